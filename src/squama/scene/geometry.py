"""The beam in space: bar, scales, contact points and forces, in pitches; ``js/geometry.js`` has the same functions.

Axes: z along the beam, y out of the scaled face, as in docs, theory: geometry. The middle of the beam stays where it
is, or the section ``still`` pitches from it. A design is what :func:`squama.scene.motion.shape` returns; ``S`` maps the
scaled face's places to those of its face, which sees the bend ``d["bend"]`` times and the twist in the sense
``d["sense"]`` (:mod:`squama.beam.faces`). Loads are angles per pitch, or all strains per pitch: bend, twist, lateral
bend (rad) and stretch; of a beam with ends the strains of each cell, in the middle of which its scale stands.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple, TypedDict, TypeGuard, cast

import numpy as np

from squama.fe.plate import axes, rotation, translation
from squama.loads import LOADS
from squama.types import Array


class Face(TypedDict):
    """What places the scales of a face."""

    S: Sequence[float]
    bend: float
    shift: float


class Design(Face):
    """A design: ratios (lengths in pitches, rad), kind of load, sense, law."""

    kind: str
    held: float
    eta: float
    beta: float
    lam: float
    height: float
    alpha: float
    half: float
    thick: float
    sense: float
    law: str
    neighbour: int
    scales: int


class Placed(Design):
    """A design of a part, with the place of the end that stays."""

    still: float


Cells = tuple[tuple[float, ...], ...]
Load = float | Sequence[float] | Cells
Attitude = float | Sequence[Sequence[float]]
"""Attitude of a scale: its inclination on a hinge (rad), or place of its base, n_X and n_Y in the section's axes."""
STEPS = 6
"""Segments of the bar per pitch."""
PIECES = 6, 2
"""Segments of a bent plate along its length and across it."""
LONGEST = 2.6
"""Asymptotic length of an arrow for large forces, in pitches."""


class Frame(NamedTuple):
    """Axes ``x``, ``y``, ``z`` of a cross-section, and ``o``, the middle of its scaled edge."""

    o: Array
    x: Array
    y: Array
    z: Array


class Scale(NamedTuple):
    """Axes and corners of a scale: ``o`` middle of the base edge D-A, ``m`` middle of the tip edge C-B."""

    x: Array
    y: Array
    z: Array
    o: Array
    m: Array
    corners: Array


class Contact(NamedTuple):
    """Contact of tip edge and side edge: points on side edge and tip edge, coordinates ``p`` and ``s`` along them."""

    point: Array
    on_tip: Array
    p: float
    s: float


class Stand(NamedTuple):
    """How a scale stands on its cross-section, and its deflection: 24 powers (:func:`lift`), None of a flat one."""

    attitude: Attitude
    bent: Sequence[float] | None = None


def _by_cell(load: Load) -> TypeGuard[Cells]:
    return not isinstance(load, int | float) and isinstance(load[0], Sequence)


def strains(d: Design, load: float | Sequence[float]) -> Sequence[float]:
    """Return all strains per pitch; of a load angle the stretch is that of the line that keeps its length."""
    if not isinstance(load, int | float):
        return load
    psi, phi = (d["held"], d["sense"] * load) if LOADS[d["kind"]].sided else (d["bend"] * load, 0.0)
    return psi, phi, 0.0, psi * (d["lam"] - d["height"])


def _screw(own: Sequence[float], k: float) -> tuple[Array, Array]:
    """Return the turn (3, 3) and the shift (3) of a cross-section over k pitches of one cell's strains."""
    psi, phi, chi, eps = own
    w = -k * np.array([psi, chi, phi])
    return rotation(w).E, k * (1 + eps) * translation(w).E[:, 2]


@lru_cache(maxsize=16)
def _sections(cells: Cells, still: float) -> list[tuple[Array, Array]]:
    """Return turn and shift of the n + 1 sections between n cells; ``still``: what does not move, from the middle."""
    n, start = len(cells), (np.eye(3), np.array([0.0, 0.0, still]))
    out = [start] * (n + 1)
    for way in (1, -1):
        # the middle of an odd number of cells lies in one
        (R, o), place = start, n / 2 + still
        while place < n if way > 0 else place > 0:
            cell = math.floor(place) if way > 0 else math.ceil(place) - 1
            end = cell + 1 if way > 0 else cell
            turn, shift = _screw(cells[cell], end - place)
            R, o, place = R @ turn, o + R @ shift, end
            out[end] = R, o
    return out


def frame(d: Design, load: Load, k: float) -> Frame:
    """Return the cross-section ``k`` pitches from the middle of the beam: moved by k times the screw of its strains."""
    if _by_cell(load):
        place = k + len(load) / 2
        cell = min(max(math.floor(place), 0), len(load) - 1)
        R, o = _sections(load, d.get("still", 0.0))[cell]
        turn, shift = _screw(load[cell], place - cell)
        turn, shift = R @ turn, o + R @ shift
    else:
        turn, shift = _screw(strains(d, cast("float | Sequence[float]", load)), k)
    x, y, z = turn.T
    return Frame(d["lam"] * y + shift, x, y, z)


def scale(d: Design, load: Load, theta: Attitude, k: float) -> Scale:
    """Return the scale ``k`` pitches from the beam's middle; corners D, A, B, C as rows."""
    f = frame(d, load, k)
    section = np.array([f.x, f.y, f.z])
    own = [(0.0, 0.0, 0.0), *axes(d["alpha"], theta)[:2]] if isinstance(theta, int | float) else theta
    moved, x, y = np.asarray(own) @ section * d["S"]
    o = f.o * d["S"] + moved
    m, half = o + d["eta"] * x, d["beta"] * y
    return Scale(x, y, np.prod(d["S"]) * np.cross(x, y), o, m, np.array([o - half, o + half, m + half, m - half]))


def contact(
    d: Design, load: Load, theta: Attitude, k: float, bent: Sequence[float] | None = None, beside: Stand | None = None
) -> Contact:
    """Return the contact of scale ``k``'s tip with its neighbour, as the common normal of the two edges.

    ``beside``: attitude and deflection of the neighbour, by default those of the scale. Edges are those of the flat
    middle surfaces; ``point`` lies on the surface of the thick, ``bent`` plate. In bending the tip's corner B meets the
    neighbour's face (where edges lie across the beam the tip edge does, and its middle stands for it); ``s`` and ``p``
    are its place along and across the face.
    """
    beside = beside or Stand(theta, bent)
    one, two = scale(d, load, theta, k), scale(d, load, beside.attitude, k + d["neighbour"])
    if not LOADS[d["kind"]].sided:
        x, y = np.array([d["eta"]]), np.array([d["beta"] if d["alpha"] else 0.0])
        point = one.m + y * one.y + (_lifted(d, bent, x, y) - d["thick"] / 2) * one.z
        return Contact(point, point, float((point - two.o) @ two.y), float((point - two.o) @ two.x))
    corner = two.corners[0 if d["sense"] > 0 else 1]
    normal = np.cross(one.y, two.x)
    away, size = corner - one.m, float(normal @ normal)
    p = float(np.cross(away, two.x) @ normal) / size
    s = float(np.cross(away, one.y) @ normal) / size
    x, y = np.array([s]), np.array([-d["sense"] * d["beta"]])
    point = corner + s * two.x + (_lifted(d, beside.bent, x, y) + d["thick"] / 2) * two.z
    return Contact(point, one.m + p * one.y, d["sense"] * p, s)


def _lifted(d: Design, bent: Sequence[float] | None, x: Array, y: Array) -> Array:
    return lift(d, bent, x, y) if bent else np.zeros_like(x)


def directions(
    d: Design, load: Load, theta: Attitude, slip: tuple[float, float], k: float, beside: Stand | None = None
) -> tuple[Array, Array]:
    """Return the unit vectors of the normal and the friction force on scale ``k`` where it rests on its neighbour.

    ``beside``: attitude and deflection of the neighbour, by default those of the scale. ``slip`` are the sliding rates
    along the side edge and along the tip edge, in bending along and across the face. By the plate law the normal is the
    plate's and friction lies in the plate (docs, theory: forces).
    """
    other = beside.attitude if beside else theta
    one, two = scale(d, load, theta, k), scale(d, load, other, k + d["neighbour"])
    sided = LOADS[d["kind"]].sided
    n, t = two.z, slip[0] * two.x + slip[1] * (d["sense"] * one.y if sided else two.y)
    if d["law"] == "plate":
        t = t - (t @ n) * n
    elif sided:
        n = np.prod(d["S"]) * np.cross(two.x, one.y)
        n = n / np.linalg.norm(n)
    size = float(np.linalg.norm(t))
    return n, t / size if size else t


class Plate(NamedTuple):
    """A scale as a body in its own axes, in pitches: points (n, 3), faces (m, 4) and edges (e, 2) by point index."""

    points: Array
    faces: Array
    edges: Array

    def at(self, one: Scale) -> Array:
        """Return the points (n, 3) in space."""
        return np.asarray(one.o + self.points @ np.array([one.x, one.y, one.z]))


def lift(d: Design, bent: Sequence[float], x: Array, y: Array) -> Array:
    """Return the deflection of a bent plate from its flat middle surface at coordinates x, y, all in pitches.

    ``bent``: 24 coefficients of X^2 X^i Y^j by i (6) and j (4), for shares X of the length and Y of the half width.
    """
    X, Y = np.asarray(x / d["eta"]), np.asarray(y / d["beta"])
    return np.asarray(X**2 * np.polynomial.polynomial.polyval2d(X, Y, np.reshape(bent, (6, 4))))


def plate(d: Design, bent: Sequence[float] | None) -> Plate:
    """Return the body of a scale: a thin scale is a surface, a bent one has :data:`PIECES` segments."""
    n, m = PIECES if bent else (1, 1)
    x, y = (v.ravel() for v in np.meshgrid(np.linspace(0, d["eta"], n + 1), d["beta"] * np.linspace(-1, 1, m + 1)))
    middle = np.column_stack([x, y, _lifted(d, bent, x, y)])
    number = np.arange(x.size).reshape(m + 1, n + 1)
    quads = np.stack([number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1]], axis=-1).reshape(-1, 4)
    rim = np.concatenate([number[0], number[1:, -1], number[-1, -2::-1], number[-2:0:-1, 0]])
    edges = np.column_stack([rim, np.roll(rim, -1)])
    if not d["thick"]:
        return Plate(middle, quads, edges)
    half, up = np.array([0.0, 0.0, d["thick"] / 2]), x.size
    sides = np.column_stack([edges, edges[:, ::-1] + up])
    corners = number[[0, 0, -1, -1], [0, -1, -1, 0]]
    return Plate(
        np.concatenate([middle - half, middle + half]),
        np.concatenate([quads, quads + up, sides]),
        np.concatenate([edges, edges + up, np.column_stack([corners, corners + up])]),
    )


def arrow(x: float) -> float:
    """Return the length (pitches) of the arrow of a force ``x`` (without unit): it grows and stays below `LONGEST`."""
    return LONGEST * x / (1 + x)


def bar(d: Design, load: Load) -> tuple[Array, Array]:
    """Return the corners (n, 4, 3) of the bar's cross-sections, and their positions along it in pitches (n,).

    The corners of a section are at (-w, 0), (w, 0), (w, -2 lambda), (-w, -2 lambda) from the middle of its scaled edge.
    """
    ends = d["scales"] / 2
    places = np.linspace(-ends, ends, STEPS * d["scales"] + 1)
    frames = (frame(d, load, float(place)) for place in places)
    corners = [(across * d["half"], 2 * d["lam"] * depth) for across, depth in ((-1, 0), (1, 0), (1, 1), (-1, 1))]
    return np.array([[f.o + across * f.x - depth * f.y for across, depth in corners] for f in frames]), places


def first(d: Design) -> float:
    """Return the position of the first scale in pitches; the others follow at distances of one pitch."""
    return -(int(d["scales"]) - 1) / 2 + float(d["shift"])

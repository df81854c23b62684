"""The beam in space: bar, scales, contact points and forces, in pitches; ``js/geometry.js`` states the same.

Axes: z along the beam, y out of the scaled face, as in docs, theory: geometry. The middle of the beam stays where it
is. A design is what :func:`squama.scene.motion.shape` returns; ``S`` maps the scaled face's places to those of its
face, which sees the bend ``d["bend"]`` times and the twist in the sense ``d["sense"]`` (:mod:`squama.beam.faces`).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from squama.fe.plate import axes
from squama.loads import LOADS
from squama.model.screw import Screw
from squama.types import Array

Design = Mapping[str, Any]
Attitude = float | Sequence[Sequence[float]]
"""How a scale stands: its inclination on a hinge, or place of its base, n_X and n_Y in the cross-section's axes."""
STEPS = 6
"""Pieces of the bar per pitch."""
LONGEST = 1.6
"""Length that an arrow comes near to as its force grows, in pitches."""


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
    """Where tip edge and side edge meet: point on the side edge, point on the tip edge, places ``p`` and ``s``."""

    point: Array
    on_tip: Array
    p: float
    s: float


def frame(d: Design, load: float, k: float) -> Frame:
    """Return the cross-section ``k`` pitches from the middle of the beam at a load angle per pitch.

    It is moved by k times the screw of bend and twist, about the line that keeps its length; in twisting with the bend
    that is held.
    """
    psi, phi = (d["held"], d["sense"] * load) if LOADS[d["kind"]].sided else (d["bend"] * load, 0.0)
    g = Screw.of(np.asarray(k * psi), np.asarray(k * phi), np.asarray(0.0))
    g = g._replace(v=np.array([0.0, 0.0, k * (1 + psi * (d["lam"] - d["height"]))]))
    x, y, z = (g.turned(axis) for axis in np.eye(3))
    return Frame(d["lam"] * y + g.shift, x, y, z)


def scale(d: Design, load: float, theta: Attitude, k: float) -> Scale:
    """Return the scale ``k`` pitches from the middle; corners D, A, B, C as rows."""
    f = frame(d, load, k)
    section = np.array([f.x, f.y, f.z])
    own = [(0.0, 0.0, 0.0), *axes(d["alpha"], theta)[:2]] if isinstance(theta, int | float) else theta
    moved, x, y = np.asarray(own) @ section * d["S"]
    o = f.o * d["S"] + moved
    m, half = o + d["eta"] * x, d["beta"] * y
    return Scale(x, y, np.prod(d["S"]) * np.cross(x, y), o, m, np.array([o - half, o + half, m + half, m - half]))


def contact(d: Design, load: float, theta: Attitude, k: float) -> Contact:
    """Return the contact of scale ``k``'s tip with its neighbour, as the common normal of the two edges.

    In bending the tip's corner B meets the neighbour's face (where edges lie across the beam the tip edge does, and its
    middle stands for it); ``s`` and ``p`` are its place along and across the face.
    """
    one, two = scale(d, load, theta, k), scale(d, load, theta, k + d["neighbour"])
    if not LOADS[d["kind"]].sided:
        point = one.corners[2] if d["alpha"] else one.m
        return Contact(point, point, float((point - two.o) @ two.y), float((point - two.o) @ two.x))
    corner = two.corners[0 if d["sense"] > 0 else 1]
    normal = np.cross(one.y, two.x)
    away, size = corner - one.m, float(normal @ normal)
    p = float(np.cross(away, two.x) @ normal) / size
    s = float(np.cross(away, one.y) @ normal) / size
    return Contact(corner + s * two.x, one.m + p * one.y, d["sense"] * p, s)


def directions(d: Design, load: float, theta: Attitude, slip: tuple[float, float], k: float) -> tuple[Array, Array]:
    """Return the unit vectors of the normal and the friction force on scale ``k`` where it rests on its neighbour.

    ``slip`` are the sliding rates along the side edge and along the tip edge, in bending along and across the face. By
    the plate law the normal is the plate's and friction lies in the plate (docs, theory: forces).
    """
    one, two = scale(d, load, theta, k), scale(d, load, theta, k + d["neighbour"])
    sided = LOADS[d["kind"]].sided
    n, t = two.z, slip[0] * two.x + slip[1] * (d["sense"] * one.y if sided else two.y)
    if d["law"] == "plate":
        t = t - (t @ n) * n
    elif sided:
        n = np.prod(d["S"]) * np.cross(two.x, one.y)
        n = n / np.linalg.norm(n)
    size = float(np.linalg.norm(t))
    return n, t / size if size else t


def arrow(x: float) -> float:
    """Return the length of the arrow of a force ``x`` in units of its own: it grows and stays below `LONGEST`."""
    return LONGEST * x / (1 + x)


def bar(d: Design, load: float) -> tuple[Array, Array]:
    """Return the vertices (n, 4, 3) of the bar's cross-sections, and their places along it in pitches (n).

    The corners of a section are at (-w, 0), (w, 0), (w, -2 lambda), (-w, -2 lambda) from the middle of its scaled edge.
    """
    ends = d["scales"] / 2
    places = np.linspace(-ends, ends, STEPS * d["scales"] + 1)
    frames = (frame(d, load, float(place)) for place in places)
    corners = [(across * d["half"], 2 * d["lam"] * depth) for across, depth in ((-1, 0), (1, 0), (1, 1), (-1, 1))]
    return np.array([[f.o + across * f.x - depth * f.y for across, depth in corners] for f in frames]), places


def first(d: Design) -> float:
    """Place of the first scale; the others follow at distances of one pitch."""
    return -(int(d["scales"]) - 1) / 2 + float(d["shift"])

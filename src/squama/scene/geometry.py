"""The beam in space: bar, scales, contact points and forces, in pitches; ``js/geometry.js`` states the same.

Axes: z along the beam, y out of the scaled face, as in docs, theory: geometry. The middle of the beam stays where it
is. A design is what :func:`squama.scene.motion.shape` returns.
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

    It is moved by k times the screw of bend and twist: in twisting with the bend that is held (``held``) about the
    bar's middle, in bending alone about its scaled face, which keeps its length.
    """
    psi, phi, height = (d.get("held", 0.0), d["sense"] * load, 0.0) if LOADS[d["kind"]].sided else (load, 0.0, d["lam"])
    g = Screw.of(np.asarray(k * psi), np.asarray(k * phi), np.asarray(0.0))
    g = g._replace(v=np.array([0.0, 0.0, k * (1 + psi * height)]))
    x, y, z = (g.turned(axis) for axis in np.eye(3))
    return Frame(d["lam"] * y + g.shift, x, y, z)


def scale(d: Design, load: float, theta: Attitude, k: float) -> Scale:
    """Return the scale ``k`` pitches from the middle; corners D, A, B, C as rows."""
    f = frame(d, load, k)
    section = np.array([f.x, f.y, f.z])
    own = [(0.0, 0.0, 0.0), *axes(d["alpha"], theta)[:2]] if isinstance(theta, int | float) else theta
    moved, x, y = np.asarray(own) @ section
    o = f.o + moved
    m, half = o + d["eta"] * x, d["beta"] * y
    return Scale(x, y, np.cross(x, y), o, m, np.array([o - half, o + half, m + half, m - half]))


def contact(d: Design, load: float, theta: Attitude, k: float) -> Contact:
    """Return the contact of scale ``k``'s tip with its neighbour, as the common normal of the two edges.

    In bending the tip's middle meets the neighbour's face, and ``s`` is its distance from the base.
    """
    one, two = scale(d, load, theta, k), scale(d, load, theta, k + d["neighbour"])
    if not LOADS[d["kind"]].sided:
        return Contact(one.m, one.m, 0.0, float((one.m - two.o) @ two.x))
    corner = two.corners[0 if d["sense"] > 0 else 1]
    normal = np.cross(one.y, two.x)
    away, size = corner - one.m, float(normal @ normal)
    p = float(np.cross(away, two.x) @ normal) / size
    s = float(np.cross(away, one.y) @ normal) / size
    return Contact(corner + s * two.x, one.m + p * one.y, d["sense"] * p, s)


def directions(d: Design, load: float, theta: Attitude, slip: tuple[float, float], k: float) -> tuple[Array, Array]:
    """Return the unit vectors of the normal and the friction force on scale ``k`` where it rests on its neighbour.

    ``slip`` are the sliding rates along the side edge and along the tip edge. By the plate law the normal is the
    plate's and friction lies in the plate (docs, theory: forces).
    """
    one, two = scale(d, load, theta, k), scale(d, load, theta, k + d["neighbour"])
    n, t = two.z, slip[0] * two.x + d["sense"] * slip[1] * one.y
    if d["law"] == "plate":
        t = t - (t @ n) * n
    elif LOADS[d["kind"]].sided:
        n = np.cross(two.x, one.y)
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
    sections = np.empty((places.size, 4, 3))
    for i, place in enumerate(places):
        f = frame(d, load, float(place))
        for j, (across, depth) in enumerate(((-1, 0), (1, 0), (1, 1), (-1, 1))):
            sections[i, j] = f.o + across * d["half"] * f.x - 2 * d["lam"] * depth * f.y
    return sections, places


def first(d: Design) -> float:
    """Place of the first scale; the others follow at distances of one pitch."""
    return -(int(d["scales"]) - 1) / 2

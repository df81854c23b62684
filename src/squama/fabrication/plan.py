"""The plan of a beam's solids, in mm and rad: from a beam and the workshop's sizes to the places of the plates.

z runs along the bar from its end, y out of the scaled face from the bar's middle, x across. Scale k = 0, 1, .. has its
base midpoint at O = (0, lambda, ends + (k + 1/2) d) and the axes (theory, section 2)
    n_X = (-sin a cos th, sin th, cos a cos th)    n_Y = (cos a, 0, sin a)    n_Z = n_X x n_Y.
It fills -L <= X <= l, |Y| <= b, |Z| <= t_s/2. Its slot is larger by the clearance on every side and open at the face.
Scales of the other face follow in the count; S and the shift of :mod:`squama.beam.faces` give their places.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping
from math import cos, sin, tan
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from squama import arguments
from squama.beam.faces import FACES
from squama.errors import Problems
from squama.fe import plate
from squama.types import Array
from squama.units import Bounds, Dimension, bounded

if TYPE_CHECKING:
    from squama.beam.design import Beam

MOST_SCALES = 500

_SIZE = Bounds(0.0, 10.0, "0 or more, up to 10 m", closed=True)
_THICK = Bounds(1e-6, 10.0, "0.001 mm to 10 m", closed=True)
SIZES: dict[str, tuple[Dimension, Bounds]] = {
    "clearance": (Dimension.LENGTH, _SIZE._replace(example="0.2 mm")),
    "feature": (Dimension.LENGTH, _THICK._replace(example="0.4 mm")),
    "wall": (Dimension.LENGTH, _THICK._replace(example="3 mm")),
    "ends": (Dimension.LENGTH, _SIZE._replace(example="30 mm")),
    "draft": (Dimension.ANGLE, Bounds(0.0, math.radians(20), "0 to 20 deg", closed=True, example="1 deg")),
    "bed": (Dimension.LENGTH, _THICK._replace(example="220 mm")),
}
"""Sizes of the workshop: dimension, bounds and example of each."""
HANDLE = 12.0
"""Length of a blade's head, mm."""


class Plan(NamedTuple):
    """Sizes of a beam's solids; lengths in mm, angles in rad.

    ``width`` and ``height`` of the bar, ``pitch``, number of ``scales``; a scale's exposed ``length``, ``embedded``
    length, full ``breadth``, ``thickness``, ``alpha`` and ``theta0``; ``ends``: plain lengths of the bar before and
    behind its pitches; ``clearance`` per side; ``feature``: least size that can be printed; ``wall`` of the mould;
    ``draft`` of its sides; ``bed``: longest part that can be printed, or None; ``faces`` with scales, as of a beam.
    """

    width: float
    height: float
    pitch: float
    scales: int
    length: float
    embedded: float
    breadth: float
    thickness: float
    alpha: float
    theta0: float
    ends: float = 30.0
    clearance: float = 0.2
    feature: float = 0.4
    wall: float = 3.0
    draft: float = 0.0
    bed: float | None = None
    faces: str = "one"

    @property
    def sides(self) -> list[tuple[Array, float]]:
        """For each face with scales: the signs S that map the scaled face's directions to its own, the shift in mm."""
        other = FACES[self.faces]
        own = [(np.ones(3), 0.0)]
        return [*own, (np.array(other.S, float), other.shift * self.pitch)] if other else own

    @property
    def pieces(self) -> int:
        """Number of scales of all faces."""
        return self.scales * len(self.sides)

    def stands(self, i: int) -> tuple[Array, Array]:
        """Return axes (rows, right-handed) and base midpoint (mm) of scale i of all faces."""
        face, k = divmod(i, self.scales)
        S, shift = self.sides[face]
        x, y, _ = self.axes * S
        return np.array([x, y, np.cross(x, y)]), self.base(k) * S + [0.0, 0.0, shift]

    @property
    def axes(self) -> Array:
        """Axes n_X, n_Y, n_Z of the scales, as rows."""
        return plate.axes(self.alpha, self.theta0)

    @property
    def total(self) -> float:
        """Length of the bar with its ends, mm."""
        return self.scales * self.pitch + 2 * self.ends

    def base(self, k: int) -> Array:
        """Return the base midpoint of scale k, mm."""
        return np.array([0.0, self.height / 2, self.ends + (k + 0.5) * self.pitch])

    @property
    def step(self) -> Array:
        """Vector from a scale to the next one, in the scales' own axes, mm."""
        return np.asarray(self.axes @ [0.0, 0.0, self.pitch])

    @property
    def slope(self) -> float:
        """Lift of a scale over the next one per length of the bar, sin(theta0) cos(alpha)."""
        return sin(self.theta0) * cos(self.alpha)

    @property
    def slot(self) -> tuple[float, float, float]:
        """Length L + c, width 2 (b + c) and thickness t_s + 2 c of a slot below the face along the scale's axes."""
        c = self.clearance
        return self.embedded + c, self.breadth + 2 * c, self.thickness + 2 * c

    @property
    def slot_profile(self) -> Array:
        """Corners (4, 2) of the slot in the plane of X and Z; the face is X sin(theta0) + Z cos(theta0) = 0."""
        deep, _, t = self.slot
        out = t / 2 / tan(self.theta0)
        return np.array([(-deep, -t / 2), (out, -t / 2), (-out, t / 2), (-deep, t / 2)])

    @property
    def slit(self) -> tuple[float, float]:
        """Width and thickness of the lid's slits: those of a blade plus the clearance on every side."""
        _, across, t = self.slot
        return across + 2 * self.clearance, t + 2 * self.clearance

    @property
    def slit_profile(self) -> Array:
        """Corners (4, 2) of a slit of the lid in the plane of X and Z."""
        half = self.slit[1] / 2
        out, up = half / tan(self.theta0), self.wall / sin(self.theta0)
        return np.array([(out, -half), (out + up, -half), (-out + up, half), (-out, half)])

    @property
    def shank(self) -> float:
        """Length from the scale's base to the head of a blade, whose lower edge rests on the lid, mm."""
        return (self.wall + self.slot[2] / 2 * cos(self.theta0)) / sin(self.theta0)

    @property
    def blade(self) -> tuple[float, float, float]:
        """Length, width at the head, and thickness of a blade, mm."""
        deep, across, t = self.slot
        return deep + self.shank + HANDLE, across + 2 * self.wall, t

    def corners(self, profile: Array, across: float) -> Array:
        """Return the corners of the prism over a profile in X and Z, |Y| <= across/2, of the first scale."""
        local = [(x, y, z) for (x, z), y in itertools.product(profile, (-across / 2, across / 2))]
        return np.asarray(np.array(local) @ self.axes + self.base(0))


def read(given: Mapping[str, object], prefix: str = "", *, bare: bool = True) -> dict[str, float]:
    """Return sizes (m, rad) by name, or refuse all mistakes; ``prefix`` of the names in messages."""
    found, problems = {}, Problems()
    for name, value in given.items():
        dimension, bounds = SIZES[name]
        with problems.caught(prefix + name):
            found[name] = bounded(value, dimension, bounds, bare=bare)
    problems.settle()
    return found


def plan(beam: Beam, scales: int | None, sizes: dict[str, float]) -> Plan:
    """Return the plan of a beam with ``scales`` scales (None: its own number, at most 500); sizes in m and rad."""
    count = arguments.whole("scales", beam.pitches if scales is None else scales, 1, MOST_SCALES)
    lengths = {name: value if SIZES[name][0] is Dimension.ANGLE else mm(value) for name, value in sizes.items()}
    bar, one = beam.substrate, beam.scale
    across = mm(bar.width), mm(bar.thickness), mm(beam.pitch)
    plate_sizes = mm(one.length), mm(one.embedded), mm(one.width), mm(one.thickness)
    return Plan(*across, count, *plate_sizes, one.alpha, one.theta0, **lengths, faces=beam.faces)


def mm(length: float) -> float:
    """Return a length in m as mm, without the rounding error of the conversion."""
    return float(f"{length * 1e3:.14g}")


def apart(a: Array, b: Array) -> float:
    """Return the distance of two convex polygons (n, 2) in the plane; 0 if they meet.

    >>> square = np.array([(0, 0), (1, 0), (1, 1), (0, 1.0)])
    >>> apart(square, square + [4, 5])
    5.0
    """
    separated, least = False, np.inf
    for polygon, points in ((a, b), (b, a)):
        edge, away = np.roll(polygon, -1, axis=0) - polygon, points[:, None] - polygon
        normals = np.stack([edge[:, 1], -edge[:, 0]], axis=1)
        own, other = normals @ polygon.T, normals @ points.T
        # one of the edges has all of the other polygon on its outer side
        separated |= bool(((other.min(1) >= own.max(1)) | (other.max(1) <= own.min(1))).any())
        along = np.clip((away * edge).sum(-1) / (edge**2).sum(-1), 0, 1)
        least = min(least, float(np.linalg.norm(away - along[..., None] * edge, axis=-1).min()))
    return least if separated else 0.0


def between(plan: Plan, profile: Array, across: float) -> float:
    """Return the distance, mm, between the prisms over a profile of a scale and of the next scale; 0 if they meet."""
    x, y, z = plan.step
    return float(np.hypot(apart(profile, profile + np.array([x, z])), max(0.0, abs(y) - across)))

"""A way through bend and twist, the analysis of a beam along it, and what a model gives: states, or a curve."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import NamedTuple, Protocol

import numpy as np

from squama.beam.design import Beam
from squama.loads import ENDLESS, LOADS, Load
from squama.people import per_pitch
from squama.types import Array

VERBS = tuple(load.verb for load in sorted(LOADS.values(), key=lambda load: load.axis))
"""Strains that may be loaded: bend and twist."""
OPEN, SLIDING = "open", "sliding"
"""What a beam is called at a bend and a twist to which nothing ends the way."""


class Way(NamedTuple):
    """Bend and twist per pitch (psi, phi) to go to one after the other, from rest; rad, signed.

    An infinite one is the end of the curve in that sense. ``typed``: the words in which load angles were given;
    ``loaded``: the strains that the way names, others are free unless the beam's ``hold`` names them. ``free``: the
    axis of the load that hinges leave free, as of :func:`squama.bend_twist`.
    """

    corners: tuple[tuple[float, float], ...]
    typed: Mapping[float, str] = {}
    loaded: tuple[str, ...] = VERBS
    free: int | None = None

    @classmethod
    def of(cls, load: str, values: Sequence[float], typed: Mapping[float, str] = {}) -> Way:
        """Return the way along one load."""
        kind = LOADS[load]
        return cls(tuple((0.0, v) if kind.axis else (v, 0.0) for v in map(float, values)), typed, (kind.verb,))

    def said(self, value: float) -> str:
        """Return a load angle as it was typed, and per pitch."""
        angle = per_pitch(value, 6)
        text = self.typed.get(value, angle)
        return angle if text == angle else f'"{text}" ({angle})'

    @property
    def load(self) -> Load:
        """The one load that changes along the way; twisting if none does, or both do."""
        used = [load for load in LOADS.values() if any(corner[load.axis] for corner in self.corners)]
        return used[0] if len(used) == 1 else LOADS["twisting"]

    @property
    def values(self) -> list[float]:
        """Load angles along the way."""
        axis = self.load.axis
        return [corner[axis] for corner in self.corners]

    @property
    def sense(self) -> str:
        """Sense in which the way sets out."""
        return "-" if self.sign < 0 else "+"

    @property
    def sign(self) -> int:
        """The same as a number, 1 or -1."""
        return -1 if next((v for v in self.values if v), 0.0) < 0 else 1


class Stations(NamedTuple):
    """Points of a way: lengths from rest (n,), bend and twist per pitch there (n, 2), legs (n,), counted from 1."""

    ways: Array
    strains: Array
    legs: Array

    @classmethod
    def of(cls, corners: Sequence[tuple[float, float]], count: int, engaged: float) -> Stations:
        """Return ``count`` points of each leg, one of them at the length ``engaged``."""
        start, parts = 0.0, []
        for i, (a, b) in enumerate(pairwise(np.array([(0.0, 0.0), *corners]))):
            length = float(np.hypot(*(b - a)))
            w = np.linspace(0, 1, count)
            if start < engaged < start + length:
                w[1 + np.abs(w[1:-1] * length + start - engaged).argmin()] = (engaged - start) / length
            one = cls(start + w * length, a + w[:, None] * (b - a), np.full(w.size, i + 1))
            parts.append(one if not i else cls(*(v[1:] for v in one)))
            start += length
        return cls(*map(np.concatenate, zip(*parts, strict=True)))

    @classmethod
    def along(cls, load: Load, x: Array, legs: Array | int = 1) -> Stations:
        """Return stations at values of one load from 0 on, the other one imposed as 0 or free."""
        strains = np.zeros((x.size, 2))
        strains[:, load.axis] = x
        return cls(np.cumsum(np.abs(np.diff(x, prepend=0.0))), strains, np.broadcast_to(legs, x.size))

    @property
    def turns(self) -> list[int]:
        """Numbers of the points at which the way sets out, turns and ends."""
        return [0, *np.flatnonzero(np.diff(self.legs)).tolist(), self.legs.size - 1]

    @property
    def loads(self) -> Array:
        """Values of the one load (n,) of a way along which there is no other."""
        return np.asarray(self.strains.sum(axis=1))


def direction(load: Load, value: float) -> tuple[float, float]:
    """Return a load's direction in the plane of bend and twist, in the sense of a value."""
    sign = math.copysign(1.0, value)
    return (0.0, sign) if load.axis else (sign, 0.0)


def spaced(stop: float, points: int, engaged: float) -> Array:
    """Return evenly spaced loads from 0 to an end, with engagement in the place of the nearest one between the two."""
    at = np.linspace(0.0, stop, points)
    if 0 < engaged < stop:
        at[1 + np.abs(at[1:-1] - engaged).argmin()] = engaged
    return at


class Analysis(NamedTuple):
    """A beam, the way that it goes, and the model that answers.

    ``mus`` coefficients of friction, ``points`` of a curve (of each leg of a history), ``at`` load angles per pitch
    (magnitudes) at which a curve is wanted instead; ``ideal``: thin, rigid scales; ``note``: a warning that goes along;
    ``joint``: the model (:data:`squama.curves.chosen.MODELS`); ``ends`` of the beam, of :data:`squama.loads.ENDS`.
    """

    beam: Beam
    way: Way
    mus: Array
    law: str
    margin: float
    points: int
    at: Array | None = None
    ideal: bool = False
    note: str = ""
    joint: str = "hinge"
    ends: str = ENDLESS


class Case(NamedTuple):
    """What a kind of loading brings: pitch, rigidity without contact (N m^2), joint stiffness (N m), sense."""

    pitch: float
    rigidity: float
    stiffness: float
    eta: float
    theta0: float
    mirrored: bool = False

    @classmethod
    def of(cls, beam: Beam, load: str, sense: str = "+") -> Case:
        """Return the case of a beam."""
        kind = LOADS[load]
        return cls(beam.pitch, kind.rigidity(beam), beam.joint_stiffness, beam.eta, beam.scale.theta0, sense == "-")


class Curve(NamedTuple):
    """Variables along a curve (``along``) and single figures of it (``figures``), by role (:mod:`squama.loads`).

    ``each``: those of each of N scales (points, N); ``notes``: where the curve leaves what the model was compared with.
    """

    along: dict[str, Array]
    figures: dict[str, float | int | str]
    each: Mapping[str, Array] = {}
    notes: tuple[str, ...] = ()


class Solved(Protocol):
    """A beam's path in one sense with one coefficient of friction, solved; what every model gives."""

    @property
    def case(self) -> Case:
        """What the beam and the model bring."""

    @property
    def load_e(self) -> float:
        """Load angle per pitch (a magnitude) at engagement, inf for none."""

    def curve(self, *, points: int, at: Array | None = None) -> Curve:
        """Return the curve at points of the path's own, or at load angles per pitch: NaN beyond its end."""


class States(NamedTuple):
    """What a model says along a way: values by dimension and role, and what its attributes and warnings add."""

    by_dim: Mapping[tuple[str, ...], dict[str, Array]]
    attrs: Mapping[str, float | str] = {}
    notes: Sequence[str] = ()

"""A way through bend and twist, the analysis of a beam along it, and the results of a model: states, or a curve."""

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
"""Strains that can be loaded: bend and twist."""
OPEN, SLIDING = "open", "sliding"
"""States of a beam at a bend and twist that is reached."""


class Way(NamedTuple):
    """Points (psi, phi) of bend and twist per pitch, in succession from rest; rad, signed.

    An infinite value is the end of the curve in that sense. ``typed``: load angles as text, as the user typed them;
    ``loaded``: the strains that the way names, others are free unless the beam's ``hold`` names them. ``free``: the
    axis of the load that is free on hinges, as in :func:`squama.bend_twist`.
    """

    corners: tuple[tuple[float, float], ...]
    typed: Mapping[float, str] = {}
    loaded: tuple[str, ...] = VERBS
    free: int | None = None

    @classmethod
    def of(cls, load: str, values: Sequence[float], typed: Mapping[float, str] = {}) -> Way:
        """Return the way along a single load."""
        kind = LOADS[load]
        return cls(tuple((0.0, v) if kind.axis else (v, 0.0) for v in map(float, values)), typed, (kind.verb,))

    def said(self, value: float) -> str:
        """Return a load angle as it was typed, and per pitch, as text."""
        angle = per_pitch(value, 6)
        text = self.typed.get(value, angle)
        return angle if text == angle else f'"{text}" ({angle})'

    @property
    def load(self) -> Load:
        """The single load that changes along the way; twisting if none or both do."""
        used = [load for load in LOADS.values() if any(corner[load.axis] for corner in self.corners)]
        return used[0] if len(used) == 1 else LOADS["twisting"]

    @property
    def values(self) -> list[float]:
        """Load angles along the way."""
        axis = self.load.axis
        return [corner[axis] for corner in self.corners]

    @property
    def sense(self) -> str:
        """Sense in which the way begins."""
        return "-" if self.sign < 0 else "+"

    @property
    def sign(self) -> int:
        """Sense in which the way begins, as 1 or -1."""
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
        """Return stations at values of one load from 0 on; the other load is imposed as 0, or free."""
        strains = np.zeros((x.size, 2))
        strains[:, load.axis] = x
        return cls(np.cumsum(np.abs(np.diff(x, prepend=0.0))), strains, np.broadcast_to(legs, x.size))

    @property
    def turns(self) -> list[int]:
        """Indices of the points at which the way begins, turns and ends."""
        return [0, *np.flatnonzero(np.diff(self.legs)).tolist(), self.legs.size - 1]

    @property
    def loads(self) -> Array:
        """Values (n,) of the load along a way with a single load."""
        return np.asarray(self.strains.sum(axis=1))


def direction(load: Load, value: float) -> tuple[float, float]:
    """Return a load's direction in the plane of bend and twist, with the sign of a value."""
    sign = math.copysign(1.0, value)
    return (0.0, sign) if load.axis else (sign, 0.0)


def spaced(stop: float, points: int, engaged: float) -> Array:
    """Return evenly spaced loads from 0 to ``stop``; the nearest one is replaced by the load of engagement."""
    at = np.linspace(0.0, stop, points)
    if 0 < engaged < stop:
        at[1 + np.abs(at[1:-1] - engaged).argmin()] = engaged
    return at


class Analysis(NamedTuple):
    """A beam, its way, and the model.

    ``mus`` coefficients of friction, ``points`` of a curve (of each leg of a history), ``at`` load angles per pitch
    (magnitudes) in place of points; ``ideal``: thin, rigid scales; ``note``: a warning for the result; ``joint``: the
    model (:data:`squama.curves.chosen.MODELS`); ``ends`` of the beam, of :data:`squama.loads.ENDS`.
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
    """Data of a beam under a load: pitch, rigidity without contact (N m^2), joint stiffness (N m), ratios, sense."""

    pitch: float
    rigidity: float
    stiffness: float
    eta: float
    theta0: float
    mirrored: bool = False

    @classmethod
    def of(cls, beam: Beam, load: str, sense: str = "+") -> Case:
        """Return the data of a beam with hinges."""
        kind = LOADS[load]
        return cls(beam.pitch, kind.rigidity(beam), beam.joint_stiffness, beam.eta, beam.scale.theta0, sense == "-")


class Curve(NamedTuple):
    """Variables along a curve (``along``) and its single values (``figures``), by role (:mod:`squama.loads`).

    ``each``: variables of each of N scales (points, N); ``notes``: where the curve leaves the range in which the model
    was compared.
    """

    along: dict[str, Array]
    figures: dict[str, float | int | str]
    each: Mapping[str, Array] = {}
    notes: tuple[str, ...] = ()


class Solved(Protocol):
    """Interface of a solved path of a beam in one sense with one coefficient of friction, common to all models."""

    @property
    def case(self) -> Case:
        """Data of the beam under the load."""

    @property
    def load_e(self) -> float:
        """Load angle per pitch (a magnitude) at engagement, inf for none."""

    def curve(self, *, points: int, at: Array | None = None) -> Curve:
        """Return the curve at evenly distributed points, or at load angles per pitch; NaN beyond its end."""


class States(NamedTuple):
    """Results of a model along a way: values by dimension and role, further attributes and warnings."""

    by_dim: Mapping[tuple[str, ...], dict[str, Array]]
    attrs: Mapping[str, float | str] = {}
    notes: Sequence[str] = ()

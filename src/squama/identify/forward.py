r"""The model's torque at measured twists as a function of what is to be found, with its derivatives.

The inclination at a given twist is geometry alone: neither friction, joint stiffness, rigidity nor the inclination at
rest enter the contact condition (paper Eq. 6). So each measured twist is put on the path of the contact once, and with
the rates and moments there (docs, theory: cycles) every trial is the closed form

.. math::
    T = R\,\Phi + T_0 + K_\theta\,\langle\theta-\theta_0\rangle
        \Bigl[\frac{\theta'}{\varphi'} + m\,\frac{r'}{\varphi'}\,\frac{1}{D(m)}\Bigr],
    \qquad D(m) = -(M_N + m M_f), \qquad m = \pm\mu ,

with m = mu while the scales are loaded, -mu while they are unloaded, and < > zero before engagement.

Towards a lock D vanishes and the torque grows without bound. So that a trial beyond a lock has a value and a slope too,
1/D is continued by its tangent where D is below a thousandth of what it is without friction: the torque of such a
trial is finite, a thousand times too large, and falls towards the lock.

On the compliant joint (:class:`Walked`) the way decides, so the record is walked for each friction that is tried. The
plates' contact is geometry and friction grows with the pressure, so that the motions do not change where the matrix of
the joint is multiplied by a factor, the rigidity R without contact being kept: T = R Phi + T_0 + K_theta g(mu) again.
"""

from __future__ import annotations

import copy
import itertools
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from squama.beam.design import Beam
from squama.curves import follow
from squama.curves.hinge import invert
from squama.curves.hinge_cycles import Senses
from squama.curves.path import Asked, LoadPath
from squama.errors import InputError
from squama.model.paths import ARRAY
from squama.types import Array

FLOOR = 1e-3
"""Part of the D without friction below which 1/D is continued by its tangent."""


class Physical(NamedTuple):
    """What the torque depends on: friction, joint stiffness (N m), rigidity (N m2), theta0 (rad), zero (N m)."""

    mu: float
    stiffness: float
    rigidity: float
    theta0: float
    zero: float = 0.0


class Forward(NamedTuple):
    """Places of n points on the paths of their contacts; arrays of length n.

    ``rate`` twist rate or curvature (signed), ``sign`` of the sense, ``way`` +1 loading, -1 unloading; ``theta``
    inclination there (0 where there is no contact whatever theta0 is), ``lift_rate`` theta'/phi', ``slip_rate``
    r'/phi', moments ``M_N``, ``M_f``.
    """

    rate: Array
    sign: Array
    way: Array
    theta: Array
    lift_rate: Array
    slip_rate: Array
    M_N: Array
    M_f: Array

    def take(self, index: Array) -> Forward:
        """Return some of the points."""
        return Forward(*(column[index] for column in self))

    def inverse(self, mu: Array | float) -> tuple[Array, Array]:
        """Return 1/D, continued beyond a lock, and its derivative to D."""
        D = -(self.M_N + self.way * mu * self.M_f)
        least = FLOOR * -self.M_N
        safe = np.maximum(D, least)
        return (2 - D / safe) / safe, -1 / safe**2

    def torque(self, v: Physical) -> Array:
        """Torque or moment (N m); the entries of ``v`` may be columns of many trials, shape (..., 1)."""
        inverse = self.inverse(v.mu)[0]
        lift = np.maximum(self.theta - v.theta0, 0.0)
        scales = lift * (self.lift_rate + self.way * v.mu * self.slip_rate * inverse)
        return np.asarray(v.rigidity * self.rate + v.zero + v.stiffness * self.sign * scales)

    def jacobian(self, v: Physical) -> Array:
        """Return the derivatives of the torque, shape (n, 5), in the order of :class:`Physical`."""
        inverse, slope = self.inverse(v.mu)
        touching = self.theta > v.theta0
        lift = np.where(touching, self.theta - v.theta0, 0.0)
        share = self.lift_rate + self.way * v.mu * self.slip_rate * inverse
        to_mu = self.way * self.slip_rate * (inverse - self.way * v.mu * slope * self.M_f)
        return np.stack(
            [
                v.stiffness * self.sign * lift * to_mu,
                self.sign * lift * share,
                self.rate,
                -v.stiffness * self.sign * touching * share,
                np.ones(self.rate.size),
            ],
            axis=1,
        )

    def locks_at(self, theta0: float) -> float:
        """Smallest friction at which one of the points that are loaded is beyond a lock; inf if there is none."""
        seen = (self.theta > theta0) & (self.M_f > 0) & (self.way > 0)
        return float(np.min(-self.M_N[seen] / self.M_f[seen], initial=np.inf))


def build(senses: Senses, load: Array, way: Array) -> Forward:
    """Put points on the paths of their contacts.

    ``senses`` are solved for the smallest friction and inclination at rest of all trials; ``load`` are load angles per
    pitch, signed, none beyond what the senses allow; ``way`` is +1 where their magnitude grew, -1 where it fell.
    """
    sign = np.where(load < 0, -1.0, 1.0)
    zero = np.zeros(load.size)
    rate, apart = load / senses.case.pitch, [zero.copy(), zero.copy(), zero.copy(), zero - 1, zero.copy()]
    out = Forward(rate, sign, way.astype(float), *apart)
    for name, side in senses.sides.items():
        path, s = senses.paths[name], -1.0 if name == "-" else 1.0
        index = np.flatnonzero((sign == s) & (np.abs(load) > path.load_e))
        if not index.size:
            continue
        x = invert(path.row, np.abs(load[index]), path.x0, path.x_c, path.law)
        pt = side.row.point(x, side.law, ARRAY)
        columns = (pt.theta, pt.theta_rate / pt.load_rate, pt.slip_rate / pt.load_rate, pt.M_N, pt.M_f)
        for target, values in zip(out[3:], columns, strict=True):
            target[index] = values
    return out


class Walked:
    """Points of records, one behind the other, on the joint whose matrix the beam has; asked as :class:`Forward` is.

    ``way`` and ``specimen`` are those of a record; ``ways`` has the load angles of each specimen, one array for each
    way between two turning points. The points are placed with the friction ``mu``; where the scales jump or lock on the
    way then, they are refused.
    """

    points = 100
    """Points of each way that are walked to; between them the torque is interpolated."""
    step = 2e-3
    """Step of the differences by friction."""

    def __init__(self, beam: Beam, load: Array, way: Array, specimen: Array, mu: float) -> None:
        ends = np.flatnonzero((np.diff(way * np.where(load < 0, -1, 1)) != 0) | (np.diff(specimen) != 0)) + 1
        pieces = np.split(np.arange(load.size), ends)
        self.ways = [[load[i] for i in pieces if specimen[i[0]] == n] for n in dict.fromkeys(specimen.tolist())]
        self.beam, self.load, self.rate, self.mu = beam, load, load / beam.pitch, mu
        self.index = np.arange(self.load.size)
        self.walks: dict[tuple[float, ...], dict[str, Array]] = {}
        self._walked("scales", mu)

    def take(self, index: Array) -> Walked:
        """Return some of the points; what is walked is shared."""
        other = copy.copy(self)
        other.rate, other.index = self.rate[index], self.index[index]
        return other

    @property
    def theta(self) -> Array:
        """Inclination where plates touch, 0 elsewhere."""
        return self._walked("touching", self.mu)[self.index]

    def torque(self, v: Physical) -> Array:
        """Torque (N m); a thousand times too large where the scales do not follow the record."""
        try:
            share = self._walked("scales", v.mu)
        except InputError:
            share = 1e3 * self._walked("scales", self.mu)
        return np.asarray(v.rigidity * self.rate + v.zero + v.stiffness * share[self.index])

    def jacobian(self, v: Physical) -> Array:
        """Return the derivatives of the torque, shape (n, 5), in the order of :class:`Physical`."""
        here, h = self._walked("scales", v.mu), self.step
        try:
            slope = (self._walked("scales", v.mu + h) - here) / h
        except InputError:
            slope = (here - self._walked("scales", v.mu - h)) / h
        none = np.zeros(self.rate.size)
        columns = [v.stiffness * slope[self.index], here[self.index], self.rate, none, none + 1]
        return np.stack(columns, axis=1)

    def locks_at(self, _: float) -> float:
        """Smallest friction beyond a lock: not known before it is walked."""
        return float("inf")

    def drawn(self, points: int) -> tuple[Walked, Array]:
        """Return evenly spaced points of each way, and the number of their way, counted from 1."""
        found = copy.copy(self)
        pairs = [list(itertools.pairwise(_stops(record)))[-len(record) :] for record in self.ways]
        found.ways = [[np.linspace(a, b, points) for a, b in record] for record in pairs]
        legs = [load for record in found.ways for load in record]
        found.load = np.concatenate(legs)
        found.rate, found.index = found.load / self.beam.pitch, np.arange(found.load.size)
        return found, np.repeat(np.arange(len(legs)) + 1, points)

    def _walked(self, name: str, mu: float) -> Array:
        """Torque of the ``scales`` over K_theta, or where they are ``touching``, at all points."""
        from scipy.interpolate import PchipInterpolator

        found = []
        for record in self.ways:
            stops = _stops(record)
            states = self._walk(stops, float(mu))
            for i, load in enumerate(record, start=len(stops) - len(record)):
                part = np.flatnonzero((states["leg"] == i) | (np.append(states["leg"][1:], 0) == i))
                x, order = np.unique(states["load"][part], return_index=True)
                y = states[name][part][order]
                at = np.clip(load, x[0], x[-1])
                found.append(PchipInterpolator(x, y)(at) if name == "scales" else np.interp(at, x, y))
        return np.concatenate(found)

    def _walk(self, stops: list[float], mu: float) -> dict[str, Array]:
        key = (*stops, mu)
        if key not in self.walks:
            asked = Asked(self.beam, LoadPath.of("twisting", stops), np.asarray(mu), "edge", 0.01, self.points)
            states = follow.model("compliant", asked).walk(asked)
            along = states.by_dim["point",]
            scales = along["scales"] / states.attrs["K_theta"]
            theta = np.where(along["N"] > 0, np.maximum(along["theta"], 1.001 * self.beam.scale.theta0), 0.0)
            self.walks[key] = {"load": along["load"], "leg": along["leg"], "scales": scales, "touching": theta}
        return self.walks[key]


def _stops(record: Sequence[Array]) -> list[float]:
    """Return the twists to go to, from rest at 0, of the ways of a record."""
    stops, here = [0.0], 0.0
    if abs(record[0][-1]) < abs(record[0][0]):
        # it begins with unloading
        stops.append(float(record[0][0]))
    for load in record:
        grows = load[-1] >= load[0] if load.size > 1 else load[0] >= here
        here = float(load.max() if grows else load.min())
        stops.append(here)
    return stops

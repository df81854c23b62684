r"""Twist of the specimen from the readings of the machine: zero of the twist, backlash and compliance.

The reading m of a specimen that is twisted by x (rad per pitch; z and b over the whole beam of N scales) is

.. math::
    m = x + \frac{z - c\,b}{N}

with the zero z of the twist, the backlash b, c = 0 on the ways in the first sense, and the sign of the first sense on
the ways back. After a reversal the specimen rests until the backlash is taken up. A testing machine of the compliance c
(rad per N m) in series takes c T of the rotation at its end:

.. math:: x = m - \frac{c\,T}{N}

Records are corrected for the given compliance c_0, so a trial with another one moves them by (c - c_0) T/N. T is the
measured torque without its noise (:func:`squama.identify.noise.smooth`).
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from types import MappingProxyType
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from squama.types import Array


class Readings(NamedTuple):
    """Points of a test, arrays of length n.

    ``load``: signed reading, rad per pitch; ``direction`` (+1 or -1) in which it moved; ``specimen``: index; ``order``:
    place in the record, 0 to 1; ``torque`` N m, without noise; ``compliance`` (rad/(N m)) of the machine for which they
    are corrected; ``shifts`` by name: values of dimensions with a tolerance, and the torque's derivatives there.
    """

    load: Array
    direction: Array
    specimen: NDArray[np.int64]
    order: Array
    torque: Array
    scales: int
    compliance: float = 0.0
    shifts: Mapping[str, tuple[float, Array]] = MappingProxyType({})

    @classmethod
    def of(
        cls, load: Array, way: Array, specimen: Array, scales: int, torque: Array | None = None, compliance: float = 0.0
    ) -> Readings:
        """Return the readings of records, joined; ``way``: +1 where the magnitude grew, -1 where it fell."""
        order = np.zeros(load.size)
        for number in np.unique(specimen):
            own = specimen == number
            order[own] = np.linspace(0, 1, np.count_nonzero(own))
        torque = np.zeros(load.size) if torque is None else torque
        return cls(load, way * np.where(load < 0, -1.0, 1.0), specimen, order, torque, scales, compliance)

    @property
    def records(self) -> list[list[slice]]:
        """Ways between two turning points as slices, for each specimen."""
        new = np.diff(self.specimen) != 0
        ends = [0, *(np.flatnonzero((np.diff(self.direction) != 0) | new) + 1).tolist(), self.load.size]
        found: list[list[slice]] = []
        for a, b in itertools.pairwise(ends):
            if a == 0 or new[a - 1]:
                found.append([])
            found[-1].append(slice(a, b))
        return found

    @property
    def groups(self) -> NDArray[np.int64]:
        """Index of each point's loop (two ways), or of its specimen where there are several."""
        if self.specimen.size and np.ptp(self.specimen) > 0:
            return self.specimen
        found = np.zeros(self.load.size, np.int64)
        for number, way in enumerate(self.records[0]):
            found[way] = number // 2
        return found

    @property
    def words(self) -> tuple[str, ...]:
        """Names of the groups."""
        kind = "specimen" if np.ptp(self.specimen) > 0 else "loop"
        return tuple(f"{kind} {number + 1}" for number in range(int(self.groups.max()) + 1))

    @property
    def numbers(self) -> NDArray[np.int64]:
        """Number of each point's way."""
        return np.concatenate([[0], np.cumsum((np.diff(self.direction) != 0) | (np.diff(self.specimen) != 0))])

    def turning(self, share: float) -> NDArray[np.bool_]:
        """Return which readings follow a reversal within a share of the range."""
        found, reach = np.zeros(self.load.size, bool), share * float(np.ptp(self.load))
        for ways in self.records:
            for before, way in itertools.pairwise(ways):
                farthest = self.load[before].max() if self.direction[way.start] < 0 else self.load[before].min()
                found[way] = np.abs(self.load[way] - farthest) < reach
        return found

    def placed(self, zero: float, backlash: float, compliance: float) -> tuple[Array, Array]:
        """Return the specimen's twists (rad per pitch), and ``way`` there: +1 loading, -1 unloading."""
        x = self.load - (zero + (compliance - self.compliance) * self.torque) / self.scales
        direction = self.direction.copy()
        for ways in self.records:
            first = self.direction[ways[0].start]
            for before, way in itertools.pairwise(ways):
                sense = self.direction[way.start]
                if sense != first:
                    x[way] += first * backlash / self.scales
                turned = x[before].max() if sense < 0 else x[before].min()
                # within the backlash the specimen keeps the twist of the reversal
                held = np.flatnonzero(sense * (x[way] - turned) <= 0) + way.start
                x[held], direction[held] = turned, -sense
        return x, direction * np.where(x < 0, -1.0, 1.0)

    def drawn(self, points: int, *, once: bool, same: float = 0.02) -> tuple[Readings, Array]:
        """Return evenly spaced readings of a way, and its number; 0, not drawn, where short or repeated (``once``)."""
        size, seen = float(np.abs(self.load).max()), list[tuple[float, float]]()
        parts: list[tuple[Array, ...]] = []
        given = (self.torque, *(shift for _, shift in self.shifts.values()))
        for ways in self.records:
            at: float | None = None
            for way in ways:
                own, sense = self.load[way], float(self.direction[way.start])
                start = at if at is not None else float(own[0])
                stop = float(own.max() if sense > 0 else own.min())
                again = once and any(max(abs(start - a), abs(stop - b)) <= same * size for a, b in seen)
                new = abs(stop - start) > same * size and not again
                if new:
                    seen.append((start, stop))
                # two points at the start of a way: the torque before the drop at a reversal, and after it
                share = np.concatenate([[0.0, 1e-9], np.linspace(0, 1, points)[1:]])
                load = start + share * (stop - start)
                rising = np.argsort(own)
                known = [np.interp(load, own[rising], v[way][rising]) for v in given]
                n, ends = load.size, self.order[[way.start, way.stop - 1]]
                order = ends[0] + share * (ends[1] - ends[0])
                leg = np.full(n, len(seen) if new else 0)
                parts.append((load, np.full(n, sense), np.full(n, self.specimen[way.start]), order, leg, *known))
                at = stop
        load, direction, specimen, order, leg, torque, *known = map(np.concatenate, zip(*parts, strict=True))
        shifts = {name: (self.shifts[name][0], shift) for name, shift in zip(self.shifts, known, strict=True)}
        return Readings(load, direction, specimen, order, torque, self.scales, self.compliance, shifts), leg

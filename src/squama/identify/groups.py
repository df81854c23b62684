"""Parameters with a value for each group of a test (loops or specimens), and the test whether groups differ."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from squama.errors import InputError
from squama.identify.estimate import Points
from squama.identify.joint_points import Linear, Walked
from squama.identify.prepare import Prepared
from squama.identify.selection import Found, chosen, fit_for, robust, rounding, settle
from squama.identify.unknowns import Asked, Parameter
from squama.types import Array

_CHANCE = 1e-2
"""Probability, for equal groups, below which a difference is reported."""
_TWICE, _OF_GROUP = 2, 8
"""Number of linearisations about the values of each group; least number of points in contact in a group."""


def apart(test: Prepared, shared: Found, each: tuple[str, ...], candidates: tuple[str, ...]) -> Found:
    """Find the parameters ``each`` once for each group of the points, from the estimates for all together."""
    words = test.points.readings.words
    found, asked = shared, test.asked.apart(each, words)
    start, points = asked.spread(shared.values), linear(test.points, shared)
    for _ in range(_TWICE if isinstance(points, Linear) else 1):
        near = fit_for(test, asked.names)._replace(asked=asked, points=points)
        rough, out = robust(near, [start])
        found = chosen(near, rough, out, candidates)
        start = found.estimates[: len(asked.rows)]
        if isinstance(points, Linear):
            # about the values of each group, with the derivatives for all
            points = points.apart([found.asked.physical(found.estimates, g) for g in range(len(words))])
    return replace(found, starts=shared.starts)


def about(points: Points, asked: Asked, p: Array) -> Points:
    """Return points whose torque is linearised about values p, on compliant joints; the same points on hinges."""
    if not isinstance(points, Walked):
        return points
    found = Linear(points, asked.physical(p))
    return found.apart([asked.physical(p, g) for g in range(len(asked.groups))]) if asked.groups else found


def linear(points: Points, found: Found) -> Points:
    """Return points whose torque is linearised about the estimates, on compliant joints; else the same points."""
    return found.points if isinstance(found.points, Linear) else about(points, found.asked, found.estimates)


class Differing(NamedTuple):
    """Estimates of one parameter for each group, their errors, and the probability of that in equal groups."""

    name: str
    rows: tuple[Parameter, ...]
    values: Array
    errors: Array
    chance: float

    @property
    def told(self) -> bool:
        """Whether the difference is significant."""
        return self.chance < _CHANCE

    @property
    def way(self) -> str:
        """The order of the values: "rises", "falls" or "changes"."""
        steps = np.sign(np.diff(self.values))
        return {1.0: "rises", -1.0: "falls"}.get(float(steps[0]) if np.ptp(steps) == 0 else 0.0, "changes")

    def report(self) -> dict[str, object]:
        """Return the result as plain data."""
        return {**self._asdict(), "rows": [row.words for row in self.rows]}


def differing(test: Prepared, shared: Found, name: str) -> Differing | None:
    """Compare one value of a parameter with one for each group (F test); None where the points do not suffice."""
    from scipy.stats import f

    readings, used = test.points.readings, shared.used
    touching = used & test.points.touching(shared.asked.physical(shared.estimates))
    counts = [np.count_nonzero(touching & (readings.groups == g)) for g in range(len(readings.words))]
    if name not in shared.parameters or len(counts) < 2 or min(counts) < _OF_GROUP or shared.square == 0:
        return None
    asked = shared.asked.apart((name,), readings.words)
    near = test._replace(asked=asked, points=linear(test.points, shared), usable=used)
    try:
        own = settle(near, asked.spread(shared.values))
    except InputError:
        return None
    freedom, groups = np.count_nonzero(used) / own.dependence - len(asked.rows), len(counts)
    if freedom < 1 or own.square <= rounding(test, test.record.torque[used]):
        return None
    gain = max(shared.square - own.square, 0.0) / (groups - 1)
    chance = float(f.sf(gain / (own.noise**2 * own.dependence), groups - 1, freedom))
    place = [i for i, row in enumerate(asked.rows) if row.group is not None]
    return Differing(name, tuple(asked.rows[i] for i in place), own.estimates[place], own.deviations[place], chance)

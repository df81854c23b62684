"""Where the points of a history stand: evenly on each way, closer together where a reversal is resolved."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence

import numpy as np

from squama.curves.hinge_cycles import STRAIGHT

_LEAST, _GROWS = 4e-6, 2.0
"""First step after a reversal, rad per pitch, and by how much the next ones grow: the contact sticks there while the
friction turns round, and the torque falls steeply."""
_APART, _FULL = 1e-6, 1e-9
"""Least distance of states, rad per pitch: a shorter step may find no balance; and below which two are the same."""


def goals_of(start: float, stop: float, points: int) -> list[float]:
    """Return the twists of a way back from a reversal: even ones, and small steps while the friction turns round."""
    even = evenly(start, stop, [], points)
    return [*resolving(start, even[0]), *even]


def evenly(
    start: float, stop: float, earlier: Sequence[float], points: int, engaged: Sequence[float] = ()
) -> list[float]:
    """Return even twists of a way, and in their places 0 and those where loops may close and where contact begins.

    ``points`` on each part in contact, a quarter of it (:data:`STRAIGHT`) on one without.
    """
    way = math.copysign(1.0, stop - start)

    def within(v: float, least: float) -> bool:
        return (v - start) * way > least and (stop - v) * way > least

    cuts = sorted((v for v in engaged if within(v, _APART)), reverse=way < 0)
    kept = sorted({v for v in (0.0, *earlier) if within(v, _FULL)} | {stop})
    kept += [v for v in cuts if min(abs(v - u) for u in kept) > _APART]
    goals: list[float] = []
    for a, b in itertools.pairwise([start, *cuts, stop]):
        touches = not engaged or any((a + b) / 2 / v > 1 for v in engaged)
        n = points if touches else max(2, points // STRAIGHT)
        even = np.linspace(a, b, n + 1)[1:-1]
        goals += even[np.abs(even[:, None] - np.array(kept)).min(axis=1) > abs(b - a) / n * (0.5 + 1e-9)].tolist()
    return sorted([*goals, *kept], reverse=way < 0)


def resolving(start: float, first: float) -> list[float]:
    """Return the twists between a reversal and the next one that is asked for, by growing steps."""
    steps = max(0, math.ceil(math.log(max(abs(first - start) / 2 / _LEAST, 1.0), _GROWS)))
    return [start + math.copysign(_LEAST * _GROWS**i, first - start) for i in range(steps)]

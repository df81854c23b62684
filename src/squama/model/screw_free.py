"""One load imposed and the other free: a bend with free twist, or a twist with free bend; without friction.

The free load takes the value at which the sum of the scales' and the bar's moment is zero. Where that moment jumps
through zero, at a change of contact (mostly on the line phi = psi tan(alpha)), the beam stays there and the two
contacts share the force.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from squama.model.bracket import zero
from squama.model.screw import NONE, Posed, State, state
from squama.model.screw_path import Design
from squama.types import Array

SIDE, SHARED = 1e-9, 1e-6
"""Difference of the free load, rad, across which a jump is evaluated, and smallest jump relative to the loads."""
FIRST, GROWTH, MOST = 1e-4, 1.6, 40
"""First step away from the last solution, rad, growth of the steps, and their largest number."""


class Free(NamedTuple):
    """States (n,), lengths in pitches, moments in K_theta; NaN beyond the last imposed load with a solution."""

    psi: Array
    phi: Array
    theta: Array
    contact: Array
    N: Array
    M: Array
    T: Array


def relaxed(design: Design, imposed: Array, bar: float, *, free: int) -> Free:
    """Follow an imposed load from rest with the other load free: axis ``free`` of (psi, phi).

    ``bar`` is the bar's moment per angle of the free load and per pitch, over K_theta.
    """
    found: list[tuple[float | str, ...]] = []
    last = 0.0
    for load in map(float, imposed):

        def moment(x: float, load: float = load) -> float:
            point = (load, x) if free else (x, load)
            one = _state(design, *point)
            return float((one.torque if free else one.bending_moment)[0]) + bar * x

        last = _root(moment, last)
        if np.isnan(last):
            break
        found.append(_row(design, load, last, bar, free))
    rows = found + [_LOST] * (len(imposed) - len(found))
    return Free(*(np.array(column) for column in zip(*rows, strict=True)))


_LOST = (np.nan, np.nan, np.nan, NONE, np.nan, np.nan, np.nan)


def _state(design: Design, psi: float, phi: float) -> State:
    """Return the state without friction at a bend and a twist."""
    one = np.ones(1)
    y_n = design.y_n * one
    posed = Posed.of(psi * one, phi * one, y_n, [v * one for v in design[:5]])
    return state(posed, 0.0 * one, (one, one), y_n)


def _root(moment: Callable[[float], float], start: float) -> float:
    """Return the value of the free load nearest to the last one at which its moment is zero; NaN if there is none."""
    a, fa = start, moment(start)
    if fa == 0 or np.isnan(fa):
        return a if fa == 0 else np.nan
    step = -FIRST if fa > 0 else FIRST
    for _ in range(MOST):
        b, fb = a + step, moment(a + step)
        if np.isnan(fb):
            return np.nan
        if fa * fb <= 0:
            return zero(moment, a, fa, b, fb, a, fa, False)
        a, fa, step = b, fb, GROWTH * step
    return np.nan


def _row(design: Design, load: float, x: float, bar: float, free: int) -> tuple[float | str, ...]:
    """Return a state; where the free moment jumps through zero, that of two contacts sharing the force."""

    def at(x: float) -> tuple[str, list[float]]:
        one = _state(design, *((load, x) if free else (x, load)))
        return str(one.contact[0]), [float(v[0]) for v in (one.theta, one.normal, one.bending_moment, one.torque)]

    contact, values = at(x)
    psi, phi = (load, x) if free else (x, load)
    if abs(values[2 + free] + bar * x) > SHARED * (abs(values[2]) + abs(values[3])):
        (low, below), (high, above) = at(x - SIDE), at(x + SIDE)
        ends = [side[2 + free] + bar * x for side in (below, above)]
        share = ends[0] / (ends[0] - ends[1])
        contact = "+".join(sorted({low, high}))
        values = [a + share * (b - a) for a, b in zip(below, above, strict=True)]
    return psi, phi, values[0], contact, *values[1:]

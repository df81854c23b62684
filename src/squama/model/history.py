r"""A contact under loading and unloading: both branches, the stick interval between them, loops, and jamming.

The inclination is a function of the twist (or bend), so a reversal moves nothing: only the friction reverses. With m
the friction per normal force, -mu <= m <= mu, the balance of a scale and the scales' torque are, in units of K_theta
and the pitch and with rates per path parameter (docs, theory: cycles),

.. math::
    D(m) = -(M_N + m M_f), \qquad N = \frac{\theta - \theta_0}{D(m)}, \qquad
    T_s = \frac{(\theta - \theta_0)\,\theta' + m N r'}{\varphi'} .

Loading is m = mu, unloading m = -mu (:func:`squama.model.mechanics.forces` with the friction turned round). In
between the contact sticks, and N changes with m too: T_s falls monotonically as m does, since
dT_s/dm = -(theta - theta0) M_N r' / (phi' D^2) and M_N < 0.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from squama.model import energy, mechanics
from squama.model.bracket import bracketed
from squama.model.paths import ARRAY, FLOAT, Ops, Point
from squama.model.tracks import OneRow
from squama.model.twisting import Number
from squama.types import Array

SAMPLES = 1025
"""Number of samples of a path for the search of jamming on unloading."""
_DEEP = 0.5
_ROUNDS = 4


class Loop(NamedTuple):
    """A closed loop: load angles at its turning points, ``base`` smaller in magnitude; index of the closing value."""

    base: float
    top: float
    closed: int


class Side(NamedTuple):
    """A path in both directions: row of floats, engagement ``x0``, last place ``x_end``, pole, mu, force law."""

    row: OneRow
    x0: float
    x_end: float
    pole: float
    mu: float
    law: str

    def friction(self, way: int) -> float:
        """Return the signed friction per normal force; ``way`` is +1 for loading, -1 for unloading."""
        return way * self.mu

    def forces(self, pt: Point, way: int) -> mechanics.Forces:
        """Return a scale's forces on the loading (+1) or the unloading (-1) branch; f is negative on the latter."""
        return mechanics.forces(pt, self.row.theta0, self.friction(way))


class _Back(NamedTuple):
    """A row in the opposite direction: its path parameter is -x."""

    row: mechanics.Followed

    @property
    def theta0(self) -> Number:
        """Initial inclination, rad."""
        return self.row.theta0

    def point(self, x: Number, law: str, ops: Ops) -> Point:
        """Return the contact at the path parameter -x of the row."""
        return self.row.point(-x, law, ops)


def reversals(values: Sequence[float]) -> list[int]:
    """Return the indices in a history at which the load reverses."""
    steps = np.sign(np.diff(values))
    return [int(i) + 1 for i in np.flatnonzero(steps[1:] * steps[:-1] < 0)]


def loops(values: Sequence[float]) -> list[Loop]:
    """Return the closed loops of a history that starts at 0, in the order in which they close.

    A loop is closed when the load returns to an earlier turning point (or to the start). Since a branch depends on the
    direction of motion only, the history continues as if the loop had not happened. No two values in a row may be
    equal.
    """
    found: list[Loop] = []
    stack = [float(values[0])]
    for i, value in enumerate(map(float, values[1:]), start=1):
        while len(stack) > 1:
            a, b = stack[-2:]
            if (b - a) * (value - b) > 0:
                # same direction: b was no turning point
                stack.pop()
            elif (value - a) * (b - a) <= 0:
                found.append(Loop(min(a, b, key=abs), max(a, b, key=abs), i))
                del stack[-2:]
                stack = stack or [a]
            else:
                break
        if value != stack[-1]:
            stack.append(value)
    return found


def work(side: Side, start: float, stop: float) -> Callable[[Array], Array]:
    """Return the frictional work W_fr d / K_theta from ``start`` to ``stop`` (path parameters), as a function of x.

    The series is that of :func:`squama.model.energy.work`, on either branch; on the unloading branch the parameter is
    reversed, so that a pole of that branch, if there is one, lies ahead too.
    """
    if stop >= start:
        up = energy.work(side.row, start, stop, side.pole, side.mu, side.law)
        return lambda x: np.asarray(up(x))
    row, a, b = _Back(side.row), -start, -stop
    h = 1e-4 * (b - a)
    D1, D0 = (side.forces(row.point(x, side.law, FLOAT), -1).D for x in (b, b - h))
    pole = b + energy.beyond(D1, D0, h, FLOAT)
    down = energy.work(row, a, b, pole, side.friction(-1), side.law)
    # friction and slip have both turned round: the work is the positive one
    return lambda x: -np.asarray(down(-np.asarray(x)))


def held(side: Side, low: float, high: float) -> float | None:
    """Return the path parameter at which friction stops the unloading from ``high`` to ``low``; None if it does not.

    There D = -(M_N - mu M_f) <= 0: the spring cannot push the scale back, however large the normal force.
    """

    def drive(x: Number) -> Number:
        ops = FLOAT if isinstance(x, float) else ARRAY
        return side.forces(side.row.point(x, side.law, ops), -1).D

    return last_below(drive, low, high)


def _free(side: Side, bar: float) -> Callable[[Number], Number]:
    """Return a function of x that is positive where the unloading beam slides under a positive torque.

    ``bar`` is the rigidity of the bar over K_theta d.
    """

    def free(x: Number) -> Number:
        scalar = isinstance(x, float)
        pt = side.row.point(x, side.law, FLOAT if scalar else ARRAY)
        mu, lift = side.mu, pt.theta - side.row.theta0
        D = -(pt.M_N - mu * pt.M_f)
        # D times the torque has no pole where D vanishes
        torque = D * (bar * pt.load + lift * pt.theta_rate / pt.load_rate) - mu * lift * pt.slip_rate / pt.load_rate
        return min(D, torque) if scalar else np.minimum(D, torque)

    return free


def jam(side: Side, bar: float) -> float | None:
    """Return the smallest path parameter at which a released beam does not unload; None if there is none on the path.

    There the torque of the whole beam on the unloading branch is zero or less, or the contact does not slide back at
    all; ``bar`` is the rigidity of the bar without contact over K_theta d.
    """
    free = _free(side, bar)
    found = last_below(lambda x: free(-x), -side.x_end, -side.x0)
    return None if found is None else -found


def residual(side: Side, bar: float, x: float) -> float | None:
    """Return the path parameter at which a beam released at ``x`` comes to rest; None if it unloads until straight."""
    return last_below(_free(side, bar), side.x0, x)


def last_below(f: Callable[[Number], Number], low: float, high: float) -> float | None:
    """Return the largest x in [low, high] with f(x) <= 0, f continuous, for floats or arrays; None if f is positive."""
    x = np.linspace(low, high, SAMPLES)
    with np.errstate(all="ignore"):
        y = np.asarray(f(x))
    below = np.flatnonzero(~(y > 0))
    first = int(below[-1]) if below.size else -1
    for i in _dips(y, first)[::-1]:
        bottom = _bottom(f, float(x[i - 1]), float(x[i + 1]))
        if f(bottom) <= 0:
            return bracketed(lambda v: float(f(v)), float(x[i + 1]), bottom)
    if first == -1:
        return None
    if first == SAMPLES - 1:
        return float(high)
    return bracketed(lambda v: float(f(v)), float(x[first + 1]), float(x[first]))


def _dips(y: Array, first: int) -> Array:
    """Return the samples beyond ``first`` at which f has a local minimum that may be below zero."""
    left, middle, right = y[:-2], y[1:-1], y[2:]
    with np.errstate(all="ignore"):
        bottom = middle - (right - left) ** 2 / (8 * (right + left - 2 * middle))
    dip = (middle <= left) & (middle < right) & (bottom < _DEEP * middle)
    i = np.flatnonzero(dip) + 1
    return np.asarray(i[i > first + 1])


def _bottom(f: Callable[[Number], Number], a: float, b: float) -> float:
    """Return the place of the smallest value between ``a`` and ``b``, by repeated subdivision."""
    x = np.linspace(a, b, 33)
    for _ in range(_ROUNDS):
        i = int(np.argmin(f(x)))
        x = np.linspace(x[max(i - 1, 0)], x[min(i + 1, 32)], 33)
    return float(x[16])

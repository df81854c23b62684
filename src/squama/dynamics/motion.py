r"""Integration of the motion in time with events, for material damping and forcing.

.. math:: \ddot y + 2\zeta\dot y + y + q(y, \mathrm{sign}\,\dot y) = F\sin\Omega t

Each part of the motion is smooth: without contact, or on the loading or the unloading branch of a side. It ends where a
contact engages or opens and where the motion turns. At a turning point the scales stick while the force on them lies
between the branches, and leave along the loading branch above, the unloading branch below. Time is in 1/omega0 of the
bar, angles as in :mod:`squama.dynamics.branches`.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from typing import Any, NamedTuple

import numpy as np
from scipy.integrate import solve_ivp

from squama.dynamics.branches import Branch
from squama.dynamics.decay import Sides
from squama.types import Array

TOLERANCE = 1e-10
"""Relative error of a time step on branches that are smooth to all digits."""
DENSE = 24
"""Number of recorded points on each smooth part of the motion."""
MOST_PARTS = 1000
"""Largest number of smooth parts in a period."""
APART, TURNED, STUCK, BEYOND, EVENTS = "apart", "turned", "stuck", "beyond", "events"


class Drive(NamedTuple):
    """Material damping ratio of the bar; amplitude of the force, as static angle of the bare bar; frequency Omega.

    ``tolerance`` is the relative error of a time step.
    """

    zeta: float = 0.0
    force: float = 0.0
    frequency: float = 1.0
    tolerance: float = TOLERANCE

    def at(self, t: float) -> float:
        """Return the force at the time t."""
        return self.force * math.sin(self.frequency * t) if self.force else 0.0

    def steady(self) -> tuple[float, float, float]:
        """Return amplitude, and angle and speed at t = 0, of the bare bar's steady state."""
        w, a = self.frequency, complex(1 - self.frequency**2, 2 * self.zeta * self.frequency)
        z = self.force / a
        return abs(z), z.imag, w * z.real


class State(NamedTuple):
    """Time, signed angle, speed; work of the force, of material damping and on the scales since the start."""

    t: float
    y: float
    v: float
    fed: float = 0.0
    damped: float = 0.0
    scales: float = 0.0


class Part(NamedTuple):
    """A smooth part of the motion: times, angles and speeds, the state at its end, and the event that ended it."""

    t: Array
    y: Array
    v: Array
    last: State
    why: str


def follow(sides: Sides, drive: Drive, state: State, until: float, *, dense: int = 0) -> Iterator[Part]:
    """Yield the smooth parts of a motion until the time ``until``, each with ``dense`` intervals, or its ends.

    The last part ends at ``until``, or where the motion sticks for good or goes beyond a side's last angle.
    """
    way, side = _where(sides, drive, state)
    while state.t < until:
        if way == 0 and side is not None:
            part, way = _stick(sides, drive, state, until)
            yield part
            state = part.last
            if part.why == STUCK:
                return
            # the branch in which it stuck is the unloading one
            side = sides.of(1 if state.y > 0 else -1).up if way > 0 else side
            continue
        part = _part(sides, drive, state, until, way, side, dense)
        yield part
        state = part.last
        if part.why == BEYOND:
            return
        if part.why == TURNED:
            way, side = _turn(sides, drive, state, way, side)
        elif part.why == APART:
            sign = 1 if state.y > 0 else -1
            outward = state.v * sign > 0
            way, side = (1, sides.of(sign).up) if outward else (0, None)


def joined(start: State, parts: Iterable[Part]) -> tuple[Array, Array, Array]:
    """Return times, angles and speeds of consecutive parts."""
    rows = [np.array([[start.t], [start.y], [start.v]]), *(np.array([p.t[1:], p.y[1:], p.v[1:]]) for p in parts)]
    t, y, v = np.concatenate(rows, axis=1)
    return t, y, v


def _where(sides: Sides, drive: Drive, state: State) -> tuple[int, Branch | None]:
    """Return the direction (+1 loading, -1 unloading, 0 no contact) and the branch of a state."""
    sign = 1 if state.y > 0 else -1
    side, u, w = sides.of(sign), abs(state.y), state.v * sign
    if side.up is None or u < side.y_e or (u == side.y_e and w <= 0):
        return 0, None
    if w == 0:
        return _turn(sides, drive, state, 1, side.up)
    return (1, side.up) if w > 0 else (-1, side.falling(u))


def _turn(sides: Sides, drive: Drive, state: State, way: int, branch: Branch | None) -> tuple[int, Branch | None]:
    """Return direction and branch after a turning point; direction 0 with a branch means that the scales stick."""
    sign = 1 if state.y > 0 else -1
    side, u = sides.of(sign), abs(state.y)
    if branch is None or u <= side.y_e:
        return 0, None
    up, down = side.up, (side.falling(u) if way > 0 else branch)
    bare = sign * drive.at(state.t) - u
    if bare > float(up.force(u)):
        return 1, up
    if u <= down.last and bare < float(down.force(u)):
        return -1, down
    return 0, down


class _Event:
    """Event that ends a part: the signed angle (``index`` 0) or the speed (1) passes a value in a direction."""

    terminal = True

    def __init__(self, index: int, value: float, direction: int, why: str) -> None:
        self.index, self.value, self.direction, self.why = index, value, direction, why

    def __call__(self, _: float, s: Array) -> float:
        """Return the signed distance from the event's value."""
        return float(s[self.index]) - self.value


def _part(sides: Sides, drive: Drive, state: State, until: float, way: int, branch: Branch | None, dense: int) -> Part:
    """Integrate one smooth part, to the next event or to ``until``."""
    zeta2 = 2 * drive.zeta
    sign = 1 if state.y > 0 else -1
    pull: Callable[[float], float] = (lambda _: 0.0) if branch is None else branch.quick

    def rates(t: float, s: Array) -> list[float]:
        y, v = float(s[0]), float(s[1])
        f = drive.at(t)
        return [v, f - zeta2 * v - y - sign * pull(sign * y), f * v, zeta2 * v * v]

    if branch is None:
        both = [(k, sides.of(k)) for k in (1, -1)]
        events = [_Event(0, k * s.y_e, k, APART) for k, s in both if s.y_e < math.inf]
        events += [_Event(0, k * s.last, k, BEYOND) for k, s in both if s.up is None and s.last < math.inf]
        heading = state.v or drive.at(state.t) - state.y or drive.force
        events.append(_Event(1, 0.0, -1 if heading > 0 else 1, TURNED))
    else:
        side = sides.of(sign)
        last = min(side.last, branch.last)
        stops = TURNED if side.endless else BEYOND
        bound = _Event(0, sign * last, sign, stops) if way > 0 else _Event(0, sign * side.y_e, -sign, APART)
        events = [bound, _Event(1, 0.0, -sign * way, TURNED)]
    x0 = np.array([state.y, state.v, state.fed, state.damped])

    def solve(stop: float) -> Any:
        near, few = drive.tolerance, drive.tolerance / 100
        return solve_ivp(rates, (state.t, stop), x0, "DOP853", None, dense > 0, events, rtol=near, atol=few)

    found = solve(until)
    hit = _hit(found)
    if hit == len(events) - 1 and any(e(0.0, found.y[:, -1]) * e.direction > 0 for e in events[:-1]):
        # a bound is passed and left again within one step
        found = solve(float(found.t[-1]))
        hit = _hit(found)
    t = float(found.t[-1])
    y, v, fed, damped = map(float, found.y[:, -1])
    why = "" if hit is None else events[hit].why
    if hit is not None and events[hit].index == 0:
        # a swing that a lock turns ends at the lock, too
        y = events[hit].value
    if why == TURNED:
        v = 0.0
    work = 0.0 if branch is None else float(branch.work(sign * y)) - float(branch.work(sign * state.y))
    times = np.linspace(state.t, t, dense + 1) if dense else np.array([state.t, t])
    ends = found.sol(times)[:2] if dense else found.y[:2, [0, -1]]
    return Part(times, ends[0], ends[1], State(t, y, v, fed, damped, state.scales + work), why)


def _hit(found: Any) -> int | None:
    """Return the number of the event that ended an integration, None if none did."""
    hits = [(float(times[-1]), i) for i, times in enumerate(found.t_events) if len(times)]
    return max(hits)[1] if hits and found.status == 1 else None


def _stick(sides: Sides, drive: Drive, state: State, until: float) -> tuple[Part, int]:
    """Return the part in which the scales stick, and the direction (+1, -1) in which they leave; 0 if they do not."""
    sign = 1 if state.y > 0 else -1
    side, u = sides.of(sign), abs(state.y)
    down = side.falling(u)
    low = float(down.force(u)) if u <= down.last else -math.inf
    # the force's phase at which sign * F sin(phase) - u comes to a branch
    leaves = [(_reaches(drive, state.t, sign * (u + float(side.up.force(u))), sign), 1)]
    leaves.append((_reaches(drive, state.t, sign * (u + low), -sign), -1))
    t, way = min(leaves)
    why = "" if t < math.inf else STUCK
    if t > until:
        t, way, why = until, 0, why or ""
    last = state._replace(t=t)
    return Part(np.array([state.t, t]), np.full(2, state.y), np.zeros(2), last, why), way


def _reaches(drive: Drive, t: float, level: float, rising: int) -> float:
    """Return the next time at which the force passes a level in a direction; inf if it never does."""
    if abs(level) > drive.force:
        return math.inf
    phase = math.asin(level / drive.force)
    phase = phase if rising > 0 else math.pi - phase
    turn = 2 * math.pi
    return t + ((phase - drive.frequency * t) % turn) / drive.frequency


# ---- steady states ----------------------------------------------------------------------------------------

SETTLED, POLISHED = 1e-3, 10.0
"""Relative change of the state over a period below which Newton's method starts; convergence limit over the step's
error.
"""
MOST_PERIODS, LAST = 400, 50
"""Number of periods after which a motion counts as not settled; its extremes are then those of the last ``LAST``."""


class Steady(NamedTuple):
    """A steady state: largest and smallest angle, state at the beginning of a period, works over it, number of periods.

    ``settled``: whether the state returns after a period; ``parts``: number of smooth parts in a period.
    """

    high: float
    low: float
    y: float
    v: float
    fed: float
    damped: float
    rubbed: float
    periods: int
    settled: bool
    parts: int


class LeftError(Exception):
    """Error for a motion beyond a side's last angle (``why`` BEYOND), or with too many parts in a period (EVENTS)."""

    def __init__(self, why: str, state: State) -> None:
        super().__init__(why)
        self.why, self.state = why, state


def period(sides: Sides, drive: Drive, y: float, v: float) -> Steady:
    """Follow one period of the force from angle ``y`` and speed ``v`` at its beginning."""
    state, high, low, n = State(0.0, y, v), y, y, 0
    until = 2 * math.pi / drive.frequency
    for part in follow(sides, drive, state, until):
        state, n = part.last, n + 1
        high, low = max(high, state.y), min(low, state.y)
        if part.why == BEYOND or n > MOST_PARTS:
            raise LeftError(BEYOND if part.why == BEYOND else EVENTS, state)
    return Steady(high, low, state.y, state.v, state.fed, state.damped, state.scales, 1, False, n)


def steady(sides: Sides, drive: Drive, y: float = 0.0, v: float = 0.0) -> Steady:
    """Follow a forced motion until it is periodic.

    Successive periods are followed, so that the state is stable; Newton's method only refines it. Without contact the
    result is the linear oscillator's exact steady state. A motion that repeats only after several periods, or never,
    does not settle.
    """
    reach, y_s, v_s = drive.steady()
    engaged = min(sides.plus.y_e, sides.minus.y_e)
    seen: deque[tuple[float, float]] = deque(maxlen=LAST)
    for n in range(1, MOST_PERIODS + 1):
        if drive.zeta and reach + _swing(drive, y - y_s, v - v_s) < engaged:
            damped = math.pi * 2 * drive.zeta * drive.frequency * reach**2
            return Steady(reach, -reach, y_s, v_s, damped, damped, 0.0, n, True, 0)
        one = period(sides, drive, y, v)
        size, change = one.high - one.low, math.hypot(one.y - y, one.v - v)
        if change <= POLISHED * drive.tolerance * size:
            return one._replace(periods=n, settled=True)
        if change <= SETTLED * size:
            found = _newton(sides, drive, one.y, one.v, size)
            if found is not None:
                return found._replace(periods=n, settled=True)
        y, v = one.y, one.v
        seen.append((one.high, one.low))
    highs, lows = zip(*seen, strict=True)
    return one._replace(high=max(highs), low=min(lows), periods=n)


def _swing(drive: Drive, y: float, v: float) -> float:
    """Return an upper bound of the angle in the bare bar's free motion from a state."""
    return math.hypot(y, (v + drive.zeta * y) / math.sqrt(1 - drive.zeta**2))


def _newton(sides: Sides, drive: Drive, y: float, v: float, size: float) -> Steady | None:
    """Return the periodic state near a state; None if Newton's method does not converge in a few steps."""
    h = math.sqrt(drive.tolerance) * size
    for _ in range(4):
        base = period(sides, drive, y, v)
        gap = np.array([base.y - y, base.v - v])
        if float(np.hypot(*gap)) <= POLISHED * drive.tolerance * size:
            return base
        moved = [period(sides, drive, y + h, v), period(sides, drive, y, v + h)]
        slope = np.array([[m.y - base.y, m.v - base.v] for m in moved]).T / h - np.eye(2)
        step = np.linalg.solve(slope, -gap)
        if float(np.hypot(*step)) > 100 * SETTLED * size:
            return None
        y, v = y + float(step[0]), v + float(step[1])
    return None

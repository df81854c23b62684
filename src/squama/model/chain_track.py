"""The path of a finite row: one Newton solution for all scales at each twist, then the next twist.

The unknowns of a point are theta, w, N and a multiplier nu for each scale. Closed contacts fix g = 0 and its rate; the
motions that they leave free follow a difference formula of second order (BDF2), with nu keeping it on the contacts. So
rates that the contacts fix are exact, and without friction the point does not depend on the way to it.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.linalg import LinAlgError, solve_banded

from squama.model.chain import Row, frame, pair, terms
from squama.model.outcome import End
from squama.types import Array

REACH = 7
"""Width of the band: scales i and i + 1 share a contact, four unknowns each."""
TOLERANCE = 1e-11
"""Newton ends below this change of inclinations (rad) and rates."""
ROUNDS = 25
SMALLEST = 2.0**-14
"""Smallest step, as a fraction of the distance between two points; where it fails the row has its end."""
OPEN = 1e-10
"""Gap (pitches) or inclination (rad) below zero that counts as closing."""
LEVER = 0.05
"""Lever of a tip (over the scale's length) below which an end without a next state is a lock."""
STEEP = 0.1
"""Largest change of an inclination in one step, rad."""


class State(NamedTuple):
    """Row at one twist: inclinations, rates ``w`` and normal forces ``N`` (K_theta/d; the last is 0).

    ``Q`` moments of the substrate (K_theta), ``closed`` contacts, scales that lie ``down`` on the substrate.
    """

    phi: float
    theta: Array
    w: Array
    N: Array
    Q: Array
    closed: Array
    down: Array


class Track(NamedTuple):
    """Rows along phi, how and where the path ended: ``scale`` from 0, ``other`` in words, ``phi_end``."""

    states: list[State]
    end: End
    scale: int
    other: str
    phi_end: float


class _Band:
    """Places of the blocks of contacts in the band of the matrix, made once for a row."""

    def __init__(self, scales: int) -> None:
        self.size = 4 * scales
        i = 4 * np.arange(scales - 1)[:, None, None]
        r, c = np.arange(8)[:, None], np.arange(8)[None, :]
        flat = (REACH + r - c) * self.size + i + c
        self.parts = [(slice(k, None, 2), flat[k::2]) for k in (0, 1)]
        self.diagonal = REACH * self.size + 4 * np.arange(scales)

    def assemble(self, blocks: Array, own: Array) -> Array:
        """Return the band of the blocks (contacts, 8, 8) and of each scale's ``own`` entries {(r, c): values}."""
        ab = np.zeros((2 * REACH + 1) * self.size)
        for part, flat in self.parts:
            ab[flat] += blocks[part]
        r, c = np.arange(4)[:, None], np.arange(4)[None, :]
        ab[(self.diagonal[:, None, None] + (r - c) * self.size + c)] += own
        return ab.reshape(2 * REACH + 1, self.size)


class _Formula(NamedTuple):
    """Difference formula of the free motions: w = gamma theta - history, or (gamma 0) the first rate of all."""

    gamma: float
    history: Array


def _newton(row: Row, band: _Band, phi: float, guess: State, formula: _Formula | None) -> State | None:
    """Solve a point with the contacts that ``guess`` has closed; None where it does not converge.

    Without a formula it is the start: the lifts are zero, and their rates w and the rates of N are in balance.
    """
    n = row.scales
    f = frame(row, phi)
    closed = guess.closed[:-1]
    theta, w, N, nu = guess.theta.copy(), guess.w.copy(), guess.N.copy(), np.zeros(n)
    h = 1e-30
    steps = np.zeros((4, 5, 1), complex)
    for k in range(4):
        steps[k, k + 1] = 1j * h
    blocks = np.zeros((n - 1, 8, 8))
    own = np.zeros((n, 4, 4))
    r = np.zeros((n, 4))
    weight = 1.0 if formula is None else 1 / formula.gamma
    for _ in range(ROUNDS):
        local = np.stack([theta[:-1], theta[1:], w[:-1], w[1:]])[:, None, :]
        e = terms(row, f, *(local + steps))
        M, c = N[:-1], e.c
        A, B, gap, rate = (v[0].real for v in (e.A, e.B, c.gap, e.rate))
        g_a, g_b = c.g_a[0].real, c.g_b[0].real
        dA, dB, dgap, drate, dg_a, dg_b = (v[1:].imag / h for v in (e.A, e.B, c.gap, e.rate, c.g_a, c.g_b))
        r[:], blocks[:], own[:] = 0, 0, 0
        # columns of a contact's block: theta, w, N, nu of its first scale, then of its second
        for k, col in enumerate((0, 4, 1, 5)):
            blocks[:, 0, col] -= M * dA[k]
            blocks[:, 4, col] -= M * dB[k]
            blocks[:, 2, col] = np.where(closed, drate[k] if formula is None else dgap[k], 0)
        blocks[:, 0, 2] -= A
        blocks[:, 4, 2] -= B
        own[:-1, 2, 2] = own[:-1, 3, 3] = ~closed
        own[-1, 2, 2] = own[-1, 3, 3] = 1
        r[:-1, 2], r[:-1, 3], r[-1, 2:] = (
            np.where(closed, rate if formula is None else gap, M),
            nu[:-1],
            (N[-1], nu[-1]),
        )
        if formula is None:
            r[:, 0], r[:, 1] = w, theta - row.theta0
            own[:, 0, 1] = own[:, 1, 0] = own[:-1, 3, 3] = 1
        else:
            r[:, 0], r[:, 1] = theta - row.theta0, weight * (w + formula.history) - theta
            r[:-1, 1] -= g_a * nu[:-1]
            r[1:, 1] -= g_b * nu[:-1]
            r[:-1, 3] = np.where(closed, rate, nu[:-1])
            own[:, 0, 0], own[:, 1, 0], own[:, 1, 1] = 1, -1, weight
            blocks[:, 1, 3] -= g_a
            blocks[:, 5, 3] -= g_b
            for k, col in enumerate((0, 4, 1, 5)):
                blocks[:, 1, col] -= nu[:-1] * dg_a[k]
                blocks[:, 5, col] -= nu[:-1] * dg_b[k]
                blocks[:, 3, col] = np.where(closed, drate[k], 0)
        r[:-1, 0] -= M * A
        r[1:, 0] -= M * B
        Q = np.where(guess.down, r[:, 0], 0.0)
        r[:, 0] = np.where(guess.down, theta, r[:, 0])
        r[:, 1] = np.where(guess.down, w, r[:, 1])
        blocks[guess.down[:-1], :2] = 0
        blocks[guess.down[1:], 4:6] = 0
        own[guess.down, :2] = ((1, 0, 0, 0), (0, 1, 0, 0))
        try:
            x = solve_banded((REACH, REACH), band.assemble(blocks, own), r.ravel(), check_finite=False).reshape(n, 4)
        except (LinAlgError, ValueError):
            return None
        if not np.isfinite(x).all():
            return None
        theta, w, N, nu = theta - x[:, 0], w - x[:, 1], N - x[:, 2], nu - x[:, 3]
        change, rates = np.abs(x[:, 0]).max(), np.abs(x[:, 1]).max()
        if change > 1 or not np.isfinite(rates):
            return None
        if change < TOLERANCE and rates < TOLERANCE * (1 + np.abs(w).max()) * 100:
            return State(phi, theta, w, N, Q, guess.closed, guess.down)
    return None


def start(row: Row, phi_e: float) -> State | None:
    """Return the row at engagement, with the rates of N in place of N; None where friction locks it there."""
    n = row.scales
    flat = np.full(n, row.theta0)
    zero = np.zeros(n)
    state = State(phi_e, flat, zero, zero, zero, np.arange(n) < n - 1, zero > 0)
    band = _Band(n)
    # without friction the equations are linear; friction is then brought in by steps
    for share in np.linspace(0, 1, 2 + int(4 * row.mu)) if row.mu else (0.0,):
        found = _newton(row._replace(mu=share * row.mu), band, phi_e, state, None)
        if found is None or (found.N[:-1] < 0).any():
            return None
        state = found
    return state


def track(row: Row, phi_e: float, phis: Array, first: State | None = None) -> Track:
    """Follow the row through the twists ``phis`` (ascending, beyond ``phi_e``) to the last or to its end."""
    first = start(row, phi_e) if first is None else first
    if first is None:
        return Track([], End.STATIC, 0, "", phi_e)
    band = _Band(row.scales)
    done = [first._replace(N=np.zeros(row.scales))]
    states = [done[0]]
    rates = first.N
    for phi in phis:
        least = SMALLEST * (phi - states[-1].phi)
        step = phi - done[-1].phi
        while done[-1].phi < phi:
            target = phi if done[-1].phi + step > phi - least else done[-1].phi + step
            found, problem = _advance(row, band, target, done, rates)
            if problem is None and found is not None:
                done = [*done[-1:], found]
                step = min(2 * step, phi - found.phi)
                continue
            step = (target - done[-1].phi) / 2
            if step < least:
                states += [] if done[-1] is states[-1] else [done[-1]]
                end, scale, words = problem or _stuck(row, done[-1])
                return Track(states, end, scale, words, done[-1].phi)
        states.append(done[-1])
    return Track(states, End.RANGE, 0, "", float(phis[-1]))


Problem = tuple[End, int, str] | None


def _advance(row: Row, band: _Band, phi: float, done: list[State], rates: Array) -> tuple[State | None, Problem]:
    """Take one step from the last of the states ``done``; say what ends the row there, if anything does."""
    last = done[-1]
    guess, formula = _predict(phi, done, rates)
    f = frame(row, phi)
    for _ in range(2 * row.scales):
        found = _newton(row, band, phi, guess, formula)
        if found is None or np.abs(found.theta - last.theta).max() > STEEP:
            return None, None
        gap = pair(row, f, found.theta[:-1], found.theta[1:]).gap
        closed, down = found.closed.copy(), found.down.copy()
        closed[:-1] = np.where(closed[:-1], found.N[:-1] >= 0, gap < -OPEN)
        down = np.where(down, found.Q >= 0, found.theta < -OPEN)
        if (closed == found.closed).all() and (down == found.down).all():
            return found, _problem(row, found)
        if (closed & ~found.closed & last.closed).any():
            # a contact that was opened because its force vanished sinks in: it was no opening
            return None, None
        guess = guess._replace(closed=closed, down=down, N=np.where(closed, np.maximum(guess.N, 0), 0))
    return None, None


def _predict(phi: float, done: list[State], rates: Array) -> tuple[State, _Formula]:
    """Return the first guess of a step and its difference formula: BDF2, or one of first order after a change."""
    last = done[-1]
    h = phi - last.phi
    if len(done) == 1:
        guess = last._replace(theta=last.theta + h * last.w, N=h * rates)
        return guess, _Formula(2 / h, 2 / h * last.theta + last.w)
    old = done[0]
    if (old.closed != last.closed).any() or (old.down != last.down).any():
        return last, _Formula(1 / h, last.theta / h)
    q = h / (last.phi - old.phi)
    guess = last._replace(
        theta=last.theta + h * (last.w + q / 2 * (last.w - old.w)),
        w=last.w + q * (last.w - old.w),
        N=last.N + q * (last.N - old.N),
    )
    return guess, _Formula((1 + 2 * q) / (1 + q) / h, ((1 + q) * last.theta - q * q / (1 + q) * old.theta) / h)


def _stuck(row: Row, state: State) -> tuple[End, int, str]:
    """Name an end without a next state: a lock where the lever of a tip, friction included, has all but vanished."""
    e = terms(row, frame(row, state.phi), state.theta[:-1], state.theta[1:], state.w[:-1], state.w[1:])
    i = int(np.argmin(np.where(state.closed[:-1], e.A, np.inf)))
    if e.A[i] < LEVER * row.eta:
        return (End.FRICTIONAL if row.mu else End.KINEMATIC), i, ""
    return End.OTHER, i, "no equilibrium of the row was found beyond this twist"


def _problem(row: Row, state: State) -> Problem:
    """Return what ends the row at this state: a contact off its edges, or a farther neighbour."""
    theta = state.theta
    for k in range(1, min(int(np.hypot(row.eta, 2 * row.beta)), row.scales - 1) + 1):
        c = pair(row, frame(row, state.phi, k), theta[:-k], theta[k:])
        on = (abs(c.p) <= row.beta) & (c.s >= 0) & (c.s <= row.eta)
        if k > 1:
            met = np.flatnonzero(on & (c.gap < 0))
            if met.size:
                i = int(met[0])
                return End.OTHER, i, f"tip edge of scale {i + 1} on side edge of scale {i + 1 + k}"
            continue
        off = np.flatnonzero(state.closed[:-1] & ~on)
        if off.size:
            i = int(off[0])
            return (End.OFF_TIP if abs(c.p[i]) > row.beta else End.OFF_SIDE), i, ""
    return None

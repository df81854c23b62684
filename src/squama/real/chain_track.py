"""The path of a finite row on a joint that gives: all scales at once at each twist, then the next twist.

Contacts that are closed and scales that lie on the substrate are taken as in the last state, solved for, and changed
where the solution contradicts them. Where that leads nowhere the step is halved.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from scipy.linalg import LinAlgError, solve_banded

from squama.batch.keeping import tell
from squama.model import elastic_plate as plate
from squama.progress import steps
from squama.real import chain, changes, entry, follow, path
from squama.real.contact import Step
from squama.types import Array

ROUNDS = 20
SMALLEST = 1e-6
"""Smallest step, rad per pitch; where it fails the row has its end."""
TIGHT = 1e-9
"""Newton's last correction."""
OPEN = 1e-10
"""Gap (pitches) or inclination (rad) below zero that counts as closing."""
_FIRST = 1 / 16
"""First step over the largest one."""
_SHARP = 1e-5
"""Newton's last correction over the step: rates count."""
LENGTHWISE = plate.SIDE_D, plate.SIDE_A


class Row(NamedTuple):
    """A row of scales: the endless beam's path, and the number of scales.

    Neighbours that touch stand side by side in ``order``: scales 1, 1 + k, .. for contacts with neighbour k, then
    2, 2 + k, ..; ``joined`` says where there is a contact with the next in that order. ``edges`` (2, 2): least and
    largest place on the edge of the one and of the other.
    """

    way: path.Path
    scales: int
    order: Array
    joined: Array
    edges: Array

    @property
    def beam(self) -> tuple[entry.Beams, Array, Array]:
        """What compiled code is told of the beam."""
        return self.way.beams, np.array(self.way.contact), self.way.table

    @classmethod
    def of(cls, way: path.Path, scales: int) -> Row:
        """Return a row."""
        k = way.contact.k
        order = np.concatenate([np.arange(i, scales, k) for i in range(min(k, scales))])
        ends = [(0.0, way.scale.eta) if e in LENGTHWISE else (-way.scale.beta, way.scale.beta) for e in way.contact[:2]]
        return cls(way, scales, order, order + k < scales, np.array(ends))


class State(NamedTuple):
    """A row at a twist.

    ``s`` (n, 32) see :mod:`squama.real.chain`, its ``rate`` with the twist and the rate of that; ``marks`` (3, n):
    contacts, closed ones, scales that lie on the substrate; work of friction and of the torque so far (n,), E d^3.
    """

    phi: float
    s: Array
    rate: Array
    bow: Array
    marks: Array
    rubbed: Array
    work: Array


class Track(NamedTuple):
    """What became of a row; NaN beyond its end, which is the last point.

    ``rows`` (points, n, 17) are states of every scale, :data:`squama.real.follow.COLUMNS`, with the places at which its
    plate is touched: on its tip by the next, on its side by the one before. ``sides`` (points, n) are the places on the
    next one's edge, ``held`` the moments of the substrate, E d^3. The end: number, twist, scale (from 0), edge and
    neighbour of another contact.
    """

    rows: Array
    sides: Array
    held: Array
    code: int
    phi: float
    scale: int
    edge: int
    k: int


def track(way: path.Path, scales: int, phis: Array, step: float = path.STEP) -> Track:
    """Follow a row through ascending twists beyond engagement to the last or to its end."""
    tell(entry.row, "rows of the real beam")
    row = Row.of(way, scales)
    where = np.argsort(row.order)
    last, before, h = _start(row), None, step * _FIRST
    rows = np.full((phis.size, scales, len(follow.COLUMNS)), np.nan)
    sides, held = np.full((2, phis.size, scales), np.nan)
    for i, goal in enumerate(steps(phis, phis.size, "points of the row")):
        while last.phi < goal:
            left = goal - last.phi
            size = left / math.ceil(left / h * (1 - 1e-9))
            found = _advance(row, goal if size > left * (1 - 1e-9) else last.phi + size, last, before)
            problem = (changes.STOPPED, -1, -1, 0) if found is None else _problem(row, where, found)
            if found is not None and problem is None:
                before, last, h = last, found, min(step, 2 * size)
                continue
            h = size / 2
            if h < SMALLEST and problem is not None:
                if i == 0 or last.phi > phis[i - 1]:
                    _write(row, last, rows[i], sides[i], held[i])
                return Track(rows, sides, held, problem[0], last.phi, *problem[1:])
        _write(row, last, rows[i], sides[i], held[i])
    return Track(rows, sides, held, changes.RANGE, last.phi, -1, -1, 0)


def decay(way: path.Path) -> float:
    """Return how much of an end's effect is left one contact further on, at engagement and without friction.

    Forces of contacts then grow by N' with a N'_(i-1) + b N'_i + a N'_(i+1) alike for all of them, so differences of
    N' fall by r with r + 1/r = -b/a.
    """
    if way.contact.first < 0:
        return math.nan
    shapes = way.beams.shapes.copy()
    shapes[:, 8] = 0.0
    row = Row.of(way._replace(beams=way.beams._replace(shapes=shapes)), 6 * way.contact.k)
    found, marks, h = _start(row), _start(row).marks, SMALLEST
    r, band = np.empty((2, row.scales, chain.UNKNOWNS)), np.empty((2 * chain.REACH + 1, row.scales * chain.UNKNOWNS))
    states = np.stack([found.s] * 3)
    for i, at in enumerate((found.phi, found.phi + h)):
        entry.row(*row.beam, at, Step(False, 1.0, -1.0, 0.0, h), states, marks, r[i], band if i == 0 else band[:0])
    rates = solve_banded((chain.REACH, chain.REACH), band, (r[0] - r[1]).ravel()).reshape(r[0].shape)
    states[0, :, : chain.UNKNOWNS] += rates
    entry.row(*row.beam, found.phi + h, Step(False, 1.0, -1.0, 0.0, h), states, marks, r[0], band[:0])
    N = states[0, :4, chain.NORMAL]
    both = (N[0] + N[2] - N[1]) / (N[1] - N[0])
    return float((both - math.copysign(math.sqrt(max(0.0, both * both - 4)), both)) / 2)


def _start(row: Row) -> State:
    """Return the row at engagement."""
    c, n = row.way.contact, row.scales
    s = np.zeros((n, chain.WIDTH))
    s[:, :6] = row.way.states(np.array([c.phi]))[0][0, 11:17]
    s[row.joined, chain.X], s[row.joined, chain.Y] = c.x, c.y
    s[:, chain.TORQUE] = path.rigidity(row.way) * c.phi
    marks = np.array([row.joined, row.joined, np.zeros(n, bool)])
    return State(c.phi, s, 0 * s, 0 * s, marks, np.zeros(n), s[:, chain.TORQUE] * c.phi / 2)


def _advance(row: Row, phi: float, last: State, before: State | None) -> State | None:
    """Take one step; None where no state was found."""
    h = phi - last.phi
    step, guess = Step(False, 1.0, -1.0, 0.0, h), last.s + h * last.rate + h * h / 2 * last.bow
    states = np.stack([guess, last.s, last.s])
    if before is None:
        # the endless beam sets out much as the row does
        near = row.way.states(np.array([phi]))[0][0]
        if math.isfinite(near[1]):
            guess[:, :6] = near[11:17]
            guess[row.joined, chain.X : chain.Y + 1] = near[4:6]
    elif (before.marks == last.marks).all():
        q = h / (last.phi - before.phi)
        step = Step(False, (1 + 2 * q) / (1 + q), -(1 + q), q * q / (1 + q), h)
        states[2] = before.s
    marks, changed = last.marks.copy(), np.zeros((2, row.scales), int)
    while changed.max() < 2:
        states[0] = guess
        if not _newton(row, phi, step, states, marks):
            return None
        s = states[0]
        closing = row.joined & (s[:, chain.GAP] < -OPEN) & ~_off(row, s).any(axis=0)
        closed = np.where(marks[1], s[:, chain.NORMAL] >= 0, closing)
        down = np.where(marks[2], s[:, chain.Q] >= 0, s[:, chain.THETA] < -OPEN)
        changes = np.array([closed, down]) != marks[1:]
        if not changes.any():
            return _accepted(step, states, marks, last, before)
        changed += changes
        marks = np.array([row.joined, closed, down])
        guess[~closed, chain.F : chain.C1 + 1] = 0.0
    return None


def _newton(row: Row, phi: float, step: Step, states: Array, marks: Array) -> bool:
    """Solve for the new one of the states (3, n, 32) at a twist from its guess; whether it was found."""
    n, beam = row.scales, row.beam
    r, band = np.empty((n, chain.UNKNOWNS)), np.empty((2 * chain.REACH + 1, n * chain.UNKNOWNS))
    for _ in range(ROUNDS):
        entry.row(*beam, phi, step, states, marks, r, band)
        try:
            change = solve_banded((chain.REACH, chain.REACH), band, r.ravel(), check_finite=False)
        except (LinAlgError, ValueError):
            return False
        size = np.abs(change).max()
        if not size < 1.0:
            return False
        states[0, :, : chain.UNKNOWNS] -= change.reshape(r.shape)
        if size < min(TIGHT, _SHARP * step.dphi):
            entry.row(*beam, phi, step, states, marks, r, band[:0])
            return True
    return False


def _accepted(step: Step, states: Array, marks: Array, last: State, before: State | None) -> State:
    """Return the state to which a step has come."""
    s, h = states[0].copy(), step.dphi
    rate = (step.b0 * s + step.b1 * states[1] + step.b2 * states[2]) / h
    bow = 0 * rate if before is None else (rate - last.rate) / h
    rubbing = np.where(marks[1], s[:, chain.RUBBED], 0.0)
    was = rubbing
    if before is not None:
        was = np.where(last.marks[1], last.s[:, chain.RUBBED], 0.0) * h / (last.phi - before.phi)
    work = last.work + h * (last.s[:, chain.TORQUE] + s[:, chain.TORQUE]) / 2
    return State(last.phi + h, s, rate, bow, marks, last.rubbed + (was + rubbing) / 2, work)


def _off(row: Row, s: Array) -> Array:
    """Say which contacts (2, n) are off the first and the second edge."""
    places = s[:, chain.X : chain.Y + 1].T
    return np.asarray((places < row.edges[:, :1]) | (places > row.edges[:, 1:]))


def _problem(row: Row, where: Array, state: State) -> tuple[int, int, int, int] | None:
    """Return what ends the row at a state: end, scale, edge, neighbour; None if nothing does."""
    off = _off(row, state.s) & state.marks[1]
    if off.any():
        which, i = np.argwhere(off)[0]
        return (changes.OFF_SECOND if which else changes.OFF_FIRST), int(row.order[i]), -1, 0
    edge, scale, k = entry.beside(*row.beam, state.phi, state.s, row.joined, where)
    return (changes.OTHER, scale, edge, k) if edge >= 0 else None


def _write(row: Row, state: State, out: Array, sides: Array, held: Array) -> None:
    """Write a state, see :class:`Track`."""
    s, (_, closed, down) = state.s, state.marks
    pressed, o = np.append(False, closed[:-1]), row.order
    out[:] = 0.0
    out[:, 0] = state.phi
    out[o, 1:4] = s[:, [chain.TORQUE, chain.NORMAL, chain.FRICTION]]
    out[o, 4], sides[o] = np.where(closed, s[:, [chain.X, chain.Y]].T, np.nan)
    out[o, 5] = np.where(pressed, np.roll(s[:, chain.Y], 1), np.nan)
    out[o, 6:8] = s[:, chain.C1 : chain.C2 + 1]
    out[o, 8], out[o, 9], held[o] = state.rubbed, state.work, np.where(down, s[:, chain.Q], 0.0)
    out[o, 11:17] = s[:, :6]

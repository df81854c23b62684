"""A path of the twist, followed step by step: free, slipping, sticking, and its end by name; compiled."""

from __future__ import annotations

import math
from typing import NamedTuple

import numba
import numpy as np

from squama.real.contact import (
    AT, BEFORE, BENT, BOW, FORCE, FRICTION, LAST, MOST, NEW, NORMAL, PHI, SHAPE, SLIDING, SLOPE, SPEED, STATES, TORQUE,
    WIDTH, Design, Step, _in, _jit, add, back, frame, high, lengthwise, low, mixed, place, powers, rotated, scaled, turn,
    turned,
)  # fmt: skip
from squama.real.steps import free_rates, rates_engaging, rates_sliding, solve
from squama.types import Array

FREE, SLIP, STICK = range(3)
RANGE, OFF_FIRST, OFF_SECOND, OTHER, STOPPED, PARTED, NONE = range(7)
"""Ends by number."""
COLUMNS = (
    "phi",
    "T",
    "N",
    "f",
    "x",
    "y",
    "c1",
    "c2",
    "W_fr",
    "W",
    "mode",
    "u_X",
    "u_Y",
    "u_Z",
    "w_X",
    "w_Y",
    "w_Z",
    "eps",
)
"""What is written of each point."""
_LEAST, _SMALLEST, _HELD = 1e-7, 1e-15, 1e-7
_START, _SOFTLY, _GENTLE = 1 / 16, 1 / 8, 1e-5
"""First steps at engagement, when a contact begins to slide, and to stick; shares of the largest step."""
_TOUCH = -1e-6
_ALONG, _ACROSS = 16, 8
"""Places that are looked at along the length and the width."""


class End(NamedTuple):
    """How a path ended: number, twist, edge and neighbour of another contact (+4: an edge of the other scale)."""

    code: int
    phi: float
    edge: int
    k: int
    solved: int


@_in
def bulge(d: Design, b: Array, x: float, y: float) -> float:
    """Return the deflection at a place of the plate by its coefficients (24,)."""
    X, Y, w = x / d.eta, y / d.beta, 0.0
    for m in range(5, -1, -1):
        row = b[4 * m] + Y * (b[4 * m + 1] + Y * (b[4 * m + 2] + Y * b[4 * m + 3]))
        w = w * X + row
    return w * X * X


@_jit
def shape(d: Design, s: Array, out: Array) -> None:
    """Write the coefficients (24,) of the plate's deflection in a state."""
    out[:] = 0.0
    if d.elastic:
        g, m = np.empty(12), d.motions
        powers(d, d.first, s[AT], g, 0)
        powers(d, d.second, s[AT + 1], g, 6)
        for i in range(24):
            for j in range(6):
                out[i] += d.table[SHAPE + i, j] * g[j] * s[m + 3] + d.table[SHAPE + i, 6 + j] * g[6 + j] * s[m + 4]


@_jit
def others(d: Design, q: Array, phi: float, b: Array) -> tuple[float, int, int]:
    """Return how deep edges lie in a neighbour's face, the deepest one's edge and neighbour; 0 if none does.

    Places along the edges of scale 1's lower face are looked at over the upper faces of the others, and the edges of
    their upper faces under scale 1's lower face.
    """
    u, e, inverse = (q[0], q[1], q[2]), turned((q[3], q[4], q[5])), turned((-q[3], -q[4], -q[5]))
    deepest, edge_of, k_of = _TOUCH, -1, 0
    reach = max(1, int(math.hypot(d.eta, 2 * d.beta)))
    for k in range(1, reach + 1):
        f = frame(d, phi, k)
        home, step = add(u, 1.0, f.o), scaled(k * (1 + q[6]), f.z)
        for upper in range(2):
            # a place X of the one scale in the axes of the other: origin + X_x ex + X_y ey + X_z ez
            there = add(turn(f, home), 1.0, step) if upper else back(f, add(home, -1.0, step))
            o = rotated(inverse, add(there, -1.0, home))
            ex = rotated(e, (1.0, 0.0, 0.0))
            ey = rotated(e, (0.0, 1.0, 0.0))
            ez = rotated(e, (0.0, 0.0, 1.0))
            ex = rotated(inverse, turn(f, ex) if upper else back(f, ex))
            ey = rotated(inverse, turn(f, ey) if upper else back(f, ey))
            ez = rotated(inverse, turn(f, ez) if upper else back(f, ez))
            half = d.h / 2 if upper else -d.h / 2
            for edge in range(4):
                n = _ALONG if lengthwise(edge) else _ACROSS
                for i in range(n + 1):
                    at = place(d, edge, low(d, edge) + (high(d, edge) - low(d, edge)) * i / n, 0.0)
                    lift = half + (bulge(d, b, at[0], at[1]) if d.elastic else 0.0)
                    p = add(mixed(at[0], ex, at[1], ey, lift, ez), 1.0, o)
                    if 0.0 < p[0] < d.eta and -d.beta < p[1] < d.beta:
                        face = half - p[2] + (bulge(d, b, p[0], p[1]) if d.elastic else 0.0)
                        # the face of the other scale is its lower one where edges of upper faces are looked at
                        height = face - d.h if upper else -face - d.h
                        if height < deepest:
                            deepest, edge_of, k_of = height, edge + 4 * upper, k
    return (deepest, edge_of, k_of) if edge_of >= 0 else (0.0, -1, 0)


@_jit
def write(d: Design, s: Array, mode: int, rubbed: float, work: float, out: Array) -> None:
    """Write a row of :data:`COLUMNS`."""
    m = d.motions
    out[0], out[1], out[2], out[3] = s[PHI], s[TORQUE], s[NORMAL], s[FRICTION]
    out[4], out[5], out[6], out[7] = s[AT], s[AT + 1], s[m + 3], s[m + 4]
    out[8], out[9], out[10] = rubbed, work, mode
    out[11:18] = 0.0
    out[11 : 11 + m] = s[:m]
    if not d.elastic:
        out[6] = out[7] = 0.0


@_jit
def at_rest(d: Design, rates: Array, phi: float, s: Array) -> None:
    """Write the state without contact."""
    m = d.motions
    s[:] = 0.0
    s[:m] = rates[:m] * phi
    s[AT] = s[AT + 1] = np.nan
    s[PHI], s[TORQUE] = phi, d.table[7, 7] * phi
    for j in range(m):
        s[TORQUE] += d.table[7, j] * s[j]


@_jit
def beyond(d: Design, s: Array, b: Array, look: bool) -> tuple[int, int, int]:
    """Return why a state is no longer of this one contact: end, edge, neighbour; -1 if it is."""
    x, y = s[AT], s[AT + 1]
    if not low(d, d.first) <= x <= high(d, d.first):
        return OFF_FIRST, d.first, d.k
    if not low(d, d.second) <= y <= high(d, d.second):
        return OFF_SECOND, d.second, d.k
    if look:
        q = np.zeros(7)
        q[: d.motions] = s[: d.motions]
        shape(d, s, b)
        _, edge, k = others(d, q, s[PHI], b)
        if edge >= 0:
            return OTHER, edge, k
    return -1, -1, 0


@_jit
def guess(d: Design, now: Step, size: float, ratio: float, fresh: bool, room: Array, J: Array, order: Array) -> bool:
    """Write a guess of the new state after a step, ``ratio`` times as large as the last one; False if there is none."""
    last, new, m, n = room[LAST], room[NEW], d.motions, d.motions + 5
    new[SLIDING : SLIDING + 3] = last[SLIDING : SLIDING + 3]
    if not fresh:
        for j in range(n):
            bow = (size + size / ratio) * room[BOW, j]
            new[j] = last[j] + ratio * (last[j] - room[BEFORE, j] + bow)
        return True
    if now.stuck:
        last[m : m + 3] = last[FORCE : FORCE + 3]
        new[:] = last
        return True
    last[m], last[m + 1], last[m + 2] = last[AT], last[AT + 1], last[NORMAL]
    way = math.copysign(1.0, now.dphi)
    possible = rates_sliding(d, way, room, J, order) if last[NORMAL] > 0.0 else rates_engaging(d, way, room)
    for j in range(n):
        new[j] = last[j] + size * new[j]
    return possible


@_in
def turned_by(a: Array, b: Array) -> float:
    """Return the cosine between the directions of slip of two states; 0 where one has none."""
    i = SLIDING
    return a[i] * b[i] + a[i + 1] * b[i + 1] + a[i + 2] * b[i + 2]


@_jit
def accept(room: Array, size: float, before: float, fresh: bool) -> None:
    """Make the new state the last one, after a step that followed one of the size ``before``."""
    for j in range(MOST):
        slope = (room[NEW, j] - room[LAST, j]) / size
        room[BOW, j] = 0.0 if fresh else (slope - room[SLOPE, j]) / (size + before) * size
        room[SLOPE, j] = slope
    room[BEFORE] = room[LAST]
    room[LAST] = room[NEW]


@_jit
def follow(
    d: Design, start: tuple[float, float, float], targets: Array, step: float, every: int, out: Array
) -> End:  # fmt: skip
    """Follow the twist to targets (n,), one after the other, from rest; rows of ``out`` (n, 18) not reached stay.

    ``start``: twist and places at engagement; ``step``: largest increment; other contacts are looked for at every so
    many steps.
    """
    room, J, order, b = np.zeros((STATES, WIDTH)), np.empty((MOST, MOST)), np.zeros(MOST, np.int64), np.zeros(24)
    last, new, rates = room[LAST], room[NEW], free_rates(d)
    at_rest(d, rates, 0.0, last)
    mode, fresh, known, closing, rubbed, work, way, count = FREE, True, False, False, 0.0, 0.0, 1.0, 0
    h, h_last, narrow, bold = step, step, math.inf, False
    for i in range(targets.size):
        goal = targets[i]
        if goal != last[PHI]:
            towards = 1.0 if goal > last[PHI] else -1.0
            if mode != FREE and towards != way and d.mu > 0.0:
                mode, fresh, known, h, narrow, closing = STICK, True, False, step * _GENTLE, math.inf, False
            way = towards
        while last[PHI] != goal:
            phi = last[PHI]
            if mode == FREE:
                before = last[TORQUE]
                at_rest(d, rates, goal, last)
                if way > 0 and phi < start[0] <= goal:
                    at_rest(d, rates, start[0], last)
                work += (before + last[TORQUE]) / 2 * (last[PHI] - phi)
                if way > 0 and phi < start[0] <= goal:
                    last[AT], last[AT + 1] = start[1], start[2]
                    mode, fresh, known, h, narrow, closing = SLIP, True, False, step * _START, math.inf, False
                continue
            left = abs(goal - phi)
            size = left / math.ceil(left / h * (1 - 1e-9))
            to, ratio = phi + way * size, size / h_last
            if size > left * (1 - 1e-9):
                to = goal
            b0, b1, b2 = (1 + 2 * ratio) / (1 + ratio), -(1 + ratio), ratio * ratio / (1 + ratio)
            if fresh:
                b0, b1, b2 = 1.0, -1.0, 0.0
            now = Step(mode == STICK, b0, b1, b2, to - phi)
            found, code, edge, k = guess(d, now, size, ratio, fresh, room, J, order), STOPPED, -1, 0
            if found:
                found, known = solve(d, to, now, room, J, order, known)
            # friction that turns round within a step is no solution: the contact would stick first
            found = found and (mode == STICK or turned_by(last, new) >= 0.0)
            if found and new[NORMAL] < 0.0:
                code = PARTED
                if way < 0.0:
                    # it opens where it closed: nothing but the twist holds the scales there
                    rubbed += last[FRICTION] * last[SPEED] / 2 * max(0.0, phi - start[0])
                    before = last[TORQUE]
                    at_rest(d, rates, min(phi, start[0]), last)
                    work += (before + last[TORQUE]) / 2 * (last[PHI] - phi)
                    mode, fresh = FREE, True
                    continue
            elif found:
                code, edge, k = beyond(d, new, b, count % every == 0 or narrow < math.inf)
                held = d.mu * new[NORMAL] - new[FRICTION]
                if code < 0 and mode == STICK and held < _HELD * new[NORMAL] and (held < 0.0 or closing):
                    if abs(held) < _HELD * new[NORMAL] or size < _SMALLEST:
                        work += (last[TORQUE] + new[TORQUE]) / 2 * (to - phi)
                        accept(room, size, h_last, fresh)
                        # the slip's direction turns quickly at first
                        mode, fresh, known, h, closing = SLIP, True, False, step * _SOFTLY, False
                    else:
                        # what holds falls almost linearly
                        before = d.mu * last[NORMAL] - last[FRICTION]
                        share = before / (before - held) if before > _HELD * last[NORMAL] else 0.5
                        h, closing = size * min(0.9, max(0.1, share)) if not closing else size * share, True
                    continue
            if code >= 0:
                h, narrow, known = size / 2, narrow if code == STOPPED else size, False
                if h < _LEAST:
                    if not (fresh and mode == SLIP and code == STOPPED and not bold and phi != start[0]):
                        return End(code, phi, edge, k, i)
                    # the slip's direction turns quickly where it sets out: a larger step may find where it turns to
                    bold, h, narrow = True, step, math.inf
                continue
            count += 1
            if mode == SLIP:
                rubbed += (last[FRICTION] * (new if fresh else last)[SPEED] + new[FRICTION] * new[SPEED]) / 2 * size
            work += (last[TORQUE] + new[TORQUE]) / 2 * (to - phi)
            accept(room, size, h_last, fresh)
            h_last, fresh, bold, narrow = size, False, False, narrow - size
            h = min(step, 2 * size) if not closing else size
            if narrow < 2 * _LEAST:
                narrow = math.inf
            elif narrow < math.inf:
                h = min(h, narrow / 2)
        write(d, last, mode, rubbed, work, out[i])
    return End(RANGE, last[PHI], -1, 0, targets.size)

"""A path of the twist, followed step by step: free, slipping, sticking, and its end by name; compiled."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from squama.real.contact import (
    AT,
    BEFORE,
    BOW,
    FORCE,
    FRICTION,
    LAST,
    MOST,
    MOTIONS,
    NEW,
    NORMAL,
    PHI,
    SHAPE,
    SLIDING,
    SLOPE,
    SPEED,
    STATES,
    TALLY,
    TORQUE,
    WIDTH,
    Design,
    Frame,
    Step,
    _in,
    _jit,
    add,
    back,
    frame,
    high,
    lengthwise,
    low,
    mixed,
    place,
    powers,
    rotated,
    scaled,
    turn,
    turned,
)  # fmt: skip
from squama.real.steps import free_rates, rates_engaging, rates_sliding, solve
from squama.types import Array

FREE, SLIP, STICK = range(3)
RANGE, OFF_FIRST, OFF_SECOND, OTHER, STOPPED, PARTED = range(6)
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
)
"""What is written of each point."""
_LEAST, _SMALLEST, _HELD = 1e-7, 1e-15, 1e-7
_START, _SOFTLY, _GENTLE = 1 / 16, 1 / 8, 1e-5
"""First steps at engagement, when a contact begins to slide, and to stick; shares of the largest step."""
_TOUCH, _MISSES = -1e-6, 400
MODE, FRESH, KNOWN, CLOSING, BOLD, H, SIZE, NARROW, MISSES, RUBBED, WORK, WAY, COUNT = range(13)
"""What is counted along a path: the mode; whether it just began, the Jacobian may be kept, a slide is being located, a
bold step was tried; next and last step, distance to what ends the path; steps refused; frictional work, work of the
torque; sense of the twist; steps."""
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
def shape(d: Design, x: float, y: float, c1: float, c2: float, out: Array) -> None:
    """Write the coefficients (24,) of a plate's deflection under forces at places on its two edges."""
    out[:] = 0.0
    if d.elastic:
        g = np.empty(12)
        powers(d, d.first, x, g, 0)
        powers(d, d.second, y, g, 6)
        for i in range(24):
            for j in range(6):
                out[i] += d.table[SHAPE + i, j] * g[j] * c1 + d.table[SHAPE + i, 6 + j] * g[6 + j] * c2


@_jit
def overlap(d: Design, f: Frame, k: int, q: Array, b: Array, p: Array, c: Array) -> tuple[float, int]:
    """Return how deep edges of a scale and of its neighbour k lie in each other's face, and the deepest one's edge.

    ``q``, ``p`` begin with the motions (6,), ``b``, ``c`` are the deflections (24,) of the scale and of the neighbour.
    Places along the edges of the scale's lower face are looked at over the neighbour's upper face, and the edges of
    that (+ 4) under the scale's lower face. The edge is -1 where nothing touches.
    """
    deepest, edge_of = _TOUCH, -1
    u, v, step = (q[0], q[1], q[2]), (p[0], p[1], p[2]), scaled(k, f.z)
    for upper in range(2):
        # a place X of the one scale in the axes of the other: origin + X_x ex + X_y ey + X_z ez
        home, away = add(v if upper else u, 1.0, f.o), add(u if upper else v, 1.0, f.o)
        own = p if upper else q
        other = q if upper else p
        e, inverse = turned((own[3], own[4], own[5])), turned((-other[3], -other[4], -other[5]))
        there = add(turn(f, home), 1.0, step) if upper else back(f, add(home, -1.0, step))
        o = rotated(inverse, add(there, -1.0, away))
        ex = rotated(e, (1.0, 0.0, 0.0))
        ey = rotated(e, (0.0, 1.0, 0.0))
        ez = rotated(e, (0.0, 0.0, 1.0))
        ex = rotated(inverse, turn(f, ex) if upper else back(f, ex))
        ey = rotated(inverse, turn(f, ey) if upper else back(f, ey))
        ez = rotated(inverse, turn(f, ez) if upper else back(f, ez))
        half = d.h / 2 if upper else -d.h / 2
        lifts, faces = (c, b) if upper else (b, c)
        for edge in range(4):
            n = _ALONG if lengthwise(edge) else _ACROSS
            for i in range(n + 1):
                at = place(d, edge, low(d, edge) + (high(d, edge) - low(d, edge)) * i / n, 0.0)
                lift = half + (bulge(d, lifts, at[0], at[1]) if d.elastic else 0.0)
                x = add(mixed(at[0], ex, at[1], ey, lift, ez), 1.0, o)
                if 0.0 < x[0] < d.eta and -d.beta < x[1] < d.beta:
                    face = half - x[2] + (bulge(d, faces, x[0], x[1]) if d.elastic else 0.0)
                    # the face of the other scale is its lower one where edges of upper faces are looked at
                    height = face - d.h if upper else -face - d.h
                    if height < deepest:
                        deepest, edge_of = height, edge + 4 * upper
    return (deepest, edge_of) if edge_of >= 0 else (0.0, -1)


@_jit
def others(d: Design, q: Array, phi: float, b: Array) -> tuple[float, int, int]:
    """Return how deep edges lie in a neighbour's face, the deepest one's edge and neighbour (:func:`overlap`)."""
    deepest, edge_of, k_of = 0.0, -1, 0
    for k in range(1, reach(d) + 1):
        deep, edge = overlap(d, frame(d, phi, k), k, q, b, q, b)
        if deep < deepest:
            deepest, edge_of, k_of = deep, edge, k
    return deepest, edge_of, k_of


@_in
def reach(d: Design) -> int:
    """Return the farthest neighbour that plates may meet."""
    return max(1, int(math.hypot(d.eta, 2 * d.beta)))


@_jit
def write(d: Design, s: Array, tally: Array, out: Array) -> None:
    """Write a row of :data:`COLUMNS`."""
    m = MOTIONS
    out[0], out[1], out[2], out[3] = s[PHI], s[TORQUE], s[NORMAL], s[FRICTION]
    out[4], out[5], out[6], out[7] = s[AT], s[AT + 1], s[m + 3], s[m + 4]
    out[8], out[9], out[10] = tally[RUBBED], tally[WORK], tally[MODE]
    out[11:17] = s[:m]
    if not d.elastic:
        out[6] = out[7] = 0.0


@_jit
def at_rest(d: Design, rates: Array, phi: float, s: Array) -> None:
    """Write the state without contact."""
    m = MOTIONS
    s[:] = 0.0
    s[:m] = rates[:m] * phi
    s[AT] = s[AT + 1] = np.nan
    s[PHI], s[TORQUE] = phi, d.table[6, 6] * phi
    for j in range(m):
        s[TORQUE] += d.table[6, j] * s[j]


@_jit
def beyond(d: Design, s: Array, b: Array, look: bool) -> tuple[int, int, int]:
    """Return why a state is no longer of this one contact: end, edge, neighbour; -1 if it is."""
    x, y = s[AT], s[AT + 1]
    if not low(d, d.first) <= x <= high(d, d.first):
        return OFF_FIRST, d.first, d.k
    if not low(d, d.second) <= y <= high(d, d.second):
        return OFF_SECOND, d.second, d.k
    if look:
        shape(d, x, y, s[MOTIONS + 3], s[MOTIONS + 4], b)
        _, edge, k = others(d, s, s[PHI], b)
        if edge >= 0:
            return OTHER, edge, k
    return -1, -1, 0


@_jit
def guess(d: Design, now: Step, size: float, room: Array, J: Array, order: Array) -> bool:
    """Write a guess of the new state after a step; False if there is none."""
    last, new, tally, m, n = room[LAST], room[NEW], room[TALLY], MOTIONS, MOTIONS + 5
    new[SLIDING : SLIDING + 3] = last[SLIDING : SLIDING + 3]
    if tally[FRESH] == 0.0:
        ratio = size / tally[SIZE]
        for j in range(n):
            bow = (size + tally[SIZE]) * room[BOW, j]
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


@_jit
def accept(room: Array, size: float) -> None:
    """Make the new state the last one, after a step of a size."""
    last, new, tally = room[LAST], room[NEW], room[TALLY]
    fresh = tally[FRESH] > 0.0
    for j in range(MOST):
        slope = (new[j] - last[j]) / size
        room[BOW, j] = 0.0 if fresh else (slope - room[SLOPE, j]) / (size + tally[SIZE]) * size
        room[SLOPE, j] = slope
    if tally[MODE] == SLIP:
        before = new[SPEED] if fresh else last[SPEED]
        tally[RUBBED] += (last[FRICTION] * before + new[FRICTION] * new[SPEED]) / 2 * size
    tally[WORK] += (last[TORQUE] + new[TORQUE]) / 2 * (new[PHI] - last[PHI])
    tally[SIZE], tally[FRESH] = size, 0.0
    room[BEFORE] = last
    room[LAST] = new


@_in
def begin(tally: Array, mode: int, h: float) -> None:
    """Go on in a mode with a first step."""
    tally[MODE], tally[FRESH], tally[KNOWN], tally[H] = mode, 1.0, 0.0, h
    tally[NARROW], tally[CLOSING] = math.inf, 0.0


@_jit
def advance(d: Design, rates: Array, start: tuple[float, float, float], goal: float, step: float, room: Array) -> None:
    """Go on without contact, to the goal or to engagement."""
    last, tally = room[LAST], room[TALLY]
    phi, before = last[PHI], last[TORQUE]
    engages = phi < start[0] <= goal
    at_rest(d, rates, start[0] if engages else goal, last)
    tally[WORK] += (before + last[TORQUE]) / 2 * (last[PHI] - phi)
    if engages:
        last[AT], last[AT + 1] = start[1], start[2]
        begin(tally, SLIP, step * _START)


@_jit
def attempt(
    d: Design, to: float, size: float, every: int, room: Array, J: Array, order: Array, b: Array
) -> tuple[int, int, int]:  # fmt: skip
    """Solve for the state at a twist; return why it is not of this contact (end, edge, neighbour), -1 if it is."""
    last, new, tally = room[LAST], room[NEW], room[TALLY]
    b0, b1, b2, ratio = 1.0, -1.0, 0.0, size / tally[SIZE]
    if tally[FRESH] == 0.0:
        b0, b1, b2 = (1 + 2 * ratio) / (1 + ratio), -(1 + ratio), ratio * ratio / (1 + ratio)
    now = Step(tally[MODE] == STICK, b0, b1, b2, to - last[PHI])
    if not guess(d, now, size, room, J, order):
        return STOPPED, -1, 0
    found, known = solve(d, to, now, room, J, order, tally[KNOWN] > 0.0)
    tally[KNOWN] = 1.0 if known else 0.0
    i = SLIDING
    # friction that turns round within a step is no solution: the contact would stick first
    turns = last[i] * new[i] + last[i + 1] * new[i + 1] + last[i + 2] * new[i + 2] < 0.0
    if not found or (turns and d.mu > 0.0 and not now.stuck):
        return STOPPED, -1, 0
    if new[NORMAL] < 0.0:
        return PARTED, -1, 0
    return beyond(d, new, b, tally[COUNT] % every == 0 or tally[NARROW] < math.inf)


@_jit
def slides(d: Design, size: float, step: float, room: Array) -> bool:
    """Say whether friction no longer holds the new state; go nearer to where it gives way, or on from there."""
    last, new, tally = room[LAST], room[NEW], room[TALLY]
    held, least = d.mu * new[NORMAL] - new[FRICTION], _HELD * new[NORMAL]
    if held >= least or (held >= 0.0 and tally[CLOSING] == 0.0):
        return False
    if abs(held) < least or size < _SMALLEST:
        accept(room, size)
        begin(tally, SLIP, step * _SOFTLY)
        return True
    # what holds falls almost linearly
    before = d.mu * last[NORMAL] - last[FRICTION]
    share = before / (before - held) if before > _HELD * last[NORMAL] else 0.5
    tally[H] = size * (share if tally[CLOSING] > 0.0 else min(0.9, max(0.1, share)))
    tally[CLOSING] = 1.0
    return True


@_jit
def opens(d: Design, rates: Array, engaged: float, room: Array) -> None:
    """Let go where the contact closed: nothing but the twist holds the scales there."""
    last, tally = room[LAST], room[TALLY]
    phi, before = last[PHI], last[TORQUE]
    tally[RUBBED] += last[FRICTION] * last[SPEED] / 2 * max(0.0, phi - engaged)
    at_rest(d, rates, min(phi, engaged), last)
    tally[WORK] += (before + last[TORQUE]) / 2 * (last[PHI] - phi)
    begin(tally, FREE, tally[H])


@_jit
def refused(code: int, size: float, step: float, engaged: float, room: Array) -> bool:
    """Take a smaller step after one that was refused; True where there is none."""
    tally = room[TALLY]
    tally[H], tally[KNOWN] = size / 2, 0.0
    tally[MISSES] += 1.0
    if code != STOPPED:
        tally[NARROW] = size
    if tally[H] >= _LEAST and tally[MISSES] <= _MISSES:
        return False
    again = tally[FRESH] > 0.0 and tally[MODE] == SLIP and code == STOPPED and room[LAST, PHI] != engaged
    if tally[MISSES] > _MISSES or not again or tally[BOLD] > 0.0:
        return True
    # the slip's direction turns quickly where it sets out: a larger step may find where it turns to
    tally[BOLD], tally[H], tally[NARROW] = 1.0, step, math.inf
    return False


@_jit
def onward(size: float, step: float, room: Array) -> None:
    """Accept a step and choose the next one."""
    tally = room[TALLY]
    accept(room, size)
    tally[COUNT] += 1.0
    tally[BOLD] = 0.0
    tally[NARROW] -= size
    tally[H] = size if tally[CLOSING] > 0.0 else min(step, 2 * size)
    if tally[NARROW] < 2 * _LEAST:
        tally[NARROW] = math.inf
    elif tally[NARROW] < math.inf:
        tally[H] = min(tally[H], tally[NARROW] / 2)


@_jit
def follow(
    d: Design, start: tuple[float, float, float], targets: Array, step: float, every: int, out: Array
) -> End:  # fmt: skip
    """Follow the twist to targets (n,), one after the other, from rest; rows of ``out`` (n, 17) not reached stay.

    ``start``: twist and places at engagement; ``step``: largest increment; other contacts are looked for at every so
    many steps.
    """
    room, J, order, b = np.zeros((STATES, WIDTH)), np.empty((MOST, MOST)), np.zeros(MOST, np.int64), np.zeros(24)
    last, tally, rates = room[LAST], room[TALLY], free_rates(d)
    at_rest(d, rates, 0.0, last)
    begin(tally, FREE, step)
    tally[SIZE], tally[WAY] = step, 1.0
    for i in range(targets.size):
        goal = targets[i]
        if goal != last[PHI]:
            way = 1.0 if goal > last[PHI] else -1.0
            if tally[MODE] != FREE and way != tally[WAY] and d.mu > 0.0:
                begin(tally, STICK, step * _GENTLE)
            tally[WAY] = way
        while last[PHI] != goal:
            if tally[MODE] == FREE:
                advance(d, rates, start, goal, step, room)
                continue
            left = abs(goal - last[PHI])
            size = left / math.ceil(left / tally[H] * (1 - 1e-9))
            to = goal if size > left * (1 - 1e-9) else last[PHI] + tally[WAY] * size
            code, edge, k = attempt(d, to, size, every, room, J, order, b)
            if code == PARTED and tally[WAY] < 0.0:
                opens(d, rates, start[0], room)
            elif code >= 0:
                if refused(code, size, step, start[0], room):
                    return End(code, last[PHI], edge, k, i)
            elif tally[MODE] != STICK or not slides(d, size, step, room):
                onward(size, step, room)
        write(d, last, tally, out[i])
    return End(RANGE, last[PHI], -1, 0, targets.size)

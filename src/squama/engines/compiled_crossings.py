"""Where another neighbour's tip-side contact comes in, in lock-step, as :mod:`squama.model.neighbours` finds it."""

from __future__ import annotations

import math

from squama.engines import compiled_lanes as lanes
from squama.engines import compiled_lines as others
from squama.engines.compiled_ends import LEFT
from squama.engines.compiled_kernel import compiled, inlined
from squama.engines.compiled_lanes import (
    BEST,
    CODE,
    FA,
    FB,
    FC,
    LOW,
    OK,
    P1,
    P2,
    REACH,
    S0,
    X0,
    X_END,
    A,
    B,
    C,
    K,
    W,
    X,
)  # fmt: skip
from squama.model.neighbours import AWAY, CLEAR, FOLDED_CLEAR, FOLDED_SAMPLES, NEAR, SAMPLES
from squama.model.solve import Array

FAR = 32
"""Neighbours that are looked for here; designs that reach farther are left to the numpy engine."""


@compiled
def _many(w: Array) -> int:
    far = 1.0
    for i in range(W):
        far = max(far, min(w[REACH + i], float(FAR)))
    return int(far)


@compiled
def _walk(w: Array, part: float, folded: bool) -> None:
    """Terms of the contact conditions at a fraction of the path."""
    for i in range(W):
        w[X + i] = w[X0 + i] + (w[X_END + i] - w[X0 + i]) * part
    others.lines(w, folded)
    for i in range(W):
        w[lanes.COSJ + i], w[lanes.SINJ + i] = w[lanes.COS + i], w[lanes.SIN + i]


@compiled
def _next(w: Array) -> int:
    """First neighbour to look for: 2 where all follow the next one."""
    near = 0
    for i in range(W):
        near += 1 if w[K + i] == 1 else 0
    if near < W:
        return 1
    for i in range(W):
        others.line(w, i, 1.0)
    return 2


@compiled
def _copy(to: Array, low: int, of: Array, start: int) -> None:
    a, b = to[low : low + W], of[start : start + W]
    for i in range(W):
        a[i] = b[i]


@compiled
def clear(w: Array, folded: bool) -> None:
    """OK = 1 where no other neighbour comes near: the contact conditions stay below zero by more than they bend.

    Only paths that follow the next neighbour and reach few others are looked at, the rest is not clear.
    """
    samples, many = FOLDED_CLEAR if folded else CLEAR, 1.0
    for i in range(W):
        mine = (w[REACH + i] < NEAR) & (w[K + i] == 1)
        w[OK + i], w[lanes.SPAN + i] = 1.0 if mine else 0.0, w[X_END + i] - w[X0 + i]
        many = max(many, w[REACH + i] if mine else 1.0)
    if many < 2:
        return
    for s in range(samples):
        lanes.roots_at(w, s / (samples - 1), folded)
        others.start_lines(w)
        for i in range(W):
            # how far the tip reaches at the three samples
            far = others.reach_here(w, i)
            w[S0 + i] = max(far, w[P1 + i], w[P2 + i])
            w[P2 + i], w[P1 + i] = w[P1 + i], far
        _away(w, 2.0, lanes.PAST, s)
        if many >= 3:
            _away(w, 3.0, lanes.PAST + 2 * W, s)
        if many >= 4:
            _away(w, 4.0, lanes.PAST + 4 * W, s)
        if many >= 5:
            _away(w, 5.0, lanes.PAST + 6 * W, s)
        if many >= 6:
            _away(w, 6.0, lanes.PAST + 8 * W, s)


@inlined
def _away(w: Array, j: float, past: int, s: int) -> None:
    """Keep OK where neighbour j stays away at sample s and before."""
    for i in range(W):
        now, before, last = others.line(w, i, j), w[past + i], w[past + W + i]
        w[past + i], w[past + W + i] = now, before
        high = max(now, before, last)
        away = (high < -AWAY * abs(now - 2 * before + last)) | (s < 2) | (w[S0 + i] < j)
        w[OK + i] = w[OK + i] if away else 0.0


@compiled
def crossings(w: Array, h: Array, events: Array, index: Array, start: int, count: int, found: int, folded: bool) -> int:
    """Note every sample after which another neighbour's lines cross, at the samples of ``neighbours.first_crossing``.

    Rows of ``events``: design, neighbour, sample before. Returns how many are noted; where there is no more room, or
    a tip reaches farther than neighbour FAR, the design is LEFT.
    """
    samples, many = FOLDED_SAMPLES if folded else SAMPLES, _many(w)
    for i in range(W):
        w[CODE + i] = LEFT if w[REACH + i] > FAR else w[CODE + i]
    for s in range(samples):
        _walk(w, s / (samples - 1), folded)
        for n in range(_next(w), many + 1):
            j, rising = float(n), 0
            _copy(w, P1, h, n * W)
            for i in range(W):
                now, far = others.line(w, i, j), max(w[lanes.HERE + i], w[lanes.BEFORE + i])
                up = (now >= 0) & (not w[P1 + i] >= 0) & (j <= far) & (j != w[K + i])
                w[S0 + i] = now
                w[OK + i] = 1.0 if up else 0.0
                rising += 1 if up else 0
            _copy(h, n * W, w, S0)
            if (s > 0) & (rising > 0):
                for i in range(count):
                    if w[OK + i] > 0:
                        if found == events.shape[1]:
                            w[CODE + i] = LEFT
                            continue
                        events[0, found], events[1, found], events[2, found] = index[start + i], n, s - 1
                        found += 1
    return found


@compiled
def solve_crossings(w: Array, folded: bool) -> None:
    """Solve for the place (BEST) where neighbour FIRST comes in between A and B; QQ = 1 if it lies on its edges."""
    for i in range(W):
        w[X + i] = w[A + i]
        w[C + i], w[FC + i] = w[A + i], math.nan
    others.not_met(w, folded)
    for i in range(W):
        w[FA + i], w[X + i] = w[LOW + i], w[B + i]
    others.not_met(w, folded)
    for i in range(W):
        w[FB + i] = w[LOW + i]
    lanes.start_root(w)
    for _ in range(200):
        others.not_met(w, folded)
        if lanes.next_root(w):
            break
    for i in range(W):
        w[X + i] = w[BEST + i]
    others.not_met(w, folded)

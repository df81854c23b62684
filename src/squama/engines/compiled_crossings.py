"""Where another neighbour's tip-side contact comes in, in lock-step, as :mod:`squama.model.neighbours` finds it."""

from __future__ import annotations

import math

from squama.engines import compiled_lanes as lanes
from squama.engines.compiled_ends import LEFT, SAFETY
from squama.engines.compiled_kernel import compiled
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
from squama.model.neighbours import FOLDED_SAMPLES, SAMPLES
from squama.model.solve import Array

FAR = 32
"""Neighbours that are looked for here; designs that reach farther are left to the numpy engine."""
CLEAR, FOLDED_CLEAR = 5, 13
"""Samples that show for most designs that no other neighbour comes near."""


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
    lanes.lines(w, folded)
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
        lanes.line(w, i, 1.0)
    return 2


@compiled
def _copy(to: Array, low: int, of: Array, start: int) -> None:
    for i in range(W):
        to[low + i] = of[start + i]


@compiled
def clear(w: Array, h: Array, folded: bool) -> None:
    """OK = 1 where no other neighbour comes near: the contact conditions stay below zero by more than they bend."""
    samples, many = FOLDED_CLEAR if folded else CLEAR, _many(w)
    for i in range(W):
        w[OK + i] = 1.0 if w[REACH + i] <= FAR else 0.0
    for s in range(samples):
        _walk(w, s / (samples - 1), folded)
        for n in range(_next(w), many + 1):
            j, one, two = float(n), 2 * n * W, (2 * n + 1) * W
            _copy(w, P1, h, one)
            _copy(w, P2, h, two)
            for i in range(W):
                now, before, last = lanes.line(w, i, j), w[P1 + i], w[P2 + i]
                bend = abs(now - 2 * before + last)
                high = max(now, before, last)
                ok = (high < -SAFETY * bend) | (s < 2) | (j > w[REACH + i]) | (j == w[K + i])
                w[OK + i] = w[OK + i] if ok else 0.0
                w[S0 + i] = now
            _copy(h, one, w, S0)
            _copy(h, two, w, P1)


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
                now = lanes.line(w, i, j)
                up = (now >= 0) & (not w[P1 + i] >= 0) & (j <= w[REACH + i]) & (j != w[K + i])
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
    lanes.not_met(w, folded)
    for i in range(W):
        w[FA + i], w[X + i] = w[LOW + i], w[B + i]
    lanes.not_met(w, folded)
    for i in range(W):
        w[FB + i] = w[LOW + i]
    lanes.start_root(w)
    for _ in range(200):
        lanes.not_met(w, folded)
        if lanes.next_root(w):
            break
    for i in range(W):
        w[X + i] = w[BEST + i]
    lanes.not_met(w, folded)

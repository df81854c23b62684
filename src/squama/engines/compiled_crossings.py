"""Where another neighbour's tip-side contact comes in, in lock-step, as :mod:`squama.model.neighbours` finds it."""

from __future__ import annotations

import math

from squama.engines import compiled_lanes as lanes
from squama.engines.compiled_ends import LEFT, SAFETY
from squama.engines.compiled_kernel import OPS, compiled, inlined
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
from squama.model.neighbours import FOLDED_SAMPLES, SAMPLES, reach_at
from squama.model.solve import Array
from squama.model.twisting import Root

FAR = 32
"""Neighbours that are looked for here; designs that reach farther are left to the numpy engine."""
NEAR = 7
"""Neighbours from which on the quick look is not made."""
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
    a, b = to[low : low + W], of[start : start + W]
    for i in range(W):
        a[i] = b[i]


@compiled
def clear(w: Array, folded: bool) -> None:
    """OK = 1 where no other neighbour comes near: the contact conditions stay below zero by more than they bend.

    Only paths that follow the next neighbour and reach few others are looked at, the rest is not clear.
    """
    samples = FOLDED_CLEAR if folded else CLEAR
    for i in range(W):
        w[OK + i] = 1.0 if (w[REACH + i] < NEAR) & (w[K + i] == 1) else 0.0
    for s in range(samples):
        part = s / (samples - 1)
        if folded:
            for i in range(W):
                row = lanes.folded_row(w, i)
                x = w[X0 + i] + (w[X_END + i] - w[X0 + i]) * part
                _, r, q, _ = row.solve_from(lanes.at_fold(w, i), x, OPS)
                _keep(w, i, s, r, q)
        else:
            for i in range(W):
                x = w[X0 + i] + (w[X_END + i] - w[X0 + i]) * part
                _, r, q, _ = lanes.open_row(w, i).solve(x, OPS)
                _keep(w, i, s, r, q)


@inlined
def _keep(w: Array, i: int, s: int, r: Root, q: float) -> None:
    """Keep OK where neighbours 2 to 6 stay away at sample s and before."""
    u = r.S / (r.H + q)
    c = 1 / (1 + u * u)
    c1, s1, lean = (1 - u * u) * c, 2 * u * c, w[lanes.SA + i] * w[lanes.CA + i] * r.cs
    half, H = r.G / 2, r.H + lean
    # how far the tip reaches at the three samples
    far = reach_at(lanes.open_row(w, i), r.cs)
    reach = max(far, w[P1 + i], w[P2 + i])
    w[P1 + i], w[P2 + i] = far, w[P1 + i]
    c2, s2 = c1 * c1 - s1 * s1, 2 * s1 * c1
    c3, s3 = c2 * c1 - s2 * s1, s2 * c1 + c2 * s1
    c4, s4 = c2 * c2 - s2 * s2, 2 * s2 * c2
    c5, s5 = c4 * c1 - s4 * s1, s4 * c1 + c4 * s1
    c6, s6 = c3 * c3 - s3 * s3, 2 * s3 * c3
    ok = _below(w, i, 0, s, reach < 2, (half - 2 * r.S) * c2 + (H - 2 * lean) * s2 - half)
    ok &= _below(w, i, 2 * W, s, reach < 3, (half - 3 * r.S) * c3 + (H - 3 * lean) * s3 - half)
    ok &= _below(w, i, 4 * W, s, reach < 4, (half - 4 * r.S) * c4 + (H - 4 * lean) * s4 - half)
    ok &= _below(w, i, 6 * W, s, reach < 5, (half - 5 * r.S) * c5 + (H - 5 * lean) * s5 - half)
    ok &= _below(w, i, 8 * W, s, reach < 6, (half - 6 * r.S) * c6 + (H - 6 * lean) * s6 - half)
    w[OK + i] = w[OK + i] if ok else 0.0


@inlined
def _below(w: Array, i: int, past: int, s: int, beyond: bool, now: float) -> bool:
    """Whether the contact condition of neighbour j stays below zero between sample s and the two before."""
    one, two = lanes.PAST + past + i, lanes.PAST + past + W + i
    before, last = w[one], w[two]
    w[one], w[two] = now, before
    high = max(now, before, last)
    away: bool = (high < -SAFETY * abs(now - 2 * before + last)) | (s < 2) | beyond
    return away


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
                now, far = lanes.line(w, i, j), max(w[lanes.HERE + i], w[lanes.BEFORE + i])
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

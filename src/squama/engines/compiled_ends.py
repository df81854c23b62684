"""Ends of many paths in lock-step: the same looks, in the same places, as :mod:`squama.model.ends` takes.

Dips that might hide an end between two samples are rare; such designs are left to the numpy engine (LEFT).
"""

from __future__ import annotations

import math

from squama.engines import compiled_lanes as lanes
from squama.engines.compiled_kernel import compiled, inlined
from squama.engines.compiled_lanes import (
    BEST,
    CODE,
    FA,
    FB,
    FC,
    FIRST,
    FOLD,
    LOW,
    OK,
    P1,
    P2,
    QQ,
    R1,
    R2,
    S1,
    S2,
    SPAN,
    THETA0,
    THETA_F,
    TURN,
    X0,
    X1,
    X_END,
    A,
    B,
    C,
    D,
    W,
    X,
)  # fmt: skip
from squama.model.ends import COINCIDE
from squama.model.outcome import CODES, End
from squama.model.scan import DEEP, SAFETY
from squama.model.solve import Array

FRICTIONAL, KINEMATIC, STATIC, OFF_TIP, OFF_SIDE, OTHER, RELEASED, RANGE, NONE = map(
    CODES.index,
    (
        End.FRICTIONAL,
        End.KINEMATIC,
        End.STATIC,
        End.OFF_TIP,
        End.OFF_SIDE,
        End.OTHER,
        End.RELEASED,
        End.RANGE,
        End.NONE,
    ),
)
LEFT = -1.0
"""Stands in CODE for a design that is left to the numpy engine."""
NEVER = 1e6


@compiled
def gather(w: Array, table: Array, index: Array, start: int, count: int, rows: int) -> None:
    """Bring rows of the designs index[start : start + count] into a block; the last design fills it up."""
    for i in range(W):
        n = index[start + min(i, count - 1)]
        for row in range(rows):
            w[row * W + i] = table[n, row]


@compiled
def scatter(w: Array, table: Array, index: Array, start: int, count: int, first: int, last: int) -> None:
    """Put rows first..last of a block back."""
    for i in range(count):
        n = index[start + i]
        for row in range(first // W, last // W + 1):
            table[n, row] = w[row * W + i]


@compiled
def scan(w: Array, steps: Array, beyond: int, folded: bool, plates: bool) -> None:
    """Sample the paths up to ``beyond`` samples past their ends, and tell what was seen.

    FIRST is the sample at which the path has ended, A..B the interval before it and C one sample earlier (A = B = X0
    for a path that has ended where it begins), FOLD the first sample without a root; NEVER where there is none.
    CODE = LEFT where a margin or the root dips between samples.
    """
    for i in range(W):
        w[FIRST + i], w[FOLD + i], w[CODE + i] = NEVER, NEVER, 0.0
        w[P1 + i] = w[P2 + i] = math.nan
        for row in range(10):
            w[lanes.PAST + row * W + i] = math.nan
        w[A + i] = w[B + i] = w[C + i] = w[X0 + i]
        w[FA + i] = w[FB + i] = w[FC + i] = math.nan
    for s in range(steps.size):
        for i in range(W):
            w[X + i] = w[X0 + i] + (w[X1 + i] - w[X0 + i]) * steps[s]
        lanes.look(w, folded, plates)
        left = 0
        for i in range(W):
            low, q2, x, first = w[LOW + i], w[QQ + i], w[X + i], w[FIRST + i]
            # dips at the sample before, on the way to the end
            dip = (not folded) & _dip(w[P2 + i], w[P1 + i], q2) & (s <= first)
            w[P2 + i], w[P1 + i] = w[P1 + i], q2
            w[CODE + i] = LEFT if dip else w[CODE + i]
            # A..B moves on until the end is between
            on = first == NEVER
            w[C + i], w[FC + i] = w[A + i] if on else w[C + i], w[FA + i] if on else w[FC + i]
            w[A + i], w[FA + i] = w[B + i] if on else w[A + i], w[FB + i] if on else w[FA + i]
            w[B + i], w[FB + i] = x if on else w[B + i], low if on else w[FB + i]
            first = float(s) if on & (not low > 0) else first
            turned = (not folded) & (not q2 >= 0) & (w[FOLD + i] == NEVER) & (s <= first + 4) & (first > 0)
            fold = float(s) if turned else w[FOLD + i]
            w[FIRST + i], w[FOLD + i] = first, fold
            left += 1 if s < first + beyond else 0
        for i in range(W):
            # any margin might vanish before the one that ends the path at the sample FIRST
            dips = _dips(w, i, lanes.RATE, lanes.PAST) | _dips(w, i, D, lanes.PAST + 2 * W)
            dips |= _dips(w, i, lanes.TIP, lanes.PAST + 4 * W) | _dips(w, i, lanes.SIDE, lanes.PAST + 6 * W)
            dips |= _dips(w, i, TURN, lanes.PAST + 8 * W)
            w[CODE + i] = LEFT if dips & (s <= w[FIRST + i] + 1) else w[CODE + i]
        if left == 0:
            break


@inlined
def _dip(left: float, middle: float, right: float) -> bool:
    # its bottom is (right - left)^2 / (8 (right + left - 2 middle)) lower than the middle
    deep = (right - left) * (right - left) > 8 * (1 - DEEP) * middle * (right + left - 2 * middle)
    return (middle > 0) & (middle <= left) & (middle < right) & deep


@inlined
def _dips(w: Array, i: int, row: int, past: int) -> bool:
    """Whether a margin dips at the sample before."""
    a, b, now = w[past + W + i], w[past + i], w[row + i]
    w[past + W + i], w[past + i] = b, now
    dip: bool = _dip(a, b, now)
    return dip


@compiled
def coarse(w: Array, steps: Array, folded: bool, plates: bool) -> None:
    """Sample the paths once; OK = 1 where that settles the end, 2 where a fold comes before it, else 0.

    Rows as :func:`scan` leaves them, but for dips: where one might hide an end, nothing is settled.
    """
    for i in range(W):
        w[FIRST + i], w[FOLD + i], w[S1 + i], w[S2 + i] = NEVER, NEVER, 1.0, 1.0
        w[A + i] = w[B + i] = w[C + i] = w[X0 + i]
        w[FA + i] = w[FB + i] = w[FC + i] = math.nan
        w[SPAN + i] = w[X1 + i] - w[X0 + i]
    for s in range(steps.size):
        lanes.look_at(w, steps[s], folded, plates)
        left = 0
        for i in range(W):
            first, low, q2 = w[FIRST + i], w[LOW + i], w[QQ + i]
            on = first == NEVER
            w[C + i], w[FC + i] = w[A + i] if on else w[C + i], w[FA + i] if on else w[FC + i]
            w[A + i], w[FA + i] = w[B + i] if on else w[A + i], w[FB + i] if on else w[FA + i]
            w[B + i], w[FB + i] = w[X + i] if on else w[B + i], low if on else w[FB + i]
            first = float(s) if on & (not low > 0) else first
            turned = (not folded) & (not q2 >= 0) & (w[FOLD + i] == NEVER) & (s <= first) & (first > 0)
            w[FOLD + i] = float(s) if turned else w[FOLD + i]
            w[FIRST + i] = first
            left += 1 if first == NEVER else 0
        for i in range(W):
            first = w[FIRST + i]
            calm = _calm(w, i, lanes.RATE, lanes.PAST, first, s) & _calm(w, i, D, lanes.PAST + 2 * W, first, s)
            calm &= _calm(w, i, lanes.TIP, lanes.PAST + 4 * W, first, s)
            calm &= _calm(w, i, lanes.SIDE, lanes.PAST + 6 * W, first, s)
            calm &= _calm(w, i, TURN, lanes.PAST + 8 * W, first, s)
            w[S1 + i] = w[S1 + i] if calm else 0.0
        if not folded:
            for i in range(W):
                w[S2 + i] = w[S2 + i] if _calm_root(w, i, w[FIRST + i], w[FOLD + i], s) else 0.0
        if left == 0:
            break
    for i in range(W):
        folds = (w[FOLD + i] == w[FIRST + i]) & (w[FOLD + i] < NEVER)
        ok = (w[FIRST + i] < NEVER) & (w[S2 + i] > 0) & ((w[S1 + i] > 0) | folds)
        w[OK + i] = (2.0 if folds else 1.0) if ok else 0.0


@inlined
def _calm(w: Array, i: int, row: int, past: int, first: float, s: int) -> bool:
    """Whether a margin cannot vanish in the two intervals before sample s, as far as the path goes."""
    a, b, now = w[past + W + i], w[past + i], w[row + i]
    w[past + W + i], w[past + i] = b, now
    bend = SAFETY * abs(now - 2 * b + a)
    # in the interval of the end itself another margin than that which ends the path there might dip before it
    ends = (first < s) | ((first == s) & (not now > 0))
    calm: bool = ((min(a, b) > bend) | (first < s)) & ((min(b, now) > bend) | ends)
    return calm | (s < 2)


@inlined
def _calm_root(w: Array, i: int, first: float, fold: float, s: int) -> bool:
    """Whether the root changes its sign in the two intervals before sample s only where samples show it."""
    a, b, now = w[P2 + i], w[P1 + i], w[QQ + i]
    w[P2 + i], w[P1 + i] = b, now
    bend = SAFETY * abs(now - 2 * b + a)
    steep = (b > bend) & (-now > bend) & (fold == first)
    # what comes after the end must not matter: whether it is looked at depends on the other lanes
    calm: bool = (first < s) | ((min(a, b) > bend) & ((min(b, now) > bend) | ((first == s) & steep)))
    return calm | (s < 2)


@compiled
def bracket_folds(w: Array, steps: Array) -> None:
    """Bracket of the fold where FOLD tells of one, or where one lies within the bracket of the end; else FOLD = 0."""
    for i in range(W):
        n, span = int(min(w[FOLD + i], steps.size - 1.0)), w[X1 + i] - w[X0 + i]
        fold = w[FOLD + i] < NEVER
        w[FOLD + i] = 1.0 if fold else 0.0
        w[R1 + i] = w[X0 + i] + span * steps[max(n - 1, 0)] if fold else w[A + i]
        w[R2 + i] = w[X0 + i] + span * steps[n] if fold else w[B + i]
    for part in range(1, 8):
        for i in range(W):
            w[X + i] = w[A + i] + (w[B + i] - w[A + i]) * (part / 8)
        lanes.square(w)
        for i in range(W):
            hit = (w[FOLD + i] == 0) & (w[B + i] > w[A + i]) & (w[FIRST + i] < NEVER) & (not w[LOW + i] > 0)
            w[FOLD + i] = 1.0 if hit else w[FOLD + i]
            w[R2 + i] = w[X + i] if hit else w[R2 + i]
    for i in range(W):
        if w[FOLD + i] > 0:
            w[A + i], w[B + i] = w[R1 + i], w[R2 + i]


@compiled
def find_folds(w: Array) -> None:
    """Solve for the folds and set up the folded paths (THETA_F, X0, X1)."""
    for i in range(W):
        w[X + i] = w[A + i]
        w[C + i], w[FC + i] = w[A + i], math.nan
    lanes.square(w)
    for i in range(W):
        w[FA + i] = w[LOW + i]
        w[X + i] = w[B + i]
    lanes.square(w)
    for i in range(W):
        w[FB + i] = w[LOW + i]
    lanes.start_root(w)
    for _ in range(200):
        lanes.square(w)
        if lanes.next_root(w):
            break
    for i in range(W):
        w[THETA_F + i] = w[BEST + i]
        tau = math.sqrt(w[BEST + i] - w[THETA0 + i])
        w[X0 + i], w[X1 + i] = -tau, tau
    lanes.folds(w)


@compiled
def solve_ends(w: Array, folded: bool, plates: bool, sweeps: int) -> None:
    """Solve for the ends in their brackets (X_END) and name them (CODE); OK = 0 where that takes more sweeps."""
    lanes.start_root(w)
    for i in range(W):
        # nothing to solve where the path has ended at its start or does not end
        if (w[FIRST + i] == 0) | (w[FIRST + i] == NEVER):
            w[OK + i], w[BEST + i] = 1.0, w[X0 + i] if w[FIRST + i] == 0 else w[X1 + i]
            w[A + i], w[B + i], w[X + i] = w[BEST + i], w[BEST + i], w[BEST + i]
    for _ in range(sweeps):
        lanes.look(w, folded, plates)
        if lanes.next_root(w):
            break
    for i in range(W):
        w[X_END + i] = w[X + i] = w[BEST + i]
    lanes.figures(w, folded, plates)
    for i in range(W):
        if w[CODE + i] != LEFT:
            w[CODE + i] = _name(w, i, folded)


@inlined
def _name(w: Array, i: int, folded: bool) -> float:
    if w[FIRST + i] == NEVER:
        return float(RELEASED if folded else RANGE)
    names = (KINEMATIC, FRICTIONAL, OFF_TIP, OFF_SIDE, RANGE)
    values = (w[lanes.RATE + i], w[lanes.D + i], w[lanes.TIP + i], w[lanes.SIDE + i], w[TURN + i])
    found, least = -1, math.inf
    for n in range(5):
        value = values[n]
        if not value > COINCIDE:
            found = names[n]
            break
        if value < least:
            found, least = names[n], value
    if (found == FRICTIONAL) & (w[FIRST + i] == 0):
        found = STATIC
    return float(found)

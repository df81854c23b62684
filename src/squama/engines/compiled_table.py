"""One table of designs from engagement to work: every step takes the designs it is for, in blocks of lanes."""

from __future__ import annotations

import math

import numpy as np

from squama.engines import compiled_crossings as crossings
from squama.engines import compiled_ends as ends
from squama.engines import compiled_lanes as lanes
from squama.engines import compiled_work as works
from squama.engines.compiled_ends import LEFT, NONE, OTHER, gather, scatter
from squama.engines.compiled_kernel import compiled
from squama.engines.compiled_lanes import (
    BEST,
    BETA,
    CARRIED,
    CODE,
    ETA,
    FEW,
    FIRST,
    FOLD,
    FORCE,
    LAM,
    LOAD,
    LOADE,
    MU,
    OK,
    QQ,
    REACH,
    S0,
    S1,
    THETA,
    THETA0,
    THETA_F,
    TORQUE,
    X0,
    X1,
    X_END,
    A,
    B,
    K,
    W,
    X,
)  # fmt: skip
from squama.model.neighbours import FOLDED_SAMPLES, SAMPLES
from squama.model.solve import Array

TABLE = 8192
"""Designs of a table: it stays in the processor's cache."""
EVENTS = 8 * TABLE
SWEEPS = 6
"""Sweeps of the root finder after which the designs that have not converged are gathered in blocks of their own."""
HALF_TURN = math.radians(179)
LOAD_E, THETA_END, LOAD_END, THETA_C, LOAD_C, F0, TORQUE_C, WORK, PARAMETER, FOLD_AT = range(10)
"""Rows of the answer; the last two are the path parameter of the end and the inclination of the fold (0: none)."""


@compiled
def engage(w: Array, table: Array, cols: Array, out: Array, low: int, n: int, index: Array) -> int:
    """Find the neighbours that are met first; return how many designs engage (their places in ``index``)."""
    engaged = 0
    for start in range(0, n, W):
        count = min(W, n - start)
        for i in range(W):
            at = low + start + min(i, count - 1)
            for row in range(5):
                w[row * W + i] = cols[row, at]
            w[THETA0 + i], w[MU + i] = cols[5, at], cols[6, at]
        lanes.engage(w)
        for i in range(W):
            k = max(w[K + i], 1.0)
            w[X0 + i], w[X1 + i], w[THETA_F + i] = w[THETA0 + i], HALF_TURN, 0.0
            w[X_END + i], w[FOLD + i] = w[THETA0 + i], 0.0
            w[ETA + i], w[BETA + i], w[LAM + i] = w[ETA + i] / k, w[BETA + i] / k, w[LAM + i] / k
            w[CODE + i] = 0.0 if w[K + i] > 0 else float(NONE)
        for i in range(count):
            for row in range(FEW):
                table[start + i, row] = w[row * W + i]
            out[LOAD_E, low + start + i] = w[LOADE + i]
            if w[K + i] > 0:
                index[engaged] = start + i
                engaged += 1
    return engaged


@compiled
def follow(w: Array, table: Array, index: Array, n: int, steps: Array, folded_steps: Array, plates: bool) -> int:
    """Bracket and solve the ends; return how many paths do not fold: ``index`` is sorted, these come first."""
    unsettled, folded = np.empty(n, np.int64), np.empty(n, np.int64)
    many, bent, plain = 0, 0, 0
    # numbers and flags as such, not as constants, for which Numba would compile every step anew
    unfolded, fold = n < 0, n >= 0
    for start in range(0, n, W):
        count = min(W, n - start)
        gather(w, table, index, start, count, FEW)
        ends.scan(w, steps[::4], 1, unfolded, plates)
        scatter(w, table, index, start, count, B, FOLD)
        for i in range(count):
            at = index[start + i]
            if w[OK + i] == 1:
                index[plain] = at
                plain += 1
            elif w[OK + i] == 2:
                folded[bent] = at
                bent += 1
            else:
                unsettled[many] = at
                many += 1
    for start in range(0, many, W):
        count = min(W, many - start)
        gather(w, table, unsettled, start, count, FEW)
        ends.scan(w, steps[::1], 4, unfolded, plates)
        ends.bracket_folds(w, steps)
        scatter(w, table, unsettled, start, count, CODE, FOLD)
        for i in range(count):
            at = unsettled[start + i]
            if w[FOLD + i] > 0:
                folded[bent] = at
                bent += 1
            else:
                index[plain] = at
                plain += 1
    index[plain : plain + bent] = folded[:bent]
    many = 0
    for start in range(plain, n, W):
        count = min(W, n - start)
        gather(w, table, index, start, count, CARRIED)
        ends.find_folds(w)
        ends.scan(w, folded_steps[::4], 1, fold, plates)
        scatter(w, table, index, start, count, THETA_F, THETA_F)
        scatter(w, table, index, start, count, X0, X1)
        scatter(w, table, index, start, count, B, FOLD)
        for i in range(count):
            if w[OK + i] == 0:
                unsettled[many] = index[start + i]
                many += 1
    for start in range(0, many, W):
        count = min(W, many - start)
        gather(w, table, unsettled, start, count, FEW)
        ends.scan(w, folded_steps[::1], 1, fold, plates)
        scatter(w, table, unsettled, start, count, CODE, FIRST)
    return plain


@compiled
def solve(w: Array, table: Array, index: Array, low: int, high: int, folded: bool, plates: bool) -> None:
    """Solve the ends: few sweeps do for most designs, the others go on together."""
    late = np.empty(high - low, np.int64)
    many = 0
    for start in range(low, high, W):
        count = min(W, high - start)
        gather(w, table, index, start, count, CARRIED)
        ends.solve_ends(w, folded, plates, SWEEPS)
        for i in range(count):
            if w[OK + i] > 0:
                table[index[start + i], X_END // W] = w[X_END + i]
                table[index[start + i], CODE // W] = w[CODE + i]
            else:
                late[many] = index[start + i]
                many += 1
    for start in range(0, many, W):
        count = min(W, many - start)
        gather(w, table, late, start, count, CARRIED)
        ends.solve_ends(w, folded, plates, 200)
        scatter(w, table, late, start, count, X_END, CODE)


@compiled
def cross(
    w: Array, h: Array, table: Array, index: Array, low: int, high: int, folded: bool, events: Array, met: Array
) -> None:
    """Cut paths where another neighbour's contact comes in."""
    found, many = 0, 0
    near, order = np.empty(high - low, np.int64), np.empty(high - low, np.int64)
    # in order of reach, so that few designs are asked for neighbours they do not have
    for far in range(1, crossings.FAR + 1):
        for i in range(low, high):
            reach = min(table[index[i], REACH // W], float(crossings.FAR))
            if reach == far:
                order[many] = index[i]
                many += 1
        if many == high - low:
            break
    total, many = many, 0
    for start in range(0, total, W):
        count = min(W, total - start)
        gather(w, table, order, start, count, FEW)
        crossings.clear(w, h, folded)
        for i in range(count):
            if w[OK + i] == 0:
                near[many] = order[start + i]
                many += 1
    for start in range(0, many, W):
        count = min(W, many - start)
        gather(w, table, near, start, count, FEW)
        found = crossings.crossings(w, h, events, near, start, count, found, folded)
        scatter(w, table, near, start, count, CODE, CODE)
    samples = (FOLDED_SAMPLES if folded else SAMPLES) - 1
    for start in range(0, found, W):
        count = min(W, found - start)
        gather(w, table, events[0], start, count, FEW)
        for i in range(W):
            e = start + min(i, count - 1)
            span, step = w[X_END + i] - w[X0 + i], float(events[2, e])
            w[FIRST + i] = float(events[1, e])
            w[A + i], w[B + i] = w[X0 + i] + span * (step / samples), w[X0 + i] + span * ((step + 1) / samples)
        crossings.solve_crossings(w, folded)
        for i in range(count):
            e = start + i
            events[3, e] = 1 if w[QQ + i] > 0 else 0
            met[e] = w[BEST + i]
    for e in range(found):
        at = events[0, e]
        if (events[3, e] == 1) & (met[e] < table[at, X_END // W]) & (table[at, CODE // W] != LEFT):
            table[at, X_END // W], table[at, CODE // W] = met[e], float(OTHER)


@compiled
def answer(
    w: Array, table: Array, index: Array, low: int, high: int, folded: bool, plates: bool,
    margin: float, out: Array, base: int,
) -> None:  # fmt: skip
    """Give out ends and figures at the cut-offs; the cut-offs are kept in the table (X_C)."""
    for start in range(low, high, W):
        count = min(W, high - start)
        gather(w, table, index, start, count, FEW)
        for i in range(W):
            w[X + i] = w[X_END + i]
        lanes.figures(w, folded, plates)
        for i in range(count):
            at = base + index[start + i]
            ended = w[X_END + i] == w[X0 + i]
            out[PARAMETER, at], out[FOLD_AT, at] = w[X_END + i], w[THETA_F + i]
            out[THETA_END, at] = w[THETA0 + i] if ended else w[THETA + i]
            out[LOAD_END, at] = out[LOAD_E, at] if ended else w[LOAD + i] / w[K + i]
        works.cut(w, margin, folded)
        for i in range(W):
            w[X + i] = w[B + i]
        lanes.figures(w, folded, plates)
        scatter(w, table, index, start, count, B, B)
        for i in range(count):
            at = base + index[start + i]
            moved = w[B + i] > w[X0 + i]
            out[THETA_C, at] = w[THETA + i] if moved else w[THETA0 + i]
            out[LOAD_C, at] = w[LOAD + i] / w[K + i] if moved else out[LOAD_E, at]
            out[F0, at] = w[FORCE + i] * w[ETA + i] if moved else 0.0
            out[TORQUE_C, at] = w[TORQUE + i] * w[K + i] if moved else 0.0
            out[WORK, at] = 0.0


@compiled
def work(
    w: Array, table: Array, index: Array, n: int, locked: bool, folded: bool, plates: bool,
    sizes: Array, rule: Array, out: Array, base: int,
) -> None:  # fmt: skip
    """Frictional work by rule after rule, each for the designs that the one before has not served; NaN is left."""
    first = 0
    for size in sizes:
        left = 0
        for start in range(0, n, W):
            count = min(W, n - start)
            gather(w, table, index, start, count, FEW)
            if not locked:
                works.pole(w, folded, plates)
            works.work(w, rule, first, size, locked, folded, plates)
            for i in range(count):
                if w[S1 + i] > 0:
                    out[WORK, base + index[start + i]] = w[S0 + i]
                else:
                    index[left] = index[start + i]
                    left += 1
        n, first = left, first + size
    for i in range(n):
        out[WORK, base + index[i]] = math.nan

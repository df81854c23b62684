"""One table of designs from engagement to work: every step takes the designs it is for, in blocks of lanes."""

from __future__ import annotations

import numpy as np

from squama.engines import compiled_crossings as crossings
from squama.engines import compiled_ends as ends
from squama.engines import compiled_lanes as lanes
from squama.engines import compiled_work as works
from squama.engines.compiled_ends import LEFT, OTHER, gather, scatter
from squama.engines.compiled_first import AGAIN, DONE, FOLDS, PLAIN, WORK, give_ends, give_figures, waits_for
from squama.engines.compiled_kernel import compiled
from squama.engines.compiled_lanes import (
    BEST,
    CARRIED,
    CODE,
    FEW,
    FIRST,
    FOLD,
    OK,
    QQ,
    S0,
    S1,
    THETA_F,
    X0,
    X1,
    X_C,
    X_END,
    A,
    B,
    W,
    X,
)  # fmt: skip
from squama.engines.compiled_order import order_by
from squama.model.neighbours import FOLDED_SAMPLES, SAMPLES
from squama.model.scan import FOLDED_COARSE
from squama.model.solve import Array

TABLE = 8192
"""Designs of a table: it stays in the processor's cache."""
EVENTS = 8 * TABLE


@compiled
def choose(state: Array, n: int, wanted: int, index: Array, low: int) -> int:
    """Put the designs of a state into ``index`` from ``low`` on; return where they stop."""
    for i in range(n):
        if state[i] == wanted:
            index[low] = i
            low += 1
    return low


@compiled
def follow(
    w: Array, table: Array, state: Array, opened: Array, bent: Array, n: int,
    steps: Array, folded_steps: Array, plates: bool,
) -> tuple[int, int]:  # fmt: skip
    """Bracket the ends that one look has not settled; return how many of the paths are open and how many fold."""
    unsettled = np.empty(n, np.int64)
    many, folds, plain = choose(state, n, AGAIN, unsettled, 0), choose(state, n, FOLDS, bent, 0), 0
    # those side by side that have ended at the same sample of the first look
    order_by(table[:, FIRST // W], unsettled, many)
    # flags as such, not as constants, for which Numba would compile every step anew
    unfolded, fold = n < 0, n >= 0
    for start in range(0, many, W):
        count = min(W, many - start)
        gather(w, table, unsettled, start, count, FEW)
        ends.scan(w, steps, 4, unfolded, plates)
        ends.bracket_folds(w, steps)
        scatter(w, table, unsettled, start, count, CODE, FOLD)
        for i in range(count):
            at = unsettled[start + i]
            if w[FOLD + i] > 0:
                bent[folds] = at
                folds += 1
            else:
                opened[plain] = at
                plain += 1
    many = 0
    for start in range(0, folds, W):
        count = min(W, folds - start)
        gather(w, table, bent, start, count, CARRIED)
        ends.find_folds(w)
        ends.coarse(w, folded_steps[::FOLDED_COARSE], fold, plates)
        scatter(w, table, bent, start, count, THETA_F, THETA_F)
        scatter(w, table, bent, start, count, X0, X1)
        scatter(w, table, bent, start, count, B, FOLD)
        for i in range(count):
            if w[OK + i] == 0:
                unsettled[many] = bent[start + i]
                many += 1
    for start in range(0, many, W):
        count = min(W, many - start)
        gather(w, table, unsettled, start, count, FEW)
        lanes.folds(w)
        ends.scan(w, folded_steps, 1, fold, plates)
        scatter(w, table, unsettled, start, count, CODE, FIRST)
    return plain, folds


@compiled
def solve(w: Array, table: Array, index: Array, n: int, folded: bool, plates: bool) -> None:
    """Solve the ends."""
    for start in range(0, n, W):
        count = min(W, n - start)
        gather(w, table, index, start, count, CARRIED)
        lanes.folds(w)
        ends.solve_ends(w, folded, plates, 200)
        scatter(w, table, index, start, count, X_END, CODE)


@compiled
def cross(
    w: Array, h: Array, table: Array, index: Array, n: int, every: int, folded: bool, events: Array, met: Array
) -> None:
    """Cut paths where another neighbour's contact comes in; from ``n`` on it is known that one comes near."""
    found, many = 0, every - n
    near = np.empty(every, np.int64)
    near[:many] = index[n:every]
    for start in range(0, n, W):
        count = min(W, n - start)
        gather(w, table, index, start, count, FEW)
        lanes.folds(w)
        crossings.clear(w, folded)
        for i in range(count):
            if w[OK + i] == 0:
                near[many] = index[start + i]
                many += 1
    for start in range(0, many, W):
        count = min(W, many - start)
        gather(w, table, near, start, count, FEW)
        lanes.folds(w)
        found = crossings.crossings(w, h, events, near, start, count, found, folded)
        scatter(w, table, near, start, count, CODE, CODE)
    samples = (FOLDED_SAMPLES if folded else SAMPLES) - 1
    for start in range(0, found, W):
        count = min(W, found - start)
        gather(w, table, events[0], start, count, FEW)
        lanes.folds(w)
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
    w: Array, table: Array, state: Array, index: Array, n: int, folded: bool, plates: bool,
    margin: float, out: Array, code: Array, base: int,
) -> None:  # fmt: skip
    """Give out ends and figures at the cut-offs; what is left is work."""
    for start in range(0, n, W):
        count = min(W, n - start)
        gather(w, table, index, start, count, FEW)
        lanes.folds(w)
        for i in range(W):
            w[X + i] = w[X_END + i]
        lanes.figures(w, folded, plates)
        for i in range(count):
            give_ends(w, out, i, index[start + i])
        works.cut(w, margin, folded)
        for i in range(W):
            w[X + i] = w[X_C + i]
        lanes.figures(w, folded, plates)
        scatter(w, table, index, start, count, X_C, X_C)
        for i in range(count):
            at = index[start + i]
            give_figures(w, out, i, at)
            code[base + at] = int(w[CODE + i])
            state[at] = DONE if w[CODE + i] == LEFT else waits_for(w, i, folded)


@compiled
def work(
    w: Array, table: Array, state: Array, index: Array, n: int, locked: bool, folded: bool, plates: bool,
    sizes: Array, rule: Array, out: Array,
) -> None:  # fmt: skip
    """Frictional work by rule after rule, each for the designs that the one before has not served, and then in parts.

    Locks that no rule of theirs serves wait for Legendre's.
    """
    for i in range(n):
        state[index[i]] = DONE
    # the rules stand one after the other, the last ones are asked for
    first = rule.shape[1] - sizes.sum()
    for size in sizes:
        left = 0
        for start in range(0, n, W):
            count = min(W, n - start)
            gather(w, table, index, start, count, FEW)
            lanes.folds(w)
            if not locked:
                works.pole(w, folded, plates)
            works.work(w, rule, first, size, locked, folded, plates)
            for i in range(count):
                if w[S1 + i] > 0:
                    out[index[start + i], WORK] = w[S0 + i]
                else:
                    index[left] = index[start + i]
                    left += 1
        n, first = left, first + size
    for i in range(n):
        if locked:
            state[index[i]] = PLAIN
        else:
            gather(w, table, index, i, 1, FEW)
            lanes.folds(w)
            out[index[i], WORK] = works.in_parts(w, rule, sizes[0], folded, plates)

"""The first pass over all designs: a block of lanes stays in its rows from engagement to work.

It answers the designs that a few samples and one rule settle. The others are kept in the table, with a state that
says what they wait for (:mod:`squama.engines.compiled_table`).
"""

from __future__ import annotations

from squama.engines import compiled_crossings as crossings
from squama.engines import compiled_ends as ends
from squama.engines import compiled_lanes as lanes
from squama.engines import compiled_work as works
from squama.engines.compiled_ends import FRICTIONAL, NONE
from squama.engines.compiled_kernel import compiled
from squama.engines.compiled_lanes import (
    CARRIED,
    CODE,
    ETA,
    FEW,
    FIRST,
    FORCE,
    LOAD,
    LOADE,
    MU,
    OK,
    S0,
    S1,
    STATE,
    THETA,
    THETA0,
    THETA_F,
    TORQUE,
    TURNED,
    X0,
    X1,
    X_C,
    X_END,
    A,
    B,
    K,
    W,
    X,
)  # fmt: skip
from squama.model.solve import Array

SWEEPS = 6
"""Sweeps of the root finder in the first pass."""
DONE, AGAIN, FOLDS, CROSSED, ROUGH, PLAIN = range(6)
"""What a design waits for: nothing; a closer look; its folded path; a look for other neighbours; more nodes at a pole;
Legendre's rules."""
LOAD_E, THETA_END, LOAD_END, THETA_C, LOAD_C, F0, TORQUE_C, WORK, PARAMETER, FOLD_AT = range(10)
"""Rows of the answer; the last two are the path parameter of the end and the inclination of the fold (0: none)."""


@compiled
def give_ends(w: Array, out: Array, i: int, at: int) -> None:
    """Answer of lane i: its end, with the figures of the contact there."""
    ended = w[X_END + i] == w[X0 + i]
    out[PARAMETER, at], out[FOLD_AT, at] = w[X_END + i], w[THETA_F + i]
    out[THETA_END, at] = w[THETA0 + i] if ended else w[THETA + i]
    out[LOAD_END, at] = out[LOAD_E, at] if ended else w[LOAD + i] / w[K + i]


@compiled
def give_figures(w: Array, out: Array, i: int, at: int) -> None:
    """Answer of lane i: the figures at its cut-off, without work."""
    moved = w[X_C + i] > w[X0 + i]
    out[THETA_C, at] = w[THETA + i] if moved else w[THETA0 + i]
    out[LOAD_C, at] = w[LOAD + i] / w[K + i] if moved else out[LOAD_E, at]
    out[F0, at] = w[FORCE + i] * w[ETA + i] if moved else 0.0
    out[TORQUE_C, at] = w[TORQUE + i] * w[K + i] if moved else 0.0
    out[WORK, at] = 0.0


@compiled
def waits_for(w: Array, i: int, folded: bool) -> int:
    """Kind of rule that lane i needs for its work: ROUGH (pole at the end), PLAIN, or DONE where there is no work."""
    if not ((w[MU + i] > 0) & (w[X_C + i] > w[X0 + i])):
        return DONE
    pole = (w[CODE + i] == FRICTIONAL) & ((not folded) | (w[X_END + i] > 0))
    return ROUGH if pole else PLAIN


@compiled
def first_pass(
    w: Array, h: Array, table: Array, state: Array, cols: Array, base: int, n: int,
    steps: Array, size: int, rule: Array, plates: bool, margin: float, out: Array, code: Array, neighbour: Array,
) -> None:  # fmt: skip
    """Take n designs from ``base`` on as far as they go with one look."""
    # a flag as such, not as a constant, for which Numba would compile every step anew
    unfolded = n < 0
    for start in range(0, n, W):
        count = min(W, n - start)
        for i in range(W):
            at = base + start + min(i, count - 1)
            for row in range(5):
                w[row * W + i] = cols[row, at]
            w[THETA0 + i], w[MU + i] = cols[5, at], cols[6, at]
        lanes.engage(w)
        for i in range(W):
            k = max(w[K + i], 1.0)
            w[X0 + i], w[X1 + i], w[THETA_F + i], w[CODE + i] = w[THETA0 + i], TURNED, 0.0, 0.0
            for row in range(3):
                w[row * W + i] = w[row * W + i] / k
        ends.coarse(w, h, steps, unfolded, plates)
        for i in range(count):
            at = start + i
            out[LOAD_E, base + at], neighbour[base + at] = w[LOADE + i], int(w[K + i])
            w[STATE + i] = DONE if w[OK + i] == 1 else (FOLDS if w[OK + i] == 2 else AGAIN)
            if w[K + i] == 0:
                w[STATE + i], code[base + at] = DONE, NONE
                for row in range(1, 10):
                    out[row, base + at] = 0.0
            elif w[STATE + i] != DONE:
                for row in range(CARRIED):
                    table[at, row] = w[row * W + i]
        for i in range(W):
            if (w[OK + i] != 1) | (w[K + i] == 0):
                # keeps the root finder still
                w[FIRST + i], w[A + i], w[B + i] = 0.0, w[X0 + i], w[X0 + i]
        ends.solve_ends(w, unfolded, plates, SWEEPS)
        for i in range(count):
            at = base + start + i
            if (w[STATE + i] == DONE) & (w[K + i] > 0):
                if w[OK + i] == 0:
                    w[STATE + i] = AGAIN
                    for row in range(CARRIED):
                        table[start + i, row] = w[row * W + i]
                else:
                    give_ends(w, out, i, at)
        crossings.clear(w, unfolded)
        works.cut(w, margin, unfolded)
        for i in range(W):
            w[X + i] = w[X_C + i]
        lanes.figures(w, unfolded, plates)
        locked = 0
        for i in range(count):
            if (w[STATE + i] == DONE) & (w[K + i] > 0):
                if w[OK + i] == 0:
                    w[STATE + i] = CROSSED
                else:
                    give_figures(w, out, i, base + start + i)
                    w[STATE + i] = waits_for(w, i, unfolded)
                    locked += 1 if w[STATE + i] == ROUGH else 0
        if locked > 0:
            works.work(w, rule, 0, size, n >= 0, unfolded, plates)
        for i in range(count):
            at = start + i
            if (w[STATE + i] == ROUGH) & (w[S1 + i] > 0):
                out[WORK, base + at], w[STATE + i] = w[S0 + i], DONE
            state[at] = int(w[STATE + i])
            if w[STATE + i] >= CROSSED:
                for row in range(FEW):
                    table[at, row] = w[row * W + i]
            if (w[K + i] > 0) & (w[STATE + i] != AGAIN) & (w[STATE + i] != FOLDS):
                code[base + at] = int(w[CODE + i])

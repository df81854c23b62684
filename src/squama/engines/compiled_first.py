"""The first pass over all designs: a block of lanes stays in its rows from engagement to work.

It answers the designs that a few samples and one rule settle. The others are kept in the table, with a state that
says what they wait for (:mod:`squama.engines.compiled_table`).
"""

from __future__ import annotations

import numpy as np

from squama.engines import compiled_crossings as crossings
from squama.engines import compiled_ends as ends
from squama.engines import compiled_lanes as lanes
from squama.engines import compiled_lines as others
from squama.engines import compiled_work as works
from squama.engines.compiled_ends import FRICTIONAL, NONE
from squama.engines.compiled_kernel import OPS, compiled
from squama.engines.compiled_lanes import (
    BETA,
    CA,
    CARRIED,
    CODE,
    ETA,
    FEW,
    FIRST,
    FORCE,
    LAM,
    LOAD,
    LOADE,
    MU,
    OK,
    S0,
    S1,
    SA,
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
LOAD_E, THETA_END, LOAD_END, THETA_C, LOAD_C, F0, TORQUE_C, ELASTIC, WORK, RED = range(10)
"""Rows of the answer."""
ANSWER = 10


@compiled
def give_ends(w: Array, out: Array, i: int, at: int) -> None:
    """Answer of lane i: its end, with the figures of the contact there."""
    ended = w[X_END + i] == w[X0 + i]
    out[at, THETA_END] = w[THETA0 + i] if ended else w[THETA + i]
    out[at, LOAD_END] = out[at, LOAD_E] if ended else w[LOAD + i] / w[K + i]


@compiled
def give_figures(w: Array, out: Array, i: int, at: int) -> None:
    """Answer of lane i: the figures at its cut-off, without work."""
    moved = w[X_C + i] > w[X0 + i]
    out[at, THETA_C] = w[THETA + i] if moved else w[THETA0 + i]
    out[at, LOAD_C] = w[LOAD + i] / w[K + i] if moved else out[at, LOAD_E]
    out[at, F0] = w[FORCE + i] * w[ETA + i] if moved else 0.0
    out[at, TORQUE_C] = w[TORQUE + i] * w[K + i] if moved else 0.0
    out[at, WORK] = 0.0


@compiled
def give_out(designs: tuple[Array, ...], found: Array, base: int, n: int, out: Array) -> None:
    """Put what was found of n designs where it is asked for, with elastic energy, RED and the beam's own torque."""
    theta0, ratio = designs[4], designs[6]
    for i in range(n):
        at = base + i
        load, lift, work = found[i, LOAD_C], found[i, THETA_C] - theta0[at], found[i, WORK]
        elastic = (ratio[at] * load * load + lift * lift) / 2
        total = elastic + work
        found[i, ELASTIC], found[i, RED] = elastic, work / total if total > 0 else 0.0
        found[i, TORQUE_C] += ratio[at] * load
        for row in range(ANSWER):
            out[row, at] = found[i, row]


@compiled
def waits_for(w: Array, i: int, folded: bool) -> int:
    """Kind of rule that lane i needs for its work: ROUGH (pole at the end), PLAIN, or DONE where there is no work."""
    if not ((w[MU + i] > 0) & (w[X_C + i] > w[X0 + i])):
        return DONE
    pole = (w[CODE + i] == FRICTIONAL) & ((not folded) | (w[X_END + i] > 0))
    return ROUGH if pole else PLAIN


@compiled
def serve(
    v: Array, kept: Array, n: int, table: Array, state: Array, rule: Array, size: int, plates: bool, out: Array
) -> None:  # fmt: skip
    """Work of the first n lanes of ``v``, the designs ``kept``; those that want more nodes go to the table."""
    works.work(v, rule, 0, size, n >= 0, n < 0, plates)
    for i in range(n):
        at = kept[i]
        if v[S1 + i] > 0:
            out[at, WORK], state[at] = v[S0 + i], DONE
        else:
            for row in range(FEW):
                table[at, row] = v[row * W + i]


@compiled
def first_pass(
    w: Array, v: Array, table: Array, state: Array, designs: tuple[Array, ...], mirrored: bool, index: Array,
    base: int, n: int, steps: Array, size: int, rule: Array, plates: bool, margin: float, out: Array, code: Array,
    neighbour: Array,
) -> None:  # fmt: skip
    """Take n designs from ``base`` on, in the order ``index``, as far as they go with one look.

    The designs of a block whose work has a pole are put beside each other in ``v``, and served when that is full.
    """
    # a flag as such, not as a constant, for which Numba would compile every step anew
    unfolded, waiting = n < 0, 0
    kept = np.empty(W, np.int64)
    for start in range(0, n, W):
        count = min(W, n - start)
        eta, beta, lam, alpha, theta0, mu, _ = designs
        for i in range(W):
            at = base + index[start + min(i, count - 1)]
            w[ETA + i], w[BETA + i], w[LAM + i] = eta[at], beta[at], lam[at]
            w[X + i], w[THETA0 + i], w[MU + i] = alpha[at], theta0[at], mu[at]
        for i in range(W):
            sa = OPS.sin(w[X + i])
            w[SA + i], w[CA + i] = -sa if mirrored else sa, OPS.cos(w[X + i])
        others.engage(w)
        for i in range(W):
            k = max(w[K + i], 1.0)
            w[X0 + i], w[X1 + i], w[THETA_F + i], w[CODE + i] = w[THETA0 + i], TURNED, 0.0, 0.0
            for row in range(3):
                w[row * W + i] = w[row * W + i] / k
        ends.coarse(w, steps, unfolded, plates)
        for i in range(count):
            at = index[start + i]
            out[at, LOAD_E], neighbour[base + at] = w[LOADE + i], int(w[K + i])
            w[STATE + i] = DONE if w[OK + i] == 1 else (FOLDS if w[OK + i] == 2 else AGAIN)
            if w[K + i] == 0:
                w[STATE + i], code[base + at] = DONE, NONE
                for row in range(F0, ANSWER):
                    out[at, row] = 0.0
                out[at, THETA_END] = out[at, THETA_C] = w[THETA0 + i]
                out[at, LOAD_END], out[at, LOAD_C] = w[LOADE + i], 0.0
            elif w[STATE + i] != DONE:
                for row in range(CARRIED):
                    table[at, row] = w[row * W + i]
        for i in range(W):
            if (w[OK + i] != 1) | (w[K + i] == 0):
                # keeps the root finder still
                w[FIRST + i], w[A + i], w[B + i] = 0.0, w[X0 + i], w[X0 + i]
        ends.solve_ends(w, unfolded, plates, SWEEPS)
        for i in range(count):
            at = index[start + i]
            if (w[STATE + i] == DONE) & (w[K + i] > 0):
                if w[OK + i] == 0:
                    w[STATE + i] = AGAIN
                    for row in range(CARRIED):
                        table[at, row] = w[row * W + i]
                else:
                    give_ends(w, out, i, at)
        crossings.clear(w, unfolded)
        works.cut(w, margin, unfolded)
        for i in range(W):
            w[X + i] = w[X_C + i]
        lanes.figures(w, unfolded, plates)
        for i in range(count):
            at = index[start + i]
            if (w[STATE + i] == DONE) & (w[K + i] > 0):
                if w[OK + i] == 0:
                    w[STATE + i] = CROSSED
                else:
                    give_figures(w, out, i, at)
                    w[STATE + i] = waits_for(w, i, unfolded)
            state[at] = int(w[STATE + i])
            if w[STATE + i] == ROUGH:
                for row in range(FEW):
                    v[row * W + waiting] = w[row * W + i]
                kept[waiting] = at
                waiting += 1
                if waiting == W:
                    serve(v, kept, waiting, table, state, rule, size, plates, out)
                    waiting = 0
            elif w[STATE + i] >= CROSSED:
                for row in range(FEW):
                    table[at, row] = w[row * W + i]
            if (w[K + i] > 0) & (w[STATE + i] != AGAIN) & (w[STATE + i] != FOLDS):
                code[base + at] = int(w[CODE + i])
    if waiting > 0:
        for i in range(waiting, W):
            for row in range(FEW):
                v[row * W + i] = v[row * W]
        serve(v, kept, waiting, table, state, rule, size, plates, out)

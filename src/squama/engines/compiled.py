"""The Numba engine: the same kernel and the same steps as the numpy engine, compiled and in lock-step blocks.

What is unusual is left to the numpy engine: paths with a deep dip of a margin between samples, work that needs very
many nodes, and bending. Threads take turns at parts of some thousand designs; no design's answer depends on the others.
"""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

import numpy as np
from numba import config

from squama.engines import Problem, Solved
from squama.engines import numpy as plain
from squama.engines.compiled_entry import ready, solve_all
from squama.engines.compiled_first import (
    FOLD_AT,
    LOAD_C,
    LOAD_END,
    PARAMETER,
    THETA_C,
    THETA_END,
    TORQUE_C,
    WORK,
)  # fmt: skip
from squama.engines.compiled_rules import legendre_rules, pole_rules
from squama.model import energy
from squama.model.ends import FOLDED_STEPS, STEPS
from squama.model.outcome import CODES, End
from squama.model.paths import FoldedTwist, Twist
from squama.model.solve import Array

__all__ = ["ready", "run"]
PART = 8192
"""Designs a thread takes at a time."""


def run(p: Problem, threads: int | None = None) -> Solved:
    """Answer every design of a problem.

    Parameters
    ----------
    threads
        Threads to work with; NUMBA_NUM_THREADS (all cores unless set) by default.
    """
    if p.load == "bending":
        return plain.run(p)
    n = p.eta.size
    out, code, neighbour = np.empty((8, n)), np.empty(n, np.int8), np.empty(n, np.int64)
    elastic, red = np.empty((2, n))
    late: list[tuple[Array, Array]] = []
    pole_rules(p.margin), legendre_rules()  # made once, before the threads ask for them

    def answer(low: int) -> None:
        here = slice(low, min(n, low + PART))
        part = _take(p, here)
        found = _follow(part, code[here], neighbour[here])
        rough = np.flatnonzero(np.isnan(found[WORK]) & (code[here] >= 0))
        late.append((low + rough, found[:, rough]))
        out[:, here] = found[:8]
        elastic[here], red[here] = _energies(part, out[:, here])

    lows = range(0, n, PART)
    workers = min(threads or int(getattr(config, "NUMBA_NUM_THREADS", 1)), len(lows))
    if workers > 1:
        with ThreadPoolExecutor(workers) as pool:
            list(pool.map(answer, lows))
    else:
        for low in lows:
            answer(low)
    if late:
        # in the order of the designs, whichever thread was first
        index, rows = (np.concatenate(parts, axis=-1) for parts in zip(*sorted(late, key=_lowest), strict=True))
        for fold in (False, True):
            some = np.flatnonzero((rows[FOLD_AT] > 0) == fold)
            at = index[some]
            if at.size:
                out[WORK, at] = _works(_take(p, at), rows[:, some], code[at], neighbour[at])
                red[at] = _red(elastic[at], out[WORK, at])
    load_e, theta_end, load_end, theta_c, load_c, f0, torque, work = out[:8]
    solved = Solved(load_e, theta_end, load_end, code, neighbour, theta_c, load_c, f0, torque, elastic, work, red)
    left = np.flatnonzero(code < 0)
    if left.size:
        for mine, theirs in zip(solved, plain.run(_take(p, left)), strict=True):
            mine[left] = theirs
    return solved


def _lowest(part: tuple[Array, Array]) -> float:
    return float(part[0][0]) if part[0].size else np.inf


def _take(p: Problem, index: slice | Array) -> Problem:
    columns = ("eta", "beta", "lam", "alpha", "theta0", "mu", "ratio")
    return p._replace(**{name: getattr(p, name)[index] for name in columns})


def _columns(p: Problem) -> Array:
    sa = np.sin(p.alpha) * (1 if p.sense == "+" else -1)
    return np.stack([p.eta, p.beta, p.lam, sa, np.cos(p.alpha), p.theta0, p.mu])


def _follow(p: Problem, code: Array, neighbour: Array) -> Array:
    """Rows of the answer of :mod:`squama.engines.compiled_table`."""
    n = p.eta.size
    out = np.zeros((10, n))
    rules = (*pole_rules(p.margin), *legendre_rules())
    solve_all(_columns(p), 0, n, p.law == "plate", p.margin, STEPS, FOLDED_STEPS, *rules, out, code, neighbour)
    none = code == CODES.index(End.NONE)
    for row in (THETA_END, THETA_C):
        out[row, none] = p.theta0[none]
    out[LOAD_END, none] = np.inf
    return out


def _works(p: Problem, out: Array, code: Array, neighbour: Array) -> Array:
    """Frictional work of designs whose paths all fold or all do not, by the numpy engine's rule."""
    eta, beta, lam, sa, ca, x0, mu = _columns(p)
    k, x_end, theta_f = neighbour.astype(float), out[PARAMETER], out[FOLD_AT]
    row: Twist | FoldedTwist = Twist(eta, beta, lam, sa, ca, p.theta0, k)
    if theta_f[0] > 0:
        row, x0 = FoldedTwist(eta, beta, lam, sa, ca, p.theta0, theta_f, k), -np.sqrt(theta_f - p.theta0)
    x_c = energy.cutoff(row, x0, x_end, np.isin(code, plain.LOCKS), p.margin)
    return energy.works(row, x0, x_c, energy.pole(row, x_end, mu, p.law, x0), mu, p.law)


def _energies(p: Problem, out: Array) -> tuple[Array, Array]:
    """Elastic energy and RED; adds the beam's own part to the torque."""
    load_c = out[LOAD_C]
    elastic = (p.ratio * load_c**2 + (out[THETA_C] - p.theta0) ** 2) / 2
    out[TORQUE_C] += p.ratio * load_c
    return elastic, _red(elastic, out[WORK])


def _red(elastic: Array, work: Array) -> Array:
    total: Array = elastic + work
    red: Array = np.divide(work, total, out=np.zeros_like(work), where=total > 0)
    return red

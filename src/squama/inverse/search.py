"""Many starts at once: a screen of points all over the bounds, then Gauss-Newton steps under linearised limits.

All starts are evaluated together (:mod:`squama.batch`). A step is the least-squares step inside a box around the
point, inside the bounds, and inside the limits as they are linearised there; it is taken if the merit falls, else the
box shrinks. So a step that loses the lock, or meets another contact of the plates first, is not taken.
"""

from __future__ import annotations

import copy

import numpy as np

from squama.inverse.residuals import PRICE, Look, Residuals
from squama.progress import steps
from squama.types import Array

BEST = 400
"""Points of the screen whose plates are tested against each other."""
SPREAD = 0.06
"""Least distance of two starts, in the unit cube, per root of the number of variables."""
ROUNDS = 60
BEND = 1.0
"""How far limits may bend, per square of a step."""
STILL = 1e-12
"""Relative gain of a step at which a point counts as settled."""
LATE, HOPELESS = 24, 2.0
"""Steps after which points whose merit is that many times the best are left."""
DAMPING = 1e-7
SMALL = 1e-13
WIDEST, FIRST = 0.5, 0.15
"""Half widths of the box of a step, of the unit cube."""


def sobol(n: int, m: int, seed: int) -> Array:
    """Return n points of a scrambled Sobol sequence in the unit cube of m dimensions."""
    from scipy.stats import qmc

    power = int(np.ceil(np.log2(max(n, 2))))
    return np.asarray(qmc.Sobol(m, scramble=True, rng=np.random.default_rng(seed)).random_base2(power))[:n]


def screen(target: Residuals, first: Array, n: int, keep: int, seed: int) -> Array:
    """Return the best points of a screen, spread out; ``first`` (m,) is the starting beam."""
    y = np.vstack([first, sobol(n, len(first), seed)])
    merit = target.look(y, slopes=False, plates=False).merit
    y = y[np.argsort(merit, kind="stable")[:BEST]]
    look = target.look(y, slopes=False, plates=True)
    order = np.argsort(look.merit, kind="stable")
    order = order[np.isfinite(look.merit[order])]
    chosen: list[int] = []
    least = SPREAD * np.sqrt(len(first))
    for i in order:
        if len(chosen) < keep and all(np.linalg.norm(y[i] - y[j]) >= least for j in chosen):
            chosen.append(int(i))
    chosen += [int(i) for i in order if i not in chosen][: keep - len(chosen)]
    return y[chosen]


def refine(target: Residuals, y: Array) -> Look:
    """Return the designs at which the search ends, from starts (n, m) in the unit cube."""
    # arrays of its own, which may be written to
    best = copy.deepcopy(target.look(y, slopes=True, plates=True))
    n = len(y)
    radius = np.full(n, FIRST)
    live = np.isfinite(best.merit)
    for turn in steps(range(ROUNDS), ROUNDS, "steps of the search"):
        lanes = np.flatnonzero(live)
        if not lanes.size:
            break
        ways = np.array([_step(best, int(i), radius[i]) for i in lanes])
        trial = np.clip(best.y[lanes] + ways, 0.0, 1.0)
        look = target.look(trial, slopes=True, plates=True)
        gain = best.merit[lanes] - look.merit
        promised = np.array([best.merit[i] - _model(best, int(i), trial[k] - best.y[i]) for k, i in enumerate(lanes)])
        better = gain > 0
        size = np.abs(trial - best.y[lanes]).max(axis=1)
        with np.errstate(all="ignore"):
            ratio = np.where(promised > 0, gain / promised, 0.0)
        # where the border holds a step back the box shrinks too, and lets the next one nearer to it
        wide = np.where(ratio > 0.7, 2.0, 1.0) * np.clip(radius[lanes], size, np.maximum(2 * size, radius[lanes] / 8))
        radius[lanes] = np.where(ratio > 0.2, np.minimum(wide, WIDEST), np.minimum(size, radius[lanes]) / 3)
        _adopt(best, look, lanes[better], np.flatnonzero(better))
        done = (radius[lanes] < SMALL) | (best.merit[lanes] < 1e-26) | (better & (gain < STILL * best.merit[lanes]))
        if turn >= LATE:
            done |= best.merit[lanes] > HOPELESS * best.merit.min()
        live[lanes[done]] = False
    return best


def _adopt(best: Look, look: Look, to: Array, of: Array) -> None:
    """Replace points ``to`` by the better ones ``of`` another evaluation."""
    best.y[to] = look.y[of]
    for name in ("r", "J", "g", "G", "merit", "d", "scales"):
        getattr(best, name)[..., to] = getattr(look, name)[..., of]
    for mine, theirs in zip(best.found, look.found, strict=True):
        mine[..., to] = theirs[..., of]


def _step(look: Look, i: int, radius: float) -> Array:
    """Return the step (m,) of point i inside a box of half width ``radius``."""
    m = look.y.shape[1]
    # a residual without a slope (a figure that is not there) has nothing to say
    J, r = look.J[:, :, i], look.r[:, i]
    E = np.vstack([J, np.sqrt(DAMPING) * np.eye(m)])
    f = np.append(-r, np.zeros(m))
    low, high = np.maximum(-look.y[i], -radius), np.minimum(1 - look.y[i], radius)
    box, edge = np.vstack([np.eye(m), -np.eye(m)]), np.append(low, -high)
    # limits and the border of the domain may bend: keep off them as far as they may bend within the box
    g, G = look.g[:, i] - BEND * radius**2, look.G[:, :, i]
    step = lsi(E, f, np.vstack([box, G]), np.append(edge, -g))
    if step is None:
        # the limits cannot all be kept inside the box: as far as they can
        broken = g < 0
        E = np.vstack([E, PRICE * G[broken]])
        f = np.append(f, -PRICE * g[broken])
        step = lsi(E, f, np.vstack([box, G[~broken]]), np.append(edge, -g[~broken]))
    return np.zeros(m) if step is None else np.clip(step, low, high)


def _model(look: Look, i: int, step: Array) -> float:
    """Return the merit of point i after a step, by the linear model."""
    r = look.r[:, i] + look.J[:, :, i] @ step
    g = look.g[:, i] + look.G[:, :, i] @ step
    return float(0.5 * r @ r + PRICE * np.maximum(-g, 0).sum())


def lsi(E: Array, f: Array, G: Array, h: Array) -> Array | None:
    """Return x that minimises |E x - f| under G x >= h; None where the inequalities contradict each other.

    E (k, m) has full column rank. Source: Lawson and Hanson, Solving Least Squares Problems, chapter 23. With E = Q R
    and z = R x - Q^T f this is the vector of least length in a polyhedron, whose dual is one non-negative least squares
    problem.

    >>> print(lsi(np.eye(2), np.array([2.0, 1.0]), np.array([[-1.0, 0.0]]), np.array([-0.5])))
    [0.5 1. ]
    """
    from scipy.optimize import nnls

    Q, R = np.linalg.qr(E)
    start: Array = np.linalg.solve(R, Q.T @ f)
    if np.all(G @ start >= h):
        return start
    A = np.linalg.solve(R.T, G.T).T
    b = h - G @ start
    # rows of one size keep the small problem well scaled; one of nothing but zeros holds anyway, or never
    size = np.linalg.norm(A, axis=1)
    empty = size == 0
    if np.any(h[empty] > 0):
        return None
    A, b = A[~empty] / size[~empty, None], b[~empty] / size[~empty]
    top = max(float(np.abs(b).max()), 1e-300)
    M, unit = np.vstack([A.T, b / top]), np.append(np.zeros(A.shape[1]), 1.0)
    try:
        u, _ = nnls(M, unit, maxiter=50 * b.size)
    except RuntimeError:
        return None
    rest = M @ u - unit
    if abs(rest[-1]) < 1e-13:
        return None
    return np.asarray(start + np.linalg.solve(R, -rest[:-1] / rest[-1] * top))

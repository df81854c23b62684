"""Search from many starts: a screen of points over the bounds, then Gauss-Newton steps under linearised limits.

All starts are evaluated together (:mod:`squama.batch`). A step minimises the linearised residuals inside a box around
the point, inside the bounds and the linearised limits; it is taken if the merit falls, else the box shrinks. A step
that loses the lock, or after which other plates meet first, raises the merit and is not taken.

The search computes endless beams, whose end scales have all neighbours. A figure at a twist of a beam with N scales is
that of the endless beam times a share. The share changes little between neighbouring designs: it is computed at a
design, kept while the design is refined, and computed anew.
"""

from __future__ import annotations

import copy
import itertools
from collections.abc import Callable

import numpy as np

from squama.inverse import joint_figures
from squama.inverse.residuals import PRICE, Ends, Look, Residuals
from squama.inverse.target import Target
from squama.loads import ENDLESS
from squama.progress import steps
from squama.types import Array

BEST = 400
"""Points of the screen whose plates are all tested against each other."""
SPREAD = 0.06
"""Least distance of two starts in the unit cube, over the root of the number of variables."""
ROUNDS = 60
BEND = 1.0
"""Allowance for the curvature of limits, per square of a step."""
STILL = 1e-12
"""Relative gain of a step below which a point counts as converged."""
LATE, HOPELESS = 24, 2.0
"""Number of steps after which points with HOPELESS times the best merit are dropped."""
DAMPING = 1e-7
SMALL = 1e-13
WIDEST, FIRST = 0.5, 0.15
"""Largest and first half width of the box of a step, in the unit cube."""
CORNERS = 8
"""Largest number of dimensions whose roundings up and down are all tried; for more, as many are drawn at random."""
NEIGHBOURS = 4
"""Number of searches among the neighbours on the grid."""
GOOD = 1e-12
"""Merit below which a design meets all goals."""
AWAY = 1e-9
"""Merit per squared distance from the unrounded design, in steps: among equal designs the nearest is taken."""
REPEATS, NEAR = 6, 2e-3
"""Largest number of refinements with a design's own ends; the change of a figure that calls for another one."""
TYPICAL, LIKELY = 5, 4
"""Number of designs whose shares give the typical share; designs refined, beyond two per wanted design."""
APART, POWERS = 0.02, (0.1, 2.0)
"""Least change of the logarithm of an endless figure from which a power is taken; bounds of powers."""


def sobol(n: int, m: int, seed: int) -> Array:
    """Return n points of a scrambled Sobol sequence in the unit cube of m dimensions, (n, m)."""
    from scipy.stats import qmc

    power = int(np.ceil(np.log2(max(n, 2))))
    return np.asarray(qmc.Sobol(m, scramble=True, rng=np.random.default_rng(seed)).random_base2(power))[:n]


def screen(target: Residuals, first: Array, n: int, keep: int, seed: int) -> Array:
    """Return good points (``keep``, m) of a screen of n points, spread out; ``first`` (m,) is the starting beam."""
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
    """Return the refined designs from starts (n, m) in the unit cube."""
    # own arrays, because they are overwritten
    best = copy.deepcopy(target.look(y, slopes=True, plates=True))
    radius = np.full(len(y), FIRST)
    live = np.isfinite(best.merit)
    for turn in steps(range(ROUNDS), ROUNDS, "steps of the search"):
        lanes = np.flatnonzero(live)
        if not lanes.size:
            break
        moves = np.array([_step(best, int(i), radius[i]) for i in lanes])
        look = target.look(np.clip(best.y.T[lanes] + moves, 0.0, 1.0), slopes=True, plates=True)
        moved = (look.y - best.y[:, lanes]).T
        gain = best.merit[lanes] - look.merit
        promised = np.array([best.merit[i] - _model(best, int(i), move) for i, move in zip(lanes, moved, strict=True)])
        better = gain > 0
        size = np.abs(moved).max(axis=1)
        with np.errstate(all="ignore"):
            ratio = np.where(promised > 0, gain / promised, 0.0)
        # a step held back by a border shrinks the box, so that the next step can come nearer to it
        wide = np.where(ratio > 0.7, 2.0, 1.0) * np.clip(radius[lanes], size, np.maximum(2 * size, radius[lanes] / 8))
        radius[lanes] = np.where(ratio > 0.2, np.minimum(wide, WIDEST), np.minimum(size, radius[lanes]) / 3)
        for mine, other in zip(best, look, strict=True):
            mine[..., lanes[better]] = other[..., better]
        done = (radius[lanes] < SMALL) | (best.merit[lanes] < 1e-26) | (better & (gain < STILL * best.merit[lanes]))
        if turn >= LATE:
            done |= best.merit[lanes] > HOPELESS * best.merit.min()
        live[lanes[done]] = False
    return best


def _step(look: Look, i: int, radius: float) -> Array:
    """Return the step (m,) of point i inside a box of half width ``radius``."""
    m = len(look.y)
    # residuals of missing figures have derivative 0 and do not count
    J, r = look.J[:, :, i], look.r[:, i]
    E = np.vstack([J, np.sqrt(DAMPING) * np.eye(m)])
    f = np.append(-r, np.zeros(m))
    low, high = np.maximum(-look.y[:, i], -radius), np.minimum(1 - look.y[:, i], radius)
    box, edge = np.vstack([np.eye(m), -np.eye(m)]), np.append(low, -high)
    # limits and borders are curved: keep off them by their possible curvature within the box
    g, G = look.g[:, i] - BEND * radius**2, look.G[:, :, i]
    step = lsi(E, f, np.vstack([box, G]), np.append(edge, -g))
    if step is None:
        # no point of the box keeps all limits: penalise the broken ones
        broken = g < 0
        E = np.vstack([E, PRICE * G[broken]])
        f = np.append(f, -PRICE * g[broken])
        step = lsi(E, f, np.vstack([box, G[~broken]]), np.append(edge, -g[~broken]))
    return np.zeros(m) if step is None else np.clip(step, low, high)


def _model(look: Look, i: int, step: Array) -> float:
    """Return the merit of point i after a step, by the linearised residuals and limits."""
    r = look.r[:, i] + look.J[:, :, i] @ step
    return float(0.5 * r @ r + PRICE * np.maximum(-look.g[:, i] - look.G[:, :, i] @ step, 0).sum())


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
    # rows of equal norm keep the problem well scaled; a row of zeros always holds, or never
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


def rounded(residuals: Residuals, y: Array, seed: int = 1) -> Array:
    """Return designs (n, m) on the grid of the steps: the best neighbour of each on the grid."""
    space = residuals.space
    grid = [v for v in space.variables if v.step]
    if not grid:
        return y
    sizes = np.array([v.step for v in grid])
    low, high = np.array([v.multiples for v in grid], float).T
    values = space.values(y)
    exact = np.stack([values[v.key] for v in grid], axis=1) / sizes

    def place(which: Array, multiples: Array) -> Array:
        """Return points (k, m) of designs ``which`` (k,) with multiples (k, g) of the steps."""
        at = {key: column[which] for key, column in values.items()}
        return space.place(at | {v.key: column for v, column in zip(grid, (multiples * sizes).T, strict=True)})

    rng = np.random.default_rng(seed)
    best = np.clip(np.round(exact), low, high)
    merit = np.full(len(y), np.inf)
    for turn in range(NEIGHBOURS):
        live = np.flatnonzero(merit > GOOD)
        if not live.size:
            break
        moves = _around(len(grid)) if turn else _corners(len(grid), rng)
        base = best[live] if turn else np.floor(exact[live])
        tried = np.clip(base[:, None] + moves, low, high)
        points = place(np.repeat(live, len(moves)), tried.reshape(-1, len(grid)))
        found = residuals.look(points, slopes=False, plates=True).merit.reshape(live.size, -1)
        first = np.argmin(found + AWAY * ((tried - exact[live, None]) ** 2).sum(axis=2), axis=1)
        lanes = np.arange(live.size)
        better = found[lanes, first] < merit[live]
        best[live[better]] = tried[lanes, first][better]
        merit[live[better]] = found[lanes, first][better]
        if turn and not better.any():
            break
    return place(np.arange(len(y)), best)


def _corners(k: int, rng: np.random.Generator) -> Array:
    """Return roundings down (0) and up (1) of k numbers, (combinations, k)."""
    if k <= CORNERS:
        return np.array(list(itertools.product((0.0, 1.0), repeat=k)))
    return rng.integers(0, 2, (2**CORNERS, k)).astype(float)


def _around(k: int) -> Array:
    """Return steps of one or two units of k numbers, (combinations, k)."""
    one = np.concatenate([np.eye(k), -np.eye(k)])
    two = [a + b for a, b in itertools.combinations(one, 2) if np.any(a + b)]
    return np.array([*one, *two])


def with_ends(target: Target, look: Look, count: int, seed: int) -> tuple[Look, Array]:
    """Refine designs for their own number of scales; return them, and their figures' derivatives by endless ones."""
    some = [_ends(target, look.y[:, [i]].T) for i in _best(look, TYPICAL)]
    if known := [one.share for one in some if np.isfinite(one.own).all()]:
        typical = np.median(np.concatenate(known, axis=1), axis=1, keepdims=True)
        look = refine(Residuals(target, Ends.none(len(typical))._replace(own=typical)), look.y.T)
    best = _best(look, LIKELY + 2 * count)
    found = [_with_ends(target, look.y[:, [i]].T, seed) for i in steps(best.tolist(), best.size, "designs refined")]
    # drop designs whose curves end before the twist, unless there are no others
    found = [one for one in found if np.isfinite(one[1].own).all()] or found
    looks, ends = zip(*found, strict=True)
    joined = Look(*(np.concatenate(parts, axis=-1) for parts in zip(*looks, strict=True)))
    return joined, np.concatenate([one.rates for one in ends], axis=1)


def _best(look: Look, n: int) -> Array:
    """Return the indices of the n best designs with finite merit."""
    best = np.argsort(look.merit, kind="stable")[:n]
    return best[np.isfinite(look.merit[best])]


def _with_ends(target: Target, y: Array, seed: int) -> tuple[Look, Ends]:
    """Refine a design (1, m) for its own number of scales, and round it to the grid of the steps."""

    def settled(y: Array, ends: Ends, move: Callable[[Residuals, Array], Array]) -> tuple[Array, Ends]:
        for _ in range(REPEATS):
            y = move(Residuals(target, ends), y)
            last, ends = ends, _ends(target, y, ends)
            # (a beam whose curve ends before the twist has NaN and stays as it is)
            with np.errstate(divide="ignore", invalid="ignore"):
                off = np.abs(last.figures(ends.endless, ends.endless[:, None])[0] / ends.own - 1).max()
            if not off >= NEAR:
                break
        return y, ends

    exact, ends = settled(y, _ends(target, y), lambda residuals, y: refine(residuals, y).y.T)
    if any(v.step for v in target.space.variables):
        y, ends = settled(exact, ends, lambda residuals, _: rounded(residuals, exact, seed))
    else:
        y = exact
    return Residuals(target, ends).look(y, slopes=True, plates=True), ends


def _ends(target: Target, y: Array, before: Ends | None = None) -> Ends:
    """Return a design's figures beside those of the endless beam, NaN where its curve ends before.

    The power is that between this design and the one ``before``, whose power is kept where they hardly differ.
    """
    wants, beam = [goal.want for goal in target.goals], target.space.beam_of(y[0])
    own, endless = (
        np.array(joint_figures.followed(beam, wants, target.options, ends=ends)[0])[:, None] for ends in (None, ENDLESS)
    )
    alone = np.array([want.at is None for want in wants])[:, None]
    ends = Ends(np.where(alone, endless, own), endless, np.ones_like(own))
    if before is None:
        return ends
    with np.errstate(divide="ignore", invalid="ignore"):
        moved, by = np.log(np.abs(endless / before.endless)), np.log(np.abs(ends.own / before.own))
        power = np.where(np.abs(moved) > APART, np.clip(by / moved, *POWERS), before.power)
    return ends._replace(power=np.where(np.isfinite(power), power, 1.0))

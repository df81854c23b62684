"""Blocks of designs in lock-step: one flat array holds a row of lanes for every quantity.

All loops run over the lanes of a block, without branches, on rows of one array whose distances are constants: that is
what LLVM needs to compute several designs in one instruction.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from squama.engines.compiled_kernel import OPS, compiled, decay, edge, inlined, plate
from squama.model import solve, twisting
from squama.model.mechanics import forces
from squama.model.paths import FoldedTwist, Twist
from squama.model.solve import Array

place, reached = inlined(solve.place), inlined(solve.reached)

W = 32
"""Lanes of a block."""
# the design, in units of k pitches, and the range of its path
ETA, BETA, LAM, SA, CA, THETA0, THETA_F, MU, K, X0, X1 = (W * n for n in range(11))
# what is known of its end, and the bracket of a root (X_C: the cut-off, once the end is known)
X_END, CODE, REACH, B, A, C, FA, FB, FC, FIRST, FOLD = (W * n for n in range(11, 22))
X_C = B
"""The cut-off, once the end is known, stands in the row of one end of its bracket."""
FEW, CARRIED = 15, 22
"""Rows that travel between a block and the table of all designs: without the bracket, and with it."""
TURNED = math.radians(179)
"""Largest inclination looked at (``ends.half_turn``)."""
X, LOW, QQ, T, OK, BEST, LOADE = (W * n for n in range(22, 29))
THETA, LOAD, D, FORCE, TORQUE, STATE, RATE, TIP, SIDE, TURN = (W * n for n in range(29, 39))
S0, S1, S2, P1, P2, R1, R2, COS, SIN, COSJ, SINJ, H, HALF, LEAN, SN = (W * n for n in range(39, 54))
F_SN, F_CS, F_S, F_H = (W * n for n in range(54, 58))
"""What the path needs of the terms of the contact condition at the fold."""
PAST = W * 58
"""Ten rows: the contact conditions of five neighbours at the two samples before."""
HERE, BEFORE = W * 68, W * 69
R_THETA, R_SN, R_CS, R_S, R_H, R_G, R_Q2, R_Q, R_PER_X = (W * n for n in range(70, 79))
"""Terms of the contact condition at X and its root, kept between the two halves of an evaluation."""
SPAN = W * 79
"""Length of the path that is sampled, or of the part of it."""
ROWS = 80
SCRATCH = W * 160
"""Room for what is kept of the samples of a path."""


@inlined
def open_row(w: Array, i: int) -> Twist:
    """Return the row of lane i."""
    return Twist(w[ETA + i], w[BETA + i], w[LAM + i], w[SA + i], w[CA + i], w[THETA0 + i], 1.0)


@inlined
def at_fold(w: Array, i: int) -> twisting.Root:
    """Return what is known of the fold of lane i."""
    return twisting.Root(w[F_SN + i], w[F_CS + i], w[F_S + i], w[F_H + i], 0.0, 0.0)


@inlined
def folded_row(w: Array, i: int) -> FoldedTwist:
    """Return the folded row of lane i."""
    return FoldedTwist(w[ETA + i], w[BETA + i], w[LAM + i], w[SA + i], w[CA + i], w[THETA0 + i], w[THETA_F + i], 1.0)


@inlined
def _lower(a: float, b: float) -> float:
    """Return the smaller of two, or b where it is no number."""
    return a if a < b else b


@inlined
def _keep(w: Array, i: int, solved: Any) -> None:
    theta, r, q, per_x = solved
    w[R_THETA + i], w[R_SN + i], w[R_CS + i], w[R_S + i] = theta, r.sn, r.cs, r.S
    w[R_H + i], w[R_G + i], w[R_Q2 + i], w[R_Q + i], w[R_PER_X + i] = r.H, r.G, r.q2, q, per_x


@inlined
def kept(w: Array, i: int) -> Any:
    """Return what a row's ``solve`` gives, as :func:`roots` left it for lane i."""
    r = twisting.Root(w[R_SN + i], w[R_CS + i], w[R_S + i], w[R_H + i], w[R_G + i], w[R_Q2 + i])
    return w[R_THETA + i], r, w[R_Q + i], w[R_PER_X + i]


@compiled
def roots(w: Array, folded: bool) -> None:
    """Terms of the contact condition at X, and its root."""
    if folded:
        for i in range(W):
            _keep(w, i, folded_row(w, i).solve_from(at_fold(w, i), w[X + i], OPS))
    else:
        for i in range(W):
            _keep(w, i, open_row(w, i).solve(w[X + i], OPS))


@compiled
def roots_at(w: Array, part: float, folded: bool) -> None:
    """Go to the fraction ``part`` of SPAN from X0 on: X, the terms of the contact condition there, and its root."""
    # in one loop, for LLVM takes short loops apart before it could compute several lanes at once
    if folded:
        for i in range(W):
            w[X + i] = w[X0 + i] + w[SPAN + i] * part
            _keep(w, i, folded_row(w, i).solve_from(at_fold(w, i), w[X + i], OPS))
    else:
        for i in range(W):
            w[X + i] = w[X0 + i] + w[SPAN + i] * part
            _keep(w, i, open_row(w, i).solve(w[X + i], OPS))


def _over(body: Callable[..., None]) -> Callable[[Array, bool], None]:
    """Run a body over the lanes of a block, with either law, where their roots are known.

    A loop of its own: in shorter chains of operations a core finds more to do at once.
    """

    @compiled
    def run(w: Array, plates: bool) -> None:
        if plates:
            for i in range(W):
                body(w, i, open_row(w, i), kept(w, i), plate)
        else:
            for i in range(W):
                body(w, i, open_row(w, i), kept(w, i), edge)

    return run


@inlined
def _look(w: Array, i: int, row: Twist, solved: Any, law: Any) -> None:
    theta, r, q, per_x = solved
    pt = row.at_root(theta, r, q, per_x, law, OPS)
    tip, side = row.places(pt)
    balance = -(pt.M_N + w[MU + i] * pt.M_f)
    w[RATE + i], w[D + i], w[TIP + i], w[SIDE + i], w[TURN + i] = pt.load_rate, balance, tip, side, pt.turn
    w[LOW + i] = _lower(_lower(tip, side), _lower(pt.turn, _lower(pt.load_rate, balance)))
    w[QQ + i] = r.q2


@inlined
def _figures(w: Array, i: int, row: Twist, solved: Any, law: Any) -> None:
    theta, r, q, per_x = solved
    pt = row.at_root(theta, r, q, per_x, law, OPS)
    f = forces(pt, row.theta0, w[MU + i])
    tip, side = row.places(pt)
    w[THETA + i], w[LOAD + i], w[D + i], w[FORCE + i], w[TORQUE + i] = theta, pt.load, f.D, f.f, f.torque
    w[RATE + i], w[TIP + i], w[SIDE + i], w[TURN + i] = pt.load_rate, tip, side, pt.turn


@inlined
def _push(w: Array, i: int, row: Twist, solved: Any, law: Any) -> None:
    theta, r, q, per_x = solved
    pt = row.at_root(theta, r, q, per_x, law, OPS)
    w[FORCE + i] = forces(pt, row.theta0, w[MU + i]).f * pt.slip_rate


look_here = _over(_look)
figures_here = _over(_figures)
push_here = _over(_push)


@compiled
def look(w: Array, folded: bool, plates: bool) -> None:
    """Smallest margin LOW and squared root QQ at X."""
    roots(w, folded)
    look_here(w, plates)


@compiled
def look_at(w: Array, part: float, folded: bool, plates: bool) -> None:
    """Look at the fraction ``part`` of SPAN."""
    roots_at(w, part, folded)
    look_here(w, plates)


@compiled
def figures(w: Array, folded: bool, plates: bool) -> None:
    """All figures of the contact at X."""
    roots(w, folded)
    figures_here(w, plates)


@compiled
def square(w: Array) -> None:
    """Square of the root at X on the open path (negative beyond a fold)."""
    for i in range(W):
        w[LOW + i] = open_row(w, i).root(w[X + i], OPS).q2


@compiled
def folds(w: Array) -> None:
    """Terms of the contact condition at the folds."""
    for i in range(W):
        r = open_row(w, i).root(w[THETA_F + i], OPS)
        w[F_SN + i], w[F_CS + i], w[F_S + i], w[F_H + i] = r.sn, r.cs, r.S, r.H


@compiled
def start_root(w: Array) -> None:
    """First place to look for the zero between A (positive) and B, if C (beyond A) is a third known point."""
    for i in range(W):
        t, safe = place(w[A + i], w[FA + i], w[B + i], w[FB + i], w[C + i], w[FC + i])
        w[T + i] = t if safe else 0.5
        w[X + i] = w[A + i] + w[T + i] * (w[B + i] - w[A + i])
        w[OK + i] = 0.0
        w[BEST + i] = w[A + i]


@compiled
def next_root(w: Array) -> bool:
    """Take in the value LOW at X, choose the next X; whether all lanes have converged (their zeros are in BEST)."""
    left = 0
    for i in range(W):
        value = w[LOW + i]
        f = value if value == value else -1.0  # noqa: PLR0124
        x, x1, f1, x2, f2 = w[X + i], w[A + i], w[FA + i], w[B + i], w[FB + i]
        same = (f > 0) == (f1 > 0)
        x3, f3 = x1 if same else x2, f1 if same else f2
        x2, f2 = x2 if same else x1, f2 if same else f1
        best = x if abs(f) < abs(f2) else x2
        tol = 2e-15 * abs(best) + 1e-300
        width = abs(x2 - x)
        t, safe = place(x, f, x2, f2, x3, f3)
        t = t if safe else 0.5
        # the next place itself is the zero, to all digits, where the interpolation hardly moves any more
        near = (t >= 0) & reached(t * (x2 - x), x, f, x1, f1)
        best = x + t * (x2 - x) if near else best
        step = max(tol, min(width - tol, t * width))
        done = w[OK + i] > 0
        w[BEST + i] = w[BEST + i] if done else best
        now = done | near | (width <= 2 * tol) | (f == 0)
        w[OK + i] = 1.0 if now else 0.0
        w[A + i], w[FA + i], w[B + i], w[FB + i], w[X + i] = x, f, x2, f2, x + (step if x2 > x else -step)
        left += 0 if now else 1
    return left == 0


@compiled
def spread(w: Array, node: float) -> None:
    """Place of a node of the rule in y between X0 and the cut-off; P1 is the reach to the pole, P2 the last y."""
    for i in range(W):
        p, fall = decay(w[P2 + i] * node)
        w[X + i] = w[X0 + i] + w[P1 + i] * fall
        w[R1 + i] = w[P1 + i] * w[P2 + i] * p

"""Newton's method for the state with given contacts; compiled."""

from __future__ import annotations

import numpy as np

from squama.batch.keeping import part as _jit
from squama.contacts import touch
from squama.contacts.equations import residual
from squama.contacts.jacobian import jacobian
from squama.contacts.linear import RESIDUALS, SOLVED, Linear, factor, laid_out, substitute
from squama.contacts.meeting import Work, prepared
from squama.contacts.supports import moved_alone, shifted
from squama.contacts.system import STRAINS, Past, State, System, freedoms, strain_columns
from squama.contacts.touch import places_of
from squama.types import Array

TIGHT, TIGHTER = 1e-11, 1e-13
"""Remaining error of the unknowns, estimated from the last two corrections; with the Jacobian of another state, whose
corrections fall in proportion."""
ROUNDED = 1e-8
"""Size of corrections that may stall at rounding errors, mostly in places where plates are nearly tangent."""
_ROUNDS, _LARGEST, _LOST, _QUICK, _STALLED = 30, 0.4, 3.0, 0.2, 0.1
"""Iterations; largest correction that is applied, and at which the iteration fails; ratios of successive corrections to
keep a Jacobian, and to count as stalled.
"""
_KEPT, _SLOWEST, _NOISE = 1e-3, 0.5, 4.0
"""For a row, whose Jacobian takes as long as a dozen corrections: largest correction, and ratio of successive ones,
with which it is kept; corrections are rounding up to so many times those that were."""
_TRIED, _STUCK, _HALF = 10, 0.7, 0.5
"""Iterations for a row after which corrections that do not shrink by a ratio are halved."""


@_jit
def shift(S: System, st: State, con: Array, m: int, at: Array, n: int, x: Array, by: complex) -> None:
    """Add a multiple ``by`` of changes (n,) of the unknowns to a state."""
    N = len(S.shapes)
    for i in range(N):
        for a in range(freedoms(S)):
            st.q[i, a] += by * x[at[i] + a]
    for c in range(m):
        o = at[N + c]
        if con[c, touch.KIND] == touch.LIES:
            st.F[c, 0] += by * x[o]
            continue
        for a in range(3):
            st.F[c, a] += by * x[o + a]
        for a in range(places_of(con[c, touch.KIND])):
            st.s[c, a] += by * x[o + 3 + a]
    if S.own:
        shifted(S, st, at, n, x, by)
        return
    columns = strain_columns(S, at, n, 0)
    for e in range(STRAINS):
        if columns[e] >= 0:
            st.strains[0, e] += by * x[columns[e]]


@_jit
def solve(
    S: System, st: State, past: Past, con: Array, m: int, W: Work, J: Linear, loads: Array, near: float = 0.0
) -> bool:
    """Solve for the state with the given contacts, from the guess in ``st``; update W and ``loads`` to the solution.

    The Jacobian of another state is kept for a first correction up to ``near``.
    """
    n = laid_out(S, con, m, J)
    if n < 0:
        return False
    loose, several = S.own, len(S.shapes) > S.stride
    for e in range(STRAINS):
        loose = loose or S.free[e] > 0
    old, fresh, moved, own = np.inf, False, True, J.kept[SOLVED] != n
    for count in range(_ROUNDS):
        prepared(S, st, con, m, moved, W)
        moved = loose
        residual(S, st, past, con, m, J.at, n, W, J.r, loads)
        J.kept[RESIDUALS] += 1
        if J.kept[SOLVED] != n:
            jacobian(S, st, past, con, m, n, W, J)
            if not factor(J, n):
                J.kept[SOLVED] = 0
                return False
            J.kept[SOLVED], fresh, own = n, True, True
        substitute(J, n, J.r)
        moved_alone(S, J.at, J.r)
        size = 0.0
        for a in range(n):
            size = max(size, abs(J.r[a]))
        if not size < _LOST:
            J.kept[SOLVED] = 0
            if fresh:
                return False
            old = np.inf
            continue
        # of several scales, forces that change sign, and with them their friction, may throw it to and fro
        share = _HALF if several and count >= _TRIED and size > _STUCK * old else 1.0
        shift(S, st, con, m, J.at, n, J.r, -share * min(1.0, _LARGEST / max(size, 1e-300)))
        known = old < np.inf
        rate = min(size / old, 1.0) if known else 1.0
        rounded = ROUNDED if own else _NOISE * J.noise[0] if several else 0.0
        stalled = known and rate > _STALLED and size < rounded
        if stalled or size * rate < (TIGHT if own else TIGHTER):
            if own:
                J.noise[0] = size if stalled else 0.0
            prepared(S, st, con, m, moved, W)
            residual(S, st, past, con, m, J.at, n, W, J.r, loads)
            return True
        if several:
            renewed = size > _KEPT or (known and rate > _SLOWEST)
        else:
            renewed = size > _LARGEST or (rate > (_QUICK if own else _STALLED) if known else own or size > near)
        if renewed:
            J.kept[SOLVED] = 0
        old, fresh = size, False
    J.kept[SOLVED] = 0
    return False

"""Newton's method for a state whose contacts are given; compiled."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from squama.batch.keeping import part as _jit
from squama.contacts.equations import Work, jacobian, prepared, residual
from squama.contacts.system import KIND, MOTIONS, STRAINS, Past, State, System, layout, places_of, strain_columns
from squama.types import Array

TIGHT = 1e-11
"""Error of the unknowns that is left, estimated from the last two corrections."""
ROUNDED = 1e-8
"""Corrections, mostly of places where plates are nearly tangent, that may stall at what rounding leaves."""
_ROUNDS, _LARGEST, _LOST, _QUICK, _STALLED = 30, 0.4, 3.0, 0.2, 0.1
"""Iterations; largest correction that is taken, and that is given up at; by how much corrections must fall to keep a
Jacobian, and not to stall."""


class Linear(NamedTuple):
    """A factored Jacobian (n, n), its row exchanges, its residual, first unknowns of scales and contacts; ``kept`` (2,):
    how many unknowns it is of, 0 for none, and how many residuals were evaluated.
    """

    A: Array
    order: Array
    r: Array
    at: Array
    kept: Array


@_jit
def factor(A: Array, order: Array, n: int) -> bool:
    """Factor a matrix in place with row exchanges, its zeros left out; False where it is singular."""
    for k in range(n):
        best, p = abs(A[k, k]), k
        for i in range(k + 1, n):
            if abs(A[i, k]) > best:
                best, p = abs(A[i, k]), i
        if not 0.0 < best < 1e300:
            return False
        order[k] = p
        if p != k:
            for j in range(n):
                A[k, j], A[p, j] = A[p, j], A[k, j]
        last, over = n - 1, 1 / A[k, k]
        while A[k, last] == 0.0:
            last -= 1
        for i in range(k + 1, n):
            if A[i, k] != 0.0:
                f = A[i, k] * over
                A[i, k] = f
                for j in range(k + 1, last + 1):
                    A[i, j] -= f * A[k, j]
    return True


@_jit
def substitute(A: Array, order: Array, n: int, x: Array) -> None:
    """Solve with a factored matrix in place."""
    for k in range(n):
        p = order[k]
        if p != k:
            x[k], x[p] = x[p], x[k]
    for i in range(n):
        out = x[i]
        for j in range(i):
            out -= A[i, j] * x[j]
        x[i] = out
    for i in range(n - 1, -1, -1):
        out = x[i]
        for j in range(i + 1, n):
            out -= A[i, j] * x[j]
        x[i] = out / A[i, i]


@_jit
def shift(S: System, st: State, con: Array, m: int, at: Array, n: int, x: Array, by: float) -> None:
    """Add a multiple of unknowns (n,) to a state."""
    N = len(S.shapes)
    for i in range(N):
        for a in range(MOTIONS):
            st.q[i, a] += by * x[at[i] + a]
    for c in range(m):
        o = at[N + c]
        for a in range(3):
            st.F[c, a] += by * x[o + a]
        for a in range(places_of(con[c, KIND])):
            st.s[c, a] += by * x[o + 3 + a]
    columns = strain_columns(S, n)
    for e in range(STRAINS):
        if columns[e] >= 0:
            st.strains[e] += by * x[columns[e]]


@_jit
def solve(S: System, st: State, past: Past, con: Array, m: int, W: Work, J: Linear, loads: Array) -> bool:
    """Solve for the state of given contacts from the guess that it holds; W, ``loads`` are those of the solution."""
    n = layout(S, con, m, J.at)
    loose = False
    for e in range(STRAINS):
        loose = loose or S.free[e] > 0
    old, fresh, moved = np.inf, False, True
    for _ in range(_ROUNDS):
        prepared(S, st, con, m, moved, W)
        moved = loose
        residual(S, st, past, con, m, J.at, n, W, J.r, loads)
        J.kept[1] += 1
        if J.kept[0] != n:
            jacobian(S, st, past, con, m, J.at, n, W, J.A)
            if not factor(J.A, J.order, n):
                J.kept[0] = 0
                return False
            J.kept[0], fresh = n, True
        substitute(J.A, J.order, n, J.r)
        size = 0.0
        for a in range(n):
            size = max(size, abs(J.r[a]))
        if not size < _LOST:
            J.kept[0] = 0
            if fresh:
                return False
            old = np.inf
            continue
        shift(S, st, con, m, J.at, n, J.r, -min(1.0, _LARGEST / max(size, 1e-300)))
        rate = min(size / old, 1.0) if old < np.inf else 1.0
        if size * rate < TIGHT or (size < ROUNDED and rate > _STALLED):
            prepared(S, st, con, m, moved, W)
            residual(S, st, past, con, m, J.at, n, W, J.r, loads)
            return True
        if rate > _QUICK or size > _LARGEST:
            J.kept[0] = 0
        old, fresh = size, False
    J.kept[0] = 0
    return False

"""Derivatives of the plates' deflections at contacts with respect to the forces on them; compiled."""

from __future__ import annotations

from squama.batch.keeping import part as _jit
from squama.contacts import touch
from squama.contacts.geometry import back, normal, powers, turn, vector
from squama.contacts.linear import FAR, INNER, Linear, start
from squama.contacts.meeting import Work, clear
from squama.contacts.system import (
    ELASTIC,
    POWERS,
    STRAINS,
    TILT,
    State,
    System,
    partner,
    pieces,
    spots,
    strain_columns,
)
from squama.contacts.touch import unknown
from squama.contacts.vectors import by_vector, cross, dot, scaled, turned
from squama.types import Array


@_jit
def lifts(S: System, st: State, con: Array, m: int, W: Work) -> bool:
    """Write the data for derivatives of deflections: powers at all places, and deflections under unit loads there.

    Returns whether any plate is elastic.
    """
    any_ = False
    for i in range(len(S.shapes)):
        W.first[i] = -1
    for c in range(m):
        row = con[c]
        if row[touch.KIND] == touch.LIES:
            continue
        i, j = row[touch.FIRST], partner(S, row)
        x1, y1, x2, y2 = spots(S, row, st.s[c])
        F = vector(st.F[c], 0)
        for side in range(2):
            a, x, y, o = (i, x1, y1, 2 * c) if side == 0 else (j, x2, y2, 2 * c + 1)
            if not S.shapes[a, ELASTIC] > 0:
                continue
            any_ = True
            W.next[o], W.first[a] = W.first[a], o
            powers(S, a, x, y, W.powers[o])
            for f in range(3):
                out = W.bent[o, f]
                clear(out)
                for p in range(POWERS):
                    v = W.powers[o, f, p]
                    for b in range(POWERS):
                        out[b] += S.plates[a, p, b] * v
            up = normal(W.E[a])
            W.side[o] = dot(F, up) if side == 0 else -dot(F, turn(W.pairs[i, row[touch.APART] - 1], up))
    return any_


@_jit
def lifted(
    S: System, st: State, con: Array, at: Array, n: int, c: int, side: int, W: Work, begin: int, end: int
) -> None:
    """Write the derivatives (3, n) of lift and slopes at a place, by the forces on its plate alone, into W.lifts.

    They are with respect to unknowns from ``begin`` to before ``end``, and to free strains that all cells share.
    """
    N, own, o = len(S.shapes), W.lifts[3 * side : 3 * side + 3], 2 * c + side
    columns = shared(S, at, n)
    for f in range(3):
        for b in range(begin, end):
            own[f, b] = 0.0
        for e in range(STRAINS):
            if columns[e] >= 0:
                own[f, columns[e]] = 0.0
    a = con[c, touch.FIRST] if side == 0 else partner(S, con[c])
    if not S.shapes[a, ELASTIC] > 0:
        return
    up0 = normal(W.E[a])
    turning = turned(vector(st.q[a], 3))
    q = W.first[a]
    while q >= 0:
        d, other = q // 2, q % 2
        row, first = con[d], at[N + d]
        P, F = W.pairs[row[touch.FIRST], row[touch.APART] - 1], vector(st.F[d], 0)
        places = unknown(row[touch.KIND], row[touch.ONE], row[touch.OTHER])
        up = up0 if other == 0 else scaled(-1.0, turn(P, up0))
        # the load is F . up, so that a turn o changes it by o . (up x F)
        moment = cross(up, F)
        by_w = by_vector(turning, moment if other == 0 else back(P, moment))
        ix, iy = (places[0], places[1]) if other == 0 else (places[2], places[3])
        for f in range(3):
            v = vx = vy = 0.0
            for p in range(POWERS):
                v += W.powers[o, f, p] * W.bent[q, 0, p]
                vx += W.powers[o, f, p] * W.bent[q, 1, p]
                vy += W.powers[o, f, p] * W.bent[q, 2, p]
            for b in range(3):
                own[f, first + b] += v * up[b]
                own[f, at[a] + 3 + b] += v * by_w[b]
            if other == 1:
                for p in range(pieces(S, row[touch.APART])):
                    strained = strain_columns(S, at, n, row[touch.FIRST] + p * S.stride)
                    for e in range(STRAINS):
                        if strained[e] >= 0:
                            own[f, strained[e]] += v * dot(vector(P, 12 + 24 * p + 6 * e), moment)
                for last in range(2 if S.own else 0):
                    tilted = at[a if last else row[touch.FIRST]] + TILT
                    own[f, tilted] += v * dot(vector(P, 12 + 24 * pieces(S, row[touch.APART]) + 6 * last), moment)
            if ix >= 0:
                own[f, first + 3 + ix] += vx * W.side[q]
            if iy >= 0:
                own[f, first + 3 + iy] += vy * W.side[q]
        q = W.next[q]


@_jit
def around(S: System, J: Linear, a: int) -> tuple[int, int]:
    """Return the range of unknowns, first and behind the last, on which a plate's deflection may depend."""
    if S.periodic and not S.own:
        return 0, J.kept[INNER]
    cell = a // S.stride
    return start(S, J, cell - J.kept[FAR]), start(S, J, cell + 1)


@_jit
def shared(S: System, at: Array, n: int) -> tuple[int, int, int, int]:
    """Return the unknowns of strains that all cells share; -1 for imposed strains, and for strains of single cells."""
    return (-1, -1, -1, -1) if S.own else strain_columns(S, at, n, 0)

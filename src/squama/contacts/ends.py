r"""Ends of a row whose cells have strains of their own: what cells carry, and what is asked of the ends; compiled.

With the strains e_i of cell i, the part of the energy and of the contacts' forces in its own axes balances what the
load at the ends is there, R_i::

    K_e . (q_i, e_i) + sum F . dp2/de_i = R_i

    loose     R_i is 0 of strains that are free, and alike in all cells of those that are loaded, whose sum is imposed
    gripped   R_i = W . X_i, with W the wrench on the far end and X_i the motion of that end per strain of cell i, both
              as the near end sees them: turn (o, v) and wrench (m, f) about the near end

The frames of the bar's ends are half a pitch beyond the first and the last scale. Of gripped ends the far one stands on
the near one's axis and looks along it, turned about it by N times the twist that is imposed; it may come nearer,
without an axial force, or keeps its distance.

As strains of cells before cell i move its section by s_i, X_i changes by the bracket (s x o, s x v + t x o) of both.
These s_i, linear in the strains' changes, are unknowns of the equations' derivatives alone: so they remain a band.
"""

from __future__ import annotations

import math

from squama.batch.keeping import inlined as _in
from squama.batch.keeping import part as _jit
from squama.contacts.geometry import PLACED, RATES, chain, vector
from squama.contacts.linear import Linear, enter
from squama.contacts.meeting import Work
from squama.contacts.system import (
    EPS,
    GRIPPED,
    LOADED,
    PHI,
    STRAINS,
    State,
    System,
    ahead,
    borders,
    strain_columns,
)
from squama.contacts.vectors import Vector, add, cross, dot, scaled
from squama.types import Array

LOADS, GIVEN = range(2)
"""Rows of a state's ends."""


@_in
def moves(W: Work, i: int, e: int) -> tuple[Vector, Vector]:
    """Return the motion of the far end per strain e of cell i, as the near end sees it: turn, and shift there."""
    at = PLACED + RATES * i + 6 * e
    return vector(W.bar, at), vector(W.bar, at + 3)


@_in
def load_on(S: System, st: State, W: Work, i: int, e: int) -> float:
    """Return what the load at the ends is of cell i's strain e."""
    none = 0.0 * st.ends[LOADS, 0]
    if S.ends == GRIPPED:
        o, v = moves(W, i, e)
        load: float = dot(vector(st.ends[LOADS], 0), o) + dot(vector(st.ends[LOADS], 3), v)
        return load
    alike: float = st.ends[LOADS, e] if S.free[e] == LOADED else none
    return alike


@_jit
def tied(S: System, st: State, at: Array, n: int, W: Work, r: Array, loads: Array) -> None:
    """Write the residuals of all cells' strains and of the ends; loads that are imposed take the place of means."""
    N, b = len(S.shapes), n - borders(S)
    if S.ends == GRIPPED:
        none = 0.0 * st.ends[LOADS, 0]
        chain(S, st.strains, 0, N, 1.0, W.section, (none, none, none), W.bar)
    for i in range(N):
        columns = strain_columns(S, at, n, i)
        for e in range(STRAINS):
            if columns[e] >= 0:
                r[columns[e]] = W.carried[i, e] - load_on(S, st, W, i, e)
        for a in range(at[i] - ahead(S), at[i] - ahead(S) + 6 if S.ends == GRIPPED else 0):
            r[a] = 0.0
    if S.ends == GRIPPED:
        gripped(S, st, b, W, r)
        loads[PHI], loads[EPS] = -st.ends[LOADS, 2], st.ends[LOADS, 5]
        return
    for e in range(STRAINS):
        if S.free[e] == LOADED:
            r[b] = -N * st.ends[GIVEN, e]
            for i in range(N):
                r[b] += st.strains[i, e]
            loads[e] = st.ends[LOADS, e]
            b += 1


@_jit
def target(S: System, st: State) -> tuple[Vector, Vector]:
    """Return where x and y of the near end are to be at the far one."""
    turn = -len(S.shapes) * st.ends[GIVEN, PHI] * S.sees[0, PHI]
    # sine and cosine, complex steps included
    s, c = math.sin(turn.real), math.cos(turn.real)
    step = turn - turn.real
    return (c - s * step, s + c * step, 0.0 * step), (-s - c * step, c - s * step, 0.0 * step)


@_jit
def gripped(S: System, st: State, b: int, W: Work, r: Array) -> None:
    """Write by how much the far end is off the near one's axis, in the order of turns and shifts, from row b on."""
    R, N = W.bar, len(S.shapes)
    x, y = target(S, st)
    r[b], r[b + 1] = -R[5], R[2]
    r[b + 2] = (dot(y, (R[0], R[3], R[6])) - dot(x, (R[1], R[4], R[7]))) / 2
    r[b + 3], r[b + 4] = R[9], R[10]
    if S.free[EPS] == LOADED:
        r[b + 5] = R[11] - N * (1.0 + st.ends[GIVEN, EPS])


@_jit
def ties(S: System, st: State, at: Array, n: int, W: Work, J: Linear) -> None:
    """Enter the derivatives of :func:`tied`, without those of what cells carry."""
    N, b = len(S.shapes), n - borders(S)
    if S.ends == GRIPPED:
        grips(S, st, at, n, W, J)
        return
    for e in range(STRAINS):
        if S.free[e] == LOADED:
            for i in range(N):
                column = strain_columns(S, at, n, i)[e]
                enter(J, column, b, -1.0)
                enter(J, b, column, 1.0)
            b += 1


@_jit
def grips(S: System, st: State, at: Array, n: int, W: Work, J: Linear) -> None:
    """Enter the derivatives of gripped ends."""
    N, first, b = len(S.shapes), ahead(S), n - borders(S)
    m, f = vector(st.ends[LOADS], 0), vector(st.ends[LOADS], 3)
    R, t = W.bar, vector(W.bar, 9)
    axis, (x, y) = (R[2], R[5], R[8]), target(S, st)
    turned = scaled(0.5, add(cross((R[0], R[3], R[6]), y), -1.0, cross((R[1], R[4], R[7]), x)))
    for i in range(N):
        here, columns = at[i] - first, strain_columns(S, at, n, i)
        behind, before = (at[i - 1] - first, strain_columns(S, at, n, i - 1)) if i > 0 else (-1, columns)
        for a in range(6):
            enter(J, here + a, here + a, 1.0)
            if behind >= 0:
                enter(J, here + a, behind + a, -1.0)
        for e in range(STRAINS):
            o, v = moves(W, i, e)
            row = columns[e]
            by_turn, by_shift = add(cross(o, m), 1.0, cross(v, f)), cross(o, f)
            for a in range(3):
                enter(J, row, here + a, -by_turn[a])
                enter(J, row, here + 3 + a, -by_shift[a])
                enter(J, row, b + a, -o[a])
                if 3 + a < n - b:
                    enter(J, row, b + 3 + a, -v[a])
            # a cell's own strains move its middle by half
            for other in range(STRAINS):
                p, u = moves(W, i, other)
                enter(J, row, columns[other], -(dot(p, by_turn) + dot(u, by_shift)) / 2)
            shift = add(v, 1.0, cross(o, t))
            enter(J, b, row, o[0] * axis[2] - o[2] * axis[0])
            enter(J, b + 1, row, o[1] * axis[2] - o[2] * axis[1])
            enter(J, b + 2, row, dot(o, turned))
            for a in range(3):
                if 3 + a < n - b:
                    enter(J, b + 3 + a, row, shift[a])
            if behind >= 0:
                p, u = moves(W, i - 1, e)
                for a in range(3):
                    enter(J, here + a, before[e], -p[a])
                    enter(J, here + 3 + a, before[e], -u[a])


@_jit
def shifted(S: System, st: State, at: Array, n: int, x: Array, by: complex) -> None:
    """Add a multiple of unknowns (n,) to strains of cells and to loads at the ends."""
    b = n - borders(S)
    for i in range(len(S.shapes)):
        columns = strain_columns(S, at, n, i)
        for e in range(STRAINS):
            if columns[e] >= 0:
                st.strains[i, e] += by * x[columns[e]]
    if S.ends == GRIPPED:
        for a in range(n - b):
            st.ends[LOADS, a] += by * x[b + a]
        return
    for e in range(STRAINS):
        if S.free[e] == LOADED:
            st.ends[LOADS, e] += by * x[b]
            b += 1


@_jit
def moved_alone(S: System, at: Array, x: Array) -> None:
    """Leave out of a correction how far sections move, which no state holds."""
    if S.ends == GRIPPED:
        for i in range(len(S.shapes)):
            for a in range(6):
                x[at[i] - ahead(S) + a] = 0.0

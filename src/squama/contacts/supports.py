r"""Supports and loads of a bar whose cells have strains of their own: balance of the cells, and ties; compiled.

For the strains e_i of cell i, the elastic and contact forces of the cell balance the loads beyond it::

    K_e . (q_i, e_i) + sum F . dp2/de_i = W_i . X_i + sum L_k c_k

with X_i the motion of all beyond cell i per strain of it, and W_i the wrench of all loads there, both in the frame
of the clamped near end: motion (o, v) and wrench (m, f) about its origin. The loads are the loads L_k of ties
(``squama.contacts.system.Ties``): each is the multiplier of a coordinate that is imposed, as the twist of an end
is by a torque, or the travel of a tip along the force on it. A tie adds L_k c_k to all cells alike, forces L_k f to
sections, the moment conjugate to a rotation that it holds, and a couple on the far end.

As cells before cell i are strained, its section moves by s_i, X_i changes by the bracket (s x o, s x v + t x o) of
both, and W_i with the places of the loads beyond. All s_i and changes of W_i, linear in those of the unknowns, are
unknowns of the equations' derivatives alone: so they remain a band.
"""

from __future__ import annotations

import numpy as np

from squama.batch.keeping import inlined as _in
from squama.batch.keeping import part as _jit
from squama.contacts.geometry import PLACED, back, over_cell, put, turn, vector
from squama.contacts.linear import Linear, enter
from squama.contacts.meeting import Work
from squama.contacts.system import (
    AXIS,
    CHI,
    EPS,
    LOADED,
    PHI,
    PSI,
    SECTION,
    SPIN,
    STRAINS,
    State,
    System,
    before_cell,
    borders,
    cells,
    of_tie,
    sectioned,
    strain_columns,
)
from squama.contacts.vectors import Vector, add, cross, dot, rotated, scaled, spin, turned, unit
from squama.types import Array

LOADS, GIVEN = range(2)
"""Rows of a state's ties: loads, and prescribed values."""


@_jit
def spine(S: System, st: State, W: Work) -> None:
    """Write the frames of all sections, and the motions of all that is beyond a cell per strain of it."""
    none, K = 0.0 * st.strains[0, 0], len(S.ties.course)
    x, y, z, t = unit(0, none), unit(1, none), unit(2, none), (none, none, none)
    if S.ties.floating:
        e = turned(vector(st.ties[LOADS], K))
        x, y, z, t = rotated(e, x), rotated(e, y), rotated(e, z), vector(st.ties[LOADS], K + 3)
    for i in range(cells(S) + 1):
        R = W.frames[i]
        for r in range(3):
            R[3 * r], R[3 * r + 1], R[3 * r + 2] = x[r], y[r], z[r]
        put(t, R, 9)
        if i == cells(S):
            return
        over_cell(S, st.strains, i * S.stride, 1.0, W.section, (none, none, none), W.cell)
        for strain in range(STRAINS):
            o = turn(R, vector(W.cell, PLACED + 6 * strain))
            v = turn(R, vector(W.cell, PLACED + 6 * strain + 3))
            put(o, W.moves[i, strain], 0)
            put(add(v, 1.0, cross(t, o)), W.moves[i, strain], 3)
        C = W.cell
        x, y, z = turn(R, (C[0], C[3], C[6])), turn(R, (C[1], C[4], C[7])), turn(R, (C[2], C[5], C[8]))
        t = add(t, 1.0, turn(R, vector(C, 9)))


@_in
def moves(W: Work, i: int, e: int) -> tuple[Vector, Vector]:
    """Return the motion of all that is beyond cell i per strain e of it: rotation, and translation at the origin."""
    return vector(W.moves[i, e], 0), vector(W.moves[i, e], 3)


@_in
def bracket(o: Vector, v: Vector, p: Vector, u: Vector) -> tuple[Vector, Vector]:
    """Return the change of the motion (p, u), each rotation and translation, that is moved along (o, v)."""
    return cross(o, p), add(cross(o, u), 1.0, cross(v, p))


@_in
def screw(st: State, i: int, W: Work) -> tuple[Vector, Vector]:
    """Return the motion from cell i's near to its far section, see :func:`moves`."""
    o, v = moves(W, i, EPS)
    for e in range(STRAINS):
        p, u = moves(W, i, e)
        o, v = add(o, st.strains[i, e], p), add(v, st.strains[i, e], u)
    return o, v


@_jit
def aim(S: System, st: State, k: int, v: Vector) -> Vector:
    """Return a vector turned by the rotation that tie k prescribes for its section."""
    course = vector(S.ties.turns[k], SPIN)
    return rotated(turned(scaled(st.ties[GIVEN, k], course)), v)


@_jit
def askew(S: System, st: State, W: Work, k: int) -> Vector:
    """Return the deviation of tie k's section from its prescribed rotation: the vector part of R T^T."""
    R, none = W.frames[int(S.ties.turns[k, SECTION])], 0.0 * st.ties[LOADS, k]
    out = (none, none, none)
    for a in range(3):
        out = add(out, 0.5, cross(aim(S, st, k, unit(a, none)), (R[a], R[3 + a], R[6 + a])))
    return out


@_jit
def moment_of(S: System, st: State, W: Work, k: int) -> Vector:
    """Return the moment of a unit load of tie k on the section whose rotation it holds."""
    R, axis, none = W.frames[int(S.ties.turns[k, SECTION])], vector(S.ties.turns[k], AXIS), 0.0 * st.ties[LOADS, k]
    trace = none
    for a in range(3):
        trace += dot(aim(S, st, k, unit(a, none)), (R[a], R[3 + a], R[6 + a]))
    return add(scaled(0.5 * trace, axis), -0.5, aim(S, st, k, back(R, axis)))


@_jit
def bisected(S: System, W: Work, k: int) -> tuple[Vector, float]:
    """Return the sum of the axis of tie k's couple at the near and at the far end, and 1 + the cosine between them.

    Axes have the size of the couple.
    """
    a = vector(S.ties.couples[k], 0)
    far = turn(W.frames[cells(S)], a)
    return add(a, 1.0, far), 1.0 + dot(a, far) / max(dot(a, a), 1e-300)


@_jit
def couple(S: System, W: Work, k: int) -> Vector:
    """Return the moment on the far end of a unit load of tie k: it turns the end about an axis and lets it tilt.

    The rotation R of the end is a rotation about the axis a, by the angle p, followed by a tilt about an axis across a.
    The couple that does work on p alone bisects the axes of both ends: m = (a + R a)/(1 + a . R a).
    """
    both, q = bisected(S, W, k)
    return scaled(1.0 / q, both)


@_jit
def couple_moved(S: System, W: Work, k: int, o: Vector) -> Vector:
    """Return the change of :func:`couple` for a rotation o of the far end."""
    a = vector(S.ties.couples[k], 0)
    both, q = bisected(S, W, k)
    change = cross(o, add(both, -1.0, a))
    return add(scaled(1.0 / q, change), -dot(a, change) / max(dot(a, a), 1e-300) / (q * q), both)


@_jit
def turned_by(S: System, st: State, W: Work, k: int) -> float:
    """Return the angle p by which the far end is turned about the axis of tie k's couple, times its size.

    Of the angles that differ by whole turns it is the nearest to the sum over all cells.
    """
    a, N = vector(S.ties.couples[k], 0), cells(S)
    R = W.frames[N]
    size = np.sqrt(dot(a, a))
    q = 1.0 + dot(a, turn(R, a)) / (size * size)
    vee = (R[7] - R[5], R[2] - R[6], R[3] - R[1])
    sine, cosine = dot(a, vee) / (size * q), (R[0] + R[4] + R[8] + 1.0) / q - 1.0
    angle = np.arctan2(sine.real, cosine.real)
    total = 0.0
    for i in range(N):
        total -= (a[0] * st.strains[i, PSI] + a[1] * st.strains[i, CHI] + a[2] * st.strains[i, PHI]).real
    whole = 2 * np.pi * np.round((total / size.real - angle) / (2 * np.pi))
    # the last part is 0, except for complex steps
    by: float = size * (angle + whole + sine * np.cos(angle) - cosine * np.sin(angle))
    return by


@_jit
def load_at(S: System, st: State, W: Work, j: int) -> tuple[Vector, Vector]:
    """Return the wrench (moment, force) of all ties on section j."""
    none = 0.0 * st.strains[0, 0]
    m, f = (none, none, none), (none, none, none)
    for k in range(len(S.ties.course)):
        f = add(f, st.ties[LOADS, k], vector(S.ties.forces[k, j], 0))
        if S.ties.turns[k, SECTION] == j:
            m = add(m, st.ties[LOADS, k], moment_of(S, st, W, k))
        if j == cells(S):
            m = add(m, st.ties[LOADS, k], couple(S, W, k))
    return add(m, 1.0, cross(vector(W.frames[j], 9), f)), f


@_jit
def load_moved(S: System, st: State, W: Work, j: int, o: Vector, v: Vector) -> Vector:
    """Return the change of all ties' moment on section j for its rotation o and its translation v at the origin."""
    none = 0.0 * st.strains[0, 0]
    m, f = (none, none, none), (none, none, none)
    for k in range(len(S.ties.course)):
        f = add(f, st.ties[LOADS, k], vector(S.ties.forces[k, j], 0))
        if S.ties.turns[k, SECTION] == j:
            axis = vector(S.ties.turns[k], AXIS)
            other = aim(S, st, k, back(W.frames[j], cross(o, axis)))
            change = add(scaled(-dot(askew(S, st, W, k), o), axis), 0.5, other)
            m = add(m, st.ties[LOADS, k], change)
        if j == cells(S):
            m = add(m, st.ties[LOADS, k], couple_moved(S, W, k, o))
    return add(m, 1.0, cross(add(v, 1.0, cross(o, vector(W.frames[j], 9))), f))


@_jit
def unit_load(S: System, st: State, W: Work, k: int, j: int) -> tuple[Vector, Vector]:
    """Return the wrench of a unit load of tie k on section j; it is also the gradient of the tie's coordinate."""
    f = vector(S.ties.forces[k, j], 0)
    m = cross(vector(W.frames[j], 9), f)
    if S.ties.turns[k, SECTION] == j:
        m = add(m, 1.0, moment_of(S, st, W, k))
    return (add(m, 1.0, couple(S, W, k)) if j == cells(S) else m), f


@_jit
def wrenches(S: System, st: State, W: Work) -> None:
    """Write the wrench of all loads on and beyond each section."""
    none = 0.0 * st.strains[0, 0]
    m, f = (none, none, none), (none, none, none)
    for j in range(cells(S), -1, -1):
        own_m, own_f = load_at(S, st, W, j)
        m, f = add(m, 1.0, own_m), add(f, 1.0, own_f)
        put(m, W.wrench[j], 0)
        put(f, W.wrench[j], 3)


@_jit
def tied(S: System, st: State, at: Array, n: int, W: Work, r: Array, loads: Array) -> None:
    """Write the residuals of all cells' strains and of ties; the ties' loads replace the mean loads."""
    N, K, along = cells(S), len(S.ties.course), sectioned(S)
    if along:
        spine(S, st, W)
        wrenches(S, st, W)
    for i in range(N):
        columns = strain_columns(S, at, n, i * S.stride)
        for e in range(STRAINS):
            if columns[e] >= 0:
                load = 0.0 * st.strains[0, 0]
                for k in range(K):
                    load += st.ties[LOADS, k] * S.ties.carried[k, i, e]
                if along:
                    o, v = moves(W, i, e)
                    load += dot(o, vector(W.wrench[i + 1], 0)) + dot(v, vector(W.wrench[i + 1], 3))
                r[columns[e]] = W.carried[i, e] - load
        for a in range(12 if along else 0):
            r[before_cell(S, at, i) + a] = 0.0
    for k in range(K):
        r[of_tie(S, at, k)] = coordinate(S, st, W, k)
    for a in range(borders(S) - K):
        r[of_tie(S, at, K + a)] = W.wrench[0, a]
    for e in range(STRAINS):
        if S.free[e] == LOADED:
            loads[e] = 0.0
            for k in range(K):
                if S.ties.course[k, 0] == e:
                    share = S.ties.course[k, 1] + dot(vector(S.ties.turns[k], AXIS), vector(S.ties.turns[k], SPIN))
                    loads[e] += st.ties[LOADS, k] * share / N


@_jit
def coordinate(S: System, st: State, W: Work, k: int) -> float:
    """Return the difference of tie k's coordinate from its prescribed value."""
    off: float = -S.ties.course[k, 1] * st.ties[GIVEN, k]
    for i in range(cells(S)):
        for e in range(STRAINS):
            if S.ties.carried[k, i, e] != 0.0:
                off += S.ties.carried[k, i, e] * st.strains[i, e]
    for j in range(S.ties.forces.shape[1]):
        p = vector(W.frames[j], 9)
        off += dot(vector(S.ties.forces[k, j], 0), (p[0], p[1], p[2] - j))
    if S.ties.turns[k, SECTION] >= 0:
        off += dot(vector(S.ties.turns[k], AXIS), askew(S, st, W, k))
    if dot(vector(S.ties.couples[k], 0), vector(S.ties.couples[k], 0)) > 0.0:
        off += turned_by(S, st, W, k)
    return off


@_jit
def tie_rates(S: System, st: State, at: Array, n: int, W: Work, J: Linear) -> None:
    """Add the derivatives of :func:`tied` to the Jacobian, without those of the cells' own loads."""
    N, K = cells(S), len(S.ties.course)
    for i in range(N):
        columns = strain_columns(S, at, n, i * S.stride)
        for k in range(K):
            b = of_tie(S, at, k)
            for e in range(STRAINS):
                if columns[e] >= 0 and S.ties.carried[k, i, e] != 0.0:
                    enter(J, columns[e], b, -S.ties.carried[k, i, e])
                    enter(J, b, columns[e], S.ties.carried[k, i, e])
    if not sectioned(S):
        return
    for i in range(N):
        section_rates(S, st, at, n, i, W, J)
    for k in range(K):
        for j in range(N + 1):
            m, f = unit_load(S, st, W, k, j)
            if dot(m, m) + dot(f, f) > 0.0:
                by_section(S, at, n, of_tie(S, at, k), j, m, f, W, J)
    if S.ties.floating:
        floating_rates(S, st, at, W, J)


@_jit
def by_section(S: System, at: Array, n: int, row: int, j: int, m: Vector, f: Vector, W: Work, J: Linear) -> None:
    """Add to a row the derivatives by the motion of section j: by its rotation (m), and its translation (f)."""
    i = min(j, cells(S) - 1)
    here = before_cell(S, at, i)
    for a in range(3):
        enter(J, row, here + a, m[a])
        enter(J, row, here + 3 + a, f[a])
    if i < j:
        columns = strain_columns(S, at, n, i * S.stride)
        for e in range(STRAINS):
            if columns[e] >= 0:
                o, v = moves(W, i, e)
                enter(J, row, columns[e], dot(o, m) + dot(v, f))


@_jit
def section_rates(S: System, st: State, at: Array, n: int, i: int, W: Work, J: Linear) -> None:
    """Add the derivatives of cell i's motion, of the wrench beyond it, and of its work on the cell's strains."""
    N = cells(S)
    here, columns = before_cell(S, at, i), strain_columns(S, at, n, i * S.stride)
    beyond = here + 6
    m, f = vector(W.wrench[i + 1], 0), vector(W.wrench[i + 1], 3)
    for a in range(6):
        enter(J, here + a, here + a, 1.0)
        enter(J, beyond + a, beyond + a, 1.0)
        if i > 0:
            enter(J, here + a, before_cell(S, at, i - 1) + a, -1.0)
        if i < N - 1:
            enter(J, beyond + a, before_cell(S, at, i + 1) + 6 + a, -1.0)
    if i > 0:
        before = strain_columns(S, at, n, (i - 1) * S.stride)
        for e in range(STRAINS):
            if before[e] >= 0:
                for a in range(6):
                    enter(J, here + a, before[e], -W.moves[i - 1, e, a])
    for k in range(len(S.ties.course)):
        by_m, by_f = unit_load(S, st, W, k, i + 1)
        # what is zero may lie outside the band
        for a in range(3 if dot(by_m, by_m) + dot(by_f, by_f) > 0.0 else 0):
            enter(J, beyond + a, of_tie(S, at, k), -by_m[a])
            enter(J, beyond + 3 + a, of_tie(S, at, k), -by_f[a])
    none = (0.0, 0.0, 0.0)
    for c in range(6):
        o, v = (unit(c, 0.0), none) if c < 3 else (none, unit(c - 3, 0.0))
        change = load_moved(S, st, W, i + 1, o, v)
        for a in range(3):
            enter(J, beyond + a, here + c, -change[a])
    along = screw(st, i, W)
    for e in range(STRAINS):
        row = columns[e]
        if row < 0:
            continue
        o, v = moves(W, i, e)
        half = bracket(along[0], along[1], o, v)
        change = load_moved(S, st, W, i + 1, o, v)
        by_turn, by_shift = add(cross(o, m), 1.0, cross(v, f)), cross(o, f)
        for a in range(3):
            enter(J, beyond + a, row, -change[a])
            enter(J, row, here + a, -by_turn[a])
            enter(J, row, here + 3 + a, -by_shift[a])
            enter(J, row, beyond + a, -o[a])
            enter(J, row, beyond + 3 + a, -v[a])
        # a cell's own strains move its middle by half, and shorten its chord
        for other in range(STRAINS):
            if columns[other] >= 0:
                p, u = moves(W, i, other)
                one, two = bracket(p, u, half[0], half[1]), bracket(along[0], along[1], p, u)
                two = bracket(o, v, two[0], two[1])
                chord = dot(m, add(one[0], 1.0, two[0])) + dot(f, add(one[1], 1.0, two[1]))
                enter(J, row, columns[other], -(dot(p, by_turn) + dot(u, by_shift)) / 2 - chord / 12)


@_jit
def floating_rates(S: System, st: State, at: Array, W: Work, J: Linear) -> None:
    """Add the derivatives by the near end's motion, and of the balance of all loads."""
    K, here = len(S.ties.course), before_cell(S, at, 0)
    e, t = turned(vector(st.ties[LOADS], K)), vector(st.ties[LOADS], K + 3)
    none = (0.0, 0.0, 0.0)
    for c in range(6):
        o = spin(e, unit(c, 0.0)) if c < 3 else none
        v = cross(t, o) if c < 3 else unit(c - 3, 0.0)
        for a in range(3):
            enter(J, here + a, of_tie(S, at, K + c), -o[a])
            enter(J, here + 3 + a, of_tie(S, at, K + c), -v[a])
        enter(J, of_tie(S, at, K + c), here + 6 + c, 1.0)
        o, v = (unit(c, 0.0), none) if c < 3 else (none, unit(c - 3, 0.0))
        change = load_moved(S, st, W, 0, o, v)
        for a in range(3):
            enter(J, of_tie(S, at, K + a), here + c, change[a])
    for k in range(K):
        by_m, by_f = unit_load(S, st, W, k, 0)
        for a in range(3 if dot(by_m, by_m) + dot(by_f, by_f) > 0.0 else 0):
            enter(J, of_tie(S, at, K + a), of_tie(S, at, k), by_m[a])
            enter(J, of_tie(S, at, K + 3 + a), of_tie(S, at, k), by_f[a])


@_jit
def shifted(S: System, st: State, at: Array, n: int, x: Array, by: complex) -> None:
    """Add a multiple of changes (n,) to strains of cells, loads of ties, and the place of a floating beam."""
    for i in range(cells(S)):
        columns = strain_columns(S, at, n, i * S.stride)
        for e in range(STRAINS):
            if columns[e] >= 0:
                st.strains[i, e] += by * x[columns[e]]
    for k in range(borders(S)):
        st.ties[LOADS, k] += by * x[of_tie(S, at, k)]


@_jit
def moved_alone(S: System, at: Array, x: Array) -> None:
    """Clear from a correction the sections' motions and changes of wrenches, which are not part of the state."""
    if S.own and sectioned(S):
        for i in range(cells(S)):
            for a in range(12):
                x[before_cell(S, at, i) + a] = 0.0

"""Derivatives of the equations with respect to the unknowns, in closed form; compiled."""

from __future__ import annotations

import numpy as np

from squama.batch.keeping import inlined as _in
from squama.batch.keeping import part as _jit
from squama.contacts import touch
from squama.contacts.geometry import back, bow, slopes, turn, vector
from squama.contacts.lifts import around, lifted, lifts, shared
from squama.contacts.linear import AT, INNER, Linear, alone, emptied, enter, grow
from squama.contacts.meeting import Meeting, Work, along_edges, before, frame, lever, meet
from squama.contacts.supports import tie_rates
from squama.contacts.system import (
    ELASTIC,
    MOTIONS,
    MU,
    STIFF,
    STRAINS,
    TILT,
    Past,
    State,
    System,
    partner,
    pieces,
    rated,
    spots,
    strain_columns,
)
from squama.contacts.touch import lengthwise, places_of, unknown
from squama.contacts.vectors import Vector, add, by_vector, cross, dot, scaled, spin, turned, unit
from squama.types import Array

_J, _S, _W, _F, _E = 6, 12, 15, 21, 24
"""Offsets of a contact's local variables: motions of both scales, places, lifts and slopes of both plates, force,
strains of the cells between.
"""
LOCAL = 18
"""Number of local equations of a contact, without those of strains."""


@_jit
def lie_rates(st: State, i: int, c: int, o: int, turns: int, W: Work, J: Linear) -> None:
    """Write the derivatives of :func:`squama.contacts.equations.lie`."""
    Q, w = st.F[c, 0], vector(st.q[i], 3)
    e, (rate, up, square) = turned(w), lever(i, W)
    by_w = by_vector(e, rate)
    for z in range(3):
        by_turn = cross(spin(e, unit(z, 0.0)), up)
        grown = 2 * (up[0] * by_turn[0] + up[2] * by_turn[2])
        change = add(cross(by_turn, (-up[2], 0.0, up[0])), 1.0, cross(up, (-by_turn[2], 0.0, by_turn[0])))
        change = scaled(Q / square, add(change, -grown, rate))
        change = add(map_rate(w, scaled(Q, rate), unit(z, 0.0)), 1.0, by_vector(e, change))
        enter(J, o, turns + z, by_w[z])
        enter(J, turns + z, o, -by_w[z])
        for a in range(3):
            enter(J, turns + a, turns + z, -change[a])


@_jit
def varied(
    g: Meeting,
    P: Array,
    F: Vector,
    v: int,
    places: tuple[int, int, int, int],
    bows: tuple[float, float, float, float, float, float],
    slips: tuple[Vector, Vector, Vector, Vector],
    rubs: bool,
) -> tuple[Vector, Vector, Vector, Vector, Vector, Vector, Vector, Vector, Vector, Vector, Vector]:
    """Return the derivatives of a contact's vectors with respect to its local variable number v.

    The vectors are r1, p2, both arms, tangents along x and y of both plates, the force, the rotation of the force in
    the second scale's axes, and the slip. ``places``: unknown places of the contact; ``bows``: second derivatives of
    both deflections; ``slips``: derivatives of the slip with respect to the places.
    """
    k1, k2, k3, k4 = places
    xx1, xy1, yy1, xx2, xy2, yy2 = bows
    a1, b1, c1, d1 = slips
    none = (0.0, 0.0, 0.0)
    dr1, dp2, darm1, darm2 = none, none, none, none
    dtx1, dty1, dtx2, dty2, dF, dFj = none, none, none, none, none, none
    dv = none
    if v < 3:
        dr1 = unit(v, 0.0)
    elif v < _J:
        o = unit(v - 3, 0.0)
        dr1 = cross(o, g.arm1)
        darm1, dtx1, dty1 = dr1, cross(o, g.tx1), cross(o, g.ty1)
    elif v < _J + 3:
        dp2 = turn(P, unit(v - _J, 0.0))
    elif v < _S:
        o = turn(P, unit(v - _J - 3, 0.0))
        dp2 = cross(o, g.arm2)
        darm2, dtx2, dty2 = dp2, cross(o, g.tx2), cross(o, g.ty2)
    elif v < _W:
        p = v - _S
        dx1, dy1 = 1.0 if k1 == p else 0.0, 1.0 if k2 == p else 0.0
        dx2, dy2 = 1.0 if k3 == p else 0.0, 1.0 if k4 == p else 0.0
        darm1 = add(scaled(dx1, g.tx1), dy1, g.ty1)
        darm2 = add(scaled(dx2, g.tx2), dy2, g.ty2)
        dr1, dp2 = darm1, darm2
        dtx1, dty1 = scaled(xx1 * dx1 + xy1 * dy1, g.up1), scaled(xy1 * dx1 + yy1 * dy1, g.up1)
        dtx2, dty2 = scaled(xx2 * dx2 + xy2 * dy2, g.up2), scaled(xy2 * dx2 + yy2 * dy2, g.up2)
        if rubs:
            dv = add(add(add(scaled(dx1, a1), dy1, b1), dx2, c1), dy2, d1)
    elif v == _W:
        dr1, darm1 = g.up1, g.up1
    elif v == _W + 1:
        dtx1 = g.up1
    elif v == _W + 2:
        dty1 = g.up1
    elif v == _W + 3:
        dp2, darm2 = g.up2, g.up2
    elif v == _W + 4:
        dtx2 = g.up2
    elif v == _W + 5:
        dty2 = g.up2
    elif v < _E:
        dF = unit(v - _F, 0.0)
    else:
        e = v - _E
        o = vector(P, 12 + 6 * e)
        dp2 = add(cross(o, g.p2), 1.0, vector(P, 15 + 6 * e))
        dtx2, dty2, dFj = cross(o, g.tx2), cross(o, g.ty2), cross(F, o)
    return dr1, dp2, darm1, darm2, dtx1, dty1, dtx2, dty2, dF, dFj, dv


@_jit
def rubbing(
    S: System, row: Array, s: Array, past: Past, g: Meeting, f: Vector, most: float, rubs: bool
) -> tuple[tuple[Vector, Vector, Vector, Vector], float, float, Vector]:
    """Return slip rates with a contact's places, the largest friction, and size and direction of the trial force."""
    none = (0.0, 0.0, 0.0)
    if not rubs:
        return (none, none, none, none), 0.0, 1.0, f
    v, a1, b1, c1, d1 = before(S, row, s, past, 0)
    if row[touch.STUCK] > 0:
        return (scaled(-1.0, a1), scaled(-1.0, b1), scaled(-1.0, c1), scaled(-1.0, d1)), 0.0, 1.0, f
    w1, w2 = past.weights[1], past.weights[2]
    v, a1, b1, c1, d1 = scaled(w1, v), scaled(w1, a1), scaled(w1, b1), scaled(w1, c1), scaled(w1, d1)
    if w2 != 0.0:
        v2, a2, b2, c2, d2 = before(S, row, s, past, 1)
        v, a1, b1 = add(v, w2, v2), add(a1, w2, a2), add(b1, w2, b2)
        c1, d1 = add(c1, w2, c2), add(d1, w2, d2)
    v = add(v, -dot(v, g.n), g.n)
    y = add(f, -S.shapes[row[touch.FIRST], STIFF], v)
    reach = max(np.sqrt(dot(y, y)), 1e-300)
    return (a1, b1, c1, d1), most, reach, scaled(1 / reach, y)


@_jit
def locally(S: System, st: State, past: Past, c: int, row: Array, W: Work) -> None:
    """Write the derivatives (18 + s, 24 + s) of a contact's terms with respect to its local variables.

    Rows: D, friction (2), tangency, force and moment on both scales, F . dp2/de; the moments without the rate of the
    rotation vector's own map. Terms of the order of an increment are left out, which does not slow Newton's method
    down.
    """
    L, s, g = W.local, st.s[c], meet(S, st, row, st.s[c], W)
    i, j, kind = row[touch.FIRST], partner(S, row), row[touch.KIND]
    P, F, mu, k = W.pairs[i, row[touch.APART] - 1], vector(st.F[c], 0), S.shapes[i, MU], S.shapes[i, STIFF]
    x1, y1, x2, y2 = spots(S, row, s)
    xx1 = xy1 = yy1 = xx2 = xy2 = yy2 = 0.0
    if S.shapes[i, ELASTIC] > 0:
        xx1, xy1, yy1 = bow(S, i, st.b[i], x1, y1)
        xx2, xy2, yy2 = bow(S, j, st.b[j], x2, y2)
    N = dot(F, g.n)
    f = add(F, -N, g.n)
    A, B = frame(row, g)
    rubs = mu > 0.0 and row[touch.STUCK] >= 0
    slips, most, reach, hat = rubbing(S, row, s, past, g, f, mu * max(N, 0.0), rubs)
    places, bows = unknown(kind, row[touch.ONE], row[touch.OTHER]), (xx1, xy1, yy1, xx2, xy2, yy2)
    t1, t2 = along_edges(row, g)
    sign = -1.0 if kind == touch.EE and dot(cross(t2, t1), g.n) < 0.0 else 1.0
    strains = rated(S, row[touch.APART])
    for v_ in range(_E + strains):
        dr1, dp2, darm1, darm2, dtx1, dty1, dtx2, dty2, dF, dFj, dv = varied(g, P, F, v_, places, bows, slips, rubs)
        dt1, dt2 = (dtx1 if lengthwise(row[touch.ONE]) else dty1), (dtx2 if lengthwise(row[touch.OTHER]) else dty2)
        if kind == touch.EE:
            dm = scaled(sign, add(cross(dt2, t1), 1.0, cross(t2, dt1)))
        elif kind in (touch.VF, touch.EF):
            dm = add(cross(dtx2, g.ty2), 1.0, cross(g.tx2, dty2))
        else:
            dm = add(cross(dtx1, g.ty1), 1.0, cross(g.tx1, dty1))
        dn = scaled(1 / g.length, add(dm, -dot(g.n, dm), g.n))
        dN = dot(dF, g.n) + dot(F, dn)
        df = add(add(dF, -dN, g.n), -N, dn)
        L[0, v_], L[1, v_], L[2, v_] = add(dr1, -1.0, dp2)
        if rubs and row[touch.STUCK] > 0:
            dg = scaled(k, add(dv, S.grip, df))
        elif rubs:
            dy = add(df, -k, dv)
            rest = add(dy, -dot(hat, dy), hat)
            dg = add(add(df, -mu * dN if N > 0.0 else 0.0, hat), -most / reach, rest)
        else:
            dg = df
        L[3, v_], L[4, v_] = dot(dg, A), dot(dg, B)
        L[5, v_] = 0.0
        if kind == touch.EF:
            L[5, v_] = dot(dt1, g.n) + dot(t1, dn)
        elif kind == touch.FE:
            L[5, v_] = dot(dt2, g.n) + dot(t2, dn)
        L[6, v_], L[7, v_], L[8, v_] = dF
        L[9, v_], L[10, v_], L[11, v_] = add(cross(darm1, F), 1.0, cross(g.arm1, dF))
        dFj = add(dFj, 1.0, dF)
        L[12, v_], L[13, v_], L[14, v_] = back(P, dFj)
        L[15, v_], L[16, v_], L[17, v_] = back(P, add(cross(darm2, F), 1.0, cross(g.arm2, dFj)))
        for e in range(strains):
            o = vector(P, 12 + 6 * e)
            rate = add(cross(o, g.p2), 1.0, vector(P, 15 + 6 * e))
            change, first = dot(F, cross(o, dp2)), order(S, row, e) - order(S, row, v_ - _E)
            if v_ >= _E and first >= 0:
                # later cells along the bar are turned; within a cell rotations about two axes are taken to commute
                other = dot(F, cross(vector(P, 12 + 6 * (v_ - _E)), rate))
                change = other if first > 0 else (change + other) / 2
            L[LOCAL + e, v_] = dot(dF, rate) + change


@_in
def order(S: System, row: Array, e: int) -> int:
    """Return the place along the bar of strain e of the cells between two scales, or of their tilts behind these."""
    many = pieces(S, row[touch.APART])
    if e < STRAINS * many:
        return 3 * (e // STRAINS)
    return 1 if e == STRAINS * many else 3 * many - 4


@_jit
def map_rate(w: Vector, m: Vector, d: Vector) -> Vector:
    """Return the change, for a change d of a rotation vector, of the gradient by it of the work of a moment m."""
    e = turned(w)
    g, s = dot(w, w), 2 * dot(w, d)
    series = -1 / 6 * (1 - g / 10 * (1 - g / 28 * (1 - g / 54)))
    da = series if g < 0.05 else (np.cos(np.sqrt(g)) - e.a) / (2 * g)
    db, dc = slopes(e)
    out = add(add(scaled(da * s, m), -db * s, cross(w, m)), -e.b, cross(d, m))
    out = add(add(out, dc * s * dot(w, m), w), e.c * dot(d, m), w)
    return add(out, e.c * dot(w, m), d)


@_jit
def spread(
    J: Linear,
    strained: tuple[int, int, int, int],
    L: Array,
    column: Array,
    rows: Array,
    lifts: Array,
    from1: int,
    to1: int,
    from2: int,
    to2: int,
) -> None:
    """Add a contact's local derivatives to a Jacobian; ``column`` and ``rows`` are the unknowns and equations.

    -1 stands for none, -2 for a lift or slope of a plate, which depends on unknowns from ``from1`` (``from2``: of the
    second plate) to before ``to1``, and on free strains.
    """
    band, inner = J.band, J.kept[INNER]
    strains = len(column) - _E
    for z in range(len(rows)):
        to = rows[z]
        if to < 0:
            continue
        sign, o = -1.0 if 6 <= z < 12 else 1.0, J.rows[AT, to] if to < inner else 0
        for u in range(len(column)):
            # motions and strains first, then the other local variables
            v = u if u < _S else (u + _E - _S if u < _S + strains else u - strains)
            x, b = sign * L[z, v], column[v]
            if x == 0.0 or b == -1:
                continue
            if b >= 0:
                if b < inner and to < inner:
                    band[o + b] += x
                else:
                    enter(J, to, b, x)
                continue
            own = lifts[v - _W]
            begin, end = (from1, to1) if v < _W + 3 else (from2, to2)
            if to < inner:
                grow(band[o + begin : o + end], x, own[begin:end])
            else:
                grow(J.lower[to - inner, begin:end], x, own[begin:end])
            for e in range(STRAINS):
                if strained[e] >= 0:
                    enter(J, to, strained[e], x * own[strained[e]])


@_jit
def hold_rates(S: System, at: Array, n: int, W: Work, J: Linear) -> None:
    """Add the derivatives of :func:`squama.contacts.equations.held_back`."""
    for i in range(len(S.shapes)):
        for a in range(MOTIONS):
            enter(J, at[i] + a, at[i] + a, W.stiffness[0] * S.K[i, a, a])
        columns = strain_columns(S, at, n, i)
        for e in range(STRAINS if S.own or i == 0 else 0):
            if columns[e] >= 0:
                enter(J, columns[e], columns[e], W.stiffness[0] * S.K[i, MOTIONS + e, MOTIONS + e])


@_jit
def elastic_rates(S: System, at: Array, n: int, J: Linear) -> None:
    """Add the derivatives of :func:`squama.contacts.equations.elastic`."""
    for i in range(len(S.shapes)):
        columns = strain_columns(S, at, n, i)
        for a in range(MOTIONS):
            for b in range(MOTIONS):
                enter(J, at[i] + a, at[i] + b, S.K[i, a, b])
        if S.own:
            enter(J, at[i] + TILT, at[i] + TILT, 1.0)
        for e in range(STRAINS):
            if columns[e] >= 0:
                for a in range(MOTIONS):
                    enter(J, at[i] + a, columns[e], S.K[i, a, MOTIONS + e])
                    enter(J, columns[e], at[i] + a, S.K[i, a, MOTIONS + e])
                for o in range(STRAINS):
                    if columns[o] >= 0:
                        enter(J, columns[e], columns[o], S.K[i, MOTIONS + e, MOTIONS + o])


@_jit
def jacobian(  # noqa: C901 - one loop over contacts
    S: System, st: State, past: Past, con: Array, m: int, n: int, W: Work, J: Linear
) -> None:
    """Write the derivatives of the residual with respect to the unknowns, at the state in W."""
    N, L, at = len(S.shapes), W.local, J.at
    emptied(J, n)
    elastic_rates(S, at, n, J)
    bent = lifts(S, st, con, m, W) if m > 0 else False
    column, rows = W.columns[0], W.columns[1]
    for c in range(m):
        row, o = con[c], at[N + c]
        i, j, k = row[touch.FIRST], partner(S, row), places_of(row[touch.KIND])
        if row[touch.KIND] == touch.LIES:
            lie_rates(st, i, c, o, at[i] + 3, W, J)
            continue
        locally(S, st, past, c, row, W)
        many = pieces(S, row[touch.APART])
        inputs, outputs = _E + rated(S, row[touch.APART]), LOCAL + rated(S, row[touch.APART])
        from1, to1 = around(S, J, i)
        from2, to2 = around(S, J, j)
        if bent:
            lifted(S, st, con, at, n, c, 0, W, from1, to1)
            lifted(S, st, con, at, n, c, 1, W, from2, to2)
        # from turns of the scales to their rotation vectors: columns, then the rows of the moments
        P, F, g = W.pairs[i, row[touch.APART] - 1], vector(st.F[c], 0), meet(S, st, row, st.s[c], W)
        for side in range(2):
            a = i if side == 0 else j
            w, first, moments = vector(st.q[a], 3), 3 + 6 * side, 9 + 6 * side
            turning = turned(w)
            for z in range(outputs):
                v = by_vector(turning, (L[z, first], L[z, first + 1], L[z, first + 2]))
                L[z, first], L[z, first + 1], L[z, first + 2] = v
            for z in range(inputs):
                v = by_vector(turning, (L[moments, z], L[moments + 1, z], L[moments + 2, z]))
                L[moments, z], L[moments + 1, z], L[moments + 2, z] = v
            moment = cross(g.arm1, F) if side == 0 else back(P, cross(g.arm2, F))
            for z in range(3):
                v = map_rate(w, moment, unit(z, 0.0))
                for b in range(3):
                    L[moments + b, first + z] += v[b]
        for z in range(6):
            column[z], column[_J + z] = at[i] + z, at[j] + z
        for z in range(3):
            column[_S + z] = o + 3 + z if z < k else -1
            column[_F + z] = o + z
        for z in range(6):
            column[_W + z] = -2 if bent else -1
            rows[z] = o + z if z < 3 + k else -1
            rows[6 + z], rows[12 + z] = at[i] + z, at[j] + z
        for p in range(many):
            columns = strain_columns(S, at, n, i + p * S.stride)
            for e_ in range(STRAINS):
                column[_E + STRAINS * p + e_] = rows[LOCAL + STRAINS * p + e_] = columns[e_]
        for last in range(2 if S.own else 0):
            tilted = at[j if last else i] + TILT
            column[_E + STRAINS * many + last] = rows[LOCAL + STRAINS * many + last] = tilted
        spread(J, shared(S, at, n), L, column[:inputs], rows[:outputs], W.lifts, from1, to1, from2, to2)
    if S.own:
        tie_rates(S, st, at, n, W, J)
    if W.stiffness[0] > 0.0:
        hold_rates(S, at, n, W, J)
    for c in range(m):
        if con[c, touch.STUCK] == touch.LET_GO:
            for a in range(3 + places_of(con[c, touch.KIND])):
                alone(J, at[N + c] + a)
    for a in range(len(S.masked)):
        if S.masked[a] > 0:
            for i in range(N):
                alone(J, at[i] + a)

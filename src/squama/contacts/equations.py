r"""The equations of N scales in contact: their residual; compiled.

Contact c presses scale i away from its neighbour j by the force F at the places r1 and p2, both in the axes of scale
i::

    scale      K_q . (q, e) = sum F - R'^T F,  and the moments of both about the scales' base midpoints
    plate      b = C sum [Phi(x1, y1) F.n_1 - Phi(x2, y2) F.n_2]                 (explicit: no unknowns of its own)
    contact    r1 - p2 = 0,  along a bent edge that lies on a face t . n = 0 as well
    friction   y = f - k v:  abs(y) <= mu N: v1 + grip (f - f_last) = 0 (sticks);  else f - mu N y/abs(y) = 0 (slips)
    strain     K_e . (q, e) + sum F . dp2/de = 0  for each free strain, or the load of an imposed one;
               the load at the ends for each cell with strains of its own (:mod:`squama.contacts.supports`)
    tilt       of each scale of a row, t_i + sum F . dp2/dt_i = 0
    substrate  theta_i = 0 of a scale that lies on it, by a moment Q_i that brings Q_i theta_q to its balance

with f = F - N n the part along the plate, N = F . n, n the common normal from the image to scale i. The slip v over the
increment is that of the contact's present material places: r1 - p2 of these places at the two earlier states,
by the backward difference of second order. The law is the same for each kind of contact (docs: contacts).
"""

from __future__ import annotations

import numpy as np

from squama.batch.keeping import part as _jit
from squama.contacts import touch
from squama.contacts.geometry import back, vector
from squama.contacts.meeting import F_, MARGIN, N_, Work, along_edges, before, clear, frame, inclination, lever, meet
from squama.contacts.supports import tied
from squama.contacts.system import (
    MOTIONS,
    MU,
    STIFF,
    STRAINS,
    TILT,
    Past,
    State,
    System,
    cells,
    partner,
    pieces,
    row_of,
    strain_columns,
)
from squama.contacts.touch import places_of
from squama.contacts.vectors import Vector, add, by_vector, cross, dot, scaled, turned
from squama.types import Array


@_jit
def elastic(S: System, st: State, at: Array, W: Work, r: Array, loads: Array) -> None:
    """Write the elastic part of a state: residual of the scales, loads M, T, B, P of the cells, and their means."""
    N, many = len(S.shapes), cells(S)
    for e in range(STRAINS):
        loads[e] = 0.0
        for i in range(len(W.carried)):
            W.carried[i, e] = 0.0
    for i in range(N):
        K, q, strains = S.K[i], st.q[i], st.strains[row_of(S, i)]
        for a in range(MOTIONS + STRAINS):
            out = 0.0 * q[0]
            for b in range(MOTIONS):
                out += K[a, b] * q[b]
            for e in range(STRAINS):
                out += K[a, MOTIONS + e] * strains[e]
            if a < MOTIONS:
                r[at[i] + a] = out
            else:
                loads[a - MOTIONS] += out / many
                if S.own:
                    W.carried[row_of(S, i), a - MOTIONS] += out
        if S.own:
            r[at[i] + TILT] = q[TILT]


@_jit
def residual(
    S: System, st: State, past: Past, con: Array, m: int, at: Array, n: int, W: Work, r: Array, loads: Array
) -> None:
    """Write the residual (n,) of a state, the loads M, T, B, P, and the contacts' values; update W to the state."""
    N, many = len(S.shapes), cells(S)
    elastic(S, st, at, W, r, loads)
    for c in range(m):
        row, o = con[c], at[N + c]
        if row[touch.KIND] == touch.LIES:
            lie(S, st, row[touch.FIRST], c, o, at[row[touch.FIRST]] + 3, W, r)
            continue
        g = meet(S, st, row, st.s[c], W)
        i, j, kind = row[touch.FIRST], partner(S, row), row[touch.KIND]
        P, F, mu, told = W.pairs[i, row[touch.APART] - 1], vector(st.F[c], 0), S.shapes[i, MU], W.told[c]
        k = S.shapes[i, STIFF]
        normal_force = dot(F, g.n)
        f = add(F, -normal_force, g.n)
        A, B = frame(row, g)
        size = np.sqrt(dot(f, f))
        told[N_], told[F_], told[MARGIN] = normal_force, size, 0.0
        if mu.real > 0.0 and row[touch.STUCK] >= 0:
            D1, _, _, _, _ = before(S, row, st.s[c], past, 0)
            v = scaled(past.weights[1], D1)
            if past.weights[2] != 0.0:
                D2, _, _, _, _ = before(S, row, st.s[c], past, 1)
                v = add(v, past.weights[2], D2)
            v = add(v, -dot(v, g.n), g.n)
            y = add(f, -k, v)
            reach, most = np.sqrt(dot(y, y)), mu * normal_force if normal_force.real > 0.0 else 0.0 * normal_force
            told[MARGIN] = reach - most
            if row[touch.STUCK] > 0:
                told[MARGIN] = size - most
                held = add(scaled(-1.0, D1), S.grip, add(f, -1.0, vector(past.F[c], 0)))
                r[o + 3], r[o + 4] = k * dot(held, A), k * dot(held, B)
            else:
                share = most / reach if reach.real > 0.0 else 0.0 * most
                r[o + 3], r[o + 4] = dot(f, A) - share * dot(y, A), dot(f, B) - share * dot(y, B)
        else:
            r[o + 3], r[o + 4] = dot(f, A), dot(f, B)
        r[o], r[o + 1], r[o + 2] = g.D
        t1, t2 = along_edges(row, g)
        if kind == touch.EF:
            r[o + 5] = dot(t1, g.n)
        elif kind == touch.FE:
            r[o + 5] = dot(t2, g.n)
        if row[touch.STUCK] == touch.LET_GO:
            # its force and its places are fixed
            told[N_] = 0.0
            for a in range(3 + places_of(kind)):
                r[o + a] *= 0.0
        e1, e2 = turned(vector(st.q[i], 3)), turned(vector(st.q[j], 3))
        moment1, moment2 = by_vector(e1, cross(g.arm1, F)), by_vector(e2, back(P, cross(g.arm2, F)))
        behind = back(P, F)
        for a in range(3):
            r[at[i] + a] -= F[a]
            r[at[i] + 3 + a] -= moment1[a]
            r[at[j] + a] += behind[a]
            r[at[j] + 3 + a] += moment2[a]
        for e in range(STRAINS * pieces(S, row[touch.APART])):
            rate = add(cross(vector(P, 12 + 6 * e), g.p2), 1.0, vector(P, 15 + 6 * e))
            loads[e % STRAINS] += dot(F, rate) / many
            if S.own:
                W.carried[row_of(S, i) + e // STRAINS, e % STRAINS] += dot(F, rate)
        tilting(S, row, F, g.p2, at, W, r)
    if not S.own:
        columns = strain_columns(S, at, n, 0)
        for e in range(STRAINS):
            if columns[e] >= 0:
                r[columns[e]] = loads[e] * many
    else:
        tied(S, st, at, n, W, r, loads)
    if W.stiffness[0] > 0.0:
        held_back(S, st, at, n, W, r)
    for a in range(len(S.masked)):
        if S.masked[a] > 0:
            for i in range(N):
                r[at[i] + a] = st.q[i, a]


@_jit
def tilting(S: System, row: Array, F: Vector, place: Vector, at: Array, W: Work, r: Array) -> None:
    """Add the work of a contact's force per tilt of both scales to their residuals."""
    P = W.pairs[row[touch.FIRST], row[touch.APART] - 1]
    for last in range(2 if S.own else 0):
        e = STRAINS * pieces(S, row[touch.APART]) + last
        rate = add(cross(vector(P, 12 + 6 * e), place), 1.0, vector(P, 15 + 6 * e))
        r[at[partner(S, row) if last else row[touch.FIRST]] + TILT] += dot(F, rate)


@_jit
def held_back(S: System, st: State, at: Array, n: int, W: Work, r: Array) -> None:
    """Add the forces of springs that hold motions and free strains, see :mod:`squama.contacts.relaxing`."""
    for i in range(len(S.shapes)):
        for a in range(MOTIONS):
            r[at[i] + a] += W.stiffness[0] * S.K[i, a, a] * (st.q[i, a] - W.hold[i, a])
        columns = strain_columns(S, at, n, i)
        for e in range(STRAINS if S.own or i == 0 else 0):
            if columns[e] >= 0:
                own = S.K[i, MOTIONS + e, MOTIONS + e] * (st.strains[row_of(S, i), e] - W.hold[i, MOTIONS + e])
                r[columns[e]] += W.stiffness[0] * own


@_jit
def lie(S: System, st: State, i: int, c: int, o: int, turns: int, W: Work, r: Array) -> None:
    """Write the equation of a scale that lies on the substrate, and its moment in the scale's balance."""
    Q, told = st.F[c, 0], W.told[c]
    clear(told)
    told[N_] = Q
    r[o] = inclination(S, i, W)
    moment = by_vector(turned(vector(st.q[i], 3)), scaled(Q, lever(i, W)[0]))
    for a in range(3):
        r[turns + a] -= moment[a]

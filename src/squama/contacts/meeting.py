"""Positions of contacts on both scales, their slip, and the deflections of the plates; compiled."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from squama.batch.keeping import inlined as _in
from squama.batch.keeping import part as _jit
from squama.contacts import touch
from squama.contacts.geometry import attitudes, beside, lift, neighbours, normal, press, turn, vector
from squama.contacts.system import ELASTIC, POWERS, H, Past, State, System, partner, spots
from squama.contacts.touch import lengthwise
from squama.contacts.vectors import Vector, add, cross, dot, scaled
from squama.types import Array

N_, F_, MARGIN = range(3)
"""Columns of the values of a contact (C, 3): N, friction, |y| - mu N."""


class Work(NamedTuple):
    """Working arrays of a path.

    Attitudes (N, 12), neighbours (N, reach, 36), loads of the plates (N, 24), powers at the places and the plates'
    deflections under unit loads there (2 C, 3, 24), loads of the sides (2 C,), derivatives of lifts (6, n), local
    derivatives (22, 28) or more, values of contacts (C, 3); views of a pair (2, 12), its corners (4, 3), a vertex (7,),
    the end of an edge (9,), the unknowns of a contact's variables and rows (2, 28) or more; of each plate the last
    place at which it is pressed (N,), and for each place the previous one on the same plate (2 C,), -1 for none. If
    cells have their own strains, the loads M, T, B, P of each (N, 4); if sections are followed, their frames (N + 1,
    12), motions beyond cells per strain (N, 4, 6), wrenches on sections and beyond (N + 1, 6), one cell as written by
    :func:`squama.contacts.geometry.chain` (36,), and the axes of a section (3, 3); ``window`` (1,): the share of a
    plate within which a vertex beside an edge along a face counts as that contact; motions and strains (N, 10) at which
    springs hold each scale and its cell, and their stiffness (1,) over the joints' own (mostly 0).
    """

    E: Array
    pairs: Array
    load: Array
    powers: Array
    bent: Array
    side: Array
    lifts: Array
    local: Array
    told: Array
    views: Array
    corners: Array
    vertex: Array
    end: Array
    columns: Array
    first: Array
    next: Array
    carried: Array
    frames: Array
    moves: Array
    wrench: Array
    cell: Array
    section: Array
    window: Array
    hold: Array
    stiffness: Array
    halves: Array


class Meeting(NamedTuple):
    """Geometry of a contact of two plates.

    Both places relative to the base midpoints (the second one in the axes of the first scale), the second place itself,
    the difference D, tangents along x and y of both plates, their normals, the unit common normal, and its length
    before it was scaled.
    """

    arm1: Vector
    arm2: Vector
    p2: Vector
    D: Vector
    tx1: Vector
    ty1: Vector
    tx2: Vector
    ty2: Vector
    up1: Vector
    up2: Vector
    n: Vector
    length: float


@_jit
def clear(a: Array) -> None:
    """Set an array to zero."""
    x = a.flat
    for i in range(a.size):
        x[i] = 0.0


@_jit
def deflect(S: System, st: State, con: Array, m: int, W: Work) -> None:
    """Write the deflections of all plates from the forces on them."""
    if m == 0:
        clear(st.b)
        return
    N = len(S.shapes)
    clear(W.load)
    for c in range(m):
        if con[c, touch.KIND] == touch.LIES:
            continue
        i, j = con[c, touch.FIRST], partner(S, con[c])
        x1, y1, x2, y2 = spots(S, con[c], st.s[c])
        F = vector(st.F[c], 0)
        if S.shapes[i, ELASTIC].real > 0:
            press(S, i, x1, y1, dot(F, normal(W.E[i])), W.load[i])
            press(S, j, x2, y2, -dot(F, turn(W.pairs[i, con[c, touch.APART] - 1], normal(W.E[j]))), W.load[j])
    for i in range(N):
        b = st.b[i]
        clear(b)
        if S.shapes[i, ELASTIC].real > 0:
            for p in range(POWERS):
                load = W.load[i, p]
                for o in range(POWERS):
                    b[o] += S.plates[i, p, o] * load


@_jit
def meet(S: System, st: State, c: Array, s: Array, W: Work) -> Meeting:
    """Return the geometry of a contact: its places, tangents and common normal."""
    i, j = c[touch.FIRST], partner(S, c)
    P, E1, E2 = W.pairs[i, c[touch.APART] - 1], W.E[i], W.E[j]
    x1, y1, x2, y2 = spots(S, c, s)
    w1, wx1, wy1, w2, wx2, wy2 = 0.0 * x1, 0.0 * x1, 0.0 * x1, 0.0 * x1, 0.0 * x1, 0.0 * x1
    if S.shapes[i, ELASTIC].real > 0:
        w1, wx1, wy1 = lift(S, i, st.b[i], x1, y1)
        w2, wx2, wy2 = lift(S, j, st.b[j], x2, y2)
    arm1 = turn(E1, (x1, y1, w1 - S.shapes[i, H] / 2))
    arm = turn(E2, (x2, y2, w2 + S.shapes[j, H] / 2))
    arm2, inner = turn(P, arm), (arm[0] + E2[9], arm[1] + E2[10], arm[2] + E2[11])
    p2 = add(turn(P, inner), 1.0, vector(P, 9))
    D = (arm1[0] + E1[9] - p2[0], arm1[1] + E1[10] - p2[1], arm1[2] + E1[11] - p2[2])
    one, none = 1.0 + 0.0 * x1, 0.0 * x1
    tx1, ty1, up1 = turn(E1, (one, none, wx1)), turn(E1, (none, one, wy1)), normal(E1)
    tx2, ty2 = turn(P, turn(E2, (one, none, wx2))), turn(P, turn(E2, (none, one, wy2)))
    up2 = turn(P, normal(E2))
    kind = c[touch.KIND]
    if kind == touch.EE:
        t1 = tx1 if lengthwise(c[touch.ONE]) else ty1
        t2 = tx2 if lengthwise(c[touch.OTHER]) else ty2
        n = cross(t2, t1)
        if dot(n, up2).real < 0.0:
            n = scaled(-1.0, n)
    elif kind in (touch.VF, touch.EF):
        n = cross(tx2, ty2)
    else:
        n = cross(tx1, ty1)
    length = np.sqrt(dot(n, n))
    return Meeting(arm1, arm2, p2, D, tx1, ty1, tx2, ty2, up1, up2, scaled(1 / length, n), length)


@_in
def along_edges(c: Array, g: Meeting) -> tuple[Vector, Vector]:
    """Return the tangents of a contact's edges on both scales."""
    return g.tx1 if lengthwise(c[touch.ONE]) else g.ty1, g.tx2 if lengthwise(c[touch.OTHER]) else g.ty2


@_jit
def frame(c: Array, g: Meeting) -> tuple[Vector, Vector]:
    """Return two orthogonal directions tangent to the plates at a contact; not of unit length."""
    t1, t2 = along_edges(c, g)
    kind = c[touch.KIND]
    a = t2 if kind == touch.FE else (g.tx2 if kind == touch.VF else (g.tx1 if kind == touch.FV else t1))
    a = add(a, -dot(a, g.n), g.n)
    return a, cross(g.n, a)


@_jit
def before(S: System, c: Array, s: Array, past: Past, which: int) -> tuple[Vector, Vector, Vector, Vector, Vector]:
    """Return D of a contact's material places at an earlier state, and its derivatives with x1, y1, x2 and y2."""
    i, j = c[touch.FIRST], partner(S, c)
    P, E1, E2 = past.pairs[which, i, c[touch.APART] - 1], past.E[which, i], past.E[which, j]
    x1, y1, x2, y2 = spots(S, c, s)
    w1, wx1, wy1, w2, wx2, wy2 = 0.0 * x1, 0.0 * x1, 0.0 * x1, 0.0 * x1, 0.0 * x1, 0.0 * x1
    if S.shapes[i, ELASTIC].real > 0:
        w1, wx1, wy1 = lift(S, i, past.b[which, i], x1, y1)
        w2, wx2, wy2 = lift(S, j, past.b[which, j], x2, y2)
    r1 = beside(E1, x1, y1, w1 - S.shapes[i, H] / 2)
    p2 = add(turn(P, beside(E2, x2, y2, w2 + S.shapes[j, H] / 2)), 1.0, vector(P, 9))
    one, none = 1.0 + 0.0 * x1, 0.0 * x1
    tx1, ty1 = turn(E1, (one, none, wx1)), turn(E1, (none, one, wy1))
    tx2, ty2 = turn(P, turn(E2, (one, none, wx2))), turn(P, turn(E2, (none, one, wy2)))
    return add(r1, -1.0, p2), tx1, ty1, scaled(-1.0, tx2), scaled(-1.0, ty2)


@_jit
def prepared(S: System, st: State, con: Array, m: int, moved: bool, W: Work) -> None:
    """Update attitudes, neighbours and deflections to a state; ``moved``: strains differ from the last call's."""
    if moved:
        neighbours(S, st.q, st.strains, W.section, W.halves, W.pairs)
    attitudes(st.q, W.E)
    deflect(S, st, con, m, W)


@_jit
def inclination(S: System, i: int, W: Work) -> float:
    """Return the angle (rad) of a scale's length over the bar's face."""
    x, z = W.E[i, 0], W.E[i, 6]
    angle = math.atan2(z.real, x.real)
    c, s = math.cos(angle), math.sin(angle)
    # the last part is 0 except for a complex step
    whole: float = S.rests[i] + angle + (z * c - x * s) / (x * c + z * s)
    return whole


@_jit
def lever(i: int, W: Work) -> tuple[Vector, Vector, float]:
    """Return the gradient of the inclination by a rotation of the scale, the projection of n_X, and its square."""
    up = (W.E[i, 0], W.E[i, 3], W.E[i, 6])
    square = up[0] * up[0] + up[2] * up[2]
    return scaled(1 / square, cross(up, (-up[2], 0.0, up[0]))), up, square

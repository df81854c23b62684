"""One contact of thick, elastic scales on a joint that gives, of two edges or on a face: its equations, compiled.

Scale 1 touches with an edge of its lower face, scale 1 + k with an edge of its upper face. In the axes of a scale at
rest, from its base midpoint, with E the rotation by the vector w and (with primes: turned into these axes) R' the turn
by k phi, O' the place of the base midpoint, z' the axis,

    x1 = u + E X1        x2 = R' (u + E X2 + O') - O' + k z'        D = x1 - x2

X1 = (x, y, deflection - h/2) on the edge of scale 1, X2 likewise with + h/2. The unknowns are q = (u, w), the places
on both edges and the force N while it slips, or the force's three components while it sticks, the forces c1, c2 along
the scales' own normals, which bend them, and the angle of t from the first edge while friction slips:

    K q + K_phi phi = D_q^T F        D = 0        F = N (n - mu t)        c1 = F . E e_3,  c2 = -(R'^T F) . E e_3

A beam that is bent, too, has a screw in place of the turn (docs, theory: bending and twisting): R' = exp(k w) with w of
-(psi, 0, phi), and k (1 + epsilon) V(k w) z' in place of k z'. The stretch epsilon, on which R' does not depend,
follows from the axial force, the bar's and the contact's, which is none. phi is the way along a straight leg of the
path then, and the torque the work per way.

Where a corner of the one lies on the face of the other, both places are on the face, and n is its normal. Where the tip
edge lies there between its corners, its place is one more unknown, and it is tangent to the face: while it sticks it
rolls. Elsewhere n is the common normal of the edges and t the direction of slip: V . (n x t) = 0 and V . t > 0 with V
the rate of D at material points, by backward differences of second order. So a contact that hardly slips has a
direction, too: that of its friction. The torque is K_phi . (q, phi) - D_phi . F, the bar's included.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from squama.real.design import BEND, LEG, MOTIONS, Design, Frame, _in, _jit, back, load, strains, turn

from squama.real.features import (  # isort: skip
    FACE, deflection, on_face, place, powers, raised, rolls, shape, spots, tangent,
)  # fmt: skip
from squama.contacts.vectors import (  # isort: skip
    Turned, Vector, add, by_vector, cross, dot, magnitude, mixed, rotated, scaled, spin, turned,
)  # fmt: skip
from squama.types import Array

MOST = 13
"""Unknowns at most: motions, three of the contact, c1 and c2, the place on a tip edge that rolls, the angle of slip."""
AT, BENT, FORCE, SLIDING, PHI, TORQUE, NORMAL, FRICTION = 13, 16, 40, 43, 46, 47, 48, 49
SPEED, CROSSING, ALONG, ASIDE, STRETCH, WIDTH = 50, 51, 52, 53, 54, 56
"""Columns of a state: unknowns, places (on both edges, or on the face and on the tip edge), deflections of both edges
or of the plate, force, direction of slip, twist, torque, N, tangential force, slip per twist, cosine of the angle
between the edges, direction of a tip edge along a face, stretch."""
NEW, LAST, BEFORE, MISSED, MOVED, POWERS, BOW, SLOPE, TALLY, STATES = range(10)
"""Rows of the room of a path: three states, two residuals, powers of the places, differences of the unknowns,
and what is counted along a path."""


class Step(NamedTuple):
    """A step: whether it sticks, weights of the backward difference, change of the twist."""

    stuck: bool
    b0: float
    b1: float
    b2: float
    dphi: float


@_in
def angle(d: Design) -> int:
    """Return the number of the unknown angle of slip, which follows the others."""
    return held(d) + (1 if rolls(d) else 0)


@_in
def held(d: Design) -> int:
    """Return the number of motions and forces of one that sticks; where it rolls the place on the tip edge follows."""
    return MOTIONS + (5 if d.elastic else 3)


@_in
def meet(d: Design, f: Frame, one: Vector, two: Vector, ahead: Vector, across: Vector) -> tuple[Vector, Vector, Vector]:
    """Return D, -D_phi and n of places (from the base midpoints at rest) and directions in which it may slide."""
    inner = add(two, 1.0, f.o)
    D = add(add(add(one, -1.0, turn(f, inner)), 1.0, f.o), -1.0, f.t)
    n = cross(across, ahead)
    by_phi = (dot(f.da, inner), dot(f.db, inner), dot(f.dc, inner))
    return D, by_phi, scaled(d.sign / np.sqrt(dot(n, n)), n)


@_jit
def crossed(d: Design, f: Frame, e: Turned, room: Array) -> tuple[Vector, Vector, Vector, Vector]:
    """Return the places of a contact of two edges in their scales, and the directions of both edges.

    The deflections of both are written into the new state.
    """
    s, m = room[NEW], MOTIONS
    x, y = s[AT], s[AT + 1]
    w1, slope1, w2, slope2 = 0.0, 0.0, 0.0, 0.0
    if d.elastic:
        g = room[POWERS]
        powers(d, d.first, x, g, 0)
        powers(d, d.second, y, g, 6)
        for i in range(6):
            g[i] *= s[m + 3]
            g[6 + i] *= s[m + 4]
        for i in range(12):
            out = 0.0
            for j in range(12):
                out += d.table[BEND + i, j] * g[j]
            s[BENT + i] = out
        w1, slope1 = deflection(d, d.first, x, s, BENT)
        w2, slope2 = deflection(d, d.second, y, s, BENT + 6)
    X1, X2 = place(d, d.first, x, w1 - d.h / 2), place(d, d.second, y, w2 + d.h / 2)
    along1, along2 = rotated(e, tangent(d.first, slope1)), rotated(e, tangent(d.second, slope2))
    return X1, X2, along1, turn(f, along2)


@_jit
def faced(d: Design, room: Array) -> tuple[Vector, Vector, Vector, Vector, Vector]:
    """Return the places of a contact on a face in their scales, the tip edge's direction, and two along the face.

    The plate's deflection is written into the new state.
    """
    s, m = room[NEW], MOTIONS
    shape(d, s[AT], s[AT + 1], s[AT + 2], s[m + 3], s[m + 4], room[POWERS], s, BENT)
    x1, y1, x2, y2 = spots(d, s[AT], s[AT + 1], s[AT + 2])
    w1, wx1, wy1 = raised(d, s, BENT, x1, y1)
    w2, wx2, wy2 = raised(d, s, BENT, x2, y2)
    wx, wy = (wx2, wy2) if d.second == FACE else (wx1, wy1)
    X1, X2 = (x1, y1, w1 - d.h / 2), (x2, y2, w2 + d.h / 2)
    return X1, X2, (0.0, 1.0, wy1), (1.0, 0.0, wx), (0.0, 1.0, wy)


@_in
def rolled(s: Array, along: float) -> tuple[float, float]:
    """Return where on a face a tip edge touches that has rolled, or borne elsewhere, from a state on to a place."""
    way, c = along - s[AT + 2], s[CROSSING]
    y = way * s[ASIDE] / np.sqrt(1 - c * c)
    return s[AT] + way * s[ALONG] - c * y, s[AT + 1] + y


@_jit
def residual(d: Design, f: Frame, phi: float, step: Step, room: Array, to: int) -> None:
    """Write the equations' residual at the new state's unknowns into a row of the room, and the rest of that state."""
    m, z, s, r = MOTIONS, room[NEW], room[NEW], room[to]
    u, w = (z[0], z[1], z[2]), (z[3], z[4], z[5])
    e = turned(w)
    normal = rotated(e, (0.0, 0.0, 1.0))
    x, y = (room[LAST, AT], room[LAST, AT + 1]) if step.stuck else (z[m], z[m + 1])
    if rolls(d):
        s[AT + 2] = z[held(d)]
        if step.stuck:
            x, y = rolled(room[LAST], z[held(d)])
    s[AT], s[AT + 1] = x, y
    if on_face(d):
        X1, X2, tip, tx, ty = faced(d, room)
        along1, across = rotated(e, tx), rotated(e, ty)
        if d.second == FACE:
            along1, across = turn(f, along1), turn(f, across)
    else:
        X1, X2, along1, across = crossed(d, f, e, room)
    moved1, moved2 = rotated(e, X1), rotated(e, X2)
    D, by_phi, n = meet(d, f, add(u, 1.0, moved1), add(u, 1.0, moved2), along1, across)
    ahead = scaled(1 / np.sqrt(dot(along1, along1)), along1)
    aside = cross(n, ahead)
    s[CROSSING] = dot(ahead, across) / np.sqrt(dot(across, across))
    if on_face(d):
        tip = rotated(e, tip)
        s[ALONG], s[ASIDE] = dot(tip, ahead), dot(tip, aside)
        if rolls(d):
            r[held(d)] = dot(tip, n)
    if step.stuck:
        F = (z[m], z[m + 1], z[m + 2])
        N = dot(F, n)
        across = add(F, -N, n)
        friction = np.sqrt(dot(across, across))
        s[NORMAL], s[FRICTION], s[SPEED] = N, friction, 0.0
        if friction.real > 0.0:
            t = scaled(-1 / friction, across)
            s[SLIDING], s[SLIDING + 1], s[SLIDING + 2] = t
            s[angle(d)] = np.arctan2(dot(t, aside).real, dot(t, ahead).real)
    else:
        N = z[m + 2]
        F = scaled(N, n)
        s[NORMAL], s[FRICTION], s[SPEED] = N, d.mu * N, 0.0
        if d.mu.real > 0.0:
            c, a = np.cos(z[angle(d)]), np.sin(z[angle(d)])
            t = mixed(c, ahead, a, aside, 0.0, n)
            F = add(F, -d.mu * N, t)
            if d.bent:
                by_phi = along(d, f, F, phi, s, by_phi)
            V = slip(d, f, step, room, e, moved1, moved2, normal, by_phi)
            r[angle(d)] = (c * dot(V, aside) - a * dot(V, ahead)) / magnitude(step.dphi)
            s[SPEED] = dot(V, t) / magnitude(step.dphi)
            s[SLIDING], s[SLIDING + 1], s[SLIDING + 2] = t
    psi, twist = 0.0, phi
    if d.bent:
        if step.stuck or d.mu.real == 0.0:
            by_phi = along(d, f, F, phi, s, by_phi)
        D, (psi, twist) = add(D, -s[STRETCH], f.t), strains(d, phi)
    behind = back(f, F)
    push, moment = add(F, -1.0, behind), by_vector(e, add(cross(moved1, F), -1.0, cross(moved2, behind)))
    for i in range(m):
        out = d.table[i, 6] * twist
        for j in range(m):
            out += d.table[i, j] * z[j]
        if d.bent:
            out += d.table[i, 7] * psi + d.table[i, 8] * s[STRETCH]
        r[i] = out
    for i in range(3):
        r[i] -= push[i]
        r[3 + i] -= moment[i]
        r[m + i] = D[i]
    if d.elastic:
        r[m + 3] = z[m + 3] - dot(F, normal)
        r[m + 4] = z[m + 4] + dot(behind, normal)
    s[FORCE], s[FORCE + 1], s[FORCE + 2] = F
    s[PHI] = phi
    # (a Jacobian does without)
    if to == MISSED:
        s[TORQUE] = load(d, phi, z, s[STRETCH]) + dot(F, by_phi)


@_jit
def along(d: Design, f: Frame, F: Vector, way: float, s: Array, by_phi: Vector) -> Vector:
    """Write the stretch at which there is no axial force into a state; return -D_phi with the axis' own part."""
    psi, phi = strains(d, way)
    out = dot(f.t, F) + d.table[8, 6] * phi + d.table[8, 7] * psi
    for j in range(MOTIONS):
        out += d.table[8, j] * s[j]
    s[STRETCH] = -d.table[LEG, 4] * out
    return add(by_phi, 1.0 + s[STRETCH], f.dt)


@_in
def slip(
    d: Design, f: Frame, step: Step, room: Array, e: Turned, moved1: Vector, moved2: Vector, normal: Vector,
    by_phi: Vector,
) -> Vector:  # fmt: skip
    """Return the slip of scale 1 on the other over the step, by the backward difference."""
    z, a, c = room[NEW], room[LAST], room[BEFORE]
    du, o = rates(step, z, a, c, e)
    one, two = add(du, 1.0, cross(o, moved1)), add(du, 1.0, cross(o, moved2))
    if d.elastic:
        x, y = z[AT], z[AT + 1]
        if on_face(d):
            x1, y1, x2, y2 = spots(d, x, y, z[AT + 2])
            one = add(one, bulging(d, step, z, a, c, x1, y1), normal)
            two = add(two, bulging(d, step, z, a, c, x2, y2), normal)
        else:
            one = add(one, bending(d, step, z, a, c, d.first, x, BENT), normal)
            two = add(two, bending(d, step, z, a, c, d.second, y, BENT + 6), normal)
    if d.bent:
        stretched = step.b0 * z[STRETCH] + step.b1 * a[STRETCH] + step.b2 * c[STRETCH]
        one = add(one, -stretched, f.t)
    return add(add(one, -1.0, turn(f, two)), -step.dphi, by_phi)


@_in
def rates(step: Step, z: Array, a: Array, c: Array, e: Turned) -> tuple[Vector, Vector]:
    """Return the move of a scale's base and its turn over the step, by the backward difference of its states."""
    b0, b1, b2 = step.b0, step.b1, step.b2
    du = (b0 * z[0] + b1 * a[0] + b2 * c[0], b0 * z[1] + b1 * a[1] + b2 * c[1], b0 * z[2] + b1 * a[2] + b2 * c[2])
    dw = (b0 * z[3] + b1 * a[3] + b2 * c[3], b0 * z[4] + b1 * a[4] + b2 * c[4], b0 * z[5] + b1 * a[5] + b2 * c[5])
    return du, spin(e, dw)


@_in
def bending(d: Design, step: Step, z: Array, a: Array, c: Array, edge: int, x: float, first: int) -> float:
    """Return how the deflection at a material place on an edge changes over the step."""
    w = step.b0 * deflection(d, edge, x, z, first)[0] + step.b1 * deflection(d, edge, x, a, first)[0]
    return w + step.b2 * deflection(d, edge, x, c, first)[0]


@_in
def bulging(d: Design, step: Step, z: Array, a: Array, c: Array, x: float, y: float) -> float:
    """Return the same at a material place of the plate."""
    w = step.b0 * raised(d, z, BENT, x, y)[0] + step.b1 * raised(d, a, BENT, x, y)[0]
    return w + step.b2 * raised(d, c, BENT, x, y)[0]

"""One contact of two edges of thick, elastic scales on a joint that gives: its equations, compiled.

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

n is the common normal of the edges and t the direction of slip: V . (n x t) = 0 and V . t > 0 with V the rate of D at
material points, by backward differences of second order. So a contact that hardly slips has a direction, too: that of
its friction. The torque is K_phi . (q, phi) - D_phi . F, the bar's included.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from squama.batch.keeping import inlined, part

from squama.real.vectors import (  # isort: skip
    Turned, Vector, add, by_vector, cross, dot, magnitude, mixed, rotated, scaled, spin, turned,
)  # fmt: skip
from squama.types import Array

MOTIONS, MOST = 6, 12
"""Motions u, w of a scale; unknowns at most: these, three of the contact, c1 and c2, the angle of slip."""

_jit, _in = part, inlined


class Design(NamedTuple):
    """What does not change along a path: lengths in pitches, E = 1, angles in rad.

    ``first``, ``second``: the edges that meet, by number (:mod:`squama.model.elastic_plate`), of scales 1 and 1 + k;
    ``sign`` that of n; ``table`` (46, 12): rows of K (9, 9) over (u, w, phi, psi, epsilon), or of (7, 7), from ``BEND``
    on the compliances (12, 12) between the powers of the places on both edges, from ``SHAPE`` on the deflections
    (24, 12) that go with them; these are without effect unless ``elastic``.
    """

    eta: float
    beta: float
    lam: float
    sa: float
    ca: float
    st: float
    ct: float
    h: float
    mu: float
    first: int
    second: int
    k: int
    sign: float
    elastic: bool
    table: Array
    bent: bool


BEND, SHAPE, LEG, ROWS = 9, 21, 45, 46
"""Rows of a design's table; the last one: bend and twist at way 0, their rates, the stretch per axial force."""
_STRAIGHT = 1 - 1e-9
AT, BENT, FORCE, SLIDING, PHI, TORQUE, NORMAL, FRICTION = 12, 14, 26, 29, 32, 33, 34, 35
SPEED, CROSSING, STRETCH, WIDTH = 36, 37, 38, 40
"""Columns of a state: unknowns, places, deflections of both edges, force, direction of slip, twist, torque, N,
tangential force, slip per twist, cosine of the angle between the edges, stretch."""
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


class Frame(NamedTuple):
    """What depends on the twist alone, in a scale's axes: R', its rate with phi (row by row), k z', its rate, O'."""

    a: Vector
    b: Vector
    c: Vector
    da: Vector
    db: Vector
    dc: Vector
    t: Vector
    dt: Vector
    o: Vector


@_jit
def frame(d: Design, phi: float, k: int) -> Frame:
    """Return what the twist per pitch makes of neighbour k."""
    if d.bent:
        return screw(d, phi, k)
    c, s = np.cos(k * phi), np.sin(k * phi)
    x, y, z = (-d.sa * d.ct, d.ca, d.sa * d.st), (d.st, 0.0, d.ct), (d.ca * d.ct, d.sa, -d.ca * d.st)
    # R = [[c, s, 0], [-s, c, 0], [0, 0, 1]] in the scale's axes; x, y, z: the axes of space there
    rx, ry = mixed(c, x, -s, y, 0.0, z), mixed(s, x, c, y, 0.0, z)
    dx, dy = mixed(-k * s, x, -k * c, y, 0.0, z), mixed(k * c, x, -k * s, y, 0.0, z)
    a, da = mixed(x[0], rx, y[0], ry, z[0], z), mixed(x[0], dx, y[0], dy, 0.0, z)
    b, db = mixed(x[1], rx, y[1], ry, z[1], z), mixed(x[1], dx, y[1], dy, 0.0, z)
    e, de = mixed(x[2], rx, y[2], ry, z[2], z), mixed(x[2], dx, y[2], dy, 0.0, z)
    # columns of R' so far: rows of its transpose
    return Frame(
        (a[0], b[0], e[0]), (a[1], b[1], e[1]), (a[2], b[2], e[2]),
        (da[0], db[0], de[0]), (da[1], db[1], de[1]), (da[2], db[2], de[2]),
        scaled(k, z), scaled(0.0, z), scaled(d.lam, y),
    )  # fmt: skip


@_jit
def screw(d: Design, way: float, k: int) -> Frame:
    """Return what bend and twist per pitch make of neighbour k, the axis at its length."""
    x, y, z = (-d.sa * d.ct, d.ca, d.sa * d.st), (d.st, 0.0, d.ct), (d.ca * d.ct, d.sa, -d.ca * d.st)
    psi, phi = strains(d, way)
    w, dw = mixed(-k * psi, x, 0.0, y, -k * phi, z), mixed(-k * d.table[LEG, 2], x, 0.0, y, -k * d.table[LEG, 3], z)
    e = turned(w)
    o = spin(e, dw)
    p, q, r = rotated(e, (1.0, 0.0, 0.0)), rotated(e, (0.0, 1.0, 0.0)), rotated(e, (0.0, 0.0, 1.0))
    dp, dq, dr = cross(o, p), cross(o, q), cross(o, r)
    # the factors' rates by w . w
    g, along = dot(w, w), 2 * dot(w, dw)
    if g.real < 0.05:
        b1 = -1 / 24 * (1 - g / 15 * (1 - 3 * g / 112 * (1 - 2 * g / 135)))
        c1 = -1 / 120 * (1 - g / 21 * (1 - g / 48 * (1 - 2 * g / 165)))
    else:
        b1, c1 = (e.a - 2 * e.b) / (2 * g), (e.b - 3 * e.c) / (2 * g)
    once, donce = cross(w, z), cross(dw, z)
    twice, dtwice = cross(w, once), add(cross(dw, once), 1.0, cross(w, donce))
    t, dt = mixed(1.0, z, e.b, once, e.c, twice), mixed(b1 * along, once, e.b, donce, c1 * along, twice)
    return Frame(
        (p[0], q[0], r[0]), (p[1], q[1], r[1]), (p[2], q[2], r[2]),
        (dp[0], dq[0], dr[0]), (dp[1], dq[1], dr[1]), (dp[2], dq[2], dr[2]),
        scaled(k, t), scaled(k, add(dt, e.c, dtwice)), scaled(d.lam, y),
    )  # fmt: skip


@_in
def strains(d: Design, way: float) -> tuple[float, float]:
    """Return bend and twist per pitch at a place on the path."""
    leg = d.table[LEG]
    return leg[0] + leg[2] * way, leg[1] + leg[3] * way


@_jit
def onto(d: Design, here: float, goal: float, corners: Array, i: int) -> bool:
    """Go on to corner i along a straight leg, from the corner before (or rest); say whether it turns there."""
    leg, over = d.table[LEG], 1 / (goal - here)
    psi, phi = (corners[i - 1, 0], corners[i - 1, 1]) if i > 0 else (0.0, 0.0)
    psi1, phi1 = (corners[i, 0] - psi) * over, (corners[i, 1] - phi) * over
    turns: bool = psi1 * leg[2] + phi1 * leg[3] < _STRAIGHT
    leg[0], leg[1], leg[2], leg[3] = psi - here * psi1, phi - here * phi1, psi1, phi1
    return turns


@_in
def load(d: Design, way: float, q: Array, stretch: float) -> float:
    """Return what the bar opposes to the path at motions q (6,) and a stretch."""
    if d.bent:
        return load_of_leg(d, way, q, stretch)
    out: float = d.table[6, 6] * way
    for j in range(6):
        out += d.table[6, j] * q[j]
    return out


@_jit
def load_of_leg(d: Design, way: float, q: Array, stretch: float) -> float:
    """Return the same where bend and twist go along a leg."""
    psi, phi = strains(d, way)
    out = 0.0
    for row in range(2):
        one = d.table[6 + row, 6] * phi + d.table[6 + row, 7] * psi + d.table[6 + row, 8] * stretch
        for j in range(6):
            one += d.table[6 + row, j] * q[j]
        out += one * d.table[LEG, 2 if row else 3]
    return out


@_in
def turn(f: Frame, v: Vector) -> Vector:
    """Return R' v."""
    return dot(f.a, v), dot(f.b, v), dot(f.c, v)


@_in
def back(f: Frame, v: Vector) -> Vector:
    """Return R'^T v."""
    return mixed(v[0], f.a, v[1], f.b, v[2], f.c)


@_in
def place(d: Design, edge: int, x: float, z: float) -> Vector:
    """Return the place on an edge at height z."""
    if edge == 0:
        return d.eta, x, z
    if edge == 1:
        return x, -d.beta, z
    if edge == 2:
        return x, d.beta, z
    return 0.0 * x, x, z


@_in
def lengthwise(edge: int) -> bool:
    """Say whether an edge runs along the length."""
    return 1 <= edge <= 2


@_in
def low(d: Design, edge: int) -> float:
    """Return the least place on an edge."""
    return 0.0 if lengthwise(edge) else -d.beta


@_in
def high(d: Design, edge: int) -> float:
    """Return the largest place on an edge."""
    return d.eta if lengthwise(edge) else d.beta


@_in
def angle(d: Design) -> int:
    """Return the number of the unknown angle of slip, which follows the others."""
    return MOTIONS + (5 if d.elastic else 3)


@_in
def powers(d: Design, edge: int, x: float, out: Array, first: int) -> None:
    """Write the powers of a place on an edge into the row of powers, from a column on."""
    y = x / d.eta if lengthwise(edge) else x / d.beta
    value = y * y if lengthwise(edge) else 1.0
    for i in range(first, first + 6):
        out[i] = value
        value *= y


@_in
def deflection(d: Design, edge: int, x: float, row: Array, first: int) -> tuple[float, float]:
    """Return a deflection along an edge by its coefficients, from a column on, and its slope."""
    size = d.eta if lengthwise(edge) else d.beta
    y = x / size
    w, slope = 0.0, 0.0
    for i in range(5, -1, -1):
        slope = slope * y + w
        w = w * y + row[first + i]
    if lengthwise(edge):
        return w * y * y, (slope * y * y + 2 * w * y) / size
    return w, slope / size


@_in
def tangent(edge: int, slope: float) -> Vector:
    """Return the direction of an edge whose deflection has a slope."""
    return (1.0, 0.0, slope) if lengthwise(edge) else (0.0, 1.0, slope)


@_in
def meet(
    d: Design, f: Frame, one: Vector, two: Vector, along1: Vector, along2: Vector
) -> tuple[Vector, Vector, Vector]:
    """Return D, -D_phi and n of places (from the base midpoints at rest) and directions of the edges of two scales."""
    inner = add(two, 1.0, f.o)
    D = add(add(add(one, -1.0, turn(f, inner)), 1.0, f.o), -1.0, f.t)
    n = cross(turn(f, along2), along1)
    by_phi = (dot(f.da, inner), dot(f.db, inner), dot(f.dc, inner))
    return D, by_phi, scaled(d.sign / np.sqrt(dot(n, n)), n)


@_jit
def residual(d: Design, f: Frame, phi: float, step: Step, room: Array, to: int) -> None:
    """Write the equations' residual at the new state's unknowns into a row of the room, and the rest of that state."""
    m, z, s, r = MOTIONS, room[NEW], room[NEW], room[to]
    u, w = (z[0], z[1], z[2]), (z[3], z[4], z[5])
    e = turned(w)
    normal = rotated(e, (0.0, 0.0, 1.0))
    x, y = (room[LAST, AT], room[LAST, AT + 1]) if step.stuck else (z[m], z[m + 1])
    s[AT], s[AT + 1] = x, y
    w1, slope1, w2, slope2 = 0.0, 0.0, 0.0, 0.0
    if d.elastic:
        g = room[POWERS]
        powers(d, d.first, x, g, 0)
        powers(d, d.second, y, g, 6)
        for i in range(6):
            g[i] *= z[m + 3]
            g[6 + i] *= z[m + 4]
        for i in range(12):
            out = 0.0
            for j in range(12):
                out += d.table[BEND + i, j] * g[j]
            s[BENT + i] = out
        w1, slope1 = deflection(d, d.first, x, s, BENT)
        w2, slope2 = deflection(d, d.second, y, s, BENT + 6)
    X1, X2 = place(d, d.first, x, w1 - d.h / 2), place(d, d.second, y, w2 + d.h / 2)
    moved1, moved2 = rotated(e, X1), rotated(e, X2)
    along1, along2 = rotated(e, tangent(d.first, slope1)), rotated(e, tangent(d.second, slope2))
    D, by_phi, n = meet(d, f, add(u, 1.0, moved1), add(u, 1.0, moved2), along1, along2)
    ahead = scaled(1 / np.sqrt(dot(along1, along1)), along1)
    aside = cross(n, ahead)
    s[CROSSING] = dot(ahead, turn(f, along2)) / np.sqrt(dot(along2, along2))
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
            V = slip(d, f, step, room, e, x, y, moved1, moved2, normal, by_phi)
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
    d: Design, f: Frame, step: Step, room: Array, e: Turned, x: float, y: float, moved1: Vector, moved2: Vector,
    normal: Vector, by_phi: Vector,
) -> Vector:  # fmt: skip
    """Return the slip of scale 1 on the other over the step, by the backward difference."""
    z, a, c = room[NEW], room[LAST], room[BEFORE]
    du, o = rates(step, z, a, c, e)
    one, two = add(du, 1.0, cross(o, moved1)), add(du, 1.0, cross(o, moved2))
    if d.elastic:
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

"""One contact of two edges of thick, elastic scales on a joint that gives: its equations, compiled.

Scale 1 touches with an edge of its lower face, scale 1 + k with an edge of its upper face. In the axes of a scale at
rest, from its base midpoint, with E the rotation by the vector w and (with primes: turned into these axes) R' the turn
by k phi, O' the place of the base midpoint, z' the axis,

    x1 = u + E X1        x2 = R' (u + E X2 + O') - O' + k z'        D = x1 - x2

X1 = (x, y, deflection - h/2) on the edge of scale 1, X2 likewise with + h/2. The unknowns are q = (u, w), the places
on both edges and the force N while it slips, or the force's three components while it sticks, the forces c1, c2 along
the scales' own normals, which bend them, and the angle of t from the first edge while friction slips:

    K q + K_phi phi = D_q^T F        D = 0        F = N (n - mu t)        c1 = F . E e_3,  c2 = -(R'^T F) . E e_3

n is the common normal of the edges and t the direction of slip: V . (n x t) = 0 and V . t > 0 with V the rate of D at
material points, by backward differences of second order. So a contact that hardly slips has a direction, too: that of
its friction. The torque is K_phi . (q, phi) - D_phi . F, the bar's included.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from squama.batch.keeping import inlined, part
from squama.types import Array

MOTIONS, MOST = 6, 12
"""Motions u, w of a scale; unknowns at most: these, three of the contact, c1 and c2, the angle of slip."""
Vector = tuple[float, float, float]

_jit, _in = part, inlined


class Design(NamedTuple):
    """What does not change along a path: lengths in pitches, E = 1, angles in rad.

    ``first``, ``second``: the edges that meet, by number (:mod:`squama.model.elastic_plate`), of scales 1 and 1 + k;
    ``sign`` that of n; ``table`` (43, 12): rows of K (7, 7) over (u, w, phi), neither bent nor stretched, from ``BEND``
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


BEND, SHAPE, ROWS = 7, 19, 43
"""Rows of a design's table."""
AT, BENT, FORCE, SLIDING, PHI, TORQUE, NORMAL, FRICTION = 12, 14, 26, 29, 32, 33, 34, 35
SPEED, CROSSING, WIDTH = 36, 37, 40
"""Columns of a state: unknowns, places, deflections of both edges, force, direction of slip, twist, torque, N,
tangential force, slip per twist, cosine of the angle between the edges."""
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
    """What depends on the twist alone: R', its rate with phi (row by row), the axis z' and O' in a scale's axes."""

    a: Vector
    b: Vector
    c: Vector
    da: Vector
    db: Vector
    dc: Vector
    z: Vector
    o: Vector


@_in
def copy(of: Array, to: Array) -> None:
    """Write an array's entries into another; an assignment of slices takes long to compile."""
    for i in range(of.size):
        to[i] = of[i]


@_jit
def put(of: Array, to: Array) -> None:
    """Write a matrix into another one's first rows and columns."""
    for i in range(of.shape[0]):
        copy(of[i], to[i])


@_in
def dot(a: Vector, b: Vector) -> float:
    """Return a . b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@_in
def cross(a: Vector, b: Vector) -> Vector:
    """Return a x b."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@_in
def add(a: Vector, s: float, b: Vector) -> Vector:
    """Return a + s b."""
    return a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]


@_in
def scaled(s: float, a: Vector) -> Vector:
    """Return s a."""
    return s * a[0], s * a[1], s * a[2]


@_in
def mixed(a: float, x: Vector, b: float, y: Vector, c: float, z: Vector) -> Vector:
    """Return a x + b y + c z."""
    return a * x[0] + b * y[0] + c * z[0], a * x[1] + b * y[1] + c * z[1], a * x[2] + b * y[2] + c * z[2]


@_jit
def frame(d: Design, phi: float, k: int) -> Frame:
    """Return what the twist per pitch makes of neighbour k."""
    c, s = math.cos(k * phi), math.sin(k * phi)
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
        z, scaled(d.lam, y),
    )  # fmt: skip


@_in
def turn(f: Frame, v: Vector) -> Vector:
    """Return R' v."""
    return dot(f.a, v), dot(f.b, v), dot(f.c, v)


@_in
def back(f: Frame, v: Vector) -> Vector:
    """Return R'^T v."""
    return mixed(v[0], f.a, v[1], f.b, v[2], f.c)


class Turned(NamedTuple):
    """A rotation by the vector w: sin(t)/t, (1 - cos t)/t^2 and (t - sin t)/t^3 of its angle t."""

    w: Vector
    a: float
    b: float
    c: float


@_in
def turned(w: Vector) -> Turned:
    """Return the rotation by a vector."""
    q = dot(w, w)
    if q < 0.05:
        a = 1 - q / 6 * (1 - q / 20 * (1 - q / 42 * (1 - q / 72 * (1 - q / 110))))
        b = 0.5 - q / 24 * (1 - q / 30 * (1 - q / 56 * (1 - q / 90 * (1 - q / 132))))
        return Turned(w, a, b, 1 / 6 - q / 120 * (1 - q / 42 * (1 - q / 72 * (1 - q / 110))))
    t = math.sqrt(q)
    a = math.sin(t) / t
    return Turned(w, a, (1 - math.cos(t)) / q, (1 - a) / q)


@_in
def rotated(e: Turned, x: Vector) -> Vector:
    """Return E x."""
    y = cross(e.w, x)
    return add(add(x, e.a, y), e.b, cross(e.w, y))


@_in
def spin(e: Turned, dw: Vector) -> Vector:
    """Return the vector o of a change dw: E x changes by o x (E x)."""
    return add(mixed(e.a, dw, e.b, cross(e.w, dw), 0.0, dw), e.c * dot(e.w, dw), e.w)


@_in
def by_vector(e: Turned, moment: Vector) -> Vector:
    """Return the gradient by w of the work whose moment is given: the transposed map of :func:`spin`."""
    return add(mixed(e.a, moment, -e.b, cross(e.w, moment), 0.0, moment), e.c * dot(e.w, moment), e.w)


@_in
def place(d: Design, edge: int, x: float, z: float) -> Vector:
    """Return the place on an edge at height z."""
    if edge == 0:
        return d.eta, x, z
    if edge == 1:
        return x, -d.beta, z
    if edge == 2:
        return x, d.beta, z
    return 0.0, x, z


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
    D = add(add(add(one, -1.0, turn(f, inner)), 1.0, f.o), -d.k, f.z)
    n = cross(turn(f, along2), along1)
    by_phi = (dot(f.da, inner), dot(f.db, inner), dot(f.dc, inner))
    return D, by_phi, scaled(d.sign / math.sqrt(dot(n, n)), n)


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
    ahead = scaled(1 / math.sqrt(dot(along1, along1)), along1)
    aside = cross(n, ahead)
    s[CROSSING] = dot(ahead, turn(f, along2)) / math.sqrt(dot(along2, along2))
    if step.stuck:
        F = (z[m], z[m + 1], z[m + 2])
        N = dot(F, n)
        across = add(F, -N, n)
        friction = math.sqrt(dot(across, across))
        s[NORMAL], s[FRICTION], s[SPEED] = N, friction, 0.0
        if friction > 0.0:
            t = scaled(-1 / friction, across)
            s[SLIDING], s[SLIDING + 1], s[SLIDING + 2] = t
            s[angle(d)] = math.atan2(dot(t, aside), dot(t, ahead))
    else:
        N = z[m + 2]
        F = scaled(N, n)
        s[NORMAL], s[FRICTION], s[SPEED] = N, d.mu * N, 0.0
        if d.mu > 0.0:
            c, a = math.cos(z[angle(d)]), math.sin(z[angle(d)])
            t = mixed(c, ahead, a, aside, 0.0, n)
            V = slip(d, f, step, room, e, x, y, moved1, moved2, normal, by_phi)
            r[angle(d)] = (c * dot(V, aside) - a * dot(V, ahead)) / abs(step.dphi)
            s[SPEED] = dot(V, t) / abs(step.dphi)
            s[SLIDING], s[SLIDING + 1], s[SLIDING + 2] = t
            F = add(F, -d.mu * N, t)
    behind = back(f, F)
    push, moment = add(F, -1.0, behind), by_vector(e, add(cross(moved1, F), -1.0, cross(moved2, behind)))
    for i in range(m):
        out = d.table[i, 6] * phi
        for j in range(m):
            out += d.table[i, j] * z[j]
        r[i] = out
    for i in range(3):
        r[i] -= push[i]
        r[3 + i] -= moment[i]
        r[m + i] = D[i]
    if d.elastic:
        r[m + 3] = z[m + 3] - dot(F, normal)
        r[m + 4] = z[m + 4] + dot(behind, normal)
    torque = d.table[6, 6] * phi + dot(F, by_phi)
    for j in range(m):
        torque += d.table[6, j] * z[j]
    s[FORCE], s[FORCE + 1], s[FORCE + 2] = F
    s[PHI], s[TORQUE] = phi, torque


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

"""A design of the compiled model, and what twist, or bend and twist, make of the neighbours of its scales."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from squama.batch.keeping import inlined, making
from squama.contacts.vectors import Vector, add, cross, dot, mixed, rotated, scaled, spin, turned
from squama.types import Array

MOTIONS = 6
"""Motions u, w of a scale."""

_jit, _in = making, inlined


class Design(NamedTuple):
    """What does not change along a path: lengths in pitches, E = 1, angles in rad.

    ``first``, ``second``: the edges or other features that meet, by number (:mod:`squama.real.features`), of scales 1
    and 1 + k; ``sign`` that of n; ``table`` (46, 24): rows of K (9, 9) over (u, w, phi, psi, epsilon), or of (7, 7),
    from ``BEND`` on the compliances (12, 12) between the powers of the places on both edges, from ``SHAPE`` on those
    (24, 24) between the powers X^m Y^n of the whole plate; these are without effect unless ``elastic``.
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
"""Cosine of the turn at a corner of a path, below which it is one."""


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

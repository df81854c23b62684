r"""A row of N scales on a joint that gives, each with motions of its own: its equations, compiled.

One twist per pitch is common to all. Scale i has motions q_i = (u, w), the length held, and touches the next one with
the edges of :mod:`squama.real.contact`; contact i has places on both edges and a force, F_i on scale i. A plate bends
by the parts c1 of F_i and c2 of -F_(i-1) along its own normal. In the axes of scale i,

    K q_i + K_phi phi = x1_q^T F_i - x2_q^T R'^T F_(i-1) + Q_i theta_q
    closed contact:  D = 0,  F_t = P(F_t - k V)        open contact:  F = 0,  D along n
    0 <= gap, N >= 0                                   0 <= theta_i, Q_i >= 0

F_t = F - N n, V the slip over the step by backward differences as for one contact, and P the nearest place in the disk
of radius mu N: Coulomb's law, sliding or sticking, whatever the stiffness k > 0. Q holds a scale that lies on the
substrate by a moment that only lifts. The torque is the mean over the scales of K_phi . (q, phi) + F . x2_phi.
"""

from __future__ import annotations

import math

import numpy as np

from squama.real.contact import Step, bending, meet, rates
from squama.real.design import BEND, Design, Frame, _in, _jit, back, frame, turn
from squama.real.faces import overlap, reach
from squama.real.features import deflection, place, powers, shape, tangent
from squama.contacts.vectors import Vector, add, by_vector, copy, cross, dot, put, rotated, scaled, turned
from squama.types import Array

X, Y, F, C1, C2, Q, UNKNOWNS = 6, 7, 8, 11, 12, 13, 14
"""Unknowns of a scale after its six motions: places on both edges of its contact with the next, force, forces on the
plate, moment of the substrate."""
BENT, GAP, NORMAL, FRICTION, RUBBED, TORQUE, THETA, WIDTH = UNKNOWNS, 26, 27, 28, 29, 30, 31, 32
"""Columns of a scale's state after these: deflections of both edges, gap, N, friction, its work over the step by the
last of its forces, torque, inclination."""
REACH = 2 * UNKNOWNS - 1
"""Width of the band of the matrix on each side: a scale shares equations with the two beside it."""
_MOVE, _LEAST_MOVE = 1e-6, 1e-11


@_jit
def bow(d: Design, s: Array, touched: Array, i: int) -> None:
    """Write the deflections along both edges of a scale into its state."""
    if d.elastic:
        g, z = np.zeros(12), s[i]
        if touched[i]:
            powers(d, d.first, z[X], g, 0)
        if i > 0 and touched[i - 1]:
            powers(d, d.second, s[i - 1, Y], g, 6)
        for j in range(6):
            g[j] *= z[C1]
            g[6 + j] *= z[C2]
        for j in range(12):
            out = 0.0
            for k in range(12):
                out += d.table[BEND + j, k] * g[k]
            z[BENT + j] = out


@_in
def arm(d: Design, edge: int, x: float, z: Array, first: int, half: float) -> tuple[Vector, float]:
    """Return a place on a bent edge, in its scale, and the slope there."""
    w, slope = deflection(d, edge, x, z, first) if d.elastic else (0.0, 0.0)
    return place(d, edge, x, w + half), slope


@_jit
def contact(d: Design, f: Frame, step: Step, states: Array, i: int, closed: bool, r: Array) -> None:
    """Write the equations (5,) of the contact of a scale with the next one, and its figures into the state."""
    s, z = states[0, i], states[0, i + 1]
    e1, e2 = turned((s[3], s[4], s[5])), turned((z[3], z[4], z[5]))
    X1, slope1 = arm(d, d.first, s[X], s, BENT, -d.h / 2)
    X2, slope2 = arm(d, d.second, s[Y], z, BENT + 6, d.h / 2)
    moved1, moved2 = rotated(e1, X1), rotated(e2, X2)
    along1, along2 = rotated(e1, tangent(d.first, slope1)), turn(f, rotated(e2, tangent(d.second, slope2)))
    one, two = add((s[0], s[1], s[2]), 1.0, moved1), add((z[0], z[1], z[2]), 1.0, moved2)
    D, by_phi, n = meet(d, f, one, two, along1, along2)
    side, force = cross(n, along1), (s[F], s[F + 1], s[F + 2])
    N, stiff = dot(force, n), d.table[4, 4] / d.eta**2
    a, c, a2, c2 = states[1, i], states[2, i], states[1, i + 1], states[2, i + 1]
    du1, o1 = rates(step, s, a, c, e1)
    du2, o2 = rates(step, z, a2, c2, e2)
    V1, V2 = add(du1, 1.0, cross(o1, moved1)), add(du2, 1.0, cross(o2, moved2))
    if d.elastic:
        V1 = add(V1, bending(d, step, s, a, c, d.first, s[X], BENT), rotated(e1, (0.0, 0.0, 1.0)))
        V2 = add(V2, bending(d, step, z, a2, c2, d.second, s[Y], BENT + 6), rotated(e2, (0.0, 0.0, 1.0)))
    V = add(add(V1, -1.0, turn(f, V2)), -step.dphi, by_phi)
    V = add(V, -dot(V, n), n)
    rubbing = add(force, -N, n)
    held = add(rubbing, -stiff, V)
    size, most = math.sqrt(dot(held, held)), d.mu * max(N, 0.0)
    off = scaled(stiff, V) if size <= most else add(rubbing, -most / size, held)
    s[GAP], s[NORMAL], s[FRICTION], s[RUBBED] = dot(D, n), N, math.sqrt(dot(rubbing, rubbing)), -dot(rubbing, V)
    s[TORQUE] = dot(force, by_phi)
    if closed:
        r[0], r[1], r[2] = D
        r[3], r[4] = dot(off, along1), dot(off, side)
    else:
        r[0], r[1] = dot(D, along1), dot(D, along2)
        r[2], r[3], r[4] = force


@_jit
def scale(d: Design, f: Frame, phi: float, step: Step, states: Array, marks: Array, i: int, r: Array) -> None:
    """Write the residual (14,) of a scale and of its contact with the next one.

    ``marks`` (3, n): where there is a contact with the next one, which are closed, which scales lie on the substrate.
    """
    s = states[0, i]
    e, push, moment = turned((s[3], s[4], s[5])), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    normal, up = rotated(e, (0.0, 0.0, 1.0)), rotated(e, (1.0, 0.0, 0.0))
    r[C1], r[C2] = s[C1], s[C2]
    if marks[0, i]:
        push = (s[F], s[F + 1], s[F + 2])
        moment = cross(rotated(e, arm(d, d.first, s[X], s, BENT, -d.h / 2)[0]), push)
        if d.elastic:
            r[C1] -= dot(push, normal)
        contact(d, f, step, states, i, marks[1, i], r[X:C1])
    else:
        copy(s[X:C1], r[X:])
        s[TORQUE] = 0.0
    if i > 0 and marks[0, i - 1]:
        b = states[0, i - 1]
        behind = back(f, (b[F], b[F + 1], b[F + 2]))
        push = add(push, -1.0, behind)
        moment = add(moment, -1.0, cross(rotated(e, arm(d, d.second, b[Y], s, BENT + 6, d.h / 2)[0]), behind))
        if d.elastic:
            r[C2] += dot(behind, normal)
    # inclination of the scale's length over the bar's face, and its gradient by a turn
    s[THETA] = math.atan2(d.st, d.ct) + math.atan2(up[2], up[0])
    r[Q] = s[THETA] if marks[2, i] else s[Q]
    lever = scaled(s[Q] / (up[0] * up[0] + up[2] * up[2]), cross(up, (-up[2], 0.0, up[0])))
    moment = by_vector(e, add(moment, 1.0, lever))
    torque = d.table[6, 6] * phi
    for j in range(6):
        r[j] = d.table[j, 6] * phi - (push[j] if j < 3 else moment[j - 3])
        for k in range(6):
            r[j] += d.table[j, k] * s[k]
        torque += d.table[6, j] * s[j]
    s[TORQUE] += torque


@_jit
def assemble(d: Design, phi: float, step: Step, states: Array, marks: Array, r: Array, band: Array) -> None:
    """Write the residual (n, 14) of a row and the band of its derivative, as :func:`scipy.linalg.solve_banded` has it.

    ``states`` (3, n, 32): the new one, whose unknowns are given, and the two before.
    """
    n, f, s, moved = len(r), frame(d, phi, d.k), states[0], np.empty(UNKNOWNS)
    for i in range(n):
        bow(d, s, marks[0], i)
    for i in range(n):
        scale(d, f, phi, step, states, marks, i, r[i])
    if not band.size:
        return
    # well below the slip, whose direction counts
    move = max(_LEAST_MOVE, _MOVE * step.dphi)
    band[:] = 0.0
    kept = np.empty((3, WIDTH))
    for j in range(n):
        first, last = max(0, j - 1), min(n, j + 2)
        put(s[first:last], kept)
        for c in range(UNKNOWNS):
            s[j, c] += move
            bow(d, s, marks[0], j)
            if j + 1 < n:
                bow(d, s, marks[0], j + 1)
            for i in range(first, last):
                scale(d, f, phi, step, states, marks, i, moved)
                for k in range(UNKNOWNS):
                    band[REACH + UNKNOWNS * (i - j) + k - c, UNKNOWNS * j + c] = (moved[k] - r[i, k]) / move
            put(kept[: last - first], s[first:])


@_jit
def look(d: Design, phi: float, s: Array, joined: Array, where: Array) -> tuple[int, int, int]:
    """Return the edge (see :func:`squama.real.faces.overlap`), scale and neighbour of another contact; edge -1: none.

    ``where`` (n,): the row of each scale in the state ``s``, of which contacts are with the next row where ``joined``.
    """
    n, deepest, found = len(s), 0.0, (-1, 0, 0)
    b, room = np.zeros((n, 24)), np.zeros(24)
    for i in range(n):
        x = s[i, X] if joined[i] else 0.0
        y = s[i - 1, Y] if i > 0 and joined[i - 1] else 0.0
        shape(d, x, y, 0.0, s[i, C1], s[i, C2], room, b[i], 0)
    for k in range(1, min(reach(d), n - 1) + 1):
        f = frame(d, phi, k)
        for a in range(n - k):
            i, j = where[a], where[a + k]
            deep, edge = overlap(d, f, 0.0, s[i], b[i], s[j], b[j])
            if deep < deepest:
                deepest, found = deep, (edge, a, k)
    return found

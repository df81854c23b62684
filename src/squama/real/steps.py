"""Steps along the twist in contact: Newton's method, engagement; compiled.

Jacobians are made by differences of the residual and kept while they lead to a solution quickly.
"""

from __future__ import annotations

import math

import numpy as np

from squama.real.contact import (  # isort: skip
    AT, LAST, MISSED, MOVED, NEW, PHI, SLIDING, STRETCH, Step, angle, held, residual,
)  # fmt: skip
from squama.real.design import LEG, MOTIONS, SHAPE, Design, Frame, _in, _jit, frame, turn
from squama.real.features import FACE, lengthwise, on_face, press, rolls, spots
from squama.contacts.vectors import Vector, add, cross, dot, mixed, rotated, scaled, turned
from squama.types import Array

TIGHT = 1e-8
"""Newton's last correction, relative."""
_MOVE = 1e-7
_ROUNDS, _FEW, _QUICK, _ANGLE = 20, 5, 0.3, 1e-3


@_jit
def invert(A: Array, order: Array, n: int) -> bool:
    """Invert a matrix in place with row exchanges; False where it is singular."""
    for k in range(n):
        best, p = 0.0, k
        for i in range(k, n):
            if abs(A[i, k]) > best:
                best, p = abs(A[i, k]), i
        if not best > 0.0:
            return False
        order[k] = p
        if p != k:
            for j in range(n):
                A[k, j], A[p, j] = A[p, j], A[k, j]
        pivot, A[k, k] = A[k, k], 1.0
        for j in range(n):
            A[k, j] /= pivot
        for i in range(n):
            if i != k:
                g = A[i, k]
                A[i, k] = 0.0
                for j in range(n):
                    A[i, j] -= g * A[k, j]
    for k in range(n - 1, -1, -1):
        if order[k] != k:
            for i in range(n):
                A[i, k], A[i, order[k]] = A[i, order[k]], A[i, k]
    return True


@_jit
def jacobian(d: Design, f: Frame, phi: float, step: Step, room: Array, J: Array, order: Array, n: int) -> bool:
    """Invert the Jacobian at the new state's unknowns, whose residual is in the room."""
    z, r, moved = room[NEW], room[MISSED], room[MOVED]
    for j in range(n):
        kept = z[j]
        z[j] = kept + _MOVE
        residual(d, f, phi, step, room, MOVED)
        for i in range(n):
            J[i, j] = (moved[i] - r[i]) / _MOVE
        z[j] = kept
    return invert(J, order, n)


@_jit
def solve(d: Design, phi: float, step: Step, room: Array, J: Array, order: Array, known: bool) -> tuple[bool, bool]:
    """Solve for the new state at a twist from its guess; whether it was found, and whether J may be kept."""
    n = angle(d) + (0 if step.stuck or d.mu == 0.0 else 1)
    if step.stuck and phi == room[LAST, PHI]:
        # nothing rolls where nothing moves on
        n = held(d)
    f, z, r, moved = frame(d, phi, d.k), room[NEW], room[MISSED], room[MOVED]
    old, fresh = math.inf, False
    for count in range(_ROUNDS):
        residual(d, f, phi, step, room, MISSED)
        if not known:
            if not jacobian(d, f, phi, step, room, J, order, n):
                return False, False
            known, fresh, old = True, True, math.inf
        size = 0.0
        for i in range(n):
            moved[i] = 0.0
            for j in range(n):
                moved[i] += J[i, j] * r[j]
            # an angle turns little of the force
            size = max(size, abs(moved[i]) if i < angle(d) else _ANGLE * abs(moved[i]))
        if not size < 1.0:
            return False, False
        for j in range(n):
            z[j] -= moved[j]
        # a Jacobian has moved what goes with the unknowns; else that may lag behind by so little
        if size < TIGHT and not fresh:
            if not step.stuck:
                z[AT], z[AT + 1] = z[MOTIONS], z[MOTIONS + 1]
            if rolls(d):
                z[AT + 2] = z[held(d)]
            # of the angles of one direction that next to the last state's, from which steps are extrapolated
            z[angle(d)] -= 2 * math.pi * np.floor((z[angle(d)] - room[LAST, angle(d)]) / (2 * math.pi) + 0.5)
            return True, count < _FEW
        known = fresh or size < _QUICK * old
        fresh, old = False, size
    return False, False


@_jit
def apart(d: Design, phi: float, q: Array, x: float, y: float) -> Vector:
    """Return D between places on straight edges, or on a flat face, at motions q (7,), the stretch the last of them."""
    f, u, w = frame(d, phi, d.k), (q[0], q[1], q[2]), (q[3], q[4], q[5])
    e, (x1, y1, x2, y2) = turned(w), spots(d, x, y, 0.0 * y)
    one = add(u, 1.0, rotated(e, (x1, y1, -d.h / 2)))
    two = add(add(u, 1.0, rotated(e, (x2, y2, d.h / 2))), 1.0, f.o)
    return add(add(add(one, -1.0, turn(f, two)), 1.0, f.o), -1.0 - q[6], f.t)


@_jit
def solved(A: Array, b: Array) -> Array:
    """Return A^-1 b for a small matrix and columns b (n, m)."""
    inverse, n = A.copy(), b.shape[0]
    invert(inverse, np.empty(n, np.int64), n)
    return inverse @ b


@_jit
def free_rates(d: Design) -> Array:
    """Return the motions and the stretch while nothing touches: (7, 2), per twist (or way), and where that is 0."""
    loads, leg = np.zeros((7, 2), d.table.dtype), d.table[LEG]
    for i in range(7):
        if d.bent:
            row = d.table[i if i < MOTIONS else 8]
            loads[i, 0] = -row[6] * leg[3] - row[7] * leg[2]
            loads[i, 1] = -row[6] * leg[1] - row[7] * leg[0]
        elif i < MOTIONS:
            loads[i, 0] = -d.table[i, 6]
    return solved(loosened(d), loads)


@_jit
def loosened(d: Design) -> Array:
    """Return the stiffness (7, 7) over the motions and the stretch, out of reach of a length that is held."""
    A = np.zeros((7, 7), d.table.dtype)
    for i in range(MOTIONS):
        for j in range(MOTIONS):
            A[i, j] = d.table[i, j]
        if d.bent and d.table[LEG, 4].real > 0.0:
            A[i, 6] = A[6, i] = d.table[8, i]
    A[6, 6] = 1 / d.table[LEG, 4] if d.table[LEG, 4].real > 0.0 else math.inf
    return A


@_in
def unloaded(rates: Array, phi: float, q: Array) -> None:
    """Write the motions and the stretch (7,) at a twist while nothing touches."""
    for j in range(7):
        q[j] = phi * rates[j, 0] + rates[j, 1]


@_jit
def engagement(d: Design, rates: Array, guess: Vector) -> tuple[bool, float, float, float]:
    """Solve D = 0 on the path without contact for the twist and both places, from a guess of them."""
    v = np.array(guess)
    J, r, q = np.empty((3, 3), v.dtype), np.empty((3, 1), v.dtype), np.empty(7, v.dtype)
    for _ in range(30):
        unloaded(rates, v[0], q)
        D = apart(d, v[0], q, v[1], v[2])
        for j in range(3):
            o = v.copy()
            o[j] += _MOVE
            unloaded(rates, o[0], q)
            moved = apart(d, o[0], q, o[1], o[2])
            for i in range(3):
                J[i, j] = (moved[i] - D[i]) / _MOVE
        r[0, 0], r[1, 0], r[2, 0] = D
        change = solved(J, r)[:, 0]
        size = np.abs(change).max()
        if not size < 1e6:
            break
        v -= change * min(1.0, 0.3 / size)
        if size < TIGHT:
            return True, v[0], v[1], v[2]
    return False, v[0], v[1], v[2]


@_jit
def rates_engaging(d: Design, way: float, room: Array) -> bool:
    """Write the rates with |twist| of the unknowns at engagement into the new state; False if the contact cannot slip.

    Its direction is looked for all around, since friction turns it; it is written into the last state.
    """
    last, guess = room[LAST], room[NEW]
    m, phi, x, y = MOTIONS, last[PHI], last[AT], last[AT + 1]
    q = np.empty(7)
    for j in range(m):
        q[j] = last[j]
    q[m] = last[STRETCH]
    Dq, base = np.empty((3, 7)), apart(d, phi, q, x, y)
    for j in range(7):
        q[j] += _MOVE
        moved = apart(d, phi, q, x, y)
        q[j] -= _MOVE
        for i in range(3):
            Dq[i, j] = (moved[i] - base[i]) / _MOVE
    moved = apart(d, phi + _MOVE, q, x, y)
    free = free_rates(d)
    V0 = np.empty(3)
    for i in range(3):
        V0[i] = way * (moved[i] - base[i]) / _MOVE
        for j in range(7):
            V0[i] += Dq[i, j] * way * free[j, 0]
    given = solved(loosened(d), Dq.T.copy())
    C = Dq @ given
    f, w = frame(d, phi, d.k), (q[3], q[4], q[5])
    e = turned(w)
    up = rotated(e, (0.0, 0.0, 1.0))
    other = turn(f, up)
    if d.elastic:
        c11, c12, c22 = compliance(d, x, y)
        for i in range(3):
            for j in range(3):
                C[i, j] += c11 * up[i] * up[j] - c12 * (up[i] * other[j] + other[i] * up[j]) + c22 * other[i] * other[j]
    along1 = rotated(e, (1.0, 0.0, 0.0) if lengthwise(d.first) or on_face(d) else (0.0, 1.0, 0.0))
    along1 = turn(f, along1) if d.second == FACE else along1
    along2 = rotated(e, (1.0, 0.0, 0.0) if lengthwise(d.second) else (0.0, 1.0, 0.0))
    along2 = along2 if d.first == FACE else turn(f, along2)
    n = cross(along2, along1)
    n = scaled(d.sign / math.sqrt(dot(n, n)), n)
    side = cross(n, along1)
    Cn = (C[0, 0] * n[0] + C[0, 1] * n[1] + C[0, 2] * n[2], C[1, 0] * n[0] + C[1, 1] * n[1] + C[1, 2] * n[2],
          C[2, 0] * n[0] + C[2, 1] * n[1] + C[2, 2] * n[2])  # fmt: skip
    v0 = (V0[0], V0[1], V0[2])
    found, N, t = False, 0.0, side
    before, turns = 0.0, 1 if d.mu == 0.0 else 180
    for i in range(turns + 1):
        if turns > 1:
            last[angle(d)] = 2 * math.pi * i / turns
            t = mixed(math.cos(last[angle(d)]), along1, math.sin(last[angle(d)]), side, 0.0, n)
        push = add(n, -d.mu, t)
        stiff = dot(Cn, push)
        N = -dot(n, v0) / stiff if stiff > 0.0 else 0.0
        V = (v0[0] + N * (C[0, 0] * push[0] + C[0, 1] * push[1] + C[0, 2] * push[2]),
             v0[1] + N * (C[1, 0] * push[0] + C[1, 1] * push[1] + C[1, 2] * push[2]),
             v0[2] + N * (C[2, 0] * push[0] + C[2, 1] * push[1] + C[2, 2] * push[2]))  # fmt: skip
        aside = dot(V, cross(n, t))
        if turns == 1 or (i > 0 and before * aside <= 0.0 and dot(V, t) > 0.0 and N > 0.0):
            found = N > 0.0
            break
        before = aside
    push = scaled(N, add(n, -d.mu, t))
    for j in range(m):
        guess[j] = way * free[j, 0] + given[j, 0] * push[0] + given[j, 1] * push[1] + given[j, 2] * push[2]
    # the place on a tip edge, too
    guess[held(d)] = guess[m] = guess[m + 1] = 0.0
    guess[m + 2] = N
    guess[m + 3], guess[m + 4] = dot(push, up), -dot(push, other)
    guess[angle(d)] = 0.0
    last[SLIDING], last[SLIDING + 1], last[SLIDING + 2] = t
    return found


@_jit
def compliance(d: Design, x: float, y: float) -> Vector:
    """Return the plates' compliances at the place of the first scale, of one by the other, and of the second one."""
    g, out = np.zeros((2, 24)), np.zeros(3)
    x1, y1, x2, y2 = spots(d, x, y, 0.0)
    press(d, x1, y1, 1.0, g[0])
    press(d, x2, y2, 1.0, g[1])
    for i in range(24):
        for j in range(24):
            S = d.table[SHAPE + i, j]
            out[0] += g[0, i] * S * g[0, j]
            out[1] += g[0, i] * S * g[1, j]
            out[2] += g[1, i] * S * g[1, j]
    return out[0], out[1], out[2]

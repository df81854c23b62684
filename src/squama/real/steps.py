"""Steps along the twist in contact: Newton's method, engagement, the onset of slip; compiled.

Jacobians are made by differences of the residual and kept while they lead to a solution quickly.
"""

from __future__ import annotations

import math

import numpy as np

from squama.real.contact import (
    AT,
    BEND,
    FORCE,
    LAST,
    MISSED,
    MOTIONS,
    MOVED,
    NEW,
    NORMAL,
    PHI,
    SLIDING,
    Design,
    Frame,
    Step,
    Vector,
    _in,
    _jit,
    add,
    cross,
    dot,
    frame,
    lengthwise,
    mixed,
    place,
    powers,
    residual,
    rotated,
    scaled,
    turn,
    turned,
)  # fmt: skip
from squama.types import Array

TIGHT = 1e-8
"""Newton's last correction, relative."""
_MOVE, _LEAST_MOVE = 1e-7, 1e-11
_ROUNDS, _FEW, _QUICK = 20, 5, 0.3


@_in
def factorise(A: Array, order: Array, n: int) -> bool:
    """Factorise a matrix in place with row exchanges; False where it is singular."""
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
        for i in range(k + 1, n):
            A[i, k] /= A[k, k]
            g = A[i, k]
            if g != 0.0:
                for j in range(k + 1, n):
                    A[i, j] -= g * A[k, j]
    return True


@_in
def substitute(A: Array, order: Array, n: int, b: Array) -> None:
    """Solve in place with a factorised matrix."""
    for k in range(n):
        p = order[k]
        if p != k:
            b[k], b[p] = b[p], b[k]
    for i in range(n):
        for j in range(i):
            b[i] -= A[i, j] * b[j]
    for i in range(n - 1, -1, -1):
        for j in range(i + 1, n):
            b[i] -= A[i, j] * b[j]
        b[i] /= A[i, i]


@_jit
def jacobian(d: Design, f: Frame, phi: float, step: Step, room: Array, J: Array, order: Array, n: int) -> bool:
    """Factorise the Jacobian at the new state's unknowns, whose residual is in the room."""
    z, r, moved = room[NEW], room[MISSED], room[MOVED]
    # well below the slip, whose direction counts
    move = max(_LEAST_MOVE, min(_MOVE, 1e-3 * abs(step.dphi)))
    for j in range(n):
        kept = z[j]
        z[j] = kept + move
        residual(d, f, phi, step, room, MOVED)
        for i in range(n):
            J[i, j] = (moved[i] - r[i]) / move
        z[j] = kept
    return factorise(J, order, n)


@_jit
def solve(d: Design, phi: float, step: Step, room: Array, J: Array, order: Array, known: bool) -> tuple[bool, bool]:
    """Solve for the new state at a twist from its guess; whether it was found, and whether J may be kept."""
    n = MOTIONS + 3 + (2 if d.elastic else 0)
    f, z, r = frame(d, phi, d.k), room[NEW], room[MISSED]
    old, fresh = math.inf, False
    for i in range(_ROUNDS):
        residual(d, f, phi, step, room, MISSED)
        if not known:
            if not jacobian(d, f, phi, step, room, J, order, n):
                return False, False
            known, fresh, old = True, True, math.inf
        substitute(J, order, n, r)
        size = 0.0
        for j in range(n):
            z[j] -= r[j]
            size = max(size, abs(r[j]))
        if not size < 1.0:
            return False, False
        if size < TIGHT:
            # deflections of soft plates count, too
            residual(d, f, phi, step, room, MISSED)
            return True, i < _FEW
        known = fresh or size < _QUICK * old
        fresh, old = False, size
    return False, False


@_jit
def apart(d: Design, phi: float, q: Array, x: float, y: float) -> Vector:
    """Return D between places on straight edges at motions q (6,)."""
    f, u, w = frame(d, phi, d.k), (q[0], q[1], q[2]), (q[3], q[4], q[5])
    e = turned(w)
    one = add(u, 1.0, rotated(e, place(d, d.first, x, -d.h / 2)))
    two = add(add(u, 1.0, rotated(e, place(d, d.second, y, d.h / 2))), 1.0, f.o)
    return add(add(add(one, -1.0, turn(f, two)), 1.0, f.o), -d.k, f.z)


@_jit
def solved(A: Array, b: Array) -> Array:
    """Return A^-1 b for a small matrix and columns b (n, m)."""
    n = b.shape[0]
    A, out, order = A.copy(), b.copy(), np.empty(n, np.int64)
    factorise(A, order, n)
    for j in range(b.shape[1]):
        column = out[:, j].copy()
        substitute(A, order, n, column)
        out[:, j] = column
    return out


@_jit
def free_rates(d: Design) -> Array:
    """Return the motions (6,) per twist while nothing touches."""
    return -solved(d.table[:6, :6], d.table[:6, 6:7])[:, 0]


@_jit
def engagement(d: Design, rates: Array, guess: Vector) -> tuple[bool, float, float, float]:
    """Solve D = 0 on the path without contact for the twist and both places, from a guess of them."""
    v, J, r = np.array(guess), np.empty((3, 3)), np.empty((3, 1))
    for _ in range(30):
        D = apart(d, v[0], v[0] * rates, v[1], v[2])
        for j in range(3):
            o = v.copy()
            o[j] += _MOVE
            moved = apart(d, o[0], o[0] * rates, o[1], o[2])
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
    return False, 0.0, 0.0, 0.0


@_jit
def rates_engaging(d: Design, way: float, room: Array) -> bool:
    """Write the rates with |twist| of the unknowns at engagement into the new state; False if the contact cannot slip.

    Its direction is looked for all around, since friction turns it.
    """
    last, guess = room[LAST], room[NEW]
    m, phi, x, y = MOTIONS, last[PHI], last[AT], last[AT + 1]
    q = last[:m].copy()
    Dq, base = np.empty((3, m)), apart(d, phi, q, x, y)
    for j in range(m):
        q[j] += _MOVE
        moved = apart(d, phi, q, x, y)
        q[j] -= _MOVE
        for i in range(3):
            Dq[i, j] = (moved[i] - base[i]) / _MOVE
    moved = apart(d, phi + _MOVE, q, x, y)
    free = way * free_rates(d)
    V0 = np.empty(3)
    for i in range(3):
        V0[i] = way * (moved[i] - base[i]) / _MOVE
        for j in range(m):
            V0[i] += Dq[i, j] * free[j]
    given = solved(d.table[:m, :m], Dq.T.copy())
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
    along1 = rotated(e, (1.0, 0.0, 0.0) if lengthwise(d.first) else (0.0, 1.0, 0.0))
    along2 = turn(f, rotated(e, (1.0, 0.0, 0.0) if lengthwise(d.second) else (0.0, 1.0, 0.0)))
    n = cross(along2, along1)
    n = scaled(d.sign / math.sqrt(dot(n, n)), n)
    side = cross(n, along1)
    Cn = (C[0, 0] * n[0] + C[0, 1] * n[1] + C[0, 2] * n[2], C[1, 0] * n[0] + C[1, 1] * n[1] + C[1, 2] * n[2],
          C[2, 0] * n[0] + C[2, 1] * n[1] + C[2, 2] * n[2])  # fmt: skip
    v0 = (V0[0], V0[1], V0[2])
    found, N, t = False, 0.0, side
    before, turns = 0.0, 1 if d.mu == 0.0 else 720
    for i in range(turns + 1):
        if turns > 1:
            angle = 2 * math.pi * i / turns
            t = mixed(math.cos(angle), along1, math.sin(angle), side, 0.0, n)
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
        guess[j] = free[j] + given[j, 0] * push[0] + given[j, 1] * push[1] + given[j, 2] * push[2]
    guess[m], guess[m + 1], guess[m + 2] = 0.0, 0.0, N
    guess[m + 3], guess[m + 4] = dot(push, up), -dot(push, other)
    guess[SLIDING], guess[SLIDING + 1], guess[SLIDING + 2] = t
    return found


@_jit
def rates_sliding(d: Design, way: float, room: Array, J: Array, order: Array) -> bool:
    """Write the rates with |twist| of the unknowns where a sticking contact begins to slide into the new state.

    The slip sets out against the friction that acts, and as fast as keeps the force on the cone.
    """
    m, n, last, new = MOTIONS, MOTIONS + 3 + (2 if d.elastic else 0), room[LAST], room[NEW]
    phi, step, r, moved = last[PHI], Step(True, 1.0, -1.0, 0.0, way), room[MISSED], room[MOVED]
    new[:] = last
    new[m : m + 3] = last[FORCE : FORCE + 3]
    f = frame(d, phi, d.k)
    residual(d, f, phi, step, room, MISSED)
    if not jacobian(d, f, phi, step, room, J, order, n):
        return False
    residual(d, frame(d, phi + _MOVE, d.k), phi + _MOVE, step, room, MOVED)
    for i in range(n):
        moved[i] = -way * (moved[i] - r[i]) / _MOVE
        r[i] = 0.0
    t = (last[SLIDING], last[SLIDING + 1], last[SLIDING + 2])
    r[m], r[m + 1], r[m + 2] = t
    substitute(J, order, n, moved)
    substitute(J, order, n, r)
    F = (last[FORCE], last[FORCE + 1], last[FORCE + 2])
    normal = add(scaled(1 / last[NORMAL], F), d.mu, t)
    edge = add(t, d.mu, normal)
    stuck, slid = (moved[m], moved[m + 1], moved[m + 2]), (r[m], r[m + 1], r[m + 2])
    speed = -dot(stuck, edge) / dot(slid, edge)
    for j in range(n):
        new[j] = moved[j] + speed * r[j]
    new[m + 2] = dot((new[m], new[m + 1], new[m + 2]), normal)
    new[m], new[m + 1] = 0.0, 0.0
    new[SLIDING : SLIDING + 3] = last[SLIDING : SLIDING + 3]
    return speed > 0.0


@_jit
def compliance(d: Design, x: float, y: float) -> Vector:
    """Return the plates' compliances at the place on the first edge, of one by the other, and on the second edge."""
    g, out = np.empty(12), np.zeros(3)
    powers(d, d.first, x, g, 0)
    powers(d, d.second, y, g, 6)
    for i in range(12):
        for j in range(12):
            out[i // 6 + j // 6] += g[i] * d.table[BEND + i, j] * g[j]
    return out[0], out[1] / 2, out[2]

"""Geometry of scales and their neighbours: screws between cells and their rates, attitudes, deflections; compiled."""

from __future__ import annotations

from squama.batch.keeping import inlined as _in
from squama.batch.keeping import part as _jit
from squama.contacts.system import BETA, CHI, EPS, ETA, PHI, PSI, TILT, System, further, pieces, row_of
from squama.contacts.vectors import Turned, Vector, add, cross, dot, mixed, rotated, scaled, spin, turned, unit
from squama.types import Array

PLACED, RATES, LEANS = 12, 24, 15
"""Columns of a neighbour: its rotation, row by row, and translation; then rotation and translation per strain, for each
strain of each cell between, and per tilt of both scales, if they have tilts. Columns of a tilt: its rotation, row by
row; rotation and translation per tilt.
"""


@_in
def vector(a: Array, at: int) -> Vector:
    """Return three consecutive numbers of an array as a vector."""
    return a[at], a[at + 1], a[at + 2]


@_in
def put(v: Vector, a: Array, at: int) -> None:
    """Write a vector into an array at an index."""
    a[at], a[at + 1], a[at + 2] = v


@_in
def turn(R: Array, v: Vector) -> Vector:
    """Return R v, with R (9,) row by row at the beginning of an array."""
    x, y, z = v
    return R[0] * x + R[1] * y + R[2] * z, R[3] * x + R[4] * y + R[5] * z, R[6] * x + R[7] * y + R[8] * z


@_in
def back(R: Array, v: Vector) -> Vector:
    """Return R^T v, with R as in :func:`turn`."""
    x, y, z = v
    return R[0] * x + R[3] * y + R[6] * z, R[1] * x + R[4] * y + R[7] * z, R[2] * x + R[5] * y + R[8] * z


@_in
def rowwise(A: Array, v: Vector) -> Vector:
    """Return A v for a matrix (3, 3)."""
    return dot(vector(A[0], 0), v), dot(vector(A[1], 0), v), dot(vector(A[2], 0), v)


@_in
def slopes(e: Turned) -> tuple[float, float]:
    """Return the derivatives of (1 - cos t)/t^2 and (t - sin t)/t^3 with respect to w.w = t^2."""
    g = dot(e.w, e.w)
    if g.real < 0.05:
        b = -1 / 24 * (1 - g / 15 * (1 - 3 * g / 112 * (1 - 2 * g / 135)))
        return b, -1 / 120 * (1 - g / 21 * (1 - g / 48 * (1 - 2 * g / 165)))
    return (e.a - 2 * e.b) / (2 * g), (e.b - 3 * e.c) / (2 * g)


@_in
def mapped(x: Vector, y: Vector, z: Vector, v: Vector) -> Vector:
    """Return the vector with components v along x, y, z."""
    return mixed(v[0], x, v[1], y, v[2], z)


@_jit
def over_cell(S: System, strains: Array, i: int, k: float, axes: Array, base: Vector, out: Array) -> None:
    """Write how axes (3, 3) and a point move over ``k`` pitches of scale i's cell, and the rates of that motion.

    Written are the axes in columns, row by row, and the point; then rotation and translation per strain, for each
    strain.
    """
    psi, phi, chi, own = S.sees[i, PSI], S.sees[i, PHI], S.sees[i, CHI], strains[row_of(S, i)]
    none = 0.0 * strains[0, 0]
    w = (-k * psi * own[PSI], -k * chi * own[CHI], -k * phi * own[PHI])
    e, v = turned(w), (none, none, 1.0 + own[EPS])
    once = cross(w, v)
    twice = cross(w, once)
    T = scaled(k, mixed(1.0, v, e.b, once, e.c, twice))
    db, dc = slopes(e)
    for strain in range(4):
        if strain == EPS:
            up = (none, none, 1.0 + none)
            o1 = (none, none, none)
            turning = cross(w, up)
            dT = scaled(k, mixed(1.0, up, e.b, turning, e.c, cross(w, turning)))
        else:
            dw = (
                -k * (psi if strain == PSI else 0.0),
                -k * (chi if strain == CHI else 0.0),
                -k * (phi if strain == PHI else 0.0),
            )
            o1 = spin(e, dw)
            s = 2 * dot(w, dw)
            donce = cross(dw, v)
            dtwice = add(cross(dw, once), 1.0, cross(w, donce))
            dT = scaled(k, add(mixed(db * s, once, e.b, donce, dc * s, twice), e.c, dtwice))
        put(o1, out, PLACED + 6 * strain)
        put(add(dT, -1.0, cross(o1, T)), out, PLACED + 6 * strain + 3)
    put(add(rotated(e, base), 1.0, T), out, 9)
    for column in range(3):
        v = rotated(e, vector(axes[column], 0))
        out[column], out[3 + column], out[6 + column] = v


@_jit
def tilted(S: System, i: int, q: float, out: Array) -> None:
    """Write the tilt ``q`` of scale i along its section's axes: rotation, row by row, and both rates of the tilt."""
    A, none = S.axes[i], 0.0 * q
    w = mixed(S.tilts[i, 1], vector(A[0], 0), S.tilts[i, 2], vector(A[1], 0), none, vector(A[2], 0))
    e = turned(scaled(q, w))
    for column in range(3):
        out[column], out[3 + column], out[6 + column] = rotated(e, unit(column, none))
    put(w, out, 9)
    put(scaled(S.tilts[i, 0], vector(A[2], 0)), out, PLACED)


@_jit
def chain(S: System, q: Array, halves: Array, i: int, j: int, many: int, out: Array) -> None:
    """Write scale j, in the last of ``many`` cells from scale i's on, as :func:`neighbour`.

    ``halves`` (N, 51): the ways over half of each cell, and tilts. A tilt displaces a scale as seen from the section
    halfway to its neighbour; seen from both neighbours it is opposite.
    """
    A = S.axes[i]
    x, y, z = (A[0, 0], A[1, 0], A[2, 0]), (A[0, 1], A[1, 1], A[2, 1]), (A[0, 2], A[1, 2], A[2, 2])
    t = scaled(-1.0, rowwise(A, vector(S.bases[i], 0)))
    for half in range(2 * many - 2):
        p = (half + 1) // 2
        for last in range(2):
            # halfway to the next scale, and halfway from the last one but one
            if half != (2 * many - 3 if last else 1):
                continue
            a, sign = (j, 1.0) if last else (i, -1.0)
            T = halves[a, PLACED + RATES :]
            o1 = scaled(sign, mapped(x, y, z, vector(T, 9)))
            v1 = scaled(sign, mapped(x, y, z, vector(T, PLACED)))
            t = add(t, q[a, TILT], v1)
            o = PLACED + RATES * many + 6 * last
            put(o1, out, o)
            put(add(v1, 1.0, cross(t, o1)), out, o + 3)
            if last:
                X, Y, Z = (T[0], T[3], T[6]), (T[1], T[4], T[7]), (T[2], T[5], T[8])
            else:
                X, Y, Z = vector(T, 0), vector(T, 3), vector(T, 6)
            x, y, z = mapped(x, y, z, X), mapped(x, y, z, Y), mapped(x, y, z, Z)
        H = halves[i + p * S.stride]
        for rate in range(0, RATES, 6):
            o = PLACED + RATES * p + rate
            o1 = mapped(x, y, z, vector(H, PLACED + rate))
            v1 = add(mapped(x, y, z, vector(H, PLACED + rate + 3)), 1.0, cross(t, o1))
            if half % 2 == 0 and half > 0:
                # the second half of a cell that is passed whole
                o1, v1 = add(o1, 1.0, vector(out, o)), add(v1, 1.0, vector(out, o + 3))
            put(o1, out, o)
            put(v1, out, o + 3)
        t = add(t, 1.0, mapped(x, y, z, vector(H, 9)))
        X, Y, Z = (H[0], H[3], H[6]), (H[1], H[4], H[7]), (H[2], H[5], H[8])
        x, y, z = mapped(x, y, z, X), mapped(x, y, z, Y), mapped(x, y, z, Z)
    put(add(t, 1.0, mapped(x, y, z, vector(S.bases[j], 0))), out, 9)
    for column in range(3):
        out[column], out[3 + column], out[6 + column] = mapped(x, y, z, vector(S.axes[j, column], 0))


@_jit
def neighbour(S: System, strains: Array, i: int, j: int, k: int, out: Array) -> None:
    """Write scale j, k cells further than scale i, in the axes of i: rotation, translation, and their rates.

    Each scale is in the middle of its cell, and all cells have the same strains.
    """
    A, o = S.axes[i], vector(S.bases[i], 0)
    over_cell(S, strains, i, k, S.axes[j], vector(S.bases[j], 0), out)
    for column in range(3):
        v = rowwise(A, (out[column], out[3 + column], out[6 + column]))
        out[column], out[3 + column], out[6 + column] = v
    put(rowwise(A, add(vector(out, 9), -1.0, o)), out, 9)
    for rate in range(PLACED, PLACED + RATES, 6):
        o1, v1 = vector(out, rate), vector(out, rate + 3)
        put(rowwise(A, o1), out, rate)
        put(rowwise(A, add(v1, 1.0, cross(o1, o))), out, rate + 3)


@_jit
def neighbours(S: System, q: Array, strains: Array, fixed: Array, halves: Array, pairs: Array) -> None:
    """Write the neighbours (N, reach, 12 + 24 cells between, + 12 with tilts) that each scale may touch.

    ``fixed``: axes (3, 3) of a section; ``halves`` (N, 51), or (0, 51) where all cells have the same strains: room for
    the ways over half of each cell, and the tilts of scales.
    """
    N, none = len(S.shapes), 0.0 * strains[0, 0]
    for i in range(len(halves)):
        over_cell(S, strains, i, 0.5, fixed, (none, none, none), halves[i])
        tilted(S, i, q[i, TILT], halves[i, PLACED + RATES :])
    for i in range(N):
        for k in range(1, S.reach + 1):
            j = further(S, i, k)
            if j < N and S.own and not S.periodic:
                chain(S, q, halves, i, j, pieces(S, k), pairs[i, k - 1])
            elif j < N:
                neighbour(S, strains, i, j, k, pairs[i, k - 1])


@_jit
def attitudes(q: Array, E: Array) -> None:
    """Write rotation matrices, row by row, and displacements (N, 12) of scales from their motions (N, 6)."""
    for i in range(len(q)):
        e = turned(vector(q[i], 3))
        one = (1.0 + 0.0 * q[i, 0], 0.0 * q[i, 0], 0.0 * q[i, 0])
        x, y, z = rotated(e, one), rotated(e, (one[1], one[0], one[1])), rotated(e, (one[1], one[1], one[0]))
        for r in range(3):
            E[i, 3 * r], E[i, 3 * r + 1], E[i, 3 * r + 2] = x[r], y[r], z[r]
            E[i, 9 + r] = q[i, r]


@_in
def normal(R: Array) -> Vector:
    """Return the third column of a rotation matrix: the normal of a scale."""
    return R[2], R[5], R[8]


@_jit
def lift(S: System, i: int, b: Array, x: float, y: float) -> tuple[float, float, float]:
    """Return the deflection (24 coefficients) at a place of scale i, and its slopes along x and y."""
    X, Y = x / S.shapes[i, ETA], y / S.shapes[i, BETA]
    w, wx, wy = 0.0 * X, 0.0 * X, 0.0 * X
    for m in range(5, -1, -1):
        o = 4 * m
        row = b[o] + Y * (b[o + 1] + Y * (b[o + 2] + Y * b[o + 3]))
        wx = wx * X + w
        w = w * X + row
        wy = wy * X + b[o + 1] + Y * (2 * b[o + 2] + 3 * Y * b[o + 3])
    return w * X * X, (wx * X + 2 * w) * X / S.shapes[i, ETA], wy * X * X / S.shapes[i, BETA]


@_jit
def lifted_by(S: System, i: int, b: Array, x: float, y: float) -> float:
    """Return the deflection of :func:`lift` alone."""
    X, Y = x / S.shapes[i, ETA], y / S.shapes[i, BETA]
    w: float = 0.0 * x
    for m in range(5, -1, -1):
        o = 4 * m
        w = w * X + b[o] + Y * (b[o + 1] + Y * (b[o + 2] + Y * b[o + 3]))
    w *= X * X
    return w


@_jit
def bow(S: System, i: int, b: Array, x: float, y: float) -> tuple[float, float, float]:
    """Return the curvatures w_xx, w_xy, w_yy of a deflection."""
    eta, beta = S.shapes[i, ETA], S.shapes[i, BETA]
    X, Y = x / eta, y / beta
    xx, xy, yy, p = 0.0 * X, 0.0 * X, 0.0 * X, 1.0 + 0.0 * X
    for m in range(6):
        o = 4 * m
        xx += (m + 2) * (m + 1) * p * (b[o] + Y * (b[o + 1] + Y * (b[o + 2] + Y * b[o + 3])))
        xy += (m + 2) * p * X * (b[o + 1] + Y * (2 * b[o + 2] + 3 * Y * b[o + 3]))
        yy += p * X * X * (2 * b[o + 2] + 6 * Y * b[o + 3])
        p *= X
    return xx / (eta * eta), xy / (eta * beta), yy / (beta * beta)


@_jit
def powers(S: System, i: int, x: float, y: float, out: Array) -> None:
    """Write the powers X^m Y^n (3, 24) at a place of scale i: values, and slopes along x and y."""
    eta, beta = S.shapes[i, ETA], S.shapes[i, BETA]
    X, Y = x / eta, y / beta
    p = X
    for m in range(6):
        v, dv = 1.0 + 0.0 * X, 0.0 * X
        for n in range(4):
            o = 4 * m + n
            out[0, o] = p * X * v
            out[1, o] = (m + 2) * p * v / eta
            out[2, o] = p * X * dv / beta
            dv = (n + 1) * v
            v *= Y
        p *= X


@_jit
def press(S: System, i: int, x: float, y: float, force: float, load: Array) -> None:
    """Add the load (24,) on each power by a force along the normal at a place of scale i."""
    X, Y = x / S.shapes[i, ETA], y / S.shapes[i, BETA]
    a = force * X * X
    for m in range(6):
        o = 4 * m
        load[o] += a
        load[o + 1] += a * Y
        load[o + 2] += a * Y * Y
        load[o + 3] += a * Y * Y * Y
        a *= X


@_in
def beside(E: Array, x: float, y: float, z: float) -> Vector:
    """Return a place of a displaced scale from its attitude (12,), relative to its base midpoint at rest."""
    r = turn(E, (x, y, z))
    return r[0] + E[9], r[1] + E[10], r[2] + E[11]

"""Places where overlapping plates would touch: vertices of the overlap and their gaps; compiled.

The lower sheet of a scale lies over the upper sheet of its neighbour. Seen along the neighbour's normal they overlap in
a polygon. Between rigid plates the gap is linear over it, so the least one is at a vertex: a corner of the one over the
other, or a crossing of two edges. A bent edge may come nearest between its ends as well.
"""

from __future__ import annotations

import math

import numpy as np

from squama.batch.keeping import part as _jit
from squama.contacts import touch
from squama.contacts.geometry import back, lift, lifted_by, turn
from squama.contacts.meeting import Work
from squama.contacts.system import (
    BETA,
    ELASTIC,
    ETA,
    H,
    State,
    System,
    corner,
    further,
    high,
    low,
    on_edge,
    partner,
    spots,
)
from squama.contacts.touch import corner_at, lengthwise
from squama.contacts.vectors import Vector, add
from squama.types import Array

_DIP = 1e-3
"""Depth, in pitches, by which the gap along a bent edge may be lower between two samples."""
ALONG, ACROSS = 16, 8
"""Number of samples along a bent edge in the direction of the length, and of the width."""
WINDOW = 0.03
"""Share of a plate within which a vertex beside an edge along a face counts as that contact, at first."""
_PARALLEL, _SAME, _REFINED = 1e-9, 1e-5, 6
_BERNSTEIN = np.array([[math.comb(r, m) / math.comb(7, m) for m in range(2, 8)] for r in range(8)])
"""Coefficients of the powers X^2 .. X^7 in Bernstein's polynomials of degree 7."""


@_jit
def view(W: Work, i: int, j: int, k: int, other: bool, out: Array) -> None:
    """Write the origin and axes (12,) of scale i in the axes of j, or with ``other`` of j in those of i."""
    P, E1, E2 = W.pairs[i, k - 1], W.E[i], W.E[j]
    x, y, z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
    if other:
        o = add(add(turn(P, (E2[9], E2[10], E2[11])), 1.0, (P[9], P[10], P[11])), -1.0, (E1[9], E1[10], E1[11]))
        o = back(E1, o)
        x, y, z = back(E1, turn(P, turn(E2, x))), back(E1, turn(P, turn(E2, y))), back(E1, turn(P, turn(E2, z)))
    else:
        o = back(P, (E1[9] - P[9], E1[10] - P[10], E1[11] - P[11]))
        o = back(E2, (o[0] - E2[9], o[1] - E2[10], o[2] - E2[11]))
        x, y, z = back(E2, back(P, turn(E1, x))), back(E2, back(P, turn(E1, y))), back(E2, back(P, turn(E1, z)))
    for a in range(3):
        out[a], out[3 + a], out[6 + a], out[9 + a] = o[a], x[a], y[a], z[a]


@_jit
def seen(v: Array, x: float, y: float, z: float) -> Vector:
    """Return a place (x, y, z) of a scale in the other scale's axes."""
    X, Y = v[0] + v[3] * x + v[6] * y + v[9] * z, v[1] + v[4] * x + v[7] * y + v[10] * z
    return X, Y, v[2] + v[5] * x + v[8] * y + v[11] * z


@_jit
def height(S: System, i: int, b: Array, x: float, y: float) -> float:
    """Return the deflection of scale i at a place, 0 for a rigid scale."""
    return lifted_by(S, i, b, x, y) if S.shapes[i, ELASTIC].real > 0 else 0.0 * x


@_jit
def over(S: System, st: State, v: Array, own: int, other: int, upper: bool, x: float, y: float) -> tuple[Vector, float]:
    """Return a place of a sheet in the other scale's axes, and its gap there.

    ``upper``: the upper sheet, below the other scale's lower sheet; else the lower sheet, over its upper one.
    """
    half = S.shapes[own, H] / 2 if upper else -S.shapes[own, H] / 2
    p = seen(v, x, y, height(S, own, st.b[own], x, y) + half)
    face = height(S, other, st.b[other], p[0], p[1]) + (-1.0 if upper else 1.0) * S.shapes[other, H] / 2
    return p, face - p[2] if upper else p[2] - face


@_jit
def covers(S: System, i: int, x: float, y: float) -> bool:
    """Return whether a place lies on scale i."""
    return bool(0.0 <= x.real <= S.shapes[i, ETA].real and abs(y.real) <= S.shapes[i, BETA].real)


@_jit
def noted(
    out: Array, n: int, pair: tuple[int, int], kind: int, one: int, other: int, gap: float, a: float, b: float, c: float
) -> int:
    """Write a vertex of a pair (scale, cells to the other) as a row: kind, features, gap, places; return n + 1."""
    v = out[n]
    v[touch.FIRST], v[touch.APART], v[touch.KIND], v[touch.ONE], v[touch.OTHER] = pair[0], pair[1], kind, one, other
    v[touch.GAP], v[touch.AT], v[touch.AT + 1], v[touch.AT + 2] = gap, a, b, c
    return n + 1


@_jit
def across(edge: int) -> int:
    """Return the index of the coordinate that is constant along an edge: 0 for x, 1 for y."""
    return 1 if lengthwise(edge) else 0


@_jit
def bound(S: System, i: int, edge: int) -> float:
    """Return the coordinate that is constant along an edge of scale i."""
    x, y = on_edge(S, i, edge, 0.0 * S.shapes[i, ETA])
    return y if lengthwise(edge) else x


@_jit
def crossing(
    S: System, st: State, v: Array, i: int, j: int, e: int, f: int, start: float
) -> tuple[float, float, float]:
    """Return the places where edge e of scale i crosses edge f of scale j, and the gap, by iteration from ``start``."""
    a, axis, goal = start, across(f), bound(S, j, f)
    rate = v[3 + axis] if lengthwise(e) else v[6 + axis]
    p, gap = (0.0 * a, 0.0 * a, 0.0 * a), 0.0 * a
    for _ in range(4 if S.shapes[i, ELASTIC].real > 0 else 1):
        x, y = on_edge(S, i, e, a)
        p, gap = over(S, st, v, i, j, False, x, y)
        a += (goal - p[axis]) / rate
    x, y = on_edge(S, i, e, a)
    p, gap = over(S, st, v, i, j, False, x, y)
    return a, p[0] if axis == 1 else p[1], gap


@_jit
def dip(
    S: System, st: State, v: Array, own: int, other: int, upper: bool, e: int, a: float
) -> tuple[float, float, float, float, bool]:
    """Return the gap's slope along an edge at a place, the place (x, y) on the face, the gap, whether it is over it."""
    x, y = on_edge(S, own, e, a)
    half, faced = S.shapes[own, H] / 2, S.shapes[other, H] / 2
    lifted, wx, wy = lift(S, own, st.b[own], x, y)
    p = seen(v, x, y, lifted + half if upper else lifted - half)
    face, fx, fy = lift(S, other, st.b[other], p[0], p[1])
    gap = face - faced - p[2] if upper else p[2] - face - faced
    o, w = (3, wx) if lengthwise(e) else (6, wy)
    rise = v[o + 2] + w * v[11] - fx * (v[o] + w * v[9]) - fy * (v[o + 1] + w * v[10])
    return -rise if upper else rise, p[0], p[1], gap, covers(S, other, p[0], p[1])


@_jit
def span(S: System, i: int, b: Array) -> tuple[float, float]:
    """Return tight bounds of the deflection of scale i: the extreme coefficients of Bernstein's polynomials."""
    least, most = 0.0, 0.0
    if not S.shapes[i, ELASTIC] > 0:
        return least, most
    for r in range(2, 8):
        c0, c1, c2, c3 = 0.0, 0.0, 0.0, 0.0
        for m in range(r - 1):
            t, o = _BERNSTEIN[r, m], 4 * m
            c0, c1, c2, c3 = c0 + t * b[o], c1 + t * b[o + 1], c2 + t * b[o + 2], c3 + t * b[o + 3]
        even, odd = c0 + c2, c1 + c3
        inner, tilt = c0 - c2 / 3, c1 / 3 - c3
        least = min(least, even - abs(odd), inner - abs(tilt))
        most = max(most, even + abs(odd), inner + abs(tilt))
    return least, most


@_jit
def clear(S: System, v: Array, i: int, j: int, bent1: float, bent2: float) -> float:
    """Return a lower bound of scale i's gap over the whole face of j, for deflections up to ``bent1``, ``bent2``."""
    half, det = S.shapes[i, H] / 2, v[3] * v[7] - v[4] * v[6]
    if abs(det) < 0.05:
        return -1.0
    o, h = (v[0] - half * v[9], v[1] - half * v[10], v[2] - half * v[11]), S.shapes[j, H] / 2
    # height of the plane of i over that of j, along x and y of j
    by_x, by_y = (v[5] * v[7] - v[8] * v[4]) / det, (v[8] * v[3] - v[5] * v[6]) / det
    base = o[2] - by_x * o[0] - by_y * o[1] - h
    least: float = base + min(0.0, by_x * S.shapes[j, ETA]) - abs(by_y) * S.shapes[j, BETA]
    least -= bent1 / abs(det) + bent2
    return least


@_jit
def vertices(S: System, st: State, W: Work, i: int, k: int, cap: float, out: Array, n: int) -> int:
    """Write all vertices of scale i and its neighbour k with a gap below ``cap``; return their number."""
    j, room = further(S, i, k), len(out)
    bent = S.shapes[i, ELASTIC] > 0
    v, u, corners = W.views[0], W.views[1], W.corners
    view(W, i, j, k, False, v)
    low1, high1 = span(S, i, st.b[i])
    low2, high2 = span(S, j, st.b[j])
    bent1, bent2 = max(-low1, high1), max(-low2, high2)
    if clear(S, v, i, j, bent1, bent2) > cap:
        return n
    view(W, i, j, k, True, u)
    for c in range(4):
        x, y = corner(S, i, c)
        p, gap = over(S, st, v, i, j, False, x, y)
        corners[c, 0], corners[c, 1], corners[c, 2] = p
        if covers(S, j, p[0], p[1]) and gap < cap and n < room:
            n = noted(out, n, (i, k), touch.VF, c, 0, gap, p[0], p[1], 0.0)
        x, y = corner(S, j, c)
        p, gap = over(S, st, u, j, i, True, x, y)
        if covers(S, i, p[0], p[1]) and gap < cap and n < room:
            n = noted(out, n, (i, k), touch.FV, 0, c, gap, p[0], p[1], 0.0)
    for e in range(4):
        first, last = corner_at(e, False), corner_at(e, True)
        for f in range(4):
            axis, goal = across(f), bound(S, j, f)
            way = corners[last, axis] - corners[first, axis]
            if abs(way) < _PARALLEL:
                continue
            t = (goal - corners[first, axis]) / way
            if not -0.05 < t < 1.05:
                continue
            a0, a1 = low(S, i, e), high(S, i, e)
            if bent:
                z = corners[first, 2] + t * (corners[last, 2] - corners[first, 2]) - S.shapes[j, H] / 2
                if z - bent1 * (1 + 1 / abs(v[11])) - bent2 > cap:
                    continue
                a, b, gap = crossing(S, st, v, i, j, e, f, a0 + t * (a1 - a0))
            else:
                a = a0 + t * (a1 - a0)
                b = corners[first, 1 - axis] + t * (corners[last, 1 - axis] - corners[first, 1 - axis])
                gap = corners[first, 2] + t * (corners[last, 2] - corners[first, 2]) - S.shapes[j, H] / 2
            if a0 <= a <= a1 and low(S, j, f) <= b <= high(S, j, f) and gap < cap and n < room:
                n = noted(out, n, (i, k), touch.EE, e, f, gap, a, b, 0.0)
    if not bent:
        return n
    for e in range(4):
        n = minima(S, st, v, i, j, False, e, bent1, high2, i, k, cap, out, n)
        n = minima(S, st, u, j, i, True, e, bent2, -low1, i, k, cap, out, n)
    return n


@_jit
def minima(
    S: System,
    st: State,
    s: Array,
    own: int,
    other: int,
    upper: bool,
    e: int,
    most: float,
    faced: float,
    i: int,
    k: int,
    cap: float,
    out: Array,
    n: int,
) -> int:
    """Write the local minima of the gap along an edge between its ends; return the number of vertices then.

    The edge is bent by ``most`` at most, the other scale towards it by ``faced``.
    """
    a0, a1 = low(S, own, e), high(S, own, e)
    half, side = S.shapes[own, H] / 2, -1.0 if upper else 1.0
    begin, stop = overhang(S, s, own, other, e, -side * half, most)
    if begin >= stop:
        return n
    many = ALONG if lengthwise(e) else ACROSS
    here, there = max(0, math.floor(begin * many)), min(many, math.ceil(stop * many))
    size, bound = (a1 - a0) / many, cap + _DIP + S.shapes[other, H] / 2 + faced
    for g in range(here + 1, there + 1):
        a = a0 + (a1 - a0) * g / many
        x, y = on_edge(S, own, e, a)
        # farther away than both scales can bend
        if side * (s[2] + s[5] * x + s[8] * y - side * half * s[11]) - most * abs(s[11]) > bound:
            continue
        if side * (s[2] + s[5] * x + s[8] * y + s[11] * (height(S, own, st.b[own], x, y) - side * half)) > bound:
            continue
        slope, x, y, gap, on = dip(S, st, s, own, other, upper, e, a)
        if not on or slope < 0.0 or gap >= cap + _DIP:
            continue
        before, x, y, _, inside = dip(S, st, s, own, other, upper, e, a - size)
        if not inside or before >= 0.0:
            continue
        # a minimum between two places: a root of the slope
        low_end, high_end, low_slope, high_slope = a - size, a, before, slope
        for _ in range(_REFINED):
            wide, rise = high_end - low_end, high_slope - low_slope
            a = low_end - low_slope * wide / rise
            slope, x, y, gap, on = dip(S, st, s, own, other, upper, e, a)
            if slope < 0.0:
                low_end, low_slope = a, slope
                high_slope /= 2
            else:
                high_end, high_slope = a, slope
                low_slope /= 2
            if abs(slope) < 1e-13:
                break
        if gap < cap and on and n < len(out):
            n = noted(out, n, (i, k), touch.FE if upper else touch.EF, e, e, gap, x, y, a)
    return n


@_jit
def gap_at(S: System, st: State, W: Work, row: Array) -> float:
    """Return the gap of a known vertex, real or with a complex step."""
    i, kind, one, other = int(row[touch.FIRST]), int(row[touch.KIND]), int(row[touch.ONE]), int(row[touch.OTHER])
    k, a, none = int(row[touch.APART]), row[touch.AT], 0.0 * S.shapes[int(row[touch.FIRST]), ETA]
    j, upper = further(S, i, k), kind in (touch.FV, touch.FE)
    v = W.views[0]
    view(W, i, j, k, upper, v)
    if kind == touch.EE:
        return crossing(S, st, v, i, j, one, other, a + none)[2]
    own, faced = (j, i) if upper else (i, j)
    if kind >= touch.EF:
        return dip(S, st, v, own, faced, upper, other if upper else one, row[touch.AT + 2] + none)[3]
    x, y = corner(S, own, other if upper else one)
    return over(S, st, v, own, faced, upper, x, y)[1]


@_jit
def overhang(S: System, s: Array, own: int, other: int, e: int, half: float, most: float) -> tuple[float, float]:
    """Return the range of shares of an edge that may lie over the other scale's face, for bending up to ``most``."""
    x, y = on_edge(S, own, e, low(S, own, e))
    p = seen(s, x, y, half)
    x, y = on_edge(S, own, e, high(S, own, e))
    q = seen(s, x, y, half)
    aside, along = most * abs(s[9]), most * abs(s[10])
    begin, stop = narrowed(-aside, S.shapes[other, ETA] + aside, p[0], q[0], 0.0, 1.0)
    return narrowed(-S.shapes[other, BETA] - along, S.shapes[other, BETA] + along, p[1], q[1], begin, stop)


@_jit
def narrowed(least: float, most: float, start: float, end: float, first: float, last: float) -> tuple[float, float]:
    """Return the range of shares narrowed to where a quantity, linear from start to end, is between two bounds."""
    if abs(end - start) > _PARALLEL:
        one, two = (least - start) / (end - start), (most - start) / (end - start)
        return max(first, min(one, two)), min(last, max(one, two))
    return (first, last) if least <= start <= most else (1.0, 0.0)


@_jit
def edges_of(kind: int, one: int, other: int, side: int) -> tuple[int, int]:
    """Return the edges of a scale (``side`` 0: the first scale) on which a contact lies; -1 for none."""
    feature = one if side == 0 else other
    if kind == touch.EE or (kind == touch.EF and side == 0) or (kind == touch.FE and side == 1):
        return feature, -1
    if (kind == touch.VF and side == 0) or (kind == touch.FV and side == 1):
        return (0 if feature < 2 else 3), (1 if feature % 2 == 0 else 2)
    return -1, -1


@_jit
def known(S: System, st: State, con: Array, m: int, row: Array, W: Work) -> bool:
    """Return whether a vertex is already a contact, or at the place of one; its row is written to ``W.vertex``."""
    c = W.vertex
    kind, one, other = int(row[touch.KIND]), int(row[touch.ONE]), int(row[touch.OTHER])
    for a in range(5):
        c[a] = int(row[a])
    x1, y1, x2, y2 = spots(S, c, row[touch.AT :])
    i, j = c[touch.FIRST], partner(S, c)
    for a in range(m):
        d = con[a]
        if d[touch.FIRST] != c[touch.FIRST] or d[touch.APART] != c[touch.APART] or d[touch.STUCK] == touch.LET_GO:
            continue
        k, o, t = d[touch.KIND], d[touch.ONE], d[touch.OTHER]
        if k == kind and o == one and t == other and k < touch.EF:
            return True
        X1, Y1, X2, Y2 = spots(S, d, st.s[a])
        near = W.window[0] if kind >= touch.EF or k >= touch.EF else _SAME
        here = abs(X1 - x1) < near * S.shapes[i, ETA] and abs(Y1 - y1) < 2 * near * S.shapes[i, BETA]
        if here and abs(X2 - x2) < near * S.shapes[j, ETA] and abs(Y2 - y2) < 2 * near * S.shapes[j, BETA]:
            return True
    return False


@_jit
def deepest_of(
    S: System, st: State, con: Array, m: int, W: Work, i: int, k: int, cap: float, out: Array, n: int
) -> tuple[int, int]:
    """Return the deepest new vertex of scale i and its neighbour k, and the row behind the written ones."""
    first, n, best = n, vertices(S, st, W, i, k, cap, out, n), -1
    for a in range(first, n):
        if not known(S, st, con, m, out[a], W) and (best < 0 or out[a, touch.GAP] < out[best, touch.GAP]):
            best = a
    return best, n


@_jit
def deepest(S: System, st: State, con: Array, m: int, W: Work, cap: float, near: Array, every: bool, out: Array) -> int:
    """Return the row of ``out`` with the least gap below ``cap`` that is no contact yet; -1 if there is none.

    ``near`` (N, reach) marks pairs that have such a vertex; all pairs are searched with ``every``, else only the marked
    ones.
    """
    n, N, best = 0, len(S.shapes), -1
    for i in range(N):
        for k in range(1, S.reach + 1):
            if further(S, i, k) < N and (every or near[i, k - 1] > 0):
                a, n = deepest_of(S, st, con, m, W, i, k, cap, out, n)
                if a >= 0:
                    near[i, k - 1] = 1
                    if best < 0 or out[a, touch.GAP] < out[best, touch.GAP]:
                        best = a
    return best

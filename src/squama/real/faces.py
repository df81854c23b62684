"""Edges of a scale that come to a neighbour's face, at their ends or between; compiled."""

from __future__ import annotations

import math

import numpy as np

from squama.real.contact import SHAPE, Design, Frame, _in, _jit, back, frame, high, lengthwise, low, place, powers, turn
from squama.real.vectors import Vector, add, mixed, rotated, scaled, turned
from squama.types import Array

_TOUCH = -1e-6
_ALONG, _ACROSS = 16, 8
"""Places that are looked at along the length and the width."""


@_in
def bulge(d: Design, b: Array, x: float, y: float) -> float:
    """Return the deflection at a place of the plate by its coefficients (24,)."""
    X, Y, w = x / d.eta, y / d.beta, 0.0
    for m in range(5, -1, -1):
        row = b[4 * m] + Y * (b[4 * m + 1] + Y * (b[4 * m + 2] + Y * b[4 * m + 3]))
        w = w * X + row
    return w * X * X


@_jit
def shape(d: Design, x: float, y: float, c1: float, c2: float, out: Array) -> None:
    """Write the coefficients (24,) of a plate's deflection under forces at places on its two edges."""
    out[:] = 0.0
    if d.elastic:
        g = np.empty(12)
        powers(d, d.first, x, g, 0)
        powers(d, d.second, y, g, 6)
        for i in range(24):
            for j in range(6):
                out[i] += d.table[SHAPE + i, j] * g[j] * c1 + d.table[SHAPE + i, 6 + j] * g[6 + j] * c2


@_in
def aside(d: Design, edge: int, half: float, most: float, o: Vector, ex: Vector, ey: Vector, ez: Vector) -> bool:
    """Say whether an edge, deflected by ``most`` at most, lies beside the other scale, from whose axes it is seen."""
    one, two = place(d, edge, low(d, edge), half), place(d, edge, high(d, edge), half)
    p = add(mixed(one[0], ex, one[1], ey, half, ez), 1.0, o)
    q = add(mixed(two[0], ex, two[1], ey, half, ez), 1.0, o)
    x, y = most * abs(ez[0]), most * abs(ez[1])
    along = max(p[0], q[0]) < -x or min(p[0], q[0]) > d.eta + x
    return along or max(p[1], q[1]) < -d.beta - y or min(p[1], q[1]) > d.beta + y


@_jit
def overlap(d: Design, f: Frame, stretch: float, q: Array, b: Array, p: Array, c: Array) -> tuple[float, int]:
    """Return how deep edges of a scale and of its neighbour lie in each other's face, and the deepest one's edge.

    ``f`` is the neighbour's, ``stretch`` that of the bar; ``q``, ``p`` begin with the motions (6,) of the scale and of
    the neighbour, ``b``, ``c`` are their deflections (24,).
    Places along the edges of the scale's lower face are looked at over the neighbour's upper face, and the edges of
    that (+ 4) under the scale's lower face. The edge is -1 where nothing touches.
    """
    deepest, edge_of = _TOUCH, -1
    u, v, step = (q[0], q[1], q[2]), (p[0], p[1], p[2]), scaled(1.0 + stretch, f.t)
    for upper in range(2):
        # a place X of the one scale in the axes of the other: origin + X_x ex + X_y ey + X_z ez
        home, away = add(v if upper else u, 1.0, f.o), add(u if upper else v, 1.0, f.o)
        own = p if upper else q
        other = q if upper else p
        e, inverse = turned((own[3], own[4], own[5])), turned((-other[3], -other[4], -other[5]))
        there = add(turn(f, home), 1.0, step) if upper else back(f, add(home, -1.0, step))
        o = rotated(inverse, add(there, -1.0, away))
        ex = rotated(e, (1.0, 0.0, 0.0))
        ey = rotated(e, (0.0, 1.0, 0.0))
        ez = rotated(e, (0.0, 0.0, 1.0))
        ex = rotated(inverse, turn(f, ex) if upper else back(f, ex))
        ey = rotated(inverse, turn(f, ey) if upper else back(f, ey))
        ez = rotated(inverse, turn(f, ez) if upper else back(f, ez))
        half = d.h / 2 if upper else -d.h / 2
        lifts, faces = (c, b) if upper else (b, c)
        most = np.abs(lifts).sum()
        for edge in range(4):
            if aside(d, edge, half, most, o, ex, ey, ez):
                continue
            n = _ALONG if lengthwise(edge) else _ACROSS
            for i in range(n + 1):
                at = place(d, edge, low(d, edge) + (high(d, edge) - low(d, edge)) * i / n, 0.0)
                lift = half + (bulge(d, lifts, at[0], at[1]) if d.elastic else 0.0)
                x = add(mixed(at[0], ex, at[1], ey, lift, ez), 1.0, o)
                if 0.0 < x[0] < d.eta and -d.beta < x[1] < d.beta:
                    face = half - x[2] + (bulge(d, faces, x[0], x[1]) if d.elastic else 0.0)
                    # the face of the other scale is its lower one where edges of upper faces are looked at
                    height = face - d.h if upper else -face - d.h
                    if height < deepest:
                        deepest, edge_of = height, edge + 4 * upper
    return (deepest, edge_of) if edge_of >= 0 else (0.0, -1)


@_jit
def others(d: Design, q: Array, phi: float, stretch: float, b: Array) -> tuple[float, int, int]:
    """Return how deep edges lie in a neighbour's face, the deepest one's edge and neighbour (:func:`overlap`)."""
    deepest, edge_of, k_of = 0.0, -1, 0
    for k in range(1, reach(d) + 1):
        deep, edge = overlap(d, frame(d, phi, k), stretch, q, b, q, b)
        if deep < deepest:
            deepest, edge_of, k_of = deep, edge, k
    return deepest, edge_of, k_of


@_in
def reach(d: Design) -> int:
    """Return the farthest neighbour that plates may meet."""
    return max(1, int(math.hypot(d.eta, 2 * d.beta)))

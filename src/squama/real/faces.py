"""Edges of a scale that come to a neighbour's face, at their ends or between; compiled."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from squama.model.elastic_plate import TIP
from squama.real.design import Design, Frame, _in, _jit, back, frame, turn
from squama.real.features import high, lengthwise, low, place, raised
from squama.contacts.vectors import Vector, add, mixed, rotated, scaled, turned
from squama.types import Array

_TOUCH, _FLAT = -1e-6, 1e-9
_ALONG, _ACROSS = 16, 8
"""Places that are looked at along the length and the width."""


class View(NamedTuple):
    """One scale in the axes of another: a place X of it is at o + X_x x + X_y y + X_z z there."""

    o: Vector
    x: Vector
    y: Vector
    z: Vector


@_in
def view(f: Frame, stretch: float, q: Array, p: Array, upper: int) -> View:
    """Return a scale as its neighbour sees it or, ``upper``, the neighbour as the scale sees it, by their motions."""
    u, v, step = (q[0], q[1], q[2]), (p[0], p[1], p[2]), scaled(1.0 + stretch, f.t)
    home, away = add(v if upper else u, 1.0, f.o), add(u if upper else v, 1.0, f.o)
    own = p if upper else q
    other = q if upper else p
    e, inverse = turned((own[3], own[4], own[5])), turned((-other[3], -other[4], -other[5]))
    there = add(turn(f, home), 1.0, step) if upper else back(f, add(home, -1.0, step))
    x, y, z = rotated(e, (1.0, 0.0, 0.0)), rotated(e, (0.0, 1.0, 0.0)), rotated(e, (0.0, 0.0, 1.0))
    x = rotated(inverse, turn(f, x) if upper else back(f, x))
    y = rotated(inverse, turn(f, y) if upper else back(f, y))
    z = rotated(inverse, turn(f, z) if upper else back(f, z))
    return View(rotated(inverse, add(there, -1.0, away)), x, y, z)


@_in
def spotted(d: Design, s: View, edge: int, along: float, lifts: Array, half: float) -> Vector:
    """Return where a place on an edge of a scale, deflected by ``lifts`` (24,), is in the other one's axes."""
    at = place(d, edge, along, 0.0)
    lift = half + (raised(d, lifts, 0, at[0], at[1])[0] if d.elastic else 0.0)
    return add(mixed(at[0], s.x, at[1], s.y, lift, s.z), 1.0, s.o)


@_in
def over(d: Design, x: Vector, faces: Array, upper: int) -> float:
    """Return the height of a place over the other scale's face or, ``upper``, below its lower one."""
    face = (d.h / 2 if upper else -d.h / 2) - x[2] + (raised(d, faces, 0, x[0], x[1])[0] if d.elastic else 0.0)
    return face - d.h if upper else -face - d.h


@_in
def inside(low: float, high: float, start: float, end: float, first: float, last: float) -> tuple[float, float]:
    """Narrow a range of shares, ``first`` to ``last``, to where what runs from start to end is between two bounds."""
    if abs(end - start) > _FLAT:
        one, two = (low - start) / (end - start), (high - start) / (end - start)
        return max(first, min(one, two)), min(last, max(one, two))
    # (what runs along a bound is on neither side of it)
    return (first, last) if low + _FLAT < start < high - _FLAT else (1.0, 0.0)


@_in
def crossing(d: Design, edge: int, half: float, most: float, s: View) -> tuple[float, float]:
    """Return between which shares of an edge, deflected by ``most`` at most, it may lie over the other scale's face.

    It is seen from that one's axes; the first share is above the last one where it lies beside it.
    """
    one, two = place(d, edge, low(d, edge), half), place(d, edge, high(d, edge), half)
    p = add(mixed(one[0], s.x, one[1], s.y, half, s.z), 1.0, s.o)
    q = add(mixed(two[0], s.x, two[1], s.y, half, s.z), 1.0, s.o)
    x, y = most * abs(s.z[0]), most * abs(s.z[1])
    first, last = inside(-x, d.eta + x, p[0], q[0], 0.0, 1.0)
    return inside(-d.beta - y, d.beta + y, p[1], q[1], first, last)


@_jit
def overlap(d: Design, f: Frame, stretch: float, q: Array, b: Array, p: Array, c: Array) -> tuple[float, int]:
    """Return how deep edges of a scale and of its neighbour lie in each other's face, and the deepest one's edge.

    ``f`` is the neighbour's, ``stretch`` that of the bar; ``q``, ``p`` begin with the motions (6,) of the scale and of
    the neighbour, ``b``, ``c`` are their deflections (24,).
    Places along the edges of the scale's lower face are looked at over the neighbour's upper face, and the edges of
    that (+ 4) under the scale's lower face; of plates that are not bent those where an edge comes over the face and
    goes, one of which is the deepest. The edge is -1 where nothing touches.
    """
    deepest, edge_of = _TOUCH, -1
    flat = np.abs(b).sum() + np.abs(c).sum() == 0.0
    for upper in range(2):
        s, half = view(f, stretch, q, p, upper), d.h / 2 if upper else -d.h / 2
        lifts, faces = (c, b) if upper else (b, c)
        most = np.abs(lifts).sum()
        for edge in range(4):
            first, last = crossing(d, edge, half, most, s)
            if first > last:
                continue
            n = _ALONG if lengthwise(edge) else _ACROSS
            here, there, way = math.ceil(n * first - _FLAT), math.floor(n * last + _FLAT), 1.0 / n
            if flat:
                here, there, way = 0, 1, last - first
            for i in range(here, there + 1):
                share = first + i * way if flat else i * way
                x = spotted(d, s, edge, low(d, edge) + (high(d, edge) - low(d, edge)) * share, lifts, half)
                if flat or (0.0 < x[0] < d.eta and -d.beta < x[1] < d.beta):
                    height = over(d, x, faces, upper)
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


@_jit
def tilt(d: Design, q: Array, phi: float, stretch: float, b: Array, x: float, y: float, along: float) -> float:
    """Return how a tip edge rises over the other scale's face from a place (x, y on it) on, by the length towards C.

    It touches at ``along``; ``q`` begins with the motions (6,), ``b`` (24,) is the deflection.
    """
    s = view(frame(d, phi, d.k), stretch, q, q, 0)
    slope, wx, wy = 0.0, 0.0, 0.0
    if d.elastic:
        _, _, slope = raised(d, b, 0, d.eta, along)
        _, wx, wy = raised(d, b, 0, x, y)
    return wx * (s.y[0] + slope * s.z[0]) + wy * (s.y[1] + slope * s.z[1]) - s.y[2] - slope * s.z[2]


@_jit
def tip_over(
    d: Design, q: Array, phi: float, stretch: float, b: Array, along: float, side: float
) -> tuple[float, float, float]:
    """Return a place of the tip edge over the other scale's face, and how far along the edge it is.

    It is that at ``along``, or where the edge comes to ``side`` of the face (its y), 0 for neither; as :func:`tilt`.
    """
    s = view(frame(d, phi, d.k), stretch, q, q, 0)
    x = spotted(d, s, TIP, along, b, -d.h / 2)
    for _ in range(3 if side != 0.0 else 0):
        along += (side - x[1]) / s.y[1]
        x = spotted(d, s, TIP, along, b, -d.h / 2)
    return x[0], x[1], along


@_in
def reach(d: Design) -> int:
    """Return the farthest neighbour that plates may meet."""
    return max(1, int(math.hypot(d.eta, 2 * d.beta)))

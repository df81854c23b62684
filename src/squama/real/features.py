"""What of two scales may meet: edges, corners and faces of elastic plates, their places and deflections; compiled.

The lower face of scale 1 lies on the upper face of scale 1 + k. Edges have the numbers of
:mod:`squama.model.elastic_plate`; beside them there are faces and corners. Two edges that cross have a place on each.
A corner, or the tip edge anywhere, on a face has two places on the face, along its length and across.
"""

from __future__ import annotations

from squama.model.elastic_plate import ACROSS, BASE, LENGTHWISE, SIDE_D, TIP
from squama.real.design import BEND, SHAPE, Design, _in, _jit
from squama.contacts.vectors import Vector
from squama.types import Array

FACE, CORNERS = 4, 5
"""Numbers of a face, and of the first of the corners C, B (tip), D, A (base)."""


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
def on_face(d: Design) -> bool:
    """Say whether something lies on a face, not an edge across an edge."""
    return FACE in (d.first, d.second)


@_in
def rolls(d: Design) -> bool:
    """Say whether it is the tip edge, which touches where it is tangent to the face."""
    return d.second == FACE and d.first == TIP


@_in
def spot(d: Design, feature: int, x: float, y: float, along: float) -> tuple[float, float]:
    """Return the place of a contact on a feature in its plate: x, y on a face, ``along`` the tip edge, or a corner."""
    if feature == FACE:
        return x, y
    if feature == TIP:
        return d.eta + 0.0 * x, along
    return (d.eta if feature < CORNERS + 2 else 0.0) + 0.0 * x, (d.beta if feature % 2 == 0 else -d.beta) + 0.0 * x


@_in
def spots(d: Design, x: float, y: float, along: float) -> tuple[float, float, float, float]:
    """Return the places of a contact in the plates of both scales, x and y each."""
    if on_face(d):
        one, two = spot(d, d.first, x, y, along), spot(d, d.second, x, y, along)
        return one[0], one[1], two[0], two[1]
    a, b = place(d, d.first, x, 0.0), place(d, d.second, y, 0.0)
    return a[0], a[1], b[0], b[1]


@_in
def raised(d: Design, b: Array, first: int, x: float, y: float) -> tuple[float, float, float]:
    """Return the deflection at a place of the plate by its coefficients (24,), from a column on, and its slopes."""
    X, Y, w, wx, wy = x / d.eta, y / d.beta, 0.0 * x, 0.0 * x, 0.0 * x
    for m in range(LENGTHWISE - 1, -1, -1):
        i = first + ACROSS * m
        row = b[i] + Y * (b[i + 1] + Y * (b[i + 2] + Y * b[i + 3]))
        wx = wx * X + w
        w = w * X + row
        wy = wy * X + b[i + 1] + Y * (2 * b[i + 2] + 3 * Y * b[i + 3])
    return w * X * X, (wx * X + 2 * w) * X / d.eta, wy * X * X / d.beta


@_in
def press(d: Design, x: float, y: float, c: float, out: Array) -> None:
    """Add to the load (24,) of a plate a force c at a place, by the powers X^m Y^n there."""
    X, Y = x / d.eta, y / d.beta
    along = c * X * X
    for m in range(LENGTHWISE):
        value = along
        for n in range(ACROSS):
            out[ACROSS * m + n] += value
            value *= Y
        along *= X


@_jit
def shape(
    d: Design, x: float, y: float, along: float, c1: float, c2: float, load: Array, out: Array, first: int
) -> None:
    """Write the coefficients (24,) of a plate's deflection under the forces of a contact, from a column on.

    ``load`` (24,) is room for their load.
    """
    n = LENGTHWISE * ACROSS
    out[first : first + n] = 0.0
    if d.elastic:
        x1, y1, x2, y2 = spots(d, x, y, along)
        load[:n] = 0.0
        press(d, x1, y1, c1, load)
        press(d, x2, y2, c2, load)
        for i in range(n):
            for j in range(n):
                out[first + i] += d.table[SHAPE + i, j] * load[j]


@_in
def power(edge: int, m: int, n: int) -> tuple[int, float]:
    """Return which power of the place X^m Y^n is along an edge (see :func:`powers`), and its factor there."""
    if edge == TIP:
        return n, 1.0
    if edge == BASE:
        return 0, 0.0
    return m, -1.0 if edge == SIDE_D and n % 2 else 1.0


@_jit
def compliances(d: Design) -> None:
    """Write those between the powers of the places on both edges that meet into the design's table."""
    table = d.table
    for i in range(12):
        for j in range(12):
            table[BEND + i, j] = 0.0
    for one in range(LENGTHWISE * ACROSS):
        for two in range(LENGTHWISE * ACROSS):
            for i in range(2):
                a, u = power(d.second if i else d.first, one // ACROSS, one % ACROSS)
                for j in range(2):
                    b, v = power(d.second if j else d.first, two // ACROSS, two % ACROSS)
                    table[BEND + 6 * i + a, 6 * j + b] += u * v * table[SHAPE + one, two]

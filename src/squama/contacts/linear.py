"""Linear equations of a row: a band, because only near scales touch, bordered by unknowns of all scales; compiled."""

from __future__ import annotations

from typing import NamedTuple

from squama.batch.keeping import inlined as _in
from squama.batch.keeping import part as _jit
from squama.contacts import touch
from squama.contacts.system import System, before_cell, cells, layout, transfer
from squama.types import Array

SOLVED, RESIDUALS, INNER, FILLED, FAR = range(5)
"""Entries of ``kept``: number of factored unknowns, 0 for none; number of residual evaluations; unknowns without the
border's; length of the band; largest number of cells between two scales in contact, at least 1.
"""
AT, LOW, HIGH = range(3)
"""Rows of ``rows``: position in the band of column 0 of each row, its first column, and the one behind its last."""


class Linear(NamedTuple):
    """A factored Jacobian: rows of its ``band`` one after another, right and lower border (B, n), corner (B, B).

    Columns are exchanged for pivots: ``order`` (n,); ``last`` (n,): end of what is not zero in each row. ``rows``
    (3, n) see above; ``r`` (n,) its residual; ``at`` (N + C + K,) first unknowns of scales, contacts and ties; ``kept``
    (5,) see above; ``noise`` (1,): size of corrections that were rounding, when it was last new.
    """

    band: Array
    right: Array
    lower: Array
    corner: Array
    order: Array
    last: Array
    rows: Array
    r: Array
    at: Array
    kept: Array
    noise: Array


@_jit
def laid_out(S: System, con: Array, m: int, J: Linear) -> int:
    """Arrange the unknowns; return their number, -1 if there is no room for them."""
    kept, rows, far, many, filled = J.kept, J.rows, 1, cells(S), 0
    for c in range(m):
        if con[c, touch.KIND] != touch.LIES:
            far = max(far, con[c, touch.APART])
    n, inner = layout(S, con, m, J.at)
    kept[FAR], kept[INNER] = far, inner
    if S.periodic and not S.own:
        far = many
    for i in range(many):
        # contacts reach so far, and exchanged columns once more to the left
        low, high = start(S, J, i - 2 * far), start(S, J, i + far + 1)
        for a in range(start(S, J, i), start(S, J, i + 1)):
            rows[AT, a], rows[LOW, a], rows[HIGH, a] = filled - low, low, high
            filled += high - low
    kept[FILLED] = filled
    return n if filled <= len(J.band) else -1


@_in
def start(S: System, J: Linear, i: int) -> int:
    """Return the first unknown of cell i; before the first cell 0, behind the last one the end of the band."""
    n: int = 0 if i <= 0 else before_cell(S, J.at, i) if i < cells(S) else J.kept[INNER]
    return n


@_jit
def emptied(J: Linear, n: int) -> None:
    """Set a Jacobian to zero."""
    for a in range(J.kept[FILLED]):
        J.band[a] = 0.0
    for e in range(n - J.kept[INNER]):
        for a in range(n):
            J.right[e, a] = J.lower[e, a] = 0.0
        for o in range(len(J.corner)):
            J.corner[e, o] = 0.0


@_in
def enter(J: Linear, a: int, b: int, x: float) -> None:
    """Add x to entry (a, b)."""
    inner = J.kept[INNER]
    if a < inner:
        if b < inner:
            J.band[J.rows[AT, a] + b] += x
        else:
            J.right[b - inner, a] += x
    elif b < inner:
        J.lower[a - inner, b] += x
    else:
        J.corner[a - inner, b - inner] += x


@_jit
def alone(J: Linear, a: int) -> None:
    """Replace row a by the equation that unknown a is zero."""
    o = J.rows[AT, a]
    for b in range(J.rows[LOW, a], J.rows[HIGH, a]):
        J.band[o + b] = 0.0
    for e in range(len(J.right)):
        J.right[e, a] = 0.0
    J.band[o + a] = 1.0


@_in
def grow(x: Array, f: float, y: Array) -> None:
    """Add a multiple of numbers to others: of parts of arrays the processor takes several at once."""
    for a in range(len(x)):
        x[a] += f * y[a]


@_in
def product(x: Array, y: Array) -> float:
    """Return the sum of products of numbers, in four parts that do not wait for each other."""
    a = b = c = d = 0.0
    whole = len(x) // 4 * 4
    for i in range(0, whole, 4):
        a += x[i] * y[i]
        b += x[i + 1] * y[i + 1]
        c += x[i + 2] * y[i + 2]
        d += x[i + 3] * y[i + 3]
    for i in range(whole, len(x)):
        a += x[i] * y[i]
    return a + b + (c + d)


@_jit
def factor(J: Linear, n: int) -> bool:
    """Factor a Jacobian in place, row by row with exchanges of columns, skipping zeros; False if it is singular."""
    A, order, last, inner, ats = J.band, J.order, J.last, J.kept[INNER], J.rows[AT]
    for a in range(inner):
        at, low = ats[a], J.rows[LOW, a]
        x = A[at + low : at + J.rows[HIGH, a]]
        for k in range(low, a):
            p, own = order[k] - low, k - low
            f = x[p]
            if p != own:
                x[p], x[own] = x[own], f
            if f != 0.0:
                o = ats[k]
                grow(x[own + 1 : last[k] - low], -f, A[o + k + 1 : o + last[k]])
        own, p, end = a - low, a - low, len(x)
        best = abs(x[own])
        for b in range(own + 1, end):
            if abs(x[b]) > best:
                best, p = abs(x[b]), b
        if not 0.0 < best < 1e300:
            return False
        x[p], x[own] = x[own], x[p]
        while x[end - 1] == 0.0:
            end -= 1
        over = 1 / x[own]
        for b in range(own + 1, end):
            x[b] *= over
        order[a], last[a] = p + low, end + low
    return cornered(J, n)


@_jit
def cornered(J: Linear, n: int) -> bool:
    """Factor the rest of the border beside a factored band; False if it is singular."""
    inner, corner = J.kept[INNER], J.corner
    free = n - inner
    for e in range(free):
        across(J, J.right[e])
        for o in range(free):
            corner[o, e] -= product(J.lower[o, :inner], J.right[e, :inner])
    for k in range(free):
        p = k
        for i in range(k + 1, free):
            if abs(corner[i, k]) > abs(corner[p, k]):
                p = i
        J.order[inner + k] = p
        if not abs(corner[p, k]) > 0.0:
            return False
        for o in range(free if p != k else 0):
            corner[k, o], corner[p, o] = corner[p, o], corner[k, o]
        for i in range(k + 1, free):
            f = corner[i, k] / corner[k, k]
            corner[i, k] = f
            grow(corner[i, k + 1 : free], -f, corner[k, k + 1 : free])
    return True


@_jit
def across(J: Linear, x: Array) -> None:
    """Solve with the factored band alone, in place."""
    A, inner = J.band, J.kept[INNER]
    for a in range(inner):
        o, low = J.rows[AT, a], J.rows[LOW, a]
        x[a] = (x[a] - product(A[o + low : o + a], x[low:a])) / A[o + a]
    for a in range(inner - 1, -1, -1):
        o, p, end = J.rows[AT, a], J.order[a], J.last[a]
        out = x[a] - product(A[o + a + 1 : o + end], x[a + 1 : end])
        x[a] = x[p]
        x[p] = out


@_jit
def substitute(J: Linear, n: int, x: Array) -> None:
    """Solve with a factored Jacobian in place."""
    across(J, x)
    inner = J.kept[INNER]
    free = n - inner
    for e in range(free):
        x[inner + e] -= product(J.lower[e, :inner], x[:inner])
    for e in range(free):
        p = inner + J.order[inner + e]
        x[inner + e], x[p] = x[p], x[inner + e]
    for e in range(free):
        for o in range(e):
            x[inner + e] -= J.corner[e, o] * x[inner + o]
    for e in range(free - 1, -1, -1):
        for o in range(e + 1, free):
            x[inner + e] -= J.corner[e, o] * x[inner + o]
        x[inner + e] /= J.corner[e, e]
    for e in range(free):
        grow(x[:inner], -x[inner + e], J.right[e, :inner])


@_jit
def stored(J: Linear, n: int) -> int:
    """Return the number of values in the factors of n unknowns."""
    wide = len(J.corner)
    filled: int = J.kept[FILLED]
    return filled + 2 * n + 2 * wide * n + wide * wide


@_jit
def exchanged(J: Linear, n: int, a: Array, at: int, out: bool) -> None:
    """Copy the factors to an array from index ``at`` on, or from there if not ``out``."""
    at = transfer(J.band[: J.kept[FILLED]], a, at, out)
    for e in range(len(J.corner)):
        at = transfer(J.right[e, :n], a, at, out)
        at = transfer(J.lower[e, :n], a, at, out)
        at = transfer(J.corner[e], a, at, out)
    at = transfer(J.order[:n], a, at, out)
    transfer(J.last[:n], a, at, out)

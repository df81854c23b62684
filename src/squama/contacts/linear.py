"""Linear equations of a row: a band, because only near scales touch, bordered by unknowns of all scales; compiled."""

from __future__ import annotations

from typing import NamedTuple

from squama.batch.keeping import inlined as _in
from squama.batch.keeping import part as _jit
from squama.contacts import touch
from squama.contacts.system import System, before_cell, borders, cells, layout, transfer
from squama.types import Array

SOLVED, RESIDUALS, INNER, HALF, STRIDE, BASE, FAR = range(7)
"""Entries of ``kept``: number of factored unknowns, 0 for none; number of residual evaluations; unknowns without the
border's; half the band's width; position of entry (a, b) in the band, BASE + a STRIDE + b; largest number of cells
between two scales in contact, at least 1.
"""


class Linear(NamedTuple):
    """A factored Jacobian: its ``band``, all in one row, right border (n, B), lower border (B, n), corner (B, B).

    ``under``: factors of the rows below each pivot, column by column. ``order`` and ``last`` (n,): row exchanges, last
    column of each row that is not zero; ``r`` (n,) its residual; ``at`` (N + C,) first unknowns of scales and contacts;
    ``kept`` (7,) see above.
    """

    band: Array
    under: Array
    right: Array
    lower: Array
    corner: Array
    order: Array
    last: Array
    r: Array
    at: Array
    kept: Array


@_jit
def laid_out(S: System, con: Array, m: int, J: Linear) -> int:
    """Arrange the unknowns; return their number, -1 if there is no room for them."""
    kept, far = J.kept, 1
    for c in range(m):
        if con[c, touch.KIND] != touch.LIES:
            far = max(far, con[c, touch.APART])
    kept[FAR] = far
    n = layout(S, con, m, J.at)
    inner = n - borders(S)
    half = inner - 1
    if not S.periodic:
        half = 0
        for i in range(cells(S)):
            end = before_cell(S, J.at, i + far + 1) if i + far + 1 < cells(S) else inner
            half = max(half, end - before_cell(S, J.at, i) - 1)
    narrow = 3 * half + 1 < inner
    kept[INNER], kept[HALF] = inner, half
    kept[STRIDE], kept[BASE] = (3 * half, half) if narrow else (inner, 0)
    return n if filled(J) <= len(J.band) and inner * half <= len(J.under) else -1


@_in
def filled(J: Linear) -> int:
    """Return the number of entries in the band."""
    kept = J.kept
    n: int = kept[BASE] + (kept[INNER] - 1) * (kept[STRIDE] + 1) + 1
    return n


@_jit
def emptied(J: Linear, n: int) -> None:
    """Set a Jacobian to zero."""
    for a in range(filled(J)):
        J.band[a] = 0.0
    for e in range(n - J.kept[INNER]):
        for a in range(n):
            J.right[a, e] = J.lower[e, a] = 0.0
        for o in range(len(J.corner)):
            J.corner[e, o] = 0.0


@_in
def enter(J: Linear, a: int, b: int, x: float) -> None:
    """Add x to entry (a, b)."""
    inner = J.kept[INNER]
    if a < inner:
        if b < inner:
            J.band[J.kept[BASE] + a * J.kept[STRIDE] + b] += x
        else:
            J.right[a, b - inner] += x
    elif b < inner:
        J.lower[a - inner, b] += x
    else:
        J.corner[a - inner, b - inner] += x


@_jit
def alone(J: Linear, a: int) -> None:
    """Replace row a by the equation that unknown a is zero."""
    half, inner, o = J.kept[HALF], J.kept[INNER], J.kept[BASE] + a * J.kept[STRIDE]
    for b in range(max(0, a - half), min(inner, a + half + 1)):
        J.band[o + b] = 0.0
    for e in range(J.right.shape[1]):
        J.right[a, e] = 0.0
    J.band[o + a] = 1.0


@_in
def grow(x: Array, f: float, y: Array) -> None:
    """Add a multiple of numbers to others: of parts of arrays the processor takes several at once."""
    for a in range(len(x)):
        x[a] += f * y[a]


@_in
def swapped(x: Array, y: Array) -> None:
    """Exchange numbers."""
    for a in range(len(x)):
        x[a], y[a] = y[a], x[a]


@_jit
def factor(J: Linear, n: int) -> bool:
    """Factor a Jacobian in place with row exchanges, skipping zeros; False if it is singular."""
    A, inner, half, s, base = J.band, J.kept[INNER], J.kept[HALF], J.kept[STRIDE], J.kept[BASE]
    right, under = J.right[:, : n - inner], J.under
    for k in range(inner):
        o = base + k * s
        best, p, below = abs(A[o + k]), k, min(inner, k + half + 1)
        for i in range(k + 1, below):
            if abs(A[base + i * s + k]) > best:
                best, p = abs(A[base + i * s + k]), i
        if not 0.0 < best < 1e300:
            return False
        J.order[k] = p
        last = min(inner - 1, k + 2 * half)
        if p != k:
            q = base + p * s
            swapped(A[o + k : o + last + 1], A[q + k : q + last + 1])
            swapped(right[k], right[p])
        while A[o + last] == 0.0:
            last -= 1
        J.last[k] = last
        over, own = 1 / A[o + k], A[o + k + 1 : o + last + 1]
        for i in range(k + 1, below):
            q = base + i * s
            f = A[q + k] * over
            under[k * half + i - k - 1] = f
            if f != 0.0:
                grow(A[q + k + 1 : q + last + 1], -f, own)
                grow(right[i], -f, right[k])
    return cornered(J, n)


@_jit
def cornered(J: Linear, n: int) -> bool:
    """Factor the rest of the border beside a factored band; False if it is singular."""
    A, inner, s, base = J.band, J.kept[INNER], J.kept[STRIDE], J.kept[BASE]
    free = n - inner
    right, corner = J.right[:, :free], J.corner[:, :free]
    for i in range(inner - 1 if free > 0 else -1, -1, -1):
        o = base + i * s
        for j in range(i + 1, J.last[i] + 1):
            if A[o + j] != 0.0:
                grow(right[i], -A[o + j], right[j])
        for e in range(free):
            right[i, e] /= A[o + i]
    for e in range(free):
        for a in range(inner):
            grow(corner[e], -J.lower[e, a], right[a])
    for k in range(free):
        p = k
        for i in range(k + 1, free):
            if abs(corner[i, k]) > abs(corner[p, k]):
                p = i
        J.order[inner + k] = p
        if not abs(corner[p, k]) > 0.0:
            return False
        if p != k:
            swapped(corner[k], corner[p])
        for i in range(k + 1, free):
            f = corner[i, k] / corner[k, k]
            corner[i, k] = f
            grow(corner[i, k + 1 :], -f, corner[k, k + 1 :])
    return True


@_jit
def across(J: Linear, x: Array) -> None:
    """Solve with the factored band alone, in place."""
    A, inner, half, s, base = J.band, J.kept[INNER], J.kept[HALF], J.kept[STRIDE], J.kept[BASE]
    for k in range(inner):
        p = J.order[k]
        if p != k:
            x[k], x[p] = x[p], x[k]
        below = min(inner, k + half + 1)
        if x[k] != 0.0:
            grow(x[k + 1 : below], -x[k], J.under[k * half : k * half + below - k - 1])
    for i in range(inner - 1, -1, -1):
        o, out = base + i * s, x[i]
        for j in range(i + 1, J.last[i] + 1):
            out -= A[o + j] * x[j]
        x[i] = out / A[o + i]


@_jit
def substitute(J: Linear, n: int, x: Array) -> None:
    """Solve with a factored Jacobian in place."""
    across(J, x)
    inner = J.kept[INNER]
    free = n - inner
    for e in range(free):
        for a in range(inner):
            x[inner + e] -= J.lower[e, a] * x[a]
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
        for a in range(inner):
            x[a] -= J.right[a, e] * x[inner + e]


@_jit
def stored(J: Linear, n: int) -> int:
    """Return the number of values in the factors of n unknowns."""
    wide = len(J.corner)
    below: int = J.kept[INNER] * J.kept[HALF]
    return filled(J) + below + 2 * n + 2 * wide * n + wide * wide


@_jit
def exchanged(J: Linear, n: int, a: Array, at: int, out: bool) -> None:
    """Copy the factors to an array from index ``at`` on, or from there if not ``out``."""
    wide = len(J.corner)
    at = transfer(J.band[: filled(J)], a, at, out)
    at = transfer(J.under[: J.kept[INNER] * J.kept[HALF]], a, at, out)
    at = transfer(J.right[:n], a, at, out)
    for e in range(wide):
        at = transfer(J.lower[e, :n], a, at, out)
        at = transfer(J.corner[e], a, at, out)
    at = transfer(J.order[:n], a, at, out)
    transfer(J.last[:n], a, at, out)

"""Which edges and triangles of two scales are looked at for contact.

Boxes of the edges, triangles and points are compared in the frame of the first scale, where its box is flat, so that
few of the second one's are left.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from squama.fe.exposed import Exposed, Index
from squama.types import Array


class Near(NamedTuple):
    """Pairs that are looked at, by their numbers among all scales: (n, 2) edge and edge, (m, 2) triangle and point."""

    edges: Index
    faces: Index


def every(exposed: Exposed, i: int, j: int) -> Near:
    """Return all pairs of rigid scales i and j: edges of the plates, and triangles with points."""
    n, m, q = len(exposed.points), len(exposed.edges), len(exposed.faces)
    outer, faces, points = exposed.outer, np.arange(q), np.arange(n)
    both = [(faces + q * a, points + n * b) for a, b in ((i, j), (j, i))]
    return Near(_product(outer + m * i, outer + m * j), np.concatenate([_product(*pair) for pair in both]))


def _product(a: Index, b: Index) -> Index:
    return np.column_stack([np.repeat(a, b.size), np.tile(b, a.size)])


class _Boxes(NamedTuple):
    """Boxes by their corners, (3, n) each."""

    low: Array
    high: Array

    def meet(self, other: _Boxes) -> Index:
        """Return the numbers of those that meet the one box around all of the others."""
        low, high = other.low.min(axis=1, keepdims=True), other.high.max(axis=1, keepdims=True)
        x, y, z = (self.low <= high) & (self.high >= low)
        return np.flatnonzero(x & y & z)

    def around(self, cells: Index) -> _Boxes:
        """Return the boxes around boxes of points, by the cells' points (n, k)."""
        first, *more = cells.T
        low, high = self.low[:, first], self.high[:, first]
        for at in more:
            low, high = np.minimum(low, self.low[:, at]), np.maximum(high, self.high[:, at])
        return _Boxes(low, high)


def within_reach(exposed: Exposed, i: int, j: int, V: Array, there: Array, within: float) -> Near:
    """Return the pairs of scales i and j whose boxes come as near as ``within`` on a straight way.

    Parameters
    ----------
    V, there : (n, 3) arrays
        Points of all scales at the start and the end.
    within : float
        Distance.
    """
    n, m, q = len(exposed.points), len(exposed.edges), len(exposed.faces)
    frame = _frame(V[n * i : n * i + n])
    one, two = (_swept(V, there, slice(n * k, n * k + n), frame, wide) for k, wide in ((i, within), (j, 0.0)))
    edges = _pairs(one.around(exposed.edges), two.around(exposed.edges))
    faces, points = _pairs(one.around(exposed.faces), two), _pairs(one, two.around(exposed.faces))[:, ::-1]
    both = faces + np.array([q * i, n * j]), points + np.array([q * j, n * i])
    return Near(edges + np.array([m * i, m * j]), np.concatenate(both))


def _swept(V: Array, there: Array, part: slice, frame: Array, wide: float) -> _Boxes:
    x, y = frame.T @ V[part].T, frame.T @ there[part].T
    return _Boxes(np.minimum(x, y) - wide, np.maximum(x, y) + wide)


def _frame(x: Array) -> Array:
    """Return orthonormal axes (columns) along which the box of points of a plate is small."""
    y = x - x.mean(axis=0)
    return np.asarray(np.linalg.eigh(y.T @ y)[1])


def _pairs(one: _Boxes, two: _Boxes) -> Index:
    """Return the pairs (n, 2) of boxes that meet."""
    b = two.meet(one)
    if not b.size:
        return np.empty((0, 2), np.int64)
    a = one.meet(_Boxes(two.low[:, b], two.high[:, b]))
    x, y, z = (one.low[:, a, None] <= two.high[:, None, b]) & (one.high[:, a, None] >= two.low[:, None, b])
    at = np.argwhere(x & y & z)
    return np.column_stack([a[at[:, 0]], b[at[:, 1]]])

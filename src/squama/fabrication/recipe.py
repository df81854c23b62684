"""How a solid is made: one block with plane faces, less other blocks; and its volume in closed form.

A block is an array (8, 3) of corners in mm: corner 4 i + 2 j + k has the first, second and third coordinate low (0) or
high (1). The coordinate system of the blocks is right-handed.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

QUADS = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
"""Corners of a block's six faces, counterclockwise seen from outside."""
BENCH = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
"""From the beam's x, y, z (across, out of the scaled face, along) to along, across, up."""


class Recipe(NamedTuple):
    """A solid: ``name``, the block ``whole``, the blocks ``cuts`` taken from it, ``volume`` in mm^3 in closed form."""

    name: str
    whole: Array
    cuts: tuple[Array, ...]
    volume: float

    def moved(self, turn: Array, shift: ArrayLike = (0.0, 0.0, 0.0)) -> Recipe:
        """Return the solid turned by a rotation matrix, then moved."""
        whole, *cuts = (block @ turn.T + np.asarray(shift) for block in (self.whole, *self.cuts))
        return self._replace(whole=whole, cuts=tuple(cuts))


def block(low: ArrayLike, high: ArrayLike, axes: Array | None = None, origin: ArrayLike = (0.0, 0.0, 0.0)) -> Array:
    """Return a box between two corners given in ``axes`` (rows) from ``origin``."""
    lo, hi = np.asarray(low, float), np.asarray(high, float)
    bits = (np.arange(8)[:, None] >> np.array([2, 1, 0])) & 1
    corners = np.where(bits == 1, hi, lo)
    return np.asarray(corners @ (np.eye(3) if axes is None else axes) + np.asarray(origin, float))


def tapered(x: Sequence[Sequence[float]], y: Sequence[float], z: Sequence[Sequence[float]]) -> Array:
    """Return a block between y[0] and y[1], with x[i] and z[i] its (low, high) at y[i]."""
    return np.array([(x[j][i], y[j], z[j][k]) for i in (0, 1) for j in (0, 1) for k in (0, 1)], float)

"""Thick plates as boxes: the distance of two boxes, and the names of the features that touch first.

Two boxes are apart if one of 15 directions separates them: the three axes of each box, and the products of an axis of
one with an axis of the other. So the largest gap over the directions is a distance that vanishes at the first touch.
While the lower tip edge of scale 1 slides on the upper side edge of another scale it is zero, and the boxes do not
touch elsewhere as long as the common normal points out of both: k_ZX, k_XX, k_YZ, k_YY >= 0
(:mod:`squama.model.twisting`). Where one of these vanishes an edge lies flat on a face.

A box is given by half its sides; the other box also by its base midpoint and the columns of its axes, both in the axes
of scale 1 (:func:`squama.model.plates.axes`).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from squama.types import Array

PARALLEL = 1e-12
"""Squared sine of the angle below which two axes count as parallel and their product is skipped."""
SIDES = (2, 0), (0, 0), (1, 2), (1, 1)
"""Indices of the cosines k_IJ that keep the common normal of tip and side edge outside both boxes."""
_FLAT = (
    "{side} on the lower face of scale 1",
    "{side} on the tip face of scale 1",
    "{tip} on the upper face of scale {k}",
    "{tip} on the side face of scale {k}",
)


def directions(half: Sequence[float], o: Array, M: Array) -> Array:
    """Return the gaps along the 15 directions, shape (15, ...): negative where the boxes overlap."""
    r = np.array(half).reshape(3, *[1] * (o.ndim - 1))
    t, size = o + r[0] * M[:, 0], np.abs(M)
    t = np.concatenate([t[:1] - r[0], t[1:]])
    out = list(np.abs(t) - r - (size * r[None]).sum(axis=1))
    out += list(np.abs((t[:, None] * M).sum(axis=0)) - r - (size * r[:, None]).sum(axis=0))
    for i in range(3):
        a, b = (i + 1) % 3, (i + 2) % 3
        for j in range(3):
            c, d = (j + 1) % 3, (j + 2) % 3
            gap = np.abs(t[b] * M[a, j] - t[a] * M[b, j]) - r[a] * size[b, j] - r[b] * size[a, j]
            gap = gap - r[c] * size[i, d] - r[d] * size[i, c]
            square = 1 - M[i, j] ** 2
            out.append(np.where(square > PARALLEL, gap / np.sqrt(np.maximum(square, PARALLEL)), -np.inf))
    return np.stack(out)


def gaps(half: Sequence[float], o: Array, M: Array) -> Array:
    """Return the distance of the boxes and the cosines of :data:`SIDES`, shape (5, ...)."""
    return np.stack([directions(half, o, M).max(axis=0), *(M[i, j] for i, j in SIDES)])


def leave_out(gap: Array, follows: int, closed: Array) -> None:
    """Set gaps (5, n, m) that are not other contacts to 1; neighbour ``follows`` is touched where ``closed`` (m,)."""
    alone = gap[:, follows - 1].copy() if follows else None
    gap[1:] = 1.0
    if alone is not None:
        gap[0, follows - 1] = np.where(closed, 1.0, alone[0])
        gap[1:, follows - 1] = np.where(closed, alone[1:], 1.0)


def name(half: Sequence[float], o: Array, M: Array, pair: int, k: int, mirrored: bool) -> str:
    """Return the touching features in words; ``pair`` is the row of :func:`gaps` that vanishes."""
    other = 1 + k
    if pair:
        side = _edge(0, np.array([0, -1, 1]), other, mirrored)
        tip = _edge(1, np.array([1, 0, -1]), 1, mirrored)
        return _FLAT[pair - 1].format(side=side, tip=tip, k=other)
    which = int(np.argmax(directions(half, o, M)))
    t = o + half[0] * (M[:, 0] - np.eye(3)[0])
    if which < 6:
        i = which % 3
        n = np.eye(3)[i] if which < 3 else M[:, i]
        n = n if n @ t > 0 else -n
        # the deepest corner of one box, and the face of the other
        if which < 3:
            return f"{_corner(-np.sign(n @ M), other, mirrored)} on the {_face(i, n[i])} face of scale 1"
        return f"{_corner(np.sign(n), 1, mirrored)} on the {_face(i, -(n @ M)[i])} face of scale {other}"
    i, j = divmod(which - 6, 3)
    n = np.cross(np.eye(3)[i], M[:, j])
    n = n if n @ t > 0 else -n
    return f"{_edge(i, np.sign(n), 1, mirrored)} on {_edge(j, -np.sign(n @ M), other, mirrored)}"


def _level(z: float) -> str:
    return "upper" if z > 0 else "lower"


def _letter(x: float, y: float, mirrored: bool) -> str:
    return ("CB" if x > 0 else "DA")[int((y > 0) != mirrored)]


def _face(axis: int, sign: float) -> str:
    return ("tip" if sign > 0 else "base", "side", _level(sign))[axis]


def _corner(at: Array, scale: int, mirrored: bool) -> str:
    return f"{_level(at[2])} corner {_letter(at[0], at[1], mirrored)}{scale}"


def _edge(along: int, at: Array, scale: int, mirrored: bool) -> str:
    """Return the name of the edge along an axis, on the sides ``at`` of the box."""
    if along == 2:
        return f"upright edge {_letter(at[0], at[1], mirrored)}{scale}"
    if along == 0:
        ends, kind = [_letter(x, at[1], mirrored) for x in (-1, 1)], "side"
    else:
        ends, kind = [_letter(at[0], y, mirrored) for y in (-1, 1)], "tip" if at[0] > 0 else "base"
    return f"{_level(at[2])} {kind} edge {ends[0]}{scale}{ends[1]}{scale}"

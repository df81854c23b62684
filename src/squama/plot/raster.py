"""Rasterisation of triangles with a depth buffer, for thin plates that overlap each other cyclically."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from squama.types import Array


def fill(near: Array, corners: Array) -> Iterator[tuple[int, tuple[slice, slice], Array, Array]]:
    """Draw triangles one after the other into a depth buffer ``near`` (rows, columns) of nearness to the eye.

    ``corners`` (n, 3, 3): column, row and nearness, which must be linear in the picture: the inverse of the distance in
    perspective, the coordinate along the view in a parallel projection. For each triangle that covers the middle of a
    pixel, yields its number, the window of pixels around it, and the masks of its pixels in front of all drawn before,
    and behind.
    """
    rows, columns = near.shape
    low = np.maximum(np.floor(corners[..., :2].min(axis=1)).astype(int), 0)
    high = np.minimum(np.ceil(corners[..., :2].max(axis=1)).astype(int), [columns, rows])
    (ax, ay), (bx, by), (cx, cy) = (corners[:, i, :2].T for i in range(3))
    area = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
    depth = corners[..., 2]
    for i in np.flatnonzero((np.abs(area) > 1e-9) & (high > low).all(axis=1)):
        x = np.arange(low[i, 0], high[i, 0]) + 0.5
        y = (np.arange(low[i, 1], high[i, 1]) + 0.5)[:, None]
        u = ((x - ax[i]) * (cy[i] - ay[i]) - (y - ay[i]) * (cx[i] - ax[i])) / area[i]
        v = ((bx[i] - ax[i]) * (y - ay[i]) - (by[i] - ay[i]) * (x - ax[i])) / area[i]
        inside = (u >= 0) & (v >= 0) & (u + v <= 1)
        if not inside.any():
            continue
        window = np.s_[low[i, 1] : high[i, 1], low[i, 0] : high[i, 0]]
        nearness = depth[i, 0] + u * (depth[i, 1] - depth[i, 0]) + v * (depth[i, 2] - depth[i, 0])
        front = inside & (nearness > near[window])
        near[window][front] = nearness[front]
        yield int(i), window, front, inside & ~front

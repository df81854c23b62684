"""Triangles to pixels with a depth buffer: enough for thin plates that lie over each other in turns."""

from __future__ import annotations

import numpy as np

from squama.model.solve import Array
from squama.view.look import Camera

SAMPLES = 2
"""Every pixel is drawn as SAMPLES x SAMPLES, which smooths edges."""
PALE = 0.3
"""How strongly something shows through what is in front of it, where it is asked to."""
NEARER = 0.997
"""Lines are drawn this much nearer than the faces they bound."""


class Canvas:
    """A picture that is being drawn.

    Parameters
    ----------
    width, height : int
        Size in pixels.
    camera : Camera
        From where one looks.
    background : Array
        Colour (3), 0 to 1.
    """

    def __init__(self, width: int, height: int, camera: Camera, background: Array) -> None:
        self.size = np.array([width, height]) * SAMPLES
        self.camera = camera
        self.colour = np.empty((self.size[1], self.size[0], 3))
        self.colour[:] = background
        self.depth = np.full((self.size[1], self.size[0]), np.inf)

    def place(self, points: Array) -> Array:
        """Return points (..., 3) as pixels across, pixels down, distance."""
        seen = self.camera.seen(points)
        x = (seen[..., 0] + 1) / 2 * self.size[0]
        y = (1 - seen[..., 1]) / 2 * self.size[1]
        return np.stack([x, y, seen[..., 2]], axis=-1)

    def triangles(self, corners: Array, colours: Array, *, through: bool = False) -> None:
        """Fill triangles (n, 3, 3) in space with colours (n, 3); ``through``: pale where something is in front."""
        self.fill(self.place(corners), colours, through=through)

    def lines(self, starts: Array, ends: Array, colour: Array, thick: float, *, through: bool = False) -> None:
        """Draw lines between points (n, 3), ``thick`` pixels wide."""
        a, b = self.place(starts), self.place(ends)
        way = b[:, :2] - a[:, :2]
        size = np.linalg.norm(way, axis=1, keepdims=True)
        way = np.divide(way, size, out=np.zeros_like(way), where=size > 0)
        aside = np.zeros_like(a)
        aside[:, 0], aside[:, 1] = -way[:, 1], way[:, 0]
        aside *= thick * SAMPLES / 2
        # a little longer, so that lines meet at corners
        reach = np.zeros_like(a)
        reach[:, :2] = way * thick * SAMPLES / 2
        near = np.array([1, 1, NEARER])
        p, q = (a - reach) * near, (b + reach) * near
        quads = np.stack([p - aside, p + aside, q + aside, q - aside], axis=1)
        self._quads(quads, colour, through=through)

    def discs(self, centres: Array, radius: float, colour: Array, *, through: bool = False) -> None:
        """Draw discs around points (n, 3) that face the eye; the radius is a length in space."""
        middle = self.place(centres) * np.array([1, 1, NEARER])
        turn = np.linspace(0, 2 * np.pi, 13)
        across = self.size[1] / (2 * self.camera.slope * middle[:, 2]) * radius
        rim = middle[:, None] + across[:, None, None] * np.stack([np.cos(turn), np.sin(turn), 0 * turn], axis=-1)
        fans = np.stack([np.broadcast_to(middle[:, None], rim[:, 1:].shape), rim[:, :-1], rim[:, 1:]], axis=2)
        self.fill(fans.reshape(-1, 3, 3), _same(colour, fans.shape[0] * 12), through=through)

    def _quads(self, quads: Array, colour: Array, *, through: bool) -> None:
        parts = quads[:, [[0, 1, 2], [0, 2, 3]]].reshape(-1, 3, 3)
        self.fill(parts, _same(colour, len(parts)), through=through)

    def fill(self, placed: Array, colours: Array, *, through: bool) -> None:
        """Fill triangles that are already placed in the picture."""
        width, height = self.size
        low = np.floor(placed[..., :2].min(axis=1)).astype(int)
        high = np.ceil(placed[..., :2].max(axis=1)).astype(int)
        low, high = np.maximum(low, 0), np.minimum(high, [width, height])
        (ax, ay), (bx, by), (cx, cy) = (placed[:, i, :2].T for i in range(3))
        area = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
        # the inverse of the distance is linear in the picture
        inverse = 1 / placed[..., 2]
        for i in np.flatnonzero((np.abs(area) > 1e-9) & (high > low).all(axis=1) & (placed[..., 2] > 0).all(axis=1)):
            x = np.arange(low[i, 0], high[i, 0]) + 0.5
            y = (np.arange(low[i, 1], high[i, 1]) + 0.5)[:, None]
            u = ((x - ax[i]) * (cy[i] - ay[i]) - (y - ay[i]) * (cx[i] - ax[i])) / area[i]
            v = ((bx[i] - ax[i]) * (y - ay[i]) - (by[i] - ay[i]) * (x - ax[i])) / area[i]
            inside = (u >= 0) & (v >= 0) & (u + v <= 1)
            if not inside.any():
                continue
            depth = 1 / (inverse[i, 0] + u * (inverse[i, 1] - inverse[i, 0]) + v * (inverse[i, 2] - inverse[i, 0]))
            window = np.s_[low[i, 1] : high[i, 1], low[i, 0] : high[i, 0]]
            front = inside & (depth < self.depth[window])
            if through:
                behind = inside & ~front
                self.colour[window][behind] += PALE * (colours[i] - self.colour[window][behind])
            self.colour[window][front] = colours[i]
            self.depth[window][front] = depth[front]

    def pixels(self) -> Array:
        """Return the picture as bytes (height, width, 3)."""
        height, width = self.size[1] // SAMPLES, self.size[0] // SAMPLES
        mean = self.colour.reshape(height, SAMPLES, width, SAMPLES, 3).mean(axis=(1, 3))
        return np.asarray(np.round(255 * np.clip(mean, 0, 1)), np.uint8)


def _same(colour: Array, n: int) -> Array:
    return np.broadcast_to(colour, (n, 3))

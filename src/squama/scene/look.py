"""How a beam is looked at: the camera, as ``js/scene.js`` has it, and the picture that is drawn through it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from squama.plot import raster
from squama.scene.geometry import Attitude, Design, Load, bar, first, scale
from squama.types import Array

LOOK = np.array([-0.75, 0.72, -0.16])
"""From where one looks."""
AWAY = 1.1
"""How much farther away one stands than the beam needs."""
SAMPLES = 2
"""Every pixel is drawn as SAMPLES x SAMPLES, which smooths edges."""
NEARER = 0.999
"""Lines are drawn this much nearer than the faces they bound."""


class Camera(NamedTuple):
    """Where one stands, and the ``middle`` one looks at; unit vectors ``right``, ``up``, ``back``.

    ``slope``: tangent of half the angle of view.
    """

    eye: Array
    middle: Array
    right: Array
    up: Array
    back: Array
    slope: float
    aspect: float

    def seen(self, points: Array) -> Array:
        """Return places in the picture: across and up from -1 to 1, and distance from the eye along the view."""
        q = points - self.eye
        depth = -(q @ self.back)
        across, up = q @ self.right / (depth * self.slope * self.aspect), q @ self.up / (depth * self.slope)
        return np.stack([across, up, depth], axis=-1)


def outline(d: Design, load: Load, *stands: Attitude) -> Array:
    """Return points (n, 3) that surround the beam: bar and scales, straight and as it is.

    ``stands``: how the scales stand, all alike or each by itself.
    """
    seen = []
    every: tuple[Load, ...] = (0.0, load)
    for at in every:
        seen.append(bar(d, at)[0].reshape(-1, 3))
        places = enumerate(first(d) + np.arange(d["scales"]))
        seen += [scale(d, at, stands[min(i, len(stands) - 1)], k).corners for i, k in places]
    return np.concatenate(seen)


def fitted(points: Array, aspect: float) -> Camera:
    """Return the camera that sees all points from `LOOK`, as near as can be, in a picture of this width over height."""
    middle = (points.min(axis=0) + points.max(axis=0)) / 2
    back = LOOK / np.linalg.norm(LOOK)
    right = np.cross([0.0, 1.0, 0.0], back)
    right /= np.linalg.norm(right)
    up = np.cross(back, right)
    # the angle of view is 32 deg, from the lower to the upper edge of the picture
    slope = float(np.tan(np.radians(32.0) / 2))
    q = points - middle
    needed = np.maximum(np.abs(q @ right) / aspect, np.abs(q @ up))
    away = AWAY * max(0.0, float(np.max(q @ back + needed / slope)))
    return Camera(middle + away * back, middle, right, up, back, slope, aspect)


def halves(quads: Array) -> Array:
    """Return the triangles (2 n, 3, 3) of quadrilaterals (n, 4, 3)."""
    return quads[:, [[0, 1, 2], [0, 2, 3]]].reshape(-1, 3, 3)


class Canvas:
    """A picture of ``width`` x ``height`` pixels that is being drawn, on a ground of one colour (3), 0 to 1."""

    def __init__(self, width: int, height: int, camera: Camera, background: Array) -> None:
        self.size = np.array([width, height]) * SAMPLES
        self.camera = camera
        self.near = np.zeros((self.size[1], self.size[0]))
        self.colour = np.full((*self.near.shape, 3), background)

    def place(self, points: Array) -> Array:
        """Return points (..., 3) as pixels across, pixels down, distance."""
        across, up, depth = np.moveaxis(self.camera.seen(points), -1, 0)
        return np.stack([(across + 1) / 2 * self.size[0], (1 - up) / 2 * self.size[1], depth], axis=-1)

    def triangles(self, corners: Array, colours: Array, *, through: bool = False) -> None:
        """Fill triangles (n, 3, 3) in space with colours (n, 3); ``through``: pale where something is in front."""
        self.fill(self.place(corners), colours, through=through)

    def lines(self, starts: Array, ends: Array, colour: Array, thick: float, *, through: bool = False) -> None:
        """Draw lines between points (n, 3), ``thick`` pixels wide."""
        a, b = self.place(starts), self.place(ends)
        way = (b - a) * [1, 1, 0]
        size = np.linalg.norm(way, axis=1, keepdims=True)
        # a little longer, so that lines meet at corners
        reach = np.divide(way, size, out=np.zeros_like(way), where=size > 0) * thick * SAMPLES / 2
        aside = reach[:, [1, 0, 2]] * [-1, 1, 1]
        near = np.array([1, 1, NEARER])
        p, q = (a - reach) * near, (b + reach) * near
        self.fill(halves(np.stack([p - aside, p + aside, q + aside, q - aside], axis=1)), colour, through=through)

    def discs(self, centres: Array, radius: float, colour: Array, *, through: bool = False) -> None:
        """Draw discs around points (n, 3) that face the eye; the radius is a length in space."""
        middle = self.place(centres) * np.array([1, 1, NEARER])
        turn = np.linspace(0, 2 * np.pi, 13)
        across = self.size[1] / (2 * self.camera.slope * middle[:, 2]) * radius
        rim = middle[:, None] + across[:, None, None] * np.stack([np.cos(turn), np.sin(turn), 0 * turn], axis=-1)
        fans = np.stack([np.broadcast_to(middle[:, None], rim[:, 1:].shape), rim[:, :-1], rim[:, 1:]], axis=2)
        self.fill(fans.reshape(-1, 3, 3), colour, through=through)

    def fill(self, placed: Array, colours: Array, *, through: bool) -> None:
        """Fill triangles that are already placed in the picture, with a colour for each or for all."""
        ahead = (placed[..., 2] > 0).all(axis=1)
        colours = np.broadcast_to(colours, (len(placed), 3))[ahead]
        # the inverse of the distance is linear in the picture
        corners = np.concatenate([placed[ahead, :, :2], 1 / placed[ahead, :, 2:]], axis=-1)
        for number, window, front, behind in raster.fill(self.near, corners):
            pixels, colour = self.colour[window], colours[number]
            if through:
                pixels[behind] += 0.3 * (colour - pixels[behind])
            pixels[front] = colour

    def pixels(self) -> Array:
        """Return the picture as bytes (height, width, 3)."""
        height, width = self.size[1] // SAMPLES, self.size[0] // SAMPLES
        mean = self.colour.reshape(height, SAMPLES, width, SAMPLES, 3).mean(axis=(1, 3))
        return np.asarray(np.round(255 * np.clip(mean, 0, 1)), np.uint8)

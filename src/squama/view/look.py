"""How a beam is looked at, and in which colours; ``js/scene.js`` and the page have the same."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from squama.model.solve import Array
from squama.view.geometry import Design, bar, first, scale

COLOURS = {
    "free": "#4a90c2",
    "sliding": "#e0a030",
    "locked": "#c8323c",
    "ended": "#8a63b0",
}
"""Colours of the scales by their state."""
WORDS = {"free": "not in contact", "sliding": "sliding", "locked": "locked", "ended": "at the end of the curve"}
"""What the states are called."""
THEMES = {
    "light": {"background": "#f7f7f5", "bar": "#cfc8ba", "edge": "#2b2b2b", "point": "#111111", "normal": "#14803c",
              "friction": "#c2185b"},
    "dark": {"background": "#16191d", "bar": "#6d675c", "edge": "#e6e6e6", "point": "#ffffff", "normal": "#3ddc84",
             "friction": "#ff5fa2"},
}  # fmt: skip
"""Colours of the rest, on a light and on a dark page."""
LOOK = np.array([-0.75, 0.72, -0.16])
"""From where one looks."""
FIELD = np.radians(32.0)
"""Angle of view, from the lower to the upper edge of the picture."""
AWAY = 1.1
"""How much farther away one stands than the beam needs."""


class Camera(NamedTuple):
    """Where one stands; unit vectors ``right``, ``up``, ``back``; ``slope`` tangent of half the angle of view."""

    eye: Array
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


def outline(d: Design, load: float, theta: float) -> Array:
    """Return points (n, 3) that surround the beam: bar, first, middle and last scale, straight and as it is."""
    seen = []
    for at in (0.0, load):
        seen.append(bar(d, at)[0].reshape(-1, 3))
        seen += [scale(d, at, theta, k).corners for k in (first(d), 0.0, -first(d))]
    return np.concatenate(seen)


def fitted(points: Array, aspect: float) -> Camera:
    """Return the camera that sees all points from `LOOK`, as near as can be, in a picture of this width over height."""
    middle = (points.min(axis=0) + points.max(axis=0)) / 2
    back = LOOK / np.linalg.norm(LOOK)
    right = np.cross([0.0, 1.0, 0.0], back)
    right /= np.linalg.norm(right)
    up = np.cross(back, right)
    slope = float(np.tan(FIELD / 2))
    q = points - middle
    needed = np.maximum(np.abs(q @ right) / aspect, np.abs(q @ up))
    away = AWAY * max(0.0, float(np.max(q @ back + needed / slope)))
    return Camera(middle + away * back, right, up, back, slope, aspect)

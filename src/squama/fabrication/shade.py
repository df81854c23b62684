"""Pictures of solids by a depth buffer: parallel projection, plain shading, edges drawn where depth or face changes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from squama.fabrication.mesh import Mesh, from_manifold, manifold
from squama.fabrication.recipe import Array

LIGHT = np.array([-0.35, -0.5, 0.8])
EDGE = (0.1, 0.1, 0.1)


class View(NamedTuple):
    """Directions to the right, up and to the eye, as rows of ``axes``; the picture's extent there, mm."""

    axes: Array
    left: float
    right: float
    bottom: float
    top: float


def look(azimuth: float, elevation: float) -> Array:
    """Return the directions to the right, up and to the eye; angles in degrees, 0 looks along across."""
    a, e = np.radians([azimuth, elevation])
    eye = np.array([np.sin(a) * np.cos(e), -np.cos(a) * np.cos(e), np.sin(e)])
    right = np.array([np.cos(a), np.sin(a), 0.0])
    return np.array([right, np.cross(eye, right), eye])


def fitted(meshes: Sequence[Mesh], axes: Array, margin: float = 0.03) -> View:
    """Return the view that shows all solids."""
    seen = np.concatenate([m.vertices for m in meshes]) @ axes[:2].T
    low, high = seen.min(axis=0), seen.max(axis=0)
    room = margin * float((high - low).max())
    return View(axes, low[0] - room, high[0] + room, low[1] - room, high[1] + room)


def halved(mesh: Mesh, across: float = 0.0) -> Mesh | None:
    """Return the part of a solid beyond a plane along the bar; None if there is nothing."""
    part = manifold(mesh).trim_by_plane((0.0, 1.0, 0.0), across)
    return None if part.is_empty() else from_manifold(mesh.name, part)


def picture(meshes: Sequence[Mesh], colours: Sequence[Sequence[float]], view: View, pixels: int) -> NDArray[np.uint8]:
    """Return an image (rows, ``pixels``, 4) of the solids, the first row at the top; nothing is transparent white.

    Parameters
    ----------
    meshes : sequence of Mesh
        The solids.
    colours : sequence
        Red, green, blue of each, 0 to 1.
    view : View
        What is seen.
    pixels : int
        Width of the image.
    """
    fine = 2
    size = (view.right - view.left) / (pixels * fine)
    shape = fine * max(1, round((view.top - view.bottom) / size / fine)), pixels * fine
    depth, face = np.full(shape, -np.inf), np.full(shape, -1)
    shades: list[Array] = []
    for number, (mesh, colour) in enumerate(zip(meshes, colours, strict=True)):
        seen = (mesh.vertices @ view.axes.T - [view.left, view.bottom, 0]) / [size, size, 1]
        corners = seen[mesh.triangles]
        a, b, c = (mesh.vertices[mesh.triangles[:, i]] for i in range(3))
        normals = np.cross(b - a, c - a)
        normals /= np.maximum(np.linalg.norm(normals, axis=1), 1e-300)[:, None]
        bright = 0.7 + 0.3 * (normals @ (LIGHT / np.linalg.norm(LIGHT)))
        for triangle, light, normal in zip(corners, bright, normals, strict=True):
            if normal @ view.axes[2] > 1e-9:
                _fill(depth, face, triangle, len(shades))
                shades.append(np.array([*(np.asarray(colour) * light), number, *normal, normal @ view.axes[2]]))
    return _image(depth, face, np.array(shades).reshape(-1, 8), size, fine)


def _fill(depth: Array, face: NDArray[np.int64], triangle: Array, number: int) -> None:
    """Draw a triangle into the buffers; its corners are columns, rows from the bottom, depths."""
    low = np.maximum(np.floor(triangle[:, :2].min(axis=0)).astype(int), 0)
    high = np.minimum(np.ceil(triangle[:, :2].max(axis=0)).astype(int) + 1, depth.shape[::-1])
    if (high <= low).any():
        return
    x, y = np.meshgrid(np.arange(low[0], high[0]) + 0.5, np.arange(low[1], high[1]) + 0.5)
    (ax, ay, az), (bx, by, bz), (cx, cy, cz) = triangle
    area = (bx - ax) * (cy - ay) - (cx - ax) * (by - ay)
    if abs(area) < 1e-12:
        return
    v = ((x - ax) * (cy - ay) - (cx - ax) * (y - ay)) / area
    w = ((bx - ax) * (y - ay) - (x - ax) * (by - ay)) / area
    z = az + v * (bz - az) + w * (cz - az)
    place = slice(low[1], high[1]), slice(low[0], high[0])
    nearer = (v >= 0) & (w >= 0) & (v + w <= 1) & (z > depth[place])
    depth[place][nearer], face[place][nearer] = z[nearer], number


def _image(depth: Array, face: NDArray[np.int64], shades: Array, size: float, fine: int) -> NDArray[np.uint8]:
    """Colour the buffers; a line stands where the solid, the direction of its face or the depth changes."""
    seen = face >= 0
    # one row more, for what is not seen (face -1)
    colour = np.append(np.c_[shades[:, :3], np.ones(len(shades))], [[1.0, 1, 1, 0]], axis=0).astype(np.float32)
    _, kind = np.unique(np.round(shades[:, 3:7], 3), axis=0, return_inverse=True)
    kind = np.append(kind.ravel(), -1)[face]
    slope = np.append(1 / np.maximum(shades[:, 7], 0.02), 1.0).astype(np.float32)[face]
    flat = np.where(seen, depth, -1e9)
    line = np.zeros(face.shape, bool)
    for axis in (0, 1):
        p, q = (tuple(part if i == axis else slice(None) for i in (0, 1)) for part in (slice(1, None), slice(-1)))
        jump = np.abs(flat[p] - flat[q]) > size * (1.5 * np.maximum(slope[p], slope[q]) + 1)
        line[p] |= (kind[p] != kind[q]) | jump
    pixels = colour[face]
    pixels[line] = [*EDGE, 1.0]
    rows, columns = (n // fine for n in face.shape)
    small = pixels.reshape(rows, fine, columns, fine, 4)
    weight = small[..., 3:]
    mixed = (small[..., :3] * weight).sum((1, 3)) / np.maximum(weight.sum((1, 3)), 1e-9)
    whole = np.concatenate([mixed, weight.mean((1, 3))], axis=-1)
    return np.asarray(np.round(whole[::-1] * 255), np.uint8)

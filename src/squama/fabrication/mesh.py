"""From recipes to triangles (manifold3d cuts, in double precision), and what a mesh says about itself."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from squama.errors import SquamaError
from squama.fabrication.bodies import QUADS, Recipe
from squama.needs import need
from squama.types import Array

if TYPE_CHECKING:
    from manifold3d import Manifold

Index = NDArray[np.int64]

TRIANGLES = np.array([t for a, b, c, d in QUADS for t in ((a, b, c), (a, c, d))])


class Mesh(NamedTuple):
    """A solid's surface: ``name``, ``vertices`` (n, 3) in mm, ``triangles`` (m, 3) counterclockwise from outside."""

    name: str
    vertices: Array
    triangles: Index

    def moved(self, turn: Array, shift: ArrayLike, name: str | None = None) -> Mesh:
        """Return the mesh turned by a rotation matrix, then moved."""
        return Mesh(name or self.name, self.vertices @ turn.T + np.asarray(shift), self.triangles)

    @property
    def corners(self) -> Array:
        """Corners (3, m, 3) of the triangles: first, second, third ones."""
        return self.vertices[self.triangles.T]

    @property
    def normals(self) -> Array:
        """Normals (m, 3) of the triangles, as long as twice their areas."""
        a, b, c = self.corners
        return np.cross(b - a, c - a)

    @property
    def volume(self) -> float:
        """Volume in mm^3, by the divergence theorem."""
        a, b, c = self.corners
        # from the middle, where less is lost in the sum
        middle = self.vertices.mean(axis=0)
        return float(np.einsum("ij,ij->", np.cross(a - middle, b - middle), c - middle) / 6)

    @property
    def bounds(self) -> Array:
        """Lowest and highest coordinates (2, 3)."""
        return np.array([self.vertices.min(axis=0), self.vertices.max(axis=0)])


def build(recipe: Recipe) -> Mesh:
    """Return a solid's mesh. Raises SquamaError: the cutting failed."""
    kernel = need("manifold3d")
    parts = [manifold(Mesh(recipe.name, block, TRIANGLES)) for block in (recipe.whole, *recipe.cuts)]
    return from_manifold(recipe.name, kernel.Manifold.batch_boolean(parts, kernel.OpType.Subtract))


def manifold(mesh: Mesh) -> Manifold:
    """Return the mesh as a manifold3d.Manifold. Raises SquamaError: it is no closed oriented surface."""
    kernel = need("manifold3d")
    solid = kernel.Manifold(
        kernel.Mesh64(np.ascontiguousarray(mesh.vertices), np.ascontiguousarray(mesh.triangles, np.uint64))
    )
    if solid.status() != kernel.Error.NoError or solid.is_empty():
        message = f"{mesh.name}: the solid is not a manifold ({solid.status().name})"
        raise SquamaError(message)
    return solid


def from_manifold(name: str, solid: Manifold) -> Mesh:
    """Return a manifold's mesh with vertices and triangles in an order that follows from the shape alone."""
    raw = solid.to_mesh64()
    vertices, triangles = np.asarray(raw.vert_properties)[:, :3], np.asarray(raw.tri_verts).astype(np.int64)
    order = np.lexsort(vertices.T[::-1])
    number = np.empty_like(order)
    number[order] = np.arange(order.size)
    triangles = number[triangles]
    first = triangles.argmin(axis=1)
    triangles = triangles[np.arange(len(triangles))[:, None], (first[:, None] + np.arange(3)) % 3]
    return Mesh(name, vertices[order], triangles[np.lexsort(triangles.T[::-1])])


NEAR = 1e-9
"""A ray meets no surface nearer than this to its start, mm; nor one that it grazes at a smaller sine."""


class Faces(NamedTuple):
    """Faces of one direction: unit ``normal`` (3,), ``area`` in mm^2, numbers of the ``triangles``."""

    normal: Array
    area: float
    triangles: Index


def open_edges(mesh: Mesh) -> int:
    """Return how many edges are not run through once in each direction; 0: closed, oriented and manifold."""
    start, stop = _edges(mesh.triangles)
    unique, counts = np.unique(start * len(mesh.vertices) + stop, return_counts=True)
    return int((counts > 1).sum() + (~np.isin(stop * len(mesh.vertices) + start, unique)).sum())


def _edges(triangles: Index) -> Index:
    """Return starts and ends (2, 3 m) of the edges: of all triangles the first, then the second, the third."""
    return np.stack([triangles.T.ravel(), np.roll(triangles, -1, axis=1).T.ravel()])


def closed(triangles: Index) -> bool:
    """Say whether every edge is run through as often in one direction as in the other, at least once."""
    edges = _edges(triangles)
    _, which = np.unique(np.sort(edges, axis=0).T, axis=0, return_inverse=True)
    return bool(edges.size and not np.bincount(which.ravel(), np.where(edges[0] < edges[1], 1.0, -1.0)).any())


def faces(mesh: Mesh) -> list[Faces]:
    """Return the faces by direction, the largest first; mirrored directions are two."""
    normals = mesh.normals
    twice = np.linalg.norm(normals, axis=1)
    whole = twice > NEAR
    units = normals[whole] / twice[whole, None]
    numbers = np.flatnonzero(whole)
    _, group = np.unique(np.round(units, 5) + 0.0, axis=0, return_inverse=True)
    found = []
    for g in range(int(group.max()) + 1):
        inside = numbers[group.ravel() == g]
        total = normals[inside].sum(axis=0)
        found.append(Faces(total / np.linalg.norm(total), float(twice[inside].sum() / 2), inside))
    return sorted(found, key=lambda f: -f.area)


def samples(mesh: Mesh, triangles: Index) -> Array:
    """Return four points inside each triangle (n, 4, 3): its middle, and one close to each corner."""
    near = 0.999 * np.eye(3) + 0.0005 * (1 - np.eye(3))
    shares = np.concatenate([np.full((1, 3), 1 / 3), near])
    return np.asarray(np.einsum("sc,tcx->tsx", shares, mesh.vertices[mesh.triangles[triangles]]))


def cast(mesh: Mesh, origins: Array, direction: Array) -> Array:
    """Return the distance from each origin (n, 3) along a unit direction to the next surface; inf if there is none."""
    a, b, c = mesh.corners
    first, second = b - a, c - a
    across = np.cross(direction, second)
    det = np.einsum("ij,ij->i", first, across)
    size = np.linalg.norm(np.cross(first, second), axis=1)
    usable = np.abs(det) > NEAR * np.maximum(size, NEAR)
    a, first, second, across, det = (x[usable] for x in (a, first, second, across, det))
    away = origins[:, None] - a
    u = (away * across).sum(-1) / det
    turned = np.cross(away, first)
    v = (turned @ direction) / det
    t = (turned * second).sum(-1) / det
    slack = 1e-12
    met = (u >= -slack) & (v >= -slack) & (u + v <= 1 + slack) & (t > 1e-7)
    return np.asarray(np.where(met, t, np.inf).min(axis=1))

"""From recipes to triangles: manifold3d does the cutting, in double precision."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from squama.errors import SquamaError
from squama.fabrication.recipe import QUADS, Array, Recipe
from squama.needs import need

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
    def volume(self) -> float:
        """Volume in mm^3, by the divergence theorem."""
        a, b, c = (self.vertices[self.triangles[:, i]] for i in range(3))
        # from the middle, where less is lost in the sum
        middle = self.vertices.mean(axis=0)
        return float(np.einsum("ij,ij->", np.cross(a - middle, b - middle), c - middle) / 6)

    @property
    def bounds(self) -> Array:
        """Lowest and highest coordinates (2, 3)."""
        return np.array([self.vertices.min(axis=0), self.vertices.max(axis=0)])


def build(recipe: Recipe) -> Mesh:
    """Return a solid's mesh.

    Raises
    ------
    SquamaError
        The cutting failed.
    """
    kernel = need("manifold3d")
    parts = [manifold(Mesh(recipe.name, block, TRIANGLES)) for block in (recipe.whole, *recipe.cuts)]
    solid = kernel.Manifold.batch_boolean(parts, kernel.OpType.Subtract)
    return from_manifold(recipe.name, solid)


def manifold(mesh: Mesh) -> Any:
    """Return the mesh as a manifold3d.Manifold; it refuses what is no closed oriented surface.

    Raises
    ------
    SquamaError
        The mesh is not a manifold.
    """
    kernel = need("manifold3d")
    solid = kernel.Manifold(
        kernel.Mesh64(np.ascontiguousarray(mesh.vertices), np.ascontiguousarray(mesh.triangles, np.uint64))
    )
    if solid.status() != kernel.Error.NoError or solid.is_empty():
        message = f"{mesh.name}: the solid is not a manifold ({solid.status().name})"
        raise SquamaError(message)
    return solid


def from_manifold(name: str, solid: Any) -> Mesh:
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

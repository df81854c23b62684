"""Solids as triangles, cut from recipes by manifold3d in double precision, and measurements of their sizes."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import cos, degrees, sin
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from squama.errors import SquamaError
from squama.fabrication.bodies import BENCH, QUADS, Recipe
from squama.fabrication.plan import Plan
from squama.needs import need
from squama.types import Array

if TYPE_CHECKING:
    from manifold3d import Manifold
    from trimesh import Trimesh

Index = NDArray[np.int64]

TRIANGLES = np.array([t for a, b, c, d in QUADS for t in ((a, b, c), (a, c, d))])
NEAR = 1e-9
"""Least distance of a surface from a ray's start, mm, and least sine of its angle to the ray."""
VOLUME, FILE_VOLUME, OVERLAP, LENGTH, ANGLE = 1e-6, 1e-4, 1e-6, 1e-6, 1e-6
"""Tolerances: volume in memory and from a file (relative), common volume (mm^3), lengths (mm), angles (deg)."""


class Mesh(NamedTuple):
    """A solid's surface: ``name``, ``vertices`` (n, 3) in mm, ``triangles`` (m, 3) counterclockwise from outside."""

    name: str
    vertices: Array
    triangles: Index

    def moved(self, turn: Array, shift: ArrayLike, name: str | None = None) -> Mesh:
        """Return the mesh turned by a rotation matrix (3, 3), then shifted (mm)."""
        return Mesh(name or self.name, self.vertices @ turn.T + np.asarray(shift), self.triangles)

    @property
    def corners(self) -> Array:
        """Corners (3, m, 3) of the triangles, mm."""
        return self.vertices[self.triangles.T]

    @property
    def normals(self) -> Array:
        """Normals (m, 3) of the triangles, of length twice their areas (mm^2)."""
        a, b, c = self.corners
        return np.cross(b - a, c - a)

    @property
    def volume(self) -> float:
        """Volume in mm^3, by the divergence theorem."""
        a, b, c = self.corners
        # relative to the middle, for a smaller rounding error
        middle = self.vertices.mean(axis=0)
        return float(np.einsum("ij,ij->", np.cross(a - middle, b - middle), c - middle) / 6)

    @property
    def bounds(self) -> Array:
        """Lowest and highest coordinates (2, 3)."""
        return np.array([self.vertices.min(axis=0), self.vertices.max(axis=0)])


def build(recipe: Recipe) -> Mesh:
    """Return a solid's mesh. Raises SquamaError where the cutting fails."""
    kernel = need("manifold3d")
    parts = [manifold(Mesh(recipe.name, block, TRIANGLES)) for block in (recipe.whole, *recipe.cuts)]
    return from_manifold(recipe.name, kernel.Manifold.batch_boolean(parts, kernel.OpType.Subtract))


def manifold(mesh: Mesh) -> Manifold:
    """Return the mesh as a manifold3d.Manifold. Raises SquamaError where it is no closed oriented surface."""
    kernel = need("manifold3d")
    solid = kernel.Manifold(
        kernel.Mesh64(np.ascontiguousarray(mesh.vertices), np.ascontiguousarray(mesh.triangles, np.uint64))
    )
    if solid.status() != kernel.Error.NoError or solid.is_empty():
        message = f"{mesh.name}: the solid is not a manifold ({solid.status().name})"
        raise SquamaError(message)
    return solid


def from_manifold(name: str, solid: Manifold) -> Mesh:
    """Return a manifold's mesh with a canonical order of vertices and triangles."""
    raw = solid.to_mesh64()
    vertices, triangles = np.asarray(raw.vert_properties)[:, :3], np.asarray(raw.tri_verts).astype(np.int64)
    order = np.lexsort(vertices.T[::-1])
    number = np.empty_like(order)
    number[order] = np.arange(order.size)
    triangles = number[triangles]
    first = triangles.argmin(axis=1)
    triangles = triangles[np.arange(len(triangles))[:, None], (first[:, None] + np.arange(3)) % 3]
    return Mesh(name, vertices[order], triangles[np.lexsort(triangles.T[::-1])])


class Faces(NamedTuple):
    """Faces of one direction: unit ``normal`` (3,), ``area`` in mm^2, indices of the ``triangles``."""

    normal: Array
    area: float
    triangles: Index


def open_edges(mesh: Mesh) -> int:
    """Return the number of edges not used once in each direction; 0: closed, oriented and manifold."""
    start, stop = _edges(mesh.triangles)
    unique, counts = np.unique(start * len(mesh.vertices) + stop, return_counts=True)
    return int((counts > 1).sum() + (~np.isin(stop * len(mesh.vertices) + start, unique)).sum())


def _edges(triangles: Index) -> Index:
    """Return starts and ends (2, 3 m) of the edges: the first edge of all triangles, then the second, the third."""
    return np.stack([triangles.T.ravel(), np.roll(triangles, -1, axis=1).T.ravel()])


def closed(triangles: Index) -> bool:
    """Return whether every edge is used equally often in both directions, at least once."""
    edges = _edges(triangles)
    _, which = np.unique(np.sort(edges, axis=0).T, axis=0, return_inverse=True)
    return bool(edges.size and not np.bincount(which.ravel(), np.where(edges[0] < edges[1], 1.0, -1.0)).any())


def faces(mesh: Mesh) -> list[Faces]:
    """Return the faces by direction, the largest first; opposite directions are separate."""
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
    """Return four points inside each triangle (n, 4, 3): its centroid, and one close to each corner."""
    near = 0.999 * np.eye(3) + 0.0005 * (1 - np.eye(3))
    shares = np.concatenate([np.full((1, 3), 1 / 3), near])
    return np.asarray(np.einsum("sc,tcx->tsx", shares, mesh.vertices[mesh.triangles[triangles]]))


def cast(mesh: Mesh, origins: Array, direction: Array) -> Array:
    """Return the distance (n,) from each origin (n, 3) along a unit direction to the next surface; inf for none."""
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
    hit = (u >= -slack) & (v >= -slack) & (u + v <= 1 + slack) & (t > 1e-7)
    return np.asarray(np.where(hit, t, np.inf).min(axis=1))


class Check(NamedTuple):
    """A measurement: ``what``, of which ``solid``; lengths in mm, angles in deg, volumes in mm^3."""

    what: str
    solid: str
    expected: float
    measured: float
    unit: str
    tolerance: float

    @property
    def holds(self) -> bool:
        """Whether the measured value is within the tolerance."""
        return bool(abs(self.measured - self.expected) <= self.tolerance)

    def line(self) -> str:
        """Return the check as text."""
        unit = f" {self.unit}" if self.unit else ""
        return f"{self.solid}: {self.what} = {self.measured:.9g}{unit}, should be {self.expected:.9g}{unit}"


def solid(recipe: Recipe, mesh: Mesh) -> Iterator[Check]:
    """Check a solid: closed, manifold, in one piece, with the volume of the closed form."""
    body = manifold(mesh)
    yield Check("edges that are not closed", mesh.name, 0, open_edges(mesh), "", 0)
    # where sheets meet in a single point, the kernel gives each sheet its own vertex
    yield Check("pinched vertices", mesh.name, 0, body.num_vert() - len(mesh.vertices), "", 0)
    yield Check("pieces", mesh.name, 1, len(body.decompose()), "", 0)
    yield Check("volume", mesh.name, recipe.volume, mesh.volume, "mm^3", VOLUME * recipe.volume)


def scale(plan: Plan, mesh: Mesh) -> Iterator[Check]:
    """Check a scale in its place on the bench: thickness by rays between its largest faces, and their angles."""
    top = next(f for f in faces(mesh) if f.normal[2] > 0)
    through = cast(mesh, samples(mesh, top.triangles).reshape(-1, 3), -top.normal)
    yield Check("thickness", mesh.name, plan.thickness, _worst(through, plan.thickness), "mm", LENGTH)
    yield from _angles(plan, mesh.name, top.normal)


def _cuts(mesh: Mesh) -> tuple[Array, Array, Array, float] | None:
    """Return the parallel oblique slots of a solid on the bench; None without any.

    Returns the normal of their floors (3,), the level of each along it (n,), thicknesses, and the lowest point, mm.
    """
    oblique = [f for f in faces(mesh) if np.abs(f.normal).max() < 1 - 1e-9]
    # opposite walls; the largest pair encloses a plate
    pairs = [(f, g) for f in oblique if f.normal[2] > LENGTH for g in oblique if f.normal @ g.normal < -1 + 1e-9]
    if not pairs:
        return None
    floor, roof = pairs[0]
    points, planes, levels = _levels(mesh, floor, floor.normal)
    _, _, roofs = _levels(mesh, roof, floor.normal)
    # the ends of a piece may be as oblique as its slits: a floor with no roof above it, a roof with no floor below
    inside = levels < roofs.max()
    planes, levels = [p for p, held in zip(planes, inside, strict=True) if held], levels[inside]
    roofs = roofs[roofs > levels.min(initial=np.inf)]
    if not planes:
        return None
    found = [np.array([np.inf])] if roofs.size != levels.size else [roofs - levels]
    for plane in planes:
        through = cast(mesh, points[plane].reshape(-1, 3), floor.normal)
        # a ray may leave through the slot's mouth
        found.append(through[np.isfinite(through)])
    corners = mesh.vertices[np.unique(mesh.triangles[np.concatenate([f.triangles for f in oblique])])]
    return floor.normal, levels, np.concatenate(found), float(corners[:, 2].min())


def _levels(mesh: Mesh, face: Faces, normal: Array) -> tuple[Array, list[Index], Array]:
    """Return points in a face's triangles (n, 4, 3), groups of indices in one plane, and the planes' levels."""
    points = samples(mesh, face.triangles)
    heights = points.mean(axis=1) @ normal
    order = np.argsort(heights)
    planes = np.split(order, np.flatnonzero(np.diff(heights[order]) > LENGTH) + 1)
    return points, planes, np.array([heights[p].mean() for p in planes])


def upright(plan: Plan, mesh: Mesh, face: int) -> Mesh:
    """Return a solid on the bench with a face mapped to the place of the scaled face."""
    S = BENCH @ plan.sides[face][0]
    middle = np.array([0.0, 0.0, plan.height / 2])
    triangles = mesh.triangles[:, ::-1] if np.prod(S) < 0 else mesh.triangles
    return mesh._replace(vertices=(mesh.vertices - middle) * S + middle, triangles=triangles)


def halves(plan: Plan, mesh: Mesh) -> Iterator[Mesh]:
    """Yield the substrate's surface for each face with scales, that face up; of two faces the upper half only."""
    for face in range(len(plan.sides)):
        seen = upright(plan, mesh, face)
        above = seen.vertices[seen.triangles, 2].mean(axis=1) > plan.height / 2
        yield seen._replace(triangles=seen.triangles[above]) if len(plan.sides) > 1 else seen


def slots(plan: Plan, mesh: Mesh) -> Iterator[Check]:
    """Check the slots of the substrate on the bench: number, distance, depth, thickness and angles."""
    seen = _cuts(mesh)
    yield Check("slots", mesh.name, plan.scales, 0 if seen is None else seen[1].size, "", 0)
    if seen is None:
        return
    normal, levels, thicknesses, lowest = seen
    pitches = np.diff(levels) / np.abs(normal[0])
    yield Check("distance of slots", mesh.name, plan.pitch, _worst(pitches, plan.pitch), "mm", LENGTH)
    _, _, wide = plan.slot
    yield Check("thickness of slots", mesh.name, wide, _worst(thicknesses, wide), "mm", LENGTH)
    deep = plan.slot[0] * sin(plan.theta0) + wide / 2 * cos(plan.theta0)
    yield Check("depth of slots", mesh.name, deep, float(mesh.vertices[:, 2].max()) - lowest, "mm", LENGTH)
    yield from _angles(plan, mesh.name, normal)


def _angles(plan: Plan, name: str, normal: Array) -> Iterator[Check]:
    """Check theta0 and alpha from the normal (along, across, up) of a plate's upper side."""
    theta0 = degrees(np.arctan2(np.hypot(normal[0], normal[1]), normal[2]))
    alpha = degrees(np.arctan2(normal[1], -normal[0]))
    # n_Z = (sin th sin a, cos th, -sin th cos a) in the beam's x, y, z
    yield Check("theta0", name, degrees(plan.theta0), float(theta0), "deg", ANGLE)
    yield Check("alpha", name, degrees(plan.alpha), float(alpha), "deg", ANGLE / max(sin(plan.theta0), 1e-3))


def overlaps(named: Sequence[Mesh], what: str) -> Check:
    """Return the check of the common volume of all pairs of solids."""
    bodies = [manifold(m) for m in named]
    boxes = np.array([m.bounds for m in named])
    total = 0.0
    for i in range(len(named)):
        near = (boxes[i, 0] <= boxes[:, 1]).all(1) & (boxes[:, 0] <= boxes[i, 1]).all(1)
        total += sum(abs((bodies[i] ^ bodies[j]).volume()) for j in np.flatnonzero(near) if j > i)
    return Check("common volume of all pairs", what, 0, total, "mm^3", OVERLAP)


def gap(one: Mesh, others: Sequence[Mesh], search: float) -> float:
    """Return the least distance from a solid to others, mm, or ``search`` if it is larger."""
    body = manifold(one)
    return min((float(body.min_gap(manifold(o), search)) for o in others), default=search)


def loaded(found: Trimesh, file: str, name: str, volume: float) -> Iterator[Check]:
    """Check a solid read from a file against its volume; without a name, all solids of the file together."""
    where = f"{file}, {name}" if name else file
    # solids in one STL file may touch; their surface is then closed, but not a manifold
    whole = found.is_watertight and found.is_winding_consistent if name else closed(np.asarray(found.faces))
    yield Check("watertight", where, 1, float(whole), "", 0)
    yield Check("volume", where, volume, float(found.volume), "mm^3", FILE_VOLUME * volume)


def _worst(found: Array, expected: float) -> float:
    """Return the value that is farthest from the expected one."""
    return float(found[np.abs(found - expected).argmax()]) if found.size else expected


def slits(plan: Plan, lids: Sequence[Mesh]) -> Iterator[Check]:
    """Check the slits of the lid in its place on the bench: number, thickness and angles."""
    count = 0
    for lid in lids:
        if (seen := _cuts(lid)) is not None:
            normal, levels, thicknesses, _ = seen
            count += levels.size
            found = _worst(thicknesses, plan.slit[1])
            yield Check("thickness of slits", lid.name, plan.slit[1], found, "mm", LENGTH)
            yield from _angles(plan, lid.name, normal)
    yield Check("slits", "lid", plan.scales, count, "", 0)

"""Sizes measured back from the meshes, beside those that were asked for."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import cos, degrees, sin
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from squama.fabrication import mesh as meshes
from squama.fabrication.bodies import BENCH, Recipe
from squama.fabrication.mesh import Index, Mesh
from squama.fabrication.plan import Plan
from squama.types import Array

if TYPE_CHECKING:
    from trimesh import Trimesh

VOLUME, FILE_VOLUME, OVERLAP, LENGTH, ANGLE = 1e-6, 1e-4, 1e-6, 1e-6, 1e-6
"""Tolerances: volume in memory and from a file (relative), common volume (mm^3), lengths (mm), angles (deg)."""


class Check(NamedTuple):
    """One thing that was looked at: ``what``, of which ``solid``; lengths in mm, angles in deg, volumes in mm^3."""

    what: str
    solid: str
    expected: float
    measured: float
    unit: str
    tolerance: float

    @property
    def holds(self) -> bool:
        """Whether it is as it should be."""
        return bool(abs(self.measured - self.expected) <= self.tolerance)

    def line(self) -> str:
        """Return it in words."""
        unit = f" {self.unit}" if self.unit else ""
        return f"{self.solid}: {self.what} = {self.measured:.9g}{unit}, should be {self.expected:.9g}{unit}"


def solid(recipe: Recipe, mesh: Mesh) -> Iterator[Check]:
    """Look at a solid: closed, manifold, in one piece, its volume that of the closed form."""
    body = meshes.manifold(mesh)
    yield Check("edges that are not closed", mesh.name, 0, meshes.open_edges(mesh), "", 0)
    # the kernel gives each of several sheets that meet in a point alone a vertex of its own
    yield Check("pinched vertices", mesh.name, 0, body.num_vert() - len(mesh.vertices), "", 0)
    yield Check("pieces", mesh.name, 1, len(body.decompose()), "", 0)
    yield Check("volume", mesh.name, recipe.volume, mesh.volume, "mm^3", VOLUME * recipe.volume)


def scale(plan: Plan, mesh: Mesh) -> Iterator[Check]:
    """Measure a scale in its place on the bench: thickness by rays between its largest faces, angles of these."""
    top = next(f for f in meshes.faces(mesh) if f.normal[2] > 0)
    through = meshes.cast(mesh, meshes.samples(mesh, top.triangles).reshape(-1, 3), -top.normal)
    yield Check("thickness", mesh.name, plan.thickness, _worst(through, plan.thickness), "mm", LENGTH)
    yield from _angles(plan, mesh.name, top.normal)


def _cuts(mesh: Mesh) -> tuple[Array, Array, Array, float] | None:
    """Find the parallel oblique slots of a solid on the bench; None if there are none.

    Returns the direction of their floors (3,), the level of each along it (n,), thicknesses, and the lowest point, mm.
    """
    oblique = [f for f in meshes.faces(mesh) if np.abs(f.normal).max() < 1 - 1e-9]
    # walls that face each other; the largest such pair is what a plate lies between
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
        met = meshes.cast(mesh, points[plane].reshape(-1, 3), floor.normal)
        # a ray may leave through the mouth
        found.append(met[np.isfinite(met)])
    corners = mesh.vertices[np.unique(mesh.triangles[np.concatenate([f.triangles for f in oblique])])]
    return floor.normal, levels, np.concatenate(found), float(corners[:, 2].min())


def _levels(mesh: Mesh, face: meshes.Faces, normal: Array) -> tuple[Array, list[Index], Array]:
    """Return points in a face's triangles (n, 4, 3), which of these lie in one plane, and the planes' levels."""
    points = meshes.samples(mesh, face.triangles)
    heights = points.mean(axis=1) @ normal
    order = np.argsort(heights)
    planes = np.split(order, np.flatnonzero(np.diff(heights[order]) > LENGTH) + 1)
    return points, planes, np.array([heights[p].mean() for p in planes])


def upright(plan: Plan, mesh: Mesh, face: int) -> Mesh:
    """Return a solid on the bench with a face brought to the scaled one's place by the map between them."""
    S = BENCH @ plan.sides[face][0]
    middle = np.array([0.0, 0.0, plan.height / 2])
    triangles = mesh.triangles[:, ::-1] if np.prod(S) < 0 else mesh.triangles
    return mesh._replace(vertices=(mesh.vertices - middle) * S + middle, triangles=triangles)


def halves(plan: Plan, mesh: Mesh) -> Iterator[Mesh]:
    """Return the substrate's surface for each face with scales, that face up; of two faces the upper half's only."""
    for face in range(len(plan.sides)):
        seen = upright(plan, mesh, face)
        above = seen.vertices[seen.triangles, 2].mean(axis=1) > plan.height / 2
        yield seen._replace(triangles=seen.triangles[above]) if len(plan.sides) > 1 else seen


def slots(plan: Plan, mesh: Mesh) -> Iterator[Check]:
    """Measure the slots of the substrate on the bench: number, distance, depth, thickness and angles."""
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
    """Read theta0 and alpha from the normal (along, across, up) of a plate's upper side."""
    theta0 = degrees(np.arctan2(np.hypot(normal[0], normal[1]), normal[2]))
    alpha = degrees(np.arctan2(normal[1], -normal[0]))
    # n_Z = (sin th sin a, cos th, -sin th cos a) in the beam's x, y, z
    yield Check("theta0", name, degrees(plan.theta0), float(theta0), "deg", ANGLE)
    yield Check("alpha", name, degrees(plan.alpha), float(alpha), "deg", ANGLE / max(sin(plan.theta0), 1e-3))


def overlaps(named: Sequence[Mesh], what: str) -> Check:
    """Return the common volume of all pairs of solids."""
    bodies = [meshes.manifold(m) for m in named]
    boxes = np.array([m.bounds for m in named])
    total = 0.0
    for i in range(len(named)):
        near = (boxes[i, 0] <= boxes[:, 1]).all(1) & (boxes[:, 0] <= boxes[i, 1]).all(1)
        total += sum(abs((bodies[i] ^ bodies[j]).volume()) for j in np.flatnonzero(near) if j > i)
    return Check("common volume of all pairs", what, 0, total, "mm^3", OVERLAP)


def gap(one: Mesh, others: Sequence[Mesh], search: float) -> float:
    """Return the least distance from a solid to others, mm; ``search`` if it is more than that."""
    body = meshes.manifold(one)
    return min((float(body.min_gap(meshes.manifold(o), search)) for o in others), default=search)


def loaded(found: Trimesh, file: str, name: str, volume: float) -> Iterator[Check]:
    """Look at a solid read from a file, of so much volume; without a name at all solids of the file in one."""
    where = f"{file}, {name}" if name else file
    # solids in one STL file may touch; their surface is then closed, but not a manifold
    closed = found.is_watertight and found.is_winding_consistent if name else meshes.closed(np.asarray(found.faces))
    yield Check("watertight", where, 1, float(closed), "", 0)
    yield Check("volume", where, volume, float(found.volume), "mm^3", FILE_VOLUME * volume)


def _worst(found: Array, expected: float) -> float:
    """Return the value that is farthest from what is expected."""
    return float(found[np.abs(found - expected).argmax()]) if found.size else expected


def slits(plan: Plan, lids: Sequence[Mesh]) -> Iterator[Check]:
    """Measure the slits of the lid in its place on the bench: number, thickness and angles."""
    count = 0
    for lid in lids:
        if (seen := _cuts(lid)) is not None:
            normal, levels, thicknesses, _ = seen
            count += levels.size
            found = _worst(thicknesses, plan.slit[1])
            yield Check("thickness of slits", lid.name, plan.slit[1], found, "mm", LENGTH)
            yield from _angles(plan, lid.name, normal)
    yield Check("slits", "lid", plan.scales, count, "", 0)

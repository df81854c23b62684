"""Meshes of the substrate: one pitch with the slot of its scale, the bare bar, and several pitches in a row.

A pitch is cut along the planes z = x tan(alpha) + c, so that no scale meets a cut. Where an embedded scale takes most
of its pitch, or more, the cuts run parallel to it down to its depth, halfway between neighbours, and are such planes
below (:meth:`Geometry.front`). The back is the front moved by one pitch, node by node. Netgen makes linear tetrahedra;
middle nodes are added here, halfway along straight edges.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from math import cos, tan
from types import ModuleType
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from squama.errors import InputError, refuse
from squama.fe.geometry import Geometry
from squama.needs import need
from squama.types import Array

Index = NDArray[np.int64]

SIZE, EDGE_SIZE = 0.15, 0.02
"""Default sizes of the elements in the bulk and along the embedded scale's edges, pitches."""
GRADING = 0.5
"""Growth rate of elements with the distance from small ones (netgen's grading)."""
EDGES = np.array([(0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3)])
"""Corners of the six edges whose middles are nodes 4 to 9."""
_FACES = np.array([(1, 2, 3), (0, 3, 2), (0, 1, 3), (0, 2, 1)])
_NEAR = 1e-6
_TOO_MANY = 2_000_000
_NOT_FILLED, _PIECES, _DIFFER = "elements are missing", "the scale cuts it into pieces", "its two ends differ"


class Pitch(NamedTuple):
    """One pitch of the substrate in quadratic tetrahedra with straight edges; lengths in pitches.

    ``nodes`` (n, 3); ``tets`` (m, 10): corners, then the middles of the edges 01 12 02 03 13 23, volumes positive;
    ``front``, ``back`` (k,): nodes of the two cuts, nodes[back] = nodes[front] + (0, 0, 1); ``tied`` (j,): nodes on the
    walls of the slot; ``surface`` (q, 6): triangles of the whole boundary, cuts and slot included: corners, then the
    middles of 01 12 20, seen from outside counterclockwise; ``tab`` (i,): elements of the embedded part of the scale if
    it is meshed; it is then tied at its root only.
    """

    nodes: Array
    tets: Index
    front: Index
    back: Index
    tied: Index
    surface: Index
    tab: Index = np.empty(0, np.int64)

    @property
    def images(self) -> tuple[Index, NDArray[np.bool_], Array]:
        """Number of each node's master, whether the node is its image a pitch further, and the masters' places."""
        turned = np.zeros(len(self.nodes), bool)
        turned[self.back] = True
        master = np.cumsum(~turned) - 1
        master[self.back] = master[self.front]
        return master, turned, self.nodes[~turned]

    @property
    def shares(self) -> Array:
        """Weights (k,) of the front nodes over the bar's section: integrals of their shape functions along x and y."""
        faces = self.faces
        a, b, c = (self.nodes[self.front[faces[:, i]], :2] for i in range(3))
        areas = np.abs(np.linalg.det(np.stack([b - a, c - a], axis=1))) / 2
        # in a quadratic triangle the corners' functions integrate to nothing
        weights = np.bincount(faces[:, 3:].ravel(), np.repeat(areas / 3, 3), minlength=self.front.size)
        return np.asarray(weights / weights.sum())

    @property
    def faces(self) -> Index:
        """Triangles (q, 6) of the front, numbered among its nodes."""
        place = np.full(len(self.nodes), -1)
        place[self.front] = np.arange(self.front.size)
        faces = place[self.surface]
        return np.asarray(faces[(faces >= 0).all(axis=1)])


class Tiled(NamedTuple):
    """Pitches in a row with shared nodes.

    ``tied``: nodes of each scale's slot, ``cuts`` (n + 1, k), ``ends`` (2, k): nodes of the outer sections, which are
    the outer cuts unless plain bar is added (:mod:`squama.fe.closed`).
    """

    nodes: Array
    tets: Index
    tied: list[Index]
    cuts: Index
    ends: Index


def pitch_mesh(geometry: Geometry, size: float = SIZE, edge_size: float = EDGE_SIZE, *, tab: bool = False) -> Pitch:
    """Mesh one pitch of the substrate with the slot of scale 0 in its true thickness, cut off at the bar's sides.

    ``size``, ``edge_size``: of elements in the bulk and along the edges of the embedded scale, pitches; ``tab``: the
    embedded part of the scale (X < 0) is meshed, too; then the part of the slot with X > 0 stays open, and its walls
    are tied, with the scale's section X = 0. Refuses a scale that does not fit into a pitch, unusable sizes, and what
    the mesher cannot mesh.
    """
    geometry.check()
    pitch = _mesh(geometry, size, edge_size, tab=tab)
    if not tab:
        return pitch
    walls = pitch.nodes[pitch.surface[:, :3]].mean(axis=1)
    tied = geometry.in_slot(walls) & (geometry.local(walls)[:, 0] > -_NEAR)
    inside = geometry.in_slot(pitch.nodes[pitch.tets[:, :4]].mean(axis=1))
    return pitch._replace(tied=np.unique(pitch.surface[tied]), tab=np.flatnonzero(inside))


def bar_mesh(geometry: Geometry, size: float = SIZE) -> Pitch:
    """Mesh one pitch of the bare bar with the same cuts as :func:`pitch_mesh`; no nodes are tied."""
    return _mesh(geometry, size, None)


def tile(pitch: Pitch, n: int) -> Tiled:
    """Join n pitches (n >= 1) in a row along z."""
    master, turned, masters = pitch.images
    count, k = len(masters), np.arange(n)
    number = master + count * (k[:, None] + turned)
    # the last pitch has its own back nodes
    number[-1][pitch.back] = n * count + np.arange(pitch.back.size)
    moved = masters + np.array([0.0, 0.0, 1.0]) * k[:, None, None]
    cuts = np.concatenate([number[:, pitch.front], number[-1:, pitch.back]])
    return Tiled(
        nodes=np.concatenate([moved.reshape(-1, 3), pitch.nodes[pitch.back] + [0, 0, n - 1]]),
        tets=number[:, pitch.tets].reshape(-1, 10),
        tied=list(number[:, pitch.tied]),
        cuts=cuts,
        ends=cuts[[0, -1]],
    )


def _check_sizes(geometry: Geometry, size: float, edge_size: float) -> None:
    most = max(geometry.width, 2 * geometry.lam, 1.0)
    for name, value in (("size", size), ("edge size", edge_size)):
        if not 1e-4 <= value <= most:
            refuse(f"element {name}", f"{value:.4g} pitches", f"must be 0.0001 to {most:.4g}")
    volume, length = 2 * geometry.width * geometry.lam, 2 * geometry.beta + 2 * geometry.zeta
    count = 8 * volume / size**3 + 60 * length / edge_size
    if count > _TOO_MANY:
        refuse("element size", f"{size:.4g} pitches", f"about {count:.2g} elements", "take larger ones")


def _mesh(geometry: Geometry, size: float, edge_size: float | None, *, tab: bool = False) -> Pitch:
    _check_sizes(geometry, size, size if edge_size is None else edge_size)
    occ, meshing = need("netgen.occ"), need("netgen.meshing")
    meshing.SetMessageImportance(0)
    try:
        cell = _cell(occ, geometry, edge_size, tab=tab)
        volume = cell.mass
        mesh = occ.OCCGeometry(cell).GenerateMesh(maxh=size, grading=GRADING)
        points = np.array(mesh.Coordinates(), float)
        cells = mesh.Elements3D().NumPy()["nodes"][:, :4].astype(np.int64) - 1
    except Exception as error:
        raise _failed(" ".join(str(error).split())[:200]) from None
    corners = points[cells]
    parts = np.linalg.det(corners[:, 1:] - corners[:, :1]) / 6
    turned = parts < 0
    cells[turned] = cells[turned][:, [1, 0, 2, 3]]
    if not len(cells) or np.abs(parts).min() <= 0 or abs(np.abs(parts).sum() / volume - 1) > _NEAR:
        raise _failed(_NOT_FILLED)
    return _quadratic(geometry, points, cells, slot=edge_size is not None)


class MeshError(InputError):
    """Error for a shape that the mesher gives up with elements of a size."""


def _failed(said: str) -> MeshError:
    return MeshError(
        f"the substrate could not be meshed ({said}): take another element size, or change the scale where it comes "
        "close to the substrate's sides, its faces or its neighbour"
    )


def _cell(occ: ModuleType, geometry: Geometry, edge_size: float | None, *, tab: bool) -> Any:
    """Return the solid: a skewed prism, less the slot if an edge size is given, with front and back identified.

    With a tab the embedded part of the scale is a second solid, glued to it.
    """
    half, lam, slope = geometry.width / 2, geometry.lam, tan(geometry.alpha)
    heights = sorted({lam, lam - geometry.knee, -lam}, reverse=True)
    way = [(y, float(geometry.front(y))) for y in heights]
    way += [(y, z + 1) for y, z in reversed(way)]
    cell = _polygon(occ, [(-half, y, z - half * slope) for y, z in way])
    cell = cell.Extrude(occ.Vec(2 * half, 0, 2 * half * slope))
    if edge_size is not None:
        x, y, z = geometry.rest.axes
        beta, t = geometry.beta, geometry.thickness

        def plate(to: float) -> Any:
            around = [(-geometry.zeta, -beta), (to, -beta), (to, beta), (-geometry.zeta, beta)]
            floor = _polygon(occ, [geometry.rest.base + p * x + q * y - t / 2 * z for p, q in around])
            return floor.Extrude(occ.Vec(*map(float, t * z)))

        # long enough to cut through the scaled face over its whole thickness
        cell = cell - plate(t / tan(geometry.theta0))
    if len(cell.solids) != 1:
        raise _failed(_PIECES)
    if tab:
        cell = occ.Glue([cell, plate(0.0)])
    pairs: dict[float, dict[int, Any]] = {}
    for face in cell.faces:
        at = face.center
        place = at.z - at.x * slope - float(geometry.front(at.y))
        if abs(place - round(place)) < _NEAR:
            pairs.setdefault(round(at.y, 6), {})[round(place)] = face
    trafo = occ.gp_Trsf.Translation(occ.Vec(0, 0, 1))
    for pair in pairs.values():
        pair[0].Identify(pair[1], "pitch", occ.IdentificationType.PERIODIC, trafo)
    if edge_size is not None:
        for edge in cell.edges:
            if geometry.in_slot(np.array([[edge.center.x, edge.center.y, edge.center.z]])):
                edge.maxh = edge_size
    return cell


def _polygon(occ: ModuleType, points: Sequence[Sequence[float] | Array]) -> Any:
    corners = [occ.Pnt(*map(float, p)) for p in points]
    around = zip(corners, corners[1:] + corners[:1], strict=True)
    return occ.Face(occ.Wire([occ.Segment(p, q) for p, q in around]))


def _quadratic(geometry: Geometry, points: Array, cells: Index, *, slot: bool) -> Pitch:
    """Return the pitch with middle nodes added; find the cuts, the slot and the boundary."""
    # exact images of corners first, so that middle nodes are exact too
    low, high = _matched(geometry, points)
    points[high] = points[low] + [0.0, 0.0, 1.0]
    ends = np.sort(cells[:, EDGES].reshape(-1, 2), axis=1)
    edges, place = np.unique(ends, axis=0, return_inverse=True)
    middle = len(points) + place.reshape(-1, 6)
    nodes = np.concatenate([points, points[edges].mean(axis=1)])
    surface = _boundary(cells, middle)
    image = np.full(len(nodes), -1)
    image[low] = high
    # at a knee a triangle of the side has its corners on both parts of a cut
    flat = np.abs(_along(geometry, nodes[surface[:, :3]].mean(axis=1))[:, None] - [0.0, 1.0]) < _slack(geometry)
    on_front, on_back = (np.isin(surface[:, :3], at).all(1) & on for at, on in zip((low, high), flat.T, strict=True))
    front = np.unique(surface[on_front])
    inner = front[front >= len(points)]
    keys = {(int(a), int(b)): len(points) + i for i, (a, b) in enumerate(edges)}
    with suppress(KeyError):
        for node, (a, b) in zip(inner, image[edges[inner - len(points)]], strict=True):
            image[node] = keys[min(a, b), max(a, b)]
    back = image[front]
    if (back < 0).any() or not np.array_equal(np.sort(back), np.unique(surface[on_back])):
        raise _failed(_DIFFER)
    nodes[back] = nodes[front] + [0.0, 0.0, 1.0]
    walls = geometry.in_slot(nodes[surface[:, :3]].mean(axis=1)) & slot
    tied = np.unique(surface[walls])
    return Pitch(nodes, np.concatenate([cells, middle], axis=1), front, back, tied, surface)


def _matched(geometry: Geometry, points: Array) -> tuple[Index, Index]:
    """Return corner nodes of the front, and their images on the back in the same order."""
    from scipy.spatial import cKDTree

    place, slack = _along(geometry, points), _slack(geometry)
    low, high = np.flatnonzero(np.abs(place) < slack), np.flatnonzero(np.abs(place - 1) < slack)
    away, nearest = map(np.asarray, cKDTree(points[high]).query(points[low] + [0.0, 0.0, 1.0]))
    if low.size != high.size or np.unique(nearest).size != low.size or away.max() > _NEAR:
        raise _failed(_DIFFER)
    return low, high[nearest]


def _along(geometry: Geometry, points: Array) -> Array:
    """Return the distance (n,) of points (n, 3) behind the front along the bar, pitches."""
    return np.asarray(points[:, 2] - points[:, 0] * tan(geometry.alpha) - geometry.front(points[:, 1]))


def _slack(geometry: Geometry) -> float:
    """Return the tolerance of the distance of points from a cut along the bar, pitches."""
    return _NEAR / cos(geometry.alpha) * (1 + geometry.lean)


def _boundary(cells: Index, middle: Index) -> Index:
    """Return the boundary triangles (q, 6) with outward normals and their middle nodes: those of one element only."""
    number = np.full((4, 4), -1)
    for i, (a, b) in enumerate(EDGES):
        number[a, b] = number[b, a] = i
    triangles = np.concatenate([cells[:, f] for f in _FACES])
    middles = np.concatenate([middle[:, [number[a, b], number[b, c], number[c, a]]] for a, b, c in _FACES])
    _, first, count = np.unique(np.sort(triangles, axis=1), axis=0, return_index=True, return_counts=True)
    alone = np.sort(first[count == 1])
    return np.concatenate([triangles[alone], middles[alone]], axis=1)

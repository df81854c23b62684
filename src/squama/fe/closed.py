"""Rows of pitches that end at plane sections, as grips and supports hold them.

Where the outer cuts lean against these sections, each triangle of a cut is the base of a column along the bar, up to
the section; a column is prisms in layers, and each of them is three tetrahedra.
"""

from __future__ import annotations

from math import tan

import numpy as np

from squama.fe.geometry import Ends, Geometry
from squama.fe.mesh import EDGES, Index, Pitch, Tiled, tile
from squama.types import Array

LAYERS = 1
"""Number of layers of a column per pitch of plain bar."""


def row_mesh(pitch: Pitch, ends: Ends, n: int) -> Tiled:
    """Join n pitches in a row along z, with plain bar up to its end sections."""
    mesh = tile(pitch, n)
    if not ends.pitches:
        return mesh
    to = mesh.nodes[mesh.cuts[0]] * [1.0, 1.0, 0.0]
    to[:, 2] = ends.start + to[:, 0] * ends.slope
    for side in (0, 1):
        behind = [0.0, 0.0, side * (n + ends.pitches)]
        mesh = _extended(mesh, side, pitch.faces, to + behind, LAYERS * ends.pitches)
    return mesh


def sections(mesh: Tiled, geometry: Geometry, places: Array, at: Array) -> Array:
    """Return where points of plane sections are (m, k, 3), linear between cuts: one for each node of a cut.

    ``places`` (n, 3) of all nodes, ``at`` (m,): the sections z = x tan(alpha) + at at rest, along the scales' bases.
    """
    rows, column = np.concatenate([mesh.ends[:1], mesh.cuts, mesh.ends[1:]]), np.arange(mesh.cuts.shape[1])
    along = mesh.nodes[rows, 2] - mesh.nodes[rows, 0] * tan(geometry.alpha)
    out = []
    for z in at:
        k = (along <= z).sum(axis=0) - 1
        low, high = along[k, column], along[k + 1, column]
        share = ((z - low) / (high - low))[:, None]
        out.append((1 - share) * places[rows[k, column]] + share * places[rows[k + 1, column]])
    return np.array(out)


def _extended(mesh: Tiled, side: int, faces: Index, to: Array, layers: int) -> Tiled:
    """Return the mesh with columns from an outer cut (0 front, 1 back) to the places ``to`` (k, 3) of its nodes.

    ``faces`` (q, 6): triangles of the cut by numbers of its nodes: corners, then the middles of 01 12 20.
    """
    cut, first = mesh.cuts[-side], len(mesh.nodes)
    corners = np.unique(faces[:, :3])
    low, high = mesh.nodes[cut[corners]], to[corners]
    places = [low + (high - low) * (i / layers) for i in range(1, layers + 1)]
    number = np.full((layers + 1, cut.size), -1)
    number[0], number[1:, corners] = cut, first + np.arange(layers * corners.size).reshape(layers, -1)
    # the diagonal of a prism's side rises to the larger of its two corners, in both columns that it is part of
    a, b, c = np.sort(faces[:, :3], axis=1).T
    under, over = number[:-1], number[1:]
    parts = [(under[:, a], under[:, b], under[:, c], over[:, c]), (under[:, a], under[:, b], over[:, b], over[:, c])]
    parts.append((under[:, a], over[:, a], over[:, b], over[:, c]))
    cells = np.concatenate([np.stack(part, axis=-1).reshape(-1, 4) for part in parts])
    nodes = np.concatenate([mesh.nodes, *places])
    turned = np.linalg.det(nodes[cells[:, 1:]] - nodes[cells[:, :1]]) < 0
    cells[turned] = cells[turned][:, [1, 0, 2, 3]]
    edges, where = np.unique(np.sort(cells[:, EDGES].reshape(-1, 2), axis=1), axis=0, return_inverse=True)
    around = faces[:, [(0, 1), (1, 2), (2, 0)]].reshape(-1, 2)
    # middles on the cut are there
    middles = _middles(cut[around], cut[faces[:, 3:].ravel()])
    fresh = edges[:, 1] >= first
    middles |= _middles(edges[fresh], len(nodes) + np.arange(fresh.sum()))
    middle = np.array([middles[edge] for edge in map(tuple, edges.tolist())])[where.reshape(-1, 6)]
    end = number[-1].copy()
    end[faces[:, 3:].ravel()] = [middles[edge] for edge in map(tuple, np.sort(end[around], axis=1).tolist())]
    return mesh._replace(
        nodes=np.concatenate([nodes, nodes[edges[fresh]].mean(axis=1)]),
        tets=np.concatenate([mesh.tets, np.concatenate([cells, middle], axis=1)]),
        ends=np.stack([end, mesh.ends[1]] if side == 0 else [mesh.ends[0], end]),
    )


def _middles(edges: Index, middles: Index) -> dict[tuple[int, ...], int]:
    """Return the numbers of middle nodes by those of the ends of their edges (q, 2), the smaller one first."""
    return dict(zip(map(tuple, np.sort(edges, axis=1).tolist()), middles.tolist(), strict=True))

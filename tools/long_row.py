"""The public part with long embedded parts on two supports: `squama load` beside linear elements of all its scales.

python tools/long_row.py [--scales N ..] [--mesh SIZE EDGE]
Elements of ``examples/long_tabs.toml`` with elastic embedded parts, N scales and plain bar beside them, loaded in the
middle; supports hold the mean height of the end sections. The model has the same length, with as many cells as pitches.
Prints for each N stiffness before contact (N/m), and where scales first touch: deflection (mm) and the two scales.
"""

from __future__ import annotations

import argparse
import os
import time
from pathlib import Path
from typing import Any

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("MKL_NUM_THREADS", "1")

import numpy as np
from scipy import sparse

import squama
from squama import Beam
from squama.fe.closed import row_mesh
from squama.fe.contact import RowContact
from squama.fe.elements import Elements, Material
from squama.fe.exposed import box
from squama.fe.geometry import Geometry, geometry
from squama.fe.mesh import Index, Pitch, Tiled, pitch_mesh
from squama.fe.plate import Carried
from squama.fe.rows import Row
from squama.fe.solver import Solver
from squama.types import Array

EXAMPLE = Path(__file__).parents[1] / "examples" / "long_tabs.toml"
MESH = 0.3, 0.0625
FAR = 2.0
"""Deflection up to which contact is searched, pitches."""


def stiffness(mesh: Tiled, pitch: Pitch, shape: Geometry, n: int, tab: Material) -> Any:
    """Return the stiffness matrix of a row at rest, in E = 1 and d = 1; embedded parts are of their own material."""
    stiff = np.concatenate([pitch.tab + k * len(pitch.tets) for k in range(n)])
    parts = (np.delete(mesh.tets, stiff, axis=0), Material(1.0, shape.nu)), (mesh.tets[stiff], tab)
    out = None
    for tets, material in parts:
        elements = Elements(mesh.nodes, tets, material)
        result = elements(mesh.nodes)
        assert result.least > 0
        A = elements.matrix(result.values).tocsr()
        out = A if out is None else out + A
    return out


def mean(nodes: Index, weights: Array, size: int, axis: int) -> Array:
    """Return the row (3 size,) of the mean displacement of nodes along an axis."""
    out = np.zeros(3 * size)
    out[3 * nodes + axis] = weights / weights.sum()
    return out


def conditions(mesh: Tiled, pitch: Pitch, shape: Geometry, n: int) -> Array:
    """Return rows of displacements that are given: the middle's, the heights of both ends, four to hold rigid motions.

    The middle is the bar within half a pitch of it.
    """
    size, (near, far) = len(mesh.nodes), mesh.ends
    middle = shape.start + (n + shape.plain) / 2
    corners = mesh.tets[:, :4]
    sizes = np.abs(np.linalg.det(mesh.nodes[corners[:, 1:]] - mesh.nodes[corners[:, :1]]))
    # a quadratic element's load lies on its middle nodes
    around = np.bincount(mesh.tets[:, 4:].ravel(), np.repeat(sizes, 6), minlength=size)
    loaded = np.flatnonzero(np.abs(mesh.nodes[:, 2] - middle) < 0.5)
    x, y = mesh.nodes[near, :2].T
    turn = np.zeros(3 * size)
    turn[3 * near], turn[3 * near + 1] = pitch.shares * y, -pitch.shares * x
    ends = [mean(end, pitch.shares, size, axis) for end, axis in ((near, 1), (far, 1), (near, 0), (far, 0), (near, 2))]
    return np.array([mean(loaded, around[loaded], size, 1), *ends, turn])


def solved(pitch: Pitch, shape: Geometry, n: int, tab: Material) -> tuple[float, Array]:
    """Return the force (E d^2) and the scales' motions (6 n,) for a deflection of the middle by -1."""
    mesh = row_mesh(pitch, shape, n)
    A, C, size = stiffness(mesh, pitch, shape, n, tab), conditions(mesh, pitch, shape, n), len(mesh.nodes)
    moved = np.zeros((size, 3, 6 * n))
    for k, nodes in enumerate(mesh.tied):
        moved[nodes, :, 6 * k : 6 * k + 6] = Carried(shape.rest, mesh.nodes[nodes], k).rates(np.zeros(6), 0.0)[:, :, :6]
    moved = moved.reshape(3 * size, -1)
    free = np.setdiff1d(np.arange(3 * size), (3 * np.concatenate(mesh.tied)[:, None] + np.arange(3)).ravel())
    pushed = A @ moved
    border = sparse.csr_array(np.column_stack([pushed[free], C[:, free].T]))
    corner = np.zeros((6 * n + len(C),) * 2)
    corner[: 6 * n, : 6 * n], corner[: 6 * n, 6 * n :] = moved.T @ pushed, (C @ moved).T
    at = np.triu_indices(len(corner))
    upper = sparse.coo_array((corner[at], at), shape=corner.shape)
    inner = sparse.triu(A[free][:, free])
    matrix = sparse.csr_array(sparse.block_array([[inner, border], [None, upper]], format="csr"))
    matrix.sort_indices()
    solver = Solver(matrix, len(corner))
    try:
        S = solver.factorise(matrix.data)
    finally:
        solver.close()
    given = np.zeros(len(S))
    given[6 * n] = -1.0
    found = np.linalg.solve(S, given)
    return float(found[6 * n]), found[: 6 * n]


def touch(shape: Geometry, v: Array, n: int) -> tuple[float, int]:
    """Return the deflection (pitches) at which scales first touch, and the number of the first of the two."""
    row = Row(shape.rest, n, exposed=box(shape.eta, shape.beta, shape.thickness))
    contact = RowContact(row, 0.0)
    rest, low, high = contact.corners(0.0 * v, 0.0), 0.0, FAR
    for _ in range(20):
        s = (low + high) / 2
        low, high = (s, high) if contact.free(rest, contact.corners(s * v, 0.0)) == 1.0 else (low, s)
    at = contact.corners(low * v, 0.0).reshape(n, -1, 3)
    return low, 1 + int(np.argmin([contact.two.gap(at[i : i + 2].reshape(-1, 3)) for i in range(n - 1)]))


def main() -> None:
    """Compare the public part with elements."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scales", type=int, nargs="+", default=[5, 15])
    parser.add_argument("--mesh", type=float, nargs=2, default=MESH)
    asked = parser.parse_args()
    beam = Beam.from_toml(EXAMPLE)
    shape, d, E = geometry(beam), beam.pitch, beam.substrate.youngs_modulus
    pitch = pitch_mesh(shape, *asked.mesh, tab=True)
    for n in asked.scales:
        begun = time.process_time()
        force, v = solved(pitch, shape, n, Material(beam.modulus_ratio, beam.scale.poisson_ratio))
        s, first = touch(shape, v, n)
        cpu = time.process_time() - begun
        cells = n + shape.plain
        r = squama.load(beam, f"{1e3 * FAR * d} mm down at middle", support="simple", scales=cells, mu=0.2, points=100)
        model = float(r["F"][1] / r["travel"][1])
        bare = 48 * beam.bending_rigidity / beam.bending_C_f / (cells * d) ** 3
        share = float(r["share_e"])
        print(
            f"{n} scales, {cells} pitches, {len(pitch.tets)} elements each: {force * E * d:.5g} N/m, touch at "
            f"{1e3 * s * d:.4g} mm, scales {first} and {first + 1}; model {model:.5g} N/m, "
            f"{1e3 * share * FAR * d:.4g} mm; bare {bare:.4g} N/m; {cpu:.0f} s",
            flush=True,
        )


if __name__ == "__main__":
    main()

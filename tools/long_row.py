"""The public part with long embedded parts on two supports: `squama load` beside linear elements of all its scales.

python tools/long_row.py [--scales N ..] [--mesh SIZE EDGE]
Elements of ``examples/long_tabs.toml`` with elastic embedded parts, N scales and plain bar beside them, loaded in the
middle; supports hold the mean height of the end sections. The model has the same length and number of scales.
Prints for each N stiffness before contact (N/m), and where scales first touch: deflection (mm) and the two scales.
"""

from __future__ import annotations

import argparse
import os
import time
from pathlib import Path

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
from squama.fe.pitch_stiffness import _stiffness
from squama.fe.plate import Carried
from squama.fe.rows import Row
from squama.fe.solver import Solver
from squama.study.parts import Closed
from squama.types import Array

PUBLIC = Beam.from_toml(Path(__file__).parents[1] / "examples" / "long_tabs.toml")
MESH = 0.3, 0.0625
FAR = 2.0
"""Deflection up to which contact is searched, pitches."""


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
    middle = shape.oblique.start + (n + shape.oblique.pitches) / 2
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
    mesh = row_mesh(pitch, shape.oblique, n)
    tabs = np.concatenate([pitch.tab + k * len(pitch.tets) for k in range(n)])
    A = _stiffness(Elements(mesh.nodes, np.delete(mesh.tets, tabs, axis=0), Material(1.0, shape.nu)), mesh.nodes)
    A = A + _stiffness(Elements(mesh.nodes, mesh.tets[tabs], tab), mesh.nodes)
    C, size = conditions(mesh, pitch, shape, n), len(mesh.nodes)
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


def elements(pitch: Pitch, n: int) -> tuple[tuple[float, float], int]:
    """Return stiffness (N/m) and deflection (mm) at the first touch by elements, and the first of the two scales."""
    shape, d, E = geometry(PUBLIC), PUBLIC.pitch, PUBLIC.substrate.youngs_modulus
    force, v = solved(pitch, shape, n, Material(PUBLIC.modulus_ratio, PUBLIC.scale.poisson_ratio or 0.0))
    s, first = touch(shape, v, n)
    return (force * E * d, 1e3 * s * d), first


def model(n: int, *, everywhere: bool = False) -> tuple[float, float]:
    """Return the same by the model of a part with as many scales, or with scales in every pitch."""
    cells = n + geometry(PUBLIC).oblique.pitches
    # scales of 18 pitches touch at 4.1 mm
    most = 6e-3 * (cells / 18) ** 2
    load, support = f"{1e3 * most} mm down at middle", "simple"
    part = squama.Part(PUBLIC, load, support) if everywhere else Closed.of(PUBLIC, n, load, support, cells - n, blank=0)
    r = squama.load(part, scales=cells, mu=0.2, points=50)
    return float(r["F"][1] / r["travel"][1]), float(r["share_e"]) * 1e3 * most


def bare(n: int) -> float:
    """Return the stiffness of the bar without scales, N/m."""
    length = (n + geometry(PUBLIC).oblique.pitches) * PUBLIC.pitch
    return 48 * PUBLIC.bending_rigidity / PUBLIC.bending_C_f / length**3


def main() -> None:
    """Print the comparison for each number of scales."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scales", type=int, nargs="+", default=[5, 15])
    parser.add_argument("--mesh", type=float, nargs=2, default=MESH)
    asked = parser.parse_args()
    pitch = pitch_mesh(geometry(PUBLIC), *asked.mesh, tab=True)
    for n in asked.scales:
        begun = time.process_time()
        found, first = elements(pitch, n)
        cpu = time.process_time() - begun
        results = found, model(n), model(n, everywhere=True)
        said = [f"{k:.4g} N/m, touch at {u:.4g} mm" for k, u in results]
        long = n + geometry(PUBLIC).oblique.pitches
        print(f"{n} scales of {len(pitch.tets)} elements in {long} pitches of bar ({cpu:.0f} s):")
        print(f"elements {said[0]}, scales {first} and {first + 1}; model {said[1]}; with scales all along {said[2]};")
        print(f"bare bar {bare(n):.4g} N/m", flush=True)


if __name__ == "__main__":
    main()

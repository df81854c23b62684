"""Bending of the exposed part of a scale: modes of a solid of quadratic bricks.

It is clamped at X = 0, where the rigid embedded part begins; the modes are those of
:class:`squama.fe.exposed.Exposed`. Lengths in pitches; the modulus over that of the substrate.

The bricks have 20 nodes and 2 x 2 x 2 Gauss points, bend without locking, and lie in two layers. Of the solid's static
answers to forces along n_Z at the places where scales can touch, the leading ones are kept: with C the
compliance between these places and w their shares of edges and face, the eigenvectors of w^1/2 C w^1/2. Under a point
force the rest is missing; :data:`MODES` leave out less than a hundredth of the deflection at the plate's edges.
"""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING

import numpy as np

from squama.fe.elements import Material
from squama.fe.exposed import Exposed, sheet
from squama.types import Array

if TYPE_CHECKING:
    from scipy import sparse

MODES = 24
"""Number of static deflections of the solid kept as modes."""
LAYERS = 2
BRICKS = (12, 6)
"""Bricks along and across."""

# nodes of the brick: corners in the order of the deck's C3D8, then middles of the edges
_CORNERS = np.array(
    [(-1, -1, -1), (1, -1, -1), (1, 1, -1), (-1, 1, -1), (-1, -1, 1), (1, -1, 1), (1, 1, 1), (-1, 1, 1)]
)
_EDGES = [(0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7)]
NODES = np.concatenate([_CORNERS, [(_CORNERS[a] + _CORNERS[b]) / 2 for a, b in _EDGES]])
"""Places (20, 3) of a brick's nodes between -1 and 1."""


def shapes(at: Array) -> tuple[Array, Array]:
    """Return the shape functions (n, 20) of a brick at places (n, 3) in it, and their derivatives (n, 20, 3)."""
    r = 1 + NODES * at[:, None]
    values, rates = np.empty(r.shape[:2]), np.empty(r.shape)
    sums = (NODES * at[:, None]).sum(axis=-1)
    for a, node in enumerate(NODES):
        middle = np.flatnonzero(node == 0)
        x, y, z = r[:, a].T
        if not middle.size:
            # r s t (xi + eta + zeta - 2) / 8
            factor = sums[:, a] - 2
            values[:, a] = x * y * z * factor / 8
            for i, others in enumerate((y * z, x * z, x * y)):
                rates[:, a, i] = node[i] * others * (factor + r[:, a, i]) / 8
        else:
            (m,) = middle
            i, j = (k for k in range(3) if k != m)
            q = 1 - at[:, m] ** 2
            values[:, a] = q * r[:, a, i] * r[:, a, j] / 4
            rates[:, a, m] = -2 * at[:, m] * r[:, a, i] * r[:, a, j] / 4
            rates[:, a, i] = node[i] * q * r[:, a, j] / 4
            rates[:, a, j] = node[j] * q * r[:, a, i] / 4
    return values, rates


class Bricks:
    """Solid plate of equal bricks, :data:`LAYERS` over the thickness; ``nodes`` (n, 3), pitches, ``cells`` (m, 20)."""

    def __init__(self, eta: float, beta: float, h: float, along: int, across: int) -> None:
        self.counts = np.array([along, across, LAYERS])
        self.low = np.array([0.0, -beta, -h / 2])
        self.size = np.array([eta, 2 * beta, h]) / self.counts
        cells = np.array(list(itertools.product(*map(range, self.counts))))
        # twice the place, in bricks
        places = 2 * cells[:, None] + np.asarray(NODES + 1, np.int64)
        unique, index = np.unique(places.reshape(-1, 3), axis=0, return_inverse=True)
        self.nodes, self.cells = self.low + unique / 2 * self.size, index.reshape(-1, 20)

    def stiffness(self, material: Material) -> sparse.csc_array:
        """Return the small-strain stiffness matrix (3 n, 3 n), sparse, in E d."""
        from scipy import sparse

        lame, shear = material.lame
        D = np.zeros((6, 6))
        D[:3, :3] = lame
        D += np.diag([2 * shear] * 3 + [shear] * 3)
        g = np.array(list(itertools.product((-1, 1), repeat=3))) / np.sqrt(3)
        each = np.zeros((60, 60))
        for rates in shapes(g)[1] * (2 / self.size):
            B = np.zeros((6, 20, 3))
            for row, (i, j) in enumerate([(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2)]):
                B[row, :, i] += rates[:, j]
                if i != j:
                    B[row, :, j] += rates[:, i]
            each += B.reshape(6, 60).T @ D @ B.reshape(6, 60) * self.size.prod() / 8
        at = (3 * self.cells[:, :, None] + np.arange(3)).reshape(-1, 60)
        rows, columns = np.repeat(at, 60, axis=1).ravel(), np.tile(at, 60).ravel()
        n = 3 * len(self.nodes)
        return sparse.coo_array((np.tile(each.ravel(), len(at)), (rows, columns)), shape=(n, n)).tocsc()

    def at(self, points: Array) -> sparse.csr_array:
        """Return the sparse matrix (points, nodes) of the shape functions at points (k, 3) of the plate."""
        from scipy import sparse

        place = (points - self.low) / self.size
        cell = np.clip(np.floor(place).astype(np.int64), 0, self.counts - 1)
        number = np.ravel_multi_index(tuple(cell.T), tuple(self.counts))
        values, _ = shapes(2 * (place - cell) - 1)
        rows = np.repeat(np.arange(len(points)), 20)
        shape = (len(points), len(self.nodes))
        return sparse.coo_array((values.ravel(), (rows, self.cells[number].ravel())), shape=shape).tocsr()


def solid(
    eta: float,
    beta: float,
    h: float,
    material: Material,
    *,
    contact_h: float | None = None,
    bricks: tuple[int, int] = BRICKS,
    modes: int = MODES,
) -> Exposed:
    """Return an exposed part whose bending modes come from a solid of quadratic bricks.

    Length ``eta``, half width ``beta`` and thickness ``h`` in pitches; ``contact_h``: thickness of the contact surface,
    0 for the middle plane, by default that of the plate; ``bricks`` along and across; ``modes``: their number.
    """
    plate = Bricks(eta, beta, h, *bricks)
    grid = lines(eta, beta, bricks)
    surface = sheet(*grid, h if contact_h is None else contact_h)
    places, shares = _touched(*grid)
    answers = _answers(plate, material, places)
    to_places = plate.at(places)
    compliance = to_places @ answers[2::3]
    root = np.sqrt(shares)
    values, axes = np.linalg.eigh(root[:, None] * (compliance + compliance.T) / 2 * root)
    kept = np.argsort(values)[::-1][:modes]
    forces = root[:, None] * axes[:, kept]
    moved = (answers @ forces).reshape(-1, 3, kept.size)
    within = np.clip(surface.points, [0, -beta, -h / 2], [eta, beta, h / 2])
    on = plate.at(within)
    shapes_at = np.stack([on @ moved[:, axis] for axis in range(3)], axis=1)
    return surface.bending(shapes_at, forces.T @ compliance @ forces)


def mesh_error(eta: float, beta: float, h: float, material: Material) -> float:
    """Return the relative decrease of stiffness from bricks of twice the size, under a force on a corner of the tip."""
    corner, flexible = np.array([[eta, -beta, 0.0]]), []
    for along, across in (BRICKS, (BRICKS[0] // 2, BRICKS[1] // 2)):
        mesh = Bricks(eta, beta, h, along, across)
        flexible.append(float((mesh.at(corner) @ _answers(mesh, material, corner)[2::3])[0, 0]))
    return 1 - flexible[1] / flexible[0]


def lines(eta: float, beta: float, bricks: tuple[int, int]) -> tuple[Array, Array]:
    """Return the grid lines (pitches) of the contact surface along X and Y, two for each brick."""
    along, across = bricks
    return np.linspace(0, eta, 2 * along + 1), np.linspace(-beta, beta, 2 * across + 1)


def _touched(X: Array, Y: Array) -> tuple[Array, Array]:
    """Return places (k, 3) of the middle plane at which forces act, and their weights: edges above the face.

    All points of the grid's free edges, and every second one of the interior.
    """
    i, j = (v.ravel() for v in np.meshgrid(np.arange(1, X.size), np.arange(Y.size), indexing="ij"))
    edge = (i == X.size - 1) | (j == 0) | (j == Y.size - 1)
    taken = edge | ((i % 2 == 0) & (j % 2 == 0))
    i, j, edge = i[taken], j[taken], edge[taken]
    shares = np.where(edge, 1.0 / edge.sum(), 0.1 / max(1, (~edge).sum()))
    return np.column_stack([X[i], Y[j], np.zeros(i.size)]), shares


def _answers(plate: Bricks, material: Material, places: Array) -> Array:
    """Return the displacements (3 n, k) of the clamped plate's nodes under unit forces along n_Z at places (k, 3)."""
    from scipy.sparse.linalg import splu

    free = (3 * np.flatnonzero(plate.nodes[:, 0] > 0)[:, None] + np.arange(3)).ravel()
    K = plate.stiffness(material)[free][:, free]
    force, out = np.zeros((2, 3 * len(plate.nodes), len(places)))
    force[2::3] = plate.at(places).T.toarray()
    out[free] = splu(K.tocsc(), permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True}).solve(force[free])
    return out

"""Quadratic tetrahedra with straight edges: energy, forces and tangent of a neo-Hookean solid under a helical map.

The strain energy per volume is W = G/2 (tr C - 3 - 2 ln J) + L/2 (ln J)^2 with Lamé's constants G, L. A node may be the
image of another one: ``x = Q(phi) y + e_z`` (helical periodicity); such nodes are eliminated element by element, and
the derivatives with respect to phi come along.

Fourteen Gauss points integrate polynomials of degree 5. Four would be exact for small strains, but at the corners of an
embedded scale, where strains are singular, a small element can then be crushed between its points: it snaps through at
some twist, and no equilibrium leads on. With fourteen it resists; the whole evaluation stays below a seventh of a
Newton step.
"""

from __future__ import annotations

import functools
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from squama.needs import need

Array = NDArray[np.float64]
Index = NDArray[np.int64]


class Material(NamedTuple):
    """Young's modulus and Poisson's ratio."""

    E: float = 1.0
    nu: float = 0.25

    @property
    def lame(self) -> tuple[float, float]:
        """Lamé's constants L and G."""
        return self.E * self.nu / ((1 + self.nu) * (1 - 2 * self.nu)), self.E / (2 * (1 + self.nu))


class Turn(NamedTuple):
    """Rotation about z by which an image is turned, with its derivatives with respect to the twist per pitch."""

    Q: Array
    dQ: Array
    ddQ: Array

    @classmethod
    def at(cls, phi: float) -> Turn:
        """Clockwise about +z, as scale 1 + k is turned against scale 1."""
        c, s = np.cos(phi), np.sin(phi)
        turn = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
        rate = np.array([[-s, c, 0.0], [-c, -s, 0.0], [0.0, 0.0, 0.0]])
        return cls(turn, rate, np.diag([-c, -c, 0.0]) + np.array([[0, -s, 0], [s, 0, 0], [0, 0, 0.0]]))


class Result(NamedTuple):
    """Energy, forces on the masters (n, 3), their rates with phi, dU/dphi, d2U/dphi2, tangent values, least det F."""

    energy: float
    forces: Array
    forces_phi: Array
    torque: float
    torque_phi: float
    values: Array
    least: float


class Elements:
    """Elements of a mesh, ready to be evaluated.

    Parameters
    ----------
    nodes : (n, 3) array
        Places at rest.
    tets : (m, 10) integer array
        Corners, then the middles of the edges 01 12 02 03 13 23.
    material : Material
        Of all elements.
    master, turned : (n,) arrays, optional
        The node whose image each node is, and whether it is turned and moved by one pitch. All free if not given.

    Notes
    -----
    Masters are numbered 0 .. ``size`` - 1 by ``master``; the tangent is stored in blocks of 3 x 3 whose rows and
    columns are ``indptr`` and ``indices`` (all blocks, both triangles).
    """

    def __init__(
        self,
        nodes: Array,
        tets: Index,
        material: Material,
        master: Index | None = None,
        turned: NDArray[np.bool_] | None = None,
    ) -> None:
        n = len(nodes)
        self.tets = np.ascontiguousarray(tets, dtype=np.int64)
        self.master = np.arange(n) if master is None else np.asarray(master, np.int64)
        self.turned = np.zeros(n, bool) if turned is None else np.asarray(turned, bool)
        self.size = int(self.master.max()) + 1
        self.lame = material.lame
        self.gradients, self.volumes = _gradients(nodes, self.tets)
        self.indptr, self.indices, self._places = _pattern(self.master[self.tets], self.size)

    @property
    def blocks(self) -> int:
        """Number of 3 x 3 blocks of the tangent."""
        return int(self.indices.size)

    def __call__(self, y: Array, phi: float = 0.0, *, tangent: bool = True) -> Result:
        """Evaluate at the places ``y`` (size, 3) of the masters and a twist per pitch."""
        turn = Turn.at(phi)
        out = _compiled()(
            np.ascontiguousarray(y),
            self.tets,
            self.master,
            self.turned,
            self.gradients,
            self.volumes,
            *self.lame,
            turn.Q,
            turn.dQ,
            turn.ddQ,
            self._places if tangent else self._places[:0],
            self.blocks if tangent else 0,
        )
        energy, forces, forces_phi, torque, torque_phi, values, least = out
        return Result(float(energy), forces, forces_phi, float(torque), float(torque_phi), values, float(least))

    def matrix(self, values: Array) -> Any:
        """Return tangent values as a scipy.sparse BSR matrix of shape (3 size, 3 size)."""
        from scipy import sparse

        shape = (3 * self.size, 3 * self.size)
        return sparse.bsr_array((values, self.indices, self.indptr), shape=shape)


def stiffness(nodes: Array, tets: Index, material: Material) -> Any:
    """Return the small-strain stiffness (3 n, 3 n) of a mesh, in scipy's CSR format; degrees of freedom 3 i + axis."""
    elements = Elements(nodes, tets, material)
    return elements.matrix(elements(nodes).values).tocsr()


_EDGES = np.array([(0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3)])
# rule of degree 5 with positive weights: points (1 - 3 a, a, a, a), (1 - 3 b, b, b, b) and (c, c, 1/2 - c, 1/2 - c) in
# every order, and the weight of one point of each kind
_A, _B, _C = 0.31088591926330061, 0.09273525031089123, 0.04550370412564965
_EACH = 0.11268792571801585, 0.07349304311636195, 0.04254602077708147
_POINTS = np.concatenate(
    [
        *(np.full((4, 4), a) + (1 - 4 * a) * np.eye(4) for a in (_A, _B)),
        [[_C if k in pair else 0.5 - _C for k in range(4)] for pair in _EDGES],
    ]
)
"""Corner coordinates of the Gauss points."""
_WEIGHTS = np.repeat(_EACH, [4, 4, 6])
"""Their shares of an element's volume."""


def _gradients(nodes: Array, tets: Index) -> tuple[Array, Array]:
    """Gradients of the corner coordinates (m, 4, 3), and volumes; positive, or the mesh is not usable."""
    corners = nodes[tets[:, :4]]
    edges = corners[:, 1:] - corners[:, :1]
    volumes = np.linalg.det(edges) / 6
    if not (volumes > 0).all():
        message = f"{int((volumes <= 0).sum())} elements have no volume"
        raise ValueError(message)
    inner = np.linalg.inv(edges).transpose(0, 2, 1)
    return np.ascontiguousarray(np.concatenate([-inner.sum(1, keepdims=True), inner], axis=1)), volumes


def _pattern(cells: Index, size: int) -> tuple[NDArray[np.int32], NDArray[np.int32], NDArray[np.int32]]:
    """Rows and columns of the blocks, and the place of every element's 100 blocks among them."""
    m = len(cells)
    keys = (cells[:, :, None] * size + cells[:, None, :]).reshape(-1)
    unique, places = np.unique(keys, return_inverse=True)
    rows = unique // size
    indptr = np.concatenate([[0], np.cumsum(np.bincount(rows, minlength=size))])
    shape = (m, 10, 10)
    return indptr.astype(np.int32), (unique % size).astype(np.int32), places.reshape(shape).astype(np.int32)


@functools.cache
def _shape() -> Array:
    """Return the derivatives of the ten shape functions with respect to the corner coordinates, (points, 10, 4)."""
    out = np.zeros((len(_POINTS), 10, 4))
    for q, at in enumerate(_POINTS):
        for a in range(4):
            out[q, a, a] = 4 * at[a] - 1
        for e, (i, j) in enumerate(_EDGES):
            out[q, 4 + e, i], out[q, 4 + e, j] = 4 * at[j], 4 * at[i]
    return out


@functools.cache
def _compiled() -> Any:
    njit = need("numba").njit
    shape, shares = _shape(), _WEIGHTS

    @njit(cache=True, error_model="numpy", fastmath={"contract", "nsz", "arcp"})
    def evaluate(  # type: ignore[no-untyped-def]
        y, tets, master, turned, gradients, volumes, L, G, Q, dQ, ddQ, places, blocks
    ):
        energy, torque, torque_phi, least = 0.0, 0.0, 0.0, np.inf
        forces, forces_phi = np.zeros(y.shape), np.zeros(y.shape)
        values = np.zeros((blocks, 3, 3))
        x, dx, ddx = np.empty((10, 3)), np.empty((10, 3)), np.empty((10, 3))
        g, t, f, K = np.empty((10, 3)), np.empty((10, 3)), np.empty((10, 3)), np.empty((10, 10, 3, 3))
        F, inv, B = np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3))
        for e in range(tets.shape[0]):
            any_turned = False
            for a in range(10):
                node = tets[e, a]
                at = master[node]
                if turned[node]:
                    any_turned = True
                    for i in range(3):
                        x[a, i], dx[a, i], ddx[a, i] = 1.0 if i == 2 else 0.0, 0.0, 0.0
                        for j in range(3):
                            x[a, i] += Q[i, j] * y[at, j]
                            dx[a, i] += dQ[i, j] * y[at, j]
                            ddx[a, i] += ddQ[i, j] * y[at, j]
                else:
                    for i in range(3):
                        x[a, i], dx[a, i], ddx[a, i] = y[at, i], 0.0, 0.0
            f[:] = 0.0
            K[:] = 0.0
            for q in range(shares.size):
                weight = volumes[e] * shares[q]
                F[:] = 0.0
                for a in range(10):
                    for i in range(3):
                        g[a, i] = 0.0
                        for c in range(4):
                            g[a, i] += shape[q, a, c] * gradients[e, c, i]
                    for i in range(3):
                        for j in range(3):
                            F[i, j] += x[a, i] * g[a, j]
                J = (
                    F[0, 0] * (F[1, 1] * F[2, 2] - F[1, 2] * F[2, 1])
                    - F[0, 1] * (F[1, 0] * F[2, 2] - F[1, 2] * F[2, 0])
                    + F[0, 2] * (F[1, 0] * F[2, 1] - F[1, 1] * F[2, 0])
                )
                least = min(least, J)
                if not J > 0.0:
                    return np.inf, forces, forces_phi, 0.0, 0.0, values, J
                for i in range(3):
                    for j in range(3):
                        i1, i2, j1, j2 = (i + 1) % 3, (i + 2) % 3, (j + 1) % 3, (j + 2) % 3
                        inv[j, i] = (F[i1, j1] * F[i2, j2] - F[i1, j2] * F[i2, j1]) / J
                log = np.log(J)
                square = 0.0
                for i in range(3):
                    for j in range(3):
                        square += F[i, j] * F[i, j]
                energy += weight * (G / 2 * (square - 3.0 - 2.0 * log) + L / 2 * log * log)
                pressure = L * log - G
                for a in range(10):
                    for i in range(3):
                        t[a, i] = inv[0, i] * g[a, 0] + inv[1, i] * g[a, 1] + inv[2, i] * g[a, 2]
                for a in range(10):
                    for i in range(3):
                        f[a, i] += weight * (
                            G * (F[i, 0] * g[a, 0] + F[i, 1] * g[a, 1] + F[i, 2] * g[a, 2]) + pressure * t[a, i]
                        )
                if blocks == 0:
                    continue
                w1, w2, w3 = weight * G, -weight * pressure, weight * L
                for a in range(10):
                    for b in range(a + 1):
                        gg = w1 * (g[a, 0] * g[b, 0] + g[a, 1] * g[b, 1] + g[a, 2] * g[b, 2])
                        for i in range(3):
                            for k in range(3):
                                K[a, b, i, k] += w2 * t[a, k] * t[b, i] + w3 * t[a, i] * t[b, k]
                            K[a, b, i, i] += gg
            for a in range(10):
                at = master[tets[e, a]]
                if turned[tets[e, a]]:
                    for i in range(3):
                        torque += f[a, i] * dx[a, i]
                        torque_phi += f[a, i] * ddx[a, i]
                        for j in range(3):
                            forces[at, j] += Q[i, j] * f[a, i]
                            forces_phi[at, j] += dQ[i, j] * f[a, i]
                else:
                    for i in range(3):
                        forces[at, i] += f[a, i]
            if blocks == 0:
                continue
            for a in range(10):
                for b in range(a):
                    for i in range(3):
                        for k in range(3):
                            K[b, a, k, i] = K[a, b, i, k]
            if any_turned:
                for a in range(10):
                    node = tets[e, a]
                    at = master[node]
                    for i in range(3):
                        push = 0.0
                        for b in range(10):
                            for k in range(3):
                                push += K[a, b, i, k] * dx[b, k]
                        torque_phi += dx[a, i] * push
                        if turned[node]:
                            for j in range(3):
                                forces_phi[at, j] += Q[i, j] * push
                        else:
                            forces_phi[at, i] += push
                for a in range(10):
                    for b in range(10):
                        if turned[tets[e, a]]:
                            B[:] = 0.0
                            for i in range(3):
                                for j in range(3):
                                    for k in range(3):
                                        B[j, k] += Q[i, j] * K[a, b, i, k]
                            K[a, b] = B
                        if turned[tets[e, b]]:
                            B[:] = 0.0
                            for i in range(3):
                                for j in range(3):
                                    for k in range(3):
                                        B[i, j] += K[a, b, i, k] * Q[k, j]
                            K[a, b] = B
            for a in range(10):
                for b in range(10):
                    at = places[e, a, b]
                    for i in range(3):
                        for k in range(3):
                            values[at, i, k] += K[a, b, i, k]
        return energy, forces, forces_phi, torque, torque_phi, values, least

    return evaluate

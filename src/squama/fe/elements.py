"""Quadratic tetrahedra with straight edges: energy, forces and tangent of a neo-Hookean solid, also periodic.

The strain energy per volume is W = G/2 (tr C - 3 - 2 ln J) + L/2 (ln J)^2 with Lamé's constants G, L. A node may be the
image of another one: ``x = Q y + t`` (helical periodicity, :mod:`squama.fe.periodic`). Such nodes are eliminated by a
map outside the elements, with derivatives by the loads.

Fourteen Gauss points integrate polynomials of degree 5. Four would be exact for small strains, but at the corners of an
embedded scale, where strains are singular, a small element can then be crushed between its points: it snaps through at
some twist, and no equilibrium leads on. With fourteen it does not; they take less than a seventh of a Newton step. Per
Gauss point of the compiled loop: the shape functions' gradients g (10, 3), F = sum x_a g_a, J = det F, t_a = F^-T g_a,
and with p = L ln J - G
    f_a += w (G F g_a + p t_a)      K_ab += w (G g_a . g_b 1 - p t_b t_a^T + L t_a t_b^T).
"""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from squama.batch.keeping import kept, making, tell
from squama.fe.mesh import EDGES, Index
from squama.fe.periodic import Course, Moves, Twist
from squama.types import Array

if TYPE_CHECKING:
    from scipy import sparse


class Material(NamedTuple):
    """Isotropic material: Young's modulus over that of the substrate, and Poisson's ratio."""

    E: float = 1.0
    nu: float = 0.25

    @property
    def lame(self) -> tuple[float, float]:
        """Lamé's constants L and G."""
        return self.E * self.nu / ((1 + self.nu) * (1 - 2 * self.nu)), self.E / (2 * (1 + self.nu))


class Result(NamedTuple):
    """Energy, forces (n, 3), values of the tangent's blocks, least det F; and derivatives by the L loads.

    These are the forces' derivatives (n, 3, L), dU/dl (L,) and its derivatives (L, L) at fixed places; 0 for elements
    without periodicity.
    """

    energy: float
    forces: Array
    values: Array
    least: float
    forces_by: Array
    loads: Array
    loads_by: Array


class Blocked:
    """A tangent in 3 x 3 blocks over ``size`` nodes; ``indptr`` and ``indices`` are its rows and columns (CSR)."""

    size: int
    indptr: NDArray[np.int32]
    indices: NDArray[np.int32]
    course: Course = Twist()

    @property
    def blocks(self) -> int:
        """Number of 3 x 3 blocks of the tangent."""
        return int(self.indices.size)

    def matrix(self, values: Array) -> sparse.bsr_array:
        """Return tangent values as a scipy.sparse BSR matrix of shape (3 n, 3 n)."""
        from scipy import sparse

        shape = (3 * self.size, 3 * self.size)
        return sparse.bsr_array((values, self.indices, self.indptr), shape=shape)


class Elements(Blocked):
    """Elements of a mesh with precomputed gradients and pattern of the tangent.

    ``nodes`` (n, 3): places at rest; ``tets`` (m, 10): corners, then the middles of the edges 01 12 02 03 13 23;
    ``course``: loads of the body, by default a twist, without effect on the elements themselves.
    """

    def __init__(self, nodes: Array, tets: Index, material: Material, course: Course | None = None) -> None:
        self.course = course or Twist()
        self.tets = np.ascontiguousarray(tets, dtype=np.int64)
        self.size, self.lame = len(nodes), material.lame
        self.gradients, self.volumes = gradients(nodes, self.tets)
        keys = self.tets[:, :, None] * self.size + self.tets[:, None, :]
        self.indptr, self.indices, places = _pattern(keys.ravel(), self.size)
        self._places = places.reshape(keys.shape)

    def __call__(self, y: Array, loads: Array | None = None, *, tangent: bool = True) -> Result:
        """Evaluate at places ``y`` (n, 3) of the nodes; loads have no effect."""
        L = 1 if loads is None else np.size(loads)
        tell(evaluate, "finite elements")
        energy, forces, values, least = evaluate(
            np.ascontiguousarray(y),
            self.tets,
            self.gradients,
            self.volumes,
            *self.lame,
            _RATES,
            _WEIGHTS,
            self._places,
            self.blocks if tangent else 0,
        )
        return Result(
            float(energy), forces, values, float(least), np.zeros((*forces.shape, L)), np.zeros(L), np.zeros((L, L))
        )


class Helical(Blocked):
    """Elements with periodic nodes, x = Q y + t, as functions of the places of the masters only.

    ``master``, ``turned`` (n,): master of each node, and whether the node is its image a pitch further (else it is the
    master itself); masters are numbered 0 .. ``size`` - 1; ``course``: moves Q and t of the images, by default a twist.
    """

    def __init__(
        self, elements: Elements, master: Index, turned: NDArray[np.bool_], course: Course | None = None
    ) -> None:
        self.course = course or Twist()
        self.elements, self.master, self.turned = elements, np.asarray(master, np.int64), np.asarray(turned, bool)
        self.size = int(self.master.max()) + 1
        rows, columns = np.repeat(np.arange(elements.size), np.diff(elements.indptr)), elements.indices
        self._by_row, self._by_column = np.flatnonzero(self.turned[rows]), np.flatnonzero(self.turned[columns])
        self.indptr, self.indices, place = _pattern(self.master[rows] * self.size + self.master[columns], self.size)
        # blocks of nodes with the same masters are added to the first of them
        _, self._first = np.unique(place, return_index=True)
        self._more = np.setdiff1d(np.arange(place.size), self._first)
        self._there = place[self._more]

    def __call__(self, y: Array, loads: Array | None = None, *, tangent: bool = True) -> Result:
        """Evaluate at places ``y`` (size, 3) of the masters and loads (L,) of the course."""
        loads = np.zeros(self.course.loads) if loads is None else loads
        moves, turned = self.course.moves(loads, np.ones(1)), self.turned
        Q, dQ = moves.Q[0], moves.dQ[0]
        r = self.elements(images(y, self.master, self.turned, moves), tangent=tangent)
        pushed, origin = r.forces[turned], y[self.master[turned]]
        moved = np.zeros((*r.forces.shape, loads.size))
        moved[turned] = np.einsum("lij,nj->nil", dQ, origin) + moves.dt[0].T
        by_load = np.einsum("ni,nil->l", pushed, moved[turned])
        second = np.einsum("ni,lmij,nj->lm", pushed, moves.ddQ[0], origin, optimize=True)
        second += moves.ddt[0] @ pushed.sum(0)
        by, values = np.zeros_like(moved), r.values
        if tangent and r.least > 0:
            flat = moved.reshape(-1, loads.size)
            by = (self.elements.matrix(values) @ flat).reshape(moved.shape)
            second += by.reshape(flat.shape).T @ flat
            values[self._by_row] = Q.T @ values[self._by_row]
            values[self._by_column] = values[self._by_column] @ Q
            more, values = values[self._more], values[self._first]
            np.add.at(values, self._there, more)
        forces_by = np.stack([self._gathered(each, Q) for each in np.moveaxis(by, -1, 0)], axis=-1)
        np.add.at(forces_by, self.master[turned], np.einsum("ni,lij->njl", pushed, dQ))
        return Result(r.energy, self._gathered(r.forces, Q), values, r.least, forces_by, by_load, second)

    def _gathered(self, forces: Array, Q: Array) -> Array:
        """Return forces (n, 3) on all nodes summed on the masters (size, 3)."""
        out, own = np.zeros((self.size, 3)), ~self.turned
        out[self.master[own]] = forces[own]
        np.add.at(out, self.master[self.turned], forces[self.turned] @ Q)
        return out


def images(y: Array, master: Index, turned: NDArray[np.bool_], moves: Moves) -> Array:
    """Return places (n, 3) of all nodes from those of the masters and the first of moves, see :class:`Helical`."""
    x = y[master]
    x[turned] = x[turned] @ moves.Q[0].T + moves.t[0]
    return x


# rule of degree 5 with positive weights: points (1 - 3 a, a, a, a), (1 - 3 b, b, b, b) and (c, c, 1/2 - c, 1/2 - c) in
# every order, and the weight of one point of each kind
_A, _B, _C = 0.31088591926330061, 0.09273525031089123, 0.04550370412564965
_EACH = 0.11268792571801585, 0.07349304311636195, 0.04254602077708147
_POINTS = np.concatenate(
    [
        *(np.full((4, 4), a) + (1 - 4 * a) * np.eye(4) for a in (_A, _B)),
        [[_C if k in pair else 0.5 - _C for k in range(4)] for pair in EDGES],
    ]
)
"""Corner coordinates of the Gauss points."""
_WEIGHTS = np.repeat(_EACH, [4, 4, 6])
"""Weights of the Gauss points, over the volume of an element."""


def gradients(nodes: Array, tets: Index) -> tuple[Array, Array]:
    """Return the gradients of the corner coordinates (m, 4, 3) and the volumes (m,), all positive or ValueError."""
    corners = nodes[tets[:, :4]]
    edges = corners[:, 1:] - corners[:, :1]
    volumes = np.linalg.det(edges) / 6
    if not (volumes > 0).all():
        message = f"{int((volumes <= 0).sum())} elements have no volume"
        raise ValueError(message)
    inner = np.linalg.inv(edges).transpose(0, 2, 1)
    return np.ascontiguousarray(np.concatenate([-inner.sum(1, keepdims=True), inner], axis=1)), volumes


def _pattern(keys: Index, size: int) -> tuple[NDArray[np.int32], NDArray[np.int32], NDArray[np.int32]]:
    """Return row pointers and columns (CSR) of the blocks with these keys (row * size + column), and keys' places."""
    unique, places = np.unique(keys, return_inverse=True)
    indptr = np.concatenate([[0], np.cumsum(np.bincount(unique // size, minlength=size))])
    return indptr.astype(np.int32), (unique % size).astype(np.int32), places.reshape(-1).astype(np.int32)


def shape_rates(points: Array) -> Array:
    """Return the derivatives (points, 10, 4) of the ten shape functions by the corner coordinates at points (.., 4)."""
    out = np.zeros((len(points), 10, 4))
    for q, at in enumerate(points):
        out[q, range(4), range(4)] = 4 * at - 1
        for e, (i, j) in enumerate(EDGES):
            out[q, 4 + e, i], out[q, 4 + e, j] = 4 * at[j], 4 * at[i]
    return out


_RATES = shape_rates(_POINTS)


# ---- the compiled loop over the elements -------------------------------------------------------------------

_FAST = {"contract", "nsz", "arcp"}


def _slopes(shape: Array, corners: Array, g: Array) -> None:
    for a in range(10):
        for i in range(3):
            g[a, i] = 0.0
            for c in range(4):
                g[a, i] += shape[a, c] * corners[c, i]


def _deform(x: Array, g: Array, F: Array, inv: Array) -> float:
    F[:] = 0.0
    for a in range(10):
        for i in range(3):
            for j in range(3):
                F[i, j] += x[a, i] * g[a, j]
    J: float = (
        F[0, 0] * (F[1, 1] * F[2, 2] - F[1, 2] * F[2, 1])
        - F[0, 1] * (F[1, 0] * F[2, 2] - F[1, 2] * F[2, 0])
        + F[0, 2] * (F[1, 0] * F[2, 1] - F[1, 1] * F[2, 0])
    )
    for i in range(3):
        for j in range(3):
            i1, i2, j1, j2 = (i + 1) % 3, (i + 2) % 3, (j + 1) % 3, (j + 2) % 3
            inv[j, i] = (F[i1, j1] * F[i2, j2] - F[i1, j2] * F[i2, j1]) / J
    return J


def _push(F: Array, inv: Array, g: Array, t: Array, f: Array, w: float, G: float, p: float) -> None:
    for a in range(10):
        for i in range(3):
            t[a, i] = inv[0, i] * g[a, 0] + inv[1, i] * g[a, 1] + inv[2, i] * g[a, 2]
    for a in range(10):
        for i in range(3):
            f[a, i] += w * (G * (F[i, 0] * g[a, 0] + F[i, 1] * g[a, 1] + F[i, 2] * g[a, 2]) + p * t[a, i])


def _stiffen(g: Array, t: Array, K: Array, w1: float, w2: float, w3: float) -> None:
    for a in range(10):
        for b in range(a + 1):
            gg = w1 * (g[a, 0] * g[b, 0] + g[a, 1] * g[b, 1] + g[a, 2] * g[b, 2])
            for i in range(3):
                for k in range(3):
                    K[a, b, i, k] += w2 * t[a, k] * t[b, i] + w3 * t[a, i] * t[b, k]
                K[a, b, i, i] += gg


def _add(K: Array, places: Array, values: Array) -> None:
    for a in range(10):
        for b in range(10):
            at = places[a, b]
            for i in range(3):
                for k in range(3):
                    values[at, i, k] += K[a, b, i, k] if b <= a else K[b, a, k, i]


slopes, deform, push, stiffen, add = map(partial(making, fastmath=_FAST), (_slopes, _deform, _push, _stiffen, _add))


def _evaluate(
    y: Array,
    tets: Array,
    gradients: Array,
    volumes: Array,
    L: float,
    G: float,
    shape: Array,
    shares: Array,
    places: Array,
    blocks: int,
) -> tuple[float, Array, Array, float]:
    energy, least = 0.0, np.inf
    forces, values = np.zeros(y.shape), np.zeros((blocks, 3, 3))
    x, g, t, f = np.empty((10, 3)), np.empty((10, 3)), np.empty((10, 3)), np.empty((10, 3))
    F, inv, K = np.empty((3, 3)), np.empty((3, 3)), np.empty((10, 10, 3, 3))
    for e in range(tets.shape[0]):
        for a in range(10):
            x[a] = y[tets[e, a]]
        f[:] = 0.0
        K[:] = 0.0
        for q in range(shares.size):
            slopes(shape[q], gradients[e], g)
            J = deform(x, g, F, inv)
            least = min(least, J)
            if not J > 0.0:
                return np.inf, forces, values, J
            log, w = np.log(J), volumes[e] * shares[q]
            energy += w * (G / 2 * ((F * F).sum() - 3.0 - 2.0 * log) + L / 2 * log * log)
            p = L * log - G
            push(F, inv, g, t, f, w, G, p)
            if blocks:
                stiffen(g, t, K, w * G, -w * p, w * L)
        for a in range(10):
            for i in range(3):
                forces[tets[e, a], i] += f[a, i]
        if blocks:
            add(K, places[e], values)
    return energy, forces, values, least


evaluate = kept(_evaluate, [Path(__file__)], fastmath=_FAST)
"""Energy, forces (n, 3), values of the tangent's blocks (empty for ``blocks`` = 0), and least det F.

``y`` (n, 3) places; ``gradients`` (m, 4, 3) of the corner coordinates; ``shape`` (points, 10, 4), ``shares`` (points,);
``places`` (m, 10, 10) of each element's blocks. Ends at the first inverted element with an energy of inf.
"""

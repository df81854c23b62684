"""The elements of a finite beam: pitches in a row, rigid scales tied in, both ends gripped; condensed onto the motions.

Unknowns of the elements are eliminated by one factorisation in each iteration, in which the scales' motions and the
twist are the border (:mod:`squama.fe.bordered`). Lengths in pitches, stresses in the substrate's Young's modulus.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from squama.errors import InputError
from squama.fe.bordered import Bordered
from squama.fe.carried import Carried, spread
from squama.fe.elements import Array, Elements, Index, Material, Result
from squama.fe.geometry import Geometry
from squama.fe.memory import available, too_large
from squama.fe.mesh import Pitch, tile
from squama.fe.plate import Rest


class Condensed(NamedTuple):
    """The beam condensed onto its motions at one state; meanings as in :class:`squama.fe.body.Reduced`."""

    s: Array
    S: Array
    s_phi: Array
    torque: float
    torque_phi: float
    energy: float
    unbalanced: float
    least: float
    follow: Callable[[Array, float], Array]

    @property
    def correction(self) -> Array:
        """Change of the free unknowns at motions that stay."""
        return self.follow(np.zeros(len(self.s)), 0.0)

    def update(self, dv: Array, dphi: float = 0.0) -> Array:
        """Return the change of the free unknowns; only until the next state is condensed."""
        return self.follow(dv, dphi)


class BeamBody:
    """Pitches in a row with rigid scales tied in, held at both ends.

    The motions are six for each scale and six for the turned end (translation and rotation vector along x, y, z), each
    in its turning frame (:mod:`squama.fe.carried`). Who walks decides which are free; the end's are zero but for u_z.

    Parameters
    ----------
    pitch : Pitch
        Mesh of one of them.
    geometry : Geometry
        What it is a mesh of.
    scales : int
        How many.

    Attributes
    ----------
    rest : (n, 3) array
        The nodes at rest.
    cuts : (N + 1, k) integer array
        Nodes of the sections between the pitches, the fixed one first.
    """

    def __init__(self, pitch: Pitch, geometry: Geometry, scales: int) -> None:
        from scipy import sparse

        mesh = tile(pitch, scales)
        self.mesh, self.rest, self.scales = mesh, mesh.nodes, scales
        count = len(pitch.images[2])
        self.cuts = np.stack([*(mesh.front + count * k for k in range(scales)), mesh.back])
        self.weights = pitch.section[1]
        self.elements = elements = Elements(mesh.nodes, mesh.tets, Material(1.0, geometry.nu))
        places = mesh.nodes
        self._rigid = [(nodes, Carried(geometry, places[nodes], k, geometry.cut)) for k, nodes in enumerate(mesh.tied)]
        # the end's frame is turned by N phi
        axis = Rest(0.0, 0.0, np.eye(3), np.zeros(3))
        self._rigid.append((mesh.back, Carried(axis, places[mesh.back], scales)))
        tied = np.concatenate([nodes for nodes, _ in self._rigid])
        fixed = np.concatenate([mesh.front, tied])
        if np.unique(fixed).size != fixed.size:
            message = "the last scale's slot meets the end section: take smaller elements"
            raise InputError(message)
        self.free = np.setdiff1d(np.arange(elements.size), fixed)
        self._heights = mesh.nodes[self.free, 2] - geometry.cut
        self._number(sparse, tied)

    @property
    def motions(self) -> int:
        """Number of motions, six for each scale and six for the turned end."""
        return 6 * (self.scales + 1)

    def _number(self, sparse: Any, tied: Index) -> None:
        """Find where the entries of the bordered matrix come from."""
        elements, m = self.elements, self.motions
        last = elements.blocks * 9
        ids = elements.matrix(np.arange(1.0, last + 1).reshape(-1, 3, 3)).tocsr()
        free = _components(self.free)
        among = ids[free]
        self._tied = _components(tied)
        self._tt = ids[self._tied][:, self._tied].tocsr()
        # each body moves the rows beside it: the border's blocks of six columns, and the last column of all
        self._beside: list[tuple[Index, Any]] = []
        blocks, beside = [], []
        for nodes, _ in self._rigid:
            part = among[:, _components(nodes)].tocsr()
            rows = np.flatnonzero(np.diff(part.indptr))
            self._beside.append((rows, part[rows]))
            beside.append(rows)
            numbers = last + 1.0 + np.arange(6 * rows.size)
            where = np.repeat(rows, 6), np.tile(np.arange(6), rows.size)
            blocks.append(sparse.csr_array((numbers, where), shape=(free.size, 6)))
            last += numbers.size
        self._by_phi = np.unique(np.concatenate(beside))
        numbers = last + 1.0 + np.arange(self._by_phi.size)
        where = self._by_phi, np.zeros(self._by_phi.size, np.int64)
        blocks.append(sparse.csr_array((numbers, where), shape=(free.size, 1)))
        last += numbers.size
        m += 1
        corner = sparse.csr_array(last + 1.0 + np.arange(m * m).reshape(m, m))
        inner = sparse.triu(among[:, free])
        del ids, among
        pattern = sparse.csr_array(
            sparse.block_array([[inner, sparse.hstack(blocks)], [None, sparse.triu(corner)]], format="csr")
        )
        del inner
        pattern.sort_indices()
        self._entries = pattern.data.astype(np.int64) - 1
        self.solver = Bordered(pattern, m)
        room = available()
        if room is not None and self.solver.needs > room:
            self.close()
            raise too_large(self.scales, pattern.shape[0], self.solver.needs, room)

    @property
    def unknowns(self) -> int:
        """Number of free unknowns of the elements."""
        return 3 * self.free.size

    def start(self, rest: Array) -> Array:
        """Return the free unknowns at rest, given all nodes' places at rest."""
        return np.asarray(rest[self.free].ravel())

    def _turned(self, z: Array, phi: float, sign: int = 1) -> Array:
        """Turn free unknowns or their changes, node by node, into space (or back with sign -1); (free, 3)."""
        x, y, up = z.reshape(-1, 3).T
        angles = sign * phi * self._heights
        c, s = np.cos(angles), np.sin(angles)
        return np.column_stack([c * x + s * y, c * y - s * x, up])

    def places(self, z: Array, v: Array, phi: float) -> Array:
        """Places (size, 3) of all nodes: free unknowns z, motions v (N + 1, 6), twist per pitch phi."""
        y = np.empty((self.elements.size, 3))
        y[self.mesh.front] = self.rest[self.mesh.front]
        y[self.free] = self._turned(z, phi)
        for (nodes, rigid), motion in zip(self._rigid, v, strict=True):
            y[nodes] = rigid.places(motion, phi)
        return y

    def forces(self, z: Array, v: Array, phi: float) -> Result:
        """Evaluate the elements without a tangent."""
        return self.elements(self.places(z, v, phi), tangent=False)

    def reduce(self, z: Array, v: Array, phi: float) -> Condensed | None:
        """Condense onto the motions; None where an element is inverted.

        Parameters
        ----------
        z : (unknowns,) array
            Free unknowns: places of the free nodes, each turned back by phi times its height over the fixed end.
        v : (N + 1, 6) array
            Motions of the scales and of the end in their frames.
        phi : float
            Twist per pitch.
        """
        r = self.elements(self.places(z, v, phi))
        if not r.least > 0:
            return None
        values, n = r.values.ravel(), self.scales + 1
        J, D = self._corner(v, phi, r.forces, values)
        B = [_taken(part, values) @ rates for (_, part), rates in zip(self._beside, J, strict=True)]
        by_phi = np.zeros(self.unknowns)
        for (rows, _), b in zip(self._beside, B, strict=True):
            by_phi[rows] += b[:, 6]
        blocks = [values, *(b[:, :6].ravel() for b in B), by_phi[self._by_phi], D.ravel()]
        S = self.solver.factorise(np.concatenate(blocks)[self._entries])
        f = r.forces[self.free].ravel()
        x = self.solver.solve(f, np.zeros(len(S)))
        sums = np.zeros((n, 7))
        for i, ((nodes, _), rates, b, (rows, _)) in enumerate(zip(self._rigid, J, B, self._beside, strict=True)):
            sums[i] = rates.T @ r.forces[nodes].ravel() - b.T @ x[rows]

        def follow(dv: Array, dphi: float) -> Array:
            moved = self._turned(self.solver.solve(-f, np.append(dv, dphi)), phi, -1)
            moved[:, :2] += dphi * self._heights[:, None] * (z.reshape(-1, 3)[:, [1, 0]] * [-1.0, 1.0])
            return moved.ravel()

        return Condensed(
            s=sums[:, :6].ravel(),
            S=S[:-1, :-1],
            s_phi=S[:-1, -1],
            torque=float(sums[:, 6].sum()),
            torque_phi=float(S[-1, -1]),
            energy=r.energy,
            unbalanced=float(np.abs(f).max()),
            least=r.least,
            follow=follow,
        )

    def _corner(self, v: Array, phi: float, forces: Array, values: Array) -> tuple[list[Array], Array]:
        """Return rates (3 k, 7) of each body's nodes, and the tangent by (v, phi) at free nodes that stay."""
        from scipy import sparse

        J = [rigid.rates(m, phi).reshape(-1, 7) for (_, rigid), m in zip(self._rigid, v, strict=True)]
        all_rates, n = sparse.csr_array(sparse.block_diag(J)), len(J)
        blocks = (all_rates.T @ (_taken(self._tt, values) @ all_rates)).toarray().reshape(n, 7, n, 7)
        blocks = blocks.transpose(0, 2, 1, 3)
        for i, ((nodes, rigid), m) in enumerate(zip(self._rigid, v, strict=True)):
            blocks[i, i] += rigid.curvature(m, phi, forces[nodes])
        return J, spread(blocks)

    def turns(self, places: Array) -> Array:
        """Return the mean turn (N + 1,) of the cuts about z, in the sense of the twist, rad.

        The turn of a cut is that of the rigid motion in the plane that fits the places of its nodes best (least squares
        weighted by area), their mean place set aside, so that bowing does not count.
        """
        w = self.weights
        X, x = (at[self.cuts][..., :2] for at in (self.rest, places))
        X, x = (at - np.einsum("k,jki->ji", w, at)[:, None] for at in (X, x))
        cross = X[..., 0] * x[..., 1] - X[..., 1] * x[..., 0]
        return np.unwrap(-np.arctan2(cross @ w, (X * x).sum(-1) @ w))

    def close(self) -> None:
        """Give the solver's memory back."""
        self.solver.close()


def _components(nodes: Index) -> Index:
    return (3 * nodes[:, None] + np.arange(3)).ravel()


def _taken(ids: Any, values: Array) -> Any:
    out = ids.copy()
    out.data = values[ids.data.astype(np.int64) - 1]
    return out

"""The substrate with its scales attached: residual, tangent, and its exact condensation onto the motions and the twist.

Unknowns are the places of the free nodes and, where a section is held on average, four multipliers. They are eliminated
by one factorisation (Schur complement), in which the motions of the rigid bodies, six each, and the twist per pitch are
the border (:mod:`squama.fe.solver`). Contact acts on the small system that is left.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from squama.errors import InputError
from squama.fe.elements import Elements, Helical, Result
from squama.fe.mesh import Index
from squama.fe.plate import Carried, Row, Turn
from squama.fe.solver import Solver
from squama.types import Array


class Section:
    """Mean place of a section and its mean turn about z, which multipliers hold in the twisted frame.

    Parameters
    ----------
    nodes : (k,) integer array
        Numbers of its nodes among the masters.
    places : (k, 3) array
        Where they are at rest.
    weights : (k,) array
        Shares of the section's area.
    """

    def __init__(self, nodes: Index, places: Array, weights: Array) -> None:
        used = weights != 0
        self.nodes, self.rest, self.weights = nodes[used], places[used], weights[used] / weights.sum()
        self._radius = float(self.weights @ (self.rest[:, :2] ** 2).sum(1))
        # derivatives of x, y, z and the turn by the places: rows, and columns 3 k + axis
        k = np.arange(self.nodes.size)
        self.rows = np.repeat([0, 1, 2, 3, 3], k.size)
        self.columns = np.concatenate([3 * k, 3 * k + 1, 3 * k + 2, 3 * k, 3 * k + 1])

    def means(self, y: Array, phi: float) -> tuple[list[Array], list[Array]]:
        """Return derivatives of the four means by the places and their rates with phi; the means with two rates.

        The means (4,) at places y (k, 3) are zero where the section is held; derivatives are in the order of ``rows``.
        """
        z, w, turn = self.rest[:, 2:], self.weights, self.weights / self._radius
        # the twisted frame
        frames = [(Q @ self.rest[..., None])[..., 0] * z**n for n, Q in enumerate(Turn.at(phi * z[:, 0]))]
        # shifts are counted from the frame, the turn is linear in it
        entries = [
            np.concatenate([own * w, own * w, own * w, turn * x[:, 1], -turn * x[:, 0]])
            for own, x in zip((1, 0), frames, strict=False)
        ]
        means = [
            np.append(w @ (own * y - x), turn @ (y[:, 0] * x[:, 1] - y[:, 1] * x[:, 0]))
            for own, x in zip((1, 0, 0), frames, strict=True)
        ]
        return entries, means


class Reduced(NamedTuple):
    """A body condensed onto its motions v and the twist phi at one state.

    ``s`` (m,) and ``S`` (m, m) are the force on the motions and its tangent once the free nodes are in balance, m = 6
    for each rigid body; ``s_phi`` the rate of s with phi; ``torque`` and ``torque_phi`` the same of dU/dphi. ``energy``
    is the strain energy, ``unbalanced`` the largest force on a free node.
    ``update(dv, dphi=0)`` is the change of the free unknowns that goes with one of the motions and the twist, until the
    next state is condensed.
    """

    v: Array
    phi: float
    s: Array
    S: Array
    s_phi: Array
    torque: float
    torque_phi: float
    energy: float
    unbalanced: float
    update: Callable[..., Array]

    def linear(self, v: Array, phi: float) -> tuple[Array, Array, Array]:
        """Return the force at motions v (m,) and a twist by the tangent, and its derivatives by both."""
        return self.s + self.S @ (v - self.v) + self.s_phi * (phi - self.phi), self.S, self.s_phi


class Body:
    """Elements with rigid bodies tied in, a section that is held on average, and nodes that stay where they are.

    Parameters
    ----------
    elements : Elements or Helical
        The solid.
    rest : (n, 3) array
        Its masters at rest.
    rigid : sequence of (nodes, Carried)
        Masters tied to each rigid body, the scales first, and how they move with it.
    section : Section, optional
        Held by multipliers.
    still : (k,) integer array, optional
        Nodes that stay.
    axis : float, optional
        The free unknowns are places turned back by phi times the height over this place along z, so that predictions
        follow the twist; places in space if not given.

    Attributes
    ----------
    places_free, unknowns, motions : int
        Numbers of the free unknowns that are places, of all, and of the motions, six for each rigid body.
    """

    def __init__(
        self,
        elements: Elements | Helical,
        rest: Array,
        rigid: Sequence[tuple[Index, Carried]],
        *,
        section: Section | None = None,
        still: Index | None = None,
        axis: float | None = None,
    ) -> None:
        self.elements, self.rest, self.rigid, self.section = elements, rest, list(rigid), section
        self.still = np.empty(0, np.int64) if still is None else still
        self._tied_nodes = np.concatenate([np.empty(0, np.int64), *(nodes for nodes, _ in self.rigid)])
        fixed = np.concatenate([self.still, self._tied_nodes])
        if np.unique(fixed).size != fixed.size:
            message = "a node is tied to two things, such as the last scale and the end section: take smaller elements"
            raise InputError(message)
        self.free = np.setdiff1d(np.arange(elements.size), fixed)
        self._heights = None if axis is None else rest[self.free, 2] - axis
        self.places_free = 3 * self.free.size
        self.unknowns, self.motions = self.places_free + (4 if section is not None else 0), 6 * len(rigid)
        self._number()

    def _number(self) -> None:
        """Find where the entries of the bordered matrix come from: tangent, section, zero, border, corner."""
        from scipy import sparse

        elements, n, m = self.elements, self.unknowns, self.motions + 1
        last = elements.blocks * 9
        ids = elements.matrix(np.arange(1.0, last + 1).reshape(-1, 3, 3)).tocsr()

        def numbered(rows: Array, columns: Array, shape: tuple[int, int]) -> sparse.csr_array:
            nonlocal last
            numbers = last + 1.0 + np.arange(rows.size)
            last += rows.size
            return sparse.csr_array((numbers, (rows, columns)), shape=shape)

        free, tied = _components(self.free), _components(self._tied_nodes)
        among = ids[free]
        self._tt = ids[tied][:, tied].tocsr()
        inner = sparse.triu(among[:, free])
        if self.section is not None:
            place = np.full(elements.size, -1)
            place[self.free] = np.arange(self.free.size)
            columns = 3 * np.repeat(place[self.section.nodes], 3) + np.tile(np.arange(3), self.section.nodes.size)
            self._held = columns[self.section.columns]
            C = numbered(self.section.rows, self._held, (4, free.size))
            last += 1
            # explicit zeros stand on the multipliers' diagonal
            zeros = sparse.csr_array(np.diag(np.full(4, float(last))))
            inner = sparse.block_array([[inner, C.T], [None, zeros]])
        # each body moves the rows beside it: the border's blocks of six columns, and the last column of all
        self._beside: list[tuple[Index, Any]] = []
        blocks = []
        for nodes, _ in self.rigid:
            part = among[:, _components(nodes)].tocsr()
            rows = np.flatnonzero(np.diff(part.indptr))
            self._beside.append((rows, part[rows]))
            blocks.append(numbered(np.repeat(rows, 6), np.tile(np.arange(6), rows.size), (n, 6)))
        moved = [rows for rows, _ in self._beside] if isinstance(elements, Elements) else [np.arange(n)]
        self._by_phi = np.unique(np.concatenate(moved))
        blocks.append(numbered(self._by_phi, np.zeros_like(self._by_phi), (n, 1)))
        corner = sparse.csr_array(last + 1.0 + np.arange(m * m).reshape(m, m))
        del ids, among
        pattern = sparse.csr_array(
            sparse.block_array([[inner, sparse.hstack(blocks)], [None, sparse.triu(corner)]], format="csr")
        )
        pattern.sort_indices()
        self._entries = pattern.data.astype(np.int64) - 1
        self.solver = Solver(pattern, m, multipliers=self.section is not None)

    def start(self) -> Array:
        """Return the free unknowns at rest."""
        return np.append(self.rest[self.free].ravel(), np.zeros(self.unknowns - self.places_free))

    def _turned(self, x: Array, phi: float) -> Array:
        """Turn places or their changes (free, 3), node by node, from the twisted frame into space; back with -phi."""
        if self._heights is None:
            return x
        angles = phi * self._heights
        c, s = np.cos(angles), np.sin(angles)
        return np.column_stack([c * x[:, 0] + s * x[:, 1], c * x[:, 1] - s * x[:, 0], x[:, 2]])

    def places(self, z: Array, v: Array, phi: float) -> Array:
        """Places (n, 3) of all masters: free unknowns z, motions v (m,), twist per pitch phi."""
        y = np.empty((self.elements.size, 3))
        y[self.still] = self.rest[self.still]
        y[self.free] = self._turned(z[: self.places_free].reshape(-1, 3), phi)
        for (nodes, rigid), motion in zip(self.rigid, v.reshape(-1, 6), strict=True):
            y[nodes] = rigid.places(motion, phi)
        return y

    def reduce(self, z: Array, v: Array, phi: float) -> Reduced | None:
        """Condense onto the motions and the twist; None where an element is inverted.

        Parameters
        ----------
        z : (unknowns,) array
            Free unknowns.
        v : (m,) array
            Motions.
        phi : float
            Twist per pitch.
        """
        y = self.places(z, v, phi)
        r = self.elements(y, phi)
        if not r.least > 0:
            return None
        values, torque, torque_phi = [r.values.ravel()], r.torque, r.torque_phi
        f, by_phi = r.forces[self.free].ravel(), r.forces_phi[self.free].ravel()
        if self.section is not None:
            multipliers = z[self.places_free :]
            entries, (means, c_phi, c_second) = self.section.means(y[self.section.nodes], phi)
            values.append(np.append(entries[0], 0.0))
            by = (multipliers[self.section.rows] * derivatives for derivatives in entries)
            held, held_phi = (np.bincount(self._held, weights, minlength=self.places_free) for weights in by)
            f, by_phi = np.append(f + held, means), np.append(by_phi + held_phi, c_phi)
            torque += float(multipliers @ c_phi)
            torque_phi += float(multipliers @ c_second)
        J, D = self._corner(v, phi, r)
        D[-1, -1] += torque_phi
        B = [_taken(part, values[0]) @ rates for (_, part), rates in zip(self._beside, J, strict=True)]
        for (rows, _), b in zip(self._beside, B, strict=True):
            by_phi[rows] += b[:, 6]
        values += [*(b[:, :6].ravel() for b in B), by_phi[self._by_phi], D.ravel()]
        S = self.solver.factorise(np.concatenate(values)[self._entries])
        x = self.solver.solve(f)
        torque -= float(by_phi @ x)
        s = np.zeros((len(J), 6))
        for i, ((nodes, _), rates, b, (rows, _)) in enumerate(zip(self.rigid, J, B, self._beside, strict=True)):
            pushed = rates.T @ r.forces[nodes].ravel()
            s[i], torque = pushed[:6] - b[:, :6].T @ x[rows], torque + float(pushed[6])

        def changed(dv: Array, dphi: float = 0.0) -> Array:
            change = -(x + self.solver.spread(np.append(dv, dphi)))
            if self._heights is not None:
                moved = self._turned(change.reshape(-1, 3), -phi)
                moved[:, :2] += dphi * self._heights[:, None] * (z.reshape(-1, 3)[:, [1, 0]] * [-1.0, 1.0])
                change = moved.ravel()
            return change

        unbalanced, torque_phi = float(np.abs(f).max()), float(S[-1, -1])
        rest = torque, torque_phi, r.energy, unbalanced, changed
        return Reduced(v, phi, s.ravel(), S[:-1, :-1], S[:-1, -1], *rest)

    def _corner(self, v: Array, phi: float, r: Result) -> tuple[list[Array], Array]:
        """Return rates (3 k, 7) of each body's nodes, and the tangent by (v, phi) at free nodes that stay."""
        from scipy import sparse

        both = list(zip(self.rigid, v.reshape(-1, 6), strict=True))
        J = [rigid.rates(motion, phi).reshape(-1, 7) for (_, rigid), motion in both]
        D = np.zeros((self.motions + 1, self.motions + 1))
        if not J:
            return J, D
        parts: list[Any] = [sparse.block_diag([j[:, :6] for j in J]), sparse.coo_array(np.concatenate(J)[:, 6:])]
        rates = sparse.csr_array(sparse.hstack(parts))
        D += (rates.T @ (_taken(self._tt, r.values.ravel()) @ rates)).toarray()
        for i, (((nodes, rigid), motion), j) in enumerate(zip(both, J, strict=True)):
            part, more = slice(6 * i, 6 * i + 6), rigid.curvature(motion, phi, r.forces[nodes])
            beside = j.T @ r.forces_phi[nodes].ravel()
            D[part, part] += more[:6, :6]
            D[part, -1] += more[:6, 6] + beside[:6]
            D[-1, part] += more[6, :6] + beside[:6]
            D[-1, -1] += more[6, 6] + 2 * beside[6]
        return J, D


class Matrix:
    """A body that is a stiffness matrix (7, 7) over the motions of one scale and the twist: condensed at any state."""

    places_free = 0

    def __init__(self, K: Array) -> None:
        self._K, self._S, self._s_phi = K, K[:6, :6], K[:6, 6]

    def start(self) -> Array:
        """Return the free unknowns: none."""
        return np.empty(0)

    def places(self, z: Array, v: Array, phi: float) -> Array:  # noqa: ARG002 - as a Body's
        """Return the places of its nodes: none."""
        return np.empty((0, 3))

    def reduce(self, z: Array, v: Array, phi: float) -> Reduced:
        """Return what it opposes to motions v (6,) and a twist; exact at all others, too."""
        q = np.append(v, phi)
        pushed = self._K @ q
        energy, stays = float(q @ pushed) / 2, float(self._K[6, 6])
        s, torque = pushed[:6], float(pushed[6])
        return Reduced(v, phi, s, self._S, self._s_phi, torque, stays, energy, 0.0, lambda dv, dphi=0.0: z)  # noqa: ARG005


class Bent:
    """A body whose scales bend: behind its motions come the amplitudes of each scale's modes (fe.exposed).

    Parameters
    ----------
    body : Body or Matrix
        What carries the scales.
    stiffness : (r, r) array
        That of the modes of one scale, E d.
    scales : int
        How many scales bend.
    """

    def __init__(self, body: Body | Matrix, stiffness: Array, scales: int = 1) -> None:
        self.body, self.places_free = body, body.places_free
        self._K = np.kron(np.eye(scales), stiffness)

    def start(self) -> Array:
        """Return the free unknowns at rest."""
        return self.body.start()

    def _parts(self, v: Array) -> tuple[Array, Array]:
        return v[: v.size - len(self._K)], v[v.size - len(self._K) :]

    def places(self, z: Array, v: Array, phi: float) -> Array:
        """Return the places (n, 3) of the body's nodes."""
        return self.body.places(z, self._parts(v)[0], phi)

    def reduce(self, z: Array, v: Array, phi: float) -> Reduced | None:
        """Condense the body and add what the scales oppose to their bending; None where an element is inverted."""
        motions, a = self._parts(v)
        r = self.body.reduce(z, motions, phi)
        if r is None:
            return None
        m, pushed = motions.size, self._K @ a
        S = np.zeros((v.size, v.size))
        S[:m, :m], S[m:, m:] = r.S, self._K
        return r._replace(
            v=v, s=np.append(r.s, pushed), S=S, s_phi=np.append(r.s_phi, np.zeros(a.size)),
            energy=r.energy + float(a @ pushed) / 2,
            update=lambda dv, dphi=0.0: r.update(dv[:m], dphi),
        )  # fmt: skip


def bent(body: Body | Matrix, row: Row) -> Body | Matrix | Bent:
    """Return the body with the scales of a row on it, as far as these bend."""
    return Bent(body, row.exposed.stiffness, row.moving) if row.exposed.amplitudes else body


def ways_of(motions: Array, row: Row) -> Array:
    """Return directions in which motions (m, k) can go with those of all amplitudes behind them."""
    (m, k), r = motions.shape, row.exposed.amplitudes * row.moving
    return np.block([[motions, np.zeros((m, r))], [np.zeros((r, k)), np.eye(r)]])


def mean_turns(rest: Array, places: Array, cuts: Index, weights: Array) -> Array:
    """Return the mean turn (cuts,) of cuts about z, in the sense of the twist, rad.

    The turn of a cut (its nodes are a row of ``cuts``) is that of the rigid motion in the plane that fits the places of
    its nodes best (least squares weighted by area), their mean place set aside, so that bowing does not count.
    """
    X, x = (at[cuts][..., :2] for at in (rest, places))
    X, x = (at - np.einsum("k,jki->ji", weights, at)[:, None] for at in (X, x))
    cross = X[..., 0] * x[..., 1] - X[..., 1] * x[..., 0]
    return np.unwrap(-np.arctan2(cross @ weights, (X * x).sum(-1) @ weights))


def _components(nodes: Index) -> Index:
    return (3 * nodes[:, None] + np.arange(3)).ravel()


def _taken(ids: Any, values: Array) -> Any:
    out = ids.copy()
    out.data = values[ids.data.astype(np.int64) - 1]
    return out

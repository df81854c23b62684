"""The substrate with its scales attached: residual, tangent, and its exact condensation onto the scales' motions.

Unknowns are the places of the free nodes, the multipliers that hold the section, and six numbers a scale. The free
nodes are eliminated by one factorisation (Schur complement), which leaves a small system on which the contact acts.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from squama.fe.direct import Symmetric
from squama.fe.elements import Array, Elements, Index, Result, Turn


class Rigid(Protocol):
    """Points that move with a rigid scale whose motion is six numbers v."""

    def places(self, v: Array) -> Array:
        """Return places (n, 3)."""
        ...

    def rates(self, v: Array) -> Array:
        """Return derivatives (n, 3, 6)."""
        ...

    def curvature(self, v: Array, forces: Array) -> Array:
        """Return the second derivatives (6, 6) of ``sum(forces * places)``."""
        ...


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
        # rows of x, y, z and the turn; columns 3 k + axis
        k = np.arange(self.nodes.size)
        self.rows = np.repeat([0, 1, 2, 3, 3], k.size)
        self.columns = np.concatenate([3 * k, 3 * k + 1, 3 * k + 2, 3 * k, 3 * k + 1])

    def twisted(self, phi: float) -> tuple[Array, Array, Array]:
        """Places of the twisted frame and two derivatives, each (k, 3)."""
        z = self.rest[:, 2]
        turns = [Turn.at(phi * h) for h in z]
        x = np.einsum("kij,kj->ki", [t.Q for t in turns], self.rest)
        dx = np.einsum("kij,kj->ki", [t.dQ for t in turns], self.rest) * z[:, None]
        ddx = np.einsum("kij,kj->ki", [t.ddQ for t in turns], self.rest) * z[:, None] ** 2
        return x, dx, ddx

    def entries(self, frame: Array) -> Array:
        """Return the derivatives of the four means by the places, in the order of ``rows`` and ``columns``."""
        w, turn = self.weights, self.weights / self._radius
        return np.concatenate([w, w, w, turn * frame[:, 1], -turn * frame[:, 0]])

    def values(self, y: Array, frame: Array) -> Array:
        """Return the four means at places (k, 3), zero where the section is held; linear in the frame."""
        away = self.weights @ (y - frame)
        turn = self.weights @ (y[:, 0] * frame[:, 1] - y[:, 1] * frame[:, 0]) / self._radius
        return np.append(away, turn)


class Held(Protocol):
    """Nodes whose places are given by the twist."""

    nodes: Index

    def places(self, phi: float) -> tuple[Array, Array, Array]:
        """Return places (k, 3) and their first and second derivatives with respect to phi."""
        ...


class Reduced(NamedTuple):
    """The body condensed onto its scales' motions at one state.

    ``s`` (m,) and ``S`` (m, m) are the force on the scales and its tangent once the free nodes are in balance, m = 6 a
    scale; ``s_phi`` the rate of s with phi; ``torque`` and ``torque_phi`` the same of dU/dphi. ``energy`` is the strain
    energy, ``unbalanced`` the largest force on a free node, ``least`` the least det F.
    """

    s: Array
    S: Array
    s_phi: Array
    torque: float
    torque_phi: float
    energy: float
    unbalanced: float
    least: float
    correction: Array
    follow: Array
    follow_phi: Array

    def update(self, dv: Array, dphi: float = 0.0) -> Array:
        """Return the change of the free unknowns that goes with a change of the motions (m,) and the twist."""
        return self.correction + self.follow @ dv + self.follow_phi * dphi


class Condensed(Protocol):
    """What a walk asks of a body at one state; see :class:`Reduced`, whose arrays it need not hold."""

    @property
    def s(self) -> Array: ...  # noqa: D102
    @property
    def S(self) -> Array: ...  # noqa: D102
    @property
    def s_phi(self) -> Array: ...  # noqa: D102
    @property
    def torque(self) -> float: ...  # noqa: D102
    @property
    def energy(self) -> float: ...  # noqa: D102
    @property
    def unbalanced(self) -> float: ...  # noqa: D102
    @property
    def correction(self) -> Array: ...  # noqa: D102

    def update(self, dv: Array, dphi: float = 0.0) -> Array:
        """Return the change of the free unknowns that goes with a change of the motions and the twist."""
        ...


class Solid(Protocol):
    """What a walk asks of a body: its free nodes, places, and its condensation onto the scales' motions."""

    @property
    def free(self) -> Index: ...  # noqa: D102

    def start(self, rest: Array) -> Array:
        """Return the free unknowns at rest."""
        ...

    def places(self, z: Array, v: Array, phi: float) -> Array:
        """Return the places (n, 3) of all masters."""
        ...

    def reduce(self, z: Array, v: Array, phi: float) -> Condensed | None:
        """Condense; None where an element is inverted."""
        ...


class Body:
    """Elements with rigid scales tied in, a section that is held on average, and nodes with given places.

    Parameters
    ----------
    elements : Elements
        The solid.
    scales : sequence of (nodes, Rigid)
        Masters tied to each scale, and how they move with it.
    section : Section, optional
        Held by multipliers.
    held : Held, optional
        Nodes with given places.
    """

    def __init__(
        self,
        elements: Elements,
        scales: Sequence[tuple[Index, Rigid]],
        section: Section | None = None,
        held: Held | None = None,
    ) -> None:
        from scipy import sparse

        self.elements, self.scales, self.section, self.held = elements, list(scales), section, held
        tied = np.concatenate([np.empty(0, np.int64), *(nodes for nodes, _ in scales)])
        given = np.empty(0, np.int64) if held is None else held.nodes
        fixed = np.concatenate([tied, given])
        if np.unique(fixed).size != fixed.size:
            message = "a node is tied to two things"
            raise ValueError(message)
        self.free = np.setdiff1d(np.arange(elements.size), fixed)
        self.fixed = fixed
        numbers = np.arange(1, elements.blocks * 9 + 1, dtype=np.float64).reshape(-1, 3, 3)
        ids = elements.matrix(numbers).tocsr()
        free, rest = _components(self.free), _components(fixed)
        among = ids[free]
        self._ft, self._tt = among[:, rest].tocsr(), ids[rest][:, rest].tocsr()
        inner = sparse.triu(among[:, free])
        if section is not None:
            place = np.full(elements.size, -1)
            place[self.free] = np.arange(self.free.size)
            columns = 3 * np.repeat(place[section.nodes], 3) + np.tile(np.arange(3), section.nodes.size)
            last = elements.blocks * 9
            entries = np.arange(last + 1, last + 1 + section.rows.size)
            C = sparse.csr_array(
                (entries.astype(float), (section.rows, columns[section.columns])), shape=(4, 3 * self.free.size)
            )
            # explicit zeros stand on the multipliers' diagonal
            zeros = sparse.csr_array(np.diag(np.full(4, float(entries[-1] + 1))))
            inner = sparse.block_array([[inner, C.T], [None, zeros]])
            self._C = C
        inner = sparse.csr_array(inner)
        inner.sort_indices()
        self._entries = inner.data.astype(np.int64) - 1
        self._solver = Symmetric(inner)

    @property
    def unknowns(self) -> int:
        """Number of free unknowns."""
        return 3 * self.free.size + (4 if self.section is not None else 0)

    def start(self, rest: Array) -> Array:
        """Return the free unknowns at rest, given all masters' places at rest."""
        return np.append(rest[self.free].ravel(), np.zeros(self.unknowns - 3 * self.free.size))

    def places(self, z: Array, v: Array, phi: float) -> Array:
        """Places (size, 3) of all masters: free unknowns z, motions v (scales, 6), twist per pitch phi."""
        y = np.empty((self.elements.size, 3))
        y[self.free] = z[: 3 * self.free.size].reshape(-1, 3)
        for (nodes, rigid), motion in zip(self.scales, v, strict=True):
            y[nodes] = rigid.places(motion)
        if self.held is not None:
            y[self.held.nodes] = self.held.places(phi)[0]
        return y

    def forces(self, z: Array, v: Array, phi: float) -> Result:
        """Evaluate the elements without a tangent."""
        return self.elements(self.places(z, v, phi), phi, tangent=False)

    def reduce(self, z: Array, v: Array, phi: float) -> Reduced | None:
        """Condense onto the scales' motions; None where an element is inverted.

        Parameters
        ----------
        z : (unknowns,) array
            Free unknowns.
        v : (scales, 6) array
            Motions of the scales.
        phi : float
            Twist per pitch.
        """
        y = self.places(z, v, phi)
        r = self.elements(y, phi)
        if not r.least > 0:
            return None
        values = r.values.ravel()
        n, m = 3 * self.free.size, 6 * len(self.scales)
        J, bend = self._attach(v, r.forces)
        moved = np.zeros((self.fixed.size, 3))
        torque, torque_phi = r.torque, r.torque_phi
        if self.held is not None:
            _, rate, second = self.held.places(phi)
            count = len(self.held.nodes)
            moved[-count:] = rate
            pushes = r.forces[self.held.nodes]
            torque, torque_phi = torque + float((pushes * rate).sum()), torque_phi + float((pushes * second).sum())
        K_ft, K_tt = self._take(self._ft, values), self._take(self._tt, values)
        out = moved.ravel()
        f, f_phi = r.forces[self.free].ravel(), r.forces_phi[self.free].ravel() + K_ft @ out
        t, t_phi = r.forces[self.fixed].ravel(), r.forces_phi[self.fixed].ravel() + K_tt @ out
        torque_phi += float(out @ (K_tt @ out) + 2 * (out @ r.forces_phi[self.fixed].ravel()))
        B = np.zeros((self.unknowns, m))
        B[:n] = (K_ft @ J).toarray() if m else 0.0
        if self.section is not None:
            frame, rate, second = self.section.twisted(phi)
            where = y[self.section.nodes]
            entries, multipliers = self.section.entries(frame), z[n:]
            values = np.concatenate([values, entries, [0.0]])
            C = self._take(self._C, values)
            f = np.append(f + C.T @ multipliers, self.section.values(where, frame))
            # the turn is linear in the frame and the shift too, so their rates are values of the rate
            zero = np.zeros_like(where)
            turn_phi = self.section.entries(rate)
            turn_phi[self.section.rows < 3] = 0.0
            C_phi = self._take(self._C, np.concatenate([np.zeros(r.values.size), turn_phi, [0.0]]))
            c_phi, c_second = (
                np.append(self.section.values(zero, d)[:3], self.section.values(where, d)[3]) for d in (rate, second)
            )
            f_phi = np.append(f_phi + C_phi.T @ multipliers, c_phi)
            torque += float(multipliers @ c_phi)
            torque_phi += float(multipliers @ c_second)
        self._solver.factorise(values[self._entries])
        solved = self._solver.solve(np.column_stack([f, f_phi, B]))
        x, x_phi, X = solved[:, 0], solved[:, 1], solved[:, 2:]
        return Reduced(
            s=J.T @ t - B.T @ x,
            S=(J.T @ (K_tt @ J)).toarray() + bend - B.T @ X if m else np.zeros((0, 0)),
            s_phi=J.T @ t_phi - B.T @ x_phi,
            torque=torque - float(f_phi @ x),
            torque_phi=torque_phi - float(f_phi @ x_phi),
            energy=r.energy,
            unbalanced=float(np.abs(f).max()),
            least=r.least,
            correction=-x,
            follow=-X,
            follow_phi=-x_phi,
        )

    def _take(self, ids: Any, values: Array) -> Any:
        out = ids.copy()
        out.data = values[ids.data.astype(np.int64) - 1]
        return out

    def _attach(self, v: Array, forces: Array) -> tuple[Any, Array]:
        """Return the derivatives of the fixed nodes' places by the motions, and the forces' second-order part."""
        from scipy import sparse

        m = 6 * len(self.scales)
        bend, rows = np.zeros((m, m)), []
        for i, ((nodes, rigid), motion) in enumerate(zip(self.scales, v, strict=True)):
            part = slice(6 * i, 6 * i + 6)
            bend[part, part] = rigid.curvature(motion, forces[nodes])
            rows.append(rigid.rates(motion).reshape(-1, 6))
        given = sparse.csr_array((3 * len(self.held.nodes) if self.held else 0, 0))
        return sparse.csr_array(sparse.block_diag([*rows, given])), bend

    def close(self) -> None:
        """Give the solver's memory back."""
        self._solver.close()


def _components(nodes: Index) -> NDArray[np.int64]:
    return (3 * nodes[:, None] + np.arange(3)).ravel()

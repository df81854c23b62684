"""The substrate with its scales attached: residual, tangent, and exact condensation onto the motions and the twist.

Unknowns are the places of the free nodes and, where sections are held on average, multipliers. They are eliminated
by one factorisation (Schur complement), in which the motions of the rigid bodies, six each, and the loads per pitch
(:mod:`squama.fe.periodic`) are the border (:mod:`squama.fe.solver`). Contact acts on the small system that is left.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from squama.errors import InputError
from squama.fe.averages import Section
from squama.fe.elements import Elements, Helical, Result
from squama.fe.mesh import Index
from squama.fe.periodic import Course, Twist
from squama.fe.plate import Carried
from squama.fe.rows import Row
from squama.fe.solver import Solver
from squama.types import Array

if TYPE_CHECKING:
    from scipy import sparse


class Reduced(NamedTuple):
    """A body condensed onto its motions v and the twist phi (or the way on a path of several loads) at one state.

    ``s`` (m,) and ``S`` (m, m) are the force on the motions and its tangent with the free nodes in equilibrium, where m
    counts 6 for each rigid body and the strains of a :class:`squama.fe.periodic.Leg`; ``s_phi`` (m,) is the derivative
    of s by phi; ``torque`` is dU/dphi and ``torque_phi`` its derivative. ``energy`` is the strain energy,
    ``unbalanced`` the largest force on a free node. ``update(dv, dphi=0)`` returns the change of the free unknowns with
    the motions and the twist, and is valid until the next state is condensed.
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
        """Return the force (m,) at motions v (m,) and a twist, linearised at this state, with derivatives by both."""
        return self.s + self.S @ (v - self.v) + self.s_phi * (phi - self.phi), self.S, self.s_phi


class Body:
    """Elements with rigid bodies tied in, sections held on average, and fixed nodes.

    ``rest`` (n, 3): places of the masters at rest; ``rigid``: the masters tied to each rigid body, the scales first,
    and the kinematics of these points; ``still`` (k,): fixed nodes; ``axis``: place along z from which heights are
    counted: the free unknowns are places turned back by phi times the height, so that predictions follow the twist;
    places in space without it. ``places_free``, ``unknowns`` and ``motions`` are the numbers of free unknowns that are
    places, of all, and of the motions: six for each rigid body and the strains of the course.
    """

    def __init__(
        self,
        elements: Elements | Helical,
        rest: Array,
        rigid: Sequence[tuple[Index, Carried]],
        *,
        sections: Sequence[Section] = (),
        still: Index | None = None,
        axis: float | None = None,
    ) -> None:
        self.elements, self.rest, self.rigid, self.sections = elements, rest, list(rigid), list(sections)
        self.course, self._tied_motions = elements.course, 6 * len(self.rigid)
        self.still = np.empty(0, np.int64) if still is None else still
        self._tied_nodes = np.concatenate([np.empty(0, np.int64), *(nodes for nodes, _ in self.rigid)])
        fixed = np.concatenate([self.still, self._tied_nodes])
        if np.unique(fixed).size != fixed.size:
            message = "a node is tied to two things, such as the last scale and the end section: take smaller elements"
            raise InputError(message)
        self.free = np.setdiff1d(np.arange(elements.size), fixed)
        self._heights = None if axis is None else rest[self.free, 2] - axis
        self.places_free = 3 * self.free.size
        self._multipliers = sum(section.conditions for section in self.sections)
        self.unknowns = self.places_free + self._multipliers
        self.motions = self._tied_motions + self.course.strains
        self._number()

    def _number(self) -> None:
        """Set up the pattern of the bordered matrix and the source of each entry: tangent, section, border, corner."""
        from scipy import sparse

        elements, n, loads = self.elements, self.unknowns, self.course.loads
        m = self._tied_motions + loads
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
        count = self._multipliers
        self._held: list[tuple[Index, Index]] = []
        if count:
            place = np.full(elements.size, -1)
            place[self.free] = np.arange(self.free.size)
            first = 0
            for section in self.sections:
                columns = _components(place[section.nodes])[section.columns]
                self._held.append((first + section.rows, columns))
                first += section.conditions
            rows, columns = (np.concatenate(each) for each in zip(*self._held, strict=True))
            C = numbered(rows, columns, (count, free.size))
            last += 1
            # explicit zeros stand on the multipliers' diagonal
            zeros = sparse.csr_array(np.diag(np.full(count, float(last))))
            inner = sparse.block_array([[inner, C.T], [None, zeros]])
        # each body moves the rows beside it: the border's blocks of six columns; the last columns are the loads'
        self._beside: list[tuple[Index, sparse.csr_array]] = []
        blocks = []
        for nodes, _ in self.rigid:
            part = among[:, _components(nodes)].tocsr()
            rows = np.flatnonzero(np.diff(part.indptr))
            self._beside.append((rows, part[rows]))
            blocks.append(numbered(np.repeat(rows, 6), np.tile(np.arange(6), rows.size), (n, 6)))
        moved = [rows for rows, _ in self._beside] if isinstance(elements, Elements) else [np.arange(n)]
        multipliers = np.arange(n - self._multipliers, n)
        self._loaded = np.unique(np.concatenate([*moved, multipliers, *(columns for _, columns in self._held)]))
        count = self._loaded.size
        blocks.append(numbered(np.repeat(self._loaded, loads), np.tile(np.arange(loads), count), (n, loads)))
        corner = sparse.csr_array(last + 1.0 + np.arange(m * m).reshape(m, m))
        del ids, among
        pattern = sparse.csr_array(
            sparse.block_array([[inner, sparse.hstack(blocks)], [None, sparse.triu(corner)]], format="csr")
        )
        pattern.sort_indices()
        self._entries = pattern.data.astype(np.int64) - 1
        self.solver = Solver(pattern, m, multipliers=bool(self.sections))

    def start(self) -> Array:
        """Return the free unknowns at rest."""
        return np.append(self.rest[self.free].ravel(), np.zeros(self.unknowns - self.places_free))

    def _turned(self, x: Array, phi: float) -> Array:
        """Return places or changes (free, 3) turned node by node from the twisted frame into space; back by -phi."""
        if self._heights is None:
            return x
        angles = phi * self._heights
        c, s = np.cos(angles), np.sin(angles)
        return np.column_stack([c * x[:, 0] + s * x[:, 1], c * x[:, 1] - s * x[:, 0], x[:, 2]])

    def places(self, z: Array, v: Array, phi: float) -> Array:
        """Places (n, 3) of all masters: free unknowns z, motions v (m,), twist per pitch phi."""
        y, turn = np.empty((self.elements.size, 3)), float(self.course.at(v, phi)[-1])
        y[self.still] = self.rest[self.still]
        y[self.free] = self._turned(z[: self.places_free].reshape(-1, 3), phi)
        for (nodes, rigid), motion in zip(self.rigid, v[: self._tied_motions].reshape(-1, 6), strict=True):
            y[nodes] = rigid.places(motion, turn)
        return y

    def reduce(self, z: Array, v: Array, phi: float) -> Reduced | None:
        """Condense onto motions v (m,) and twist at free unknowns z; return None where an element is inverted."""
        loads = self.course.at(v, phi)
        y = self.places(z, v, phi)
        r = self.elements(y, loads)
        if not r.least > 0:
            return None
        L, values, by_load, second = loads.size, [r.values.ravel()], r.loads, r.loads_by
        f, forces_by = r.forces[self.free].ravel(), r.forces_by[self.free].reshape(-1, L)
        all_means, multipliers = [], z[self.places_free :]
        for section, (rows, columns) in zip(self.sections, self._held, strict=True):
            entries, entries_by, means, means_by, means_second = section.means(y[section.nodes], loads)
            values.append(entries)
            weights = multipliers[rows]
            held, *held_by = (
                np.bincount(columns, weights * each, minlength=self.places_free) for each in (entries, *entries_by.T)
            )
            f, forces_by = f + held, forces_by + np.stack(held_by, axis=1)
            all_means.append(np.column_stack([means, means_by]))
            first = rows[0]
            by_load = by_load + multipliers[first : first + section.conditions] @ means_by
            second = second + np.tensordot(multipliers[first : first + section.conditions], means_second, 1)
        if self.sections:
            stacked = np.concatenate(all_means)
            values.append(np.zeros(1))
            f, forces_by = np.append(f, stacked[:, 0]), np.concatenate([forces_by, stacked[:, 1:]])
        J, D = self._corner(v, float(loads[-1]), r)
        D[-L:, -L:] += second
        B = [_taken(part, values[0]) @ rates for (_, part), rates in zip(self._beside, J, strict=True)]
        for (rows, _), b in zip(self._beside, B, strict=True):
            forces_by[rows, -1:] += b[:, 6:]
        values += [*(b[:, :6].ravel() for b in B), forces_by[self._loaded].ravel(), D.ravel()]
        S = self.solver.factorise(np.concatenate(values)[self._entries])
        x = self.solver.solve(f)
        s = np.append(np.zeros(self._tied_motions), by_load - forces_by.T @ x)
        for i, ((nodes, _), rates, b, (rows, _)) in enumerate(zip(self.rigid, J, B, self._beside, strict=True)):
            pushed = rates.T @ r.forces[nodes].ravel()
            s[6 * i : 6 * i + 6] = pushed[:6] - b[:, :6].T @ x[rows]
            s[-1] += float(pushed[6])
        by = _by_motions(self.course, self._tied_motions, v.size + 1)

        def changed(dv: Array, dphi: float = 0.0) -> Array:
            change = -(x + self.solver.spread(by @ np.append(dv, dphi)))
            if self._heights is not None:
                own, rest = np.split(change, [self.places_free])
                moved, places = self._turned(own.reshape(-1, 3), -phi), z[: self.places_free].reshape(-1, 3)
                moved[:, :2] += dphi * self._heights[:, None] * (places[:, [1, 0]] * [-1.0, 1.0])
                change = np.append(moved.ravel(), rest)
            return change

        s, S = s @ by, by.T @ S @ by
        rest = float(s[-1]), float(S[-1, -1]), r.energy, float(np.abs(f).max()), changed
        return Reduced(v, phi, s[:-1], S[:-1, :-1], S[:-1, -1], *rest)

    def _corner(self, v: Array, phi: float, r: Result) -> tuple[list[Array], Array]:
        """Return derivatives (3 k, 7) of bodies' nodes by motions and phi, and the tangent by motions and loads.

        The tangent is at fixed free nodes. A rigid body depends on the last of the loads, a twist, only.
        """
        from scipy import sparse

        both = list(zip(self.rigid, v[: self._tied_motions].reshape(-1, 6), strict=True))
        J = [rigid.rates(motion, phi).reshape(-1, 7) for (_, rigid), motion in both]
        m, L = self._tied_motions, self.course.loads
        D = np.zeros((m + L, m + L))
        if not J:
            return J, D
        last = sparse.coo_array(np.concatenate(J)[:, 6:])
        parts: list[Any] = [sparse.block_diag([j[:, :6] for j in J]), *[sparse.coo_array(last.shape)] * (L - 1), last]
        rates = sparse.csr_array(sparse.hstack(parts))
        D += (rates.T @ (_taken(self._tt, r.values.ravel()) @ rates)).toarray()
        for i, (((nodes, rigid), motion), j) in enumerate(zip(both, J, strict=True)):
            at = np.append(np.arange(6 * i, 6 * i + 6), m + L - 1)
            beside = j.T @ r.forces_by[nodes].reshape(-1, L)
            D[np.ix_(at, at)] += rigid.curvature(motion, phi, r.forces[nodes])
            D[at, m:] += beside
            D[m:, at] += beside.T
        return J, D


def _by_motions(course: Course, tied: int, size: int) -> Array:
    """Return the derivatives (tied + L, size) of the motions of rigid bodies and the loads by motions and way."""
    by = np.zeros((tied + course.loads, size))
    by[:tied, :tied] = np.eye(tied)
    by[tied:] = course.by(size)
    return by


class Matrix:
    """A body given by a stiffness matrix over the motions of one scale and the loads, the same at all states."""

    places_free = 0

    def __init__(self, K: Array, course: Course | None = None) -> None:
        self._K, self._course = K, course or Twist()

    def start(self) -> Array:
        """Return the free unknowns at rest, an empty array."""
        return np.empty(0)

    def places(self, z: Array, v: Array, phi: float) -> Array:  # noqa: ARG002 - as a Body's
        """Return the places of the nodes, an empty array (0, 3)."""
        return np.empty((0, 3))

    def reduce(self, z: Array, v: Array, phi: float) -> Reduced:
        """Return force, torque and energy at motions v (m,) and a twist; the linearisation is exact at all states."""
        q, by = np.append(v[:6], self._course.at(v, phi)), _by_motions(self._course, 6, v.size + 1)
        pushed = self._K @ q
        energy, s, S = float(q @ pushed) / 2, pushed @ by, by.T @ self._K @ by
        rest = float(s[-1]), float(S[-1, -1]), energy, 0.0, lambda dv, dphi=0.0: z  # noqa: ARG005
        return Reduced(v, phi, s[:-1], S[:-1, :-1], S[:-1, -1], *rest)


class Bent:
    """A body whose scales bend: its motions are followed by the amplitudes of each scale's modes (fe.exposed).

    ``stiffness`` (r, r) of the modes of one scale, E d; ``scales``: number of scales that bend.
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
        """Condense the body and add the bending of the scales; return None where an element is inverted."""
        motions, a = self._parts(v)
        r = self.body.reduce(z, motions, phi)
        if r is None:
            return None
        m, pushed = motions.size, self._K @ a
        S = np.zeros((v.size, v.size))
        S[:m, :m], S[m:, m:] = r.S, self._K
        return r._replace(
            v=v,
            s=np.append(r.s, pushed),
            S=S,
            s_phi=np.append(r.s_phi, np.zeros(a.size)),
            energy=r.energy + float(a @ pushed) / 2,
            update=lambda dv, dphi=0.0: r.update(dv[:m], dphi),
        )


def bent(body: Body | Matrix, row: Row) -> Body | Matrix | Bent:
    """Return the body with the bending modes of a row's scales added, if they have any."""
    return Bent(body, row.exposed.stiffness, row.moving) if row.exposed.amplitudes else body


def ways_of(motions: Array, row: Row) -> Array:
    """Return the directions of motion (m, k), as columns, extended by one direction for each mode amplitude."""
    (m, k), r = motions.shape, row.exposed.amplitudes * row.moving
    return np.block([[motions, np.zeros((m, r))], [np.zeros((r, k)), np.eye(r)]])


def mean_turns(rest: Array, places: Array, weights: Array) -> Array:
    """Return the mean turns (m,) of sections about z, rad, positive in the sense of the twist.

    The turn of a section (its k points are a row of ``rest`` and ``places``, (m, k, 3)) is that of the rigid motion in
    the plane that fits their places best (least squares weighted by area), their mean place set aside, so that bowing
    does not count.
    """
    X, x = (at[..., :2] for at in (rest, places))
    X, x = (at - np.einsum("k,jki->ji", weights, at)[:, None] for at in (X, x))
    cross = X[..., 0] * x[..., 1] - X[..., 1] * x[..., 0]
    return np.unwrap(-np.arctan2(cross @ weights, (X * x).sum(-1) @ weights))


def _components(nodes: Index) -> Index:
    return (3 * nodes[:, None] + np.arange(3)).ravel()


def _taken(ids: sparse.csr_array, values: Array) -> sparse.csr_array:
    out = ids.copy()
    out.data = values[ids.data.astype(np.int64) - 1]
    return out

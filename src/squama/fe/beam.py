"""A finite beam of N scales in finite elements: N pitches in a row, one end fixed, the other one turned.

The end sections are the cuts of the pitches, z = x tan(alpha) + c, and are held rigidly, as in grips: they neither
warp nor change shape. The front one is fixed. The back one is turned about z by N phi, where phi is the twist per
pitch, and cannot tilt or move sideways; along z it is free to move (``ends="free"``), or stays where it was
(``"held"``, as the periodic cell keeps the length of its pitch). So the bar may bow between its ends. Every scale has
six motions.

Unknowns of the elements are eliminated by one factorisation in each iteration, in which the scales' motions are the
border (:mod:`squama.fe.bordered`). Lengths in pitches, stresses in the substrate's Young's modulus.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from squama.errors import InputError
from squama.fe.bordered import Bordered
from squama.fe.contact import DHAT, SLIP
from squama.fe.elements import Array, Elements, Index, Material, Result, Turn
from squama.fe.geometry import Geometry
from squama.fe.memory import available, check, too_large
from squama.fe.mesh import Pitch, tile
from squama.fe.plate import MOTIONS, Attached, Rest, Shape, inclination, turned
from squama.fe.row_contact import Row, RowContact
from squama.fe.walk import State, Walk

ENDS = ("free", "held")
"""What the turned end does along the axis."""
ALONG = ("phi", "T", "U_el", "W_fr", "W", "gap", "u_end", "iterations", "unbalanced")
"""What is recorded of every equilibrium; T is that of the end, energies and works are those of the whole beam."""
EACH = ("theta", *MOTIONS, "N", "f", "p", "s", "twist")
"""What is recorded of every scale: inclination and motions in the frame that turns with the section at its base, its
contact with the next one (N, f, p, s), and the twist of its pitch from cut to cut (see :meth:`BeamBody.turns`)."""
_TURN = 5
"""Place of the rotation about z among the end's motions."""


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
    solve: Callable[[Array], Array]
    turn: Array

    @property
    def correction(self) -> Array:
        """Change of the free unknowns at motions that stay."""
        return self.solve(np.zeros(len(self.s)))

    def update(self, dv: Array, dphi: float = 0.0) -> Array:
        """Return the change of the free unknowns; only until the next state is condensed."""
        return self.solve(dv + self.turn * dphi)


class BeamBody:
    """Pitches in a row with rigid scales tied in, held at both ends.

    The motions are six for each scale and six for the turned end: translation and rotation vector along x, y, z, from
    its turned place. The tangent and the forces cover them all; who walks decides which are free.

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
        self._rigid, up = [], np.array([0.0, 0.0, 1.0])
        for k, nodes in enumerate(mesh.tied):
            stand = Rest(geometry.eta, geometry.beta, geometry.axes, geometry.base + k * up)
            self._rigid.append((nodes, Attached(stand, mesh.nodes[nodes])))
        # the axis is the end's line of reference, so that its last motion is the turn
        axis = Rest(0.0, 0.0, np.eye(3), np.zeros(3))
        self._rigid.append((mesh.back, Attached(axis, mesh.nodes[mesh.back])))
        tied = np.concatenate([nodes for nodes, _ in self._rigid])
        fixed = np.concatenate([mesh.front, tied])
        if np.unique(fixed).size != fixed.size:
            message = "the last scale's slot meets the end section: take smaller elements"
            raise InputError(message)
        self.free = np.setdiff1d(np.arange(elements.size), fixed)
        self._turn = np.zeros(self.motions)
        self._turn[6 * scales + _TURN] = -scales
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
        # each body moves the rows of its neighbours: the border's blocks of six columns
        self._beside: list[tuple[Index, Any]] = []
        blocks = []
        for nodes, _ in self._rigid:
            part = among[:, _components(nodes)].tocsr()
            rows = np.flatnonzero(np.diff(part.indptr))
            self._beside.append((rows, part[rows]))
            numbers = last + 1.0 + np.arange(6 * rows.size)
            where = np.repeat(rows, 6), np.tile(np.arange(6), rows.size)
            blocks.append(sparse.csr_array((numbers, where), shape=(free.size, 6)))
            last += numbers.size
        corner = sparse.csr_array(last + 1.0 + np.arange(m * m).reshape(m, m))
        inner = sparse.triu(among[:, free])
        del ids, among
        pattern = sparse.csr_array(
            sparse.block_array([[inner, sparse.hstack(blocks)], [None, sparse.triu(corner)]], format="csr")
        )
        del inner
        pattern.sort_indices()
        self._entries = pattern.data.astype(np.int64) - 1
        self._solver = Bordered(pattern, m)
        room = available()
        if room is not None and self._solver.needs > room:
            self.close()
            raise too_large(self.scales, pattern.shape[0], self._solver.needs, room)

    @property
    def unknowns(self) -> int:
        """Number of free unknowns of the elements."""
        return 3 * self.free.size

    def start(self, rest: Array) -> Array:
        """Return the free unknowns at rest, given all nodes' places at rest."""
        return np.asarray(rest[self.free].ravel())

    def _motions(self, v: Array, phi: float) -> Array:
        return (v.ravel() + self._turn * phi).reshape(-1, 6)

    def places(self, z: Array, v: Array, phi: float) -> Array:
        """Places (size, 3) of all nodes: free unknowns z, motions v (N + 1, 6), twist per pitch phi."""
        y = np.empty((self.elements.size, 3))
        y[self.mesh.front] = self.rest[self.mesh.front]
        y[self.free] = z.reshape(-1, 3)
        for (nodes, rigid), motion in zip(self._rigid, self._motions(v, phi), strict=True):
            y[nodes] = rigid.places(motion)
        return y

    def forces(self, z: Array, v: Array, phi: float) -> Result:
        """Evaluate the elements without a tangent."""
        return self.elements(self.places(z, v, phi), tangent=False)

    def reduce(self, z: Array, v: Array, phi: float) -> Condensed | None:
        """Condense onto the motions; None where an element is inverted.

        Parameters
        ----------
        z : (unknowns,) array
            Free unknowns.
        v : (N + 1, 6) array
            Motions of the scales, and of the end from its turned place.
        phi : float
            Twist per pitch.
        """
        r = self.elements(self.places(z, v, phi))
        if not r.least > 0:
            return None
        values = r.values.ravel()
        J, D = self._corner(self._motions(v, phi), r.forces, values)
        B = [_taken(part, values) @ rates for (_, part), rates in zip(self._beside, J, strict=True)]
        S = self._solver.factorise(np.concatenate([values, *(b.ravel() for b in B), D.ravel()])[self._entries])
        f = r.forces[self.free].ravel()
        x = self._solver.solve(f, np.zeros(self.motions))
        sums = [
            rates.T @ r.forces[nodes].ravel() - b.T @ x[rows]
            for (nodes, _), rates, b, (rows, _) in zip(self._rigid, J, B, self._beside, strict=True)
        ]
        s, s_phi = np.concatenate(sums), S @ self._turn
        return Condensed(
            s=s,
            S=S,
            s_phi=s_phi,
            torque=float(self._turn @ s),
            torque_phi=float(self._turn @ s_phi),
            energy=r.energy,
            unbalanced=float(np.abs(f).max()),
            least=r.least,
            solve=lambda dv: self._solver.solve(-f, dv),
            turn=self._turn,
        )

    def _corner(self, motions: Array, forces: Array, values: Array) -> tuple[list[Array], Array]:
        """Return the rates (3 k, 6) of each body's nodes, and the tangent (m, m) by the motions at fixed free nodes."""
        from scipy import sparse

        J = [rigid.rates(v).reshape(-1, 6) for (_, rigid), v in zip(self._rigid, motions, strict=True)]
        all_rates = sparse.csr_array(sparse.block_diag(J))
        D = (all_rates.T @ (_taken(self._tt, values) @ all_rates)).toarray()
        for i, ((nodes, rigid), v) in enumerate(zip(self._rigid, motions, strict=True)):
            part = slice(6 * i, 6 * i + 6)
            D[part, part] += rigid.curvature(v, forces[nodes])
        return J, D

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
        self._solver.close()


def make_beam(
    pitch: Pitch,
    geometry: Geometry,
    scales: int,
    mu: float,
    *,
    ends: str = "free",
    hinged: bool = False,
    dhat: float = DHAT,
    slip: float = SLIP,
) -> Walk:
    """Return a finite beam at rest.

    Parameters
    ----------
    pitch, geometry : Pitch, Geometry
        Mesh of one pitch and what it is a mesh of.
    scales : int
        Number of scales and pitches, 2 or more.
    mu : float
        Coefficient of friction.
    ends : {"free", "held"}
        What the turned end does along the axis.
    hinged : bool
        Block roll and yaw of the scales.
    dhat, slip : float
        See :mod:`squama.fe.contact`.

    Returns
    -------
    Walk
        Its rows have the columns :data:`ALONG`, then N columns for each of :data:`EACH`; its torque and works are those
        of the whole beam by the twist per pitch, N times the end's torque.

    Raises
    ------
    InputError
        The memory that is free does not do.
    """
    unknowns = 3 * len(pitch.images[2]) * scales
    check(scales, unknowns)
    body = BeamBody(pitch, geometry, scales)
    row = Row(geometry, scales)
    contact = RowContact(row, mu, dhat=dhat, slip=slip)
    each = np.eye(6)[:, [0, 1, 2, 4]] if hinged else np.eye(6)
    ways = np.zeros((body.motions, each.shape[1] * scales + (ends == "free")))
    ways[: 6 * scales, : each.shape[1] * scales] = np.kron(np.eye(scales), each)
    if ends == "free":
        ways[6 * scales + 2, -1] = 1.0

    def record(walk: Walk, state: State) -> tuple[list[float], str]:
        v = state.v[:-6].reshape(-1, 6)
        N, f = np.zeros((2, scales))
        N[-1] = f[-1] = np.nan
        for pair in state.load.pairs:
            if pair.second == pair.first + 1:
                N[pair.first], f[pair.first] = pair.N, pair.f
        p, s, words = contact.places(state.v, walk.kappa)
        turns = body.turns(body.places(state.z, state.v.reshape(-1, 6), state.phi))
        # the section that a scale's base stands on lies between two cuts
        share = -geometry.cut
        local = (1 - share) * turns[:-1] + share * turns[1:]
        v = np.array([turned_back(geometry, *both) for both in zip(v, local, strict=True)])
        theta = [inclination(geometry, motion) for motion in v]
        gap = contact.contact.gap(contact.corners(state.v, state.phi), dhat)
        along = [
            state.phi, state.T / scales, state.reduced.energy, walk.W_fr, walk.W, gap, state.v[-4], state.iterations,
            state.reduced.unbalanced,
        ]  # fmt: skip
        return [*along, *theta, *v.T.ravel(), *N, *f, *p, *s, *np.diff(turns)], words

    return Walk(body, body.rest, contact, ways, record, dhat=dhat)


def turned_back(rest: Shape, v: Array, turn: float) -> Array:
    """Return a scale's motions (6,) in the frame that is turned with its section about z, rad."""
    from scipy.spatial.transform import Rotation

    A, back = rest.axes, Turn.at(turn).Q.T
    u = A @ (back @ (rest.base + v[:3] @ A) - rest.base)
    return np.append(u, Rotation.from_matrix(A @ back @ A.T @ turned(v[3:])).as_rotvec())


def _components(nodes: Index) -> Index:
    return (3 * nodes[:, None] + np.arange(3)).ravel()


def _taken(ids: Any, values: Array) -> Any:
    out = ids.copy()
    out.data = values[ids.data.astype(np.int64) - 1]
    return out

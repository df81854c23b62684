"""Frictional contact of thin rectangular scales: a barrier against touching, smoothed Coulomb friction, no passing.

The scales keep a gap between 0 and ``dhat`` by a potential that grows without bound as the gap closes (incremental
potential contact: Li et al., ACM Trans. Graph. 39, 49, 2020; computed by ipctk). Only edges on edges and corners on
faces of given pairs of scales are looked at: two flat convex plates meet in no other way. Friction follows the slip
since the last increment, with normal force and direction of the present state, so the tangent is not symmetric.
Lengths in pitches; forces in whatever unit the stiffness brings.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from squama.fe.plate import CORNERS, EDGES, FACES, Placed, Row
from squama.needs import need
from squama.types import Array

DHAT = 1e-4
"""Distance within which scales push each other off, pitches."""
SLIP = 1e-5
"""Slip within an increment up to which friction grows to its full value, pitches."""
_HALF = 4.329441541679836
"""Force at a gap of dhat / 2 over stiffness dhat^3."""
_CLOSE = 0.99
"""Fraction of the gap that a step may close before it counts as a collision."""
_CLEAR = 0.9
"""Fraction of a step to the next collision that is taken."""
_WORDS = {0: "base edge DA", 1: "side edge AB", 2: "tip edge CB", 3: "side edge DC"}


def stiffness(force: float, dhat: float) -> float:
    """Return the barrier's stiffness at which a force keeps a gap of dhat / 2."""
    return force / (_HALF * dhat**3)


class Push(NamedTuple):
    """Contact at one place of the corners (n, 3).

    ``gradient`` (n, 3) of the barrier's energy, the ``friction`` (n, 3; minus the friction forces), and the
    ``tangent`` (3 n, 3 n): derivative of gradient + friction, or None if not asked or without contact.
    """

    gradient: Array
    friction: Array
    tangent: Array | None


class Touch(NamedTuple):
    """A place where two scales touch.

    ``first`` and ``second`` number the scales, ``pair`` says the features in words (scale i is called 1 + i), ``N`` is
    the normal force, and ``p``, ``s`` the places of a contact of the tip edge of the first
    with side edge DC of the second: from the tip edge's middle towards B, and from D (NaN for others).
    """

    first: int
    second: int
    pair: str
    N: float
    p: float
    s: float


class Contact:
    """Contact of scales given by their corners, in the order D, A, B, C for each.

    Parameters
    ----------
    corners : (4 m, 3) array
        Corners of the m scales at rest.
    pairs : sequence of (int, int)
        Scales that may touch.
    mu : float
        Coefficient of friction.
    dhat, slip : float
        As :data:`DHAT` and :data:`SLIP`.
    """

    def __init__(
        self, corners: Array, pairs: Sequence[tuple[int, int]], mu: float, *, dhat: float = DHAT, slip: float = SLIP
    ) -> None:
        self._ipc = ipc = need("ipctk")
        self.mu, self.dhat, self.slip = mu, dhat, slip
        count = len(corners) // 4
        edges = [(4 * i + a, 4 * i + b) for i in range(count) for a, b in (*EDGES, (0, 2))]
        faces = [tuple(4 * i + a for a in face) for i in range(count) for face in FACES]
        self._rest = np.asfortranarray(corners, dtype=float)
        self._mesh = ipc.CollisionMesh(self._rest, _whole(edges), _whole(faces))
        self._near = ipc.Candidates()
        self._near.ee_candidates = [
            ipc.EdgeEdgeCandidate(5 * i + a, 5 * j + b) for i, j in pairs for a in range(4) for b in range(4)
        ]
        self._near.fv_candidates = [
            ipc.FaceVertexCandidate(2 * f + a, 4 * c + b)
            for i, j in pairs
            for f, c in ((i, j), (j, i))
            for a in range(2)
            for b in range(4)
        ]
        self._ccd = ipc.AdditiveCCD(conservative_rescaling=_CLOSE)
        self._friction = ipc.FrictionPotential(slip)

    def push(self, corners: Array, before: Array | None, kappa: float, *, tangent: bool = True) -> Push:
        """Evaluate barrier and friction.

        Parameters
        ----------
        corners : (n, 3) array
            Where the corners are.
        before : (n, 3) array, optional
            Where they were at the end of the last increment; no friction if not given.
        kappa : float
            Stiffness of the barrier, see :func:`stiffness`.
        """
        V = np.asfortranarray(corners)
        found = self._found(V, self.dhat)
        zero = np.zeros_like(corners)
        if len(found) == 0:
            return Push(zero, zero, None)
        barrier = self._ipc.BarrierPotential(self.dhat, kappa)
        gradient = barrier.gradient(found, self._mesh, V).reshape(-1, 3)
        H = barrier.hessian(found, self._mesh, V).toarray() if tangent else None
        friction = zero
        if before is not None and self.mu > 0:
            slide = self._ipc.TangentialCollisions()
            slide.build(self._mesh, V, found, barrier, self.mu)
            moved, since = np.asfortranarray(corners - self._rest), np.asfortranarray(corners - before)
            args = slide, self._mesh, self._rest, moved, since, barrier
            friction = -self._friction.force(*args).reshape(-1, 3)
            if tangent:
                by = self._friction.DiffWRT
                for wrt in (by.VELOCITIES, by.LAGGED_DISPLACEMENTS):
                    H -= self._friction.force_jacobian(*args, wrt).toarray()
        return Push(gradient, friction, H)

    def _found(self, V: Any, within: float) -> Any:
        found = self._ipc.NormalCollisions()
        found.build(self._near, self._mesh, V, within)
        return found

    def gap(self, corners: Array, within: float = np.inf) -> float:
        """Return the least distance of the pairs, pitches; inf where it is more than ``within``."""
        V = np.asfortranarray(corners)
        found = self._found(V, min(within, 1e3))
        return float(np.sqrt(found.compute_minimum_distance(self._mesh, V))) if len(found) else np.inf

    def free(self, start: Array, end: Array) -> float:
        """Return the fraction of a straight motion of the corners that no collision stops, 1 for all of it."""
        a, b = np.asfortranarray(start), np.asfortranarray(end)
        t = self._near.compute_collision_free_stepsize(self._mesh, a, b, 0.0, self._ccd)
        return 1.0 if t >= 1 else _CLEAR * float(t)

    def touches(self, corners: Array, kappa: float) -> list[Touch]:
        """Return the places of contact, strongest first."""
        V = np.asfortranarray(corners)
        found = self._found(V, self.dhat)
        barrier = self._ipc.BarrierPotential(self.dhat, kappa)
        out = []
        for (a, kind_a), (b, kind_b), collision in _features(found):
            ids = [i for i in collision.vertex_ids(self._mesh.edges, self._mesh.faces) if i >= 0]
            g = barrier.gradient(collision, V[ids].ravel()).reshape(-1, 3)
            N = float(np.linalg.norm(g[np.array(ids) // 4 == a].sum(0)))
            p = s = np.nan
            if (kind_a, kind_b) == ("tip edge CB", "side edge DC"):
                p, s = _along(V[4 * a : 4 * a + 4], V[4 * b : 4 * b + 4])
            out.append(Touch(a, b, f"{_named(kind_a, a)} on {_named(kind_b, b)}", N, p, s))
        return sorted(out, key=lambda t: -t.N)


def _whole(rows: Sequence[Any]) -> Any:
    return np.asfortranarray(np.array(rows, np.int32).reshape(len(rows), -1))


def _features(found: Any) -> Iterator[tuple[tuple[int, str], tuple[int, str], Any]]:
    """Yield number of the scale and kind of feature, twice, and the collision; the lower number first."""

    def edge(i: int) -> tuple[int, str]:
        return i // 5, _WORDS[i % 5]

    def corner(i: int) -> tuple[int, str]:
        return i // 4, f"corner {CORNERS[i % 4]}"

    both = [
        *((edge(c.edge0_id), edge(c.edge1_id), c) for c in found.ee_collisions),
        *((corner(c.vertex_id), edge(c.edge_id), c) for c in found.ev_collisions),
        *((corner(c.vertex0_id), corner(c.vertex1_id), c) for c in found.vv_collisions),
        *((corner(c.vertex_id), (c.face_id // 2, "the face"), c) for c in found.fv_collisions),
    ]
    for a, b, c in both:
        yield (b, a, c) if a[0] > b[0] else (a, b, c)


def _named(kind: str, scale: int) -> str:
    """Return a feature with the letters of its corners and the number of its scale, e.g. tip edge C1B1."""
    if kind == "the face":
        return f"the face of scale {1 + scale}"
    words, _, letters = kind.rpartition(" ")
    return f"{words} {''.join(f'{letter}{1 + scale}' for letter in letters)}"


def _along(first: Array, second: Array) -> tuple[float, float]:
    """Places on the tip edge of the first (from its middle, to B) and on DC of the second (from D)."""
    (_, _, B, C), (D, _, _, end) = first, second
    m, t, e = (B + C) / 2, (B - C) / np.linalg.norm(B - C), (end - D) / np.linalg.norm(end - D)
    c = t @ e
    q = D - m
    p, s = np.linalg.solve([[1.0, -c], [c, -1.0]], [q @ t, q @ e])
    return float(p), float(s)


class Pair(NamedTuple):
    """Contact of two scales: their numbers, and the normal force and friction force (3,) on the first."""

    first: int
    second: int
    normal: Array
    friction: Array

    @property
    def N(self) -> float:
        """Magnitude of the normal force."""
        return float(np.linalg.norm(self.normal))

    @property
    def f(self) -> float:
        """Magnitude of the friction force."""
        return float(np.linalg.norm(self.friction))


class Load:
    """Contact of a row at one state: minus the forces on (v, phi), in two parts, and their tangent.

    Attributes
    ----------
    normal, friction, total : (m + 1,) array
        Derivatives of the work, and their sum.
    tangent : (m + 1, m + 1) array
        Derivative of the total, not symmetric.
    push : Push or None
        The same by the corners; None without contact.
    slid : float
        Work of the present friction forces on the slip since ``before``, 0 or more.
    """

    def __init__(self, contact: RowContact, v: Array, phi: float, before: Array | None, kappa: float) -> None:
        placed = Placed(contact.row, v, phi)
        push = contact.push(placed.corners, before, kappa)
        self._contact, self._corners, self._before, self._kappa = contact, placed.corners, before, kappa
        m, self.slid = v.size + 1, 0.0
        self.push = None if push.tangent is None else push
        if push.tangent is None:
            self.normal = self.friction = self.total = np.zeros(m)
            self.tangent = np.zeros((m, m))
            return
        J = placed.rates
        self.normal, self.friction = push.gradient.ravel() @ J, push.friction.ravel() @ J
        self.total = self.normal + self.friction
        self.tangent = J.T @ push.tangent @ J + placed.curvature(push.gradient + push.friction)
        if before is not None:
            self.slid = float((push.friction * (placed.corners - before)).sum())

    @cached_property
    def pairs(self) -> list[Pair]:
        """The pairs that touch."""
        if self.push is None:
            return []
        V, before, out = self._corners.reshape(-1, 4, 3), self._before, []
        for i, j in self._contact.row.pairs:
            then = None if before is None else before.reshape(-1, 4, 3)[[i, j]].reshape(-1, 3)
            push = self._contact.two.push(V[[i, j]].reshape(-1, 3), then, self._kappa, tangent=False)
            if push.gradient.any():
                out.append(Pair(i, j, -push.gradient[:4].sum(0), -push.friction[:4].sum(0)))
        return out

    @cached_property
    def strongest(self) -> Pair:
        """The pair that presses most; without contact a scale and itself, and no forces."""
        return max(self.pairs, key=lambda p: p.N, default=Pair(0, 0, np.zeros(3), np.zeros(3)))


class RowContact(Contact):
    """Frictional contact of the scales of a row with all neighbours within reach.

    Parameters
    ----------
    row : Row
        The scales; an endless row counts per pitch.
    mu, dhat, slip : float
        As in :class:`Contact`.
    """

    def __init__(self, row: Row, mu: float, *, dhat: float = DHAT, slip: float = SLIP) -> None:
        self.row = row
        rest = self.corners(np.zeros(6 * row.moving), 0.0)
        super().__init__(rest, row.pairs, mu, dhat=dhat, slip=slip)
        # places at rest do not come in, so any two scales will do for every pair
        self.two = Contact(rest[:8], [(0, 1)], mu, dhat=dhat, slip=slip)

    def corners(self, v: Array, phi: float) -> Array:
        """Return the corners of all scales, (n, 3), scale by scale in the order D, A, B, C."""
        return Placed(self.row, v, phi).corners

    def load(self, v: Array, phi: float, before: Array | None, kappa: float) -> Load:
        """Evaluate contact; ``before`` and ``kappa`` as in :meth:`Contact.push`."""
        return Load(self, v, phi, before, kappa)


def where(touches: Iterable[Touch], scales: int) -> tuple[Array, Array, str]:
    """Return where the tip edge of each scale touches the next one, p and s (scales,), and all contacts in words.

    p and s are NaN where the tip edge of a scale does not touch the side edge of the next.
    """
    p, s = np.full(scales, np.nan), np.full(scales, np.nan)
    usual: dict[int, Touch] = {}
    others: dict[str, None] = {}
    for touch in touches:
        if touch.second == touch.first + 1 and np.isfinite(touch.p):
            usual.setdefault(touch.first, touch)
        else:
            others[touch.pair] = None
    for i, touch in usual.items():
        p[i], s[i] = touch.p, touch.s
    words = [f"tip edge on the next scale's side edge DC: {ranges(1 + i for i in usual)}"] if usual else []
    return p, s, "; ".join([*words, *others])


def ranges(numbers: Iterable[int]) -> str:
    """Return whole numbers in words: "1 to 3, 5"."""
    parts: list[Sequence[int]] = []
    for number in sorted(numbers):
        if parts and number == parts[-1][-1] + 1:
            parts[-1] = (parts[-1][0], number)
        else:
            parts.append((number, number))
    return ", ".join(f"{a}" if a == b else f"{a} to {b}" for a, b in parts)

"""Frictional contact of scales, thin or thick, rigid or bent: a barrier, smoothed Coulomb friction, no passing.

The scales keep a gap between 0 and ``dhat`` by a potential that grows without bound as the gap closes (incremental
potential contact: Li et al., ACM Trans. Graph. 39, 49, 2020; computed by ipctk). For rigid scales, candidates are edges
against edges and corners against faces of given pairs, since convex bodies meet in no other way; for scales that bend,
all edges and triangles of their surfaces that come near each other. Friction follows the slip since the last increment,
with normal force and direction of the present state, so the tangent is not symmetric.

Lengths in pitches; forces in the unit of the barrier's stiffness times pitches cubed.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from squama.fe.exposed import FACE, Exposed, Index, thin
from squama.fe.rows import Placed, Row
from squama.needs import need
from squama.types import Array

if TYPE_CHECKING:
    from scipy import sparse

DHAT = 1e-4
"""Gap below which the barrier repels scales, pitches."""
SLIP = 1e-5
"""Slip within an increment at which friction reaches its full value, pitches."""
_HALF = 4.329441541679836
"""Force at a gap of dhat / 2 over stiffness dhat^3."""
_CLOSE = 0.99
"""Largest fraction of the gap closed by a step; beyond, the step counts as a collision."""
_CLEAR = 0.9
"""Fraction of the step to the next collision that is taken."""
_WIDE = 0.01
"""Margin added to the search distance of candidates, so that they stay valid until corners move by half of it."""
_FAR = 10.0
"""Largest distance of the search for gaps, pitches."""
_USUAL = ("tip edge CB", "side edge DC")
_THIN = thin(1.0, 1.0)


def stiffness(force: float, dhat: float) -> float:
    """Return the stiffness of the barrier at which a contact force keeps a gap of dhat / 2."""
    return force / (_HALF * dhat**3)


class Push(NamedTuple):
    """Contact at one state of the corners (n, 3).

    ``gradient`` (n, 3) of the barrier's energy, the ``friction`` (n, 3; minus the friction forces), the numbers
    ``nodes`` (a,) of the corners with forces, and the ``tangent`` (3 a, 3 a): derivative of gradient + friction at
    these corners, or None if not requested or without contact.
    """

    gradient: Array
    friction: Array
    nodes: Index
    tangent: Array | None


class Touch(NamedTuple):
    """A place of contact of two scales.

    ``first`` and ``second`` number the scales, ``pair`` names the features (scale i is called 1 + i), ``N`` is the
    normal force, and ``p``, ``s`` the places of a contact of the tip edge of the first with side edge DC of the second:
    from the tip edge's middle towards B, and from D (NaN for others).
    """

    first: int
    second: int
    pair: str
    N: float
    p: float
    s: float


class Contact:
    """Contact of scales given by the points of their surfaces, here called "corners", scale by scale.

    ``corners`` (n m, 3) of the m scales at rest; ``pairs``: scales that may touch (scales that bend are searched for
    all contacts, in an endless row those of scale 0); ``exposed``: surface of each scale, by default a rectangle with
    the corners D, A, B, C; ``dhat``, ``slip`` as :data:`DHAT` and :data:`SLIP`.
    """

    def __init__(
        self,
        corners: Array,
        pairs: Sequence[tuple[int, int]],
        mu: float,
        *,
        exposed: Exposed = _THIN,
        dhat: float = DHAT,
        slip: float = SLIP,
    ) -> None:
        self._ipc = ipc = need("ipctk")
        self.mu, self.dhat, self.slip = mu, dhat, slip
        self._exposed, self._each = exposed, len(exposed.points)
        scales = np.arange(len(corners) // self._each)[:, None, None]
        edges, faces = (
            (cells + self._each * scales).reshape(-1, n) for cells, n in ((exposed.edges, 2), (exposed.faces, 3))
        )
        self._rest = np.asfortranarray(corners, dtype=float)
        self._mesh = ipc.CollisionMesh(self._rest, _whole(edges), _whole(faces))
        # in an endless row pairs without scale 0 repeat others
        number = np.arange(scales.size) if any(i for i, _ in pairs) else np.minimum(np.arange(scales.size), 1)
        self._mesh.can_collide = ipc.make_vertex_patches_filter(np.repeat(number, self._each).astype(np.int32))
        self._always = None if exposed.amplitudes else self._between(pairs)
        # path and distance of the last search, and the candidates
        self._kept: tuple[tuple[Array, Array], float, object] = (self._rest, self._rest), -1.0, None
        self._ccd = ipc.AdditiveCCD(conservative_rescaling=_CLOSE)
        self._friction = ipc.FrictionPotential(slip)

    def _between(self, pairs: Iterable[tuple[int, int]]) -> object:
        """Return candidates of rigid scales: all pairs of edges, and of triangles and points."""
        exposed, ipc, out = self._exposed, self._ipc, self._ipc.Candidates()
        n, m, q, outer = self._each, len(exposed.edges), len(exposed.faces), exposed.outer.tolist()
        out.ee_candidates = [
            ipc.EdgeEdgeCandidate(m * i + one, m * j + two) for i, j in pairs for one in outer for two in outer
        ]
        out.fv_candidates = [
            ipc.FaceVertexCandidate(q * one + face, n * two + point)
            for pair in pairs
            for one, two in (pair, pair[::-1])
            for face in range(q)
            for point in range(n)
        ]
        return out

    def _near(self, V: Array, there: Array, within: float) -> Any:
        """Return candidates within a distance ``within`` on a straight path of the corners, or a superset."""
        if self._always is not None:
            return self._always
        # candidates stay valid while both ends of the path are near ends of the searched path
        moved = max(min(float(np.abs(x - end).max()) for end in self._kept[0]) for x in (V, there))
        # the distance of two scales changes by at most twice the displacement of a corner
        if within + 2 * np.sqrt(3) * moved > self._kept[1]:
            wide, found = within + _WIDE, self._ipc.Candidates()
            found.build(self._mesh, V, there, wide / 2)
            self._kept = (V, there), wide, found
        return self._kept[2]

    def push(self, corners: Array, before: Array | None, kappa: float, *, tangent: bool = True) -> Push:
        """Evaluate barrier and friction at corners (n, 3); there is no friction without those ``before``."""
        V = np.asfortranarray(corners)
        found = self._found(V, self.dhat)
        zero = np.zeros_like(corners)
        if len(found) == 0:
            return Push(zero, zero, np.empty(0, np.int64), None)
        barrier = self._ipc.BarrierPotential(self.dhat, kappa)
        gradient = barrier.gradient(found, self._mesh, V).reshape(-1, 3)
        tangents = [(1.0, barrier.hessian(found, self._mesh, V))] if tangent else []
        friction = zero
        if before is not None and self.mu > 0:
            slide = self._ipc.TangentialCollisions()
            slide.build(self._mesh, V, found, barrier, self.mu)
            moved, since = np.asfortranarray(corners - self._rest), np.asfortranarray(corners - before)
            args = slide, self._mesh, self._rest, moved, since, barrier
            friction = -self._friction.force(*args).reshape(-1, 3)
            if tangent:
                by = self._friction.DiffWRT
                both = (by.VELOCITIES, by.LAGGED_DISPLACEMENTS)
                tangents += [(-1.0, self._friction.force_jacobian(*args, wrt)) for wrt in both]
        nodes = np.flatnonzero(gradient.any(axis=1) | friction.any(axis=1))
        return Push(gradient, friction, nodes, _among(nodes, tangents) if tangent else None)

    def _found(self, V: Array, within: float) -> Any:
        found = self._ipc.NormalCollisions()
        found.build(self._near(V, V, within), self._mesh, V, within)
        return found

    def gap(self, corners: Array, within: float = np.inf) -> float:
        """Return the least distance of the pairs, pitches; inf if it exceeds ``within`` (or :data:`_FAR`)."""
        V = np.asfortranarray(corners)
        # a search for candidates is faster the smaller the distance
        reach = min(within, _FAR) if self._always is not None else min(within, self.dhat)
        while len(found := self._found(V, reach)) == 0 and reach < min(within, _FAR):
            reach = min(4 * reach, within, _FAR)
        return float(np.sqrt(found.compute_minimum_distance(self._mesh, V))) if len(found) else np.inf

    def free(self, start: Array, end: Array) -> float:
        """Return the collision-free fraction of a straight motion of the corners from start to end, 1 for all of it."""
        a, b = np.asfortranarray(start), np.asfortranarray(end)
        t = self._near(a, b, 0.0).compute_collision_free_stepsize(self._mesh, a, b, 0.0, self._ccd)
        return 1.0 if t >= 1 else _CLEAR * float(t)

    def touches(self, corners: Array, kappa: float) -> list[Touch]:
        """Return the places of contact, strongest first."""
        V = np.asfortranarray(corners)
        barrier = self._ipc.BarrierPotential(self.dhat, kappa)
        sums: dict[tuple[int, int, str], tuple[Array, Array]] = {}
        for one, two, collision in self._features(self._found(V, self.dhat)):
            ids = [i for i in collision.vertex_ids(self._mesh.edges, self._mesh.faces) if i >= 0]
            g = collision.weight * barrier.gradient(collision, V[ids].ravel()).reshape(-1, 3)
            force = g[np.array(ids) // self._each == one.scale].sum(0)
            place = self._places(V, one, two) if (one.kind, two.kind) == _USUAL else np.full(2, np.nan)
            key = one.scale, two.scale, f"{one.words} on {two.words}"
            old, moment = sums.get(key, (np.zeros(3), np.zeros(2)))
            sums[key] = old + force, moment + np.linalg.norm(force) * place
        out = []
        for (a, b, pair), (force, moment) in sums.items():
            N = float(np.linalg.norm(force))
            p, s = (moment / N).tolist() if N > 0 else (np.nan, np.nan)
            out.append(Touch(a, b, pair, N, p, s))
        return sorted(out, key=lambda t: -t.N)

    def _features(self, found: Any) -> Iterator[tuple[_Feature, _Feature, Any]]:
        """Yield the two features of every collision, that of the lower scale first, and the collision."""
        exposed, edges, faces = self._exposed, len(self._exposed.edges), len(self._exposed.faces)

        def edge(i: int) -> _Feature:
            return _Feature(i // edges, exposed.sides[i % edges], self._mesh.edges[i])

        def corner(i: int) -> _Feature:
            return _Feature(i // self._each, exposed.names[i % self._each], np.array([i]))

        none = np.empty(0, np.int64)
        both = [
            *((edge(c.edge0_id), edge(c.edge1_id), c) for c in found.ee_collisions),
            *((corner(c.vertex_id), edge(c.edge_id), c) for c in found.ev_collisions),
            *((corner(c.vertex0_id), corner(c.vertex1_id), c) for c in found.vv_collisions),
            *((corner(c.vertex_id), _Feature(c.face_id // faces, FACE, none), c) for c in found.fv_collisions),
        ]
        for a, b, c in both:
            yield (b, a, c) if a.scale > b.scale else (a, b, c)

    def _places(self, V: Array, one: _Feature, two: _Feature) -> Array:
        """Return the nearest points of two lines or points of two scales: Y on the first, X on the second, pitches."""
        lines = [(V[f.nodes], self._exposed.points[f.nodes % self._each]) for f in (one, two)]
        (x, X), (y, Y) = lines
        along = [*(x[1:] - x[0]), *(y[0] - y[1:])]
        t = np.linalg.lstsq(np.array(along).reshape(-1, 3).T, y[0] - x[0], rcond=None)[0].tolist()
        a = t.pop(0) if len(x) > 1 else 0.0
        b = t.pop(0) if len(y) > 1 else 0.0
        return np.array([X[0, 1] + a * (X[-1, 1] - X[0, 1]), Y[0, 0] + b * (Y[-1, 0] - Y[0, 0])])


def _among(nodes: Index, matrices: Iterable[tuple[float, sparse.csc_array]]) -> Array:
    """Return a sum of sparse matrices over all places times factors as a dense block (3 a, 3 a) of these nodes."""
    n, out = 3 * nodes.size, np.zeros((3 * nodes.size + 1, 3 * nodes.size + 1))
    for factor, matrix in matrices:
        # the last row and column collect all other entries
        place = np.full(matrix.shape[0], n)
        place[(3 * nodes[:, None] + np.arange(3)).ravel()] = np.arange(n)
        entries = matrix.tocoo()
        out[place[entries.row], place[entries.col]] += factor * entries.data
    return out[:n, :n]


def _whole(rows: Index) -> NDArray[np.int32]:
    return np.asfortranarray(rows, dtype=np.int32)


class _Feature(NamedTuple):
    """Feature of a scale in a collision: number of the scale, kind of the feature, numbers of its points."""

    scale: int
    kind: str
    nodes: Index

    @property
    def words(self) -> str:
        """The feature with the letters of its corners and the number of its scale, e.g. tip edge C1B1."""
        if self.kind == FACE:
            return f"the face of scale {1 + self.scale}"
        words, _, letters = self.kind.rpartition(" ")
        return f"{words} {''.join(f'{letter}{1 + self.scale}' for letter in letters)}"


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
    """Contact forces of a row at one state: minus the forces on (v, phi), normal and frictional, and their tangent.

    ``normal``, ``friction`` and their sum ``total`` (m + 1,) are derivatives of the work by (v, phi), ``tangent`` (m +
    1, m + 1) that of the total, not symmetric; ``push``: gradients by the corners, None without contact; ``slid``: work
    of the present friction forces on the slip since ``before``, at least 0.
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
        J, nodes = placed.rates(push.nodes), push.nodes
        gradient, friction = push.gradient[nodes], push.friction[nodes]
        self.normal, self.friction = gradient.ravel() @ J, friction.ravel() @ J
        self.total = self.normal + self.friction
        self.tangent = J.T @ push.tangent @ J + placed.curvature(nodes, gradient + friction)
        if before is not None:
            self.slid = float((push.friction * (placed.corners - before)).sum())

    @cached_property
    def pairs(self) -> list[Pair]:
        """Pairs of scales in contact, with their forces."""
        if self.push is None:
            return []
        n = len(self._contact.row.exposed.points)
        V, before, out = self._corners.reshape(-1, n, 3), self._before, []
        scales = set((self.push.nodes // n).tolist())
        for i, j in self._contact.row.pairs:
            if not {i, j} <= scales:
                continue
            then = None if before is None else before.reshape(-1, n, 3)[[i, j]].reshape(-1, 3)
            push = self._contact.two.push(V[[i, j]].reshape(-1, 3), then, self._kappa, tangent=False)
            if push.gradient.any():
                out.append(Pair(i, j, -push.gradient[:n].sum(0), -push.friction[:n].sum(0)))
        return out

    @cached_property
    def strongest(self) -> Pair:
        """Pair with the largest normal force; without contact a scale and itself, with zero forces."""
        return max(self.pairs, key=lambda p: p.N, default=Pair(0, 0, np.zeros(3), np.zeros(3)))


class RowContact(Contact):
    """Frictional contact of a row's scales with all neighbours within reach; of an endless row per pitch."""

    def __init__(self, row: Row, mu: float, *, dhat: float = DHAT, slip: float = SLIP) -> None:
        self.row = row
        # motions of bodies without contact may precede the strains
        motions = max(6 * row.moving, row.course.first) + row.course.strains
        size = motions + row.exposed.amplitudes * row.moving
        rest, exposed = self.corners(np.zeros(size), 0.0), row.exposed
        super().__init__(rest, row.pairs, mu, exposed=exposed, dhat=dhat, slip=slip)
        # rest places have no influence, so any two scales serve for every pair
        self.two = Contact(rest[: 2 * len(exposed.points)], [(0, 1)], mu, exposed=exposed, dhat=dhat, slip=slip)

    def corners(self, v: Array, phi: float) -> Array:
        """Return the corners of all scales, (n, 3), scale by scale."""
        return Placed(self.row, v, phi).corners

    def load(self, v: Array, phi: float, before: Array | None, kappa: float) -> Load:
        """Return the contact forces at a state; ``before`` and ``kappa`` as in :meth:`Contact.push`."""
        return Load(self, v, phi, before, kappa)


def forces(load: Load, scales: int) -> tuple[Array, Array]:
    """Return the magnitudes (scales,) of normal and friction force of each scale on the next one; NaN for the last."""
    N, f = np.zeros((2, scales))
    N[-1] = f[-1] = np.nan
    for pair in load.pairs:
        if pair.second == pair.first + 1:
            N[pair.first], f[pair.first] = pair.N, pair.f
    return N, f


def where(touches: Iterable[Touch], scales: int) -> tuple[Array, Array, str]:
    """Return the contact places p and s (scales,) of each tip edge on the next scale, and all contacts in words.

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
    """Return whole numbers as text with ranges: "1 to 3, 5"."""
    parts: list[Sequence[int]] = []
    for number in sorted(numbers):
        if parts and number == parts[-1][-1] + 1:
            parts[-1] = (parts[-1][0], number)
        else:
            parts.append((number, number))
    return ", ".join(f"{a}" if a == b else f"{a} to {b}" for a, b in parts)

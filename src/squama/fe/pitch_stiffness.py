"""Linear elements of one pitch: its stiffness over a scale's six motions and the beam's twist, bend and stretch.

At small strain the back of a pitch follows its front, u_back = u_front + (displacement of the step by one pitch under
the loads), with plate 0 tied in as a rigid body. The energy per pitch is 1/2 q^T K q over q = (v, phi, psi, epsilon):
the six motions of the plate along its axes at rest, the twist per pitch, the bend per pitch (positive towards the
scaled face) and the stretch of the axis y = 0. A step by one pitch is the screw whose rotation vector is -(psi, 0,
phi); to first order at a place (x, y, z) it moves by
    twist (y, -x, 0)        bend (0, z + 1/2, -y)        stretch (0, 0, 1)        lateral bend (-z - 1/2, 0, x).
The mean place of the front section and its mean turn about z are held in the frame that follows the loads, from which v
is counted; twist and bend act at a held length (epsilon = 0) unless the stretch is left free.
"""

from __future__ import annotations

from math import tan
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from squama.errors import InputError
from squama.fe.elements import Elements, Material, gradients, shape_rates
from squama.fe.geometry import Geometry
from squama.fe.mesh import EDGES, Index, Pitch
from squama.fe.plate import Carried
from squama.fe.solver import Solver
from squama.types import Array

if TYPE_CHECKING:
    from scipy import sparse

MOTIONS, LATERAL = 9, 10
"""Rows of K: six motions of the scale, twist, bend, stretch; with lateral bend."""
NEAR = 0.1
"""Distance from an embedded edge within which strains are averaged, over embedded length or half width."""
EDGES_OF_TAB = ("deep edge", "side at -Y", "side at +Y", "mouth")
"""Edges of the embedded part, where the substrate is strained most."""


class Response(NamedTuple):
    """Results of one mesh, E = 1 and d = 1: ``K`` (9, 9) or (10, 10), ``strain`` (4, 9, 9) or more, number of elements.

    ``strain`` is a form for each of :data:`EDGES_OF_TAB`: q^T strain q is the mean of 2 W / E near that edge, W the
    strain energy per volume; its root is the strain of a bar in tension with that energy.
    """

    K: Array
    strain: Array
    elements: int


def response(pitch: Pitch, geometry: Geometry, tab: Material | None = None, motions: int = MOTIONS) -> Response:
    """Return the stiffness of a pitch and the strains around its scale; ``tab``: material of a meshed tab.

    ``motions``: :data:`MOTIONS`, or :data:`LATERAL` with a row for lateral bend.

    Raises
    ------
    InputError
        The mesh has inverted elements, or the solver fails.
    """
    from scipy import sparse

    master, _, rest = pitch.images
    tets = np.delete(pitch.tets, pitch.tab, axis=0)
    elements = Elements(pitch.nodes, tets, Material(1.0, geometry.nu))
    A = _stiffness(elements, pitch.nodes)
    if tab is not None:
        A = A + _stiffness(Elements(pitch.nodes, pitch.tets[pitch.tab], tab), pitch.nodes)
    tied = master[pitch.tied]
    moved = _moved(pitch, geometry, tied, motions)
    P = _from_free(master, np.setdiff1d(np.arange(len(rest)), tied))
    pushed = A @ moved
    means, own = _section(pitch, geometry, motions)
    corner = np.zeros((motions + 4, motions + 4))
    corner[:motions, :motions], corner[:motions, motions:] = moved.T @ pushed, (means @ moved + own).T
    border = sparse.csr_array(np.column_stack([P.T @ pushed, P.T @ means.T]))
    matrix = _bordered(P.T @ A @ P, border, corner)
    solver = Solver(matrix, len(corner))
    try:
        S = solver.factorise(matrix.data)
        S = (S + S.T) / 2
        # multipliers of the section's conditions, for each of the motions
        m = -np.linalg.solve(S[motions:, motions:], S[motions:, :motions])
        K = S[:motions, :motions] + S[:motions, motions:] @ m
        both = np.vstack([np.eye(motions), m])
        fields = moved - P @ np.column_stack([solver.spread(motion) for motion in both.T])
    finally:
        solver.close()
    points = np.einsum("qc,eci->eqi", _POINTS, pitch.nodes[tets[:, :4]])
    parts = near_edges(geometry, points)
    strain = mean_energies(tets, elements, fields.reshape(-1, 3, motions), parts)
    return Response((K + K.T) / 2, strain, len(pitch.tets))


def _bordered(inner: sparse.csr_array, border: sparse.csr_array, corner: Array) -> sparse.csr_array:
    """Return the upper triangle of a symmetric matrix with a border and a corner, of which zeros are stored, too."""
    from scipy import sparse

    at = np.triu_indices(len(corner))
    upper = sparse.coo_array((corner[at], at), shape=corner.shape)
    matrix = sparse.csr_array(sparse.block_array([[sparse.triu(inner), border], [None, upper]], format="csr"))
    matrix.sort_indices()
    return matrix


def _from_free(master: Index, free: Index) -> sparse.csr_array:
    """Return the matrix from displacements of free masters to those of all nodes."""
    from scipy import sparse

    column = np.full(master.max() + 1, -1)
    column[free] = np.arange(free.size)
    node = np.flatnonzero(column[master] >= 0)
    rows, columns = ((3 * at[:, None] + np.arange(3)).ravel() for at in (node, column[master[node]]))
    return sparse.csr_array((np.ones(rows.size), (rows, columns)), shape=(3 * master.size, 3 * free.size))


def _stiffness(elements: Elements, nodes: Array) -> sparse.csr_array:
    """Return the stiffness matrix (3 n, 3 n) of elements at rest."""
    result = elements(nodes)
    if not result.least > 0:
        message = "the mesh has inverted elements: take another element size"
        raise InputError(message)
    return elements.matrix(result.values).tocsr()


def _moved(pitch: Pitch, geometry: Geometry, tied: Index, motions: int) -> Array:
    """Return the displacements (3 n, motions) of nodes by motions of the scale and loads at fixed free masters."""
    master, turned, rest = pitch.images
    out = np.zeros((len(pitch.nodes), 3, LATERAL))
    place = np.full(len(rest), -1)
    place[tied] = np.arange(tied.size)
    of_scale = np.flatnonzero(place[master] >= 0)
    rates = Carried(geometry.rest, rest[tied]).rates(np.zeros(6), 0.0)[:, :, :6]
    out[of_scale, :, :6] = rates[place[master[of_scale]]]
    x = rest[master[turned]]
    out[turned, 0, 6], out[turned, 1, 6] = x[:, 1], -x[:, 0]
    out[turned, 1, 7], out[turned, 2, 7] = x[:, 2] + 0.5, -x[:, 1]
    out[turned, 2, 8] = 1.0
    out[turned, 0, 9], out[turned, 2, 9] = -x[:, 2] - 0.5, x[:, 0]
    return out[..., :motions].reshape(-1, motions)


def _section(pitch: Pitch, geometry: Geometry, motions: int) -> tuple[Array, Array]:
    """Return the mean place and turn of the section z = x tan(alpha) + c in the frame that follows the loads.

    As matrices by displacements of all nodes (4, 3 n), and directly by motions and loads (4, motions).
    """
    from scipy import sparse

    if geometry.lean:
        X, w, N, steps, rigid = _across(pitch, geometry)
    else:
        X, w = pitch.nodes[pitch.front], pitch.shares
        N = sparse.eye_array(len(pitch.nodes), format="csr")[pitch.front]
        steps, rigid = np.zeros(len(X)), np.zeros(len(X), bool)
    radius = float(w @ (X[:, :2] ** 2).sum(1))
    weights = np.zeros((4, len(X), 3))
    for i in range(3):
        weights[i, :, i] = w
    weights[3, :, 0], weights[3, :, 1] = w * X[:, 1] / radius, -w * X[:, 0] / radius
    # displacement of a step less that of the frame, at the place before the step
    x, y, z = X.T
    z = z - steps
    own = np.zeros((len(X), 3, LATERAL))
    own[:, 0, 6], own[:, 1, 6] = -y * z, x * z
    own[:, 1, 7], own[:, 2, 7] = -z * z / 2, y * z
    own[:, 2, 8] = -z
    own[:, 0, 9], own[:, 2, 9] = z * z / 2, -x * z
    back = X - steps[:, None] * np.array([0.0, 0.0, 1.0])
    own[rigid, :, :6] = Carried(geometry.rest, back[rigid]).rates(np.zeros(6), 0.0)[:, :, :6]
    means = np.stack([(N.T @ weights[:, :, i].T).T for i in range(3)], axis=-1)
    return means.reshape(4, -1), np.einsum("iqj,qjk->ik", weights, own[..., :motions])


def _across(pitch: Pitch, geometry: Geometry) -> tuple[Array, Array, sparse.csr_array, Array, NDArray[np.bool_]]:
    """Return points (q, 3) of the section, their weights, shape functions (q, n), steps in pitches, and rigid ones.

    With leaning cuts the section is no face of the mesh: it runs through several pitches and their scales. ``steps``:
    number of pitches from the meshed pitch to the point. A rigid point lies in a scale and has no shape functions.
    """
    from scipy import sparse

    (u, share_u), (v, share_v) = (np.polynomial.legendre.leggauss(n) for n in _ACROSS)
    x, y = (at.ravel() for at in np.meshgrid(u * geometry.width / 2, v * geometry.lam, indexing="ij"))
    weights = np.outer(share_u, share_v).ravel() / 4
    low, high = geometry.footprint
    s = np.full(x.size, (low + high - 1) / 2)
    steps = np.floor(s - geometry.front(y))
    X = np.column_stack([x, y, s + x * tan(geometry.alpha)])
    back = X - steps[:, None] * np.array([0.0, 0.0, 1.0])
    rigid = geometry.in_slot(back)
    if pitch.tab.size:
        rigid &= geometry.local(back)[:, 0] > 0
    slopes, _ = gradients(pitch.nodes, pitch.tets)
    first = np.zeros((len(slopes), 4))
    first[:, 0] = 1.0
    first -= np.einsum("eci,ei->ec", slopes, pitch.nodes[pitch.tets[:, 0]])
    soft = np.flatnonzero(~rigid)
    at, values = np.empty((soft.size, 10), np.int64), np.empty((soft.size, 10))
    for i, q in enumerate(soft):
        inside = slopes @ back[q] + first
        e = int(inside.min(axis=1).argmax())
        c, at[i] = inside[e], pitch.tets[e]
        values[i, :4], values[i, 4:] = c * (2 * c - 1), 4 * c[EDGES].prod(axis=1)
    places, shape = (np.repeat(soft, 10), at.ravel()), (x.size, len(pitch.nodes))
    N = sparse.csr_array((values.ravel(), places), shape=shape)
    return X, weights, N, steps, rigid


# Gauss points of degree 2, enough for a product of linear strains
_INNER, _OUTER = 0.1381966011250105, 0.5854101966249685
_POINTS = np.full((4, 4), _INNER) + (_OUTER - _INNER) * np.eye(4)
_RATES = shape_rates(_POINTS)
_ACROSS = (32, 16)
"""Gauss points along the width and the height of a section that is no face of the mesh."""


def near_edges(geometry: Geometry, points: Array) -> list[Array]:
    """Return for points (e, q, 3) whether they lie near each of :data:`EDGES_OF_TAB`, a list of arrays (e, q)."""
    near, half = NEAR * min(geometry.zeta, geometry.beta), geometry.thickness / 2
    X, Y, Z = np.moveaxis(geometry.local(points.reshape(-1, 3)).reshape(points.shape), -1, 0)
    off = np.maximum(np.abs(Z) - half, 0.0)
    along, across = -geometry.zeta - near <= X, np.abs(Y) <= geometry.beta + near
    return [
        (np.hypot(X + geometry.zeta, off) <= near) & across,
        (np.hypot(Y + geometry.beta, off) <= near) & along,
        (np.hypot(Y - geometry.beta, off) <= near) & along,
        (points[..., 1] >= geometry.lam - near) & (off <= near) & across & along,
    ]


def mean_energies(tets: Index, elements: Elements, fields: Array, parts: list[Array]) -> Array:
    """Return the forms (k, 9, 9) of the mean of 2 W / E over Gauss points selected by ``parts``, each (e, q).

    ``fields`` (n, 3, 9) are the displacements of the nodes for each of the motions.
    """
    used = np.flatnonzero(np.any(parts, axis=(0, 2)))
    slopes = np.einsum("qac,eci->eqai", _RATES, elements.gradients[used])
    # rows: element, point; the strain's matrix (3, 3) for each motion
    grad = np.einsum("eqaj,eaim->eqijm", slopes, fields[tets[used]])
    strain = (grad + grad.swapaxes(2, 3)) / 2
    L, G = elements.lame
    trace = np.einsum("eqiim->eqm", strain)
    shares = elements.volumes[used, None] / len(_POINTS)
    forms = []
    for part in parts:
        w = shares * part[used]
        w = w / max(w.sum(), np.finfo(float).tiny)
        form = 2 * G * np.einsum("eq,eqijm,eqijn->mn", w, strain, strain, optimize=True)
        forms.append(form + L * np.einsum("eq,eqm,eqn->mn", w, trace, trace, optimize=True))
    return np.array(forms)

"""Linear elements of one pitch: its stiffness over a scale's six motions and the beam's twist, bend and stretch.

At small strain the back of a pitch follows its front, u_back = u_front + (what a load makes of the step by one pitch),
with plate 0 tied in as a rigid body. The energy per pitch is 1/2 q^T K q over q = (v, phi, psi, epsilon): the six
motions of the plate along its axes at rest, the twist per pitch, the bend per pitch (positive towards the scaled face)
and the stretch of the axis y = 0. A step by one pitch is the screw whose rotation vector is -(psi, 0, phi); to first
order at a place (x, y, z) it moves by
    twist (y, -x, 0)        bend (0, z + 1/2, -y)        stretch (0, 0, 1).
The mean place of the front section and its mean turn about z are held in the frame that goes with the load, so v is
counted from there; twist and bend act at a held length (epsilon = 0) unless the stretch is left free.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from squama.errors import InputError
from squama.fe.elements import Elements, Material, shape_rates
from squama.fe.geometry import Geometry
from squama.fe.mesh import Index, Pitch
from squama.fe.plate import Carried
from squama.fe.solver import Solver
from squama.types import Array

MOTIONS = 9
"""Rows of K: six motions of the scale, twist, bend, stretch."""
NEAR = 0.1
"""Strains are averaged as near to an edge of the embedded scale: share of its embedded length or half width."""
EDGES_OF_TAB = ("deep edge", "side at -Y", "side at +Y", "mouth")
"""Where the substrate is strained most."""


class Response(NamedTuple):
    """What one mesh gave, E = 1 and d = 1: ``K`` (9, 9), ``strain`` (4, 9, 9), the number of elements.

    ``strain`` is a form for each of :data:`EDGES_OF_TAB`: q^T strain q is the mean of 2 W / E near that edge, W the
    strain energy per volume; its root is the strain that a bar under tension would have at that energy.
    """

    K: Array
    strain: Array
    elements: int


def response(pitch: Pitch, geometry: Geometry, tab: Material | None = None) -> Response:
    """Return the stiffness of a pitch and the strains around its scale; ``tab``: material of a tab that is meshed.

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
    free = np.setdiff1d(np.arange(len(rest)), tied)
    moved = _moved(pitch, geometry, tied)
    # nodes by the free masters
    column = np.full(len(rest), -1)
    column[free] = np.arange(free.size)
    node = np.flatnonzero(column[master] >= 0)
    axis = np.arange(3)
    rows, columns = ((3 * at[:, None] + axis).ravel() for at in (node, column[master[node]]))
    P = sparse.csr_array((np.ones(rows.size), (rows, columns)), shape=(moved.shape[0], 3 * free.size))
    pushed = A @ moved
    held, frames = _section(pitch, master, len(rest))
    held = held[:, free].reshape(4, -1)
    corner = np.zeros((MOTIONS + 4, MOTIONS + 4))
    corner[:MOTIONS, :MOTIONS], corner[:MOTIONS, MOTIONS:] = moved.T @ pushed, -frames.T
    # every entry is stored, the multipliers' zeros too
    at = np.triu_indices(len(corner))
    upper = sparse.coo_array((corner[at], at), shape=corner.shape)
    border = sparse.csr_array(np.column_stack([P.T @ pushed, held.T]))
    matrix = sparse.csr_array(sparse.block_array([[sparse.triu(P.T @ A @ P), border], [None, upper]], format="csr"))
    matrix.sort_indices()
    solver = Solver(matrix, len(corner))
    try:
        S = solver.factorise(matrix.data)
        S = (S + S.T) / 2
        # multipliers that hold the section, for each of the motions
        m = -np.linalg.solve(S[MOTIONS:, MOTIONS:], S[MOTIONS:, :MOTIONS])
        K = S[:MOTIONS, :MOTIONS] + S[:MOTIONS, MOTIONS:] @ m
        both = np.vstack([np.eye(MOTIONS), m])
        fields = moved - P @ np.column_stack([solver.spread(motion) for motion in both.T])
    finally:
        solver.close()
    points = np.einsum("qc,eci->eqi", _POINTS, pitch.nodes[tets[:, :4]])
    parts = near_edges(geometry, points)
    strain = mean_energies(tets, elements, fields.reshape(-1, 3, MOTIONS), parts)
    return Response((K + K.T) / 2, strain, len(pitch.tets))


def _stiffness(elements: Elements, nodes: Array) -> Any:
    """Return the matrix (3 n, 3 n) of elements at rest."""
    result = elements(nodes)
    if not result.least > 0:
        message = "the mesh has inverted elements: take another element size"
        raise InputError(message)
    return elements.matrix(result.values).tocsr()


def _moved(pitch: Pitch, geometry: Geometry, tied: Index) -> Array:
    """Return how far nodes go (3 n, 9) with the scale and the loads while the free masters stay."""
    master, turned, rest = pitch.images
    out = np.zeros((len(pitch.nodes), 3, MOTIONS))
    place = np.full(len(rest), -1)
    place[tied] = np.arange(tied.size)
    of_scale = np.flatnonzero(place[master] >= 0)
    rates = Carried(geometry.rest, rest[tied]).rates(np.zeros(6), 0.0)[:, :, :6]
    out[of_scale, :, :6] = rates[place[master[of_scale]]]
    x = rest[master[turned]]
    out[turned, 0, 6], out[turned, 1, 6] = x[:, 1], -x[:, 0]
    out[turned, 1, 7], out[turned, 2, 7] = x[:, 2] + 0.5, -x[:, 1]
    out[turned, 2, 8] = 1.0
    return out.reshape(-1, MOTIONS)


def _section(pitch: Pitch, master: Index, masters: int) -> tuple[Array, Array]:
    """Return the section's mean place and turn by the masters (4, masters, 3), and by the motions and loads (4, 9)."""
    X, w, front = pitch.nodes[pitch.front], pitch.shares, master[pitch.front]
    radius = float(w @ (X[:, :2] ** 2).sum(1))
    means = np.zeros((4, masters, 3))
    for i in range(3):
        means[i, front, i] = w
    means[3, front, 0], means[3, front, 1] = w * X[:, 1] / radius, -w * X[:, 0] / radius
    frame = np.zeros((front.size, 3, MOTIONS))
    x, y, z = X.T
    frame[:, 0, 6], frame[:, 1, 6] = y * z, -x * z
    frame[:, 1, 7], frame[:, 2, 7] = z * z / 2, -y * z
    frame[:, 2, 8] = z
    return means, np.einsum("inj,njk->ik", means[:, front], frame)


# Gauss points of degree 2, enough for a product of linear strains
_INNER, _OUTER = 0.1381966011250105, 0.5854101966249685
_POINTS = np.full((4, 4), _INNER) + (_OUTER - _INNER) * np.eye(4)
_RATES = shape_rates(_POINTS)


def near_edges(geometry: Geometry, points: Array) -> list[Array]:
    """Say which points (e, q, 3) lie near each of :data:`EDGES_OF_TAB`, truths (e, q)."""
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
    """Return the forms (k, 9, 9) of the mean of 2 W / E over parts of the elements' Gauss points, truths (e, q) each.

    ``fields`` (n, 3, 9) are what nodes do for each of the motions.
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

"""The deformed pitch at the end of a run, in SI units, with what the elements feel: for pictures and files."""

from __future__ import annotations

from math import sqrt
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from squama.fe.elements import Array, Index, Material, Turn
from squama.fe.geometry import geometry
from squama.fe.mesh import Pitch
from squama.fe.plate import Attached

if TYPE_CHECKING:
    from squama.design import Beam
    from squama.fe.walk import Walk

IMAGES = (-1, 0, 1)
"""The scale and its neighbours that are shown."""


class Deformed(NamedTuple):
    """One pitch of the substrate and three scales.

    ``nodes``, ``moved`` (n, 3): places at rest and now, m; ``tets`` (m, 10), ``surface`` (q, 6) as in
    :class:`squama.fe.mesh.Pitch`, ``walls`` (q,): whether a triangle is the slot's; per element
    ``stretch`` (largest principal stretch), ``density`` (strain energy per volume at rest, J/m3) and ``mises`` (von
    Mises stress in the deformed state, Pa), means over its Gauss points;
    ``scales``, ``scales_moved`` (3, 4, 3): corners of the mid-planes of the scales -1, 0, 1 with their embedded parts,
    m; ``phi``: twist, rad per pitch, signed; ``pitch`` and ``exposed``, the scale's exposed length: m.
    """

    nodes: Array
    moved: Array
    tets: Index
    surface: Index
    walls: NDArray[np.bool_]
    stretch: Array
    density: Array
    mises: Array
    scales: Array
    scales_moved: Array
    phi: float
    pitch: float
    exposed: float

    def at_nodes(self, values: Array) -> Array:
        """Return values of the elements (m,) as means at the nodes (n,), weighted by volume."""
        x = self.nodes[self.tets[:, :4]]
        volumes = np.repeat(np.abs(np.linalg.det(x[:, 1:] - x[:, :1])), 10)
        node = self.tets.ravel()
        total = np.bincount(node, volumes, minlength=len(self.nodes))
        sums = np.bincount(node, volumes * np.repeat(values, 10), minlength=len(self.nodes))
        return np.asarray(sums / np.maximum(total, 1e-300))


def deformed(beam: Beam, walk: Walk, pitch: Pitch) -> Deformed:
    """Return where a run stands.

    Parameters
    ----------
    beam : Beam
        What was twisted.
    walk : Walk
        The run, from :func:`squama.fe.cell.make_cell`.
    pitch : Pitch
        Its mesh.
    """
    shape, d, E = geometry(beam), beam.pitch, beam.substrate.youngs_modulus
    master, turned, _ = pitch.images
    moved = walk.places()[master]
    moved[turned] = moved[turned] @ Turn.at(walk.phi).Q.T + [0.0, 0.0, 1.0]
    F = gradients(pitch.nodes, pitch.tets, moved)
    stretch, density, mises = (values.mean(axis=1) for values in _felt(F, Material(1.0, shape.nu)))
    X, Y = (-shape.zeta, shape.eta), (-shape.beta, shape.beta)
    local = np.array([[X[0], Y[0], 0.0], [X[1], Y[0], 0.0], [X[1], Y[1], 0.0], [X[0], Y[1], 0.0]])
    rest = shape.base + local @ shape.axes
    now = Attached(shape, rest).places(walk.v)
    lift = [np.array([0.0, 0.0, k]) for k in IMAGES]
    return Deformed(
        nodes=pitch.nodes * d,
        moved=moved * d,
        tets=pitch.tets,
        surface=pitch.surface,
        walls=np.asarray(np.isin(pitch.surface, pitch.tied).all(axis=1)),
        stretch=stretch,
        density=density * E,
        mises=mises * E,
        scales=np.array([rest + up for up in lift]) * d,
        scales_moved=np.array([now @ Turn.at(k * walk.phi).Q.T + up for k, up in zip(IMAGES, lift, strict=True)]) * d,
        phi=walk.phi,
        pitch=d,
        exposed=shape.eta * d,
    )


def gradients(nodes: Array, tets: Index, moved: Array) -> Array:
    """Return the deformation gradients (m, 4, 3, 3) at the Gauss points of quadratic tetrahedra."""
    x = nodes[tets[:, :4]]
    inverse = np.linalg.inv(x[:, 1:] - x[:, :1])
    # derivatives (m, 4, 3) of the four corner coordinates
    corner = np.concatenate([-inverse.sum(axis=2, keepdims=True), inverse], axis=2).transpose(0, 2, 1)
    a = (5 - sqrt(5)) / 20
    points = np.full((4, 4), a) + (1 - 4 * a) * np.eye(4)
    edges = ((0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3))
    # (Gauss point, node, corner coordinate)
    slopes = np.zeros((4, 10, 4))
    for g, L in enumerate(points):
        slopes[g, range(4), range(4)] = 4 * L - 1
        for n, (i, j) in enumerate(edges):
            slopes[g, 4 + n, i], slopes[g, 4 + n, j] = 4 * L[j], 4 * L[i]
    shapes = np.einsum("gnc,mcj->mgnj", slopes, corner)
    return np.asarray(np.einsum("mni,mgnj->mgij", moved[tets], shapes))


def _felt(F: Array, material: Material) -> tuple[Array, Array, Array]:
    """Return largest stretch, energy density and von Mises stress (E = 1) of the solid of the elements module."""
    L, G = material.lame
    B = F @ F.swapaxes(-1, -2)
    J = np.linalg.det(F)
    stretch = np.sqrt(np.linalg.eigvalsh(B)[..., -1])
    trace = np.trace(B, axis1=-2, axis2=-1)
    density = G / 2 * (trace - 3 - 2 * np.log(J)) + L / 2 * np.log(J) ** 2
    deviator = G * (B - trace[..., None, None] / 3 * np.eye(3)) / J[..., None, None]
    return stretch, density, np.sqrt(1.5 * (deviator**2).sum(axis=(-2, -1)))

"""Linear elements of scales that move alternately, every second one the opposite way: B of squama.joints.tilt."""

from __future__ import annotations

import numpy as np
from scipy import sparse

from squama.fe.elements import Elements, Material
from squama.fe.geometry import Geometry
from squama.fe.mesh import Pitch
from squama.fe.pitch_stiffness import _bordered, _from_free, _moved, _stiffness
from squama.fe.plate import Rest
from squama.fe.solver import Solver
from squama.types import Array

_STRAINS = np.array([[0.0, 0.0, -1.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, -1.0, 0.0]])
"""Rotation per pitch of the strains twist, bend, stretch and lateral bend."""


def alternating(pitch: Pitch, geometry: Geometry) -> Array:
    """Return the stiffness (6, 6) of a scale against motions of which every second scale has the opposite ones.

    The displacement of the bar changes sign from pitch to pitch, and the bar is not held otherwise.
    """
    master, turned, rest = pitch.images
    tets = np.delete(pitch.tets, pitch.tab, axis=0)
    A = _stiffness(Elements(pitch.nodes, tets, Material(1.0, geometry.nu)), pitch.nodes)
    sign = np.ones(len(pitch.nodes))
    sign[turned] = -1.0
    signs = sparse.diags_array(np.repeat(sign, 3))
    tied = master[pitch.tied]
    moved = signs @ _moved(pitch, geometry, tied, 6)
    P = signs @ _from_free(master, np.setdiff1d(np.arange(len(rest)), tied))
    pushed = A @ moved
    matrix = _bordered(P.T @ A @ P, sparse.csr_array(P.T @ pushed), moved.T @ pushed)
    solver = Solver(matrix, 6)
    try:
        S = solver.factorise(matrix.data)
    finally:
        solver.close()
    return np.asarray((S + S.T) / 2)


def unshared(stiffness: Array, K: Array, rest: Rest) -> Array:
    """Return B (6, 6) from the stiffness (6, 6) of scales that move alternately, and the joint K (10, 10)."""
    # section halfway between scales: it moves the opposite way a pitch further
    moved = np.linalg.solve(_shifted(1.0) + np.eye(6), _bent(1.0))
    section = _bent(0.5) - _shifted(0.5) @ moved
    A = rest.axes
    by_strains = np.vstack([A @ (section[:3] - _cross(rest.base) @ section[3:]), A @ section[3:]])
    J = np.hstack([np.eye(6), by_strains])
    return np.asarray(np.linalg.inv(stiffness) - J @ np.linalg.inv(K) @ J.T)


def _bent(length: float) -> Array:
    """Return displacement and rotation (6, 4) behind a length of bar, by its strains."""
    shift = np.cross(_STRAINS, [0.0, 0.0, length**2 / 2])
    shift[2, 2] = length
    return np.vstack([shift.T, length * _STRAINS.T])


def _shifted(length: float) -> Array:
    """Return the displacement and rotation (6, 6) of a place that moves rigidly with one ``length`` before it."""
    out = np.eye(6)
    out[:3, 3:] = -_cross(np.array([0.0, 0.0, length]))
    return out


def _cross(v: Array) -> Array:
    """Return the matrix (3, 3) of the cross product with v."""
    return np.asarray(np.cross(np.eye(3), v) * -1.0)

"""Tilt of the scales of a row: how a scale yields to loads that its neighbours do not share; E = 1 and d = 1.

The joint's matrix K is that of scales which all move alike. Embedded parts lie in each other's strain fields, so a
scale gives more where its neighbours bear less: at the ends of a row, where contacts come in one by one, along a graded
part. With W_i the wrench of the contacts between scales i and i + 1 on scale i, in its axes and about the place halfway
to the next one, each scale moves on its joint and besides by

    B (W_i - W_(i-1)),        B = C - C_K

C is the compliance (6, 6) of a scale where every second one bears the opposite load (linear elements,
:func:`squama.fe.pitch_stiffness.alternating`), C_K that of a bar with joints K under these loads. Contacts press along
n_Z and turn a scale mainly about its width n_Y. So B is taken to be g g^T with g = (B_uY, B_XY, B_YY)/sqrt(B_YY) over
u_Z, w_X and w_Y: one tilt of stiffness 1 for each scale, which moves it by g (docs, theory: row).

The outputs ln B_YY, ln(-B_XY/sin(alpha)), ln(-B_uY) of a Gaussian process over the features of
:mod:`squama.joints.law` are fitted to linear elements (``tools/neighbours.py``). What a joint gives right at its edges
has no part in B: elements of half the size change the joint's compliance by half, and B by 4 %.
"""

from __future__ import annotations

import functools
from pathlib import Path
from typing import NamedTuple

import numpy as np

from squama.fe.plate import Rest
from squama.joints import law
from squama.joints.law import Shape
from squama.joints.processes import nearness, read
from squama.types import Array

PLACE = Path(__file__).with_name("tilt.npz")
U_Z, W_X, W_Y = 2, 3, 4
STEEP, NARROW = np.radians(66.0), 0.45
"""Largest alpha, and least width of the bar times cos(alpha) in pitches, of the designs that are fitted: beyond, a rod
between scales describes the bar badly, B is not positive, and there is no tilt.
"""
_STRAINS = np.array([[0.0, 0.0, -1.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, -1.0, 0.0]])
"""Rotation per pitch of the strains twist, bend, stretch and lateral bend."""


class Process(NamedTuple):
    """The process of three outputs from n designs over p features: see :mod:`squama.joints.processes`.

    ``mean`` and ``spread`` (p,) of the features; ``sample`` (n, p) of scaled ones; ``lengths`` (p,); ``trend``
    (1 + p, 3); ``weights`` (n, 3).
    """

    mean: Array
    spread: Array
    sample: Array
    lengths: Array
    trend: Array
    weights: Array

    def __call__(self, shape: Shape) -> Array:
        """Return the outputs (n, 3) of shapes (n,)."""
        x = (law.features(shape) - self.mean) / self.spread
        apart = (x[:, None] - self.sample) / self.lengths
        return np.asarray(self.trend[0] + x @ self.trend[1:] + nearness(5 * (apart**2).sum(axis=-1)) @ self.weights)


def tilts(shape: Shape) -> Array:
    """Return the motion (n, 3) of scales along u_Z, w_X and w_Y per unit of their tilt, or (3,) of one; real parts.

    Zeros for shapes that the process does not cover.
    """
    many = Shape(*np.broadcast_arrays(*(np.atleast_1d(np.real(v)) for v in shape)))
    out = np.zeros((len(many.alpha), 3))
    covered = fitted(many) & law.within(many)
    if covered.any():
        out[covered] = motion(many.at(covered), shipped()(many.at(covered)))
    return out if np.ndim(shape.alpha) else out[0]


def motion(shape: Shape, column: Array) -> Array:
    """Return g (n, 3) over u_Z, w_X and w_Y from the outputs (n, 3) of the process."""
    turn, roll, lift = np.exp(column.T)
    return np.asarray((np.array([-lift, -roll * np.sin(shape.alpha), turn]) / np.sqrt(turn)).T)


def fitted(shape: Shape) -> Array:
    """Return truth values (n,): whether designs like these are fitted."""
    return np.asarray((np.abs(shape.alpha) < STEEP) & (shape.width * np.cos(shape.alpha) > NARROW))


def unshared(alternating: Array, K: Array, rest: Rest) -> Array:
    """Return B (6, 6) from the stiffness (6, 6) of scales that move alternately, and the joint K (10, 10)."""
    # section halfway between scales: it moves the opposite way a pitch further
    moved = np.linalg.solve(_shifted(1.0) + np.eye(6), _bent(1.0))
    section = _bent(0.5) - _shifted(0.5) @ moved
    A = rest.axes
    by_strains = np.vstack([A @ (section[:3] - _cross(rest.base) @ section[3:]), A @ section[3:]])
    J = np.hstack([np.eye(6), by_strains])
    return np.asarray(np.linalg.inv(alternating) - J @ np.linalg.inv(K) @ J.T)


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


@functools.cache
def shipped() -> Process:
    """Return the process of the package's file, read once."""
    return read(PLACE, lambda table: Process(*(np.asarray(table[name], float) for name in Process._fields)))

"""Tilt of the scales of a row: how a scale yields to loads that its neighbours do not share; E = 1 and d = 1.

The joint's matrix K is that of scales which all move alike. Embedded parts lie in each other's strain fields, so a
scale gives more where its neighbours bear less: at the ends of a row, where contacts come in one by one, along a graded
part. With W_i the wrench of the contacts between scales i and i + 1 on scale i, in its axes and about the place halfway
to the next one, each scale moves on its joint and besides by

    B (W_i - W_(i-1)),        B = C - C_K

C is the compliance (6, 6) of a scale where every second one bears the opposite load (linear elements,
``tools/alternating.py``), C_K that of a bar with joints K under these loads. Contacts press along n_Z and turn a scale
mainly about its width n_Y. So B is taken to be g g^T with g = (B_uY, B_XY, B_YY)/sqrt(B_YY) over u_Z, w_X and w_Y: one
tilt of stiffness 1 for each scale, which moves it by g (docs, theory: row).

The outputs ln B_YY, ln(-B_XY/sin(alpha)), ln(-B_uY) of a Gaussian process over the features of
:mod:`squama.joints.law` are fitted to linear elements (``tools/neighbours.py``). What a joint gives right at its edges
has no part in B: elements of half the size change the joint's compliance by half, and B by 4 %.
"""

from __future__ import annotations

import functools
from pathlib import Path
from typing import NamedTuple

import numpy as np

from squama.joints import law
from squama.joints.law import Shape
from squama.joints.processes import nearness, read
from squama.types import Array

PLACE = Path(__file__).with_name("tilt.npz")
STEEP, NARROW = np.radians(66.0), 0.45
"""Largest alpha, and least width of the bar times cos(alpha) in pitches, of the designs that are fitted: beyond, a rod
between scales describes the bar badly, B is not positive, and there is no tilt.
"""


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


@functools.cache
def shipped() -> Process:
    """Return the process of the package's file, read once."""
    return read(PLACE, lambda table: Process(*(np.asarray(table[name], float) for name in Process._fields)))

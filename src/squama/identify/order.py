"""Check whether the rows of a record are in the order measured, or sorted by twist with both branches mixed up."""

from __future__ import annotations

import numpy as np

from squama.identify import noise
from squama.types import Array

_ROWS = 2000
"""Number of rows at the largest twists that are checked."""
_PAIRS, _APART = 5, 4.0
"""Least number of twists with two rows, in the farther half, for a verdict; least distance of their torques over the
roughness of the higher ones.
"""


def mixed(twist: Array, torque: Array) -> bool:
    """Return whether rows are sorted by twist while their torque jumps between two branches.

    Where the rows of loading and unloading have the same twists, the torques of such pairs lie far apart, and the
    higher ones are a smooth curve; else see :func:`noise.interleaved`.
    """
    steps = np.diff(twist)
    if not steps.size or (steps.min() < 0 < steps.max()):
        return False
    # the farthest twists last
    order = np.argsort(np.abs(twist), kind="stable")[-_ROWS:]
    x, y = twist[order], torque[order]
    if noise.interleaved(x, y, np.zeros(x.size)):
        return True
    pairs = np.flatnonzero(np.diff(x) == 0)
    pairs = pairs[np.abs(x[pairs]) >= np.median(np.abs(x))]
    if pairs.size < _PAIRS:
        return False
    apart, top = np.abs(y[pairs + 1] - y[pairs]), np.maximum(y[pairs + 1], y[pairs])
    return bool(np.median(apart) > _APART * np.median(np.abs(np.diff(top, 2))))

"""Whether the rows of a record are in the order measured, or sorted by the twist, both branches mixed up."""

from __future__ import annotations

import numpy as np

from squama.identify import noise
from squama.types import Array

_ROWS = 2000
"""Rows at the farthest twists by which it is told."""
_PAIRS, _APART = 5, 4.0
"""Twists with two rows, in the farther half, from which on it is told; distance of their torques over how rough the
higher ones are."""


def mixed(twist: Array, torque: Array) -> bool:
    """Say whether rows are sorted by the twist while their torque jumps between two branches.

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

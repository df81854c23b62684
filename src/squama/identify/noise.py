r"""Analysis of a fit's residual: noise, stray points, number of independent points, and covariance.

Neighbours on one way of a test resemble each other where the model misses something or the noise is slow. With the
correlations r_k of residuals k points apart, n points are worth n/tau independent ones,

.. math:: \tau = \max\Bigl(1 + 2 \sum_k r_k,\; \frac{1 + r_1}{1 - r_1}\Bigr),

summed up to the first r_k that noise alone would give. Where residuals grow with the slope of the
curve (noise of the twist) the covariance is the sandwich of MacKinnon and White (1985, HC3), else that of least
squares; both times tau.
"""

from __future__ import annotations

import itertools
import math

import numpy as np
from numpy.typing import NDArray

from squama.types import Array

_MAD = 1.4826
_BESIDE, _WINDOW, _LEAST = 3, 25, 9
_BRANCHES = 0.25
"""Ratio of the distances from smooth curves, within the points above and below to that of all, below which these are
two branches; noise has 0.6 and more.
"""
_STRAY, _MOST = 6.0, 0.03
"""Standard deviations, by its neighbours, that make a point stray; largest share of the points that may be stray."""
_ROWS = 2000
"""Number of rows at the largest twists that are checked."""
_PAIRS, _BETWEEN = 5, 4.0
"""Least number of twists with two rows, in the farther half, for a verdict; least distance of their torques over the
roughness of the higher ones.
"""
_LEVEL = 1.65
"""Bound of correlations of pure noise, times the root of the number of points: exceeded in 5 of 100 cases."""
_UNEVEN = 2.33
"""Rank correlation, times the root of the number of points, that even noise exceeds once in 100 cases."""


def scatter(torque: Array, way: Array) -> float:
    """Return the noise of a torque (its unit), robustly, from second differences along the ways."""
    inside = (way[2:] == way[1:-1]) & (way[1:-1] == way[:-2])
    second = (torque[2:] - 2 * torque[1:-1] + torque[:-2])[inside]
    return _MAD * float(np.median(np.abs(second))) / math.sqrt(6) if second.size else 0.0


def smooth(x: Array, y: Array, turns: list[int]) -> Array:
    """Return y smoothed by running lines over x, of seven neighbours on a way between turns; shorter ways unchanged."""
    out, width = y.copy(), 2 * _BESIDE + 1
    for a, b in itertools.pairwise([0, *(i + 1 for i in turns), y.size]):
        if b - a < width:
            continue
        first = np.clip(np.arange(b - a) - _BESIDE, 0, b - a - width)
        near, beside = (np.lib.stride_tricks.sliding_window_view(v[a:b], width)[first] for v in (x, y))
        apart = near - near.mean(axis=1, keepdims=True)
        square = np.einsum("ij,ij->i", apart, apart)
        steep = np.divide(np.einsum("ij,ij->i", apart, beside), square, out=np.zeros(b - a), where=square > 0)
        out[a:b] = beside.mean(axis=1) + steep * (x[a:b] - near.mean(axis=1))
    return out


def strays(residual: Array, way: Array, least: float) -> NDArray[np.bool_]:
    """Return which points differ from their neighbours on the same way far more than others do, and by ``least``."""
    apart, local, found = np.zeros(residual.size), np.zeros(residual.size), np.zeros(residual.size, bool)
    for number in np.unique(way):
        own = np.flatnonzero(way == number)
        if own.size < _LEAST:
            continue
        beside = _windows(residual[own], _BESIDE)
        apart[own] = residual[own] - np.median(np.delete(beside, _BESIDE, axis=1), axis=1)
        reach = min(_WINDOW // 2, own.size - 1)
        local[own] = np.median(_windows(np.abs(apart[own]), reach), axis=1)
        found[own] = True
    if not found.any():
        return found
    scale = _MAD * np.maximum(local, np.median(np.abs(apart[found])))
    found &= np.abs(apart) > np.maximum(_STRAY * scale, least)
    return found & (np.count_nonzero(found) <= max(1, _MOST * residual.size))


def _windows(values: Array, reach: int) -> Array:
    """Return every value with its neighbours, shape (n, 2 reach + 1); mirrored at the ends."""
    return np.lib.stride_tricks.sliding_window_view(np.pad(values, reach, mode="reflect"), 2 * reach + 1)


def interleaved(twist: Array, torque: Array) -> bool:
    """Return whether the torque jumps between two branches, e.g. because rows are sorted by twist."""
    # at the larger twists branches lie apart: the points above and below lines through their neighbours then each form
    # a smooth curve, much smoother than the halves of pure noise
    far = np.abs(twist) > np.median(np.abs(twist))
    x, y = twist[far], torque[far]
    if x.size < 2 * _LEAST:
        return False
    apart = _from_lines(x, y)
    halves = [apart > 0, apart <= 0]
    if min(map(np.count_nonzero, halves)) < _LEAST:
        return False
    rough = np.concatenate([np.abs(_from_lines(x[half], y[half])) for half in halves])
    return float(np.median(rough)) < _BRANCHES * float(np.median(np.abs(apart)))


def mixed(twist: Array, torque: Array) -> bool:
    """Return whether rows are sorted by twist while their torque jumps between two branches."""
    steps = np.diff(twist)
    if not steps.size or (steps.min() < 0 < steps.max()):
        return False
    # the farthest twists last
    order = np.argsort(np.abs(twist), kind="stable")[-_ROWS:]
    x, y = twist[order], torque[order]
    if interleaved(x, y):
        return True
    pairs = np.flatnonzero(np.diff(x) == 0)
    pairs = pairs[np.abs(x[pairs]) >= np.median(np.abs(x))]
    if pairs.size < _PAIRS:
        return False
    # rows of loading and unloading at the same twists: far apart, and the higher ones are a smooth curve
    apart, top = np.abs(y[pairs + 1] - y[pairs]), np.maximum(y[pairs + 1], y[pairs])
    return bool(np.median(apart) > _BETWEEN * np.median(np.abs(np.diff(top, 2))))


def _from_lines(x: Array, y: Array) -> Array:
    """Return the distance of each point from the line through its neighbours on both sides."""
    out = np.empty(x.size)
    for i in range(x.size):
        first = min(max(i - _BESIDE, 0), x.size - 2 * _BESIDE - 1)
        near = np.delete(np.arange(first, first + 2 * _BESIDE + 1), i - first)
        a, b = x[near] - x[i], y[near]
        spread = a - a.mean()
        square = float(spread @ spread)
        out[i] = y[i] - b.mean() + (float(spread @ b) / square if square > 0 else 0.0) * a.mean()
    return out


def dependence(residual: Array, way: Array) -> float:
    """Return tau, the number of points that are worth one independent point."""
    n, square = residual.size, float(np.mean(residual**2))
    if n < 2 * _LEAST or square == 0:
        return 1.0
    total, first = 0.0, 0.0
    for k in range(1, n // 4):
        same = way[k:] == way[:-k]
        pairs = int(np.count_nonzero(same))
        if pairs < _LEAST:
            break
        r = float(np.mean((residual[k:] * residual[:-k])[same])) / square
        if r < _LEVEL / math.sqrt(pairs):
            break
        first = first or min(r, 0.99)
        total += r * pairs / n
    return max(1 + 2 * total, (1 + first) / (1 - first))


def uneven(residual: Array, slope: Array) -> bool:
    """Return whether residuals grow with the slope, by the correlation of their ranks (Spearman)."""
    from scipy.stats import spearmanr

    steep = np.abs(slope)
    if residual.size < 2 * _LEAST or not np.ptp(steep) > 1e-9 * steep.max():
        return False
    r = spearmanr(np.abs(residual), np.round(steep / steep.max(), 9)).statistic
    return bool(r * math.sqrt(residual.size - 1) > _UNEVEN)


def sandwich(jacobian: Array, residual: Array, inner: Array) -> Array:
    """Return the covariance HC3 (parameters, parameters); ``inner`` is the inverse of J^T J."""
    leverage = np.einsum("ij,jk,ik->i", jacobian, inner, jacobian)
    J = jacobian * (residual / np.maximum(1 - leverage, 1e-3))[:, None]
    return np.asarray(inner @ (J.T @ J) @ inner)

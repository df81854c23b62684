"""Where the path of a contact ends: the first margin to vanish, for many designs at once.

Every path is sampled coarsely first. Where the margins are so smooth that nothing can hide between two samples, the
first interval in which one changes sign is kept; the other paths are sampled again, four times as closely, and local
minima that come near zero are followed to their bottom. The end is then solved in its interval by a bracketing method
to full precision. Paths are sampled in blocks that stay in the processor's cache.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from squama.model.mechanics import Row, margins, named_margins
from squama.model.neighbours import first_crossing
from squama.model.outcome import CODES, End
from squama.model.paths import ARRAY, FLOAT, FoldedTwist, Twist
from squama.model.solve import Array, blocks, first_zero, lowest, point, take
from squama.model.twisting import Number

STEPS = np.concatenate([np.linspace(0.0, 0.55, 29)[:-1], np.linspace(0.55, 1.0, 13)])
"""Samples of an open path as fractions of its parameter; closer together up to about 100 deg, where most end."""
FOLDED_STEPS = np.linspace(0.0, 1.0, 81)
"""Samples of a folded path, on which the twist grows large and farther neighbours come and go."""
_COARSE = 4
_CHUNK = 14
_SAFETY = 0.25
_NONE = 10**6
_COINCIDE = 1e-11
_DEEP = 0.5


class Track(NamedTuple):
    """Paths of n designs: ``row`` holds their ratios, from ``x0`` to ``x_end`` where ``code`` names the end.

    ``crossing`` tells, for an end by another neighbour's tip-side contact, which neighbour came in (else 0).
    """

    row: Row
    x0: Array
    x_end: Array
    code: Array
    crossing: Array


class _Scan(NamedTuple):
    """Brackets of the first end and of the first fold of n paths.

    ``a`` is NaN where nothing ends the path, ``fold_a`` where there is no fold before the end or just behind it.
    A path that has ended where it begins has a = b = x0.
    """

    a: Array
    b: Array
    fold_a: Array
    fold_b: Array


def half_turn(n: int) -> Array:
    """Largest inclination looked at: 179 deg, where the scale lies on its back."""
    return np.full(n, math.radians(179))


def track(row: Any, x1: Array, mu: Array, law: str) -> list[tuple[Array, Track]]:
    """Follow engaged paths to their ends, at most to the path parameter ``x1``.

    Parameters
    ----------
    row
        A row of arrays, one entry a design, all engaged.
    x1, mu
        End of the search and coefficient of friction of every design.
    law
        Force law.

    Returns
    -------
    list of (index, Track)
        The designs grouped by the kind of row that follows them (open or folded).
    """
    x0 = np.asarray(row.theta0, float)
    scan = _scan(row, x0, x1, mu, law)
    folded = ~np.isnan(scan.fold_a)
    groups = []
    index = np.flatnonzero(~folded)
    if index.size:
        sub: Any = row if index.size == x0.size else take(row, index)
        groups.append((index, _solve(sub, x0[index], x1[index], scan.a[index], scan.b[index], mu[index], law)))
    index = np.flatnonzero(folded)
    if index.size:
        sub = take(row, index)
        theta_f = _fold(sub, scan.fold_a[index], scan.fold_b[index])
        bent = FoldedTwist(sub.eta, sub.beta, sub.lam, sub.sa, sub.ca, sub.theta0, theta_f, sub.k)
        tau = np.sqrt(bent.theta_f - x0[index])
        scan = _closely(bent, -tau, tau, mu[index], law)
        groups.append((index, _solve(bent, -tau, tau, scan.a, scan.b, mu[index], law)))
    return groups


def _first(flags: Array) -> Array:
    """First sample flagged along axis 0; _NONE where there is none."""
    return np.where(flags.any(axis=0), flags.argmax(axis=0), _NONE)


def _scan(row: Any, x0: Array, x1: Array, mu: Array, law: str) -> _Scan:
    """Bracket the ends and folds of open paths; closely only where a coarse look does not settle them."""
    a, b, fold_a, fold_b = np.full((4, x0.size), np.nan)
    steps = STEPS[::_COARSE]
    unsettled = []
    for part in blocks(x0.size):
        low, q = _sample(take(row, part), x0[part], x1[part], mu[part], law, steps)
        first = _first(~(low > 0))
        settled = (first < _NONE) & _smooth(low, first - 1) & _smooth(q * q, first)
        unsettled.append(np.flatnonzero(~settled) + part.start)
        j = np.minimum(first, steps.size - 1)
        span = (x1 - x0)[part]
        a[part], b[part] = x0[part] + span * steps[np.maximum(j - 1, 0)], x0[part] + span * steps[j]
    index = np.concatenate(unsettled)
    if index.size:
        close = _closely(take(row, index), x0[index], x1[index], mu[index], law)
        a[index], b[index], fold_a[index], fold_b[index] = close
    return _Scan(a, b, fold_a, fold_b)


def _smooth(values: Array, stop: Array) -> Array:
    """Whether nothing can hide between the samples up to ``stop``: the smallest of two minus their bend stays > 0."""
    bend = np.abs(values[2:] - 2 * values[1:-1] + values[:-2])
    bend = np.concatenate([bend[:1], np.maximum(bend[1:], bend[:-1]), bend[-1:]])
    safe = np.minimum(values[1:], values[:-1]) > bend * _SAFETY
    return np.asarray((safe | (np.arange(safe.shape[0])[:, None] >= stop)).all(axis=0))


def _closely(row: Any, x0: Array, x1: Array, mu: Array, law: str) -> _Scan:
    """Bracket the ends and folds of paths by close samples, and by the dips between them."""
    n, steps = x0.size, FOLDED_STEPS if isinstance(row, FoldedTwist) else STEPS
    first, fold = np.full(n, _NONE), np.full(n, _NONE)
    lows: list[tuple[Array, Array]] = []
    folds: list[tuple[Array, Array]] = []
    for part in blocks(n):
        low, q = _sample(take(row, part), x0[part], x1[part], mu[part], law, steps)
        first[part] = _first(~(low > 0))
        lows.append(_dips(low, first[part], part.start))
        if isinstance(row, Twist):
            fold[part] = _first(np.isnan(q))
            folds.append(_dips(q * q, first[part], part.start))
    a, b = _bottoms(_event(type(row), law), row, x0, x1, mu, lows, first, steps)
    fold_a, fold_b = np.full((2, n), np.nan)
    if folds:
        fold_a, fold_b = _bottoms(_square, row, x0, x1, mu, folds, fold, steps)
        _fold_in_last(row, a, b, fold_a, fold_b)
        # a contact that has ended already where it begins, or well before the fold, does not get there
        beyond = (first == 0) | (fold > first + 4)
        fold_a[beyond & (fold < _NONE)] = np.nan
    return _Scan(a, b, fold_a, fold_b)


def _sample(row: Any, x0: Array, x1: Array, mu: Array, law: str, steps: Array) -> tuple[Array, Array]:
    """Smallest margin and root at the samples up to the end of each path (whatever stands there beyond it)."""
    low, q = np.ones((2, steps.size, x0.size))
    alive = np.arange(x0.size)
    for start in range(0, steps.size, _CHUNK):
        sub, rows = take(row, alive), slice(start, start + _CHUNK)
        with np.errstate(all="ignore"):
            pt = sub.point(x0[alive] + (x1 - x0)[alive] * steps[rows, None], law, ARRAY)
            low[rows, alive] = np.minimum.reduce(named_margins(sub, pt, mu[alive]))
        q[rows, alive] = pt.q
        alive = alive[(low[rows, alive] > 0).all(axis=0)]
        if alive.size == 0:
            break
    return low, q


def _dips(values: Array, stop: Array, offset: int) -> tuple[Array, Array]:
    """Find local minima before ``stop`` that a parabola takes below half their value: samples and designs."""
    left, middle, right = values[:-2], values[1:-1], values[2:]
    dip = (middle > 0) & (middle <= left) & (middle < right) & (np.arange(1, values.shape[0] - 1)[:, None] < stop)
    i, lane = np.nonzero(dip)
    left, middle, right = left[i, lane], middle[i, lane], right[i, lane]
    bottom = middle - (right - left) ** 2 / (8 * (right + left - 2 * middle))
    deep = bottom < _DEEP * middle
    return i[deep] + 1, lane[deep] + offset


def _bottoms(
    f: Callable[..., Number],
    row: Any,
    x0: Array,
    x1: Array,
    mu: Array,
    dips: list[tuple[Array, Array]],
    first: Array,
    steps: Array,
) -> tuple[Array, Array]:
    """Bracket the first sample, or the first dip whose bottom is below zero; NaN where there is neither."""
    span = x1 - x0
    j = np.minimum(first, steps.size - 1)
    a = np.where(first < _NONE, x0 + span * steps[np.maximum(j - 1, 0)], np.nan)
    b = x0 + span * steps[j]
    i = np.concatenate([d[0] for d in dips])
    lane = np.concatenate([d[1] for d in dips])
    if i.size == 0:
        return a, b
    three = tuple(x0[lane] + span[lane] * steps[i + shift] for shift in (-1, 0, 1))
    with np.errstate(all="ignore"):
        x, value = lowest(f, three, (*take(row, lane), mu[lane]))
    # the earliest dip of a design wins: go through them from the latest
    for n in np.argsort(-i, kind="stable"):
        if value[n] < 0:
            a[lane[n]], b[lane[n]] = three[0][n], x[n]
    return a, b


def _fold_in_last(row: Twist, a: Array, b: Array, fold_a: Array, fold_b: Array) -> None:
    """Look for a fold and its way back within the interval in which the path ends."""
    index = np.flatnonzero((b > a) & np.isnan(fold_a))
    x = a[index] + (b - a)[index] * np.linspace(0.0, 1.0, 9)[1:-1, None]
    with np.errstate(all="ignore"):
        inside = ~(take(row, index).root(x, ARRAY).q2 > 0)
    for n in np.flatnonzero(inside.any(axis=0)):
        fold_a[index[n]], fold_b[index[n]] = a[index[n]], x[inside[:, n].argmax(), n]


def _event(kind: type[Any], law: str) -> Callable[..., Number]:
    """Smallest margin as a function of the path parameter, the row's entries and mu."""

    def event(x: Number, *cols: Number) -> Number:
        if isinstance(x, float):
            return float(min(margins(kind(*cols[:-1]), x, cols[-1], law, FLOAT)))
        return np.minimum.reduce(margins(kind(*cols[:-1]), x, cols[-1], law, ARRAY))

    return event


def _square(x: Number, *cols: Number) -> Number:
    return Twist(*cols[:-1]).root(x, ARRAY).q2


def _fold(row: Twist, low: Array, high: Array) -> Array:
    """Inclination of the fold, where the two roots of the contact condition meet."""

    def square(theta: Number, *cols: Number) -> Number:
        return Twist(*cols).root(theta, FLOAT if isinstance(theta, float) else ARRAY).q2

    return first_zero(square, low, high, tuple(row))


def _solve(row: Any, x0: Array, x1: Array, a: Array, b: Array, mu: Array, law: str) -> Track:
    """Solve every end in its interval and name it."""
    n = x0.size
    x_end = x1.copy()
    # a folded path that reaches its far end has come back to theta0, where the spring is at rest
    unended = End.RELEASED if isinstance(row, FoldedTwist) else End.RANGE
    code = np.full(n, CODES.index(unended), np.int8)
    inside, start = np.flatnonzero(b > a), np.flatnonzero(b == a)
    x_end[start] = x0[start]
    if inside.size:
        cols = (*take(row, inside), mu[inside])
        with np.errstate(all="ignore"):
            x_end[inside] = first_zero(_event(type(row), law), a[inside], b[inside], cols)
    met = np.flatnonzero(b >= a)
    if met.size:
        code[met] = _names(take(row, met), x_end[met], mu[met], law)
        code[start[code[start] == CODES.index(End.FRICTIONAL)]] = CODES.index(End.STATIC)
    if not isinstance(row, Twist | FoldedTwist):
        return Track(row, x0, x_end, code, np.zeros(n, np.int64))
    crossing = first_crossing(row, x0, x_end)
    other = crossing.x < x_end
    x_end = np.where(other, crossing.x, x_end)
    code[other] = CODES.index(End.OTHER)
    return Track(row, x0, x_end, code, np.where(other, crossing.k, 0))


def _names(row: Any, x_end: Array, mu: Array, law: str) -> Array:
    """Codes of the margins that vanish at the ends; where two coincide, of the first in ``row.ENDS``."""
    values = np.stack(np.broadcast_arrays(*named_margins(row, point(row, x_end, law), mu)))
    zero = ~(values > _COINCIDE)
    which = zero.argmax(axis=0)
    none = ~zero.any(axis=0)
    if none.any():
        which[none] = np.nan_to_num(values[:, none], nan=-1.0).argmin(axis=0)
    return np.asarray(np.array([CODES.index(e) for e in row.ENDS], np.int8)[which])

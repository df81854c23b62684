"""Samples of paths, and the brackets of their ends and folds that they show, for many designs at once.

Every path is sampled coarsely first. Where the margins are so smooth that nothing can hide between two samples, the
first interval in which one changes sign is kept; the other paths are sampled again, four times as closely, and local
minima that come near zero are followed to their bottom. Paths are sampled in blocks that stay in the processor's cache.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from squama.model import formulas
from squama.model.mechanics import margins
from squama.model.paths import FLOAT, FoldedTwist, Twist
from squama.model.solve import FEW, Array, blocks, lowest, take
from squama.model.twisting import Number

STEPS = np.concatenate([np.linspace(0.0, 0.55, 29)[:-1], np.linspace(0.55, 1.0, 13)])
"""Samples of an open path as fractions of its parameter; closer together up to about 100 deg, where most end."""
FOLDED_STEPS = np.linspace(0.0, 1.0, 81)
"""Samples of a folded path, on which the twist grows large and farther neighbours come and go."""
COARSE, FOLDED_COARSE = 4, 5
"""Every so many of these samples are looked at first."""
SAFETY = 0.25
"""Part of the bend seen in three samples by which a margin may differ from them in between."""
DEEP = 0.5
"""Minima are followed whose parabola goes below this part of the lowest sample."""
_CHUNK, _COARSE_CHUNK = 14, 6
_NONE = 10**6


class Scan(NamedTuple):
    """Brackets of the first end and of the first fold of n paths.

    ``a`` is NaN where nothing ends the path, ``fold_a`` where there is no fold before the end or just behind it.
    A path that has ended where it begins has a = b = x0. ``fa``, ``fb`` are the smallest margins there, ``fc`` that at
    another place ``c`` (NaN where there is none).
    """

    a: Array
    b: Array
    fa: Array
    fb: Array
    c: Array
    fc: Array
    fold_a: Array
    fold_b: Array


def _first(flags: Array) -> Array:
    """First sample flagged along axis 0; _NONE where there is none."""
    return np.where(flags.any(axis=0), flags.argmax(axis=0), _NONE)


def scan(row: Any, x0: Array, x1: Array, mu: Array, law: str) -> Scan:
    """Bracket the ends and folds of paths from ``x0`` to ``x1``; closely only where a coarse look settles nothing."""
    found, bent = Scan(*np.empty((len(Scan._fields), x0.size))), isinstance(row, FoldedTwist)
    if bent:
        found.fold_a[:] = found.fold_b[:] = np.nan
    steps = FOLDED_STEPS[::FOLDED_COARSE] if bent else STEPS[::COARSE]
    chunk = _COARSE_CHUNK if x0.size > FEW else steps.size
    unsettled = []
    for part in blocks(x0.size):
        found_here = _sample(take(row, part), x0[part], x1[part], mu[part], law, steps, chunk)
        low, square, every = *found_here[:2], found_here[2:]
        first = _first(~(low > 0))
        brackets = _around(low, first, x0[part], (x1 - x0)[part], steps)
        settled = (first < _NONE) & _calm(every, first)
        if not bent:
            # the path bends back before it has ended: what comes before is looked at on the folded path
            folds = (first == _first(square < 0)) & (first > 0) & (first < _NONE)
            folds &= _smooth(square, first - 1) & _falls(square, first)
            settled = (settled & _smooth(square, first)) | folds
            brackets += tuple(np.where(folds, brackets[:2], np.nan))
        unsettled.append(np.flatnonzero(~settled) + part.start)
        for column, values in zip(found, brackets, strict=False):
            column[part] = values
    index = np.concatenate(unsettled)
    if index.size:
        close = _closely(take(row, index), x0[index], x1[index], mu[index], law)
        for column, values in zip(found, close, strict=True):
            column[index] = values
    return found


def _around(low: Array, first: Array, x0: Array, span: Array, steps: Array) -> tuple[Array, ...]:
    """Places and smallest margins before and at the sample ``first``, and one sample earlier; as in :class:`Scan`."""
    lane, j = np.arange(first.size), np.minimum(first, steps.size - 1)
    i, h = np.maximum(j - 1, 0), np.maximum(j - 2, 0)
    a = np.where(first < _NONE, x0 + span * steps[i], np.nan)
    third = np.where(j > 1, x0 + span * steps[h], np.nan)
    return a, x0 + span * steps[j], low[i, lane], low[j, lane], third, low[h, lane]


def _bend(values: Array) -> Array:
    """By how much a value may differ from its samples in the intervals between them."""
    bend = np.abs(values[2:] - 2 * values[1:-1] + values[:-2]) * SAFETY
    return np.concatenate([bend[:1], np.maximum(bend[1:], bend[:-1]), bend[-1:]])


def _smooth(values: Array, stop: Array) -> Array:
    """Whether nothing can hide between the samples up to ``stop``: the smallest of two minus their bend stays > 0."""
    safe = np.minimum(values[1:], values[:-1]) > _bend(values)
    return np.asarray((safe | (np.arange(safe.shape[0])[:, None] >= stop)).all(axis=0))


def _calm(margins: Array, first: Array) -> Array:
    """Whether no margin can vanish between the samples, up to the sample ``first`` that has ended each path.

    In the last interval, before that sample, the margins that end the path there may.
    """
    s = np.arange(2, margins.shape[1])[:, None]
    over, last = first < s, first == s
    hidden = np.zeros(over.shape, bool)
    # many designs one margin at a time, for the cache; few all at once
    with np.errstate(all="ignore"):
        for v in margins[:, None] if first.size > FEW else margins[None]:
            hidden |= hides(v[:, :-2], v[:, 1:-1], v[:, 2:], last, np.minimum).any(axis=0)
    return np.asarray(~(hidden & ~over).any(axis=0))


def hides(a: Any, b: Any, c: Any, last: Any, minimum: Callable[[Any, Any], Any]) -> Any:
    """Whether a margin might vanish between its samples a, b and c; it may where it ends the path at the last one."""
    before, after, bend = minimum(a, b), minimum(b, c), abs(c - 2 * b + a) * SAFETY
    return ~(before > bend) | (~(after > bend) & ((c > 0) | ~last))


def _falls(values: Array, stop: Array) -> Array:
    """Whether values fall through zero just once between the sample before ``stop`` and that one."""
    lane, i = np.arange(stop.size), np.clip(stop, 1, values.shape[0] - 1) - 1
    bend = _bend(values)[i, lane]
    return np.asarray((values[i, lane] > bend) & (-values[i + 1, lane] > bend))


def _closely(row: Any, x0: Array, x1: Array, mu: Array, law: str) -> Scan:
    """Bracket the ends and folds of paths by close samples, and by the dips between them."""
    n, steps = x0.size, FOLDED_STEPS if isinstance(row, FoldedTwist) else STEPS
    first, fold = np.full(n, _NONE), np.full(n, _NONE)
    lows: list[list[tuple[Array, Array]]] = [[] for _ in row.ENDS]
    folds: list[tuple[Array, Array]] = []
    found = Scan(*np.full((len(Scan._fields), n), np.nan))
    for part in blocks(n):
        low, square, *every = _sample(take(row, part), x0[part], x1[part], mu[part], law, steps, _CHUNK)
        first[part] = _first(~(low > 0))
        for column, values in zip(found, _around(low, first[part], x0[part], (x1 - x0)[part], steps), strict=False):
            column[part] = values
        for dips, values in zip(lows, every, strict=True):
            # up to the sample that has ended the path: before it another margin may have dipped
            dips.append(_dips(values, first[part] + 1, part.start))
        if isinstance(row, Twist):
            fold[part] = _first(square < 0)
            i = np.minimum(fold[part], steps.size - 1)
            before, at = (x0[part] + (x1 - x0)[part] * steps[np.maximum(i + k, 0)] for k in (-1, 0))
            found.fold_a[part], found.fold_b[part] = np.where(fold[part] < _NONE, (before, at), np.nan)
            folds.append(_dips(square, first[part], part.start))
    seen = found.b.copy()
    for n, dips in enumerate(lows):
        _bottoms(_margin(type(row), law, n), row, x0, x1, mu, dips, steps, (found.a, found.b))
    moved = np.flatnonzero(~((found.b == seen) | np.isnan(found.b)))
    with np.errstate(all="ignore"):
        for x, value in ((found.a, found.fa), (found.b, found.fb)):
            value[moved] = formulas.least(take(row, moved), x[moved], mu[moved], law)
    found.c[moved] = found.fc[moved] = np.nan
    if folds:
        _bottoms(_square, row, x0, x1, mu, folds, steps, (found.fold_a, found.fold_b))
        _fold_in_last(row, found)
        # a contact that has ended already where it begins, or well before the fold, does not get there
        beyond = (first == 0) | (fold > first + 4)
        found.fold_a[beyond & (fold < _NONE)] = np.nan
    return found


def _sample(row: Any, x0: Array, x1: Array, mu: Array, law: str, steps: Array, chunk: int) -> Array:
    """Smallest margin, squared root, and margins at the samples up to the one after the end of each path.

    Beyond, the first two are 1.
    """
    found, span = np.empty((2 + len(row.ENDS), steps.size, x0.size)), x1 - x0
    found[:2] = 1
    alive, ended = np.arange(x0.size), np.zeros(x0.size, bool)
    for start in range(0, steps.size, chunk):
        rows = slice(start, start + chunk)
        with np.errstate(all="ignore"):
            # indices only where they are needed: they cost as much as the arithmetic
            if alive.size == x0.size:
                margin = formulas.margins(row, x0 + span * steps[rows, None], mu, law, found[:, rows])[0]
            else:
                x = x0[alive] + span[alive] * steps[rows, None]
                margin = (values := formulas.margins(take(row, alive), x, mu[alive], law))[0]
                found[:, rows, alive] = values
        # a path that has ended in the last of these samples goes on for the one after its end
        seen = margin > 0
        done = ended[alive] | ~seen[:-1].all(axis=0)
        ended[alive] = done | ~seen[-1]
        alive = alive[~done]
        if alive.size == 0:
            break
    return found


def _dips(values: Array, stop: Array, offset: int) -> tuple[Array, Array]:
    """Find local minima before ``stop`` that a parabola takes below half their value; return samples and designs."""
    left, middle, right = values[:-2], values[1:-1], values[2:]
    dip = (middle > 0) & (middle <= left) & (middle < right) & (np.arange(1, values.shape[0] - 1)[:, None] < stop)
    i, lane = np.nonzero(dip)
    left, middle, right = left[i, lane], middle[i, lane], right[i, lane]
    bottom = middle - (right - left) ** 2 / (8 * (right + left - 2 * middle))
    deep = bottom < DEEP * middle
    return i[deep] + 1, lane[deep] + offset


def _bottoms(
    f: Callable[..., Number],
    row: Any,
    x0: Array,
    x1: Array,
    mu: Array,
    dips: list[tuple[Array, Array]],
    steps: Array,
    bracket: tuple[Array, Array],
) -> None:
    """Let the brackets (a, b) end at the first dip whose bottom is below zero and before b."""
    i, lane = (np.concatenate(part) for part in zip(*dips, strict=True))
    if i.size == 0:
        return
    a, b = bracket
    three = tuple(x0[lane] + (x1 - x0)[lane] * steps[i + shift] for shift in (-1, 0, 1))
    with np.errstate(all="ignore"):
        x, value = lowest(f, three, (*take(row, lane), mu[lane]))
    # the earliest dip of a design wins: go through them from the latest
    for n in np.argsort(-x, kind="stable"):
        if value[n] < 0 and not x[n] > b[lane[n]]:
            a[lane[n]], b[lane[n]] = three[0][n], x[n]


def _fold_in_last(row: Twist, found: Scan) -> None:
    """Look for a fold and its way back within the interval in which the path ends."""
    index = np.flatnonzero((found.b > found.a) & np.isnan(found.fold_a))
    a, b = found.a[index], found.b[index]
    x = a + (b - a) * np.linspace(0.0, 1.0, 9)[1:-1, None]
    with np.errstate(all="ignore"):
        inside = ~(formulas.square(take(row, index), x) > 0)
    for n in np.flatnonzero(inside.any(axis=0)):
        found.fold_a[index[n]], found.fold_b[index[n]] = a[n], x[inside[:, n].argmax(), n]


def event(kind: type[Any], law: str) -> Callable[..., Number]:
    """Smallest margin as a function of the path parameter, the row's entries and mu."""

    def event(x: Number, *cols: Number) -> Number:
        if isinstance(x, float):
            return float(min(margins(kind(*cols[:-1]), x, cols[-1], law, FLOAT)))
        return formulas.least(kind(*cols[:-1]), x, cols[-1], law)

    return event


def _margin(kind: type[Any], law: str, n: int) -> Callable[..., Number]:
    """One margin as a function of the path parameter, the row's entries and mu."""
    return lambda x, *cols: formulas.margins(kind(*cols[:-1]), x, cols[-1], law)[2 + n]


def _square(x: Number, *cols: Number) -> Number:
    return formulas.square(Twist(*cols[:-1]), x)

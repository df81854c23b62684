"""Roots of margins, one lane on plain floats or many lanes in lock-step, and rows of arrays taken apart."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np

from squama.model import formulas
from squama.model.bracket import bracketed
from squama.model.paths import FLOAT, Point
from squama.model.twisting import Number

Array = np.ndarray[Any, np.dtype[Any]]


BLOCK = 4096
"""Designs sampled together: BLOCK x samples stay in the processor's cache."""
FEW = 64
"""Designs up to which a step costs the same for all: nothing is saved by leaving some out."""
LOCK_STEP = 16384
"""Roots solved in lock-step, for the same reason."""
SWEEPS = 200
"""Sweeps after which a lane is given up: bisection alone needs some 60."""
STILL, NEARLY = 1e-13, 1e-9
"""Relative steps of an interpolation after which no further one is made: in any case, and where the line through the
last two places leads to the same zero: then its own error is far smaller than the step."""
CLOSE = 1e-5
"""Relative length of the step before, at most: no longer than that the values follow a straight line."""


def blocks(n: int, size: int = BLOCK) -> Iterator[slice]:
    """Parts of n designs that are sampled together."""
    for low in range(0, n, size):
        yield slice(low, min(n, low + size))


def take(row: Any, index: Any) -> Any:
    """Return the designs ``index`` of a row of arrays."""
    return type(row)(*(np.asarray(col)[index] for col in row))


def scalar(row: Any, i: int = 0) -> Any:
    """Return design ``i`` of a row as plain floats."""
    return type(row)(*(float(np.asarray(col)[i]) for col in row))


def point(row: Any, x: Array, law: str) -> Point:
    """Evaluate the contacts of n designs at one path parameter each; a single design runs on plain floats."""
    with np.errstate(all="ignore"):
        if x.size == 1:
            return Point(*(np.array([v]) for v in scalar(row).point(float(x[0]), law, FLOAT)))
        return formulas.point(row, x, law)


def first_zero(
    f: Callable[..., Number], a: Array, b: Array, cols: tuple[Array, ...], known: Sequence[Array] | None = None
) -> Array:
    """Solve f(x, *cols) = 0 in every bracket [a, b], where f(a) > 0 >= f(b); NaN where that is not so.

    One lane runs on plain floats, many run in lock-step; both by Chandrupatla's method. ``known``, if given, are f(a),
    f(b), and a third place with its value (NaN where there is none).
    """
    if a.size == 1:
        args = tuple(float(c[0]) for c in cols)
        return np.array([bracketed(lambda x: float(f(x, *args)), float(a[0]), float(b[0]))])
    x = np.empty(a.size)
    for part in blocks(a.size, LOCK_STEP):
        lanes = tuple(np.broadcast_to(c, a.shape)[part] for c in cols)
        with np.errstate(all="ignore"):
            if known is None:
                none = np.full(lanes[0].size, np.nan)
                ends = [a[part], b[part], f(a[part], *lanes), f(b[part], *lanes), none, none]
            else:
                ends = [v[part] for v in (a, b, *known)]
            x[part] = _lock_step(f, ends, lanes)
    return x


def _lock_step(f: Callable[..., Number], known: Sequence[Array], cols: tuple[Array, ...]) -> Array:
    """Chandrupatla's method; the sweep after which interpolation hardly moves any more is the last."""
    a, b, fa, fb, c, fc = known
    out = np.where(fa == 0, a, np.nan)
    at = np.flatnonzero((fa > 0) & ~(fb > 0))
    x1, f1, x2, f2, x3, f3 = (v[at] for v in (a, fa, b, np.where(np.isnan(fb), -1.0, fb), c, fc))
    cols, live = tuple(v[at] for v in cols), np.ones(at.size, bool)
    t, safe = place(x1, f1, x2, f2, x3, f3)
    t = np.where(safe, t, 0.5)
    for _ in range(SWEEPS):
        x = x1 + t * (x2 - x1)
        value = f(x, *cols)
        value = np.where(np.isnan(value), -1.0, value)
        same, before = (value > 0) == (f1 > 0), (x1, f1)
        x3, f3, x2, f2 = np.where(same, x1, x2), np.where(same, f1, f2), np.where(same, x2, x1), np.where(same, f2, f1)
        x1, f1 = x, value
        t, safe = place(x1, f1, x2, f2, x3, f3)
        t = np.where(safe, t, 0.5)
        small, width = abs(f1), abs(x2 - x1)
        near = (t >= 0) & reached(t * (x2 - x1), x1, f1, *before)
        best = np.where(near, x1 + t * (x2 - x1), np.where(small < abs(f2), x1, x2))
        least = (2e-15 * abs(best) + 1e-300) / width
        done = live & (near | (least >= 0.5) | (f1 == 0))
        new = np.flatnonzero(done)
        out[at[new]] = best[new]
        live &= ~done
        left = np.count_nonzero(live)
        if left == 0:
            break
        # a lane that is done stays where it is until so many are that it pays to go on without them
        t = np.where(live, np.maximum(np.minimum(t, 1 - least), least), 0.0)
        if left < 0.5 * live.size:
            keep = np.flatnonzero(live)
            at, t, x1, f1, x2, f2 = (v[keep] for v in (at, t, x1, f1, x2, f2))
            cols, live = tuple(v[keep] for v in cols), np.ones(left, bool)
    return out


def place(x1: Any, f1: Any, x2: Any, f2: Any, x3: Any, f3: Any) -> tuple[Any, Any]:
    """Return where inverse quadratic interpolation puts the zero on the way from x1 to x2, and whether that is safe.

    x1 lies between x2 and x3. Arithmetic alone, over one denominator: every engine executes it.
    """
    f12, f31, f32, x21, x31 = f1 - f2, f3 - f1, f3 - f2, x2 - x1, x3 - x1
    t = f1 * (f3 * f31 * x21 + f2 * f12 * x31) / (f12 * f31 * f32 * x21)
    all_ = abs(x3 - x2)
    return t, (f12 * f12 * all_ < abs(x21) * (f32 * f32)) & (f31 * f31 * all_ < abs(x31) * (f32 * f32))


def reached(step: Any, x: Any, f: Any, before: Any, value_before: Any) -> Any:
    """Whether a step from x, with the value f, ends at the zero to all digits; x is one step from ``before``."""
    moved, size = x - before, abs(x)
    straight = abs(f * moved + step * (f - value_before)) <= 1e-3 * abs(f * moved)
    short = (abs(step) <= STILL * size) | ((abs(step) <= NEARLY * size) & straight)
    return short & (abs(f) <= 1e-4 * abs(value_before)) & (abs(moved) <= CLOSE * size)


def lowest(f: Callable[..., Number], x: tuple[Array, ...], cols: tuple[Array, ...]) -> tuple[Array, Array]:
    """Minimise f(x, *cols) in every bracket of three points whose middle is the lowest; return place and value."""
    from scipy.optimize import elementwise

    res = elementwise.find_minimum(f, x, args=cols)  # type: ignore[arg-type]
    return np.asarray(res.x), np.asarray(res.f_x)

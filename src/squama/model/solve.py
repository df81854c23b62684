"""Roots of margins, one lane on plain floats or many lanes in lock-step, and rows of arrays taken apart."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from squama.model.bracket import bracketed
from squama.model.paths import ARRAY, FLOAT, Point
from squama.model.twisting import Number

Array = np.ndarray[Any, np.dtype[Any]]


BLOCK = 1024
"""Designs sampled together: BLOCK x samples stay in the processor's cache."""
LOCK_STEP = 16384
"""Roots solved in lock-step, for the same reason."""


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
        pt: Point = row.point(x, law, ARRAY)
        return pt


def first_zero(f: Callable[..., Number], a: Array, b: Array, cols: tuple[Array, ...]) -> Array:
    """Solve f(x, *cols) = 0 in every bracket [a, b], where f(a) > 0 >= f(b).

    One lane runs on plain floats, many run in lock-step; both by Chandrupatla's method.
    """
    if a.size == 1:
        args = tuple(float(c[0]) for c in cols)
        return np.array([bracketed(lambda x: float(f(x, *args)), float(a[0]), float(b[0]))])
    from scipy.optimize import elementwise

    x = np.empty(a.size)
    exact = {"xatol": 0, "xrtol": 4e-16, "fatol": 0, "frtol": 0}
    for low in range(0, a.size, LOCK_STEP):
        part = slice(low, low + LOCK_STEP)
        lanes = tuple(np.broadcast_to(c, a.shape)[part] for c in cols)
        res = elementwise.find_root(f, (a[part], b[part]), args=lanes, tolerances=exact, maxiter=200)  # type: ignore[call-overload]
        x[part] = res.x
    return x


def lowest(f: Callable[..., Number], x: tuple[Array, ...], cols: tuple[Array, ...]) -> tuple[Array, Array]:
    """Minimise f(x, *cols) in every bracket of three points whose middle is the lowest; return place and value."""
    from scipy.optimize import elementwise

    res = elementwise.find_minimum(f, x, args=cols)  # type: ignore[arg-type]
    return np.asarray(res.x), np.asarray(res.f_x)

"""Checks of array arguments: one clear line, or the array as floats."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NoReturn

import numpy as np
from numpy.typing import ArrayLike

from squama.errors import InputError
from squama.model import reach
from squama.model.laws import LAWS
from squama.model.solve import Array

EXAMPLES = {
    "eta": "3",
    "beta": "1.25",
    "lam": "0.45",
    "alpha": "np.radians(45)",
    "theta0": "np.radians(10)",
    "theta": "np.radians(20)",
    "mu": "0.25",
    "margin": "0.01",
    "points": "200",
    "at": "5",
    "scales": "25",
    "neighbour": "1",
    "stiffness_ratio": "1",
}
"""What to write, by the name of an argument."""


def fail(text: str) -> NoReturn:
    """Raise the error with this text."""
    raise InputError(text) from None


def numbers(name: str, value: ArrayLike) -> Array:
    """Return finite numbers as an array of floats."""
    try:
        array = np.asarray(value, dtype=float)
    except (TypeError, ValueError):
        fail(f"{name} = {value!r:.60}: give a number or an array of numbers")
    _refuse(name, array, ~np.isfinite(array), "a finite number")
    return array


def _refuse(name: str, array: Array, bad: Any, allowed: str) -> None:
    if np.any(bad):
        first = float(np.ravel(array)[np.flatnonzero(np.ravel(bad))[0]])
        count = int(np.count_nonzero(bad))
        where = f" (and {count - 1} more)" if count > 1 else ""
        fail(f"{name} = {first:.6g}{where}: must be {allowed}{_remedy(name, allowed)}")


def _remedy(name: str, allowed: str = "") -> str:
    return f"; write e.g. {EXAMPLES[name]}" if name in EXAMPLES and "write" not in allowed else ""


def positive(name: str, value: ArrayLike) -> Array:
    """Return numbers above zero."""
    array = numbers(name, value)
    _refuse(name, array, array <= 0, "above 0")
    return array


def overlap(name: str, value: ArrayLike) -> Array:
    """Return eta or beta: above zero, and not so large that neighbours without end are within reach."""
    array = numbers(name, value)
    _refuse(name, array, (array <= 0) | (array > reach.MOST), reach.ALLOWED)
    return array


def ratio(name: str, value: ArrayLike) -> Array:
    """Return eta, beta or another ratio above zero, within its bounds."""
    return overlap(name, value) if name in ("eta", "beta") else positive(name, value)


def not_negative(name: str, value: ArrayLike) -> Array:
    """Return numbers of zero or more."""
    array = numbers(name, value)
    _refuse(name, array, array < 0, "0 or more")
    return array


def between(name: str, value: ArrayLike, low: float, high: float) -> Array:
    """Return angles in radians between the bounds, exclusive."""
    array = numbers(name, value)
    top = np.degrees(high)
    hint = f"an angle in radians between {low:g} and {high:.6g} ({top:g} deg), exclusive"
    first = np.max(np.abs(array), initial=0.0)
    if first >= high:
        hint += f"; for degrees write np.radians({first:g})"
    _refuse(name, array, (array <= low) | (array >= high), hint)
    return array


def together(columns: dict[str, Array]) -> tuple[Array, ...]:
    """Return the columns broadcast against each other."""
    try:
        return np.broadcast_arrays(*columns.values())
    except ValueError:
        shapes = ", ".join(f"{name} {v.shape}" for name, v in columns.items())
        fail(f"shapes do not fit each other: {shapes}; give shapes that broadcast")


def designs(**columns: ArrayLike) -> tuple[list[Array], tuple[int, ...]]:
    """Check the columns of many designs; return them flat, of one length, and their broadcast shape."""
    given = []
    for name, value in columns.items():
        if name in ("alpha", "theta0"):
            given.append(between(name, value, 0.0, np.pi / 2))
        elif name in ("mu", "stiffness_ratio"):
            given.append(not_negative(name, value))
        else:
            given.append(ratio(name, value))
    cols = together(dict(zip(columns, given, strict=True)))
    return [np.ascontiguousarray(c, float).ravel() for c in cols], cols[0].shape


def one_of(name: str, value: str, allowed: Sequence[str]) -> str:
    """Return the value if it is one of the allowed words."""
    if value not in allowed:
        fail(f"{name} = {value!r}: must be {' or '.join(repr(a) for a in allowed)}".replace("'", '"'))
    return value


def law(value: str) -> str:
    """Return the name of a force law."""
    return one_of("law", value, tuple(LAWS))


def joint(value: str) -> str:
    """Return the name of a kind of joint."""
    return one_of("joint", value, ("hinge", "compliant"))


def sense(value: str) -> int:
    """Return +1 for "+", -1 for "-"."""
    return 1 if one_of("sense", value, ("+", "-")) == "+" else -1


def whole(name: str, value: Any, low: float, high: float) -> int:
    """Return one whole number with low <= value <= high."""
    allowed = f"a whole number from {low:g} to {high:g}"
    number = scalar(name, value, low, high + 1, allowed)
    if number != int(number):
        fail(f"{name} = {number:.6g}: must be {allowed}{_remedy(name)}")
    return int(number)


def scalar(name: str, value: Any, low: float, high: float, allowed: str) -> float:
    """Return one number with low <= value < high (low exclusive if it is 0)."""
    array = numbers(name, value)
    if array.ndim:
        fail(f"{name}: must be one number, not an array of shape {array.shape}")
    _refuse(name, array, (array < low) | (array >= high), allowed)
    return float(array)

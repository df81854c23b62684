"""One root between two bounds: on plain floats, and the same compiled."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

STILL, NEARLY = 1e-13, 1e-9
"""Relative steps of an interpolation after which no further one is made: in any case, and where the line through the
last two places leads to the same zero: then its own error is far smaller than the step."""
CLOSE = 1e-5
"""Relative length of the step before, at most: no longer than that the values follow a straight line."""


def bracketed(f: Callable[[float], float], a: float, b: float) -> float:
    """Solve f(x) = 0 for one x between a and b, where f changes sign, to the last bits.

    Here because the import of SciPy's takes longer than the rest of a command.
    """
    fa, fb = f(a), f(b)
    if fa * fb > 0:
        message = f"no change of sign between {a!r} and {b!r}"
        raise ValueError(message)
    return zero(f, a, fa, b, fb, a, fa, False)


def zero(
    f: Callable[..., float], a: float, fa: float, b: float, fb: float, c: float, fc: float, simple: bool, *args: Any
) -> float:
    """Solve f(x, *args) = 0 for one x between a and b (Chandrupatla, Adv. Eng. Software 28 (1997) 145).

    Parameters
    ----------
    a, fa, b, fb
        Two places and the values there, of different signs; what is no number counts as below zero.
    c, fc
        A third place beyond a, or a itself.
    simple
        Whether f crosses zero steeply and smoothly: the place that interpolation hardly moves any more is the last.
    """
    if fa == 0 or fb == 0:
        return a if fa == 0 else b
    fb = fb if fb == fb else -1.0  # noqa: PLR0124
    t, best = place(a, fa, b, fb, c, fc), a
    for _ in range(1100):
        x = a + t * (b - a)
        value = f(x, *args)
        fx = value if value == value else -1.0  # noqa: PLR0124
        before, value_before = a, fa
        if (fx > 0) == (fa > 0):
            c, fc = a, fa
        else:
            c, fc, b, fb = b, fb, a, fa
        a, fa = x, fx
        t = place(a, fa, b, fb, c, fc)
        if simple and t >= 0 and reached(t * (b - a), a, fa, before, value_before):
            return a + t * (b - a)
        best = a if abs(fa) < abs(fb) else b
        bound = (4.5e-16 * abs(best) + 1e-300) / abs(b - a) if a != b else 1.0
        if fa == 0 or bound >= 0.5:
            break
        t = min(max(t, bound), 1 - bound)
    return best


def place(a: float, fa: float, b: float, fb: float, c: float, fc: float) -> float:
    """Return where inverse quadratic interpolation puts the zero on the way from a to b, or half way where it may err.

    a lies between b and c.
    """
    xi, bend = (a - b) / (c - b), (fa - fb) / (fc - fb)
    if bend * bend < xi and (1 - bend) * (1 - bend) < 1 - xi:
        return fa / (fb - fa) * fc / (fb - fc) + (c - a) / (b - a) * fa / (fc - fa) * fb / (fc - fb)
    return 0.5


def reached(step: float, x: float, f: float, before: float, value_before: float) -> bool:
    """Whether a step from x, with the value f, ends at the zero to all digits; x is one step from ``before``."""
    moved, size = x - before, abs(x)
    straight = abs(f * moved + step * (f - value_before)) <= 1e-3 * abs(f * moved)
    short = abs(step) <= STILL * size or (abs(step) <= NEARLY * size and straight)
    return short and abs(f) <= 1e-4 * abs(value_before) and abs(moved) <= CLOSE * size

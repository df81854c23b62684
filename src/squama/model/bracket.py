"""Solution of f(x) = 0 between two bounds, for plain floats; also compiled."""

from __future__ import annotations

from collections.abc import Callable

STILL, NEARLY = 1e-13, 1e-9
"""Relative steps after which interpolation stops: always, and if the secant of the last two places agrees; the error is
then far smaller than the step.
"""
CLOSE = 1e-5
"""Largest relative length of the previous step for which the values count as a straight line."""


def bracketed(f: Callable[[float], float], a: float, b: float) -> float:
    """Solve f(x) = 0 between a and b, where f changes sign, to the last bits.

    An own function, because importing SciPy's takes longer than the rest of a command.
    """
    fa, fb = f(a), f(b)
    if fa * fb > 0:
        message = f"no change of sign between {a!r} and {b!r}"
        raise ValueError(message)
    return zero(f, a, fa, b, fb, a, fa, False)


def zero(
    f: Callable[..., float], a: float, fa: float, b: float, fb: float, c: float, fc: float, simple: bool, *args: object
) -> float:
    """Solve f(x, *args) = 0 between a and b (Chandrupatla, Adv. Eng. Software 28 (1997) 145).

    The values fa and fb have different signs, NaN counts as negative; c is a third place beyond a, or a itself;
    ``simple``: f crosses zero steeply and smoothly, so that a small interpolation step may end the search.
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
    """Return the zero by inverse quadratic interpolation, as a share of the way from a to b, 0.5 where it may fail."""
    xi, bend = (a - b) / (c - b), (fa - fb) / (fc - fb)
    if bend * bend < xi and (1 - bend) * (1 - bend) < 1 - xi:
        return fa / (fb - fa) * fc / (fb - fc) + (c - a) / (b - a) * fa / (fc - fa) * fb / (fc - fb)
    return 0.5


def reached(step: float, x: float, f: float, before: float, value_before: float) -> bool:
    """Return whether a step from x, with the value f, ends at the zero to all digits; ``before`` is the last place."""
    moved, size = x - before, abs(x)
    straight = abs(f * moved + step * (f - value_before)) <= 1e-3 * abs(f * moved)
    short = abs(step) <= STILL * size or (abs(step) <= NEARLY * size and straight)
    return short and abs(f) <= 1e-4 * abs(value_before) and abs(moved) <= CLOSE * size

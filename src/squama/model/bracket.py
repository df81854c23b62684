"""One root between two bounds, on plain floats."""

from __future__ import annotations

from collections.abc import Callable


def bracketed(f: Callable[[float], float], a: float, b: float) -> float:
    """Solve f(x) = 0 for one x between a and b, where f changes sign, to the last bits.

    Chandrupatla, Adv. Eng. Software 28 (1997) 145; here because the import of SciPy's takes longer than the rest of a
    command.
    """
    fa, fb = f(a), f(b)
    if fa * fb > 0:
        message = f"no change of sign between {a!r} and {b!r}"
        raise ValueError(message)
    c, fc, t, best = a, fa, 0.5, a
    for _ in range(1100):
        best, least = (a, fa) if abs(fa) < abs(fb) else (b, fb)
        bound = 4.5e-16 * abs(best) / abs(b - a) if a != b else 1.0
        if least == 0 or bound >= 0.5:
            break
        x = a + min(max(t, bound), 1 - bound) * (b - a)
        fx = f(x)
        if (fx > 0) == (fa > 0):
            c, fc = a, fa
        else:
            c, fc, b, fb = b, fb, a, fa
        a, fa = x, fx
        xi, bend = (a - b) / (c - b), (fa - fb) / (fc - fb)
        t = 0.5
        if bend**2 < xi and (1 - bend) ** 2 < 1 - xi:
            # inverse quadratic interpolation is safe here
            t = fa / (fb - fa) * fc / (fb - fc) + (c - a) / (b - a) * fa / (fc - fa) * fb / (fc - fb)
    return best

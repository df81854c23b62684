r"""Frictional work along a path, with the pole of the friction force built in (paper Eqs. 13, 15 and 16).

Near a frictional lock f grows like 1/(x_p - x). With y = -ln(1 - (x - x0)/(x_p - x0)) the integrand f dr/dy is smooth.
Its Chebyshev series in y is integrated term by term; the number of terms doubles until the series has converged. For
many paths only the integral up to the cut-off is computed (:mod:`squama.model.figures`). Units: W_fr d / K_theta.
"""

from __future__ import annotations

import functools
import warnings
from typing import Any, NamedTuple

import numpy as np

from squama.errors import ValidityWarning
from squama.model.mechanics import Followed, forces
from squama.model.paths import ARRAY, FoldedTwist, Ops
from squama.types import Array

TOLERANCE = 1e-11
"""Size of the last terms of the series, relative to the work, at which it counts as converged."""
NODES = 64
FEW_NODES = 24
MOST_NODES = 2048


class Series(NamedTuple):
    """Frictional work of one path as a Chebyshev series in y, from ``x0`` on; ``pole`` is x_p."""

    coefficients: Array
    x0: float
    pole: float
    y_end: float

    def __call__(self, x: Array | float) -> Array:
        """Return the frictional work W_fr d / K_theta from engagement to the path parameter ``x``."""
        if not self.coefficients.any():
            return np.zeros_like(np.asarray(x, float))
        y = -np.log1p(-(np.asarray(x, float) - self.x0) / (self.pole - self.x0))
        z = 2 * y / self.y_end - 1
        return np.asarray(np.polynomial.chebyshev.chebval(z, self.coefficients))


@functools.cache
def _rule(n: int) -> tuple[Array, Array]:
    """Return Chebyshev nodes on [0, 1] and the matrix from values there to coefficients of the integral from 0."""
    j = np.arange(n)
    angle = np.pi * (j + 0.5) / n
    values_to_coefficients = 2 / n * np.cos(j[:, None] * angle)
    values_to_coefficients[0] /= 2
    integral = np.polynomial.chebyshev.chebint(values_to_coefficients, lbnd=-1, axis=0)
    return (1 + np.cos(angle)) / 2, integral / 2


def pole(row: Followed, x_end: Array, mu: Array, law: str, x0: Array) -> Array:
    """Return the path parameter at which the friction force has its pole: the end, or beyond it by the slope of D."""
    h = 1e-4 * (x_end - x0)
    with np.errstate(all="ignore"):
        D1 = forces(row.point(x_end, law, ARRAY), row.theta0, mu).D
        D0 = forces(row.point(x_end - h, law, ARRAY), row.theta0, mu).D
        return np.asarray(x_end + beyond(D1, D0, h, ARRAY))


def beyond(D1: float | Array, D0: float | Array, h: float | Array, ops: Ops) -> Any:
    """Return the distance from a path's end to the pole, by D1 = D there and D0 = D at ``h`` (length / 1e4) before it.

    Without a pole ahead it is so large that y is proportional to x.
    """
    D1 = ops.larger(D1, 0.0)
    return h * D1 / ops.larger(D0 - D1, 1e-7 * D1 + 1e-300)


def cutoff(row: Followed, x0: Array, x_end: Array, locks: Array, margin: complex) -> Array:
    """Return the path parameters at which the work up to a lock is cut off; the end itself where ``locks`` is false.

    A fraction ``margin`` is left of the inclination, or of the path parameter if the path has passed a fold; ``row`` is
    one of arrays.
    """
    x_c = x0 + (1 - margin) * (x_end - x0)
    if isinstance(row, FoldedTwist):
        theta_c = row.theta0 + (1 - margin) * (row.theta(x_end) - row.theta0)
        x_c = np.where(x_end <= 0, row.parameter(theta_c, ARRAY), x_c)
    return np.asarray(np.where(locks, x_c, x_end))


def work(row: Followed, x0: float, x_stop: float, x_pole: float, mu: float, law: str) -> Series:
    """Return the frictional work of one path up to ``x_stop`` before its pole, to 1e-9 or better, or with a warning."""
    if mu == 0 or x_stop <= x0:
        return Series(np.zeros(1), x0, x0 + 1.0, 1.0)
    y_end = -float(np.log1p(-(x_stop - x0) / (x_pole - x0)))
    n = NODES
    while True:
        unit, integral = _rule(n)
        y = y_end * unit
        x = x0 - (x_pole - x0) * np.expm1(-y)
        pt = row.point(x, law, ARRAY)
        density = forces(pt, row.theta0, mu).f * pt.slip_rate * (x_pole - x)
        c = y_end * (integral @ density)
        total = abs(float(c.sum()))
        if float(np.abs(c[-4:]).max()) <= TOLERANCE * total:
            break
        if n >= MOST_NODES:
            warnings.warn(
                f"frictional work converged to {np.abs(c[-4:]).max() / total:.1e} only", ValidityWarning, stacklevel=2
            )
            break
        n *= 2
    return Series(c, x0, x_pole, y_end)

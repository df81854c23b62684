r"""Frictional work along a path, with the pole of the friction force built in (paper Eqs. 13, 15 and 16).

Near a frictional lock f grows like 1/(x_p - x). With y = -ln(1 - (x - x0)/(x_p - x0)) the integrand
f dr/dy is smooth. Of one path its Chebyshev series in y is integrated term by term; the number of terms doubles until
the series has converged. Many paths are integrated by Gauss rules (:mod:`squama.model.rules`), and in parts where none
serves. Units: W_fr d / K_theta.
"""

from __future__ import annotations

import functools
import warnings
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from squama.errors import ValidityWarning
from squama.model import formulas
from squama.model.mechanics import Row, forces
from squama.model.paths import ARRAY, FoldedTwist, Ops, as_next
from squama.model.rules import Rules, legendre_rules, pole_rules
from squama.model.solve import Array, blocks, point, take

TOLERANCE = 1e-11
"""Size of the last terms of the series, relative to the work, at which it counts as converged."""
NODES = 64
FEW_NODES = 24
ENTRIES = 49_152
"""Places taken at a time: of more the product with the weights is given to threads that wait for each other."""
MOST_NODES = 2048
PARTS, DEPTH, MOST_PARTS = 16, 6, 64
"""Parts into which y is cut where the integrand is too sharp for one rule, how often, and how many of one path are cut
again: more are no corner but rounding."""


class Series(NamedTuple):
    """Frictional work of one path as a Chebyshev series in y, from ``x0`` on; ``pole`` is x_p."""

    coefficients: Array
    x0: float
    pole: float
    y_end: float

    def __call__(self, x: Array | float) -> Array:
        """Frictional work W_fr d / K_theta from engagement to the path parameter ``x``."""
        if not self.coefficients.any():
            return np.zeros_like(np.asarray(x, float))
        y = -np.log1p(-(np.asarray(x, float) - self.x0) / (self.pole - self.x0))
        z = 2 * y / self.y_end - 1
        return np.asarray(np.polynomial.chebyshev.chebval(z, self.coefficients))


@functools.cache
def _rule(n: int) -> tuple[Array, Array]:
    """Chebyshev nodes on [0, 1] and the matrix from values there to coefficients of the integral from 0."""
    j = np.arange(n)
    angle = np.pi * (j + 0.5) / n
    values_to_coefficients = 2 / n * np.cos(j[:, None] * angle)
    values_to_coefficients[0] /= 2
    integral = np.polynomial.chebyshev.chebint(values_to_coefficients, lbnd=-1, axis=0)
    return (1 + np.cos(angle)) / 2, integral / 2


def pole(row: Row, x_end: Array, mu: Array, law: str, x0: Array) -> Array:
    """Where the friction force has its pole, at or (estimated by the slope of D) beyond the end of the path."""
    h = 1e-4 * (x_end - x0)
    with np.errstate(all="ignore"):
        D1 = forces(point(row, x_end, law), row.theta0, mu).D
        D0 = forces(point(row, x_end - h, law), row.theta0, mu).D
        return np.asarray(x_end + beyond(D1, D0, h, ARRAY))


def beyond(D1: Any, D0: Any, h: Any, ops: Ops) -> Any:
    """Distance from the end of a path to the pole, with D1 = D there and D0 = D at ``h`` (path length / 1e4) before it.

    Where no pole is ahead: one far enough that y is x in other units.
    """
    D1 = ops.larger(D1, 0.0)
    return h / ops.larger((D0 - D1) / D1, 1e-7)


def ends_at_pole(row: Any, x_end: Array, friction: Array) -> Array:
    """Whether the friction force has its pole at the end of each path, whose cut-off is a fraction of x before it.

    On a folded path whose frictional lock comes before the fold the cut-off is a fraction of the inclination instead.
    """
    return np.asarray(friction & ((x_end > 0) | (not isinstance(row, FoldedTwist))))


def cutoff(row: Any, x0: Array, x_end: Array, locks: Array, margin: float) -> Array:
    """Path parameters at which the work up to a lock is cut off; the end itself where the path does not lock.

    A fraction ``margin`` is left of the inclination, or of the path parameter where the path has passed a fold.

    Parameters
    ----------
    row, x0, x_end
        A row of arrays, its path parameters of engagement and end.
    locks
        Whether the end is a frictional or a kinematic lock.
    """
    x_c = x0 + (1 - margin) * (x_end - x0)
    if isinstance(row, FoldedTwist):
        theta_c = row.theta0 + (1 - margin) * (row.theta(x_end) - row.theta0)
        x_c = np.where(x_end <= 0, row.parameter(theta_c, ARRAY), x_c)
    return np.asarray(np.where(locks, x_c, x_end))


def works(row: Any, x0: Array, x_stop: Array, x_pole: Array, mu: Array, law: str, margin: float | None = None) -> Array:
    """Frictional work W_fr d / K_theta of many paths; as :func:`work`, each path with as many nodes as it needs.

    ``margin`` is the fraction before their poles at which most paths stop, if it is known: a rule of its own serves
    those with fewer nodes.
    """
    out = np.zeros(x0.size)
    left = (mu > 0) & (x_stop > x0)
    row, reach = as_next(row), x_pole - x0
    if margin is not None:
        cut = left & (abs((x_stop - x0) - (1 - margin) * reach) < 1e-9 * margin * reach)

        def straight(lanes: Array, unit: Array) -> Any:
            r = reach[lanes]
            return formulas.power(take(row, lanes), x0[lanes] + r * unit, mu[lanes], law) * r

        rough = _by_rules(pole_rules(margin), np.flatnonzero(cut), straight, out)
        left &= ~cut
        left[rough] = True
    index = np.flatnonzero(left)
    y_end = np.zeros(x0.size)
    y_end[index] = -np.log1p(-(x_stop - x0)[index] / reach[index])

    def along_y(lanes: Array, unit: Array) -> Any:
        y = y_end[lanes]
        return y * _density(row, lanes, x0[lanes], reach[lanes], y * unit, mu, law)

    rough = _by_rules(legendre_rules(), index, along_y, out)
    if rough.size:
        out[rough] = in_parts(take(row, rough), x0[rough], x_stop[rough], x_pole[rough], mu[rough], law)
    return out


def _density(row: Any, lanes: Array, start: Array, reach: Array, y: Array, mu: Array, law: str) -> Any:
    """Frictional work per unit of y, which counts from ``start``, ``reach`` before the pole."""
    short = -np.expm1(-y)
    return formulas.power(take(row, lanes), start + reach * short, mu[lanes], law) * (reach * (1 - short))


def _by_rules(rules: Rules, lanes: Array, f: Callable[[Array, Array], Any], out: Array) -> Array:
    """Integrate ``f(lanes, nodes)`` over [0, 1] into ``out``; return the lanes that want more nodes than there are."""
    first = 0
    for size in rules.sizes:
        unit, *weights = rules.nodes[:, first : first + size]
        rule, first = np.stack(weights), first + size
        again = [lanes[:0]]
        for part in blocks(lanes.size, max(1, ENTRIES // size)):
            some = lanes[part]
            with np.errstate(all="ignore"):
                total, last, last_but_one = rule @ f(some, unit[:, None])
            out[some] = total
            good = np.maximum(abs(last), abs(last_but_one)) <= rules.rough * abs(total)
            again.append(some[~good])
        lanes = np.concatenate(again)
        if lanes.size == 0:
            break
    return lanes


def in_parts(row: Any, x0: Array, x_stop: Array, x_pole: Array, mu: Array, law: str) -> Array:
    """Frictional work of paths that no one rule serves: y is cut where the integrand is sharp, and there again."""
    rules = legendre_rules()
    unit, *weights = rules.nodes[:, : rules.sizes[0]]
    rule, reach, row = np.stack(weights), x_pole - x0, as_next(row)
    with np.errstate(all="ignore"):
        y_end = np.where((mu > 0) & (x_stop > x0), -np.log1p(-(x_stop - x0) / reach), 0.0)
    out: Array = np.zeros(x0.size)
    size: Array = np.zeros(x0.size)
    lanes, low, width = np.arange(x0.size), np.zeros(x0.size), y_end
    for depth in range(DEPTH):
        lanes, width = np.repeat(lanes, PARTS), np.repeat(width / PARTS, PARTS)
        low = np.repeat(low, PARTS) + width * np.tile(np.arange(PARTS), lanes.size // PARTS)
        terms = np.zeros((3, lanes.size))
        for part in blocks(lanes.size):
            some, r = lanes[part], reach[lanes[part]]
            start, ahead = x0[some] - r * np.expm1(-low[part]), r * np.exp(-low[part])
            with np.errstate(all="ignore"):
                terms[:, part] = rule @ _density(row, some, start, ahead, width[part] * unit[:, None], mu, law)
        total, last, last_but_one = terms * width
        if depth == 0:
            size = np.bincount(lanes, abs(total), x0.size)
        rough = np.maximum(abs(last), abs(last_but_one)) > TOLERANCE * size[lanes]
        rough &= (depth < DEPTH - 1) & (np.bincount(lanes, rough, x0.size) <= MOST_PARTS)[lanes]
        out += np.bincount(lanes[~rough], total[~rough], x0.size)
        lanes, low, width = lanes[rough], low[rough], width[rough]
        if lanes.size == 0:
            break
    return out


def work(row: Any, x0: float, x_stop: float, x_pole: float, mu: float, law: str) -> Series:
    """Frictional work of one path from engagement to ``x_stop`` < ``x_pole``.

    Parameters
    ----------
    row
        A row of floats.
    x0, x_stop, x_pole
        Path parameters of engagement, of the cut-off and of the pole.

    Returns
    -------
    Series
        Relative accuracy 1e-9 or better; a warning tells where it was not reached.
    """
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
                f"frictional work converged to {np.abs(c[-4:]).max() / total:.1e} only",
                ValidityWarning,
                stacklevel=2,
            )
            break
        n *= 2
    return Series(c, x0, x_pole, y_end)

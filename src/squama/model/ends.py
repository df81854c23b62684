"""Where the path of a contact ends: the first margin to vanish, for many designs at once.

Samples of the paths bracket the ends (:mod:`squama.model.scan`). Each end is then solved in its interval by a
bracketing method to full precision, and another neighbour that comes in before it cuts the path.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from squama.model import formulas
from squama.model.mechanics import Row, named_margins
from squama.model.neighbours import first_crossing
from squama.model.outcome import CODES, End
from squama.model.paths import FLOAT, FoldedTwist, Point, Twist, as_next
from squama.model.scan import Scan, event, scan
from squama.model.solve import Array, first_zero, point, take
from squama.model.twisting import Number

COINCIDE = 1e-11
"""Margins below this have vanished."""


class Track(NamedTuple):
    """Paths of n designs: ``row`` holds their ratios, from ``x0`` to ``x_end`` where ``code`` names the end.

    ``load_end`` is the load angle there. ``crossing`` tells, for an end by another neighbour's tip-side contact, which
    neighbour came in (else 0).
    """

    row: Row
    x0: Array
    x_end: Array
    load_end: Array
    code: Array
    crossing: Array


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
    found = scan(as_next(row), x0, x1, mu, law)
    folded = ~np.isnan(found.fold_a)
    groups = []
    index = np.flatnonzero(~folded)
    if index.size:
        sub: Any = row if index.size == x0.size else take(row, index)
        groups.append((index, _solve(sub, x0[index], x1[index], take(found, index), mu[index], law)))
    index = np.flatnonzero(folded)
    if index.size:
        sub = take(row, index)
        theta_f = _fold(sub, found.fold_a[index], found.fold_b[index])
        bent = FoldedTwist(sub.eta, sub.beta, sub.lam, sub.sa, sub.ca, sub.theta0, theta_f, sub.k)
        tau = np.sqrt(bent.theta_f - x0[index])
        groups.append((index, _solve(bent, -tau, tau, scan(as_next(bent), -tau, tau, mu[index], law), mu[index], law)))
    return groups


def _fold(row: Twist, low: Array, high: Array) -> Array:
    """Inclination of the fold, where the two roots of the contact condition meet."""

    def square(theta: Number, *cols: Number) -> Number:
        row = Twist(*cols)
        return row.root(theta, FLOAT).q2 if isinstance(theta, float) else formulas.square(row, theta)

    return first_zero(square, low, high, tuple(as_next(row)))


def _solve(row: Any, x0: Array, x1: Array, found: Scan, mu: Array, law: str) -> Track:
    """Solve every end in its interval and name it."""
    n, (a, b) = x0.size, found[:2]
    x_end = x1.copy()
    # a folded path that reaches its far end has come back to theta0, where the spring is at rest
    unended = End.RELEASED if isinstance(row, FoldedTwist) else End.RANGE
    code = np.full(n, CODES.index(unended), np.int8)
    inside, start = np.flatnonzero(b > a), np.flatnonzero(b == a)
    x_end[start] = x0[start]
    if inside.size:
        cols = (*as_next(take(row, inside)), mu[inside])
        with np.errstate(all="ignore"):
            known = take(found, inside)[2:6]
            x_end[inside] = first_zero(event(type(row), law), a[inside], b[inside], cols, known)
    pt = point(row, x_end, law)
    met = b >= a
    code[met] = _names(row, pt, mu)[met]
    code[start[code[start] == CODES.index(End.FRICTIONAL)]] = CODES.index(End.STATIC)
    if not isinstance(row, Twist | FoldedTwist):
        return Track(row, x0, x_end, pt.load, code, np.zeros(n, np.int64))
    crossing = first_crossing(row, x0, x_end)
    other = np.flatnonzero(crossing.x < x_end)
    if other.size:
        x_end[other] = crossing.x[other]
        pt.load[other] = point(take(row, other), x_end[other], law).load
        code[other] = CODES.index(End.OTHER)
    k = np.zeros(n, np.int64)
    k[other] = crossing.k[other]
    return Track(row, x0, x_end, pt.load, code, k)


def _names(row: Any, pt: Point, mu: Array) -> Array:
    """Codes of the margins that vanish at the ends; where two coincide, of the first in ``row.ENDS``."""
    values = np.stack(np.broadcast_arrays(*named_margins(row, pt, mu)))
    zero = ~(values > COINCIDE)
    which = zero.argmax(axis=0)
    none = ~zero.any(axis=0)
    if none.any():
        which[none] = np.nan_to_num(values[:, none], nan=-1.0).argmin(axis=0)
    return np.asarray(np.array([CODES.index(e) for e in row.ENDS], np.int8)[which])

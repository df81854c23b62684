"""What of a contact is evaluated at very many places, each as a program of its own (:mod:`squama.model.tape`).

Rows are in units of k pitches (``paths.as_next``). Rows that look at values while they are evaluated (bending) are
evaluated as they are.
"""

from __future__ import annotations

import functools
from typing import Any

import numpy as np

from squama.model.mechanics import named_margins, pressed
from squama.model.paths import ARRAY, FoldedTwist, Point, Twist
from squama.model.tape import Array, Tape, kept


def margins(row: Any, x: Array, mu: Array, law: str, out: Array | None = None) -> Array:
    """Return the smallest margin, the squared root (below zero beyond a fold), and the margins one by one."""
    if isinstance(row, Twist | FoldedTwist):
        return _margins(type(row), law)(x, *row[:-1], mu, out=out)
    pt = row.point(x, law, ARRAY)
    each = named_margins(row, pt, mu)
    every = np.stack(np.broadcast_arrays(_smallest(*each), pt.q * pt.q, *each))
    if out is not None:
        out[...] = every
    return every


def least(row: Any, x: Array, mu: Array, law: str) -> Array:
    """Return the smallest margin."""
    if isinstance(row, Twist | FoldedTwist):
        return np.asarray(_least(type(row), law)(x, *row[:-1], mu)[0])
    return np.asarray(_smallest(*named_margins(row, row.point(x, law, ARRAY), mu)))


def power(row: Any, x: Array, mu: Array, law: str) -> Array:
    """Return the frictional work per unit of the path parameter."""
    if isinstance(row, Twist | FoldedTwist):
        return np.asarray(_power(type(row), law)(x, *row[:-1], mu)[0])
    return np.asarray(_worked(row.point(x, law, ARRAY), row, mu))


def point(row: Any, x: Array, law: str) -> Point:
    """Return the contacts; here a row may be in units of pitches."""
    if isinstance(row, Twist | FoldedTwist):
        return Point(*_point(type(row), law)(x, *row))
    pt: Point = row.point(x, law, ARRAY)
    return pt


def square(row: Twist, theta: Array) -> Array:
    """Return the squared root of the contact condition."""
    return np.asarray(_square()(theta, *row[:-1])[0])


def _smallest(*values: Any) -> Any:
    """Smallest of several arrays, entry by entry; not a number where one is none."""
    return functools.reduce(np.minimum, values)


def _worked(pt: Point, row: Any, mu: Any) -> Any:
    return pressed(pt, row.theta0, mu)[2] * pt.slip_rate


@kept
def _margins(kind: type[Any], law: str) -> Tape:
    def margins(x: Any, *columns: Any) -> tuple[Any, ...]:
        row = kind(*columns[:-1])
        theta, r, q, per_x = row.solve(x, ARRAY)
        pair = row.open if kind is FoldedTwist else row
        each = named_margins(pair, pair.at_root(theta, r, q, per_x, law, ARRAY), columns[-1])
        return _smallest(*each), r.q2, *each

    return Tape(margins, len(kind._fields))


@kept
def _least(kind: type[Any], law: str) -> Tape:
    def least(x: Any, *columns: Any) -> tuple[Any]:
        row = kind(*columns[:-1])
        return (_smallest(*named_margins(row, row.point(x, law, ARRAY), columns[-1])),)

    return Tape(least, len(kind._fields))


@kept
def _power(kind: type[Any], law: str) -> Tape:
    def power(x: Any, *columns: Any) -> tuple[Any]:
        row = kind(*columns[:-1])
        return (_worked(row.point(x, law, ARRAY), row, columns[-1]),)

    return Tape(power, len(kind._fields))


@kept
def _point(kind: type[Any], law: str) -> Tape:
    return Tape(lambda x, *columns: kind(*columns).point(x, law, ARRAY), len(kind._fields))


@kept
def _square() -> Tape:
    return Tape(lambda theta, *columns: (Twist(*columns).root(theta, ARRAY).q2,), len(Twist._fields) - 1)

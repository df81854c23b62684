"""Paths of many designs: rows of arrays, with beginning and end of each path."""

from __future__ import annotations

from typing import NamedTuple, TypeVar

import numpy as np

from squama.model.bending import Bend
from squama.model.mechanics import Row
from squama.model.paths import ARRAY, FoldedTwist, Twist
from squama.types import Array

OneRow = Twist | FoldedTwist | Bend
"""Row of one kind of contact."""
_Row = TypeVar("_Row", bound=OneRow)


def take(row: _Row, index: Array | int) -> _Row:
    """Return the designs ``index`` of a row of arrays; single numbers, common to all designs, are kept."""
    return type(row)(*(col if np.ndim(col) == 0 else np.asarray(col)[index] for col in row))


def scalar(row: _Row, i: int = 0) -> _Row:
    """Return design ``i`` of a row as plain floats."""
    return type(row)(*(float(np.asarray(col)[i]) for col in row))


class Track(NamedTuple):
    """Paths of n designs: ``row`` has their ratios; each path goes from ``x0`` to ``x_end``, the end is ``code``.

    ``load_end`` is the load angle there (rad per pitch). ``crossing`` is the neighbour whose tip-side contact ends the
    path (0 for none).
    """

    row: OneRow
    x0: Array
    x_end: Array
    load_end: Array
    code: Array
    crossing: Array


def at_loads(row: Row, load: Array, bounds: tuple[Array, Array], seen: tuple[Array, Array]) -> Array:
    """Return the path parameters (n,) at which paths reach load angles (n,), by Newton's method within bounds.

    ``bounds`` are path parameters before and behind each load angle (rad per pitch), ``seen`` the load angles there.
    """
    (a, b), (fa, fb) = bounds, seen
    # a load just beyond the ends of a path belongs to its ends
    x = np.clip(a + (load - fa) / np.where(fb > fa, fb - fa, 1.0) * (b - a), a, b)
    last = False
    for _ in range(60):
        with np.errstate(all="ignore"):
            if hasattr(row, "off"):
                off, slope = row.off(load, x, ARRAY)
            else:
                pt = row.point(x, "edge", ARRAY)
                off, slope = pt.load - load, pt.load_rate
            a, b = np.where(off <= 0, x, a), np.where(off > 0, x, b)
            new = x - off / slope
        new = np.where((new >= a) & (new <= b), new, (a + b) / 2)
        # digits double: after so small a step one more gives them all
        small, x = not np.any(np.abs(new - x) > 1e-8 * np.abs(x)), new
        if last:
            break
        last = small
    return np.asarray(x)

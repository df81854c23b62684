"""Row of integers that describes a contact: its columns, and the codes of its kind and state."""

from __future__ import annotations

from squama.batch.keeping import inlined as _in

FIRST, APART, KIND, ONE, OTHER, STUCK, ENDED = range(7)
"""Columns of a contact: scale, number of cells to the other scale, kind, features of both, whether it sticks (1;
slides: 0; is taken as smooth: SMOOTH; is let go of, with its force fixed: LET_GO), and whether it replaces an edge that
is tangent to the face nowhere: for this increment, or while it lies flush.
"""
FLUSH, SMOOTH, LET_GO = 2, -1, -2
EE, VF, FV, EF, FE, LIES = range(6)
"""Kinds of contact; LIES is a scale that lies on the substrate: a moment that lifts it, without places."""
GAP, AT, VERTEX = 5, 6, 9
"""Columns of a vertex after the first five of a contact: its gap, and its places (3); number of columns."""


@_in
def places_of(kind: int) -> int:
    """Return the number of unknown places of a kind of contact."""
    return 3 if kind >= EF else 2


@_in
def lengthwise(edge: int) -> bool:
    """Return whether an edge runs along the length."""
    return edge in (1, 2)


@_in
def corner_at(edge: int, high_end: bool) -> int:
    """Return the corner at the low or high end of an edge."""
    if edge == 0:
        return 1 if high_end else 0
    if edge == 1:
        return 0 if high_end else 2
    if edge == 2:
        return 1 if high_end else 3
    return 3 if high_end else 2


@_in
def unknown(kind: int, one: int, other: int) -> tuple[int, int, int, int]:
    """Return the index of the unknown place for each of x1, y1, x2, y2 of a contact; -1 for constant coordinates."""
    if kind == EE:
        x1, y1 = (0, -1) if lengthwise(one) else (-1, 0)
        x2, y2 = (1, -1) if lengthwise(other) else (-1, 1)
        return x1, y1, x2, y2
    if kind == VF:
        return -1, -1, 0, 1
    if kind == FV:
        return 0, 1, -1, -1
    if kind == EF:
        x1, y1 = (2, -1) if lengthwise(one) else (-1, 2)
        return x1, y1, 0, 1
    x2, y2 = (2, -1) if lengthwise(other) else (-1, 2)
    return 0, 1, x2, y2

"""Where scales come to bear on each other behind a contact that ran off its edge; compiled.

A corner that slides off the edge of the next scale falls past it, until other edges through the same place lie across
each other: mostly the side edge that ends at the corner, far from it. So the force of the contact is taken away little
by little, and what comes to bear meanwhile takes its place. Where that path ends equilibria are looked for from places
along both of these edges.
"""

from __future__ import annotations

from squama.batch.keeping import part as _jit
from squama.contacts import tally, touch
from squama.contacts.changes import regroup
from squama.contacts.detection import bound
from squama.contacts.handover import add_contact, drop
from squama.contacts.increments import NO_EQUILIBRIUM, Walk, number
from squama.contacts.meeting import meet
from squama.contacts.system import MU, System, copied, copy, high, low, partner, spots
from squama.contacts.touch import lengthwise
from squama.contacts.vectors import dot
from squama.types import Array

_ALONG, _THROUGH = 5, 1e-6
"""Places along a pair of edges that are tried; distance, in pitches, within which an edge goes through a place."""
GUESSES = 4 * _ALONG
"""Guesses of which there are no more: a place is on two edges of a scale at most."""
_FIRST, _LEAST, _GROWTH, _SHRINK = 1 / 16, 1e-5, 2.0, 0.25
"""Share of the force that is taken away first, the least one at a time, and how it grows and shrinks."""
_RELAPSES = 2
"""How often a contact that is let go of may come in again and run off once more: its scale creeps, and the others are
held up one by one, where they all fall after a longer increment."""


@_jit
def released(w: Walk, h: float, c: int) -> int:
    """Look for an equilibrium after an increment, from its guess, as the force of a contact is taken away; 0 if found.

    Contacts that run off their edges meanwhile are let go of, too. Those that come in are smooth: what they slide along
    is not known. They stick where they then bear.
    In haste (:data:`squama.contacts.tally.HASTY`) a walk on which a scale creeps is given up.
    """
    w.con[c, touch.STUCK] = touch.LET_GO
    share, by, code = 1.0, _FIRST, 0
    laid_aside(w)
    while share > 0.0:
        less = max(0.0, share - by)
        for o in range(w.counts[0]):
            for a in range(3 if w.con[o, touch.STUCK] == touch.LET_GO else 0):
                w.new.F[o, a] *= less / share
        code = regroup(w, h, False)
        if code == 0:
            if w.tally[tally.HASTY] > 0.0 and relapses(w) > _RELAPSES:
                w.tally[tally.HASTY] = 2.0
                return NO_EQUILIBRIUM
            share, by = less, by * _GROWTH
            laid_aside(w)
            continue
        by *= _SHRINK
        if by < _LEAST:
            return code
        copied(w.aside, w.new)
        copy(w.stuck, w.con)
        w.counts[0], w.J.kept[0] = w.counts[2], 0
    for o in range(w.counts[0] - 1, -1, -1):
        if w.con[o, touch.STUCK] == touch.LET_GO:
            drop(w, w.new, o)
    code = regroup(w, h, False)
    rough(w)
    return code


@_jit
def relapses(w: Walk) -> int:
    """Return how often a contact that is let go of has come in again and run off once more, at most."""
    most = 0
    for a in range(w.counts[0]):
        times = -1
        for b in range(w.counts[0] if w.con[a, touch.STUCK] == touch.LET_GO else 0):
            same = w.con[b, touch.STUCK] == touch.LET_GO and number(w.con[a]) == number(w.con[b])
            times += 1 if same else 0
        most = max(most, times)
    return most


@_jit
def rough(w: Walk) -> None:
    """Let smooth contacts stick where they bear."""
    for o in range(w.counts[0]):
        if w.con[o, touch.STUCK] == touch.SMOOTH:
            w.con[o, touch.STUCK] = 1 if w.S.shapes[0, MU] > 0.0 else 0


@_jit
def laid_aside(w: Walk) -> None:
    """Keep a state on the way and its contacts."""
    copied(w.new, w.aside)
    copy(w.con, w.stuck)
    w.counts[2] = w.counts[0]


@_jit
def through(S: System, i: int, edge: int, x: float, y: float) -> tuple[bool, float, float]:
    """Say whether an edge goes through a place of a scale, where on the edge that is, and which way it goes on there.

    Up (1), down (-1) or both ways (0).
    """
    a, off = (x, y) if lengthwise(edge) else (y, x)
    way = 1.0 if a < low(S, i, edge) + _THROUGH else (-1.0 if a > high(S, i, edge) - _THROUGH else 0.0)
    return abs(off - bound(S, i, edge)) < _THROUGH, a, way


@_jit
def left(S: System, i: int, edge: int, a: float, way: float) -> float:
    """Return how long an edge is from a place on, one way."""
    return high(S, i, edge) - a if way > 0.0 else a - low(S, i, edge)


@_jit
def across(w: Walk, c: int, guess: int, v: Array) -> int:
    """Write two edges through the place of a contact as a vertex, and guess where they touch.

    Each pair of edges has several guesses, some way along both. Returned is 1; 0 where the edges go nowhere from the
    place, -1 where there are not so many guesses.
    """
    S, row, pair = w.S, w.con[c], guess // _ALONG
    i, j = row[touch.FIRST], partner(S, row)
    x1, y1, x2, y2 = spots(S, row, w.now.s[c])
    # only whether edges run alike is asked of it
    g = meet(S, w.now, row, w.now.s[c], w.W)
    for one in range(4):
        here, a, way1 = through(S, i, one, x1, y1)
        for other in range(4):
            there, b, way2 = through(S, j, other, x2, y2)
            own = row[touch.KIND] == touch.EE and row[touch.ONE] == one and row[touch.OTHER] == other
            if own or not (here and there):
                continue
            if pair > 0:
                pair -= 1
                continue
            alike = dot(g.tx1 if lengthwise(one) else g.ty1, g.tx2 if lengthwise(other) else g.ty2)
            sense = 1.0 if alike > 0.0 else -1.0
            way1, way2 = way1 if way1 != 0.0 else sense * way2, way2 if way2 != 0.0 else sense * way1
            if way1 == 0.0:
                return 0
            far = min(left(S, i, one, a, way1), left(S, j, other, b, way2)) * (guess % _ALONG) / _ALONG
            v[touch.FIRST], v[touch.APART] = i, row[touch.APART]
            v[touch.KIND], v[touch.ONE], v[touch.OTHER] = touch.EE, one, other
            v[touch.AT], v[touch.AT + 1], v[touch.AT + 2] = a + way1 * far, b + way2 * far, 0.0
            return 1
    return -1


@_jit
def slipped(w: Walk, h: float, c: int, guess: int) -> int:
    """Look for any equilibrium after an increment with two edges in the place of a contact that left its own one.

    They take the place of all contacts of that pair of scales. What they have slid along is not known: they stick where
    they would bear without friction. 0 if an equilibrium is found, -1 where there are not so many guesses.
    """
    found = across(w, c, guess, w.best)
    if found < 1:
        return found if found < 0 else NO_EQUILIBRIUM
    for o in range(w.counts[0] - 1, -1, -1):
        if w.con[o, touch.FIRST] == w.best[touch.FIRST] and w.con[o, touch.APART] == w.best[touch.APART]:
            drop(w, w.new, o)
    add_contact(w, w.new, w.best)
    w.con[w.counts[0] - 1, touch.STUCK] = touch.SMOOTH
    code = regroup(w, h, True)
    rough(w)
    return code

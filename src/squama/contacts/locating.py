"""Location of the first violated condition within an increment; compiled."""

from __future__ import annotations

import math

from squama.batch.keeping import inlined as _in
from squama.batch.keeping import part as _jit
from squama.contacts.changes import solved, tried
from squama.contacts.conditions import MEET, MISSED_GAP, value, violated
from squama.contacts.detection import deepest
from squama.contacts.increments import Walk, between
from squama.contacts.system import copied

LOCATED = 1e-10
"""Width, rad per pitch, to which an event is located."""
_DEEPER, _PATIENT = 100, 12
"""Largest gap, in units of its tolerance, for which the zero of the gap is located by interpolation; number of secants
before every third one gives way to a bisection."""


@_jit
def locate(w: Walk, h: float, fresh: bool, what: int, c: int, high_value: float) -> tuple[float, int, int]:
    """Return the smallest increment up to h after which a condition is violated, the condition, and its contact.

    The state after it is in ``w.new``.
    """
    up, vu = h, high_value
    while True:
        # only marked pairs are searched on the way, all pairs at the end
        up, what, c = bisected(w, up, fresh, what, c, vu)
        marks = marked(w)
        if up < 0.0 or deepest(w.S, w.new, w.con, w.counts[0], w.W, -MISSED_GAP, w.near, True, w.found) < 0:
            return up, what, c
        if marked(w) == marks:
            return up, what, c
        vu = math.nan


@_jit
def marked(w: Walk) -> int:
    """Return the number of marked pairs."""
    n = 0
    for i in range(len(w.near)):
        for k in range(w.S.reach):
            n += w.near[i, k]
    return n


@_in
def slack(what: int) -> float:
    """Return the tolerance of a closing gap; 0 for other conditions, which are located to rounding."""
    return MISSED_GAP if what == MEET else 0.0


@_jit
def near(w: Walk, x: float, fresh: bool, y: float, z: float) -> bool:
    """Solve for the state after an increment x, begun from those after y, in ``w.aside``, and z, in ``w.trial``.

    ``y`` is 0 where no state is known, z where only one is. Returned is whether it was found.
    """
    if y > 0.0:
        between(w, x, y, z)
        if solved(w, x, fresh):
            return True
    return tried(w, x, fresh)


@_jit
def bisected(w: Walk, h: float, fresh: bool, what: int, c: int, high_value: float) -> tuple[float, int, int]:
    """Return as :func:`locate`, searching new contacts between marked pairs only.

    By the secant through both ends of the interval, where an end that stays counts half (the Illinois rule).
    """
    low_, up, vl, vu, last = 0.0, h, math.nan, high_value + slack(what), 0
    below, above = math.nan, vu
    # ways of the last two states without a violation: one with a violation may be on another branch
    y, z = 0.0, 0.0
    for count in range(80):
        if up - low_ < LOCATED:
            break
        x = (low_ + up) / 2
        if vl > 0.0 and vu < 0.0 and (count < _PATIENT or count % 3 > 0):
            x = low_ + (up - low_) * vl / (vl - vu)
            x = min(max(x, low_ + 0.3 * LOCATED), up - 0.3 * LOCATED)
        if not near(w, x, fresh, y, z):
            up, vu, above = x, math.nan, math.nan
            continue
        w2, c2, v2 = violated(w, w.new, False)
        if w2 < 0:
            copied(w.aside, w.trial)
            copied(w.new, w.aside)
            low_, y, z = x, x, y
            vl = below = value(w, w.new, what, c) + slack(what)
            if last == 1:
                vu /= 2
            last = 1
        else:
            if w2 != what or (c2 != c and c2 >= 0):
                what, c, vl, below = w2, c2, math.nan, math.nan
            up = x
            vu = above = v2 + slack(what)
            if last == 2 and vl > 0.0:
                vl /= 2
            last = 2
    if what == MEET:
        # to the last digits: the engagement is reported
        a, b = below - MISSED_GAP, above - MISSED_GAP
        # a vertex near another contact may come in deeper: its gap is not zero here
        if low_ > 0.0 and a > b > -_DEEPER * MISSED_GAP:
            up = max(low_ + (up - low_) * a / (a - b), low_ / 2)
        return (up if near(w, up, fresh, y, z) else -1.0), what, c
    if near(w, up, fresh, y, z):
        w2, c2, _ = violated(w, w.new, False)
        # -1: the violated state was on another branch than the last states
        return up, w2, c2
    return -1.0, what, c

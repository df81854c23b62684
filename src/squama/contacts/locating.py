"""Where on an increment a condition is violated first; compiled."""

from __future__ import annotations

import math

from squama.batch.keeping import inlined as _in
from squama.batch.keeping import part as _jit
from squama.contacts.changes import tried
from squama.contacts.conditions import MEET, MISSED_GAP, value, violated
from squama.contacts.detection import deepest
from squama.contacts.increments import Walk

LOCATED = 1e-10
"""Width, rad per pitch, to which an event is located."""
_DEEPER = 100
"""Gap, over that which may be missed, up to which a contact comes in where its gap is zero."""


@_jit
def closed(w: Walk, low_: float, up: float, fresh: bool) -> float:
    """Return the increment after which the gap that closes is zero, by those after two around it."""
    if low_ == 0.0 or not tried(w, low_, fresh):
        return up
    a = value(w, w.new, MEET, -1)
    if not tried(w, up, fresh):
        return up
    b = value(w, w.new, MEET, -1)
    # one that was near another contact may come in deeper: its gap is not closed here
    return max(low_ + (up - low_) * a / (a - b), low_ / 2) if a > b > -_DEEPER * MISSED_GAP else up


@_jit
def locate(w: Walk, h: float, fresh: bool, what: int, c: int, high_value: float) -> tuple[float, int, int]:
    """Find the least increment up to h after which a condition is violated; return it, what, and of which contact.

    The state after it is the new one.
    """
    up, vu = h, high_value
    while True:
        # only near pairs are looked at on the way, all of them at the end
        up, what, c = bisected(w, up, fresh, what, c, vu)
        marks = marked(w)
        if up < 0.0 or deepest(w.S, w.new, w.con, w.counts[0], w.W, -MISSED_GAP, w.near, True, w.found) < 0:
            return up, what, c
        if marked(w) == marks:
            return up, what, c
        vu = math.nan


@_jit
def marked(w: Walk) -> int:
    """Return how many pairs are marked."""
    n = 0
    for i in range(len(w.near)):
        for k in range(w.S.reach):
            n += w.near[i, k]
    return n


@_in
def slack(what: int) -> float:
    """Return by how much a gap that closes may be missed; 0 of other conditions, which change at rounding's pace."""
    return MISSED_GAP if what == MEET else 0.0


@_jit
def bisected(w: Walk, h: float, fresh: bool, what: int, c: int, high_value: float) -> tuple[float, int, int]:
    """Find as :func:`locate`, where new contacts are looked for between pairs that are marked."""
    low_, up, vl, vu, last = 0.0, h, math.nan, high_value + slack(what), 0
    for count in range(80):
        if up - low_ < LOCATED:
            break
        x = (low_ + up) / 2
        if vl > 0.0 and vu < 0.0 and count % 4 != 3:
            x = low_ + (up - low_) * vl / (vl - vu)
            x = min(max(x, low_ + 0.3 * LOCATED), up - 0.3 * LOCATED)
        if not tried(w, x, fresh):
            up, vu = x, math.nan
            continue
        w2, c2, v2 = violated(w, w.new, False)
        if w2 < 0:
            low_ = x
            vl = value(w, w.new, what, c) + slack(what)
            if last == 1:
                vu /= 2
            last = 1
        else:
            if w2 != what or (c2 != c and c2 >= 0):
                what, c, vl = w2, c2, math.nan
            up, vu = x, v2 + slack(what)
            if last == 2 and vl > 0.0:
                vl /= 2
            last = 2
    if what == MEET:
        # to the last digits: where a beam engages is told
        up = closed(w, low_, up, fresh)
        return (up if tried(w, up, fresh) else -1.0), what, c
    ok = tried(w, up, fresh)
    if ok:
        w2, c2, _ = violated(w, w.new, False)
        # -1: what was violated was another solution than the one that the last states lead to
        return up, w2, c2
    return -1.0, what, c

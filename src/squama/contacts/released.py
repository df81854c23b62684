"""Where scales come to bear on each other behind a contact that ran off its edge; compiled.

A corner that slides off the edge of the next scale falls past it, until other edges hold it: mostly the side edge that
ends at the corner, far from it. So the force of the contact is taken away little by little, and what comes to bear
meanwhile takes its place.
"""

from __future__ import annotations

from squama.batch.keeping import part as _jit
from squama.contacts.changes import regroup
from squama.contacts.handover import drop, let_go
from squama.contacts.increments import Walk
from squama.contacts.system import LET_GO, MU, SMOOTH, STUCK, copied, copy

_FIRST, _LEAST, _GROWTH, _SHRINK = 1 / 16, 1e-5, 2.0, 0.25
"""Share of the force that is taken away first, the least one at a time, and how it grows and shrinks."""


@_jit
def released(w: Walk, h: float, c: int) -> int:
    """Look for an equilibrium after an increment, from its guess, as the force of a contact is taken away; 0 if found.

    Contacts that come in meanwhile are smooth: what they slide along is not known. They stick where they then bear.
    """
    w.con[c, STUCK] = LET_GO
    share, by, code = 1.0, _FIRST, 0
    laid_aside(w)
    while share > 0.0:
        less = max(0.0, share - by)
        for a in range(3):
            w.new.F[c, a] *= less / share
        code = regroup(w, h, False)
        c = let_go(w)
        if code == 0 and c >= 0:
            share, by = less, by * _GROWTH
            laid_aside(w)
            continue
        c = taken_up(w)
        by *= _SHRINK
        if by < _LEAST:
            return code
    drop(w, w.new, c)
    code = regroup(w, h, False)
    for o in range(w.counts[0]):
        if w.con[o, STUCK] == SMOOTH:
            w.con[o, STUCK] = 1 if w.S.shapes[0, MU] > 0.0 else 0
    return code


@_jit
def laid_aside(w: Walk) -> None:
    """Keep a state on the way and its contacts."""
    copied(w.new, w.aside)
    copy(w.con, w.stuck)
    w.counts[2] = w.counts[0]


@_jit
def taken_up(w: Walk) -> int:
    """Come back to the state that was kept; return the contact that is let go of."""
    copied(w.aside, w.new)
    copy(w.stuck, w.con)
    w.counts[0], w.J.kept[0] = w.counts[2], 0
    return let_go(w)

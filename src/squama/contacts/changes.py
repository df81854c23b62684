"""Changes of the set of contacts, and the search for an equilibrium with the right set; compiled."""

from __future__ import annotations

import math

from squama.batch.keeping import part as _jit
from squama.contacts import conditions, increments, tally, touch
from squama.contacts.conditions import FLIP, LEAN, MEET, OFF, PULL, SLOPE, beyond, dips, sideways, violated
from squama.contacts.detection import edges_of, vertices
from squama.contacts.handover import add_contact, any_let_go, apart, become, drop, every, leave, roll, succeed
from squama.contacts.increments import Walk, guess, number, remark, tell, weigh
from squama.contacts.meeting import MARGIN, N_, prepared
from squama.contacts.newton import ROUNDED, solve
from squama.contacts.system import MU, State, copied, copy
from squama.types import Array

_NEAR = 0.01
"""Correction of a guess, over the increment, up to which the slips keep their directions."""
_CHANGES, _SETTLED = 24, 8
"""Largest number of changes of contacts in a search for one scale, three more for each further scale; rounds of
sticking and sliding after which the search looks for a cycle of them."""


@_jit
def unfold(w: Walk, st: State) -> bool:
    """Replace an edge contact that is tangent nowhere by the edge's end with the least gap; False if there is none.

    Of several edges that lie on faces it is the one tangent nearest to such an end.
    """
    prepared(w.S, st, w.con, w.counts[0], True, w.W)
    nearest, which, v = math.inf, -1, w.W.end
    for c in range(w.counts[0]):
        row = w.con[c]
        if row[touch.KIND] != touch.EF and row[touch.KIND] != touch.FE:
            continue
        side = 0 if row[touch.KIND] == touch.EF else 1
        own = row[touch.ONE] if side == 0 else row[touch.OTHER]
        n, best = vertices(w.S, st, w.W, row[touch.FIRST], row[touch.APART], 5e-3, w.found, 0), -1
        for a in range(n):
            kind = int(w.found[a, touch.KIND])
            p, q = edges_of(kind, int(w.found[a, touch.ONE]), int(w.found[a, touch.OTHER]), side)
            if kind < touch.EF and own in (p, q) and (best < 0 or w.found[a, touch.GAP] < w.found[best, touch.GAP]):
                best = a
        if best >= 0:
            far = apart(w, st, c, w.found[best])
            if far < nearest:
                nearest, which = far, c
                copy(w.found[best], v)
    if which < 0:
        return False
    become(w, st, which, v)
    w.con[which, touch.ENDED] = 1
    return True


@_jit
def tried(w: Walk, h: float, fresh: bool) -> bool:
    """Solve for the state after an increment; if Newton's method fails, let all contacts stick first, or end edges."""
    guess(w, h)
    if solved(w, h, fresh):
        return True
    if w.S.shapes[0, MU] > 0.0 and not fresh and w.counts[0] > 0:
        keep_stuck(w, w.con, w.stuck)
        guess(w, h)
        every(w, 1)
        if solved(w, h, True):
            return True
        keep_stuck(w, w.stuck, w.con)
    for _ in range(2):
        guess(w, h)
        if not unfold(w, w.new):
            return False
        if solved(w, h, True):
            # an edge that dips beside its end is still tangent somewhere: a shorter increment finds the place
            return not dipping(w, w.new)
    return False


@_jit
def dipping(w: Walk, st: State) -> bool:
    """Return whether an edge lies deeper beside an end of it that replaced it as contact."""
    found = False
    for c in range(w.counts[0]):
        if w.con[c, touch.ENDED] == 1:
            w.con[c, touch.ENDED] = 0
            found = found or dips(w, st, c)[0].real < -conditions.MISSED_SLOPE
            w.con[c, touch.ENDED] = 1
    return found


@_jit
def keep_stuck(w: Walk, a: Array, b: Array) -> None:
    """Copy from contacts ``a`` to ``b`` whether each sticks."""
    for c in range(w.counts[0]):
        b[c, touch.STUCK] = a[c, touch.STUCK]


@_jit
def solved(w: Walk, h: float, fresh: bool) -> bool:
    """Solve for the state after an increment from its guess; ``fresh``: contacts may change between stick and slide."""
    weigh(w, h)
    m, mu, near = w.counts[0], w.S.shapes[0, MU], _NEAR * h
    if not solve(w.S, w.new, w.past, w.con, m, w.W, w.J, w.loads, near):
        return False
    if not fresh or mu == 0.0:
        return True
    # the state with sticking contacts is near that with sliding ones
    left, before, felt, again, since = 2 * m + 2, -1, 0.0, _SETTLED, 0
    while left > 0:
        changed, left, since = False, left - 1, since + 1
        for c in range(m):
            if w.con[c, touch.STUCK] > 0 and w.W.told[c, MARGIN] > conditions.MISSED_CONE:
                w.con[c, touch.STUCK], changed = 0, True
        if not changed and m > 1:
            # others that slip may hold one of them
            for c in range(m):
                if w.con[c, touch.STUCK] == 0 and w.W.told[c, MARGIN] < -conditions.MISSED_CONE:
                    w.con[c, touch.STUCK], changed = 1, True
        if not changed:
            break
        w.J.kept[0] = 0
        if not solve(w.S, w.new, w.past, w.con, m, w.W, w.J, w.loads, near) and not sliding(w, h):
            return False
        there, feels = touched(w), pressed(w)
        if there == before and abs(feels - felt) < ROUNDED:
            # they stick and slide in a circle (Brent's algorithm): only as many more as lead to its last place
            left %= since
        elif since == again:
            before, felt, again, since = there, feels, 2 * again, 0
    return True


@_jit
def sliding(w: Walk, h: float) -> bool:
    """Solve for the state after an increment with all contacts sliding, started from the state without friction."""
    m = w.counts[0]
    guess(w, h)
    every(w, touch.SMOOTH)
    w.J.kept[0] = 0
    found = solve(w.S, w.new, w.past, w.con, m, w.W, w.J, w.loads)
    every(w, 0)
    w.J.kept[0] = 0
    return found and solve(w.S, w.new, w.past, w.con, m, w.W, w.J, w.loads)


@_jit
def give(w: Walk, st: State, what: int, c: int) -> None:
    """Remove a contact that violates a condition, or replace it by another one."""
    if what == PULL:
        drop(w, st, c)
    elif what == SLOPE:
        roll(w, st, c, dips(w, st, c)[1])
    elif what == FLIP:
        w.con[c, touch.STUCK] = 1 - w.con[c, touch.STUCK]
        w.J.kept[0] = 0
    elif not leave(w, st, c, beyond(w.S, st, w.con[c], c)[1]):
        if any_let_go(w):
            # slide off as another contact did
            w.con[c, touch.STUCK], w.J.kept[0] = touch.LET_GO, 0
        else:
            succeed(w, st, c)


@_jit
def missed(w: Walk, st: State, what: int, c: int) -> bool:
    """Return whether a contact violates condition ``what`` at the state just solved for."""
    if what == PULL:
        return bool(w.W.told[c, N_].real < -conditions.MISSED_PULL / 2)
    if what == FLIP:
        margin = w.W.told[c, MARGIN].real
        return bool((-margin if w.con[c, touch.STUCK] > 0 else margin) < -conditions.MISSED_CONE / 2)
    if what == SLOPE:
        return dips(w, st, c)[0].real < -conditions.MISSED_SLOPE / 2
    return beyond(w.S, st, w.con[c], c)[0].real < -conditions.MISSED_PLACE / 2


@_jit
def touched(w: Walk) -> int:
    """Return a number for the set of contacts and their sticking, independent of their order."""
    n: int = 0
    for c in range(w.counts[0]):
        n += (3 * number(w.con[c]) + w.con[c, touch.STUCK] + 1) * 2654435761 % 4294967291
    return n


@_jit
def pressed(w: Walk) -> float:
    """Return a number of the forces and places of the present contacts, to know a state again by."""
    total = 0.0
    for c in range(w.counts[0]):
        for a in range(3):
            total += w.new.F[c, a].real + w.new.s[c, a].real
    return total


@_jit
def regroup(w: Walk, h: float, deep: bool) -> int:
    """Search for any equilibrium after an increment by changing contacts until all conditions hold; 0 if they do.

    ``deep``: allow scales to interpenetrate deeper than where one comes in from the side. Else the code of the failure
    is returned.
    """
    ends, slide, before, again = 0, True, -1, 1
    for count in range(_CHANGES + 3 * (len(w.S.shapes) - 1)):
        # contacts that were there before come and go in a circle (Brent's algorithm)
        there = touched(w)
        if there == before:
            return increments.NO_EQUILIBRIUM
        if count == again:
            before, again = there, 2 * again
        copied(w.new, w.trial)
        if not solved(w, h, True):
            copied(w.trial, w.new)
            if slide and w.S.shapes[0, MU] > 0.0 and w.counts[0] > 0:
                # contacts that do not slide together may stick, or open when they do
                slide, w.J.kept[0] = False, 0
                every(w, 1)
                continue
            ends += 1
            if ends > 3 or not unfold(w, w.new):
                return increments.NO_EQUILIBRIUM
            continue
        what, c, v = violated(w, w.new, True)
        if what < 0:
            return 0
        if what >= LEAN:
            return increments.SIDE_ENTRY if what == LEAN else increments.TOO_FAR
        if what != MEET:
            scale = w.con[c, touch.FIRST]
            give(w, w.new, what, c)
            for o in range(w.counts[0] - 1, -1, -1):
                if len(w.S.shapes) > 1 and w.con[o, touch.FIRST] != scale and missed(w, w.new, what, o):
                    give(w, w.new, what, o)
        else:
            if sideways(w, v) and not deep:
                return increments.SIDE_ENTRY
            if not add_contact(w, w.new, w.best):
                return increments.MANY
    return increments.NO_EQUILIBRIUM


@_jit
def change(w: Walk, what: int, c: int, events: Array) -> bool:
    """Change the contacts at an event, at the last state; False if the path does not continue smoothly.

    ``w.best`` is the contact that comes in, or replaces one that leaves its edge.
    """
    t = w.tally
    remark(w, what, c)
    if what == PULL:
        tell(w, events, increments.OPEN, c, 0.0)
        drop(w, w.now, c)
    elif what == FLIP:
        w.con[c, touch.STUCK] = 1 - w.con[c, touch.STUCK]
        w.J.kept[0] = 0
        tell(w, events, increments.STICK if w.con[c, touch.STUCK] > 0 else increments.SLIDE, c, 0.0)
        if w.con[c, touch.STUCK] == 0:
            t[tally.ONSET] = t[tally.LOAD]
    elif what == SLOPE:
        roll(w, w.now, c, dips(w, w.now, c)[1])
        if w.con[c, touch.KIND] >= touch.EF:
            tell(w, events, increments.CHANGE, c, 0.0)
    elif what == OFF:
        v = w.best
        if not leave(w, w.now, c, beyond(w.S, w.now, w.con[c], c)[1]):
            if v[touch.KIND] < 0.0:
                return False
            become(w, w.now, c, v)
        tell(w, events, increments.CHANGE, c, 0.0)
    else:
        if not add_contact(w, w.now, w.best):
            return False
        tell(w, events, increments.ENGAGE, w.counts[0] - 1, 0.0)
    t[tally.SINCE] = t[tally.WAY]
    return True

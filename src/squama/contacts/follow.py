"""A load path, increment by increment: contacts come, stick, slip, hand over and go at located events; compiled.

An increment is solved with the contacts of the last state. Where it then violates a condition (a force that pulls, a
place beyond its edge, a gap below zero, a stuck contact outside its cone, an edge that dips) the first such place is
found by a root on the increment, the state there is taken, the contacts change, and the path goes on.
"""

from __future__ import annotations

import math

from squama.batch.keeping import part as _jit
from squama.contacts import increments, tally, touch
from squama.contacts.changes import change, missed, regroup, tried
from squama.contacts.conditions import FLIP, LEAN, MEET, MISSED_GAP, OFF, lying, sideways, violated
from squama.contacts.detection import deepest, deepest_of
from squama.contacts.handover import doubled, drop, every, merged, successor
from squama.contacts.increments import Legs, Walk, Written, guess, keep, note, remark, restore, tell, tell_gone, weigh
from squama.contacts.locating import LOCATED, locate
from squama.contacts.meeting import clear, inclination, prepared
from squama.contacts.newton import solve
from squama.contacts.relaxing import relaxed
from squama.contacts.slipped import GUESSES, released, slipped
from squama.contacts.system import FREE, MU, STRAINS, cells, copy
from squama.contacts.works import INEXACT, SNAPS, UNBALANCED, accept, fall, remember, rounded, unbalanced, worked
from squama.contacts.written import write
from squama.types import Array

_START, _SOFTLY, _GENTLE, _FREELY = 1 / 16, 1 / 8, 1 / 64, 4.0
"""First increments at engagement, after other events, and at a turn of the path; increments without contact."""
_SHORT = 5e-4
"""Increment, rad per pitch: as much as one so long may be lost by a shorter one."""
_LEAST, _SHRINK, _EVENTS, _ZEROS, _FLIPS = 1e-8, 0.35, 400, 8, 2
"""Least increment, and by how much one that fails shrinks; limits of events of each scale, of successive events without
an increment, and of those of them in which contacts stick or slide."""
_CREEPS, _RESTS = 1e-6, 4
"""Way at least between two states of rest that are crept to; how many of them, and one more for each scale of a row."""
_FAR = 6
"""How many increments, each ten times the last one, an equilibrium is looked for after."""


@_jit
def reached(w: Walk, h: float, before: float, gone: int) -> int:
    """Look for any equilibrium after an increment; 0 if it is found.

    From the last contacts, as they are and all sticking, and from none; or, if it is not -1, as the contact ``gone``
    gives way, and with other edges in its place. None has more energy than that ``before`` and the work done.
    """
    code = increments.NO_EQUILIBRIUM
    # at leisure it is only the walk that was given up in haste
    for way in range(3 if gone < 0 else (1 + GUESSES if w.tally[tally.HASTY].real > 0.0 else 1)):
        restore(w)
        w.tally[tally.FRESH] = 0.0
        guess(w, h)
        if gone >= 0:
            found = released(w, h, gone) if way == 0 else slipped(w, h, gone, way - 1)
        elif way == 1 and not rubs(w):
            continue
        else:
            if way == 1:
                every(w, 1)
            if way == 2:
                # from the state without any contact
                w.counts[0], w.J.kept[0] = 0, 0
            found = regroup(w, h, False)
        if found < 0:
            break
        if found == 0:
            lost, doubt = fall(w, h, before)
            if lost.real >= -doubt.real - SNAPS * max(before.real, rounded(w).real):
                return 0
            found = increments.NO_EQUILIBRIUM
        code = found if way == 0 else code
    return code


@_jit
def rubs(w: Walk) -> bool:
    """Say whether a contact slid in the last state, against friction."""
    found = False
    for c in range(w.counts[1]):
        found = found or w.kept[c, touch.STUCK] == 0
    return found and w.S.shapes[0, MU].real > 0.0


@_jit
def land(w: Walk, h: float, before: float, events: Array) -> None:
    """Go on from the equilibrium that was found after an increment, and tell what is lost and which contact changed."""
    t = w.tally
    lost, _ = fall(w, h, before)
    lost += t[tally.GRIPS]
    rubbed, slid, other = t[tally.RUBBED], t[tally.SLID], t[tally.SLID_OTHER]
    note(w, h)
    remark(w, increments.LOST, -1)
    accept(w, h, True, worked(w, h))
    # what is rubbed in a snap is a part of what it loses
    t[tally.RUBBED], t[tally.SLID], t[tally.SLID_OTHER] = rubbed, slid, other
    t[tally.GRIPS] = 0.0
    if lost < 0.0:
        # it jumped where the loads did as much as is stored
        t[tally.WORK] -= lost / cells(w.S)
        lost *= 0.0
    kind = increments.SNAP if lost > SNAPS * max(before, rounded(w)) else increments.CHANGE
    t[tally.LOST] += lost
    c, gone = altered(w)
    tell(w, events, kind, c, lost)
    if gone >= 0:
        tell_gone(w, events, gone)


@_jit
def altered(w: Walk) -> tuple[int, int]:
    """Return which contact a jump brought, and if it brought none which it took away; of several the most pressed one.

    -1 for none; where the contacts are the same the most pressed one is the first number.
    """
    came = strongest(w.con, w.counts[0], w.now.F, w.kept, w.counts[1])
    if came >= 0:
        return came, -1
    gone = strongest(w.kept, w.counts[1], w.old.F, w.con, w.counts[0])
    return (-1, gone) if gone >= 0 else (strongest(w.con, w.counts[0], w.now.F, w.con, 0), -1)


@_jit
def strongest(con: Array, m: int, F: Array, others: Array, n: int) -> int:
    """Return the contact of the largest force among those that are not in another list; -1 for none."""
    best, most = -1, -1.0
    for c in range(m):
        there = False
        for o in range(n):
            same = True
            for a in range(touch.FIRST, touch.STUCK):
                same = same and con[c, a] == others[o, a]
            there = there or same
        size = abs(F[c, 0]) ** 2 + abs(F[c, 1]) ** 2 + abs(F[c, 2]) ** 2
        if not there and size > most:
            best, most = c, size
    return best


@_jit
def jump(w: Walk, goal: float, step: float, gone: int, events: Array) -> int:
    """Go on from where the path is not continuous: to an equilibrium a little further, with the energy it loses.

    ``gone``: a contact that left its edge, which gives way, or -1. What was given up in haste is looked at once more
    where nothing else is found.
    """
    t = w.tally
    for c in range(w.counts[0]):
        w.con[c, touch.ENDED] = 0
    keep(w)
    t[tally.HASTY] = 1.0
    code = landed(w, goal, step, gone, events)
    if code != 0 and t[tally.HASTY].real > 1.0:
        t[tally.HASTY] = 0.0
        code = landed(w, goal, step, gone, events)
    if code != 0:
        restore(w)
    return code


@_jit
def landed(w: Walk, goal: float, step: float, gone: int, events: Array) -> int:
    """Go on as :func:`jump` after one of some increments, each ten times as long as the one before; 0 if it did.

    A station that would be passed is tried first: its state is one of its own way if there is an equilibrium.
    """
    t = w.tally
    before, left = t[tally.ENERGY], goal - t[tally.WAY]
    # where it stops again at once an equilibrium farther off is looked for
    begin = int(t[tally.TRIAL].real) + 1 if 0.0 < t[tally.JUMPED].real > t[tally.WAY].real - step / 4 else 0
    code, passed = increments.RANGE, False
    for trial in range(min(begin, _FAR), _FAR):
        h = 1e-7 * 10.0**trial if trial < _FAR - 1 else step
        found = increments.NO_EQUILIBRIUM
        if h > left and not passed:
            passed = True
            found = reached(w, left, before, gone)
            if found == 0:
                h = left
        if found != 0:
            found = reached(w, h, before, gone)
        code = found if code == increments.RANGE else code
        if found != 0:
            continue
        land(w, h, before, events)
        t[tally.TRIAL], t[tally.JUMPED] = trial, t[tally.WAY]
        t[tally.SINCE], t[tally.H] = t[tally.WAY], step * _SOFTLY
        return 0
    return code if code != increments.RANGE else increments.NO_EQUILIBRIUM


@_jit
def stopped(w: Walk, goal: float, step: float, events: Array) -> int:
    """Go on where no increment is small enough: with one contact less, or by a jump."""
    c, several = w.counts[0] - 1, len(w.S.shapes) > w.S.stride
    # of a row one place is given up before all of its contacts are looked for anew
    if not merged(w, several):
        code = jump(w, goal, step, -1, events)
        o = doubled(w) if code == increments.NO_EQUILIBRIUM else -1
        if o >= 0:
            # a corner about to leave a face, whose edge comes in beside it
            drop(w, w.now, c)
            code = jump(w, goal, step, o, events)
        if several or code == increments.RANGE or o >= 0 or not merged(w, True):
            return code
    copy(w.kept[c], w.con[c])
    tell(w, events, increments.OPEN, c, 0.0)
    # where a row has no balance with this one less either, the next one follows without smaller trials
    w.tally[tally.H], w.tally[tally.ZERO] = 2 * _LEAST if several else step * _SOFTLY, 0.0
    return 0


@_jit
def advance(w: Walk, goal: float, step: float, events: Array) -> int:
    """Go on towards a way by one increment; return why not, 0 if it went on."""
    t, m, N = w.tally, w.counts[0], len(w.S.shapes)
    left = goal - t[tally.WAY]
    most = step * _FREELY if m == 0 else step
    h = min(t[tally.H], most)
    h = left / math.ceil(left / h * (1 - 1e-9))
    fresh = t[tally.FRESH] < 1 and t[tally.ZERO] >= 0
    for c in range(m):
        if w.con[c, touch.ENDED] != touch.FLUSH:
            w.con[c, touch.ENDED] = 0
    keep(w)
    while True:
        if not tried(w, h, fresh):
            restore(w)
            h *= _SHRINK
            if h < _LEAST:
                return stopped(w, goal, step, events)
            continue
        clear(w.near)
        what, c, v = violated(w, w.new, True)
        where = h
        if what >= 0:
            if what != MEET:
                deepest(w.S, w.new, w.con, m, w.W, -MISSED_GAP, w.near, True, w.found)
            where, what, c = locate(w, h, fresh, what, c, v)
        spent = worked(w, where)
        lost, share = unbalanced(w, spent) if where >= 0.0 else (math.inf, math.inf)
        if not (lost <= UNBALANCED and share <= INEXACT * max(where, _SHORT)):
            restore(w)
            h = _SHRINK * (where if lost <= UNBALANCED else h)
            if h < _LEAST:
                return stopped(w, goal, step, events)
            continue
        break
    if what == MEET and sideways(w, v) and w.best[touch.GAP] < -1e-3:
        return increments.SIDE_ENTRY
    note(w, where)
    if what < 0:
        accept(w, where, False, spent)
        # what is lost is of the fourth order; by halves, so that rounding does not change increments
        h = 2 * where
        while h.real > 2 * _LEAST and share * (h.real / where) ** 4 > INEXACT / 2 * max(where, _SHORT):
            h /= 2
        t[tally.H], t[tally.ZERO] = min(most, h.real), 0.0
        return 0
    accept(w, where, True, spent)
    if what >= LEAN:
        return increments.SIDE_ENTRY if what == LEAN else increments.TOO_FAR
    scale = int(w.best[touch.FIRST]) if what == MEET else int(w.con[c, touch.FIRST])
    t[tally.ZERO] = t[tally.ZERO] + 1 if where < 10 * LOCATED else 0.0
    t[tally.H] = step * (_START if m == 0 else _SOFTLY)
    # those that stick or slide at one way change together
    zeros = _FLIPS if what == FLIP else _ZEROS + N - 1
    if t[tally.ZERO] > zeros or t[tally.EVENTS] > _EVENTS * N or not altering(w, what, c, events):
        t[tally.ZERO] = 0.0
        code = jump(w, goal, step, -1, events)
        if code != increments.RANGE and what == OFF:
            code = jump(w, goal, step, c, events)
        # a corner that leaves an edge, and finds no other hold, comes to lie beside it
        return increments.SIDE_ENTRY if what == OFF and code == increments.NO_EQUILIBRIUM else code
    together(w, what, scale, events)
    return 0


@_jit
def together(w: Walk, what: int, scale: int, events: Array) -> None:
    """Change the contacts of other scales at which the same happens where an event was located on one scale."""
    if len(w.S.shapes) == 1:
        return
    if what == MEET and w.best[touch.KIND] == touch.LIES:
        for i in range(len(w.S.rests)):
            if i != scale and abs(inclination(w.S, i, w.W)) < MISSED_GAP and not lying(w, i):
                w.best[touch.FIRST] = i
                change(w, what, -1, events)
        return
    if what == MEET:
        clear(w.near)
        deepest(w.S, w.now, w.con, w.counts[0], w.W, MISSED_GAP, w.near, True, w.found)
        for i in range(len(w.S.shapes)):
            for k in range(1, w.S.reach + 1):
                if i == scale or w.near[i, k - 1] == 0:
                    continue
                a, _ = deepest_of(w.S, w.now, w.con, w.counts[0], w.W, i, k, MISSED_GAP, w.found, 0)
                if a >= 0:
                    copy(w.found[a], w.best)
                    if not change(w, what, -1, events):
                        return
        return
    for c in range(w.counts[0] - 1, -1, -1):
        if w.con[c, touch.FIRST] != scale and missed(w, w.now, what, c):
            altering(w, what, c, events)


@_jit
def altering(w: Walk, what: int, c: int, events: Array) -> bool:
    """Change the contacts at an event as :func:`change`, with a look at what takes the place of one that leaves."""
    if what == OFF:
        successor(w, w.now, c)
    return change(w, what, c, events)


@_jit
def set_out(w: Walk, corners: Array, ways: Array, i: int, step: float) -> None:
    """Turn onto the leg to a corner."""
    t, leg = w.tally, w.leg
    begin = ways[i - 1] if i > 0 else 0.0
    length, turns, size = ways[i] - begin, 0.0, 0.0
    for e in range(STRAINS):
        before = corners[i - 1, e] if i > 0 else 0.0
        rate = (corners[i, e] - before) / length
        turns += rate * leg[4 + e]
        size += rate * rate
    went = 0.0
    for e in range(STRAINS):
        went += leg[4 + e] ** 2
    straight = i > 0 and turns.real > (1 - 1e-9) * math.sqrt(size.real * went.real)
    load = 0.0
    for e in range(STRAINS):
        before = corners[i - 1, e] if i > 0 else 0.0
        leg[4 + e] = (corners[i, e] - before) / length
        leg[e] = before - leg[4 + e] * begin
        if w.S.free[e] != FREE:
            load += w.loads[e] * leg[4 + e]
    if not straight:
        t[tally.FRESH], t[tally.ONSET], t[tally.LOAD], t[tally.POWER] = 0.0, load, load, 0.0
        t[tally.H] = step if w.counts[0] == 0 else step * _GENTLE
        if w.S.shapes[0, MU].real > 0.0:
            for c in range(w.counts[0]):
                w.con[c, touch.STUCK] = 1
            # where they slide again is located
            t[tally.ZERO] = -1.0
        w.J.kept[0] = 0


@_jit
def strained(w: Walk, within: Array) -> bool:
    """Say whether a cell is strained beyond limits (4,)."""
    found = False
    for i in range(len(w.now.strains)):
        for e in range(STRAINS):
            found = found or abs(w.now.strains[i, e].real) > within[e]
    return found


@_jit
def follow(w: Walk, legs: Legs, written: Written) -> None:
    """Follow a beam along legs, and write the states at their ways, events and the end.

    From rest, or from a state read from a snapshot (:mod:`squama.contacts.snapshot`): the first corner, at the way 0.

    Where nothing touches up to there, that is looked for straight on; without ways along the first of the corners, a
    rate.
    """
    ways, corners, most, step = legs.ways, legs.corners, float(legs.most), legs.step
    events, end = written.events, written.ends
    t = w.tally
    code = increments.RANGE
    done, last, rests, rested = 0, math.inf, 0, -math.inf
    # where an endless beam jumps, all of its scales do
    most_rests = _RESTS + len(w.S.shapes) if len(w.S.shapes) > w.S.stride else 0
    prepared(w.S, w.now, w.con, w.counts[0], True, w.W)
    if t[tally.COUNT] == 0:
        t[tally.H], t[tally.SIZE], t[tally.BEFORE] = step, step, step
        weigh(w, step)
        solve(w.S, w.now, w.past, w.con, 0, w.W, w.J, w.loads)
        if deepest(w.S, w.now, w.con, 0, w.W, -1e-9, w.near, True, w.found) >= 0:
            code = increments.AT_REST
        remember(w)
        remember(w)
    for i in range(len(ways)):
        if code != increments.RANGE:
            break
        begin = ways[i - 1] if i > 0 else 0.0
        if ways[i] > begin:
            set_out(w, corners, ways, i, step)
        guard = 0
        while code == increments.RANGE and t[tally.WAY] < ways[i] - 1e-13:
            code = advance(w, ways[i], step, events)
            if code == increments.NO_EQUILIBRIUM and rests < most_rests and t[tally.WAY].real > rested:
                rests, rested = rests + 1, t[tally.WAY].real + _CREEPS
                code = relaxed(w, ways[i], events)
            guard += 1
            if guard > 100000:
                code = increments.NO_EQUILIBRIUM
        if code == increments.RANGE and strained(w, legs.within):
            last = begin
            break
        if code == increments.RANGE:
            # what is told of contacts is that of the state solved for last
            write(w, written, i)
            done += 1
    end[0], end[1] = code, min(last, t[tally.WAY].real)
    while code == increments.RANGE and t[tally.EVENTS] == 0 and t[tally.WAY] < most - 1e-13:
        if len(ways) == 0 and t[tally.WAY] == 0.0:
            for e in range(STRAINS):
                w.leg[4 + e] = corners[0, e]
        if advance(w, most, step, events) != increments.RANGE:
            break
    end[2], end[3] = t[tally.EVENTS], done

"""Derivatives of load paths with respect to designs: a recorded path followed again with complex steps; compiled.

The real path is followed once and its increments are recorded (``squama.contacts.increments.note``). With the
equations r(z, states before, beam, strains) = 0 of an increment and J = dr/dz, a change of the beam changes the state
by

    dz = -J^-1 (change of r with the beam, the strains and the states before)

(implicit function theorem). All changes are imaginary parts of one evaluation, z -= i J^-1 Im r: no differences are
taken. J need not be exact: the effect of its error is in the next Im r, and is corrected.

The size of an increment that ends with an event is such that the event's condition holds: a gap, N, a place at its
edge's end, abs(y) - mu N or the slope of a gap is zero for any beam. The imaginary part of the size makes that of the
condition vanish, so that the followed curve itself is differentiated, beyond events as well: where contacts come, open,
stick, slip and replace each other, states are continuous. At a snap they are not: there and beyond it imaginary
parts are NaN.
"""

from __future__ import annotations

import math

import numpy as np

from squama.batch.keeping import making
from squama.batch.keeping import part as _jit
from squama.contacts import increments, tally, touch
from squama.contacts.changes import change
from squama.contacts.conditions import MEET, condition
from squama.contacts.detection import gap_at
from squama.contacts.equations import residual
from squama.contacts.follow import set_out
from squama.contacts.increments import Legs, Walk, Written, guess, weigh
from squama.contacts.linear import exchanged, laid_out, stored, substitute
from squama.contacts.meeting import inclination, prepared
from squama.contacts.newton import shift
from squama.contacts.system import PHI, STRAINS, State, copy
from squama.contacts.works import accept, remember, worked
from squama.contacts.written import write
from squama.types import Array

_ROUNDS, _TIGHT, _LOOSE, _AT_ONCE = 12, 1e-13, 1e-6, 1e-9
"""Largest number of corrections of a change; relative error of the last correction that is accepted, and beyond which
the change is unknown; size of an increment below which two events coincide.
"""


@_jit
def read(w: Walk, at: int) -> tuple[int, int, int]:
    """Take contacts and real parts of the state from a record; return numbers of contacts and unknowns, index of J."""
    notes, st, width = w.notes, w.new, w.con.shape[1]
    m, n = int(notes[at + increments.NOTED_M]), int(notes[at + increments.NOTED_N])
    a = at + increments.NOTED
    for c in range(m):
        for o in range(width):
            w.con[c, o] = int(notes[a + o])
        a += width
    w.counts[0] = m
    a = taken(notes, a, st.q, len(st.q))
    a = taken(notes, a, st.strains, 1)
    a = taken(notes, a, st.F, m)
    return m, n, taken(notes, a, st.s, m)


@_jit
def taken(notes: Array, at: int, a: Array, m: int) -> int:
    """Copy recorded real parts into the first m rows of an array; return the index behind them."""
    for i in range(m):
        for b in range(a.shape[1]):
            a[i, b] = notes[at] + 1j * a[i, b].imag
            at += 1
    return at


@making
def changed(w: Walk, at: int, h: float) -> bool:
    """Compute the state after an increment of complex size with recorded real part; False if its change is unknown."""
    S, J, st = w.S, w.J, w.new
    weigh(w, h)
    guess(w, h)
    m, n, a = read(w, at)
    laid_out(S, w.con, m, J)
    exchanged(J, n, w.notes, a, False)
    x = np.empty(n)
    loose = False
    for e in range(STRAINS):
        loose = loose or S.free[e] > 0
    moved, known, last = True, False, math.inf
    for count in range(_ROUNDS + 1):
        prepared(S, st, w.con, m, moved, w.W)
        moved = loose
        residual(S, st, w.past, w.con, m, J.at, n, w.W, J.r, w.loads)
        if known or count == _ROUNDS:
            break
        for i in range(n):
            x[i] = J.r[i].imag
        substitute(J, n, x)
        shift(S, st, w.con, m, J.at, n, x, -1j)
        size, scale = largest(x), extent(w, m)
        rate = min(1.0, size / last) if last < math.inf else 1.0
        known = not size * rate > _TIGHT * scale
        last = size
    return known or last <= _LOOSE * extent(w, m)


@_jit
def largest(x: Array) -> float:
    """Return the largest magnitude in an array."""
    size = 0.0
    for v in x:
        size = max(size, abs(v))
    return size


@_jit
def extent(w: Walk, m: int) -> float:
    """Return the largest imaginary part of the unknowns in the new and in the last state."""
    return max(extent_of(w.new, m), extent_of(w.now, m))


@_jit
def extent_of(st: State, m: int) -> float:
    """Return the largest imaginary part of a state's unknowns."""
    size = 0.0
    for i in range(len(st.q)):
        for a in range(st.q.shape[1]):
            size = max(size, abs(st.q[i, a].imag))
    for e in range(STRAINS):
        size = max(size, abs(st.strains[0, e].imag))
    for c in range(m):
        for a in range(3):
            size = max(size, abs(st.F[c, a].imag), abs(st.s[c, a].imag))
    return size


@_jit
def missed(w: Walk, what: int, c: int) -> float:
    """Return the imaginary part of an event's condition at the new state."""
    if what != MEET:
        return condition(w, w.new, what, c).imag
    if w.best[touch.KIND] == touch.LIES:
        return inclination(w.S, int(w.best[touch.FIRST]), w.W).imag
    return gap_at(w.S, w.new, w.W, w.best).imag


@_jit
def increment(w: Walk, at: int, goal: complex, events: Array) -> bool:
    """Follow the recorded increment at index ``at``; return False if changes are unknown beyond it."""
    t, notes = w.tally, w.notes
    h, what = notes[at + increments.NOTED_H], int(notes[at + increments.NOTED_WHAT])
    c = int(notes[at + increments.NOTED_WHICH])
    if what == increments.LOST:
        return False
    left, by, first = goal - t[tally.WAY], 0.0, 0.0
    if what == increments.NOTHING:
        # the same share of the remaining way
        by = left.imag * (h / left.real)
    else:
        copy(notes[at + increments.NOTED_VERTEX : at + increments.NOTED], w.best)
    for trial in range(3):
        if not changed(w, at, h + 1j * by):
            return False
        if what == increments.NOTHING or h < _AT_ONCE or trial == 2:
            break
        off = missed(w, what, c)
        if trial == 0:
            if off == 0.0:
                break
            first, by = off, abs(off)
        else:
            # linear in the size's change
            by *= first / (first - off)
            if not math.isfinite(by):
                return False
    accept(w, h + 1j * by, what != increments.NOTHING, worked(w, h + 1j * by))
    return what == increments.NOTHING or change(w, what, c, events)


@_jit
def length(w: Walk, at: int) -> int:
    """Return the number of recorded values of an increment."""
    m, n = int(w.notes[at + increments.NOTED_M]), int(w.notes[at + increments.NOTED_N])
    return int(increments.NOTED + m * (w.con.shape[1] + 6) + w.new.q.size + STRAINS + stored(w.J, n))


@_jit
def unknown(a: Array) -> None:
    """Fill an array with NaN, for unknown changes."""
    x = a.flat
    for i in range(a.size):
        x[i] = complex(math.nan, math.nan)


@_jit
def again(w: Walk, legs: Legs, written: Written) -> None:
    """Follow a recorded path with the complex steps of beam, ways and corners, from where it began.

    The ends are those of the real path. The output is that of :func:`squama.contacts.follow.follow`, NaN where changes
    are unknown: behind a snap, at a way with an event, and beyond the room for the record.
    """
    ways, events = legs.ways, written.events
    t, at, known = w.tally, 1, True
    stop = abs(int(w.notes[0]))
    prepared(w.S, w.now, w.con, w.counts[0], True, w.W)
    if t[tally.COUNT].real == 0:
        t[tally.SIZE], t[tally.BEFORE] = legs.step, legs.step
        remember(w)
        remember(w)
    unknown(events)
    for i in range(len(ways) + 1):
        goal = ways[i] if i < len(ways) else complex(legs.most)
        begin = ways[i - 1].real if i > 0 else 0.0
        if i < len(ways) and ways[i].real > begin:
            set_out(w, legs.corners, ways, i, legs.step)
        elif len(ways) == 0:
            w.leg[4 + PHI] = 1.0
        event = False
        while known and at < stop and t[tally.WAY].real < goal.real - 1e-13:
            known = increment(w, at, goal, events)
            event = int(w.notes[at + increments.NOTED_WHAT]) != increments.NOTHING
            at += length(w, at)
        if i >= int(written.ends[3]):
            continue
        known = known and t[tally.WAY].real >= goal.real - 1e-13
        if known and not event:
            write(w, written, i)
        else:
            unknown(written.rows[i])
            unknown(written.motions[i])
            unknown(written.bends[i])
            unknown(written.contacts[i])

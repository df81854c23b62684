"""A path on its way: what is followed, its states, and what is counted and noted along it; compiled."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from squama.batch.keeping import part as _jit
from squama.contacts import tally, touch
from squama.contacts.jacobian import jacobian
from squama.contacts.linear import SOLVED, Linear, exchanged, factor, laid_out, stored
from squama.contacts.meeting import Work
from squama.contacts.supports import GIVEN, LOADS
from squama.contacts.system import IMPOSED, STRAINS, Past, State, System, copied, copy, transfer
from squama.types import Array

RANGE, NO_EQUILIBRIUM, SIDE_ENTRY, AT_REST, MANY, TOO_FAR = range(6)
"""How a path ends: at its last target, without an equilibrium, where side faces bear, plates that touch at rest, more
contacts than there is room for, motions beyond the linear joint."""
ENGAGE, OPEN, SLIDE, STICK, CHANGE, SNAP = range(6)
"""What happens on the way."""
CONTACT, EVENT, LINE = 16, 25, 22
"""Columns of a contact, an event and a row that are written."""
AFTER = 17
"""First column of an event that holds a contact that there is behind it, see :func:`number`."""
SCALE = 64 * 5 * 4 * 4
"""How many such numbers there are of a scale."""
NOTED_H, NOTED_WHAT, NOTED_WHICH, NOTED_M, NOTED_N, NOTED_VERTEX = range(6)
NOTED = NOTED_VERTEX + touch.VERTEX
"""What is noted of an increment first, see :func:`note`: its size; what ended it (-1: nothing), of which contact;
contacts and unknowns; the vertex that came in."""
NOTHING, LOST = -1, 5
"""What ends an increment beside the violations: nothing, and a snap."""


class Walk(NamedTuple):
    """A path on its way: what it follows, three states, contacts now and (``kept``) before a trial, and counters.

    ``notes`` (n,): room for all increments, if any is given, see :func:`note`; ``loads`` (4,) are M, T, B, P;
    ``counts`` (4,): contacts now, and kept; ``leg`` (8,): strains at way 0 of the leg and their rates; ``best`` the
    vertex found last; ``near`` (N, reach): pairs at which is looked.
    """

    S: System
    W: Work
    J: Linear
    now: State
    new: State
    old: State
    older: State
    trial: State
    aside: State
    past: Past
    con: Array
    kept: Array
    stuck: Array
    found: Array
    loads: Array
    counts: Array
    leg: Array
    tally: Array
    best: Array
    near: Array
    notes: Array


ANY = np.full(STRAINS, np.inf)
"""No limit to the strains of a cell."""


class Legs(NamedTuple):
    """Rising ways (m,) of a path, and the strains there (m, 4), between which it is straight; of n paths (n, m, ...).

    ``most``: the way to which a first contact is looked for, for each path; ``step``: the largest increment; ``within``
    (4,): strains of a cell, at the first corner beyond which a path ends at the one before.
    """

    ways: Array
    corners: Array
    most: Array
    step: float
    within: Array = ANY


class Written(NamedTuple):
    """What is written of a path at m ways, see :func:`squama.contacts.written.write`; of n paths (n, ...).

    ``rows`` (m, 22), ``motions`` (m, N, 6 or 14), ``bends`` (m, N, 24), ``contacts`` (m, C, 16), ``events`` (E, 25),
    and ``ends`` (4,): why, way, events, rows.
    """

    rows: Array
    motions: Array
    bends: Array
    contacts: Array
    events: Array
    ends: Array


@_jit
def extrapolate(t: Array, x: float, y: float, now: Array, old: Array, older: Array, new: Array) -> None:
    """Add to numbers what the last three states say of their change, linear by x and quadratic by y."""
    a, b, c, n = now.flat, old.flat, older.flat, new.flat
    for i in range(now.size):
        d = a[i] - b[i]
        n[i] += x * d + y * (d / t[tally.SIZE] - (b[i] - c[i]) / t[tally.BEFORE])


@_jit
def guess(w: Walk, h: float) -> None:
    """Write a guess of the state after an increment: as the last ones went on."""
    t, a, b, c, n = w.tally, w.now, w.old, w.older, w.new
    copied(a, n)
    if t[tally.FRESH].real >= 1:
        x = h / t[tally.SIZE]
        y = 0.0
        if t[tally.FRESH].real >= 2:
            y = h * (h + t[tally.SIZE]) / (t[tally.SIZE] + t[tally.BEFORE])
        m = w.counts[0]
        extrapolate(t, x, y, a.q, b.q, c.q, n.q)
        extrapolate(t, x, y, a.strains, b.strains, c.strains, n.strains)
        extrapolate(t, x, y, a.ties[LOADS], b.ties[LOADS], c.ties[LOADS], n.ties[LOADS])
        extrapolate(t, x, y, a.F[:m], b.F[:m], c.F[:m], n.F[:m])
        extrapolate(t, x, y, a.s[:m], b.s[:m], c.s[:m], n.s[:m])
    given(w, h)


@_jit
def given(w: Walk, h: float) -> None:
    """Write imposed strains after an increment, and how far along the leg ties go."""
    n, way = w.new, w.tally[tally.WAY] + h
    for e in range(STRAINS):
        if w.S.free[e] == IMPOSED:
            for i in range(len(n.strains)):
                n.strains[i, e] = w.leg[e] + w.leg[4 + e] * way
    for k in range(len(w.S.ties.course)):
        e = int(w.S.ties.course[k, 0])
        if e >= 0:
            n.ties[GIVEN, k] = w.leg[e] + w.leg[4 + e] * way


@_jit
def through(now: Array, y: Array, z: Array, new: Array, b: float, c: float) -> None:
    """Write the sum of three arrays' numbers, whose weights are 1 - b - c, b and c."""
    p, q, r, n = now.flat, y.flat, z.flat, new.flat
    for i in range(now.size):
        n[i] = (1 - b - c) * p[i] + b * q[i] + (c * r[i] if c != 0.0 else 0.0)


@_jit
def between(w: Walk, x: float, y: float, z: float) -> None:
    """Write a guess of the state after an increment x, on a parabola through states on the way.

    These are the last one, that after y, in ``w.aside``, and that after z, in ``w.trial`` (z = 0: none, on a line).
    """
    n, p, q, s, m = w.now, w.aside, w.trial, w.new, w.counts[0]
    b, c = (x / y, 0.0) if z == 0.0 else (x * (x - z) / (y * (y - z)), x * (x - y) / (z * (z - y)))
    through(n.q, p.q, q.q, s.q, b, c)
    through(n.strains, p.strains, q.strains, s.strains, b, c)
    through(n.ties[LOADS], p.ties[LOADS], q.ties[LOADS], s.ties[LOADS], b, c)
    through(n.F[:m], p.F[:m], q.F[:m], s.F[:m], b, c)
    through(n.s[:m], p.s[:m], q.s[:m], s.s[:m], b, c)
    given(w, x)


@_jit
def weigh(w: Walk, h: float) -> None:
    """Write the weights of the backward difference over an increment."""
    t, weights = w.tally, w.past.weights
    weights[0], weights[1], weights[2] = 1.0, -1.0, 0.0
    if t[tally.FRESH].real >= 1:
        r = h / t[tally.SIZE]
        weights[0], weights[1], weights[2] = (1 + 2 * r) / (1 + r), -(1 + r), r * r / (1 + r)


@_jit
def note(w: Walk, h: float) -> None:
    """Note the increment just solved for, where there is room, so that it can be followed once more.

    ``notes`` begin with the number of all that are written, below 0 where the room did not suffice. Then follow of each
    increment :data:`NOTED` numbers, its contacts (m, 7), motions (N, 6), strains, forces and places (m, 3), and
    the factors of its Jacobian.
    """
    notes, S, st, m = w.notes, w.S, w.new, w.counts[0]
    w.tally[tally.NOTED] = 0.0
    if notes.size == 0 or notes[0] < 0:
        return
    n = laid_out(S, w.con, m, w.J)
    at = int(max(notes[0], 1.0))
    a = at + NOTED
    end = a + m * (w.con.shape[1] + 6) + st.q.size + st.strains.size + stored(w.J, n)
    if end > notes.size:
        notes[0] = -float(at)
        return
    notes[at + NOTED_H], notes[at + NOTED_WHAT], notes[at + NOTED_M], notes[at + NOTED_N] = h, NOTHING, m, n
    a = transfer(w.con[:m], notes, a, True)
    a = transfer(st.q, notes, a, True)
    a = transfer(st.strains, notes, a, True)
    a = transfer(st.F[:m], notes, a, True)
    a = transfer(st.s[:m], notes, a, True)
    jacobian(S, st, w.past, w.con, m, n, w.W, w.J)
    w.J.kept[SOLVED] = n if factor(w.J, n) else 0
    if w.J.kept[SOLVED] == 0:
        notes[at + NOTED_WHAT] = LOST
    exchanged(w.J, n, notes, a, True)
    notes[0], w.tally[tally.NOTED] = end, at


@_jit
def remark(w: Walk, what: int, c: int) -> None:
    """Note what ended the increment that was noted last."""
    at = int(w.tally[tally.NOTED].real)
    if at > 0:
        w.notes[at + NOTED_WHAT], w.notes[at + NOTED_WHICH] = what, c
        copy(w.best, w.notes[at + NOTED_VERTEX : at + NOTED])


@_jit
def keep(w: Walk) -> None:
    """Keep the contacts, to come back to them."""
    copy(w.con, w.kept)
    w.counts[1] = w.counts[0]


@_jit
def restore(w: Walk) -> None:
    """Come back to the contacts that were kept."""
    copy(w.kept, w.con)
    w.counts[0], w.J.kept[0] = w.counts[1], 0
    copy(w.now.F, w.past.F)


@_jit
def number(c: Array) -> int:
    """Return one number for a contact's scale, the other's distance, kind and features."""
    n: int = (((c[touch.FIRST] * 64 + c[touch.APART]) * 5 + c[touch.KIND]) * 4 + c[touch.ONE]) * 4 + c[touch.OTHER]
    return n


@_jit
def strain(st: State, e: int) -> float:
    """Return a strain of the cells, in the mean."""
    whole = 0.0 * st.strains[0, e]
    for i in range(len(st.strains)):
        whole += st.strains[i, e]
    mean_: float = whole / len(st.strains)
    return mean_


@_jit
def tell(w: Walk, events: Array, kind: int, c: int, lost: float) -> None:
    """Write an event.

    Kind, way, strains, the contact's columns, torque, energy lost, contacts, its places, and what touches behind it.
    """
    n = int(w.tally[tally.EVENTS].real)
    if n < len(events):
        row = events[n]
        row[0], row[1] = kind, w.tally[tally.WAY]
        for e in range(STRAINS):
            row[2 + e] = strain(w.now, e)
        for a in range(touch.FIRST, touch.STUCK):
            row[6 + a] = w.con[c, a] if c >= 0 else -1
        row[11], row[12], row[13] = w.loads[1], lost, w.counts[0]
        for a in range(3):
            row[14 + a] = w.now.s[c, a] if c >= 0 else 0.0
        # one that is let go is about to go
        n = AFTER
        for a in range(w.counts[0]):
            if (kind != OPEN or a != c) and n < len(row):
                row[n] = number(w.con[a])
                n += 1
        for a in range(n, len(row)):
            row[a] = -1.0
        w.tally[tally.EVENTS] += 1


@_jit
def tell_gone(w: Walk, events: Array, c: int) -> None:
    """Write into the last event which of the contacts before is gone, and where it was."""
    n = int(w.tally[tally.EVENTS].real) - 1
    if n < len(events):
        for a in range(touch.FIRST, touch.STUCK):
            events[n, 6 + a] = w.kept[c, a]
        for a in range(3):
            events[n, 14 + a] = w.old.s[c, a]

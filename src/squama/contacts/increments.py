"""A path on its way: what is followed, its states, and what is counted and noted along it; compiled."""

from __future__ import annotations

from typing import NamedTuple

from squama.batch.keeping import part as _jit
from squama.contacts.detection import VERTEX
from squama.contacts.jacobian import jacobian
from squama.contacts.linear import SOLVED, Linear, exchanged, factor, laid_out, stored
from squama.contacts.meeting import Work
from squama.contacts.supports import GIVEN, LOADS
from squama.contacts.system import (
    APART,
    FIRST,
    IMPOSED,
    KIND,
    MOTIONS,
    ONE,
    OTHER,
    STRAINS,
    STUCK,
    Past,
    State,
    System,
    copied,
    copy,
)
from squama.types import Array

RANGE, NO_EQUILIBRIUM, SIDE_ENTRY, AT_REST, MANY = range(5)
"""How a path ends: at its last target, without an equilibrium, where a plate comes in from the side, plates that touch
at rest, more contacts than there is room for."""
ENGAGE, OPEN, SLIDE, STICK, CHANGE, SNAP = range(6)
"""What happens on the way."""
CONTACT, EVENT, LINE = 16, 25, 22
"""Columns of a contact, an event and a row that are written."""
AFTER = 17
"""First column of an event that holds a contact that there is behind it, see :func:`number`."""
SCALE = 64 * 5 * 4 * 4
"""How many such numbers there are of a scale."""
(
    T_WAY,
    T_H,
    T_SIZE,
    T_BEFORE,
    T_FRESH,
    T_WORK,
    T_RUBBED,
    T_LOST,
    T_SLID,
    T_SLID_OTHER,
    T_POWER,
    T_POWER2,
    T_LOAD,
    T_LOAD2,
    T_ONSET,
    T_SINCE,
    T_COUNT,
    T_EVENTS,
    T_ZERO,
    T_NOTED,
    T_TRIAL,
    T_JUMPED,
    T_ENERGY,
    T_MOST,
    T_STICK,
    T_GRIPS,
) = range(26)
TALLY = 26
"""What is counted: way; next, last and last but one increments; increments since the last event; work of the loads,
frictional work, energy lost in snaps, length of slip of the first contact of each face; rates of both works at the last
two states; the load where a contact last began to slide; way since which the contacts are these; increments; events;
events without an increment; where the last increment is noted, 0 for nowhere; trial and way of the last jump; elastic
energy, now and at most; contacts that stick, and what their grips took up."""
NOTED_H, NOTED_WHAT, NOTED_WHICH, NOTED_M, NOTED_N, NOTED_VERTEX = range(6)
NOTED = NOTED_VERTEX + VERTEX
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


@_jit
def impose(w: Walk, way: float, st: State) -> None:
    """Write the strains that are imposed at a way along the leg."""
    for e in range(STRAINS):
        given = w.leg[e] + w.leg[4 + e] * way
        if w.S.free[e] == IMPOSED:
            for i in range(len(st.strains)):
                st.strains[i, e] = given
    for k in range(len(w.S.ties.course)):
        e = int(w.S.ties.course[k, 0])
        if e >= 0:
            st.ties[GIVEN, k] = w.leg[e] + w.leg[4 + e] * way


@_jit
def guess(w: Walk, h: float) -> None:
    """Write a guess of the state after an increment: as the last ones went on."""
    t, a, b, c, n = w.tally, w.now, w.old, w.older, w.new
    copied(a, n)
    if t[T_FRESH].real >= 1:
        x = h / t[T_SIZE]
        y = 0.0
        if t[T_FRESH].real >= 2:
            y = h * (h + t[T_SIZE]) / (t[T_SIZE] + t[T_BEFORE])
        for i in range(len(a.q)):
            for o in range(MOTIONS):
                d = a.q[i, o] - b.q[i, o]
                n.q[i, o] += x * d + y * (d / t[T_SIZE] - (b.q[i, o] - c.q[i, o]) / t[T_BEFORE])
        for i in range(len(a.strains)):
            for e in range(STRAINS):
                d = a.strains[i, e] - b.strains[i, e]
                n.strains[i, e] += x * d + y * (d / t[T_SIZE] - (b.strains[i, e] - c.strains[i, e]) / t[T_BEFORE])
        for o in range(a.ties.shape[1]):
            d = a.ties[LOADS, o] - b.ties[LOADS, o]
            n.ties[LOADS, o] += x * d + y * (d / t[T_SIZE] - (b.ties[LOADS, o] - c.ties[LOADS, o]) / t[T_BEFORE])
        for k in range(w.counts[0]):
            for o in range(3):
                d = a.F[k, o] - b.F[k, o]
                n.F[k, o] += x * d + y * (d / t[T_SIZE] - (b.F[k, o] - c.F[k, o]) / t[T_BEFORE])
                d = a.s[k, o] - b.s[k, o]
                n.s[k, o] += x * d + y * (d / t[T_SIZE] - (b.s[k, o] - c.s[k, o]) / t[T_BEFORE])
    impose(w, t[T_WAY] + h, n)


@_jit
def weigh(w: Walk, h: float) -> None:
    """Write the weights of the backward difference over an increment."""
    t, weights = w.tally, w.past.weights
    weights[0], weights[1], weights[2] = 1.0, -1.0, 0.0
    if t[T_FRESH].real >= 1:
        r = h / t[T_SIZE]
        weights[0], weights[1], weights[2] = (1 + 2 * r) / (1 + r), -(1 + r), r * r / (1 + r)


@_jit
def note(w: Walk, h: float) -> None:
    """Note the increment just solved for, where there is room, so that it can be followed once more.

    ``notes`` begin with the number of all that are written, below 0 where the room did not suffice. Then follow of each
    increment :data:`NOTED` numbers, its contacts (m, 7), motions (N, 6), strains, forces and places (m, 3), and
    the factors of its Jacobian.
    """
    notes, S, st, m = w.notes, w.S, w.new, w.counts[0]
    w.tally[T_NOTED] = 0.0
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
    a = put_down(w.con, m, notes, a)
    a = put_down(st.q, len(st.q), notes, a)
    a = put_down(st.strains, len(st.strains), notes, a)
    a = put_down(st.F, m, notes, a)
    a = put_down(st.s, m, notes, a)
    jacobian(S, st, w.past, w.con, m, n, w.W, w.J)
    w.J.kept[SOLVED] = n if factor(w.J, n) else 0
    if w.J.kept[SOLVED] == 0:
        notes[at + NOTED_WHAT] = LOST
    exchanged(w.J, n, notes, a, True)
    notes[0], w.tally[T_NOTED] = end, at


@_jit
def put_down(a: Array, m: int, notes: Array, at: int) -> int:
    """Write the first m rows of an array into the notes; return where they end."""
    for i in range(m):
        for b in range(a.shape[1]):
            notes[at] = a[i, b]
            at += 1
    return at


@_jit
def remark(w: Walk, what: int, c: int) -> None:
    """Note what ended the increment that was noted last."""
    at = int(w.tally[T_NOTED].real)
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
    n: int = (((c[FIRST] * 64 + c[APART]) * 5 + c[KIND]) * 4 + c[ONE]) * 4 + c[OTHER]
    return n


@_jit
def tell_contacts(w: Walk, row: Array, without: int) -> None:
    """Write into an event which contacts there are behind it; -1 for none. One of them may be about to go."""
    n = AFTER
    for c in range(w.counts[0]):
        if c != without and n < len(row):
            row[n] = number(w.con[c])
            n += 1
    for a in range(n, len(row)):
        row[a] = -1.0


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
    n = int(w.tally[T_EVENTS].real)
    if n < len(events):
        row = events[n]
        row[0], row[1] = kind, w.tally[T_WAY]
        for e in range(STRAINS):
            row[2 + e] = strain(w.now, e)
        for a in range(FIRST, STUCK):
            row[6 + a] = w.con[c, a] if c >= 0 else -1
        row[11], row[12], row[13] = w.loads[1], lost, w.counts[0]
        for a in range(3):
            row[14 + a] = w.now.s[c, a] if c >= 0 else 0.0
        tell_contacts(w, row, c if kind == OPEN else -1)
        w.tally[T_EVENTS] += 1


@_jit
def tell_gone(w: Walk, events: Array, c: int) -> None:
    """Write into the last event which of the contacts before is gone, and where it was."""
    n = int(w.tally[T_EVENTS].real) - 1
    if n < len(events):
        for a in range(FIRST, STUCK):
            events[n, 6 + a] = w.kept[c, a]
        for a in range(3):
            events[n, 14 + a] = w.old.s[c, a]

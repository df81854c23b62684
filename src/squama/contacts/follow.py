"""A load path followed increment by increment: contacts come, stick, slip, hand over and go at located events; compiled.

An increment is solved with the contacts of the last state. Where it then violates a condition (a force that pulls, a
place beyond its edge, a gap below zero, a stuck contact outside its cone, an edge that dips) the first such place is
found by a root on the increment, the state there is taken, the contacts change, and the path goes on.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np


from squama.batch.keeping import part as _jit
from squama.contacts.detection import AT, GAP, VERTEX, deepest, edges_of, known, vertices
from squama.contacts.equations import (
    BEFORE,
    F_,
    MARGIN,
    N_,
    V_,
    Work,
    along_edges,
    before,
    clear,
    jacobian,
    inclination,
    meet,
    prepared,
)
from squama.contacts.geometry import PLACED, back, put, vector
from squama.contacts.linear import SOLVED, Linear, exchanged, factor, laid_out, stored
from squama.contacts.newton import solve
from squama.contacts.system import (
    APART,
    BETA,
    EE,
    EF,
    ELASTIC,
    ETA,
    FE,
    FIRST,
    FV,
    H,
    KIND,
    LIES,
    MOTIONS,
    MU,
    ONE,
    OTHER,
    PHI,
    POWERS,
    ENDED,
    STRAINS,
    STUCK,
    VF,
    Past,
    State,
    System,
    copied,
    copy,
    corner_at,
    high,
    lengthwise,
    low,
    partner,
    spots,
)
from squama.contacts.vectors import dot
from squama.types import Array

RANGE, NO_EQUILIBRIUM, SIDE_ENTRY, AT_REST, MANY = range(5)
"""How a path ends: at its last target, without an equilibrium, where a plate comes in from the side, plates that touch
at rest, more contacts than there is room for."""
ENGAGE, OPEN, SLIDE, STICK, CHANGE, SNAP = range(6)
"""What happens on the way."""
PULL, OFF, SLOPE, FLIP, MEET = range(5)
"""What an increment violates."""
CONTACT, EVENT, LINE = 16, 25, 21
"""Columns of a contact, an event and a row that are written."""
AFTER = 17
"""First column of an event that holds a contact that there is behind it, see :func:`number`."""
_TOUCH, _PULL, _PAST, _CONE, _FLAT = 1e-10, 1e-12, 1e-12, 1e-11, 1e-9
"""Gap, force, place, force beyond the cone of friction, and slope by which a condition may be missed."""
_LOCATED = 1e-10
"""Width, rad per pitch, to which an event is located."""
_START, _SOFTLY, _GENTLE, _FREELY = 1 / 16, 1 / 8, 1 / 64, 4.0
"""First increments at engagement, after other events, and at a turn of the path; increments without contact."""
_LEAST, _SHRINK, _EVENTS, _CHANGES, _ZEROS = 1e-8, 0.35, 400, 24, 8
"""Least increment, and by how much one that fails shrinks; events, changes at once and events without an increment, of each
scale, that a path may have."""
_FAR, _SNAPS = 6, 1e-6
"""How many increments, each ten times the last one, an equilibrium is looked for after; least part of the energy that a
snap loses, for it to be one."""
T_WAY, T_H, T_SIZE, T_BEFORE, T_FRESH, T_WORK, T_RUBBED, T_LOST, T_SLID, T_POWER, T_POWER2, T_LOAD, T_LOAD2, T_ONSET, T_SINCE, T_COUNT, T_EVENTS, T_ZERO, T_NOTED, T_TRIAL, T_JUMPED = range(21)
TALLY = 21
"""What is counted: way; next, last and last but one increments; increments since the last event; work of the loads,
frictional work, energy lost in snaps, length of slip; rates of both works at the last two states; the load where a
contact last began to slide; way since which the contacts are these; increments; events; events without an increment; where the last
increment is noted, 0 for nowhere."""
NOTED_H, NOTED_WHAT, NOTED_WHICH, NOTED_M, NOTED_N, NOTED_VERTEX = range(6)
NOTED = NOTED_VERTEX + VERTEX
"""What is noted of an increment first, see :func:`note`: its size; what ended it (-1: nothing), of which contact;
contacts and unknowns; the vertex that came in."""
NOTHING, LOST = -1, 5
"""What ends an increment beside the violations: nothing, and a snap."""


class Walk(NamedTuple):
    """A path on its way: what it follows, three states, contacts now and (``kept``) before a trial, and counters.

    ``notes`` (n,): room for all increments, if any is given, see :func:`note`; ``loads`` (4,) are M, T, B, P; ``count``
    (4,): contacts now, and kept; ``leg`` (8,): strains at way 0 of the leg and their rates; ``best`` the vertex that was
    found last; ``near`` (N, reach): pairs at which is looked.
    """

    S: System
    W: Work
    J: Linear
    now: State
    new: State
    old: State
    older: State
    trial: State
    past: Past
    con: Array
    kept: Array
    stuck: Array
    found: Array
    loads: Array
    count: Array
    leg: Array
    tally: Array
    best: Array
    near: Array
    notes: Array


@_jit
def impose(w: Walk, way: float, st: State) -> None:
    """Write the strains that are imposed at a way along the leg."""
    for e in range(STRAINS):
        if not w.S.free[e] > 0:
            st.strains[e] = w.leg[e] + w.leg[4 + e] * way


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
        for e in range(STRAINS):
            if w.S.free[e] > 0:
                d = a.strains[e] - b.strains[e]
                n.strains[e] += x * d + y * (d / t[T_SIZE] - (b.strains[e] - c.strains[e]) / t[T_BEFORE])
        for k in range(w.count[0]):
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
def unfold(w: Walk, st: State) -> bool:
    """Let the end of an edge with the least gap take over from the edge, which is tangent nowhere; False for none."""
    prepared(w.S, st, w.con, w.count[0], True, w.W)
    for c in range(w.count[0]):
        row = w.con[c]
        if row[KIND] != EF and row[KIND] != FE:
            continue
        side = 0 if row[KIND] == EF else 1
        own = row[ONE] if side == 0 else row[OTHER]
        n, best = vertices(w.S, st, w.W, row[FIRST], row[APART], 5e-3, w.found, 0), -1
        for a in range(n):
            kind = int(w.found[a, KIND])
            p, q = edges_of(kind, int(w.found[a, ONE]), int(w.found[a, OTHER]), side)
            if kind < EF and (p == own or q == own) and (best < 0 or w.found[a, GAP] < w.found[best, GAP]):
                best = a
        if best >= 0:
            v = w.found[best]
            exchange(w, st, c, int(v[KIND]), int(v[ONE]), int(v[OTHER]), v[AT], v[AT + 1], 0.0)
            w.con[c, ENDED] = 1
            return True
    return False


@_jit
def tried(w: Walk, h: float, fresh: bool) -> bool:
    """Solve for the state after an increment; where Newton's method fails all stick at first, or edges end."""
    guess(w, h)
    if solved(w, h, fresh):
        return True
    if w.S.shapes[0, MU] > 0.0 and not fresh and w.count[0] > 0:
        keep_stuck(w, w.con, w.stuck)
        guess(w, h)
        for c in range(w.count[0]):
            w.con[c, STUCK] = 1
        if solved(w, h, True):
            return True
        keep_stuck(w, w.stuck, w.con)
    for _ in range(2):
        guess(w, h)
        if not unfold(w, w.new):
            return False
        if solved(w, h, True):
            return True
    return False


@_jit
def keep_stuck(w: Walk, a: Array, b: Array) -> None:
    """Write which contacts of a list stick into another one."""
    for c in range(w.count[0]):
        b[c, STUCK] = a[c, STUCK]


@_jit
def solved(w: Walk, h: float, fresh: bool) -> bool:
    """Solve for the state after an increment, by its guess; contacts that are new say themselves whether they stick."""
    weigh(w, h)
    m, mu = w.count[0], w.S.shapes[0, MU]
    if not solve(w.S, w.new, w.past, w.con, m, w.W, w.J, w.loads):
        return False
    if not fresh or mu == 0.0:
        return True
    # what would be if they stuck is near what is if they slip
    for _ in range(2 * m + 2):
        changed = False
        for c in range(m):
            if w.con[c, STUCK] > 0 and w.W.told[c, MARGIN] > _CONE:
                w.con[c, STUCK], changed = 0, True
        if not changed and m > 1:
            # others that slip may hold one of them
            for c in range(m):
                if w.con[c, STUCK] == 0 and w.W.told[c, MARGIN] < -_CONE:
                    w.con[c, STUCK], changed = 1, True
        if not changed:
            break
        w.J.kept[0] = 0
        if not solve(w.S, w.new, w.past, w.con, m, w.W, w.J, w.loads) and not sliding(w, h):
            return False
    return True


@_jit
def sliding(w: Walk, h: float) -> bool:
    """Solve for the state after an increment in which all contacts slide, from that without friction."""
    m = w.count[0]
    guess(w, h)
    for c in range(m):
        w.con[c, STUCK] = 0
    w.past.weights[0], w.J.kept[0] = 0.0, 0
    found = solve(w.S, w.new, w.past, w.con, m, w.W, w.J, w.loads)
    weigh(w, h)
    w.J.kept[0] = 0
    return found and solve(w.S, w.new, w.past, w.con, m, w.W, w.J, w.loads)


@_jit
def beyond(S: System, st: State, c: Array, k: int) -> tuple[float, int]:
    """Return how far inside its edges or face a contact is (below 0: outside), and where it would leave: 0 to 5.

    By twos the ends of its first place, of its second one, and of an edge that lies along a face.
    """
    kind, i, j, s = c[KIND], c[FIRST], partner(S, c), st.s[k]
    least, which = 1e9 + 0.0 * s[0], 0
    if kind == LIES:
        return least, which
    if kind == EE:
        l0, h0, l1, h1 = low(S, i, c[ONE]), high(S, i, c[ONE]), low(S, j, c[OTHER]), high(S, j, c[OTHER])
    else:
        face = j if kind == VF or kind == EF else i
        l0, h0, l1, h1 = 0.0 * S.shapes[face, ETA], S.shapes[face, ETA], -S.shapes[face, BETA], S.shapes[face, BETA]
    for a, v in enumerate((s[0] - l0, h0 - s[0], s[1] - l1, h1 - s[1])):
        if v.real < least.real:
            least, which = v, a
    if kind >= EF:
        own, e = (i, c[ONE]) if kind == EF else (j, c[OTHER])
        for a, v in enumerate((s[2] - low(S, own, e), high(S, own, e) - s[2])):
            if v.real < least.real:
                least, which = v, 4 + a
    return least, which


@_jit
def dips(w: Walk, st: State, k: int) -> tuple[float, int]:
    """Return the least slope of the gap inwards along the edges of a contact, and the edge (+ 4: of the other scale).

    Below 0 the edge lies deeper beside the contact than there; only of bent plates.
    """
    S, c = w.S, w.con[k]
    i, j, kind = c[FIRST], partner(S, c), c[KIND]
    if kind >= EF or c[ENDED] > 0 or not (S.shapes[i, ELASTIC].real > 0 or S.shapes[j, ELASTIC].real > 0):
        return 1e9 + 0.0 * st.s[k, 0], -1
    g = meet(S, st, c, st.s[k], w.W)
    n1 = (g.tx1[1] * g.ty1[2] - g.tx1[2] * g.ty1[1], g.tx1[2] * g.ty1[0] - g.tx1[0] * g.ty1[2], g.tx1[0] * g.ty1[1] - g.tx1[1] * g.ty1[0])
    n2 = (g.tx2[1] * g.ty2[2] - g.tx2[2] * g.ty2[1], g.tx2[2] * g.ty2[0] - g.tx2[0] * g.ty2[2], g.tx2[0] * g.ty2[1] - g.tx2[1] * g.ty2[0])
    P, E1, E2 = w.W.pairs[i, c[APART] - 1], w.W.E[i], w.W.E[j]
    if kind == EE:
        t1, t2 = along_edges(c, g)
        inner = back(E2, back(P, t1))
        v = inner[1] if lengthwise(c[OTHER]) else inner[0]
        first = dot(t1, n2) * (1.0 if v.real > 0 else -1.0) * (1.0 if c[OTHER] == 1 or c[OTHER] == 3 else -1.0)
        inner = back(E1, t2)
        v = inner[1] if lengthwise(c[ONE]) else inner[0]
        second = -dot(t2, n1) * (1.0 if v.real > 0 else -1.0) * (1.0 if c[ONE] == 1 or c[ONE] == 3 else -1.0)
        return (first, c[ONE]) if first.real <= second.real else (second, 4 + c[OTHER])
    v = c[ONE] if kind == VF else c[OTHER]
    sy, sx = (1.0 if v % 2 == 0 else -1.0), (-1.0 if v < 2 else 1.0)
    if kind == VF:
        a, b = sy * dot(g.ty1, n2), sx * dot(g.tx1, n2)
    else:
        a, b = -sy * dot(g.ty2, n1), -sx * dot(g.tx2, n1)
    end, side = (0 if v < 2 else 3), (1 if v % 2 == 0 else 2)
    o = 0 if kind == VF else 4
    return (a, o + end) if a.real <= b.real else (b, o + side)


@_jit
def condition(w: Walk, st: State, what: int, c: int) -> float:
    """Return the value of a contact's condition at a state that was just solved for; below 0 it is violated."""
    if what == PULL:
        return w.W.told[c, N_]
    if what == OFF:
        return beyond(w.S, st, w.con[c], c)[0]
    if what == SLOPE:
        return dips(w, st, c)[0]
    margin: float = w.W.told[c, MARGIN]
    return -margin if w.con[c, STUCK] > 0 else margin


@_jit
def value(w: Walk, st: State, what: int, c: int) -> float:
    """Return the value of any condition at a state that was just solved for; below 0 it is violated."""
    if what != MEET:
        return condition(w, st, what, c)
    if w.best[KIND] == LIES:
        return inclination(w.S, int(w.best[FIRST]), w.W)
    # a vertex of the overlap, if it is there
    n = vertices(w.S, st, w.W, int(w.best[FIRST]), int(w.best[APART]), 1e9, w.found, 0)
    for a in range(n):
        if w.found[a, KIND] == w.best[KIND] and w.found[a, ONE] == w.best[ONE] and w.found[a, OTHER] == w.best[OTHER]:
            gap: float = w.found[a, GAP]
            return gap
    return math.nan


@_jit
def violated(w: Walk, st: State, every: bool) -> tuple[int, int, float]:
    """Return what the state just solved for violates most, of which contact, and by how much; -1 where nothing is.

    New contacts are looked for between all scales, or, not ``every``, where that found them before.
    """
    m, mu = w.count[0], w.S.shapes[0, MU]
    what, which, worst = -1, -1, 0.0
    for c in range(m):
        v = w.W.told[c, N_]
        if v < -_PULL and v < worst:
            what, which, worst = PULL, c, v
    if what >= 0:
        return what, which, worst
    for c in range(m):
        v, _ = beyond(w.S, st, w.con[c], c)
        if v < -_PAST and v < worst:
            what, which, worst = OFF, c, v
        v, _ = dips(w, st, c)
        if v < -_FLAT and v < worst:
            what, which, worst = SLOPE, c, v
        if mu > 0.0:
            margin = w.W.told[c, MARGIN]
            v = -margin if w.con[c, STUCK] > 0 else margin
            if v < -_CONE and v < worst:
                what, which, worst = FLIP, c, v
    if what >= 0:
        return what, which, worst
    a = deepest(w.S, st, w.con, m, w.W, -_TOUCH, w.near, every, w.found)
    if a >= 0:
        copy(w.found[a], w.best)
        return MEET, -1, w.found[a, GAP]
    return lain(w)


@_jit
def lain(w: Walk) -> tuple[int, int, float]:
    """Return as :func:`violated` a scale that would be turned into the substrate, the farthest of them."""
    worst, which = -_TOUCH, -1
    for i in range(len(w.S.rests)):
        theta = inclination(w.S, i, w.W)
        if theta < worst and not lying(w, i):
            worst, which = theta, i
    if which < 0:
        return -1, -1, 0.0
    for a in range(VERTEX):
        w.best[a] = 0.0
    w.best[FIRST], w.best[KIND], w.best[GAP] = which, LIES, worst
    return MEET, -1, worst


@_jit
def lying(w: Walk, i: int) -> bool:
    """Say whether a scale lies on the substrate."""
    for c in range(w.count[0]):
        if w.con[c, KIND] == LIES and w.con[c, FIRST] == i:
            return True
    return False


@_jit
def sideways(w: Walk, gap: float) -> bool:
    """Say whether a vertex that was just found is as deep as only one that came in from the side."""
    return w.best[KIND] != LIES and gap < -0.3 * w.S.shapes[0, H] - 5e-3


@_jit
def accept(w: Walk, h: float, event: bool) -> None:
    """Make the new state the last one, after an increment; ``event``: rates change here."""
    t, S = w.tally, w.S
    power, load = 0.0, 0.0
    for c in range(w.count[0]):
        # slip per way
        power += w.W.told[c, F_] * (0.0 if w.con[c, STUCK] > 0 else w.W.told[c, V_] / h)
    for e in range(STRAINS):
        if not S.free[e] > 0:
            load += w.loads[e] * w.leg[4 + e]
    share = h / t[T_SIZE] if t[T_FRESH].real >= 1 else 0.0 * h
    if t[T_FRESH].real >= 1:
        t[T_RUBBED] += h * mean(t[T_POWER2], t[T_POWER], power, share)
    else:
        # forces may turn at once behind an event
        for c in range(w.count[0]):
            if w.con[c, STUCK] == 0:
                t[T_RUBBED] += w.W.told[c, V_] * (w.W.told[c, F_] + w.W.told[c, BEFORE]) / 2
    t[T_WORK] += h * mean(t[T_LOAD2], t[T_LOAD], load, share) if t[T_FRESH].real >= 1 else h * (t[T_LOAD] + load) / 2
    t[T_POWER2], t[T_LOAD2] = t[T_POWER], t[T_LOAD]
    if t[T_FRESH].real < 1:
        t[T_POWER2] = power
    t[T_POWER], t[T_LOAD] = power, load
    if w.count[0] > 0 and w.con[0, STUCK] == 0:
        D = before(S, w.con[0], w.new.s[0], w.past, 0)[0]
        t[T_SLID] += np.sqrt(dot(D, D))
    copied(w.old, w.older)
    copied(w.now, w.old)
    copied(w.new, w.now)
    remember(w)
    t[T_WAY] += h
    t[T_BEFORE], t[T_SIZE] = t[T_SIZE], h
    t[T_FRESH] = 0.0 if event else t[T_FRESH] + 1
    t[T_COUNT] += 1


@_jit
def note(w: Walk, h: float) -> None:
    """Note the increment just solved for, where there is room, so that it can be followed once more.

    ``notes`` begin with the number of all that are written, below 0 where the room did not suffice. Then follow of each
    increment :data:`NOTED` numbers, its contacts (m, 7), motions (N, 6), strains (4,), forces and places (m, 3), and the
    factors of its Jacobian.
    """
    notes, S, st, m = w.notes, w.S, w.new, w.count[0]
    w.tally[T_NOTED] = 0.0
    if notes.size == 0 or notes[0] < 0:
        return
    n = laid_out(S, w.con, m, w.J)
    at = int(max(notes[0], 1.0))
    a = at + NOTED
    end = a + m * (w.con.shape[1] + 6) + st.q.size + STRAINS + stored(w.J, n)
    if end > notes.size:
        notes[0] = -float(at)
        return
    notes[at + NOTED_H], notes[at + NOTED_WHAT], notes[at + NOTED_M], notes[at + NOTED_N] = h, NOTHING, m, n
    a = put_down(w.con, m, notes, a)
    a = put_down(st.q, len(st.q), notes, a)
    for e in range(STRAINS):
        notes[a + e] = st.strains[e]
    a = put_down(st.F, m, notes, a + STRAINS)
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
def mean(a: float, b: float, c: float, ratio: float) -> float:
    """Return the mean from b to c of a parabola through a, b and c; ``ratio``: of the last interval to the first."""
    return (b + c) / 2 - (c - b - ratio * (b - a)) / 6 * ratio / (1 + ratio)


@_jit
def remember(w: Walk) -> None:
    """Write the state just solved for as the last one before the next increment."""
    N, past, W = len(w.S.shapes), w.past, w.W
    copy(past.E[0], past.E[1])
    copy(past.b[0], past.b[1])
    copy(past.pairs[0], past.pairs[1])
    copy(W.E, past.E[0])
    copy(w.now.b, past.b[0])
    for i in range(N):
        for k in range(w.S.reach):
            for a in range(PLACED):
                past.pairs[0, i, k, a] = W.pairs[i, k, a]
    copy(w.now.F, past.F)


@_jit
def drop(w: Walk, st: State, c: int) -> None:
    """Take a contact out."""
    m = w.count[0] - 1
    for a in range(c, m):
        copy(w.con[a + 1], w.con[a])
        copy(st.F[a + 1], st.F[a])
        copy(st.s[a + 1], st.s[a])
        copy(w.past.F[a + 1], w.past.F[a])
        copy(w.W.told[a + 1], w.W.told[a])
    w.count[0], w.J.kept[0] = m, 0


@_jit
def add_contact(w: Walk, st: State, row: Array) -> bool:
    """Take a vertex in as a contact without a force; False where there is no room."""
    m = w.count[0]
    if m == len(w.con):
        return False
    for a in range(FIRST, STUCK):
        w.con[m, a] = int(row[a])
    w.con[m, STUCK], w.con[m, ENDED] = 1 if w.S.shapes[0, MU].real > 0.0 else 0, 0
    for a in range(3):
        st.F[m, a] = w.past.F[m, a] = 0.0
        st.s[m, a] = row[AT + a]
    w.count[0], w.J.kept[0] = m + 1, 0
    return True


@_jit
def exchange(w: Walk, st: State, c: int, kind: int, one: int, other: int, a: float, b: float, d: float) -> None:
    """Make a contact one of other features at the same place; its force stays."""
    w.con[c, KIND], w.con[c, ONE], w.con[c, OTHER] = kind, one, other
    st.s[c, 0], st.s[c, 1], st.s[c, 2] = a, b, d
    w.J.kept[0] = 0


@_jit
def roll(w: Walk, st: State, c: int, edge: int) -> None:
    """Let the edge that dips beside a contact lie along the face there (+ 4: an edge of the other scale)."""
    S, row = w.S, w.con[c]
    x1, y1, x2, y2 = spots(S, row, st.s[c])
    if edge < 4:
        exchange(w, st, c, EF, edge, edge, x2, y2, x1 if lengthwise(edge) else y1)
    else:
        exchange(w, st, c, FE, edge - 4, edge - 4, x1, y1, x2 if lengthwise(edge - 4) else y2)


@_jit
def leave(w: Walk, st: State, c: int, which: int) -> bool:
    """Hand an edge along a face over to its corner, or to the face's edge; False where that is not continuous."""
    row, s = w.con[c], st.s[c]
    kind = row[KIND]
    if kind < EF:
        return False
    own = row[ONE] if kind == EF else row[OTHER]
    if which >= 4:
        v = corner_at(own, which == 5)
        if kind == EF:
            exchange(w, st, c, VF, v, 0, s[0], s[1], 0.0)
        else:
            exchange(w, st, c, FV, 0, v, s[0], s[1], 0.0)
        return True
    edge = 3 if which == 0 else (0 if which == 1 else (1 if which == 2 else 2))
    at = s[1] if which < 2 else s[0]
    if kind == EF:
        exchange(w, st, c, EE, own, edge, s[2], at, 0.0)
    else:
        exchange(w, st, c, EE, edge, own, at, s[2], 0.0)
    return True


@_jit
def succeed(w: Walk, st: State, c: int) -> bool:
    """Let a vertex at the same place take the force of a contact that left its edge; False where there is none."""
    S, row = w.S, w.con[c]
    i, apart, kind, one, other = row[FIRST], row[APART], row[KIND], row[ONE], row[OTHER]
    x1, y1, x2, y2 = spots(S, row, st.s[c])
    F = vector(st.F[c], 0)
    drop(w, st, c)
    n = vertices(S, st, w.W, i, apart, 1e-3, w.found, 0)
    best, least, k = -1, 0.1, w.W.vertex
    for a in range(n):
        # what it is gets into k
        if known(S, st, w.con, w.count[0], w.found[a], k) or (k[KIND] == kind and k[ONE] == one and k[OTHER] == other):
            continue
        X1, Y1, X2, Y2 = spots(S, k, w.found[a, AT:])
        far = abs(X1 - x1) + abs(Y1 - y1) + abs(X2 - x2) + abs(Y2 - y2)
        if far < least:
            best, least = a, far
    if best < 0 or not add_contact(w, st, w.found[best]):
        return False
    put(F, st.F[w.count[0] - 1], 0)
    return True


@_jit
def energy(w: Walk, st: State) -> float:
    """Return the elastic energy of joints, bar and plates."""
    S, out = w.S, 0.0 * w.S.K[0, 0, 0]
    for i in range(len(S.shapes)):
        K, q, e = S.K[i], st.q[i], st.strains
        for a in range(MOTIONS + STRAINS):
            z = q[a] if a < MOTIONS else e[a - MOTIONS]
            for b in range(MOTIONS + STRAINS):
                out += z * K[a, b] * (q[b] if b < MOTIONS else e[b - MOTIONS]) / 2
        if S.shapes[i, ELASTIC].real > 0:
            for a in range(POWERS):
                out += st.b[i, a] * w.W.load[i, a] / 2
    return out


@_jit
def keep(w: Walk) -> None:
    """Keep the contacts, to come back to them."""
    copy(w.con, w.kept)
    w.count[1] = w.count[0]


@_jit
def restore(w: Walk) -> None:
    """Come back to the contacts that were kept."""
    copy(w.kept, w.con)
    w.count[0], w.J.kept[0] = w.count[1], 0
    copy(w.now.F, w.past.F)


@_jit
def give(w: Walk, st: State, what: int, c: int) -> None:
    """Take out a contact that violates a condition, or let another one take its place."""
    if what == PULL:
        drop(w, st, c)
    elif what == SLOPE:
        roll(w, st, c, dips(w, st, c)[1])
    elif what == FLIP:
        w.con[c, STUCK] = 1 - w.con[c, STUCK]
        w.J.kept[0] = 0
    elif not leave(w, st, c, beyond(w.S, st, w.con[c], c)[1]):
        succeed(w, st, c)


@_jit
def missed(w: Walk, st: State, what: int, c: int) -> bool:
    """Say whether a contact violates a condition at a state that was just solved for."""
    if what == PULL:
        return w.W.told[c, N_].real < -_PULL / 2
    if what == FLIP:
        margin = w.W.told[c, MARGIN].real
        return (-margin if w.con[c, STUCK] > 0 else margin) < -_CONE / 2
    if what == SLOPE:
        return dips(w, st, c)[0].real < -_FLAT / 2
    return beyond(w.S, st, w.con[c], c)[0].real < -_PAST / 2


@_jit
def regroup(w: Walk, h: float) -> int:
    """Look for any equilibrium after an increment: contacts come and go until all conditions hold; 0 if they do."""
    lost = False
    ends = 0
    for _ in range(_CHANGES * len(w.S.shapes)):
        copied(w.new, w.trial)
        if not solved(w, h, True):
            copied(w.trial, w.new)
            ends += 1
            if ends > 3 or not unfold(w, w.new):
                return NO_EQUILIBRIUM
            continue
        what, c, v = violated(w, w.new, True)
        if what < 0:
            return 0
        if what != MEET:
            scale = w.con[c, FIRST]
            give(w, w.new, what, c)
            for o in range(w.count[0] - 1, -1, -1):
                if len(w.S.shapes) > 1 and w.con[o, FIRST] != scale and missed(w, w.new, what, o):
                    give(w, w.new, what, o)
        else:
            if sideways(w, v):
                return SIDE_ENTRY
            if not add_contact(w, w.new, w.best):
                return MANY
    return NO_EQUILIBRIUM


@_jit
def number(c: Array) -> int:
    """Return one number for a contact's scale, the other's distance, kind and features."""
    n: int = (((c[FIRST] * 64 + c[APART]) * 5 + c[KIND]) * 4 + c[ONE]) * 4 + c[OTHER]
    return n


@_jit
def tell_contacts(w: Walk, row: Array, without: int) -> None:
    """Write into an event which contacts there are behind it; -1 for none. One of them may be about to go."""
    n = AFTER
    for c in range(w.count[0]):
        if c != without and n < len(row):
            row[n] = number(w.con[c])
            n += 1
    for a in range(n, len(row)):
        row[a] = -1.0


@_jit
def tell(w: Walk, events: Array, kind: int, c: int, lost: float) -> None:
    """Write an event: kind, way, strains, the contact's columns, torque, energy lost, contacts, its places, and what
    touches behind it.
    """
    n = int(w.tally[T_EVENTS].real)
    if n < len(events):
        row = events[n]
        row[0], row[1] = kind, w.tally[T_WAY]
        for e in range(STRAINS):
            row[2 + e] = w.now.strains[e]
        for a in range(FIRST, STUCK):
            row[6 + a] = w.con[c, a] if c >= 0 else -1
        row[11], row[12], row[13] = w.loads[1], lost, w.count[0]
        for a in range(3):
            row[14 + a] = w.now.s[c, a] if c >= 0 else 0.0
        tell_contacts(w, row, c if kind == OPEN else -1)
        w.tally[T_EVENTS] += 1


@_jit
def change(w: Walk, what: int, c: int, events: Array, step: float) -> bool:
    """Change the contacts at an event, at the last state; False where the path does not go on continuously."""
    t = w.tally
    remark(w, what, c)
    if what == PULL:
        tell(w, events, OPEN, c, 0.0)
        drop(w, w.now, c)
    elif what == FLIP:
        w.con[c, STUCK] = 1 - w.con[c, STUCK]
        w.J.kept[0] = 0
        tell(w, events, STICK if w.con[c, STUCK] > 0 else SLIDE, c, 0.0)
        if w.con[c, STUCK] == 0:
            t[T_ONSET] = t[T_LOAD]
    elif what == SLOPE:
        roll(w, w.now, c, dips(w, w.now, c)[1])
        tell(w, events, CHANGE, c, 0.0)
    elif what == OFF:
        if not leave(w, w.now, c, beyond(w.S, w.now, w.con[c], c)[1]):
            return False
        tell(w, events, CHANGE, c, 0.0)
    else:
        if not add_contact(w, w.now, w.best):
            return False
        tell(w, events, ENGAGE, w.count[0] - 1, 0.0)
    t[T_SINCE] = t[T_WAY]
    return True


@_jit
def closed(w: Walk, low_: float, up: float, fresh: bool) -> float:
    """Return the increment after which the gap that closes is zero, by those after two around it."""
    if low_ == 0.0 or not tried(w, low_, fresh):
        return up
    a = value(w, w.new, MEET, -1)
    if not tried(w, up, fresh):
        return up
    b = value(w, w.new, MEET, -1)
    return max(low_ + (up - low_) * a / (a - b), low_ / 2) if a > b else up


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
        if up < 0.0 or deepest(w.S, w.new, w.con, w.count[0], w.W, -_TOUCH, w.near, True, w.found) < 0:
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


@_jit
def bisected(w: Walk, h: float, fresh: bool, what: int, c: int, high_value: float) -> tuple[float, int, int]:
    """Find as :func:`locate`, where new contacts are looked for between pairs that are marked."""
    low_, up, vl, vu, last = 0.0, h, math.nan, high_value, 0
    for count in range(80):
        if up - low_ < _LOCATED:
            break
        x = (low_ + up) / 2
        if vl > 0.0 and vu < 0.0 and count % 4 != 3:
            x = low_ + (up - low_) * vl / (vl - vu)
            x = min(max(x, low_ + 0.3 * _LOCATED), up - 0.3 * _LOCATED)
        if not tried(w, x, fresh):
            up, vu = x, math.nan
            continue
        w2, c2, v2 = violated(w, w.new, False)
        if w2 < 0:
            low_ = x
            vl = value(w, w.new, what, c)
            if last == 1:
                vu /= 2
            last = 1
        else:
            if w2 != what or (c2 != c and c2 >= 0):
                what, c, vl = w2, c2, math.nan
            up, vu = x, v2
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


@_jit
def jump(w: Walk, events: Array, step: float) -> int:
    """Go on from where the path is not continuous: to an equilibrium a little further, with the energy it loses."""
    t = w.tally
    before = energy_now(w)
    # where it stops again at once an equilibrium farther off is looked for
    begin = int(t[T_TRIAL].real) + 1 if 0.0 < t[T_JUMPED].real > t[T_WAY].real - step / 4 else 0
    keep(w)
    code = NO_EQUILIBRIUM
    for trial in range(min(begin, _FAR), _FAR):
        h = 1e-7 * 10.0**trial if trial < _FAR - 1 else step
        for way in range(2):
            restore(w)
            t[T_FRESH] = 0.0
            guess(w, h)
            if way == 1:
                # from the state without any contact
                w.count[0], w.J.kept[0] = 0, 0
            found = regroup(w, h)
            code = found if trial == begin and way == 0 else code
            if found == 0:
                after = energy(w, w.new)
                rubbed, slid = t[T_RUBBED], t[T_SLID]
                note(w, h)
                remark(w, LOST, -1)
                accept(w, h, True)
                # what is rubbed in a snap is a part of what it loses
                t[T_RUBBED], t[T_SLID] = rubbed, slid
                lost = before + h * t[T_LOAD] - after
                c = 0 if w.count[0] > 0 else -1
                if lost > _SNAPS * before:
                    t[T_LOST] += lost
                    tell(w, events, SNAP, c, lost)
                else:
                    tell(w, events, CHANGE, c, 0.0)
                t[T_TRIAL], t[T_JUMPED] = trial, t[T_WAY]
                t[T_SINCE], t[T_H] = t[T_WAY], step * _SOFTLY
                return 0
    restore(w)
    return code


@_jit
def energy_now(w: Walk) -> float:
    """Return the elastic energy of the last state."""
    prepared(w.S, w.now, w.con, w.count[0], True, w.W)
    return energy(w, w.now)


@_jit
def advance(w: Walk, goal: float, step: float, events: Array) -> int:
    """Go on towards a way by one increment; return why not, 0 if it went on."""
    t, m, N = w.tally, w.count[0], len(w.S.shapes)
    left = goal - t[T_WAY]
    most = step * _FREELY if m == 0 else step
    h = min(t[T_H], most)
    h = left / math.ceil(left / h * (1 - 1e-9))
    fresh = t[T_FRESH] < 1 and t[T_ZERO] >= 0
    for c in range(m):
        w.con[c, ENDED] = 0
    keep(w)
    while True:
        if not tried(w, h, fresh):
            restore(w)
            h *= _SHRINK
            if h < _LEAST:
                return jump(w, events, step)
            continue
        clear(w.near)
        what, c, v = violated(w, w.new, True)
        if what < 0:
            note(w, h)
            accept(w, h, False)
            t[T_H], t[T_ZERO] = min(most, 2 * h), 0.0
            return 0
        if what != MEET:
            deepest(w.S, w.new, w.con, m, w.W, -_TOUCH, w.near, True, w.found)
        where, what, c = locate(w, h, fresh, what, c, v)
        if where < 0.0:
            restore(w)
            h *= _SHRINK
            if h < _LEAST:
                return jump(w, events, step)
            continue
        break
    if what == MEET and sideways(w, v) and w.best[GAP] < -1e-3:
        return SIDE_ENTRY
    note(w, where)
    if what < 0:
        accept(w, where, False)
        t[T_H], t[T_ZERO] = min(most, 2 * where), 0.0
        return 0
    accept(w, where, True)
    scale = int(w.best[FIRST]) if what == MEET else int(w.con[c, FIRST])
    t[T_ZERO] = t[T_ZERO] + 1 if where < 10 * _LOCATED else 0.0
    t[T_H] = step * (_START if m == 0 else _SOFTLY)
    zeros = (2 if what == FLIP else _ZEROS) + N - 1
    if t[T_ZERO] > zeros or t[T_EVENTS] > _EVENTS * N or not change(w, what, c, events, step):
        t[T_ZERO] = 0.0
        return jump(w, events, step)
    together(w, what, scale, events, step)
    return 0


@_jit
def together(w: Walk, what: int, scale: int, events: Array, step: float) -> None:
    """Change the contacts of other scales at which the same happens where an event was located on one scale."""
    if len(w.S.shapes) == 1:
        return
    if what == MEET and w.best[KIND] == LIES:
        for i in range(len(w.S.rests)):
            if i != scale and abs(inclination(w.S, i, w.W)) < _TOUCH and not lying(w, i):
                w.best[FIRST] = i
                change(w, what, -1, events, step)
        return
    if what == MEET:
        clear(w.near)
        while True:
            a = deepest(w.S, w.now, w.con, w.count[0], w.W, _TOUCH, w.near, True, w.found)
            if a < 0 or int(w.found[a, FIRST]) == scale:
                return
            copy(w.found[a], w.best)
            if not change(w, what, -1, events, step):
                return
    for c in range(w.count[0] - 1, -1, -1):
        if w.con[c, FIRST] != scale and missed(w, w.now, what, c):
            change(w, what, c, events, step)


@_jit
def write(w: Walk, row: Array, contacts: Array) -> None:
    """Write the last state: way, strains, loads, works, contacts and what is told of them, energy, work per way."""
    t, S = w.tally, w.S
    row[0] = t[T_WAY]
    for e in range(STRAINS):
        row[1 + e], row[5 + e] = w.now.strains[e], w.loads[e]
    m, mode, N, f = w.count[0], 0, 0.0, 0.0
    for c in range(m):
        if w.con[c, KIND] == LIES:
            continue
        N += w.W.told[c, N_]
        f += w.W.told[c, F_]
        if c == 0 or w.con[c, STUCK] == 0:
            mode = 2 if w.con[c, STUCK] > 0 else 1
    row[9], row[10], row[11], row[12], row[13], row[14], row[15] = t[T_WORK], t[T_RUBBED], t[T_LOST], m, mode, N, f
    row[16], row[17], row[18], row[19] = t[T_SLID], t[T_ONSET], t[T_SINCE], energy(w, w.now)
    row[20] = t[T_LOAD]
    for c in range(min(m, len(contacts))):
        out = contacts[c]
        for a in range(ENDED):
            out[a] = w.con[c, a]
        if w.con[c, KIND] != LIES:
            out[6], out[7], out[8], out[9] = spots(S, w.con[c], w.now.s[c])
        for a in range(3):
            out[10 + a] = w.now.F[c, a]
        out[13], out[14], out[15] = w.W.told[c, N_], w.W.told[c, F_], w.now.s[c, 2]


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
        if not w.S.free[e] > 0:
            load += w.loads[e] * leg[4 + e]
    if not straight:
        t[T_FRESH], t[T_ONSET], t[T_LOAD], t[T_POWER] = 0.0, load, load, 0.0
        t[T_H] = step if w.count[0] == 0 else step * _GENTLE
        if w.S.shapes[0, MU].real > 0.0:
            for c in range(w.count[0]):
                w.con[c, STUCK] = 1
            # where they slide again is located
            t[T_ZERO] = -1.0
        w.J.kept[0] = 0


@_jit
def follow(
    w: Walk, ways: Array, corners: Array, most: float, step: float, rows: Array, motions: Array, bends: Array,
    contacts: Array, events: Array, end: Array,
) -> None:  # fmt: skip
    """Follow a beam from rest along straight legs to corners (n, 4) in the strains, at rising ways (n,).

    Where nothing touches up to there, that is looked for straight on to the way ``most``.

    Written are ``rows`` (n, 21), ``motions`` (n, N, 6), ``bends`` (n, N, 24), ``contacts`` (n, C, 16), ``events``
    (E, 25), and ``end`` (4,): why, way, events, rows.
    """
    t = w.tally
    t[T_H], t[T_SIZE], t[T_BEFORE] = step, step, step
    code = RANGE
    done = 0
    prepared(w.S, w.now, w.con, 0, True, w.W)
    weigh(w, step)
    solve(w.S, w.now, w.past, w.con, 0, w.W, w.J, w.loads)
    if deepest(w.S, w.now, w.con, 0, w.W, -1e-9, w.near, True, w.found) >= 0:
        code = AT_REST
    remember(w)
    remember(w)
    for i in range(len(ways)):
        if code != RANGE:
            break
        begin = ways[i - 1] if i > 0 else 0.0
        if ways[i] > begin:
            set_out(w, corners, ways, i, step)
        guard = 0
        while code == RANGE and t[T_WAY] < ways[i] - 1e-13:
            code = advance(w, ways[i], step, events)
            guard += 1
            if guard > 100000:
                code = NO_EQUILIBRIUM
        if code == RANGE:
            # what is told of contacts is that of the state solved for last
            write(w, rows[i], contacts[i])
            copy(w.now.q, motions[i])
            copy(w.now.b, bends[i])
            done += 1
    end[0], end[1] = code, t[T_WAY]
    while code == RANGE and t[T_EVENTS] == 0 and t[T_WAY] < most - 1e-13:
        if len(ways) == 0 and t[T_WAY] == 0.0:
            # twisted alone
            w.leg[4 + PHI] = 1.0
        if advance(w, most, step, events) != RANGE:
            break
    end[2], end[3] = t[T_EVENTS], done

"""Work and energy of increments: work of the loads, stored energy, frictional work; compiled.

The difference is either reported as the loss of a snap or measures the error of the increments.
"""

from __future__ import annotations

import numpy as np

from squama.batch.keeping import part as _jit
from squama.contacts import tally, touch
from squama.contacts.geometry import PLACED, vector
from squama.contacts.increments import Walk
from squama.contacts.meeting import before, meet, prepared
from squama.contacts.system import (
    CHI,
    ELASTIC,
    FREE,
    MOTIONS,
    MU,
    PHI,
    POWERS,
    STRAINS,
    TILT,
    State,
    cells,
    copied,
    copy,
    row_of,
)
from squama.contacts.vectors import Vector, add, dot

UNBALANCED, INEXACT = 3e-4, 1e-3
"""Unbalanced work over the energy above which an increment has left its branch; unbalanced work over the largest energy
so far, per rad per pitch, that a path may lose.
"""
SNAPS = 1e-6
"""Least part of the energy that a snap loses, for it to be one."""
_SMALL = 1e-4
"""Motions, in pitches and rad, whose energy counts as rounding."""
_UNEQUAL = 1e-9
"""Motions (pitches, rad) and strains that differ left and right up to which scales straight across the bar are taken
for symmetric."""


@_jit
def mean(a: float, b: float, c: float, ratio: float) -> float:
    """Return the mean from b to c of a parabola through a, b and c; ``ratio``: last interval over the first one."""
    return (b + c) / 2 - (c - b - ratio * (b - a)) / 6 * ratio / (1 + ratio)


@_jit
def load_rate(w: Walk) -> float:
    """Return the work of the loads per way, of one cell, at the state just solved for."""
    load: float = 0.0 * w.loads[0]
    for e in range(STRAINS):
        if w.S.free[e] != FREE:
            load += w.loads[e] * w.leg[4 + e]
    return load


@_jit
def tangential(F: Vector, n: Vector) -> Vector:
    """Return the part of F orthogonal to the unit vector n."""
    return add(F, -dot(F, n), n)


@_jit
def power(w: Walk, c: int, h: float) -> float:
    """Return the frictional work per way of a sliding contact, at the end of the increment just solved for.

    Its slip is that of its present material places, over as many states as there are since the last event.
    """
    t, row, s = w.tally, w.con[c], w.new.s[c]
    f = tangential(vector(w.new.F[c], 0), meet(w.S, w.new, row, s, w.W).n)
    a, b = h, h + t[tally.SIZE]
    slip = dot(f, before(w.S, row, s, w.past, 0)[0])
    rate: float = slip / a
    if t[tally.FRESH].real >= 1:
        second = dot(f, before(w.S, row, s, w.past, 1)[0])
        rate = (slip * b / a - second * a / b) / (b - a)
    if t[tally.FRESH].real >= 2:
        d = b + t[tally.BEFORE]
        third = dot(f, before(w.S, row, s, w.past, 2)[0])
        # derivative of the polynomial of third degree
        rate = (
            slip * b * d / (a * (b - a) * (d - a))
            - second * a * d / (b * (b - a) * (d - b))
            + third * a * b / (d * (d - a) * (d - b))
        )
    return rate


@_jit
def slid(w: Walk, c: int) -> float:
    """Return the frictional work of a contact over the increment just solved for, from mean force and mean slip.

    The slip is the mean of those at its last and at its present material places; only the latter where an edge has come
    to its end.
    """
    row, was, s = w.con[c], w.now.s[c], w.new.s[c]
    n = meet(w.S, w.new, row, s, w.W).n
    f = tangential(add(vector(w.new.F[c], 0), 1.0, vector(w.past.F[c], 0)), n)
    here = dot(f, before(w.S, row, s, w.past, 0)[0])
    there = here
    if row[touch.ENDED] == 0:
        there = dot(f, add(before(w.S, row, was, w.past, 0)[0], -1.0, meet(w.S, w.new, row, was, w.W).D))
    work: float = (here + there) / 4
    return work


@_jit
def worked(w: Walk, h: float) -> tuple[float, float, float, float, float, int]:
    """Return work of the loads and frictional work over the increment just solved for, and their rates at its end.

    Then the energy taken up by the grips of sticking contacts, and their number.
    """
    t, load, stick = w.tally, load_rate(w), 0
    rate, rubbed, grips = 0.0 * load, 0.0 * load, 0.0 * load
    share, fresh = h / t[tally.SIZE], t[tally.FRESH].real
    if w.S.shapes[0, MU].real > 0.0:
        for c in range(w.counts[0]):
            stick += w.con[c, touch.STUCK]
        # forces and slips may jump after an event, and where contacts stick
        smooth = fresh >= 2 and stick == t[tally.STICK].real
        for c in range(w.counts[0]):
            if w.con[c, touch.KIND] == touch.LIES:
                continue
            if w.con[c, touch.STUCK] > 0:
                # its grip gives way
                n = meet(w.S, w.new, w.con[c], w.new.s[c], w.W).n
                f, last = tangential(vector(w.new.F[c], 0), n), tangential(vector(w.past.F[c], 0), n)
                grips += w.S.grip * (dot(f, f) - dot(last, last)) / 2
                continue
            rate += power(w, c, h)
            if not smooth:
                rubbed += slid(w, c)
        if smooth:
            rubbed += h * mean(t[tally.POWER2], t[tally.POWER], rate, share)
    work = h * (mean(t[tally.LOAD2], t[tally.LOAD], load, share) if fresh >= 1 else (t[tally.LOAD] + load) / 2)
    return work, rubbed, load, rate, grips, stick


@_jit
def rounded(w: Walk) -> float:
    """Return an energy below which differences of energies are rounding: that of very small motions."""
    most = 0.0 * w.tally[tally.ENERGY]
    for a in range(MOTIONS):
        most = max(most, w.S.K[0, a, a])
    least: float = _SMALL**2 * most
    return least


@_jit
def unbalanced(w: Walk, spent: tuple[float, float, float, float, float, int]) -> tuple[float, float]:
    """Return the work of the increment just solved for that is neither stored nor dissipated, see :func:`worked`.

    Over the energy, and over the largest energy so far.
    """
    stored, had = energy(w, w.new), w.tally[tally.ENERGY]
    lost = abs(spent[0] * cells(w.S) - spent[1] - spent[4] + had - stored)
    most = max(abs(stored), abs(had), rounded(w))
    return lost / most, lost / max(most, w.tally[tally.MOST])


@_jit
def symmetric(w: Walk) -> bool:
    """Remove from the new state what makes left and right differ, if that is rounding; return whether it was.

    With friction it would grow from increment to increment, until corners of tips leave the edge they lie on.
    """
    st, most = w.new, 0.0
    for i in range(len(st.q)):
        if w.S.axes[i, 1, 2] != 0.0:
            return False
        for a in range(1, MOTIONS, 2):
            most = max(most, abs(st.q[i, a].real))
        e = st.strains[row_of(w.S, i)]
        most = max(most, abs(e[PHI].real), abs(e[CHI].real))
    if not 0.0 < most < _UNEQUAL:
        return False
    for i in range(len(st.q)):
        for a in range(1, MOTIONS, 2):
            st.q[i, a] -= st.q[i, a].real
        e = st.strains[row_of(w.S, i)]
        e[PHI] -= e[PHI].real
        e[CHI] -= e[CHI].real
    return True


@_jit
def accept(w: Walk, h: float, event: bool, spent: tuple[float, float, float, float, float, int]) -> None:
    """Make the new state the last one, after an increment with its works; ``event``: rates jump here."""
    t, S = w.tally, w.S
    work, rubbed, load, rate, grips, stick = spent
    if symmetric(w):
        prepared(S, w.new, w.con, w.counts[0], True, w.W)
    t[tally.GRIPS] += grips
    if stick == 0:
        # the energy of grips is dissipated when their contacts slide
        rubbed += t[tally.GRIPS] if t[tally.GRIPS].real > 0.0 else 0.0 * rubbed
        t[tally.GRIPS] = 0.0
    t[tally.WORK] += work
    t[tally.RUBBED] += rubbed
    t[tally.ENERGY] = energy(w, w.new)
    t[tally.MOST] = max(t[tally.MOST].real, t[tally.ENERGY].real)
    t[tally.POWER2], t[tally.LOAD2] = t[tally.POWER], t[tally.LOAD]
    if t[tally.FRESH].real < 1:
        t[tally.POWER2] = rate
    t[tally.POWER], t[tally.LOAD], t[tally.STICK] = rate, load, stick
    for face in range(S.stride):
        # of the first contact of the face's scales
        for c in range(w.counts[0]):
            if w.con[c, touch.FIRST] % S.stride == face:
                if w.con[c, touch.STUCK] == 0:
                    D = before(S, w.con[c], w.new.s[c], w.past, 0)[0]
                    t[tally.SLID + face] += np.sqrt(dot(D, D))
                break
    copied(w.old, w.older)
    copied(w.now, w.old)
    copied(w.new, w.now)
    remember(w)
    t[tally.WAY] += h
    t[tally.BEFORE], t[tally.SIZE] = t[tally.SIZE], h
    t[tally.FRESH] = 0.0 if event else t[tally.FRESH] + 1
    t[tally.COUNT] += 1


@_jit
def remember(w: Walk) -> None:
    """Store the state just solved for as the last one before the next increment."""
    N, past, W = len(w.S.shapes), w.past, w.W
    for which in range(len(past.E) - 1, 0, -1):
        copy(past.E[which - 1], past.E[which])
        copy(past.b[which - 1], past.b[which])
        copy(past.pairs[which - 1], past.pairs[which])
    copy(W.E, past.E[0])
    copy(w.now.b, past.b[0])
    for i in range(N):
        for k in range(w.S.reach):
            for a in range(PLACED):
                past.pairs[0, i, k, a] = W.pairs[i, k, a]
    copy(w.now.F, past.F)


@_jit
def energy(w: Walk, st: State) -> float:
    """Return the elastic energy of joints, bar and plates."""
    S = w.S
    out: float = 0.0 * S.K[0, 0, 0]
    for i in range(len(S.shapes)):
        K, q, e = S.K[i], st.q[i], st.strains[row_of(S, i)]
        for a in range(MOTIONS + STRAINS):
            z = q[a] if a < MOTIONS else e[a - MOTIONS]
            for b in range(MOTIONS + STRAINS):
                out += z * K[a, b] * (q[b] if b < MOTIONS else e[b - MOTIONS]) / 2
        if S.own:
            out += q[TILT] * q[TILT] / 2
        if S.shapes[i, ELASTIC].real > 0:
            for a in range(POWERS):
                out += st.b[i, a] * w.W.load[i, a] / 2
    return out


@_jit
def fall(w: Walk, h: float, before: float) -> tuple[float, float]:
    """Return the energy lost in a jump within an increment, for the energy ``before`` it, and its uncertainty.

    The jump may be anywhere on the increment, so the load there is the last or the new one.
    """
    load, each = load_rate(w), h * cells(w.S) / 2
    lost: float = before + each * (w.tally[tally.LOAD] + load) - energy(w, w.new)
    return lost, each * abs(load - w.tally[tally.LOAD])

"""Entry points of the compiled contact solver, for Python."""

from __future__ import annotations

import math
from pathlib import Path
from typing import NamedTuple

import numpy as np

from squama.batch import records
from squama.batch.keeping import kept, making
from squama.batch.keeping import part as _jit
from squama.contacts import tally, touch
from squama.contacts.derivatives import again
from squama.contacts.detection import WINDOW
from squama.contacts.follow import follow
from squama.contacts.from_endless import from_endless
from squama.contacts.geometry import LEANS, PLACED, RATES, put
from squama.contacts.increments import NO_EQUILIBRIUM, RANGE, Legs, Walk, Written
from squama.contacts.jacobian import LOCAL
from squama.contacts.linear import Linear
from squama.contacts.meeting import Work
from squama.contacts.snapshot import save, take
from squama.contacts.system import (
    ALONE,
    CHI,
    ELASTIC,
    ENDLESS,
    EPS,
    MOTIONS,
    MU,
    OWN,
    PHI,
    PSI,
    STIFF,
    STRAINS,
    UNTIED,
    Past,
    State,
    System,
    Ties,
    ahead,
    borders,
    cells,
    copy,
    freedoms,
    rated,
)
from squama.contacts.written import write
from squama.types import Array

SOURCES = [*sorted(Path(__file__).parent.glob("*.py")), Path(records.__file__)]
GRIP = 1e-6
"""Tangential compliance, d/E, of a sticking contact. It determines the forces that rigid plates leave undetermined
where several contacts stick, as the local compliance of real plates does.
"""
SLIDING = 0.2
"""Stiffness, E d, that multiplies slip in the friction law."""

_CROWD = 8
"""Room for contacts per scale among the scales of a row that may meet, on average."""


@_jit
def _follow(w: Walk, legs: Legs, written: Written) -> None:
    """Follow a path kept in memory: compiled functions get its address."""
    follow(records.held(w), legs, written)


@_jit
def _again(w: Walk, legs: Legs, written: Written) -> None:
    """Follow a recorded path again, see :func:`_follow`."""
    again(records.held(w), legs, written)


@making
def _at(legs: Legs, i: int) -> Legs:
    """Return the legs of path i of many."""
    return Legs(legs.ways[i], legs.corners[i], legs.most[i], legs.step, legs.within)


@making
def _of(found: Written, i: int) -> Written:
    """Return the output arrays of path i of many."""
    rows, motions, bends, contacts, events, ends = found
    return Written(rows[i], motions[i], bends[i], contacts[i], events[i], ends[i])


@_jit
def _begun(w: Walk, given: Array, written: Written) -> None:
    """Solve for a row's state from that of an endless beam and write it, see :func:`_follow`."""
    row = records.held(w)
    written.ends[0] = RANGE if from_endless(row, given) else NO_EQUILIBRIUM
    write(row, written, 0)


@making
def state(S: System, C: int) -> State:
    """Return a state at rest with room for C contacts."""
    N, kind = len(S.shapes), S.K.dtype
    return State(
        np.zeros((N, freedoms(S)), kind),
        np.zeros((cells(S) if S.own else 1, STRAINS), kind),
        np.zeros((N, 24), kind),
        np.zeros((C, 3), kind),
        np.zeros((C, 3), kind),
        np.zeros((2, borders(S) if S.own else 0), kind),
    )


@making
def walk(S: System, C: int, notes: Array) -> Walk:
    """Return a path at rest with room for C contacts, and an array for its record (or an empty one)."""
    N, k, kind = len(S.shapes), S.reach, S.K.dtype
    wide = borders(S)
    n, own, sections = (freedoms(S) + ahead(S)) * N + 6 * C + wide, cells(S) if S.own else 0, S.ties.forces.shape[1]
    strains = rated(S, k)
    W = Work(
        np.zeros((N, 12), kind), np.zeros((N, k, PLACED + 6 * rated(S, k)), kind), np.zeros((N, 24), kind),
        np.zeros((2 * C, 3, 24)), np.zeros((2 * C, 3, 24)), np.zeros(2 * C), np.zeros((6, n)),
        np.zeros((LOCAL + strains, LOCAL + 6 + strains)), np.zeros((C, 3), kind), np.zeros((2, 12), kind),
        np.zeros((4, 3)), np.zeros(7, np.int64), np.zeros(touch.VERTEX),
        np.zeros((2, LOCAL + 6 + strains), np.int64), np.zeros(N, np.int64), np.zeros(2 * C, np.int64),
        np.zeros((own, STRAINS), kind), np.zeros((sections, PLACED), kind), np.zeros((sections, STRAINS, 6), kind),
        np.zeros((sections, 6), kind), np.zeros(PLACED + RATES, kind), np.eye(3).astype(kind), np.full(1, WINDOW),
        np.zeros((N, MOTIONS + STRAINS), kind), np.zeros(1),
        np.zeros((N if S.own else 0, PLACED + RATES + LEANS), kind),
    )  # fmt: skip
    near = n if S.periodic and not S.own else (3 * k + 1) * S.stride * (freedoms(S) + ahead(S) + 6 * _CROWD)
    J = Linear(
        np.zeros(n * min(n, near)), np.zeros((wide, n)), np.zeros((wide, n)), np.zeros((wide, wide)),
        np.zeros(n, np.int64), np.zeros(n, np.int64), np.zeros((3, n), np.int64), np.zeros(n, kind),
        np.zeros(N + C + wide, np.int64), np.zeros(5, np.int64), np.zeros(1),
    )  # fmt: skip
    past = Past(
        np.zeros((3, N, 12), kind), np.zeros((3, N, k, PLACED), kind), np.zeros((3, N, 24), kind),
        np.zeros((C, 3), kind), np.zeros(3, kind),
    )  # fmt: skip
    return Walk(
        S, W, J, state(S, C), state(S, C), state(S, C), state(S, C), state(S, C), state(S, C),
        past, np.zeros((C, 7), np.int64),
        np.zeros((C, 7), np.int64), np.zeros((C, 7), np.int64), np.zeros((64 * N, touch.VERTEX)), np.zeros(4, kind),
        np.zeros(4, np.int64), np.zeros(8, kind), np.zeros(tally.TALLY, kind), np.zeros(touch.VERTEX),
        np.zeros((N, k), np.int64), notes,
    )  # fmt: skip


class Beams(NamedTuple):
    """Many endless beams, E = d = 1.

    ``shapes`` (n, 9): eta, beta, lam, sine and cosine of alpha and of theta0, h, mu; ``K`` (n, 7, 7) over (u, w, phi),
    or (n, 9, 9) with bend and stretch; ``elastic`` (n,); ``plates`` (n, 24, 24), see
    :func:`squama.model.elastic_plate.compliances`; ``free`` (n, 4): flags of free strains; ``aside`` (n,): the bar's
    stiffness against lateral bend over that against bend; ``masked`` (n, 6): 1 for blocked motions, or (n, 0);
    ``grip`` (n,): tangential compliance of a sticking contact, :data:`GRIP`; ``tilts`` (n, 3): motion of a scale of a
    row per unit of its tilt, see :mod:`squama.joints.tilt`. With scales on both faces ``seen`` (n, 3) are the signs
    with which the other face sees bend, twist and lateral bend, and ``own`` (n, 4) is the bar's own stiffness against
    the strains, included in the matrices of both; else both are (n, 0).
    """

    shapes: Array
    K: Array
    elastic: Array
    plates: Array
    free: Array
    aside: Array
    masked: Array
    seen: Array
    own: Array
    grip: Array
    tilts: Array


@_jit
def faces(b: Beams) -> int:
    """Return the number of faces with scales."""
    return 2 if b.seen.shape[1] > 0 else 1


@making
def system(b: Beams, i: int, n: int, about: int, ties: Ties) -> System:
    """Return one beam as n scales that repeat for ever, or as a row, which may come to lie on the substrate.

    With scales on both faces every second scale is on the other face. For ``i`` < 0 each scale is that of another beam.
    """
    kind, periodic, reach = b.shapes.dtype, about in (ENDLESS, ALONE), 1
    shapes, axes = np.zeros((n, 6), kind), np.zeros((n, 3, 3), kind)
    tilts = np.zeros((n if about >= OWN else 0, 3), kind)
    bases, joint, plates = np.zeros((n, 3), kind), np.zeros((n, 10, 10), kind), np.zeros((n, 24, 24), kind)
    rests, sees, stride = np.zeros(0 if periodic else n), np.ones((n, 3)), faces(b)
    for o in range(n):
        own = o // stride if i < 0 else i
        s, K = b.shapes[own], b.K[own]
        eta, beta, sa, ca, st, ct = s[0], s[1], s[3], s[4], s[5], s[6]
        reach = max(reach, int(math.hypot(eta.real, 2 * beta.real)))
        put((eta, beta, s[7]), shapes[o], 0)
        shapes[o, MU], shapes[o, ELASTIC], shapes[o, STIFF] = s[8], 1.0 if b.elastic[own] else 0.0, SLIDING
        put((-sa * ct, st, ca * ct), axes[o, 0], 0)
        put((ca, 0.0 * ca, sa), axes[o, 1], 0)
        put((st * sa, ct, -st * ca), axes[o, 2], 0)
        bases[o, 1] = s[2]
        for a in range(len(K)):
            for c in range(len(K)):
                joint[o, _place(a), _place(c)] = K[a, c]
        if len(K) == 9:
            joint[o, MOTIONS + CHI, MOTIONS + CHI] = b.aside[own] * K[7, 7]
        if o % stride == 1:
            turned_over(b, own, joint[o], sees[o])
        if about == OWN:
            copy(b.tilts[own], tilts[o])
        if b.elastic[own]:
            copy(b.plates[own], plates[o])
        if not periodic:
            rests[o] = math.atan2(st.real, ct.real)
    one = max(i, 0)
    return System(
        shapes, axes, bases, joint, plates, b.free[one], b.grip[one], reach, periodic, sees, stride, rests,
        b.masked[one], about >= OWN, ties, tilts,
    )  # fmt: skip


@_jit
def turned_over(b: Beams, i: int, K: Array, sees: Array) -> None:
    """Transform a joint (10, 10) into that of a scale on the other face, without the bar, which is counted once."""
    copy(b.seen[i], sees)
    for e in range(STRAINS):
        if e != EPS:
            for a in range(MOTIONS + STRAINS):
                K[a, MOTIONS + e] *= sees[e]
            for a in range(MOTIONS + STRAINS):
                K[MOTIONS + e, a] *= sees[e]
    for e in range(STRAINS):
        K[MOTIONS + e, MOTIONS + e] -= b.own[i, e]


@_jit
def _place(a: int) -> int:
    """Return the row of a joint's matrix in the order of motions and strains, where bend comes before twist."""
    if a < MOTIONS:
        return a
    return MOTIONS + (PHI if a == 6 else (PSI if a == 7 else EPS))


def _many(
    b: Beams, scales: int, about: int, ties: Ties, C: int, legs: Legs, found: Written, notes: Array, snapshots: Array
) -> None:
    """Follow beams with a number of scales, endless or rows, each on its own path.

    ``about``: kind of their cells, :data:`squama.contacts.system.ENDLESS` and so on. If there are more beams than
    paths, each beam is a scale of one row; one beam may have many paths. ``snapshots`` (n, size): states from which
    paths start, replaced by those they reach; (n, 0) starts from rest. For rows whose cells have their own strains they
    are states of the endless beam, from which one state of the row is solved for (:mod:`squama.contacts.from_endless`).
    """
    each, one = len(b.shapes) > len(legs.ways), len(b.shapes) == 1
    for i in range(len(legs.ways)):
        w = walk(system(b, -1 if each else 0 if one else i, scales, about, ties), C, notes[i])
        if snapshots.shape[1] > 0 and about == OWN:
            _begun(w, snapshots[i], _of(found, i))
            continue
        if snapshots.shape[1] > 0:
            take(w, snapshots[i])
        _follow(w, _at(legs, i), _of(found, i))
        if snapshots.shape[1] > 0:
            save(w, snapshots[i])


def _move(b: Beams, C: int, legs: Legs, found: Written, notes: Array, snapshots: Array) -> None:
    """Follow endless beams (n k) with complex steps, k copies of each of n recorded paths, with the ends found there.

    ``snapshots`` (n, size) of their starting states, or (n, 0) for rest.
    """
    k, one = len(legs.ways) // len(notes), len(b.shapes) == 1
    for i in range(len(legs.ways)):
        w = walk(system(b, 0 if one else i, faces(b), ENDLESS, UNTIED), C, notes[i // k])
        if snapshots.shape[1] > 0:
            take(w, snapshots[i // k])
        _again(w, _at(legs, i), _of(found, i))


many, move = kept(_many, SOURCES), kept(_move, SOURCES)

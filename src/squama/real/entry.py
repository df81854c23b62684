"""The compiled code of the real model as it is called from outside: many beams, one after the other."""

from __future__ import annotations

import math
from pathlib import Path
from typing import NamedTuple

import numpy as np

from squama.batch.keeping import kept
from squama.model import elastic_plate
from squama.model.elastic_plate import SIDE_D, TIP
from squama.real import moved, start
from squama.real import follow as following
from squama.real.changes import OTHER
from squama.real.contact import MOST
from squama.real.design import LEG, ROWS, SHAPE, Design, _jit
from squama.real.features import compliances
from squama.real.follow import End
from squama.contacts.vectors import put
from squama.types import Array

SOURCES = [Path(elastic_plate.__file__), *sorted(Path(__file__).parent.glob("*.py"))]
"""All that may be compiled."""
_follow, _first_contact, _met_along, _meeting = following.follow, start.first_contact, start.met_along, start.meeting
_bend = compliances
_inverses, _again = moved.inverses, moved.again


class Beams(NamedTuple):
    """Many beams, E = d = 1.

    ``shapes`` (n, 9): eta, beta, lam, sine and cosine of alpha and of theta0, h, mu; ``K`` (n, 7, 7) over (u, w,
    phi), or (n, 9, 9) over bend and stretch, too; ``elastic`` (n,); ``plates`` (n, 24, 24), see
    :func:`squama.model.elastic_plate.compliances`; ``bent`` (n,); ``soft`` (n,), the stretch per axial force, 0
    where the length is held.
    """

    shapes: Array
    K: Array
    elastic: Array
    plates: Array
    bent: Array
    soft: Array


@_jit
def _design(b: Beams, i: int, table: Array) -> Design:
    """Return a beam's design, its tip edge on the next one's side edge, the joint written into its table."""
    put(b.K[i], table)
    table[LEG, 3], table[LEG, 4] = 1.0, b.soft[i]
    if b.elastic[i]:
        put(b.plates[i], table[SHAPE:])
    s = b.shapes[i]
    edges, upwards = (TIP, SIDE_D, 1), 1.0
    return Design(
        s[0], s[1], s[2], s[3], s[4], s[5], s[6], s[7], s[8], *edges, upwards, b.elastic[i], table,
        b.bent[i],
    )  # fmt: skip


@_jit
def _along(
    d: Design, c: Array, targets: Array, corners: Array, step: float, every: int, out: Array, notes: Array
) -> End:  # fmt: skip
    """Follow a beam from its first contact on, as :func:`squama.real.follow.follow`."""
    begin, reached = (math.inf, 0.0, 0.0), targets.size
    if c[0] >= 0.0:
        begin = c[3], c[4], c[5]
    elif c[0] == -2.0:
        reached = 0
        while reached < targets.size and targets[reached] <= c[3]:
            reached += 1
    end = _follow(d, begin, targets[:reached], corners, step, every, out, notes)
    return end if reached == targets.size else End(OTHER, c[3], int(c[1]), int(c[2]), reached)


def _answer(
    b: Beams, most: Array, step: float, every: int, targets: Array, corners: Array, contacts: Array, tables: Array,
    out: Array, ends: Array, notes: Array,
) -> None:  # fmt: skip
    """Find what touches first below the twists ``most`` (n,) where that is not known yet, and follow the beams.

    With ``corners`` (n, m, 2), bend and twist between which a path is straight, ``targets`` are ways along it; without
    (n, 0, 2) they are twists. ``bent`` beams know bend and stretch.

    Written are ``contacts`` (n, 6), see :func:`squama.real.start.first_contact`, NaN where they are not known,
    ``tables`` (n, 46, 24) of the designs, ``out`` (n, m, 19) at targets (n, m) as far as they are reached, and ``ends``
    (n, 5), see :class:`squama.real.follow.End`, and ``notes`` (n, m, 56), see :func:`squama.real.follow.follow`.
    """
    for i in range(targets.shape[0]):
        d, c, end = _design(b, i, tables[i]), contacts[i], ends[i]
        if math.isnan(c[0]):
            if len(corners[i]):
                c[0], c[1], c[2], c[3], c[4], c[5] = _met_along(d, 0.0, 0.0, 0, targets[i], corners[i], most[i])
            else:
                c[0], c[1], c[2], c[3], c[4], c[5] = _first_contact(d, 0.0, most[i], 0.0)
        if c[0] >= 0.0:
            d = _meeting(d, int(c[0]), int(c[1]), int(c[2]))
        if d.elastic:
            _bend(d)
        end[0], end[1], end[2], end[3], end[4] = _along(d, c, targets[i], corners[i], step, every, out[i], notes[i])


def _move(
    b: Beams, contacts: Array, targets: Array, step: float, notes: Array, many: Beams, goals: Array, tables: Array,
    starts: Array, out: Array,
) -> None:  # fmt: skip
    """Follow beams that :func:`answer` has followed, and noted, with complex steps.

    ``contacts``, ``targets``, ``notes`` of n beams as there; ``many`` are the same beams, each k times one after the
    other, with other complex steps; so are ``goals`` (n k, m), their targets. Written are ``tables`` (n k, 46, 24),
    ``starts`` (n k, 3), twists and places at engagement, and ``out`` (n k, m, 19).
    """
    k = len(goals) // len(targets)
    J, table = np.empty((notes.shape[1], MOST, MOST)), np.zeros((ROWS, 24))
    for i in range(len(targets)):
        c, n = contacts[i], 0
        if c[0] >= 0.0:
            d = _meeting(_design(b, i, table), int(c[0]), int(c[1]), int(c[2]))
            if d.elastic:
                _bend(d)
            n = _inverses(d, (c[3], c[4], c[5]), step, notes[i], J)
        for j in range(i * k, (i + 1) * k):
            one = _design(many, j, tables[j])
            if c[0] >= 0.0:
                one = _meeting(one, int(c[0]), int(c[1]), int(c[2]))
            if one.elastic:
                _bend(one)
            _again(one, c, targets[i], goals[j], step, notes[i, :n], J, starts[j], out[j])


move = kept(_move, SOURCES)
answer = kept(_answer, SOURCES)

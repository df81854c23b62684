"""Which edges touch first, and at which twist; compiled."""

from __future__ import annotations

import math

import numpy as np

from squama.model.elastic_plate import BASE, SIDE_D, TIP
from squama.real.design import LEG, Design, _in, _jit, onto
from squama.real.faces import others, tilt, tip_over
from squama.real.features import CORNERS, FACE, compliances, high, lengthwise, low, on_face
from squama.real.steps import engagement, free_rates, unloaded
from squama.types import Array

_SAMPLES, _HALVINGS, _NEAR, _EARLIER, _APART, _FLUSH, _SEEN, _AGAIN = 8, 24, 0.02, 0.7, 5e-3, 1e-9, 1e-5, 1e-5
"""Twists at which plates are looked at, halvings; where edges may have met, as parts of the twist at which one is seen
in a face; distance of places on a leg, rad; slope of a tip edge that comes to a face all along; how far behind the end
of a leg is looked, and from how far behind a place of parting on, rad."""


@_in
def meeting(d: Design, first: int, second: int, k: int) -> Design:
    """Return the design with other features that meet, their common normal pushing scale 1 upwards."""
    # (edges along one direction cross by the twist alone, and directions along a face by themselves)
    sign = 1.0 if lengthwise(second) and first in (TIP, BASE) else -1.0
    return Design(
        d.eta, d.beta, d.lam, d.sa, d.ca, d.st, d.ct, d.h, d.mu, first, second, k, sign, d.elastic, d.table,
        d.bent,
    )  # fmt: skip


@_in
def within(d: Design, x: float, y: float) -> bool:
    """Say whether places lie on their edges, or on their face."""
    if on_face(d):
        return 0.0 <= x <= d.eta and abs(y) <= d.beta
    return low(d, d.first) <= x <= high(d, d.first) and low(d, d.second) <= y <= high(d, d.second)


@_jit
def hinge_guess(d: Design) -> tuple[float, float, float]:
    """Return twist and places at which tip and side of thick plates on hinges would meet (docs, theory: geometry)."""
    S = d.ca * d.st
    H = d.sa * (d.eta + d.lam * d.st) + d.ca * d.ct * (d.beta - d.sa)
    s2, c2 = 2 * d.sa * d.ca, d.ca * d.ca - d.sa * d.sa
    G = d.beta * s2 * d.st + 2 * d.eta * d.ca * d.ca * d.st * d.ct + 2 * d.lam * c2 * d.ct
    u = (S - d.h) / (H + math.sqrt(max(0.0, H * H - (S - d.h) * (G - S + d.h * S * S))))
    phi = 2 * math.atan(u) if u > 0 else 0.05
    c, s = math.cos(phi), math.sin(phi)
    y = (d.lam * (1 - c) + d.eta * d.st - d.beta * d.ca * s) / (d.st * c + d.sa * d.ct * s)
    return phi, 0.0, min(max(y, 0.0), d.eta)


@_jit
def first_contact(d: Design, least: float, most: float, since: float) -> tuple[int, int, int, float, float, float]:
    """Return what touches first between twists, neighbour, twist and both places; it goes straight ``since`` a way.

    The first edge is -1 where nothing touches below ``most``, and -2 where something touches that is not followed, or
    does already at ``least``, as at rest (twist 0).
    """
    rates, b, q = free_rates(d), np.zeros(24), np.empty(7)
    found, phi, x, y = engagement(d, rates, hinge_guess(d))
    bends = d.bent and (d.table[LEG, 0].real != 0.0 or d.table[LEG, 2].real != 0.0)
    found = found and least < phi <= most and within(d, x, y) and not bends
    n = _SAMPLES if found else 8 * _SAMPLES
    if bends:
        n = min(n, 1 + int((most - least) / _APART))
    limit = phi * (1 - 1e-9) if found else most
    before = least
    for i in range(n + 1):
        at = least + (limit - least) * i / n
        unloaded(rates, at, q)
        deep, edge, k = others(d, q, at, q[6], b)
        if deep < 0.0:
            if i == 0:
                return -2, edge, k, least, 0.0, 0.0
            for _ in range(_HALVINGS):
                middle = (before + at) / 2
                unloaded(rates, middle, q)
                deep, e, j = others(d, q, middle, q[6], b)
                if deep < 0.0:
                    at, edge, k = middle, e, j
                else:
                    before = middle
            return by_edge(d, rates, edge, k, since, at)
        before = at
    if found:
        return d.first, d.second, d.k, phi, x, y
    return -1, 0, 0, math.inf, 0.0, 0.0


@_jit
def met_along(
    d: Design, here: float, since: float, begun: int, targets: Array, corners: Array, most: float
) -> tuple[int, int, int, float, float, float]:
    """Return what touches first on the legs of a path, as :func:`first_contact`, from a way on.

    ``begun``: the next target's number; the last leg goes straight on to ``most``; ``since``: the way from which on
    what is seen may have touched, on others it is where they begin. The leg that was looked at last is left in the
    design's table.
    """
    found = (-1, 0, 0, math.inf, 0.0, 0.0)
    for i in range(begun, targets.size):
        last = targets[i - 1] if i > 0 else 0.0
        if found[0] != -1 or targets[i] <= here or targets[i] <= last:
            continue
        if onto(d, last, targets[i], corners, i):
            since = last
        # what has just touched is not deep enough to be seen
        found = first_contact(d, max(here, last), targets[i] + _SEEN, since)
        here = targets[i]
        if found[3] > here:
            found = (-1, 0, 0, math.inf, 0.0, 0.0)
    if found[0] == -1 and here < most:
        found = first_contact(d, here, most, since)
    return found


@_jit
def next_contact(
    d: Design, here: float, targets: Array, corners: Array, i: int
) -> tuple[Design, int, int, int, tuple[float, float, float]]:
    """Return the design with what touches next once a contact has parted before target i, and where, as for the first.

    It is looked for on all of the way that is left: what has just touched, or is about to, is known at each target.
    """
    if len(corners) > 0:
        first, second, k, phi, x, y = met_along(d, here + _AGAIN, here + _AGAIN, i, targets, corners, 0.0)
        onto(d, targets[i - 1] if i > 0 else 0.0, targets[i], corners, i)
    else:
        first, second, k, phi, x, y = first_contact(d, here + _AGAIN, targets[i:].max(), here + _AGAIN)
    if first >= 0:
        d = meeting(d, first, second, k)
        if d.elastic and not on_face(d):
            compliances(d)
    return d, first, second, k, (phi, x, y)


@_jit
def by_edge(
    d: Design, rates: Array, edge: int, k: int, least: float, near: float
) -> tuple[int, int, int, float, float, float]:
    """Return the contact of an edge (+ 4: of the neighbour's upper face) with what it meets first between two twists.

    That is an edge of the other scale or, of beams that are bent, its face, on which a corner of the edge comes.
    """
    best = (-2, edge, k, near, 0.0, 0.0)
    # (edges of plates that are not turned yet coincide)
    earliest, latest = max(least, near * _EARLIER), near * (1 + _NEAR)
    for other in range(6 if d.bent else 4):
        if other < FACE:
            pair = meeting(d, other, edge - 4, k) if edge >= 4 else meeting(d, edge, other, k)
        else:
            corner = corner_of(edge % 4, other - FACE)
            pair = meeting(d, FACE, corner, k) if edge >= 4 else meeting(d, corner, FACE, k)
        for i in range(3):
            for j in range(3):
                x, y = start_at(pair, 0, (i + 0.5) / 3), start_at(pair, 1, (j + 0.5) / 3)
                found, phi, x, y = engagement(pair, rates, (near, x, y))
                if found and earliest < phi <= latest and (phi < best[3] or best[0] < 0) and within(pair, x, y):
                    best = (pair.first, pair.second, k, phi, x, y)
    return flush(d, rates, best) if d.bent and edge == TIP and best[0] >= 0 else best


@_jit
def flush(
    d: Design, rates: Array, found: tuple[int, int, int, float, float, float]
) -> tuple[int, int, int, float, float, float]:
    """Return the contact of a tip edge, on the face by its middle where it comes to lie in that all along."""
    q, none, k, phi = np.empty(7), np.zeros(24), found[2], found[3]
    unloaded(rates, phi, q)
    d = meeting(d, TIP, FACE, k)
    if abs(tilt(d, q, phi, q[6], none, 0.0, 0.0, 0.0)) > _FLUSH:
        return found
    x, y, _ = tip_over(d, q, phi, q[6], none, 0.0, 0.0)
    return (TIP, FACE, k, phi, x, y) if within(d, x, y) else found


@_in
def corner_of(edge: int, which: int) -> int:
    """Return one of the two corners of an edge, C, B, D, A by number."""
    if edge in (TIP, BASE):
        return CORNERS + which + (0 if edge == TIP else 2)
    return CORNERS + 2 * which + (0 if edge == SIDE_D else 1)


@_in
def start_at(d: Design, which: int, share: float) -> float:
    """Return a place on the first (0) or the second edge, or of the two on a face."""
    if on_face(d):
        return d.beta * (2 * share - 1) if which else d.eta * share
    edge = d.second if which else d.first
    return low(d, edge) + (high(d, edge) - low(d, edge)) * share

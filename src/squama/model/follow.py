"""From the ratios of one design to its end: engagement, path of the first contact, and reason of its end.

The path is first sampled coarsely. Where a margin curves so much that it might vanish between two samples, the interval
is halved until none does, so that a margin that only touches zero is found too. The end is then solved for in its
interval, and another neighbour that comes in before it cuts the path (:mod:`squama.model.crossings`).

The functions work on one design. Python executes them for few designs, with :mod:`squama.model.evaluation`, and they
are compiled for many, with ``squama.batch.kernel``; nothing else differs.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from squama.model.bracket import zero
from squama.model.crossings import first_crossing
from squama.model.evaluation import (
    BENT,
    DEEPEST,
    EVEN,
    FOLDED,
    LEAST,
    MOST_PARTS,
    OPEN,
    PART,
    SQUARE,
    Design,
    Room,
    Spot,
    looks,
    onward,
    sample,
    samples,
    spot,
)
from squama.model.neighbours import engages, meets, reach, touches_at_rest
from squama.model.outcome import CODES, End
from squama.model.paths import FLOAT, Twist
from squama.types import Array

SAFETY = 0.25
"""Share of the second difference of three samples by which a margin may deviate between them."""
UNSTEADY = 2.0
"""Factor by which a margin must exceed its deviation from a parabola half way to the second sample."""
COINCIDE = 1e-11
"""Value of a margin below which it counts as vanished."""
TURNED, UPRIGHT = math.radians(179), math.pi / 2
"""Largest sampled inclinations: the scale lies on its back (twisting), stands upright (bending)."""
FRICTIONAL, KINEMATIC, STATIC = map(CODES.index, (End.FRICTIONAL, End.KINEMATIC, End.STATIC))
OTHER, RELEASED, RANGE = map(CODES.index, (End.OTHER, End.RELEASED, End.RANGE))
NONE, TOUCHING = map(CODES.index, (End.NONE, End.TOUCHING))
PASSED, ENDS, TURNS, UNCLEAR = range(4)
"""Verdict on samples of a path: nothing ends it, it ends, it folds, or the samples are too far apart to decide."""
MARGINS = (KINEMATIC, FRICTIONAL, CODES.index(End.OFF_TIP), CODES.index(End.OFF_SIDE), RANGE)
BENT_MARGINS = (KINEMATIC, FRICTIONAL, RANGE, CODES.index(End.OFF_SIDE), CODES.index(End.LINE))
"""Ends by the vanishing margin, in twisting and in bending; the first counts where two coincide."""


class Bracket(NamedTuple):
    """Interval of a path's end: between ``a`` and ``b``, with the smallest margins ``fa`` > 0 >= ``fb`` there.

    ``c`` is a third place with the value ``fc`` (NaN for none). ``a`` is NaN if nothing ends the path, and equals b if
    the path ends at its beginning. A fold before the end lies between ``fold_a`` and ``fold_b`` (NaN for none).
    """

    a: float
    b: float
    fa: float
    fb: float
    c: float
    fc: float
    fold_a: float
    fold_b: float


class Followed(NamedTuple):
    """The path of a design, in units of k pitches, from ``x0`` to ``x_end``, and the ``code`` of its end.

    ``k`` neighbour followed (0 for none), ``load_e``, ``load_end`` load angles per pitch, ``crossing`` neighbour whose
    contact ends the path (0 for none).
    """

    d: Design
    k: int
    load_e: float
    x0: float
    x_end: float
    load_end: float
    code: int
    crossing: int


def follow(pair: Twist, mu: float, kind: int, law: int, room: Room) -> Followed:
    """Follow the first contact of a design to its end; lengths in pitches, ``pair.sa`` < 0 for the other sense.

    ``kind`` is BENT for bending, else OPEN; ``law`` is the index of a force law.
    """
    n, load_e, theta0 = 0, math.inf, pair.theta0
    if kind != BENT:
        n, load_e = first_engagement(pair)
    else:
        start = spot(theta0, design(pair, mu, 0.0, 1.0, kind, law), room)
        if start.load > 0 and start.tip > 0 and start.side >= 0:
            n, load_e = 1, start.load
    k = float(max(n, 1))
    d = design(pair, mu, 0.0, k, kind, law)
    if kind != BENT and touches_at_rest(pair):
        return Followed(d, 0, 0.0, theta0, theta0, 0.0, TOUCHING, 0)
    if n == 0:
        return Followed(d, 0, math.inf, theta0, theta0, math.inf, NONE, 0)
    x0, x1 = theta0, UPRIGHT if kind == BENT else TURNED
    found = bracket(d, x0, x1, room)
    if not math.isnan(found.fold_a):
        a, b = found.fold_a, found.fold_b
        fold, at_a, at_b = b, value(a, d, room, SQUARE), value(b, d, room, SQUARE)
        if b > a:
            fold = zero(value, a, at_a, b, at_b, a, math.nan, True, d, room, SQUARE)
        d = design(pair, mu, fold, k, FOLDED, law)
        x1 = math.sqrt(fold - theta0)
        x0 = -x1
        found = bracket(d, x0, x1, room)
    x_end, code, load_end = end(d, found, x0, x1, room)
    j = 0
    if kind != BENT:
        j, x_end = first_crossing(d, pair, x0, x1, x_end, room)
    if j > 0:
        code, load_end = OTHER, spot(x_end, d, room).load
    if x_end == x0:
        load_end = load_e
    return Followed(d, n, load_e, x0, x_end, load_end, code, j)


def design(pair: Twist, mu: float, theta_f: float, k: float, kind: int, law: int) -> Design:
    """Return the contact of a pair with neighbour k, lengths in k pitches."""
    eta, beta, lam, thickness = pair.eta / k, pair.beta / k, pair.lam / k, pair.thickness / k
    return Design(eta, beta, lam, pair.sa, pair.ca, pair.theta0, mu, theta_f, k, kind, law, thickness)


def value(x: float, d: Design, room: Room, what: int) -> float:
    """Return field number ``what`` of the :class:`Spot` at a path parameter."""
    return spot(x, d, room)[what]


def first_engagement(pair: Twist) -> tuple[int, float]:
    """Return the neighbour that engages first and its twist per pitch (rad); 0 and inf if none does."""
    k, best = 0, math.inf
    for n in range(1, max(1, int(reach(pair, FLOAT))) + 1):
        row = Twist(pair.eta, pair.beta, pair.lam, pair.sa, pair.ca, pair.theta0, float(n), pair.thickness)
        phi = meets(row, FLOAT)
        if phi < best and engages(row, FLOAT):
            k, best = n, phi
    return k, best


def bracket(d: Design, x0: float, x1: float, room: Room) -> Bracket:
    """Bracket the end of a path, or the fold of an open path; refine only if coarse samples do not decide."""
    m = samples(d.kind) + 1
    for j in range(1, m):
        room.x[j] = sample(j - 1, d.kind, x0, x1)
    room.x[m] = (x0 + room.x[2]) / 2
    looks(d, room, 1, m + 1)
    first, state = judged(d, room, m)
    if state == UNCLEAR or not steady(room, first, m) or (d.kind == OPEN and first > EVEN):
        return closely(d, x0, x1, room)
    return around(room, first, state)


def closely(d: Design, x0: float, x1: float, room: Room) -> Bracket:
    """Bracket the end or the fold of a path: every interval is halved until its samples decide."""
    parts, m = 0, PART + 2
    for i in range(samples(d.kind) - 1):
        low, high, n, level = sample(i, d.kind, x0, x1), sample(i + 1, d.kind, x0, x1), 0, 0
        while level > 0 or n == 0:
            width = (high - low) * 0.5**level
            a = low + n * width
            for s in range(PART + 1):
                room.x[s + 1] = a + width * (s / PART)
            looks(d, room, 1, m)
            first, state = judged(d, room, m)
            parts += 1
            if state == UNCLEAR:
                if level < DEEPEST and parts < MOST_PARTS:
                    n, level = 2 * n, level + 1
                    continue
                # beyond this depth the samples are taken at face value
                state = PASSED
                if first < m:
                    state = TURNS if d.kind == OPEN and not room.square[first] > 0 else ENDS
            if state != PASSED:
                return around(room, first, state)
            n, level = onward(n, level)
    return around(room, m, PASSED)


def judged(d: Design, room: Room, m: int) -> tuple[int, int]:
    """Return the first of the samples 1..m - 1 beyond the end of the path (m for none), and the verdict."""
    first = first_not_positive(room.least, m)
    if d.kind == OPEN and first > 1:
        turned = first_not_positive(room.square, m)
        if turned == first < m:
            # the path folds: its beginning is searched again on the folded path
            return first, TURNS if smooth(room, first - 1, m) and falls(room, first, m) else UNCLEAR
        if not smooth(room, first, m):
            return first, UNCLEAR
    if not calm(room, first, m):
        return first, UNCLEAR
    return first, PASSED if first == m else ENDS


def first_not_positive(values: Array, m: int) -> int:
    """Return the first sample at which values are not above zero; m if all are."""
    for i in range(1, m):
        if not values[i] > 0:
            return i
    return m


def around(room: Room, first: int, state: int) -> Bracket:
    """Return the bracket of an end, or of a fold, at the sample ``first``."""
    x, low, nan = room.x, room.least, math.nan
    if state == PASSED:
        return Bracket(nan, nan, nan, nan, nan, nan, nan, nan)
    i, h = max(first - 1, 1), max(first - 2, 1)
    a, b, fa, fb = float(x[i]), float(x[first]), float(low[i]), float(low[first])
    if state == TURNS:
        return Bracket(nan, nan, nan, nan, nan, nan, a, b)
    return Bracket(a, b, fa, fb, float(x[h]), float(low[h]) if h < i else nan, nan, nan)


def calm(room: Room, first: int, m: int) -> bool:
    """Return whether no margin can vanish between the samples, up to the sample ``first`` that ended the path.

    In the interval before that sample, the margins that end the path may vanish.
    """
    if first == 2:
        return False
    for v in (room.rate, room.drive, room.tip, room.side, room.turn):
        for s in range(3, min(first + 1, m)):
            a, b, c = v[s - 2], v[s - 1], v[s]
            bend = abs(c - 2 * b + a) * SAFETY
            if not (a > bend and b > bend) or (not c > bend and (c > 0 or s != first)):
                return False
    return True


def steady(room: Room, first: int, m: int) -> bool:
    """Return whether the margins at sample ``m``, half way to the second, fit a parabola through the first three.

    At the beginning of a path there are no earlier samples to estimate their curvature.
    """
    for v in (room.rate, room.drive, room.tip, room.side, room.turn):
        off = abs(v[m] - (3 * v[1] + 6 * v[2] - v[3]) / 8)
        if first > 2 and not (v[1] > UNSTEADY * off and v[m] > UNSTEADY * off):
            return False
    return True


def bend_at(room: Room, i: int, m: int) -> float:
    """Return the possible deviation of the squared root from its samples in the interval from i to i + 1."""
    v, bend = room.square, 0.0
    for s in (max(i, 2), min(i + 1, m - 2)):
        if i <= s <= i + 1:
            bend = max(bend, abs(v[s + 1] - 2 * v[s] + v[s - 1]) * SAFETY)
    return bend


def smooth(room: Room, stop: int, m: int) -> bool:
    """Return whether the squared root stays above zero between the samples up to ``stop``."""
    v = room.square
    for i in range(1, min(stop, m - 1)):
        bend = bend_at(room, i, m)
        if not (v[i] > bend and v[i + 1] > bend):
            return False
    return True


def falls(room: Room, stop: int, m: int) -> bool:
    """Return whether the squared root falls through zero just once in the interval before the sample ``stop``."""
    bend = bend_at(room, stop - 1, m)
    return bool(room.square[stop - 1] > bend and -room.square[stop] > bend)


def end(d: Design, found: Bracket, x0: float, x1: float, room: Room) -> tuple[float, int, float]:
    """Solve for the end of a path in its bracket; return path parameter, code of the end, and load angle (rad)."""
    if math.isnan(found.a):
        # a folded path that reaches its far end has come back to theta0, where the spring is at rest
        return x1, RELEASED if d.kind == FOLDED else RANGE, spot(x1, d, room).load
    x = found.b
    if found.b > found.a:
        x = zero(value, found.a, found.fa, found.b, found.fb, found.c, found.fc, True, d, room, LEAST)
    at = spot(x, d, room)
    code = named(at, d.kind)
    return x, STATIC if code == FRICTIONAL and x == x0 else code, at.load


def named(values: Spot, kind: int) -> int:
    """Return the code of the margin that vanishes at the end; the first where two coincide."""
    least, which, codes = math.inf, 0, BENT_MARGINS if kind == BENT else MARGINS
    for n in range(5):
        v = values[2 + n]
        if not v > COINCIDE:
            return codes[n]
        if v < least:
            least, which = v, n
    return codes[which]

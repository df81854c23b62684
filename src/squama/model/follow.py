"""From the ratios of one design to its end: engagement, the path of the pair that is met first, what ends it.

The path is sampled coarsely first. Where the margins are so smooth that nothing can hide between two samples, the first
interval in which one changes sign is kept; other paths are sampled again, four times as closely, and local minima that
come near zero are followed to their bottom. The end is then solved for in its interval, and another neighbour that
comes in before it cuts the path.

Everything here works on one design. Python executes it for few designs, with what :mod:`squama.model.evaluation`
sees of a place, and has it compiled for many, with what :mod:`squama.batch.kernel` sees; nothing else differs.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from squama.model.bracket import zero
from squama.model.evaluation import BENT, FOLDED, LEAST, OPEN, SQUARE, Design, Room, apart, joined, looks, roots, spot
from squama.model.neighbours import engages, reach, reach_at
from squama.model.outcome import CODES, End
from squama.model.paths import FLOAT, Twist
from squama.types import Array

STEPS = np.concatenate([np.linspace(0.0, 0.55, 29)[:-1], np.linspace(0.55, 1.0, 13)])
"""Samples of an open path as fractions of its parameter; closer together up to about 100 deg, where most end."""
COARSE_STEPS = STEPS[::4].copy()
"""Those that are looked at first."""
FOLDED_STEPS = np.linspace(0.0, 1.0, 81)
"""Samples of a folded path, on which the twist grows large and farther neighbours come and go."""
FOLDED_COARSE_STEPS = FOLDED_STEPS[::5].copy()
SAFETY = 0.25
"""Part of the bend seen in three samples by which a margin may differ from them in between."""
DEEP = 0.5
"""Minima are followed whose parabola goes below this part of the lowest sample."""
COINCIDE = 1e-11
"""Margins below this have vanished."""
TURNED, UPRIGHT = math.radians(179), math.pi / 2
"""Largest inclinations looked at: where the scale lies on its back (twisting), where it stands (bending)."""
SAMPLES, FOLDED_SAMPLES = 13, 41
"""Samples of a path at which other neighbours are looked for, open and folded."""
CLEAR, FOLDED_CLEAR = 5, 13
"""Samples that show for most designs that no other neighbour comes near."""
NEAR = 7
"""Neighbours from which on that quick look is not made."""
AWAY = 0.5
"""Part of the bend seen in three samples that a condition must be away from zero by (a parabola needs an eighth)."""
FRICTIONAL, KINEMATIC, STATIC, OTHER, RELEASED, RANGE, NONE = (
    CODES.index(e) for e in (End.FRICTIONAL, End.KINEMATIC, End.STATIC, End.OTHER, End.RELEASED, End.RANGE, End.NONE)
)
MARGINS = (KINEMATIC, FRICTIONAL, CODES.index(End.OFF_TIP), CODES.index(End.OFF_SIDE), RANGE)
"""Ends named by the margins that vanish; where two coincide, the first."""


class Bracket(NamedTuple):
    """Where a path ends: between ``a`` and ``b``, with the smallest margins ``fa`` > 0 >= ``fb`` there.

    ``c`` is a third place with the value ``fc`` (NaN where there is none). ``a`` is NaN where nothing ends the path; it
    is b where the path has ended where it begins. A fold before the end lies between ``fold_a`` and ``fold_b`` (NaN
    where there is none).
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


def follow(
    eta: float, beta: float, lam: float, sa: float, ca: float, theta0: float, mu: float, kind: int, law: int, room: Room
) -> Followed:
    """Follow the contact that a design meets first; lengths in pitches, ``sa`` < 0 is the other sense.

    ``kind`` is BENT for the tip-on-face contact of bending, else OPEN; ``law`` as in Design.
    """
    pair, n, load_e = Twist(eta, beta, lam, sa, ca, theta0, 1.0), 0, math.inf
    if kind != BENT:
        n, load_e = first_engagement(pair)
    elif eta >= 1:
        n, load_e = 1, spot(theta0, design(pair, mu, 0.0, 1.0, kind, law), room).load
    k = float(max(n, 1))
    d = design(pair, mu, 0.0, k, kind, law)
    if n == 0:
        return Followed(d, 0, math.inf, theta0, theta0, math.inf, NONE, 0)
    x0, x1 = theta0, UPRIGHT if kind == BENT else TURNED
    found = bracket(d, x0, x1, room)
    if not math.isnan(found.fold_a):
        a, b = found.fold_a, found.fold_b
        fold = zero(
            value, a, value(a, d, room, SQUARE), b, value(b, d, room, SQUARE), a, math.nan, True, d, room, SQUARE
        )
        d = design(pair, mu, fold, k, FOLDED, law)
        x1 = math.sqrt(fold - theta0)
        x0 = -x1
        found = bracket(d, x0, x1, room)
    x_end, code = end(d, found, x0, x1, room)
    j = 0
    if kind != BENT:
        j, x_end = first_crossing(d, pair, x0, x_end, room)
    if j > 0:
        code = OTHER
    load_end = load_e if x_end == x0 else spot(x_end, d, room).load
    return Followed(d, n, load_e, x0, x_end, load_end, code, j)


def design(pair: Twist, mu: float, theta_f: float, k: float, kind: int, law: int) -> Design:
    """Return a contact with neighbour k."""
    return Design(pair.eta / k, pair.beta / k, pair.lam / k, pair.sa, pair.ca, pair.theta0, mu, theta_f, k, kind, law)


def value(x: float, d: Design, room: Room, what: int) -> float:
    """Return one of the values at a path parameter."""
    return spot(x, d, room)[what]


def first_engagement(pair: Twist) -> tuple[int, float]:
    """Return the neighbour that is met first and its engagement twist; 0 and inf where there is none."""
    k, best = 0, math.inf
    for n in range(1, max(1, int(reach(pair, FLOAT))) + 1):
        on, phi = engages(Twist(pair.eta, pair.beta, pair.lam, pair.sa, pair.ca, pair.theta0, float(n)), FLOAT)
        if on and phi < best:
            k, best = n, phi
    return k, best


def sample(x0: float, x1: float, steps: Array, room: Room) -> int:
    """Put samples of a path into the room, from its second place on (the first is for single looks)."""
    x = room.x
    for j in range(steps.size):
        x[j + 1] = x0 + (x1 - x0) * steps[j]
    return steps.size + 1


def bracket(d: Design, x0: float, x1: float, room: Room) -> Bracket:
    """Bracket the end of a path, and the fold of an open one; closely only where a coarse look settles nothing."""
    m = sample(x0, x1, FOLDED_COARSE_STEPS if d.kind == FOLDED else COARSE_STEPS, room)
    looks(d, room, 1, m)
    first = first_not_positive(room.least, m)
    settled = first < m and calm(room, first)
    if d.kind == OPEN:
        turned = first_not_positive(room.square, m)
        # the path bends back before it has ended: what comes before is looked at on the folded path
        if turned == first and 1 < first < m and smooth(room, first - 1, m) and falls(room, first, m):
            a, b = float(room.x[first - 1]), float(room.x[first])
            return Bracket(a, b, math.nan, math.nan, math.nan, math.nan, a, b)
        settled = settled and smooth(room, first, m)
    if settled:
        return around(room, first, m)
    return closely(d, x0, x1, room)


def first_not_positive(values: Array, m: int) -> int:
    """First sample at which values are not above zero; m where they all are."""
    for i in range(1, m):
        if not values[i] > 0:
            return i
    return m


def around(room: Room, first: int, m: int) -> Bracket:
    """Bracket of an end at the sample ``first``."""
    x, low, nan = room.x, room.least, math.nan
    if first == m:
        return Bracket(nan, nan, nan, nan, nan, nan, nan, nan)
    i, h = max(first - 1, 1), max(first - 2, 1)
    a, b, fa, fb = float(x[i]), float(x[first]), float(low[i]), float(low[first])
    return Bracket(a, b, fa, fb, float(x[h]), float(low[h]) if h < i else nan, nan, nan)


def calm(room: Room, first: int) -> bool:
    """Whether no margin can vanish between the samples, up to the sample ``first`` that has ended the path.

    In the last interval, before that sample, the margins that end the path there may.
    """
    for v in (room.rate, room.drive, room.tip, room.side, room.turn):
        for s in range(3, first + 1):
            a, b, c = v[s - 2], v[s - 1], v[s]
            bend = abs(c - 2 * b + a) * SAFETY
            if not (a > bend and b > bend) or (not c > bend and (c > 0 or s != first)):
                return False
    return True


def bend_at(room: Room, i: int, m: int) -> float:
    """By how much the squared root may differ from its samples in the interval from i to i + 1."""
    v, bend = room.square, 0.0
    for s in (max(i, 2), min(i + 1, m - 2)):
        if i <= s <= i + 1:
            bend = max(bend, abs(v[s + 1] - 2 * v[s] + v[s - 1]) * SAFETY)
    return bend


def smooth(room: Room, stop: int, m: int) -> bool:
    """Whether the squared root stays above zero between the samples up to ``stop``."""
    v = room.square
    for i in range(1, min(stop, m - 1)):
        bend = bend_at(room, i, m)
        if not (v[i] > bend and v[i + 1] > bend):
            return False
    return True


def falls(room: Room, stop: int, m: int) -> bool:
    """Whether the squared root falls through zero just once between the sample before ``stop`` and that one."""
    bend = bend_at(room, stop - 1, m)
    return bool(room.square[stop - 1] > bend and -room.square[stop] > bend)


def closely(d: Design, x0: float, x1: float, room: Room) -> Bracket:
    """Bracket the end and the fold of a path by close samples, and by the dips between them."""
    m = sample(x0, x1, FOLDED_STEPS if d.kind == FOLDED else STEPS, room)
    looks(d, room, 1, m)
    first = first_not_positive(room.least, m)
    found = around(room, first, m)
    a, b, fa, fb, c, fc, fold_a, fold_b = found
    for v, what in ((room.rate, 2), (room.drive, 3), (room.tip, 4), (room.side, 5), (room.turn, 6)):
        # up to the sample that has ended the path: before it another margin may have dipped
        low, bottom = dip(v, d, room, what, min(first, m - 2), b)
        if not math.isnan(low):
            a, b, c, fc = low, bottom, low, math.nan
            fa, fb = spot(a, d, room)[LEAST], spot(b, d, room)[LEAST]
    if d.kind == OPEN:
        x, turned = room.x, first_not_positive(room.square, m)
        if turned < m:
            fold_a, fold_b = float(x[max(turned - 1, 1)]), float(x[turned])
        low, bottom = dip(room.square, d, room, SQUARE, min(first - 1, m - 2), fold_b)
        if not math.isnan(low):
            fold_a, fold_b = low, bottom
        if b > a and math.isnan(fold_a):
            # a fold and its way back within the interval in which the path ends
            for part in range(1, 8):
                at = a + (b - a) * (part / 8)
                if not spot(at, d, room)[SQUARE] > 0:
                    fold_a, fold_b = a, at
                    break
        # a contact that has ended already where it begins, or well before the fold, does not get there
        if turned < m and (first == 1 or turned > first + 4):
            fold_a = fold_b = math.nan
    return Bracket(a, b, fa, fb, c, fc, fold_a, fold_b)


def dip(v: Array, d: Design, room: Room, what: int, last: int, limit: float) -> tuple[float, float]:
    """First dip below zero between samples up to ``last`` and before ``limit``: the sample before it and a place in it.

    Looked at are local minima that a parabola takes below half their value. No numbers where there is none.
    """
    x = room.x
    for i in range(2, last + 1):
        left, middle, right = v[i - 1], v[i], v[i + 1]
        if middle > 0 and middle <= left and middle < right:
            bottom = middle - (right - left) * (right - left) / (8 * (right + left - 2 * middle))
            if bottom < DEEP * middle:
                at = lowest(d, room, what, float(x[i - 1]), float(x[i]), float(x[i + 1]), float(middle))
                if not math.isnan(at) and not at > limit:
                    return float(x[i - 1]), at
    return math.nan, math.nan


def lowest(d: Design, room: Room, what: int, a: float, b: float, c: float, fb: float) -> float:
    """Place where a value that is lowest at ``b``, of a < b < c, is below zero; NaN for none (golden section)."""
    ratio = 0.3819660112501051
    while c - a > 1e-9 * abs(b) + 1e-12:
        x = b + ratio * (c - b) if c - b > b - a else b - ratio * (b - a)
        fx = spot(x, d, room)[what]
        if fx < 0:
            return x
        if fx < fb:
            a, c = (b, c) if x > b else (a, b)
            b, fb = x, fx
        elif x > b:
            c = x
        else:
            a = x
    return math.nan


def end(d: Design, found: Bracket, x0: float, x1: float, room: Room) -> tuple[float, int]:
    """Solve for the end of a path in its bracket and name it."""
    if math.isnan(found.a):
        # a folded path that reaches its far end has come back to theta0, where the spring is at rest
        return x1, RELEASED if d.kind == FOLDED else RANGE
    x = x0
    if found.b > found.a:
        x = zero(value, found.a, found.fa, found.b, found.fb, found.c, found.fc, True, d, room, LEAST)
    code = named(d, x, room)
    return x, STATIC if code == FRICTIONAL and found.b == found.a else code


def named(d: Design, x: float, room: Room) -> int:
    """Code of the margin that vanishes at the end; where two coincide, of the first."""
    values = spot(x, d, room)
    least, which = math.inf, 0
    for n in range(5):
        v = values[2 + n]
        if not v > COINCIDE:
            return MARGINS[n]
        if v < least:
            least, which = v, n
    return MARGINS[which]


def first_crossing(d: Design, pair: Twist, x0: float, x_end: float, room: Room) -> tuple[int, float]:
    """Find where another neighbour's tip-side contact comes in first before ``x_end``: its number (0 for none), place.

    Parameters
    ----------
    pair
        The contact with the next neighbour, lengths in pitches.
    x0, x_end
        Path parameters of engagement and end.
    """
    far = max(1, int(reach(pair, FLOAT)))
    folded = d.kind == FOLDED
    if far < 2 or not x_end > x0:
        return 0, x_end
    if d.k == 1 and far < NEAR and clear(d, pair, far, x0, x_end, FOLDED_CLEAR if folded else CLEAR, room):
        return 0, x_end
    m = lines(d, pair, x0, x_end, FOLDED_SAMPLES if folded else SAMPLES, room)
    x, near, found, best = room.x, room.near, 0, x_end
    for j in range(1, far + 1):
        before = math.nan
        for s in range(1, m):
            now = condition(room, s, float(j))
            if now >= 0 and not before >= 0 and s > 1 and j != d.k and j <= max(near[s - 1], near[s]):
                a, b = float(x[s - 1]), float(x[s])
                fa, fb = apart(a, d, pair, float(j), room), apart(b, d, pair, float(j), room)
                at = a if fa <= 0 else zero(apart, a, fa, b, fb, a, fa, True, d, pair, float(j), room)
                if at < best and joined(at, d, pair, float(j), room):
                    found, best = j, at
            before = now
    return found, best


def lines(d: Design, pair: Twist, x0: float, x_end: float, samples: int, room: Room) -> int:
    """Note what the contact conditions of all neighbours are made of, at samples of a path, and the tip's reach.

    The condition times j is linear in j but for the cosine and sine of j phi (:func:`condition`).
    """
    x, k = room.x, d.k
    for s in range(samples):
        x[s + 1] = x0 + (x_end - x0) * (s / (samples - 1))
    m = samples + 1
    roots(d, room, 1, m)
    for s in range(1, m):
        S, H, G, cs = float(room.S[s]), float(room.H[s]), float(room.G[s]), float(room.cs[s])
        u = S / (H + float(room.q[s]))
        if k > 1:
            u = math.tan(math.atan(u) / k)
            r = pair.root(float(room.theta[s]), FLOAT)
            S, H, G = r.S, r.H, r.G
        w = 1 / (1 + u * u)
        lean = pair.sa * pair.ca * cs
        room.H[s], room.S[s], room.lean[s], room.G[s] = H + lean, S, lean, G / 2
        room.cos[s] = room.cosj[s] = (1 - u * u) * w
        room.sin[s] = room.sinj[s] = 2 * u * w
        room.near[s] = reach_at(pair, cs)
    return m


def condition(room: Room, s: int, j: float) -> float:
    """Contact condition of neighbour j, times j, at a sample; the next call there is for the next neighbour."""
    c, h = room.cosj[s], room.sinj[s]
    room.cosj[s] = c * room.cos[s] - h * room.sin[s]
    room.sinj[s] = h * room.cos[s] + c * room.sin[s]
    return float((room.G[s] - j * room.S[s]) * c + (room.H[s] - j * room.lean[s]) * h - room.G[s])


def clear(d: Design, pair: Twist, far: int, x0: float, x_end: float, samples: int, room: Room) -> bool:
    """Whether no other neighbour comes near: the conditions stay below zero by more than they bend."""
    m = lines(d, pair, x0, x_end, samples, room)
    near = room.near
    for j in range(1, far + 1):
        a = b = math.nan
        for s in range(1, m):
            c = condition(room, s, float(j))
            away = max(a, b, c) < -AWAY * abs(c - 2 * b + a) or max(near[s - 2], near[s - 1], near[s]) < j
            if j > 1 and s > 2 and not away:
                return False
            a, b = b, c
    return True

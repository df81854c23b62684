"""Contacts of other neighbours that come in along a path, by the signs of their contact conditions.

The samples depend on the geometry alone and not on where friction ends the path, so that all coefficients of friction
find the same crossings.
"""

from __future__ import annotations

import math

from squama.model.bracket import zero
from squama.model.evaluation import (
    DEEPEST,
    MOST_PARTS,
    PART,
    Design,
    Room,
    apart,
    joined,
    onward,
    roots,
    sample,
    samples,
)
from squama.model.neighbours import reach, reach_at
from squama.model.paths import FLOAT, Twist

NEAR = 7
"""Number of neighbours within reach from which on the quick check is skipped."""
AWAY = 0.5
"""Share of the curvature seen in three samples by which a condition must be away from zero (a parabola needs an
eighth).
"""
SWING = 0.12
"""Half the square of the largest angle (rad) by which a neighbour may turn between two samples."""


def first_crossing(d: Design, pair: Twist, x0: float, x1: float, x_end: float, room: Room) -> tuple[int, float]:
    """Find the first tip-side contact of another neighbour before ``x_end``: its number (0 for none), and the place.

    ``pair`` is the contact with the next neighbour, lengths in pitches; ``x0``, ``x1``, ``x_end`` are the path
    parameters of engagement, of the last sample, and of the end.
    """
    far = max(1, int(reach(pair, FLOAT)))
    if far < 2 or not x_end > x0:
        return 0, x_end
    if d.k == 1 and far < NEAR and clear(d, pair, far, x0, x1, x_end, room):
        return 0, x_end
    parts = 0
    for i in range(samples(d.kind) - 1):
        low, high, n, level = sample(i, d.kind, x0, x1), sample(i + 1, d.kind, x0, x1), 0, 0
        while level > 0 or n == 0:
            width = (high - low) * 0.5**level
            a = low + n * width
            if not a < x_end:
                return 0, x_end
            for s in range(PART + 1):
                room.x[s + 1] = a + width * (s / PART)
            lines(d, pair, PART + 2, room)
            parts += 1
            found, at = rises(d, pair, far, level < DEEPEST and parts < MOST_PARTS, room)
            if found < 0:
                n, level = 2 * n, level + 1
                continue
            if found > 0:
                return (found, at) if at < x_end else (0, x_end)
            n, level = onward(n, level)
    return 0, x_end


def rises(d: Design, pair: Twist, far: int, halve: bool, room: Room) -> tuple[int, float]:
    """Return the first neighbour that comes in between the samples of an interval (0 for none), and the place.

    The number is -1 if the samples are too far apart to decide and the interval may be halved.
    """
    x, cos, sin, m = room.x, room.cos, room.sin, PART + 2
    turn = 0.0
    for s in range(2, m):
        turn = max(turn, 1 - (cos[s] * cos[s - 1] + sin[s] * sin[s - 1]))
    found, best = 0, math.inf
    for j in range(1, far + 1):
        for s in range(1, m):
            room.g[s] = condition(room, s, float(j), pair.thickness)
        if j == d.k or j > max(room.near[1], room.near[m - 1]):
            continue
        if halve and not turn * j * j < SWING:
            return -1, math.inf
        bend = 0.0
        for s in range(3, m):
            bend = max(bend, AWAY * abs(room.g[s] - 2 * room.g[s - 1] + room.g[s - 2]))
        for s in range(2, m):
            before, now = room.g[s - 1], room.g[s]
            if halve and not (abs(before) > bend and abs(now) > bend):
                return -1, math.inf
            if now >= 0 and before < 0:
                a, b = float(x[s - 1]), float(x[s])
                fa, fb = apart(a, d, pair, float(j), room), apart(b, d, pair, float(j), room)
                at = a if fa <= 0 else zero(apart, a, fa, b, fb, a, fa, True, d, pair, float(j), room)
                if at < best and joined(at, d, pair, float(j), room):
                    found, best = j, at
    return found, best


def lines(d: Design, pair: Twist, m: int, room: Room) -> None:
    """Store the terms of all neighbours' contact conditions at the samples 1..m - 1, and the reach of the tip.

    The condition times j is linear in j except for the cosine and sine of j phi (:func:`condition`).
    """
    roots(d, room, 1, m)
    for s in range(1, m):
        S, H, G, cs = float(room.S[s]), float(room.H[s]), float(room.G[s]), float(room.cs[s])
        u = S / (H + float(room.q[s]))
        if d.k > 1:
            u = math.tan(math.atan(u) / d.k)
            r = pair.root(float(room.theta[s]), FLOAT)
            S, H, G = r.S, r.H, r.G
        S = S + pair.thickness
        w = 1 / (1 + u * u)
        lean = pair.sa * pair.ca * cs
        room.H[s], room.S[s], room.lean[s], room.G[s] = H + lean, S, lean, G / 2
        room.cos[s] = room.cosj[s] = (1 - u * u) * w
        room.sin[s] = room.sinj[s] = 2 * u * w
        room.near[s] = reach_at(pair, cs)


def condition(room: Room, s: int, j: float, thickness: float) -> float:
    """Return the contact condition of neighbour j, times j, at sample s.

    Each call prepares the next neighbour, so calls for a sample must count j up from 1.
    """
    c, h = room.cosj[s], room.sinj[s]
    room.cosj[s] = c * room.cos[s] - h * room.sin[s]
    room.sinj[s] = h * room.cos[s] + c * room.sin[s]
    return float((room.G[s] + thickness - j * room.S[s]) * c + (room.H[s] - j * room.lean[s]) * h - room.G[s])


def clear(d: Design, pair: Twist, far: int, x0: float, x1: float, x_end: float, room: Room) -> bool:
    """Return whether all other neighbours stay away: their conditions are below zero by more than their curvature."""
    m = 1
    while m < 4 or (m <= samples(d.kind) and room.x[m - 1] < x_end):
        room.x[m] = sample(m - 1, d.kind, x0, x1)
        m += 1
    lines(d, pair, m, room)
    near = room.near
    for j in range(1, far + 1):
        a = b = math.nan
        for s in range(1, m):
            c = condition(room, s, float(j), pair.thickness)
            away = max(a, b, c) < -AWAY * abs(c - 2 * b + a) or max(near[s - 2], near[s - 1], near[s]) < j
            if j > 1 and s > 2 and not away:
                return False
            a, b = b, c
    return True

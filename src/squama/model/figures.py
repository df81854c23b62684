"""Results of one design at its cut-off: place, load, force, torque and frictional work.

Executed by Python for few designs and compiled for many, as :mod:`squama.model.follow`.

The work is integrated by Gauss rules, each with a measure of its convergence. For a path that ends in a frictional lock
the weight z/(1-z) on [0, 1 - margin] contains the pole and the zero of the integrand, so that a few nodes suffice; for
other paths the rule is Legendre's in y = -ln(1 - z), and if no rule converges the range of y is divided.
"""

from __future__ import annotations

import functools
import math
from typing import NamedTuple

import numpy as np

from squama.model.energy import TOLERANCE, beyond
from squama.model.evaluation import FOLDED, Design, Room, looks, spot
from squama.model.follow import FRICTIONAL, KINEMATIC, Followed, follow
from squama.model.paths import FLOAT, Twist
from squama.types import Array

LOCKING = (FRICTIONAL, KINEMATIC)
"""Ends before which paths are cut off."""
NEAREST = 1e-13
"""Smallest share of the path parameter left before a lock: some hundred times its error."""
SIZES = (14, 26, 48, 96)
LEGENDRE_SIZES = (26, 48, 96, 192, 512)
ROUGH, ROUGH_PLAIN = 3e-8, 5e-9
"""Last terms of the series over the integral at which a rule counts as converged: pole rules, Legendre's rules.

The error of a Gauss rule is about that of twice as many terms; the gain depends on how steadily the terms fall. Of 600
000 random designs of wide ranges two had an error of 2e-9, 33 an error above 1e-10, most of 1e-12.
"""
PARTS, DEPTH, MOST_PARTS = 16, 6, 32
"""Parts into which y is divided if one rule does not converge; how many times; and how many parts of a path may be
divided again: more are due to rounding, not to a corner.
"""


class Rules(NamedTuple):
    """Quadrature rules in a row: ``sizes``; rows of nodes, weights and the last two series terms; limit ``rough``."""

    sizes: Array
    nodes: Array
    rough: float


class Common(NamedTuple):
    """Data common to all designs: ``kind`` is BENT for bending, else OPEN, ``sign`` the sense, ``law`` an index.

    ``margin`` is the fraction of the path left before a lock; ``cut`` and ``plain`` are the rules for paths cut off
    before their pole, and for the others.
    """

    kind: int
    sign: float
    law: int
    with_figures: bool
    margin: float
    cut: Rules
    plain: Rules


class Figures(NamedTuple):
    """Inclination ``theta`` and ``load`` per pitch (rad) at the cut-off, ``f0`` = f l/K_theta, ``torque``, ``work``.

    Torque and work are the scales', over K_theta and K_theta/d.
    """

    theta: float
    load: float
    f0: float
    torque: float
    work: float


def fill(designs: Array, low: int, high: int, common: Common, room: Room, out: Array, whole: Array) -> None:
    """Solve the designs low..high and store results in ``out`` and ``whole``, in the order of :class:`Answers`.

    ``designs`` has the rows eta, beta, lam, alpha, theta0, mu, thickness.
    """
    for i in range(low, high):
        # plain floats, because they are faster in Python
        eta, beta, lam = float(designs[0, i]), float(designs[1, i]), float(designs[2, i])
        alpha, theta0, mu = float(designs[3, i]), float(designs[4, i]), float(designs[5, i])
        thickness = float(designs[6, i])
        sa, ca = common.sign * math.sin(alpha), math.cos(alpha)
        pair = Twist(eta, beta, lam, sa, ca, theta0, 1.0, thickness)
        f = follow(pair, mu, common.kind, common.law, room)
        out[0, i], out[1, i], out[2, i], out[3, i], out[4, i] = f.load_e, f.load_end, f.x0, f.x_end, f.d.theta_f
        whole[0, i], whole[1, i], whole[2, i], whole[3, i] = f.code, f.k, f.crossing, f.d.kind
        if common.with_figures:
            c = figures(f, common.margin, common.cut, common.plain, room)
            out[5, i], out[6, i], out[7, i], out[8, i], out[9, i] = c.theta, c.load, c.f0, c.torque, c.work


def figures(f: Followed, margin: float, cut: Rules, plain: Rules, room: Room) -> Figures:
    """Return the results at the cut-off of a followed path; arguments as of :class:`Common`."""
    d = f.d
    if f.k == 0:
        return Figures(d.theta0, 0.0, 0.0, 0.0, 0.0)
    x_c = asked = cutoff(f, margin)
    at = spot(x_c, d, room)
    if f.code in LOCKING:
        # leave more if rounding would hide on which side of the lock the path is
        left, least = f.x_end - x_c, NEAREST * (abs(f.x0) + abs(f.x_end))
        while x_c > f.x0 and not (left >= least and at.least > 0):
            left = max(2 * left, least)
            x_c = f.x_end - left
            at = spot(x_c, d, room)
    if not x_c > f.x0:
        # a path that ends where it begins bears no load yet
        return Figures(d.theta0, f.load_e, 0.0, 0.0, 0.0)
    work = 0.0
    if d.mu > 0:
        # the rules are made for this margin only
        rules = cut if x_c == asked else Rules(cut.sizes[:0], cut.nodes, cut.rough)
        work = worked(f, x_c, rules, plain, room)
    return Figures(at.theta, at.load, at.force * d.eta, at.torque * d.k, work)


def cutoff(f: Followed, margin: float) -> float:
    """Return the path parameter of the cut-off, as :func:`squama.model.energy.cutoff`."""
    d = f.d
    if f.code not in LOCKING:
        return f.x_end
    if d.kind == FOLDED and f.x_end <= 0:
        theta_end = d.theta_f - f.x_end * f.x_end
        return -math.sqrt(d.theta_f - (d.theta0 + (1 - margin) * (theta_end - d.theta0)))
    return f.x0 + (1 - margin) * (f.x_end - f.x0)


def worked(f: Followed, x_c: float, cut: Rules, plain: Rules, room: Room) -> float:
    """Return the frictional work up to the cut-off, with as many nodes as it needs."""
    d, reach = f.d, f.x_end - f.x0
    if f.code == FRICTIONAL and (d.kind != FOLDED or f.x_end > 0):
        # the force has its pole at the end
        first = 0
        for size in cut.sizes:
            total, last = by_rule(d, f.x0, reach, 0.0, cut, first, size, room)
            if last <= cut.rough * abs(total):
                return total
            first += size
    else:
        h = 1e-4 * reach
        reach += beyond(spot(f.x_end, d, room).drive, spot(f.x_end - h, d, room).drive, h, FLOAT)
    y_end, first = -math.log1p(-min((x_c - f.x0) / reach, 1 - 1e-15)), 0
    for size in plain.sizes:
        total, last = by_rule(d, f.x0, reach, y_end, plain, first, size, room)
        if last <= plain.rough * abs(total):
            return total
        first += size
    return in_parts(d, f.x0, reach, y_end, plain, room)


def by_rule(
    d: Design, x0: float, reach: float, y_end: float, rule: Rules, first: int, size: int, room: Room
) -> tuple[float, float]:
    """Integrate the power over y from 0 to ``y_end``, or directly over the path if ``y_end`` is 0.

    Returns the integral and the larger of the last two terms of its series. y counts from ``x0``; the pole lies at x0 +
    ``reach``.
    """
    x, g = room.x, room.g
    nodes, weights, lasts, before = rule.nodes[0], rule.nodes[1], rule.nodes[2], rule.nodes[3]
    for j in range(size):
        part = nodes[first + j]
        if y_end == 0:
            x[j + 1], g[j + 1] = x0 + reach * part, reach
        else:
            short = -math.expm1(-y_end * part)
            x[j + 1], g[j + 1] = x0 + reach * short, y_end * (reach * (1 - short))
    looks(d, room, 1, size + 1)
    power, total, last, last_but_one = room.power, 0.0, 0.0, 0.0
    for j in range(size):
        v = power[j + 1] * g[j + 1]
        total += weights[first + j] * v
        last += lasts[first + j] * v
        last_but_one += before[first + j] * v
    return total, max(abs(last), abs(last_but_one))


def in_parts(d: Design, x0: float, reach: float, y_end: float, rule: Rules, room: Room) -> float:
    """Integrate a path for which no single rule converges: the range of y is divided where needed, repeatedly."""
    # columns of the room that the rule does not use
    lows, before, works, lasts = room.near, room.lean, room.cosj, room.sinj
    total, whole, width, n = 0.0, 0.0, y_end, 1
    lows[0] = 0.0
    for depth in range(DEPTH):
        width, rough = width / PARTS, 0
        for i in range(n * PARTS):
            ahead = reach * math.exp(-(lows[i // PARTS] + width * (i % PARTS)))
            works[i], lasts[i] = by_rule(d, x0 + (reach - ahead), ahead, width, rule, 0, rule.sizes[0], room)
            whole += abs(works[i]) if depth == 0 else 0.0
        for i in range(n * PARTS):
            rough += 1 if lasts[i] > TOLERANCE * whole else 0
        # more are no corner but rounding
        last, parts = depth == DEPTH - 1 or rough > MOST_PARTS, n * PARTS
        for i in range(n):
            before[i] = lows[i]
        n = 0
        for i in range(parts):
            if last or not lasts[i] > TOLERANCE * whole:
                total += works[i]
            else:
                lows[n] = before[i // PARTS] + width * (i % PARTS)
                n += 1
        if n == 0:
            break
    return total


def _recurrence(x: Array, w: Array, n: int) -> tuple[Array, Array]:
    """Return the recurrence coefficients of the orthonormal polynomials of a discrete measure (Stieltjes)."""
    a, b = np.zeros((2, n))
    before, now = np.zeros_like(x), np.full_like(x, 1 / np.sqrt(w.sum()))
    for k in range(n):
        a[k] = (w * x * now * now).sum()
        after = (x - a[k]) * now - (b[k - 1] if k else 0.0) * before
        b[k] = np.sqrt((w * after * after).sum())
        before, now = now, after / b[k]
    return a, b


def _gauss(x: Array, w: Array, n: int) -> Array:
    """Return the Gauss rule of n nodes for a measure: nodes, weights, and rows for the last two terms of the series."""
    a, b = _recurrence(x, w, n)
    nodes, vectors = np.linalg.eigh(np.diag(a) + np.diag(b[:-1], 1) + np.diag(b[:-1], -1))
    first = vectors[0] * np.sqrt(w.sum())
    # column i of the eigenvectors is sqrt(weight i) times the orthonormal polynomials at node i
    root = np.sqrt(w.sum())
    return np.stack([nodes, first * first, root * first * vectors[-1], root * first * vectors[-2]])


def _legendre(n: int) -> tuple[Array, Array, Array, Array]:
    """Return nodes and weights of Legendre's rule on [-1, 1], and its last two polynomials there."""
    angle = np.pi * (np.arange(n) + 0.75) / (n + 0.5)
    for _ in range(6):
        x, sine = np.cos(angle), np.sin(angle)
        older, before, last = np.zeros(n), np.zeros(n), np.ones(n)
        for k in range(1, n + 1):
            older, before, last = before, last, ((2 * k - 1) * x * last - (k - 1) * before) / k
        slope = n * (before - x * last) / sine
        angle = angle + last / slope
    return x, 2 / (slope * slope), before, older


@functools.lru_cache(maxsize=32)
def pole_rules(margin: float) -> Rules:
    """Return rules for the weight z/(1-z) on [0, 1 - margin]; their weights are divided by that weight."""
    y, w, *_ = _legendre(400)
    last = -np.log(margin)
    y, w = last * (y + 1) / 2, last * w / 2
    z = -np.expm1(-y)
    rules = [_gauss(z, w * z, n) for n in SIZES]
    parts = np.concatenate(rules, axis=1)
    parts[1:] *= (1 - parts[0]) / parts[0]
    return Rules(np.array(SIZES), np.ascontiguousarray(parts), ROUGH)


@functools.cache
def legendre_rules() -> Rules:
    """Return Legendre's rules on [0, 1]."""
    rules = []
    for n in LEGENDRE_SIZES:
        y, w, last, before = _legendre(n)
        rules.append(
            np.stack([(y + 1) / 2, w / 2, w / 2 * last * np.sqrt(2 * n - 1), w / 2 * before * np.sqrt(2 * n - 3)])
        )
    return Rules(np.array(LEGENDRE_SIZES), np.ascontiguousarray(np.concatenate(rules, axis=1)), ROUGH_PLAIN)

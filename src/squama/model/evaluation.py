"""Evaluation of one design's path: at a single place with plain floats, or at many places with arrays.

Compiled code has its own versions of these functions (``squama.batch.kernel``), over the same rows.
"""

from __future__ import annotations

import functools
import math
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from squama.model.bending import Bend
from squama.model.laws import LAWS
from squama.model.mechanics import forces
from squama.model.neighbours import gap, on_edges
from squama.model.paths import ARRAY, FLOAT, FoldedTwist, Ops, Twist

Column = np.ndarray[tuple[int], np.dtype[np.float64]]
OPEN, FOLDED, BENT = range(3)
"""Kinds of paths: twisting without a fold, twisting through a fold, bending."""
NAMES = tuple(LAWS)
"""Names of the force laws, by index."""
SIZE = 536
"""Number of places of a room: as many as the largest rule has nodes, and not a multiple of 512, which makes caches
collide.
"""
STEPS = np.concatenate([np.linspace(0.0, 0.55, 8)[:-1], np.linspace(0.55, 1.0, 4)])
"""Samples of an open path as fractions of its parameter; closer together up to about 100 deg, where most paths end."""
EVEN = 8
"""Number of the first samples of an open path that are evenly spaced."""
FOLDED_STEPS = np.linspace(0.0, 1.0, 17)
"""Samples of a folded path, on which the twist grows large and farther neighbours come and go."""
PART, DEEPEST, MOST_PARTS = 4, 28, 400
"""Steps in a refined interval, largest number of halvings, and largest number of intervals."""
LEAST, SQUARE, RATE, DRIVE, TIP, SIDE, TURN = range(7)
"""Indices of the fields of a :class:`Spot`: the smallest margin, the squared root, and the margins."""


class Design(NamedTuple):
    """One contact, lengths in units of ``k`` pitches; ``kind`` is OPEN, FOLDED or BENT, ``law`` a force law's index."""

    eta: float
    beta: float
    lam: float
    sa: float
    ca: float
    theta0: float
    mu: float
    theta_f: float
    k: float
    kind: int
    law: int
    thickness: float = 0.0


class Spot(NamedTuple):
    """Values at one place of a path: margins, load and forces; lengths in units of k pitches, ``load`` per pitch (rad).

    ``least`` is the smallest margin; ``square`` is the squared root of the contact condition, negative beyond a fold;
    ``drive`` = -(M_N + mu M_f); ``power`` is the frictional work per unit of the path parameter.
    """

    least: float
    square: float
    rate: float
    drive: float
    tip: float
    side: float
    turn: float
    theta: float
    load: float
    force: float
    torque: float
    power: float


FIELDS = (
    *("x", "least", "square", "rate", "drive", "tip", "side", "turn", "theta", "load", "force", "torque", "power"),
    *("sn", "cs", "S", "H", "G", "q", "per_x", "lean", "cos", "sin", "cosj", "sinj", "near", "g"),
)
"""Columns of a room: places and the values there, terms of the contact condition, working columns."""


class Room:
    """Working arrays for the samples of one path: columns by the names of :data:`FIELDS`."""

    def __init__(self) -> None:
        for name in FIELDS:
            setattr(self, name, np.empty(SIZE))

    if TYPE_CHECKING:

        def __getattr__(self, name: str) -> Column: ...


def samples(kind: int) -> int:
    """Return the number of first samples of a path."""
    return FOLDED_STEPS.size if kind == FOLDED else STEPS.size


def sample(i: int, kind: int, x0: float, x1: float) -> float:
    """Return sample i of a path from x0 to x1; it does not depend on where the path ends."""
    return float(x0 + (x1 - x0) * (FOLDED_STEPS[i] if kind == FOLDED else STEPS[i]))


def onward(n: int, level: int) -> tuple[int, int]:
    """Return the part after part ``n`` of an interval halved ``level`` times: number, level; 1, 0 after all."""
    n += 1
    while level > 0 and n % 2 == 0:
        n, level = n // 2, level - 1
    return n, level


def row(d: Design) -> Any:
    """Return the row of a design, which evaluates its path."""
    if d.kind == BENT:
        return Bend(d.eta, d.beta, d.lam, d.sa, d.ca, d.theta0)
    if d.kind == FOLDED:
        return FoldedTwist(d.eta, d.beta, d.lam, d.sa, d.ca, d.theta0, d.theta_f, 1.0, d.thickness)
    return Twist(d.eta, d.beta, d.lam, d.sa, d.ca, d.theta0, 1.0, d.thickness)


def spot(x: float, d: Design, room: Room) -> Spot:  # noqa: ARG001
    """Evaluate one place of a path."""
    try:
        return _seen(d, row(d), x, FLOAT)
    except ZeroDivisionError:
        # at the pole of the friction force
        with np.errstate(all="ignore"):
            return Spot(*map(float, _seen(d, row(d), np.float64(x), ARRAY)))


def _seen(d: Design, here: Any, x: float | Column, ops: Ops) -> Spot:
    """Evaluate one place, or many."""
    law = NAMES[d.law]
    if d.kind == BENT:
        pt = here.point(x, law, ops)
        square = 1.0
    else:
        theta, r, q, per_x = here.solve(x, ops)
        pt = getattr(here, "open", here).at_root(theta, r, q, per_x, law, ops)
        square = r.q2
    tip, side = here.places(pt)
    f = forces(pt, d.theta0, d.mu)
    least = functools.reduce(ops.smaller, (pt.load_rate, f.D, tip, side, pt.turn))
    power = f.f * pt.slip_rate
    return Spot(least, square, pt.load_rate, f.D, tip, side, pt.turn, pt.theta, pt.load / d.k, f.f, f.torque, power)


def looks(d: Design, room: Room, start: int, stop: int) -> None:
    """Evaluate the places room.x[start : stop] and store the values in the room."""
    part = slice(start, stop)
    with np.errstate(all="ignore"):
        seen = _seen(d, row(d), room.x[part], ARRAY)
    for name in ("least", "square", "rate", "drive", "tip", "side", "turn", "power"):
        getattr(room, name)[part] = getattr(seen, name)


def roots(d: Design, room: Room, start: int, stop: int) -> None:
    """Store the terms of the contact condition, and its root, at the places room.x[start : stop]."""
    part = slice(start, stop)
    with np.errstate(all="ignore"):
        theta, r, q, _ = row(d).solve(room.x[part], ARRAY)
    for name, values in (("theta", theta), ("cs", r.cs), ("S", r.S), ("H", r.H), ("G", r.G), ("q", q)):
        getattr(room, name)[part] = values


def meet(x: float, d: Design, room: Room) -> tuple[float, float]:  # noqa: ARG001
    """Return inclination and twist per pitch (rad) at a place of a twisting path."""
    theta, r, q, _ = row(d).solve(x, FLOAT)
    return theta, 2 * math.atan(r.S / (r.H + q)) / d.k


def apart(x: float, d: Design, pair: Twist, j: float, room: Room) -> float:
    """Return the contact condition of neighbour ``j`` at a place of a twisting path, positive before contact."""
    theta, phi = meet(x, d, room)
    return -float(gap(pair, j, theta, phi, FLOAT))


def joined(x: float, d: Design, pair: Twist, j: float, room: Room) -> bool:
    """Return whether the lines of neighbour ``j``, which meet at a place of a twisting path, meet within both edges."""
    theta, phi = meet(x, d, room)
    return bool(on_edges(pair, j, theta, phi, FLOAT))

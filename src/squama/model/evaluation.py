"""What is evaluated of one design: a single place of its path on plain floats, many on arrays.

Compiled code has its own of these functions (``squama.batch.kernel``), over the same rows.
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
"""Kinds of paths."""
NAMES = tuple(LAWS)
"""Force laws in the order of their numbers."""
SIZE = 536
"""Places of a room: as many as the largest rule has nodes, and not a multiple of 512, which processors confuse."""
STEPS = np.concatenate([np.linspace(0.0, 0.55, 8)[:-1], np.linspace(0.55, 1.0, 4)])
"""Samples of an open path as fractions of its parameter; closer together up to about 100 deg, where most end."""
EVEN = 8
"""Samples of an open path up to which their steps are even."""
FOLDED_STEPS = np.linspace(0.0, 1.0, 17)
"""Samples of a folded path, on which the twist grows large and farther neighbours come and go."""
PART, DEEPEST, MOST_PARTS = 4, 28, 400
"""Steps in an interval that is looked at closely, how often it may be halved, and how many there may be."""
LEAST, SQUARE, RATE, DRIVE, TIP, SIDE, TURN = range(7)
"""Fields of a :class:`Spot` by number: the smallest margin, the squared root, and the margins."""


class Design(NamedTuple):
    """One contact, lengths in units of ``k`` pitches; ``kind`` is OPEN, FOLDED or BENT, ``law`` a law's number."""

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
    """One place of a path: margins, and what they leave; lengths in units of k pitches, ``load`` per pitch.

    ``square`` is the squared root of the contact condition, below zero beyond a fold; ``drive`` = -(M_N + mu M_f);
    ``power`` the frictional work per unit of the path parameter.
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
"""Columns of a room: places and what is seen there, terms of the contact condition, what else a path needs."""


class Room:
    """Room for the samples of one path: columns by the names of FIELDS."""

    def __init__(self) -> None:
        for name in FIELDS:
            setattr(self, name, np.empty(SIZE))

    if TYPE_CHECKING:

        def __getattr__(self, name: str) -> Column: ...


def samples(kind: int) -> int:
    """How many samples of a path are looked at first."""
    return FOLDED_STEPS.size if kind == FOLDED else STEPS.size


def sample(i: int, kind: int, x0: float, x1: float) -> float:
    """Sample i of a path from x0 to x1; it does not depend on where the path ends."""
    return float(x0 + (x1 - x0) * (FOLDED_STEPS[i] if kind == FOLDED else STEPS[i]))


def onward(n: int, level: int) -> tuple[int, int]:
    """Return what comes after part ``n`` of an interval halved ``level`` times: number and level; 1, 0 after all."""
    n += 1
    while level > 0 and n % 2 == 0:
        n, level = n // 2, level - 1
    return n, level


def row(d: Design) -> Any:
    """Return the row that follows the path of a design."""
    if d.kind == BENT:
        return Bend(d.eta, d.beta, d.lam, d.sa, d.ca, d.theta0)
    if d.kind == FOLDED:
        return FoldedTwist(d.eta, d.beta, d.lam, d.sa, d.ca, d.theta0, d.theta_f, 1.0, d.thickness)
    return Twist(d.eta, d.beta, d.lam, d.sa, d.ca, d.theta0, 1.0, d.thickness)


def spot(x: float, d: Design, room: Room) -> Spot:  # noqa: ARG001
    """Look at one place."""
    try:
        return _seen(d, row(d), x, FLOAT)
    except ZeroDivisionError:
        # where the friction force has its pole
        with np.errstate(all="ignore"):
            return Spot(*map(float, _seen(d, row(d), np.float64(x), ARRAY)))


def _seen(d: Design, here: Any, x: Any, ops: Ops) -> Spot:
    """Look at one place, or at many."""
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
    """Look at the places room.x[start : stop] and put what is seen beside them."""
    part = slice(start, stop)
    with np.errstate(all="ignore"):
        seen = _seen(d, row(d), room.x[part], ARRAY)
    for name in ("least", "square", "rate", "drive", "tip", "side", "turn", "power"):
        getattr(room, name)[part] = getattr(seen, name)


def roots(d: Design, room: Room, start: int, stop: int) -> None:
    """Terms of the contact condition, and its root, at the places room.x[start : stop]."""
    part = slice(start, stop)
    with np.errstate(all="ignore"):
        theta, r, q, _ = row(d).solve(room.x[part], ARRAY)
    for name, values in (("theta", theta), ("cs", r.cs), ("S", r.S), ("H", r.H), ("G", r.G), ("q", q)):
        getattr(room, name)[part] = values


def meet(x: float, d: Design, room: Room) -> tuple[float, float]:  # noqa: ARG001
    """Inclination and twist per pitch at a place of a twisting path."""
    theta, r, q, _ = row(d).solve(x, FLOAT)
    return theta, 2 * math.atan(r.S / (r.H + q)) / d.k


def apart(x: float, d: Design, pair: Twist, j: float, room: Room) -> float:
    """How far neighbour ``j`` is from being met at a place of a twisting path."""
    theta, phi = meet(x, d, room)
    return -float(gap(pair, j, theta, phi, FLOAT))


def joined(x: float, d: Design, pair: Twist, j: float, room: Room) -> bool:
    """Whether the lines of neighbour ``j``, which meet at a place of a twisting path, do so within both edges."""
    theta, phi = meet(x, d, room)
    return bool(on_edges(pair, j, theta, phi, FLOAT))

r"""Free vibration without material damping: peaks from an exact balance of energies, times by quadrature.

Friction does not depend on speed, so a swing loses the area of the quasi-static loop. With V = y^2/2 + work of the
scales on the branch followed (:mod:`squama.dynamics.branches`), from a turning point A in one sense to B in the other

.. math::
    V_-(A) = V_+(B), \qquad \zeta_n = \frac{1}{4\pi}\ln\frac{U(A_n)}{U(A_{n+1})}, \qquad
    t = \int_{y_e}^{A} \frac{\mathrm dy}{\sqrt{2\,(V(A) - V(y))}} + \arcsin\frac{y_e}{\sqrt{2V}}

with U the elastic energy. y = A - (A - y_e) u^2 takes the root out of the integrand. Time is in 1/omega0 of the bar.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from squama.dynamics.branches import Curve, Side, Way
from squama.dynamics.modes import gauss
from squama.types import Array

RINGS, JAMS, BEYOND = "rings", "jams", "beyond"
"""Ends of a record: all requested swings done, the beam stuck at an angle, a swing beyond the model."""
QUICK = 1e-7
"""Step of Newton's method, over the bracket's width, after which the next step is below rounding."""
POINTS = 32
"""Number of points of the quadrature for a time."""


Limit = tuple[float, str]
"""A magnitude of the angle in the negative sense, and the note for motions beyond it."""


class Sides(NamedTuple):
    """Both senses of load of one system or of n; ``limit`` is where a contact in the negative sense is neglected."""

    plus: Side
    minus: Side
    limit: Limit | None = None

    def of(self, sign: int) -> Side:
        """Return the side for a sign of the load angle."""
        return self.plus if sign > 0 else self.minus


class Decay(NamedTuple):
    """Turning points: times, signed load angles, elastic energies; ``end`` is the reason of the end.

    ``rest`` is the angle at which a jammed beam stays; ``energy`` is that of a swing that goes beyond the model. For n
    systems the first three have the shape (turns, n), NaN beyond the end.
    """

    t: Array
    y: Array
    stored: Array
    end: str | Array
    rest: float | Array = math.nan
    energy: float | Array = math.nan

    def single(self) -> Decay:
        """Return the decay of one system (n = 1) without the NaN values beyond its end."""
        own = ~np.isnan(self.y[:, 0])
        t, y, stored = (v[own, 0] for v in self[:3])
        rest, energy = (float(np.ravel(v)[0]) for v in (self.rest, self.energy))
        return Decay(t, y, stored, str(self.end[0]), rest, energy)


def decay(sides: Sides, *, start: float | Array = 0.0, speed: float | Array = 0.0, turns: int) -> Decay:
    """Follow systems through turning points, released at ``start`` (signed) or passing 0 with a ``speed``.

    ``start`` or ``speed``, numbers or arrays (n,), are of one sign. ``turns`` includes the first turning point. A
    turning point beyond the side's last angle is not followed.
    """
    start, speed = np.broadcast_arrays(*np.atleast_1d(start, speed))
    n, pushed = start.size, bool(speed.any())
    sign = 1 if (speed if pushed else start)[0] > 0 else -1
    found = np.full((3, turns, n), np.nan)
    now, energy, rest = np.zeros(n), np.square(speed) / 2, np.full(n, np.nan)
    end, on = np.full(n, RINGS, "<U6"), np.ones(n, bool)
    for turn in range(turns):
        side = sides.of(sign)
        if turn or pushed:
            over = on & (energy > side.height() * (1 + 1e-12))
            end[over], on = BEYOND, on & ~over
            top, s = rise(side, energy)
            now = now + quarter(side.up, side.y_e, s, energy)
        else:
            top = np.abs(start)
            s = _grown(up, up.load(up.places), up.load, up.rate, top) if (up := side.up) else top
        found[:, turn, on] = np.array([now, sign * top, side.stored(top, s)])[:, on]
        if turn + 1 == turns or not on.any():
            break
        touches = top > side.y_e
        down = side.falling(top) if side.up and touches.any() else None
        had = top * top / 2
        if down:
            had = np.where(touches, down.energy(s), had)
            kept = np.where(on, stays(down, s, top, had), np.nan)
            stuck = ~np.isnan(kept)
            end[stuck], rest[stuck], on = JAMS, sign * kept[stuck], on & ~stuck
        energy = np.where(on, had, energy)
        now = now + quarter(down, side.y_e, s, energy)
        sign = -sign
    return Decay(found[0], found[1], found[2], end, rest, energy)


def root(f: Curve, slope: Curve, a: Array, b: Array, share: float | Array) -> Array:
    """Solve f(s) = 0 for n places between ``a`` (f <= 0) and ``b`` (f >= 0) by Newton's method within brackets.

    It starts at a fraction ``share`` of the way from a to b.
    """
    s, near = a + share * (b - a), QUICK * np.abs(b - a)
    for _ in range(100):
        off = f(s)
        a, b = np.where(off <= 0, s, a), np.where(off >= 0, s, b)
        with np.errstate(all="ignore"):
            new = s - off / slope(s)
        low, high = np.minimum(a, b), np.maximum(a, b)
        new = np.where((new >= low) & (new <= high), new, (a + b) / 2)
        still = np.abs(new - s) <= near
        s = new
        if still.all():
            break
    return np.asarray(s)


def _grown(way: Way, seen: Array, values: Curve, slope: Curve, goal: Array) -> Array:
    """Return the places (n,) where a quantity that grows along a branch reaches ``goal``, or the branch's ends.

    ``seen`` (m, n) are its values at the branch's places.
    """
    i = np.clip((seen < goal).sum(axis=0), 1, way.places.size - 1)
    first, last = way.places[[0, -1], 0]
    a = np.where(goal >= seen[-1], last, way.places[i - 1, 0])
    b = np.where(goal <= seen[0], first, way.places[i, 0])
    low, high = (np.take_along_axis(seen, j[None], axis=0)[0] for j in (i - 1, i))
    share = np.clip((goal - low) / (high - low), 0.0, 1.0)
    return root(lambda s: values(s) - goal, slope, a, b, share)


def rise(side: Side, energy: Array) -> tuple[Array, Array]:
    """Return the turning points (n,) of swings that pass 0 with an energy, and their parameters s."""
    free = np.sqrt(2 * energy)
    if side.up is None:
        return free, free
    s = _grown(side.up, side.up.energies, side.up.energy, side.up.slope, energy)
    return np.where(free <= side.y_e, free, side.up.load(s)), s


def stays(down: Way, s: Array, top: Array, had: Array) -> Array:
    """Return the angles (n,) at which released beams stop before they slide back all the way, or NaN.

    They stop where the energy on the unloading branch equals that at the top, ``had``.
    """
    y = down.places
    above = (down.energies >= had) & (y < s * (1 - 1e-9))
    rest = np.where((s > down.last * (1 + 1e-12)) | (down.slope(s) <= 0), top, np.nan)
    part = np.flatnonzero(above.any(axis=0) & np.isnan(rest))
    if part.size:
        i = np.where(above.any(axis=0), y.size - 1 - np.argmax(above[::-1], axis=0), 0)
        a, b = np.where(i > 0, [y[i, 0], np.minimum(y[np.minimum(i + 1, y.size - 1), 0], s)], s)
        kept = down.load(root(lambda v: had - down.energy(v), lambda v: -down.slope(v), a, b, 0.5))
        rest[part] = kept[part]
    return rest


def quarter(way: Way | None, y_e: float | Array, s: Array, energy: Array) -> Array:
    """Return the times between 0 and turning points at the parameters ``s``, along one branch."""
    free = np.sqrt(2 * energy)
    bare = np.full(energy.shape, math.pi / 2)
    if way is None:
        return bare
    u, w = (v[:, None] for v in gauss(POINTS))
    begin = way.places[0, 0]
    v = s - (s - begin) * u * u
    with np.errstate(all="ignore"):
        contact = (w * 2 * (s - begin) * u * way.rate(v) / np.sqrt(2 * (energy - way.energy(v)))).sum(axis=0)
        return np.where(free > y_e, contact + np.arcsin(np.minimum(y_e / free, 1.0)), bare)


def damping(stored: Array) -> Array:
    """Return the damping ratio of every cycle from the elastic energies of successive peaks in one sense."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(np.log(stored[:-1] / stored[1:]) / (4 * math.pi))

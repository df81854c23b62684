r"""Free vibration without material damping: peaks by an exact map of energies, times by quadratures.

Friction does not depend on speed, so what a swing loses is the area of the quasi-static loop. With V = y^2/2 + work of
the scales on the branch gone (:mod:`squama.dynamics.branches`), from a turning point A in one sense to B in the other

.. math::
    V_-(A) = V_+(B), \qquad \zeta_n = \frac{1}{4\pi}\ln\frac{U(A_n)}{U(A_{n+1})}, \qquad
    t = \int_{y_e}^{A} \frac{\mathrm dy}{\sqrt{2\,(V(A) - V(y))}} + \arcsin\frac{y_e}{\sqrt{2V}}

with U the elastic energy. y = A - (A - y_e) u^2 takes the root out of the integrand. Time is in 1/omega0 of the bar.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from squama.dynamics.branches import Branch, Side, gauss
from squama.model.bracket import bracketed
from squama.types import Array

RINGS, JAMS, BEYOND = "rings", "jams", "beyond"
"""How a record ends: as many swings as were asked, where the beam stays, where a swing goes beyond the model."""


class Sides(NamedTuple):
    """Both senses of load of a system."""

    plus: Side
    minus: Side

    def of(self, sign: int) -> Side:
        """Return the side of a sign."""
        return self.plus if sign > 0 else self.minus


class Decay(NamedTuple):
    """Turning points: times, signed load angles, elastic energies; how it ends, and what it would have taken to go on.

    ``rest`` is where the beam stays that jams; ``energy`` what a swing had that goes beyond the model.
    """

    t: Array
    y: Array
    stored: Array
    end: str
    rest: float = math.nan
    energy: float = math.nan

    @classmethod
    def of(cls, turns: Sequence[tuple[float, float, float]], end: str, rest: float, energy: float) -> Decay:
        """Return a decay by its turning points one after the other."""
        t, y, stored = np.array(turns, float).reshape(-1, 3).T
        return cls(t, y, stored, end, rest, energy)


def decay(sides: Sides, *, start: float = 0.0, speed: float = 0.0, turns: int) -> Decay:
    """Follow a system that is let go at ``start`` (signed), or that passes 0 with a speed, through turning points.

    ``turns`` are counted with the first one. One beyond the side's last angle is not followed.
    """
    t, y, energy = 0.0, start, speed * speed / 2
    found: list[tuple[float, float, float]] = []
    sign = int(math.copysign(1, speed or start))
    if not speed:
        found.append((t, y, sides.of(sign).stored(abs(y))))
    end, rest = RINGS, math.nan
    while len(found) < turns:
        if found:
            side = sides.of(sign)
            kept = stays(side, abs(y)) if abs(y) > side.y_e else None
            if kept is not None:
                end, rest = JAMS, kept * sign
                break
            energy, spent = let_go(side, abs(y))
            t, sign = t + spent, -sign
        side = sides.of(sign)
        if energy > side.height() * (1 + 1e-12):
            end = BEYOND
            break
        top = rise(side, energy)
        t += quarter(side.up, side.y_e, top, energy)
        y = sign * top
        found.append((t, y, side.stored(top)))
    return Decay.of(found, end, rest, energy)


def rise(side: Side, energy: float) -> float:
    """Return the turning point to which a swing comes that passes 0 with an energy."""
    free = math.sqrt(2 * energy)
    if side.up is None or free <= side.y_e:
        return free
    up = side.up
    knots = np.append(up.force.x, side.last)
    i = int(np.searchsorted(knots**2 / 2 + up.work(knots), energy))
    a, b = float(knots[max(i - 1, 0)]), float(knots[min(i, knots.size - 1)])
    if up.energy(b) <= energy:
        return b
    return bracketed(lambda y: up.energy(y) - energy, a, b)


def let_go(side: Side, top: float) -> tuple[float, float]:
    """Return the energy at 0 of a beam let go at a turning point, and the time until there."""
    if top <= side.y_e:
        return top * top / 2, math.pi / 2
    down = side.falling(top)
    energy = down.energy(top)
    return energy, quarter(down, side.y_e, top, energy)


def stays(side: Side, top: float) -> float | None:
    """Return where a beam comes to rest that is let go and does not slide back all the way; None for one that does.

    It stops where the energy on the way back is again what it was at the top.
    """
    down = side.falling(top)
    if top > down.last * (1 + 1e-12) or top + float(down.force(top)) <= 0:
        return top
    y = down.force.x[down.force.x < top * (1 - 1e-9)]
    above = np.flatnonzero(y**2 / 2 + down.work(y) >= down.energy(top))
    if not above.size:
        return None
    i = int(above[-1])
    if i + 1 == y.size:
        return top
    return bracketed(lambda v: down.energy(v) - down.energy(top), float(y[i]), float(y[i + 1]))


def quarter(branch: Branch | None, y_e: float, top: float, energy: float) -> float:
    """Return the time between 0 and a turning point, on one branch."""
    if branch is None or top <= y_e:
        return math.pi / 2
    u, w = gauss(60)
    y = top - (top - y_e) * u**2
    left = energy - y * y / 2 - branch.work(y)
    contact = float(w @ (2 * (top - y_e) * u / np.sqrt(2 * left)))
    return contact + math.asin(y_e / math.sqrt(2 * energy))


def damping(stored: Array) -> Array:
    """Return the damping ratio of every cycle by the elastic energies of its peaks, of the same sense."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(np.log(stored[..., :-1] / stored[..., 1:]) / (4 * math.pi))

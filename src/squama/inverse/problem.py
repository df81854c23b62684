"""A target as a problem of least squares: residuals and limits of many designs, with their derivatives."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from squama.inverse.figures import evaluate, harmless
from squama.inverse.goals import residual
from squama.inverse.limits import LIMITS, Sizes, law_rooms
from squama.inverse.target import Target
from squama.inverse.wants import Found, Want
from squama.model import joint
from squama.model.sensitivity import STEP
from squama.model.solve import Array
from squama.study.cells import Cells
from squama.study.columns import valid

ROOM = 1e-9
"""Limits are kept with this much room, so that rounding does not break them."""
EDGE = 1e-6
"""The same for the border of the domain where a figure is there."""
LOCKED = ("lock", "RED", "range", "W_fr")
"""Figures that only beams that lock have."""
PRICE = 1e4
"""What a broken limit costs, in residuals."""


class Look(NamedTuple):
    """Designs as the search sees them: residuals, limits, slopes of both by variable, and the merit (less is better).

    ``r`` (goals, n), ``J`` (goals, variables, n), ``g`` (limits, n), ``G`` (limits, variables, n); ``found`` has the
    figures of the goals first.
    """

    y: Array
    r: Array
    J: Array
    g: Array
    G: Array
    merit: Array
    found: Found
    d: Array


class Problem:
    """The residuals and limits of a target."""

    def __init__(self, target: Target) -> None:
        self.target = target
        self.space = target.space
        wants = [goal.want for goal in target.goals]
        self.rates = [w.at for w in wants if w.at is not None]
        locks = any(w.figure in LOCKED for w in wants)
        self.lock = "strain" in target.limits and locks
        self.wants = [*wants, Want("lock")] if self.lock else wants
        # what keeps a design inside the domain where its figures are smooth
        self.inside = (
            [Want(name) for name in ("tip", "side", "hold")] if locks and target.space.load == "twisting" else []
        )
        self.inside += [Want("reach")] if self.rates else []
        self.tangents = [w.at for w in wants if w.figure == "tangent" and w.at is not None]
        self.inside += [Want("engagement")] * len(self.tangents)

    def look(self, y: Array, *, slopes: bool, plates: bool) -> Look:
        """Evaluate points (n, m) of the unit cube."""
        c = self.space.cells(y)
        moved = self.space.moved(y) if slopes else []
        good = valid(c)
        # rows that are no beam are computed as something harmless and then ruled out
        safe = harmless(c, good)
        every = evaluate(safe, moved, [*self.inside, *self.wants], self.target.options, plates=plates)
        at = len(self.inside)
        found = every._replace(values=every.values[at:], slopes=every.slopes[at:])
        n, m = y.shape
        d_slopes = np.stack([np.imag(v.d) / STEP for v in moved]) if slopes else np.zeros((0, n))
        k = len(self.target.goals)
        r, J = residual(self.target.goals, found.values[:k], found.slopes[:k], c.d, d_slopes, self._short(c, found))
        g, G = self.limits(c, moved, found)
        rooms, by = self._inside(every, c.d, d_slopes)
        g, G = np.concatenate([g, rooms]), np.concatenate([G, by[:, : len(moved)]])
        merit = 0.5 * (r * r).sum(axis=0) + PRICE * np.maximum(-g, 0).sum(axis=0)
        merit = np.where(good & np.isfinite(merit), merit, np.inf)
        if not slopes:
            J, G = np.zeros((k, m, n)), np.zeros((len(g), m, n))
        return Look(y, r, J, g, G, merit, found, c.d)

    def _inside(self, every: Found, d: Array, d_slopes: Array) -> tuple[Array, Array]:
        """Room to the border of the domain where the figures are there, and its derivatives; 1 where it has no say."""
        k = len(self.inside)
        rooms, slopes = np.array(every.values[:k]), np.array(every.slopes[:k])
        tangents = iter(self.tangents)
        for i, want in enumerate(self.inside):
            if want.figure == "engagement":
                # the tangent jumps at engagement: a design stays on its side
                at = next(tangents)
                need = at.per_pitch(d)
                side = np.where(rooms[i] >= need, 1.0, -1.0)
                slopes[i] = side * (slopes[i] / need - rooms[i] * at.rate / need**2 * d_slopes)
                rooms[i] = side * (rooms[i] / need - 1)
            if want.figure == "reach":
                needs = np.array([at.per_pitch(d) for at in self.rates])
                first = np.argmax(needs, axis=0)
                need, rate = needs[first, np.arange(d.size)], np.array([at.rate for at in self.rates])[first]
                slopes[i] = slopes[i] / need - rooms[i] * rate / need**2 * d_slopes
                rooms[i] = rooms[i] / need - 1
        missing = ~np.isfinite(rooms)
        slopes = np.where(missing[:, None, :] | ~np.isfinite(slopes), 0.0, slopes)
        return np.where(missing, 1.0, rooms) - EDGE, slopes

    @property
    def names(self) -> list[str]:
        """Names of the rooms in the order of ``Look.g``."""
        words = {
            "tip": "the contact at the lock at the end of the tip edge",
            "side": "the contact at the lock at the end of the side edge",
            "hold": "the contact at the end of an edge before it locks",
            "engagement": "engagement at the twist of the tangent",
            "reach": "the end of the curve at the farthest twist asked for",
        }
        laws = [limit for law in self.target.laws for limit in joint.LAWS[law].limits]
        ranges: dict[str, None] = {}
        for limit in laws:
            ranges[f"{limit.ratio} <= {limit.high:g}"] = None
            if limit.low > 0:
                ranges[f"{limit.ratio} >= {limit.low:g}"] = None
        return [*self.target.limits, *ranges, *(words[w.figure] for w in self.inside)]

    def _short(self, c: Cells, found: Found) -> Array:
        """How much of the twist a goal needs a design lacks, as a share; 0 where it does not lack any."""
        short = np.zeros((len(self.target.goals), c.d.size))
        for i, goal in enumerate(self.target.goals):
            at = goal.want.at or goal.twist
            if at is not None:
                need = at.per_pitch(c.d)
                short[i] = np.clip((need - found.load_end) / need, 0.0, 1.0)
        return short

    def rate(self, c: Cells, values: Array) -> Array:
        """Farthest twist rate that the target asks for, or that of the lock; rad/m. ``values`` as in :class:`Found`."""
        rates = [at.per_pitch(c.d) / c.d for at in self.rates] or [np.zeros(c.d.size)]
        if self.lock:
            rates.append(np.nan_to_num(values[-1]) / c.d)
        return np.asarray(np.max(rates, axis=0))

    def limits(self, c: Cells, moved: list[Cells], found: Found) -> tuple[Array, Array]:
        """Room to every limit (limits, n) and its derivatives."""
        rate = self.rate(c, found.values)
        g = np.array(list(self.rooms(c, rate).values())).reshape(-1, c.d.size) - ROOM
        G = np.zeros((len(g), len(moved), c.d.size))
        for j, v in enumerate(moved):
            step: Any = 0.0
            if "strain" in self.target.limits:
                options = [at.per_pitch(v.d) / v.d for at in self.rates]
                if self.lock:
                    last = np.nan_to_num(found.values[-1]) + 1j * STEP * found.slopes[-1, j]
                    options.append(last / v.d)
                every = np.array(options or [np.zeros(c.d.size, complex)])
                step = every[np.argmax(every.real, axis=0), np.arange(c.d.size)]
            room = np.array([np.broadcast_to(value, c.d.size) for value in self.rooms(v, step).values()])
            G[:, j] = np.imag(room.reshape(-1, c.d.size)) / STEP
        return g, G

    def rooms(self, c: Cells, rate: Any) -> dict[str, Any]:
        """Room to every limit by name."""
        s = Sizes.of(c, self.space.beam.scales, self.space.load, rate)
        rooms = {name: LIMITS[name].room(s, value) for name, value in self.target.limits.items()}
        return rooms | law_rooms(s, self.target.laws)

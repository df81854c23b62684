"""Least squares of a target: residuals, limits and effects of tolerances for many designs, with derivatives."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from squama.inverse.goals import Pitches
from squama.inverse.limits import Sizes, farthest
from squama.inverse.named_figures import OF_LOCKS, Found, Want
from squama.inverse.space import stepped
from squama.inverse.target import Target
from squama.loads import LOADS
from squama.model.sensitivity import STEP
from squama.study.columns import Cells, valid
from squama.study.parameters import of_beam
from squama.types import Array

ROOM = 1e-9
"""Room kept to limits, so that rounding does not break them."""
EDGE = 1e-6
"""Room kept to the borders of the domain of the figures."""
MISSING = 100.0
"""Residual of a design that lacks the figure, e.g. does not lock; other residuals are relative differences."""
PRICE = 1e4
"""Merit added per unit of a broken limit."""
BORDERS = {
    "tip": "the contact at the lock at the end of the tip edge",
    "side": "the contact at the lock at the end of the side edge",
    "hold": "the contact at the end of an edge before it locks",
    "engagement": "engagement at the twist of the tangent",
    "reach": "the end of the curve at the farthest twist asked for",
}
"""Borders of the domain in which figures are smooth, by the figure that marks them."""

MOST = 20.0
"""Bound of a figure of N scales over that of the endless beam, and of its inverse."""


class Look(NamedTuple):
    """Evaluated designs (last axis n): residuals, limits, derivatives of both, and merit.

    ``y`` (variables, n) in the unit cube; ``r`` (goals, n) and ``J`` (goals, variables, n); ``g`` (limits, n), negative
    where broken, and ``G`` (limits, variables, n); ``merit`` (n,), less is better. ``values`` and ``slopes`` of the
    figures, ``code`` and ``load_end`` as in :class:`Found`, the goals first; ``d`` (m): pitches; numbers of scales.
    """

    y: Array
    r: Array
    J: Array
    g: Array
    G: Array
    merit: Array
    values: Array
    slopes: Array
    code: Array
    load_end: Array
    d: Array
    scales: Array


class Ends(NamedTuple):
    """Figures (goals, n) of N scales near a design, ``own`` (``endless figure`` / ``endless``)^``power``.

    Scales at the ends lack a neighbour, so a stiffness ratio of N scales grows more slowly than that of the endless
    beam; the power is that of the last two designs of a search.
    """

    own: Array
    endless: Array
    power: Array

    @classmethod
    def none(cls, goals: int) -> Ends:
        """Return the ends of an endless beam."""
        return cls(*np.ones((3, goals, 1)))

    @property
    def share(self) -> Array:
        """Figures over those of the endless beam (goals, n); 1 where its curve ends before."""
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.clip(np.nan_to_num(self.own / self.endless, nan=1.0), 1 / MOST, MOST)

    @property
    def rates(self) -> Array:
        """Derivatives (goals, n) of the figures by the endless beam's."""
        return self.power * self.share

    def figures(self, endless: Array, slopes: Array) -> tuple[Array, Array]:
        """Return figures (goals, n) and their derivatives (goals, variables, n) from those of the endless beam."""
        with np.errstate(divide="ignore", invalid="ignore"):
            grown = np.where(self.power == 1, 1.0, np.abs(endless / self.endless) ** (self.power - 1))
        return self.share * endless * grown, slopes * (self.rates * grown)[:, None]


class Residuals:
    """Residuals and limits of a target; ``ends`` turn figures of the endless beam into those of N scales."""

    def __init__(self, target: Target, ends: Ends | None = None) -> None:
        self.target, self.space = target, target.space
        self.ends = ends or Ends.none(len(target.goals))
        wants = [goal.want for goal in target.goals]
        self.rates = [w.at for w in wants if w.at is not None]
        hinge = target.options.joint == "hinge"
        locks = hinge and any(w.figure in OF_LOCKS and w.figure != "critical_mu" for w in wants)
        self.lock = "strain" in target.limits and locks
        self.wants = [*wants, Want("lock")] if self.lock else wants
        self.tangents = [w.at for w in wants if w.figure == "tangent" and w.at is not None]
        # limits that keep a design inside the domain where its figures are smooth
        edges = ("tip", "side", "hold") if locks and LOADS[target.space.load].sided else ()
        names = [*edges, *["reach"] * bool(self.rates), *["engagement"] * len(self.tangents)] if hinge else []
        self.inside = [Want(name) for name in names]
        start = self.space.cells(self.space.start[None])
        self.names = [*self.rooms(start, np.zeros((len(self.wants), 1))), *(BORDERS[name] for name in names)]
        """Names of the limits in the order of ``Look.g``."""

    def look(self, y: Array, *, slopes: bool, plates: bool) -> Look:
        """Evaluate points (n, m) of the unit cube, with derivatives if ``slopes``, testing all plates if ``plates``."""
        c = self.space.cells(y)
        moved = self.space.moved(y) if slopes else []
        good = valid(c)
        every = self.target.figures(c, moved, [*self.inside, *self.wants], plates=plates)
        at, k, (n, m) = len(self.inside), len(self.target.goals), y.shape
        found = every._replace(values=every.values[at:].copy(), slopes=every.slopes[at:].copy())
        found.values[:k], found.slopes[:k] = self.ends.figures(found.values[:k], found.slopes[:k])
        own, by = Pitches(c.d, c.sizes["beam"]["scales"]), Pitches.of(moved, n)
        r, J = self._residuals(found, own, by)
        g, G = self._limits(c, moved, found)
        room, rising = self._inside(every, c.d, np.imag(by.d) / STEP)
        g, G = np.concatenate([g, room]), np.concatenate([G, rising[:, : len(moved)]])
        merit = 0.5 * (r * r).sum(axis=0) + PRICE * np.maximum(-g, 0).sum(axis=0)
        merit = np.where(good & np.isfinite(merit), merit, np.inf)
        # choices from lists have no derivative
        still = ((0, 0), (0, m - J.shape[1]), (0, 0))
        J, G = np.pad(J, still), np.pad(G, still)
        return Look(y.T, r, J, g, G, merit, found.values, found.slopes, found.code, found.load_end, *own)

    def _inside(self, every: Found, d: Array, d_slopes: Array) -> tuple[Array, Array]:
        """Return the room to the borders of the figures' domain and its derivatives; 1 where there is no border."""
        k = len(self.inside)
        room, slopes = np.array(every.values[:k]), np.array(every.slopes[:k])
        tangents = iter(self.tangents)
        for i, want in enumerate(self.inside):
            side = np.ones(d.size)
            if want.figure == "engagement":
                # the tangent jumps at engagement: a design stays on its side
                at = next(tangents)
                need, rate = at.per_pitch(d), at.rate
                side = np.where(room[i] >= need, 1.0, -1.0)
            elif want.figure == "reach":
                needs = np.array([at.per_pitch(d) for at in self.rates])
                first = np.argmax(needs, axis=0)
                need, rate = needs[first, np.arange(d.size)], np.array([at.rate for at in self.rates])[first]
            else:
                continue
            slopes[i] = side * (slopes[i] / need - room[i] * rate / need**2 * d_slopes)
            room[i] = side * (room[i] / need - 1)
        missing = ~np.isfinite(room)
        slopes = np.where(missing[:, None, :] | ~np.isfinite(slopes), 0.0, slopes)
        return np.where(missing, 1.0, room) - EDGE, slopes

    def _residuals(self, found: Found, own: Pitches[Array], moved: Pitches[Array]) -> tuple[Array, Array]:
        """Return weighted relative differences from the goals (goals, n) and derivatives (goals, variables, n)."""
        k, inside = len(self.target.goals), self.target.inside
        r, J = np.empty((k, own.d.size)), np.zeros_like(found.slopes[:k])
        for i, goal in enumerate(self.target.goals):
            difference = goal.relative(found.values[i], *own)
            slope = goal.slope(found.values[i], found.slopes[i], moved)
            if goal.sense != "=":
                difference = difference - inside if goal.sense == ">=" else difference + inside
                slack = difference >= 0 if goal.sense == ">=" else difference <= 0
                difference, slope = np.where(slack, 0.0, difference), np.where(slack, 0.0, slope)
            missing, at = ~np.isfinite(difference), goal.want.at or goal.twist
            need = np.inf if at is None else at.per_pitch(*own)
            short = 0.0 if at is None else np.clip((need - found.load_end) / need, 0.0, 1.0)
            r[i] = goal.weight * np.where(missing, MISSING + short, difference)
            J[i] = goal.weight * np.where(missing, 0.0, slope)
        return r, J

    def _limits(self, c: Cells, moved: Sequence[Cells], found: Found) -> tuple[Array, Array]:
        """Return the room to every limit (limits, n) and its derivatives (limits, variables, n)."""

        def every(c: Cells, values: Array) -> Array:
            return np.array([np.broadcast_to(room, c.d.size) for room in self.rooms(c, values).values()])

        g = every(c, found.values).reshape(-1, c.d.size) - ROOM
        slopes = [every(v, found.values + 1j * STEP * found.slopes[:, j]).imag / STEP for j, v in enumerate(moved)]
        return g, np.stack(slopes, axis=1).reshape(len(g), -1, c.d.size) if moved else np.zeros((len(g), 0, c.d.size))

    def rooms(self, c: Cells, values: Array) -> dict[str, Array]:
        """Return the room to every limit by name; ``values`` as in :class:`Found`, with the complex steps of ``c``."""
        return self.target.rooms(c, self.sizes(c, values))

    def sizes(self, c: Cells, values: Array) -> Sizes:
        """Return the sizes for limits, at the largest twist of a goal or at the lock."""
        return Sizes.of(c, self.space.load, farthest(c, self.rates, values[-1] if self.lock else None))

    def tolerances(self, y: Array) -> dict[str, Array]:
        """Return the tolerance (n,) of every dimension by key for designs y (n, m), SI."""
        values, (beam, load) = self.space.values(y), self.space[:2]
        found = {}
        for key, size in self.target.tolerance.items():
            here = np.broadcast_to(values.get(key, of_beam(beam, load, key)), len(y))
            found[key] = np.abs(here) * -size if size < 0 else np.full(len(y), size)
        return found

    def effects(self, y: Array) -> Array:
        """Return derivative times tolerance over the required value (goals, dimensions, n) of designs y (n, m)."""
        goals, values = self.target.goals, self.space.values(y)
        moved = [stepped(*self.space[:2], values, key, size, len(y)) for key, size in self.tolerances(y).items()]
        found = self.target.figures(self.space.cells(y), moved, [goal.want for goal in goals], plates=False)
        rows, by = zip(goals, found.values, found.slopes, strict=True), Pitches.of(moved, len(y))
        return np.array([goal.slope(value, slopes, by) for goal, value, slopes in rows])

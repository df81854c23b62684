r"""Figures of many designs on hinges that a target may name, with their derivatives by whatever was moved.

No differences are taken but for the tangent. Along a path the torque at a given twist phi follows from the path
parameter x with phi(x, p) = phi, so that by the implicit function theorem

.. math::  \frac{\mathrm d T}{\mathrm d p} = \frac{\partial T}{\partial p}
           - \frac{\partial T/\partial x}{\partial \phi/\partial x} \frac{\partial \phi}{\partial p},

each partial derivative by a complex step; ends and cut-offs are those of :mod:`squama.model.sensitivity`. Derivatives
of the tangent stiffness are central differences of these along the twist.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from squama.arrays.solution import COLUMNS as CONTACT
from squama.arrays.solution import Solution, solve, with_touches
from squama.inverse.named_figures import Found, Options, Want, take
from squama.loads import LOADS
from squama.model import energy, mechanics, tracks
from squama.model.figures import LOCKING
from squama.model.outcome import CODES, End
from squama.model.paths import ARRAY
from squama.model.reach import SEARCH
from squama.model.sensitivity import COMPLEX, STEP, Moved, Seed, Tracked, move, seed, tracked, vanishing
from squama.model.tracks import Track, at_loads
from squama.study.columns import Cells
from squama.types import Array

COLUMNS = (*CONTACT, "ratio", "K", "d", "rigidity")
GRID = 33
"""Samples of a path between which a twist is looked for."""
NEAR = 1e-5
"""Step of the central differences along the twist, relative."""
_NONE, _OTHER = CODES.index(End.NONE), CODES.index(End.OTHER)
_OFF = (CODES.index(End.OFF_TIP), CODES.index(End.OFF_SIDE))

Partials = dict[str, Array]


def evaluate(c: Cells, moved: Sequence[Cells], wants: Sequence[Want], options: Options, *, plates: bool) -> Found:
    """Evaluate figures of many designs, flat columns.

    ``moved`` are the same designs, each time with one variable moved by i STEP. With ``plates`` all plates are tested
    against each other, as :func:`squama.twist` does; else a contact of another kind goes unnoticed.
    """
    n = c.eta.size
    by_column = {name: np.stack([np.imag(getattr(m, name)) for m in moved]) / STEP for name in COLUMNS if moved}
    with_work = any(w.figure in ("RED", "W_fr") for w in wants)
    sol, limit = _follow(c, options, plates=plates, with_work=with_work)
    values, slopes = np.full((len(wants), n), np.nan), np.zeros((len(wants), len(moved), n))

    def put(i: int, index: Array, value: Array, partials: Partials) -> None:
        values[i, index] = value
        for name, partial in partials.items():
            if moved:
                slopes[i][:, index] += np.where(np.isfinite(partial), partial, 0.0) * by_column[name][:, index]

    with np.errstate(all="ignore"):
        used = [p for p in CONTACT if moved and by_column[p].any()]
        for i, want in enumerate(wants):
            if want.figure == "stiffness":
                put(i, np.arange(n), c.rigidity, {"rigidity": np.ones(n)})
            elif want.at is not None:
                # before engagement the beam is straight
                phi = want.at.per_pitch(c.d)
                index = np.flatnonzero(phi <= np.minimum(sol.found.load_e, limit))
                none = np.zeros(index.size)
                put(i, index, *_at_twist(want, take(c, index), phi[index], (none, none, {}), {}))
        for index, t in sol.tracks:
            part = _Part(take(c, index), t, options, used, sol.found.W_fr[index], with_work=with_work)
            for i, want in enumerate(wants):
                if want.figure != "stiffness":
                    lanes, value, partials = part.figure(want, limit[index], sol.found.code[index])
                    put(i, index[lanes], value, partials)
    return Found(values, slopes, sol.found.code, sol.found.load_e, limit)


def _follow(c: Cells, options: Options, *, plates: bool, with_work: bool) -> tuple[Solution, Array]:
    """Return the ends of the designs, and how far their curves go."""
    load = LOADS[options.load]
    margin = options.margin if with_work else None
    columns = {name: np.asarray(getattr(c, name)) for name in CONTACT}
    sol = solve(columns, load=load.name, law=options.law, sense=options.sense, margin=margin)
    limit = np.where(sol.found.code == _NONE, SEARCH, sol.found.load_end)
    if plates:
        shapes = [columns[name] for name in CONTACT[:5]]
        sol, touches = with_touches(sol, shapes, load=load.name, sense=options.sense)
        touch = np.array([np.inf if hit is None else hit.phi for hit in touches])
        limit = np.where(sol.found.code == _NONE, np.minimum(SEARCH, touch), sol.found.load_end)
    return sol, limit


def _at_twist(
    want: Want, c: Cells, phi: Array, scales: tuple[Array, Array, Partials], slopes: Partials, bend: Array | float = 0.0
) -> tuple[Array, Partials]:
    """Torque or tangent stiffness from the scales' torque (in K), its slope and its curvature ``bend`` by phi.

    ``scales`` are torque, slope and the derivatives of the torque by column, ``slopes`` those of the slope.
    """
    assert want.at is not None
    a, (tau, slope, by_path) = want.at.rate, scales
    if want.figure == "torque":
        by_d = c.K * slope * a + c.rigidity * (a - phi / c.d) / c.d
        known = {"K": tau, "rigidity": phi / c.d, "d": by_d}
        return c.K * tau + c.rigidity * phi / c.d, known | {p: c.K * v for p, v in by_path.items()}
    known = {"K": c.d * slope, "rigidity": np.ones_like(phi), "d": c.K * (slope + c.d * bend * a)}
    return c.rigidity + c.K * c.d * slope, known | {p: c.K * c.d * v for p, v in slopes.items()}


class _Part:
    """One track of paths: figures of its designs, with partial derivatives by column."""

    def __init__(
        self, c: Cells, t: Track, options: Options, used: Sequence[str], work: Array, *, with_work: bool
    ) -> None:
        self.c, self.t, self.options = c, t, options
        sign = 1 if options.sense == "+" else -1
        self.base: Tracked = tracked(t, c.mu, options.margin, options.law, work)
        self.seeds: dict[str, Seed] = {p: seed(self.base, p, sign) for p in used}
        self.moved: dict[str, Moved] = {p: move(self.base, s, with_work=with_work) for p, s in self.seeds.items()}
        self.grid: tuple[Array, Array] | None = None
        start = getattr(t.row, "open", t.row)
        self.engaged = np.asarray(start.point(t.row.theta0, "edge", ARRAY).load)

    def figure(self, want: Want, limit: Array, code: Array) -> tuple[Array, Array, Partials]:
        """Return the designs that have the figure, its values and partial derivatives."""
        if want.at is not None:
            phi = want.at.per_pitch(self.c.d)
            lanes = np.flatnonzero((phi > self.engaged) & (phi <= limit))
            return lanes, *self._contact(want, phi[lanes], lanes)
        locks = np.isin(code, _OFF if want.figure == "hold" else self.options.locks)
        ends: dict[str, tuple[Array, Array, Callable[[Moved], Array]]] = {
            "engagement": (limit >= self.engaged, self.engaged, lambda m: m.load_e),
            # where other plates meet first the derivative is not known
            "reach": (code != _OTHER, limit, lambda m: m.load_end),
            "lock": (locks, limit, lambda m: m.load_end),
            "range": (locks, limit - self.engaged, lambda m: m.load_end - m.load_e),
        }
        there = locks
        if want.figure in ends:
            there, value, of = ends[want.figure]
            partials = self._slopes(of)
        elif want.figure == "critical_mu":
            there, (value, partials) = np.ones(code.size, bool), self._critical()
        elif want.figure in ("tip", "side", "hold"):
            value, partials = self._room(want.figure)
        else:
            value, partials = self._dissipated(want.figure)
        lanes = np.flatnonzero(there)
        return lanes, value[lanes], {p: v[lanes] for p, v in partials.items()}

    def _slopes(self, of: Callable[[Moved], Array]) -> Partials:
        """Return derivatives of results of :class:`Moved`."""
        return {p: np.imag(of(m)) / STEP for p, m in self.moved.items()}

    def _critical(self) -> tuple[Array, Partials]:
        pt = self.t.row.point(self.t.x0, self.options.law, ARRAY)
        starts = {
            p: s.row.point(s.row.parameter(s.row.theta0, COMPLEX) + 0j, self.options.law, COMPLEX)
            for p, s in self.seeds.items()
        }
        partials = {p: np.imag(mechanics.mu_lock(at)) / STEP for p, at in starts.items()}
        return np.where(pt.M_f > 0, mechanics.mu_lock(pt), np.nan), partials

    def _room(self, figure: str) -> tuple[Array, Partials]:
        """Room of the contact to the end of an edge, or what it lacks to a frictional lock, at the end of the path."""
        law, t, b = self.options.law, self.t, self.base
        pt = t.row.point(t.x_end, law, ARRAY)
        side = np.sign(pt.p) if figure == "tip" else np.where(2 * pt.s < t.row.eta, 1.0, -1.0)

        def room(row: Any, mu: Array, at: Any) -> Array:
            if figure == "hold":
                return np.asarray((at.M_N + mu * at.M_f) / row.eta)
            return np.asarray(
                1 - side * at.p / row.beta if figure == "tip" else np.where(side > 0, at.s, row.eta - at.s) / row.eta
            )

        partials = {}
        for p, s in self.seeds.items():
            rate = -np.imag(vanishing(s.row, s.row.point(t.x_end, law, COMPLEX), t, s.mu, law)) / b.E_x
            x = np.where(t.x_end == t.x0, s.row.parameter(s.row.theta0, COMPLEX) + 0j, t.x_end + 1j * rate)
            partials[p] = np.imag(room(s.row, s.mu, s.row.point(x, law, COMPLEX))) / STEP
        return room(t.row, self.c.mu, pt), partials

    def _dissipated(self, figure: str) -> tuple[Array, Partials]:
        """RED or frictional work at the cut-off before a lock."""
        c, t, work = self.c, self.t, self.base.work
        if figure == "W_fr":
            partials = self._slopes(lambda m: m.W_fr * c.K / c.d)
            return work * c.K / c.d, partials | {"K": work / c.d, "d": -work * c.K / c.d**2}
        x_c = energy.cutoff(t.row, t.x0, t.x_end, np.isin(t.code, LOCKING), self.options.margin)
        pt = t.row.point(x_c, self.options.law, ARRAY)
        went = x_c > t.x0
        load, lift = np.where(went, pt.load, self.engaged), np.where(went, pt.theta - c.theta0, 0.0)
        total = (c.ratio * load**2 + lift**2) / 2 + work
        partials = {"ratio": -work * load**2 / 2 / total**2}
        for p, m in self.moved.items():
            theta0 = c.theta0 + (STEP * 1j if p == "theta0" else 0)
            moved = (c.ratio * m.load_c**2 + (m.theta_c - theta0) ** 2) / 2 + m.W_fr
            partials[p] = np.imag(m.W_fr / moved) / STEP
        return np.where(total > 0, work / total, 0.0), partials

    def _contact(self, want: Want, phi: Array, lanes: Array) -> tuple[Array, Partials]:
        """Torque or tangent stiffness at twists in contact."""
        c = take(self.c, lanes)
        scales = self._torque(phi, lanes)
        if want.figure == "torque" or not self.seeds:
            return _at_twist(want, c, phi, scales, {})
        h = NEAR * phi
        (_, s1, p1), (_, s0, p0) = (self._torque(phi + e, lanes) for e in (h, -h))
        slopes = {p: (p1[p] - p0[p]) / (2 * h) for p in self.seeds}
        return _at_twist(want, c, phi, scales, slopes, (s1 - s0) / (2 * h))

    def _torque(self, phi: Array, lanes: Array) -> tuple[Array, Array, Partials]:
        """Scales' torque in K_theta at a twist, and its derivatives by the twist and by the path's columns."""
        law, mu = self.options.law, self.c.mu
        x = self._place(phi, lanes)
        row = tracks.take(self.t.row, lanes)
        pt = row.point(x + STEP * 1j, law, COMPLEX)
        torque = mechanics.forces(pt, row.theta0, mu[lanes]).torque
        by_x, load_x = np.imag(torque) / STEP, np.imag(pt.load) / STEP
        partials = {}
        for p, s in self.seeds.items():
            r = tracks.take(s.row, lanes)
            at = r.point(x, law, COMPLEX)
            moved = mechanics.forces(at, r.theta0, np.broadcast_to(s.mu, mu.shape)[lanes]).torque
            partials[p] = (np.imag(moved) - by_x / load_x * np.imag(at.load)) / STEP
        return np.real(torque), by_x / load_x, partials

    def _place(self, phi: Array, lanes: Array) -> Array:
        """Path parameters at which the paths reach their twists: bracketed on a grid, then Newton's method."""
        law, t = self.options.law, self.t
        if self.grid is None:
            x = t.x0 + (t.x_end - t.x0) * np.linspace(0.0, 1.0, GRID)[:, None]
            seen = t.row.point(x, law, ARRAY).load
            self.grid = x, np.maximum.accumulate(np.where(np.isfinite(seen), seen, -np.inf), axis=0)
        x, seen = self.grid[0][:, lanes], self.grid[1][:, lanes]
        j = np.clip((seen < phi).sum(axis=0) - 1, 0, GRID - 2)
        k = np.arange(lanes.size)
        a, b, fa, fb = x[j, k], x[j + 1, k], seen[j, k], seen[j + 1, k]
        return at_loads(tracks.take(t.row, lanes), phi, (a, b), (fa, fb))

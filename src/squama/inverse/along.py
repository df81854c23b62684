r"""Figures of many designs that a target may name, with their derivatives by the columns of the batch engine.

No differences are taken but for the tangent. Along a path the torque at a given twist phi follows from the path
parameter x with phi(x, p) = phi, so that by the implicit function theorem

.. math::  \frac{\mathrm d T}{\mathrm d p} = \frac{\partial T}{\partial p}
           - \frac{\partial T/\partial x}{\partial \phi/\partial x} \frac{\partial \phi}{\partial p},

each partial derivative by a complex step; ends and cut-offs are those of :mod:`squama.model.sensitivity`. Derivatives
of the tangent stiffness are central differences of these along the twist.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from squama.inverse.wants import Options, Partials, Want
from squama.model import energy, mechanics
from squama.model.ends import Track
from squama.model.outcome import CODES, End
from squama.model.paths import ARRAY
from squama.model.sensitivity import COMPLEX, STEP, Moved, Seed, Tracked, move, seed, tracked, vanishing
from squama.model.solve import Array
from squama.study.cells import Cells

_OTHER = CODES.index(End.OTHER)
_OFF = (CODES.index(End.OFF_TIP), CODES.index(End.OFF_SIDE))
GRID = 33
"""Samples of a path between which a twist is looked for."""
NEAR = 1e-5
"""Step of the central differences along the twist, relative."""


def take(c: Cells, index: Array) -> Cells:
    """Return some designs, without their sizes."""
    return Cells._make([*(v[index] for v in c[:-1]), {}])


def at_twist(
    want: Want,
    c: Cells,
    phi: Array,
    tau: Array,
    slope: Array,
    by_path: Partials,
    slope_by_path: Partials,
    bend: Any = 0.0,
) -> tuple[Array, Partials]:
    """Torque or tangent stiffness from the scales' torque tau (in K), its slope and its curvature ``bend`` by phi."""
    assert want.at is not None
    a = want.at.rate
    if want.figure == "torque":
        value = c.K * tau + c.rigidity * phi / c.d
        by_d = c.K * slope * a + c.rigidity * (a - phi / c.d) / c.d
        known = {"K": tau, "rigidity": phi / c.d, "d": by_d}
        return value, known | {p: c.K * v for p, v in by_path.items()}
    value = c.rigidity + c.K * c.d * slope
    known = {"K": c.d * slope, "rigidity": np.ones_like(phi), "d": c.K * (slope + c.d * bend * a)}
    return value, known | {p: c.K * c.d * v for p, v in slope_by_path.items()}


class Part:
    """One track of paths: figures of its designs, with partial derivatives by column."""

    def __init__(self, c: Cells, t: Track, options: Options, with_work: bool, used: Sequence[str]) -> None:
        self.c, self.t, self.options = c, t, options
        sign = 1 if options.sense == "+" else -1
        self.base: Tracked = tracked(t, c.mu, options.margin, options.law, with_work=with_work)
        self.seeds: dict[str, Seed] = {p: seed(self.base, p, sign) for p in used}
        self.moved: dict[str, Moved] = {p: move(self.base, s, with_work=with_work) for p, s in self.seeds.items()}
        self.grid: tuple[Array, Array] | None = None
        self.all = np.arange(c.eta.size)

    def figure(self, want: Want, limit: Array, code: Array) -> tuple[Array, Array, Partials]:
        """Return the designs that have the figure, its values and partial derivatives."""
        if want.at is not None:
            phi = want.at.per_pitch(self.c.d)
            lanes = np.flatnonzero((phi > self._engaged()) & (phi <= limit))
            return lanes, *self._contact(want, phi[lanes], lanes)
        if want.figure == "critical_mu":
            return self.all, *self._critical()
        if want.figure == "engagement":
            lanes = np.flatnonzero(limit >= self._engaged())
            return lanes, self._engaged()[lanes], {p: np.imag(m.load_e)[lanes] / STEP for p, m in self.moved.items()}
        if want.figure == "reach":
            # where other plates meet first the derivative is not known
            lanes = np.flatnonzero(code != _OTHER)
            return lanes, limit[lanes], {p: np.imag(m.load_end)[lanes] / STEP for p, m in self.moved.items()}
        lanes = np.flatnonzero(np.isin(code, _OFF if want.figure == "hold" else self.options.locks))
        if want.figure in ("tip", "side", "hold"):
            value, partials = self._room(want.figure)
        elif want.figure == "lock":
            value = limit
            partials = {p: np.imag(m.load_end) / STEP for p, m in self.moved.items()}
        elif want.figure == "range":
            value = limit - self._engaged()
            partials = {p: np.imag(m.load_end - m.load_e) / STEP for p, m in self.moved.items()}
        else:
            value, partials = self._dissipated(want.figure)
        return lanes, value[lanes], {p: v[lanes] for p, v in partials.items()}

    def _engaged(self) -> Array:
        row: Any = self.t.row
        start = getattr(row, "open", row)
        return np.asarray(start.point(row.theta0, "edge", ARRAY).load)

    def _critical(self) -> tuple[Array, Partials]:
        row: Any = self.t.row
        pt = row.point(self.t.x0, self.options.law, ARRAY)
        value = np.where(pt.M_f > 0, mechanics.mu_lock(pt), np.nan)
        partials = {}
        for p, s in self.seeds.items():
            x0 = s.row.parameter(s.row.theta0, COMPLEX) + 0j
            partials[p] = np.imag(mechanics.mu_lock(s.row.point(x0, self.options.law, COMPLEX))) / STEP
        return value, partials

    def _room(self, figure: str) -> tuple[Array, Partials]:
        """Room of the contact to the end of an edge, or what it lacks to a frictional lock, at the end of the path."""
        law, t, b = self.options.law, self.t, self.base
        row: Any = t.row
        pt, mu = row.point(t.x_end, law, ARRAY), self.c.mu
        side = np.sign(pt.p) if figure == "tip" else np.where(2 * pt.s < row.eta, 1.0, -1.0)

        def room(r: Any, mu: Any, at: Any) -> Any:
            if figure == "hold":
                return (at.M_N + mu * at.M_f) / r.eta
            return 1 - side * at.p / r.beta if figure == "tip" else np.where(side > 0, at.s, r.eta - at.s) / r.eta

        partials = {}
        for p, s in self.seeds.items():
            at = s.row.point(t.x_end, law, COMPLEX)
            rate = -np.imag(vanishing(s.row, at, t, s.mu, law)) / b.E_x
            x0 = s.row.parameter(s.row.theta0, COMPLEX) + 0j
            x = np.where(t.x_end == t.x0, x0, t.x_end + 1j * rate)
            partials[p] = np.imag(room(s.row, s.mu, s.row.point(x, law, COMPLEX))) / STEP
        return room(row, mu, pt), partials

    def _dissipated(self, figure: str) -> tuple[Array, Partials]:
        """RED or frictional work at the cut-off before a lock."""
        c, t = self.c, self.t
        x_c = energy.cutoff(t.row, t.x0, t.x_end, np.ones(c.eta.size, bool), self.options.margin)
        pt = t.row.point(x_c, self.options.law, ARRAY)
        went = x_c > t.x0
        load, lift = np.where(went, pt.load, self._engaged()), np.where(went, pt.theta - c.theta0, 0.0)
        work = self.base.work
        if figure == "W_fr":
            partials = {p: np.imag(m.W_fr) / STEP * c.K / c.d for p, m in self.moved.items()}
            return work * c.K / c.d, partials | {"K": work / c.d, "d": -work * c.K / c.d**2}
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
        tau, slope, by_path = self._torque(phi, lanes)
        if want.figure == "torque" or not by_path:
            return at_twist(want, c, phi, tau, slope, by_path, {})
        h = NEAR * phi
        (_, s1, p1), (_, s0, p0) = (self._torque(phi + e, lanes) for e in (h, -h))
        slopes = {p: (p1[p] - p0[p]) / (2 * h) for p in by_path}
        return at_twist(want, c, phi, tau, slope, by_path, slopes, (s1 - s0) / (2 * h))

    def _torque(self, phi: Array, lanes: Array) -> tuple[Array, Array, Partials]:
        """Scales' torque in K_theta at a twist, and its derivatives by the twist and by the path's columns."""
        law, mu = self.options.law, self.c.mu[lanes]
        x = self._place(phi, lanes)
        row = _lanes(self.t.row, lanes)
        pt = row.point(x + STEP * 1j, law, COMPLEX)
        torque = mechanics.forces(pt, row.theta0, mu).torque
        by_x, load_x = np.imag(torque) / STEP, np.imag(pt.load) / STEP
        partials = {}
        for p, s in self.seeds.items():
            r = _lanes(s.row, lanes)
            at = r.point(x, law, COMPLEX)
            moved = mechanics.forces(at, r.theta0, np.broadcast_to(s.mu, self.c.mu.shape)[lanes]).torque
            partials[p] = (np.imag(moved) - by_x / load_x * np.imag(at.load)) / STEP
        return np.real(torque), by_x / load_x, partials

    def _place(self, phi: Array, lanes: Array) -> Array:
        """Path parameters at which the paths reach their twists: bracketed on a grid, then Newton's method."""
        law, t = self.options.law, self.t
        if self.grid is None:
            x = t.x0 + (t.x_end - t.x0) * np.linspace(0.0, 1.0, GRID)[:, None]
            seen: Any = t.row.point(x, law, ARRAY).load
            self.grid = x, np.maximum.accumulate(np.where(np.isfinite(seen), seen, -np.inf), axis=0)
        x, seen = self.grid[0][:, lanes], self.grid[1][:, lanes]
        j = np.clip((seen < phi).sum(axis=0) - 1, 0, GRID - 2)
        k = np.arange(lanes.size)
        a, b, fa, fb = x[j, k], x[j + 1, k], seen[j, k], seen[j + 1, k]
        # a twist just beyond the ends of a path belongs to its ends
        at = np.clip(a + (phi - fa) / np.where(fb > fa, fb - fa, 1.0) * (b - a), a, b)
        row = _lanes(t.row, lanes)
        for _ in range(60):
            pt = row.point(at, law, ARRAY)
            off = pt.load - phi
            a, b = np.where(off <= 0, at, a), np.where(off > 0, at, b)
            new = at - off / pt.load_rate
            new = np.where((new >= a) & (new <= b), new, (a + b) / 2)
            done = np.abs(new - at) <= 4e-16 * np.abs(at)
            at = new
            if done.all():
                break
        return np.asarray(at)


def _lanes(row: Any, index: Array) -> Any:
    """Return designs of a row some of whose entries may be single numbers."""
    return type(row)(*(v if np.ndim(v) == 0 else np.asarray(v)[index] for v in row))

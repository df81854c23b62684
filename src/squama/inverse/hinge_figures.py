r"""Figures of many designs on hinges that a target may name, with their derivatives by the moved variables.

Only the tangent takes differences. Along a path the torque at a given twist phi follows from the path parameter x with
phi(x, p) = phi, so that by the implicit function theorem

.. math::  \frac{\mathrm d T}{\mathrm d p} = \frac{\partial T}{\partial p}
           - \frac{\partial T/\partial x}{\partial \phi/\partial x} \frac{\partial \phi}{\partial p},

each partial derivative by a complex step; ends and cut-offs are those of :mod:`squama.model.sensitivity`. Derivatives
of the tangent stiffness are central differences of these along the twist.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from squama.arrays.solution import COLUMNS as CONTACT
from squama.arrays.solution import Solution, solve, with_touches
from squama.inverse.named_figures import Found, Options, Want
from squama.loads import LOADS
from squama.model import energy, mechanics, tracks
from squama.model.figures import LOCKING
from squama.model.outcome import CODES, End
from squama.model.paths import ARRAY, Point
from squama.model.reach import SEARCH
from squama.model.sensitivity import COMPLEX, STEP, Moved, Seed, Tracked, move, seed, tracked, vanishing
from squama.model.tracks import Track, at_loads
from squama.study.columns import Cells
from squama.types import Array

COLUMNS = (*CONTACT, "ratio", "K", "d", "rigidity")
GRID = 33
"""Samples of a path that bracket a twist."""
NEAR = 1e-5
"""Relative step of the central differences along the twist."""
_NONE, _OTHER = CODES.index(End.NONE), CODES.index(End.OTHER)
_OFF = (CODES.index(End.OFF_TIP), CODES.index(End.OFF_SIDE))

Steps = dict[str, Array]
"""Imaginary parts of a result by the path's parameter that the complex step moves."""


def evaluate(c: Cells, moved: Sequence[Cells], wants: Sequence[Want], options: Options, *, plates: bool) -> Found:
    """Evaluate figures of designs (n,); each of ``moved`` has one variable moved by i STEP; ``plates``: test all."""
    n = c.eta.size
    columns = {name: np.stack([getattr(m, name) for m in moved or [c]]) for name in COLUMNS}
    used = [p for p in CONTACT if np.imag(columns[p]).any()]
    with_work = any(w.figure in ("RED", "W_fr") for w in wants)
    sol, limit = _follow(c, options, plates=plates, with_work=with_work)
    values, slopes = np.full((len(wants), n), np.nan), np.zeros((len(wants), len(moved), n))

    def put(i: int, index: Array, value: Array) -> None:
        values[i, index] = value[0].real
        if moved:
            slopes[i][:, index] = np.where(np.isfinite(value), value, 0.0).imag / STEP

    with np.errstate(all="ignore"):
        for i, want in enumerate(wants):
            if want.figure == "stiffness":
                put(i, np.arange(n), columns["rigidity"])
            elif want.at is not None:
                # before engagement the bar alone resists
                index = np.flatnonzero(want.at.per_pitch(c.d) <= np.minimum(sol.found.load_e, limit))
                d, rigidity = columns["d"][:, index], columns["rigidity"][:, index]
                put(i, index, rigidity * want.at.per_pitch(d) / d if want.figure == "torque" else rigidity)
        for index, t in sol.tracks:
            own = {name: column[:, index] for name, column in columns.items()}
            part = _Part(own, t, options, used, sol.found.W_fr[index], with_work=with_work)
            for i, want in enumerate(wants):
                if want.figure != "stiffness":
                    lanes, value = part.figure(want, limit[index], sol.found.code[index])
                    put(i, index[lanes], value[:, lanes])
    return Found(values, slopes, sol.found.code, sol.found.load_e, limit)


def _follow(c: Cells, options: Options, *, plates: bool, with_work: bool) -> tuple[Solution, Array]:
    """Return the solution of the designs, and the end of their curves (n,) in rad per pitch."""
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


class _Part:
    """One track of paths: figures of its designs, arrays (moved, n) with complex steps; ``columns`` have this shape."""

    def __init__(
        self, columns: Steps, t: Track, options: Options, used: Sequence[str], work: Array, *, with_work: bool
    ) -> None:
        self.columns, self.t, self.options = columns, t, options
        self.mu, sign = columns["mu"][0].real, 1 if options.sense == "+" else -1
        self.base: Tracked = tracked(t, self.mu, options.margin, options.law, work)
        self.seeds: dict[str, Seed] = {p: seed(self.base, p, sign) for p in used}
        self.moved: dict[str, Moved] = {p: move(self.base, s, with_work=with_work) for p, s in self.seeds.items()}
        self.grid: tuple[Array, Array] | None = None
        start = getattr(t.row, "open", t.row)
        self.engaged = np.asarray(start.point(t.row.theta0, "edge", ARRAY).load)

    def figure(self, want: Want, limit: Array, code: Array) -> tuple[Array, Array]:
        """Return the indices of the designs that have the figure, and its values (moved, n)."""
        if want.at is not None:
            phi = want.at.per_pitch(self.columns["d"])
            there = (phi[0].real > self.engaged) & (phi[0].real <= limit)
            return np.flatnonzero(there), self._at_twist(want.figure, phi, np.flatnonzero(there))
        locks = np.isin(code, _OFF if want.figure == "hold" else self.options.locks)
        if want.figure == "critical_mu":
            return np.arange(code.size), self._critical()
        if want.figure == "engagement":
            return np.flatnonzero(limit >= self.engaged), self._result(self.engaged, lambda m: m.load_e)
        if want.figure == "reach":
            # no derivative where other plates meet first
            return np.flatnonzero(code != _OTHER), self._result(limit, lambda m: m.load_end)
        if want.figure == "lock":
            value = self._result(limit, lambda m: m.load_end)
        elif want.figure == "range":
            value = self._result(limit - self.engaged, lambda m: m.load_end - m.load_e)
        else:
            value = self._room(want.figure) if want.figure in ("tip", "side", "hold") else self._dissipated(want.figure)
        return np.flatnonzero(locks), value

    def _stepped(self, value: Array, steps: Steps, lanes: Array | slice = slice(None)) -> Array:
        """Return a result (moved, n) with the steps of the moved variables, from ``steps`` by path parameter."""
        total = np.zeros_like(self.columns["d"][:, lanes].real)
        for p, step in steps.items():
            total += np.where(np.isfinite(step), step, 0.0) * self.columns[p][:, lanes].imag / STEP
        return value + 1j * total

    def _result(self, value: Array, of: Callable[[Moved], Array]) -> Array:
        """Return ``value`` with the complex steps of a field of :class:`Moved`."""
        return self._stepped(value, {p: np.imag(of(m)) for p, m in self.moved.items()})

    def _critical(self) -> Array:
        """Return the smallest friction coefficient that locks at engagement, (moved, n)."""
        law, pt, steps = self.options.law, self.t.row.point(self.t.x0, self.options.law, ARRAY), {}
        for p, s in self.seeds.items():
            start = s.row.point(s.row.parameter(s.row.theta0, COMPLEX) + 0j, law, COMPLEX)
            steps[p] = np.imag(mechanics.mu_lock(start))
        return self._stepped(np.where(pt.M_f > 0, mechanics.mu_lock(pt), np.nan), steps)

    def _room(self, figure: str) -> Array:
        """Return the room of the contact to the edge's end, or the moment missing to a lock, at the path's end."""
        law, t, b = self.options.law, self.t, self.base
        pt = t.row.point(t.x_end, law, ARRAY)
        side = np.sign(pt.p) if figure == "tip" else np.where(2 * pt.s < t.row.eta, 1.0, -1.0)

        def room(row: tracks.OneRow, mu: Array, at: Point) -> Array:
            if figure == "hold":
                return np.asarray((at.M_N + mu * at.M_f) / row.eta)
            if figure == "tip":
                return np.asarray(1 - side * at.p / row.beta)
            return np.asarray(np.where(side > 0, at.s, row.eta - at.s) / row.eta)

        steps = {}
        for p, s in self.seeds.items():
            rate = -np.imag(vanishing(s.row, s.row.point(t.x_end, law, COMPLEX), t, s.mu, law)) / b.E_x
            x = np.where(t.x_end == t.x0, s.row.parameter(s.row.theta0, COMPLEX) + 0j, t.x_end + 1j * rate)
            steps[p] = np.imag(room(s.row, s.mu, s.row.point(x, law, COMPLEX)))
        return self._stepped(room(t.row, self.mu, pt), steps)

    def _dissipated(self, figure: str) -> Array:
        """Return RED or frictional work (J/m) at the cut-off before a lock, (moved, n)."""
        c, t, work = self.columns, self.t, self._result(self.base.work, lambda m: m.W_fr)
        if figure == "W_fr":
            return work * c["K"] / c["d"]
        x_c = energy.cutoff(t.row, t.x0, t.x_end, np.isin(t.code, LOCKING), self.options.margin)
        pt, bears = t.row.point(x_c, self.options.law, ARRAY), x_c > t.x0
        load = self._result(np.where(bears, pt.load, self.engaged), lambda m: m.load_c)
        lift = self._result(np.where(bears, pt.theta, c["theta0"][0].real), lambda m: m.theta_c) - c["theta0"]
        total = (c["ratio"] * load**2 + lift**2) / 2 + work
        return np.where(total.real > 0, work / total, 0.0)

    def _at_twist(self, figure: str, phi: Array, lanes: Array) -> Array:
        """Return torque (N m) or tangent stiffness (N m^2) at twists (moved, n) in contact; NaN elsewhere."""
        K, d, rigidity, phi = (v[:, lanes] for v in (*(self.columns[n] for n in ("K", "d", "rigidity")), phi))
        at, turn, value = phi[0].real, 1j * phi.imag, np.full(self.columns["d"].shape, np.nan, complex)
        torque, slope, steps = self._torque(at, lanes)
        if figure == "torque":
            value[:, lanes] = K * (self._stepped(torque, steps, lanes) + slope * turn) + rigidity * phi / d
            return value
        bend = 0.0
        if self.seeds:
            h = NEAR * at
            (_, s1, p1), (_, s0, p0) = (self._torque(at + e, lanes) for e in (h, -h))
            steps, bend = {p: (p1[p] - p0[p]) / (2 * h) for p in self.seeds}, (s1 - s0) / (2 * h)
        value[:, lanes] = rigidity + K * d * (self._stepped(slope, steps, lanes) + bend * turn)
        return value

    def _torque(self, phi: Array, lanes: Array) -> tuple[Array, Array, Steps]:
        """Return the scales' torque over K_theta at a twist, its slope by the twist, its steps by path parameter."""
        law, mu = self.options.law, self.mu
        x = self._place(phi, lanes)
        row = tracks.take(self.t.row, lanes)
        pt = row.point(x + STEP * 1j, law, COMPLEX)
        torque = mechanics.forces(pt, row.theta0, mu[lanes]).torque
        slope = np.imag(torque) / np.imag(pt.load)
        steps = {}
        for p, s in self.seeds.items():
            r = tracks.take(s.row, lanes)
            at = r.point(x, law, COMPLEX)
            moved = mechanics.forces(at, r.theta0, np.broadcast_to(s.mu, mu.shape)[lanes]).torque
            steps[p] = np.imag(moved) - slope * np.imag(at.load)
        return np.real(torque), slope, steps

    def _place(self, phi: Array, lanes: Array) -> Array:
        """Return the path parameters at twists ``phi``: bracketed on a grid, then by Newton's method."""
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

"""One curve of one beam: points along the path, torque, forces and energies in SI units.

Twisting and bending differ only in the data of their :class:`Case`.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from squama.model import energy, mechanics
from squama.model.ends import Track
from squama.model.outcome import CODES, End
from squama.model.paths import ARRAY, FLOAT
from squama.model.plates import Touch
from squama.model.solution import SEARCH, Solution, other_words
from squama.model.solve import Array, first_zero, scalar

LINEAR = 10
"""Every LINEAR-th point of a curve lies before engagement."""


class Case(NamedTuple):
    """What a kind of loading brings: pitch, rigidity without contact (N m^2), joint stiffness (N m), sense."""

    pitch: float
    rigidity: float
    stiffness: float
    eta: float
    theta0: float
    mirrored: bool = False


class Curve(NamedTuple):
    """Variables along the curve (``along``) and single figures of it (``figures``), by their symbols' roles."""

    along: dict[str, Array]
    figures: dict[str, Any]


class Path(NamedTuple):
    """The solved path of one design, cut to the asked range; ``touch`` twist and inclination of the other contact.

    Without engagement ``load_end`` is how far the straight part goes.
    """

    row: Any
    x0: float
    x_end: float
    x_c: float
    pole: float
    load_e: float
    load_end: float
    theta_end: float
    end: End
    neighbour: int
    other: str
    mu: float
    law: str
    touch: tuple[float, float] = (np.nan, np.nan)

    @property
    def engaged(self) -> bool:
        """Whether part of the path is in contact."""
        return self.row is not None and self.x_c > self.x0


def path(case: Case, sol: Solution, touch: Touch | None, mu: float, law: str, margin: float, to: float | None) -> Path:
    """Cut the path of a single solved design at ``to`` (load angle per pitch) and place its cut-off."""
    end = CODES[int(sol.code[0])]
    load_e, load_end, theta_end = float(sol.load_e[0]), float(sol.load_end[0]), float(sol.theta_end[0])
    other = other_words(sol, [touch], 0, mirrored=case.mirrored)
    if end is End.NONE:
        # the straight part reaches to the other contact that comes first, or to the end of the search
        stop = touch.phi if touch else SEARCH
        stop = stop if to is None else min(stop, to)
        met = (touch.phi, case.theta0) if touch else (np.nan, np.nan)
        return Path(None, 0, 0, 0, 1, np.inf, stop, case.theta0, end, 0, other, mu, law, met)
    t: Track = sol.tracks[0][1]
    row = scalar(t.row)
    x0, x_end = float(t.x0[0]), float(t.x_end[0])
    # the pole of the friction force belongs to the path, wherever the asked range ends
    pole = float(energy.pole(t.row, t.x_end, np.array([mu]), law, t.x0)[0]) if x_end > x0 else x0 + 1
    if to is not None and to < load_end:
        end, other, load_end = End.RANGE, "", to
        x_end = float(invert(row, np.array([to]), x0, x_end, law)[0]) if to > load_e else x0
        theta_end = float(row.theta(x_end))
    locks = np.array([end in (End.FRICTIONAL, End.KINEMATIC)])
    x_c = float(energy.cutoff(t.row, t.x0, np.array([x_end]), locks, margin)[0])
    return Path(
        row,
        x0,
        x_end,
        x_c,
        float(pole),
        load_e,
        load_end,
        theta_end,
        end,
        int(sol.neighbour[0]),
        other,
        mu,
        law,
        (load_end, theta_end) if other else (np.nan, np.nan),
    )


def invert(row: Any, load: Array, x0: float, x_end: float, law: str) -> Array:
    """Path parameters at which the path reaches the load angles, all between its ends."""
    grid = np.linspace(x0, x_end, 257)
    with np.errstate(all="ignore"):
        seen = row.point(grid, law, ARRAY).load
    seen = np.maximum.accumulate(np.where(np.isfinite(seen), seen, -np.inf))
    i = np.clip(np.searchsorted(seen, load, side="left") - 1, 0, 255)

    def below(x: Any, target: Any) -> Any:
        return target - row.point(np.asarray(x, float), law, ARRAY).load

    inside = (load > seen[0]) & (load < seen[-1])
    x = np.where(load <= seen[0], x0, x_end)
    if inside.any():
        j = i[inside]
        x[inside] = first_zero(below, grid[j], grid[j + 1], (load[inside],))
    return x


def samples(p: Path, points: int) -> tuple[Array, Array]:
    """Load angles of the straight part, and path parameters of the part in contact; together ``points``."""
    if not p.engaged:
        return np.linspace(0.0, min(p.load_e, p.load_end), points), np.empty(0)
    straight = max(1, points // LINEAR)
    w = np.linspace(0.0, 1.0, points - straight)
    if p.end in (End.FRICTIONAL, End.KINEMATIC):
        # closer together where the curve steepens
        w = 1 - (1 - w) ** 2
    return np.linspace(0.0, p.load_e, straight, endpoint=False), p.x0 + (p.x_c - p.x0) * w


def evaluate(case: Case, p: Path, load: Array, x: Array) -> dict[str, Array]:
    """Every variable at the load angles before engagement, followed by the path parameters in contact."""
    d, K = case.pitch, case.stiffness
    n = load.size
    theta, angle = np.full(n + x.size, case.theta0), np.concatenate([load, x])
    scales, tangent, N, f, work = np.zeros((5, n + x.size))
    places = np.full((3, n + x.size), np.nan)
    if x.size:
        with np.errstate(all="ignore"):
            # a complex step gives the tangent without cancellation
            pt = p.row.point(x + 1e-30j, p.law, ARRAY)
            forces = mechanics.forces(pt, case.theta0, p.mu)
            theta[n:], angle[n:] = pt.theta.real, pt.load.real
            scales[n:], tangent[n:] = forces.torque.real, forces.torque.imag / pt.load.imag
            N[n:], f[n:] = forces.N.real, forces.f.real
            places[0, n:], places[1, n:], places[2, n:] = pt.p.real, pt.s.real, mechanics.mu_lock(pt).real
        work[n:] = energy.work(p.row, p.x0, float(x.max()), p.pole, p.mu, p.law)(x)
    rate, lift = angle / d, theta - case.theta0
    elastic = (case.rigidity * rate**2 + K / d * lift**2) / 2
    total = elastic + work * K / d
    return {
        "theta": theta,
        "load": angle,
        "rate": rate,
        "torque": case.rigidity * rate + K * scales,
        "scales": K * scales,
        "tangent": case.rigidity + K * d * tangent,
        "N": N * K / d,
        "f": f * K / d,
        "f0": f * case.eta,
        "p": places[0] * d,
        "s": places[1] * d,
        "mu_lock": places[2],
        "elastic": elastic,
        "work": work * K / d,
        "RED": np.divide(work * K / d, total, out=np.zeros_like(work), where=total > 0),
    }


def curve(case: Case, p: Path, *, points: int, at: Array | None) -> Curve:
    """Evaluate a path at its own points or at the given load angles; figures at its cut-off.

    Parameters
    ----------
    points
        Number of points, from load 0 to the cut-off.
    at
        Load angles per pitch instead; NaN comes back beyond the end of the path.
    """
    if at is None:
        load, x = samples(p, points)
    else:
        straight = at <= min(p.load_e, p.load_end)
        contact = ~straight & (at <= p.load_end)
        load = at[straight]
        x = invert(p.row, at[contact], p.x0, p.x_end, p.law) if contact.any() else np.empty(0)
        order = np.concatenate([np.flatnonzero(straight), np.flatnonzero(contact)])
    # the cut-off goes along as the last point
    cut = min(p.load_e, p.load_end)
    load, x = (load, np.append(x, p.x_c)) if p.engaged else (np.append(load, cut), x)
    values = evaluate(case, p, load, x)
    last = {name: float(v[-1]) for name, v in values.items()}
    along = {name: v[:-1] for name, v in values.items()}
    if at is not None:
        for name, v in along.items():
            along[name] = np.full(at.size, np.nan)
            along[name][order] = v
        along["load"], along["rate"] = at, at / case.pitch
    return Curve(along, _figures(case, p, last))


def _figures(case: Case, p: Path, last: dict[str, float]) -> dict[str, Any]:
    mu_static = np.nan
    if p.row is not None:
        pt = p.row.point(p.x0, p.law, FLOAT)
        mu_static = mechanics.mu_lock(pt) if pt.M_f > 0 else np.inf
    load_end = np.inf if p.end is End.NONE else p.load_end
    return {
        "load_e": p.load_e,
        "rate_e": p.load_e / case.pitch,
        "theta_end": p.theta_end,
        "load_end": load_end,
        "rate_end": load_end / case.pitch,
        "theta_c": last["theta"],
        "rate_c": last["rate"],
        "torque_c": last["torque"],
        "stiffening": last["torque"] / (case.rigidity * last["rate"]),
        "elastic_c": last["elastic"],
        "work_c": last["work"],
        "RED_c": last["RED"],
        "mu_static": mu_static,
        "end": str(p.end),
        "neighbour": p.neighbour,
        "other_contact": p.other,
        "load_touch": p.touch[0],
        "theta_touch": p.touch[1],
    }

"""Sweeps over eta, alpha and mu: regime maps, lock lines, and maps of the relative energy dissipation (RED)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike
from scipy.optimize import elementwise

from squama.arrays import edge_contacts, solution
from squama.batch import Solved
from squama.batch.answers import answers
from squama.beam.design import Beam
from squama.loads import LawName
from squama.model.evaluation import FOLDED
from squama.model.outcome import CODES, SLID, End
from squama.model.paths import ARRAY, Twist
from squama.symbols import SYMBOLS
from squama.types import Array

POINTS = 200
"""Number of points of a path."""

Ratios = dict[str, Any]
"""Ratios of many designs that determine the contact: eta, beta, lam, alpha, theta0 (rad), in this order, each (n,)."""


def known(axes: str | tuple[str, ...], **arrays: Array) -> dict[str, object]:
    """Return arrays as variables of a dataset, with the attributes of their symbols."""
    return {name: (axes, array, SYMBOLS[name].attrs) for name, array in arrays.items()}


def sweep(beam: Beam, over: str, values: Sequence[float] | Array) -> Ratios:
    """Return the ratios of a beam with one of them ("eta" or "alpha") replaced by each of the values."""
    v = np.asarray(values, float)
    return {name: np.full(v.size, value) for name, value in beam.ratios.items()} | {over: v}


def ends(r: Ratios, mu: float | Array, law: str) -> solution.Solution:
    """Solve the first tip-side contact of each design (n,), with one mu or mu (n,)."""
    mus = np.broadcast_to(np.asarray(mu, float), r["eta"].shape)
    return solution.solve({**r, "mu": mus}, law=law, sense="+")


def touch(r: Ratios) -> tuple[Array, Array]:
    """Return twist per pitch and inclination (n,), rad, at the first contact of other plates than the tip-side pair.

    Sought along the whole geometric path, on which friction and force law have no effect. inf and NaN for none.
    """
    e = edge_contacts.ends(**r, mu=0.0, law="edge", contacts="all")
    hit = np.isin(e.end, (str(End.OTHER), str(End.NONE)))
    return np.where(hit, e.phi_end, np.inf), np.where(hit, e.theta_end, np.nan)


def mu_static(r: Ratios, law: LawName) -> Array:
    """Return the coefficient of friction (n,) that locks at engagement, for the nearest neighbour; inf for none."""
    found = edge_contacts.forces(r["theta0"], **r, mu=0.0, law=law).mu_lock
    return np.where(found > 0, found, np.inf)


def kinematic_lock(r: Ratios) -> tuple[Array, Array]:
    """Return twist per pitch and inclination (n,), rad, at dphi/dtheta = 0, nearest neighbour; NaN for none."""
    eta, beta, lam, alpha, theta0 = r.values()
    row = Twist(eta, beta, lam, np.sin(alpha), np.cos(alpha), theta0)
    x = theta0 + (np.pi * (1 - 1e-9) - theta0) * np.linspace(0, 1, 401)[:, None]
    with np.errstate(all="ignore"):
        pt = row.point(x, "edge", ARRAY)
        inside = np.logical_and.accumulate((row.places(pt)[0] > 0) & (row.places(pt)[1] > 0) & np.isfinite(pt.q))
        stop = (pt.load_rate <= 0).argmax(axis=0)
    lane = np.flatnonzero((stop > 0) & inside[np.maximum(stop - 1, 0), np.arange(stop.size)])
    theta, phi = np.full(stop.size, np.nan), np.full(stop.size, np.nan)
    if lane.size:
        cols = tuple(np.asarray(c)[lane] if np.ndim(c) else np.full(lane.size, float(c)) for c in row)

        def rate(v: Array, *c: Array) -> Array:
            return np.asarray(Twist(*c).point(v, "edge", ARRAY).load_rate)

        bounds = x[stop[lane] - 1, lane], x[stop[lane], lane]
        theta[lane] = elementwise.find_root(rate, bounds, args=cols).x
        phi[lane] = Twist(*cols).point(theta[lane], "edge", ARRAY).load
    return phi, theta


def _coords(over: str, laws: Sequence[str], mus: ArrayLike, **along: ArrayLike) -> dict[str, object]:
    """Return the coordinates ``law`` and ``mu``, and those in ``along``, values of the ratio ``over``."""
    found = {name: (name, np.asarray(values, float), SYMBOLS[over].attrs) for name, values in along.items()}
    return {**found, **known("mu", mu=np.asarray(mus, float)), "law": list(laws)}


def regimes(
    beam: Beam,
    over: str,
    values: Sequence[float],
    scan: Array,
    mus: Sequence[float],
    laws: Sequence[str] = ("plate", "edge"),
) -> xr.Dataset:
    """Compute a regime map for :func:`squama.plot.regime_figure`: paths of a few designs, lock lines over one ratio.

    ``over`` names the ratio that is varied ("eta" or "alpha"), ``values`` are its values for the paths,
    ``scan`` those along the lock lines, increasing; ``mus`` (above 0) and ``laws`` of the frictional lines.
    """
    r, free = sweep(beam, over, scan), ends(sweep(beam, over, values), 0.0, "edge")
    # each geometric path ends at its kinematic lock or where the contact leaves
    phi, theta = free.sampled(POINTS)
    found = [[ends(r, mu, law).found for mu in mus] for law in laws]
    along = ("load_end", "theta_end", "end")
    phi_end, theta_end, end = (np.array([[getattr(s, name) for s in row] for row in found]) for name in along)
    phi_lock, theta_lock = kinematic_lock(r)
    plain = ends(r, 0.0, "edge").found
    off = np.isin(plain.code, (CODES.index(End.OFF_TIP), CODES.index(End.OFF_SIDE)))
    phi_touch, theta_touch = touch(r)
    phi_off, theta_off = np.where(off, [plain.load_end, plain.theta_end], np.nan)
    lines = {
        "lock": (phi_lock, theta_lock, "at the kinematic lock"),
        "off": (phi_off, theta_off, "where the contact leaves the tip edge"),
        "touch": (np.where(np.isfinite(phi_touch), phi_touch, np.nan), theta_touch, "where other plates touch"),
    }
    data = known(("value", "point"), phi=phi, theta=theta)
    data["path_end"] = "value", free.found.end, SYMBOLS["end"].attrs
    data |= known(("law", "mu", "scan"), phi_end=phi_end, theta_end=theta_end, end=end)
    for name, (phi, theta, where) in lines.items():
        for base, line in (("phi", phi), ("theta", theta)):
            about = {"long_name": f"{SYMBOLS[base].long_name} {where}", "units": "rad"}
            data[f"{base}_{name}"] = "scan", line, about
    coords = _coords(over, laws, mus, value=values, scan=scan)
    return xr.Dataset(data, coords, {"over": over, "theta0": beam.scale.theta0, "beam": beam.to_toml()})


def lock_lines(beam: Beam, mus: Sequence[float], etas: Array, law: str, points: int = 120) -> xr.Dataset:
    """Compute the lock lines of bending and twisting as eta varies, and their distance from the kinematic line.

    ``mus`` are above 0, ``etas`` increase, ``law`` is the force law in twisting; ``points`` of a line are equidistant
    in the load angle. Returns ``load``, ``theta`` and ``drop`` over ``loading``, ``mu`` (0 for the kinematic line) and
    ``point``; ``drop`` is NaN where a line has no kinematic point at the same load angle or locks statically.
    """
    all_mus = [0.0, *mus]
    shape = (2, len(all_mus), points)
    load, theta, drop = np.full((3, *shape), np.nan)
    r = sweep(beam, "eta", etas)
    for i in range(2):
        base = np.empty(0), np.empty(0)
        for j, mu in enumerate(all_mus):
            # bending in the plane, about the scaled face
            flat = {} if i else {"alpha": 0 * etas, "lam": 0 * etas}
            designs = {**r, **flat, "mu": np.full(etas.size, mu)}
            sol = solution.solve(designs, load="twisting" if i else "bending", law=law, sense="+")
            x, y = sol.found.load_end, sol.found.theta_end
            keep = np.isin(sol.found.code, SLID)
            if i == 1 and j == 0:
                x, y = kinematic_lock(r)
                keep = np.isfinite(x)
            order = np.flatnonzero(keep)[np.argsort(x[keep])]
            x, y = x[order], y[order]
            if j == 0:
                base = x, y
            if x.size < 2:
                continue
            load[i, j] = np.linspace(x[0], x[-1], points)
            theta[i, j] = _line(x, y, load[i, j])
            drop[i, j] = _line(*base, load[i, j]) - theta[i, j]
    angle = {"long_name": "load angle per pitch (psi in bending, phi in twisting)", "units": "rad"}
    axes = ("loading", "mu", "point")
    data: dict[str, object] = {
        "load": (axes, load, angle),
        "theta": (axes, theta, SYMBOLS["theta_end"].attrs),
        "drop": (axes, drop, {"long_name": "inclination below the kinematic lock", "units": "rad"}),
    }
    coords = {"loading": ["bending", "twisting"], "mu": ("mu", np.array(all_mus), SYMBOLS["mu"].attrs)}
    return xr.Dataset(data, coords, {"law": law, "eta_low": etas[0], "eta_high": etas[-1], "theta0": beam.scale.theta0})


def _line(x: Array, y: Array, at: Array) -> Array:
    """Return a cubic spline through x, y at ``at``; NaN outside."""
    from scipy.interpolate import CubicSpline

    outside = (at < x[0] - 1e-12) | (at > x[-1] + 1e-12)
    return np.where(outside, np.nan, CubicSpline(x, y)(np.clip(at, x[0], x[-1])))


def dissipation(beam: Beam, r: Ratios, mu: Array, law: str, margin: float) -> tuple[Solved, Array]:
    """Solve many designs on one substrate up to the margin before a lock (RED: paper Eqs. 15, 16).

    Return also whether each path has passed a fold at its end; the margin counts otherwise there, and RED jumps.
    """
    softness = np.full(mu.size, beam.torsional_rigidity / (beam.joint_stiffness * beam.pitch))
    a = answers((*r.values(), mu), law=law, sense="+", margin=margin, load="twisting")
    return Solved.of(a, r["theta0"], softness), (a.kind == FOLDED) & (a.x_end > 0)


def red_map(
    beam: Beam, over: str, values: Array, mus: Array, laws: Sequence[LawName] = ("plate", "edge"), margin: float = 0.01
) -> xr.Dataset:
    """Compute RED over one ratio and the coefficient of friction, with constant substrate and joint stiffness.

    Returns ``RED``, ``end``, ``phi_end``, ``folded`` over ``law``, ``value`` (of the ratio ``over``) and ``mu``;
    ``mu_static`` over ``law`` and ``value``; ``phi_touch`` over ``value``.
    """
    v, m = (a.ravel() for a in np.meshgrid(values, mus, indexing="ij"))
    shape = (len(laws), values.size, mus.size)
    every = sweep(beam, over, v)
    solved, folds = zip(*(dissipation(beam, every, m, law, margin) for law in laws), strict=True)
    columns = {"RED": "RED", "phi_end": "load_end", "end": "end"}
    arrays = {name: np.array([getattr(s, own) for s in solved]).reshape(shape) for name, own in columns.items()}
    data = known(("law", "value", "mu"), **arrays)
    one = sweep(beam, over, values)
    about = {"long_name": "whether the path has passed a fold at its end", "units": "1"}
    data["folded"] = ("law", "value", "mu"), np.array(folds).reshape(shape), about
    about = {"long_name": "twist per pitch where other plates touch", "units": "rad"}
    data["phi_touch"] = "value", touch(one)[0], about
    data |= known(("law", "value"), mu_static=np.stack([mu_static(one, law) for law in laws]))
    coords = _coords(over, laws, mus, value=values)
    return xr.Dataset(data, coords, {"over": over, "margin": margin, "beam": beam.to_toml()})

"""Sweeps over eta, alpha and mu: regime maps and lock lines."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from squama.design import Beam
from squama.model import mechanics, solution
from squama.model.outcome import CODES, End
from squama.model.paths import ARRAY, Twist
from squama.model.solve import Array, first_zero
from squama.symbols import SYMBOLS


class Ratios(NamedTuple):
    """What the contact of many designs depends on: arrays of one length, rad."""

    eta: Array
    beta: Array
    lam: Array
    alpha: Array
    theta0: Array


def sweep(beam: Beam, over: str, values: Sequence[float] | Array) -> Ratios:
    """Return the ratios of a beam with one of them ("eta" or "alpha") replaced by each of the values."""
    v = np.asarray(values, float)
    columns = {name: np.full(v.size, value) for name, value in beam.ratios.items()}
    columns[over] = v
    return Ratios(**columns)


def ends(r: Ratios, mu: float | Array, law: str) -> solution.Solution:
    """Follow the tip-side contact that is met first in each design."""
    mus = np.broadcast_to(np.asarray(mu, float), r.eta.shape)
    return solution.solve_twisting(*r, mus, law=law, sense="+")


def touch(r: Ratios) -> tuple[Array, Array]:
    """Twist per pitch and inclination at which a pair of plates other than the tip-side one touches.

    Looked for along the whole geometric path, which friction and force law do not change. inf and NaN for none.
    """
    from squama import api

    e = api.ends(**r._asdict(), mu=0.0, law="edge", contacts="all")
    hit = np.isin(e.end, (str(End.OTHER), str(End.NONE)))
    return np.where(hit, e.phi_end, np.inf), np.where(hit, e.theta_end, np.nan)


def mu_static(r: Ratios, law: str) -> Array:
    """Coefficient of friction that locks at engagement, for the nearest neighbour; inf for none."""
    row = Twist(*r[:3], np.sin(r.alpha), np.cos(r.alpha), r.theta0)
    with np.errstate(all="ignore"):
        pt = row.point(r.theta0, law, ARRAY)
        return np.asarray(np.where(pt.M_f > 0, mechanics.mu_lock(pt), np.inf))


def kinematic_lock(r: Ratios) -> tuple[Array, Array]:
    """Twist per pitch and inclination at which dphi/dtheta = 0 for the nearest neighbour; NaN if it is not reached."""
    row = Twist(*r[:3], np.sin(r.alpha), np.cos(r.alpha), r.theta0)
    x = r.theta0 + (np.pi * (1 - 1e-9) - r.theta0) * np.linspace(0, 1, 401)[:, None]
    with np.errstate(all="ignore"):
        pt = row.point(x, "edge", ARRAY)
        inside = np.logical_and.accumulate((row.places(pt)[0] > 0) & (row.places(pt)[1] > 0) & np.isfinite(pt.q))
        stop = (pt.load_rate <= 0).argmax(axis=0)
    lane = np.flatnonzero((stop > 0) & inside[np.maximum(stop - 1, 0), np.arange(stop.size)])
    theta, phi = np.full(stop.size, np.nan), np.full(stop.size, np.nan)
    if lane.size:
        cols = tuple(np.asarray(c)[lane] if np.ndim(c) else np.full(lane.size, float(c)) for c in row)

        def rate(v: Any, *c: Any) -> Any:
            return Twist(*c).point(np.asarray(v, float), "edge", ARRAY).load_rate

        theta[lane] = first_zero(rate, x[stop[lane] - 1, lane], x[stop[lane], lane], cols)
        phi[lane] = Twist(*cols).point(theta[lane], "edge", ARRAY).load
    return phi, theta


def _paths(r: Ratios, points: int) -> tuple[Array, Array, list[str]]:
    """Twist and inclination along each geometric path, to its kinematic lock or to where the contact goes."""
    sol = ends(r, 0.0, "edge")
    phi, theta = np.full((r.eta.size, points), np.nan), np.full((r.eta.size, points), np.nan)
    for index, t in sol.tracks:
        w = np.linspace(0, 1, points)[:, None]
        x = t.x0 + (t.x_end - t.x0) * w
        with np.errstate(all="ignore"):
            pt = t.row.point(x, "edge", ARRAY)
        phi[index], theta[index] = pt.load.T, np.broadcast_to(pt.theta, x.shape).T
    return phi, theta, [str(CODES[c]) for c in sol.code]


def regimes(
    beam: Beam,
    over: str,
    values: Sequence[float],
    scan: Array,
    mus: Sequence[float],
    laws: Sequence[str] = ("plate", "edge"),
    points: int = 200,
) -> xr.Dataset:
    """Compute a regime map: paths of a few designs, lock lines as one ratio is varied.

    Parameters
    ----------
    beam : Beam
        The design.
    over : {"eta", "alpha"}
        The ratio that is varied.
    values : sequence of float
        Its values for the paths.
    scan : array
        Its values along the lock lines, increasing.
    mus, laws : sequence
        Coefficients of friction (above 0) and force laws of the frictional lock lines.
    points : int
        Points of a path.

    Returns
    -------
    xarray.Dataset
        See :func:`squama.plot.regime_figure`.
    """
    r, c = sweep(beam, over, scan), sweep(beam, over, values)
    phi, theta, how = _paths(c, points)
    shape = (len(laws), len(mus), scan.size)
    phi_end, theta_end, end = np.empty(shape), np.empty(shape), np.empty(shape, "U24")
    for i, law in enumerate(laws):
        for j, mu in enumerate(mus):
            sol = ends(r, mu, law)
            phi_end[i, j], theta_end[i, j] = sol.load_end, sol.theta_end
            end[i, j] = [str(CODES[k]) for k in sol.code]
    phi_lock, theta_lock = kinematic_lock(r)
    plain = ends(r, 0.0, "edge")
    off = np.isin(plain.code, (CODES.index(End.OFF_TIP), CODES.index(End.OFF_SIDE)))
    phi_touch, theta_touch = touch(r)
    lines = {
        "phi_lock": phi_lock,
        "theta_lock": theta_lock,
        "phi_off": np.where(off, plain.load_end, np.nan),
        "theta_off": np.where(off, plain.theta_end, np.nan),
        "phi_touch": np.where(np.isfinite(phi_touch), phi_touch, np.nan),
        "theta_touch": theta_touch,
    }
    words = {
        "lock": "at the kinematic lock",
        "off": "where the contact leaves the tip edge",
        "touch": "where other plates touch",
    }
    data: dict[str, Any] = {
        "phi": (("value", "point"), phi, SYMBOLS["phi"].attrs),
        "theta": (("value", "point"), theta, SYMBOLS["theta"].attrs),
        "path_end": ("value", np.array(how), SYMBOLS["end"].attrs),
        "phi_end": (("law", "mu", "scan"), phi_end, SYMBOLS["phi_end"].attrs),
        "theta_end": (("law", "mu", "scan"), theta_end, SYMBOLS["theta_end"].attrs),
        "end": (("law", "mu", "scan"), end, SYMBOLS["end"].attrs),
    }
    for name, line in lines.items():
        base, place = name.split("_")
        text = f"{SYMBOLS[base].long_name} {words[place]}"
        data[name] = ("scan", line, {"long_name": text, "units": "rad"})
    coords = {
        "value": ("value", np.asarray(values, float), SYMBOLS[over].attrs),
        "scan": ("scan", scan, SYMBOLS[over].attrs),
        "mu": ("mu", np.asarray(mus, float), SYMBOLS["mu"].attrs),
        "law": list(laws),
    }
    return xr.Dataset(data, coords, {"over": over, "theta0": beam.scale.theta0, "beam": beam.to_toml()})


def lock_lines(beam: Beam, mus: Sequence[float], etas: Array, law: str, points: int = 120) -> xr.Dataset:
    """Compute the lock lines of bending and twisting as eta varies, and their distance from the kinematic line.

    Parameters
    ----------
    beam : Beam
        The design.
    mus : sequence of float
        Coefficients of friction above 0.
    etas : array
        Overlap ratios, increasing.
    law : str
        Force law in twisting.
    points : int
        Points of a line, evenly spaced in the load angle.

    Returns
    -------
    xarray.Dataset
        ``load``, ``theta`` and ``drop`` over ``loading``, ``mu`` (0 for the kinematic line) and ``point``; ``drop`` is
        NaN where a line has no kinematic point at the same load angle or locks statically.
    """
    all_mus = [0.0, *mus]
    shape = (2, len(all_mus), points)
    load, theta, drop = np.full(shape, np.nan), np.full(shape, np.nan), np.full(shape, np.nan)
    r = sweep(beam, "eta", etas)
    for i in range(2):
        base: tuple[Array, Array] = (np.empty(0), np.empty(0))
        for j, mu in enumerate(all_mus):
            m = np.full(etas.size, mu)
            sol = ends(r, m, law) if i else solution.solve_bending(etas, r.theta0, m)
            x, y = sol.load_end, sol.theta_end
            keep = np.isin(sol.code, (CODES.index(End.FRICTIONAL), CODES.index(End.KINEMATIC)))
            if i == 1 and j == 0:
                x, y = kinematic_lock(r)
                keep = np.isfinite(x)
            order = np.argsort(x[keep])
            x, y = x[keep][order], y[keep][order]
            if j == 0:
                base = (x, y)
            if x.size < 2:
                continue
            load[i, j] = np.linspace(x[0], x[-1], points)
            theta[i, j] = _line(x, y, load[i, j])
            drop[i, j] = _line(*base, load[i, j]) - theta[i, j]
    angle = {"long_name": "load angle per pitch (psi in bending, phi in twisting)", "units": "rad"}
    axes = ("loading", "mu", "point")
    data: dict[str, Any] = {
        "load": (axes, load, angle),
        "theta": (axes, theta, SYMBOLS["theta_end"].attrs),
        "drop": (axes, drop, {"long_name": "inclination below the kinematic lock", "units": "rad"}),
    }
    coords = {"loading": ["bending", "twisting"], "mu": ("mu", np.array(all_mus), SYMBOLS["mu"].attrs)}
    return xr.Dataset(data, coords, {"law": law, "eta_low": etas[0], "eta_high": etas[-1], "theta0": beam.scale.theta0})


def _line(x: Array, y: Array, at: Array) -> Array:
    """Interpolate a smooth line; NaN outside."""
    from scipy.interpolate import CubicSpline

    return np.asarray(
        CubicSpline(x, y, extrapolate=False)(np.clip(at, x[0], x[-1]))
        + np.where((at < x[0] - 1e-12) | (at > x[-1] + 1e-12), np.nan, 0.0)
    )

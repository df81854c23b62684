"""The claims of the paper on twisting, each with the numbers that show whether it holds."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np
import xarray as xr

from squama import api
from squama.model.outcome import CODES, End
from squama.model.solve import Array
from squama.paper import maps
from squama.paper import parameters as par
from squama.paper.tables import Claim

FRICTIONAL, STATIC = CODES.index(End.FRICTIONAL), CODES.index(End.STATIC)
LOW_ALPHAS = (1.0, 5.0, 10.0, 15.0, 20.0)
"""Below about 23 deg there is no kinematic lock, deg."""
MU_GRID = np.round(np.arange(0.0, 6.0, 0.01), 2)


def numbers(values: Sequence[float] | Array, form: str = ".3g") -> str:
    """Write numbers one after the other; "none" for NaN."""
    return ", ".join("none" if math.isnan(v) else format(float(v), form) for v in values)


def yes(flag: bool) -> str:
    """Return "yes" or "no"."""
    return "yes" if flag else "no"


def fig4(data: xr.Dataset) -> list[Claim]:
    """f0 rises without bound towards one asymptote for each mu, which moves to smaller twist as mu grows."""
    out = []
    mus = [float(mu) for mu in data["mu"].values]
    r: dict[str, Any] = par.main().ratios
    for law in par.LAWS:
        part = data.sel(law=law)
        ends = part["phi_end"].values / part["phi_e"].values
        growth = []
        for mu, end in zip(mus, part["theta_end"].values, strict=True):
            at = end - (end - r["theta0"]) * np.array([1e-3, 1e-6])
            f0 = api.forces(at, **r, mu=mu, law=law).friction
            growth.append(float(f0[1] / f0[0]))
        pole = bool(np.all(np.abs(np.array(growth) / 1000 - 1) < 0.05))
        out.append(
            Claim(
                "fig4",
                "the friction force rises without bound towards a lock",
                law,
                "f0 at 1e-6 over f0 at 1e-3 of the path before the lock, least over mu (1000 for a simple pole)",
                f"{min(growth):.1f}",
                "",
                yes(pole),
            )
        )
        out.append(
            Claim(
                "fig4",
                "the asymptote moves to smaller twist as mu grows",
                law,
                f"Phi_lock/Phi_e at mu = {numbers(mus)}",
                numbers(ends, ".4f"),
                "",
                yes(bool(np.all(np.diff(ends) < 0))),
            )
        )
    return out


def fig5a(drops: dict[str, xr.Dataset]) -> list[Claim]:
    """Frictional envelopes lie below the kinematic one, are no translates of it and meet the axis at high mu."""
    out = []
    etas = np.array(par.FIG5_ETAS)
    for law in par.LAWS:
        twisting = drops[law].sel(loading="twisting")
        mus = twisting["mu"].values[1:]
        drop = np.degrees(twisting["drop"].values[1:])
        least, spread = np.nanmin(drop, axis=1), np.nanmax(drop, axis=1) - np.nanmin(drop, axis=1)
        out.append(
            Claim(
                "fig5a",
                "each frictional envelope lies below the kinematic one",
                law,
                f"least drop of theta below it at the same phi, mu = {numbers(mus)}",
                numbers(least),
                "deg",
                yes(bool(np.all(least > 0))),
            )
        )
        out.append(
            Claim(
                "fig5a",
                "it is not a translate of the kinematic envelope",
                law,
                f"largest less least drop along the envelope, eta {par.BENDING_ETAS[0]:g} to "
                f"{par.BENDING_ETAS[-1]:g}, mu = {numbers(mus)}",
                numbers(spread),
                "deg",
                yes(bool(np.all(spread > 1.0))),
                "0 for a translate; in bending it is 0 (figure bending)",
            )
        )
        static = maps.mu_static(maps.sweep(par.main(), "eta", etas), law)
        out.append(
            Claim(
                "fig5a",
                "for large mu the envelope meets the axis (static lock)",
                law,
                f"mu_static at eta = {numbers(etas)}",
                numbers(static),
                "",
                yes(bool(np.all(np.isfinite(static)))),
                f"{static.min() / par.PLA_ON_PLA[1]:.0f} times the largest friction measured of printed PLA on PLA "
                f"({par.PLA_ON_PLA[0]:g} to {par.PLA_ON_PLA[1]:g})",
            )
        )
    return out


def least_lock(alpha: float, law: str, *, plates: bool) -> float:
    """Least mu of a grid from which on the beam locks by friction at this alpha (rad); NaN if it does not.

    ``plates``: a lock counts only if no other pair of plates touches before it.
    """
    r = maps.sweep(par.main(), "alpha", np.full(MU_GRID.size, alpha))
    sol = maps.ends(r, MU_GRID, law)
    locked = np.isin(sol.code, (FRICTIONAL, STATIC))
    if plates:
        phi, _ = maps.touch(maps.sweep(par.main(), "alpha", [alpha]))
        locked &= sol.load_end <= phi[0]
    open_until = np.flatnonzero(~locked).max(initial=-1) + 1
    return float(MU_GRID[open_until]) if open_until < MU_GRID.size else math.nan


def fold_alpha() -> float:
    """Return the alpha (rad, to .01 deg) below which the path of the main case without friction passes a fold."""
    r = maps.sweep(par.main(), "alpha", np.radians(np.arange(5.0, 25.0, 0.01)))._asdict()
    e = api.ends(**r, mu=0.0)
    theta0 = r.pop("theta0")
    before = api.contact(np.maximum(e.theta_end, theta0), **r).phi
    # past a fold the end does not lie on the branch that starts at engagement
    return float(r["alpha"][~np.isclose(before, e.phi_end, rtol=1e-6)].max())


def fig5b() -> list[Claim]:
    """Higher alpha engages, steepens and locks earlier; locks at low alpha; static locks."""
    alphas = np.radians([30.0, 40.0, 50.0, 60.0, 70.0])
    r = maps.sweep(par.main(), "alpha", alphas)
    phi_e = maps.ends(r, 0.0, "edge").load_e
    steep = 1 / api.contact(r.theta0, eta=r.eta, beta=r.beta, lam=r.lam, alpha=r.alpha).dphi_dtheta
    phi_lock, _ = maps.kinematic_lock(r)
    words = "alpha = 30, 40, 50, 60, 70 deg"
    out = [
        Claim(
            "fig5b", "higher alpha engages earlier", "both", f"phi_e at {words}", numbers(phi_e), "rad", _falls(phi_e)
        ),
        Claim(
            "fig5b",
            "higher alpha is steeper",
            "both",
            f"dtheta/dphi at engagement, {words}",
            numbers(steep),
            "",
            _falls(-steep),
        ),
        Claim(
            "fig5b",
            "higher alpha locks earlier",
            "both",
            f"phi at the kinematic lock, {words}",
            numbers(phi_lock),
            "rad",
            _falls(phi_lock),
        ),
    ]
    scan = np.radians(np.arange(1.0, 40.0, 0.1))
    none = np.isnan(maps.kinematic_lock(maps.sweep(par.main(), "alpha", scan))[0])
    out.append(
        Claim(
            "fig5b",
            "at low alpha there is no kinematic lock",
            "both",
            "largest alpha without one",
            f"{np.degrees(scan[none].max()):.1f}",
            "deg",
            yes(bool(none[0])),
            f"the contact leaves the tip edge, below {math.degrees(fold_alpha()):.1f} deg past a fold",
        )
    )
    for law in par.LAWS:
        alone = [least_lock(math.radians(a), law, plates=False) for a in LOW_ALPHAS]
        real = [least_lock(math.radians(a), law, plates=True) for a in LOW_ALPHAS]
        names = f"at alpha = {numbers(LOW_ALPHAS)} deg"
        free = all(mu <= 0.01 for mu in alone)
        low = "it locks without friction where mu = 0 is listed: the law does not satisfy virtual work"
        high = "at less friction the contact leaves the tip edge, or the scales come back to rest past the fold"
        out.append(
            Claim(
                "fig5b",
                "friction locks the beam also where there is no kinematic lock",
                law,
                f"least mu that locks, tip-side contact alone, {names}",
                numbers(alone),
                "",
                yes(free) if free else "in part",
                low if 0 in alone else high,
            )
        )
        out.append(
            Claim(
                "fig5b",
                "friction locks the beam also where there is no kinematic lock",
                law,
                f"least mu that locks before another pair of plates touches, {names}",
                numbers(real),
                "",
                "in part",
                "at less friction the model of one contact ends before any lock",
            )
        )
    for law in par.LAWS:
        scan = np.radians(np.array([0.01, 10, 20, 30, 45, 60, 70]))
        static = maps.mu_static(maps.sweep(par.main(), "alpha", scan), law)
        rises = bool(np.all(np.diff(static) > 0))
        top = np.degrees(scan[static.argmax()])
        out.append(
            Claim(
                "fig5b",
                "static lock needs a larger mu as alpha grows",
                law,
                "mu_static at alpha = 0.01, 10, 20, 30, 45, 60, 70 deg",
                numbers(static),
                "",
                "yes" if rises else "in part",
                "" if rises else f"it falls again beyond {top:.0f} deg",
            )
        )
    return out


def _falls(values: Array) -> str:
    return yes(bool(np.all(np.diff(values) < 0)))


def fig6a(data: xr.Dataset) -> list[Claim]:
    """Torque and stiffness of the scales rise with mu."""
    out = []
    mus = [float(mu) for mu in data["mu"].values]
    for law in par.LAWS:
        part = data.sel(law=law)
        last = float(part["phi_end"].min())
        phi = np.linspace(float(part["phi_e"][0]) * 1.01, 0.98 * last, 60)
        for name, word in (("T_K", "torque"), ("K_K", "stiffness")):
            lines = [np.interp(phi, part["phi"][i].values, part[name][i].values) for i in range(len(mus))]
            ratio = np.min([b / a for a, b in pairwise(lines)])
            middle = [float(line[phi.size // 2]) for line in lines]
            out.append(
                Claim(
                    "fig6a",
                    f"the {word} rises with mu",
                    law,
                    f"{word} over K_theta at phi = {phi[phi.size // 2]:.4f} rad, mu = {numbers(mus)}",
                    numbers(middle),
                    "",
                    yes(bool(ratio > 1)),
                    f"least ratio of neighbouring curves up to the first lock: {ratio:.3f}",
                )
            )
    return out


def bending(data: xr.Dataset) -> list[Claim]:
    """In bending the lock line is a translate by arctan(mu); in twisting it is not."""
    out = []
    mus = data["mu"].values[1:]
    for loading in ("bending", "twisting"):
        drop = np.degrees(data.sel(loading=loading)["drop"].values[1:])
        off = np.nanmax(abs(drop - np.degrees(np.arctan(mus))[:, None]), axis=1)
        spread = np.nanmax(drop, axis=1) - np.nanmin(drop, axis=1)
        translate = bool(np.all(spread < 1e-3))
        out.append(
            Claim(
                "bending",
                "the lock line is a translate by arctan(mu) in theta + psi/2"
                if loading == "bending"
                else "in twisting the lock line is no translate",
                "edge" if loading == "twisting" else "both",
                f"largest less least drop; largest distance from arctan(mu), mu = {numbers(mus)}",
                f"{numbers(spread, '.2g')}; {numbers(off, '.2g')}",
                "deg",
                yes(translate if loading == "bending" else not translate),
            )
        )
    return out

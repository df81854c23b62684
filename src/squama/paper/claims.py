"""Claims of the paper on twisting, each with computed numbers and a verdict."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import Any

import numpy as np
import xarray as xr

from squama.arrays import edge_contacts
from squama.model.outcome import CODES, End
from squama.paper import maps
from squama.paper import parameters as par
from squama.paper.parameters import Claim
from squama.types import Array

FRICTIONAL, STATIC = CODES.index(End.FRICTIONAL), CODES.index(End.STATIC)
LOW_ALPHAS = (1.0, 5.0, 10.0, 15.0, 20.0)
"""Values of alpha, deg, below about 23 deg, where there is no kinematic lock."""
MU_GRID = np.round(np.arange(0.0, 6.0, 0.01), 2)
FLAT = 0.25
"""Largest variation of RED over eta, as a share of that over mu, with which RED counts as nearly flat in eta."""


def numbers(values: Sequence[float] | Array, form: str = ".3g") -> tuple[str, ...]:
    """Return numbers as text; "none" for NaN."""
    return tuple("none" if math.isnan(v) else format(float(v), form) for v in values)


def at(name: str, values: Sequence[float] | Array, unit: str = "") -> tuple[str, ...]:
    """Return the places of values as text: "mu = 0.2", ..."""
    return tuple(f"{name} = {text} {unit}".strip() for text in numbers(values, "g"))


def yes(flag: bool | np.bool | Array) -> str:
    """Return "yes" or "no"; "yes" for an array if all entries are true."""
    return "yes" if np.all(flag) else "no"


def falls(values: Array) -> str:
    """Return "yes" if numbers decrease from one to the next, else "no"."""
    return yes(np.diff(values) < 0)


def fig4(data: xr.Dataset) -> Iterator[Claim]:
    """Claim: f0 rises without bound towards one asymptote for each mu, at smaller twist for larger mu."""
    mus = [float(mu) for mu in data["mu"].values]
    r: dict[str, Any] = par.main().ratios
    for law in par.LAWS:
        part = data.sel(law=law)
        ends = part["phi_end"].values / part["phi_e"].values
        growth = []
        for mu, end in zip(mus, part["theta_end"].values, strict=True):
            near = end - (end - r["theta0"]) * np.array([1e-3, 1e-6])
            f0 = edge_contacts.forces(near, **r, mu=mu, law=law).friction
            growth.append(float(f0[1] / f0[0]))
        text = "the friction force rises without bound towards a lock"
        what = "f0 at 1e-6 over f0 at 1e-3 of the path before the lock, least over mu (1000 for a simple pole)"
        holds = yes(np.abs(np.array(growth) / 1000 - 1) < 0.05)
        yield Claim("fig4", text, law, what, numbers([min(growth)], ".1f"), "", holds)
        text = "the asymptote moves to smaller twist as mu grows"
        yield Claim("fig4", text, law, "Phi_lock/Phi_e", numbers(ends, ".4f"), "", falls(ends), at=at("mu", mus))


def fig5a() -> Iterator[Claim]:
    """Claim: frictional envelopes lie below the kinematic one, are no translates of it and meet the axis at high mu."""
    etas = np.array(par.FIG5_ETAS)
    for law in par.LAWS:
        lines = maps.lock_lines(par.main(), par.BENDING_MUS, par.BENDING_ETAS, law)
        twisting = lines.sel(loading="twisting")
        mus = twisting["mu"].values[1:]
        drop = np.degrees(twisting["drop"].values[1:])
        least, spread = np.nanmin(drop, axis=1), np.nanmax(drop, axis=1) - np.nanmin(drop, axis=1)
        text = "each frictional envelope lies below the kinematic one"
        what, places = "least drop of theta below it at the same phi", at("mu", mus)
        yield Claim("fig5a", text, law, what, numbers(least), "deg", yes(least > 0), at=places)
        text = "it is not a translate of the kinematic envelope"
        low, high = par.BENDING_ETAS[0], par.BENDING_ETAS[-1]
        what = f"largest less least drop along the envelope, eta {low:g} to {high:g}"
        note = "0 for a translate; in bending it is 0 (figure bending)"
        yield Claim("fig5a", text, law, what, numbers(spread), "deg", yes(spread > 1.0), note, places)
        static = maps.mu_static(maps.sweep(par.main(), "eta", etas), law)
        text = "for large mu the envelope meets the axis (static lock)"
        holds = yes(np.isfinite(static))
        low, high = par.PLA_ON_PLA
        measured = f"the largest friction measured of printed PLA on PLA ({low:g} to {high:g})"
        note = f"{static.min() / high:.0f} times {measured}"
        yield Claim("fig5a", text, law, "mu_static", numbers(static), "", holds, note, at("eta", etas))


def least_lock(alpha: float, law: str, *, plates: bool) -> float:
    """Return the least mu of a grid from which the beam locks by friction at alpha (rad); NaN for none.

    ``plates``: whether a lock counts only if no other pair of plates touches before it.
    """
    r = maps.sweep(par.main(), "alpha", np.full(MU_GRID.size, alpha))
    sol = maps.ends(r, MU_GRID, law).found
    locked = np.isin(sol.code, (FRICTIONAL, STATIC))
    if plates:
        phi, _ = maps.touch(maps.sweep(par.main(), "alpha", [alpha]))
        locked &= sol.load_end <= phi[0]
    open_until = np.flatnonzero(~locked).max(initial=-1) + 1
    return float(MU_GRID[open_until]) if open_until < MU_GRID.size else math.nan


def fold_alpha() -> float:
    """Return alpha (rad, to .01 deg) below which the frictionless path of the main case passes a fold."""
    r = maps.sweep(par.main(), "alpha", np.radians(np.arange(5.0, 25.0, 0.01)))
    e = edge_contacts.ends(**r, mu=0.0)
    before = edge_contacts.contact(np.maximum(e.theta_end, r.pop("theta0")), **r).phi
    # past a fold the end does not lie on the branch that starts at engagement
    return float(r["alpha"][~np.isclose(before, e.phi_end, rtol=1e-6)].max())


def fig5b() -> Iterator[Claim]:
    """Claim: higher alpha engages, steepens and locks earlier; locks at low alpha; static locks."""
    alphas = np.radians([30.0, 40.0, 50.0, 60.0, 70.0])
    r = maps.sweep(par.main(), "alpha", alphas)
    phi_e = maps.ends(r, 0.0, "edge").found.load_e
    phi_lock, _ = maps.kinematic_lock(r)
    steep = 1 / edge_contacts.contact(r.pop("theta0"), **r).dphi_dtheta
    places = at("alpha", np.degrees(alphas), "deg")
    for text, what, values, unit, holds in (
        ("higher alpha engages earlier", "phi_e", phi_e, "rad", falls(phi_e)),
        ("higher alpha is steeper", "dtheta/dphi at engagement", steep, "", falls(-steep)),
        ("higher alpha locks earlier", "phi at the kinematic lock", phi_lock, "rad", falls(phi_lock)),
    ):
        yield Claim("fig5b", text, "both", what, numbers(values), unit, holds, at=places)
    scan = np.radians(np.arange(1.0, 40.0, 0.1))
    none = np.isnan(maps.kinematic_lock(maps.sweep(par.main(), "alpha", scan))[0])
    text, what = "at low alpha there is no kinematic lock", "largest alpha without one"
    note = f"the contact leaves the tip edge, below {math.degrees(fold_alpha()):.1f} deg past a fold"
    last = numbers([np.degrees(scan[none].max())], ".1f")
    yield Claim("fig5b", text, "both", what, last, "deg", yes(none[0]), note)
    text = "friction locks the beam also where there is no kinematic lock"
    places = at("alpha", LOW_ALPHAS, "deg")
    for law in par.LAWS:
        alone, plated = (
            [least_lock(math.radians(a), law, plates=plates) for a in LOW_ALPHAS] for plates in (False, True)
        )
        note = "at less friction the contact leaves the tip edge, or the scales come back to rest past the fold"
        if 0 in alone:
            note = "it locks without friction where mu = 0 is listed: the law does not satisfy virtual work"
        what, free = "least mu that locks, tip-side contact alone", all(mu <= 0.01 for mu in alone)
        yield Claim("fig5b", text, law, what, numbers(alone), "", "yes" if free else "in part", note, places)
        what = "least mu that locks before another pair of plates touches"
        note = "at less friction the model of one contact ends before any lock"
        yield Claim("fig5b", text, law, what, numbers(plated), "", "in part", note, places)
    text = "static lock needs a larger mu as alpha grows"
    degrees = np.array([0.01, 10, 20, 30, 45, 60, 70])
    for law in par.LAWS:
        scan = np.radians(degrees)
        static = maps.mu_static(maps.sweep(par.main(), "alpha", scan), law)
        rises = bool(np.all(np.diff(static) > 0))
        note = "" if rises else f"it falls again beyond {np.degrees(scan[static.argmax()]):.0f} deg"
        holds = "yes" if rises else "in part"
        yield Claim("fig5b", text, law, "mu_static", numbers(static), "", holds, note, at("alpha", degrees, "deg"))


def fig6a(data: xr.Dataset) -> Iterator[Claim]:
    """Claim: torque and stiffness of the scales rise with mu."""
    mus = [float(mu) for mu in data["mu"].values]
    for law in par.LAWS:
        part = data.sel(law=law)
        last = float(part["phi_end"].min())
        phi = np.linspace(float(part["phi_e"][0]) * 1.01, 0.98 * last, 60)
        for name, word in (("T_K", "torque"), ("K_K", "stiffness")):
            lines = [np.interp(phi, part["phi"][i].values, part[name][i].values) for i in range(len(mus))]
            ratio = float(np.min([b / a for a, b in pairwise(lines)]))
            middle = numbers([float(line[phi.size // 2]) for line in lines])
            what = f"{word} over K_theta at phi = {phi[phi.size // 2]:.4f} rad"
            note = f"least ratio of neighbouring curves up to the first lock: {ratio:.3f}"
            yield Claim(
                "fig6a", f"the {word} rises with mu", law, what, middle, "", yes(ratio > 1), note, at("mu", mus)
            )


def bending(data: xr.Dataset) -> Iterator[Claim]:
    """Claim: in bending the lock line is translated by arctan(mu); in twisting it is not."""
    mus = data["mu"].values[1:]
    for loading, law, text in (
        ("bending", "both", "the lock line is a translate by arctan(mu) in theta + psi/2"),
        ("twisting", "edge", "in twisting the lock line is no translate"),
    ):
        drop = np.degrees(data.sel(loading=loading)["drop"].values[1:])
        off = np.nanmax(abs(drop - np.degrees(np.arctan(mus))[:, None]), axis=1)
        spread = np.nanmax(drop, axis=1) - np.nanmin(drop, axis=1)
        holds = yes(np.all(spread < 1e-3) == (law == "both"))
        for what, values in (("largest less least drop", spread), ("largest distance from arctan(mu)", off)):
            yield Claim("bending", text, law, what, numbers(values, ".2g"), "deg", holds, at=at("mu", mus))


def fig7a(data: xr.Dataset) -> Iterator[Claim]:
    """Claim: RED rises with mu and saturates, nearly flat in eta; without a margin it is not defined."""
    mu, etas = data["mu"].values, data["value"].values
    for law in par.LAWS:
        part = data.sel(law=law)
        sliding = float(part["mu_static"].min())
        rise = float(np.diff(part["RED"].values[:, mu <= 2.0], axis=1).min())
        seen = [0.5, 1.0, 2.0, 3.0, 4.0]
        near = part["RED"].sel(value=3.0, method="nearest")
        middle, wide = near.interp(mu=seen).values, part["RED"].interp(mu=seen)
        spread = (wide.max("value") - wide.min("value")).values
        slope = part["RED"].interp(mu=0.5, value=[1.5, 3.0, 8.0]).values
        places, margin = at("mu", seen), f"margin {data.attrs['margin']:g}"
        what = "least rise of RED per step of mu (0.05), all eta, mu up to 2"
        note = (
            f"at eta = 3 it is largest at mu = {mu[near.values.argmax()]:.2f} and falls to 0 at the static lock "
            f"(the first, over eta, at mu = {sliding:.2f})"
        )
        yield Claim("fig7a", "RED rises with mu", law, what, numbers([rise], ".2g"), "", yes(rise > 0), note)
        what, still = f"RED at eta = 3, {margin}", yes(middle[3] - middle[2] < 0.05)
        yield Claim("fig7a", "RED saturates", law, what, numbers(middle), "", still, at=places)
        what = f"largest less least RED over eta {etas[0]:g} to {etas[-1]:g}, {margin}"
        note = f"RED at mu = 0.5, eta = 1.5, 3, 8: {', '.join(numbers(slope))}; "
        note += f"over mu it goes from 0 to {middle.max():.2f}"
        text, flat = "RED depends on eta far less than on mu", yes(spread.max() < FLAT * middle.max())
        yield Claim("fig7a", text, law, what, numbers(spread), "", flat, note, places)
    text = "RED up to the lock is a number (Eq. 15b)"
    what = "RED at eta = 3, mu = 0.5"
    note = "the work diverges like a logarithm, RED goes to 1: a map needs its margin"
    r = maps.sweep(par.main(), "eta", [3.0])
    for law in par.LAWS:
        steps = (1e-1, 1e-2, 1e-3, 1e-4)
        values = [float(maps.dissipation(par.main(), r, np.array([0.5]), law, m)[0].RED[0]) for m in steps]
        yield Claim("fig7a", text, law, what, numbers(values), "", "no", note, at("margin", steps))


def fig7b(data: xr.Dataset) -> Iterator[Claim]:
    """Claim: static lock at low alpha and high mu; RED not monotonic in mu there; alpha of the largest RED."""
    alpha, mu = np.degrees(data["value"].values), data["mu"].values
    low = int(np.argmin(abs(alpha - 10)))
    for law in par.LAWS:
        part = data.sel(law=law)
        static = part["end"].values == "static lock"
        first = [float(mu[row.argmax()]) if row.any() else math.nan for row in static]
        picks = [first[int(np.argmin(abs(alpha - a)))] for a in (1, 20, 45, 70)]
        text = "static lock (blank region) at low alpha and high mu"
        holds, places = yes(first[0] < np.nanmax(first)), at("alpha", (1, 20, 45, 70), "deg")
        yield Claim("fig7b", text, law, "first mu of the region", numbers(picks), "", holds, at=places)
        line = part["RED"].values[low]
        top = int(line.argmax())
        fall = float(line[top] - line[np.flatnonzero(~static[low])[-1]])
        text = "at low alpha RED is not monotonic in mu"
        for what, value in (
            ("largest RED", line[top]),
            ("mu of the largest RED", mu[top]),
            ("fall of RED from there to the last mu before static lock", fall),
        ):
            places, holds = at("alpha", [round(alpha[low])], "deg"), yes(fall > 0.05)
            yield Claim("fig7b", text, law, what, numbers([value]), "", holds, at=places)
        seen = [0.5, 1.0, 2.0, 3.0]
        best = [alpha[part["RED"].sel(mu=m, method="nearest").values.argmax()] for m in seen]
        inside = [40 <= a <= 60 for a in best]
        text = "friction dissipates most at alpha of 40 to 60 deg"
        what = f"alpha of the largest RED, margin {data.attrs['margin']:g}"
        note = f"{alpha[-1]:.0f} deg is the border of the map: RED still rises there"
        holds = "yes" if all(inside) else "in part" if any(inside) else "no"
        yield Claim("fig7b", text, law, what, numbers(best), "deg", holds, note, at("mu", seen))

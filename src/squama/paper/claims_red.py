"""The claims of the paper on the relative energy dissipation (Fig. 7), each with its numbers."""

from __future__ import annotations

import math

import numpy as np
import xarray as xr

from squama.paper import maps, red
from squama.paper import parameters as par
from squama.paper.claims import numbers, yes
from squama.paper.tables import Claim

FLAT = 0.25
"""RED counts as nearly flat in eta if it varies over eta by less than this part of its variation over mu."""


def fig7a(data: xr.Dataset) -> list[Claim]:
    """RED rises with mu and saturates, nearly flat in eta; without a margin it is no number."""
    out = []
    mu = data["mu"].values
    for law in par.LAWS:
        part = data.sel(law=law)
        sliding = float(part["mu_static"].min())
        upto = mu <= 2.0
        rise = float(np.diff(part["RED"].values[:, upto], axis=1).min())
        seen = [0.5, 1.0, 2.0, 3.0, 4.0]
        middle = part["RED"].sel(value=3.0, method="nearest").interp(mu=seen).values
        wide = part["RED"].interp(mu=seen)
        spread = (wide.max("value") - wide.min("value")).values
        slope = part["RED"].interp(mu=0.5, value=[1.5, 3.0, 8.0]).values
        best = mu[part["RED"].sel(value=3.0, method="nearest").values.argmax()]
        at = f"mu = {numbers(seen)}, margin {data.attrs['margin']:g}"
        out += [
            Claim(
                "fig7a",
                "RED rises with mu",
                law,
                "least rise of RED per step of mu (0.05), all eta, mu up to 2",
                f"{rise:.2g}",
                "",
                yes(rise > 0),
                f"at eta = 3 it is largest at mu = {best:.2f} and falls to 0 at the static lock "
                f"(the first, over eta, at mu = {sliding:.2f})",
            ),
            Claim(
                "fig7a",
                "RED saturates",
                law,
                f"RED at eta = 3, {at}",
                numbers(middle),
                "",
                yes(middle[3] - middle[2] < 0.05),
            ),
            Claim(
                "fig7a",
                "RED depends on eta far less than on mu",
                law,
                f"largest less least RED over eta {data['value'].values[0]:g} to {data['value'].values[-1]:g}, {at}",
                numbers(spread),
                "",
                yes(bool(spread.max() < FLAT * middle.max())),
                f"RED at mu = 0.5, eta = 1.5, 3, 8: {numbers(slope)}; over mu it goes from 0 to {middle.max():.2f}",
            ),
        ]
    steps = np.array([1e-1, 1e-2, 1e-3, 1e-4])
    for law in par.LAWS:
        r = maps.sweep(par.main(), "eta", [3.0])
        values = [float(red.dissipation(par.main(), r, np.array([0.5]), law, m)[0][0]) for m in steps]
        out.append(
            Claim(
                "fig7a",
                "RED up to the lock is a number (Eq. 15b)",
                law,
                "RED at eta = 3, mu = 0.5, margin 0.1, 0.01, 0.001, 0.0001",
                numbers(values),
                "",
                "no",
                "the work diverges like a logarithm, RED goes to 1: a map needs its margin",
            )
        )
    return out


def fig7b(data: xr.Dataset) -> list[Claim]:
    """Lock statically at low alpha and high mu; RED not monotonic in mu there; alpha of the largest RED."""
    out = []
    alpha, mu = np.degrees(data["value"].values), data["mu"].values
    low = int(np.argmin(abs(alpha - 10)))
    for law in par.LAWS:
        part = data.sel(law=law)
        static = part["end"].values == "static lock"
        first = [mu[row.argmax()] if row.any() else math.nan for row in static]
        picks = [int(np.argmin(abs(alpha - a))) for a in (1, 20, 45, 70)]
        out.append(
            Claim(
                "fig7b",
                "static lock (blank region) at low alpha and high mu",
                law,
                "first mu of the region at alpha = 1, 20, 45, 70 deg",
                numbers([first[i] for i in picks]),
                "",
                yes(bool(static[0].any() and first[0] < np.nanmax(first))),
            )
        )
        line = part["RED"].values[low]
        top = int(line.argmax())
        fall = float(line[top] - line[np.flatnonzero(~static[low])[-1]])
        out.append(
            Claim(
                "fig7b",
                "at low alpha RED is not monotonic in mu",
                law,
                f"alpha = {alpha[low]:.0f} deg: largest RED, at mu; fall of RED to the last mu before static lock",
                f"{line[top]:.3f}, {mu[top]:.2f}; {fall:.3f}",
                "",
                yes(fall > 0.05),
            )
        )
        seen = [0.5, 1.0, 2.0, 3.0]
        best = [alpha[part["RED"].sel(mu=m, method="nearest").values.argmax()] for m in seen]
        inside = [40 <= a <= 60 for a in best]
        out.append(
            Claim(
                "fig7b",
                "friction dissipates most at alpha of 40 to 60 deg",
                law,
                f"alpha of the largest RED at mu = {numbers(seen)}, margin {data.attrs['margin']:g}",
                numbers(best),
                "deg",
                "yes" if all(inside) else "in part" if any(inside) else "no",
                f"{alpha[-1]:.0f} deg is the border of the map: RED still rises there",
            )
        )
    return out

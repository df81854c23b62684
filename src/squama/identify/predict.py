"""Predictions from a fit: draws of its parameters, each followed along a curve, and bands over the draws."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from squama import arguments
from squama.beam.design import Beam
from squama.curves.doors import How
from squama.curves.histories import cycled
from squama.errors import InputError, refuse
from squama.identify.estimated import Table, variables
from squama.loads import LOADS
from squama.progress import steps
from squama.types import Array

if TYPE_CHECKING:
    from collections.abc import Sequence

    import xarray as xr

    from squama.identify.result import Fit

_ENDED = 0.5
"""Largest share of the draws that may end before the end of the curve."""


def draws(fit: Fit, number: int, seed: int) -> Array:
    """Return draws (number, parameters): of the posterior samples, else of estimates and covariance within bounds."""
    r = np.random.default_rng(seed)
    if fit.posterior is not None:
        samples = fit.posterior.samples
        return np.asarray(samples[r.integers(0, len(samples), number)])
    drawn = r.multivariate_normal(np.zeros(len(fit.rows)), fit.correlation, number) * fit.deviations
    return np.clip(fit.estimates + drawn, fit.asked.low, fit.asked.high)


def predict(
    fit: Fit,
    to: float | str | Sequence[float | str],
    *,
    samples: int = 100,
    seed: int = 1,
    points: int = 60,
    probability: float = 0.95,
) -> xr.Dataset:
    """Return the curve of the fitted beam there and back with its band; see :meth:`squama.Fit.predict`."""
    samples = arguments.whole("samples", samples, 10, 1e5)
    arguments.whole("seed", seed, 0, 2**32 - 1)
    if not 0 < probability < 1:
        refuse("probability", str(probability), "must lie between 0 and 1", "write e.g. 0.95")
    load, hinged = LOADS[fit.load], fit.joint == "hinge"

    def curve(beam: Beam) -> xr.Dataset:
        how: How = {"law": fit.law, "joint": fit.joint, "ideal": hinged}
        return cycled(beam, to, load=fit.load, ends=None if hinged else fit.ends, points=points, **how).dataset()

    best = curve(fit.beam)
    angle, leg = best[load.angle].values, best["leg"].values
    values, work, asked = [], [], fit.asked._replace(beam=fit.beam)
    for p in steps(list(draws(fit, samples, seed)), samples, "draws of the fit"):
        try:
            one = curve(asked.fitted(p))
        except InputError:
            continue
        x, T, own = (one[name].values for name in (load.angle, load.torque, "leg"))
        values.append(_on(angle, leg, x, T, own))
        work.append(np.trapezoid(T, x))
    if len(values) < (1 - _ENDED) * samples:
        refuse("to", "", f"{samples - len(values)} of {samples} draws are not followed", "go less far")
    return _dataset(fit, best, np.array(values), np.array(work), probability)


def _on(angle: Array, leg: Array, x: Array, T: Array, own: Array) -> Array:
    """Return torques T at angles x interpolated to the angles of another curve, way by way; NaN beyond the way."""
    out = np.full(angle.size, np.nan)
    for number in np.unique(leg):
        here, there = np.flatnonzero(leg == number), np.flatnonzero(own == number)
        if there.size:
            order = there[np.argsort(x[there], kind="stable")]
            out[here] = np.interp(angle[here], x[order], T[order], left=np.nan, right=np.nan)
    return out


def _dataset(fit: Fit, best: xr.Dataset, values: Array, work: Array, probability: float) -> xr.Dataset:
    import xarray as xr

    load, tail = LOADS[fit.load], (1 - probability) / 2
    T, between = load.torque, f"{100 * probability:g} % of the draws lie between"
    known = np.count_nonzero(np.isfinite(values), axis=0) > _ENDED * len(values)
    band = np.nanquantile(np.where(known, values, 0.0), (tail, 1 - tail), axis=0)
    low, high = np.where(known, band, np.nan)
    x, torque = best[load.angle].values, best[T].values
    ends = np.quantile(work, (tail, 1 - tail))
    words = load.torque_words
    loss = "work per pitch of the whole history, there and back"
    table: Table = {
        load.angle: ("point", x, load.angle_words, "rad"),
        T: ("point", torque, f"{words} of the estimates", "N m"),
        f"{T}_low": ("point", low, f"{words}, {between} this", "N m"),
        f"{T}_high": ("point", high, f"{words}, {between} and this", "N m"),
        "leg": ("point", best["leg"].values, "way between two reversals, counted from 1", None),
        f"{T}_draws": ("draw point", values, f"{words} of each draw", "N m"),
        "work": ("", np.trapezoid(torque, x), loss, "J"),
        "work_low": ("", ends[0], f"{loss}, {between} this", "J"),
        "work_high": ("", ends[1], f"{loss}, {between} and this", "J"),
    }
    attrs = {"title": f"prediction in {fit.load} from a fit", "load": fit.load, "estimates": ", ".join(fit.lines)}
    return xr.Dataset(variables(table), attrs=attrs | {"draws": len(values), "probability": probability})

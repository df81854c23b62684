"""Predictions from a fit: the curve of the fitted beam or part along a history, with a band from draws."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

import numpy as np

from squama import arguments, progress, units
from squama.curves.histories import cycled
from squama.errors import InputError, naming, refuse
from squama.identify.estimated import Table, variables
from squama.identify.joint_points import Walked
from squama.identify.posterior import Posterior, draws
from squama.identify.selection import Found
from squama.identify.unknowns import Asked
from squama.loads import LOADS, TESTS
from squama.types import Array

if TYPE_CHECKING:
    import xarray as xr

_ENDED = 0.5
"""Largest share of the draws that may end before the end of a predicted curve."""


class Curve(NamedTuple):
    """Load angles (n,), torques and numbers of the ways, from 1."""

    x: Array
    torque: Array
    leg: Array


class Course(Protocol):
    """The curve of a beam along a history for values p of the parameters."""

    def curve(self, p: Array | None, points: int) -> Curve:
        """Return the curve, of the estimates without p; refuse one that ends early."""


class Cycled(NamedTuple):
    """The history of :func:`squama.cycle`; ``asked`` has the beam of the estimates, ``model``: for ``cycled``."""

    asked: Asked
    model: Mapping[str, Any]
    to: float | str | Sequence[float | str]

    def curve(self, p: Array | None, points: int) -> Curve:
        """Return the curve as :meth:`Course.curve` does."""
        beam, load = self.asked.beam if p is None else self.asked.fitted(p), LOADS[self.asked.load]
        one = cycled(beam, self.to, points=points, **self.model).dataset()
        return Curve(*(one[name].values for name in (load.angle, load.torque, "leg")))


class Pushed(NamedTuple):
    """A part whose loaded place travels to a place and back, or through a history of places (m)."""

    points: Walked
    asked: Asked
    estimates: Array
    to: float | str | Sequence[float | str]

    def curve(self, p: Array | None, points: int) -> Curve:
        """Return the curve as :meth:`Course.curve` does."""
        with naming("to"):
            every = [self.to] if isinstance(self.to, str | float | int) else list(self.to)
            turns = [units.quantity(value, units.Dimension.LENGTH) for value in every]
        corners = np.array([0.0, *turns, 0.0] if len(turns) == 1 else [0.0, *turns])
        if not np.diff(corners).all():
            refuse("to", "", "has two equal travels in a row, or none", 'write e.g. "5 mm"')
        ways = [np.linspace(a, b, points + 1)[i > 0 :] for i, (a, b) in enumerate(itertools.pairwise(corners))]
        x, leg = np.concatenate(ways), np.repeat(np.arange(len(ways)) + 1, [len(way) for way in ways])
        values = self.asked.physical(self.estimates if p is None else p)
        return Curve(x, self.points.curve(values, x), leg)


def predict(
    fit: Found,
    course: Course,
    posterior: Posterior | None,
    *,
    samples: int = 100,
    seed: int = 1,
    points: int = 60,
    probability: float = 0.95,
) -> xr.Dataset:
    """Return the curve of the fitted beam along a course with its band, see :meth:`squama.Fit.predict`."""
    samples, points = arguments.whole("samples", samples, 10, 1e5), arguments.whole("points", points, 2, 1e4)
    arguments.whole("seed", seed, 0, 2**32 - 1)
    if not 0 < probability < 1:
        refuse("probability", str(probability), "must lie between 0 and 1", "write e.g. 0.95")
    best = course.curve(None, points)
    values, work = [], []
    for p in progress.steps(list(draws(fit, posterior, samples, seed)), samples, "draws of the fit"):
        try:
            one = course.curve(p, points)
        except InputError:
            continue
        values.append(_on(best, one))
        work.append(np.trapezoid(one.torque, one.x))
    if len(values) < (1 - _ENDED) * samples:
        refuse("to", "", f"{samples - len(values)} of {samples} draws are not followed", "go less far")
    return _dataset(fit, best, np.array(values), np.array(work), probability)


def _on(best: Curve, one: Curve) -> Array:
    """Return the torques of a curve at the load angles of another, way by way; NaN beyond the way."""
    out = np.full(best.x.size, np.nan)
    for number in np.unique(best.leg):
        here, there = np.flatnonzero(best.leg == number), np.flatnonzero(one.leg == number)
        if there.size:
            order = there[np.argsort(one.x[there], kind="stable")]
            out[here] = np.interp(best.x[here], one.x[order], one.torque[order], left=np.nan, right=np.nan)
    return out


def _dataset(fit: Found, best: Curve, values: Array, work: Array, probability: float) -> xr.Dataset:
    import xarray as xr

    load, tail = TESTS[fit.asked.load], (1 - probability) / 2
    T, between = load.torque, f"{100 * probability:g} % of the draws lie between"
    known = np.count_nonzero(np.isfinite(values), axis=0) > _ENDED * len(values)
    band = np.nanquantile(np.where(known, values, 0.0), (tail, 1 - tail), axis=0)
    low, high = np.where(known, band, np.nan)
    ends = np.quantile(work, (tail, 1 - tail))
    words, unit = load.torque_words, load.force
    loss = f"work {'' if load.pushed else 'per pitch '}of the whole history, there and back"
    table: Table = {
        load.angle: ("point", best.x, load.angle_words, load.unit),
        T: ("point", best.torque, f"{words} of the estimates", unit),
        f"{T}_low": ("point", low, f"{words}, {between} this", unit),
        f"{T}_high": ("point", high, f"{words}, {between} and this", unit),
        "leg": ("point", best.leg, "way between two reversals, counted from 1", None),
        f"{T}_draws": ("draw point", values, f"{words} of each draw", unit),
        "work": ("", np.trapezoid(best.torque, best.x), loss, "J"),
        "work_low": ("", ends[0], f"{loss}, {between} this", "J"),
        "work_high": ("", ends[1], f"{loss}, {between} and this", "J"),
    }
    attrs = {"title": f"prediction in {load.name} from a fit", "load": load.name, "estimates": ", ".join(fit.lines)}
    return xr.Dataset(variables(table), attrs=attrs | {"draws": len(values), "probability": probability})

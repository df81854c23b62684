"""What is said of a fit beside its summary: notes on what is to be known, a beam file, a record for JSON."""

from __future__ import annotations

import itertools
import math
from typing import Any

import numpy as np

from squama._version import __version__
from squama.curves.hinge_cycles import Senses
from squama.identify import estimate
from squama.identify.result import Fit
from squama.types import Array
from squama.units import moment

_SMALL = 0.05
"""Standard error of a friction that is known to be small."""
_GAIN = 0.7
"""A further measurement is named if it brings one of the errors concerned below this part of it."""


def notes(fit: Fit, senses: Senses | None) -> list[str]:
    """Say what is to be known about a fit; ``senses`` are those of the fitted beam, on hinges."""
    out = []
    for i in np.flatnonzero(fit.at_bound):
        low, high, value = fit.asked.low[i], fit.asked.high[i], fit.estimates[i]
        nearer = low if value - low < high - value else high
        out.append(f"{fit.parameters[i]} is at its bound {nearer:.6g}: errors are as without bounds")
    names = itertools.combinations(fit.parameters, 2)
    above = zip(names, fit.correlation[np.triu_indices(len(fit.parameters), 1)], strict=True)
    hard = [(a, b, float(c)) for (a, b), c in above if abs(c) > estimate.HARDLY]
    for a, b, c in hard:
        out.append(
            f"{a} and {b} are hardly separable by these points (correlation {c:+.3f}, condition of the scaled "
            f"derivatives {fit.condition:.3g}): a change of one is made up for by the other"
        )
    weak = [n for n in fit.parameters if n != "zero" and fit.errors[n] > estimate.UNSEEN * abs(fit.values[n])]
    weak = [n for n in weak if not fit.at_bound[fit.parameters.index(n)]]
    if "mu" in weak and fit.errors["mu"] < _SMALL:
        weak.remove("mu")
        most = fit.values["mu"] + 2 * fit.errors["mu"]
        out.append(f"mu cannot be told from 0: two standard errors above the estimate are {most:.2g}")
    out += [
        f"{n} is not determined by these points: its error is {100 * fit.errors[n] / abs(fit.values[n]):.0f} % of it"
        for n in weak
    ]
    concerned = [i for i, n in enumerate(fit.parameters) if n in {*weak, *(x for a, b, _ in hard for x in (a, b))}]
    for r in fit.remedies:
        now = np.array(list(fit.errors.values()))
        if any(r.errors[i] < _GAIN * now[i] for i in concerned):
            # with as many digits as with the estimates
            rows = zip(fit.asked.rows, fit.estimates, r.errors, strict=True)
            errors = ", ".join(f"{row.name} {row.written(v, error).partition(' +- ')[2]}" for row, v, error in rows)
            out.append(f"would help: {r.what} (standard errors then {errors})")
    limit = max(0.2, 3 / math.sqrt(max(int(np.count_nonzero(fit.used)), 1)))
    autocorrelation = _autocorrelation(fit)
    if autocorrelation > limit:
        share = math.sqrt((1 + autocorrelation) / (1 - min(autocorrelation, 0.99)))
        out.append(
            f"residuals are not noise alone: each resembles the next (correlation {autocorrelation:.2f}), so the model "
            f"misses something of the test, and errors are too small, by a factor of about {share:.1f} for that alone"
        )
    if fit.given_noise and fit.rms > 1.5 * fit.noise:
        out.append(
            f"residuals ({moment(fit.rms, 3)}) are larger than the noise that is given ({moment(fit.noise, 3)}): "
            "the model misses something of the test, and errors are too small"
        )
    return out + (_locked(fit, senses) if senses else []) + _scatter(fit)


def _autocorrelation(fit: Fit) -> float:
    """Correlation of each residual with the next of the same specimen; 0 where too few points tell."""
    r, specimen = fit.residuals[fit.used], fit.record.specimen[fit.used]
    together = specimen[1:] == specimen[:-1]
    if np.count_nonzero(together) < 10 or not r.any() or fit.rms < 1e-9 * float(np.abs(fit.record.torque).max()):
        return 0.0
    return float(np.sum((r[1:] * r[:-1])[together]) / np.sum(r**2))


def _locked(fit: Fit, senses: Senses) -> list[str]:
    """Say where the fitted beam does not follow the data as the model takes them."""
    rec = fit.record
    for sign, path in senses.paths.items():
        there = fit.used & ((rec.load < 0) == (sign == "-"))
        far = float(np.max(np.abs(rec.load), where=there, initial=0.0))
        if far > path.load_end * (1 + 1e-9):
            return [
                f"the fitted beam ends at {path.load_end:.6g} rad/pitch ({path.end}), before the farthest point "
                f"({far:.6g} rad/pitch): the points beyond are not described by it"
            ]
    return []


def _scatter(fit: Fit) -> list[str]:
    """Say where specimens differ by more than their errors."""
    alone = [s for s in fit.specimens if s.values is not None]
    if len(alone) < 2:
        return []
    values, errors = np.array([s.values for s in alone]), np.array([s.errors for s in alone])
    out = []
    for i, (name, row) in enumerate(zip(fit.parameters, fit.asked.rows, strict=True)):
        scatter = float(np.std(values[:, i], ddof=1))
        if scatter > 2 * float(np.sqrt(np.mean(errors[:, i] ** 2))):
            out.append(
                f"{name} differs between the {len(alone)} specimens by more than its errors: "
                f"{row.written(values[:, i].mean(), scatter)} is mean and scatter of the specimens"
            )
    return out


def beam_file(fit: Fit, sources: list[str]) -> str:
    """Return the beam with the estimates put in as the text of a beam file; comments tell where they come from."""
    lines = [f"# Fitted by squama fit to {', '.join(sources)}: estimates and standard errors"]
    return "\n".join([*lines, *(f"# {line}" for line in fit.lines)]) + "\n\n" + fit.beam.to_toml()


def record(fit: Fit) -> dict[str, Any]:
    """Return all there is to say about a fit, for JSON."""
    samples, asked = fit.posterior, fit.asked
    columns = (column.tolist() for column in (asked.low, asked.high, asked.start, fit.at_bound))
    limits = [dict(zip(("low", "high", "initial", "at_bound"), row, strict=True)) for row in zip(*columns, strict=True)]

    def by_name(values: Array) -> dict[str, float]:
        return dict(zip(fit.parameters, values.tolist(), strict=True))

    return {
        "load": fit.load,
        "law": fit.law,
        "joint": fit.joint,
        "scales": fit.scales,
        "parameters": {
            row.name: {"estimate": fit.values[row.name], "error": fit.errors[row.name], "unit": row.unit, **bounds}
            for row, bounds in zip(fit.asked.rows, limits, strict=True)
        },
        "correlation": fit.correlation,
        "condition": fit.condition,
        "noise": fit.noise,
        "noise_given": fit.given_noise,
        "rms": fit.rms,
        "starts": {"agreed": fit.starts[0], "of": fit.starts[1]},
        "points": {
            "specimen": [fit.record.specimens[int(s)].label for s in fit.record.specimen],
            "load": fit.record.load,
            "torque": fit.record.torque,
            "fitted": fit.fitted,
            "error": fit.band,
            "residual": fit.residuals,
            "branch": fit.branch,
            "used": fit.used,
        },
        "specimens": [
            {"label": s.label, "estimates": s.values, "errors": s.errors, "problem": s.problem} for s in fit.specimens
        ],
        "remedies": [{"what": r.what, "errors": by_name(r.errors)} for r in fit.remedies],
        "notes": list(fit.notes),
        "posterior": None
        if samples is None
        else {
            "samples": len(samples.samples),
            "effective": samples.effective,
            "mean": by_name(samples.samples.mean(axis=0)),
            "sd": by_name(samples.samples.std(axis=0, ddof=1)),
            "acceptance": samples.acceptance,
            "autocorrelation": samples.autocorrelation,
        },
        "beam": fit.beam.model_dump(),
        "squama_version": __version__,
        "warnings": fit.beam.warnings(fit.load),
    }

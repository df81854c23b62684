"""The words for a fit: estimates in readable units, the summary, and what is to be known about it."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from squama._version import __version__
from squama.identify import separable

if TYPE_CHECKING:
    from squama.identify.result import Fit

WORDS = {"twisting": ("twist", "twist rate", "torque"), "bending": ("bend", "curvature", "moment")}
_SMALL = 0.05
"""Standard error of a friction that is known to be small."""
_GAIN = 0.7
"""A further measurement is named if it brings one of the errors concerned below this part of it."""
_UNITS = {"rad": (180 / math.pi, "deg"), "Pa": (1.0, "Pa"), "N m": (1.0, "N m"), "1": (1.0, "")}
_SCALES = ((1e9, 1e-9, "G"), (1e6, 1e-6, "M"), (1e3, 1e-3, "k"), (1e-1, 1.0, ""), (0.0, 1e3, "m"))


def with_error(value: float, error: float, unit: str) -> str:
    """Write a value and its error with as many digits as the error has two: "0.251 +- 0.013 N m".

    Examples
    --------
    >>> with_error(0.2512, 0.0134, "1"), with_error(1.5123e6, 2.2e4, "Pa")
    ('0.251 +- 0.013', '1.512 +- 0.022 MPa')
    """
    factor, name = _UNITS[unit]
    if name in ("Pa", "N m"):
        largest = max(abs(value), error if math.isfinite(error) else 0.0)
        scale, prefix = next((f, p) for low, f, p in _SCALES if largest >= low)
        # N mm is what joints and load cells are given in
        name = "N mm" if name == "N m" and prefix == "m" else prefix + name
        factor = scale
    value, error = value * factor, error * factor
    if not math.isfinite(error) or error < 1e-6 * abs(value):
        return f"{value:.7g} +- {error:.1e} {name}".strip()
    digits = max(0, 1 - math.floor(math.log10(error or 1.0)))
    return f"{value:.{digits}f} +- {error:.{digits}f} {name}".strip()


def estimate(fit: Fit, name: str) -> str:
    """Write an estimate: "mu = 0.251 +- 0.013"."""
    unit = fit.asked.rows[fit.parameters.index(name)].unit
    return f"{name} = {with_error(fit.values[name], fit.errors[name], unit)}"


def summary(fit: Fit) -> str:
    """Return the summary of a fit as plain text."""
    lines = [f"{name:8} {text}" for name, text in table(fit)]
    counts = ", ".join(
        f"{np.count_nonzero(fit.branch == b)} {words}" for b, words in BRANCHES if (fit.branch == b).any()
    )
    share = 100 * fit.rms / float(np.abs(fit.record.torque[fit.used]).max())
    source = "given" if fit.given_noise else "from the residuals"
    lines += [
        f"residual rms {torque(fit.rms)}, {share:.2g} % of the largest; noise {torque(fit.noise)} ({source})",
        f"{np.count_nonzero(fit.used)} of {fit.used.size} points used: {counts}",
    ]
    lines += _each(fit) + _samples(fit)
    lines += [f"note: {note}" for note in fit.notes]
    return "\n".join(lines)


def _each(fit: Fit) -> list[str]:
    """Return what each specimen gives alone."""
    lines = []
    for s in fit.specimens:
        if s.values is None:
            lines.append(f"specimen {s.label} alone: {s.problem}")
            continue
        rows = zip(fit.parameters, fit.asked.rows, s.values, s.errors, strict=True)
        lines.append(
            f"specimen {s.label} alone: " + ", ".join(f"{n} = {with_error(v, e, r.unit)}" for n, r, v, e in rows)
        )
    return lines


def _samples(fit: Fit) -> list[str]:
    """Return mean and standard deviation of the posterior samples."""
    if fit.posterior is None:
        return []
    x = fit.posterior.samples
    rows = zip(fit.parameters, fit.asked.rows, x.mean(axis=0), x.std(axis=0, ddof=1), strict=True)
    words = ", ".join(f"{n} = {with_error(float(v), float(e), r.unit)}" for n, r, v, e in rows)
    note = fit.posterior.note()
    lines = [f"posterior, {len(x)} samples (worth {fit.posterior.effective:.0f} independent ones): {words}"]
    return lines + ([f"note: {note}"] if note else [])


BRANCHES = (
    ("straight", "before engagement"),
    ("loading", "loading"),
    ("stick", "at a reversal (not used)"),
    ("unloading", "unloading"),
    ("beyond", "beyond the range asked (not used)"),
)


def table(fit: Fit) -> list[tuple[str, str]]:
    """Return name and estimate, with its correlations to those before it."""
    rows = []
    for i, (name, row) in enumerate(zip(fit.parameters, fit.asked.rows, strict=True)):
        text = f"{with_error(fit.values[name], fit.errors[name], row.unit):24} {row.words}"
        corr = [f"{fit.correlation[i, j]:+.2f} with {fit.parameters[j]}" for j in range(i)]
        rows.append((name, text + (f"; correlation {', '.join(corr)}" if corr else "")))
    return rows


def torque(value: float) -> str:
    """Write a torque in N m or N mm."""
    return f"{value:.3g} N m" if abs(value) >= 0.1 else f"{1e3 * value:.3g} N mm"


def notes(fit: Any, autocorrelation: float, lock: str | None) -> list[str]:
    """Say what is to be known about a fit; empty if nothing is.

    Parameters
    ----------
    fit : Fit
        Without its notes.
    autocorrelation
        Correlation of each residual with the next.
    lock
        What is wrong with the fitted beam on the way of the data, if anything.
    """
    out = []
    for name, here in zip(fit.parameters, fit.at_bound, strict=True):
        if here:
            i = fit.parameters.index(name)
            low, high, value = fit.asked.low[i], fit.asked.high[i], fit.estimates[i]
            nearer = low if value - low < high - value else high
            out.append(f"{name} is at its bound {nearer:.6g}: errors are as without bounds")
    hard = separable.pairs(fit.parameters, fit.correlation)
    for a, b, c in hard:
        out.append(
            f"{a} and {b} are hardly separable by these points (correlation {c:+.3f}, condition of the scaled "
            f"derivatives {fit.condition:.3g}): a change of one is made up for by the other"
        )
    weak = [n for n in fit.parameters if n != "zero" and fit.errors[n] > separable.UNSEEN * abs(fit.values[n])]
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
            out.append(f"would help: {remedy(fit, r)}")
    limit = max(0.2, 3 / math.sqrt(max(int(np.count_nonzero(fit.used)), 1)))
    if autocorrelation > limit:
        share = math.sqrt((1 + autocorrelation) / (1 - min(autocorrelation, 0.99)))
        out.append(
            f"residuals are not noise alone: each resembles the next (correlation {autocorrelation:.2f}), so the model "
            f"misses something of the test, and errors are too small, by a factor of about {share:.1f} for that alone"
        )
    if fit.given_noise and fit.rms > 1.5 * fit.noise:
        out.append(
            f"residuals ({torque(fit.rms)}) are larger than the noise that is given ({torque(fit.noise)}): the model "
            "misses something of the test, and errors are too small"
        )
    if lock:
        out.append(lock)
    return out + _scatter(fit)


def remedy(fit: Any, r: separable.Remedy) -> str:
    """Write a further measurement and the errors it brings."""
    parts = [
        with_error(fit.values[n], float(e), row.unit)
        for n, row, e in zip(fit.parameters, fit.asked.rows, r.errors, strict=True)
    ]
    errors = ", ".join(f"{n} {p.partition(' +- ')[2]}" for n, p in zip(fit.parameters, parts, strict=True))
    return f"{r.what} (standard errors then {errors})"


def _scatter(fit: Any) -> list[str]:
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
                f"{with_error(float(values[:, i].mean()), scatter, row.unit)} is mean and scatter of the specimens"
            )
    return out


def beam_file(fit: Fit, sources: list[str]) -> str:
    """Return the beam with the estimates put in as the text of a beam file; comments tell where they come from."""
    lines = [f"# Fitted by squama fit to {', '.join(sources)}: estimates and standard errors"]
    lines += [f"# {estimate(fit, name)}" for name in fit.parameters]
    return "\n".join(lines) + "\n\n" + fit.beam.to_toml()


def record(fit: Fit) -> dict[str, Any]:
    """Return all there is to say about a fit, for JSON."""
    rows = fit.asked.rows
    samples = fit.posterior
    return {
        "load": fit.load,
        "law": fit.law,
        "parameters": {
            name: {
                "estimate": fit.values[name],
                "error": fit.errors[name],
                "unit": row.unit,
                "low": float(fit.asked.low[i]),
                "high": float(fit.asked.high[i]),
                "initial": float(fit.asked.start[i]),
                "at_bound": bool(fit.at_bound[i]),
            }
            for i, (name, row) in enumerate(zip(fit.parameters, rows, strict=True))
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
        "remedies": [
            {"what": r.what, "errors": dict(zip(fit.parameters, r.errors.tolist(), strict=True))} for r in fit.remedies
        ],
        "notes": list(fit.notes),
        "posterior": None
        if samples is None
        else {
            "samples": len(samples.samples),
            "effective": samples.effective,
            "mean": dict(zip(fit.parameters, samples.samples.mean(axis=0).tolist(), strict=True)),
            "sd": dict(zip(fit.parameters, samples.samples.std(axis=0, ddof=1).tolist(), strict=True)),
            "acceptance": samples.acceptance,
            "autocorrelation": samples.autocorrelation,
        },
        "beam": fit.beam.model_dump(),
        "squama_version": __version__,
        "warnings": fit.beam.warnings(fit.load),
    }

"""Notes on what is to be known about a fit."""

from __future__ import annotations

import itertools

import numpy as np

from squama.curves.hinge_cycles import Senses
from squama.identify import estimate
from squama.identify.result import Fit
from squama.identify.unknowns import NUISANCES

_ALIKE = 1.5
"""Points that are worth one independent one, from which on it is said."""
_HIDDEN = "the residual would hardly show it, but the errors would not hold without"
_SMALL = 0.05
"""Standard error of a friction that is known to be small."""
_GAIN = 0.7
"""A further measurement is named if it brings one of the errors concerned below this part of it."""


def notes(fit: Fit, senses: Senses | None) -> list[str]:
    """Return the notes on a fit; ``senses`` are those of the fitted beam on hinges."""
    seen = {name: abs(fit.values[name]) > 2 * fit.errors[name] for name in fit.added}
    out = [f"{n} is found too: {'the residual shows it' if yes else _HIDDEN}" for n, yes in seen.items()]
    if fit.rival is not None and fit.rival.problem:
        out.append(f'joint="{fit.rival.joint}" has no fit to compare with: {fit.rival.problem}')
    for i in np.flatnonzero(fit.at_bound):
        low, high, value = fit.asked.low[i], fit.asked.high[i], fit.estimates[i]
        if fit.parameters[i] == "mu" and low + 2 * estimate.EDGE < value < high - 2 * estimate.EDGE:
            out.append(
                f"mu is {value:.3g} or more: from there on the scales stick all along, and the torque is the same"
            )
            continue
        nearer = low if value - low < high - value else high
        out.append(f"{fit.parameters[i]} is at its bound {nearer:.6g}: errors are as without bounds")
    asked = [i for i, name in enumerate(fit.parameters) if name not in fit.added]
    pairs = [(fit.parameters[i], fit.parameters[j], fit.correlation[i, j]) for i, j in itertools.combinations(asked, 2)]
    hard = [(a, b, float(c)) for a, b, c in pairs if abs(c) > estimate.HARDLY]
    for a, b, c in hard:
        out.append(
            f"{a} and {b} are hardly separable by these points (correlation {c:+.3f}, condition of the scaled "
            f"derivatives {fit.condition:.3g}): a change of one is made up for by the other"
        )
    weak = [n for n in fit.parameters if n not in NUISANCES and fit.errors[n] > estimate.UNSEEN * abs(fit.values[n])]
    weak = [n for n in weak if not fit.at_bound[fit.parameters.index(n)]]
    if "mu" in weak and fit.errors["mu"] < _SMALL:
        weak.remove("mu")
        most = fit.values["mu"] + 2 * fit.errors["mu"]
        out.append(f"mu cannot be told from 0: two standard errors above the estimate are {most:.2g}")
    out += [
        f"{n} is not determined by these points: its error is {fit.errors[n] / abs(fit.values[n]):.2g} times as large"
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
    if fit.dependence > _ALIKE:
        n = int(np.count_nonzero(fit.used))
        out.append(
            f"residuals resemble their neighbours: {n} points are worth {n / fit.dependence:.0f}; errors allow for that"
        )
    if fit.uneven:
        out.append("the noise goes with the slope of the curve, as a noise of the twist does; errors allow for that")
    out += [f"stray, not used: {fit.record.where(int(i))}" for i in np.flatnonzero(fit.branch == "stray")]
    return out + (_locked(fit, senses) if senses else []) + _scatter(fit)


def _locked(fit: Fit, senses: Senses) -> list[str]:
    """Return a note where the fitted beam ends before the farthest point."""
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
    """Return notes on parameters whose specimens differ by more than their errors."""
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

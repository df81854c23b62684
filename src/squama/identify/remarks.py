"""Remarks on a fit: whether its errors hold, comparison with the other model, and notes."""

from __future__ import annotations

import math

import numpy as np

from squama.curves.hinge_cycles import Senses
from squama.identify import estimate
from squama.identify.groups import Differing
from squama.identify.result import Fit
from squama.identify.selection import Found, Rival
from squama.identify.unknowns import NUISANCES
from squama.loads import TESTS
from squama.people import per_pitch
from squama.units import moment

_WORTH, _EACH = 8.0, 10.0
"""Points per independent point above which residuals are no noise; least independent points per parameter."""
_BETTER = 10.0
"""Difference of n ln(S) above which one model describes the points better; BIC calls it very strong."""
_LOUD = 1.5
_SAME = 2.0
"""Least difference of two models' estimates, in standard errors."""
_AS_WELL = 1.5
"""Largest residual rms, over that of the fit, of another model that describes the points as well."""
_SPARE = 6
"""Least number of points beyond the number of parameters for the noise from the residual: two standard errors then
contain the true value in at least 91 of 100 cases.
"""
_ALIKE = 1.5
"""Points per independent point above which a note says so."""
_FROM_PRIOR = 3.0
"""Distance of the points' own estimate from a prior, over its error, above which they contradict each other."""
_INFORMED = 1e-3
"""Least share of a prior's variance that the points must remove for a comparison."""
_HIDDEN = "the residual would hardly show it, but the errors would not hold without"
_SMALL = 0.05
"""Largest standard error of a friction that is reported as near 0."""
_MISSES = "the model misses something of the test"
_GAIN = 0.7
"""Ratio of a standard error with a further measurement, below which the measurement is proposed."""


def disagreement(found: Found, rival: Rival | None) -> str:
    """Return a sentence where a model that describes the points as well has other estimates; else empty."""
    if rival is None or rival.found is None or rival.found.rms > _AS_WELL * found.rms:
        return ""
    other = rival.found
    asked = [n for n in found.parameters if n not in found.added and n in other.parameters]
    here, there = ({n: (one.values[n], one.errors[n]) for n in one.parameters} for one in (found, other))
    better = describes_better(found, other)
    # the errors of a model that misses the points do not count
    counted = {1: (0, 1), 0: (1, 1), -1: (1, 0)}[better]
    errors = {n: math.hypot(counted[0] * here[n][1], counted[1] * there[n][1]) for n in asked}
    apart = [n for n in asked if abs(here[n][0] - there[n][0]) > _SAME * errors[n]]
    if not apart:
        return ""
    rows = (row for row in other.asked.rows if row.name in (*asked, *other.added))
    values = ", ".join(f"{row.name} = {row.written(*there[row.name])}" for row in rows)
    words = {1: " and describe the points better", 0: " and describe the points as well", -1: ""}
    rms = f"with a residual rms of {moment(other.rms)} against {moment(found.rms)}{words[better]}"
    return f"the models disagree on {' and '.join(apart)}: {rival.words} give {values}, {rms}"


def describes_better(found: Found, other: Found) -> int:
    """Return 1 where the other model describes the same points better, -1 where worse, 0 where undecided."""
    n = np.count_nonzero(found.used) / min(found.dependence, other.dependence)
    gain = 2 * n * math.log(max(found.rms, 1e-150) / max(other.rms, 1e-150))
    return int(gain > _BETTER) - int(gain < -_BETTER)


def doubts(found: Fit, *, machine: bool) -> list[str]:
    """Return why the errors do not hold, as sentences; ``machine``: whether its stiffness is given."""
    given, rival, out = found.noise if found.given_noise else None, found.rival, list[str]()
    scales, load = found.asked.scales, TESTS[found.load]
    if found.slope is not None and (cause := found.slope.cause(found.parameters, scales, load, machine)):
        out.append(cause)
    out += _contradicted(found)
    if found.loops is not None and found.loops.told:
        out.append(_differing(found.loops))
    n, tau, p = np.count_nonzero(found.used), found.dependence, len(found.rows)
    least = p + (_SPARE if given is None else 1)
    if n < least:
        what = "the noise" if given is None else "whether the model holds"
        few = f"too few points: {n} for {p} parameter{'s' * (p != 1)} hardly tell {what}"
        out.append(f"{few}; measure {least} or more, better {int(_EACH) * p}")
    if tau > _WORTH or (tau > 1 and n / tau < _EACH * p):
        worth = f"{n} points are worth only {n / tau:.0f} independent ones"
        out.append(f"residuals are not noise alone: {worth}, so {_MISSES}")
    if rival is not None and rival.found is not None and describes_better(found, rival.found) > 0:
        out.append(f"{rival.words} describe the points better")
    if given is not None and found.rms > _LOUD * given:
        rms, noise = load.size(found.rms), load.size(given)
        out.append(f"residuals ({rms}) are larger than the noise that is given ({noise}), so {_MISSES}")
    return out


def _differing(loops: Differing) -> str:
    """Return a sentence on a parameter that differs between loops, with possible causes."""
    values = ", ".join(row.written(v, e) for row, v, e in zip(loops.rows, loops.values, loops.errors, strict=True))
    found = f"{loops.name} {loops.way} from loop to loop: {values} (chance {loops.chance:.1g} in equal loops)"
    remedy = f'find it for each loop: each="{loops.name}" (--each {loops.name})'
    return f"{found}; is it the rate, wear or run-in? {remedy}"


def _contradicted(found: Found) -> list[str]:
    """Return a doubt for each prior that contradicts the points.

    With the variance s^2 of the prior and C of the estimate from both, the distance over its error is (p -
    p_0)/sqrt(s^2 - C) (the pull of a constrained fit).
    """
    (mean, spread), out = found.asked.known, list[str]()
    if not np.isfinite(spread).any():
        return out
    errors = np.sqrt(np.diag(estimate.covariance(found.jacobian, found.asked.weight, found.parameters)))
    for row, value, given, s, error in zip(found.rows, found.estimates, mean, spread, errors, strict=True):
        if not math.isfinite(s) or error**2 > (1 - _INFORMED) * s**2:
            continue
        pull = abs(value - given) / math.sqrt(s**2 - error**2)
        if pull > _FROM_PRIOR:
            side = f"{'above' if value > given else 'below'} the given value ({row.written(given, s)})"
            off = f"the points alone give {row.name} {side} by {pull:.1f} standard deviations"
            out.append(f"{off}: one of the two is wrong, or {_MISSES}")
    return out


def notes(fit: Fit, senses: Senses | None) -> list[str]:
    """Return the notes on a fit; ``senses``: those of the fitted beam on hinges, or None."""
    seen = {name: abs(fit.values[name]) > 2 * fit.errors[name] for name in fit.added}
    out = [f"{n} is found too: {'the residual shows it' if yes else _HIDDEN}" for n, yes in seen.items()]
    if fit.rival is not None and fit.rival.problem:
        out.append(f'joint="{fit.rival.joint}" has no fit to compare with: {fit.rival.problem}')
    for i in np.flatnonzero(fit.at_bound):
        low, high, value = fit.asked.low[i], fit.asked.high[i], fit.estimates[i]
        if fit.parameters[i] == "mu" and low + 2 * estimate.EDGE < value < high - 2 * estimate.EDGE:
            stick = "from there on the scales stick all along, and the torque is the same"
            out.append(f"mu is {value:.3g} or more: {stick}")
            continue
        nearer = low if value - low < high - value else high
        out.append(f"{fit.parameters[i]} is at its bound {nearer:.6g}: errors are as without bounds")
    asked = [i for i, name in enumerate(fit.parameters) if name not in fit.added]
    hard = estimate.hardly_separable([fit.parameters[i] for i in asked], fit.correlation[np.ix_(asked, asked)])
    for a, b, c in hard:
        how = f"correlation {c:+.3f}, condition of the scaled derivatives {fit.condition:.3g}"
        pair = f"{a} and {b} are hardly separable by these points ({how})"
        out.append(f"{pair}: a change of one is made up for by the other")
    weak = [n for n in fit.parameters if n not in NUISANCES and fit.errors[n] > estimate.UNSEEN * abs(fit.values[n])]
    weak = [n for n in weak if not fit.at_bound[fit.parameters.index(n)]]
    if "mu" in weak and fit.errors["mu"] < _SMALL:
        weak.remove("mu")
        most = fit.values["mu"] + 2 * fit.errors["mu"]
        out.append(f"mu cannot be told from 0: two standard errors above the estimate are {most:.2g}")
    shares = {n: fit.errors[n] / abs(fit.values[n]) for n in weak}
    out += [f"{n} is not determined by these points: its error is {v:.2g} times as large" for n, v in shares.items()]
    concerned = [i for i, n in enumerate(fit.parameters) if n in {*weak, *(x for a, b, _ in hard for x in (a, b))}]
    for r in fit.remedies:
        if any(r.errors[i] < _GAIN * fit.deviations[i] for i in concerned):
            # with as many digits as the estimates
            rows = zip(fit.asked.rows, fit.estimates, r.errors, strict=True)
            errors = ", ".join(f"{row.name} {row.written(v, error).partition(' +- ')[2]}" for row, v, error in rows)
            out.append(f"would help: {r.what} (standard errors then {errors})")
    if fit.dependence > _ALIKE:
        n = int(np.count_nonzero(fit.used))
        worth = f"{n} points are worth {n / fit.dependence:.0f}"
        out.append(f"residuals resemble their neighbours: {worth}; errors allow for that")
    if fit.uneven:
        way = TESTS[fit.load].way
        out.append(f"the noise goes with the slope of the curve, as a noise of the {way} does; errors allow for that")
    out += [f"stray, not used: {fit.record.where(int(i))}" for i in np.flatnonzero(fit.branch == "stray")]
    return out + (_locked(fit, senses) if senses else []) + _scatter(fit)


def _locked(fit: Fit, senses: Senses) -> list[str]:
    """Return a note where the fitted beam ends before the farthest point."""
    rec = fit.record
    for sign, path in senses.paths.items():
        there = fit.used & ((rec.load < 0) == (sign == "-"))
        far = float(np.max(np.abs(rec.load), where=there, initial=0.0))
        if far > path.load_end * (1 + 1e-9):
            end = f"the fitted beam ends at {per_pitch(path.load_end, 6)} ({path.end})"
            beyond = "the points beyond are not described by it"
            return [f"{end}, before the farthest point ({per_pitch(far, 6)}): {beyond}"]
    return []


def _scatter(fit: Fit) -> list[str]:
    """Return notes on parameters whose specimens differ by more than their errors."""
    # values of each group are reported elsewhere
    alone = [] if fit.asked.groups else [s for s in fit.specimens if s.values is not None]
    if len(alone) < 2:
        return []
    values, errors = np.array([s.values for s in alone]), np.array([s.errors for s in alone])
    out = []
    for i, (name, row) in enumerate(zip(fit.parameters, fit.rows, strict=True)):
        scatter = float(np.std(values[:, i], ddof=1))
        if scatter > 2 * float(np.sqrt(np.mean(errors[:, i] ** 2))):
            differs = f"{name} differs between the {len(alone)} specimens by more than its errors"
            mean = row.written(values[:, i].mean(), scatter)
            out.append(f"{differs}: {mean} is mean and scatter of the specimens")
    return out

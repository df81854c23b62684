"""Whether the errors of a fit hold: what its residual says, and what the other model makes of the same points."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from squama.curves.chosen import idealisation
from squama.identify import noise
from squama.identify.prepare import Prepared
from squama.identify.selection import Found
from squama.identify.slope import Slope
from squama.units import moment

_WORTH, _EACH = 8.0, 10.0
"""Points that are worth one, from which on they are no noise; independent points for each parameter at least."""
_BETTER = 10.0
"""Growth of n ln(S) from which one model describes the points better than another; BIC calls it very strong."""
_LOUD = 1.5
_SAME = 2.0
"""Standard errors of a difference that is one."""
_AS_WELL = 1.5
"""Residual over that of the fit up to which the other model describes the points as well, and is reported."""
_SPARE = 6
"""Points beyond the number of parameters from which on the residual tells the noise: two standard errors then hold 91
of 100 truths or more."""


class Rival(NamedTuple):
    """The other model fitted to the same points: ``joint``; None where that is not possible, ``problem`` says why."""

    joint: str
    found: Found | None
    problem: str

    @property
    def words(self) -> str:
        """The model in words."""
        if self.joint == "hinge":
            return "thin, rigid scales on hinges"
        assert self.found is not None
        scales = idealisation(self.found.asked.beam, self.joint, ideal=False)
        return f"{scales} on the compliant joint"


def disagreement(found: Found, rival: Rival | None) -> str:
    """Say where the other model finds other values by more than the errors; empty where it does not.

    It is empty, too, where the other model does not describe the points as well: its values then say nothing.
    """
    if rival is None or rival.found is None or rival.found.rms > _AS_WELL * found.rms:
        return ""
    other = rival.found
    asked = [n for n in found.asked.names if n not in found.added and n in other.asked.names]
    here, there = (
        {n: (one.best.values[i], math.sqrt(one.covariance[i, i])) for i, n in enumerate(one.asked.names)}
        for one in (found, other)
    )
    better = describes_better(found, other)
    # where one misses the points its errors say nothing
    counted = {1: (0, 1), 0: (1, 1), -1: (1, 0)}[better]
    errors = {n: math.hypot(counted[0] * here[n][1], counted[1] * there[n][1]) for n in asked}
    apart = [n for n in asked if abs(here[n][0] - there[n][0]) > _SAME * errors[n]]
    if not apart:
        return ""
    values = ", ".join(
        f"{row.name} = {row.written(*there[row.name])}"
        for row in other.asked.rows
        if row.name in (*asked, *other.added)
    )
    words = {1: " and describe the points better", 0: " and describe the points as well", -1: ""}
    return (
        f"the models disagree on {' and '.join(apart)}: {rival.words} give {values}, with a residual rms of "
        f"{moment(other.rms, 3)} against {moment(found.rms, 3)}{words[better]}"
    )


def describes_better(found: Found, other: Found) -> int:
    """Return 1 where the other model describes the same points better, -1 where worse, 0 where none tells."""
    n = np.count_nonzero(found.usable) / min(found.dependence, other.dependence)
    gain = 2 * n * math.log(max(found.rms, 1e-150) / max(other.rms, 1e-150))
    return int(gain > _BETTER) - int(gain < -_BETTER)


def of_record(test: Prepared, found: Found, steep: Slope | None) -> list[str]:
    """Say what is wrong with a record, or with the bar that it was measured on, by name."""
    rec, out, asked = test.record, [], found.asked
    own = np.flatnonzero(found.usable)
    if noise.interleaved(rec.load[own], rec.torque[own], test.points.readings.numbers[own]):
        out.append(
            "the rows are sorted by the twist: the torque jumps between two branches from row to row, so that loading "
            "and unloading are mixed up; give the rows in the order measured"
        )
    cause = steep.cause(asked.names, asked.beam.pitches) if steep is not None else ""
    return [*out, cause] if cause else out


def doubts(found: Found, rival: Rival | None, given: float | None) -> list[str]:
    """Say why the errors do not hold."""
    out, n = [], int(np.count_nonzero(found.usable))
    tau, p = found.dependence, len(found.asked.rows)
    least = p + (_SPARE if given is None else 1)
    if n < least:
        what = "the noise" if given is None else "whether the model holds"
        out.append(
            f"too few points: {n} for {p} parameter{'s' * (p != 1)} hardly tell {what}; measure {least} or more, "
            f"better {int(_EACH) * p}"
        )
    if tau > _WORTH or (tau > 1 and n / tau < _EACH * p):
        out.append(
            f"residuals are not noise alone: {n} points are worth only {n / tau:.0f} independent ones, so the model "
            "misses something of the test"
        )
    if rival is not None and rival.found is not None and describes_better(found, rival.found) > 0:
        out.append(f"{rival.words} describe the points better")
    if given is not None and found.rms > _LOUD * given:
        out.append(
            f"residuals ({moment(found.rms, 3)}) are larger than the noise that is given ({moment(given, 3)}), so the "
            "model misses something of the test"
        )
    return out

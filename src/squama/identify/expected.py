"""The plan of a test: loops with their expected errors, the best loop, and the plan in words."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from squama._version import __version__
from squama.beam.design import Beam
from squama.curves.chosen import idealisation
from squama.identify.estimate import HARDLY, UNSEEN
from squama.identify.estimated import Table, of, variables
from squama.identify.unknowns import Parameter
from squama.loads import LOADS
from squama.people import degrees
from squama.types import Array
from squama.units import moment

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

ENOUGH = 20
"""Largest number of repeated loops."""
_FEW = 4
"""Number of repeated loops that counts as easy."""
_TIMES = {1: "once", 2: "twice"}
_WAYS = {
    "loading": "to {} (loading alone)",
    "loop": "to {} and back",
    "both senses": "to {} in either sense and back",
}


class Candidate(NamedTuple):
    """A loop: shape, top (rad per pitch), readings, largest torque (N m), values and covariance, or the problem."""

    shape: str
    top: float
    readings: int
    torque: float
    values: Array
    covariance: Array
    problem: str

    @property
    def errors(self) -> Array:
        """Standard errors of one loop, SI units."""
        return np.asarray(np.sqrt(np.diag(self.covariance)))

    @property
    def shares(self) -> Array:
        """Standard errors over the values."""
        return np.asarray(self.errors / np.abs(self.values))

    @property
    def worst(self) -> float:
        """Largest standard error over its value; inf without values."""
        return float(self.shares.max(initial=0.0)) if self.values.size else math.inf

    @property
    def correlation(self) -> Array:
        """Correlation matrix of the estimates."""
        return np.asarray(self.covariance / np.outer(self.errors, self.errors))


@dataclass(frozen=True, repr=False, eq=False)
class Plan:
    """Result of :func:`squama.plan`: loops of a test with their expected standard errors.

    ``candidates`` are the loops, ``best`` the loop whose largest relative error is smallest. ``noise`` N m,
    ``twist_noise`` rad over the whole beam, ``compliance`` of the machine rad/(N m), ``engaged`` rad per pitch.
    ``free``: errors of the best loop with further parameters found, each with words.
    """

    beam: Beam
    rows: tuple[Parameter, ...]
    load: str
    law: str
    joint: str
    ends: str
    noise: float
    twist_noise: float
    compliance: float
    accuracy: float
    engaged: float
    candidates: tuple[Candidate, ...]
    best: Candidate
    free: tuple[tuple[str, Candidate], ...]

    @property
    def parameters(self) -> tuple[str, ...]:
        """Names of the parameters to find."""
        return tuple(row.name for row in self.rows)

    @property
    def scales(self) -> str:
        """The model's idealisation of the scales, in words."""
        return idealisation(self.beam, self.joint, ideal=self.joint == "hinge")

    def loops(self, one: Candidate) -> int | None:
        """Return how often a loop must be repeated for the accuracy; None if more than 20 times."""
        number = math.ceil((one.worst / self.accuracy) ** 2 - 1e-9) if math.isfinite(one.worst) else ENOUGH + 1
        return max(number, 1) if number <= ENOUGH else None

    def summary(self) -> str:
        """Return the verdict, a table of the loops, and notes, as text."""
        head, rows = self.table()
        widths = [max(map(len, column)) for column in zip(head, *rows, strict=True)]
        every = (zip(row, widths, strict=True) for row in (head, *rows))
        table = ("  ".join(f"{cell:{w}}" for cell, w in row).rstrip() for row in every)
        return "\n".join([*self.verdict(), *table, *self.notes()])

    def verdict(self) -> list[str]:
        """Return the recommended test and its expected errors, as lines."""
        best, loops = self.best, self.loops(self.best)
        specimen = self.beam.extent if self.beam.scales else "an endless beam"
        what = f"{LOADS[self.load].verb.capitalize()} {specimen} {self._way(best, loops or ENOUGH)}"
        lines = [f"{what}: {self._tells(best, loops or ENOUGH)}"]
        if loops is None:
            remedy = "measure farther or with less noise, or find fewer parameters"
            lines.append(f"{ENOUGH} loops do not reach {self._percent}: {remedy}")
        nearer = (one for one in self.candidates if abs(one.top) < abs(best.top))
        gentle = [(abs(one.top), one.worst, n, one) for one in nearer if (n := self.loops(one) or ENOUGH) <= _FEW]
        if gentle:
            _, _, number, one = min(gentle)
            lines.append(f"Least {LOADS[self.load].verb} for {self._percent}: {self._way(one, number)}")
        for words, more in self.free:
            lines.append(f"{words}: {more.problem or self._tells(more, loops or ENOUGH)}")
        return lines

    def _way(self, one: Candidate, loops: int) -> str:
        """Return a loop and its repetitions in words."""
        way = _WAYS[one.shape].format(f"{self._top(one)} {degrees(self.beam)[1]}")
        return f"{way}, {_TIMES.get(loops, f'{loops} times')} ({one.readings} readings each time)"

    def _top(self, one: Candidate) -> str:
        """Return the top of a loop in degrees: of the whole beam, or per pitch of an endless one."""
        return f"{degrees(self.beam)[0] * one.top:.3g}"

    def _tells(self, one: Candidate, loops: int) -> str:
        pairs = zip(self.parameters, self._errors(one, loops), strict=True)
        return ", ".join(f"{name} to +-{text}" for name, text in pairs)

    def _errors(self, one: Candidate, loops: int = 1) -> list[str]:
        """Return the errors after so many loops as text: absolute for a ratio, else in per cent."""
        errors, shares = (v / math.sqrt(loops) for v in (one.errors, one.shares))
        ratio = [row.unit == "1" for row in self.rows]
        return [
            "over 100 %" if share > 1 else f"{error:.2g}" if plain else f"{100 * share:.2g} %"
            for error, share, plain in zip(errors, shares, ratio, strict=True)
        ]

    @property
    def _percent(self) -> str:
        return f"{100 * self.accuracy:.3g} %"

    def table(self) -> tuple[list[str], list[list[str]]]:
        """Return head and rows of a table of the loops that the model can follow."""
        head = ["loop", f"top {degrees(self.beam)[1]}", f"largest {LOADS[self.load].torque_words}", *self.parameters]
        head += ["correlation"] * (len(self.rows) > 1) + [f"loops for {self._percent}"]
        rows = []
        for one in self.candidates:
            if one.problem:
                continue
            loops = self.loops(one)
            cells = [one.shape, self._top(one), moment(one.torque), *self._errors(one)]
            if len(self.rows) > 1:
                r, names = self._related(one)
                cells.append(f"{r:+.2f} {names}")
            rows.append([*cells, str(loops or f"over {ENOUGH}")])
        return head, rows

    def _related(self, one: Candidate) -> tuple[float, str]:
        """Return the largest correlation of two estimates, and their names."""
        apart = np.abs(np.tril(one.correlation, -1))
        i, j = np.unravel_index(int(np.argmax(apart)), apart.shape)
        return float(one.correlation[i, j]), f"{self.parameters[j]}, {self.parameters[i]}"

    def notes(self) -> list[str]:
        """Return the basis of the errors, parameters that are hardly separable, and loops left out, as lines."""
        said = f"standard errors of one loop, by the model's derivatives; noise of a reading {moment(self.noise)}"
        if self.twist_noise:
            said += f" and {math.degrees(self.twist_noise):.3g} deg of the twist"
        if self.compliance:
            said += f"; machine of {1 / self.compliance:.3g} N m/rad"
        lines, good = [said], [one for one in self.candidates if not one.problem]
        if any(one.worst > UNSEEN for one in good):
            share = f"{100 * UNSEEN:.0f} %"
            lines.append(f"errors above {share} only say that a loop does not tell: the model is not linear over them")
        for shape in dict.fromkeys(one.shape for one in good if len(self.rows) > 1):
            r, names = max((self._related(one) for one in good if one.shape == shape), key=lambda pair: abs(pair[0]))
            if abs(r) > HARDLY:
                lines.append(f"note: {shape}: {names} are hardly told apart (correlation up to {r:+.3f})")
        lost = [one for one in self.candidates if one.problem]
        if lost:
            tops, unit = sorted({self._top(one).lstrip("-") for one in lost}, key=float), degrees(self.beam)[1]
            lines.append(f"note: {len(lost)} loops, to {', '.join(tops)} {unit}, are left out: {lost[0].problem}")
        return lines

    def report(self) -> dict[str, object]:
        """Return the plan as plain values, for JSON."""
        return {
            "verdict": self.verdict()[0],
            "notes": [*self.verdict()[1:], *self.notes()],
            "find": list(self.parameters),
            "units": {row.name: row.unit for row in self.rows},
            **of(self, "noise", "twist_noise", "compliance", "accuracy", "engaged", "load", "law", "joint", "ends"),
            "best": self._entry(self.best),
            "candidates": [self._entry(one) for one in self.candidates],
            "squama_version": __version__,
        }

    def _entry(self, one: Candidate) -> dict[str, object]:
        found = {"loop": one.shape, "top": one.top, "readings": one.readings, "problem": one.problem}
        if one.problem:
            return found
        errors = dict(zip(self.parameters, one.errors.tolist(), strict=True))
        more = {"torque": one.torque, "errors": errors, "loops": self.loops(one)}
        return {**found, **more, "correlation": one.correlation.tolist()}

    def dataset(self) -> xr.Dataset:
        """Return the loops that the model can follow as a dataset.

        Dimension ``candidate``: ``loop``, ``top`` (rad per pitch), ``total`` (rad over the whole beam), ``readings``,
        ``torque`` (N m), ``loops`` (repetitions for the accuracy, 0 where too many), and for each parameter its
        standard error in one loop, ``error_mu`` and so on. Dimensions ``parameter`` and ``other``: ``correlation``.
        """
        import xarray as xr

        good = [one for one in self.candidates if not one.problem]
        tops, words = np.array([one.top for one in good]), f"largest {LOADS[self.load].torque_words}"
        errors = zip(self.rows, np.array([one.errors for one in good]).T, strict=True)
        related, dims = [one.correlation for one in good], "candidate parameter other"
        table: Table = {
            "loop": ("candidate", [one.shape for one in good], "shape of the loop", None),
            "top": ("candidate", tops, "largest twist per pitch", "rad"),
            "total": ("candidate", tops * self.beam.pitches, "largest twist of the beam", "rad"),
            "readings": ("candidate", [one.readings for one in good], "readings of a loop", None),
            "torque": ("candidate", [one.torque for one in good], words, "N m"),
            "loops": ("candidate", [self.loops(one) or 0 for one in good], "loops for the accuracy", None),
            **{f"error_{r.name}": ("candidate", v, f"standard error of {r.name}", r.unit) for r, v in errors},
            "correlation": (dims, related, "correlation of estimates", None),
        }
        names = list(self.parameters)
        attrs = {
            "title": f"plan of a test of a scale-covered beam in {LOADS[self.load].name}",
            "verdict": self.verdict()[0],
            "values": self.best.values.tolist(),
            **of(self, "scales", "load", "law", "joint", "ends", "noise", "accuracy", "engaged"),
            "beam": self.beam.to_toml(),
            "squama_version": __version__,
        }
        return xr.Dataset(variables(table), coords={"parameter": names, "other": names}, attrs=attrs)

    def plot(self) -> Figure:
        """Draw the expected errors over the top of the loops."""
        from squama.plot import plan_figure

        return plan_figure(self.dataset())

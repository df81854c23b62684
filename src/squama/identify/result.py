"""The result of a fit, with its curve, datasets and texts."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from squama._version import __version__
from squama.beam.card import card
from squama.beam.design import Beam
from squama.curves.chosen import idealisation
from squama.curves.finite_rows import Ends
from squama.identify import estimate
from squama.identify.estimate import Remedy
from squama.identify.estimated import Table, of
from squama.identify.groups import Differing
from squama.identify.joint_points import Walked
from squama.identify.machine import Unknown
from squama.identify.posterior import Posterior
from squama.identify.prediction import Course, Cycled, Pushed, predict
from squama.identify.records import Record
from squama.identify.selection import Found, Rival
from squama.identify.slope import Slope
from squama.identify.unknowns import Parameter, written
from squama.loads import ENDLESS, LOADS, TESTS, ending
from squama.people import per_pitch
from squama.types import Array

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

BRANCHES = {
    "straight": "before engagement",
    "loading": "loading",
    "stick": "at a reversal (not used)",
    "unloading": "unloading",
    "stray": "stray (not used)",
    "beyond": "beyond the range asked (not used)",
}
POINTS = 80
"""Points of each way of the fitted curve."""


class Alone(NamedTuple):
    """Estimates, errors and rms (N m) of one specimen alone, or of the endless beam; None with a ``problem``."""

    label: str
    values: Array | None
    errors: Array | None
    rms: float = math.nan
    problem: str = ""
    rows: tuple[Parameter, ...] = ()


@dataclass(frozen=True, repr=False, eq=False)
class Fit(Found):
    """Parameters of a beam found from a test.

    ``beam`` has the estimates. ``parameters`` are the names of the estimates; in this order ``covariance`` and
    ``correlation`` (parameters, parameters), by name ``values`` and their standard ``errors``, SI units; ``condition``
    number of the derivatives to the parameters, columns scaled to one length. ``noise`` standard deviation of a torque,
    N m: from the residuals, or as given; ``rms`` root mean square of the residuals of the points that were used, N m.

    Arrays of one length, the points: ``residuals`` measured less fitted torque, N m, of every point that the model
    covers, NaN elsewhere; ``fitted``, ``band`` fitted torque and its standard error, N m; ``branch`` "straight" (before
    engagement), "loading", "unloading", "stick" (at a reversal) or "stray"; ``used``: points of the fit, without
    reversals and stray points.

    ``ends`` of the beam that is fitted, a word of :func:`squama.cycle`; ``endless`` the fit of the endless beam to the
    same points, None where the endless beam is fitted: then ``row`` has torque and tangent of the beam's own number of
    scales over those of the endless beam, at the farthest point, if that is known. ``slope``: slope of the torque
    before engagement over the beam's own, None with too few points there.

    ``added``: nuisances that were added because the residual shows them; ``dependence``: points per independent point;
    ``uneven``: whether the noise grows with the slope (the errors allow for both). ``rival``: fit of the other model to
    the same points; ``disagreement``: a sentence where that model describes the points as well (residual at most 1.5
    times as large) and its estimates differ by more than the errors; ``doubts``: why the errors do not hold, empty
    where they do (``holds``). ``machine``: effect of a compliant testing machine, None where its stiffness was
    given; ``loops``: friction of each loop, with the probability of such differences for equal friction, None for a
    single loop.

    ``specimens``: estimates from each specimen alone, empty for a single one; ``remedies``: further measurements with
    the standard errors expected from them; ``notes``: inseparable parameters, bounds that are reached; ``posterior``:
    samples, if drawn.
    """

    beam: Beam
    initial: Beam
    load: str
    law: str
    record: Record
    given_noise: bool
    residuals: Array
    fitted: Array
    band: Array
    branch: NDArray[np.str_]
    specimens: tuple[Alone, ...]
    remedies: tuple[Remedy, ...]
    rival: Rival | None
    disagreement: str
    slope: Slope | None
    ends: str
    row: Ends | None
    endless: Alone | None
    notes: tuple[str, ...] = ()
    doubts: tuple[str, ...] = ()
    machine: Unknown | None = None
    loops: Differing | None = None
    posterior: Posterior | None = None

    @property
    def condition(self) -> float:
        """Condition number of the scaled derivatives: 1 where no parameter resembles another."""
        s = np.linalg.svd(self.jacobian / np.linalg.norm(self.jacobian, axis=0), compute_uv=False)
        return float(s[0] / s[-1])

    @property
    def joint(self) -> str:
        """Kind of joint of the model: "hinge" or "compliant"."""
        return "compliant" if isinstance(self.points, Walked) else "hinge"

    @property
    def scales(self) -> str:
        """The model's idealisation of the scales, in words."""
        return idealisation(self.beam, self.joint, ideal=self.joint == "hinge")

    @property
    def holds(self) -> bool:
        """Whether the errors hold: there are no doubts."""
        return not self.doubts

    def __repr__(self) -> str:
        used = f"{np.count_nonzero(self.used)} of {self.used.size} points"
        return f"Fit({', '.join(self.lines)}; {used}, rms {self.rms:.3g} {TESTS[self.load].force})"

    def _repr_html_(self) -> str:
        """Return the card of a notebook."""
        notes = [*self._doubted, *self.checked, *self.notes]
        rows = zip(self.asked.rows, self.estimates, self.deviations, strict=True)
        found = [(f"{row.name}, {row.words}", row.written(value, error)) for row, value, error in rows]
        used = f"{np.count_nonzero(self.used)} of {self.used.size} points"
        return card(f"Fit: {used}, residual rms {TESTS[self.load].size(self.rms)}; {self.scales}", found, notes)

    @property
    def _doubted(self) -> list[str]:
        """Sentences that question the estimates."""
        return [*self.doubted, *filter(None, [self.of_machine])]

    @property
    def doubted(self) -> list[str]:
        """Sentences on why the errors do not hold, and on the other model's estimates."""
        return [*(f"the errors do not hold: {doubt}" for doubt in self.doubts), *filter(None, [self.disagreement])]

    @property
    def _outside(self) -> list[str]:
        """Warnings where the beam leaves the range of the model."""
        return self.beam.warnings(self.load if self.load in LOADS else "bending", joint=self.joint)

    @property
    def warnings(self) -> list[str]:
        """Doubts about the errors, and warnings where the beam leaves the range of the model."""
        return [*self.doubted, *self._outside]

    @property
    def of_machine(self) -> str:
        """A sentence on the effect of a compliant testing machine; empty where its stiffness is given."""
        return self.machine.sentence(self.values) if self.machine is not None and self.machine.told else ""

    @property
    def checked(self) -> list[str]:
        """Sentences on the effect of the beam's own number of scales and on the slope before engagement."""
        steep = self.slope.sentence if self.slope else "slope before engagement: too few points there to check the bar"
        if self.endless is not None:
            return [self._compared(self.endless), steep]
        if self.row is None:
            return [f"fitted as {self.fitted_as}", steep] if TESTS[self.load].pushed else [steep]
        n, load, torque, tangent, end = self.row
        lost = [n for n in self.parameters if n in ("mu", "K_theta")]
        biased = f": {' and '.join(lost)} are those of an endless beam and biased by it" if lost else ""
        row = f"{n} scales have {torque:.3g} of the torque and {tangent:.3g} of the tangent of an endless beam"
        place = f"where the row ends: {end}" if end else "the top of the data"
        return [f"{row} at {per_pitch(load)}, {place} (squama row){biased}", steep]

    def _compared(self, other: Alone) -> str:
        """Return a sentence on the scales of a fit with ends, and on the estimates of the endless beam."""
        head = f"fitted as {self.fitted_as}; as an endless beam: "
        if other.values is None or other.errors is None:
            return f"{head}no fit ({other.problem})"
        rows = [*zip(other.rows, other.values, other.errors, strict=True)]
        values = ", ".join(f"{r.name} = {r.written(v, e)}" for r, v, e in rows if r.name not in self.added)
        return f"{head}{values}, residual rms {TESTS[self.load].size(other.rms)}"

    @property
    def fitted_as(self) -> str:
        """The beam of the model in words: "25 scales with free ends", "an endless beam"."""
        if self.ends == ENDLESS:
            return "an endless beam"
        if TESTS[self.load].pushed:
            return f"{self.beam.pitches} scales, {self.ends}"
        return f"{self.beam.scales} scales {ending(self.ends)}"

    def summary(self) -> str:
        """Return estimates, errors, correlations and notes as text."""
        head = [*self.described(), *self._doubted, *self.checked]
        return "\n".join([*head, *(f"{name} {text}" for name, text in self.sizes), *self.more])

    @property
    def sizes(self) -> list[tuple[str, str]]:
        """Residuals and number of points as text, each with its name."""
        share = 100 * self.rms / float(np.abs(self.record.torque[self.used]).max())
        source = "given" if self.given_noise else "from the residuals"
        counts = {words: np.count_nonzero(self.branch == b) for b, words in BRANCHES.items()}
        states = ", ".join(f"{count} {words}" for words, count in counts.items() if count)
        size = TESTS[self.load].size
        noise = f"{share:.2g} % of the largest; noise {size(self.noise)} ({source})"
        return [
            ("residual", f"rms {size(self.rms)}, {noise}"),
            ("points", f"{np.count_nonzero(self.used)} of {self.used.size} used: {states}"),
        ]

    @property
    def more(self) -> list[str]:
        """Sentences on single specimens, posterior samples and notes."""
        lines = []
        for s in self.specimens:
            text = s.problem
            if s.values is not None and s.errors is not None:
                text = ", ".join(written(s.rows, s.values, s.errors))
            lines.append(f"specimen {s.label} alone: {text}")
        if self.posterior is not None:
            x, note = self.posterior.samples, self.posterior.note()
            found = ", ".join(written(self.rows, x.mean(axis=0), x.std(axis=0, ddof=1)))
            worth = f"worth {self.posterior.effective:.0f} independent ones"
            worth += f", from {self.posterior.walked} walks of the model" if self.posterior.walked else ""
            lines.append(f"posterior, {len(x)} samples ({worth}): {found}")
            lines += [f"note: {note}"] if note else []
        return [*lines, *super().more]

    def report(self) -> dict[str, object]:
        """Return the whole result as plain data, for JSON."""
        rec, samples, asked, load = self.record, self.posterior, self.asked, TESTS[self.load]
        columns = (asked.low, asked.high, asked.start, self.at_bound)
        labels = [specimen.label for specimen in rec.specimens]
        drawn = samples and {
            "samples": len(samples.samples),
            "effective": samples.effective,
            "mean": self._by_name(samples.samples.mean(axis=0)),
            "sd": self._by_name(samples.samples.std(axis=0, ddof=1)),
            **of(samples, "walked", "acceptance", "autocorrelation"),
        }
        return {
            **of(self, "load", "law", "joint", "scales"),
            "parameters": self._parameters(**dict(zip(("low", "high", "initial", "at_bound"), columns, strict=True))),
            **of(self, "correlation", "condition", "noise"),
            "noise_given": self.given_noise,
            **of(self, "rms", "dependence"),
            "nuisances": list(self.added),
            "starts": dict(zip(("agreed", "of"), self.starts, strict=True)),
            "points": {
                "specimen": [labels[i] for i in rec.specimen.tolist()],
                load.angle: rec.load,
                load.torque: rec.torque,
                f"{load.torque}_fit": self.fitted,
                f"{load.torque}_error": self.band,
                "residual": self.residuals,
                **of(self, "branch", "used"),
            },
            "specimens": [
                {"label": s.label, "estimates": s.values, "errors": s.errors, "problem": s.problem}
                for s in self.specimens
            ],
            "remedies": [{"what": r.what, "errors": self._by_name(r.errors)} for r in self.remedies],
            "disagreement": self.disagreement,
            "slope": self.slope and self.slope._asdict(),
            "ends": self.ends,
            "number_of_scales": None if self.ends == ENDLESS else self.beam.scales,
            "row": self.row and self.row._asdict(),
            "endless": self.endless and {name: getattr(self.endless, name) for name in Alone._fields[1:]},
            "doubts": list(self.doubts),
            "machine": self.machine and self.machine.report(),
            "differing": self.loops and self.loops.report(),
            "notes": list(self.notes),
            "posterior": drawn,
            "beam": self.beam.model_dump(),
            "squama_version": __version__,
            "warnings": self._outside,
        }

    def dataset(self) -> xr.Dataset:
        """Return all results as an ``xarray.Dataset``: dimensions ``point``, ``parameter``, ``curve``, ``sample``."""
        load, rec = TESTS[self.load], self.record
        labels = np.array([s.label for s in rec.specimens])
        error = f"standard error of the fitted {load.torque_words}"
        drawn, T = self.curve(), load.torque
        table: Table = {
            # (a travel is of the whole part, and has one name)
            load.rate: ("point", rec.load / self.beam.pitch, load.rate_words, "rad/m"),
            load.angle: ("point", rec.load, load.angle_words, load.unit),
            T: ("point", rec.torque, f"measured {load.torque_words}", load.force),
            f"{T}_fit": ("point", self.fitted, f"fitted {load.torque_words}", load.force),
            f"{T}_error": ("point", self.band, error, load.force),
            "residual": ("point", self.residuals, "measured less fitted", load.force),
            "specimen": ("point", labels[rec.specimen], "specimen", ""),
            "branch": ("point", self.branch, "state in which the point was reached", ""),
            "used": ("point", self.used, "whether the fit is made from the point", ""),
            "low": ("parameter", self.asked.low, "lower bound", None),
            "high": ("parameter", self.asked.high, "upper bound", None),
            "initial": ("parameter", self.asked.start, "value in the beam as given", None),
            "rms": ("", self.rms, "root mean square of the residuals", load.force),
            "noise": ("", self.noise, "standard deviation of a point", load.force),
            f"{load.angle}_curve": ("curve", drawn.load, f"{load.angle} of the fitted curve", load.unit),
            f"{T}_curve": ("curve", drawn.torque, "fitted curve", load.force),
            f"{T}_curve_error": ("curve", drawn.error, "standard error of the fitted curve", load.force),
            "leg": ("curve", drawn.leg, "way between two reversals, counted from 1", None),
        }
        if self.posterior is not None:
            table["sample_value"] = ("sample parameter", self.posterior.samples, "posterior sample", None)
        attrs = {
            **of(self, "load", "law", "joint", "scales", "disagreement"),
            "initial_beam": self.initial.to_toml(),
            "checked": "\n".join(self.checked),
            **({} if self.ends == ENDLESS else {"ends": self.ends}),
            "doubts": "\n".join(self.doubts),
            "notes": "\n".join(self.notes),
            "remedies": json.dumps([{"what": r.what, "errors": r.errors.tolist()} for r in self.remedies]),
        }
        return self._labelled(f"test in {self.load}", table, attrs)

    def plot(self) -> Figure:
        """Draw measured points, the fitted curve and the residuals, see :func:`squama.plot.fit_figure`."""
        from squama.plot import fit_figure

        return fit_figure(self.dataset())

    def predict(self, to: float | str | Sequence[float | str], **how: Any) -> xr.Dataset:
        """Predict the curve of the fitted beam there and back, with a band from draws of the parameters.

        Parameters
        ----------
        to
            As in :func:`squama.cycle`: the largest twist, or a history; of a part under a force the travel of the
            loaded place, m or text such as "5 mm", or a history of travels.
        how
            ``samples`` (100) draws from the estimates and their covariance, or from the posterior samples; ``seed`` (1)
            of them; ``points`` (60) of a way; ``probability`` (0.95) within the band.

        Returns
        -------
        xarray.Dataset
            Dimension ``point``: angle, ``leg``, torque of the estimates (N m), ``T_low`` and ``T_high``, in bending
            ``M_low`` and ``M_high``, of a part ``travel`` (m), ``F_low`` and ``F_high`` (N); ``T_draws`` (draw, point);
            ``work`` (J) of the whole history per pitch, or of the part, with its band. A band is NaN where at least
            half of the draws have ended.

        Raises
        ------
        InputError
            An argument is out of range, or the model cannot follow more than half of the draws.
        """
        if isinstance(self.points, Walked) and self.points.load.pushed:
            course: Course = Pushed(self.points, self.asked, self.estimates, to)
        else:
            hinged = self.joint == "hinge"
            model = {**of(self, "load", "law", "joint"), "ideal": hinged, "ends": None if hinged else self.ends}
            course = Cycled(self.asked._replace(beam=self.beam), model, to)
        return predict(self, course, self.posterior, **how)

    def curve(self) -> Curve:
        """Return the fitted curve along the ways of the records, each once; a way back begins with the drop there."""
        once = "drift" not in self.parameters and not self.asked.groups
        drawn, leg = self.points.drawn(POINTS, once=once)
        error = estimate.standard_error(drawn, self.asked, self.estimates, self.covariance)
        torque = estimate.modelled(drawn, self.asked, self.estimates)
        return Curve(drawn.readings.load[drawn.index], torque, error, leg)


class Curve(NamedTuple):
    """Load angles (signed, rad per pitch), torques and errors (N m), and the number of each point's way, from 1."""

    load: Array
    torque: Array
    error: Array
    leg: Array

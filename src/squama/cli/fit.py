"""squama fit: parameters of a beam from measured torque and twist, or from the record of a decay."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, get_args

from cyclopts import Parameter

from squama import units
from squama.beam.beamfile import heading
from squama.cli import flags, output
from squama.cli.flags import flag, one_of, pair
from squama.cli.load import SUPPORT
from squama.cli.load import read as read_part
from squama.errors import Problems, refuse
from squama.io.files import label
from squama.io.numerals import DecimalName
from squama.loads import ENDLESS, LOADS, TESTS, ending, model
from squama.units import is_number, shown

if TYPE_CHECKING:
    import xarray as xr

    from squama.beam.design import Beam
    from squama.identify.decay_fit import DecayFit
    from squama.identify.result import Fit
    from squama.io.measured import Measured
    from squama.part.definition import Part

_pair = pair("name=lower:upper", "mu=0.1:0.5")


def _bounds(name: str, text: str) -> flags.Pair:
    """Read the bounds of a parameter; an open end is empty."""
    found = _pair.read(name, text)
    if found.text.count(":") != 1:
        refuse(f"{name} {shown(text)}", "", "is not name=lower:upper", "write e.g. mu=0.1:0.5")
    return found


def with_unit(unit: str) -> flags.Reader[str]:
    """Return a reader that refuses numbers without a unit (in Python SI)."""

    def read(name: str, text: str) -> str:
        if is_number(text):
            refuse(name, text, "has no unit", f'write e.g. "{text} {unit}"')
        return text

    return flags.Reader(read, "")


_prior = pair("name=tolerance", '--prior E_B="1.5 MPa +- 5 %"')
_limits = flags.Reader(_bounds, flags.Pair("", ""))
_FILES = (
    'Beam file (TOML) and CSV files of measured points with a header such as "Phi (deg/mm), T (N mm)", or one of a '
    'decay: "t (s), total (deg)".'
)
_FIND = (
    "Parameters to find: mu, K_theta, C_f, E_B, theta0, torque_zero, twist_zero, backlash, drift, compliance. "
    "Default: mu,K_theta; of a decay mu,K_theta,damping."
)
_BOUNDS = 'Bounds of a parameter, e.g. mu=0.1:0.5 or theta0="5 deg:20 deg"; may be repeated.'
_NOISE = 'Standard deviation of a measured torque or force, e.g. "5 N mm". Default: from the residuals.'
_TO = 'Twist or travel beyond which points are not used, e.g. "0.1 rad/pitch".'
_REVERSAL = 'Noise of the twist: a smaller way back is no reversal, e.g. "0.5 deg total". Default: from the points.'
_NUISANCES = "Zeros, backlash and drift of the test: auto (found where the residual shows them) or none. Default: auto."
_POSTERIOR = "Number of posterior samples (extra fit). Default: 0."
_DECIMAL = 'Decimal sign of measured points: "." or ",". Default: guessed.'
_COLUMNS = (
    'Names and units of the columns of measured points: "Winkel=total (deg), 3=T (N mm)". Default: from the header.'
)
_JOINT = "Joint of a scale: compliant or hinge. Default: compliant; hinge with the plate law."
Joint = Annotated[str | None, flag(_JOINT, read=one_of("hinge", "compliant"))]
_EACH = 'Parameters with a value for each loop, or each specimen: "mu", "mu,twist_zero".'
_MACHINE = 'Stiffness of the testing machine in series: "2 N m/rad", "5 N/mm", "2 +- 0.5 N m/rad" (found too) or rigid.'
_PRIOR = 'Prior of a parameter to find: E_B="1.5 MPa +- 5 %" (limits), mu="0.3 +- 0.03 sd"; may be repeated.'
_KNOWN = "TOML file with tolerances under [tolerance], as priors; --prior takes precedence."
_PREDICT = 'Predict the curve of the fitted beam to a twist (travel) and back, with a band of 95 %: "0.1 rad/pitch".'
_BAND = "File of the prediction to write: .png, .svg, .pdf, .csv or .nc; may be repeated."
_KINDS = (*flags.PLOTS, ".csv", ".nc")
_LOAD = (
    'Load: twisting, bending (of the ends), or the force on a part, of which the table has force and travel: "1 N up '
    'at tip". Default: [[load]] of the file, or twisting.'
)
_STICK = 'Twist after a reversal for which points are not used, e.g. "0.002 rad/pitch".'


@flags.group
class Search:
    """Settings of the search: arguments of :func:`squama.fit`."""

    load: Annotated[str | None, flag(_LOAD)] = None
    support: Annotated[str | None, flag(SUPPORT)] = None
    law: flags.Law = "edge"
    noise: Annotated[str | None, flag(_NOISE)] = None
    to: Annotated[str | None, flag(_TO)] = None
    reversal: Annotated[str | None, flag(_REVERSAL)] = None
    stick: Annotated[str | None, flag(_STICK)] = None
    starts: Annotated[int, flag("Number of starts of the search. Default: 6.", read=flags.whole(1, 1000, "6"))] = 6
    posterior: Annotated[int, flag(_POSTERIOR, read=flags.whole(0, 1_000_000, "4000"))] = 0
    seed: Annotated[int, flag("Seed of the samples. Default: 1.", read=flags.whole(0, 2**32 - 1, "1"))] = 1
    joint: Joint = None
    nuisances: Annotated[str, flag(_NUISANCES, read=flags.one_of("auto", "none"))] = "auto"
    ends: flags.Ends = None
    each: Annotated[str | None, flag(_EACH)] = None
    machine: Annotated[str | None, flag(_MACHINE)] = None


SEARCH = Search()


@flags.group
class Swing:
    """Motion in a decay: arguments of :func:`squama.fit_decay`."""

    mode: flags.Mode = "uniform"
    ideal: flags.Ideal = None


@flags.group
class Tables:
    """Settings for reading tables of measured points."""

    decimal: Annotated[DecimalName | None, flag(_DECIMAL, read=one_of(*get_args(DecimalName)))] = None
    columns: Annotated[str | None, flag(_COLUMNS)] = None

    def swings(self, path: str) -> bool:
        """Return whether a table is the record of a decay."""
        from squama.io import measured

        with flags.laid({"columns": "--columns"}):
            return measured.swings(path, self.columns)

    def read(self, paths: Iterable[str], beam: Beam, load: str, *, decay: bool = False) -> list[Measured]:
        """Return the measured points of tables of a beam's tests, or of the record of its decay."""
        from squama.io import measured
        from squama.io.columns import TIME

        found, wrong = [], Problems()
        for path in paths:
            with wrong.caught(), flags.laid({"decimal": "--decimal", "columns": "--columns"}):
                given = {"pitch": beam.pitch, "scales": beam.pitches, **vars(self)}
                found.append(measured.read(path, load=load, ordinate=TIME if decay else None, **given))
        wrong.settle()
        return found


@flags.group
class Prediction:
    """A curve predicted from a fit, and the files of its band."""

    predict: Annotated[str | None, flag(_PREDICT)] = None
    band: Annotated[tuple[flags.File, ...], flag(_BAND)] = ()

    def check(self, files: Iterable[str]) -> None:
        """Collect mistakes: files that cannot be written, and files of a prediction without --predict."""
        flags.check_places([(path, _KINDS) for path in self.band], list(files))
        if self.band and self.predict is None and "--predict" not in flags.problems().flags:
            flags.problems().add("--band", self.band[0], "is of a prediction", 'give --predict "0.1 rad/pitch" too')

    def of(self, found: Fit) -> tuple[list[Path], list[str], dict[str, object]]:
        """Predict the curve of a fit; return files, lines of the summary, and JSON."""
        if self.predict is None:
            return [], [], {}
        from squama.io import datasets

        with flags.laid({"to": "--predict"}):
            data = found.predict(self.predict)
        load = TESTS[found.load]
        T, at = load.torque, data.isel(point=int(abs(data[load.angle].values).argmax()))
        shown = (lambda F: units.number(F, load.force)) if load.pushed else units.moment
        best, low, high = (shown(float(at[name])) for name in (T, f"{T}_low", f"{T}_high"))
        share = f"{100 * float(data.attrs['probability']):g} % of {data.attrs['draws']} draws of the fit"
        line = f"prediction to {self.predict}: {best} there; {share} lie between {low} and {high}"
        written = output.draw([p for p in self.band if p.endswith(flags.PLOTS)], "prediction_figure", data)
        for path in self.band:
            if not path.endswith(flags.PLOTS):
                table = data if path.endswith(".nc") else on_points(data)
                written.append(datasets.save(table, path))
        record = {str(name): v.values for name, v in data.data_vars.items() if "draw" not in v.dims}
        return written, [line], {"prediction": {**record, "units": output.units(data.data_vars.items())}}


SWING, TABLES, PREDICTION = Swing(), Tables(), Prediction()
_OF_DECAYS = ("load", "law", "joint", "ends")
"""Settings that a decay shares with a test."""


def fit(
    *files: Annotated[flags.File, Parameter(help=_FILES)],
    find: Annotated[str | None, flag(_FIND)] = None,
    bounds: Annotated[tuple[flags.Pair, ...], flag(_BOUNDS, read=_limits, many=True)] = (),
    prior: Annotated[tuple[flags.Pair, ...], flag(_PRIOR, read=_prior, many=True)] = (),
    tolerances: Annotated[flags.File | None, flag(_KNOWN)] = None,
    search: Search = SEARCH,
    swing: Swing = SWING,
    tables: Tables = TABLES,
    prediction: Prediction = PREDICTION,
    out: Annotated[flags.File | None, flag("Beam file (.toml) to write, with the estimates.", "--out", "-o")] = None,
    corner: Annotated[flags.File | None, flag("Picture of the posterior samples to write.")] = None,
    full: flags.Full = False,
    common: flags.Common = flags.COMMON,
) -> int:
    """Fit friction, joint stiffness and other parameters to measured torque and twist, or to a decay."""
    beams = [f for f in files if f.lower().endswith(".toml")]
    data = [f for f in files if f not in beams]
    _count(beams, data)
    limits = flags.once("--bounds", bounds)
    if corner is not None and not search.posterior and "--posterior" not in flags.problems().flags:
        flags.problems().add("--corner", corner, "draws posterior samples", "ask for them too, e.g. --posterior 4000")
    common.check(*files, *([tolerances] if tolerances else []), plots=[corner] if corner else [])
    flags.check_places([(out, (".toml",))], files)
    prediction.check(files)
    given: Beam | Part | None = None
    if len(beams) == 1:
        # twisting and bending of the ends need no load or support of the file
        ends = search.load in LOADS
        given = common.beam(beams[0], friction=False) if ends else read_part(common, beams[0], friction=False)
    flags.problems().settle()
    assert given is not None

    from squama.cli.uncertainty import given_tolerances
    from squama.identify import decay_fit, fitting, known
    from squama.identify.joint_points import of_test

    names = {name: f"--{name}" for name in vars(search)}
    names |= {"parameters": "--find", "bounds:": "--bounds", "data": ", ".join(data), "mode": "--mode"}
    decays = any(tables.swings(path) for path in data)
    if decays:
        others = {"bounds": bounds, "prior": prior, "tolerances": tolerances, "predict": prediction.predict}
        _of_tests(data, {**vars(search), "corner": corner, **others})
    elif swing != SWING:
        refuse("--mode, --ideal", "", "are for decays: no table has a column of time, and no torque")
    own = {name: f"{label(beams[0])}: {heading(name)}" for name in ("load", "support", "along")}
    with flags.laid(own | {name: f"--{name}" for name in own if getattr(search, name, None)}):
        kind, part = of_test(given, search.load, search.support)
    _have_units(search, prediction, kind)
    read = tables.read(data, part.beam, kind, decay=decays)
    wanted = () if find is None else (find,)
    found: Fit | DecayFit
    with flags.laid(names):
        if decays:
            how = {**{name: getattr(search, name) for name in _OF_DECAYS}, "load": kind, **vars(swing)}
            found = decay_fit.fit_decay(read[0], part.beam, *wanted, **how)
        else:
            how = {name: value for name, value in vars(search).items() if value is not None}
            parted = ((name, text.partition(":")) for name, text in limits.items())
            priors = partial(known.read, beam=part.beam, bare=False)
            how["tolerances"] = given_tolerances("--prior", prior, tolerances, priors) or None
            flags.problems().settle()
            how["bounds"] = {name: (low.strip(), high.strip()) for name, (low, _, high) in parted}
            found = fitting.fit(read, given, *wanted, **how)
    written = output.write(common, found.dataset, *(("decay_figure", on_points) if decays else ("fit_figure", flat)))
    if corner:
        written += output.draw([corner], "corner_figure", found.dataset())
    if out is not None:
        written.append(output.write_text(out, found.beam_file([label(path) for path in data])))
    more, lines, of_band = ([], [], {}) if isinstance(found, decay_fit.DecayFit) else prediction.of(found)
    record = {"file": label(beams[0]), "data": data, **found.report(), **of_band}
    shown = _summary(found, label(beams[0]), lines).shown(full=full)
    return output.report(common.json, ", ".join(data), [*written, *more], record, shown)


def _have_units(search: Search, prediction: Prediction, kind: str) -> None:
    """Refuse numbers without a unit (in Python SI) for torques, forces, twists and travels."""
    load = TESTS[kind]
    given = {"noise": search.noise, "to": search.to, "reversal": search.reversal, "stick": search.stick}
    units = {"noise": load.force, "machine": "N/mm" if load.pushed else "N m/rad"}
    for name, text in (given | {"predict": prediction.predict, "machine": search.machine}).items():
        if text is not None:
            unit = units.get(name, "mm" if load.pushed else "rad/pitch")
            with flags.problems().caught():
                with_unit(unit).read(f"--{name}", text)
    flags.problems().settle()


def _of_tests(data: list[str], given: Mapping[str, object]) -> None:
    """Refuse several files, and flags for tests of torque and twist only, with a decay."""
    for path in data[1:]:
        flags.problems().add(path, "", "is a second file beside the record of a decay", "give one")
    for name, value in given.items():
        if name not in _OF_DECAYS and value != getattr(SEARCH, name, None) and value != ():
            flags.problems().add(f"--{name}", "", "is for torque and twist, not for a decay", "leave it out")
    flags.problems().settle()


def _summary(found: Fit | DecayFit, file: str, predicted: list[str]) -> output.Summary:
    """Return the summary: estimates with errors, then checks and doubts; ``predicted``: lines of a prediction."""
    from squama.identify.decay_fit import DecayFit

    verdict, full = ", ".join(found.lines), [*found.described(), *found.more]
    if isinstance(found, DecayFit):
        ends = found.attrs["ends"]
        many = "endless beam" if ends == ENDLESS else f"{found.beam.scales} scales {ending(ends)}"
        words = f"{model(found.attrs)}; {many}; {found.attrs['load']}, {found.mode}; a decay (time, no torque)"
        return output.Summary(verdict, [*found.sizes, ("beam", file), ("model", words)], predicted, (), full)
    kind = TESTS[found.load].model(found.law, found.joint, found.scales)
    figures = [*found.sizes, ("beam", file), ("model", f"{kind}; {found.fitted_as}; {found.load}")]
    table = [*predicted, *found.checked, *filter(None, [found.of_machine])]
    verdict = verdict if found.holds else f"{verdict}; the errors do not hold"
    return output.Summary(verdict, figures, table, found.warnings, full)


def _count(beams: list[str], data: list[str]) -> None:
    """Collect mistakes in the files: beam or data missing, or given twice."""
    usage = "write: squama fit test.csv beam.toml"
    if not data:
        flags.problems().add("", "", "no measured points are given", usage)
    if not beams:
        flags.problems().add("", "", "no beam file (.toml) is given", usage)
    if len(beams) > 1:
        flags.problems().add(beams[1], "", "is a second beam file", "give one")
    for path in dict.fromkeys(data):
        if data.count(path) > 1:
            flags.problems().add(path, "", "is given twice", "give each file once")


def on_points(dataset: xr.Dataset) -> xr.Dataset:
    """Return the variables of a fit along ``point`` only."""
    return dataset.drop_dims([d for d in dataset.dims if d != "point"])


def flat(dataset: xr.Dataset) -> xr.Dataset:
    """Return the variables of a fit along ``point`` as a table, with the estimates as attributes."""
    keys = ("estimate", "error", "low", "high", "initial", "unit")
    columns = [dataset[key].values.tolist() for key in ("parameter", *keys)]
    rows = [dict(zip(("name", *keys), row, strict=True)) for row in zip(*columns, strict=True)]
    return on_points(dataset).assign_attrs(parameters=rows, correlation=dataset["correlation"].values.tolist())

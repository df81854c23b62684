"""squama fit: parameters of a beam from measured torque and twist."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from squama.cli.options import Options, Problems, check_outputs, flag, read_number, read_overrides
from squama.errors import InputError

if TYPE_CHECKING:
    from squama.design import Beam
    from squama.identify.result import Fit


def fit(
    *files: str,
    find: Annotated[
        str, flag('What to find: "mu,K_theta" (default), any of mu, K_theta, C_f, E_B, theta0, zero.')
    ] = "mu,K_theta",
    bounds: Annotated[
        tuple[str, ...], flag('Bounds of a parameter, e.g. mu=0.1:0.5 or theta0="5 deg:20 deg"; may be repeated.')
    ] = (),
    load: Annotated[str, flag("twisting or bending.")] = "twisting",
    law: Annotated[str, flag("Force law: edge (satisfies virtual work) or plate (the paper's).")] = "edge",
    noise: Annotated[
        str | None, flag('Standard deviation of a measured torque, e.g. "5 N mm"; from the residuals if not given.')
    ] = None,
    to: Annotated[str | None, flag('Twist beyond which points are not used, e.g. "0.1 rad/pitch".')] = None,
    reversal: Annotated[
        str | None, flag('Way back that is noise of the twist, not a reversal, e.g. "0.5 deg total".')
    ] = None,
    stick: Annotated[
        str | None, flag('Way after a reversal on which points are not used, e.g. "0.002 rad/pitch".')
    ] = None,
    starts: Annotated[str, flag("Number of starts of the search (6).")] = "6",
    posterior: Annotated[str, flag("Number of posterior samples to draw (0; extra fit).")] = "0",
    seed: Annotated[str, flag("Seed of the samples (1).")] = "1",
    set_: Annotated[
        tuple[str, ...],
        flag('A value in place of the beam file\'s, e.g. scale.alpha="30 deg"; may be repeated.', "--set"),
    ] = (),
    out: Annotated[
        str | None, Parameter(name=("--out", "-o"), help="Beam file to write, estimates put in (.toml).")
    ] = None,
    plot: Annotated[tuple[str, ...], flag("Picture to write: .png, .svg or .pdf; may be repeated.")] = (),
    corner: Annotated[str | None, flag("Picture of the posterior samples to write.")] = None,
    csv: Annotated[str | None, flag("CSV file to write: a row per point, units in the header.")] = None,
    netcdf: Annotated[str | None, flag("netCDF file to write (.nc), samples included.")] = None,
    json: Annotated[bool, Parameter(help="Print everything as JSON instead of the summary.")] = False,
) -> int:
    """Find friction, joint stiffness and other parameters of a beam from measured torque and twist.

    Parameters
    ----------
    files
        Measured points, one or more CSV files with a header such as "Phi (deg/mm), T (N mm)", and the beam file.
    """
    from squama import checks
    from squama.cli import run

    problems = Problems()
    numbers: dict[str, Any] = {}
    overrides: dict[str, dict[str, Any]] = {}
    limits: dict[str, tuple[str, str]] = {}
    beams = [f for f in files if f.lower().endswith(".toml")]
    data = [f for f in files if f not in beams]
    problems.lines += _counted(beams, data)
    for name, text, low, high, example in (
        ("starts", starts, 1, 1000, "6"),
        ("posterior", posterior, 0, 1_000_000, "4000"),
        ("seed", seed, 0, 2**32 - 1, "1"),
    ):
        with problems.caught():
            numbers[name] = _whole(f"--{name}", text, low, high, example)
    with problems.caught():
        overrides = read_overrides(set_)
    with problems.caught():
        limits = read_bounds(bounds)
    for name, value, allowed in (("law", law, ("edge", "plate")), ("load", load, ("twisting", "bending"))):
        with problems.caught():
            checks.one_of(f"--{name}", value, allowed)
    if corner is not None and not numbers.get("posterior"):
        problems.lines.append(f"--corner {corner}: draws posterior samples; ask for them too, e.g. --posterior 4000")
    problems.lines += _outputs((*plot, *([corner] if corner else [])), csv, netcdf, out, files)
    beam: Beam | None = None
    if len(beams) == 1:
        with problems.caught():
            beam = run.read_beam(beams[0], overrides)
    problems.settle()
    assert beam is not None

    given = {"to": to, "noise": noise, "reversal": reversal, "stick": stick}
    numbers |= {name: _with_unit(name, text) for name, text in given.items() if text is not None}
    result = _fitted(data, beam, find, {**numbers, "load": load, "law": law, "bounds": limits})
    written = _write(result, plot, corner, csv, netcdf, out, data)
    if json:
        _record(beams[0], data, result, written)
    else:
        _show(beams[0], data, result, written)
    return 0


def _counted(beams: list[str], data: list[str]) -> list[str]:
    """Say what is missing of beam and data, or given twice."""
    lines = []
    if not data:
        lines.append("no measured points are given; write: squama fit test.csv beam.toml")
    if not beams:
        lines.append("no beam file (.toml) is given; write: squama fit test.csv beam.toml")
    if len(beams) > 1:
        lines.append(f"{beams[1]}: is a second beam file; give one")
    lines += [f"{f}: is given twice; give each file once" for f in dict.fromkeys(data) if data.count(f) > 1]
    return lines


def read_bounds(texts: tuple[str, ...]) -> dict[str, tuple[str, str]]:
    """Return the bounds of --bounds by parameter, as texts; an open end is empty."""
    from squama.units import shown

    found: dict[str, tuple[str, str]] = {}
    problems = []
    for text in texts:
        name, equals, value = text.partition("=")
        low, colon, high = value.strip().strip('"').partition(":")
        if not (name.strip() and equals and colon) or ":" in high:
            problems.append(f"--bounds {shown(text)}: is not name=lower:upper; write e.g. mu=0.1:0.5")
        elif name.strip() in found:
            problems.append(f"--bounds {shown(text)}: {name.strip()} is bounded twice; give both bounds at once")
        else:
            found[name.strip()] = (low.strip(), high.strip())
    if problems:
        raise InputError("\n".join(problems))
    return found


def _whole(name: str, text: str, low: int, high: int, example: str) -> int:
    value = read_number(name, text, low, high, f"{low} to {high}", example)
    if value != int(value):
        message = f"{name} = {text}: is not a whole number; write e.g. {example}"
        raise InputError(message)
    return int(value)


def _with_unit(name: str, text: str) -> str:
    """Refuse numbers without a unit, which in Python are SI."""
    try:
        float(text)
    except ValueError:
        return text
    unit = "N m" if name == "noise" else "rad/pitch"
    message = f'--{name} = {text}: has no unit; write e.g. "{text} {unit}"'
    raise InputError(message)


def _outputs(
    plots: tuple[str, ...], csv: str | None, netcdf: str | None, out: str | None, inputs: tuple[str, ...]
) -> list[str]:
    """Look at every output path before any work."""
    from squama.files import label
    from squama.store import check_place

    lines = check_outputs(Options(plot=plots, csv=csv, netcdf=netcdf), inputs)
    if out is not None:
        try:
            check_place(out, (".toml",))
        except InputError as error:
            lines += str(error).splitlines()
        if Path(out).resolve() in {Path(f).resolve() for f in inputs}:
            lines.append(f"{label(out)}: is read too; give the output another name")
    return lines


def _fitted(data: list[str], beam: Beam, find: str, arguments: dict[str, Any]) -> Fit:
    """Fit; a mistake in an argument is laid to the flag it came from."""
    from squama.identify import facade

    flags = {"parameters:": "--find:", "bounds:": "--bounds", "data:": f"{', '.join(data)}:"}
    flags |= {f"{name} = ": f"--{name} = " for name in ("to", "noise", "reversal", "stick")} | {"to:": "--to:"}
    try:
        return facade.fit(data, beam, find, **arguments)
    except InputError as error:
        lines = str(error).splitlines()
        for i, line in enumerate(lines):
            for start, said in flags.items():
                if line.startswith(start):
                    lines[i] = said + line.removeprefix(start)
                    break
        raise InputError("\n".join(lines)) from None


def _write(
    fit: Fit,
    plot: tuple[str, ...],
    corner: str | None,
    csv: str | None,
    netcdf: str | None,
    out: str | None,
    data: list[str],
) -> list[Path]:
    written: list[Path] = []
    if plot or corner or csv or netcdf:
        from squama import store

        dataset = fit.dataset()
        if plot or corner:
            from squama import plot as figures

            if plot:
                figure = figures.fit_figure(dataset)
                written += [figures.save_figure(figure, path) for path in plot]
            if corner:
                written.append(figures.save_figure(figures.corner_figure(dataset), corner))
        if csv is not None:
            written.append(store.save(flat(dataset), csv))
        if netcdf is not None:
            written.append(store.save(dataset, netcdf))
    if out is not None:
        from squama import files
        from squama.identify import wording

        text = wording.beam_file(fit, [files.label(path) for path in data])
        written.append(files.atomic_write(out, lambda place: place.write_text(text, encoding="utf-8")))
    return written


def flat(dataset: Any) -> Any:
    """Return a fit with the dimension ``point`` only, as a table of one shape; the estimates as an attribute."""
    rows = [
        {"name": str(name)}
        | {v: dataset[v].values[i].item() for v in ("estimate", "error", "low", "high", "initial", "unit")}
        for i, name in enumerate(dataset["parameter"].values)
    ]
    table = dataset.drop_dims([d for d in dataset.dims if d != "point"])
    return table.assign_attrs(parameters=rows, correlation=dataset["correlation"].values.tolist())


def _record(beam: str, data: list[str], fit: Fit, written: list[Path]) -> None:
    from squama import files
    from squama.cli import record
    from squama.identify import wording

    record.show({"file": files.label(beam), "data": data, **wording.record(fit), "written": [str(p) for p in written]})


def _show(beam: str, data: list[str], fit: Fit, written: list[Path]) -> None:
    """Print the summary."""
    from rich.console import Console

    from squama import files

    console = Console(highlight=False, markup=False, emoji=False)
    law = f", {fit.law} law" if fit.load == "twisting" else ""
    names = ", ".join(files.label(path) for path in data)
    console.print(f"{names} fitted with {files.label(beam)} in {fit.load}{law}", style="bold", soft_wrap=True)
    lines = fit.summary().splitlines()
    lines += [f"warning: {line}" for line in fit.beam.warnings(fit.load)]
    lines += [f"wrote {files.label(place)}" for place in written]
    for line in lines:
        console.print(line, soft_wrap=True)

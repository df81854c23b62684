"""squama cycle: loading, unloading and reversal, from a beam file."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from squama.cli.options import Options, Problems, check_outputs, flag, read_number, read_overrides
from squama.errors import InputError

if TYPE_CHECKING:
    import xarray as xr

    from squama.answer import Answer
    from squama.design import Beam

_KEYS = ("load", "law", "joint", "margin", "increment", "K_theta", "rigidity", "history", "squama_version")
SHOWN = 12
"""Loops in the table of the summary at most."""


def cycle(
    beam: str,
    /,
    *,
    to: Annotated[str | None, flag('Twist to and back: "5 rad/m", "0.2 rad/pitch" or "90 deg total".')] = None,
    history: Annotated[
        str | None,
        flag('Twists one after the other instead: "0, 0.15, 0.05, 0.2, 0 rad/pitch"; below 0 the other way.'),
    ] = None,
    loops: Annotated[str, flag("How many times it is gone through (1).")] = "1",
    load: Annotated[str, flag("twisting or bending; in bending the twists are curvatures (twisting).")] = "twisting",
    law: Annotated[str, flag("Force law: edge (satisfies virtual work) or plate (the paper's).")] = "edge",
    joint: Annotated[
        str, flag("How a scale is held: hinge (closed form) or compliant (six motions, by finite elements) (hinge).")
    ] = "hinge",
    mu: Annotated[str | None, flag("Coefficient of friction, e.g. 0.25.")] = None,
    margin: Annotated[str, flag("How near to a lock it may go: fraction of the path left before it (0.01).")] = "0.01",
    points: Annotated[str, flag("Number of points in contact of each way between two twists (60).")] = "60",
    set_: Annotated[
        tuple[str, ...],
        flag('A value in place of the file\'s, e.g. scale.alpha="30 deg"; may be repeated.', "--set"),
    ] = (),
    plot: Annotated[tuple[str, ...], flag("Picture to write: .png, .svg or .pdf; may be repeated.")] = (),
    csv: Annotated[str | None, flag("CSV file to write: a row per point, units in the header.")] = None,
    netcdf: Annotated[str | None, flag("netCDF file to write (.nc).")] = None,
    json: Annotated[bool, Parameter(help="Print everything as JSON instead of the summary.")] = False,
) -> int:
    """Load and unload a beam: loops, stick intervals, dissipation, damping, jamming, from a beam file.

    Parameters
    ----------
    beam
        Beam file (TOML); "squama new beam.toml" writes an example.
    """
    from squama import checks, files
    from squama.cli import run

    problems = Problems()
    arguments: dict[str, Any] = {"law": law, "load": load, "joint": joint}
    overrides: dict[str, dict[str, Any]] = {}
    with problems.caught():
        arguments["margin"] = read_number("--margin", margin, 1e-12, 1 - 1e-12, "at least 1e-12, below 1", "0.01")
    for name, text, low, high, example in (("points", points, 3, 100_000, "60"), ("loops", loops, 1, 10_000, "3")):
        with problems.caught():
            arguments[name] = _whole(f"--{name}", text, low, high, example)
    with problems.caught():
        overrides = read_overrides(set_)
    with problems.caught():
        if mu is not None:
            overrides.setdefault("friction", {})["mu"] = read_number("--mu", mu, 0.0, 10.0, "0 to 10", "0.25")
    words = (
        ("law", law, ("edge", "plate")),
        ("load", load, ("twisting", "bending")),
        ("joint", joint, ("hinge", "compliant")),
    )
    for name, value, allowed in words:
        with problems.caught():
            checks.one_of(f"--{name}", value, allowed)
    if (to is None) == (history is None):
        what = "both are given, give one of them" if to else 'give one of them, e.g. --to "0.2 rad/pitch"'
        problems.lines.append(f"--to, --history: {what}")
    problems.lines += check_outputs(Options(plot=plot, csv=csv, netcdf=netcdf), [beam])
    described = None
    with problems.caught():
        described = run.read_beam(beam, overrides)
    if described is not None and described.friction.mu is None and mu is None:
        problems.lines.append(
            f"{files.label(beam)}: friction.mu: is missing; write mu = 0.25 under [friction] or give --mu 0.25"
        )
    problems.settle()
    assert described is not None

    data = _computed(described, to, history, arguments)
    written = _write(data, plot, csv, netcdf)
    if json:
        _record(files.label(beam), described, data, written)
    else:
        _show(files.label(beam), described, data, written)
    return 0


def _whole(name: str, text: str, low: int, high: int, example: str) -> int:
    value = read_number(name, text, low, high, f"{low} to {high}", example)
    if value != int(value):
        message = f"{name} = {text}: is not a whole number; write e.g. {example}"
        raise InputError(message)
    return int(value)


def _computed(beam: Beam, to: str | None, history: str | None, arguments: dict[str, Any]) -> Answer:
    """Run the history; a mistake in it is laid to the flag it came from."""
    from squama import cycles

    name, text = ("--history", history) if to is None else ("--to", to)
    assert text is not None
    if to is not None and "," in to:
        message = f'--to = "{to}": is more than one twist; give them to --history'
        raise InputError(message)
    try:
        return cycles.cycled(beam, _with_unit(name, text), **arguments)
    except InputError as error:
        words = str(error)
        if words.startswith(("law", "load")):
            words = f"--{words}"
        raise InputError(name + words.removeprefix("twist") if words.startswith("twist") else words) from None


def _with_unit(name: str, text: str) -> str:
    """Refuse numbers without a unit, which in Python are rates in rad/m."""
    from squama import units

    last = text.rpartition(",")[2].strip()
    try:
        float(last)
    except ValueError:
        return text
    message = (
        f'{name} = {units.shown(text)}: has no unit; write "{text} rad/m", "{text} rad/pitch" or "{text} rad total"'
    )
    raise InputError(message)


def _write(data: Answer, plot: tuple[str, ...], csv: str | None, netcdf: str | None) -> list[Path]:
    written: list[Path] = []
    if not (plot or csv or netcdf):
        return written
    from squama import store

    dataset = data.dataset()
    if plot:
        from squama import plot as figures

        figure = figures.cycle_figure(dataset)
        written += [figures.save_figure(figure, path) for path in plot]
    if csv is not None:
        written.append(store.save(flat(dataset), csv))
    if netcdf is not None:
        written.append(store.save(dataset, netcdf))
    return written


def flat(dataset: xr.Dataset) -> xr.Dataset:
    """Return a cycle with the dimension ``point`` only, as a table of one shape; figures of loops as an attribute."""
    loops = [
        {str(name): v.values[i].item() for name, v in dataset.data_vars.items() if v.dims == ("loop",)}
        for i in range(dataset.sizes["loop"])
    ]
    senses = [
        {str(name): v.values[i].item() for name, v in dataset.variables.items() if v.dims == ("sense",)}
        for i in range(dataset.sizes["sense"])
    ]
    table = dataset.drop_dims(["loop", "sense"])
    return table.assign_attrs(loops=_words(loops), senses=_words(senses))


def _words(rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Return rows with infinity and NaN as words, for which JSON has no numbers."""
    return [
        {k: repr(v) if isinstance(v, float) and not math.isfinite(v) else v for k, v in row.items()} for row in rows
    ]


def _part(data: Answer, dim: str) -> dict[str, Any]:
    return {name: v.values for name, v in data.variables.items() if v.dims == (dim,)}


def _record(file: str, beam: Beam, data: Answer, written: list[Path]) -> None:
    from squama.cli import record

    record.show(
        {
            "file": file,
            **{key: data.attrs[key] for key in _KEYS if key in data.attrs},
            "mu": float(data["mu"]),
            "warnings": data.attrs["warnings"].splitlines(),
            "beam": beam.model_dump(),
            "loops": _part(data, "loop"),
            "senses": _part(data, "sense"),
            "curve": _part(data, "point"),
            **({"energy_error": data["energy_error"]} if "energy_error" in data.variables else {}),
            "units": {name: v.attrs.get("units", "") for name, v in data.variables.items()},
            "written": [str(path) for path in written],
        }
    )


def _show(file: str, beam: Beam, data: Answer, written: list[Path]) -> None:
    """Print the summary: a row per loop, and what holds for the whole history."""
    from rich.console import Console
    from rich.table import Table

    from squama import files
    from squama.cli.summary import moment, number

    console = Console(highlight=False, markup=False, emoji=False)
    console = Console(highlight=False, markup=False, emoji=False, width=max(console.width, 100))
    twisting = data.attrs["load"] == "twisting"
    angle, torque, tangent = ("phi", "T", "K_t") if twisting else ("psi", "M", "K_b")
    law = f", {data.attrs['law']} law" if twisting else ""
    law = ", compliant joint" if data.attrs["joint"] == "compliant" else law
    console.print(
        f"{file} in cycles of {data.attrs['load']}: mu = {float(data['mu']):g}{law}", style="bold", soft_wrap=True
    )
    bases, tops = data[f"{angle}_base"], data[f"{angle}_top"]
    if tops.size:
        table = Table(box=None, pad_edge=False, padding=(0, 1, 0, 0))
        drop, secant = f"{torque} drop N m", "secant N m2"
        for name in ("loop", f"{angle} rad/pitch", "W_d J/m", "U_max J/m", "damping", secant, drop, "left"):
            table.add_column(name, header_style="bold")
        for i in range(min(tops.size, SHOWN)):
            cells = [data[name][i] for name in ("W_d", "U_max", "zeta_eq", "K_sec", f"{torque}_drop")]
            left = number(data[f"{angle}_residual"][i])
            table.add_row(str(i + 1), f"{bases[i]:.4g} to {tops[i]:.4g}", *map(number, cells), left)
        console.print(table)
        lines = [f"the first {SHOWN} of {tops.size} loops"] if tops.size > SHOWN else []
        lines.append(
            "damping: W_d/(4 pi U_max), with U_max the elastic energy at the top of the loop; "
            f"left: {angle} that stays when the beam is let go at the top"
        )
    else:
        lines = ["no loop is closed: the history does not come back to where it turned"]
    work = float(data["W_fr"][-1])
    lines += [
        f"frictional work of the history: {work:.4g} J/m, {work * beam.length:.4g} J over {beam.scales} scales",
        f"largest {torque}: {moment(float(abs(data[torque]).max()))}; tangent stiffness {data[tangent].min():.4g} "
        f"to {data[tangent].max():.4g} N m2",
    ]
    if data.attrs["joint"] == "compliant":
        lines += _walked(data)
    for i, sense in enumerate(data["sense"]):
        if "phi_most" not in data.variables and twisting:
            continue
        engaged, jam = float(data[f"{angle}_e"][i]), float(data[f"{angle}_jam"][i])
        words = f"sense {sense}: {data['end'][i]}"
        if math.isfinite(engaged):
            at = number(float(data[f"{angle}_end"][i]), "rad/pitch")
            words = f"sense {sense}: engagement at {number(engaged, 'rad/pitch')}, {data['end'][i]} at {at}"
        if data["other_contact"][i]:
            words += f" ({data['other_contact'][i]})"
        words += f"; a history may go to {number(float(data[f'{angle}_most'][i]), 'rad/pitch')}"
        if math.isfinite(engaged):
            jams = f"let go beyond {number(jam, 'rad/pitch')} it stays twisted"
            words += f"; {jams if math.isfinite(jam) else 'let go from anywhere there it comes back'}"
        lines.append(words)
    lines += [f"warning: {line}" for line in data.attrs["warnings"].splitlines()]
    lines += [f"wrote {files.label(place)}" for place in written]
    for line in lines:
        console.print(line, soft_wrap=True)


def _walked(data: Answer) -> list[str]:
    """Return what only the compliant joint has to say."""
    lines = [
        f"walked in increments of up to {data.attrs['increment']:g} rad/pitch: the work of the torque is balanced to "
        f"{abs(float(data['energy_error'])):.1e}"
    ]
    for i, sense in enumerate(data["sense"]):
        words = "no contact"
        if data["first_contact"][i]:
            words = f"first contact at {float(data['phi_e'][i]):.4g} rad/pitch: {data['first_contact'][i]}"
        if data["other_contact"][i]:
            words += f"; then {data['other_contact'][i]}"
        lines.append(f"sense {sense}: {words}")
    return lines

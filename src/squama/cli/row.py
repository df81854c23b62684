"""squama row: every scale of a finite row, from a beam file."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from squama.cli.options import Options, Problems, check_outputs, flag, read_number, read_overrides, read_points
from squama.errors import InputError

if TYPE_CHECKING:
    import xarray as xr

    from squama.design import Beam


def row(
    beam: str,
    /,
    *,
    scales: Annotated[str | None, flag("Number of scales of the row, 2 to 2000 (that of the file).")] = None,
    mu: Annotated[str | None, flag("Coefficient of friction, e.g. 0.25.")] = None,
    to: Annotated[
        str | None,
        flag(
            'Where to stop: "5 rad/m", "0.2 rad/pitch" or "90 deg total" (where the endless beam\'s curve is cut off).'
        ),
    ] = None,
    sense: Annotated[str, flag("Which way the beam is twisted: + or - (+).")] = "+",
    points: Annotated[str, flag("Number of points along the twist (100).")] = "100",
    set_: Annotated[
        tuple[str, ...],
        flag('A value in place of the file\'s, e.g. scale.alpha="30 deg"; may be repeated.', "--set"),
    ] = (),
    plot: Annotated[tuple[str, ...], flag("Picture to write: .png, .svg or .pdf; may be repeated.")] = (),
    csv: Annotated[str | None, flag("CSV file to write: a row per point and scale, units in the header.")] = None,
    netcdf: Annotated[str | None, flag("netCDF file to write (.nc).")] = None,
    json: Annotated[bool, Parameter(help="Print everything as JSON instead of the summary.")] = False,
) -> int:
    """Twist a finite row of scales, whose end scales lack a neighbour: every scale's inclination and force.

    Parameters
    ----------
    beam
        Beam file (TOML); "squama new beam.toml" writes an example.
    """
    from squama import files
    from squama.cli import run

    problems = Problems()
    arguments: dict[str, Any] = {"sense": sense}
    overrides: dict[str, dict[str, Any]] = {}
    with problems.caught():
        arguments["scales"] = read_scales(scales)
    with problems.caught():
        arguments["points"] = read_points(points)
    with problems.caught():
        overrides = read_overrides(set_)
    with problems.caught():
        if mu is not None:
            overrides.setdefault("friction", {})["mu"] = read_number("--mu", mu, 0.0, 10.0, "0 to 10", "0.25")
    with problems.caught():
        read_sense(sense)
    problems.lines += check_outputs(Options(plot=plot, csv=csv, netcdf=netcdf), [beam])
    described = None
    with problems.caught():
        described = run.read_beam(beam, overrides)
    if described is not None:
        if arguments.get("scales"):
            described = described.replace(scales=arguments["scales"])
        with problems.caught():
            if to is not None:
                arguments["to"] = read_twist("--to", to, described)
        if described.friction.mu is None and mu is None:
            problems.lines.append(
                f"{files.label(beam)}: friction.mu: is missing; write mu = 0.25 under [friction] or give --mu 0.25"
            )
    problems.settle()
    assert described is not None

    from squama import rows

    data = rows.row(described, **arguments)
    written = _write(data, plot, csv, netcdf)
    if json:
        _record(files.label(beam), described, data, written)
    else:
        _show(files.label(beam), data, written)
    return 0


def read_scales(text: str | None, most: int = 2000) -> int | None:
    """Return the number of scales of --scales.

    Raises
    ------
    InputError
        It is no whole number of 2 or more.
    """
    if text is None:
        return None
    value = read_number("--scales", text, 2, most, f"2 to {most}", "25")
    if value != int(value):
        message = f"--scales = {text}: is not a whole number; write e.g. 25"
        raise InputError(message)
    return int(value)


def read_sense(text: str) -> None:
    """Check --sense."""
    if text not in ("+", "-"):
        message = f'--sense = "{text}": must be "+" or "-"'
        raise InputError(message)


def read_twist(name: str, text: str, beam: Beam) -> float:
    """Return the twist rate that a flag asks for, rad/m.

    Raises
    ------
    InputError
        It is no twist, or not above 0.
    """
    from squama import units

    try:
        rate = units.twist(text, pitch=beam.pitch, scales=beam.scales, bare=False)
    except units.QuantityError as error:
        message = f"{name} = {error.shown}: {error.reason}"
        raise InputError(message) from None
    if rate <= 0:
        message = f'{name} = {units.shown(text)}: must be more than 0; write e.g. "0.2 rad/pitch"'
        raise InputError(message)
    return rate


def _write(data: xr.Dataset, plot: tuple[str, ...], csv: str | None, netcdf: str | None) -> list[Path]:
    from squama import store

    written: list[Path] = []
    if plot:
        from squama import plot as figures

        figure = figures.row_figure(data)
        written += [figures.save_figure(figure, path) for path in plot]
    if csv is not None:
        # a table has one shape: what belongs to a point stands in the line of each of its scales
        table = data.reset_coords("phi")
        along = {name: v.broadcast_like(table["theta"]) for name, v in table.data_vars.items() if v.dims == ("point",)}
        written.append(store.save(table.assign(along), csv))
    if netcdf is not None:
        written.append(store.save(data, netcdf))
    return written


def _record(file: str, beam: Beam, data: xr.Dataset, written: list[Path]) -> None:
    from squama.cli import record

    def part(dims: tuple[str, ...]) -> dict[str, Any]:
        return {str(name): v.values for name, v in data.variables.items() if v.dims == dims}

    record.show(
        {
            "file": file,
            **{key: data.attrs[key] for key in ("load", "law", "sense", "squama_version")},
            "mu": float(data["mu"]),
            "warnings": data.attrs["warnings"].splitlines(),
            "beam": beam.model_dump(),
            "figures": {name: value for name, value in part(()).items() if name != "mu"},
            "curve": part(("point",)),
            "scales": part(("point", "scale")),
            "units": {str(name): data[name].attrs.get("units", "") for name in data.variables},
            "written": [str(path) for path in written],
        }
    )


def _show(file: str, data: xr.Dataset, written: list[Path]) -> None:
    """Print the summary: the row at its last point."""
    import math

    import numpy as np
    from rich.console import Console

    from squama import files
    from squama.cli.summary import moment, number
    from squama.model.outcome import SENTENCES, End

    console = Console(highlight=False, markup=False, emoji=False)
    n = data.sizes["scale"]
    last = data.isel(point=-1)
    console.print(
        f"{file} as a row of {n} scales: mu = {float(data['mu']):g}, sense {data.attrs['sense']}, edge law",
        style="bold",
        soft_wrap=True,
    )
    end = str(data["end"].item())
    theta = np.degrees(last["theta"].values)
    down = np.flatnonzero(last["Q"].values > 0) + 1
    endless = float(last["T_periodic"])
    lines = [
        f"engagement at phi = {number(float(data['phi_e']), 'rad/pitch')}",
        f"end: {end}"
        + (f" at phi = {number(float(data['phi_end']), 'rad/pitch')}" if np.isfinite(data["phi_end"]) else "")
        + (f", scale {int(data['scale_end'])}" if data["scale_end"] else ""),
        SENTENCES[End(end)] + (f" ({data['other_contact'].item()})" if data["other_contact"].item() else ""),
        f"torque there: {moment(float(last['T']))}"
        + (
            f"; endless beam: {moment(endless)}" if math.isfinite(endless) else "; the endless beam's curve ends before"
        ),
        f"inclinations there: first {theta[0]:.4g} deg, middle {theta[n // 2]:.4g} deg, last {theta[-1]:.4g} deg, "
        f"endless beam {number(math.degrees(float(last['theta_periodic'])), 'deg')}",
        f"what an end does decays by {number(float(data['decay']))} per scale (at engagement)",
        f"relative energy dissipation RED = {float(last['RED']):.4g}",
    ]
    if down.size:
        lines.append(f"lying on the substrate: scale {', '.join(map(str, down))}")
    lines += [f"warning: {line}" for line in data.attrs["warnings"].splitlines()]
    lines += [f"wrote {files.label(place)}" for place in written]
    for line in lines:
        console.print(line, soft_wrap=True)

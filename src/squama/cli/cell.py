"""squama cell: one pitch of finite elements, from a beam file."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from squama.cli.options import Options, Problems, check_outputs, flag, read_number, read_overrides
from squama.interrupt import Interrupted

if TYPE_CHECKING:
    import xarray as xr

    from squama.fe.deformed import Deformed

MOST_SCALES = 200


def cell(
    beam: str,
    /,
    *,
    to: Annotated[str, flag('Twist to reach: "5 rad/m", "0.2 rad/pitch" or "90 deg total".')],
    mu: Annotated[str | None, flag("Coefficient of friction, e.g. 0.25.")] = None,
    sense: Annotated[str, flag("Which way the beam is twisted: + or - (+).")] = "+",
    mesh: Annotated[
        str,
        flag(
            '"coarse", "medium", "fine", or sizes in the bulk and along the scale\'s edges in pitches, e.g. 0.2,0.02.'
        ),
    ] = "medium",
    increment: Annotated[str, flag("Largest increment of the twist, rad per pitch (0.01).")] = "0.01",
    scales: Annotated[str | None, flag("Number of scales of a finite beam; one endless pitch if not given.")] = None,
    ends: Annotated[
        str, flag("Along the axis the turned end of a finite beam is free or held (free); the other is fixed.")
    ] = "free",
    hinged: Annotated[bool, Parameter(help="Block roll and yaw of the scales.")] = False,
    set_: Annotated[
        tuple[str, ...],
        flag('A value in place of the file\'s, e.g. scale.alpha="30 deg"; may be repeated.', "--set"),
    ] = (),
    plot: Annotated[tuple[str, ...], flag("Picture to write: .png, .svg or .pdf; may be repeated.")] = (),
    csv: Annotated[str | None, flag("CSV file to write, units in the header.")] = None,
    netcdf: Annotated[str | None, flag("netCDF file to write (.nc).")] = None,
    vtk: Annotated[str | None, flag("File of the deformed pitch for ParaView and the like (.vtu).")] = None,
    picture: Annotated[
        tuple[str, ...], flag("Picture of the deformed pitch with its strain: .png, .svg or .pdf; may be repeated.")
    ] = (),
    restart: Annotated[
        str | None,
        flag("File written after every increment; where it is there, the run goes on from it."),
    ] = None,
    json: Annotated[bool, Parameter(help="Print everything as JSON instead of the summary.")] = False,
    quiet: Annotated[bool, Parameter(help="No lines of progress.")] = False,
) -> int:
    """Twist one pitch of finite elements with helical periodicity, or a finite beam; needs the extra fe.

    Parameters
    ----------
    beam
        Beam file (TOML); "squama new beam.toml" writes an example.
    """
    from squama import files, store
    from squama.cli import run
    from squama.cli.row import read_scales, read_sense, read_twist

    problems = Problems()
    arguments: dict[str, Any] = {"sense": sense, "hinged": hinged, "mesh": mesh, "restart": restart}
    overrides: dict[str, dict[str, Any]] = {}
    with problems.caught():
        overrides = read_overrides(set_)
    with problems.caught():
        if mu is not None:
            overrides.setdefault("friction", {})["mu"] = read_number("--mu", mu, 0.0, 10.0, "0 to 10", "0.25")
    with problems.caught():
        arguments["increment"] = read_number("--increment", increment, 1e-5, 0.1, "0.00001 to 0.1", "0.01")
    with problems.caught():
        arguments["mesh"] = read_mesh(mesh)
    with problems.caught():
        read_sense(sense)
    problems.lines += check_outputs(Options(plot=(*plot, *picture), csv=csv, netcdf=netcdf), [beam])
    with problems.caught():
        if vtk is not None:
            store.check_place(vtk, (".vtu",))
    if scales is not None:
        with problems.caught():
            arguments["scales"] = read_scales(scales, MOST_SCALES)
        arguments["ends"] = ends
        if ends not in ("free", "held"):
            problems.lines.append(f'--ends = "{ends}": must be free or held')
        if vtk is not None or picture:
            problems.lines.append("--vtk and --picture show one endless pitch: leave them out, or leave out --scales")
    elif ends != "free":
        problems.lines.append("--ends: is for finite beams; give --scales too")
    described = None
    with problems.caught():
        described = run.read_beam(beam, overrides)
    if described is not None:
        if "scales" in arguments:
            described = described.replace(scales=arguments["scales"])
        with problems.caught():
            arguments["to"] = read_twist("--to", to, described)
        if described.friction.mu is None:
            problems.lines.append(
                f"{files.label(beam)}: friction.mu: is missing; write mu = 0.25 under [friction] or give --mu 0.25"
            )
    problems.settle()
    assert described is not None

    from squama.cli import finite
    from squama.fe import facade, facade_beam

    told = None if quiet else facade.print_progress
    states: list[Deformed] = []
    if vtk is not None or picture:
        arguments["last"] = states.append
    try:
        if scales is None:
            data = facade.cell(described, progress=told, **arguments)
        else:
            said = None if quiet else finite.announce
            data = facade_beam.beam(described, progress=told, announce=said, **arguments)
    except Interrupted as stop:
        kept = f"; {files.label(restart)} holds what is done" if restart else ""
        print(f"squama: {files.label(beam)}: {stop}{kept}", file=sys.stderr)
        return 130
    written = (write if scales is None else finite.write)(data, plot, csv, netcdf)
    for state in states:
        written += _write_state(state, vtk, picture)
    if json:
        _record(files.label(beam), data, written)
    else:
        (show if scales is None else finite.show)(files.label(beam), data, written)
    return 0


def read_mesh(text: str, name: str = "--mesh") -> str | tuple[float, float]:
    """Return the name of a mesh, or its two sizes.

    Raises
    ------
    InputError
        It is neither.
    """
    from squama.errors import InputError
    from squama.fe.facade import MESHES

    if text in MESHES:
        return text
    parts = text.split(",")
    if len(parts) != 2:
        message = f'{name} = "{text}": must be {", ".join(MESHES)}, or two sizes in pitches such as 0.2,0.02'
        raise InputError(message)
    bulk, edge = (read_number(name, part, 1e-4, 10.0, "0.0001 to 10", "0.2,0.02") for part in parts)
    return bulk, edge


def write(data: xr.Dataset, plot: tuple[str, ...], csv: str | None, netcdf: str | None) -> list[Path]:
    """Write pictures and files; return their places."""
    from squama import store

    written: list[Path] = []
    if plot:
        from squama import plot as figures

        figure = figures.elements_figure(data)
        written += [figures.save_figure(figure, path) for path in plot]
    written += [store.save(data, path) for path in (csv, netcdf) if path is not None]
    return written


def _write_state(state: Deformed, vtk: str | None, picture: tuple[str, ...]) -> list[Path]:
    """Write the deformed pitch; return the places."""
    written: list[Path] = []
    if vtk is not None:
        from squama.fe.vtk import write_vtu

        written.append(write_vtu(state, vtk))
    if picture:
        from squama import plot as figures

        figure = figures.deformed_figure(state)
        written += [figures.save_figure(figure, path) for path in picture]
    return written


def _record(file: str, data: xr.Dataset, written: list[Path]) -> None:
    from squama.cli import record

    record.show(
        {
            "file": file,
            **{key: value for key, value in data.attrs.items() if key not in ("beam", "warnings")},
            "mu": float(data["mu"]),
            "curve": {str(name): v.values for name, v in data.data_vars.items()},
            "units": {str(name): v.attrs.get("units", "") for name, v in data.data_vars.items()},
            "written": [str(path) for path in written],
        }
    )


def show(file: str, data: xr.Dataset, written: list[Path]) -> None:
    """Print the summary of a run."""
    import math

    from rich.console import Console

    from squama import files
    from squama.cli.summary import moment, number

    console = Console(highlight=False, markup=False, emoji=False)
    last = data.isel(point=-1)
    blocked = "roll and yaw blocked, " if "blocked" in data.attrs["joint"] else ""
    lines = [
        f"{data.attrs['sentence']}",
        f"phi = {number(float(last['phi']), 'rad/pitch')}, Phi = {number(float(last['Phi']), 'rad/m')}",
        f"torque T = {moment(float(last['T']))}, "
        f"inclination theta = {number(math.degrees(float(last['theta'])), 'deg')}",
        f"normal force N = {number(float(last['N']), 'N')}, friction force f = {number(float(last['f']), 'N')}",
        f"energy balance: (W - U_el - W_fr)/W = {data.attrs['energy_error']:.2e}",
    ]
    before = ""
    for phi, words in zip(data["phi"].values, data["contact"].values, strict=True):
        if words != before:
            lines.append(f"from phi = {phi:.4g}: {words or 'no contact'}")
            before = words
    lines += [f"wrote {files.label(place)}" for place in written]
    console.print(
        f"{file} by finite elements: mu = {float(data['mu']):g}, sense {data.attrs['sense']}, {blocked}"
        f"{data.attrs['mesh']}",
        style="bold",
        soft_wrap=True,
    )
    for line in lines:
        console.print(line, soft_wrap=True)

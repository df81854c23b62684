"""squama verify: a beam by every model, beside finite elements."""

from __future__ import annotations

import math
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from squama.cli.options import Problems, flag, read_number, read_overrides
from squama.interrupt import Interrupted

if TYPE_CHECKING:
    import xarray as xr
    from rich.table import Table

    from squama.study.verify import Verified

ROWS = 12
"""Twists in the printed table."""


def verify(
    beam: str,
    /,
    *,
    mu: Annotated[str | None, flag("Coefficient of friction, e.g. 0.25.")] = None,
    to: Annotated[
        str | None,
        flag(
            'Twist to reach: "5 rad/m", "0.2 rad/pitch" or "90 deg total" (where the hinge\'s curve is cut off, '
            "0.3 rad/pitch at most)."
        ),
    ] = None,
    sense: Annotated[str, flag("Which way the beam is twisted: + or - (+).")] = "+",
    mesh: Annotated[
        str,
        flag(
            '"coarse", "medium", "fine", or sizes in the bulk and along the scale\'s edges in pitches, e.g. 0.2,0.02.'
        ),
    ] = "medium",
    increment: Annotated[str, flag("Largest increment of the twist, rad per pitch (0.01).")] = "0.01",
    hinged: Annotated[bool, Parameter(help="Block roll and yaw of the elements' scales.")] = False,
    scales: Annotated[str | None, flag("Run a finite beam of so many scales too, 2 to 200.")] = None,
    beam_mesh: Annotated[str, flag("Mesh of the finite beam (coarse).")] = "coarse",
    set_: Annotated[
        tuple[str, ...],
        flag('A value in place of the file\'s, e.g. scale.alpha="30 deg"; may be repeated.', "--set"),
    ] = (),
    out: Annotated[
        str | None,
        Parameter(
            name=("--out", "-o"), help="Folder to write to (verify_ and the file's name).", allow_leading_hyphen=True
        ),
    ] = None,
    json: Annotated[bool, Parameter(help="Print everything as JSON instead of the summary.")] = False,
    quiet: Annotated[bool, Parameter(help="No lines of progress.")] = False,
) -> int:
    """Set the hinge, the compliant joint and finite beams beside finite elements; needs the extra fe.

    The folder holds the table (CSV), the picture and the elements' run; the same command goes on where it was stopped.

    Parameters
    ----------
    beam
        Beam file (TOML); "squama new beam.toml" writes an example.
    """
    from squama import files
    from squama.cli import run
    from squama.cli.cell import read_mesh
    from squama.cli.row import read_scales, read_sense, read_twist

    problems = Problems()
    arguments: dict[str, Any] = {"sense": sense, "hinged": hinged}
    overrides: dict[str, dict[str, Any]] = {}
    with problems.caught():
        overrides = read_overrides(set_)
    with problems.caught():
        if mu is not None:
            overrides.setdefault("friction", {})["mu"] = read_number("--mu", mu, 0.0, 10.0, "0 to 10", "0.25")
    with problems.caught():
        arguments["increment"] = read_number("--increment", increment, 1e-5, 0.1, "0.00001 to 0.1", "0.01")
    for name, text in (("mesh", mesh), ("beam_mesh", beam_mesh)):
        with problems.caught():
            arguments[name] = read_mesh(text, "--" + name.replace("_", "-"))
    with problems.caught():
        arguments["scales"] = read_scales(scales, 200)
    with problems.caught():
        read_sense(sense)
    described = None
    with problems.caught():
        described = run.read_beam(beam, overrides)
    if described is not None:
        with problems.caught():
            if to is not None:
                arguments["to"] = read_twist("--to", to, described)
        if described.friction.mu is None:
            problems.lines.append(
                f"{files.label(beam)}: friction.mu: is missing; write mu = 0.25 under [friction] or give --mu 0.25"
            )
    folder = Path(f"verify_{Path(beam).stem}" if out is None else out)
    problems.settle()
    assert described is not None

    from squama.fe.facade import print_progress
    from squama.study import verify as study

    files.make_folder(folder)
    try:
        found = study.verify(
            described,
            folder,
            progress=None if quiet else print_progress,
            announce=None if quiet else lambda words: print(words, file=sys.stderr, flush=True),
            **arguments,
        )
    except Interrupted as stop:
        print(f"squama: {files.label(beam)}: {stop}; {files.label(folder)} holds what is done", file=sys.stderr)
        return 130
    if json:
        _record(files.label(beam), found)
    else:
        _show(files.label(beam), found)
    return 0


def _record(file: str, found: Verified) -> None:
    from squama.cli import record

    table = found.table
    each = ("words", "within", "last", "dT_last", "dtheta_last", "T", "theta", "dT", "dtheta")
    record.show(
        {
            "file": file,
            "title": table.attrs["title"],
            "elements": {key: found.elements.attrs[key] for key in ("mesh", "sentence", "reached", "energy_error")},
            "share": table.attrs["share"],
            "curve": {str(name): table[name].values for name in ("phi", "T_elements", "theta_elements")},
            "models": {
                str(name): {key: table[key].sel(model=name).values for key in each} for name in table["model"].values
            },
            "units": {str(name): v.attrs.get("units", "") for name, v in table.variables.items() if name != "model"},
            "written": [str(path) for path in found.written],
        }
    )


def _show(file: str, found: Verified) -> None:
    """Print the table of differences, and how far each model holds."""
    from rich.console import Console

    from squama import files

    data, console = found.table, Console(highlight=False, markup=False, emoji=False)
    # the table's lines wrap on a narrow terminal rather than lose digits
    console = Console(highlight=False, markup=False, emoji=False, width=max(console.width, 100))
    attrs = found.elements.attrs
    console.print(f"{file}: {data.attrs['title']}", style="bold", soft_wrap=True)
    console.print(f"elements: {attrs['mesh']}; {attrs['sentence']}", soft_wrap=True)
    console.print(f"energy balance: (W - U_el - W_fr)/W = {attrs['energy_error']:.2e}", soft_wrap=True)
    console.print()
    for name, factor, words in (
        ("dT", 100.0, "torque over the elements', less 1 (%)"),
        ("dtheta", math.degrees(1.0), "inclination less the elements' (deg)"),
    ):
        console.print(words, style="bold", soft_wrap=True)
        console.print(_table(data, name, factor))
        console.print()
    for line in [*ranges(data), *finite(data)]:
        console.print(line, soft_wrap=True)
    for line in filter(None, data.attrs["warnings"].splitlines()):
        console.print(f"warning: {line}", soft_wrap=True)
    for path in found.written:
        console.print(f"wrote {files.label(path)}", soft_wrap=True)


def _table(data: xr.Dataset, name: str, factor: float) -> Table:
    """Return the differences of all models at some twists, beside the elements' own value."""
    import numpy as np
    from rich.table import Table

    table = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0))
    own, unit, scale = ("T_elements", "N m", 1.0) if name == "dT" else ("theta_elements", "deg", math.degrees(1.0))
    models = [str(model) for model in data["model"].values]
    for column in ("phi", f"elements ({unit})", *models):
        table.add_column(column, justify="right", no_wrap=True)
    phi = data["phi"].values
    for i in np.unique(np.linspace(0, phi.size - 1, ROWS + 1).round().astype(int))[1:]:
        at = data.isel(point=int(i))
        cells = [factor * float(at[name].sel(model=model)) for model in models]
        texts = ["-" if math.isnan(cell) else f"{cell:+.{2 if abs(cell) < 99 else 0}f}" for cell in cells]
        table.add_row(f"{phi[i]:.4g}", f"{scale * float(at[own]):.4g}", *texts)
    return table


def ranges(data: xr.Dataset) -> list[str]:
    """Return a line per model of the endless beam: how far it holds, and by how much it is off at the end."""
    from squama.fe.compare import FINITE

    lines, share = [], float(data.attrs["share"])
    for name in data["model"].values:
        if name in FINITE:
            continue
        one = data.sel(model=name)
        within, last, off = (float(one[key]) for key in ("within", "last", "dT_last"))
        words = f"{name} ({one['words'].item()})"
        if math.isnan(within):
            lines.append(f"{words}: has no twist in common with the elements")
        elif within >= last:
            lines.append(f"{words}: within {share:.0%} in torque as far as both go, {last:.4g} rad/pitch")
        else:
            angle = math.degrees(float(one["dtheta_last"]))
            holds = f"within {share:.0%} in torque up to {within:.4g} rad/pitch"
            holds = holds if within else f"more than {share:.0%} off in torque from the start"
            size = f"{100 * off:+.1f} %" if abs(off) < 1 else f"{1 + off:.3g} times"
            lines.append(f"{words}: {holds}; at {last:.4g} {size}, theta {angle:+.2f} deg")
    return lines


def finite(data: xr.Dataset) -> list[str]:
    """Return what there is to say of finite beams: the elements' beside the endless one, the row beside the elements'.

    An endless beam says nothing on how good a short one is, so the row of hinges is held to the elements' beam.
    """
    import numpy as np

    if "beam" not in data["model"].values:
        return []
    beam, row = data.sel(model="beam"), data.sel(model="row")
    lines = []
    for one, other, words in (
        (beam, None, f"{beam['words'].item()}: beside the endless one"),
        (row, beam, f"{row['words'].item()}: beside the finite beam"),
    ):
        T, theta = (data["T_elements"], data["theta_elements"]) if other is None else (other["T"], other["theta"])
        both = np.flatnonzero(np.isfinite(one["T"].values) & np.isfinite(T.values) & (data["phi"].values > 0))
        if not both.size:
            lines.append(f"{words} there is no twist that both have")
            continue
        off = [100 * float(one["T"][i] / T[i] - 1) for i in both]
        angle = math.degrees(float(one["theta"][both[-1]] - theta[both[-1]]))
        first, last = (float(data["phi"][i]) for i in (both[0], both[-1]))
        lines.append(
            f"{words} the torque is {off[0]:+.3g} % at {first:.4g} rad/pitch and {off[-1]:+.3g} % at {last:.4g}, "
            f"theta {angle:+.2f} deg there"
        )
    return lines

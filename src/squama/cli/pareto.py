"""squama pareto: trade-offs between figures of beams, from a target file."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from squama.cli.options import Options, Problems, check_outputs, flag, read_overrides

if TYPE_CHECKING:
    import xarray as xr

    from squama.design import Beam

SHOWN = 12
"""Designs in the table of the summary at most."""


def pareto(
    target: str,
    /,
    *,
    out: Annotated[
        str | None,
        Parameter(name=("--out", "-o"), help="Folder for design_1.toml, design_2.toml ...", allow_leading_hyphen=True),
    ] = None,
    pick: Annotated[str | None, flag("Which designs -o writes, e.g. 1,40,200 (all).")] = None,
    force: Annotated[bool, Parameter(help="Replace designs that are in the folder.")] = False,
    population: Annotated[
        str | None, flag("Designs of a generation, and of the front at most (the file's, or 200).")
    ] = None,
    generations: Annotated[str | None, flag("Generations (the file's, or 100).")] = None,
    seed: Annotated[str | None, flag("Seed of the search (the file's, or 1).")] = None,
    set_: Annotated[
        tuple[str, ...],
        flag("A value in place of the starting beam's, e.g. friction.mu=0.3; may be repeated.", "--set"),
    ] = (),
    plot: Annotated[tuple[str, ...], flag("Picture to write: .png, .svg or .pdf; may be repeated.")] = (),
    csv: Annotated[str | None, flag("CSV file to write: a row per design, units in the header.")] = None,
    netcdf: Annotated[str | None, flag("netCDF file to write (.nc).")] = None,
    json: Annotated[bool, Parameter(help="Print everything as JSON instead of the summary.")] = False,
) -> int:
    """Trade figures of beams off against each other: a Pareto front, each point a beam that can be built (extra fit).

    Parameters
    ----------
    target
        Target file (TOML) with a table [front]; see docs, how-to: design a beam.
    """
    from squama import files
    from squama.cli import folder
    from squama.cli.design import whole
    from squama.inverse import front as inverse
    from squama.inverse.target import read_target

    problems = Problems()
    numbers: dict[str, int] = {}
    overrides: dict[str, dict[str, Any]] = {}
    for name, text, low, high, example in (
        ("population", population, 8, 10_000, "200"),
        ("generations", generations, 1, 100_000, "100"),
        ("seed", seed, 0, 2**31 - 1, "1"),
    ):
        with problems.caught():
            if text is not None:
                numbers[name] = whole(f"--{name}", text, low, high, example)
    picked: list[int] | None = None
    with problems.caught():
        if pick is not None:
            picked = [whole("--pick", part, 1, 100_000, "1,40,200") for part in pick.split(",")]
            if out is None:
                problems.lines.append("--pick: says which designs -o writes; give -o too")
    with problems.caught():
        overrides = read_overrides(set_)
    problems.lines += check_outputs(Options(plot=plot, csv=csv, netcdf=netcdf), [target])
    with problems.caught():
        if out is not None:
            folder.check(out, force=force)
    read = None
    with problems.caught():
        read = read_target(target, need="front", overrides=overrides)
    problems.settle()
    assert read is not None

    found = inverse.trade(read, **numbers)
    many = found.sizes["design"]
    written: list[Path] = []
    if out is not None:
        wanted = [i for i in dict.fromkeys(picked or range(1, many + 1)) if i <= many]
        if far := [str(i) for i in picked or () if i > many]:
            print(f"squama: warning: --pick: the front has {many} designs, no {', '.join(far)}", file=sys.stderr)
        every = inverse.beams(found)
        texts = [_text(files.label(target), found, every[i - 1], i) for i in wanted]
        written += folder.write(out, texts, wanted)
    written += _write(found, plot, csv, netcdf)
    if json:
        _record(files.label(target), found, written)
    else:
        _show(files.label(target), found, written, out)
    return 0


def _text(file: str, front: xr.Dataset, beam: Beam, number: int) -> str:
    one = front.sel(design=number)
    values = [f"{name} = {float(one[name]):.6g} {one[name].attrs['units']}" for name in _objectives(front)]
    return f"# design {number} of {front.sizes['design']} on the front of {file}: {', '.join(values)}\n{beam.to_toml()}"


def _objectives(front: xr.Dataset) -> list[str]:
    return [str(name) for name, v in front.data_vars.items() if "objective" in v.attrs]


def _write(front: xr.Dataset, plot: tuple[str, ...], csv: str | None, netcdf: str | None) -> list[Path]:
    from squama import store

    written: list[Path] = []
    if plot:
        from squama import plot as figures

        figure = figures.front_figure(front)
        written += [figures.save_figure(figure, path) for path in plot]
    return [*written, *(store.save(front, path) for path in (csv, netcdf) if path is not None)]


def _record(file: str, front: xr.Dataset, written: list[Path]) -> None:
    from squama.cli import record

    record.show(
        {
            "file": file,
            **front.attrs,
            "designs": {str(name): v.values for name, v in front.data_vars.items()},
            "units": {str(name): v.attrs.get("units", "") for name, v in front.data_vars.items()},
            "written": [str(path) for path in written],
        }
    )


def _show(file: str, front: xr.Dataset, written: list[Path], out: str | None) -> None:
    """Print a choice of the front, evenly along its first objective."""
    import numpy as np
    from rich.console import Console
    from rich.table import Table

    from squama import files
    from squama.cli.design import _unit

    console = Console(highlight=False, markup=False, emoji=False)
    console = Console(highlight=False, markup=False, emoji=False, width=max(console.width, 100))
    n, names = front.sizes["design"], _objectives(front)
    console.print(f"{file}: {n} designs on the front of {', '.join(front.attrs['objectives'])}", style="bold")
    dimensions = [str(name) for name in front.data_vars if "." in str(name)]
    table = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0))
    units = [(1.0, str(front[name].attrs["units"])) for name in names] + [_unit(name) for name in dimensions]
    heads = [
        f"{name.replace('.', '.' + chr(10))} {unit}".strip()
        for name, (_, unit) in zip([*names, *dimensions], units, strict=True)
    ]
    for name in ("design", *heads):
        table.add_column(name, header_style="bold", justify="right")
    for i in np.unique(np.linspace(0, n - 1, min(n, SHOWN)).round().astype(int)):
        values = [
            f"{factor * front[name].values[i]:.4g}"
            for name, (factor, _) in zip([*names, *dimensions], units, strict=True)
        ]
        table.add_row(str(front.design.values[i]), *values)
    console.print(table)
    lines = [f"{name}: {front[name].attrs['long_name']}" + _at(front, name) for name in names]
    if out is not None:
        wrote = [p for p in written if p.suffix == ".toml"]
        lines.append(f"wrote {len(wrote)} beam files into {files.label(out)}")
    lines += [f"wrote {files.label(p)}" for p in written if p.suffix != ".toml"]
    for line in lines:
        console.print(line, soft_wrap=True)


def _at(front: xr.Dataset, name: str) -> str:
    return f" ({front[name].attrs['at']})" if "at" in front[name].attrs else ""

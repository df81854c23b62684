"""squama uncertainty: what the tolerances of a beam do to it, by Monte Carlo."""

from __future__ import annotations

import tomllib
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from squama.cli.options import Options, Problems, check_outputs, flag, read_number, read_overrides
from squama.errors import InputError

if TYPE_CHECKING:
    import xarray as xr

    from squama.design import Beam
    from squama.study.uncertainty import Uncertain


def uncertainty(
    beam: str,
    /,
    *,
    vary: Annotated[
        tuple[str, ...],
        flag('A tolerance: scale.alpha="60 deg +- 1 deg" (limits), mu="normal(0.25, 0.03)"; may be repeated.'),
    ] = (),
    tolerances: Annotated[
        str | None, flag("TOML file with tolerances under [tolerance]; --vary goes before it.")
    ] = None,
    before: Annotated[str | None, flag('Probability of locking before this twist, e.g. "120 deg total".')] = None,
    samples: Annotated[str, flag("Number of beams at least (131072).")] = "131072",
    sampler: Annotated[str, flag("sobol (scrambled Sobol points) or random (PCG64) (sobol).")] = "sobol",
    seed: Annotated[str, flag("Seed of the samples (0).")] = "0",
    indices: Annotated[
        str, flag("Base number of Sobol indices, a power of two such as 4096; 0 for none (0); extra fit.")
    ] = "0",
    load: Annotated[str, flag("twisting or bending (twisting).")] = "twisting",
    law: Annotated[str, flag("Force law: edge (satisfies virtual work) or plate (the paper's).")] = "edge",
    sense: Annotated[str, flag("Which way the beam is twisted: + or - (+).")] = "+",
    mu: Annotated[str | None, flag("Coefficient of friction in place of the file's, e.g. 0.25.")] = None,
    margin: Annotated[
        str, flag("Where a curve that locks is cut off: fraction of its path left before the lock (0.01).")
    ] = "0.01",
    set_: Annotated[
        tuple[str, ...],
        flag('A value in place of the file\'s, e.g. scale.alpha="30 deg"; may be repeated.', "--set"),
    ] = (),
    plot: Annotated[tuple[str, ...], flag("Picture to write: .png, .svg or .pdf; may be repeated.")] = (),
    csv: Annotated[str | None, flag("CSV file to write: a row per sample, units in the header.")] = None,
    netcdf: Annotated[str | None, flag("netCDF file to write (.nc): statistics and samples.")] = None,
    json: Annotated[bool, Parameter(help="Print everything but the samples as JSON instead of the summary.")] = False,
) -> int:
    """Say what tolerances and friction do to engagement, end, torque and dissipation: Monte Carlo, Sobol indices.

    Parameters
    ----------
    beam
        Beam file (TOML); "squama new beam.toml" writes an example.
    """
    from squama import checks, files
    from squama.cli import run
    from squama.study import uncertainty_indices
    from squama.study.uncertainty_samples import MOST, SAMPLERS

    problems = Problems()
    arguments: dict[str, Any] = {}
    overrides: dict[str, dict[str, Any]] = {}
    with problems.caught():
        arguments["margin"] = read_number("--margin", margin, 1e-12, 1 - 1e-12, "at least 1e-12, below 1", "0.01")
    wholes = (
        ("samples", samples, 3200, MOST, "131072"),
        ("seed", seed, 0, 2**31, "7"),
        ("indices", indices, 0, 2**20, "4096"),
    )
    for name, text, low, high, example in wholes:
        with problems.caught():
            arguments[name] = _whole(f"--{name}", text, low, high, example)
    with problems.caught():
        if base := arguments.get("indices"):
            if base < 64 or base & (base - 1):
                problems.lines.append(f"--indices = {base}: is no power of two from 64 on; write e.g. 4096")
            uncertainty_indices.needed()
    words = (
        ("law", law, ("edge", "plate")),
        ("load", load, ("twisting", "bending")),
        ("sense", sense, ("+", "-")),
        ("sampler", sampler, SAMPLERS),
    )
    for name, value, allowed in words:
        with problems.caught():
            arguments[name] = checks.one_of(f"--{name}", value, allowed)
    with problems.caught():
        overrides = read_overrides(set_)
    with problems.caught():
        if mu is not None:
            overrides.setdefault("friction", {})["mu"] = read_number("--mu", mu, 0.0, 10.0, "0 to 10", "0.25")
    read = [beam, *([tolerances] if tolerances else [])]
    problems.lines += check_outputs(Options(plot=plot, csv=csv, netcdf=netcdf), read)
    described: Beam | None = None
    with problems.caught():
        described = run.read_beam(beam, overrides)
    given: dict[str, Any] = {}
    if described is not None:
        with problems.caught():
            given = _tolerances(vary, tolerances, described)
        if described.friction.mu is None and "friction.mu" not in given and not problems.lines:
            problems.lines.append(
                f"{files.label(beam)}: friction.mu: is missing; write mu = 0.25 under [friction] or give --mu 0.25"
            )
    if before is not None and described is not None:
        with problems.caught():
            _before(before, described, load)
    problems.settle()
    assert described is not None

    from squama.study.uncertainty import uncertain

    found = uncertain(described, given, before=before, keep=bool(csv or netcdf), bare=False, **arguments)
    written = _write(found, plot, csv, netcdf)
    from squama.cli import uncertainty_summary as report

    (report.record if json else report.show)(files.label(beam), found, written)
    return 0


def _whole(name: str, text: str, low: int, high: int, example: str) -> int:
    value = read_number(name, text, low, high, f"{low} to {high}", example)
    if value != int(value):
        message = f"{name} = {text}: is not a whole number; write e.g. {example}"
        raise InputError(message)
    return int(value)


def _before(text: str, beam: Beam, load: str) -> None:
    from squama import units

    read = units.twist if load == "twisting" else units.curvature
    try:
        rate = read(text, pitch=beam.pitch, scales=beam.scales, bare=False)
    except units.QuantityError as error:
        message = f"--before = {error.shown}: {error.reason}"
        raise InputError(message) from None
    if rate <= 0:
        message = f'--before = {units.shown(text)}: must be more than 0; write e.g. "120 deg total"'
        raise InputError(message)


def _tolerances(vary: Iterable[str], path: str | None, beam: Beam) -> dict[str, Any]:
    """Return the tolerances of the flags and of the file, by the names of the beam file; every mistake is told."""
    from squama.files import label
    from squama.study.uncertainty_tolerances import tolerances
    from squama.units import shown

    problems = Problems()
    flags: dict[str, Any] = {}
    for text in vary:
        name, equals, value = text.partition("=")
        name, value = name.strip(), value.strip().strip('"')
        if not (equals and name and value):
            problems.lines.append(
                f'--vary {shown(text)}: is not name=tolerance; write e.g. --vary scale.alpha="60 deg +- 1 deg"'
            )
        elif name in flags:
            problems.lines.append(f"--vary {name}: is given twice; give each tolerance once")
        else:
            flags[name] = value
    with problems.caught():
        table = {} if path is None else _table(path)
    found: dict[str, Any] = {}
    groups: list[tuple[str, Mapping[str, Any]]] = [(f"{label(path)}: ", table)] if path and not problems.lines else []
    for where, group in [*groups, ("--vary ", flags)]:
        if not group:
            continue
        try:
            read = tolerances(group, beam, bare=False)
        except InputError as error:
            problems.lines += [f"{where}{line}" for line in str(error).splitlines()]
        else:
            # a distribution in SI units reads back as itself
            found |= {t.name: (t.kind, *t.numbers) for t in read}
    if not flags and not path and not problems.lines:
        problems.lines.append('--vary: no tolerance is given; write e.g. --vary scale.alpha="60 deg +- 1 deg"')
    problems.settle()
    return found


def _table(path: str) -> dict[str, Any]:
    """Return the table [tolerance] of a file."""
    from squama import files

    name = files.label(path)
    text = files.read_text(path, missing='write one with [tolerance] and e.g. mu = "normal(0.25, 0.03)"')
    try:
        tables = tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        message = f'{name}: is not TOML: {error}; write e.g. mu = "normal(0.25, 0.03)" under [tolerance]'
        raise InputError(message) from None
    found = tables.pop("tolerance", None)
    if tables or not isinstance(found, dict) or not found:
        what = f"holds {', '.join(tables)} too" if tables else "has no tolerances"
        message = f'{name}: {what}; write [tolerance] and under it lines such as scale.alpha = "60 deg +- 1 deg"'
        raise InputError(message)
    return found


def _write(found: Uncertain, plot: tuple[str, ...], csv: str | None, netcdf: str | None) -> list[Path]:
    written: list[Path] = []
    if not (plot or csv or netcdf):
        return written
    from squama import store

    dataset = found.dataset()
    if plot:
        from squama import plot as figures

        figure = figures.uncertainty_figure(dataset)
        written += [figures.save_figure(figure, path) for path in plot]
    if csv is not None:
        written.append(store.save(flat(dataset), csv))
    if netcdf is not None:
        written.append(store.save(dataset, netcdf))
    return written


def flat(dataset: xr.Dataset) -> xr.Dataset:
    """Return the samples alone, a row each."""
    names = [name for name, v in dataset.variables.items() if v.dims == ("sample",)]
    return dataset[names].drop_vars([name for name in dataset[names].coords if name not in names])

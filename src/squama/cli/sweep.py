"""squama sweep: a beam over ranges of parameters, into a store that can be resumed."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

from squama.cli.options import Problems, flag, read_number, read_overrides
from squama.errors import InputError
from squama.interrupt import Interrupted


def sweep(
    beam: str,
    /,
    *,
    over: Annotated[
        tuple[str, ...],
        flag("Parameter and its values: mu=0:2:401, alpha=15deg:75deg:601, margin=0.001,0.01,0.1; may be repeated."),
    ] = (),
    out: Annotated[
        str, Parameter(name=("--out", "-o"), help="Store to write or to go on with (.zarr).", allow_leading_hyphen=True)
    ],
    load: Annotated[str, flag("twisting or bending (twisting).")] = "twisting",
    law: Annotated[str, flag("Force law: edge, plate, or edge,plate for both (edge).")] = "edge",
    sense: Annotated[str, flag("Which way the beam is twisted: + or - (+).")] = "+",
    mu: Annotated[str | None, flag("Coefficient of friction, if it is not swept.")] = None,
    margin: Annotated[
        str, flag("Where a curve that locks is cut off: fraction of its path left before the lock (0.01).")
    ] = "0.01",
    set_: Annotated[
        tuple[str, ...],
        flag('A value in place of the file\'s, e.g. scale.alpha="30 deg"; may be repeated.', "--set"),
    ] = (),
    tile: Annotated[str | None, flag("Largest number of cells solved and written at once.")] = None,
    shard: Annotated[str | None, flag("Only a share of the tiles, for job arrays: 1/4 to 4/4.")] = None,
    dask: Annotated[str | None, flag("Solve on dask.distributed: local:2 or tcp://host:8786.")] = None,
    engine: Annotated[str, flag("Engine that solves the cells (auto).")] = "auto",
    progress: Annotated[str | None, flag("bar, json or none; on standard error (bar on a terminal).")] = None,
    json: Annotated[bool, Parameter(help="Print the result as JSON.")] = False,
) -> int:
    """Solve a beam over ranges of parameters, into a store that can be resumed.

    Parameters
    ----------
    beam
        Beam file (TOML); "squama new beam.toml" writes an example.
    """
    from squama import files
    from squama.study import cluster
    from squama.study import progress as listeners
    from squama.study import sweep as study

    problems = Problems()
    ranges: dict[str, str] = {}
    options: dict[str, Any] = {"load": load, "sense": sense, "engine": engine}
    options["law"] = tuple(part.strip() for part in law.split(",")) if "," in law else law
    overrides: dict[str, dict[str, Any]] = {}
    with problems.caught():
        ranges = _ranges(over)
    with problems.caught():
        options["margin"] = read_number("--margin", margin, 1e-12, 1 - 1e-12, "at least 1e-12, below 1", "0.01")
    with problems.caught():
        options["tile"] = None if tile is None else _tile(tile)
    with problems.caught():
        overrides = read_overrides(set_)
    with problems.caught():
        if mu is not None:
            overrides.setdefault("friction", {})["mu"] = read_number("--mu", mu, 0.0, 10.0, "0 to 10", "0.25")
            if {"mu", "friction.mu"} & set(ranges):
                message = "--mu: mu is swept too; keep one of --mu and --over mu"
                raise InputError(message)
    if not out.strip():
        problems.lines.append("--out: is empty; write e.g. map.zarr")
    chosen = progress or ("bar" if sys.stderr.isatty() else "none")
    for check in (
        lambda: listeners.known(chosen),
        lambda: study.read_shard(shard),
        lambda: cluster.check(dask or "local:1"),
    ):
        before = len(problems.lines)
        with problems.caught():
            check()
        problems.lines[before:] = [f"--{line}" for line in problems.lines[before:]]
    problems.settle()

    from squama.cli import run

    described = run.read_beam(beam, overrides)
    try:
        plan = study.make_plan(described, ranges, bare=False, **options)
    except InputError as error:
        raise InputError("\n".join(_flagged(line, ranges) for line in str(error).splitlines())) from None
    name = files.label(out)
    try:
        done, tiles = study.run(plan, Path(out), shard=shard, dask=dask, progress=chosen)
    except Interrupted as stop:
        print(f"squama: {name}: {stop}", file=sys.stderr)
        return 130
    if json:
        from squama.cli import record

        record.show({"out": out, "cells": plan.cells, "tiles": tiles, "tiles_done": done, "sha256": plan.digest})
        return 0
    sides = " x ".join(f"{n} {dim}" for n, dim in zip(plan.shape, plan.dims, strict=True))
    if done == tiles:
        print(f"{name}: {plan.cells} cells ({sides}); look at it with: squama map {name} --plot map.png")
    else:
        whose = f"shard {shard} is done; " if shard else ""
        print(f"{name}: {whose}{done} of {tiles} tiles are done")
    return 0


def _ranges(over: tuple[str, ...]) -> dict[str, str]:
    """Return the ranges of --over by name as they stand."""
    from squama.study.parameters import ALIASES
    from squama.units import shown

    found: dict[str, str] = {}
    problems = []
    known: set[str] = set()
    for item in over:
        name, equals, text = (part.strip() for part in item.partition("="))
        same = ALIASES.get(name, name)
        if not (name and equals and text):
            problems.append(f"--over {shown(item)}: is not name=low:high:count; write e.g. mu=0:2:401")
        elif same in known:
            problems.append(f"--over {name}: is given twice; keep one of them")
        else:
            known.add(same)
            found[name] = text
    if not over:
        problems.append("--over: is missing; name a parameter and its range, e.g. --over mu=0:2:401")
    if problems:
        raise InputError("\n".join(problems))
    return found


def _tile(text: str) -> int:
    value = read_number("--tile", text, 1, 1e9, "1 to 1e9", "16384")
    if value != int(value):
        message = f"--tile = {text}: is not a whole number; write e.g. 16384"
        raise InputError(message)
    return int(value)


def _flagged(line: str, ranges: dict[str, str]) -> str:
    """Lay a mistake to its flag."""
    name = line.partition(":")[0].partition(" ")[0]
    if name in ranges:
        return f"--over {line}"
    flags = ("law", "load", "sense", "engine", "margin", "tile")
    return f"--{line}" if name in flags else line

"""Opening the store of a sweep: whose it is, whether it is whole, what is done, and as a labelled dataset."""

from __future__ import annotations

import json
import os
import re
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from squama import files
from squama.errors import InputError
from squama.model.solve import Array
from squama.study import create, zstore
from squama.study.plan import FORMAT, VARIABLES, Plan, differences

if TYPE_CHECKING:
    import xarray as xr


def read_plan(path: Path) -> Plan:
    """Return the plan of a store.

    Raises
    ------
    InputError
        There is no store, squama did not write it, or it is damaged.
    """
    name = files.label(path)
    if not path.exists():
        raise _no(name, "no such store; make it with: squama sweep beam.toml --over mu=0:2:401 -o map.zarr")
    foreign = "is no store that squama sweep has written; give another name"
    if not path.is_dir():
        raise _no(name, foreign)
    try:
        text = (path / "zarr.json").read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError):
        parts = {entry.name for entry in path.iterdir()}
        raise _damaged(name, "zarr.json") if {"status", "end", "RED"} <= parts else _no(name, foreign) from None
    try:
        about = json.loads(text)["attributes"]
        version = about.get(zstore.MARK)
    except (ValueError, KeyError, TypeError, AttributeError):
        ours = zstore.MARK in text
        raise _damaged(name, "zarr.json") if ours else _no(name, foreign) from None
    if version is None:
        raise _no(name, foreign)
    if version != FORMAT:
        raise _no(name, f"was written by another version of squama (layout {version}); make a new store")
    try:
        plan = Plan.from_text(about["configuration"])
        whole = plan.digest == about["configuration_sha256"] and zstore.attributes(plan) == about
    except (ValueError, KeyError, TypeError, AttributeError):
        whole = False
    if not whole:
        raise _damaged(name, "its configuration does not fit its hash")
    return plan


def check(path: Path, plan: Plan) -> Array:
    """Look at every part of a store but the data themselves; return which tiles are done, in the shape of the grid.

    Raises
    ------
    InputError
        It is damaged.
    """
    name = files.label(path)
    library = zstore.zarr()
    known = zstore.coordinates(plan)
    wanted = ("shape", "chunks", "dtype", "dimension_names")
    for key, about in zstore.arrays(plan).items():
        try:
            array = library.open_array(path / key, mode="r", zarr_format=3)
            found = (array.shape, array.chunks, str(array.dtype), array.metadata.dimension_names)
            whole = found == tuple(about[entry] for entry in wanted)
            whole = whole and (key not in known or np.array_equal(array[:], known[key][0]))
        except Exception:  # damage shows itself in zarr as errors of many kinds
            whole = False
        if not whole:
            raise _damaged(name, key)
    done = marked(path, plan)
    for variable in VARIABLES[plan.load]:
        missing = done & ~_chunks(path / variable, plan.grid)
        if missing.any():
            first = tuple(int(i) for i in np.argwhere(missing)[0])
            raise _damaged(name, f"{variable}/{zstore.key(first)} is missing")
    return done


def marked(path: Path, plan: Plan) -> Array:
    """Say of each tile whether it has the mark of a finished one."""
    return _chunks(path / zstore.STATUS, plan.grid)


def _chunks(folder: Path, grid: tuple[int, ...]) -> Array:
    """Say of each tile whether a folder holds its chunk; a byte a tile, however many names there are."""
    there = np.zeros(grid, bool)
    chunk = re.compile("c" + r"\.(\d{1,9})" * len(grid))
    with os.scandir(folder) as entries:
        for entry in entries:
            if (found := chunk.fullmatch(entry.name)) and entry.is_file():
                tile = tuple(map(int, found.groups()))
                if all(i < n for i, n in zip(tile, grid, strict=True)):
                    there[tile] = True
    return there


def prepare(path: Path, plan: Plan) -> Array:
    """Make the store of a plan, or find it to go on with; return which tiles are done.

    Raises
    ------
    InputError
        The place cannot take it; what is there is not the store of this plan. It is left as it was.
    """
    name = files.label(path)
    if path.suffix.lower() != ".zarr":
        raise _no(name or '""', "has not the extension .zarr; write e.g. map.zarr")
    if not path.exists():
        folder = path.absolute().parent
        if not folder.is_dir():
            raise _no(name, f"its folder {files.label(folder)} does not exist; make it first or give another path")
        if not zstore.writable(folder):
            raise _no(name, f"its folder {files.label(folder)} is read-only; give another path")
        create.clear(path)
        create.create(path, plan)
    stored = read_plan(path)
    if different := differences(stored, plan):
        what = "; ".join(different)
        raise _no(name, f"belongs to another sweep: {what} (stored against asked); give another name")
    done = check(path, plan)
    create.clear(path)
    if not done.all() and not all(zstore.writable(path / part) for part in (".", *VARIABLES[plan.load], zstore.STATUS)):
        raise _no(name, "is read-only; make it writable or give another path")
    return done


def open_sweep(path: str | os.PathLike[str]) -> xr.Dataset:
    """Open the store of a sweep; values are read when they are used.

    Parameters
    ----------
    path : path
        The store, finished or not.

    Returns
    -------
    xarray.Dataset
        As from :func:`squama.sweep`.

    Raises
    ------
    InputError
        There is no store, squama did not write it, or it is damaged.
    """
    place = Path(path)
    plan = read_plan(place)
    check(place, plan)
    import xarray as xr

    found: Any = xr.open_zarr(place, consolidated=False, zarr_format=3, chunks=None)
    # in the order of the plan: that of a folder is any
    coords = {dim: found.variables[dim] for dim in plan.dims}
    if "law" in coords:
        coords["law"] = xr.Variable("law", list(plan.laws), {"long_name": "force law"})
    data = {name: found.variables[name] for name in (*VARIABLES[plan.load], zstore.STATUS)}
    return xr.Dataset(data, coords, found.attrs)


def _no(name: str, problem: str) -> InputError:
    return InputError(f"{name}: {problem}")


def _damaged(name: str, what: str) -> InputError:
    return InputError(f"{name}: is damaged ({what}); remove it and run the sweep again")

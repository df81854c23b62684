"""The store of a sweep: a zarr group (format 3) of labelled arrays, a chunk per tile, and a mark per finished tile.

A store is made in a hidden folder beside its place and moved there when it is whole. zarr writes each chunk beside its
place and moves it there; the mark of a tile (its chunk of ``status``) comes last, when the disk has all its data.
Whatever kills a run, the marks therefore name whole tiles only, and the next run overwrites or takes away whatever a
dead one left. Nothing in a store tells when or where it was written.
A writer claims a tile by a lock, so no tile has two writers on one machine or one file system with locks.
"""

from __future__ import annotations

import contextlib
import errno
import hashlib
import json
import os
import re
import secrets
import shutil
import stat
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from squama.beam.design import Beam
from squama.errors import InputError, Problem, refuse
from squama.io import files
from squama.needs import need
from squama.study.columns import matrix_warnings
from squama.study.plan import FORMAT, MARK, STATUS, VARIABLES, Plan, Tile, arrays, attributes, coordinates, differences
from squama.types import Array
from squama.units import shown

if TYPE_CHECKING:
    import xarray as xr

_WRITE_BITS = 0o222
_TRIES = 5
_PARTIAL = ".partial"
"""Ending of a chunk that zarr has not finished, and of the claim on a tile."""


class Writer:
    """Writes the tiles of one store; one per process."""

    def __init__(self, path: Path, plan: Plan) -> None:
        self.path, self.plan = path, plan
        self._arrays = {
            name: need("zarr").open_array(path / name, mode="r+", zarr_format=3, config={"write_empty_chunks": True})
            for name in (*VARIABLES[plan.load], STATUS)
        }

    @contextlib.contextmanager
    def claim(self, tile: Tile) -> Iterator[bool]:
        """Take a tile; False if it is done or another writer has it."""
        mark = self.path / STATUS / key(tile)
        claimed = mark.with_name(mark.name + _PARTIAL)
        # while any writer holds the store nobody sweeps it
        with _opened(self.path / "zarr.json") as store, _opened(claimed, os.O_RDWR | os.O_CREAT) as handle:
            _locked(store, wait=True)
            mine = _locked(handle) is not False and _same(handle, claimed)
            try:
                yield mine and not mark.exists()
            finally:
                if mine:
                    claimed.unlink(missing_ok=True)

    def write(self, tile: Tile, values: Mapping[str, Array]) -> None:
        """Write the data of a tile, then its mark; where the disk fails what was written is taken away."""
        places = [self.path / name / key(tile) for name in (STATUS, *values)]
        region = self.plan.place(tile)
        try:
            for name, array in values.items():
                self._arrays[name][region] = array
            for place in (*places[1:], *(place.parent for place in places[1:])):
                flush(place)
            self._arrays[STATUS][tuple(slice(i, i + 1) for i in tile)] = 1
            flush(places[0])
            flush(places[0].parent)
        except BaseException:
            for place in places:
                with contextlib.suppress(OSError):
                    place.unlink()
            raise


def sweep_orphans(path: Path, plan: Plan) -> None:
    """Take away what killed writers have left in a store, unless a living one is at work there."""
    with contextlib.suppress(OSError), _opened(path / "zarr.json") as store:
        if not _locked(store):
            return
        for name in (*VARIABLES[plan.load], STATUS):
            with contextlib.suppress(OSError), os.scandir(path / name) as entries:
                for entry in entries:
                    # a mark without content is one that a machine had not on its disk when it went down
                    if entry.name.endswith(_PARTIAL) or (name == STATUS and not entry.stat().st_size):
                        Path(entry).unlink(missing_ok=True)


def key(tile: Tile) -> str:
    """Name of the file of a chunk."""
    return ".".join(("c", *map(str, tile)))


@contextlib.contextmanager
def _opened(path: Path, how: int = os.O_RDWR) -> Iterator[int]:
    handle = os.open(path, how, 0o666)
    try:
        yield handle
    finally:
        os.close(handle)


def _same(handle: int, path: Path) -> bool:
    """Say whether an open file is still the one of that name."""
    try:
        return os.path.samestat(os.fstat(handle), path.stat())
    except FileNotFoundError:
        return False


def _locked(handle: int, *, wait: bool = False) -> bool | None:
    """Lock an open file, for one or (``wait``) with others; False if another has it, None where locks are unknown."""
    try:
        import fcntl

        fcntl.flock(handle, fcntl.LOCK_SH if wait else fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except (ImportError, OSError):
        return None
    return True


def flush(place: Path) -> None:
    """Wait until the disk has a file or a folder."""
    with _opened(place, os.O_RDONLY) as handle:
        os.fsync(handle)


def _writable(path: Path) -> bool:
    """Say whether files can be made in a folder; mode bits are looked at because root may write anything."""
    return bool(stat.S_IMODE(path.stat().st_mode) & _WRITE_BITS) and os.access(path, os.W_OK)


def refused(path: Path, error: OSError) -> InputError:
    """Return the line for an error of the file system."""
    if error.errno in {errno.ENOSPC, errno.EDQUOT}:
        return _no(path, "the disk is full", "make room and run the same command again, finished tiles are kept")
    if error.errno in {errno.EACCES, errno.EPERM, errno.EROFS}:
        return _no(path, "is read-only", "make it writable or give another path")
    said = shown(error.strerror or str(error)).strip(chr(34)).lower()
    return _no(path, f"cannot be written ({said})", "check the place")


def _create(path: Path, plan: Plan) -> None:
    """Make an empty store, or refuse the place; another process may be first, and then it is that one's."""
    for attempt in range(_TRIES):
        beside = path.with_name(f".{path.name}.{secrets.token_hex(6)}.new")
        try:
            beside.mkdir()
            with _opened(beside, os.O_RDONLY) as handle:
                _locked(handle)
                _fill(beside, plan)
                try:
                    beside.rename(path)
                except OSError as error:  # another run was first
                    if error.errno not in {errno.ENOTEMPTY, errno.EEXIST}:
                        raise
            flush(path.parent)
        except OSError as error:
            # a run that cannot see the lock, on another machine, may have taken the folder for a leftover
            if isinstance(error, FileNotFoundError) and not beside.exists() and attempt < _TRIES - 1:
                continue
            raise refused(path, error) from None
        finally:
            shutil.rmtree(beside, ignore_errors=True)
        return


def _clear(path: Path) -> None:
    """Take away what makers of this store have left beside it that were killed; never what a living one holds."""
    ours = re.compile(re.escape(f".{path.name}.") + r"[0-9a-f]{12}\.new")
    with contextlib.suppress(OSError):
        for beside in path.absolute().parent.iterdir():
            if ours.fullmatch(beside.name) and beside.is_dir() and not beside.is_symlink():
                with contextlib.suppress(OSError), _opened(beside, os.O_RDONLY) as handle:
                    if _locked(handle):
                        shutil.rmtree(beside, ignore_errors=True)


def _fill(beside: Path, plan: Plan) -> None:
    library = need("zarr")
    codecs = [library.codecs.ZstdCodec(level=1), library.codecs.Crc32cCodec()]
    group = library.create_group(beside, zarr_format=3, attributes=attributes(plan))
    for name, about in arrays(plan).items():
        how = {"chunk_key_encoding": {"name": "default", "separator": "."}, "config": {"write_empty_chunks": True}}
        group.create_array(name=name, compressors=codecs, **how, **about)
    for name, (values, _) in coordinates(plan).items():
        group[name][:] = values
    for place in sorted(beside.rglob("*")):
        flush(place)


def read_plan(path: Path) -> Plan:
    """Return the plan of a store; refuse what is none, what squama did not write, and a damaged one."""
    if not path.exists():
        raise _no(path, "no such store", "make it with: squama sweep beam.toml --over mu=0:2:401 -o map.zarr")
    text = ""
    try:
        text = (path / "zarr.json").read_text(encoding="utf-8")
        about = json.loads(text)["attributes"]
        version = about[MARK]
    except (OSError, ValueError, KeyError, TypeError):
        if MARK in text or (path.is_dir() and {STATUS, "end", "RED"} <= {entry.name for entry in path.iterdir()}):
            raise _damaged(path, "zarr.json") from None
        raise _no(path, "is no store that squama sweep has written", "give another name") from None
    if version != FORMAT:
        raise _no(path, f"was written by another version of squama (layout {version})", "make a new store")
    try:
        text = about["configuration"]
        plan = Plan.from_text(text)
        as_told = {"configuration": text, "configuration_sha256": hashlib.sha256(text.encode()).hexdigest()}
        if "engine" in plan.versions:
            as_told |= {key: about[key] for key in ("engine", "versions")}
        whole = attributes(plan) | as_told == about
    except (ValueError, KeyError, TypeError, AttributeError):
        whole = False
    if not whole:
        raise _damaged(path, "its configuration does not fit its hash")
    return plan


def check(path: Path, plan: Plan) -> Array:
    """Look at every part of a store but the data themselves; return which tiles are done, in the shape of the grid.

    A damaged store is refused.
    """
    library = need("zarr")
    known = coordinates(plan)
    wanted = ("shape", "chunks", "dtype", "dimension_names")
    for part, about in arrays(plan).items():
        try:
            array = library.open_array(path / part, mode="r", zarr_format=3)
            found = (array.shape, array.chunks, str(array.dtype), array.metadata.dimension_names)
            whole = found == tuple(about[entry] for entry in wanted)
            whole = whole and (part not in known or np.array_equal(array[:], known[part][0]))
        except Exception:  # damage shows itself in zarr as errors of many kinds
            whole = False
        if not whole:
            raise _damaged(path, part)
    done = marked(path, plan)
    for variable in VARIABLES[plan.load]:
        missing = done & ~_chunks(path / variable, plan.grid)
        if missing.any():
            first = tuple(int(i) for i in np.argwhere(missing)[0])
            raise _damaged(path, f"{variable}/{key(first)} is missing")
    return done


def marked(path: Path, plan: Plan) -> Array:
    """Say of each tile whether it has the mark of a finished one."""
    return _chunks(path / STATUS, plan.grid)


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

    A place that cannot take it, or that holds anything else, is refused and left as it was.
    """
    if path.suffix.lower() != ".zarr":
        refuse(files.label(path) or '""', "", "has not the extension .zarr", "write e.g. map.zarr")
    if not path.exists():
        folder = path.absolute().parent
        if not folder.is_dir():
            raise _no(path, f"its folder {files.label(folder)} does not exist", "make it first or give another path")
        if not _writable(folder):
            raise _no(path, f"its folder {files.label(folder)} is read-only", "give another path")
        _clear(path)
        _create(path, plan)
    stored = read_plan(path)
    if different := differences(stored, plan):
        raise _no(path, f"belongs to another sweep: {'; '.join(different)} (stored against asked)", "give another name")
    _clear(path)
    sweep_orphans(path, plan)
    done = check(path, plan)
    if not done.all() and not all(_writable(path / part) for part in (".", *VARIABLES[plan.load], STATUS)):
        raise _no(path, "is read-only", "make it writable or give another path")
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
    data = {name: found.variables[name] for name in (*VARIABLES[plan.load], STATUS)}
    beam = Beam.from_toml_text(plan.beam_toml)
    limits = {axis.name: (float(axis.values[0]), float(axis.values[-1])) for axis in plan.axes}
    # those of the beam as it is, and those of its joint's matrix where its shape varies
    lines = dict.fromkeys([*beam.warnings(plan.load), *matrix_warnings(beam, plan.load, limits)])
    return xr.Dataset(data, coords, {**found.attrs, "warnings": "\n".join(lines)})


def _no(path: Path, reason: str, remedy: str) -> InputError:
    return InputError(Problem(files.label(path), "", reason, remedy))


def _damaged(path: Path, what: str) -> InputError:
    return _no(path, f"is damaged ({what})", "remove it and run the sweep again")

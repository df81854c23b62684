"""The store of a sweep: a zarr group (format 3) of labelled arrays, a chunk per tile, and a mark per finished tile.

A store is made in a hidden folder beside its place and renamed when it is complete. zarr writes each chunk beside its
place and renames it; the mark of a tile (its chunk of ``status``) follows when its data and their checksums are on the
disk. However a run is killed, the marks name complete tiles only, and the next run overwrites or removes leftovers. It
also checks every marked tile against its checksums and computes damaged tiles anew. A store holds no time, machine or
path of its making.
"""

from __future__ import annotations

import contextlib
import errno
import functools
import json
import os
import re
import secrets
import shutil
import stat
import warnings
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from squama.beam.design import Beam
from squama.errors import InputError, Problem, refuse
from squama.io import files
from squama.loads import PAPER
from squama.needs import need
from squama.study.columns import matrix_warnings
from squama.study.layout import alike, fill, following
from squama.study.plan import CHECKSUMS, FORMAT, MARK, STATUS, Plan, Tile, arrays, attributes, differences
from squama.types import Array
from squama.units import shown

if TYPE_CHECKING:
    import xarray as xr

_WRITE_BITS = 0o222
_TRIES = 5
_MOST = 2**26
"""Largest size of a store's plan, and of a file that follows from it beyond its expected size, bytes."""
_PARTIAL = ".partial"
"""Suffix of a chunk that zarr has not finished, and of the claim on a tile."""
_TROUBLE: files.Known = {
    **dict.fromkeys(
        (errno.ENOSPC, errno.EDQUOT),
        ("the disk is full", "make room and run the same command again, finished tiles are kept"),
    ),
    **dict.fromkeys(
        (errno.EACCES, errno.EPERM, errno.EROFS), ("is read-only", "make it writable or give another path")
    ),
}
_AGAIN = "remove it and run the sweep again"
"""Remedy for a store that cannot be repaired."""
_REWRITE = "run the same sweep again: it writes this anew"


class Writer:
    """Writes the tiles of one store; one writer per process."""

    def __init__(self, path: Path, plan: Plan) -> None:
        self.path, self.plan = path, plan
        library = need("zarr")
        # chunks that hold only NaN are written too
        with library.config.set({"array.write_empty_chunks": True}):
            self._arrays = {
                name: library.open_array(path / name, mode="r+", zarr_format=3)
                for name in (*plan.variables, CHECKSUMS, STATUS)
            }

    @contextlib.contextmanager
    def claim(self, tile: Tile) -> Iterator[bool]:
        """Lock a tile and remove the mark of a damaged one; yield False where it is done or another writer has it."""
        mark = self.path / STATUS / key(tile)
        claimed = mark.with_name(mark.name + _PARTIAL)
        # while a writer holds the store, no process removes leftovers from it
        with _opened(self.path / "zarr.json") as store, _opened(claimed, os.O_RDWR | os.O_CREAT) as handle:
            _locked(store, wait=True)
            mine = _locked(handle) is not False and _same(handle, claimed)
            try:
                anew = mine and not whole(self.path, self.plan, tile)
                if anew:
                    mark.unlink(missing_ok=True)
                yield anew
            finally:
                if mine:
                    claimed.unlink(missing_ok=True)

    def write(self, tile: Tile, values: Mapping[str, Array]) -> None:
        """Write data and checksums of a tile, then its mark; remove all of them on failure."""
        from squama.study.chunks import sum_at, sums_of

        data = [f"{name}/{key(tile)}" for name in self.plan.variables]
        places = [self.path / place for place in (f"{STATUS}/{key(tile)}", *data, sums_of(key(tile)))]
        region = self.plan.place(tile)
        try:
            for name, array in values.items():
                self._arrays[name][region] = array
            sums = b"".join(sum_at(place, (self.path / place).read_bytes()) for place in data)
            self._arrays[CHECKSUMS][tile] = np.frombuffer(sums, "<u4")
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
    """Remove the leftovers of killed writers from a store, unless another writer is at work there."""
    with contextlib.suppress(OSError), _opened(path / "zarr.json") as store:
        if not _locked(store):
            return
        for name in arrays(plan):
            with contextlib.suppress(OSError), os.scandir(path / name) as entries:
                for entry in entries:
                    # an empty mark is one whose content had not reached the disk at a power failure
                    with contextlib.suppress(OSError):
                        if entry.name.endswith(_PARTIAL) or (name == STATUS and not entry.stat().st_size):
                            Path(entry).unlink(missing_ok=True)


def key(tile: Tile) -> str:
    """Return the file name of a tile's chunk, such as ``c.0.1``."""
    return ".".join(("c", *map(str, tile)))


@contextlib.contextmanager
def _opened(path: Path, how: int = os.O_RDWR) -> Iterator[int | None]:
    """Open a file or a folder; yield None for a folder where the system cannot open folders."""
    if os.name == "nt" and path.is_dir():
        yield None
        return
    handle = os.open(path, how, 0o666)
    try:
        yield handle
    finally:
        os.close(handle)


def _same(handle: int | None, path: Path) -> bool:
    """Say whether an open file is still the file at a path."""
    try:
        return handle is not None and os.path.samestat(os.fstat(handle), path.stat())
    except FileNotFoundError:
        return False


def _locked(handle: int | None, *, wait: bool = False) -> bool | None:
    """Lock an open file, exclusively or shared (``wait``); False if another has it, None where there are no locks."""
    if handle is None:
        return None
    library = need("portalocker")
    kinds = library.LockFlags
    try:
        library.lock(handle, kinds.SHARED if wait else kinds.EXCLUSIVE | kinds.NON_BLOCKING)
    except library.AlreadyLocked:
        return False
    except (library.LockException, OSError):
        return None
    return True


def flush(place: Path) -> None:
    """Wait until a file or a folder is on the disk."""
    # Windows flushes only files opened for writing
    with _opened(place, os.O_RDWR if os.name == "nt" else os.O_RDONLY) as handle:
        if handle is not None:
            os.fsync(handle)


def _writable(path: Path) -> bool:
    """Say whether files can be created in a folder; mode bits count too, because root may write anything."""
    return bool(stat.S_IMODE(path.stat().st_mode) & _WRITE_BITS) and os.access(path, os.W_OK)


def writing(path: Path) -> contextlib.AbstractContextManager[None]:
    """Name the store in errors of writing."""
    return files.naming(path, _TROUBLE, ("cannot be written", "check the place"), (OSError,))


def _create(path: Path, plan: Plan) -> None:
    """Make an empty store; if another process is first, its store stays."""
    for attempt in range(_TRIES):
        beside = path.with_name(f".{path.name}.{secrets.token_hex(6)}.new")
        try:
            beside.mkdir()
            with _opened(beside, os.O_RDONLY) as handle:
                _locked(handle)
                fill(beside, plan)
                for place in sorted(beside.rglob("*")):
                    flush(place)
                try:
                    beside.rename(path)
                except OSError as error:  # another run made the store first
                    if error.errno not in {errno.ENOTEMPTY, errno.EEXIST}:
                        raise
            flush(path.parent)
        except FileNotFoundError:
            # a run that cannot see the lock, on another machine, may have taken the folder for a leftover
            if beside.exists() or attempt == _TRIES - 1:
                raise
        else:
            return
        finally:
            shutil.rmtree(beside, ignore_errors=True)


def _clear(path: Path) -> None:
    """Remove unfinished copies of this store that killed runs left beside it; the copy of a living run is locked."""
    ours = re.compile(re.escape(f".{path.name}.") + r"[0-9a-f]{12}\.new")
    with contextlib.suppress(OSError):
        for beside in path.absolute().parent.iterdir():
            if ours.fullmatch(beside.name) and beside.is_dir() and not beside.is_symlink():
                with contextlib.suppress(OSError), _opened(beside, os.O_RDONLY) as handle:
                    if _locked(handle):
                        shutil.rmtree(beside, ignore_errors=True)


def read_plan(path: Path) -> Plan:
    """Return the plan of a store; refuse a missing, foreign or damaged one."""
    if not files.exists(path):
        raise _no(path, "no such store", "make it with: squama sweep beam.toml --over mu=0:2:401 -o map.zarr")
    text = ""
    try:
        text = files.read_ordinary(path / "zarr.json", _MOST).decode()
        document = json.loads(text)
        about, node = document["attributes"], (document["zarr_format"], document["node_type"])
        version = about[MARK]
    except (OSError, ValueError, KeyError, TypeError, RecursionError):
        if MARK in text or (path.is_dir() and {STATUS, "end", "RED"} <= {entry.name for entry in path.iterdir()}):
            raise _damaged(path, "zarr.json") from None
        raise _no(path, "is no store that squama sweep has written", "give another name") from None
    if version != FORMAT:
        said = f"was written by another version of squama (layout {shown(version)})"
        raise _no(path, said, "make a new store")
    try:
        plan = Plan.from_text(about["configuration"])
        sound = node == (3, "group") and attributes(plan) == about
    except (ValueError, KeyError, TypeError, AttributeError):
        sound = False
    if not sound:
        raise _damaged(path, "its configuration does not fit its hash")
    return plan


def check(path: Path, plan: Plan, remedy: str = _REWRITE) -> Array:
    """Check all files of a store but the tiles; return which tiles are marked as done, bool in the shape of the grid.

    A damaged store is refused; ``remedy`` is the advice for a file that follows from the plan.
    """
    found: dict[str, bytes] = {}
    for place, data in following(plan).items():
        name = place.partition("/")[0]
        try:
            found[place] = files.read_ordinary(path / place, _MOST + len(data))
            sound = found[place] == data or alike(found, plan, name)
        except Exception:  # damage shows itself in zarr as errors of many kinds
            sound = False
        if not sound:
            mends = (path / name).is_dir() and not (path / place).is_dir()
            raise _damaged(path, place, remedy) if mends else _damaged(path, name)
    return marked(path, plan)


def _mend(path: Path, plan: Plan) -> None:
    """Rewrite damaged files that follow from the plan, where the folder is writable."""
    for place, data in following(plan).items():
        file = path / place
        with contextlib.suppress(OSError):
            if files.read_ordinary(file, len(data)) == data:
                continue
        with contextlib.suppress(OSError, InputError):
            if file.is_symlink() or not file.is_file():
                file.unlink(missing_ok=True)
            files.atomic_write(file, functools.partial(Path.write_bytes, data=data))


def whole(path: Path, plan: Plan, tile: Tile) -> bool:
    """Say whether a tile is marked as done and undamaged; refuse a folder in place of a chunk."""
    from squama.study import chunks

    name = key(tile)
    if not (path / STATUS / name).exists():
        return False
    try:
        chunks.check(path, plan, name)
    except InputError:
        places = (*(f"{part}/{name}" for part in (STATUS, *plan.variables)), chunks.sums_of(name))
        if any((path / place).is_dir() for place in places):
            raise
        return False
    return True


def marked(path: Path, plan: Plan) -> Array:
    """Return which tiles are marked as done, bool in the shape of the grid."""
    return _chunks(path / STATUS, plan.grid)


def _chunks(folder: Path, grid: tuple[int, ...]) -> Array:
    """Return for which tiles a folder holds a chunk, bool in the shape of the grid (1 byte per tile)."""
    there = np.zeros(grid, bool)
    chunk = re.compile("c" + r"\.(\d{1,9})" * len(grid))
    with os.scandir(folder) as entries:
        for entry in entries:
            if (found := chunk.fullmatch(entry.name)) and os.path.isfile(entry.path):  # noqa: PTH113 - false for loops
                tile = tuple(map(int, found.groups()))
                if all(i < n for i, n in zip(tile, grid, strict=True)):
                    there[tile] = True
    return there


def there(path: Path) -> bool:
    """Say whether a store's path exists; refuse a path that cannot become a store."""
    need("zarr")
    if path.suffix.lower() != ".zarr":
        refuse(files.label(path) or '""', "", "has not the extension .zarr", "write e.g. map.zarr")
    if files.exists(path):
        return True
    files.try_place(path)
    return False


def prepare(path: Path, plan: Plan, shard: tuple[int, int] = (1, 1)) -> Array:
    """Make the store of a plan, or open it to resume; return which tiles are done, bool in the shape of the grid.

    Done tiles of the shard are checked against their checksums. A place that cannot hold the store, or that holds
    something else, is refused and left unchanged.
    """
    if not there(path):
        _clear(path)
        with writing(path):
            _create(path, plan)
    stored = read_plan(path)
    if different := differences(stored, plan):
        raise _no(path, f"belongs to another sweep: {'; '.join(different)} (stored against asked)", "give another name")
    _clear(path)
    sweep_orphans(path, plan)
    _mend(path, plan)
    # all files that could be rewritten have been
    done = check(path, plan, "make it writable and run the same sweep again")
    for tile in plan.tiles(shard):
        done[tile] = done[tile] and whole(path, plan, tile)
    if not done.all() and not all(_writable(path / part) for part in (".", *plan.variables, CHECKSUMS, STATUS)):
        raise _no(path, "is read-only", "make it writable or give another path")
    return done


def open_sweep(path: str | os.PathLike[str]) -> xr.Dataset:
    """Open the store of a sweep, finished or not, as :func:`squama.sweep` returns it; values are read on use.

    Raises InputError where there is no store, or one that squama did not write, or a damaged one.
    """
    files.place(path, "map.zarr")
    place = Path(path)
    plan = read_plan(place)
    done = check(place, plan)
    import xarray as xr

    from squama.study import chunks

    for variable in plan.variables:
        for missing in np.argwhere(done & ~_chunks(place / variable, plan.grid))[:1]:
            chunks.check(place, plan, key(tuple(missing)), variable)
    with warnings.catch_warnings():
        # zarr warns of foreign files in the folder, which do no harm
        warnings.simplefilter("ignore")
        found = xr.open_zarr(chunks.Checked(place, plan), consolidated=False, zarr_format=3, chunks=None)
    # in the order of the plan, because a folder has none
    coords = {dim: found.variables[dim] for dim in plan.dims}
    if "law" in coords:
        coords["law"] = xr.Variable("law", list(plan.laws), {"long_name": "force law"})
    data = {name: found.variables[name] for name in (*plan.variables, STATUS)}
    beam = Beam.from_toml_text(plan.beam_toml)
    limits = {axis.name: (float(axis.values[0]), float(axis.values[-1])) for axis in plan.axes}
    # warnings about the beam itself, and about its joint's matrix where the shape varies
    lines = dict.fromkeys(
        [*plan.model.warnings(beam, plan.load, plan.sense), *matrix_warnings(beam, plan.load, limits)]
    )
    return xr.Dataset(data, coords, {**PAPER, **found.attrs, "warnings": "\n".join(lines)})


def _no(path: Path, reason: str, remedy: str) -> InputError:
    return InputError(Problem(files.label(path), "", reason, remedy))


def _damaged(path: Path, what: str, remedy: str = _AGAIN) -> InputError:
    return _no(path, f"is damaged ({what})", remedy)

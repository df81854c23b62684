"""The store of a sweep: a zarr group (format 3) of labelled arrays, a chunk per tile, and a mark per finished tile.

Every chunk is written beside its place, flushed to the disk and moved there; the mark of a tile (its chunk of
``status``) follows when all its data are in place. Whatever kills a run, the marks therefore name whole tiles only,
and the next run overwrites whatever a dead one left. Nothing in a store tells when or where it was written.
A writer holds a lock on the unfinished mark, so no tile has two writers on one machine or one file system with locks.
"""

from __future__ import annotations

import contextlib
import errno
import os
import stat
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from squama import files
from squama.errors import InputError
from squama.model.solve import Array
from squama.study.parameters import PARAMETERS
from squama.study.plan import VARIABLES, Plan, Tile
from squama.units import shown

MARK = "squama_sweep"
"""Attribute of the group that marks a store; its value is the version of the layout."""
STATUS = "status"
_STATUS_ATTRS = {
    "long_name": "state of each tile",
    "flag_values": [0, 1],
    "flag_meanings": "not_computed done",
}
_WRITE_BITS = 0o222


def arrays(plan: Plan) -> dict[str, dict[str, Any]]:
    """Return the arguments of every array of the store, but for its codecs."""
    found: dict[str, dict[str, Any]] = {}
    for name, variable in VARIABLES[plan.load].items():
        found[name] = {
            "shape": plan.shape,
            "chunks": plan.tile,
            "dtype": variable.dtype,
            "dimension_names": plan.dims,
            "attributes": variable.attrs,
            "fill_value": np.nan if variable.dtype == "float64" else -1,
        }
    found[STATUS] = {
        "shape": plan.grid,
        "chunks": (1,) * len(plan.grid),
        "dtype": "int8",
        "dimension_names": tuple(f"tile_{dim}" for dim in plan.dims),
        "attributes": _STATUS_ATTRS,
        "fill_value": 0,
    }
    for name, (values, attrs) in coordinates(plan).items():
        found[name] = {
            "shape": values.shape,
            "chunks": values.shape,
            "dtype": str(values.dtype),
            "dimension_names": (name,),
            "attributes": attrs,
            "fill_value": 0,
        }
    return found


def coordinates(plan: Plan) -> dict[str, tuple[Array, dict[str, Any]]]:
    """Return values and attributes of the coordinates."""
    found: dict[str, tuple[Array, dict[str, Any]]] = {}
    if len(plan.laws) > 1:
        codes = np.arange(len(plan.laws), dtype="int8")
        flags = {"long_name": "force law", "flag_values": codes.tolist(), "flag_meanings": " ".join(plan.laws)}
        found["law"] = codes, flags
    for axis in plan.axes:
        found[axis.name] = axis.values, PARAMETERS[axis.name].symbol.attrs
    return found


def attributes(plan: Plan) -> dict[str, Any]:
    """Return the attributes of the group."""
    about = {
        "title": f"sweep of a scale-covered beam in {plan.load}",
        "Conventions": "CF-1.11",
        "load": plan.load,
        "law": " ".join(plan.laws),
        "sense": plan.sense,
        "margin": plan.margin,
        "engine": plan.engine,
        "beam": plan.beam_toml,
        "squama_version": plan.versions["squama"],
        "versions": plan.versions,
        "configuration": plan.text,
        "configuration_sha256": plan.digest,
        MARK: 1,
    }
    return {key: value for key, value in about.items() if value is not None}


def zarr() -> Any:
    """Import zarr, which is an extra.

    Raises
    ------
    InputError
        It is not installed.
    """
    try:
        import zarr as library
    except ImportError:
        message = "a sweep needs zarr; install it with: pip install 'squama[sweep]'"
        raise InputError(message) from None
    return library


class Writer:
    """Writes the tiles of one store; one per process."""

    def __init__(self, path: Path, plan: Plan) -> None:
        self.path, self.plan = path, plan
        library = zarr()
        self._memory: dict[str, dict[str, Any]] = {}
        self._arrays: dict[str, Any] = {}
        prototype = library.core.buffer.default_buffer_prototype().buffer
        for name in (*VARIABLES[plan.load], STATUS):
            # the array's own document, over memory: zarr encodes there, this class puts the bytes on the disk
            document = prototype.from_bytes((path / name / "zarr.json").read_bytes())
            self._memory[name] = {"zarr.json": document}
            store = library.storage.MemoryStore(store_dict=self._memory[name])
            self._arrays[name] = library.open_array(store, mode="r+", config={"write_empty_chunks": True})

    def encode(self, name: str, place: tuple[slice, ...], tile: Tile, values: Any) -> bytes:
        """Return the bytes of a chunk."""
        self._arrays[name][place] = values
        return bytes(self._memory[name].pop(key(tile)).to_bytes())

    @contextlib.contextmanager
    def claim(self, tile: Tile) -> Iterator[int | None]:
        """Take a tile: yield an open mark that is locked, or None if it is done or another writer has it."""
        mark = self.path / STATUS / key(tile)
        open_mark = _partial(mark)
        handle = os.open(open_mark, os.O_RDWR | os.O_CREAT, 0o666)
        try:
            mine = lock(handle)
            if mine and not mark.exists() and same(handle, open_mark):
                yield handle
            else:
                if mine and same(handle, open_mark):
                    open_mark.unlink()
                yield None
        except BaseException:
            if same(handle, open_mark):
                open_mark.unlink()
            raise
        finally:
            os.close(handle)

    def write(self, tile: Tile, values: Mapping[str, Array], handle: int) -> None:
        """Write the data of a tile, then its mark.

        Raises
        ------
        OSError
            The disk is full, read-only ...; what was written of the tile has then been taken away.
        """
        mark = self.path / STATUS / key(tile)
        places = {name: self.path / name / key(tile) for name in values}
        region = self.plan.place(tile)
        try:
            for name, place in places.items():
                put(_partial(place), self.encode(name, region, tile, values[name]))
            for place in places.values():
                _partial(place).replace(place)
            for place in places.values():
                flush(place.parent)
            cell = tuple(slice(i, i + 1) for i in tile)
            os.truncate(handle, 0)
            os.pwrite(handle, self.encode(STATUS, cell, tile, 1), 0)
            os.fsync(handle)
            _partial(mark).replace(mark)
            flush(mark.parent)
        except BaseException:
            if not mark.exists():
                for place in (*places.values(), *map(_partial, places.values()), _partial(mark)):
                    with contextlib.suppress(OSError):
                        place.unlink()
            raise


def put(place: Path, data: bytes) -> None:
    """Write a file and flush it to the disk."""
    with place.open("wb") as file:
        file.write(data)
        file.flush()
        os.fsync(file.fileno())


def key(tile: Tile) -> str:
    """Name of the file of a chunk."""
    return ".".join(("c", *map(str, tile)))


def _partial(place: Path) -> Path:
    return place.with_name(place.name + ".partial")


def same(handle: int, path: Path) -> bool:
    """Say whether an open file is still the one of that name."""
    try:
        return os.path.samestat(os.fstat(handle), path.stat())
    except FileNotFoundError:
        return False


def lock(handle: int, *, unless: bool = True) -> bool:
    """Lock an open file; False if another process has, ``unless`` where the file system has no locks."""
    try:
        import fcntl

        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except (ImportError, OSError):
        return unless
    return True


def flush(place: Path) -> None:
    """Wait until the disk has a file or a folder."""
    handle = os.open(place, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def writable(path: Path) -> bool:
    """Say whether files can be made in a folder; mode bits are looked at because root may write anything."""
    return bool(stat.S_IMODE(path.stat().st_mode) & _WRITE_BITS) and os.access(path, os.W_OK)


def refused(path: Path, error: OSError) -> InputError:
    """Return the line for an error of the file system."""
    name = files.label(path)
    if error.errno in {errno.ENOSPC, errno.EDQUOT}:
        problem = "the disk is full; make room and run the same command again, finished tiles are kept"
    elif error.errno in {errno.EACCES, errno.EPERM, errno.EROFS}:
        problem = "is read-only; make it writable or give another path"
    else:
        problem = f"cannot be written ({shown(error.strerror or str(error)).strip(chr(34)).lower()}); check the place"
    return InputError(f"{name}: {problem}")

"""Checks of the chunks of a store against their CRC-32C checksums, on reading and on resuming a sweep.

The last four bytes of a chunk are the CRC-32C of the bytes before. For a finished tile the array ``checksums`` holds,
for each chunk, the CRC-32C of the chunk followed by the name of its place, so a chunk in the wrong place is noticed
too.
"""

from __future__ import annotations

import asyncio
import errno
import math
from collections.abc import AsyncIterator
from pathlib import Path
from typing import TYPE_CHECKING, NoReturn

import google_crc32c as crc32c
from zarr.storage import LocalStore

from squama.errors import refuse
from squama.io import files
from squama.study.plan import CHECKSUMS, STATUS, Plan, arrays, coordinates

if TYPE_CHECKING:
    from zarr.abc.store import ByteRequest
    from zarr.core.buffer import Buffer, BufferPrototype

_SUM = 4
"""Bytes of a checksum."""
_DONE = b"\x01"
_ANEW = "run the same sweep again: it does this tile anew"
_MOST = 2**20
"""Largest size of a chunk beyond the bytes of its numbers, bytes."""


def sum_at(place: str, chunk: bytes) -> bytes:
    """Return the CRC-32C (4 bytes) of a chunk followed by the name of its place (``RED/c.0.1``)."""
    own = int.from_bytes(chunk[-_SUM:], "little")
    return int(crc32c.extend(own, place.encode())).to_bytes(_SUM, "little")


def sums_of(tile: str) -> str:
    """Return the place of a tile's checksums (``checksums/c.0.1.0``), with one more index, of the variables."""
    return f"{CHECKSUMS}/{tile}.0"


def check(path: Path, plan: Plan, tile: str, only: str | None = None) -> None:
    """Refuse a damaged tile (``c.0.1``) that is marked as done; ``only``: check the chunk of this variable alone."""
    names = list(plan.variables)
    mark, sums = (_sound(path, plan, tile, place)[:-_SUM] for place in (f"{STATUS}/{tile}", sums_of(tile)))
    if mark != _DONE or len(sums) != _SUM * len(names):
        _refuse(path, tile, "its mark does not fit its checksum")
    for i, name in enumerate(names):
        place = f"{name}/{tile}"
        if only in (None, name) and sum_at(place, _sound(path, plan, tile, place)) != sums[_SUM * i : _SUM * (i + 1)]:
            _refuse(path, tile, f"{place} does not fit the checksum of its place")


def _sound(path: Path, plan: Plan, tile: str, place: str) -> bytes:
    """Return the bytes of a chunk, or refuse one that is missing or does not fit its own checksum."""
    try:
        chunk = files.read_ordinary(path / place, _MOST + 16 * math.prod(plan.tile))
    except FileNotFoundError:
        _refuse(path, tile, f"{place} is missing")
    except IsADirectoryError:
        _refuse(path, tile, f"{place} is a folder", f"remove it and {_ANEW}")
    except OSError as error:
        known = error.errno in {errno.EINVAL, errno.EFBIG}
        why = error.strerror if known else f"cannot be read, {str(error.strerror).lower()}"
        _refuse(path, tile, f"{place} {why}")
    if len(chunk) <= _SUM or crc32c.value(chunk[:-_SUM]) != int.from_bytes(chunk[-_SUM:], "little"):
        _refuse(path, tile, f"{place} does not fit its checksum")
    return chunk


def _refuse(path: Path, tile: str, what: str, remedy: str = _ANEW) -> NoReturn:
    refuse(files.label(path), "", f"is damaged (tile {tile.removeprefix('c.')}: {what})", remedy)


class Checked(LocalStore):
    """A read-only zarr store that hides unmarked tiles and foreign files and refuses damaged chunks."""

    def __init__(self, root: Path, plan: Plan) -> None:
        super().__init__(root, read_only=True)
        self._plan = plan
        self._own = {"zarr.json", *arrays(plan), *coordinates(plan)}

    def with_read_only(self, read_only: bool = True) -> Checked:  # noqa: ARG002 - the shape of a store
        """Return this store, which is always read-only."""
        return self

    async def list_dir(self, prefix: str) -> AsyncIterator[str]:
        """Yield the names in a folder; in the root, only arrays of the plan."""
        async for name in super().list_dir(prefix):
            if prefix.strip("/") or name in self._own:
                yield name

    def _there(self, key: str) -> bool:
        """Say whether a file may be read: the plan has it, and its tile is marked as done and undamaged."""
        name, _, tile = key.rpartition("/")
        if key.partition("/")[0] not in self._own:
            return False
        if not tile.startswith("c.") or name not in (STATUS, *self._plan.variables):
            return True
        if not (self.root / STATUS / tile).exists():
            return False
        check(self.root, self._plan, tile, name)
        return True

    async def get(
        self, key: str, prototype: BufferPrototype | None = None, byte_range: ByteRequest | None = None
    ) -> Buffer | None:
        """Return the content of a file, None for a missing file."""
        return await super().get(key, prototype, byte_range) if await asyncio.to_thread(self._there, key) else None

    def get_sync(
        self, key: str, *, prototype: BufferPrototype | None = None, byte_range: ByteRequest | None = None
    ) -> Buffer | None:
        """Return the content of a file, None for a missing file."""
        return super().get_sync(key, prototype=prototype, byte_range=byte_range) if self._there(key) else None

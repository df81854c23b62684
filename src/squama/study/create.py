"""Making the store of a sweep: complete in its place, or not there at all.

A store grows in a hidden folder beside its place, which its maker keeps locked, and is moved there when it is whole.
A maker that was killed leaves that folder without a lock: the next run takes it away.
"""

from __future__ import annotations

import contextlib
import errno
import os
import re
import secrets
import shutil
from collections.abc import Iterator
from pathlib import Path

from squama.study import zstore
from squama.study.plan import Plan

TRIES = 5


def create(path: Path, plan: Plan) -> None:
    """Make an empty store; another process may be first, and then it is that one's.

    Raises
    ------
    InputError
        The place cannot take it.
    """
    for attempt in range(TRIES):
        beside = path.with_name(f".{path.name}.{secrets.token_hex(6)}.new")
        try:
            beside.mkdir()
            with _held(beside):
                _fill(beside, plan)
                with contextlib.suppress(FileExistsError):
                    _rename_new(beside, path)
            zstore.flush(path.parent)
        except OSError as error:
            # a run that cannot see the lock, on another machine, may have taken the folder for a leftover
            if isinstance(error, FileNotFoundError) and not beside.exists() and attempt < TRIES - 1:
                continue
            raise zstore.refused(path, error) from None
        finally:
            shutil.rmtree(beside, ignore_errors=True)
        return


def clear(path: Path) -> None:
    """Take away what makers of this store have left beside it that were killed; never what a living one holds."""
    ours = re.compile(re.escape(f".{path.name}.") + r"[0-9a-f]{12}\.new")
    with contextlib.suppress(OSError):
        for beside in path.absolute().parent.iterdir():
            if ours.fullmatch(beside.name) and beside.is_dir() and not beside.is_symlink():
                with contextlib.suppress(OSError), _held(beside) as mine:
                    if mine:
                        shutil.rmtree(beside, ignore_errors=True)


def _fill(beside: Path, plan: Plan) -> None:
    library = zstore.zarr()
    codecs = [library.codecs.ZstdCodec(level=1), library.codecs.Crc32cCodec()]
    group = library.create_group(beside, zarr_format=3, attributes=zstore.attributes(plan))
    for name, about in zstore.arrays(plan).items():
        group.create_array(
            name=name,
            compressors=codecs,
            chunk_key_encoding={"name": "default", "separator": "."},
            config={"write_empty_chunks": True},
            **about,
        )
    for name, (values, _) in zstore.coordinates(plan).items():
        group[name][:] = values
    for place in sorted(beside.rglob("*")):
        zstore.flush(place)


@contextlib.contextmanager
def _held(folder: Path) -> Iterator[bool]:
    """Lock a folder; False if another process has, or if nobody can on this file system."""
    handle = os.open(folder, os.O_RDONLY)
    try:
        yield zstore.lock(handle, unless=False)
    finally:
        os.close(handle)


def _rename_new(beside: Path, path: Path) -> None:
    """Move a folder to a place where nothing is; another shard may have been first."""
    try:
        beside.rename(path)
    except OSError as error:
        if error.errno in {errno.ENOTEMPTY, errno.EEXIST}:
            raise FileExistsError from None
        raise

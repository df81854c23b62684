"""The copies of compiled code and of joints on the disk are cut off, deleted, replaced or impossible to write.

What is computed is the same, no error comes out and no warning; where a copy cannot be written one line says so.
"""

from __future__ import annotations

import errno
import logging
import os
import random
import shutil
import tempfile
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from unittest import mock

import numba
import numpy as np
from numba.core.caching import IndexDataCacheFile

from squama.batch import keeping
from squama.fe import stiffness
from squama.progress import LOG

TRIALS, SIZE = 40, 10
KINDS = ("whole", "cut", "empty", "deleted", "folder", "loop", "full", "file")


@contextmanager
def told() -> Iterator[list[str]]:
    """Yield a list that gets the lines of the log."""
    lines: list[str] = []
    handler = logging.Handler()
    handler.emit = lambda record: lines.append(record.getMessage())  # type: ignore[method-assign]
    LOG.addHandler(handler)
    try:
        yield lines
    finally:
        LOG.removeHandler(handler)


def computed(folder: Path, shift: float) -> tuple[float, list[float]]:
    """Return what a compiled function and a joint's numbers are, by their copies in a folder or anew."""

    def f(x: float) -> float:
        return 2 * x

    with (
        mock.patch.object(numba.config, "CACHE_DIR", str(folder)),
        mock.patch.object(numba.config, "CACHE_LOCATOR_CLASSES", "UserProvidedCacheLocator"),
        mock.patch.dict(os.environ, {"XDG_CACHE_HOME": str(folder)}),
    ):
        found, _, _ = stiffness.kept(("campaign", shift), False, lambda: (shift * np.eye(2), 1))
        return float(keeping.kept(f, [Path(__file__)])(shift)), found.ravel().tolist()


def damage(dice: random.Random, folder: Path, kind: str) -> None:
    """Damage a file of the copies."""
    if kind == "file":
        shutil.rmtree(folder)
        folder.write_text("")
        return
    place = dice.choice([p for p in sorted(folder.rglob("*")) if p.is_file()])
    data = place.read_bytes()
    if kind in ("cut", "empty"):
        place.write_bytes(data[: dice.randrange(len(data))] if kind == "cut" else b"")
    elif kind not in ("whole", "full"):
        place.unlink()
        if kind == "folder":
            place.mkdir()
        elif kind == "loop":
            place.symlink_to(place.name)


def full(*_: object, **__: object) -> None:
    """Fail as on a full disk."""
    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


def trial(seed: int) -> list[str]:
    """Damage copies."""
    dice = random.Random(seed)
    failed = []
    for number in range(SIZE):
        shift, kind = dice.uniform(1, 2), dice.choice(KINDS)
        folder = Path(tempfile.mkdtemp(prefix="squama-caches-"))
        try:
            wanted = computed(folder, shift)
            damage(dice, folder, kind)
            if kind == "full":
                shutil.rmtree(folder)
            blocked = [
                mock.patch.object(IndexDataCacheFile, "_save_data", full),
                mock.patch.object(Path, "write_text", full),
            ]
            with warnings.catch_warnings(), told() as lines:
                warnings.simplefilter("error")
                for patch in blocked if kind == "full" else []:
                    patch.start()
                try:
                    found = [computed(folder, shift) for _ in range(2)]
                finally:
                    mock.patch.stopall()
            if any(values != wanted for values in found):
                failed.append(f"seed {seed}, {number}: {kind}: {found} for {wanted}")
            if kind == "full" and len(lines) != 2:
                failed.append(f"seed {seed}, {number}: {kind}: {lines}")
        except Exception as error:
            failed.append(f"seed {seed}, {number}: {kind}: {type(error).__name__}: {error}"[:300])
        finally:
            (folder.unlink if folder.is_file() else lambda f=folder: shutil.rmtree(f))()
    return failed

"""Results for joints that are kept between runs, in the user's cache folder: XDG_CACHE_HOME/squama/joints.

A file for each mesh, named after what it depends on. The folder can be deleted at any time; where it cannot be written
or a file is damaged, results are computed anew.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from squama import files
from squama._version import __version__
from squama.errors import InputError

_SCHEME = 1
"""Changes whenever the same numbers would mean something else."""

Array = NDArray[np.float64]


def folder() -> Path:
    """Return where results are kept."""
    given = os.environ.get("XDG_CACHE_HOME", "")
    base = Path(given) if Path(given).is_absolute() else Path("~/.cache").expanduser()
    return base / "squama" / "joints"


def kept(key: tuple[object, ...], store: bool, compute: Callable[[], tuple[Array, int]]) -> tuple[Array, int, bool]:
    """Return an array and a count that belong to a key, computed if they are not there.

    Parameters
    ----------
    key : tuple
        Numbers and words that they depend on.
    store : bool
        Whether to read and write the folder at all.
    compute : callable
        Returns both.

    Returns
    -------
    (array, int, bool)
        The last says whether they were computed now.
    """
    if not store:
        return *compute(), True
    text = json.dumps([_SCHEME, __version__, *key])
    try:
        place = folder() / f"{hashlib.sha256(text.encode()).hexdigest()[:32]}.json"
    except RuntimeError:
        # there is no home
        return *compute(), True
    if (found := _read(place, text)) is not None:
        return *found, False
    array, count = compute()
    _write(place, {"key": text, "array": array.tolist(), "count": count})
    return array, count, True


def _read(place: Path, text: str) -> tuple[Array, int] | None:
    try:
        record = json.loads(place.read_text(encoding="utf-8"))
        array, count = np.array(record["array"], float), int(record["count"])
    except (OSError, ValueError, KeyError, TypeError):
        return None
    return (array, count) if record["key"] == text and np.isfinite(array).all() else None


def _write(place: Path, record: dict[str, object]) -> None:
    try:
        place.parent.mkdir(parents=True, exist_ok=True)
        files.atomic_write(place, lambda beside: beside.write_text(json.dumps(record), encoding="utf-8"))
    except (OSError, InputError):
        return

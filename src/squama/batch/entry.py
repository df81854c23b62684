"""The one compiled function that is called from outside, and its copy on the disk."""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import Any

import numba
import numpy as np

from squama import model
from squama.batch import kernel
from squama.model.figures import Common
from squama.types import Array

SOURCES = [f for room in (__file__, str(model.__file__)) for f in sorted(Path(room).parent.glob("*.py"))]
"""All that may be compiled."""
_answer = kernel.fill


def _sources() -> str:
    """Digest of the sources, for Numba looks at the file of the outermost function only."""
    return hashlib.sha256(b"".join(f.read_bytes() for f in SOURCES)).hexdigest()


def _entry(stamp: str) -> Any:
    def fill(designs: Array, low: int, high: int, common: Common, rooms: Array, out: Array, whole: Array) -> str:
        """Answer the designs low..high, as :func:`squama.model.figures.fill`."""
        _answer(designs, low, high, common, rooms[0], out, whole)
        return stamp

    # the files of the copy bear the digest: Numba fails on those of sources from which a module went
    fill.__qualname__ = f"fill_{stamp[:16]}"
    options: dict[str, Any] = {"error_model": "numpy", "nogil": True}
    try:
        return numba.njit(cache=True, **options)(fill)
    except RuntimeError:  # no place on the disk to keep compiled code
        return numba.njit(**options)(fill)


fill = _entry(_sources())


def room() -> Array:
    """Return room for the samples of one path."""
    return np.zeros(1, kernel.ROOM).view(np.recarray)


def ready() -> bool:
    """Whether the compiled code is loaded, or likely to be found on the disk."""
    kept = fill.stats.cache_path
    return bool(fill.signatures) or (kept is not None and any(Path(kept).glob(f"*{fill.py_func.__qualname__}-*.nbc")))

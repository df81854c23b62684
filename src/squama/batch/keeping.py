"""Compiled functions that are kept on the disk, for the sources they were made from."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Sequence
from pathlib import Path
from types import FunctionType
from typing import Any

import numba


def kept(f: Callable[..., Any], sources: Sequence[Path]) -> Any:
    """Return a function compiled; its copy on the disk is used as long as none of the sources changes.

    Numba itself looks at the file of this function only.
    """
    assert isinstance(f, FunctionType)
    stamp = hashlib.sha256(b"".join(file.read_bytes() for file in sources)).hexdigest()
    # the files of the copy bear the digest: Numba fails on those of sources from which a module went
    f.__qualname__ = f"{f.__name__}_{stamp[:16]}"
    options: dict[str, Any] = {"error_model": "numpy", "nogil": True}
    try:
        return numba.njit(cache=True, **options)(f)
    except RuntimeError:  # no place on the disk to keep compiled code
        return numba.njit(**options)(f)


def is_ready(f: Any) -> bool:
    """Whether a compiled function is loaded, or likely to be found on the disk."""
    place = f.stats.cache_path
    return bool(f.signatures) or (place is not None and any(Path(place).glob(f"*{f.py_func.__qualname__}-*.nbc")))

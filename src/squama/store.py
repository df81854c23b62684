"""Datasets to files and back; the file's extension chooses the format.

A format is one row of :data:`FORMATS`: a writer that fills a path, a reader that returns what was written.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from squama import csvfile, files, netcdf
from squama.errors import InputError

if TYPE_CHECKING:
    import xarray as xr


class Format(NamedTuple):
    """How datasets are written to, and read from, files of one extension."""

    name: str
    write: Callable[[xr.Dataset, Path], None]
    read: Callable[[str | os.PathLike[str]], xr.Dataset]


FORMATS: dict[str, Format] = {
    ".nc": Format("netCDF", netcdf.write, netcdf.read),
    ".csv": Format("CSV", csvfile.write, csvfile.read),
}
"""Formats by extension; whoever adds a row adds a format."""


def save(dataset: xr.Dataset, path: str | os.PathLike[str]) -> Path:
    """Write a response to a file; the extension chooses the format (.nc, .csv).

    Parameters
    ----------
    dataset : xarray.Dataset
        As :func:`squama.twist` or :func:`squama.bend` returns it.
    path : path
        Where to write. A file that is there is replaced when the new one is complete.

    Returns
    -------
    Path
        The file's path, as given.

    Raises
    ------
    InputError
        The extension is not known, or the place cannot take the file.

    Examples
    --------
    >>> import squama, tempfile
    >>> r = squama.twist(squama.Beam.from_ratios(), mu=0.5)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     again = squama.read(squama.save(r, f"{folder}/curve.csv"))
    >>> again.identical(r)
    True
    """
    chosen = FORMATS[extension(path, FORMATS)]
    return files.atomic_write(path, lambda place: chosen.write(dataset, place))


def read(path: str | os.PathLike[str]) -> xr.Dataset:
    """Read a response that :func:`save` or the command line has written (.nc, .csv).

    Parameters
    ----------
    path : path
        The file.

    Returns
    -------
    xarray.Dataset
        Identical to the one that was written.

    Raises
    ------
    InputError
        The extension is not known, there is no such file, it is damaged, or squama did not write it.
    """
    return FORMATS[extension(path, FORMATS)].read(path)


def extension(path: str | os.PathLike[str], allowed: Iterable[str]) -> str:
    """Return the extension of a path in small letters, or refuse it and name the allowed ones."""
    found = Path(path).suffix.lower()
    known = list(allowed)
    if found in known:
        return found
    problem = f"the extension {files.label(found)} is not known" if found else "has no extension"
    name = files.label(path) or '""'
    message = f"{name}: {problem}; allowed: {', '.join(known)}"
    raise InputError(message)


def check_place(path: str | os.PathLike[str], allowed: Iterable[str] = ()) -> None:
    """Refuse a path that could not be written, before any work is done for it; nothing is left there.

    Parameters
    ----------
    path : path
        Where a file is to be.
    allowed : iterable of str
        Extensions that the file may have; any if empty.

    Raises
    ------
    InputError
        As from :func:`save`.
    """
    known = list(allowed)
    if known:
        extension(path, known)
    try:
        files.atomic_write(path, _try)
    except _Tried:
        return


class _Tried(Exception):  # noqa: N818 - it is the good outcome
    """Ends a trial of a place before anything is put there."""


def _try(place: Path) -> None:
    place.touch()
    raise _Tried

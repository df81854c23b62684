"""Datasets as netCDF-4 files, through xarray and h5netcdf."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from squama import files
from squama.errors import InputError

if TYPE_CHECKING:
    import xarray as xr

MARK = "squama_file"
"""Global attribute that marks the files of :func:`write`; its value is the version of the layout."""

LISTS = "squama_lists"
"""Global attribute with the names of those that are lists; HDF5 does not tell a list of one number from a number."""

_SIGNATURES = (b"\x89HDF\r\n\x1a\n",)


def write(dataset: xr.Dataset, place: Path) -> None:
    """Write a dataset to a new file."""
    lists = [str(key) for key, value in dataset.attrs.items() if isinstance(value, list)]
    marked = dataset.assign_attrs({MARK: 1, **({LISTS: " ".join(lists)} if lists else {})})
    # what an earlier file wanted (chunks, fill values) does not belong to the data
    marked.drop_encoding().to_netcdf(place, engine="h5netcdf", format="NETCDF4")


def read(path: str | os.PathLike[str]) -> xr.Dataset:
    """Read what :func:`write` has written.

    Parameters
    ----------
    path : path
        The file.

    Returns
    -------
    xarray.Dataset

    Raises
    ------
    InputError
        No such file, damaged, or written by another program.
    """
    name = files.label(path)
    head = _head(path)
    if head not in _SIGNATURES:
        raise _refused(name, "is no netCDF-4 file")
    import xarray as xr

    try:
        with xr.open_dataset(Path(path), engine="h5netcdf", decode_times=False) as stored:
            dataset = stored.load()
    except Exception:  # damage shows itself in h5py and xarray as errors of many kinds
        raise _refused(name, "is damaged: it cannot be read to its end") from None
    if dataset.attrs.pop(MARK, None) != 1:
        raise _refused(name, "was not written by this version of squama")
    for variable in dataset.variables.values():
        variable.attrs = {key: _plain(value) for key, value in variable.attrs.items()}
    lists = dataset.attrs.pop(LISTS, "").split()
    dataset.attrs = {
        key: np.atleast_1d(value).tolist() if key in lists else _plain(value) for key, value in dataset.attrs.items()
    }
    texts = {key: value.astype(str) for key, value in dataset.variables.items() if value.dtype == object}
    dataset = dataset.assign({key: value for key, value in texts.items() if key in dataset.data_vars})
    dataset = dataset.assign_coords({key: value for key, value in texts.items() if key in dataset.coords})
    return dataset.drop_encoding()


def _head(path: str | os.PathLike[str]) -> bytes:
    """Return the first bytes of a file; a file that cannot be opened is refused in the words for all files."""
    try:
        with Path(path).open("rb") as file:
            return file.read(len(_SIGNATURES[0]))
    except (OSError, ValueError):
        files.read_text(path, missing="check the name")
        raise


def _plain(value: Any) -> Any:
    """Return an attribute as it was before it went through HDF5, which keeps NumPy scalars."""
    return value.item() if getattr(value, "ndim", None) == 0 else value


def _refused(name: str, problem: str) -> InputError:
    return InputError(f"{name}: {problem}; write it anew with squama.save or --netcdf")

"""Datasets as CSV: one row per point for people, and all the rest in comments that a program reads back.

The file begins with ``# squama file: 1``. Then follow, one JSON value to a line, the sizes of the dimensions,
the attributes (among them the beam), every single figure, and what belongs to each column; then the header with
units, such as ``Phi (rad/m)``, and a row per point, curve after curve. Numbers have all their digits.
"""

from __future__ import annotations

import csv
import json
import math
import os
import re
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from squama import tabular
from squama.errors import InputError

if TYPE_CHECKING:
    import xarray as xr

MARK = "# squama file: 1"
_LINE = re.compile(r"# (\w+)(?: (.+?))?: (.+)")
_CAST: dict[str, Any] = {"f": float, "i": int, "u": int, "U": str, "b": bool}


class _Column(NamedTuple):
    """Header and cells of a variable that spans all dimensions, or of a dimension's coordinate."""

    header: str
    cells: list[str]


def write(dataset: xr.Dataset, place: Path) -> None:
    """Write a dataset to a new file.

    Raises
    ------
    InputError
        A variable is of a type that has no text form here, such as complex numbers or dates; or there are no rows.
    """
    sizes = {str(dim): int(size) for dim, size in dataset.sizes.items()}
    if not sizes or not all(sizes.values()):
        message = "the dataset has no points, so a CSV file of it would have no rows; write a .nc file"
        raise InputError(message)
    lines = [MARK, f"# sizes: {json.dumps(sizes)}"]
    lines += [f"# attribute {key}: {json.dumps(_plain(value))}" for key, value in dataset.attrs.items()]
    columns: list[_Column] = []
    for name in (*dataset.coords, *dataset.data_vars):
        variable = dataset.variables[name]
        role = "coordinate" if name in dataset.coords else "variable"
        if variable.dtype.kind not in _CAST:
            message = f"{name}: values of type {variable.dtype} cannot be written to CSV; write a .nc file"
            raise InputError(message)
        about = {
            "dims": list(variable.dims),
            "dtype": variable.dtype.str[1:] if variable.dtype.kind == "U" else str(variable.dtype),
            "attrs": {key: _plain(value) for key, value in variable.attrs.items()},
        }
        whole = set(variable.dims) == set(sizes)
        if whole or variable.dims == (name,):
            header = _header(str(name), variable.attrs.get("units"))
            present = [dim for dim in sizes if dim in variable.dims]
            shape = [sizes[dim] if dim in present else 1 for dim in sizes]
            values = variable.transpose(*present).values.reshape(shape)
            columns.append(_Column(header, _texts(np.broadcast_to(values, list(sizes.values())))))
        if whole:
            about["header"] = columns[-1].header
        else:
            about = {"value": _jsonable(variable.values.tolist()), **about}
        lines.append(f"# {role} {name}: {json.dumps(about)}")
    with place.open("w", encoding="utf-8", newline="") as file:
        file.write("\n".join(lines) + "\n")
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow([column.header for column in columns])
        writer.writerows(zip(*(column.cells for column in columns), strict=True))


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
        No such file, damaged (with the line), or written by another program.
    """
    table = tabular.read(path)
    if not table.comments or table.comments[0] != MARK:
        message = (
            f"{table.name}: was not written by squama --csv; measured points are given with --data, "
            "designs to squama ends"
        )
        raise InputError(message)
    import xarray as xr

    entries = [_entry(table, number, line) for number, line in enumerate(table.comments[1:], start=2)]
    sizes: dict[str, int] = {}
    attrs: dict[str, Any] = {}
    found: dict[str, dict[str, Any]] = {"coordinate": {}, "variable": {}}
    for entry in entries:
        with _damage(table, entry.line):
            if entry.role == "sizes":
                sizes = {str(dim): int(size) for dim, size in entry.value.items()}
                _check_rows(table, sizes)
            elif entry.role == "attribute":
                attrs[entry.key] = entry.value
            else:
                found[entry.role][entry.key] = _variable(table, entry.value, sizes)
    with _damage(table, table.header.line):
        return xr.Dataset(found["variable"], coords=found["coordinate"], attrs=attrs)


class _Entry(NamedTuple):
    """A comment line that a program reads."""

    line: int
    role: str
    key: str
    value: Any


@contextmanager
def _damage(table: tabular.Table, line: int) -> Iterator[None]:
    """Turn what goes wrong with a line into the error that names it."""
    try:
        yield
    except InputError:
        raise
    except (AttributeError, KeyError, TypeError, ValueError):
        raise table.error(line, "is damaged: it is not as squama wrote it; write the file anew") from None


def _entry(table: tabular.Table, line: int, text: str) -> _Entry:
    with _damage(table, line):
        role, key, value = _LINE.fullmatch(text).groups()  # type: ignore[union-attr]
        return _Entry(line, role, key, json.loads(value))


def _check_rows(table: tabular.Table, sizes: dict[str, int]) -> None:
    """Refuse a table that is cut off."""
    rows = math.prod(sizes.values())
    if len(table.rows) != rows:
        last = (table.rows or [table.header])[-1].line
        what = f"has {len(table.rows)} rows where squama wrote {rows}; write the file anew"
        raise table.error(last, f"the table ends here and {what}")
    for row in table.rows:
        if problem := tabular.ragged(row, len(table.header.cells)):
            raise table.error(row.line, problem)


def _variable(
    table: tabular.Table, about: dict[str, Any], sizes: dict[str, int]
) -> tuple[list[str], Any, dict[str, Any]]:
    """Return dimensions, values and attributes of a variable from its comment line and its column."""
    dims, dtype = list(about["dims"]), np.dtype(about["dtype"])
    cast = _CAST[dtype.kind]
    if "header" not in about:
        return dims, np.array(_nested(about["value"], cast), dtype), about["attrs"]
    place = table.header.cells.index(about["header"])
    read = {"true": True, "false": False}.__getitem__ if dtype.kind == "b" else cast
    cells: list[Any] = []
    for row in table.rows:
        try:
            cells.append(read(row.cells[place]))
        except (KeyError, ValueError):
            where = tabular.where(about["header"], row.cells[place])
            raise table.error(row.line, f"{where}: is not as squama wrote it; write the file anew") from None
    order = list(sizes)
    values = np.array(cells, dtype).reshape([sizes[dim] for dim in order])
    return dims, values.transpose([order.index(dim) for dim in dims]), about["attrs"]


def _header(name: str, unit: str | None) -> str:
    return f"{name} ({unit})" if unit else name


def _texts(values: np.ndarray[Any, Any]) -> list[str]:
    """Return values as text that reads back to the last bit."""
    flat: Sequence[Any] = values.ravel().tolist()
    if values.dtype.kind == "U":
        return list(flat)
    return [repr(value).lower() for value in flat]


def _plain(value: Any) -> Any:
    """Return an attribute as JSON knows it."""
    return value.tolist() if hasattr(value, "tolist") else value


def _jsonable(value: Any) -> Any:
    """Return nested numbers with NaN and infinity as words, which JSON has no numbers for."""
    if isinstance(value, list):
        return [_jsonable(item) for item in value]
    return repr(value) if isinstance(value, float) and not np.isfinite(value) else value


def _nested(value: Any, cast: Any) -> Any:
    return [_nested(item, cast) for item in value] if isinstance(value, list) else cast(value)

"""Datasets in files; the extension selects the format, a row of :data:`FORMATS`.

A CSV file has a row for each point (for N scales a row for each scale), and all other data in comments that a program
reads back. It begins with ``# squama file: 1``. Then follow, one JSON value to a line, the sizes of the rows'
dimensions, the attributes (among them the beam), values and tables that are no columns, dimensions and attributes of
each column, and the hash of all other lines; then the header with units, such as ``Phi (rad/m)``, and the rows, curve
after curve: the load, the number of the scale, variables of the point, variables of the scale. Numbers have all their
digits.

A netCDF file ends with the hash of all bytes before it, so damage is found before the HDF5 library reads the file and
possibly hangs. Older files have no hash and are read as they are.
"""

from __future__ import annotations

import hashlib
import io
import json
import math
import operator
import os
import re
import subprocess
import sys
import warnings
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from squama import arguments
from squama.errors import InputError, Problem, Problems, refuse
from squama.io import files, tabular
from squama.types import Array

if TYPE_CHECKING:
    import xarray as xr

CSV_MARK = "# squama file: 1"
"""First line of CSV files."""
CSV_HASH = "# sha256: "
"""Start of the line with the hash of all other lines."""
NETCDF_MARK = "squama_file"
"""Global attribute that marks netCDF files: 2 for a file that ends with a hash, 1 for older files."""
LARGEST = 1_000_000_000
"""Largest size of values in memory, bytes, where the file is smaller."""
_HANGS = 120.0
"""Seconds after which reading a file without a hash is abandoned."""
NETCDF_LISTS = "squama_lists"
"""Global attribute with the names of attributes that are lists (twice for lists of lists), because HDF5 does not
distinguish a list of one item from the item.
"""
_POINT = "point"
"""Dimension along a curve."""
_SIGNATURE = b"\x89HDF\r\n\x1a\n"
_LINE = re.compile(r"# (?:(sizes|sha256)|(attribute|coordinate|variable) (.+?)): (.+)")
_JOINED = re.compile(r"([,;])([=+@-])")
_encode = json.JSONEncoder(default=operator.methodcaller("tolist")).encode
_CAST: dict[str, Callable[[str], object]] = {"f": float, "i": int, "u": int, "U": str, "b": bool}


def save(dataset: xr.Dataset, path: str | os.PathLike[str]) -> Path:
    """Write a response to a file; the extension chooses the format (.nc, .csv).

    An existing file is replaced when the new one is complete. Returns the path as given. Raises InputError for an
    unknown extension, or a place that cannot hold the file.

    >>> import squama, tempfile
    >>> r = squama.twist(squama.Beam.from_ratios(), mu=0.5)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     again = squama.read(squama.save(r, f"{folder}/curve.csv"))
    >>> again.identical(r)
    True
    """
    arguments.result(dataset)
    files.place(path, "curve.nc")
    write, _ = FORMATS[extension(path, FORMATS)]
    return files.atomic_write(path, lambda place: write(dataset, place))


def read(path: str | os.PathLike[str]) -> xr.Dataset:
    """Read a dataset written by :func:`save` or the command line (.nc, .csv), identical to the one written.

    Raises InputError for an unknown extension, and for a file that is missing, damaged, changed or not written by
    squama. In files without a hash some damage stays unnoticed.
    """
    files.place(path, "curve.nc")
    reader = FORMATS[extension(path, FORMATS)][1]
    with warnings.catch_warnings():
        # warnings of libraries about a damaged file add nothing to the error
        warnings.simplefilter("ignore")
        warnings.simplefilter("error", RuntimeWarning)
        return reader(path)


def extension(path: str | os.PathLike[str], allowed: Iterable[str]) -> str:
    """Return the extension of a path in lower case; refuse one that is not allowed."""
    found = Path(path).suffix.lower()
    known = list(allowed)
    if found in known:
        return found
    reason = f"the extension {files.label(found)} is not known" if found else "has no extension"
    raise InputError(Problem("", "", reason, f"allowed: {', '.join(known)}", files.label(path) or '""'))


def check_place(path: str | os.PathLike[str], allowed: Iterable[str] = ()) -> None:
    """Refuse a path that could not be written, before any work for it; ``allowed`` extensions, all if empty."""
    if known := list(allowed):
        extension(path, known)
    files.try_place(path)


def write_csv(dataset: xr.Dataset, place: Path) -> None:
    """Write a dataset to a new CSV file; refusals as of :func:`csv_text`."""
    place.write_text(csv_text(dataset), encoding="utf-8", newline="")


def csv_text(dataset: xr.Dataset) -> str:
    """Return a dataset as CSV; refuse one without rows, or with types that have no text form, such as dates."""
    sizes = _rows(dataset)
    if not sizes or not all(sizes.values()):
        refuse("", "", "the dataset has no points, so a CSV file of it would have no rows", "write a .nc file")
    lines = [CSV_MARK, f"# sizes: {json.dumps(sizes)}"]
    lines += [f"# attribute {key}: {_json(value)}" for key, value in dataset.attrs.items()]
    columns: dict[str, list[str]] = {}
    # the load of a point before the number of a scale
    coordinates = sorted(dataset.coords, key=lambda name: dataset[name].dims == (name,))
    for name in (*coordinates, *dataset.data_vars):
        variable = dataset.variables[name]
        role = "coordinate" if name in dataset.coords else "variable"
        if variable.dtype.kind not in _CAST:
            refuse(str(name), "", f"values of type {variable.dtype} cannot be written to CSV", "write a .nc file")
        about = {
            "dims": list(variable.dims),
            "dtype": variable.dtype.str[1:] if variable.dtype.kind == "U" else str(variable.dtype),
            "attrs": variable.attrs,
        }
        along = {*variable.dims}
        if along == {*sizes} or ({_POINT, name} & along and along <= {*sizes}):
            unit = variable.attrs.get("units")
            about["header"] = header = f"{name} ({unit})" if unit else str(name)
            others = {dim: size for dim, size in sizes.items() if dim not in along}
            whole = dataset[name].reset_coords(drop=True).expand_dims(others).transpose(*sizes)
            flat = whole.values.ravel().tolist()
            # text that reads back to the last bit
            columns[header] = flat if variable.dtype.kind == "U" else [repr(value).lower() for value in flat]
        else:
            about = {"value": _finite(variable.values.tolist()), **about}
        lines.append(f"# {role} {name}: {_json(about)}")
    rows = io.StringIO()
    tabular.write(rows, [columns, *zip(*columns.values(), strict=True)])
    comments = "\n".join(lines)
    digest = _hash(f"{comments}\n{rows.getvalue()}")
    return f'{comments}\n{CSV_HASH}"{digest}"\n{rows.getvalue()}'


def _rows(dataset: xr.Dataset) -> dict[str, int]:
    """Return the dimensions of a table's rows: points and their scales; all dimensions of a dataset without points."""
    every = [v.dims for v in dataset.variables.values() if _POINT in v.dims]
    every = [dims for dims in every if "scale" in dims] or every
    over = {dim for dims in every for dim in dims} or {*dataset.dims}
    return {str(dim): int(size) for dim, size in dataset.sizes.items() if dim in over}


def _json(value: object) -> str:
    """Return JSON in which no cell begins like a formula when a spreadsheet splits it at commas."""
    return _JOINED.sub(lambda found: f"{found[1]}\\u{ord(found[2]):04x}", _encode(value))


def _hash(text: str) -> str:
    """Return the hash of a CSV file's lines without the line of the hash; independent of the kind of line ends."""
    lines = re.sub(r"\r\n?", "\n", text).rstrip().split("\n")
    kept = "\n".join(line for line in lines if not line.startswith(CSV_HASH))
    return hashlib.sha256(kept.encode()).hexdigest()


def read_csv(path: str | os.PathLike[str]) -> xr.Dataset:
    """Read a file of :func:`write_csv`; errors as from :func:`squama.read`, with the line."""
    text = files.read_text(path, limit=tabular.LARGEST_TABLE)
    table = tabular.parse(text, files.label(path))
    if not table.comments or table.comments[0] != CSV_MARK:
        remedy = "measured points are given with --data, designs to squama ends"
        refuse("", "", "was not written by squama --csv", remedy, table.name)
    import xarray as xr

    sizes: dict[str, int] = {}
    attrs: dict[str, object] = {}
    found: dict[str, dict[str, tuple[list[str], Array, dict[str, object]]]] = {"coordinate": {}, "variable": {}}
    digest, digest_line = "", 0
    for number, line in enumerate(table.comments[1:], start=2):
        with _damage(table, number):
            alone, role, key, entry = _LINE.fullmatch(line).groups()  # type: ignore[union-attr]
            value = json.loads(entry)
            if alone == "sha256":
                digest, digest_line = value, number
            elif alone == "sizes":
                sizes = {str(dim): int(size) for dim, size in value.items()}
                _check_rows(table, sizes)
            elif role == "attribute":
                attrs[key] = value
            else:
                found[role][key] = _variable(table, value, sizes, entry.count(",") + 1)
    with _damage(table, table.header.line):
        dataset = xr.Dataset(found["variable"], coords=found["coordinate"], attrs=attrs)
    if digest and digest != _hash(text):
        reason = "is damaged: the file is not as squama wrote it, by its hash"
        raise table.error(digest_line, reason, "write the file anew, or remove this line if it was changed on purpose")
    return dataset


@contextmanager
def _damage(table: tabular.Table, line: int) -> Iterator[None]:
    """Turn any error about a line into an InputError that names the line."""
    try:
        yield
    except InputError:
        raise
    except Exception:  # damage shows itself in NumPy and xarray as errors of many kinds
        raise table.error(line, "is damaged: squama did not write it like this", "write the file anew") from None


def _check_rows(table: tabular.Table, sizes: dict[str, int]) -> None:
    """Refuse a truncated table."""
    rows = math.prod(sizes.values())
    if len(table.rows) != rows:
        last = (table.rows or [table.header])[-1].line
        reason = f"the table ends here and has {len(table.rows)} rows where squama wrote {rows}"
        raise table.error(last, reason, "write the file anew")
    for row in table.rows:
        Problems(tabular.ragged(table, row)).settle()


def _variable(
    table: tabular.Table, about: dict[str, Any], sizes: dict[str, int], most: int
) -> tuple[list[str], Array, dict[str, object]]:
    """Return dimensions, values and attributes of a variable from its comment (``most`` values) and its column."""
    dims, dtype = list(about["dims"]), np.dtype(about["dtype"])
    cast = _CAST[dtype.kind]
    if dtype.itemsize * max(most, len(table.rows)) > LARGEST:
        raise ValueError
    if "header" not in about:
        return dims, np.array(about["value"], dtype), about["attrs"]
    place = table.header.cells.index(about["header"])
    read = {"true": True, "false": False}.__getitem__ if dtype.kind == "b" else cast
    cells: list[object] = []
    for row in table.rows:
        try:
            cells.append(read(row.cells[place]))
        except (KeyError, ValueError):
            reason, cell = "is not as squama wrote it", tabular.shown_cell(row.cells[place])
            raise table.error(row.line, reason, "write the file anew", about["header"], cell) from None
    # values of a point are repeated in the row of each of its scales
    values = np.array(cells, dtype).reshape(list(sizes.values()))[tuple(slice(None) if d in dims else 0 for d in sizes)]
    order = [dim for dim in sizes if dim in dims]
    return dims, values.transpose([order.index(dim) for dim in dims]), about["attrs"]


def _finite(value: object) -> object:
    """Return nested numbers with NaN and infinity as text, because JSON has no numbers for them."""
    if isinstance(value, list):
        return [_finite(item) for item in value]
    return repr(value) if isinstance(value, float) and not np.isfinite(value) else value


def write_netcdf(dataset: xr.Dataset, place: Path) -> None:
    """Write a dataset to a new netCDF file."""
    lists = [str(key) for key, v in dataset.attrs.items() if isinstance(v, list) for _ in range(np.ndim(v))]
    marked = dataset.assign_attrs({NETCDF_MARK: 2, **({NETCDF_LISTS: " ".join(lists)} if lists else {})})
    # the encoding of an earlier file (chunks, fill values) is no part of the data; on a full disk HDF5 would end the
    # process
    made = io.BytesIO()
    marked.drop_encoding().to_netcdf(made, engine="h5netcdf", format="NETCDF4")
    # readers of HDF5 ignore bytes after its end
    place.write_bytes(files.sealed(made.getvalue()))


def read_netcdf(path: str | os.PathLike[str]) -> xr.Dataset:
    """Read a file of :func:`write_netcdf`; errors as from :func:`squama.read`."""
    size = files.regular(path)
    head = files.read_bytes(path, 64)
    if head[: len(_SIGNATURE)] != _SIGNATURE:
        raise _refused(path, "is no netCDF-4 file")
    # the place of the file's end address depends on the version of the superblock
    noted = {0: 40, 1: 44}.get(head[8], 28) if len(head) == 64 else 64
    if noted == 64 or int.from_bytes(head[noted : noted + 8], "little") > size:
        raise _refused(path, "is damaged: it is cut off")
    data = files.read_bytes(path, size)
    with suppress(ValueError):
        data = files.unsealed(data)
    sealed = len(data) < size
    begin, end = files.SEAL.split(b"%s")
    if data[-files.SEALED :].startswith(begin) and data.endswith(end):
        raise _refused(path, "is damaged: squama did not write it like this, by its hash")
    try:
        if not sealed:
            # damage may make the library hang, so a process that can be killed reads first
            code = "import sys; from squama.io import datasets; datasets.stored(sys.argv[1])"
            subprocess.run([sys.executable, "-c", code, path], check=True, capture_output=True, timeout=_HANGS)
        dataset = stored(path)
    except InputError:
        raise
    except Exception:  # damage shows itself in h5py and xarray as errors of many kinds
        raise _refused(path, "is damaged: it cannot be read to its end") from None
    if (mark := dataset.attrs.pop(NETCDF_MARK, None)) not in (1, 2):
        raise _refused(path, "was not written by this version of squama")
    if mark == 2 and not sealed:
        reason = "is damaged or was changed: the hash that squama wrote at its end is missing"
        raise _refused(path, reason, f", or set its attribute {NETCDF_MARK} to 1 if it was changed on purpose")
    return dataset


def stored(path: str | os.PathLike[str]) -> xr.Dataset:
    """Return the dataset of a netCDF file with squama's mark; refuse values far larger than the file."""
    import h5netcdf
    import xarray as xr

    with h5netcdf.File(os.fspath(path), "r") as file:
        size = sum(math.prod(v.shape) * v.dtype.itemsize for v in file.variables.values())
    if size > max(LARGEST, 2 * Path(path).stat().st_size):
        raise _refused(path, f"would take {size / 1e9:.3g} GB of memory, {LARGEST / 1e9:g} GB at most")
    with xr.open_dataset(Path(path), engine="h5netcdf", decode_times=False) as opened:
        dataset = opened.load()
    for variable in dataset.variables.values():
        variable.attrs = {key: _plain(value) for key, value in variable.attrs.items()}
    lists = dataset.attrs.pop(NETCDF_LISTS, "").split()
    dataset.attrs = {
        key: np.array(value, ndmin=lists.count(key)).tolist() if key in lists else _plain(value)
        for key, value in dataset.attrs.items()
    }
    for key in [key for key, value in dataset.variables.items() if value.dtype == object]:
        dataset[key] = dataset[key].astype(str)
    return dataset.drop_encoding()


def _plain(value: object) -> object:
    """Return an attribute as it was saved, because HDF5 returns NumPy scalars."""
    return value.item() if isinstance(value, np.generic | np.ndarray) and value.ndim == 0 else value


def _refused(path: str | os.PathLike[str], reason: str, or_else: str = "") -> InputError:
    remedy = f"write it anew with squama.save or --netcdf{or_else}"
    return InputError(Problem("", "", reason, remedy, files.label(path)))


FORMATS: dict[str, tuple[Callable[[xr.Dataset, Path], None], Callable[[str | os.PathLike[str]], xr.Dataset]]] = {
    ".nc": (write_netcdf, read_netcdf),
    ".csv": (write_csv, read_csv),
}
"""Writer and reader by extension; a new row adds a format."""

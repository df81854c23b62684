"""Sheets of an Excel workbook (.xlsx) as rows of text, by openpyxl; memory and size are bounded.

openpyxl yields the rows as it reads them, so a sheet with two cells far apart needs little memory.
"""

from __future__ import annotations

import io
import warnings
import zipfile
from collections.abc import Iterator
from typing import Any, NamedTuple

from squama.errors import InputError, refuse
from squama.io.tabular import Row
from squama.needs import need
from squama.units import shown

LARGEST = 100_000_000
"""Largest size of all parts of a workbook, unpacked, bytes."""
ROWS, CELLS = 200_000, 2_000_000
"""Largest row number of a sheet, and largest number of cells of all sheets."""
_ZIP, _OLD = b"PK\x03\x04", b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1"


class Grid(NamedTuple):
    """The rows of a sheet with text; ``name``: file and sheet in messages."""

    name: str
    title: str
    rows: list[Row]


def is_one(data: bytes) -> bool:
    """Return whether the bytes of a file begin as those of a workbook."""
    return data.startswith((_ZIP, _OLD))


def read(data: bytes, name: str) -> list[Grid]:
    """Return the sheets of a workbook that have text; refuse other files, and workbooks that are too large."""
    if data.startswith(_OLD):
        refuse("", "", "is a workbook of an old Excel (.xls)", "save it as .xlsx or as CSV", name)
    openpyxl = need("openpyxl")
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as packed:
            size = sum(part.file_size for part in packed.infolist())
            found = {part.filename for part in packed.infolist()}
    except (zipfile.BadZipFile, OSError, ValueError, NotImplementedError):
        refuse("", "", "is a damaged workbook", "save it again, or as CSV", name)
    if "xl/workbook.xml" not in found:
        refuse("", "", "is a packed file, but no workbook of Excel", "save it as .xlsx or as CSV", name)
    if size > LARGEST:
        refuse("", "", f"unpacks to {size:,} bytes ({LARGEST:,} at most)", "save the table alone, as CSV", name)
    try:
        with warnings.catch_warnings():
            # warnings about styles, validation rules and pictures, which are not read
            warnings.simplefilter("ignore")
            book = openpyxl.load_workbook(io.BytesIO(data), read_only=True, data_only=True, keep_links=False)
            sheets = [sheet for sheet in book.worksheets if sheet.sheet_state == "visible"]
            grids = [Grid(place := f"{name}: sheet {shown(s.title)}", s.title, list(_rows(s, place))) for s in sheets]
    except InputError:
        raise
    except Exception:  # damage shows itself in openpyxl and its readers as errors of many kinds
        refuse("", "", "is a damaged workbook", "save it again, or as CSV", name)
    filled = [grid for grid in grids if grid.rows]
    if not filled:
        remedy = "give a sheet with a header and a row for each point; open and save it where formulas have no values"
        refuse("", "", "has no sheet with values", remedy, name)
    if sum(len(row.cells) for grid in filled for row in grid.rows) > CELLS:
        refuse("", "", f"has more than {CELLS:,} cells", "save the table alone, as CSV", name)
    return filled


def _rows(sheet: Any, place: str) -> Iterator[Row]:
    """Yield the rows of a sheet with values, as text; refuse a sheet with too many rows."""
    sheet.reset_dimensions()
    for number, values in enumerate(sheet.iter_rows(values_only=True), 1):
        if number > ROWS:
            refuse("", "", f"has more than {ROWS:,} rows", "thin it out, or save it as CSV", place)
        cells = ["" if value is None else str(value) for value in values]
        if any(cell.strip() for cell in cells):
            yield Row(number, cells)

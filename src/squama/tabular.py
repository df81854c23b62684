"""Reading tables of text: header, delimiter, and rows that know the line they stand in."""

from __future__ import annotations

import csv
import difflib
import math
import os
import re
from collections.abc import Iterable, Iterator
from typing import NamedTuple

from squama import files
from squama.errors import InputError
from squama.units import shown

LARGEST_TABLE = 500_000_000
DELIMITERS = (",", ";", "\t")
_DECIMAL_COMMA = re.compile(r"\s*[+-]?\d*,\d+(?:[eE][+-]?\d+)?\s*")


class Row(NamedTuple):
    """The cells of one row, and the line it begins in (1 is the first line of the file)."""

    line: int
    cells: list[str]


class Table(NamedTuple):
    """A table of text: its file's name for messages, its leading comments, header and rows."""

    name: str
    delimiter: str
    comments: list[str]
    header: Row
    rows: list[Row]

    def error(self, line: int, text: str) -> InputError:
        """Return the error that names the file and the line."""
        return InputError(f"{self.name}: line {line}: {text}")


def read(path: str | os.PathLike[str], *, missing: str = "check the name") -> Table:
    """Read a table of text with one line of header.

    Parameters
    ----------
    path : path
        The file: UTF-8, cells set apart by comma, semicolon or tab; leading lines that start with "#" are comments.
    missing : str
        What to do if there is no such file; the end of that message.

    Returns
    -------
    Table
        Header cells are stripped, others are as they stand in the file; rows without any text are left out.

    Raises
    ------
    InputError
        The file cannot be read as text, has no header, or a quote in it is not closed.
    """
    return parse(files.read_text(path, limit=LARGEST_TABLE, missing=missing), files.label(path))


def parse(text: str, name: str) -> Table:
    """Read a table from the text of a file; ``name`` is the file's in messages, the rest as :func:`read`."""
    lines = text.replace("\r\n", "\n").replace("\r", "\n").split("\n")
    first = 0
    while first < len(lines) and (not lines[first].strip() or lines[first].startswith("#")):
        first += 1
    comments = [line for line in lines[:first] if line.startswith("#")]
    if first == len(lines):
        message = f"{name}: has comments only; give a header and a row for each point"
        raise InputError(message)
    delimiter = max(DELIMITERS, key=lines[first].count)
    try:
        rows = list(_rows(lines, first, delimiter))
    except csv.Error as error:
        found = csv_error_line(lines, first, delimiter)
        message = f"{name}: line {found}: is not a row of a table ({error}); check its quotes"
        raise InputError(message) from None
    header = Row(rows[0].line, [cell.strip() for cell in rows[0].cells])
    return Table(name, delimiter, comments, header, rows[1:])


def _rows(lines: list[str], first: int, delimiter: str) -> Iterator[Row]:
    reader = csv.reader((f"{line}\n" for line in lines[first:]), delimiter=delimiter, strict=True)
    begins = first + 1
    for cells in reader:
        if any(cell.strip() for cell in cells):
            yield Row(begins, cells)
        begins = first + reader.line_num + 1


def csv_error_line(lines: list[str], first: int, delimiter: str) -> int:
    """Return the line in which the row begins that the csv module refuses."""
    last = first + 1
    rows = _rows(lines, first, delimiter)
    try:
        for row in rows:
            last = row.line + 1 + sum(cell.count("\n") for cell in row.cells)
    except csv.Error:
        pass
    return last


def no_header(table: Table, wanted: str) -> InputError:
    """Return the error for a table whose first line names none of the columns that are needed."""
    cells = table.header.cells
    text = shown(table.delimiter.join(cells))
    try:
        [float(cell) for cell in cells]
    except ValueError:
        what, remedy = f"the header {text} has none of the columns that are needed", "write a header like:"
    else:
        what, remedy = f"{text} are numbers where the header must stand", "write above them a line like:"
    return table.error(table.header.line, f"{what}; {remedy} {wanted}")


def ragged(row: Row, width: int) -> str | None:
    """Say that a row has not as many cells as the header; None if it has."""
    if len(row.cells) == width:
        return None
    have = f"{len(row.cells)} cell{'s' * (len(row.cells) != 1)}"
    return f"has {have}, the header has {width}; give one for each column"


def number(cell: str, example: str = "0.25") -> float:
    """Return a finite number, or refuse the cell with the value and what to write (a ValueError's text)."""
    try:
        value = float(cell)
    except ValueError:
        value = math.nan
        if not cell.strip():
            message = f"is empty; write e.g. {example}"
        elif _DECIMAL_COMMA.fullmatch(cell):
            message = f"has a decimal comma; write {cell.strip().replace(',', '.')}"
        else:
            message = f"is not a number; write e.g. {example}"
        raise ValueError(message) from None
    if "_" in cell:
        message = "is not a number; write it without _"
        raise ValueError(message)
    if not math.isfinite(value):
        message = f"is not a finite number; write e.g. {example}"
        raise ValueError(message)
    return value


def where(column: str, cell: str) -> str:
    """Return the place of a cell as messages name it: its column and its value."""
    text = cell.strip()
    try:
        float(text)
    except ValueError:
        text = shown(text)
    return f"{column} = {text}"


def guess(name: str, known: Iterable[str]) -> str:
    """Return "did you mean ...? " for a misspelt name, or nothing."""
    by_fold = {other.casefold(): other for other in known}
    close = difflib.get_close_matches(name.casefold(), list(by_fold), n=1)
    return f"did you mean {by_fold[close[0]]}? " if close else ""

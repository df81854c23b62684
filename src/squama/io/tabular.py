"""Reading and writing of tables of text: header, delimiter, and rows with their line numbers."""

from __future__ import annotations

import csv
import difflib
import math
import os
import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import NamedTuple, TextIO

from squama.errors import InputError, Problem, Problems, refuse
from squama.io import files
from squama.units import is_number, shown

LARGEST_TABLE = 500_000_000
DELIMITERS = (";", "\t", ",")
"""Marks between cells; of two that are equally frequent the first, because a comma may belong to numbers or names."""
_FORMULA = re.compile(r"'*[=+\-@\t\r\n](?s:.)")
DECIMAL_COMMA = re.compile(r"\s*[+-]?\d*,\d+(?:[eE][+-]?\d+)?\s*")


class Row(NamedTuple):
    """The cells of a row, and its first line in the file (from 1)."""

    line: int
    cells: list[str]


class Table(NamedTuple):
    """A table of text: its file's name for messages, delimiter, leading comments, header and rows."""

    name: str
    delimiter: str
    comments: list[str]
    header: Row
    rows: list[Row]

    def line(self, number: int | None = None) -> str:
        """Return file and line (by default the header's) as the source of a problem."""
        return f"{self.name}: line {self.header.line if number is None else number}"

    def error(self, line: int | None, reason: str, remedy: str = "", where: str = "", value: str = "") -> InputError:
        """Return an error that names the file and the line."""
        return InputError(Problem(where, value, reason, remedy, self.line(line)))


def read(path: str | os.PathLike[str], *, missing: str = "check the name") -> Table:
    """Read a table of text: leading comments ("#"), a header line, cells separated by comma, semicolon or tab.

    Header cells are stripped; other cells stay as in the file, without the ' that :func:`write` puts before a formula.
    Rows without text are left out. ``missing``: remedy for a missing file. Refuses an empty file, a missing header, an
    open quote.
    """
    return parse(files.read_text(path, limit=LARGEST_TABLE, missing=missing), files.label(path))


def parse(text: str, name: str) -> Table:
    """Read a table from the text of a file; ``name``: the file in messages; otherwise as :func:`read`."""
    lines = text.replace("\r\n", "\n").replace("\r", "\n").split("\n")
    first = next((i for i, line in enumerate(lines) if line.strip() and not line.startswith("#")), None)
    comments = [line for line in lines[:first] if line.startswith("#")]
    if first is None:
        refuse("", "", "has comments only", "give a header and a row for each point", name)
    delimiter = max(DELIMITERS, key=lines[first].count)
    header, *found = rows(lines, first, delimiter, name)
    return Table(name, delimiter, comments, Row(header.line, [cell.strip() for cell in header.cells]), found)


def rows(lines: list[str], first: int, delimiter: str, name: str) -> Iterator[Row]:
    """Yield the rows with text from line ``first`` (from 0) on; refuse an open quote. ``name``: file in messages."""
    reader = csv.reader((f"{line}\n" for line in lines[first:]), delimiter=delimiter, strict=True)
    begins = first + 1
    try:
        for cells in reader:
            if any(cell.strip() for cell in cells):
                yield Row(begins, [cell[1:] if cell[:1] == "'" and _FORMULA.match(cell, 1) else cell for cell in cells])
            begins = first + reader.line_num + 1
    except csv.Error as error:
        refuse("", "", f"is not a row of a table ({error})", "check its quotes", f"{name}: line {begins}")


def write(file: TextIO, rows: Iterable[Iterable[object]], delimiter: str = ",") -> None:
    """Write rows of cells, the header included.

    Text that a spreadsheet would run as a formula gets a leading ', which :func:`read` removes; numbers stay.
    """
    writer = csv.writer(file, delimiter=delimiter, lineterminator="\n")
    writer.writerows(map(_guarded, row) for row in rows)


def _guarded(cell: object) -> str:
    text = str(cell)
    return f"'{text}" if _FORMULA.match(text) and not is_number(text) else text


def no_header(table: Table, wanted: str) -> InputError:
    """Return the error for a table whose first line names none of the needed columns."""
    cells = table.header.cells
    text = shown(table.delimiter.join(cells))
    what, remedy = f"the header {text} has none of the columns that are needed", "write a header like:"
    if all(map(is_number, cells)):
        what, remedy = f"{text} are numbers where the header must stand", "write above them a line like:"
    return table.error(None, what, f"{remedy} {wanted}")


def ragged(table: Table, row: Row) -> list[Problem]:
    """Return the mistake of a row with another number of cells than the header; else an empty list."""
    width, have = len(table.header.cells), len(row.cells)
    if have == width:
        return []
    cells = f"{have} cell{'s' * (have != 1)}"
    return [Problem("", "", f"has {cells}, the header has {width}", "give one for each column", table.line(row.line))]


def number(cell: str, example: str = "0.25", gap: str = "") -> float:
    """Return a finite number from a cell, or refuse it; the caller adds its place (`squama.errors.naming`).

    ``gap``: remedy for a cell that is empty or not finite, in place of the example.
    """
    remedy = f"write e.g. {example}"
    try:
        value = float(cell)
        if math.isfinite(value) and "_" not in cell:
            return value
        reason = "is not a finite number"
    except ValueError:
        reason = "is not a number" if cell.strip() else "is empty"
    if "_" in cell:
        reason, remedy = "is not a number", "write it without _"
    elif DECIMAL_COMMA.fullmatch(cell):
        reason, remedy = "has a decimal comma", f"write {cell.strip().replace(',', '.')}"
    elif gap and reason != "is not a number":
        # an example would not help with a missing value
        remedy = gap
    raise InputError(Problem("", shown_cell(cell), reason, remedy))


def numbers(
    table: Table, columns: Mapping[str, tuple[int, Callable[[str], float]]], noun: str
) -> tuple[list[Row], list[list[float]], Problems]:
    """Read columns of numbers; ``columns``: by name, the place and the function that reads a cell.

    Returns the rows without mistakes, their numbers (a list for each row), and the mistakes of the others. Refuses a
    table without rows; ``noun``: the object of a row.
    """
    if not table.rows:
        refuse("", "", "has a header but no rows", f"give one for each {noun}", table.name)
    rows, values, problems = [], [], Problems()
    for row in table.rows:
        wrong, found = ragged(table, row), []
        for name, (place, read_cell) in columns.items() if not wrong else ():
            try:
                found.append(read_cell(row.cells[place]))
            except InputError as error:
                wrong += error.at(name, table.line(row.line)).problems
        problems += wrong
        if not wrong:
            rows.append(row)
            values.append(found)
    return rows, values, problems


def shown_cell(cell: str) -> str:
    """Return a cell for a message: a number unchanged, text in quotes."""
    text = cell.strip()
    return text if is_number(text) else shown(text)


def close(name: str, known: Iterable[str]) -> str:
    """Return the known name most similar to a misspelt one, or ""."""
    by_fold = {other.casefold(): other for other in known}
    return next((by_fold[found] for found in difflib.get_close_matches(name.casefold(), list(by_fold), n=1)), "")


def guess(name: str, known: Iterable[str], form: str = "{}") -> str:
    """Return "did you mean ...? " for a misspelt name, or ""."""
    meant = close(name, known)
    return f"did you mean {form.format(meant)}? " if meant else ""

"""Tables as laboratories write them, in one form: a header with units, rows of cells, and their blocks.

Missing information is guessed from the text, and the guess is kept in words: encoding, lines above the header, a second
line of units. Line numbers stay those of the file. Blocks are rows between blank lines or repeated headers.
"""

from __future__ import annotations

import csv
import os
import re
from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

from squama.errors import refuse
from squama.io import files, headers, numerals, tabular, workbook
from squama.io.headers import split
from squama.io.tabular import Row, Table
from squama.units import shown

LARGEST, ROWS = 100_000_000, 1_000_000
"""Largest number of bytes, and of lines, of a table."""
COMMENTS = ("#", "%", "//")
"""Marks at the start of a comment line."""
LOOK = 100
"""Number of lines that are searched for a header."""
COLUMNS = 256
"""Largest number of columns of a table."""
SPACES = " "
"""Delimiter that stands for any white space between cells."""
_LONGEST = 100_000
"""Largest number of characters of a line in the search for a header."""
_SEPARATOR = re.compile(r'"?sep=(.)"?\s*', re.IGNORECASE)
_FIRST = re.compile(r"[;,\t\s]")
_APART = re.compile(r"\s{2,}|\t")
_CELLS = re.compile(r"\s+(?=[^()\[\]]*(?:[(\[]|$))(?![(\[])")
_PART = re.compile(r",\s*(?=[^,=]+=)")


class Sheet(NamedTuple):
    """A table with a unit in each cell of its header, where the file has one.

    ``blocks``: number of each row's block; ``said``: guesses in words; ``title``: name of a workbook's sheet;
    ``headless``: whether the file has no header (its cells are then the columns' numbers).
    """

    table: Table
    blocks: list[int]
    said: list[str]
    title: str = ""
    headless: bool = False


class _Asked(NamedTuple):
    """Names of columns that identify a header, and new names of columns by old name or number."""

    known: set[str]
    renamed: dict[str, str]

    @property
    def numbered(self) -> bool:
        """Whether columns get new names, all by their numbers."""
        return bool(self.renamed) and all(old.isdecimal() for old in self.renamed)

    def knows(self, cells: Sequence[str]) -> bool:
        """Return whether cells name a quantity, have a unit of one, or get new names."""
        names = {split(cell)[0] for cell in cells} | {cell.strip() for cell in cells}
        if names & {old for old in self.renamed if not old.isdecimal()}:
            return True
        return any(name in self.known or name.casefold() in self.known for name in names) or any(
            map(headers.named, cells)
        )


def read(path: str | os.PathLike[str], known: set[str], columns: str | Mapping[str, str] | None = None) -> list[Sheet]:
    """Read a table in UTF-8, UTF-16 or latin-1, or the sheets of a workbook that hold tables.

    Comment lines may stand anywhere in text. ``known``: names of columns that identify a header; ``columns``: new names
    by name or number (from 1): "Winkel=total (deg), 3=T (N mm)", or a mapping; without a unit the file's unit stays.
    """
    name, data, asked = files.label(path), files.read_bytes(path, LARGEST + 1), _Asked(known, _columns(columns))
    if workbook.is_one(data) and len(data) <= LARGEST:
        return _of_workbook(workbook.read(data, name), asked)
    text, encoding = files.any_text(path, data, limit=LARGEST)
    lines = text.replace("\r\n", "\n").replace("\r", "\n").split("\n")
    if len(lines) > ROWS:
        refuse("", "", f"has more than {ROWS:,} lines", "thin it out", name)
    separator = _SEPARATOR.fullmatch(lines[0])
    blank = {i for i, line in enumerate(lines, 1) if not line.strip(" ;,\t")}
    lines = ["" if _comment(line) or (separator and not i) else line for i, line in enumerate(lines)]
    for i in range(min(LOOK, len(lines))):
        # a header's cell in quotes may have several lines
        whole = next((n for n in range(1, 5) if "".join(lines[i : i + n]).count('"') % 2 == 0), 1)
        lines[i : i + whole] = [*[""] * (whole - 1), " ".join(lines[i : i + whole])]
    used = [i for i, line in enumerate(lines) if line.strip()][:LOOK]
    if not used:
        refuse("", "", "has comments only", "give a header and a row for each point", name)
    delimiter = separator[1] if separator else _delimiter([lines[i] for i in used])
    looked = [Row(i + 1, cells) for i, cells in zip(used, _cells([lines[i] for i in used], delimiter), strict=True)]
    _few(looked, name)
    head = _header(looked, asked)
    start = _first(looked) if head is None else head
    if delimiter == SPACES:
        found = zip(range(start, len(lines) + 1), _cells(lines[start - 1 :], delimiter), strict=True)
        rows = [Row(line, cells) for line, cells in found if cells]
    else:
        rows = list(tabular.rows(lines, start - 1, delimiter, name))
    said = [f"in {encoding}"] * (encoding not in {"utf-8", "utf-16"})
    made = _sheet(Table(name, delimiter, [], Row(start, []), rows), looked, head, blank, asked)
    return [_renamed(made._replace(said=said + made.said), asked.renamed)]


def _of_workbook(grids: Sequence[workbook.Grid], asked: _Asked) -> list[Sheet]:
    """Return the sheets of a workbook that have a table's header; the first sheet if none has."""
    sheets, others = list[Sheet](), list[str]()
    for grid in grids:
        looked = grid.rows[:LOOK]
        _few(looked, grid.name)
        head = _header(looked, asked)
        start = _first(looked) if head is None else head
        rows, lines = [row for row in grid.rows if row.line >= start], {row.line for row in grid.rows}
        blank = set(range(start, grid.rows[-1].line)) - lines
        if rows:
            made = _sheet(Table(grid.name, ";", [], Row(start, []), rows), looked, head, blank, asked)
            sheets.append(made._replace(title=grid.title))
    good = [
        s for s in sheets if asked.knows(s.table.header.cells) or (asked.numbered and _numeric(s.table.rows[0].cells))
    ]
    others = [shown(s.title) for s in sheets if s not in good]
    if good and others:
        good[0].said.append(f"without sheet{'s' * (len(others) > 1)} {', '.join(others)}")
    return [_renamed(sheet, asked.renamed) for sheet in good or sheets[:1]]


def _few(looked: Sequence[Row], name: str) -> None:
    """Refuse a table with too many columns, each of whose cells would be searched for a unit."""
    row = max(looked, key=lambda row: len(row.cells))
    if len(row.cells) > COLUMNS:
        reason = f"has {len(row.cells):,} cells in line {row.line} ({COLUMNS} at most)"
        refuse("", "", reason, "leave columns of twist and torque", name)


def _comment(line: str) -> bool:
    """Return whether a line is a comment; an error of a spreadsheet (#N/A) is none."""
    text = line.lstrip()
    return text.startswith(COMMENTS) and not numerals.is_gap(_FIRST.split(text, maxsplit=1)[0])


def _delimiter(lines: Sequence[str]) -> str:
    """Return the delimiter: the first of those that give most rows of numbers, or occur in most lines."""

    def numbers(delimiter: str) -> tuple[int, int]:
        rows = list(_cells(lines, delimiter))
        if delimiter == SPACES:
            rows = list(filter(_numbers, rows))
        return sum(_numeric(row) for row in rows), 0 if delimiter == SPACES else sum(delimiter in s for s in lines)

    return max((";", "\t", "|", SPACES, ","), key=numbers)


def _cells(lines: Sequence[str], delimiter: str) -> Iterator[list[str]]:
    """Yield the cells of each line; for white space, as many as the lines of numbers have."""
    if delimiter != SPACES:
        for line in lines:
            yield next(csv.reader([line[:_LONGEST]], delimiter=delimiter), [])
        return
    wide = [_APART.split(line.strip()) for line in lines]
    # one space may stand between thousands, or within a unit
    far = sum(map(_numbers, wide)) >= sum(_numbers(line.split()) for line in lines)
    plain = [cells if far else line.split() for cells, line in zip(wide, lines, strict=True)]
    width = max((len(cells) for cells in plain if _numeric(cells)), default=0)
    for line, cells, narrow in zip(lines, wide, plain, strict=True):
        if all(map(_value, narrow)):
            yield narrow if line.strip() else []
        else:
            ways = (cells, _CELLS.split(line.strip()), line.split())
            yield next((way for way in ways if len(way) == width), cells)


def _value(cell: str) -> bool:
    return numerals.is_number(cell) or numerals.is_gap(cell)


def _numeric(cells: Sequence[str]) -> bool:
    """Return whether a row has two or more numbers, or marks of missing values."""
    return sum(bool(cell.strip()) and _value(cell) for cell in cells) > 1


def _numbers(cells: Sequence[str]) -> bool:
    """Return whether all of several cells of a row are numbers, or marks of missing values."""
    return len(cells) > 1 and all(map(_value, cells))


def _first(looked: Sequence[Row]) -> int:
    """Return the line of the first row of numbers, else the first line."""
    return next((row.line for row in looked if _numeric(row.cells)), looked[0].line)


def _header(looked: Sequence[Row], asked: _Asked) -> int | None:
    """Return the line of the header: the first candidate with numbers below, or with units and numbers.

    Else the first candidate, or the text above the first numbers; None without a header.
    """
    texts = [(i, row) for i, row in enumerate(looked) if not any(map(numerals.is_number, row.cells))]
    for sure in (True, False):
        for i, row in texts:
            below = [one.cells for one in looked[i + 1 : i + 3]]
            if sure and not (below and (_numeric(below[0]) or (headers.units(below[0]) and _numeric(below[-1])))):
                continue
            # the names of a line of units stand above it
            if headers.units(row.cells) and not (i and _is_text(looked[i - 1])) and len(row.cells) > 1:
                return row.line
            if not headers.units(row.cells) and asked.knows(row.cells) and (sure or len(row.cells) > 1):
                return row.line
            if headers.units(row.cells) and i and _is_text(looked[i - 1]):
                return looked[i - 1].line
    i = next((i for i, row in enumerate(looked) if _numeric(row.cells)), len(looked))
    return looked[i - 1].line if i and _is_text(looked[i - 1]) else None


def _is_text(row: Row) -> bool:
    """Return whether a row has several cells and no numbers."""
    return sum(bool(cell.strip()) for cell in row.cells) > 1 and not any(map(numerals.is_number, row.cells))


def _sheet(table: Table, looked: Sequence[Row], head: int | None, blank: set[int], asked: _Asked) -> Sheet:
    """Return the sheet of a table whose rows begin with the header, if there is one."""
    first, *rows = table.rows
    if head is None:
        width = max(len(row.cells) for row in table.rows) if asked.numbered else 0
        numbers = [str(i + 1) for i in range(width)] or [cell.strip() for cell in first.cells]
        kept, blocks = _blocks(table.rows, numbers, [], blank)
        return Sheet(
            table._replace(header=Row(first.line, numbers), rows=kept), blocks, [], headless=not asked.numbered
        )
    cells, said = [" ".join(cell.split()) for cell in first.cells], []
    if skipped := sum(row.line < head for row in looked):
        said.append(f"without {skipped} line{'s' * (skipped > 1)} above the header")
    units: list[str] = []
    if headers.units(cells):
        cells = [f"({cell})" if cell else "" for cell in map(headers.symbol, cells)]
    elif rows and headers.units(rows[0].cells):
        units = rows.pop(0).cells
        said.append(f"with the units of line {table.rows[1].line}")
    kept, blocks = _blocks(rows, first.cells, units, blank)
    for i, unit in enumerate(map(headers.symbol, units[: len(cells)])):
        if unit and not split(cells[i])[1]:
            cells[i] = f"{cells[i]} ({unit})"
    return Sheet(table._replace(header=Row(first.line, cells), rows=kept), blocks, said)


def _blocks(rows: Sequence[Row], header: list[str], units: list[str], blank: set[int]) -> tuple[list[Row], list[int]]:
    """Return the rows of values and their block numbers, without repeated headers and titles of blocks."""
    kept, numbers, number = list[Row](), list[int](), 0
    heads = [_folded(cells) for cells in (header, units) if cells]
    line = rows[0].line if rows else 0
    for row in rows:
        apart = any(between in blank for between in range(line, row.line))
        line = row.line
        if _folded(row.cells) in heads:
            # text above a repeated header is its preamble
            while kept and numbers[-1] == number and not _numeric(kept[-1].cells):
                kept.pop()
                numbers.pop()
            number += 1
        elif apart and len(filled := [c for c in row.cells if c.strip()]) == 1 and not _value(filled[0]):
            number += 1
        else:
            number += apart
            kept.append(row)
            numbers.append(number)
    return kept, numbers


def _folded(cells: Sequence[str]) -> list[str]:
    return [" ".join(cell.split()).casefold() for cell in cells]


def _columns(given: str | Mapping[str, str] | None) -> dict[str, str]:
    """Return new names of columns by their names or numbers."""
    if isinstance(given, str):
        parts = [part.partition("=") for part in _PART.split(given)]
        if not all(old.strip() and new.strip() for old, _, new in parts):
            refuse("columns", shown(given), "does not name columns", 'write e.g. "Winkel=total (deg), 3=T (N mm)"')
        return {old.strip(): new.strip() for old, _, new in parts}
    return {str(old).strip(): new.strip() for old, new in (given or {}).items()}


def _renamed(sheet: Sheet, wanted: Mapping[str, str]) -> Sheet:
    """Return a sheet with the user's names in its header."""
    table = sheet.table
    cells = list(table.header.cells)
    own = [{str(i + 1), cell, split(cell)[0]} for i, cell in enumerate(table.header.cells)]
    for old, new in wanted.items():
        places = [i for i, names in enumerate(own) if old in names]
        if len(places) != 1:
            among = ", ".join(cell for cell in table.header.cells if cell)
            reason = f"{'several columns are' if places else 'no column is'} called {shown(old)} among {shown(among)}"
            raise table.error(None, reason, f"give names or numbers from 1 to {len(cells)}", "columns")
        name, unit = split(new)
        unit = unit or split(cells[places[0]])[1]
        # drop another column of the same name
        cells = ["" if split(cell)[0] == name else cell for cell in cells]
        cells[places[0]] = f"{name} ({unit})" if unit else name
    return sheet._replace(table=table._replace(header=table.header._replace(cells=cells)))

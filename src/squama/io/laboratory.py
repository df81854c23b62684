"""Tables as laboratories write them, brought to one form: a header with units, and decimal points.

What a file does not say is guessed from its text, and the guess is kept in words: encoding, decimal comma, lines above
the header, a second line of units. Line numbers stay those of the file.
"""

from __future__ import annotations

import csv
import os
import re
from collections.abc import Mapping, Sequence
from typing import NamedTuple

from squama.errors import InputError, Problem, refuse
from squama.io import files, tabular
from squama.units import Dimension, look_up, shown

COMMENTS = ("#", "%", "//")
"""What a line of comment begins with."""
LOOK = 100
"""Lines among which a header is looked for."""
_NUMBER = re.compile(r"[+-]?(?:\d+[.,]?\d*|[.,]\d+)(?:[eE][+-]?\d+)?")
_CELL = re.compile(r"(.*?)\s*(?:\((.*)\)|\[(.*)\])?")
_BRACKETS = re.compile(r"[(\[](.*)[)\]]")
_WORDS = {"U": "rev", "Umdr": "rev", "Umdr.": "rev", "Grad": "deg"}
"""Units in other words, which as symbols would mean something else."""
_PART = re.compile(r",\s*(?=[^,=]+=)")
MEASURED = (Dimension.ANGLE, Dimension.TORQUE, Dimension.TWIST_RATE, Dimension.TIME)


class Sheet(NamedTuple):
    """A table with a unit in each cell of its header, where the file gives one; ``said`` are the guesses in words."""

    table: tabular.Table
    said: list[str]


def split(cell: str) -> tuple[str, str]:
    """Return name and unit of a header's cell; no unit is empty.

    >>> split("Phi (deg/mm)"), split("Moment [N mm]"), split("T")
    (('Phi', 'deg/mm'), ('Moment', 'N mm'), ('T', ''))
    """
    match = _CELL.fullmatch(cell.strip())
    return (match[1], _unit(match[2] or match[3] or "")) if match else (cell, "")


def dimension(unit: str) -> Dimension | None:
    """Return the dimension of a unit: angle, torque, twist rate or time; None for any other."""
    found = look_up(unit) if unit else None
    return found[0] if found and found[0] in MEASURED else None


def read(path: str | os.PathLike[str], known: set[str], columns: str | Mapping[str, str] | None = None) -> Sheet:
    """Read a table, in UTF-8, UTF-16 with its mark, or latin-1; lines of comment may stand anywhere.

    ``known`` are names of columns by which a header is told, ``columns`` names columns anew, by their name or number
    (from 1): "Winkel=total (deg), 3=T (N mm)", or the same as a mapping; without a unit that of the file stays.
    """
    name, (text, encoding) = files.label(path), files.read_any_text(path, limit=tabular.LARGEST_TABLE)
    wanted = _columns(columns)
    lines = text.replace("\r\n", "\n").replace("\r", "\n").split("\n")
    first = [i for i, line in enumerate(lines) if line.strip()][:1]
    lines = ["" if line.lstrip().startswith(COMMENTS) else line for line in lines]
    used = [i for i, line in enumerate(lines) if line.strip()][:LOOK]
    if not used:
        refuse("", "", "has comments only" if first else "is empty", "give a header and a row for each point", name)
    delimiter = max(tabular.DELIMITERS, key=lambda d: sum(d in lines[i] for i in used))
    rows = {i: next(csv.reader([lines[i]], delimiter=delimiter), []) for i in used}
    head = _header(rows, known, wanted)
    said = [f"in {encoding}"] if encoding == "latin-1" else []
    if head is None:
        # numbers only: the columns go by their numbers
        numbers = delimiter.join(str(i + 1) for i in range(len(rows[used[0]])))
        table = tabular.parse("\n".join([numbers, *lines]), name, delimiter)
        table = table._replace(rows=[row._replace(line=row.line - 1) for row in table.rows])
        return Sheet(_renamed(table, [], wanted), said)
    if skipped := sum(i < head for i in used):
        said.append(f"without {skipped} line{'s' * (skipped > 1)} above the header")
    below = next((i for i in used if i > head), None)
    units: list[str] = []
    if below is not None and _units(rows[below]):
        units = [_unit(cell) for cell in rows[below]]
        lines[below] = ""
        said.append(f"with the units of line {below + 1}")
    table = tabular.parse("\n".join([*[""] * head, *lines[head:]]), name, delimiter)
    return Sheet(_renamed(table, units, wanted), said)


def number(cell: str, decimal: str, gap: str = "") -> float:
    """Read a number with the decimal sign ``decimal``, "." or ","; ``gap`` as in :func:`tabular.number`.

    >>> number("1,25e3", ","), number("-.5", ".")
    (1250.0, -0.5)
    """
    if decimal == ",":
        if "." in cell and tabular.number(cell.replace(".", "").replace(",", "."), gap=gap) is not None:
            reason = "has a point, but decimals are set off by commas here"
            raise InputError(Problem("", shown(cell.strip()), reason, "leave out points between thousands"))
        cell = cell.replace(",", ".")
    return tabular.number(cell, gap=gap)


def decimal_of(cells: Sequence[str], given: str | None) -> str:
    """Return the decimal sign of cells: as given; else a comma if some number has one and none has a point."""
    if given is not None:
        if given not in (".", ","):
            refuse("decimal", shown(given), 'must be "." or ","')
        return given
    commas = any(tabular.DECIMAL_COMMA.fullmatch(cell) for cell in cells)
    return "," if commas and not any("." in cell for cell in cells) else "."


def _columns(given: str | Mapping[str, str] | None) -> dict[str, str]:
    """Return the new names of columns by their names or numbers."""
    if isinstance(given, str):
        parts = [part.partition("=") for part in _PART.split(given)]
        if not all(old.strip() and new.strip() for old, _, new in parts):
            refuse("columns", shown(given), "does not name columns", 'write e.g. "Winkel=total (deg), 3=T (N mm)"')
        return {old.strip(): new.strip() for old, _, new in parts}
    return {str(old).strip(): new.strip() for old, new in (given or {}).items()}


def _header(rows: Mapping[int, Sequence[str]], known: set[str], wanted: Mapping[str, str]) -> int | None:
    """Return the line of the header, the first if there is no sign of another; None if there are numbers only."""
    before = None
    for i, cells in rows.items():
        names = {split(cell)[0] for cell in cells}
        if not any(map(_is_number, cells)):
            named = any(name in known or name.casefold() in known for name in names)
            if named or {old for old in wanted if not old.isdecimal()} & {*names, *(c.strip() for c in cells)}:
                return i
            if any(name and dimension(unit) for name, unit in map(split, cells)):
                return i
            if _units(cells) and before is not None:
                return before
        before = i
    first = next(iter(rows))
    return None if wanted and all(old.isdecimal() for old in wanted) and _is_number(rows[first][0]) else first


def _units(cells: Sequence[str]) -> bool:
    """Say whether a line holds units, and no numbers."""
    return not any(map(_is_number, cells)) and any(dimension(_unit(cell)) for cell in cells)


def _unit(text: str) -> str:
    """Return a unit without brackets, by its symbol."""
    text = text.strip()
    match = _BRACKETS.fullmatch(text)
    text = (match[1] if match else text).strip()
    return _WORDS.get(text, text)


def _is_number(cell: str) -> bool:
    return bool(_NUMBER.fullmatch(cell.strip()))


def _renamed(table: tabular.Table, units: Sequence[str], wanted: Mapping[str, str]) -> tabular.Table:
    """Return a table whose header has the units of a second line and the names that the user gives."""
    cells = list(table.header.cells)
    for i, unit in enumerate(units[: len(cells)]):
        if unit and not split(cells[i])[1]:
            cells[i] = f"{cells[i]} ({unit})"
    own = [{str(i + 1), cell, split(cell)[0]} for i, cell in enumerate(table.header.cells)]
    for old, new in wanted.items():
        places = [i for i, names in enumerate(own) if old in names]
        if len(places) != 1:
            among = ", ".join(cell for cell in table.header.cells if cell)
            reason = f"{'several columns are' if places else 'no column is'} called {shown(old)} among {shown(among)}"
            raise table.error(None, reason, f"give names or numbers from 1 to {len(cells)}", "columns")
        name, unit = split(new)
        unit = unit or split(cells[places[0]])[1]
        # another column of this name is not the one that is meant
        cells = ["" if split(cell)[0] == name else cell for cell in cells]
        cells[places[0]] = f"{name} ({unit})" if unit else name
    return table._replace(header=table.header._replace(cells=cells))

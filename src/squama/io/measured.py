"""Measured points of a test: a table of twist and torque, or of curvature and moment, in SI units.

The header names each column and its unit: ``Phi (deg/mm), T (N mm)``. The abscissa is an angle per length (``Phi``),
per pitch (``phi``) or of the whole beam (``total``).
"""

from __future__ import annotations

import os
import warnings
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from squama import arguments
from squama.errors import Problem, Problems, TableWarning, refuse
from squama.io import columns as quantities
from squama.io import files, headers, laboratory, numerals, tabular
from squama.io.columns import TIME, Ordinate, Reading, torque
from squama.io.numerals import DecimalName
from squama.loads import TESTS, LoadName
from squama.types import Array
from squama.units import Dimension, shown

SHOWN, _NAMED = 8, 5
"""Largest number of mistakes of a file, and of rows left out, that are named one by one."""
_REST, _FEW = 0.02, 3
"""Twist over the largest at which a loop may begin; least number of rows of a block."""
_GAP = "leave the cell empty where nothing was measured"


class Measured(NamedTuple):
    """Points in the order in which they were measured, of a whole file or of one specimen.

    ``rate``: twist rate or curvature (rad/m); ``load``: torque or bending moment (N m), for a decay time (s);
    ``label``: specimen or, for legends, file; ``file`` and ``lines``: source of the rows ("" and None without a file);
    ``names``: specimen of each row, where the table has several.
    """

    rate: Array
    load: Array
    label: str
    file: str = ""
    lines: Array | None = None
    names: Array | None = None

    def where(self, i: int) -> str:
        """Return the place of a point in messages."""
        if self.lines is None:
            return f"{self.label}: point {i}"
        return f"{self.file}: line {self.lines[i]}"

    def specimens(self) -> list[Measured]:
        """Return the points of each specimen, in the order of first occurrence; one specimen if none is named."""
        if self.names is None or self.lines is None:
            return [self]
        empty = (
            Problem("specimen", '""', "is empty", "name it", self.where(i))
            for i in np.flatnonzero(self.names == "").tolist()
        )
        _settle(Problems(empty), self.file)
        groups = ((name, self.names == name) for name in dict.fromkeys(self.names))
        return [Measured(self.rate[own], self.load[own], name, self.file, self.lines[own]) for name, own in groups]


def swings(path: str | os.PathLike[str], columns: str | Mapping[str, str] | None = None) -> bool:
    """Return whether a table is the record of a decay: a column of time and no torque or force."""
    names = {name for load in TESTS.values() for name in (*quantities.over(load), *torque(load).names)} | {*TIME.names}
    cells = [headers.split(cell) for cell in laboratory.read(path, names, columns)[0].table.header.cells]
    found = {headers.dimension(unit) for _, unit in cells}
    return Dimension.TIME in found and not found & {Dimension.TORQUE, Dimension.FORCE}


def read_measured(
    path: str | os.PathLike[str],
    beam: Any,
    *,
    load: LoadName = "twisting",
    decimal: DecimalName | None = None,
    columns: str | Mapping[str, str] | None = None,
) -> Measured:
    r"""Read measured points of a beam's test from a table of text.

    Parameters
    ----------
    path
        A table in UTF-8, UTF-16 or latin-1, with cells separated by semicolons, tabs, commas, bars or white space, or a
        workbook (.xlsx). Its header names each column and its unit, which may stand in a line below; comment lines
        begin with #, % or //.
    beam : Beam
        Its pitch and number of scales turn angles per pitch or of the whole beam into rates.
    load
        "twisting" or "bending".
    decimal
        Decimal sign, "." or ","; default: guessed.
    columns
        Names and units of columns by their names or numbers (from 1) in the file: "Winkel=total (deg), 3=T (N mm)", or
        a mapping. Default: columns are identified by name, else by unit; an angle is then the twist (bend) of the whole
        beam.

    Returns
    -------
    Measured
        ``rate`` (rad/m) and ``load`` (N m), arrays of one length, in the order of the rows.

    Raises
    ------
    InputError
        The table cannot be read; every mistake with file and line.

    Warns
    -----
    TableWarning
        One line that lists the guesses.

    Examples
    --------
    >>> import pathlib, tempfile, squama
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = pathlib.Path(folder, "test.csv")
    ...     _ = file.write_text("a;b\n90;1.5\n", encoding="utf-16")
    ...     found = read_measured(file, squama.Beam.from_ratios(), columns="a=total (deg), b=T (N mm)")
    >>> found.load
    array([0.0015])
    """
    files.place(path, "test.csv")
    arguments.beam(beam)
    given = {"pitch": beam.pitch, "scales": beam.pitches}
    return read(path, **given, load=arguments.load(load).name, decimal=decimal, columns=columns)


def read(
    path: str | os.PathLike[str],
    *,
    pitch: float,
    scales: int,
    load: str = "twisting",
    decimal: DecimalName | None = None,
    columns: str | Mapping[str, str] | None = None,
    ordinate: Ordinate | None = None,
) -> Measured:
    r"""Read measured points of a beam of ``scales`` scales at a ``pitch`` (m), otherwise as :func:`read_measured`.

    Columns of twisting: ``Phi`` or ``twist rate`` (rad/m, deg/mm ...), or ``phi`` or ``twist per pitch`` (deg ...), or
    ``total`` or ``total twist`` (deg ...), and ``T`` or ``torque`` (N m, N mm ...). Bending: ``kappa`` or
    ``curvature``, ``psi`` or ``bend per pitch``, ``total`` or ``total bend``, and ``M`` or ``moment``. A column
    ``specimen`` names the specimens. With :data:`TIME` as ``ordinate`` a column ``t`` or ``time`` replaces the torque.

    >>> import pathlib, tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = pathlib.Path(folder, "test.csv")
    ...     _ = file.write_text("specimen, Phi (rad/mm), T (N mm)\nA, 0.002, 40\nB, 0.002, 42\nA, 0.003, 44\n")
    ...     found = read(file, pitch=0.02, scales=25)
    >>> found[:3]
    (array([2., 2., 3.]), array([0.04 , 0.042, 0.044]), 'test')
    >>> [(s.label, s.load.tolist()) for s in found.specimens()]
    [('A', [0.04, 0.044]), ('B', [0.042])]
    """
    kind = TESTS[load]
    wanted = torque(kind) if ordinate is None else ordinate
    sheets = laboratory.read(path, {*quantities.over(kind), *wanted.names}, columns)
    found, said = [], list[str]()
    for sheet in sheets:
        one, guessed = _points(sheet, Reading(kind, wanted, pitch, scales, decimal), Path(files.label(path)).stem)
        found.append(one)
        said += [words for words in guessed if words not in said]
    if said:
        remedy = "if that is wrong, set decimal and columns"
        warnings.warn(f"{files.label(path)} is read {', '.join(said)}; {remedy}", TableWarning, stacklevel=2)
    return found[0] if len(found) == 1 else _joined(found, [sheet.title for sheet in sheets], files.label(path))


def _points(sheet: laboratory.Sheet, how: Reading, label: str) -> tuple[Measured, list[str]]:
    """Return the points of a sheet, and the guesses in words."""
    table = sheet.table
    if sheet.headless:
        raise quantities.no_header(table, how)
    places, length, guessed = quantities.places(table, how)
    cells = [table.header.cells[i] for i in places]
    factors, problems = [], Problems()
    for cell, span in zip(cells, (length, how.ordinate.dimension), strict=True):
        with problems.caught(source=table.line()):
            factors.append(quantities.factor(cell, span, how))
    problems.settle()
    if not table.rows:
        refuse("", "", "has a header but no rows", "give one for each point", table.name)
    columns = [[row.cells[i] for row in table.rows if i < len(row.cells)] for i in places]
    style = numerals.style(columns, how.decimal)
    rows, blocks, values, left = _values(sheet, dict(zip(cells, places, strict=True)), style)
    said = [*sheet.said, *style.said(given=how.decimal is not None), *guessed, *left]
    rate, load = (column * factor for column, factor in zip(np.array(values).T, factors, strict=True))
    lines = np.array([row.line for row in rows])
    own = _column(table, rows, lambda name, _: name.casefold() == "specimen")
    if own is None and (loops := _loops(rate, _in_order(table, rows, np.array(blocks), rate))).max() > 0:
        said.append(f"as {loops.max() + 1} loops")
        own = np.array([f"loop {i + 1}" for i in loops.tolist()], object)
    return Measured(rate, load, label, table.name, lines, own), said


def _values(
    sheet: laboratory.Sheet, places: Mapping[str, int], style: numerals.Style
) -> tuple[list[tabular.Row], list[int], list[list[float]], list[str]]:
    """Return the rows with values, their blocks and values as written, and in words those without one, or repeated."""
    table, width = sheet.table, len(sheet.table.header.cells)
    rows, blocks, values, problems = list[tabular.Row](), list[int](), list[list[float]](), Problems()
    gaps, again, before = list[int](), list[int](), list[str]()
    for row, block in zip(table.rows, sheet.blocks, strict=True):
        own = [row.cells[i] if i < len(row.cells) else "" for i in places.values()]
        short = table.delimiter == laboratory.SPACES and len(row.cells) < width
        if short or any(cell.strip() for cell in row.cells[width:]):
            problems += tabular.ragged(table, row)
        elif any(map(numerals.is_gap, own)):
            gaps.append(row.line)
        elif row.cells == before:
            again.append(row.line)
        else:
            found, wrong = list[float](), Problems()
            for cell, name in zip(own, places, strict=True):
                with wrong.caught(name, table.line(row.line)):
                    found.append(numerals.number(cell, style, _GAP))
            problems += wrong
            rows.append(row)
            blocks.append(block)
            values.append(found)
        before = row.cells
    widths = {len(row.cells) for row in table.rows}
    if table.delimiter == "," and len(table.rows) > 1 and len(problems) == len(table.rows) and widths == {2 * width}:
        reason = f"all rows have {2 * width} cells, the header has {width}: commas part both cells and decimals"
        raise table.error(table.rows[0].line, reason, "save it with semicolons or tabs between cells")
    _settle(problems, table.name)
    if not rows:
        among = " and ".join(map(shown, places))
        refuse("", "", f"no row has a value of both {among}", "check the columns", table.name)
    said = [f"without {_count(gaps)} that {'have' if len(gaps) > 1 else 'has'} no value"] * bool(gaps)
    said += [f"without {_count(again)} that repeat{'s' * (len(again) == 1)} the row before"] * bool(again)
    return rows, blocks, values, said


def _count(lines: list[int]) -> str:
    """Return the number of rows and their lines as text: "3 rows (lines 4, 5, 9)"."""
    where = ", ".join(map(str, lines[:_NAMED])) + " ..." * (len(lines) > _NAMED)
    return f"{len(lines)} row{'s' * (len(lines) > 1)} (line{'s' * (len(lines) > 1)} {where})"


def _loops(rate: Array, blocks: Array) -> Array:
    """Return the loop number (from 0) of each point, from the numbers of their blocks.

    A block begins a loop where its first twist is near 0, or nearer to 0 than to the end of the block before; else it
    continues that block. Where any block has only a few rows, blank lines are ignored.
    """
    starts = np.flatnonzero(np.diff(blocks, prepend=blocks[0] - 1))
    loops, near = np.zeros(rate.size, np.int64), _REST * float(np.abs(rate).max())
    sizes = np.diff([*starts, rate.size])
    if sizes.min() < _FEW:
        return loops
    for start in starts[1:].tolist():
        first, last = abs(rate[start]), abs(rate[start] - rate[start - 1])
        loops[start:] += int(first <= near or first < last)
    return loops


def _in_order(table: tabular.Table, rows: Sequence[tabular.Row], blocks: Array, rate: Array) -> Array:
    """Return block numbers of rows; a block is split where time restarts. Refuse rows that go back in time."""
    cells = _column(table, rows, headers.is_time)
    if cells is None or not all(map(numerals.is_number, cells)):
        return blocks
    style = numerals.style([cells.tolist()])
    t, first = np.array([numerals.number(cell, style) for cell in cells]), 0
    for i in (np.flatnonzero(np.diff(t) < 0) + 1).tolist():
        if blocks[i] == blocks[i - 1]:
            if t[i] > t[first] + _REST * float(np.ptp(t)):
                steps = np.diff(rate)
                sort = "the rows are sorted by the twist" if not (steps < 0).any() or not (steps > 0).any() else ""
                reason = f"the time goes back, from {cells[i - 1]} to {cells[i]}{f': {sort}' * bool(sort)}"
                raise table.error(rows[i].line, reason, "sort the rows by the time")
            blocks = blocks + (np.arange(blocks.size) >= i)
        first = i
    return blocks


def _column(
    table: tabular.Table, rows: Sequence[tabular.Row], wanted: Callable[[str, str], bool]
) -> NDArray[np.object_] | None:
    """Return the cells of the first column whose name and unit satisfy ``wanted``; None without one."""
    place = next((i for i, cell in enumerate(table.header.cells) if wanted(*headers.split(cell))), None)
    if place is None:
        return None
    return np.array([(row.cells[place] if place < len(row.cells) else "").strip() for row in rows], object)


def _joined(parts: list[Measured], titles: list[str], file: str) -> Measured:
    """Return the points of several sheets; a specimen is named by its sheet, and by its specimen or loop there."""
    rate, load = (np.concatenate([getattr(part, name) for part in parts]) for name in ("rate", "load"))
    lines, names = list[str](), list[str]()
    for part, title in zip(parts, titles, strict=True):
        own = part.names if part.names is not None else [""] * part.rate.size
        names += [f"{title}, {name}" if name else title for name in own]
        lines += [f"{line} of sheet {shown(title)}" for line in (part.lines if part.lines is not None else ())]
    return Measured(rate, load, parts[0].label, file, np.array(lines, object), np.array(names, object))


def _settle(problems: Problems, file: str) -> None:
    """Raise the mistakes; of very many only the first, and the number of others."""
    if (more := len(problems) - SHOWN) > 0:
        problems[SHOWN:] = [Problem(reason=f"and {more} more mistakes of this kind", source=file)]
    problems.settle()

"""Measured points of a test: a table of twist and torque, or of curvature and moment, in SI units.

The header names each column and its unit: ``Phi (deg/mm), T (N mm)``. What the abscissa is measured over
may be a length (``Phi``), one pitch (``phi``) or the whole beam (``total``).
"""

from __future__ import annotations

import os
import re
from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from squama import files, tabular, units
from squama.errors import InputError
from squama.units import shown

SHOWN = 8
"""Mistakes of a file that are named one by one."""


class Measured(NamedTuple):
    """Measured points: ``rate`` (twist rate or curvature, rad/m) and ``load`` (torque or bending moment, N m).

    ``label`` is the name of the file without its ending, for legends.
    """

    rate: NDArray[np.float64]
    load: NDArray[np.float64]
    label: str


class _Columns(NamedTuple):
    """Names that a column may have (small letters for words), by what they are measured over."""

    over: Mapping[str, tuple[str, ...]]
    torque: tuple[str, ...]
    noun: str
    example: str


_LOADS = {
    "twisting": _Columns(
        {"": ("Phi", "twist rate"), "/pitch": ("phi", "twist per pitch"), " total": ("total", "total twist")},
        ("T", "torque"),
        "twist",
        "Phi (rad/m), T (N m)",
    ),
    "bending": _Columns(
        {"": ("kappa", "curvature"), "/pitch": ("psi", "bend per pitch"), " total": ("total", "total bend")},
        ("M", "moment", "bending moment"),
        "curvature",
        "kappa (1/m), M (N m)",
    ),
}
_HEADER = re.compile(r"(.*?)\s*(?:\((.*)\)|\[(.*)\])?")


def read(path: str | os.PathLike[str], *, pitch: float, scales: int, load: str = "twisting") -> Measured:
    r"""Read measured points.

    Parameters
    ----------
    path : path
        A table of text; leading lines that start with "#" are comments, columns of other names are not read.
        Twisting: ``Phi`` or ``twist rate`` (rad/m, deg/mm ...), or ``phi`` or ``twist per pitch`` (deg ...),
        or ``total`` or ``total twist`` (deg ...), and ``T`` or ``torque`` (N m, N mm ...). Bending: ``kappa`` or
        ``curvature``, ``psi`` or ``bend per pitch``, ``total`` or ``total bend``, and ``M`` or ``moment``.
    pitch, scales : float, int
        Distance d of the scales (m) and their number N.
    load : {"twisting", "bending"}
        Which kind of test it is.

    Returns
    -------
    Measured

    Raises
    ------
    InputError
        One line per mistake, each with the file and the line.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = pathlib.Path(folder, "test.csv")
    ...     _ = file.write_text("Phi (rad/mm), T (N mm)\n0.002, 40\n")
    ...     read(file, pitch=0.02, scales=25)
    Measured(rate=array([2.]), load=array([0.04]), label='test')
    """
    table, used, factors, _ = _columns(path, pitch, scales, load)
    values = _values(table, used)
    return Measured(values[0] * factors[0], values[1] * factors[1], Path(files.label(path)).stem)


class Specimen(NamedTuple):
    """One specimen's points in the order in which they were measured, ``rate`` and ``load`` as in :class:`Measured`.

    ``label`` names it; ``file`` and ``lines`` say where its rows stand, for messages ("" and None if in no file).
    """

    rate: NDArray[np.float64]
    load: NDArray[np.float64]
    label: str
    file: str = ""
    lines: NDArray[np.int64] | None = None

    def where(self, i: int) -> str:
        """Name the place of a point in messages."""
        if self.lines is None:
            return f"{self.label}: point {i}"
        return f"{self.file}: line {self.lines[i]}"


def read_specimens(
    path: str | os.PathLike[str], *, pitch: float, scales: int, load: str = "twisting"
) -> list[Specimen]:
    r"""Read measured points of one or more specimens, in the order of the rows.

    Parameters
    ----------
    path, pitch, scales, load
        As for :func:`read`. A column ``specimen`` tells specimens apart; without it all rows are one.

    Returns
    -------
    list of Specimen
        In the order in which they first occur.

    Raises
    ------
    InputError
        One line per mistake, each with the file and the line.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = pathlib.Path(folder, "test.csv")
    ...     _ = file.write_text("specimen, total (deg), T (N mm)\nA, 90, 40\nB, 90, 42\nA, 95, 44\n")
    ...     [(s.label, s.load.tolist()) for s in read_specimens(file, pitch=0.02, scales=25)]
    [('A', [0.04, 0.044]), ('B', [0.042])]
    """
    table, used, factors, place = _columns(path, pitch, scales, load)
    rate, torque = (values * factor for values, factor in zip(_values(table, used), factors, strict=True))
    stem, lines = Path(files.label(path)).stem, np.array([row.line for row in table.rows])
    if place is None:
        return [Specimen(rate, torque, stem, table.name, lines)]
    labels = [row.cells[place].strip() for row in table.rows]
    empty = [
        f"{table.name}: line {line}: specimen is empty; name it" for line, n in zip(lines, labels, strict=True) if not n
    ]
    if empty:
        raise InputError(_some(empty))
    found = []
    for label in dict.fromkeys(labels):
        mine = np.array([other == label for other in labels])
        found.append(Specimen(rate[mine], torque[mine], label, table.name, lines[mine]))
    return found


def _columns(
    path: str | os.PathLike[str], pitch: float, scales: int, load: str
) -> tuple[tabular.Table, tuple[int, int], list[float], int | None]:
    """Open a table: the places of abscissa and ordinate, what they are multiplied with, the place of the specimen."""
    columns = _LOADS[load]
    table = tabular.read(path)
    cells = table.header.cells
    names, wanted = _names(table, columns)
    rate_name, over = wanted["rate"]
    factors = []
    problems = []
    for column, dimension in ((names[rate_name], over), (names[wanted["torque"][0]], None)):
        try:
            factors.append(_factor(cells[column], dimension, pitch, scales, columns.example))
        except InputError as error:
            problems.append(f"{table.name}: line {table.header.line}: {error}")
    if problems:
        raise InputError("\n".join(problems))
    specimen = next((i for name, i in names.items() if name.casefold() == "specimen"), None)
    return table, (names[rate_name], names[wanted["torque"][0]]), factors, specimen


def _names(table: tabular.Table, columns: _Columns) -> tuple[dict[str, int], dict[str, tuple[str, str]]]:
    """Find which columns are read: their places by name, and the names of abscissa and ordinate."""
    names: dict[str, int] = {}
    for i, cell in enumerate(table.header.cells):
        name = _split(cell)[0]
        if name in names:
            raise table.error(table.header.line, f"the column {shown(name)} is given twice; keep one")
        names[name] = i
    # phi and Phi are two things, words may begin with a capital
    folded = {name if len(name) < 4 else name.casefold(): name for name in names}
    over_by_name = {name: over for over, known in columns.over.items() for name in known}
    found: dict[str, tuple[str, str]] = {}
    if not set(folded) & {*over_by_name, *columns.torque}:
        raise tabular.no_header(table, columns.example)
    problems = []
    for role, known in (("rate", list(over_by_name)), ("torque", list(columns.torque))):
        present = [name for name in known if name in folded]
        if present:
            found[role] = (folded[present[0]], over_by_name.get(present[0], ""))
            continue
        noun = f"a {columns.noun}" if role == "rate" else f"a {columns.torque[-1]}"
        problems.append(
            f"{table.name}: line {table.header.line}: no column of {noun} ({', '.join(known)}) among "
            f"{shown(', '.join(table.header.cells))}; write a header like: {columns.example}"
        )
    if problems:
        raise InputError("\n".join(problems))
    return names, found


def _split(cell: str) -> tuple[str, str | None]:
    """Return name and unit of a header's cell; no unit is None."""
    match = _HEADER.fullmatch(cell)
    if match is None:
        return cell, None
    unit = match[2] if match[2] is not None else match[3]
    return match[1], unit.strip() if unit is not None else None


def _factor(cell: str, over: str | None, pitch: float, scales: int, example: str) -> float:
    """Return what a column is multiplied with to be in SI units; ``over`` is None for a torque."""
    name, unit = _split(cell)
    if not unit:
        message = f"column {shown(cell)}: has no unit; write a header like: {example}"
        raise InputError(message)
    try:
        if over is None:
            return units.quantity(f"1 {unit}", "torque")
        try:
            return units.twist(f"1 {unit}", pitch=pitch, scales=scales)
        except units.QuantityError:
            if not over:
                raise
            return units.twist(f"1 {unit}{over}", pitch=pitch, scales=scales)
    except units.QuantityError as error:
        problem = f"{unit} is no unit of a {'torque' if over is None else 'twist or curvature'}"
        remedy = f"write a header like: {example}"
        if "over which length" in error.reason:
            problem = f"{unit} does not say over which length"
            remedy = f'write "{name} ({unit}/mm)", "{name} ({unit}/pitch)" or "total ({unit})"'
        message = f"column {shown(cell)}: {problem}; {remedy}"
        raise InputError(message) from None


def _values(table: tabular.Table, used: tuple[int, int]) -> list[NDArray[np.float64]]:
    if not table.rows:
        message = f"{table.name}: has a header but no rows; give one for each point"
        raise InputError(message)
    problems = []
    values: tuple[list[float], list[float]] = ([], [])
    for row in table.rows:
        problem = tabular.ragged(row, len(table.header.cells))
        if problem:
            problems.append(f"{table.name}: line {row.line}: {problem}")
            continue
        for target, i in zip(values, used, strict=True):
            try:
                target.append(tabular.number(row.cells[i]))
            except ValueError as error:
                place = tabular.where(table.header.cells[i], row.cells[i])
                reason = str(error)
                if "is empty" in reason or "finite" in reason:
                    # a gap in a record is not filled by an example
                    reason = f"{reason.partition(';')[0]}; leave out the rows that were not measured"
                problems.append(f"{table.name}: line {row.line}: {place}: {reason}")
    if problems:
        raise InputError(_some(problems))
    return [np.array(column) for column in values]


def _some(problems: list[str]) -> str:
    """Join lines; of very many the first, and how many there are."""
    if len(problems) <= SHOWN:
        return "\n".join(problems)
    first = problems[0].partition(": line")[0]
    return "\n".join([*problems[:SHOWN], f"{first}: and {len(problems) - SHOWN} more mistakes of this kind"])

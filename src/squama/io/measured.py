"""Measured points of a test: a table of twist and torque, or of curvature and moment, in SI units.

The header names each column and its unit: ``Phi (deg/mm), T (N mm)``. What the abscissa is measured over
may be a length (``Phi``), one pitch (``phi``) or the whole beam (``total``).
"""

from __future__ import annotations

import os
import re
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np

from squama import units
from squama.errors import InputError, Problem, Problems, refuse
from squama.io import files, tabular
from squama.loads import LOADS, Load
from squama.types import Array
from squama.units import shown

SHOWN = 8
"""Mistakes of a file that are named one by one."""


class Measured(NamedTuple):
    """Points in the order in which they were measured, of a whole file or of one specimen.

    ``rate`` is the twist rate or curvature (rad/m), ``load`` the torque or bending moment (N m); ``label`` names the
    specimen or, for legends, the file; ``file`` and ``lines`` say where the rows stand ("" and None if in no file),
    ``names`` whose they are in a table that tells specimens apart.
    """

    rate: Array
    load: Array
    label: str
    file: str = ""
    lines: Array | None = None
    names: Array | None = None

    def where(self, i: int) -> str:
        """Name the place of a point in messages."""
        if self.lines is None:
            return f"{self.label}: point {i}"
        return f"{self.file}: line {self.lines[i]}"

    def specimens(self) -> list[Measured]:
        """Return the points of each specimen, in the order in which they first occur; all are one if none is named."""
        if self.names is None or self.lines is None:
            return [self]
        empty = (
            Problem("specimen", '""', "is empty", "name it", self.where(i))
            for i in np.flatnonzero(self.names == "").tolist()
        )
        _settle(Problems(empty), self.file)
        groups = ((name, self.names == name) for name in dict.fromkeys(self.names))
        return [Measured(self.rate[own], self.load[own], name, self.file, self.lines[own]) for name, own in groups]


_HEADER = re.compile(r"(.*?)\s*(?:\((.*)\)|\[(.*)\])?")


def read(path: str | os.PathLike[str], *, pitch: float, scales: int, load: str = "twisting") -> Measured:
    r"""Read measured points of a beam of so many scales at this pitch (m), or name every mistake with file and line.

    Columns of twisting: ``Phi`` or ``twist rate`` (rad/m, deg/mm ...), or ``phi`` or ``twist per pitch`` (deg ...), or
    ``total`` or ``total twist`` (deg ...), and ``T`` or ``torque`` (N m, N mm ...). Bending: ``kappa`` or
    ``curvature``, ``psi`` or ``bend per pitch``, ``total`` or ``total bend``, and ``M`` or ``moment``. A column
    ``specimen`` tells specimens apart. Others are not read.

    Examples
    --------
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
    kind = LOADS[load]
    example = f"{kind.rate} ({'rad/m' if kind.sided else '1/m'}), {kind.torque} (N m)"
    table = tabular.read(path)
    names, abscissa, over, ordinate = _names(table, kind, example)
    places = names[abscissa], names[ordinate]
    cells = [table.header.cells[i] for i in places]
    factors, problems = [], Problems()
    for cell, length in zip(cells, (over, None), strict=True):
        with problems.caught(source=table.line()):
            factors.append(_factor(cell, length, pitch, scales, example))
    problems.settle()
    read_cell = partial(tabular.number, gap="leave out the rows that were not measured")
    readers = {cell: (i, read_cell) for cell, i in zip(cells, places, strict=True)}
    _, values, problems = tabular.numbers(table, readers, "point")
    _settle(problems, table.name)
    specimen = next((i for name, i in names.items() if name.casefold() == "specimen"), None)
    rate, torque = (column * factor for column, factor in zip(np.array(values).T, factors, strict=True))
    lines = np.array([row.line for row in table.rows])
    own = None if specimen is None else np.array([row.cells[specimen].strip() for row in table.rows], object)
    return Measured(rate, torque, Path(files.label(path)).stem, table.name, lines, own)


def _names(table: tabular.Table, load: Load, example: str) -> tuple[dict[str, int], str, str, str]:
    """Find which columns are read: places by name, name of the abscissa and what it is over, name of the ordinate."""
    names: dict[str, int] = {}
    for i, cell in enumerate(table.header.cells):
        name = _split(cell)[0]
        if name in names:
            raise table.error(None, f"the column {shown(name)} is given twice", "keep one")
        names[name] = i
    # phi and Phi are two things, words may begin with a capital
    folded = {name if len(name) < 4 else name.casefold(): name for name in names}
    over = {load.rate: "", load.rate_words: "", load.angle: "/pitch", load.angle_words: "/pitch"}
    over |= dict.fromkeys(("total", f"total {load.verb}"), " total")
    torque = (load.torque, load.torque_words, f"{load.name} {load.torque_words}")
    if not set(folded) & {*over, *torque}:
        raise tabular.no_header(table, example)
    found, problems = [], Problems()
    for noun, known in ((load.rate_words, tuple(over)), (load.torque_words, torque)):
        found += [name for name in known if name in folded][:1]
        if not set(known) & set(folded):
            among = shown(", ".join(table.header.cells))
            reason = f"no column of a {noun} ({', '.join(known)}) among {among}"
            problems.add("", "", reason, f"write a header like: {example}", table.line())
    problems.settle()
    abscissa, ordinate = found
    return names, folded[abscissa], over[abscissa], folded[ordinate]


def _split(cell: str) -> tuple[str, str]:
    """Return name and unit of a header's cell; no unit is empty."""
    match = _HEADER.fullmatch(cell)
    return (match[1], (match[2] or match[3] or "").strip()) if match else (cell, "")


def _factor(cell: str, over: str | None, pitch: float, scales: int, example: str) -> float:
    """Return what a column is multiplied with to be in SI units; ``over`` is None for a torque."""
    name, unit = _split(cell)
    where, remedy = f"column {shown(cell)}", f"write a header like: {example}"
    if not unit:
        refuse(where, "", "has no unit", remedy)
    try:
        if over is None:
            return units.quantity(f"1 {unit}", "torque")
        try:
            return units.twist(f"1 {unit}", pitch=pitch, scales=scales)
        except units.QuantityError:
            if not over:
                raise
            return units.twist(f"1 {unit}{over}", pitch=pitch, scales=scales)
    except units.NoLengthError:
        reason = f"{unit} does not say over which length"
        remedy = f'write "{name} ({unit}/mm)", "{name} ({unit}/pitch)" or "total ({unit})"'
    except units.QuantityError:
        reason = f"{unit} is no unit of a {'torque' if over is None else 'twist or curvature'}"
    raise InputError(Problem(where, "", reason, remedy)) from None


def _settle(problems: Problems, file: str) -> None:
    """Raise what was found; of very many mistakes the first, and how many there are."""
    if (more := len(problems) - SHOWN) > 0:
        problems[SHOWN:] = [Problem(reason=f"and {more} more mistakes of this kind", source=file)]
    problems.settle()

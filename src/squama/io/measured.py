"""Measured points of a test: a table of twist and torque, or of curvature and moment, in SI units.

The header names each column and its unit: ``Phi (deg/mm), T (N mm)``. What the abscissa is measured over
may be a length (``Phi``), one pitch (``phi``) or the whole beam (``total``).
"""

from __future__ import annotations

import os
import warnings
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from squama import arguments, units
from squama.errors import InputError, Problem, Problems, TableWarning, refuse
from squama.io import files, laboratory, tabular
from squama.loads import LOADS, Load
from squama.types import Array
from squama.units import Dimension, shown

SHOWN = 8
"""Mistakes of a file that are named one by one."""


class Measured(NamedTuple):
    """Points in the order in which they were measured, of a whole file or of one specimen.

    ``rate`` is the twist rate or curvature (rad/m), ``load`` the torque or bending moment (N m), of a decay its time
    (s); ``label`` names the specimen or, for legends, the file; ``file`` and ``lines`` say where the rows stand ("" and
    None if in no file), ``names`` whose they are in a table that tells specimens apart.
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


class Ordinate(NamedTuple):
    """The quantity beside the twist: noun, names of its column, dimension, and a cell of a header as example."""

    noun: str
    names: tuple[str, ...]
    dimension: Dimension
    cell: str


TIME = Ordinate("time", ("t", "time"), Dimension.TIME, "t (s)")


def torque(load: Load) -> Ordinate:
    """Return the ordinate of a test: the torque or bending moment."""
    names = (load.torque, load.torque_words, f"{load.name} {load.torque_words}")
    return Ordinate(load.torque_words, names, Dimension.TORQUE, f"{load.torque} (N m)")


def swings(path: str | os.PathLike[str], columns: str | Mapping[str, str] | None = None) -> bool:
    """Say whether a table is the record of a decay: it has a column of time and none of a torque."""
    names = {name for load in LOADS.values() for name in (*_over(load), *torque(load).names)} | {*TIME.names}
    cells = [laboratory.split(cell) for cell in laboratory.read(path, names, columns).table.header.cells]
    found = {laboratory.dimension(unit) for _, unit in cells}
    return Dimension.TIME in found and Dimension.TORQUE not in found


def read_measured(
    path: str | os.PathLike[str],
    beam: Any,
    *,
    load: str = "twisting",
    decimal: str | None = None,
    columns: str | Mapping[str, str] | None = None,
) -> Measured:
    r"""Read measured points of a beam's test from a table of text.

    Parameters
    ----------
    path
        A table in UTF-8, UTF-16 with its mark, or latin-1, cells set apart by semicolons, tabs or commas. Its header
        names each column and its unit, which may stand in a line below; lines of comment begin with #, % or //.
    beam : Beam
        Its pitch and number of scales turn angles per pitch or of the whole beam into rates.
    load
        "twisting" or "bending".
    decimal
        What sets decimals off, "." or ","; guessed if not given.
    columns
        What columns are, by their names or numbers (from 1): "Winkel=total (deg), 3=T (N mm)", or as a mapping. Without
        it columns are known by name, else by their units; an angle is then the twist (bend) of the whole beam.

    Returns
    -------
    Measured
        ``rate`` (rad/m) and ``load`` (N m), arrays of one length, in the order of the rows.

    Raises
    ------
    InputError
        The table cannot be read so; every mistake with file and line.

    Warns
    -----
    TableWarning
        Something was guessed; what, in one line.

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
    arguments.place(path, "test.csv")
    arguments.beam(beam)
    given = {"pitch": beam.pitch, "scales": beam.pitches}
    return read(path, **given, load=arguments.load(load).name, decimal=decimal, columns=columns)


def read(
    path: str | os.PathLike[str],
    *,
    pitch: float,
    scales: int,
    load: str = "twisting",
    decimal: str | None = None,
    columns: str | Mapping[str, str] | None = None,
    ordinate: Ordinate | None = None,
) -> Measured:
    r"""Read measured points of a beam of so many scales at this pitch (m), or name every mistake with file and line.

    Columns of twisting: ``Phi`` or ``twist rate`` (rad/m, deg/mm ...), or ``phi`` or ``twist per pitch`` (deg ...), or
    ``total`` or ``total twist`` (deg ...), and ``T`` or ``torque`` (N m, N mm ...). Bending: ``kappa`` or
    ``curvature``, ``psi`` or ``bend per pitch``, ``total`` or ``total bend``, and ``M`` or ``moment``. A column
    ``specimen`` tells specimens apart. With :data:`TIME` for ``ordinate`` a column ``t`` or ``time`` stands in place of
    the torque. The rest is as for :func:`read_measured`.

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
    wanted = torque(kind) if ordinate is None else ordinate
    example = f"{kind.rate} ({'rad/m' if kind.sided else '1/m'}), {wanted.cell}"
    table, said = laboratory.read(path, {*_over(kind), *wanted.names}, columns)
    places, length, guessed = _places(table, kind, wanted, example)
    cells = [table.header.cells[i] for i in places]
    factors, problems = [], Problems()
    for cell, span in zip(cells, (length, wanted.dimension), strict=True):
        with problems.caught(source=table.line()):
            factors.append(_factor(cell, span, pitch, scales, example))
    problems.settle()
    sign = laboratory.decimal_of([row.cells[i] for row in table.rows for i in places if i < len(row.cells)], decimal)
    read_cell = partial(laboratory.number, decimal=sign, gap="leave out the rows that were not measured")
    readers = {cell: (i, read_cell) for cell, i in zip(cells, places, strict=True)}
    _, values, problems = tabular.numbers(table, readers, "point")
    _settle(problems, table.name)
    said += ["with decimal commas"] * (sign == "," and decimal is None)
    if said := said + guessed:
        remedy = "if that is wrong, tell decimal and columns"
        warnings.warn(f"{table.name} is read {', '.join(said)}; {remedy}", TableWarning, stacklevel=2)
    names = [laboratory.split(cell)[0].casefold() for cell in table.header.cells]
    rate, values = (column * factor for column, factor in zip(np.array(values).T, factors, strict=True))
    lines, own = np.array([row.line for row in table.rows]), None
    if "specimen" in names:
        own = np.array([row.cells[names.index("specimen")].strip() for row in table.rows], object)
    return Measured(rate, values, Path(files.label(path)).stem, table.name, lines, own)


def _over(load: Load) -> dict[str, str]:
    """Return the names of an abscissa, each with the length that its angle belongs to."""
    over = {load.rate: "", load.rate_words: "", load.angle: "/pitch", load.angle_words: "/pitch"}
    return over | dict.fromkeys(("total", f"total {load.verb}"), " total")


def _places(table: tabular.Table, load: Load, ordinate: Ordinate, example: str) -> tuple[list[int], str, list[str]]:
    """Find the columns of abscissa and ordinate, what the abscissa is over, and what was guessed of them in words."""
    over = _over(load)
    names: dict[str, list[int]] = {}
    dimensions = []
    for i, cell in enumerate(table.header.cells):
        name, unit = laboratory.split(cell)
        # phi and Phi are two things, words may begin with a capital
        names.setdefault(name if len(name) < 4 else name.casefold(), []).append(i)
        dimensions.append("" if unit.endswith(("/rad", "/deg")) else str(laboratory.dimension(unit) or ""))
    for name in (*over, *ordinate.names, "specimen"):
        if len(names.get(name, [])) > 1:
            own = laboratory.split(table.header.cells[names[name][1]])[0]
            raise table.error(None, f"the column {shown(own)} is given twice", "keep one")
    # what is named as of another loading is not guessed to be of this one; any torque may be called a moment
    others = [name for other in LOADS.values() for part in (_over(other), torque(other).names) for name in part]
    taken = {i for name in others if name not in ("M", "moment") for i in names.get(name, [])}
    places, length, guessed, problems = [], "", [], Problems()
    for noun, known, kinds in (
        (load.rate_words, tuple(over), ("angle", "twist rate")),
        (ordinate.noun, ordinate.names, (ordinate.dimension,)),
    ):
        found = next((name for name in known if name in names), None)
        alike = [i for i, d in enumerate(dimensions) if d in kinds and i not in taken]
        if found is not None:
            places += names[found]
            length = over.get(found, length)
        elif len(alike) == 1:
            places += alike
            whole = dimensions[alike[0]] == "angle"
            length = " total" if whole else length
            what = f"the {load.verb} of the whole beam" if whole else f"the {noun}"
            guessed.append(f"{shown(table.header.cells[alike[0]])} as {what}")
        else:
            among = shown(", ".join(table.header.cells))
            reason = "several columns may be" if alike else "no column of"
            reason += f" a {noun} ({', '.join(known)}) among {among}"
            remedy = f'write a header like: {example}; or say which it is with columns, e.g. "2={known[-1]}"'
            problems.add("", "", reason, remedy, table.line())
    if len(problems) == 2:
        raise tabular.no_header(table, example)
    problems.settle()
    return places, length, guessed


def _factor(cell: str, over: str | Dimension, pitch: float, scales: int, example: str) -> float:
    """Return the factor from a column to SI units; ``over``: an ordinate's dimension, or what an angle is over."""
    name, unit = laboratory.split(cell)
    where, remedy = f"column {shown(cell)}", f"write a header like: {example}"
    if not unit:
        refuse(where, "", "has no unit", remedy)
    try:
        if isinstance(over, Dimension):
            return units.quantity(f"1 {unit}", over)
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
        reason = f"{unit} is no unit of a {over if isinstance(over, Dimension) else 'twist or curvature'}"
    raise InputError(Problem(where, "", reason, remedy)) from None


def _settle(problems: Problems, file: str) -> None:
    """Raise the mistakes; of very many the first ones, and how many more there are."""
    if (more := len(problems) - SHOWN) > 0:
        problems[SHOWN:] = [Problem(reason=f"and {more} more mistakes of this kind", source=file)]
    problems.settle()

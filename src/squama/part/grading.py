"""Grading: a beam whose scales differ along it."""

from __future__ import annotations

import functools
import os
from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from squama.beam.beamfile import NUMBERS
from squama.beam.design import Beam
from squama.errors import naming, refuse
from squama.io import files, headers, tabular
from squama.units import bounded, quantity, shown

GRADED = tuple(f"scale.{name}" for name in ("length", "width", "thickness", "alpha", "theta0", "embedded"))
"""What may differ from scale to scale."""
_EXAMPLES = {name: f"{name} ({'deg' if name in GRADED[3:5] else 'mm'})" for name in GRADED}
"""How the columns of a table are written, by name."""
Grades = Mapping[str, Sequence[float | str]]
"""By name the values of the first and the last scale, or of each."""


def values(along: Grades, *, bare: bool = True) -> dict[str, list[float]]:
    """Return grades in SI units; ``bare``: numbers without a unit are SI, else they are refused."""
    if not isinstance(along, Mapping):
        refuse("along", "", "is no mapping", 'write e.g. {"scale.theta0": ["5 deg", "10 deg"]}')
    found = {}
    for name, given in along.items():
        if name not in GRADED:
            refuse("along", shown(name), f"must be one of {', '.join(GRADED)}", 'write e.g. "scale.theta0"')
        if isinstance(given, str | Mapping) or not isinstance(given, Iterable):
            refuse(f"along: {name}", "", "is no list", 'write e.g. ["5 deg", "10 deg"]')
        with naming(f"along: {name}"):
            found[name] = [bounded(value, *NUMBERS[name], bare=bare) for value in given]
    return found


def of_scales(along: Grades | str | os.PathLike[str], n: int) -> dict[str, list[float]]:
    """Return grades of a part of n scales in SI units: two values of each name, or n; read a table, if it is one."""
    if isinstance(along, str | os.PathLike):
        with naming("along"):
            return _table(along, n)
    found = values(along)
    for name, numbers in found.items():
        if len(numbers) not in (2, n):
            what = f"has {len(numbers)}, but needs 2 values, or {n}"
            refuse(f"along: {name}", "", what, "give those of the first and the last scale, or of all")
    return found


def _table(path: str | os.PathLike[str], n: int) -> dict[str, list[float]]:
    """Read a table with a row for each of n scales: columns are names with their units."""
    table = tabular.parse(files.read_text(path, missing="write a CSV with a row for each scale"), files.label(path))
    columns = {}
    for place, cell in enumerate(table.header.cells):
        name, unit = headers.split(cell)
        with naming(f"column {shown(cell)}", table.line()):
            if name not in GRADED:
                refuse("", "", "is not known", f"allowed: {', '.join(_EXAMPLES.values())}")
            if name in columns:
                refuse("", "", "is there twice", "keep one of them")
            if not unit:
                refuse("", "", "has no unit", f"write {_EXAMPLES[name]}")
            quantity(f"1 {unit}", NUMBERS[name][0])
        columns[name] = place, functools.partial(_number, name, unit)
    if len(table.rows) != n:
        rows = f"has {len(table.rows)} rows, but the part has {n} scales"
        refuse("", "", rows, "give a row for each scale", table.name)
    _, numbers, problems = tabular.numbers(table, columns, "scale")
    problems.settle()
    return dict(zip(columns, map(list, zip(*numbers, strict=True)), strict=True))


def _number(name: str, unit: str, cell: str) -> float:
    """Read a cell of a column, SI."""
    return bounded(f"{tabular.number(cell, '5')!r} {unit}", *NUMBERS[name])


def graded(beam: Beam, grades: Mapping[str, Sequence[float]], n: int) -> list[Beam]:
    """Return the beam of each of n scales, or one for all where nothing differs."""
    if not grades:
        return [beam]
    each = np.linspace(0, 1, n)
    columns = {name.removeprefix("scale."): np.interp(each, np.linspace(0, 1, len(v)), v) for name, v in grades.items()}
    beams = []
    for i in range(n):
        with naming(f"along: scale {i + 1}"):
            beams.append(beam.replace(scale={name: float(v[i]) for name, v in columns.items()}))
    return beams

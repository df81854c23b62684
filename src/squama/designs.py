"""Many designs from a spreadsheet: a table in, the same table with engagement and end out.

Bad rows are named with their line, column and value; the good ones are computed all the same, together.
"""

from __future__ import annotations

import csv
import os
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from squama import api, files, parts, tabular
from squama.errors import InputError
from squama.units import Bounds

Numbers = NDArray[np.float64]
_QUARTER = Bounds(0.0, 90.0, "0 to 90 deg, exclusive")
INPUTS: dict[str, Bounds] = {
    "eta": parts.RATIOS["eta"],
    "beta": parts.RATIOS["beta"],
    "lambda": parts.RATIOS["lam"],
    "alpha_deg": _QUARTER._replace(example="45"),
    "theta0_deg": _QUARTER._replace(example="10"),
    "mu": parts.FRICTION._replace(example="0.25"),
}
"""Bounds of the columns, each in its own unit."""
RESULTS = ("phi_e_rad", "end", "theta_end_deg", "phi_end_rad", "neighbour")
OTHER, SENSE = "other_contact", "sense"
_ADDED = (*RESULTS, OTHER, SENSE)


class Solved(NamedTuple):
    """A table of designs with its results.

    ``header`` and ``rows`` are cells as they are written, ``problems`` has one line per mistake in the rows that were
    left out, ``bad`` counts those rows, ``ends`` counts the good rows by their end.
    """

    header: list[str]
    rows: list[list[str]]
    problems: list[str]
    bad: int
    ends: dict[str, int]
    delimiter: str


def solve(path: str | os.PathLike[str], *, law: str = "edge", sense: str = "+", contacts: str = "tip") -> Solved:
    """Read a table of designs and find where each engages, and how and where its curve ends.

    Parameters
    ----------
    path : path
        Columns eta, beta, lambda, alpha_deg, theta0_deg, mu; others are carried along. Where all columns of
        results are there already they are those of an earlier run and are replaced; some of them are refused.
    law, sense, contacts
        As in :func:`squama.ends`; with "all" the column other_contact is added. The last column is the sense.

    Returns
    -------
    Solved

    Raises
    ------
    InputError
        The file cannot be read, or a column is missing, given twice or misspelt.
    """
    table = tabular.read(path)
    places = _places(table)
    good, columns, problems = _good(table, places)
    if not table.rows:
        message = f"{table.name}: has a header but no rows; give one for each design"
        raise InputError(message)
    angles = {"alpha": np.radians(columns["alpha_deg"]), "theta0": np.radians(columns["theta0_deg"])}
    ratios = {"eta": columns["eta"], "beta": columns["beta"], "lam": columns["lambda"], "mu": columns["mu"]}
    found = api.ends(**ratios, **angles, law=law, sense=sense, contacts=contacts)
    results = [
        [repr(v) for v in found.phi_e.tolist()],
        found.end.tolist(),
        [repr(v) for v in np.degrees(found.theta_end).tolist()],
        [repr(v) for v in found.phi_end.tolist()],
        [str(v) for v in found.neighbour.tolist()],
    ]
    names = list(RESULTS)
    if contacts == "all":
        results.append(found.other.tolist())
        names.append(OTHER)
    results.append(found.sense.tolist())
    names.append(SENSE)
    kept = [i for i, name in enumerate(table.header.cells) if name not in _ADDED]
    rows = [
        [row.cells[i] for i in kept] + list(added) for row, added in zip(good, zip(*results, strict=True), strict=True)
    ]
    header = [table.header.cells[i] for i in kept] + names
    words, counts = np.unique(found.end, return_counts=True)
    ends = dict(zip(words.tolist(), counts.tolist(), strict=True))
    return Solved(header, rows, problems, len(table.rows) - len(good), ends, table.delimiter)


def write(solved: Solved, path: str | os.PathLike[str]) -> Path:
    """Write a solved table; the file is complete or not there at all.

    Raises
    ------
    InputError
        The file cannot be written.
    """

    def fill(place: Path) -> None:
        with place.open("w", encoding="utf-8", newline="") as file:
            writer = csv.writer(file, delimiter=solved.delimiter, lineterminator="\n")
            writer.writerow(solved.header)
            writer.writerows(solved.rows)

    return files.atomic_write(path, fill)


def _places(table: tabular.Table) -> dict[str, int]:
    """Return where the input columns stand."""
    header = table.header.cells
    line = f"{table.name}: line {table.header.line}: "
    problems = [
        f"{line}the column {name} is given twice; keep one"
        for name in dict.fromkeys(header)
        if header.count(name) > 1 and name
    ]
    unused = [name for name in header if name not in INPUTS]
    if len(unused) == len(header) and not any(tabular.guess(name, unused) for name in INPUTS):
        raise tabular.no_header(table, ",".join(INPUTS))
    # a table that has been here before has all of them
    if not set(RESULTS) <= set(header):
        problems += [
            f"{line}the column {name} has the name of a result; rename it"
            for name in dict.fromkeys(header)
            if name in _ADDED
        ]
    for name in INPUTS:
        if name not in header:
            hint = tabular.guess(name, unused)
            hint = f"rename {hint[13:-2]} to {name}" if hint else f"the header must have {', '.join(INPUTS)}"
            problems.append(f"{line}the column {name} is missing; {hint}")
    if problems:
        raise InputError("\n".join(problems))
    return {name: header.index(name) for name in INPUTS}


def _good(table: tabular.Table, places: dict[str, int]) -> tuple[list[tabular.Row], dict[str, Numbers], list[str]]:
    """Part the good rows from the bad ones; return them, their numbers by column, and a line per mistake."""
    width = len(table.header.cells)
    whole = [row for row in table.rows if len(row.cells) == width]
    wrong: dict[int, list[str]] = {
        row.line: [str(tabular.ragged(row, width))] for row in table.rows if len(row.cells) != width
    }
    columns: dict[str, Numbers] = {}
    fine = np.ones(len(whole), bool)
    for name, place in places.items():
        cells = [row.cells[place] for row in whole]
        values, words = _numbers(cells, INPUTS[name].example)
        bounds = INPUTS[name]
        inside = np.array([bounds.hold(value) for value in values.tolist()], bool)
        for i in np.flatnonzero(~inside):
            reason = words.get(int(i), f"is out of range; allowed: {bounds.allowed}; write e.g. {bounds.example}")
            wrong.setdefault(whole[i].line, []).append(f"{tabular.where(name, cells[i])}: {reason}")
        columns[name] = values
        fine &= inside
    problems = [f"{table.name}: line {line}: {problem}" for line in sorted(wrong) for problem in wrong[line]]
    chosen = np.flatnonzero(fine)
    return [whole[i] for i in chosen], {name: values[chosen] for name, values in columns.items()}, problems


def _numbers(cells: list[str], example: str) -> tuple[Numbers, dict[int, str]]:
    """Read cells; NaN and words, by their place, for those that hold no finite number."""
    values = np.full(len(cells), np.nan)
    words: dict[int, str] = {}
    for i, cell in enumerate(cells):
        try:
            values[i] = tabular.number(cell, example)
        except ValueError as error:
            words[i] = str(error)
    return values, words

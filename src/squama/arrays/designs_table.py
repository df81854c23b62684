"""Tables of designs: read a spreadsheet, and add engagement and end of each design as columns.

Bad rows are reported with line, column and value; the good rows are still computed, all together.
"""

from __future__ import annotations

import os
from collections import Counter
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple, TextIO

import numpy as np

from squama.arrays import edge_contacts
from squama.beam import beamfile, parts
from squama.errors import Problem, Problems, refuse
from squama.io import files, tabular
from squama.units import Bounds

INPUTS: dict[str, Bounds] = {
    "eta": parts.RATIOS["eta"],
    "beta": parts.RATIOS["beta"],
    "lambda": parts.RATIOS["lam"],
    "alpha_deg": Bounds(0.0, 90.0, beamfile.QUARTER.allowed, example="45"),
    "theta0_deg": Bounds(0.0, 90.0, beamfile.QUARTER.allowed, example="10"),
    "mu": beamfile.NUMBERS["friction.mu"][1],
}
"""Bounds of the input columns, each in its own unit."""
RESULTS = ("phi_e_rad", "end", "theta_end_deg", "phi_end_rad", "neighbour")
OTHER, SENSE = "other_contact", "sense"
_ADDED = (*RESULTS, OTHER, SENSE)


class Solved(NamedTuple):
    """A table of designs with its results.

    ``header`` and ``rows`` are cells as written to the file; ``problems`` are the mistakes in the rows left out;
    ``bad`` is the number of those rows; ``ends`` counts the good rows by their end.
    """

    header: list[str]
    rows: list[list[str]]
    problems: list[Problem]
    bad: int
    ends: dict[str, int]
    delimiter: str


def solve(path: str | os.PathLike[str], *, law: str = "edge", sense: str = "+", contacts: str = "tip") -> Solved:
    """Read a table of designs and add where each engages, and how and where its curve ends.

    Columns other than :data:`INPUTS` are kept. If all result columns are present they come from an earlier run and are
    replaced; if only some are, the table is refused. ``law``, ``sense``, ``contacts`` are as in :func:`squama.ends`;
    "all" adds the column other_contact.
    """
    table = tabular.read(path)
    header = _checked(table)
    readers = {name: (header.index(name), partial(_value, bounds=bounds)) for name, bounds in INPUTS.items()}
    good, values, problems = tabular.numbers(table, readers, "design")
    eta, beta, lam, alpha, theta0, mu = np.array(values).reshape(-1, len(INPUTS)).T
    angles = {"alpha": np.radians(alpha), "theta0": np.radians(theta0)}
    how: dict[str, Any] = {"law": law, "sense": sense, "contacts": contacts}
    found = edge_contacts.ends(eta=eta, beta=beta, lam=lam, mu=mu, **angles, **how)
    columns = (found.phi_e, found.end, np.degrees(found.theta_end), found.phi_end, found.neighbour)
    results = dict(zip(RESULTS, columns, strict=True))
    if contacts == "all":
        results[OTHER] = found.other
    results[SENSE] = found.sense
    added = zip(*(map(str, column.tolist()) for column in results.values()), strict=True)
    kept = [i for i, name in enumerate(header) if name not in _ADDED]
    rows = [[*(row.cells[i] for i in kept), *texts] for row, texts in zip(good, added, strict=True)]
    ends = dict(Counter(sorted(found.end.tolist())))
    bad = len(table.rows) - len(good)
    return Solved([*(header[i] for i in kept), *results], rows, problems, bad, ends, table.delimiter)


def put(solved: Solved, file: TextIO) -> None:
    """Write a table with results to an open file."""
    tabular.write(file, [solved.header, *solved.rows], solved.delimiter)


def write(solved: Solved, path: str | os.PathLike[str]) -> Path:
    """Write a table with results to a file, which is complete or not there at all."""

    def fill(place: Path) -> None:
        with place.open("w", encoding="utf-8", newline="") as file:
            put(solved, file)

    return files.atomic_write(path, fill)


def _checked(table: tabular.Table) -> list[str]:
    """Return the header; refuse missing or repeated input columns, and columns with the names of results."""
    header = table.header.cells
    unused = [name for name in header if name not in INPUTS]
    if len(unused) == len(header) and not any(tabular.close(name, unused) for name in INPUTS):
        raise tabular.no_header(table, ",".join(INPUTS))
    wrong: list[tuple[str, str, str]] = []
    for name in dict.fromkeys(header):
        if name and header.count(name) > 1:
            wrong.append((name, "is given twice", "keep one"))
        # a table from an earlier run has all of them
        if name in _ADDED and not set(RESULTS) <= set(header):
            wrong.append((name, "has the name of a result", "rename it"))
    for name in INPUTS:
        if name not in header:
            meant = tabular.close(name, unused)
            remedy = f"rename {meant} to {name}" if meant else f"the header must have {', '.join(INPUTS)}"
            wrong.append((name, "is missing", remedy))
    Problems(Problem("", "", f"the column {name} {what}", fix, table.line()) for name, what, fix in wrong).settle()
    return header


def _value(cell: str, bounds: Bounds) -> float:
    value = tabular.number(cell, bounds.example)
    if not bounds.hold(value):
        reason = f"is out of range; allowed: {bounds.allowed}"
        refuse("", tabular.shown_cell(cell), reason, f"write e.g. {bounds.example}")
    return value

"""CSV files of figures, and the tables of claims."""

from __future__ import annotations

import csv
import io
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from squama import files

Table = Mapping[str, Any]
"""Columns by their headers (name and unit), all of one length."""


class Claim(NamedTuple):
    """One statement of the paper and the number computed for it; ``holds`` is yes, no, in part or open."""

    figure: str
    claim: str
    law: str
    quantity: str
    value: str
    unit: str
    holds: str
    note: str = ""


def write_table(table: Table, path: str | os.PathLike[str]) -> Path:
    """Write columns to a CSV file; numbers have 12 digits, NaN is an empty cell."""
    columns = [np.asarray(c).ravel() for c in table.values()]
    rows = zip(*columns, strict=True)
    return files.atomic_write(path, lambda place: place.write_text(_csv(list(table), rows), encoding="utf-8"))


def _csv(header: Sequence[str], rows: Any) -> str:
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(header)
    writer.writerows([_cell(v) for v in row] for row in rows)
    return out.getvalue()


def _cell(value: Any) -> str:
    if isinstance(value, bool | np.bool):
        return "yes" if value else "no"
    if isinstance(value, float | np.floating):
        return "" if np.isnan(value) else f"{value:.12g}"
    return str(value)


def flat(data: xr.Dataset, columns: Mapping[str, tuple[str, float]]) -> dict[str, Any]:
    """Lay variables of a dataset side by side, one row for each cell of their common dimensions.

    Parameters
    ----------
    data : xarray.Dataset
        The dataset.
    columns : mapping
        From header to the variable's name and the factor that brings it to the header's unit.
    """
    arrays = xr.broadcast(*(data[name] for name, _ in columns.values()))
    out = {}
    for (header, (_, factor)), array in zip(columns.items(), arrays, strict=True):
        values = array.values.ravel()
        out[header] = values * factor if values.dtype.kind == "f" else values
    return out


def without(table: Table, keep: Any) -> dict[str, Any]:
    """Return the rows of a table that a mask keeps."""
    return {header: np.asarray(column)[keep] for header, column in table.items()}


def write_claims(claims: Sequence[Claim], directory: Path) -> list[Path]:
    """Write ``claims.csv`` and ``claims.md``."""
    rows = [[*c] for c in claims]
    text = _csv(Claim._fields, rows)
    done = [files.atomic_write(directory / "claims.csv", lambda place: place.write_text(text, encoding="utf-8"))]
    head = (
        "# Claims of the paper and what is computed\n\n"
        "H. Ebrahimi, H. Ali, R. Ghosh, Coulomb friction in twisting of biomimetic scale-covered substrate, "
        "Bioinspir. Biomim. 15 (2020). The plate law is the paper's; the edge law satisfies virtual work.\n\n"
        "| figure | claim | law | what is computed | value | holds | note |\n|---|---|---|---|---|---|---|\n"
    )
    body = "".join(
        f"| {c.figure} | {c.claim} | {c.law} | {c.quantity} | {c.value}{' ' + c.unit if c.unit else ''} | "
        f"{c.holds} | {c.note} |\n"
        for c in claims
    )
    markdown = head + body
    done.append(files.atomic_write(directory / "claims.md", lambda place: place.write_text(markdown, encoding="utf-8")))
    return done

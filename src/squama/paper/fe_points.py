"""Finite element points for Fig. 6b, from a CSV file."""

from __future__ import annotations

import math
import os
from typing import NamedTuple

import numpy as np

from squama import response, tabular
from squama.errors import InputError
from squama.model.solve import Array
from squama.paper import parameters as par
from squama.paper.tables import Claim

COLUMNS = ("eta", "mu", "Phi (rad/m)", "T/(G_B I) (rad/m)")
"""Header of the file: overlap ratio, coefficient of friction, twist rate, torque over G_B times the polar moment."""
COMPLIANT = "compliant joint T/(G_B I) (rad/m)"
"""Column that may be there too: torque of the compliant joint with the stiffness of the same mesh; may be empty."""
K_THETA, C_F = "K_theta/(E_B d^3)", "C_f"
"""Comments that may stand at the head, each with a number after a colon: the hinge that the elements make."""
LEAST = {COLUMNS[0]: 1.0, COLUMNS[1]: 0.0, COLUMNS[2]: 0.0}
CLOSE = 0.1
"""Relative difference of torques that counts as agreement."""
MOST = 4
"""Panels (overlap ratios) that the figure has room for."""


class FePoints(NamedTuple):
    """Points in the order of the file; ``source`` is its name.

    ``compliant`` is the compliant joint's load, and ``joint`` K_theta (E_B d^3) and C_f of the elements, if given.
    """

    eta: Array
    mu: Array
    rate: Array
    load: Array
    source: str
    compliant: Array | None = None
    joint: tuple[float, float] | None = None


def read_points(path: str | os.PathLike[str]) -> FePoints:
    """Read finite element points.

    Parameters
    ----------
    path : path
        A CSV file with the columns ``eta, mu, Phi (rad/m), T/(G_B I) (rad/m)`` in any order, one point a row;
        I is the polar moment of the section. Leading lines that start with # are comments. A column
        :data:`COMPLIANT` and the comments :data:`K_THETA` and :data:`C_F` are read too.

    Returns
    -------
    FePoints

    Raises
    ------
    InputError
        The file cannot be read or has no such columns, a value is no number or out of range (one line a mistake,
        with its line number), no row is left, or there are more overlap ratios than panels.
    """
    wanted = ", ".join(COLUMNS)
    table = tabular.read(path, missing=f"give a CSV file with the columns {wanted}")
    header, line = table.header.cells, table.header.line
    problems = [f'line {line}: no column "{c}"; the header must be {wanted}' for c in COLUMNS if c not in header]
    problems += [f'line {line}: the column "{c}" is given twice; keep one' for c in COLUMNS if header.count(c) > 1]
    values: list[list[float]] = []
    for row in table.rows if not problems else ():
        if text := tabular.ragged(row, len(header)):
            problems.append(f"line {row.line}: {text}")
            continue
        cells = dict(zip(header, row.cells, strict=True))
        values.append([_value(column, cells[column], row.line, problems) for column in COLUMNS])
    if not problems and not values:
        problems = [f"line {line}: holds a header but no points; write one row per point"]
    if problems:
        raise InputError("\n".join(f"{table.name}: {problem}" for problem in problems))
    eta, mu, rate, load = np.array(values).T
    if (count := np.unique(eta).size) > MOST:
        message = f"{table.name}: has {count} values of eta, the figure has room for {MOST}; write more files"
        raise InputError(message)
    return FePoints(eta, mu, rate, load, table.name, _compliant(table), _joint(table))


def _compliant(table: tabular.Table) -> Array | None:
    header = table.header.cells
    if COMPLIANT not in header:
        return None
    problems: list[str] = []
    i = header.index(COMPLIANT)
    cells = [(row.line, row.cells[i]) for row in table.rows]
    values = [_value(COMPLIANT, cell, line, problems) if cell.strip() else math.nan for line, cell in cells]
    if problems:
        raise InputError("\n".join(f"{table.name}: {problem}" for problem in problems))
    return np.array(values)


def _joint(table: tabular.Table) -> tuple[float, float] | None:
    found = dict(line.lstrip("# ").rsplit(": ", 1) for line in table.comments if ": " in line)
    try:
        return float(found[K_THETA]), float(found[C_F])
    except (KeyError, ValueError):
        return None


def _value(column: str, cell: str, line: int, problems: list[str]) -> float:
    """Return the number in a cell, or note what is wrong with it."""
    try:
        value = tabular.number(cell)
    except ValueError as error:
        problems.append(f"line {line}: {tabular.where(column, cell)} {error}")
        return math.nan
    low = LEAST.get(column, -math.inf)
    if value < low:
        problems.append(f"line {line}: {tabular.where(column, cell)}: must be {low:g} or more")
    return value


def compare(points: FePoints | None) -> list[Claim]:
    """Set the points beside both force laws and, if they hold it, the compliant joint.

    The largest difference, and up to which twist the two agree.
    """
    text = "the model agrees with finite elements"
    if points is None:
        words = "give a file of finite element points to compare"
        return [Claim("fig6b", text, "both", words, "no points given", "", "open")]
    out = []
    for eta in np.unique(points.eta):
        beam = par.fig6b(float(eta))
        for mu in np.unique(points.mu[points.eta == eta]):
            mine = (points.eta == eta) & (points.mu == mu)
            models = {}
            for law in par.LAWS:
                run = response.twist(beam, mu=float(mu), law=law, at=points.rate[mine])
                models[law] = run["T"].values / (beam.G_B * beam.I)
            if points.compliant is not None:
                models["compliant"] = points.compliant[mine]
            for law, model in models.items():
                with np.errstate(all="ignore"):
                    apart = abs(points.load[mine] / model - 1)
                good = np.isfinite(apart)
                if not good.any():
                    continue
                close = points.rate[mine][good & (apart <= CLOSE)]
                first = points.rate[mine][good & (apart > CLOSE)].min(initial=np.inf)
                reach = close[close < first].max(initial=0.0)
                value = f"{100 * apart[good].max():.1f} %, {reach:.3g} of {points.rate[mine][good].max():.3g} rad/m"
                out.append(
                    Claim(
                        "fig6b",
                        text,
                        law,
                        f"eta = {eta:g}, mu = {mu:g}: largest difference of T; twist rate up to which it is below "
                        f"{100 * CLOSE:g} %",
                        value,
                        "",
                        "yes" if not np.any(apart[good] > CLOSE) else "in part" if reach > 0 else "no",
                    )
                )
    return out

"""The finite element points of Fig. 6b (from ``make fig6b``): read from a file, and compared with the models."""

from __future__ import annotations

import math
import os
from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from squama.curves import doors
from squama.errors import Problems, refuse
from squama.io import tabular
from squama.loads import NOTHING, STRAIGHT
from squama.paper import parameters as par
from squama.paper.parameters import Claim
from squama.types import Array

STORED = Path(__file__).with_name("fig6b_elements.csv")
"""The points of the package."""
COLUMNS = ("eta", "mu", "Phi (rad/m)", "T/(G_B I) (rad/m)")
"""Header of the file: overlap ratio, coefficient of friction, twist rate, torque over G_B times the polar moment."""
COMPLIANT = "compliant joint T/(G_B I) (rad/m)"
"""Optional column, with empty cells allowed: torque of the compliant joint with the stiffness of the same mesh."""
K_THETA, C_F = "K_theta/(E_B d^3)", "C_f"
"""Optional comments of the head, each with a number after a colon: stiffness and inclusion factor of the elements."""
LEAST = {COLUMNS[0]: 1.0, COLUMNS[1]: 0.0, COLUMNS[2]: 0.0}
CLOSE = 0.1
"""Relative difference of torques that counts as agreement."""
HELD_MU, HELD_AT = 0.2, (0.1, 0.15, 0.2)
"""Friction, and twists per pitch (rad), of the claims on the moment that holds a beam straight."""
MOST = 4
"""Largest number of overlap ratios, one panel each."""


class FePoints(NamedTuple):
    """Points in the order of the file; ``source`` is its name.

    ``eta``, ``mu``, ``rate`` (rad/m) and ``load``, T/(G_B I) (rad/m), are (n,). ``compliant`` (n,) is the load of the
    compliant joint, and ``joint`` K_theta (E_B d^3) and C_f of the elements, if given.
    """

    eta: Array
    mu: Array
    rate: Array
    load: Array
    source: str
    compliant: Array | None = None
    joint: tuple[float, float] | None = None


def read_points(path: str | os.PathLike[str]) -> FePoints:
    """Read finite element points from a CSV file with the columns :data:`COLUMNS` in any order, one point a row.

    I is the polar moment of the section. A column :data:`COMPLIANT`, and the comments :data:`K_THETA` and :data:`C_F`
    among leading lines that start with #, are read too. Mistakes are refused with their lines, as are more overlap
    ratios than panels.
    """
    wanted = ", ".join(COLUMNS)
    table = tabular.read(path, missing=f"give a CSV file with the columns {wanted}")
    header, problems = table.header.cells, Problems()
    for c in COLUMNS:
        if c not in header:
            problems.add("", "", f'no column "{c}"', f"the header must be {wanted}", table.line())
        elif header.count(c) > 1:
            problems.add("", "", f'the column "{c}" is given twice', "keep one", table.line())
    problems.settle()
    columns = {c: (header.index(c), partial(_value, c)) for c in (*COLUMNS, COMPLIANT) if c in header}
    _, values, problems = tabular.numbers(table, columns, "point")
    problems.settle()
    eta, mu, rate, load, *rest = np.array(values).T
    if (count := np.unique(eta).size) > MOST:
        refuse("", "", f"has {count} values of eta, the figure has room for {MOST}", "write more files", table.name)
    return FePoints(eta, mu, rate, load, table.name, rest[0] if rest else None, _joint(table))


def _joint(table: tabular.Table) -> tuple[float, float] | None:
    found = dict(line.lstrip("# ").rsplit(": ", 1) for line in table.comments if ": " in line)
    try:
        return float(found[K_THETA]), float(found[C_F])
    except (KeyError, ValueError):
        return None


def _value(column: str, cell: str) -> float:
    """Return the number in a cell, or refuse it; cells of the compliant joint may be empty."""
    if column == COMPLIANT and not cell.strip():
        return math.nan
    value = tabular.number(cell)
    if value < (low := LEAST.get(column, -math.inf)):
        refuse("", tabular.shown_cell(cell), f"must be {low:g} or more")
    return value


def compare(points: FePoints) -> Iterator[Claim]:
    """Yield the differences of the points from both force laws and, if included, the compliant joint.

    For each: the largest difference of the torque, and the twist rate up to which it is below :data:`CLOSE`.
    """
    text = "the model agrees with finite elements"
    for eta in np.unique(points.eta):
        beam = par.fig6b(float(eta))
        for mu in np.unique(points.mu[points.eta == eta]):
            mine = (points.eta == eta) & (points.mu == mu)
            rate, load = points.rate[mine], points.load[mine]
            runs = {
                law: doors.twist(beam, mu=float(mu), law=law, at=rate, joint="hinge", ideal=True) for law in par.LAWS
            }
            models: dict[str, Array] = {law: run["T"].values / (beam.G_B * beam.I) for law, run in runs.items()}
            if points.compliant is not None:
                models["compliant"] = points.compliant[mine]
            at = (f"eta = {eta:g}, mu = {mu:g}",)
            for law, model in models.items():
                with np.errstate(all="ignore"):
                    apart = abs(load / model - 1)
                good = np.isfinite(apart)
                if not good.any():
                    continue
                first = rate[good & (apart > CLOSE)].min(initial=np.inf)
                reach = rate[good & (apart <= CLOSE) & (rate < first)].max(initial=0.0)
                holds = "yes" if first == np.inf else "in part" if reach > 0 else "no"
                over = f"points up to {rate[good].max():.3g} rad/m"
                for what, value, unit in (
                    ("largest difference of T", f"{100 * apart[good].max():.1f}", "%"),
                    (f"twist rate up to which it is below {100 * CLOSE:g} %", f"{reach:.3g}", "rad/m"),
                ):
                    yield Claim("fig6b", text, law, what, (value,), unit, holds, over, at)


def straight(etas: Sequence[float]) -> Iterator[Claim]:
    """Yield the moment that holds the beams straight, and the torque without it, at friction :data:`HELD_MU`."""
    phi = np.array(HELD_AT)
    places = tuple(f"eta = {eta:g}, phi = {angle:g} rad" for eta in etas for angle in HELD_AT)
    rows = []
    for eta in etas:
        beam = par.fig6b(float(eta))
        thin: dict[str, Any] = {"mu": HELD_MU, "at": phi / beam.pitch, "joint": "compliant", "ideal": True}
        kept, free = (doors.respond(beam, "twisting", hold=hold, **thin) for hold in (STRAIGHT, NOTHING))
        rows.append(np.array([kept["M"], free["T"]]) / kept["T"])
    moment, torque = np.concatenate(rows, axis=1)
    text, law = f"the beam is in pure twist (mu = {HELD_MU:g})", "compliant"
    note = "one end of a beam that is fixed, and one that is turned, hold the ends coaxial, not each pitch straight"
    for what, values in (
        ("bending moment that holds it straight, over the torque", moment),
        ("torque without that moment, over the torque", torque),
    ):
        yield Claim("fig6b", text, law, what, tuple(f"{v:.3g}" for v in values.tolist()), "", "no", note, places)

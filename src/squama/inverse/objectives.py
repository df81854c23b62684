"""What is traded off: figures of beams by name, each as large or as small as possible."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from squama.errors import InputError
from squama.inverse import read
from squama.inverse.figures import evaluate, follow, harmless, touched
from squama.inverse.limits import LIMITS, Sizes, law_rooms
from squama.inverse.schema import FrontTable
from squama.inverse.target import Target
from squama.inverse.wants import At, Found, Want
from squama.model.solution import Solution
from squama.model.solve import Array
from squama.study.cells import Cells
from squama.study.columns import valid
from squama.units import shown

NAMES = {
    "tangent": ("N m2", "tangent stiffness in contact at the stated twist", r"$\mathrm{d}T/\mathrm{d}\Phi$"),
    "torque": ("N m", "torque at the stated twist", "$T$"),
    "stiffness": ("N m2", "stiffness before engagement", r"$C_f J G_B$"),
    "range": ("rad", "twist per pitch from engagement to the lock", r"$\phi_\mathrm{lock}-\phi_e$"),
    "lock": ("rad", "twist per pitch at the lock", r"$\phi_\mathrm{lock}$"),
    "engagement": ("rad", "twist per pitch at engagement", r"$\phi_e$"),
    "W_fr": ("J/m", "frictional work at the cut-off before the lock", r"$W_\mathrm{fr}$"),
    "RED": ("1", "relative energy dissipation at the cut-off before the lock", "RED"),
    "critical_mu": ("1", "smallest friction that locks at engagement", r"$\mu_\mathrm{static}$"),
}
"""Objectives by name: unit, words, symbol."""
DECADES = ("tangent", "torque", "stiffness", "W_fr")
"""Objectives that span decades: spread over a front by their logarithm."""
AT_TWIST = ("tangent", "torque")
MOST = 5


class Objective(NamedTuple):
    """A figure that is to be large (``sense`` 1) or small (-1)."""

    name: str
    sense: int
    want: Want

    @property
    def word(self) -> str:
        """Which way is better."""
        return "max" if self.sense > 0 else "min"


class Settings(NamedTuple):
    """What is traded off and how long it is searched; ``given`` is the stated twist in words."""

    objectives: tuple[Objective, ...]
    population: int
    generations: int
    seed: int
    at: At | None
    given: str


def settings(table: FrontTable, context: read.Context) -> Settings:
    """Read the table [front].

    Raises
    ------
    InputError
        One line per mistake.
    """
    problems: list[str] = []
    at: At | None = None
    if table.at is not None:
        try:
            at, _ = read.twist("front.at", table.at, context)
        except InputError as error:
            problems.append(str(error))
    found: list[Objective] = []
    for key, sense in (("maximise", 1), ("minimise", -1)):
        names = getattr(table, key)
        if not isinstance(names, list | tuple):
            problems.append(f'front.{key} = {shown(names)}: is no list; write e.g. {key} = ["tangent", "range"]')
            continue
        for name in names:
            if name not in NAMES:
                meant = read.guess(str(name), NAMES)
                problems.append(f"front.{key}: {shown(name)} is not known; {meant}allowed: {', '.join(NAMES)}")
            elif name in [o.name for o in found]:
                problems.append(f"front.{key}: {name} is given twice; keep one")
            else:
                found.append(Objective(name, sense, Want(name, at if name in AT_TWIST else None)))
                if name in AT_TWIST and table.at is None:
                    problems.append(f'front.at: is missing; {name} needs a twist, write e.g. at = "60 deg total"')
    if not problems and not 2 <= len(found) <= MOST:
        problems.append(f"[front]: names {len(found)} objectives; give 2 to {MOST} in maximise and minimise")
    numbers = {}
    for key, low, high in (("population", 8, 10_000), ("generations", 1, 100_000), ("seed", 0, 2**31 - 1)):
        value = getattr(table, key)
        if isinstance(value, bool) or not isinstance(value, int) or not low <= value <= high:
            problems.append(f"front.{key} = {shown(value)}: is not a whole number from {low} to {high}")
        else:
            numbers[key] = value
    if problems:
        raise InputError("\n".join(problems))
    words = "" if at is None else str(table.at)
    return Settings(tuple(found), numbers["population"], numbers["generations"], numbers["seed"], at, words)


class Seen(NamedTuple):
    """Designs as the search sees them: objectives (n, k), violations (n,), figures, columns, and paths.

    A violation is 0 where the design is a beam, has all figures and keeps all limits.
    """

    values: Array
    violation: Array
    found: Found
    cells: Cells
    sol: Solution


class Trade:
    """Objectives and limits of many designs."""

    def __init__(self, target: Target, chosen: Settings) -> None:
        self.target, self.chosen = target, chosen
        self.space = target.space
        self.lock = "strain" in target.limits
        self.wants = [o.want for o in chosen.objectives] + [Want("lock")] * self.lock

    def evaluate(self, y: Array, *, plates: bool) -> Seen:
        """Evaluate points (n, m) of the unit cube."""
        c = self.space.cells(y)
        good = valid(c)
        safe = harmless(c, good)
        sol, limit = follow(safe, self.target.options, plates=plates)
        found = evaluate(safe, [], self.wants, self.target.options, plates=plates, followed=(sol, limit))
        k = len(self.chosen.objectives)
        values = found.values[:k].T
        if self.chosen.at is not None:
            # stiffness is traded off in contact: before engagement it is "stiffness"
            apart = sol.load_e >= self.chosen.at.per_pitch(safe.d)
            for i, o in enumerate(self.chosen.objectives):
                if o.name == "tangent":
                    values[apart, i] = np.nan
        rate = np.zeros(len(y)) if self.chosen.at is None else self.chosen.at.per_pitch(c.d) / c.d
        if self.lock:
            rate = np.maximum(rate, np.nan_to_num(found.values[-1]) / c.d)
        s = Sizes.of(c, self.space.beam.scales, self.space.load, rate)
        rooms: dict[str, Any] = {name: LIMITS[name].room(s, value) for name, value in self.target.limits.items()}
        rooms |= law_rooms(s, self.target.laws)
        broken = sum(np.maximum(-np.broadcast_to(room, len(y)), 0.0) for room in rooms.values())
        missing = ~np.isfinite(values).all(axis=1)
        violation = np.where(good, np.nan_to_num(broken, nan=1.0), 2.0) + missing
        return Seen(values, violation, found, c, sol)

    def alone(self, seen: Seen, index: Array) -> Array:
        """Tell which of some designs no other contact of their plates ends before their paths do."""
        engaged = np.isfinite(seen.sol.load_e[index])
        out = np.ones(index.size, bool)
        out[engaged] = ~touched(seen.cells, seen.sol, index[engaged], self.target.options)
        # where nothing engages other plates may touch all the same
        out[~engaged] = self.target.options.load == "bending"
        return out

    def costs(self, values: Array) -> Array:
        """Return objectives (n, k) as costs: less is better, and those that span decades by their logarithm."""
        columns = []
        for o, column in zip(self.chosen.objectives, values.T, strict=True):
            good = np.isfinite(column)
            if o.name in DECADES:
                good &= column > 0
                column = np.log(np.where(good, column, 1.0))  # noqa: PLW2901
            columns.append(-o.sense * np.where(good, column, 0.0))
        return np.stack(columns, axis=1)


def dominated(values: Array, by: Array) -> Array:
    """Tell which points (n, k) are dominated by one of the points ``by`` (m, k), all to be as small as possible."""
    out = np.zeros(len(values), bool)
    for low in range(0, len(values), 256):
        part = values[low : low + 256, None]
        worse = np.all(by <= part, axis=2) & np.any(by < part, axis=2)
        out[low : low + 256] = np.any(worse, axis=1)
    return out

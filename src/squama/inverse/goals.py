"""Goals of a target: figures and required values, read from the table [target]; a design's distance from them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Generic, NamedTuple, NoReturn

import numpy as np

from squama.errors import Problems, refuse
from squama.inverse import targetfile
from squama.inverse.named_figures import FIGURES, At, Number, Want
from squama.inverse.space import Space
from squama.inverse.targetfile import AT_POINTS, GOALS, Context, File, Table
from squama.io import files, measured
from squama.loads import LOADS
from squama.model.sensitivity import STEP
from squama.study.columns import Cells
from squama.types import Array
from squama.units import Dimension, look_up, shown

ACCEPT = 0.01
"""Largest relative difference at which a goal counts as reached."""
LABELS = {"tangent": "tangent", "stiffness_ratio": "stiffness ratio", "strength_share": "stress over strength"}
MOST_POINTS = 24
"""Largest number of points of a measured curve; longer curves are thinned out evenly."""
SENSES = {"=": "", ">=": "at least ", "<=": "at most "}
"""Words before a required value."""


class Pitches(NamedTuple, Generic[Number]):
    """Pitch ``d`` (m) and number of scales of designs; numbers or arrays."""

    d: Number
    scales: Number

    @staticmethod
    def of(every: Sequence[Cells], n: int) -> Pitches[Array]:
        """Return pitches and numbers of scales of sets of columns, shape (sets, n)."""
        d, scales = [c.d for c in every], [c.sizes["beam"]["scales"] for c in every]
        return Pitches(np.reshape(d, (-1, n)), np.reshape(scales, (-1, n)))


class Goal(NamedTuple):
    """One required figure.

    ``name`` is its place in the file, ``number`` and ``unit`` stand as given. A required twist is an :class:`At` in
    ``twist``, other values are ``asked`` in SI units. ``sense`` is "=", ">=" or "<=". Differences are divided by
    ``scale`` (SI; 0: the required value) and multiplied by ``weight``. Goals of one ``group`` are reported together.
    """

    name: str
    want: Want
    number: float
    unit: str
    asked: float = 0.0
    twist: At | None = None
    sense: str = "="
    weight: float = 1.0
    scale: float = 0.0
    group: str = ""

    def value(self, d: Number, scales: Number | float = 1.0) -> Number:
        """Return the required value in SI units (twists: rad per pitch) for pitches d (m) and numbers of scales."""
        return self.asked + 0 * d if self.twist is None else self.twist.per_pitch(d, scales)

    def shown(self, reached: float, d: float, scales: float) -> float:
        """Return a reached figure (SI) in the unit of the goal."""
        return float(self.number * reached / self.value(d, scales))

    def met(self, reached: float, d: float, scales: float, accept: float) -> bool:
        """Return whether a reached figure (SI) meets the goal to within the share ``accept``."""
        difference = float(self.relative(reached, d, scales))
        return (difference >= -accept or self.sense == "<=") and (difference <= accept or self.sense == ">=")

    def relative(self, reached: Number, d: Number, scales: Number | float) -> Number:
        """Return the difference of a figure (SI) from the goal, over ``scale`` or the goal; complex steps pass."""
        asked = self.value(d, scales)
        return (reached - asked) / (self.scale or asked)

    def slope(self, reached: Array, slopes: Array, moved: Pitches[Array]) -> Array:
        """Return derivatives (variables, designs) of :meth:`relative`; 0 where there is no figure."""
        known = np.where(np.isfinite(reached), reached, 0.0)
        return np.asarray(np.imag(self.relative(known + 1j * STEP * slopes, *moved)) / STEP)


@dataclass(frozen=True)
class Reached:
    """One goal of a design, in the unit of the target.

    ``difference`` is reached minus required; ``effects`` by dimension are derivative times tolerance, ``spread`` is the
    root of the sum of their squares. A measured curve is one goal: ``reached`` is then the rms difference of its
    points. A figure that the design does not have is NaN.
    """

    name: str
    unit: str
    sense: str
    asked: float
    reached: float
    difference: float
    met: bool
    spread: float = math.nan
    effects: dict[str, float] = field(default_factory=dict, repr=False)

    @property
    def wanted(self) -> str:
        """The goal as text: "at least 5", "45 deg total"."""
        return f"{SENSES[self.sense]}{self.asked:.5g} {self.unit}".strip()


def reached(
    goals: Sequence[Goal],
    values: Array,
    own: Pitches[float],
    accept: float,
    effects: Array | None = None,
    names: Sequence[str] = (),
) -> list[Reached]:
    """Return the reached goals of one design from its figures (goals,) in SI; ``effects`` (goals, dimensions)."""
    by = np.zeros((len(goals), 0)) if effects is None else effects
    found: list[tuple[tuple[str, str, str, float], float, bool, Array]] = []
    for k, goal in enumerate(goals):
        if not goal.group:
            asked, met = (goal.name, goal.unit, goal.sense, goal.number), goal.met(float(values[k]), *own, accept)
            found.append((asked, goal.shown(values[k], *own), met, goal.number * by[k]))
    for group in dict.fromkeys(goal.group for goal in goals if goal.group):
        those = [k for k, goal in enumerate(goals) if goal.group == group]
        scale = goals[those[0]].scale
        off = float(_rms(values[those] - [goals[k].asked for k in those]))
        found.append(((f"{group}, rms", "N m", "=", 0.0), off, off / scale <= accept, scale * _rms(by[those])))
    spreads = [float(np.linalg.norm(change)) if names else math.nan for *_, change in found]
    return [
        Reached(*asked, value, value - asked[3], met, spread, dict(zip(names, change.tolist(), strict=True)))
        for (asked, value, met, change), spread in zip(found, spreads, strict=True)
    ]


def _rms(values: Array) -> Array:
    return np.asarray(np.sqrt(np.mean(np.square(values), axis=0)))


def read_goals(file: File, context: Context, folder: Path, problems: Problems) -> tuple[Goal, ...]:
    """Read all goals; mistakes are added to ``problems``."""
    found, table = list[Goal](), file.table("target")
    for name in GOALS:
        if (value := table.get(name)) is not None:
            with problems.caught():
                found.append(_single(name, value, context))
    for key, points in file.points.items():
        for i, point in enumerate(points):
            with problems.caught():
                found += _points(f"target.{key}[{i}]", point, key, context)
    if (curve := table.get("curve")) is not None:
        with problems.caught():
            found += _curve(curve, context, folder)
    return tuple(found)


def _single(name: str, value: object, context: Context) -> Goal:
    """Read a goal of one figure: its value, or a table of value and weight."""
    where, weight = f"target.{name}", 1.0
    if isinstance(value, dict):
        if unknown := [key for key in value if key not in ("value", "weight")]:
            refuse(f"{where}.{unknown[0]}", "", "unknown key", "allowed: value, weight")
        if "value" not in value:
            refuse(where, "", "has no value", "write { value = ..., weight = 2 }")
        weight, value = _weight(where, value.get("weight", 1.0)), value["value"]
    return _goal(where, name, Want(name), value, weight, context)


def _goal(where: str, name: str, want: Want, value: object, weight: float, context: Context) -> Goal:
    """Read the required value of a figure."""
    figure = want.figure
    if figure in ("lock", "engagement"):
        got = targetfile.twist(where, value, context)
    else:
        dimension, *_ = look_up(FIGURES[figure][0]) or (Dimension.RATIO,)
        got = targetfile.quantity(where, value, dimension, context)
    if figure == "RED" and got.si >= 1:
        refuse(where, shown(got.number), "a part of the work cannot be 1 or more", "write e.g. 0.4")
    if figure == "critical_mu" and got.si > 10:
        refuse(where, shown(value), "is out of range (up to 10)", "write e.g. 0.6")
    return Goal(name, want, got.number, got.unit, got.si, got.at, got.sense, weight)


def _points(where: str, table: Table, kind: str, context: Context) -> list[Goal]:
    """Read the goals at one twist: figures of a point, or a tangent stiffness."""
    at = targetfile.twist(f"{where}.twist", table["twist"], context).at
    torques = ("torque", *AT_POINTS, LOADS[context.load].torque_words)
    allowed = dict.fromkeys(torques if kind == "points" else ("stiffness",))
    given = {key: value for key, value in table.items() if key not in ("twist", "weight") and value is not None}
    for key in given:
        if key not in allowed:
            refuse(f"{where}.{key}", "", "does not belong here", f"allowed: twist, {', '.join(allowed)}, weight")
        if key in AT_POINTS and context.joint == "hinge":
            refuse(f"{where}.{key}", "", "is not a figure of hinges", f"leave out {' and '.join(context.hinged)}")
    if not given:
        refuse(f"{where}.{next(iter(allowed))}", "", "is missing", f"write e.g. {targetfile.EXAMPLES[kind]}")
    twist = table["twist"].strip() if isinstance(table["twist"], str) else f"{shown(table['twist'])} rad/m"
    weight, found = _weight(where, table.get("weight", 1.0)), []
    for key, value in given.items():
        figure = _figure(key, value)
        name = f"{LABELS.get(figure, key)} at {twist}"
        found.append(_goal(f"{where}.{key}", name, Want(figure, at), value, weight, context))
    return found


def _figure(key: str, value: object) -> str:
    """Return the name of the figure for a key of a point."""
    if key == "stress" and isinstance(value, str) and value.strip().endswith("%"):
        return "strength_share"
    return {"stiffness": "tangent", "moment": "torque"}.get(key, key)


def _curve(value: object, context: Context, folder: Path) -> list[Goal]:
    """Read a measured curve as goals; points without twist or torque are left out."""
    if not isinstance(value, str):
        refuse("target.curve", shown(value), "is no file name", 'write e.g. curve = "test.csv"')
    path = folder / value
    every = [measured.read(path, pitch=p, scales=n, load=context.load) for p, n in context.beams]
    one = every[0]

    def bad(reason: str, remedy: str = "") -> NoReturn:
        refuse("", "", reason, remedy, files.label(path))

    seen: dict[float, int] = {}
    for i, (rate, load) in enumerate(zip(one.rate, one.load, strict=True)):
        if rate < 0 or load < 0:
            bad("a twist or torque is below 0", "give the loading curve as magnitudes")
        if one.load[j := seen.setdefault(float(rate), i)] != load:
            bad(f"points {j + 1} and {i + 1} have one twist and two torques", "give the loading curve alone")
    keep = np.flatnonzero((one.rate > 0) & (one.load > 0))
    if keep.size == 0:
        bad("has no point with a twist and a torque above 0")
    if keep.size > MOST_POINTS:
        keep = keep[np.linspace(0, keep.size - 1, MOST_POINTS).round().astype(int)]
    scale, weight = float(one.load.max()), 1 / np.sqrt(keep.size)
    made = []
    for i in keep.tolist():
        load = float(one.load[i])
        at = targetfile.common_twist([float(read.rate[i]) for read in every], context)
        want = Want("torque", at)
        made.append(Goal(f"curve[{i}]", want, load, "N m", asked=load, weight=weight, scale=scale, group="curve"))
    return made


def _weight(where: str, value: object) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not 0 < value < np.inf:
        refuse(f"{where}.weight", shown(value), "must be a number above 0", "write e.g. 2")
    return float(value)


def conflicts(found: tuple[Goal, ...], space: Space, problems: Problems) -> None:
    """Add contradictory pairs of goals, and goals that need friction, to the problems."""
    if not found and not problems:
        known = "allowed: lock, engagement, stiffness, RED, critical_mu, length, points, tangent, curve"
        problems.add("[target]", "", "asks for nothing", known)
    single = {goal.name: goal for goal in found}
    pitch = next((v for v in space.variables if v.name == "beam.pitch"), None)
    pitches = np.array([space.beam.pitch] if pitch is None else [pitch.low, pitch.high])
    lock, engagement, red = (single.get(name) for name in ("lock", "engagement", "RED"))
    if lock and lock.sense != ">=":
        if engagement and engagement.sense != "<=" and np.all(engagement.value(pitches) >= lock.value(pitches)):
            problems.add("target.lock", "", "must be larger than target.engagement: scales engage before they lock")
        for goal in found:
            if goal.want.at is not None and np.all(goal.want.at.per_pitch(pitches) >= lock.value(pitches)):
                problems.add(f"target: {goal.name}", "", f"is at or beyond the lock at {lock.number:g} {lock.unit}")
                break
    seen: dict[Want, Goal] = {}
    for goal in found:
        other = seen.setdefault(goal.want, goal)
        if other is goal:
            continue
        same = (other.asked, other.sense) == (goal.asked, goal.sense)
        if not same and "=" in (other.sense, goal.sense):
            a, b = (f"{g.number:g} {g.unit}".strip() for g in (other, goal))
            problems.add(f"target: {goal.name}", "", f"is asked twice, {a} and {b}", "keep one")
        elif other.sense == goal.sense == "=":
            problems.add(f"target: {goal.name}", "", "is given twice", "keep one")
    most = max((v.high for v in space.variables if v.key == "mu"), default=space.beam.friction.mu or 0.0)
    if red and red.sense != "<=" and most == 0:
        problems.add("target.RED", "", "needs friction", "give friction.mu or vary it")

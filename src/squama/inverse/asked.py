"""Goals from the table [target], and what in them contradicts the physics or itself."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from squama import files, measured
from squama.errors import InputError
from squama.inverse import read, schema
from squama.inverse.goals import Goal
from squama.inverse.space import Space
from squama.inverse.wants import At, Want
from squama.units import Dimension, shown

MOST_POINTS = 24
"""Points of a measured curve that are used; more are thinned out evenly."""
_TWISTS = ("lock", "engagement")


def goals(table: schema.TargetTable, context: read.Context, folder: Path, problems: list[str]) -> tuple[Goal, ...]:
    """Read all goals; add one line per mistake to the problems."""
    found: list[Goal] = []

    def attempt(make: Any, *arguments: Any) -> None:
        try:
            made = make(*arguments)
            found.extend(made if isinstance(made, list) else [made])
        except InputError as error:
            problems.extend(str(error).splitlines())

    for name in ("lock", "engagement", "stiffness", "RED", "critical_mu"):
        if (value := getattr(table, name)) is not None:
            attempt(_single, name, value, context)
    for i, point in enumerate(table.points):
        attempt(_point, f"points[{i}]", point, "torque", context)
    for i, point in enumerate(table.tangent):
        attempt(_point, f"tangent[{i}]", point, "tangent", context)
    if table.curve is not None:
        attempt(_curve, table.curve, context, folder)
    return tuple(found)


def _single(name: str, value: Any, context: read.Context) -> Goal:
    """Read a goal of one figure: its value, or a table of value and weight."""
    where, weight = f"target.{name}", 1.0
    if isinstance(value, dict):
        if unknown := [key for key in value if key not in ("value", "weight")]:
            message = f"{where}.{unknown[0]}: unknown key; allowed: value, weight"
            raise InputError(message)
        if "value" not in value:
            message = f"{where}: has no value; write {{ value = ..., weight = 2 }}"
            raise InputError(message)
        weight, value = _weight(where, value.get("weight", 1.0)), value["value"]
    if name in _TWISTS:
        at, got = read.twist(where, value, context)
        return Goal(name, Want(name), got.number, got.unit, twist=at, sense=got.sense, weight=weight)
    if name == "stiffness":
        got = read.rigidity(where, value, context)
    else:
        got = read.quantity(where, value, Dimension.RATIO, context, "")
        if name == "RED" and got.si >= 1:
            read.refuse(where, value, "a part of the work cannot be 1 or more; write e.g. 0.4")
        if name == "critical_mu" and got.si > 10:
            read.refuse(where, value, "is out of range (up to 10); write e.g. 0.6")
    return Goal(name, Want(name), got.number, got.unit, asked=got.si, sense=got.sense, weight=weight)


def _point(name: str, table: schema.PointTable, figure: str, context: read.Context) -> Goal:
    """Read a torque (moment) or a tangent stiffness at a twist."""
    where = f"target.{name}"
    at, _ = read.twist(f"{where}.twist", table.twist, context)
    key = "stiffness" if figure == "tangent" else "torque"
    if context.load == "bending" and figure == "torque" and table.moment is not None:
        key = "moment"
    value = getattr(table, key)
    for other in ("torque", "moment", "stiffness"):
        if other != key and getattr(table, other) is not None:
            message = f"{where}.{other}: does not belong here; allowed: twist, {key}, weight"
            raise InputError(message)
    if value is None:
        message = f"{where}.{key}: is missing; write e.g. {schema.EXAMPLES['points' if figure == 'torque' else figure]}"
        raise InputError(message)
    if figure == "tangent":
        got = read.rigidity(f"{where}.{key}", value, context)
    else:
        got = read.quantity(f"{where}.{key}", value, Dimension.TORQUE, context, "N m")
    weight = _weight(where, table.weight)
    label = f"{key if figure == 'torque' else 'tangent'} at {_words(table.twist)}"
    return Goal(label, Want(figure, at), got.number, got.unit, asked=got.si, sense=got.sense, weight=weight)


def _words(value: object) -> str:
    return value.strip() if isinstance(value, str) else f"{shown(value)} rad/m"


def _curve(value: Any, context: read.Context, folder: Path) -> list[Goal]:
    """Read a measured curve; points before any twist are left out."""
    if not isinstance(value, str):
        read.refuse("target.curve", value, 'is no file name; write e.g. curve = "test.csv"')
    path = folder / value
    one, two = (measured.read(path, pitch=p, scales=context.scales, load=context.load) for p in (1.0, 2.0))
    name = files.label(path)
    seen: dict[float, int] = {}
    for i, (rate, load) in enumerate(zip(one.rate, one.load, strict=True)):
        if rate < 0 or load < 0:
            message = f"{name}: a twist or torque is below 0; give the loading curve as magnitudes"
            raise InputError(message)
        if one.load[j := seen.setdefault(float(rate), i)] != load:
            message = f"{name}: points {j + 1} and {i + 1} have one twist and two torques; give the loading curve alone"
            raise InputError(message)
    keep = np.flatnonzero((one.rate > 0) & (one.load > 0))
    if keep.size == 0:
        message = f"{name}: has no point with a twist and a torque above 0"
        raise InputError(message)
    if keep.size > MOST_POINTS:
        keep = keep[np.linspace(0, keep.size - 1, MOST_POINTS).round().astype(int)]
    scale, weight = float(one.load.max()), 1 / np.sqrt(keep.size)
    made = []
    for i in keep.tolist():
        rate, load = float(one.rate[i]), float(one.load[i])
        # a column over a length is the same for every pitch, one per pitch or of the whole beam is not
        at = At(rate, 0.0) if one.rate[i] == two.rate[i] else At(0.0, rate)
        want = Want("torque", at)
        made.append(Goal(f"curve[{i}]", want, load, "N m", asked=load, weight=weight, scale=scale, group="curve"))
    return made


def _weight(where: str, value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not 0 < value < np.inf:
        read.refuse(f"{where}.weight", value, "must be a number above 0; write e.g. 2")
    return float(value)


def conflicts(found: tuple[Goal, ...], space: Space, problems: list[str]) -> None:
    """Add a line for every pair of goals that no beam can meet, and for goals that friction alone excludes."""
    if not found and not problems:
        known = "lock, engagement, stiffness, RED, critical_mu, points, tangent, curve"
        problems.append(f"[target]: asks for nothing; allowed: {known}")
    single = {goal.name: goal for goal in found}
    pitches = np.array([v.low for v in space.variables if v.name == "beam.pitch"] or [space.beam.pitch])
    pitches = np.append(pitches, [v.high for v in space.variables if v.name == "beam.pitch"])
    lock, engagement, red = (single.get(name) for name in ("lock", "engagement", "RED"))

    def beyond(a: Any, b: Any) -> bool:
        return bool(np.all(a.twist.per_pitch(pitches) >= b.twist.per_pitch(pitches)))

    if lock and engagement and lock.sense != ">=" and engagement.sense != "<=" and beyond(engagement, lock):
        problems.append("target.lock: is not beyond target.engagement, but scales engage before they lock")
    if lock and lock.sense != ">=":
        for goal in found:
            at = goal.want.at
            if at is not None and np.all(at.per_pitch(pitches) >= lock.value(pitches)):
                problems.append(f"target: {goal.name}: is at or beyond the lock at {lock.number:g} {lock.unit}")
                break
    seen: dict[Want, Goal] = {}
    for goal in found:
        other = seen.setdefault(goal.want, goal)
        if (
            other is not goal
            and (other.asked, other.sense) != (goal.asked, goal.sense)
            and "=" in (other.sense, goal.sense)
        ):
            a, b = (f"{g.number:g} {g.unit}".strip() for g in (other, goal))
            problems.append(f"target: {goal.name}: is asked twice, {a} and {b}; keep one")
        elif other is not goal and {other.sense, goal.sense} == {"="}:
            problems.append(f"target: {goal.name}: is given twice; keep one")
    most = max((v.high for v in space.variables if v.key == "mu"), default=space.beam.friction.mu or 0.0)
    if red and red.sense != "<=" and most == 0:
        problems.append("target.RED: no work is dissipated without friction; give friction.mu or vary it")

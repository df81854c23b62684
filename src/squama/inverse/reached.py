"""What a design reaches of its goals, by the model that found it and by others."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from squama.inverse.goals import Goal, Pitches
from squama.types import Array

SENSES = {"=": "", ">=": "at least ", "<=": "at most "}
"""Words before an asked value."""


@dataclass(frozen=True)
class Reached:
    """One goal of a design, in the unit in which it was asked.

    ``difference`` is reached minus asked; ``spread`` the root of the sum of squares of ``effects``, which are
    derivative times tolerance by dimension. A measured curve is one goal: ``reached`` is then the rms difference of its
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
        """Goal in words: "at least 5", "45 deg total"."""
        return f"{SENSES[self.sense]}{self.asked:.5g} {self.unit}".strip()


@dataclass(frozen=True)
class Beside:
    """What a design reaches by another model than the one that found it.

    ``key`` is "door" (``squama.twist`` or ``squama.bend`` of the file, as everybody calls them), "endless" (without
    ends) or "free_to_bow" (without the bending moment that holds it straight); ``words`` say so; ``goals`` are those
    that may differ there; ``note``: why a figure is missing.
    """

    key: str
    words: str
    goals: tuple[Reached, ...]
    note: str = ""

    @property
    def agrees(self) -> bool:
        """Whether every goal is met here, too; what has no ends is told only for comparison."""
        return self.key == "endless" or (all(goal.met for goal in self.goals) and bool(self.goals or not self.note))

    def says(self, goal: Reached) -> str:
        """Return what is reached of a goal here, in words: "4.9 with 10 scales"."""
        value = f"{goal.reached:.3g} {goal.unit}".strip()
        if self.key == "door":
            return f"{self.words} has none" if math.isnan(goal.reached) else f"{self.words} says {value}"
        return f"{'not known' if math.isnan(goal.reached) else value} {self.words}"


def reached(
    goals: Sequence[Goal],
    values: Array,
    own: Pitches,
    accept: float,
    effects: Array | None = None,
    names: Sequence[str] = (),
) -> list[Reached]:
    """Return the reached goals of a design by its figures (goals,) in SI; points of a curve are one goal.

    ``own`` are the design's pitch and number of scales, ``effects`` (goals, dimensions) what tolerances do, over the
    asked values, by the ``names`` of the dimensions.
    """
    found: list[Reached] = []
    if effects is None:
        effects = np.zeros((len(goals), 0))

    def add(goal: tuple[str, str, str, float], value: float, by: Array, *, met: bool) -> None:
        spread = float(np.linalg.norm(by)) if names else math.nan
        found.append(Reached(*goal, value, value - goal[3], met, spread, dict(zip(names, by.tolist(), strict=True))))

    for k, goal in enumerate(goals):
        if not goal.group:
            met = goal.met(float(values[k]), *own, accept)
            one = (goal.name, goal.unit, goal.sense, goal.number)
            add(one, goal.shown(values[k], *own), goal.number * effects[k], met=met)
    for group in dict.fromkeys(goal.group for goal in goals if goal.group):
        those = [k for k, goal in enumerate(goals) if goal.group == group]
        scale = goals[those[0]].scale
        off = float(_rms(values[those] - [goals[k].asked for k in those]))
        add((f"{group}, rms", "N m", "=", 0.0), off, scale * _rms(effects[those]), met=off / scale <= accept)
    return found


def _rms(values: Array) -> Array:
    return np.asarray(np.sqrt(np.mean(np.square(values), axis=0)))

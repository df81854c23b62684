"""What is asked of a beam: goals, each one figure, and how far a design is from them."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from squama.inverse.wants import At, Want
from squama.model.solve import Array

MISSING = 100.0
"""Residual of a design that has no such figure, e.g. does not lock; reached figures are relative to the asked ones."""
ACCEPT = 0.01
"""Largest difference, relative to what is asked, of a goal that counts as reached."""


class Goal(NamedTuple):
    """One figure that is asked for.

    ``name`` is its place in the file, ``number`` and ``unit`` as they were given. Twists are asked as an :class:`At`,
    the rest as ``asked`` in SI units. ``sense`` is "=", ">=" or "<=". Differences are divided by ``scale`` (SI; the
    asked value itself where it is 0), and weigh ``weight``. Goals of one ``group`` are reported together.
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

    def value(self, d: Any) -> Any:
        """Asked value in SI units (twists in rad per pitch) for designs with the pitch d."""
        return self.asked + 0 * d if self.twist is None else self.twist.per_pitch(d)

    def shown(self, reached: Any, d: Any) -> Any:
        """Return a reached figure in the unit of the goal."""
        return self.number * reached / self.value(d)


class Residual(NamedTuple):
    """Weighted relative differences (goals, designs), and derivatives (goals, variables, designs)."""

    r: Array
    slopes: Array


def residual(
    goals: tuple[Goal, ...], values: Array, slopes: Array, d: Array, d_slopes: Array, short: Array
) -> Residual:
    """Return how far designs are from the goals.

    Parameters
    ----------
    goals : tuple of Goal
        What is asked.
    values, slopes : array
        Figures (goals, designs) and their derivatives (goals, variables, designs).
    d, d_slopes : array
        Pitches, and their derivatives (variables, designs).
    short : array
        How much of the asked twist a design lacks (goals, designs), for those that have no figure.
    """
    r, J = np.empty_like(values), np.zeros_like(slopes)
    for i, goal in enumerate(goals):
        asked = goal.value(d)
        scale = goal.scale or asked
        difference = (values[i] - asked) / scale
        by_pitch = 0.0
        if goal.twist is not None and goal.twist.rate:
            by_pitch = -values[i] * goal.twist.rate / asked**2 * d_slopes
        slope = slopes[i] / scale + by_pitch
        if goal.sense != "=":
            slack = difference >= 0 if goal.sense == ">=" else difference <= 0
            difference, slope = np.where(slack, 0.0, difference), np.where(slack, 0.0, slope)
        missing = ~np.isfinite(difference)
        r[i] = goal.weight * np.where(missing, MISSING + short[i], difference)
        J[i] = goal.weight * np.where(missing, 0.0, slope)
    return Residual(r, J)


def within(goal: Goal, reached: float, d: float, accept: float) -> bool:
    """Whether a reached figure counts as what was asked."""
    asked = float(goal.value(d))
    difference = (reached - asked) / (goal.scale or asked)
    if goal.sense == ">=":
        return difference >= -accept
    if goal.sense == "<=":
        return difference <= accept
    return abs(difference) <= accept

"""The solids of the beam itself: a scale with its tab, the substrate with its slots."""

from __future__ import annotations

from math import tan

import numpy as np

from squama.fabrication.place import Plan
from squama.fabrication.recipe import BENCH, Array, Recipe, block


def scale(plan: Plan) -> Recipe:
    """Return one scale lying flat: its length along the first axis, the base at 0, its lower face at height 0."""
    t, b = plan.thickness, plan.breadth / 2
    whole = block((-plan.embedded, -b, 0), (plan.length, b, t))
    return Recipe("scale", whole, (), (plan.length + plan.embedded) * plan.breadth * t)


def seat(plan: Plan, k: int, thickness: float) -> tuple[Array, Array]:
    """Return rotation and shift that bring a flat scale or blade to its place k on the bar (along, across, up; mm)."""
    turn = BENCH @ plan.axes.T
    low = np.array([0.0, 0.0, -thickness / 2])
    return turn, turn @ low + bench(plan, plan.base(k))


def bench(plan: Plan, point: Array) -> Array:
    """Return a point of the beam as (along, across, up), the bar's lower face at height 0."""
    return np.asarray(BENCH @ point + [0.0, 0.0, plan.height / 2])


def on_bench(plan: Plan, solid: Recipe) -> Recipe:
    """Return a solid of the beam's frame as (along, across, up), the bar's lower face at height 0."""
    return solid.moved(BENCH, (0.0, 0.0, plan.height / 2))


def substrate(plan: Plan) -> Recipe:
    """Return the bar with its ends and slots, the scaled face up.

    The volume of a slot below the face is t (L + c) 2 (b + c), t its thickness: its mouth is cut off obliquely, but as
    much is lost above the middle plane as is won below.
    """
    deep, across, t = plan.slot
    x, y = plan.width / 2, plan.height / 2
    whole = block((-x, -y, 0), (x, y, plan.total))
    out = t / 2 / tan(plan.theta0) + t + 1
    cuts = [
        block((-deep, -across / 2, -t / 2), (out, across / 2, t / 2), plan.axes, plan.base(k))
        for k in range(plan.scales)
    ]
    volume = plan.width * plan.height * plan.total - plan.scales * deep * across * t
    return on_bench(plan, Recipe("substrate", whole, tuple(cuts), volume))

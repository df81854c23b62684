"""How much the reached figures change with the tolerance of each dimension: derivative times tolerance."""

from __future__ import annotations

import numpy as np

from squama.inverse.figures import evaluate
from squama.inverse.problem import Problem
from squama.inverse.space import of_beam, stepped
from squama.model.sensitivity import STEP
from squama.model.solve import Array


def sizes(problem: Problem, y: Array) -> dict[str, Array]:
    """Return the tolerance of every dimension (by key) for designs y (n, m), SI."""
    values = problem.space.values(y)
    beam, load = problem.space.beam, problem.space.load
    found = {}
    for key, size in problem.target.tolerance.items():
        here = np.broadcast_to(values.get(key, of_beam(beam, load, key)), len(y))
        found[key] = np.abs(here) * -size if size < 0 else np.full(len(y), size)
    return found


def effects(problem: Problem, y: Array) -> Array:
    """Change of each goal's figure by the tolerance of each dimension.

    Parameters
    ----------
    problem : Problem
        The target.
    y : array
        Designs (n, m) in the unit cube.

    Returns
    -------
    array
        (goals, dimensions, n): derivative times tolerance, in units of the asked value (of ``scale`` where a goal has
        one). Dimensions in the order of the target's tolerances. A twist that is asked as a rate is compared at the
        design's own pitch.
    """
    space, goals = problem.space, problem.target.goals
    values = space.values(y)
    steps = sizes(problem, y)
    moved = [stepped(space.beam, space.load, values, key, size, len(y)) for key, size in steps.items()]
    c = space.cells(y)
    found = evaluate(c, moved, [goal.want for goal in goals], problem.target.options, plates=False)
    by_pitch = np.stack([np.imag(v.d) / STEP for v in moved])
    out = np.array(found.slopes)
    for i, goal in enumerate(goals):
        asked = goal.value(c.d)
        out[i] /= goal.scale or asked
        if goal.twist is not None and goal.twist.rate:
            out[i] -= found.values[i] * goal.twist.rate / asked**2 * by_pitch
    return out

"""How each measured point was reached: turning points of a record, and which way friction acts.

A rigid scale neither slips nor moves while the contact turns round, so that at the twist of a turning point any torque
between both branches is possible (docs, theory: cycles). Such points tell the drop, not a branch, and are set apart.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from squama.model.solve import Array


class Ways(NamedTuple):
    """For each point: ``direction`` +1 or -1 in which the twist moved last ``stuck`` at a turn.

    ``turns`` are the places of the turning points.
    """

    direction: NDArray[np.int64]
    stuck: NDArray[np.bool_]
    turns: list[int]


def turning_points(values: Array, tolerance: float) -> list[int]:
    """Places of the turning points of a record: the twist then goes back by more than ``tolerance``."""
    found: list[int] = []
    low = high = 0
    direction = 0
    for i in range(1, values.size):
        if direction >= 0 and values[i] > values[high]:
            high = i
        if direction <= 0 and values[i] < values[low]:
            low = i
        if direction >= 0 and values[high] - values[i] > tolerance:
            if direction:
                found.append(high)
            direction, low = -1, i
        elif direction <= 0 and values[i] - values[low] > tolerance:
            if direction:
                found.append(low)
            direction, high = 1, i
    return found


def ways(values: Array, *, tolerance: float = 0.0, stick: float = 0.0) -> Ways:
    """Tell for each point of a record in which direction the twist went, and whether the contact may stick there.

    Parameters
    ----------
    values
        Load angles in the order measured.
    tolerance
        Way back that is taken for noise of the twist, not for a reversal.
    stick
        Way after a turning point on which the contact is taken to stick; 0 if only at the turning point itself.
    """
    n = values.size
    turns = turning_points(values, tolerance)
    direction, stuck = np.zeros(n, np.int64), np.zeros(n, bool)
    starts, ends = [0, *turns], [*turns, n - 1]
    width = max(tolerance, stick)
    for number, (a, b) in enumerate(zip(starts, ends, strict=True)):
        # a record that does not move has come from rest
        way = int(np.sign(values[b] - values[a]) or np.sign(values[a]) or 1)
        direction[a + 1 if number else 0 : b + 1] = way
        # a record that begins with unloading: nobody saw how its first point was reached
        if number or way * values[a] < 0:
            first = a + 1 if number else a
            gone = way * (values[first : b + 1] - values[a]) > width
            stuck[first : first + (int(gone.argmax()) if gone.any() else gone.size)] = True
    return Ways(direction, stuck, turns)

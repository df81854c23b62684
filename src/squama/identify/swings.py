"""The record of a decay: time and twist, where it begins, its turning points."""

from __future__ import annotations

import os
from typing import Any, NamedTuple

import numpy as np

from squama.beam.design import Beam
from squama.errors import refuse
from squama.identify import noise, records
from squama.io import measured
from squama.io.measured import Measured
from squama.loads import Load
from squama.types import Array

_FEWEST, _LEAST = 20, 0.02
"""Points of a record; way back that makes a turning point, over the range of the twist."""
_TIMES = 6.0
"""That way over the noise of a point."""


class Swings(NamedTuple):
    """A record behind its first turning point, or from before that if it is held there.

    ``y`` rad per pitch, ``turns`` places of the turning points after the first, ``release`` and
    ``start`` angle and time of the first one.
    """

    t: Array
    y: Array
    turns: list[int]
    release: float
    start: float


def read(data: Any, beam: Beam, load: Load) -> Measured:
    """Return the record of a file or of arrays; see :func:`squama.fit_decay`."""
    if isinstance(data, Measured):
        return data
    if isinstance(data, str | os.PathLike):
        return measured.read(data, pitch=beam.pitch, scales=beam.pitches, load=load.name, ordinate=measured.TIME)
    return records.arrays(data, "data", beam, load, measured.TIME)


def swings(given: Measured, pitch: float) -> Swings:
    """Find the turning points of a record; one that is not a decay is refused."""
    parts = given.specimens()
    if len(parts) > 1:
        refuse(given.file, "", f"has {len(parts)} specimens", "give one decay")
    t, y = parts[0].load, parts[0].rate * pitch
    place = given.file or given.label
    back = np.flatnonzero(np.diff(t) <= 0)
    if back.size:
        refuse(parts[0].where(int(back[0]) + 1), "", "the time does not grow", "give the rows in the order measured")
    if t.size < _FEWEST or not np.ptp(y) > 0:
        refuse(place, "", f"{t.size} points, {np.ptp(y):.3g} rad/pitch apart, are no decay", f"give {_FEWEST} or more")
    sigma = noise.scatter(y, np.zeros(y.size))
    reach = max(_LEAST * float(np.ptp(y)), min(_TIMES * sigma, 0.1 * float(np.ptp(y))))
    turns = records.turning_points(y, reach)
    if len(turns) > 1 and y[0] * y[turns[0]] < 0 and abs(y[0]) > reach:
        # let go at the first row, or held until it moves
        held = np.flatnonzero(np.abs(y[: turns[0]] - y[0]) > reach / 2)
        last = max(int(held[0]) - 1, 0) if held.size else 0
        return Swings(t, y, turns, float(np.median(y[: last + 1])), float(t[last]))
    if len(turns) < 3:
        refuse(place, "", f"too few turning points: {len(turns)}", "give a record of one swing there and back, or more")
    first = turns[0]
    after = first + 1
    return Swings(t[after:], y[after:], [i - after for i in turns[1:]], float(y[first]), float(t[first]))

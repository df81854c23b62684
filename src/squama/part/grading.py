"""Grading: a beam whose scales differ along it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from squama.beam.beamfile import NUMBERS
from squama.beam.design import Beam
from squama.errors import naming, refuse
from squama.units import quantity, shown

GRADED = tuple(f"scale.{name}" for name in ("length", "width", "thickness", "alpha", "theta0", "embedded"))
"""What may differ from scale to scale."""


def graded(beam: Beam, along: Mapping[str, Sequence[float | str]], n: int) -> list[Beam]:
    """Return the beam of each scale, or one for all where nothing differs.

    ``along``: by name the values of the first and the last scale, or of each.
    """
    columns = {}
    if not isinstance(along, Mapping):
        refuse("along", "", "is no mapping", 'write e.g. {"scale.theta0": ["5 deg", "10 deg"]}')
    for name, values in along.items():
        if name not in GRADED:
            refuse("along", shown(name), f"must be one of {', '.join(GRADED)}", 'write e.g. "scale.theta0"')
        if isinstance(values, str) or len(values) not in (2, n):
            refuse("along", shown(name), f"needs 2 values, or {n}", 'write e.g. ["5 deg", "10 deg"]')
        with naming(f"along, {name}"):
            read = [quantity(v, NUMBERS[name][0]) for v in values]
        columns[name.removeprefix("scale.")] = np.interp(np.linspace(0, 1, n), np.linspace(0, 1, len(read)), read)
    if not columns:
        return [beam]
    rows = ({name: float(v[i]) for name, v in columns.items()} for i in range(n))
    return [beam.replace(scale=row) for row in rows]

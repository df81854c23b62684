"""From a beam and the workshop's sizes to a plan in millimetres."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from squama import checks
from squama.errors import InputError
from squama.fabrication.place import Plan
from squama.units import Bounds, Dimension, QuantityError, bounded

if TYPE_CHECKING:
    from squama.design import Beam

MOST_SCALES = 500

_SIZE = Bounds(0.0, 10.0, "0 or more, up to 10 m", closed=True)
_THICK = Bounds(1e-6, 10.0, "0.001 mm to 10 m", closed=True)
SIZES: dict[str, tuple[Dimension, Bounds]] = {
    "clearance": (Dimension.LENGTH, _SIZE._replace(example="0.2 mm")),
    "feature": (Dimension.LENGTH, _THICK._replace(example="0.4 mm")),
    "wall": (Dimension.LENGTH, _THICK._replace(example="3 mm")),
    "ends": (Dimension.LENGTH, _SIZE._replace(example="30 mm")),
    "draft": (Dimension.ANGLE, Bounds(0.0, math.radians(20), "0 to 20 deg", closed=True, example="1 deg")),
    "bed": (Dimension.LENGTH, _THICK._replace(example="220 mm")),
}
"""Sizes of the workshop: dimension, bounds and example of each."""


def read(given: dict[str, Any], prefix: str = "", *, bare: bool = True) -> dict[str, float]:
    """Return sizes in m and rad by name; ``prefix`` is put before the names in messages.

    Raises
    ------
    InputError
        One line per mistake.
    """
    found, lines = {}, []
    for name, value in given.items():
        dimension, bounds = SIZES[name]
        try:
            found[name] = bounded(value, dimension, bounds, bare=bare)
        except QuantityError as error:
            lines.append(f"{prefix}{name} = {error.shown}: {error.reason}")
    if lines:
        raise InputError("\n".join(lines))
    return found


def plan(beam: Beam, scales: int | None, sizes: dict[str, float]) -> Plan:
    """Return the plan of a beam with so many scales (its own number if None); sizes in m and rad.

    Raises
    ------
    InputError
        Too many scales.
    """
    count = checks.whole("scales", beam.scales if scales is None else scales, 1, MOST_SCALES)
    lengths = {name: value if SIZES[name][0] is Dimension.ANGLE else mm(value) for name, value in sizes.items()}
    return Plan(
        width=mm(beam.substrate.width),
        height=mm(beam.substrate.thickness),
        pitch=mm(beam.pitch),
        scales=count,
        length=mm(beam.scale.length),
        embedded=mm(beam.scale.embedded),
        breadth=mm(beam.scale.width),
        thickness=mm(beam.scale.thickness),
        alpha=beam.scale.alpha,
        theta0=beam.scale.theta0,
        **lengths,
    )


def mm(length: float) -> float:
    """Return a length in m as mm, without the last digits that the conversion leaves."""
    return float(f"{length * 1e3:.14g}")

"""The table of units; a unit that is not in it is handed to pint.

Importing pint takes longer than a whole calculation, so that happens only when the table
does not know a unit.
"""

from __future__ import annotations

import math
import re
from enum import StrEnum


class Dimension(StrEnum):
    """What a quantity measures; the value is its name in messages."""

    LENGTH = "length"
    ANGLE = "angle"
    PRESSURE = "pressure"
    TORQUE = "torque"  # also the stiffness of a joint, N m or N m/rad
    TWIST_RATE = "twist rate"  # also a curvature
    RATIO = "ratio"


DEGREE = math.pi / 180
# unit -> (dimension, factor, divisor): two numbers, because 60 / 1000 is rounded once and 60 * 0.001 twice
UNITS: dict[str, tuple[Dimension, float, float]] = {
    "m": (Dimension.LENGTH, 1, 1),
    "km": (Dimension.LENGTH, 1e3, 1),
    "cm": (Dimension.LENGTH, 1, 1e2),
    "mm": (Dimension.LENGTH, 1, 1e3),
    "um": (Dimension.LENGTH, 1, 1e6),
    "rad": (Dimension.ANGLE, 1, 1),
    "deg": (Dimension.ANGLE, DEGREE, 1),
    "Pa": (Dimension.PRESSURE, 1, 1),
    "kPa": (Dimension.PRESSURE, 1e3, 1),
    "MPa": (Dimension.PRESSURE, 1e6, 1),
    "GPa": (Dimension.PRESSURE, 1e9, 1),
    "N/m^2": (Dimension.PRESSURE, 1, 1),
    "N/mm^2": (Dimension.PRESSURE, 1e6, 1),
    "1/m": (Dimension.TWIST_RATE, 1, 1),
    "1/mm": (Dimension.TWIST_RATE, 1e3, 1),
    "%": (Dimension.RATIO, 1, 100),
    "": (Dimension.RATIO, 1, 1),
}
for _name, _newton, _metre in (("N m", 1.0, 1.0), ("N cm", 1.0, 1e2), ("N mm", 1.0, 1e3), ("kN m", 1e3, 1.0)):
    for _per, _divisor in (("", 1.0), ("/rad", 1.0), ("/deg", DEGREE)):
        UNITS[_name + _per] = (Dimension.TORQUE, _newton, _metre * _divisor)
for _angle, _radian in (("rad", 1.0), ("deg", DEGREE)):
    for _length, _multiple in (("m", 1.0), ("cm", 1e2), ("mm", 1e3)):
        UNITS[f"{_angle}/{_length}"] = (Dimension.TWIST_RATE, _radian * _multiple, 1)

_ALIASES = {"Nm": "N m", "Nmm": "N mm", "degree": "deg", "degrees": "deg", "radian": "rad", "radians": "rad"}
_LONGEST_UNIT = 40


def look_up(unit: str) -> tuple[Dimension, float, float] | None:
    """Return dimension, factor and divisor of a unit: SI value = number * factor / divisor.

    Spelling is forgiven where it is clear: "N*m", "N·m", "Nm", "rad / m", "rad per m", "degrees", "°", "µm".

    Parameters
    ----------
    unit : str
        The text after the number; empty for a plain number.

    Returns
    -------
    tuple or None
        None for text that is no unit, or a unit of a dimension that squama does not use.
    """
    key = re.sub(r"\s*(?:/|\bper\b)\s*", "/", unit).replace("°", "deg")
    key = re.sub(r"\s*[*·⋅]\s*|\s+", " ", key).replace("µ", "u").replace("μ", "u").replace("²", "^2")
    key = "/".join(_ALIASES.get(part, part) for part in key.split("/"))
    if key in UNITS:
        return UNITS[key]
    return _ask_pint(unit) if len(unit) <= _LONGEST_UNIT else None


def _ask_pint(unit: str) -> tuple[Dimension, float, float] | None:
    """Let pint read a unit; None if it cannot, or if it is of no dimension that squama uses."""
    import pint

    registry = pint.get_application_registry()  # type: ignore[no-untyped-call]
    try:
        base = registry.Quantity(1.0, unit).to_base_units()
        powers = {str(name): float(power) for name, power in base.unit_items()}
        factor = float(base.magnitude)
    except Exception:  # pint raises errors of many kinds on text that is no unit
        return None
    radian = powers.pop("radian", 0.0)
    for dimension, wanted, radians in _PINT:
        if powers == wanted and radian in radians and math.isfinite(factor) and factor > 0:
            return dimension, factor, 1
    return None


_PINT: tuple[tuple[Dimension, dict[str, float], tuple[float, ...]], ...] = (
    (Dimension.LENGTH, {"meter": 1}, (0,)),
    (Dimension.ANGLE, {}, (1,)),
    (Dimension.RATIO, {}, (0,)),
    (Dimension.PRESSURE, {"kilogram": 1, "meter": -1, "second": -2}, (0,)),
    (Dimension.TORQUE, {"kilogram": 1, "meter": 2, "second": -2}, (0, -1)),
    (Dimension.TWIST_RATE, {"meter": -1}, (0, 1)),
)

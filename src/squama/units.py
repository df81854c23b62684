"""Quantities with units: text and numbers in, SI floats out.

Inside squama lengths are in m, angles in rad, pressures in Pa, torques in N m and twist rates in rad/m.
"""

from __future__ import annotations

import math
import re
from numbers import Real
from typing import NamedTuple

from squama.errors import InputError
from squama.unit_table import DEGREE, UNITS, Dimension, look_up

__all__ = [
    "Bounds",
    "Dimension",
    "QuantityError",
    "as_text",
    "bounded",
    "curvature",
    "example",
    "quantity",
    "shown",
    "twist",
]


class QuantityError(InputError):
    """A value that is not usable; `shown` is the value as the user gave it, `reason` the rest of the line."""

    def __init__(self, shown: str, reason: str) -> None:
        self.shown = shown
        self.reason = reason
        super().__init__(f"{shown} {reason}")


class Bounds(NamedTuple):
    """The numbers that a quantity may have, in SI units, and the words for them."""

    low: float
    high: float
    allowed: str
    closed: bool = False
    example: str = ""

    def hold(self, value: float) -> bool:
        """Say whether the value lies within."""
        return self.low <= value <= self.high if self.closed else self.low < value < self.high


class _Kind(NamedTuple):
    noun: str
    unit: str
    number: str
    si: str


_KINDS = {
    Dimension.LENGTH: _Kind("a length", "mm", "12", "m"),
    Dimension.ANGLE: _Kind("an angle", "deg", "45", "rad"),
    Dimension.PRESSURE: _Kind("a pressure", "MPa", "1.5", "Pa"),
    Dimension.TORQUE: _Kind("a torque", "N m", "0.02", "N m"),
    Dimension.TWIST_RATE: _Kind("a twist rate", "rad/m", "5", "rad/m"),
    Dimension.RATIO: _Kind("a plain number", "", "0.25", ""),
}

_NUMBER = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(.*?)\s*", re.DOTALL | re.ASCII)


def shown(value: object, limit: int = 60) -> str:
    """Return a value as it is printed in a message: one line, text in double quotes, cut at `limit`."""
    if isinstance(value, bool):
        text = str(value).lower()
    elif isinstance(value, str):
        text = f'"{value}"'
    elif isinstance(value, Real):
        try:
            text = f"{float(value):.12g}"
        except OverflowError:
            text = "a huge number"
    else:
        text = str(value)
    if len(text) > limit:
        text = f"{text[: limit - 4]} ..."
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in text)


def example(dimension: Dimension | str, number: str | None = None) -> str:
    """Return what to write: the example of a dimension, with the user's own number if it is given."""
    kind = _KINDS[Dimension(dimension)]
    text = f"{number or kind.number} {kind.unit}".strip()
    return f'"{text}"' if kind.unit else text


def quantity(value: object, dimension: Dimension | str, *, bare: bool = True) -> float:
    """Read a quantity and return it in SI units.

    Parameters
    ----------
    value : str or number
        Text such as ``"45 deg"``, ``"45deg"``, ``"0.2 rad/m"``, ``"1e-3 m"``, or a number in SI units.
    dimension : Dimension or str
        What it must measure: length, angle, pressure, torque, twist rate, ratio.
    bare : bool
        Whether a number without a unit is taken as SI (Python); if not, it is refused (files, command line).
        A ratio never needs a unit.

    Returns
    -------
    float
        The value in m, rad, Pa, N m, rad/m or 1; finite.

    Raises
    ------
    QuantityError
        Not a finite number, no unit, an unknown unit, or a unit of another dimension.

    Examples
    --------
    >>> quantity("32 mm", "length")
    0.032
    >>> quantity("12 deg", "length")
    Traceback (most recent call last):
    ...
    squama.units.QuantityError: "12 deg" is an angle, but a length is needed; write e.g. "12 mm"
    """
    dimension = Dimension(dimension)
    kind = _KINDS[dimension]
    if isinstance(value, str):
        number, unit = _split(value, dimension)
        found, factor, divisor = _unit(value, unit, dimension)
        if found is not dimension:
            reason = f"is {_KINDS[found].noun}, but {kind.noun} is needed; write e.g. {example(dimension, number)}"
            if not unit:
                reason = f"has no unit; {_advice(float(number), dimension, number)}"
            raise QuantityError(shown(value), reason)
        return _finite(float(number) * factor / divisor, value, dimension)
    if isinstance(value, bool) or not isinstance(value, Real):
        what = f"is {_type_name(value)}, but {kind.noun} is needed; write e.g. {example(dimension)}"
        raise QuantityError(shown(value), what)
    try:
        si = _finite(float(value), value, dimension)
    except OverflowError:
        raise _not_finite(value, dimension) from None
    if not bare and dimension is not Dimension.RATIO:
        raise QuantityError(shown(value), f"has no unit; {_advice(si, dimension, shown(value))}")
    return si


def bounded(value: object, dimension: Dimension | str, bounds: Bounds, *, bare: bool = True) -> float:
    """Read a quantity as `quantity` does and hold it to its bounds.

    Returns
    -------
    float
        The value in SI units.

    Raises
    ------
    QuantityError
        As `quantity` but with the bounds' own example, or the value is out of bounds; a bare angle that would fit
        in degrees gets that hint.
    """
    dimension = Dimension(dimension)
    try:
        si = quantity(value, dimension, bare=bare)
    except QuantityError as error:
        reason = error.reason
        # where the unit is wrong the user's own number stays
        if bounds.example and not (isinstance(value, str) and "is needed" in reason):
            reason = reason.replace(f"write e.g. {example(dimension)}", f"write e.g. {bounds.example}")
        raise QuantityError(error.shown, reason) from None
    if bounds.hold(si):
        return si
    kind = _KINDS[dimension]
    text = shown(value)
    hint = f"write e.g. {bounds.example or example(dimension)}"
    if not isinstance(value, str) and kind.si:
        if dimension is Dimension.ANGLE and bounds.hold(si * DEGREE):
            hint = f"write {example(dimension, text)}"
        text = f"{text} {kind.si}"
    raise QuantityError(text, f"is out of range ({bounds.allowed}); {hint}")


def twist(value: object, *, pitch: float, scales: int, bare: bool = True) -> float:
    """Read a twist and return the twist rate Phi.

    Parameters
    ----------
    value : str or number
        A rate ("5 rad/m", "0.3 deg/mm"), an angle per pitch ("0.2 rad/pitch") or an angle over the whole beam
        ("90 deg total"); a number is a rate in rad/m.
    pitch : float
        Distance d between two scales, m.
    scales : int
        Number N of scales; the beam is N d long.
    bare : bool
        Whether a number without a unit is taken as rad/m.

    Returns
    -------
    float
        Phi, rad/m, with the sign that was given.

    Raises
    ------
    QuantityError
        As `quantity`; a bare angle ("90 deg") is refused, because it does not say over which length.
    """
    return _rate(value, pitch, scales, bare, "a twist")


def curvature(value: object, *, pitch: float, scales: int, bare: bool = True) -> float:
    """Read a bending curvature and return it in 1/m; what may be written is as in `twist`, and "2 1/m"."""
    return _rate(value, pitch, scales, bare, "a curvature")


def as_text(value: float, dimension: Dimension | str) -> str:
    """Write an SI value as the shortest text with a unit that `quantity` reads back to the same float.

    Examples
    --------
    >>> as_text(0.032, "length"), as_text(0.2, "angle")
    ('32 mm', '0.2 rad')
    """
    dimension = Dimension(dimension)
    best = f"{float(value)!r} {_KINDS[dimension].si}".strip()
    for unit in _WRITTEN[dimension]:
        _, factor, divisor = UNITS[unit]
        candidate = f"{value * divisor / factor:.15g} {unit}"
        if len(candidate) < len(best) and quantity(candidate, dimension) == value:
            best = candidate
    return best


_WRITTEN = {
    Dimension.LENGTH: ("mm", "m"),
    Dimension.ANGLE: ("deg", "rad"),
    Dimension.PRESSURE: ("GPa", "MPa", "kPa", "Pa"),
    Dimension.TORQUE: ("N m", "N mm"),
    Dimension.TWIST_RATE: ("rad/m",),
    Dimension.RATIO: (),
}


def _rate(value: object, pitch: float, scales: int, bare: bool, what: str) -> float:
    if isinstance(value, str):
        per_length = _over_length(value, pitch, scales, what)
        if per_length is not None:
            return per_length
    elif isinstance(value, Real) and not isinstance(value, bool) and not bare:
        n = shown(value)
        raise QuantityError(n, f'has no unit; write "{n} rad/m", "{n} rad/pitch" or "{n} rad total"')
    return quantity(value, Dimension.TWIST_RATE, bare=bare)


def _over_length(value: str, pitch: float, scales: int, what: str) -> float | None:
    """Return the rate of "angle/pitch" and "angle total", None for other text; refuse a bare angle."""
    body = value.strip()
    for ending, length in ((r"(?:/|\bper\b)\s*(?:pitch|scale)", pitch), (r"\btotal", scales * pitch)):
        if match := re.fullmatch(rf"(.*?)\s*{ending}", body, re.DOTALL):
            # "0.2 1/pitch" is 0.2 rad per pitch
            angle = re.sub(r"(?<=\d)\s+1$", " rad", match[1])
            try:
                return quantity(angle, Dimension.ANGLE) / length
            except QuantityError as error:
                raise QuantityError(shown(value), f"does not start with an angle: {error}") from None
    number, unit = _split(value, Dimension.TWIST_RATE)
    found, _, _ = _unit(value, unit, Dimension.TWIST_RATE)
    if found is Dimension.ANGLE or not unit:
        n = f"{number} {unit or 'rad'}"
        reason = (
            f'does not say over which length; write {what} as a rate "{n}/m", per pitch "{n}/pitch", '
            f'or over the {scales} scales "{n} total"'
        )
        raise QuantityError(shown(value), reason)
    return None


def _split(value: str, dimension: Dimension) -> tuple[str, str]:
    """Split text into number and unit."""
    match = _NUMBER.fullmatch(value)
    if match is None:
        noun = _KINDS[dimension].noun
        raise QuantityError(shown(value), f"is not {noun}; write e.g. {example(dimension)}")
    number, unit = match.groups()
    if re.match(r",\d", unit):
        fixed = value.strip().replace(",", ".", 1)
        raise QuantityError(shown(value), f"has a decimal comma; write {shown(fixed)}")
    if not math.isfinite(float(number)):
        raise _not_finite(value, dimension)
    return number, unit


def _advice(si: float, dimension: Dimension, number: str) -> str:
    """Say what to write in place of a bare number; offer the SI unit too where it may have been meant."""
    kind = _KINDS[dimension]
    text = f"write {example(dimension, number)}"
    small = dimension in {Dimension.LENGTH, Dimension.ANGLE} and 0 < abs(si) < 1
    large = dimension is Dimension.PRESSURE and abs(si) >= 1e4
    return f'{text} or "{number} {kind.si}"' if small or large else text


def _unit(value: str, unit: str, dimension: Dimension) -> tuple[Dimension, float, float]:
    found = look_up(unit)
    if found is None:
        noun = _KINDS[dimension].noun
        reason = f"is not {noun}: {shown(unit)} is not known as a unit of one; write e.g. {example(dimension)}"
        raise QuantityError(shown(value), reason)
    return found


def _finite(si: float, value: object, dimension: Dimension) -> float:
    if not math.isfinite(si):
        raise _not_finite(value, dimension)
    return si


def _not_finite(value: object, dimension: Dimension) -> QuantityError:
    return QuantityError(shown(value), f"is not a finite number; write e.g. {example(dimension)}")


def _type_name(value: object) -> str:
    if value is None:
        return "nothing"
    if isinstance(value, bool):
        return "no number"
    return {"list": "a list", "dict": "a table", "date": "a date"}.get(type(value).__name__, "of another type")

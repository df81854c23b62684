"""Quantities with units: read text and numbers as floats in SI units, and write floats as text."""

from __future__ import annotations

import math
import re
from enum import StrEnum
from numbers import Real
from typing import NamedTuple

from squama.errors import InputError, Problem, printable


class Dimension(StrEnum):
    """Physical dimension of a quantity; its value is its name in messages."""

    LENGTH = "length"
    ANGLE = "angle"
    PRESSURE, FORCE = "pressure", "force"
    TORQUE = "torque"  # also the stiffness of a joint, N m or N m/rad
    TWIST_RATE = "twist rate"  # also a curvature
    DENSITY = "density"
    INERTIA = "moment of inertia"
    IMPULSE = "angular impulse"
    FREQUENCY, TIME = "frequency", "time"
    RIGIDITY = "stiffness of a beam"  # torque per twist rate, moment per curvature
    LINE_WORK, COMPLIANCE = "work per length", "compliance"  # the latter angle per torque
    SPRING, YIELDING = "stiffness of a spring", "travel per force"
    RATIO = "ratio"


DEGREE = math.pi / 180
# unit -> (dimension, factor, divisor): two numbers, because 60 / 1000 is rounded once and 60 * 0.001 twice
UNITS: dict[str, tuple[Dimension, float, float]] = {
    unit: (dimension, *scale)
    for dimension, scales in {
        Dimension.LENGTH: {"m": (1.0, 1.0), "km": (1e3, 1.0), "cm": (1.0, 1e2), "mm": (1.0, 1e3), "um": (1.0, 1e6)},
        Dimension.ANGLE: {"rad": (1.0, 1.0), "deg": (DEGREE, 1.0), "rev": (2 * math.pi, 1.0)},
        Dimension.FORCE: {"N": (1.0, 1.0), "mN": (1.0, 1e3), "kN": (1e3, 1.0)},
        Dimension.PRESSURE: {"Pa": (1.0, 1.0), "kPa": (1e3, 1.0), "MPa": (1e6, 1.0), "GPa": (1e9, 1.0)}
        | {"N/m^2": (1.0, 1.0), "N/mm^2": (1e6, 1.0)},
        Dimension.TWIST_RATE: {"1/m": (1.0, 1.0), "1/mm": (1e3, 1.0)},
        Dimension.DENSITY: {"kg/m^3": (1.0, 1.0), "kg/m3": (1.0, 1.0), "g/cm^3": (1e3, 1.0), "g/cm3": (1e3, 1.0)},
        Dimension.INERTIA: {"kg m^2": (1.0, 1.0), "kg m2": (1.0, 1.0), "g cm^2": (1.0, 1e7), "g cm2": (1.0, 1e7)},
        Dimension.IMPULSE: {"N m s": (1.0, 1.0), "N mm s": (1.0, 1e3)},
        Dimension.FREQUENCY: {"Hz": (1.0, 1.0), "kHz": (1e3, 1.0), "mHz": (1.0, 1e3)},
        Dimension.TIME: {"s": (1.0, 1.0), "ms": (1.0, 1e3), "us": (1.0, 1e6), "min": (60.0, 1.0)},
        Dimension.LINE_WORK: {"J/m": (1.0, 1.0), "mJ/m": (1.0, 1e3), "mJ/mm": (1.0, 1.0), "J/mm": (1e3, 1.0)},
        Dimension.COMPLIANCE: {"rad/(N m)": (1.0, 1.0), "deg/(N m)": (DEGREE, 1.0)},
        Dimension.SPRING: {"N/m": (1.0, 1.0), "N/mm": (1e3, 1.0), "kN/m": (1e3, 1.0), "kN/mm": (1e6, 1.0)},
        Dimension.YIELDING: {"m/N": (1.0, 1.0), "mm/N": (1.0, 1e3), "um/N": (1.0, 1e6)},
        Dimension.RATIO: {"%": (1.0, 1e2), "": (1.0, 1.0)},
    }.items()
    for unit, scale in scales.items()
}
_MOMENTS = {"N m": (1.0, 1.0, 1.0), "N cm": (1.0, 1e2, 1e4), "N mm": (1.0, 1e3, 1e6), "mN m": (1.0, 1e3, 1e3)}
for _name, (_newton, _metre, _square) in (_MOMENTS | {"kN m": (1e3, 1.0, 1.0)}).items():
    for _per, _divisor in (("", 1.0), ("/rad", 1.0), ("/deg", DEGREE)):
        UNITS[_name + _per] = (Dimension.TORQUE, _newton, _metre * _divisor)
        UNITS[f"{_name}^2{_per}"] = (Dimension.RIGIDITY, _newton, _square * _divisor)
for _angle, _radian in (("rad", 1.0), ("deg", DEGREE)):
    for _length, _multiple in (("m", 1.0), ("cm", 1e2), ("mm", 1e3)):
        UNITS[f"{_angle}/{_length}"] = (Dimension.TWIST_RATE, _radian * _multiple, 1)

_ALIASES = {"degree": "deg", "degrees": "deg", "radian": "rad", "radians": "rad"}
_ALIASES |= dict.fromkeys(("revs", "revolution", "revolutions", "turn", "turns"), "rev")
_LONGEST_UNIT = 40
LONGEST, _TOO_LONG = 100, "is longer than 100 characters"
"""Largest number of characters of a quantity as text: longer ones would slow down patterns and messages."""
# names with powers of one digit, one level of brackets: pint evaluates powers in a unit, even 9**9**9
_SUPERSCRIPT = r"\u2070\xb9²³\u2074-\u2079"
_POWER = rf"(?: ?(?:\*\*|\^) ?[+-]?[0-9]|\u207b?[{_SUPERSCRIPT}])?"
_FACTOR = rf"(?:1|%|°|[^\W\d{_SUPERSCRIPT}][^\W{_SUPERSCRIPT}]*{_POWER})"
_BETWEEN = r"(?: ?[*/·⋅] ?| )"
_FACTORS = rf"{_FACTOR}(?:{_BETWEEN}{_FACTOR})*"
_UNIT = re.compile(rf"(?:{_FACTOR}|\({_FACTORS}\))(?:{_BETWEEN}(?:{_FACTOR}|\({_FACTORS}\)))*")


def look_up(unit: str) -> tuple[Dimension, float, float] | None:
    """Return dimension, factor and divisor of a unit: SI value = number * factor / divisor.

    Spelling is forgiven where it is clear: "N*m", "N·m", "N-m", "Nm", "rad / m", "rad per m", "degrees", "°", "µm".
    None for text that is no unit, or a unit of a dimension that squama does not use. A power is one digit.
    """
    if len(unit) > _LONGEST_UNIT:
        return None
    key = re.sub(r"\s*(?:/|\bper\b)\s*", "/", unit).replace("°", "deg")
    key = re.sub(r"\s*[*·⋅]\s*|\s+", " ", key).replace("µ", "u").replace("μ", "u").replace("²", "^2")
    key = re.sub(r"(?<=N)[-. ]?([cm]?m)(2?)\b", lambda m: f" {m[1]}{'^2' if m[2] else ''}", key)
    key = "/".join(_ALIASES.get(part, part) for part in key.split("/"))
    if key in UNITS:
        return UNITS[key]
    return _ask_pint(unit) if _UNIT.fullmatch(" ".join(unit.split())) else None


def _ask_pint(unit: str) -> tuple[Dimension, float, float] | None:
    """Look up a unit that is not in the table with pint, imported late because that takes longer than a calculation."""
    import pint

    registry = pint.get_application_registry()  # type: ignore[no-untyped-call]
    try:
        base = registry.Quantity(1.0, unit).to_base_units()
        factor = float(base.magnitude)
    except Exception:  # pint raises errors of many kinds on text that is no unit
        return None
    for si in ("m", "rad", "", "Pa", "N m", "N m/rad", "1/m", "rad/m", "kg/m^3", "kg m^2", "N m s", "Hz", "s", "N"):
        if base.units == registry.Quantity(1.0, si).to_base_units().units and 0 < factor < math.inf:
            return UNITS[si][0], factor, 1.0
    return None


def is_number(text: str) -> bool:
    """Return whether a text is a number without a unit."""
    try:
        float(text)
    except ValueError:
        return False
    return True


class QuantityError(InputError):
    """Error for an unusable value; its one problem has no place until `squama.errors.naming` adds it."""


class NoLengthError(QuantityError):
    """Error for a twist without the length over which it is counted."""


class Bounds(NamedTuple):
    """Allowed range of a quantity in SI units, with the words and the example for messages."""

    low: float
    high: float
    allowed: str
    closed: bool = False
    example: str = ""

    def hold(self, value: float) -> bool:
        """Return whether the value lies within the bounds."""
        return self.low <= value <= self.high if self.closed else self.low < value < self.high


MARGIN = Bounds(1e-9, 1 - 1e-12, "at least 1e-9 and below 1", closed=True, example="0.01")
"""Fraction of the path before a lock at which a curve is cut off. A lock is known to about 1e-15 of the inclination;
closer to it the force has no correct digit.
"""


class _Kind(NamedTuple):
    """A dimension in text: noun, unit and number of its example, SI unit, and the units in which files are written.

    ``other`` is an example that replaces the default one.
    """

    dimension: Dimension
    noun: str
    unit: str
    number: str
    si: str
    written: tuple[str, ...] = ()
    other: str = ""

    def example(self, number: str = "") -> str:
        """Return an example to write, with the user's own number if it is given."""
        if not number and self.other:
            return self.other
        text = f"{number or self.number} {self.unit}".strip()
        return f'"{text}"' if self.unit else text

    def error(self, value: object, reason: str, remedy: str | None = None) -> QuantityError:
        """Return the error for a value; the default remedy is the example."""
        remedy = f"write e.g. {self.example()}" if remedy is None else remedy
        return QuantityError(Problem("", shown(value), reason, remedy))


_KINDS = {
    Dimension.LENGTH: _Kind(Dimension.LENGTH, "a length", "mm", "12", "m", ("mm", "m")),
    Dimension.ANGLE: _Kind(Dimension.ANGLE, "an angle", "deg", "45", "rad", ("deg", "rad")),
    Dimension.FORCE: _Kind(Dimension.FORCE, "a force", "N", "0.2", "N", ("N", "mN")),
    Dimension.PRESSURE: _Kind(Dimension.PRESSURE, "a pressure", "MPa", "1.5", "Pa", ("GPa", "MPa", "kPa", "Pa")),
    Dimension.TORQUE: _Kind(Dimension.TORQUE, "a torque", "N m", "0.02", "N m", ("N m", "N mm")),
    Dimension.TWIST_RATE: _Kind(Dimension.TWIST_RATE, "a twist rate", "rad/m", "5", "rad/m", ("rad/m",)),
    Dimension.DENSITY: _Kind(Dimension.DENSITY, "a density", "kg/m3", "1100", "kg/m3"),
    Dimension.INERTIA: _Kind(Dimension.INERTIA, "a moment of inertia", "kg m2", "1e-4", "kg m2"),
    Dimension.IMPULSE: _Kind(Dimension.IMPULSE, "an angular impulse", "N m s", "0.01", "N m s"),
    Dimension.FREQUENCY: _Kind(Dimension.FREQUENCY, "a frequency", "Hz", "3", "Hz"),
    Dimension.TIME: _Kind(Dimension.TIME, "a time", "s", "0.5", "s"),
    Dimension.RIGIDITY: _Kind(Dimension.RIGIDITY, "a stiffness of a beam", "N m^2", "0.5", "N m^2"),
    Dimension.LINE_WORK: _Kind(Dimension.LINE_WORK, "a work per length of the beam", "J/m", "0.2", "J/m"),
    Dimension.COMPLIANCE: _Kind(Dimension.COMPLIANCE, "a compliance", "rad/(N m)", "0.5", "rad/(N m)"),
    Dimension.SPRING: _Kind(Dimension.SPRING, "a stiffness", "N/mm", "5", "N/m", ("N/mm", "N/m")),
    Dimension.YIELDING: _Kind(Dimension.YIELDING, "a travel per force", "mm/N", "0.2", "m/N"),
    Dimension.RATIO: _Kind(Dimension.RATIO, "a plain number", "", "0.25", ""),
}
_TYPES = {"NoneType": "nothing", "bool": "no number", "list": "a list", "dict": "a table", "date": "a date"}
_RATE = _KINDS[Dimension.TWIST_RATE]
NUMBER = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(.*?)\s*", re.DOTALL | re.ASCII)


def shown(value: object, limit: int = 60) -> str:
    """Return a value as printed in a message: one line, text in double quotes, cut at `limit` characters."""
    if isinstance(value, bool):
        text = str(value).lower()
    elif isinstance(value, str):
        text = f'"{value}"'
    else:
        try:
            text = f"{float(value):.12g}" if isinstance(value, Real) else str(value)
        except (OverflowError, ValueError):  # Python writes integers of 4300 digits at most
            text = "a huge number" if isinstance(value, Real) else "huge numbers"
        except TypeError:  # a span of time of NumPy counts as an integer and is none
            text = str(value)
    if len(text) > limit:
        text = f"{text[: limit - 4]} ..."
    return printable(text)


def change(share: float, sign: str = "", *, digits: int = 2, factor: str = "a factor of {}") -> str:
    """Return a relative difference as text: in per cent, or as a factor from twice on."""
    return f"{100 * share:{sign}.{digits}g} %" if abs(share) < 1 else factor.format(number(1 + share))


def example(dimension: Dimension | str) -> str:
    """Return the example to write for a dimension."""
    return _KINDS[Dimension(dimension)].example()


def si_unit(dimension: Dimension | str) -> str:
    """Return the SI unit of a dimension, "1" for a ratio."""
    return _KINDS[Dimension(dimension)].si or "1"


def quantity(value: object, dimension: Dimension | str, *, bare: bool = True) -> float:
    """Read a quantity and return it in SI units.

    Parameters
    ----------
    value : str or number
        Text such as ``"45 deg"``, ``"45deg"``, ``"0.2 rad/m"``, ``"1e-3 m"``, or a number in SI units.
    dimension : Dimension or str
        Required dimension: length, angle, pressure, torque, twist rate, ratio ...
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
    return _read(value, _KINDS[Dimension(dimension)], bare)


def bounded(value: object, dimension: Dimension | str, bounds: Bounds, *, bare: bool = True) -> float:
    """Read a quantity as `quantity` does and check its bounds; messages use the example of the bounds.

    For a bare angle that is out of bounds but would fit in degrees, the remedy is the same number in degrees.
    """
    kind = _KINDS[Dimension(dimension)]._replace(other=bounds.example)
    si = _read(value, kind, bare)
    if bounds.hold(si):
        return si
    text, remedy = shown(value), f"write e.g. {kind.example()}"
    if not isinstance(value, str) and kind.si:
        if kind.dimension is Dimension.ANGLE and bounds.hold(si * DEGREE):
            remedy = f"write {kind.example(text)}"
        text = f"{text} {kind.si}"
    raise QuantityError(Problem("", text, f"is out of range ({bounds.allowed})", remedy))


def twist(value: object, *, pitch: float, scales: int, bare: bool = True, what: str = "a twist") -> float:
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
    what : str
        Name of the quantity in messages.

    Returns
    -------
    float
        Phi, rad/m, with the sign that was given.

    Raises
    ------
    QuantityError
        As `quantity`; a bare angle ("90 deg") is refused, because it does not say over which length.
    """
    if isinstance(value, str):
        if len(value) > LONGEST:
            raise _RATE.error(value, _TOO_LONG)
        for ending, length in ((r"(?:/|\bper\b)\s*(?:pitch|scale)", pitch), (r"\btotal", scales * pitch)):
            if match := re.fullmatch(rf"(.*?)\s*{ending}", value.strip(), re.DOTALL):
                # "0.2 1/pitch" is 0.2 rad per pitch
                angle = re.sub(r"(?<=\d)\s+1$", " rad", match[1])
                try:
                    return quantity(angle, Dimension.ANGLE) / length
                except QuantityError as error:
                    raise _RATE.error(value, f"does not start with an angle: {error}", "") from None
        number, unit, (found, _, _) = _split(value, _RATE)
        if found is Dimension.ANGLE or not unit:
            n = f"{number} {unit or 'rad'}"
            remedy = f'write {what} as a rate "{n}/m", per pitch "{n}/pitch", or over the {scales} scales "{n} total"'
            raise NoLengthError(Problem("", shown(value), "does not say over which length", remedy))
    elif isinstance(value, Real) and not isinstance(value, bool) and not bare:
        n = shown(value)
        raise _RATE.error(value, "has no unit", f'write "{n} rad/m", "{n} rad/pitch" or "{n} rad total"')
    return quantity(value, Dimension.TWIST_RATE, bare=bare)


def curvature(value: object, *, pitch: float, scales: int, bare: bool = True) -> float:
    """Read a bending curvature and return it in 1/m; the same forms as in `twist`, and "2 1/m"."""
    return twist(value, pitch=pitch, scales=scales, bare=bare, what="a curvature")


def as_text(value: float, dimension: Dimension | str) -> str:
    """Write an SI value as the shortest text with a unit that `quantity` reads back to the same float.

    Examples
    --------
    >>> as_text(0.032, "length"), as_text(0.2, "angle")
    ('32 mm', '0.2 rad')
    """
    kind = _KINDS[Dimension(dimension)]
    best = f"{float(value)!r} {kind.si}".strip()
    for unit in kind.written:
        _, factor, divisor = UNITS[unit]
        candidate = f"{value * divisor / factor:.15g} {unit}"
        if len(candidate) < len(best) and quantity(candidate, dimension) == value:
            best = candidate
    return best


def _read(value: object, kind: _Kind, bare: bool) -> float:
    if isinstance(value, str):
        number, unit, (found, factor, divisor) = _split(value, kind)
        if found is kind.dimension:
            return _finite(float(number) * factor / divisor, value, kind)
        if not unit:
            raise kind.error(value, "has no unit", _advice(float(number), kind, number))
        reason = f"is {_KINDS[found].noun}, but {kind.noun} is needed"
        raise kind.error(value, reason, f"write e.g. {kind.example(number)}")
    if isinstance(value, bool) or not isinstance(value, Real):
        what = _TYPES.get(type(value).__name__, "of another type")
        raise kind.error(value, f"is {what}, but {kind.noun} is needed")
    try:
        si = _finite(float(value), value, kind)
    except OverflowError:
        si = _finite(math.inf, value, kind)
    except TypeError:  # a span of time of NumPy counts as an integer and is none
        raise kind.error(value, f"is of another type, but {kind.noun} is needed") from None
    if not bare and kind.dimension is not Dimension.RATIO:
        raise kind.error(value, "has no unit", _advice(si, kind, shown(value)))
    return si


def _split(value: str, kind: _Kind) -> tuple[str, str, tuple[Dimension, float, float]]:
    """Split text into number and unit, and look the unit up."""
    if len(value) > LONGEST:
        raise kind.error(value, _TOO_LONG)
    match = NUMBER.fullmatch(value)
    if match is None:
        raise kind.error(value, f"is not {kind.noun}")
    number, unit = match.groups()
    if re.match(r",\d", unit):
        fixed = value.strip().replace(",", ".", 1)
        raise kind.error(value, "has a decimal comma", f"write {shown(fixed)}")
    _finite(float(number), value, kind)
    if (found := look_up(unit)) is None:
        raise kind.error(value, f"is not {kind.noun}: {shown(unit)} is not known as a unit of one")
    return number, unit, found


def _advice(si: float, kind: _Kind, number: str) -> str:
    """Return the remedy for a number without a unit; it also offers the SI unit where that is plausible."""
    text = f"write {kind.example(number)}"
    small = kind.dimension in {Dimension.LENGTH, Dimension.ANGLE} and 0 < abs(si) < 1
    large = kind.dimension is Dimension.PRESSURE and abs(si) >= 1e4
    return f'{text} or "{number} {kind.si}"' if small or large else text


def _finite(si: float, value: object, kind: _Kind) -> float:
    if not math.isfinite(si):
        raise kind.error(value, "is not a finite number")
    return si


PEOPLE = {"rad": (180 / math.pi, "deg"), "m": (1e3, "mm"), "Pa": (1e-6, "MPa"), "m/N": (1e3, "mm/N")}
"""Factor and unit for people, by the SI unit; other units are shown as they are."""
_PREFIXES = ((1e9, "G"), (1e6, "M"), (1e3, "k"), (1.0, ""), (1e-3, "m"), (0.0, "\N{MICRO SIGN}"))


def for_people(unit: str) -> tuple[float, str]:
    """Return factor and unit for people of a quantity in an SI unit ("" for a ratio).

    Examples
    --------
    >>> for_people("Pa"), for_people("N m"), for_people("1")
    ((1e-06, 'MPa'), (1.0, 'N m'), (1.0, ''))
    """
    return PEOPLE.get(unit, (1.0, "" if unit == "1" else unit))


def prefix(largest: float) -> tuple[float, str]:
    """Return the factor and the SI prefix that make a number readable; (1.0, "") for 0, (1000.0, "m") for 0.02."""
    low, sign = next(row for row in _PREFIXES if abs(largest) >= row[0]) if largest else (1.0, "")
    return 1 / (low or 1e-6), sign


def torque_unit(largest: float) -> tuple[float, str]:
    """Return factor and unit of a torque (N m) in text: N mm below 0.1 N m, as for joints and load cells, else N m."""
    return (1e3, "N mm") if 0 < abs(largest) < 0.1 else (1.0, "N m")


def moment(value: float) -> str:
    """Return a torque (N m) as text for people, in N m or N mm."""
    factor, unit = torque_unit(value)
    return number(factor * value, unit)


def number(value: float, unit: str = "", sign: str = "", digits: int = 3) -> str:
    """Return a number as text, to so many digits, with a plus sign if ``sign`` is "+"; inf is "never", NaN "-"."""
    if not math.isfinite(value):
        return "never" if math.isinf(value) else "-"
    text = f"{value:{sign}.{digits}g}"
    return f"{f'{float(text):{sign}.0f}' if 'e+' in text and abs(value) < 1e6 else text} {unit}".strip()

"""Numbers as text for people: twists and bends in degrees over the whole beam, or per pitch of an endless one."""

from __future__ import annotations

import math
from typing import Protocol

from squama.units import change, number, prefix, torque_unit

PITCH = "deg per pitch"
"""Unit of the twist or bend of an endless beam."""


class Counted(Protocol):
    """Object with a number of scales (None if endless) and the number of pitches to which totals refer."""

    @property
    def scales(self) -> int | None: ...  # noqa: D102
    @property
    def pitches(self) -> int: ...  # noqa: D102


def figure(value: float, unit: str = "") -> str:
    """Return a number with its unit, to three digits; "" for NaN."""
    return "" if math.isnan(value) else number(value, unit)


def rigidity_unit(largest: float) -> tuple[float, str]:
    """Return factor and unit for a rigidity or tangent stiffness (N m^2): N mm2 or N m2."""
    factor, unit = torque_unit(largest)
    return factor**2, f"{unit}2"


def readable(unit: str, largest: float) -> tuple[float, str]:
    """Return factor and unit in which texts and pictures show a quantity of an SI unit, by its largest value.

    Torques and rigidities are in N mm or N m, forces in N from 0.01 N on. Other quantities get an SI prefix.

    Examples
    --------
    >>> readable("N m", 0.02), readable("N", 0.05), readable("J/m", 0.02)
    ((1000.0, 'N mm'), (1.0, 'N'), (1000.0, 'mJ/m'))
    """
    by_size = {"N m": torque_unit, "N m^2": rigidity_unit}
    if unit in by_size:
        return by_size[unit](largest)
    factor, sign = (1.0, "") if unit == "N" and 0.01 <= abs(largest) < 1e3 else prefix(largest)
    return factor, sign + unit


def tidy(value: float) -> float:
    """Return a value rounded to six decimals, without -0."""
    return round(value, 6) + 0.0


def apart_by(share: float) -> str:
    """Return a relative difference for a table, as :func:`squama.units.change` with its sign and three digits.

    Examples
    --------
    >>> apart_by(-0.021), apart_by(1039.2), apart_by(12345)
    ('-2.1 %', '1040 times', '12300 times')
    """
    return change(share, "+", digits=3, factor="{} times")


def degrees(*beams: Counted) -> tuple[float, str]:
    """Return factor and unit to show a twist or bend (rad per pitch): degrees over the whole beam, or per pitch.

    Beams with different numbers of scales are shown per pitch.

    Examples
    --------
    >>> from squama import Beam
    >>> degrees(Beam.from_ratios())[1], degrees(Beam.from_ratios(scales=25))[1]
    ('deg per pitch', 'deg')
    """
    first, *more = beams
    alike = first.scales and all(one.scales == first.scales for one in more)
    return (math.degrees(first.pitches), "deg") if alike else (math.degrees(1), PITCH)


def over(beam: Counted) -> str:
    """Return " over N scales", to be appended to a twist or bend of the whole beam; "" for an endless beam."""
    return f" over {beam.scales} scales" if beam.scales else ""


def per_pitch(angle: float, digits: int = 3) -> str:
    """Return a twist or bend (rad per pitch) in degrees per pitch; "" for NaN.

    Examples
    --------
    >>> per_pitch(0.2), per_pitch(math.inf)
    ('11.5 deg per pitch', 'never')
    """
    return number(math.degrees(angle), PITCH, digits=digits) if not math.isnan(angle) else ""


def at_most(angle: float, digits: int = 4) -> str:
    """Return a twist or bend (rad per pitch) in deg/pitch, rounded towards 0, in a form that can be typed as input.

    Examples
    --------
    >>> at_most(0.2), at_most(-0.19999)
    ('11.45 deg/pitch', '-11.45 deg/pitch')
    """
    value = math.degrees(abs(angle))
    step = 10.0 ** (math.floor(math.log10(value)) + 1 - digits) if value else 1.0
    return f"{math.copysign(math.floor(value / step) * step, angle):.{digits}g} deg/pitch"


def turned(angle: float, beam: Counted) -> str:
    """Return a twist or bend (rad per pitch) in degrees: over the whole beam and per pitch, or per pitch alone.

    Examples
    --------
    >>> from squama import Beam
    >>> turned(0.2, Beam.from_ratios(scales=25))
    '286 deg (11.5 deg per pitch)'
    """
    factor, unit = degrees(beam)
    own = f" ({per_pitch(angle)})" if beam.scales and math.isfinite(angle) else ""
    return f"{figure(factor * angle, unit)}{own}"


def span(low: float, high: float, beam: Counted) -> str:
    """Return a range of twists or bends (rad per pitch) in degrees, over the whole beam or per pitch."""
    factor, unit = degrees(beam)
    return f"{figure(factor * low)} to {figure(factor * high, unit)}"

"""Figures as people read them: twists and bends in degrees of the whole beam, or of a pitch where it has no end."""

from __future__ import annotations

import math
from typing import Protocol

from squama.units import change, number

PITCH = "deg per pitch"
"""Unit of the twist or bend of an endless beam."""


class Counted(Protocol):
    """A beam: its number of ``scales``, None of an endless one, and the number of ``pitches`` that totals are of."""

    @property
    def scales(self) -> int | None: ...  # noqa: D102
    @property
    def pitches(self) -> int: ...  # noqa: D102


def figure(value: float, unit: str = "") -> str:
    """Return a number with its unit, to three digits; "" where it is not known."""
    return "" if math.isnan(value) else number(value, unit)


def tidy(value: float) -> float:
    """Return a value without what is only rounding, and without -0."""
    return round(value, 6) + 0.0


def apart_by(share: float) -> str:
    """Return :func:`squama.units.change` for a table: with its sign, to three digits.

    Examples
    --------
    >>> apart_by(-0.021), apart_by(1039.2), apart_by(12345)
    ('-2.1 %', '1040 times', '12300 times')
    """
    return change(share, "+", digits=3, factor="{} times")


def degrees(*beams: Counted) -> tuple[float, str]:
    """Return factor and unit of a twist or bend (rad per pitch): degrees over the whole beam, or of a pitch.

    Of several beams with different numbers of scales it is that of a pitch.

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
    """Return what a twist or bend of the whole beam is of, to be put behind other words; "" of an endless beam."""
    return f" over {beam.scales} scales" if beam.scales else ""


def per_pitch(angle: float, digits: int = 3) -> str:
    """Return a twist or bend (rad per pitch) in degrees per pitch.

    Examples
    --------
    >>> per_pitch(0.2), per_pitch(math.inf)
    ('11.5 deg per pitch', 'never')
    """
    return number(math.degrees(angle), PITCH, digits=digits) if not math.isnan(angle) else ""


def at_most(angle: float, digits: int = 4) -> str:
    """Return the largest twist or bend (rad per pitch) that is not beyond an angle, as one may type it.

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
    """Return a range of twists or bends (rad per pitch) in degrees over the whole beam, or per pitch."""
    factor, unit = degrees(beam)
    return f"{figure(factor * low)} to {figure(factor * high, unit)}"

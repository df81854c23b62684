"""Checks of the number of scales of a beam and of the word for its ends."""

from __future__ import annotations

from numbers import Integral

from squama.errors import refuse
from squama.loads import COUPLE, ENDLESS, FREE, GRIPPED
from squama.units import shown

SHOWN = 25
"""Number of pitches used for lengths, totals and pictures of an endless beam."""


def number_of_scales(value: object) -> int | None:
    """Return the number of scales, None for an endless beam; refuse all but whole numbers of 2 or more."""
    if value is None or value == ENDLESS:
        return None
    if not (isinstance(value, Integral) and 2 <= int(value) <= 1_000_000):
        text = repr(value) if isinstance(value, float) else shown(value)
        refuse("", text, f"is neither a whole number from 2 to 1000000 nor {shown(ENDLESS)}", "write e.g. 25")
    return int(value)


def held_ends(value: object) -> str:
    """Return the word for a beam's ends if it is known; refuse others."""
    known = FREE, COUPLE, GRIPPED
    if value not in known:
        refuse("", shown(value), f"must be one of {', '.join(map(shown, known))}", 'write e.g. "gripped"')
    return str(value)

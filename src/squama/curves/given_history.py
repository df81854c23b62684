"""A history of twists or bends as it is given: numbers and texts with units, to load angles per pitch."""

from __future__ import annotations

import itertools
import re
from bisect import bisect_left
from collections.abc import Sequence
from functools import partial

import numpy as np

from squama import arguments
from squama.beam.design import Beam
from squama.errors import naming, refuse
from squama.loads import LOADS

_ROUNDING = 1e-12
"""Relative difference of twists that are the same one in two units."""


def read(given: float | str | Sequence[float | str], beam: Beam, load: str) -> list[float]:
    """Return a history as load angles per pitch, from rest at 0 on, and no two in a row equal.

    Given is a number (rad/m), a text, or a sequence of them; a single one is gone to and back. In a text with commas a
    number without a unit has that of the last one.
    """
    texts = items(given)
    rates = [_rate(item, i, len(texts), beam, load) for i, item in enumerate(texts)]
    if not rates:
        refuse("twist", "", "is empty", "give twists one after the other, such as [0, 5, 0]")
    rates = [0.0, *rates, 0.0] if len(rates) == 1 else rates
    values = [rate * beam.pitch for rate in rates]
    if values[0] != 0:
        values.insert(0, 0.0)
    if len(texts) == 1:
        arguments.moves("twist", values[1])
    _distinct(values, beam, len(texts))
    return values


def _apart(a: float, b: float) -> float:
    return abs(a - b)


def _distinct(values: list[float], beam: Beam, given: int) -> None:
    """Refuse two twists in a row that are the same, or two of a history that are all but the same.

    Twists that differ by rounding, as of two units, become equal.
    """
    known = [0.0]
    for i, value in enumerate(values):
        place = bisect_left(known, value)
        near = min(known[max(0, place - 1) : place + 1], key=partial(_apart, value))
        if abs(near - value) <= _ROUNDING * abs(value):
            values[i] = near
            continue
        if abs(near - value) < arguments.LEAST:
            reason = f"is nearer than {arguments.LEAST:g} rad/pitch to another one of the history, {near:.9g} rad/pitch"
            refuse(f"twist[{i + given - len(values)}]", f"{value:.9g} rad/pitch", reason, "give the same one")
        known.insert(place, value)
    for i, (a, b) in enumerate(itertools.pairwise(values)):
        if a == b:
            place = i + 1 + given - len(values)
            refuse(f"twist[{place}]", f"{b / beam.pitch:.6g} rad/m", "is the same as the one before", "give it once")


def items(given: float | str | Sequence[float | str]) -> list[float | str]:
    """Return the twists of a history as they were given, one by one."""
    if isinstance(given, str):
        return [*_parts(given)]
    return list(given) if isinstance(given, Sequence | np.ndarray) else [given]


def _parts(text: str) -> list[str]:
    """Split a text at its commas and hand the last unit on to the numbers without one."""
    parts = [part.strip() for part in text.split(",")]
    unit = re.sub(r"^[+-]?[\d.]+(?:[eE][+-]?\d+)?", "", parts[-1]).strip()
    return [f"{p} {unit}" if unit and re.fullmatch(r"[+-]?[\d.]+(?:[eE][+-]?\d+)?", p) else p for p in parts]


def _rate(item: object, i: int, n: int, beam: Beam, load: str) -> float:
    if isinstance(item, np.generic):
        item = item.item()
    with naming("twist" if n == 1 else f"twist[{i}]"):
        return LOADS[load].read(item, pitch=beam.pitch, scales=beam.scales)


def repeated(values: list[float], times: int) -> list[float]:
    """Return a history gone through several times; where it starts as it ended, that twist stands once."""
    once = values[1:] if values[-1] == values[0] else values
    return values + once * (times - 1)

"""Ways as they are given, numbers and texts with units, to bends and twists per pitch."""

from __future__ import annotations

import itertools
import math
import re
from bisect import bisect_left
from collections.abc import Sequence

import numpy as np

from squama import arguments
from squama.beam.design import Beam
from squama.curves.way import VERBS, Way
from squama.errors import naming, refuse
from squama.loads import LOADS, Load
from squama.people import per_pitch
from squama.units import shown

_ROUNDING = 1e-12
"""Relative difference of twists that are the same one in two units."""
EXAMPLE = '"bend 5 rad/m; twist 8 rad/m"'
Rate = float | str
"""A rate in rad/m, or a text with its unit."""
Path = str | Sequence[tuple[Rate, Rate]]
"""Where a path goes: text, or pairs of curvature and twist rate in rad/m or as texts with their units."""


def _angle(value: object, load: Load, beam: Beam, *, bare: bool = True) -> float:
    """Return a load angle per pitch; ``bare``: a number without a unit is a rate in rad/m."""
    value = value.item() if isinstance(value, np.generic) else value
    return load.read(value, pitch=beam.pitch, scales=beam.pitches, bare=bare) * beam.pitch


def path(given: Path, beam: Beam) -> Way:
    """Return a path as bends and twists per pitch; no two corners in a row are equal."""
    parts = [part.strip() for part in given.split(";")] if isinstance(given, str) else given
    if not isinstance(parts, Sequence | np.ndarray) or not len(parts):
        refuse("path", "", "is not a path", f"write e.g. {EXAMPLE}")
    corners, loaded = [(0.0, 0.0)], set[str]()
    for i, part in enumerate(parts):
        with naming(f"path[{i}]" if len(parts) > 1 else "path"):
            corner, verbs = _named(part, corners[-1], beam) if isinstance(part, str) else (_pair(part, beam), VERBS)
            loaded.update(verbs)
            if corner == corners[-1]:
                refuse("", shown(part), "ends where it starts", "leave it out")
            if max(map(abs, corner)) >= math.pi:
                refuse("", shown(part), "is half a turn per pitch or more", "give less")
        corners.append(corner)
    return Way(tuple(corners[1:]), loaded=tuple(verb for verb in VERBS if verb in loaded))


def _named(text: str, here: tuple[float, float], beam: Beam) -> tuple[tuple[float, float], Sequence[str]]:
    """Return where a text such as "bend 5 rad/m, twist 8 rad/m" goes from here, per pitch, and what it names."""
    verbs = {load.verb: load for load in LOADS.values()}
    found = list(here)
    said: list[str] = []
    for part in text.split(","):
        verb, _, value = part.strip().partition(" ")
        if verb not in verbs or verb in said or not value:
            refuse("", shown(text.strip()), "is not a way", f"write e.g. {EXAMPLE}, each word once between semicolons")
        said.append(verb)
        found[verbs[verb].axis] = _angle(value.strip(), verbs[verb], beam, bare=False)
    return (found[0], found[1]), said


def _pair(item: object, beam: Beam) -> tuple[float, float]:
    """Return a pair of curvature and twist rate per pitch."""
    if not isinstance(item, Sequence | np.ndarray) or len(item) != 2:
        refuse("", shown(item), "is not a pair of curvature and twist rate", "write e.g. (5, 8), in rad/m")
    by_axis = sorted(LOADS.values(), key=lambda load: load.axis)
    psi, phi = (_angle(value, load, beam) for load, value in zip(by_axis, item, strict=True))
    return psi, phi


def history(given: Rate | Sequence[Rate], beam: Beam, load: Load, loops: int = 1) -> Way:
    """Return a history of one load from rest at 0 on, no two load angles in a row equal, gone through several times.

    Given is a number (rad/m), a text, or a sequence of them; a single one is gone to and back. In a text with commas a
    number without a unit has that of the last one.
    """
    texts = _items(given)
    angles = []
    for i, text in enumerate(texts):
        with naming("twist" if len(texts) == 1 else f"twist[{i}]"):
            angles.append(_angle(text, load, beam))
    if not angles:
        refuse("twist", "", "is empty", "give twists one after the other, such as [0, 5, 0]")
    values = [0.0, *angles, 0.0] if len(angles) == 1 else angles
    if values[0] != 0:
        values.insert(0, 0.0)
    if len(texts) == 1:
        arguments.moves("twist", values[1])
    _distinct(values, beam, len(texts))
    ends = values[1:2] if len(texts) == 1 else values[::-1]
    typed = {v: text for v, text in zip(ends, texts[::-1], strict=False) if isinstance(text, str)}
    # where it starts as it ended, that twist stands once
    once = values[1:] if values[-1] == values[0] else values
    return Way.of(load.name, values + once * (loops - 1), typed)


def _distinct(values: list[float], beam: Beam, given: int) -> None:
    """Refuse two twists in a row that are the same, or two of a history that are all but the same.

    Twists that differ by rounding, as of two units, become equal.
    """
    known = [0.0]
    for i, value in enumerate(values):
        place = bisect_left(known, value)
        apart, near = min((abs(other - value), other) for other in known[max(0, place - 1) : place + 1])
        if apart <= _ROUNDING * abs(value):
            values[i] = near
            continue
        if apart < arguments.LEAST:
            reason = f"is nearer than {per_pitch(arguments.LEAST)} to another one of the history, {per_pitch(near, 9)}"
            refuse(f"twist[{i + given - len(values)}]", per_pitch(value, 9), reason, "give the same one")
        known.insert(place, value)
    for i, (a, b) in enumerate(itertools.pairwise(values)):
        if a == b:
            place = i + 1 + given - len(values)
            refuse(f"twist[{place}]", f"{b / beam.pitch:.6g} rad/m", "is the same as the one before", "give it once")


def _items(given: Rate | Sequence[Rate]) -> list[Rate]:
    """Return the twists of a history one by one; in a text the last unit is handed on to numbers without one."""
    if not isinstance(given, str):
        return list(given) if isinstance(given, Sequence | np.ndarray) else [given]
    parts = [part.strip() for part in given.split(",")]
    unit = re.sub(r"^[+-]?[\d.]+(?:[eE][+-]?\d+)?", "", parts[-1]).strip()
    return [f"{p} {unit}" if unit and re.fullmatch(r"[+-]?[\d.]+(?:[eE][+-]?\d+)?", p) else p for p in parts]

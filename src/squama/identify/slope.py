"""The slope of a record before engagement over the beam's own: a check of units and of the bar's data.

Before engagement the torque is that of the bar, R times the twist, whatever friction and joint. R follows from modulus,
section and inclusion factor of the beam file, so a record that begins there checks file and units.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from squama.identify import noise
from squama.identify.estimate import Points
from squama.identify.hinge_points import Physical
from squama.identify.joint_points import Loaded
from squama.identify.records import Record
from squama.identify.unknowns import PARAMETERS, with_error
from squama.loads import Load
from squama.types import Array

_FEWEST = 6
"""Spare points above which the residual of the line itself gives the slope's error; else the fit's noise."""
_OFF, _LEAST = 3.0, 0.01
"""Difference of a slope that counts, in errors and as a share of the slope."""
_UNIT, _NEAR = 5.0, 1.25
"""Ratio beyond which no bar explains a slope; factor within which a unit is named."""
_FIRST = 0.25
"""Share of the twist that counts as before engagement where the engagement is unknown."""
_HALVES, _BENT = 2, 3.0
"""How often the range may be halved; errors beyond which the slope of the first half differs."""
BAR = ("C_f", "E_B")
"""Parameters of a fit that change the slope."""


class Slope(NamedTuple):
    """Slope before engagement over that of the given beam (``E_B``); ``gives``: compliance that would explain it."""

    ratio: float
    error: float
    points: int
    E_B: float = math.nan
    gives: float = 0.0

    @property
    def text(self) -> str:
        """The ratio and its error as text: "0.850 +- 0.004"."""
        return with_error(self.ratio, self.error, "1")

    @property
    def sentence(self) -> str:
        """The line of the summary."""
        bar = "" if self.wrong_unit else f", E_B = {self.modulus}"
        return f"slope before engagement: {self.text} of the beam's own ({self.points} points){bar}"

    @property
    def modulus(self) -> str:
        """Young's modulus of the bar from the slope, with its error, if section, inclusion and machine are right."""
        return PARAMETERS["E_B"].written(self.ratio * self.E_B, self.error * self.E_B)

    def cause(self, names: tuple[str, ...], scales: int, load: Load, machine: bool = False) -> str:
        """Return why the slope is off; empty where it is not, or the fit adapts; ``machine``: whether it is known."""
        if not self.wrong_unit and (set(names) & set(BAR) or abs(self.ratio - 1) < max(_OFF * self.error, _LEAST)):
            return ""
        off = f"the slope before engagement is {self.text} of the beam's own"
        if self.wrong_unit:
            return f"{off}: {unit(self.ratio, scales, load)}; check the units of {load.noun} and {load.way}"
        kind = "softer" if self.ratio < 1 else "stiffer"
        percent = 100 * abs(self.ratio - 1)
        much = f"{percent:.{0 if percent >= 10 else 1}f} %"
        gives = ""
        if self.gives > 0 and not machine and "compliance" not in names:
            stiffness = f"{1 / self.gives:.2g} {load.force}/{load.unit}"
            gives = f', or the machine gives in ("{stiffness}"; the slope alone cannot tell which)'
        why = f"the bar is {much} {kind} than its file says (modulus, section or inclusion factor){gives}"
        remedy = f"correct the file, or find E_B {'' if load.pushed else 'or C_f '}too"
        return f"{off}: {why}, which moves the other estimates; {remedy}"

    @property
    def wrong_unit(self) -> bool:
        """Whether the slope is beyond what a bar can explain."""
        return not 1 / _UNIT < self.ratio < _UNIT


_OF_PARTS = ((1000.0, "a force in mN", "N"), (1e-3, "a travel in mm", "m"), (9.81, "a force in N", "kgf"))


def unit(ratio: float, scales: int, load: Load) -> str:
    """Return which wrong unit explains a slope this many times too steep."""
    known = {1.0: "a sign is wrong"}
    of_beams = (
        (1000.0, "a torque in N mm", "N m"),
        (100.0, "a torque in N cm", "N m"),
        (180 / math.pi, "a twist in rad", "deg"),
        (2 * math.pi, "a twist in revolutions", "rad"),
        (float(scales), "a twist per pitch", "the twist of the whole beam"),
    )
    for factor, small, large in _OF_PARTS if load.pushed else of_beams:
        known[factor] = f"a unit is wrong, as of {small} taken as {large}"
        what, _, name = small.partition(" in ")
        other = f"{what} in {large} taken as {name}" if name else f"{large} taken as {small}"
        known[1 / factor] = f"a unit is wrong, as of {other}"
    nearest = min(known, key=lambda factor: abs(math.log(abs(ratio) / factor))) if ratio > 0 else 1.0
    return known[nearest] if ratio < 0 or max(ratio / nearest, nearest / ratio) < _NEAR else "a unit is wrong"


def slope(
    record: Record,
    points: Points,
    usable: NDArray[np.bool_],
    at: Physical,
    bar: tuple[float, float],
    least: float | None,
) -> Slope | None:
    """Return the slope of the usable points before engagement over that of the bar; None with too few points.

    ``bar``: its slope (N m per rad of a pitch) and modulus (Pa); ``least``: noise of a point (N m), None for points of
    the first part of the twist, because a wrong unit hides the engagement.
    """
    readings, size = points.readings, np.abs(record.load)
    straight = usable & ~points.touching(at)
    if least is None:
        straight &= size <= _FIRST * float(np.max(size, where=usable, initial=0.0))
    placed = readings.placed(at.twist_zero, at.backlash, at.compliance)[0]
    twist = points.straight(at) if isinstance(points, Loaded) else placed
    torque = record.torque - at.drift * readings.order

    def of(part: NDArray[np.bool_]) -> Slope | None:
        line = _line(twist[part], torque[part], readings.numbers[part], least or 0.0)
        if line is None:
            return None
        ratio, unit = line[0] / bar[0], bar[0] / readings.scales
        gives = (1 / ratio - 1) / unit if ratio > 0 else 0.0
        return Slope(ratio, line[1] / bar[0], int(np.count_nonzero(part)), bar[1], gives)

    # where the slope of the first half differs, scales touch earlier than in the model
    found = of(straight)
    for _ in range(_HALVES):
        straight = straight & (size <= float(np.max(size, where=straight, initial=0.0)) / 2)
        first = of(straight)
        if found is None or first is None or abs(first.ratio - found.ratio) < _BENT * first.error:
            break
        found = first
    return found


def _line(x: Array, y: Array, way: NDArray[np.int64], least: float) -> tuple[float, float] | None:
    """Return the slope of y over x and its error, with an offset for each way; None with too few points."""
    numbers, place = np.unique(way, return_inverse=True)
    spare = x.size - numbers.size - 1
    if spare < 0:
        return None
    apart = [v - (np.bincount(place, v) / np.bincount(place))[place] for v in (x, y)]
    square = float(apart[0] @ apart[0])
    if not square > 0:
        return None
    steep = float(apart[0] @ apart[1]) / square
    residual = apart[1] - steep * apart[0]
    own = math.sqrt(float(residual @ residual) / max(spare, 1))
    sigma = own if spare >= _FEWEST else max(own, least)
    return steep, sigma * math.sqrt(noise.dependence(residual, way)) / math.sqrt(square)

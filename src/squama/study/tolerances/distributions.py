"""Distributions of the dimensions of a beam, and their text form.

"60 deg +- 1 deg" are limits, between which all values are equally likely (Guide to the Expression of Uncertainty in
Measurement, 4.3.7, for quantities of which only limits are known); a word after the limits names another distribution.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping
from typing import NamedTuple, NoReturn

import numpy as np

from squama.beam import beamfile
from squama.beam.design import Beam
from squama.errors import Problems, refuse
from squama.study import parameters
from squama.study.parameters import EXAMPLES, FACTOR, FULL, PARAMETERS, UNUSED, canonical
from squama.types import Array
from squama.units import LONGEST, Bounds, Dimension, QuantityError, bounded, quantity, shown

MOST_CUT = 0.1
"""Largest share of a normal distribution that may lie outside a parameter's bounds."""
_NOTED = 1e-9
KINDS = {"normal": "mean, sd", "uniform": "low, high", "triangular": "low, most likely, high"}
"""Distributions and their numbers."""
KEYS = (*(name for name in beamfile.NUMBERS if name not in UNUSED), FACTOR)
"""Numbers that may scatter: every number of a beam file that changes a figure, and the error of the joint's law."""
_SHORT = {**FULL, "pitch": "beam.pitch"}
_CALL = re.compile(r"\s*([A-Za-z]+)\s*\((.*)\)\s*", re.DOTALL)
_PLUS_MINUS = re.compile(r"(.*?)\s*(?:\+-|\+/-|\N{PLUS-MINUS SIGN})\s*(.*?)", re.DOTALL)
_WORD = re.compile(r"(.*?)\s*(?:(uniform|triangular)|([\d.]*)\s*sd)\s*", re.DOTALL)
_NUMBER = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?")


class Tolerance(NamedTuple):
    """Distribution of one parameter, SI units.

    ``name`` as in the beam file; ``kind`` of :data:`KINDS`; ``numbers``: mean and sd, limits, or limits with the most
    likely value in between; ``low``, ``high``: bounds of the parameter, at which a normal distribution is truncated;
    ``outside``: share of the normal distribution beyond them.
    """

    name: str
    kind: str
    numbers: tuple[float, ...]
    low: float
    high: float
    outside: float = 0.0

    def at(self, u: Array) -> Array:
        """Return the quantiles (SI) at the probabilities ``u``, above 0 and below 1."""
        if self.kind == "uniform":
            a, b = self.numbers
            return a + (b - a) * u
        if self.kind == "triangular":
            a, c, b = self.numbers
            rising = a + np.sqrt(u * (b - a) * (c - a))
            return np.asarray(np.where(u * (b - a) < c - a, rising, b - np.sqrt((1 - u) * (b - a) * (b - c))))
        from scipy.special import ndtr, ndtri

        mean, sd = self.numbers
        below, most = ndtr((np.array([self.low, self.high]) - mean) / sd)
        x = mean + sd * ndtri(below + u * (most - below))
        return np.asarray(np.clip(x, self.low, self.high))

    @property
    def moments(self) -> tuple[float, float]:
        """Mean and standard deviation, SI; of a normal distribution before it is truncated."""
        if self.kind == "normal":
            return self.numbers[0], self.numbers[1]
        a, c, b = self.numbers if self.kind == "triangular" else (*self.numbers[:1], *self.numbers)
        if self.kind == "uniform":
            return (a + b) / 2, (b - a) / math.sqrt(12)
        return (a + b + c) / 3, math.sqrt(((b - a) ** 2 - (c - a) * (b - c)) / 18)

    @property
    def text(self) -> str:
        """The distribution as text with units, such as "normal(0.25, 0.02)"."""
        factor, unit = parameters.people(self.name)
        return f"{self.kind}({', '.join(f'{v * factor:.6g} {unit}'.strip() for v in self.numbers)})"

    @property
    def notes(self) -> list[str]:
        """A note on the share of a normal distribution that the bounds cut off, if any."""
        if self.outside < _NOTED:
            return []
        bounds = PARAMETERS[canonical(self.name)].bounds
        return [f"{self.name} = {self.text}: truncated to {bounds.allowed}, which leaves out {self.outside:.2g} of it"]


def tolerances(
    given: Mapping[str, object], beam: Beam, *, bare: bool = True, joint: str = "hinge", ideal: bool = True
) -> list[Tolerance]:
    """Read distributions of numbers of the beam file, by name; nested tables give dotted names.

    A value is text as in the module's head or ``(kind, number, ..)``; "+- 1 deg" alone is about the beam's own value,
    and a number without a unit is SI (``bare``) or refused. One InputError names all mistakes.
    """
    found: dict[str, Tolerance] = {}
    problems = Problems()
    for name, value in parameters.flattened(given):
        with problems.caught():
            key = _key(name)
            parameters.effective(key, joint, ideal=ideal)
            if key in found:
                refuse(name, "", "is given twice", "give each tolerance once")
            found[key] = _read(key, name, value, beam, bare=bare)
    if not given:
        problems.add("tolerances", "", "there are none", 'give at least one, e.g. scale.alpha = "60 deg +- 1 deg"')
    problems.settle()
    return list(found.values())


def spread(given: object, dimension: Dimension, bounds: Bounds) -> tuple[float, float]:
    """Return a value within bounds (SI) and its standard deviation: "2 +- 0.5 N m/rad" (limits), "... sd"; else 0."""
    if not (isinstance(given, str) and _PLUS_MINUS.fullmatch(given)):
        return bounded(given, dimension, bounds), 0.0

    def no(reason: str, remedy: str = f"write e.g. {bounds.example}") -> NoReturn:
        refuse("", shown(given), reason, remedy)

    kind, items, sds = _form(given, no)
    middle, half = _numbers(items, dimension, False, True)
    if half <= 0:
        no("what stands behind +- must be more than 0")
    if not bounds.hold(middle):
        no(f"is out of range ({bounds.allowed})")
    return middle, half / (sds or math.sqrt({"uniform": 3.0, "triangular": 6.0}[kind]))


def _key(name: str) -> str:
    """Return the beam file's name of a number that may scatter, from any of its names; refuse other names."""
    key = _SHORT.get(name, name)
    if name in PARAMETERS and key not in KEYS and "." not in name:
        instead = "give tolerances of lengths, e.g. scale.length"
        refuse(name, "", "is a ratio or a setting, not a dimension", instead)
    if key not in KEYS:
        remedy = f"{parameters.meant(name, KEYS, _SHORT)}allowed: {', '.join(KEYS)}"
        refuse(shown(name).strip('"'), "", "is not known as a dimension with a tolerance", remedy)
    return key


def _read(key: str, name: str, given: object, beam: Beam, *, bare: bool) -> Tolerance:
    """Return the distribution of parameter ``key``, which the user calls ``name``; a bare number is SI or refused."""
    dimension, bounds, _ = PARAMETERS[canonical(key)]
    _, value, spread = EXAMPLES[dimension]
    example = f'write e.g. "{value} +- {spread}" (limits), "{value} +- {spread} sd" or "normal({value}, {spread})"'

    def no(reason: str, remedy: str = example) -> NoReturn:
        refuse(name, shown(given), reason, remedy)

    try:
        kind, items, sds = _form(given, no)
        if sds is not None and items[0] == "":
            items[0] = parameters.own(beam, key)
            if items[0] is None:
                no(f"the beam has no {key} of its own to which this belongs", "write the value too")
        numbers = _numbers(items, dimension, bare, kind == "normal" or sds is not None)
    except QuantityError as error:
        (problem,) = error.problems
        # a part of the text may be wrong alone
        whole = problem.value in ("", shown(given))
        no(problem.reason if whole else str(problem), problem.remedy if whole else "")
    if sds is not None:
        middle, half = numbers
        if half <= 0:
            no("what stands behind +- must be more than 0")
        low, high = middle - half, middle + half
        numbers = {"normal": [middle, half / (sds or 1)], "uniform": [low, high]}.get(kind, [low, middle, high])
    low, high = bounds.low, bounds.high
    if not bounds.closed:
        low, high = float(np.nextafter(low, high)), float(np.nextafter(high, low))
    outside = 0.0
    if kind == "normal":
        from scipy.special import ndtr

        mean, sd = numbers
        if sd <= 0:
            no("the standard deviation must be more than 0")
        outside = float(ndtr((low - mean) / sd) + ndtr((mean - high) / sd))
        if outside > MOST_CUT:
            out = f"{outside:.0%} of it would be out of range ({bounds.allowed})"
            no(f"{out}, at most {MOST_CUT:.0%} may be cut off", "make it narrower or write limits")
    elif not numbers[0] < numbers[-1] or numbers != sorted(numbers):
        no(f"the values of {kind} must grow from the first to the last")
    elif beyond := [number for number in numbers if not low <= number <= high]:
        no(
            f"it reaches to {parameters.text_of(key, beyond[0])}, which is out of range ({bounds.allowed})",
            "make it narrower",
        )
    return Tolerance(key, kind, tuple(numbers), low, high, outside)


def _form(value: object, no: Callable[..., NoReturn]) -> tuple[str, list[object], float | None]:
    """Return kind and values of a tolerance, then for "a +- b" the standard deviations in b (0: a limit), else None."""
    if isinstance(value, str) and len(value) > LONGEST:
        no(f"is longer than {LONGEST} characters")
    if isinstance(value, list | tuple) and value and isinstance(value[0], str):
        kind, items = value[0], list(value[1:])
    elif isinstance(value, str) and (call := _CALL.fullmatch(value)):
        kind, items = call[1].lower(), [part.strip() for part in call[2].split(",")]
    elif isinstance(value, str) and (both := _PLUS_MINUS.fullmatch(value)):
        word = _WORD.fullmatch(both[2])
        spread = word[1] if word else both[2]
        if word is None or word[2]:
            return word[2] if word else "uniform", [both[1], spread], 0.0
        # a plain number before "sd" is the spread
        spread, sds = (spread, word[3] or "1") if spread else (word[3], "1")
        if not _NUMBER.fullmatch(sds) or float(sds) == 0:
            no("does not say how many standard deviations")
        return "normal", [both[1], spread], float(sds)
    else:
        no("is no tolerance")
    if kind not in KINDS:
        no(f'"{kind}" is no distribution that is known')
    wanted = KINDS[kind].split(", ")
    if len(items) != len(wanted):
        no(f"{kind} takes {len(wanted)} values: {kind}({KINDS[kind]})", "")
    return kind, items, None


def _numbers(items: list[object], dimension: Dimension, bare: bool, spread: bool) -> list[float]:
    """Return values in SI units; one unit serves all values without a unit, a spread may be in % of the first."""
    texts = [item for item in items if isinstance(item, str) and not item.endswith("%")]
    units = [unit for text in texts if (unit := _NUMBER.sub("", text, count=1).strip())]
    found: list[float] = []
    for i, item in enumerate(items):
        if isinstance(item, str) and item.endswith("%") and spread and i == 1:
            found.append(abs(found[0]) * quantity(item[:-1].strip(), Dimension.RATIO) / 100)
        elif isinstance(item, str) and units and _NUMBER.fullmatch(item):
            found.append(quantity(f"{item} {units[-1]}", dimension, bare=bare))
        else:
            # the beam's own value is in SI units already
            found.append(quantity(item, dimension, bare=bare or not isinstance(item, str)))
    return found


def nominal(tolerance: Tolerance, beam: Beam) -> float:
    """Return the beam's own value of a parameter (SI), or the median of its distribution where the beam states none."""
    value = parameters.own(beam, tolerance.name)
    return float(tolerance.at(np.array([0.5]))[0]) if value is None else value

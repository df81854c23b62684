"""What may be swept: names, bounds and words of every parameter, and the values that are given for it.

A ratio keeps the other ratios and the substrate's section as they are, like ``Beam.from_ratios``: eta changes the
scale's length, beta its width, zeta its embedded length and its thickness, slenderness its thickness, lam the pitch
and with it all four. A dimension (``scale.length``, ``beam.pitch`` ...) changes itself alone.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from types import MappingProxyType
from typing import Any, NamedTuple, NoReturn

import numpy as np

from squama.beam import beamfile, parts
from squama.errors import InputError, Problem, Problems, naming, refuse
from squama.io.tabular import close
from squama.symbols import SYMBOLS, Symbol
from squama.types import Array
from squama.units import MARGIN, Bounds, Dimension, as_text, bounded, shown

MOST_VALUES, LONGEST_LIST = 10_000_000, 100_000
"""Values of a range, and of a list."""


class Parameter(NamedTuple):
    """A parameter that may be swept: what it measures, its bounds, its words."""

    dimension: Dimension
    bounds: Bounds
    symbol: Symbol


def _key(name: str) -> Parameter:
    table, _, key = name.partition(".")
    dimension, bounds = beamfile.NUMBERS[name]
    meaning = beamfile.TABLES[table][key].meaning
    units = {
        Dimension.LENGTH: "m",
        Dimension.ANGLE: "rad",
        Dimension.PRESSURE: "Pa",
        Dimension.TORQUE: "N m",
        Dimension.RATIO: "1",
    }
    words = meaning if len(meaning) > 4 else f"{key.replace('_', ' ')} {meaning}"
    return Parameter(dimension, bounds, Symbol(name, units[dimension], f"{table} {words}", ""))


_SHORT = {"alpha": "scale.alpha", "theta0": "scale.theta0", "mu": "friction.mu"}
PARAMETERS: dict[str, Parameter] = {
    **{n: Parameter(Dimension.RATIO, bounds, SYMBOLS[n]) for n, bounds in parts.RATIOS.items()},
    **{n: Parameter(*beamfile.NUMBERS[name], SYMBOLS[n]) for n, name in _SHORT.items()},
    "margin": Parameter(Dimension.RATIO, MARGIN, SYMBOLS["margin"]),
    **{name: _key(name) for name in beamfile.NUMBERS if name not in _SHORT.values()},
}
"""Parameters by name, in the order in which messages list them."""

ALIASES = {"lambda": "lam", "scale.alpha": "alpha", "scale.theta0": "theta0", "friction.mu": "mu"}
_CHANGES = {
    "eta": ("scale.length",),
    "beta": ("scale.width",),
    "zeta": ("scale.embedded", "scale.thickness"),
    "slenderness": ("scale.thickness",),
    "lam": ("beam.pitch", "scale.length", "scale.width", "scale.embedded", "scale.thickness"),
}
_NO_EFFECT = {
    "beam.scales": "the figures of a sweep are per pitch or per length, so it changes nothing; leave it out",
    "law": "is no range; give both laws with --law edge,plate",
    "sense": "is no range; sweep each sense into a store of its own",
}


class Axis(NamedTuple):
    """A swept parameter: its name and its values in SI units, increasing."""

    name: str
    values: Array

    @property
    def span(self) -> str:
        """The range, with units."""
        return f"{self.name} = {text_of(self.name, self.values[0])} to {text_of(self.name, self.values[-1])}"

    @property
    def record(self) -> list[float] | dict[str, float]:
        """The values for the configuration: both ends and the count if they are evenly spaced."""
        low, high, count = float(self.values[0]), float(self.values[-1]), self.values.size
        if count > 2 and np.array_equal(self.values, np.linspace(low, high, count)):
            return {"low": low, "high": high, "count": count}
        return [float(v) for v in self.values]

    @classmethod
    def from_record(cls, name: str, record: Any) -> Axis:
        """Read back :attr:`record`."""
        if isinstance(record, Mapping):
            return cls(name, np.linspace(record["low"], record["high"], record["count"]))
        return cls(name, np.asarray(record, float))


def text_of(name: str, value: float) -> str:
    """Return a value of a parameter with its unit, for people."""
    dimension = PARAMETERS[name].dimension
    text = as_text(float(value), dimension)
    if len(text) <= 14 and dimension is not Dimension.RATIO:
        return text
    unit = "deg" if dimension is Dimension.ANGLE else PARAMETERS[name].symbol.unit.replace("1", "")
    number = np.degrees(value) if dimension is Dimension.ANGLE else value
    return f"{number:.6g} {unit}".strip()


def canonical(name: str) -> str:
    """Return the one name of a parameter, or refuse a name that is none and suggest which was meant."""
    if name in PARAMETERS:
        return name
    if name in ALIASES:
        return ALIASES[name]
    if name in _NO_EFFECT:
        refuse(name, "", _NO_EFFECT[name])
    remedy = f"{meant(name, [*PARAMETERS, *ALIASES])}allowed: {', '.join(PARAMETERS)}"
    raise InputError(Problem(shown(name).strip('"'), "", "is no parameter that can be swept", remedy))


def meant(name: str, known: Iterable[str], short: Mapping[str, str] = MappingProxyType({})) -> str:
    """Return "did you mean ...? " with the known names that end so, or the one most like it, or nothing."""
    near = close(name, [*known, *short])
    names = [full for full in known if full.endswith(f".{name}")] or [short.get(near, near)]
    return f"did you mean {' or '.join(names)}? " if names != [""] else ""


def axes(over: Mapping[str, Any], *, bare: bool = True) -> list[Axis]:
    """Read all swept parameters, in the order given.

    A value is ``(low, high, count)``, a list or an array of values, or text such as ``"15deg:75deg:601"`` or
    ``"0.1,0.2,0.5"``; a number without a unit is SI (``bare``) or refused.

    Raises
    ------
    InputError
        One line per mistake.
    """
    found: dict[str, Axis] = {}
    first: dict[str, str] = {}
    problems = Problems()
    for name, value in over.items():
        with problems.caught():
            known = canonical(str(name))
            if known in first:
                refuse(str(name), "", f"is the same parameter as {first[known]}", "give it once")
            first[known] = str(name)
            found[known] = _Reader(known, str(name), value, bare).axis()
    for ratio, sizes in _CHANGES.items():
        for size in sizes:
            if {ratio, size} <= set(found):
                problems.add(f"{ratio} and {size}", "", f"{ratio} changes {size} too", "sweep one of them")
    if not over:
        problems.add("over", "", "is empty", 'name a parameter and its range, e.g. {"mu": (0, 2, 401)}')
    if len(over) > 8:
        problems.add("over", "", f"has {len(over)} parameters", "sweep 8 at most")
    problems.settle()
    return list(found.values())


def read_value(name: str, value: object, *, bare: bool) -> float:
    """Return one value of a parameter in SI units, or refuse it under its name."""
    parameter = PARAMETERS[ALIASES.get(name, name)]
    with naming(name):
        return bounded(value, parameter.dimension, parameter.bounds, bare=bare)


class _Reader(NamedTuple):
    """Reads the values of a parameter that was given by another name."""

    name: str
    given: str
    value: Any
    bare: bool

    def axis(self) -> Axis:
        """Return the values of a range or a list."""
        value = self.value
        if isinstance(value, str):
            items = [part.strip() for part in value.split(":" if ":" in value else ",")]
            return self.spaced(items) if ":" in value else self.listed(items)
        if isinstance(value, tuple):
            return self._replace(value=":".join(map(str, value))).spaced(value)
        if isinstance(value, np.ndarray):
            value = value.tolist() if value.ndim == 1 else None
        if not isinstance(value, Sequence):
            self.refuse("is no range", f"write {self.example}")
        return self._replace(value=f"{len(value)} values").listed(value)

    def spaced(self, items: Sequence[Any]) -> Axis:
        """Return evenly spaced values."""
        if len(items) != 3 or any(isinstance(i, str) and ("," in i or not i) for i in items):
            self.refuse("is no range low:high:count")
        low, high = (read_value(self.given, item, bare=self.bare) for item in items[:2])
        try:
            count = float(items[2])
        except (TypeError, ValueError):
            count = np.nan
        if not (count == np.floor(count) and 2 <= count <= MOST_VALUES):
            self.refuse(f"the count {shown(items[2])} is not a whole number from 2 to {MOST_VALUES}")
        if low == high:
            self.refuse("begins where it ends", "for one value change the beam and sweep something else")
        if low > high:
            self.refuse("runs downwards", f"write {items[1]}:{items[0]}:{items[2]}")
        values = np.linspace(low, high, int(count))
        if not np.all(np.diff(values) > 0):
            self.refuse("is narrower than its count of numbers can tell apart", "give a smaller count")
        return Axis(self.name, values)

    def listed(self, items: Sequence[Any]) -> Axis:
        """Return values that are given one by one."""
        if len(items) < 2:
            self.refuse("is empty" if not items or items[0] == "" else "is one value, no range")
        if len(items) > LONGEST_LIST:
            self.refuse(f"has more than {LONGEST_LIST:,} values", "write low:high:count")
        values = np.array([read_value(self.given, item, bare=self.bare) for item in items])
        if not np.all(np.diff(values) > 0):
            self.refuse("does not increase from each value to the next", "put the values in order")
        return Axis(self.name, values)

    @property
    def example(self) -> str:
        """What to write."""
        return {
            Dimension.ANGLE: "15deg:75deg:601",
            Dimension.LENGTH: "10mm:60mm:101",
            Dimension.PRESSURE: "1MPa:3MPa:101",
            Dimension.TORQUE: '"0.01 N m:0.05 N m:101"',
        }.get(PARAMETERS[self.name].dimension, "0.001,0.01,0.1" if self.name == "margin" else "0.2:0.4:401")

    def refuse(self, reason: str, remedy: str = "") -> NoReturn:
        """Refuse what is given, with an example unless there is better advice."""
        refuse(self.given, shown(self.value).strip('"'), reason, remedy or f"write e.g. {self.example}")

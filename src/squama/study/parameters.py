"""What may be swept: names, bounds and words of every parameter, and the values that are given for it.

A ratio keeps the other ratios and the substrate's section as they are, like ``Beam.from_ratios``: eta changes the
scale's length, beta its width, zeta its embedded length and its thickness, slenderness its thickness, lam the pitch
and with it all four. A dimension (``scale.length``, ``beam.pitch`` ...) changes itself alone.
"""

from __future__ import annotations

import difflib
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from squama import beamfile, parts
from squama.errors import InputError
from squama.model.solve import Array
from squama.symbols import SYMBOLS, Symbol
from squama.units import Bounds, Dimension, QuantityError, as_text, bounded, shown

MOST_VALUES, LONGEST_LIST = 10_000_000, 100_000
"""Values of a range, and of a list."""
MARGINS = Bounds(1e-12, 1 - 1e-12, "at least 1e-12, below 1", closed=True, example="0.01")


class Parameter(NamedTuple):
    """A parameter that may be swept: what it measures, its bounds, its words."""

    dimension: Dimension
    bounds: Bounds
    symbol: Symbol


def _key(name: str, bounds: Bounds) -> Parameter:
    table, _, key = name.partition(".")
    dimension, meaning, _ = beamfile.TABLES[table][key]
    assert dimension is not None
    units = {
        Dimension.LENGTH: "m",
        Dimension.ANGLE: "rad",
        Dimension.PRESSURE: "Pa",
        Dimension.TORQUE: "N m",
        Dimension.RATIO: "1",
    }
    words = meaning if len(meaning) > 4 else f"{key.replace('_', ' ')} {meaning}"
    return Parameter(dimension, parts.own(table, key, bounds), Symbol(name, units[dimension], f"{table} {words}", ""))


PARAMETERS: dict[str, Parameter] = {
    **{n: Parameter(Dimension.RATIO, bounds, SYMBOLS[n]) for n, bounds in parts.RATIOS.items()},
    **{n: Parameter(Dimension.ANGLE, parts.own("scale", n, parts.QUARTER), SYMBOLS[n]) for n in ("alpha", "theta0")},
    "mu": Parameter(Dimension.RATIO, parts.own("friction", "mu", parts.FRICTION), SYMBOLS["mu"]),
    "margin": Parameter(Dimension.RATIO, MARGINS, SYMBOLS["margin"]),
    **{f"scale.{n}": _key(f"scale.{n}", parts.SIZE) for n in ("length", "width", "thickness")},
    "scale.embedded": _key("scale.embedded", parts.DEPTH),
    **{f"substrate.{n}": _key(f"substrate.{n}", parts.SIZE) for n in ("width", "thickness")},
    "substrate.youngs_modulus": _key("substrate.youngs_modulus", parts.MODULUS),
    "substrate.poisson_ratio": _key("substrate.poisson_ratio", parts.POISSON),
    "beam.pitch": _key("beam.pitch", parts.SIZE),
    "joint.stiffness": _key("joint.stiffness", parts.STIFFNESS),
    "joint.inclusion_factor": _key("joint.inclusion_factor", parts.FACTOR),
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
    """A swept parameter: its name and its values in SI units, increasing; ``given`` as text for messages."""

    name: str
    values: Array
    given: str

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
            return cls(name, np.linspace(record["low"], record["high"], record["count"]), "")
        return cls(name, np.asarray(record, float), "")


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
        message = f"{name}: {_NO_EFFECT[name]}"
        raise InputError(message)
    known = [*PARAMETERS, *ALIASES]
    ends = [full for full in known if "." in full and full.endswith(f".{name}")]
    close = ends or difflib.get_close_matches(name.lower(), known, n=1)
    guess = f"did you mean {' or '.join(close)}? " if close else ""
    message = (
        f"{shown(name).strip(chr(34))}: is no parameter that can be swept; {guess}allowed: {', '.join(PARAMETERS)}"
    )
    raise InputError(message)


def axes(over: Mapping[str, Any], *, bare: bool = True) -> list[Axis]:
    """Read all swept parameters, one line per mistake.

    Parameters
    ----------
    over : mapping
        By name: ``(low, high, count)``, a list or an array of values, or text such as ``"15deg:75deg:601"`` or
        ``"0.1,0.2,0.5"``.
    bare : bool
        Whether a number without a unit is SI.

    Returns
    -------
    list of Axis
        In the order given.

    Raises
    ------
    InputError
        One line per mistake.
    """
    found: list[Axis] = []
    problems: list[str] = []
    first: dict[str, str] = {}
    for name, value in over.items():
        try:
            known = canonical(str(name))
            if known in first:
                problems.append(f"{name}: is the same parameter as {first[known]}; give it once")
                continue
            first[known] = str(name)
            found.append(_axis(known, str(name), value, bare))
        except InputError as error:
            problems += str(error).splitlines()
    swept = {axis.name for axis in found}
    problems += [
        f"{ratio} and {size}: {ratio} changes {size} too; sweep one of them"
        for ratio, sizes in _CHANGES.items()
        for size in sizes
        if {ratio, size} <= swept
    ]
    if not over:
        problems.append('over: is empty; name a parameter and its range, e.g. {"mu": (0, 2, 401)}')
    if len(over) > 8:
        problems.append(f"over: has {len(over)} parameters; sweep 8 at most")
    if problems:
        raise InputError("\n".join(problems))
    return found


def read_value(name: str, value: object, *, bare: bool) -> float:
    """Return one value of a parameter in SI units, or refuse it under its name."""
    parameter = PARAMETERS[ALIASES.get(name, name)]
    try:
        return bounded(value, parameter.dimension, parameter.bounds, bare=bare)
    except QuantityError as error:
        message = f"{name} = {error.shown}: {error.reason}"
        raise InputError(message) from None


def _axis(name: str, given: str, value: Any, bare: bool) -> Axis:
    """Read the values of one parameter; ``given`` is the name that the user wrote."""
    if isinstance(value, str):
        parts_ = [part.strip() for part in value.split(":" if ":" in value else ",")]
        if ":" in value:
            return _range(name, given, parts_, value, bare)
        return _list(name, given, parts_, value, bare)
    if isinstance(value, tuple):
        text = ":".join(str(v) for v in value)
        return _range(name, given, value, text, bare)
    if isinstance(value, np.ndarray):
        value = value.tolist() if value.ndim == 1 else None
    if isinstance(value, Sequence):
        return _list(name, given, value, f"{len(value)} values", bare)
    raise _refused(given, value, f"is no range; write {_example(name)}")


def _range(name: str, given: str, items: Sequence[Any], text: str, bare: bool) -> Axis:
    example = _example(name)
    if len(items) != 3 or any(isinstance(i, str) and ("," in i or not i) for i in items):
        raise _refused(given, text, f"is no range low:high:count; write e.g. {example}")
    low, high = (read_value(given, item, bare=bare) for item in items[:2])
    try:
        count = float(items[2])
    except (TypeError, ValueError):
        count = np.nan
    if not (count == np.floor(count) and 2 <= count <= MOST_VALUES):
        allowed = f"a whole number from 2 to {MOST_VALUES}"
        raise _refused(given, text, f"the count {shown(items[2])} is not {allowed}; write e.g. {example}")
    if low == high:
        raise _refused(given, text, "begins where it ends; for one value change the beam and sweep something else")
    if low > high:
        turned = f"{items[1]}:{items[0]}:{items[2]}"
        raise _refused(given, text, f"runs downwards; write {turned}")
    values = np.linspace(low, high, int(count))
    if not np.all(np.diff(values) > 0):
        raise _refused(given, text, "is narrower than its count of numbers can tell apart; give a smaller count")
    return Axis(name, values, text)


def _list(name: str, given: str, items: Sequence[Any], text: str, bare: bool) -> Axis:
    if isinstance(items, Sequence) and len(items) < 2:
        what = "is empty" if not items or items[0] == "" else "is one value, no range"
        raise _refused(given, text, f"{what}; write e.g. {_example(name)}")
    if len(items) > LONGEST_LIST:
        raise _refused(given, text, f"has more than {LONGEST_LIST:,} values; write low:high:count")
    values = np.array([read_value(given, item, bare=bare) for item in items])
    if not np.all(np.diff(values) > 0):
        raise _refused(given, text, "does not increase from each value to the next; put the values in order")
    return Axis(name, values, text)


def _example(name: str) -> str:
    return {
        Dimension.ANGLE: "15deg:75deg:601",
        Dimension.LENGTH: "10mm:60mm:101",
        Dimension.PRESSURE: "1MPa:3MPa:101",
        Dimension.TORQUE: '"0.01 N m:0.05 N m:101"',
    }.get(PARAMETERS[name].dimension, "0.001,0.01,0.1" if name == "margin" else "0.2:0.4:401")


def _refused(given: str, value: object, problem: str) -> InputError:
    return InputError(f"{given} = {shown(value).strip(chr(34))}: {problem}")

"""Parameters of sweeps: names, bounds and meaning, and the reading of their ranges.

A ratio keeps the other ratios and the substrate's section as they are, like ``Beam.from_ratios``: eta changes the
scale's length, beta its width, zeta its embedded length and its thickness, slenderness its thickness, lam the pitch
and with it all four. A dimension (``scale.length``, ``beam.pitch`` ...) changes itself alone.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from types import MappingProxyType
from typing import Any, NamedTuple, NoReturn

import numpy as np

from squama.beam import beamfile, parts
from squama.beam.design import Beam
from squama.errors import InputError, Problem, Problems, naming, refuse
from squama.io.tabular import close
from squama.loads import TESTS
from squama.symbols import SYMBOLS, Symbol
from squama.types import Array
from squama.units import MARGIN, Bounds, Dimension, as_text, bounded, for_people, shown, si_unit

MOST_VALUES, LONGEST_LIST = 10_000_000, 100_000
"""Largest number of values of a range, and of a list."""


class Parameter(NamedTuple):
    """A parameter of sweeps: its dimension, bounds and symbol."""

    dimension: Dimension
    bounds: Bounds
    symbol: Symbol


def _key(name: str) -> Parameter:
    table, _, key = name.partition(".")
    dimension, bounds = beamfile.NUMBERS[name]
    meaning = beamfile.TABLES[table][key].meaning
    words = meaning if len(meaning) > 4 else f"{key.replace('_', ' ')} {meaning}"
    return Parameter(dimension, bounds, Symbol(name, si_unit(dimension), f"{table} {words}", ""))


UNUSED = ("substrate.strength", "substrate.strain_limit", "scale.density", "beam.density", "beam.rotor")
"""Numbers of a beam file that change no figure of many beams."""
ELASTIC = ("scale.youngs_modulus", "scale.poisson_ratio", "scale.strength")
"""Numbers that change only figures of elastic scales."""
FACTOR = "joint.factor"
"""Factor on the K_theta of a compliant joint: the error of the joint's law."""
BEND = "psi"
"""Bend per pitch in which a beam is held while it is twisted; for sweeps only."""
SCALES = "beam.scales"
"""Number of scales; for designs only, because figures of sweeps do not depend on it."""
FULL = {"alpha": "scale.alpha", "theta0": "scale.theta0", "mu": "friction.mu"}
"""Names in the beam file of the parameters that have a shorter name."""
PARAMETERS: dict[str, Parameter] = {
    **{n: Parameter(Dimension.RATIO, bounds, SYMBOLS[n]) for n, bounds in parts.RATIOS.items()},
    **{n: Parameter(*beamfile.NUMBERS[name], SYMBOLS[n]) for n, name in FULL.items()},
    "margin": Parameter(Dimension.RATIO, MARGIN, SYMBOLS["margin"]),
    BEND: Parameter(
        Dimension.ANGLE,
        Bounds(-1.0, 1.0, "-1 to 1 rad", closed=True, example="2 deg"),
        SYMBOLS[BEND]._replace(long_name="bend per pitch in which the beam is held"),
    ),
    **{name: _key(name) for name in beamfile.NUMBERS if name not in (*FULL.values(), *UNUSED)},
    SCALES: Parameter(
        Dimension.RATIO,
        Bounds(2.0, 1e6, "2 or more", closed=True, example="25"),
        Symbol(SCALES, "1", "beam number N of scales", ""),
    ),
    FACTOR: Parameter(
        Dimension.RATIO,
        Bounds(0.1, 10.0, "0.1 to 10", closed=True, example="1"),
        Symbol(FACTOR, "1", "factor on the joint's stiffness", ""),
    ),
}
"""Parameters by name, in the order in which messages list them."""

ALIASES = {"lambda": "lam"} | {full: short for short, full in FULL.items()}
"""Names of parameters by their other names."""
_CHANGES = {
    "eta": ("scale.length",),
    "beta": ("scale.width",),
    "zeta": ("scale.embedded", "scale.thickness"),
    "slenderness": ("scale.thickness",),
    "lam": ("beam.pitch", "scale.length", "scale.width", "scale.embedded", "scale.thickness"),
}
_NO_EFFECT = {
    **dict.fromkeys(UNUSED, "changes no figure of many beams; leave it out"),
    SCALES: "the figures of a sweep are per pitch or per length, so it changes nothing; leave it out",
    "law": "is no range; give both laws with --law edge,plate",
    "sense": "is no range; sweep each sense into a store of its own",
}


class Axis(NamedTuple):
    """A swept parameter: its name and its values in SI units, increasing."""

    name: str
    values: Array

    @property
    def span(self) -> str:
        """The range as text with units."""
        return f"{self.name} = {text_of(self.name, self.values[0])} to {text_of(self.name, self.values[-1])}"

    @property
    def record(self) -> list[float] | dict[str, float]:
        """The values for the configuration: both ends and the count where they are evenly spaced, else a list."""
        low, high, count = float(self.values[0]), float(self.values[-1]), self.values.size
        if count > 2 and np.array_equal(self.values, np.linspace(low, high, count)):
            return {"low": low, "high": high, "count": count}
        return [float(v) for v in self.values]

    @classmethod
    def from_record(cls, name: str, record: object) -> Axis:
        """Read an axis from its :attr:`record`."""
        if isinstance(record, Mapping):
            return cls(name, np.linspace(record["low"], record["high"], record["count"]))
        return cls(name, np.asarray(record, float))


def text_of(name: str, value: float) -> str:
    """Return a value of a parameter (SI), by any of its names, as text with a suitable unit."""
    dimension = PARAMETERS[ALIASES.get(name, name)].dimension
    text = as_text(float(value), dimension)
    if len(text) <= 14 and dimension is not Dimension.RATIO:
        return text
    factor, unit = people(name)
    return f"{factor * value:.6g} {unit}".strip()


def people(name: str) -> tuple[float, str]:
    """Return the unit in which texts show a parameter, after its factor from SI."""
    return for_people(PARAMETERS[ALIASES.get(name, name)].symbol.unit)


def own(beam: Beam, name: str) -> float | None:
    """Return a value that a beam states (SI), by any name of the parameter; None where it states none."""
    if name == FACTOR:
        return 1.0
    table, _, key = FULL.get(name, name).partition(".")
    if f"{table}.{key}" == SCALES:
        return float(beam.pitches)
    value = getattr(beam if table == "beam" else getattr(beam, table), key)
    return None if value is None else float(value)


def of_beam(beam: Beam, load: str, name: str) -> float:
    """Return a value of a beam (SI); a joint's value not stated comes from law or matrix, any other is 0."""
    if name == "joint.stiffness":
        return beam.joint_stiffness
    if name == "joint.inclusion_factor":
        return TESTS[load].inclusion(beam)
    return (name and own(beam, name)) or 0.0


def canonical(name: str) -> str:
    """Return the canonical name of a parameter; refuse an unknown name with a suggestion."""
    if name in _NO_EFFECT:
        refuse(name, "", _NO_EFFECT[name])
    if name in PARAMETERS:
        return name
    if name in ALIASES:
        return ALIASES[name]
    known = [key for key in PARAMETERS if key not in _NO_EFFECT]
    remedy = f"{meant(name, [*known, *ALIASES])}allowed: {', '.join(known)}"
    raise InputError(Problem(shown(name).strip('"'), "", "is no parameter that can be swept", remedy))


def meant(name: str, known: Iterable[str], short: Mapping[str, str] = MappingProxyType({})) -> str:
    """Return "did you mean ...? " with the known names that end in ``name``, or the most similar name; else ""."""
    near = close(name, [*known, *short])
    names = [full for full in known if full.endswith(f".{name}")] or [short.get(near, near)]
    return f"did you mean {' or '.join(names)}? " if names != [""] else ""


def effective(name: str, joint: str, *, ideal: bool, load: str = "twisting") -> None:
    """Refuse a parameter that changes no figure of the model."""
    rigid = ideal or joint == "hinge"
    if name == BEND and load != "twisting":
        refuse(name, "", "is what bending changes", 'leave it out, or write load="twisting"')
    why = dict.fromkeys(ELASTIC, "changes nothing where scales are rigid; leave it out") if rigid else {}
    why |= (
        {FACTOR: "is for the compliant joint; leave it out"}
        if joint == "hinge"
        else {"margin": "is of hinges' locks; leave it out"}
    )
    if name in why:
        refuse(name, "", why[name])


def axes(
    over: Mapping[str, object], *, bare: bool = True, joint: str = "hinge", ideal: bool = True, load: str = "twisting"
) -> list[Axis]:
    """Read all swept parameters, in the given order.

    A value is ``(low, high, count)``, a list or an array, or text such as ``"15deg:75deg:601"`` or ``"0.1,0.2,0.5"``; a
    number without a unit is SI (``bare``) or refused. One InputError names all mistakes.
    """
    found: dict[str, Axis] = {}
    first: dict[str, str] = {}
    problems = Problems()
    for name, value in over.items():
        with problems.caught():
            known = canonical(str(name))
            effective(known, joint, ideal=ideal, load=load)
            if first.setdefault(known, str(name)) != str(name):
                refuse(str(name), "", f"is the same parameter as {first[known]}", "give it once")
            found[known] = Axis(known, _values(known, str(name), value, bare=bare))
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


def flattened(table: Mapping[str, object], prefix: str = "") -> Iterator[tuple[str, object]]:
    """Yield dotted names (``"scale.length"``) and values of nested tables."""
    for key, value in table.items():
        if isinstance(value, Mapping):
            yield from flattened(value, f"{prefix}{key}.")
        else:
            yield f"{prefix}{key}", value


def read_value(name: str, value: object, *, bare: bool) -> float:
    """Return one value of a parameter in SI units; an InputError names ``name``."""
    parameter = PARAMETERS[ALIASES.get(name, name)]
    with naming(name):
        return bounded(value, parameter.dimension, parameter.bounds, bare=bare)


EXAMPLES = {
    Dimension.ANGLE: ("15deg:75deg:601", "60 deg", "1 deg"),
    Dimension.LENGTH: ("10mm:60mm:101", "20 mm", "0.1 mm"),
    Dimension.PRESSURE: ("1MPa:3MPa:101", "1.5 MPa", "5 %"),
    Dimension.TORQUE: ('"0.01 N m:0.05 N m:101"', "0.02 N m", "10 %"),
    Dimension.RATIO: ("0.2:0.4:401", "0.25", "0.03"),
}
"""Examples for messages by dimension: a range, a value and its tolerance."""


def _values(name: str, given: str, value: object, *, bare: bool) -> Array:
    """Return the values of a parameter (named ``given`` by the user) from a range low:high:count or a list."""
    example = "0.001,0.01,0.1" if name == "margin" else EXAMPLES[PARAMETERS[name].dimension][0]
    spaced = isinstance(value, tuple) or (isinstance(value, str) and ":" in value)
    said = value

    def no(reason: str, remedy: str = f"write e.g. {example}") -> NoReturn:
        refuse(given, shown(said).strip('"'), reason, remedy)

    items: Any = value.tolist() if isinstance(value, np.ndarray) and value.ndim == 1 else value
    if isinstance(value, str):
        items = [part.strip() for part in value.split(":" if spaced else ",")]
    elif isinstance(items, Sequence):
        said = ":".join(map(str, items)) if spaced else f"{len(items)} values"
    else:
        no("is no range", f"write {example}")
    if spaced:
        if len(items) != 3 or any(isinstance(i, str) and ("," in i or not i) for i in items):
            no("is no range low:high:count")
        low, high = (read_value(given, item, bare=bare) for item in items[:2])
        try:
            count = float(items[2])
        except (TypeError, ValueError):
            count = np.nan
        if not (count == np.floor(count) and 2 <= count <= MOST_VALUES):
            no(f"the count {shown(items[2])} is not a whole number from 2 to {MOST_VALUES}")
        if low == high:
            no("begins where it ends", "for one value change the beam and sweep something else")
        if low > high:
            no("runs downwards", f"write {items[1]}:{items[0]}:{items[2]}")
        values = np.linspace(low, high, int(count))
        wrong = "is narrower than its count of numbers can tell apart", "give a smaller count"
    else:
        if len(items) < 2:
            no("is empty" if not items or items[0] == "" else "is one value, no range")
        if len(items) > LONGEST_LIST:
            no(f"has more than {LONGEST_LIST:,} values", "write low:high:count")
        values = np.array([read_value(given, item, bare=bare) for item in items])
        wrong = "does not increase from each value to the next", "put the values in order"
    if not np.all(np.diff(values) > 0):
        no(*wrong)
    return values

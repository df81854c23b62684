"""Target files: tables and keys, values with their units, and the messages for mistakes."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple

from squama import units
from squama.beam.beamfile import TABLES
from squama.errors import InputError, Problem, Problems, naming, printable, refuse
from squama.inverse.named_figures import At
from squama.inverse.space import DIMENSIONS, Choice, Grid, Variable
from squama.io.tabular import guess
from squama.loads import LOADS
from squama.study.parameters import ALIASES, PARAMETERS, SCALES, effective, flattened, text_of
from squama.units import LONGEST, Dimension, shown

_SENSE = re.compile(r"\s*(at least|at most|>=|<=)\s+(.*)", re.DOTALL | re.IGNORECASE)


AT_POINTS = ("stiffness_ratio", "stress", "RED", "W_fr")
"""Figures at a point, besides the torque, that exist with thick scales only."""
MATERIAL = ("youngs_modulus", "poisson_ratio", "strength")
GROUPS = {str(kind): kind for kind in (Dimension.LENGTH, Dimension.ANGLE, Dimension.PRESSURE, Dimension.RATIO)}
FINEST = 1e-9
ROUNDED = {"length": Grid(0.1, "mm"), "angle": Grid(0.5, "deg")}
"""Default rounding of beams with thick scales."""


Table = Mapping[str, object]


class File(NamedTuple):
    """A target file without the tables of the beam: plain keys, the tables that are given, lists of points by key."""

    plain: Table
    tables: Mapping[str, Table]
    points: Mapping[str, Sequence[Table]]

    def table(self, name: str) -> Table:
        """Return a table; empty where it is not given."""
        return self.tables.get(name, {})


EXAMPLES = {
    "target": 'lock = "120 deg total"',
    "choose": 'scale.thickness = ["0.8 mm", "1.2 mm", "1.6 mm"]',
    "rounding": 'length = "0.1 mm"',
    "printer": 'feature = "0.4 mm"',
    "vary": 'scale.length = ["40 mm", "70 mm"]',
    "limits": 'gap = "1 mm"',
    "tolerance": 'scale.length = "0.2 mm"',
    "front": 'maximise = ["tangent", "range"]',
    "points": '[[target.points]] with twist = "60 deg total" and torque = "80 N mm"',
    "tangent": '[[target.tangent]] with twist = "60 deg total" and stiffness = "0.1 N m^2"',
}
_PLAIN: Table = {"load": "twisting", "law": "edge", "sense": "+", "margin": 0.01, "designs": 5}
FRONT: Table = {"maximise": [], "minimise": [], "at": None, "population": 200, "generations": 100, "seed": 1}
"""Keys of [front] and their defaults: objectives and settings of NSGA-II."""
GOALS = ("lock", "engagement", "stiffness", "RED", "critical_mu", "length")
"""Figures of [target] without a twist."""
_POINT = ("twist", "torque", "moment", "stiffness", *AT_POINTS, "weight")
_TABLES = ("target", "front", "vary", "choose", "rounding", "printer", "limits", "tolerance")
_KEYS = {
    "": ("start", "joint", *_PLAIN, *_TABLES),
    "target": (GOALS[0], "lock_by", *GOALS[1:], "points", "tangent", "curve", "accept"),
    "front": tuple(FRONT),
    "points": ("twist", "torque", *AT_POINTS, "weight"),
    "tangent": ("twist", "stiffness", "weight"),
}


def parse(data: Table) -> tuple[File | None, dict[str, object], list[Problem]]:
    """Return a target file's own part (None if its structure is wrong), the beam's tables, and mistakes."""
    # joint = "..." is the kind of joint, [joint] a table of the beam
    beam = {key: value for key, value in data.items() if key in TABLES and (key, type(value)) != ("joint", str)}
    own, problems = {key: value for key, value in data.items() if key not in beam}, Problems()
    plain = {**_PLAIN, **{key: value for key, value in own.items() if key not in _TABLES}}
    tables, points = dict[str, Table](), dict[str, list[Table]]()
    for name in _TABLES:
        given = own.get(name)
        if isinstance(given, Mapping):
            tables[name] = given
        elif given is not None:
            problems.add(name, shown(given), "is not a table", f"write [{name}] and under it e.g. {EXAMPLES[name]}")
        table = tables.get(name, {})
        if name == "target":
            points = {kind: _points(kind, table, problems) for kind in ("points", "tangent")}
        problems += _strange(f"{name}.", table, _KEYS.get(name, tuple(table)))
    problems += _strange("", own, _KEYS[""], also=f", and the tables of a beam: {', '.join(TABLES)}")
    return None if problems else File(plain, tables, points), beam, problems


def _points(kind: str, target: Table, problems: Problems) -> list[Table]:
    """Return a list of tables in [target], each with its keys in order."""
    found, where, given = list[Table](), f"target.{kind}", target.get(kind, [])
    pairs: list[tuple[str, object]] = [(where, given)]
    if listed := isinstance(given, list | tuple):
        pairs = [(f"{where}[{i}]", one) for i, one in enumerate(given)]
    for place, point in pairs:
        if not listed or not isinstance(point, Mapping):
            problems.add(place, shown(point), "is no list of tables", f"write {EXAMPLES[kind]}")
            continue
        if "twist" not in point:
            problems.add(f"{place}.twist", "", "is missing", f"write e.g. {EXAMPLES[kind]}")
        problems += _strange(f"{place}.", {key: point[key] for key in point if key not in _POINT}, _KEYS[kind])
        found.append({key: point[key] for key in _POINT if key in point})
    return found


def _strange(place: str, given: Table, known: Sequence[str], also: str = "") -> list[Problem]:
    """Return the mistakes of keys that are not known in a table."""
    return [unknown(f"{place}{key}", key, known, "unknown key", also) for key in given if key not in known]


def unknown(where: str, name: str, known: Iterable[str], reason: str, also: str = "") -> Problem:
    """Return the mistake of an unknown name: the likely name, and the allowed ones."""
    known = list(known)
    meant = guess(name, [*known, *TABLES] if also else known)
    return Problem(where, "", reason, f"{meant}allowed: {', '.join(known)}{also}")


class Given(NamedTuple):
    """A value as given: SI, number and unit as written, and the sense "=", ">=" or "<="; a twist is in ``at``."""

    si: float
    number: float
    unit: str
    sense: str = "="
    at: At | None = None


class Context(NamedTuple):
    """Context of reading; ``hinged``: the keys of the file that select hinges, where the user may leave them out."""

    scales: int
    load: str
    bare: bool
    joint: str = "hinge"
    hinged: tuple[str, ...] = ()

    @property
    def beams(self) -> tuple[tuple[float, int], ...]:
        """Pitch (m) and number of scales of three beams that tell a rate, an angle per pitch and a total apart."""
        return (1.0, self.scales), (2.0, self.scales), (1.0, 2 * self.scales)


def quantity(where: str, value: object, dimension: Dimension, context: Context) -> Given:
    """Read a positive quantity; ``where`` is its place for messages."""
    sense, rest = _sense(value)
    with naming(where):
        si = units.quantity(rest, dimension, bare=context.bare)
    if si <= 0:
        refuse(where, shown(rest), "must be more than 0", f"write e.g. {units.example(dimension)}")
    unit = "" if dimension is Dimension.RATIO else units.si_unit(dimension)
    return Given(si, *_split(rest, unit), sense)


def twist(where: str, value: object, context: Context) -> Given:
    """Read a twist (curvature): a rate, or an angle per pitch or of the beam, which then holds for every pitch."""
    sense, rest = _sense(value)
    load = LOADS[context.load]
    with naming(where):
        rates = [load.read(rest, pitch=p, scales=n, bare=context.bare) for p, n in context.beams]
    if rates[0] <= 0:
        turned = load.other_way('sense = "-"')
        refuse(where, shown(rest), f"must be more than 0{turned}", 'write e.g. "0.2 rad/pitch"')
    at = common_twist(rates, context)
    if at.per_pitch(0.0, context.scales) >= math.pi:
        most = f'write less than "{180 * context.scales:g} deg total"'
        refuse(where, shown(rest), "is half a turn per pitch or more, beyond the model", most)
    return Given(0.0, *_split(rest, "rad/m"), sense, at)


def common_twist(rates: Sequence[float], context: Context) -> At:
    """Return a twist from its rates (rad/m) on the beams of :attr:`Context.beams`."""
    rate, shorter, more = rates
    if more != rate and context.joint == "compliant":
        return At(0.0, 0.0, rate * context.scales)
    return At(rate, 0.0) if rate == shorter else At(0.0, rate)


def _sense(value: object) -> tuple[str, object]:
    """Split "at least 5 mm" into ">=" and the rest."""
    if isinstance(value, str) and (match := _SENSE.fullmatch(value)):
        return {"at least": ">=", "at most": "<="}.get(match[1].lower(), match[1]), match[2]
    return "=", value


def _split(value: object, unit: str) -> tuple[float, str]:
    """Return number and unit as written; ``unit`` for a bare number."""
    if isinstance(value, str) and len(value) <= LONGEST and (match := units.NUMBER.fullmatch(value)):
        return float(match[1]), match[2]
    if isinstance(value, int | float) and not isinstance(value, bool):
        return float(value), unit
    return math.nan, ""


def variables(file: File, problems: Problems, context: Context) -> tuple[Variable, ...]:
    """Read the tables [vary] and [rounding]."""
    found: list[Variable] = []
    if not (flat := dict(flattened(file.table("vary")))) and not file.table("choose"):
        problems.add("[vary]", "", "nothing to vary", f"add this table with e.g. {EXAMPLES['vary']}")
    for name, bounds in flat.items():
        with problems.caught():
            found.append(_variable(f"vary.{name}", name, bounds, context))
    grids: dict[str, Grid] = dict(ROUNDED) if context.joint == "compliant" else {}
    for name, step in sorted(flattened(file.table("rounding")), key=lambda item: item[0] not in GROUPS):
        where = f"rounding.{name}"
        with problems.caught():
            kind = GROUPS.get(name) or PARAMETERS[key_of(where, name)].dimension
            key = str(kind) if name in GROUPS else key_of(where, name)
            if step is False:
                grids[key] = Grid()
                continue
            got = quantity(where, step, kind, context)
            if got.si < FINEST:
                refuse(where, shown(step), "is too fine", f"write at least {FINEST:g} in SI units")
            grids[key] = Grid(got.number, got.unit)
    grids[SCALES] = Grid(1.0)
    return tuple(v._replace(grid=grids.get(v.key, grids.get(str(PARAMETERS[v.key].dimension), v.grid))) for v in found)


def choices(table: Table, problems: Problems, context: Context) -> tuple[Choice, ...]:
    """Read the table [choose]: lists of values of a dimension, or of materials."""
    found: list[Choice] = []
    for name, listed in flattened(table):
        where = f"choose.{name}"
        with problems.caught():
            if not isinstance(listed, list | tuple) or not listed:
                refuse(where, shown(listed), "is no list", f"write e.g. {EXAMPLES['choose']}")
            if name in ("scale.material", "substrate.material"):
                part = name.split(".")[0]
                read = [_material(f"{where}[{i}]", part, one, context) for i, one in enumerate(listed)]
                if any(set(option) != set(read[0][1]) for _, option in read):
                    remedy = f"allowed: name, {', '.join(MATERIAL)}"
                    refuse(where, "", "gives different keys for different materials", remedy)
            else:
                key = key_of(where, name)
                read = [(text_of(key, value), {name: value}) for value in _values(where, key, listed, context)]
            found.append(Choice(name, *zip(*read, strict=True)))
    return tuple(found)


def _material(where: str, table: str, given: object, context: Context) -> tuple[str, dict[str, float]]:
    """Read a material: its name, and the values (SI) that it sets in a table of the beam."""
    allowed = [key for key in MATERIAL if f"{table}.{key}" in PARAMETERS]
    if not isinstance(given, Mapping) or not isinstance(given.get("name"), str) or "youngs_modulus" not in given:
        refuse(where, shown(given), "is no material", 'write { name = "PETG", youngs_modulus = "2.1 GPa" }')
    for key in given:
        if key not in ("name", *allowed):
            raise InputError(unknown(f"{where}.{key}", key, ["name", *allowed], "unknown key"))
    keys = [key for key in allowed if key in given]
    found = {f"{table}.{k}": _values(f"{where}.{k}", f"{table}.{k}", [given[k]], context)[0] for k in keys}
    return printable(given["name"]), found


def _variable(where: str, name: str, bounds: object, context: Context) -> Variable:
    """Read the bounds of a varied dimension."""
    key = key_of(where, name)
    if not isinstance(bounds, list | tuple) or len(bounds) != 2:
        table, _, own = name.partition(".")
        first = units.quantity(TABLES[table][own].example.strip('"'), PARAMETERS[key].dimension)
        example = ", ".join(f'"{text_of(key, factor * first)}"' for factor in (1, 1.5))
        refuse(where, shown(bounds), "is no pair of bounds", f"write e.g. {name} = [{example}]")
    low, high = _values(where, key, bounds, context)
    if low == high:
        refuse(where, shown(bounds), "begins where it ends", "put that value into the beam and leave it out here")
    if low > high:
        refuse(where, shown(bounds), "is reversed", f"write [{shown(bounds[1])}, {shown(bounds[0])}]")
    if context.joint == "hinge":
        effective(key, "hinge", ideal=True)
    return Variable(name, low, high)


def _values(where: str, key: str, given: Sequence[object], context: Context) -> list[float]:
    """Read values of a dimension, SI; numbers of scales must be whole and cannot vary on hinges."""
    if key == SCALES and context.joint == "hinge":
        refuse(where, "", "cannot be varied on hinges", "put it into the beam")
    kind = PARAMETERS[key]
    with naming(where):
        found = [units.bounded(value, kind.dimension, kind.bounds, bare=context.bare) for value in given]
    if key == SCALES and (parts := [value for value in found if value != round(value)]):
        refuse(where, f"{parts[0]:g}", "is not a whole number", "write e.g. 25")
    return found


def key_of(where: str, name: str) -> str:
    """Return the key of a dimension of the beam file; refuse other names."""
    if name in DIMENSIONS:
        return ALIASES.get(name, name)
    full = [f for f in DIMENSIONS if f.rpartition(".")[2] == name and name not in ("width", "thickness")]
    meant = f"did you mean {full[-1]}? " if full else guess(name, DIMENSIONS)
    raise InputError(Problem(where, "", "is no dimension of a beam", f"{meant}allowed: {', '.join(DIMENSIONS)}"))

"""What is varied, chosen and rounded, as a target file says it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from squama import units
from squama.beam import beamfile
from squama.errors import InputError, Problem, Problems, naming, printable, refuse
from squama.inverse import targetfile
from squama.inverse.space import DIMENSIONS, Choice, Grid, Variable
from squama.inverse.targetfile import Context, File
from squama.io.tabular import guess
from squama.study.parameters import ALIASES, PARAMETERS, SCALES, effective, flattened, text_of
from squama.units import Dimension, shown

MATERIAL = ("youngs_modulus", "poisson_ratio", "strength")
GROUPS = {str(kind): kind for kind in (Dimension.LENGTH, Dimension.ANGLE, Dimension.PRESSURE, Dimension.RATIO)}
FINEST = 1e-9
ROUNDED = {"length": Grid(0.1, "mm"), "angle": Grid(0.5, "deg")}
"""To what real beams are rounded unless the file says else."""


def variables(file: File, problems: Problems, context: Context) -> tuple[Variable, ...]:
    """Read the tables [vary] and [rounding]."""
    found: list[Variable] = []
    if not (flat := dict(flattened(file.vary))) and not file.choose:
        problems.add("[vary]", "", "nothing to vary", f"add this table with e.g. {targetfile.EXAMPLES['vary']}")
    for name, bounds in flat.items():
        with problems.caught():
            found.append(_variable(f"vary.{name}", name, bounds, context))
    grids: dict[str, Grid] = dict(ROUNDED) if context.joint == "compliant" else {}
    for name, step in sorted(flattened(file.rounding), key=lambda item: item[0] not in GROUPS):
        where = f"rounding.{name}"
        with problems.caught():
            kind = GROUPS.get(name) or PARAMETERS[key_of(where, name)].dimension
            key = str(kind) if name in GROUPS else key_of(where, name)
            if step is False:
                grids[key] = Grid()
                continue
            got = targetfile.quantity(where, step, kind, context)
            if got.si < FINEST:
                refuse(where, shown(step), "is finer than any workshop", f"write at least {FINEST:g} in SI units")
            grids[key] = Grid(got.number, got.unit)
    grids[SCALES] = Grid(1.0)
    return tuple(v._replace(grid=grids.get(v.key, grids.get(str(PARAMETERS[v.key].dimension), v.grid))) for v in found)


def choices(table: dict[str, object], problems: Problems, context: Context) -> tuple[Choice, ...]:
    """Read what is chosen from lists: values of a dimension, or materials."""
    found: list[Choice] = []
    for name, listed in flattened(table):
        where = f"choose.{name}"
        with problems.caught():
            if not isinstance(listed, list | tuple) or not listed:
                refuse(where, shown(listed), "is no list", f"write e.g. {targetfile.EXAMPLES['choose']}")
            if name in ("scale.material", "substrate.material"):
                part, bare = name.split(".")[0], context.bare
                read = [_material(f"{where}[{i}]", part, one, bare=bare) for i, one in enumerate(listed)]
                if any(set(option) != set(read[0][1]) for _, option in read):
                    remedy = f"allowed: name, {', '.join(MATERIAL)}"
                    refuse(where, "", "does not say the same of every material", remedy)
            else:
                kind = PARAMETERS[key := key_of(where, name)]
                _check_joint(where, key, context)
                with naming(where):
                    si = [units.bounded(value, kind.dimension, kind.bounds, bare=context.bare) for value in listed]
                _check_whole(where, key, si)
                read = [(text_of(key, value), {name: value}) for value in si]
            found.append(Choice(name, *zip(*read, strict=True)))
    return tuple(found)


def _material(where: str, table: str, given: object, *, bare: bool) -> tuple[str, dict[str, float]]:
    """Read a material: its name, and what it sets of a table of the beam."""
    allowed = [key for key in MATERIAL if f"{table}.{key}" in PARAMETERS]
    if not isinstance(given, Mapping) or not isinstance(given.get("name"), str) or "youngs_modulus" not in given:
        refuse(where, shown(given), "is no material", 'write { name = "PETG", youngs_modulus = "2.1 GPa" }')
    for key in given:
        if key not in ("name", *allowed):
            raise InputError(targetfile.unknown(f"{where}.{key}", key, ["name", *allowed], "unknown key"))
    found = {}
    for key in (key for key in allowed if key in given):
        kind = PARAMETERS[f"{table}.{key}"]
        with naming(f"{where}.{key}"):
            found[f"{table}.{key}"] = units.bounded(given[key], kind.dimension, kind.bounds, bare=bare)
    return printable(given["name"]), found


def _variable(where: str, name: str, bounds: object, context: Context) -> Variable:
    """Read the bounds of a dimension."""
    key = key_of(where, name)
    _check_joint(where, key, context)
    if not isinstance(bounds, list | tuple) or len(bounds) != 2:
        table, _, own = name.partition(".")
        first = units.quantity(beamfile.TABLES[table][own].example.strip('"'), PARAMETERS[key].dimension)
        example = ", ".join(f'"{text_of(key, factor * first)}"' for factor in (1, 1.5))
        refuse(where, shown(bounds), "is no pair of bounds", f"write e.g. {name} = [{example}]")
    kind = PARAMETERS[key]
    with naming(where):
        low, high = (units.bounded(b, kind.dimension, kind.bounds, bare=context.bare) for b in bounds)
    _check_whole(where, key, (low, high))
    if low == high:
        refuse(where, shown(bounds), "begins where it ends", "put that value into the beam and leave it out here")
    if low > high:
        refuse(where, shown(bounds), "is reversed", f"write [{shown(bounds[1])}, {shown(bounds[0])}]")
    if context.joint == "hinge":
        effective(key, "hinge", ideal=True)
    return Variable(name, low, high)


def _check_joint(where: str, key: str, context: Context) -> None:
    """Refuse to vary the number of scales on hinges."""
    if key == SCALES and context.joint == "hinge":
        refuse(where, "", "is varied of real beams; on hinges it stays as it is", "put it into the beam")


def _check_whole(where: str, key: str, values: Sequence[float]) -> None:
    """Refuse numbers of scales that are not whole."""
    for value in values:
        if key == SCALES and value != round(value):
            refuse(where, f"{value:g}", "is not a whole number", "write e.g. 25")


def key_of(where: str, name: str) -> str:
    """Return the key of a dimension of the beam file, or refuse a name that is none."""
    if name in DIMENSIONS:
        return ALIASES.get(name, name)
    full = [f for f in DIMENSIONS if f.rpartition(".")[2] == name and name not in ("width", "thickness")]
    meant = f"did you mean {full[-1]}? " if full else guess(name, DIMENSIONS)
    raise InputError(Problem(where, "", "is no dimension of a beam", f"{meant}allowed: {', '.join(DIMENSIONS)}"))

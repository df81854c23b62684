"""A target: starting beam, what is asked, what may be varied and within which limits; from a file or a mapping."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

from squama import arguments, units
from squama.beam import beamfile
from squama.beam.design import Beam
from squama.errors import InputError, Problem, Problems, naming, refuse
from squama.inverse import goals, targetfile
from squama.inverse.figures import LOCKS, Options
from squama.inverse.goals import ACCEPT, Goal
from squama.inverse.limits import ALWAYS, LIMITS
from squama.inverse.space import DIMENSIONS, Space, Variable
from squama.inverse.targetfile import Context, File, FrontTable
from squama.io import files
from squama.io.tabular import guess
from squama.loads import LOADS
from squama.model.outcome import CODES, End
from squama.study.parameters import ALIASES, PARAMETERS, flattened, own, text_of
from squama.units import Dimension, shown

MOST_DESIGNS = 100
DEFAULTS = {Dimension.LENGTH: 1e-4, Dimension.ANGLE: 0.017453292519943295}
"""Tolerances of lengths (m) and angles (rad) unless given; of the rest: SHARE of the value."""
SHARE = 0.05
_LOCKS = {"any": LOCKS, **{e.value.split()[0]: (CODES.index(e),) for e in (End.FRICTIONAL, End.KINEMATIC, End.STATIC)}}


class Target(NamedTuple):
    """A target that was read and checked.

    ``limits`` by name, SI; ``laws`` whose ranges hold as limits; ``tolerance`` by key, SI or (below 0) as minus the
    share of the value; ``front`` as it stands in the file.
    """

    source: str
    space: Space
    options: Options
    goals: tuple[Goal, ...]
    accept: float
    limits: dict[str, float]
    laws: list[str]
    tolerance: dict[str, float]
    designs: int
    front: FrontTable | None


def read_target(
    target: str | os.PathLike[str] | Mapping[str, Any],
    *,
    beam: Beam | None = None,
    need: str = "target",
    overrides: Mapping[str, Mapping[str, Any]] | None = None,
) -> Target:
    """Read a target: a TOML file, or the same as nested mappings (numbers without a unit are then SI).

    ``beam`` stands in place of the starting beam of the file, ``overrides`` (by table and key) in place of its values;
    ``need`` is the table that has to be there, "target" or "front". All mistakes are named at once.
    """
    if isinstance(target, Mapping):
        source, data, folder, bare = "", dict(target), Path(), True
    else:
        source, folder, bare = files.label(target), Path(target).parent, False
        text = files.read_text(target)
        with naming(source=source):
            data = beamfile.loads(text)
    file, tables, mistakes = targetfile.parse(data)
    problems = Problems(mistakes)
    start = beam
    if beam is None:
        with problems.caught():
            start = _start(data.get("start"), tables, folder, overrides or {}, bare=bare)
    elif tables or "start" in data:
        problems.add("start", "", "a beam is given as an argument too", "give one of them")
    common: dict[str, Any] = {}
    if file is not None:
        common = _common(file, problems)
        if getattr(file, need) is None:
            problems.add(f"[{need}]", "", "is missing", f"add this table with e.g. {targetfile.EXAMPLES[need]}")
    problems.settle(source)
    assert file is not None
    assert start is not None
    context = Context(start.scales, common["load"], bare)
    found = _read(file, start, common, context, folder, problems)._replace(source=source)
    problems.settle(source)
    return found


def _start(
    start: object, tables: dict[str, Any], folder: Path, overrides: Mapping[str, Mapping[str, Any]], *, bare: bool
) -> Beam:
    """Return the starting beam: of a file, of the tables of the target, or the file's with values of the tables."""
    wrong = Problems()
    for table, content in tables.items():
        if not isinstance(content, Mapping):
            wrong.append(beamfile.no_table(table, content))
        else:
            wrong += [beamfile.unknown_key(table, key) for key in content if key not in beamfile.TABLES[table]]
    wrong.settle()
    merged = {t: {**tables.get(t, {}), **overrides.get(t, {})} for t in {**tables, **overrides}}
    if isinstance(start, str | os.PathLike):
        return Beam.from_toml(folder / start, overrides=merged)
    if start is not None:
        refuse("start", shown(start), "is no file name", 'write e.g. start = "beam.toml"')
    if not tables:
        refuse("start", "", "is missing", 'write start = "beam.toml", or the tables [scale], [substrate], [beam]')
    return Beam._build(beamfile.merge({}, merged), bare=bare)


def _common(file: File, problems: Problems) -> dict[str, Any]:
    """Return what is not in a table: load, law, sense, margin and number of designs."""
    found: dict[str, Any] = {}
    words = {"load": tuple(LOADS), "law": ("edge", "plate"), "sense": ("+", "-")}
    for name, allowed in words.items():
        with problems.caught():
            found[name] = arguments.one_of(name, getattr(file, name), allowed)
    for name in ("margin", "designs"):
        value = getattr(file, name)
        with problems.caught():
            if isinstance(value, bool) or not isinstance(value, int | float):
                refuse(name, shown(value), "is no plain number")
            found[name] = arguments.margin(value) if name == "margin" else arguments.whole(name, value, 1, MOST_DESIGNS)
    return found


def _read(file: File, beam: Beam, common: dict[str, Any], context: Context, folder: Path, problems: Problems) -> Target:
    variables = _variables(file.vary, problems, bare=context.bare)
    space = Space(beam, context.load, variables)
    varied = {v.key for v in variables}
    if beam.friction.mu is None and "mu" not in varied:
        remedy = "write mu = 0.25 under [friction] of the beam, or vary friction.mu"
        problems.add("friction.mu", "", "is missing", remedy)
    wanted = targetfile.TargetTable() if file.target is None else file.target
    by = "any" if wanted.lock_by is None else str(wanted.lock_by)
    if by not in _LOCKS:
        words = f"allowed: {', '.join(map(shown, _LOCKS))}"
        problems.add("target.lock_by", shown(wanted.lock_by), "is not known", words)
    asked = goals.read_goals(wanted, context, folder, problems)
    if file.target is not None:
        goals.conflicts(asked, space, problems)
    accept = ACCEPT
    if wanted.accept is not None:
        with problems.caught():
            accept = targetfile.quantity("target.accept", wanted.accept, Dimension.RATIO, context).si
            if accept >= 1:
                refuse("target.accept", shown(wanted.accept), "must be below 1", 'write e.g. "1 %"')
    limits, laws = _limits(file, beam, varied, context, problems)
    designs, law = common.pop("designs"), LOADS[context.load].law(common.pop("law"))
    options = Options(**common, law=law, locks=_LOCKS.get(by, LOCKS))
    tolerance = _tolerances(file.tolerance, space, problems, bare=context.bare)
    return Target("", space, options, asked, accept, limits, laws, tolerance, designs, file.front)


def _variables(table: dict[str, object], problems: Problems, *, bare: bool) -> tuple[Variable, ...]:
    found: list[Variable] = []
    if not (flat := dict(flattened(table))):
        problems.add("[vary]", "", "nothing to vary", f"add this table with e.g. {targetfile.EXAMPLES['vary']}")
    for name, bounds in flat.items():
        with problems.caught():
            found.append(_variable(f"vary.{name}", name, bounds, bare=bare))
    return tuple(found)


def _variable(where: str, name: str, bounds: object, *, bare: bool) -> Variable:
    key = _key(where, name)
    if not isinstance(bounds, list | tuple) or len(bounds) != 2:
        table, _, own = name.partition(".")
        first = units.quantity(beamfile.TABLES[table][own].example.strip('"'), PARAMETERS[key].dimension)
        example = ", ".join(f'"{text_of(key, factor * first)}"' for factor in (1, 1.5))
        refuse(where, shown(bounds), "is no pair of bounds", f"write e.g. {name} = [{example}]")
    kind = PARAMETERS[key]
    with naming(where):
        low, high = (units.bounded(b, kind.dimension, kind.bounds, bare=bare) for b in bounds)
    if low == high:
        refuse(where, shown(bounds), "begins where it ends", "put that value into the beam and leave it out here")
    if low > high:
        refuse(where, shown(bounds), "is reversed", f"write [{shown(bounds[1])}, {shown(bounds[0])}]")
    return Variable(name, low, high)


def _key(where: str, name: str) -> str:
    """Return the key of a dimension of the beam file, or refuse a name that is none."""
    if name in DIMENSIONS:
        return ALIASES.get(name, name)
    if name == "beam.scales":
        refuse(where, "", "is a whole number and stays as it is", "put it into the beam")
    full = [f for f in DIMENSIONS if f.rpartition(".")[2] == name and name not in ("width", "thickness")]
    meant = f"did you mean {full[-1]}? " if full else guess(name, DIMENSIONS)
    raise InputError(Problem(where, "", "is no dimension of a beam", f"{meant}allowed: {', '.join(DIMENSIONS)}"))


def _limits(
    file: File, beam: Beam, varied: set[str], context: Context, problems: Problems
) -> tuple[dict[str, float], list[str]]:
    found = dict(ALWAYS)
    laws: list[str] = []
    for name, value in file.limits.items():
        where = f"limits.{name}"
        if name == "joint_law":
            if not isinstance(value, bool):
                problems.add(where, shown(value), "must be true or false")
            elif value:
                lawful = not (LOADS[context.load].matrix and beam.joint.matrix is not None)
                laws = [
                    f"{law} {context.load}"
                    for law, key in (("stiffness", "stiffness"), ("inclusion", "inclusion_factor"))
                    if lawful and getattr(beam.joint, key) is None and f"joint.{key}" not in varied
                ]
        elif name not in LIMITS:
            problems.append(targetfile.unknown(where, name, [*LIMITS, "joint_law"], "unknown limit"))
        elif name == "edge" and value is False:
            del found["edge"]
        else:
            limit = LIMITS[name]
            with problems.caught(where):
                found[name] = units.bounded(value, limit.dimension, limit.bounds, bare=context.bare)
    return found, laws


def _tolerances(table: dict[str, object], space: Space, problems: Problems, *, bare: bool) -> dict[str, float]:
    """Return tolerances by key; a share of the value as minus that share."""
    has = (ALIASES.get(name, name) for name in DIMENSIONS if own(space.beam, name) is not None)
    keys = dict.fromkeys([*has, *(v.key for v in space.variables)])
    kinds = {key: PARAMETERS[key].dimension for key in keys}
    found = {key: DEFAULTS.get(kinds[key], -SHARE) for key in keys}
    groups = {"length": Dimension.LENGTH, "angle": Dimension.ANGLE, "relative": Dimension.RATIO}

    def size(where: str, value: object, kind: Dimension) -> float:
        with naming(where):
            si = units.quantity(value, kind, bare=bare)
        if si < 0:
            refuse(where, shown(value), "is below 0", "write the size of the tolerance")
        return si

    for name, value in sorted(dict(flattened(table)).items(), key=lambda item: item[0] not in groups):
        where = f"tolerance.{name}"
        with problems.caught():
            if name in groups:
                si = size(where, value, groups[name])
                share = name == "relative"
                same = (k for k in keys if (kinds[k] not in DEFAULTS if share else kinds[k] is groups[name]))
                found |= dict.fromkeys(same, -si if share else si)
                continue
            key = _key(where, name)
            share = isinstance(value, str) and value.strip().endswith("%")
            si = size(where, value, Dimension.RATIO if share else PARAMETERS[key].dimension)
            found[key] = -si if share else si
    return found

"""A target: starting beam, what is asked, what may be varied and within which limits; from a file or a mapping."""

from __future__ import annotations

import os
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

from squama import beamfile, checks, files
from squama.design import Beam
from squama.errors import InputError
from squama.inverse import asked, read, schema
from squama.inverse.goals import ACCEPT, Goal
from squama.inverse.limits import ALWAYS, LIMITS
from squama.inverse.space import DIMENSIONS, Space, Variable, given
from squama.inverse.wants import LOCKS, Options
from squama.model.outcome import CODES, End
from squama.study.parameters import ALIASES, PARAMETERS, read_value, text_of
from squama.units import Dimension, QuantityError, shown

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
    front: schema.FrontTable | None
    notes: tuple[str, ...] = ()


def read_target(
    target: str | os.PathLike[str] | Mapping[str, Any],
    *,
    beam: Beam | None = None,
    need: str = "target",
    overrides: Mapping[str, Mapping[str, Any]] | None = None,
) -> Target:
    """Read a target.

    Parameters
    ----------
    target : path or mapping
        A TOML file, or the same as nested mappings (numbers without a unit are then SI).
    beam : Beam, optional
        Starting beam in place of that of the file.
    need : {"target", "front"}
        Which table has to be there.
    overrides : mapping, optional
        Values in place of those of the starting beam, by table and key.

    Returns
    -------
    Target

    Raises
    ------
    InputError
        One line per mistake, with the file's name.
    """
    if isinstance(target, Mapping):
        source, data, folder, bare = "", dict(target), Path(), True
    else:
        source, folder, bare = files.label(target), Path(target).parent, False
        text = files.read_text(target)
        try:
            data = tomllib.loads(text)
        except (ValueError, RecursionError):
            try:
                beamfile.parse(text)  # says in plain words what is wrong
            except InputError as error:
                schema.fail([str(error)], source)
            raise
    file, tables, problems = schema.parse(data)
    start = None
    if beam is None:
        start = _start(data.get("start"), tables, folder, problems, overrides or {}, bare=bare)
    elif tables or "start" in data:
        problems.append("start: a beam is given as an argument too; give one of them")
    else:
        start = beam
    if file is not None:
        _common(file, problems)
        missing = getattr(file, need)
        if missing is None:
            problems.append(f"[{need}]: is missing; add this table with e.g. {schema.EXAMPLES[need]}")
    if file is None or start is None or problems:
        schema.fail(problems, source)
    assert file is not None
    assert start is not None
    found = _read(file, start, read.Context(start.scales, file.load, bare), folder, problems, source)
    schema.fail(problems, source)
    return found


def _start(
    start: object,
    tables: dict[str, Any],
    folder: Path,
    problems: list[str],
    overrides: Mapping[str, Mapping[str, Any]],
    *,
    bare: bool,
) -> Beam | None:
    """Return the starting beam: of a file, of the tables of the target, or the file's with values of the tables."""
    try:
        if wrong := _wrong(tables):
            problems += wrong
            return None
        merged = {t: {**tables.get(t, {}), **overrides.get(t, {})} for t in {**tables, **overrides}}
        if start is None:
            if not tables:
                problems.append(
                    'start: is missing; write start = "beam.toml", or the tables [scale], [substrate], [beam]'
                )
                return None
            arguments = beamfile.merge({}, merged)
            return Beam._build(arguments, bare=bare)
        if not isinstance(start, str | os.PathLike):
            problems.append(f'start = {shown(start)}: is no file name; write e.g. start = "beam.toml"')
            return None
        return Beam.from_toml(folder / start, overrides=merged)
    except InputError as error:
        problems += str(error).splitlines()
        return None


def _wrong(tables: dict[str, Any]) -> list[str]:
    """Return a line for every key of a beam's tables that does not belong."""
    lines = []
    for table, content in tables.items():
        if not isinstance(content, Mapping):
            lines.append(beamfile.no_table(table, content))
        else:
            lines += [beamfile.unknown_key(table, key) for key in content if key not in beamfile.TABLES[table]]
    return lines


def _common(file: schema.File, problems: list[str]) -> None:
    for name, value, allowed in (
        ("load", file.load, ("twisting", "bending")),
        ("law", file.law, ("edge", "plate")),
        ("sense", file.sense, ("+", "-")),
    ):
        if value not in allowed:
            words = " or ".join(f'"{a}"' for a in allowed)
            problems.append(f"{name} = {shown(value)}: must be {words}")
    for name, value, low, high in (("margin", file.margin, 1e-12, 1.0), ("designs", file.designs, 1, MOST_DESIGNS + 1)):
        try:
            if isinstance(value, bool) or not isinstance(value, int | float):
                read.refuse(name, value, "is no plain number")
            if name == "designs":
                checks.whole(name, value, low, MOST_DESIGNS)
            else:
                checks.scalar(name, value, low, high, "at least 1e-12 and below 1")
        except InputError as error:
            problems.append(str(error))


def _read(
    file: schema.File, beam: Beam, context: read.Context, folder: Path, problems: list[str], source: str
) -> Target:
    variables = _variables(file.vary, problems, bare=context.bare)
    space = Space(beam, file.load, variables)
    varied = {v.key for v in variables}
    if beam.friction.mu is None and "mu" not in varied:
        problems.append("friction.mu: is missing; write mu = 0.25 under [friction] of the beam, or vary friction.mu")
    wanted = schema.TargetTable() if file.target is None else file.target
    locks = LOCKS
    if wanted.lock_by is not None:
        if wanted.lock_by not in _LOCKS:
            words = ", ".join(f'"{name}"' for name in _LOCKS)
            problems.append(f"target.lock_by = {shown(wanted.lock_by)}: is not known; allowed: {words}")
        else:
            locks = _LOCKS[wanted.lock_by]
    goals = asked.goals(wanted, context, folder, problems)
    if file.target is not None:
        asked.conflicts(goals, space, problems)
    accept = ACCEPT
    if wanted.accept is not None:
        try:
            accept = read.quantity("target.accept", wanted.accept, Dimension.RATIO, context, "").si
            if accept >= 1:
                read.refuse("target.accept", wanted.accept, 'must be below 1; write e.g. "1 %"')
        except InputError as error:
            problems.append(str(error))
    limits, laws = _limits(file, beam, varied, context, problems)
    options = Options(file.law if file.load == "twisting" else "edge", file.sense, float(file.margin), file.load, locks)
    tolerance = _tolerances(file.tolerance, space, problems, bare=context.bare)
    return Target(source, space, options, goals, accept, limits, laws, tolerance, int(file.designs), file.front)


def _variables(table: dict[str, Any], problems: list[str], *, bare: bool) -> tuple[Variable, ...]:
    found: list[Variable] = []
    given_ = read.flattened(table)
    if not given_:
        problems.append(f"[vary]: nothing to vary; add this table with e.g. {schema.EXAMPLES['vary']}")
    for name, bounds in given_.items():
        where = f"vary.{name}"
        try:
            full = dimension(where, name)
            example = (
                f'write e.g. {name} = ["{text_of(_key(full), _low(full))}", "{text_of(_key(full), 1.5 * _low(full))}"]'
            )
            if not isinstance(bounds, list | tuple) or len(bounds) != 2:
                read.refuse(where, bounds, f"is no pair of bounds; {example}")
            low, high = (read_value(full, b, bare=bare) for b in bounds)
            if low == high:
                read.refuse(where, bounds, "begins where it ends; put that value into the beam and leave it out here")
            if low > high:
                read.refuse(where, bounds, f"is reversed; write [{shown(bounds[1])}, {shown(bounds[0])}]")
            if full in {v.name for v in found}:
                read.refuse(where, bounds, "is given twice; keep one")
            found.append(Variable(full, low, high))
        except InputError as error:
            words = str(error)
            problems.append(words if words.startswith("vary.") else f"vary.{words}")
    return tuple(found)


def _key(full: str) -> str:
    return ALIASES.get(full, full)


def _low(full: str) -> float:
    """Return a value of a dimension for an example."""
    from squama.units import quantity

    table, _, key = full.partition(".")
    kind = PARAMETERS[_key(full)].dimension
    return quantity(beamfile.TABLES[table][key].example.strip('"'), kind)


def dimension(where: str, name: str) -> str:
    """Return the full name of a dimension of the beam file, or refuse one that is none."""
    shorter = {
        full.rpartition(".")[2]: full for full in DIMENSIONS if full.rpartition(".")[2] not in ("width", "thickness")
    }
    if name in DIMENSIONS:
        return name
    if name == "beam.scales":
        message = f"{where}: is a whole number and stays as it is; put it into the beam"
        raise InputError(message)
    meant = f"did you mean {shorter[name]}? " if name in shorter else read.guess(name, DIMENSIONS)
    message = f"{where}: is no dimension of a beam; {meant}allowed: {', '.join(DIMENSIONS)}"
    raise InputError(message)


def _limits(
    file: schema.File, beam: Beam, varied: set[str], context: read.Context, problems: list[str]
) -> tuple[dict[str, float], list[str]]:
    found = dict(ALWAYS)
    laws: list[str] = []
    for name, value in file.limits.items():
        where = f"limits.{name}"
        if name == "joint_law":
            if not isinstance(value, bool):
                problems.append(f"{where} = {shown(value)}: must be true or false")
            elif value:
                stiffness = beam.joint.stiffness is None and "joint.stiffness" not in varied
                inclusion = beam.joint.inclusion_factor is None and "joint.inclusion_factor" not in varied
                laws = [f"stiffness {file.load}"] * stiffness + [f"inclusion {file.load}"] * inclusion
        elif name not in LIMITS:
            known = [*LIMITS, "joint_law"]
            problems.append(f"{where}: unknown limit; {read.guess(name, known)}allowed: {', '.join(known)}")
        elif name == "edge" and value is False:
            del found["edge"]
        else:
            limit = LIMITS[name]
            try:
                from squama.units import bounded

                found[name] = bounded(value, limit.dimension, limit.bounds, bare=context.bare)
            except QuantityError as error:
                problems.append(f"{where} = {error.shown}: {error.reason}")
    return found, laws


def _tolerances(table: dict[str, Any], space: Space, problems: list[str], *, bare: bool) -> dict[str, float]:
    """Return tolerances by key; a share of the value as minus that share."""
    keys = dict.fromkeys([*given(space.beam), *(v.key for v in space.variables)])
    kinds = {key: PARAMETERS[key].dimension for key in keys}
    found = {key: DEFAULTS.get(kinds[key], -SHARE) for key in keys}
    flat = read.flattened(table)
    groups = {"length": Dimension.LENGTH, "angle": Dimension.ANGLE, "relative": Dimension.RATIO}
    for name, value in sorted(flat.items(), key=lambda item: item[0] not in groups):
        where = f"tolerance.{name}"
        try:
            if name in groups:
                si = _tolerance(where, value, groups[name], bare)
                same = [
                    k for k in keys if (kinds[k] is groups[name] if name != "relative" else kinds[k] not in DEFAULTS)
                ]
                found |= dict.fromkeys(same, -si if name == "relative" else si)
                continue
            key = _key(dimension(where, name))
            share = isinstance(value, str) and value.strip().endswith("%")
            si = _tolerance(where, value, Dimension.RATIO if share else PARAMETERS[key].dimension, bare)
            found[key] = -si if share else si
        except InputError as error:
            problems.append(str(error))
    return found


def _tolerance(where: str, value: object, kind: Dimension, bare: bool) -> float:
    from squama.units import quantity

    try:
        si = quantity(value, kind, bare=bare)
    except QuantityError as error:
        message = f"{where} = {error.shown}: {error.reason}"
        raise InputError(message) from None
    if si < 0:
        read.refuse(where, value, "is below 0; write the size of the tolerance")
    return si

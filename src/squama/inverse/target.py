"""A target, read from a file or a mapping: starting beam, goals, varied dimensions and limits."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from squama import arguments, units
from squama.beam import beamfile
from squama.beam.design import Beam
from squama.errors import InputError, Problems, naming, refuse
from squama.fabrication.plan import SIZES, plan
from squama.fabrication.plan import read as read_sizes
from squama.inverse import goals, targetfile
from squama.inverse.goals import ACCEPT, Goal
from squama.inverse.joint_figures import EVALUATE
from squama.inverse.limits import ALWAYS, LIMITS, Sizes, known_rooms, printed_rooms, rooms
from squama.inverse.named_figures import AT_TWIST, OF_LOCKS, Found, Options, Want, harmless
from squama.inverse.space import DIMENSIONS, Space
from squama.inverse.targetfile import FRONT, Context, File, Table
from squama.io import files
from squama.loads import LOADS
from squama.model.outcome import CODES, LOCKS, End
from squama.study.columns import Cells, valid
from squama.study.parameters import ALIASES, ELASTIC, PARAMETERS, SCALES, flattened, own
from squama.types import Array
from squama.units import Dimension, shown

MOST_DESIGNS = 100
DEFAULTS = {Dimension.LENGTH: 1e-4, Dimension.ANGLE: 0.017453292519943295}
"""Default tolerances of lengths (m) and angles (rad); other values have the share SHARE."""
SHARE = 0.05
_LOCKS = {
    "any": LOCKS,
    **{e.value.split()[0]: (CODES.index(e),) for e in (End.FRICTIONAL, End.STATIC)},
    "kinematic": (CODES.index(End.KINEMATIC), CODES.index(End.LINE)),
}
_HINGED = {"joint": "hinge", "law": "plate"}
LOCK_GOALS = ("lock", "lock_by", "RED", "critical_mu")


class Target(NamedTuple):
    """A target, read and checked; ``printer``: sizes with which thick scales must be printable, or None.

    ``limits`` by name, SI; ``laws``: scaling laws whose ranges are limits; ``tolerance`` by key, SI, or minus a share.
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
    front: Table | None
    printer: dict[str, float] | None

    @property
    def compliant(self) -> bool:
        """Whether figures are those of thick, elastic scales on compliant joints."""
        return self.options.joint == "compliant"

    @property
    def own(self) -> bool:
        """Whether designs have a number of scales and are judged as finite beams."""
        return self.compliant and (self.space.beam.scales is not None or SCALES in self.space.keys)

    @property
    def inside(self) -> float:
        """Margin inside "at least" and "at most" that the search keeps, because rounding uses some of it."""
        return self.accept if self.compliant else 0.0

    def figures(self, c: Cells, moved: Sequence[Cells], wants: Sequence[Want], *, plates: bool) -> Found:
        """Evaluate figures of designs; rows that are no valid beam get harmless values first."""
        return EVALUATE[self.options.joint](harmless(c, valid(c)), moved, wants, self.options, plates=plates)

    def rooms(self, c: Cells, s: Sizes) -> dict[str, Array]:
        """Return the room to every limit, to the range of the joint's law, and to the rules of printing, by name."""
        found = rooms(s, self.limits, self.laws)
        if self.compliant and self.space.beam.joint.matrix is None:
            found |= known_rooms(c, self.space.cells(self.space.start[None]))
        if self.printer is not None:
            # two scales: a slot and its neighbour
            found |= printed_rooms(c, plan(self.space.beam, 2, self.printer))
        return found


def read_target(
    target: str | os.PathLike[str] | Mapping[str, object],
    *,
    beam: Beam | None = None,
    need: str = "target",
    overrides: Mapping[str, Mapping[str, object]] | None = None,
) -> Target:
    """Read a target from a TOML file, or from nested mappings (numbers without a unit are then SI).

    ``beam`` replaces the starting beam of the file, ``overrides`` (by table and key) replace its values; ``need`` is
    the required table, "target" or "front". One InputError names all mistakes.
    """
    if isinstance(target, Mapping):
        source, data, folder, bare = "", dict(target), Path(), True
    else:
        source, folder, bare = files.label(target), files.folder_of(target), False
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
    if file is not None and need not in file.tables:
        problems.add(f"[{need}]", "", "is missing", f"add this table with e.g. {targetfile.EXAMPLES[need]}")
    common = {} if file is None else _common(file, problems)
    problems.settle(source)
    assert file is not None
    assert start is not None
    locks = _of_locks(file, need)
    joint = _joint(file, common, locks, problems)
    # the keys that select hinges
    keys = [f'{key} = "{value}"' for key, value in _HINGED.items() if file.plain.get(key) == value]
    context = Context(start.pitches, common["load"], bare, joint, (*keys, *locks))
    found = _read(source, file, start, common, context, folder, problems)
    problems.settle(source)
    return found


def _start(
    start: object, tables: dict[str, Any], folder: Path, overrides: Mapping[str, Mapping[str, object]], *, bare: bool
) -> Beam:
    """Return the starting beam from a file, from tables of the target, or from the file with values of the tables."""
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


def _of_locks(file: File, need: str) -> list[str]:
    """Return the places in the file of goals or objectives that exist on hinges only."""
    if need == "target":
        return [f"target.{key}" for key in LOCK_GOALS if file.table(need).get(key) is not None]
    table = file.table("front")
    listed = [names for key in ("maximise", "minimise") if isinstance(names := table.get(key), list | tuple)]
    locks = [name for name in OF_LOCKS if table.get("at") is None or name not in AT_TWIST]
    return [f"front: {name}" for names in listed for name in names if name in locks]


def _joint(file: File, common: Mapping[str, Any], locks: Sequence[str], problems: Problems) -> str:
    """Return the joint: "hinge" for locks or the plate law, else "compliant"."""
    covered = LOADS[common["load"]].law(common["law"]) == "edge"
    joint = "compliant" if covered and not locks else "hinge"
    if (given := file.plain.get("joint")) is None:
        return joint
    with problems.caught():
        joint = arguments.one_of("joint", str(given), ("compliant", "hinge"))
    if joint == "compliant" and not covered:
        problems.add("joint", shown(joint), "is for the edge law", 'write joint = "hinge"')
    if joint == "compliant" and locks:
        reason = "is of a lock, which only thin, rigid scales on hinges have"
        problems.add(locks[0], "", reason, "ask for a stiffness ratio, torque or stress at a twist")
    return joint


def _common(file: File, problems: Problems) -> dict[str, Any]:
    """Read the keys outside of tables: load, law, sense, margin and number of designs."""
    found: dict[str, Any] = {}
    checks: dict[str, Callable[[Any], object]] = {
        "load": arguments.load,
        "law": arguments.law,
        "sense": arguments.sense,
        "margin": arguments.margin,
        "designs": lambda value: arguments.whole("designs", value, 1, MOST_DESIGNS),
    }
    for name, check in checks.items():
        value = file.plain[name]
        with problems.caught():
            if name in ("margin", "designs") and (isinstance(value, bool) or not isinstance(value, int | float)):
                refuse(name, shown(value), "is no plain number")
            check(value)
            found[name] = value
    return found


def _read(
    source: str, file: File, beam: Beam, common: dict[str, Any], context: Context, folder: Path, problems: Problems
) -> Target:
    """Read the tables of a target; mistakes are added to ``problems``."""
    compliant, load = context.joint == "compliant", context.load
    choices = targetfile.choices(file.table("choose"), problems, context)
    space = Space(beam, load, targetfile.variables(file, problems, context), choices)
    keys = set(space.keys)
    if len(keys) < len(space.keys):
        problems.add("[choose]", "", "sets what is varied or chosen elsewhere, too", "keep one")
    if beam.friction.mu is None and "mu" not in keys:
        remedy = "write mu = 0.25 under [friction] of the beam, or vary friction.mu"
        problems.add("friction.mu", "", "is missing", remedy)
    given_by, accepted = (file.table("target").get(key) for key in ("lock_by", "accept"))
    by = "any" if given_by is None else str(given_by)
    if by not in _LOCKS:
        words = f"allowed: {', '.join(map(shown, _LOCKS))}"
        problems.add("target.lock_by", shown(given_by), "is not known", words)
    asked = goals.read_goals(file, context, folder, problems)
    stressed = {goal.want.figure for goal in asked} & {"stress", "strength_share"}
    for key in ["youngs_modulus"] * bool(stressed) + ["strength"] * ("strength_share" in stressed):
        if getattr(beam.scale, key) is None and f"scale.{key}" not in keys:
            remedy = "a stress needs it: give it to the beam, or choose a material"
            problems.add(f"scale.{key}", "", "is missing", remedy)
    if "target" in file.tables:
        goals.conflicts(asked, space, problems)
    accept = ACCEPT
    if accepted is not None:
        with problems.caught():
            accept = targetfile.quantity("target.accept", accepted, Dimension.RATIO, context).si
            if accept >= 1:
                refuse("target.accept", shown(accepted), "must be below 1", 'write e.g. "1 %"')
    limits, laws = _limits(file, beam, keys, context, problems)
    printer = None
    if limits.pop("printable", compliant):
        with problems.caught():
            if wrong := [name for name in file.table("printer") if name not in SIZES]:
                raise InputError(targetfile.unknown(f"printer.{wrong[0]}", wrong[0], SIZES, "unknown key"))
            printer = read_sizes(file.table("printer"), "printer.", bare=context.bare)
    law, locks = LOADS[load].law(common["law"]), _LOCKS.get(by, LOCKS)
    options = Options(law, common["sense"], common["margin"], load, locks, context.joint)
    tolerance = _tolerances(file.table("tolerance"), space, problems, context)
    front = {**FRONT, **file.tables["front"]} if "front" in file.tables else None
    return Target(source, space, options, asked, accept, limits, laws, tolerance, common["designs"], front, printer)


def _limits(
    file: File, beam: Beam, varied: set[str], context: Context, problems: Problems
) -> tuple[dict[str, float], list[str]]:
    """Read the limits (SI), and the scaling laws whose ranges are limits."""
    found, laws = dict(ALWAYS), list[str]()
    words = {
        "joint_law": "hinges; a compliant joint is always within its law",
        "printable": "beams on compliant joints",
    }
    for name, value in file.table("limits").items():
        where = f"limits.{name}"
        if name in words and (name == "joint_law") != (context.joint == "hinge"):
            problems.add(where, "", f"is a limit of {words[name]}", "leave it out")
        elif name in words and not isinstance(value, bool):
            problems.add(where, shown(value), "must be true or false")
        elif name == "printable":
            found[name] = bool(value)
        elif name == "joint_law":
            pairs = (("stiffness", "stiffness"), (f"inclusion {context.load}", "inclusion_factor"))
            known = [key for _, key in pairs if getattr(beam.joint, key) is not None or f"joint.{key}" in varied]
            laws = [law for law, key in pairs if value and beam.joint.matrix is None and key not in known]
        elif name not in LIMITS:
            problems.append(targetfile.unknown(where, name, [*LIMITS, *words], "unknown limit"))
        elif name == "edge" and value is False:
            del found["edge"]
        else:
            limit = LIMITS[name]
            with problems.caught(where):
                found[name] = units.bounded(value, limit.dimension, limit.bounds, bare=context.bare)
    return found, laws


def _tolerances(table: Table, space: Space, problems: Problems, context: Context) -> dict[str, float]:
    """Return tolerances by key: SI, or minus the share of the value."""
    compliant = context.joint == "compliant"
    has = (ALIASES.get(name, name) for name in DIMENSIONS if own(space.beam, name) is not None)
    without = (SCALES,) if compliant else (SCALES, *ELASTIC)
    keys = (key for key in (*has, *(v.key for v in space.variables)) if key not in without)
    kinds = {key: PARAMETERS[key].dimension for key in keys}
    found = {key: DEFAULTS.get(kind, -SHARE) for key, kind in kinds.items()}
    groups = {"length": Dimension.LENGTH, "angle": Dimension.ANGLE, "relative": Dimension.RATIO}
    for name, value in sorted(dict(flattened(table)).items(), key=lambda item: item[0] not in groups):
        where = f"tolerance.{name}"
        with problems.caught():
            key = "" if name in groups else targetfile.key_of(where, name)
            if compliant and key and key not in kinds:
                refuse(where, "", "is for a value that the beam does not give", "give it to the beam")
            share = name == "relative" or (bool(key) and isinstance(value, str) and value.strip().endswith("%"))
            kind = Dimension.RATIO if share else groups.get(name) or PARAMETERS[key].dimension
            with naming(where):
                si = units.quantity(value, kind, bare=context.bare)
            if si < 0:
                refuse(where, shown(value), "is below 0", "write the size of the tolerance")
            same = [k for k, own_kind in kinds.items() if (own_kind not in DEFAULTS if share else own_kind is kind)]
            found |= dict.fromkeys([key] if key else same, -si if share else si)
    return found

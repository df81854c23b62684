"""The shape of a target file: its tables and keys, and one line for everything that does not fit."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from pydantic import BaseModel, ConfigDict, ValidationError

from squama.beamfile import TABLES
from squama.errors import InputError
from squama.inverse.read import guess
from squama.units import shown


class _Table(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")


class PointTable(_Table):
    """A point of the torque-twist curve, or a tangent stiffness at a twist."""

    twist: Any
    torque: Any = None
    moment: Any = None
    stiffness: Any = None
    weight: Any = 1.0


class TargetTable(_Table):
    """What is asked."""

    lock: Any = None
    lock_by: Any = None
    engagement: Any = None
    stiffness: Any = None
    RED: Any = None
    critical_mu: Any = None
    points: list[PointTable] = []
    tangent: list[PointTable] = []
    curve: Any = None
    accept: Any = None


class FrontTable(_Table):
    """What is traded off."""

    maximise: Any = []
    minimise: Any = []
    at: Any = None
    population: Any = 200
    generations: Any = 100
    seed: Any = 1


class File(_Table):
    """A whole target file, without the tables of the beam."""

    start: Any = None
    load: Any = "twisting"
    law: Any = "edge"
    sense: Any = "+"
    margin: Any = 0.01
    designs: Any = 5
    target: TargetTable | None = None
    front: FrontTable | None = None
    vary: dict[str, Any] = {}
    limits: dict[str, Any] = {}
    tolerance: dict[str, Any] = {}


EXAMPLES = {
    "target": 'lock = "120 deg total"',
    "vary": 'scale.length = ["40 mm", "70 mm"]',
    "limits": 'gap = "1 mm"',
    "tolerance": 'scale.length = "0.2 mm"',
    "front": 'maximise = ["tangent", "range"]',
    "points": '[[target.points]] with twist = "60 deg total" and torque = "80 N mm"',
    "tangent": '[[target.tangent]] with twist = "60 deg total" and stiffness = "0.1 N m^2"',
}
_KEYS = {
    "": tuple(File.model_fields),
    "target": tuple(TargetTable.model_fields),
    "front": tuple(FrontTable.model_fields),
    "points": ("twist", "torque", "weight"),
    "tangent": ("twist", "stiffness", "weight"),
}


def parse(data: Mapping[str, Any]) -> tuple[File | None, dict[str, Any], list[str]]:
    """Split a target file into its own part and the tables of the beam.

    Returns
    -------
    file : File or None
        None if its shape is wrong.
    beam : dict
        Tables of the beam as they stand in the file.
    problems : list of str
        One line per mistake of shape.
    """
    beam = {key: value for key, value in data.items() if key in TABLES}
    own = {key: value for key, value in data.items() if key not in TABLES}
    try:
        return File.model_validate(own), beam, []
    except ValidationError as error:
        return None, beam, [_line(e["type"], list(e["loc"]), e["input"]) for e in error.errors(include_url=False)]


def place(path: list[Any]) -> str:
    """Return a place in the file: target.points[1].twist."""
    words = ""
    for part in path:
        words += f"[{part}]" if isinstance(part, int) else f".{part}" if words else str(part)
    return words


def _line(kind: str, path: list[Any], value: object) -> str:
    """Say in one line what does not fit."""
    where = place(path)
    names = [str(part) for part in path if not isinstance(part, int)]
    if kind == "extra_forbidden":
        home = names[-2] if len(names) > 1 else ""
        known = _KEYS[home]
        also = f", and the tables of a beam: {', '.join(TABLES)}" if not home else ""
        everything = (*known, *TABLES) if not home else known
        return f"{where}: unknown key; {guess(names[-1], everything)}allowed: {', '.join(known)}{also}"
    if kind == "missing":
        return f"{where}: is missing; write e.g. {EXAMPLES[names[-2]]}"
    example = EXAMPLES.get(names[-1], "")
    if names[-1] in ("points", "tangent"):
        return f"{where} = {shown(value)}: is no list of tables; write {example}"
    return f"{where} = {shown(value)}: is not a table; write [{names[-1]}] and under it e.g. {example}"


def fail(problems: list[str], source: str) -> None:
    """Raise what has been found, each line with the file's name.

    Raises
    ------
    InputError
        If anything has been found.
    """
    if problems:
        raise InputError("\n".join(f"{source}: {line}" if source else line for line in dict.fromkeys(problems)))

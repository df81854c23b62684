"""The beam file (TOML): its tables and keys, reading and writing, and the messages for mistakes in it."""

from __future__ import annotations

import math
import os
import re
import tomllib
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

from squama.errors import InputError, Problem, Problems, refuse
from squama.io import files
from squama.io.tabular import close, guess
from squama.units import Bounds, Dimension, as_text, shown

if TYPE_CHECKING:
    from pydantic import ValidationError


class Key(NamedTuple):
    """A key of the file: dimension (None for a whole number, word or file name), meaning, example, bounds in SI units.

    ``bounds`` are those of a number, in SI units, with the example.
    """

    dimension: Dimension | None
    meaning: str
    example: str
    bounds: Bounds | None = None


SIZE = Bounds(1e-9, 1e6, "more than 0; 1 nm to 1000 km", closed=True)
DEPTH = Bounds(0.0, 1e6, "0 or more, up to 1000 km", closed=True)
QUARTER = Bounds(0.0, math.pi / 2, "0 to 90 deg, exclusive")
SLANT = Bounds(0.0, math.nextafter(math.pi / 2, 0), "0 or more, below 90 deg", closed=True)
MODULUS = Bounds(1e-6, 1e15, "more than 0; 1e-6 Pa to 1e15 Pa", closed=True)
POISSON = Bounds(-1.0, 0.5, "-1 to 0.5, exclusive")
STIFFNESS = Bounds(1e-18, 1e15, "more than 0; 1e-18 N m to 1e15 N m", closed=True)
STRAIN = Bounds(1e-6, 100.0, "more than 0; 1e-6 to 100", closed=True)
FACTOR = Bounds(1e-3, 1e3, "more than 0; 0.001 to 1000", closed=True)
DENSITY = Bounds(1e-3, 1e6, "more than 0; 0.001 to 1e6 kg/m3", closed=True)
INERTIA = Bounds(1e-18, 1e15, "more than 0; 1e-18 to 1e15 kg m2", closed=True)
FRICTION = Bounds(0.0, 10.0, "0 to 10", closed=True)


def _number(dimension: Dimension, bounds: Bounds, meaning: str, example: str) -> Key:
    return Key(dimension, meaning, example, bounds._replace(example=example))


TABLES: Mapping[str, Mapping[str, Key]] = {
    "scale": {
        "length": _number(Dimension.LENGTH, SIZE, "exposed length l", '"60 mm"'),
        "embedded": _number(Dimension.LENGTH, DEPTH, "embedded length L", '"7 mm"'),
        "width": _number(Dimension.LENGTH, SIZE, "full width 2b", '"30 mm"'),
        "thickness": _number(Dimension.LENGTH, SIZE, "thickness t_s", '"0.2 mm"'),
        "alpha": _number(Dimension.ANGLE, SLANT, "angle between the cross-section and the scale's width", '"45 deg"'),
        "theta0": _number(Dimension.ANGLE, QUARTER, "inclination at rest", '"10 deg"'),
        "youngs_modulus": _number(Dimension.PRESSURE, MODULUS, "E_s; without it the scale is rigid", '"3 GPa"'),
        "poisson_ratio": _number(Dimension.RATIO, POISSON, "nu_s", "0.35"),
        "strength": _number(Dimension.PRESSURE, MODULUS, "largest stress (von Mises) of a scale", '"50 MPa"'),
        "density": _number(Dimension.DENSITY, DENSITY, "density of a scale; for vibration", '"1240 kg/m3"'),
    },
    "substrate": {
        "width": _number(Dimension.LENGTH, SIZE, "width", '"32 mm"'),
        "thickness": _number(Dimension.LENGTH, SIZE, "full thickness 2t", '"16 mm"'),
        "youngs_modulus": _number(Dimension.PRESSURE, MODULUS, "E_B", '"1.5 MPa"'),
        "poisson_ratio": _number(Dimension.RATIO, POISSON, "nu", "0.49"),
        "strength": _number(Dimension.PRESSURE, MODULUS, "largest stress (von Mises) of the bar", '"4 MPa"'),
        "strain_limit": _number(Dimension.RATIO, STRAIN, "largest strain of the bar", "2"),
        "neutral": Key(
            None, "line that keeps its length: middle (also in twisting) or face (hinges in bending)", '"face"'
        ),
    },
    "beam": {
        "pitch": _number(Dimension.LENGTH, SIZE, "distance d between two scales", '"20 mm"'),
        "scales": Key(None, "number N of scales, the beam is N d long; endless if it is not given", "25"),
        "ends": Key(None, "its ends, if it has a number of scales: free, couple or gripped", '"gripped"'),
        "faces": Key(None, "faces with scales: one, mirrored or turned; of two also shifted", '"mirrored"'),
        "hold": Key(None, "strains held: bend, twist, lateral bend, stretch; straight for all", '"bend"'),
        "density": _number(Dimension.DENSITY, DENSITY, "density of the bar; for vibration", '"1150 kg/m3"'),
        "rotor": _number(Dimension.INERTIA, INERTIA, "moment of inertia at its end", '"1e-4 kg m2"'),
    },
    "joint": {
        "stiffness": _number(Dimension.TORQUE, STIFFNESS, "K_theta of one scale", '"0.02 N m"'),
        "inclusion_factor": _number(Dimension.RATIO, FACTOR, "C_f", "1.4"),
        "matrix": Key(None, "file of the joint's stiffness in all motions, from squama joint --matrix", '"joint.csv"'),
    },
    "friction": {"mu": _number(Dimension.RATIO, FRICTION, "coefficient of friction", "0.25")},
}
PART: Mapping[str, Mapping[str, Key]] = {
    "support": {
        "kind": Key(None, "clamped (the root), gripped (both ends) or simple (two rollers)", '"simple"'),
        "span": Key(Dimension.LENGTH, "distance between the rollers of simple", '"160 mm"'),
    },
    "load": {"text": Key(None, "a force, moment, tendon ... or a deformation that is imposed", '"2 N up at tip"')},
    "along": {
        "scale.theta0": Key(None, "values of the first and the last scale, or of each", '["5 deg", "9 deg"]'),
        "table": Key(None, "in place of these a table (CSV) with a row for each scale", '"scales.csv"'),
    },
}
"""Tables of a part under load (:class:`squama.Part`), which a file may have besides those of its beam."""
NUMBERS: dict[str, tuple[Dimension, Bounds]] = {
    f"{table}.{name}": (key.dimension, key.bounds)
    for table, keys in TABLES.items()
    for name, key in keys.items()
    if key.dimension is not None and key.bounds is not None
}
"""Dimension and bounds of the file's numbers, by "table.key"."""
# a value with a unit, but without the quotes that TOML needs
_LONGEST_LINE = 200
_UNQUOTED = re.compile(r"\s*([\w.-]+)\s*=\s*([+-]?\d[\w.+-]*\s*[^\s\d\"'#\[\]{},][^\"'#\[\]{},]*?)\s*(?:#.*)?")


def read(path: str | os.PathLike[str]) -> tuple[str, str]:
    """Return a beam file's name for messages, and its text."""
    files.place(path, "beam.toml")
    name = files.label(path)
    example = "beam.toml" if os.fspath(path) == files.INPUT else name
    force = " --force" if files.exists(path) else ""
    return name, files.read_text(path, missing=f"write an example with: squama new {example}{force}")


def loads(text: str) -> dict[str, object]:
    """Return the tables of TOML text; text that is not TOML is refused with the line number, not the file's name."""
    try:
        return tomllib.loads(text)
    except ValueError as error:
        raise InputError(_not_toml(str(error), text)) from None
    except RecursionError:
        refuse("", "", "is nested too deeply for a beam file")


def parse(text: str) -> tuple[dict[str, object], Problems]:
    """Return the arguments of `Beam` in the text of a beam file, and a problem for every unknown key and table.

    The tables of a part under load are allowed and left out: see :func:`sections`.
    """
    arguments: dict[str, object] = {}
    problems = Problems()
    for table, content in loads(text).items():
        if table in PART:
            continue
        if table not in TABLES:
            problems.append(unknown_table(table, content, (*TABLES, *PART)))
        elif not isinstance(content, dict):
            problems.append(no_table(table, content))
        elif table == "beam":
            arguments |= {key: value for key, value in content.items() if key in TABLES["beam"]}
            problems += [unknown_key(table, key) for key in content if key not in TABLES["beam"]]
        else:
            arguments[table] = content
    return arguments, problems


def sections(text: str) -> dict[str, object]:
    """Return the tables of a part under load (:data:`PART`) in the text of a beam file."""
    return {name: content for name, content in loads(text).items() if name in PART}


def beside_the_beam(text: str) -> str:
    """Return the headings of the tables of a part under load in a beam file's text, which a `Beam` ignores."""
    return ", ".join(map(heading, sections(text)))


def heading(section: str) -> str:
    """Return the heading in the file of a table of a part."""
    return "[[load]]" if section == "load" else f"[{section}]"


def merge(arguments: Mapping[str, object], overrides: Mapping[str, Mapping[str, object]]) -> dict[str, object]:
    """Return the arguments with the values of ``overrides`` in place of theirs, by table and key as in the file."""
    merged: dict[str, Any] = dict(arguments)
    for table, content in overrides.items():
        if table == "beam":
            merged |= content
        else:
            merged[table] = {**merged.get(table, {}), **content}
    return merged


def explain(error: ValidationError, root: str | None, problems: Iterable[Problem] = ()) -> InputError:
    """Turn pydantic's errors in a table (None: a whole beam) into problems, after the given ones.

    A key or table that a misspelt one stands for is not also reported as missing.
    """
    found = Problems(problems)
    missing: list[tuple[str, str]] = []
    for one in error.errors(include_url=False):
        path = [str(part) for part in one["loc"]]
        table, key = _place(path, root)
        where = f"{table}.{key}" if key else table
        cause = one.get("ctx", {}).get("error")
        if one["type"] == "missing":
            missing.append((table, key))
        elif one["type"] == "extra_forbidden":
            found.append(unknown_key(table, key or table, whole_beam=len(path) == 1 and root is None))
        elif isinstance(cause, InputError):
            # problems from a check of several keys already have their place
            found += (cause.at(where) if key else cause).problems
        elif not key:
            found.append(no_table(table, one["input"]))
        else:
            found.add(where, shown(one["input"]), one["msg"].lower())
    # a misspelt key or a table given as something else is one mistake, not two
    found += [_missing(table, key) for table, key in missing if not any(_meant(p, table, key) for p in found)]
    return InputError(*found)


def no_table(table: str, value: object) -> Problem:
    """Return the problem of a table given as another type."""
    keys = ", ".join({**TABLES, **PART}.get(table, ()))
    return Problem(table, shown(value), "is not a table", f"write [{table}] and under it {keys}")


def unknown_table(table: str, content: object, known: Sequence[str] = tuple(TABLES)) -> Problem:
    """Return the problem of an unknown table (or of a key outside all tables), with a guess among the known ones."""
    tables = ", ".join(known)
    if isinstance(content, dict):
        meant = guess(table, known, "[{}]")
        return Problem(f"[{_name(table)}]", "", "unknown table", f"{meant}allowed: {tables}")
    homes = _homes(table)
    remedy = f"put it under {' or '.join(f'[{home}]' for home in homes)}" if homes else f"allowed tables: {tables}"
    return Problem(_name(table), shown(content), "stands outside the tables", remedy)


def unknown_key(table: str, key: str, *, whole_beam: bool = False) -> Problem:
    """Return the problem of an unknown key of a table, with a guess among the known ones."""
    keys = [*{**TABLES, **PART}[table], *(name for name in TABLES if whole_beam and name != "beam")]
    homes = _homes(key)
    meant = f"it belongs in {' or '.join(f'[{home}]' for home in homes)}; " if homes else guess(key, keys)
    return Problem(f"{table}.{_name(key)}", "", "unknown key", f"{meant}allowed: {', '.join(keys)}")


def write(tables: Mapping[str, Mapping[str, float | str | None]]) -> str:
    """Return the text of a beam file, with a comment on each value; `parse` and `Beam` read back the same floats.

    ``tables`` are SI values by table and key; None for a key that is not given. A matrix is written out as its file's
    text.
    """
    parts = []
    for table, keys in TABLES.items():
        values = ((name, key, tables[table][name]) for name, key in keys.items())
        lines = [f"{n} = {_written(v, key.dimension)}  # {key.meaning}" for n, key, v in values if v is not None]
        if lines:
            parts.append("\n".join([f"[{table}]", *lines]))
    return "\n\n".join(parts) + "\n"


def _written(value: float | str, dimension: Dimension | None) -> str:
    """Return a value in TOML."""
    if isinstance(value, str):
        return f"'''\n{value}'''" if "\n" in value else f'"{value}"'
    if dimension is None:
        return str(value)
    text = as_text(value, dimension)
    return text if dimension is Dimension.RATIO else f'"{text}"'


def _place(path: Sequence[str], root: str | None) -> tuple[str, str]:
    """Return table and key of pydantic's location in the model; the key is "" for a whole table."""
    if root:
        return root, path[0] if path else ""
    if not path:
        return "beam", ""
    if path[0] in TABLES and path[0] != "beam":
        return path[0], path[1] if len(path) > 1 else ""
    return "beam", path[0]


def _missing(table: str, key: str) -> Problem:
    if key:
        _, meaning, example, _ = TABLES[table][key]
        return Problem(f"{table}.{key}", "", "is missing", f"write {key} = {example} under [{table}] ({meaning})")
    return Problem(f"[{table}]", "", "is missing", f"add this table with {', '.join(TABLES[table])}")


def _meant(problem: Problem, table: str, key: str) -> bool:
    """Return whether a problem is already about the missing table or key, misspelt or given as another type."""
    home, _, name = problem.where.partition(".")
    if key:
        return home == table and not _homes(name) and close(name, TABLES[table]) == key
    # a misspelt table of a beam made of arguments is an unknown key of the beam
    return problem.where == table or close(name or home.strip("[]"), TABLES) == table


def _homes(key: str) -> list[str]:
    return [table for table, keys in TABLES.items() if key in keys]


def _name(key: str) -> str:
    return shown(key).strip('"')


def _not_toml(message: str, text: str) -> Problem:
    """Return tomllib's error in plain words, with its line."""
    match = re.search(r"\(at line (\d+), column \d+\)", message)
    if "integer string" in message:
        return Problem(reason="is not valid TOML: a number has more than 4300 digits")
    if match is None:
        return Problem(reason=f"is not valid TOML: {shown(message, limit=120).strip(chr(34))}")
    number = int(match[1])
    # only "\n" ends a line in tomllib's count
    line = text.replace("\r\n", "\n").split("\n")[number - 1].strip()
    where = f"line {number}"
    key = _name(line.split("=")[0].strip())
    if "Cannot overwrite" in message or "Duplicate" in message:
        return Problem(where, "", f"{key} is given twice", "keep one of them")
    if "Cannot declare" in message:
        return Problem(where, "", f"the table {key} is given twice", "put its keys under one heading")
    if len(line) <= _LONGEST_LINE and (unquoted := _UNQUOTED.fullmatch(line)):
        name, value = unquoted.groups()
        return Problem(f"{where}: {name}", value, "a value with a unit needs quotes", f'write {name} = "{value}"')
    if line.count('"') % 2:
        return Problem(f"{where}: {shown(line)}", "", "a quote is missing")
    reason = f"{shown(line)} is not valid TOML ({message[: match.start()].strip().lower()})"
    return Problem(where, "", reason, 'write key = value, such as length = "60 mm"')

"""The beam file (TOML): its tables and keys, reading, writing, and the words for every mistake in it."""

from __future__ import annotations

import difflib
import re
import tomllib
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, NamedTuple

from squama.errors import InputError
from squama.units import Dimension, QuantityError, as_text, shown


class Key(NamedTuple):
    """One key of the file: what it measures (None: a whole number or a file), what it means, how it may look."""

    dimension: Dimension | None
    meaning: str
    example: str


TABLES: Mapping[str, Mapping[str, Key]] = {
    "scale": {
        "length": Key(Dimension.LENGTH, "exposed length l", '"60 mm"'),
        "embedded": Key(Dimension.LENGTH, "embedded length L", '"7 mm"'),
        "width": Key(Dimension.LENGTH, "full width 2b", '"30 mm"'),
        "thickness": Key(Dimension.LENGTH, "thickness t_s", '"0.2 mm"'),
        "alpha": Key(Dimension.ANGLE, "angle between the cross-section and the scale's width", '"45 deg"'),
        "theta0": Key(Dimension.ANGLE, "inclination at rest", '"10 deg"'),
    },
    "substrate": {
        "width": Key(Dimension.LENGTH, "width", '"32 mm"'),
        "thickness": Key(Dimension.LENGTH, "full thickness 2t", '"16 mm"'),
        "youngs_modulus": Key(Dimension.PRESSURE, "E_B", '"1.5 MPa"'),
        "poisson_ratio": Key(Dimension.RATIO, "nu", "0.49"),
    },
    "beam": {
        "pitch": Key(Dimension.LENGTH, "distance d between two scales", '"20 mm"'),
        "scales": Key(None, "number N of scales; the beam is N d long", "25"),
    },
    "joint": {
        "stiffness": Key(Dimension.TORQUE, "K_theta of one scale", '"0.02 N m"'),
        "inclusion_factor": Key(Dimension.RATIO, "C_f", "1.4"),
        "matrix": Key(None, "file of the joint's stiffness in all motions, from squama joint --matrix", '"joint.csv"'),
    },
    "friction": {"mu": Key(Dimension.RATIO, "coefficient of friction", "0.25")},
}
# a value with a unit, but without the quotes that TOML wants
_UNQUOTED = re.compile(r"\s*([\w.-]+)\s*=\s*([+-]?\d[\w.+-]*\s*[^\s\d\"'#\[\]{},][^\"'#\[\]{},]*?)\s*(?:#.*)?")


def parse(text: str) -> tuple[dict[str, Any], list[str]]:
    """Turn the text of a beam file into the arguments of `Beam`, and name every key that does not belong.

    Returns
    -------
    arguments : dict
        Nested values as they stand in the file; unknown keys left out.
    problems : list of str
        One line per table or key that is not known or not a table.

    Raises
    ------
    InputError
        The text is not TOML; one line with the line number, without the file's name.
    """
    try:
        tables = tomllib.loads(text)
    except ValueError as error:
        message = _not_toml(str(error), text)
        raise InputError(message) from None
    except RecursionError:
        message = "is nested too deeply for a beam file"
        raise InputError(message) from None
    arguments: dict[str, Any] = {}
    problems: list[str] = []
    for table, content in tables.items():
        if table not in TABLES:
            problems.append(unknown_table(table, content))
        elif not isinstance(content, dict):
            problems.append(no_table(table, content))
        elif table == "beam":
            arguments |= {key: value for key, value in content.items() if key in TABLES["beam"]}
            problems += [unknown_key(table, key) for key in content if key not in TABLES["beam"]]
        else:
            arguments[table] = content
    return arguments, problems


def merge(arguments: Mapping[str, Any], overrides: Mapping[str, Mapping[str, Any]]) -> dict[str, Any]:
    """Return the arguments with values of other origin put over them, by table and key as in the file."""
    merged = dict(arguments)
    for table, content in overrides.items():
        if table == "beam":
            merged |= content
        else:
            merged[table] = {**merged.get(table, {}), **content}
    return merged


def explain(errors: Iterable[Mapping[str, Any]], root: str | None, problems: Sequence[str] = ()) -> list[str]:
    """Put pydantic's findings into one line each: where, which value, what is wrong, what to write.

    Parameters
    ----------
    errors : iterable of mapping
        As `ValidationError.errors()` gives them.
    root : str or None
        The table that was validated; None for a whole beam.
    problems : sequence of str
        Lines that were found before; a key or table that they guess to be misspelt is not called missing.

    Returns
    -------
    list of str
        All lines, `problems` first.
    """
    lines = list(problems)
    missing: list[tuple[str, str]] = []
    for error in errors:
        path = [str(part) for part in error["loc"]]
        table, key = _place(path, root)
        where = f"{table}.{key}" if key else table
        cause = error.get("ctx", {}).get("error")
        if error["type"] == "missing":
            missing.append((table, key))
        elif error["type"] == "extra_forbidden":
            lines.append(unknown_key(table, key or table, whole_beam=len(path) == 1 and root is None))
        elif isinstance(cause, QuantityError):
            lines.append(f"{where} = {cause.shown}: {cause.reason}")
        elif isinstance(cause, InputError):
            lines += str(cause).splitlines()
        elif not key:
            lines.append(no_table(table, error["input"]))
        else:
            lines.append(f"{where} = {shown(error['input'])}: {error['msg'].lower()}")
    guessed = "\n".join(lines)
    for table, key in missing:
        # a misspelt key or a table given as something else is one mistake, not two
        if key:
            known = re.search(rf"^{table}\..*did you mean {key}\?", guessed, re.MULTILINE)
        else:
            known = re.search(rf"did you mean \[?{table}\]?\?|^{table} = ", guessed, re.MULTILINE)
        if not known:
            lines.append(_missing(table, key))
    return lines


def no_table(table: str, value: object) -> str:
    """Say that a table was given as something else."""
    keys = ", ".join(TABLES.get(table, ()))
    return f"{table} = {shown(value)}: is not a table; write [{table}] and under it {keys}"


def unknown_table(table: str, content: object) -> str:
    """Say that a table (or a key outside any table) is not known, and guess which was meant."""
    tables = ", ".join(TABLES)
    if isinstance(content, dict):
        return f"[{_name(table)}]: unknown table; {_guess(table, TABLES, '[{}]')}allowed: {tables}"
    homes = [home for home, keys in TABLES.items() if table in keys]
    remedy = f"put it under {' or '.join(f'[{home}]' for home in homes)}" if homes else f"allowed tables: {tables}"
    return f"{_name(table)} = {shown(content)}: stands outside the tables; {remedy}"


def unknown_key(table: str, key: str, *, whole_beam: bool = False) -> str:
    """Say that a key of a table is not known, and guess which was meant."""
    keys = [*TABLES[table], *(name for name in TABLES if whole_beam and name != "beam")]
    homes = [home for home, others in TABLES.items() if key in others]
    remedy = f"it belongs in [{homes[0]}]; " if homes else _guess(key, keys, "{}")
    return f"{table}.{_name(key)}: unknown key; {remedy}allowed: {', '.join(keys)}"


def write(tables: Mapping[str, Mapping[str, float | str | None]]) -> str:
    """Return the text of a beam file; `parse` and `Beam` read back the very same floats.

    Parameters
    ----------
    tables : mapping
        SI values by table and key; None for a key that is not given, the text of a file for one that names a file.

    Returns
    -------
    str
        TOML, each value with its unit and its meaning as a comment.
    """
    parts = []
    for table, keys in TABLES.items():
        lines = []
        for key, (dimension, meaning, _) in keys.items():
            value = tables[table][key]
            if value is None:
                continue
            if isinstance(value, str):
                quoted = f"'''\n{value}'''"
            else:
                text = str(value) if dimension is None else as_text(value, dimension)
                quoted = text if dimension in {None, Dimension.RATIO} else f'"{text}"'
            lines.append(f"{key} = {quoted}  # {meaning}")
        if lines:
            parts.append("\n".join([f"[{table}]", *lines]))
    return "\n\n".join(parts) + "\n"


def _place(path: Sequence[str], root: str | None) -> tuple[str, str]:
    """Return table and key of a place in the model; the key is empty for a whole table."""
    if root:
        return root, path[0] if path else ""
    if not path:
        return "beam", ""
    if path[0] in TABLES and path[0] != "beam":
        return path[0], path[1] if len(path) > 1 else ""
    return "beam", path[0]


def _missing(table: str, key: str) -> str:
    if key:
        _, meaning, example = TABLES[table][key]
        return f"{table}.{key}: is missing; write {key} = {example} under [{table}] ({meaning})"
    return f"[{table}]: is missing; add this table with {', '.join(TABLES[table])}"


def _guess(name: str, known: Iterable[str], form: str) -> str:
    close = difflib.get_close_matches(name.lower(), list(known), n=1)
    return f"did you mean {form.format(close[0])}? " if close else ""


def _name(key: str) -> str:
    return shown(key).strip('"')


def _not_toml(message: str, text: str) -> str:
    """Say in plain words what tomllib found, with the line it stands in."""
    match = re.search(r"\(at line (\d+), column \d+\)", message)
    if match is None:
        return f"is not valid TOML: {shown(message, limit=120).strip(chr(34))}"
    number = int(match[1])
    # only "\n" ends a line in tomllib's count
    line = text.replace("\r\n", "\n").split("\n")[number - 1].strip()
    where = f"line {number}"
    key = _name(line.split("=")[0].strip())
    if "Cannot overwrite" in message or "Duplicate" in message:
        return f"{where}: {key} is given twice; keep one of them"
    if "Cannot declare" in message:
        return f"{where}: the table {key} is given twice; put its keys under one heading"
    if unquoted := _UNQUOTED.fullmatch(line):
        name, value = unquoted.groups()
        return f'{where}: {name} = {value}: a value with a unit needs quotes; write {name} = "{value}"'
    if line.count('"') % 2:
        return f"{where}: {shown(line)}: a quote is missing"
    reason = message[: match.start()].strip().lower()
    return f'{where}: {shown(line)} is not valid TOML ({reason}); write key = value, such as length = "60 mm"'

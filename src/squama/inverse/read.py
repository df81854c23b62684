"""Values of a target file: quantities with their units, twists over a length, a pitch or the beam, stiffnesses."""

from __future__ import annotations

import difflib
import math
import re
from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

from squama import units
from squama.errors import InputError
from squama.inverse.wants import At
from squama.units import Dimension, QuantityError, shown

_NUMBER = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(.*?)\s*", re.DOTALL | re.ASCII)
_SENSE = re.compile(r"\s*(at least|at most|>=|<=)\s+(.*)", re.DOTALL | re.IGNORECASE)
_RIGIDITIES = {"N m^2": 1.0, "N cm^2": 1e-4, "N mm^2": 1e-6, "kN m^2": 1e3, "mN m^2": 1e-3}


class Read(NamedTuple):
    """A value that was read: SI, number and unit as given, and the sense "=", ">=" or "<="."""

    si: float
    number: float
    unit: str
    sense: str = "="


class Context(NamedTuple):
    """What reading depends on: number of scales, kind of loading, whether bare numbers are SI."""

    scales: int
    load: str
    bare: bool


def sense_of(value: object) -> tuple[str, object]:
    """Split "at least 5 mm" into ">=" and the rest."""
    if isinstance(value, str) and (match := _SENSE.fullmatch(value)):
        return {"at least": ">=", ">=": ">=", "at most": "<=", "<=": "<="}[match[1].lower()], match[2]
    return "=", value


def quantity(where: str, value: object, dimension: Dimension, context: Context, unit: str, allowed: str = "") -> Read:
    """Read a positive quantity; ``unit`` is the SI unit of a bare number, ``allowed`` says what else bounds it."""
    sense, rest = sense_of(value)
    try:
        si = units.quantity(rest, dimension, bare=context.bare)
    except QuantityError as error:
        raise _bad(where, error) from None
    if si <= 0:
        refuse(where, rest, f"must be more than 0{allowed}; write e.g. {units.example(dimension)}")
    return Read(si, *_split(rest, unit), sense)


def rigidity(where: str, value: object, context: Context) -> Read:
    """Read a torsional (bending) stiffness of the beam, N m^2."""
    sense, rest = sense_of(value)
    example = 'write e.g. "0.5 N m^2"'
    if isinstance(rest, str):
        number, unit = _split(rest, "")
        key = re.sub(r"\s*[*·⋅]\s*|\s+", " ", unit.replace("²", "^2")).removesuffix("/rad")
        key = re.sub(r"m2$", "m^2", re.sub(r"^(k|m)?N(?=[a-z]+\^?2)", r"\1N ", key))
        if not math.isfinite(number) or key not in _RIGIDITIES:
            what = (
                "has no unit"
                if math.isfinite(number) and not unit
                else "is not a stiffness of a beam, torque per twist rate"
            )
            refuse(where, rest, f"{what}; {example}")
        si = number * _RIGIDITIES[key]
    elif isinstance(rest, bool) or not isinstance(rest, int | float) or not math.isfinite(rest) or not context.bare:
        what = (
            "has no unit"
            if isinstance(rest, int | float) and not isinstance(rest, bool)
            else "is not a stiffness of a beam"
        )
        refuse(where, rest, f"{what}; {example}")
    else:
        si, number, unit = float(rest), float(rest), "N m^2"
    if si <= 0:
        refuse(where, rest, f"must be more than 0; {example}")
    return Read(si, number, unit, sense)


def twist(where: str, value: object, context: Context) -> tuple[At, Read]:
    """Read a twist (curvature): a rate, or an angle per pitch or over the beam, which then hold for every pitch."""
    sense, rest = sense_of(value)
    read = units.twist if context.load == "twisting" else units.curvature
    try:
        rate, other = (read(rest, pitch=p, scales=context.scales, bare=context.bare) for p in (1.0, 2.0))
    except QuantityError as error:
        raise _bad(where, error) from None
    if rate <= 0:
        turn = '; for the other way round write sense = "-"' if context.load == "twisting" else ""
        refuse(where, rest, f'must be more than 0{turn}; write e.g. "0.2 rad/pitch"')
    at = At(rate, 0.0) if rate == other else At(0.0, rate)
    if at.angle >= math.pi:
        most = f"{180 * context.scales:g} deg total"
        refuse(where, rest, f'is half a turn per pitch or more, beyond the model; write less than "{most}"')
    return at, Read(rate, *_split(rest, "rad/m"), sense)


def refuse(where: str, value: object, problem: str) -> None:
    """Refuse a value of the file."""
    message = f"{where} = {shown(value)}: {problem}"
    raise InputError(message)


def guess(name: str, known: Iterable[str]) -> str:
    """Return which name was meant, as the beginning of a remedy."""
    close = difflib.get_close_matches(name.lower(), list(known), n=1)
    return f"did you mean {close[0]}? " if close else ""


def flattened(table: Mapping[str, Any], prefix: str = "") -> dict[str, Any]:
    """Return ``{"scale.length": ...}`` of nested tables."""
    found: dict[str, Any] = {}
    for key, value in table.items():
        name = f"{prefix}{key}"
        if isinstance(value, Mapping):
            found |= flattened(value, f"{name}.")
        else:
            found[name] = value
    return found


def _split(value: object, unit: str) -> tuple[float, str]:
    """Return number and unit as given."""
    if isinstance(value, str) and (match := _NUMBER.fullmatch(value)):
        return float(match[1]), match[2]
    return (float(value), unit) if isinstance(value, int | float) else (math.nan, "")


def _bad(where: str, error: QuantityError) -> InputError:
    return InputError(f"{where} = {error.shown}: {error.reason}")

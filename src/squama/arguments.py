"""Checks of the arguments of array functions: each returns the checked value, or raises an error of one clear line."""

from __future__ import annotations

import os
from collections.abc import Iterable, Sequence
from datetime import date, timedelta
from typing import TYPE_CHECKING, TypeVar, cast, get_args

import numpy as np
from numpy.typing import ArrayLike

from squama import loads
from squama.errors import naming, refuse
from squama.loads import LOADS, LawName, Load, SenseName
from squama.model import reach
from squama.model.laws import LAWS
from squama.people import per_pitch
from squama.types import Array
from squama.units import MARGIN, shown

if TYPE_CHECKING:
    from squama.beam.design import Beam

_Word = TypeVar("_Word", bound=str)
EXAMPLES = {
    "eta": "3",
    "beta": "1.25",
    "lam": "0.45",
    "mu": "0.25",
    "margin": "0.01",
    "stiffness_ratio": "1",
    "alpha": "np.radians(45)",
    "theta0": "np.radians(10)",
    "theta": "np.radians(20)",
    "nu": "0.49",
    "scale_nu": "0.35",
    "zeta": "0.3",
    "width": "1.5",
    "modulus_ratio": "2000",
    "thickness": "0.02",
    "points": "200",
    "at": "5",
    "scales": "25",
    "neighbour": "1",
}
"""Example values for the remedy of a message, by the name of the argument."""
LEAST = 1e-6
"""Smallest load angle per pitch (rad) that counts as a motion, and smallest difference between two load angles; less
comes near to rounding errors.
"""
_KINDS: dict[tuple[type, ...], str] = {
    (bool, np.bool_): "a truth value",
    (complex, np.complexfloating): "a complex number",
    (str, bytes): "a text",
    (date, np.datetime64): "a date",
    (timedelta, np.timedelta64): "a span of time",
}
"""Types that NumPy converts to numbers but that are refused here, with their names in messages."""


def beam(value: object) -> None:
    """Refuse an object that is not a beam, such as the path of a beam file.

    A beam is recognised by its attributes, because this module cannot import its class.
    """
    if all(hasattr(value, part) for part in ("substrate", "pitch", "scales")):
        return
    if isinstance(value, str | os.PathLike):
        path = shown(os.fspath(value))
        refuse("beam", path, "is a text, not a beam", f"for a beam file write squama.Beam.from_toml({path})")
    remedy = 'give a squama.Beam, e.g. squama.Beam.from_toml("beam.toml")'
    refuse("beam", "", f"is of type {type(value).__name__}, not a beam", remedy)


def result(value: object) -> None:
    """Refuse the path of a file, or a beam, where a result is expected."""
    remedy = 'give what e.g. squama.twist returns, or squama.read("twist.nc")'
    if isinstance(value, str | os.PathLike):
        refuse("", shown(os.fspath(value)), "is a text, not a result", remedy)
    if hasattr(value, "substrate"):
        refuse("", "", "a beam is not a result", remedy)


def held_by(beam: Beam, hold: str | None) -> Beam:
    """Return the beam with ``hold`` in place of its own held strains, or the beam itself where ``hold`` is None."""
    if hold is None:
        return beam
    with naming("hold"):
        loads.hold(hold)
    return beam.replace(hold=hold)


def _kind(value: object) -> str:
    """Return the name in :data:`_KINDS` of a value, or an element of it, that is no number; "" if all are numbers."""
    inside: list[object] = []
    if isinstance(value, list | tuple):
        types, inside = set(map(type, value)), [v for v in value if isinstance(v, list | tuple | np.ndarray)]
    else:
        array = value if isinstance(value, np.ndarray) else np.asarray(value)
        types = set(map(type, array.ravel().tolist())) if array.dtype.kind == "O" else {array.dtype.type}
    words = (words for kinds, words in _KINDS.items() if any(issubclass(t, kinds) for t in types))
    return next(filter(None, (*words, *map(_kind, inside))), "")


def numbers(name: str, value: ArrayLike, *, endless: bool = False) -> Array:
    """Return a value as an array of finite floats; with ``endless`` infinity is allowed too."""
    try:
        kind = _kind(value)
        array = np.asarray([] if kind else value, dtype=float)
    except (TypeError, ValueError, OverflowError):
        refuse(name, shown(value), "give a number or an array of numbers")
    if kind:
        refuse(name, shown(value), f"is {kind}", "give a number or an array of numbers")
    _refuse(name, array, ~np.isfinite(array) & ~(endless & np.isposinf(array)), "a finite number")
    return array


def _refuse(name: str, array: Array, bad: Array, allowed: str, remedy: str = "") -> None:
    if np.any(bad):
        first = float(np.ravel(array)[np.flatnonzero(np.ravel(bad))[0]])
        count = int(np.count_nonzero(bad))
        more = f" (and {count - 1} more)" if count > 1 else ""
        remedy = remedy or (f"write e.g. {EXAMPLES[name]}" if name in EXAMPLES else "")
        refuse(name, f"{first:.6g}{more}", f"must be {allowed}", remedy)


def positive(name: str, value: ArrayLike, *, endless: bool = False) -> Array:
    """Return a value as an array of floats above 0; with ``endless`` infinity is allowed too."""
    array = numbers(name, value, endless=endless)
    _refuse(name, array, array <= 0, "above 0")
    return array


def not_negative(name: str, value: ArrayLike) -> Array:
    """Return a value as an array of floats of 0 or more."""
    array = numbers(name, value)
    _refuse(name, array, array < 0, "0 or more")
    return array


def between(name: str, value: ArrayLike, low: float, high: float, *, closed: bool = False) -> Array:
    """Return angles (rad) between the bounds, exclusive; with ``closed`` the lower bound is allowed too."""
    array = numbers(name, value)
    top = np.degrees(high)
    allowed = f"an angle in radians between {low:g} and {high:.6g} ({top:g} deg), exclusive"
    if closed:
        allowed = f"an angle in radians from {low:g} to below {high:.6g} ({top:g} deg)"
    first = np.max(np.abs(array), initial=0.0)
    hint = f"for degrees write np.radians({first:g})" if first >= high else ""
    _refuse(name, array, ((array < low) if closed else (array <= low)) | (array >= high), allowed, hint)
    return array


def together(columns: dict[str, Array]) -> tuple[Array, ...]:
    """Return the arrays, broadcast to one shape."""
    try:
        return np.broadcast_arrays(*columns.values())
    except ValueError:
        shapes = ", ".join(f"{name} {v.shape}" for name, v in columns.items())
        refuse("", "", f"shapes do not fit each other: {shapes}", "give shapes that broadcast")


PLANE = {"beta": 1.0, "lam": 0.0, "alpha": 0.0}
"""Values in bending of arguments that are left out: scales across the beam, on the line that keeps its length."""


def designs(load: str = "twisting", /, **columns: ArrayLike | None) -> tuple[list[Array], tuple[int, ...]]:
    """Check the columns of many designs; return them flattened to one length, and their broadcast shape.

    In bending ``lam`` is the height of the face over the line that keeps its length, in pitches, and may be 0
    (:meth:`squama.loads.Load.height`).
    """
    given = []
    for name, told in columns.items():
        value = PLANE.get(name) if told is None and not LOADS[load].sided else told
        if value is None:
            refuse(name, "", "is missing", "give it")
        if name in ("alpha", "theta0"):
            # scales may lie across the beam, but not flat on it
            given.append(between(name, value, 0.0, np.pi / 2, closed=name == "alpha"))
        elif name in ("psi", "phi"):
            given.append(between(name, value, -np.pi, np.pi))
        elif name in ("dpsi", "dphi", "neutral_height"):
            given.append(numbers(name, value))
        elif name in ("mu", "stiffness_ratio", "thickness") or (name == "lam" and not LOADS[load].sided):
            given.append(not_negative(name, value))
            if name == "thickness":
                _refuse(name, given[-1], given[-1] > reach.MOST, f"0 to {reach.MOST:g}")
        elif name in ("eta", "beta"):
            # beyond that, neighbours without end are within reach
            given.append(numbers(name, value))
            _refuse(name, given[-1], (given[-1] <= 0) | (given[-1] > reach.MOST), reach.ALLOWED)
        else:
            given.append(positive(name, value, endless=name == "modulus_ratio"))
            if name in ("nu", "scale_nu"):
                _refuse(name, given[-1], given[-1] >= 0.5, "above 0 and below 0.5")
    cols = together(dict(zip(columns, given, strict=True)))
    return [np.ascontiguousarray(c, float).ravel() for c in cols], cols[0].shape


def one_of(name: str, value: str, allowed: Sequence[_Word]) -> _Word:
    """Return the value if it is an allowed word; refuse others."""
    if not isinstance(value, str) or value not in allowed:
        refuse(name, shown(value), f"must be {' or '.join(map(shown, allowed))}")
    return allowed[allowed.index(value)]


def several(name: str, value: str | Sequence[str], allowed: tuple[_Word, ...]) -> tuple[_Word, ...]:
    """Return the given words without repeats, in the order of the allowed ones."""
    found = words(name, value, allowed)
    return tuple(word for word in allowed if word in found)


def words(name: str, value: str | Sequence[str], allowed: tuple[_Word, ...]) -> tuple[_Word, ...]:
    """Return the given words in their given order; refuse words that are not allowed."""
    if not isinstance(value, str | Iterable):
        refuse(name, shown(value), "is no word and no list of words", f"write e.g. {allowed[0]}")
    found = tuple(one_of(name, word, allowed) for word in ([value] if isinstance(value, str) else value))
    if not found:
        refuse(name, "", "is empty", f"write e.g. {allowed[0]}")
    return found


def law(value: str) -> LawName:
    """Return the name of a force law, "edge" or "plate"; refuse others."""
    return cast("LawName", one_of("law", value, tuple(LAWS)))


def load(value: str) -> Load:
    """Return the :class:`Load` of a name, "twisting" or "bending"; refuse others."""
    return LOADS[one_of("load", value, tuple(LOADS))]


def thin(thickness: Array, law: str, load: str = "twisting") -> None:
    """Refuse a thickness above 0 where the model has thin scales: with the paper's force law, and in bending."""
    where = "in bending" if not LOADS[load].sided else 'with law="plate"' if law == "plate" else ""
    if where:
        remedy = "leave thickness out" if "bending" in where else 'leave thickness out, or take law="edge"'
        _refuse("thickness", thickness, thickness > 0, f"0 {where}, where the scales are thin", remedy)


def joint(value: str) -> str:
    """Return the name of a kind of joint, "hinge" or "compliant"; refuse others."""
    return one_of("joint", value, tuple(loads.HELD))


def held(kind: str | None, ideal: bool | None) -> None:
    """Refuse an unknown kind of joint, and an ``ideal`` that is not a truth value; None stands for the default."""
    if kind is not None:
        joint(kind)
    if ideal is not None and not isinstance(ideal, bool | np.bool_):
        refuse("ideal", shown(ideal), "must be True or False")


def sense(value: str) -> int:
    """Return +1 for "+", -1 for "-"."""
    return 1 if one_of("sense", value, get_args(SenseName)) == "+" else -1


def whole(name: str, value: ArrayLike, low: float, high: float) -> int:
    """Return a whole number between ``low`` and ``high``, inclusive."""
    allowed = f"a whole number from {low:g} to {high:g}"
    number = np.asarray(scalar(name, value, low, high + 1, allowed))
    _refuse(name, number, number != np.floor(number), allowed)
    return int(number)


def scalar(name: str, value: ArrayLike, low: float, high: float, allowed: str) -> float:
    """Return a single number with low <= value < high."""
    array = numbers(name, value)
    if array.ndim:
        refuse(name, "", f"must be one number, not an array of shape {array.shape}")
    _refuse(name, array, (array < low) | (array >= high), allowed)
    return float(array)


def margin(value: ArrayLike) -> float:
    """Return the cut-off before a lock, as a fraction of the path."""
    return scalar("margin", value, MARGIN.low, 1.0, MARGIN.allowed)


def frictions(own: float | None, given: ArrayLike | None, how: str = "pass mu=0.3") -> Array:
    """Return coefficients of friction (n,) or (): those given, else the beam's; ``how`` is the message's remedy."""
    if given is None and own is None:
        refuse("mu", "", "is not given", f"{how}, or write mu under [friction] in the beam's file")
    mus = not_negative("mu", own if given is None else given)  # type: ignore[arg-type]
    if mus.ndim > 1 or mus.size == 0:
        refuse("mu", "", f"must be one number or a sequence of numbers, not an array of shape {mus.shape}")
    return mus


def friction(own: float | None, given: ArrayLike | None, how: str = "pass mu=0.3") -> float:
    """Return one coefficient of friction: the given one, else the beam's; see :func:`frictions`."""
    return scalar("mu", frictions(own, given, how), 0.0, np.inf, "0 or more")


def moves(name: str, angle: float) -> float:
    """Return a load angle per pitch (rad); refuse one below :data:`LEAST`, which is no motion."""
    if abs(angle) < LEAST:
        value, why = (per_pitch(angle), f"is below {per_pitch(LEAST)}: ") if angle else ("0", "")
        refuse(name, value, f"{why}nothing moves", 'write e.g. "5 deg/pitch"')
    return angle

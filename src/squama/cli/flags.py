"""The flags of the commands: typed; flags of several commands are defined here; all mistakes are reported at once.

A flag is read while the command line is parsed. A mistake is collected, so that the command goes on to check its other
flags and its files; :func:`settled` then raises all mistakes, a line each.
"""

from __future__ import annotations

import logging
import math
import os
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Generic, NamedTuple, TypeVar, dataclass_transform, get_type_hints

from cyclopts import Parameter

from squama.beam import beamfile
from squama.errors import InputError, Problems, naming, refuse
from squama.io.files import label, table_place
from squama.loads import ENDS, LINES, LOADS, MODES, EndsName
from squama.progress import LOG
from squama.units import MARGIN, Bounds, Dimension, bounded, shown

if TYPE_CHECKING:
    from cyclopts import Token

    from squama.beam.design import Beam

PLOTS = (".png", ".svg", ".pdf")
T = TypeVar("T")
_Word = TypeVar("_Word", bound=str)


# ---- mistakes ---------------------------------------------------------------------------------------------


class Mistakes(Problems):
    """Mistakes of a command line, and the names of flags that could not be read, whose values are not missing."""

    def __init__(self) -> None:
        super().__init__()
        self.flags: set[str] = set()


_FOUND: ContextVar[Mistakes] = ContextVar("mistakes")


@contextmanager
def collecting() -> Iterator[None]:
    """Start a command line with its own list of mistakes."""
    token = _FOUND.set(Mistakes())
    try:
        yield
    finally:
        _FOUND.reset(token)


def problems() -> Mistakes:
    """Return the mistakes of this command line so far."""
    return _FOUND.get()


def settled(value: T | None) -> T:
    """Return the value, or raise all mistakes found so far."""
    problems().settle()
    assert value is not None
    return value


@contextmanager
def laid(names: Mapping[str, str]) -> Iterator[None]:
    """Attribute mistakes found inside to flags, by the names of their places."""
    try:
        yield
    except InputError as error:
        raise error.renamed(names) from None


# ---- how a flag is read -----------------------------------------------------------------------------------


class Reader(NamedTuple, Generic[T]):
    """Reads a value from the name and text of a flag; ``failed`` replaces a value that could not be read."""

    read: Callable[[str, str], T]
    failed: T


def flag(words: str, *names: str, read: Reader[T] | None = None, many: bool = False) -> Parameter:
    """Return a flag with its help, other names and reader (default: the text); ``many``: repeated, a tuple."""
    plain = Parameter(name=names or None, help=words, allow_leading_hyphen=True)
    if read is None:
        return plain

    def convert(_: object, tokens: Sequence[Token]) -> object:
        found = []
        for token in tokens:
            name = token.keyword or ""
            with problems().caught():
                if len(tokens) > 1 and not many:
                    refuse(name, "", f"is given {len(tokens)} times", "give it once")
                found.append(read.read(name, token.value))
                continue
            problems().flags.add(name)
        return tuple(found) if many else found[0] if found else read.failed

    return Parameter.combine(plain, Parameter(converter=convert, n_tokens=1, accepts_keys=False))


def within(bounds: Bounds) -> Reader[float]:
    """Return a reader of plain numbers within bounds."""

    def read(name: str, text: str) -> float:
        with naming(name):
            return bounded(text, Dimension.RATIO, bounds)

    return Reader(read, bounds.low)


def number(low: float, high: float, example: str, allowed: str = "") -> Reader[float]:
    """Return a reader of plain numbers within inclusive bounds."""
    return within(Bounds(low, high, allowed or f"{low:.12g} to {high:.12g}", closed=True, example=example))


def whole(low: int, high: int, example: str) -> Reader[int]:
    """Return a reader of whole numbers within inclusive bounds."""
    inside, endless = number(low, high, example), number(-math.inf, math.inf, example)

    def read(name: str, text: str) -> int:
        if not endless.read(name, text).is_integer():
            refuse(name, text, "is not a whole number", f"allowed: {low} to {high}; write e.g. {example}")
        return int(inside.read(name, text))

    return Reader(read, low)


def one_of(*allowed: _Word) -> Reader[_Word]:
    """Return a reader of one of several words."""

    def read(name: str, text: str) -> _Word:
        if text not in allowed:
            refuse(name, shown(text), f"must be {' or '.join(shown(word) for word in allowed)}")
        return allowed[allowed.index(text)]

    return Reader(read, allowed[0])


def words_of(allowed: tuple[_Word, ...]) -> Reader[tuple[_Word, ...]]:
    """Return a reader of some of the words, separated by commas."""

    def read(name: str, text: str) -> tuple[_Word, ...]:
        from squama import arguments

        return arguments.several(name, [word.strip() for word in text.split(",")], allowed)

    return Reader(read, allowed)


class Pair(NamedTuple):
    """Name and text before and after an equals sign."""

    name: str
    text: str


def pair(form: str, example: str) -> Reader[Pair]:
    """Return a reader of name=text."""

    def read(name: str, text: str) -> Pair:
        left, equals, right = text.partition("=")
        found = Pair(left.strip(), right.strip().strip('"').strip())
        if not (equals and all(found)):
            refuse(f"{name} {shown(text)}", "", f"is not {form}", f"write e.g. {example}")
        return found

    return Reader(read, Pair("", ""))


def once(name: str, pairs: Iterable[Pair], aliases: Mapping[str, str] | None = None) -> dict[str, str]:
    """Return pairs as a mapping; a repeated name, also by an alias, is collected as a mistake of the flag."""
    found, same = dict[str, str](), aliases or {}
    for key, text in pairs:
        if same.get(key, key) in (same.get(other, other) for other in found):
            problems().add(f"{name} {key}", "", "is given twice", "keep one of them")
        else:
            found[key] = text
    return found


class Setting(NamedTuple):
    """A value of --set, or of another flag that replaces a value of the file."""

    place: str
    value: int | str
    flag: str = "--set"

    @property
    def name(self) -> str:
        """The flag and the replaced key, as written."""
        return f"{self.flag} {self.place}" if self.flag == "--set" else self.flag


def _setting(name: str, text: str) -> Setting:
    place, equals, right = text.partition("=")
    table, dot, key = place.strip().partition(".")
    value = right.strip().strip('"')
    where, known = f"{name} {shown(text)}", beamfile.TABLES
    if not (equals and dot and value):
        refuse(where, "", "is not table.key=value", 'write e.g. scale.alpha="30 deg"')
    if key not in known.get(table, ()):
        wrong = beamfile.unknown_key(table, key) if table in known else beamfile.unknown_table(table, {})
        raise InputError(wrong.at(where))
    digits = value.lstrip("+-").isdecimal() and len(value) < 20
    return Setting(place.strip(), int(value) if digits else value)


def several(one: Reader[T]) -> Reader[tuple[T, ...]]:
    """Return a reader of values separated by commas."""
    return Reader(lambda name, text: tuple(one.read(name, part) for part in text.split(",")), ())


_mu = number(0.0, 10.0, "0.25")


def _family(name: str, text: str) -> tuple[float, ...]:
    values = several(_mu).read(name, text)
    kept = {f"{mu:g}": values.count(mu) for mu in values}
    if twice := [mu for mu, count in kept.items() if count > 1]:
        refuse(name, text, f"{' and '.join(twice)} is given twice", f"write {name} {','.join(kept)}")
    return values


def rate(name: str, text: str, beam: Beam, load: str = "twisting", *, still: bool = False) -> float:
    """Return the twist rate or curvature of a flag, rad/m; 0 is allowed only with ``still``."""
    kind = LOADS[load]
    with naming(name):
        found = kind.read(text, pitch=beam.pitch, scales=beam.pitches, bare=False)
    if found < 0 or (found == 0 and not still):
        least = "0 or more" if still else "more than 0"
        refuse(name, shown(text), f"must be {least}{kind.other_way('--sense -')}", 'write e.g. "0.2 rad/pitch"')
    return found


def asked(
    name: str, text: str | None, beam: Beam | None, load: str = "twisting", *, still: bool = False
) -> float | None:
    """Return the twist rate or curvature of a flag, None where it or the beam is missing; mistakes are collected."""
    with problems().caught():
        return None if text is None or beam is None else rate(name, text, beam, load, still=still)
    return None


@dataclass_transform(frozen_default=True, kw_only_default=True)
def group(flags: type[T]) -> type[T]:
    """Return a class of flags as a frozen dataclass, whose flags join those of the command."""
    made = dataclass(frozen=True, kw_only=True)(flags)
    # a group may be extended in another module, where the names of these types are unknown
    vars(made)["__init__"].__annotations__ = get_type_hints(made, include_extras=True)
    return Parameter(name="*")(made)


# ---- flags of several commands ---------------------------------------------------------------------

TWISTS = '"5 rad/m", "0.2 rad/pitch" or "90 deg total"'
"""Examples of twists, for help texts."""
AT = f"Twist for which compliant joints give their figures: {TWISTS}. Default: twice that at engagement."
if TYPE_CHECKING:
    File = str
else:
    # for shells a path, which they complete; for the program the text as written
    File = Annotated[Path, Parameter(converter=lambda _, tokens: tokens[0].value)]
BeamFile = Annotated[File, Parameter(help="Beam file (TOML), or - for standard input; squama new writes one.")]
Mu = Annotated[float | None, flag("Coefficient of friction, e.g. 0.25. Default: the beam file's.", read=_mu)]
_MUS = "Coefficient of friction, e.g. 0.25, or several: 0,0.2,0.5. Default: the file's."
Family = Annotated[tuple[float, ...], flag(_MUS, read=Reader(_family, ()))]
_LOAD = "Load: twisting or bending (twists are then bends). Default: twisting."
Load = Annotated[str, flag(_LOAD, read=one_of(*LOADS))]
_LAW = "Force law: edge (satisfies virtual work) or plate (of the paper). Default: edge."
Law = Annotated[str, flag(_LAW, read=one_of("edge", "plate"))]
_NEUTRAL = "Line of the bar that keeps its length: free (no axial force), middle, face (hinges). Default: the file's."
Neutral = Annotated[str | None, flag(_NEUTRAL, read=one_of(*LINES))]
_MODE = "Mode: uniform; in bending also simply supported or cantilever (the first mode). Default: uniform."
Mode = Annotated[str, flag(_MODE, read=one_of(*MODES))]
Sense = Annotated[str, flag("Sense of the twist: + or -. Default: +.", read=one_of("+", "-"))]
_HELD = "Joint of a scale: compliant (six motions) or hinge. Default: compliant; hinge with the plate law."
Joint = Annotated[str | None, flag(_HELD, read=one_of("hinge", "compliant"))]
_IDEAL = "Thin, rigid scales. Default: thick and elastic as in the beam file; on hinges thin."
Ideal = Annotated[bool | None, Parameter(help=_IDEAL)]
_CUT = "Share of the path before a lock that is left out of the curve. Default: 0.01."
Margin = Annotated[float, flag(_CUT, read=within(MARGIN))]
Json = Annotated[bool, Parameter(help="Print all results as JSON instead of the summary.")]
Full = Annotated[bool, Parameter(help="Print all figures after the summary.")]
Quiet = Annotated[bool, Parameter(help="Print no progress.")]
_ENDS = "Ends: free, couple, gripped, equal (pitches alike), endless. Default: the file's, or free."
Ends = Annotated[EndsName | None, flag(_ENDS, read=one_of(*ENDS))]
Plot = Annotated[tuple[File, ...], flag("Picture to write (.png, .svg, .pdf); may be repeated.")]


def arguments(*others: str, **named: str) -> dict[str, str]:
    """Return the flags of arguments, and other places, for the attribution of mistakes."""
    names = ("law", "load", "joint", "sense", "margin", "mu", "points", "to", *others)
    return {name: f"--{name}" for name in names} | named


def points(default: int) -> Parameter:
    """Return the flag --points of a command."""
    return flag(f"Number of points of the curve. Default: {default}.", read=whole(3, 100_000, str(default)))


def scales(most: int, words: str, least: int = 2) -> Parameter:
    """Return the flag --scales of a command."""
    return flag(f"{words} {least} to {most}.", read=whole(least, most, "25"))


@group
class How:
    """Load of a beam, and the model of its joints and scales."""

    load: Load = "twisting"
    law: Law = "edge"
    joint: Joint = None
    ideal: Ideal = None


@group
class Joints:
    """Model of joints and scales, and the line of the bar that keeps its length."""

    joint: Joint = None
    ideal: Ideal = None
    neutral: Neutral = None


HOW, JOINTS = How(), Joints()
_SET = 'Value in place of the beam file\'s, e.g. scale.alpha="30 deg"; may be repeated.'


@group
class Base:
    """Flags of every command that reads a beam."""

    set_: Annotated[tuple[Setting, ...], flag(_SET, "--set", read=Reader(_setting, Setting("", "")), many=True)] = ()
    json: Json = False
    verbose: Annotated[bool, Parameter(help="Print steps and their times on standard error.")] = False

    def __post_init__(self) -> None:
        """Switch on the log as soon as the command line is read."""
        if self.verbose:
            LOG.setLevel(logging.INFO)

    @property
    def settings(self) -> Sequence[Setting]:
        """Values that replace those of the file; --hold is one of them where the command has it."""
        hold = getattr(self, "hold", None)
        return self.set_ if hold is None else (*self.set_, Setting("beam.hold", hold, "--hold"))

    def overrides(self, mu: float | None = None) -> dict[str, dict[str, object]]:
        """Return the replacing values by table and key; a value given twice is refused."""
        found: dict[str, dict[str, object]] = {} if mu is None else {"friction": {"mu": mu}}
        for one in self.settings:
            name, _, key = one.place.partition(".")
            table = found.setdefault(name, {})
            if key in table:
                refuse(one.name, "", "is given twice, or by a flag of its own, too", "keep one of them")
            table[key] = one.value
        return found

    def beam(
        self, path: str, mu: float | None = None, *, scales: int | None = None, friction: bool = True
    ) -> Beam | None:
        """Read the beam, with ``mu`` and ``scales`` for the file's, ``friction`` required; mistakes are collected."""
        from squama.beam.design import Beam

        with problems().caught(), laid({s.place: s.name for s in self.settings}):
            found = Beam.from_toml(path, overrides=self.overrides(mu))
            if friction:
                check_friction(path, found)
            return found if scales is None else found.replace(scales=scales)
        return None


_HOLD = "Strains of the bar that are held: bend, twist, lateral bend, stretch; or straight (all). Default: the file's."


@group
class Common(Base):
    """Flags of every command that computes a dataset of a beam."""

    plot: Plot = ()
    csv: Annotated[File | None, flag("CSV file to write, with units in its header; - prints it alone.")] = None
    netcdf: Annotated[File | None, flag("netCDF file (.nc) to write, with all results.")] = None
    hold: Annotated[str | None, flag(_HOLD)] = None

    def check(self, *inputs: str, plots: Iterable[str] = ()) -> None:
        """Check every output path, other pictures included, before any work."""
        pictures = ((path, PLOTS) for path in (*self.plot, *plots))
        table = table_place(problems(), "--csv", self.csv, as_json=self.json)
        check_places([*pictures, (table, (".csv",)), (self.netcdf, (".nc",))], inputs)


BASE, COMMON = Base(), Common()


def check_places(wanted: Iterable[tuple[str | None, tuple[str, ...]]], inputs: Iterable[str] = ()) -> None:
    """Check paths to be written, each with its allowed extensions; mistakes are collected."""
    from squama.io.datasets import check_place

    seen = {os.path.realpath(path): "is read too" for path in inputs}
    for path, allowed in wanted:
        if path is not None:
            with problems().caught():
                check_place(path, allowed)
                place = os.path.realpath(path)
                if place in seen:
                    refuse(label(path), "", seen[place], "give the output another name")
                seen[place] = "is given twice"


def check_friction(path: str, beam: Beam) -> None:
    """Collect a missing coefficient of friction as a mistake."""
    if beam.friction.mu is None and "--mu" not in problems().flags:
        remedy = "write mu = 0.25 under [friction] or give --mu 0.25"
        problems().add("friction.mu", "", "is missing", remedy, source=label(path))

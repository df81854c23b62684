"""The flags of the commands: typed; those of several commands stand here once; all mistakes are told at once.

A flag is read as the command line is taken apart. What cannot be read is kept as a mistake, so that the command goes on
to look at its other flags and its files; :func:`settled` then refuses them all, a line each.
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
    """Mistakes of a command line, and its flags that could not be read: what they would have said is not missing."""

    def __init__(self) -> None:
        super().__init__()
        self.flags: set[str] = set()


_FOUND: ContextVar[Mistakes] = ContextVar("mistakes")


@contextmanager
def collecting() -> Iterator[None]:
    """Start a command line: what is found inside is kept apart from that of any other."""
    token = _FOUND.set(Mistakes())
    try:
        yield
    finally:
        _FOUND.reset(token)


def problems() -> Mistakes:
    """Return the mistakes of this command line so far."""
    return _FOUND.get()


def settled(value: T | None) -> T:
    """Return what was read, or raise every mistake that was found."""
    problems().settle()
    assert value is not None
    return value


@contextmanager
def laid(names: Mapping[str, str]) -> Iterator[None]:
    """Lay the mistakes found inside to flags, by the names of their places."""
    try:
        yield
    except InputError as error:
        raise error.renamed(names) from None


# ---- how a flag is read -----------------------------------------------------------------------------------


@dataclass(frozen=True)
class Reader(Generic[T]):
    """Makes a value of the name and the text of a flag; ``failed`` stands for a value that could not be read."""

    read: Callable[[str, str], T]
    failed: T

    def __call__(self, name: str, text: str) -> T:
        """Read a text, or raise InputError."""
        return self.read(name, text)


def flag(words: str, *names: str, read: Reader[T] | None = None, many: bool = False) -> Parameter:
    """Return a flag whose value may begin with a minus sign.

    ``words`` are its help, ``names`` its names if they are not the argument's; ``read`` makes the value, without one it
    is the text; of a flag that may be repeated (``many``) the value is a tuple.
    """
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
                found.append(read(name, token.value))
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
    """Return a reader of plain numbers within bounds, both of which belong to it."""
    return within(Bounds(low, high, allowed or f"{low:.12g} to {high:.12g}", closed=True, example=example))


def whole(low: int, high: int, example: str) -> Reader[int]:
    """Return a reader of whole numbers within bounds, both of which belong to it."""
    inside, endless = number(low, high, example), number(-math.inf, math.inf, example)

    def read(name: str, text: str) -> int:
        if not endless(name, text).is_integer():
            refuse(name, text, "is not a whole number", f"allowed: {low} to {high}; write e.g. {example}")
        return int(inside(name, text))

    return Reader(read, low)


def one_of(*allowed: _Word) -> Reader[_Word]:
    """Return a reader of one of some words."""

    def read(name: str, text: str) -> _Word:
        if text not in allowed:
            refuse(name, shown(text), f"must be {' or '.join(shown(word) for word in allowed)}")
        return allowed[allowed.index(text)]

    return Reader(read, allowed[0])


def words_of(allowed: tuple[_Word, ...]) -> Reader[tuple[_Word, ...]]:
    """Return a reader of some of the words, with commas between them."""

    def read(name: str, text: str) -> tuple[_Word, ...]:
        from squama import arguments

        return arguments.several(name, [word.strip() for word in text.split(",")], allowed)

    return Reader(read, allowed)


class Pair(NamedTuple):
    """What stands before and after the sign of equality."""

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
    """Return pairs as a mapping; a name that is there twice, by an alias too, is kept as a mistake of the flag."""
    found, same = dict[str, str](), aliases or {}
    for key, text in pairs:
        if same.get(key, key) in (same.get(other, other) for other in found):
            problems().add(f"{name} {key}", "", "is given twice", "keep one of them")
        else:
            found[key] = text
    return found


class Setting(NamedTuple):
    """A value of --set, or of another flag that gives one of the file's."""

    place: str
    value: int | str
    flag: str = "--set"

    @property
    def name(self) -> str:
        """The flag and what it sets, as they are written."""
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
    """Return a reader of values with commas between them."""
    return Reader(lambda name, text: tuple(one(name, part) for part in text.split(",")), ())


_mu = number(0.0, 10.0, "0.25")


def _family(name: str, text: str) -> tuple[float, ...]:
    values = several(_mu)(name, text)
    kept = {f"{mu:g}": values.count(mu) for mu in values}
    if twice := [mu for mu, count in kept.items() if count > 1]:
        refuse(name, text, f"{' and '.join(twice)} is given twice", f"write {name} {','.join(kept)}")
    return values


def rate(name: str, text: str, beam: Beam, load: str = "twisting", *, still: bool = False) -> float:
    """Return the twist rate or curvature that a flag asks for, rad/m; only if ``still`` it may be 0."""
    kind = LOADS[load]
    with naming(name):
        found = kind.read(text, pitch=beam.pitch, scales=beam.pitches, bare=False)
    if found < 0 or (found == 0 and not still):
        least = "0 or more" if still else "more than 0"
        refuse(name, shown(text), f"must be {least}{kind.other_way('--sense -')}", 'write e.g. "0.2 rad/pitch"')
    return found


@dataclass_transform(frozen_default=True, kw_only_default=True)
def group(flags: type[T]) -> type[T]:
    """Make a frozen class of flags, which stand among the others of a command."""
    made = dataclass(frozen=True, kw_only=True)(flags)
    # a group may be extended in another module, which has not the names of this one's types
    vars(made)["__init__"].__annotations__ = get_type_hints(made, include_extras=True)
    return Parameter(name="*")(made)


# ---- flags that several commands have ---------------------------------------------------------------------

TWISTS = '"5 rad/m", "0.2 rad/pitch" or "90 deg total"'
"""How a twist is written."""
AT = f"Twist for which compliant joints give their figures: {TWISTS}. Default: twice that at engagement."
if TYPE_CHECKING:
    File = str
else:
    # a path to shells, which complete it; to the program the text as it is written
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
    """Return what to lay mistakes to: the flags of the names of arguments, and what is said for others."""
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
    """Model of joints and scales, and which line of the bar keeps its length."""

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
        """Let the log speak as early as the command line is read."""
        if self.verbose:
            LOG.setLevel(logging.INFO)

    @property
    def settings(self) -> Sequence[Setting]:
        """Values in place of the file's; what is held is one of them, where it is a flag."""
        hold = getattr(self, "hold", None)
        return self.set_ if hold is None else (*self.set_, Setting("beam.hold", hold, "--hold"))

    def overrides(self, mu: float | None = None) -> dict[str, dict[str, object]]:
        """Return the values in place of the file's, by table and key; one that is given twice is refused."""
        found: dict[str, dict[str, object]] = {} if mu is None else {"friction": {"mu": mu}}
        for one in self.settings:
            name, _, key = one.place.partition(".")
            table = found.setdefault(name, {})
            if key in table:
                refuse(one.name, "", "is given twice, or by a flag of its own, too", "keep one of them")
            table[key] = one.value
        return found

    def beam(self, path: str, mu: float | None = None, *, friction: bool = True) -> Beam | None:
        """Read the beam, ``mu`` in place of the file's; mistakes are kept, of a value of --set laid to that flag.

        A beam without a coefficient of friction is a mistake if ``friction``.
        """
        from squama.beam.design import Beam

        with problems().caught(), laid({s.place: s.name for s in self.settings}):
            found = Beam.from_toml(path, overrides=self.overrides(mu))
            if friction:
                check_friction(path, found)
            return found
        return None

    def turned(
        self,
        path: str,
        mu: float | None,
        name: str,
        text: str | None,
        *,
        scales: int | None = None,
        load: str = "twisting",
        friction: bool = True,
        still: bool = False,
    ) -> tuple[Beam | None, float | None]:
        """Read the beam, with so many scales, and the twist of a flag, if it is given; mistakes are kept."""
        found, twist = self.beam(path, mu, friction=friction), None
        if found is not None:
            found = found.replace(scales=scales or found.scales)
        if found is not None and text is not None:
            with problems().caught():
                twist = rate(name, text, found, load, still=still)
        return found, twist


_HOLD = "Strains of the bar that are held: bend, twist, lateral bend, stretch; or straight (all). Default: the file's."


@group
class Common(Base):
    """Flags of every command that computes a dataset of a beam."""

    plot: Plot = ()
    csv: Annotated[File | None, flag("CSV file to write, with units in its header; - prints it alone.")] = None
    netcdf: Annotated[File | None, flag("netCDF file (.nc) to write, with all results.")] = None
    hold: Annotated[str | None, flag(_HOLD)] = None

    def check(self, *inputs: str, plots: Iterable[str] = ()) -> None:
        """Look at every output path before any work, other pictures included."""
        pictures = ((path, PLOTS) for path in (*self.plot, *plots))
        table = table_place(problems(), "--csv", self.csv, as_json=self.json)
        check_places([*pictures, (table, (".csv",)), (self.netcdf, (".nc",))], inputs)


BASE, COMMON = Base(), Common()


def check_places(wanted: Iterable[tuple[str | None, tuple[str, ...]]], inputs: Iterable[str] = ()) -> None:
    """Look at paths that are to be written, if given, each with the endings it may have; mistakes are kept."""
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
    """Keep a beam without a coefficient of friction as a mistake."""
    if beam.friction.mu is None and "--mu" not in problems().flags:
        remedy = "write mu = 0.25 under [friction] or give --mu 0.25"
        problems().add("friction.mu", "", "is missing", remedy, source=label(path))

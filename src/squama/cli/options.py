"""What the commands twist and bend have in common: their flags, and how these are read."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

from squama.errors import InputError

PLOTS = (".png", ".svg", ".pdf")


def flag(words: str, name: str | None = None) -> Parameter:
    """Return a flag whose value may begin with a minus sign."""
    return Parameter(name=name, help=words, allow_leading_hyphen=True)


@Parameter(name="*")
@dataclass(frozen=True, kw_only=True)
class Options:
    """Flags of twist and bend."""

    mu: Annotated[str | None, flag("Coefficient of friction, e.g. 0.25; 0,0.2,0.5 draws a family of curves.")] = None
    margin: Annotated[
        str, flag("Where a curve that locks is cut off: fraction of its path left before the lock (0.01).")
    ] = "0.01"
    points: Annotated[str, flag("Number of points of a curve (200).")] = "200"
    to: Annotated[str | None, flag('Where to stop: "5 rad/m", "0.2 rad/pitch" or "90 deg total".')] = None
    set_: Annotated[
        tuple[str, ...],
        flag('A value in place of the file\'s, e.g. scale.alpha="30 deg"; may be repeated.', "--set"),
    ] = ()
    data: Annotated[
        str | None, flag('Measured points to draw too: CSV with a header such as "Phi (deg/mm), T (N mm)".')
    ] = None
    plot: Annotated[tuple[str, ...], flag("Picture to write: .png, .svg or .pdf; may be repeated.")] = ()
    csv: Annotated[str | None, flag("CSV file to write: a row per point, units in the header.")] = None
    netcdf: Annotated[str | None, flag("netCDF file to write (.nc).")] = None
    json: Annotated[
        bool,
        Parameter(help='Print everything as JSON instead of the summary; no number is null, infinity is "inf".'),
    ] = False


DEFAULTS = Options()


class Problems:
    """Collects mistakes, so that all are named at once."""

    def __init__(self) -> None:
        self.lines: list[str] = []

    @contextmanager
    def caught(self) -> Iterator[None]:
        """Keep the mistake that is found inside, and go on."""
        try:
            yield
        except InputError as error:
            self.lines += str(error).splitlines()

    def settle(self) -> None:
        """Raise what has been found, if anything.

        Raises
        ------
        InputError
            One line per mistake.
        """
        if self.lines:
            raise InputError("\n".join(self.lines))


def read_number(name: str, text: str, low: float, high: float, allowed: str, example: str) -> float:
    """Return a plain number within its bounds (both belong to it), or refuse the flag."""
    from squama.units import Bounds, Dimension, QuantityError, bounded

    try:
        return bounded(text, Dimension.RATIO, Bounds(low, high, allowed, closed=True, example=example))
    except QuantityError as error:
        message = f"{name} = {error.shown}: {error.reason}"
        raise InputError(message) from None


def read_mu(text: str | None) -> float | list[float] | None:
    """Return one coefficient of friction, a family of them, or None."""
    if text is None:
        return None
    values = [read_number("--mu", part, 0.0, 10.0, "0 to 10", "0.25") for part in text.split(",")]
    twice = [f"{mu:g}" for mu in dict.fromkeys(values) if values.count(mu) > 1]
    if twice:
        once = ",".join(f"{mu:g}" for mu in dict.fromkeys(values))
        message = f"--mu = {text}: {' and '.join(twice)} is given twice; write --mu {once}"
        raise InputError(message)
    return values if len(values) > 1 else values[0]


def read_points(text: str) -> int:
    """Return the number of points."""
    allowed = "3 to 100000"
    value = read_number("--points", text, -math.inf, math.inf, allowed, "200")
    if value != int(value):
        message = f"--points = {text}: is not a whole number; allowed: {allowed}; write e.g. 200"
        raise InputError(message)
    return int(read_number("--points", text, 3, 100_000, allowed, "200"))


def read_overrides(settings: Iterable[str]) -> dict[str, dict[str, Any]]:
    """Return the values of --set by table and key."""
    from squama import beamfile
    from squama.units import shown

    found: dict[str, dict[str, Any]] = {}
    problems = []
    for setting in settings:
        place, equals, value = setting.partition("=")
        table, dot, key = place.strip().partition(".")
        text = value.strip().strip('"')
        if not (equals and dot and text):
            problems.append(f'--set {shown(setting)}: is not table.key=value; write e.g. scale.alpha="30 deg"')
        elif table not in beamfile.TABLES:
            problems.append(f"--set {shown(setting)}: {beamfile.unknown_table(table, {})}")
        elif key not in beamfile.TABLES[table]:
            problems.append(f"--set {shown(setting)}: {beamfile.unknown_key(table, key)}")
        else:
            whole = text.lstrip("+-").isdecimal() and len(text) < 20
            found.setdefault(table, {})[key] = int(text) if whole else text
    if problems:
        raise InputError("\n".join(problems))
    return found


def check_outputs(options: Options, inputs: Iterable[str]) -> list[str]:
    """Look at every output path before any work; return one line per mistake."""
    wanted: list[tuple[str, tuple[str, ...]]] = [(path, PLOTS) for path in options.plot]
    wanted += [(path, (ext,)) for path, ext in ((options.csv, ".csv"), (options.netcdf, ".nc")) if path is not None]
    return check_places(wanted, inputs)


def check_places(wanted: Iterable[tuple[str, tuple[str, ...]]], inputs: Iterable[str]) -> list[str]:
    """Look at paths, each with the endings it may have, that are to be written; return one line per mistake."""
    from squama.files import label
    from squama.store import check_place

    problems = Problems()
    seen = {Path(path).resolve(): "is read too" for path in inputs}
    for path, allowed in wanted:
        with problems.caught():
            check_place(path, allowed)
            place = Path(path).resolve()
            if place in seen:
                message = f"{label(path)}: {seen[place]}; give the output another name"
                raise InputError(message)
            seen[place] = "is given twice"
    return problems.lines

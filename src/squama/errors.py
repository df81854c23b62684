"""What can go wrong, as values: where, which value, what is wrong with it, what to write instead.

The text of an error is made from its problems and never read again: who knows better where a value came from (a flag,
a file, a field) changes ``where`` or ``source``.
"""

from __future__ import annotations

import functools
import re
import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from typing import NamedTuple, NoReturn, ParamSpec, TypeVar

P = ParamSpec("P")
T = TypeVar("T")
LONGEST = 1000
"""Characters of a part of a message that are shown."""
_DIGITS = re.compile(r"(\d{20})\d{21,}")


class SquamaError(Exception):
    """Base of every error that squama raises on purpose; its text is complete for the user."""


class Problem(NamedTuple):
    """One mistake.

    ``where`` names the argument, key or cell, ``value`` is what stands there as it is shown, ``reason`` what is wrong,
    ``remedy`` what to write instead, ``source`` the file (and line) it stands in; what does not apply is empty.
    """

    where: str = ""
    value: str = ""
    reason: str = ""
    remedy: str = ""
    source: str = ""

    def __str__(self) -> str:
        """Return the line: ``source: where = value: reason; remedy``; control characters are escaped, all is short."""
        where, value, reason, remedy, source = map(_brief, self)
        said = "; ".join(filter(None, (reason, remedy)))
        if value and not where:
            return ": ".join(filter(None, (source, f"{value} {said}")))
        named = " = ".join(filter(None, (where, value)))
        return ": ".join(filter(None, (source, named, said)))

    def at(self, where: str = "", source: str = "") -> Problem:
        """Return the problem at a place that stands before its own; a file named at that place becomes part of it."""
        found = self
        if where:
            found = self._replace(where=": ".join(filter(None, (where, self.source, self.where))), source="")
        return found._replace(source=": ".join(filter(None, (source, found.source))))

    def renamed(self, names: Mapping[str, str]) -> Problem:
        """Return the problem with another name for its place, without the source: the value came from there.

        A name changes places that are equal to it or begin with it (``scale.alpha``, ``at[3]``, ``bounds: mu``), or
        do so after the last colon (``design 17: mu``); the longest name counts.
        """
        before, colon, last = self.where.rpartition(": ")
        for start, place in (("", self.where), (before + colon, last)):
            for name in sorted(names, key=len, reverse=True):
                rest = place.removeprefix(name)
                if place.startswith(name) and (not rest or rest[0] in ".[:, " or not name[-1:].isalnum()):
                    return self._replace(where=start + names[name] + rest, source="")
        return self


def printable(text: str) -> str:
    """Return text whose control characters, and others that steer a terminal, are escaped."""
    if text.isprintable():
        return text
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in text)


def _brief(text: str) -> str:
    """Return a part of a message as it is shown."""
    short = _DIGITS.sub(r"\1...", text)
    return printable(short if len(short) <= LONGEST else f"{short[:LONGEST]} ...")


class InputError(SquamaError, ValueError):
    """Something the user gave is not usable.

    Parameters
    ----------
    problems : Problem or str
        The mistakes; text is the reason of one that has no place, each line one.

    Attributes
    ----------
    problems : tuple
        The mistakes, each a ``Problem``; the text of the error has a line for each: what, where, which value, what is
        allowed, what to write instead.
    """

    problems: tuple[Problem, ...]

    def __init__(self, *problems: Problem | str) -> None:
        found: list[Problem] = []
        for one in problems:
            found += [one] if isinstance(one, Problem) else [Problem(reason=line) for line in one.splitlines()]
        self.problems = tuple(found)
        super().__init__(*found)

    def __str__(self) -> str:
        """Return one line for each problem."""
        return "\n".join(map(str, self.problems))

    def at(self, where: str = "", source: str = "") -> InputError:
        """Return the error with a place, a source or both put before those of its problems."""
        return InputError(*(problem.at(where, source) for problem in self.problems))

    def renamed(self, names: Mapping[str, str]) -> InputError:
        """Return the error with other names for places, such as ``{"mu": "--mu"}``; see :meth:`Problem.renamed`."""
        return InputError(*(problem.renamed(names) for problem in self.problems))


def refuse(where: str, value: str, reason: str, remedy: str = "", source: str = "") -> NoReturn:
    """Raise an error of one problem."""
    raise InputError(Problem(where, value, reason, remedy, source)) from None


@contextmanager
def naming(where: str = "", source: str = "") -> Iterator[None]:
    """Put a place, a source or both before those of an error that is raised inside."""
    try:
        yield
    except InputError as error:
        raise error.at(where, source) from None


class Problems(list[Problem]):
    """Collects mistakes, so that all are named at once."""

    def add(self, where: str, value: str = "", reason: str = "", remedy: str = "", source: str = "") -> None:
        """Add one."""
        self.append(Problem(where, value, reason, remedy, source))

    @contextmanager
    def caught(self, where: str = "", source: str = "") -> Iterator[None]:
        """Keep the mistakes that are found inside, and go on; place and source are put before theirs."""
        try:
            yield
        except InputError as error:
            self.extend(error.at(where, source).problems)

    def settle(self, source: str = "") -> None:
        """Raise what has been found, if anything, each mistake once."""
        if self:
            raise InputError(*dict.fromkeys(self)).at(source=source) from None


class SquamaWarning(UserWarning):
    """What squama warns of, for filters: ``warnings.filterwarnings("ignore", category=squama.SquamaWarning)``."""


class TableWarning(SquamaWarning):
    """A table of measured points does not say how it is to be read; what was guessed."""


class ResultWarning(SquamaWarning):
    """What a result says in its ``warnings``: how far it can be trusted, and what is outside the model's range."""


def telling(function: Callable[P, T]) -> Callable[P, T]:
    """Return a function that also warns of what its result says in its ``warnings``, each line once for a call.

    The package's public functions are made so where they get their public names; the command line and other functions
    of the package call those inside, which are silent.
    """

    @functools.wraps(function)
    def told(*args: P.args, **kwargs: P.kwargs) -> T:
        result = function(*args, **kwargs)
        found: str | Iterable[str] = getattr(result, "attrs", {}).get("warnings", getattr(result, "warnings", ()))
        for line in dict.fromkeys(found.splitlines() if isinstance(found, str) else found):
            warnings.warn(line, ResultWarning, stacklevel=2)
        return result

    # by this name it is found again in another process
    told.__module__ = "squama"
    return told


class ValidityWarning(SquamaWarning):
    """A law or an idealisation is used outside the range it was made for."""

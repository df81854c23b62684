"""Errors and warnings of squama, kept as values: the place of a mistake, the wrong value, the reason and the remedy.

The text of an error is made from its problems and never parsed: a caller that knows the origin of a value better (a
flag, a file, a field) changes ``where`` or ``source``.
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
"""Largest number of characters of a part of a message that is printed."""
_DIGITS = re.compile(r"(\d{20})\d{21,}")


class SquamaError(Exception):
    """Base of every error that squama raises on purpose; its text is complete for the user."""


class Problem(NamedTuple):
    """A mistake in the user's input.

    ``where`` names the argument, key or cell, ``value`` is the wrong value as printed, ``reason`` says why it is wrong,
    ``remedy`` says what to write instead, ``source`` names the file (and line). Parts that do not apply are empty.
    """

    where: str = ""
    value: str = ""
    reason: str = ""
    remedy: str = ""
    source: str = ""

    def __str__(self) -> str:
        """Return the line ``source: where = value: reason; remedy``, shortened, with control characters escaped."""
        where, value, reason, remedy, source = map(_brief, self)
        said = "; ".join(filter(None, (reason, remedy)))
        if value and not where:
            return ": ".join(filter(None, (source, f"{value} {said}")))
        named = " = ".join(filter(None, (where, value)))
        return ": ".join(filter(None, (source, named, said)))

    def at(self, where: str = "", source: str = "") -> Problem:
        """Return the problem with ``where`` put before its own place; its source becomes part of that place.

        ``source`` is put before the source that is left.
        """
        found = self
        if where:
            found = self._replace(where=": ".join(filter(None, (where, self.source, self.where))), source="")
        return found._replace(source=": ".join(filter(None, (source, found.source))))

    def renamed(self, names: Mapping[str, str]) -> Problem:
        """Return the problem with another name for its place, and without its source: the value came from there.

        A name changes places that are equal to it or begin with it (``scale.alpha``, ``at[3]``, ``bounds: mu``), or do
        so after the last colon (``design 17: mu``); the longest matching name counts.
        """
        before, colon, last = self.where.rpartition(": ")
        for start, place in (("", self.where), (before + colon, last)):
            for name in sorted(names, key=len, reverse=True):
                rest = place.removeprefix(name)
                if place.startswith(name) and (not rest or rest[0] in ".[:, " or not name[-1:].isalnum()):
                    return self._replace(where=start + names[name] + rest, source="")
        return self


def printable(text: str) -> str:
    """Return text in which control characters, and others that steer a terminal, are escaped."""
    if text.isprintable():
        return text
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in text)


def _brief(text: str) -> str:
    """Return a part of a message as it is printed: shortened and escaped."""
    short = _DIGITS.sub(r"\1...", text)
    return printable(short if len(short) <= LONGEST else f"{short[:LONGEST]} ...")


class InputError(SquamaError, ValueError):
    """Error for input that squama cannot use.

    Parameters
    ----------
    problems : Problem or str
        The mistakes; the text of the error has one line for each: place, value, reason and remedy.

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
        """Return the text of the error: one line for each problem."""
        return "\n".join(map(str, self.problems))

    def at(self, where: str = "", source: str = "") -> InputError:
        """Return the error with a place, a source or both put before those of its problems; see :meth:`Problem.at`."""
        return InputError(*(problem.at(where, source) for problem in self.problems))

    def renamed(self, names: Mapping[str, str]) -> InputError:
        """Return the error with other names for its places, such as ``{"mu": "--mu"}``; see :meth:`Problem.renamed`."""
        return InputError(*(problem.renamed(names) for problem in self.problems))


def refuse(where: str, value: str, reason: str, remedy: str = "", source: str = "") -> NoReturn:
    """Raise an :class:`InputError` of one problem."""
    raise InputError(Problem(where, value, reason, remedy, source)) from None


@contextmanager
def naming(where: str = "", source: str = "") -> Iterator[None]:
    """Put a place, a source or both before those of an :class:`InputError` raised in the block."""
    try:
        yield
    except InputError as error:
        raise error.at(where, source) from None


class Problems(list[Problem]):
    """List of mistakes, collected so that one error names them all."""

    def add(self, where: str, value: str = "", reason: str = "", remedy: str = "", source: str = "") -> None:
        """Append a problem of these parts."""
        self.append(Problem(where, value, reason, remedy, source))

    @contextmanager
    def caught(self, where: str = "", source: str = "") -> Iterator[None]:
        """Collect the problems of an :class:`InputError` in the block, with place and source put before theirs."""
        try:
            yield
        except InputError as error:
            self.extend(error.at(where, source).problems)

    def settle(self, source: str = "") -> None:
        """Raise the collected problems as one error, each once; do nothing if there are none."""
        if self:
            raise InputError(*dict.fromkeys(self)).at(source=source) from None


class SquamaWarning(UserWarning):
    """Base of squama's warnings, for filters: ``warnings.filterwarnings("ignore", category=SquamaWarning)``."""


class TableWarning(SquamaWarning):
    """Warning that a table of measured points leaves its units or columns open, with the reading that was guessed."""


class ResultWarning(SquamaWarning):
    """Warning from the ``warnings`` of a result: how far to trust it, and where it leaves the model's range."""


def telling(function: Callable[P, T]) -> Callable[P, T]:
    """Return the function wrapped so that each line of its result's ``warnings`` is issued as a warning, once a call.

    Only the package's public names are wrapped; the command line and the package's own calls use the silent functions.
    """

    @functools.wraps(function)
    def told(*args: P.args, **kwargs: P.kwargs) -> T:
        result = function(*args, **kwargs)
        found: str | Iterable[str] = getattr(result, "attrs", {}).get("warnings", getattr(result, "warnings", ()))
        for line in dict.fromkeys(found.splitlines() if isinstance(found, str) else found):
            warnings.warn(line, ResultWarning, stacklevel=2)
        return result

    # so that another process can unpickle it by this name
    told.__module__ = "squama"
    return told


class ValidityWarning(SquamaWarning):
    """Warning that a law or an idealisation is used outside its range of validity."""

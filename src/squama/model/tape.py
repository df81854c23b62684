"""Formulas of many arrays as flat programs of NumPy's functions.

A formula is called once with terms in place of arrays, and what it does to them is noted. What its results do not need
is left out, and what occurs twice is done once. The program then takes arrays piece by piece, so that they stay in the
processor's cache, and puts what lies between into the same few places: new memory for every step costs more time than
the arithmetic.
"""

from __future__ import annotations

import functools
import math
import threading
from collections.abc import Callable, Iterable
from typing import Any, NamedTuple

import numpy as np
from numpy.lib.mixins import NDArrayOperatorsMixin

Array = np.ndarray[Any, np.dtype[Any]]

PIECE = 16384
"""Entries of an array that are taken at a time: steps take some 0.4 us each beside their arithmetic."""
_rooms = threading.local()


def _minimum(a: Array, b: Array, out: Array) -> None:
    np.minimum(a, b, out=out)


_WITH_PLACE: dict[Any, Callable[..., Any]] = {np.minimum: _minimum}
"""How a function is given the place of its result, if not as its last argument, which is the fastest way."""


class Term(NDArrayOperatorsMixin):
    """Stands for an array while a formula is noted: what it is made of, its place, and the last that takes it."""

    __hash__ = object.__hash__

    def __init__(self, tape: Tape, ufunc: np.ufunc | None, of: tuple[Term, ...], place: int) -> None:
        self.tape, self.ufunc, self.of, self.place = tape, ufunc, of, place
        self.last: Term | None = None

    def __array_ufunc__(self, ufunc: np.ufunc, method: str, *of: Any) -> Term:
        assert method == "__call__"
        return self.tape.note(ufunc, of)


class Step(NamedTuple):
    """Fill the place ``to`` with a function of the places ``a`` and, if it takes two, ``b``."""

    fill: Callable[..., Any]
    a: int
    b: int | None
    to: int


class Tape:
    """A formula ``f(x, *columns)`` with several results, for ``x`` of shape (n,) or (m, n) and columns of shape (n,).

    Parameters
    ----------
    f
        The formula: arithmetic and NumPy's functions, without a look at values.
    columns
        Number of its columns.
    """

    def __init__(self, f: Callable[..., Iterable[Any]], columns: int) -> None:
        self._known: dict[Any, Term] = {}
        # x, the columns, constants, results, what columns alone give, and registers, which are counted from the end
        self._places: list[Any] = [None] * (columns + 1)
        x, *inputs = (Term(self, None, (), n) for n in range(columns + 1))
        results = list(f(x, *inputs))
        self.columns, self.results = columns, slice(len(self._places), len(self._places) + len(results))
        self._places += [None] * len(results)
        self.before, self.steps = self._planned(x, results)

    def note(self, ufunc: np.ufunc, of: tuple[Any, ...]) -> Term:
        """Note a step, unless it changes nothing or has been noted before."""
        if ufunc in (np.multiply, np.divide) and not isinstance(of[1], Term) and of[1] == 1:
            return of[0]  # type: ignore[no-any-return]
        if ufunc is np.bitwise_and:
            # truth values are the numbers 0 and 1, for all places are of one type
            ufunc = np.multiply
        if ufunc is np.negative and of[0].ufunc is np.negative:
            return of[0].of[0]  # type: ignore[no-any-return]
        terms = tuple(v if isinstance(v, Term) else self._constant(float(v)) for v in of)
        return self._known.setdefault((ufunc, *map(id, terms)), Term(self, ufunc, terms, 0))

    def _constant(self, value: float) -> Term:
        if value not in self._known:
            self._known[value] = Term(self, None, (), len(self._places))
            # an array without dimensions is taken faster than a number
            self._places.append(np.array(value))
        return self._known[value]

    def _needed(self, results: list[Term]) -> list[Term]:
        """Return the steps that the results need, in order; note of every term which of them is the last to take it."""
        steps = [t for t in self._known.values() if t.ufunc]
        for term in results:
            term.last = term
        for term in reversed(steps):
            for t in term.of if term.last else ():
                t.last = t.last or term
        return [t for t in steps if t.last]

    def _planned(self, x: Term, results: list[Term]) -> tuple[list[Step], list[Step]]:
        """Give every step its place: those of the columns alone, those of x, and results that are copies."""
        varies, before, steps = {x}, [], []
        free: list[int] = []
        self.registers, wanted = 0, {t: self.results.start + i for i, t in enumerate(results)}
        for term in self._needed(results):
            assert term.ufunc
            a, b = term.of[0].place, term.of[1].place if len(term.of) > 1 else None
            if varies.isdisjoint(term.of):
                term.place = len(self._places)
                self._places.append(None)
                before.append(Step(term.ufunc, a, b, term.place))
                continue
            varies.add(term)
            free += [t.place for t in dict.fromkeys(term.of) if t.last is term and t.place < 0]
            if term in wanted:
                term.place = wanted[term]
            elif free:
                term.place = free.pop()
            else:
                self.registers += 1
                term.place = -self.registers
            steps.append(Step(_WITH_PLACE.get(term.ufunc, term.ufunc), a, b, term.place))
        places = enumerate(results, self.results.start)
        steps += [Step(np.positive, t.place, None, at) for at, t in places if t.place != at]
        self._places += [None] * self.registers
        return before, steps

    def __call__(self, x: Array, *columns: Array, out: Array | None = None) -> Array:
        """Return the results, of the shape of ``x``; in ``out`` where that is given."""
        out = np.empty((self.results.stop - self.results.start, *x.shape)) if out is None else out
        table, given, places = np.atleast_2d(x), [np.atleast_2d(v) for v in out], self._places.copy()
        for low in range(0, table.shape[1], PIECE):
            part = slice(low, low + PIECE)
            places[1 : self.columns + 1] = [c[part] for c in columns]
            for made, a, b, to in self.before:
                places[to] = made(places[a]) if b is None else made(places[a], places[b])
            # short rows are taken together
            rows = PIECE // table[0, part].size
            for row in range(0, table.shape[0], max(1, rows)):
                at = (slice(row, row + rows) if rows > 1 else row, part)
                places[0], places[self.results] = table[at], [v[at] for v in given]
                places[len(places) - self.registers :] = _room(self.registers, places[0].shape)
                for fill, a, b, to in self.steps:
                    if b is None:
                        fill(places[a], places[to])
                    else:
                        fill(places[a], places[b], places[to])
        return out


def kept(make: Callable[..., Tape]) -> Callable[..., Tape]:
    """Make a tape once."""
    out: Any = functools.cache(make)
    return out  # type: ignore[no-any-return]


def _room(n: int, shape: tuple[int, ...]) -> list[Array]:
    """Return n arrays of a shape, in the same memory at every call from a thread."""
    size = n * math.prod(shape)
    room = getattr(_rooms, "room", None)
    if room is None or room.size < size:
        room = _rooms.room = np.empty(size)
    return list(room[:size].reshape(n, *shape))

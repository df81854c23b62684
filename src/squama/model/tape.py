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
from typing import Any

import numpy as np
from numpy.lib.mixins import NDArrayOperatorsMixin

Array = np.ndarray[Any, np.dtype[Any]]

PIECE = 16384
"""Entries of an array that are taken at a time: steps take some 0.3 us each beside their arithmetic."""
_rooms = threading.local()


class Term(NDArrayOperatorsMixin):
    """Stands for an array while a formula is noted; ``name`` is that of its place in the program."""

    __hash__ = object.__hash__

    def __init__(self, tape: Tape, ufunc: np.ufunc | None, of: tuple[Any, ...], name: str) -> None:
        self.tape, self.ufunc, self.of, self.name = tape, ufunc, of, name
        self.last: Term | None = None

    def __array_ufunc__(self, ufunc: np.ufunc, method: str, *of: Any) -> Term:
        assert method == "__call__"
        return self.tape.note(ufunc, of)


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
        self._names: dict[str, Any] = {"copyto": np.copyto}
        x, *inputs = (Term(self, None, (), f"c{n}") for n in range(columns + 1))
        results = list(f(x, *inputs))
        self.results = len(results)
        self.source = self._written(x, inputs, results)
        # a loop over the steps would take as long again as many of them
        exec(self.source, self._names)

    def note(self, ufunc: np.ufunc, of: tuple[Any, ...]) -> Term:
        """Note a step, unless it changes nothing or has been noted before."""
        if ufunc in (np.multiply, np.divide) and not isinstance(of[1], Term) and of[1] == 1:
            return of[0]  # type: ignore[no-any-return]
        if ufunc is np.bitwise_and:
            # truth values are the numbers 0 and 1, for all places are of one type
            ufunc = np.multiply
        of = tuple(v if isinstance(v, Term) else self._constant(float(v)) for v in of)
        self._names[ufunc.__name__] = ufunc
        return self._known.setdefault((ufunc, *map(id, of)), Term(self, ufunc, of, ""))

    def _constant(self, value: float) -> Term:
        term = self._known.setdefault(value, Term(self, None, (), f"k{len(self._names)}"))
        # an array without dimensions is taken faster than a number
        self._names[term.name] = np.array(value)
        return term

    def _needed(self, results: list[Term]) -> list[Term]:
        """Return the steps that the results need, in order; note of every term which of them is the last to take it."""
        steps = [t for t in self._known.values() if t.ufunc]
        for term in results:
            term.last = term
        for term in reversed(steps):
            for t in term.of if term.last else ():
                t.last = t.last or term
        return [t for t in steps if t.last]

    def _written(self, x: Term, inputs: list[Term], results: list[Term]) -> str:
        """Write the program: what the columns alone give, and the steps for a row of x with results and registers."""
        varies, self.registers = {x}, 0
        free: list[str] = []
        before: list[str] = []
        steps, given = [], [t.name for t in inputs]
        wanted = dict(zip(results, range(self.results), strict=True))
        for term in self._needed(results):
            assert term.ufunc
            call = f"{term.ufunc.__name__}({', '.join(t.name for t in term.of)}"
            if varies.isdisjoint(term.of):
                term.name = f"t{len(before)}"
                before.append(f"{term.name} = {call})")
                continue
            varies.add(term)
            free += [t.name for t in dict.fromkeys(term.of) if t.last is term and t.name[0] == "r"]
            if term in wanted:
                term.name = f"o{wanted[term]}"
            elif free:
                term.name = free.pop()
            else:
                term.name, self.registers = f"r{self.registers}", self.registers + 1
            steps.append(f"{call}, out={term.name})")
        steps += [f"copyto(o{i}, {t.name})" for i, t in enumerate(results) if t.name != f"o{i}"]
        given += [f"t{i}" for i in range(len(before))]
        places = [f"o{i}" for i in range(self.results)] + [f"r{i}" for i in range(self.registers)]
        first = [f"def columns({', '.join(t.name for t in inputs)}):", *before, f"return ({', '.join(given)},)"]
        second = [f"def steps({', '.join([x.name, *places, *given])}):", *steps]
        return "\n ".join(first) + "\n\n" + "\n ".join(second)

    def __call__(self, x: Array, *columns: Array, out: Array | None = None) -> Array:
        """Return the results, of the shape of ``x``; in ``out`` where that is given."""
        out = np.empty((self.results, *x.shape)) if out is None else out
        table, given = np.atleast_2d(x), [np.atleast_2d(v) for v in out]
        for low in range(0, table.shape[1], PIECE):
            part = slice(low, low + PIECE)
            fixed = self._names["columns"](*(c[part] for c in columns))
            # short rows are taken together
            rows = PIECE // table[0, part].size
            for row in range(0, table.shape[0], max(1, rows)):
                at = (slice(row, row + rows) if rows > 1 else row, part)
                room = _room(self.registers, table[at].shape)
                self._names["steps"](table[at], *(v[at] for v in given), *room, *fixed)
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

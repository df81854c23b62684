"""The state of a path as numbers in a row, from which the path goes on as if it had not been left; compiled.

Friction remembers the way: a slip is that from the states before, and a contact sticks or slides as it did. So a
snapshot holds what an increment takes from those before it (:class:`squama.contacts.increments.Walk`): the last three
states, where scales were, contacts, loads, direction of the leg and counters. Zeros are the beam at rest.
"""

from __future__ import annotations

from squama.batch.keeping import part as _jit
from squama.contacts.geometry import PLACED
from squama.contacts.increments import T_EVENTS, T_JUMPED, T_SINCE, T_WAY, TALLY, Walk
from squama.contacts.system import MOTIONS, POWERS, STRAINS, State
from squama.types import Array

_CONTACT = 7
"""Columns of a contact of a walk."""


def size(scales: int, reach: int, C: int) -> int:
    """Return how many numbers a snapshot has: of a beam whose cells repeat, with room for C contacts."""
    state = scales * (MOTIONS + POWERS) + STRAINS + 6 * C
    past = 3 * scales * (12 + reach * PLACED + POWERS) + 3 * C
    return 3 * state + past + _CONTACT * C + 1 + 4 + 8 + TALLY + 1


@_jit
def save(w: Walk, out: Array) -> None:
    """Write a snapshot of a path where it stands."""
    at = _saved(w.now, out, 0)
    at = _saved(w.old, out, at)
    at = _saved(w.older, out, at)
    at = _written(w.past.E, out, at)
    at = _written(w.past.pairs, out, at)
    at = _written(w.past.b, out, at)
    at = _written(w.past.F, out, at)
    at = _written(w.con, out, at)
    out[at] = w.counts[0]
    at = _written(w.loads, out, at + 1)
    at = _written(w.leg, out, at)
    at = _written(w.tally, out, at)
    _written(w.W.window, out, at)


@_jit
def take(w: Walk, kept: Array) -> None:
    """Let a path go on from a snapshot; its way and its events are counted from there on."""
    at = _taken(kept, 0, w.now)
    at = _taken(kept, at, w.old)
    at = _taken(kept, at, w.older)
    at = _read(kept, at, w.past.E)
    at = _read(kept, at, w.past.pairs)
    at = _read(kept, at, w.past.b)
    at = _read(kept, at, w.past.F)
    for c in range(len(w.con)):
        for a in range(w.con.shape[1]):
            w.con[c, a] = int(kept[at])
            at += 1
    w.counts[0] = int(kept[at])
    at = _read(kept, at + 1, w.loads)
    at = _read(kept, at, w.leg)
    at = _read(kept, at, w.tally)
    if kept[at] > 0.0:
        _read(kept, at, w.W.window)
    t = w.tally
    t[T_SINCE] -= t[T_WAY]
    t[T_WAY], t[T_JUMPED], t[T_EVENTS] = 0.0, 0.0, 0.0


@_jit
def _saved(st: State, out: Array, at: int) -> int:
    """Write a state; return where it ends."""
    at = _written(st.q, out, at)
    at = _written(st.strains, out, at)
    at = _written(st.b, out, at)
    at = _written(st.F, out, at)
    return _written(st.s, out, at)


@_jit
def _taken(kept: Array, at: int, st: State) -> int:
    """Read a state; return where it ends."""
    at = _read(kept, at, st.q)
    at = _read(kept, at, st.strains)
    at = _read(kept, at, st.b)
    at = _read(kept, at, st.F)
    return _read(kept, at, st.s)


@_jit
def _written(a: Array, out: Array, at: int) -> int:
    """Write an array; return where it ends."""
    x = a.flat
    for i in range(a.size):
        out[at + i] = x[i]
    return at + a.size


@_jit
def _read(kept: Array, at: int, a: Array) -> int:
    """Read an array; return where it ends."""
    x = a.flat
    for i in range(a.size):
        x[i] = kept[at + i]
    return at + a.size

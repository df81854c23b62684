"""Snapshot of a path as a row of numbers, from which the path continues unchanged; compiled.

Friction depends on the way: slip counts from earlier states, and a contact sticks or slides as it did. So a snapshot
has all that an increment needs of earlier ones (``squama.contacts.increments.Walk``): the last three states,
positions of the scales, contacts, loads, direction of the leg and counters. Zeros are the beam at rest.
"""

from __future__ import annotations

from squama.batch.keeping import part as _jit
from squama.contacts import tally
from squama.contacts.geometry import PLACED
from squama.contacts.increments import Walk
from squama.contacts.system import MOTIONS, POWERS, STRAINS, State, transfer
from squama.types import Array

_CONTACT = 7
"""Number of columns of a contact."""


def size(scales: int, reach: int, C: int) -> int:
    """Return the length of a snapshot: for a beam whose cells repeat, with room for C contacts."""
    state = scales * (MOTIONS + POWERS) + STRAINS + 6 * C
    past = 3 * scales * (12 + reach * PLACED + POWERS) + 3 * C
    return 3 * state + past + _CONTACT * C + 1 + 4 + 8 + tally.TALLY + 1


@_jit
def save(w: Walk, out: Array) -> None:
    """Write a snapshot of a path's present state."""
    _exchanged(w, out, True)


@_jit
def take(w: Walk, kept: Array) -> None:
    """Continue a path from a snapshot; its way and its events are counted from there on."""
    t, window = w.tally, w.W.window[0]
    _exchanged(w, kept, False)
    if not w.W.window[0] > 0.0:
        # that of the beam at rest
        w.W.window[0] = window
    t[tally.SINCE] -= t[tally.WAY]
    t[tally.WAY], t[tally.JUMPED], t[tally.EVENTS] = 0.0, 0.0, 0.0


@_jit
def _exchanged(w: Walk, a: Array, out: bool) -> None:
    """Write a snapshot, or read it if not ``out``."""
    at = _state(w.now, a, 0, out)
    at = _state(w.old, a, at, out)
    at = _state(w.older, a, at, out)
    at = transfer(w.past.E, a, at, out)
    at = transfer(w.past.pairs, a, at, out)
    at = transfer(w.past.b, a, at, out)
    at = transfer(w.past.F, a, at, out)
    at = transfer(w.con, a, at, out)
    at = transfer(w.counts[:1], a, at, out)
    at = transfer(w.loads, a, at, out)
    at = transfer(w.leg, a, at, out)
    at = transfer(w.tally, a, at, out)
    transfer(w.W.window, a, at, out)


@_jit
def _state(st: State, a: Array, at: int, out: bool) -> int:
    """Write a state, or read it if not ``out``; return the index behind it."""
    at = transfer(st.q, a, at, out)
    at = transfer(st.strains, a, at, out)
    at = transfer(st.b, a, at, out)
    at = transfer(st.F, a, at, out)
    return transfer(st.s, a, at, out)

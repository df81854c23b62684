"""Events on a path in words: contacts that engage, change, stick, slide and open, and jumps of the scales."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from squama.contacts import increments
from squama.contacts.path import COLUMNS, CORNERS, FACE, Answers, features
from squama.model.elastic_plate import BASE, SIDE_A, SIDE_D, TIP
from squama.people import per_pitch
from squama.types import Array

LETTERS = {
    (TIP, SIDE_D): "TS",
    (TIP, SIDE_A): "TA",
    (SIDE_A, BASE): "SB",
    (SIDE_D, BASE): "SD",
    (TIP, FACE): "TF",
    (CORNERS, FACE): "CF",
    (CORNERS + 1, FACE): "BF",
    (FACE, CORNERS + 2): "DF",
    (FACE, CORNERS + 3): "AF",
}
"""Letters of contacts by their features (docs, theory: bending and twisting); other contacts have words only."""
PARTS = (
    *("tip edge C{0}B{0}", "side edge D{0}C{0}", "side edge A{0}B{0}", "base edge D{0}A{0}", "the face of scale {0}"),
    *(f"corner {letter}{{0}}" for letter in "CBDA"),
)
"""Features of a contact in words, by number; scale 2 is neighbour k of scale 1."""
AT_ONCE = 1e-7
"""Distance, rad per pitch, within which an event and its reversal cancel."""
TOGETHER = "+"
"""Separator of the names of simultaneous contacts."""


class Event(NamedTuple):
    """An event at a way: ``kind`` of ``squama.contacts.increments``, bend and twist per pitch, name of the contact.

    ``before`` and ``after``: names of all contacts; ``lost``: energy lost, E d^2 per pitch.
    """

    kind: int
    way: float
    psi: float
    phi: float
    contact: str
    before: tuple[str, ...]
    after: tuple[str, ...]
    lost: float

    @property
    def placed(self) -> str:
        """Contact and way, in words."""
        return f"{self.contact} at {per_pitch(self.way)}"

    @property
    def word(self) -> str:
        """The event in words."""
        if self.kind == increments.ENGAGE:
            return f"engagement ({self.contact})" if not self.before else f"another contact ({self.contact})"
        if self.kind == increments.OPEN:
            return "release" if not self.after else f"release ({self.contact})"
        if self.kind == increments.SNAP:
            return f"snap to {TOGETHER.join(self.after)}" if self.after else "snap: the contact opens"
        if self.kind == increments.CHANGE:
            old, new = changed(self.before, self.after)
            if old and new:
                return f"{old} to {new}"
            if not old and not new:
                # no contact changed and no energy was lost: another equilibrium of the same contacts
                return "jump of the scales"
            return f"another contact ({new})" if new else f"release ({old})"
        return f"{self.contact} {'sticks' if self.kind == increments.STICK else 'slides'}"


def changed(before: tuple[str, ...], after: tuple[str, ...]) -> tuple[str, str]:
    """Return the names of contacts that exist only before, and only after, an event."""
    old, new = list(before), list(after)
    for name in before:
        if name in new:
            new.remove(name)
            old.remove(name)
    return TOGETHER.join(old), TOGETHER.join(new)


def named(first: int, second: int, k: int) -> str:
    """Return the letters of a contact from its features; words if it has none."""
    words = f"{PARTS[first].format(1)} on {PARTS[second].format(2)}"
    return LETTERS.get((first, second), words) + f" (k = {k})" * (k > 1)


def _of(kind: float, one: float, other: float, k: float) -> str:
    """Return the name of a contact from its kind, features and neighbour."""
    first, second = features(*np.array([[kind], [one], [other]]).astype(int))
    return named(int(first[0]), int(second[0]), int(k))


def _numbered(code: float) -> str:
    """Return the name of a contact from its number, see :func:`squama.contacts.increments.number`."""
    whole, other = divmod(int(code), 4)
    whole, one = divmod(whole, 4)
    whole, kind = divmod(whole, 5)
    return _of(kind, one, other, whole % 64)


def events(found: Answers, i: int = 0) -> list[Event]:
    """Return the events on the path of beam i, in their order."""
    told: list[Event] = []
    before: tuple[str, ...] = ()
    for row in found.events[i, : min(int(found.ends[i, 2]), len(found.events[i]))]:
        after = tuple(_numbered(code) for code in row[increments.AFTER :] if code >= 0)
        name = "" if row[7] < 0 else _of(row[8], row[9], row[10], row[7])
        way, psi, phi = row[1:4].tolist()
        told.append(Event(int(row[0]), way, psi, phi, name, before, after, float(row[12])))
        before = after
        if told[1:] and undone(*told[-2:]):
            del told[-2:]
    return told


def undone(one: Event, next_one: Event) -> bool:
    """Return whether an event reverses the one before it at once: one of two contacts opens as the other engages."""
    pairs = {increments.ENGAGE, increments.OPEN}, {increments.STICK, increments.SLIDE}
    same = one.contact == next_one.contact and {one.kind, next_one.kind} in pairs
    return same and next_one.way - one.way < AT_ONCE


def touching(found: Answers, i: int = 0) -> Array:
    """Return the names of the contacts (m,) in the states of beam i, joined; "" without contact."""
    return _joined(found.touches[i], found.rows[i])


def last(found: Answers) -> Array:
    """Return the names of the contacts (n,) in the last states of n beams, see :func:`touching`."""
    return _joined(found.touches[:, -1], found.rows[:, -1])


def _joined(touches: Array, rows: Array) -> Array:
    """Return the names of the contacts (n,) of states, from contacts (n, C, 16) and rows (n, 60)."""
    counts = np.nan_to_num(rows[:, COLUMNS.index("contacts")]).astype(int)
    names = [
        TOGETHER.join(_of(c[2], c[3], c[4], c[1]) for c in contacts[:count])
        for contacts, count in zip(touches, counts, strict=True)
    ]
    return np.array(names, str)


def second(told: Sequence[Event]) -> Event | None:
    """Return the first event in which a contact comes in beside another one; None if there is none."""
    return next((event for event in told if event.kind == increments.ENGAGE and event.before), None)

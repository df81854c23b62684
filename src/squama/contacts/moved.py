"""Many beams followed with complex steps: derivatives of what they do; E = d = 1."""

from __future__ import annotations

import numpy as np

from squama.batch.keeping import tell
from squama.contacts import entry
from squama.contacts.path import ROOM, STEP, Answers, Room, on_legs, signed
from squama.contacts.system import ENDLESS, UNTIED
from squama.types import Array

NOTES = 200_000
"""Numbers that are noted of a path at first; four times as many where they do not suffice."""


def moved(
    beams: entry.Beams, targets: Array, copies: int, *, most: float | Array | None = None, step: float = STEP,
    corners: Array | None = None, room: int = 1,
) -> Answers:  # fmt: skip
    """Follow beams as :func:`squama.contacts.path.follow_all`, with complex steps in beams, targets and corners.

    Each beam stands there ``copies`` times, one after the other, with other steps; their real parts are the same, and
    the path is followed once. All that is returned but the ends is complex, its real parts those of the beams without
    steps but for rounding. Imaginary parts are NaN where there are no derivatives, see
    :mod:`squama.contacts.derivatives`: behind a snap, first of all.
    """
    real = entry.Beams._make(np.ascontiguousarray(np.real(v[::copies])) for v in beams)
    kind = [v if v.dtype == bool else v.astype(complex) for v in beams]
    free, masked, seen = (v.repeat(copies, axis=0) for v in (real.free, real.masked, real.seen))
    many = entry.Beams._make([*kind[:4], free, kind[5], masked, seen, kind[8]])
    ways, strains, most = on_legs(targets.astype(complex), None if corners is None else corners.astype(complex), most)
    at, legs, most = (np.ascontiguousarray(np.real(v[::copies])) for v in (ways, strains, most))
    tell(entry.many, "scales in contact")
    tell(entry.move, "derivatives of scales in contact")
    faces = 1 + bool(real.seen.shape[1])
    found, changed = Room.of(at, room, faces), Room.of(ways, room, faces)
    for i in range(len(at)):
        _move(real, many, i, copies, most, step, at, legs, ways, strains, found, changed)
    whole = Room._make(np.repeat(v, copies, axis=0) for v in found)
    both = [_joined(v, c.imag) for v, c in zip(whole[:-1], changed[:-1], strict=True)]
    answers = Room._make([*both, whole.ends]).answers()
    return answers if corners is not None else signed(answers, targets)


def _move(
    real: entry.Beams, many: entry.Beams, i: int, copies: int, most: Array, step: float, at: Array, legs: Array,
    ways: Array, strains: Array, found: Room, changed: Room,
) -> None:  # fmt: skip
    """Follow beam i, note its increments, and follow its copies."""
    one, all_ = slice(i, i + 1), slice(i * copies, (i + 1) * copies)
    own, beam = found.part(one), entry.Beams._make(v[one] for v in real)
    every = entry.Beams._make(v[all_] for v in many)
    size, faces = NOTES, 1 + bool(real.seen.shape[1])
    while True:
        notes, rest = np.zeros((1, size)), np.zeros((1, 0))
        entry.many(beam, faces, ENDLESS, UNTIED, step, most[one], faces * ROOM, at[one], legs[one], *own, notes, rest)
        if notes[0, 0] >= 0.0:
            break
        size *= 4
    entry.move(
        every, step, most[one], faces * ROOM, ways[all_], strains[all_], notes, rest, own.ends, *changed.part(all_)[:-1]
    )  # fmt: skip


def _joined(real: Array, imag: Array) -> Array:
    """Return complex numbers of both parts, NaN in one of them or not."""
    out = real.astype(complex)
    out.imag = imag
    return out

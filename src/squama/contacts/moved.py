"""Derivatives of load paths of many beams: paths followed with complex steps; E = d = 1."""

from __future__ import annotations

import numpy as np

from squama.batch.keeping import tell
from squama.contacts import entry, path
from squama.contacts.increments import Legs, Written
from squama.types import Array

NOTES = 200_000
"""Initial room for the record of a path, in numbers; quadrupled if it does not suffice."""


def moved(
    beams: entry.Beams,
    targets: Array,
    copies: int,
    *,
    most: float | Array | None = None,
    step: float = path.STEP,
    corners: Array | None = None,
    room: int = 1,
) -> path.Answers:
    """Follow beams as :func:`squama.contacts.path.follow_all`, with complex steps in beams, targets and corners.

    Each beam appears ``copies`` times in a row, with different steps and the same real parts, so that the real path is
    followed once. All results except the ends are complex; their real parts are those of the beams without steps, up to
    rounding. Imaginary parts are NaN where there are no derivatives, see :mod:`squama.contacts.derivatives`, mainly
    behind a snap.
    """
    real = entry.Beams._make(np.ascontiguousarray(np.real(v[::copies])) for v in beams)
    many = stepped(beams, real, copies)
    whole = None if corners is None else corners.astype(complex)
    legs, faces = path.on_legs(targets.astype(complex), whole, most, step), path.faces(real)
    at = Legs._make([*(np.ascontiguousarray(np.real(v[::copies])) for v in legs[:3]), *legs[3:]])
    found, changed = path.unwritten(at.ways, room, faces), path.unwritten(legs.ways, room, faces)
    for i in range(len(at.ways)):
        one, all_ = slice(i, i + 1), slice(i * copies, (i + 1) * copies)
        own = Written._make(v[one] for v in found)
        beam, alike = (entry.Beams._make(v[which] for v in some) for some, which in ((real, one), (many, all_)))
        notes = noted(beam, _part(at, one), own)
        changed.ends[all_] = own.ends
        follow_steps(alike, _part(legs, all_), Written._make(v[all_] for v in changed), notes)
    both = [_joined(np.repeat(v, copies, axis=0), c.imag) for v, c in zip(found[:-1], changed[:-1], strict=True)]
    return path.read(Written._make([*both, changed.ends]), targets if corners is None else None)


def stepped(beams: entry.Beams, real: entry.Beams, copies: int) -> entry.Beams:
    """Return real beams as complex ones, each ``copies`` times; fields without derivatives stay real."""
    kind = [v if v.dtype == bool else v.astype(complex) for v in beams]
    alike = {name: getattr(real, name).repeat(copies, axis=0) for name in ("free", "masked", "seen", "grip")}
    return entry.Beams._make(kind)._replace(**alike)


def noted(beams: entry.Beams, legs: Legs, found: Written, snapshot: Array | None = None) -> Array:
    """Follow one beam as :func:`squama.contacts.path.follow`; return the record (1, size) of its increments."""
    size = NOTES
    while True:
        notes = np.zeros((1, size))
        path.follow(beams, legs, found, notes, None if snapshot is None else snapshot.copy())
        if notes[0, 0] >= 0.0:
            return notes
        size *= 4


def follow_steps(beams: entry.Beams, legs: Legs, found: Written, notes: Array, snapshot: Array | None = None) -> None:
    """Follow the copies of a recorded beam with their complex steps; their ends are those of the beam."""
    begin = np.zeros((1, 0)) if snapshot is None else snapshot
    tell(entry.move, "derivatives of scales in contact")
    entry.move(beams, path.faces(beams) * path.ROOM, legs, found, notes, begin)


def _part(legs: Legs, which: slice) -> Legs:
    """Return the legs of the paths ``which``."""
    return Legs._make([*(v[which] for v in legs[:3]), *legs[3:]])


def _joined(real: Array, imag: Array) -> Array:
    """Return complex numbers from real and imaginary parts, each of which may be NaN."""
    out = real.astype(complex)
    out.imag = imag
    return out

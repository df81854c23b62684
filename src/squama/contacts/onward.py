"""Endless beams that go on from states: straight legs in the strains, and derivatives of loads behind them; E = d = 1.

Each leg is followed as one of :func:`squama.contacts.path.follow_legs`, and leaves a snapshot
(:mod:`squama.contacts.snapshot`) from which the next one goes on. All are of one beam, in states of their own.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from squama.batch.keeping import tell
from squama.contacts import entry, snapshot
from squama.contacts.moved import NOTES
from squama.contacts.path import ROOM, STEP, Answers, Room
from squama.contacts.system import ENDLESS, PHI, PSI, STRAINS, UNTIED
from squama.types import Array

_STEP = 1e-20
"""Imaginary step of a strain: its square is lost beside all that is real."""
_M, _T = 5, 6
"""Columns of the moment and the torque among those that the compiled solver writes."""


class Leg(NamedTuple):
    """States (n,) behind legs: rows (n, 60), NaN where a leg ends before; snapshots (n, size) to go on from."""

    rows: Array
    answers: Answers
    snapshots: Array


def at_rest(beams: entry.Beams, n: int) -> Array:
    """Return snapshots (n, size) of a beam at rest."""
    scales, (eta, beta) = _faces(beams), beams.shapes[0, :2]
    reach = max(1, int(math.hypot(eta, 2 * beta)))
    return np.zeros((n, snapshot.size(scales, reach, scales * ROOM)))


def onward(beams: entry.Beams, snapshots: Array, strains: Array, goals: Array, step: float = STEP) -> Leg:
    """Follow one beam from snapshots (n, size) at strains (n, 2), bend and twist, straight to others (n, 2).

    None is equal to the one where its leg begins.
    """
    ways, corners = _legs(strains, goals)
    found, kept = Room.of(ways, ROOM, _faces(beams)), snapshots.copy()
    _many(beams, ways, corners, step, found, np.zeros((len(ways), 0)), kept)
    answers = found.answers()
    return Leg(answers.rows[:, 1], answers, kept)


def slopes(beams: entry.Beams, snapshots: Array, strains: Array, goals: Array, step: float = STEP) -> Array:
    """Return derivatives (n, 2, 2) of moment and torque behind legs by the bend and twist there, see :func:`onward`.

    Those of all that the leg does, by complex steps (:mod:`squama.contacts.derivatives`); NaN behind a snap, and where
    a leg stands at an event.
    """
    ways, corners = _legs(strains, goals)
    out = np.full((len(ways), 2, 2), np.nan)
    complex_ = [v if v.dtype == bool else v.astype(complex) for v in beams]
    moved = entry.Beams._make([*complex_[:4], beams.free, complex_[5], beams.masked, beams.seen, complex_[8]])
    faces, none = _faces(beams), np.zeros(1)
    tell(entry.move, "derivatives of scales in contact")
    for i in range(len(ways)):
        one = slice(i, i + 1)
        found, size = Room.of(ways[one], 1, faces), NOTES
        while True:
            notes = np.zeros((1, size))
            _many(beams, ways[one], corners[one], step, found, notes, snapshots[one].copy())
            if notes[0, 0] >= 0.0:
                break
            size *= 4
        both = np.repeat(corners[one], 2, axis=0).astype(complex)
        both[[0, 1], 1, [PSI, PHI]] += 1j * _STEP
        far = np.zeros((2, 2), complex)
        far[:, 1] = np.sqrt(((both[:, 1] - both[:, 0]) ** 2).sum(axis=1))
        changed = Room.of(far, 1, faces)
        entry.move(
            moved, step, none, faces * ROOM, far, both, notes, snapshots[one], found.ends, *changed[:-1]
        )  # fmt: skip
        if np.isfinite(found.rows[0, 1, 0]):
            out[i] = changed.rows[:, 1, [_M, _T]].imag.T / _STEP
    return out


def _many(
    beams: entry.Beams, ways: Array, corners: Array, step: float, found: Room, notes: Array, snapshots: Array
) -> None:
    """Follow legs, and write snapshots of where they end in place of those where they begin."""
    faces, most = _faces(beams), np.zeros(len(ways))
    tell(entry.many, "scales in contact")
    entry.many(beams, faces, ENDLESS, UNTIED, step, most, faces * ROOM, ways, corners, *found, notes, snapshots)


def _legs(strains: Array, goals: Array) -> tuple[Array, Array]:
    """Return ways (n, 2) and all strains (n, 2, 4) at the ends of legs."""
    corners = np.zeros((len(goals), 2, STRAINS))
    corners[:, 0, [PSI, PHI]], corners[:, 1, [PSI, PHI]] = strains, goals
    ways = np.zeros((len(goals), 2))
    ways[:, 1] = np.hypot(*(goals - strains).T)
    return ways, corners


def _faces(beams: entry.Beams) -> int:
    """Return on how many faces a beam has scales."""
    return 1 + bool(beams.seen.shape[1])

"""Endless beams continued from states: straight legs in the strains, and derivatives of loads behind them; E = d = 1.

Each leg is followed as one of :func:`squama.contacts.path.Path.along`, and leaves a snapshot
(:mod:`squama.contacts.snapshot`) from which the next leg continues. All are of one beam, in different states.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from squama.contacts import entry, path, snapshot
from squama.contacts.increments import Legs
from squama.contacts.moved import follow_steps, noted, stepped
from squama.contacts.system import PHI, PSI, STRAINS
from squama.types import Array

_STEP = 1e-20
"""Imaginary step of a strain; its square is below rounding."""
_M, _T = 5, 6
"""Columns of moment and torque in the compiled solver's output."""


class Leg(NamedTuple):
    """States (n,) at the end of legs: rows (n, 60), NaN where a leg ends early; snapshots (n, size) of the ends."""

    rows: Array
    answers: path.Answers
    snapshots: Array


def at_rest(beams: entry.Beams, n: int) -> Array:
    """Return snapshots (n, size) of a beam at rest."""
    scales, (eta, beta) = path.faces(beams), beams.shapes[0, :2]
    reach = max(1, int(math.hypot(eta, 2 * beta)))
    return np.zeros((n, snapshot.size(scales, reach, scales * path.ROOM)))


def onward(beams: entry.Beams, snapshots: Array, strains: Array, goals: Array, step: float = path.STEP) -> Leg:
    """Follow one beam from snapshots (n, size) at strains (n, 2), bend and twist, straight to others (n, 2).

    No goal may equal its start.
    """
    legs, kept = _legs(strains, goals, step), snapshots.copy()
    found = path.unwritten(legs.ways, path.ROOM, path.faces(beams))
    path.follow(beams, legs, found, snapshots=kept)
    answers = path.read(found)
    return Leg(answers.rows[:, 1], answers, kept)


def slopes(beams: entry.Beams, snapshots: Array, strains: Array, goals: Array, step: float = path.STEP) -> Array:
    """Return derivatives (n, 2, 2) of moment and torque behind legs by the bend and twist there, see :func:`onward`.

    They include all that happens on the leg, by complex steps (:mod:`squama.contacts.derivatives`); NaN behind a snap,
    and where a leg ends at an event.
    """
    out = np.full((len(goals), 2, 2), np.nan)
    stepping, faces = stepped(beams, beams, 1), path.faces(beams)
    for i in range(len(goals)):
        one = slice(i, i + 1)
        legs = _legs(strains[one], goals[one], step)
        found = path.unwritten(legs.ways, 1, faces)
        notes = noted(beams, legs, found, snapshots[one])
        both = np.repeat(legs.corners, 2, axis=0).astype(complex)
        both[[0, 1], 1, [PSI, PHI]] += 1j * _STEP
        far = np.zeros((2, 2), complex)
        far[:, 1] = np.sqrt(((both[:, 1] - both[:, 0]) ** 2).sum(axis=1))
        changed = path.unwritten(far, 1, faces)
        changed.ends[:] = found.ends
        follow_steps(stepping, Legs(far, both, np.zeros(2), step), changed, notes, snapshots[one])
        if np.isfinite(found.rows[0, 1, 0]):
            out[i] = changed.rows[:, 1, [_M, _T]].imag.T / _STEP
    return out


def _legs(strains: Array, goals: Array, step: float) -> Legs:
    """Return straight legs (n,) from strains (n, 2) to others (n, 2)."""
    corners = np.zeros((len(goals), 2, STRAINS))
    corners[:, 0, [PSI, PHI]], corners[:, 1, [PSI, PHI]] = strains, goals
    ways = np.zeros((len(goals), 2))
    ways[:, 1] = np.hypot(*(goals - strains).T)
    return Legs(ways, corners, np.zeros(len(goals)), step)

"""Beams that are bent and twisted: paths of straight legs in the strains, moment and torque along them; E = d = 1."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from squama.contacts.path import COLUMNS, ROOM, STEP, STRETCHING, Answers, Free, Path, Scale, beams, follow_all
from squama.types import Array


class Bent(NamedTuple):
    """States of one beam along a path, or of many paths at their ends: ``rows`` (n, 60), NaN beyond the end.

    ``answers`` are those of ``way``.
    """

    rows: Array
    answers: Answers
    way: Path

    def column(self, name: str) -> Array:
        """Return a column (n,) of :data:`squama.contacts.path.COLUMNS`."""
        return np.asarray(self.rows[:, COLUMNS.index(name)])

    @property
    def strains(self) -> Array:
        """Bend and twist per pitch (n, 2), rad."""
        return np.column_stack([self.column("psi"), self.column("twist")])

    @property
    def stretch(self) -> Array:
        """Stretches (n,)."""
        return self.column("stretch")

    @property
    def M(self) -> Array:
        """Moments (n,), E d^3, the bar's included."""
        return self.column("M")

    @property
    def T(self) -> Array:
        """Torques (n,), E d^3, the bar's included."""
        return self.column("torque")


def follow_legs(
    scale: Scale, K: Array, mu: float, corners: Array, *, free: Free = STRETCHING, aside: float = 1.0,
    seen: Sequence[float] = (), own: Sequence[float] = (), step: float = STEP,
) -> Bent:  # fmt: skip
    """Follow a beam from rest through corners; every contact is told.

    Parameters
    ----------
    scale : Scale
        The scale, of floats; ``alpha`` below 0 for the mirror image.
    K : (9, 9) array
        The joint over (u, w, phi, psi, epsilon), see :mod:`squama.joints.factor`.
    mu : float
        Coefficient of friction.
    corners : (n, 2) array
        Bend and twist per pitch, rad, between which the path is straight; each other than the one before.
    free, aside, seen, own
        Strains without a moment or force, the stiffness against lateral bend, and what scales on both faces bring, as
        of :func:`squama.contacts.path.beams`; of a strain that is free the corners say nothing.
    step
        Largest increment of the way.
    """
    corners = np.asarray(corners, float)
    ways = np.cumsum(np.hypot(*np.diff(corners, axis=0, prepend=np.zeros((1, 2))).T))
    scales, mus = Scale(*np.array([scale]).T), np.array([mu])
    one = beams(scales, K[None], mus, free=free, aside=aside, seen=seen, own=own)
    found = follow_all(one, ways[None], step=step, corners=corners[None], room=ROOM)
    return Bent(found.rows[0], found, Path.met(scale, one, found))


def follow_straight(
    scale: Scale, K: Array, mu: float, ends: Array, *, free: Free = STRETCHING, aside: float = 1.0,
    seen: Sequence[float] = (), own: Sequence[float] = (),
) -> Bent:  # fmt: skip
    """Follow a beam from rest straight to each of ``ends`` (n, 2), see :func:`follow_legs`; ``way`` is of the first."""
    n = len(ends)
    scales, mus = Scale(*np.tile(scale, (n, 1)).T), np.full(n, mu)
    one = beams(scales, np.broadcast_to(K, (n, 9, 9)), mus, free=free, aside=aside, seen=seen, own=own)
    corners = np.ascontiguousarray(ends[:, None], float)
    found = follow_all(one, np.hypot(*ends.T)[:, None], corners=corners, room=ROOM)
    return Bent(found.rows[:, 0], found, Path.met(scale, one, found))

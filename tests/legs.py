"""One beam that is bent and twisted along straight legs in the strains, by the contact solver; E = d = 1."""

from __future__ import annotations

from typing import NamedTuple, Unpack

import numpy as np

from squama.contacts.path import COLUMNS, ROOM, STEP, STRETCHING, Answers, Bar, Path, Scale, beams, follow_all
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


def follow_legs(scale: Scale, K: Array, mu: float, corners: Array, *, step: float = STEP, **bar: Unpack[Bar]) -> Bent:
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
    step
        Largest increment of the way.
    **bar
        As of :func:`squama.contacts.path.beams`, by default free to stretch; of a strain that is free the corners say
        nothing.
    """
    way = Path.at_rest(scale, K, mu, **_stretching(bar))
    found = way.along(np.asarray(corners, float), step)
    return Bent(found.rows[0], found, way.met(found))


def follow_straight(scale: Scale, K: Array, mu: float, ends: Array, **bar: Unpack[Bar]) -> Bent:
    """Follow a beam from rest straight to each of ``ends`` (n, 2), see :func:`follow_legs`; ``way`` is of the first."""
    n = len(ends)
    scales, mus = Scale(*np.tile(scale, (n, 1)).T), np.full(n, mu)
    one = beams(scales, np.broadcast_to(K, (n, 9, 9)), mus, **_stretching(bar))
    corners = np.ascontiguousarray(ends[:, None], float)
    found = follow_all(one, np.hypot(*ends.T)[:, None], corners=corners, room=ROOM)
    way = Path.at_rest(scale, K, mu, **_stretching(bar))
    return Bent(found.rows[:, 0], found, way.met(found))


def _stretching(bar: Bar) -> Bar:
    """Return what is taken of the bar, free to stretch where nothing is said."""
    return {"free": STRETCHING, **bar}

"""A real beam that is bent and twisted: paths of straight legs in the strains, moment and torque along them; E = d = 1.

One contact at a time is followed (:mod:`squama.real.contact`), from one to the next (:mod:`squama.real.changes`). Where
others come in the path ends by name, and general contact (:func:`squama.fe.assembly.make_bent`) goes on.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from squama.real.moments import moments
from squama.real.path import EVERY, STEP, Answers, Path, Scale, beams, follow_all
from squama.types import Array


class Bent(NamedTuple):
    """States of a beam at the corners of its path, NaN beyond its end; ``answers`` are those of ``way``.

    Strains ``psi``, ``phi`` and ``stretch`` per pitch, moment ``M`` and torque ``T`` (E d^3, the bar's included), (n,)
    each.
    """

    psi: Array
    phi: Array
    stretch: Array
    M: Array
    T: Array
    answers: Answers
    way: Path


def follow_legs(
    scale: Scale, K: Array, mu: float, corners: Array, *, stretch: str = "free", step: float = STEP, every: int = EVERY
) -> Bent:
    """Follow a beam from rest through corners.

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
    stretch : {"free", "held"}
        No axial force, or the length of the axis stays.
    step, every
        As :func:`squama.real.path.follow_all`; the way's largest increment.
    """
    corners = np.asarray(corners, float)
    ways = np.cumsum(np.hypot(*np.diff(corners, axis=0, prepend=np.zeros((1, 2))).T))
    one = beams(Scale(*np.array([scale]).T), K[None], np.array([mu]), stretch=stretch)
    found = follow_all(one, ways[None], step=step, every=every, corners=corners[None])
    M, T, rows = moments(scale, K, found.rows[0])
    way = Path(scale, one, found.tables[0], found.contact())
    return Bent(rows["psi"], rows["twist"], rows["stretch"], M, T, found, way)


def follow_straight(scale: Scale, K: Array, mu: float, ends: Array, *, stretch: str = "free") -> Bent:
    """Follow a beam from rest straight to each of ``ends`` (n, 2), see :func:`follow_legs`; ``way`` is of the first."""
    n = len(ends)
    one = beams(Scale(*np.tile(scale, (n, 1)).T), np.broadcast_to(K, (n, 9, 9)), np.full(n, mu), stretch=stretch)
    found = follow_all(one, np.hypot(*ends.T)[:, None], corners=np.ascontiguousarray(ends[:, None], float))
    M, T, rows = moments(scale, K, found.rows[:, 0])
    way = Path(scale, one, found.tables[0], found.contact())
    return Bent(rows["psi"], rows["twist"], rows["stretch"], M, T, found, way)

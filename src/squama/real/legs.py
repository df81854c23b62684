"""A real beam that is bent and twisted: paths of straight legs in the strains, moment and torque along them; E = d = 1.

One contact at a time is followed (:mod:`squama.real.contact`), from one to the next (:mod:`squama.real.changes`). Where
others come in the path ends by name, and general contact (:func:`squama.fe.assembly.make_bent`) goes on.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from squama.model.screw import Screw
from squama.real.follow import STRAINED
from squama.real.path import EVERY, STEP, Answers, Path, Scale, beams, follow_all, spots
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
    M, T, rows = _moments(scale, K, found.rows[0])
    way = Path(scale, one, found.tables[0], found.contact())
    return Bent(rows["psi"], rows["twist"], rows["stretch"], M, T, found, way)


def follow_straight(scale: Scale, K: Array, mu: float, ends: Array, *, stretch: str = "free") -> Bent:
    """Follow a beam from rest straight to each of ``ends`` (n, 2), see :func:`follow_legs`; ``way`` is of the first."""
    n = len(ends)
    one = beams(Scale(*np.tile(scale, (n, 1)).T), np.broadcast_to(K, (n, 9, 9)), np.full(n, mu), stretch=stretch)
    found = follow_all(one, np.hypot(*ends.T)[:, None], corners=np.ascontiguousarray(ends[:, None], float))
    M, T, rows = _moments(scale, K, found.rows[:, 0])
    way = Path(scale, one, found.tables[0], found.contact())
    return Bent(rows["psi"], rows["twist"], rows["stretch"], M, T, found, way)


def _moments(scale: Scale, K: Array, states: Array) -> tuple[Array, Array, dict[str, Array]]:
    """Return moment and torque (n,) by virtual work, of the joint, and of the contact's force on the other scale.

    And the states' columns by name.
    """
    from scipy.spatial.transform import Rotation

    rows = dict(zip(STRAINED, states.T, strict=True))
    q = np.array([rows[name] for name in ("u_X", "u_Y", "u_Z", "w_X", "w_Y", "w_Z", "twist", "psi", "stretch")])
    T, M = K[6:8] @ q
    touches = rows["N"] > 0
    if not touches.any():
        return M, T, rows
    q, force = q[:, touches], np.array([rows[name][touches] for name in ("F_x", "F_y", "F_z")])
    k, (x, y) = rows["k"][touches], spots(scale, (), states[touches], 1)
    place, none = np.column_stack([x, y, rows["lift"][touches] + scale.h / 2]), np.zeros((3, x.size))
    sa, ca, st, ct = np.sin(scale.alpha), np.cos(scale.alpha), np.sin(scale.theta0), np.cos(scale.theta0)
    axes = np.array([[-sa * ct, st, ca * ct], [ca, 0.0, sa], [sa * st, ct, -ca * st]])
    moved = q[:3].T + Rotation.from_rotvec(q[3:6].T).apply(place)
    inner = (moved @ axes + np.array([0.0, scale.lam, 0.0])).T
    g = Screw.of(k * q[7], k * q[6], none[0])
    g = g._replace(v=np.array([none[0], none[0], k * (1 + q[8])]))
    for moment, axis in ((M, 0), (T, 2)):
        turning = none.copy()
        turning[axis] = -k
        moment[touches] += ((axes.T @ force) * g.rates(inner, turning, none)).sum(axis=0)
    return M, T, rows

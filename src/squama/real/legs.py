"""A real beam that is bent and twisted: paths of straight legs in the strains, moment and torque along them; E = d = 1.

One contact of two edges is followed (:mod:`squama.real.contact`). A beam that is bent first is touched by a corner on
a face in most cases; that is an end by name here, and general contact (:func:`squama.fe.assembly.make_bent`) goes on.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from squama.model.screw import Screw
from squama.real.follow import STRAINED
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
    rows = dict(zip(STRAINED, found.rows[0].T, strict=True))
    M, T = _moments(scale, K, found.contacts[0], rows)
    way = Path(scale, one, found.tables[0], found.contact())
    return Bent(rows["psi"], rows["twist"], rows["stretch"], M, T, found, way)


def follow_straight(scale: Scale, K: Array, mu: float, ends: Array, *, stretch: str = "free") -> Bent:
    """Follow a beam from rest straight to each of ``ends`` (n, 2), see :func:`follow_legs`; ``way`` is of the first."""
    n = len(ends)
    one = beams(Scale(*np.tile(scale, (n, 1)).T), np.broadcast_to(K, (n, 9, 9)), np.full(n, mu), stretch=stretch)
    found = follow_all(one, np.hypot(*ends.T)[:, None], corners=np.ascontiguousarray(ends[:, None], float))
    rows = dict(zip(STRAINED, found.rows[:, 0].T, strict=True))
    M, T = np.empty(n), np.empty(n)
    for contact in np.unique(found.contacts[:, :3], axis=0):
        alike = (found.contacts[:, :3] == contact).all(axis=1)
        M[alike], T[alike] = _moments(scale, K, contact, {name: v[alike] for name, v in rows.items()})
    way = Path(scale, one, found.tables[0], found.contact())
    return Bent(rows["psi"], rows["twist"], rows["stretch"], M, T, found, way)


def _moments(scale: Scale, K: Array, contact: Array, rows: dict[str, Array]) -> tuple[Array, Array]:
    """Return moment and torque (n,) by virtual work: of the joint, and of the contact's force on the other scale."""
    from scipy.spatial.transform import Rotation

    first, second, k = contact[:3].astype(int)
    q = np.array([rows[name] for name in ("u_X", "u_Y", "u_Z", "w_X", "w_Y", "w_Z", "twist", "psi", "stretch")])
    T, M = K[6:8] @ q
    touches = rows["N"] > 0
    if first < 0 or not touches.any():
        return M, T
    q, force = q[:, touches], np.array([rows[name][touches] for name in ("F_x", "F_y", "F_z")])
    at = rows["y"][touches]
    one = np.ones_like(at)
    x, y = [(scale.eta * one, at), (at, -scale.beta * one), (at, scale.beta * one), (0 * one, at)][second]
    place = np.column_stack([x, y, rows["lift"][touches] + scale.h / 2])
    sa, ca, st, ct = np.sin(scale.alpha), np.cos(scale.alpha), np.sin(scale.theta0), np.cos(scale.theta0)
    axes = np.array([[-sa * ct, st, ca * ct], [ca, 0.0, sa], [sa * st, ct, -ca * st]])
    moved = q[:3].T + Rotation.from_rotvec(q[3:6].T).apply(place)
    inner = (moved @ axes + np.array([0.0, scale.lam, 0.0])).T
    g, none = Screw.of(k * q[7], k * q[6], 0 * one), np.zeros((3, at.size))
    g = g._replace(v=np.array([0 * one, 0 * one, k * (1 + q[8])]))
    for moment, axis in ((M, 0), (T, 2)):
        turning = none.copy()
        turning[axis] = -k
        moment[touches] += ((axes.T @ force) * g.rates(inner, turning, none)).sum(axis=0)
    return M, T

"""Bending moment and torque of a real beam's states, by virtual work; E = d = 1."""

from __future__ import annotations

import numpy as np

from squama.model.screw import Screw
from squama.real.follow import STRAINED
from squama.real.path import Scale, spots
from squama.types import Array


def moments(scale: Scale, K: Array, states: Array) -> tuple[Array, Array, dict[str, Array]]:
    """Return moment and torque (n,) of states (n, 31), E d^3, and the states' columns by name.

    By virtual work, of the joint K (9, 9) and of the contact's force on the other scale.
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

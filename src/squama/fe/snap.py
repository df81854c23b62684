"""Whether a run of elements stops because the scales snap: the next equilibrium is a jump away (a limit point).

The elements' stiffness at the last equilibrium carries the scales, the twist goes on a little, and the scales are let
go. Where they leave and come to rest elsewhere, energy is lost on the way, and a curve of equilibria ends there.
"""

from __future__ import annotations

import numpy as np

from squama.fe.plate import Array
from squama.fe.small import fall
from squama.fe.walk import JUMP, Ended, Walk

_FARTHER = 1 / 16
"""Share of an increment by which the twist goes on."""


def explained(walk: Walk, ended: Ended, goal: float, increment: float) -> Ended:
    """Return how a run ended, saying so where the scales snap.

    Parameters
    ----------
    walk : Walk
        The run.
    ended : Ended
        What it said itself.
    goal, increment : float
        Twist that was asked for, and largest increment, rad per pitch.
    """
    if ended.reached or "invert" in ended.sentence:
        return ended
    reduced = walk.body.reduce(walk.z, walk.v.reshape(-1, 6), walk.phi)
    if reduced is None:
        return ended
    s, S, s_phi, v_0, phi_0 = reduced.s, reduced.S, reduced.s_phi, walk.v, walk.phi

    def body(v: Array, phi: float) -> tuple[Array, Array, Array]:
        return s + S @ (v - v_0) + s_phi * (phi - phi_0), S, s_phi

    contact = walk.contact
    phi = phi_0 + float(np.sign(goal - phi_0)) * abs(increment) * _FARTHER
    here, v = contact.corners(v_0, phi_0), walk.trail.expected(phi)
    if contact.free(here, contact.corners(v, phi)) < 1:
        v, phi = v_0, phi_0
    found = fall(body, contact, v, phi, walk.trail.before(phi), walk.kappa, walk.ways)
    if not np.abs(found.v - v_0).max() > JUMP:
        return ended
    away = float(np.linalg.norm(contact.corners(found.v, found.phi) - here, axis=1).max())
    words = f"come to rest {away:.2g} pitches away" if found.solved else f"move {away:.2g} pitches or farther"
    return Ended(
        False,
        f"stopped at phi = {phi_0:.4f} rad per pitch: the scales snap there; let go, they {words}, energy is lost on "
        "the way, and the curve ends",
    )

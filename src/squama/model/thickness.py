"""Plates of finite thickness: the gap between neighbours at rest, and the twist at engagement.

A plate of thickness t_s has its faces t_s/2 off the mid-plane, so that neighbours touch earlier than thin plates; the
contact condition in twisting is that of :mod:`squama.model.twisting`. All lengths are in pitches d.
"""

from __future__ import annotations

import math

from squama.model import twisting


def gap(alpha: float, theta0: float) -> float:
    """Return the distance between the mid-planes of two neighbours at rest, in pitches: -F at phi = 0."""
    return math.cos(alpha) * math.sin(theta0)


def engagement_twisting(eta: float, beta: float, lam: float, alpha: float, theta0: float, *, tau: float = 0.0) -> float:
    """Return the twist per pitch (rad) at which plates of thickness tau = t_s/d engage, tip edge on side edge.

    0 if the plates touch at rest, inf if this pair of edge lines never meets; tau = 0 is the thin model. Lengths in
    pitches, alpha and theta0 in rad, both between 0 and pi/2.
    """
    shape = math.sin(alpha), math.cos(alpha), eta, beta, lam, tau
    r = twisting.root(math.sin(theta0), math.cos(theta0), *shape)
    if r.S <= 0:
        return 0.0
    if r.q2 < 0 or r.H + math.sqrt(r.q2) <= 0:
        return math.inf
    return 2 * math.atan(r.S / (r.H + math.sqrt(r.q2)))

"""Plates of finite thickness: how much of the gap they fill, and when they would engage.

Curves of beams take the plates as thin. A real plate of thickness t_s has its faces t_s/2 off the mid-plane, so
neighbours touch earlier: in twisting where :mod:`squama.model.twisting` says.
In bending the distance of the tip's corner to the next plate's face is, per pitch,
(2/psi) sin(psi/2) sin(theta0 + psi/2) - eta sin(psi) - tau/2 (1 + cos psi).
All lengths are in pitches d.
"""

from __future__ import annotations

import math

from squama.model import twisting
from squama.model.bracket import bracketed


def gap(alpha: float, theta0: float) -> float:
    """Distance between the mid-planes of two neighbours at rest, in pitches: -F at phi = 0; alpha = 0 in bending."""
    return math.cos(alpha) * math.sin(theta0)


def engagement_twisting(eta: float, beta: float, lam: float, alpha: float, theta0: float, *, tau: float = 0.0) -> float:
    """Twist per pitch (rad) at which plates of thickness tau = t_s/d engage, tip edge on side edge.

    0 if the plates touch at rest, inf if this pair of edge lines never meets; for tau = 0 that of the thin model.
    Lengths in pitches, alpha and theta0 in rad, both between 0 and pi/2.
    """
    shape = math.sin(alpha), math.cos(alpha), eta, beta, lam, tau
    r = twisting.root(math.sin(theta0), math.cos(theta0), *shape)
    if r.S <= 0:
        return 0.0
    if r.q2 < 0 or r.H + math.sqrt(r.q2) <= 0:
        return math.inf
    return 2 * math.atan(r.S / (r.H + math.sqrt(r.q2)))


def engagement_bending(eta: float, theta0: float, tau: float = 0.0) -> float:
    """Bend per pitch (rad) at which plates of thickness tau = t_s/d engage, tip on face.

    0 if the plates touch at rest, inf if they do not meet below psi = pi/2. tau = 0 gives
    eta psi cos(psi/2) = sin(theta0 + psi/2) of docs, theory: bending; theta0 in rad, between 0 and pi/2.
    """

    def distance(psi: float) -> float:
        chord = math.sin(psi / 2) / (psi / 2) if psi else 1.0
        return chord * math.sin(theta0 + psi / 2) - eta * math.sin(psi) - tau / 2 * (1 + math.cos(psi))

    if distance(0.0) <= 0:
        return 0.0
    steps = 400
    for i in range(1, steps + 1):
        psi = i / steps * math.pi / 2
        if distance(psi) <= 0:
            return bracketed(distance, (i - 1) / steps * math.pi / 2, psi)
    return math.inf

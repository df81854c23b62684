"""Plates of finite thickness: how much of the gap they fill, and when they would engage.

The contact model takes the plates as thin. A real plate of thickness t_s has its faces t_s/2 off the
mid-plane, so neighbours touch earlier. In twisting the lower tip edge of scale 1 meets the upper side edge
of scale 2, and the contact condition of docs, theory: geometry becomes, with tau = t_s/d,

    F + tau/2 (k_XX + k_YY) = 0,  k_XX = n_X1 . n_X2,  k_YY = n_Y1 . n_Y2,  2 F = A cos phi + B sin phi - G.

By Rodrigues k_XX + k_YY = 2 c + (1 - c) q with c = cos phi and q = zX^2 + zY^2, where zX and zY are the
components of the torsion axis along n_X and n_Y. So the condition keeps its form, with
S = cos(alpha) sin(theta0) replaced by S - tau and G by G - tau q, and its root stays closed.
In bending the distance of the tip's corner to the next plate's face is, per pitch,
(2/psi) sin(psi/2) sin(theta0 + psi/2) - eta sin(psi) - tau/2 (1 + cos psi).
All lengths are in pitches d.
"""

from __future__ import annotations

import math

from squama.model.bracket import bracketed


def gap(alpha: float, theta0: float) -> float:
    """Distance between the mid-planes of two neighbours at rest, in pitches: -F at phi = 0; alpha = 0 in bending."""
    return math.cos(alpha) * math.sin(theta0)


def engagement_twisting(eta: float, beta: float, lam: float, alpha: float, theta0: float, *, tau: float = 0.0) -> float:
    """Twist per pitch (rad) at which plates of thickness tau = t_s/d engage, tip edge on side edge.

    0 if the plates touch at rest, inf if this pair of edge lines never meets; for tau = 0 that of the thin model.
    Lengths in pitches, alpha and theta0 in rad, both between 0 and pi/2.
    """
    sin_a, cos_a = math.sin(alpha), math.cos(alpha)
    sin_t, cos_t = math.sin(theta0), math.cos(theta0)
    z_x = cos_a * cos_t
    g = (
        beta * math.sin(2 * alpha) * sin_t
        + eta * cos_a**2 * math.sin(2 * theta0)
        + 2 * lam * math.cos(2 * alpha) * cos_t
    ) - tau * (z_x**2 + sin_a**2)
    s = cos_a * sin_t - tau
    if s <= 0:
        return 0.0
    h = sin_a * (eta + lam * sin_t) + z_x * (beta - sin_a)
    square = h * h - s * (g - s)
    if square < 0 or h + math.sqrt(square) <= 0:
        return math.inf
    return 2 * math.atan(s / (h + math.sqrt(square)))


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

r"""A row of N hinged scales: the tip edge of each on the side edge of the next, inclinations that differ.

Every contact is a pair gap g, relative velocity V (theory: forces). With one twist phi per pitch along the row, scale i
at inclination theta_i and the contact i between scales i and i + 1, in units of K_theta and the pitch:

.. math::

    \theta_i - \theta_0 &= N_i (\partial_a g_i - \mu\, t_i \cdot V_{a,i})
                         + N_{i-1} (\partial_b g_{i-1} - \mu\, t_{i-1} \cdot V_{b,i-1}), \\
    0 &\le g_i \perp N_i \ge 0, \qquad t = V / |V|, \quad V = V_a w_i + V_b w_{i+1} + V_\varphi, \\
    T &= \sum_i N_i (\mu\, t_i \cdot V_{\varphi,i} - \partial_\varphi g_i),

where a is the inclination of the scale whose tip rests, b that of the scale it rests on, and w = d(theta)/d(phi). The
first scale is pressed by no neighbour, the last one rests on none and is pressed down: at theta = 0 it lies on the
substrate, which holds it there (0 <= theta_i, with a moment that only lifts). Equal inclinations give the `edge` law.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from squama.types import Array

STICK = 1e-2
"""Slip (pitches per rad of phi) below which friction is less than mu N, in proportion at first: a contact that sticks
creeps slower than this."""


class Row(NamedTuple):
    """Ratios of a design (lengths in pitches), friction, number of scales."""

    eta: float
    beta: float
    lam: float
    sa: float
    ca: float
    theta0: float
    mu: float
    scales: int
    thickness: float = 0.0


class Frame(NamedTuple):
    """What all contacts have in common at one twist, in the axes (along, across, out) of a scale's hinge.

    ``h`` from the other scale's base corner D2 to the base midpoint; ``P``, ``Q`` the other scale's
    axes along the substrate and out of it; ``dh``, ``dP``, ``dQ`` their derivatives with phi. Shape (3,).
    """

    h: Array
    P: Array
    Q: Array
    dh: Array
    dP: Array
    dQ: Array


class Pair(NamedTuple):
    """Tip edge at inclination a on side edge at inclination b; lengths in pitches, shapes that of a and b.

    ``gap`` along the common normal, > 0 while open, and its derivatives; ``s``, ``p`` places on the side and tip edge;
    ``V_a``, ``V_b``, ``V_phi`` velocity of the tip edge relative to the side edge, shape (3, ...).
    """

    gap: Array
    g_a: Array
    g_b: Array
    g_phi: Array
    s: Array
    p: Array
    V_a: Array
    V_b: Array
    V_phi: Array


def frame(row: Row, phi: float, k: int = 1) -> Frame:
    """Return the axes of the scale k pitches further on, at the twist ``phi`` per pitch."""
    sa, ca, lam, beta = row.sa, row.ca, row.lam, row.beta
    c, s = np.cos(k * phi), np.sin(k * phi)
    v = 2 * np.sin(k * phi / 2) ** 2
    P = np.array([c + v * ca * ca, v * ca * sa, s * sa])
    Q = np.array([-s * sa, s * ca, c])
    Y = np.array([v * ca * sa, c + v * sa * sa, -s * ca])
    dP = k * np.array([-s * sa * sa, s * ca * sa, c * sa])
    dQ = k * np.array([-c * sa, c * ca, -s])
    dY = k * np.array([s * ca * sa, -s * ca * ca, -c * ca])
    h = lam * np.array([s * sa, -s * ca, v]) - k * np.array([ca, sa, 0.0]) + beta * Y
    return Frame(h, P, Q, beta * dY - lam * dQ, dP, dQ)


def pair(row: Row, f: Frame, a: Any, b: Any) -> Pair:
    """Return the contact of a tip edge at the inclinations ``a`` with side edges at ``b``; complex numbers too.

    It is the lower tip edge and the upper side edge, half the thickness off the middle planes.
    """
    eta, half = row.eta, row.thickness / 2
    ca, sa, cb, sb = np.cos(a), np.sin(a), np.cos(b), np.sin(b)
    mP, mY, mQ = (cb * f.P[i] + sb * f.Q[i] for i in range(3))
    tP, tY, tQ = (cb * f.Q[i] - sb * f.P[i] for i in range(3))
    fP, fY, fQ = (cb * f.dP[i] + sb * f.dQ[i] for i in range(3))
    lP, lY, lQ = (cb * f.dQ[i] - sb * f.dP[i] for i in range(3))
    x = eta * ca + f.h[0] + half * (sa - tP)
    y = f.h[1] - half * tY
    z = eta * sa + f.h[2] - half * (ca + tQ)
    J2 = mP * mP + mQ * mQ
    J = np.sqrt(J2)
    nP, nQ = -mQ / J, mP / J
    s = (x * mP + z * mQ) / J2
    V_a = np.stack([half * ca - eta * sa, 0 * sa, eta * ca + half * sa])
    V_b = np.stack([half * mP - s * tP, half * mY - s * tY, half * mQ - s * tQ])
    V_phi = np.stack([f.dh[0] - s * fP - half * lP, f.dh[1] - s * fY - half * lY, f.dh[2] - s * fQ - half * lQ])
    gap = nP * x + nQ * z
    g_a, g_b, g_phi = (nP * V[0] + nQ * V[2] for V in (V_a, V_b, V_phi))
    return Pair(gap, g_a, g_b, g_phi, s, s * mY - y, V_a, V_b, V_phi)


class Terms(NamedTuple):
    """Terms of the equations of each contact, per unit of N and of phi.

    Levers ``A``, ``B`` of its force on the two scales, ``torque``, ``friction`` the work that friction takes,
    ``rate`` of the gap, ``c`` the pair itself.
    """

    A: Array
    B: Array
    torque: Array
    friction: Array
    rate: Array
    c: Pair


def terms(row: Row, f: Frame, a: Any, b: Any, wa: Any, wb: Any) -> Terms:
    """Return the terms of contacts at inclinations a, b and rates wa, wb (per unit of phi)."""
    c = pair(row, f, a, b)
    V = c.V_a * wa + c.V_b * wb + c.V_phi
    slip = np.sqrt((V * V).sum(axis=0) + 1e-30)
    t = row.mu * V * np.where(slip.real > STICK, 1 / slip, (2 - slip / STICK) / STICK)
    A = c.g_a - (t * c.V_a).sum(axis=0)
    B = c.g_b - (t * c.V_b).sum(axis=0)
    torque = (t * c.V_phi).sum(axis=0) - c.g_phi
    return Terms(A, B, torque, (t * V).sum(axis=0), c.g_a * wa + c.g_b * wb + c.g_phi, c)

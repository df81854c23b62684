r"""Twisting: the tip edge of a scale on the side edge of the scale k pitches further along the beam.

Frame: z is the torsion axis, y points out of the scaled face, the base midpoint of scale 1 is
``(0, lam, 0)``. Scale 1 has the unit vectors n_X (base to tip), n_Y (along the width), n_Z = n_X x n_Y
(out of the upper face); scale 2 is scale 1 turned by phi about z and moved by one pitch along it.
Seen from the scale, the torsion axis is ``(zX, zY, zZ) = (cos a cos th, sin a, -cos a sin th)``, and every
cosine between the two scales, ``k_IJ = n_I . R(phi) n_J``, follows from it (Rodrigues).

Contact condition (paper Eq. 6, halved), with the half-angle tangent u = tan(phi/2):

.. math::  (G - S) u^2 - 2 H u + S = 0, \qquad q^2 = H^2 - S (G - S), \qquad u = S / (H + q),

with S = cos a sin th, H = sin a (eta + lam sin th) + zX (beta - sin a), and
G = beta sin 2a sin th + eta cos^2 a sin 2th + 2 lam cos 2a cos th. The root q is positive from engagement to
the fold, where it vanishes, and negative beyond; along the path d(theta) : d(phi) = q : V with
V = eta k_XX - s k_YY, so nothing is singular at a fold (q = 0) or at the kinematic lock (V = 0).

Plates of thickness ts touch with the lower tip edge and the upper side edge. S becomes S - ts and G becomes
G - ts (1 - S^2), the condition and its root keep their form, and moments and slip get arms ts/2.

Everything here is + - * / and ``sqrt``, which the caller passes in: floats, arrays, complex step, mpmath and
compiled code all execute this one source. Lengths are in units of the pitch (of k pitches for neighbour k).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

Number = Any  # float, complex, ndarray, mpmath.mpf, ...
Sqrt = Callable[[Number], Number]


class Root(NamedTuple):
    """Terms of the contact condition at an inclination; ``q2`` < 0 where no twist satisfies it.

    ``S`` is the distance of the plates at rest; ``S`` and ``G`` include the thickness of the plates.
    """

    sn: Number
    cs: Number
    S: Number
    H: Number
    G: Number
    q2: Number


class Contact(NamedTuple):
    """A tip edge resting on a side edge. Rates are per unit of one common, unnamed path parameter.

    ``u`` = tan(phi/2); ``p``, ``s`` places on tip and side edge; ``theta_rate``, ``phi_rate``; ``a_rate``, ``c_rate``
    sliding along side and tip edge (a = eta - s, c = beta + p); ``slip_x``, ``slip_y`` components of the slip along the
    side edge and along the tip edge; ``lift_x``, ``lift_y`` the components per unit of theta alone; ``k_IJ`` cosines
    between the two scales; ``per_J2`` = 1 / (1 - k_YX^2).
    """

    u: Number
    p: Number
    s: Number
    theta_rate: Number
    phi_rate: Number
    a_rate: Number
    c_rate: Number
    slip_x: Number
    slip_y: Number
    lift_x: Number
    lift_y: Number
    k_YY: Number
    k_ZX: Number
    k_ZY: Number
    k_ZZ: Number
    per_J2: Number


def root(
    sn: Number, cs: Number, sa: Number, ca: Number, eta: Number, beta: Number, lam: Number, ts: Number = 0.0
) -> Root:
    """Return the terms of the contact condition (paper Eq. 6) at an inclination.

    From sine and cosine of theta and of alpha, and over the pitch overlap ratio, half width of a scale, half thickness
    of the substrate, thickness of a scale.
    """
    S = ca * sn
    zX = ca * cs
    # products of constants of a path come first: arrays of rows compute them once
    H = sa * eta + sa * lam * sn + zX * (beta - sa)
    G = S * (2 * beta * sa + 2 * eta * zX) + 2 * lam * (ca * ca - sa * sa) * cs
    G = G - ts * (1 - S * S)
    S = S - ts
    return Root(sn, cs, S, H, G, H * H - S * (G - S))


def contact(
    r: Root, q: Number, sa: Number, ca: Number, eta: Number, beta: Number, lam: Number, ts: Number = 0.0
) -> Contact:
    """Return the contact at the signed root ``q`` of ``r.q2``, + before the fold and - beyond it."""
    sn, cs = r.sn, r.cs
    # half-angle tangent u, sine h and versine v of phi, and the torsion axis in the scale's own axes
    upright = r.H + q
    u = r.S / upright
    per = 2 * r.S / (upright * upright + r.S * r.S)
    h, v = per * upright, per * r.S
    S, half = ca * sn, ts / 2
    zX = ca * cs
    vX, vYZ, hX, zX2 = v * zX, v * sa * S, h * zX, zX * zX
    k_YX = vX * sa + h * S
    k_YY = 1 - v * (1 - sa * sa)
    k_YZ = hX - vYZ
    k_ZX = h * sa - vX * S
    k_ZY = -(vYZ + hX)
    k_ZZ = 1 - v * (1 - S * S)
    per_J2 = 1 / (1 - k_YX * k_YX)
    # M1 - D2 along n_Y1; a = eta - s in a form that keeps its digits where the contact is near the tip
    e_Y = (beta - sa) - v * (beta * ca * ca) - h * (lam * ca) - half * k_YZ
    eta_v, lean = eta * v, lam * sa * cs
    a = (eta_v * (1 - zX2) + k_YX * (e_Y - eta * k_YX) + v * (lam * sn) - h * lean + zX + half * k_ZX) * per_J2
    s = eta - a
    p = s * k_YX - e_Y
    V = a * k_YY + eta_v * (zX2 - sa * sa) - half * k_ZX
    # velocities at the contact: theta turns both scales about their bases, phi turns scale 2 about z
    lift_x = -(eta * k_ZX + half * (2 - v * (1 - zX2)))
    lift_y = s * k_YZ - half * k_YX
    slip_x = V * (beta * S - lean - half * sa) + q * lift_x
    slip_y = V * (ca * lam + eta * S - half * zX) + q * lift_y
    c_rate = (slip_y - k_YX * slip_x) * per_J2
    a_rate = (slip_x - k_YX * slip_y) * per_J2
    return Contact(u, p, s, q, V, a_rate, c_rate, slip_x, slip_y, lift_x, lift_y, k_YY, k_ZX, k_ZY, k_ZZ, per_J2)

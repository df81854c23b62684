"""The two force laws of frictional twisting: moments about the base line and the rate of slip.

Balance with the joint spring (theory; paper Eq. 7 with the missing minus sign): ``K_theta (theta - theta0) = -(M_N + mu
M_f) N``, with M_N and M_f the moments of a unit normal force pair and of a unit friction force pair on one scale about
its base line.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from squama.model.twisting import Contact, Number, Sqrt


class Moments(NamedTuple):
    """``M_N``, ``M_f`` (length units) and ``slip_rate`` (length per unit of the path parameter, >= 0)."""

    M_N: Number
    M_f: Number
    slip_rate: Number


def plate(c: Contact, eta: Number, sqrt: Sqrt) -> Moments:
    """Return the moments of forces in and normal to thin plates, slip projected on the plate (paper Eqs. 7-12)."""
    across = c.c_rate * c.k_YY
    slip = sqrt(c.slip_x * c.slip_x + across * across)
    return Moments(c.s - eta * c.k_ZZ, -eta * (c.slip_x * c.k_ZX + across * c.k_ZY) / slip, slip)


def edge(c: Contact, eta: Number, sqrt: Sqrt) -> Moments:  # noqa: ARG001
    """Return the moments for a normal force along the common normal of the edges, friction along the slip.

    This law satisfies virtual work.
    """
    slip = sqrt(c.a_rate * c.slip_x + c.c_rate * c.slip_y)
    M_f = (c.c_rate * c.lift_y + c.a_rate * c.lift_x) / slip
    return Moments(-(c.phi_rate * sqrt(c.per_J2)), M_f, slip)


LAWS: dict[str, Callable[[Contact, Number, Sqrt], Moments]] = {"edge": edge, "plate": plate}


def moments(law: str, c: Contact, eta: Number, sqrt: Sqrt) -> Moments:
    """Return the moments by the force law of a name."""
    return LAWS[law](c, eta, sqrt)

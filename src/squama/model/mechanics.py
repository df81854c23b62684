"""Balance, torque and margins of any contact: the part common to twisting and bending.

All in units of the joint stiffness K_theta and the pitch d.
"""

from __future__ import annotations

from typing import NamedTuple, Protocol

from squama.model.paths import Ops, Point
from squama.model.twisting import Number


class Followed(Protocol):
    """A contact on its path."""

    @property
    def theta0(self) -> Number:
        """Initial inclination, rad."""

    def point(self, x: Number, law: str, ops: Ops) -> Point:
        """Return the contact at the path parameter."""


class Row(Followed, Protocol):
    """Interface of a contact, implemented in :mod:`squama.model.paths`."""

    @property
    def eta(self) -> Number:
        """Overlap ratio."""

    def places(self, pt: Point) -> tuple[Number, ...]:
        """Return the margins of the contact's place on its edges."""

    def theta(self, x: Number) -> Number:
        """Return the inclination (rad) at the path parameter."""

    def parameter(self, theta: Number, ops: Ops) -> Number:
        """Return the path parameter of an inclination on the first branch."""


class Forces(NamedTuple):
    """``D`` = -(M_N + mu M_f); ``N`` normal and ``f`` friction force (K_theta/d); ``torque`` the scales' part."""

    D: Number
    N: Number
    f: Number
    torque: Number


def forces(pt: Point, theta0: Number, mu: Number) -> Forces:
    """Return the forces of a sliding contact from a scale's balance (paper Eqs. 7, 12, 14; docs, theory: forces)."""
    D = -pt.M_N - mu * pt.M_f
    N = (pt.theta - theta0) / D
    f = mu * N
    return Forces(D, N, f, ((pt.theta - theta0) * pt.theta_rate + f * pt.slip_rate) / pt.load_rate)


def mu_lock(pt: Point) -> Number:
    """Return the coefficient of friction at which the contact locks at this point."""
    return -pt.M_N / pt.M_f

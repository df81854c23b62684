r"""Bending: the tip of a scale on the face of the next one (docs, theory: bending).

With psi the bend per pitch and w = theta + psi/2 the contact condition is :math:`\eta\,\psi\cos(\psi/2) = \sin w`,
at the distance r = eta sin(theta - psi/2) / sin w from the base of the other scale. The kinematic lock is
w = pi/2; the moment of the forces about the base is N eta sin(psi) (cot w - mu).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from squama.model.paths import Ops, Point
from squama.model.twisting import Number


def bend_at(theta: Number, eta: Number, ops: Ops) -> Number:
    """Return the smallest bend psi per pitch at which the tip reaches the face, by Newton from below.

    Parameters
    ----------
    theta, eta
        Inclination (rad) and overlap ratio, eta >= 1.
    """
    psi = 0 * theta
    # from 0 the steps shrink quadratically: six are enough for every eta >= 1 and theta < 90 deg
    for _ in range(8):
        half = psi / 2
        gap = eta * psi * ops.cos(half) - ops.sin(theta + half)
        slope = eta * (ops.cos(half) - half * ops.sin(half)) - ops.cos(theta + half) / 2
        step = gap / slope
        psi = psi - step
        if np.all(abs(step) <= 1e-12 * abs(psi)):
            break
    return psi


class Bend(NamedTuple):
    """Tip on face, followed by x = theta; the one force law of the plane, whatever ``law`` is named."""

    eta: Number
    theta0: Number

    def point(self, x: Number, law: str, ops: Ops) -> Point:  # noqa: ARG002
        """Return the contact at the inclination ``x``."""
        eta, psi = self.eta, bend_at(x, self.eta, ops)
        half = psi / 2
        sw, cw = ops.sin(x + half), ops.cos(x + half)
        psi_rate = cw / (eta * (ops.cos(half) - half * ops.sin(half)) - cw / 2)
        r_rate = eta * (ops.sin(psi) - psi_rate * ops.sin(2 * x) / 2) / (sw * sw)
        slip = ops.sqrt(r_rate * r_rate)
        arm = eta * ops.sin(psi)
        return Point(
            theta=x,
            load=psi,
            theta_rate=1.0,
            load_rate=psi_rate,
            slip_rate=slip,
            M_N=-arm * cw / sw,
            M_f=arm * r_rate / slip,
            p=0.0,
            s=eta * ops.sin(x - half) / sw,
            q=1.0,
            turn=1.0,
        )

    def inclination(self, psi: Number, ops: Ops) -> Number:
        """Inclination at a bend, before the kinematic lock."""
        sine = ops.smaller(self.eta * psi * ops.cos(psi / 2), 1.0)
        return 2 * ops.atan(sine / (1 + ops.sqrt(1 - sine * sine))) - psi / 2

    def places(self, pt: Point) -> tuple[Number, ...]:  # noqa: ARG002
        """Return no margins: for eta >= 1 the contact never leaves the face."""
        return ()

    def theta(self, x: Number) -> Number:
        """Inclination at the path parameter."""
        return x

    def parameter(self, theta: Number, ops: Ops) -> Number:  # noqa: ARG002
        """Path parameter of an inclination."""
        return theta

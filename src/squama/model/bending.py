r"""Bending: the tip's corner B of a scale on the face of the next scale (docs, theory: bending).

This is the contact BF of ``squama.model.screw`` without twist, as a function of the inclination; no other contact
comes in before a lock. With psi = 2 h the bend per pitch, c and s cosine and sine of theta, and lam the height of the
scales' face over the line that keeps its length, the corner lies in the face where

.. math::
    c \sin h + s \cos\alpha \cos h &= \psi (A_1 \cos h + A_2 \sin h), \\
    A_1 &= \eta \cos\alpha + \beta c \sin\alpha + \lambda s \cos\alpha, \\
    A_2 &= \eta c s \sin^2\alpha - \beta s \sin\alpha \cos\alpha + \lambda c .
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from squama.model.paths import Ops, Point
from squama.model.reach import SEARCH
from squama.model.twisting import Number


class Meeting(NamedTuple):
    """Left minus right side of the contact condition at a bend, and its derivatives with respect to psi and theta."""

    G: Number
    G_psi: Number
    G_theta: Number


class Bend(NamedTuple):
    """Corner on face, with path parameter x = theta; lengths in pitches, ``lam`` from the line that keeps its length.

    There is only one force law; the argument ``law`` of the methods has no effect.
    """

    eta: Number
    beta: Number
    lam: Number
    sa: Number
    ca: Number
    theta0: Number

    def meeting(self, psi: Number, s: Number, c: Number, ops: Ops) -> Meeting:
        """Return the contact condition at a bend ``psi`` (rad) and sine and cosine of an inclination."""
        eta, beta, lam, sa, ca, _ = self
        sh, ch = ops.sin(psi / 2), ops.cos(psi / 2)
        A1, A2 = self.levers(s, c)
        by_theta = sa * (eta * sa * (c * c - s * s) - beta * ca * c) - lam * s
        arm = A1 * ch + A2 * sh
        G_psi = (c * ch - ca * s * sh) / 2 - arm - psi / 2 * (A2 * ch - A1 * sh)
        G_theta = ca * c * ch - s * sh - psi * ((lam * ca * c - beta * sa * s) * ch + by_theta * sh)
        return Meeting(c * sh + ca * s * ch - psi * arm, G_psi, G_theta)

    def levers(self, s: Number, c: Number) -> tuple[Number, Number]:
        """Return A_1 and A_2 of the contact condition."""
        eta, beta, lam, sa, ca, _ = self
        return eta * ca + beta * sa * c + lam * ca * s, s * sa * (eta * sa * c - beta * ca) + lam * c

    def off(self, psi: Number, x: Number, ops: Ops) -> tuple[Number, Number]:
        """Return the contact condition at bend ``psi`` and inclination ``x``, 0 in contact, and its derivative by x."""
        m = self.meeting(psi, ops.sin(x), ops.cos(x), ops)
        return m.G, m.G_theta

    def bend(self, s: Number, c: Number, ops: Ops) -> Number:
        """Return the smallest bend per pitch (rad) with the corner in the face, by Newton's method; NaN for none."""
        A1, A2 = self.levers(s, c)
        # to the second order in psi
        b = A1 - c / 2
        psi = 2 * self.ca * s / (b + ops.sqrt(b * b + 2 * A2 * self.ca * s))
        for _ in range(8):
            m = self.meeting(psi, s, c, ops)
            step = m.G / m.G_psi
            psi = psi - step
            if np.all(abs(step) <= 1e-12 * abs(psi)):
                break
        return psi

    def point(self, x: Number, law: str, ops: Ops) -> Point:  # noqa: ARG002
        """Return the contact at the inclination ``x``; ``turn`` > 0 up to the line contact of the plates."""
        eta, beta, lam, sa, ca, _ = self
        s, c = ops.sin(x), ops.cos(x)
        psi = self.bend(s, c, ops)
        m = self.meeting(psi, s, c, ops)
        sh, ch = ops.sin(psi / 2), ops.cos(psi / 2)
        S, v, off = 2 * sh * ch, 2 * sh * sh, lam - 1 / psi
        C, flat = 1 - v, c * c * ca * ca + s * s
        psi_rate = -m.G_theta / m.G_psi
        # the corner in the face, along and across it: derivatives where theta grows, and on the way
        along = off * (c * ca * S - s * v) - beta * sa * (c * ca * v + s * S) + eta * (1 - v * flat)
        across = beta - sa * (beta * sa * v - off * S + eta * (c * ca * v - s * S))
        lift, turn = eta * (ca * S - c * s * sa * sa * v), eta * sa * (s * ca * v + c * S)
        by_psi = (c * ca * S - s * v) / (psi * psi) + off * (c * ca * C - s * S)
        slid = lift + psi_rate * (by_psi - beta * sa * (c * ca * S + s * C) - eta * S * flat)
        rolled = S / (psi * psi) + off * C - beta * sa * S - eta * (c * ca * S - s * C)
        aside = turn + psi_rate * sa * rolled
        slip = ops.sqrt(slid * slid + aside * aside)
        return Point(
            theta=x,
            load=psi,
            theta_rate=1.0,
            load_rate=psi_rate,
            slip_rate=slip,
            M_N=-2 * sh / psi * m.G_theta,
            M_f=(slid * lift + aside * turn) / slip,
            p=across,
            s=along,
            q=1.0,
            turn=c * ch - ca * s * sh,
        )

    def places(self, pt: Point) -> tuple[Number, Number]:
        """Return the margins of the bend below its limit and of the contact's place on the face."""
        along, across = self.eta / 2 - abs(pt.s - self.eta / 2), self.beta + pt.p
        return SEARCH - pt.load, (along + across - abs(along - across)) / 2

    def theta(self, x: Number) -> Number:
        """Return the inclination (rad) at the path parameter."""
        return x

    def parameter(self, theta: Number, ops: Ops) -> Number:  # noqa: ARG002
        """Return the path parameter of an inclination (rad)."""
        return theta

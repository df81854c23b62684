"""The path that a contact follows: a row for each kind of contact, all with the same interface.

A row is a named tuple of ratios (floats or arrays; lengths in units of the pitch). Its ``point(x, law, ops)`` returns
the contact at the path parameter x: inclination, load angle per pitch (twist phi or bend psi), their rates, the slip
rate and the moments per unit force. Balance, locks, torque, work and RED are the same for every row
(:mod:`squama.model.mechanics`).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from squama.model import twisting
from squama.model.laws import moments
from squama.model.twisting import Number


class Ops(NamedTuple):
    """Elementary functions of one number type; ``sincos`` returns sine and cosine of an angle below half a turn."""

    sqrt: Callable[[Number], Number]
    sin: Callable[[Number], Number]
    cos: Callable[[Number], Number]
    tan: Callable[[Number], Number]
    atan: Callable[[Number], Number]
    sincos: Callable[[Number], tuple[Number, Number]]
    larger: Callable[[Number, Number], Number] = max
    smaller: Callable[[Number, Number], Number] = min


def by_tangent(tan: Callable[[Number], Number]) -> Callable[[Number], tuple[Number, Number]]:
    """Return a function for sine and cosine by the tangent of half the angle, which is faster for arrays."""

    def sincos(x: Number) -> tuple[Number, Number]:
        t = tan(0.5 * x)
        w = 2 / (1 + t * t)
        return t * w, w - 1

    return sincos


NEXT = 1
"""Neighbour k of a row whose lengths are in units of k pitches."""
ARRAY = Ops(np.sqrt, np.sin, np.cos, np.tan, np.arctan, by_tangent(np.tan), np.maximum, np.minimum)
FLOAT = Ops(
    lambda x: math.sqrt(x) if x >= 0 else math.nan,
    *(math.sin, math.cos, math.tan, math.atan, lambda x: (math.sin(x), math.cos(x))),
)


class Point(NamedTuple):
    """A contact on its path; rates are per unit of the path parameter, lengths in pitches.

    ``theta``, ``load`` (phi or psi, per pitch), ``theta_rate``, ``load_rate``, ``slip_rate`` (>= 0), ``M_N``, ``M_f``
    moments of a unit normal and friction force pair about the base line, ``p``, ``s`` places of the contact on the
    tip edge and along the other scale, ``q`` root of the contact condition, ``turn`` > 0 while the
    twist is below half a turn per pitch.
    """

    theta: Number
    load: Number
    theta_rate: Number
    load_rate: Number
    slip_rate: Number
    M_N: Number
    M_f: Number
    p: Number
    s: Number
    q: Number
    turn: Number


class Twist(NamedTuple):
    """Tip edge on the side edge of neighbour k, with path parameter x = theta (for paths without a fold)."""

    eta: Number
    beta: Number
    lam: Number
    sa: Number
    ca: Number
    theta0: Number
    k: Number = NEXT
    thickness: Number = 0.0

    @property
    def ratios(self) -> tuple[Number, ...]:
        """``sa, ca, eta, beta, lam, ts`` in units of k pitches, the arguments of :mod:`squama.model.twisting`."""
        return self.sa, self.ca, self.eta / self.k, self.beta / self.k, self.lam / self.k, self.thickness / self.k

    def root(self, theta: Number, ops: Ops) -> twisting.Root:
        """Return the terms of the contact condition at the inclination ``theta``."""
        return twisting.root(*ops.sincos(theta), *self.ratios)

    def solve(self, x: Number, ops: Ops) -> tuple[Number, twisting.Root, Number, Number]:
        """Return inclination, terms of the contact condition, its root, and the factor to rates per x."""
        return self.solve_at(x, *ops.sincos(x), ops)

    def solve_at(self, x: Number, sn: Number, cs: Number, ops: Ops) -> tuple[Number, twisting.Root, Number, Number]:
        """Return the results of :meth:`solve` from sine and cosine of the inclination."""
        r = twisting.root(sn, cs, *self.ratios)
        q = ops.sqrt(r.q2)
        return x, r, q, 1 / q

    def point(self, x: Number, law: str, ops: Ops) -> Point:
        """Return the contact at the inclination ``x`` on the branch that starts at engagement."""
        return self.at_root(*self.solve(x, ops), law, ops)

    def at_root(self, theta: Number, r: twisting.Root, q: Number, per_x: Number, law: str, ops: Ops) -> Point:
        """Return the contact at the root ``q``; ``per_x`` converts the rates of twisting into rates per unit of x."""
        ratios = self.ratios
        c = twisting.contact(r, q, *ratios)
        m = moments(law, c, ratios[2], ops.sqrt)
        k = self.k
        return Point(
            theta,
            2 * ops.atan(c.u) / k,
            q * per_x,
            c.phi_rate * per_x / k,
            m.slip_rate * per_x * k,
            m.M_N * k,
            m.M_f * k,
            c.p * k,
            c.s * k,
            q,
            r.H + q,
        )

    def places(self, pt: Point) -> tuple[Number, Number]:
        """Return the margins of the place on the tip edge and on the side edge."""
        return self.beta - abs(pt.p), self.eta / 2 - abs(pt.s - self.eta / 2)

    def theta(self, x: Number) -> Number:
        """Return the inclination at the path parameter."""
        return x

    def parameter(self, theta: Number, ops: Ops) -> Number:  # noqa: ARG002
        """Return the path parameter of an inclination on the branch that starts at engagement."""
        return theta


class FoldedTwist(NamedTuple):
    """Tip edge on side edge, followed through a fold at ``theta_f``: theta = theta_f - x^2, x from below to above 0.

    q^2 = x^2 E with E the divided difference of q^2 between theta and theta_f, so q = -x sqrt(E) keeps its digits and
    its sign at the fold.
    """

    eta: Number
    beta: Number
    lam: Number
    sa: Number
    ca: Number
    theta0: Number
    theta_f: Number
    k: Number = NEXT
    thickness: Number = 0.0

    @property
    def open(self) -> Twist:
        """The row of the same contact without its fold."""
        return Twist(self.eta, self.beta, self.lam, self.sa, self.ca, self.theta0, self.k, self.thickness)

    def solve(self, x: Number, ops: Ops) -> tuple[Number, twisting.Root, Number, Number]:
        """Return inclination, terms of the contact condition, its root, and the factor to rates per x."""
        return self.solve_from(self.open.root(self.theta_f, ops), x, *ops.sincos(self.half(x)), ops)

    def half(self, x: Number) -> Number:
        """Return half the inclination's distance from the fold, (theta - theta_f)/2, never exactly 0."""
        return 1e-300 - x * x / 2

    def solve_from(
        self, f: twisting.Root, x: Number, up: Number, over: Number, ops: Ops
    ) -> tuple[Number, twisting.Root, Number, Number]:
        """Return the results of :meth:`solve` from the terms ``f`` at the fold and sine and cosine of :meth:`half`."""
        row = self.open
        theta = self.theta_f - x * x
        sa, ca, eta, beta, lam, ts = row.ratios
        sinc = up / self.half(x)
        # divided differences between theta and theta_f of sin, cos and the terms built from them
        d_sn, d_cs = (f.cs * over - f.sn * up) * sinc, -(f.sn * over + f.cs * up) * sinc
        r = twisting.root(f.sn - x * x * d_sn, f.cs - x * x * d_cs, sa, ca, eta, beta, lam, ts)
        d_S, S = ca * d_sn, ca * f.sn
        d_H = sa * lam * d_sn + ca * (beta - sa) * d_cs
        d_G = 2 * (d_S * (beta * sa + eta * ca * r.cs) + S * eta * ca * d_cs + lam * (ca * ca - sa * sa) * d_cs)
        d_G = d_G + ts * d_S * (ca * r.sn + S)
        d_q2 = d_H * (r.H + f.H) - d_S * (r.G - r.S) - f.S * (d_G - d_S)
        root_E = ops.sqrt(-d_q2)
        return theta, r, -x * root_E, 2 / root_E

    def point(self, x: Number, law: str, ops: Ops) -> Point:
        """Return the contact at the path parameter ``x``."""
        return self.open.at_root(*self.solve(x, ops), law, ops)

    def places(self, pt: Point) -> tuple[Number, Number]:
        """Return the margins of the place on the tip edge and on the side edge."""
        return self.open.places(pt)

    def theta(self, x: Number) -> Number:
        """Return the inclination at the path parameter."""
        return self.theta_f - x * x

    def parameter(self, theta: Number, ops: Ops) -> Number:
        """Return the path parameter of an inclination on the branch that starts at engagement."""
        return -ops.sqrt(self.theta_f - theta)

"""Plain vectors over any number type, the rigid scales, and numerical derivatives.

`ctx` is a namespace of functions: `mpmath.fp` (floats), `numpy` (arrays) or `MP` (30 digits).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import mpmath
import numpy as np

MP = mpmath.mp.clone()
"""A private mpmath context (30 digits), so that no test changes another one's precision."""
MP.dps = 30
FP = mpmath.fp
NP = np

Num = Any
Ctx = Any
Vec = tuple[Num, Num, Num]
STEP = 2.0**-200  # complex step: error STEP**2, no cancellation


def add(u: Vec, v: Vec) -> Vec:
    return (u[0] + v[0], u[1] + v[1], u[2] + v[2])


def sub(u: Vec, v: Vec) -> Vec:
    return (u[0] - v[0], u[1] - v[1], u[2] - v[2])


def mul(c: Num, v: Vec) -> Vec:
    return (c * v[0], c * v[1], c * v[2])


def dot(u: Vec, v: Vec) -> Num:
    return u[0] * v[0] + u[1] * v[1] + u[2] * v[2]


def cross(u: Vec, v: Vec) -> Vec:
    return (u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0])


def triple(u: Vec, v: Vec, w: Vec) -> Num:
    return dot(u, cross(v, w))


def norm(ctx: Ctx, v: Vec) -> Num:
    return ctx.sqrt(dot(v, v))


def unit(ctx: Ctx, v: Vec) -> Vec:
    return mul(1 / norm(ctx, v), v)


@dataclass(frozen=True)
class Design:
    """A scale-covered beam; lengths in pitches, angles in radians.

    `sense` = -1 twists the other way (really: the rotations turn round, and the tip edge meets the
    other side edge). `k` is the neighbour whose side edge scale 1 rests on.
    """

    eta: Num
    alpha: Num
    beta: Num
    lam: Num
    theta0: Num
    sense: int = 1
    k: int = 1

    @classmethod
    def of(cls, eta: float, alpha_deg: float, beta: float, lam: float, theta0_deg: float, sense: int = 1) -> Design:
        """Make a 30-digit design from decimals, angles in degrees."""
        e, a, b, m, t = (MP.mpf(str(x)) for x in (eta, alpha_deg, beta, lam, theta0_deg))
        return cls(e, a * MP.pi / 180, b, m, t * MP.pi / 180, sense)

    def floats(self) -> Design:
        """Return the same design in doubles."""
        e, a, b, m, t = (float(x) for x in (self.eta, self.alpha, self.beta, self.lam, self.theta0))
        return Design(e, a, b, m, t, self.sense, self.k)

    def with_k(self, k: int) -> Design:
        return replace(self, k=k)


@dataclass(frozen=True)
class Scale:
    """Axes, base midpoint, tip midpoint and corners of one rigid scale."""

    x: Vec
    y: Vec
    z: Vec
    base: Vec
    tip: Vec
    D: Vec
    A: Vec
    C: Vec
    B: Vec


def rotated(ctx: Ctx, v: Vec, angle: Num) -> Vec:
    """R(angle) v, about the torsion axis."""
    c, s = ctx.cos(angle), ctx.sin(angle)
    return (c * v[0] + s * v[1], c * v[1] - s * v[0], v[2])


def scale(ctx: Ctx, d: Design, theta: Num, phi: Num, j: int) -> Scale:
    """Scale 1 + j at inclination theta and twist phi per pitch."""
    ca, sa, ct, st = ctx.cos(d.alpha), ctx.sin(d.alpha), ctx.cos(theta), ctx.sin(theta)
    turn = j * d.sense * phi
    x = rotated(ctx, (-sa * ct, st, ca * ct), turn)
    y = rotated(ctx, (ca, 0 * st, sa), turn)
    o = rotated(ctx, (0 * st, d.lam + 0 * st, 0 * st), turn)
    base = (o[0], o[1], o[2] + j)
    tip = add(base, mul(d.eta, x))
    half = mul(d.beta, y)
    return Scale(x, y, cross(x, y), base, tip, sub(base, half), add(base, half), sub(tip, half), add(tip, half))


def along(fun: Callable[[Num, Num], Any], theta: Num, phi: Num, dtheta: Num, dphi: Num) -> Any:
    """Directional derivative of `fun(theta, phi)` (a number or nested tuple), by complex step."""

    def imag(v: Any) -> Any:
        return tuple(imag(c) for c in v) if isinstance(v, tuple) else v.imag / STEP

    return imag(fun(theta + 1j * STEP * dtheta, phi + 1j * STEP * dphi))

"""Twisting from the definitions: contact as a triple product, forces as vectors, rates by differentiation.

Every function works at one point (theta, phi) of the path and for any number type (see `vectors`).
Numbers come back in the units of theory.md: lengths in d, N and f times l / K_theta, torque over K_theta.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .vectors import (
    FP,
    MP,
    Ctx,
    Design,
    Num,
    Scale,
    Vec,
    add,
    along,
    cross,
    dot,
    mul,
    norm,
    scale,
    sub,
    triple,
    unit,
)

LAWS = ("plate", "edge")


def side(d: Design, s: Scale) -> Vec:
    """Base corner of the side edge that the tip edge comes to rest on (D, or A twisting the other way)."""
    return s.D if d.sense > 0 else s.A


def condition(ctx: Ctx, d: Design, theta: Num, phi: Num) -> Num:
    """F: negative while tip edge and side edge are apart, zero at contact."""
    one, two = scale(ctx, d, theta, phi, 0), scale(ctx, d, theta, phi, d.k)
    return triple(sub(one.tip, side(d, two)), one.y, two.x)


def places(ctx: Ctx, d: Design, theta: Num, phi: Num) -> tuple[Num, Num]:
    """(p, s): places on the tip edge and the side edge of the common normal, by Cramer's rule.

    p is counted along +n_Y of scale 1 (twisting the other way: along -n_Y, as the mirror image has it).
    """
    one, two = scale(ctx, d, theta, phi, 0), scale(ctx, d, theta, phi, d.k)
    m = cross(one.y, two.x)
    e = sub(side(d, two), one.tip)
    det = triple(one.y, two.x, m)
    return d.sense * triple(e, two.x, m) / det, -triple(one.y, e, m) / det


def gradient(ctx: Ctx, d: Design, theta: Num, phi: Num) -> tuple[Num, Num]:
    """(dF/dtheta, dF/dphi), by complex step."""

    def f(t: Num, q: Num) -> Num:
        return condition(ctx, d, t, q)

    return along(f, theta, phi, 1, 0), along(f, theta, phi, 0, 1)


def tangent(ctx: Ctx, d: Design, theta: Num, phi: Num) -> tuple[Num, Num]:
    """Direction (theta', phi') of the path, phi growing: regular at a fold and at the kinematic lock."""
    f_theta, f_phi = gradient(ctx, d, theta, phi)
    return f_phi, -f_theta


def phi(theta: Num, d: Design, branch: int = 0) -> Num | None:
    """phi(theta) to 30 digits: the first (0) or second (1, beyond a fold) positive root of F, or None."""
    n = 4000
    grid = np.linspace(0.0, 2 * np.pi / d.k, n + 1)
    f = condition(np, d.floats(), float(theta) + 0 * grid, grid)
    change = np.flatnonzero(np.sign(f[:-1]) * np.sign(f[1:]) < 0)
    if len(change) <= branch:
        return None
    i = int(change[branch])
    df, t = d.floats(), float(theta)
    lo, hi = float(grid[i]), float(grid[i + 1])
    sign = f[i]
    for _ in range(45):
        mid = 0.5 * (lo + hi)
        if condition(FP, df, t, mid) * sign > 0:
            lo = mid
        else:
            hi = mid
    return polish_phi(MP.mpf(theta), MP.mpf(0.5 * (lo + hi)), d)


def polish_phi(theta: Num, guess: Num, d: Design) -> Num:
    """Newton on F(theta, .) to 30 digits."""
    q = MP.mpf(guess)
    for _ in range(12):
        step = condition(MP, d, theta, q) / gradient(MP, d, theta, q)[1]
        q -= step
        if abs(step) < 10 * MP.eps:
            break
    return q


@dataclass(frozen=True)
class Contact:
    """Places and rates at one point of the path (per unit theta, as geometry gives them)."""

    p: Num
    s: Num
    dphi_dtheta: Num
    da_dtheta: Num
    dc_dtheta: Num
    dr_dtheta: Num
    """Length of slip per unit |theta|, by the law's own measure: never negative."""
    dr_dphi: Num


@dataclass(frozen=True)
class Forces:
    """Forces and torque at one point of the path."""

    N0: Num
    f0: Num
    torque_energy: Num
    torque_direct: Num
    mu_lock: Num


@dataclass(frozen=True)
class Slip:
    """The two contact points of scale 1, and the slip per unit path parameter at each."""

    x10: Vec
    x12: Vec
    slip10: Vec
    slip12: Vec
    zero: Scale
    one: Scale
    two: Scale


def slips(ctx: Ctx, d: Design, theta: Num, phi: Num) -> Slip:
    """Velocities of the material points in contact: scale 1 less scale 0, and scale 2 less scale 1."""
    p, s = places(ctx, d, theta, phi)
    dtheta, dphi = tangent(ctx, d, theta, phi)

    def point(j: int) -> Vec:
        two = scale(ctx, d, theta, phi, j)
        return add(side(d, two), mul(s, two.x))

    def on_side(j: int) -> Vec:
        def f(t: Num, q: Num) -> Vec:
            sc = scale(ctx, d, t, q, j)
            return add(side(d, sc), mul(s, sc.x))

        return along(f, theta, phi, dtheta, dphi)

    def on_tip(j: int) -> Vec:
        def f(t: Num, q: Num) -> Vec:
            sc = scale(ctx, d, t, q, j)
            return add(sc.tip, mul(d.sense * p, sc.y))

        return along(f, theta, phi, dtheta, dphi)

    return Slip(
        point(0),
        point(d.k),
        sub(on_side(0), on_tip(-d.k)),
        sub(on_side(d.k), on_tip(0)),
        scale(ctx, d, theta, phi, -d.k),
        scale(ctx, d, theta, phi, 0),
        scale(ctx, d, theta, phi, d.k),
    )


def directions(ctx: Ctx, law: str, v: Slip) -> tuple[Vec, Vec, Vec, Vec, Num]:
    """n10, n12, t10, t12 and the length of slip per unit path parameter."""
    if law == "edge":
        n10, n12 = unit(ctx, cross(v.one.x, v.zero.y)), unit(ctx, cross(v.two.x, v.one.y))
        s10, s12 = v.slip10, v.slip12
    else:
        n10, n12 = v.one.z, v.two.z
        s10 = sub(v.slip10, mul(dot(v.slip10, n10), n10))
        s12 = sub(v.slip12, mul(dot(v.slip12, n12), n12))
    return n10, n12, unit(ctx, s10), unit(ctx, s12), norm(ctx, s10)


def unit_forces(ctx: Ctx, law: str, mu: Num, v: Slip) -> tuple[Vec, Vec]:
    """Forces on scale 1 at P10 and P12 for N = 1."""
    n10, n12, t10, t12, _ = directions(ctx, law, v)
    return mul(-1, add(n10, mul(mu, t10))), add(n12, mul(mu, t12))


def lifting(ctx: Ctx, law: str, mu: Num, v: Slip) -> Num:
    """D: moment lifting scale 1 about its base line (axis -n_Y) for N = 1."""
    f10, f12 = unit_forces(ctx, law, mu, v)
    r10, r12 = sub(v.x10, v.one.base), sub(v.x12, v.one.base)
    return -dot(add(cross(r10, f10), cross(r12, f12)), v.one.y)


def drive(ctx: Ctx, d: Design, theta: Num, phi: Num, law: str, mu: Num) -> Num:
    """D at a point of the path: its first zero is the frictional lock."""
    return lifting(ctx, law, mu, slips(ctx, d, theta, phi))


def contact(theta: Num, phi: Num, d: Design, law: str, ctx: Ctx = MP) -> Contact:
    """State of the contact at a point of the path."""
    p, s = places(ctx, d, theta, phi)
    dtheta, dphi = tangent(ctx, d, theta, phi)
    dp, ds = along(lambda t, q: places(ctx, d, t, q), theta, phi, dtheta, dphi)
    dr = directions(ctx, law, slips(ctx, d, theta, phi))[4]
    return Contact(p, s, dphi / dtheta, -ds / dtheta, dp / dtheta, dr / abs(dtheta), dr / dphi)


def forces(theta: Num, phi: Num, d: Design, law: str, mu: Num, ctx: Ctx = MP) -> Forces:
    """Forces at a point of the path, torque from the energy balance and directly from the contact forces.

    The direct torque is the moment about the torsion axis of the contact forces that cross a section:
    k of them, where scale 1 rests on scale 1 + k.
    """
    v = slips(ctx, d, theta, phi)
    dtheta, dphi = tangent(ctx, d, theta, phi)
    dr = directions(ctx, law, v)[4]
    lift = theta - d.theta0
    n = lift / lifting(ctx, law, mu, v)
    energy = (lift * dtheta + mu * n * dr) / dphi
    f12 = mul(n, unit_forces(ctx, law, mu, v)[1])
    direct = -d.sense * d.k * cross(v.x12, f12)[2]
    free, one = lifting(ctx, law, 0, v), lifting(ctx, law, 1, v)
    return Forces(n * d.eta, mu * n * d.eta, energy, direct, free / (free - one))

"""Work of friction up to the cut-off, the state half way, and what RED is made of."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .path import End, trace
from .twisting import condition, directions, drive, gradient, polish_phi, slips, tangent
from .vectors import MP, Design, Num

LOCKS = ("friction", "kinematic")


def tau(end: End, fraction: Num, theta0: Num) -> tuple[Num, int]:
    """(theta, branch) at a fraction of the path: of theta, or of tau on a path that went through its fold.

    theta = theta_f - tau**2, tau from -sqrt(theta_f - theta0) to +sqrt(theta_f - theta_end).
    """
    if end.theta_f is None:
        return theta0 + fraction * (end.theta - theta0), 0
    first, last = -MP.sqrt(end.theta_f - theta0), MP.sqrt(end.theta_f - end.theta)
    t = first + fraction * (last - first)
    return end.theta_f - t * t, int(t > 0)


def point(d: Design, end: End, fraction: Num) -> tuple[Num, Num]:
    """(theta, phi) at that fraction of the path, to 30 digits."""
    theta, branch = tau(end, fraction, d.theta0)
    points = trace(d, end.phi_e)
    turn = int(np.argmax(points[:, 0]))
    half = points[: turn + 1] if branch == 0 else points[: turn - 1 : -1]
    return theta, polish_phi(theta, float(np.interp(float(theta), half[:, 0], half[:, 1])), d)


def theta_at(d: Design, phi: Num, guess: Num) -> Num:
    """Newton on F(., phi) to working precision: regular through a fold."""
    t = MP.mpf(guess)
    for _ in range(12):
        step = condition(MP, d, t, phi) / gradient(MP, d, t, phi)[0]
        t -= step
        if abs(step) < 10 * MP.eps:
            break
    return t


@dataclass(frozen=True)
class Work:
    """W = W_fr d / K_theta up to (theta_c, phi_c), and the springs' energy there over K_theta / d."""

    W: Num
    theta_c: Num
    phi_c: Num
    spring: Num
    error: Num


def work(d: Design, mu: Num, law: str, end: End, margin: Num = "0.01", *, upto_neighbour: bool = False) -> Work:
    """Integrate f dr from engagement to the cut-off (`d.k` must be `end.k`).

    The pole at a frictional lock is taken out by e - x = (e - start) exp(-u): the integrand in u is smooth.
    `upto_neighbour` stops where the other pair comes in, without margin.
    """
    zero = MP.mpf(0)
    if end.kind == "none" or (end.theta == d.theta0 and end.phi == end.phi_e):
        return Work(zero, d.theta0, end.phi_e, zero, zero)
    stop = end.neighbour if upto_neighbour else None
    if stop is not None:
        theta_c, phi_c = stop.theta, stop.phi
    elif end.kind in LOCKS:
        theta_c, phi_c = point(d, end, 1 - MP.mpf(margin))
    else:
        theta_c, phi_c = end.theta, end.phi
    spring = (theta_c - d.theta0) ** 2 / 2
    if mu == 0:
        return Work(zero, theta_c, phi_c, spring, zero)
    points = trace(d, end.phi_e)
    by_phi = end.theta_f is not None
    if by_phi and end.kind == "kinematic":
        msg = "kinematic lock beyond a fold: no smooth parameter chosen"
        raise NotImplementedError(msg)
    last = len(points) - 1 if by_phi else int(np.argmax(points[:, 0]))
    t_grid, q_grid = points[: last + 1, 0], points[: last + 1, 1]

    def rate(x: Num) -> Num:
        if by_phi:
            q, t = x, theta_at(d, x, float(np.interp(float(x), q_grid, t_grid)))
        else:
            t, q = x, polish_phi(x, float(np.interp(float(x), t_grid, q_grid)), d)
        dt, dq = tangent(MP, d, t, q)
        dr = directions(MP, law, slips(MP, d, t, q))[4]
        n = (t - d.theta0) / drive(MP, d, t, q, law, mu)
        return mu * n * dr / (dq if by_phi else dt)

    start, cut, pole = (end.phi_e, phi_c, end.phi) if by_phi else (d.theta0, theta_c, end.theta)
    digits, MP.dps = MP.dps, 18
    try:
        if end.kind in LOCKS and stop is None:
            span = MP.log((pole - start) / (pole - cut))

            def smooth(u: Num) -> Num:
                rest = (pole - start) * MP.exp(-u)
                return rate(pole - rest) * rest

            W, error = MP.quad(smooth, MP.linspace(0, span, 4), method="gauss-legendre", error=True)
        else:
            W, error = MP.quad(rate, MP.linspace(start, cut, 4), method="gauss-legendre", error=True)
    finally:
        MP.dps = digits
    return Work(W, theta_c, phi_c, spring, error)


def red(w: Work, stiffness: Num) -> Num:
    """RED, for substrate stiffness C_f C_w G_B I / (K_theta d) (U_el holds half of it times phi**2)."""
    total = w.W + w.spring + stiffness * w.phi_c**2 / 2
    return w.W / total if w.W else MP.mpf(0)

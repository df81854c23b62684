"""Bending in the plane (section 6) from plain 2-D vectors.

Base points lie on a circle of curvature psi (arc length 1 per pitch); x along the substrate at scale 1's
base, y out of the scaled face, the substrate curving towards the scales. Scale j is turned by j psi.
"""

from __future__ import annotations

from dataclasses import dataclass

from .vectors import MP, STEP, Num

V2 = tuple[Num, Num]


def _add(u: V2, v: V2) -> V2:
    return (u[0] + v[0], u[1] + v[1])


def _sub(u: V2, v: V2) -> V2:
    return (u[0] - v[0], u[1] - v[1])


def _mul(c: Num, v: V2) -> V2:
    return (c * v[0], c * v[1])


def _dot(u: V2, v: V2) -> Num:
    return u[0] * v[0] + u[1] * v[1]


def _wedge(u: V2, v: V2) -> Num:
    return u[0] * v[1] - u[1] * v[0]


def base(psi: Num, j: int) -> V2:
    """Base point of scale 1 + j."""
    return (MP.sin(j * psi) / psi, (1 - MP.cos(j * psi)) / psi)


def axis(theta: Num, psi: Num, j: int) -> V2:
    """Unit vector up scale 1 + j."""
    return (MP.cos(theta + j * psi), MP.sin(theta + j * psi))


def normal(theta: Num, psi: Num, j: int) -> V2:
    """Unit normal out of the upper face of scale 1 + j."""
    x = axis(theta, psi, j)
    return (-x[1], x[0])


def gap(theta: Num, psi: Num, eta: Num) -> Num:
    """Distance of scale 1's tip behind the face of scale 2 (positive: apart)."""
    tip = _mul(eta, axis(theta, psi, 0))
    return _dot(_sub(tip, base(psi, 1)), normal(theta, psi, 1))


def reach(theta: Num, psi: Num, eta: Num) -> Num:
    """Place r of the contact along scale 2, from its base."""
    tip = _mul(eta, axis(theta, psi, 0))
    return _dot(_sub(tip, base(psi, 1)), axis(theta, psi, 1))


def _d(fun, theta: Num, psi: Num, dtheta: Num, dpsi: Num) -> Num:  # type: ignore[no-untyped-def]
    return fun(theta + 1j * STEP * dtheta, psi + 1j * STEP * dpsi).imag / STEP


def _tangent(theta: Num, psi: Num, eta: Num) -> tuple[Num, Num]:
    """Direction (theta, psi) of the path, theta growing."""
    g_theta = _d(lambda t, q: gap(t, q, eta), theta, psi, 1, 0)
    g_psi = _d(lambda t, q: gap(t, q, eta), theta, psi, 0, 1)
    sign = 1 if g_psi < 0 else -1
    return -sign * g_psi, sign * g_theta


def _root(fun, lo: Num, hi: Num, n: int = 60) -> Num | None:  # type: ignore[no-untyped-def]
    """First change of sign in (lo, hi), refined to 30 digits."""
    step = (hi - lo) / n
    a, fa = lo, fun(lo)
    for i in range(1, n + 1):
        b = lo + i * step
        fb = fun(b)
        if fa * fb <= 0:
            return MP.findroot(fun, (a, b), solver="anderson", tol=1e-58, maxsteps=200)
        a, fa = b, fb
    return None


def psi_of(theta: Num, eta: Num) -> Num | None:
    """Curvature per pitch at which the contact holds (first root), or None."""
    small = MP.mpf("1e-9")
    return _root(lambda q: gap(theta, q, eta), small, MP.pi, 60)


@dataclass(frozen=True)
class Bend:
    """State of the contact in bending; N0, f0 times l / K, moments over K (d = 1)."""

    psi: Num
    r: Num
    dtheta_dpsi: Num
    dr_dpsi: Num
    N0: Num
    f0: Num
    moment_energy: Num
    moment_direct: Num
    mu_lock: Num


def _unit_forces(theta: Num, psi: Num, mu: Num, sense: int) -> tuple[V2, V2]:
    """Forces on scale 1, for N = 1: at its face (from scale 0's tip) and at its tip (from scale 2's face).

    `sense` is the sign of dr/d(path): +1 where the tip of scale 1 slides up the face of scale 2.
    Friction on the tip acts against that, friction on the face of scale 1 with its own visitor.
    """
    x1, y1 = axis(theta, psi, 0), normal(theta, psi, 0)
    x2, y2 = axis(theta, psi, 1), normal(theta, psi, 1)
    on_face = _add(_mul(-1, y1), _mul(mu * sense, x1))
    on_tip = _sub(y2, _mul(mu * sense, x2))
    return on_face, on_tip


def _lift(theta: Num, psi: Num, eta: Num, mu: Num, sense: int) -> Num:
    """Moment that lifts scale 1 about its base, for N = 1."""
    on_face, on_tip = _unit_forces(theta, psi, mu, sense)
    x1 = axis(theta, psi, 0)
    return _wedge(_mul(reach(theta, psi, eta), x1), on_face) + _wedge(_mul(eta, x1), on_tip)


def _slide(theta: Num, psi: Num, eta: Num) -> tuple[Num, int]:
    dt, dq = _tangent(theta, psi, eta)
    dr = _d(lambda t, q: reach(t, q, eta), theta, psi, dt, dq)
    return dr, 1 if dr > 0 else -1


def state(theta: Num, psi: Num, eta: Num, theta0: Num, mu: Num) -> Bend:
    """Forces and moment at a point of the path.

    The direct moment is the power of the contact force on scale 2 through its motion relative to scale 1
    as the curvature grows with theta held.
    """
    dt, dq = _tangent(theta, psi, eta)
    dr, sense = _slide(theta, psi, eta)
    n = (theta - theta0) / _lift(theta, psi, eta, mu, sense)
    energy = ((theta - theta0) * dt + mu * n * abs(dr)) / dq
    r = reach(theta, psi, eta)
    on_two = _mul(-n, _unit_forces(theta, psi, mu, sense)[1])

    def place(q: Num) -> V2:
        return _add(base(q, 1), _mul(r, axis(theta, q, 1)))

    moved = place(psi + 1j * STEP)
    # the beam is made to move: its moment is minus the power that scale 2 receives
    direct = -_dot(on_two, (moved[0].imag / STEP, moved[1].imag / STEP))
    free, one = _lift(theta, psi, eta, 0, sense), _lift(theta, psi, eta, 1, sense)
    return Bend(psi, r, dt / dq, dr / dq, n * eta, mu * n * eta, energy, direct, free / (free - one))


@dataclass(frozen=True)
class BendEnd:
    """kind: none, kinematic or friction (theta = theta0: static lock)."""

    kind: str
    theta: Num
    psi: Num
    psi_e: Num
    mu_static: Num


def path_end(eta: Num, theta0: Num, mu: Num) -> BendEnd:
    """First lock in bending, by root finding on the kinematic and the lifting moment's zero."""
    psi_e = psi_of(theta0, eta)
    if psi_e is None:
        return BendEnd("none", theta0, MP.inf, MP.inf, MP.inf)
    mu_static = state(theta0, psi_e, eta, theta0, mu).mu_lock
    if mu >= mu_static:
        return BendEnd("friction", theta0, psi_e, psi_e, mu_static)

    def stop(theta: Num) -> Num:
        psi = psi_of(theta, eta)
        if psi is None:
            return MP.mpf(-1)
        return _lift(theta, psi, eta, mu, _slide(theta, psi, eta)[1])

    lo, step = theta0, MP.mpf(1) / 10
    while stop(lo + step) > 0:
        lo += step
    psi = psi_of(lo, eta)
    if mu == 0:
        # dpsi/dtheta = 0: the two equations gap = 0 and d gap/d theta = 0 by Newton
        t, q = MP.findroot(lambda t, q: [gap(t, q, eta), _d(lambda a, b: gap(a, b, eta), t, q, 1, 0)], (lo, psi))
        return BendEnd("kinematic", t, q, psi_e, mu_static)
    t, q = MP.findroot(lambda t, q: [gap(t, q, eta), _lift(t, q, eta, mu, _slide(t, q, eta)[1])], (lo, psi))
    return BendEnd("friction", t, q, psi_e, mu_static)

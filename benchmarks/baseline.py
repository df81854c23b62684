"""What a careful SciPy script does for one design: closed-form contact, scan, brentq, quad.

It does the whole job (first neighbour, fold, edges, other neighbours, locks, work at a margin), one design at a
time in plain floats, and shares no code with the package. Edge law, sense "+".
"""

from __future__ import annotations

from collections.abc import Callable
from math import atan2, cos, hypot, inf, pi, sin, sqrt
from typing import NamedTuple

from scipy.integrate import quad
from scipy.optimize import brentq


class Terms(NamedTuple):
    """A cos(phi) + B sin(phi) = G."""

    A: float
    B: float
    G: float


class State(NamedTuple):
    """Contact at one inclination; rates per unit of theta."""

    phi: float
    p: float
    s: float
    dphi: float
    dr: float
    M_N: float
    M_f: float


class Design(NamedTuple):
    """Ratios with lengths in units of k pitches."""

    eta: float
    beta: float
    lam: float
    alpha: float

    def scaled(self, k: int) -> Design:
        """Ratios of neighbour k."""
        return Design(self.eta / k, self.beta / k, self.lam / k, self.alpha)


def terms(theta: float, d: Design) -> Terms:
    """Coefficients of the contact condition."""
    ca, sa, ct, st = cos(d.alpha), sin(d.alpha), cos(theta), sin(theta)
    G = d.beta * sin(2 * d.alpha) * st + d.eta * ca**2 * sin(2 * theta) + 2 * d.lam * cos(2 * d.alpha) * ct
    return Terms(G - 2 * ca * st, 2 * sa * (d.eta + d.lam * st) + 2 * ca * ct * (d.beta - sa), G)


def square(theta: float, d: Design) -> float:
    """Square of the root of the contact condition; 0 at a fold."""
    A, B, G = terms(theta, d)
    return (hypot(A, B) - G) * (hypot(A, B) + G)


def places(theta: float, phi: float, d: Design) -> tuple[float, float]:
    """Places on the tip edge and on the side edge."""
    ca, sa, ct, st, c, sp = cos(d.alpha), sin(d.alpha), cos(theta), sin(theta), cos(phi), sin(phi)
    v = 1 - c
    s = (d.lam * v + d.eta * st - d.beta * ca * sp) / (st * c + sa * ct * sp)
    return s * (v * ca * ct * sa + sp * ca * st) - (d.beta * (c + v * sa * sa) - d.lam * ca * sp - sa), s


def state(theta: float, d: Design, branch: int = 1) -> State | None:
    """Contact at an inclination; None beyond a fold."""
    A, B, G = terms(theta, d)
    sq = (hypot(A, B) - G) * (hypot(A, B) + G)
    if sq <= 0:
        return None
    phi = atan2(B, A) - branch * atan2(sqrt(sq), G)
    ca, sa, ct, st, c, sp = cos(d.alpha), sin(d.alpha), cos(theta), sin(theta), cos(phi), sin(phi)
    v, zX, zZ = 1 - c, ca * ct, -ca * st
    kXX, kYY, kYX = c + v * zX * zX, c + v * sa * sa, v * zX * sa - sp * zZ
    kYZ, kZX = v * sa * zZ + sp * zX, v * zX * zZ + sp * sa
    p, s = places(theta, phi, d)
    J2 = 1 - kYX * kYX
    dphi = (d.eta * kXX - s * kYY) / (branch * sqrt(sq) / 2)
    b1 = dphi * (d.beta * ca * st - d.lam * sa * ct) - d.eta * kZX
    b2 = dphi * ca * (d.lam + d.eta * st) + s * kYZ
    c_rate, a_rate = (b2 - kYX * b1) / J2, (b1 - kYX * b2) / J2
    dr = sqrt(a_rate * b1 + c_rate * b2)
    M_f = -branch * (d.eta * a_rate * kZX - s * c_rate * kYZ) / dr
    return State(phi, p, s, dphi, dr, -(d.eta * kXX - s * kYY) / sqrt(J2), M_f)


def engagement(theta0: float, d: Design) -> tuple[int, float]:
    """Neighbour that is met first, and its twist; 0 and inf for none."""
    best = (0, inf)
    for k in range(1, max(1, int(hypot(d.eta, 2 * d.beta))) + 1):
        near = d.scaled(k)
        st = state(theta0, near)
        if st and st.phi > 0 and abs(st.p) <= near.beta and 0 <= st.s <= near.eta and st.phi / k < best[1]:
            best = (k, st.phi / k)
    return best


def first_event(f: Callable[[float], float], a: float, b: float, steps: int) -> float:
    """First zero of f between a and b; b where there is none."""
    x = a
    for i in range(1, steps + 1):
        y = a + (b - a) * i / steps
        if f(y) <= 0:
            return float(brentq(f, x, y, xtol=1e-15, rtol=1e-14))
        x = y
    return b


def crossing(at: Callable[[float], tuple[float, float]], d: Design, j: int, a: float, b: float, steps: int) -> float:
    """First place where the tip-side pair of neighbour j comes in; inf for none."""
    near = d.scaled(j)

    def gap(x: float) -> float:
        theta, phi = at(x)
        A, B, G = terms(theta, near)
        return A * cos(j * phi) + B * sin(j * phi) - G

    x, fx = a, gap(a)
    for i in range(1, steps + 1):
        y = a + (b - a) * i / steps
        fy = gap(y)
        if fx < 0 <= fy:
            root = brentq(gap, x, y, xtol=1e-15, rtol=1e-14)
            theta, phi = at(root)
            p, s = places(theta, j * phi, near)
            if abs(p) <= near.beta and 0 <= s <= near.eta:
                return float(root)
        x, fx = y, fy
    return inf


def solve(d: Design, theta0: float, mu: float, *, work: bool) -> tuple[float, float, float, float]:
    """Return phi_e, theta_end, phi_end and, if asked, the frictional work at a margin of 1 %."""
    k, phi_e = engagement(theta0, d)
    if k == 0:
        return inf, theta0, inf, 0.0
    near = d.scaled(k)

    def lowest(st: State | None, branch: int = 1) -> float:
        if st is None:
            return -1.0
        margins = (st.dphi * branch, -(st.M_N + mu * st.M_f), near.beta - abs(st.p), near.eta - st.s, st.s)
        return min(margins)

    if lowest(state(theta0, near)) <= 0:
        return phi_e, theta0, phi_e, 0.0
    top = pi * 179 / 180
    fold = first_event(lambda theta: square(theta, near), theta0, top, 48)
    if (
        fold < top
        and lowest(state(first_event(lambda t: lowest(state(t, near)), theta0, fold * (1 - 1e-9), 32), near)) > 1e-6
    ):
        # no end before the fold: theta = fold - x^2
        def inclination(x: float) -> float:
            return fold - max(x * x, 1e-14)

        def branch(x: float) -> int:
            return 1 if x < 0 else -1

        a, b, steps = -sqrt(fold - theta0), sqrt(fold - theta0), 64
    else:

        def inclination(x: float) -> float:
            return x

        def branch(x: float) -> int:  # noqa: ARG001
            return 1

        a, b, steps = theta0, top, 48

    def at(x: float) -> tuple[float, float]:
        theta = inclination(x)
        st = state(theta, near, branch(x))
        return theta, (st.phi if st else inf) / k

    end = first_event(lambda x: lowest(state(inclination(x), near, branch(x)), branch(x)), a, b, steps)
    for j in range(1, max(1, int(hypot(d.eta, 2 * d.beta))) + 1):
        if j != k:
            end = min(end, crossing(at, d, j, a, end - 1e-13, 16))
    theta_end, phi_end = at(end - 1e-15)

    def density(x: float) -> float:
        st = state(inclination(x), near, branch(x))
        rate = 1.0 if steps == 48 else abs(2 * x)
        return -mu * (inclination(x) - theta0) / (st.M_N + mu * st.M_f) * st.dr * rate if st else 0.0

    total = quad(density, a, a + 0.99 * (end - a), epsrel=1e-9, limit=200)[0] if work else 0.0
    return phi_e, theta_end, phi_end, total


def naive_twist(theta: float, d: Design) -> float | None:
    """Smallest twist at which the contact condition holds, searched for."""
    A, B, G = terms(theta, d)

    def condition(phi: float) -> float:
        return A * cos(phi) + B * sin(phi) - G

    for i in range(200):
        if condition(i * pi / 200) < 0 <= condition((i + 1) * pi / 200):
            return float(brentq(condition, i * pi / 200, (i + 1) * pi / 200))
    return None


def naive_state(theta: float, d: Design) -> State | None:
    """Contact at an inclination; the rate of twist is a difference."""
    h = 1e-6
    phi, before, after = naive_twist(theta, d), naive_twist(theta - h, d), naive_twist(theta + h, d)
    if phi is None or before is None or after is None:
        return None
    dphi = (after - before) / (2 * h)
    ca, sa, ct, st, c, sp = cos(d.alpha), sin(d.alpha), cos(theta), sin(theta), cos(phi), sin(phi)
    v, zX, zZ = 1 - c, ca * ct, -ca * st
    kXX, kYY, kYX = c + v * zX * zX, c + v * sa * sa, v * zX * sa - sp * zZ
    kYZ, kZX = v * sa * zZ + sp * zX, v * zX * zZ + sp * sa
    p, s = places(theta, phi, d)
    J2 = 1 - kYX * kYX
    b1 = dphi * (d.beta * ca * st - d.lam * sa * ct) - d.eta * kZX
    b2 = dphi * ca * (d.lam + d.eta * st) + s * kYZ
    c_rate, a_rate = (b2 - kYX * b1) / J2, (b1 - kYX * b2) / J2
    dr = sqrt(max(a_rate * b1 + c_rate * b2, 1e-300))
    M_f = -(d.eta * a_rate * kZX - s * c_rate * kYZ) / dr
    return State(phi, p, s, dphi, dr, -(d.eta * kXX - s * kYY) / sqrt(J2), M_f)


def naive(d: Design, theta0: float, mu: float, *, work: bool) -> tuple[float, float, float, float]:
    """Return what :func:`solve` returns, for the next neighbour and without folds, as one writes it first."""
    first = naive_state(theta0, d)
    if first is None:
        return inf, theta0, inf, 0.0

    def lowest(theta: float) -> float:
        st = naive_state(theta, d)
        if st is None:
            return -1.0
        return min(st.dphi, -(st.M_N + mu * st.M_f), d.beta - abs(st.p), d.eta - st.s, st.s)

    def density(theta: float) -> float:
        st = naive_state(theta, d)
        return -mu * (theta - theta0) / (st.M_N + mu * st.M_f) * st.dr if st else 0.0

    if lowest(theta0) <= 0:
        return first.phi, theta0, first.phi, 0.0
    end = first_event(lowest, theta0, pi * 179 / 180, 200)
    last = naive_twist(end, d) or inf
    total = quad(density, theta0, theta0 + 0.99 * (end - theta0), epsrel=1e-9, limit=200)[0] if work else 0.0
    return first.phi, end, last, total

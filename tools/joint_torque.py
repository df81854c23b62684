"""The torque of thick, rigid plates on a joint, for many designs at once: what an error of the joint does to it.

One contact, tip edge of scale 1 on the side edge of scale 2: balance of the scale's six motions and the contact's three
equations by Newton, with derivatives by complex steps, at evenly spaced twists from engagement on; slip from one twist
to the next.
"""

from __future__ import annotations

from collections.abc import Callable
from math import factorial
from typing import NamedTuple

import numpy as np

from squama.joints.law import Shape
from squama.types import Array

MU, STEPS = 0.25, 24


class Torque(NamedTuple):
    """Twist at engagement, torque and motions (n, 9) at the last twist, and whether a path of contacts leads there.

    The stretch is one of the motions where it is free.
    """

    engagement: Array
    torque: Array
    motions: Array
    good: Array


class Plates:
    """Scale 1 and its neighbour, designs along the first axis of all arrays but the last."""

    def __init__(self, shape: Shape, eta: Array, mu: float) -> None:
        self.mu = mu
        a, t, zero = shape.alpha, shape.theta0, 0 * shape.alpha
        up = np.stack([-np.sin(a) * np.cos(t), np.sin(t), np.cos(a) * np.cos(t)], -1)
        across = np.stack([np.cos(a), zero, np.sin(a)], -1)
        self.axes = np.stack([up, across, np.cross(up, across)], -1)
        self.base = np.stack([zero, shape.lam, zero], -1)
        self.eta, self.beta, self.half = eta, shape.beta, shape.thickness / 2

    def contact(self, q: Array, phi: Array, p: Array, s: Array) -> tuple[Array, ...]:
        """Return the gap D of the two points, its rates with q and phi, and the tangents of the two edges.

        q are six motions, or these and the stretch.
        """
        turned, rates = rotation(q[..., 3:6])
        one = 0 * p + 1
        tip = applied(turned, np.stack([self.eta * one, p, -self.half * one], -1))
        side = applied(turned, np.stack([s, -self.beta * one, self.half * one], -1))
        c, z = np.cos(phi), 0 * phi
        sin = np.sin(phi)
        R = np.stack([np.stack(row, -1) for row in ((c, sin, z), (-sin, c, z), (z, z, z + 1))], -2)
        dR = np.stack([np.stack(row, -1) for row in ((-sin, c, z), (-c, -sin, z), (z, z, z))], -2)
        first = self.base + applied(self.axes, q[..., :3] + tip)
        second = self.base + applied(self.axes, q[..., :3] + side)
        moves = [
            np.concatenate([np.broadcast_to(self.axes, (*x.shape, 3)), -self.axes @ crossing(x) @ rates], -1)
            for x in (tip, side)
        ]
        apart = np.stack([0 * p, 0 * p, 0 * p + 1 + q[..., 6:].sum(-1)], -1)
        gap = first - applied(R, second) - apart
        edges = applied(self.axes, turned[..., :, 1]), applied(R, applied(self.axes, turned[..., :, 0]))
        with_q = moves[0] - R @ moves[1]
        if q.shape[-1] > 6:
            with_q = np.concatenate([with_q, np.broadcast_to([[0.0], [0.0], [-1.0]], (*p.shape, 3, 1))], -1)
        return gap, with_q, -applied(dR, second), *edges

    def balance(self, K: Array, x: Array, phi: Array, before: Array) -> tuple[Array, Array]:
        """Return what is not balanced at x = (q, p, s, N), and the torque; ``before``: q and phi one step ago.

        K (n, m + 1, m + 1) is over q and phi.
        """
        q, p, s, N = x[..., :-3], x[..., -3], x[..., -2], x[..., -1, None]
        gap, with_q, with_phi, e1, e2 = self.contact(q, phi, p, s)
        n = np.cross(e2, e1)
        n = n / np.sqrt(inner(n, n))
        slip = gap - self.contact(before[..., :-1], before[..., -1], p, s)[0]
        slip = slip - inner(slip, n) * n
        F = N * (n - self.mu * slip / np.sqrt(inner(slip, slip) + 1e-30))
        load = phi[..., None]
        off = applied(K[:, :-1, :-1], q) + K[:, :-1, -1] * load - applied(np.swapaxes(with_q, -1, -2), F)
        torque = inner(K[:, -1, :-1], q) + K[:, -1, -1, None] * load - inner(with_phi, F)
        return np.concatenate([off, gap], -1), torque[..., 0]


def torque(
    shape: Shape, K: Array, eta: Array, twist: Array | None = None, mu: float = MU, *, free: bool = False
) -> Torque:  # fmt: skip
    """Return the torque, E d^3, of designs (n,) with K (n, 9, 9) at a twist, else at twice the engagement.

    The bar is not bent, and keeps its length unless its ends are ``free``.
    """
    plates, rows = Plates(shape, eta, mu), [*range(6), *[8] * free, 6]
    K = K[:, rows][:, :, rows]
    own = -np.linalg.solve(K[:, :-1, :-1], K[:, :-1, -1:])[..., 0]
    start = np.stack(hinge(shape, eta), -1)
    met, off = newton(lambda y: plates.contact(own * y[..., :1], y[..., 0], y[..., 1], y[..., 2])[0], start, 15)
    phi = met[:, 0]
    step = ((2 * phi if twist is None else twist) - phi) / STEPS
    x = np.column_stack([own * phi[:, None], met[:, 1:], 0 * phi])
    last = x - np.column_stack([own * step[:, None], np.zeros((len(phi), 2)), np.full(len(phi), 5e-5)])
    for k in range(STEPS):
        before = np.column_stack([x[:, :-3], phi])
        phi = phi + step

        def balance(y: Array, phi: Array = phi, before: Array = before) -> Array:
            return plates.balance(K, y, phi, before)[0]

        new, left = newton(balance, 2 * x - last, 5 if k else 8)
        last, x, off = x, new, np.maximum(off, left)
    # what has run away is not good
    with np.errstate(all="ignore"):
        found = plates.balance(K, x, phi, before)[1]
    p, s, N = x[:, -3:].T
    good = (off < 1e-9) & (np.abs(p) < shape.beta) & (s > 0) & (s < eta) & (N > 0) & (met[:, 0] > 0)
    motions = np.column_stack([x[:, :6], phi, 0 * phi, x[:, 6] if free else 0 * phi])
    return Torque(met[:, 0], found, motions, good)


def hinge(shape: Shape, eta: Array) -> tuple[Array, Array, Array]:
    """Return twist and places p, s at which plates on hinges engage, in closed form (docs, theory: geometry)."""
    _, lam, _, beta, h, a, t, _ = shape
    G = beta * np.sin(2 * a) * np.sin(t) + eta * np.cos(a) ** 2 * np.sin(2 * t) + 2 * lam * np.cos(2 * a) * np.cos(t)
    S, H = np.cos(a) * np.sin(t), np.sin(a) * (eta + lam * np.sin(t)) + np.cos(a) * np.cos(t) * (beta - np.sin(a))
    root = np.sqrt(np.maximum(H**2 - (S - h) * (G - S + h * S**2), 1e-6))
    phi = 2 * np.arctan((S - h) / (H + root))
    s = lam * (1 - np.cos(phi)) + eta * np.sin(t) - beta * np.cos(a) * np.sin(phi)
    return phi, 0 * phi, s / (np.sin(t) * np.cos(phi) + np.sin(a) * np.cos(t) * np.sin(phi))


def newton(f: Callable[[Array], Array], x: Array, steps: int) -> tuple[Array, Array]:
    """Return roots (n, m) of f from x and what is left of f there, the largest entry (n,)."""
    small = 1e-25
    with np.errstate(all="ignore"):
        for _ in range(steps):
            J = np.moveaxis(f(x + 1j * small * np.eye(x.shape[-1])[:, None, :]).imag / small, 0, -1)
            size = np.abs(J).max(-1) + 1e-300
            J = np.where(np.isfinite(J), J / size[..., None], 0) + 1e-14 * np.eye(x.shape[-1])
            x = x - np.linalg.solve(J, (f(x) / size)[..., None])[..., 0]
        left = np.abs(f(x)).max(-1)
    return x, np.where(np.isfinite(left), left, 1.0)


def rotation(w: Array) -> tuple[Array, Array]:
    """Return the rotation by a vector w (.., 3), and the matrix T of its rate, dE E^T = [T dw]x; small angles."""
    W, square = crossing(w), inner(w, w)[..., None]
    one, two, three = (sum((-square) ** k / factorial(2 * k + first) for k in range(9)) for first in (1, 2, 3))
    return np.eye(3) + one * W + two * W @ W, np.eye(3) + two * W + three * W @ W


def crossing(w: Array) -> Array:
    """Return the matrices of w x (.., 3, 3)."""
    x, y, z = np.moveaxis(w, -1, 0)
    o = 0 * x
    return np.stack([np.stack(row, -1) for row in ((o, -z, y), (z, o, -x), (-y, x, o))], -2)


def applied(M: Array, v: Array) -> Array:
    """Return M v of matrices (.., 3, 3) and vectors (.., 3)."""
    return np.asarray((M @ v[..., None])[..., 0])


def inner(a: Array, b: Array) -> Array:
    """Return a . b, (.., 1)."""
    return np.asarray((a * b).sum(-1, keepdims=True))

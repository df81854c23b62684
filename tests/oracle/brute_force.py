"""Brute force: a rigid box on springs among its images; elastic energy and log barriers of distances, minimised.

An endless beam of rigid scales without friction: scale 1 + k is the image of scale 1 under k times the screw of a cell.
Every corner of the one box has a distance to the other box, every edge to every edge; ``-kappa log`` of each keeps them
apart, and with kappa to zero the sum is the energy of scales in contact, whatever touches.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np

from oracle.boxes import Vector, apart

CORNERS = np.array(list(itertools.product((0, 1), (-1, 1), (-1, 1))), float)
EDGES = np.array([(i, j) for i, j in itertools.combinations(range(8), 2) if abs(CORNERS[i] - CORNERS[j]).sum() in (1, 2)
                  and (CORNERS[i] != CORNERS[j]).sum() == 1])  # fmt: skip
CROSSED = np.array(list(itertools.product(range(12), repeat=2)))
COARSE, NEAR = 1e-4, 1e-6
"""kappa at which a path is followed, E d^3, and gap at which its states are told, d."""


def cross(w: Vector) -> Vector:
    """Return the matrix of w x."""
    return np.array([[0, -w[2], w[1]], [w[2], 0, -w[0]], [-w[1], w[0], 0]])


def exponential(w: Vector) -> tuple[Vector, Vector]:
    """Return the rotation by a vector and its left Jacobian, by their series; complex, too."""
    W, R, V, term = cross(w), np.eye(3), np.eye(3), np.eye(3)
    for n in range(1, 30):
        term = term @ W / n
        R, V = R + term, V + term / (n + 1)
    return R, V


@dataclass
class Boxes:
    """A beam: ratios of its scales, and K (9, 9) over (u, w) of scale 1 in its axes, twist, bend and stretch."""

    eta: float
    beta: float
    lam: float
    alpha: float
    theta0: float
    h: float
    K: Vector

    def __post_init__(self) -> None:
        """Keep what is used often."""
        a, t = self.alpha, self.theta0
        X, Y = np.array([-np.sin(a) * np.cos(t), np.sin(t), np.cos(a) * np.cos(t)]), np.array([np.cos(a), 0, np.sin(a)])
        self.axes = np.array([X, Y, np.cross(X, Y)])
        self.half = np.array([self.eta / 2, self.beta, self.h / 2])
        self.corners = CORNERS * [self.eta, self.beta, self.h / 2]
        self.images = range(1, int(np.hypot(self.eta, 2 * self.beta)) + 1)

    def screw(self, strains: Vector, k: int) -> tuple[Vector, Vector]:
        """Return rotation and shift of image k by twist, bend and stretch."""
        R, V = exponential(np.array([-k * strains[1], 0, -k * strains[0]]))
        return R, V @ np.array([0, 0, k * (1 + strains[2])])

    def placed(self, z: Vector) -> tuple[Vector, Vector, Vector]:
        """Return attitude (its axes in rows), the left Jacobian, and the corners of scale 1."""
        E, V = exponential(z[3:6])
        turned = E.T @ self.axes
        return turned, V, np.array([0, self.lam, 0]) + z[:3] @ self.axes + self.corners @ turned

    def gap(self, z: Vector) -> float:
        """Return the least gap of the boxes, below 0 where they overlap."""
        turned, _, points = self.placed(z)
        middle = points.mean(axis=0)
        gaps = []
        for k in self.images:
            R, t = self.screw(z[6:], k)
            gaps.append(apart(self.half, R @ middle + t - middle, turned, turned @ R.T))
        return float(min(gaps))

    def closest(self, p: Vector, axes: Vector, points: Vector) -> tuple[Vector, Vector]:
        """Return the weights (8, 8) by corners of the places of a box that are closest to points, and these places."""
        base = points[:4].mean(axis=0)
        x = np.clip((p - base) @ axes.T, [0, -self.beta, -self.h / 2], [self.eta, self.beta, self.h / 2])
        s = np.column_stack([x[:, 0] / self.eta, (1 + x[:, 1] / self.beta) / 2, 0.5 + x[:, 2] / self.h])
        up = np.array([CORNERS[:, 0], (1 + CORNERS[:, 1]) / 2, (1 + CORNERS[:, 2]) / 2])
        weights = np.prod(np.where(up[None] > 0, s[:, :, None], 1 - s[:, :, None]), axis=1)
        return weights, base + x @ axes

    def pairs(self, k: int, z: Vector) -> tuple[Vector, Vector, Vector, Vector]:
        """Return weights (n, 8) of places on box 1 and on image k, by corners, unit vectors between, and distances."""
        turned, _, one = self.placed(z)
        R, t = self.screw(z[6:], k)
        other, same = one @ R.T + t, np.eye(8)
        a, xa = self.closest(one, turned @ R.T, other)
        b, xb = self.closest(other, turned, one)
        s, r = crossing(one, other)
        e, f = EDGES[CROSSED[:, 0]], EDGES[CROSSED[:, 1]]
        first = same[e[:, 0]] * (1 - s[:, None]) + same[e[:, 1]] * s[:, None]
        second = same[f[:, 0]] * (1 - r[:, None]) + same[f[:, 1]] * r[:, None]
        A, B = np.concatenate([same, b, first]), np.concatenate([a, same, second])
        way = np.concatenate([one - xa, xb - other, first @ one - second @ other])
        d = np.sqrt((way**2).sum(axis=1))
        return A, B, way / d[:, None], d

    def energy(self, z: Vector, kappa: float) -> tuple[float, Vector, Vector]:
        """Return energy with barriers, its gradient by (u, w), and its parts' with 1 / d^2 for the second one."""
        U, g, H = z @ self.K @ z / 2, (self.K @ z)[:6], self.K[:6, :6].copy()
        moved = self.moved(z)
        for k in self.images:
            A, B, n, d = self.pairs(k, z)
            R = self.screw(z[6:], k)[0]
            ways = np.einsum("ap,ai,pij->aj", A, n, moved) - np.einsum("ap,ai,pij->aj", B, n @ R, moved)
            U -= kappa * np.log(d).sum()
            g -= kappa / d @ ways
            H += (ways * (kappa / d**2)[:, None]).T @ ways
        return float(U), g, H

    def moved(self, z: Vector) -> Vector:
        """Return how corners move with (u, w)."""
        _, V, one = self.placed(z)
        arms = one - (np.array([0, self.lam, 0]) + z[:3] @ self.axes)
        turns = [-cross(arm) @ self.axes.T @ V for arm in arms]
        return np.array([np.column_stack([self.axes.T, turn]) for turn in turns])

    def curved(self, z: Vector, kappa: float) -> Vector:
        """Return what the curvature of the distances adds to the second derivatives: forces stay, directions change."""
        e, H = 1e-2 * self.gap(z), np.empty((6, 6))
        e = min(e, 1e-6)
        held = [kappa / self.pairs(k, z)[3] for k in self.images]
        for i in range(6):
            sides = []
            for sign in (1, -1):
                near = z.copy()
                near[i] += sign * e
                moved, g = self.moved(near), np.zeros(6)
                for k, F in zip(self.images, held, strict=True):
                    A, B, n, _ = self.pairs(k, near)
                    R = self.screw(near[6:], k)[0]
                    on, off = A.T @ (F[:, None] * n), B.T @ (F[:, None] * n)
                    g -= np.einsum("pi,pij->j", on - off @ R, moved)
                sides.append(g)
            H[i] = (sides[0] - sides[1]) / (2 * e)
        return (H + H.T) / 2

    def pressed(self, z: Vector, k: int, kappa: float) -> tuple[Vector, Vector, Vector]:
        """Return forces (8, 3) of barriers on corners of box 1, those by its image on the image's, distances."""
        A, B, n, d = self.pairs(k, z)
        F = kappa / d[:, None] * n
        return A.T @ F, B.T @ F, d

    def loads(self, z: Vector, kappa: float) -> Vector:
        """Return torque, moment and axial force."""
        told, (_, _, one) = (self.K @ z)[6:], self.placed(z)
        for k in self.images:
            off = self.pressed(z, k, kappa)[1]
            for s in range(3):
                step = z[6:].astype(complex)
                step[s] += 1e-30j
                dR, dt = (v.imag / 1e-30 for v in self.screw(step, k))
                told[s] += (off * (one @ dR.T + dt)).sum()
        return told

    def minimum(self, z: Vector, kappa: float) -> tuple[Vector, float]:
        """Return where the energy is least, by Newton's method with a line search, and what is left of its gradient."""
        U, g, H = self.energy(z, kappa)
        for _ in range(60):
            if abs(g).max() < 1e-10:
                break
            values, ways = np.linalg.eigh(H + self.curved(z, kappa))
            step = -ways @ (ways.T @ g / np.maximum(abs(values), 1e-9))
            f, lower = min(1.0, 0.05 / abs(step).max()), False
            while not lower and f > 1e-9:
                near = z.copy()
                near[:6] += f * step
                if self.gap(near) > 0:
                    Un, gn, Hn = self.energy(near, kappa)
                    lower = Un <= U + 1e-4 * f * (g @ step) or abs(gn).max() < 0.5 * abs(g).max()
                f /= 2
            if not lower:
                break
            z, U, g, H = near, Un, gn, Hn
        return z, float(abs(g).max())

    def follow(self, places: Vector, increment: float = 0.01) -> list[tuple[float, float, float]]:
        """Return torque, moment and what is left of the balance at twists and bends (n, 2), followed from rest."""
        z, rate, told = np.zeros(9), np.zeros(9), []
        for goal in places:
            start, far, done = z[6:8].copy(), float(np.hypot(*(goal - z[6:8]))), 0.0
            step = increment
            while done < far * (1 - 1e-12):
                size = min(step, far - done)
                near = z + rate * size
                near[6:8] = start + (goal - start) * (done + size) / far
                if self.gap(near) <= 0:
                    step /= 2
                    if step < 1e-6:
                        return told
                    continue
                new, left = self.minimum(near, COARSE)
                rate = (new - z) / size if left < 1e-10 else 0 * z
                z, done, step = new, done + size, min(increment, 2 * step)
            told.append(self.refined(z))
        return told

    def refined(self, z: Vector) -> tuple[float, float, float]:
        """Return torque, moment and what is left of the balance where barriers vanish, by two of them."""
        kappa, last, T = COARSE, np.zeros(3), np.zeros(3)
        while self.gap(z) > NEAR:
            kappa, last = kappa / 10, T
            z, left = self.minimum(z, kappa)
            T = self.loads(z, kappa)
        T = (10 * T - last) / 9
        return float(T[0]), float(T[1]), left


def crossing(one: Vector, other: Vector) -> tuple[Vector, Vector]:
    """Return the shares of their lengths at which edges of two boxes are closest, for all pairs."""
    p, q = one[EDGES[CROSSED[:, 0]]], other[EDGES[CROSSED[:, 1]]]
    u, v, w = p[:, 1] - p[:, 0], q[:, 1] - q[:, 0], p[:, 0] - q[:, 0]
    a, b, c, d, e = ((x * y).sum(axis=1) for x, y in ((u, u), (u, v), (v, v), (u, w), (v, w)))
    whole = a * c - b * b
    s = np.where(whole > 1e-14 * a * c, np.clip((b * e - c * d) / np.where(whole > 0, whole, 1), 0, 1), 0)
    r = (b * s + e) / c
    s = np.where(r < 0, np.clip(-d / a, 0, 1), np.where(r > 1, np.clip((b - d) / a, 0, 1), s))
    return s, np.clip(r, 0, 1)

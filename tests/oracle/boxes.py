"""Scales as boxes, by plain vectors: corners, points of edges, and whether two boxes overlap."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

Vector = np.ndarray


def axes(alpha: float, theta: float, phi: float) -> Vector:
    """Rows n_X, n_Y, n_Z of a scale that is turned by phi."""
    X = np.array([-np.sin(alpha) * np.cos(theta), np.sin(theta), np.cos(alpha) * np.cos(theta)])
    Y = np.array([np.cos(alpha), 0, np.sin(alpha)])
    return np.array([turned(v, phi) for v in (X, Y, np.cross(X, Y))])


def turned(v: Vector, phi: float) -> Vector:
    """Turn about the torsion axis, as theory.md's R."""
    c, s = np.cos(phi), np.sin(phi)
    return np.array([c * v[0] + s * v[1], c * v[1] - s * v[0], v[2]])


def middle(lam: float, n: Vector, eta: float, phi: float, k: int) -> Vector:
    """Middle of the box of scale 1 + k."""
    return turned(np.array([0, lam, 0]), phi) + np.array([0, 0, k]) + eta / 2 * n[0]


def distance(shape: tuple[float, ...], theta: float, phi: float, k: int) -> float:
    """Largest gap over all directions that can part the boxes of scale 1 and 1 + k; below 0 where they overlap."""
    eta, beta, lam, alpha, thickness = shape
    a, b = axes(alpha, theta, 0.0), axes(alpha, theta, k * phi)
    t = middle(lam, b, eta, k * phi, k) - middle(lam, a, eta, 0.0, 0)
    return apart(np.array([eta / 2, beta, thickness / 2]), t, a, b)


def displaced(shape: tuple[float, ...], theta: float, phi: float, k: int, motion: Vector, stretch: float) -> float:
    """Gap as :func:`distance`, all scales moved by (u, w) in their own axes, the line stretched."""
    eta, beta, lam, alpha, thickness = shape
    n = axes(alpha, theta, 0.0)
    a = Rotation.from_rotvec(motion[3:]).as_matrix().T @ n
    one = np.array([0, lam, 0]) + motion[:3] @ n + eta / 2 * a[0]
    t = turned(one, k * phi) + np.array([0, 0, k * (1 + stretch)]) - one
    return apart(np.array([eta / 2, beta, thickness / 2]), t, a, np.array([turned(v, k * phi) for v in a]))


def apart(half: Vector, t: Vector, a: Vector, b: Vector) -> float:
    """Largest gap over all directions between boxes of these half sizes, axes in rows, middles a way t apart."""
    ways = [*a, *b, *(np.cross(u, v) for u in a for v in b)]
    ways = [w / np.linalg.norm(w) for w in ways if np.linalg.norm(w) > 1e-6]
    return max(abs(t @ w) - half @ abs(a @ w) - half @ abs(b @ w) for w in ways)

"""The rigid scale: its motion, points that move with it, and its exposed part beside its images along the helix.

Lengths in pitches. The six motions are v = (u_X, u_Y, u_Z, w_X, w_Y, w_Z): translation of the base midpoint O and
rotation vector (finite), both along the scale's axes at rest. A point whose rest position in these axes, from O, is
xi comes to  O + A^T (u + E(w) xi)  with the axes as the rows of A and E the rotation by the vector w.
Image k is turned by R(k phi) and moved by k along z.
"""

from __future__ import annotations

import functools
import math
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

MOTIONS = ("u_X", "u_Y", "u_Z", "w_X", "w_Y", "w_Z")
"""Names of the six motions, in their order."""
CORNERS = ("D", "A", "B", "C")
"""Corners of the exposed part in their order: D and A at the base, C and B at the tip, A and B at +beta."""
EDGES = ((0, 1), (1, 2), (2, 3), (3, 0))
"""Edges of the exposed part by their corners: base DA, side AB, tip BC, side CD."""
FACES = ((0, 1, 2), (0, 2, 3))
"""The two triangles of the exposed part; they share the diagonal DB."""

# matrices of the cross products with the unit vectors
_G = np.array(
    [[[0, 0, 0], [0, 0, -1], [0, 1, 0]], [[0, 0, 1], [0, 0, 0], [-1, 0, 0]], [[0, -1, 0], [1, 0, 0], [0, 0, 0]]]
)
_G = _G.astype(float)
_GG = np.einsum("iab,jbc->ijac", _G, _G)
_GG = _GG + _GG.transpose(1, 0, 2, 3)
_ONE, _FLAT = np.eye(3), _G.reshape(3, 9)


class Shape(Protocol):
    """What is asked of a geometry: ratios, and the axes (rows) and base midpoint of scale 0 at rest."""

    @property
    def eta(self) -> float: ...  # noqa: D102
    @property
    def beta(self) -> float: ...  # noqa: D102
    @property
    def axes(self) -> Array: ...  # noqa: D102
    @property
    def base(self) -> Array: ...  # noqa: D102


class Rest(NamedTuple):
    """A scale at rest: overlap ratio, half width (pitches), axes n_X, n_Y, n_Z (rows) and base midpoint O."""

    eta: float
    beta: float
    axes: Array
    base: Array

    @classmethod
    def at(cls, eta: float, beta: float, lam: float, alpha: float, theta: float) -> Rest:
        """Place a scale at the inclination theta (theory, section 2; angles in rad)."""
        sa, ca, st, ct = np.sin(alpha), np.cos(alpha), np.sin(theta), np.cos(theta)
        x, y = np.array([-sa * ct, st, ca * ct]), np.array([ca, 0.0, sa])
        return cls(eta, beta, np.array([x, y, np.cross(x, y)]), np.array([0.0, lam, 0.0]))


class Pose(NamedTuple):
    """Place ``c`` (3,) of the base midpoint and turn ``R`` (3, 3) from the attitude at rest."""

    c: Array
    R: Array


class Rotation(NamedTuple):
    """Matrix of a rotation vector w (3, 3) and its derivatives with respect to w, (3, 3, 3) and (3, 3, 3, 3)."""

    E: Array
    dE: Array
    ddE: Array


def _series(first: int) -> list[list[float]]:
    """Coefficients of sum (-q)^n / (2 n + first)!, highest power first, and of two derivatives by q."""
    terms = [(-1) ** n / math.factorial(2 * n + first) for n in range(8)][::-1]
    slopes = [c * n for n, c in zip(range(7, 0, -1), terms, strict=False)]
    return [terms, slopes, [c * n for n, c in zip(range(6, 0, -1), slopes, strict=False)]]


_SERIES = (*_series(1), *_series(2))


def _factors(q: float) -> tuple[float, ...]:
    """Return sin(t)/t with two derivatives by q = t^2, and (1 - cos t)/t^2 with two."""
    if q < 0.1:
        return tuple(functools.reduce(lambda value, c: value * q + c, terms) for terms in _SERIES)
    t = math.sqrt(q)
    s, c = math.sin(t), math.cos(t)
    a, b = s / t, (1 - c) / q
    a1, b1 = (c - a) / (2 * q), (a - 2 * b) / (2 * q)
    return a, a1, -(a / 2 + 3 * a1) / (2 * q), b, b1, (a1 - 4 * b1) / (2 * q)


def turned(w: Array) -> Array:
    """Return the matrix of a rotation vector (3,) in rad."""
    W = (w @ _FLAT).reshape(3, 3)
    a, _, _, b, _, _ = _factors(float(w @ w))
    return np.asarray(_ONE + a * W + b * (W @ W))


def rotation(w: Array) -> Rotation:
    """Return the matrix of a rotation vector (3,) in rad with its derivatives (Rodrigues' formula)."""
    W = (w @ _FLAT).reshape(3, 3)
    W2 = W @ W
    a, a1, a2, b, b1, b2 = _factors(float(w @ w))
    H = _G @ W + W @ _G
    dE = w[:, None, None] * (2 * a1 * W + 2 * b1 * W2) + a * _G + b * H
    mixed = w[:, None, None, None] * (2 * a1 * _G + 2 * b1 * H)
    ddE = mixed + mixed.transpose(1, 0, 2, 3) + b * _GG
    ddE += np.outer(w, w)[:, :, None, None] * (4 * a2 * W + 4 * b2 * W2)
    ddE += _ONE[:, :, None, None] * (2 * a1 * W + 2 * b1 * W2)
    return Rotation(_ONE + a * W + b * W2, dE, ddE)


def pose(rest: Shape, v: Array) -> Pose:
    """Return the pose that six motions (6,) give to a scale."""
    A = rest.axes
    return Pose(rest.base + v[:3] @ A, A.T @ turned(v[3:]) @ A)


def inclination(rest: Shape, v: Array) -> float:
    """Inclination theta, rad: angle of n_X against the beam's face, seen along the width at rest.

    n_X is projected on the plane normal to n_Y at rest; in that plane theta is measured from the face (y = 0)
    towards y. For a rotation about n_Y alone this is the hinge's angle, also beyond 90 deg.
    """
    x = rest.axes.T @ turned(v[3:])[:, 0]
    y = rest.axes[1]
    along = np.array([-y[2], 0.0, y[0]])
    return float(np.arctan2(x[1], x @ along))


class Attached:
    """Points that move with a rigid scale.

    Parameters
    ----------
    rest : Shape
        The scale.
    points : (n, 3) array
        Their places at rest.
    """

    def __init__(self, rest: Shape, points: Array) -> None:
        self.axes, self.base = rest.axes, rest.base
        self.local = (np.asarray(points, float) - rest.base) @ rest.axes.T

    def places(self, v: Array) -> Array:
        """Return the places (n, 3) for motions v (6,)."""
        return np.asarray(self.base + (v[:3] + self.local @ turned(v[3:]).T) @ self.axes)

    def rates(self, v: Array) -> Array:
        """Return the derivatives (n, 3, 6) of the places by v."""
        return self._rates(rotation(v[3:]))

    def _rates(self, turn: Rotation) -> Array:
        rates = np.empty((len(self.local), 3, 6))
        rates[:, :, :3] = self.axes.T
        # (point, axis of space, motion)
        rates[:, :, 3:] = ((self.local @ turn.dE.transpose(0, 2, 1)) @ self.axes).transpose(1, 2, 0)
        return rates

    def curvature(self, v: Array, forces: Array) -> Array:
        """Return the second derivatives (6, 6) of ``sum(forces * places)`` for forces (n, 3) that stay."""
        return self._curvature(rotation(v[3:]), forces)

    def _curvature(self, turn: Rotation, forces: Array) -> Array:
        out = np.zeros((6, 6))
        out[3:, 3:] = (turn.ddE.reshape(9, 9) @ ((forces @ self.axes.T).T @ self.local).ravel()).reshape(3, 3)
        return out


class Placed(NamedTuple):
    """Corners of scale 0 and its images, shape (4 (1 + reach), 3), and their derivatives (.., 3, 7) by (v, phi)."""

    corners: Array
    rates: Array


class Helix:
    """The exposed part of scale 0 (a rectangle without thickness) and of its images 1, 2, .. reach.

    By periodicity every pair of scales is one of the pairs (0, k), k > 0, turned and moved; so counting these once is
    counting each pair once per pitch, and the derivatives by v hold the forces from the neighbours on both sides.

    Parameters
    ----------
    rest : Shape
        The scale.
    reach : int, optional
        Farthest image; the farthest a scale can touch if not given.
    """

    def __init__(self, rest: Shape, reach: int | None = None) -> None:
        self.rest = rest
        self.reach = int(np.ceil(np.hypot(rest.eta, 2 * rest.beta))) if reach is None else reach
        eta, beta = rest.eta, rest.beta
        local = np.array([[0.0, -beta, 0.0], [0.0, beta, 0.0], [eta, beta, 0.0], [eta, -beta, 0.0]])
        self.plate = Attached(rest, rest.base + local @ rest.axes)
        self._k = np.arange(1.0 + self.reach)
        self._lift = np.zeros((1 + self.reach, 1, 3))
        self._lift[:, 0, 2] = self._k

    def _turns(self, phi: float) -> tuple[Array, Array, Array]:
        """Matrices (1 + reach, 3, 3) that turn row vectors, and their derivatives by phi."""
        c, s = np.cos(self._k * phi), np.sin(self._k * phi)
        Q, dQ, ddQ = np.zeros((3, self._k.size, 3, 3))
        Q[:, 0, 0], Q[:, 1, 1], Q[:, 1, 0], Q[:, 0, 1], Q[:, 2, 2] = c, c, s, -s, 1.0
        c, s = self._k * c, self._k * s
        dQ[:, 0, 0], dQ[:, 1, 1], dQ[:, 1, 0], dQ[:, 0, 1] = -s, -s, c, -c
        c, s = self._k * c, self._k * s
        ddQ[:, 0, 0], ddQ[:, 1, 1], ddQ[:, 1, 0], ddQ[:, 0, 1] = -c, -c, -s, s
        return Q, dQ, ddQ

    def corners(self, v: Array, phi: float) -> Array:
        """Return the corners (4 (1 + reach), 3), scale by scale in the order D, A, B, C."""
        return np.asarray((self.plate.places(v) @ self._turns(phi)[0] + self._lift).reshape(-1, 3))

    def placed(self, v: Array, phi: float) -> Placed:
        """Return the corners and their derivatives by (v, phi)."""
        x, (Q, dQ, _) = self.plate.places(v), self._turns(phi)
        rates = np.empty((self._k.size, 4, 3, 7))
        ours = self.plate.rates(v)
        # (image, 1, axes, axes) times (point, axis, motion)
        rates[..., :6] = Q.transpose(0, 2, 1)[:, None] @ ours
        rates[..., 6] = x @ dQ
        return Placed((x @ Q + self._lift).reshape(-1, 3), rates.reshape(-1, 3, 7))

    def curvature(self, v: Array, phi: float, forces: Array) -> Array:
        """Return the second derivatives (7, 7) by (v, phi) of ``sum(forces * corners)`` for forces that stay."""
        x, turn, (Q, dQ, ddQ) = self.plate.places(v), rotation(v[3:]), self._turns(phi)
        f = forces.reshape(-1, 4, 3)
        back, back1, back2 = ((f @ q.transpose(0, 2, 1)).sum(0) for q in (Q, dQ, ddQ))
        out = np.zeros((7, 7))
        out[:6, :6] = self.plate._curvature(turn, back)
        out[:6, 6] = out[6, :6] = back1.ravel() @ self.plate._rates(turn).reshape(-1, 6)
        out[6, 6] = (back2 * x).sum()
        return out

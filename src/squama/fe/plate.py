"""A scale's rigid motion, and points that move with it or are displaced by its bending.

Lengths in pitches. The six motions are v = (u_X, u_Y, u_Z, w_X, w_Y, w_Z): translation of the base midpoint O and
rotation vector (finite), both along the scale's axes at rest. A point whose rest position in these axes, from O, is
xi comes to  O + A^T (u + E(w) xi)  with the axes as the rows of A and E the rotation by the vector w. Where the scale
bends, xi is moved by its modes first (:mod:`squama.fe.exposed`), whose amplitudes follow the six motions.
Scale k along the helix is turned by R(k phi) and moved by k along z.
"""

from __future__ import annotations

import copy
import functools
import math
from typing import NamedTuple

import numpy as np

from squama.fe.exposed import Index
from squama.types import Array

# matrices of the cross products with the unit vectors
_G = np.array(
    [[[0, 0, 0], [0, 0, -1], [0, 1, 0]], [[0, 0, 1], [0, 0, 0], [-1, 0, 0]], [[0, -1, 0], [1, 0, 0], [0, 0, 0]]]
)
_G = _G.astype(float)
_GG = np.einsum("iab,jbc->ijac", _G, _G)
_GG = _GG + _GG.transpose(1, 0, 2, 3)
_ONE, _FLAT = np.eye(3), _G.reshape(3, 9)


def axes(alpha: float, theta: float) -> Array:
    """Return the axes n_X, n_Y, n_Z of a scale at the inclination theta, as rows (theory, section 2; angles in rad)."""
    sa, ca, st, ct = math.sin(alpha), math.cos(alpha), math.sin(theta), math.cos(theta)
    x, y = np.array([-sa * ct, st, ca * ct]), np.array([ca, 0.0, sa])
    return np.array([x, y, np.cross(x, y)])


class Rest(NamedTuple):
    """A scale at rest: overlap ratio, half width (pitches), axes n_X, n_Y, n_Z (rows) and base midpoint O."""

    eta: float
    beta: float
    axes: Array
    base: Array

    @classmethod
    def at(cls, eta: float, beta: float, lam: float, alpha: float, theta: float) -> Rest:
        """Return a scale at rest at the inclination theta (theory, section 2; angles in rad)."""
        return cls(eta, beta, axes(alpha, theta), np.array([0.0, lam, 0.0]))


class Rotation(NamedTuple):
    """Rotation matrix E (3, 3) of a rotation vector w and its derivatives by w, (3, 3, 3) and (3, 3, 3, 3)."""

    E: Array
    dE: Array
    ddE: Array


def _series(first: int) -> list[list[float]]:
    """Return coefficients of sum (-q)^n / (2 n + first)!, highest power first, and of two derivatives by q."""
    terms = [(-1) ** n / math.factorial(2 * n + first) for n in range(8)][::-1]
    slopes = [c * n for n, c in zip(range(7, 0, -1), terms, strict=False)]
    return [terms, slopes, [c * n for n, c in zip(range(6, 0, -1), slopes, strict=False)]]


_SERIES, _THIRD = (*_series(1), *_series(2)), _series(3)


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
    """Return the rotation matrix (3, 3) of a rotation vector (3,), rad."""
    W = (w @ _FLAT).reshape(3, 3)
    a, _, _, b, _, _ = _factors(float(w @ w))
    return np.asarray(_ONE + a * W + b * (W @ W))


def rotation(w: Array) -> Rotation:
    """Return the rotation matrix of a rotation vector (3,), rad, with two derivatives (Rodrigues' formula)."""
    return _with_rates(w, *_factors(float(w @ w)))


def translation(w: Array) -> Rotation:
    """Return the mean of the rotations by s w, s from 0 to 1, with derivatives: the matrix of a screw's shift."""
    q = float(w @ w)
    _, _, _, b, b1, b2 = _factors(q)
    if q < 0.1:
        third = [functools.reduce(lambda value, c: value * q + c, terms) for terms in _THIRD]
    else:
        c = (1 - math.sin(math.sqrt(q)) / math.sqrt(q)) / q
        c1 = (b - 3 * c) / (2 * q)
        third = [c, c1, (b1 - 5 * c1) / (2 * q)]
    return _with_rates(w, b, b1, b2, *third)


def _with_rates(w: Array, a: float, a1: float, a2: float, b: float, b1: float, b2: float) -> Rotation:
    """Return 1 + a W + b W^2 with two derivatives, W the cross product with w; a1 .. b2: derivatives by w . w."""
    W = (w @ _FLAT).reshape(3, 3)
    W2 = W @ W
    H = _G @ W + W @ _G
    dE = w[:, None, None] * (2 * a1 * W + 2 * b1 * W2) + a * _G + b * H
    mixed = w[:, None, None, None] * (2 * a1 * _G + 2 * b1 * H)
    ddE = mixed + mixed.transpose(1, 0, 2, 3) + b * _GG
    ddE += np.outer(w, w)[:, :, None, None] * (4 * a2 * W + 4 * b2 * W2)
    ddE += _ONE[:, :, None, None] * (2 * a1 * W + 2 * b1 * W2)
    return Rotation(_ONE + a * W + b * W2, dE, ddE)


def pose(rest: Rest, v: Array) -> tuple[Array, Array]:
    """Return the base midpoint (3,), pitches, and the rotation (3, 3) from rest of a scale for six motions (6,)."""
    A = rest.axes
    return rest.base + v[:3] @ A, A.T @ turned(v[3:6]) @ A


def inclination(rest: Rest, v: Array) -> float:
    """Return the inclination theta, rad: angle of n_X to the beam's face, seen along the width at rest.

    n_X is projected on the plane normal to n_Y at rest; in that plane theta is measured from the face (y = 0)
    towards y. For a rotation about n_Y alone this is the hinge's angle, also beyond 90 deg.
    """
    return inclined(rest, rest.axes.T @ turned(v[3:6])[:, 0])


def inclined(rest: Rest, x: Array) -> float:
    """Return the inclination, rad, of a scale with axis n_X = ``x`` (3,) in the frame of its section."""
    y = rest.axes[1]
    along = np.array([-y[2], 0.0, y[0]])
    return float(np.arctan2(x[1], x @ along))


class Attached:
    """Points (n, 3) that move with a scale; ``modes`` (n, 3, r): displacements along the scale's axes per amplitude."""

    def __init__(self, rest: Rest, points: Array, modes: Array | None = None) -> None:
        self.axes, self.base = rest.axes, rest.base
        self.local = (np.asarray(points, float) - rest.base) @ rest.axes.T
        self.modes = np.zeros((len(self.local), 3, 0)) if modes is None else modes

    def of(self, nodes: Index) -> Attached:
        """Return the points with these numbers."""
        part = copy.copy(self)
        part.local, part.modes = self.local[nodes], self.modes[nodes]
        return part

    def bent(self, v: Array) -> Array:
        """Return the points (n, 3) in the scale's frame, displaced by the modes."""
        return self.local + self.modes @ v[6:] if v.size > 6 else self.local

    def places(self, v: Array) -> Array:
        """Return the places (n, 3) for motions v (6 + r,)."""
        return np.asarray(self.base + (v[:3] + self.bent(v) @ turned(v[3:6]).T) @ self.axes)

    def rates(self, v: Array, turn: Rotation | None = None) -> Array:
        """Return the derivatives (n, 3, 6 + r) of the places by v; ``turn``: its rotation, if known."""
        turn = rotation(v[3:6]) if turn is None else turn
        rates = np.empty((len(self.local), 3, v.size))
        rates[:, :, :3] = self.axes.T
        # (point, axis of space, motion)
        rates[:, :, 3:6] = ((self.bent(v) @ turn.dE.transpose(0, 2, 1)) @ self.axes).transpose(1, 2, 0)
        rates[:, :, 6:] = (self.axes.T @ turn.E) @ self.modes
        return rates

    def curvature(self, v: Array, forces: Array, turn: Rotation | None = None) -> Array:
        """Return the second derivatives (6 + r, 6 + r) of ``sum(forces * places)`` at constant forces (n, 3)."""
        turn = rotation(v[3:6]) if turn is None else turn
        out, along = np.zeros((v.size, v.size)), forces @ self.axes.T
        out[3:6, 3:6] = (turn.ddE.reshape(9, 9) @ (along.T @ self.bent(v)).ravel()).reshape(3, 3)
        # rotation and amplitude
        mixed = turn.dE.reshape(3, 9) @ np.tensordot(along.T, self.modes, 1).reshape(9, -1)
        out[3:6, 6:], out[6:, 3:6] = mixed, mixed.T
        return out


class Turn(NamedTuple):
    """Rotations about z with two derivatives by the angle, (.., 3, 3) each: from scale 1 to scale 1 + k."""

    Q: Array
    dQ: Array
    ddQ: Array

    @classmethod
    def at(cls, angle: float | Array) -> Turn:
        """Return the rotations by angles, rad, clockwise seen against +z."""
        angle = np.asarray(angle)[..., None, None]
        c, s = np.cos(angle), np.sin(angle)
        across, along = c * _ACROSS, s * _TURN
        return cls(across + along + _UP, c * _TURN - s * _ACROSS, -across - along)


_ACROSS, _UP = np.diag([1.0, 1.0, 0.0]), np.diag([0.0, 0.0, 1.0])
_TURN = np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 0.0]])


class Carried:
    """Points on a rigid scale whose six motions are counted in a frame that turns with the twist.

    Scale k of a beam stands at z = k; its frame is turned by (k - c) phi about z, where c (``still``) is the place of
    the section that does not turn. In an endless beam all scales have the same motions in their frames. ``rest``: scale
    0 at rest; ``points`` (n, 3): places at rest, on scale k.
    """

    def __init__(self, rest: Rest, points: Array, k: int = 0, still: float = 0.0) -> None:
        self._lift = np.array([0.0, 0.0, k])
        self._attached, self._k = Attached(rest, points - self._lift), k - still

    def places(self, v: Array, phi: float) -> Array:
        """Return the places (n, 3) for motions v (6,) and the twist per pitch."""
        return np.asarray(self._attached.places(v) @ Turn.at(self._k * phi).Q.T + self._lift)

    def rates(self, v: Array, phi: float) -> Array:
        """Return the derivatives (n, 3, 7) of the places by (v, phi)."""
        turn = Turn.at(self._k * phi)
        by_phi = self._k * self._attached.places(v) @ turn.dQ.T
        return np.concatenate([turn.Q @ self._attached.rates(v), by_phi[..., None]], axis=-1)

    def curvature(self, v: Array, phi: float, forces: Array) -> Array:
        """Return the second derivatives (7, 7) by (v, phi) of ``sum(forces * places)`` at constant forces (n, 3)."""
        turn, k, own = Turn.at(self._k * phi), self._k, rotation(v[3:])
        out = np.zeros((7, 7))
        out[:6, :6] = self._attached.curvature(v, forces @ turn.Q, own)
        out[:6, 6] = out[6, :6] = k * (forces @ turn.dQ).ravel() @ self._attached.rates(v, own).reshape(-1, 6)
        out[6, 6] = k * k * float(((forces @ turn.ddQ) * self._attached.places(v)).sum())
        return out

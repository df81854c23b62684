"""Moves x -> Q x + t from pitch to pitch by the loads, with two derivatives; and the path of the loads.

A twisted beam has one load, the twist phi per pitch: Q = R(k phi), t = k e_z for a scale k pitches away. A beam that is
bent and twisted has three strains: twist phi, bend psi (towards the scaled face) and stretch epsilon of the axis y = 0,
in the order of the joint's matrix, and its pitches follow by powers of the screw exp(w, v),

    w = -(psi, 0, phi)      v = (0, 0, 1 + epsilon)      Q = exp(k w)      t = k V(k w) v

with V(w) the mean of exp(s w), s from 0 to 1.

The path of a run has one parameter: the twist itself, or the way along a straight leg in the strains.
"""

from __future__ import annotations

import functools
from typing import NamedTuple

import numpy as np

from squama.fe.plate import Turn, rotation, translation
from squama.types import Array

STRAINS = 3
"""Twist, bend and stretch per pitch, in this order."""
_UP = np.array([0.0, 0.0, 1.0])
_BY = -np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
"""Derivatives of w by the strains, as rows."""


class Moves(NamedTuple):
    """Rotations Q (n, 3, 3) and shifts t (n, 3) with derivatives by L loads, (n, L, ..) and (n, L, L, ..)."""

    Q: Array
    t: Array
    dQ: Array
    dt: Array
    ddQ: Array
    ddt: Array

    def of(self, x: Array) -> tuple[Array, Array, Array]:
        """Return the places of x (n, 3), one for each move: (n, 3), with derivatives (n, L, 3) and (n, L, L, 3)."""
        place, rate, second = self.turned(x)
        return place + self.t, rate + self.dt, second + self.ddt

    def turned(self, x: Array) -> tuple[Array, Array, Array]:
        """Return vectors x (n, 3) rotated, with the same derivatives."""
        return (
            (self.Q @ x[:, :, None])[..., 0],
            (self.dQ @ x[:, None, :, None])[..., 0],
            (self.ddQ @ x[:, None, None, :, None])[..., 0],
        )


class Twist:
    """The load of a twisted beam: its twist per pitch, which is the parameter of the path, too."""

    loads, strains, first = 1, 0, 0

    def at(self, v: Array, way: float) -> Array:  # noqa: ARG002 - as a Leg's
        """Return the loads (1,) for motions v and the place ``way`` on the path."""
        return np.array([way])

    def by(self, size: int) -> Array:
        """Return the derivatives (1, size) of the loads by motions and way, ``size`` in all."""
        return np.eye(1, size, size - 1)

    def moves(self, loads: Array, k: Array) -> Moves:
        """Return the moves by k (n,) pitches."""
        turn, z = Turn.at(k * loads[0]), np.zeros((k.size, 1, 1, 3))
        first, second = (k**n * of.T for n, of in ((1, turn.dQ), (2, turn.ddQ)))
        return Moves(turn.Q, k[:, None] * _UP, first.T[:, None], z[:, 0], second.T[:, None, None], z)


class Leg:
    """The loads of a beam in bend and twist: strains along a straight leg, plus free strains among the motions.

    Three motions from number ``first`` on (6 with one scale) are added to the strains; their conjugate forces are the
    torque T, the moment M and the axial force. Motions outside the ways of a run (:class:`squama.fe.walk.Walk`) stay 0,
    so that the strain is imposed; others are free. ``start`` and ``rate`` (3,) are the strains at the begin of the leg
    and their derivatives by the way, ``way`` the way there.
    """

    loads = strains = STRAINS

    def __init__(self, first: int = 6) -> None:
        self.first = first
        self.start, self.rate, self.way = np.zeros(self.loads), np.zeros(self.loads), 0.0

    def turn(self, rate: Array, way: float) -> None:
        """Begin a new leg at ``way``, with the derivatives ``rate`` (L,) of the loads by the way."""
        self.start, self.rate, self.way = self.start + (way - self.way) * self.rate, rate, way

    def at(self, v: Array, way: float) -> Array:
        """Return the loads (L,) for motions v and the place ``way`` on the path."""
        return np.asarray(self.start + (way - self.way) * self.rate + v[self.first : self.first + self.loads])

    def by(self, size: int) -> Array:
        """Return the derivatives (L, size) of the loads by motions and way, ``size`` in all."""
        out = np.eye(self.loads, size, self.first)
        out[:, -1] = self.rate
        return out

    def moves(self, loads: Array, k: Array) -> Moves:
        """Return the moves by k (n,) pitches."""
        return _powers(tuple(loads.tolist()), tuple(k.tolist()))


class End(Leg):
    """The loads of a finite beam: the motion of its far end, imposed along one leg or free.

    Six motions after those of the rigid bodies are the loads: shift of the end (3), tilt about x and y, and twist phi
    per pitch. At rest the end is at ``place`` (3,), in pitches; it is turned clockwise about z by phi times the number
    of pitches, then tilted. Motions outside the ways of a run are held; motions of scales are in frames that turn with
    phi. ``rate`` (6,): derivatives of the loads by the way.
    """

    loads = strains = 6

    def __init__(self, bodies: int, pitches: int, place: Array, rate: Array) -> None:
        super().__init__(6 * bodies)
        self.pitches, self._place, self.rate = pitches, place, rate

    def moves(self, loads: Array, k: Array) -> Moves:
        """Return the moves by k (n,) pitches: a twist about the axis at rest."""
        twist = Twist().moves(loads[5:], k)
        out = Moves(twist.Q, twist.t, *(np.zeros((k.size, *(6,) * n, *end)) for n in (1, 2) for end in ((3, 3), (3,))))
        out.dQ[:, 5], out.ddQ[:, 5, 5] = twist.dQ[:, 0], twist.ddQ[:, 0, 0]
        return out

    def frame(self, loads: Array) -> Moves:
        """Return the frame of the end section for loads (6,)."""
        n, tilt, turn = float(self.pitches), rotation(np.append(loads[3:5], 0.0)), Turn.at(self.pitches * loads[5])
        dQ, ddQ = np.zeros((6, 3, 3)), np.zeros((6, 6, 3, 3))
        dQ[3:5], dQ[5] = tilt.dE[:2] @ turn.Q, n * tilt.E @ turn.dQ
        ddQ[3:5, 3:5], ddQ[5, 5] = tilt.ddE[:2, :2] @ turn.Q, n * n * tilt.E @ turn.ddQ
        ddQ[3:5, 5] = ddQ[5, 3:5] = n * tilt.dE[:2] @ turn.dQ
        dt = np.zeros((6, 3))
        dt[:3] = np.eye(3)
        every = tilt.E @ turn.Q, self._place + loads[:3], dQ, dt, ddQ, np.zeros((6, 6, 3))
        return Moves(*(part[None] for part in every))


def stays(loads: Array) -> Moves:
    """Return the frame of a section that does not depend on the loads (L,)."""
    L = loads.size
    rest = (np.zeros((1, *(L,) * n, *end)) for n in (1, 2) for end in ((3, 3), (3,)))
    return Moves(np.eye(3)[None], np.zeros((1, 3)), *rest)


Course = Twist | Leg


@functools.lru_cache(maxsize=8)
def _powers(strains: tuple[float, ...], k: tuple[float, ...]) -> Moves:
    """Return moves by k powers of a screw, cached, since they are needed three times in a row at each state."""
    each = [power(np.array(strains), n) for n in k]
    return Moves(*(np.array(part) for part in zip(*each, strict=True)))


def power(strains: Array, k: float) -> Moves:
    """Return the k-th power of the screw of strains (3,): a :class:`Moves` without its first axis."""
    w, by = k * (strains @ _BY), k * _BY
    E, V = rotation(w), translation(w)
    # the shift is k (1 + epsilon) times the last column of V
    size, column = k * (1 + strains[2]), V.E[:, 2]
    rate, bow = by @ V.dE[:, :, 2], np.einsum("li,mj,ija->lma", by, by, V.ddE[..., 2])
    dt, ddt = size * rate, size * bow
    dt[2] += k * column
    ddt[2] += k * rate
    ddt[:, 2] += k * rate
    dQ = np.tensordot(by, E.dE, 1)
    return Moves(E.E, size * column, dQ, dt, np.einsum("li,mj,ijab->lmab", by, by, E.ddE), ddt)

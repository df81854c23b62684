"""Points of a rigid scale whose six motions are counted in a frame that turns with the twist.

Scale k of a beam stands at z = k; its frame is turned by (k - c) phi about z, clockwise, where c is the place of the
section that does not turn. In an endless beam all scales have the same motions in their frames (see
:mod:`squama.fe.plate`).
"""

from __future__ import annotations

import numpy as np

from squama.fe.elements import Turn
from squama.fe.plate import Array, Attached, Shape


class Carried:
    """Points that move with a rigid scale in its turning frame.

    Parameters
    ----------
    rest : Shape
        Scale 0 at rest.
    points : (n, 3) array
        Places of the points at rest, on scale k.
    k : int
        How many pitches the scale stands further along z.
    still : float
        Place c along z of the section that does not turn.
    """

    def __init__(self, rest: Shape, points: Array, k: int, still: float = 0.0) -> None:
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
        """Return the second derivatives (7, 7) by (v, phi) of ``sum(forces * places)`` for forces (n, 3) that stay."""
        turn, k = Turn.at(self._k * phi), self._k
        out = np.zeros((7, 7))
        out[:6, :6] = self._attached.curvature(v, forces @ turn.Q)
        mixed = k * (forces @ turn.dQ).ravel() @ self._attached.rates(v).reshape(-1, 6)
        out[:6, 6] = out[6, :6] = mixed
        out[6, 6] = k * k * float(((forces @ turn.ddQ) * self._attached.places(v)).sum())
        return out


def spread(blocks: Array) -> Array:
    """Return the matrix (6 n + 1, 6 n + 1) by all motions and phi from blocks (n, n, 7, 7) of pairs of scales."""
    n = len(blocks)
    out = np.zeros((6 * n + 1, 6 * n + 1))
    out[:-1, :-1] = blocks[:, :, :6, :6].transpose(0, 2, 1, 3).reshape(6 * n, 6 * n)
    out[:-1, -1] = blocks[:, :, :6, 6].sum(1).ravel()
    out[-1, :-1] = blocks[:, :, 6, :6].sum(0).ravel()
    out[-1, -1] = blocks[:, :, 6, 6].sum()
    return out

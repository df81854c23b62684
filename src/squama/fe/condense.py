"""The compliant model: rigid scales on the substrate's condensed stiffness, in frictional contact along the helix.

The substrate enters as one symmetric matrix K over the six motions of a scale and the twist per pitch, energy per pitch
1/2 q^T K q with q = (v, phi); the scales turn by finite rotations and may touch anywhere. Per pitch, with the barrier
and friction of :mod:`squama.fe.contact`,
    balance   K_v q + dB/dv + F_v = 0        torque   T = K_phi q + dB/dphi + F_phi
    U = 1/2 q^T K q        dW_fr = friction forces x slip        int T dphi = U + W_fr
Units: pitch d = 1, Young's modulus E = 1: torques in E d^3, forces in E d^2, works in E d^3 per pitch.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from squama.fe import walk
from squama.fe.body import Matrix
from squama.fe.contact import DHAT, SLIP, RowContact
from squama.fe.plate import Row, Shape, inclination
from squama.fe.walk import Contacts
from squama.types import Array

INCREMENT = 2e-3
"""Largest increment of the twist, rad per pitch, unless asked otherwise."""
JUMP = 0.01
"""Farthest a new equilibrium may lie from where the last ones point (pitches, rad); beyond, increments are halved."""
_HALVINGS = 5
_FIRST = 0.05
RANGE_END, SNAP, STOPPED = "range end", "snap", "stopped"
"""How a curve ends: the range is done; the scales jump away, no equilibrium being near; no way on is found (a lock)."""
HINGE = np.eye(6)[:, 4:5]
FREE = np.eye(6)


class Condensed(NamedTuple):
    """A curve; arrays over its points, signed, units as the module says; NaN where it did not come to.

    ``theta``: see :func:`squama.fe.plate.inclination`; ``v`` (n, 6) motions; ``N``, ``f`` of the neighbour that presses
    most; ``U`` strain energy, ``W_fr`` frictional work and ``W`` the torque's, per pitch; ``gap`` between the
    scales; ``p``, ``s`` place of a tip-side contact (NaN for another or none).
    ``phi_e`` is the twist at engagement (inf if none), ``contacts`` what touches from where on, ``end`` a word for the
    end at ``phi_end``, ``rigidity`` the torque per twist without contact, ``rounds`` the number of Newton steps.
    """

    phi: Array
    theta: Array
    v: Array
    T: Array
    N: Array
    f: Array
    U: Array
    W_fr: Array
    W: Array
    gap: Array
    p: Array
    s: Array
    phi_e: float
    phi_end: float
    end: str
    contacts: tuple[Contacts, ...]
    rigidity: float
    rounds: int

    @property
    def unbalanced(self) -> float:
        """Work of the torque less U and W_fr at the last point reached, over the work of the torque."""
        i = np.flatnonzero(np.isfinite(self.T))[-1]
        return float((self.W[i] - self.U[i] - self.W_fr[i]) / self.W[i]) if self.W[i] else 0.0


def curve(
    rest: Shape,
    K: Array,
    mu: float,
    phi: Sequence[float] | Array,
    *,
    hinge: bool = False,
    increment: float = INCREMENT,
    dhat: float = DHAT,
    slip: float = SLIP,
) -> Condensed:
    """Follow the scales along a history of the twist.

    Parameters
    ----------
    rest : Shape
        A scale at rest, e.g. :class:`squama.fe.plate.Rest` or a geometry.
    K : (7, 7) array
        Stiffness over (u_X, u_Y, u_Z, w_X, w_Y, w_Z, phi).
    mu : float
        Coefficient of friction.
    phi : sequence of float
        Twists per pitch at which the state is wanted, in the order of loading from 0; negative for the other sense.
    hinge : bool
        Let the scale turn about n_Y only.
    increment, dhat, slip : float
        Largest increment of the twist; distance of contact and slip of friction's onset (see the contact module).

    Returns
    -------
    Condensed
    """
    way = Walk(rest, np.asarray(K, float), mu, HINGE if hinge else FREE, dhat, slip)
    wanted = np.asarray(phi, float)
    rows: list[tuple[float, ...]] = []
    end = RANGE_END
    for goal in wanted:
        if not way.to(float(goal), increment):
            end = way.ending(increment)
            break
        rows.append(way.row())
    table = np.full((wanted.size, 16), np.nan)
    table[: len(rows)] = np.array(rows).reshape(-1, 16)
    engaged = engagement(rest, K, way.contacts[0].phi, hinge=hinge) if way.contacts else np.inf
    T, N, f, U, W_fr, W, gap, p, s = table[:, 7:].T
    return Condensed(
        wanted, table[:, 0], table[:, 1:7], T, N, f, U, W_fr, W, gap, p, s,
        engaged, float(way.phi), end, tuple(way.contacts), way.rigidity, way.rounds,
    )  # fmt: skip


def free_rates(K: Array, ways: Array) -> Array:
    """Return the motions (6,) per twist of a scale that touches nothing."""
    return np.asarray(-ways @ np.linalg.solve(ways.T @ K[:6, :6] @ ways, ways.T @ K[:6, 6]))


def rigidity(K: Array, *, hinge: bool = False) -> float:
    """Return the torque per twist per pitch of a beam whose scales touch nothing, E d^3."""
    r = free_rates(np.asarray(K, float), HINGE if hinge else FREE)
    return float(K[6, 6] + K[6, :6] @ r)


def engagement(rest: Shape, K: Array, near: float, *, hinge: bool = False) -> float:
    """Return the twist at which the scales first touch, given a twist at or a little beyond it."""
    rates = free_rates(np.asarray(K, float), HINGE if hinge else FREE)
    contact = RowContact(Row(rest), 0.0)

    def gap(x: float) -> float:
        return contact.contact.gap(contact.corners(rates * x, x))

    x = 0.0
    # to the neighbourhood along ways that are free, then along the gap's tangent, from below
    while (share := contact.free(contact.corners(rates * x, x), contact.corners(rates * near, near))) < 1:
        step = share * (near - x)
        if abs(step) < 1e-4 * abs(near):
            break
        x += step
    else:
        x = near - 1e-3 * near if gap(near) < gap(near * (1 - 1e-3)) else near
    for _ in range(60):
        g, h = gap(x), 1e-6 * near
        slope = (gap(x - h) - g) / h
        if g < 1e-10 or slope * near <= 0:
            break
        x += 0.95 * g / slope
    return x


class Walk(walk.Walk):
    """The state of a curve, led from twist to twist."""

    def __init__(self, rest: Shape, K: Array, mu: float, ways: Array, dhat: float, slip: float) -> None:
        self.rest, self.rigidity = rest, float(K[6, 6] + K[6, :6] @ free_rates(K, ways))
        contact = RowContact(Row(rest), mu, dhat=dhat, slip=slip)
        first = _FIRST * float(K[4, 4])
        super().__init__(Matrix(K), contact, ways, first=first, dhat=dhat, jump=JUMP, halvings=_HALVINGS)
        self.begin()

    def ending(self, most: float) -> str:
        """Say why no increment leads on: the scale leaves when it is let go a little farther on, or it stays."""
        return STOPPED if self.let_go(np.sign(self.phi) or 1.0, most) is None else SNAP

    def row(self) -> tuple[float, ...]:
        """Return what a curve shows of the state."""
        touch = self.touch
        gap = self.contact.contact.gap(self.contact.corners(self.v, self.phi))
        p, s = (touch.p, touch.s) if touch else (np.nan, np.nan)
        return (
            inclination(self.rest, self.v), *self.v, self.T, self.N, self.f, self.reduced.energy, self.W_fr, self.W,
            gap, p, s,
        )  # fmt: skip

"""The compliant model: scales on the substrate's condensed stiffness, in frictional contact along the helix.

The substrate enters as one symmetric matrix K over the six motions of a scale and the twist per pitch, energy per pitch
1/2 q^T K q with q = (v, phi); the scales turn by finite rotations and may touch anywhere. They are thin or thick, and
rigid or bend by their modes (:mod:`squama.fe.exposed`), whose amplitudes are motions, too. Per pitch, with the barrier
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
from squama.fe.body import Matrix, bent, ways_of
from squama.fe.contact import DHAT, SLIP, RowContact
from squama.fe.exposed import Exposed, box
from squama.fe.plate import Rest
from squama.fe.rows import Row
from squama.fe.walk import Contacts
from squama.progress import steps
from squama.types import Array

INCREMENT = 2e-3
"""Largest increment of the twist, rad per pitch, unless asked otherwise."""
JUMP = 0.01
"""Farthest a new equilibrium may lie from where the last ones point (pitches, rad); beyond, increments are halved."""
_HALVINGS = 5
_FIRST = 0.05
RANGE_END = "range end"
"""The word for a curve that is as long as asked; others are those of :meth:`squama.fe.walk.Walk.ending`."""
HINGE = np.eye(6)[:, 4:5]
FREE = np.eye(6)


class Condensed(NamedTuple):
    """A curve; units as the module says.

    ``along``: arrays over its points by the names of :meth:`squama.fe.walk.Walk.endless`, signed, NaN where it did not
    come to; energy and works are per pitch, N and f those of the neighbour that presses most. ``phi_e`` is the twist at
    engagement (inf if none), ``contacts`` what touches from where on, ``end`` a word for the end at ``phi_end``;
    ``moved`` (n, points, 3) how far the points of a scale's surface have moved in its frame.
    """

    along: dict[str, Array]
    phi_e: float
    phi_end: float
    end: str
    contacts: tuple[Contacts, ...]
    moved: Array

    @property
    def unbalanced(self) -> float:
        """Work of the torque less U and W_fr at the last point reached, over the work of the torque."""
        reached = np.flatnonzero(np.isfinite(self.along["T"]))
        if not reached.size:
            return 0.0
        i = reached[-1]
        W, U, W_fr = (float(self.along[name][i]) for name in ("W", "U_el", "W_fr"))
        return (W - U - W_fr) / W if W else 0.0


def curve(
    rest: Rest,
    K: Array,
    mu: float,
    phi: Sequence[float] | Array,
    *,
    exposed: Exposed | None = None,
    hinge: bool = False,
    increment: float = INCREMENT,
    dhat: float = DHAT,
    slip: float = SLIP,
) -> Condensed:
    """Follow the scales along a history of the twist.

    Parameters
    ----------
    rest : Rest
        A scale at rest, e.g. :attr:`squama.fe.geometry.Geometry.rest`.
    K : (7, 7) array
        Stiffness over (u_X, u_Y, u_Z, w_X, w_Y, w_Z, phi).
    mu : float
        Coefficient of friction.
    phi : sequence of float
        Twists per pitch at which the state is wanted, in the order of loading from 0; negative for the other sense.
    exposed : Exposed, optional
        The exposed part of a scale; a rigid rectangle without thickness if not given.
    hinge : bool
        Let the scale turn about n_Y only.
    increment, dhat, slip : float
        Largest increment of the twist; distance of contact and slip of friction's onset (see the contact module).

    Returns
    -------
    Condensed
    """
    way = Walk(rest, np.asarray(K, float), mu, HINGE if hinge else FREE, dhat, slip, exposed)
    wanted = np.asarray(phi, float)
    columns = {name: np.full(wanted.size, np.nan) for name in way.endless()}
    moved = np.full((wanted.size, *way.moved.shape[:2]), np.nan)
    end = RANGE_END
    for i, goal in enumerate(steps(wanted, wanted.size, "points by general contact")):
        if not way.run(float(goal), increment).reached:
            end = way.ending(increment)
            break
        for name, value in way.endless().items():
            columns[name][i] = value
        moved[i] = way.moved[:, :, 0]
    thick = None if exposed is None else box(rest.eta, rest.beta, exposed.thickness)
    engaged = engagement(rest, K, way.contacts[0].phi, exposed=thick, hinge=hinge) if way.contacts else np.inf
    return Condensed({**columns, "phi": wanted}, engaged, float(way.phi), end, tuple(way.contacts), moved)


def engagement(rest: Rest, K: Array, near: float, *, exposed: Exposed | None, hinge: bool) -> float:
    """Return the twist at which the scales (rigid until then) first touch, given a twist at or a little beyond it."""
    ways, contact = HINGE if hinge else FREE, RowContact(Row(rest, exposed=exposed), 0.0)
    # motions per twist of a scale that touches nothing
    rates = -ways @ np.linalg.solve(ways.T @ K[:6, :6] @ ways, ways.T @ K[:6, 6])

    def gap(x: float) -> float:
        return contact.gap(contact.corners(rates * x, x))

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

    def __init__(
        self, rest: Rest, K: Array, mu: float, ways: Array, dhat: float, slip: float, exposed: Exposed | None = None
    ) -> None:
        row = Row(rest, exposed=exposed)
        contact = RowContact(row, mu, dhat=dhat, slip=slip)
        first = _FIRST * float(K[4, 4])
        body = bent(Matrix(K), row)
        super().__init__(body, contact, ways_of(ways, row), first=first, dhat=dhat, jump=JUMP, halvings=_HALVINGS)
        self.begin()

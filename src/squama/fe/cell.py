"""The periodic cell: one pitch of finite elements with its rigid scale, in frictional contact with the scale's images.

Geometrically nonlinear quadratic elements, neo-Hookean; helical periodicity x(X + e_z) = Q(phi) x(X) + e_z; Coulomb
contact of the scale with its images. The section's mean place and turn are held in the twisted frame, since a lateral
shift is a null mode at phi = 0. Lengths in pitches, stresses in the substrate's Young's modulus.
"""

from __future__ import annotations

import numpy as np

from squama.fe.body import Body, Section
from squama.fe.contact import DHAT, SLIP, HelixContact
from squama.fe.elements import Elements, Material
from squama.fe.geometry import Geometry
from squama.fe.mesh import Pitch
from squama.fe.plate import MOTIONS, Array, Attached, Helix, inclination
from squama.fe.walk import State, Walk

FREE = np.eye(6)
HINGED = FREE[:, [0, 1, 2, 4]]
"""Roll (about n_X) and yaw (about n_Z) blocked, as in a hinge."""
COLUMNS = ("phi", "theta", *MOTIONS, "T", "N", "f", "U_el", "W_fr", "W", "gap", "p", "s", "neighbour", "iterations",
           "unbalanced")  # fmt: skip
"""What is recorded of every equilibrium: lengths in pitches, torques in E d^3, forces in E d^2, works in E d^3."""


def make_body(pitch: Pitch, geometry: Geometry) -> tuple[Body, Array]:
    """Return the body of one pitch with its scale tied in, and its masters' places at rest (n, 3)."""
    master, turned, rest = pitch.images
    elements = Elements(pitch.nodes, pitch.tets, Material(1.0, geometry.nu), master, turned)
    tied = master[pitch.tied]
    front, shares = pitch.section
    section = Section(master[front], pitch.nodes[front], shares)
    return Body(elements, [(tied, Attached(geometry, rest[tied]))], section), rest


def make_cell(
    pitch: Pitch,
    geometry: Geometry,
    mu: float,
    *,
    hinged: bool = False,
    dhat: float = DHAT,
    slip: float = SLIP,
) -> Walk:
    """Return a periodic cell at rest.

    Parameters
    ----------
    pitch, geometry : Pitch, Geometry
        Mesh of one pitch and what it is a mesh of.
    mu : float
        Coefficient of friction.
    hinged : bool
        Block roll and yaw of the scale.
    dhat, slip : float
        See :mod:`squama.fe.contact`.

    Returns
    -------
    Walk
        Its rows have the columns :data:`COLUMNS`.
    """
    body, rest = make_body(pitch, geometry)
    contact = HelixContact(Helix(geometry), mu, dhat=dhat, slip=slip)

    def record(walk: Walk, state: State) -> tuple[list[float], str]:
        corners = contact.corners(state.v, state.phi)
        touches = contact.contact.touches(corners, walk.kappa) if state.load.resultant.N > 0 else []
        p, s, k, words = np.nan, np.nan, 0, ""
        if touches:
            first = touches[0]
            p, s, k, words = first.p, first.s, first.second, f"{first.pair} (k = {first.second})"
        return [
            state.phi, inclination(geometry, state.v), *state.v, state.T, *state.load.resultant[1:],
            state.reduced.energy, walk.W_fr, walk.W, contact.contact.gap(corners, dhat), p, s, k, state.iterations,
            state.reduced.unbalanced,
        ], words  # fmt: skip

    return Walk(body, rest, contact, HINGED if hinged else FREE, record, dhat=dhat)

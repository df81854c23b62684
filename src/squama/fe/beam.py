"""A finite beam of N scales in finite elements: N pitches in a row, one end fixed, the other one turned.

The end sections are the cuts of the pitches, z = x tan(alpha) + c, and are held rigidly, as in grips: they neither
warp nor change shape. The front one is fixed. The back one is turned about z by N phi, where phi is the twist per
pitch, and cannot tilt or move sideways; along z it is free to move (``ends="free"``), or stays where it was
(``"held"``, as the periodic cell keeps the length of its pitch). So the bar may bow between its ends. Every scale has
six motions.

Lengths in pitches, stresses in the substrate's Young's modulus.
"""

from __future__ import annotations

import numpy as np

from squama.fe.beam_body import BeamBody
from squama.fe.contact import DHAT, SLIP
from squama.fe.elements import Array, Turn
from squama.fe.geometry import Geometry
from squama.fe.memory import check
from squama.fe.mesh import Pitch
from squama.fe.plate import MOTIONS, Shape, inclination, turned
from squama.fe.row_contact import Row, RowContact
from squama.fe.walk import JUMP, State, Walk

ENDS = ("free", "held")
"""What the turned end does along the axis."""
ALONG = ("phi", "T", "U_el", "W_fr", "W", "gap", "u_end", "iterations", "unbalanced")
"""What is recorded of every equilibrium; T is that of the end, energies and works are those of the whole beam."""
EACH = ("theta", *MOTIONS, "N", "f", "p", "s", "twist")
"""What is recorded of every scale: inclination and motions in the frame that turns with the section at its base, its
contact with the next one (N, f, p, s), and the twist of its pitch from cut to cut (see :meth:`BeamBody.turns`)."""


def make_beam(
    pitch: Pitch,
    geometry: Geometry,
    scales: int,
    mu: float,
    *,
    ends: str = "free",
    hinged: bool = False,
    dhat: float = DHAT,
    slip: float = SLIP,
) -> Walk:
    """Return a finite beam at rest.

    Parameters
    ----------
    pitch, geometry : Pitch, Geometry
        Mesh of one pitch and what it is a mesh of.
    scales : int
        Number of scales and pitches, 2 or more.
    mu : float
        Coefficient of friction.
    ends : {"free", "held"}
        What the turned end does along the axis.
    hinged : bool
        Block roll and yaw of the scales.
    dhat, slip : float
        See :mod:`squama.fe.contact`.

    Returns
    -------
    Walk
        Its rows have the columns :data:`ALONG`, then N columns for each of :data:`EACH`; its torque and works are those
        of the whole beam by the twist per pitch, N times the end's torque.

    Raises
    ------
    InputError
        The memory that is free does not do.
    """
    unknowns = 3 * len(pitch.images[2]) * scales
    check(scales, unknowns)
    body = BeamBody(pitch, geometry, scales)
    row = Row(geometry, scales, geometry.cut)
    contact = RowContact(row, mu, dhat=dhat, slip=slip)
    each = np.eye(6)[:, [0, 1, 2, 4]] if hinged else np.eye(6)
    ways = np.zeros((body.motions, each.shape[1] * scales + (ends == "free")))
    ways[: 6 * scales, : each.shape[1] * scales] = np.kron(np.eye(scales), each)
    if ends == "free":
        ways[6 * scales + 2, -1] = 1.0

    def record(walk: Walk, state: State) -> tuple[list[float], str]:
        v = state.v[:-6].reshape(-1, 6)
        N, f = np.zeros((2, scales))
        N[-1] = f[-1] = np.nan
        for pair in state.load.pairs:
            if pair.second == pair.first + 1:
                N[pair.first], f[pair.first] = pair.N, pair.f
        p, s, words = contact.places(state.v, state.phi, walk.kappa)
        turns = body.turns(body.places(state.z, state.v.reshape(-1, 6), state.phi))
        # the section that a scale's base stands on lies between two cuts
        share = -geometry.cut
        local = (1 - share) * turns[:-1] + share * turns[1:]
        local -= state.phi * (np.arange(scales) - geometry.cut)
        v = np.array([turned_back(geometry, *both) for both in zip(v, local, strict=True)])
        theta = [inclination(geometry, motion) for motion in v]
        gap = contact.contact.gap(contact.corners(state.v, state.phi), dhat)
        along = [
            state.phi, state.T / scales, state.reduced.energy, walk.W_fr, walk.W, gap, state.v[-4], state.iterations,
            state.reduced.unbalanced,
        ]  # fmt: skip
        return [*along, *theta, *v.T.ravel(), *N, *f, *p, *s, *np.diff(turns)], words

    # what the twist of many pitches does to a scale adds up along the beam
    return Walk(body, body.rest, contact, ways, record, dhat=dhat, jump=JUMP * max(1.0, scales / 5))


def turned_back(rest: Shape, v: Array, turn: float) -> Array:
    """Return a scale's motions (6,) in the frame that is turned with its section about z, rad."""
    from scipy.spatial.transform import Rotation

    A, back = rest.axes, Turn.at(turn).Q.T
    u = A @ (back @ (rest.base + v[:3] @ A) - rest.base)
    return np.append(u, Rotation.from_matrix(A @ back @ A.T @ turned(v[3:])).as_rotvec())

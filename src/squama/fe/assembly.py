"""A pitch, or pitches in a row, with scales and their contact: put together to be twisted, and what is recorded of it.

The endless beam is one pitch with helical periodicity x(X + e_z) = Q(phi) x(X) + e_z, its scale in contact with the
scale's images; the section's mean place and turn are held in the twisted frame, since a lateral shift is a null mode at
phi = 0. A finite beam is N pitches in a row. Its end sections are the cuts of the pitches, z = x tan(alpha) + c, and
are held rigidly, as in grips: they neither warp nor change shape. The front one is fixed. The back one is turned about
z by N phi, where phi is the twist per pitch, and cannot tilt or move sideways; along z it is free to move
(``ends="free"``), or stays where it was (``"held"``, as the periodic cell keeps the length of its pitch). So the bar
may bow between its ends. Every scale has six motions.

Geometrically nonlinear quadratic elements, neo-Hookean; Coulomb contact. Lengths in pitches, stresses in the
substrate's Young's modulus.
"""

from __future__ import annotations

import numpy as np

from squama.errors import InputError
from squama.fe.body import Body, Section, mean_turns
from squama.fe.contact import DHAT, SLIP, RowContact, where
from squama.fe.elements import Elements, Helical, Index, Material
from squama.fe.geometry import Geometry
from squama.fe.mesh import Pitch, tile
from squama.fe.plate import MOTIONS, Carried, Rest, Row, Shape, Turn, inclination, turned
from squama.fe.solver import check_memory, estimate
from squama.fe.walk import Walk
from squama.types import Array

ENDS = ("free", "held")
"""What the turned end of a finite beam does along the axis."""
FREE = np.eye(6)
HINGED = FREE[:, [0, 1, 2, 4]]
"""Roll (about n_X) and yaw (about n_Z) blocked, as in a hinge."""
COLUMNS = ("phi", "theta", "T", "N", "f", *MOTIONS, "U_el", "W_fr", "W", "gap", "p", "s", "neighbour", "iterations",
           "unbalanced")  # fmt: skip
"""What is recorded of every equilibrium of an endless beam: lengths in pitches, torques in E d^3, forces in E d^2,
works in E d^3 per pitch."""
ALONG = ("phi", "T", "U_el", "W_fr", "W", "gap", "u_end", "iterations", "unbalanced")
"""The same of a finite beam; T is that of the end, energies and works are those of the whole beam."""
EACH = ("theta", *MOTIONS, "N", "f", "p", "s", "twist")
"""And of each of its scales: inclination and motions in the frame that turns with the section at its base, its
contact with the next one (N, f, p, s), and the twist of its pitch from cut to cut (see
:func:`squama.fe.body.mean_turns`)."""


def make_body(pitch: Pitch, geometry: Geometry) -> Body:
    """Return the body of one endless pitch with its scale, if it has one, tied in."""
    master, turned, rest = pitch.images
    elements = Elements(pitch.nodes, pitch.tets, Material(1.0, geometry.nu))
    front, shares = pitch.section
    section = Section(master[front], pitch.nodes[front], shares)
    tied = master[pitch.tied]
    scales = [(tied, Carried(geometry, rest[tied]))] if tied.size else []
    return Body(Helical(elements, master, turned), rest, scales, section=section)


def make_cell(
    pitch: Pitch, geometry: Geometry, mu: float, *, hinged: bool = False, dhat: float = DHAT, slip: float = SLIP
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
    contact = RowContact(Row(geometry), mu, dhat=dhat, slip=slip)

    def record(walk: Walk) -> tuple[list[float], str]:
        p, s, k, words = np.nan, np.nan, 0, ""
        if walk.touch:
            p, s, k = walk.touch.p, walk.touch.s, walk.touch.second
            words = f"{walk.touch.pair} (k = {k})"
        return [
            walk.phi, inclination(geometry, walk.v), walk.T, walk.N, walk.f, *walk.v, *_ended(walk), p, s, k,
            walk.iterations, walk.reduced.unbalanced,
        ], words  # fmt: skip

    return Walk(make_body(pitch, geometry), contact, HINGED if hinged else FREE, record, dhat=dhat)


def _ended(walk: Walk) -> tuple[float, float, float, float]:
    """Return energy, works and gap."""
    gap = walk.contact.contact.gap(walk.contact.corners(walk.v, walk.phi), walk.dhat)
    return walk.reduced.energy, walk.W_fr, walk.W, gap


def beam_body(pitch: Pitch, geometry: Geometry, scales: int) -> tuple[Body, Index]:
    """Return the body of pitches in a row between two grips, and the nodes of their cuts (N + 1, k), the fixed first.

    The turned end is a rigid body after the scales; its motions are translation and rotation along x, y, z.
    """
    mesh, count = tile(pitch, scales), len(pitch.images[2])
    places = mesh.nodes
    rigid = [(nodes, Carried(geometry, places[nodes], k, geometry.cut)) for k, nodes in enumerate(mesh.tied)]
    # the end's frame is turned by N phi
    axis = Rest(0.0, 0.0, np.eye(3), np.zeros(3))
    rigid.append((mesh.back, Carried(axis, places[mesh.back], scales)))
    elements = Elements(places, mesh.tets, Material(1.0, geometry.nu))
    body = Body(elements, places, rigid, still=mesh.front, axis=geometry.cut)
    return body, np.stack([*(mesh.front + count * k for k in range(scales)), mesh.back])


def make_beam(
    pitch: Pitch, geometry: Geometry, scales: int, mu: float, *, ends: str = "free", hinged: bool = False
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
    check_memory(scales, unknowns, estimate(unknowns, scales))
    body, cuts = beam_body(pitch, geometry, scales)
    try:
        check_memory(scales, body.unknowns, body.solver.needs)
    except InputError:
        body.close()
        raise
    contact = RowContact(Row(geometry, scales, geometry.cut), mu)
    each = HINGED if hinged else FREE
    ways = np.zeros((body.motions, each.shape[1] * scales + (ends == "free")))
    ways[: 6 * scales, : each.shape[1] * scales] = np.kron(np.eye(scales), each)
    if ends == "free":
        ways[6 * scales + 2, -1] = 1.0

    def record(walk: Walk) -> tuple[list[float], str]:
        N, f = np.zeros((2, scales))
        N[-1] = f[-1] = np.nan
        for pair in walk.load.pairs:
            if pair.second == pair.first + 1:
                N[pair.first], f[pair.first] = pair.N, pair.f
        p, s, words = where(walk.touches, scales)
        turns = mean_turns(body.rest, walk.places(), cuts, pitch.section[1])
        # the section that a scale's base stands on lies between two cuts
        local = (1 + geometry.cut) * turns[:-1] - geometry.cut * turns[1:]
        local -= walk.phi * (np.arange(scales) - geometry.cut)
        v = np.array([turned_back(geometry, *at) for at in zip(walk.v[:-6].reshape(-1, 6), local, strict=True)])
        theta = [inclination(geometry, motion) for motion in v]
        along = [
            walk.phi, walk.T / scales, *_ended(walk), walk.v[-4], walk.iterations, walk.reduced.unbalanced
        ]  # fmt: skip
        return [*along, *theta, *v.T.ravel(), *N, *f, *p, *s, *np.diff(turns)], words

    # what the twist of many pitches does to a scale adds up along the beam
    return Walk(body, contact, ways, record, slack=max(1.0, scales / 5))


def turned_back(rest: Shape, v: Array, turn: float) -> Array:
    """Return a scale's motions (6,) in the frame that is turned with its section about z, rad."""
    from scipy.spatial.transform import Rotation

    A, back = rest.axes, Turn.at(turn).Q.T
    u = A @ (back @ (rest.base + v[:3] @ A) - rest.base)
    return np.append(u, Rotation.from_matrix(A @ back @ A.T @ turned(v[3:])).as_rotvec())

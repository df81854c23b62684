"""One pitch, or pitches in a row, with scales and contact: bodies and recorded columns of a twisted beam.

The endless beam is one pitch with helical periodicity x(X + e_z) = Q(phi) x(X) + e_z, its scale in contact with the
scale's images; the section's mean place and turn are held in the twisted frame, since a lateral shift is a null mode at
phi = 0. Bent and twisted it is x(X + e_z) = g(x(X)) with the screw g of :mod:`squama.fe.periodic`; its strains are
those of the line of the sections' mean places, and the stretch is free (no axial force) or held. A finite beam is N
pitches in a row (:mod:`squama.fe.closed`). Its end sections are planes z = x tan(alpha) + c, and are held rigidly, as
in grips: they neither warp nor change shape. The front one is fixed. The back one is turned about z by N phi, where phi
is the twist per pitch, and cannot tilt or move sideways; along z it is free to move (``ends="free"``), or stays where
it was (``"held"``, as the periodic cell keeps the length of its pitch). So the bar may bow between its ends. Every
scale has six motions.

Geometrically nonlinear quadratic elements, neo-Hookean; Coulomb contact. Lengths in pitches, stresses in the
substrate's Young's modulus.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import numpy as np

from squama.beam.matrixfile import MOTIONS
from squama.errors import InputError
from squama.fe.averages import Section
from squama.fe.body import Body, Matrix, bent, mean_turns, ways_of
from squama.fe.closed import row_mesh, sections
from squama.fe.contact import DHAT, SLIP, RowContact, forces, where
from squama.fe.elements import Elements, Helical, Material
from squama.fe.exposed import Exposed
from squama.fe.geometry import Geometry
from squama.fe.mesh import Pitch, Tiled
from squama.fe.periodic import STRAINS, Course, Leg
from squama.fe.plate import Carried, Rest, Turn, inclination, turned
from squama.fe.rows import Row
from squama.fe.solver import check_memory, estimate
from squama.fe.walk import Recorded, Walk
from squama.types import Array

ENDS = ("free", "held")
"""Axial motion of the turned end of a finite beam."""
FREE = np.eye(6)
HINGED = FREE[:, [0, 1, 2, 4]]
"""Roll (about n_X) and yaw (about n_Z) blocked, as in a hinge."""


STRAIN_NAMES = ("twist", "bend", "stretch")


def make_body(pitch: Pitch, geometry: Geometry, course: Course | None = None) -> Body:
    """Return the body of one endless pitch, whose scale, if it has one, is tied in as a rigid body."""
    master, turned, rest = pitch.images
    elements = Elements(pitch.nodes, pitch.tets, Material(1.0, geometry.nu))
    section = Section.of_pitch(master[pitch.front], pitch.nodes[pitch.front], pitch.shares, course)
    tied = master[pitch.tied]
    scales = [(tied, Carried(geometry.rest, rest[tied]))] if tied.size else []
    return Body(Helical(elements, master, turned, course), rest, scales, sections=[section])


def beam_body(mesh: Tiled, geometry: Geometry) -> Body:
    """Return the body of a finite beam: pitches in a row between two rigidly gripped end sections.

    The turned end is a rigid body after the scales; its motions are translation and rotation along x, y, z.
    """
    places, (front, back) = mesh.nodes, mesh.ends
    rigid = [(nodes, Carried(geometry.rest, places[nodes], k, geometry.cut)) for k, nodes in enumerate(mesh.tied)]
    # the end's frame is turned by N phi
    axis = Rest(0.0, 0.0, np.eye(3), np.zeros(3))
    rigid.append((back, Carried(axis, places[back], len(mesh.tied))))
    elements = Elements(places, mesh.tets, Material(1.0, geometry.nu))
    return Body(elements, places, rigid, still=front, axis=geometry.cut)


def make_walk(
    pitch: Pitch,
    geometry: Geometry,
    mu: float,
    *,
    scales: int | None = None,
    ends: str = "free",
    hinged: bool = False,
    exposed: Exposed | None = None,
) -> Walk:
    """Return an endless or a finite beam of elements at rest, ready to be twisted.

    ``pitch``: mesh of one pitch of the ``geometry``; ``scales``: number of scales and pitches, an endless beam without;
    ``ends``: axial motion of the turned end of a finite beam, :data:`ENDS`; ``hinged``: roll and yaw are blocked;
    ``exposed``: exposed part of a scale, without it a rigid rectangle without thickness.

    Lengths are in pitches, torques in E d^3, forces in E d^2. The columns of an endless beam are twist, inclination,
    torque, forces, motions, works per pitch, and the number of the touched ``neighbour``. Of a finite one T is the
    torque at the end (the walk's own is N times that: its works are those of the whole beam by the twist per pitch),
    ``u_end`` the move of the end, and for each scale there are the inclination ``theta`` and motions in the frame that
    turns with the section at its base, the contact with the next one (N, f, p, s), and the ``twist`` of its pitch from
    cut to cut (see :func:`squama.fe.body.mean_turns`). ``contact`` names the touching features, and ``deflection`` is
    the farthest that a point of a scale has moved in the scale's frame.

    Raises InputError where the free memory is too small.
    """
    each = HINGED if hinged else FREE
    if scales is None:
        row = Row(geometry.rest, exposed=exposed)
        return Walk(bent(make_body(pitch, geometry), row), RowContact(row, mu), ways_of(each, row), _endless)
    mesh = row_mesh(pitch, geometry.oblique, scales)
    unknowns = 3 * len(mesh.nodes)
    check_memory(scales, unknowns, estimate(unknowns, scales))
    body = beam_body(mesh, geometry)
    try:
        check_memory(scales, body.unknowns, body.solver.needs)
    except InputError:
        body.solver.close()
        raise
    row = Row(geometry.rest, scales, geometry.cut, exposed)
    moved = np.zeros((body.motions, each.shape[1] * scales + (ends == "free")))
    moved[: 6 * scales, : each.shape[1] * scales] = np.kron(np.eye(scales), each)
    if ends == "free":
        moved[6 * scales + 2, -1] = 1.0
    record = partial(_finite, geometry, mesh, pitch.shares)
    # displacements of a scale by the twist add up along the beam
    return Walk(bent(body, row), RowContact(row, mu), ways_of(moved, row), record, slack=max(1.0, scales / 5))


def make_bent(
    carrier: Pitch | Array,
    geometry: Geometry,
    mu: float,
    *,
    free: Sequence[str] = ("stretch",),
    hinged: bool = False,
    exposed: Exposed | None = None,
    dhat: float = DHAT,
    slip: float = SLIP,
) -> Walk:
    """Return an endless beam at rest, to be bent and twisted along paths set by :meth:`squama.fe.walk.Walk.aim`.

    ``carrier``: mesh of one pitch, or the stiffness matrix (9, 9) of a joint over a scale's motions, twist, bend and
    stretch; ``free``: those of "twist", "bend" and "stretch" that are free, with no torque, moment or axial force;
    ``dhat``, ``slip``: see :mod:`squama.fe.contact`; otherwise as :func:`make_walk`.

    Columns as of its endless beam, with ``psi``, ``phi`` and ``stretch`` per pitch, and their conjugate loads, those of
    the bar included: ``M`` and ``T`` (E d^3) and the axial ``force`` (E d^2).
    """
    each, leg = HINGED if hinged else FREE, Leg()
    row = Row(geometry.rest, exposed=exposed, course=leg)
    loose = [6 + i for i, name in enumerate(STRAIN_NAMES) if name in free]
    motions = np.zeros((6 + STRAINS, each.shape[1] + len(loose)))
    motions[:6, : each.shape[1]] = each
    motions[loose, range(each.shape[1], motions.shape[1])] = 1.0
    body = make_body(carrier, geometry, leg) if isinstance(carrier, Pitch) else Matrix(carrier, leg)
    contact = RowContact(row, mu, dhat=dhat, slip=slip)
    return Walk(bent(body, row), contact, ways_of(motions, row), _strained)


def _strained(walk: Walk) -> Recorded:
    part = slice(6, 6 + STRAINS)
    strains = walk.contact.row.course.at(walk.v, walk.phi)
    forces = walk.reduced.s[part] + walk.load.total[:-1][part]
    return {
        **_endless(walk),
        "way": walk.phi,
        **dict(zip(("phi", "psi", "stretch", "T", "M", "force"), [*strains.tolist(), *forces.tolist()], strict=True)),
    }


def _endless(walk: Walk) -> Recorded:
    touch, most = walk.touch, walk.load.strongest
    return {
        "phi": walk.phi,
        "theta": inclination(walk.contact.row.rest, walk.v),
        "T": walk.T,
        "N": most.N,
        "f": most.f,
        **dict(zip(MOTIONS, walk.v[:6].tolist(), strict=True)),
        **walk.works(walk.contact.dhat),
        "p": touch.p if touch else np.nan,
        "s": touch.s if touch else np.nan,
        "neighbour": touch.second if touch else 0,
        "deflection": walk.deflection,
        "contact": f"{touch.pair} (k = {touch.second})" if touch else "",
    }


def _finite(geometry: Geometry, mesh: Tiled, shares: Array, walk: Walk) -> Recorded:
    scales = len(mesh.tied)
    N, f = forces(walk.load, scales)
    p, s, words = where(walk.touches, scales)
    places, base = walk.places(), np.arange(scales)
    turns = mean_turns(mesh.nodes[mesh.cuts], places[mesh.cuts], shares)
    before, after = (sections(mesh, geometry, at, base) for at in (mesh.nodes, places))
    local = mean_turns(before, after, shares) - walk.phi * (base - geometry.cut)
    v = np.array(
        [turned_back(geometry.rest, *at) for at in zip(walk.v[: 6 * scales].reshape(-1, 6), local, strict=True)]
    )
    theta = np.array([inclination(geometry.rest, motion) for motion in v])
    return {
        "phi": walk.phi,
        "T": walk.T / scales,
        **walk.works(walk.contact.dhat),
        "u_end": walk.v[6 * scales + 2],
        "theta": theta,
        **dict(zip(MOTIONS, v.T, strict=True)),
        "N": N,
        "f": f,
        "p": p,
        "s": s,
        "twist": np.diff(turns),
        "contact": words,
        "deflection": walk.deflection,
    }


def turned_back(rest: Rest, v: Array, turn: float) -> Array:
    """Return a scale's motions (6,) in the frame turned about z with its section, by ``turn``, rad."""
    from scipy.spatial.transform import Rotation

    A, back = rest.axes, Turn.at(turn).Q.T
    u = A @ (back @ (rest.base + v[:3] @ A) - rest.base)
    return np.append(u, Rotation.from_matrix(A @ back @ A.T @ turned(v[3:])).as_rotvec())

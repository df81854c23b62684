"""A finite beam of elements under load: one end clamped, the other moved along a shift, a bend or a twist.

A pitch of bar whose scale has no exposed part lies beside the first and the last scale, so that all scales stand in a
whole bar. Plain bar lies beyond, up to end sections across the bar (:mod:`squama.fe.closed`): a bar that is twisted far
leaves sections along oblique scales at an angle. Six conditions hold each of them; their tractions are those of
Saint-Venant's bar in tension, bending and torsion, so the ends are free to warp. The mean place and turns of the far
section are its motion: one is imposed, others are free or held.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import numpy as np

from squama.fe.averages import Section
from squama.fe.body import Body, bent, ways_of
from squama.fe.closed import row_mesh, sections
from squama.fe.contact import RowContact, forces, where
from squama.fe.elements import Elements, Material
from squama.fe.exposed import Exposed
from squama.fe.geometry import Geometry
from squama.fe.mesh import Pitch, Tiled
from squama.fe.periodic import End, Moves, stays
from squama.fe.plate import Carried, Turn, inclined, turned
from squama.fe.rows import Row
from squama.fe.solver import check_memory, estimate
from squama.fe.walk import Recorded, Walk
from squama.model.section import torsion_shear
from squama.types import Array

BLANK = 1
"""Number of pitches of bar at either end whose scales have no exposed part."""
SHIFT, TILT, TWIST = slice(0, 3), slice(3, 5), 5
"""The end's motions: shift along x, y, z; tilt about x and y; twist per pitch."""


class Lead(NamedTuple):
    """Imposed motion of the far end.

    ``towards`` (3,): direction of a shift; ``turn``: "bend" or "twist" in place of it; ``coaxial``: the end neither
    moves sideways nor tilts.
    """

    towards: Array | None = None
    turn: str = ""
    coaxial: bool = False

    def per_way(self, pitches: int) -> float:
        """Return shift (pitches) or turn (rad) per way; a way of 1 is about one radian per pitch at the root."""
        return float(pitches if self.turn else pitches**2 / 3)

    def rate(self, pitches: int) -> Array:
        """Return the derivatives (6,) of the end's motions by the way."""
        out = np.zeros(6)
        if self.turn == "twist":
            out[TWIST] = 1.0
        elif self.turn:
            # towards the scaled face: about -x
            out[TILT.start] = -self.per_way(pitches)
        elif self.towards is not None:
            out[SHIFT] = self.per_way(pitches) * self.towards
        return out

    def free(self, pitches: int) -> list[int]:
        """Return the numbers of the free motions of the end."""
        return [2] if self.coaxial else np.flatnonzero(self.rate(pitches) == 0).tolist()


def make_loaded(
    pitch: Pitch, geometry: Geometry, mu: float, scales: int, lead: Lead, exposed: Exposed | None = None
) -> Walk:
    """Return a beam of N scales at rest with an imposed motion of its far end; it has :func:`length` pitches.

    ``pitch``: mesh of one pitch of the ``geometry``; ``exposed``: exposed part of a scale, without it a rigid rectangle
    without thickness. The way is one number, see :meth:`Lead.per_way`; T is the derivative of the work by it.

    Columns: ``way``, ``load``: force or moment (E d^2, E d^3); ``x_end``, ``y_end``, ``z_end`` (pitches): shift of the
    far end; works of the whole beam; for each scale the inclination ``theta`` to its section, N and f on the next one;
    ``contact`` in words. Raises InputError where the free memory is too small.
    """
    count, pitches = scales + 2 * BLANK, length(geometry, scales)
    mesh = row_mesh(pitch, geometry.square, count)
    unknowns = 3 * len(mesh.nodes)
    check_memory(scales, unknowns, estimate(unknowns, pitches))
    mesh = mesh._replace(nodes=mesh.nodes - np.array([0.0, 0.0, BLANK]))
    near, far = (np.array([0.0, 0.0, z + geometry.square.start - BLANK]) for z in (0, pitches))
    rate = lead.rate(pitches)
    course = End(count, pitches, far, rate)
    order = [*range(BLANK, BLANK + scales), *range(BLANK), *range(BLANK + scales, count)]
    tied = [(mesh.tied[j], Carried(geometry.rest, mesh.nodes[mesh.tied[j]], j - BLANK, near[2])) for j in order]
    sections = [
        _end(mesh, geometry, pitch, 0, near, lambda loads: stays(loads)._replace(t=near[None])),
        _end(mesh, geometry, pitch, -1, far, course.frame),
    ]
    elements = Elements(mesh.nodes, mesh.tets, Material(1.0, geometry.nu), course)
    body = Body(elements, mesh.nodes, tied, sections=sections, axis=near[2] if rate[TWIST] else None)
    row = Row(geometry.rest, scales, near[2], exposed, course)
    free, bodies = lead.free(pitches), 6 * count
    moved = np.zeros((body.motions, bodies + len(free)))
    moved[:bodies, :bodies] = np.eye(bodies)
    moved[bodies + np.array(free), bodies + np.arange(len(free))] = 1.0
    record = partial(_recorded, geometry, mesh, pitch.shares, lead, scales)
    return Walk(bent(body, row), RowContact(row, mu), ways_of(moved, row), record, slack=max(1.0, pitches / 5))


def length(geometry: Geometry, scales: int) -> int:
    """Return the length of a part of N scales, pitches."""
    return scales + 2 * BLANK + geometry.square.pitches


def _end(
    mesh: Tiled, geometry: Geometry, pitch: Pitch, cut: int, place: Array, frame: Callable[[Array], Moves]
) -> Section:
    """Return an end section; its conditions are the work of Saint-Venant's tractions on its displacements."""
    used = pitch.shares != 0
    nodes, shares = mesh.ends[cut][used], pitch.shares[used]
    arms = mesh.nodes[nodes] - place
    x, y, _ = arms.T
    none = np.zeros(x.size)
    twist = np.column_stack([*torsion_shear(x, y, geometry.width, 2 * geometry.lam), none])
    turns = np.array([np.column_stack([none, none, y]), np.column_stack([none, none, x]), twist])
    return Section(nodes, arms, shares, frame, turns)


def _recorded(geometry: Geometry, mesh: Tiled, shares: Array, lead: Lead, scales: int, walk: Walk) -> Recorded:
    N, f = forces(walk.load, scales)
    end, rest, places = walk.contact.row.course.at(walk.v, walk.phi), geometry.rest, walk.places()
    theta = np.empty(scales)
    both = (sections(mesh, geometry, at, np.arange(scales)) for at in (mesh.nodes, places))
    for i, (before, after) in enumerate(zip(*both, strict=True)):
        # scales are counted in frames that turn with the twist
        frame = Turn.at((i + BLANK - geometry.square.start) * end[TWIST]).Q
        n_X = frame @ rest.axes.T @ turned(walk.v[6 * i + 3 : 6 * i + 6])[:, 0]
        theta[i] = inclined(rest, attitude(before, after, shares).T @ n_X)
    return {
        "way": walk.phi,
        "load": walk.T / lead.per_way(length(geometry, scales)),
        **walk.works(walk.contact.dhat),
        **dict(zip(("x_end", "y_end", "z_end"), end[SHIFT], strict=True)),
        "theta": theta,
        "N": N,
        "f": f,
        "contact": where(walk.touches, scales)[2],
        "deflection": walk.deflection,
    }


def attitude(rest: Array, places: Array, weights: Array) -> Array:
    """Return the rotation (3, 3) of best fit to places (k, 3), weighted, about the mean place (Kabsch)."""
    X, x = (at - weights @ at for at in (rest, places))
    U, _, V = np.linalg.svd((weights[:, None] * x).T @ X)
    return np.asarray(U @ np.diag([1.0, 1.0, np.linalg.det(U @ V)]) @ V)

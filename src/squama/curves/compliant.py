"""Thick, elastic scales on compliant joints: their stiffness, their path for the contact solver, notes on validity.

A scale has six motions against the substrate (:mod:`squama.joints`) and bends if its modulus is given; with ``ideal``
it is thin and rigid.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from squama.beam import joint_law
from squama.beam.design import Beam
from squama.beam.joint_law import Free
from squama.beam.matrixfile import SHAPE, TAB, inclination_stiffness, twisting_stiffness
from squama.contacts import path, states
from squama.curves.way import Case
from squama.errors import refuse
from squama.joints import lateral, tilt
from squama.joints.choice import Joint, joint_of, shape
from squama.loads import LOADS, STRAIGHT, STRAINS, Load, holding
from squama.people import per_pitch
from squama.types import Array
from squama.units import change

TAB_LIMIT = 0.025
"""Error of a torque by :func:`rigid_tab` from which it is reported; the actual error may be twice as large."""
STRAIN_LIMIT = 0.3
"""Twist per pitch, rad, up to which the model was compared with nonlinear finite elements."""
COMPARED = f"the joint's stiffness was compared with nonlinear elements up to {per_pitch(STRAIN_LIMIT)}"
"""Words of the note for cells that are strained beyond :data:`STRAIN_LIMIT`."""
TWIST = LOADS["twisting"].verb


class Held(NamedTuple):
    """Joint of a beam's scales, and stiffnesses in SI units.

    ``K`` is that of scales on one face, over ``modulus`` d^3; ``rigidity`` is the beam's, in twisting (N m^2).
    ``free``: flags of strains without a moment or force; ``aside``: the bar's stiffness against lateral bend over that
    against bend; ``tilt``: motion of a scale of a row per unit of its tilt. For scales on both faces ``seen`` and
    ``own`` are those of :func:`squama.contacts.path.beams`.
    """

    joint: Joint
    K: Array
    modulus: float
    K_theta: float
    rigidity: float
    free: Free
    aside: float
    tilt: tuple[float, ...] = (0.0, 0.0, 0.0)
    seen: tuple[int, ...] = ()
    own: tuple[float, ...] = ()

    @property
    def bar(self) -> path.Bar:
        """Arguments of the contact solver that describe the bar."""
        return {"free": self.free, "aside": self.aside, "seen": self.seen, "own": self.own, "tilt": self.tilt}

    @classmethod
    def of(cls, beam: Beam, *loaded: str) -> Held:
        """Return the joint of a beam with the strains ``loaded``, by default the twist; refuse an unknown joint."""
        joint = joint_of(beam)
        if joint.K is None:
            refuse("joint", '"compliant"', joint.note, 'write joint="hinge" (--joint hinge)')
        K = np.asarray(joint.K, float)
        own = _own(beam, K) if beam.other else ()
        K_theta = inclination_stiffness(K[:7, :7]) * beam.unit_moment
        free = beam.given.free(*(loaded or (TWIST,)))
        aside = float(lateral.stiffness(K, shape(beam)) / K[7, 7]) if len(K) > 7 else 1.0
        E, rigidity = beam.substrate.youngs_modulus, _rigidity(beam, K, own)
        leans = tuple(tilt.tilts(shape(beam)).tolist()) if len(K) > 7 else (0.0, 0.0, 0.0)
        return cls(joint, K, E, K_theta, rigidity, free, aside, leans, beam.given.seen, own)


def _rigidity(beam: Beam, K: Array, own: Sequence[float]) -> float:
    """Return the torsional rigidity without contact, N m^2; ``own``: the bar's stiffness, for scales on both faces."""
    given = beam.given
    return twisting_stiffness(K, given.free(TWIST), given.seen, own) * beam.unit_moment * beam.pitch


def _own(beam: Beam, K: Array) -> tuple[float, ...]:
    """Return the bar's own stiffness against its four strains, E d^3, which the matrices K of both faces include.

    A given inclusion factor is that of the whole beam: the stiffness against twist is then set so that the beam has it.
    """
    bend, twist, aside, stretch = joint_law.own(beam.sizes)
    if beam.joint.inclusion_factor is not None:
        whole = _rigidity(beam, K, (bend, 0.0, aside, stretch))
        twist = (whole - beam.torsional_rigidity) / (beam.pitch * beam.unit_moment)
    # a matrix (7, 7) knows the twist alone
    return (bend, twist, aside, stretch) if len(K) == 9 else (0.0, twist, 0.0, 0.0)


def scale(beam: Beam, *, ideal: bool) -> path.Scale:
    """Return a beam's scale for the contact solver; thin and rigid with ``ideal``, else elastic if it has a modulus."""
    s, d = beam.scale, beam.pitch
    thin = path.Scale(beam.eta, beam.beta, beam.lam, s.alpha, s.theta0, 0.0)
    if ideal:
        return thin
    thick = thin._replace(h=s.thickness / d)
    if s.youngs_modulus is None:
        return thick
    return thick._replace(D=beam.plate_rigidity / beam.unit_moment, nu=s.nu)


class Path(NamedTuple):
    """Thick scales in the contact solver: their joint, and their ``way``, with the first contact if it was searched.

    ``toward``: direction in bend and twist of that search, zeros if there was none.
    """

    beam: Beam
    held: Held
    way: path.Path
    toward: tuple[float, float]

    @classmethod
    def of(
        cls,
        beam: Beam,
        mu: float,
        loaded: Sequence[str],
        *,
        ideal: bool,
        toward: tuple[float, float] = (0.0, 0.0),
        most: float = path.RANGE,
    ) -> Path:
        """Return the path of a beam with the strains ``loaded``.

        The first contact is searched up to the load angle ``most`` (rad per pitch) in the direction ``toward``, if it
        is not zero.
        """
        held, plate = Held.of(beam, *loaded), scale(beam, ideal=ideal)
        way = path.Path.at_rest(plate, held.K, mu, **held.bar)
        return cls(beam, held, way.looked(toward, most) if any(toward) else way, toward)

    @property
    def lead(self) -> int:
        """Face whose scales touch first: 0 the scaled face, 1 the other one."""
        return int(np.argmin([c.phi for c in self.way.contacts]))

    @property
    def seen(self) -> list[tuple[int, ...]]:
        """Signs of bend, twist and lateral bend seen by each face, the scaled face first."""
        return [(1, 1, 1), *([self.held.seen] if self.held.seen else [])]

    def as_twisted(self, met: path.Contact, face: int) -> path.Contact:
        """Return a contact on a face, mirrored if the face sees a negative twist."""
        return met.mirrored if self.toward[1] * self.seen[face][1] < 0 else met

    def contact(self, face: int) -> path.Contact:
        """Return the first contact on a face, see :meth:`as_twisted`."""
        return self.as_twisted(self.way.contacts[face], face)

    @property
    def unit_moment(self) -> float:
        """Unit of moments in the contact solver, N m."""
        return self.held.modulus * self.beam.pitch**3

    @property
    def rigidities(self) -> Array:
        """Stiffness without contact against twist and bend (2, 2), N m^2; (1, 1) for a joint without bend."""
        return np.asarray(states.bare(self.way.beams)[0] * (self.unit_moment * self.beam.pitch))

    def case(self, load: Load) -> Case:
        """Return the beam's data for a load."""
        beam, held = self.beam, self.held
        bare = held.rigidity if load.sided else float(self.rigidities[1, 1])
        return Case(beam.pitch, bare, held.K_theta, beam.eta, beam.scale.theta0, self.toward[1] < 0)


def attributes(held: Held, *loaded: str) -> dict[str, float | str]:
    """Return the attributes of a result on the joint and on held strains, for a beam with the strains ``loaded``."""
    fixed = [name for name, free in zip(STRAINS, held.free, strict=True) if not free and name not in loaded]
    straight = len(fixed) + len(loaded) == len(STRAINS)
    return {
        "K_theta": held.K_theta,
        "rigidity": held.rigidity,
        "joint_source": held.joint.source,
        "band": held.joint.band,
        "hold": STRAIGHT if straight else holding(fixed),
        "neutral": "free" if held.free[-1] else "middle",
    }


def rigid_tab(group: float, inclusion: float) -> float:
    """Return the estimated relative excess of a torque because the joint's embedded part is rigid (theory: joint).

    From the group (E_s/E)(t_s/L)^3 and the torque per twist over that of the bare bar, fitted to finite elements.
    """
    return 0.11 * (inclusion - 1) / (1 + group / 1.5)


def notes(held: Held, beam: Beam, far: float, *, ideal: bool) -> list[str]:
    """Return notes where a curve up to the twist ``far`` (rad per pitch) leaves the range of the comparisons."""
    lines = [held.joint.note] if held.joint.note else []
    if not beam.given.may and set(beam.held) < set(STRAINS):
        lines.append(
            "the beam is held straight: joint.matrix knows no bend (squama joint --matrix writes all nine motions)"
        )
    # a matrix of elements names its shape; one without shape, or a factor, was measured and includes the tab's bending
    matrix, factor = beam.joint.matrix, beam.joint.inclusion_factor
    stated = set() if matrix is None else set(matrix.made)
    measured = factor is not None or (matrix is not None and (stated.isdisjoint(SHAPE) or TAB[0] in stated))
    measured |= held.joint.bends
    if beam.scale.youngs_modulus is not None and beam.zeta > 0 and not (ideal or measured):
        group = beam.modulus_ratio / beam.slenderness**3
        error = rigid_tab(group, held.rigidity / (beam.G_B * beam.J))
        if error > TAB_LIMIT:
            lines.append(
                f"the torque is too high by about {change(error)}: the joint takes the embedded part of a scale as "
                f"rigid, but it bends (squama joint --tab elastic), with (E_s/E)(t_s/L)^3 = {group:.2g}"
            )
    if far > STRAIN_LIMIT:
        lines.append(
            f"trust the curve up to {per_pitch(STRAIN_LIMIT)}, not to its end at {math.degrees(far):.3g}: {COMPARED}"
        )
    return lines

"""Thick, elastic scales on a compliant joint: what holds them, and what a result says of that.

A scale has six motions against the substrate (:mod:`squama.joints`) and bends where its modulus is known; ``ideal``
makes it thin and rigid.
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
from squama.joints.choice import Joint, joint_of
from squama.loads import LOADS, STRAIGHT, STRAINS, Load, holding
from squama.people import per_pitch
from squama.types import Array
from squama.units import change

TAB_LIMIT = 0.025
"""Error of a torque by :func:`rigid_tab` from which on it is told; it may then be twice as large."""
STRAIN_LIMIT = 0.3
"""Twist per pitch, rad, up to which the model was compared with nonlinear elements."""
COMPARED = f"the joint's stiffness was compared with nonlinear elements up to {per_pitch(STRAIN_LIMIT)}"
"""What is said of cells that are strained farther."""
TWIST = LOADS["twisting"].verb


class Held(NamedTuple):
    """What holds a beam's scales, and its figures in SI units.

    ``K`` is of scales on one face, over ``modulus`` d^3; ``rigidity`` is the beam's, in twisting. ``free``: strains
    without a moment or force; ``aside``: the bar's stiffness against lateral bend over that against bend. With scales
    on both faces ``seen`` and ``own`` as of :func:`squama.contacts.path.beams`.
    """

    joint: Joint
    K: Array
    modulus: float
    K_theta: float
    rigidity: float
    free: Free
    aside: float
    seen: tuple[int, ...] = ()
    own: tuple[float, ...] = ()

    @property
    def bar(self) -> path.Bar:
        """What the contact solver takes of the bar, by argument."""
        return {"free": self.free, "aside": self.aside, "seen": self.seen, "own": self.own}

    @classmethod
    def of(cls, beam: Beam, *loaded: str) -> Held:
        """Return that of a beam with strains ``loaded``, by default the twist; refuse one whose joint is not known."""
        joint = joint_of(beam)
        if joint.K is None:
            refuse("joint", '"compliant"', joint.note, 'write joint="hinge" (--joint hinge)')
        K = np.asarray(joint.K, float)
        own = _own(beam, K) if beam.other else ()
        K_theta = inclination_stiffness(K[:7, :7]) * beam.unit_moment
        bar, free = beam.substrate, beam.given.free(*(loaded or (TWIST,)))
        aside = (bar.width / bar.thickness) ** 2
        E, rigidity = bar.youngs_modulus, _rigidity(beam, K, own)
        return cls(joint, K, E, K_theta, rigidity, free, aside, beam.given.seen, own)


def _rigidity(beam: Beam, K: Array, own: Sequence[float]) -> float:
    """Return the torsional rigidity without contact, N m^2; ``own``: with two faces what the matrices of both hold."""
    given = beam.given
    return twisting_stiffness(K, given.free(TWIST), given.seen, own) * beam.unit_moment * beam.pitch


def _own(beam: Beam, K: Array) -> tuple[float, ...]:
    """Return what the matrices K of both faces hold alike, E d^3: the bar's own stiffness against its four strains.

    A given inclusion factor is the whole beam's: what both hold of the twist is so large that it becomes that.
    """
    bend, twist, aside, stretch = joint_law.own(beam.sizes)
    if beam.joint.inclusion_factor is not None:
        whole = _rigidity(beam, K, (bend, 0.0, aside, stretch))
        twist = (whole - beam.torsional_rigidity) / (beam.pitch * beam.unit_moment)
    # a matrix (7, 7) knows the twist alone
    return (bend, twist, aside, stretch) if len(K) == 9 else (0.0, twist, 0.0, 0.0)


def scale(beam: Beam, *, ideal: bool) -> path.Scale:
    """Return a beam's scale; ``ideal``: thin and rigid, elastic else where its modulus is known."""
    s, d = beam.scale, beam.pitch
    thin = path.Scale(beam.eta, beam.beta, beam.lam, s.alpha, s.theta0, 0.0)
    if ideal:
        return thin
    thick = thin._replace(h=s.thickness / d)
    if s.youngs_modulus is None:
        return thick
    return thick._replace(D=beam.plate_rigidity / beam.unit_moment, nu=s.nu)


class Path(NamedTuple):
    """Thick scales for the contact solver: what holds them, and their ``way``, of which the first contact is known.

    ``toward``: the bend and twist towards which that was looked for, zeros where it was not.
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
        """Return the path of a beam with strains ``loaded``.

        What touches first is looked for as far as ``most``, if there is a bend or a twist ``toward`` which.
        """
        held, plate = Held.of(beam, *loaded), scale(beam, ideal=ideal)
        way = path.Path.at_rest(plate, held.K, mu, **held.bar)
        return cls(beam, held, way.looked(toward, most) if any(toward) else way, toward)

    @property
    def lead(self) -> int:
        """Number of the face whose scales touch first: 0 the scaled one, 1 the other."""
        return int(np.argmin([c.phi for c in self.way.contacts]))

    @property
    def seen(self) -> list[tuple[int, ...]]:
        """Signs of bend, twist and lateral bend that each face sees, that of the scaled one first."""
        return [(1, 1, 1), *([self.held.seen] if self.held.seen else [])]

    def as_twisted(self, met: path.Contact, face: int) -> path.Contact:
        """Return what meets on a face as where the twist that the face sees is not below 0."""
        return met.mirrored if self.toward[1] * self.seen[face][1] < 0 else met

    def contact(self, face: int) -> path.Contact:
        """Return what touches first on a face, see :meth:`as_twisted`."""
        return self.as_twisted(self.way.contacts[face], face)

    @property
    def unit_moment(self) -> float:
        """What moments of the contact solver are over, N m."""
        return self.held.modulus * self.beam.pitch**3

    @property
    def rigidities(self) -> Array:
        """Stiffness without contact against twist and bend (2, 2), N m^2; (1, 1) where the joint knows the twist."""
        return np.asarray(states.bare(self.way.beams)[0] * (self.unit_moment * self.beam.pitch))

    def case(self, load: Load) -> Case:
        """Return what the beam and its joint bring to a load."""
        beam, held = self.beam, self.held
        bare = held.rigidity if load.sided else float(self.rigidities[1, 1])
        return Case(beam.pitch, bare, held.K_theta, beam.eta, beam.scale.theta0, self.toward[1] < 0)


def attributes(held: Held, *loaded: str) -> dict[str, float | str]:
    """Return what answers say of the joint, and of what holds a beam with strains ``loaded``."""
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
    """Return by about how much a torque is too high since the joint takes the embedded part as rigid (theory: joint).

    By the group (E_s/E)(t_s/L)^3 and the torque per twist over that of the bare bar, fitted to elements.
    """
    return 0.11 * (inclusion - 1) / (1 + group / 1.5)


def notes(held: Held, beam: Beam, far: float, *, ideal: bool) -> list[str]:
    """Say where a curve to the twist ``far`` (rad per pitch) leaves what the model was compared with."""
    lines = [held.joint.note] if held.joint.note else []
    if not beam.given.may and set(beam.held) < set(STRAINS):
        lines.append(
            "the beam is held straight: joint.matrix knows no bend (squama joint --matrix writes all nine motions)"
        )
    # a matrix of elements says for which shape it was made; in one that does not, or a factor, the tab's give is in
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

"""A vibrating beam: branches in both senses, for hinges or compliant joints, and its inertia and frequency."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from squama.beam import mass
from squama.beam.design import Beam
from squama.contacts import path
from squama.curves import both_faces, compliant, hinge_cycles
from squama.curves.chosen import MODELS
from squama.curves.way import direction
from squama.dynamics import hinge_branches, joint_branches, motion
from squama.dynamics.branches import APART, Side
from squama.dynamics.decay import Limit, Sides
from squama.dynamics.hinge_branches import FINEST
from squama.dynamics.modes import SHAPES
from squama.errors import refuse
from squama.loads import ENDLESS, UNIFORM, Load
from squama.people import per_pitch

ROUGH = 1e-7
"""Relative error of a time step on branches of thick scales, limited by their increments."""
MOST = 1.0
"""Largest twist per pitch, rad, to which a beam with thick scales is followed."""
FARTHER = 1.001
"""Factor on the released twist up to which the beam is followed."""
TOO_HIGH = 0.11
"""Relative excess of the frequency without a rotor due to the assumed shapes: 120 instead of pi^4 in bending."""
NOTED = 0.005
"""Share of the frequency from which the effect of an unknown mass is reported."""


class Model(NamedTuple):
    """Model of a vibrating beam: load, friction, force law, kind of joint, thin and rigid scales or not, ends."""

    load: Load
    mu: float
    law: str
    joint: str
    ideal: bool
    ends: str = ENDLESS

    def held_in(self, mode: str) -> str:
        """Return the word for the ends in a mode, which holds them itself."""
        return self.ends if self.ends == ENDLESS or mode == UNIFORM else mode

    def rigidity(self, beam: Beam) -> float:
        """Return the rigidity of a beam without contact, N m^2."""
        return MODELS[self.joint].programs().case(beam, self.load).rigidity


class Bar(NamedTuple):
    """The bar without contact: rigidity (N m^2), inertia, angular frequency; energy (J) of y^2/2 = 1.

    ``notes`` report masses left out because they are unknown, and a beam with more inertia than its rotor.
    """

    rigidity: float
    inertia: float
    omega: float
    energy: float
    notes: tuple[str, ...] = ()


def tolerance(model: Model) -> float:
    """Return the relative error of a time step for a model."""
    return motion.TOLERANCE if MODELS[model.joint].straight else ROUGH


def bar(beam: Beam, model: Model, mode: str, rotor: float | None, density: float | None) -> Bar:
    """Return the linear bar: with a rotor (kg m^2) at its end in twisting, at either end in bending, or in a mode.

    ``inertia`` is the rotor's, or in a mode the mass per length (kg/m), plus the contribution of bar and scales
    (:func:`swinging`); ``density`` (kg/m^3) is the bar's.
    """
    kind, L = model.load, beam.length
    rigidity = model.rigidity(beam)
    stiffness = rigidity / beam.pitch * beam.pitches
    if mode == "uniform":
        if rotor is None:
            remedy = 'give its moment of inertia, e.g. "1e-4 kg m2", or write rotor under [beam]'
            refuse("rotor", "", "is not given: in the uniform mode a rotor at the end of the beam swings", remedy)
        inertia = swinging(beam, model, mode, rotor, (density or 0.0, beam.scale.density or 0.0))
        omega = math.sqrt((1 if kind.sided else 2) * rigidity / (L * inertia))
        notes = _left_out(beam, model, mode, rotor, density)
        if inertia > 2 * rotor:
            shape = "a twist that grows evenly along it" if kind.sided else "an arc"
            error = f"which gives frequencies up to {TOO_HIGH:.0%} too high"
            notes.append(f"the beam has more inertia than its rotor: it is taken to swing as {shape}, {error}")
        return Bar(rigidity, inertia, omega, stiffness, tuple(notes))
    if kind.sided:
        refuse("mode", f'"{mode}"', "is a mode of bending", 'write load="bending", or mode="uniform"')
    if density is None:
        remedy = 'give e.g. "1150 kg/m3", or write density under [beam]'
        refuse("density", "", f"is not given: a {mode} bar swings by its own mass", remedy)
    notes = _left_out(beam, model, mode, 0.0, density)
    first, inertia = SHAPES[mode], swinging(beam, model, mode, 0.0, (density, beam.scale.density or 0.0))
    omega = (first.number / L) ** 2 * math.sqrt(rigidity / inertia)
    return Bar(rigidity, inertia, omega, stiffness * first.square, tuple(notes))


def swinging(beam: Beam, model: Model, mode: str, rotor: float, densities: tuple[float, float]) -> float:
    """Return the moment of inertia of rotor, bar and scales (kg m^2), or in a mode the mass per length (kg/m).

    ``densities`` (kg/m^3) of bar and scales, 0 to leave one out. From the kinetic energy of the assumed shape: the
    twist grows linearly from the clamped end; a bar bent by two rotors is an arc whose ends turn in bearings; in a mode
    scales turn with the slope. The coupling of deflection and slope, due to scales that lean to one side, is neglected.
    """
    m, L = mass.of(beam, *densities), beam.length
    if mode != "uniform":
        return m.mass + m.across * SHAPES[mode].slope / L**2
    return rotor + (m.polar * L / 3 if model.load.sided else m.mass * L**3 / 60 + m.across * L / 6)


def _left_out(beam: Beam, model: Model, mode: str, rotor: float, density: float | None) -> list[str]:
    """Return a note on unknown densities: by how much typical ones would lower the frequency."""
    own = (density, beam.scale.density)
    missing = [i for i, given in enumerate(own) if given is None]
    known, typical = (
        swinging(beam, model, mode, rotor, (own[0] or bar, own[1] or scale))
        for bar, scale in ((0.0, 0.0), (mass.SILICONE, mass.PLASTIC))
    )
    share = 1 - math.sqrt(known / typical)
    if not missing or share < NOTED:
        return []
    words = [("the bar", f"silicone, {mass.SILICONE:g} kg/m3"), ("the scales", f"PLA, {mass.PLASTIC:g} kg/m3")]
    what, materials = (" and ".join(words[i][k] for i in missing) for k in (0, 1))
    tables = " and ".join(("[beam]", "[scale]")[i] for i in missing)
    return [
        f"the mass of {what} is not known and left out: with typical densities ({materials}) frequencies are "
        f"{share:.1%} lower; write density under {tables}"
    ]


def sides(beam: Beam, model: Model, mode: str, sign: int, far: float) -> Sides:
    """Return the branches of a beam in both senses; ``far`` is the largest angle on the side of ``sign``.

    On hinges, a sense in which another contact comes in is taken as bare up to that contact, which is the ``limit``.
    """
    if not MODELS[model.joint].straight:
        # without friction a swing returns to the released angle, up to rounding
        far = min(far * FARTHER, max(far, MOST))
        first = _compliant(beam, model, mode, sign, far)
        energy = float(first.up.energy(np.array(min(far, first.last)))) if first.up else far**2 / 2
        alike = both_faces.sense(beam, model.load.name) < 0
        second = first if alike else _compliant(beam, model, mode, -sign, min(math.sqrt(2 * energy), MOST))
        return Sides(first, second) if sign > 0 else Sides(second, first)
    return _hinged(beam, model, mode)


def _hinged(beam: Beam, model: Model, mode: str) -> Sides:
    """Return the branches of scales on hinges in both senses."""
    kind = model.load
    both = hinge_cycles.senses(beam, kind.name, model.mu, model.law, FINEST, model.ideal)
    found = {sign: hinge_branches.of_path(both.paths[sign], both.bar, mode) for sign in ("+", "-")}
    other = both.paths["-"]
    if found["-"].up is None and math.isfinite(other.load_end) and (kind.sided or other.other):
        text = f"in the other sense another contact comes in at {per_pitch(other.load_end)} ({other.other})"
        return Sides(found["+"], APART, (other.load_end, f"{text}; on hinges the bar goes on without it"))
    return Sides(found["+"], found["-"])


def _compliant(beam: Beam, model: Model, mode: str, sign: int, far: float) -> Side:
    """Return the branches of thick scales on compliant joints in one sense."""
    load, toward = model.load, direction(model.load, sign)
    # first touches are searched at least up to there
    most = max(far, path.RANGE)
    one = compliant.Path.of(beam, model.mu, (load.verb,), ideal=model.ideal, toward=toward, most=most)
    return joint_branches.side(joint_branches.LoadedBeam(one, load, sign, model.ends, mode), far)


def notes(beam: Beam, model: Model, limit: Limit | None, low: float, high: float) -> list[str]:
    """Return notes where a motion between two load angles (rad per pitch) leaves the model's range."""
    found = [limit[1]] if limit is not None and -low >= limit[0] else []
    if not MODELS[model.joint].straight:
        found += compliant.notes(compliant.Held.of(beam), beam, max(-low, high), ideal=model.ideal)
    return found

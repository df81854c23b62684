"""A beam that swings: its branches in both senses, by hinges or by the real model, and what it weighs."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from squama.beam import mass
from squama.beam.design import Beam
from squama.curves import both_faces, hinge_cycles, real
from squama.curves.chosen import MODELS
from squama.dynamics import hinged, motion, walked
from squama.dynamics.branches import APART, Side
from squama.dynamics.decay import Sides
from squama.dynamics.hinged import FINEST
from squama.dynamics.modes import SHAPES
from squama.errors import refuse
from squama.loads import Load

ROUGH = 1e-7
"""Relative error of a step in time on branches of the real beam: they are no better than its increments."""
MOST = 1.0
"""Largest twist per pitch, rad, to which the real beam is followed."""
FARTHER = 1.001
"""By how much it is followed beyond the twist from which it is let go."""
TOO_HIGH = 0.11
"""By how much a frequency is too high without any rotor, by the shapes assumed: 120 for pi^4 in bending."""
NOTED = 0.005
"""Share of the frequency from which on a mass that is left out is told."""

Limit = tuple[float, str]
"""A note for motions beyond an angle below 0, which is a magnitude."""


class Held(NamedTuple):
    """What a beam is answered by: kind of load, friction, law, joint, thin and rigid scales."""

    load: Load
    mu: float
    law: str
    joint: str
    ideal: bool

    def rigidity(self, beam: Beam) -> float:
        """Return the rigidity of a beam without contact, N m^2."""
        return MODELS[self.joint].programs().case(beam, self.load).rigidity


class Bar(NamedTuple):
    """The bar without contact: rigidity (N m^2), what swings, angular frequency; energy (J) of y^2/2 = 1.

    ``notes`` tell of masses that are left out because they are not known, and where a beam outweighs its rotor.
    """

    rigidity: float
    inertia: float
    omega: float
    energy: float
    notes: tuple[str, ...] = ()


def tolerance(held: Held) -> float:
    """Return the relative error of a step in time."""
    return SWINGS[held.joint].tolerance


def bar(beam: Beam, held: Held, mode: str, rotor: float | None, density: float | None) -> Bar:
    """Return what swings: a rotor (kg m^2) at the end of a twisted bar, one at either end of a bent one, or a mode.

    ``inertia`` is the rotor's, or in a mode the mass per length (kg/m), with what bar and scales add to it
    (:func:`swinging`); ``density`` (kg/m^3) is the bar's.
    """
    kind, L = held.load, beam.length
    rigidity = held.rigidity(beam)
    stiffness = rigidity / beam.pitch * beam.scales
    if mode == "uniform":
        if rotor is None:
            remedy = 'give e.g. "1e-4 kg m2", or write rotor under [beam]'
            refuse("rotor", "", "is not given: uniform load comes of a rotor at the end", remedy)
        inertia = swinging(beam, held, mode, rotor, (density or 0.0, beam.scale.density or 0.0))
        omega = math.sqrt((1 if kind.sided else 2) * rigidity / (L * inertia))
        notes = _left_out(beam, held, mode, rotor, density)
        if inertia > 2 * rotor:
            how = "a twist that grows evenly along it" if kind.sided else "an arc"
            notes.append(f"the beam has more inertia than its rotor: it is taken to swing as {how}, which gives "
                         f"frequencies up to {TOO_HIGH:.0%} too high")  # fmt: skip
        return Bar(rigidity, inertia, omega, stiffness, tuple(notes))
    if kind.sided:
        refuse("mode", f'"{mode}"', "is one of bending", 'write load="bending", or mode="uniform"')
    if density is None:
        remedy = 'give e.g. "1150 kg/m3", or write density under [beam]'
        refuse("density", "", f"is not given: a {mode} bar swings by its own mass", remedy)
    notes = _left_out(beam, held, mode, 0.0, density)
    shape, inertia = SHAPES[mode], swinging(beam, held, mode, 0.0, (density, beam.scale.density or 0.0))
    omega = (shape.number / L) ** 2 * math.sqrt(rigidity / inertia)
    return Bar(rigidity, inertia, omega, stiffness * shape.square, tuple(notes))


def swinging(beam: Beam, held: Held, mode: str, rotor: float, densities: tuple[float, float]) -> float:
    """Return the moment of inertia of a rotor, or in a mode the mass per length, with those of bar and scales.

    ``densities`` of bar and scales, 0 for one that is left out. By the kinetic energy of the shape: the twist grows
    along the beam from its clamped end; a bar that two rotors bend is an arc whose ends turn in bearings; in a mode
    scales turn with the slope. What couples deflection and slope, as scales lean to one side, is left out.
    """
    m, L = mass.of(beam, *densities), beam.length
    if mode != "uniform":
        return m.mass + m.across * SHAPES[mode].slope / L**2
    return rotor + (m.polar * L / 3 if held.load.sided else m.mass * L**3 / 60 + m.across * L / 6)


def _left_out(beam: Beam, held: Held, mode: str, rotor: float, density: float | None) -> list[str]:
    """Say by how much the frequency would be lower with the masses that are not known, if they were typical."""
    own = (density, beam.scale.density)
    missing = [i for i, given in enumerate(own) if given is None]
    known, typical = (
        swinging(beam, held, mode, rotor, (own[0] or bar, own[1] or scale))
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


def sides(beam: Beam, held: Held, mode: str, sign: int, far: float) -> tuple[Sides, Limit | None]:
    """Return the branches of a beam in both senses; ``far`` is the largest angle on the side of ``sign``.

    A sense in which hinged scales run into another contact is taken as bare; that contact is told as a limit.
    """
    return SWINGS[held.joint].sides(beam, held, mode, sign, far)


def _walked(beam: Beam, held: Held, mode: str, sign: int, far: float) -> tuple[Sides, Limit | None]:
    # without friction a swing comes back to where it was let go, but for rounding
    far = min(far * FARTHER, max(far, MOST))
    first = _real(beam, held, mode, sign, far)
    energy = float(first.up.energy(np.array(min(far, first.last)))) if first.up else far**2 / 2
    alike = both_faces.sense(beam, held.load.name) < 0
    second = first if alike else _real(beam, held, mode, -sign, min(math.sqrt(2 * energy), MOST))
    return Sides(*(first, second)[::sign]), None


def _hinged(beam: Beam, held: Held, mode: str, _sign: int, _far: float) -> tuple[Sides, Limit | None]:
    kind = held.load
    both = hinge_cycles.senses(beam, kind.name, held.mu, held.law, FINEST, held.ideal)
    found = {sign: hinged.of_path(both.paths[sign], both.bar, mode) for sign in ("+", "-")}
    other = both.paths["-"]
    limit: Limit | None = None
    if found["-"].up is None and math.isfinite(other.load_end) and (kind.sided or other.other):
        text = f"in the other sense another contact comes in at {other.load_end:.4g} rad per pitch ({other.other})"
        limit = (other.load_end, f"{text}; on hinges the bar goes on without it")
        found["-"] = APART
    return Sides(found["+"], found["-"]), limit


def _real(beam: Beam, held: Held, mode: str, sign: int, far: float) -> Side:
    """Return the branches of the real beam in one sense."""
    swung = walked.Swung.of(beam, held.load, held.mu, sign, far, ideal=held.ideal)
    return walked.side(swung, far, mode)


def notes(beam: Beam, held: Held, limit: Limit | None, low: float, high: float) -> list[str]:
    """Say where a motion between two angles leaves the model."""
    found = [limit[1]] if limit is not None and -low >= limit[0] else []
    return found + SWINGS[held.joint].notes(beam, held, max(-low, high))


def _real_notes(beam: Beam, held: Held, far: float) -> list[str]:
    return real.notes(real.Held.of(beam), beam, far, ideal=held.ideal)


class Swing(NamedTuple):
    """How a model swings: relative error of a step in time, branches in both senses, notes on a motion so far."""

    tolerance: float
    sides: Callable[[Beam, Held, str, int, float], tuple[Sides, Limit | None]]
    notes: Callable[[Beam, Held, float], list[str]]


SWINGS = {
    "hinge": Swing(motion.TOLERANCE, _hinged, lambda *_: []),
    "compliant": Swing(ROUGH, _walked, _real_notes),
}
"""The models of :data:`squama.curves.chosen.MODELS`."""

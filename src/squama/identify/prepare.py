"""Settings of a fit, checked, and the points of a record by a model: which are usable, and whether they suffice."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from squama import arguments
from squama.beam import matrixfile
from squama.beam.design import Beam
from squama.beam.faces import only_one
from squama.contacts.ties import KINDS
from squama.curves import doors, hinge_cycles, rows
from squama.curves.chosen import chosen
from squama.curves.compliant import Held
from squama.curves.way import Way
from squama.errors import InputError, refuse
from squama.identify import records
from squama.identify.estimate import Points
from squama.identify.hinge_points import Hinged, Physical
from squama.identify.joint_points import Loaded, Walked
from squama.identify.machine import Machine
from squama.identify.noise import scatter
from squama.identify.records import Limits, Record
from squama.identify.slope import slope
from squama.identify.unknowns import Asked, ask
from squama.io.measured import Measured
from squama.loads import ENDLESS, TESTS
from squama.part.definition import Part
from squama.types import Array
from squama.units import shown

_NEAR = 1e-9
_OF_TWIST = "a compliant joint takes it as a factor of the twist"
_ENGAGED = {"mu", "K_theta", "theta0"}


class Wanted(NamedTuple):
    """Settings of a fit, checked: arguments of :func:`squama.fit`.

    ``candidates``: nuisances that may be added; ``ends`` on compliant joints (hinges are endless); ``machine``: None
    where unknown; ``priors`` by name, those of the beam's ``dimensions`` apart; ``part`` under a force, else None.
    """

    beam: Beam
    specimens: list[Measured]
    names: tuple[str, ...]
    load: str
    law: str
    bounds: Mapping[str, tuple[object, object]] | None
    limits: Limits
    noise: float | None
    starts: int
    candidates: tuple[str, ...]
    ends: str = ENDLESS
    machine: Machine | None = None
    dimensions: Mapping[str, tuple[float, float]] = MappingProxyType({})
    priors: Mapping[str, tuple[float, float]] = MappingProxyType({})
    part: Part | None = None

    @property
    def compliance(self) -> float:
        """Compliance for which records are corrected, rad/(N m)."""
        return 0.0 if self.machine is None else self.machine.compliance


class Prepared(NamedTuple):
    """Points of a record by a model, the mask of usable points, the parameters to find; noise (N m) if given."""

    record: Record
    asked: Asked
    points: Points
    usable: NDArray[np.bool_]
    noise: float | None = None

    @property
    def used(self) -> tuple[NDArray[np.int64], Points, Array, NDArray[np.int64]]:
        """Indices of the usable points, the points, their torques (N m), and the numbers of their ways."""
        index = np.flatnonzero(self.usable)
        return index, self.points.take(index), self.record.torque[index], self.points.readings.numbers[index]


def kind(joint: str | None, wanted: Wanted) -> tuple[str, str]:
    """Return the joint of the fit, and why it is the hinge where it was not chosen; else an empty text."""
    load, inclined = TESTS[wanted.load], "theta0" in wanted.names
    if load.pushed:
        if joint == "hinge":
            refuse("joint", '"hinge"', "is not available for a part under load", "leave it out")
        joint = "compliant"
    factor = not load.sided and "C_f" in wanted.names
    if joint is not None and arguments.joint(joint) == "compliant":
        if inclined:
            reason = 'theta0 is not found with joint="compliant": the elements depend on it'
            refuse("parameters", "", reason, "leave it out")
        if factor:
            refuse("parameters", "", f'C_f is not found with joint="compliant" in bending: {_OF_TWIST}', "find E_B")
        if load.pushed:
            return joint, ""
    means = chosen(wanted.beam, load, law=wanted.law, joint=joint)
    found, why = means.joint, means.note
    if joint is None and found != "hinge" and factor:
        found, why = "hinge", f"C_f is found on hinges only in bending: {_OF_TWIST}"
    if joint is None and means.joint != "hinge" and inclined:
        found, why = "hinge", "theta0 is found on hinges only: the matrix of a joint depends on it"
    if found == "hinge":
        only_one(wanted.beam.faces, "a fit on hinges")
    return found, why


def ends(joint: str, wanted: Wanted, word: str | None) -> str:
    """Return the ends of the beam of a fit: ``word`` checked, or the default for this joint."""
    load = TESTS[wanted.load]
    if load.pushed:
        if word is not None:
            refuse("ends", shown(word), "are not of a part under a force", "give its support")
        return ENDLESS
    asked = doors.analysis(wanted.beam, Way.of(wanted.load, [1.0]), load, points=3, mu=0.0, law=wanted.law, joint=joint)
    found = doors.ends_of(asked, word, history=True)
    if (ended := KINDS.get(found)) is not None:
        # the joint may need finite elements
        rows.check_ends(ended, Held.of(wanted.beam), wanted.beam.pitches)
    return found


def prepared(joint: str, wanted: Wanted) -> Prepared:
    """Return the points of a record by a kind of joint; refuse points that no trial covers."""
    beam = wanted.beam if joint == "hinge" else _held(wanted.beam)
    asked = ask(beam, wanted.load, wanted.names, wanted.bounds, joint=joint, priors=wanted.priors)
    # a stiffness given in the file does not scale with the bar's modulus
    follows = asked.follows and wanted.beam.joint.stiffness is None
    asked = asked._replace(follows=follows, base=asked.base._replace(compliance=wanted.compliance))
    record = records.record(wanted.specimens, beam, wanted.limits, wanted.compliance, TESTS[wanted.load])
    made = placed(record, asked, wanted.law) if joint == "hinge" else _walked(record, asked, wanted)
    if not wanted.priors:
        return made._replace(noise=wanted.noise)
    _, _, torque, way = made.used
    weight = wanted.noise or scatter(torque, way) or float(np.abs(torque).max(initial=0.0)) or 1.0
    return made._replace(noise=wanted.noise, asked=asked._replace(weight=weight))


def placed(record: Record, asked: Asked, law: str) -> Prepared:
    """Locate a record on the paths of its contacts on hinges; refuse points that no trial covers."""
    # for the smallest friction and inclination at rest of all trials
    start = asked.beam.replace(scale={"theta0": asked.bound("theta0", 0)})
    senses = hinge_cycles.senses(start, asked.load, asked.bound("mu", 0), law, _NEAR)
    records.check_range(record, senses, asked.bound("mu", 0))
    points = Hinged(senses, record.readings(asked.scales, asked.base.compliance))
    # points outside the requested range may lie beyond the path
    most = np.where(record.load < 0, senses.most["-"], senses.most["+"])
    covered = np.abs(record.load) <= most * (1 + _NEAR)
    stuck = record.stuck & (points.at(asked.physical(asked.start)).theta > 0)
    return Prepared(record, asked, points, record.asked & covered & ~stuck)


def _held(beam: Beam) -> Beam:
    """Return the beam with the matrix of its joint as the only joint value."""
    held = Held.of(beam)
    matrix = matrixfile.stored(beam, held.K, tab=held.joint.bends)
    return beam.replace(joint={"matrix": matrix, "stiffness": None, "inclusion_factor": None})


def _walked(record: Record, asked: Asked, wanted: Wanted) -> Prepared:
    """Follow a record on compliant joints; refuse a record that the beam cannot follow even with the least friction."""
    start = asked.physical(asked.start)
    readings = record.readings(asked.scales, asked.base.compliance)

    def at(v: Physical) -> Walked:
        if wanted.part is not None:
            return Loaded(wanted.part, asked.beam, readings, v)
        return Walked(asked.beam, TESTS[asked.load], readings, v, wanted.ends)

    try:
        points = at(start)
    except InputError:
        if asked.place("mu") is None or not asked.bound("mu", 0) < start.mu:
            raise
        points = at(start._replace(mu=asked.bound("mu", 0)))
    return Prepared(record, asked, points, record.asked & ~(record.stuck & points.touching(points.start)))


def enough(made: Prepared) -> None:
    """Refuse too few points, and points that do not show the parameters."""
    (rec, asked, points, usable, noise), load = made, TESTS[made.asked.load]
    need, have = len(asked.rows) + (noise is None), int(np.count_nonzero(usable))
    if have < need:
        count = f"{have} usable point{'s' * (have != 1)} (of {rec.load.size}) for {len(asked.rows)} parameters"
        remedy = f"give {need} or more, better ten for each parameter"
        refuse("data", "", f"{count} ({' and '.join(asked.names)})", remedy)
    if not rec.torque[usable].any():
        refuse("data", "", f"the {load.noun} is 0 at every point that is used", "check the column and the load cell")
    hidden = [n for n in asked.names if n in _ENGAGED]
    least = asked.physical(asked.start)._replace(theta0=asked.bound("theta0", 0))
    touching = int(np.count_nonzero(usable & points.touching(least)))
    if touching >= len(hidden):
        return
    if touching:
        kinds = " and ".join([n for n in hidden if n != "theta0"] or hidden)
        reason = f"{touching} point in contact for {len(hidden)} parameters that are seen in contact only ({kinds})"
        refuse("data", "", reason, f"give points at a larger {load.verb}")
    far = float(max(rec.load[usable], key=abs))
    here, there = ("-", "+") if far < 0 else ("+", "-")
    engaged = points.engaged()
    if np.isfinite(engaged[here]):
        at = float(np.copysign(engaged[here], far))
        where = f"engagement is at {load.shown(at)}"
        other = ", or find E_B" if load.pushed else f" ({at / asked.beam.pitch:.4g} rad/m), or find C_f or E_B"
        remedy = f"measure beyond {load.shown(at)}{other} only"
    else:
        where = f"in this sense, {here}, the scales do not engage"
        turned = np.isfinite(engaged[there])
        signs = f"if the sense was the other, turn the signs of {load.verb} and {load.noun}"
        remedy = signs if turned else "find C_f or E_B only"
    reason = f"all {have} points lie before engagement (largest {load.verb} {load.shown(far)}, {where})"
    cause = wrong_unit(made)
    remedy = f"{cause}, or {remedy}" if cause else remedy
    refuse("data", "", f"{reason}, where {' and '.join(hidden)} cannot be seen", remedy)


def bar(made: Prepared) -> tuple[float, float]:
    """Return the slope of the given beam's torque before engagement, N m per rad of a pitch, and its E_B, Pa."""
    points, modulus = made.points, made.asked.beam.substrate.youngs_modulus
    if isinstance(points, Walked):
        return points.bar(), modulus
    return made.asked.base.rigidity / made.asked.beam.pitch, modulus


def wrong_unit(made: Prepared) -> str:
    """Return which unit the slope at small twists points to; empty where a bar may explain it."""
    asked = made.asked
    steep = slope(made.record, made.points, made.usable, asked.physical(asked.start), bar(made), None)
    return steep.cause(asked.names, asked.scales, TESTS[asked.load]) if steep is not None and steep.wrong_unit else ""

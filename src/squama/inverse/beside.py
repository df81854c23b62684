"""A design asked once more by the models that a search leaves out.

A design with a number of scales is found and judged with that; beside it stands the endless beam. Where hinges answer,
its scales are thin and rigid and it is held straight: it is asked as everybody asks it (``squama.twist`` or
``squama.bend`` of the file) and, where it is held straight, free to bow.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from squama.beam.design import Beam
from squama.curves import doors
from squama.errors import InputError
from squama.fe import runs
from squama.fe.sizes import MeshName
from squama.inverse import joint_figures
from squama.inverse.goals import Goal, Pitches, Reached, reached
from squama.inverse.named_figures import OF_LOCKS
from squama.inverse.target import Target
from squama.joints import law
from squama.joints.choice import impossible, known, said, shape
from squama.loads import ENDLESS, LOADS, NOTHING, STRAIGHT, SenseName, holds
from squama.people import per_pitch
from squama.units import change, moment

OF_BOW = ("torque", "tangent", "stiffness_ratio")
"""Figures at a twist that are known of a beam that is free to bow."""
MESH: MeshName = "coarse"
INCREMENTS = 20
"""Mesh of the elements that a design is held against, and increments of their twist."""


@dataclass(frozen=True)
class Beside:
    """What a design reaches by another model than the one that found it.

    ``key`` is "door" (``squama.twist`` or ``squama.bend`` of the file, as everybody calls them), "endless" (without
    ends) or "free_to_bow" (without the bending moment that holds it straight); ``words`` say so; ``goals`` are those
    that may differ there; ``note``: why a figure is missing.
    """

    key: str
    words: str
    goals: tuple[Reached, ...]
    note: str = ""

    @property
    def agrees(self) -> bool:
        """Whether every goal is met here, too; what has no ends is told only for comparison."""
        return self.key == "endless" or (all(goal.met for goal in self.goals) and bool(self.goals or not self.note))

    def says(self, goal: Reached) -> str:
        """Return what is reached of a goal here, in words: "4.9 with 10 scales"."""
        value = f"{goal.reached:.3g} {goal.unit}".strip()
        if self.key == "door":
            return f"{self.words} has none" if math.isnan(goal.reached) else f"{self.words} says {value}"
        return f"{'not known' if math.isnan(goal.reached) else value} {self.words}"


def found_by(target: Target, beam: Beam) -> str:
    """Name the beam of a design's figures: "(10 scales, free to bow)", "on hinges (endless, held straight)"."""
    load = LOADS[target.space.load]
    straight = not target.compliant or holds(target.space.beam.holding, load)
    ends = f"{beam.scales} scales" if target.own else ENDLESS
    place = f"({ends}, {'held straight' if straight else 'free to bow'})" if load.sided else f"({ends})"
    return place if target.compliant else f"on hinges {place}"


def beside(target: Target, beam: Beam, *, elements: bool) -> tuple[Beside, ...]:
    """Return what a design reaches by other models than that of the search.

    With ``elements`` of one, too, whose joint is not known without them: they take a minute, and are kept.
    """
    load = LOADS[target.space.load]
    # no beam of thick scales on joints that give has a lock: that needs no elements
    locks = any(goal.want.at is None and goal.want.figure in OF_LOCKS for goal in target.goals)
    ask = target.compliant or known(beam) or (elements and not locks)
    found = [] if target.compliant else [_door(target, beam, ask=ask)]
    goals = [goal for goal in target.goals if goal.want.at is not None]
    if goals and ask and not impossible(beam):
        if target.own:
            found.append(_at_twists(ENDLESS, "as an endless beam", target, beam, goals))
        bowing = [goal for goal in goals if goal.want.figure in OF_BOW]
        if load.sided and bowing and holds(beam.holding, load):
            found.append(_at_twists("free_to_bow", "free to bow", target, beam, bowing))
    return tuple(found)


def _door(target: Target, beam: Beam, *, ask: bool) -> Beside:
    """Return what ``squama.twist`` or ``squama.bend`` of the file gives; without ``ask`` why it is not asked."""
    words = f"squama {LOADS[target.space.load].verb} of this file"
    if not ask:
        return Beside("door", words, (), f"not asked: its joint needs elements, {said(law.outside(shape(beam)))}")
    wants = [goal.want for goal in target.goals]
    try:
        values, answer = joint_figures.followed(beam, wants, target.options, joint=None)
    except InputError as error:
        return Beside("door", words, (), str(error))
    goals = tuple(reached(target.goals, np.array(values), Pitches(beam.pitch, beam.pitches), target.accept))
    if answer.attrs["joint"] == "hinge" and all(goal.met for goal in goals):
        # the same model once more confirms nothing
        return Beside("door", words, (), "by hinges, too")
    return Beside("door", words, goals)


def _at_twists(key: str, words: str, target: Target, beam: Beam, goals: Sequence[Goal]) -> Beside:
    """Return what the endless beam, or the one that is free to bow, reaches of goals at twists."""
    endless = key == ENDLESS
    one, wants = beam if endless else beam.replace(hold=NOTHING), [goal.want for goal in goals]
    try:
        values, answer = joint_figures.followed(one, wants, target.options, endless=endless)
    except InputError as error:
        return Beside(key, words, (), str(error))
    note = "" if np.isfinite(values).all() else str(answer["end"].item())
    found = reached(goals, np.array(values), Pitches(beam.pitch, beam.pitches), target.accept)
    return Beside(key, words, tuple(found), note)


def by_elements(beam: Beam, sense: str, rates: Sequence[float]) -> list[str]:
    """Return lines that compare finite elements with the curve of thick scales at twist rates (rad/m).

    Both are of one pitch that is held straight.

    Raises
    ------
    InputError
        The extra ``fe`` is not installed, or the mesh is refused.
    """
    way: SenseName = "-" if sense == "-" else "+"
    run = runs.cell(beam, to=max(rates), sense=way, mesh=MESH, increment=max(rates) * beam.pitch / INCREMENTS)
    x, T = run["Phi"].values, run["T"].values
    how = doors.How(joint="compliant", hold=STRAIGHT)
    own = doors.respond(beam, "twisting", at=x.tolist(), sense=sense, ends=ENDLESS, **how)["T"]
    # slopes of both between the same twists
    ratios = [np.gradient(torque, x) / (torque[1] / x[1]) for torque in (T, own)]
    lines = []
    for rate in rates:
        where = f"elements ({MESH} mesh), held straight, {per_pitch(rate * beam.pitch)}"
        if rate > x[-1] * (1 + 1e-9):
            lines.append(f"{where}: the run ends before, {run.attrs['sentence']}")
            continue
        torque, own_torque, stiffer, as_stiff = (float(np.interp(rate, x, v)) for v in (T, own, *ratios))
        beside = f"stiffness ratio {stiffer:.3g} (model: {as_stiff:.3g})"
        lines.append(f"{where}: torque {moment(torque)} ({change(torque / own_torque - 1, '+')}), {beside}")
    return lines

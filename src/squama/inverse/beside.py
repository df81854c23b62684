"""Checks of a design by models other than that of the search.

A design with a number of scales is found and judged as a finite beam, and compared with the endless beam. Hinges have
thin, rigid scales and are held straight; their designs are also computed by ``squama.twist`` or ``squama.bend`` of the
beam file with default options, and designs held straight also free to bow.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from squama.beam.design import Beam
from squama.errors import InputError
from squama.inverse import joint_figures
from squama.inverse.goals import Goal, Pitches, Reached, reached
from squama.inverse.named_figures import OF_LOCKS
from squama.inverse.target import Target
from squama.joints import law
from squama.joints.choice import impossible, known, said, shape
from squama.loads import COUPLE, ENDLESS, GRIPPED, LOADS, NOTHING, ending, holds

OF_BOW = ("torque", "tangent", "stiffness_ratio")
"""Figures at a twist that are computed for a beam that is free to bow."""


@dataclass(frozen=True)
class Beside:
    """Goals of a design by another model than that of the search; ``note``: why a figure is missing.

    ``key``: "door" (``squama.twist`` or ``squama.bend`` of the file with default options), "endless" (without ends),
    "free_to_bow" (not held straight) or "elements".
    """

    key: str
    words: str
    goals: tuple[Reached, ...]
    note: str = ""

    @property
    def agrees(self) -> bool:
        """Whether every goal is met by this model too; the endless beam is for comparison only and always agrees."""
        return self.key == "endless" or (all(goal.met for goal in self.goals) and bool(self.goals or not self.note))

    def says(self, goal: Reached) -> str:
        """Return the reached value of a goal by this model as text: "4.9 with 10 scales"."""
        value = f"{goal.reached:.3g} {goal.unit}".strip()
        if self.key == "door":
            return f"{self.words} has none" if math.isnan(goal.reached) else f"{self.words} says {value}"
        return f"{'not known' if math.isnan(goal.reached) else value} {self.words}"


def found_by(target: Target, beam: Beam) -> str:
    """Return the beam behind a design's figures as text: "(10 scales, free to bow)", "on hinges (endless, ...)"."""
    load = LOADS[target.space.load]
    straight = not target.compliant or holds(target.space.beam.holding, load)
    many = f"{beam.scales} scales" if target.own else ENDLESS
    by_ends = ending(beam.ends) if target.own and beam.ends in (GRIPPED, COUPLE) else "free to bow"
    held = "held straight" if straight else by_ends
    place = f"({many}, {held})" if load.sided else f"({many})"
    return place if target.compliant else f"on hinges {place}"


def beside(target: Target, beam: Beam, *, elements: bool) -> tuple[Beside, ...]:
    """Compute a design's goals by other models; ``elements``: allowed for a joint outside the law (a minute)."""
    load = LOADS[target.space.load]
    # thick scales on compliant joints never lock, so a lock needs no joint by finite elements
    locks = any(goal.want.at is None and goal.want.figure in OF_LOCKS for goal in target.goals)
    ask = target.compliant or known(beam) or (elements and not locks)
    found = []
    if not target.compliant:
        words = f"squama {load.verb} of this file"
        if ask:
            found.append(_judged("door", words, target, beam, target.goals, joint=None))
        else:
            outside = said(law.outside(shape(beam)))
            found.append(Beside("door", words, (), f"not computed: the joint needs elements, {outside}"))
    goals = [goal for goal in target.goals if goal.want.at is not None]
    if goals and ask and not impossible(beam):
        if target.own:
            found.append(_judged(ENDLESS, "as an endless beam", target, beam, goals))
        bowing = [goal for goal in goals if goal.want.figure in OF_BOW]
        if load.sided and bowing and holds(beam.holding, load):
            found.append(_judged("free_to_bow", "free to bow", target, beam.replace(hold=NOTHING), bowing))
    return tuple(found)


def _judged(
    key: str, words: str, target: Target, beam: Beam, goals: Sequence[Goal], joint: str | None = "compliant"
) -> Beside:
    """Return the goals of a beam by another model; ``joint`` None: by the default model of the response."""
    wants = [goal.want for goal in goals]
    try:
        values, answer = joint_figures.followed(
            beam, wants, target.options, joint, ends=ENDLESS if key == ENDLESS else None
        )
    except InputError as error:
        return Beside(key, words, (), str(error))
    found = tuple(reached(goals, np.array(values), Pitches(beam.pitch, beam.pitches), target.accept))
    if joint is not None:
        return Beside(key, words, found, "" if np.isfinite(values).all() else str(answer["end"].item()))
    if answer.attrs["joint"] == "hinge" and all(goal.met for goal in found):
        # the model of the search again: no confirmation
        return Beside(key, words, (), "by hinges, too")
    return Beside(key, words, found)

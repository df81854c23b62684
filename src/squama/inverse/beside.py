"""A design asked once more by the models that a search leaves out.

The search asks an endless beam; where hinges answer, its scales are thin and rigid and it is held straight. What is
handed out is therefore asked as everybody asks it (``squama.twist`` or ``squama.bend`` of the file), as a row of its
own number of scales and, where it is held straight, free to bow.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from squama.beam.design import Beam
from squama.curves.doors import respond
from squama.curves.own_scales import own_scales
from squama.errors import InputError
from squama.inverse import joint_figures
from squama.inverse.goals import Goal, Pitches
from squama.inverse.named_figures import OF_LOCKS
from squama.inverse.reached import Beside, reached
from squama.inverse.target import Target
from squama.joints import law
from squama.joints.choice import impossible, known, said, shape
from squama.loads import LOADS, NOTHING, holds

_NAMES = {"torque": "T", "tangent": "K_t", "strength_share": "stress"}
"""Names that figures at a twist have in a row and in a response, where they are others."""
OF_BOW = ("torque", "tangent", "stiffness_ratio")
"""Figures at a twist that are known of a beam that is free to bow."""


def found_by(target: Target) -> str:
    """Name the beam of a target's figures: "(endless, held straight)", "on hinges (endless)"."""
    load = LOADS[target.space.load]
    straight = not target.real or holds(target.space.beam.holding, load)
    place = f"(endless, {'held straight' if straight else 'free to bow'})" if load.sided else "(endless)"
    return place if target.real else f"on hinges {place}"


def beside(target: Target, beam: Beam, *, elements: bool) -> tuple[Beside, ...]:
    """Return what a design reaches by other models than that of the search.

    With ``elements`` of one, too, whose joint is not known without them: they take a minute, and are kept.
    """
    load = LOADS[target.space.load]
    # no beam of thick scales on joints that give has a lock: that needs no elements
    locks = any(goal.want.at is None and goal.want.figure in OF_LOCKS for goal in target.goals)
    ask = target.real or known(beam) or (elements and not locks)
    found = [] if target.real else [_door(target, beam, ask=ask)]
    goals = [goal for goal in target.goals if goal.want.at is not None]
    if load.sided and goals and ask and not impossible(beam):
        found.append(_at_twists("row", f"with {beam.scales} scales", target, beam, goals))
        bowing = [goal for goal in goals if goal.want.figure in OF_BOW]
        if bowing and holds(beam.holding, load):
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
    goals = tuple(reached(target.goals, np.array(values), Pitches(beam.pitch, beam.scales), target.accept))
    if answer.attrs["joint"] == "hinge" and all(goal.met for goal in goals):
        # the same model once more confirms nothing
        return Beside("door", words, (), "by hinges, too")
    return Beside("door", words, goals)


def _at_twists(key: str, words: str, target: Target, beam: Beam, goals: Sequence[Goal]) -> Beside:
    """Return what a row of the beam's own scales, or the endless beam free to bow, reaches of goals at twists."""
    rates, sense = [g.want.at.per_length(beam) for g in goals if g.want.at is not None], target.options.sense
    names = [_NAMES.get(goal.want.figure, goal.want.figure) for goal in goals]
    try:
        if key == "row":
            row = own_scales(beam, rates, sense=sense)
            values, note = np.array([getattr(row, name)[i] for i, name in enumerate(names)]), row.note
        else:
            bowed = respond(beam, "twisting", at=rates, sense=sense, hold=NOTHING)
            values = np.array([bowed[name][i] for i, name in enumerate(names)])
            note = "" if np.isfinite(values).all() else str(bowed["end"].item())
    except InputError as error:
        return Beside(key, words, (), str(error))
    shares = [1.0 if goal.want.figure != "strength_share" else beam.scale.strength or np.nan for goal in goals]
    found = reached(goals, values / shares, Pitches(beam.pitch, beam.scales), target.accept)
    return Beside(key, words, tuple(found), note)

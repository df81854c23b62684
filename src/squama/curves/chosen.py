"""Which model answers what is asked of a beam: the paper's hinges, or the real beam where nothing else is meant."""

from __future__ import annotations

from typing import NamedTuple

from squama import arguments
from squama.beam.design import Beam
from squama.errors import refuse
from squama.joints import choice
from squama.loads import LINES, LOADS, NEUTRAL, Load

HINGED = 'write joint="hinge" (--joint hinge)'
STRETCHES = ("free", "middle")
"""Which line of a real beam keeps its length: none, there being no axial force, or that in the bar's middle."""


class Chosen(NamedTuple):
    """A beam and the model that answers: its joint, "compliant" or "hinge", and whether scales are thin and rigid.

    ``beam`` knows the line of its bar that keeps its length; ``note``: why it is hinges where nobody asks for them.
    """

    beam: Beam
    joint: str
    ideal: bool
    note: str

    @property
    def real(self) -> bool:
        """Whether the real beam answers."""
        return self.joint == "compliant"


def chosen(
    beam: Beam,
    load: Load | None = None,
    *,
    law: str = "edge",
    joint: str | None = None,
    ideal: bool | None = None,
    neutral: str | None = None,
    free: str | None = None,
    elements: bool = True,
) -> Chosen:
    """Return by which model a beam is answered.

    Parameters
    ----------
    beam
        The beam.
    load
        The one load; twisting and bending at once if not given.
    law, joint, ideal, neutral
        As of :func:`squama.twist` and :func:`squama.bend`.
    free
        The load that is left free, as of :func:`squama.bend_twist`.
    elements
        Whether elements may make the joint of a beam that the law does not know.

    Raises
    ------
    InputError
        What is asked does not go together, or the joint that is asked for is not known.
    """
    arguments.held(joint, ideal)
    if neutral is not None:
        arguments.one_of("neutral", neutral, tuple(LINES))
    bends, line = load is not LOADS["twisting"], neutral or beam.substrate.neutral
    hinged, note = law != "edge" or free is not None or (bends and line == "face"), ""
    if joint is None:
        unknown = choice.impossible if elements else choice.unknown
        note = "" if hinged else unknown(beam) or (choice.unbent(beam) if bends else "")
        joint = "hinge" if hinged or note else "compliant"
    elif joint == "compliant":
        why = (choice.impossible(beam) if elements else "") or (choice.unbent(beam) if bends else "")
        for name, value, reason, remedy in (
            ("joint", joint, why, HINGED),
            ("law", law, 'is not covered by joint="compliant"' * (law != "edge"), 'write law="edge"'),
            ("free", free, "is of the hinge" * (free is not None), HINGED),
        ):
            if reason:
                refuse(name, f'"{value}"', reason, remedy)
    thin = joint == "hinge" if ideal is None else ideal
    if joint == "hinge" and bends and not thin:
        refuse("ideal", "False", "is not covered by the hinge that is bent", "leave it out")
    if not bends and neutral is not None and joint == "hinge":
        refuse("neutral", f'"{neutral}"', "is of the compliant joint in twisting", "leave it out")
    if bends or neutral is not None:
        beam = _lined(beam, joint, line)
    return Chosen(beam, joint, thin, note)


def _lined(beam: Beam, joint: str, line: str | None) -> Beam:
    """Return a beam that knows which line of its bar keeps its length; by default the first that the joint has."""
    lines = tuple(NEUTRAL) if joint == "hinge" else STRETCHES
    line = arguments.one_of("neutral", line or lines[0], lines)
    if joint == "hinge":
        if beam.other and line == "face":
            refuse("neutral", f'"{line}"', "is of scales on one face: between two it is the middle", 'write "middle"')
        return beam if beam.neutral == line else beam.replace(substrate={"neutral": line})
    if line == "free" and beam.joint.matrix is not None and len(beam.joint.matrix.K) < 9:
        refuse("neutral", '"free"', "is not known by joint.matrix, which has no stretch", 'write "middle"')
    if beam.given.line == line:
        return beam
    return beam.replace(substrate={"neutral": None if line == "free" else line})

"""Ends of a curve: a name and a sentence for each."""

from __future__ import annotations

from enum import StrEnum
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from squama.types import Array


class End(StrEnum):
    """Reason why the path of a contact ends."""

    FRICTIONAL = "frictional lock"
    KINEMATIC = "kinematic lock"
    LINE = "kinematic lock (line contact)"
    STATIC = "static lock"
    OFF_TIP = "off tip edge"
    OFF_SIDE = "off side edge"
    OTHER = "other contact"
    RELEASED = "released"
    RANGE = "range end"
    NONE = "no engagement"
    STOPPED = "no equilibrium"
    SIDE = "side entry"
    JOINT = "beyond the joint"
    TOUCHING = "touching at rest"

    @property
    def locks(self) -> bool:
        """Whether the end is a lock of the beam."""
        return self in (End.FRICTIONAL, End.KINEMATIC, End.LINE, End.STATIC)


CODES = (*(end for end in End if end not in (End.LINE, End.STOPPED, End.SIDE, End.JOINT)), End.LINE)
"""Ends on hinges in the order of their integer codes (index = code); the others occur on compliant joints only."""
LOCKS = tuple(code for code, end in enumerate(CODES) if end.locks)
"""Codes of the locks."""
SLID = (CODES.index(End.FRICTIONAL), CODES.index(End.KINEMATIC))
"""Codes of the locks after sliding."""

SENTENCES: dict[End, str] = {
    End.FRICTIONAL: "friction holds the sliding contact: no torque moves it further, the beam is locked",
    End.KINEMATIC: "the geometry allows no further rotation of the scales: the beam is locked",
    End.LINE: "the tip edge of a scale lies flush in the next one's face and can go neither way: the beam is locked",
    End.STATIC: "friction holds the contact as soon as the scales touch: the beam locks at engagement",
    End.OFF_TIP: "the contact runs off the end of the tip edge before any lock; the model ends here",
    End.OFF_SIDE: "the contact runs off the end of the side edge before any lock; the model ends here",
    End.OTHER: "another pair of plate edges or faces comes into contact; the model of one contact ends here",
    End.RELEASED: "beyond the fold the scales come back to their initial inclination and the contact opens",
    End.RANGE: "the range of the curve ends here; nothing locks before",
    End.STOPPED: "no equilibrium was found beyond this twist, however small the increment: the scales lock or jump",
    End.SIDE: "a plate comes to lie beside another one's edge, face against thickness; the model ends there",
    End.JOINT: "a scale turns by more than 57 deg or moves by more than a pitch in its joint; the model ends there",
    End.TOUCHING: "the scales are thicker than the gap between them: they touch before anything is loaded",
    End.NONE: "the tip edge of a scale never rests on a side edge of a neighbour in this sense of loading",
}


def named(code: Array | int) -> Array:
    """Return ends in words from their codes, as an array of text."""
    import numpy as np

    return np.array([str(end) for end in CODES])[code]

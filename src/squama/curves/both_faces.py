"""Scales on both faces: signs with which each face sees a load, and names of the other face's variables.

Each face sees the beam's strains by :mod:`squama.beam.faces`. To first order embedded tabs are independent of those in
the other face, so their stiffening adds up (:meth:`squama.beam.joint_law.Given.gathered`): on hinges each face follows
its own path (:class:`squama.curves.hinge.Both`). On compliant joints the scales of both faces are one system
(:mod:`squama.contacts.system`).
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from squama.beam import faces
from squama.beam.design import Beam
from squama.loads import LOADS
from squama.symbols import OF_A_SCALE, OTHER
from squama.types import Array

WHOSE = "of the other face: "
"""Words before messages about the other face's contacts."""


def sense(beam: Beam, load: str) -> int:
    """Return the sign with which the other face sees a load; 0 without scales there."""
    return faces.sense(beam.faces, LOADS[load].axis, beam.scale.alpha)


def views(beam: Beam) -> list[tuple[int, int]]:
    """Return the signs of bend and twist seen by each face, the scaled face first."""
    return [(1, 1), beam.other.seen[:2]] if beam.other else [(1, 1)]


def of_other(along: Mapping[str, Array]) -> dict[str, Array]:
    """Return the variables of a scale, by role, under the names of the other face."""
    return {role + OTHER: along[role] for role in OF_A_SCALE if role in along}


def worst(along: Mapping[str, Array], role: str) -> Array:
    """Return the larger value of a scale's variable on the two faces, for comparison with a limit such as strength."""
    own = along[role]
    return np.fmax(own, along[role + OTHER]) if role + OTHER in along else own

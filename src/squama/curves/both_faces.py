"""Scales on both faces, on hinges: each face follows its own path by one face's model, and the bar is counted once.

A face sees the beam's path by :mod:`squama.beam.faces`. To first order embedded tabs do not feel those of the other
face, so what each adds to the bar is what it adds alone (:meth:`squama.beam.joint_law.Given.gathered`). On compliant
joints the scales of both faces are one system (:mod:`squama.contacts.system`).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from squama.beam import faces
from squama.beam.design import Beam
from squama.curves.curve_figures import dissipation, figures
from squama.curves.way import Asked, Case, Curve, Solved, States, Way, spaced
from squama.loads import LOADS
from squama.model.outcome import End
from squama.symbols import OF_A_SCALE, OTHER
from squama.types import Array

_NEAR = 1e-9
WHOSE = "of the other face: "
"""Before what is told of the other face's contacts."""


def sense(beam: Beam, load: str) -> int:
    """Return the sense in which the other face sees a load; 0 without scales there."""
    return faces.sense(beam.faces, LOADS[load].axis, beam.scale.alpha)


def views(beam: Beam) -> list[tuple[int, int]]:
    """Return the signs of the bend and of the twist that each face sees, the scaled face first."""
    return [(1, 1), beam.other.seen[:2]] if beam.other else [(1, 1)]


def alike(beam: Beam, load: str) -> int:
    """Return on how many faces scales do the same, where those of two do not act one at a time."""
    return 2 if sense(beam, load) > 0 else 1


def total(parts: Sequence[Mapping[str, Array]], bar: float) -> dict[str, Array]:
    """Return variables of a beam, by role, by those of its faces: sums, else those of the first.

    ``bar`` is the rigidity of the beam without contact (N m^2), which each part holds.
    """
    if len(parts) == 1:
        return dict(parts[0])
    found, rate = dict(parts[0]), parts[0]["rate"]
    once = {"tangent": bar + 0 * rate, "torque": bar * rate, "U_el": bar * rate**2 / 2}
    for role, own in (once | dict.fromkeys(("scales", "W_fr"), 0 * rate)).items():
        found[role] = own + sum(part[role] - own for part in parts)
    found["RED"] = dissipation(found["U_el"], found["W_fr"])
    return found


class Both(NamedTuple):
    """The path of a beam with scales on both faces, solved; ``lead``: the face whose scales touch first.

    ``turns`` are the signs with which the faces see the load that is held. What is told of a scale is of the leading
    face; inclination and normal force of the other's go along. The curve ends where one of the two does.
    """

    lead: Solved
    other: Solved
    turns: tuple[int, int]

    @property
    def case(self) -> Case:
        """What the beam and the model bring."""
        return self.lead.case

    @property
    def load_e(self) -> float:
        """Load angle per pitch at engagement."""
        return self.lead.load_e

    def curve(self, *, points: int, at: Array | None = None) -> Curve:
        """Return the curve at points of its leading face's own, or at load angles: NaN beyond its end."""
        own, other = self._followed(points, at)
        cuts = [float(one.figures["rate_c"]) * self.case.pitch for one in (own, other)]
        loads, cut = own.along["load"], cuts[0]
        if cuts[1] < cuts[0] * (1 - _NEAR):
            cut = cuts[1]
            loads = spaced(cut, points, self.load_e)
        loads = loads if at is None else np.asarray(at, float)
        grid = np.union1d(loads, cut)
        return self._told(own, other, grid, self._summed(*self._followed(points, grid)), loads, cut)

    def _followed(self, points: int, at: Array | None) -> tuple[Curve, Curve]:
        """Return the curves of both faces, followed once where they do the same."""
        own = self.lead.curve(points=points, at=at)
        return own, own if self.other is self.lead else self.other.curve(points=points, at=at)

    def _told(
        self, own: Curve, other: Curve, grid: Array, along: dict[str, Array], loads: Array, cut: float
    ) -> Curve:  # fmt: skip
        """Return the curve at loads among those of ``grid``, with its figures; it ends at ``cut``."""
        told, load_e = own.figures, self.load_e
        sooner = float(other.figures["rate_c"]) < float(told["rate_c"]) * (1 - _NEAR)
        ends = other.figures if sooner else told
        last = {role: float(v[np.searchsorted(grid, cut)]) for role, v in along.items() if v.dtype.kind == "f"}
        theta_end = float(told["theta_end"]) if ends is told else last["theta"]
        load_end = float(ends["load_end"])
        load_end = load_end if ends is told or math.isfinite(load_end) else cut
        kept = told | figures(self.case, last, load_e, load_end, theta_end)
        kept["load_e_other"] = float(other.figures["load_e"])
        if ends is not told:
            words = str(ends["other_contact"])
            kept["end"] = str(End.OTHER) if ends["end"] == End.NONE else ends["end"]
            kept["other_contact"] = WHOSE + words if words else ""
        if "T" in along:
            kept["T_c"] = last["T"]
        which = np.searchsorted(grid, loads)
        return Curve({role: v[which] for role, v in along.items()}, kept)

    def _summed(self, own: Curve, other: Curve) -> dict[str, Array]:
        """Return every variable of the beam by those of its faces at the same load angles, by role."""
        parts = [own.along, other.along]
        found = total(parts, self.case.rigidity)
        for role in ("T", "M"):
            # what holds a beam of oblique scales from twisting, or straight
            if role in found:
                found[role] = self.turns[0] * parts[0][role] + self.turns[1] * parts[1][role]
        return found | of_other(parts[1])


def of_other(along: Mapping[str, Array]) -> dict[str, Array]:
    """Return the figures of a scale, by role, as those of the other face."""
    return {role + OTHER: along[role] for role in OF_A_SCALE if role in along}


def worst(along: Mapping[str, Array], role: str) -> Array:
    """Return a figure of a scale on the face where it is larger, such as what is held against a strength."""
    own = along[role]
    return np.fmax(own, along[role + OTHER]) if role + OTHER in along else own


def gather(
    asked: Asked, paths: Sequence[Solved], solve: Callable[[Asked], tuple[Sequence[Solved], States]]
) -> Sequence[Solved]:  # fmt: skip
    """Return the paths of a beam by those of its scaled face, for each coefficient of friction.

    ``solve`` gives the other face's, which sees the load in its own sense.
    """
    beam, load = asked.beam, asked.way.load
    if not (seen := sense(beam, load.name)):
        return paths
    assert beam.other is not None
    mirror = asked._replace(way=Way.of(load.name, [-v for v in asked.way.values]))
    others = paths if seen > 0 else solve(mirror)[0]
    across = 1, beam.other.seen[1 - load.axis]
    found = []
    for pair in zip(paths, others, strict=True):
        lead = int(pair[1].load_e < pair[0].load_e)
        found.append(Both(pair[lead], pair[1 - lead], (across[lead], across[1 - lead])))
    return found

"""Scales on both faces: each face follows its own path by one face's model, and the bar is counted once.

A face sees the beam's path by :mod:`squama.beam.faces`. To first order embedded tabs do not feel those of the other
face, so what each adds to the bar is what it adds alone (:meth:`squama.beam.joint_law.Given.gathered`).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from squama.beam import faces
from squama.beam.design import Beam
from squama.curves.path import FINE, Asked, Case, Curve, LoadPath, Solved, figures, stiffened
from squama.loads import LOADS
from squama.model.outcome import End
from squama.types import Array

_FORCES, _ENERGIES, _SUMS = ("torque", "onset"), ("U_el", "U_bar", "work"), ("scales", "W_fr", "U_joint", "U_plate")
_NEAR = 1e-9
OTHER = "of the other face: "
"""Before what is told of the other face's contacts."""


def sense(beam: Beam, load: str) -> int:
    """Return the sense in which the other face sees a load; 0 without scales there."""
    return faces.sense(beam.faces, LOADS[load].axis, beam.scale.alpha)


def views(beam: Beam) -> list[tuple[int, int]]:
    """Return the signs of the bend and of the twist that each face sees, the scaled face first."""
    return [(1, 1), beam.other.seen] if beam.other else [(1, 1)]


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
    once = {"tangent": bar + 0 * rate} | dict.fromkeys(_FORCES, bar * rate)
    once |= dict.fromkeys(_ENERGIES, bar * rate**2 / 2) | dict.fromkeys(_SUMS, 0 * rate)
    for role in found.keys() & once.keys():
        found[role] = once[role] + sum(part[role] - once[role] for part in parts)
    if "stiffness_ratio" in found:
        found["stiffness_ratio"] = found["tangent"] / bar
    whole = found["U_el"] + found["W_fr"]
    found["RED"] = np.divide(found["W_fr"], whole, out=0 * whole, where=whole > 0)
    return found


class Both(NamedTuple):
    """The path of a beam with scales on both faces, solved; ``lead``: the face whose scales touch first.

    ``turns`` are the signs with which the faces see the load that is held. What is told of a scale is of the leading
    face; inclination and normal force of the other's go along. The curve ends where
    one of the two does.
    """

    lead: Solved
    other: Solved
    turns: tuple[int, int]

    @property
    def case(self) -> Case:
        """What the beam and the model bring."""
        return self.lead.case

    def curve(self, *, points: int, at: Array | None = None) -> Curve:
        """Return the curve at points of its leading face's own, or at load angles: NaN beyond its end."""
        own, other = (path.curve(points=points, at=at) for path in (self.lead, self.other))
        d, told = self.case.pitch, own.figures
        cuts = [float(one.figures["rate_c"]) * d for one in (own, other)]
        load_e = float(told["load_e"])
        loads, cut, ends = own.along["load"], cuts[0], told
        if cuts[1] < cuts[0] * (1 - _NEAR):
            cut, ends = cuts[1], other.figures
            loads = np.linspace(0.0, cut, points)
            if 0 < load_e < cut:
                loads[np.abs(loads - load_e).argmin()] = load_e
        loads = loads if at is None else np.asarray(at, float)
        walked = "load_twofold" in told
        # the slope right after engagement is looked at, wherever the points stand
        fine = [*np.linspace(0.0, cut, math.ceil(cut / FINE) + 1), min(load_e, cut)] if walked else []
        grid = np.union1d(np.append(loads, cut), fine)
        along = self._at(grid)
        last = {role: float(v[np.searchsorted(grid, cut)]) for role, v in along.items() if v.dtype.kind == "f"}
        theta_end = float(told["theta_end"]) if ends is told else last["theta"]
        load_end = float(ends["load_end"])
        load_end = load_end if ends is told or math.isfinite(load_end) else cut
        kept = told | figures(self.case, last, load_e, load_end, theta_end)
        kept["load_e_other"] = float(other.figures["load_e"])
        if ends is not told:
            words = str(ends["other_contact"])
            kept["end"] = str(End.OTHER) if ends["end"] == End.NONE else ends["end"]
            kept["other_contact"] = OTHER + words if words else ""
        if "T" in along:
            kept["T_c"] = last["T"]
        if walked:
            reached = np.isfinite(along["torque"])
            touching = reached & (grid >= load_e)
            ratios = along["stiffness_ratio"][touching]
            kept |= stiffened(grid[touching], ratios, grid[reached], along["torque"][reached])
        which = np.searchsorted(grid, loads)
        return Curve({role: v[which] for role, v in along.items()}, kept)

    def _at(self, loads: Array) -> dict[str, Array]:
        """Return every variable at load angles, by role."""
        parts = [path.curve(points=3, at=loads).along for path in (self.lead, self.other)]
        found = total(parts, self.case.rigidity)
        for role in ("T", "M"):
            # what holds a beam of oblique scales from twisting, or straight
            if role in found:
                found[role] = self.turns[0] * parts[0][role] + self.turns[1] * parts[1][role]
        return found | {f"{role}_other": parts[1][role] for role in ("theta", "N")}


def gather(asked: Asked, paths: Sequence[Solved], solve: Callable[[Asked], Sequence[Solved]]) -> Sequence[Solved]:
    """Return the paths of a beam by those of its scaled face, for each coefficient of friction.

    ``solve`` gives the other face's, which sees the load in its own sense.
    """
    beam, load = asked.beam, asked.path.load
    if not (way := sense(beam, load.name)):
        return paths
    assert beam.other is not None
    mirror = asked._replace(path=LoadPath.of(load.name, [-v for v in asked.path.values]))
    others = paths if way > 0 else solve(mirror)
    across = 1, beam.other.seen[1 - load.axis]
    found = []
    for pair in zip(paths, others, strict=True):
        late = float(pair[1].curve(points=3).figures["load_e"]) < float(pair[0].curve(points=3).figures["load_e"])
        lead = int(late)
        found.append(Both(pair[lead], pair[1 - lead], (across[lead], across[1 - lead])))
    return found

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
from squama.symbols import OF_A_SCALE, OTHER
from squama.types import Array

_FORCES, _ENERGIES = ("torque", "onset"), ("U_el", "U_bar", "work")
_SUMS = ("scales", "W_fr", "W_snap", "U_joint", "U_plate")
_LIMITS = ("load_strength", "load_strain", "load_second", "load_bent")
_NEAR = 1e-9
WHOSE = "of the other face: "
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
    face; inclination and normal force of the other's go along. The curve ends where one of the two does. ``far``: load
    angle to which it goes at most, of a path that is walked.
    """

    lead: Solved
    other: Solved
    turns: tuple[int, int]
    far: float = 0.0

    @property
    def case(self) -> Case:
        """What the beam and the model bring."""
        return self.lead.case

    @property
    def load_e(self) -> float:
        """Load angle per pitch at engagement."""
        return self.lead.load_e

    def curve(self, *, points: int, at: Array | None = None) -> Curve:
        """Return the curve at points of its leading face's own, or at load angles: NaN beyond its end.

        Each face that is walked is followed at load angles known before.
        """
        if self.far:
            loads = even(self.far, points, self.load_e) if at is None else np.asarray(at, float)
            grid = _fine(loads, float(loads.max(initial=0.0)), self.load_e)
            own, other = self._followed(points, grid)
            cut = min(float(one.figures["rate_c"]) for one in (own, other)) * self.case.pitch
            along = _until(cut, self._summed(own, other))
            if at is None and cut < self.far:
                # the last steps before an end hang on where the others are
                cut = float(grid[max(0, int(np.searchsorted(grid, cut)) - 2)])
                loads = even(cut, points, self.load_e)
                grid = _fine(loads, cut, self.load_e)
                along = self._summed(*self._followed(points, grid))
            return self._told(own, other, grid, along, loads, cut)
        own, other = self._followed(points, at)
        cuts = [float(one.figures["rate_c"]) * self.case.pitch for one in (own, other)]
        loads, cut = own.along["load"], cuts[0]
        if cuts[1] < cuts[0] * (1 - _NEAR):
            cut = cuts[1]
            loads = even(cut, points, self.load_e)
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
        kept |= {role: _sooner(told[role], other.figures[role], cut) for role in _LIMITS if role in told}
        if ends is not told:
            words = str(ends["other_contact"])
            kept["end"] = str(End.OTHER) if ends["end"] == End.NONE else ends["end"]
            kept["other_contact"] = WHOSE + words if words else ""
        if "T" in along:
            kept["T_c"] = last["T"]
        if "load_twofold" in told:
            reached = np.isfinite(along["torque"])
            touching = reached & (grid >= load_e)
            ratios = along["stiffness_ratio"][touching]
            kept |= stiffened(grid[touching], ratios, grid[reached], along["torque"][reached])
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


def _sooner(one: float | str, other: float | str, cut: float) -> float:
    """Return the first of two load angles at which a face comes to a limit, NaN for none up to the cut-off."""
    first = float(np.fmin(float(one), float(other)))
    return first if first <= cut * (1 + _NEAR) else math.nan


def even(cut: float, points: int, load_e: float) -> Array:
    """Return evenly spaced load angles up to ``cut``, the one next to engagement there."""
    loads = np.linspace(0.0, cut, points)
    if 0 < load_e < cut:
        loads[np.abs(loads - load_e).argmin()] = load_e
    return loads


def _fine(loads: Array, most: float, load_e: float) -> Array:
    """Return load angles and those between them at which a path that is walked is looked at for its figures."""
    # the slope right after engagement is looked at, wherever the points stand
    fine = [*np.linspace(0.0, most, math.ceil(most / FINE) + 1), min(load_e, most)]
    return np.union1d(loads, fine)


def _until(cut: float, along: dict[str, Array]) -> dict[str, Array]:
    """Return variables, by role, without their values beyond the end."""
    beyond = along["load"] > cut * (1 + _NEAR)
    kept = ("load", "rate")
    return {
        role: v if role in kept or v.dtype.kind != "f" else np.where(beyond, np.nan, v) for role, v in along.items()
    }


def gather(
    asked: Asked, paths: Sequence[Solved], solve: Callable[[Asked], Sequence[Solved]], far: float = 0.0
) -> Sequence[Solved]:
    """Return the paths of a beam by those of its scaled face, for each coefficient of friction.

    ``solve`` gives the other face's, which sees the load in its own sense; ``far`` as of :class:`Both`.
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
        lead = int(pair[1].load_e < pair[0].load_e)
        found.append(Both(pair[lead], pair[1 - lead], (across[lead], across[1 - lead]), far))
    return found

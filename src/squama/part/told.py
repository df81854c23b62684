"""What is told of a part under load, in SI units: load and travel, places, the root, scales and cells."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from squama.contacts import increments, path
from squama.contacts.row import Track
from squama.contacts.system import ALONE, STRAINS
from squama.curves import compliant, rows
from squama.curves.curve_figures import dissipation
from squama.loads import LOADS
from squama.model.outcome import End
from squama.part.loaded import Course, at_sections, sections, turned
from squama.part.loading import Load
from squama.types import Array
from squama.units import Dimension

NOT_ON = "load not reached"
"""The end of a part whose cells would be strained by more than is looked for before all of the load is on."""


class Told(NamedTuple):
    """A part that was followed from rest: its scales, first load, course, strains of the path (points,), states.

    ``on``: all that was asked is reached; ``bare`` states without contact, and with the contacts of ``endless`` beams,
    both maybe fewer; ``frames`` of all sections.
    """

    ones: Sequence[compliant.Path]
    first: Load
    course: Course
    at: Array
    track: Track
    bare: Track
    endless: Track | None
    on: bool
    frames: Array

    @classmethod
    def of(
        cls, ones: Sequence[compliant.Path], first: Load, course: Course, at: Array, *, on: bool, endless: bool = False
    ) -> Told:
        """Follow a part, and the same without contact, to strains of the path from 0 on.

        ``endless``: follow it with the law of an endless beam in each cell, too.
        """
        courses = (course, course.bare, *([course._replace(cells=ALONE)] if endless else []))
        track, bare, *more = (_from_rest(one.follow(at[1:])) for one in courses)
        local, frames = more[0] if more else None, sections(track, course.n)
        return cls(ones, first, course, at[: len(track.rows)], track, bare, local, on, frames)

    @property
    def load(self) -> Array:
        """The load (points,), E = d = 1."""
        return self.course.load(self.track)

    @property
    def share(self) -> Array:
        """Part of the load, or of the deformation that is imposed (points,)."""
        reached = self.load if self.course.loads else self.at * self.course.share
        return np.asarray(reached / self.course.full)

    def by_dim(self) -> dict[tuple[str, ...], dict[str, Array]]:
        """Return values by dimension and role."""
        x, y, z = np.moveaxis(self.frames[:, :, :3, 3], -1, 0) * self.ones[0].beam.pitch
        return {
            ("point", "section", "axis", "direction"): {"frame": self.frames[:, :, :3, :3]},
            ("point",): self._along(),
            ("point", "section"): {"x_axis": x, "y_axis": y, "z_axis": z},
            ("point", "axis"): self._root(),
            ("point", "scale"): self._of_scales(),
            (): {name: np.asarray(value) for name, value in self._single().items()},
        }

    def _along(self) -> dict[str, Array]:
        """Return load and travel, the load without contact, energies and frictional work per length."""
        one, turns = self.ones[0], self.first.measures in (Dimension.TORQUE, Dimension.ANGLE)
        unit = one.unit_moment if turns else one.unit_moment / one.beam.pitch
        if self.course.loads:
            # of the first of several: each grows as all do
            unit = self.first.size / self.course.full
        name, way = ("moment", "turn") if turns else ("F", "travel")
        others = {"bare": self.bare, **({"periodic": self.endless} if self.endless else {})}
        found = {"share": self.share, name: self.load * unit, way: self._travel() * (1.0 if turns else one.beam.pitch)}
        for word, track in others.items():
            known = self.course.load(track)[: self.at.size] * unit
            found[f"{name}_{word}"] = np.append(known, np.full(self.at.size - known.size, np.nan))
        each, per = path.named(self.track.rows), one.held.modulus * one.beam.pitch**2
        for role, name in (("U_el", "energy"), ("W_fr", "W_fr"), ("W_snap", "W_snap")):
            found[role] = each[name].mean(axis=1) * per
        return found | {"RED": dissipation(found["U_el"], found["W_fr"])}

    def _travel(self) -> Array:
        """Return the way of the first load's place along it, in pitches, or the angle by which it turns the ends."""
        n = self.course.n
        if self.course.main is None:
            return self.at * self.course.share
        if self.first.turns >= 0 and not self.course.floating:
            return turned(self.frames, self.track.cells, self.first.tie.couple)[0]
        if not self.first.tie.forces:
            carried = np.eye(STRAINS)[self.first.turns] if self.first.turns >= 0 else np.asarray(self.first.tie.carried)
            return np.asarray((self.track.cells[..., :STRAINS] @ carried).sum(axis=1))
        moved = self.frames[:, :, :3, 3] - self.frames[:1, :, :3, 3]
        places = ((j, s * f) for at, f in self.first.tie.forces for j, s in at_sections(at, n))
        return np.asarray(sum(moved[:, j] @ force for j, force in places))

    def _root(self) -> dict[str, Array]:
        """Return force (N) and moment (N m) that hold the root, in the axes that it has at rest; 0 on rollers."""
        one, points = self.ones[0], self.at.size
        force, moment = np.zeros((points, 3)), np.zeros((points, 3))
        for tie, size in zip([] if self.course.floating else self.course.every, self.track.loads.T, strict=False):
            for at, f in tie.forces:
                for j, share in at_sections(at, self.course.n):
                    force -= np.outer(size, share * f)
                    moment -= size[:, None] * np.cross(self.frames[:, j, :3, 3], share * f)
            if tie.turn is not None:
                moment -= np.outer(size, tie.turn[1])
            if tie.couple.any():
                # axes of several couples add up to one
                amount = np.linalg.norm(tie.couple)
                moment -= size[:, None] * amount * turned(self.frames, self.track.cells, tie.couple / amount)[1]
            psi, phi, chi, eps = tie.carried
            force[:, 2] -= size * eps
            moment += np.outer(size, [psi, chi, phi])
        return {"root_force": force * one.unit_moment / one.beam.pitch, "root_moment": moment * one.unit_moment}

    def _of_scales(self) -> dict[str, Array]:
        """Return what is told of scales and cells, by role."""
        track, strains, twisting = self.track, np.zeros((self.at.size, 2)), LOADS["twisting"]
        if len(self.ones) == 1:
            _, each = rows.of_scales(self.ones[0], twisting, strains, track)
        else:
            one_by_one = [
                rows.of_scales(one, twisting, strains, _alone(track, i))[1] for i, one in enumerate(self.ones)
            ]
            each = {role: np.column_stack([v[role][:, 0] for v in one_by_one]) for role in one_by_one[0]}
            rows.untouched(each)
        one = self.ones[0]
        units = one.unit_moment * np.append(np.ones(3), 1 / one.beam.pitch)
        own, carried = (np.moveaxis(v, -1, 0) for v in (track.cells[..., :4], track.cells[..., 4:]))
        # (adding 0 leaves no -0)
        each |= dict(zip(rows.CELLS, own + 0.0, strict=True))
        return each | {name: unit * v + 0.0 for name, v, unit in zip(rows.CARRIED, carried, units, strict=True)}

    def _single(self) -> dict[str, float | str]:
        """Return the single figures."""
        track, v = self.track, path.named(self.track.rows)
        up = slice(0, int(self.at.argmax()) + 1)
        engaged = math.isfinite(track.engaged)
        kept = (v["energy"] + v["W_fr"] + v["W_snap"] - v["W"]).sum(axis=1)
        most, other = float(v["energy"].sum(axis=1).max()), track.other()
        end: str = track.end.word if engaged or track.end.code != increments.RANGE else End.NONE
        if not self.on and track.end.code == increments.RANGE:
            end = NOT_ON
        return {
            "share_e": float(np.interp(track.engaged, self.at[up], self.share[up])) if engaged else math.inf,
            "end": str(end), "other_contact": rows.said(other),
            "energy_error": float(np.abs(kept).max() / most) if most > 0 else 0.0,
        }  # fmt: skip


def _alone(track: Track, i: int) -> Track:
    """Return the track of one of the scales, twice; of each face."""
    opposite = _alone(track.opposite, i) if track.opposite else None
    return track._replace(rows=track.rows[:, [i, i]], held=track.held[:, [i, i]], opposite=opposite)


def _from_rest(track: Track) -> Track:
    """Return a track with the state at rest as its first point."""

    def whole(v: Array) -> Array:
        return np.concatenate([np.zeros((1, *v.shape[1:])), v])

    rows, cells, held, loads = map(whole, (track.rows, track.cells, track.held, track.loads))
    opposite = _from_rest(track.opposite) if track.opposite else None
    found = track._replace(rows=rows, cells=cells, held=held, loads=loads, opposite=opposite)
    return found._replace(contacts=whole(track.contacts))

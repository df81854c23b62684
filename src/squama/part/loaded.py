"""A part on its way: how far its load goes and what the part does then, E = d = 1; places of its sections."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from squama.contacts import increments, path, row
from squama.contacts.row import Track
from squama.contacts.system import CHI, EPS, OWN, PHI, PSI, STRAINS
from squama.contacts.ties import Tie, Z, freed, ties
from squama.errors import refuse
from squama.model.screw import coefficients
from squama.part.loading import Load, Support, supporting
from squama.types import Array
from squama.units import Dimension, shown

MOST = 1.5
"""Strain of a cell, rad per pitch, to which a load is looked for: that of the part without contact."""
_PROBE, _COARSE, _GROWTH = 1e-5, 24, 1.7
"""Strain at which the part's stiffness without contact is measured; points of a search for the load, and by how much it
goes farther each time."""
_NEAR, _TRIES = 2e-7, 5
"""By how much the load found may differ from that which is asked, and how often it is located anew."""
_CARRIED = ("M", "torque", "B", "P")


class Course(NamedTuple):
    """A part of n cells whose load goes along one coordinate.

    ``main``: the coordinate of all loads together, whose multiplier is 1 of the largest of them where ``loads`` are
    asked; None where the far grip turns. ``axis``: the strain by whose name the path goes, and ``share``: how far the
    coordinate goes per unit of it, so that cells are strained by about that. ``full``: the load, or the deformation,
    that is asked. ``cells``: kind of cells, ``OWN``, or ``ALONE`` for those of an endless beam.
    """

    way: path.Path
    n: int
    main: Tie | None
    supports: Sequence[Tie]
    floating: bool
    axis: int
    full: float
    loads: bool
    share: float = 1.0
    cells: int = OWN

    @property
    def every(self) -> list[Tie]:
        """All ties; what the path drives knows by how much."""
        if self.main is not None:
            return [self.main._replace(course=(self.axis, self.share)), *self.supports]
        turned = -self.share * Z
        return [
            t if t.turn is None else t._replace(turn=(*t.turn[:2], turned), course=(self.axis, 0.0))
            for t in self.supports
        ]

    def follow(self, at: Array) -> Track:
        """Follow the part to strains (m,) of the path, which may go back."""
        held, free = ties(self.n, self.every, floating=self.floating), freed(self.way.beams.free, self.axis)
        return row.tied(self.way, self.n, row.legs(at, self.axis), held, free, about=self.cells)

    def load(self, track: Track) -> Array:
        """Return the load (points,)."""
        found: Array = path.named(track.rows)[_CARRIED[self.axis]][:, 0] * self.n / self.share
        return found

    @property
    def bare(self) -> Course:
        """The part without contact: its scales are too short to touch."""
        beams = self.way.beams
        shapes = beams.shapes.copy()
        shapes[:, :2] = 1e-3
        alone = beams._replace(shapes=shapes, elastic=np.zeros_like(beams.elastic))
        return self._replace(way=self.way._replace(beams=alone))

    def asked(self) -> tuple[float, bool]:
        """Return the strain of the path at which all is reached that is asked, or the part ends; whether it is."""
        if not self.loads:
            return self.full / self.share, True
        # as far as without contact, step by step: with scales it is stiffer
        stiffness = float(self.load(self.bare.follow(np.array([_PROBE])))[-1]) / _PROBE
        at = min(self.full / stiffness, MOST) / 4
        while True:
            x = np.linspace(0.0, at, _COARSE + 1)
            track = self.follow(x[1:])
            load = np.append(0.0, self.load(track))
            over = np.flatnonzero(load >= self.full)
            if over.size:
                i = int(over[0])
                return self._located(*zip(x[i - 1 : i + 1], load[i - 1 : i + 1], strict=True)), True
            if track.end.code != increments.RANGE or at >= MOST:
                return min(track.end.phi, at), False
            at = min(at * _GROWTH, MOST)

    def _located(self, low: tuple[float, float], high: tuple[float, float]) -> float:
        """Return where the load is that which is asked, between two strains with their loads."""
        x = high[0]
        for _ in range(_TRIES):
            share = (self.full - low[1]) / (high[1] - low[1])
            x = low[0] + min(max(share, 0.02), 0.98) * (high[0] - low[0])
            load = float(self.load(self.follow(np.linspace(0.0, x, _COARSE + 1)[1:]))[-1])
            if abs(load / self.full - 1) < _NEAR:
                break
            low, high = ((x, load), high) if load < self.full else (low, (x, load))
        return x


def course(way: path.Path, n: int, loads: Sequence[Load], held: Support, units: tuple[float, float, float]) -> Course:
    """Return the course of a part; ``units``: pitch in m, E d^2 in N, and E d^3 in N m."""
    axis = next((e for e in (PHI, PSI, EPS) if way.beams.free[0, e]), -1)
    said = "; ".join(load.words.strip() for load in loads)
    if axis < 0:
        refuse("load", shown(said), "cannot move a part whose strains are all held", "hold less")
    per = dict(zip((Dimension.LENGTH, Dimension.FORCE, Dimension.TORQUE), units, strict=True))
    sizes = [load.size / per.get(load.measures, 1.0) for load in loads]
    full, first = max(sizes), loads[0]
    weights = [1.0 if load.given else size / full for load, size in zip(loads, sizes, strict=True)]
    lies = held.word == "simple"
    every = list(zip(weights, [_lying(load) if lies and load.turns >= 0 else load.tie for load in loads], strict=True))
    main: Tie | None = Tie(
        [(at, w * force) for w, tie in every for at, force in tie.forces],
        np.sum([w * np.array(tie.carried) for w, tie in every], axis=0).tolist(),
        couple=np.sum([w * tie.couple for w, tie in every], axis=0),
    )
    if held.word == "gripped" and first.turns == PHI:
        main = None
    one = Course(way, n, main, supporting(held, n), lies, axis, full, not first.given)
    cells = one.bare.follow(np.array([_PROBE])).cells
    if not cells.size or not np.abs(cells).max() > 0:
        refuse("load", shown(said), "does not move the part", "put it where the part can move, or hold less")
    return one._replace(share=float(_PROBE / np.abs(cells[-1, :, :STRAINS]).max()))


def _lying(load: Load) -> Tie:
    """Return couples at both ends of a part on rollers: the same moment in all cells."""
    return Tie(carried=np.eye(STRAINS)[load.turns].tolist())


def at_sections(place: float, n: int) -> list[tuple[int, float]]:
    """Return the sections between which a place is, and the share of each."""
    j = min(int(place), n - 1)
    return [(j, 1 - (place - j)), (j + 1, place - j)]


def sections(track: Track, n: int) -> Array:
    """Return the frames (points, n + 1, 4, 4) of all sections, as the root saw them at rest."""
    points, floats = len(track.rows), track.loads.shape[1] - 6
    out = np.empty((points, n + 1, 4, 4))
    out[:, 0] = np.eye(4)
    if track.floating:
        out[:, 0] = _moved(track.loads[:, floats : floats + 3], np.zeros((points, 3)))
        out[:, 0, :3, 3] = track.loads[:, floats + 3 :]
    psi, phi, chi, eps = np.moveaxis(track.cells[..., :STRAINS], -1, 0)
    none = np.zeros(points)
    for i in range(n):
        shift = np.column_stack([none, none, 1 + eps[:, i]])
        out[:, i + 1] = out[:, i] @ _moved(-np.column_stack([psi[:, i], chi[:, i], phi[:, i]]), shift)
    return out


def turned(frames: Array, cells: Array, axis: Array) -> tuple[Array, Array]:
    """Return by which angle (points,) far ends are turned about an axis, and the couple (points, 3) that works on it.

    ``frames`` of all sections, ``cells`` with their strains; see :func:`squama.contacts.supports.couple`.
    """
    R = frames[:, -1, :3, :3]
    far = R @ axis
    q = 1 + far @ axis
    vee = np.column_stack([R[:, 2, 1] - R[:, 1, 2], R[:, 0, 2] - R[:, 2, 0], R[:, 1, 0] - R[:, 0, 1]])
    angle = np.arctan2(vee @ axis, np.trace(R, axis1=1, axis2=2) + 1 - q)
    near = -cells[..., [PSI, CHI, PHI]].sum(axis=1) @ axis
    return angle + 2 * np.pi * np.round((near - angle) / (2 * np.pi)), (axis + far) / q[:, None]


def _moved(w: Array, v: Array) -> Array:
    """Return the motions (m, 4, 4) of screws: turns (m, 3) and shifts (m, 3) (combined.md, section 1)."""
    S = np.zeros((len(w), 4, 4))
    x, y, z = w.T
    S[:, 0, 1], S[:, 0, 2], S[:, 1, 2] = -z, y, -x
    S[:, 1, 0], S[:, 2, 0], S[:, 2, 1] = z, -y, x
    S[:, :3, 3] = v
    _, b, c = coefficients((w * w).sum(axis=1)[:, None, None])
    found: Array = np.eye(4) + S + b * (S @ S) + c * (S @ S @ S)
    return found

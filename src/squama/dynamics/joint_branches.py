r"""Loading and unloading branches of thick, elastic scales on compliant joints, computed step by step.

For an endless beam, or for N scales between their ends, whose loads and energies are the means over the cells. The
model is that of ``squama.twist``, ``bend`` and ``cycle`` (:mod:`squama.curves.compliant_walk`); the unloading branch is
computed anew from each turning point. The scales' torque or moment, and their energy, are over the beam's rigidity.

In a bending mode cell i of N carries the moment lambda chi_i of the mode's inertia forces, and has a bend psi_i of its
own; the coordinate is the amplitude a = sum chi_i psi_i / sum chi_i^2. The cells of an endless beam each have its law.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy.interpolate import CubicSpline

from squama.contacts import increments, row, states
from squama.contacts.row import Track
from squama.contacts.system import ALONE, OWN
from squama.contacts.ties import KINDS, freed, of_mode
from squama.curves import compliant, compliant_cycles
from squama.dynamics.branches import APART, Branch, Side
from squama.dynamics.modes import SHAPES
from squama.loads import ENDLESS, UNIFORM, Load
from squama.types import Array

STEPS, OF_ROW = 256, 96
"""Number of points of a branch between engagement and its end, for an endless beam and for N scales."""
TOPS = 0.02
"""Largest distance, rad per pitch, of the turning points from which N scales are unloaded; others are interpolated."""
NEAR = 0.3
"""Points before a turning point keep this share of a step off it: a much shorter step may not converge."""
SMALL = 1e-4
"""Below this distance of the turning point from engagement, rad per pitch, a bent bar unloads along its loading branch.
"""
FIRST, LEAST = 4e-6, 1e-6
"""First step of an unloading, rad per pitch (each next one is twice as large); smallest even step."""
NOTHING = 1e-12
"""Torque over the bar's rigidity per pitch below which it is rounding."""


class LoadedBeam(NamedTuple):
    """A beam with thick scales under one load in one sense ``sign``; ``ends``: those of its N scales, or endless.

    ``mode``: bending mode, or "uniform".
    """

    one: compliant.Path
    load: Load
    sign: int
    ends: str = ENDLESS
    mode: str = UNIFORM

    @property
    def shape(self) -> Array:
        """Share of the largest moment that each of N cells carries."""
        return SHAPES[self.mode].of_cells(self.one.beam.pitches)

    def engaged(self, far: float) -> float:
        """Return the load angle (rad per pitch) at which scales first touch; inf if they do not up to ``far``."""
        y_e = self.one.way.engaged
        return self._track(np.array([far])).engaged if self.mode != UNIFORM and y_e < far else y_e

    def _track(self, x: Array) -> Track:
        """Follow the cells of a mode through amplitudes (n,) above 0 from rest."""
        axis, way, shape = self.load.axis, self.one.way, self.shape
        held, free = of_mode(axis, shape), freed(way.beams.free, axis)
        strains = row.legs(self.sign * x, axis)
        about = ALONE if self.ends == ENDLESS else OWN
        return row.tied(way, len(shape), strains, held, free, step=compliant_cycles.OF_ROWS, about=about)

    @property
    def steps(self) -> int:
        """Number of points of a branch."""
        return STEPS if self.alike else OF_ROW

    @property
    def alike(self) -> bool:
        """Whether all cells are strained alike."""
        return self.ends == ENDLESS and self.mode == UNIFORM

    def walk(self, x: Array) -> tuple[Array, Array, str]:
        """Follow load angles (n,) above 0 from rest, no two in a row equal, as far as the model goes.

        Returns the scales' torque and elastic energy, over the beam's rigidity per pitch, and the reason of an early
        end, or "".
        """
        if self.mode == UNIFORM:
            square, (v, end) = 1.0, compliant_cycles.reached(self.one, self.load, self.sign * x, KINDS.get(self.ends))
        else:
            square, track = float(np.mean(self.shape**2)), self._track(x)
            v, end = compliant_cycles.by_scale(track), track.end
        n = 0 if end.code == increments.AT_REST else v[0]["N"].size
        axis = 1 - self.load.axis
        alone = square * float(states.bare(self.one.way.beams)[0, axis, axis])
        q = self.sign * compliant_cycles.torque(v, self.load)[:n] / alone - x[:n]
        stored = np.mean([each["energy"][:n] for each in v], axis=0) / alone - x[:n] ** 2 / 2
        ends = "" if end.code == increments.RANGE else str(end.word)
        return np.where(np.abs(q) < NOTHING, 0.0, q), stored, ends


def side(loaded: LoadedBeam, far: float) -> Side:
    """Return the branches up to the load angle ``far`` (rad per pitch), in a mode its amplitude."""
    y_e = loaded.engaged(far)
    if not y_e < far:
        return APART._replace(y_e=y_e)
    y = np.linspace(y_e, far, loaded.steps)
    # scales touch with no force at engagement; the step after one that ends there may not converge
    force, stored, ends = loaded.walk(y[1:])
    n = 1 + force.size
    if n < 4:
        return Side(math.inf, y_e, ends)
    y = y[:n]
    up, elastic = Branch(y, np.append(0.0, force)), CubicSpline(y, np.append(0.0, stored))

    def back(top: float, steps: int) -> Branch:
        """Return the unloading branch from the load angle ``top``."""
        if top < y_e + SMALL and not loaded.load.sided:
            return up
        there = np.append(y[1:][y[1:] < top - NEAR * (y[1] - y[0])], top)
        down = _back(top, y_e, steps)
        q = loaded.walk(np.concatenate([there, down]))[0][there.size - 1 :]
        down = np.append(top, down)[: q.size]
        return Branch(np.append(y_e, down[::-1]), np.append(0.0, q[::-1]))

    if not loaded.alike:
        fall = _between(up, back)
        return Side(y_e, float(y[-1]), ends, up, lambda top: fall(float(np.max(top))), elastic)
    walked = functools.lru_cache(maxsize=256)(functools.partial(back, steps=loaded.steps))
    return Side(y_e, float(y[-1]), ends, up, lambda top: walked(float(np.max(top))), elastic)


def _between(up: Branch, back: Callable[[float, int], Branch]) -> Callable[[float], Branch]:
    """Return unloading branches from any turning point, interpolated from a few, which take long to compute.

    The drop below the loading branch, at the same share of the unloading, is linear between turning points.
    """
    y_e, last = float(up.places[0, 0]), up.last
    m = max(1, math.ceil((last - y_e) / TOPS))

    @functools.lru_cache(maxsize=256)
    def below(i: int) -> CubicSpline:
        """Return the drop below the loading branch over the share of the unloading, from turning point i."""
        top = y_e + (last - y_e) * i / m
        down = back(top, OF_ROW)
        y = down.places[::-1, 0]
        drop = up.force(y) - down.force(y)
        drop[[0, -1]] = 0.0
        return CubicSpline((top - y) / (top - y_e), drop)

    @functools.lru_cache(maxsize=256)
    def fall(top: float) -> Branch:
        i, share = divmod((top - y_e) / (last - y_e) * m, 1.0)
        farther = below(min(int(i) + 1, m))
        way = farther.x
        nearer = below(int(i))(way) if 0 < i <= m else 0.0 * way
        y = top - way * (top - y_e)
        q = up.force(y) - ((1 - share) * nearer + share * farther(way))
        return Branch(y[::-1], q[::-1])

    return fall


def _back(top: float, y_e: float, steps: int) -> Array:
    """Return the load angles of an unloading: evenly spaced to engagement, with ever finer ones at the start.

    Friction reverses there. Steps that keep growing would lose the direction in which the scales slide again: for
    turning points 1e-7 apart the energies of the unloading would differ by 1 %.
    """
    even = np.linspace(top, y_e, max(2, min(steps, int((top - y_e) / LEAST))) + 1)[1:-1]
    near = top - FIRST * 2.0 ** np.arange(60)
    return np.concatenate([near[near > (top + even[0]) / 2], even])

r"""Branches of thick, elastic scales on joints, walked along the load and back.

Of an endless beam, or of all of N scales between their ends, whose loads and energies are those of a cell in the mean.
By the same model as ``squama.twist``, ``bend`` and ``cycle`` (:mod:`squama.curves.compliant_walk`); each way back from
a turning point is walked from there. The scales' torque or moment, and their energy, are over the beam's rigidity.

Along a mode of bending, always by the endless beam, the largest curvature a is the coordinate, and each place x follows
its own bend a chi(x):

.. math::
    q_+(a) = \frac{\langle\chi\,q_+(a\chi)\rangle}{\langle\chi^2\rangle}, \qquad
    q_-(a; A) = \frac{\langle\chi\,q_-(a\chi; A\chi)\rangle}{\langle\chi^2\rangle}

where the way back of a place begins at its own largest bend.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy.interpolate import CubicSpline

from squama.contacts import increments, states
from squama.contacts.ties import KINDS
from squama.curves import compliant, compliant_cycles
from squama.dynamics.branches import APART, Branch, Side
from squama.dynamics.modes import SHAPES, gauss
from squama.loads import ENDLESS, Load
from squama.types import Array

STEPS, OF_ROW = 256, 96
"""Places of a branch between engagement and its end, of an endless beam and of N scales."""
TOPS = 0.02
"""Largest distance, rad per pitch, of turning points from which N scales are walked back; others lie between."""
ALONG = 24
"""Places along a mode, on the engaged part of the beam."""
NEAR = 0.3
"""Places on the way to a turning point keep off it by this part of a step: a much shorter step may find no balance."""
SMALL = 1e-4
"""Where a place of a bent bar turns round nearer to engagement than this, rad per pitch, it goes back as it went up."""
FIRST, LEAST = 4e-6, 1e-6
"""First step of a way back, rad per pitch, the next ones are twice as large each; least one of the even ones."""
NOTHING = 1e-12
"""Torque over that of the bar at a rad per pitch that is rounding."""


class LoadedBeam(NamedTuple):
    """A beam with thick scales under one load in one sense, ``sign``; ``ends``: of its own scales, or it is endless."""

    one: compliant.Path
    load: Load
    sign: int
    ends: str = ENDLESS

    @property
    def steps(self) -> int:
        """Number of places of a branch."""
        return STEPS if self.ends == ENDLESS else OF_ROW

    def walk(self, x: Array) -> tuple[Array, Array, str]:
        """Walk from rest through load angles (n,) above 0, no two in a row equal, as far as the scales follow.

        Their torque and elastic energy over the beam's rigidity, and what ends the way there, empty where nothing does.
        """
        v, end = compliant_cycles.reached(self.one, self.load, self.sign * x, KINDS.get(self.ends))
        n = 0 if end.code == increments.AT_REST else v[0]["N"].size
        axis = 1 - self.load.axis
        alone = float(states.bare(self.one.way.beams)[0, axis, axis])
        q = self.sign * compliant_cycles.torque(v, self.load)[:n] / alone - x[:n]
        stored = np.mean([each["energy"][:n] for each in v], axis=0) / alone - x[:n] ** 2 / 2
        ends = "" if end.code == increments.RANGE else str(end.word)
        return np.where(np.abs(q) < NOTHING, 0.0, q), stored, ends


def side(loaded: LoadedBeam, far: float, mode: str) -> Side:
    """Return the branches up to the load angle ``far`` per pitch; in a mode the largest along the beam."""
    y_e = loaded.one.way.engaged
    if not y_e < far:
        return APART._replace(y_e=y_e)
    y = np.linspace(y_e, far, loaded.steps)
    # scales touch with no force; a step that ends there would be followed by one that may find no balance
    force, stored, ends = loaded.walk(y[1:])
    n = 1 + force.size
    if n < 4:
        return Side(math.inf, y_e, ends)
    y = y[:n]
    up, elastic = Branch(y, np.append(0.0, force)), CubicSpline(y, np.append(0.0, stored))

    def back(top: float, steps: int) -> Branch:
        """Return the way back from a load angle."""
        if top < y_e + SMALL and not loaded.load.sided:
            return up
        there = np.append(y[1:][y[1:] < top - NEAR * (y[1] - y[0])], top)
        down = _back(top, y_e, steps)
        q = loaded.walk(np.concatenate([there, down]))[0][there.size - 1 :]
        down = np.append(top, down)[: q.size]
        return Branch(np.append(y_e, down[::-1]), np.append(0.0, q[::-1]))

    if mode != "uniform":
        return _modal(mode, up, elastic, back, ends)
    if loaded.ends != ENDLESS:
        fall = _between(up, back)
        return Side(y_e, float(y[-1]), ends, up, lambda top: fall(float(np.max(top))), elastic)
    walked = functools.lru_cache(maxsize=256)(functools.partial(back, steps=loaded.steps))
    return Side(y_e, float(y[-1]), ends, up, lambda top: walked(float(np.max(top))), elastic)


def _between(up: Branch, back: Callable[[float, int], Branch]) -> Callable[[float], Branch]:
    """Return the ways back from any turning point by those from some, which take long to walk.

    By how much they are below the loading branch is linear between turning points, at the same share of the way back.
    """
    y_e, last = float(up.places[0, 0]), up.last
    m = max(1, math.ceil((last - y_e) / TOPS))

    @functools.lru_cache(maxsize=256)
    def below(i: int) -> CubicSpline:
        """Return how far below, over the share of the way back from turning point number i."""
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
    """Return the places of a way back: even ones to where the contact opens, and before them some ever closer ones.

    The friction turns round there. Steps that keep growing lose the direction in which the scales slide again: of tops
    1e-7 apart the energies of the way back then differ by 1 %.
    """
    even = np.linspace(top, y_e, max(2, min(steps, int((top - y_e) / LEAST))) + 1)[1:-1]
    near = top - FIRST * 2.0 ** np.arange(60)
    return np.concatenate([near[near > (top + even[0]) / 2], even])


def _modal(mode: str, up: Branch, elastic: CubicSpline, back: Callable[[float, int], Branch], ends: str) -> Side:
    """Return the branches of a mode by those of uniform bending."""
    m, (nodes, weights) = SHAPES[mode], gauss(ALONG)
    y_e, last = float(up.places[0, 0]), up.last

    def places(top: float) -> tuple[Array, Array]:
        """Return shape and weights at places of the part that is engaged at the largest curvature ``top``."""
        share = float(m.far(np.array([min(y_e / top, 1.0)]))[0])
        return m.shape(share * nodes), share * weights * m.weight / m.square

    # of a power 3/2 of a - y_e
    a = y_e + (last - y_e) * np.linspace(0.0, 1.0, STEPS) ** 1.5
    force, stored = np.zeros((2, a.size))
    for i in range(1, a.size):
        chi, w = places(a[i])
        force[i], stored[i] = (w * chi) @ up.force(a[i] * chi), w @ elastic(a[i] * chi)

    @functools.lru_cache(maxsize=256)
    def fall(top: float) -> Branch:
        chi, w = places(top)
        down = np.concatenate([[y_e], _back(top, y_e, STEPS // 2)[::-1], [top]])
        q = np.zeros(down.size)
        for one, part in zip(chi, w, strict=True):
            branch, bends = back(top * float(one), STEPS // 4), down * one
            q += part * one * np.where(bends > y_e, branch.force(np.clip(bends, y_e, branch.last)), 0.0)
        return Branch(down, q)

    return Side(y_e, last, ends, Branch(a, force), lambda top: fall(float(np.max(top))), CubicSpline(a, stored))

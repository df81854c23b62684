r"""Branches of a real beam that is bent: thick, elastic scales on joints, walked along the bend and back.

By the same model as ``squama.bend`` and ``squama.cycle`` in bending: a path of both loads
(:mod:`squama.contacts.legs`), the twist held. The scales' moment and energy are over the beam's rigidity.

Along a mode the largest curvature a is the coordinate, and each place x follows its own bend a chi(x):

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

from squama.beam.design import Beam
from squama.contacts import increments, path, states
from squama.contacts.legs import follow_legs
from squama.curves import cycle_points, real, real_cycles
from squama.curves.real_bent import BENT
from squama.curves.real_polygons import bending_rigidity
from squama.dynamics.branches import APART, Branch, Side
from squama.dynamics.modes import SHAPES, gauss
from squama.types import Array

STEPS = 256
"""Places of a branch between engagement and its end."""
ALONG = 24
"""Places along a mode, on the engaged part of the beam."""
NEAR = 0.3
"""Bends on the way to a turning point keep off it by this part of a step: a much shorter step may find no balance."""
SMALL = 1e-4
"""Where a place turns round nearer to engagement than this, rad per pitch, its way back is taken as its way up."""


class Walked(NamedTuple):
    """States at bends as far as the scales follow: their moment and elastic energy over the beam's rigidity.

    ``ends`` is what ends the way there, empty where nothing does.
    """

    q: Array
    stored: Array
    ends: str


class Bend(NamedTuple):
    """A real beam that is bent in one sense, ``sign``: what :func:`squama.contacts.legs.follow_legs` takes."""

    scale: path.Scale
    K: Array
    mu: float
    bar: real.Bar
    sign: int

    @classmethod
    def of(cls, beam: Beam, mu: float, sign: int, *, ideal: bool) -> Bend:
        """Return that of a beam."""
        scale, held = real.scale(beam, ideal=ideal), real.Held.of(beam, BENT)
        return cls(scale, held.K, mu, held.bar, sign)

    def engages(self, far: float) -> float:
        """Return the bend per pitch at which scales come into contact, looked for up to ``far``; inf for none."""
        way = follow_legs(self.scale, self.K, self.mu, np.array([(self.sign * far, 0.0)]), **self.bar).way
        return min((c.phi for c in way.contacts if c.first != -1), default=math.inf)

    def walk(self, x: Array) -> Walked:
        """Walk from rest through bends (n,), no two in a row equal."""
        corners = np.column_stack([self.sign * x, 0.0 * x])
        found = follow_legs(self.scale, self.K, self.mu, corners, **self.bar, step=real_cycles.INCREMENT)
        end, alone = found.answers.end(), float(states.bare(found.way.beams)[0, 1, 1])
        n, ends = (x.size, "") if end.code == increments.RANGE else (end.solved, str(end.word))
        u = states.energies(found.way, *(face.rows[0] for face in found.answers.faces))
        stored = u["U_joint"] + u["U_plate"]
        return Walked(self.sign * found.M[:n] / alone - x[:n], stored[:n] / alone, ends)


def rigidity(beam: Beam) -> float:
    """Return the bending rigidity of a beam without contact, N m^2."""
    held, scale = real.Held.of(beam, BENT), real.scale(beam, ideal=True)
    at_rest = follow_legs(scale, held.K, 0.0, np.empty((0, 2)), **held.bar)
    return bending_rigidity(beam, at_rest.way)


def side(bend: Bend, far: float, mode: str) -> Side:
    """Return the branches up to the bend ``far`` per pitch; in a mode the largest along the beam."""
    y_e = bend.engages(max(far, path.RANGE))
    if not y_e < far:
        return APART._replace(y_e=y_e)
    y = np.linspace(y_e, far, STEPS)
    # scales touch with no force; a step that ends there would be followed by one that may find no balance
    found = bend.walk(y[1:])
    n = 1 + found.q.size
    if n < 4:
        return Side(math.inf, y_e, found.ends)
    y = y[:n]
    up, elastic = Branch(y, np.append(0.0, found.q)), CubicSpline(y, np.append(0.0, found.stored))

    def back(top: float, steps: int) -> Branch:
        """Return the way back from a bend."""
        if top < y_e + SMALL:
            return up
        there = np.append(y[1:][y[1:] < top - NEAR * (y[1] - y[0])], top)
        down = np.array([v for v in cycle_points.goals_of(top, 0.0, steps) if v > y_e + 1e-9])
        q = bend.walk(np.concatenate([there, down])).q[there.size - 1 :]
        down = np.append(top, down)[: q.size]
        return Branch(np.append(y_e, down[::-1]), np.append(0.0, q[::-1]))

    if mode != "uniform":
        return _modal(mode, up, elastic, back, found.ends)
    walked = functools.lru_cache(maxsize=256)(functools.partial(back, steps=STEPS))
    return Side(y_e, float(y[-1]), found.ends, up, lambda top: walked(float(np.max(top))), elastic)


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
        down = np.array([v for v in cycle_points.goals_of(top, 0.0, STEPS // 2) if v > y_e + 1e-9])
        down = np.concatenate([[y_e], down[::-1], [top]])
        q = np.zeros(down.size)
        for one, part in zip(chi, w, strict=True):
            branch, bends = back(top * float(one), STEPS // 4), down * one
            q += part * one * np.where(bends > y_e, branch.force(np.clip(bends, y_e, branch.last)), 0.0)
        return Branch(down, q)

    return Side(y_e, last, ends, Branch(a, force), lambda top: fall(float(np.max(top))), CubicSpline(a, stored))

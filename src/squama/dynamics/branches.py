r"""What scales add to the torque of a bar that swings: a loading and an unloading branch over the load angle.

The load angle per pitch y is a magnitude in one sense of load, and everything is over the bar's own rigidity per
pitch, so that the bare bar's torque is y and its energy y^2/2. A contact on hinges has two branches

.. math::
    q_\pm(y) = \frac{Q_\pm}{\kappa}, \qquad
    Q_\pm = \frac{(\theta - \theta_0)\,\theta' \pm \mu N_\pm r'}{y'}, \qquad \kappa = \frac{C_f J G_B}{K_\theta d}

(:mod:`squama.model.history`). In a bending mode y = a chi(x), and a takes the place of y with
q(a) = <chi q(a chi)>/<chi^2>, <..> the mean over the beam.
"""

from __future__ import annotations

import functools
import math
from bisect import bisect_right
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from scipy.interpolate import CubicSpline

from squama.curves import hinge
from squama.loads import MODES
from squama.model import history
from squama.model.outcome import End
from squama.model.paths import ARRAY
from squama.types import Array

NODES = 256
"""Places of a branch, per unit of the logarithm in which the pole of friction is straight: peaks to some 1e-11."""
FINEST = 1e-6
"""Part of a path left before a lock at which its branches end, where nothing ends them before."""


class Branch:
    """One branch: scales' torque ``force(y)``, its integral from engagement ``work(y)``; splines up to ``last``."""

    def __init__(self, y: Array, q: Array) -> None:
        self.force = CubicSpline(y, q)
        self.work = self.force.antiderivative()
        self.last = float(y[-1])

    @functools.cached_property
    def quick(self) -> Callable[[float], float]:
        """The torque as a function of one number: the spline's own takes ten times as long for it."""
        knots, pieces = self.force.x.tolist(), self.force.c.T.tolist()
        most = len(pieces) - 1

        def force(y: float) -> float:
            i = min(max(bisect_right(knots, y) - 1, 0), most)
            a, b, c, d = pieces[i]
            s = y - knots[i]
            return float(d + s * (c + s * (b + s * a)))

        return force

    def energy(self, y: float) -> float:
        """Work of the whole torque, bar included, from rest to ``y``."""
        return y * y / 2 + (float(self.work(y)) if y > self.force.x[0] else 0.0)


class Side(NamedTuple):
    """One sense of load: engagement ``y_e`` (inf for none), the last angle that is followed, and what ends it.

    ``up`` is the loading branch, ``fall`` gives the unloading branch from a turning point (on hinges always the same),
    ``elastic`` the scales' elastic energy on the way up. ``endless``: the end is a frictional lock, which no energy
    reaches.
    """

    y_e: float
    last: float
    ends: str = ""
    up: Branch | None = None
    fall: Callable[[float], Branch] | None = None
    elastic: Callable[[Any], Any] | None = None
    endless: bool = False

    def rising(self) -> Branch:
        """Return the loading branch."""
        assert self.up is not None
        return self.up

    def falling(self, top: float) -> Branch:
        """Return the unloading branch from a turning point."""
        assert self.fall is not None
        return self.fall(top)

    def stored(self, y: float) -> float:
        """Elastic energy at ``y``, bar included."""
        return y * y / 2 + (float(self.elastic(y)) if self.elastic and y > self.y_e else 0.0)

    def height(self) -> float:
        """Work that it takes to come to the last angle; inf at a frictional lock."""
        if self.endless:
            return math.inf
        return self.up.energy(self.last) if self.up else self.last * self.last / 2


APART = Side(math.inf, math.inf)
"""A sense in which no scales touch: the bar is linear."""


def places(start: float, stop: float, pole: float) -> Array:
    """Path parameters of a branch: close where it begins, and towards the pole of the friction force."""
    end = -math.log1p(-(stop - start) / (pole - start))
    w = np.linspace(0.0, 1.0, int(NODES * max(1.0, end)) + 1)
    x = start - (pole - start) * np.expm1(-end * w**1.5)
    x[-1] = stop
    return np.asarray(x)


def hinged(side: history.Side, kappa: float, ends: str, top: float = math.inf) -> Side:
    """Return the branches of scales on hinges, to the path's end or to the load angle ``top``, if that is before."""
    x = places(side.x0, side.x_end, side.pole)
    pt = side.row.point(x, side.law, ARRAY)
    y = pt.load
    if top < y[-1]:
        beyond = int(np.searchsorted(y, top)) + 1
        x = places(side.x0, float(x[beyond]), side.pole) if beyond < x.size else x
        pt = side.row.point(x, side.law, ARRAY)
        y = pt.load
    lift = pt.theta - side.row.theta0
    up, down = (side.forces(pt, way) for way in (1, -1))
    back = Branch(y, up.torque / kappa)
    # where D <= 0 friction holds the scales: there is no unloading branch beyond
    held = np.flatnonzero(~(down.D > 0))
    count = int(held[0]) if held.size else y.size
    fall = Branch(y[:count], down.torque[:count] / kappa)
    elastic = CubicSpline(y, lift**2 / 2 / kappa)
    return Side(float(y[0]), float(y[-1]), ends, back, lambda _: fall, elastic)


def of_path(path: hinge.Path, kappa: float, top: float = math.inf) -> Side:
    """Return the branches of a solved path; ``kappa`` is the bar's rigidity over K_theta d."""
    ends = words(path.end, path.other)
    if not path.engaged:
        return APART if path.end is End.NONE and not path.other else Side(math.inf, path.load_end, ends)
    return hinged(path.side, kappa, ends, top)._replace(endless=path.end is End.FRICTIONAL and path.mu > 0)


def words(end: str, other: str) -> str:
    """Say what ends a path."""
    return f"{end} ({other})" if other else str(end)


# ---- modes ------------------------------------------------------------------------------------------------


class Mode(NamedTuple):
    """Shape of a bending mode over the distance s from its largest curvature: chi falls from 1 to 0.

    ``weight`` parts of the beam have that shape; ``square`` is the mean of chi^2; omega0 = (number/L)^2 sqrt(E I/m').
    """

    shape: Callable[[Array], Array]
    far: Callable[[Array], Array]
    weight: float
    square: float
    number: float


_B = 1.8751040687119611
_S = (math.cosh(_B) + math.cos(_B)) / (math.sinh(_B) + math.sin(_B))


def _cantilever(s: Array) -> Array:
    v = _B * np.asarray(s)
    return np.asarray((np.cosh(v) + np.cos(v) - _S * (np.sinh(v) + np.sin(v))) / 2)


def _cantilever_far(chi: Array) -> Array:
    """Place at which the cantilever's curvature has a share of its largest: Newton's method, chi is convex."""
    s = np.zeros_like(chi)
    for _ in range(60):
        v = _B * s
        slope = _B * (np.sinh(v) - np.sin(v) - _S * (np.cosh(v) + np.cos(v))) / 2
        step = (_cantilever(s) - chi) / np.minimum(slope, -1e-12)
        s = np.clip(s - step, 0.0, 1.0)
        if np.abs(step).max(initial=0.0) < 1e-15:
            break
    return s


SHAPES = dict(zip(MODES[1:], (
    Mode(lambda s: np.cos(np.pi * s), lambda c: np.arccos(c) / np.pi, 2.0, 0.5, math.pi),
    Mode(_cantilever, _cantilever_far, 1.0, 0.25, _B),
), strict=True))  # fmt: skip
"""First bending modes (<chi^2> of the cantilever is 1/4 exactly)."""


def modal(side: Side, mode: str) -> Side:
    """Return the branches of a bending mode, by those of uniform bending; the largest curvature is the coordinate."""
    if mode == "uniform" or side.up is None:
        return side
    m, y = SHAPES[mode], side.rising().force.x
    share = m.far(np.clip(side.y_e / y, 0.0, 1.0))
    nodes, weights = gauss(48)
    # engaged is what bends more than engagement asks for
    s = share[:, None] * nodes
    chi, w = m.shape(s), share[:, None] * weights * m.weight / m.square
    local = np.maximum(y[:, None] * chi, side.y_e)

    def mean(f: Callable[[Array], Array], power: int) -> Array:
        return np.asarray((w * chi**power * f(local)).sum(axis=1))

    up = Branch(y, mean(side.rising().force, 1))
    fall = side.falling(side.last)
    n = int(np.searchsorted(y, fall.last, side="right"))
    down = Branch(y[:n], mean(fall.force, 1)[:n])
    assert side.elastic is not None
    return side._replace(up=up, fall=lambda _: down, elastic=CubicSpline(y, mean(side.elastic, 0)))


@functools.cache
def gauss(n: int) -> tuple[Array, Array]:
    """Return nodes and weights of Gauss and Legendre on [0, 1]."""
    x, w = np.polynomial.legendre.leggauss(n)
    return (x + 1) / 2, w / 2

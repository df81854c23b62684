r"""Torque that scales add to a vibrating bar: a loading and an unloading branch over the load angle.

The load angle per pitch y is a magnitude in one sense of load, and all torques are over the bar's own rigidity per
pitch, so that the bare bar's torque is y and its energy y^2/2. A contact on hinges has two branches

.. math::
    q_\pm(y) = \frac{Q_\pm}{\kappa}, \qquad
    Q_\pm = \frac{(\theta - \theta_0)\,\theta' \pm \mu N_\pm r'}{y'}, \qquad \kappa = \frac{C_f J G_B}{K_\theta d}

(:mod:`squama.model.history`). In a bending mode y = a chi(x); the amplitude a takes the place of y with q(a) = <chi q(a
chi)>/<chi^2>, where <..> is the mean over the beam.
"""

from __future__ import annotations

import functools
import math
from bisect import bisect_right
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from scipy.interpolate import CubicSpline

from squama.types import Array

Curve = Callable[[Array], Array]


class Way:
    """A branch of n systems, over a parameter s that grows with the load angle; functions of s of shape (..., n).

    ``load`` is the load angle and ``rate`` its derivative with respect to s; ``energy`` is the work of the whole
    torque, bar included, from rest, and ``slope`` its derivative. ``places`` (m, 1) are samples of s from engagement
    on, ``energies`` (m, n) the energies there, to bracket roots; ``last``, (n,) or one number, is s at the end.
    """

    def __init__(self, load: Curve, rate: Curve, energy: Curve, slope: Curve, places: Array, last: Any) -> None:
        self.load, self.rate, self.energy, self.slope = load, rate, energy, slope
        self.places, self.energies, self.last = places, energy(places), last


class Branch(Way):
    """A branch of one system with s = y: the scales' torque ``force(y)`` and its integral ``work(y)``, as splines."""

    def __init__(self, y: Array, q: Array) -> None:
        force = CubicSpline(y, q)
        self.force, self.work = force, force.antiderivative()

        def energy(s: Array) -> Array:
            return np.asarray(s * s / 2 + self.work(s))

        def slope(s: Array) -> Array:
            return np.asarray(s + force(s))

        super().__init__(lambda s: s, np.ones_like, energy, slope, y[:, None], float(y[-1]))

    @functools.cached_property
    def quick(self) -> Callable[[float], float]:
        """Torque as a function of one float, ten times as fast as the spline's own evaluation."""
        knots, (a, b, c, d) = self.force.x.tolist(), self.force.c.tolist()
        most = len(a) - 1

        def force(y: float) -> float:
            i = min(max(bisect_right(knots, y) - 1, 0), most)
            s = y - knots[i]
            return float(d[i] + s * (c[i] + s * (b[i] + s * a[i])))

        return force


class Side(NamedTuple):
    """One sense of load of n systems: engagement ``y_e`` (inf for none), ``last`` followed angle, reason ``ends``.

    ``up`` is the loading branch, ``fall`` returns the unloading branch from a turning point (on hinges always the
    same), ``elastic`` is the scales' elastic energy at a parameter s of the loading branch. ``endless``: the end is a
    frictional lock, which no energy reaches. Integration in time needs branches of type :class:`Branch`.
    """

    y_e: Any
    last: Any
    ends: str = ""
    up: Any = None
    fall: Callable[[float | Array], Way] | None = None
    elastic: Callable[[Array], Array] | None = None
    endless: Any = False

    def falling(self, top: float | Array) -> Any:
        """Return the unloading branch from a turning point."""
        assert self.fall is not None
        return self.fall(top)

    def stored(self, y: float | Array, s: Any) -> Any:
        """Return the elastic energy at the load angle ``y``, bar included; ``s`` is its parameter if scales touch."""
        bar = y * y / 2
        return bar + np.where(y > self.y_e, self.elastic(s), 0.0) if self.elastic else bar

    def height(self) -> Any:
        """Return the work needed to reach the last angle; inf at a frictional lock."""
        work = self.up.energies[-1] if self.up else np.square(self.last) / 2
        return np.where(self.endless, math.inf, work)


APART = Side(math.inf, math.inf)
"""Sense of load in which no scales touch: the bar is linear."""

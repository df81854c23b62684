r"""Branches of scales on hinges for many designs: piecewise polynomials over a parameter s of the path, 0 to 1.

With x the path parameter, x_p the pole of friction and E = -ln(1 - (x_1 - x_0)/(x_p - x_0)),

.. math::
    x = x_0 + (x_p - x_0)\,(1 - e^{-E s^p}), \qquad
    V_\pm(s) = \frac{y_e^2}{2} + \int_0^s \Bigl(y + \frac{Q_\pm}{\kappa}\Bigr)\,\frac{dy}{ds}\,ds

which is smooth up to the pole; p = 1. Along a mode V(a) = a^2/2 + <V(a chi) - (a chi)^2/2>/<chi^2> begins with a power
5/2 of a - y_e, which p = 2 makes smooth.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
from numpy.polynomial import polynomial
from scipy.interpolate import CubicSpline

from squama.curves import hinge
from squama.dynamics.branches import APART, Branch, Side, Way
from squama.dynamics.modes import SHAPES, gauss
from squama.model import energy, history, mechanics
from squama.model.outcome import CODES, SLID, End
from squama.model.paths import ARRAY
from squama.model.tracks import OneRow, Track, at_loads, take
from squama.types import Array

FINEST = 1e-6
"""Share of the path left before a lock; there its branches end, unless something ends them before."""
NODES = 10
"""Number of nodes in a part of a piecewise polynomial."""
PARTS = (8, 16, 32, 64)
"""Numbers of parts of a path to try, until the polynomials converge."""
ENOUGH = 1e-11
"""Last term of a polynomial over its largest value at which it counts as converged."""
ALONG = 48
"""Number of quadrature points along a mode, on the engaged part of the beam."""
SAMPLES = 256
"""Number of knots of a spline per unit of E."""


class Pieces:
    """Piecewise polynomials on equal parts of [0, 1] for n designs; coefficients (degree + 1, parts, n).

    Functions of s in [0, 1], shape (..., n) or (..., 1).
    """

    def __init__(self, coefficients: Array) -> None:
        self.c = np.ascontiguousarray(coefficients)
        _, self.parts, self.n = coefficients.shape
        self.own = np.arange(self.n)

    @classmethod
    def through(cls, values: Array) -> Pieces:
        """Return the polynomials through values at the nodes, shape (parts NODES, n)."""
        parted = values.reshape(-1, NODES, values.shape[1])
        return cls(np.einsum("kj,pjn->kpn", _rule()[1], parted, optimize=True))

    def __call__(self, s: Array) -> Array:
        """Return the values at s, shape (..., n)."""
        at = s * self.parts
        i = np.minimum(at.astype(int), self.parts - 1)
        r = 2 * (at - i) - 1
        last, *rows = self.c.reshape(len(self.c), -1).take(i * self.n + self.own, axis=1)[::-1]
        for row in rows:
            last *= r
            last += row
        return np.asarray(last)

    def derivative(self) -> Pieces:
        """Return the derivatives with respect to s."""
        return Pieces(2 * self.parts * polynomial.polyder(self.c))

    def integral(self, start: Array) -> Pieces:
        """Return the integrals, with the value ``start`` at s = 0."""
        c = polynomial.polyint(self.c, lbnd=-1) / (2 * self.parts)
        ends = c.sum(axis=0)
        c[0] += start + np.cumsum(ends, axis=0) - ends
        return Pieces(c)

    def rough(self) -> Array:
        """Return the last terms over the largest values (n,), a measure of convergence."""
        last = np.abs(self.c[-1]).max(axis=0) / 2 ** (len(self.c) - 2)
        return np.asarray(last / np.abs(self.c).sum(axis=0).max(axis=0))

    def take(self, index: Array) -> Pieces:
        """Return the polynomials of the designs ``index``."""
        return Pieces(self.c[:, :, index])


@functools.cache
def _rule() -> tuple[Array, Array]:
    """Return Chebyshev nodes on [-1, 1], and the matrix from values at them to coefficients of powers."""
    r = np.polynomial.chebyshev.chebpts1(NODES)
    return r, np.linalg.inv(np.vander(r, increasing=True))


def _nodes(parts: int) -> Array:
    """Return all nodes on [0, 1], shape (parts NODES, 1)."""
    return ((np.arange(parts)[:, None] + (_rule()[0] + 1) / 2) / parts).reshape(-1, 1)


class PathBranch(Way):
    """A branch of n designs as piecewise polynomials; ``last`` (n,) is the parameter s of its end."""

    def __init__(self, load: Pieces, energy: Pieces, slope: Pieces, last: Array) -> None:
        self.pieces = load, energy, slope
        places = np.concatenate([[[0.0]], _nodes(load.parts), [[1.0]]])
        super().__init__(load, load.derivative(), energy, slope, places, last)

    def take(self, index: Array) -> PathBranch:
        """Return the branches of the designs ``index``."""
        load, energy, slope = (v.take(index) for v in self.pieces)
        return PathBranch(load, energy, slope, self.last[index])


class Paths(NamedTuple):
    """Paths of n designs in contact, from ``x0`` to ``x1``; ``endless`` (n,) if a frictional lock ends them."""

    row: OneRow
    law: str
    mu: Array
    kappa: Array
    x0: Array
    x1: Array
    pole: Array
    endless: Array

    @classmethod
    def of(cls, side: history.Side, kappa: float, *, endless: bool) -> Paths:
        """Return the path of one design from its :class:`squama.model.history.Side`."""
        row = type(side.row)(*(np.atleast_1d(v) for v in side.row))
        mu, kappas, x0, x1, pole = np.array([[side.mu, kappa, side.x0, side.x_end, side.pole]]).T
        return cls(row, side.law, mu, kappas, x0, x1, pole, np.array([endless]))

    @classmethod
    def solved(cls, t: Track, law: str, mu: Array, kappa: Array) -> Paths:
        """Return the paths of a track, cut off before locks."""
        locks = np.isin(t.code, SLID)
        x1 = energy.cutoff(t.row, t.x0, t.x_end, locks, FINEST)
        pole = np.where(t.x_end > t.x0, energy.pole(t.row, t.x_end, mu, law, t.x0), t.x0 + 1)
        return cls(t.row, law, mu, kappa, t.x0, x1, pole, (t.code == CODES.index(End.FRICTIONAL)) & (mu > 0))

    def take(self, index: Array) -> Paths:
        """Return the paths of the designs ``index``."""
        return Paths(take(self.row, index), self.law, *(v[index] for v in self[2:]))

    def up_to(self, top: Array) -> Paths:
        """Return the paths cut at the load angles ``top`` (n,)."""
        seen = [self.row.point(x, self.law, ARRAY).load for x in (self.x0, self.x1)]
        x = at_loads(self.row, np.clip(top, *seen), (self.x0, self.x1), (seen[0], seen[1]))
        return self._replace(x1=x)

    @property
    def reach(self) -> Array:
        """The quantity E (n,) in the head of this module."""
        return np.asarray(-np.log1p(-(self.x1 - self.x0) / (self.pole - self.x0)))

    def contact(self, w: Array) -> Contact:
        """Return the contact at w = s^p, which grows along the first axis."""
        e, far = self.reach, self.pole - self.x0
        x = np.minimum(self.x0 - far * np.expm1(-e * w), self.x1)
        pt = self.row.point(x, self.law, ARRAY)
        up, down = (mechanics.forces(pt, self.row.theta0, way * self.mu) for way in (1, -1))
        # if D <= 0 friction holds the scales: the unloading branch ends there
        free = np.logical_and.accumulate(down.D > 0, axis=0)
        rate, lift = pt.load_rate * far * e * np.exp(-e * w), (pt.theta - self.row.theta0) ** 2 / 2
        return Contact(pt.load, rate, up.torque / self.kappa, down.torque / self.kappa, lift / self.kappa, free)


class Contact(NamedTuple):
    """Contact along a path: load angle, its derivative with w, torques of both branches and energy of the joint.

    Torques and energy are over kappa; ``free``: whether the unloading branch exists up to this point.
    """

    y: Array
    rate: Array
    up: Array
    down: Array
    lift: Array
    free: Array


def sides(paths: Paths, mode: str = "uniform") -> Iterator[tuple[Array, Side]]:
    """Yield the branches of designs in groups with the same number of parts: indices and side."""
    left = np.arange(paths.mu.size)
    for parts in PARTS:
        some = paths.take(left)
        side, rough = _uniform(some, parts)
        if mode != "uniform":
            side, rough_too = _modal(some, side, mode, parts)
            rough = np.maximum(rough, rough_too)
        good = np.flatnonzero((rough < ENOUGH) | (parts == PARTS[-1]))
        if good.size:
            yield left[good], _some(side, good)
        left = np.delete(left, good)
        if not left.size:
            return


def _some(side: Side, index: Array) -> Side:
    up, down = side.up.take(index), side.falling(math.inf).take(index)
    elastic: Any = side.elastic
    return Side(side.y_e[index], side.last[index], "", up, lambda _: down, elastic.take(index), side.endless[index])


def _uniform(paths: Paths, parts: int) -> tuple[Side, Array]:
    """Return the branches of paths in ``parts`` parts, and their measure of convergence (n,)."""
    y_e, last = (paths.row.point(x, paths.law, ARRAY).load for x in (paths.x0, paths.x1))
    with np.errstate(all="ignore"):
        at = paths.contact(_nodes(parts))
        # the unloading branch leaves out the part in which it ends
        free = np.repeat(at.free[NODES - 1 :: NODES], NODES, axis=0)
        slopes = ((at.y + at.up) * at.rate, np.where(free, (at.y + at.down) * at.rate, 0.0))
    load, elastic, *ways = (Pieces.through(v) for v in (at.y, at.lift, *slopes))
    ends = np.ones_like(y_e), free.mean(axis=0)
    up, down = (PathBranch(load, v.integral(y_e * y_e / 2), v, end) for v, end in zip(ways, ends, strict=True))
    rough = np.max([v.rough() for v in (load, elastic, *ways)], axis=0)
    return Side(y_e, last, "", up, lambda _: down, elastic, paths.endless), rough


def _modal(paths: Paths, side: Side, mode: str, parts: int) -> tuple[Side, Array]:
    """Return the branches of a mode from those of uniform bending, and their measure of convergence (n,).

    The coordinate is the largest curvature along the beam, per pitch.
    """
    m, s = SHAPES[mode], _nodes(parts)
    y = side.up.load(s * s)
    share = m.far(np.minimum(side.y_e / y, 1.0))
    ways = (side.up, side.falling(math.inf))
    elastic: Any = side.elastic
    means = np.zeros((3, *y.shape))
    for node, weight in zip(*gauss(ALONG), strict=True):
        # a place is engaged if its bend exceeds that of engagement
        local = np.maximum(y * m.shape(share * node), side.y_e)
        x = at_loads(paths.row, local, (paths.x0, paths.x1), (side.y_e, side.last))
        w = np.clip(-np.log1p(-(x - paths.x0) / (paths.pole - paths.x0)) / paths.reach, 0.0, 1.0)
        values = np.array([*(way.energy(w) - local * local / 2 for way in ways), elastic(w)])
        means += share * (weight * m.weight / m.square) * values
    load, lift, *works = (Pieces.through(v) for v in (y, means[2], *(y * y / 2 + means[:2])))
    up, down = (
        PathBranch(load, work, work.derivative(), np.sqrt(way.last)) for work, way in zip(works, ways, strict=True)
    )
    rough = np.max([v.rough() for v in (load, lift, *works)], axis=0)
    return side._replace(up=up, fall=lambda _: down, elastic=lift), rough


def of_path(path: hinge.Path, kappa: float, mode: str = "uniform") -> Side:
    """Return the branches of a solved path as splines; ``kappa`` is the bar's rigidity over K_theta d."""
    ends = f"{path.end} ({path.other})" if path.other else str(path.end)
    if not path.engaged:
        return APART if path.end is End.NONE and not path.other else Side(math.inf, path.load_end, ends)
    endless = path.end is End.FRICTIONAL and path.mu > 0
    paths = Paths.of(path.side, kappa, endless=endless)
    w = np.linspace(0.0, 1.0, int(SAMPLES * max(1.0, paths.reach[0])) + 1)[:, None] ** 1.5
    with np.errstate(all="ignore"):
        y, _, up, down, lift, free = (v[:, 0] for v in paths.contact(w))
    if mode != "uniform":
        ((_, side),) = sides(paths, mode)
        s = np.sqrt(w)
        with np.errstate(all="ignore"):
            up, down = ((v.slope(s) / v.rate(s) - v.load(s))[:, 0] for v in (side.up, side.falling(math.inf)))
        elastic: Any = side.elastic
        up[0] = down[0] = 0.0
        lift = elastic(s)[:, 0]
    back, fall = Branch(y, up), Branch(y[free], down[free])
    return Side(float(y[0]), float(y[-1]), ends, back, lambda _: fall, CubicSpline(y, lift), endless)

r"""Derivatives along a track of paths: complex step through the kernel, implicit function theorem at the end.

With the parameters moved by :math:`i h` (h = 1e-30) every analytic result carries h times its derivative in its
imaginary part, to all digits. Two places are not analytic. The end x_e is where a margin E vanishes, so

.. math::  \frac{\mathrm d x_e}{\mathrm d p} = -\frac{\partial E/\partial p}{\partial E/\partial x},

and the fold is where q^2 vanishes. The cut-off, the pole of the friction force and the nodes of the integral of the
frictional work move along with the end; so the integrand stays smooth in the integral's variable.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from squama.model import energy, mechanics
from squama.model.bending import Bend
from squama.model.follow import COINCIDE
from squama.model.neighbours import gap
from squama.model.outcome import CODES, SLID, End
from squama.model.paths import FoldedTwist, Ops, Point, by_tangent
from squama.model.reach import SEARCH
from squama.model.tracks import Track, take
from squama.types import Array

STEP = 1e-30
TOLERANCE = 1e-10
"""Last terms of the derivative's series, relative to its largest, below which it counts as converged."""
BLOCK = 256
"""Number of designs integrated together, so that they fit the processor's cache."""
_MARGINS = (End.KINEMATIC, End.FRICTIONAL, End.OFF_TIP, End.OFF_SIDE, End.RANGE, End.LINE)


def first_order(f: Callable[[Array], Array], slope: Callable[[Array, Array], Array]) -> Callable[[Array], Array]:
    """Return f(z) = f(x) + i y f'(x), exact for the tiny imaginary part STEP; ``slope`` takes x and f(x)."""

    def extended(z: Array) -> Array:
        if not np.iscomplexobj(z):
            return f(z)
        x = np.real(z)
        out = np.empty(np.shape(z), complex)
        out.real = value = f(x)
        out.imag = np.imag(z) * slope(x, value)
        return out

    return extended


_tan = first_order(np.tan, lambda _, t: 1 + t * t)
COMPLEX = Ops(
    first_order(np.sqrt, lambda _, r: 0.5 / r),
    first_order(np.sin, lambda x, _: np.cos(x)),
    first_order(np.cos, lambda x, _: -np.sin(x)),
    _tan,
    first_order(np.arctan, lambda x, _: 1 / (1 + x * x)),
    by_tangent(_tan),
)
"""Elementary functions of arrays with a complex step; several times faster than NumPy's complex functions."""
_log1p = first_order(np.log1p, lambda x, _: 1 / (1 + x))
_expm1 = first_order(np.expm1, lambda _, e: 1 + e)


class Seed(NamedTuple):
    """Parameters of a track, one moved by the complex step; ``on_path``: whether it changes forces along the path."""

    row: Any
    mu: Array
    margin: complex
    on_path: bool


class Moved(NamedTuple):
    """Results at the end and at the cut-off, with STEP times their derivative as imaginary part; see Solved."""

    load_e: Array
    theta_end: Array
    load_end: Array
    theta_c: Array
    load_c: Array
    f0: Array
    scales: Array
    W_fr: Array


class Tracked(NamedTuple):
    """Data common to all parameters: slopes along the path at the end, pole of the friction force, frictional work."""

    track: Track
    mu: Array
    margin: float
    law: str
    E_x: Array
    D_x: Array
    load_x: Array
    fixed: Array
    pole: Array
    work: Array


def seed(t: Tracked, name: str, sign: int) -> Seed:
    """Return a track's parameters with ``name`` moved by the complex step; ``sign`` is that of the sense of loading."""
    row: Any = t.track.row
    real, mu, margin, ih = row, t.mu, t.margin, STEP * 1j
    if name == "mu":
        return Seed(row, mu + ih, margin, on_path=True)
    if name not in ("alpha", *row._fields):
        return Seed(row, mu, margin + ih * (name == "margin"), on_path=False)
    if name == "alpha":
        row = row._replace(sa=row.sa + ih * sign * row.ca, ca=row.ca - ih * sign * row.sa)
    else:
        row = row._replace(**{name: getattr(row, name) + ih})
    if isinstance(row, FoldedTwist):
        q2_p = row.open.root(row.theta_f, COMPLEX).q2
        q2_x = real.open.root(row.theta_f + ih, COMPLEX).q2
        row = row._replace(theta_f=row.theta_f - 1j * np.imag(q2_p) * STEP / np.imag(q2_x))
    return Seed(row, mu, margin, on_path=True)


def tracked(t: Track, mu: Array, margin: float, law: str, work: Array) -> Tracked:
    """Return the data common to derivatives with respect to all parameters; ``work``: frictional, at the cut-off."""
    pt = t.row.point(t.x_end + STEP * 1j, law, COMPLEX)
    slope = np.imag(vanishing(t.row, pt, t, mu, law)) / STEP
    D = -(pt.M_N + mu * pt.M_f)
    fixed = (t.code == CODES.index(End.RANGE)) & (np.real(pt.turn) > COINCIDE)
    pole = energy.pole(t.row, t.x_end, mu, law, t.x0)
    return Tracked(t, mu, margin, law, slope, D.imag / STEP, np.real(pt.load_rate), fixed, pole, work)


def vanishing(row: Any, pt: Point, t: Track, mu: Array, law: str) -> Array:
    """Return the margin that ends each path, as an analytic function of the parameters and the path parameter."""
    D = -(pt.M_N + mu * pt.M_f)
    # at mu = 0 these two ends coincide where virtual work holds, and for mu > 0 friction locks first
    kinematic = np.where((np.real(mu) == 0) & (law == "edge" or isinstance(row, Bend)), D, pt.load_rate)
    E: Array = np.select(
        [t.code == CODES.index(e) for e in _MARGINS],
        [
            kinematic,
            D,
            getattr(row, "beta", 0) - np.sign(np.real(pt.p)) * pt.p,
            np.where(np.real(pt.s) * 2 < np.real(row.eta), pt.s, row.eta - pt.s),
            SEARCH - pt.load if isinstance(row, Bend) else pt.turn + 0j,
            pt.turn + 0j,
        ],
        1,
    ).astype(complex)
    other = np.flatnonzero(t.crossing)
    if other.size:
        pair = take(getattr(row, "open", row), other)
        E[other] = gap(pair, t.crossing[other].astype(float), pt.theta[other], pt.load[other], COMPLEX)
    return E


def move(t: Tracked, s: Seed, *, with_work: bool) -> Moved:
    """Return the results at the end and at the cut-off with their derivatives, for the parameter moved in ``s``."""
    track, row = t.track, s.row
    x_end, code = track.x_end, track.code
    x0 = row.parameter(row.theta0, COMPLEX) + 0j
    e: Array = getattr(row, "open", row).point(row.theta0, "edge", COMPLEX).load
    # the end: a margin vanishes, or the end is fixed, or tied to the beginning
    pt = row.point(x_end, t.law, COMPLEX)
    rate = -np.imag(vanishing(row, pt, track, s.mu, t.law)) / t.E_x
    rate = np.where(t.fixed, 0.0, rate)
    rate = np.where(code == CODES.index(End.RELEASED), -x0.imag, rate)
    at_start = x_end == track.x0
    x_e = x_end + 1j * rate
    theta_end = np.where(at_start, row.theta0, row.theta(x_e))
    load_end = np.where(at_start, e, pt.load + t.load_x * (x_e - x_end))
    # the pole moves with the end, or with the zero of D ahead
    D = -(pt.M_N + s.mu * pt.M_f)
    lag = (np.imag(D) + t.D_x * x_e.imag) / t.D_x
    near = (t.pole - x_end < x_end - track.x0) & np.isfinite(lag)
    pole = t.pole + 1j * (x_e.imag - np.where(near, lag, 0.0))
    x_c = energy.cutoff(row, x0, x_e, np.isin(code, SLID), s.margin)
    # a path that ends where it begins bears no load yet
    moved = np.real(x_c) > track.x0
    pt = row.point(x_c, t.law, COMPLEX)
    forces = mechanics.forces(pt, row.theta0, s.mu)
    if with_work and s.on_path:
        work = works(s, x0, x_c, pole, t.law, moved)
    else:
        # only the upper bound moves
        work = t.work + 1j * np.where(moved, np.real(forces.f * pt.slip_rate) * np.imag(x_c), 0.0)
    return Moved(
        e,
        theta_end,
        load_end,
        np.where(moved, pt.theta, row.theta0),
        np.where(moved, pt.load, e),
        np.where(moved, forces.f * row.eta, 0),
        np.where(moved, forces.torque, 0),
        work,
    )


def works(s: Seed, x0: Array, x_stop: Array, x_pole: Array, law: str, moved: Array) -> Array:
    """Return the frictional work with its derivative, by the series of :func:`squama.model.energy.work`."""
    out = np.zeros(x0.size, complex)
    left = np.flatnonzero(moved & ((np.real(s.mu) > 0) | (np.imag(s.mu) > 0)))
    n = energy.FEW_NODES
    while left.size and n <= energy.MOST_NODES:
        unit, integral = energy._rule(n)
        # the integral, and the last terms of its series
        rule = np.vstack([integral.sum(axis=0), integral[-4:]]).astype(complex)
        again = []
        for low in range(0, left.size, BLOCK):
            lanes = left[low : low + BLOCK]
            row, mu, start = take(s.row, lanes), s.mu[lanes], x0[lanes]
            reach = x_pole[lanes] - start
            y_end = -_log1p(-(x_stop[lanes] - start) / reach)
            short = -_expm1(-y_end * unit[:, None])
            pt = row.point(start + reach * short, law, COMPLEX)
            density = mechanics.forces(pt, row.theta0, mu).f * pt.slip_rate * (reach * (1 - short))
            c = rule @ density
            last = c[1:]
            rough = np.abs(last.real).max(axis=0) > energy.TOLERANCE * np.abs(c[0].real)
            rough |= np.abs(last.imag).max(axis=0) > TOLERANCE * np.abs(density.imag).mean(axis=0)
            out[lanes] = y_end * c[0]
            again.append(lanes[rough])
        left = np.concatenate(again)
        n *= 2
    return out

"""Least squares from several starts, and the covariance of what is found.

Residuals are measured over the largest torque, parameters over their start values. The model is linear in
the joint stiffness, the rigidity and the zero of the load cell: at every start these are
solved for first.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from squama import checks
from squama.identify.forward import Forward
from squama.identify.parameters import Asked
from squama.model.solve import Array

_NEAR_LOCK = 0.98
_SPREAD = (0.3, 0.6, 0.1, 0.8, 0.45, 0.93, 0.02)
_AGREE = 1e-6
_AT_BOUND = 1e-6
SINGULAR = 1e-9
"""Smallest singular value of the scaled derivatives, over the largest, below which parameters are one."""


class Estimate(NamedTuple):
    """Estimates, residuals (measured - model), sum of squares, derivatives; how many of the starts ended here."""

    values: Array
    residual: Array
    square: float
    jacobian: Array
    starts: int
    agreed: int
    at_bound: NDArray[np.bool_]


def solve(forward: Forward, torque: Array, asked: Asked, starts: int) -> Estimate:
    """Find the parameters with the least sum of squares within their bounds.

    Parameters
    ----------
    forward
        Points that are used, on their paths.
    torque
        Measured torque or moment there, N m.
    asked
        Parameters, start values, bounds.
    starts
        Number of starts, the beam's own values first.
    """
    from scipy.optimize import least_squares

    size = float(np.abs(torque).max())
    unit = np.array([size if row.name == "zero" else 1.0 for row in asked.rows])
    scale = np.where(asked.start == 0, unit, np.abs(asked.start))
    low, high = asked.low / scale, asked.high / scale

    def residual(u: Array) -> Array:
        return np.asarray((forward.torque(asked.physical(u * scale)) - torque) / size)

    def slope(u: Array) -> Array:
        return derivatives(forward, asked, u * scale) * scale / size

    found = []
    for start in _starts(forward, torque, asked, starts):
        inside = np.clip(start / scale, low + 1e-9 * (high - low), high - 1e-9 * (high - low))
        inside = np.where((start / scale > low) & (start / scale < high), start / scale, inside)
        fit = least_squares(
            residual, inside, slope, bounds=(low, high), x_scale="jac", ftol=1e-13, xtol=1e-13, gtol=1e-13, max_nfev=300
        )
        found.append((float(fit.cost), np.clip(fit.x, low, high)))
    found.sort(key=lambda pair: pair[0])
    best, u = found[0]
    agreed = sum(cost <= best * (1 + _AGREE) + 1e-28 for cost, _ in found)
    p = u * scale
    r = torque - forward.torque(asked.physical(p))
    near = (u - low < _AT_BOUND * np.maximum(np.abs(u), 1)) | (high - u < _AT_BOUND * np.maximum(np.abs(u), 1))
    return Estimate(p, r, float(r @ r), derivatives(forward, asked, p), len(found), agreed, near)


def derivatives(forward: Forward, asked: Asked, p: Array) -> Array:
    """Return the derivatives of the torque to the parameters, shape (points, parameters)."""
    return np.asarray(forward.jacobian(asked.physical(p)) @ asked.chain(p))


def _starts(forward: Forward, torque: Array, asked: Asked, number: int) -> list[Array]:
    """Return the starts of a search: the beam's own values, then others within the bounds and before every lock."""
    mu, theta0 = asked.place("mu"), asked.place("theta0")
    lock = forward.locks_at(asked.bound("theta0", 0))
    free = mu is not None or theta0 is not None
    found = []
    for n in range(number if free else 1):
        p = asked.start.copy()
        if n and mu is not None:
            top = min(asked.high[mu], lock, max(2.0, 2 * asked.low[mu]))
            p[mu] = asked.low[mu] + _SPREAD[(n - 1) % len(_SPREAD)] * max(top - asked.low[mu], 0.0)
        if n and theta0 is not None:
            share = _SPREAD[(3 * n) % len(_SPREAD)]
            p[theta0] = asked.low[theta0] + share * (asked.high[theta0] - asked.low[theta0])
        if mu is not None:
            p[mu] = max(min(p[mu], _NEAR_LOCK * lock), asked.low[mu])
        found.append(_solved_for_linear(forward, torque, asked, p))
    return found


def _solved_for_linear(forward: Forward, torque: Array, asked: Asked, start: Array) -> Array:
    """Return a start with those parameters solved for to which the torque is proportional, within their bounds."""
    linear = np.flatnonzero([row.linear for row in asked.rows])
    if {"C_f", "E_B"} <= set(asked.names):
        linear = np.array([i for i in linear if asked.names[i] != "C_f"])
    if not linear.size:
        return start
    J = derivatives(forward, asked, start)[:, linear]
    rest = forward.torque(asked.physical(start)) - J @ start[linear]
    norm = np.linalg.norm(J, axis=0)
    norm[norm == 0] = 1.0
    p = start.copy()
    p[linear] = np.linalg.lstsq(J / norm, torque - rest, rcond=None)[0] / norm
    # a value that the bounds forbid says nothing: keep the beam's own
    outside = (p <= asked.low) | (p >= asked.high)
    return np.where(outside, start, p)


def covariance(jacobian: Array, noise: float, names: tuple[str, ...]) -> Array:
    """Covariance of the estimates, from the derivatives and the standard deviation of a point.

    Raises
    ------
    InputError
        The derivatives leave parameters undetermined; one line that names them.
    """
    norm = np.linalg.norm(jacobian, axis=0)
    unseen = [n for n, size in zip(names, norm, strict=True) if not size > 0]
    if unseen:
        checks.fail(f"{' and '.join(unseen)}: the points do not depend on it; leave it out or measure where they do")
    _, s, vt = np.linalg.svd(jacobian / norm, full_matrices=False)
    if s[-1] < SINGULAR * s[0]:
        one = [n for n, v in zip(names, vt[-1], strict=True) if abs(v) > 0.1]
        checks.fail(f"{' and '.join(one)}: these points do not tell them apart; find fewer of them")
    half = vt.T / s
    inner = half @ half.T / np.outer(norm, norm)
    return np.asarray(noise**2 * inner)

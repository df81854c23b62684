"""Least squares from several starts, errors of the estimates, and further measurements that would reduce them.

Residuals are divided by the largest torque, parameters by their start values. The model is linear in the joint
stiffness, the rigidity and the zero of the load cell: every start solves for these first. The model, linearised at the
estimates, gives the covariance of the parameters, also with points that are not measured yet.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from squama.curves import hinge_cycles
from squama.curves.hinge_cycles import Senses
from squama.errors import refuse
from squama.identify.hinge_points import Forward, Hinged, build
from squama.identify.joint_points import Walked
from squama.identify.unknowns import Asked, ask
from squama.loads import TESTS
from squama.model.outcome import End
from squama.model.paths import ARRAY
from squama.people import per_pitch
from squama.progress import steps
from squama.types import Array

_NEAR_LOCK = 0.98
_SPREAD = (0.3, 0.6, 0.1, 0.8, 0.45, 0.93, 0.02)
_AGREE = 1e-4
_ROUGH, _BEGIN = 1e-6, 1e-3
"""Accuracy of robust searches, and of those that only begin another one."""
_AT_BOUND = 1e-6
EDGE = 1e-4
"""Accuracy of the least friction at which scales stick all along."""
SINGULAR = 1e-9
"""Smallest singular value of the scaled derivatives, over the largest, below which parameters are inseparable."""
HARDLY = 0.95
"""Correlation above which two parameters are called hardly separable."""
UNSEEN = 0.5
"""Standard error over the estimate above which a parameter is called not determined."""
FEW = 0.2
"""Share of the points below which more of a kind are proposed."""
FAR = 0.5
"""Distance of the proposed points, as a share of the way from the farthest point to the end of the path."""


Points = Hinged | Walked


class Estimate(NamedTuple):
    """Estimates, residuals (measured - model, N m), sum of squares, derivatives; starts, and how many ended here."""

    values: Array
    residual: Array
    square: float
    jacobian: Array
    starts: int
    agreed: int
    at_bound: NDArray[np.bool_]


def solve(
    points: Points, torque: Array, asked: Asked, starts: Sequence[Array], robust: float | None = None, most: int = 300
) -> Estimate:
    """Find the least squares of torques (N m) within the bounds; residuals over ``robust`` (N m) count linearly."""
    from scipy.optimize import least_squares

    size = float(np.abs(torque).max())
    units = {"N m": size, "rad": 0.01, "rad/(N m)": 0.01 / size}
    far = float(np.abs(points.readings.load).max())
    units |= {"N": size, "m": 0.01 * far, "m/N": 0.01 * far / size}
    unit = [units.get(row.unit, 1.0) for row in asked.rows]
    scale = np.where(asked.start == 0, unit, np.abs(asked.start))
    low, high = asked.low / scale, asked.high / scale

    def residual(u: Array) -> Array:
        return np.concatenate([modelled(points, asked, u * scale) - torque, -asked.pull(u * scale)]) / size

    def slope(u: Array) -> Array:
        return np.concatenate([derivatives(points, asked, u * scale), asked.pull_slope]) * scale / size

    still = 1e-13 if isinstance(points, Hinged) else 1e-8
    how: dict[str, Any] = {"bounds": (low, high), "x_scale": "jac", "max_nfev": most}
    if robust is not None:
        still = max(still, _ROUGH)
        how |= {"loss": "soft_l1", "f_scale": robust / size, "max_nfev": min(most, 60)}
    alike = _AGREE
    if isinstance(points, Walked) and points.rough:
        still = alike = _BEGIN
    how |= dict.fromkeys(("ftol", "xtol", "gtol"), still)
    found = []
    for start in steps(starts, len(starts), "starts of the fit"):
        inside = np.clip(start / scale, low + 1e-9 * (high - low), high - 1e-9 * (high - low))
        inside = np.where((start / scale > low) & (start / scale < high), start / scale, inside)
        fit = least_squares(residual, inside, slope, **how)
        found.append((float(fit.cost), np.clip(fit.x, low, high)))
    best, u = min(found, key=lambda pair: pair[0])
    agreed = sum(cost <= best * (1 + alike) + 1e-28 for cost, _ in found)
    near = (u - low < _AT_BOUND * np.maximum(np.abs(u), 1)) | (high - u < _AT_BOUND * np.maximum(np.abs(u), 1))
    return _at(points, torque, asked, u * scale, near)._replace(starts=len(found), agreed=agreed)


def _at(points: Points, torque: Array, asked: Asked, p: Array, near: NDArray[np.bool_]) -> Estimate:
    """Return the estimate with values ``p`` of the parameters, as if from one start; ``near``: which are at a bound."""
    r = torque - modelled(points, asked, p)
    return Estimate(p, r, float(r @ r), derivatives(points, asked, p), 1, 1, near)


def sliding(points: Points, torque: Array, asked: Asked, best: Estimate) -> Estimate:
    """Return the least squares where scales slide, for an estimate whose friction makes them stick all along."""
    mu = asked.place("mu")
    if mu is None or best.jacobian[:, mu].any():
        return best
    # above some friction the torque no longer depends on it: the search goes on from the least such friction, and
    # where it returns there, the estimate is that friction, marked as a bound
    again = solve(points, torque, asked, [_sticking(points, asked, best.values, mu)])
    if again.jacobian[:, mu].any() and again.square < best.square:
        return again
    near = again.at_bound.copy()
    near[mu] = True
    return _at(points, torque, asked, _sticking(points, asked, again.values, mu), near)


def _sticking(points: Points, asked: Asked, p: Array, mu: int) -> Array:
    """Return the values with the least friction at which scales stick all along: the torque does not depend on it."""
    at, low, high = p.copy(), float(asked.low[mu]), float(p[mu])
    stuck = points.torque(asked.physical(p))
    while high - low > EDGE:
        at[mu] = (low + high) / 2
        same = np.allclose(points.torque(asked.physical(at)), stuck, rtol=0, atol=1e-9 * float(np.abs(stuck).max()))
        low, high = (low, at[mu]) if same else (at[mu], high)
    at[mu] = low
    return at


def _groups(points: Points, asked: Asked) -> list[tuple[int | None, NDArray[np.bool_]]]:
    """Return the groups with parameters of their own (None: all points), and the masks of their points."""
    if not asked.groups:
        return [(None, np.ones(points.index.size, bool))]
    number = points.readings.groups[points.index]
    return [(g, number == g) for g in range(len(asked.groups))]


def shifts(points: Points, asked: Asked) -> dict[int, tuple[float, Array]]:
    """Return, by place, the values of dimensions with a tolerance, and the torque's derivatives there (points,)."""
    known = [(i, points.readings.shifts[name]) for i, name in enumerate(asked.names) if name in points.readings.shifts]
    return {i: (value, shift[points.index]) for i, (value, shift) in known}


def modelled(points: Points, asked: Asked, p: Array) -> Array:
    """Return the torque of the model at the points (N m) for values p of the parameters."""
    out = np.zeros(points.index.size)
    for group, own in _groups(points, asked):
        out[own] = points.of(group).torque(asked.physical(p, group))[own]
    for i, (value, shift) in shifts(points, asked).items():
        out += shift * (p[i] - value)
    return out


def derivatives(points: Points, asked: Asked, p: Array) -> Array:
    """Return the derivatives of the torque by the parameters, shape (points, parameters)."""
    out = np.zeros((points.index.size, p.size))
    for group, own in _groups(points, asked):
        chain = asked.chain(p, group)
        found = points.of(group).jacobian(asked.physical(p, group), np.asarray(chain.any(axis=1))) @ chain
        out[own] = found[own]
    for i, (_, shift) in shifts(points, asked).items():
        out[:, i] = shift
    return out


def standard_error(points: Points, asked: Asked, p: Array, covariance: Array) -> Array:
    """Return the standard error of the torque (N m) at the points for a covariance of the estimates p."""
    J = derivatives(points, asked, p)
    return np.asarray(np.sqrt(np.maximum(np.einsum("ij,jk,ik->i", J, covariance, J), 0.0)))


def starts(points: Points, torque: Array, asked: Asked, number: int) -> list[Array]:
    """Return ``number`` starts of a search: the beam's own values, then others within bounds and before every lock."""
    mu, theta0 = asked.place("mu"), asked.place("theta0")
    least = asked.physical(asked.start)._replace(theta0=asked.bound("theta0", 0))
    lock = points.locks_at(least)
    found = []
    for n in range(1 if mu is None and theta0 is None else number):
        p = asked.start.copy()
        if n and mu is not None:
            top = min(asked.high[mu], lock, max(2.0, 2 * asked.low[mu]))
            p[mu] = asked.low[mu] + _SPREAD[(n - 1) % len(_SPREAD)] * max(top - asked.low[mu], 0.0)
        if n and theta0 is not None:
            share = _SPREAD[(3 * n) % len(_SPREAD)]
            p[theta0] = asked.low[theta0] + share * (asked.high[theta0] - asked.low[theta0])
        if mu is not None:
            p[mu] = max(min(p[mu], _NEAR_LOCK * lock), asked.low[mu])
        found.append(_solved_for_linear(points, torque, asked, p))
    return found


def _solved_for_linear(points: Points, torque: Array, asked: Asked, start: Array) -> Array:
    """Return a start with the linear parameters solved for, within their bounds."""
    # of two factors of the rigidity one
    fixed = "C_f" if "E_B" in asked.names else ""
    linear = np.flatnonzero([row.linear and row.name != fixed for row in asked.rows])
    if not linear.size:
        return start
    J = derivatives(points, asked, start)[:, linear]
    rest = modelled(points, asked, start) - J @ start[linear]
    norm = np.linalg.norm(J, axis=0)
    norm[norm == 0] = 1.0
    p = start.copy()
    p[linear] = np.linalg.lstsq(J / norm, torque - rest, rcond=None)[0] / norm
    # keep the beam's own value where the solution lies outside the bounds
    return np.where((p <= asked.low) | (p >= asked.high), start, p)


def covariance(jacobian: Array, noise: float, names: tuple[str, ...]) -> Array:
    """Return the covariance of the estimates for the noise of a point (N m); refuse undetermined parameters."""
    norm = np.linalg.norm(jacobian, axis=0)
    unseen = [n for n, size in zip(names, norm, strict=True) if not size > 0]
    if unseen:
        refuse(" and ".join(unseen), "", "the points do not depend on it", "leave it out or measure where they do")
    _, s, vt = np.linalg.svd(jacobian / norm, full_matrices=False)
    if s[-1] < SINGULAR * s[0]:
        one = [n for n, v in zip(names, vt[-1], strict=True) if abs(v) > 0.1]
        refuse(" and ".join(one), "", "these points do not tell them apart", "find fewer of them")
    half = vt.T / s
    return np.asarray(noise**2 * (half @ half.T / np.outer(norm, norm)))


def hardly_separable(names: Sequence[str], covariance: Array) -> list[tuple[str, str, float]]:
    """Return pairs of parameters of which a change of one is made up for by the other, with their correlations."""
    errors = np.sqrt(np.diag(covariance))
    correlation = covariance / np.outer(errors, errors)
    pairs = itertools.combinations(range(len(names)), 2)
    every = [(names[i], names[j], float(correlation[i, j])) for i, j in pairs]
    return [pair for pair in every if abs(pair[2]) > HARDLY]


class Remedy(NamedTuple):
    """A further measurement in words, and the expected standard errors with it, in the order of the parameters."""

    what: str
    errors: Array


def remedies(
    asked: Asked, values: Array, senses: Senses, forward: Forward, jacobian: Array, noise: float
) -> list[Remedy]:
    """Return further measurements without the nuisances of this test (``forward``, ``jacobian``), with their errors."""
    found = []
    with np.errstate(all="ignore"):
        for what, more in _further(asked, values, senses, forward):
            J = np.concatenate([jacobian, more])
            norm = np.linalg.norm(J, axis=0)
            half = np.linalg.pinv(J / norm)
            found.append(Remedy(what, noise * np.linalg.norm(half, axis=1) / norm))
    return found


def _further(asked: Asked, values: Array, senses: Senses, forward: Forward) -> Iterator[tuple[str, Array]]:
    """Yield further measurements in words, each with the derivatives of its torques by the parameters."""
    at, chain = asked.physical(values), asked.chain(values)[:4]
    touching = forward.theta > at.theta0
    loaded, back = touching & (forward.way > 0), touching & (forward.way < 0)
    for one, other, seen, missing in ((loaded, back, "loading", "unloading"), (back, loaded, "unloading", "loading")):
        if one.any() and np.count_nonzero(other) < FEW * np.count_nonzero(one):
            turned = forward.take(np.flatnonzero(one))
            turned = turned._replace(way=-turned.way)
            yield f"{missing} measured too, at the twists of the {seen}", turned.jacobian(at) @ chain
    n = max(int(np.count_nonzero(loaded)), 10)
    sign = "-" if touching.any() and np.all(forward.sign[touching] < 0) else "+"
    path, s = senses.paths[sign], -1.0 if sign == "-" else 1.0
    far = float(np.abs(forward.rate).max()) * senses.case.pitch
    end = max(far, path.load_e)
    end += FAR * (senses.most[sign] - end)
    if np.isfinite(path.load_e) and np.count_nonzero(~touching) < FEW * forward.rate.size:
        straight = build(senses, s * np.linspace(0, path.load_e, n), np.ones(n))
        yield f"{n} points before engagement", straight.jacobian(at) @ chain
    if np.isfinite(path.load_e) and path.end is not End.NONE and end > 1.02 * far:
        beyond = build(senses, s * np.linspace(max(far, path.load_e), end, n + 1)[1:], np.ones(n))
        yield f"{n} points more of loading, up to {per_pitch(end)}", beyond.jacobian(at) @ chain
    if TESTS[asked.load].sided and touching.any():
        yield from _bending(asked, values, forward, n)


def _bending(asked: Asked, values: Array, forward: Forward, n: int) -> Iterator[tuple[str, Array]]:
    """Yield a bending test up to the largest inclination of these points, with the same share of noise."""
    at = asked.physical(values)
    bent = ask(asked.fitted(values), "bending", asked.names)
    senses = hinge_cycles.senses(bent.beam, "bending", at.mu, "edge", 0.1)
    path = senses.paths["+"]
    if not path.engaged:
        return
    theta = min(float(forward.theta.max()), path.theta_end)
    last = min(float(path.row.point(np.array([theta]), path.law, ARRAY).load[0]), senses.most["+"])
    if last <= path.load_e:
        return
    points = build(senses, np.linspace(path.load_e, last, n), np.ones(n))
    J = np.asarray(points.jacobian(bent.physical(values)) @ bent.chain(values)[:4])
    J[:, [name in ("C_f", "E_B") for name in asked.names]] = 0.0
    largest = np.abs(forward.torque(at)).max() / np.abs(points.torque(bent.physical(values))).max()
    yield f"a bending test too, {n} points of loading up to {per_pitch(last, 4)}", J * largest

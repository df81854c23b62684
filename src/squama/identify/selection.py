"""The search of a fit: first robust, then without stray points, with the nuisances that the residual shows.

Schwarz's criterion (BIC) selects the nuisances: all of them are found at once, with their covariance C. Without some of
them, p, the sum of squares over the noise would grow by p^T C_pp^-1 p. The selection with the least growth plus ln(n)
per kept nuisance is taken. A nuisance of at least half its error is kept too where leaving it out would move a
parameter by more than half its error: the points would hardly show it, and a narrow interval would not hold.

The other selections are not excluded. With the growth g and k nuisances a selection has the weight w ~ exp(-(g + k ln
n)/2) (Hoeting et al., Statist. Sci. 14 (1999) 382). With the distance D of its estimates from those of the kept
selection, sum w (C + D D^T) is the second moment of all. The covariance is that of the kept selection, widened to this
moment in every direction in which the moment is larger.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from squama.curves.chosen import idealisation
from squama.errors import InputError, refuse
from squama.identify import estimate, noise
from squama.identify.estimate import Estimate, Points
from squama.identify.estimated import Estimated
from squama.identify.hinge_points import Physical
from squama.identify.joint_points import Linear, Walked
from squama.identify.prepare import Prepared
from squama.identify.unknowns import OF_TWIST, Asked, Parameter
from squama.loads import HELD
from squama.types import Array

_EXACT = (1e-9, 1e-5)
"""Residuals over the largest torque that count as rounding: on hinges, and on compliant joints."""
_ALIKE = 1e-4
"""Least share of a nuisance's derivatives, independent of the others, for which it is considered."""
_SHARE = 0.05
"""Largest value of an added nuisance, over the range of the measured quantity."""
_SEEN = 0.5
"""Least nuisance, over its error, that is kept because the parameters would move without it."""
_TURNING = 0.01
"""Distance after a reversal within which points are left out of a fit of backlash, over the range of the twist."""
_MOVES = 0.5
"""Least such move of a parameter, over its error."""
_GLANCE = 12
"""Number of evaluations of the short search that compares a model with the fit."""
_ROBUST, _FLOOR = 3.0, 1e-3
"""Residuals above which the first search counts linearly: over the noise, and at least over the largest torque; smaller
residuals are no stray points either.
"""
_SHARES, _NEAR = 3, 1e-2
"""Largest number of computations of the finite beam's share; change of the share that calls for another one."""
_NOISELESS, _WEIGHT = 1e-6, 0.1
"""Least noise of a point against which a prior counts, over the largest torque; change that ends the rounds."""
_ROUNDS, _STAYS, _SMALL, _HALVES = 10, 0.02, 2.0, 6
"""Largest number of linearisations; move over its error that ends them; move below which derivatives are kept; halvings
of a step.
"""


@dataclass(frozen=True, repr=False, eq=False)
class Found(Estimated):
    """Estimates of a search, with its points and statistics.

    ``noise`` of a point (N m); ``dependence``: tau; ``uneven``: whether the noise grows with the slope; ``used``: mask
    without the ``stray`` points; ``square``: sum of squares of the residuals; ``starts``: number that agreed, and of
    all; ``added``: nuisances that were added.
    """

    asked: Asked
    points: Points
    estimates: Array
    covariance: Array
    jacobian: Array
    square: float
    noise: float
    dependence: float
    uneven: bool
    used: NDArray[np.bool_]
    stray: NDArray[np.bool_]
    at_bound: NDArray[np.bool_]
    starts: tuple[int, int]
    added: tuple[str, ...]

    @property
    def rows(self) -> tuple[Parameter, ...]:
        """The parameters that were found."""
        return self.asked.rows

    @property
    def rms(self) -> float:
        """Root mean square of the residuals of the points that are used, N m."""
        return math.sqrt(self.square / np.count_nonzero(self.used))


class Rival(NamedTuple):
    """The other model fitted to the same points: its ``joint`` and fit, or None with the ``problem``."""

    joint: str
    found: Found | None
    problem: str

    @property
    def words(self) -> str:
        """The model in words."""
        assert self.found is not None
        return f"{idealisation(self.found.asked.beam, self.joint, ideal=self.joint == 'hinge')} on {HELD[self.joint]}"


def find(test: Prepared, starts: int, candidates: tuple[str, ...]) -> Found:
    """Find the parameters, from ``starts`` starts, and those candidate nuisances that the residual shows."""
    if isinstance(test.points, Walked) and test.points.finite:
        return _find_with_ends(test, test.points, starts, candidates)
    test = fit_for(test, test.asked.names)
    rough, out = robust(test, started(test, starts))
    return chosen(test, rough, out, candidates)


def chosen(test: Prepared, rough: Estimate, out: NDArray[np.bool_], candidates: tuple[str, ...]) -> Found:
    """Return the least squares after a robust search, without the stray points ``out``, with added nuisances."""
    asked, (index, _, torque, _) = test.asked, test.used
    stray = np.zeros(test.usable.size, bool)
    stray[index[out]] = True
    left = test._replace(usable=test.usable & ~stray)
    full = _with(left, rough.values, tuple(n for n in candidates if n not in asked.names))
    best = settle(left, rough.values)
    added: tuple[str, ...] = ()
    if full is not None and best.square > rounding(test, torque):
        wanted, start = full
        try:
            whole = settle(fit_for(left, wanted.names)._replace(asked=wanted), start)
            kept, apart = _needed(whole, asked)
        except InputError:
            # the points cannot separate all nuisances at once
            kept, apart = (), np.zeros_like(best.covariance)
        if kept:
            some = wanted.without({n for n in wanted.names if n not in (*asked.names, *kept)})
            values = [whole.values[n] for n in some.names]
            best, added = settle(fit_for(left, kept)._replace(asked=some), np.array(values)), kept
        best = replace(best, covariance=best.covariance + apart)
    return replace(best, starts=(rough.agreed, rough.starts), stray=stray, added=added)


def comes_near(test: Prepared, added: tuple[str, ...], rms: float) -> bool:
    """Return whether a short search from the beam's own values leaves at most ``rms`` (N m), with nuisances added."""
    test = fit_for(test, test.asked.names)
    rough, out = robust(test, started(test, 1), _GLANCE)
    square = float(np.mean(rough.residual[~out] ** 2))
    full = _with(test, rough.values, tuple(n for n in added if n not in test.asked.names)) if added else None
    if full is not None and square > rms * rms:
        index, points, torque, _ = fit_for(test, full[0].names).used
        square = estimate.solve(points, torque, full[0], [full[1]], most=_GLANCE).square / index.size
    return math.sqrt(square) <= rms


def started(test: Prepared, number: int) -> list[Array]:
    """Return ``number`` starts of a search."""
    _, points, torque, _ = test.used
    return estimate.starts(points, torque, test.asked, number)


def robust(test: Prepared, starts: Sequence[Array], most: int = 300) -> tuple[Estimate, NDArray[np.bool_]]:
    """Return the estimate of a robust search from its starts, and the mask of stray points."""
    _, points, torque, way = test.used
    size = float(np.abs(torque).max())
    limit = max(_ROBUST * noise.scatter(torque, way), _FLOOR * size)
    rough = estimate.solve(points, torque, test.asked, starts, limit, most)
    return rough, noise.strays(rough.residual, way, _FLOOR * size)


def fit_for(test: Prepared, names: Collection[str]) -> Prepared:
    """Return the test without points at reversals, where the torque jumps, if backlash is to be found."""
    if "backlash" not in names:
        return test
    return test._replace(usable=test.usable & ~test.points.readings.turning(_TURNING))


def rounding(test: Prepared, torque: Array) -> float:
    """Return the sum of squares of residuals that are rounding, (N m)^2."""
    return (_EXACT[isinstance(test.points, Walked)] * float(np.abs(torque).max())) ** 2 * torque.size


def settle(test: Prepared, start: Array) -> Found:
    """Find the least squares from a start, with the covariance that suits the residual."""
    asked, best, sigma, tau = _weighed(test, start)
    _, points, torque, _ = test.used
    s, skew = asked.weight or sigma * math.sqrt(tau), False
    J = np.concatenate([best.jacobian, asked.pull_slope])
    covariance = estimate.covariance(J, s, asked.names)
    if best.square > rounding(test, torque):
        wanted = np.array([name == "twist_zero" for name in Physical._fields])
        slope = points.jacobian(asked.physical(best.values), wanted)[:, 5]
        skew = test.noise is None and noise.uneven(best.residual, slope)
    if skew:
        # the priors keep their own noise
        own = covariance / asked.known[1]
        covariance = tau * noise.sandwich(best.jacobian, best.residual, covariance / s**2) + own @ own.T
    if not all(np.isfinite(values).all() for values in (best.values, covariance, sigma)):
        refuse("data", "", "the estimates or their errors are no finite numbers", "check the units of twist and torque")
    return Found(
        asked=asked,
        points=test.points,
        estimates=best.values,
        covariance=covariance,
        jacobian=J,
        square=best.square,
        noise=sigma,
        dependence=tau,
        uneven=skew,
        used=test.usable,
        stray=np.zeros_like(test.usable),
        at_bound=best.at_bound,
        starts=(best.agreed, best.starts),
        added=(),
    )


def _weighed(test: Prepared, start: Array) -> tuple[Asked, Estimate, float, float]:
    """Return the parameters with priors weighted by the noise, the least squares, the noise (N m), and tau."""
    asked, (index, points, torque, way) = test.asked, test.used
    least = _NOISELESS * float(np.abs(torque).max())
    for _ in range(_ROUNDS):
        best = estimate.sliding(points, torque, asked, estimate.solve(points, torque, asked, [start]))
        sigma = math.sqrt(best.square / (index.size - len(asked.rows))) if test.noise is None else test.noise
        tau = noise.dependence(best.residual, way) if best.square > rounding(test, torque) else 1.0
        if not set(asked.names) & set(asked.priors):
            return asked._replace(weight=0.0), best, sigma, tau
        before, start = asked.weight, best.values
        asked = asked._replace(weight=max(sigma * math.sqrt(tau), least))
        if abs(asked.weight / before - 1) < _WEIGHT:
            break
    return asked, best, sigma, tau


def _with(test: Prepared, values: Array, names: tuple[str, ...]) -> tuple[Asked, Array] | None:
    """Return the parameters with the nuisances that the points can show, and a start; None without such nuisances."""
    asked, (index, points, torque, _) = test.asked, test.used
    if index.size < 10 * (len(asked.rows) + len(names)):
        return None
    twists, readings = test.points.readings.load[index], test.points.readings
    reach = dict.fromkeys(OF_TWIST, float(np.ptp(twists)) * readings.scales)
    reach |= dict.fromkeys(("torque_zero", "drift"), float(np.ptp(torque)))
    limits = {n: ((0.0 if n == "backlash" else -_SHARE * reach[n]), _SHARE * reach[n]) for n in names}
    wanted = asked.more(names, limits)
    start = np.concatenate([values, np.zeros(len(names))])
    J = estimate.derivatives(points, wanted, start)
    while len(wanted.rows) > len(asked.rows):
        free = _own(J)
        own = len(asked.rows) + int(np.argmin(free[len(asked.rows) :]))
        if free[own] > _ALIKE:
            return wanted, start
        wanted = wanted.without({wanted.names[own]})
        J, start = np.delete(J, own, axis=1), np.delete(start, own)
    return None


def _own(J: Array) -> Array:
    """Return the share of each column's square that is independent of the other columns."""
    norm = np.linalg.norm(J, axis=0)
    unit, left = J / np.where(norm > 0, norm, 1.0), []
    for i, column in enumerate(unit.T):
        others = np.delete(unit, i, axis=1)
        left.append(float(np.sum((column - others @ np.linalg.lstsq(others, column, rcond=None)[0]) ** 2)))
    return np.array(left)


class _Selection(NamedTuple):
    """Estimates and covariance with some of the nuisances (the others 0), and their cost by Schwarz's criterion."""

    values: Array
    covariance: Array
    cost: float


def _selections(whole: Found, own: int) -> dict[frozenset[int], _Selection]:
    """Return all selections of the nuisances by their places; the first ``own`` parameters are always kept."""
    p, C, n = whole.estimates, whole.covariance, np.count_nonzero(whole.used)
    every = np.arange(own, p.size)
    free = [i for i in every.tolist() if not whole.at_bound[i]]
    found = {}
    for kept in (kept for size in range(len(free) + 1) for kept in itertools.combinations(free, size)):
        out = [i for i in every if i not in kept]
        share = np.linalg.solve(C[np.ix_(out, out)], C[out]).T
        grown = float(p[out] @ np.linalg.solve(C[np.ix_(out, out)], p[out]))
        cost = grown + math.log(n) * len(kept)
        found[frozenset(kept)] = _Selection(p - share @ p[out], C - share @ C[out], cost)
    return found


def _needed(whole: Found, asked: Asked) -> tuple[tuple[str, ...], Array]:
    """Return the nuisances that are kept, and the covariance that the other selections add."""
    from scipy.linalg import eigh

    own = len(asked.names)
    found = _selections(whole, own)
    kept = min(found, key=lambda one: found[one].cost)
    while True:
        moves: dict[frozenset[int], float] = {}
        errors = np.sqrt(np.diag(found[kept].covariance)[:own])
        for more in (one for one in found if kept < one and len(one) == len(kept) + 1):
            (i,), (p, C, _) = more - kept, found[more]
            if p[i] ** 2 > _SEEN**2 * C[i, i]:
                moves[more] = float(np.max(np.abs(p - found[kept].values)[:own] / errors))
        if not moves or max(moves.values()) < _MOVES:
            break
        kept = max(moves, key=moves.__getitem__)
    costs = np.array([one.cost for one in found.values()])
    weights = np.exp((costs.min() - costs) / 2)
    moment = np.zeros_like(whole.covariance)
    for one, weight in zip(found.values(), weights / weights.sum(), strict=True):
        distance = one.values - found[kept].values
        moment += weight * (one.covariance + np.outer(distance, distance))
    rows = np.ix_(*2 * [[*range(own), *sorted(kept)]])
    here = found[kept].covariance[rows]
    larger, directions = eigh(moment[rows], here)
    half = here @ directions * np.sqrt(np.maximum(larger - 1, 0.0))
    return tuple(whole.asked.names[i] for i in sorted(kept)), half @ half.T


def _find_with_ends(test: Prepared, own: Walked, starts: int, candidates: tuple[str, ...]) -> Found:
    """Find the parameters as :func:`find` does, for a beam with a number of scales and ends.

    The search begins with the torque of the endless beam times the share of the finite beam. Then the torque is
    linearised about the estimate until this converges: Gauss-Newton steps, halved where a full step increases the
    residual; small steps keep the derivatives.
    """
    test = fit_for(test, test.asked.names)
    before = own.shared(own.start)
    # with linear forces all starts find the same
    starts = 1 if isinstance(before, Linear) else starts
    near = test._replace(points=before)
    rough, out = robust(near, started(near, starts))
    agreed, places = rough.agreed, [test.asked.start]
    for _ in range(_SHARES):
        places.append(rough.values)
        try:
            points = own.shared(test.asked.physical(rough.values))
        except InputError:
            # the finite beam cannot follow the record
            break
        rough, out = robust(test._replace(points=points), [rough.values])
        if np.abs(points.share / before.share - 1).max() < _NEAR:
            break
        before = points
    # the endless beam may lead away from the beam's own values where it does not show a parameter
    values = min([*places, rough.values], key=lambda p: _left(test, test.asked.physical(p), test.usable))
    v, place, columns = test.asked.physical(values), test.asked.place("mu"), dict[str, Array]()
    found: Found | None = None
    for _ in range(_ROUNDS):
        try:
            linear = Linear(own, v, columns)
        except InputError:
            v = own.start
            continue
        if place is not None and not linear.jacobian(v, np.arange(len(v)) == 0).any():
            # scales stick all along: the torque is not linear in the friction
            break
        near = test._replace(points=linear)
        rough, out = robust(near, [values])
        values = rough.values
        found = chosen(near, rough, out, candidates)
        goal = found.asked.physical(found.estimates)
        if (move := _move(found, v, goal)) < _STAYS:
            return replace(found, starts=(agreed, starts))
        nearer = _nearer(test, found, v, goal)
        if nearer is None:
            break
        v, columns = nearer, linear.columns if move < _SMALL else {}
    else:
        if found is not None:
            # two selections of nuisances alternate, within the errors
            return replace(found, starts=(agreed, starts))
    rough, out = robust(test, [values])
    return replace(chosen(test, rough, out, candidates), starts=(agreed, starts))


def _left(test: Prepared, at: Physical, used: NDArray[np.bool_]) -> float:
    """Return the sum of squares of the residuals of the full model, (N m)^2."""
    return float(np.sum((test.points.torque(at) - test.record.torque)[used] ** 2))


def _nearer(test: Prepared, found: Found, v: Physical, goal: Physical) -> Physical | None:
    """Return ``goal``, or a point on the way to it, where the residual does not grow; None if there is none."""
    # (with a slack of a tenth of the noise of a point)
    most = max(_left(test, v, found.used), found.square) * (1 + 0.1 / np.count_nonzero(found.used))
    for _ in range(_HALVES):
        if _left(test, goal, found.used) <= most:
            return goal
        goal = Physical(*((a + b) / 2 for a, b in zip(v, goal, strict=True)))
    return None


def _move(found: Found, v: Physical, goal: Physical) -> float:
    """Return the largest move from v to goal over the errors of the estimates."""
    chain = found.asked.chain(found.estimates)
    errors = np.sqrt(np.einsum("ij,jk,ik->i", chain, found.covariance, chain))
    return float(np.max(np.abs(np.subtract(goal, v)) / np.where(errors > 0, errors, np.inf), initial=0.0))

"""The search of a fit on a beam of a number of scales with its ends, whose walks take some hundred times as long.

The search begins on the endless beam, whose torque is taken times the share that the scales have of it, reading by
reading: the share is found at an estimate, kept while that is refined, and found anew. From there on the torque of the
scales themselves is linear about the estimate, until that stays: Gauss and Newton's method, with halved steps where a
whole one makes the residual larger, and derivatives that are kept on a small one. Estimates, derivatives and residuals
are those of the scales.
"""

from __future__ import annotations

import numpy as np

from squama.errors import InputError
from squama.identify import selection
from squama.identify.hinge_points import Physical
from squama.identify.joint_points import Linear, Walked
from squama.identify.prepare import Prepared
from squama.identify.selection import Found
from squama.types import Array

SHARES, NEAR = 3, 1e-2
"""How often a share is found at most, and the change of it from which on that is done once more."""
ROUNDS, STAYS, SMALL = 10, 0.02, 0.5
"""How often the torque is linearised at most, and moves of an estimate, over its error, that are none and small."""
HALVES = 6


def find(test: Prepared, starts: int, candidates: tuple[str, ...]) -> Found:
    """Find the parameters as :func:`squama.identify.selection.find` does, on a beam's own scales where it has ends."""
    own = test.points
    if not (isinstance(own, Walked) and own.kind is not None):
        return selection.find(test, starts, candidates)
    test = selection.fit_for(test, test.asked.names)
    before = own.shared(own.start)
    near = test._replace(points=before)
    rough, out = selection.robust(near, selection.started(near, starts))
    agreed = rough.agreed
    for _ in range(SHARES):
        try:
            points = own.shared(test.asked.physical(rough.values))
        except InputError:
            # the scales do not follow what the endless beam does
            break
        rough, out = selection.robust(test._replace(points=points), [rough.values])
        if np.abs(points.share / before.share - 1).max() < NEAR:
            break
        before = points
    v, place, columns = test.asked.physical(rough.values), test.asked.place("mu"), dict[str, Array]()
    found: Found | None = None
    for _ in range(ROUNDS):
        try:
            linear = Linear(own, v, columns)
        except InputError:
            v = own.start
            continue
        if place is not None and not linear.jacobian(v, np.arange(len(v)) == 0).any():
            # scales stick all along: their torque is not linear in the friction
            break
        near = test._replace(points=linear)
        rough, out = selection.robust(near, [rough.values])
        found = selection.chosen(near, rough, out, candidates)
        goal = found.asked.physical(found.best.values)
        if (move := _move(found, v, goal)) < STAYS:
            return _told(found, starts, agreed)
        nearer = _nearer(test, found, v, goal)
        if nearer is None:
            break
        v, columns = nearer, linear.columns if move < SMALL else {}
    else:
        if found is not None:
            # two selections of nuisances follow each other, within the errors
            return _told(found, starts, agreed)
    rough, out = selection.robust(test, [rough.values])
    return _told(selection.chosen(test, rough, out, candidates), starts, agreed)


def _told(found: Found, starts: int, agreed: int) -> Found:
    """Return what is found, with how many of the first starts agreed."""
    return found._replace(best=found.best._replace(starts=starts, agreed=agreed))


def _nearer(test: Prepared, found: Found, v: Physical, goal: Physical) -> Physical | None:
    """Return a goal, or a place on the way to it where the whole way makes the residual larger; None if all do.

    It is larger, too, where a nuisance is left out, which the linear torque tells.
    """

    def square(at: Physical) -> float:
        return float(np.sum((test.points.torque(at) - test.record.torque)[found.usable] ** 2))

    # (more by a tenth of the noise of a point is none)
    most = max(square(v), found.best.square) * (1 + 0.1 / np.count_nonzero(found.usable))
    for _ in range(HALVES):
        if square(goal) <= most:
            return goal
        goal = Physical(*((a + b) / 2 for a, b in zip(v, goal, strict=True)))
    return None


def _move(found: Found, v: Physical, goal: Physical) -> float:
    """Return how far values lie apart, over the errors of what is found."""
    chain = found.asked.chain(found.best.values)
    errors = np.sqrt(np.einsum("ij,jk,ik->i", chain, found.covariance, chain))
    apart = np.abs(np.subtract(goal, v))
    return float(np.max(apart / np.where(errors > 0, errors, np.inf), initial=0.0))

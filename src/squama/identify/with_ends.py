"""The search of a fit on a beam of a number of scales with its ends, whose walks take some hundred times as long.

The search asks the endless beam, whose torque is taken times the share that the scales have of it, reading by reading.
That share changes little from one trial to its neighbours, so it is found at an estimate, kept while that is refined,
and found anew. The last estimate, its derivatives and its residuals are those of the scales themselves.
"""

from __future__ import annotations

import numpy as np

from squama.errors import InputError
from squama.identify import selection
from squama.identify.joint_points import Walked
from squama.identify.prepare import Prepared
from squama.identify.selection import Found

ROUNDS, NEAR = 6, 2e-3
"""How often an estimate is refined at most, and the change of a share from which on that is done once more."""


def find(test: Prepared, starts: int, candidates: tuple[str, ...]) -> Found:
    """Find the parameters as :func:`squama.identify.selection.find` does, on a beam's own scales where it has ends."""
    own = test.points
    if not (isinstance(own, Walked) and own.kind is not None):
        return selection.find(test, starts, candidates)
    before = own.shared(own.start)
    near = selection.fit_for(test._replace(points=before), test.asked.names)
    rough, out = selection.robust(near, selection.started(near, starts))
    for _ in range(ROUNDS):
        try:
            points = own.shared(test.asked.physical(rough.values))
        except InputError:
            # a start that the scales do not follow
            break
        near = near._replace(points=points)
        again, out = selection.robust(near, [rough.values])
        rough = again._replace(starts=rough.starts, agreed=rough.agreed)
        if np.abs(points.share / before.share - 1).max() < NEAR:
            break
        before = points
    return selection.chosen(near, rough, out, candidates, own)

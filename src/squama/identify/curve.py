"""The fitted curve between the points: every way of the records once, with its standard error."""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from squama import histories
from squama.identify import estimate
from squama.identify.branches import turning_points
from squama.identify.forward import build
from squama.model.solve import Array

if TYPE_CHECKING:
    from squama.identify.result import Fit

POINTS = 80
"""Points of each way."""
_SAME = 0.02
_NEAR = 1e-6


class Curve(NamedTuple):
    """Load angles (signed), torques, standard errors, and the way that each point belongs to, counted from 1."""

    load: Array
    torque: Array
    error: Array
    leg: Array


def curve(fit: Fit) -> Curve:
    """Return the fitted curve along the ways of the records; ways that are gone again stand once.

    A way that begins at a reversal begins with the drop there.
    """
    at = fit.asked.physical(fit.estimates)
    senses = histories.senses(fit.beam, fit.load, at.mu, fit.law, _NEAR)
    rec = fit.record
    size = float(np.abs(rec.load).max())
    seen: list[tuple[float, float]] = []
    for number in range(len(rec.specimens)):
        mine = rec.load[(rec.specimen == number) & (fit.branch != "beyond")]
        if mine.size < 2:
            continue
        ends = [0, *turning_points(mine, _SAME * size), mine.size - 1]
        for a, b in itertools.pairwise(mine[ends]):
            pair = tuple(float(np.clip(v, -senses.most["-"], senses.most["+"])) for v in (a, b))
            if all(max(abs(pair[0] - p), abs(pair[1] - q)) > _SAME * size for p, q in seen) and pair[0] != pair[1]:
                seen.append((pair[0], pair[1]))
    parts = []
    for number, (a, b) in enumerate(seen, start=1):
        load = np.concatenate([[a], np.linspace(a, b, POINTS)])
        way = np.sign(b - a) * np.where(load < 0, -1.0, 1.0)
        if number > 1:
            way[0] *= -1
        forward = build(senses, load, way)
        J = estimate.derivatives(forward, fit.asked, fit.estimates)
        error = np.sqrt(np.maximum(np.einsum("ij,jk,ik->i", J, fit.covariance, J), 0.0))
        parts.append((load, forward.torque(at), error, np.full(load.size, number)))
    return Curve(*(np.concatenate(column) for column in zip(*parts, strict=True)))

"""Designs refined for their own number of scales: the search asks endless beams, whose end scales lack no neighbour.

A figure at a twist is that of the endless beam times what the design's own scales have of it. That share changes little
from one design to its neighbours, so it is found at a design, kept while that is refined, and found anew.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from squama.inverse import joint_figures, making, search
from squama.inverse.residuals import Look, Residuals
from squama.inverse.target import Target
from squama.progress import steps
from squama.types import Array

ROUNDS, NEAR = 4, 2e-3
"""How often a design is refined at most, and the change of a share from which on that is done once more."""
TYPICAL, LIKELY = 5, 4
"""Designs whose shares are taken as typical; designs that are refined, beside two for each that is wanted."""
MOST = 20.0
"""Largest share, and one over the least."""


class Refined(NamedTuple):
    """Designs, and the shares (goals, n) of the endless beam's figures that they have."""

    look: Look
    shares: Array


def refined(target: Target, look: Look, count: int, seed: int) -> Refined:
    """Refine the designs of a search for their own number of scales; ``count`` are wanted.

    All of them once more with the shares that are typical, then the best ones with their own.
    """
    some = np.concatenate([_shares(target, look.y[i : i + 1]) for i in _best(look, TYPICAL)], axis=1)
    some = some[:, np.isfinite(some).all(axis=0)]
    if some.size:
        look = search.refine(Residuals(target, np.median(some, axis=1, keepdims=True)), look.y)
    best = _best(look, LIKELY + 2 * count)
    found = [_refined(target, look.y[i : i + 1], seed) for i in steps(best.tolist(), best.size, "designs refined")]
    # a design that does not come to the twist cannot be judged, unless there is no other
    found = [one for one in found if np.isfinite(one[1]).all()] or found
    looks, shares = zip(*found, strict=True)
    return Refined(_joined(looks), _known(np.concatenate(shares, axis=1)))


def _best(look: Look, n: int) -> Array:
    """Return the numbers of the best designs, n at most."""
    best = np.argsort(look.merit, kind="stable")[:n]
    return best[np.isfinite(look.merit[best])]


def _known(shares: Array) -> Array:
    """Return shares, 1 where they are not known."""
    return np.where(np.isfinite(shares), shares, 1.0)


def _refined(target: Target, y: Array, seed: int) -> tuple[Look, Array]:
    """Refine a design (1, m), and put it on the grid of what can be made."""
    before, shares = np.ones((len(target.goals), 1)), _shares(target, y)
    for _ in range(ROUNDS):
        # (a beam that does not come to a twist stays as it is)
        if not np.abs(shares / before - 1).max() >= NEAR:
            break
        y = search.refine(Residuals(target, shares), y).y
        before, shares = shares, _shares(target, y)
    if any(v.step for v in target.space.variables):
        exact = y
        for _ in range(ROUNDS):
            if not np.isfinite(shares).all():
                break
            y = making.rounded(Residuals(target, shares), exact, seed)
            before, shares = shares, _shares(target, y)
            if np.abs(shares / before - 1).max() < NEAR:
                break
    return Residuals(target, _known(shares)).look(y, slopes=True, plates=True), shares


def _shares(target: Target, y: Array) -> Array:
    """Return the shares (goals, 1) of the endless beam's figures that a design (1, m) has; 1 of what has no twist.

    NaN where the design does not come to the twist.
    """
    wants, beam = [goal.want for goal in target.goals], target.space.beam_of(y[0])
    own, _ = joint_figures.followed(beam, wants, target.options)
    endless, _ = joint_figures.followed(beam, wants, target.options, endless=True)
    with np.errstate(divide="ignore", invalid="ignore"):
        share = np.where([want.at is not None for want in wants], np.divide(own, endless), 1.0)
    return np.clip(share, 1 / MOST, MOST)[:, None]


def _joined(looks: tuple[Look, ...]) -> Look:
    """Return several looks as one."""
    names = ("r", "J", "g", "G", "merit", "d", "scales")
    parts = {name: np.concatenate([getattr(one, name) for one in looks], axis=-1) for name in names}
    figures = zip(*(one.found for one in looks), strict=True)
    found = type(looks[0].found)._make(np.concatenate(v, axis=-1) for v in figures)
    return Look(y=np.concatenate([one.y for one in looks]), found=found, **parts)

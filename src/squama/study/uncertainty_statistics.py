"""Statistics of samples that come in independent sets, each with its standard error.

A statistic is that of all samples together. It is also taken of each of the R sets; the sets are independent and
alike, so their standard deviation over the root of R is the standard error, for scrambled Sobol points as for random
ones. For R = 32 it is itself known to some 13 %; for Sobol points, which are far off now and then, to a factor of two.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from squama.model.solve import Array

LEAST = 20
"""Samples of a figure that every set must have for statistics of it."""


class Summary(NamedTuple):
    """Statistics of one figure over the samples in which it exists; ``*_se`` are standard errors.

    ``share`` of samples in which it exists; ``quantiles`` at the levels asked for; ``low``, ``high`` smallest and
    largest value.
    """

    share: float
    mean: float
    mean_se: float
    sd: float
    sd_se: float
    quantiles: Array
    quantiles_se: Array
    low: float
    high: float


class Probability(NamedTuple):
    """Share of the samples with some property, and its standard error; ``number`` of them."""

    value: float
    se: float
    number: int


def summary(x: Array, levels: Sequence[float], replicates: int) -> Summary | None:
    """Summarise a figure.

    Parameters
    ----------
    x : (n,) array
        Values, set after set; not finite where the figure does not exist.
    levels : sequence of float
        Probabilities of the quantiles.
    replicates : int
        Number of sets R.

    Returns
    -------
    Summary or None
        None if some set has fewer than :data:`LEAST` values.
    """
    sets = x.reshape(replicates, -1)
    there = np.isfinite(sets)
    counts = there.sum(axis=1)
    if counts.min() < LEAST:
        return None
    # what does not exist goes to the end of its set
    ordered = np.sort(np.where(there, sets, np.inf), axis=1)
    parts = [row[:count] for row, count in zip(ordered, counts, strict=True)]
    whole = np.sort(ordered, axis=None)[: counts.sum()]
    of_sets = np.array([[p.mean(), p.std(ddof=1)] for p in parts])
    se = of_sets.std(axis=0, ddof=1) / np.sqrt(replicates)
    quantiles = _quantiles(whole, levels)
    quantiles_se = _quantile_errors(whole, parts, levels, quantiles)
    # a figure that is the same in all samples has no scatter, not that of rounding
    same = whole[0] == whole[-1]
    mean, sd = (float(whole[0]), 0.0) if same else (float(whole.mean()), float(whole.std(ddof=1)))
    se, quantiles_se = se * (not same), quantiles_se * (not same)
    return Summary(
        float(counts.sum() / x.size), mean, float(se[0]), sd, float(se[1]), quantiles, quantiles_se,
        float(whole[0]), float(whole[-1]),
    )  # fmt: skip


def _quantiles(ordered: Array, levels: Sequence[float] | Array) -> Array:
    """Return quantiles of values in order, linear between them."""
    place = np.asarray(levels, float) * (ordered.size - 1)
    i = np.minimum(place.astype(int), ordered.size - 2)
    w = place - i
    return np.asarray((1 - w) * ordered[i] + w * ordered[i + 1])


def _quantile_errors(whole: Array, parts: list[Array], levels: Sequence[float], quantiles: Array) -> Array:
    """Return standard errors of quantiles: that of the share below each, over the density there.

    (The quantiles of a small set of Sobol points scatter less than their share in the whole does.)
    """
    shares = np.array([np.searchsorted(p, quantiles) / p.size for p in parts])
    # a place between two samples is all that is known
    of_share = np.maximum(shares.std(axis=0, ddof=1) / np.sqrt(len(parts)), 0.5 / whole.size)
    p = np.asarray(levels, float)
    above, below = (_quantiles(whole, np.clip(p + side * of_share, 0, 1)) for side in (1, -1))
    return (above - below) / 2


def probability(has: Array, replicates: int) -> Probability:
    """Return the share of samples that have a property.

    Where none or all have it the sets do not differ; then the standard error is that of one sample more or less,
    about 1/n.

    Parameters
    ----------
    has : (n,) array of bool
        Set after set.
    replicates : int
        Number of sets.
    """
    n, count = has.size, int(np.count_nonzero(has))
    if count in (0, n):
        p = (count + 1) / (n + 2)
        return Probability(count / n, float(np.sqrt(p * (1 - p) / n)), count)
    shares = has.reshape(replicates, -1).mean(axis=1)
    # a handful of samples in one set or another scatter as any counts do
    least = 0.0 if count * (n - count) / n > replicates else np.sqrt(count * (n - count) / n**3)
    return Probability(count / n, float(max(shares.std(ddof=1) / np.sqrt(replicates), least)), count)

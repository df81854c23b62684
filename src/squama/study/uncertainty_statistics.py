"""Statistics of samples that come in independent sets, each with its standard error.

A statistic is that of all samples together. It is also taken of each of the R sets; the sets are independent and
alike, so their standard deviation over the root of R is the standard error (within some 13 % for R = 32), for
scrambled Sobol points as for random ones.
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
    of_sets = np.array([[p.mean(), p.std(ddof=1), *_quantiles(p, levels)] for p in parts])
    se = of_sets.std(axis=0, ddof=1) / np.sqrt(replicates)
    # a figure that is the same in all samples has no scatter, not that of rounding
    same = whole[0] == whole[-1]
    mean, sd = (float(whole[0]), 0.0) if same else (float(whole.mean()), float(whole.std(ddof=1)))
    se = se * (not same)
    return Summary(
        float(counts.sum() / x.size), mean, float(se[0]), sd, float(se[1]), _quantiles(whole, levels), se[2:],
        float(whole[0]), float(whole[-1]),
    )  # fmt: skip


def _quantiles(ordered: Array, levels: Sequence[float]) -> Array:
    """Return quantiles of values in order, linear between them."""
    place = np.asarray(levels, float) * (ordered.size - 1)
    i = np.minimum(place.astype(int), ordered.size - 2)
    w = place - i
    return np.asarray((1 - w) * ordered[i] + w * ordered[i + 1])


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

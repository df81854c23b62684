"""The order in which designs are taken: those that ask for about as much work side by side.

All lanes of a block wait for the slowest. Only speed depends on the order, so rough figures do.
"""

from __future__ import annotations

import numpy as np

from squama.engines.compiled_kernel import compiled
from squama.model.solve import Array

FAR, LONG = 8, 8
"""Classes of reach, and of the guessed length of the path."""


@compiled
def _sort(key: Array, taken: Array, index: Array) -> None:
    """Put ``taken`` into ``index`` in the order of its keys, all below FAR LONG; those of one key stay as they are."""
    after = np.zeros(FAR * LONG + 1, np.int64)
    for k in key:
        after[k + 1] += 1
    for i in range(FAR * LONG):
        after[i + 1] += after[i]
    for i in range(key.size):
        index[after[key[i]]] = taken[i]
        after[key[i]] += 1


@compiled
def order(designs: tuple[Array, ...], mirrored: bool, base: int, n: int, index: Array) -> None:
    """Order n designs from ``base`` on in ``index``."""
    end = base + n
    # parts of the arrays: an index that might be negative costs more than all the rest
    eta, beta, alpha, mu = designs[0][base:end], designs[1][base:end], designs[3][base:end], designs[5][base:end]
    key = np.empty(n, np.int64)
    wide = 0.0 if mirrored else 2.0
    for i in range(n):
        a2 = alpha[i] * alpha[i]
        # eta cos alpha + 2 beta sin alpha, about
        far = eta[i] * (1 - a2 * (0.497 - 0.037 * a2)) + wide * beta[i] * alpha[i] * (1 - a2 * (0.166 - 0.0076 * a2))
        # fitted to where random designs end: friction locks early, wide scales late
        long = 5.7 / (1 + mu[i]) + 4.1 * beta[i] / eta[i] - 2.0
        key[i] = LONG * int(max(0.0, min(far, FAR - 1.0))) + int(max(0.0, min(long, LONG - 1.0)))
    _sort(key, np.arange(n), index)


@compiled
def order_by(column: Array, index: Array, n: int) -> None:
    """Order the first n entries of ``index`` by whole numbers in a column of the table, all large ones alike."""
    taken, key = index[:n].copy(), np.empty(n, np.int64)
    for i in range(n):
        key[i] = int(min(column[taken[i]], FAR * LONG - 1.0))
    _sort(key, taken, index)

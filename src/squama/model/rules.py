"""Gauss rules for the frictional work, each with a measure of how well it has converged.

On a path that ends in a frictional lock the weight z/(1-z) on [0, 1 - margin] holds the pole and the zero of the
integrand, and a few nodes do; on other paths the rule is Legendre's in y = -ln(1 - z).
"""

from __future__ import annotations

import functools
from typing import NamedTuple

import numpy as np

from squama.model.solve import Array

SIZES = (14, 26, 48, 96)
LEGENDRE_SIZES = (26, 48, 96, 192, 512)
ROUGH, ROUGH_PLAIN = 3e-8, 5e-9
"""Last terms of the series over the first at which a rule counts as converged: pole rules, Legendre's rules.

The error of a Gauss rule is about that of twice as many terms; how much that gains depends on how steadily the terms
fall. Of 600 000 random designs of wide ranges two had an error of 2e-9, 33 one above 1e-10, most of 1e-12.
"""


class Rules(NamedTuple):
    """Rules one after the other: ``sizes``; a row each of nodes, weights and the last two series terms; ``rough``."""

    sizes: Array
    nodes: Array
    rough: float


def _recurrence(x: Array, w: Array, n: int) -> tuple[Array, Array]:
    """Coefficients of the orthonormal polynomials of a discrete measure (Stieltjes)."""
    a, b = np.zeros((2, n))
    before, now = np.zeros_like(x), np.full_like(x, 1 / np.sqrt(w.sum()))
    for k in range(n):
        a[k] = (w * x * now * now).sum()
        after = (x - a[k]) * now - (b[k - 1] if k else 0.0) * before
        b[k] = np.sqrt((w * after * after).sum())
        before, now = now, after / b[k]
    return a, b


def _gauss(x: Array, w: Array, n: int) -> Array:
    """Gauss rule of n nodes for a measure: nodes, weights, and the weights of the last two terms over the first."""
    a, b = _recurrence(x, w, n)
    nodes, vectors = np.linalg.eigh(np.diag(a) + np.diag(b[:-1], 1) + np.diag(b[:-1], -1))
    first = vectors[0] * np.sqrt(w.sum())
    # column i of the eigenvectors is sqrt(weight i) times the orthonormal polynomials at node i
    root = np.sqrt(w.sum())
    return np.stack([nodes, first * first, root * first * vectors[-1], root * first * vectors[-2]])


@functools.lru_cache(maxsize=32)
def pole_rules(margin: float) -> Rules:
    """Rules for the weight z/(1-z) on [0, 1 - margin]; their weights are divided by that weight."""
    y, w = np.polynomial.legendre.leggauss(400)
    last = -np.log(margin)
    y, w = last * (y + 1) / 2, last * w / 2
    z = -np.expm1(-y)
    rules = [_gauss(z, w * z, n) for n in SIZES]
    parts = np.concatenate(rules, axis=1)
    parts[1:] *= (1 - parts[0]) / parts[0]
    return Rules(np.array(SIZES), np.ascontiguousarray(parts), ROUGH)


@functools.cache
def legendre_rules() -> Rules:
    """Legendre's rules on [0, 1]."""
    y, w = np.polynomial.legendre.leggauss(LEGENDRE_SIZES[-1])
    rules = [_gauss((y + 1) / 2, w / 2, n) for n in LEGENDRE_SIZES]
    return Rules(np.array(LEGENDRE_SIZES), np.ascontiguousarray(np.concatenate(rules, axis=1)), ROUGH_PLAIN)

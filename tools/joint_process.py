"""A Gaussian process with a linear trend, for outputs that share their lengths: fitted by restricted likelihood."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.linalg import cho_solve, cholesky, solve_triangular
from scipy.optimize import minimize

from squama.joints.processes import nearness
from squama.types import Array

LENGTHS, NOISE = (-1.5, 5.0), (1e-5, 1.0)
"""Limits of the logarithms of lengths, in standard deviations of a feature, and of the noise's share of variance."""
PRIOR = 1.0, 1.5
"""Mean and deviation of the logarithm of a length before anything is known."""


class Process(NamedTuple):
    """Lengths (p,), noise, weights (n, m), trend (1 + p, m), and each design's error when it is left out (n, m)."""

    lengths: Array
    noise: float
    weights: Array
    trend: Array
    left_out: Array


class _Parts(NamedTuple):
    slope: Array
    factor: Array
    inner: Array
    solved: Array
    Q: Array


def fitted(x: Array, Y: Array, spread: Array | None = None, *, steps: int = 100, noise: float = NOISE[0]) -> Process:
    """Return the process of outputs Y (n, m) over standardised features x (n, p).

    ``spread`` (n,) are factors of the noise's variance, ``noise`` is its least share. The likelihood is that of outputs
    that are independent but for their lengths, each of its own variance, with the trend's coefficients integrated out:
        log L = sum_j -(n - p - 1)/2 log(y_j^T Q y_j) - m/2 log|A| - m/2 log|H^T A^-1 H|
    with A = kernel + noise, H = [1, x], Q = A^-1 - A^-1 H (H^T A^-1 H)^-1 H^T A^-1.
    """
    n, p = x.shape
    spread = np.ones(n) if spread is None else spread
    H, m, rest = np.column_stack([np.ones(n), x]), Y.shape[1], n - p - 1
    apart = [(x[:, None, k] - x[None, :, k]) ** 2 for k in range(p)]

    def parts(at: Array) -> _Parts:
        square = 5 * sum(d * np.exp(-2 * a) for d, a in zip(apart, at, strict=False))
        near, r = nearness(square), np.sqrt(square)
        # times a square of distances over its length: the kernel's derivative by the logarithm of that length
        slope = 5 / 3 * (1 + r) * np.exp(-r)
        factor = cholesky(near + np.diag(np.exp(at[p]) * spread), lower=True)
        inverse = cho_solve((factor, True), np.eye(n))
        solved = inverse @ H
        inner = cholesky(H.T @ solved, lower=True)
        half = solve_triangular(inner, solved.T, lower=True)
        return _Parts(slope, factor, inner, solved, inverse - half.T @ half)

    def lost(at: Array) -> tuple[float, Array]:
        try:
            near_slope, factor, inner, _, Q = parts(at)
        except np.linalg.LinAlgError:
            return 1e10, np.zeros(p + 1)
        QY = Q @ Y
        q = (Y * QY).sum(0)
        value = rest / 2 * np.log(q).sum() + m * (np.log(np.diag(factor)).sum() + np.log(np.diag(inner)).sum())
        W = m * Q - (QY * (rest / q)) @ QY.T
        B = W * near_slope
        slope = [0.5 * (B * d).sum() * np.exp(-2 * a) for d, a in zip(apart, at, strict=False)]
        slope.append(0.5 * (np.diag(W) * spread).sum() * np.exp(at[p]))
        mean, deviation = PRIOR
        off = np.append((at[:p] - mean) / deviation, 0.0)
        return value / m + (off**2).sum() / 2, np.array(slope) / m + off / deviation

    start = np.append(np.full(p, 2.0), np.log(max(1e-4, noise)))
    found = minimize(
        lost,
        start,
        jac=True,
        method="L-BFGS-B",
        bounds=[LENGTHS] * p + [(np.log(noise), np.log(NOISE[1]))],
        options={"maxiter": steps},
    )
    _, factor, inner, solved, Q = parts(found.x)
    trend = cho_solve((inner, True), solved.T @ Y)
    weights = cho_solve((factor, True), Y - H @ trend)
    return Process(np.exp(found.x[:p]), float(np.exp(found.x[p])), weights, trend, (Q @ Y) / np.diag(Q)[:, None])


def predicted(process: Process, x: Array, at: Array) -> Array:
    """Return outputs (k, m) at features ``at`` (k, p) of a process of designs at x (n, p)."""
    z, c = at / process.lengths, x / process.lengths
    near = nearness(5 * ((z[:, None] - c[None]) ** 2).sum(2))
    return np.asarray(process.trend[0] + at @ process.trend[1:] + near @ process.weights)

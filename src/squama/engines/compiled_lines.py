"""Other neighbours of many designs in lock-step: which is met first, and how far the others are from being met."""

from __future__ import annotations

import math

from squama.engines.compiled_kernel import OPS, compiled, inlined
from squama.engines.compiled_lanes import (
    BEFORE,
    BETA,
    CA,
    COS,
    COSJ,
    ETA,
    FIRST,
    HALF,
    HERE,
    LAM,
    LEAN,
    LOADE,
    LOW,
    OK,
    QQ,
    R_CS,
    R_G,
    R_H,
    R_Q,
    R_S,
    REACH,
    SA,
    SIN,
    SINJ,
    SN,
    THETA0,
    H,
    K,
    W,
    kept,
    open_row,
    roots,
)  # fmt: skip
from squama.model import twisting
from squama.model.neighbours import gap, meeting, on_edges, reach, reach_at, within
from squama.model.paths import Twist
from squama.model.solve import Array


@inlined
def _near(w: Array, i: int, k: float) -> Twist:
    """Return neighbour k of a design whose lengths are in pitches."""
    return Twist(w[ETA + i], w[BETA + i], w[LAM + i], w[SA + i], w[CA + i], w[THETA0 + i], k)


@inlined
def _whole(w: Array, i: int) -> Twist:
    """Return the same with lengths in pitches."""
    k = w[K + i]
    return Twist(w[ETA + i] * k, w[BETA + i] * k, w[LAM + i] * k, w[SA + i], w[CA + i], w[THETA0 + i], 1.0)


@compiled
def engage(w: Array) -> None:
    """Neighbour that is met first (K; 0 for none) and its twist (LOADE), as ``neighbours.first_engagement``."""
    far = 1.0
    for i in range(W):
        w[REACH + i] = reach(_near(w, i, 1.0), OPS)
        w[K + i] = 0.0
        w[LOADE + i] = math.inf
    for i in range(W):
        far = max(far, w[REACH + i])
    for n in range(1, int(far) + 1):
        k, asked = float(n), 0
        for i in range(W):
            r, q, phi = meeting(_near(w, i, k), OPS)
            first = (r.H + q > 0) & ((k <= w[REACH + i]) | (n == 1)) & (phi < w[LOADE + i])
            w[OK + i] = phi if first else math.nan
            asked += 1 if first else 0
        if asked == 0:
            continue
        for i in range(W):
            row = _near(w, i, k)
            r, q, phi = meeting(row, OPS)
            on = within(row, r, q) & (w[OK + i] < w[LOADE + i])
            w[LOADE + i] = w[OK + i] if on else w[LOADE + i]
            w[K + i] = k if on else w[K + i]


@compiled
def not_met(w: Array, folded: bool) -> None:
    """How far neighbour FIRST is from being met at X (LOW); in QQ whether it lies on its edges there."""
    roots(w, folded)
    for i in range(W):
        theta, r, q, _ = kept(w, i)
        phi = 2 * OPS.atan(r.S / (r.H + q)) / w[K + i]
        w[LOW + i] = -gap(_whole(w, i), w[FIRST + i], theta, phi, OPS)
        w[QQ + i] = 1.0 if on_edges(_whole(w, i), w[FIRST + i], theta, phi) else 0.0


@inlined
def _lines(w: Array, i: int, u: float, r: twisting.Root) -> None:
    c = 1 / (1 + u * u)
    w[COS + i], w[SIN + i] = (1 - u * u) * c, 2 * u * c
    w[LEAN + i] = w[SA + i] * w[CA + i] * r.cs
    w[H + i] = r.H + w[LEAN + i]
    w[SN + i] = r.S
    w[HALF + i] = r.G / 2
    w[BEFORE + i] = w[HERE + i]
    w[HERE + i] = reach_at(_whole(w, i), r.cs)


@compiled
def start_lines(w: Array) -> None:
    """Terms of the contact conditions of all neighbours, where the path follows the next; ready for the second."""
    for i in range(W):
        u = w[R_S + i] / (w[R_H + i] + w[R_Q + i])
        c = 1 / (1 + u * u)
        cos, sin = (1 - u * u) * c, 2 * u * c
        w[COS + i], w[SIN + i] = cos, sin
        w[COSJ + i], w[SINJ + i] = cos * cos - sin * sin, 2 * cos * sin
    for i in range(W):
        lean = w[SA + i] * w[CA + i] * w[R_CS + i]
        w[LEAN + i], w[H + i], w[SN + i], w[HALF + i] = lean, w[R_H + i] + lean, w[R_S + i], w[R_G + i] / 2


@inlined
def reach_here(w: Array, i: int) -> float:
    """How far the tip of lane i reaches at X, in its own units."""
    far: float = reach_at(open_row(w, i), w[R_CS + i])
    return far


@compiled
def lines(w: Array, folded: bool) -> None:
    """Terms of the contact conditions of all neighbours at X, as in ``neighbours._crossed``."""
    roots(w, folded)
    near = 0
    for i in range(W):
        near += 1 if w[K + i] == 1 else 0
    if near == W:
        for i in range(W):
            _, r, q, _ = kept(w, i)
            _lines(w, i, r.S / (r.H + q), r)
        return
    for i in range(W):
        theta, r, q, _ = kept(w, i)
        _lines(w, i, OPS.tan(OPS.atan(r.S / (r.H + q)) / w[K + i]), _whole(w, i).root(theta, OPS))


@inlined
def line(w: Array, i: int, j: float) -> float:
    """Contact condition of neighbour j times j, and the sine and cosine of the next."""
    c, d = w[COSJ + i], w[SINJ + i]
    w[COSJ + i] = c * w[COS + i] - d * w[SIN + i]
    w[SINJ + i] = d * w[COS + i] + c * w[SIN + i]
    value: float = (w[HALF + i] - j * w[SN + i]) * c + (w[H + i] - j * w[LEAN + i]) * d - w[HALF + i]
    return value

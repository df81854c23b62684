"""Figures at the cut-off and frictional work of many paths in lock-step (``energy.cutoff``, ``pole`` and ``works``)."""

from __future__ import annotations

import math

import numpy as np

from squama.engines import compiled_lanes as lanes
from squama.engines.compiled_ends import FRICTIONAL, KINEMATIC
from squama.engines.compiled_kernel import OPS, compiled
from squama.engines.compiled_lanes import (
    CODE,
    FORCE,
    P1,
    P2,
    R1,
    S0,
    S1,
    S2,
    SPAN,
    THETA0,
    THETA_F,
    X0,
    X_C,
    X_END,
    D,
    W,
    X,
)  # fmt: skip
from squama.model.energy import DEPTH, MOST_PARTS, TOLERANCE, beyond
from squama.model.rules import ROUGH, ROUGH_PLAIN
from squama.model.solve import Array


@compiled
def cut(w: Array, margin: float, folded: bool) -> None:
    """Path parameter of the cut-off, in X_C (as ``energy.cutoff``)."""
    for i in range(W):
        x0, x_end, theta0, theta_f = w[X0 + i], w[X_END + i], w[THETA0 + i], w[THETA_F + i]
        x_c = x0 + (1 - margin) * (x_end - x0)
        if folded:
            theta_c = theta0 + (1 - margin) * (theta_f - x_end * x_end - theta0)
            x_c = -math.sqrt(theta_f - theta_c) if x_end <= 0 else x_c
        locks = (w[CODE + i] == FRICTIONAL) | (w[CODE + i] == KINEMATIC)
        w[X_C + i] = x_c if locks else x_end


@compiled
def pole(w: Array, folded: bool, plates: bool) -> None:
    """Reach P1 from X0 to the pole of the friction force, and the last y, P2 (as ``energy.pole``)."""
    for i in range(W):
        w[X + i] = w[X_END + i]
    lanes.figures(w, folded, plates)
    for i in range(W):
        w[S0 + i] = w[D + i]
        w[X + i] = w[X_END + i] - 1e-4 * (w[X_END + i] - w[X0 + i])
    lanes.figures(w, folded, plates)
    for i in range(W):
        span = w[X_END + i] - w[X0 + i]
        w[P1 + i] = span + beyond(w[S0 + i], w[D + i], 1e-4 * span, OPS)
        w[P2 + i] = -math.log1p(-(w[X_C + i] - w[X0 + i]) / w[P1 + i])


@compiled
def work(w: Array, rule: Array, start: int, size: int, locked: bool, folded: bool, plates: bool) -> None:
    """Frictional work in S0 by one rule; S1 tells whether it has converged (> 0) or not."""
    for i in range(W):
        w[S0 + i] = w[S1 + i] = w[S2 + i] = 0.0
        w[R1 + i] = w[SPAN + i] = w[X_END + i] - w[X0 + i]
    for n in range(start, start + size):
        node, weight, last, last_but_one = rule[0, n], rule[1, n], rule[2, n], rule[3, n]
        if locked:
            # the path of a lock ends at its pole
            lanes.roots_at(w, node, folded)
        else:
            lanes.spread(w, node)
            lanes.roots(w, folded)
        lanes.push_here(w, plates)
        for i in range(W):
            g = w[FORCE + i] * w[R1 + i]
            w[S0 + i] += weight * g
            w[S1 + i] += last * g
            w[S2 + i] += last_but_one * g
    for i in range(W):
        limit = (ROUGH if locked else ROUGH_PLAIN) * abs(w[S0 + i])
        good = (abs(w[S1 + i]) <= limit) & (abs(w[S2 + i]) <= limit)
        w[S1 + i] = 1.0 if good else 0.0


@compiled
def in_parts(w: Array, rule: Array, size: int, folded: bool, plates: bool) -> float:
    """Frictional work of the design that fills all lanes, as ``energy.in_parts``: every lane takes a part of y.

    ``rule`` begins with Legendre's smallest, of ``size`` nodes.
    """
    pole(w, folded, plates)
    start, reach = w[X0], w[P1]
    lows, widths, total, whole, left = np.zeros(W * MOST_PARTS), np.zeros(W * MOST_PARTS), 0.0, 0.0, 1
    widths[0] = w[P2]
    for depth in range(DEPTH):
        parts, low, width, left = left, lows[:left].copy(), widths[:left] / W, 0
        for part in range(parts):
            for i in range(W):
                y = low[part] + width[part] * i
                w[P1 + i], w[P2 + i] = reach * math.exp(-y), width[part]
                w[X0 + i] = start - reach * math.expm1(-y)
            work(w, rule, 0, size, size < 0, folded, plates)
            if depth == 0:
                for i in range(W):
                    whole += abs(w[S0 + i])
            for i in range(W):
                good = (w[S1 + i] > 0) | (abs(w[S0 + i]) <= TOLERANCE * whole)
                if good | (depth == DEPTH - 1) | (parts > MOST_PARTS):
                    total += w[S0 + i]
                else:
                    lows[left], widths[left] = low[part] + width[part] * i, width[part]
                    left += 1
    return total

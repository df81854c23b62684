"""Which edges touch first, and at which twist; compiled."""

from __future__ import annotations

import math

import numpy as np

from squama.real.contact import Design, _in, _jit, high, lengthwise, low
from squama.real.faces import others
from squama.real.steps import engagement, free_rates, unloaded
from squama.types import Array

_SAMPLES, _HALVINGS, _NEAR = 8, 40, 0.02
_EDGES = (0, 1, 2, 3)


@_in
def meeting(d: Design, first: int, second: int, k: int) -> Design:
    """Return the design with other edges that meet, their common normal pushing scale 1 upwards."""
    # (edges along one direction cross by the twist alone)
    sign = 1.0 if lengthwise(second) and not lengthwise(first) else -1.0
    return Design(
        d.eta, d.beta, d.lam, d.sa, d.ca, d.st, d.ct, d.h, d.mu, first, second, k, sign, d.elastic, d.table,
        d.bent,
    )  # fmt: skip


@_in
def within(d: Design, x: float, y: float) -> bool:
    """Say whether places lie on their edges."""
    return low(d, d.first) <= x <= high(d, d.first) and low(d, d.second) <= y <= high(d, d.second)


@_jit
def hinge_guess(d: Design) -> tuple[float, float, float]:
    """Return twist and places at which tip and side of thick plates on hinges would meet (docs, theory: geometry)."""
    S = d.ca * d.st
    H = d.sa * (d.eta + d.lam * d.st) + d.ca * d.ct * (d.beta - d.sa)
    s2, c2 = 2 * d.sa * d.ca, d.ca * d.ca - d.sa * d.sa
    G = d.beta * s2 * d.st + 2 * d.eta * d.ca * d.ca * d.st * d.ct + 2 * d.lam * c2 * d.ct
    u = (S - d.h) / (H + math.sqrt(max(0.0, H * H - (S - d.h) * (G - S + d.h * S * S))))
    phi = 2 * math.atan(u) if u > 0 else 0.05
    c, s = math.cos(phi), math.sin(phi)
    y = (d.lam * (1 - c) + d.eta * d.st - d.beta * d.ca * s) / (d.st * c + d.sa * d.ct * s)
    return phi, 0.0, min(max(y, 0.0), d.eta)


@_jit
def first_contact(d: Design, least: float, most: float) -> tuple[int, int, int, float, float, float]:
    """Return the edges that touch first between twists, their neighbour, the twist and both places.

    The first edge is -1 where nothing touches below ``most``, and -2 where something touches that is not two edges, or
    at rest (twist 0).
    """
    rates, b, q = free_rates(d), np.zeros(24), np.empty(7)
    found, phi, x, y = engagement(d, rates, hinge_guess(d))
    found = found and least < phi <= most and within(d, x, y) and not d.bent
    n = _SAMPLES if found else 8 * _SAMPLES
    limit = phi * (1 - 1e-9) if found else most
    before = least
    for i in range(n + 1):
        at = least + (limit - least) * i / n
        unloaded(rates, at, q)
        deep, edge, k = others(d, q, at, q[6], b)
        if deep < 0.0:
            if i == 0:
                return -2, edge, k, 0.0, 0.0, 0.0
            for _ in range(_HALVINGS):
                middle = (before + at) / 2
                unloaded(rates, middle, q)
                deep, e, j = others(d, q, middle, q[6], b)
                if deep < 0.0:
                    at, edge, k = middle, e, j
                else:
                    before = middle
            return by_edge(d, rates, edge, k, at)
        before = at
    if found:
        return d.first, d.second, d.k, phi, x, y
    return -1, 0, 0, math.inf, 0.0, 0.0


@_jit
def by_edge(d: Design, rates: Array, edge: int, k: int, near: float) -> tuple[int, int, int, float, float, float]:
    """Return the contact of an edge (+ 4: of the neighbour's upper face) with one of the other scale's near a twist."""
    best = (-2, edge, k, near, 0.0, 0.0)
    gap = _NEAR * near
    for other in _EDGES:
        pair = meeting(d, other, edge - 4, k) if edge >= 4 else meeting(d, edge, other, k)
        for i in range(3):
            for j in range(3):
                x = low(d, pair.first) + (high(d, pair.first) - low(d, pair.first)) * (i + 0.5) / 3
                y = low(d, pair.second) + (high(d, pair.second) - low(d, pair.second)) * (j + 0.5) / 3
                found, phi, x, y = engagement(pair, rates, (near, x, y))
                if found and abs(phi - near) <= gap and within(pair, x, y):
                    best, gap = (pair.first, pair.second, k, phi, x, y), abs(phi - near)
    return best

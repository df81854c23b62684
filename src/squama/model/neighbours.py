"""Tip-side contacts of all neighbours: the first one to engage, and others that come in along a path.

Neighbour k obeys the same contact condition with eta/k, beta/k, lam/k and k phi (docs, theory: geometry).
"""

from __future__ import annotations

import math
from typing import Any

from squama.model import twisting
from squama.model.paths import ARRAY, Ops, Twist
from squama.types import Array


def reach_at(row: Twist, cs: Any) -> Any:
    """Return an upper bound of the neighbours within reach of a tip, at an inclination with the cosine ``cs``.

    A contact with neighbour k lies at k = (eta - s) cos a cos th + (beta + p) sin a + ts cos a sin th, with 0 <= s and
    p <= beta.
    """
    thin = row.eta * row.ca * (cs + abs(cs)) / 2 + row.beta * (row.sa + abs(row.sa)) + 1e-9
    return thin + row.thickness * row.ca


def reach(row: Twist, ops: Ops = ARRAY) -> Any:
    """Return an upper bound of the neighbours within reach of a tip: the inclination is never smaller than at rest."""
    return reach_at(row, ops.cos(row.theta0))


def meets(row: Twist, ops: Ops) -> Any:
    """Return the twist per pitch (rad) at which the lines of neighbour ``row.k`` meet, at rest (paper Eq. 6). Exact."""
    r = row.root(row.theta0, ops)
    return 2 * ops.atan(r.S / (r.H + ops.sqrt(r.q2))) / row.k


def engages(row: Twist, ops: Ops) -> Any:
    """Return whether the tip-side contact of neighbour ``row.k`` engages: its lines meet within both edges."""
    r = row.root(row.theta0, ops)
    q = ops.sqrt(r.q2)
    c = twisting.contact(r, q, *row.ratios)
    return (r.S > 0) & (r.H + q > 0) & (abs(c.p) <= row.beta / row.k) & (c.s >= 0) & (c.s <= row.eta / row.k)


def touches_at_rest(row: Twist) -> bool:
    """Return whether plates overlap their neighbours and fill the gap between them before any load."""
    S, over = row.ca * math.sin(row.theta0), row.ca * math.cos(row.theta0)
    return bool(row.thickness > 0 and row.thickness >= S and over < row.eta and abs(row.sa) < 2 * row.beta)


def gap(row: Twist, j: float | Array, theta: float | Array, phi: float | Array, ops: Ops) -> Any:
    """Return the contact condition F of neighbour ``j`` at an inclination and a twist: negative before contact."""
    r = row._replace(k=j).root(theta, ops)
    c, s = ops.cos(j * phi), ops.sin(j * phi)
    return ((r.G - 2 * r.S) * c - r.G) / 2 + r.H * s


def on_edges(row: Twist, j: float | Array, theta: float | Array, phi: float | Array, ops: Ops) -> Any:
    """Return whether the lines of neighbour ``j``'s tip-side pair meet within both edges."""
    sub = row._replace(k=j)
    r = sub.root(theta, ops)
    u = ops.tan(j * phi / 2)
    c = twisting.contact(r, r.H - (r.G - r.S) * u, *sub.ratios)
    return (abs(c.p) <= row.beta / j) & (c.s >= 0) & (c.s <= row.eta / j)

"""Tip-side contacts of all neighbours: which is met first, and which comes in along a path.

Neighbour k obeys the same contact condition with eta/k, beta/k, lam/k and k phi (docs, theory: geometry).
"""

from __future__ import annotations

from typing import Any, NamedTuple, Self

import numpy as np

from squama.model import twisting
from squama.model.paths import ARRAY, FLOAT, Ops, Twist
from squama.model.solve import Array, blocks, first_zero, take

SAMPLES = 13
"""Samples of an open path at which other neighbours are looked for."""
FOLDED_SAMPLES = 41
"""The same for a folded path, on which the twist grows large and farther neighbours come and go."""


class Crossing(NamedTuple):
    """Per design: neighbour ``k`` (0 for none) whose tip-side contact comes in at the path parameter ``x``."""

    k: Array
    x: Array

    @classmethod
    def none(cls, n: int) -> Self:
        """No crossing in n designs."""
        return cls(np.zeros(n, np.int64), np.full(n, np.inf))

    def take(self, index: Array) -> Crossing:
        """Return a part."""
        return Crossing(self.k[index], self.x[index])


def reach_at(row: Any, cs: Any) -> Any:
    """Bound of the neighbours a tip can reach at an inclination with the cosine ``cs``.

    A contact with neighbour k lies at k = (eta - s) cos a cos th + (beta + p) sin a, with 0 <= s and p <= beta.
    """
    return row.eta * row.ca * (cs + abs(cs)) / 2 + row.beta * (row.sa + abs(row.sa)) + 1e-9


def reach(row: Any, ops: Ops = ARRAY) -> Any:
    """Bound of the neighbours a tip can reach: the inclination is nowhere smaller than at rest."""
    return reach_at(row, ops.cos(row.theta0))


def _farthest(row: Any) -> Array:
    """Farthest neighbour to look for, the next one at least."""
    return np.asarray(np.maximum(1.0, np.floor(reach(row, ARRAY))))


def meeting(row: Twist, ops: Ops) -> tuple[twisting.Root, Any, Any]:
    """Terms, root, and twist per pitch at which the lines of neighbour ``row.k`` meet (paper Eq. 6 at theta0)."""
    r = row.root(row.theta0, ops)
    q = ops.sqrt(r.q2)
    return r, q, 2 * ops.atan(r.S / (r.H + q)) / row.k


def within(row: Twist, r: twisting.Root, q: Any) -> Any:
    """Whether lines that meet do so on both edges."""
    c = twisting.contact(r, q, *row.ratios)
    return (r.H + q > 0) & (abs(c.p) <= row.beta / row.k) & (c.s >= 0) & (c.s <= row.eta / row.k)


def engages(row: Twist, ops: Ops) -> tuple[Any, Any]:
    """Whether the tip-side contact of neighbour ``row.k`` engages, and at which twist per pitch. Exact."""
    r, q, phi = meeting(row, ops)
    return within(row, r, q), phi


def engagement(row: Twist) -> Array:
    """Twist per pitch at which the tip-side contact of neighbour ``row.k`` engages; inf where it never does."""
    with np.errstate(all="ignore"):
        on, phi = engages(row, ARRAY)
    return np.where(on, phi, np.inf)


def first_engagement(row: Twist) -> tuple[Array, Array]:
    """Return the neighbour that is met first and its engagement twist; k = 0 and inf where there is none."""
    n = row.eta.size
    k, best = np.zeros(n, np.int64), np.full(n, np.inf)
    for p in blocks(n):
        part = take(row, p)
        far = _farthest(part).astype(np.int64)
        # one lane for every design and neighbour within reach, a design's lanes side by side
        owner = np.repeat(np.arange(far.size), far)
        start = np.cumsum(far) - far
        number = np.arange(owner.size) - start[owner] + 1
        phi = engagement(take(part, owner)._replace(k=number.astype(float)))
        best[p] = np.minimum.reduceat(phi, start)
        met = np.flatnonzero((phi == best[p][owner]) & np.isfinite(phi))[::-1]
        k[p.start + owner[met]] = number[met]
    return k, best


def gap(row: Twist, j: Any, theta: Any, phi: Any, ops: Ops) -> Any:
    """Contact condition F of neighbour ``j`` at an inclination and a twist: negative before it is met."""
    r = row._replace(k=j).root(theta, ops)
    c, s = ops.cos(j * phi), ops.sin(j * phi)
    return ((r.G - 2 * r.S) * c - r.G) / 2 + r.H * s


def on_edges(row: Twist, j: Any, theta: Any, phi: Any) -> Any:
    """Whether the lines of neighbour ``j``'s tip-side pair meet within both edges."""
    sub = row._replace(k=j)
    r = sub.root(theta, ARRAY)
    u = np.tan(j * phi / 2)
    c = twisting.contact(r, r.H - (r.G - r.S) * u, *sub.ratios)
    return (abs(c.p) <= row.beta / j) & (c.s >= 0) & (c.s <= row.eta / j)


def first_crossing(row: Any, x0: Array, x_end: Array) -> Crossing:
    """Find where another neighbour's tip-side contact comes in first on paths from ``x0`` to ``x_end``.

    Parameters
    ----------
    row
        Twisting row (open or folded) of n designs.
    x0, x_end
        Path parameters of engagement and end.
    """
    found = Crossing.none(x0.size)
    steps = np.linspace(0.0, 1.0, FOLDED_SAMPLES if hasattr(row, "open") else SAMPLES)
    # in order of reach, so that few designs are asked for neighbours they do not have
    order = np.argsort(_farthest(row), kind="stable")
    parts = [np.empty((3, 0), np.int64)]
    for p in blocks(x0.size):
        lanes = order[p]
        lane, j, i = _crossed(take(row, lanes), x0[lanes], x_end[lanes], steps)
        parts.append(np.stack([lanes[lane], j, i]))
    lane, j, i = np.concatenate(parts, axis=1)
    if lane.size == 0:
        return found
    span = (x_end - x0)[lane]
    a, b = x0[lane] + span * steps[i], x0[lane] + span * steps[i + 1]
    kind = type(row)

    def at(x: Any, *cols: Any) -> Any:
        ops = FLOAT if isinstance(x, float) else ARRAY
        one = kind(*cols[:-1])
        theta, r, q, _ = one.solve(x, ops)
        phi = 2 * ops.atan(r.S / (r.H + q)) / one.k
        return -gap(getattr(one, "open", one), cols[-1], theta, phi, ops)

    sub, number = take(row, lane), j.astype(float)
    with np.errstate(all="ignore"):
        x = first_zero(at, a, b, (*sub, number))
        pt = sub.point(x, "edge", ARRAY)
        on = on_edges(getattr(sub, "open", sub), number, pt.theta, pt.load)
    for n in np.flatnonzero(on):
        if x[n] < found.x[lane[n]]:
            found.x[lane[n]], found.k[lane[n]] = x[n], j[n]
    return found


def _crossed(row: Any, x0: Array, x_end: Array, steps: Array) -> Array:
    """Design, neighbour and sample before every crossing of the lines of another neighbour's tip-side pair."""
    pair = getattr(row, "open", row)
    far = _farthest(pair)
    rows = [np.empty((3, 0), np.int64)]
    with np.errstate(all="ignore"):
        theta, r, q, _ = row.solve(x0 + (x_end - x0) * steps[:, None], ARRAY)
        phi = 2 * np.arctan(r.S / (r.H + q)) / pair.k
        if (pair.k != 1).any():
            r = pair._replace(k=1.0).root(theta, ARRAY)
        # j F_j is linear in j, and cos(j phi), sin(j phi) follow from cos(phi), sin(phi)
        lean = pair.sa * pair.ca * r.cs
        H, S2, half = r.H + lean, r.S, r.G / 2
        near = reach_at(pair, r.cs)
        near = np.maximum(near[1:], near[:-1])
        c1, s1 = np.cos(phi), np.sin(phi)
        c, s = c1, s1
        for j in range(1, int(far.max(initial=1.0)) + 1):
            met = (half - j * S2) * c + (H - j * lean) * s >= half
            rising = (met[1:] > met[:-1]) & ((pair.k != j) & (j <= near))
            if rising.any():
                i, lane = np.nonzero(rising)
                rows.append(np.stack([lane, np.full(lane.size, j), i]))
            c, s = c * c1 - s * s1, s * c1 + c * s1
    return np.concatenate(rows, axis=1)

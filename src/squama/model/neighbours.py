"""Tip-side contacts of all neighbours: which is met first, and which comes in along a path.

Neighbour k obeys the same contact condition with eta/k, beta/k, lam/k and k phi (docs, theory: geometry).
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple, Self

import numpy as np

from squama.model import twisting
from squama.model.paths import ARRAY, FLOAT, NEXT, FoldedTwist, Ops, Twist
from squama.model.solve import FEW, Array, blocks, first_zero, take
from squama.model.tape import Tape, kept

SAMPLES = 13
"""Samples of an open path at which other neighbours are looked for."""
FOLDED_SAMPLES = 41
"""The same for a folded path, on which the twist grows large and farther neighbours come and go."""
CLEAR, FOLDED_CLEAR = 5, 13
"""Samples that show for most designs that no other neighbour comes near."""
NEAR = 7
"""Neighbours from which on that quick look is not made."""
AWAY = 0.5
"""Part of the bend seen in three samples that a condition must be away from zero by (a parabola needs an eighth)."""


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


def first_engagement(row: Twist) -> tuple[Array, Array]:
    """Return the neighbour that is met first and its engagement twist; k = 0 and inf where there is none."""
    n = row.eta.size
    k, best = np.zeros(n, np.int64), np.full(n, np.inf)
    far = _farthest(row)
    order = _by_reach(far)
    for p in blocks(n):
        lanes = order[p]
        part = take(row, lanes)
        number = np.arange(1.0, far[lanes].max() + 1)[:, None]
        with np.errstate(all="ignore"):
            upright, phi = _meetings()(np.broadcast_to(number, (number.size, lanes.size)), *part[:-1])
        phi = np.where((upright > 0) & (number <= far[lanes]), phi, np.inf)
        phi[np.isnan(phi)] = np.inf
        first, wrong = phi.argmin(axis=0), np.arange(lanes.size)
        with np.errstate(all="ignore"):
            if n > FEW:
                # the lines that meet first are those of the contact if they do so on both edges, as they mostly do
                wrong = np.flatnonzero(_within()(first + 1.0, *part[:-1])[0] == 0)
            # where they do not, all neighbours are asked
            on = _within()(np.broadcast_to(number, (number.size, wrong.size)), *take(part, wrong)[:-1])[0]
        phi[:, wrong] = np.where(on > 0, phi[:, wrong], np.inf)
        first[wrong] = phi[:, wrong].argmin(axis=0)
        best[lanes] = phi[first, np.arange(lanes.size)]
        k[lanes] = np.where(np.isfinite(best[lanes]), first + 1, 0)
    return k, best


def _by_reach(far: Array) -> Array:
    """Order of designs by their reach; short numbers are sorted much faster."""
    return np.argsort(far.astype(np.int16), kind="stable")


@kept
def _meetings() -> Tape:
    def meetings(k: Any, *columns: Any) -> tuple[Any, Any]:
        r, q, phi = meeting(Twist(*columns)._replace(k=k), ARRAY)
        return r.H + q, phi

    return Tape(meetings, len(Twist._fields) - 1)


@kept
def _within() -> Tape:
    def on_both(k: Any, *columns: Any) -> tuple[Any]:
        row = Twist(*columns)._replace(k=k)
        return (within(row, *meeting(row, ARRAY)[:2]),)

    return Tape(on_both, len(Twist._fields) - 1)


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
    bent = isinstance(row, FoldedTwist)
    steps = np.linspace(0.0, 1.0, FOLDED_SAMPLES if bent else SAMPLES)
    # in order of reach, so that few designs are asked for neighbours they do not have
    far = _farthest(row)
    order = _by_reach(far)
    if x0.size > FEW:
        few = np.linspace(0.0, 1.0, FOLDED_CLEAR if bent else CLEAR)
        quick = ((far < NEAR) & (row.k == 1))[order]
        asked, near = order[quick], ~quick
        clear = [
            _clear(take(row, asked[p]), far[asked[p]], x0[asked[p]], x_end[asked[p]], few) for p in blocks(asked.size)
        ]
        near[quick] = ~np.concatenate([np.zeros(0, bool), *clear])
        order = order[near]
    parts = [np.empty((3, 0), np.int64)]
    for p in blocks(order.size):
        lanes = order[p]
        lane, j, i = _crossed(take(row, lanes), far[lanes], x0[lanes], x_end[lanes], steps)
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


class _Lines(NamedTuple):
    """What the contact conditions of all neighbours along paths are made of; ``near`` is how far the tips reach."""

    H: Any
    S: Any
    lean: Any
    half: Any
    c: Any
    s: Any
    near: Any

    @classmethod
    def of(cls, row: Any, pair: Twist, x: Any) -> Self:
        """Lines at path parameters of a twisting row, and of the same without its fold."""
        theta, r, q, _ = row.solve(x, ARRAY)
        u = r.S / (r.H + q)
        if pair.k is not NEXT:
            u = np.tan(np.arctan(u) / pair.k)
            r = pair._replace(k=NEXT).root(theta, ARRAY)
        w = 1 / (1 + u * u)
        lean = pair.sa * pair.ca * r.cs
        return cls(r.H + lean, r.S, lean, r.G / 2, (1 - u * u) * w, 2 * u * w, reach_at(pair, r.cs))

    def walk(self, many: int) -> Iterator[tuple[int, Any]]:
        """Neighbours 1 to ``many``, each with its condition times j: it is linear in j but for cos and sin of j phi."""
        c, s = self.c, self.s
        for j in range(1, many + 1):
            yield j, (self.half - j * self.S) * c + (self.H - j * self.lean) * s - self.half
            c, s = c * self.c - s * self.s, s * self.c + c * self.s


@kept
def _lines(kind: type[Any]) -> Tape:
    def lines(x: Any, *columns: Any) -> _Lines:
        row = kind(*columns)
        return _Lines.of(row, row.open if kind is FoldedTwist else row, x)

    return Tape(lines, len(kind._fields))


@kept
def _conditions(kind: type[Any], many: int) -> Tape:
    def conditions(x: Any, *columns: Any) -> list[Any]:
        row = kind(*columns)
        lines = _Lines.of(row, row.open if kind is FoldedTwist else row, x)
        return [lines.near, *(F for j, F in lines.walk(many) if j > 1)]

    return Tape(conditions, len(kind._fields) - 1)


def _clear(row: Any, far: Array, x0: Array, x_end: Array, steps: Array) -> Array:
    """Whether no other neighbour comes near: the conditions stay below zero by more than they bend.

    For paths that follow the next neighbour.
    """
    clear, many = np.ones(x0.size, bool), int(far.max())
    with np.errstate(all="ignore"):
        near, *every = _conditions(type(row), many)(x0 + (x_end - x0) * steps[:, None], *row[:-1])
        near = np.maximum(np.maximum(near[2:], near[1:-1]), near[:-2])
        for j, F in enumerate(every, 2):
            a, b, c = F[:-2], F[1:-1], F[2:]
            away = np.maximum(np.maximum(a, b), c) < -AWAY * abs(c - 2 * b + a)
            clear &= (away | (near < j)).all(axis=0)
    return clear


def _crossed(row: Any, far: Array, x0: Array, x_end: Array, steps: Array) -> Array:
    """Design, neighbour and sample before every crossing of the lines of another neighbour's tip-side pair."""
    rows, k = [np.empty((3, 0), np.int64)], row.k
    with np.errstate(all="ignore"):
        lines = _Lines(*_lines(type(row))(x0 + (x_end - x0) * steps[:, None], *row))
        near = np.maximum(lines.near[1:], lines.near[:-1])
        for j, F in lines.walk(int(far.max(initial=1.0))):
            met = F >= 0
            rising = (met[1:] > met[:-1]) & ((k != j) & (j <= near))
            if rising.any():
                i, lane = np.nonzero(rising)
                rows.append(np.stack([lane, np.full(lane.size, j), i]))
    return np.concatenate(rows, axis=1)

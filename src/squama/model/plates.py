"""Other contacts of the rigid plates: edges on edges and corners on faces of all overlapping scales.

Scale 1 and scale 1 + k are rectangles (thick ones: ``squama.model.boxes``); in the axes of scale 1 scale 1 + k has
the base midpoint o and the axes k_IJ.

Each of the 24 feature pairs has a signed distance that changes sign when the features meet; a change counts if the
features meet within both of them. Along a path the first such change is the first other contact.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from squama.model import boxes
from squama.model.screw import Screw, dot
from squama.types import Array

CORNERS = ("D", "A", "C", "B")
EDGES = ("DA", "CB", "DC", "AB")
_MIRRORED_CORNERS = ("A", "D", "B", "C")
_MIRRORED_EDGES = ("DA", "CB", "AB", "DC")
_KIND = {"DA": "base edge", "CB": "tip edge", "DC": "side edge", "AB": "side edge"}
TIP_SIDE = 8 + 4 * EDGES.index("CB") + EDGES.index("DC")
CORNER_FACE = 4 + CORNERS.index("B")
"""Index among the feature pairs of the tip's corner B on the face; TIP_SIDE is that of the tip edge on the side edge.
"""
_ROUNDS = 4
_PARALLEL = 1e-10
_FINER, _PARTS = 2, np.arange(1, 8) / 8
"""Number of refinements where gaps have a minimum near zero, and the added places in an interval."""


class Touch(NamedTuple):
    """First other contact: neighbour ``k``, ``pair`` in words, path parameter, inclination, larger load angle (rad)."""

    k: int
    pair: str
    x: float
    theta: float
    phi: float


class Plates(NamedTuple):
    """Shape of the scales: ratios with lengths in pitches, sine and cosine of alpha; ``y_n`` for bent beams."""

    eta: float
    beta: float
    lam: float
    sa: float
    ca: float
    thickness: float = 0.0
    y_n: float = 0.0

    @property
    def reach(self) -> int:
        """Farthest neighbour within reach."""
        return max(1, int(np.hypot(np.hypot(self.eta, 2 * self.beta), self.thickness)))


def axes(plates: Plates, theta: Array, phi: Array, k: Array) -> tuple[Array, Array]:
    """Return base midpoints (3, n, m) and axes (3, 3, n, m; columns) of scales 1 + k in the axes of scale 1.

    ``phi`` are twists (m,), or bends and twists (2, m), in rad per pitch.
    """
    if phi.ndim == 2:
        return _screwed(plates, theta, phi, k)
    lam, sa, ca, k = plates.lam, plates.sa, plates.ca, k[:, None]
    st, ct = np.sin(theta), np.cos(theta)
    S, C1 = np.sin(k * phi), -2 * np.sin(k * phi / 2) ** 2
    z = np.stack([ca * ct, sa + 0 * ct, -ca * st])
    # k_IJ = cos + (1 - cos) z_I z_J, and the turn about z (clockwise) in the off-diagonal terms
    M = -C1 * (z[:, None, None] * z[None, :, None])
    M += np.eye(3)[:, :, None, None] * (1 + C1)
    for i, j, m in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        M[i, j] += S * z[m]
        M[j, i] -= S * z[m]
    o = lam * np.stack([S * (-sa * ct) + C1 * st, S * ca + 0 * C1 * st, S * (sa * st) + C1 * ct]) + k * z[:, None]
    return o, M


def _screwed(plates: Plates, theta: Array, loads: Array, k: Array) -> tuple[Array, Array]:
    """Return the base midpoints and axes of :func:`axes` for beams that are bent and twisted."""
    k = k[:, None]
    one = np.ones((k.size, theta.size))
    g = Screw.of(k * loads[0], k * loads[1], plates.y_n / k * one)
    g = g._replace(v=k * g.v)
    st, ct, zero, sa, ca = np.sin(theta) * one, np.cos(theta) * one, 0 * one, plates.sa * one, plates.ca * one
    own = [np.array(v) for v in ((-sa * ct, st, ca * ct), (ca, zero, sa), (sa * st, ct, -ca * st))]
    other = [g.turned(v) for v in own]
    up = np.array([zero, plates.lam * one, zero])
    away = g.turned(up) + g.shift - up
    return np.array([dot(away, v) for v in own]), np.array([[dot(v, u) for u in other] for v in own])


def gaps(plates: Plates, theta: Array, phi: Array, k: Array) -> tuple[Array, Array]:
    """Return the signed gaps of the 24 feature pairs and whether their meeting place lies within both features.

    At inclinations and twists per pitch (m,), or bends and twists (2, m), for neighbours k (n,). Both have the shape
    (24, n, m): 4 corners of the other scale on the face of scale 1, 4 corners of scale 1 on the other face, 16 edges on
    edges (of scale 1 first). For thick plates the gaps are those of :func:`squama.model.boxes.gaps`, (5, n, m).
    """
    o, M = axes(plates, theta, phi, k)
    if plates.thickness > 0:
        apart = boxes.gaps((plates.eta / 2, plates.beta, plates.thickness / 2), o, M)
        return apart, np.ones(apart.shape, bool)
    eta, beta = plates.eta, plates.beta
    corners = np.array([[0.0, 0.0, eta, eta], [-beta, beta, -beta, beta], [0.0] * 4])[:, :, None, None]
    # where features meet at a corner, rounding must not let all of them miss
    tol = 1e-9 * (eta + beta)
    # corners of the other scale in the axes of scale 1, and the other way round
    theirs = o[:, None] + corners[0] * M[:, None, 0] + corners[1] * M[:, None, 1]
    ours = (M[:, :, None] * (corners - o[:, None])[:, None]).sum(axis=0)
    x, y, h = np.concatenate([theirs, ours], axis=1)
    gap, inside = [h], [(x >= -tol) & (x <= eta + tol) & (abs(y) <= beta + tol)]
    # edges of the other scale: a point on the axis through the middle, direction, range of the place along it
    Q = np.stack([o, o + eta * M[:, 0], o - beta * M[:, 1], o + beta * M[:, 1]], axis=1)
    d = M[:, (1, 1, 0, 0)]
    low = np.array([-beta, -beta, 0.0, 0.0])[:, None, None] - tol
    high = np.array([beta, beta, eta, eta])[:, None, None] + tol
    for e, at in enumerate((0.0, eta, -beta, beta)):
        across, along = (0, 1) if e < 2 else (1, 0)
        off, da = Q[across] - at, d[across]
        square = da * da + d[2] * d[2] + 1e-300
        gap.append((off * d[2] - Q[2] * da) / np.sqrt(square))
        w = -(off * da + Q[2] * d[2]) / square
        v = Q[along] + w * d[along]
        within = abs(v) <= beta + tol if e < 2 else (v >= -tol) & (v <= eta + tol)
        # where lines become parallel the gap changes sign without a meeting
        inside.append((w >= low) & (w <= high) & within & (square > _PARALLEL))
    return np.concatenate(gap), np.concatenate(inside)


def name(pair: int, k: int, mirrored: bool) -> str:
    """Return a feature pair in words, with the paper's corner letters (mirrored in the other sense)."""
    corners, edges = (CORNERS, EDGES) if not mirrored else (_MIRRORED_CORNERS, _MIRRORED_EDGES)

    def edge(i: int, scale: int) -> str:
        return f"{_KIND[edges[i]]} {edges[i][0]}{scale}{edges[i][1]}{scale}"

    other = 1 + k
    if pair < 8:
        corner, face = (other, 1) if pair < 4 else (1, other)
        return f"corner {corners[pair % 4]}{corner} on the face of scale {face}"
    return f"{edge((pair - 8) // 4, 1)} on {edge((pair - 8) % 4, other)}"


def first_touch(
    plates: Plates,
    at: Callable[[Array], tuple[Array, Array]],
    x: Array,
    *,
    follows: int,
    mirrored: bool = False,
    own: Sequence[int] = (TIP_SIDE,),
) -> Touch | None:
    """Return the first contact that comes in along a path, other than the followed one; None if there is none.

    ``at`` returns inclination and twist (or bend and twist) at path parameters; ``x`` are samples, ascending from a
    small positive twist; ``follows`` is the neighbour in contact from x = 0 on, 0 for none; ``own`` are the feature
    pairs of that contact.
    """
    k = np.arange(1, plates.reach + 1)
    best: tuple[float, int, int] | None = None
    x, gap, inside = _seen(plates, at, x, k, follows, own)
    for i, n, j in _changes(gap, inside):
        if best is not None and x[j] > best[0]:
            continue
        hit = _refine(plates, at, float(x[j]), float(x[j + 1]), int(k[n]), i)
        if hit is not None and (best is None or hit < best[0]):
            best = hit, i, int(k[n])
    if best is None:
        return None
    theta, phi = at(np.array([best[0]]))
    words = _words(plates, theta, phi, best[1], best[2], mirrored)
    return Touch(best[2], words, best[0], float(theta[0]), float(np.abs(phi).max()))


def _words(plates: Plates, theta: Array, phi: Array, pair: int, k: int, mirrored: bool) -> str:
    if plates.thickness == 0:
        return name(pair, k, mirrored)
    o, M = axes(plates, theta, phi, np.array([k]))
    half = (plates.eta / 2, plates.beta, plates.thickness / 2)
    return boxes.name(half, o[:, 0, 0], M[:, :, 0, 0], pair, k, mirrored)


def _seen(
    plates: Plates, at: Callable[[Array], tuple[Array, Array]], x: Array, k: Array, follows: int, own: Sequence[int]
) -> tuple[Array, Array, Array]:
    """Return samples, gaps and whether they count, with more samples where a gap has a minimum near zero."""
    for finer in range(_FINER + 1):
        gap, inside = gaps(plates, *at(x), k)
        if plates.thickness > 0:
            boxes.leave_out(gap, follows, x >= 0)
        elif follows:
            gap[list(own), follows - 1] = 1.0
        near = _turns(gap, inside) if finer < _FINER and x.size > 2 else np.empty(0, int)
        if not near.size:
            break
        low = np.union1d(near, near + 1)
        x = np.union1d(x, x[low] + np.outer(_PARTS, x[low + 1] - x[low]))
    return x, gap, inside


def _turns(gap: Array, inside: Array) -> Array:
    """Return the indices of samples before a minimum of a gap whose parabola falls to half of it or less."""
    left, middle, right = np.abs(gap[..., :-2]), np.abs(gap[..., 1:-1]), np.abs(gap[..., 2:])
    above = gap > 0
    turns = (above[..., :-2] == above[..., 1:-1]) & (above[..., 1:-1] == above[..., 2:])
    turns &= (middle <= left) & (middle < right) & (middle > _PARALLEL)
    turns &= inside[..., :-2] | inside[..., 1:-1] | inside[..., 2:]
    turns &= (right - left) ** 2 > 4 * middle * (right + left - 2 * middle)
    return np.unique(np.argwhere(turns)[:, 2])


def _changes(gap: Array, inside: Array) -> list[tuple[int, int, int]]:
    """Return feature pair, neighbour and sample before each change of sign near both features, in path order."""
    change = (gap[..., :-1] > 0) != (gap[..., 1:] > 0)
    change &= inside[..., :-1] | inside[..., 1:]
    found = np.argwhere(change)
    return [(int(i), int(n), int(j)) for i, n, j in found[np.argsort(found[:, 2], kind="stable")]]


def _refine(
    plates: Plates, at: Callable[[Array], tuple[Array, Array]], a: float, b: float, k: int, i: int
) -> float | None:
    """Return the path parameter of a change of sign by repeated subdivision; None if the features miss."""
    for _ in range(_ROUNDS):
        x = np.linspace(a, b, 33)
        gap = gaps(plates, *at(x), np.array([k]))[0][i, 0]
        j = int(np.argmax((gap[:-1] > 0) != (gap[1:] > 0)))
        a, b, g0, g1 = float(x[j]), float(x[j + 1]), gap[j], gap[j + 1]
    root = a + (b - a) * float(g0 / (g0 - g1)) if g0 != g1 else a
    inside = gaps(plates, *at(np.array([root])), np.array([k]))[1][i, 0, 0]
    return root if inside else None

"""Do two rigid rectangles intersect, and which features touch first? In doubles, by chords.

Each rectangle cuts the other's plane in a chord; both chords lie on the line common to the two planes, and
the plates intersect where the chords overlap. The ends of the overlap, when it is born, name the features.
No sign change of a contact function is looked for.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from squama.types import Array

EDGES = ("DA", "AB", "BC", "CD")
"""Edges in the order of the corners D, A, B, C (base, side A, tip, side D)."""
CORNERS = "DABC"
OPEN = 2e-8
"""The followed pair is looked at with theta larger by this: just apart, so that only other contacts show."""


@dataclass(frozen=True)
class First:
    """First contact: scale 1 with scale 1 + k.

    pair: ("edge-edge", edge of scale 1, edge of scale 1 + k), ("corner-face", corner of scale 1, "face"),
    or ("corner-face", "face", corner of scale 1 + k); edges DA (base), AB, BC (tip), CD.
    """

    k: int
    pair: tuple[str, str, str]
    theta: float
    phi: float
    index: float


def corners(eta: float, beta: float, lam: float, alpha: float, theta: Array, phi: Array, j: int) -> Array:
    """Corners D, A, B, C of scale 1 + j at every sample: shape (n, 4, 3)."""
    ca, sa, ct, st = np.cos(alpha), np.sin(alpha), np.cos(theta), np.sin(theta)
    x = np.stack([-sa * ct, st, ca * ct], axis=-1)
    y = np.array([ca, 0.0, sa])
    o = np.array([0.0, lam, 0.0])
    rows = [o - beta * y + 0 * x, o + beta * y + 0 * x, o + beta * y + eta * x, o - beta * y + eta * x]
    flat = np.stack(rows, axis=-2)
    c, s = np.cos(j * phi), np.sin(j * phi)
    zero, one = np.zeros_like(c), np.ones_like(c)
    turn = np.stack([np.stack([c, s, zero], -1), np.stack([-s, c, zero], -1), np.stack([zero, zero, one], -1)], axis=-2)
    out: Array = np.einsum("nij,ncj->nci", turn, flat)
    out[..., 2] += j
    return out


def chord(plate: Array, other: Array, line: Array) -> tuple[Array, Array, NDArray[np.int64], NDArray[np.int64]]:
    """Where `plate` cuts the plane of `other`: interval (lo, hi) along `line`, and the edges it ends on.

    No cut: lo = inf, hi = -inf.
    """
    normal = np.cross(other[:, 1] - other[:, 0], other[:, 3] - other[:, 0])
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    height = np.einsum("ncj,nj->nc", plate - other[:, :1], normal)
    nxt = np.roll(height, -1, axis=1)
    cut = (height > 0) != (nxt > 0)
    with np.errstate(divide="ignore", invalid="ignore"):
        w = np.where(cut, height / (height - nxt), 0.0)
    spot = plate + w[..., None] * (np.roll(plate, -1, axis=1) - plate)
    along = np.einsum("ncj,nj->nc", spot, line)
    low, high = np.where(cut, along, np.inf), np.where(cut, along, -np.inf)
    i_low, i_high = low.argmin(axis=1), high.argmax(axis=1)
    return low.min(axis=1), high.max(axis=1), i_low, i_high


def overlap(one: Array, two: Array) -> tuple[Array, list[tuple[tuple[int, int], tuple[int, int]]]]:
    """Length of the common chord (negative: apart), and its two ends as (plate, edge)."""
    n1 = np.cross(one[:, 1] - one[:, 0], one[:, 3] - one[:, 0])
    n2 = np.cross(two[:, 1] - two[:, 0], two[:, 3] - two[:, 0])
    line = np.cross(n1, n2)
    size = np.linalg.norm(line, axis=-1, keepdims=True)
    line = line / np.where(size > 0, size, 1.0)
    lo1, hi1, a1, b1 = chord(one, two, line)
    lo2, hi2, a2, b2 = chord(two, one, line)
    length = np.minimum(hi1, hi2) - np.maximum(lo1, lo2)
    length = np.where(np.isfinite(length), length, -1e9)
    if len(length) > 1:
        return length, []
    first = (0, int(a1[0])) if lo1[0] > lo2[0] else (1, int(a2[0]))
    last = (0, int(b1[0])) if hi1[0] < hi2[0] else (1, int(b2[0]))
    return length, [(first, last)]


def _name(ends: tuple[tuple[int, int], tuple[int, int]]) -> tuple[str, str, str]:
    (p, e), (q, f) = ends
    if p != q:
        first, second = (e, f) if p == 0 else (f, e)
        return ("edge-edge", EDGES[first], EDGES[second])
    if abs(e - f) == 2:
        return ("edge-face", EDGES[e], EDGES[f])
    corner = CORNERS[max(e, f)] if abs(e - f) == 1 else CORNERS[0]
    return ("corner-face", corner, "face") if p == 0 else ("corner-face", "face", corner)


def first_contact(
    eta: float,
    beta: float,
    lam: float,
    alpha: float,
    theta0: float,
    path: ArrayLike,
    skip_tip_side: int | None = None,
    kmax: int | None = None,
) -> First | None:
    """First contact of any two rectangles along `path`, a dense list of (theta, phi), or None.

    alpha < 0 is the other sense of twist (phi stays positive). The path should start at (theta0, 0), come
    up to engagement and go on along the contact curve; it is read between its points by cubics.
    `skip_tip_side` is the followed k, whose tip edge always touches: that pair is looked at with theta
    larger by OPEN (phi is then right to about 1e-7). Its only other contacts come where the tip edge comes to
    lie in the face of scale 1 + k, or the side edge of that in the face of scale 1.
    """
    pts = np.asarray(path, dtype=float)
    if abs(pts[0, 0] - theta0) > 1e-9 and abs(pts[0, 1]) > 0:
        msg = "the path must start at theta0 or at phi = 0"
        raise ValueError(msg)
    top = kmax or int(np.ceil(2 * np.hypot(eta, beta)))
    best: First | None = None
    for k in range(1, top + 1):
        opened = OPEN if k == skip_tip_side else 0.0
        last = len(pts) if best is None else min(len(pts), int(best.index) + 2)
        found = _first(eta, beta, lam, alpha, pts[:last], k, opened)
        if found is not None and (best is None or found.index < best.index):
            best = found
    return best


def _first(eta: float, beta: float, lam: float, alpha: float, pts: Array, k: int, opened: float) -> First | None:
    def length(at: Array) -> tuple[Array, list[tuple[tuple[int, int], tuple[int, int]]]]:
        t, q = np.ascontiguousarray(at[:, 0]) + opened, np.ascontiguousarray(at[:, 1])
        return overlap(corners(eta, beta, lam, alpha, t, q, 0), corners(eta, beta, lam, alpha, t, q, k))

    hit = np.flatnonzero(length(pts)[0] > 0)
    if not len(hit):
        return None
    i = int(hit[0])
    if i == 0:
        return First(k, _name(length(pts[:1])[1][0]), float(pts[0, 0]), float(pts[0, 1]), 0.0)
    lo, hi = i - 1.0, float(i)
    for _ in range(44):
        mid = 0.5 * (lo + hi)
        if length(between(pts, mid)[None])[0][0] > 0:
            hi = mid
        else:
            lo = mid
    at = between(pts, hi)
    return First(k, _name(length(at[None])[1][0]), float(at[0]), float(at[1]), hi)


def between(pts: Array, x: float) -> Array:
    """Point at fractional index x: cubic of the smoothest four points about it (the path has a corner)."""
    i = min(max(int(x), 0), len(pts) - 2)
    starts = [j for j in (i - 1, i - 2, i) if j >= 0 and j + 4 <= len(pts)]
    if not starts:
        flat: Array = pts[i] + (x - i) * (pts[i + 1] - pts[i])
        return flat
    start = min(starts, key=lambda j: float(np.abs(np.diff(pts[j : j + 4], n=3, axis=0)).max()))
    w = x - start
    weights = [
        -(w - 1) * (w - 2) * (w - 3) / 6,
        w * (w - 2) * (w - 3) / 2,
        -w * (w - 1) * (w - 3) / 2,
        w * (w - 1) * (w - 2) / 6,
    ]
    cubic: Array = np.asarray(weights) @ pts[start : start + 4]
    return cubic

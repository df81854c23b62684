"""From ratios to ends: engagement, the path of the pair that is met first, its end; twisting and bending."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from squama.model import neighbours
from squama.model.bending import Bend
from squama.model.ends import Track, half_turn, track
from squama.model.outcome import CODES, End
from squama.model.paths import ARRAY, Twist
from squama.model.plates import TIP_SIDE, Plates, Touch, first_touch, name
from squama.model.solve import Array, scalar, take

TOUCH_SAMPLES = 41
"""Samples at which the plates are tested against each other along a path."""
REST_SAMPLES = 24
"""The same before engagement."""
SEARCH = math.pi / 2
"""Twist per pitch up to which plates that do not engage are looked at, unless a range is asked."""


class Solution(NamedTuple):
    """Ends of n designs (arrays), and the tracks that lead there, grouped by row.

    ``load_e`` engagement load angle per pitch (inf where there is none), ``theta_end``, ``load_end``, ``code`` of the
    end, ``neighbour`` followed (0 for none), ``crossing`` neighbour whose tip-side contact came in (0 for none).
    """

    load_e: Array
    theta_end: Array
    load_end: Array
    code: Array
    neighbour: Array
    crossing: Array
    tracks: list[tuple[Array, Track]]


def _collect(theta0: Array, load_e: Array, k: Array, engaged: Array, found: list[tuple[Array, Track]]) -> Solution:
    code = np.full(k.size, CODES.index(End.NONE), np.int8)
    theta_end, load_end = theta0.astype(float), np.full(k.size, np.inf)
    crossing = np.zeros(k.size, np.int64)
    tracks = []
    for local, t in found:
        index = engaged[local]
        at_start = t.x_end == t.x0
        load_end[index] = np.where(at_start, load_e[index], t.load_end)
        theta_end[index] = np.where(at_start, theta0[index], t.row.theta(t.x_end))
        code[index], crossing[index] = t.code, t.crossing
        tracks.append((index, t))
    return Solution(load_e, theta_end, load_end, code, np.where(np.isfinite(load_e), k, 0), crossing, tracks)


def solve_twisting(
    eta: Array, beta: Array, lam: Array, alpha: Array, theta0: Array, mu: Array, *, law: str, sense: str
) -> Solution:
    """Follow the tip-side contact that is met first in each design (1-D arrays of one length, radians)."""
    sa = np.sin(alpha) * (1 if sense == "+" else -1)
    row = Twist(eta, beta, lam, sa, np.cos(alpha), theta0, np.ones_like(eta))
    k, phi_e = neighbours.first_engagement(row)
    engaged = np.flatnonzero(k)
    found: list[tuple[Array, Track]] = []
    if engaged.size:
        sub = take(row._replace(k=k.astype(float)), engaged)
        found = track(sub, half_turn(engaged.size), mu[engaged], law)
    return _collect(theta0, phi_e, k, engaged, found)


def solve_bending(eta: Array, theta0: Array, mu: Array) -> Solution:
    """Follow the tip-on-face contact of each design (1-D arrays of one length, radians)."""
    row = Bend(eta, theta0)
    psi = row.point(theta0, "edge", ARRAY).load
    engaged = np.flatnonzero(eta >= 1)
    psi_e = np.where(eta >= 1, psi, np.inf)
    found = track(take(row, engaged), np.full(engaged.size, math.pi / 2), mu[engaged], "edge") if engaged.size else []
    return _collect(theta0, psi_e, np.ones(eta.size, np.int64), engaged, found)


def touch(plates: Plates, theta0: float, limit: float, t: Track | None, i: int, *, mirrored: bool) -> Touch | None:
    """First contact of the plates other than the followed one: at rest up to the twist ``limit``, then on the path.

    Parameters
    ----------
    t, i
        Track and the design's place in it; None for a design that does not engage.
    """
    row: Any = None if t is None else scalar(t.row, i)
    x0, x_end = (0.0, 0.0) if t is None else (float(t.x0[i]), float(t.x_end[i]))

    def at(v: Array) -> tuple[Array, Array]:
        # v runs from -1 to 0 at rest and from 0 to 1 on the path
        rest = v < 0
        theta, phi = np.full(v.size, theta0), limit * (1 + v) ** 2
        if not rest.all():
            pt = row.point(x0 + (x_end - x0) * v[~rest], "edge", ARRAY)
            theta[~rest], phi[~rest] = pt.theta, pt.load
        return theta, phi

    # at the end of an edge the corner itself touches: that is the end, not another contact
    on_path = np.linspace(0.0, 1 - 1e-9, TOUCH_SAMPLES) if x_end > x0 else np.empty(0)
    v = np.concatenate([[-1 + 1e-5], np.linspace(-1, -1e-9, REST_SAMPLES)[1:], on_path])
    return first_touch(plates, at, v, follows=0 if row is None else int(row.k), mirrored=mirrored)


def with_touches(
    sol: Solution, plates: list[Plates], theta0: Array, *, mirrored: bool
) -> tuple[Solution, list[Touch | None]]:
    """Cut every path at the first contact of any pair of plates; return the contacts too (None for none)."""
    touches: list[Touch | None] = [None] * theta0.size
    theta_end, load_end, code = sol.theta_end.copy(), sol.load_end.copy(), sol.code.copy()
    places: dict[int, tuple[Track, int]] = {int(i): (t, n) for index, t in sol.tracks for n, i in enumerate(index)}
    for i in range(theta0.size):
        t, n = places.get(i, (None, 0))
        limit = float(sol.load_e[i]) if t else SEARCH
        touches[i] = hit = touch(plates[i], float(theta0[i]), limit, t, n, mirrored=mirrored)
        if hit is None or t is None:
            continue
        theta_end[i], load_end[i], code[i] = hit.theta, hit.phi, CODES.index(End.OTHER)
        t.x_end[n] = t.x0[n] + (t.x_end[n] - t.x0[n]) * max(hit.x, 0.0)
        t.load_end[n] = hit.phi
    return sol._replace(theta_end=theta_end, load_end=load_end, code=code), touches


def other_words(sol: Solution, touches: list[Touch | None], i: int, *, mirrored: bool) -> str:
    """Pair that ends the path of design ``i`` or touches instead; "" for none."""
    hit = touches[i] if touches else None
    if hit is not None:
        return f"{hit.pair} (k = {hit.k})"
    k = int(sol.crossing[i])
    return f"{name(TIP_SIDE, k, mirrored)} (k = {k})" if k else ""

"""Solutions for arrays of ratios on hinges: engagement, path and end of the first contact, in twisting and bending."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from squama.batch import Solved
from squama.batch.answers import answers
from squama.loads import LOADS
from squama.model.bending import Bend
from squama.model.evaluation import BENT, FOLDED, OPEN
from squama.model.follow import TURNED, UPRIGHT
from squama.model.outcome import CODES, End
from squama.model.paths import ARRAY, FoldedTwist
from squama.model.plates import CORNER_FACE, TIP_SIDE, Plates, Touch, first_touch, name
from squama.model.reach import SEARCH
from squama.model.tracks import OneRow, Track, scalar, take
from squama.types import Array

COLUMNS = ("eta", "beta", "lam", "alpha", "theta0", "mu")
"""Arguments of the contact in the order of the solver."""
TOUCH_SAMPLES = 121
"""Samples for the search of other contacts on a path up to its fold, if nothing ends it before."""
REST_SAMPLES = 24
"""Samples for the same search before engagement."""
TOUCHING = CODES.index(End.TOUCHING)
SHORT = 1 - 1e-9
"""Share of a path that is searched for other contacts."""


class Solution(NamedTuple):
    """Ends of n designs, and the tracks that lead there, grouped by the kind of row.

    ``found`` is without the beam's own rigidity, and NaN at the cut-off without a margin; ``crossing`` (n,) is the
    neighbour whose tip-side contact came in (0 for none).
    """

    found: Solved
    crossing: Array
    tracks: list[tuple[Array, Track]]

    def one(self, i: int) -> Solution:
        """Return the solution of design ``i`` alone."""
        tracks = [
            (np.zeros(1, int), Track(take(t.row, n), *(v[n] for v in t[1:])))
            for index, t in self.tracks
            if (n := np.flatnonzero(index == i)).size
        ]
        return Solution(Solved._make(v[i : i + 1] for v in self.found), self.crossing[i : i + 1], tracks)

    def sampled(self, points: int) -> tuple[Array, Array]:
        """Return load angle and inclination (n, points), rad, along the path of each design; NaN where it has none."""
        load, theta = np.full((2, self.crossing.size, points), np.nan)
        for index, t in self.tracks:
            x = t.x0 + (t.x_end - t.x0) * np.linspace(0, 1, points)[:, None]
            with np.errstate(all="ignore"):
                pt = t.row.point(x, "edge", ARRAY)
            load[index], theta[index] = pt.load.T, np.broadcast_to(pt.theta, x.shape).T
        return load, theta


def solve(
    columns: Mapping[str, Array], *, load: str = "twisting", law: str, sense: str, margin: float | None = None
) -> Solution:
    """Follow the first contact of each design to its end.

    ``columns`` (n,): eta, beta, lam, alpha, theta0 and mu, in radians, and "thickness" for thick scales; ``margin``:
    fraction of the path left before a lock; None leaves the values at the cut-off out.
    """
    kind = LOADS[load]
    eta, beta, lam, alpha, theta0, mu = (columns[name] for name in COLUMNS)
    ts = columns.get("thickness", np.zeros_like(eta))
    a = answers((eta, beta, lam, alpha, theta0, mu), ts, law=kind.law(law), sense=sense, load=load, margin=margin)
    rows: dict[int, OneRow] = {BENT: Bend(eta, beta, lam, np.sin(alpha), np.cos(alpha), theta0)}
    if kind.sided:
        sa = np.sin(alpha) * (1 if sense == "+" else -1)
        whole = FoldedTwist(eta, beta, lam, sa, np.cos(alpha), theta0, a.theta_f, a.neighbour.astype(float), ts)
        rows = {OPEN: whole.open, FOLDED: whole}
    tracks = []
    for path, row in rows.items():
        index = np.flatnonzero((a.neighbour > 0) & (a.kind == path))
        if index.size:
            ends = (v[index] for v in (a.x0, a.x_end, a.load_end, a.code, a.crossing))
            tracks.append((index, Track(take(row, index), *ends)))
    return Solution(Solved.of(a, theta0), a.crossing, tracks)


def touch(
    plates: Plates,
    theta0: float,
    limit: float,
    t: Track | None,
    i: int,
    *,
    mirrored: bool,
    bent: bool = False,
    ends: Array | tuple[float, ...] = (),
) -> Touch | None:
    """Return the first contact of the plates other than the followed one: up to the twist ``limit``, then on the path.

    ``t``, ``i``: track and the design's index in it, None for a design that does not engage; ``bent``: the load is a
    bend instead of a twist, away from the scales if ``mirrored``; ``ends``: path parameters at which shorter paths end
    that are parts of this one.
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
        return theta, np.array([-phi if mirrored else phi, 0 * phi]) if bent else phi

    on_path = np.empty(0)
    if x_end > x0:
        # places set by the geometry alone; friction only decides how many of them are searched
        last_of_all = -x0 if isinstance(row, FoldedTwist) else UPRIGHT if bent else TURNED
        every = np.linspace(x0, last_of_all, TOUCH_SAMPLES)
        # at the end of an edge the corner itself touches: that is the end, not another contact
        last = SHORT * (np.array([*ends, x_end]) - x0)
        on_path = np.unique([*(every[every - x0 < last[-1]] - x0), *last]) / (x_end - x0)
    v = np.concatenate([[-1 + 1e-5], np.linspace(-1, -1e-9, REST_SAMPLES)[1:], on_path])
    k = 0 if row is None else int(getattr(row, "k", 1))
    own = CORNER_FACE if bent else TIP_SIDE
    return first_touch(plates, at, v, follows=k, mirrored=mirrored and not bent, own=[own])


def with_touches(
    sol: Solution, shapes: Sequence[Array], *, sense: str, load: str = "twisting", alike: bool = False
) -> tuple[Solution, list[Touch | None]]:
    """Cut every path at the first contact of any pair of plates; also return these contacts (None for none).

    ``shapes`` are the columns (n,) eta, beta, lam, alpha, theta0 and, for thick scales, thickness. Edges across a bent
    beam lie flush in each other, so their plates are skipped. Touching is a matter of geometry: if the designs are
    ``alike`` except for friction, which only sets the length of the paths, contacts are found once.
    """
    mirrored, bent = sense == "-", not LOADS[load].sided
    eta, beta, lam, alpha, theta0, *thick = shapes
    thickness = thick[0] if thick else np.zeros_like(eta)
    sa, ca = np.sin(alpha) * (-1 if mirrored and not bent else 1), np.cos(alpha)
    touches: list[Touch | None] = [None] * theta0.size
    found = sol.found
    theta_end, load_end, code = found.theta_end.copy(), found.load_end.copy(), found.code.copy()
    places: dict[int, tuple[Track, int]] = {int(i): (t, n) for index, t in sol.tracks for n, i in enumerate(index)}
    every = list(range(theta0.size))
    for group in [every] if alike else [[i] for i in every]:
        first = group[0]
        if found.code[first] == TOUCHING or (bent and not alpha[first]):
            continue
        shape = Plates(*(float(v[first]) for v in (eta, beta, lam, sa, ca, thickness)))
        rest = float(theta0[first])
        known = [places[i] for i in group if i in places]
        if not known:
            hit = touch(shape, rest, SEARCH, None, 0, mirrored=mirrored, bent=bent)
            for i in group:
                touches[i] = hit
            continue
        # the longest path contains all others; it is sampled wherever they would be
        longest, n = max(known, key=lambda place: float(place[0].load_end[place[1]]))
        row, x0 = take(longest.row, n), longest.x0[n]
        whole = longest.x_end[n] - x0
        ends = [_along(row, t, m) for t, m in known]
        limit = float(found.load_e[first])
        hit = touch(shape, rest, limit, longest, n, mirrored=mirrored, bent=bent, ends=np.array(ends))
        if hit is None:
            continue
        reached = x0 + whole * max(hit.x, 0.0)
        for i, (t, m), x in zip(group, known, ends, strict=True):
            if hit.x > 0 and reached > x0 + (x - x0) * SHORT:
                continue
            touches[i] = hit
            theta_end[i], load_end[i], code[i] = hit.theta, hit.phi, CODES.index(End.OTHER)
            t.x_end[m] = reached if type(t.row) is type(row) else take(t.row, m).parameter(hit.theta, ARRAY)
            t.load_end[m] = hit.phi
    return sol._replace(found=found._replace(theta_end=theta_end, load_end=load_end, code=code)), touches


def _along(row: OneRow, t: Track, m: int) -> float:
    """Return the parameter on the path of ``row`` at which design ``m`` of a track ends; only friction differs."""
    if type(t.row) is type(row):
        return float(t.x_end[m])
    return float(np.asarray(row.parameter(take(t.row, m).theta(t.x_end[m]), ARRAY)))


def other_words(hit: Touch | None, crossing: int, *, mirrored: bool) -> str:
    """Return the other pair that ends a path in words: a contact of plates, or a neighbour's; "" for none."""
    if hit is not None:
        return f"{hit.pair} (k = {hit.k})"
    return f"{name(TIP_SIDE, crossing, mirrored)} (k = {crossing})" if crossing else ""

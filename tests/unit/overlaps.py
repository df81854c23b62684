"""Vertices of the overlap of two plates beside plain geometry by matrices of four rows; not compiled.

Run in a process of its own, with NUMBA_DISABLE_JIT=1; writes what vertices miss. The argument is the number of pairs
of each shape.
"""

import itertools
import json
import math
import sys
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from scipy.linalg import expm
from scipy.optimize import brentq

from squama.contacts import changes, entry, path
from squama.contacts.conditions import MEET, beside_it, slope, value
from squama.contacts.detection import clear, gap_at, span, vertices, view
from squama.contacts.handover import leave
from squama.contacts.meeting import prepared
from squama.contacts.system import EQUAL, UNTIED, corner, high, low, on_edge, spots
from squama.contacts.touch import AT, EE, EF, ENDED, FE, FV, GAP, KIND, ONE, OTHER, STUCK, VF, corner_at
from squama.joints import law

SHAPES = [(2.5, 0.8, 0.5, 0.8, 0.3, 0.1), (3.2, 0.5, 0.4, 0.2, 0.1, 0.04), (1.9, 1.2, 0.6, 1.2, 0.4, 0.06)]
EDGES = {0: (1.0, None), 1: (None, -1.0), 2: (None, 1.0), 3: (0.0, None)}
"""Shares of length and half width at which edges lie: tip, two sides, base."""
EVERY = 1e9


class Pair:
    """Scale 0 over its neighbour, in some attitudes and deflections."""

    def __init__(self, shape: tuple[float, ...], bent: float, seed: int, turns: float) -> None:
        rng = np.random.default_rng(seed)
        self.eta, self.beta, lam, alpha, theta0, self.h = shape
        K = law.stiffness(law.Shape(2.0, lam, 0.3, self.beta, self.h, alpha, theta0, 0.45))
        scale = path.Scale(*np.array([(*shape, 0.05 if bent else np.inf, 0.3)]).T)
        beams = path.beams(scale, K[None], np.zeros(1))
        w = self.w = entry.walk(entry.system(beams, 0, 2, EQUAL, UNTIED), 8, np.zeros(0))
        st = self.st = w.now
        st.q[:], st.strains[:] = turns * rng.standard_normal((2, 6)), 0.05 * rng.standard_normal((1, 4))
        prepared(w.S, st, w.con, 0, True, w.W)
        st.b[:] = bent * rng.standard_normal((2, 24))
        psi, phi, chi, eps = st.strains[0]
        screw = np.array([[0, phi, -chi, 0], [-phi, 0, psi, 0], [chi, -psi, 0, 1 + eps], [0, 0, 0, 0]])
        X = [-np.sin(alpha) * np.cos(theta0), np.sin(theta0), np.cos(alpha) * np.cos(theta0)]
        Y = [np.cos(alpha), 0.0, np.sin(alpha)]
        rest = np.eye(4)
        rest[:3, :3], rest[:3, 3] = np.column_stack([X, Y, np.cross(X, Y)]), (0.0, lam, 0.0)
        self.poses = [expm(i * screw) @ rest @ self.moved(st.q[i]) for i in range(2)]

    @staticmethod
    def moved(q: Any) -> Any:
        """Return the matrix of a scale's motion."""
        out, (x, y, z) = np.eye(4), q[3:]
        out[:3, :3], out[:3, 3] = expm(np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])), q[:3]
        return out

    def lift(self, i: int, x: float, y: float) -> float:
        """Return the deflection of scale i."""
        powers = (x / self.eta) ** np.arange(2, 8), (y / self.beta) ** np.arange(4)
        return float(powers[0] @ self.st.b[i].reshape(6, 4) @ powers[1])

    def seen(self, own: int, x: float, y: float) -> Any:
        """Return a place of the sheet of a scale that faces the other one, in that one's axes."""
        z = self.lift(own, x, y) + (-self.h / 2 if own == 0 else self.h / 2)
        return np.linalg.solve(self.poses[1 - own], self.poses[own] @ (x, y, z, 1.0))[:3]

    def over(self, own: int, x: float, y: float) -> tuple[float, float, float]:
        """Return where a place of the sheet of a scale that faces the other one is on that, and the gap there."""
        side = -1.0 if own == 0 else 1.0
        px, py, pz = self.seen(own, x, y)
        return px, py, -side * (pz - self.lift(1 - own, px, py)) - self.h / 2

    def covers(self, x: float, y: float) -> bool:
        """Whether a place is on a plate."""
        return 0 <= x <= self.eta and abs(y) <= self.beta

    def on_edge(self, edge: int, s: float) -> tuple[float, float]:
        """Return a place on an edge by a share of it."""
        x, y = EDGES[edge]
        return (self.eta * (s if x is None else x), self.beta * (2 * s - 1 if y is None else y))

    def corners(self) -> Iterator[tuple[tuple[int, int, int], float]]:
        """Yield corners over the other plate: what they are, and their gaps."""
        for own in range(2):
            for c, (x, y) in enumerate([(1, -1), (1, 1), (0, -1), (0, 1)]):
                px, py, gap = self.over(own, x * self.eta, y * self.beta)
                if self.covers(px, py):
                    yield ((VF, c, 0) if own == 0 else (FV, 0, c)), gap

    def crossings(self, own: int) -> Iterator[tuple[tuple[int, int, int], float]]:
        """Yield crossings of an edge of a scale with one of the other, seen along that one's normal, and their gaps."""
        grid = np.linspace(0, 1, 41)
        for e in EDGES:
            for f, (x, _) in EDGES.items():
                axis, bound = (0, self.on_edge(f, 0)[0]) if x is not None else (1, self.on_edge(f, 0)[1])
                for s in roots(lambda s, e=e, a=axis, b=bound: self.over(own, *self.on_edge(e, s))[a] - b, grid):
                    px, py, gap = self.over(own, *self.on_edge(e, s))
                    if (abs(py) <= self.beta) if axis == 0 else (0 <= px <= self.eta):
                        yield (EE, e, f), gap

    def least(self, own: int) -> float:
        """Return the least gap along all edges of a scale that are over the other one, at many places."""
        found = (self.over(own, *self.on_edge(e, s)) for e in EDGES for s in np.linspace(0, 1, 81))
        return min((gap for px, py, gap in found if self.covers(px, py)), default=EVERY)

    def told(self, cap: float) -> list[Any]:
        """Return the vertices that the solver finds below a gap."""
        return list(self.w.found[: vertices(self.w.S, self.st, self.w.W, 0, 1, cap, self.w.found, 0)].copy())


def roots(f: Callable[[float], float], grid: Any) -> Iterator[float]:
    """Yield roots between places of a grid."""
    values = [f(s) for s in grid]
    for a, b, va, vb in zip(grid, grid[1:], values, values[1:], strict=False):
        if va * vb < 0:
            yield brentq(f, a, b, xtol=1e-14)


def of_edges(pair: Pair, v: Any) -> float:
    """Return how far a vertex along an edge is from where it should be, and its gap from the least one around."""
    own, one = (0 if v[KIND] == EF else 1), int(v[ONE])
    step = np.array([1e-4, 0.0]) if EDGES[one][0] is None else np.array([0.0, 1e-4])
    at = np.where(step > 0, v[AT + 2], pair.on_edge(one, 0.0))
    px, py, gap = pair.over(own, *at)
    beside = min(pair.over(own, *(at + way * step))[2] for way in (-1, 1))
    return float(abs(gap - v[GAP]) + np.hypot(px - v[AT], py - v[AT + 1]) + max(0.0, gap - beside))


def slopes(pair: Pair, v: Any) -> float:
    """Return how far the least slope inwards along edges is from differences; 1 where the edge is another one."""
    w, st, kind, one, other = pair.w, pair.st, *(int(a) for a in v[[KIND, ONE, OTHER]])
    w.con[0], st.s[0] = (0, 1, kind, one, other, 0, 0), v[AT : AT + 3]
    places = np.reshape(spots(w.S, w.con[0], st.s[0]), (2, 2))
    if kind == EE:
        edges = [(0, one), (1, other)]
    else:
        own, corner = (0, one) if kind == VF else (1, other)
        edges = [(own, 0 if corner < 2 else 3), (own, 1 if corner % 2 == 0 else 2)]
    found = []
    for own, e in edges:
        along = np.array([1.0, 0.0]) if EDGES[e][0] is None else np.array([0.0, 1.0])
        ahead, behind = (pair.seen(own, *(places[own] + s * along)) for s in (1e-5, -1e-5))
        x, y, z = (ahead - behind) / 2e-5
        faced = [pair.lift(1 - own, *(places[1 - own] + s * np.array([x, y]))) for s in (1e-5, -1e-5)]
        rise = (z - (faced[0] - faced[1]) / 2e-5) * (1 if own == 0 else -1)
        middle = along @ ((pair.eta / 2, 0.0) - places[own])
        # to the middle of its own edge or, over an edge of the other plate, onto that
        inwards = (-x, y, -y, x)[one if own else other] if kind == EE else middle
        found.append((rise * np.sign(inwards), e + 4 * own))
    least, edge = slope(w, st, 0)
    return abs(least - min(found)[0]) + float(edge != min(found)[1])


def beside(pair: Pair) -> float:
    """Return how far gaps along the edges at all corners, beside these, are from the least and the largest one."""
    off = 0.0
    for own, c in itertools.product(range(2), range(4)):
        pair.w.con[0], pair.st.s[0] = (0, 1, *((VF, c, 0) if own == 0 else (FV, 0, c)), 0, 0), 0.0
        for e, end in ((0 if c < 2 else 3, c % 2), (1 + c % 2, int(c < 2))):
            places = (pair.over(own, *pair.on_edge(e, abs(end - share))) for share in (0.01, 0.03, 0.1, 0.3))
            gaps = [gap for px, py, gap in places if pair.covers(px, py)]
            exact = (min(0.0, *gaps), max(0.0, *gaps)) if gaps else (0.0, math.inf)
            told = beside_it(pair.w, pair.st, 0, e + 4 * own)
            off = max(off, *(0.0 if a == b else abs(a - b) for a, b in zip(told, exact, strict=True)))
    return off


def on_the_edge(key: tuple[int, int, int], own: int, edge: int) -> bool:
    """Whether a corner or crossing is on an edge of a scale."""
    if key[0] == EE:
        return key[1 + own] == edge
    corner = key[1 + own]
    return key[0] == (FV if own else VF) and edge in (0 if corner < 2 else 3, 1 if corner % 2 == 0 else 2)


def unfolded(pair: Pair, every: list[Any], plain: dict[tuple[int, int, int], float]) -> tuple[int, int]:
    """Return at how many tangent edges another place than the deepest of their ends is taken, and how many have one."""
    w, st, off, many = pair.w, pair.st, 0, 0
    other = next(v for v in every if v[KIND] in (EE, VF, FV))
    for v in every:
        if v[KIND] not in (EF, FE):
            continue
        own = int(v[KIND] == FE)
        near = {key: gap for key, gap in plain.items() if gap < 5e-3 and on_the_edge(key, own, int(v[ONE]))}
        for c, row in enumerate((v, other)):
            w.con[c], st.s[c] = (0, 1, *row[[KIND, ONE, OTHER]], 0, 0), row[AT : AT + 3]
        w.counts[0], before = 2, w.con[:2].copy()
        found = changes.unfold(w, st)
        if near:
            before[0, KIND:STUCK], before[0, ENDED] = min(near, key=near.__getitem__), 1
        off += found != bool(near) or (w.con[:2] != before).any()
        many += bool(near)
    return off, many


def left() -> float:
    """Return how far contacts are displaced where edges leave a face, or end over it; 1 where one does not change."""
    pair, off = Pair(SHAPES[0], 0.0, 0, 0.0), 0.0
    w, st = pair.w, pair.st
    for kind, e, which in itertools.product((EF, FE), EDGES, range(6)):
        w.con[0] = (0, 1, kind, e, e, 0, 0)
        # inside, but for one limit: of the face's place, or of the edge
        st.s[0] = 0.4 * pair.eta, 0.3 * pair.beta, 0.0
        limits = ((0.0, pair.eta), (-pair.beta, pair.beta), (low(w.S, 0, e), high(w.S, 0, e)))
        st.s[0, 2] = 0.3 * limits[2][0] + 0.7 * limits[2][1]
        st.s[0, which // 2] = limits[which // 2][which % 2]
        before = np.array(spots(w.S, w.con[0], st.s[0]))
        changed = leave(w, st, 0, which) and w.con[0, KIND] == (EE if which < 4 else VF if kind == EF else FV)
        off = max(off, np.abs(before - spots(w.S, w.con[0], st.s[0])).max() if changed else 1.0)
    return off


def spans() -> float:
    """Return how far deflections are beyond their bounds, of many plates."""
    pair, rng, off = Pair(SHAPES[0], 1e-9, 0, 0.0), np.random.default_rng(1), 0.0
    X, Y = np.meshgrid(np.linspace(0, 1, 21), np.linspace(-1, 1, 21))
    for _ in range(100):
        b = rng.standard_normal(24)
        lifts = np.polynomial.polynomial.polyval2d(X, Y, b.reshape(6, 4)) * X**2
        least, most = span(pair.w.S, 0, b)
        off = max(off, least - lifts.min(), lifts.max() - most)
    return off


def met(pair: Pair, v: Any) -> float:
    """Return the gap of the vertex that is taken for one that came in."""
    pair.w.best[:] = v
    return value(pair.w, pair.st, MEET, -1)


def waves() -> dict[str, float]:
    """Return how far gaps of vertices are from those found again where edges are tangent twice, and how often."""
    pair = Pair(SHAPES[0], 1e-9, 0, 0.0)
    w, st = pair.w, pair.st
    st.q[:], st.strains[:] = 0.0, 0.0
    prepared(w.S, st, w.con, 0, True, w.W)
    # X^2 (X - 0.4)^2 (X - 0.9)^2
    st.b[:] = 0.0
    st.b[0].reshape(6, 4)[:5, 0] = np.polynomial.polynomial.polypow(np.poly((0.9, 0.4))[::-1], 2)
    every = pair.told(EVERY)
    kinds = {tuple(v[[KIND, ONE, OTHER]]) for v in every}
    return {"twice": float(len(every) - len(kinds)), "met": max(abs(met(pair, v) - v[GAP]) for v in every)}


def ends() -> int:
    """Return how many ends of edges are at another place than the corner that is said to be there."""
    S = Pair(SHAPES[0], 0.0, 0, 0.0).w.S
    every = [(e, end, corner(S, 0, corner_at(e, end))) for e in EDGES for end in (False, True)]
    return sum(place != on_edge(S, 0, e, (high if end else low)(S, 0, e)) for e, end, place in every)


def below(vertices_: list[Any], cap: float, kinds: tuple[int, ...]) -> list[Any]:
    """Return what vertices of some kinds are whose gap is below a cap."""
    return [v[[KIND, ONE, OTHER, GAP]].tolist() for v in vertices_ if v[GAP] < cap and v[KIND] in kinds]


def missed(pair: Pair) -> dict[str, float]:
    """Return by how much vertices are not what they should be; 1 where one is missing, or one too many."""
    S, st, W, every = pair.w.S, pair.st, pair.w.W, pair.told(EVERY)
    kinds = {tuple(v[[KIND, ONE, OTHER]].astype(int)): v for v in every}
    plain = dict([*pair.corners(), *pair.crossings(0)])
    off, many = unfolded(pair, every, plain)
    out = {
        "unfolded": float(off),
        "unfolds": float(many),
        "set": float({k for k in kinds if k[0] not in (EF, FE)} != plain.keys() or len(kinds) > len(every)),
        "gaps": max((abs(kinds[k][GAP] - gap) for k, gap in plain.items() if k in kinds), default=0.0),
        "edges": max((of_edges(pair, v) for v in every if v[KIND] in (EF, FE)), default=0.0),
        "slopes": max((slopes(pair, v) for v in every if v[KIND] in (VF, FV, EE) and st.b.any()), default=0.0),
        "beside": beside(pair),
        "again": max((abs(gap_at(S, st, W, v) - v[GAP]) for v in every), default=0.0),
    }
    for own, seen in enumerate([(VF, EE, EF), (FV, FE)]):
        gaps = [v[GAP] for v in every if v[KIND] in seen] + [gap for _, gap in pair.crossings(own)]
        out[f"least {own}"] = max(0.0, min(gaps, default=EVERY) - pair.least(own))
    # gaps of corners on the lower face are along another normal: a pair is passed over only where none is below 0
    levels = np.quantile([0.0, *(v[GAP] for v in every)], (0.2, 0.5, 0.8))
    caps = [(0.0, (EE, VF, FV, EF, FE)), *((cap, (VF, EE, EF)) for cap in levels)]
    out["caps"] = max(float(below(every, *cap) != below(pair.told(cap[0]), *cap)) for cap in caps)
    bounds = [span(S, i, st.b[i]) for i in range(2)]
    grid = [(x * pair.eta, y * pair.beta) for x in np.linspace(0, 1, 9) for y in np.linspace(-1, 1, 9)]
    lifts = [[pair.lift(i, x, y) for x, y in grid] for i in range(2)]
    out["bounds"] = max(max(low - min(v), max(v) - high) for (low, high), v in zip(bounds, lifts, strict=True))
    sizes = (np.ptp([0.0, *v]) for v in lifts)
    out["wide"] = max((high - low) / max(size, 1e-300) for (low, high), size in zip(bounds, sizes, strict=True))
    view(W, 0, 1, 1, False, W.views[0])
    kept = clear(S, W.views[0], 0, 1, *(max(-low, high) for low, high in bounds))
    out["clear"] = max(0.0, kept - min([EVERY, *(v[GAP] for v in every if v[KIND] in (VF, EE, EF))]))
    return out


if __name__ == "__main__":
    # deflections stay as they are given
    changes.prepared = lambda *_: None
    found: dict[str, Any] = {"ends": ends(), "left": left(), "spans": spans(), "waves": waves()}
    for bent in (0.0, 0.02):
        pairs = [
            missed(Pair(shape, bent, seed, 0.1 if bent else 0.25))
            for seed, shape in enumerate(SHAPES * int(sys.argv[1]))
        ]
        found["bent" if bent else "rigid"] = {name: max(p[name] for p in pairs) for name in pairs[0]}
    sys.stdout.write(json.dumps(found))

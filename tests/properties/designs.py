"""Designs for the property tests: drawn one by one by hypothesis, or many at once; points of their paths."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from hypothesis import strategies as st

from oracle.vectors import Design as Rigid
from squama.arrays import solution
from squama.model import energy, mechanics
from squama.model.outcome import CODES
from squama.model.paths import FLOAT, Point
from squama.model.tracks import scalar

RATIOS = ("eta", "beta", "lam", "alpha")


class Drawn(NamedTuple):
    """A design: ratios, angles in rad, coefficient of friction."""

    eta: float
    beta: float
    lam: float
    alpha: float
    theta0: float
    mu: float

    @property
    def ratios(self) -> dict[str, float]:
        """What `squama.contact` takes."""
        return {name: getattr(self, name) for name in RATIOS}

    def rigid(self, sense: str = "+", k: int = 1) -> Rigid:
        """Return the design as the oracle takes it."""
        sign = 1 if sense == "+" else -1
        return Rigid(self.eta, self.alpha, self.beta, self.lam, self.theta0, sign, k)


def designs(mu: tuple[float, float] = (0.0, 10.0)) -> st.SearchStrategy[Drawn]:
    """Every kind of design, far beyond those that are built."""
    return st.builds(
        Drawn,
        eta=st.floats(1.05, 8),
        beta=st.floats(0.1, 3),
        lam=st.floats(0.05, 2),
        alpha=st.floats(math.radians(0.5), math.radians(89)),
        theta0=st.floats(math.radians(0.1), math.radians(60)),
        mu=st.floats(*mu),
    )


def many(n: int, seed: int) -> dict[str, np.ndarray]:
    """Return the columns of n random designs; every third at a low alpha, where paths fold."""
    r = np.random.default_rng(seed)
    low = np.arange(n) % 3 == 0
    return {
        "eta": r.uniform(1.05, 8, n),
        "beta": r.uniform(0.1, 3, n),
        "lam": r.uniform(0.05, 2, n),
        "alpha": np.radians(np.where(low, r.uniform(0.5, 15, n), r.uniform(0.5, 89, n))),
        "theta0": np.radians(10 ** r.uniform(-1, 1.5, n)),
        "mu": r.choice([0.0, 1.0, 1.0, 3.0], n) * r.uniform(0, 1, n),
    }


def mirrored(n: int, seed: int) -> dict[str, np.ndarray]:
    """Return designs most of which engage when they are twisted the other way: wide or deep, at a low alpha."""
    r = np.random.default_rng(seed)
    return many(n, seed) | {
        "beta": r.uniform(0.8, 3, n),
        "alpha": np.radians(r.uniform(0.5, 12, n)),
        "theta0": np.radians(r.uniform(0.5, 12, n)),
    }


def each(columns: dict[str, np.ndarray]) -> list[Drawn]:
    """Return the designs of the columns, one by one."""
    return [Drawn(*map(float, row)) for row in zip(*(columns[name] for name in Drawn._fields), strict=True)]


class Followed(NamedTuple):
    """A solved path: its row of floats, first and last path parameter, how it ends; pole of the friction force."""

    row: Any
    x0: float
    x_end: float
    end: str
    theta_end: float
    load_e: float
    load_end: float
    k: int
    crossing: int
    pole: float

    def at(self, fraction: float, law: str) -> Point:
        """Contact at a fraction of the path."""
        return self.row.point(self.x0 + fraction * (self.x_end - self.x0), law, FLOAT)


def follow(d: Drawn, law: str = "edge", sense: str = "+") -> Followed | None:
    """Solve one design by the package; None where nothing engages."""
    columns = {name: np.array([v]) for name, v in zip(solution.COLUMNS, d, strict=True)}
    s, crossings, tracks = solution.solve(columns, law=law, sense=sense)
    if not tracks:
        return None
    t = tracks[0][1]
    one = (s.theta_end, s.load_e, s.load_end)
    theta_end, load_e, load_end = (float(v[0]) for v in one)
    code, k, crossing = CODES[int(s.code[0])], int(s.neighbour[0]), int(crossings[0])
    row, x0, x_end = scalar(t.row), float(t.x0[0]), float(t.x_end[0])
    pole = float(energy.pole(t.row, t.x_end, columns["mu"], law, t.x0)[0])
    return Followed(row, x0, x_end, code, theta_end, load_e, load_end, k, crossing, pole)


def balance(pt: Point, d: Drawn) -> mechanics.Forces:
    """Forces at a point of a path."""
    return mechanics.forces(pt, d.theta0, d.mu)

"""A beam's path on the real model: what touches first, states along the twist, figures of the plates; E = d = 1.

Twists are magnitudes: the other sense is the mirror image, alpha -> -alpha.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from squama.real import entry, follow, plate
from squama.real.contact import BEND, ROWS, SHAPE, Design
from squama.types import Array

MIRROR = np.array([1.0, -1.0, 1.0, -1.0, 1.0, -1.0, -1.0, 1.0, 1.0])
"""Signs of the nine motions in the mirror image."""
_HELD = [0, 1, 2, 3, 4, 5, 6]
STEP = 4e-3
"""Largest increment of the twist, rad per pitch; a quarter of it changes a torque by some 1e-5."""
EVERY = 4
"""Other contacts are looked for at every so many steps."""
_GRID = np.linspace(0.0, 1.0, 13)[:, None], np.linspace(-1.0, 1.0, 9)
EDGES = ("tip edge", "side edge", "side edge", "base edge")


class Scale(NamedTuple):
    """A scale: lengths in pitches, angles in rad; ``D`` bending stiffness (E d^3, inf for rigid), Poisson's ratio."""

    eta: float
    beta: float
    lam: float
    alpha: float
    theta0: float
    h: float
    D: float = math.inf
    nu: float = 0.3

    @property
    def elastic(self) -> bool:
        """Whether it bends."""
        return math.isfinite(self.D)


class Contact(NamedTuple):
    """What touches first: edges of scale 1 and of 1 + k, twist and places; ``first`` < 0: see ``first_contact``."""

    first: int
    second: int
    k: int
    phi: float
    x: float
    y: float

    @property
    def words(self) -> str:
        """The pair in words."""
        if self.first == -1:
            return ""
        if self.first == -2:
            return place(self.second, self.k)
        return f"{EDGES[self.first]} on {EDGES[self.second]} (k = {self.k})"


def place(edge: int, k: int) -> str:
    """Return where an edge (+ 4: of the neighbour) comes to a face, in words."""
    own, other = ("scale 1", f"scale {1 + k}") if edge < 4 else (f"scale {1 + k}", "scale 1")
    return f"{EDGES[edge % 4]} of {own} on the face of {other} (k = {k})"


class Path(NamedTuple):
    """A beam to be followed: its scale, K (7, 7) or (9, 9), friction, sense, and what touches first."""

    scale: Scale
    K: Array
    mu: float
    design: Design
    contact: Contact

    @classmethod
    def of(cls, scale: Scale, K: Array, mu: float, *, sense: int = 1, free: bool = False, most: float = 1.0) -> Path:
        """Return the path of a beam; ``free``: its length may change; ``most``: largest twist."""
        n = len(K)
        signs = MIRROR[:n] if sense < 0 else np.ones(n)
        K = K * np.outer(signs, signs)
        scale = scale._replace(alpha=sense * scale.alpha)
        design = make(scale, K, mu, free=free and n == 9)
        entry.tell()
        found = Contact(*entry.first_contact(design, most))
        if found.first >= 0:
            normal = 1.0 if (found.first, found.second) == (plate.TIP, plate.SIDE_D) else _sign(found)
            design = bend(design._replace(first=found.first, second=found.second, k=found.k, sign=normal), scale)
        return cls(scale, K, mu, design, found)

    def states(self, targets: Array, step: float = STEP, every: int = EVERY) -> tuple[Array, follow.End]:
        """Follow the twist to targets (n,); return rows of :data:`squama.real.follow.COLUMNS`, NaN beyond the end."""
        out = np.full((targets.size, len(follow.COLUMNS)), np.nan)
        c = self.contact
        begin = (c.phi, c.x, c.y) if c.first >= 0 else (math.inf, 0.0, 0.0)
        reach = np.minimum(targets, c.phi) if c.first == -2 else targets
        end = entry.follow(self.design, begin, np.ascontiguousarray(reach, float), step, every, out)
        if c.first == -2 and targets.max() > c.phi:
            first = int(np.argmax(targets > c.phi))
            out[first:] = np.nan
            end = follow.End(follow.OTHER, c.phi, c.second, c.k, first)
        return out, end


def make(scale: Scale, K: Array, mu: float, *, free: bool) -> Design:
    """Return the compiled model's design of a scale on a matrix, its tip edge on the next one's side edge."""
    table = np.zeros((ROWS, 12))
    order = [*_HELD[:6], 8, 6] if free else _HELD
    places = [*range(8)] if free else [0, 1, 2, 3, 4, 5, 7]
    table[np.ix_(places, places)] = K[np.ix_(order, order)]
    sa, ca, st, ct = (f(v) for v in (scale.alpha, scale.theta0) for f in (math.sin, math.cos))
    found = Design(
        scale.eta, scale.beta, scale.lam, sa, ca, st, ct, scale.h, mu, plate.TIP, plate.SIDE_D, 1, 1.0,
        7 if free else 6, scale.elastic, table,
    )  # fmt: skip
    return bend(found, scale)


def bend(design: Design, scale: Scale) -> Design:
    """Fill a design's table with what forces on its two edges do to a plate."""
    if scale.elastic:
        C, shapes = (v[0] / scale.D for v in plate.answers(*(np.array([v]) for v in (scale.eta, scale.beta, scale.nu))))
        both = design.first, design.second
        for i, a in enumerate(both):
            design.table[SHAPE:, 6 * i : 6 * i + 6] = shapes[a]
            for j, b in enumerate(both):
                design.table[BEND + 6 * i : BEND + 6 * i + 6, 6 * j : 6 * j + 6] = C[a, b]
    return design


def _sign(contact: Contact) -> float:
    """Return the sign of the edges' common normal for which it pushes scale 1 upwards."""
    along = [np.array([1.0, 0.0, 0.0]) if edge in (1, 2) else np.array([0.0, 1.0, 0.0]) for edge in contact[:2]]
    return float(np.sign(np.cross(along[1], along[0])[2])) or 1.0


def deflections(path: Path, rows: Array) -> Array:
    """Return the plate's deflections as powers (n, 24), see :mod:`squama.real.plate`, of states."""
    d = path.design
    forces = np.stack(
        [_powers(d, edge, rows[:, 4 + i]) * rows[:, 6 + i, None] for i, edge in enumerate((d.first, d.second))]
    )
    return (
        np.einsum("ij,nj->ni", d.table[SHAPE:], np.concatenate(list(forces), axis=1))
        if d.elastic
        else np.zeros((len(rows), 24))
    )


def _powers(d: Design, edge: int, x: Array) -> Array:
    scaled = np.nan_to_num(x) / (d.eta if edge in (1, 2) else d.beta)
    return scaled[:, None] ** (np.arange(6) + plate.FIRST[edge])


def energies(path: Path, rows: Array) -> dict[str, Array]:
    """Return the elastic energy (n,) in joint, plate and bar, E d^3 per pitch: roles U_joint, U_plate, U_bar."""
    d = path.design
    q = np.column_stack([rows[:, 11:18], rows[:, 0]])
    whole = np.einsum("ni,ij,nj->n", q, d.table[:8, :8], q) / 2
    bar = rigidity(path) * rows[:, 0] ** 2 / 2
    own = np.zeros(len(rows))
    if d.elastic:
        g = np.concatenate(
            [_powers(d, e, rows[:, 4 + i]) * rows[:, 6 + i, None] for i, e in enumerate((d.first, d.second))], axis=1
        )
        own = np.einsum("ni,ij,nj->n", g, d.table[BEND : BEND + 12], g) / 2
    return {"U_joint": whole - bar, "U_plate": own, "U_bar": bar}


def rigidity(path: Path) -> float:
    """Return the torque per twist without contact, E d^3."""
    T, m = path.design.table[:8, :8], path.design.motions
    return float(T[7, 7] - T[7, :m] @ np.linalg.solve(T[:m, :m], T[:m, 7]))


def stresses(path: Path, rows: Array) -> tuple[Array, Array]:
    """Return the largest stress (von Mises, E) in a scale and where it is (n, 2), by Kirchhoff's moments 6 m / h^2."""
    s, b = path.scale, deflections(path, rows).reshape(len(rows), 6, 4)
    X, Y = _GRID
    m, n = np.arange(2, 8), np.arange(4)
    x = [X**m, m * X ** (m - 1), m * (m - 1) * X ** (m - 2)]
    y = [Y[:, None] ** n, n * Y[:, None] ** np.maximum(n - 1, 0), n * (n - 1) * Y[:, None] ** np.maximum(n - 2, 0)]
    xx, yy, xy = (
        np.einsum("am,nmk,bk->nab", x[i], b, y[j]) / s.eta**i / s.beta**j for i, j in ((2, 0), (0, 2), (1, 1))
    )
    mx, my, mxy = s.D * (xx + s.nu * yy), s.D * (yy + s.nu * xx), s.D * (1 - s.nu) * xy
    mises = 6 / s.h**2 * np.sqrt(mx**2 - mx * my + my**2 + 3 * mxy**2)
    flat = mises.reshape(len(rows), -1)
    most = flat.argmax(axis=1)
    i, j = np.unravel_index(most, mises.shape[1:])
    return flat[np.arange(len(rows)), most], np.column_stack([X[i, 0] * s.eta, Y[j] * s.beta])


def tip(path: Path, rows: Array) -> Array:
    """Return the deflection (n,) of the middle of a scale's tip along its normal, pitches."""
    return np.asarray(deflections(path, rows).reshape(len(rows), 6, 4)[:, :, 0].sum(axis=1))


def _turns(rows: Array) -> Array:
    """Return the rotations (n, 3, 3) of the scale from its attitude at rest, in its axes there."""
    from scipy.spatial.transform import Rotation

    w = rows[:, 14:17]
    known = np.isfinite(w).all(axis=1)
    out = np.full((len(rows), 3, 3), np.nan)
    if known.any():
        out[known] = Rotation.from_rotvec(w[known]).as_matrix()
    return out


def inclinations(path: Path, rows: Array) -> Array:
    """Return the angle (n,) of n_X against the beam's face, seen along the width at rest, rad."""
    theta0 = path.scale.theta0
    x = _turns(rows)[:, :, 0]
    # n_X and n_Z at rest are turned by theta0 from the face, about n_Y
    return np.asarray(theta0 + np.arctan2(x[:, 2], x[:, 0]))


def pull_out(path: Path, rows: Array) -> Array:
    """Return the force (n,) of the contacts along a scale out of the substrate, E d^2."""
    T = path.design.table[:8, :8]
    q = np.column_stack([rows[:, 11:18], rows[:, 0]])
    return np.asarray(np.einsum("ni,ni->n", q @ T[:3].T, _turns(rows)[:, :, 0]))

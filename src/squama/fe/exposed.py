"""The exposed part of a scale: its contact surface, and its bending modes.

Lengths in pitches, along the axes n_X, n_Y, n_Z of the scale from its base midpoint O; it fills 0 <= X <= eta,
|Y| <= beta, |Z| <= h/2. The embedded part is rigid. In the frame that turns with it the exposed part is linear: a point
of the surface at rest in xi comes to xi + sum_j a_j Phi_j(xi), which costs the energy 1/2 a^T K_a a. That holds while
its deflection is below about a tenth of its length. Where modes come from: :mod:`squama.fe.bending`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from squama.types import Array

Index = NDArray[np.int64]

FACE = "the face"
_SIDES = ("base edge DA", "side edge AB", "tip edge CB", "side edge DC")
CAP = 1.0
"""Largest stiffness of a mode amplitude, E d: stiffer modes are scaled down, so that systems are well conditioned."""


class Exposed(NamedTuple):
    """Triangulated contact surface of the exposed part and its bending modes.

    ``points`` (n, 3), pitches; ``edges`` (e, 2) and ``faces`` (f, 3) by numbers of points; ``names`` (n,) and ``sides``
    (e,): corner or edge of the plate to which a point or edge belongs, :data:`FACE` for others; ``modes`` (n, 3, r) and
    their ``stiffness`` (r, r), E d.
    """

    points: Array
    edges: Index
    faces: Index
    names: tuple[str, ...]
    sides: tuple[str, ...]
    modes: Array
    stiffness: Array

    @property
    def amplitudes(self) -> int:
        """Number r of modes."""
        return len(self.stiffness)

    @property
    def outer(self) -> Index:
        """Numbers of the edges on the outline of the plate."""
        return np.flatnonzero([side != FACE for side in self.sides])

    def bending(self, modes: Array, stiffness: Array) -> Exposed:
        """Return the same surface with modes (n, 3, r) and their stiffness (r, r), E d.

        Modes are combined so that the stiffness is diagonal, and scaled so that the largest displacement is one pitch
        per amplitude, or less where the stiffness would exceed :data:`CAP`.
        """
        n, _, r = modes.shape
        most = np.abs(modes).max(axis=(0, 1))
        values, axes = np.linalg.eigh(stiffness / np.outer(most, most))
        modes = (modes.reshape(3 * n, r) / most) @ axes
        size = np.abs(modes).max(axis=0)
        size = np.maximum(size, np.sqrt(values / CAP))
        return self._replace(modes=(modes / size).reshape(n, 3, r), stiffness=np.diag(values / size**2))


def thin(eta: float, beta: float) -> Exposed:
    """Return the surface of a rigid scale without thickness: a rectangle with the corners D, A, B, C in this order."""
    points = np.array([[0.0, -beta, 0.0], [0.0, beta, 0.0], [eta, beta, 0.0], [eta, -beta, 0.0]])
    edges = np.array([(0, 1), (1, 2), (2, 3), (3, 0), (0, 2)])
    names = tuple(f"corner {name}" for name in "DABC")
    return Exposed(points, edges, np.array([(0, 1, 2), (0, 2, 3)]), names, (*_SIDES, FACE), *_rigid(4))


def sheet(X: Array, Y: Array, h: float) -> Exposed:
    """Return the surface of a plate over a grid: lower and upper face and the walls between them; one face if h = 0.

    ``X`` (a,), ``Y`` (b,): lines of the grid, from 0 to eta and from -beta to beta; all in pitches.
    """
    a, b = X.size, Y.size
    i, j = (v.ravel() for v in np.meshgrid(np.arange(a), np.arange(b), indexing="ij"))
    flat = np.column_stack([X[i], Y[j], np.zeros(i.size)])
    i, j = (v.ravel() for v in np.meshgrid(np.arange(a - 1), np.arange(b - 1), indexing="ij"))
    quads = np.column_stack([i * b + j, (i + 1) * b + j, (i + 1) * b + j + 1, i * b + j + 1])
    layers = [flat + np.array([0.0, 0.0, z]) for z in ((-h / 2, h / 2) if h else (0.0,))]
    cells = [quads + k * a * b for k in range(len(layers))]
    if h:
        base, tip = np.arange(b), (a - 1) * b + np.arange(b)
        low, high = np.arange(a) * b, np.arange(a) * b + b - 1
        walls = base, tip, low, high
        cells += [np.column_stack([w[:-1], w[1:], w[1:] + a * b, w[:-1] + a * b]) for w in walls]
    points, quads = np.concatenate(layers), np.concatenate(cells)
    faces = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    edges = np.unique(np.sort(faces[:, [(0, 1), (1, 2), (2, 0)]].reshape(-1, 2), axis=1), axis=0)
    on = _on(points, (X[0], X[-1], Y[0], Y[-1]))
    names = [_corner(row) if row.sum() > 1 else _SIDES[int(np.argmax(row))] if row.any() else FACE for row in on]
    diagonal = points[edges[:, 0], 2] != points[edges[:, 1], 2]
    both = on[edges].all(axis=1) & ~diagonal[:, None]
    # an edge across the thickness at a corner is an edge of the box, too, named after the corner
    upright = diagonal & (np.abs(points[edges[:, 0], :2] - points[edges[:, 1], :2]).max(axis=1) == 0)
    sides = [
        _SIDES[int(np.argmax(row))] if row.any() else names[e] if up and names[e].startswith("corner") else FACE
        for row, e, up in zip(both, edges[:, 0], upright, strict=True)
    ]
    return Exposed(points, edges, faces, tuple(names), tuple(sides), *_rigid(len(points)))


def box(eta: float, beta: float, h: float) -> Exposed:
    """Return the surface of a rigid plate of thickness h (pitches); a rectangle for h = 0."""
    return sheet(np.array([0.0, eta]), np.array([-beta, beta]), h) if h else thin(eta, beta)


def _rigid(n: int) -> tuple[Array, Array]:
    return np.zeros((n, 3, 0)), np.zeros((0, 0))


def _on(points: Array, bounds: tuple[float, ...]) -> NDArray[np.bool_]:
    """Return for points (n, 3) whether each lies on each of the four sides (n, 4)."""
    (x, y, _), (x0, x1, y0, y1) = points.T, bounds
    return np.column_stack([x == x0, y == y1, x == x1, y == y0])


def _corner(on: NDArray[np.bool_]) -> str:
    base, right, tip, _ = on
    return f"corner {('BC' if tip else 'AD')[0 if right else 1]}" if base or tip else FACE

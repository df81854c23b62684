"""Corners of the exposed parts of scales in a row, endless or not, with derivatives by motions and loads."""

from __future__ import annotations

import functools
from collections.abc import Iterator

import numpy as np

from squama.fe.exposed import Exposed, Index, thin
from squama.fe.periodic import Course, Twist
from squama.fe.plate import Attached, Rest, Rotation, rotation
from squama.types import Array


class Row:
    """The exposed parts of scales, one pitch apart along z at rest.

    An endless row is represented by scale 0 and its images 1, 2, .. within reach, which have the same motions in their
    turning frames (see :class:`Carried`). By periodicity every pair of scales is one of the pairs (0, k), k > 0, turned
    and moved; so each pair counts once per pitch, and the derivatives by v contain the forces from the neighbours on
    both sides.

    ``rest``: scale 0 at rest; ``scales``: number of scales, each with its own motions, None for an endless row;
    ``still``: place along z of the section that does not turn; ``exposed``: their exposed parts, by default rectangles
    without thickness; ``course``: moves from scale to scale, by default a twist. ``pairs``: scales that may touch.
    """

    def __init__(
        self,
        rest: Rest,
        scales: int | None = None,
        still: float = 0.0,
        exposed: Exposed | None = None,
        course: Course | None = None,
    ) -> None:
        self.course = course or Twist()
        self.rest, self.endless, self.moving = rest, scales is None, scales or 1
        reach = int(np.ceil(np.hypot(rest.eta, 2 * rest.beta)))
        count = 1 + reach if scales is None else scales
        self.reach = min(reach, count - 1)
        last = [1] * self.reach if scales is None else [count - k for k in range(1, self.reach + 1)]
        self.pairs = [(i, i + k) for k, n in enumerate(last, start=1) for i in range(n)]
        self.exposed = thin(rest.eta, rest.beta) if exposed is None else exposed
        self.plate = Attached(rest, rest.base + self.exposed.points @ rest.axes, self.exposed.modes)
        self.k = np.arange(float(count)) - still
        self.still = np.array([0.0, 0.0, still])

    def own(self, i: int, size: int) -> Index:
        """Return the numbers of the motions and amplitudes of scale i among ``size`` motions (6 and r per scale)."""
        i, r = (0 if self.endless else i), self.exposed.amplitudes
        last = size - r * (self.moving - i)
        return np.concatenate([np.arange(6 * i, 6 * i + 6), np.arange(last, last + r)])


class Placed:
    """The scales of a row at one state; ``corners`` (n scales, 3), scale by scale in the order of their surface.

    ``v`` (m,) begins with six motions for each scale with motions of its own, and ends with r amplitudes for each;
    entries between are loads of the course. ``phi`` is the place on the path.
    """

    def __init__(self, row: Row, v: Array, phi: float) -> None:
        self._row, self._size = row, v.size + 1
        self._own = [row.own(i, v.size) for i in range(row.moving)]
        self._v = [v[own] for own in self._own]
        self._moves = row.course.moves(row.course.at(v, phi), row.k)
        # one array for all images, or one for each scale
        self._x = np.array([row.plate.places(motion) for motion in self._v])
        shift = self._moves.t[:, None] + row.still
        self.corners: Array = (self._x @ self._moves.Q.transpose(0, 2, 1) + shift).reshape(-1, 3)

    @functools.cached_property
    def _rotations(self) -> list[Rotation]:
        return [rotation(motion[3:6]) for motion in self._v]

    def _parts(self, nodes: Index) -> Iterator[tuple[int, int, Index, Index]]:
        """Yield for each scale: its number, that of its motions, places among ``nodes``, own numbers of these."""
        scales, own = np.divmod(nodes, len(self._row.plate.local))
        for k in np.unique(scales).tolist():
            at = np.flatnonzero(scales == k)
            yield k, 0 if self._row.endless else k, at, own[at]

    def rates(self, nodes: Index) -> Array:
        """Return the derivatives (3 nodes, m + 1) by (v, phi) of the corners with these numbers."""
        row, moves, by = self._row, self._moves, self._row.course.by(self._size)
        out = np.zeros((nodes.size, 3, self._size))
        for k, i, at, own in self._parts(nodes):
            each = moves.Q[k] @ row.plate.of(own).rates(self._v[i], self._rotations[i])
            out[at[:, None, None], np.arange(3)[:, None], self._own[i]] = each
            by_loads = self._x[i][own] @ moves.dQ[k].transpose(0, 2, 1) + moves.dt[k][:, None]
            out[at] += np.tensordot(by_loads, by, (0, 0))
        return out.reshape(-1, self._size)

    def curvature(self, nodes: Index, forces: Array) -> Array:
        """Return the second derivatives (m + 1, m + 1) by (v, phi) of ``sum(forces * corners[nodes])``."""
        row, moves, by = self._row, self._moves, self._row.course.by(self._size)
        out = np.zeros((self._size, self._size))
        for k, i, at, own in self._parts(nodes):
            f, x, part, to = forces[at], self._x[i][own], row.plate.of(own), self._own[i]
            out[np.ix_(to, to)] += part.curvature(self._v[i], f @ moves.Q[k], self._rotations[i])
            rates = part.rates(self._v[i], self._rotations[i]).reshape(3 * own.size, -1)
            mixed = ((f @ moves.dQ[k]).reshape(by.shape[0], -1) @ rates).T @ by
            out[to] += mixed
            out[:, to] += mixed.T
            out += by.T @ (np.einsum("ni,lmij,nj->lm", f, moves.ddQ[k], x) + moves.ddt[k] @ f.sum(0)) @ by
        return out

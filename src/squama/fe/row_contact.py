"""Contact of the scales of a finite beam, each with its own six motions.

Scale i stands i pitches further along z than scale 0, and its motions are counted in a frame that turns
with the twist (:mod:`squama.fe.carried`). All pairs within reach count once; a contact acts on both of its scales.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from functools import cached_property
from typing import NamedTuple

import numpy as np

from squama.fe.carried import Carried, spread
from squama.fe.contact import DHAT, SLIP, Contact, Push, Resultant
from squama.fe.plate import Array, Shape


class Row:
    """The exposed parts of N scales (rectangles without thickness), one pitch apart along z at rest.

    Parameters
    ----------
    rest : Shape
        Scale 0 at rest.
    scales : int
        How many.
    still : float
        Place along z of the section that does not turn, see :mod:`squama.fe.carried`.
    """

    def __init__(self, rest: Shape, scales: int, still: float = 0.0) -> None:
        self.scales = scales
        self.reach = min(int(np.ceil(np.hypot(rest.eta, 2 * rest.beta))), scales - 1)
        eta, beta = rest.eta, rest.beta
        local = np.array([[0.0, -beta, 0.0], [0.0, beta, 0.0], [eta, beta, 0.0], [eta, -beta, 0.0]])
        plate = rest.base + local @ rest.axes
        self._plates = [Carried(rest, plate + np.array([0.0, 0.0, k]), k, still) for k in range(scales)]

    @property
    def pairs(self) -> list[tuple[int, int]]:
        """Pairs of scales that may touch."""
        return [(i, i + k) for k in range(1, self.reach + 1) for i in range(self.scales - k)]

    def _each(self, v: Array) -> Iterator[tuple[Carried, Array]]:
        return zip(self._plates, v[: 6 * self.scales].reshape(-1, 6), strict=True)

    def corners(self, v: Array, phi: float) -> Array:
        """Return the corners (4 N, 3), scale by scale in the order D, A, B, C; v begins with the scales' motions."""
        return np.concatenate([plate.places(m, phi) for plate, m in self._each(v)])

    def rates(self, v: Array, phi: float) -> Array:
        """Return the derivatives (N, 12, 7) of each scale's corners by its own motions and phi."""
        return np.stack([plate.rates(m, phi).reshape(12, 7) for plate, m in self._each(v)])

    def curvature(self, v: Array, phi: float, forces: Array) -> Array:
        """Return for each scale the second derivatives (N, 7, 7) of ``sum(forces * corners)``, forces (4 N, 3)."""
        both = zip(self._each(v), forces.reshape(-1, 4, 3), strict=True)
        return np.stack([plate.curvature(m, phi, f) for (plate, m), f in both])


class Pair(NamedTuple):
    """Contact of two scales: their numbers, and the normal force and friction force (3,) on the first."""

    first: int
    second: int
    normal: Array
    friction: Array

    @property
    def N(self) -> float:
        """Magnitude of the normal force."""
        return float(np.linalg.norm(self.normal))

    @property
    def f(self) -> float:
        """Magnitude of the friction force."""
        return float(np.linalg.norm(self.friction))


class RowLoad:
    """Contact of a row at one state: minus the forces on (v, phi), in two parts, and their tangent.

    Attributes
    ----------
    normal, friction, total : (m + 1,) array
        Derivatives of the work.
    tangent : (m + 1, m + 1) array
        Derivative of the total, not symmetric.
    push : Push or None
        The same by the corners; None without contact.
    slid : float
        Work of the present friction forces on the slip since ``before``.
    """

    def __init__(self, contact: RowContact, v: Array, phi: float, before: Array | None, kappa: float) -> None:
        row = contact.row
        self._contact, self._before, self._kappa = contact, before, kappa
        self._corners = corners = row.corners(v, phi)
        m, n = v.size + 1, row.scales
        self.normal, self.friction, self.tangent = np.zeros(m), np.zeros(m), np.zeros((m, m))
        self.push: Push | None = None
        self.slid = 0.0
        push = contact.contact.push(corners, before, kappa)
        if push.tangent is None:
            return
        self.push = push
        own = np.append(np.arange(6 * n), m - 1)
        J = row.rates(v, phi)
        for part, forces in ((self.normal, push.gradient), (self.friction, push.friction)):
            each = (forces.reshape(n, 1, 12) @ J)[:, 0]
            part[own] = np.append(each[:, :6], each[:, 6].sum())
        # blocks of two scales at a time
        blocks = J.transpose(0, 2, 1)[:, None] @ push.tangent.reshape(n, 12, n, 12).transpose(0, 2, 1, 3) @ J[None]
        blocks[range(n), range(n)] += row.curvature(v, phi, push.gradient + push.friction)
        self.tangent[np.ix_(own, own)] = spread(blocks)
        if before is not None:
            self.slid = float((push.friction * (corners - before)).sum())

    @property
    def total(self) -> Array:
        """Sum of normal part and friction, (m + 1,)."""
        return self.normal + self.friction

    @cached_property
    def pairs(self) -> list[Pair]:
        """The pairs that touch."""
        if self.push is None:
            return []
        V, before, out = self._corners.reshape(-1, 4, 3), self._before, []
        for i, j in self._contact.row.pairs:
            then = None if before is None else before.reshape(-1, 4, 3)[[i, j]].reshape(-1, 3)
            push = self._contact.two.push(V[[i, j]].reshape(-1, 3), then, self._kappa, tangent=False)
            if push.gradient.any():
                out.append(Pair(i, j, -push.gradient[:4].sum(0), -push.friction[:4].sum(0)))
        return out

    @property
    def resultant(self) -> Resultant:
        """Resultant forces of the pair that presses most; ``k`` says how far apart its scales are."""
        if not self.pairs:
            return Resultant(0, 0.0, 0.0)
        most = max(self.pairs, key=lambda p: p.N)
        return Resultant(most.second - most.first, most.N, most.f)


class RowContact:
    """Frictional contact of the scales of a finite beam with all neighbours within reach.

    Parameters
    ----------
    row : Row
        The scales.
    mu, dhat, slip : float
        As in :class:`squama.fe.contact.Contact`.

    Notes
    -----
    ``v`` may be longer than the 6 N motions of the scales; contact does not depend on the rest.
    """

    def __init__(self, row: Row, mu: float, *, dhat: float = DHAT, slip: float = SLIP) -> None:
        self.row = row
        rest = row.corners(np.zeros(6 * row.scales), 0.0)
        self.contact = Contact(rest, row.pairs, mu, dhat=dhat, slip=slip)
        # places at rest do not come in, so any two scales will do for every pair
        self.two = Contact(rest[:8], [(0, 1)], mu, dhat=dhat, slip=slip)

    def corners(self, v: Array, phi: float) -> Array:
        """Return the corners of all scales, (4 N, 3)."""
        return self.row.corners(v, phi)

    def load(self, v: Array, phi: float, before: Array | None, kappa: float) -> RowLoad:
        """Evaluate contact; ``before`` and ``kappa`` as in :meth:`squama.fe.contact.Contact.push`."""
        return RowLoad(self, v, phi, before, kappa)

    def free(self, start: Array, end: Array) -> float:
        """Return the fraction of a straight motion that no collision stops; see :meth:`Contact.free`."""
        return self.contact.free(start, end)

    def places(self, v: Array, phi: float, kappa: float) -> tuple[Array, Array, str]:
        """Return where the tip edge of each scale touches the next one, p and s (N,), and all contacts in words.

        p and s are NaN where the tip edge of a scale does not touch the side edge of the next.
        """
        n = self.row.scales
        p, s = np.full(n, np.nan), np.full(n, np.nan)
        usual: set[int] = set()
        others: dict[str, None] = {}
        for touch in self.contact.touches(self.row.corners(v, phi), kappa):
            if touch.second == touch.first + 1 and np.isfinite(touch.p):
                if touch.first not in usual:
                    p[touch.first], s[touch.first] = touch.p, touch.s
                usual.add(touch.first)
            else:
                others[touch.pair] = None
        words = [f"tip edge on the next scale's side edge DC: {ranges(1 + i for i in usual)}"] if usual else []
        return p, s, "; ".join([*words, *others])


def ranges(numbers: Iterable[int]) -> str:
    """Return whole numbers in words: "1 to 3, 5"."""
    parts: list[Sequence[int]] = []
    for number in sorted(numbers):
        if parts and number == parts[-1][-1] + 1:
            parts[-1] = (parts[-1][0], number)
        else:
            parts.append((number, number))
    return ", ".join(f"{a}" if a == b else f"{a} to {b}" for a, b in parts)

"""Bending of thin, rigid scales on hinges at any alpha: the curve along psi by the kernel of bending and twisting.

The hinge has the stiffness of bending. Where edges lie across the beam and the scaled face keeps its length this is the
closed form of :mod:`squama.model.bending`.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from squama.arrays.solution import SEARCH
from squama.curves.hinge import LOCKS, SAME, before, in_si, straight
from squama.curves.hinge_polygons import of, pole_of, soft
from squama.curves.path import Asked, Case, Curve, States, figures
from squama.model import energy
from squama.model.bracket import zero
from squama.model.outcome import End
from squama.model.screw_path import Design, Piece, follow
from squama.types import Array

FIRST = 2.0
"""Bend per pitch to which a path is first followed, over 1/eta: a lock of edges across the beam is at about 1/eta."""


class Bent(NamedTuple):
    """A bent beam's path with one coefficient of friction, solved up to ``load_end``; pieces of some length only."""

    case: Case
    pieces: tuple[Piece, ...]
    end: End
    other: str
    load_e: float
    load_end: float
    margin: float
    mu_static: float
    sign: int = 1

    @property
    def engaged(self) -> bool:
        """Whether part of the path is in contact."""
        return any(piece.contact for piece in self.pieces)

    @property
    def far(self) -> float:
        """Bend per pitch at which the parameter of the pieces is 1."""
        return abs(self.pieces[0].leg.step[0])

    @property
    def theta_end(self) -> float:
        """Inclination at the end, rad."""
        piece = self.pieces[-1]
        if self.end is End.KINEMATIC and piece.leg.flush:
            # an arc sine of 1 has half the digits
            return math.pi / 2 - self.load_end / 2
        return _theta(piece, self.load_end / self.far)

    @property
    def last(self) -> float:
        """Load angle of the cut-off: before a lock a fraction ``margin`` of the inclination is left."""
        if not self.engaged or self.end not in LOCKS:
            return self.load_end
        theta0 = self.case.theta0
        theta = theta0 + (1 - self.margin) * (self.theta_end - theta0)
        piece = next(p for p in reversed(self.pieces) if _theta(p, p.x0) < theta)
        a, b = piece.x0, min(piece.x1, self.load_end / self.far)
        fa, fb = (_theta(piece, x) - theta for x in (a, b))
        return self.far * float(zero(lambda x: _theta(piece, x) - theta, a, fa, b, fb, a, fa, True))

    def curve(self, *, points: int, at: Array | None = None) -> Curve:
        """Return the curve at ``points`` of its own, from load 0 to the cut-off, or at load angles; figures there."""
        last = self.last
        if at is None:
            loads = self._samples(points, last)
        else:
            # a load that meets the end but for rounding belongs to the curve; at a lock the forces have no bounds
            within = at <= self.load_end * (1 if self.end in LOCKS else 1 + SAME)
            loads = at[within]
        # the cut-off goes along as the last point
        values = self._values(np.append(loads, last), last)
        along, cut = {name: v[:-1] for name, v in values.items()}, {name: v[-1] for name, v in values.items()}
        if at is not None:
            for name, v in along.items():
                along[name] = np.full(at.size, "" if v.dtype.kind == "U" else np.nan, v.dtype)
                along[name][within] = v
            along["load"], along["rate"] = at, at / self.case.pitch
        end = np.inf if self.end is End.NONE else self.load_end
        found = figures(self.case, cut, self.load_e, end, self.theta_end)
        own = {"T_c": cut["T"], "mu_static": self.mu_static, "end": str(self.end), "other_contact": self.other}
        return Curve(along, {**found, **own, "neighbour": int(math.isfinite(self.load_e))})

    def _samples(self, points: int, last: float) -> Array:
        """Return load angles: some before engagement, the rest in contact, closer together where a curve steepens."""
        if not self.engaged:
            return np.linspace(0.0, last, points)
        first = before(points)
        w = np.linspace(0.0, 1.0, points - first)
        w = 1 - (1 - w) ** 2 if self.end in LOCKS else w
        return np.append(np.linspace(0.0, self.load_e, first, endpoint=False), self.load_e + (last - self.load_e) * w)

    def _values(self, loads: Array, last: float) -> dict[str, Array]:
        """Return every variable at load angles up to the end; ``last`` is the cut-off."""
        x, starts = loads / self.far, [piece.x0 for piece in self.pieces]
        # a place between two pieces belongs to the first
        which = np.clip(np.searchsorted(starts, x) - 1, 0, len(starts) - 1)
        found = {name: np.zeros(x.size) for name in straight(self.case, x)} | {"T": np.zeros(x.size)}
        contact, work, done = np.full(x.size, "", "U5"), np.zeros(x.size), 0.0
        for i, piece in enumerate(self.pieces):
            here = which == i
            if piece.contact:
                values, given = _touching(piece, x[here]), _work(piece, min(piece.x1, last / self.far))
                work[here] = done + given(x[here])
                done += float(given(min(piece.x1, last / self.far)))
                contact[here] = piece.contact
            else:
                values, work[here] = straight(self.case, loads[here]) | {"T": np.zeros(int(here.sum()))}, done
            for name, v in values.items():
                found[name][here] = v
        found["load"] = loads
        found["scales"] *= self.sign
        along = in_si(self.case, found, work)
        return along | {"T": self.case.stiffness * found["T"], "contact": contact}


def solve(asked: Asked) -> tuple[list[Bent], States]:
    """Solve what is asked up to the one bend of its path, for each coefficient of friction."""
    case, to = Case.of(asked.beam, "bending", asked.path.sense), abs(asked.path.values[-1])
    sign = -1 if case.mirrored else 1
    found = [_cut(case, list(_followed(of(asked, float(m)), sign)), asked.margin, to) for m in np.atleast_1d(asked.mus)]
    attrs: dict[str, float | str] = {"margin": asked.margin, "neutral": asked.neutral}
    return found, States({}, attrs, soft([piece for bent in found for piece in bent.pieces]))


def _followed(design: Design, sign: int) -> list[Piece]:
    """Follow a design as it is bent, ``sign`` -1 away from its scales, to its end or to the end of the search."""
    far = FIRST / design.eta
    while True:
        far = min(far, SEARCH)
        pieces = list(follow(design, [(sign * far, 0.0)]))
        if pieces[-1].end or far == SEARCH:
            return pieces
        far *= 2


def _cut(case: Case, pieces: list[Piece], margin: float, to: float) -> Bent:
    """Return a path that was followed, up to the bend ``to`` per pitch."""
    step, last = pieces[0].leg.step[0], pieces[-1]
    far = abs(step)
    first = next((piece for piece in pieces if piece.contact), None)
    load_e, load_end = (first.x0 * far if first else math.inf), last.x1 * far
    end = End(last.end or (End.RANGE if first else End.NONE))
    other, lock = last.other, math.inf
    if first:
        lock = float(first.states(np.array([first.x0]))["mu_lock"][0])
    if to < load_end:
        end, other, load_end = End.NONE if end is End.NONE else End.RANGE, "", to
    kept = tuple(piece for piece in pieces if piece.x1 > piece.x0 and piece.x0 * far < load_end)
    lock = lock if lock > 0 else math.inf
    return Bent(case, kept, end, other, load_e, load_end, margin, lock, 1 if step > 0 else -1)


def _theta(piece: Piece, x: float) -> float:
    """Return the inclination at a place of a piece."""
    return float(piece.states(np.array([x]))["theta"][0])


def _touching(piece: Piece, x: Array) -> dict[str, Array]:
    """Return a contact at places of a piece in units of K_theta and the pitch, by role."""
    state = piece.states(x)
    # where the contact opens the lift is zero but for rounding
    N = np.maximum(state["N"], 0.0)
    return {
        "theta": state["theta"],
        "scales": state["M"],
        # moment and bend change their signs together
        "tangent": piece.tangent(x) / piece.leg.step[0],
        "N": N,
        "f": piece.leg.design.mu * N,
        "p": np.full(x.size, np.nan),
        "s": piece.places(x)[2].along,
        "mu_lock": state["mu_lock"],
        # across the beam the two contacts of a flush edge cancel but for rounding
        "T": 0 * x if piece.leg.flush else state["T"],
    }


def _work(piece: Piece, x_stop: float) -> energy.Series:
    """Return the frictional work from the start of a piece on, W_fr d / K_theta."""
    return energy.work(piece, piece.x0, x_stop, pole_of(piece), piece.leg.design.mu, "")

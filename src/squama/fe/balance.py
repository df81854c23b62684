"""Equilibrium of scales against their neighbours: a small Newton solver whose steps never pass through a contact.

Unknowns are the six motions v at a given twist phi. The body that carries the scale is a callable, so that a stiffness
matrix and condensed finite elements use the same solver. Friction has the normal force and direction of the present
state in every iteration, and its tangent is exact, so no term lags behind near a lock.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from squama.fe.contact import RowContact
from squama.types import Array

Body = Callable[[Array, float], tuple[Array, Array, Array]]
"""Motions v (6,) and twist phi -> restoring force (6,) of the body, its derivatives by v (6, 6) and by phi (6,)."""

TOLERANCE = 1e-9
"""Residual force over the body's force below which a state counts as an equilibrium."""
_ROUNDING = 1e-6
"""Accepted relative residual where rounding prevents any further decrease."""
ROUNDS = 25
"""Largest number of Newton steps at one twist; larger for a row of scales, see :class:`Balance`."""
SUBSTEPS = 30
"""Largest number of stops on the way to a twist, each at a contact met on the way; larger for a row of scales."""
_SHRINK = 16
_LEAST, _NEAR = 1e-6, 1e-7
_FALL, _FALL_REACH = 100, 0.05
_REACH = 0.1


class Found(NamedTuple):
    """Result of a solution: motions ``v`` (6,) at the twist ``phi``; ``solved`` is false without an equilibrium there.

    ``rounds`` counts the Newton steps, ``rate`` (6,) is the derivative of v by phi with the present state of friction.
    """

    v: Array
    phi: float
    solved: bool
    rounds: int
    rate: Array


class Balance(NamedTuple):
    """Equations of equilibrium of the scales on one increment, with their solver.

    ``before`` (n, 3): corners at the end of the last increment, from which the slip of friction is counted; ``kappa``:
    the barrier's stiffness; ``ways`` (6, m): directions of motion, as columns; ``tolerance`` of the residual, relative
    to the force of the body; ``beat`` is called at each Newton step, as an increment of many scales takes minutes.
    """

    body: Body
    contact: RowContact
    before: Array | None
    kappa: float
    ways: Array
    tolerance: float = TOLERANCE
    beat: Callable[[], None] = lambda: None

    @property
    def _many(self) -> int:
        """Half the number of bodies: contacts of a row meet and stick one after the other."""
        return max(1, len(self.ways) // 12)

    def _state(self, v: Array, phi: float) -> _State:
        force, stiff, by_phi = self.body(v, phi)
        load, ways = self.contact.load(v, phi, self.before, self.kappa), self.ways
        total, tangent = force + load.total[:-1], load.tangent[:-1, :-1]
        scale = max(float(np.abs(force).max()), 1e-7 * float(np.abs(stiff).max()))
        by_phi = by_phi + load.tangent[:-1, -1]
        return _State(total, ways.T @ total, ways.T @ stiff @ ways, ways.T @ tangent @ ways, by_phi, scale)

    def find(self, v: Array, phi: float) -> Found:
        """Return the equilibrium at a twist (rad per pitch), from motions (6,) without interpenetration."""
        contact, ways = self.contact, self.ways
        places, now = contact.corners(v, phi), self._state(v, phi)
        metric = np.linalg.inv(_convex(now.stiff))
        rounds = 0
        while np.abs(now.r).max() > self.tolerance * now.scale and rounds < ROUNDS * self._many:
            rounds += 1
            self.beat()
            least = (now.r @ metric @ now.r) * (1 - 1e-4)
            for form in (np.asarray, _convex):
                new, v_new, there = None, v, places
                step = ways @ _solved(now.stiff + form(now.tangent), -now.r)
                step *= min(1.0, _REACH / max(float(np.abs(step).max()), 1e-300))
                for _ in range(_SHRINK):
                    v_new = v + step
                    there = contact.corners(v_new, phi)
                    clear = contact.free(places, there)
                    if clear == 1:
                        new = self._state(v_new, phi)
                        if new.r @ metric @ new.r < least:
                            break
                        new = None
                    step = step * min(clear, 0.5 if clear == 1 else 1.0)
                if new is not None:
                    break
            if new is None:
                break
            v, places, now = v_new, there, new
        rate = -ways @ _solved(now.stiff + now.tangent, ways.T @ now.by_phi)
        return Found(v, phi, bool(np.abs(now.r).max() <= max(self.tolerance, _ROUNDING) * now.scale), rounds, rate)

    def fall(self, v: Array, phi: float) -> Found:
        """Release a scale that is out of balance at a fixed twist, and return its state of rest.

        Every step decreases the energy, over any distance; friction counts the whole slip since ``before``. Where a
        contact slips off a corner, this finds the direction of the jump even if no equilibrium follows.
        """
        contact = self.contact
        for _ in range(_FALL):
            self.beat()
            now = self._state(v, phi)
            step = -self.ways @ np.linalg.solve(_convex(now.stiff + now.tangent), now.r)
            size = float(np.abs(step).max())
            if size < _NEAR:
                return self.find(v, phi)
            step *= min(1.0, _FALL_REACH / size)
            here, down = contact.corners(v, phi), abs(float(now.total @ step))
            for _ in range(4 * _SHRINK):
                clear = contact.free(here, contact.corners(v + step, phi))
                # not past the valley's floor
                floor = 0.5 * down * float(np.abs(step).max()) / min(size, _FALL_REACH)
                if clear == 1 and self._state(v + step, phi).total @ step <= floor:
                    break
                step = step * min(clear, 0.5 if clear == 1 else 1.0)
            v = v + step
        return Found(v, phi, False, _FALL, np.zeros_like(v))

    def advance(self, start: tuple[Array, float], goal: tuple[Array, float]) -> Found:
        """Advance from an equilibrium (v, phi) to another twist, with a stop where the straight path meets a contact.

        ``goal``: the predicted motions and the twist there. Returns the state at the goal, or the last one reached
        (``solved`` is false).
        """
        (v, phi), (guess, wanted) = start, goal
        contact, rounds = self.contact, 0
        for _ in range(SUBSTEPS * self._many):
            here, share = contact.corners(v, phi), 1.0
            there = _between(v, phi, guess, wanted, share)
            while share > _LEAST and (clear := contact.free(here, contact.corners(*there))) < 1:
                # again, since paths of points of rigid scales are slightly curved
                share *= clear
                there = _between(v, phi, guess, wanted, share)
            found = self.find(*there)
            rounds += found.rounds
            if not found.solved or share == 1:
                return found._replace(rounds=rounds)
            v, phi = found.v, found.phi
            # tangentially along the new contact
            guess = v + found.rate * (wanted - phi)
        return Found(v, phi, False, rounds, np.zeros_like(v))


class _State(NamedTuple):
    """Residual on all motions and on the ways; tangents of body and contact on the ways; rate with phi; scale."""

    total: Array
    r: Array
    stiff: Array
    tangent: Array
    by_phi: Array
    scale: float


def _convex(matrix: Array) -> Array:
    """Return the symmetric part of a matrix with eigenvalues replaced by magnitudes, at least 1e-6 of the largest."""
    values, axes = np.linalg.eigh((matrix + matrix.T) / 2)
    values = np.abs(values)
    top = float(values.max())
    return np.asarray((axes * np.maximum(values, 1e-6 * top)) @ axes.T) if top > 0 else matrix


def _solved(matrix: Array, r: Array) -> Array:
    try:
        return np.asarray(np.linalg.solve(matrix, r))
    except np.linalg.LinAlgError:
        return np.asarray(np.linalg.lstsq(matrix, r, rcond=None)[0])


def _between(v: Array, phi: float, guess: Array, wanted: float, share: float) -> tuple[Array, float]:
    return v + share * (guess - v), phi + share * (wanted - phi) if share < 1 else wanted


class Trail:
    """The last equilibria, for predictions of the next one and for the reference state of slip.

    Friction needs the direction of slip at the end of an increment, not along its chord; so slip is counted from a
    place extrapolated from two increments (second-order backward difference), and from the last place after a single
    increment or a reversal of the twist. ``past``: equilibria (state, phi, corners) in order, of which the last three
    are kept; a state is an array of unknowns that depend on the twist; ``rate``: its derivative by phi at the first.
    """

    def __init__(self, past: Sequence[tuple[Array, float, Array]], rate: Array | None = None) -> None:
        self.past = list(past)[-3:]
        self._rate = rate

    def add(self, state: Array, phi: float, corners: Array) -> None:
        """Append an equilibrium to the trail."""
        self.past = [*self.past[-2:], (state, phi, corners)]

    def _on(self, phi: float) -> float:
        """Return the step to a twist over the last step: above 0 onward, below 0 after a reversal, 0 at first."""
        if len(self.past) < 2:
            return 0.0
        return (phi - self.past[-1][1]) / (self.past[-1][1] - self.past[-2][1])

    def turns(self, phi: float) -> bool:
        """Return whether the twist reverses on the way to ``phi``."""
        return self._on(phi) < 0

    def expected(self, phi: float) -> Array:
        """Return the state extrapolated to a twist."""
        if len(self.past) == 1 and self._rate is not None:
            return np.asarray(self.past[0][0] + self._rate * (phi - self.past[0][1]))
        if not self._on(phi) > 0:
            return self.past[-1][0]
        (a, x), (b, y) = (e[:2] for e in self.past[-2:])
        rate = (b - a) / (y - x)
        if len(self.past) < 3 or (y - x) * (x - self.past[0][1]) <= 0:
            return np.asarray(b + rate * (phi - y))
        c, z = self.past[0][:2]
        bend = (rate - (a - c) / (x - z)) / (y - z)
        return np.asarray(b + (phi - y) * (rate + bend * (phi - x)))

    def before(self, phi: float) -> Array:
        """Return the corners (n, 3) from which slip is counted on the increment to a twist."""
        last, w = self.past[-1][2], self._on(phi)
        return last + (last - self.past[-2][2]) * (w * w / (1 + 2 * w)) if w > 0 else last

    def stretch(self, phi: float) -> float:
        """Return the factor from friction times slip since :meth:`before` to power times the increment."""
        w = max(self._on(phi), 0.0)
        return (1 + 2 * w) / (1 + w)

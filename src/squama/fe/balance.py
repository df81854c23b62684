"""Equilibrium of scales against their neighbours: a small Newton solver whose steps never pass through a contact.

Unknown are the six motions v at a given twist phi. The body that carries the scale enters through a callable, so that
a matrix and condensed finite elements use the same solver. Friction has the normal force and direction of the present
state in every iteration, and its tangent is exact, so near a lock nothing is lagged.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from squama.fe.contact import RowContact
from squama.types import Array

Body = Callable[[Array, float], tuple[Array, Array, Array]]
"""Motions v (6,) and twist phi -> force (6,) that the body opposes, its derivatives by v (6, 6) and by phi (6,)."""

TOLERANCE = 1e-9
"""Residual force over the body's force at which an equilibrium counts as found."""
_ROUNDING = 1e-6
"""The same where rounding lets no step make it smaller."""
ROUNDS = 25
"""Most Newton steps at one twist; a row of scales has more, see :class:`Balance`."""
SUBSTEPS = 30
"""Most stops on the way to a twist, each where a scale would otherwise pass through another; likewise."""
_SHRINK = 16
_LEAST, _NEAR = 1e-6, 1e-7
_FALL, _FALL_REACH = 100, 0.05
_REACH = 0.1


class Found(NamedTuple):
    """Motions ``v`` (6,) at the twist ``phi``; ``solved`` is false where no equilibrium was found there.

    ``rounds`` counts the Newton steps, ``residual`` is the largest force left over, and ``rate`` (6,) the derivative of
    v by phi as friction now acts.
    """

    v: Array
    phi: float
    solved: bool
    rounds: int
    residual: float
    rate: Array


class Balance(NamedTuple):
    """What scales are in balance with on one increment.

    Attributes
    ----------
    body : callable
        See :data:`Body`.
    contact : RowContact
        Contact with the neighbours.
    before : (n, 3) array
        Corners at the end of the last increment: friction follows the slip since then.
    kappa : float
        The barrier's stiffness, see :func:`squama.fe.contact.stiffness`.
    ways : (6, m) array
        Directions in which the scale can move; the identity for all.
    tolerance : float
        Of the residual, relative to the body's force.
    beat : callable, optional
        Called at each Newton step: a beam of many scales takes minutes for one increment.
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
        """Find the equilibrium at a twist (rad per pitch) from motions (6,) that do not pass through each other."""
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
        left = float(np.abs(now.r).max())
        rate = -ways @ _solved(now.stiff + now.tangent, ways.T @ now.by_phi)
        return Found(v, phi, left <= max(self.tolerance, _ROUNDING) * now.scale, rounds, left, rate)

    def fall(self, v: Array, phi: float) -> Found:
        """Let go of a scale that is not in balance, at a twist that stays, and find where it comes to rest.

        Every step leads downhill, however far; friction acts on the whole way since ``before``. Where a contact slips
        off a corner, this shows where the scales jump, even before they rest there.
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
        return Found(v, phi, False, _FALL, np.inf, np.zeros_like(v))

    def advance(self, start: tuple[Array, float], goal: tuple[Array, float]) -> Found:
        """Go from an equilibrium to another twist, with stops where the straight way there meets a contact.

        Parameters
        ----------
        start : (v, phi)
            Equilibrium.
        goal : (v, phi)
            Predicted motions at the wanted twist.

        Returns
        -------
        Found
            At the wanted twist, or where it did not go on (``solved`` is false).
        """
        (v, phi), (guess, wanted) = start, goal
        contact, rounds = self.contact, 0
        for _ in range(SUBSTEPS * self._many):
            here, share = contact.corners(v, phi), 1.0
            there = _between(v, phi, guess, wanted, share)
            while share > _LEAST and (clear := contact.free(here, contact.corners(*there))) < 1:
                # once more, since the way of the rigid scales is a little curved
                share *= clear
                there = _between(v, phi, guess, wanted, share)
            found = self.find(*there)
            rounds += found.rounds
            if not found.solved or share == 1:
                return found._replace(rounds=rounds)
            v, phi = found.v, found.phi
            # on along the contact that was met
            guess = v + found.rate * (wanted - phi)
        return Found(v, phi, False, rounds, np.inf, np.zeros_like(v))


class _State(NamedTuple):
    """Forces on all motions and on the ways; tangents of body and contact on the ways; rate with phi; size."""

    total: Array
    r: Array
    stiff: Array
    tangent: Array
    by_phi: Array
    scale: float


def _convex(matrix: Array) -> Array:
    """Return the symmetric part with its eigenvalues' magnitudes, at least a millionth of the largest."""
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
    """The last equilibria: where the next one is to be expected, and since when scales have slid.

    The direction of the slip at the end of an increment is wanted, not that of the increment's chord; so friction
    refers to a place extrapolated from two increments (the second-order backward difference), and to the last place
    where there is one increment only or the twist has turned back.

    Parameters
    ----------
    past : sequence of (state, phi, corners)
        Equilibria, the last one last; three at most are kept. A state is any array that the twist moves.
    rate : array, optional
        Derivative of the state by phi at the first one.
    """

    def __init__(self, past: Sequence[tuple[Array, float, Array]], rate: Array | None = None) -> None:
        self.past = list(past)[-3:]
        self._rate = rate

    def add(self, state: Array, phi: float, corners: Array) -> None:
        """Take an equilibrium into the trail."""
        self.past = [*self.past[-2:], (state, phi, corners)]

    def _on(self, phi: float) -> float:
        """Return the step to a twist over the last one: above 0 the same way, below 0 where it turns, 0 at first."""
        if len(self.past) < 2:
            return 0.0
        return (phi - self.past[-1][1]) / (self.past[-1][1] - self.past[-2][1])

    def turns(self, phi: float) -> bool:
        """Tell whether the twist turns round on the way there."""
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
        """Return the corners (n, 3) since which the slip at a twist is to be counted."""
        last, w = self.past[-1][2], self._on(phi)
        return last + (last - self.past[-2][2]) * (w * w / (1 + 2 * w)) if w > 0 else last

    def stretch(self, phi: float) -> float:
        """Return what turns friction times slip since :meth:`before` into its rate times the increment."""
        w = max(self._on(phi), 0.0)
        return (1 + 2 * w) / (1 + w)

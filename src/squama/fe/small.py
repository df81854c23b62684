"""Equilibrium of scales against their neighbours: a small Newton solver whose steps never pass through a contact.

Unknown are the six motions v at a given twist phi. The body that carries the scale enters through a callable, so that
a matrix and condensed finite elements use the same solver. Friction has the normal force and direction of the present
state in every iteration, and its tangent is exact, so near a lock nothing is lagged.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple, Protocol

import numpy as np

from squama.fe.plate import Array

Body = Callable[[Array, float], tuple[Array, Array, Array]]
"""Motions v (6,) and twist phi -> force (6,) that the body opposes, its derivatives by v (6, 6) and by phi (6,)."""

TOLERANCE = 1e-9
"""Residual force over the body's force at which an equilibrium counts as found."""
_ROUNDING = 1e-6
"""The same where rounding lets no step make it smaller."""
ROUNDS = 25
"""Most Newton steps at one twist; a row of scales has more, see :func:`_many`."""
SUBSTEPS = 30
"""Most stops on the way to a twist, each where a scale would otherwise pass through another; likewise."""
_SHRINK = 16
_LEAST, _NEAR = 1e-6, 1e-7
_FALL, _FALL_REACH = 100, 0.05
_REACH = 0.1


class _Load(Protocol):
    @property
    def tangent(self) -> Array: ...
    @property
    def total(self) -> Array: ...


class Neighbours(Protocol):
    """Contact as the solver needs it: :class:`squama.fe.contact.HelixContact` or another."""

    def corners(self, v: Array, phi: float) -> Array:
        """Return places that tell whether a motion is free."""
        ...

    def load(self, v: Array, phi: float, before: Array | None, kappa: float) -> _Load:
        """Return the work's derivatives by (v, phi)."""
        ...

    def free(self, start: Array, end: Array) -> float:
        """Return the fraction of a motion that no contact stops."""
        ...


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


def balance(
    body: Body,
    contact: Neighbours,
    v: Array,
    phi: float,
    before: Array | None,
    kappa: float,
    ways: Array,
    *,
    tolerance: float = TOLERANCE,
) -> Found:
    """Find the equilibrium at a twist from motions v that do not touch too deep.

    Parameters
    ----------
    body : callable
        See :data:`Body`.
    contact : Neighbours
        Contact with the neighbours.
    v : (6,) array
        Start; the corners must not pass through each other there.
    phi : float
        Twist per pitch, rad.
    before : (n, 3) array
        Corners at the end of the last increment: friction follows the slip since then.
    kappa : float
        The barrier's stiffness, see :func:`squama.fe.contact.stiffness`.
    ways : (6, m) array
        Directions in which the scale can move; the identity for all.
    tolerance : float
        Of the residual, relative to the body's force.

    Returns
    -------
    Found
    """
    places = contact.corners(v, phi)

    def state(v: Array) -> _State:
        force, stiff, by_phi = body(v, phi)
        load = contact.load(v, phi, before, kappa)
        scale = max(float(np.abs(force).max()), 1e-7 * float(np.abs(stiff).max()))
        r = ways.T @ (force + load.total[:-1])
        return _State(
            r, ways.T @ stiff @ ways, ways.T @ load.tangent[:-1, :-1] @ ways, by_phi + load.tangent[:-1, -1], scale
        )

    now = state(v)
    metric = np.linalg.inv(_convex(now.stiff))
    rounds = 0
    while np.abs(now.r).max() > tolerance * now.scale and rounds < ROUNDS * _many(ways):
        rounds += 1
        least = (now.r @ metric @ now.r) * (1 - 1e-4)
        for contact_part in (now.tangent, _convex(now.tangent)):
            new, v_new, there = None, v, places
            step = ways @ _solved(now.stiff + contact_part, -now.r)
            step *= min(1.0, _REACH / max(float(np.abs(step).max()), 1e-300))
            for _ in range(_SHRINK):
                v_new, clear = v + step, 1.0
                there = contact.corners(v_new, phi)
                clear = contact.free(places, there)
                if clear == 1:
                    new = state(v_new)
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
    return Found(v, phi, left <= max(tolerance, _ROUNDING) * now.scale, rounds, left, rate)


def fall(
    body: Body,
    contact: Neighbours,
    v: Array,
    phi: float,
    before: Array | None,
    kappa: float,
    ways: Array,
) -> Found:
    """Let go of a scale that is not in balance, at a twist that stays, and find where it comes to rest.

    Every step leads downhill, however far; friction acts on the whole way since ``before``. Parameters as in
    :func:`balance`. Where a contact slips off a corner, this shows where the scales jump, even before they rest there.
    """
    for _ in range(_FALL):
        force, stiff, _ = body(v, phi)
        load = contact.load(v, phi, before, kappa)
        r = ways.T @ (force + load.total[:-1])
        step = -ways @ np.linalg.solve(_convex(ways.T @ (stiff + load.tangent[:-1, :-1]) @ ways), r)
        size = float(np.abs(step).max())
        if size < _NEAR:
            return balance(body, contact, v, phi, before, kappa, ways)
        step *= min(1.0, _FALL_REACH / size)
        here, down = contact.corners(v, phi), abs(float((force + load.total[:-1]) @ step))
        for _ in range(4 * _SHRINK):
            clear = contact.free(here, contact.corners(v + step, phi))
            if clear == 1:
                there = body(v + step, phi)[0] + contact.load(v + step, phi, before, kappa).total[:-1]
                # not past the valley's floor
                if there @ step <= 0.5 * down * float(np.abs(step).max()) / min(size, _FALL_REACH):
                    break
            step = step * min(clear, 0.5 if clear == 1 else 1.0)
        v = v + step
    return Found(v, phi, False, _FALL, np.inf, np.zeros_like(v))


def _many(ways: Array) -> int:
    """Return half the number of bodies: contacts of a row meet and stick one after the other."""
    return max(1, len(ways) // 12)


class _State(NamedTuple):
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


def advance(
    body: Body,
    contact: Neighbours,
    start: tuple[Array, float],
    goal: tuple[Array, float],
    before: Array | None,
    kappa: float,
    ways: Array,
    *,
    tolerance: float = TOLERANCE,
) -> Found:
    """Go from an equilibrium to another twist, with stops where the straight way there meets a contact.

    Parameters
    ----------
    start : (v, phi)
        Equilibrium.
    goal : (v, phi)
        Predicted motions at the wanted twist.
    body, contact, before, kappa, ways, tolerance
        As in :func:`balance`.

    Returns
    -------
    Found
        At the wanted twist, or where it did not go on (``solved`` is false).
    """
    (v, phi), (guess, wanted) = start, goal
    rounds = 0
    for _ in range(SUBSTEPS * _many(ways)):
        here = contact.corners(v, phi)
        share = 1.0
        while (
            share > _LEAST
            and (clear := contact.free(here, contact.corners(*_between(v, phi, guess, wanted, share)))) < 1
        ):
            # once more, since the way of the rigid scales is a little curved
            share *= clear
        found = balance(
            body, contact, *_between(v, phi, guess, wanted, share), before, kappa, ways, tolerance=tolerance
        )
        rounds += found.rounds
        if not found.solved or share == 1:
            return found._replace(rounds=rounds)
        v, phi = found.v, found.phi
        # on along the contact that was met
        guess = v + found.rate * (wanted - phi)
    return Found(v, phi, False, rounds, np.inf, np.zeros_like(v))


def _between(v: Array, phi: float, guess: Array, wanted: float, share: float) -> tuple[Array, float]:
    return v + share * (guess - v), phi + share * (wanted - phi) if share < 1 else wanted


class Trail:
    """The last equilibria: where the next one is to be expected, and since when scales have slid.

    The direction of the slip at the end of an increment is wanted, not that of the increment's chord; so friction
    refers to a place extrapolated from two increments (the second-order backward difference), and to the last place
    where there is one increment only or the twist has turned back.
    """

    def __init__(self, v: Array, phi: float, corners: Array) -> None:
        self.past = [(v, phi, corners)]

    @classmethod
    def of(cls, past: list[tuple[Array, float, Array]]) -> Trail:
        """Return the trail of equilibria (v, phi, corners), at most three, the last one last."""
        trail = cls(*past[-1])
        trail.past = past
        return trail

    def add(self, v: Array, phi: float, corners: Array) -> None:
        """Take an equilibrium into the trail."""
        self.past = [*self.past[-2:], (v, phi, corners)]

    @property
    def last(self) -> tuple[Array, float]:
        """The last equilibrium."""
        return self.past[-1][:2]

    def _same_way(self, phi: float) -> bool:
        return len(self.past) > 1 and (phi - self.past[-1][1]) * (self.past[-1][1] - self.past[-2][1]) > 0

    def expected(self, phi: float) -> Array:
        """Return the motions (6,) extrapolated to a twist."""
        if not self._same_way(phi):
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
        last = self.past[-1][2]
        return last + (last - self.past[-2][2]) * self._carry(phi) if self._same_way(phi) else last

    def _carry(self, phi: float) -> float:
        w = (phi - self.past[-1][1]) / (self.past[-1][1] - self.past[-2][1])
        return w * w / (1 + 2 * w)

    def stretch(self, phi: float) -> float:
        """Return what turns friction times slip since :meth:`before` into its rate times the increment."""
        if not self._same_way(phi):
            return 1.0
        w = (phi - self.past[-1][1]) / (self.past[-1][1] - self.past[-2][1])
        return (1 + 2 * w) / (1 + w)

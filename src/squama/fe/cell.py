"""The periodic cell: one pitch of finite elements with its rigid scale, in frictional contact with the scale's images.

Geometrically nonlinear quadratic elements, helical periodicity x(X + e_z) = Q(phi) x(X) + e_z, Coulomb contact. Every
increment is a Newton iteration in two levels: the elements are factorised once an iteration and condensed exactly onto
the scale's six motions, on which the contact problem is solved to convergence. The section's mean place and turn are
held in the twisted frame (a lateral shift is a null mode at phi = 0).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from squama.fe.body import Body, Reduced, Section
from squama.fe.contact import DHAT, SLIP, HelixContact, Touch, stiffness
from squama.fe.elements import Elements, Material
from squama.fe.plate import MOTIONS, Attached, Helix, inclination
from squama.fe.small import Trail, advance, balance

Array = NDArray[np.float64]

FREE = np.eye(6)
HINGED = FREE[:, [0, 1, 2, 4]]
"""Roll (about n_X) and yaw (about n_Z) blocked, as in a hinge."""
ITERATIONS = 12
TOLERANCE = 1e-7
"""Change of a place, in pitches, at which an increment has converged."""
JUMP = 0.02
"""Largest distance of an equilibrium from where the last ones point; beyond, the increment is halved."""
_FIRST = 1e-3
COLUMNS = ("phi", "theta", *MOTIONS, "T", "N", "f", "U", "W_fr", "W", "gap", "p", "s", "k", "iterations", "unbalanced")
"""What is recorded of every increment; lengths in pitches, torques in E d^3, forces in E d^2, works in E d^3."""


class Increment(NamedTuple):
    """What a listener is told: the twist reached and wanted, Newton steps, largest force left, steps halved so far."""

    phi: float
    goal: float
    iterations: int
    unbalanced: float
    halvings: int


class Ended(NamedTuple):
    """How a run ended: ``reached`` the goal, or the sentence that says why not."""

    reached: bool
    sentence: str


def make_body(pitch: Any, geometry: Any, material: Material) -> tuple[Body, Array]:
    """Return the body of one pitch with its scale tied in, and the masters' places at rest.

    Parameters
    ----------
    pitch : squama.fe.mesh.Pitch
        The mesh.
    geometry : squama.fe.geometry.Geometry
        Its scale.
    """
    n = len(pitch.nodes)
    image = np.zeros(n, bool)
    image[pitch.back] = True
    masters = np.flatnonzero(~image)
    number = np.full(n, -1)
    number[masters] = np.arange(masters.size)
    number[pitch.back] = number[pitch.front]
    rest = pitch.nodes[masters]
    elements = Elements(pitch.nodes, pitch.tets, material, number, image)
    tied = number[pitch.tied]
    body = Body(elements, [(tied, Attached(geometry, rest[tied]))], _front(pitch, number, rest))
    return body, rest


def _front(pitch: Any, number: NDArray[np.int64], rest: Array) -> Section:
    """Return the front section; a quadratic triangle's mean is that of the middles of its edges."""
    on = np.zeros(len(pitch.nodes), bool)
    on[pitch.front] = True
    triangles = pitch.surface[on[pitch.surface].all(1)]
    corners = pitch.nodes[triangles[:, :3]]
    areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) / 2
    weights = np.zeros(len(rest))
    np.add.at(weights, number[triangles[:, 3:]], areas[:, None] / 3)
    nodes = np.flatnonzero(weights)
    return Section(nodes, rest[nodes], weights[nodes])


class Cell:
    """A periodic cell on its way along a history of the twist.

    Parameters
    ----------
    pitch, geometry
        Mesh of one pitch and what it is a mesh of.
    mu : float
        Coefficient of friction.
    sense : int
        1, or -1 to twist the other way.
    hinged : bool
        Block roll and yaw of the scale.
    dhat, slip : float
        See :mod:`squama.fe.contact`.
    """

    def __init__(
        self,
        pitch: Any,
        geometry: Any,
        mu: float,
        *,
        hinged: bool = False,
        dhat: float = DHAT,
        slip: float = SLIP,
    ) -> None:
        self.geometry, self.ways = geometry, HINGED if hinged else FREE
        self.body, self.rest = make_body(pitch, geometry, Material(1.0, geometry.nu))
        self.contact = HelixContact(Helix(geometry), mu, dhat=dhat, slip=slip)
        self.z, self.v, self.phi = self.body.start(self.rest), np.zeros(6), 0.0
        self._rate = np.zeros_like(self.z)
        self.dhat = dhat
        self.kappa = stiffness(_FIRST, dhat)
        self.before = self.contact.corners(self.v, self.phi)
        self.trail = Trail(self.v, self.phi, self.before)
        self.W_fr = self.W = self._power = self.T = 0.0
        self.rows: list[tuple[float, ...]] = []
        self.touch: Touch | None = None
        self.pairs: list[tuple[float, str]] = []
        self.halvings = 0

    def run(
        self,
        goal: float,
        increment: float,
        *,
        told: Callable[[Increment], None] | None = None,
        stop: Callable[[], bool] | None = None,
    ) -> Ended:
        """Go on to a twist in increments, halved where one does not converge.

        Parameters
        ----------
        goal : float
            Twist per pitch, rad; negative for the other sense.
        increment : float
            Largest increment.
        told : callable, optional
            Called after each increment.
        stop : callable, optional
            Asked after each increment whether to stop.
        """
        if not self.rows:
            reduced = self.body.reduce(self.z, self.v[None], 0.0)
            assert reduced is not None
            self._rate = self._at_rest(reduced)
            self._record(reduced, 0)
        step, least = np.sign(goal - self.phi) * abs(increment), abs(increment) / 2**7
        why = ""
        while self.phi != goal:
            left = goal - self.phi
            count = max(1, int(np.ceil(abs(left) / abs(step) - 1e-9)))
            there = goal if count == 1 else self.phi + left / count
            why = self._increment(there)
            if why:
                self.halvings += 1
                step = (there - self.phi) / 2
                if abs(step) < least:
                    return Ended(False, f"stopped at phi = {self.phi:.4f} rad per pitch: {why}")
                continue
            if told is not None:
                last = self.rows[-1]
                told(Increment(self.phi, goal, int(last[-2]), last[-1], self.halvings))
            step = np.sign(left) * min(abs(step) * 1.5, abs(increment))
            if stop is not None and stop() and self.phi != goal:
                return Ended(False, f"interrupted at phi = {self.phi:.4f} rad per pitch")
        return Ended(True, "the asked twist was reached")

    def _at_rest(self, reduced: Reduced) -> Array:
        """Rates of the free unknowns at rest, without contact."""
        W = self.ways
        self._v_rate = -W @ np.linalg.solve(W.T @ reduced.S @ W, W.T @ reduced.s_phi)
        return reduced.update(self._v_rate, 1.0) - reduced.correction

    def _increment(self, phi: float) -> str:
        """Go to a twist; the reason if that fails, and nothing has changed then."""
        first = len(self.rows) == 1
        step = phi - self.phi
        expected = self.v + self._v_rate * step if first else self.trail.expected(phi)
        before = self.trail.before(phi)
        z, v = self.z + self._rate * step, expected
        for iteration in range(1, ITERATIONS + 1):
            reduced = self.body.reduce(z, v[None], phi)
            if reduced is None:
                return "elements at the plate's edge invert; a finer mesh there or less twist may help"
            at, here = v, reduced

            def linear(u: Array, x: float, at: Array = at, r: Reduced = here) -> tuple[Array, Array, Array]:
                return r.s + r.S @ (u - at) + r.s_phi * (x - phi), r.S, r.s_phi

            if iteration == 1:
                found = advance(
                    linear, self.contact, (self.v, self.phi), (expected, phi), before, self.kappa, self.ways
                )
            else:
                found = balance(linear, self.contact, v, phi, before, self.kappa, self.ways)
            if not found.solved:
                return "the contact's balance was not found"
            change = reduced.update(found.v - v)
            z, moved, v = z + change, np.abs(found.v - v).max(), found.v
            if max(np.abs(change[: 3 * self.body.free.size]).max(), moved) < TOLERANCE:
                break
        else:
            return f"no balance within {ITERATIONS} iterations"
        if np.abs(v - expected).max() > JUMP:
            return "the next equilibrium is a jump away"
        self._take(z, v, phi, before, reduced, iteration)
        return ""

    def _take(self, z: Array, v: Array, phi: float, before: Array, reduced: Reduced, iterations: int) -> None:
        step, T, power = phi - self.phi, self.T, self._power
        stretch = self.trail.stretch(phi) / step
        self._rate = (z - self.z) / step
        self.z, self.v, self.phi, self.before = z, v, phi, before
        slid = self._record(reduced, iterations, T=T, step=step, power=power, stretch=stretch)
        self.trail.add(v, phi, self.contact.corners(v, phi))
        self._power = slid * stretch
        if self.rows[-1][COLUMNS.index("N")] > 0:
            wanted = stiffness(self.rows[-1][COLUMNS.index("N")], self.dhat)
            self.kappa = float(np.clip(wanted, self.kappa / 2, self.kappa * 2))

    def _record(
        self,
        reduced: Reduced,
        iterations: int,
        *,
        T: float = 0.0,
        step: float = 0.0,
        power: float = 0.0,
        stretch: float = 0.0,
    ) -> float:
        load = self.contact.load(self.v, self.phi, self.before, self.kappa)
        self.T = reduced.torque + float(load.total[6])
        self.W += (T + self.T) / 2 * step
        self.W_fr += (power + load.slid * stretch) / 2 * step
        N, f = load.resultant.N, load.resultant.f
        corners = self.contact.corners(self.v, self.phi)
        touches = self.contact.contact.touches(corners, self.kappa) if N > 0 else []
        self.touch = touches[0] if touches else None
        pair = f"{self.touch.pair} (k = {self.touch.second})" if self.touch else ""
        if pair != (self.pairs[-1][1] if self.pairs else ""):
            self.pairs.append((self.phi, pair))
        p, s, k = (self.touch.p, self.touch.s, self.touch.second) if self.touch else (np.nan, np.nan, 0)
        row = (
            self.phi, inclination(self.geometry, self.v), *self.v, self.T, N, f, reduced.energy, self.W_fr, self.W,
            self.contact.contact.gap(corners, self.dhat), p, s, k, iterations, reduced.unbalanced,
        )  # fmt: skip
        self.rows.append(tuple(float(x) for x in row))
        return load.slid

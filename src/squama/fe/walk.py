"""Scales in frictional contact along a history of the twist, on a stiffness matrix or on elements of the substrate.

Every increment is a Newton iteration in two levels: the body is condensed onto the motions (elements are factorised
once an iteration), and on these the contact problem is solved to convergence. The first iteration goes from the last
equilibrium to the predicted one without passing through a contact. Predictions and steps that would invert an element
are shortened.
"""

from __future__ import annotations

import io
import json
import os
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from squama.errors import InputError, refuse
from squama.fe.balance import Balance, Found, Trail
from squama.fe.body import Bent, Body, Matrix, Reduced
from squama.fe.contact import Load, RowContact, Touch, stiffness
from squama.fe.periodic import STRAINS, Leg
from squama.io import files
from squama.people import per_pitch
from squama.types import Array

ITERATIONS = 12
TOLERANCE = 1e-7
"""Change of a place, pitches, below which an increment has converged."""
JUMP = 0.02
"""Largest distance of an equilibrium from its prediction, pitches; beyond, the increment is halved."""
_FIRST, _HALVINGS = 1e-3, 7
"""Expected force at the first contact, E d^2; largest number of halvings of an increment."""
_STARTS, _STEPS = (1.0, 0.5, 0.25, 0.0), tuple(0.5**i for i in range(8))
"""Shares of a prediction and of a Newton step that are tried in turn, to avoid inverted elements."""
_FARTHER = 1 / 16
"""Share of an increment by which the twist advances before the scales are released."""
_INVERTED = "elements invert, most likely at a scale's embedded edge: other element sizes may go further"
_COLUMN = "column_"
_KEPT = ("numbers", "past_states", "past_phi", "past_corners")
"""Arrays of a restart file, besides one for each column."""


class Doing(NamedTuple):
    """Progress within an increment: its goal ``toward`` (twist), its iteration, and Newton steps of the contact."""

    toward: float
    iteration: int = 0
    rounds: int = 0


class Ended(NamedTuple):
    """End of a run: whether it ``reached`` the goal, and a sentence with the reason if not."""

    reached: bool
    sentence: str


Recorded = dict[str, float | str | Array]
Recorder = Callable[["Walk"], Recorded]
"""Return the recorded values of an equilibrium by name: numbers, arrays of numbers, words."""


class Walk:
    """A body with scales, and its sequence of equilibria along a history of the twist.

    ``ways`` (m, k): directions of motion, as columns; ``record``: values for the ``columns`` at every equilibrium, the
    state at rest first; an increment may go ``slack`` times as far as :data:`JUMP`.

    The last equilibrium is ``z``, ``v``, ``phi``, ``T``: free unknowns, motions, twist per pitch, torque (where a beam
    is bent and twisted, the way along the path and the derivative of the work by it), with the body and the contact
    there, ``reduced``, ``load`` and ``touches``, once a run has begun. ``W``, ``W_fr``: work of the torque and of
    friction, E d^3. ``columns``: recorded values by name, with ``iterations`` and ``unbalanced``.
    """

    def __init__(
        self,
        body: Body | Matrix | Bent,
        contact: RowContact,
        ways: Array,
        record: Recorder | None = None,
        *,
        slack: float = 1.0,
    ) -> None:
        self.body, self.contact, self.ways = body, contact, ways
        self._record, self._slack = record, slack
        self.z, self.v, self.phi = body.start(), np.zeros(len(ways)), 0.0
        self.kappa = stiffness(_FIRST, contact.dhat)
        self.trail = Trail([(np.append(self.z, self.v), self.phi, contact.corners(self.v, self.phi))])
        self.T = self.W = self.W_fr = self._power = 0.0
        self.reduced: Reduced
        self.load: Load
        self.touches: list[Touch] = []
        self.columns: dict[str, list[float | str | Array]] = {}
        self.iterations = self.halvings = 0
        self._begun = False
        self._doing = Doing(0.0)
        self._watch: Callable[[Doing], None] | None = None

    @property
    def N(self) -> float:
        """Normal force of the pair with the largest one, E d^2."""
        return self.load.strongest.N

    @property
    def touch(self) -> Touch | None:
        """The strongest contact."""
        return self.touches[0] if self.touches else None

    @property
    def deflection(self) -> float:
        """Largest displacement of a point of a scale's surface by bending, pitches."""
        row = self.contact.row
        count = row.exposed.amplitudes, row.moving
        moved = row.exposed.modes @ self.v[self.v.size - count[0] * count[1] :].reshape(count[::-1]).T
        return float(np.sqrt((moved**2).sum(axis=1).max()))

    def places(self) -> Array:
        """Return the places (n, 3) of the masters."""
        return self.body.places(self.z, self.v, self.phi)

    def works(self, within: float = np.inf) -> dict[str, float]:
        """Return strain energy, works, and the least gap between scales, inf beyond ``within``, by name."""
        gap = self.contact.gap(self.contact.corners(self.v, self.phi), within)
        return {"U_el": self.reduced.energy, "W_fr": self.W_fr, "W": self.W, "gap": gap}

    def run(
        self,
        goal: float,
        increment: float,
        *,
        told: Callable[[], None] | None = None,
        stop: Callable[[], bool] | None = None,
        watch: Callable[[Doing], None] | None = None,
    ) -> Ended:
        """Advance to a twist per pitch (rad, negative in the other sense) in increments, halved where one fails.

        After each increment ``told`` is called, and ``stop``, which returns whether to stop; ``watch`` at each of its
        steps.
        """
        self._watch = watch
        if not self._begun:
            self.begin()
        step, least = float(np.sign(goal - self.phi)) * abs(increment), abs(increment) / 2**_HALVINGS
        while self.phi != goal:
            left = goal - self.phi
            count = max(1, int(np.ceil(abs(left) / abs(step) - 1e-9)))
            there = goal if count == 1 else self.phi + left / count
            why = self._increment(there)
            if why:
                self.halvings += 1
                step = (there - self.phi) / 2
                if abs(step) < least:
                    return Ended(False, f"stopped at {per_pitch(self.phi, 4)}: {why}")
                continue
            if told is not None:
                told()
            step = float(np.sign(left)) * min(abs(step) * 1.5, abs(increment))
            if stop is not None and stop() and self.phi != goal:
                return Ended(False, f"interrupted at {per_pitch(self.phi, 4)}; the same command goes on")
        return Ended(True, "the asked twist was reached")

    def aim(self, bend: float, twist: float) -> float:
        """Begin a straight leg of the path towards bend and twist (rad per pitch); return the way at its end."""
        leg = self.contact.row.course
        if type(leg) is not Leg:
            message = "the beam is not one to be bent: make it by squama.fe.assembly.make_bent"
            raise TypeError(message)
        step = np.array([twist, bend, 0.0]) - leg.at(np.zeros_like(self.v), self.phi)
        length = float(np.linalg.norm(step))
        if not length:
            return self.phi
        leg.turn(step / length, self.phi)
        if self._begun and (reduced := self.body.reduce(self.z, self.v, self.phi)) is not None:
            self.trail = Trail(self.trail.past[-1:], self._rates(reduced))
            self.T, self._power = reduced.torque + float(self.load.total[6 : 6 + STRAINS] @ leg.rate), 0.0
        return self.phi + length

    def begin(self) -> None:
        """Set the state at rest and its derivatives by the twist, without contact; refuse elements without volume."""
        reduced = self.body.reduce(self.z, self.v, 0.0)
        if reduced is None:
            message = "an element has no volume at rest: take another element size"
            raise InputError(message)
        self._begun, self.trail = True, Trail(self.trail.past, self._rates(reduced))
        self._keep(self.z, self.v, 0.0, reduced, self.contact.load(self.v, 0.0, None, self.kappa))

    def _rates(self, reduced: Reduced) -> Array:
        """Return the derivatives of the state by the way without previous slip; scales in contact do not move."""
        W, rate = self.ways, np.zeros_like(self.v)
        if not self.touches:
            rate = -W @ np.linalg.solve(W.T @ reduced.S @ W, W.T @ reduced.s_phi)
        z_rate = reduced.update(rate, 1.0) - reduced.update(np.zeros_like(rate))
        return np.append(z_rate, rate)

    def _increment(self, phi: float) -> str:
        """Advance to a twist; return the reason if that fails, with the state unchanged, else ""."""
        body = self.body
        # predict free unknowns and motions alike, else elements beside the scales are inverted
        predicted = self.trail.expected(phi)
        z, expected = predicted[: self.z.size], predicted[self.z.size :]
        before = self.trail.before(phi)
        start = self._as_far(_STARTS, (self.z, self.v), (z - self.z, expected - self.v), phi)
        if start is None:
            return _INVERTED
        z, v, reduced, _ = start
        # a shortened step may end within a contact: then start from the last equilibrium again
        short = False
        self._doing = Doing(phi)
        for iteration in range(1, ITERATIONS + 1):
            self._doing = self._doing._replace(iteration=iteration)
            balance = Balance(reduced.linear, self.contact, before, self.kappa, self.ways, beat=self._beat)
            again = iteration == 1 or short
            found = balance.advance((self.v, self.phi), (v, phi)) if again else balance.find(v, phi)
            if not found.solved:
                return "no balance of the contact was found"
            if not body.places_free:
                # a matrix is the same at all states
                v = found.v
                reduced = reduced if (there := body.reduce(z, v, phi)) is None else there
                break
            dv = found.v - v
            change = reduced.update(dv)
            if max(float(np.abs(change[: body.places_free]).max()), float(np.abs(dv).max())) < TOLERANCE:
                z, v = z + change, found.v
                break
            taken = self._as_far(_STEPS, (z, v), (change, dv), phi)
            if taken is None:
                return _INVERTED
            z, v, reduced, short = taken
        else:
            return f"no balance within {ITERATIONS} iterations"
        if np.abs(v - expected).max() > JUMP * self._slack:
            return "the next equilibrium is a jump away"
        self.iterations = iteration
        self._keep(z, v, phi, reduced, self.contact.load(v, phi, before, self.kappa))
        return ""

    def _beat(self) -> None:
        """Count a Newton step of the contact, and report it to the watcher."""
        self._doing = self._doing._replace(rounds=self._doing.rounds + 1)
        if self._watch is not None:
            self._watch(self._doing)

    def _as_far(
        self, shares: Sequence[float], at: tuple[Array, Array], by: tuple[Array, Array], phi: float
    ) -> tuple[Array, Array, Reduced, bool] | None:
        """Take the largest share of a step of unknowns and motions that inverts no element; return also whether cut."""
        for share in shares:
            z, v = (here + share * step for here, step in zip(at, by, strict=True))
            reduced = self.body.reduce(z, v, phi)
            if reduced is not None:
                return z, v, reduced, share < 1
        return None

    def _keep(self, z: Array, v: Array, phi: float, reduced: Reduced, load: Load) -> None:
        """Store an equilibrium: works up to it, contacts, and recorded values."""
        T, step = reduced.torque + float(load.total[-1]), phi - self.phi
        corners = self.contact.corners(v, phi)
        if step:
            power = load.slid * self.trail.stretch(phi) / step
            # at a reversal of the twist the contact does not slide yet
            past = 0.0 if self.trail.turns(phi) else self._power
            self.W += (self.T + T) / 2 * step
            self.W_fr += (past + power) / 2 * step
            self._power = power
            self.trail.add(np.append(z, v), phi, corners)
        self.z, self.v, self.phi, self.T, self.reduced, self.load = z, v, phi, T, reduced, load
        self.touches = self.contact.touches(corners, self.kappa) if self.N > 0 else []
        if self._record is not None:
            effort = {"iterations": self.iterations, "unbalanced": reduced.unbalanced}
            for name, value in {**self._record(self), **effort}.items():
                self.columns.setdefault(name, []).append(value)
        if self.N > 0:
            # keep the gap near dhat / 2
            self.kappa = float(np.clip(stiffness(self.N, self.contact.dhat), self.kappa / 2, self.kappa * 2))

    def let_go(self, way: float, increment: float) -> Found | None:
        """Release the scales a little beyond the last equilibrium; return their state of rest, None if it is unchanged.

        The body acts by its tangent at the last equilibrium. Where the scales leave, the next equilibrium is a jump
        away (a limit point): energy is lost in the jump, and the curve of equilibria ends. ``way``: sign of the sense
        in which the twist goes on; ``increment``: the largest, rad per pitch.
        """
        reduced = self.body.reduce(self.z, self.v, self.phi)
        if reduced is None:
            return None
        phi = self.phi + float(np.sign(way)) * abs(increment) * _FARTHER
        v = self.trail.expected(phi)[self.z.size :]
        if self.contact.free(self.contact.corners(self.v, self.phi), self.contact.corners(v, phi)) < 1:
            v, phi = self.v, self.phi
        self._doing = Doing(phi)
        balance = Balance(reduced.linear, self.contact, self.trail.before(phi), self.kappa, self.ways, beat=self._beat)
        found = balance.fall(v, phi)
        return found if np.abs(found.v - self.v).max() > JUMP else None

    def explained(self, ended: Ended, goal: float, increment: float) -> Ended:
        """Return the end of a run to a twist, with a sentence on the snap where the scales jump."""
        if ended.reached or "invert" in ended.sentence or (found := self.let_go(goal - self.phi, increment)) is None:
            return ended
        moved = self.contact.corners(found.v, found.phi) - self.contact.corners(self.v, self.phi)
        away = float(np.linalg.norm(moved, axis=1).max())
        words = f"come to rest {away:.2g} pitches away" if found.solved else f"move {away:.2g} pitches or farther"
        return Ended(
            False,
            f"stopped at {per_pitch(self.phi, 4)}: the scales snap there; let go, they {words}, energy is "
            "lost on the way, and the curve ends",
        )

    def save(self, path: Path, key: dict[str, object]) -> None:
        """Write the state to a restart file, whole or not at all; :meth:`resume` refuses a run with another key."""
        states, twists, corners = zip(*self.trail.past, strict=True)
        arrays: dict[str, Any] = {
            "numbers": np.array([self.phi, self.kappa, self.T, self.W, self.W_fr, self._power, self.halvings]),
            "past_states": np.array(states),
            "past_phi": np.array(twists),
            "past_corners": np.array(corners),
        } | {f"{_COLUMN}{name}": np.array(values) for name, values in self.columns.items()}

        made = io.BytesIO()
        np.savez(made, key=json.dumps(key, sort_keys=True), **arrays)

        def write(place: Path) -> None:
            with place.open("wb") as out:
                out.write(files.sealed(made.getvalue()))
                out.flush()
                os.fsync(out.fileno())

        files.atomic_write(path, write)

    def resume(self, path: Path, key: dict[str, object]) -> None:
        """Continue from a restart file; refuse one that is none, is damaged, or belongs to another run."""
        data = files.read_bytes(path, files.regular(path))
        try:
            with np.load(io.BytesIO(files.unsealed(data)), allow_pickle=False) as stored:
                old = json.loads(str(stored["key"]))
                numbers, states, twists, corners = (stored[name] for name in _KEPT)
                columns = {n.removeprefix(_COLUMN): list(stored[n]) for n in stored if n.startswith(_COLUMN)}
        except Exception:  # a file of another version shows itself in NumPy as errors of many kinds
            reason = "is damaged, or no restart file of this version of squama"
            refuse("", "", reason, "remove it or name another output", str(path))
        for name in sorted({*old, *key}):
            if old.get(name) != key.get(name):
                reason = f"belongs to a run with {name} = {old.get(name)}, not {key.get(name)}"
                refuse("", "", reason, "remove it or name another output", str(path))
        self.phi, self.kappa, self.T, self.W, self.W_fr, self._power = map(float, numbers[:6])
        self.halvings, self.columns = int(numbers[6]), columns
        self.trail = Trail(list(zip(states, twists.tolist(), corners, strict=True)))
        self.z, self.v = np.split(states[-1], [self.z.size])
        self._begun = True

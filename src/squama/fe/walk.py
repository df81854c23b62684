"""Elements and rigid scales in frictional contact, led from twist to twist.

Every increment is a Newton iteration in two levels: the elements are factorised once an iteration and condensed exactly
onto the scales' motions, on which the contact problem is solved to convergence. The first iteration goes from the last
equilibrium to the predicted one without passing through a contact. Predictions and steps that would invert an element
are shortened.
"""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NamedTuple, Protocol
from zipfile import BadZipFile

import numpy as np

from squama.errors import InputError
from squama.fe.body import Condensed, Solid
from squama.fe.contact import DHAT, stiffness
from squama.fe.plate import Array
from squama.fe.small import Neighbours, Trail, advance, balance

ITERATIONS = 12
TOLERANCE = 1e-7
"""Change of a place, in pitches, at which an increment has converged."""
JUMP = 0.02
"""Largest distance of an equilibrium from where the last ones point; beyond, the increment is halved."""
_FIRST = 1e-3
_HALVINGS = 7
_SHRINK = 8
_STARTS = 1.0, 0.5, 0.25, 0.0
_INVERTED = "elements invert, most likely at a scale's embedded edge: other element sizes may go further"


_KEPT = frozenset(
    ("v", "rate", "v_rate", "before", "numbers", "rows", "words", "past_v", "past_phi", "past_corners", "past_z")
)
"""Arrays of a restart file."""


class Increment(NamedTuple):
    """What a listener is told: the twist reached and wanted, Newton steps, largest force left, increments halved."""

    phi: float
    goal: float
    iterations: int
    unbalanced: float
    halvings: int


class Ended(NamedTuple):
    """How a run ended: ``reached`` the goal, or the sentence that says why not."""

    reached: bool
    sentence: str


class State(NamedTuple):
    """An equilibrium: free unknowns z, motions v, twist, torque, condensed body, contact, iterations of its step."""

    z: Array
    v: Array
    phi: float
    T: float
    reduced: Condensed
    load: Any
    iterations: int


class Scales(Neighbours, Protocol):
    """Contact whose loads also tell the work of friction and the resultant forces (as those of HelixContact)."""

    def load(self, v: Array, phi: float, before: Array | None, kappa: float) -> Any:
        """Return a :class:`squama.fe.contact.Load` or the like."""
        ...


class Recorder(Protocol):
    """Makes a row of numbers of every equilibrium, and says what touches."""

    def __call__(self, walk: Walk, state: State) -> tuple[Sequence[float], str]:
        """Return the row and the words."""
        ...


class Walk:
    """A body with scales on its way along a history of the twist.

    Parameters
    ----------
    body : Solid
        Elements with the scales tied in.
    rest : (n, 3) array
        Its masters' places at rest.
    contact : Scales
        Contact between the scales by (v, phi).
    ways : (6 scales, m) array
        Directions in which the scales can move.
    record : Recorder
        Makes the rows.
    dhat : float
        See :mod:`squama.fe.contact`.
    jump : float
        See :data:`JUMP`.

    Attributes
    ----------
    rows, words : list
        A row for every equilibrium, the one at rest first, and what touches there ("" for nothing).
    W, W_fr : float
        Work of the torque and of friction, E d^3.
    """

    def __init__(
        self,
        body: Solid,
        rest: Array,
        contact: Scales,
        ways: Array,
        record: Recorder,
        *,
        dhat: float = DHAT,
        jump: float = JUMP,
    ) -> None:
        self.body, self.contact, self.ways, self.dhat, self._jump = body, contact, ways, dhat, jump
        self._record = record
        self.z, self.v, self.phi = body.start(rest), np.zeros(len(ways)), 0.0
        self.kappa = stiffness(_FIRST, dhat)
        self.before = contact.corners(self.v, self.phi)
        self.trail = Trail(self.v, self.phi, self.before)
        self._z_trail = Trail(self.z, self.phi, np.empty(0))
        self.T = self.W = self.W_fr = self._power = 0.0
        self.rows: list[tuple[float, ...]] = []
        self.words: list[str] = []
        self.iterations, self.unbalanced = 0, 0.0
        self.halvings = 0
        self._rate, self._v_rate = np.zeros_like(self.z), np.zeros_like(self.v)

    def places(self) -> Array:
        """Return the places (n, 3) of the masters."""
        return self.body.places(self.z, self.v.reshape(-1, 6), self.phi)

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
            self._begin()
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
                    return Ended(False, f"stopped at phi = {self.phi:.4f} rad per pitch: {why}")
                continue
            if told is not None:
                told(Increment(self.phi, goal, self.iterations, self.unbalanced, self.halvings))
            step = float(np.sign(left)) * min(abs(step) * 1.5, abs(increment))
            if stop is not None and stop() and self.phi != goal:
                return Ended(False, f"interrupted at phi = {self.phi:.4f} rad per pitch; the same command goes on")
        return Ended(True, "the asked twist was reached")

    def _reduce(self, z: Array, v: Array, phi: float) -> Condensed | None:
        return self.body.reduce(z, v.reshape(-1, 6), phi)

    def _begin(self) -> None:
        reduced = self._reduce(self.z, self.v, 0.0)
        if reduced is None:
            message = "an element has no volume at rest: take another element size"
            raise InputError(message)
        W = self.ways
        self._v_rate = -W @ np.linalg.solve(W.T @ reduced.S @ W, W.T @ reduced.s_phi)
        self._rate = reduced.update(self._v_rate, 1.0) - reduced.correction
        load = self.contact.load(self.v, 0.0, None, self.kappa)
        self._keep(State(self.z, self.v, 0.0, reduced.torque + float(load.total[-1]), reduced, load, 0))

    def _increment(self, phi: float) -> str:
        """Go to a twist; the reason if that fails, and nothing has changed then."""
        step = phi - self.phi
        if len(self.rows) == 1:
            z, expected = self.z + self._rate * step, self.v + self._v_rate * step
        else:
            # both in the same way, or the elements beside the scales are torn
            z, expected = self._z_trail.expected(phi), self.trail.expected(phi)
        before = self.trail.before(phi)
        places = 3 * self.body.free.size
        start = self._start(z, expected, phi)
        if start is None:
            return _INVERTED
        z, v, reduced = start
        # a step that is not a whole one may end within a contact: the way is sought from the last equilibrium again
        short = False
        for iteration in range(1, ITERATIONS + 1):

            def linear(u: Array, x: float, at: Array = v, r: Condensed = reduced) -> tuple[Array, Array, Array]:
                return r.s + r.S @ (u - at) + r.s_phi * (x - phi), r.S, r.s_phi

            if iteration == 1 or short:
                found = advance(linear, self.contact, (self.v, self.phi), (v, phi), before, self.kappa, self.ways)
            else:
                found = balance(linear, self.contact, v, phi, before, self.kappa, self.ways)
            if not found.solved:
                return "no balance of the contact was found"
            dv = found.v - v
            change = reduced.update(dv)
            moved = max(float(np.abs(change[:places]).max()), float(np.abs(dv).max()))
            if moved < TOLERANCE:
                z, v = z + change, found.v
                break
            taken = self._step(z, v, change, dv, phi)
            if taken is None:
                return _INVERTED
            z, v, reduced, short = taken
        else:
            return f"no balance within {ITERATIONS} iterations"
        if np.abs(v - expected).max() > self._jump:
            return "the next equilibrium is a jump away"
        load = self.contact.load(v, phi, before, self.kappa)
        state = State(z, v, phi, reduced.torque + float(load.total[-1]), reduced, load, iteration)
        power = load.slid * self.trail.stretch(phi) / step
        self.W += (self.T + state.T) / 2 * step
        self.W_fr += (self._power + power) / 2 * step
        self._power, self.before = power, before
        self.trail.add(v, phi, self.contact.corners(v, phi))
        self._z_trail.add(z, phi, np.empty(0))
        self._keep(state)
        return ""

    def _start(self, z: Array, v: Array, phi: float) -> tuple[Array, Array, Condensed] | None:
        """Return where an increment begins: as predicted, or as much of the way there as inverts no element."""
        for share in _STARTS:
            at = self.z + share * (z - self.z), self.v + share * (v - self.v)
            reduced = self._reduce(*at, phi)
            if reduced is not None:
                return *at, reduced
        return None

    def _step(
        self, z: Array, v: Array, change: Array, dv: Array, phi: float
    ) -> tuple[Array, Array, Condensed, bool] | None:
        """Go as much of a Newton step as inverts no element; the last value says whether it was shortened."""
        share = 1.0
        for _ in range(_SHRINK):
            at = z + share * change, v + share * dv
            reduced = self._reduce(*at, phi)
            if reduced is not None:
                return *at, reduced, share < 1
            share /= 2
        return None

    def _keep(self, state: State) -> None:
        self.z, self.v, self.phi, self.T = state.z, state.v, state.phi, state.T
        self.iterations, self.unbalanced = state.iterations, state.reduced.unbalanced
        row, words = self._record(self, state)
        self.rows.append(tuple(float(x) for x in row))
        self.words.append(words)
        N = state.load.resultant.N
        if N > 0:
            # keep the gap near dhat / 2
            self.kappa = float(np.clip(stiffness(N, self.dhat), self.kappa / 2, self.kappa * 2))

    def save(self, path: Path, key: dict[str, Any]) -> None:
        """Write all that is needed to go on; the file is complete or the old one stays.

        Parameters
        ----------
        path : Path
            The restart file.
        key : dict
            What the run was asked for; :meth:`load` refuses another.
        """
        past = self.trail.past
        arrays: dict[str, Any] = {
            "v": self.v, "rate": self._rate, "v_rate": self._v_rate, "before": self.before,
            "numbers": np.array([self.phi, self.kappa, self.T, self.W, self.W_fr, self._power, self.halvings]),
            "rows": np.array(self.rows), "words": np.array(self.words),
            "past_z": np.array([p[0] for p in self._z_trail.past]), "past_v": np.array([p[0] for p in past]),
            "past_phi": np.array([p[1] for p in past]), "past_corners": np.array([p[2] for p in past]),
        }  # fmt: skip
        beside = path.with_name(f".{path.name}.new")
        with beside.open("wb") as out:
            np.savez(out, key=json.dumps(key, sort_keys=True), **arrays)
            out.flush()
            os.fsync(out.fileno())
        beside.replace(path)

    def load(self, path: Path, key: dict[str, Any]) -> None:
        """Go on from a restart file.

        Raises
        ------
        InputError
            It is not one, or belongs to another run.
        """
        try:
            with np.load(path, allow_pickle=False) as stored:
                kept = {name: stored[name] for name in stored.files}
                old = json.loads(str(kept["key"]))
            missing = _KEPT - kept.keys()
        except (OSError, ValueError, KeyError, EOFError, BadZipFile):
            missing = _KEPT
        if missing:
            message = f"{path}: is no restart file of this version of squama; remove it or name another output"
            raise InputError(message)
        for name in sorted({*old, *key}):
            if old.get(name) != key.get(name):
                message = (
                    f"{path}: belongs to a run with {name} = {old.get(name)}, not {key.get(name)}; "
                    "remove it or name another output"
                )
                raise InputError(message)
        self.v, self._rate, self._v_rate = (kept[name] for name in ("v", "rate", "v_rate"))
        self.z = kept["past_z"][-1]
        self.before = kept["before"]
        numbers = [float(x) for x in kept["numbers"]]
        self.phi, self.kappa, self.T, self.W, self.W_fr, self._power = numbers[:6]
        self.halvings = int(numbers[6])
        self.rows = [tuple(row) for row in kept["rows"].tolist()]
        self.words = [str(words) for words in kept["words"]]
        past = zip(kept["past_v"], kept["past_phi"].tolist(), kept["past_corners"], strict=True)
        self.trail = Trail.of(list(past))
        self._z_trail = Trail.of([(z, p[1], np.empty(0)) for z, p in zip(kept["past_z"], self.trail.past, strict=True)])

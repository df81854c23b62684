"""A beam that is loaded by one load alone: twisted without a bending moment, or bent without a torque.

:func:`squama.twist` holds a beam straight, :func:`squama.bend` holds it from twisting, and neither has an axial force.
Once scales on one face touch, that takes a bending moment ``M``, or a torque ``T``. Here the beam is free to bow, or to
twist: the other strain is such that its moment or torque vanishes. The path is a polygon in bend and twist
(:mod:`squama.real.legs`): straight to engagement, then from one load angle to the next, each with the other strain
found by bracketing. Where another contact comes in, general contact (extra fe) answers.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq

from squama.beam.design import Beam
from squama.curves import real
from squama.loads import LOADS
from squama.real import changes, path
from squama.real.legs import Bent, follow_legs
from squama.types import Array

SPACING = 0.01
"""Largest step of the load between two corners of the path, rad per pitch: half of it changes the torque by .01 %."""
_SLOPE = 2.5e-3
"""Step of the load over which the tangent stiffness is taken, rad per pitch."""
_BEFORE, _WIDTH, _ROUNDS, _EXACT = 0.97, 0.02, 12, 1e-7
BOTH = "with scales on both faces this is not computed"
SEVEN = "joint.matrix knows no bend; squama joint --matrix writes all nine motions"
OTHER = "another contact comes in; general contact follows it with the extra fe: pip install 'squama[fe]'"


class Released(NamedTuple):
    """States of an endless beam under one load alone, at load angles per pitch (n,); NaN where not known.

    ``strain``: the other strain per pitch (bend of a twisted beam, twist of a bent one), rad; ``torque``: torque of a
    twisted beam, moment of a bent one, N m; ``tangent`` stiffness, N m^2; ``stiffness_ratio``: that over ``rigidity``,
    N m^2, of the same beam before contact. ``note`` says why values are missing.
    """

    strain: Array
    torque: Array
    tangent: Array
    stiffness_ratio: Array
    rigidity: float
    note: str


def released(beam: Beam, load: str, mu: float, at: Array | float, *, ideal: bool = False, sense: str = "+") -> Released:
    """Twist a beam that is free to bow, or bend one that is free to twist.

    Parameters
    ----------
    beam
        The beam, on its compliant joint.
    load
        "twisting" or "bending".
    mu
        Coefficient of friction.
    at
        Load angles per pitch, rad, magnitudes in any order.
    ideal
        Thin, rigid scales.
    sense
        "+" or "-", as of :func:`squama.twist`.
    """
    at = np.atleast_1d(np.asarray(at, float))
    held = real.Held.of(beam)
    if beam.other or not held.stretch:
        none = np.full(at.size, np.nan)
        return Released(none, none, none, none, math.nan, BOTH if beam.other else SEVEN)
    sign, unit, d = -1 if sense == "-" else 1, beam.unit_moment, beam.pitch
    run = _Run(real.scale(beam, ideal=ideal), held.K, mu, held.stretch, sign, LOADS[load].axis)
    nodes = np.unique(np.concatenate([at, at + _SLOPE, np.maximum(at - _SLOPE, 0.0)]))
    nodes = nodes[nodes > 0]
    states, note = run.states(nodes)
    wanted = np.isin(nodes, at)
    if not np.isfinite(states[wanted]).all() and real.general():
        states, note = _generally(beam, run, nodes), "no equilibrium was found"
    note = "" if np.isfinite(states[wanted]).all() else note
    nodes, states = np.append(0.0, nodes), np.vstack([np.zeros(2), states])
    which = np.searchsorted(nodes, at)
    strain, torque = states[which].T
    tangent = _slopes(nodes, states[:, 1])[which] * unit * d
    rigidity = run.bare * unit * d
    return Released(strain, torque * unit, tangent, tangent / rigidity, rigidity, note)


def _slopes(x: Array, y: Array) -> Array:
    """Return the slopes of y (n,), by the interval before a point where the one behind it is not known."""
    slope = np.gradient(y, x) if x.size > 1 else np.full(x.size, np.nan)
    before = np.append(np.nan, np.diff(y) / np.diff(x))
    return np.where(np.isfinite(slope), slope, before)


class _Run(NamedTuple):
    """A beam in one sense under one load, of an axis of (psi, phi); E = d = 1."""

    scale: path.Scale
    K: Array
    mu: float
    stretch: str
    sign: int
    axis: int

    def follow(self, corners: list[tuple[float, float]]) -> Bent:
        """Follow the beam through corners, each the other strain and the load, of the sense "+"."""
        points = np.array(corners)[:, ::-1] if self.axis == 0 else np.array(corners)
        return follow_legs(self.scale, self.K, self.mu, points * [1, self.sign], stretch=self.stretch)

    @property
    def alone(self) -> tuple[float, float, float]:
        """Stiffness without contact against the load, that of both together, and that against the other strain."""
        bare = path.bare(self.follow([(0.0, 1e-3)]).way.beams)[0]
        own, other = (0, 1) if self.axis else (1, 0)
        return float(bare[own, own]), float(bare[0, 1] * self.sign), float(bare[other, other])

    @property
    def bare(self) -> float:
        """Load per its strain without contact, the other strain free."""
        own, cross, other = self.alone
        return own - cross**2 / other

    def states(self, nodes: Array) -> tuple[Array, str]:
        """Return the other strain and the load's torque (n, 2) at rising loads, NaN beyond the end, and why it ends."""
        found = np.full((nodes.size, 2), np.nan)
        _, cross, other = self.alone
        ray, last = -cross / other, float(nodes[-1])
        met = self.follow([(ray * last, last)]).answers.contact()
        engaged = last if met.first == -1 else min(met.phi / math.hypot(1.0, ray), last)
        free = nodes <= engaged
        found[free] = np.outer(nodes[free], [ray, self.bare])
        # a corner right at engagement would leave no step in which the contact begins to slide
        corners = [(ray * engaged * _BEFORE, engaged * _BEFORE)] if engaged > 0 else []
        strain, here, slope = ray * engaged, engaged, ray
        for goal in nodes[~free].tolist():
            for load in np.linspace(here, goal, math.ceil((goal - here) / SPACING) + 1)[1:].tolist():
                solved = self.balanced(corners, strain + slope * (load - here), load)
                if solved is None:
                    return found, OTHER
                slope, strain, here = (solved[0] - strain) / (load - here), solved[0], load
                corners.append((strain, load))
            found[nodes == goal] = solved
        return found, ""

    def balanced(self, corners: list[tuple[float, float]], guess: float, load: float) -> tuple[float, float] | None:
        """Return the other strain at which its moment is zero, and the load's torque; None where none is found."""

        def torques(strain: float) -> tuple[float, float]:
            bent = self.follow([*corners, (strain, load)])
            if bent.answers.end().code != changes.RANGE:
                return math.nan, math.nan
            M, T = float(bent.M[-1]), float(bent.T[-1]) * self.sign
            return (M, T) if self.axis else (T, M)

        strain = _root(lambda x: torques(x)[0], guess, _WIDTH * load, _EXACT * load)
        zero, torque = torques(strain) if math.isfinite(strain) else (math.nan, math.nan)
        return (strain, torque) if math.isfinite(zero) else None


def _root(f: Callable[[float], float], guess: float, width: float, exact: float) -> float:
    """Return where a rising function vanishes, by steps from a guess until it is bracketed; NaN where it is not."""
    a = b = guess
    value = f(guess)
    step = -math.copysign(width, value)
    for _ in range(_ROUNDS):
        a, b, before = b, b + step, value
        value = f(b)
        if not math.isfinite(value) or not math.isfinite(before):
            return math.nan
        if value * before <= 0:
            return float(brentq(f, a, b, xtol=exact)) if value else b
        step *= 2
    return math.nan


def _generally(beam: Beam, run: _Run, nodes: Array) -> Array:
    """Return the other strain and the load's torque (n, 2) at rising loads by general contact, NaN beyond its end."""
    from squama.curves import general_contact

    goal = np.array([0.0, run.sign * nodes[-1]] if run.axis else [nodes[-1], 0.0])
    free = ["stretch"] * (run.stretch == "free") + ["bend" if run.axis else "twist"]
    led = general_contact.lead(beam, run.K, run.mu, run.scale, free, [(goal, nodes)])
    names, signs = (("psi", "T"), (1, run.sign)) if run.axis else (("phi", "M"), (run.sign, 1))
    found = np.full((nodes.size, 2), np.nan)
    columns = [sign * led.columns[name][1:] for name, sign in zip(names, signs, strict=True)]
    found[: len(columns[0])] = np.column_stack(columns)
    return found

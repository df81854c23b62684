"""A twisted beam that is free to bow: no bending moment, as well as no axial force.

:func:`squama.twist` holds the beam straight, which takes a bending moment ``M`` as soon as scales on one face touch.
Here the bend per pitch psi is such that M vanishes. The path is a polygon in bend and twist
(:mod:`squama.real.legs`): along M = 0 to engagement, then from one twist to the next, each with the bend at which M is
zero, by secants.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq

from squama.beam.design import Beam
from squama.curves import real
from squama.real import changes, path
from squama.real.legs import Bent, follow_legs
from squama.types import Array

SPACING = 0.01
"""Largest step of the twist between two corners of the path, rad per pitch: half of it changes T by some 0.1 %."""
_SLOPE = 2.5e-3
"""Step of the twist over which the tangent stiffness is taken, rad per pitch."""
_BEFORE, _WIDTH, _ROUNDS, _EXACT = 0.97, 0.02, 12, 1e-7
_BOTH = "with scales on both faces the bend of a beam free to bow is not known"
_STRAIGHT = "joint.matrix knows no bend: squama joint --matrix writes all nine motions"


class Bowed(NamedTuple):
    """States of a beam free to bow at twists per pitch (n,); NaN where they are not known, ``note`` says why.

    ``psi`` bend per pitch (rad), ``T`` torque (N m), ``tangent`` stiffness (N m^2), ``stiffness_ratio`` that over the
    ``rigidity`` (N m^2) of the same beam before contact.
    """

    psi: Array
    T: Array
    tangent: Array
    stiffness_ratio: Array
    rigidity: float
    note: str


def bowed(beam: Beam, mu: float, phis: Array, *, ideal: bool = False, sense: str = "+") -> Bowed:
    """Twist an endless beam that is free to bow.

    Parameters
    ----------
    beam
        The beam, on its compliant joint.
    mu
        Coefficient of friction.
    phis
        Twists per pitch, rad, magnitudes in any order.
    ideal
        Thin, rigid scales.
    sense
        "+" or "-", as of :func:`squama.twist`.
    """
    phis = np.atleast_1d(np.asarray(phis, float))
    held = real.Held.of(beam)
    if beam.other or not held.stretch:
        return _unknown(phis.size, _BOTH if beam.other else _STRAIGHT)
    sign, unit, d = -1 if sense == "-" else 1, beam.unit_moment, beam.pitch
    run = _Run(real.scale(beam, ideal=ideal), held.K, mu, held.stretch, sign)
    nodes = np.unique(np.concatenate([phis, phis + _SLOPE, np.maximum(phis - _SLOPE, 0.0)]))
    nodes = nodes[nodes > 0]
    states, note = run.states(nodes)
    if note and real.general():
        states, note = _generally(beam, run, nodes), ""
        note = "" if np.isfinite(states[np.isin(nodes, phis)]).all() else "no equilibrium was found"
    states, nodes = np.vstack([np.zeros(2), states]), np.append(0.0, nodes)
    at = np.searchsorted(nodes, phis)
    T = states[:, 1]
    slope = np.gradient(T, nodes)[at] if nodes.size > 1 else np.full(phis.size, run.bare)
    # from below where the beam is not followed beyond
    below = (T[at] - T[at - 1]) / np.where(at > 0, nodes[at] - nodes[at - 1], np.nan)
    slope = np.where(np.isfinite(slope), slope, below)
    rigidity, tangent = run.bare * unit * d, slope * unit * d
    return Bowed(states[at, 0], states[at, 1] * unit, tangent, tangent / rigidity, rigidity, note)


def _unknown(n: int, note: str) -> Bowed:
    none = np.full(n, np.nan)
    return Bowed(none, none, none, none, math.nan, note)


class _Run(NamedTuple):
    """A beam in one sense, E = d = 1."""

    scale: path.Scale
    K: Array
    mu: float
    stretch: str
    sign: int

    def follow(self, corners: list[tuple[float, float]]) -> Bent:
        """Follow the beam through corners (psi, phi), twists as magnitudes."""
        return follow_legs(self.scale, self.K, self.mu, np.array(corners) * [1, self.sign], stretch=self.stretch)

    @property
    def alone(self) -> Array:
        """Stiffness (2, 2) of the beam without contact against twist, as a magnitude, and bend."""
        signs = np.array([self.sign, 1])
        return np.asarray(path.bare(self.follow([(0.0, 1e-3)]).way.beams)[0] * np.outer(signs, signs))

    @property
    def bare(self) -> float:
        """Torque per twist without contact, free to bow."""
        (twist, cross), (_, bend) = self.alone
        return float(twist - cross**2 / bend)

    def states(self, nodes: Array) -> tuple[Array, str]:
        """Return bend and torque (n, 2) at rising twists, NaN beyond the end, and why it ends."""
        found = np.full((nodes.size, 2), np.nan)
        (_, cross), (_, bend) = self.alone
        ray = -cross / bend
        last = float(nodes[-1])
        met = self.follow([(ray * last, last)]).answers.contact()
        engaged = last if met.first == -1 else min(met.phi / math.hypot(1.0, ray), last)
        free = nodes <= engaged
        found[free] = np.outer(nodes[free], [ray, self.bare])
        # a corner right at engagement would leave no step in which the contact begins to slide
        corners = [(ray * engaged * _BEFORE, engaged * _BEFORE)] if engaged > 0 else []
        psi, here, slope = ray * engaged, engaged, 0.0
        for goal in nodes[~free].tolist():
            for phi in np.linspace(here, goal, math.ceil((goal - here) / SPACING) + 1)[1:].tolist():
                solved = self.balanced(corners, psi + slope * (phi - here), ray * phi, phi)
                if solved is None:
                    return found, "another contact comes in"
                slope, psi, here = (solved[0] - psi) / (phi - here), solved[0], phi
                corners.append((psi, phi))
            found[nodes == goal] = solved
        return found, ""

    def balanced(
        self, corners: list[tuple[float, float]], guess: float, most: float, phi: float
    ) -> tuple[float, float] | None:
        """Return the bend, below ``most``, and the torque at a twist where the moment is zero; None where that fails.

        A contact pushes the beam away from it, so that without one the moment vanishes at ``most``.
        """

        def state(psi: float) -> tuple[float, float]:
            bent = self.follow([*corners, (psi, phi)])
            known = bent.answers.end().code == changes.RANGE
            return (float(bent.M[-1]), float(bent.T[-1]) * self.sign) if known else (math.nan, math.nan)

        low, high, step = guess, most, max(most - guess, phi * _WIDTH)
        for _ in range(_ROUNDS):
            if state(low)[0] <= 0:
                break
            low, high, step = low - step, low, 2 * step
        try:
            psi = float(brentq(lambda x: state(x)[0], low, high, xtol=_EXACT * phi))
        except (ValueError, RuntimeError):
            return None
        M, T = state(psi)
        return (psi, T) if math.isfinite(M) else None


def _generally(beam: Beam, run: _Run, nodes: Array) -> Array:
    """Return bend and torque (n, 2) at rising twists by general contact, NaN beyond its end."""
    from squama.curves import general_contact

    legs = [(np.array([0.0, run.sign * nodes[-1]]), nodes)]
    led = general_contact.lead(beam, run.K, run.mu, run.scale, (*(["stretch"] * (run.stretch == "free")), "bend"), legs)
    found = np.full((nodes.size, 2), np.nan)
    found[: len(led.moved) - 1] = np.column_stack([led.columns["psi"], run.sign * led.columns["T"]])[1:]
    return found

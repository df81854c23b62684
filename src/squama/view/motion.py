"""What a picture of a loaded beam needs to know: inclination, contact, slip and forces at any load."""

from __future__ import annotations

import functools
import math
from typing import Any, NamedTuple

import numpy as np

from squama import checks, curve
from squama.design import Beam
from squama.model import solution, twisting
from squama.model.outcome import SENTENCES, End
from squama.model.paths import ARRAY
from squama.model.plates import Plates
from squama.model.solve import Array

MOST_SCALES = 60
"""A longer beam is drawn with this many scales."""
FREE, SLIDING, LOCKED, ENDED = "free", "sliding", "locked", "ended"
"""States of the scales: not in contact; in contact; locked; at an end that is no lock."""
ROOM = 1.1
"""How far beyond its end a beam may be asked to go, over the load of the end."""


class Setting(NamedTuple):
    """A beam and how it is loaded."""

    beam: Beam
    mu: float
    load: str = "twisting"
    law: str = "edge"
    margin: float = 0.01
    sense: str = "+"


class State(NamedTuple):
    """One state: load angle per pitch and inclination (rad), normal and friction force (N), slip, what it is called.

    ``slip`` are the rates along the side edge and along the tip edge; ``x`` is N d/K_theta, by which arrows are drawn.
    """

    load: float
    theta: float
    N: float
    f: float
    torque: float
    x: float
    slip: tuple[float, float]
    name: str


class Motion:
    """A beam's curve, and its state at any load.

    Parameters
    ----------
    setting : Setting
        The beam, its friction and how it is loaded.

    Raises
    ------
    InputError
        The law, margin, sense or friction is out of range.
    """

    def __init__(self, setting: Setting) -> None:
        self.setting = setting
        beam, mu = setting.beam, float(checks.not_negative("mu", setting.mu))
        law, margin = checks.law(setting.law), checks.scalar("margin", setting.margin, 1e-12, 1.0, "1e-12 to 1")
        self.twisting = checks.one_of("load", setting.load, ("twisting", "bending")) == "twisting"
        sign = checks.sense(setting.sense)
        theta0, m = np.array([beam.scale.theta0]), np.array([mu])
        touch = None
        if self.twisting:
            rigidity, stiffness = beam.torsional_rigidity, beam.joint_stiffness
            eta, beta, lam, alpha, _ = (np.array([v]) for v in beam.ratios.values())
            found = solution.solve_twisting(eta, beta, lam, alpha, theta0, m, law=law, sense=setting.sense)
            slant = beam.scale.alpha
            plates = Plates(beam.eta, beam.beta, beam.lam, sign * math.sin(slant), math.cos(slant))
            found, touches = solution.with_touches(found, [plates], theta0, mirrored=sign < 0)
            touch = touches[0]
        else:
            law = "edge"
            rigidity, stiffness = beam.bending_rigidity, beam.bending_joint_stiffness
            found = solution.solve_bending(np.array([beam.eta]), theta0, m)
        self.case = curve.Case(beam.pitch, rigidity, stiffness, beam.eta, beam.scale.theta0, sign < 0)
        self.path = curve.path(self.case, found, touch, mu, law, margin, None)

    @functools.cached_property
    def figures(self) -> dict[str, Any]:
        """Single figures of the curve, by their roles in :mod:`squama.curve`."""
        return curve.curve(self.case, self.path, points=3, at=None).figures

    def along(self, points: int) -> dict[str, Array]:
        """Every variable along the curve, from no load to the cut-off."""
        return curve.curve(self.case, self.path, points=points, at=None).along

    @property
    def end(self) -> End:
        """Why the curve ends."""
        return self.path.end

    @property
    def sentence(self) -> str:
        """The end in words."""
        return SENTENCES[self.end]

    @functools.cached_property
    def last(self) -> float:
        """Load angle of the last state that is drawn: the cut-off before a lock, or the end."""
        if not self.path.engaged:
            return min(self.path.load_e, self.path.load_end)
        return float(self.path.row.point(np.array([self.path.x_c]), self.path.law, ARRAY).load[0])

    @property
    def most(self) -> float:
        """Largest load angle that may be asked for: a little beyond the last state."""
        return ROOM * self.last

    def state(self, load: float) -> State:
        """Return the state at a load angle per pitch; beyond the last one, the last one."""
        if not (self.path.engaged and load > self.path.load_e):
            # a beam that locks as it engages goes no further than that
            now = min(load, self.last)
            name = self._named(load) if load >= self.last else FREE
            return self._straight(now, name)
        held = load >= self.last
        x = self.path.x_c if held else self._place(load)
        return self._states(np.array([x]), self._named(load) if held else SLIDING)[0]

    def samples(self, points: int) -> list[State]:
        """Return states from no load to the last one, closer together where the inclination changes fast."""
        load, x = curve.samples(self.path, points)
        states = [self._straight(float(v), FREE) for v in load]
        if x.size:
            states += self._states(x, SLIDING)
        states[-1] = states[-1]._replace(name=self._named(self.most))
        return states

    def _named(self, load: float) -> str:
        if self.end.locks:
            return LOCKED
        return FREE if self.end is End.NONE and load < self.last else ENDED

    def _place(self, load: float) -> float:
        p = self.path
        return float(curve.invert(p.row, np.array([load]), p.x0, p.x_end, p.law)[0])

    def _straight(self, load: float, name: str) -> State:
        torque = self.case.rigidity * load / self.case.pitch
        return State(load, self.case.theta0, 0.0, 0.0, torque, 0.0, (0.0, 0.0), name)

    def _states(self, x: Array, name: str) -> list[State]:
        """States at path parameters."""
        values = curve.evaluate(self.case, self.path, np.empty(0), x)
        along, across = self._slip(x)
        force = values["N"] * self.case.pitch / self.case.stiffness if self.case.stiffness else 0 * x
        return [
            State(
                float(values["load"][i]),
                float(values["theta"][i]),
                float(values["N"][i]),
                float(values["f"][i]),
                float(values["torque"][i]),
                float(force[i]),
                (float(along[i]), float(across[i])),
                name,
            )
            for i in range(x.size)
        ]

    def _slip(self, x: Array) -> tuple[Array, Array]:
        """Sliding rates along the side edge (a) and along the tip edge (c), per unit of the path parameter."""
        row = self.path.row
        if not self.twisting:
            # the tip runs towards the base of the next scale
            rate = row.point(x + 1e-30j, "edge", ARRAY).s.imag
            return -rate, 0 * x
        with np.errstate(all="ignore"):
            _, root, q, _ = row.solve(x, ARRAY)
            c = twisting.contact(root, q, *getattr(row, "open", row).ratios)
        return np.asarray(c.a_rate), np.asarray(c.c_rate)


def shape(setting: Setting, neighbour: int = 1) -> dict[str, Any]:
    """Return what the geometry needs of a design: ratios (lengths in pitches, rad), kind of loading, sense, law."""
    beam = setting.beam
    return {
        "kind": setting.load,
        "eta": beam.eta,
        "beta": beam.beta,
        "lam": beam.lam,
        "alpha": beam.scale.alpha if setting.load == "twisting" else 0.0,
        "half": beam.substrate.width / 2 / beam.pitch,
        "sense": -1 if setting.sense == "-" and setting.load == "twisting" else 1,
        "law": setting.law if setting.load == "twisting" else "edge",
        "neighbour": max(1, neighbour),
        "scales": min(beam.scales, MOST_SCALES),
    }

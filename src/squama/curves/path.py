"""What is asked of a beam and what comes back: a load path, the asked figures, and the states along it."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple, Protocol

import numpy as np

from squama.beam.design import Beam
from squama.loads import LOADS, THIN, Load
from squama.types import Array

TIMES = {"twofold": 2.0, "fivefold": 5.0}
"""Tangent stiffness over that of the beam without contact whose twist is a figure."""
VERBS = tuple(load.verb for load in sorted(LOADS.values(), key=lambda load: load.axis))
"""Strains that may be loaded: bend and twist."""
FINE = 2e-3
"""Largest step of the load angle, rad per pitch, at which a path that is walked is looked at for its figures."""


class LoadPath(NamedTuple):
    """Bend and twist per pitch (psi, phi) to go to one after the other, from rest; rad, signed.

    An infinite one is the end of the curve in that sense. ``typed``: the words in which load angles were given;
    ``loaded``: the strains that the path names, others are free unless they are held.
    """

    points: tuple[tuple[float, float], ...]
    typed: Mapping[float, str] = {}
    loaded: tuple[str, ...] = VERBS

    @classmethod
    def of(cls, load: str, values: Sequence[float], typed: Mapping[float, str] = {}) -> LoadPath:
        """Return the path along one load."""
        kind = LOADS[load]
        return cls(tuple((0.0, v) if kind.axis else (v, 0.0) for v in map(float, values)), typed, (kind.verb,))

    def said(self, value: float) -> str:
        """Return a load angle as it was typed, and per pitch."""
        angle = f"{value:.6g} rad/pitch"
        text = self.typed.get(value, angle)
        return angle if text == angle else f'"{text}" ({angle})'

    @property
    def load(self) -> Load:
        """The one load that changes along the path; twisting if none does, or both do."""
        used = [load for load in LOADS.values() if any(point[load.axis] for point in self.points)]
        return used[0] if len(used) == 1 else LOADS["twisting"]

    @property
    def values(self) -> list[float]:
        """Load angles along the path."""
        return [point[self.load.axis] for point in self.points]

    @property
    def sense(self) -> str:
        """Sense in which the path sets out."""
        return "-" if next((v for v in self.values if v), 0.0) < 0 else "+"


def spaced(stop: float, points: int, engaged: float) -> Array:
    """Return evenly spaced loads from 0 to an end, with engagement in the place of the nearest one between the two."""
    at = np.linspace(0.0, stop, points)
    if 0 < engaged < stop:
        at[1 + np.abs(at[1:-1] - engaged).argmin()] = engaged
    return at


class Asked(NamedTuple):
    """What is asked of a model.

    ``mus`` coefficients of friction, ``points`` of a curve (of each way of a history), ``at`` load angles per pitch
    (magnitudes) at which a curve is wanted instead; ``ideal``: thin, rigid scales; ``note``: a
    warning that goes along.
    """

    beam: Beam
    path: LoadPath
    mus: Array
    law: str
    margin: float
    points: int
    at: Array | None = None
    ideal: bool = False
    note: str = ""

    @property
    def thickness(self) -> float:
        """Thickness of the scales on hinges in pitches, where the model knows of it."""
        thin_ones = thin(self.path.load, self.law, "hinge", ideal=self.ideal)
        return 0.0 if thin_ones else self.beam.scale.thickness / self.beam.pitch


def thin(load: Load, law: str, joint: str, *, ideal: bool) -> bool:
    """Whether scales are taken as thin: as asked, or because the model knows of no thickness."""
    return ideal or law == "plate" or (joint == "hinge" and not load.sided)


def idealisation(beam: Beam, joint: str, *, ideal: bool) -> str:
    """Say in words how a beam's scales are taken on a kind of joint."""
    if ideal:
        return THIN
    elastic = joint == "compliant" and beam.scale.youngs_modulus is not None
    return f"thick, {'elastic' if elastic else 'rigid'} scales"


class Case(NamedTuple):
    """What a kind of loading brings: pitch, rigidity without contact (N m^2), joint stiffness (N m), sense."""

    pitch: float
    rigidity: float
    stiffness: float
    eta: float
    theta0: float
    mirrored: bool = False

    @classmethod
    def of(cls, beam: Beam, load: str, sense: str = "+") -> Case:
        """Return the case of a beam."""
        kind = LOADS[load]
        return cls(beam.pitch, kind.rigidity(beam), beam.joint_stiffness, beam.eta, beam.scale.theta0, sense == "-")


class Curve(NamedTuple):
    """Variables along a curve (``along``) and single figures of it (``figures``), by role (:mod:`squama.loads`)."""

    along: dict[str, Array]
    figures: dict[str, float | int | str]


def figures(
    case: Case, last: Mapping[str, float], load_e: float, load_end: float, theta_end: float
) -> dict[str, float | int | str]:
    """Return the single figures of every curve, by role; ``last`` are its variables at the cut-off."""
    bare = case.rigidity * last["rate"]
    return {
        "load_e": load_e,
        "rate_e": load_e / case.pitch,
        "load_end": load_end,
        "rate_end": load_end / case.pitch,
        "rate_c": last["rate"],
        "torque_c": last["torque"],
        "theta_end": theta_end,
        "theta_c": last["theta"],
        "stiffening": last["torque"] / bare if bare else math.nan,
        **{f"{role}_c": last[role] for role in ("U_el", "W_fr", "RED")},
    }


class Solved(Protocol):
    """A beam's path in one sense with one coefficient of friction, solved; what every model gives."""

    @property
    def case(self) -> Case:
        """What the beam and the model bring."""

    @property
    def load_e(self) -> float:
        """Load angle per pitch (a magnitude) at engagement, inf for none."""

    def curve(self, *, points: int, at: Array | None = None) -> Curve:
        """Return the curve at points of the path's own, or at load angles per pitch: NaN beyond its end."""


class States(NamedTuple):
    """What a model says along a path: values by dimension and role, and what its attributes and warnings add."""

    by_dim: Mapping[tuple[str, ...], dict[str, Array]]
    attrs: Mapping[str, float | str] = {}
    notes: Sequence[str] = ()


LOOP = ("base", "top", "W_d", "U_max", "zeta_eq", "K_sec", "drop", "residual")
"""Figures of a closed loop."""


def loop_figures(
    turns: tuple[float, float],
    pitch: float,
    *,
    dissipated: float,
    elastic: float,
    torques: tuple[float, float, float],
    residual: float,
) -> list[float]:
    """Return the figures of a closed loop between two load angles per pitch, base and top, in the order of ``LOOP``.

    ``elastic`` is the energy at the top, ``torques`` those where the load comes to the top, where the contact slides
    back from there, and where the load comes to the base.
    """
    (base, top), (highest, turned, lowest) = turns, torques
    secant = (highest - lowest) / ((top - base) / pitch)
    damping = dissipated / (4 * math.pi * elastic)
    return [base, top, dissipated, elastic, damping, secant, abs(highest - turned), residual]


def loop_table(rows: Sequence[Sequence[float]]) -> dict[str, Array]:
    """Return the figures of loops by role."""
    return dict(zip(LOOP, np.array(rows, float).reshape(-1, len(LOOP)).T, strict=True))


def used_senses(values: Sequence[float]) -> list[str]:
    """Return the senses that a history goes to."""
    return [s for s in ("+", "-") if s == "+" or min(values) < 0]


def stiffened(touching: Array, ratios: Array, x: Array, torque: Array) -> dict[str, float]:
    """Return where the stiffness over that without contact comes to :data:`TIMES`, and the torque to its first peak."""
    found = {f"load_{name}": first_at(touching, ratios, n) for name, n in TIMES.items()}
    peak = np.flatnonzero((torque[1:-1] > torque[:-2]) & (torque[1:-1] >= torque[2:]))
    return found | {"load_peak": float(x[peak[0] + 1]) if peak.size else math.nan}


def first_at(x: Array, y: Array, level: float) -> float:
    """Return where y first comes to a level, linear between points; NaN where it does not."""
    above = np.flatnonzero(y >= level)
    if not above.size:
        return math.nan
    i = int(above[0])
    if i == 0 or not math.isfinite(y[i - 1]):
        return float(x[i])
    return float(x[i - 1] + (level - y[i - 1]) / (y[i] - y[i - 1]) * (x[i] - x[i - 1]))

"""What can be identified: the parameters, their bounds, and where they stand in a beam.

One row of :data:`PARAMETERS` each. Friction and joint stiffness are found unless others are asked for.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from squama import checks, tabular, units
from squama.design import Beam
from squama.errors import InputError
from squama.identify.forward import Physical
from squama.model.solve import Array
from squama.parts import FACTOR, MODULUS, STIFFNESS
from squama.units import Dimension

DEFAULT = ("mu", "K_theta")
"""Parameters that are found if none are named."""
_WIDE = 1e4
_ANGLES = 3.0
_STEEPEST = math.radians(85)


class Parameter(NamedTuple):
    """One row: ``unit`` (SI), what it measures, words, its value in a beam under a load, limits that always hold.

    ``table``, ``key``: where it stands in a beam file ("" for what belongs to the test, not to the beam);
    ``linear``: whether the torque is proportional to it.
    """

    name: str
    unit: str
    dimension: Dimension
    words: str
    tex: str
    value: Callable[[Beam, str], float]
    limits: tuple[float, float]
    table: str
    key: str
    linear: bool


def stiffness(beam: Beam, load: str) -> float:
    """Joint stiffness under a load, N m."""
    return beam.joint_stiffness if load == "twisting" else beam.bending_joint_stiffness


def rigidity(beam: Beam, load: str) -> float:
    """Rigidity without contact under a load, N m2."""
    return beam.torsional_rigidity if load == "twisting" else beam.bending_rigidity


def _inclusion(beam: Beam, load: str) -> float:
    if load == "twisting":
        return beam.C_f
    return 1.0 if beam.joint.inclusion_factor is None else beam.joint.inclusion_factor


PARAMETERS = {
    p.name: p
    for p in (
        Parameter(
            "mu",
            "1",
            Dimension.RATIO,
            "coefficient of friction",
            r"\mu",
            lambda b, _: 0.25 if b.friction.mu is None else b.friction.mu,
            (0.0, 10.0),
            "friction",
            "mu",
            False,
        ),
        Parameter(
            "K_theta",
            "N m",
            Dimension.TORQUE,
            "joint stiffness of a scale",
            r"K_\theta",
            stiffness,
            (STIFFNESS.low, STIFFNESS.high),
            "joint",
            "stiffness",
            True,
        ),
        Parameter(
            "C_f",
            "1",
            Dimension.RATIO,
            "inclusion factor of the bar",
            "C_f",
            _inclusion,
            (FACTOR.low, FACTOR.high),
            "joint",
            "inclusion_factor",
            True,
        ),
        Parameter(
            "E_B",
            "Pa",
            Dimension.PRESSURE,
            "Young's modulus of the bar",
            "E_B",
            lambda b, _: b.substrate.youngs_modulus,
            (MODULUS.low, MODULUS.high),
            "substrate",
            "youngs_modulus",
            True,
        ),
        Parameter(
            "theta0",
            "rad",
            Dimension.ANGLE,
            "inclination of the scales at rest",
            r"\theta_0",
            lambda b, _: b.scale.theta0,
            (1e-4, _STEEPEST),
            "scale",
            "theta0",
            False,
        ),
        Parameter(
            "zero",
            "N m",
            Dimension.TORQUE,
            "reading of the load cell at no load",
            "T_0",
            lambda _, __: 0.0,
            (-1e15, 1e15),
            "",
            "",
            True,
        ),
    )
}
"""Everything that can be identified, by name."""
_OTHER_NAMES = {
    "G_B": "E_B",
    "E": "E_B",
    "G": "E_B",
    "youngs_modulus": "E_B",
    "stiffness": "K_theta",
    "K": "K_theta",
    "inclusion_factor": "C_f",
    "friction": "mu",
}


class Asked(NamedTuple):
    """Parameters to find, in the order asked, with start values of the beam and bounds, arrays of one length.

    ``follows``: whether the joint stiffness is not known and goes with the bar's modulus, by its scaling law.
    """

    beam: Beam
    load: str
    rows: tuple[Parameter, ...]
    start: Array
    low: Array
    high: Array
    base: Physical
    follows: bool

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the parameters."""
        return tuple(p.name for p in self.rows)

    def place(self, name: str) -> int | None:
        """Place of a parameter; None if it is not to be found."""
        return self.names.index(name) if name in self.names else None

    def bound(self, name: str, end: int) -> float:
        """Return the lower (0) or upper (1) bound of a parameter, its value in the beam if it is not to be found."""
        i = self.place(name)
        return PARAMETERS[name].value(self.beam, self.load) if i is None else float((self.low, self.high)[end][i])

    def physical(self, p: Array) -> Physical:
        """Return what the torque depends on, for values of the parameters, shape (..., parameters)."""
        v = dict(zip(self.names, np.moveaxis(np.asarray(p, float), -1, 0), strict=True))
        scale, modulus = (
            v.get("C_f", self._of("C_f")) / self._of("C_f"),
            v.get("E_B", self._of("E_B")) / self._of("E_B"),
        )
        K = self.base.stiffness * (modulus if self.follows else 1.0)
        return Physical(
            v.get("mu", self.base.mu),
            v.get("K_theta", K),
            self.base.rigidity * scale * modulus,
            v.get("theta0", self.base.theta0),
            v.get("zero", 0.0),
        )

    def chain(self, p: Array) -> Array:
        """Return the derivatives of the physical quantities to the parameters, shape (5, parameters)."""
        at = self.physical(p)
        out = np.zeros((5, len(self.rows)))
        for i, name in enumerate(self.names):
            if name in _PLACES:
                out[_PLACES[name], i] = 1.0
            else:
                out[2, i] = at.rigidity / p[i]
            if name == "E_B" and self.follows and "K_theta" not in self.names:
                out[1, i] = at.stiffness / p[i]
        return out

    def _of(self, name: str) -> float:
        return PARAMETERS[name].value(self.beam, self.load)

    def fitted(self, p: Array) -> Beam:
        """Return the beam with values of the parameters put in."""
        changes: dict[str, dict[str, float]] = {}
        for row, value in zip(self.rows, p, strict=True):
            if row.table:
                changes.setdefault(row.table, {})[row.key] = float(value)
        return self.beam.replace(**changes)


_PLACES = {"mu": 0, "K_theta": 1, "theta0": 3, "zero": 4}


def ask(
    beam: Beam, load: str, names: Sequence[str] | str, bounds: Mapping[str, tuple[Any, Any]] | None = None
) -> Asked:
    """Check which parameters are to be found, and between which bounds.

    Parameters
    ----------
    beam, load
        The beam whose values they start from, and the kind of load.
    names
        Parameters to find; one text may hold several, set apart by commas.
    bounds
        Lower and upper bound by name: SI numbers or texts with units.

    Raises
    ------
    InputError
        One line per mistake: an unknown name, one given twice, bounds that are reversed or out of range.
    """
    given = [n.strip() for n in names.split(",")] if isinstance(names, str) else [str(n) for n in names]
    problems = [f"parameters: {n} is given twice; give it once" for n in dict.fromkeys(given) if given.count(n) > 1]
    problems += [f"parameters: {_unknown(n)}" for n in dict.fromkeys(given) if n not in PARAMETERS]
    if not given:
        problems.append('parameters: none is named; give e.g. ("mu", "K_theta")')
    if problems:
        raise InputError("\n".join(problems))
    rows = tuple(PARAMETERS[n] for n in given)
    follows = beam.joint.stiffness is None and "K_theta" not in given
    if {"C_f", "E_B"} <= set(given) and not follows:
        checks.fail("parameters: C_f and E_B: only their product enters the torque, no test tells them apart; find one")
    if beam.friction.mu is None and "mu" not in given:
        checks.fail("mu is not given: find it too, or write mu under [friction] in the beam's file")
    low, high = [], []
    for row in rows:
        limits = _limits(row, beam, load)
        try:
            limits = _read(row, limits, (bounds or {}).get(row.name))
        except InputError as error:
            problems += str(error).splitlines()
        low.append(limits[0])
        high.append(limits[1])
    problems += [
        f"bounds: {n} is not to be found (found are: {', '.join(given)}); leave it out, or find it too"
        if n in PARAMETERS
        else f"bounds: {_unknown(n)}"
        for n in bounds or {}
        if n not in given
    ]
    if problems:
        raise InputError("\n".join(problems))
    start = np.clip([row.value(beam, load) for row in rows], low, high)
    base = Physical(beam.friction.mu or 0.0, stiffness(beam, load), rigidity(beam, load), beam.scale.theta0)
    return Asked(beam, load, rows, start, np.array(low), np.array(high), base, follows)


def _unknown(name: str) -> str:
    known = ", ".join(PARAMETERS)
    if name in _OTHER_NAMES:
        hint = f"write {_OTHER_NAMES[name]} ({PARAMETERS[_OTHER_NAMES[name]].words}) "
        return f'"{name}" is not the name of a parameter; {hint}or another of {known}'
    return f'"{name}" is not the name of a parameter; {tabular.guess(name, PARAMETERS)}known are {known}'


def _limits(row: Parameter, beam: Beam, load: str) -> tuple[float, float]:
    """Bounds where none are given."""
    low, high = row.limits
    value = row.value(beam, load)
    if row.name == "theta0":
        return max(low, value / _ANGLES), min(high, value * _ANGLES)
    if row.table and row.name != "mu":
        return max(low, value / _WIDE), min(high, value * _WIDE)
    return low, high


def _read(row: Parameter, default: tuple[float, float], given: tuple[Any, Any] | None) -> tuple[float, float]:
    """Return the bounds of a parameter as given; an open end (None or "") keeps the default's."""
    if given is None:
        return default
    try:
        pair = list(given)
    except TypeError:
        pair = []
    if len(pair) != 2 or isinstance(given, str):
        checks.fail(f"bounds: {row.name}: give two values, the lower and the upper one")
    found = []
    for value, other in zip(pair, default, strict=True):
        if value is None or (isinstance(value, str) and not value.strip()):
            found.append(other)
            continue
        try:
            found.append(units.quantity(value, row.dimension))
        except units.QuantityError as error:
            checks.fail(f"bounds: {row.name} = {error.shown}: {error.reason}")
    low, high = found
    if low >= high:
        turned = " (they are reversed)" if low > high else ""
        checks.fail(
            f"bounds: {row.name}: the lower bound {low:.6g} is not below the upper {high:.6g}{turned}; "
            f"give the smaller one first"
        )
    for value in (low, high):
        if not row.limits[0] <= value <= row.limits[1]:
            checks.fail(f"bounds: {row.name} = {value:.6g}: must lie within {row.limits[0]:g} and {row.limits[1]:.4g}")
    return low, high

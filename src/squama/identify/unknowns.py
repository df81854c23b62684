"""Parameters that a fit can find: their bounds, their places in a beam, and their text.

Each has a row in :data:`PARAMETERS`. Friction and joint stiffness are found by default. Parameters of the test, not of
the beam, are nuisances. A value known beforehand, with its standard deviation, is a prior: one more observation besides
the points, (p - p_0)/s_p.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np

from squama import arguments, units
from squama.beam.beamfile import FACTOR, MODULUS, STIFFNESS
from squama.beam.design import Beam
from squama.errors import Problem, Problems, naming, refuse
from squama.identify.hinge_points import Physical
from squama.io import tabular
from squama.loads import TESTS
from squama.model.sensitivity import STEP
from squama.people import readable
from squama.study.parameters import of_beam
from squama.types import Array
from squama.units import Dimension, for_people

DEFAULT = ("mu", "K_theta")
"""Parameters that are found by default."""
_WIDE = 1e4
_ANGLES = 3.0
TURN = 2 * math.pi
"""Largest error of a twist, rad over the whole beam."""
_STEEP = (1e-4, math.radians(85))


class Parameter(NamedTuple):
    """A parameter; ``place`` in a beam file, "" for those of the test; ``group``: loop or specimen, None for all."""

    name: str
    dimension: Dimension
    words: str
    limits: tuple[float, float]
    place: str
    group: int | None = None

    @property
    def base(self) -> str:
        """Name without the group: "mu" for "mu[2]"."""
        return self.name.partition("[")[0]

    @property
    def unit(self) -> str:
        """SI unit of the parameter."""
        return units.si_unit(self.dimension)

    @property
    def linear(self) -> bool:
        """Whether the torque is linear in the parameter."""
        return self.base in _LINEAR

    def value(self, beam: Beam, load: str) -> float:
        """Return the value (SI) in a beam under a load; friction starts at 0.25 where the beam has none."""
        return 0.25 if self.name == "mu" and beam.friction.mu is None else of_beam(beam, load, self.place)

    def of(self, load: str) -> Parameter:
        """Return the parameter for a kind of test: on a part under a force, zeros are of force and travel."""
        if self.place or not TESTS[load].pushed:
            return self
        words = self.words.replace("twist", "travel").replace("rotation", "travel").replace("torque", "force")
        return self._replace(dimension=_PUSHED[self.dimension], words=words.removesuffix(", whole beam"))

    def written(self, value: float, error: float) -> str:
        """Return a value and its error as text: "0.251 +- 0.013 N m"."""
        return with_error(float(value), float(error), self.unit)


def with_error(value: float, error: float, unit: str) -> str:
    """Return a value and its error as text, with two digits of the error.

    >>> with_error(0.2512, 0.0134, "1"), with_error(1.5123e6, 2.2e4, "Pa")
    ('0.251 +- 0.013', '1.512 +- 0.022 MPa')
    """
    factor, name = for_people(unit)
    largest = max(abs(value), error if math.isfinite(error) else 0.0)
    if unit in ("Pa", "N m", "N"):
        factor, name = readable(unit, largest)
    value, error = value * factor, error * factor
    if not math.isfinite(error) or error < 1e-6 * abs(value):
        return f"{value:.7g} +- {error:.1e} {name}".strip()
    digits = max(0, 1 - math.floor(math.log10(error or 1.0)))
    return f"{value:.{digits}f} +- {error:.{digits}f} {name}".strip()


def written(rows: Sequence[Parameter], values: Array, errors: Array) -> list[str]:
    """Return values with their errors as text: "mu = 0.251 +- 0.013"."""
    columns = zip(rows, values, errors, strict=True)
    return [f"{row.name} = {row.written(value, error)}" for row, value, error in columns]


PARAMETERS = {
    p.name: p
    for p in (
        Parameter("mu", Dimension.RATIO, "coefficient of friction", (0.0, 10.0), "friction.mu"),
        Parameter("K_theta", Dimension.TORQUE, "joint stiffness of a scale", STIFFNESS[:2], "joint.stiffness"),
        Parameter("C_f", Dimension.RATIO, "inclusion factor of the bar", FACTOR[:2], "joint.inclusion_factor"),
        Parameter("E_B", Dimension.PRESSURE, "Young's modulus of the bar", MODULUS[:2], "substrate.youngs_modulus"),
        Parameter("theta0", Dimension.ANGLE, "inclination of the scales at rest", _STEEP, "scale.theta0"),
        Parameter("torque_zero", Dimension.TORQUE, "reading of the load cell at no load", (-1e15, 1e15), ""),
        Parameter("twist_zero", Dimension.ANGLE, "reading of the twist at no twist, whole beam", (-TURN, TURN), ""),
        Parameter("backlash", Dimension.ANGLE, "twist that is lost at a reversal, whole beam", (0.0, TURN), ""),
        Parameter("drift", Dimension.TORQUE, "change of the load cell's zero over a record", (-1e15, 1e15), ""),
        Parameter("compliance", Dimension.COMPLIANCE, "rotation of the machine per torque", (0.0, 1e15), ""),
    )
}
"""All parameters of fits, by name."""
NUISANCES = tuple(name for name, row in PARAMETERS.items() if not row.place)
"""Parameters of the test, not of the beam."""
SHOWN = tuple(name for name in NUISANCES if name != "compliance")
"""Nuisances that may be added where the residual shows them; a compliance resembles a softer joint."""
_PUSHED = {
    Dimension.TORQUE: Dimension.FORCE,
    Dimension.ANGLE: Dimension.LENGTH,
    Dimension.COMPLIANCE: Dimension.YIELDING,
}
"""Dimensions of the parameters of a test under a force, by those under a torque."""
_LINEAR = ("K_theta", "C_f", "E_B", "torque_zero", "drift")
"""Parameters in which the torque is linear."""
OF_TWIST = ("twist_zero", "backlash", "compliance")
"""Parameters that change the twist of the specimen."""
_OTHER_NAMES = {
    **dict.fromkeys(("G_B", "E", "G", "youngs_modulus"), "E_B"),
    **dict.fromkeys(("stiffness", "K"), "K_theta"),
    "inclusion_factor": "C_f",
    "friction": "mu",
    "zero": "torque_zero",
    "play": "backlash",
}


class Asked(NamedTuple):
    """Parameters to find, in the given order, with start values and bounds, arrays (parameters,).

    ``follows``: whether the joint stiffness is unknown and scales with the bar's modulus, by its scaling law.
    ``groups``: names of loops or specimens with values of their own, else empty. ``priors``: mean and standard
    deviation by name; ``weight``: standard deviation of a point, N m, against which priors count.
    """

    beam: Beam
    load: str
    rows: tuple[Parameter, ...]
    start: Array
    low: Array
    high: Array
    base: Physical
    follows: bool
    groups: tuple[str, ...] = ()
    priors: Mapping[str, tuple[float, float]] = MappingProxyType({})
    weight: float = 0.0

    @property
    def scales(self) -> int:
        """Number of pitches over which load angles are counted."""
        return TESTS[self.load].counted(self.beam.pitches)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the parameters."""
        return tuple(p.name for p in self.rows)

    def place(self, name: str) -> int | None:
        """Return the index of a parameter; None if it is not to be found."""
        return self.names.index(name) if name in self.names else None

    def bound(self, name: str, end: int) -> float:
        """Return the lower (0) or upper (1) bound of a parameter; the beam's value if it is not to be found."""
        i = self.place(name)
        return self._of(name) if i is None else float((self.low, self.high)[end][i])

    def physical(self, p: Array, group: int | None = None) -> Physical:
        """Return the physical quantities of a group, or their means, for values p (..., parameters)."""
        v: dict[str, Any] = {}
        for row, value in zip(self.rows, np.moveaxis(np.asarray(p), -1, 0), strict=True):
            if row.group is None or group is None:
                v[row.base] = v.get(row.base, 0.0) + value / (1 if row.group is None else len(self.groups))
            elif row.group == group:
                v[row.base] = value
        scale, modulus = (v.get(name, self._of(name)) / self._of(name) for name in ("C_f", "E_B"))
        K = self.base.stiffness * (modulus if self.follows else 1.0)
        return Physical(
            v.get("mu", self.base.mu),
            v.get("K_theta", K),
            self.base.rigidity * scale * modulus,
            v.get("theta0", self.base.theta0),
            *(v.get(name, getattr(self.base, name)) for name in NUISANCES),
        )._replace(modulus=modulus)

    def chain(self, p: Array, group: int | None = None) -> Array:
        """Return the derivatives of the physical quantities by the parameters, shape (10, parameters)."""
        moved = self.physical(p + 1j * STEP * np.eye(p.size), group)
        return np.array([np.broadcast_to(np.imag(value), p.size) for value in moved]) / STEP

    def _of(self, name: str) -> float:
        return PARAMETERS[name].value(self.beam, self.load)

    @property
    def known(self) -> tuple[Array, Array]:
        """Means and standard deviations of the priors, (parameters,) each; the deviation is inf without a prior."""
        pairs = [self.priors.get(row.base, (0.0, math.inf)) for row in self.rows]
        mean, spread = np.array(pairs, float).reshape(-1, 2).T
        return mean, spread

    def pull(self, p: Array) -> Array:
        """Return the residuals of the priors, N m, with the sign of measured - model; 0 without a prior."""
        mean, spread = self.known
        return np.asarray(self.weight * (mean - p) / spread)

    @property
    def pull_slope(self) -> Array:
        """Derivatives of the priors' "torques" by the parameters, N m, shape (parameters, parameters)."""
        return np.asarray(np.diag(self.weight / self.known[1]))

    def more(self, names: Sequence[str], limits: Mapping[str, tuple[object, object]]) -> Asked:
        """Return the parameters with further ``names``, and their limits."""
        rows, *columns = _columns(self.beam, self.load, names, limits, self.priors)
        own = (self.start, self.low, self.high)
        start, low, high = (np.concatenate(pair) for pair in zip(own, columns, strict=True))
        return self._replace(rows=(*self.rows, *rows), start=start, low=low, high=high)

    def also(self, rows: Sequence[Parameter], priors: Mapping[str, tuple[float, float]], weight: float) -> Asked:
        """Return the parameters with further rows that have priors; ``weight`` where none is set yet."""
        mean = np.array([priors[row.name][0] for row in rows])
        ends = zip((self.start, self.low, self.high), (mean, *np.array([row.limits for row in rows]).T), strict=True)
        start, low, high = (np.concatenate(pair) for pair in ends)
        known, weight = {**self.priors, **priors}, self.weight or weight
        return self._replace(rows=(*self.rows, *rows), start=start, low=low, high=high, priors=known, weight=weight)

    def apart(self, each: Sequence[str], groups: tuple[str, ...]) -> Asked:
        """Return the parameters with those of ``each`` repeated for each of the named groups."""
        rows, places = list[Parameter](), list[int]()
        for i, row in enumerate(self.rows):
            own = [row._replace(name=f"{row.name}[{g + 1}]", words=f"{row.words}, {word}", group=g)
                   for g, word in enumerate(groups)]  # fmt: skip
            rows += own if row.name in each else [row]
            places += [i] * (len(own) if row.name in each else 1)
        columns = {name: getattr(self, name)[places] for name in ("start", "low", "high")}
        return self._replace(rows=tuple(rows), groups=groups, **columns)

    def spread(self, values: Mapping[str, float]) -> Array:
        """Return values by base name as an array over all rows, groups included."""
        return np.array([values[row.base] for row in self.rows])

    def without(self, names: Collection[str]) -> Asked:
        """Return the parameters without some names."""
        kept = [i for i, name in enumerate(self.names) if name not in names]
        rows = tuple(self.rows[i] for i in kept)
        return self._replace(rows=rows, start=self.start[kept], low=self.low[kept], high=self.high[kept])

    def fitted(self, p: Array) -> Beam:
        """Return the beam with values p of the parameters, averaged over groups."""
        found: dict[str, list[float]] = {}
        for row, value in zip(self.rows, p.tolist(), strict=True):
            found.setdefault(row.place, []).append(value)
        return self.beam._with({place: math.fsum(v) / len(v) for place, v in found.items() if place})


def ask(
    beam: Beam,
    load: str,
    names: Sequence[str] | str,
    bounds: Mapping[str, tuple[object, object]] | None = None,
    *,
    joint: str = "compliant",
    priors: Mapping[str, tuple[float, float]] = MappingProxyType({}),
) -> Asked:
    """Check the parameters to find and their bounds (SI numbers or texts); start values are those of the beam."""
    given, problems = named(names, PARAMETERS), Problems()
    follows = beam.joint.stiffness is None and "K_theta" not in given
    if joint == "hinge" and {"C_f", "E_B"} <= set(given) and not follows:
        reason = "C_f and E_B: only their product enters the torque on hinges, no test tells them apart"
        refuse("parameters", "", reason, "find one")
    if "mu" not in given:
        arguments.friction(beam.friction.mu, None, "find it too")
    with problems.caught():
        found = _columns(beam, load, given, bounds or {}, priors)
    for n in bounds or {}:
        if n not in PARAMETERS:
            problems.append(_unknown("bounds", n))
        elif n not in given:
            reason = f"{n} is not to be found (found are: {', '.join(given)})"
            problems.add("bounds", "", reason, "leave it out, or find it too")
    problems.settle()
    stiffness, rigidity = beam.joint_stiffness, TESTS[load].rigidity(beam)
    base = Physical(beam.friction.mu or 0.0, stiffness, rigidity, beam.scale.theta0)
    return Asked(beam, load, *found, base, follows, priors=priors)


def _columns(
    beam: Beam,
    load: str,
    names: Sequence[str],
    bounds: Mapping[str, tuple[object, object]],
    priors: Mapping[str, tuple[float, float]],
) -> tuple[tuple[Parameter, ...], Array, Array, Array]:
    """Return rows of parameters, start values and bounds; wrong bounds are refused together."""
    rows, problems, found = tuple(PARAMETERS[n].of(load) for n in names), Problems(), list[tuple[float, float]]()
    for row in rows:
        with problems.caught():
            found.append(_bounds(row, row.value(beam, load), bounds.get(row.name)))
    problems.settle()
    low, high = np.array(found, float).reshape(-1, 2).T
    start = np.clip([priors.get(row.name, (row.value(beam, load),))[0] for row in rows], low, high)
    return rows, start, low, high


def named(names: Sequence[str] | str, known: Collection[str]) -> list[str]:
    """Return the checked names of the parameters to find."""
    given = [n.strip() for n in names.split(",")] if isinstance(names, str) else [str(n) for n in names]
    problems, once = Problems(), dict.fromkeys(given)
    problems += [Problem("parameters", "", f"{n} is given twice", "give it once") for n in once if given.count(n) > 1]
    problems += [_unknown("parameters", n, known) for n in once if n not in known]
    if not given:
        problems.add("parameters", "", "none is named", 'give e.g. ("mu", "K_theta")')
    problems.settle()
    return given


def _unknown(where: str, name: str, known: Collection[str] = PARAMETERS.keys()) -> Problem:
    """Return the mistake of an unknown name: the name used here for it, or the most likely one, and all names."""
    listed, meant = ", ".join(known), _OTHER_NAMES.get(name)
    remedy = f"{tabular.guess(name, known)}known are {listed}"
    if meant and meant in known:
        remedy = f"write {meant} ({PARAMETERS[meant].words}) or another of {listed}"
    return Problem(where, "", f'"{name}" is not the name of a parameter', remedy)


def _bounds(row: Parameter, value: float, given: object) -> tuple[float, float]:
    """Return the bounds of a parameter; wide ones where none is given or an end is open (None or "")."""
    least, most = row.limits
    low, high = least, most
    if row.place and row.name != "mu":
        wide = _ANGLES if row.dimension is Dimension.ANGLE else _WIDE
        low, high = max(least, value / wide), min(most, value * wide)
    if given is None:
        return low, high
    where = f"bounds: {row.name}"
    if not isinstance(given, Sequence | np.ndarray) or isinstance(given, str) or len(given) != 2:
        refuse(where, "", "give two values, the lower and the upper one")
    with naming(where):
        low, high = (
            other if end is None or (isinstance(end, str) and not end.strip()) else units.quantity(end, row.dimension)
            for end, other in zip(given, (low, high), strict=True)
        )
    if low >= high:
        turned = " (they are reversed)" if low > high else ""
        reason = f"the lower bound {low:.6g} is not below the upper {high:.6g}{turned}"
        refuse(where, "", reason, "give the smaller one first")
    for end in (low, high):
        if not least <= end <= most:
            refuse(where, f"{end:.6g}", f"must lie within {least:g} and {most:.4g}")
    return low, high

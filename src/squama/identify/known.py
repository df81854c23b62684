r"""Prior knowledge of a fit: tolerances of the beam and of the machine.

A tolerance of a parameter of :data:`squama.identify.unknowns.PARAMETERS` is its prior. A dimension of the beam, such as
the angle of its scales, is no parameter of the search: within its tolerance the torque is linear in it,

.. math:: T = T(p) + \frac{\partial T}{\partial d}\,(d - d_0),

with the derivative as a difference of two beams about the estimates, joint and readings unchanged. The dimension is
then estimated with all parameters, from its prior and from the points, with the torque linearised about the estimate.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from types import MappingProxyType

import numpy as np

from squama.beam.design import Beam
from squama.curves import hinge_cycles
from squama.errors import InputError, Problems, refuse
from squama.identify import groups
from squama.identify.hinge_points import Hinged
from squama.identify.joint_points import Walked
from squama.identify.machine import Machine
from squama.identify.prepare import Prepared, Wanted
from squama.identify.selection import Found, settle
from squama.identify.unknowns import PARAMETERS, Asked, Parameter
from squama.loads import TESTS
from squama.study import parameters as study
from squama.study.tolerances import distributions
from squama.study.tolerances.distributions import Tolerance
from squama.types import Array

_PLACES = {row.place: name for name, row in PARAMETERS.items() if row.place}
"""Names of parameters by their names in the beam file."""
_WIDE, _STEP = 6.0, 0.5
"""Range of a dimension, and step of its difference, in standard deviations."""
_ROUNDS, _STAYS = 4, 0.1
"""Largest number of linearisations; move of the dimensions over their errors below which they have converged."""
_NEAR = 1e-9


def read(given: Mapping[str, object], beam: Beam, *, bare: bool = True) -> list[Tolerance]:
    """Return the tolerances of a fit, by names of the fit or of the beam file; ``bare``: numbers may have no unit."""
    by_place = {PARAMETERS[name].place or name if name in PARAMETERS else name: v for name, v in given.items()}
    found, problems = distributions.tolerances(by_place, beam, bare=bare, joint="compliant", ideal=False), Problems()
    for one in found:
        if one.name == study.FACTOR:
            problems.add(one.name, "", "is no parameter of a fit", "give a tolerance of K_theta")
    problems.settle()
    return found


Known = Mapping[str, tuple[float, float]]
"""Mean and standard deviation (SI) by name."""


def priors(
    given: Mapping[str, object] | None, beam: Beam, machine: Machine | None, names: Collection[str]
) -> tuple[Known, Known]:
    """Return the priors of parameters and of dimensions; an inclination that is not among ``names`` is a dimension."""
    found, dimensions = dict[str, tuple[float, float]](), dict[str, tuple[float, float]]()
    for one in [] if given is None else read(given, beam):
        name = _PLACES.get(one.name, "")
        if name and (name != "theta0" or name in names):
            found[name] = one.moments
        else:
            dimensions[one.name] = one.moments
    if machine is not None and machine.deviation:
        found["compliance"] = machine.compliance, machine.deviation
    return found, MappingProxyType(dimensions)


def tolerated(made: Prepared, found: Found, wanted: Wanted) -> tuple[Prepared, Found]:
    """Find dimensions of the beam too by Gauss-Newton steps; return the test of that beam, and the estimates."""
    rows = [_row(name, *wanted.dimensions[name]) for name in wanted.dimensions]
    at = np.array([wanted.dimensions[row.name][0] for row in rows])
    least = found.noise * math.sqrt(found.dependence) or 1e-6 * float(np.abs(made.record.torque).max())
    p, one, test = found.estimates, found, made
    for _ in range(_ROUNDS):
        test = _with(made, rows, at, wanted.law)
        bare = found.asked._replace(base=test.asked.base)
        shifts = {row.name: (value, _shift(made, bare, p, rows, at, i, wanted))
                  for i, (row, value) in enumerate(zip(rows, at.tolist(), strict=True))}  # fmt: skip
        test.points.readings = test.points.readings._replace(shifts=shifts)
        asked = bare.also(rows, wanted.dimensions, least)
        points = groups.about(test.points, bare, p)
        one = settle(test._replace(asked=asked, usable=found.used, points=points), np.concatenate([p, at]))
        move = np.abs(one.estimates[p.size :] - at) / one.deviations[p.size :]
        p, at = one.estimates[: p.size], one.estimates[p.size :]
        if move.max() < _STAYS:
            break
    kept = {name: getattr(found, name) for name in ("stray", "starts", "added")}
    return test, Found(**{**vars(one), **kept})


def _row(name: str, mean: float, deviation: float) -> Parameter:
    """Return a dimension of the beam as a parameter, bounded by some standard deviations."""
    dimension, bounds, symbol = study.PARAMETERS[study.canonical(name)]
    low, high = max(mean - _WIDE * deviation, bounds.low), min(mean + _WIDE * deviation, bounds.high)
    return Parameter(name, dimension, symbol.long_name, (low, high), name)


def _with(made: Prepared, rows: list[Parameter], at: Array, law: str) -> Prepared:
    """Return a test of the beam with dimensions ``at``, the joint unchanged."""
    asked, points = made.asked, made.points
    beam = asked.beam._with({row.place: value for row, value in zip(rows, at.tolist(), strict=True)})
    rigid = TESTS[asked.load].rigidity
    rigidity = asked.base.rigidity * rigid(beam) / rigid(asked.beam)
    asked = asked._replace(base=asked.base._replace(rigidity=rigidity, theta0=beam.scale.theta0))
    if isinstance(points, Walked):
        return made._replace(asked=asked, points=points.changed(beam=beam))
    senses = hinge_cycles.senses(beam, asked.load, asked.bound("mu", 0), law, _NEAR)
    return made._replace(asked=asked, points=Hinged(senses, points.readings))


def _shift(made: Prepared, asked: Asked, p: Array, rows: list[Parameter], at: Array, i: int, wanted: Wanted) -> Array:
    """Return the derivative of the torque by dimension ``i`` at all readings."""
    _, deviation = wanted.dimensions[rows[i].name]
    ends = []
    for step in (_STEP * deviation, 0.0, -_STEP * deviation):
        moved = at.copy()
        moved[i] += step
        try:
            test = _with(made, rows, moved, wanted.law)
            ends.append((step, test.points.whole(asked._replace(base=test.asked.base).physical(p))))
        except InputError:
            continue
    if len(ends) < 2:
        refuse(f"tolerances: {rows[i].name}", "", "beams within it do not follow the record", "make it narrower")
    (high, up), (low, down) = ends[0], ends[-1]
    return np.asarray((up - down) / (high - low))

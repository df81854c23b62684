"""What is known before a test: tolerances of the beam and the machine, as priors of the parameters of a fit."""

from __future__ import annotations

from collections.abc import Mapping

from squama.beam.design import Beam
from squama.errors import Problems
from squama.identify.machine import Machine
from squama.identify.unknowns import PARAMETERS
from squama.study.tolerances import distributions
from squama.study.tolerances.distributions import Tolerance

_PLACES = {row.place: name for name, row in PARAMETERS.items() if row.place}
"""Names of parameters by those of the beam file."""


def read(given: Mapping[str, object], beam: Beam, *, bare: bool = True) -> list[Tolerance]:
    """Return the tolerances of a fit, by the names of a fit or of the beam file; ``bare``: numbers may have no unit."""
    by_place = {PARAMETERS[name].place or name if name in PARAMETERS else name: v for name, v in given.items()}
    found, problems = distributions.tolerances(by_place, beam, bare=bare, joint="compliant", ideal=False), Problems()
    for one in found:
        if one.name not in _PLACES:
            problems.add(one.name, "", "is no parameter of a fit", f"give {', '.join(_PLACES.values())}")
    problems.settle()
    return found


def priors(given: Mapping[str, object] | None, beam: Beam, machine: Machine | None) -> dict[str, tuple[float, float]]:
    """Return mean and standard deviation by name of the parameters that have a tolerance; see :func:`squama.fit`."""
    found = {} if given is None else {_PLACES[one.name]: one.moments for one in read(given, beam)}
    if machine is not None and machine.deviation:
        found["compliance"] = machine.compliance, machine.deviation
    return found

r"""The testing machine: a stiffness k in series with the specimen, and the effect of an unknown one on a fit.

The measured rotation includes T/k of the machine. Records are corrected for a given k
(:mod:`squama.identify.readings`); with "+-" the compliance c = 1/k is found too, with the given value as its prior.
Where no k is given, a compliance c would change the torque at the readings by J_c c, with the derivative J_c of the
torque by c, and so the estimates by

.. math:: \Delta p = (J^\mathsf{T} J)^{-1} J^\mathsf{T} J_c\, c

in the fit that ignores it (J with the rows of the priors).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from squama.errors import naming, refuse
from squama.identify.estimate import Points
from squama.identify.hinge_points import Physical
from squama.identify.unknowns import Asked
from squama.loads import TESTS, Load
from squama.study.tolerances.distributions import spread
from squama.types import Array
from squama.units import Bounds, Dimension, number

STIFFNESS = Bounds(1e-12, 1e15, "1e-12 to 1e15 N m/rad", closed=True, example='"2 N m/rad"')
FRAME = Bounds(1e-12, 1e15, "1e-12 to 1e15 N/m", closed=True, example='"5 N/mm"')
"""Bounds of the torsional or bending stiffness of a machine, and of that of a frame which pushes."""
SHARES = (0.005, 0.01, 0.02)
"""Shares of the rotation at the top of a record that an unknown machine may take."""
RIGID = "rigid"
_TOLD = ("mu", "K_theta")
"""Parameters whose changes are reported."""
_SEEN = 1.0
"""Change of an estimate by the last of the shares, over its error, above which the machine is reported."""


class Machine(NamedTuple):
    """Compliance of a machine, rad/(N m) or m/N, and its standard deviation; 0 where it is exact."""

    compliance: float
    deviation: float = 0.0


def read(given: object, load: Load) -> Machine | None:
    """Return the machine of a fit under a load, None where it is unknown; see :func:`squama.fit`."""
    if given is None or given == RIGID:
        return None if given is None else Machine(0.0)
    with naming("machine"):
        size = (Dimension.SPRING, FRAME) if load.pushed else (Dimension.TORQUE, STIFFNESS)
        k, deviation = spread(given, *size)
        if deviation * 2 >= k:
            wide = f'{size[1].example[:-1].replace(" ", " +- 0.5 ", 1)}"'
            refuse("", str(given), "is too wide: no machine stiffness is below 0", f"write e.g. {wide}")
    return Machine(1 / k, deviation / k**2)


class Unknown(NamedTuple):
    """Effect of an unknown machine on a fit; ``told``: whether to report it.

    ``stiffness`` (N m/rad, or N/m) of a machine that takes 1 % of the rotation (travel) at the top, and the ``changes``
    of the estimates if it were taken into account.
    """

    stiffness: float
    changes: Array
    names: tuple[str, ...]
    told: bool
    load: Load

    def report(self) -> dict[str, object]:
        """Return the effect as plain data."""
        return {"stiffness": self.stiffness, "changes": dict(zip(self.names, self.changes.tolist(), strict=True))}

    def sentence(self, values: dict[str, float]) -> str:
        """Return a sentence: the effect of the shares of :data:`SHARES` on friction and joint stiffness."""
        parts = []
        for name, change in zip(self.names, self.changes.tolist(), strict=True):
            all_of = [change * share / 0.01 for share in SHARES]
            if name == "K_theta":
                parts.append(f"K_theta by {', '.join(f'{100 * c / values[name]:+.2g}' for c in all_of)} %")
            elif name in _TOLD:
                digits = max(0, 1 - math.floor(math.log10(abs(change)))) if change else 3
                parts.append(f"{name} by {', '.join(f'{c:+.{digits}f}' for c in all_of)}")
        shares = ", ".join(f"{100 * share:g}" for share in SHARES)
        of = self.load.way if self.load.pushed else "rotation"
        own = number(self.stiffness / 1e3, "N/mm") if self.load.pushed else number(self.stiffness, "N m/rad")
        effect = f"if it takes {shares} % of the {of} at the top, that changes {' and '.join(parts)}"
        return f'machine not given: {effect}; give its stiffness (1 %: machine "{own}"), or "{RIGID}"'


def unknown(
    points: Points, used: NDArray[np.bool_], asked: Asked, estimates: Array, jacobian: Array, errors: Array
) -> Unknown | None:
    """Return the effect of an unknown machine on a fit, from its ``jacobian`` with priors; None without torque."""
    readings, place = points.readings, Physical._fields.index("compliance")
    size = np.where(used, np.abs(readings.load), -1.0)
    top = int(np.argmax(size))
    torque = abs(float(readings.torque[top]))
    if "compliance" in asked.names or not torque > 0 or not size[top] > 0:
        return None
    percent = 0.01 * float(size[top]) * readings.scales / torque
    wanted = np.arange(len(Physical._fields)) == place
    column = points.take(np.flatnonzero(used)).jacobian(asked.physical(estimates), wanted)[:, place] * percent
    # the priors do not depend on the machine
    target = np.concatenate([column, np.zeros(len(jacobian) - column.size)])
    norm = np.linalg.norm(jacobian, axis=0)
    changes = -np.linalg.lstsq(jacobian / norm, target, rcond=None)[0] / norm
    far = np.abs(changes) * SHARES[-1] / 0.01 > _SEEN * errors
    told = any(f for f, name in zip(far, asked.names, strict=True) if name in _TOLD)
    return Unknown(1 / percent, changes, asked.names, told, TESTS[asked.load])

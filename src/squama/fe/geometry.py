"""Geometry of one pitch for the elements: ratios of the beam, place of scale 0, and cuts between pitches.

Lengths in pitches, angles in radians. z is the torsion axis, y points out of the scaled face, x across. Scale 0 has its
base midpoint at O = (0, lambda, 0) and the axes (theory, section 2)
    n_X = (-sin a cos th, sin th, cos a cos th)    n_Y = (cos a, 0, sin a)    n_Z = n_X x n_Y.
It fills -zeta <= X <= eta, |Y| <= beta, |Z| <= t_s/2; what has X < 0 is embedded.
"""

from __future__ import annotations

from math import ceil, cos, sin, tan
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from squama.errors import Problems
from squama.fe.plate import Rest

if TYPE_CHECKING:
    from squama.beam.design import Beam

ROOM = 0.02
"""Least distance of an embedded scale from the substrate's other face, over the substrate's thickness."""
CROWDED = 0.85
"""Share of the pitch along the bar above which an embedded scale is long, so that cuts between pitches lean with it."""

PLAIN = 0.2
"""Least length of plain bar between cuts that lean and the end of a row, pitches."""


class Ends(NamedTuple):
    """Plane end sections of a row at rest, z = x ``slope`` + ``start`` and ``pitches`` + n further for n pitches.

    ``pitches`` of plain bar, half of them at each end, fill the space between these sections and the cuts.
    """

    pitches: int
    start: float
    slope: float


class Geometry(NamedTuple):
    """A pitch of a beam: lengths over the pitch d, angles in rad.

    ``width`` of the section, half thickness ``lam``, embedded length ``zeta``, exposed length ``eta``, half width
    ``beta`` and ``thickness`` of a scale, ``alpha``, ``theta0``, Poisson's ratio ``nu``.
    """

    width: float
    lam: float
    zeta: float
    eta: float
    beta: float
    thickness: float
    alpha: float
    theta0: float
    nu: float

    @property
    def rest(self) -> Rest:
        """Rest position of scale 0."""
        return Rest.at(self.eta, self.beta, self.lam, self.alpha, self.theta0)

    @property
    def footprint(self) -> tuple[float, float]:
        """Begin and end of the slot of scale 0 along the bar, as z - x tan(alpha), pitches."""
        th, half = self.theta0, self.thickness / 2
        low, high = -self.zeta * cos(th) - half * sin(th), half / sin(th)
        return low / cos(self.alpha), high / cos(self.alpha)

    @property
    def gap(self) -> float:
        """Distance between the mid-planes of neighbours, pitches: parallel plates of this thickness touch."""
        return cos(self.alpha) * sin(self.theta0)

    def longest(self, share: float) -> float:
        """Return the embedded length (pitches) with which the slot takes a share of the pitch; below 0: none."""
        half, th = self.thickness / 2, self.theta0
        return (share * cos(self.alpha) - half / sin(th) - half * sin(th)) / cos(th)

    @property
    def lean(self) -> float:
        """Slope of the cuts along the bar over depth: 0, or that of the embedded parts where these are long."""
        low, high = self.footprint
        return 0.0 if high - low <= CROWDED else 1 / (tan(self.theta0) * cos(self.alpha))

    @property
    def cut(self) -> float:
        """Place c of the pitch's front on the scaled face, z - x tan(alpha), pitches; the back is a pitch further."""
        return -0.5 if self.lean else (sum(self.footprint) - 1) / 2

    @property
    def knee(self) -> float:
        """Depth (pitches) down to which leaning cuts lean, below the embedded part; 0 for plane cuts."""
        return min(self.depth + self.gap / 2, 2 * self.lam) if self.lean else 0.0

    @property
    def oblique(self) -> Ends:
        """Ends along the bases of the scales, with plain bar only where cuts lean in depth."""
        return self._ends(0.0, tan(self.alpha))

    @property
    def square(self) -> Ends:
        """Ends across the bar, as those of a specimen."""
        return self._ends(abs(self.width * tan(self.alpha)), 0.0)

    def _ends(self, skew: float, slope: float) -> Ends:
        leaning = self.lean * self.knee + skew
        pitches = ceil(leaning + 2 * PLAIN) if leaning else 0
        return Ends(pitches, self.cut - (pitches + self.lean * self.knee) / 2, slope)

    def front(self, y: NDArray[np.float64] | float) -> NDArray[np.float64]:
        """Return the front, z - x tan(alpha), at heights y (pitches), parallel to long embedded parts."""
        return self.cut + self.lean * np.maximum(np.asarray(y) - self.lam, -self.knee)

    @property
    def depth(self) -> float:
        """Depth of the slot below the scaled face, pitches."""
        return self.zeta * sin(self.theta0) + self.thickness / 2 * cos(self.theta0)

    def local(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return points (n, 3) on the axes of scale 0 at rest, from O, pitches."""
        return np.asarray((points - self.rest.base) @ self.rest.axes.T)

    def in_slot(self, points: NDArray[np.float64], slack: float = 1e-7) -> NDArray[np.bool_]:
        """Return whether points (n, 3) lie in the slot or on its walls (n,)."""
        p = self.local(points)
        inside = (p[:, 0] >= -self.zeta - slack) & (np.abs(p[:, 1]) <= self.beta + slack)
        return np.asarray(inside & (np.abs(p[:, 2]) <= self.thickness / 2 + slack))

    def check(self) -> None:
        """Refuse a scale that does not fit into a pitch of the substrate; a line per mistake, with the dimension."""
        half, th = self.thickness / 2, self.theta0
        problems, embedded = Problems(), f"{self.zeta:.4g} pitches"
        if self.thickness >= self.gap:
            thickness = f"{self.thickness:.4g} pitches"
            reason = "the embedded parts of neighbours meet, which are cos(alpha) sin(theta0) pitches apart"
            problems.add("scale.thickness", thickness, reason, f"write less than {self.gap:.4g}")
            problems.settle()
        if self.zeta * sin(th) <= half * cos(th):
            reason = f"the substrate does not close over the scale, whose thickness is {self.thickness:.4g}"
            problems.add("scale.embedded", embedded, reason, f"write more than {half / tan(th):.4g}")
        if self.depth > (most := 2 * self.lam * (1 - ROOM)):
            down, deep = (most - half * cos(th)) / sin(th), f"its depth is {self.depth:.4g} of {2 * self.lam:.4g}"
            reason = f"the scale comes out of the substrate's other face, {deep}"
            problems.add("scale.embedded", embedded, reason, f"write at most {down:.4g}")
        problems.settle()


def geometry(beam: Beam) -> Geometry:
    """Return a beam's geometry in pitches."""
    d = beam.pitch
    width, scale, nu = beam.substrate.width / d, beam.scale, beam.substrate.poisson_ratio
    ratios = width, beam.lam, beam.zeta, beam.eta, beam.beta, scale.thickness / d
    return Geometry(*ratios, scale.alpha, scale.theta0, nu)

"""What the elements need of a beam: ratios, and where scale 0 stands.

Lengths in pitches, angles in radians. z is the torsion axis, y points out of the scaled face, x across. Scale 0 has its
base midpoint at O = (0, lambda, 0) and the axes (theory, section 2)
    n_X = (-sin a cos th, sin th, cos a cos th)    n_Y = (cos a, 0, sin a)    n_Z = n_X x n_Y.
It fills -zeta <= X <= eta, |Y| <= beta, |Z| <= t_s/2; what has X < 0 is embedded.
"""

from __future__ import annotations

from math import cos, sin, tan
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from squama.errors import InputError

if TYPE_CHECKING:
    from squama.design import Beam

ROOM = 0.02
"""Least room between two embedded scales, in pitches along the bar."""


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
    def axes(self) -> NDArray[np.float64]:
        """Axes n_X, n_Y, n_Z of scale 0 at rest, as rows."""
        a, th = self.alpha, self.theta0
        x = np.array([-sin(a) * cos(th), sin(th), cos(a) * cos(th)])
        y = np.array([cos(a), 0.0, sin(a)])
        return np.array([x, y, np.cross(x, y)])

    @property
    def base(self) -> NDArray[np.float64]:
        """Base midpoint O of scale 0."""
        return np.array([0.0, self.lam, 0.0])

    @property
    def footprint(self) -> tuple[float, float]:
        """Where the slot of scale 0 begins and ends along the bar, as z - x tan(alpha)."""
        th, half = self.theta0, self.thickness / 2
        low, high = -self.zeta * cos(th) - half * sin(th), half / sin(th)
        return low / cos(self.alpha), high / cos(self.alpha)

    @property
    def cut(self) -> float:
        """Place c of the pitch's front plane z = x tan(alpha) + c; the back plane is one pitch further."""
        return (sum(self.footprint) - 1) / 2

    @property
    def depth(self) -> float:
        """How far the slot reaches below the scaled face."""
        return self.zeta * sin(self.theta0) + self.thickness / 2 * cos(self.theta0)

    def local(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return points (n, 3) in the axes of scale 0 at rest, from O."""
        return np.asarray((points - self.base) @ self.axes.T)

    def in_slot(self, points: NDArray[np.float64], slack: float = 1e-7) -> NDArray[np.bool_]:
        """Say which points (n, 3) lie in the slot or on its walls."""
        p = self.local(points)
        inside = (p[:, 0] >= -self.zeta - slack) & (np.abs(p[:, 1]) <= self.beta + slack)
        return np.asarray(inside & (np.abs(p[:, 2]) <= self.thickness / 2 + slack))

    def check(self) -> None:
        """Refuse a scale that does not fit into a pitch of the substrate.

        Raises
        ------
        InputError
            One line per mistake, each with the dimension that is to be changed.
        """
        half, th, a = self.thickness / 2, self.theta0, self.alpha
        lines = []
        if self.zeta * sin(th) <= half * cos(th):
            least = half / tan(th)
            lines.append(
                f"scale.embedded = {self.zeta:.4g} pitches: the substrate does not close over the scale, whose "
                f"thickness is {self.thickness:.4g}; write more than {least:.4g}"
            )
        low, high = self.footprint
        if high - low > 1 - ROOM:
            most = ((1 - ROOM - high) * cos(a) - half * sin(th)) / cos(th)
            change = (
                f"write at most {most:.4g}, or a smaller scale.alpha" if most > 0 else "write a smaller scale.alpha"
            )
            lines.append(
                f"scale.embedded = {self.zeta:.4g} pitches: the embedded parts of neighbours meet, each takes "
                f"{high - low:.3g} pitches along the bar at alpha = {np.degrees(a):.4g} deg; {change}"
            )
        if self.depth > 2 * self.lam * (1 - ROOM):
            most = (2 * self.lam * (1 - ROOM) - half * cos(th)) / sin(th)
            lines.append(
                f"scale.embedded = {self.zeta:.4g} pitches: the scale comes out of the substrate's other face, its "
                f"depth is {self.depth:.4g} of {2 * self.lam:.4g}; write at most {most:.4g}"
            )
        if lines:
            raise InputError("\n".join(lines))


def geometry(beam: Beam) -> Geometry:
    """Return a beam's geometry in pitches.

    Parameters
    ----------
    beam : Beam
        The beam.

    Returns
    -------
    Geometry
    """
    d = beam.pitch
    return Geometry(
        width=beam.substrate.width / d,
        lam=beam.lam,
        zeta=beam.zeta,
        eta=beam.eta,
        beta=beam.beta,
        thickness=beam.scale.thickness / d,
        alpha=beam.scale.alpha,
        theta0=beam.scale.theta0,
        nu=beam.substrate.poisson_ratio,
    )

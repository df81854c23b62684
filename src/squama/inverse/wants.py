"""What may be asked of designs: figures by name, twists at which they are wanted, what is common to all designs."""

from __future__ import annotations

from typing import Any, NamedTuple

from squama.model.outcome import CODES
from squama.model.solve import Array

PATH = {"twisting": ("eta", "beta", "lam", "alpha", "theta0", "mu"), "bending": ("eta", "theta0", "mu")}
"""Columns that a path depends on."""
COLUMNS = ("eta", "beta", "lam", "alpha", "theta0", "mu", "ratio", "K", "d", "rigidity")
LOCKS = tuple(CODES.index(end) for end in CODES if end.locks)

Partials = dict[str, Array]


class At(NamedTuple):
    """A twist, ``rate * d + angle`` in rad per pitch: a rate (rad/m) or an angle per pitch whatever the pitch is."""

    rate: float
    angle: float

    def per_pitch(self, d: Any) -> Any:
        """Twist in rad per pitch of beams with the pitch d (m)."""
        return self.rate * d + self.angle


class Want(NamedTuple):
    """A figure by name (see :data:`FIGURES`), and the twist at which it is wanted."""

    figure: str
    at: At | None = None


class Options(NamedTuple):
    """What is common to all designs; ``locks`` are the codes of the ends that count as locks."""

    law: str = "edge"
    sense: str = "+"
    margin: float = 0.01
    load: str = "twisting"
    locks: tuple[int, ...] = LOCKS


class Found(NamedTuple):
    """Values of the wanted figures (wants, designs), NaN where a design has none, and how the designs end.

    ``slopes`` (wants, variables, designs) are derivatives by what was moved. ``load_end`` is how far the design's curve
    goes, rad per pitch.
    """

    values: Array
    slopes: Array
    code: Array
    load_end: Array


FIGURES = {
    "engagement": "twist per pitch at engagement, rad",
    "lock": "twist per pitch at the lock, rad",
    "range": "twist per pitch from engagement to the lock, rad",
    "stiffness": "stiffness before engagement, N m^2",
    "torque": "torque at a twist, N m",
    "tangent": "tangent stiffness at a twist, N m^2",
    "RED": "relative energy dissipation at the cut-off before the lock",
    "W_fr": "frictional work at the cut-off before the lock, J/m",
    "reach": "how far the curve goes, twist per pitch, rad",
    "tip": "room of the contact to the end of the tip edge at the lock, over the scale's half width",
    "side": "room of the contact to the end of the side edge at the lock, over the scale's length",
    "hold": "moment of friction that lacks for a lock where the contact runs off an edge, over the scale's length",
    "critical_mu": "smallest coefficient of friction that locks at engagement",
}
"""Figures by name, in SI units."""

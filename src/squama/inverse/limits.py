"""Limits on a design, for manufacture and use: each a measure that must stay above or below a value.

Measures take columns of many designs, in m and rad; complex steps pass through.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from squama.beam.design import Beam
from squama.errors import InputError
from squama.fabrication import refuse as refusals
from squama.fabrication.kinds import parts_for
from squama.fabrication.plan import MOST_SCALES, Plan, plan
from squama.inverse.named_figures import At
from squama.joints import law
from squama.joints.choice import shape
from squama.model import joint
from squama.study.columns import Cells
from squama.types import Array
from squama.units import Bounds, Dimension

WITHIN = 0.03
"""How far a design stays from the ends of the law of the joint, as a share of its range: for tolerances of making."""
_LENGTH = Bounds(0.0, 1e6, "0 or more, up to 1000 km", closed=True)


class Sizes(NamedTuple):
    """Sizes that limits use (m); ``cos`` of alpha, ``sin0`` of theta0, ``rate``: twist or curvature (rad/m)."""

    length: Array
    embedded: Array
    width: Array
    thickness: Array
    cos: Array
    sin0: Array
    bar: Array
    height: Array
    d: Array
    scales: Array
    rate: Array | float
    load: str

    @classmethod
    def of(cls, c: Cells, load: str, rate: Array | float) -> Sizes:
        """Return the sizes of designs from their columns."""
        s, b = c.sizes["scale"], c.sizes["substrate"]
        plate = s["length"], s["embedded"], s["width"], s["thickness"], np.cos(c.alpha), np.sin(c.theta0)
        return cls(*plate, b["width"], b["thickness"], c.d, c.sizes["beam"]["scales"], rate, load)

    @property
    def apart(self) -> Array:
        """Distance between the mid-planes of two neighbouring scales, m."""
        return self.d * self.sin0 * self.cos


def farthest(c: Cells, asked: Sequence[At], lock: Array | None) -> Array:
    """Return the largest twist rate (rad/m) of designs (n,), of the goals and of the lock (rad per pitch)."""
    d = c.d
    rates = [0 * d, *(at.per_pitch(d, c.sizes["beam"]["scales"]) / d for at in asked)]
    if lock is not None:
        rates.append(np.where(np.isfinite(lock.real), lock, 0.0) / d)
    every = np.array(rates)
    return np.asarray(every[np.argmax(every.real, axis=0), np.arange(d.size)])


Measure = Callable[[Sizes], Array]


class Limit(NamedTuple):
    """A limit: its measure, whether it is a lower limit, dimension and bounds of its value, its formula."""

    measure: Measure
    least: bool
    dimension: Dimension
    bounds: Bounds
    formula: str

    def room(self, s: Sizes, value: float) -> Array:
        """Return the room to the limit, in pitches or as a share of the value; negative where the limit is broken."""
        size = s.d * (s.scales if self is LIMITS["beam_length"] else 1)
        scale = size if self.dimension is Dimension.LENGTH else max(value, 1e-9)
        return (self.measure(s) - value if self.least else value - self.measure(s)) / scale


def shear_factor(width: Array | float, thickness: Array | float) -> Array:
    """Largest shear strain of a twisted rectangle over twist rate times shorter side (Saint-Venant).

    k_1 = 1 - 8/pi^2 sum over odd n of 1/(n^2 cosh(n pi a/(2 b))) for sides a >= b; at the middle of the longer side.
    Source: Timoshenko and Goodier, Theory of Elasticity, 3rd ed., section 109.

    >>> print(f"{shear_factor(1.0, 1.0):.3f} {shear_factor(2.0, 1.0):.3f}")
    0.675 0.930
    """
    longer, shorter = _sides(width, thickness)
    total = np.zeros(np.shape(longer))
    for n in range(1, 20, 2):
        fade = np.exp(-n * math.pi * longer / (2 * shorter))
        total = total + 2 * fade / (1 + fade * fade) / n**2
    return np.asarray(1 - 8 / math.pi**2 * total)


def _sides(width: Array | float, thickness: Array | float) -> tuple[Array, Array]:
    """Return the longer and the shorter side of rectangles."""
    return _most(np.asarray(width), np.asarray(thickness)), -_most(-np.asarray(width), -np.asarray(thickness))


_STRAIN: dict[str, Measure] = {
    "twisting": lambda s: s.rate * _sides(s.bar, s.height)[1] * shear_factor(s.bar, s.height),
    "bending": lambda s: s.rate * s.height / 2,
}


def _length(measure: Measure, formula: str, example: str, *, least: bool = True) -> Limit:
    return Limit(measure, least, Dimension.LENGTH, _LENGTH._replace(example=f'"{example}"'), formula)


def _ratio(measure: Measure, high: float, formula: str, example: str, *, least: bool = False) -> Limit:
    bounds = Bounds(0.0, high, f"more than 0, below {high:g}", example=example)
    return Limit(measure, least, Dimension.RATIO, bounds, formula)


LIMITS: dict[str, Limit] = {
    # bar beside the scales
    "edge": _length(lambda s: (s.bar - s.width * s.cos) / 2, "(width - 2b cos(alpha))/2", "1 mm"),
    # clear gap between neighbouring plates and between their tabs
    "gap": _length(lambda s: s.apart - s.thickness, "d sin(theta0) cos(alpha) - t_s", "1 mm"),
    # bar between two slots, along its surface
    "web": _length(lambda s: s.d * s.cos - s.thickness / s.sin0, "d cos(alpha) - t_s/sin(theta0)", "5 mm"),
    # bar under the embedded tabs
    "cover": _length(lambda s: s.height - s.embedded * s.sin0, "2t - L sin(theta0)", "4 mm"),
    "scale_thickness": _length(lambda s: s.thickness, "t_s", "0.4 mm"),
    # share of the gap that a plate fills
    "thin": _ratio(lambda s: s.thickness / s.apart, 1.0, "t_s/(d sin(theta0) cos(alpha))", '"20 %"'),
    "overlap": _ratio(lambda s: s.length / s.d, 100.0, "l/d", "1.5", least=True),
    "beam_length": _length(lambda s: s.scales * s.d, "N d", "600 mm", least=False),
    # largest strain of the bar at the farthest twist
    "strain": _ratio(lambda s: _STRAIN[s.load](s), 10.0, "Phi x shorter side x k_1; kappa t in bending", '"30 %"'),
}
"""Limits by name."""

ALWAYS = {"edge": 0.0, "cover": 0.0}
"""Default limits: scales no wider than the bar, tabs inside it."""


def rooms(s: Sizes, limits: Mapping[str, float], laws: Sequence[str]) -> dict[str, Array]:
    """Return the room to every limit by name, and to the range of scaling laws ("joint_law (t_s/d <= 0.016)")."""
    ratios = {
        "t_s/d": s.thickness / s.d,
        "L/d": s.embedded / s.d,
        "L/(2t)": s.embedded / s.height,
        "t_s/(l + L)": s.thickness / (s.length + s.embedded),
        "zeta beta/lambda": s.embedded * s.width / (s.d * s.height),
    }
    found = {name: LIMITS[name].room(s, value) for name, value in limits.items()}
    for limit in (limit for name in laws for limit in joint.LAWS[name].limits):
        share = ratios[limit.ratio]
        found[f"joint_law ({limit.ratio} <= {limit.high:g})"] = 1 - share / limit.high
        if limit.low > 0:
            found[f"joint_law ({limit.ratio} >= {limit.low:g})"] = share / limit.low - 1
    return found


def known_rooms(c: Cells, start: Cells | None = None) -> dict[str, Array]:
    """Return the room to the range of the law of compliant joints with thick scales, by name.

    Designs of a search stay :data:`WITHIN` the range, or by half of what the ``start`` of the search does.
    """
    scale, bar = c.sizes["scale"], c.sizes["substrate"]
    over = bar["width"] / c.d, c.lam, scale["embedded"] / c.d, c.beta, scale["thickness"] / c.d
    rooms = law.rooms(law.Shape(*over, c.alpha, c.theta0, bar["poisson_ratio"]))
    if start is None:
        return rooms
    return {name: rooms[name] - np.clip(room / 2, 0.0, WITHIN) for name, room in known_rooms(start).items()}


def printed_rooms(c: Cells, sizes: Plan) -> dict[str, Array]:
    """Return the room, in pitches, to the rules of :mod:`squama.fabrication.refuse` by name; ``sizes`` of the plan.

    Closed forms for the search, those of most beams; the room of the mould's slits is slightly too small. The designs
    that are returned are checked by :mod:`squama.fabrication.refuse` itself.
    """
    scale, bar = c.sizes["scale"], c.sizes["substrate"]
    clear, feature = sizes.clearance * 1e-3, sizes.feature * 1e-3
    sin, cos, ca = np.sin(c.theta0), np.cos(c.theta0), np.cos(c.alpha)
    deep, half = scale["embedded"] + clear, scale["thickness"] / 2 + clear
    out = _most(deep * cos + half * sin, half / sin) * np.sin(c.alpha)
    rooms = {
        "the slot closes over the tab": deep - half * cos / sin,
        "the slot stays inside the bar": bar["thickness"] - deep * sin - half * cos,
        "the slot stays inside the bar's sides": bar["width"] / 2 - (scale["width"] / 2 + clear) * ca - out,
        "the slits of the mould stay apart": c.d * sin * ca - 2 * half - 2 * clear,
        "the scale's thickness": scale["thickness"],
    }
    return {f"printable: {name}": (room - feature) / c.d for name, room in rooms.items()}


def _most(a: Array, b: Array) -> Array:
    """Return the larger of each two values; complex steps pass through."""
    return np.where(np.real(a) >= np.real(b), a, b)


def refused(beam: Beam, sizes: dict[str, float] | None, *, sided: bool = True) -> list[str]:
    """Return reasons, one a line, why a beam cannot be printed with a workshop's sizes, or its joint is not covered."""
    # the law of the joint is that of twisting
    unknown = sided and beam.joint.matrix is None
    lines = [f"joint: {p}" for p in law.outside(shape(beam))] if unknown else []
    if sizes is not None:
        try:
            refusals.check(plan(beam, min(beam.pitches, MOST_SCALES), sizes), parts_for(beam.faces))
        except InputError as error:
            lines += [f"printer files: {p}" for p in error.problems]
    return lines

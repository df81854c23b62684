"""What can be made and used: limits on a design, each a measure that has to stay above or below a value.

Measures take columns of many designs, in m and rad; a complex step goes through them.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from squama.model import joint
from squama.model.solve import Array
from squama.study.cells import Cells
from squama.units import Bounds, Dimension

_LENGTH = Bounds(0.0, 1e6, "0 or more, up to 1000 km", closed=True)


class Sizes(NamedTuple):
    """What limits look at; ``cos`` is cos(alpha), 1 in bending; ``rate`` is the farthest twist or curvature, rad/m."""

    length: Any
    embedded: Any
    width: Any
    thickness: Any
    cos: Any
    sin0: Any
    bar: Any
    height: Any
    d: Any
    scales: int
    rate: Any
    load: str

    @classmethod
    def of(cls, c: Cells, scales: int, load: str, rate: Any) -> Sizes:
        """Return the sizes of designs."""
        s, b = c.sizes["scale"], c.sizes["substrate"]
        cos = np.cos(c.alpha) if load == "twisting" else np.ones(np.shape(c.alpha))
        plate = s["length"], s["embedded"], s["width"], s["thickness"], cos, np.sin(c.theta0)
        return cls(*plate, b["width"], b["thickness"], c.d, scales, rate, load)

    @property
    def apart(self) -> Any:
        """Distance between the mid-planes of two neighbours."""
        return self.d * self.sin0 * self.cos


class Limit(NamedTuple):
    """A limit: its measure, whether it holds from below, bounds of its value, formula and words, an example."""

    measure: Callable[[Sizes], Any]
    least: bool
    dimension: Dimension
    bounds: Bounds
    formula: str
    words: str

    def room(self, s: Sizes, value: float) -> Any:
        """Room left, in pitches or as a share of the value; negative where the limit is broken."""
        size = s.d * (s.scales if self is LIMITS["beam_length"] else 1)
        scale = size if self.dimension is Dimension.LENGTH else max(value, 1e-9)
        return (self.measure(s) - value if self.least else value - self.measure(s)) / scale


def shear_factor(width: Any, thickness: Any) -> Any:
    """Largest shear strain of a twisted rectangle over twist rate times shorter side (Saint-Venant).

    1 - 8/pi^2 sum over odd n of 1/(n^2 cosh(n pi a/(2 b))), a >= b the sides; at the middle of the longer side. Source:
    Timoshenko and Goodier, Theory of Elasticity, 3rd ed., section 109.

    Examples
    --------
    >>> print(f"{shear_factor(1.0, 1.0):.3f} {shear_factor(2.0, 1.0):.3f}")
    0.675 0.930
    """
    longer, shorter = _sides(width, thickness)
    total: Any = 0.0
    for n in range(1, 20, 2):
        fade = np.exp(-n * math.pi * longer / (2 * shorter))
        total = total + 2 * fade / (1 + fade * fade) / n**2
    return 1 - 8 / math.pi**2 * total


def _sides(width: Any, thickness: Any) -> tuple[Any, Any]:
    first = np.real(width) >= np.real(thickness)
    return np.where(first, width, thickness), np.where(first, thickness, width)


def _strain(s: Sizes) -> Any:
    if s.load == "bending":
        return s.rate * s.height / 2
    return s.rate * _sides(s.bar, s.height)[1] * shear_factor(s.bar, s.height)


def _length(measure: Callable[[Sizes], Any], formula: str, words: str, example: str, *, least: bool = True) -> Limit:
    return Limit(measure, least, Dimension.LENGTH, _LENGTH._replace(example=example), formula, words)


def _ratio(
    measure: Callable[[Sizes], Any], high: float, formula: str, words: str, example: str, *, least: bool = False
) -> Limit:
    bounds = Bounds(0.0, high, f"more than 0, below {high:g}", example=example)
    return Limit(measure, least, Dimension.RATIO, bounds, formula, words)


LIMITS: dict[str, Limit] = {
    "edge": _length(
        lambda s: (s.bar - s.width * s.cos) / 2,
        "(width - 2b cos(alpha))/2",
        "margin of the bar beside the scales",
        '"1 mm"',
    ),
    "gap": _length(
        lambda s: s.apart - s.thickness,
        "d sin(theta0) cos(alpha) - t_s",
        "clear gap between neighbouring plates and between their tabs",
        '"1 mm"',
    ),
    "web": _length(
        lambda s: s.d * s.cos - s.thickness / s.sin0,
        "d cos(alpha) - t_s/sin(theta0)",
        "bar left between two slots, along its surface",
        '"5 mm"',
    ),
    "cover": _length(
        lambda s: s.height - s.embedded * s.sin0, "2t - L sin(theta0)", "bar left under the embedded tabs", '"4 mm"'
    ),
    "scale_thickness": _length(lambda s: s.thickness, "t_s", "thickness of a scale", '"0.4 mm"'),
    "thin": _ratio(
        lambda s: s.thickness / s.apart,
        1.0,
        "t_s/(d sin(theta0) cos(alpha))",
        "share of the gap that a plate fills",
        '"20 %"',
    ),
    "overlap": _ratio(lambda s: s.length / s.d, 100.0, "l/d", "overlap ratio", "1.5", least=True),
    "beam_length": _length(lambda s: s.scales * s.d, "N d", "length of the beam", '"600 mm"', least=False),
    "strain": _ratio(
        _strain,
        10.0,
        "Phi x shorter side x k_1; kappa t in bending",
        "largest strain of the bar at the farthest twist",
        '"30 %"',
    ),
}
"""Limits by name. In bending cos(alpha) is 1."""

ALWAYS = {"edge": 0.0, "cover": 0.0}
"""Limits that hold unless others are given: scales no wider than the bar, tabs inside it."""


def law_rooms(s: Sizes, laws: list[str]) -> dict[str, Any]:
    """Room to the ends of the ranges of scaling laws, by ratio and end (the limit ``joint_law``)."""
    ratios = {
        "t_s/d": s.thickness / s.d,
        "L/d": s.embedded / s.d,
        "L/(2t)": s.embedded / s.height,
        "t_s/(l + L)": s.thickness / (s.length + s.embedded),
        "zeta beta/lambda": s.embedded * s.width / (s.d * s.height),
    }
    rooms: dict[str, Any] = {}
    for limit in (limit for law in laws for limit in joint.LAWS[law].limits):
        value = ratios[limit.ratio]
        rooms[f"{limit.ratio} <= {limit.high:g}"] = (limit.high - value) / limit.high
        if limit.low > 0:
            rooms[f"{limit.ratio} >= {limit.low:g}"] = (value - limit.low) / limit.low
    return rooms


def measured(c: Cells, name: str, scales: int, load: str, rate: Array) -> Array:
    """Return what a limit measures of designs, SI."""
    return np.asarray(LIMITS[name].measure(Sizes.of(c, scales, load, rate)))

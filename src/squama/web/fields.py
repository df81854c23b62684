"""The fields of the page: what each is called, its unit, its range, and how it is read and set."""

from __future__ import annotations

import math
from typing import NamedTuple

from squama.beam import parts
from squama.beam.beamfile import NUMBERS, TABLES
from squama.beam.design import Beam
from squama.units import DEGREE, MARGIN, Bounds, Dimension, bounded

TWIST = Bounds(0.0, 10.0, "0 to 10 rad/pitch", closed=True, example="0.2")
"""Loads that may be asked for; a curve ends before."""


class Field(NamedTuple):
    """A number on the page: shown in ``unit`` (``factor`` SI units), its slider from ``low`` to ``high`` (shown units).

    ``place`` is table and key of the beam file, or the ratio's name after "ratio"; ``group`` the part of the page.
    """

    label: str
    symbol: str
    unit: str
    factor: float
    low: float
    high: float
    bounds: Bounds
    place: tuple[str, str]
    group: str
    log: bool = False
    whole: bool = False
    optional: bool = False

    @property
    def dimension(self) -> Dimension:
        """What it measures."""
        table, key = self.place
        return TABLES[table][key].dimension or Dimension.RATIO if table in TABLES else Dimension.RATIO

    @property
    def allowed(self) -> str:
        """The range in words: what is allowed, and where the slider goes."""
        return f"{self.bounds.allowed.split(';')[0]} (slider {self.low:g} to {self.high:g})"

    def read(self, text: str) -> float | int | None:
        """Return the SI value of what was entered: a number in the field's unit, or a number with its own unit.

        Raises InputError: it is no number, of another kind, or out of range.
        """
        text = text.strip()
        if self.optional and not text:
            return None
        if self.whole and text.isdecimal() and len(text) < 9:
            return int(text)
        return bounded(f"{text} {self.unit}".strip() if plain(text) else text, self.dimension, self.bounds, bare=False)

    def shown(self, value: float | None) -> str:
        """Return an SI value as it stands in the field."""
        return "" if value is None else f"{value / self.factor:.6g}"


def plain(text: str) -> bool:
    """Say whether a text is a number without a unit."""
    try:
        return math.isfinite(float(text))
    except ValueError:
        return False


SCALES = Bounds(2, 1e6, "a whole number from 2 to 1000000", closed=True, example="25")
_MM, _MPA = 1e-3, 1e6
_RATIOS = "Ratios and angles"
_SIZES = "Dimensions"
_STUFF = "Material and joint"
_LOAD = "Loading"


def _bounds(table: str, key: str) -> Bounds:
    return NUMBERS[f"{table}.{key}"][1]


def _size(label: str, symbol: str, table: str, key: str, low: float, high: float) -> Field:
    return Field(label, symbol, "mm", _MM, low, high, _bounds(table, key), (table, key), _SIZES, log=low > 0)


def _ratio(label: str, symbol: str, name: str, low: float, high: float) -> Field:
    return Field(label, symbol, "", 1.0, low, high, parts.RATIOS[name], ("ratio", name), _RATIOS)


def _angle(label: str, symbol: str, key: str, low: float, high: float) -> Field:
    return Field(label, symbol, "deg", DEGREE, low, high, _bounds("scale", key), ("scale", key), _RATIOS)


FIELDS: dict[str, Field] = {
    "twist": Field("Twist per pitch", "φ", "rad/pitch", 1.0, 0, 1, TWIST, ("load", "twist"), _LOAD),
    "mu": Field("Friction coefficient", "μ", "", 1.0, 0, 2, _bounds("friction", "mu"),
                ("friction", "mu"), _LOAD),
    "margin": Field("Cut-off margin before a lock", "m", "", 1.0, 1e-4, 0.5, MARGIN, ("load", "margin"), _LOAD,
                    log=True),
    "eta": _ratio("Overlap ratio l/d", "η", "eta", 0.5, 8),
    "beta": _ratio("Half width over pitch b/d", "β", "beta", 0.1, 3),
    "lam": _ratio("Half thickness over pitch t/d", "λ", "lam", 0.05, 2),
    "zeta": _ratio("Embedded over pitch L/d", "ζ", "zeta", 0.02, 1.5),
    "slenderness": _ratio("Slenderness of the tab", "L/t\N{LATIN SUBSCRIPT SMALL LETTER S}", "slenderness", 2, 80),
    "alpha": _angle("Angle of the scale width", "α", "alpha", 1, 85),
    "theta0": _angle("Inclination at rest", "θ\N{SUBSCRIPT ZERO}", "theta0", 1, 45),
    "length": _size("Scale length, exposed", "l", "scale", "length", 2, 200),
    "width": _size("Scale width", "2b", "scale", "width", 2, 100),
    "embedded": _size("Embedded length", "L", "scale", "embedded", 0, 30),
    "thickness": _size("Scale thickness", "t\N{LATIN SUBSCRIPT SMALL LETTER S}", "scale", "thickness", 0.05, 5),
    "pitch": _size("Pitch", "d", "beam", "pitch", 2, 100),
    "bar_width": _size("Substrate width", "w", "substrate", "width", 5, 150),
    "bar_thickness": _size("Substrate thickness", "2t", "substrate", "thickness", 1, 80),
    "scales": Field("Number of scales", "N", "", 1.0, 2, 60, SCALES, ("beam", "scales"), _SIZES, whole=True),
    "modulus": Field("Young's modulus of the bar", "E_B", "MPa", _MPA, 0.1, 3e4,
                     _bounds("substrate", "youngs_modulus"), ("substrate", "youngs_modulus"), _STUFF,
                     log=True),
    "poisson": Field("Poisson's ratio of the bar", "\N{GREEK SMALL LETTER NU}", "", 1.0, 0, 0.499,
                     _bounds("substrate", "poisson_ratio"), ("substrate", "poisson_ratio"), _STUFF),
    "stiffness": Field("Joint stiffness", "K_θ", "N m", 1.0, 1e-4, 1e4,
                       _bounds("joint", "stiffness"), ("joint", "stiffness"), _STUFF, log=True,
                       optional=True),
    "inclusion": Field("Inclusion factor", "C_f", "", 1.0, 1, 5,
                       _bounds("joint", "inclusion_factor"), ("joint", "inclusion_factor"), _STUFF,
                       optional=True),
}  # fmt: skip
"""Every number of the page, in its order."""
LABELS = {".".join(field.place): field.label for field in FIELDS.values() if field.place[0] in TABLES}
"""What the page calls the keys of a beam file."""
CHOICES: dict[str, tuple[str, dict[str, str]]] = {
    "load": ("Loading", {"twisting": "twisting", "bending": "bending towards the scales"}),
    "law": ("Force law", {"edge": "edge law", "plate": "plate law (the paper's)"}),
    "sense": ("Sense of twist", {"+": "+", "-": "-"}),
    "joint": ("Joint", {"hinge": "hinge (closed form)", "compliant": "compliant (elements)"}),
}
"""Choices of the page: label, and words of each value."""


def value(beam: Beam, name: str) -> float | int | None:
    """Return what a field of the beam holds, in SI units."""
    table, key = FIELDS[name].place
    return getattr(beam if table in ("ratio", "beam") else getattr(beam, table), key)  # type: ignore[no-any-return]


def changed(beam: Beam, name: str, new: float | None) -> Beam:
    """Return the beam with one field changed. A ratio changes its dimension: the pitch stays.

    Raises InputError: the beam cannot be so.
    """
    table, key = FIELDS[name].place
    if table != "ratio":
        return beam._with({f"{table}.{key}": new})
    assert new is not None
    d = beam.pitch
    place, size = {
        "eta": ("scale.length", new * d),
        "beta": ("scale.width", 2 * new * d),
        "lam": ("substrate.thickness", 2 * new * d),
        "zeta": ("scale.embedded", new * d),
        "slenderness": ("scale.thickness", beam.scale.embedded / new),
    }[key]
    return beam._with({place: size})

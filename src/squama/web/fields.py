"""The number fields of the page: label, unit, range, reading and setting."""

from __future__ import annotations

from functools import partial
from typing import Any, NamedTuple

from squama.beam.beamfile import NUMBERS
from squama.beam.design import Beam
from squama.beam.parts import RATIOS, Scale
from squama.errors import refuse
from squama.loads import LOADS
from squama.people import degrees, over
from squama.units import MARGIN, UNITS, Bounds, Dimension, NoLengthError, bounded, is_number, number, quantity, shown

MEASURES: dict[str, tuple[Dimension, Bounds]] = {
    **NUMBERS,
    **{name: (Dimension.RATIO, bounds) for name, bounds in RATIOS.items()},
    "margin": (Dimension.RATIO, MARGIN),
    "beam.scales": (Dimension.RATIO, Bounds(2, 1e6, "a whole number from 2 to 1000000", closed=True, example="25")),
}
"""Dimension and bounds of the page's numbers, by their places."""
TURNS = {"twist": (0.0, 10.0), "bend": (-1.0, 1.0)}
"""Smallest and largest twist and held bend, rad per pitch; a curve ends before."""


class Field(NamedTuple):
    """A number on the page: displayed in ``unit``, its slider from ``low`` to ``high`` (displayed unit).

    ``place`` is "table.key" of the beam file, the name of a ratio, or one of :data:`PLAIN`; ``group``: the section of
    the page. ``turn``: for a twist or bend, the factor from rad per pitch to the displayed unit, see :func:`of`.
    """

    label: str
    symbol: str
    unit: str
    low: float
    high: float
    place: str
    group: str
    log: bool = False
    whole: bool = False
    optional: bool = False
    turn: float = 0.0

    @property
    def factor(self) -> float:
        """Size of the displayed unit in SI units."""
        if self.turn:
            return 1 / self.turn
        _, factor, divisor = UNITS.get(self.unit, UNITS[""])
        return factor / divisor

    @property
    def allowed(self) -> str:
        """The allowed range and that of the slider, as text."""
        if self.turn:
            low, high = (number(self.turn * limit) for limit in TURNS[self.place])
            words = f"{low} to {high} {self.unit}"
        else:
            words = MEASURES[self.place][1].allowed.split(";")[0]
        return f"{words} ({self.slider})"

    @property
    def slider(self) -> str:
        """The range of the slider, as text."""
        return f"slider {self.low:g} to {self.high:g}"

    def read(self, text: str) -> float | int | None:
        """Return the SI value of an entry: a number in the field's unit, or a number with its own unit.

        Raises InputError for an entry that is no number, has another dimension, or is out of range.
        """
        text = text.strip()
        if self.optional and not text:
            return None
        if self.whole and text.isdecimal() and len(text) < 9:
            return int(text)
        return bounded(f"{text} {self.unit}".strip() if is_number(text) else text, *MEASURES[self.place], bare=False)

    def shown(self, value: float | None) -> str:
        """Return an SI value as displayed in the field."""
        return "" if value is None else f"{value / self.factor:.6g}"


def of(name: str, *beams: Beam, load: str = "twisting") -> Field:
    """Return a field as displayed for beams: a twist or bend in degrees, of the whole beam or per pitch."""
    field = FIELDS[name]
    if name not in TURNS:
        return field
    factor, unit = degrees(*beams)
    whole = over(beams[0]) if unit == "deg" else ""
    kind = LOADS[load if name == "twist" else "bending"]
    words = kind.verb.capitalize() if name == "twist" else field.label
    low, high = (float(f"{factor * limit:.2g}") for limit in (field.low, field.high))
    symbol = f"N{kind.letter}" if whole else kind.letter
    return field._replace(label=f"{words}{whole}", symbol=symbol, unit=unit, low=low, high=high, turn=factor)


def turn(name: str, text: str, beam: Beam, load: str) -> float:
    """Return the twist or bend (rad per pitch) of an entry: "300", "20 deg/pitch", "5 rad/m", "90 deg total".

    A number, or an angle without a length, has the meaning of the field: of the whole beam, or per pitch of an endless
    beam. Raises InputError for an entry that is no twist or bend, or out of range.
    """
    kind = LOADS[load if name == "twist" else "bending"]
    given = f"{text} deg" if is_number(text) else text
    size = {"pitch": beam.pitch, "scales": beam.pitches}
    try:
        angle = beam.pitch * kind.read(given, **size, bare=False)
    except NoLengthError:
        angle = beam.pitch * kind.read(f"{given}{' total' if beam.scales else '/pitch'}", **size, bare=False)
    return within(name, angle, text, beam, load)


def within(name: str, angle: float, text: str, beam: Beam, load: str) -> float:
    """Return a twist or bend (rad per pitch) that is in range; raises InputError with the entry ``text`` otherwise."""
    low, high = TURNS[name]
    if not low <= angle <= high:
        field = of(name, beam, load=load)
        example = number(float(f"{0.1 * field.turn:.1g}"), field.unit)
        allowed = field.allowed.partition(" (")[0]
        refuse("", shown(text), f"is out of range ({allowed})", f"write e.g. {example}")
    return angle


_RATIOS, _SIZES, _BAR, _LOAD = "Ratios", "Dimensions and angles", "Material and joint", "Loading"
_T_S = "t\N{LATIN SUBSCRIPT SMALL LETTER S}"
_NU, _SIGMA, _EPS = "\N{GREEK SMALL LETTER NU}", "\N{GREEK SMALL LETTER SIGMA}", "\N{GREEK SMALL LETTER EPSILON}"
_given = partial(Field, group=_BAR, optional=True)
FIELDS: dict[str, Field] = {
    "twist": Field("Twist", "φ", "rad/pitch", 0, 1, "twist", _LOAD, turn=1.0),
    "bend": Field("Bend held", "ψ", "rad/pitch", -0.2, 0.2, "bend", _LOAD, turn=1.0),
    "mu": Field("Friction coefficient", "μ", "", 0, 2, "friction.mu", _LOAD),
    "margin": Field("Cut-off margin before a lock", "m", "", 1e-4, 0.5, "margin", _LOAD, log=True),
    "length": Field("Scale length, exposed", "l", "mm", 2, 200, "scale.length", _SIZES, log=True),
    "width": Field("Scale width", "2b", "mm", 2, 100, "scale.width", _SIZES, log=True),
    "embedded": Field("Embedded length", "L", "mm", 0, 30, "scale.embedded", _SIZES),
    "thickness": Field("Scale thickness", _T_S, "mm", 0.05, 5, "scale.thickness", _SIZES, log=True),
    "pitch": Field("Pitch", "d", "mm", 2, 100, "beam.pitch", _SIZES, log=True),
    "bar_width": Field("Substrate width", "w", "mm", 5, 150, "substrate.width", _SIZES, log=True),
    "bar_thickness": Field("Substrate thickness", "2t", "mm", 1, 80, "substrate.thickness", _SIZES, log=True),
    "scales": Field("Number of scales", "N", "", 2, 60, "beam.scales", _SIZES, whole=True),
    "alpha": Field("Angle of the scale width", "α", "deg", 1, 85, "scale.alpha", _SIZES),
    "theta0": Field("Inclination at rest", "θ\N{SUBSCRIPT ZERO}", "deg", 1, 45, "scale.theta0", _SIZES),
    "eta": Field("Overlap ratio l/d", "η", "", 0.5, 8, "eta", _RATIOS),
    "beta": Field("Half width over pitch b/d", "β", "", 0.1, 3, "beta", _RATIOS),
    "lam": Field("Half thickness over pitch t/d", "λ", "", 0.05, 2, "lam", _RATIOS),
    "zeta": Field("Embedded over pitch L/d", "ζ", "", 0.02, 1.5, "zeta", _RATIOS),
    "slenderness": Field("Slenderness of the tab", f"L/{_T_S}", "", 2, 80, "slenderness", _RATIOS),
    "modulus": Field("Young's modulus of the bar", "E_B", "MPa", 0.1, 3e4, "substrate.youngs_modulus", _BAR, log=True),
    "poisson": Field("Poisson's ratio of the bar", _NU, "", 0, 0.499, "substrate.poisson_ratio", _BAR),
    "scale_modulus": _given("Young's modulus of the scales", "E_s", "GPa", 0.01, 300, "scale.youngs_modulus", log=True),
    "scale_poisson": _given("Poisson's ratio of the scales", f"{_NU}_s", "", 0, 0.499, "scale.poisson_ratio"),
    "scale_strength": _given("Strength of the scales", f"{_SIGMA}_s", "MPa", 1, 3000, "scale.strength", log=True),
    "strength": _given("Strength of the bar", f"{_SIGMA}_B", "MPa", 0.1, 3000, "substrate.strength", log=True),
    "strain_limit": _given("Strain limit of the bar", f"{_EPS}_B", "", 0.001, 10, "substrate.strain_limit", log=True),
    "stiffness": _given("Joint stiffness", "K_θ", "N m", 1e-4, 1e4, "joint.stiffness", log=True),
    "inclusion": _given("Inclusion factor", "C_f", "", 1, 5, "joint.inclusion_factor"),
}
"""All numbers of the page, in its order."""
PLAIN = ("margin", "twist", "bend")
"""Numbers that do not belong to the beam."""
LABELS = {field.place: field.label for field in FIELDS.values() if "." in field.place}
"""Labels of the beam file's keys on the page."""
CHOICES: dict[str, tuple[str, dict[str, str]]] = {
    "load": ("Loading", {"twisting": "twisting", "bending": "bending towards the scales"}),
    "path": ("Load path", {"loading": "loading", "cycle": "loading and unloading", "decay": "loading, then let go"}),
    "law": ("Force law", {"edge": "edge law", "plate": "plate law (the paper's)"}),
    "sense": ("Twist sense", {"+": "+", "-": "-"}),
    "joint": ("Joint", {"compliant": "compliant (six motions)", "hinge": "hinge (the paper's)"}),
    "ideal": ("Scales", {"no": "thick, as they are made", "yes": "thin, rigid (the paper's)"}),
}
"""Choices of the page: label, and words for each value."""

MATERIALS: dict[str, tuple[str, tuple[str, float, str] | None]] = {
    "pla": ("PLA, 3 GPa", ("3 GPa", 0.35, "50 MPa")),
    "petg": ("PETG, 2.1 GPa", ("2.1 GPa", 0.38, "45 MPa")),
    "glass": ("glass laminate, 20 GPa", ("20 GPa", 0.13, "300 MPa")),
    "steel": ("spring steel, 200 GPa", ("200 GPa", 0.3, "1 GPa")),
    "rigid": ("rigid", None),
}
"""Typical materials of scales: words; Young's modulus, Poisson's ratio and strength, or None for rigid scales."""
OTHER = {"other": "by the numbers below"}
"""Entry of the list of materials for a beam with another material."""


def made_of(name: str) -> dict[str, str | float | None]:
    """Return the values of the beam file's table ``scale`` for a material."""
    values = MATERIALS[name][1] or (None, None, None)
    return dict(zip(("youngs_modulus", "poisson_ratio", "strength"), values, strict=True))


def material(scale: Scale) -> str:
    """Return the material of the list with the modulus and Poisson's ratio of a scale, else "other"."""
    for name in MATERIALS:
        modulus, ratio, _ = made_of(name).values()
        wanted = None if modulus is None else quantity(modulus, Dimension.PRESSURE)
        if scale.youngs_modulus == wanted and (wanted is None or scale.poisson_ratio == ratio):
            return name
    return "other"


def placed(beam: Beam, name: str, new: Any) -> tuple[str, Any]:
    """Return the key of the beam file that a field changes, and its value. A ratio changes a size, never the pitch."""
    d = beam.pitch
    sizes = {"eta": ("scale.length", d), "beta": ("scale.width", 2 * d)}
    sizes |= {"lam": ("substrate.thickness", 2 * d), "zeta": ("scale.embedded", d)}
    if name == "slenderness":
        return "scale.thickness", beam.scale.embedded / new
    place, unit = sizes.get(name, (FIELDS[name].place, 1))
    return place, new if new is None else new * unit

"""The parts of a scale-covered beam: frozen, validated data.

Inputs are checked at the door and stored in SI units (m, rad, Pa, N m). Numbers in Python are SI; text
carries its unit ("45 deg", "60 mm"). In a file a unit is always needed.
"""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, ClassVar, NoReturn

from pydantic import BaseModel, BeforeValidator, ConfigDict, ValidationError, ValidationInfo

from squama.beam import beamfile, joint_law, matrixfile
from squama.beam.ends import SHOWN, held_ends, number_of_scales
from squama.beam.faces import FACES, Other, read
from squama.errors import InputError, Problem, Problems
from squama.loads import NEUTRAL, NOTHING, STRAINS, hold, holding
from squama.model import reach, section
from squama.units import Bounds, Dimension, bounded, shown

Quantity = float | str
"""A number in SI units, or text with a unit."""

RATIO = Bounds(1e-9, 1e9, "more than 0; 1e-9 to 1e9", closed=True)
OVERLAP = Bounds(1e-9, reach.LARGEST, reach.ALLOWED, closed=True)
RATIOS = {
    "eta": OVERLAP._replace(example="3"),
    "beta": OVERLAP._replace(example="1.25"),
    "lam": RATIO._replace(example="0.45"),
    "zeta": RATIO._replace(example="0.35"),
    "slenderness": RATIO._replace(example="35"),
}
"""Bounds of the ratios on which the contact and the laws of the joint depend."""
_ALL_RATIOS = {**RATIOS, "modulus_ratio": RATIO._replace(example="2000")}
PLASTIC = 0.35
"""Poisson's ratio of scales for which only a modulus is given: typical of printed plastics."""


def _read(name: str) -> BeforeValidator:
    dimension, bounds = beamfile.NUMBERS[name]

    def read(value: object, info: ValidationInfo) -> float:
        return bounded(value, dimension, bounds, bare=(info.context or {}).get("bare", True))

    return BeforeValidator(read)


def read_ratios(given: Mapping[str, object]) -> dict[str, float]:
    """Return positive numbers without unit by name; refuse others with one line per mistake."""
    ratios: dict[str, float] = {}
    problems = Problems()
    for name, value in given.items():
        with problems.caught(name):
            ratios[name] = bounded(value, Dimension.RATIO, _ALL_RATIOS[name])
    problems.settle()
    return ratios


def read_matrix(value: object, info: ValidationInfo) -> matrixfile.StoredMatrix:
    """Return a joint's matrix from the name of its file (relative to the beam's file), its text, or a StoredMatrix."""
    if isinstance(value, matrixfile.StoredMatrix):
        return value
    if isinstance(value, str) and "\n" in value:
        return matrixfile.parse(value)
    folder = (info.context or {}).get("folder", "")
    if folder is None:
        # links, results and stores may come from a stranger, who must not learn which files exist
        reason = "names a file, which only a beam's own file can"
        raise InputError(Problem("", shown(value), reason, "read that file itself, or write the matrix out"))
    if isinstance(value, str | os.PathLike) and os.fspath(value):
        return matrixfile.read(Path(folder) / value)
    raise InputError(Problem("", shown(value), "is not the name of a file", 'write e.g. "joint.csv"'))


def _line(value: object) -> str:
    """Return the word for the line that keeps its length; refuse others."""
    if value in NEUTRAL:
        return str(value)
    raise InputError(Problem("", shown(value), f"must be {' or '.join(map(shown, NEUTRAL))}"))


Faces = Annotated[str, BeforeValidator(read)]
Hold = Annotated[str, BeforeValidator(lambda value: holding(hold(str(value))))]
Pitch = Annotated[float, _read("beam.pitch")]
Density = Annotated[float, _read("beam.density")]
Rotor = Annotated[float, _read("beam.rotor")]


class Part(BaseModel):
    """Base of the parts: frozen data whose mistakes raise an InputError with one line each."""

    model_config = ConfigDict(frozen=True, extra="forbid", arbitrary_types_allowed=True)
    _root: ClassVar[str | None] = None

    def __init__(self, /, **data: object) -> None:
        try:
            super().__init__(**data)
        except ValidationError as error:
            raise beamfile.explain(error, self._root) from None

    # this mark lets pydantic fill nested models itself, so that an error keeps its full path
    __init__.__pydantic_base_init__ = True  # type: ignore[attr-defined]

    def __setattr__(self, name: str, value: object) -> NoReturn:
        message = f"{type(self).__name__} is frozen; make a changed copy with beam.replace(...)"
        raise AttributeError(message)


class Scale(Part):
    """A scale: a rectangular plate, partly embedded. The model with hinges takes it as rigid and thin.

    Parameters
    ----------
    length : float or str
        Exposed length l, m.
    embedded : float or str
        Embedded length L, m; 0 or more.
    width : float or str
        Full width 2b, m.
    thickness : float or str
        Thickness t_s, m.
    alpha : float or str
        Angle between the cross-section and the scale's width, rad; 0 or more, below 90 deg.
    theta0 : float or str
        Inclination at rest, rad; 0 to 90 deg, exclusive.
    youngs_modulus : float or str, optional
        E_s, Pa; a scale without it is rigid.
    poisson_ratio : float, optional
        nu_s; -1 to 0.5, exclusive. With a modulus it is 0.35 (printed plastics) if not given.
    strength : float or str, optional
        Largest stress (von Mises), Pa.
    density : float or str, optional
        Density, kg/m^3; for vibration.

    Raises
    ------
    InputError
        A value that is missing, of the wrong dimension or out of range.
    """

    _root = "scale"
    length: Annotated[float, _read("scale.length")]
    embedded: Annotated[float, _read("scale.embedded")]
    width: Annotated[float, _read("scale.width")]
    thickness: Annotated[float, _read("scale.thickness")]
    alpha: Annotated[float, _read("scale.alpha")]
    theta0: Annotated[float, _read("scale.theta0")]
    youngs_modulus: Annotated[float, _read("scale.youngs_modulus")] | None = None
    poisson_ratio: Annotated[float, _read("scale.poisson_ratio")] | None = None
    strength: Annotated[float, _read("scale.strength")] | None = None
    density: Annotated[float, _read("scale.density")] | None = None

    if TYPE_CHECKING:

        def __init__(
            self,
            *,
            length: Quantity,
            embedded: Quantity,
            width: Quantity,
            thickness: Quantity,
            alpha: Quantity,
            theta0: Quantity,
            youngs_modulus: Quantity | None = None,
            poisson_ratio: Quantity | None = None,
            strength: Quantity | None = None,
            density: Quantity | None = None,
        ) -> None: ...

    @property
    def nu(self) -> float:
        """Poisson's ratio nu_s, as given or 0.35."""
        return PLASTIC if self.poisson_ratio is None else self.poisson_ratio


class Substrate(Part):
    """The bar under the scales: rectangular, elastic, isotropic.

    Parameters
    ----------
    width : float or str
        Width, m.
    thickness : float or str
        Full thickness 2t, m.
    youngs_modulus : float or str
        E_B, Pa.
    poisson_ratio : float
        nu; -1 to 0.5, exclusive.
    strength : float or str, optional
        Largest stress (von Mises), Pa.
    strain_limit : float, optional
        Largest strain; 2 means three times the length.
    neutral : str, optional
        Line that keeps its length: "middle", for compliant joints in twisting too (without it they have no axial
        force); or "face" (that of the scales), for hinges in bending (without it they take the middle).

    Raises
    ------
    InputError
        A value that is missing, of the wrong dimension or out of range.
    """

    _root = "substrate"
    width: Annotated[float, _read("substrate.width")]
    thickness: Annotated[float, _read("substrate.thickness")]
    youngs_modulus: Annotated[float, _read("substrate.youngs_modulus")]
    poisson_ratio: Annotated[float, _read("substrate.poisson_ratio")]
    strength: Annotated[float, _read("substrate.strength")] | None = None
    strain_limit: Annotated[float, _read("substrate.strain_limit")] | None = None
    neutral: Annotated[str, BeforeValidator(_line)] | None = None

    if TYPE_CHECKING:

        def __init__(
            self,
            *,
            width: Quantity,
            thickness: Quantity,
            youngs_modulus: Quantity,
            poisson_ratio: Quantity,
            strength: Quantity | None = None,
            strain_limit: Quantity | None = None,
            neutral: str | None = None,
        ) -> None: ...


class Joint(Part):
    """The elastic joint of a scale; values that are not given come from the laws of `squama.model.joint`.

    Parameters
    ----------
    stiffness : float or str, optional
        K_theta, N m (per rad); used in twisting and in bending.
    inclusion_factor : float, optional
        C_f; used in twisting and in bending.
    matrix : path or str, optional
        File with the stiffness matrix, as ``squama joint beam.toml --matrix joint.csv`` writes it, or the text of such
        a file; a name without a folder is relative to the beam's file. The model with compliant joints uses the matrix;
        in twisting it also supplies K_theta and C_f unless they are given.

    Raises
    ------
    InputError
        A value is out of range, or the file is no such matrix.
    """

    _root = "joint"
    stiffness: Annotated[float, _read("joint.stiffness")] | None = None
    inclusion_factor: Annotated[float, _read("joint.inclusion_factor")] | None = None
    matrix: Annotated[matrixfile.StoredMatrix, BeforeValidator(read_matrix)] | None = None

    if TYPE_CHECKING:

        def __init__(
            self,
            *,
            stiffness: Quantity | None = None,
            inclusion_factor: Quantity | None = None,
            matrix: str | os.PathLike[str] | matrixfile.StoredMatrix | None = None,
        ) -> None: ...


class Friction(Part):
    """Friction between the scales.

    Parameters
    ----------
    mu : float, optional
        Coefficient of friction (static = kinetic), 0 to 10; None if the file does not give it.
    """

    _root = "friction"
    mu: Annotated[float, _read("friction.mu")] | None = None

    if TYPE_CHECKING:

        def __init__(self, *, mu: Quantity | None = None) -> None: ...


class Assembly(Part):
    """The parts put together, with the derived ratios and stiffnesses: the data of a :class:`squama.Beam`."""

    scale: Scale
    substrate: Substrate
    pitch: Pitch
    scales: Annotated[int | None, BeforeValidator(number_of_scales)] = None
    ends: Annotated[str, BeforeValidator(held_ends)] | None = None
    faces: Faces = "one"
    hold: Hold | None = None
    joint: Joint = Joint()
    friction: Friction = Friction()
    density: Density | None = None
    rotor: Rotor | None = None

    @property
    def other(self) -> Other | None:
        """Symmetry of the scales on the other face; None for scales on one face."""
        return FACES[self.faces]

    @property
    def eta(self) -> float:
        """Overlap ratio l/d."""
        return self.scale.length / self.pitch

    @property
    def beta(self) -> float:
        """Half width of a scale over the pitch, b/d."""
        return self.scale.width / 2 / self.pitch

    @property
    def lam(self) -> float:
        """Half thickness of the substrate over the pitch, lambda = t/d."""
        return self.substrate.thickness / 2 / self.pitch

    @property
    def zeta(self) -> float:
        """Embedded length over the pitch, L/d."""
        return self.scale.embedded / self.pitch

    @property
    def slenderness(self) -> float:
        """Embedded length over the scale's thickness, L/t_s."""
        return self.scale.embedded / self.scale.thickness

    @property
    def thickness_ratio(self) -> float:
        """Thickness of a scale over the pitch, h = t_s/d."""
        return self.scale.thickness / self.pitch

    @property
    def modulus_ratio(self) -> float:
        """Modulus of the scales over that of the substrate, E_s/E_B; inf for rigid scales."""
        return (self.scale.youngs_modulus or math.inf) / self.substrate.youngs_modulus

    @property
    def unit_moment(self) -> float:
        """E d^3, N m: unit of moments in the model of thick scales, where E = 1 and d = 1."""
        return self.substrate.youngs_modulus * self.pitch**3

    @property
    def plate_rigidity(self) -> float:
        """Bending rigidity of a scale per width, D = E_s t_s^3/(12 (1 - nu_s^2)), N m; inf for a rigid scale."""
        s = self.scale
        return float(section.plate_rigidity(s.youngs_modulus or math.inf, s.thickness, s.nu))

    @property
    def ratios(self) -> dict[str, float]:
        """Ratios on which the contact depends (eta, beta, lam), and the angles alpha and theta0 in rad."""
        angles = {"alpha": self.scale.alpha, "theta0": self.scale.theta0}
        return {"eta": self.eta, "beta": self.beta, "lam": self.lam, **angles}

    @property
    def holding(self) -> str:
        """Held strains as the text of the beam file, "nothing" by default."""
        return self.hold or NOTHING

    @property
    def held(self) -> tuple[str, ...]:
        """Names of the strains that are held unless they are loaded, of :data:`squama.loads.STRAINS`."""
        # if the bar's middle line keeps its length, the stretch is held
        also = ("stretch",) if self.substrate.neutral == "middle" else ()
        return tuple(name for name in STRAINS if name in (*hold(self.holding), *also))

    @property
    def neutral(self) -> str:
        """Line of the bar that keeps its length in bending: "middle" or "face"."""
        return self.substrate.neutral or next(iter(NEUTRAL))

    @property
    def pitches(self) -> int:
        """Number of pitches for lengths, totals and pictures (N, or 25 for an endless beam)."""
        return self.scales or SHOWN

    @property
    def extent(self) -> str:
        """The pitches for lengths, totals and pictures in words: "25 scales", for an endless beam "25 pitches"."""
        return f"{self.pitches} {'pitches' if self.scales is None else 'scales'}"

    @property
    def length(self) -> float:
        """Length of the beam N d, m."""
        return self.pitches * self.pitch

    @property
    def G_B(self) -> float:
        """Shear modulus E_B / (2 (1 + nu)), Pa."""
        return section.shear_modulus(self.substrate.youngs_modulus, self.substrate.poisson_ratio)

    @property
    def J(self) -> float:
        """Saint-Venant torsion constant of the section, m^4; equals C_w I."""
        return float(section.torsion_constant(self.substrate.width, self.substrate.thickness))

    @property
    def I(self) -> float:  # noqa: E743 - the paper's symbol
        """Polar second moment of area of the section, m^4 (Eqs. 13-16)."""
        return section.polar_moment(self.substrate.width, self.substrate.thickness)

    @property
    def C_w(self) -> float:
        """Warping coefficient J / I."""
        return section.warping_coefficient(self.substrate.width, self.substrate.thickness)

    @property
    def C_f(self) -> float:
        """Inclusion factor in twisting, given, from the joint's matrix, or 1 + 1.33 zeta beta / lambda.

        Tabs in both faces add twice as much as those of one face, unless the factor is given.
        """
        return float(joint_law.inclusion("twisting", self.sizes, self.given))

    @property
    def bending_C_f(self) -> float:
        """Inclusion factor in bending, given or 1."""
        return float(joint_law.inclusion("bending", self.sizes, self.given))

    @property
    def sizes(self) -> joint_law.Sizes:
        """Arguments of the laws of joint and section, SI."""
        bar, scale = self.substrate, self.scale
        core = (bar.youngs_modulus, bar.poisson_ratio, bar.width, bar.thickness)
        plate = (scale.width / 2, scale.thickness, scale.embedded)
        return joint_law.Sizes(*core, self.pitch, *plate, self.beta, self.lam, self.zeta)

    @property
    def given(self) -> joint_law.Given:
        """Given data of the joint, with the held strains and the signs of the other face."""
        j = self.joint
        seen = self.other.seen if self.other else ()
        return joint_law.Given(j.stiffness, j.inclusion_factor, j.matrix, seen, self.held)

    @property
    def torsional_rigidity(self) -> float:
        """Torque over twist rate of the beam without contact, C_f J G_B, N m^2 (Eq. 14)."""
        return self.C_f * self.J * self.G_B

    @property
    def bending_rigidity(self) -> float:
        """Moment over curvature without contact, N m^2, E_B width (2t)^3 / 12 times the inclusion factor in bending."""
        return float(joint_law.rigidity("bending", self.sizes, self.given))

    @property
    def joint_stiffness(self) -> float:
        """K_theta of a scale, N m per rad, given, from the matrix, or 3.62 E_B t_s^2 b (L/t_s)^1.55."""
        return float(joint_law.stiffness(self.sizes, self.given))

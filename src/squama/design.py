"""A scale-covered beam, and what follows from its data.

Inputs are checked at the door and stored in SI units (m, rad, Pa, N m). Everything else is a property.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Self

from pydantic import BeforeValidator, ValidationError, model_validator

from squama import beamfile, files, joint_values, validity
from squama.errors import InputError
from squama.model import section
from squama.parts import Friction, Joint, Part, Pitch, Quantity, Scale, Substrate, read_ratios, whole

__all__ = ["Beam", "Friction", "Joint", "Scale", "Substrate"]


class Beam(Part):
    """A beam with N equal scales at equal distances.

    Parameters
    ----------
    scale, substrate : Scale, Substrate
        What it is made of.
    pitch : float or str
        Distance d between two scales, m.
    scales : int
        Number N of scales, at least 2; the beam is N d long.
    joint, friction : Joint, Friction
        Optional.

    Raises
    ------
    InputError
        One line per mistake; also if eta or beta is above 100, or the embedded tab would come out of the
        substrate's other face.
    """

    scale: Scale
    substrate: Substrate
    pitch: Pitch
    scales: Annotated[int, BeforeValidator(whole)] = 25
    joint: Joint = Joint()
    friction: Friction = Friction()

    if TYPE_CHECKING:

        def __init__(
            self,
            *,
            scale: Scale | Mapping[str, Any],
            substrate: Substrate | Mapping[str, Any],
            pitch: Quantity,
            scales: int = 25,
            joint: Joint | Mapping[str, Any] = ...,
            friction: Friction | Mapping[str, Any] = ...,
        ) -> None: ...

    @model_validator(mode="after")
    def _parts_fit(self) -> Self:
        if problems := [*validity.reach_problems(self), *validity.tab_problems(self)]:
            raise InputError("\n".join(problems))
        return self

    @classmethod
    def from_toml(
        cls, path: str | os.PathLike[str], *, overrides: Mapping[str, Mapping[str, Any]] | None = None
    ) -> Self:
        """Read a beam from a TOML file; every dimensional value in it needs its unit.

        Parameters
        ----------
        path : path
            The file, at most 1 MB of UTF-8.
        overrides : mapping, optional
            Values that replace those of the file, by table and key, e.g. ``{"scale": {"alpha": "30 deg"}}``.
            They too need their units.

        Returns
        -------
        Beam

        Raises
        ------
        InputError
            The file or a value in it cannot be used: one line per mistake, each with the file's name.
        """
        text = files.read_text(path, missing=f"write an example with: squama new {files.label(path)}")
        return cls.from_toml_text(text, source=files.label(path), overrides=overrides, folder=Path(path).parent)

    @classmethod
    def from_toml_text(
        cls,
        text: str,
        *,
        source: str = "beam",
        overrides: Mapping[str, Mapping[str, Any]] | None = None,
        folder: str | os.PathLike[str] = "",
    ) -> Self:
        """Read a beam from the text of a file: its name in messages is `source`, other files are in `folder`."""
        try:
            arguments, problems = beamfile.parse(text)
        except InputError as error:
            message = f"{source}: {error}"
            raise InputError(message) from None
        if overrides:
            arguments = beamfile.merge(arguments, overrides)
        return cls._build(arguments, problems, source=f"{source}: ", bare=False, folder=folder)

    @classmethod
    def from_ratios(
        cls,
        *,
        eta: float = 3,
        beta: float = 1.25,
        lam: float = 0.45,
        zeta: float = 0.35,
        slenderness: float = 35,
        alpha: Quantity = "45 deg",
        theta0: Quantity = "10 deg",
        width: Quantity = "32 mm",
        thickness: Quantity = "16 mm",
        youngs_modulus: Quantity = "25 GPa",
        poisson_ratio: Quantity = 0.25,
        scales: int = 25,
        mu: Quantity | None = None,
        stiffness: Quantity | None = None,
        inclusion_factor: Quantity | None = None,
    ) -> Self:
        """Make a beam from the paper's ratios; the defaults are those of its Figs. 4, 5, 6a and 7.

        Parameters
        ----------
        eta, beta, lam, zeta : float
            l/d, b/d, t/d and L/d; positive. The thickness 2t fixes the pitch, d = t / lam.
        slenderness : float
            L/t_s; positive.
        alpha, theta0 : float or str
            Angles of the scales, rad.
        width, thickness : float or str
            Section of the substrate, m; the thickness is 2t.
        youngs_modulus, poisson_ratio : float or str
            E_B, Pa, and nu.
        scales : int
            N.
        mu, stiffness, inclusion_factor : float or str, optional
            As in `Friction` and `Joint`.

        Returns
        -------
        Beam

        Raises
        ------
        InputError
            One line per mistake.
        """
        r = read_ratios({"eta": eta, "beta": beta, "lam": lam, "zeta": zeta, "slenderness": slenderness})
        substrate = Substrate(
            width=width, thickness=thickness, youngs_modulus=youngs_modulus, poisson_ratio=poisson_ratio
        )
        d = substrate.thickness / 2 / r["lam"]
        embedded = r["zeta"] * d
        sizes = {"length": r["eta"] * d, "embedded": embedded, "width": 2 * r["beta"] * d}
        return cls(
            scale={**sizes, "thickness": embedded / r["slenderness"], "alpha": alpha, "theta0": theta0},
            substrate=substrate,
            pitch=d,
            scales=scales,
            joint={"stiffness": stiffness, "inclusion_factor": inclusion_factor},
            friction={"mu": mu},
        )

    def replace(self, **changes: Any) -> Self:
        """Return a changed copy, validated again.

        Parameters
        ----------
        **changes
            Fields of the beam; a mapping changes single values of a part, e.g. ``scale={"alpha": "30 deg"}``.

        Returns
        -------
        Beam

        Raises
        ------
        InputError
            One line per mistake.
        """
        data = self.model_dump()
        for name, value in changes.items():
            old = data.get(name)
            data[name] = {**old, **value} if isinstance(old, dict) and isinstance(value, Mapping) else value
        return self._build(data)

    @classmethod
    def _build(
        cls,
        data: Mapping[str, Any],
        problems: Sequence[str] = (),
        *,
        source: str = "",
        bare: bool = True,
        folder: str | os.PathLike[str] = "",
    ) -> Self:
        """Validate nested data; put the source before every line of what is wrong."""
        lines = list(problems)
        try:
            beam = cls.model_validate(data, context={"bare": bare, "folder": folder})
            if not lines:
                return beam
        except ValidationError as error:
            lines = beamfile.explain(error.errors(include_url=False), None, problems)
        raise InputError("\n".join(source + line for line in lines))

    def to_toml(self, path: str | os.PathLike[str] | None = None) -> str:
        """Return the beam as the text of a beam file, and write that file if a path is given.

        Parameters
        ----------
        path : path, optional
            Where to write; the file is complete or not there at all.

        Returns
        -------
        str
            TOML that `from_toml` reads back to an equal beam, to the last bit.

        Raises
        ------
        InputError
            The file cannot be written.
        """
        tables = self.model_dump(include={"scale", "substrate", "joint", "friction"})
        # the matrix itself, so that the text says all wherever it goes
        matrix = self.joint.matrix
        tables["joint"]["matrix"] = None if matrix is None else matrix.text
        text = beamfile.write({**tables, "beam": {"pitch": self.pitch, "scales": self.scales}})
        if path is not None:
            files.atomic_write(path, lambda place: place.write_text(text, encoding="utf-8"))
        return text

    def warnings(self, load: str = "twisting", sense: str = "+") -> list[str]:
        """Say where the beam leaves the range of the model under a load ("twisting" or "bending") in a sense.

        Returns
        -------
        list of str
            One line per finding; empty if there is none. See `squama.validity`.
        """
        return validity.messages(self, load, sense)

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
    def ratios(self) -> dict[str, float]:
        """What the contact depends on: eta, beta, lam, and alpha, theta0 in rad."""
        return {
            "eta": self.eta,
            "beta": self.beta,
            "lam": self.lam,
            "alpha": self.scale.alpha,
            "theta0": self.scale.theta0,
        }

    @property
    def length(self) -> float:
        """Length of the beam N d, m."""
        return self.scales * self.pitch

    @property
    def G_B(self) -> float:
        """Shear modulus E_B / (2 (1 + nu)), Pa."""
        return section.shear_modulus(self.substrate.youngs_modulus, self.substrate.poisson_ratio)

    @property
    def J(self) -> float:
        """Saint-Venant torsion constant of the section, m^4; equals C_w I."""
        return section.torsion_constant(self.substrate.width, self.substrate.thickness)

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
        """Inclusion factor in twisting: as given, from the joint's matrix, or 1 + 1.33 zeta beta / lambda."""
        return joint_values.inclusion(self, "twisting")

    @property
    def torsional_rigidity(self) -> float:
        """C_f J G_B, N m^2: the torque of the beam without contact per twist rate (Eq. 14)."""
        return self.C_f * self.J * self.G_B

    @property
    def bending_rigidity(self) -> float:
        """E_B width (2t)^3 / 12, N m^2, times the inclusion factor if that is given (docs, theory: bending)."""
        area = section.bending_moment_of_area(self.substrate.width, self.substrate.thickness)
        return joint_values.inclusion(self, "bending") * self.substrate.youngs_modulus * area

    @property
    def joint_stiffness(self) -> float:
        """K_theta of one scale in twisting, N m: given, from the joint's matrix, or 3.62 E_B t_s^2 b (L/t_s)^1.55."""
        return joint_values.stiffness(self, "twisting")

    @property
    def bending_joint_stiffness(self) -> float:
        """K of one scale in bending, N m: as given, or 0.66 E_B w t_s^2 (L/t_s)^1.75 with w = 2b."""
        return joint_values.stiffness(self, "bending")

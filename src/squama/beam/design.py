"""The beam: its data in SI units, reading and writing of its file, and warnings outside the model's range.

Inputs are checked at the door and stored in SI units (m, rad, Pa, N m). Everything else is a property.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Self

from pydantic import ValidationError, model_validator

from squama.beam import beamfile, card, validity
from squama.beam.faces import FacesName
from squama.beam.parts import Assembly, Friction, Joint, Quantity, Scale, Substrate, read_ratios
from squama.errors import Problem, Problems, naming
from squama.io import files
from squama.loads import EndsName
from squama.progress import LOG

__all__ = ["Beam", "Friction", "Joint", "Scale", "Substrate"]


class Beam(Assembly):
    """A scale-covered beam with N equal scales at equal distances, or endless.

    Parameters
    ----------
    scale, substrate : Scale, Substrate
        The scales and the bar under them.
    pitch : float or str
        Distance d between two scales, m.
    scales : int or str, optional
        Number N of scales (of a face), at least 2; the beam is N d long. Without it, or with "endless", the beam is the
        paper's, in which all pitches are alike; its lengths, totals and pictures are for 25 pitches.
    ends : str, optional
        Ends of a beam with a number of scales: "free" (default; the same torque or moment in all cells), "couple" (a
        couple at both ends, which may shift and tilt) or "gripped" (both ends stay on one axis, as in a torsion
        tester).
    faces : str
        "one": scales on one face. On both faces: "mirrored" (in the bar's middle plane, as in armour) or "turned" (by
        half a turn about the beam's axis); "mirrored, shifted" and "turned, shifted" by half a pitch. See
        `squama.beam.faces`.
    hold : str, optional
        Strains of the bar held by a guide or grip: some of "bend", "twist", "lateral bend", "stretch" ("bend,
        stretch"), "straight" for all that are not loaded, or "nothing" (default). A strain that is neither loaded nor
        held is free, with no moment or force: a twisted beam bows, a bent beam twists. For compliant joints; a beam on
        hinges is always held straight.
    joint, friction : Joint, Friction
        Optional; see there for the defaults.
    density, rotor : float or str, optional
        Density of the bar, kg/m^3, and moment of inertia of a rotor at its end, kg m^2; for vibration.

    Raises
    ------
    InputError
        One line per mistake; also if eta or beta is above 100, the embedded tab would come out of the substrate's
        other face, or the scales are softer than their joint by a factor of a million.
    """

    if TYPE_CHECKING:

        def __init__(
            self,
            *,
            scale: Scale | Mapping[str, object],
            substrate: Substrate | Mapping[str, object],
            pitch: Quantity,
            scales: int | str | None = None,
            ends: EndsName | None = None,
            faces: FacesName = "one",
            hold: str | None = None,
            joint: Joint | Mapping[str, object] = ...,
            friction: Friction | Mapping[str, object] = ...,
            density: Quantity | None = None,
            rotor: Quantity | None = None,
        ) -> None: ...

    @model_validator(mode="after")
    def _parts_fit(self) -> Self:
        validity.parts_fit(self)
        return self

    @classmethod
    def from_toml(
        cls, path: str | os.PathLike[str], *, overrides: Mapping[str, Mapping[str, object]] | None = None
    ) -> Self:
        """Read a beam from a TOML file, in which every dimensional value has a unit.

        Parameters
        ----------
        path : path
            The file, at most 1 MB of UTF-8.
        overrides : mapping, optional
            Values that replace those of the file, by table and key, e.g. ``{"scale": {"alpha": "30 deg"}}``; with units
            too.

        Returns
        -------
        Beam
            The beam alone; a line of the log names sections of a part under load, which `squama.Part` reads.

        Raises
        ------
        InputError
            The file or a value in it cannot be used: one line per mistake, each with the file's name.
        """
        name, text = beamfile.read(path)
        found = cls.from_toml_text(text, source=name, overrides=overrides, folder=files.folder_of(path))
        if part := beamfile.beside_the_beam(text):
            LOG.warning(
                "squama: %s: the beam alone is read, without %s; for these: squama load, squama.Part", name, part
            )
        return found

    @classmethod
    def from_toml_text(
        cls,
        text: str,
        *,
        source: str = "beam",
        overrides: Mapping[str, Mapping[str, object]] | None = None,
        folder: str | os.PathLike[str] | None = None,
    ) -> Self:
        """Read a beam from the text of a file, with `source` as its name in messages.

        Names of other files in the text are relative to `folder`. Without a folder the text must name no file; links,
        results and stores are read that way.
        """
        with naming(source=source):
            arguments, problems = beamfile.parse(text)
        if overrides:
            arguments = beamfile.merge(arguments, overrides)
        return cls._build(arguments, problems, source=source, bare=False, folder=folder)

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
        scales: int | str | None = None,
        mu: Quantity | None = None,
        stiffness: Quantity | None = None,
        inclusion_factor: Quantity | None = None,
        modulus_ratio: float | None = None,
        scale_poisson_ratio: Quantity | None = None,
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
        scales : int or str, optional
            N; an endless beam without it.
        mu, stiffness, inclusion_factor : float or str, optional
            As in `Friction` and `Joint`.
        modulus_ratio, scale_poisson_ratio : float, optional
            E_s/E_B, positive, and nu_s; rigid scales without the first.

        Returns
        -------
        Beam

        Raises
        ------
        InputError
            One line per mistake.
        """
        given = {"eta": eta, "beta": beta, "lam": lam, "zeta": zeta, "slenderness": slenderness}
        r = read_ratios(given if modulus_ratio is None else {**given, "modulus_ratio": modulus_ratio})
        substrate = Substrate(
            width=width, thickness=thickness, youngs_modulus=youngs_modulus, poisson_ratio=poisson_ratio
        )
        d = substrate.thickness / 2 / r["lam"]
        embedded = r["zeta"] * d
        sizes = {"length": r["eta"] * d, "embedded": embedded, "width": 2 * r["beta"] * d}
        sizes |= {"thickness": embedded / r["slenderness"]}
        modulus = None if modulus_ratio is None else r["modulus_ratio"] * substrate.youngs_modulus
        elastic = {"youngs_modulus": modulus, "poisson_ratio": scale_poisson_ratio}
        return cls(
            scale={**sizes, "alpha": alpha, "theta0": theta0, **elastic},
            substrate=substrate,
            pitch=d,
            scales=scales,
            joint={"stiffness": stiffness, "inclusion_factor": inclusion_factor},
            friction={"mu": mu},
        )

    def replace(self, **changes: object) -> Self:
        """Return a changed copy of the beam, validated again.

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
        return self._build(data, folder="")

    def _with(self, values: Mapping[str, float | None]) -> Self:
        """Return a copy with some values replaced, by "table.key" as in the beam file, such as "scale.length"."""
        tables: dict[str, dict[str, float | None]] = {}
        for name, value in values.items():
            table, _, key = name.partition(".")
            tables.setdefault(table, {})[key] = value
        return self._build(beamfile.merge(self.model_dump(), tables))

    @classmethod
    def _build(
        cls,
        data: Mapping[str, object],
        problems: Iterable[Problem] = (),
        *,
        source: str = "",
        bare: bool = True,
        folder: str | os.PathLike[str] | None = None,
    ) -> Self:
        """Validate nested data; errors get the source in front. With ``folder`` None the data must name no file."""
        found = Problems(problems)
        with naming(source=source):
            try:
                beam = cls.model_validate(data, context={"bare": bare, "folder": folder})
            except ValidationError as error:
                raise beamfile.explain(error, None, found) from None
            found.settle()
            return beam

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
        # the matrix itself, so that the text is complete without other files
        matrix = self.joint.matrix
        tables["joint"]["matrix"] = None if matrix is None else matrix.text
        own = {name: getattr(self, name) for name in beamfile.TABLES["beam"]}
        own["faces"] = self.faces if self.other else None
        text = beamfile.write({**tables, "beam": own})
        if path is not None:
            files.atomic_write(path, lambda place: place.write_text(text, encoding="utf-8"))
        return text

    def warnings(self, load: str = "twisting", sense: str = "+", joint: str = "hinge") -> list[str]:
        """Return where the beam leaves the range of a joint's model, under a load ("twisting" or "bending") and sense.

        Returns
        -------
        list of str
            One line per finding; empty if there is none. See `squama.beam.validity`.
        """
        return validity.messages(self, load, sense, joint)

    def _repr_html_(self) -> str:
        """Return the beam's HTML card for notebooks."""
        return card.of_beam(self, self.warnings(joint="compliant"))

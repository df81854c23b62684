"""The parts of a scale-covered beam: frozen, validated data.

Inputs are checked at the door and stored in SI units (m, rad, Pa, N m). Numbers in Python are SI; text
carries its unit ("45 deg", "60 mm"). In a file a unit is always needed.
"""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from numbers import Integral
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, NoReturn

from pydantic import BaseModel, BeforeValidator, ConfigDict, ValidationError, ValidationInfo

from squama import beamfile, matrixfile
from squama.errors import InputError
from squama.model import reach
from squama.units import Bounds, Dimension, QuantityError, bounded, shown

Quantity = float | str
"""A number in SI units, or text with a unit."""

SIZE = Bounds(1e-9, 1e6, "more than 0; 1 nm to 1000 km", closed=True)
DEPTH = Bounds(0.0, 1e6, "0 or more, up to 1000 km", closed=True)
QUARTER = Bounds(0.0, math.pi / 2, "0 to 90 deg, exclusive")
MODULUS = Bounds(1e-6, 1e15, "more than 0; 1e-6 Pa to 1e15 Pa", closed=True)
POISSON = Bounds(-1.0, 0.5, "-1 to 0.5, exclusive")
STIFFNESS = Bounds(1e-18, 1e15, "more than 0; 1e-18 N m to 1e15 N m", closed=True)
FACTOR = Bounds(1e-3, 1e3, "more than 0; 0.001 to 1000", closed=True)
FRICTION = Bounds(0.0, 10.0, "0 to 10", closed=True)
RATIO = Bounds(1e-9, 1e9, "more than 0; 1e-9 to 1e9", closed=True)
OVERLAP = Bounds(1e-9, reach.LARGEST, reach.ALLOWED, closed=True)
RATIOS = {
    "eta": OVERLAP._replace(example="3"),
    "beta": OVERLAP._replace(example="1.25"),
    "lam": RATIO._replace(example="0.45"),
    "zeta": RATIO._replace(example="0.35"),
    "slenderness": RATIO._replace(example="35"),
}
"""Bounds of the ratios."""


def own(table: str, key: str, bounds: Bounds) -> Bounds:
    """Return bounds whose example is that of a key of the beam file."""
    return bounds._replace(example=beamfile.TABLES[table][key].example)


def _read(table: str, key: str, bounds: Bounds) -> BeforeValidator:
    dimension = beamfile.TABLES[table][key].dimension
    assert dimension is not None
    bounds = own(table, key, bounds)

    def read(value: object, info: ValidationInfo) -> float:
        return bounded(value, dimension, bounds, bare=(info.context or {}).get("bare", True))

    return BeforeValidator(read)


def whole(value: object) -> int:
    """Return a number of scales, or refuse what is not a whole number of 2 or more."""
    if isinstance(value, Integral) and 2 <= int(value) <= 1_000_000:
        return int(value)
    text = repr(value) if isinstance(value, float) else shown(value)
    raise QuantityError(text, "is not a whole number from 2 to 1000000; write e.g. 25")


def read_ratios(given: Mapping[str, object]) -> dict[str, float]:
    """Return positive plain numbers by name, or refuse them with one line per mistake."""
    ratios: dict[str, float] = {}
    problems = []
    for name, value in given.items():
        try:
            ratios[name] = bounded(value, Dimension.RATIO, RATIOS[name])
        except QuantityError as error:
            problems.append(f"{name} = {error.shown}: {error.reason}")
    if problems:
        raise InputError("\n".join(problems))
    return ratios


def read_matrix(value: object, info: ValidationInfo) -> matrixfile.StoredMatrix:
    """Return the matrix of a joint from its file's name (beside the beam's file), from the file's text, or itself."""
    if isinstance(value, matrixfile.StoredMatrix):
        return value
    try:
        if isinstance(value, str) and "\n" in value:
            return matrixfile.parse(value)
        if isinstance(value, str | os.PathLike) and os.fspath(value):
            return matrixfile.read(Path((info.context or {}).get("folder", "")) / value)
    except InputError as error:
        message = f"joint.matrix: {error}"
        raise InputError(message) from None
    raise QuantityError(shown(value), 'is not the name of a file; write e.g. "joint.csv"')


Pitch = Annotated[float, _read("beam", "pitch", SIZE)]


class Part(BaseModel):
    """Frozen data whose every mistake is an InputError with one line per mistake."""

    model_config = ConfigDict(frozen=True, extra="forbid", arbitrary_types_allowed=True)
    _root: ClassVar[str | None] = None

    def __init__(self, /, **data: Any) -> None:
        try:
            super().__init__(**data)
        except ValidationError as error:
            lines = beamfile.explain(error.errors(include_url=False), self._root)
            raise InputError("\n".join(lines)) from None

    # this mark lets pydantic fill nested models itself, so that a mistake keeps its full path
    __init__.__pydantic_base_init__ = True  # type: ignore[attr-defined]

    def __setattr__(self, name: str, value: object) -> NoReturn:
        message = f"{type(self).__name__} is frozen; make a changed copy with beam.replace(...)"
        raise AttributeError(message)


class Scale(Part):
    """One scale: a rigid rectangular plate, partly embedded.

    Parameters
    ----------
    length : float or str
        Exposed length l, m.
    embedded : float or str
        Embedded length L, m; 0 or more.
    width : float or str
        Full width 2b, m.
    thickness : float or str
        Thickness t_s, m; it enters the joint's stiffness only.
    alpha : float or str
        Angle between the cross-section and the scale's width, rad; 0 to 90 deg, exclusive.
    theta0 : float or str
        Inclination at rest, rad; 0 to 90 deg, exclusive.

    Raises
    ------
    InputError
        A value that is missing, of the wrong dimension or out of range.
    """

    _root = "scale"
    length: Annotated[float, _read("scale", "length", SIZE)]
    embedded: Annotated[float, _read("scale", "embedded", DEPTH)]
    width: Annotated[float, _read("scale", "width", SIZE)]
    thickness: Annotated[float, _read("scale", "thickness", SIZE)]
    alpha: Annotated[float, _read("scale", "alpha", QUARTER)]
    theta0: Annotated[float, _read("scale", "theta0", QUARTER)]

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
        ) -> None: ...


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

    Raises
    ------
    InputError
        A value that is missing, of the wrong dimension or out of range.
    """

    _root = "substrate"
    width: Annotated[float, _read("substrate", "width", SIZE)]
    thickness: Annotated[float, _read("substrate", "thickness", SIZE)]
    youngs_modulus: Annotated[float, _read("substrate", "youngs_modulus", MODULUS)]
    poisson_ratio: Annotated[float, _read("substrate", "poisson_ratio", POISSON)]

    if TYPE_CHECKING:

        def __init__(
            self, *, width: Quantity, thickness: Quantity, youngs_modulus: Quantity, poisson_ratio: Quantity
        ) -> None: ...


class Joint(Part):
    """The elastic joint of a scale; what is not given comes from the laws of `squama.model.joint`.

    Parameters
    ----------
    stiffness : float or str, optional
        K_theta, N m (per rad); used in twisting and in bending.
    inclusion_factor : float, optional
        C_f; used in twisting and in bending.
    matrix : path or str, optional
        File of the stiffness in all motions and in twist, as ``squama joint beam.toml --matrix joint.csv`` writes it; a
        name without a folder is looked for beside the beam's file. The compliant joint uses it, and in twisting K_theta
        and C_f come from it where they are not given. The text of such a file does too.

    Raises
    ------
    InputError
        A value is out of range, or the file is no such matrix.
    """

    _root = "joint"
    stiffness: Annotated[float, _read("joint", "stiffness", STIFFNESS)] | None = None
    inclusion_factor: Annotated[float, _read("joint", "inclusion_factor", FACTOR)] | None = None
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
    mu: Annotated[float, _read("friction", "mu", FRICTION)] | None = None

    if TYPE_CHECKING:

        def __init__(self, *, mu: Quantity | None = None) -> None: ...

"""From swept values to the columns of many designs: what :class:`squama.Beam` says of one, for arrays.

Every array is an open mesh: it spans only the dimensions that it depends on, so the laws of joint and section are
evaluated once for each combination that they see.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from squama.design import Beam
from squama.errors import InputError
from squama.model import joint, section
from squama.model.solve import Array
from squama.study.parameters import Axis, text_of

Each = Callable[..., Array]


class Cells(NamedTuple):
    """What the response of each cell depends on; SI units, radians, arrays that broadcast against each other.

    ``K`` stiffness of a joint, ``d`` pitch, ``rigidity`` of the beam without contact; the rest are sizes and ratios.
    """

    eta: Array
    beta: Array
    lam: Array
    alpha: Array
    theta0: Array
    mu: Array
    K: Array
    d: Array
    rigidity: Array
    sizes: dict[str, dict[str, Array]]

    @property
    def ratio(self) -> Array:
        """Rigidity over K d; 0 where the joint has no stiffness."""
        soft = self.K * self.d
        return np.asarray(np.where(soft > 0, self.rigidity / np.where(soft > 0, soft, 1.0), 0.0))


def cells(beam: Beam, load: str, values: Mapping[str, Any], *, each: Each | None = None) -> Cells:
    """Return the designs of a beam with some parameters replaced.

    Parameters
    ----------
    beam : Beam
        The beam.
    load : {"twisting", "bending"}
        Which laws of joint and section apply.
    values : mapping
        Numbers or arrays by the names of :data:`squama.study.parameters.PARAMETERS`, SI units; with `each` also
        complex ones.
    each : callable, optional
        Evaluates a law for arrays; one element after the other by default, to the last bit as :class:`squama.Beam`.

    Returns
    -------
    Cells
    """
    each = _each if each is None else each
    scale, bar = beam.scale, beam.substrate

    def v(name: str, otherwise: Any) -> Any:
        return _numbers(values.get(name, otherwise))

    pitch, t = v("beam.pitch", beam.pitch), v("substrate.thickness", bar.thickness) / 2
    embedded, thickness = v("scale.embedded", scale.embedded), v("scale.thickness", scale.thickness)
    width = v("scale.width", scale.width)
    eta, beta = v("eta", v("scale.length", scale.length) / pitch), v("beta", width / 2 / pitch)
    lam, zeta = v("lam", t / pitch), v("zeta", embedded / pitch)
    slenderness = v("slenderness", embedded / thickness)
    # a ratio that is not swept stays, whatever lam does to the pitch
    d = t / lam if "lam" in values else pitch
    if {"zeta", "lam"} & set(values):
        embedded = zeta * d
    if {"zeta", "lam", "slenderness"} & set(values):
        with np.errstate(all="ignore"):
            thickness = np.where(slenderness > 0, embedded / slenderness, thickness * d / pitch)
    half = beta * d if {"beta", "lam"} & set(values) else width / 2
    E, nu = v("substrate.youngs_modulus", bar.youngs_modulus), v("substrate.poisson_ratio", bar.poisson_ratio)
    across = v("substrate.width", bar.width)
    if "joint.stiffness" in values or beam.joint.stiffness is not None:
        K = v("joint.stiffness", beam.joint.stiffness)
    else:
        K = each(
            joint.LAWS[f"stiffness {load}"].value, E, thickness, half if load == "twisting" else 2 * half, embedded
        )
    if "joint.inclusion_factor" in values or beam.joint.inclusion_factor is not None:
        C = v("joint.inclusion_factor", beam.joint.inclusion_factor)
    else:
        C = each(joint.LAWS[f"inclusion {load}"].value, zeta, beta, lam)
    if load == "twisting":
        rigidity = C * each(section.torsion_constant, across, 2 * t) * section.shear_modulus(E, nu)
    else:
        rigidity = C * E * section.bending_moment_of_area(across, 2 * t)
    alpha, theta0 = v("alpha", scale.alpha), v("theta0", scale.theta0)
    sizes: dict[str, dict[str, Array]] = {
        "scale": {
            "length": eta * d,
            "embedded": embedded,
            "width": 2 * half,
            "thickness": thickness,
            "alpha": alpha,
            "theta0": theta0,
        },
        "substrate": {"width": across, "thickness": 2 * t, "youngs_modulus": E, "poisson_ratio": nu},
    }
    mu = v("mu", 0.0 if beam.friction.mu is None else beam.friction.mu)
    return Cells(eta, beta, lam, alpha, theta0, mu, K, d, rigidity, sizes)


def _numbers(value: Any) -> Array:
    """Return an array of floats; complex numbers stay."""
    array = np.asarray(value)
    return array if np.iscomplexobj(array) else array.astype(float)


def _each(law: Callable[..., float], *arguments: Array) -> Array:
    """Evaluate a law of plain numbers for arrays."""
    return np.asarray(np.frompyfunc(law, len(arguments), 1)(*arguments), float)


def check(beam: Beam, load: str, swept: Sequence[Axis]) -> None:
    """Refuse a sweep some of whose cells are no valid beam.

    Every size of a cell, and the depth of its tab, grows or falls with each parameter, so the corners of the grid
    are the worst cells: each is built as a :class:`squama.Beam`, with all its checks.

    Raises
    ------
    InputError
        One line: the ranges, the corner, and what is wrong there.
    """
    named = [axis for axis in swept if axis.name not in ("mu", "margin")]
    for corner in itertools.product(*((float(a.values[0]), float(a.values[-1])) for a in named)):
        here = {axis.name: value for axis, value in zip(named, corner, strict=True)}
        try:
            beam_at(beam, load, here)
        except InputError as error:
            ranges = ", ".join(axis.span for axis in named)
            at = ", ".join(f"{name} = {text_of(name, value)}" for name, value in here.items())
            what = "; ".join(str(error).splitlines())
            message = f"{ranges}: some cells are no valid beam; at {at}: {what}"
            raise InputError(message) from None


def beam_at(beam: Beam, load: str, values: Mapping[str, float]) -> Beam:
    """Return the beam of one cell, validated; ``margin`` is left out."""
    c = cells(beam, load, values)
    parts = {table: {key: float(value) for key, value in content.items()} for table, content in c.sizes.items()}
    changes: dict[str, Any] = {**parts, "pitch": float(c.d)}
    for table, key in (("joint", "stiffness"), ("joint", "inclusion_factor")):
        if f"{table}.{key}" in values:
            changes.setdefault(table, {})[key] = values[f"{table}.{key}"]
    if "mu" in values:
        changes["friction"] = {"mu": values["mu"]}
    return beam.replace(**changes)

"""From a beam to its labelled response: the only file that knows the whole order."""

from __future__ import annotations

import functools
import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from squama import checks, units
from squama._version import __version__
from squama.answer import Answer, Labelled
from squama.curve import Case, Curve, curve, path
from squama.design import Beam
from squama.model import solution
from squama.model.plates import Plates, Touch
from squama.model.solve import Array
from squama.symbols import SYMBOLS

if TYPE_CHECKING:
    import xarray as xr


class Loading(NamedTuple):
    """Names of the variables of a kind of loading, by their roles in :mod:`squama.curve`."""

    kind: str
    along: dict[str, str]
    figures: dict[str, str]


_ALONG = {
    "theta": "theta",
    "N": "N",
    "f": "f",
    "f0": "f0",
    "mu_lock": "mu_lock",
    "elastic": "U_el",
    "work": "W_fr",
    "RED": "RED",
}
_FIGURES = {
    "theta_end": "theta_end",
    "theta_c": "theta_c",
    "stiffening": "stiffening",
    "elastic_c": "U_el_c",
    "work_c": "W_fr_c",
    "RED_c": "RED_c",
    "mu_static": "mu_static",
    "end": "end",
    "neighbour": "neighbour",
    "other_contact": "other_contact",
}
TWISTING = Loading(
    "twisting",
    {
        "rate": "Phi",
        "load": "phi",
        "torque": "T",
        "scales": "T_scales",
        "tangent": "K_t",
        "p": "p",
        "s": "s",
        **_ALONG,
    },
    {
        "load_e": "phi_e",
        "rate_e": "Phi_e",
        "load_end": "phi_end",
        "rate_end": "Phi_end",
        "rate_c": "Phi_c",
        "torque_c": "T_c",
        **_FIGURES,
    },
)
BENDING = Loading(
    "bending",
    {
        "rate": "kappa",
        "load": "psi",
        "torque": "M",
        "scales": "M_scales",
        "tangent": "K_b",
        "s": "r",
        **_ALONG,
    },
    {
        "load_e": "psi_e",
        "rate_e": "kappa_e",
        "load_end": "psi_end",
        "rate_end": "kappa_end",
        "rate_c": "kappa_c",
        "torque_c": "M_c",
        **_FIGURES,
    },
)


def twist(
    beam: Beam,
    *,
    mu: ArrayLike | None = None,
    law: str = "edge",
    margin: float = 0.01,
    points: int = 200,
    at: ArrayLike | None = None,
    to: float | str | None = None,
    sense: str = "+",
) -> xr.Dataset:
    """Twist a beam: torque, inclination, forces and energies from no load to the end of the curve.

    Parameters
    ----------
    beam
        The beam.
    mu
        Coefficient of friction; a sequence gives a family of curves along the dimension ``mu``. The beam's own if
        not given.
    law
        "edge" (satisfies virtual work) or "plate" (the paper's).
    margin
        Where a curve that locks is cut off: the fraction of its path left before the lock (docs, theory: energy).
    points
        Number of points of a curve.
    at
        Twist rates (rad/m, magnitudes) at which to give the response instead; NaN beyond the end of the curve.
    to
        Twist at which to stop: a rate in rad/m or text such as "5 rad/m", "0.2 rad/pitch", "90 deg total".
    sense
        "+" or "-": which way the beam is twisted. Twists are magnitudes.

    Returns
    -------
    xarray.Dataset
        Dimension ``point`` (and ``mu``); variables named as in :data:`squama.SYMBOLS`, SI units and radians;
        single figures of the curve such as ``phi_e``, ``phi_end``, ``end``, ``RED_c``; beam, law, margin and version
        in the attributes.

    Raises
    ------
    InputError
        An argument is out of range.

    Examples
    --------
    >>> import squama
    >>> beam = squama.Beam.from_ratios(eta=3, beta=1.25, lam=0.45, alpha="45 deg", theta0="10 deg")
    >>> r = squama.twist(beam, mu=0.5)
    >>> print(r.end.item(), f"at {float(r.phi_end):.4f} rad per pitch, RED = {float(r.RED_c):.3f}")
    frictional lock at 0.2691 rad per pitch, RED = 0.740
    """
    return twisted(beam, mu=mu, law=law, margin=margin, points=points, at=at, to=to, sense=sense).dataset()


def twisted(
    beam: Beam,
    *,
    mu: ArrayLike | None = None,
    law: str = "edge",
    margin: float = 0.01,
    points: int = 200,
    at: ArrayLike | None = None,
    to: float | str | None = None,
    sense: str = "+",
) -> Answer:
    """Return what :func:`twist` returns, before it is a dataset."""
    sign = checks.sense(sense)
    checks.law(law)
    theta_0 = beam.scale.theta0
    case = Case(beam.pitch, beam.torsional_rigidity, beam.joint_stiffness, beam.eta, theta_0, sign < 0)
    eta, beta, lam, slant, theta0 = (np.array([v]) for v in beam.ratios.values())
    alpha = beam.scale.alpha
    plates = Plates(beam.eta, beam.beta, beam.lam, sign * math.sin(alpha), math.cos(alpha))

    def solve(m: float) -> tuple[solution.Solution, Touch | None]:
        sol = solution.solve_twisting(eta, beta, lam, slant, theta0, np.array([m]), law=law, sense=sense)
        sol, touches = solution.with_touches(sol, [plates], theta0, mirrored=sign < 0)
        return sol, touches[0]

    stop = None if to is None else units.twist(to, pitch=beam.pitch, scales=beam.scales) * beam.pitch
    slope = beam.eta * math.tan(alpha) * sign + beam.beta - math.sin(alpha) * sign
    small = beam.scale.theta0 / slope if slope > 0 else math.inf
    answer = _respond(TWISTING, beam, case, solve, mu, law, margin, points, at, stop, {"phi_e_small": small})
    answer.attrs["sense"] = sense
    return answer


def bend(
    beam: Beam,
    *,
    mu: ArrayLike | None = None,
    margin: float = 0.01,
    points: int = 200,
    at: ArrayLike | None = None,
    to: float | str | None = None,
) -> xr.Dataset:
    """Bend a beam towards its scales: moment, inclination, forces and energies to the end of the curve.

    Parameters
    ----------
    beam, mu, margin, points
        As in :func:`twist`. In the plane the two force laws coincide.
    at
        Curvatures (rad/m) at which to give the response instead; NaN beyond the end of the curve.
    to
        Curvature at which to stop: rad/m or text such as "5 rad/m", "0.2 rad/pitch", "90 deg total".

    Returns
    -------
    xarray.Dataset
        As from :func:`twist`, with ``kappa``, ``psi`` and ``M`` in place of ``Phi``, ``phi`` and ``T``.

    Raises
    ------
    InputError
        An argument is out of range.

    Examples
    --------
    >>> import squama
    >>> m = squama.bend(squama.Beam.from_ratios(eta=5, theta0="5 deg"), mu=0.3)
    >>> print(m.end.item(), f"at {float(5 * m.psi_end):.5f} / eta")
    frictional lock at 0.96228 / eta
    """
    return bent(beam, mu=mu, margin=margin, points=points, at=at, to=to).dataset()


def bent(
    beam: Beam,
    *,
    mu: ArrayLike | None = None,
    margin: float = 0.01,
    points: int = 200,
    at: ArrayLike | None = None,
    to: float | str | None = None,
) -> Answer:
    """Return what :func:`bend` returns, before it is a dataset."""
    case = Case(beam.pitch, beam.bending_rigidity, beam.bending_joint_stiffness, beam.eta, beam.scale.theta0)

    def solve(m: float) -> tuple[solution.Solution, None]:
        return solution.solve_bending(np.array([beam.eta]), np.array([beam.scale.theta0]), np.array([m])), None

    stop = None if to is None else units.curvature(to, pitch=beam.pitch, scales=beam.scales) * beam.pitch
    return _respond(BENDING, beam, case, solve, mu, "edge", margin, points, at, stop, {})


def _respond(
    loading: Loading,
    beam: Beam,
    case: Case,
    solve: Any,
    mu: ArrayLike | None,
    law: str,
    margin: float,
    points: int,
    at: ArrayLike | None,
    stop: float | None,
    constants: dict[str, float],
) -> Answer:
    mus = _friction(beam, mu)
    margin = checks.scalar("margin", margin, 1e-12, 1.0, "at least 1e-12 and below 1")
    points = checks.whole("points", points, 3, 1e6)
    if stop is not None and stop <= 0:
        checks.fail(f"to = {stop / beam.pitch:.6g} rad/m: must be above 0; twist the other way with sense")
    loads = None
    if at is not None:
        loads = np.atleast_1d(checks.not_negative("at", at)) * beam.pitch
        if loads.ndim != 1:
            checks.fail(f"at: must be one number or a sequence of numbers, not an array of shape {loads.shape}")
    curves = []
    for m in np.atleast_1d(mus):
        sol, touch = solve(float(m))
        curves.append(curve(case, path(case, sol, touch, float(m), law, margin, stop), points=points, at=loads))
    attrs = {
        "title": f"{loading.kind} of a scale-covered beam",
        "load": loading.kind,
        "law": law,
        "margin": margin,
        "beam": _text(beam),
        "squama_version": __version__,
        "warnings": "\n".join(beam.warnings(loading.kind)),
    }
    return Answer(_labelled(loading, curves, mus, constants), attrs)


@functools.lru_cache(maxsize=64)
def _text(beam: Beam) -> str:
    return beam.to_toml()


def _friction(beam: Beam, mu: ArrayLike | None) -> Array:
    value = beam.friction.mu if mu is None else mu
    if value is None:
        checks.fail("mu is not given: pass mu=0.3, or write mu under [friction] in the beam's file")
    mus = checks.not_negative("mu", value)
    if mus.ndim > 1 or mus.size == 0:
        checks.fail(f"mu: must be one number or a sequence of numbers, not an array of shape {mus.shape}")
    return mus


def _labelled(
    loading: Loading, curves: Sequence[Curve], mus: Array, constants: dict[str, float]
) -> dict[str, Labelled]:
    def stack(values: Sequence[Any]) -> Array:
        return np.stack([np.asarray(v) for v in values]) if mus.ndim else np.asarray(values[0])

    family = ("mu",) if mus.ndim else ()
    variables: dict[str, Labelled] = {}
    for role, name in loading.along.items():
        variables[name] = Labelled((*family, "point"), stack([c.along[role] for c in curves]), SYMBOLS[name].attrs)
    for role, name in loading.figures.items():
        variables[name] = Labelled(family, stack([c.figures[role] for c in curves]), SYMBOLS[name].attrs)
    for name, value in constants.items():
        variables[name] = Labelled((), np.asarray(value), SYMBOLS[name].attrs)
    variables["mu"] = Labelled(family, mus, SYMBOLS["mu"].attrs)
    return variables

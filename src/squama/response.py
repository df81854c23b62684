"""From a beam to its labelled response: the only file that knows the whole order."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from squama import checks, units
from squama._version import __version__
from squama.answer import Answer, Labelled
from squama.curve import Case, Curve, curve, path
from squama.design import Beam
from squama.loading import BENDING, COMPLIANT, TWISTING, Loading
from squama.model import solution
from squama.model.plates import Plates, Touch
from squama.model.solve import Array
from squama.symbols import SYMBOLS

if TYPE_CHECKING:
    import xarray as xr


def twist(
    beam: Beam,
    *,
    mu: ArrayLike | None = None,
    law: str = "edge",
    margin: float = 0.01,
    points: int = 200,
    at: ArrayLike | Sequence[float | str] | str | None = None,
    to: float | str | None = None,
    sense: str = "+",
    joint: str = "hinge",
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
        Twists (magnitudes, as ``to``) at which to give the response instead; NaN beyond the end of the curve.
    to
        Twist at which to stop: a rate in rad/m or text such as "5 rad/m", "0.2 rad/pitch", "90 deg total".
    sense
        "+" or "-": which way the beam is twisted. Twists are magnitudes.
    joint
        "hinge" (closed form: a scale turns about its width against K_theta) or "compliant" (six motions against the
        stiffness that finite elements give, contact of the plates anywhere; goes to ``to``, 0.3 rad per pitch if not
        given; NaN beyond an earlier end; the force law is "edge" and there is no margin). See docs, theory.

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
    return twisted(beam, mu=mu, law=law, margin=margin, points=points, at=at, to=to, sense=sense, joint=joint).dataset()


def twisted(
    beam: Beam,
    *,
    mu: ArrayLike | None = None,
    law: str = "edge",
    margin: float = 0.01,
    points: int = 200,
    at: ArrayLike | Sequence[float | str] | str | None = None,
    to: float | str | None = None,
    sense: str = "+",
    joint: str = "hinge",
) -> Answer:
    """Return what :func:`twist` returns, before it is a dataset."""
    sign = checks.sense(sense)
    checks.law(law)
    solved = JOINTS[checks.joint(joint)]
    stop = None if to is None else units.twist(to, pitch=beam.pitch, scales=beam.scales) * beam.pitch
    answer = solved(beam, _Asked(mu, law, margin, points, _rates(at, units.twist, beam), stop, sense), sign)
    answer.attrs |= {"sense": sense, "joint": joint}
    return answer


class _Asked(NamedTuple):
    """Arguments of a response as given; ``at`` in rad/m, ``stop`` in rad per pitch."""

    mu: ArrayLike | None
    law: str
    margin: float
    points: int
    at: ArrayLike | None
    stop: float | None
    sense: str = "+"


def _rates(at: Any, read: Callable[..., float], beam: Beam) -> Any:
    """Return rates in rad/m where texts such as "0.2 rad/pitch" are given."""
    given = [at] if isinstance(at, str) else at
    if not isinstance(given, list | tuple) or not any(isinstance(value, str) for value in given):
        return at
    try:
        return [read(value, pitch=beam.pitch, scales=beam.scales) for value in given]
    except units.QuantityError as error:
        checks.fail(f"at = {error.shown}: {error.reason}")


def _hinged(beam: Beam, asked: _Asked, sign: int) -> Answer:
    """Follow the closed form."""
    law, sense = asked.law, "+" if sign > 0 else "-"
    theta_0 = beam.scale.theta0
    case = Case(beam.pitch, beam.torsional_rigidity, beam.joint_stiffness, beam.eta, theta_0, sign < 0)
    eta, beta, lam, slant, theta0 = (np.array([v]) for v in beam.ratios.values())
    alpha = beam.scale.alpha
    plates = Plates(beam.eta, beam.beta, beam.lam, sign * math.sin(alpha), math.cos(alpha))

    def solve(m: float) -> tuple[solution.Solution, Touch | None]:
        sol = solution.solve_twisting(eta, beta, lam, slant, theta0, np.array([m]), law=law, sense=sense)
        sol, touches = solution.with_touches(sol, [plates], theta0, mirrored=sign < 0)
        return sol, touches[0]

    return _respond(TWISTING, beam, _closed(case, solve, law), asked, {"phi_e_small": _small(beam, sign)})


def _small(beam: Beam, sign: int) -> float:
    slope = sign * (beam.eta * math.tan(beam.scale.alpha) - math.sin(beam.scale.alpha)) + beam.beta
    return beam.scale.theta0 / slope if slope > 0 else math.inf


def _compliant(beam: Beam, asked: _Asked, sign: int) -> Answer:
    """Follow rigid plates on the stiffness from finite elements."""
    from squama import compliant

    if asked.law != "edge":
        checks.fail(f'law = "{asked.law}": belongs to joint="hinge"; plates on a compliant joint follow "edge"')
    far = compliant.RANGE if asked.stop is None else asked.stop
    if far >= math.pi:
        checks.fail(f"to = {far / beam.pitch:.6g} rad/m: must be below half a turn per pitch")
    joint = compliant.stiffness(beam)

    def trace(m: float, grid: Grid) -> Curve:
        loads = np.linspace(0.0, far, grid.points) if grid.at is None else grid.at
        return compliant.curve(beam, joint, m, loads, sign=sign)

    answer = _respond(COMPLIANT, beam, trace, asked, {"phi_e_small": _small(beam, sign)})
    answer.attrs |= {"K_theta": joint.K_theta, "rigidity": joint.rigidity}
    del answer.attrs["margin"]
    notes = compliant.warnings(beam, far if asked.at is None else float(np.max(asked.at)) * beam.pitch)
    answer.attrs["warnings"] = "\n".join([*answer.attrs["warnings"].splitlines(), *notes])
    return answer


JOINTS = {"hinge": _hinged, "compliant": _compliant}
"""How a scale is held: a hinge with one spring, or six motions against the substrate."""


def bend(
    beam: Beam,
    *,
    mu: ArrayLike | None = None,
    margin: float = 0.01,
    points: int = 200,
    at: ArrayLike | Sequence[float | str] | str | None = None,
    to: float | str | None = None,
) -> xr.Dataset:
    """Bend a beam towards its scales: moment, inclination, forces and energies to the end of the curve.

    Parameters
    ----------
    beam, mu, margin, points
        As in :func:`twist`. In the plane the two force laws coincide.
    at
        Curvatures (as ``to``) at which to give the response instead; NaN beyond the end of the curve.
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
    at: ArrayLike | Sequence[float | str] | str | None = None,
    to: float | str | None = None,
) -> Answer:
    """Return what :func:`bend` returns, before it is a dataset."""
    case = Case(beam.pitch, beam.bending_rigidity, beam.bending_joint_stiffness, beam.eta, beam.scale.theta0)

    def solve(m: float) -> tuple[solution.Solution, None]:
        return solution.solve_bending(np.array([beam.eta]), np.array([beam.scale.theta0]), np.array([m])), None

    stop = None if to is None else units.curvature(to, pitch=beam.pitch, scales=beam.scales) * beam.pitch
    asked = _Asked(mu, "edge", margin, points, _rates(at, units.curvature, beam), stop)
    return _respond(BENDING, beam, _closed(case, solve, "edge"), asked, {})


class Grid(NamedTuple):
    """Where a curve is wanted: number of points, load angles instead (rad per pitch), where to stop, margin."""

    points: int
    at: Array | None
    stop: float | None
    margin: float


def _closed(case: Case, solve: Any, law: str) -> Callable[[float, Grid], Curve]:
    """Return what makes a curve of the closed form for one coefficient of friction."""

    def trace(m: float, grid: Grid) -> Curve:
        sol, touch = solve(m)
        return curve(case, path(case, sol, touch, m, law, grid.margin, grid.stop), points=grid.points, at=grid.at)

    return trace


def _respond(
    loading: Loading,
    beam: Beam,
    trace: Callable[[float, Grid], Curve],
    asked: _Asked,
    constants: dict[str, float],
) -> Answer:
    mus = _friction(beam, asked.mu)
    margin = checks.scalar("margin", asked.margin, 1e-12, 1.0, "at least 1e-12 and below 1")
    points = checks.whole("points", asked.points, 3, 1e6)
    if asked.stop is not None and asked.stop <= 0:
        checks.fail(f"to = {asked.stop / beam.pitch:.6g} rad/m: must be above 0; twist the other way with sense")
    loads = None
    if asked.at is not None:
        loads = np.atleast_1d(checks.not_negative("at", asked.at)) * beam.pitch
        if loads.ndim != 1:
            checks.fail(f"at: must be one number or a sequence of numbers, not an array of shape {loads.shape}")
    curves = [trace(float(m), Grid(points, loads, asked.stop, margin)) for m in np.atleast_1d(mus)]
    attrs = {
        "title": f"{loading.kind} of a scale-covered beam",
        "load": loading.kind,
        "law": asked.law,
        "margin": margin,
        "mu": mus.tolist(),
        "beam": _text(beam),
        "squama_version": __version__,
        "warnings": "\n".join(beam.warnings(loading.kind, asked.sense)),
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

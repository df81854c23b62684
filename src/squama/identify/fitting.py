"""From measured torque and twist to the parameters of a beam: the order of a fit."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from squama import arguments, units
from squama.beam import matrixfile
from squama.beam.design import Beam
from squama.curves import follow, hinge_cycles, path
from squama.curves.hinge_cycles import Senses
from squama.errors import InputError, naming, refuse
from squama.identify import estimate, records, sentences
from squama.identify.estimate import Estimate, sample
from squama.identify.forward import Forward, Physical, Walked, build
from squama.identify.parameters import DEFAULT, Asked, ask
from squama.identify.records import Record
from squama.identify.result import Fit, SpecimenFit
from squama.loads import LOADS
from squama.needs import need
from squama.types import Array

_NEAR = 1e-9
_ENGAGED = {"mu", "K_theta", "theta0"}


class _Points(NamedTuple):
    """A record with its contacts: ``forward`` of all points (of those beyond the range at 0), which may be used."""

    record: Record
    forward: Forward | Walked
    usable: NDArray[np.bool_]


def fit(
    data: Any,
    beam: Beam,
    parameters: Sequence[str] | str = DEFAULT,
    *,
    load: str = "twisting",
    law: str = "edge",
    bounds: Mapping[str, tuple[Any, Any]] | None = None,
    noise: float | str | None = None,
    to: float | str | None = None,
    reversal: float | str = 0.0,
    stick: float | str = 0.0,
    starts: int = 6,
    posterior: int = 0,
    seed: int = 1,
    joint: str = "hinge",
) -> Fit:
    """Find friction, joint stiffness and other parameters of a beam from measured torque and twist.

    Parameters
    ----------
    data
        A CSV file with units in its header, or several; a dataset of :func:`squama.cycle` or another mapping with
        ``Phi`` (rad/m) or ``phi`` (rad) and ``T`` (N m), in bending ``kappa`` or ``psi`` and ``M``. Rows in the order
        measured: loading only, or loading and unloading. Several specimens: a column ``specimen``, or several files.
    beam, parameters
        The beam, from which all else is known, and what is to be found, of ``mu``, ``K_theta``, ``C_f``, ``E_B``
        (Young's modulus of the bar; its shear modulus follows), ``theta0`` and ``zero`` (reading of the load cell at no
        load).
    load, law
        As in :func:`squama.solve`.
    bounds
        Lower and upper bound by parameter: SI numbers or texts such as "5 deg"; None for an open end.
    noise
        Standard deviation of a measured torque, N m or text such as "5 N mm"; from the residuals if not given.
    to
        Twist beyond which points are not used: rad/m or text such as "0.1 rad/pitch".
    reversal, stick
        Way back that is taken for noise of the measured twist, not for a reversal; way after a reversal on which points
        are not used, because the joints still give there.
    starts, posterior, seed
        Numbers of starts of the search, and of posterior samples to draw (extra ``fit``; 0 for none); their seed.
    joint
        "hinge" or "compliant": six motions of a scale against the substrate, whose matrix is the beam's or computed
        once (extra fe); the record is walked for each friction tried, from one start. ``K_theta`` multiplies the
        matrix, ``C_f`` the rigidity without contact; ``theta0`` is not found, and no samples are drawn.

    Returns
    -------
    Fit
        ``beam`` (with the estimates put in), ``values``, ``errors``, ``correlation``, ``residuals``, ``notes``,
        ``summary()``, ``dataset()`` and more.

    Raises
    ------
    InputError
        An argument is out of range, the data cannot be used, or they do not show what is to be found.

    Examples
    --------
    >>> import squama
    >>> beam = squama.Beam.from_ratios(youngs_modulus="2 MPa", mu=0.3)
    >>> loop = squama.cycle(beam, "0.2 rad/pitch", joint="hinge", ideal=True)
    >>> f = squama.fit(loop, beam.replace(friction={"mu": 0.1}))
    >>> print(f"mu = {f.values['mu']:.6f}")
    mu = 0.300000
    """
    arguments.load(load)
    law = LOADS[load].law(arguments.law(law))
    starts, samples = arguments.whole("starts", starts, 1, 1000), arguments.whole("posterior", posterior, 0, 1e6)
    arguments.whole("seed", seed, 0, 2**32 - 1)
    if samples:
        need("emcee")
    with naming("noise"):
        sigma = None if noise is None else units.quantity(noise, "torque")
    if sigma is not None and sigma <= 0:
        refuse("noise", f"{sigma:.6g} N m", "must be above 0", 'write e.g. "5 N mm"')
    if sigma is not None and not records.TORQUES.hold(sigma):
        refuse("noise", f"{sigma:.6g} N m", f"is out of range ({records.TORQUES.allowed})", 'write e.g. "5 N mm"')
    if arguments.joint(joint) == "compliant":
        beam = _compliant(beam, load, law, samples)
    asked = ask(beam, load, parameters, bounds)
    if joint == "compliant" and "theta0" in asked.names:
        reason = 'theta0 is not found with joint="compliant": the elements depend on it'
        refuse("parameters", "", reason, "leave it out")
    record = records.record(records.read(data, beam, load), beam, load, to=to, reversal=reversal, stick=stick)
    points = placed(record, asked, law) if joint == "hinge" else _walked(record, asked)
    _enough(points, asked, noise_known=sigma is not None)
    result = _result(points, asked, law, starts if joint == "hinge" else 1, sigma)
    if samples:
        used = np.flatnonzero(result.used)
        assert isinstance(points.forward, Forward)
        forward, torque = points.forward.take(used), record.torque[used]
        found = sample(forward, torque, asked, result.estimates, result.covariance, samples, noise=sigma, seed=seed)
        result = replace(result, posterior=found)
    return result


def _senses(asked: Asked, law: str) -> Senses:
    """Return the senses for the smallest friction and inclination at rest of all trials."""
    start = asked.beam.replace(scale={"theta0": asked.bound("theta0", 0)})
    return hinge_cycles.senses(start, asked.load, asked.bound("mu", 0), law, _NEAR)


def placed(record: Record, asked: Asked, law: str) -> _Points:
    """Put a record on the paths of its contacts; refuse what no trial covers."""
    senses = _senses(asked, law)
    records.check_range(record, senses, asked.bound("mu", 0))
    # what is not asked for and lies beyond the range has no place on a path
    most = np.where(record.load < 0, senses.most["-"], senses.most["+"])
    covered = np.abs(record.load) <= most * (1 + _NEAR)
    forward = build(senses, np.where(covered, record.load, 0.0), record.way)
    return _Points(record, forward, record.asked & covered & ~(record.stuck & (forward.theta > 0)))


def _compliant(beam: Beam, load: str, law: str, samples: int) -> Beam:
    """Return the beam with the matrix of its joint, alone; refuse what the compliant joint does not cover."""
    follow.model("compliant", path.Asked(beam, path.LoadPath.of(load, [1.0]), np.zeros(()), law, 0.01, 3))
    if samples:
        refuse("posterior", str(samples), 'no samples are drawn with joint="compliant"', "leave it out")
    from squama.curves.real import Held

    matrix = matrixfile.stored(beam, Held.of(beam).K[:7, :7])
    return beam.replace(joint={"matrix": matrix, "stiffness": None, "inclusion_factor": None})


def _walked(record: Record, asked: Asked) -> _Points:
    """Put a record on the compliant joint, walked with the friction of the beam."""
    mu = float(asked.physical(asked.start).mu)
    forward = Walked(asked.beam, record.load, record.way, record.specimen, mu)
    return _Points(record, forward, record.asked & ~(record.stuck & (forward.theta > 0)))


def _enough(points: _Points, asked: Asked, *, noise_known: bool) -> None:
    """Refuse too few points, and points that do not show what is to be found."""
    usable, rec, word = points.usable, points.record, LOADS[asked.load].verb
    need, have = len(asked.rows) + (not noise_known), int(np.count_nonzero(usable))
    if have < need:
        count = f"{have} usable point{'s' * (have != 1)} (of {rec.load.size}) for {len(asked.rows)} parameters"
        remedy = f"give {need} or more, better ten for each parameter"
        refuse("data", "", f"{count} ({' and '.join(asked.names)})", remedy)
    if not rec.torque[usable].any():
        refuse("data", "", "the torque is 0 at every point that is used", "check the column and the load cell")
    hidden = [n for n in asked.names if n in _ENGAGED]
    touching = int(np.count_nonzero(usable & (points.forward.theta > asked.bound("theta0", 0))))
    if touching >= len(hidden):
        return
    if touching:
        kinds = " and ".join([n for n in hidden if n != "theta0"] or hidden)
        reason = f"{touching} point in contact for {len(hidden)} parameters that are seen in contact only ({kinds})"
        refuse("data", "", reason, f"give points at a larger {word}")
    far = float(max(rec.load[usable], key=abs))
    here, there = ("-", "+") if far < 0 else ("+", "-")
    paths = _senses(asked, "edge").paths
    if np.isfinite(paths[here].load_e):
        at = float(np.copysign(paths[here].load_e, far))
        where = f"engagement is at {at:.4g} rad/pitch"
        remedy = f"measure beyond {at:.4g} rad/pitch ({at / asked.beam.pitch:.4g} rad/m), or find C_f or E_B only"
    else:
        where = f"in this sense, {here}, the scales do not engage"
        turned = np.isfinite(paths[there].load_e)
        remedy = "if the sense was the other, turn the signs of twist and torque" if turned else "find C_f or E_B only"
    reason = f"all {have} points lie before engagement (largest {word} {far:.4g} rad/pitch, {where})"
    refuse("data", "", f"{reason}, where {' and '.join(hidden)} cannot be seen", remedy)


def _estimated(points: _Points, asked: Asked, starts: int, sigma: float | None) -> tuple[Estimate, Array, float]:
    """Return the estimate from the usable points, its covariance, and the noise of a point."""
    index = np.flatnonzero(points.usable)
    found = estimate.solve(points.forward.take(index), points.record.torque[index], asked, starts)
    noise = float(np.sqrt(found.square / (index.size - len(asked.rows)))) if sigma is None else sigma
    covariance = estimate.covariance(found.jacobian, noise, asked.names)
    if not all(np.isfinite(values).all() for values in (found.values, covariance, noise)):
        refuse("data", "", "the estimates or their errors are no finite numbers", "check the units of twist and torque")
    return found, covariance, noise


def _result(points: _Points, asked: Asked, law: str, starts: int, sigma: float | None) -> Fit:
    best, covariance, noise = _estimated(points, asked, starts, sigma)
    rec, forward = points.record, points.forward
    at, beam = asked.physical(best.values), asked.fitted(best.values)
    touching, covered = forward.theta > at.theta0, points.usable | (rec.stuck & rec.asked)
    branch = np.where(touching, np.where(rec.way > 0, "loading", "unloading"), "straight")
    branch = np.where(rec.stuck & touching, "stick", branch)
    band = estimate.standard_error(forward, asked, best.values, covariance)
    fitted = np.where(covered, forward.torque(at), np.nan)
    used = forward.take(np.flatnonzero(points.usable))
    senses, remedies = None, []
    if isinstance(used, Forward):
        senses = hinge_cycles.senses(beam, asked.load, at.mu, law, 0.01)
        remedies = estimate.remedies(asked, best.values, senses, used, best.jacobian, noise)
    else:
        beam = _scaled(beam, asked, at)
    result = Fit(
        beam=beam,
        initial=asked.beam,
        load=asked.load,
        law=law,
        asked=asked,
        record=rec,
        forward=forward,
        estimates=best.values,
        covariance=covariance,
        noise=noise,
        given_noise=sigma is not None,
        rms=float(np.sqrt(best.square / used.theta.size)),
        residuals=rec.torque - fitted,
        fitted=fitted,
        band=np.where(covered, band, np.nan),
        branch=np.where(covered, branch, "beyond"),
        used=points.usable,
        jacobian=best.jacobian,
        starts=(best.agreed, best.starts),
        at_bound=best.at_bound,
        specimens=_alone(points, asked, sigma),
        remedies=tuple(remedies),
        notes=(),
    )
    return replace(result, notes=tuple(sentences.notes(result, senses)))


def _scaled(beam: Beam, asked: Asked, at: Physical) -> Beam:
    """Return the fitted beam with its matrix: the joint times one factor, the rigidity without contact another."""
    own = asked.beam.joint.matrix
    assert own is not None
    bare, modulus = np.zeros((7, 7)), asked.beam.substrate.youngs_modulus / beam.substrate.youngs_modulus
    bare[6, 6] = own.rigidity
    joint, bar = at.stiffness / asked.base.stiffness * modulus, at.rigidity / asked.base.rigidity * modulus
    K = (own.K - bare) * joint + bare * bar
    return beam.replace(joint={"matrix": matrixfile.stored(beam, K), "stiffness": None, "inclusion_factor": None})


def _alone(points: _Points, asked: Asked, sigma: float | None) -> tuple[SpecimenFit, ...]:
    """Fit each specimen alone."""
    rec, out = points.record, []
    if len(rec.specimens) == 1:
        return ()
    for i, specimen in enumerate(rec.specimens):
        mine = points._replace(usable=points.usable & (rec.specimen == i))
        try:
            _enough(mine, asked, noise_known=sigma is not None)
            best, covariance, _ = _estimated(mine, asked, 2, sigma)
            out.append(SpecimenFit(specimen.label, best.values, np.sqrt(np.diag(covariance))))
        except InputError as error:
            out.append(SpecimenFit(specimen.label, None, None, str(error)))
    return tuple(out)

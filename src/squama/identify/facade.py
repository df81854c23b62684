"""From measured torque and twist to the parameters of a beam: the order of a fit."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from squama import checks, histories, units
from squama.design import Beam
from squama.errors import InputError
from squama.histories import Senses
from squama.identify import data as records
from squama.identify import estimate, separable, wording
from squama.identify.data import Record
from squama.identify.forward import Forward, build
from squama.identify.parameters import DEFAULT, Asked, ask
from squama.identify.result import Fit
from squama.model.solve import Array

_NEAR = 1e-9
_ENGAGED = {"mu", "K_theta", "theta0"}


class SpecimenFit(NamedTuple):
    """Estimates and errors from one specimen alone; None where that is not possible, ``problem`` says why."""

    label: str
    values: Array | None
    errors: Array | None
    problem: str = ""


class _Points(NamedTuple):
    """A record with its contacts: ``forward`` of all points (of those beyond the range at 0), which may be used."""

    record: Record
    forward: Forward
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
) -> Fit:
    """Find friction, joint stiffness and other parameters of a beam from measured torque and twist.

    Parameters
    ----------
    data
        A CSV file with units in its header, or several; a dataset of :func:`squama.cycle` or another mapping with
        ``Phi`` (rad/m) or ``phi`` (rad) and ``T`` (N m), in bending ``kappa`` or ``psi`` and ``M``. Rows in the order
        measured: loading only, or loading and unloading. Several specimens: a column ``specimen``, or several files.
    beam
        The beam; what is not to be found is known from it.
    parameters
        What is to be found, of ``mu``, ``K_theta``, ``C_f``, ``E_B`` (Young's modulus of the bar; its shear modulus
        follows), ``theta0`` and ``zero`` (reading of the load cell at no load).
    load
        "twisting" or "bending".
    law
        "edge" (satisfies virtual work) or "plate" (the paper's); in bending they coincide.
    bounds
        Lower and upper bound by parameter: SI numbers or texts such as "5 deg"; None for an open end.
    noise
        Standard deviation of a measured torque, N m or text such as "5 N mm"; from the residuals if not given.
    to
        Twist beyond which points are not used: rad/m or text such as "0.1 rad/pitch".
    reversal
        Way back that is taken for noise of the measured twist, not for a reversal.
    stick
        Way after a reversal on which points are not used, because the joints still give there.
    starts
        Number of starts of the search.
    posterior
        Number of posterior samples to draw (extra ``fit``); 0 for none.
    seed
        Seed of the samples.

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
    >>> loop = squama.cycle(beam, "0.2 rad/pitch")
    >>> f = squama.fit(loop, beam.replace(friction={"mu": 0.1}))
    >>> print(f"mu = {f.values['mu']:.6f}")
    mu = 0.300000
    """
    checks.one_of("load", load, tuple(wording.WORDS))
    checks.law(law)
    law = law if load == "twisting" else "edge"
    starts = checks.whole("starts", starts, 1, 1000)
    posterior = checks.whole("posterior", posterior, 0, 1e6)
    checks.whole("seed", seed, 0, 2**32 - 1)
    sigma = None if noise is None else _torque("noise", noise)
    asked = ask(beam, load, parameters, bounds)
    record = records.record(records.read(data, beam, load), beam, load, to=to, reversal=reversal, stick=stick)
    points = placed(record, asked, law)
    _enough(points, asked, sigma is not None)
    found = _estimated(points, points.usable, asked, starts, sigma)
    result = _result(points, asked, law, found, sigma)
    if posterior:
        from squama.identify import posterior as sampling

        samples = sampling.sample(points.forward.take(np.flatnonzero(result.used)), result, posterior, seed)
        result = replace(result, posterior=samples)
    return result


def _torque(name: str, value: float | str) -> float:
    try:
        found = units.quantity(value, "torque")
    except units.QuantityError as error:
        message = f"{name} = {error.shown}: {error.reason}"
        raise InputError(message) from None
    if found <= 0:
        checks.fail(f'{name} = {found:.6g} N m: must be above 0; write e.g. "5 N mm"')
    return found


def placed(record: Record, asked: Asked, law: str) -> _Points:
    """Put a record on the paths of its contacts; refuse what no trial covers."""
    lowest = asked.bound("mu", 0)
    start = asked.beam.replace(scale={"theta0": asked.bound("theta0", 0)})
    senses = histories.senses(start, asked.load, lowest, law, _NEAR)
    records.check_range(record, senses, lowest)
    # what is not asked for and lies beyond the range has no place on a path
    most = np.where(record.load < 0, senses.most["-"], senses.most["+"])
    covered = np.abs(record.load) <= most * (1 + _NEAR)
    forward = build(senses, np.where(covered, record.load, 0.0), record.way)
    usable = record.asked & covered & ~(record.stuck & (forward.theta > 0))
    return _Points(record, forward, usable)


def _enough(points: _Points, asked: Asked, noise_known: bool) -> None:
    """Refuse too few points, and points that do not show what is to be found."""
    usable, rec = points.usable, points.record
    need, have = len(asked.rows) + (0 if noise_known else 1), int(np.count_nonzero(usable))
    names = " and ".join(asked.names)
    word = {"twisting": "twist", "bending": "bend"}[asked.load]
    if have < need:
        checks.fail(
            f"data: {have} usable point{'s' * (have != 1)} (of {rec.load.size}) for {len(asked.rows)} parameters "
            f"({names}); give {need} or more, better ten for each parameter"
        )
    if not rec.torque[usable].any():
        checks.fail("data: the torque is 0 at every point that is used; check the column and the load cell")
    hidden = [n for n in asked.names if n in _ENGAGED]
    touching = usable & (points.forward.theta > asked.bound("theta0", 0))
    if not hidden or touching.any():
        kinds = [n for n in hidden if n != "theta0"]
        if hidden and int(np.count_nonzero(touching)) < len(hidden):
            checks.fail(
                f"data: {np.count_nonzero(touching)} point in contact for {len(hidden)} parameters that are seen in "
                f"contact only ({' and '.join(kinds or hidden)}); give points at a larger {word}"
            )
        return
    start = asked.beam.replace(scale={"theta0": asked.bound("theta0", 0)})
    senses = histories.senses(start, asked.load, asked.bound("mu", 0), "edge", _NEAR)
    far = float(max(rec.load[usable], key=abs))
    here, there = ("-", "+") if far < 0 else ("+", "-")
    at = senses.paths[here].load_e
    where = f"in this sense, {here}, the scales do not engage"
    remedy = "; find C_f or E_B only"
    if np.isfinite(senses.paths[there].load_e):
        remedy = "; if the sense was the other, turn the signs of twist and torque"
    if np.isfinite(at):
        at = float(np.copysign(at, far))
        where = f"engagement is at {at:.4g} rad/pitch"
        remedy = f"; measure beyond {at:.4g} rad/pitch ({at / asked.beam.pitch:.4g} rad/m), or find C_f or E_B only"
    checks.fail(
        f"data: all {have} points lie before engagement (largest {word} {far:.4g} rad/pitch, {where}), where "
        f"{' and '.join(hidden)} cannot be seen{remedy}"
    )


def _estimated(
    points: _Points, used: NDArray[np.bool_], asked: Asked, starts: int, sigma: float | None
) -> tuple[estimate.Estimate, Array, float]:
    """Return the estimate from some of the points, its covariance, and the noise of a point."""
    index = np.flatnonzero(used)
    found = estimate.solve(points.forward.take(index), points.record.torque[index], asked, starts)
    spare = index.size - len(asked.rows)
    noise = sigma if sigma is not None else float(np.sqrt(found.square / spare))
    return found, estimate.covariance(found.jacobian, noise, asked.names), noise


def _result(
    points: _Points, asked: Asked, law: str, found: tuple[estimate.Estimate, Array, float], sigma: float | None
) -> Fit:
    best, covariance, noise = found
    rec, forward = points.record, points.forward
    at = asked.physical(best.values)
    touching = forward.theta > at.theta0
    covered = points.usable | (rec.stuck & rec.asked)
    branch = np.where(touching, np.where(rec.way > 0, "loading", "unloading"), "straight")
    branch = np.where(rec.stuck & touching, "stick", branch)
    branch = np.where(covered, branch, "beyond")
    J = estimate.derivatives(forward, asked, best.values)
    band = np.sqrt(np.maximum(np.einsum("ij,jk,ik->i", J, covariance, J), 0.0))
    fitted = np.where(covered, forward.torque(at), np.nan)
    rms = float(np.sqrt(best.square / np.count_nonzero(points.usable)))
    fitted_beam = asked.fitted(best.values)
    senses = histories.senses(fitted_beam, asked.load, at.mu, law, 0.01)
    every = separable.remedies(
        asked, best.values, senses, forward.take(np.flatnonzero(points.usable)), best.jacobian, noise
    )
    result = Fit(
        fitted_beam,
        asked.beam,
        asked.load,
        law,
        asked,
        rec,
        forward,
        best.values,
        covariance,
        noise,
        sigma is not None,
        rms,
        rec.torque - fitted,
        fitted,
        np.where(covered, band, np.nan),
        branch,
        points.usable,
        best.jacobian,
        (best.agreed, best.starts),
        best.at_bound,
        _alone(points, asked, sigma),
        tuple(every),
        (),
    )
    notes = wording.notes(result, _autocorrelation(result), _locked(result, senses))
    return replace(result, notes=tuple(notes))


def _alone(points: _Points, asked: Asked, sigma: float | None) -> tuple[SpecimenFit, ...]:
    """Fit each specimen alone."""
    rec, out = points.record, []
    if len(rec.specimens) == 1:
        return ()
    for i, specimen in enumerate(rec.specimens):
        mine = points._replace(usable=points.usable & (rec.specimen == i))
        try:
            _enough(mine, asked, sigma is not None)
            best, covariance, _ = _estimated(mine, mine.usable, asked, 2, sigma)
        except InputError as error:
            out.append(SpecimenFit(specimen.label, None, None, str(error)))
            continue
        out.append(SpecimenFit(specimen.label, best.values, np.sqrt(np.diag(covariance))))
    return tuple(out)


def _autocorrelation(result: Fit) -> float:
    """Correlation of each residual with the next of the same specimen; 0 where too few points tell."""
    r, specimen = result.residuals[result.used], result.record.specimen[result.used]
    together = specimen[1:] == specimen[:-1]
    if np.count_nonzero(together) < 10 or not r.any() or result.rms < 1e-9 * float(np.abs(result.record.torque).max()):
        return 0.0
    return float(np.sum((r[1:] * r[:-1])[together]) / np.sum(r**2))


def _locked(result: Fit, senses: Senses) -> str | None:
    """Say where the fitted beam does not follow the data as the model takes them."""
    rec = result.record
    for sign, path in senses.paths.items():
        there = result.used & ((rec.load < 0) == (sign == "-"))
        far = float(np.max(np.abs(rec.load), where=there, initial=0.0))
        if far > path.load_end * (1 + _NEAR):
            return (
                f"the fitted beam ends at {path.load_end:.6g} rad/pitch ({path.end}), before the farthest point "
                f"({far:.6g} rad/pitch): the points beyond are not described by it"
            )
    return None

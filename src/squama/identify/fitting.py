"""A fit, step by step: from measured torque and twist to the parameters of a beam."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Literal

import numpy as np

from squama import arguments, units
from squama.beam.design import Beam
from squama.curves import finite_rows, hinge_cycles
from squama.curves.finite_rows import Ends
from squama.errors import InputError, naming, refuse
from squama.identify import estimate, groups, known, prepare, records, remarks, selection
from squama.identify import machine as machines
from squama.identify.hinge_points import Hinged
from squama.identify.joint_points import Walked, of_test
from squama.identify.posterior import sample
from squama.identify.prepare import Prepared, Wanted
from squama.identify.result import Alone, Fit
from squama.identify.selection import Found, Rival
from squama.identify.slope import slope
from squama.identify.unknowns import DEFAULT, OF_TWIST, PARAMETERS, SHOWN, ask, named
from squama.joints import choice
from squama.loads import ENDLESS, TESTS, EndsName, JointName, LawName
from squama.needs import need
from squama.part.definition import Part

_MOST = 0.9
"""Least share of the points that the other model must cover."""
_HOPELESS = 4.0
"""Ratio of residual rms, after a search from one start, above which the other model is not fitted further."""


def fit(
    data: object,
    beam: Beam | Part,
    parameters: Sequence[str] | str = DEFAULT,
    *,
    load: str | Sequence[str] | None = None,
    support: str | None = None,
    law: LawName = "edge",
    bounds: Mapping[str, tuple[object, object]] | None = None,
    noise: float | str | None = None,
    to: float | str | None = None,
    reversal: float | str | None = None,
    stick: float | str = 0.0,
    starts: int = 6,
    posterior: int = 0,
    seed: int = 1,
    joint: JointName | None = None,
    nuisances: Literal["auto", "none"] = "auto",
    ends: EndsName | None = None,
    machine: float | str | None = None,
    tolerances: Mapping[str, object] | None = None,
    each: Sequence[str] | str = (),
) -> Fit:
    """Find friction, joint stiffness and other parameters of a beam from measured torque and twist.

    A beam with a number of scales is modelled with all of them and its ends, as by :func:`squama.cycle`;
    ``Fit.endless`` has the estimates of an endless beam.

    Parameters
    ----------
    data
        A CSV file with units in its header, or several; a dataset of :func:`squama.cycle` or another mapping with
        ``Phi`` (rad/m) or ``phi`` (rad) and ``T`` (N m), in bending ``kappa`` or ``psi`` and ``M``; of a part
        ``travel`` (m) and ``F`` (N). Rows in the order measured: loading only, or loading and unloading. Several
        specimens: a column ``specimen``, or several files.
    beam, parameters
        The beam, which supplies all other values, and the parameters to find: ``mu``, ``K_theta``, ``C_f``, ``E_B``
        (Young's modulus of the bar; its shear modulus follows) and ``theta0``, and nuisances of the test:
        ``torque_zero`` and ``twist_zero`` (readings without load and without twist), ``backlash`` (twist lost at a
        reversal) and ``drift`` (change of the load cell's zero over a record); twists over the whole beam.
    load, support
        "twisting" (default) or "bending" of the beam's ends. Or the force on a part, whose table has force and travel
        of the loaded place, and the support, both as in :func:`squama.load`: "1 N up at tip", "simple, span 160 mm";
        the size of the force does not matter. A :class:`squama.Part` has both.
    law
        As in :func:`squama.solve`.
    bounds
        Lower and upper bound by parameter: SI numbers or texts such as "5 deg"; None for an open end.
    noise
        Standard deviation of a measured torque, N m or text such as "5 N mm" (of a force, N or "5 mN"); from the
        residuals if not given.
    to
        Largest twist of the used points: rad/m or text such as "0.1 rad/pitch".
    reversal, stick
        Largest backward twist that counts as noise of the measured twist, not as a reversal (default: six times the
        noise where noise turns the twist round); twist after a reversal within which points are not used, because the
        joints still give there.
    starts, posterior, seed
        Number of starts of the search, number of posterior samples (extra ``fit``; 0 for none), and their seed. On
        compliant joints up to 400 samples are computed with the full model.
    joint
        "compliant": thick, elastic scales, each free to move in all six directions, computed along the record for each
        trial; ``K_theta`` and ``C_f`` scale the joint as in a beam file; ``theta0`` cannot be found. "hinge": thin,
        rigid plates on hinges. Default: "compliant" where it covers the parameters and the record. The other model is
        fitted too, and a disagreement is reported.
    nuisances
        "auto": find nuisances that the residual shows as well; "none": only the given parameters.
    ends
        Ends of a beam with a number of scales, in place of its own: "free", "gripped", "equal" or "endless", as in
        :func:`squama.cycle`. Fits on hinges are endless.
    machine
        Torsional (in bending: bending) stiffness of the testing machine in series with the specimen, N m/rad or text
        such as "2 N m/rad"; of a frame that pushes a part N/m or "5 N/mm". "2 +- 0.5 N m/rad" (limits, or "... sd")
        finds its compliance too, from this value and from the points. "rigid" for none. If not given, ``Fit.machine``
        has the effect that a machine would have.
    tolerances
        Prior knowledge of parameters, by their name here or in the beam file, as in :func:`squama.uncertainty`:
        ``{"E_B": "1.5 MPa +- 5 %", "scale.alpha": "+- 1 deg"}``. They are found too, from the tolerance and the points:
        dimensions to first order, with the joint unchanged.
    each
        Parameters with a value for each loop of a record, or for each of several specimens, such as "mu, twist_zero". A
        loop is a way in the first sense and the way back. ``beam`` has their mean.

    Returns
    -------
    Fit
        ``beam`` (with the estimates), ``values``, ``errors``, ``correlation``, ``residuals``, ``notes``, ``doubts``
        (why the errors do not hold), ``summary()``, ``plot()``, ``dataset()`` and more.

    Raises
    ------
    InputError
        An argument is out of range, the data cannot be used, or they do not show the parameters.

    Examples
    --------
    >>> import squama
    >>> beam = squama.Beam.from_ratios(youngs_modulus="2 MPa", mu=0.3)
    >>> loop = squama.cycle(beam, "0.2 rad/pitch", joint="hinge", ideal=True)
    >>> f = squama.fit(loop, beam.replace(friction={"mu": 0.1}), joint="hinge")
    >>> print(f"mu = {f.values['mu']:.6f}")
    mu = 0.300000
    """
    load, part = of_test(beam, load, support)
    beam, pushed = part.beam, TESTS[load].pushed
    law = TESTS[load].law(arguments.law(law))
    starts, samples = arguments.whole("starts", starts, 1, 1000), arguments.whole("posterior", posterior, 0, 1e6)
    arguments.whole("seed", seed, 0, 2**32 - 1)
    if samples:
        need("emcee")
    with naming("noise"):
        size = ("force", records.FORCES) if pushed else ("torque", records.TORQUES)
        sigma = None if noise is None else units.bounded(noise, *size)
    automatic = arguments.one_of("nuisances", nuisances, ("auto", "none")) == "auto"
    means = machines.read(machine, TESTS[load])
    parameters = [*named(parameters, PARAMETERS)]
    priors, dimensions = known.priors(tolerances, beam, means, parameters)
    parameters += [n for n in priors if n not in parameters]
    asked = ask(beam, load, parameters, bounds, joint="hinge" if joint == "hinge" else "compliant", priors=priors)
    # posterior samples need fixed twists
    moved = [n for n in asked.names if n in OF_TWIST]
    if samples and moved:
        refuse("posterior", str(samples), f"no samples are drawn with {' and '.join(moved)}", "leave one out")
    candidates = tuple(n for n in SHOWN if automatic and not (samples and n in OF_TWIST))
    # before the joint, which may need finite elements
    limits = records.Limits.of(beam, load, to, reversal, stick)
    own = _each(each, asked.names, samples)
    given = (limits, sigma, starts, candidates, ENDLESS, means, dimensions, priors, part if pushed else None)
    wanted = Wanted(beam, [], asked.names, load, law, bounds, *given)
    kind, why = prepare.kind(joint, wanted)
    wanted = wanted._replace(specimens=records.read(data, beam, load), ends=prepare.ends(kind, wanted, ends))
    try:
        made = prepare.prepared(kind, wanted)
    except InputError as error:
        if joint is not None or kind == "hinge" or ends not in (None, ENDLESS) or beam.other or pushed:
            raise
        wanted = wanted._replace(ends=ENDLESS)
        made, kind, why = prepare.prepared("hinge", wanted), "hinge", f"on the compliant joint: {error}"
    prepare.enough(made)
    try:
        shared = selection.find(made, starts, candidates)
    except InputError:
        if not (cause := prepare.wrong_unit(made)):
            raise
        # the wrong unit is the cause of the first error
        refuse("data", "", f"no fit is found: {cause}")
    # no rival for a model whose residuals are rounding
    exact = shared.square <= selection.rounding(made, made.used[2])
    rival = None if exact else _rival("hinge" if kind == "compliant" else "compliant", wanted, shared)
    found = shared
    if own:
        if len(made.points.readings.words) < 2:
            remedy = "leave it out, or give a record of several loops or specimens"
            refuse("each", "", "the record is of one loop", remedy)
        found = groups.apart(made, shared, own, candidates)
    if dimensions:
        made, found = known.tolerated(made, found, wanted)
    result = _result(made, found, shared, wanted, rival, why)
    return replace(result, posterior=sample(made, found, samples, seed)) if samples else result


def _each(given: Sequence[str] | str, names: tuple[str, ...], samples: int) -> tuple[str, ...]:
    """Return the checked names of parameters with a value for each loop or specimen."""
    each = tuple(named(given, PARAMETERS)) if given else ()
    if unknown := [name for name in each if name not in names]:
        refuse("each", "", f"{unknown[0]} is not to be found (found are: {', '.join(names)})", "find it too")
    if each and samples:
        refuse("posterior", str(samples), "no samples are drawn where loops have values of their own", "leave one out")
    return each


def _rival(joint: str, wanted: Wanted, found: Found) -> Rival | None:
    """Fit the other model to the same points; None where it does not cover the case, or comes nowhere near."""
    alone = {"theta0"} if TESTS[wanted.load].sided else {"theta0", "C_f"}
    if wanted.part or wanted.beam.other or wanted.law != "edge" or alone & {*wanted.names}:
        return None
    try:
        if joint == "compliant" and not choice.known(wanted.beam):
            refuse("joint", "", "needs finite elements", f'ask for it by joint="{joint}"')
        made = prepare.prepared(joint, wanted)
        usable = made.usable & found.used
        # at reversals the models differ in a few points
        if np.count_nonzero(usable) < _MOST * np.count_nonzero(found.used):
            refuse("data", "", f"{np.count_nonzero(found.used & ~usable)} of the points are not covered")
        made = made._replace(usable=usable)
        prepare.enough(made)
        if not selection.comes_near(made, found.added, _HOPELESS * found.rms):
            return None
        # searching nuisances for compliant joints anew takes longer than the fit
        candidates = found.added if joint == "hinge" else wanted.candidates
        other = selection.find(made, min(wanted.starts, 3), candidates)
    except InputError as error:
        return Rival(joint, None, str(error))
    return Rival(joint, other, "")


def _result(made: Prepared, found: Found, shared: Found, wanted: Wanted, rival: Rival | None, why: str) -> Fit:
    """Return the result of a fit; ``shared``: all groups together, ``why``: reason for a model not the default."""
    rec, points, asked = made.record, made.points, found.asked
    at, beam = asked.physical(found.estimates), asked._replace(beam=wanted.beam).fitted(found.estimates)
    touching, covered = points.touching(at), made.usable | (rec.stuck & rec.asked)
    branch = np.where(touching, np.where(rec.way > 0, "loading", "unloading"), "straight")
    branch = np.where((rec.stuck | (made.usable & ~found.used)) & touching, "stick", branch)
    branch = np.where(found.stray, "stray", branch)
    band = estimate.standard_error(found.points, asked, found.estimates, found.covariance)
    fitted = np.where(covered, estimate.modelled(points, asked, found.estimates), np.nan)
    senses, remedies, effect, loops = None, [], None, None
    if isinstance(points, Hinged) and found.parameters == shared.parameters:
        senses = hinge_cycles.senses(beam, asked.load, at.mu, wanted.law, 0.01)
        used = points.take(np.flatnonzero(found.used)).at(at)
        remedies = estimate.remedies(asked, found.estimates, senses, used, found.jacobian, found.noise)
    steep = slope(rec, points, found.used, at, prepare.bar(made), found.noise)
    if wanted.machine is None:
        effect = machines.unknown(found.points, found.used, asked, found.estimates, found.jacobian, found.deviations)
    if not asked.groups and len(rec.specimens) == 1:
        loops = groups.differing(made, shared, "mu")
    result = Fit(
        **(vars(found) | {"points": points}),
        beam=beam,
        initial=asked.beam,
        load=asked.load,
        law=wanted.law,
        record=rec,
        given_noise=wanted.noise is not None,
        residuals=rec.torque - fitted,
        fitted=fitted,
        band=np.where(covered, band, np.nan),
        branch=np.where(covered, branch, "beyond"),
        specimens=_specimens(made, shared),
        remedies=tuple(remedies),
        rival=rival,
        disagreement=remarks.disagreement(found, rival),
        slope=steep,
        ends=points.ends if isinstance(points, Walked) else ENDLESS,
        row=_row(made, found, beam) if wanted.ends == ENDLESS else None,
        endless=_endless(made, shared),
        loops=loops,
        machine=effect,
    )
    notes = (*([why] if why else []), *remarks.notes(result, senses))
    return replace(result, notes=notes, doubts=tuple(remarks.doubts(result, machine=wanted.machine is not None)))


def _endless(made: Prepared, found: Found) -> Alone | None:
    """Fit the endless beam to the points of a fit with ends; None where the fit is of the endless beam."""
    points = made.points
    if not isinstance(points, Walked) or points.kind is None:
        return None
    return _alone(ENDLESS, made._replace(usable=found.used, points=points.endless()), found)


def _specimens(made: Prepared, found: Found) -> tuple[Alone, ...]:
    """Fit each of several specimens alone."""
    rec = made.record
    if len(rec.specimens) == 1:
        return ()
    own = made._replace(points=found.points)
    labels = enumerate(s.label for s in rec.specimens)
    return tuple(_alone(label, own._replace(usable=found.used & (rec.specimen == i)), found) for i, label in labels)


def _alone(label: str, made: Prepared, found: Found) -> Alone:
    """Fit some of the points of a fit, or all of them with another model, from its estimates."""
    made = made._replace(asked=found.asked)
    try:
        prepare.enough(made)
        one = selection.settle(made, found.estimates)
    except InputError as error:
        return Alone(label, None, None, problem=str(error))
    return Alone(label, one.estimates, one.deviations, one.rms, "", one.rows)


def _row(made: Prepared, found: Found, beam: Beam) -> Ends | None:
    """Compare the fitted beam's number of scales with the endless beam at the farthest point; None where unknown."""
    if beam.scales is None or not TESTS[made.asked.load].sided or beam.friction.mu is None:
        return None
    load = made.record.load[found.used & made.points.touching(found.asked.physical(found.estimates))]
    if not load.size:
        return None
    far, hinged = float(max(load, key=abs)), isinstance(made.points, Hinged)
    joint = "hinge" if hinged else "compliant"
    return finite_rows.ends(beam, abs(far) / beam.pitch, sense="-" if far < 0 else "+", joint=joint, ideal=hinged)

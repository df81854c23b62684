"""The doors of one load: from a beam and arguments in words and units to a dataset; twist and bend.

``respond`` gives the answer before it is a dataset, ``solved`` the path that is drawn; ``analysis`` reads the arguments
that all doors have in common.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, TypedDict, Unpack

import numpy as np
from numpy.typing import ArrayLike

from squama import arguments
from squama.beam.design import Beam
from squama.beam.faces import only_one
from squama.curves import both_faces, labelled
from squama.curves.chosen import MODELS, chosen
from squama.curves.labelled import Answer
from squama.curves.way import Analysis, Solved, States, Way
from squama.errors import naming, refuse
from squama.loads import (
    COUPLE,
    ENDLESS,
    ENDS,
    GRIPPED,
    LOADS,
    MANY_SCALES,
    EndsName,
    JointName,
    LawName,
    LineName,
    Load,
    SenseName,
)
from squama.types import Array
from squama.units import shown

if TYPE_CHECKING:
    import xarray as xr

Rates = ArrayLike | Sequence[float | str] | str
"""Rates in rad/m, or texts with their units."""


class How(TypedDict, total=False):
    """Arguments that all doors have, as of :func:`twist`."""

    mu: ArrayLike | None
    law: str
    margin: float
    joint: str | None
    ideal: bool | None
    neutral: str | None
    hold: str | None


def twist(
    beam: Beam,
    *,
    mu: ArrayLike | None = None,
    law: LawName = "edge",
    margin: float = 0.01,
    points: int = 200,
    at: Rates | None = None,
    to: float | str | None = None,
    sense: SenseName = "+",
    joint: JointName | None = None,
    ideal: bool | None = None,
    neutral: LineName | None = None,
    hold: str | None = None,
    ends: EndsName | None = None,
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
        "edge" (satisfies virtual work) or "plate" (the paper's: the hinge, thin and rigid scales).
    margin
        Where a hinge's curve that locks is cut off: the fraction of its path left before the lock (docs, theory:
        energy).
    points
        Number of points of a curve.
    at
        Twists (magnitudes, as ``to``) at which to give the response instead; NaN beyond the end of the curve.
    to
        Twist at which to stop: a rate in rad/m or text such as "5 rad/m", "0.2 rad/pitch", "90 deg total".
    sense
        "+" or "-": which way the beam is twisted. Twists are magnitudes.
    joint
        "compliant" (six motions of a scale against the substrate's stiffness; goes to ``to``, or if not given until a
        pitch twists by 0.3 rad, or to an earlier end) or "hinge" (the paper's closed form: a scale turns about its
        width against K_theta). Compliant if not given, where the law is "edge". See docs, which model.
    ideal
        Take the scales as thin and rigid, as in the paper (True), or as thick as the beam says and, on the compliant
        joint where their modulus is known, elastic (False). By default only the hinge's are ideal:
        ``joint="hinge", ideal=True`` is the paper's model.
    neutral
        "free" (there is no axial force: the default) or "middle" (the bar keeps its length), in place of the beam's own
        ``substrate.neutral``; of the compliant joint.
    hold
        Strains that a guide holds, in place of the beam's own ``hold``: some of "bend", "lateral bend", "stretch"
        ("bend, stretch"), or "straight" for all; "nothing", the default, lets a beam under a torque bow. Of the
        compliant joint: hinges are held straight.
    ends
        Of a beam with a number of scales, whose end scales lack a neighbour, in place of its own ``ends``: "free" (the
        default), one torque about the axis of each cell, which has its own twist, bend and stretch; "couple": a couple
        at both ends, which may shift and tilt, of up to 60 scales; "gripped": the ends stay on one axis, half a pitch
        beyond the first and last scale, and may come nearer, of up to 60 scales; "equal": all cells have the same
        strains; "endless": the beam without ends, the default for more than 200 scales, on
        hinges, with scales on both faces, and of a beam without a number of scales.

    Returns
    -------
    xarray.Dataset
        Dimension ``point`` (and ``mu``); variables named as in ``squama.SYMBOLS``, SI units and radians; single
        figures of the curve such as ``phi_e``, ``phi_end``, ``end``, ``RED_c``; beam, law, margin and version in the
        attributes. A curve of the compliant joint goes on through every contact that comes in: ``N``, ``f`` are sums
        over all contacts, ``p``, ``s``, ``slip`` of the first one, ``phi_second`` and ``other_contact`` describe the
        second, ``W_snap`` is the energy that jumps of the scales lose, ``phi_bent`` where a scale is bent beyond the
        plate model (docs, theory: contact). ``psi``, ``chi``, ``stretch`` are the bend, lateral bend and stretch per
        pitch, ``M``, ``M_lat``, ``P`` the loads that hold them, 0 where they are free. With scales on both faces loads
        and energies are the beam's, figures of a scale those of the face that touches first; ``theta_other``,
        ``N_other``, ``stress_other`` and the like, and ``phi_e_other``, are of the other one. ``phi_strength`` and
        ``phi_strain`` are of the face that comes there first.

        A beam with a number of scales has its twist and torque at its ends; figures of a scale (``theta``, ``N``,
        ``stress`` and the like) have the dimension ``scale``, 1 to N, and so have the cells' strains ``phi_cell``,
        ``psi_cell``, ``chi_cell``, ``stretch_cell``, their loads (``T_cell`` and the like, where they are not zero),
        and the moment ``Q`` by which the substrate lifts a scale that lies on it; ``psi`` and the like are means.
        ``T_periodic`` and ``theta_periodic`` are of the endless beam; ``decay`` is the share of an end's effect that is
        left one scale further on, ``scale_end`` where another contact comes in first.

    Raises
    ------
    InputError
        An argument is out of range.

    Examples
    --------
    >>> import squama
    >>> beam = squama.Beam.from_ratios(eta=3, beta=1.25, lam=0.45, alpha="45 deg", theta0="10 deg")
    >>> r = squama.twist(beam, mu=0.5, joint="hinge", ideal=True)
    >>> print(r.end.item(), f"at {float(r.phi_end):.4f} rad per pitch, RED = {float(r.RED_c):.3f}")
    frictional lock at 0.2691 rad per pitch, RED = 0.740
    """
    how = How(mu=mu, law=law, margin=margin, joint=joint, ideal=ideal, neutral=neutral, hold=hold)
    return respond(beam, "twisting", points=points, at=at, to=to, sense=sense, ends=ends, **how).dataset()


def bend(
    beam: Beam,
    *,
    mu: ArrayLike | None = None,
    margin: float = 0.01,
    points: int = 200,
    at: Rates | None = None,
    to: float | str | None = None,
    joint: JointName | None = None,
    ideal: bool | None = None,
    neutral: LineName | None = None,
    hold: str | None = None,
    ends: EndsName | None = None,
) -> xr.Dataset:
    """Bend a beam towards its scales: moment, inclination, forces and energies to the end of the curve.

    Thick, elastic scales on the compliant joint by default, as :func:`twist`: the way along the bend alone of
    :func:`squama.bend_twist`.

    Parameters
    ----------
    beam, mu, margin, points
        As in :func:`twist`. In the plane the two force laws coincide.
    at
        Curvatures (as ``to``) at which to give the response instead; NaN beyond the end of the curve.
    to
        Curvature at which to stop: rad/m or text such as "5 rad/m", "0.2 rad/pitch", "90 deg total".
    joint
        "compliant" (the joint's nine motions; goes to ``to``, or if not given until a pitch bends by 0.3 rad)
        or "hinge" (closed form); "hinge" if not given where ``neutral="face"`` means it, or where the joint is
        not known in bend (a warning says so).
    ideal
        Thin, rigid scales, as in :func:`twist`; the hinge has no others here.
    neutral
        Which line of the bar keeps its length, in place of the beam's own (``substrate.neutral``): "free" (none, there
        is no axial force: the compliant joint's default) or "middle"; on the hinge "middle" (the default) or "face"
        (that of the scales, as the paper's theory of bending takes it).
    hold
        As in :func:`twist`, of "twist", "lateral bend", "stretch": by default a beam under a moment is free to twist.
    ends
        As in :func:`twist`, without "gripped": moments at both ends.

    Returns
    -------
    xarray.Dataset
        As from :func:`twist`, with ``kappa``, ``psi`` and ``M`` in place of ``Phi``, ``phi`` and ``T``; ``phi`` is the
        twist of a beam of oblique scales that is free to, ``T`` the torque that holds it else, ``contact`` what touches
        (docs, theory: bending and twisting), ``r`` its distance from the base of the other scale; ``M_periodic`` in
        place of ``T_periodic``. Attributes: ``joint``, ``scales``, ``neutral``, ``ends``.

    Raises
    ------
    InputError
        An argument is out of range.

    Examples
    --------
    >>> import squama
    >>> m = squama.bend(squama.Beam.from_ratios(eta=5, theta0="5 deg", alpha=0), mu=0.3, neutral="face")
    >>> print(m.end.item(), f"at {float(5 * m.psi_end):.5f} / eta")
    frictional lock at 0.96228 / eta
    """
    how = How(mu=mu, margin=margin, joint=joint, ideal=ideal, neutral=neutral, hold=hold)
    return respond(beam, "bending", points=points, at=at, to=to, ends=ends, **how).dataset()


def respond(
    beam: Beam,
    load: str,
    *,
    points: int = 200,
    at: Rates | None = None,
    to: float | str | None = None,
    sense: str = "+",
    ends: str | None = None,
    row: bool = False,
    **how: Unpack[How],
) -> Answer:
    """Return what :func:`twist` or :func:`bend` returns, before it is a dataset; ``row``: with ends, on hinges too."""
    arguments.beam(beam)
    kind = arguments.load(load)
    sign = arguments.sense(sense) if kind.sided else 1
    way = Way.of(load, [sign * (math.inf if to is None else far(to, kind, beam.pitch, beam.pitches))])
    loads = None if at is None else _angles(at, kind, beam)
    asked = analysis(beam, way, kind, points=points, most=1e6, family=True, **how)
    return _curves(asked._replace(at=loads, ends=ends_of(asked, ends, row=row)))


def ends_of(asked: Analysis, word: str | None, *, history: bool = False, row: bool = False, grips: bool = True) -> str:
    """Return the ends of a beam by their word, or as they are by default; refuse what a model does not know.

    ``history``: of one that is loaded and unloaded, or along several loads; ``row``: it has ends even where it is
    endless by default; ``grips``: whether there may be a couple, of one load alone, or grips, of a beam that is
    twisted alone.
    """
    beam, model = asked.beam, MODELS[asked.joint]
    couple = grips and len(asked.way.loaded) == 1
    may = {COUPLE: couple, GRIPPED: couple and asked.way.loaded == (LOADS["twisting"].verb,)}
    known = [end for end in model.ends if may.get(end, True)]
    if history and model.straight:
        known = [ENDLESS]
    own = beam.ends if beam.ends in known else known[0]
    if word is None and not row:
        return ENDLESS if beam.scales is None or beam.scales > MANY_SCALES or beam.other else str(own)
    if word is None:
        word = "equal" if own == ENDLESS else own
    if word not in ENDS:
        refuse("ends", shown(word), f"must be one of {', '.join(map(shown, ENDS))}", f'write e.g. ends="{known[0]}"')
    if word == ENDLESS:
        return word
    if beam.scales is None:
        refuse("ends", shown(word), "needs a number of scales, and this beam is endless", "write scales=25")
    if word not in known:
        why = f"is not known of {'a row on hinges' if model.straight else 'a beam that is loaded so'}"
        refuse("ends", shown(word), why, f'leave it out, or write ends="{known[0]}"')
    only_one(beam.faces, "a beam with ends")
    return word


def analysis(
    beam: Beam,
    way: Way,
    load: Load | None,
    *,
    points: int,
    most: float = 1e5,
    family: bool = False,
    free: str | None = None,
    **how: Unpack[How],
) -> Analysis:
    """Return the analysis of a beam on a way: its arguments checked, and the model that answers.

    ``load`` and ``free`` as of :func:`squama.curves.chosen.chosen`; ``most`` points are allowed; ``family``: there may
    be several coefficients of friction.
    """
    asked, mu, own = how.get("law", "edge"), how.get("mu"), beam.friction.mu
    arguments.law(asked)
    law = load.law(asked) if load else asked
    mus = arguments.frictions(own, mu) if family else np.asarray(arguments.friction(own, mu))
    margin, points = arguments.margin(how.get("margin", 0.01)), arguments.whole("points", points, 3, most)
    held = arguments.held_by(beam, how.get("hold"))
    joint, ideal, neutral = how.get("joint"), how.get("ideal"), how.get("neutral")
    means = chosen(held, load, law=law, joint=joint, ideal=ideal, neutral=neutral, free=free)
    return Analysis(means.beam, way, mus, law, margin, points, None, means.ideal, means.note, means.joint)


def far(to: float | str, load: Load, pitch: float, scales: int) -> float:
    """Return the load angle per pitch, above 0, at which to stop."""
    with naming("to"):
        stop = load.read(to, pitch=pitch, scales=scales) * pitch
    if stop <= 0:
        refuse("to", f"{stop / pitch:.6g} rad/m", "must be above 0", "twist the other way with sense")
    return stop


def _angles(at: Rates, load: Load, beam: Beam) -> Array:
    """Return load angles per pitch of rates in rad/m, or of texts such as "0.2 rad/pitch" among them."""
    given = [at] if isinstance(at, str) else at
    if isinstance(given, list | tuple) and any(isinstance(value, str) for value in given):
        with naming("at"):
            at = [load.read(value, pitch=beam.pitch, scales=beam.pitches) for value in given]
    loads = np.atleast_1d(arguments.not_negative("at", at)) * beam.pitch
    if loads.ndim != 1:
        refuse("at", "", f"must be one number or a sequence of numbers, not an array of shape {loads.shape}")
    return loads


def solved(analysis: Analysis) -> tuple[Solved, Sequence[str]]:
    """Return the path of a beam in one sense, which `squama.view` and the explorer go along, and its warnings.

    Of hinges on both faces that of the scaled one alone.
    """
    found, more = MODELS[analysis.joint].programs().solve(analysis)
    return found[0], more.notes


def _curves(analysis: Analysis) -> Answer:
    """Follow a way in one sense: a curve for each coefficient of friction."""
    way, programs = analysis.way, MODELS[analysis.joint].programs()
    one_face, more = programs.solve(analysis)
    found = programs.gather(analysis, one_face)
    curves = [path.curve(points=analysis.points, at=analysis.at) for path in found]
    family = ("mu",) * analysis.mus.ndim

    def stack(values: Sequence[object]) -> Array:
        return np.stack([np.asarray(v) for v in values]) if family else np.asarray(values[0])

    along = {role: stack([c.along[role] for c in curves]) for role in curves[0].along}
    figures = {role: stack([c.figures[role] for c in curves]) for role in curves[0].figures}
    each = {role: stack([c.each[role] for c in curves]) for role in curves[0].each}
    by_dim, attrs = {(*family, "point"): along, family: figures}, dict(more.attrs)
    if each:
        by_dim[(*family, "point", "scale")], attrs["ends"] = each, analysis.ends
    if way.load.sided:
        by_dim.setdefault((), {})["phi_e_small"] = np.asarray(_small(analysis.beam, way.sign))
        attrs["sense"] = way.sense
    title = f"{way.load.name} of a scale-covered beam"
    notes = [*more.notes, *dict.fromkeys(note for curve in curves for note in curve.notes)]
    states = States(by_dim, attrs, notes)
    answer = labelled.answer(analysis, states, title, {"mu": analysis.mus.tolist()}, sense=way.sense)
    answer.over = way.load.rate, way.load.angle
    return answer


def _small(beam: Beam, sign: int) -> float:
    """Twist per pitch at engagement by the paper's formula for small angles."""
    alpha = beam.scale.alpha
    # with scales on both faces that of the one whose scales touch first
    signs = {sign, sign * (both_faces.sense(beam, "twisting") or 1)}
    slope = max(s * (beam.eta * math.tan(alpha) - math.sin(alpha)) + beam.beta for s in signs)
    return beam.scale.theta0 / slope if slope > 0 else math.inf

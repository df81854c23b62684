"""Public functions of a single load, from arguments in words and units to a dataset: twist and bend.

``respond`` returns the result before it is a dataset; ``analysis`` reads the arguments common to all public functions.
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
from squama.curves.way import Analysis, States, Way
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
"""Rates in rad/m, or text with units."""


class How(TypedDict, total=False):
    """Arguments common to all public functions, as in :func:`twist`."""

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
        "compliant" (default with law "edge"): a scale moves in six directions against the substrate's stiffness; the
        curve ends at ``to``, or without it where a pitch twists by 0.3 rad, or earlier. "hinge": the paper's closed
        form, in which a scale turns about its width against K_theta. See docs, which model.
    ideal
        True: thin, rigid scales, as in the paper. False: scales of the beam's thickness, which are elastic on the
        compliant joint if they have a modulus. The default is True on hinges, False else; ``joint="hinge", ideal=True``
        is the paper's model.
    neutral
        "free" (default: no axial force) or "middle" (the bar keeps its length), in place of the beam's
        ``substrate.neutral``; for the compliant joint.
    hold
        Strains held by a guide, in place of the beam's ``hold``: some of "bend", "lateral bend", "stretch" ("bend,
        stretch"), "straight" for all, or "nothing" (default), so that a twisted beam bows. For the compliant joint; a
        beam on hinges is always held straight.
    ends
        Ends of a beam with a number of scales, in place of its ``ends``; its end scales lack a neighbour. "free"
        (default): the same torque about the axis of each cell, which has its own twist, bend and stretch. "couple": a
        couple at both ends, which may shift and tilt; up to 60 scales. "gripped": the ends stay on one axis, half a
        pitch beyond the first and last scale, and may approach each other; up to 60 scales. "equal": all cells have the
        same strains. "endless": no ends, the default for more than 200 scales, on hinges, and without a number of
        scales.

    Returns
    -------
    xarray.Dataset
        Dimension ``point`` (and ``mu``); variables named as in ``squama.SYMBOLS``, SI units and radians; single
        figures of the curve such as ``phi_e``, ``phi_end``, ``end``, ``RED_c``; beam, law, margin and version in the
        attributes. A curve of the compliant joint continues through every new contact: ``N`` and ``f`` are sums
        over all contacts, ``p``, ``s``, ``slip`` of the first one, ``phi_second`` and ``other_contact`` describe the
        second, ``W_snap`` is the energy that jumps of the scales lose, ``phi_bent`` where a scale is bent beyond the
        plate model (docs, theory: contact). ``psi``, ``chi``, ``stretch`` are the bend, lateral bend and stretch per
        pitch, ``M``, ``M_lat``, ``P`` the loads that hold them, 0 where they are free. With scales on both faces loads
        and energies are the beam's, variables of a scale those of the face that touches first; ``theta_other``,
        ``N_other``, ``stress_other``, ``phi_e_other`` and the like are those of the other face. ``phi_strength`` and
        ``phi_strain`` are those of the face that reaches its limit first.

        For a beam with N scales twist and torque are those at its ends; variables of a scale (``theta``, ``N``,
        ``stress`` and the like) have the dimension ``scale``, 1 to N, and so have the cells' strains ``phi_cell``,
        ``psi_cell``, ``chi_cell``, ``stretch_cell``, their loads (``T_cell`` and the like, where they are not zero),
        and the moment ``Q`` by which the substrate lifts a scale that lies on it; ``psi`` and the like are means.
        ``T_periodic`` and ``theta_periodic`` are the endless beam's; ``decay`` is the share of an end's effect that is
        left one scale further on, ``scale_end`` the scale at which another contact comes in first.

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
    """Bend a beam towards its scales: moment, inclination, forces and energies from no load to the end of the curve.

    The default model has thick, elastic scales on compliant joints, as :func:`twist`; a bend is the path of
    :func:`squama.bend_twist` along the bend alone.

    Parameters
    ----------
    beam, mu, margin, points
        As in :func:`twist`. In the plane the two force laws coincide.
    at
        Curvatures (as ``to``) at which to give the response instead; NaN beyond the end of the curve.
    to
        Curvature at which to stop: rad/m or text such as "5 rad/m", "0.2 rad/pitch", "90 deg total".
    joint
        "compliant": nine motions of the joint; the curve ends at ``to``, or without it where a pitch bends by 0.3 rad.
        "hinge": the closed form; the default with ``neutral="face"``, and where the joint's stiffness in bending is
        unknown (with a warning).
    ideal
        Thin, rigid scales, as in :func:`twist`; in bending hinges have no other scales.
    neutral
        Line of the bar that keeps its length, in place of the beam's ``substrate.neutral``: "free" (none: no axial
        force; default of the compliant joint) or "middle"; on hinges "middle" (default) or "face" (that of the scales,
        as in the paper's theory of bending).
    hold
        Held strains as in :func:`twist`, some of "twist", "lateral bend", "stretch"; by default a bent beam is free to
        twist.
    ends
        As in :func:`twist`, without "gripped": moments at both ends.

    Returns
    -------
    xarray.Dataset
        As from :func:`twist`, with ``kappa``, ``psi`` and ``M`` in place of ``Phi``, ``phi`` and ``T``. For oblique
        scales ``phi`` is the twist of the beam, or ``T`` the torque that prevents it. ``contact`` names the pair in
        contact (docs, theory: bending and twisting), ``r`` is its distance from the base of the other scale;
        ``M_periodic`` replaces ``T_periodic``. Attributes: ``joint``, ``scales``, ``neutral``, ``ends``.

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
    """Return the result of :func:`twist` or :func:`bend` before it is a dataset; ``row``: with ends also on hinges."""
    arguments.beam(beam)
    kind = arguments.load(load)
    sign = arguments.sense(sense) if kind.sided else 1
    way = Way.of(load, [sign * (math.inf if to is None else far(to, kind, beam.pitch, beam.pitches))])
    loads = None if at is None else _angles(at, kind, beam)
    asked = analysis(beam, way, kind, points=points, most=1e6, family=True, **how)
    return _curves(asked._replace(at=loads, ends=ends_of(asked, ends, row=row)))


def ends_of(asked: Analysis, word: str | None, *, history: bool = False, row: bool = False, grips: bool = True) -> str:
    """Return the ends of a beam from their word, or the default; refuse ends that the model does not cover.

    ``history``: for loading and unloading, or several loads; ``row``: with ends even where the default is endless;
    ``grips``: whether a couple (under a single load) and grips (in twisting alone) are allowed.
    """
    beam, model = asked.beam, MODELS[asked.joint]
    couple = grips and len(asked.way.loaded) == 1
    may = {COUPLE: couple, GRIPPED: couple and asked.way.loaded == (LOADS["twisting"].verb,)}
    known = [end for end in model.ends if may.get(end, True)]
    if model.straight and (history or asked.way.loaded != (LOADS["twisting"].verb,)):
        known = [ENDLESS]
    own = beam.ends if beam.ends in known else known[0]
    if word is None and not row:
        return ENDLESS if beam.scales is None or beam.scales > MANY_SCALES else str(own)
    if word is None:
        word = "equal" if own == ENDLESS else own
    if word not in ENDS:
        refuse("ends", shown(word), f"must be one of {', '.join(map(shown, ENDS))}", f'write e.g. ends="{known[0]}"')
    if word == ENDLESS and row:
        other = next(end for end in known if end != ENDLESS)
        refuse("ends", shown(word), "has no row of scales", f'leave it out, or write ends="{other}"')
    if word == ENDLESS:
        return word
    if beam.scales is None:
        remedy = "write scales = 25 under [beam]"
        refuse("ends", shown(word), "needs a number of scales, and this beam is endless", remedy)
    if word not in known:
        why = f"is not known of {'a row on hinges' if model.straight else 'a beam that is loaded so'}"
        refuse("ends", shown(word), why, f'leave it out, or write ends="{known[0]}"')
    if model.straight:
        only_one(beam.faces, "a beam with ends on hinges")
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
    """Return the analysis of a beam along a way: its checked arguments, and the chosen model.

    ``load`` and ``free`` as in :func:`squama.curves.chosen.chosen`; ``most``: largest number of points; ``family``:
    whether several coefficients of friction are allowed.
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
    """Return the load angle per pitch (rad), above 0, at which the curve stops."""
    with naming("to"):
        stop = load.read(to, pitch=pitch, scales=scales) * pitch
    if stop <= 0:
        refuse("to", f"{stop / pitch:.6g} rad/m", "must be above 0", "twist the other way with sense")
    return stop


def _angles(at: Rates, load: Load, beam: Beam) -> Array:
    """Return load angles per pitch (rad) from rates in rad/m, or from text such as "0.2 rad/pitch" among them."""
    given = [at] if isinstance(at, str) else at
    if isinstance(given, list | tuple) and any(isinstance(value, str) for value in given):
        with naming("at"):
            at = [load.read(value, pitch=beam.pitch, scales=beam.pitches) for value in given]
    loads = np.atleast_1d(arguments.not_negative("at", at)) * beam.pitch
    if loads.ndim != 1:
        refuse("at", "", f"must be one number or a sequence of numbers, not an array of shape {loads.shape}")
    return loads


def _curves(analysis: Analysis) -> Answer:
    """Return a curve along a way in one sense for each coefficient of friction."""
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
    """Return the twist per pitch at engagement by the paper's formula for small angles."""
    alpha = beam.scale.alpha
    # with scales on both faces the twist of the face that touches first
    signs = {sign, sign * (both_faces.sense(beam, "twisting") or 1)}
    slope = max(s * (beam.eta * math.tan(alpha) - math.sin(alpha)) + beam.beta for s in signs)
    return beam.scale.theta0 / slope if slope > 0 else math.inf

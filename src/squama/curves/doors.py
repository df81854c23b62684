"""The doors: from a beam and what is asked of it in words and units to a dataset; twist, bend and cycle.

Each makes a load path and hands it to :mod:`squama.curves.follow`. ``respond`` and ``cycled`` give the answer before it
is a dataset.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from squama import arguments
from squama.beam.design import Beam
from squama.curves import follow
from squama.curves.chosen import chosen
from squama.curves.given_history import items, read, repeated
from squama.curves.labelled import Answer
from squama.curves.path import Asked, LoadPath
from squama.errors import naming, refuse
from squama.loads import LOADS, Load

if TYPE_CHECKING:
    import xarray as xr

MOST = 1_000_000
"""Most points of a history."""
Rates = ArrayLike | Sequence[float | str] | str
"""Rates in rad/m, or texts with their units."""


def twist(
    beam: Beam,
    *,
    mu: ArrayLike | None = None,
    law: str = "edge",
    margin: float = 0.01,
    points: int = 200,
    at: Rates | None = None,
    to: float | str | None = None,
    sense: str = "+",
    joint: str | None = None,
    ideal: bool | None = None,
    neutral: str | None = None,
    hold: str | None = None,
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
        "compliant" (six motions of a scale against the substrate's stiffness; goes to ``to``, 0.3 rad per pitch if not
        given, or to an earlier end) or "hinge" (the paper's closed form: a scale turns about its width against
        K_theta). Compliant if not given, where the law is "edge". See docs, which model.
    ideal
        Take the scales as thin and rigid, as in the paper (True), or as thick as the beam says and, on the compliant
        joint where their modulus is known, elastic (False). By default only the hinge's are ideal:
        ``joint="hinge", ideal=True`` is the paper's model.
    neutral
        "free" (there is no axial force: the default) or "middle" (the bar keeps its length), in place of the beam's own
        ``substrate.neutral``; of the compliant joint.
    hold
        What is held, in place of the beam's own ``hold``: some of "bend", "lateral bend", "stretch" ("bend, stretch"),
        or "straight" for all; "nothing", the default, lets a beam under a torque bow. Of the compliant joint: hinges
        are held straight.

    Returns
    -------
    xarray.Dataset
        Dimension ``point`` (and ``mu``); variables named as in :data:`squama.SYMBOLS`, SI units and radians; single
        figures of the curve such as ``phi_e``, ``phi_end``, ``end``, ``RED_c``; beam, law, margin and version in the
        attributes. The real beam goes on through every contact that comes in: ``N``, ``f`` are sums over all contacts,
        ``p``, ``s``, ``slip`` of the first one, ``phi_second`` and ``other_contact`` tell the second one, ``W_snap``
        the energy that jumps of the scales lose, ``phi_bent`` where a scale is bent beyond the plate model (docs,
        theory: contact). ``psi``, ``chi``, ``stretch`` are the bend, lateral bend and stretch per pitch, ``M``,
        ``M_lat``, ``P`` what holds them, 0 where they are free. With scales on both faces loads and energies are the
        beam's, what is told of a scale is of the face that touches first; ``theta_other``, ``N_other``,
        ``stress_other`` and the like, and ``phi_e_other``, are of the other one. ``phi_strength`` and ``phi_strain``
        are of the face that comes there first.

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
    arguments.beam(beam)
    return respond(
        beam,
        "twisting",
        mu=mu,
        law=law,
        margin=margin,
        points=points,
        at=at,
        to=to,
        sense=sense,
        ideal=ideal,
        joint=joint,
        neutral=neutral,
        hold=hold,
    ).dataset()


def bend(
    beam: Beam,
    *,
    mu: ArrayLike | None = None,
    margin: float = 0.01,
    points: int = 200,
    at: Rates | None = None,
    to: float | str | None = None,
    joint: str | None = None,
    ideal: bool | None = None,
    neutral: str | None = None,
    hold: str | None = None,
) -> xr.Dataset:
    """Bend a beam towards its scales: moment, inclination, forces and energies to the end of the curve.

    The real beam by default, as :func:`twist`: the way along the bend alone of :func:`squama.bend_twist`.

    Parameters
    ----------
    beam, mu, margin, points
        As in :func:`twist`. In the plane the two force laws coincide.
    at
        Curvatures (as ``to``) at which to give the response instead; NaN beyond the end of the curve.
    to
        Curvature at which to stop: rad/m or text such as "5 rad/m", "0.2 rad/pitch", "90 deg total".
    joint
        "compliant" (the joint's nine motions; goes to ``to``, 0.3 rad per pitch if not given) or "hinge" (closed form);
        "hinge" if not given where ``neutral="face"`` means it, or where the joint is not known in bend (a warning says
        so).
    ideal
        Thin, rigid scales, as in :func:`twist`; the hinge has no others here.
    neutral
        Which line of the bar keeps its length, in place of the beam's own (``substrate.neutral``): "free" (none, there
        is no axial force: the compliant joint's default) or "middle"; on the hinge "middle" (the default) or "face"
        (that of the scales, as the paper's theory of bending takes it).
    hold
        As in :func:`twist`, of "twist", "lateral bend", "stretch": by default a beam under a moment is free to twist.

    Returns
    -------
    xarray.Dataset
        As from :func:`twist`, with ``kappa``, ``psi`` and ``M`` in place of ``Phi``, ``phi`` and ``T``; ``phi`` is the
        twist of a beam of oblique scales that is free to, ``T`` the torque that holds it else, ``contact`` what touches
        (docs, theory: bending and twisting), ``r`` its distance from the base of the other scale. Attributes:
        ``joint``, ``scales``, ``neutral``.

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
    arguments.beam(beam)
    return respond(
        beam, "bending", mu=mu, margin=margin, points=points, at=at, to=to, joint=joint, ideal=ideal, neutral=neutral,
        hold=hold,
    ).dataset()  # fmt: skip


def respond(
    beam: Beam,
    load: str,
    *,
    mu: ArrayLike | None = None,
    law: str = "edge",
    margin: float = 0.01,
    points: int = 200,
    at: Rates | None = None,
    to: float | str | None = None,
    sense: str = "+",
    joint: str | None = None,
    ideal: bool | None = None,
    neutral: str | None = None,
    hold: str | None = None,
) -> Answer:
    """Return what :func:`twist` or :func:`bend` returns, before it is a dataset."""
    kind, d = arguments.load(load), beam.pitch
    sign = arguments.sense(sense) if kind.sided else 1
    arguments.law(law)
    stop = math.inf if to is None else far(to, kind, beam.pitch, beam.scales)
    mus, margin = arguments.frictions(beam.friction.mu, mu), arguments.margin(margin)
    loads = None
    if at is not None:
        loads = np.atleast_1d(arguments.not_negative("at", _rates(at, load, beam))) * d
        if loads.ndim != 1:
            refuse("at", "", f"must be one number or a sequence of numbers, not an array of shape {loads.shape}")
    way = LoadPath.of(load, [sign * stop])
    points = arguments.whole("points", points, 3, 1e6)
    means = chosen(arguments.held_by(beam, hold), kind, law=kind.law(law), joint=joint, ideal=ideal, neutral=neutral)
    asked = Asked(means.beam, way, mus, kind.law(law), margin, points, loads, means.ideal, means.note)
    return follow.curves(asked, means.joint)


def far(to: float | str, load: Load, pitch: float, scales: int) -> float:
    """Return the load angle per pitch, above 0, at which to stop."""
    with naming("to"):
        stop = load.read(to, pitch=pitch, scales=scales) * pitch
    if stop <= 0:
        refuse("to", f"{stop / pitch:.6g} rad/m", "must be above 0", "twist the other way with sense")
    return stop


def _rates(at: Rates, load: str, beam: Beam) -> ArrayLike:
    """Return rates in rad/m where texts such as "0.2 rad/pitch" are given."""
    given = [at] if isinstance(at, str) else at
    if not isinstance(given, list | tuple) or not any(isinstance(value, str) for value in given):
        return at
    with naming("at"):
        return [LOADS[load].read(value, pitch=beam.pitch, scales=beam.scales) for value in given]


def cycle(
    beam: Beam,
    twist: float | str | Sequence[float | str],
    *,
    mu: float | None = None,
    law: str = "edge",
    load: str = "twisting",
    margin: float = 0.01,
    points: int = 60,
    loops: int = 1,
    joint: str | None = None,
    ideal: bool | None = None,
    hold: str | None = None,
) -> xr.Dataset:
    """Load and unload a beam through any history of twists: loops, stick intervals, dissipation, jamming.

    Parameters
    ----------
    beam
        The beam.
    twist
        Twists one after the other, from rest at 0: rates in rad/m or texts such as "0.2 rad/pitch", or one text as
        "0, 0.15, 0.05, 0.2, 0 rad/pitch". A single twist is gone to and back. Negative: the other sense. In bending
        curvatures, positive towards the scales.
    mu
        Coefficient of friction; the beam's own if not given.
    law
        "edge" (satisfies virtual work) or "plate" (the paper's); in bending they coincide.
    load
        "twisting" or "bending".
    margin
        How near to a lock a history may go: fraction of the path left.
    points
        Number of points in contact of each way between two twists; a straight part has a quarter of it.
    loops
        How many times the history is gone through.
    joint
        "compliant" or "hinge", as in :func:`squama.twist`, in bending as in :func:`bend`.
    ideal, hold
        Thin, rigid scales, and what is held, as in :func:`squama.twist`.

    Returns
    -------
    xarray.Dataset
        Dimension ``point``: ``branch`` (how the point was reached: "straight", "loading", "unloading", "stick"),
        ``leg``, ``phi``, ``Phi``, ``T``, ``T_scales``, ``K_t``, ``theta``, ``N``, ``f`` (negative while the twist
        falls), ``p``, ``s``, ``U_el``, ``W_fr`` (from the start on); every turning point twice, before and after the
        drop of torque. Dimension ``loop``, closed loops in the order in which they close: ``phi_base``, ``phi_top``,
        ``W_d``, ``U_max``, ``zeta_eq``, ``K_sec``, ``T_drop``, ``phi_residual``. Dimension ``sense``: ``phi_e``,
        ``phi_most``, ``phi_jam``, ``phi_end``, ``end``, ``other_contact``, ``neighbour``. In bending ``psi``,
        ``kappa``, ``M``, ``K_b``, ``r``. With the compliant joint every turning point stands once, "stick" are the
        points until the contact slides back, ``phi_most`` and ``phi_jam`` are not there, ``W_snap`` is;
        ``energy_error``: work that is neither stored, rubbed away nor lost in snaps, relative to W_fr.
        See docs, theory: cycles.

    Raises
    ------
    InputError
        An argument is out of range; the history goes beyond a lock, on hinges to a contact that is not followed, else
        to where no equilibrium is found; or the scales do not slide back on it.

    Examples
    --------
    >>> import squama
    >>> beam = squama.Beam.from_ratios(youngs_modulus="2 MPa")
    >>> c = squama.cycle(beam, "0, 0.2, 0 rad/pitch", mu=0.3, joint="hinge", ideal=True)
    >>> print(f"{float(c.W_d[0]):.3g} J/m a loop, damping ratio {float(c.zeta_eq[0]):.3f}")
    9.32 J/m a loop, damping ratio 0.043
    """
    arguments.beam(beam)
    return cycled(
        beam,
        twist,
        mu=mu,
        law=law,
        load=load,
        margin=margin,
        points=points,
        loops=loops,
        ideal=ideal,
        joint=joint,
        hold=hold,
    ).dataset()


def cycled(
    beam: Beam,
    twist: float | str | Sequence[float | str],
    *,
    mu: float | None = None,
    law: str = "edge",
    load: str = "twisting",
    margin: float = 0.01,
    points: int = 60,
    loops: int = 1,
    joint: str | None = None,
    ideal: bool | None = None,
    hold: str | None = None,
) -> Answer:
    """Return what :func:`cycle` returns, before it is a dataset."""
    kind = arguments.load(load)
    law = kind.law(arguments.law(law))
    m, margin = np.asarray(arguments.friction(beam.friction.mu, mu)), arguments.margin(margin)
    points = arguments.whole("points", points, 3, 1e5)
    once = read(twist, beam, load)
    ends = once[1:2] if len(once) == 3 and len(items(twist)) == 1 else once[::-1]
    typed = {v: text for v, text in zip(ends, items(twist)[::-1], strict=False) if isinstance(text, str)}
    values = repeated(once, arguments.whole("loops", loops, 1, 1e4))
    if len(values) * points > MOST:
        reason = f"{len(values)} twists of {points} points are too many"
        refuse("twist", "", reason, "ask for fewer points or loops")
    means = chosen(arguments.held_by(beam, hold), kind, law=law, joint=joint, ideal=ideal)
    way = LoadPath.of(load, values, typed)
    asked = Asked(means.beam, way, m, law, margin, points, ideal=means.ideal, note=means.note)
    return follow.cycles(asked, means.joint)

"""The door to bending and twisting at once: from a beam and a path in words and units to a dataset."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from squama import arguments
from squama.beam.design import Beam
from squama.beam.faces import only_one
from squama.curves import hinge_polygons, real_polygons
from squama.curves.chosen import chosen
from squama.curves.labelled import Answer, attributes, labelled
from squama.curves.path import VERBS, Asked, LoadPath
from squama.errors import naming, refuse
from squama.loads import LOADS
from squama.units import shown

if TYPE_CHECKING:
    import xarray as xr

EXAMPLE = '"bend 5 rad/m; twist 8 rad/m"'
Stations = str | Sequence[tuple[float | str, float | str]]
"""Where a path goes: text, or pairs of curvature and twist rate in rad/m or as texts with their units."""


def bend_twist(
    beam: Beam,
    path: Stations,
    *,
    mu: float | None = None,
    margin: float = 0.01,
    points: int = 200,
    joint: str | None = None,
    ideal: bool | None = None,
    neutral: str | None = None,
    hold: str | None = None,
    free: str | None = None,
) -> xr.Dataset:
    """Bend and twist a beam along a path: moment, torque, inclination, forces and energies, and what happens on it.

    The real beam by default, as :func:`twist`, with every contact of its scales. On the hinge thin, rigid scales, both
    plates of every pair looked at (docs, theory: bending and twisting).

    Parameters
    ----------
    beam
        The beam.
    path
        Where to go from rest, one after the other and straight: text such as "bend 5 rad/m; twist 8 rad/m", a semicolon
        between ways, a comma between what changes on one way ("bend 5 rad/m, twist 8 rad/m" is a ray); what one way
        does not name stays as it is, what none of them names is free unless it is held. Bends are positive towards the
        scaled face; both may be negative. Or pairs (curvature, twist rate) in rad/m or as texts.
    mu
        Coefficient of friction; the beam's own if not given.
    margin
        As in :func:`twist`.
    points
        Points of each way, on the hinge one more for each change of contact on it at least.
    joint
        "compliant" or "hinge", as in :func:`twist`; "hinge" if not given where ``neutral="face"`` or ``free`` mean it,
        or where the joint is not known in bend (a warning says so).
    ideal
        Thin, rigid scales, as in :func:`twist`; the hinge has no others here.
    neutral
        Which line of the bar keeps its length: "free" (none, there is no axial force: the compliant joint's default) or
        "middle"; on the hinge "middle" (the default) or "face" (that of the scales, as the theory of bending alone
        takes it).
    hold
        What is held of that which the path does not name, as in :func:`twist`.
    free
        Of the hinge:
        "twisting" leaves the twist of a beam that is bent free, "bending" the bend of one that is twisted: its moment
        is zero, the bar's and the scales' together. One way from rest, without friction (``mu=0``), on the next scale's
        eight contacts alone; contacts that share the force have both names ("BF+TS"), events are at the next point.

    Returns
    -------
    xarray.Dataset
        Dimension ``point``: ``kappa``, ``Phi``, ``psi``, ``phi``, ``M``, ``T``, their parts of the scales, ``theta``,
        ``contact`` (docs, theory), ``N``, ``f``, ``U_el``, ``W_fr``, ``RED``, ``leg``; of the real beam ``stretch``,
        motions, stress and the like of :func:`twist`; of the hinge ``mu_lock`` along the way, and each change of
        contact and each corner twice, before and after. Dimension ``event``: what happens, where, and on the hinge by
        how much M and T jump. Single figures: ``end``, ``psi_e``, ``phi_e``, ``psi_end``, ``phi_end``, ``theta_end``,
        ... Attributes: ``joint``, ``scales``, ``joint_source``, ``neutral``. With
        scales on both faces ``contact_other``, ``theta_other``, ``N_other``, ``stress_other`` and the like are of the
        other face: a stress that is held against a strength is the larger of the two.

    Raises
    ------
    InputError
        An argument is out of range.

    Examples
    --------
    >>> import squama
    >>> beam = squama.Beam.from_ratios(eta=3, beta=1.25, lam=0.45, alpha="45 deg", theta0="10 deg")
    >>> r = squama.bend_twist(beam, "bend 0.1 rad/pitch; twist 0.25 rad/pitch", mu=0.2, joint="hinge")
    >>> for what, phi in zip(r.event.values, r.phi_event.values):
    ...     print(f"{what} at phi = {phi:.4f}")
    engagement (BF) at phi = 0.0000
    corner at phi = 0.0000
    BF to TS at phi = 0.1000
    frictional lock at phi = 0.1868
    """
    arguments.beam(beam)
    return bent_and_twisted(
        beam, path, mu=mu, margin=margin, points=points, joint=joint, ideal=ideal, neutral=neutral, hold=hold,
        free=free,
    ).dataset()  # fmt: skip


def bent_and_twisted(
    beam: Beam,
    path: Stations,
    *,
    mu: float | None = None,
    margin: float = 0.01,
    points: int = 200,
    joint: str | None = None,
    ideal: bool | None = None,
    neutral: str | None = None,
    hold: str | None = None,
    free: str | None = None,
) -> Answer:
    """Return what :func:`bend_twist` returns, before it is a dataset."""
    way = read(path, beam)
    m, margin = np.asarray(arguments.friction(beam.friction.mu, mu)), arguments.margin(margin)
    points = arguments.whole("points", points, 3, 1e5)
    twisting = LOADS["twisting"]
    means = chosen(arguments.held_by(beam, hold), joint=joint, ideal=ideal, neutral=neutral, free=free)
    asked = Asked(means.beam, way, m, "edge", margin, points, ideal=means.ideal, note=means.note)
    if free is not None:
        states = hinge_polygons.relax(asked, _freed(free, asked))
    else:
        states = (real_polygons if means.real else hinge_polygons).walk(asked)
    title = "bending and twisting of a scale-covered beam"
    attrs = attributes(asked, title, "+", means.joint, states.notes, twisting)
    attrs |= {"path": [(psi / beam.pitch, phi / beam.pitch) for psi, phi in way.points], **states.attrs}
    return Answer(labelled(twisting, states, m, "combined"), attrs)


def _freed(free: str, asked: Asked) -> int:
    """Return the axis of the load that is left free, checked against the rest."""
    axis = LOADS[arguments.one_of("free", free, tuple(LOADS))].axis
    only_one(asked.beam.faces, "a load that is left free")
    if float(asked.mus):
        refuse(
            "mu", f"{float(asked.mus):g}", f'must be 0 with free="{free}": friction holds what is free', "write mu=0"
        )
    if len(asked.path.points) > 1 or asked.path.points[0][axis]:
        refuse("path", "", f'must be one way of the other load with free="{free}"', 'write e.g. "bend 5 rad/m"')
    return axis


def read(path: Stations, beam: Beam) -> LoadPath:
    """Return a path as bends and twists per pitch; no two stations in a row are equal."""
    items = [part.strip() for part in path.split(";")] if isinstance(path, str) else path
    if not isinstance(items, Sequence | np.ndarray) or not len(items):
        refuse("path", "", "is not a path", f"write e.g. {EXAMPLE}")
    points, loaded = [(0.0, 0.0)], set[str]()
    for i, item in enumerate(items):
        name = f"path[{i}]" if len(items) > 1 else "path"
        with naming(name):
            point, verbs = _named(item, points[-1], beam) if isinstance(item, str) else (_pair(item, beam), VERBS)
            loaded.update(verbs)
            if point == points[-1]:
                refuse("", shown(item), "goes nowhere: it is where the path stands", "leave it out")
            if max(map(abs, point)) >= math.pi:
                refuse("", shown(item), "is half a turn per pitch or more", "give less")
        points.append(point)
    return LoadPath(tuple(points[1:]), loaded=tuple(verb for verb in VERBS if verb in loaded))


def _named(text: str, here: tuple[float, float], beam: Beam) -> tuple[tuple[float, float], Sequence[str]]:
    """Return where a text such as "bend 5 rad/m, twist 8 rad/m" goes from here, per pitch, and what it names."""
    verbs = {load.verb: load for load in LOADS.values()}
    found = list(here)
    said: list[str] = []
    for part in text.split(","):
        verb, _, value = part.strip().partition(" ")
        if verb not in verbs or verb in said or not value:
            refuse("", shown(text.strip()), "is not a way", f"write e.g. {EXAMPLE}, each word once between semicolons")
        said.append(verb)
        load = verbs[verb]
        found[load.axis] = load.read(value.strip(), pitch=beam.pitch, scales=beam.scales, bare=False) * beam.pitch
    return (found[0], found[1]), said


def _pair(item: object, beam: Beam) -> tuple[float, float]:
    """Return a pair of curvature and twist rate per pitch."""
    if not isinstance(item, Sequence | np.ndarray) or len(item) != 2:
        refuse("", shown(item), "is not a pair of curvature and twist rate", "write e.g. (5, 8), in rad/m")
    psi, phi = (
        load.read(value.item() if isinstance(value, np.generic) else value, pitch=beam.pitch, scales=beam.scales)
        * beam.pitch
        for load, value in zip(sorted(LOADS.values(), key=lambda load: load.axis), item, strict=True)
    )
    return psi, phi

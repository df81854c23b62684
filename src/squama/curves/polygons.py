"""Public functions of bending and twisting at once: ``bend_twist`` along a path, ``bend_twist_map`` in the plane."""

from __future__ import annotations

from typing import TYPE_CHECKING, Unpack

import numpy as np

from squama import arguments
from squama.beam.design import Beam
from squama.beam.faces import only_one
from squama.curves import doors, given, labelled
from squama.curves.chosen import MODELS
from squama.curves.doors import How
from squama.curves.labelled import Answer
from squama.curves.way import Analysis, States
from squama.errors import refuse
from squama.loads import LOADS, EndsName, JointName, LineName, LoadName
from squama.types import Array

if TYPE_CHECKING:
    import xarray as xr

ROOM = 0.15
"""Margin around a path on the map of its plane, as a share of the path's size."""
_BOTH = "bending and twisting"


def bend_twist(
    beam: Beam,
    path: given.Path,
    *,
    mu: float | None = None,
    margin: float = 0.01,
    points: int = 200,
    joint: JointName | None = None,
    ideal: bool | None = None,
    neutral: LineName | None = None,
    hold: str | None = None,
    free: LoadName | None = None,
    ends: EndsName | None = None,
) -> xr.Dataset:
    """Bend and twist a beam along a path: moment, torque, inclination, forces, energies, and a list of events.

    The default model has thick, elastic scales on compliant joints, as :func:`twist`, with every contact of its scales.
    On hinges the scales are thin and rigid, and both plates of every pair are checked for contact (docs, theory:
    bending and twisting). A beam with a number of scales has all of them; on hinges it is endless.

    Parameters
    ----------
    beam
        The beam.
    path
        Straight ways from rest, in succession: text such as "bend 5 rad/m; twist 8 rad/m", with semicolons between ways
        and commas between loads that change together ("bend 5 rad/m, twist 8 rad/m" is a ray). A load that a way does
        not name keeps its value; a load that no way names is free unless it is held. Bends are positive towards the
        scaled face; both loads may be negative. Alternatively pairs (curvature, twist rate) in rad/m or as text.
    mu
        Coefficient of friction; the beam's own if not given.
    margin
        As in :func:`twist`.
    points
        Number of points of each way; on hinges at least one more for each change of contact.
    joint
        "compliant" or "hinge", as in :func:`twist`. "hinge" is the default with ``neutral="face"`` or ``free``, and
        where the joint's stiffness in bending is unknown (with a warning).
    ideal
        Thin, rigid scales, as in :func:`twist`; here hinges have no other scales.
    neutral
        Line of the bar that keeps its length: "free" (none: no axial force; default of the compliant joint) or
        "middle"; on hinges "middle" (default) or "face" (that of the scales, as in the theory of bending alone).
    hold
        Held strains among those that the path does not name, as in :func:`twist`.
    free
        For hinges: "twisting" leaves the twist of a bent beam free, "bending" the bend of a twisted one; the sum of the
        bar's and the scales' moment is zero. For one way from rest, without friction (``mu=0``), with the next scale's
        eight contacts alone. Contacts that share the force have both names ("BF+TS"); events are at the next point.
    ends
        Ends of a beam with a number of scales, as in :func:`twist`: "free" (the path is the mean bend and twist of the
        cells, with the same moment and torque in all cells), "equal" or "endless"; "gripped" or "couple" if the path
        names the twist alone.

    Returns
    -------
    xarray.Dataset
        Dimension ``point``: ``kappa``, ``Phi``, ``psi``, ``phi``, ``M``, ``T``, their parts of the scales, ``theta``,
        ``contact`` (docs, theory), ``N``, ``f``, ``U_el``, ``W_fr``, ``RED``, ``leg``; on the compliant joint
        ``stretch``, motions, stress and the like of :func:`twist`; of the hinge ``mu_lock`` along the way, and each
        change of contact and each corner twice, before and after. Dimension ``event``: events, their places, and on the
        hinge the jumps of M and T. Single figures: ``end``, ``psi_e``, ``phi_e``, ``psi_end``, ``phi_end``,
        ``theta_end``, ... Attributes: ``joint``, ``scales``, ``joint_source``, ``neutral``.

        A beam with a number of scales has variables of each scale and the strains of the cells along ``scale``, as in
        :func:`twist`; ``M_periodic``, ``T_periodic`` and ``theta_periodic`` are of the endless beam, ``contact`` has
        every pair in contact once, ``event_scale`` is the scale of the event (0: the whole beam). With scales
        on both faces ``contact_other``, ``theta_other``, ``N_other``, ``stress_other`` and the like are of the second
        face; compare the larger of the two stresses with a strength.

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
    how = How(mu=mu, margin=margin, joint=joint, ideal=ideal, neutral=neutral, hold=hold)
    return bent_and_twisted(beam, path, points=points, free=free, ends=ends, **how).dataset()


def bent_and_twisted(
    beam: Beam,
    path: given.Path,
    *,
    points: int = 200,
    free: str | None = None,
    ends: str | None = None,
    **how: Unpack[How],
) -> Answer:
    """Return the result of :func:`bend_twist` before it is a dataset."""
    arguments.beam(beam)
    analysis = doors.analysis(beam, given.path(path, beam), None, points=points, free=free, **how)
    if free is not None:
        analysis = _freed(free, analysis)
    analysis = analysis._replace(ends=doors.ends_of(analysis, ends, history=True))
    states = MODELS[analysis.joint].programs().polygon(analysis)
    corners = [(psi / beam.pitch, phi / beam.pitch) for psi, phi in analysis.way.corners]
    title, attrs = f"{_BOTH} of a scale-covered beam", {"load": _BOTH, "path": corners}
    answer = labelled.answer(analysis, states, title, attrs, load=LOADS["twisting"], page="combined")
    answer.over = "kappa", "Phi", "psi", "phi"
    return answer


def _freed(free: str, analysis: Analysis) -> Analysis:
    """Return the analysis with a load left free; refuse arguments that exclude it."""
    axis, mu = LOADS[arguments.one_of("free", free, tuple(LOADS))].axis, float(analysis.mus)
    only_one(analysis.beam.faces, "a load that is left free")
    if mu:
        refuse("mu", f"{mu:g}", f'must be 0 with free="{free}": friction would hold the free load', "write mu=0")
    if len(analysis.way.corners) > 1 or analysis.way.corners[0][axis]:
        refuse("path", "", f'must be one way of the other load with free="{free}"', 'write e.g. "bend 5 rad/m"')
    return analysis._replace(way=analysis.way._replace(free=axis))


def bend_twist_map(
    beam: Beam,
    path: given.Path,
    *,
    mu: float | None = None,
    joint: JointName | None = None,
    ideal: bool | None = None,
    neutral: LineName | None = None,
    points: int = 81,
) -> xr.Dataset:
    """Map the plane of bend and twist around a path: contacts, locks, inclination, moment and torque.

    Every state is reached straight from rest, on its own ray: with friction, moment and torque depend on the way.

    Parameters
    ----------
    beam, mu, joint, ideal, neutral
        As in :func:`bend_twist`.
    path
        As in :func:`bend_twist`; the map is the box around rest and its corners, with some room. A ray such as
        "bend 8 rad/m, twist 10 rad/m" names the far corner.
    points
        Number of points in each direction.

    Returns
    -------
    xarray.Dataset
        Over ``psi`` and ``phi`` (rad per pitch; ``kappa``, ``Phi`` in rad/m along them): ``state`` ("open", "sliding",
        or the end of the way to it, such as "frictional lock", "no equilibrium"), ``contact``, ``theta``, ``N``, ``M``,
        ``T`` and the scales' parts of them, NaN where the way ends before; on hinges also ``mu_lock``. Attributes as in
        :func:`bend_twist`.

    Raises
    ------
    InputError
        An argument is out of range.

    Examples
    --------
    >>> import squama
    >>> beam = squama.Beam.from_ratios(eta=3, beta=1.25, lam=0.45, alpha="45 deg", theta0="10 deg")
    >>> m = squama.bend_twist_map(beam, "bend 0.2 rad/pitch, twist 0.3 rad/pitch", mu=0.5, joint="hinge", points=21)
    >>> print(m["T"].dims, *m.state.sel(psi=0.1, phi=[0.1, 0.3], method="nearest").values, sep=", ")
    ('psi', 'phi'), sliding, frictional lock
    """
    arguments.beam(beam)
    only_one(beam.faces, "the map of bend and twist")
    way, n = given.path(path, beam), arguments.whole("points", points, 3, 1000)
    analysis = doors.analysis(beam, way, None, mu=mu, points=n, joint=joint, ideal=ideal, neutral=neutral)
    corners = np.array([(0.0, 0.0), *way.corners])
    room = ROOM * float(np.ptp(corners, axis=0).max())
    psi, phi = (np.linspace(v.min() - room, v.max() + room, n) for v in corners.T)
    # at rest itself there is no way, and nothing in contact
    grid = np.meshgrid(np.where(psi == 0, 1e-9 * room, psi), phi, indexing="ij")
    found = MODELS[analysis.joint].programs().plane(analysis, *(v.ravel() for v in grid))
    by_dim: dict[tuple[str, ...], dict[str, Array]] = {
        ("psi", "phi"): {role: np.reshape(v, (n, n)) for role, v in found.by_dim[()].items()},
        ("psi",): {"psi": psi, "kappa": psi / beam.pitch},
        ("phi",): {"load": phi, "rate": phi / beam.pitch},
    }
    states, title = States(by_dim, found.attrs, found.notes), "plane of bend and twist of a scale-covered beam"
    attrs = {"load": _BOTH, "neutral": analysis.beam.neutral}
    answer = labelled.answer(analysis, states, title, attrs, load=LOADS["twisting"], page="combined")
    return answer.dataset().set_coords(["psi", "phi", "kappa", "Phi"])

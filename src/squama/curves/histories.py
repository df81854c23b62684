"""Public function ``cycle``: loading and unloading of a beam along a history of twists, as a dataset."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Unpack

from squama import arguments
from squama.beam.design import Beam
from squama.curves import doors, given, labelled
from squama.curves.chosen import MODELS
from squama.curves.doors import How
from squama.curves.labelled import Answer
from squama.errors import refuse
from squama.loads import EndsName, JointName, LawName, LoadName

if TYPE_CHECKING:
    import xarray as xr

MOST = 1_000_000
"""Largest number of points of a history."""


def cycle(
    beam: Beam,
    twist: float | str | Sequence[float | str],
    *,
    mu: float | None = None,
    law: LawName = "edge",
    load: LoadName = "twisting",
    margin: float = 0.01,
    points: int = 60,
    loops: int = 1,
    joint: JointName | None = None,
    ideal: bool | None = None,
    hold: str | None = None,
    ends: EndsName | None = None,
) -> xr.Dataset:
    """Load and unload a beam through any history of twists: loops, stick intervals, dissipation, jamming.

    Parameters
    ----------
    beam
        The beam.
    twist
        Twists in succession, from rest at 0: rates in rad/m or text such as "0.2 rad/pitch", or one text such as "0,
        0.15, 0.05, 0.2, 0 rad/pitch". A single twist is reached and released again. Negative twists are in the other
        sense. In bending: curvatures, positive towards the scales.
    mu
        Coefficient of friction; the beam's own if not given.
    law
        "edge" (satisfies virtual work) or "plate" (the paper's); in bending they coincide.
    load
        "twisting" or "bending".
    margin
        Smallest allowed distance from a lock, as a fraction of the path.
    points
        Number of points in contact on each way between two twists; a part without contact has a quarter of it.
    loops
        How many times the history is followed.
    joint
        "compliant" or "hinge", as in :func:`squama.twist`, in bending as in :func:`squama.bend`.
    ideal, hold
        Thin, rigid scales, and held strains, as in :func:`squama.twist`.
    ends
        Ends of a beam with a number of scales, as in :func:`squama.twist`; variables of a scale then have the dimension
        ``scale``.

    Returns
    -------
    xarray.Dataset
        Dimension ``point``: ``branch`` (how the point was reached: "straight", "loading", "unloading", "stick"),
        ``leg``, ``phi``, ``Phi``, ``T``, ``T_scales``, ``K_t``, ``theta``, ``N``, ``f`` (negative while the twist
        falls), ``p``, ``s``, ``U_el``, ``W_fr`` (from the start on); every turning point twice, before and after the
        drop of torque. Dimension ``loop``, closed loops in the order in which they close: ``phi_base``, ``phi_top``,
        ``W_d``, ``U_max``, ``zeta_eq``, ``K_sec``, ``T_drop`` (NaN of N scales, which slide back one by one),
        ``phi_residual``. Dimension ``sense``: ``phi_e``,
        ``phi_most``, ``phi_jam``, ``phi_end``, ``end``, ``other_contact``, ``neighbour``. In bending ``psi``,
        ``kappa``, ``M``, ``K_b``, ``r``. With the compliant joint every turning point appears once, "stick" marks the
        points until the contact slides back, ``phi_most`` and ``phi_jam`` are left out, ``W_snap`` is added;
        ``energy_error``: work neither stored, dissipated by friction nor lost in snaps, over the larger energy.
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
    how = How(mu=mu, law=law, margin=margin, joint=joint, ideal=ideal, hold=hold)
    return cycled(beam, twist, load=load, points=points, loops=loops, ends=ends, **how).dataset()


def cycled(
    beam: Beam,
    twist: float | str | Sequence[float | str],
    *,
    load: str = "twisting",
    points: int = 60,
    loops: int = 1,
    ends: str | None = None,
    **how: Unpack[How],
) -> Answer:
    """Return the result of :func:`cycle` before it is a dataset."""
    arguments.beam(beam)
    kind = arguments.load(load)
    way = given.history(twist, beam, kind, arguments.whole("loops", loops, 1, 1e4))
    analysis = doors.analysis(beam, way, kind, points=points, **how)
    analysis = analysis._replace(ends=doors.ends_of(analysis, ends, history=True))
    if len(way.values) * analysis.points > MOST:
        reason = f"{len(way.values)} twists of {analysis.points} points are too many"
        refuse("twist", "", reason, "ask for fewer points or loops")
    history = [v / analysis.beam.pitch for v in way.values]
    states = MODELS[analysis.joint].programs().walk(analysis)
    title = f"cycles of a scale-covered beam in {kind.name}"
    answer = labelled.answer(analysis, states, title, {"history": history})
    answer.over = kind.rate, kind.angle
    return answer

"""A row of N scales without periodicity: from a beam to the state of every scale, along the twist."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Unpack

import numpy as np

from squama import arguments
from squama.beam.design import Beam
from squama.beam.faces import only_one
from squama.curves import doors, labelled
from squama.curves.chosen import MODELS
from squama.curves.doors import How
from squama.curves.labelled import Answer, Labelled
from squama.curves.way import Way
from squama.errors import refuse
from squama.loads import ENDS, LOADS
from squama.units import shown

if TYPE_CHECKING:
    import xarray as xr

MOST = 2000
"""Largest number of scales of a row."""


def row(
    beam: Beam,
    *,
    scales: int | None = None,
    mu: float | None = None,
    to: float | str | None = None,
    points: int = 100,
    sense: str = "+",
    joint: str | None = None,
    ideal: bool | None = None,
    hold: str | None = None,
    ends: str | None = None,
) -> xr.Dataset:
    """Twist a row of N scales that does not repeat: its end scales lack one neighbour.

    The twist is that of the ends over the number of pitches. Each cell finds its own twist, bend, lateral bend and
    stretch under the load at the ends (docs, theory: a finite row).

    Parameters
    ----------
    beam
        The beam.
    scales
        Number of scales, 2 to 2000, between grips to 60; the beam's own if not given.
    mu
        Coefficient of friction; the beam's own if not given.
    to
        Twist at which to stop: a rate in rad/m or text such as "5 rad/m", "0.2 rad/pitch", "90 deg total" (over
        ``scales`` pitches). If not given, 0.3 rad per pitch; on the hinge the cut-off of the endless beam's curve
        (margin 0.01).
    points
        Number of points along the twist.
    sense
        "+" or "-": which way the beam is twisted. Twists are magnitudes.
    joint, ideal, hold
        "compliant" or "hinge", thin, rigid scales or those of the beam, and what is held, as in :func:`squama.twist`;
        of each cell. With grips nothing but the stretch may be held: their distance.
    ends
        "free" (default): a torque at both ends, the same in all cells; "gripped": the ends stay on one axis, held
        against bending and shear, half a pitch beyond the first and last scale; "equal": all cells have the same
        strains. Rows on hinges are "equal".

    Returns
    -------
    xarray.Dataset
        Dimensions ``point`` and ``scale`` (1 to N); ``theta``, ``N``, ``f``, ``p``, ``s`` of every scale's contact with
        the next (NaN where there is none) and ``Q``; ``T``, ``T_scales``, ``U_el``, ``W_fr``, ``RED`` of the row;
        ``T_periodic`` and ``theta_periodic`` of the endless beam, NaN beyond its end; ``phi_e``, ``phi_end``, ``end``,
        ``scale_end``, ``other_contact``, ``decay``. With the compliant joint ``deflection``, ``stress``, ``strain``,
        ``pull_out``, ``tab_force``, ``tab_bending`` and ``tab_torsion`` of every scale, and ``U_joint``, ``U_plate``,
        ``U_bar``; unless ``ends`` is "equal" the cells' strains ``phi_cell``, ``psi_cell``, ``chi_cell`` and
        ``stretch_cell``, and what they carry, ``T_cell``, ``M_cell``, ``M_lat_cell`` and ``P_cell``, without those that
        are zero. SI units and radians; joint, scales, law and ends in the attributes.

    Raises
    ------
    InputError
        An argument is out of range.

    Examples
    --------
    >>> import squama
    >>> beam = squama.Beam.from_ratios(eta=3, beta=0.6, lam=0.32, zeta=0.18, slenderness=45)
    >>> r = squama.row(beam, scales=25, mu=0.2, to="0.1 rad/pitch", joint="hinge")
    >>> ends = r.theta.isel(point=-1, scale=[0, 12, 24]).values
    >>> print([f"{t:.3f}" for t in ends], f"{float(r.decay):.2f} per scale")
    ['0.301', '0.290', '0.070'] 0.77 per scale
    """
    return rowed(
        beam, scales=scales, mu=mu, to=to, points=points, sense=sense, joint=joint, ideal=ideal, hold=hold, ends=ends
    ).dataset().set_coords("phi")  # fmt: skip


def rowed(
    beam: Beam,
    *,
    scales: int | None = None,
    to: float | str | None = None,
    points: int = 100,
    sense: str = "+",
    ends: str | None = None,
    **how: Unpack[How],
) -> Answer:
    """Return what :func:`row` returns, before it is a dataset."""
    arguments.beam(beam)
    only_one(beam.faces, "a finite row")
    twisting, n = LOADS["twisting"], arguments.whole("scales", beam.scales if scales is None else scales, 2, MOST)
    stop = math.inf if to is None else doors.far(to, twisting, beam.pitch, n)
    way = Way.of("twisting", [arguments.sense(sense) * stop])
    analysis = doors.analysis(beam.replace(scales=n), way, twisting, points=points, **how)
    ends = _ends(ends, analysis.joint)
    states = MODELS[analysis.joint].programs().row(analysis, ends)
    single = states.by_dim[()]
    single |= {f"Phi_{name}": single[f"phi_{name}"] / beam.pitch for name in ("e", "end")}
    attrs = {"load": "row", "mu": float(analysis.mus), "sense": sense, "ends": ends}
    answer = labelled.answer(analysis, states, "twisting of a row of scales", attrs, sense=sense)
    counted = {"long_name": "scale, counted along the beam"}
    answer.variables["scale"] = Labelled(("scale",), np.arange(1, n + 1), counted)
    return answer


def _ends(word: str | None, joint: str) -> str:
    """Return how the ends are held, by what is asked; refuse what a model does not know."""
    allowed = MODELS[joint].ends
    if word is not None and word not in ENDS:
        refuse("ends", shown(word), f"must be one of {', '.join(map(shown, ENDS))}", 'write e.g. ends="free"')
    if word is not None and word not in allowed:
        refuse("ends", shown(word), "a row on hinges has one twist in all cells", 'leave it out, or write ends="equal"')
    return word or allowed[0]

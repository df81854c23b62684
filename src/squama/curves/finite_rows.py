"""Public function ``row``: a twisted beam of N scales; and the effect of its ends, compared with the endless beam."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple, Unpack

import numpy as np

from squama import arguments
from squama.beam.design import Beam
from squama.curves import doors
from squama.curves.doors import How
from squama.curves.labelled import Answer
from squama.errors import InputError
from squama.loads import EndsName, JointName, SenseName

if TYPE_CHECKING:
    import xarray as xr

MOST = 2000
"""Largest number of scales of a row."""
ENOUGH, COMPARED = 100, 30
"""Number of scales from which on the effect of the ends is only divided among more scales; points of the compared row.
"""


def row(
    beam: Beam,
    *,
    scales: int | None = None,
    mu: float | None = None,
    to: float | str | None = None,
    points: int = 100,
    sense: SenseName = "+",
    joint: JointName | None = None,
    ideal: bool | None = None,
    hold: str | None = None,
    ends: EndsName | None = None,
) -> xr.Dataset:
    """Twist a row of N scales; its end scales lack a neighbour, so that it is not periodic.

    The twist is that of the ends over the number of pitches. Each cell takes its own twist, bend, lateral bend and
    stretch under the load at the ends (docs, theory: a finite row).

    Parameters
    ----------
    beam
        The beam.
    scales
        Number of scales, 2 to 2000, up to 60 between grips or under a couple; the beam's own if not given.
    mu
        Coefficient of friction; the beam's own if not given.
    to
        Twist at which to stop: a rate in rad/m or text such as "5 rad/m", "0.2 rad/pitch", "90 deg total" (over
        ``scales`` pitches). By default the twist at which a pitch twists by 0.3 rad; on hinges the cut-off of the
        endless beam's curve (margin 0.01).
    points
        Number of points along the twist.
    sense
        "+" or "-": which way the beam is twisted. Twists are magnitudes.
    joint, ideal, hold
        Joint ("compliant" or "hinge"), thin, rigid scales or those of the beam, and held strains of each cell, as in
        :func:`squama.twist`. With grips only the stretch, their distance, can be held.
    ends
        "free" (default): the same torque in all cells. "couple": a couple at both ends, which may shift and tilt;
        twists are then the rotation of the far end over the pitches. "gripped": the ends stay on one axis, held against
        bending and shear, half a pitch beyond the first and last scale. "equal": all cells have the same strains. Rows
        on hinges are "equal".

    Returns
    -------
    xarray.Dataset
        As from :func:`squama.twist` for a beam with a number of scales.

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
    how = How(mu=mu, joint=joint, ideal=ideal, hold=hold)
    found = rowed(beam, scales=scales, to=to, points=points, sense=sense, ends=ends, **how)
    return found.dataset()


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
    """Return the result of :func:`row` before it is a dataset."""
    arguments.beam(beam)
    n = arguments.whole("scales", beam.pitches if scales is None else scales, 2, MOST)
    whole = beam.replace(scales=n)
    return doors.respond(whole, "twisting", to=to, points=points, sense=sense, ends=ends, row=True, **how)


class Ends(NamedTuple):
    """Effect of a beam's ends: ``torque`` and ``tangent`` of its N ``scales`` over those of an endless beam.

    At the twist ``load``, rad per pitch; ``end`` is why the row ends early, or "".
    """

    scales: int
    load: float
    torque: float
    tangent: float
    end: str


def ends(beam: Beam, to: float, *, sense: str = "+", **how: Unpack[How]) -> Ends | None:
    """Compare a beam's row with the endless beam at a twist (rad/m), or where the row ends; None without contact."""
    n = min(beam.pitches, ENOUGH)
    try:
        found = rowed(beam, scales=n, to=to, points=COMPARED, sense=sense, **how)
    except InputError:
        return None
    phi, own, endless = (found[name] for name in ("phi", "T", "T_periodic"))
    there = np.isfinite(own) & np.isfinite(endless) & (phi > float(found["phi_e"]))
    phi, own, endless = phi[there], own[there], endless[there]
    if phi.size < 3 or not endless[-1] > 0:
        return None
    steep, other = (np.gradient(torque, phi)[-1] for torque in (own, endless))
    torque, tangent = (1 - (1 - float(share)) * n / beam.pitches for share in (own[-1] / endless[-1], steep / other))
    far = math.isclose(phi[-1], to * beam.pitch, rel_tol=1e-6)
    return Ends(beam.pitches, float(phi[-1]), torque, tangent, "" if far else str(found["end"]))

"""What a beam's own number of scales does at a twist: the row of them, whose ends lack a neighbour."""

from __future__ import annotations

import math
from typing import NamedTuple, Unpack

import numpy as np

from squama.beam.design import Beam
from squama.curves.doors import How
from squama.curves.finite_rows import rowed
from squama.errors import InputError

ENOUGH, COMPARED = 100, 30
"""Scales from which on more of them only share the ends' part among more; points of a row that is compared."""


class Ends(NamedTuple):
    """What a beam's own ends take away: ``torque`` and ``tangent`` of its N ``scales`` over those of an endless beam.

    At the twist ``load``, rad per pitch; ``end`` says why the row goes no farther, empty where it goes as far as asked.
    """

    scales: int
    load: float
    torque: float
    tangent: float
    end: str


def ends(beam: Beam, to: float, *, sense: str = "+", **how: Unpack[How]) -> Ends | None:
    """Compare a beam's row with the endless one at a twist (rad/m) or where it ends before; None without contact."""
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

"""What a beam's own number of scales does at a twist: the row of them, whose ends lack a neighbour."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple, Unpack

import numpy as np

from squama.beam.design import Beam
from squama.curves.curve_figures import tangents
from squama.curves.doors import How
from squama.curves.finite_rows import rowed
from squama.errors import InputError
from squama.types import Array

POINTS, BEHIND = 120, 1.02
"""Points of the row's curve, from which figures at twists are read, and how far it goes over the last of these."""
ENOUGH, COMPARED = 100, 30
"""Scales from which on more of them only share the ends' part among more; points of a row that is compared."""


class OwnScales(NamedTuple):
    """Figures of a row at twists, arrays (n,) in SI units, NaN where the row ends before.

    Torque ``T``, tangent stiffness ``K_t``, the same over that without contact, largest ``stress`` of all scales,
    frictional work per length and ``RED``; ``scales``: their number; ``note``: why a figure is missing, or nothing.
    """

    T: Array
    K_t: Array
    stiffness_ratio: Array
    stress: Array
    W_fr: Array
    RED: Array
    scales: int
    note: str = ""


def own_scales(beam: Beam, rates: Sequence[float], *, sense: str = "+", **how: Unpack[How]) -> OwnScales:
    """Return what :func:`squama.row` of the beam's own scales gives at twist rates (rad/m, at least one above 0).

    Other arguments as there.
    """
    at, far = np.asarray(rates, float), BEHIND * max(rates)
    found = rowed(beam, to=far, points=POINTS, sense=sense, **how)
    x, torque = found["Phi"], found["T"]
    rigidity, engaged = float(found.attrs.get("rigidity", beam.torsional_rigidity)), float(found["phi_e"])
    twists = x * beam.pitch
    slopes = tangents(rigidity, beam.pitch, [engaged], twists, twists, {"torque": torque})["tangent"]
    stress = found["stress"].max(axis=1) if "stress" in found.variables else np.full(x.size, np.nan)
    # the row may end before the last twist that is asked for
    reached = at <= x[-1] * (1 + 1e-9)
    T, K_t, stress, work, red = (
        np.where(reached, np.interp(at, x, v), np.nan) for v in (torque, slopes, stress, found["W_fr"], found["RED"])
    )
    # it jumps at engagement
    K_t[at * beam.pitch < engaged] = rigidity
    end = f"a row of {beam.scales} scales ends at {twists[-1]:.3g} rad/pitch: {found['end'].item()}"
    return OwnScales(T, K_t, K_t / rigidity, stress, work, red, beam.scales, "" if reached.all() else end)


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
    n = min(beam.scales, ENOUGH)
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
    torque, tangent = (1 - (1 - float(share)) * n / beam.scales for share in (own[-1] / endless[-1], steep / other))
    far = math.isclose(phi[-1], to * beam.pitch, rel_tol=1e-6)
    return Ends(beam.scales, float(phi[-1]), torque, tangent, "" if far else str(found["end"]))

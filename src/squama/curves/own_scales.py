"""What a beam's own number of scales does at a twist: the row of them, whose ends lack a neighbour."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from squama.beam.design import Beam
from squama.curves import curve_figures, finite_rows
from squama.types import Array

POINTS, BEHIND = 120, 1.02
"""Points of the row's curve, from which figures at twists are read, and how far it goes over the last of these."""


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


def own_scales(
    beam: Beam,
    rates: Sequence[float],
    *,
    mu: float | None = None,
    sense: str = "+",
    joint: str | None = None,
    ideal: bool | None = None,
) -> OwnScales:
    """Return what :func:`squama.row` of the beam's own scales gives at twist rates (rad/m, at least one above 0).

    Other arguments as there.
    """
    at, far = np.asarray(rates, float), BEHIND * max(rates)
    found = finite_rows.rowed(beam, mu=mu, to=far, points=POINTS, sense=sense, joint=joint, ideal=ideal)
    x, torque = found["Phi"], found["T"]

    rigidity, engaged = float(found.attrs.get("rigidity", beam.torsional_rigidity)), float(found["phi_e"])
    twists = x * beam.pitch
    slopes = curve_figures.tangents(rigidity, beam.pitch, [engaged], twists, twists, {"torque": torque})["tangent"]
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

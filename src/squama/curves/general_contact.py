"""Curves by general contact, in SI units: scales on a joint of six motions that may touch anywhere.

It follows what the real model cannot (:mod:`squama.curves.real`): other pairs of edges and faces, two contacts at once.
It needs the extra fe.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from squama.beam.design import Beam
from squama.beam.matrixfile import MOTIONS
from squama.curves.path import Case, Curve, figures, in_si
from squama.fe import bending, condense
from squama.fe.exposed import Exposed, box, sheet
from squama.fe.geometry import geometry
from squama.fe.walk import Contacts
from squama.model.elastic_plate import monomials
from squama.model.outcome import End
from squama.real.path import Scale, plate_figures
from squama.types import Array

_ALONG = (
    *("rate", "load", "torque", "scales", "tangent", "p", "s", "theta", "N", "f", "f0", "U_el", "W_fr", "RED"),
    *(*MOTIONS, "gap", "deflection", "scale_twist", "stress", "stress_x", "stress_y"),
)
_GRID = (6, 3)
"""Parts of a bent plate along and across, where it may touch anywhere."""


def curve(
    beam: Beam,
    K: Array,
    mu: float,
    loads: Array,
    scale: Scale,
    *,
    sign: int,
    increment: float = condense.INCREMENT,
) -> Curve:
    """Return a curve at twists per pitch (magnitudes, rad, any order), by the roles of :mod:`squama.loads`.

    ``K`` (7, 7) holds a ``scale``, E = 1 and d = 1; ``sign`` is that of the twist, ``increment`` the largest one, rad
    per pitch.
    """
    case = Case.held(beam, K, sign)
    order, back = np.unique(loads, return_inverse=True)
    exposed = surface(scale)
    c = condense.curve(geometry(beam).rest, K, mu, sign * order, increment=increment, exposed=exposed)
    own = {role: values for role, values in c.along.items() if role not in ("phi", "T", "W")}
    own |= plate_figures(scale, deflections(scale, exposed, c.moved))
    v = in_si(case, beam.substrate.youngs_modulus, order, own | {"torque": sign * c.along["T"]})
    reached, v["tangent"] = np.isfinite(v["torque"]), np.full(order.size, np.nan)
    if reached.sum() > 1:
        v["tangent"][reached] = np.gradient(v["torque"][reached], v["rate"][reached])
    last = {role: float(values[reached][-1]) if reached.any() else np.nan for role, values in v.items()}
    found = {
        **figures(case, last, abs(c.phi_e), abs(c.phi_end), last["theta"]),
        "end": str(End(c.end)),
        **contacts(c.contacts),
        "energy_error": c.unbalanced,
    }
    return Curve({role: v[role][back] for role in _ALONG}, found)


def surface(scale: Scale) -> Exposed | None:
    """Return the exposed part of a scale where it may touch; None of one that is thin and rigid."""
    if scale.elastic:
        grid = bending.lines(scale.eta, scale.beta, _GRID)
        return bending.plate(sheet(*grid, scale.h), scale.eta, scale.beta, scale.D, scale.nu)
    return box(scale.eta, scale.beta, scale.h) if scale.h else None


def deflections(scale: Scale, exposed: Exposed | None, moved: Array) -> Array:
    """Return deflections (n, 24), as powers, of a plate whose points have moved by (n, points, 3)."""
    if exposed is None or not scale.elastic:
        return np.zeros((len(moved), 24))
    X, Y, _ = (exposed.points / (scale.eta, scale.beta, 1.0)).T
    return np.asarray(moved[:, :, 2] @ np.linalg.pinv(monomials(X, Y)).T)


def contacts(met: Sequence[Contacts]) -> dict[str, int | str]:
    """Return which neighbour is followed, what touches first, and what else comes in later, by role."""
    first = met[0] if met else None
    other = next((t for t in met if t.k and first and (t.k, t.pair) != (first.k, first.pair)), None)
    return {
        "neighbour": first.k if first else 0,
        "other_contact": f"{other.pair} (k = {other.k}) at {abs(other.phi):.4g} rad/pitch" if other else "",
        "first_contact": f"{first.pair} (k = {first.k})" if first else "",
    }

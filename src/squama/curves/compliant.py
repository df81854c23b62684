"""Curves by general contact, in SI units: scales on a joint of six motions that may touch anywhere.

It follows what the real model cannot (:mod:`squama.curves.real`): other pairs of edges and faces, two contacts at once.
It needs the extra fe.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from squama.beam.design import Beam
from squama.curves.path import Case, Curve, figures
from squama.fe import condense
from squama.fe.exposed import Exposed
from squama.fe.plate import MOTIONS, Rest
from squama.fe.walk import Contacts
from squama.model.outcome import End
from squama.types import Array

_ALONG = (
    *("rate", "load", "torque", "scales", "tangent", "p", "s", "theta", "N", "f", "f0", "U_el", "W_fr", "RED"),
    *(*MOTIONS, "gap"),
)


class Stiffness(NamedTuple):
    """Stiffness of a scale's joint: ``K`` (7, 7) in E d^3, E d^2 and E d; K_theta and the beam's rigidity in SI."""

    K: Array
    K_theta: float
    rigidity: float

    def case(self, beam: Beam, sign: int) -> Case:
        """Return what a beam with this joint brings."""
        return Case(beam.pitch, self.rigidity, self.K_theta, beam.eta, beam.scale.theta0, sign < 0)


def rest(beam: Beam) -> Rest:
    """Return a scale at rest, in pitches."""
    return Rest.at(beam.eta, beam.beta, beam.lam, beam.scale.alpha, beam.scale.theta0)


def in_si(beam: Beam, joint: Stiffness, load: Array, own: dict[str, Array]) -> dict[str, Array]:
    """Give values of the incremental model, where E = 1 and d = 1, their units, by role; with the rate and its load."""
    d, E = beam.pitch, beam.substrate.youngs_modulus
    units = dict.fromkeys(("p", "s", "gap", "u_X", "u_Y", "u_Z"), d) | {"torque": E * d**3}
    units |= dict.fromkeys(("N", "f", "U_el", "W_fr"), E * d**2)
    values = {role: v * units.get(role, 1.0) for role, v in own.items()}
    rate = load / d
    return {**values, "load": load, "rate": rate, "scales": values["torque"] - joint.rigidity * rate}


def curve(
    beam: Beam,
    joint: Stiffness,
    mu: float,
    loads: Array,
    *,
    sign: int,
    increment: float = condense.INCREMENT,
    exposed: Exposed | None = None,
) -> Curve:
    """Return a curve at twists per pitch (magnitudes, rad, any order), by the roles of :mod:`squama.loads`.

    ``sign`` is that of the twist, ``increment`` the largest one, rad per pitch; ``exposed`` the scales, thin and rigid
    if not given.
    """
    order, back = np.unique(loads, return_inverse=True)
    c = condense.curve(rest(beam), joint.K, mu, sign * order, increment=increment, exposed=exposed)
    own = {role: values for role, values in c.along.items() if role not in ("phi", "T", "W")}
    own["torque"] = sign * c.along["T"]
    v = in_si(beam, joint, order, own)
    reached, v["tangent"] = np.isfinite(own["torque"]), np.full(order.size, np.nan)
    if reached.sum() > 1:
        v["tangent"][reached] = np.gradient(v["torque"][reached], v["rate"][reached])
    v["f0"], total = v["f"] * beam.scale.length / joint.K_theta, v["U_el"] + v["W_fr"]
    v["RED"] = np.divide(v["W_fr"], total, out=np.where(reached, 0.0, np.nan), where=total > 0)
    last = {role: float(values[reached][-1]) if reached.any() else np.nan for role, values in v.items()}
    found = {
        **figures(joint.case(beam, sign), last, abs(c.phi_e), abs(c.phi_end), last["theta"]),
        "end": str(End(c.end)),
        **contacts(c.contacts),
        "energy_error": c.unbalanced,
    }
    return Curve({role: v[role][back] for role in _ALONG}, found)


def contacts(met: Sequence[Contacts]) -> dict[str, int | str]:
    """Return which neighbour is followed, what touches first, and what else comes in later, by role."""
    first = met[0] if met else None
    other = next((t for t in met if t.k and first and (t.k, t.pair) != (first.k, first.pair)), None)
    return {
        "neighbour": first.k if first else 0,
        "other_contact": f"{other.pair} (k = {other.k}) at {abs(other.phi):.4g} rad/pitch" if other else "",
        "first_contact": f"{first.pair} (k = {first.k})" if first else "",
    }

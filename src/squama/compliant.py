"""The compliant joint in SI units: a beam's stiffness from finite elements, and its curves.

Each scale has six motions against the substrate; the elements give their stiffness, and the plates touch anywhere
(docs, theory: compliant joint). The force law is that of edges: contact pushes along the common normal.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from squama.curve import Curve
from squama.design import Beam
from squama.fe import condense
from squama.fe.plate import MOTIONS, Rest
from squama.model.outcome import End
from squama.model.solve import Array

STRAIN_LIMIT = 0.3
"""Twist per pitch, rad, up to which the model was compared with nonlinear elements."""
RANGE = 0.3
"""Twist per pitch, rad, to which a curve goes unless asked otherwise."""


class Stiffness(NamedTuple):
    """Stiffness of a scale's joint: ``K`` (7, 7) in E d^3, E d^2 and E d; K_theta and the beam's rigidity in SI."""

    K: Array
    K_theta: float
    rigidity: float


def stiffness(beam: Beam) -> Stiffness:
    """Return the stiffness of a beam's joint: the beam's own matrix, or one from finite elements.

    Raises
    ------
    InputError
        A package for the elements is missing, or the beam cannot be meshed.
    """
    K = matrix(beam)
    unit = beam.substrate.youngs_modulus * beam.pitch**3
    K_theta = float(1 / np.linalg.inv(K[:6, :6])[4, 4])
    return Stiffness(K, K_theta * unit, condense.rigidity(K) * unit * beam.pitch)


def matrix(beam: Beam) -> Array:
    """Return the (7, 7) matrix over the six motions and the twist per pitch, E = 1 and d = 1."""
    if beam.joint.matrix is not None:
        return beam.joint.matrix.K
    from squama.fe.joint import joint_matrix

    return np.asarray(joint_matrix(beam).K, float)


def rest(beam: Beam) -> Rest:
    """Return a scale at rest, in pitches."""
    return Rest.at(beam.eta, beam.beta, beam.lam, beam.scale.alpha, beam.scale.theta0)


def warnings(beam: Beam, far: float) -> list[str]:
    """Say where a curve to the twist ``far`` (rad per pitch) leaves what the model was compared with."""
    lines = []
    if far > STRAIN_LIMIT:
        lines.append(
            f"the compliant joint's stiffness is that of small strains: it was compared with nonlinear elements up to "
            f"{STRAIN_LIMIT:g} rad per pitch, and the curve goes to {far:.3g}"
        )
    given = [name for name in ("stiffness", "inclusion_factor") if getattr(beam.joint, name) is not None]
    if given and beam.joint.matrix is None:
        lines.append(f"joint.{' and joint.'.join(given)}: not used by the compliant joint, whose stiffness is computed")
    return lines


def curve(
    beam: Beam, joint: Stiffness, mu: float, loads: Array, *, sign: int, increment: float = condense.INCREMENT
) -> Curve:
    """Return a curve at twists per pitch (magnitudes, rad, any order), by the roles of :mod:`squama.curve`.

    Parameters
    ----------
    sign : int
        1 or -1: the sense of the twist.
    increment : float
        Largest increment, rad per pitch.
    """
    order, back = np.unique(loads, return_inverse=True)
    c = condense.curve(rest(beam), joint.K, mu, sign * order, increment=increment)
    d, E = beam.pitch, beam.substrate.youngs_modulus
    rate, T = order / d, sign * c.T * E * d**3
    reached = np.isfinite(c.T)
    tangent = np.full(order.size, np.nan)
    if reached.sum() > 1:
        tangent[reached] = np.gradient(T[reached], rate[reached])
    f, U, W_fr = c.f * E * d**2, c.U * E * d**2, c.W_fr * E * d**2
    total = U + W_fr
    along = {
        "theta": c.theta,
        "load": order,
        "rate": rate,
        "torque": T,
        "scales": T - joint.rigidity * rate,
        "tangent": tangent,
        "N": c.N * E * d**2,
        "f": f,
        "f0": f * beam.scale.length / joint.K_theta,
        "p": c.p * d,
        "s": c.s * d,
        "elastic": U,
        "work": W_fr,
        "RED": np.divide(W_fr, total, out=np.where(reached, 0.0, np.nan), where=total > 0),
        "gap": c.gap * d,
        **{name: c.v[:, i] * (d if name.startswith("u") else 1.0) for i, name in enumerate(MOTIONS)},
    }
    return Curve({role: values[back] for role, values in along.items()}, _figures(c, along, reached, joint, d))


def _figures(
    c: condense.Condensed, along: dict[str, Array], reached: Any, joint: Stiffness, d: float
) -> dict[str, Any]:
    last = {role: float(values[reached][-1]) if reached.any() else np.nan for role, values in along.items()}
    first = c.contacts[0] if c.contacts else None
    other = next((t for t in c.contacts if t.k and first and (t.k, t.pair) != (first.k, first.pair)), None)
    bare = joint.rigidity * last["rate"]
    return {
        "load_e": abs(c.phi_e),
        "rate_e": abs(c.phi_e) / d,
        "theta_end": last["theta"],
        "load_end": abs(c.phi_end),
        "rate_end": abs(c.phi_end) / d,
        "theta_c": last["theta"],
        "rate_c": last["rate"],
        "torque_c": last["torque"],
        "stiffening": last["torque"] / bare if bare else np.nan,
        "elastic_c": last["elastic"],
        "work_c": last["work"],
        "RED_c": last["RED"],
        "end": str(End(c.end)),
        "neighbour": first.k if first else 0,
        "other_contact": f"{other.pair} (k = {other.k}) at {abs(other.phi):.4g} rad/pitch" if other else "",
        "first_contact": f"{first.pair} (k = {first.k})" if first else "",
        "energy_error": c.unbalanced,
    }

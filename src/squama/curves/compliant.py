"""The compliant joint in SI units: a beam's stiffness from finite elements, and its curves.

Each scale has six motions against the substrate; the elements give their stiffness, and the plates touch anywhere
(docs, theory: compliant joint). The force law is that of edges: contact pushes along the common normal.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from squama.beam import matrixfile
from squama.beam.design import Beam
from squama.curves.path import Asked, Case, Curve, States, figures
from squama.errors import refuse
from squama.fe import condense
from squama.fe.plate import MOTIONS, Rest
from squama.fe.walk import Contacts
from squama.model.outcome import End
from squama.types import Array

STRAIN_LIMIT = 0.3
"""Twist per pitch, rad, up to which the model was compared with nonlinear elements."""
RANGE = 0.3
"""Twist per pitch, rad, to which a curve goes unless asked otherwise."""


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


def stiffness(beam: Beam) -> Stiffness:
    """Return the stiffness of a beam's joint: the beam's own matrix, or one from finite elements."""
    K = matrix(beam)
    unit, rigidity = beam.substrate.youngs_modulus * beam.pitch**3, matrixfile.twisting_stiffness(K)
    return Stiffness(K, matrixfile.inclination_stiffness(K) * unit, rigidity * unit * beam.pitch)


def matrix(beam: Beam) -> Array:
    """Return the (7, 7) matrix over the six motions and the twist per pitch, E = 1 and d = 1."""
    if beam.joint.matrix is not None:
        return beam.joint.matrix.K
    from squama.fe.stiffness import joint

    return np.asarray(joint(beam).K, float)


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


class Path(NamedTuple):
    """A beam's path in one sense: its stiffness, friction, and the twist per pitch to which it goes."""

    beam: Beam
    joint: Stiffness
    mu: float
    sign: int
    far: float

    @property
    def case(self) -> Case:
        """What the beam and the elements bring."""
        return self.joint.case(self.beam, self.sign)

    def curve(self, *, points: int, at: Array | None = None) -> Curve:
        """Return the curve at evenly spaced twists, or at twists per pitch; NaN beyond an earlier end."""
        loads = np.linspace(0.0, self.far, points) if at is None else at
        return curve(self.beam, self.joint, self.mu, loads, sign=self.sign)


def solve(asked: Asked) -> tuple[list[Path], States]:
    """Return the paths of a beam for each coefficient of friction; what is asked of them is walked then."""
    beam, to = asked.beam, abs(asked.path.values[-1])
    far = RANGE if to == math.inf else to
    if far >= math.pi:
        refuse("to", f"{far / beam.pitch:.6g} rad/m", "must be below half a turn per pitch")
    joint, sign = stiffness(beam), -1 if asked.path.sense == "-" else 1
    notes = warnings(beam, far if asked.at is None else float(np.max(asked.at)))
    found = [Path(beam, joint, float(mu), sign, far) for mu in np.atleast_1d(asked.mus)]
    return found, States({}, {"K_theta": joint.K_theta, "rigidity": joint.rigidity}, notes)


def in_si(beam: Beam, joint: Stiffness, load: Array, own: dict[str, Array]) -> dict[str, Array]:
    """Give values of the incremental model, where E = 1 and d = 1, their units, by role; with the rate and its load."""
    d, E = beam.pitch, beam.substrate.youngs_modulus
    units = dict.fromkeys(("p", "s", "gap", "u_X", "u_Y", "u_Z"), d) | {"torque": E * d**3}
    units |= dict.fromkeys(("N", "f", "U_el", "W_fr"), E * d**2)
    values = {role: v * units.get(role, 1.0) for role, v in own.items()}
    rate = load / d
    return {**values, "load": load, "rate": rate, "scales": values["torque"] - joint.rigidity * rate}


def curve(
    beam: Beam, joint: Stiffness, mu: float, loads: Array, *, sign: int, increment: float = condense.INCREMENT
) -> Curve:
    """Return a curve at twists per pitch (magnitudes, rad, any order), by the roles of :mod:`squama.loads`.

    ``sign`` is that of the twist, ``increment`` the largest one, rad per pitch.
    """
    order, back = np.unique(loads, return_inverse=True)
    c = condense.curve(rest(beam), joint.K, mu, sign * order, increment=increment)
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

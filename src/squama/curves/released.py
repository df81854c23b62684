"""A beam that is loaded by one load alone: twisted without a bending moment, or bent without a torque.

:func:`squama.twist` holds a beam straight, :func:`squama.bend` holds it from twisting, and neither has an axial force.
Once scales on one face touch, that takes a bending moment ``M``, or a torque ``T``. Here the beam is free to bow, or to
twist: the other strain is an unknown, and its moment or torque is zero.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from squama.beam.design import Beam
from squama.contacts import path, states
from squama.curves import real
from squama.loads import LOADS
from squama.model.outcome import SENTENCES, End
from squama.types import Array

_SLOPE = 2.5e-3
"""Step of the load over which the tangent stiffness is taken, rad per pitch."""
SEVEN = "joint.matrix knows no bend; squama joint --matrix writes all nine motions"


class Released(NamedTuple):
    """States of an endless beam under one load alone, at load angles per pitch (n,); NaN where not known.

    ``strain``: the other strain per pitch (bend of a twisted beam, twist of a bent one), rad; ``torque``: torque of a
    twisted beam, moment of a bent one, N m; ``tangent`` stiffness, N m^2; ``stiffness_ratio``: that over ``rigidity``,
    N m^2, of the same beam before contact. ``note`` says why values are missing.
    """

    strain: Array
    torque: Array
    tangent: Array
    stiffness_ratio: Array
    rigidity: float
    note: str


def released(beam: Beam, load: str, mu: float, at: Array | float, *, ideal: bool = False, sense: str = "+") -> Released:
    """Twist a beam that is free to bow, or bend one that is free to twist.

    Parameters
    ----------
    beam
        The beam, on its compliant joint.
    load
        "twisting" or "bending".
    mu
        Coefficient of friction.
    at
        Load angles per pitch, rad, magnitudes in any order.
    ideal
        Thin, rigid scales.
    sense
        "+" or "-", as of :func:`squama.twist`.
    """
    at = np.atleast_1d(np.asarray(at, float))
    held = real.Held.of(beam.replace(hold="lateral bend"), LOADS[load].verb)
    if not any(held.free):
        none = np.full(at.size, np.nan)
        return Released(none, none, none, none, math.nan, SEVEN)
    sign, unit, d, twisted = -1 if sense == "-" else 1, beam.unit_moment, beam.pitch, LOADS[load].axis == 1
    scale = path.Scale(*np.array([real.scale(beam, ideal=ideal)]).T)
    one = path.beams(scale, held.K[None], np.array([mu]), sense=sign if twisted else 1, **held.bar)
    nodes = np.unique(np.concatenate([at, at + _SLOPE, np.maximum(at - _SLOPE, 0.0)]))
    nodes = nodes[nodes > 0]
    corners = np.zeros((1, nodes.size, 2))
    corners[0, :, int(twisted)] = nodes
    found = path.follow_all(one, nodes[None], corners=corners)
    v = path.named(found.rows[0])
    strain, torque = (v["psi"], v["torque"]) if twisted else (sign * v["twist"], v["M"])
    (word,) = path.endings(found.contacts, found.ends)
    note = "" if np.isfinite(torque[np.isin(nodes, at)]).all() else SENTENCES[End(str(word))]
    nodes, strain, torque = (np.append(0.0, x) for x in (nodes, strain, torque))
    which = np.searchsorted(nodes, at)
    tangent = _slopes(nodes, torque)[which] * unit * d
    axis = int(not twisted)
    rigidity = float(states.bare(one)[0, axis, axis]) * unit * d
    return Released(strain[which], torque[which] * unit, tangent, tangent / rigidity, rigidity, note)


def _slopes(x: Array, y: Array) -> Array:
    """Return the slopes of y (n,), by the interval before a point where the one behind it is not known."""
    slope = np.gradient(y, x) if x.size > 1 else np.full(x.size, np.nan)
    before = np.append(np.nan, np.diff(y) / np.diff(x))
    return np.where(np.isfinite(slope), slope, before)

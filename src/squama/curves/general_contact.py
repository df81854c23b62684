"""Curves by general contact, in SI units: scales on a joint of six motions that may touch anywhere.

It follows what the real model cannot (:mod:`squama.curves.real`): other pairs of edges and faces, two contacts at once.
It needs the extra fe.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from squama.beam.design import Beam
from squama.beam.matrixfile import MOTIONS
from squama.curves.path import Case, Curve, figures, in_si
from squama.fe import bending
from squama.fe.assembly import make_bent
from squama.fe.exposed import Exposed, box, sheet
from squama.fe.geometry import geometry
from squama.fe.walk import Contacts
from squama.model.elastic_plate import monomials
from squama.model.outcome import End
from squama.progress import steps
from squama.real.path import STEP, Scale, plate_figures
from squama.types import Array

_STATE = ("theta", "N", "f", "U_el", "W_fr", "gap", "p", "s")
"""Roles that columns of elements have by the same name."""
_GRID = (6, 3)
"""Parts of a bent plate along and across, where it may touch anywhere."""


class Led(NamedTuple):
    """States at the points that were reached, rest the first: columns by name; the way and the word of the end.

    ``moved`` (n, points, 3): how far the points of a scale's surface have moved in its frame.
    """

    columns: dict[str, Array]
    words: list[str]
    moved: Array
    contacts: Sequence[Contacts]
    way: float
    end: str


def lead(
    beam: Beam, K: Array, mu: float, scale: Scale, free: Sequence[str], legs: Sequence[tuple[Array, Array]]
) -> Led:
    """Follow a beam along straight legs, each the strains (psi, phi) at its end and the ways (n,) of its points.

    ``K`` (9, 9) holds a ``scale``, or (7, 7) where the beam is twisted alone; ``free``: which of "stretch", "bend" and
    "twist" are not imposed. E = 1 and d = 1.
    """
    whole = np.eye(9)
    # bend and stretch are imposed where a matrix knows none
    whole[: len(K), : len(K)] = K
    walk = make_bent(whole, geometry(beam), mu, free=free, exposed=surface(scale))
    walk.begin()
    kept, moved, end = [0], [walk.moved[:, :, 0]], str(End.RANGE)
    for strains, ways in legs:
        goal = walk.aim(*strains)
        # the way that is aimed at is the last one but for rounding
        places = [*ways[ways > walk.phi][:-1].tolist(), goal]
        for way in steps(places, len(places), "points by general contact"):
            if not walk.run(way, STEP).reached:
                end = walk.ending(STEP)
                break
            kept.append(len(walk.columns["way"]) - 1)
            moved.append(walk.moved[:, :, 0])
        if end != End.RANGE:
            break
    names = [name for name in walk.columns if name != "contact"]
    columns = {name: np.array(walk.columns[name], float)[kept] for name in names}
    words = [str(walk.columns["contact"][i]) for i in kept]
    return Led(columns, words, np.array(moved), walk.contacts, float(walk.phi), end)


def curve(beam: Beam, K: Array, mu: float, loads: Array, scale: Scale, *, sign: int, stretch: str) -> Curve:
    """Return a curve at twists per pitch (magnitudes, rad, any order), by the roles of :mod:`squama.loads`.

    ``K`` (7, 7) or (9, 9) holds a ``scale``, E = 1 and d = 1; ``sign`` is that of the twist.
    """
    case = Case.held(beam, K, sign)
    order, back = np.unique(loads, return_inverse=True)
    free = ("stretch",) * (stretch == "free")
    led = lead(beam, K, mu, scale, free, [(np.array([0.0, sign * order[-1]]), order)])
    # the state at rest may not be asked for; behind the end nothing is known
    first = int(order[0] > 0)
    own = {name: np.full(order.size, np.nan) for name in led.columns}
    n = len(led.moved) - first
    for name, values in led.columns.items():
        own[name][:n] = values[first:]
    bent = np.full((order.size, *led.moved.shape[1:]), np.nan)
    bent[:n] = led.moved[first:]
    torque, work = sign * own["T"], own["W"]
    own = {role: own[role] for role in (*MOTIONS, *_STATE, *(("M", "stretch") if len(K) == 9 else ()))}
    own |= plate_figures(scale, deflections(scale, surface(scale), bent))
    v = in_si(case, beam.substrate.youngs_modulus, order, own | {"torque": torque})
    reached, v["tangent"] = np.isfinite(v["torque"]), np.full(order.size, np.nan)
    if reached.sum() > 1:
        v["tangent"][reached] = np.gradient(v["torque"][reached], v["rate"][reached])
    last = {role: float(values[reached][-1]) if reached.any() else np.nan for role, values in v.items()}
    engaged = led.contacts[0].phi if led.contacts else math.inf
    lost = work[reached][-1] - own["U_el"][reached][-1] - own["W_fr"][reached][-1] if reached.any() else 0.0
    found = {
        **figures(case, last, engaged, led.way, last["theta"]),
        "end": led.end,
        **contacts(led.contacts),
        "energy_error": float(lost / work[reached][-1]) if reached.any() and work[reached][-1] else 0.0,
    }
    return Curve({role: values[back] for role, values in v.items()}, found)


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

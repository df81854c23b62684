"""Columns of thick, elastic scales on a joint that gives, followed to a twist, with figures in SI units.

The counterpart of :mod:`squama.study.hinge_columns` for thick scales on compliant joints.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from squama.arrays.compliant_beams import Designs, Response, follow
from squama.beam.parts import PLASTIC
from squama.contacts import path
from squama.contacts.own_scales import Own
from squama.model.outcome import End
from squama.study.columns import Cells
from squama.types import Array

STEPS = 41
"""Steps of a curve up to the twist at which figures are taken; one more tells the slope there.

An odd number: a beam that engages at half the twist, or near it, does so between two of them.
"""
UNKNOWN = "joint unknown"
"""How a beam ends whose joint the law does not know."""
ENDS = (*path.WORDS.tolist(), UNKNOWN)
"""Ends in words, by their codes."""
_RANGE, _NONE = ENDS.index(End.RANGE), ENDS.index(End.NONE)
AT_ONCE = 4096
"""Beams that are followed at once."""
_GRID = np.arange(STEPS + 2) / STEPS
_BEHIND = 1e-3 / STEPS
"""First place of the curve of a beam that is held bent, as a part of the twist: behind the corner of its path."""
LEVELS = {"twofold": 2.0, "fivefold": 5.0}
"""Tangent stiffness over that without contact whose twist is a figure."""


class Figures(NamedTuple):
    """What is known of n beams with thick scales, arrays (n,); NaN where a beam has no such figure.

    ``load_e`` (inf: no engagement), ``load_end`` and the ``load_*`` at which the tangent stiffness is twice and
    five times that without contact, and at which a scale reaches its strength, in rad per pitch, no further than
    the twist asked for, 0 of a beam that is held bent where that is while it is bent; ``code`` of :data:`ENDS`; at
    that twist ``torque`` (N m), ``tangent`` (N m^2), ``stiffness_ratio``, ``N`` (N), ``stress`` (Pa), ``W_fr``,
    ``U_el`` (J/m; without what snaps lost), ``RED``; with the beam's own scales ``finite_torque``
    (N m) and ``finite_stiffness_ratio``, and ``finite_ratio`` of torques to the endless beam's. ``K_theta`` (N m) and
    ``rigidity`` (N m^2) of the joint.
    """

    load_e: Array
    load_end: Array
    code: Array
    torque: Array
    tangent: Array
    stiffness_ratio: Array
    N: Array
    stress: Array
    W_fr: Array
    U_el: Array
    RED: Array
    finite_torque: Array
    finite_stiffness_ratio: Array
    finite_ratio: Array
    load_twofold: Array
    load_fivefold: Array
    load_strength: Array
    K_theta: Array
    rigidity: Array


def solved(
    c: Cells,
    at: Array | float,
    *,
    load: str = "twisting",
    sense: str = "+",
    ideal: bool = False,
    copies: int = 0,
    along: bool = True,
    own: Own | None = None,
) -> Figures:
    """Follow beams to the twists, or bends, ``at`` (rad per pitch); all arrays broadcast, the result is flat.

    Cells are those of twisting whatever the load is: the joint's matrix knows both.

    The joint is that of the beam's matrix or the law's, with a stiffness and an inclusion factor as they are given, its
    K_theta times the cells' ``joint_factor``; ``ideal``: scales are thin and rigid. Memory is that of
    :data:`AT_ONCE` curves, whatever n is. With complex steps, each beam ``copies`` times, one after the other, figures
    are complex. Without ``along`` a stress is known at the twist only, and no ``load_strength``; without
    ``own``, the beam's own number of scales and its ends, none of these three.
    """
    scale, bar = c.sizes["scale"], c.sizes["substrate"]
    E, d = bar["youngs_modulus"], c.d
    columns = {
        **{name: getattr(c, name) for name in ("eta", "beta", "lam", "alpha", "theta0", "mu")},
        "zeta": scale["embedded"] / d,
        "thickness": scale["thickness"] / d,
        "width": bar["width"] / d,
        "nu": bar["poisson_ratio"],
        "modulus_ratio": scale.get("youngs_modulus", np.inf) / E,
        "scale_nu": scale.get("poisson_ratio", PLASTIC),
        "K_theta": None if c.given.stiffness is None else c.K / (E * d**3),
        "rigidity": None if c.given.inclusion_factor is None else c.rigidity / (E * d**4),
        "factor": c.joint_factor,
        "psi": c.psi,
        "unit": E * d**3,
        "pitch": d,
        "to": at,
        "strength": scale.get("strength", np.inf) / E,
    }
    there = {name: v for name, v in columns.items() if v is not None}
    flat = dict(zip(there, (v.ravel() for v in np.broadcast_arrays(*there.values())), strict=True))
    kind, n = np.result_type(*flat.values()), flat["to"].size
    # the last place of a curve is behind the twist
    own = own and own._replace(states=slice(-1))
    most = AT_ONCE // max(1, copies) * max(1, copies)

    def part(low: int) -> Figures:
        some = {name: np.ascontiguousarray(v[low : low + most], kind) for name, v in flat.items()}
        designs = Designs(**{name: some.pop(name) for name in Designs._fields if name in some})
        to, strength = some["to"], some["strength"]
        twists = to[:, None] * (_GRID if designs.psi is None else np.maximum(_GRID, _BEHIND))
        # a curve of stresses is for the twist at which a scale reaches its strength
        stressed = slice(None if along and np.isfinite(strength).any() else STEPS, STEPS + 1)
        r = follow(
            designs,
            twists,
            c.given,
            load=load,
            most=np.maximum(to.real, path.RANGE),
            ideal=ideal,
            sense=-1 if sense == "-" else 1,
            copies=copies,
            stressed=stressed,
            own=own,
        )
        return _figures(r, twists, strength, some["unit"], some["pitch"])

    parts = [part(low) for low in range(0, max(1, n), most)]
    return Figures(*map(np.concatenate, zip(*parts, strict=True)))


def _figures(r: Response, twists: Array, strength: Array, unit: Array, pitch: Array) -> Figures:
    """Return the figures of curves at ``STEPS`` twists and two more; ``unit`` of torque, strength over E."""
    to = twists[:, STEPS]
    code = np.array([ENDS.index(word or UNKNOWN) for word in r.end.tolist()])
    # what comes behind the twist is of no interest
    code = np.where(r.phi_end.real >= to.real, np.where(np.isfinite(r.phi_e), _RANGE, _NONE), code)
    names = ("torque", "stiffness_ratio", "N", "stress", "W_fr", "W_snap", "W")
    last = {name: getattr(r, name)[:, STEPS] for name in names}
    rigidity = r.rigidity * unit * pitch
    with np.errstate(all="ignore"):
        RED = last["W_fr"] / last["W"]
    ratio = np.where(twists.real >= r.phi_e.real[:, None], r.stiffness_ratio, np.nan)[:, : STEPS + 1]
    return Figures(
        load_e=r.phi_e,
        load_end=np.minimum(r.phi_end.real, to.real),
        code=code,
        torque=last["torque"] * unit,
        tangent=last["stiffness_ratio"] * rigidity,
        stiffness_ratio=last["stiffness_ratio"],
        N=last["N"] * unit / pitch,
        stress=last["stress"] * unit / pitch**3,
        W_fr=last["W_fr"] * unit / pitch,
        U_el=(last["W"] - last["W_fr"] - last["W_snap"]) * unit / pitch,
        RED=RED,
        finite_torque=last["torque"] * unit * r.finite_ratio,
        finite_stiffness_ratio=last["stiffness_ratio"] * r.finite_tangent,
        finite_ratio=r.finite_ratio,
        **{f"load_{name}": first(twists, ratio, np.full(to.size, level), r.phi_e) for name, level in LEVELS.items()},
        load_strength=first(twists, r.stress[:, : STEPS + 1], strength, r.phi_e),
        K_theta=r.K_theta * unit,
        rigidity=rigidity,
    )


def first(x: Array, y: Array, level: Array, start: Array) -> Array:
    """Return where y (n, m) first comes to a level (n,), linear between the x (n, m or more); NaN where it does not.

    Where it is known from there on only, that is ``start`` (n,).
    """
    above, rows = np.real(y) >= np.real(level)[:, None], np.arange(len(y))
    i = above.argmax(axis=1)
    before = np.maximum(i - 1, 0)
    low, high = y[rows, before], y[rows, i]
    with np.errstate(all="ignore"):
        found = x[rows, before] + (level - low) / (high - low) * (x[rows, i] - x[rows, before])
    found = np.where((i > 0) & np.isfinite(low), found, start)
    return np.where(above.any(axis=1), found, np.nan)

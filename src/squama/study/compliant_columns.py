"""Figures at a twist, in SI units, of many beams with thick, elastic scales on compliant joints.

The counterpart of :mod:`squama.study.hinge_columns`: the contact path of each beam is followed up to the twist.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from squama.arrays.compliant_beams import Designs, Response, follow
from squama.beam.parts import PLASTIC
from squama.contacts import path
from squama.contacts.own_scales import Own
from squama.curves.curve_figures import TIMES
from squama.model.outcome import End
from squama.study.columns import Cells
from squama.types import Array

STEPS = 41
"""Steps of a curve up to the twist at which figures are taken; one more step gives the slope there.

An odd number, so that an engagement at or near half the twist falls between two steps.
"""
UNKNOWN = "joint unknown"
"""End of a beam whose joint the law does not cover."""
ENDS = (*path.WORDS.tolist(), UNKNOWN)
"""Ends of curves in words; the index is the code."""
_RANGE, _NONE = ENDS.index(End.RANGE), ENDS.index(End.NONE)
AT_ONCE = 4096
"""Number of beams that are followed together."""
_GRID = np.arange(STEPS + 2) / STEPS
_BEHIND = 1e-3 / STEPS
"""First point of the curve of a bent beam, as a share of the twist: just beyond the corner of its path."""


class Figures(NamedTuple):
    """Figures of n beams with thick scales, arrays (n,); NaN where a beam does not have the figure.

    In rad per pitch, up to the twist asked for: ``load_e`` at engagement (inf: none), ``load_end`` at the end,
    ``load_twofold`` and ``load_fivefold`` where the tangent stiffness is two and five times that without contact,
    ``load_strength`` where a scale reaches its strength; 0 for a beam held bent that is there before it is twisted.
    ``code`` is an index of :data:`ENDS`. At the twist: ``torque`` (N m), ``tangent`` (N m^2), ``stiffness_ratio``,
    ``N`` (N), ``stress`` (Pa), ``W_fr`` and ``U_el`` (J/m; ``U_el`` without the energy lost in snaps), ``RED``. For the
    beam's own number of scales: ``finite_torque`` (N m), ``finite_stiffness_ratio`` and ``finite_ratio``, its torque
    over that of the endless beam. Of the joint: ``K_theta`` (N m) and ``rigidity`` (N m^2).
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

    ``c`` holds the columns of twisting for both loads. The joint is the beam's matrix or that of the law, with
    stiffness and inclusion factor replaced where the beam states them, and K_theta times ``c.joint_factor``; ``ideal``:
    scales are thin and rigid. For complex-step derivatives each beam comes ``copies`` times in a row, and figures are
    complex. ``along=False`` computes the stress at the twist only, without ``load_strength``; without ``own`` (the
    beam's number of scales and its ends) the three ``finite_*`` figures are NaN.
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
    # the last point of a curve lies beyond the twist
    own = own and own._replace(states=slice(-1))
    most = AT_ONCE // max(1, copies) * max(1, copies)

    def part(low: int) -> Figures:
        some = {name: np.ascontiguousarray(v[low : low + most], kind) for name, v in flat.items()}
        designs = Designs(**{name: some.pop(name) for name in Designs._fields if name in some})
        to, strength = some["to"], some["strength"]
        twists = to[:, None] * (_GRID if designs.psi is None else np.maximum(_GRID, _BEHIND))
        # stresses along the curve serve only to find the twist at which a scale reaches its strength
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
    """Return figures from curves at ``STEPS`` + 2 twists (n, m); ``unit``: N m per unit of torque; strength over E."""
    to = twists[:, STEPS]
    code = np.array([ENDS.index(word or UNKNOWN) for word in r.end.tolist()])
    # an end beyond the twist does not count
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
        **{f"load_{name}": first(twists, ratio, np.full(to.size, level), r.phi_e) for name, level in TIMES.items()},
        load_strength=first(twists, r.stress[:, : STEPS + 1], strength, r.phi_e),
        K_theta=r.K_theta * unit,
        rigidity=rigidity,
    )


def first(x: Array, y: Array, level: Array, start: Array) -> Array:
    """Return where y (n, m) first reaches a level (n,), linear between points x (n, m or more); NaN where it does not.

    Where y is known only from there on, the result is ``start`` (n,).
    """
    above, rows = np.real(y) >= np.real(level)[:, None], np.arange(len(y))
    i = above.argmax(axis=1)
    before = np.maximum(i - 1, 0)
    low, high = y[rows, before], y[rows, i]
    with np.errstate(all="ignore"):
        found = x[rows, before] + (level - low) / (high - low) * (x[rows, i] - x[rows, before])
    found = np.where((i > 0) & np.isfinite(low), found, start)
    return np.where(above.any(axis=1), found, np.nan)

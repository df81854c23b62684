"""Columns of real beams: thick, elastic scales on a joint that gives, followed to a twist, with figures in SI units.

The counterpart of :func:`squama.study.columns.solved` for the real model.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from squama.arrays.real_beams import Designs, follow
from squama.beam.parts import PLASTIC
from squama.contacts import path
from squama.joints import law
from squama.joints.factor import K_THETA, pivots, scaled
from squama.loads import LOADS
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
    """What is known of n real beams, arrays (n,); NaN where a beam has no such figure.

    ``load_e`` (inf: no engagement), ``load_end`` and the ``load_*`` at which the tangent stiffness is twice and
    five times that without contact, and at which a scale reaches its strength, in rad per pitch, no further than
    the twist asked for, 0 of a beam that is held bent where that is while it is bent; ``code`` of :data:`ENDS`; at
    that twist ``torque`` (N m), ``tangent`` (N m^2), ``stiffness_ratio``, ``N`` (N), ``stress`` (Pa), ``W_fr``,
    ``U_el`` (J/m; without what snaps lost), ``RED``. ``K_theta`` (N m) and ``rigidity`` (N m^2) of the joint.
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
    load_twofold: Array
    load_fivefold: Array
    load_strength: Array
    K_theta: Array
    rigidity: Array


class _Beams(NamedTuple):
    """Flat columns of beams: what :func:`squama.arrays.real_beams.follow` takes, and what has units."""

    designs: Designs
    unit: Array
    pitch: Array
    to: Array
    strength: Array
    K_theta: Array
    rigidity: Array
    factor: Array
    psi: Array


def solved(
    c: Cells, at: Array | float, *, load: str = "twisting", sense: str = "+", ideal: bool = False, copies: int = 0,
    along: bool = True, threads: int | None = None,
) -> Figures:  # fmt: skip
    """Follow beams to the twists, or bends, ``at`` (rad per pitch); all arrays broadcast, the result is flat.

    Cells are those of twisting whatever the load is: the joint's matrix knows both.

    The joint is that of the beam's matrix or the law's, with a stiffness and an inclusion factor as they are given, its
    K_theta times the cells' ``joint_factor``; ``ideal``: scales are thin and rigid. Memory is that of
    :data:`AT_ONCE` curves, whatever n is. With complex steps, each beam ``copies`` times, one after the other, figures
    are complex. Without ``along`` a stress is known at the twist only, and no ``load_strength``.
    """
    scale, bar = c.sizes["scale"], c.sizes["substrate"]
    E, d = bar["youngs_modulus"], c.d
    columns = (
        c.eta, c.beta, c.lam, scale["embedded"] / d, c.alpha, c.theta0, scale["thickness"] / d, bar["width"] / d,
        bar["poisson_ratio"], c.mu, scale.get("youngs_modulus", np.inf) / E, scale.get("poisson_ratio", PLASTIC),
        E * d**3, d, at, scale.get("strength", np.inf) / E, c.K / (E * d**3), c.rigidity / (E * d**4),
        1.0 if c.joint_factor is None else c.joint_factor, np.nan if c.psi is None else c.psi,
    )  # fmt: skip
    flat = [v.ravel() for v in np.broadcast_arrays(*columns)]
    ratios = len(Designs._fields)

    def part(low: int) -> Figures:
        some = [np.ascontiguousarray(v[low : low + most], np.result_type(*flat)) for v in flat]
        b = _Beams(Designs(*some[:ratios]), *some[ratios:])
        return _part(c, b, load, -1 if sense == "-" else 1, ideal, copies, along, threads)

    most = AT_ONCE // max(1, copies) * max(1, copies)
    parts = [part(low) for low in range(0, max(1, flat[0].size), most)]
    return Figures(*map(np.concatenate, zip(*parts, strict=True)))


def _joints(c: Cells, b: _Beams, i: Array) -> Array:
    """Return the joints of some of the beams."""
    stiffness, inclusion, matrix = c.given[:3]
    if matrix is None:
        K = law.stiffness(b.designs.shape.at(i))
    else:
        K = np.broadcast_to(matrix.K, (*i.shape, *matrix.K.shape)).astype(b.unit.dtype)
    K_theta = None if stiffness is None else b.K_theta[i]
    if c.joint_factor is not None:
        K_theta = b.factor[i] * (pivots(K)[..., K_THETA] if K_theta is None else K_theta)
    rigidity = None if inclusion is None else b.rigidity[i]
    if K_theta is None and rigidity is None:
        return K
    return scaled(K, K_theta=K_theta, rigidity=rigidity, free=c.given.free("twist"))


def _part(
    c: Cells, b: _Beams, load: str, sense: int, ideal: bool, copies: int, along: bool, threads: int | None
) -> Figures:  # fmt: skip
    """Return the figures of so many beams as are followed at once."""
    _, unit, pitch, to, strength, *_, psi = b
    known = law.within(b.designs.shape) if c.given.matrix is None else np.ones(unit.size, bool)
    held = None if c.psi is None else psi
    twists = to[:, None] * (_GRID if held is None else np.maximum(_GRID, _BEHIND))
    # a curve of stresses is for the twist at which a scale reaches its strength
    along = along and bool(np.isfinite(strength).any())
    r = follow(
        b.designs, twists, K=lambda i: _joints(c, b, i), known=known, most=np.maximum(to.real, path.RANGE), ideal=ideal,
        sense=sense, copies=copies, held=held, load=load,
        free=c.given.free(*(("bend", "twist") if held is not None else (LOADS[load].verb,))), threads=threads,
        stressed=slice(None if along else STEPS, STEPS + 1),
    )  # fmt: skip
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

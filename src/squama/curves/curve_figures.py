"""Single values of curves and of closed loops, by role (:mod:`squama.loads`), common to all models."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import pairwise

import numpy as np

from squama.curves.way import Case
from squama.types import Array

TIMES = {"twofold": 2.0, "fivefold": 5.0}
"""Multiples of the bare beam's tangent stiffness for which the load angle is reported."""
FINE = 2e-3
"""Largest step of the load angle, rad per pitch, along a path from which single values are taken."""
NEAR = 1e-5
"""Smallest step for a slope, rad per pitch."""
PLACES = ("psi", "phi", "kappa", "Phi", "theta")
"""Quantities of a place on a path of bends and twists: bend and twist per pitch and per length, inclination."""
LOOP = ("base", "top", "W_d", "U_max", "zeta_eq", "K_sec", "drop", "residual")
"""Single values of a closed loop."""


def figures(
    case: Case, last: Mapping[str, float], load_e: float, load_end: float, theta_end: float
) -> dict[str, float | int | str]:
    """Return the single values of every curve, by role; ``last`` are its variables at the cut-off."""
    bare = case.rigidity * last["rate"]
    return {
        "load_e": load_e,
        "rate_e": load_e / case.pitch,
        "load_end": load_end,
        "rate_end": load_end / case.pitch,
        "rate_c": last["rate"],
        "torque_c": last["torque"],
        "theta_end": theta_end,
        "theta_c": last["theta"],
        "stiffening": last["torque"] / bare if bare else math.nan,
        **{f"{role}_c": last[role] for role in ("U_el", "W_fr", "RED")},
    }


def path_figures(
    along: Mapping[str, Array], engaged: Mapping[str, float], ended: Mapping[str, float], end: str, other: str, K: float
) -> dict[str, Array]:
    """Return the single values of a path of bends and twists, by name.

    ``engaged`` and ``ended`` are the places (:data:`PLACES`) of first contact and of the end, ``end`` its reason,
    ``other`` the next contact, ``K`` the joint's stiffness K_theta (N m).
    """
    found: dict[str, float | str] = {"end": end, "other_contact": other, "K_theta": K}
    found |= {f"{name}_end": ended[name] for name in PLACES} | {f"{name}_e": engaged[name] for name in PLACES[:-1]}
    return {name: np.asarray(v) for name, v in found.items()} | {
        f"{name}_c": along[name][-1] for name in ("M", "T", "W_fr", "RED")
    }


def tangents(
    rigidity: float, d: float, engaged: Sequence[float] | Array, steps: Array, at: Array, v: Mapping[str, Array]
) -> dict[str, Array]:
    """Return the tangent stiffness at load angles ``at``, by slopes over the ``steps``, and over ``rigidity``.

    ``rigidity`` is that without contact, N m^2; ``engaged`` are the rising load angles per pitch of engagement on each
    face; ``d`` is the pitch.
    """
    torque = np.interp(steps, at, v["torque"])
    slope = np.where(np.isfinite(torque), rigidity, np.nan)
    # it jumps at engagement
    jumps = [x for i, x in enumerate(engaged) if i == 0 or x - engaged[i - 1] > NEAR]
    for begin, end in pairwise([*jumps, math.inf]):
        contact = np.flatnonzero((steps >= begin) & (steps <= end))
        if contact.size > 1:
            slopes = np.gradient(torque[contact], steps[contact] / d, edge_order=2 if contact.size > 2 else 1)
            slope[contact[steps[contact] < end]] = slopes[steps[contact] < end]
    found = np.interp(at, steps, slope)
    found[at < engaged[0]] = rigidity
    found[np.isnan(v["torque"])] = np.nan
    return {"tangent": found, "stiffness_ratio": found / rigidity}


def first_at(x: Array, y: Array, level: float) -> float:
    """Return the first x at which y reaches a level, linear between points; NaN if it does not."""
    above = np.flatnonzero(y >= level)
    if not above.size:
        return math.nan
    i = int(above[0])
    if i == 0 or not math.isfinite(y[i - 1]):
        return float(x[i])
    return float(x[i - 1] + (level - y[i - 1]) / (y[i] - y[i - 1]) * (x[i] - x[i - 1]))


def dissipation(U_el: Array, W_fr: Array) -> Array:
    """Return the relative energy dissipation RED, W_fr/(U_el + W_fr): 0 without energy, NaN where unknown."""
    total = U_el + W_fr
    out = np.where(np.isfinite(total), 0.0, np.nan)
    return np.asarray(np.divide(W_fr, total, out=out, where=total > 0))


def work_error(v: Mapping[str, Array]) -> float:
    """Return the work neither stored, dissipated by friction nor lost in snaps, over the larger energy."""
    lost = float(v["W_fr"][-1] + v["W_snap"][-1])
    error = float(v["work"][-1]) - float(v["U_el"][-1]) - lost
    return error / max(lost, float(v["U_el"].max()), 1e-300)


def loop_figures(
    base: float, top: float, pitch: float, energies: tuple[float, float], torques: Sequence[float], residual: float
) -> list[float]:
    """Return the single values of a closed loop between two load angles per pitch, in the order of ``LOOP``.

    ``energies``: dissipated, and elastic at the top; ``torques``: at the top on loading, where the contact slides back
    from there, and at the base.
    """
    (dissipated, elastic), (highest, turned, lowest) = energies, torques
    secant = (highest - lowest) / ((top - base) / pitch)
    damping = dissipated / (4 * math.pi * elastic)
    return [base, top, dissipated, elastic, damping, secant, abs(highest - turned), residual]


def loop_table(rows: Sequence[Sequence[float]]) -> dict[str, Array]:
    """Return the single values of loops as arrays by role."""
    return dict(zip(LOOP, np.array(rows, float).reshape(-1, len(LOOP)).T, strict=True))


def table(rows: Sequence[Mapping[str, float | int | str]]) -> dict[str, Array]:
    """Return the rows' single values as arrays by role."""
    return {role: np.array([row[role] for row in rows]) for role in rows[0]}


def used_senses(values: Sequence[float]) -> list[str]:
    """Return the senses that occur in a history."""
    return [s for s in ("+", "-") if s == "+" or min(values) < 0]

"""Scaling laws of the embedded part of a scale: stiffness of its joint and stiffening of the bar.

The laws are fits, not derivations. The table `LAWS` gives the source of each and the range in which it was used or
checked; `outside` describes where a design leaves that range.

Checks by finite elements at the geometry of the paper's Fig. 6b (eta = 3, true plate thickness): K_theta is 0.96 of the
law at t_s/d = .004, L/d = .18; 1.23 to .76 of it over t_s/d = .002 to .016; .78 to 1.33 over L/d = .09 to .36. C_f is
1.42 against 1.45. So even within its range K_theta may be off by a third: give `joint.stiffness` where it is known.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import NamedTuple


class Limit(NamedTuple):
    """Range of a ratio of the design in which a law can be trusted, with the reason."""

    ratio: str
    low: float
    high: float
    reason: str


class Law(NamedTuple):
    """A scaling law: quantity, formula, source, limits, remedy outside them, and the function."""

    name: str
    formula: str
    source: str
    limits: tuple[Limit, ...]
    remedy: str
    value: Callable[..., float]


def stiffness(youngs_modulus: float, scale_thickness: float, half_width: float, embedded: float) -> float:
    """Return the stiffness of a scale's joint, K_theta = 3.62 E_B t_s^2 b (L/t_s)^1.55, N m per rad, under any load.

    From E_B of the substrate (Pa), t_s, b (half the scale's width) and L (m). Source: paper, text after Eq. 7. Range: 0
    < L << 2t and t_s << l + L; see `LAWS`. The papers on bending use another law (docs, theory: bending).
    """
    power: float = (embedded / scale_thickness) ** 1.55
    return 3.62 * youngs_modulus * scale_thickness**2 * half_width * power


def inclusion_twisting(zeta: float, beta: float, lam: float) -> float:
    """Return the stiffening of the twisted bar by the embedded plates, C_f = 1 + 1.33 zeta beta / lambda, at least 1.

    From L/d, b/d and t/d. Source: paper, text before Eq. 13. Range: see `LAWS`.
    """
    return 1 + 1.33 * zeta * beta / lam


def inclusion_bending(zeta: float, beta: float, lam: float) -> float:  # noqa: ARG001 - one call for both loads
    """Return the stiffening of the bent bar: 1, as the bending theory has no factor (docs, theory: bending)."""
    return 1.0


_SHALLOW = Limit("L/(2t)", 0.0, 0.56, "made for L << 2t; the deepest tab checked had 0.56")
_SLENDER = Limit("t_s/(l + L)", 0.0, 0.05, "made for t_s << l + L")

LAWS: Mapping[str, Law] = {
    "stiffness": Law(
        "joint stiffness K_theta",
        "3.62 E_B t_s^2 b (L/t_s)^1.55",
        "paper, text after Eq. 7",
        (
            Limit("t_s/d", 0.002, 0.016, "finite elements there: 1.23 to 0.76 of the law"),
            Limit("L/d", 0.09, 0.36, "finite elements there: 0.78 to 1.33 of the law"),
            _SHALLOW,
            _SLENDER,
        ),
        "give joint.stiffness if you know it",
        stiffness,
    ),
    "inclusion twisting": Law(
        "inclusion factor C_f",
        "1 + 1.33 zeta beta / lambda",
        "paper, text before Eq. 13",
        (Limit("zeta beta/lambda", 0.0, 1.0, "the paper used 0.34 and 0.97; checked at 0.34 only"), _SHALLOW),
        "give joint.inclusion_factor if you know it",
        inclusion_twisting,
    ),
    "inclusion bending": Law(
        "inclusion factor", "1", "docs, theory: bending", (), "give joint.inclusion_factor", inclusion_bending
    ),
}


def outside(law: Law, ratios: Mapping[str, float]) -> list[str]:
    """Return a line for every limit of a law that a design breaks; ``ratios`` by their names in the limits."""
    # the limits themselves belong to the range, also where a ratio was rounded on its way here
    slack = 1e-9
    return [
        f"{law.name}: {ratio} = {ratios[ratio]:.3g} is outside its range, {low:g} to {high:g} ({reason}); {law.remedy}"
        for ratio, low, high, reason in law.limits
        if not low * (1 - slack) <= ratios[ratio] <= high * (1 + slack)
    ]

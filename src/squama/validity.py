"""Where a beam leaves the range of the model: every message in one place."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from squama.errors import InputError
from squama.model import joint, thickness

if TYPE_CHECKING:
    from squama.design import Beam

THIN = 0.05
"""Largest share of the gap between neighbours that a plate may fill and still be called thin."""

LOADS = ("twisting", "bending")


def messages(beam: Beam, load: str = "twisting") -> list[str]:
    """Say where a beam leaves the range of the model under a load.

    Parameters
    ----------
    beam : Beam
        The beam.
    load : {"twisting", "bending"}
        Which theory is to be used on it.

    Returns
    -------
    list of str
        One line per finding, with the numbers; empty if there is none.

    Raises
    ------
    InputError
        No such load.
    """
    if load not in LOADS:
        message = f"load = {load!r}: is not known; write one of {', '.join(LOADS)}"
        raise InputError(message)
    return [*_overlap(beam), *_width(beam, load), *_thin(beam, load), *_laws(beam, load)]


def tab_problem(beam: Beam) -> str | None:
    """Say that the embedded tab, inclined by theta0, would come out of the substrate's other face."""
    sine = math.sin(beam.scale.theta0)
    depth, room = beam.scale.embedded * sine, beam.substrate.thickness
    if depth < room:
        return None
    return (
        f"scale.embedded = {_mm(beam.scale.embedded)}: the tab goes through the substrate, L sin(theta0) = "
        f"{_mm(depth)} in a thickness of {_mm(room)}; write less than {_mm(room / sine)}"
    )


def _overlap(beam: Beam) -> list[str]:
    if beam.eta > 1:
        return []
    return [
        f"the scales do not overlap (eta = l/d = {beam.eta:.3g}, overlap needs more than 1), "
        "so neighbours may never touch"
    ]


def _width(beam: Beam, load: str) -> list[str]:
    alpha = beam.scale.alpha if load == "twisting" else 0.0
    across = beam.scale.width * math.cos(alpha)
    room = beam.substrate.width
    # widths that agree up to rounding fit
    if across <= room * (1 + 1e-9):
        return []
    line = f"the scales are wider than the substrate: 2 b cos(alpha) = {_mm(across)} against {_mm(room)}"
    if load == "bending":
        return [f"{line} (alpha = 0 in bending)"]
    fits = math.degrees(math.acos(room / beam.scale.width))
    return [f"{line}; they fit for alpha >= {math.ceil(fits * 100) / 100:.2f} deg"]


def _thin(beam: Beam, load: str) -> list[str]:
    tau = beam.scale.thickness / beam.pitch
    if load == "twisting":
        gap = thickness.gap(beam.scale.alpha, beam.scale.theta0)
        name, measure = "d sin(theta0) cos(alpha)", "phi"
    else:
        gap = thickness.gap(0.0, beam.scale.theta0)
        name, measure = "d sin(theta0)", "psi"
    share = tau / gap
    if share <= THIN * (1 + 1e-9):
        return []
    line = f"the scales are not thin: t_s = {_mm(beam.scale.thickness)} "
    if share >= 1:
        rest = f"{name} = {_mm(gap * beam.pitch)}: the plates touch at rest"
        return [f"{line}is no less than the gap {rest}"]

    def engagement(tau: float) -> str:
        if load == "twisting":
            value = thickness.engagement_twisting(**beam.ratios, tau=tau)
        else:
            value = thickness.engagement_bending(beam.eta, beam.scale.theta0, tau)
        return f"{measure} = {value:.3g} rad per pitch" if math.isfinite(value) else "no twist"

    return [
        f"{line}uses {100 * share:.0f} % of the gap {name} = {_mm(gap * beam.pitch)} "
        f"({100 * THIN:.0f} % is thin); "
        f"plates of that thickness engage at {engagement(tau)}, the model's thin ones at {engagement(0.0)}"
    ]


def _laws(beam: Beam, load: str) -> list[str]:
    ratios = {
        "t_s/d": beam.scale.thickness / beam.pitch,
        "L/d": beam.zeta,
        "L/(2t)": beam.scale.embedded / beam.substrate.thickness,
        "t_s/(l + L)": beam.scale.thickness / (beam.scale.length + beam.scale.embedded),
        "zeta beta/lambda": beam.zeta * beam.beta / beam.lam,
    }
    lines = []
    if beam.joint.stiffness is None:
        if beam.scale.embedded == 0:
            lines.append(
                "scale.embedded = 0: by its law the joint has no stiffness, so the scales add no torque or "
                "moment; give joint.stiffness"
            )
        else:
            lines += joint.outside(joint.LAWS[f"stiffness {load}"], ratios)
    if beam.joint.inclusion_factor is None:
        lines += joint.outside(joint.LAWS[f"inclusion {load}"], ratios)
    return lines


def _mm(length: float) -> str:
    return f"{length * 1e3:.4g} mm"

"""Where a beam leaves the range of the model: every message in one place."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from squama import beamfile, joint_values
from squama.errors import InputError
from squama.model import joint, reach, thickness, twisting
from squama.units import Dimension

if TYPE_CHECKING:
    from squama.design import Beam

THIN = 0.05
"""Largest share of the gap between neighbours that a plate may fill and still be called thin."""

LOADS = ("twisting", "bending")


def messages(beam: Beam, load: str = "twisting", sense: str = "+") -> list[str]:
    """Say where a beam leaves the range of the model under a load.

    Parameters
    ----------
    beam : Beam
        The beam.
    load : {"twisting", "bending"}
        Which theory is to be used on it.
    sense : {"+", "-"}
        Which way it is twisted.

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
    return [*_overlap(beam), *_width(beam, load), *_thin(beam, load, sense), *_laws(beam, load), *_matrix(beam)]


def reach_problems(beam: Beam) -> list[str]:
    """Say that the scales reach over too many neighbours, each of which would be asked for its contact."""
    most = beam.pitch * reach.LARGEST
    found = []
    if beam.eta > reach.MOST:
        found.append(("length", beam.scale.length, f"eta = l/d = {beam.eta:.6g}", most))
    if beam.beta > reach.MOST:
        found.append(("width", beam.scale.width, f"beta = b/d = {beam.beta:.6g}", 2 * most))
    return [
        f"scale.{key} = {_mm(size)}: makes {ratio} with beam.pitch = {_mm(beam.pitch)}; "
        f"allowed: {reach.ALLOWED}; write at most {_mm(room)}"
        for key, size, ratio, room in found
    ]


def tab_problems(beam: Beam) -> list[str]:
    """Say that the embedded tab, inclined by theta0, would come out of the substrate's other face."""
    sine = math.sin(beam.scale.theta0)
    depth, room = beam.scale.embedded * sine, beam.substrate.thickness
    if depth < room:
        return []
    return [
        f"scale.embedded = {_mm(beam.scale.embedded)}: the tab goes through the substrate, L sin(theta0) = "
        f"{_mm(depth)} in a thickness of {_mm(room)}; write less than {_mm(room / sine)}"
    ]


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


def _thin(beam: Beam, load: str, sense: str) -> list[str]:
    tau = beam.scale.thickness / beam.pitch
    if load == "twisting":
        gap = thickness.gap(beam.scale.alpha, beam.scale.theta0)
        name, measure = "d sin(theta0) cos(alpha)", "phi"
    else:
        gap = thickness.gap(0.0, beam.scale.theta0)
        name, measure = "d sin(theta0)", "psi"
    # the other sense is the mirror image
    ratios = beam.ratios | {"alpha": beam.scale.alpha * (-1 if sense == "-" else 1)}
    share = tau / gap
    if share <= THIN * (1 + 1e-9):
        return []
    line = f"the scales are not thin: t_s = {_mm(beam.scale.thickness)} "
    if share >= 1:
        rest = f"{name} = {_mm(gap * beam.pitch)}: the plates touch at rest"
        return [f"{line}is no less than the gap {rest}"]

    def engagement(tau: float) -> str:
        if load == "twisting":
            value = thickness.engagement_twisting(**ratios, tau=tau)
        else:
            value = thickness.engagement_bending(beam.eta, beam.scale.theta0, tau)
        return f"{measure} = {value:.3g} rad per pitch" if math.isfinite(value) else "no twist"

    line += f"uses {100 * share:.0f} % of the gap {name} = {_mm(gap * beam.pitch)} ({100 * THIN:.0f} % is thin); "
    if load == "twisting" and not _meets(ratios):
        return [f"{line}in this sense of twist the model's thin plates do not meet tip on side of the next scale"]
    return [f"{line}plates of that thickness engage at {engagement(tau)}, the model's thin ones at {engagement(0.0)}"]


def _meets(ratios: dict[str, float]) -> bool:
    """Whether the tip of a thin plate comes to rest on the side edge of the next one; alpha below 0: sense "-"."""
    eta, beta, lam, alpha, theta0 = ratios.values()
    shape = math.sin(alpha), math.cos(alpha), eta, beta, lam
    r = twisting.root(math.sin(theta0), math.cos(theta0), *shape)
    if r.q2 < 0 or r.H + math.sqrt(r.q2) <= 0:
        return False
    c = twisting.contact(r, math.sqrt(r.q2), *shape)
    return bool(abs(c.p) <= beta and 0 <= c.s <= eta)


def _laws(beam: Beam, load: str) -> list[str]:
    ratios = {
        "t_s/d": beam.scale.thickness / beam.pitch,
        "L/d": beam.zeta,
        "L/(2t)": beam.scale.embedded / beam.substrate.thickness,
        "t_s/(l + L)": beam.scale.thickness / (beam.scale.length + beam.scale.embedded),
        "zeta beta/lambda": beam.zeta * beam.beta / beam.lam,
    }
    lines: list[str] = []
    if load == "twisting" and beam.joint.matrix is not None:
        return lines
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


def _matrix(beam: Beam) -> list[str]:
    """Say where the joint's matrix was made for another shape."""
    matrix = beam.joint.matrix
    if matrix is None or not (found := matrix.differences(joint_values.made_for(beam))):
        return []
    words = []
    for key, made, here in found:
        table, _, name = key.partition(".")
        dimension = beamfile.TABLES[table][name].dimension
        if dimension is Dimension.LENGTH:
            texts = [f"{_mm(x)} ({x / d:.4g} d)" for x, d in ((made, matrix.made["beam.pitch"]), (here, beam.pitch))]
        elif dimension is Dimension.ANGLE:
            texts = [f"{math.degrees(x):.4g} deg" for x in (made, here)]
        else:
            texts = [f"{x:.4g}" for x in (made, here)]
        words.append(f"{key} = {texts[0]}, not {texts[1]}")
    return [
        f"joint.matrix ({matrix.name}): was made for another shape, {'; '.join(words)}; make it anew with: "
        "squama joint --matrix"
    ]


def _mm(length: float) -> str:
    return f"{length * 1e3:.4g} mm"

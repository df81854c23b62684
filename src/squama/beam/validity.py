"""Checks of a beam against the range of the models, with all their messages."""

from __future__ import annotations

import math

from squama.beam import beamfile, matrixfile
from squama.beam.parts import Assembly
from squama.errors import Problems, refuse
from squama.loads import LOADS, NEUTRAL, Load
from squama.model import joint, reach
from squama.people import per_pitch
from squama.units import Dimension, as_text, shown

THIN = 0.05
"""Largest thickness of a plate that still counts as thin, as a share of the gap between neighbours."""

SOFTEST = 1e-6
"""Smallest allowed stiffness of a scale over that of its joint."""


def messages(beam: Assembly, load: str = "twisting", sense: str = "+", joint: str = "hinge") -> list[str]:
    """Return where a beam leaves the range of a joint's model under a load, one line per finding, with the numbers."""
    if load not in LOADS:
        refuse("load", shown(load), "is not known", f"write one of {', '.join(LOADS)}")
    kind = LOADS[load]
    found = [*_overlap(beam), *_width(beam)]
    if joint == "hinge":
        found += [*_thin(beam, kind, sense), *_laws(beam, kind)]
    return [*found, *_both(beam), *_matrix(beam)]


def parts_fit(beam: Assembly) -> None:
    """Refuse a beam whose parts do not fit each other.

    Refused are scales that reach over too many neighbours, each of which would be searched for a contact; a tab,
    inclined by theta0, that comes out of the substrate's other face; and scales that are far softer than their joint.
    """
    problems = Problems()
    d, most = beam.pitch, beam.pitch * reach.LARGEST
    for key, size, words, ratio, room in (
        ("length", beam.scale.length, "eta = l/d", beam.eta, most),
        ("width", beam.scale.width, "beta = b/d", beam.beta, 2 * most),
    ):
        if ratio > reach.MOST:
            reason = f"makes {words} = {ratio:.6g} with beam.pitch = {_mm(d)}; allowed: {reach.ALLOWED}"
            problems.add(f"scale.{key}", _mm(size), reason, f"write at most {_mm(room)}")
    if beam.other and beam.neutral != next(iter(NEUTRAL)):
        reason = "needs scales on one face; with scales on both it is the middle"
        problems.add("substrate.neutral", shown(beam.neutral), reason, f'write "{next(iter(NEUTRAL))}"')
    sine = math.sin(beam.scale.theta0)
    depth, room = beam.scale.embedded * sine, beam.substrate.thickness / (2 if beam.other else 1)
    if depth >= room:
        words = "beyond the middle, to those of the other face" if beam.other else "through the substrate"
        reason = f"the tab goes {words}, L sin(theta0) = {_mm(depth)} in a thickness of {_mm(room)}"
        problems.add("scale.embedded", _mm(beam.scale.embedded), reason, f"write less than {_mm(room / sine)}")
    E, width = beam.scale.youngs_modulus, beam.scale.width
    # stiffness is meaningless for a length or width out of range
    if (
        not problems
        and E is not None
        and (plate := 3 * beam.plate_rigidity * width / beam.scale.length) < SOFTEST * beam.joint_stiffness
    ):
        figures = f"3 D 2b/l = {plate:.3g} N m against K_theta = {beam.joint_stiffness:.3g} N m"
        reason = f"is that of a scale more than {1 / SOFTEST:,.0f} times softer than its joint, {figures}"
        # rounded up
        least = float(f"{1.001 * E * SOFTEST * beam.joint_stiffness / plate:.4g}")
        given, enough = (as_text(x, Dimension.PRESSURE) for x in (E, least))
        problems.add("scale.youngs_modulus", given, reason, f"write at least {enough}")
    problems.settle()


def _both(beam: Assembly) -> list[str]:
    """Return the warning that the stiffening by tabs in both faces is approximate (see docs, theory: both faces)."""
    if beam.other is None or beam.joint.inclusion_factor is not None or not beam.scale.embedded:
        return []
    taken = "tabs in both faces are taken to stiffen the bar by twice what those of one do"
    return [f"{taken}; in elements it was 1.6 to 2.1 times (joint.inclusion_factor would be the whole beam's)"]


def _overlap(beam: Assembly) -> list[str]:
    lies = f"the scales do not overlap (eta = l/d = {beam.eta:.3g}, overlap needs more than 1)"
    return [] if beam.eta > 1 else [f"{lies}, so neighbours may never touch"]


def _width(beam: Assembly) -> list[str]:
    across, room = beam.scale.width * math.cos(beam.scale.alpha), beam.substrate.width
    # widths that agree up to rounding fit
    if across <= room * (1 + 1e-9):
        return []
    line = f"the scales are wider than the substrate: 2 b cos(alpha) = {_mm(across)} against {_mm(room)}"
    fits = math.degrees(math.acos(room / beam.scale.width))
    return [f"{line}; they fit for alpha >= {math.ceil(fits * 100) / 100:.2f} deg"]


def _thin(beam: Assembly, load: Load, sense: str) -> list[str]:
    alpha, theta0 = beam.scale.alpha, beam.scale.theta0
    tau, gap = beam.thickness_ratio, math.cos(alpha) * math.sin(theta0)
    if tau <= THIN * gap * (1 + 1e-9):
        return []
    words = f"gap d sin(theta0) cos(alpha) = {gap * beam.pitch * 1e3:.3g} mm"
    line = f"the scales are not thin: t_s = {_mm(beam.scale.thickness)}"
    if tau >= gap:
        return [f"{line} is no less than the {words}: the plates touch at rest"]
    line += f" uses {100 * tau / gap:.0f} % of the {words} ({100 * THIN:.0f} % is thin); "
    if not load.sided:
        return [f"{line}plates of that thickness engage before the model's thin ones"]
    from squama.model import neighbours
    from squama.model.paths import FLOAT, Twist

    # the other sense is the mirror image
    alpha *= -1 if sense == "-" else 1
    row = Twist(beam.eta, beam.beta, beam.lam, math.sin(alpha), math.cos(alpha), theta0)

    def engagement(tau: float) -> str:
        value = neighbours.meets(row._replace(thickness=tau), FLOAT)
        return per_pitch(value) if value > 0 else "no twist"

    if not neighbours.engages(row, FLOAT):
        return [f"{line}in this sense of twist the model's thin plates do not meet tip on side of the next scale"]
    return [f"{line}plates of that thickness engage at {engagement(tau)}, the model's thin ones at {engagement(0.0)}"]


def _laws(beam: Assembly, load: Load) -> list[str]:
    ratios = {
        "t_s/d": beam.thickness_ratio,
        "L/d": beam.zeta,
        "L/(2t)": beam.scale.embedded / beam.substrate.thickness,
        "t_s/(l + L)": beam.scale.thickness / (beam.scale.length + beam.scale.embedded),
        "zeta beta/lambda": beam.zeta * beam.beta / beam.lam,
    }
    if beam.joint.matrix is not None:
        return []
    lines: list[str] = []
    if beam.joint.stiffness is None and beam.scale.embedded == 0:
        adds = "the scales add no torque or moment; give joint.stiffness"
        lines.append(f"scale.embedded = 0: by its law the joint has no stiffness, so {adds}")
    elif beam.joint.stiffness is None:
        lines += joint.outside(joint.LAWS["stiffness"], ratios)
    if beam.joint.inclusion_factor is None:
        lines += joint.outside(joint.LAWS[f"inclusion {load.name}"], ratios)
    return lines


def _matrix(beam: Assembly) -> list[str]:
    """Return the warning that the joint's matrix was made for a beam of another shape."""
    matrix = beam.joint.matrix
    if matrix is None or not (found := matrix.differences(matrixfile.made_for(beam))):
        return []
    words = []
    for key, made, here in found:
        dimension = beamfile.NUMBERS[key][0]
        texts = [f"{x:.4g}" for x in (made, here)]
        if dimension is Dimension.LENGTH:
            texts = [f"{_mm(x)} ({x / d:.4g} d)" for x, d in ((made, matrix.made["beam.pitch"]), (here, beam.pitch))]
        elif dimension is Dimension.PRESSURE:
            texts = [f"{x / 1e9:.4g} GPa" for x in (made, here)]
        elif dimension is Dimension.ANGLE:
            texts = [f"{math.degrees(x):.4g} deg" for x in (made, here)]
        words.append(f"{key} = {texts[0]}, not {texts[1]}")
    other = f"joint.matrix ({matrix.name}): was made for another shape, {'; '.join(words)}"
    return [f"{other}; make it anew with: squama joint --matrix"]


def _mm(length: float) -> str:
    return f"{length * 1e3:.4g} mm"

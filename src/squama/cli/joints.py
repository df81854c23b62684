"""The compliant joint on the command line: its curve beside the hinge's, and how far the two are apart."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from squama.compare import SHARE, Difference, differences

if TYPE_CHECKING:
    from squama.answer import Answer
    from squama.design import Beam


def compute(beam: Beam, law: str, sense: str, numbers: dict[str, Any]) -> dict[str, Answer]:
    """Return the response with a compliant joint, and at the same twists the hinge's, and that of one of equal K."""
    from squama import response

    ours = response.twisted(beam, law=law, sense=sense, joint="compliant", **numbers)
    rates = ours["Phi"] if ours.family is None else ours["Phi"][0]
    # the hinge's own end is looked for within the same range
    same = {**numbers, "points": 3, "at": rates, "to": float(rates[-1])}
    K, rigidity = (float(ours.attrs[name]) for name in ("K_theta", "rigidity"))
    alike = beam.replace(joint={"stiffness": K, "inclusion_factor": rigidity / (beam.G_B * beam.J)})
    return {
        "compliant": ours,
        "hinge": response.twisted(beam, sense=sense, **same),
        "matched": response.twisted(alike, sense=sense, **same),
    }


def compared(laws: Mapping[str, Answer]) -> dict[str, list[dict[str, float]]]:
    """Return how far the hinges are from the compliant joint, a record per coefficient of friction."""
    return {name: [d._asdict() for d in differences(laws[name], laws["compliant"])] for name in ("hinge", "matched")}


def notes(beam: Beam, laws: Mapping[str, Answer]) -> list[str]:
    """Return the lines on stiffness, and by how much the hinge is off and how far it holds."""
    from squama.cli.summary import moment

    attrs, ours = laws["compliant"].attrs, laws["compliant"]
    K, rigidity = float(attrs["K_theta"]), float(attrs["rigidity"])
    source = "by finite elements" if beam.joint.matrix is None else f"from {beam.joint.matrix.name}"
    lines = [
        f"joint of a scale: K_theta = {moment(K)} per rad {source}, hinge {moment(beam.joint_stiffness)}",
        f"beam without contact: {rigidity:.4g} N m2 {source} (C_f = {rigidity / (beam.G_B * beam.J):.4g}), "
        f"hinge {beam.torsional_rigidity:.4g} N m2 (C_f = {beam.C_f:.4g})",
    ]
    for i, mu in enumerate(ours["mu"].ravel()):
        of_mu = f"mu = {mu:g}: " if ours.family is not None else ""
        first, error = ours["first_contact"].ravel()[i], float(ours["energy_error"].ravel()[i])
        if first:
            lines.append(f"{of_mu}first contact: {first}; the torque's work is balanced to {abs(error):.1e}")
        for name, words in (("hinge", "the hinge"), ("matched", "a hinge with the elements' K_theta and C_f")):
            d = differences(laws[name], ours)[i]
            if not math.isnan(d.within):
                lines.append(of_mu + _apart(d, words, str(laws[name]["end"].ravel()[i])))
    return lines


def _apart(d: Difference, words: str, end: str) -> str:
    if d.within >= d.last:
        return f"{words} is within {SHARE:.0%} in torque as far as both go, {d.last:.4g} rad/pitch"
    holds = f"within {SHARE:.0%} in torque up to {d.within:.4g} rad/pitch"
    holds = holds if d.within else f"more than {SHARE:.0%} off in torque from the start"
    off = f"{100 * d.torque:+.3g} %" if abs(d.torque) < 1 else f"{1 + d.torque:.3g} times"
    return f"{words} is {holds}; at {d.last:.4g} rad/pitch {off}, theta {math.degrees(d.theta):+.3g} deg ({end})"

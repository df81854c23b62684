"""What twist and bend say of a beam: a summary for people, and everything for other programs.

On the compliant joint the hinge's answer stands beside its own, and how far the two are apart.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from squama.cli import output
from squama.cli.output import table, warnings
from squama.fe.agreement import SHARE, holds
from squama.loads import LOADS, Load
from squama.model.laws import LAWS
from squama.model.outcome import SENTENCES, End
from squama.units import moment, number

if TYPE_CHECKING:
    from rich.table import Table

    from squama.beam.design import Beam
    from squama.curves.labelled import Answer

    Shown = Iterable[str | Table]


def summary(beam: Beam, law: str, laws: Mapping[str, Answer]) -> Shown:
    """Return the summary: a table, sentences, warnings; of the answers by law ``law`` is the one saved and drawn."""
    data = laws[law]
    words = LOADS[data.attrs["load"]]
    mus = ", ".join(f"{mu:g}" for mu in data["mu"].ravel())
    sense = f", sense {data.attrs['sense']}" if "sense" in data.attrs else ""
    margin = next(float(a.attrs["margin"]) for a in laws.values() if "margin" in a.attrs)
    yield f" {words.done}: {beam.scales} scales on {beam.length * 1e3:.4g} mm, mu = {mus}{sense}"
    yield ""
    if data.family is not None:
        for name, response in laws.items():
            if len(laws) > 1:
                yield column(name)
            yield _family(words, beam, response)
            yield ""
        yield (
            f"angles {words.angle} per pitch in rad, in total over {beam.scales} scales in deg; {words.torque}, "
            f"{words.torque}/{words.torque}0 (over the bare beam's) and RED at the cut-off, "
            f"margin {margin:g}"
        )
    else:
        yield _single(words, beam, margin, laws)
        yield ""
    yield from _notes(words, beam, law, laws)
    yield from warnings(data.attrs["warnings"])


def column(name: str) -> str:
    """Return what a response is called: by its law, or by its joint."""
    joints = {"compliant": "compliant joint", "hinge": "hinge, edge law", "matched": "hinge, elements' K_theta"}
    return joints.get(name, f"{name} law")


def _figure(data: Answer, name: str, factor: float = 1.0, unit: str = "") -> str:
    """Return a single figure of a curve; without engagement it has no end and no cut-off, it is as long as drawn."""
    ended = name.endswith(("_end", "_c"))
    if name not in data.variables or (ended and data["end"].item() == End.NONE):
        return "-" if name else ""
    value = data[name].item()
    if isinstance(value, str):
        return value
    return moment(value) if unit == "N m" else number(value * factor, unit)


def _inclination(beam: Beam, data: Answer, angle: str) -> str:
    """Return the inclination at engagement: on a compliant joint a scale turns before it touches."""
    engaged, theta = data[f"{angle}_e"].item(), beam.scale.theta0
    if "w_Y" in data.variables:
        theta = float(np.interp(engaged, data[angle], data["theta"]))
    return number(math.degrees(theta), "deg") if math.isfinite(engaged) else "-"


def _single(words: Load, beam: Beam, margin: float, laws: Mapping[str, Answer]) -> Table:
    """Return the table with a row per figure and a column per law."""
    angle, rate, torque = words.angle, words.rate, words.torque

    def row(label: str, name: str = "", factor: float = 1.0, unit: str = "") -> list[str]:
        return [label, *(_figure(data, name, factor, unit) for data in laws.values())]

    def places(at: str) -> list[list[str]]:
        return [
            row(f"  {words.angle_words} {angle}", f"{angle}_{at}", 1, "rad/pitch"),
            row(f"  {words.rate_words} {rate}", f"{rate}_{at}", 1, "rad/m"),
            row(f"  in total over {beam.scales} scales", f"{rate}_{at}", math.degrees(beam.length), "deg"),
        ]

    rows = [
        row("end", "end"),
        row("engagement"),
        *places("e"),
        *([row("  phi by the small-angle formula", "phi_e_small", 1, "rad/pitch")] if words.sided else []),
        ["  inclination theta", *(_inclination(beam, data, angle) for data in laws.values())],
        row("at the end"),
        *places("end"),
        row("  inclination theta", "theta_end", math.degrees(1), "deg"),
        row(f"at the cut-off, margin {margin:g}"),
        row(f"  {words.rate_words} {rate}", f"{rate}_c", 1, "rad/m"),
        row(f"  {words.torque_words} {torque}", f"{torque}_c", 1, "N m"),
        row("  over the bare beam's", "stiffening"),
        row("  relative energy dissipation RED", "RED_c"),
        row("mu that locks at engagement", "mu_static"),
        row("neighbour in contact", "neighbour"),
    ]
    head = ["", *(column(name) for name in laws)] if len(laws) > 1 else ["", ""]
    return table(head, rows, left=len(head))


def _family(words: Load, beam: Beam, data: Answer) -> Table:
    """Return the table with a row per coefficient of friction."""
    angle, rate, torque = words.angle, words.rate, words.torque
    columns = {
        "end": ("end", 1.0),
        f"{angle}_e": (f"{angle}_e", 1.0),
        f"{angle}_end": (f"{angle}_end", 1.0),
        "total deg": (f"{rate}_end", math.degrees(beam.length)),
        "theta deg": ("theta_end", math.degrees(1)),
        f"{torque} N m": (f"{torque}_c", 1.0),
        f"{torque}/{torque}0": ("stiffening", 1.0),
    }
    rows = (
        [f"{mu:g}", *(_figure(data.pick(i), *figure) for figure in columns.values()), number(data["RED_c"][i].item())]
        for i, mu in enumerate(data["mu"])
    )
    head = ["mu", *columns, "RED"]
    return table(head, rows, left=len(head), gap=1)


def _notes(kind: Load, beam: Beam, law: str, laws: Mapping[str, Answer]) -> list[str]:
    """Return the lines under the table: the joint, and a sentence for each kind of end."""
    lines = _compliant(beam, laws) if law == "compliant" else _stiffnesses(kind, beam)
    ends = dict.fromkeys(str(end) for data in laws.values() for end in data["end"].ravel())
    lines += [f"{end}: {SENTENCES[End(end)]}" for end in ends]
    lines += _others(laws)
    if any(str(End.NONE) in data["end"] for data in laws.values()):
        lines.append("without engagement the scales take no load and the curve is that of the beam without contact")
    if len(laws) > 1:
        lines.append(f"the curve, files and pictures are those of the {column(law)}")
    return lines


def _others(laws: Mapping[str, Answer]) -> list[str]:
    """Return a line for each other contact, with the laws and the frictions that it belongs to."""
    found: dict[str, dict[str, list[str]]] = {}
    for name, data in laws.items():
        touch = data["phi_touch"].ravel() if "phi_touch" in data.variables else np.full(data["mu"].size, np.nan)
        for mu, other, phi in zip(data["mu"].ravel(), data["other_contact"].ravel(), touch, strict=True):
            if other:
                at = f" at {number(float(phi), 'rad/pitch')}" if math.isfinite(phi) else ""
                found.setdefault(f"{other}{at}", {}).setdefault(name, []).append(f"{mu:g}")
    lines = []
    for text, by_law in found.items():
        frictions = [", ".join(mus) for mus in by_law.values()]
        pieces = [f"{column(name)}, mu = {mus}" for name, mus in zip(by_law, frictions, strict=True)]
        if len(by_law) == len(laws) and len(set(frictions)) == 1:
            pieces = [f"mu = {frictions[0]}"]
        lines += [f"other contact ({piece}): {text}" for piece in pieces]
    return lines


def _stiffnesses(kind: Load, beam: Beam) -> list[str]:
    matrix = beam.joint.matrix
    given = "given", f"from {matrix.name}" if matrix is not None and kind.matrix else "by its scaling law"
    K, rigidity = kind.stiffness(beam), kind.rigidity(beam)
    line = f"joint of a scale: K_theta = {moment(K)} per rad, {given[beam.joint.stiffness is None]}"
    if not kind.sided:
        return [line, f"beam without contact: C_f E_B I = {rigidity:.4g} N m2"]
    factor = f"inclusion factor C_f = {beam.C_f:.4g}, {given[beam.joint.inclusion_factor is None]}"
    return [line, f"beam without contact: C_f J G_B = {rigidity:.4g} N m2, {factor}"]


def record(beam: Beam, law: str, laws: Mapping[str, Answer]) -> dict[str, object]:
    """Return all there is to say about a twisted or bent beam.

    ``figures`` are single figures of the curve, a list of them each for a family over ``mu``; ``laws`` the same for
    each law; ``curve`` the points, a list of lists for a family; ``derived`` what follows from the beam.
    """
    data, kind = laws[law], LOADS[laws[law].attrs["load"]]
    derived: dict[str, object] = {**beam.ratios}
    derived |= {key: getattr(beam, key) for key in ("zeta", "slenderness", "length")}
    derived |= {"K_theta": kind.stiffness(beam), "rigidity": kind.rigidity(beam)}
    if kind.sided:
        derived |= {key: getattr(beam, key) for key in ("C_f", "C_w", "J", "I", "G_B")}
    if data.attrs.get("joint") == "compliant":
        derived |= {key: data.attrs[key] for key in ("K_theta", "rigidity")}
        # how far the hinges are off, a record per coefficient of friction
        derived["hinge"] = {name: [d._asdict() for d in differences(laws[name], data)] for name in ("hinge", "matched")}
    figures = {name: _figures(response) for name, response in laws.items()}
    keys, parts = "load law joint sense margin squama_version", {"laws": figures, "curve": data.curves}
    return output.record(beam, data, keys, derived=derived, figures=figures[law], **parts)


def _figures(data: Answer) -> dict[str, object]:
    ends = data["end"].tolist()
    words = [SENTENCES[End(end)] for end in ends] if isinstance(ends, list) else SENTENCES[End(ends)]
    return {**data.figures, "sentence": words}


def responses(load: str, beam: Beam, law: str, sense: str, numbers: dict[str, Any]) -> dict[str, Answer]:
    """Return the responses by law; the law that was not chosen is there for its single figures only."""
    from squama.curves.doors import respond

    few = {**numbers, "points": 3}
    return {
        name: respond(beam, load, law=name, sense=sense, **(numbers if name == law else few))
        for name in (sorted(LAWS) if LOADS[load].sided else [law])
    }


def beside_hinges(beam: Beam, law: str, sense: str, numbers: dict[str, Any]) -> dict[str, Answer]:
    """Return the response with a compliant joint, and at the same twists the hinge's, and that of one of equal K."""
    from squama.curves.doors import respond

    ours = respond(beam, "twisting", law=law, sense=sense, joint="compliant", **numbers)
    rates = ours["Phi"] if ours.family is None else ours["Phi"][0]
    # the hinge's own end is looked for within the same range
    same = {**numbers, "points": 3, "to": float(rates[-1])}
    K, rigidity = (float(ours.attrs[name]) for name in ("K_theta", "rigidity"))
    alike = beam.replace(joint={"stiffness": K, "inclusion_factor": rigidity / (beam.G_B * beam.J)})
    return {
        "compliant": ours,
        "hinge": respond(beam, "twisting", sense=sense, at=rates, **same),
        "matched": respond(alike, "twisting", sense=sense, at=rates, **same),
    }


def _compliant(beam: Beam, laws: Mapping[str, Answer]) -> list[str]:
    """Return the lines on stiffness, and by how much the hinge is off and how far it holds."""
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
                end = "" if d.within >= d.last else f" ({laws[name]['end'].ravel()[i]})"
                lines.append(f"{of_mu}{words} is {apart(*d[1:])}{end}")
    return lines


def apart(within: float, last: float, torque: float, theta: float, share: float = SHARE) -> str:
    """Return how far a curve holds, and by how much it is off at the last twist; as in a `Difference`."""
    if within >= last:
        return f"within {share:.0%} in torque as far as both go, {last:.4g} rad/pitch"
    holds = f"within {share:.0%} in torque up to {within:.4g} rad/pitch"
    holds = holds if within else f"more than {share:.0%} off in torque from the start"
    off = f"{100 * torque:+.3g} %" if abs(torque) < 1 else f"{1 + torque:.3g} times"
    return f"{holds}; at {last:.4g} rad/pitch {off}, theta {math.degrees(theta):+.3g} deg"


class Difference(NamedTuple):
    """A curve against a reference: it holds up to the twist ``within``; differences at ``last``, the last common twist.

    Twists in rad per pitch; ``torque`` is the torque over the reference's, less 1; ``theta`` the inclination less the
    reference's, rad; NaN where the curves have no twist in common.
    """

    mu: float
    within: float
    last: float
    torque: float
    theta: float


def differences(answer: Answer, reference: Answer, share: float = SHARE) -> list[Difference]:
    """Compare twisting curves with the same ``phi``, one result per friction; ``share`` of the torque is free."""
    found = []
    for i, mu in enumerate(np.atleast_1d(answer["mu"])):
        one, two = (a if a.family is None else a.pick(i) for a in (answer, reference))
        phi, T, T0 = two["phi"], one["T"], two["T"]
        with np.errstate(divide="ignore", invalid="ignore"):
            off = np.where(phi > 0, T / T0 - 1, np.nan)
        within, end = holds(phi, off, share)
        last = np.array([phi[end], off[end], one["theta"][end] - two["theta"][end]])
        found.append(Difference(float(mu), within, *(last if math.isfinite(within) else np.full(3, np.nan)).tolist()))
    return found

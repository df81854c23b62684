"""The summary of a response for people: a table, sentences, warnings; plain text when it is not a terminal."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from rich.console import Console
from rich.table import Table

from squama.model.outcome import SENTENCES, End

if TYPE_CHECKING:
    from squama.answer import Answer
    from squama.design import Beam


class _Words(NamedTuple):
    """Names of the quantities of a kind of loading, in the dataset and for people."""

    done: str
    angle: str
    per_pitch: str
    rate: str
    rate_words: str
    torque: str
    torque_words: str


_LOADS = {
    "twisting": _Words("twisted", "phi", "twist per pitch", "Phi", "twist rate", "T", "torque"),
    "bending": _Words("bent", "psi", "bend per pitch", "kappa", "curvature", "M", "moment"),
}


def show(load: str, file: str, beam: Beam, law: str, laws: Mapping[str, Answer], written: Sequence[str]) -> None:
    """Print the summary.

    Parameters
    ----------
    load : {"twisting", "bending"}
        Kind of loading.
    file : str
        The beam's file, as printed.
    beam : Beam
        The beam as computed.
    law : str
        The law whose curve is saved and drawn.
    laws : mapping
        Responses by law, one curve each or a family over ``mu``.
    written : sequence of str
        Files that were written, as printed.
    """
    console = Console(highlight=False, markup=False, emoji=False)
    # no digit is cut off: where the window is narrower than a table, it is the window that folds the lines
    console = Console(highlight=False, markup=False, emoji=False, width=max(console.width, 100))
    words = _LOADS[load]
    data = laws[law]
    console.print(_title(words, file, beam, data), style="bold", soft_wrap=True)
    console.print()
    if data.family is not None:
        for name, response in laws.items():
            if len(laws) > 1:
                console.print(column(name), style="bold")
            console.print(_family(words, beam, response))
            console.print()
        console.print(
            f"angles {words.angle} per pitch in rad, in total over {beam.scales} scales in deg; {words.torque}, "
            f"{words.torque}/{words.torque}0 (over the bare beam's) and RED at the cut-off, "
            f"margin {_margin(laws):g}",
            soft_wrap=True,
        )
    else:
        console.print(_single(words, beam, _margin(laws), laws))
        console.print()
    for line in _notes(load, beam, law, laws):
        console.print(line, soft_wrap=True)
    for line in data.attrs["warnings"].splitlines():
        console.print(f"warning: {line}", style="yellow", soft_wrap=True)
    for place in written:
        console.print(f"wrote {place}", soft_wrap=True)


def column(name: str) -> str:
    """Return what a response is called: by its law, or by its joint."""
    joints = {"compliant": "compliant joint", "hinge": "hinge, edge law", "matched": "hinge, elements' K_theta"}
    return joints.get(name, f"{name} law")


def _margin(laws: Mapping[str, Answer]) -> float:
    """Return the margin of the responses that have one."""
    return next(float(data.attrs["margin"]) for data in laws.values() if "margin" in data.attrs)


def _title(words: _Words, file: str, beam: Beam, data: Answer) -> str:
    mus = ", ".join(f"{mu:g}" for mu in data["mu"].ravel())
    sense = f", sense {data.attrs['sense']}" if "sense" in data.attrs else ""
    return f"{file} {words.done}: {beam.scales} scales on {beam.length * 1e3:.4g} mm, mu = {mus}{sense}"


def _single(words: _Words, beam: Beam, margin: float, laws: Mapping[str, Answer]) -> Table:
    """Return the table with a row per figure and a column per law."""
    per_pitch, rate, torque = words.angle, words.rate, words.torque
    total = beam.length

    def figure(name: str, factor: float = 1.0, unit: str = "") -> Callable[[Answer], str]:
        # without engagement the curve has no end and no cut-off: it is as long as it is drawn
        ended = name.rpartition("_")[2] in ("end", "c")

        def cell(data: Answer) -> str:
            if name not in data.variables or (ended and data["end"].item() == End.NONE):
                return "-"
            return number(float(data[name]) * factor, unit)

        return cell

    def places(at: str) -> list[tuple[str, Callable[[Answer], str]]]:
        return [
            (f"  {words.per_pitch} {per_pitch}", figure(f"{per_pitch}_{at}", 1, "rad/pitch")),
            (f"  {words.rate_words} {rate}", figure(f"{rate}_{at}", 1, "rad/m")),
            (f"  in total over {beam.scales} scales", figure(f"{rate}_{at}", math.degrees(total), "deg")),
        ]

    theta0 = number(math.degrees(beam.scale.theta0), "deg")

    def at_engagement(data: Answer) -> str:
        engaged = float(data[f"{per_pitch}_e"])
        if not math.isfinite(engaged):
            return "-"
        if "w_Y" not in data.variables:
            return theta0
        # on a compliant joint a scale turns before it touches
        return number(math.degrees(np.interp(engaged, data[per_pitch], data["theta"])), "deg")

    rows: list[tuple[str, Callable[[Answer], str]]] = [
        ("end", lambda data: str(data["end"].item())),
        ("engagement", lambda _: ""),
        *places("e"),
        ("  phi by the small-angle formula", figure("phi_e_small", 1, "rad/pitch")),
        ("  inclination theta", at_engagement),
        ("at the end", lambda _: ""),
        *places("end"),
        ("  inclination theta", figure("theta_end", math.degrees(1), "deg")),
        (f"at the cut-off, margin {margin:g}", lambda _: ""),
        (f"  {words.rate_words} {rate}", figure(f"{rate}_c", 1, "rad/m")),
        (
            f"  {words.torque_words} {torque}",
            lambda data: "-" if data["end"].item() == End.NONE else moment(float(data[f"{torque}_c"])),
        ),
        ("  over the bare beam's", figure("stiffening")),
        ("  relative energy dissipation RED", figure("RED_c")),
        ("mu that locks at engagement", figure("mu_static")),
        ("neighbour in contact", lambda data: str(data["neighbour"].item())),
    ]
    table = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0), show_header=len(laws) > 1)
    table.add_column("")
    for name in laws:
        table.add_column(column(name), header_style="bold")
    for label, cell in rows:
        if label.endswith("small-angle formula") and per_pitch != "phi":
            continue
        cells = [cell(data) for data in laws.values()]
        table.add_row(label, *cells)
    return table


def _family(words: _Words, beam: Beam, data: Answer) -> Table:
    """Return the table with a row per coefficient of friction."""
    table = Table(box=None, pad_edge=False, padding=(0, 1, 0, 0))
    degrees = math.degrees(1)

    def ended(name: str, factor: float = 1.0) -> Callable[[Any], str]:
        return lambda c: "-" if c["end"].item() == End.NONE else number(float(c[name]) * factor)

    columns: dict[str, Callable[[Any], str]] = {
        "mu": lambda c: f"{float(c['mu']):g}",
        "end": lambda c: str(c["end"].item()),
        f"{words.angle}_e": lambda c: number(float(c[f"{words.angle}_e"])),
        f"{words.angle}_end": ended(f"{words.angle}_end"),
        "total deg": ended(f"{words.rate}_end", beam.length * degrees),
        "theta deg": ended("theta_end", degrees),
        f"{words.torque} N m": ended(f"{words.torque}_c"),
        f"{words.torque}/{words.torque}0": lambda c: number(float(c["stiffening"])),
        "RED": lambda c: number(float(c["RED_c"])),
    }
    for name in columns:
        table.add_column(name, header_style="bold", no_wrap=name == "end")
    for i in range(data.family or 0):
        curve = data.pick(i)
        table.add_row(*(cell(curve) for cell in columns.values()))
    return table


def _notes(load: str, beam: Beam, law: str, laws: Mapping[str, Answer]) -> list[str]:
    """Return the lines under the table: the joint, and a sentence for each kind of end."""
    if law == "compliant":
        from squama.cli import joints

        lines = joints.notes(beam, laws)
    else:
        lines = _stiffnesses(load, beam)
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
        pieces = by_law
        frictions = list(dict.fromkeys(tuple(mus) for mus in by_law.values()))
        if len(frictions) == 1 and len(by_law) == len(laws):
            pieces = {"": list(frictions[0])}
        for name, mus in pieces.items():
            of_law = f"{column(name)}, " if name else ""
            lines.append(f"other contact ({of_law}mu = {', '.join(mus)}): {text}")
    return lines


def _stiffnesses(load: str, beam: Beam) -> list[str]:
    matrix = beam.joint.matrix
    given = "given", "by its scaling law" if matrix is None or load == "bending" else f"from {matrix.name}"
    stiffness = beam.joint_stiffness if load == "twisting" else beam.bending_joint_stiffness
    rigidity = beam.torsional_rigidity if load == "twisting" else beam.bending_rigidity
    lines = [f"joint of a scale: K_theta = {moment(stiffness)} per rad, {given[beam.joint.stiffness is None]}"]
    if load == "twisting":
        lines.append(
            f"beam without contact: C_f J G_B = {rigidity:.4g} N m2, "
            f"inclusion factor C_f = {beam.C_f:.4g}, {given[beam.joint.inclusion_factor is None]}"
        )
    else:
        lines.append(f"beam without contact: C_f E_B I = {rigidity:.4g} N m2")
    return lines


def number(value: float, unit: str = "") -> str:
    """Return a number for people: four digits; infinity is "never"."""
    if math.isinf(value):
        return "never"
    return "-" if math.isnan(value) else f"{value:.4g} {unit}".strip()


def moment(value: float) -> str:
    """Return a torque for people, in N m or N mm."""
    return f"{value * 1e3:.4g} N mm" if 0 < abs(value) < 0.1 else f"{value:.4g} N m"

"""The numbers and words behind the page: all that one state shows, as plain data."""

from __future__ import annotations

import functools
import math
import tempfile
from pathlib import Path
from typing import NamedTuple

import numpy as np

from squama import arguments
from squama.curves.doors import respond
from squama.io import datasets
from squama.loads import LOADS
from squama.model.outcome import SENTENCES, End
from squama.plot.palette import WORDS
from squama.scene import standalone
from squama.scene.motion import Motion, Setting, shape
from squama.types import Array
from squama.units import number, prefix
from squama.web.state import State, read

POINTS = 140
"""Points of a curve."""
READABLE = 0.9
"""Near a lock the load grows without bound: axes end at this fraction of the way from engagement to the lock."""
NAMES = "ABC"
"""Kept designs."""
THRESHOLDS = {
    "load_twofold": "twice as stiff as the bar from",
    "load_fivefold": "five times from",
    "load_peak": "peak of the torque at",
    "load_strength": "stress comes to strength at",
    "load_strain": "strain comes to its limit at",
}
"""What replaces a lock on a joint that gives, by its role."""
KINDS = {"toml": "beam.toml", "csv": "curve.csv", "html": "beam.html"}
"""Names of the files that the page hands out, by their kind."""


def torque_label(load: str) -> str:
    """Return what the load is called: "Torque T"."""
    names = LOADS[load]
    return f"{names.torque_words.capitalize()} {names.torque}"


class Along(NamedTuple):
    """Variables along a curve, in the order of the load; ``bare`` is torque per load angle without contact."""

    load: Array
    torque: Array
    theta: Array
    f: Array
    bare: float
    load_e: float
    top: float


@functools.lru_cache(maxsize=32)
def motion(setting: Setting) -> Motion:
    """Return the curve of a setting; the last ones are kept."""
    return Motion(setting)


@functools.lru_cache(maxsize=32)
def along(setting: Setting) -> Along:
    """Return the variables of the plots."""
    m = motion(setting)
    v = m.along(POINTS)
    end, engaged = float(v["load"][-1]), m.load_e
    top = float(v["torque"].max())
    if m.end.locks and m.engaged:
        readable = engaged + READABLE * (end - engaged)
        top = float(np.interp(readable, v["load"], v["torque"]))
    bare = m.rigidity / setting.beam.pitch
    return Along(v["load"], v["torque"], np.degrees(v["theta"]), v["f"], bare, engaged, top)


def prepare(state: State) -> None:
    """Solve all that a state shows, to be kept; where a joint needs elements this takes seconds."""
    for one in (state, *state.kept):
        along(one.setting)


def taken(link: str) -> State:
    """Return the state of a link, and solve what is drawn of it first. Raises InputError: as :func:`state.read`."""
    found = read(link)
    for one in (found, *found.kept):
        along((one if one.quick else one.hinged).setting)
    return found


def scene(state: State) -> dict[str, object]:
    """Return what the three-dimensional view needs: design and state, no vertices."""
    m = motion(state.setting)
    now, design, many = m.state(state.twist), shape(state.setting, m.neighbour), state.beam.scales
    count = f"{many} scales" if design["scales"] == many else f"{design['scales']} of {many} scales"
    # what the view shows, for those who do not see it
    words = (
        f"Beam of {count}, {LOADS[state.load].done} by {number(now.load)} rad per pitch; "
        f"scales at {number(math.degrees(now.theta))} degrees, {WORDS[now.name]}"
    )
    return {"design": design, "state": {**now._asdict(), "mu": state.mu}, "words": words}


def readings(state: State) -> list[tuple[str, str]]:
    """Return the figures of the current point, as label and value."""
    m = motion(state.setting)
    now, names = m.state(state.twist), LOADS[state.load]
    ratio, stress = (m.value(role, state.twist) for role in ("stiffness_ratio", "stress"))
    more = [("stiffness over bar's", f"{ratio:.3g}")] if math.isfinite(ratio) else []
    more += [("stress", quantity(stress, "Pa"))] if math.isfinite(stress) else []
    total = math.degrees(now.load) * state.beam.scales
    return [
        (names.letter, f"{number(now.load)} rad/pitch = {number(now.load / state.beam.pitch)} rad/m"),
        ("in all", f"{number(total)}°"),
        (torque_label(state.load), quantity(now.torque, "N m")),
        ("θ", f"{number(math.degrees(now.theta))}°"),
        ("normal force", quantity(now.N, "N")),
        ("friction force", quantity(now.f, "N")),
        *more,
    ]


def outcome(state: State) -> tuple[str, str, str]:
    """Return the name of the end, by which model and where it is, and its sentence."""
    m = motion(state.setting)
    p, angle = m.figures, LOADS[state.load].letter
    where = [m.model]
    if math.isfinite(p["load_e"]):
        where.append(f"engagement at {angle} = {number(p['load_e'])}")
    for role, words in THRESHOLDS.items():
        if math.isfinite(p.get(role, math.nan)):
            where.append(f"{words} {angle} = {number(p[role])}")
    # a contact that ends the walk has its place in its words
    if m.end is not End.NONE and not (m.end is End.OTHER and m.joint == "compliant"):
        where.append(f"end at {angle} = {number(p['load_end'])} rad/pitch")
    if p["other_contact"]:
        where.append(f"other contact: {p['other_contact']}")
    words = SENTENCES[m.end]
    sentence = f"{words[0].upper()}{words[1:]}."
    if m.end is End.OTHER and m.joint == "compliant":
        sentence += " squama twist goes on."
    if state.twist > m.last:
        sentence += f" Shown at its last state, {angle} = {number(m.last)}."
    return str(m.end), "; ".join(where), sentence


def compared(state: State) -> list[dict[str, str]]:
    """Return a row of figures for each kept design and for the one that is shown."""
    rows = []
    for name, one in zip([*NAMES[: len(state.kept)], "now"], [*state.kept, state], strict=True):
        m = motion(one.setting)
        figures, ended = m.figures, m.end is not End.NONE
        rows.append(
            {
                "name": name,
                "what": f"{one.load}, μ = {one.mu:g}, η = {one.beam.eta:.3g}, "
                f"α = {math.degrees(one.beam.scale.alpha):.3g}°, {m.model}",
                "end": str(m.end),
                "engagement": number(figures["load_e"]),
                "at": number(figures["load_end"]) if ended else "-",
                "torque": quantity(figures["torque_c"], "N m") if ended else "-",
                "RED": number(figures["RED_c"]) if ended else "-",
            }
        )
    return rows


def warnings(state: State) -> list[str]:
    """Return where the beam leaves the range of the model."""
    m = motion(state.setting)
    found = [*m.notes, *state.beam.warnings(state.load, state.sense, m.joint)]
    most = shape(state.setting)["scales"]
    if state.beam.scales > most:
        found.append(f"the view shows {most} of the {state.beam.scales} scales")
    return found


def quantity(value: float, unit: str) -> str:
    """Return a number with the prefix of its unit."""
    factor, sign = prefix(value)
    return f"{value * factor:.4g} {sign}{unit}"


def make_file(state: State, kind: str) -> tuple[str, bytes]:
    """Return name and content of a file. Raises InputError: no such kind."""
    arguments.one_of("kind", kind, tuple(KINDS))
    if kind == "html":
        text = standalone.page(motion(state.setting), state.twist)
    elif kind == "toml":
        text = state.beam.to_toml()
    else:
        with tempfile.TemporaryDirectory() as folder:
            m = motion(state.setting)
            # up to what is shown: general contact would take seconds
            stop = None if m.hinge else m.last / state.beam.pitch
            place = datasets.save(respond(**state.setting._asdict(), to=stop).dataset(), Path(folder) / "curve.csv")
            text = place.read_text(encoding="utf-8")
    return KINDS[kind], text.encode()

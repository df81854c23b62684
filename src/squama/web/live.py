"""The numbers and words behind the page: all that one state shows, as plain data."""

from __future__ import annotations

import functools
import math
from typing import Any, NamedTuple

import numpy as np

from squama.model.outcome import End
from squama.model.solve import Array
from squama.view.motion import FREE, LOCKED, SLIDING, Motion, Setting, shape
from squama.web.state import State

POINTS = 140
"""Points of a curve."""
READABLE = 0.9
"""Near a lock the load grows without bound: axes end at this fraction of the way from engagement to the lock."""
COLOURS = ("#0072b2", "#b5651d", "#8a63b0")
"""Colours of the kept designs A, B, C, told apart by colour-blind readers too (each has its own dashes as well)."""
NAMES = "ABC"
WORDS = {
    "twisting": {"angle": "φ", "axis": "Twist per pitch φ (rad)", "load": "Torque T", "done": "twisted"},
    "bending": {"angle": "ψ", "axis": "Bend per pitch ψ (rad)", "load": "Moment M", "done": "bent"},
}
"""What the quantities of a kind of loading are called."""


class Along(NamedTuple):
    """Variables along a curve, in the order of the load, and what stands out of it."""

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
    end, engaged = float(v["load"][-1]), m.path.load_e
    top = float(v["torque"].max())
    if m.end.locks and m.path.engaged:
        readable = engaged + READABLE * (end - engaged)
        top = float(np.interp(readable, v["load"], v["torque"]))
    # bare: torque of the beam without contact per load angle
    bare = m.case.rigidity / m.case.pitch
    return Along(v["load"], v["torque"], np.degrees(v["theta"]), v["f"], bare, engaged, top)


def scene(state: State) -> dict[str, Any]:
    """Return what the three-dimensional view needs: design and state, no vertices."""
    m = motion(state.setting)
    now = m.state(state.twist)
    return {
        "design": shape(state.setting, m.path.neighbour),
        "state": {**now._asdict(), "mu": state.mu},
        "words": picture_words(state),
    }


def picture_words(state: State) -> str:
    """Say what the view shows, for those who do not see it."""
    m = motion(state.setting)
    now = m.state(state.twist)
    words = WORDS[state.load]
    many = state.beam.scales
    drawn = shape(state.setting)["scales"]
    count = f"{many} scales" if drawn == many else f"{drawn} of {many} scales"
    return (
        f"Beam of {count}, {words['done']} by {number(now.load)} rad per pitch; "
        f"scales at {number(math.degrees(now.theta))} degrees, {state_words(now.name)}"
    )


def state_words(name: str) -> str:
    """Return what a state of the scales is called."""
    return {FREE: "not in contact", SLIDING: "in sliding contact", LOCKED: "locked"}.get(
        name, "at the end of the curve"
    )


def readings(state: State) -> list[tuple[str, str]]:
    """Return the figures of the current point, as label and value."""
    m = motion(state.setting)
    now = m.state(state.twist)
    words = WORDS[state.load]
    total = math.degrees(now.load) * state.beam.scales
    return [
        (words["angle"], f"{number(now.load)} rad/pitch = {number(now.load / state.beam.pitch)} rad/m"),
        ("in all", f"{number(total)}°"),
        (words["load"], quantity(now.torque, "N m")),
        ("θ", f"{number(math.degrees(now.theta))}°"),
        ("normal force", quantity(now.N, "N")),
        ("friction force", quantity(now.f, "N")),
    ]


def outcome(state: State) -> tuple[str, str, str]:
    """Return the name of the end, where it is, and its sentence."""
    m = motion(state.setting)
    p, angle = m.path, WORDS[state.load]["angle"]
    where = []
    if math.isfinite(p.load_e):
        where.append(f"engagement at {angle} = {number(p.load_e)}")
    if m.end is not End.NONE:
        where.append(f"end at {angle} = {number(p.load_end)} rad/pitch")
    if p.other:
        where.append(f"other contact: {p.other}")
    sentence = m.sentence[0].upper() + m.sentence[1:] + "."
    if state.twist > m.last:
        sentence += f" Shown at its last state, {angle} = {number(m.last)}."
    return str(m.end), "; ".join(where), sentence


def compared(state: State) -> list[dict[str, str]]:
    """Return a row of figures for each kept design and for the one that is shown."""
    rows = []
    names = [f"{NAMES[i]}" for i in range(len(state.kept))]
    for name, one in zip([*names, "now"], [*state.kept, state], strict=True):
        m = motion(one.setting)
        figures = m.figures
        ended = m.end is not End.NONE
        rows.append(
            {
                "name": name,
                "what": f"{one.load}, μ = {one.mu:g}, η = {one.beam.eta:.3g}, "
                f"α = {math.degrees(one.beam.scale.alpha):.3g}°, {one.law if one.load == 'twisting' else 'edge'}",
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
    found = state.beam.warnings(state.load, state.sense)
    most = shape(state.setting)["scales"]
    if state.beam.scales > most:
        found.append(f"the view shows {most} of the {state.beam.scales} scales")
    return found


def number(value: float) -> str:
    """Return four digits; infinity is "never"."""
    if math.isinf(value):
        return "never"
    return "-" if math.isnan(value) else f"{value:.4g}"


def prefix(largest: float) -> tuple[float, str]:
    """Return the factor and the prefix that bring a size to a readable number."""
    size = abs(largest)
    for low, factor, sign in ((1e6, 1e-6, "M"), (1e3, 1e-3, "k"), (1.0, 1.0, ""), (1e-3, 1e3, "m")):
        if size >= low:
            return factor, sign
    return (1e6, "µ") if size else (1.0, "")


def quantity(value: float, unit: str) -> str:
    """Return a number with the prefix of its unit."""
    factor, sign = prefix(value)
    return f"{value * factor:.4g} {sign}{unit}"

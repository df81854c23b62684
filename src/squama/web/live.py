"""Numbers and texts of the page for one state, as plain data."""

from __future__ import annotations

import functools
import math
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from squama import arguments
from squama.curves.bent_twist import Twisted
from squama.curves.chosen import thin
from squama.curves.doors import respond
from squama.curves.histories import cycled
from squama.curves.labelled import Answer
from squama.errors import InputError, refuse
from squama.io import datasets
from squama.loads import ENDLESS, LOADS, ending
from squama.loads import FREE as LOOSE
from squama.model.outcome import SENTENCES, End
from squama.people import degrees, over, readable, turned
from squama.plot.palette import READABLE, WORDS
from squama.scene import standalone
from squama.scene.motion import FREE, SLIDING, Motion, Setting
from squama.study import columns, compliant_columns, models
from squama.symbols import OTHER
from squama.types import Array
from squama.units import number
from squama.web import fields
from squama.web.fields import FIELDS
from squama.web.state import State, read

if TYPE_CHECKING:
    import xarray as xr

POINTS = 140
"""Points of a curve."""
NEAR = 1e-9
PERIOD, STEP = 1500.0, 50.0
"""Duration of the bare bar's period in the played decay, and time between two pictures, ms."""
NAMES = "ABC"
"""Letters of the kept designs."""
RATIOS, SIZES = ("eta", "beta", "lam", "zeta"), ("length", "width", "bar_thickness", "embedded")
"""Fields of a ratio, and of the size that it determines."""
THRESHOLDS = {
    "load_twofold": "twice as stiff as the bar from",
    "load_fivefold": "five times from",
    "load_peak": "torque peaks at",
    "load_strength": "stress reaches the strength at",
    "load_strain": "strain reaches its limit at",
}
"""Load angles reported on compliant joints, which have no lock, by figure."""
KINDS = {"toml": "beam.toml", "csv": "curve.csv", "html": "beam.html"}
"""Names of the files for download, by kind."""


def torque_label(load: str) -> str:
    """Return words and symbol of the load: "Torque T"."""
    names = LOADS[load]
    return f"{names.torque_words.capitalize()} {names.torque}"


class Along(NamedTuple):
    """Variables along a curve: ``load`` (rad per pitch), ``torque`` (N m), ``theta`` (deg), ``f`` (N).

    ``bare``: torque per load angle without contact; ``locks``: whether the load grows without bound towards the end.
    """

    load: Array
    torque: Array
    theta: Array
    f: Array
    bare: float
    load_e: float = math.inf
    locks: bool = False

    def span(self, plot: str) -> tuple[float, float]:
        """Return the smallest and the largest readable value of a variable."""
        values: Array = getattr(self, plot)
        if self.locks and plot != "theta":
            values = values[self.load <= self.load_e + READABLE * (self.load[-1] - self.load_e)]
        return float(values.min()), float(values.max())


@functools.lru_cache(maxsize=32)
def motion(setting: Setting) -> Motion:
    """Return the motion of a setting, cached."""
    return Motion(setting)


@functools.lru_cache(maxsize=32)
def along(setting: Setting) -> Along:
    """Return the variables of the plots, cached."""
    m = motion(setting)
    v, bare = m.along(POINTS), m.rigidity / setting.beam.pitch
    locks = m.end.locks and m.engaged
    return Along(v["load"], v["torque"], np.degrees(v["theta"]), v["f"], bare, m.load_e, locks)


def own_joint(state: State) -> dict[str, float]:
    """Return joint stiffness and inclusion factor of the displayed model, by field."""
    m, kind, beam = motion(state.setting), LOADS[state.load], state.beam
    return {"stiffness": m.stiffness, "inclusion": m.rigidity / kind.rigidity(beam) * kind.inclusion(beam)}


def beside(state: State) -> Along | None:
    """Return the curve of the other model; None where it is not available at once."""
    other = state.beside
    try:
        return along(other.setting) if other and motion(other.setting).joint != motion(state.setting).joint else None
    except InputError:
        return None


def _model(setting: Setting) -> dict[str, Any]:
    """Return friction, load and model of a setting as arguments of the package's functions."""
    s = setting
    return {"mu": s.mu, "load": s.load, "joint": motion(s).joint, "ideal": s.ideal, "ends": ENDLESS}


@functools.lru_cache(maxsize=16)
def history(setting: Setting, values: tuple[float, ...]) -> Answer:
    """Return the response to a history of load angles per pitch (signed, rad), from rest.

    Raises InputError where the model does not follow the history.
    """
    s = setting
    if s.bend:
        refuse("", "", "with a held bend the explorer only loads; squama bend-twist unloads, too")
    law, rates = LOADS[s.load].law(s.law), [v / s.beam.pitch for v in values]
    return cycled(s.beam, rates, law=law, margin=s.margin, points=POINTS // 2, **_model(s))


def loop(state: State) -> Answer | str:
    """Return the response to loading to the displayed twist and unloading, or the reason why there is none."""
    m = motion(state.setting)
    top = reached(state)
    if not top:
        return "nothing moves"
    try:
        return history(state.setting, (0.0, top if state.setting.sense == "+" or not m.kind.sided else -top, 0.0))
    except InputError as error:
        return str(error)


def back(state: State) -> Along | None:
    """Return the curve of unloading; None where the load path has no unloading."""
    if state.path != "cycle" or isinstance(found := loop(state), str):
        return None
    names, way = LOADS[state.load], found["leg"] == 2
    # the last point of loading is the first of unloading
    way[np.flatnonzero(way)[0] - 1] = True
    load, torque, theta, f = (found[name][way] for name in (names.angle, names.torque, "theta", "f"))
    sign = 1 if load.max() > 0 else -1
    return Along(sign * load, sign * torque, np.degrees(theta), f, along(state.setting).bare)


def reached(state: State) -> float:
    """Return the load angle at which unloading begins: just before the end, where it would be refused."""
    return min(state.twist, (1 - NEAR) * motion(state.setting).last)


class Swing(NamedTuple):
    """A decay to be played: pictures, each with design and state of the view, ``step`` ms apart.

    ``words``: its damping, and warnings that the page does not show already.
    """

    frames: list[dict[str, dict[str, object]]]
    step: float
    words: str


@functools.lru_cache(maxsize=4)
def swing(state: State) -> Swing:
    """Release the beam from the displayed load; damping is by friction alone.

    Raises InputError where nothing moves, or a swing leaves the range of the model.
    """
    from squama.dynamics.doors import vibrate

    s, m = state.setting, motion(state.setting)
    top = reached(state)
    sign = -1 if s.sense == "-" and m.kind.sided else 1
    release = sign * top / s.beam.pitch
    found = vibrate(s.beam, release=release, rotor=1.0, law=arguments.law(s.law), **_model(s))
    turn = found["t"].values * float(found["f_0"])
    times = np.arange(0.0, turn[-1], STEP / PERIOD)
    angles = np.interp(times, turn, found[m.kind.angle].values)
    # twist in the other sense follows that sense's curve; bending away from the scales has no contact
    other = motion(s._replace(sense="-" if s.sense == "+" else "+")) if m.kind.sided else None
    frames = []
    for angle in (sign * angles).tolist():
        one, load = (m, angle) if angle >= 0 or not other else (other, -angle)
        # scales are drawn as in loading and coloured by contact only; forces differ in unloading and are omitted
        name = SLIDING if one.touches(load) else FREE
        shape: dict[str, Any] = {"load": load, "x": 0.0} | ({"strains": None, "bent": None} if load < 0 else {})
        now = one.state(max(load, 0.0))._replace(name=name, **shape)
        if now.other:
            now = now._replace(other=now.other._replace(**shape))
        frames.append(standalone.drawn(one, now))
    zeta = found["zeta_cycle"].values.tolist()
    words = "friction holds it on the way back"
    if zeta:
        first, last = number(zeta[0]), number(zeta[-1])
        words = f"damping ratio {first} in the first cycle, {last} in cycle {len(zeta)}, by friction alone"
    own = warnings(state)
    more = [f"Warning: {line}" for line in found.attrs["warnings"].splitlines() if line not in own]
    return Swing(frames, STEP, "\n".join([f"Let go at {turned(top, state.beam)}: {words}.", *more]))


def prepare(state: State) -> None:
    """Compute and cache all curves of a state; a joint that needs finite elements takes seconds."""
    for one in (state, *state.kept):
        along(one.setting)


def linked(link: str) -> State:
    """Return the state of a link with its curves computed. Raises InputError as :func:`state.read`."""
    found = read(link)
    for one in (found, *found.kept):
        along((one if one.quick else one.hinged).setting)
    return found


def scene(state: State) -> dict[str, object]:
    """Return the data of the three-dimensional view: design and state, no vertices."""
    m = motion(state.setting)
    now, many = m.state(state.twist), state.beam.pitches
    shown = standalone.drawn(m, now)
    design = shown["design"]
    count = f"{many} scales" if design["scales"] == many else f"{design['scales']} of {many} scales"
    # description of the view for screen readers
    bent = f"bent by {turned(state.bend, state.beam)} and " if state.bent else ""
    words = (
        f"Beam of {count}, {bent}{LOADS[state.load].done} by {turned(now.load, state.beam)}; "
        f"scales at {number(math.degrees(now.theta))} degrees, {WORDS[now.name]}"
    )
    return {**shown, "words": words}


def readings(state: State) -> list[tuple[str, str]]:
    """Return the figures of the current point and of its loop, as label and value."""
    m = motion(state.setting)
    now, names = m.state(state.twist), LOADS[state.load]
    # the larger one of both faces
    stress = [v for role in ("stress", f"stress{OTHER}") if math.isfinite(v := m.value(role, state.twist))]
    more = [("stress", quantity(max(stress), "Pa"))] if stress else []
    found = loop(state) if state.path == "cycle" else ""
    if not isinstance(found, str) and found["W_d"].size:
        more += [("dissipated", quantity(float(found["W_d"][0]), "J/m")), ("ζ_eq", number(found["zeta_eq"][0]))]
    return [
        (names.verb.capitalize(), turned(now.load, state.beam) + over(state.beam)),
        (torque_label(state.load), quantity(now.torque, "N m")),
        ("θ", number(math.degrees(now.theta), "deg")),
        ("normal force", quantity(now.N, "N")),
        ("friction force", quantity(now.f, "N")),
        *more,
    ]


def angles(state: State) -> tuple[float, str]:
    """Return the unit of twists or bends of a state and its kept designs, after its factor from rad per pitch."""
    return degrees(state.beam, *(one.beam for one in state.kept))


def verdict(state: State) -> str:
    """Return a sentence: free range of the endless beam, and its stiffness at the displayed load, or its lock."""
    m, kind = motion(state.setting), LOADS[state.load]
    if not math.isfinite(engaged := float(m.figures["load_e"])):
        return f"Endless beam: the scales never touch; {kind.done}, it is as soft as its bar"
    free = f"free until {turned(engaged, state.beam)}" if engaged else f"the scales touch before it is {kind.done}"
    free = f"Endless beam: {free}"
    if m.end.locks:
        return f"{free}, locks at {turned(float(m.figures['load_end']), state.beam)}"
    now = min(state.twist, m.last)
    ratio = m.value("stiffness_ratio", now) if now > engaged else math.nan
    # the value per pitch is in the line below
    factor, unit = degrees(state.beam)
    shown = number(factor * now, unit)
    if not math.isfinite(ratio):
        return f"{free}{'' if now > engaged else '; the scales do not touch yet'}"
    if ratio < 0:
        return f"{free}, the {kind.torque_words} falls at {shown}"
    return f"{free}, {number(ratio)} times as stiff as the bar at {shown}"


@functools.lru_cache(maxsize=64)
def share(setting: Setting, load: float) -> float:
    """Return the torque of the beam's own number of scales over that of the endless beam, at a load angle per pitch.

    NaN for an endless beam, on hinges, with a held bend, and where the joint comes from finite elements.
    """
    s, m = setting, motion(setting)
    own = models.own_scales(s.beam, s.load, bent=False)
    if own is None or m.hinge or s.bend:
        return math.nan
    # thin scales where law and joint of the curve require them, as on the map
    ideal = thin(m.kind, s.law, m.joint, ideal=m.ideal)
    cells = columns.columns(s.beam, {})
    found = compliant_columns.solved(cells, load, load=s.load, sense=s.sense, ideal=ideal, along=False, own=own)
    return float(found.finite_ratio[0])


def own_scales(state: State) -> str:
    """Return a sentence on the load of the beam's own number of scales at the displayed load; "" where unknown."""
    m, beam = motion(state.setting), state.beam
    now = min(state.twist, m.last)
    if not now > m.load_e or not math.isfinite(part := share(state.setting, now)):
        return ""
    differs = (
        f"about {100 * abs(part - 1):.2g} % {'less' if part < 1 else 'more'}" if abs(part - 1) >= 5e-4 else "the same"
    )
    return f"Your {beam.extent} {ending(beam.ends or LOOSE)} carry {differs} {m.kind.torque_words} there"


def outcome(state: State) -> tuple[str, str, str]:
    """Return the name of the end ("" where the range ends), its load angle, earlier thresholds, and its sentence."""
    m = motion(state.setting)
    p, where = m.figures, []
    if m.end is not End.NONE:
        where.append(f"at {turned(float(p['load_end']), state.beam)}")
    for role, words in THRESHOLDS.items():
        if math.isfinite(p.get(role, math.nan)):
            where.append(f"{words} {turned(float(p[role]), state.beam)}")
    if other := str(p["other_contact"]):
        where.append(f"other contact: {other}")
    words = SENTENCES[m.end]
    sentence = f"{words[0].upper()}{words[1:]}."
    if state.twist > m.last:
        sentence += f" Shown at its last state, {turned(m.last, state.beam)}."
    return "" if m.end is End.RANGE else str(m.end), "; ".join(where), sentence


def _differing(states: Sequence[State]) -> list[str]:
    """Return the fields in which designs differ, without dependent ones; the usual fields if there are none."""
    # at equal pitch the ratios describe the difference, else the sizes
    left_out = {*(SIZES if len({one.beam.pitch for one in states}) == 1 else RATIOS), "slenderness", "twist"}
    own = (name for name in FIELDS if name not in left_out)
    return [n for n in own if len({one.value(n) for one in states}) > 1] or ["mu", "eta", "alpha"]


def _described(state: State, names: Sequence[str], states: Sequence[State]) -> str:
    """Return the values of some fields of one design as text, and its sense where that differs."""
    words = []
    for name in names:
        field = fields.of(name, *(one.beam for one in (state, *states)), load=state.load)
        values = [one.value(name) for one in (state, *states)]
        # as few digits as distinguish the designs
        for digits in (3, 4, 6):
            own, *every = ("not given" if v is None else f"{v / field.factor:.{digits}g}" for v in values)
            if len({*every}) == len({*values}):
                break
        unit = "" if values[0] is None else field.unit
        words.append(f"{field.symbol} = {own} {unit}".strip())
    if len({one.sense for one in states}) > 1:
        words.append(f"sense {state.sense}")
    return ", ".join(words)


def compared(state: State) -> list[dict[str, str]]:
    """Return a row of figures for each kept design and for the displayed one."""
    rows, alike = [], all(one.load == state.load for one in state.kept)
    every = [*state.kept, state]
    differing, turn = _differing(every), angles(state)[0]
    for name, one in zip([*NAMES[: len(state.kept)], "now"], every, strict=True):
        m = motion(one.setting)
        figures = m.figures
        row = {
            "name": name,
            "what": _described(one, differing, every),
            "model": m.model if alike else f"{one.load}, {m.model}",
            "end": str(m.end),
            "engagement": number(turn * figures["load_e"]),
        }
        if m.end is End.NONE:
            rows.append(row | {"at": "-", "torque": "-", "RED": "-"})
        else:
            torque = quantity(figures["torque_c"], "N m")
            at = number(turn * figures["load_end"])
            rows.append(row | {"at": at, "torque": torque, "RED": number(figures["RED_c"])})
    return rows


def warnings(state: State) -> list[str]:
    """Return warnings where the beam leaves the range of the model, and on limits of the page."""
    m = motion(state.setting)
    found = [*dict.fromkeys([*m.notes, *state.beam.warnings(state.load, state.sense, m.joint)])]
    most = m.shape()["scales"]
    if state.beam.pitches > most:
        found.append(f"the view shows {most} of the {state.beam.pitches} scales")
    if state.bent:
        found.insert(0, "the map does not include the held bend")
    if state.path == "cycle" and isinstance(reason := loop(state), str):
        found.append(f"no unloading is shown: {reason}")
    return found


def quantity(value: float, unit: str) -> str:
    """Return a number in a readable unit."""
    factor, unit = readable(unit, value)
    return f"{number(value * factor)} {unit}"


def make_file(state: State, kind: str) -> tuple[str, bytes]:
    """Return name and content of a file for download. Raises InputError for an unknown kind."""
    arguments.one_of("kind", kind, tuple(KINDS))
    if kind == "html":
        text = standalone.page(motion(state.setting), state.twist)
    elif kind == "toml":
        text = state.beam.to_toml()
    else:
        with tempfile.TemporaryDirectory() as folder:
            text = datasets.save(_table(state), Path(folder) / "curve.csv").read_text(encoding="utf-8")
    return KINDS[kind], text.encode()


def _table(state: State) -> xr.Dataset:
    """Return the curve up to the displayed load, or the loop."""
    m, how = motion(state.setting), state.setting._asdict()
    del how["to"], how["ends"]
    if state.bent:
        del how["load"], how["law"]
        return Twisted.of(**how).answer.dataset()
    del how["bend"]
    if state.path != "cycle":
        return respond(**how, ends=ENDLESS, to=None if m.hinge else m.last / state.beam.pitch).dataset()
    found = loop(state)
    if isinstance(found, str):
        refuse("", "", found)
    return found.dataset()

"""Public functions of vibration in SI units: ``vibrate`` (released or struck) and ``shake`` (harmonic torque)."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, NamedTuple, NoReturn

import numpy as np

from squama import arguments
from squama.beam import beamfile
from squama.beam.design import Beam
from squama.beam.parts import Quantity
from squama.curves import labelled
from squama.curves.chosen import MODELS
from squama.curves.doors import analysis, ends_of
from squama.curves.labelled import Answer
from squama.curves.way import Analysis, States, Way
from squama.dynamics import motion, systems
from squama.dynamics.branches import Side
from squama.dynamics.decay import BEYOND, JAMS, RINGS, Decay, Sides, damping, decay
from squama.dynamics.hinge_branches import FINEST
from squama.dynamics.motion import Drive, State
from squama.dynamics.systems import Bar, Model
from squama.errors import naming, refuse
from squama.loads import ENDLESS, MODES, UNIFORM, EndsName, JointName, LawName, LoadName, ModeName
from squama.people import at_most, per_pitch
from squama.progress import steps
from squama.types import Array
from squama.units import Bounds, Dimension, bounded, shown

if TYPE_CHECKING:
    import xarray as xr

MOST_SWINGS, MOST_FREQUENCIES = 10_000, 1_000
FAR = 0.6
"""Largest twist per pitch, rad, to which a struck or shaken beam with thick scales is followed."""
DAMPING = Bounds(0.0, 0.5, "0 to 0.5", closed=True, example="0.01")
FREQUENCY = Bounds(1e-6, 1e9, "more than 0; 1e-6 to 1e9 Hz", closed=True, example='"3 Hz"')
IMPULSE = Bounds(1e-18, 1e15, "more than 0; 1e-18 to 1e15 N m s", closed=True, example='"0.01 N m s"')
_UNITS = {"impulse": (Dimension.IMPULSE, IMPULSE), "torque": beamfile.NUMBERS["joint.stiffness"]}
_UNITS |= {name: beamfile.NUMBERS[f"beam.{name}"] for name in ("rotor", "density")}
"""Dimensions and bounds of the quantities that are not load angles, by the name of the argument."""

ByDim = dict[tuple[str, ...], dict[str, Array]]
"""Arrays by dimensions of the dataset, then by role."""


class Swinging(NamedTuple):
    """A beam prepared for vibration: its model, mode, bar, branches in both senses, and the analysis."""

    beam: Beam
    model: Model
    mode: str
    bar: Bar
    sides: Sides
    analysis: Analysis

    def answer(self, title: str, by_dim: ByDim, low: float, high: float, **attrs: float | str) -> Answer:
        """Return the answer of a motion between the load angles ``low`` and ``high``, with all its notes."""
        notes = [*self.bar.notes, *systems.notes(self.beam, self.model, self.sides.limit, low, high)]
        load, own = self.model.load, {"f_0": np.asarray(self.bar.omega / (2 * math.pi))}
        engaged = {"load_e": np.asarray(self.sides.plus.y_e)}
        by_dim = {**by_dim, (): {**engaged, **own, **by_dim[()]}}
        said: dict[str, float | str] = {"mode": self.mode, "inertia": self.bar.inertia}
        if self.model.ends != ENDLESS:
            said["ends"] = self.model.held_in(self.mode)
        if not (load.sided or MODELS[self.model.joint].straight):
            said["neutral"] = self.beam.given.line
        title = f"{title} of a scale-covered beam in {load.name}"
        return labelled.answer(self.analysis, States(by_dim, attrs, notes), title, said)


def vibrate(
    beam: Beam,
    *,
    release: Quantity | None = None,
    impulse: Quantity | None = None,
    rotor: Quantity | None = None,
    density: Quantity | None = None,
    damping: float = 0.0,
    swings: int = 8,
    mu: float | None = None,
    law: LawName = "edge",
    load: LoadName = "twisting",
    mode: ModeName = "uniform",
    joint: JointName | None = None,
    ideal: bool | None = None,
    ends: EndsName | None = None,
) -> xr.Dataset:
    """Let a beam vibrate freely: its motion in time, turning points, and the damping of every cycle.

    A beam with a number of scales vibrates by the torque or moment of all of them, between free ends: its own scales
    set its frequency and damping. In a bending mode each cell carries the moment of the mode's inertia forces.

    Parameters
    ----------
    beam
        The beam.
    release
        Twist (in bending curvature) from which the beam is released, as ``to`` of :func:`squama.twist`; negative in the
        other sense. In a mode it is the largest along the beam.
    impulse
        Alternatively an angular impulse on the rotor at rest, N m s or text such as "0.01 N m s"; uniform load only.
    rotor
        Moment of inertia of the rotor at the end (in bending of one at either end), kg m^2 or text such as
        "1e-4 kg m2"; the beam's own if not given.
    density
        Density of the bar, kg/m^3 or text; the beam's own if not given. In a mode the inertia is that of the bar and of
        the scales (``scale.density``). In uniform load it is the rotor's, plus a third of the polar inertia of bar and
        scales in twisting, or that of an arc whose ends turn in bearings in bending. Where a density is unknown, a
        warning gives the effect of typical densities.
    damping
        Damping ratio of the bar's material, 0 to 0.5. With 0 the turning points come from an exact balance of
        energies, else from integration with events.
    swings
        Number of cycles.
    mu, law, joint, ideal
        As in :func:`squama.cycle`.
    load
        "twisting" or "bending".
    mode
        "uniform", or in bending the first mode of a bar that is "simply supported" or a "cantilever".
    ends
        For a beam with a number of scales: "free" (the default), "equal" or "endless", as in :func:`squama.twist`; in
        a mode only "endless" is allowed: each cell then has the law of an endless beam.

    Returns
    -------
    xarray.Dataset
        Dimension ``point``, the record: ``t`` (s), ``phi``, ``phi_speed``. Dimension ``turn``, turning points:
        ``t_turn``, ``phi_turn``, ``U_turn`` (elastic energy of the beam, J). Dimension ``cycle``: ``zeta_cycle`` by
        the energies at its peaks, ``period``. ``f_0`` frequency of the bar without contact; ``end``: "rings", or
        "jams" at ``phi_rest``. In bending ``psi`` in place of ``phi``. See docs, theory: vibration.

    Raises
    ------
    InputError
        An argument is out of range, or a swing has more energy than the model can take up.

    Examples
    --------
    >>> import squama
    >>> beam = squama.Beam.from_ratios(youngs_modulus="2 MPa", mu=0.3)
    >>> v = squama.vibrate(beam, release="0.15 rad/pitch", rotor="0.01 kg m2", joint="hinge", ideal=True)
    >>> print(f"{float(v.f_0):.3f} Hz bare, damping {float(v.zeta_cycle[0]):.4f}, then {float(v.zeta_cycle[1]):.4f}")
    0.560 Hz bare, damping 0.0283, then 0.0249
    """
    arguments.beam(beam)
    if (release is None) == (impulse is None):
        refuse("release, impulse", "", "needs exactly one of the two", 'give one, e.g. a release at "0.1 rad/pitch"')
    n = arguments.whole("swings", swings, 1, MOST_SWINGS)
    zeta = _bounded("damping", damping, Dimension.RATIO, DAMPING)
    read = _quantities(beam, load, mode, release=release, impulse=impulse, rotor=rotor, density=density)
    model, request = model_of(beam, mu, law, load, joint, ideal, ends_in(mode, ends))
    bar = systems.bar(beam, model, mode, read.get("rotor", beam.rotor), read.get("density", beam.density))
    if impulse is not None and mode != "uniform":
        refuse("impulse", "", "acts on a rotor, and a mode has none", "give release")
    # the rotor turns by the angle of all pitches; each of two rotors by half of it
    share = beam.pitches / (1 if model.load.sided else 2)
    start, speed = read.get("release", 0.0), read.get("impulse", 0.0) / (bar.inertia * bar.omega * share)
    sides = systems.sides(beam, model, mode, -1 if start < 0 else 1, min(speed, FAR) if speed else abs(start))
    one = Swinging(beam, model, mode, bar, sides, request)
    side = sides.of(-1 if start < 0 else 1)
    if abs(start) > side.last * (1 + 1e-9):
        reason = f"is beyond {per_pitch(side.last, 6)}, where the contact ends: {side.ends}"
        refuse("release", per_pitch(start, 6), reason, f'write at most "{at_most(0.999 * side.last)}"')
    first, drive = State(0.0, start, speed), Drive(zeta, tolerance=systems.tolerance(model))
    found = _damped(one, drive, first, n) if zeta else decay(sides, start=start, speed=speed, turns=2 * n + 1).single()
    if found.end == BEYOND:
        _beyond(one, found, "impulse" if speed else "release")
    return _free_vibration(one, drive, found, first).dataset()


def _quantities(beam: Beam, load: str, mode: str, **given: Quantity | None) -> dict[str, float]:
    """Return the given quantities by name, in SI units and load angles per pitch.

    They are read before the joint is determined, which may take finite elements.
    """
    kind, found = arguments.load(load), dict[str, float]()
    arguments.one_of("mode", mode, MODES)
    for name, value in given.items():
        if value is not None and name in _UNITS:
            found[name] = _bounded(name, value, *_UNITS[name])
        elif value is not None:
            with naming(name):
                found[name] = kind.read(value, pitch=beam.pitch, scales=beam.pitches) * beam.pitch
            arguments.moves(name, found[name])
            if abs(found[name]) >= math.pi:
                refuse(name, per_pitch(found[name], 6), "must be below half a turn per pitch")
    return found


def model_of(
    beam: Beam, mu: float | None, law: str, load: str, joint: str | None, ideal: bool | None, ends: str | None = ENDLESS
) -> tuple[Model, Analysis]:
    """Return the model and the analysis of a beam under a load; ``ends`` is "endless" by default."""
    kind = arguments.load(load)
    way = Way.of(kind.name, [1.0])
    one = analysis(beam, way, kind, mu=mu, law=law, margin=FINEST, points=3, joint=joint, ideal=ideal)
    if ends != ENDLESS:
        one = one._replace(ends=ends_of(one, ends, history=True, grips=False))
    return Model(kind, float(one.mus), one.law, one.joint, one.ideal, one.ends), one


def ends_in(mode: str, ends: str | None) -> str | None:
    """Return the word for the ends; a mode holds them itself, and refuses words other than "endless"."""
    if mode != UNIFORM and ends not in (None, ENDLESS):
        refuse("ends", shown(ends), f"is for the uniform mode: a {mode} bar is held by its mode", "leave it out")
    return ends


def _bounded(name: str, value: object, dimension: Dimension, bounds: Bounds) -> float:
    with naming(name):
        return bounded(value, dimension, bounds)


def _beyond(one: Swinging, found: Decay, name: str) -> NoReturn:
    """Refuse a motion with more energy than the model's branches can store."""
    sign = -1 if found.y.size and found.y[-1] > 0 else 1
    side, unit = one.sides.of(sign), one.bar.energy
    height = float(np.max(side.height())) * unit
    why = f"where the contact ends: {side.ends}; what comes then (an impact, another contact) is not in the model"
    reason = (
        f"a swing in the sense {'+' if sign > 0 else '-'} has {found.energy * unit:.4g} J, and {height:.4g} J take it "
        f"to {per_pitch(side.last, 4)}, {why if side.ends else 'no further was the beam followed'}"
    )
    refuse(name, "", reason, "give less")


def _damped(one: Swinging, drive: Drive, state: State, cycles: int) -> Decay:
    """Return the turning points of a motion with material damping, integrated in time with events."""
    sides = one.sides

    def turn(at: State) -> tuple[float, float, float]:
        return at.t, at.y, sides.of(-1 if at.y < 0 else 1).stored(abs(at.y), abs(at.y))

    rows = [turn(state)] if state.y else []
    # a cycle takes less than twice the undamped bare bar's
    until, end, rest = (2 * cycles + 1) * 2 * math.pi, RINGS, math.nan
    for part in motion.follow(sides, drive, state, until):
        state = part.last
        if part.why == motion.TURNED:
            rows.append(turn(state))
        if part.why == motion.STUCK:
            end, rest = JAMS, state.y
        if part.why == motion.BEYOND:
            end = BEYOND
        if len(rows) > 2 * cycles:
            break
    t, y, stored = np.array(rows, float).reshape(-1, 3).T
    return Decay(t, y, stored, end, rest, state.y**2 / 2 + state.v**2 / 2)


def _free_vibration(one: Swinging, drive: Drive, found: Decay, start: State) -> Answer:
    """Return the answer to a free vibration, with its motion in time."""
    # a beam that jams is seen to stay, for a period of the bare bar
    second, until = 1 / one.bar.omega, float(found.t[-1]) + (2 * math.pi if found.end == JAMS else 0.0)
    t, y, v = motion.joined(start, motion.follow(one.sides, drive, start, until, dense=motion.DENSE))
    peaks = slice(0, None, 2)
    by_dim: ByDim = {
        ("point",): {"t": t * second, "load": y, "load_speed": v / second},
        ("turn",): {"t_turn": found.t * second, "load_turn": found.y, "U_turn": found.stored * one.bar.energy},
        ("cycle",): {"zeta_cycle": damping(found.stored[peaks]), "period": np.diff(found.t[peaks]) * second},
        (): {"load_rest": np.asarray(found.rest), "end": np.asarray(found.end)},
    }
    answer = one.answer("free vibration", by_dim, float(y.min()), float(y.max()), damping=drive.zeta)
    answer.over = ("t",)
    return answer


# ---- forced -----------------------------------------------------------------------------------------------


def shake(
    beam: Beam,
    frequencies: Sequence[float] | Array,
    *,
    static: Quantity | None = None,
    torque: Quantity | None = None,
    rotor: Quantity | None = None,
    density: Quantity | None = None,
    damping: float = 0.01,
    mu: float | None = None,
    law: LawName = "edge",
    load: LoadName = "twisting",
    mode: ModeName = "uniform",
    joint: JointName | None = None,
    ideal: bool | None = None,
    ends: EndsName | None = None,
) -> xr.Dataset:
    """Shake a beam by a harmonic torque: steady states over frequencies, swept up and down.

    The beam's torque or moment is that of its own scales, as in :func:`vibrate`.

    Parameters
    ----------
    beam
        The beam.
    frequencies
        Frequencies of the torque, Hz, growing.
    static
        Amplitude of the torque, given as the twist of the bare beam at rest under it, as ``to`` of
        :func:`squama.twist`; in a mode the largest curvature.
    torque
        Alternatively the amplitude of the torque itself, N m or text; uniform load only.
    damping
        Damping ratio of the bar's material, above 0 to 0.5.
    rotor, density, mu, law, load, mode, joint, ideal, ends
        As in :func:`vibrate`.

    Returns
    -------
    xarray.Dataset
        Dimensions ``way`` ("up", "down") and ``frequency``: ``phi_high``, ``phi_low`` largest and smallest twist,
        ``W_fed``, ``W_rubbed``, ``W_damped`` works over a period (J), ``periods`` until it was steady, ``settled``
        (False for a motion that does not repeat with the torque; its extremes are those of the last 50 periods).
        Each frequency starts from the state of the previous one, so coexisting states show as a
        difference between both ways.

    Raises
    ------
    InputError
        An argument is out of range; a motion goes beyond the model, or turns and sticks too often.

    Examples
    --------
    >>> import squama
    >>> beam = squama.Beam.from_ratios(youngs_modulus="2 MPa", mu=0.2)
    >>> s = squama.shake(beam, [0.5, 0.6], static="0.06 rad/pitch", rotor="0.01 kg m2", joint="hinge", ideal=True)
    >>> print(s.phi_high.values.round(4).tolist())
    [[0.0832, 0.099], [0.0832, 0.099]]
    """
    arguments.beam(beam)
    if (static is None) == (torque is None):
        refuse("static, torque", "", "needs exactly one of the two", 'give one, e.g. a static "0.05 rad/pitch"')
    hertz = arguments.positive("frequencies", frequencies)
    if hertz.ndim != 1 or not 1 <= hertz.size <= MOST_FREQUENCIES or (np.diff(hertz) <= 0).any():
        refuse("frequencies", "", f"must be 1 to {MOST_FREQUENCIES} growing numbers", "write e.g. [2, 2.5, 3]")
    zeta = _bounded("damping", damping, Dimension.RATIO, DAMPING)
    read = _quantities(beam, load, mode, static=static, torque=torque, rotor=rotor, density=density)
    model, request = model_of(beam, mu, law, load, joint, ideal, ends_in(mode, ends))
    bar = systems.bar(beam, model, mode, read.get("rotor", beam.rotor), read.get("density", beam.density))
    if torque is not None and mode != "uniform":
        refuse("torque", "", "acts on a rotor, and a mode has none", "give static")
    # a torque is converted to the load angle of the bar without contact
    force = abs(read["static"]) if torque is None else read["torque"] / (bar.rigidity / beam.pitch)
    one = Swinging(beam, model, mode, bar, systems.sides(beam, model, mode, 1, FAR), request)
    ratios = hertz * 2 * math.pi / one.bar.omega
    there_and_back = np.concatenate([ratios, ratios[::-1]])
    found = _steady_states(one, zeta, force, steps(there_and_back.tolist(), 2 * hertz.size, "frequencies"))

    def table(name: str, factor: float = 1.0) -> Array:
        values = np.array([getattr(state, name) for state in found]) * factor
        return np.array([values[: hertz.size], values[: hertz.size - 1 : -1]])

    unit = one.bar.energy
    along = {"load_high": table("high"), "load_low": table("low"), "settled": table("settled") > 0}
    along |= {"W_fed": table("fed", unit), "W_damped": table("damped", unit), "W_rubbed": table("rubbed", unit)}
    along |= {"periods": table("periods"), "turns": table("parts")}
    by_dim: ByDim = {
        ("way", "frequency"): along,
        ("way",): {"way": np.array(["up", "down"])},
        ("frequency",): {"frequency": hertz},
        (): {"load_static": np.asarray(force)},
    }
    low, high = float(along["load_low"].min()), float(along["load_high"].max())
    return one.answer("steady states", by_dim, low, high, damping=zeta).dataset()


def frequency(name: str, text: str) -> float:
    """Return a frequency in Hz from text with its unit."""
    return _bounded(name, text, Dimension.FREQUENCY, FREQUENCY)


def _steady_states(one: Swinging, zeta: float, force: float, ratios: Iterable[float]) -> list[motion.Steady]:
    """Return the steady states of frequency ``ratios`` in their order, each started from the previous one."""
    y, v = 0.0, 0.0
    found = []
    for ratio in ratios:
        try:
            state = motion.steady(one.sides, Drive(zeta, force, ratio, systems.tolerance(one.model)), y, v)
        except motion.LeftError as error:
            _unsteady(one, error, ratio)
        found.append(state)
        y, v = state.y, state.v
    return found


def _unsteady(one: Swinging, error: motion.LeftError, ratio: float) -> NoReturn:
    at = f"{ratio * one.bar.omega / (2 * math.pi):.4g} Hz"
    if error.why == motion.EVENTS:
        reason = f"the motion turns and sticks more than {motion.MOST_PARTS} times in a period"
        refuse("frequencies", at, reason, "give a higher one, or more damping")
    side: Side = one.sides.of(1 if error.state.y > 0 else -1)
    reason = f"the motion goes beyond {per_pitch(side.last, 4)}: {side.ends or 'no further was the beam followed'}"
    refuse("frequencies", at, reason, "shake less, or give other frequencies")

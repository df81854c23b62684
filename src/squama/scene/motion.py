"""Motion of a loaded beam for pictures: inclination, contact, slip and forces at any load."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from copy import copy
from typing import Any, NamedTuple, Self

import numpy as np

from squama import arguments
from squama.beam.design import Beam
from squama.beam.matrixfile import MOTIONS
from squama.curves import both_faces, compliant_figures, compliant_walk, doors, hinge
from squama.curves.bent_twist import Twisted
from squama.curves.chosen import COMPLIANT, MODELS, idealisation, thin
from squama.curves.compliant import STRAIN_LIMIT
from squama.curves.way import Solved, Way
from squama.errors import refuse
from squama.fe import plate
from squama.fe.geometry import geometry
from squama.loads import ENDLESS, LOADS, ending
from squama.model import twisting
from squama.model.outcome import End
from squama.model.paths import ARRAY
from squama.people import over, per_pitch, turned
from squama.scene.geometry import Attitude, Cells, Design, Face, Load
from squama.symbols import OTHER
from squama.types import Array
from squama.units import moment, number, shown

MOST_SCALES = 60
"""Largest number of drawn scales of a beam."""
FREE, SLIDING, LOCKED, ENDED = "free", "sliding", "locked", "ended"
"""States of scales: not in contact; in contact; locked; at an end without a lock."""
ROOM = 1.1
"""Largest load angle that may be entered, over that of the end."""
POINTS = 121
"""Points of a curve on compliant joints; states between them are interpolated."""
_STATE = ("load", "theta", "N", "f", "torque")

_NOT_MOVED = (None,) * 5
"""Pose, other face, strains and deflections of scales on hinges: none."""
SCALED: Face = {"S": [1, 1, 1], "bend": 1, "shift": 0.0}
"""Entries of a design for the scaled face."""


class Setting(NamedTuple):
    """A beam and its load; ``joint`` and ``ideal`` as of :func:`squama.twist`.

    ``bend``: bend held while the beam is twisted, rad per pitch, signed. ``ends`` as of :func:`squama.twist`; with ends
    the curve goes to the load angle ``to`` (rad per pitch), or where that is larger than the limit of the joint's model
    to this limit in any cell.
    """

    beam: Beam
    mu: float
    load: str = "twisting"
    law: str = "edge"
    margin: float = 0.01
    sense: str = "+"
    joint: str | None = None
    ideal: bool | None = None
    bend: float = 0.0
    ends: str | None = ENDLESS
    to: float = math.inf


class State(NamedTuple):
    """A state: load angle per pitch and inclination (rad), normal and friction force (N), slip, name.

    ``slip``: rates along the side edge and along the tip edge; ``x``: force for the length of arrows, N d/K_theta on
    hinges, where N grows without bound, else N over half of the largest along the curve; ``pose`` of scales on
    compliant joints: place of the base (pitches), n_X and n_Y, in the axes of the cross-section; ``other``: state of
    the other face's scales. ``strains`` of the bar per pitch (bend, twist, lateral bend, stretch) where some are free;
    ``bent``: 24 coefficients of the plate's deflection (:func:`squama.scene.geometry.lift`). A beam with ends has the
    ``strains`` of each cell, the largest forces, the mean inclination, and in ``each`` the states of its scales.
    """

    load: float
    theta: float
    N: float
    f: float
    torque: float
    x: float
    slip: tuple[float, float]
    name: str
    pose: list[list[float]] | None = None
    other: State | None = None
    strains: Sequence[float] | Cells | None = None
    bent: Sequence[float] | None = None
    each: list[State] | None = None

    def of(self, i: int) -> State:
        """Return the state of scale number ``i``."""
        return self.each[i] if self.each else self

    @property
    def at(self) -> Load:
        """Strains or load angle, for the functions of the geometry."""
        return self.load if self.strains is None else self.strains

    @property
    def attitude(self) -> Attitude:
        """Attitude of the scales, for the functions of the geometry."""
        return self.theta if self.pose is None else self.pose


class Motion:
    """A beam's curve, and its state at any load.

    ``curve`` (on compliant joints, with states interpolated between its points) and its ``figures``, by their fields in
    :mod:`squama.loads`: ``end``, ``neighbour`` whose contact is followed (0 for none), load angle ``load_e`` at
    engagement (inf for none). ``engaged``: whether part of it is in contact; ``last``: the last drawn load angle, the
    cut-off before a lock or the end; ``most``: the largest that may be entered; ``model`` in words, ``joint`` and
    ``ideal`` as of :func:`squama.twist`, and ``notes`` where the model differs from the chosen one or leaves its range.

    With scales on both faces these belong to the scaled face, and ``other`` is the motion of the other face (computed
    if ``own``); ``last`` and ``end`` are those of the face that ends first. ``graded``: beams of the scales, where they
    differ. ``whole``: both faces are followed
    together, and the curve's torque is that of the beam.

    Raises InputError for a law, margin, sense, friction or joint that is out of range, or for an impossible
    combination.
    """

    graded: Sequence[Beam] = ()

    def __init__(self, setting: Setting, *, own: bool = True) -> None:
        self.setting = setting
        self.kind = arguments.load(setting.load)
        load, law, mu, bend = self.kind.name, setting.law, setting.mu, setting.bend
        sense = setting.sense if self.kind.sided or not own else "+"
        way, one = Way.of(load, [arguments.sense(sense) * math.inf]), None if bend else self.kind
        how = doors.How(mu=mu, law=law, margin=setting.margin, joint=setting.joint, ideal=setting.ideal)
        analysis = doors.analysis(setting.beam, way, one, points=3, **how)
        if own and not bend and setting.beam.pitches <= MOST_SCALES:
            ends = doors.ends_of(analysis, setting.ends)
            if ends != ENDLESS and analysis.joint != COMPLIANT:
                why = "is not drawn on hinges: the view is of an endless beam"
                refuse("ends", shown(ends), why, "leave it out")
            if ends != ENDLESS:
                far = setting.to if setting.to <= STRAIN_LIMIT else math.inf
                way = Way.of(load, [arguments.sense(sense) * far])
            analysis = analysis._replace(ends=ends, way=way)
        self.joint, self.ideal = joint, ideal = analysis.joint, analysis.ideal
        scales = idealisation(setting.beam, joint, ideal=thin(self.kind, law, joint, ideal=ideal))
        self.model = self.kind.model(self.kind.law(law), joint, scales)
        if bend and (load, law) != ("twisting", "edge"):
            refuse("bend", per_pitch(bend), "is held in twisting, by the edge law", "leave it out")
        path: Solved
        notes: Sequence[str]
        if bend:
            how |= {"joint": joint, "ideal": ideal}
            path = twisted = Twisted.of(setting.beam, bend, sense=sense, **how)
            notes = twisted.notes
        else:
            # on hinges with scales on both faces the path of the scaled face alone
            paths, more = MODELS[self.joint].programs().solve(analysis)
            path, notes = paths[0], more.notes
        self.rigidity, self.stiffness = path.case.rigidity, path.case.stiffness
        self.notes = [*filter(None, [analysis.note]), *notes]
        self.hinge = path if isinstance(path, hinge.Path) else None
        found = path.curve(points=3 if self.hinge else POINTS)
        reached = np.isfinite(found.along["torque"])
        self.curve = {role: values[reached] for role, values in found.along.items() if values.dtype.kind == "f"}
        # of each scale of a beam with ends (n, scales)
        self.each = {role: values[reached] for role, values in found.each.items() if values.dtype.kind == "f"}
        self.place = f"{setting.beam.scales} scales {ending(analysis.ends)}" if self.each else "endless beam"
        # forces are drawn where the tip edge meets the side edge
        self.drawn, self.other_drawn = bool(self.hinge), False
        # strains (n, 4) and deflections (n, 24) along the curve, of each face
        self.shapes: list[tuple[Array, Array]] = []
        if isinstance(path, compliant_walk.Loaded):
            self.drawn, self.other_drawn = path.hinged[0], path.hinged[-1]
            self.shapes = path.shapes(self.curve["load"])
            if path.exchanged:
                # the curve lists the face that touches first
                self._exchange()
        self.figures: dict[str, Any] = found.figures
        self.end, self.neighbour = End(str(found.figures["end"])), int(found.figures["neighbour"])
        self.load_e = float(found.figures["load_e"])
        self.last = self.hinge.last if self.hinge else float(self.curve["load"][-1])
        self.own_last, self.own_end = self.last, self.end
        self.engaged = self.hinge.engaged if self.hinge else self.load_e < self.last
        self.whole = f"theta{OTHER}" in {*self.curve, *self.each}
        self.other: Motion | None = self._of_other() if own and self.whole else None
        seen = both_faces.sense(setting.beam, load) if own else 0
        if seen and not self.whole:
            turned = {"+": "-", "-": "+"}[setting.sense] if seen < 0 else setting.sense
            self.other = Motion(setting._replace(sense=turned), own=False)
        if self.other and self.other.last < self.last:
            self.last, self.end = self.other.last, self.other.end
        self.most = ROOM * self.last

    def _exchange(self) -> None:
        """Exchange the variables of the scales of both faces."""
        self.curve, self.each = (compliant_figures.exchanged(v, where=True) for v in (self.curve, self.each))

    def _of_other(self) -> Self:
        """Return the motion of the other face's scales."""
        other = copy(self)
        other._exchange()
        other.shapes, other.drawn = self.shapes[::-1], self.other_drawn
        return other

    def along(self, points: int) -> dict[str, Array]:
        """Return every variable at ``points`` load angles, from no load to the cut-off."""
        if self.hinge:
            return self.hinge.curve(points=points).along
        loads = np.linspace(0.0, self.last, points)
        return {role: np.interp(loads, self.curve["load"], v) for role, v in self.curve.items()}

    def shape(self) -> Design:
        """Return the design for the geometry, see :func:`shape`."""
        beam = self.setting.beam
        flat = thin(self.kind, self.setting.law, self.joint, ideal=self.ideal)
        return shape(self.setting, self.neighbour, 0.0 if flat else beam.scale.thickness / beam.pitch)

    @property
    def verb(self) -> str:
        """What the load does, in a word."""
        return self.kind.verb

    def title(self, name: str) -> str:
        """Return name and model of the beam as text, and whether its elastic scales are drawn flat."""
        flat = not self.hinge and not self.ideal and not self.shapes
        return ": ".join(filter(None, (name, f"{self.model}; {self.place}"))) + ", drawn flat" * flat

    def value(self, role: str, load: float) -> float:
        """Return a variable of the curve at a load angle; NaN where the curve does not have it."""
        loads = self.curve["load"]
        return float(np.interp(min(load, self.last), loads, self.curve[role])) if role in self.curve else np.nan

    def state(self, load: float) -> State:
        """Return the state at a load angle per pitch (rad), or the last state if it is beyond."""
        if self.other is None:
            return self._alone(load)
        own, other = (motion._alone(min(load, self.last)) for motion in (self, self.other))
        if self.whole:
            return own._replace(other=other)
        # each face's torque includes that of the bar
        torque = own.torque + other.torque - self.rigidity * own.load / self.setting.beam.pitch
        return own._replace(torque=torque, other=other)

    def touches(self, load: float) -> bool:
        """Return whether the scales of this face are in contact at a load angle of a first loading."""
        if self.whole:
            # engagement is that of the face that touches first
            return self.pressed(load) if self.each else self.value("N", load) > 0
        return self.engaged and load > self.load_e

    def pressed(self, load: float) -> bool:
        """Return whether scales of a beam with ends press on each other at one of the points beside a load angle."""
        loads = self.curve["load"]
        near = self.each["N"][np.searchsorted(loads, load, "right") - 1 : np.searchsorted(loads, load) + 1]
        return bool((np.nan_to_num(near) > 0).any())

    def _alone(self, load: float) -> State:
        """Return the state of one face."""
        held, touching = load >= self.own_last, self.touches(load)
        name = self._named() if held and (touching or not self.whole) else SLIDING if touching else FREE
        if self.hinge is None:
            return self._between(min(load, self.own_last), name)
        if not touching:
            # a beam that locks at engagement ends there
            return self._straight(min(load, self.own_last), name)
        x = np.array([self.hinge.x_c]) if held else self.hinge.place(np.array([load]))
        return self._states(self.hinge, x, name)[0]

    def words(self, state: State) -> str:
        """Return a state as text: loads, inclination, torque, friction."""
        beam, bend = self.setting.beam, self.setting.bend
        turns = {"bend": bend, "twist": state.load} if bend else {self.kind.verb: state.load}
        load = ", ".join(f"{verb} {turned(v, beam)}" for verb, v in turns.items()) + over(beam)
        torque = f"{self.kind.torque_words} {moment(state.torque)}"
        theta = number(math.degrees(state.theta), "deg")
        return f"{load[0].upper()}{load[1:]}, {torque}, inclination {theta}, µ = {self.setting.mu:g}"

    def samples(self, points: int) -> list[State]:
        """Return states from no load to the last one, denser where the inclination changes fast."""
        if self.hinge and self.other is None:
            load, x = hinge.samples(self.hinge, points)
            states = [self._straight(float(v), FREE) for v in load]
            states += self._states(self.hinge, x, SLIDING) if x.size else []
        else:
            states = [self.state(float(v)) for v in np.linspace(0.0, self.last, points)]
        if self.last == self.own_last and not self.whole:
            states[-1] = states[-1]._replace(name=self._named())
        return states

    def _named(self) -> str:
        """Return the name of the scales' state at the end of their curve."""
        if self.own_end.locks:
            return LOCKED
        if self.own_end is End.NONE:
            return FREE
        return SLIDING if self.own_end is End.RANGE and self.each and self.last >= self.setting.to else ENDED

    def _straight(self, load: float, name: str) -> State:
        beam = self.setting.beam
        return State(load, beam.scale.theta0, 0.0, 0.0, self.rigidity * load / beam.pitch, 0.0, (0.0, 0.0), name)

    def _states(self, path: hinge.Path, x: Array, name: str) -> list[State]:
        """Return states at path parameters x (n,) on hinges."""
        v = hinge.in_si(path.case, [hinge.states(path, np.empty(0), x)])
        force = v["N"] * self.setting.beam.pitch / self.stiffness if self.stiffness else 0 * x
        # sliding rates along the side edge and the tip edge, of a corner along and across the face, per unit of x
        if self.kind.sided:
            with np.errstate(all="ignore"):
                _, root, q, _ = path.row.solve(x, ARRAY)
                c = twisting.contact(root, q, *getattr(path.row, "open", path.row).ratios)
            slip = c.a_rate, c.c_rate
        else:
            at = path.row.point(x + 1e-30j, "edge", ARRAY)
            slip = -at.s.imag, -at.p.imag
        columns = np.stack([*(v[role] for role in _STATE), force, *slip], axis=1)
        return [State._make((*v[:6], (v[6], v[7]), name, *_NOT_MOVED)) for v in columns.tolist()]

    def _between(self, load: float, name: str) -> State:
        """Return a state interpolated on the curve; the slip follows from the coordinates of its contact."""
        if self.each:
            return self._of_each(load, name)
        v = self.curve

        def at(values: Array) -> float:
            return float(np.interp(load, v["load"], values))

        load_, theta, N, f, torque = (at(v[role]) for role in _STATE)
        if "u_X" not in v:
            # on hinges, held bent
            return State(load_, theta, N, f, torque, 0.0, (0.0, 0.0), name)
        s, p = (at(np.nan_to_num(np.gradient(v[role], v["load"]))) for role in ("s", "p"))
        pose = self._pose([at(v[role]) for role in MOTIONS])
        half = float(v["N"].max()) / 2 or 1.0
        state = State(load_, theta, N, f, torque, self.drawn * N / half, (-s, p), name, pose)
        if not self.shapes:
            return state
        strains, bent = ([at(column) for column in values.T] for values in self.shapes[0])
        return state._replace(strains=strains, bent=bent if any(bent) else None)

    def _pose(self, moves: Sequence[float], number: int = 0) -> list[list[float]]:
        """Return place of the base, n_X and n_Y of a scale that has moved (m, rad), see :class:`State`."""
        beam = self.graded[number] if len(self.graded) > 1 else self.setting.beam
        rest = geometry(beam).rest
        c, R = plate.pose(rest, np.array(moves) / ([beam.pitch] * 3 + [1.0] * 3))
        return [row.tolist() for row in (c - rest.base, *(R @ rest.axes[:2].T).T)]

    def _of_each(self, load: float, name: str) -> State:
        """Return the state of a beam with ends between the points of its curve, with that of each scale."""
        loads, v, (cells, bents) = self.curve["load"], self.each, self.shapes[0]
        i = min(max(int(np.searchsorted(loads, load)), 1), loads.size - 1)
        share = (load - loads[i - 1]) / (loads[i] - loads[i - 1])

        def at(values: Array) -> Array:
            return np.asarray((1 - share) * values[i - 1] + share * values[i])

        # the last scale has no neighbour to touch
        N, f = (np.nan_to_num(at(v[role])) for role in ("N", "f"))
        s, p = (at(np.nan_to_num(np.gradient(v[role], loads, axis=0))) for role in ("s", "p"))
        theta, moves, bent = at(v["theta"]), np.array([at(v[role]) for role in MOTIONS]).T, at(bents)
        touching, half = (N > 0) | (np.roll(N, 1) > 0), float(np.nanmax(v["N"])) / 2 or 1.0
        whole = State(load, float(theta.mean()), float(N.max()), float(f.max()), float(at(self.curve["torque"])), 0.0,
                      (0.0, 0.0), name, strains=tuple(map(tuple, at(cells).tolist())))  # fmt: skip
        each = [
            whole._replace(
                theta=float(theta[j]), N=float(N[j]), f=float(f[j]), x=self.drawn * float(N[j]) / half,
                slip=(-float(s[j]), float(p[j])), name=name if touching[j] else FREE, pose=self._pose(moves[j], j),
                strains=None, bent=bent[j].tolist() if bent[j].any() else None,
            )
            for j in range(N.size)
        ]  # fmt: skip
        return whole._replace(each=each)


def shapes(motion: Motion) -> list[tuple[Design, Callable[[State], State]]]:
    """Return the design of each face with scales, the scaled face first, and a selector of its part of a state."""
    design, other = motion.shape(), motion.setting.beam.other
    found: list[tuple[Design, Callable[[State], State]]] = [(design, lambda state: state)]
    if motion.other and other:
        bend, twist, _ = other.seen
        turned: Design = {
            **design, "sense": twist * design["sense"], "bend": bend, "held": bend * design["held"],
            "S": list(other.S), "shift": other.shift, "neighbour": max(1, motion.other.neighbour),
        }  # fmt: skip
        found.append((turned, lambda state: state.other or state))
    return found


def shape(setting: Setting, neighbour: int = 1, thick: float = 0.0) -> Design:
    """Return the design for the geometry: ratios (lengths in pitches, rad), kind of load, sense, law.

    ``thick``: thickness of a scale in pitches, 0 for thin scales.
    """
    beam, kind = setting.beam, LOADS[setting.load]
    return {
        "kind": setting.load,
        "held": setting.bend,
        "eta": beam.eta,
        "beta": beam.beta,
        "lam": beam.lam,
        "height": kind.height(beam.lam, beam.neutral),
        "alpha": beam.scale.alpha,
        "half": beam.substrate.width / 2 / beam.pitch,
        "thick": thick,
        "sense": -1 if setting.sense == "-" and kind.sided else 1,
        "law": kind.law(setting.law),
        "neighbour": max(1, neighbour),
        "scales": min(beam.pitches, MOST_SCALES),
        **SCALED,
    }

r"""The torque or moment of thick, elastic scales on compliant joints at the readings of a test, along its history.

Scales have six motions on the matrix of their joint, are thick and, where their modulus is given, elastic. The torque
depends on the history of the twist, so each trial beam is followed through the record as by :func:`squama.cycle`: the
matrix of its joint scales with the bar's modulus and takes stiffness and rigidity as in a beam file
(:func:`squama.joints.factor.scaled`), so that the fitted beam has the fitted curve. The beam has its number of scales
and its ends, or is endless.

.. math:: T = T_b(\mu, K_\theta, R, E_B) + T_0 + D\,o

with the drift D and the share o of the record up to the point. A loop takes some milliseconds, one of 25 scales half a
second; derivatives are differences of loops. A search needs hundreds of them, so with ends it takes the torque of the
endless beam times the share of the finite beam (:meth:`Walked.shared`).

A part is a beam of N scales on its supports (docs, theory: parts) under one force with an imposed travel, on whose
history the force depends.
"""

from __future__ import annotations

import copy
import functools
import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from squama import arguments
from squama.beam.design import Beam
from squama.contacts import increments, path
from squama.contacts.ties import KINDS
from squama.curves import compliant, compliant_cycles
from squama.errors import InputError, refuse
from squama.identify.hinge_points import Physical
from squama.identify.readings import Readings
from squama.loads import ENDLESS, LOADS, MANY_SCALES, NOTHING, PUSHED, TESTS, Load
from squama.model.outcome import SENTENCES
from squama.part import loaded, loading
from squama.part.definition import Part
from squama.part.loading import texts
from squama.types import Array
from squama.units import Dimension, shown

NODES = 500
"""Largest number of twists of a way that are computed; the torque is interpolated between them."""
_APART = 1e-5
"""Least distance of two of these twists, over the largest twist."""
_KEPT = 16
_STEPS = dict.fromkeys(("mu", "twist_zero", "backlash", "compliance"), 2e-3)
_STEPS |= dict.fromkeys(("stiffness", "rigidity", "modulus"), 1e-3)
_RELATIVE = ("stiffness", "rigidity", "modulus")
_OF_TWIST = ("twist_zero", "compliance")
"""Steps of the differences, for the compliance over the largest torque; ``_RELATIVE``: steps over the value;
``_OF_TWIST``: parameters that may be below 0.
"""
_FAR = 1e3
_SLIGHT = 1e-4
"""A load angle before engagement, rad per pitch."""
_LEAST, _MOST = 1e-3, 20.0
"""Torque over the largest below which no share is taken; largest share, and inverse of the least."""
_ENDS = 'give torque and twist (bend) of its ends, with load="twisting" (--load twisting) or "bending", and ends'


class Walked:
    """Points of a test of scales on compliant joints, whose matrix is that of the beam; ``ends`` as in a beam file."""

    rough = False
    """Whether a search with these points only begins another one."""

    def __init__(self, beam: Beam, load: Load, readings: Readings, v: Physical, ends: str = ENDLESS) -> None:
        self.beam, self.load, self.readings, self.start, self.ends = beam, load, readings, v, ends
        self.index, self.share = np.arange(readings.load.size), np.ones(readings.load.size)
        self._walked = functools.lru_cache(_KEPT)(self._walk)
        self._at(v)

    @property
    def kind(self) -> int | None:
        """The code of the ends of a beam with a number of scales, None for the endless beam."""
        return KINDS.get(self.ends)

    @property
    def finite(self) -> bool:
        """Whether the beam has a number of scales, with ends."""
        return self.kind is not None

    def take(self, index: Array) -> Walked:
        """Return the points ``index`` of these; computed trials are shared."""
        other = copy.copy(self)
        other.index = self.index[index]
        return other

    def of(self, _: int | None) -> Walked:
        """Return the points for a group, the same for all."""
        return self

    def changed(self, **changes: object) -> Walked:
        """Return points with other attributes, without the computed trials."""
        other = copy.copy(self)
        vars(other).update(changes, _walked=functools.lru_cache(_KEPT)(other._walk))
        return other

    def endless(self) -> Walked:
        """Return the points with an endless beam."""
        return self.changed(ends=ENDLESS)

    def shared(self, v: Physical) -> Walked:
        """Return the points with an endless beam whose torques are multiplied by the share of the finite beam at v."""
        endless = self.endless()
        whole = endless._at(v)[0]
        known = np.abs(whole) > _LEAST * np.abs(whole).max()
        share = np.divide(self._at(v)[0], whole, out=np.ones(whole.size), where=known)
        endless.share, endless.rough = np.clip(share, 1 / _MOST, _MOST), True
        return endless

    def touching(self, v: Physical) -> Array:
        """Return whether scales touch, (points,)."""
        return self._at(v)[1][self.index]

    def torque(self, v: Physical) -> Array:
        """Return the torque that the load cell reads (N m)."""
        try:
            torque, _ = self._at(v)
        except InputError:
            # a trial on which the contact ends
            torque, touching = self._at(self.start)
            torque = np.where(touching, _FAR, 1.0) * torque
        return np.asarray((torque + v.drift * self.readings.order)[self.index] + v.torque_zero)

    def whole(self, v: Physical) -> Array:
        """Return the torque at all readings (N m), without zero and drift; refuse a beam that does not follow them."""
        return self._at(v)[0]

    def jacobian(self, v: Physical, wanted: Array) -> Array:
        """Return the derivatives of the torque, shape (n, 10), in the order of :class:`Physical`, where ``wanted``."""
        out = np.zeros((self.index.size, len(Physical._fields)))
        out[:, 4], out[:, 7] = 1.0, self.readings.order[self.index]
        for i, name in enumerate(Physical._fields):
            # in bending the rigidity follows from the bar's modulus
            if wanted[i] and name in _STEPS and (self.load.sided or name != "rigidity"):
                out[:, i] = self._slope(v, name)
        return out

    def _slope(self, v: Physical, name: str) -> Array:
        """Return a derivative by central differences; one-sided at 0, with ends, in a rough search, and at an end."""
        value = getattr(v, name)
        h = _STEPS[name] * (value if name in _RELATIVE else 1.0)
        if name == "compliance":
            h /= float(np.abs(self.readings.torque).max()) or 1.0
        # with ends a loop takes long, and that at the value itself is known
        known = self.finite or self.rough
        ends = [value if known else value - h if name in _OF_TWIST else max(value - h, 0.0), value + h]
        for i, end in enumerate(ends):
            try:
                self._at(v._replace(**{name: end}))
            except InputError:
                ends[i] = value
        low, high = ends
        if low == high:
            return np.zeros(self.index.size)
        up, down = (self.torque(v._replace(**{name: at})) for at in (high, low))
        return np.asarray((up - down) / (high - low))

    def locks_at(self, _: Physical) -> float:
        """Return inf: no lock is known before a trial is computed."""
        return math.inf

    def engaged(self) -> dict[str, float]:
        """Return the load angle per pitch (rad) at engagement, by sense."""
        goals = [-1.0, 1.0] if self.load.sided else [1.0]
        both = compliant_cycles.paths(self.beam, self.load, self.start.mu, goals, ideal=False)
        return {sense: one.way.engaged for sense, one in both.items()}

    def curve(self, v: Physical, x: Array) -> Array:
        """Return the torque (N m) along a history of load angles from rest, without zero and drift."""
        return self._followed(self._trial(v), v.mu, x)[0]

    def bar(self) -> float:
        """Return the slope of the torque before engagement, N m per rad of a pitch; grips prevent bowing."""
        torque, _ = self._followed(self.beam, self.start.mu, np.array([0.0, _SLIGHT]))
        return float(torque[-1] / _SLIGHT)

    def drawn(self, points: int, *, once: bool) -> tuple[Walked, Array]:
        """Return evenly spaced readings along each way for a drawing, and the number of their way."""
        readings, leg = self.readings.drawn(points, once=once)
        share = np.ones(readings.load.size)
        return self.changed(readings=readings, index=np.flatnonzero(leg), share=share), leg[leg > 0]

    def _at(self, v: Physical) -> tuple[Array, Array]:
        """Return torques (N m) without zero and drift, and whether scales touch, at all readings."""
        torque, touching = self._walked(v._replace(theta0=0.0, torque_zero=0.0, drift=0.0))
        return torque * self.share, touching

    def _trial(self, v: Physical) -> Beam:
        """Return the beam with the values of a trial."""
        modulus = self.beam.substrate.youngs_modulus * v.modulus
        values = {"joint.stiffness": v.stiffness, "substrate.youngs_modulus": modulus}
        if self.load.sided:
            values["joint.inclusion_factor"] = v.rigidity / (self.beam.G_B * self.beam.J * v.modulus)
        return self.beam._with({name: float(x) for name, x in values.items()})

    def _followed(self, beam: Beam, mu: float, x: Array) -> tuple[Array, Array]:
        """Return the torque (N m) at load angles from 0 on, and the sum of the forces between scales there."""
        compliant_cycles.check(x.tolist())
        one = compliant.Path.of(beam, float(mu), (self.load.verb,), ideal=False)
        found = compliant_cycles.pressed(one, self.load, x, self.kind)
        torque = compliant_cycles.torque(found, self.load) * beam.unit_moment
        return torque, np.sum([state["N"] for state in found], axis=0)

    def _walk(self, v: Physical) -> tuple[Array, Array]:
        """Return torque and contact of a trial beam along the load angles (rad per pitch) of the specimen."""
        beam, x = self._trial(v), self.readings.placed(v.twist_zero, v.backlash, v.compliance)[0]
        torque, touching = np.zeros(x.size), np.zeros(x.size, bool)
        for ways in self.readings.records:
            nodes = [_nodes(x[way], self.readings.direction[way.start]) for way in ways]
            twists, places = _joined(nodes)
            signed, pressing = self._followed(beam, v.mu, twists)
            for way, at, place in zip(ways, nodes, places, strict=True):
                order = np.argsort(at)
                known, values, force = at[order], signed[place][order], pressing[place][order]
                torque[way] = np.interp(x[way], known, values)
                touching[way] = np.interp(x[way], known, force) > 0
        return torque, touching


class Linear(Walked):
    """Points with a torque linearised about values; ``columns``: known derivatives; ``parts``: those of groups."""

    def __init__(self, own: Walked, v: Physical, columns: dict[str, Array] | None = None) -> None:
        vars(self).update(vars(own))
        self.own, self.about, self.columns = own, v, columns or {}
        self.parts: tuple[Linear, ...] = ()
        self._torque, self._touches = own._at(v)

    def of(self, group: int | None) -> Linear:
        """Return the points for a group."""
        if group is None or not self.parts:
            return self
        part = copy.copy(self.parts[group])
        part.index = self.index
        return part

    def apart(self, values: list[Physical]) -> Linear:
        """Return the points with torques linearised about other values for each group, with the same derivatives."""
        other = copy.copy(self)
        other.parts = tuple(Linear(self.own, v, self.columns) for v in values)
        return other

    def touching(self, _: Physical) -> Array:
        """Return whether scales touch at the values of the linearisation, (points,)."""
        return self._touches[self.index]

    def torque(self, v: Physical) -> Array:
        """Return the torque read (N m); the entries of ``v`` may be columns of many trials, shape (..., 1)."""
        found = self._torque + v.drift * self.readings.order + v.torque_zero
        for name in _STEPS:
            step = getattr(v, name) - getattr(self.about, name)
            if np.any(step):
                found = found + step * self._column(name)
        return np.asarray(found[..., self.index])

    def _slope(self, _: Physical, name: str) -> Array:
        return self._column(name)[self.index]

    def _column(self, name: str) -> Array:
        if name not in self.columns:
            self.columns[name] = self.own._slope(self.about._replace(torque_zero=0.0, drift=0.0), name)
        return self.columns[name]


class Loaded(Walked):
    """Points of a test of a part: travels of the loaded place (m) and forces (N) in place of twists and torques."""

    def __init__(self, part: Part, beam: Beam, readings: Readings, v: Physical) -> None:
        self.part = part
        super().__init__(beam, TESTS[PUSHED], readings, v, self.words)

    @property
    def words(self) -> str:
        """Support and load as text."""
        given, held = loading.together(self.part.load, self.part.support, self.part.beam, self.part.beam.pitches)
        return f"{self.part.support if held.word == 'simple' else held.word}, {given[0].where}"

    @property
    def finite(self) -> bool:
        """True: a part has a number of scales."""
        return True

    def shared(self, v: Physical) -> Walked:
        """Return the points with forces linearised about v, because no endless beam resembles a part."""
        return Linear(self, v)

    def engaged(self) -> dict[str, float]:
        """Return the travel (m) at engagement, by sense."""
        course, _ = self._course(self.beam, self.start.mu)
        ways = {sense: course.follow(np.array([sign * path.RANGE])) for sense, sign in (("-", -1.0), ("+", 1.0))}
        return {sense: track.engaged * course.share * self.beam.pitch for sense, track in ways.items()}

    def straight(self, v: Physical) -> Array:
        """Return the travels (m) at which a linear bar of the first slope has the forces of the given part."""
        placed = {name: getattr(v, name) for name in ("twist_zero", "backlash", "compliance")}
        return self.whole(self.start._replace(**placed)) / self.bar()

    def _course(self, beam: Beam, mu: float) -> tuple[loaded.Course, float]:
        """Return the course of a loaded part, and the unit of its forces, N."""
        n = beam.pitches
        given, held = loading.together(self.part.load, self.part.support, beam, n)
        one = compliant.Path.of(beam, float(mu), (NOTHING,), ideal=False)
        if len(one.held.K) < 9:
            refuse("joint", "", "joint.matrix knows no bend", "squama joint --matrix writes all nine motions")
        unit = one.unit_moment / beam.pitch
        return loaded.course(one.way, n, given, held, (beam.pitch, unit, one.unit_moment)), unit

    def _followed(self, beam: Beam, mu: float, x: Array) -> tuple[Array, Array]:
        """Return the force (N) at travels (m) from 0 on, and the sum of the forces between scales there."""
        course, unit = self._course(beam, mu)
        track = course.follow(x[1:] / (course.share * beam.pitch))
        if track.end.code != increments.RANGE:
            far = 1e3 * float(x[min(len(track.rows), x.size - 1)])
            refuse("travel", "", f"the part is not followed to {far:.4g} mm: {SENTENCES[track.end.word]}")
        pressing = np.sum([path.named(face.rows)["N"].sum(axis=1) for face in track.faces], axis=0)
        return np.append(0.0, course.load(track) * unit), np.append(0.0, pressing)


def of_test(beam: Beam | Part, load: str | Sequence[str] | None, support: str | None) -> tuple[str, Part]:
    """Return the kind of load of a test, and its part, with support and load where a force acts on it."""
    part = beam if isinstance(beam, Part) else Part(beam)
    words = part.load if load is None else load
    if not words or (isinstance(words, str) and not any(map(str.isdigit, words))):
        name = words if isinstance(words, str) and words else next(iter(LOADS))
        if support is not None:
            refuse("support", shown(support), "is of a part under a force", 'give its load too, e.g. "1 N up at tip"')
        _alike(part)
        return arguments.load(name).name, Part(part.beam)
    n = arguments.whole("scales", part.beam.pitches, 2, MANY_SCALES)
    part = replace(part, load=texts(words), support=support or part.support or loading.SUPPORTS[0])
    _alike(part)
    first, *others = loading.together(part.load, part.support, part.beam, n)[0]
    if others:
        refuse("load", shown(others[0].words), "is a second load: a test has one force", "give one")
    if first.measures not in (Dimension.FORCE, Dimension.LENGTH):
        refuse("load", shown(first.words), "is no force", _ENDS)
    return PUSHED, part


def _alike(part: Part) -> None:
    """Refuse scales that differ."""
    if part.along:
        refuse("along", "", "scales that differ along a part are not fitted", "leave it out")


def _nodes(x: Array, sense: float) -> Array:
    """Return the twists of a way at which the model is computed, in their order."""
    found = np.unique(x)
    if found.size > NODES:
        found = np.linspace(found[0], found[-1], NODES)
    apart, kept = _APART * float(np.abs(found).max()), [found[-1]]
    for value in found[-2::-1]:
        if kept[-1] - value > apart:
            kept.append(value)
    return np.array(kept[::-1] if sense > 0 else kept)


def _joined(ways: list[Array]) -> tuple[Array, list[Array]]:
    """Return the twists of a history from rest, with 0 where it passes 0, and the places of each way's twists."""
    found, places = [0.0], []
    for way in ways:
        own = []
        for value in way.tolist():
            if found[-1] * value < 0:
                found.append(0.0)
            if value != found[-1]:
                found.append(value)
            own.append(len(found) - 1)
        places.append(np.array(own))
    return np.array(found), places

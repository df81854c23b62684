"""A test of a part: its support and force, and the force at the travels of the test.

A part is a beam of N scales on its supports (docs, theory: parts) under one force with an imposed travel: the force
depends on the history of the travel, as the torque of a beam does on that of its twist. The fit is otherwise the same
as on compliant joints.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from squama import arguments
from squama.beam.design import Beam
from squama.beam.faces import only_one
from squama.contacts import increments, path
from squama.curves import compliant
from squama.errors import refuse
from squama.identify.hinge_points import Physical
from squama.identify.joint_points import Linear, Walked
from squama.identify.readings import Readings
from squama.loads import LOADS, MANY_SCALES, NOTHING, PUSHED, TESTS
from squama.model.outcome import SENTENCES
from squama.part import loaded, loading
from squama.part.definition import Part
from squama.part.loading import texts
from squama.types import Array
from squama.units import Dimension, shown

_ENDS = 'give torque and twist (bend) of its ends, with load="twisting" (--load twisting) or "bending", and ends'


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
    only_one(part.beam.faces, "a part under load")
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
        pressing = path.named(track.rows)["N"].sum(axis=1)
        return np.append(0.0, course.load(track) * unit), np.append(0.0, pressing)

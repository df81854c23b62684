"""The path of the real beam: bends and twists one after the other, and the curve along one load."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from squama.contacts import increments, path, states
from squama.curves import real, real_figures
from squama.curves.both_faces import WHOSE
from squama.curves.path import FINE, Asked, Case, Curve, States, figures, first_at, spaced
from squama.errors import refuse
from squama.loads import Load
from squama.model.elastic_plate import SIDE_D, TIP
from squama.types import Array

_NEAR, _SAME = 1e-5, 1e-6
"""Distance of stations, rad per pitch, below which one is left out, or put between its neighbours."""
_INNER = ("mode", "onset", "work")
"""Names of variables that no curve tells."""


class Stations(NamedTuple):
    """Points of a path from rest: ways gone (n,), bend and twist per pitch there (n, 2), legs (n,), counted from 1."""

    ways: Array
    strains: Array
    legs: Array

    @classmethod
    def of(cls, points: Sequence[tuple[float, float]], count: int, engaged: float) -> Stations:
        """Return ``count`` points of each leg, one of them at the way ``engaged``."""
        start, parts = 0.0, []
        for i, (a, b) in enumerate(pairwise(np.array([(0.0, 0.0), *points]))):
            length = float(np.hypot(*(b - a)))
            w = np.linspace(0, 1, count)
            if start < engaged < start + length:
                w[1 + np.abs(w[1:-1] * length + start - engaged).argmin()] = (engaged - start) / length
            one = cls(start + w * length, a + w[:, None] * (b - a), np.full(w.size, i + 1))
            parts.append(one if not i else cls(*(v[1:] for v in one)))
            start += length
        return cls(*map(np.concatenate, zip(*parts, strict=True)))

    @classmethod
    def along(cls, load: Load, x: Array, legs: Array | int = 1) -> Stations:
        """Return stations at values of one load from 0 on, the other one imposed as 0 or free."""
        strains = np.zeros((x.size, 2))
        strains[:, load.axis] = x
        return cls(np.cumsum(np.abs(np.diff(x, prepend=0.0))), strains, np.broadcast_to(legs, x.size))

    def corners(self) -> list[tuple[float, int]]:
        """Return way and number of each leg's end."""
        last = np.append(np.flatnonzero(np.diff(self.legs)), self.legs.size - 1)
        return [(float(self.ways[i]), int(self.legs[i])) for i in last]


def direction(load: Load, value: float) -> tuple[float, float]:
    """Return a load's direction in the plane of bend and twist, in the sense of a value."""
    sign = math.copysign(1.0, value)
    return (0.0, sign) if load.axis else (sign, 0.0)


class Loaded(NamedTuple):
    """A beam's path under one load in one sense, see :class:`squama.curves.path.Solved`; ``far`` it goes."""

    one: real.Path
    load: Load
    far: float

    @property
    def case(self) -> Case:
        """What the beam and its joint bring."""
        return self.one.case(self.load)

    @property
    def load_e(self) -> float:
        """Load angle per pitch at the first engagement, inf for none."""
        return self.one.way.engaged

    @property
    def notes(self) -> list[str]:
        """Where the path leaves what the model was compared with."""
        one = self.one
        return real.notes(one.held, one.beam, self.far, ideal=one.way.scale.h == 0)

    @property
    def hinged(self) -> list[bool]:
        """Whether the contact of each face is that of hinges: a tip edge on the side edge that a hinge's comes to."""
        return [self.one.contact(i)[:2] == (TIP, SIDE_D) for i in range(len(self.one.seen))]

    @property
    def exchanged(self) -> bool:
        """Whether what its curve tells of a scale is of the other face: in twisting of that which touches first."""
        return self.load.sided and bool(self.one.lead)

    def curve(self, *, points: int, at: Array | None = None) -> Curve:
        """Return the curve at evenly spaced loads, or at load angles per pitch; NaN beyond an earlier end."""
        if at is not None:
            return self._curve(np.asarray(at, float))
        found = self._curve(spaced(self.far, points, self.load_e))
        cut = float(found.figures["load_end"])
        if math.isfinite(cut) and cut < self.far:
            # as many points up to an earlier end
            ended, found = found.figures, self._curve(spaced(cut * (1 - _NEAR), points, self.load_e))
            found.figures.update({role: ended[role] for role in ("end", "load_end", "rate_end") if role in ended})
        return found

    def _curve(self, at: Array) -> Curve:
        """Return the curve at load angles per pitch; NaN beyond an earlier end."""
        one, engaged, case = self.one, self.load_e, self.case
        sign, turned = sum(one.toward), one.toward[1]
        within = at <= self.far * (1 + 1e-12)
        most = float(at[within].max(initial=0.0))
        fine = np.linspace(0.0, most, max(3, math.ceil(most / FINE) + 1))
        met = np.unique([c.phi for c in one.way.contacts])
        wanted = np.union1d(at[within], met[met < most])
        # no step may be much smaller than the others; loads that are all but equal are put between their neighbours
        bounds = np.concatenate([[-np.inf], wanted, [np.inf]])
        after = np.searchsorted(bounds, fine)
        apart = np.minimum(fine - bounds[after - 1], bounds[after] - fine)
        loads = np.union1d(wanted, fine[apart > _NEAR])
        meets, apart = np.isin(loads, met), np.diff(loads) > _SAME
        kept = np.append(True, apart) | meets
        kept[:-1] &= ~meets[1:] | apart
        answers = one.way.along(Stations.along(self.load, sign * loads[kept]).strains)
        faces, end = [face.rows[0] for face in answers.faces], answers.end()
        if not kept.all():
            faces = [np.column_stack([np.interp(loads, loads[kept], column) for column in rows.T]) for rows in faces]
        v = real_figures.values(one, Stations.along(self.load, sign * loads).strains, *faces, turned=turned)
        own = real_figures.by_load(v, self.load, sign)
        if not self.load.sided:
            before = np.searchsorted(loads[kept], loads, side="right") - 1
            own |= {role: names[before] for role, names in real_figures.touching(answers).items()}
        if self.exchanged:
            own = real_figures.exchanged(own, where=True)
        own |= real_figures.tangents(case.rigidity, case.pitch, met, loads[kept], loads, own)
        reached = np.flatnonzero(np.isfinite(own["torque"]))
        numbers = {role: values for role, values in own.items() if values.dtype.kind == "f"}
        last = {role: float(v[reached[-1]]) if reached.size else math.nan for role, v in numbers.items()}
        found = {
            **figures(case, last, engaged, end.phi, last["theta"]),
            **self._ending(answers),
            **real_figures.thresholds(engaged, one.beam, loads, own),
            "load_bent": self._bent(loads, faces),
        }
        if not self.load.sided:
            found["T_c"] = last["T"]
        if len(faces) > 1:
            found["load_e_other"] = one.way.contacts[1 - one.lead].phi
        which = np.minimum(np.searchsorted(loads, at), loads.size - 1)
        along = {
            role: np.where(within, values[which], np.nan if values.dtype.kind == "f" else "")
            for role, values in own.items()
            if role not in _INNER
        }
        return Curve(along | {"load": at, "rate": at / case.pitch}, found)

    def _bent(self, loads: Array, faces: Sequence[Array]) -> float:
        """Return the load at which a scale is first bent beyond the plate model, by the states of each face, or NaN."""
        scale = self.one.way.scale
        return float(np.fmin.reduce([first_at(loads, states.bent(scale, rows), states.THIN) for rows in faces]))

    def _ending(self, answers: path.Answers) -> dict[str, float | int | str]:
        """Return how a curve ends, what touches first, and what comes in next on a face, by role."""
        one, at, words = self.one, math.nan, ""
        c = one.contact(one.lead)
        (name,) = path.endings(np.array([c], float), answers.ends)
        for i, face in enumerate(answers.faces):
            events = face.events[0, : int(face.ends[0, 2])]
            second = events[(events[:, 0] == increments.ENGAGE) & (events[:, 13] > 1)][:1]
            if second.size and not second[0, 1] >= at:
                (first,), (other,) = path.features(*second[:, 8:11].T)
                met = path.Contact(int(first), int(other), int(second[0, 7]), at := float(second[0, 1]), 0.0, 0.0)
                words = f"{WHOSE * (i != one.lead)}{one.as_twisted(met, i).words} at {at:.4g} rad/pitch"
        return {
            "end": str(name),
            "neighbour": max(0, c.k) if c.first != -1 else 0,
            "other_contact": words,
            "first_contact": c.words,
            "load_second": at,
        }


def solve(asked: Asked) -> tuple[list[Loaded], States]:
    """Return the paths of a beam under one load for each coefficient of friction."""
    beam, load, to = asked.beam, asked.path.load, asked.path.values[-1]
    last = 0.0 if asked.at is None else float(np.max(asked.at, initial=0.0))
    far = min(abs(to), last or (path.RANGE if math.isinf(to) else abs(to)))
    if far >= math.pi:
        what = "to" if far == abs(to) else "at"
        refuse(what, f"{far / beam.pitch:.6g} rad/m", "must be below half a turn per pitch")
    # engagement is told wherever it is, a short curve may end before
    most, toward = max(far, path.RANGE), direction(load, to)
    loaded, ideal = asked.path.loaded, asked.ideal
    ones = [real.Path.of(beam, mu, loaded, ideal=ideal, toward=toward, most=most) for mu in np.atleast_1d(asked.mus)]
    held = ones[0].held
    attrs = real.attributes(held, load.verb) | {"rigidity": ones[0].case(load).rigidity}
    return [Loaded(one, load, far) for one in ones], States({}, attrs, real.notes(held, beam, far, ideal=ideal))

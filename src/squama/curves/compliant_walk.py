"""Thick, elastic scales along a way: a curve under one load, a path of bends and twists, or a plane.

Every contact that comes in is followed (:mod:`squama.contacts`): contacts replace each other, several bear at once,
scales jump. At a corner of a way contacts stick while friction turns, so forces do not jump.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from squama.beam.design import Beam
from squama.contacts import entry, events, increments, path, states
from squama.contacts.system import STRAINS
from squama.contacts.ties import KINDS
from squama.curves import compliant, rows
from squama.curves.both_faces import WHOSE
from squama.curves.compliant_figures import INNER, ROLES, by_load, exchanged, thresholds, touching, values
from squama.curves.curve_figures import FINE, figures, first_at, tangents
from squama.curves.rows import Row, Told
from squama.curves.way import OPEN, SLIDING, VERBS, Analysis, Case, Curve, States, Stations, direction, spaced
from squama.errors import refuse
from squama.loads import ENDLESS, Load
from squama.model.elastic_plate import SIDE_D, TIP
from squama.model.outcome import End
from squama.people import per_pitch
from squama.types import Array

_NEAR, _SAME = 1e-5, 1e-6
"""Distance of stations, rad per pitch, below which a station is not added, or not used for a slope."""


class Loaded(NamedTuple):
    """A beam's path under one load in one sense, see :class:`squama.curves.way.Solved`, up to the angle ``far``.

    ``ends``: its number of scales and their ends; None for an endless beam.
    """

    one: compliant.Path
    load: Load
    far: float
    ends: Row | None = None

    @property
    def case(self) -> Case:
        """Data of the beam and its joint for the load."""
        return self.one.case(self.load)

    @property
    def load_e(self) -> float:
        """Load angle per pitch at the first engagement, inf for none."""
        return self.one.way.engaged

    @property
    def hinged(self) -> list[bool]:
        """Whether the first contact of each face is of the kind on hinges: tip edge on side edge."""
        return [self.one.contact(i)[:2] == (TIP, SIDE_D) for i in range(len(self.one.seen))]

    @property
    def exchanged(self) -> bool:
        """Whether a scale's variables are those of the other face: in twisting those of the face that touches first."""
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
        one, load, case, ends = self.one, self.load, self.case, self.ends
        within, met = at <= self.far * (1 + 1e-12), np.unique([c.phi for c in one.way.contacts])
        loads = _refined(at[within], met)
        told = rows.told(one, load, ends, loads) if ends else self._endless(loads)
        own = told.own
        own |= tangents(case.rigidity, case.pitch, told.met, loads[np.diff(loads, append=np.inf) > _SAME], loads, own)
        reached, engaged = np.flatnonzero(np.isfinite(own["torque"])), float(told.met[0])
        numbers = {role: v for role, v in own.items() if v.dtype.kind == "f"}
        last = {role: float(v[reached[-1]]) if reached.size else math.nan for role, v in numbers.items()}
        found = {
            **figures(case, last, engaged, told.ended, last["theta"]),
            **told.figures,
            **thresholds(engaged, one.beam, loads, own),
            "load_bent": told.bent,
        }
        found = {role: value for role, value in found.items() if not ends or role not in ends.left}
        if not load.sided:
            found["T_c"] = last["T"]
        which = np.minimum(np.searchsorted(loads, at), loads.size - 1)

        def there(v: Array) -> Array:
            out = v[which]
            out[~within] = math.nan if v.dtype.kind == "f" else ""
            return out

        untold = {*INNER, *told.each, *(ends.left if ends else ())}
        along = {role: there(v) for role, v in own.items() if role not in untold}
        along |= {"load": at, "rate": at / case.pitch}
        if ends:
            same = ends.endless.curve(points=3, at=at).along
            along |= {f"{role}_periodic": same[role] for role in ("torque", "theta")}
        return Curve(along, found, {role: there(v) for role, v in told.each.items()}, told.notes)

    def _states(self, loads: Array) -> tuple[Stations, path.Answers]:
        """Return the stations of an endless beam at load angles (n,) from 0 on, and the states there."""
        stations = Stations.along(self.load, sum(self.one.toward) * loads)
        return stations, self.one.way.along(stations.strains)

    def shapes(self, loads: Array) -> list[tuple[Array, Array]]:
        """Return the shape of a beam at load angles (n,) per pitch, as each face with scales sees it.

        Strains (n, 4) bend, twist, lateral bend and stretch per pitch, and 24 powers (n, 24) of the deflection of a
        scale in pitches, see :func:`squama.contacts.path.deflections`; with ends of each of N cells and scales
        (n, N, 4), (n, N, 24).
        """
        if self.ends:
            track = self.ends.track(self.one, self.load, loads)
            strains = track.cells[..., :STRAINS]
            faces = zip(self.one.seen, track.faces, strict=True)
            return [(strains * [*seen, 1], path.deflections(face.rows)) for seen, face in faces]
        rows = [face.rows[0] for face in self._states(loads)[1].faces]
        strains = np.column_stack([path.named(rows[0])[name] for name in ("psi", "twist", "aside", "stretch")])
        return [(strains * [*seen, 1], path.deflections(row)) for seen, row in zip(self.one.seen, rows, strict=True)]

    def _endless(self, loads: Array) -> Told:
        """Return the states of an endless beam at load angles (n,) from 0 on."""
        one, load, sign = self.one, self.load, sum(self.one.toward)
        stations, answers = self._states(loads)
        faces = [face.rows[0] for face in answers.faces]
        own = by_load(values(one, stations.strains, *faces, turned=one.toward[1]), load, sign)
        if not load.sided:
            own |= touching(answers)
        if self.exchanged:
            own = exchanged(own, where=True)
        # load angle at which a scale of either face is bent beyond the plate model
        bent = [first_at(loads, states.bent(one.way.scale, face), states.THIN) for face in faces]
        met, found = np.unique([c.phi for c in one.way.contacts]), _ending(one, answers)
        if len(faces) > 1:
            found["load_e_other"] = one.way.contacts[1 - one.lead].phi
        return Told(own, {}, found, met, float(np.fmin.reduce(bent)), answers.end().phi)


def _refined(at: Array, met: Array) -> Array:
    """Return loads with those of engagement added, and further ones between them at most :data:`FINE` apart."""
    most = float(at.max(initial=0.0))
    wanted = np.union1d(at, met[met < most])
    fine = np.linspace(0.0, most, max(3, math.ceil(most / FINE) + 1))
    bounds = np.concatenate([[-np.inf], wanted, [np.inf]])
    after = np.searchsorted(bounds, fine)
    apart = np.minimum(fine - bounds[after - 1], bounds[after] - fine)
    return np.union1d(wanted, fine[apart > _NEAR])


def _ending(one: compliant.Path, answers: path.Answers) -> dict[str, float | int | str]:
    """Return how a curve ends, the first contact, and the next contact on a face, by role."""
    at, words = math.nan, ""
    c = one.contact(one.lead)
    (name,) = path.endings(np.array([c], float), answers.ends)
    for i, face in enumerate(answers.faces):
        told = face.events[0, : int(face.ends[0, 2])]
        second = told[(told[:, 0] == increments.ENGAGE) & (told[:, 13] > 1)][:1]
        if second.size and not second[0, 1] >= at:
            (first,), (other,) = path.features(*second[:, 8:11].T)
            met = path.Contact(int(first), int(other), int(second[0, 7]), at := float(second[0, 1]), 0.0, 0.0)
            words = f"{WHOSE * (i != one.lead)}{one.as_twisted(met, i).words} at {per_pitch(at)}"
    return {
        "end": str(name),
        "neighbour": max(0, c.k) if c.first != -1 else 0,
        "other_contact": words,
        "first_contact": c.words,
        "load_second": at,
    }


def solve(analysis: Analysis) -> tuple[list[Loaded], States]:
    """Return the paths of a beam under one load for each coefficient of friction."""
    beam, load, to = analysis.beam, analysis.way.load, analysis.way.values[-1]
    last = 0.0 if analysis.at is None else float(np.max(analysis.at, initial=0.0))
    far = min(abs(to), last or (path.RANGE if math.isinf(to) else abs(to)))
    if far >= math.pi:
        what = "to" if far == abs(to) else "at"
        refuse(what, f"{far / beam.pitch:.6g} rad/m", "must be below half a turn per pitch")
    # engagement is reported wherever it is, a short curve may end before
    most, toward = max(far, path.RANGE), direction(load, to)
    loaded, ideal = analysis.way.loaded, analysis.ideal
    ones = [
        compliant.Path.of(beam, mu, loaded, ideal=ideal, toward=toward, most=most) for mu in np.atleast_1d(analysis.mus)
    ]
    held, endless = ones[0].held, [Loaded(one, load, far) for one in ones]
    attrs = compliant.attributes(held, load.verb) | {"rigidity": ones[0].case(load).rigidity}
    more = States({}, attrs, compliant.notes(held, beam, far, ideal=ideal))
    if analysis.ends == ENDLESS:
        return endless, more
    n, kind = beam.pitches, KINDS[analysis.ends]
    rows.check_ends(kind, held, n)
    more = more._replace(notes=[*more.notes, *rows.shifted(beam)])
    # by default a curve ends where a cell reaches the model's limit
    within = compliant.STRAIN_LIMIT * (1 + 1e-9) if analysis.at is None and math.isinf(to) else math.inf
    return [whole._replace(ends=Row(kind, whole, within=within)) for whole in endless], more


def case(beam: Beam, load: Load) -> Case:
    """Return the data of a beam and its joint for a load."""
    return compliant.Path.of(beam, 0.0, (load.verb,), ideal=True).case(load)


def plane(analysis: Analysis, psi: Array, phi: Array) -> States:
    """Return the states at bends and twists (n,), each straight from rest, or the end of the way there."""
    beam, strains = analysis.beam, np.column_stack([psi, phi])
    one = compliant.Path.of(beam, float(analysis.mus), VERBS, ideal=analysis.ideal)
    beams = entry.Beams._make(v.repeat(len(strains), axis=0) for v in one.way.beams)
    corners = np.ascontiguousarray(strains[:, None])
    found = path.follow_all(beams, np.hypot(psi, phi)[:, None], corners=corners, room=path.ROOM)
    contacts, rows = found.contacts, found.rows[:, 0]
    v, column = values(one, strains, rows), path.named(rows)
    state = path.endings(contacts, found.ends).astype("U40")
    reached = np.isin(state, (End.RANGE, End.NONE))
    state[reached] = np.where(column["contacts"][reached] > 0, SLIDING, OPEN)
    first = [events.named(*map(int, met)) if met[0] >= 0 else "" for met in contacts[:, :3]]
    last = np.where(reached, events.last(found), np.array(first))
    kept = ("theta", "N", "M", "M_scales", "T", "T_scales", "W_fr", "W_snap", "U_el", "RED")
    named = {ROLES.get(name, name): v[name] for name in kept}
    named = {"state": state, "contact": np.where(state == OPEN, "", last), **named}
    notes = compliant.notes(one.held, beam, float(np.abs(strains).max()), ideal=analysis.ideal)
    return States({(): named}, compliant.attributes(one.held, *VERBS), notes)

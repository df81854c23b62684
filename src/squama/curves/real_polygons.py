"""Polygons in the plane of bend and twist, of the real beam: states along them in SI units, and events.

Every contact that comes in is followed (:mod:`squama.contacts`): contacts hand over, several bear at once, scales jump.
At a corner of the path contacts stick while friction turns, so forces do not jump.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from squama.contacts import events, increments, path
from squama.contacts.events import Event
from squama.curves import both_faces, real
from squama.curves.path import Asked, States
from squama.curves.real_figures import touching, values
from squama.curves.real_path import Stations
from squama.types import Array

_BEFORE = 1e-9
_INNER = ("mode", "onset", "work")
"""Names of variables that are not told."""
_ROLES = {"phi": "load", "Phi": "rate", "T": "torque", "T_scales": "scales"}


def walk(asked: Asked) -> States:
    """Return the states along a path, its events, and how it ends."""
    corners, beam = asked.path.points, asked.beam
    one = real.Path.of(beam, float(asked.mus), asked.path.loaded, ideal=asked.ideal)
    first = one.way.met(one.way.along(np.array(corners)))
    ways = [c.phi for c in first.contacts]
    # a step from engagement on must not be much smaller than others
    stations = Stations.of(corners, asked.points, min(ways) * (1 - _BEFORE))
    answers = first.along(stations.strains)
    end, n = answers.end(), answers.end().solved
    stop = end.phi if end.code != increments.RANGE else float(stations.ways[-1])
    v = values(one, stations.strains[:n], *(face.rows[0, :n] for face in answers.faces))
    v["leg"] = stations.legs[:n]
    v |= {name: names[:n] for name, names in touching(answers).items()}
    told = []
    for face, at in zip(answers.faces, ways, strict=True):
        # the same place as without stations, to the last digit
        every = [event._replace(way=event.way if j else at) for j, event in enumerate(events.events(face))]
        told.append([event for event in every if event.way <= stop])
    at_way = _Places.of(one, stations, v)
    (word,) = path.endings(np.array([min(first.contacts, key=lambda c: c.phi)], float), answers.ends)
    rubbed = float(v["W_fr"][-1] + v["W_snap"][-1])
    lost = float(v["work"][-1] - v["U_el"][-1]) - rubbed
    figures = {
        "end": str(word), "other_contact": _second(told), "K_theta": one.held.K_theta,
        **{f"{name}_e": value for name, value in at_way(min(ways)).items() if name != "theta"},
        **{f"{name}_end": value for name, value in at_way(stop).items()},
        **{f"{name}_c": v[name][-1] for name in ("T", "M", "W_fr", "RED")},
        "energy_error": lost / max(float(v["U_el"].max()), rubbed, 1e-300),
    }  # fmt: skip
    attrs = real.attributes(one.held, *asked.path.loaded) | {"load": "bending and twisting"}
    single = {k: np.asarray(value) for k, value in figures.items()}
    along = {_ROLES.get(name, name): value for name, value in v.items() if name not in _INNER}
    notes = real.notes(one.held, beam, float(np.abs(stations.strains).max()), ideal=asked.ideal)
    happened = _events(stations, told, (stop, str(word)), at_way)
    return States({("point",): along, ("event",): happened, (): single}, attrs, notes)


def _second(faces: Sequence[Sequence[Event]]) -> str:
    """Return in words which contact comes in first beside another one, and where; nothing where none does."""
    seconds = [(both_faces.WHOSE * i, events.second(told)) for i, told in enumerate(faces)]
    found = [(event.way, of + event.placed) for of, event in seconds if event]
    return min(found, default=(math.nan, ""))[1]


class _Places(NamedTuple):
    """Where ways lead: ``columns`` are bend and twist per pitch and inclination at the first of ``ways``."""

    ways: Array
    columns: Mapping[str, Array]
    pitch: float

    @classmethod
    def of(cls, one: real.Path, stations: Stations, v: Mapping[str, Array]) -> _Places:
        """Return those of a path by its variables; strains that are imposed are known beyond its end."""
        asked = zip(("psi", "phi"), one.held.free, stations.strains.T, strict=False)
        strains = {name: v[name] if free else given for name, free, given in asked}
        return cls(stations.ways, {**strains, "theta": v["theta"]}, one.beam.pitch)

    def __call__(self, way: float) -> dict[str, float]:
        """Return bend and twist per pitch and per length, and inclination; NaN at no way."""
        psi, phi, theta = (
            float(np.interp(way, self.ways[: v.size], v)) if math.isfinite(way) else math.nan
            for v in self.columns.values()
        )
        return {"psi": psi, "phi": phi, "kappa": psi / self.pitch, "Phi": phi / self.pitch, "theta": theta}


def _events(
    stations: Stations, faces: Sequence[Sequence[Event]], end: tuple[float, str], at: _Places
) -> dict[str, Array]:
    """Return what happens on the way, and where: what contacts do, corners, the end."""
    rows: list[tuple[float, str]] = []
    for of, face in zip(("", both_faces.WHOSE), faces, strict=False):
        rows += [(event.way, of + event.word) for event in face]
    rows += [(way, "corner") for way, _ in stations.corners()[:-1]]
    rows = [*sorted([row for row in rows if row[0] < end[0]], key=lambda row: row[0]), end]
    places = [at(way) for way, _ in rows]
    ends = np.array([way for way, _ in stations.corners()])
    legs = 1 + np.searchsorted(ends[:-1], [way * (1 - 1e-12) for way, _ in rows])
    told = {f"{name}_event": np.array([place[name] for place in places]) for name in places[0]}
    return {"event": np.array([word for _, word in rows]), "event_leg": legs, **told}

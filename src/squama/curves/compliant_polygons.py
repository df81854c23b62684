"""Thick, elastic scales along bends and twists in succession: an endless beam, or N scales between free ends.

In a row the mean bend and twist of the cells are imposed, by a moment and a torque that are the same in all cells, or
all cells have the same bend and twist (:mod:`squama.contacts.ties`).
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from squama.contacts import events, increments, path, row, touch
from squama.contacts.row import Track
from squama.contacts.ties import KINDS
from squama.curves import compliant, rows
from squama.curves.both_faces import WHOSE
from squama.curves.compliant_cycles import OF_ROWS
from squama.curves.compliant_figures import INNER, ROLES, touching, values
from squama.curves.curve_figures import PLACES, path_figures, work_error
from squama.curves.way import Analysis, States, Stations
from squama.loads import ENDLESS, LOADS
from squama.model.outcome import End
from squama.symbols import OTHER
from squama.types import Array

_BEFORE = 1e-9
"""Relative distance of a station before engagement: a step from there must not be much smaller."""
_UNKNOWN = math.nan, math.nan


class Happening(NamedTuple):
    """An event at a way: words, bend and twist per pitch (NaN if unknown), scale (from 1; 0: the whole beam)."""

    way: float
    words: str
    strains: tuple[float, float] = _UNKNOWN
    scale: int = 0


class Followed(NamedTuple):
    """A beam along a path: variables (n,) up to its end, by name, those of each scale (n, N), events.

    ``met``: the way at which scales first touch; ``stop`` and ``end``: where and why it ends; ``other``: the contact
    that comes in beside the first ones; ``single``: further values of the whole path.
    """

    along: dict[str, Array]
    happened: list[Happening]
    met: float
    stop: float
    end: str
    other: str
    each: Mapping[str, Array] = {}
    single: Mapping[str, int] = {}
    notes: Sequence[str] = ()


def polygon(analysis: Analysis) -> States:
    """Return the states along bends and twists in succession, the events, and the end."""
    corners, beam = analysis.way.corners, analysis.beam
    one = compliant.Path.of(beam, float(analysis.mus), analysis.way.loaded, ideal=analysis.ideal)
    first = one.way.met(one.way.along(np.array(corners)))
    stations = Stations.of(corners, analysis.points, first.engaged * (1 - _BEFORE))
    found = _endless(one._replace(way=first), stations)
    if analysis.ends != ENDLESS:
        found = _row(analysis, one, stations, found)
    v = found.along | {"leg": stations.legs[: found.along["theta"].size]}
    places = _places(one, stations, v, [found.met, found.stop])
    near, far = ({name: float(at[i]) for name, at in places.items()} for i in (0, 1))
    single = path_figures(v, near, far, found.end, found.other, one.held.K_theta)
    by_dim: dict[tuple[str, ...], dict[str, Array]] = {
        ("point",): _told(v, (*INNER, *found.each)),
        ("event",): _timeline(one, stations, v, found),
        (): single | {"energy_error": np.asarray(work_error(v))} | {k: np.asarray(n) for k, n in found.single.items()},
    }
    attrs = compliant.attributes(one.held, *analysis.way.loaded) | {"load": "bending and twisting"}
    if found.each:
        by_dim["point", "scale"] = _told(found.each, INNER)
        attrs["ends"] = analysis.ends
    most = float(np.abs(stations.strains).max())
    return States(by_dim, attrs, [*compliant.notes(one.held, beam, most, ideal=analysis.ideal), *found.notes])


def _told(v: Mapping[str, Array], left: Sequence[str]) -> dict[str, Array]:
    """Return variables by role, without the names in ``left``."""
    return {ROLES.get(name, name): value for name, value in v.items() if name not in left}


def _endless(one: compliant.Path, stations: Stations) -> Followed:
    """Follow the endless beam, whose first contact is known."""
    engaged = [c.phi for c in one.way.contacts]
    answers = one.way.along(stations.strains)
    end, n = answers.end(), answers.end().solved
    stop = end.phi if end.code != increments.RANGE else float(stations.ways[-1])
    v = values(one, stations.strains[:n], *(face.rows[0, :n] for face in answers.faces))
    v |= {name: names[:n] for name, names in touching(answers).items()}
    happened, seconds = [], []
    for i, (face, at) in enumerate(zip(answers.faces, engaged, strict=True)):
        # engagement as computed without stations, to the last digit
        every = [event._replace(way=event.way if j else at) for j, event in enumerate(events.events(face))]
        told = [event for event in every if event.way <= stop]
        happened += [Happening(event.way, WHOSE * i + event.word, (event.psi, event.phi)) for event in told]
        if second := events.second(told):
            seconds.append((second.way, WHOSE * i + second.placed))
    (word,) = path.endings(np.array([min(one.way.contacts, key=lambda c: c.phi)], float), answers.ends)
    return Followed(v, happened, min(engaged), stop, str(word), min(seconds, default=(math.nan, ""))[1])


def _row(analysis: Analysis, one: compliant.Path, stations: Stations, endless: Followed) -> Followed:
    """Follow all N scales of a beam; the endless beam is given for comparison."""
    n, kind = analysis.beam.pitches, KINDS[analysis.ends]
    rows.check_ends(kind, one.held, n)
    loads = [load for load in LOADS.values() if load.verb in analysis.way.loaded]
    axes = tuple(load.axis for load in loads)
    track = row.track(one.way, n, stations.strains[:, axes], OF_ROWS, ends=kind, load=axes)
    points, other = len(track.rows), track.other()
    along, each = rows.of_scales(one, None, stations.strains[:points], track)
    for suffix, face in zip(("", OTHER), track.faces, strict=False):
        along |= {f"theta{suffix}": each[f"theta{suffix}"].mean(axis=1), f"contact{suffix}": _touching(face)}
    for name in {"T", "M", "theta"} & endless.along.keys():
        beside = along[f"{name}_periodic"] = np.full(points, math.nan)
        v = endless.along[name][:points]
        beside[: v.size] = v
    met, ended = min(track.engaged, endless.met), track.end.code != increments.RANGE
    return Followed(
        along,
        [
            happened._replace(words=WHOSE * i + happened.words)
            for i, face in enumerate(track.faces)
            for happened in _happenings(face)
        ],
        met,
        track.end.phi if ended else float(stations.ways[-1]),
        str(End.NONE if math.isinf(met) and not ended else track.end.word),
        rows.said(other),
        each | rows.cells_of(one, track, kind, *loads),
        {"scale_end": 0 if other is None else other.scale},
        (*rows.beyond(track, float(np.abs(stations.strains).max()), *loads), *rows.shifted(analysis.beam)),
    )


def _name(c: Array) -> str:
    """Return the name of a contact of a row from its columns; "" for none."""
    if c[touch.KIND] == touch.LIES or c[touch.FIRST] < 0:
        return ""
    (first,), (second,) = path.features(c[touch.KIND, None], c[touch.ONE, None], c[touch.OTHER, None])
    return events.named(int(first), int(second), int(c[touch.APART]))


def _touching(track: Track) -> Array:
    """Return the names of the contacts at the states of a row (n,), each once."""
    kinds = track.contacts[..., touch.FIRST : touch.OTHER + 1].astype(int)
    # empty entries are no contact, and a scale that lies on the substrate touches no other scale
    there = (kinds[..., touch.APART] > 0) & (kinds[..., touch.KIND] != touch.LIES)
    kinds[..., touch.FIRST] = 0
    every = {tuple(c) for c in kinds[there].tolist()}
    names = {c: _name(np.array(c)) for c in every}
    at = [{tuple(c) for c in state[here].tolist()} for state, here in zip(kinds, there, strict=True)]
    return np.array([events.TOGETHER.join(sorted(names[c] for c in state)) for state in at], str)


def _happenings(track: Track) -> Iterable[Happening]:
    """Yield the events of the scales of a row."""
    touching: dict[int, list[str]] = {}
    for told in track.events:
        kind, c = int(told[0]), told[6 + touch.FIRST : 6 + touch.OTHER + 1].astype(int)
        name, scale = _name(c), int(c[touch.FIRST]) + 1
        here = touching.setdefault(scale, [])
        if kind in (increments.SNAP, increments.CHANGE) and not name:
            words = "snap" if kind == increments.SNAP else "jump of the scales"
        elif c[touch.KIND] == touch.LIES:
            words = "lies on the substrate" if kind == increments.ENGAGE else "leaves the substrate"
        elif kind == increments.ENGAGE:
            words = f"another contact ({name})" if here else f"engagement ({name})"
            here.append(name)
        elif kind == increments.OPEN:
            here[:] = [other for other in here if other != name]
            words = f"release ({name})" if here else "release"
        elif kind in (increments.SLIDE, increments.STICK):
            words = f"{name} {'sticks' if kind == increments.STICK else 'slides'}"
        else:
            # for several contacts of a scale it is unknown which one has changed
            words = f"{here[0]} to {name}" if len(here) == 1 else f"contact passes to {name}"
            words = f"snap to {name}" if kind == increments.SNAP else words
            here[:] = [name] if len(here) < 2 else [*here, name]
        yield Happening(float(told[1]), words, (float(told[2]), float(told[3])), scale)


def _places(
    one: compliant.Path, stations: Stations, v: Mapping[str, Array], ways: Sequence[float], located: Array | None = None
) -> dict[str, Array]:
    """Return bend and twist per pitch and per length, and inclination, at ways (m,); NaN at an infinite one.

    Free strains and the inclination are interpolated in the path's variables; imposed strains are known beyond its end.
    ``located`` (m, 2): bend and twist of events, NaN where unknown, used for free strains.
    """
    free, d = one.held.free, one.beam.pitch
    imposed = (None if loose else given for loose, given in zip(free, stations.strains.T, strict=False))
    known = [v[name] if given is None else given for name, given in zip(("psi", "phi"), imposed, strict=True)]
    psi, phi, theta = (
        np.where(np.isfinite(ways), np.interp(ways, stations.ways[: at.size], at), np.nan)
        for at in (*known, v["theta"])
    )
    if located is not None:
        both = zip(free, located.T, (psi, phi), strict=False)
        psi, phi = (np.where(np.isnan(own), at, own) if loose else at for loose, own, at in both)
    return dict(zip(PLACES, (psi, phi, psi / d, phi / d, theta), strict=True))


def _timeline(one: compliant.Path, stations: Stations, v: Mapping[str, Array], found: Followed) -> dict[str, Array]:
    """Return the events by name, with their places: changes of contacts, corners, the end."""
    ends = stations.ways[stations.turns[1:-1]].tolist()
    every = [*found.happened, *(Happening(way, "corner") for way in ends)]
    every = sorted([one for one in every if one.way < found.stop], key=lambda one: one.way)
    ways, words, strains, scales = zip(*every, Happening(found.stop, found.end), strict=True)
    legs = 1 + np.searchsorted(ends, [way * (1 - 1e-12) for way in ways])
    places = _places(one, stations, v, list(ways), np.array(strains))
    of_scales = {"event_scale": np.array(scales)} if found.each else {}
    told = {"event": np.array(words), "event_leg": legs, **of_scales}
    return told | {f"{name}_event": at for name, at in places.items()}

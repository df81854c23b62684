"""Polygons in the plane of bend and twist, of the real beam: states along them in SI units, and events.

Every contact that comes in is followed (:mod:`squama.contacts.legs`): contacts hand over, several bear at once, scales
jump. At a corner of the path contacts stick while friction turns, so forces do not jump.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from squama.beam.design import Beam
from squama.beam.joint_law import Free
from squama.beam.matrixfile import MOTIONS
from squama.contacts import events, increments, path, states
from squama.contacts.events import Event
from squama.contacts.legs import Bent, follow_legs
from squama.curves import both_faces, real
from squama.curves.path import Asked, States, in_si
from squama.types import Array

NEUTRAL = {"free": "free", "middle": "held"}
"""Which line keeps its length: none, there being no axial force, or that in the bar's middle; what the stretch is."""
_BEFORE = 1e-9
WALKED = ("mode", "onset")
"""Roles of states that cycles alone need: how the contact moves, and where it last began to slide."""
_OF_BOTH = ("leg", "M", "M_scales", "psi", "kappa")
"""Roles that mean nothing where a beam is bent alone."""
_SEVEN = (
    "the scales are on hinges, not as in the beam: joint.matrix holds six motions and the twist, not the bend; squama "
    "joint --matrix writes all nine, and without it in the file the law of the joint holds them"
)


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

    def corners(self) -> list[tuple[float, int]]:
        """Return way and number of each leg's end."""
        last = np.append(np.flatnonzero(np.diff(self.legs)), self.legs.size - 1)
        return [(float(self.ways[i]), int(self.legs[i])) for i in last]


class Followed(NamedTuple):
    """States at the first stations (E = d = 1, by role) as far as the path goes; way and word of its end.

    ``rows`` are those of each face, ``contacts`` the names of what touches there. ``met`` way and name of the first
    contact of each face, ``events`` what happens on each; ``other`` contact of which another one comes in first, in
    words; ``second`` its way, NaN for none.
    """

    own: dict[str, Array]
    rows: list[Array]
    contacts: list[Array]
    met: list[tuple[float, str]]
    events: list[list[Event]]
    stop: float
    end: str
    other: str = ""
    second: float = math.nan


def impossible(beam: Beam) -> str:
    """Return why a beam's joint is not known in bend and twist; empty where it is."""
    return real.impossible(beam) or unbent(beam)


def unbent(beam: Beam) -> str:
    """Return why a joint's matrix does not know bends; empty where it does, or there is none."""
    return _SEVEN if beam.joint.matrix is not None and len(beam.joint.matrix.K) < 9 else ""


class Gone(NamedTuple):
    """A path that was followed: variables ``along`` the stations as far as it went; ``found``: its states.

    ``touched`` ways at engagement of each face, inf where none; ``notes`` for the reader.
    """

    one: real.Path
    stations: Stations
    found: Followed
    along: dict[str, Array]
    touched: list[float]
    notes: list[str]

    @property
    def engaged(self) -> float:
        """Way at the first engagement."""
        return min(self.touched)

    @property
    def onset(self) -> float:
        """Way from which on stations are in contact: that at engagement lies just before it."""
        return self.engaged * (1 - 2 * _BEFORE)

    @property
    def onsets(self) -> list[float]:
        """Rising ways from which on stations of each face are in contact."""
        return [self.onset, *sorted(self.touched)[1:]]

    def bending(self) -> tuple[dict[str, Array], float]:
        """Return the variables by their roles in bending alone, and the rigidity without contact, N m^2."""
        v = self.along
        own = {role: values for role, values in v.items() if role not in _OF_BOTH}
        own |= {"load": v["psi"], "rate": v["kappa"], "torque": v["M"], "scales": v["M_scales"]}
        own |= {"T": v["torque"], "phi": v["load"]}
        return own, bending_rigidity(self.one.beam, self.one.way)


def go(
    asked: Asked, mu: float, stations: Callable[[float], Stations], ahead: Sequence[tuple[float, float]],
    step: float = path.STEP,
) -> Gone:  # fmt: skip
    """Follow a beam from rest through ``stations``, made for the way just before engagement.

    ``ahead``: corners of the path, or of one that goes on straight beyond its end, on which engagement is looked for.
    ``step``: largest increment of the way.
    """
    beam, plate = asked.beam, real.scale(asked.beam, ideal=asked.ideal)
    held = real.Held.of(beam, *asked.path.loaded)
    way = follow_legs(plate, held.K, mu, np.array(ahead), **held.bar).way
    touched = [c.phi if c.first != -1 else math.inf for c in way.contacts]
    # a step from there on must not be much smaller than others
    where = stations(min(touched) * (1 - _BEFORE))
    far = float(np.abs(where.strains).max())
    one = real.Path(beam, held, way, 1, far)
    found = _followed(one, follow_legs(plate, held.K, mu, where.strains[1:], **held.bar, step=step), where, touched)
    notes = real.notes(held, beam, far, ideal=asked.ideal)
    return Gone(one, where, found, _in_si(one, found, where), touched, notes)


def walk(asked: Asked) -> States:
    """Return the states along a path, its events, and how it ends."""
    corners, beam = asked.path.points, asked.beam
    gone = go(asked, float(asked.mus), lambda engaged: Stations.of(corners, asked.points, engaged), corners)
    stations, found, along = gone.stations, gone.found, gone.along
    at = _Places(stations, along, gone.one.held.free, beam.pitch)
    reached = {name: along[name][-1] for name in ("torque", "M", "W_fr", "RED")}
    rubbed = float(along["W_fr"][-1] + along["W_snap"][-1])
    total, work = float(along["U_el"][-1]) + rubbed, float(along.pop("work")[-1])
    along = {role: values for role, values in along.items() if role not in WALKED}
    figures = {
        "end": found.end, "other_contact": found.other, "K_theta": gone.one.held.K_theta,
        **{f"{name}_e": value for name, value in at(gone.engaged).items() if name != "theta"},
        **{f"{name}_end": value for name, value in at(found.stop).items()},
        **{f"{name}_c": value for name, value in reached.items()},
        "energy_error": (work - total) / max(float(along["U_el"].max()), rubbed, 1e-300),
    }  # fmt: skip
    attrs = real.attributes(gone.one.held, *asked.path.loaded) | {"load": "bending and twisting"}
    single = {k: np.asarray(v) for k, v in figures.items()}
    told = _events(stations, found.events, (found.stop, found.end), at)
    return States({("point",): along, ("event",): told, (): single}, attrs, gone.notes)


def _followed(one: real.Path, found: Bent, stations: Stations, engaged: list[float]) -> Followed:
    """Return the states of a beam whose faces engage at these ways, rest the first of them, and what happens."""
    way, answers, end = one.way, found.answers, found.answers.end()
    n = end.solved + 1
    rest = np.zeros((1, found.rows.shape[1]))
    rest[:, [path.COLUMNS.index(name) for name in ("x", "y")]] = np.nan
    faces = [np.concatenate([rest, face.rows[0]])[:n] for face in answers.faces]
    v = path.named(faces[0])
    own = {name: v[name] for name in ("W_fr", "W_snap", "mode")} | real.bar(one.held, v)
    own["torque"] = v["torque"] * (1 - one.held.free[1]) + 0.0
    own |= {"onset": v["T_slip"], "work": v["W"], "U_el": np.sum([*states.energies(way, *faces).values()], axis=0)}
    stop = end.phi if end.code != increments.RANGE else float(stations.ways[-1])
    met, told, contacts = [], [], []
    for i, (face, rows, at) in enumerate(zip(answers.faces, faces, engaged, strict=True)):
        figures, first = _of_scale(one, face, rows), face.contact()
        own |= both_faces.of_other(figures) if i else figures
        contacts.append(np.append("", events.touching(face))[:n])
        met.append((at, events.named(first.first, first.second, first.k) if first.first >= 0 else ""))
        # the same place as without stations, to the last digit
        every = [event._replace(way=event.way if j else at) for j, event in enumerate(events.events(face))]
        told.append([event for event in every if event.way <= stop])
    (word,) = path.endings(np.array([min(way.contacts, key=lambda c: c.phi)], float), answers.ends)
    seconds = [events.second(of_face) for of_face in told]
    second = min((event.way for event in seconds if event), default=math.nan)
    words = [both_faces.WHOSE * i + event.placed for i, event in enumerate(seconds) if event and event.way == second]
    return Followed(own, faces, contacts, met, told, stop, str(word), "".join(words[:1]), second)


def _of_scale(one: real.Path, found: path.Answers, rows: Array) -> dict[str, Array]:
    """Return the figures of a scale at the states of its face, by role; rest is the first of them."""
    v, n = path.named(rows), len(rows)
    own = {name: v[name] for name in (*MOTIONS, "N", "f", "slip")}
    spots = np.concatenate([np.full((1, 4), np.nan), found.touches[0, :, 0, 6:10]])[:n]
    faced = (v["first"] == path.FACE) | (v["second"] == path.FACE)
    own |= {"p": np.where(faced, spots[:, 1], v["x"]), "s": np.where(faced, spots[:, 2], v["y"])}
    own["theta"] = states.inclinations(one.way, rows)
    return own | states.plate_figures(one.way.scale, path.deflections(rows))


def bending_rigidity(beam: Beam, way: path.Path) -> float:
    """Return the bending rigidity without contact, N m^2."""
    return float(states.bare(way.beams)[0, 1, 1]) * beam.unit_moment * beam.pitch


def _in_si(one: real.Path, found: Followed, stations: Stations) -> dict[str, Array]:
    """Give the states their units, with what the scales add to the bar and what the embedded part bears."""
    beam, column = one.beam, path.named(found.rows[0])
    n = len(found.rows[0])
    told = zip((column["psi"], column["twist"]), one.held.free, stations.strains[:n].T, strict=False)
    psi, phi = (state if free else asked for state, free, asked in told)
    own = {role: values for role, values in found.own.items() if role not in ("M", "psi")}
    v = in_si(one.case, beam.substrate.youngs_modulus, phi, own)
    unit = beam.unit_moment
    bar = unit * states.bare(one.way.beams)[0] @ [phi, psi]
    v |= {"psi": psi, "kappa": psi / beam.pitch, "M": unit * found.own["M"], "leg": stations.legs[:n]}
    v |= {"M_scales": v["M"] - bar[1], "scales": v["torque"] - bar[0]}
    for i, (rows, contact) in enumerate(zip(found.rows, found.contacts, strict=True)):
        figures = {"contact": contact, **real.embedded(one, path.motions(rows, one.seen[i]))}
        v |= both_faces.of_other(figures) if i else figures
    return v


class _Places(NamedTuple):
    """Where ways lead, by name."""

    stations: Stations
    along: dict[str, Array]
    free: Free
    pitch: float

    def __call__(self, way: float) -> dict[str, float]:
        """Return bend and twist per pitch and per length, and inclination; NaN at no way."""
        if not math.isfinite(way):
            return dict.fromkeys(("psi", "phi", "kappa", "Phi", "theta"), math.nan)
        ways, (bends, twists) = self.stations.ways, self.stations.strains.T
        free, own = self.free, self.along
        columns = own["psi"] if free[0] else bends, own["load"] if free[1] else twists, own["theta"]
        psi, phi, theta = (float(np.interp(way, ways[: v.size], v)) for v in columns)
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

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
from squama.beam.joint_law import Free, bare
from squama.beam.matrixfile import MOTIONS
from squama.contacts import events, increments, path, states
from squama.contacts.events import Event
from squama.contacts.legs import Bent, follow_legs
from squama.curves import both_faces, real
from squama.curves.path import Asked, Case, States, in_si
from squama.model.outcome import End
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
    """States at the first stations (E = d = 1, by role), and their contacts; way and word of the end.

    ``q`` (n, 9) are the motions, twist, bend and stretch; ``met`` way and name of the first contact, ``events`` what
    happens; ``other`` contacts of which another one comes in first, in words.
    """

    own: dict[str, Array]
    q: Array
    contact: Array
    met: tuple[float, str]
    events: list[Event]
    stop: float
    end: str
    other: str = ""


def impossible(beam: Beam) -> str:
    """Return why a beam's joint is not known in bend and twist; empty where it is."""
    return real.impossible(beam) or unbent(beam)


def unbent(beam: Beam) -> str:
    """Return why a joint's matrix does not know bends; empty where it does, or there is none."""
    return _SEVEN if beam.joint.matrix is not None and len(beam.joint.matrix.K) < 9 else ""


class Gone(NamedTuple):
    """A path that was followed: variables ``along`` the stations as far as it went; of each face states and engagement.

    ``found``: the states of the beam; ``touched`` ways at engagement, inf where none; ``notes`` for the reader.
    """

    one: real.Path
    stations: Stations
    faces: list[Followed]
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

    def bending(self) -> tuple[dict[str, Array], float]:
        """Return the variables by their roles in bending alone, and the rigidity without contact, N m^2."""
        v, beam = self.along, self.one.beam
        own = {role: values for role, values in v.items() if role not in _OF_BOTH}
        own |= {"load": v["psi"], "rate": v["kappa"], "torque": v["M"], "scales": v["M_scales"]}
        own |= {"T": v["torque"], "phi": v["load"]}
        return own, bending_rigidity(beam, self.one.way)


def go(
    asked: Asked, mu: float, stations: Callable[[float], Stations], ahead: Sequence[tuple[float, float]],
    step: float = path.STEP,
) -> Gone:  # fmt: skip
    """Follow a beam from rest through ``stations``, made for the way just before engagement.

    ``ahead``: corners of the path, or of one that goes on straight beyond its end, on which engagement is looked for.
    ``step``: largest increment of the way.
    """
    beam, plate = asked.beam, real.scale(asked.beam, ideal=asked.ideal)
    held, views = real.Held.of(beam, *asked.path.loaded), both_faces.views(beam)
    firsts = [follow_legs(plate, held.K, mu, np.array(ahead) * view, **held.bar) for view in views]
    met = [r.answers.contact() for r in firsts]
    touched = [c.phi if c.first != -1 else math.inf for c in met]
    # a step from there on must not be much smaller than others
    where = stations(min(touched) * (1 - _BEFORE))
    far = float(np.abs(where.strains).max())
    one = real.Path(beam, held, firsts[0].way, 1, far)
    faces = []
    for i, view in enumerate(views):
        corners = where.strains[1:] * view
        found = _followed(one, follow_legs(plate, held.K, mu, corners, **held.bar, step=step), where, touched[i])
        if found.end == End.NONE and math.isfinite(touched[i]):
            found = found._replace(end=str(End.RANGE))
        faces.append(found._replace(other=both_faces.WHOSE * bool(i and found.other) + found.other))
    whole = _gathered(one, faces, where)
    notes = real.notes(held, beam, far, ideal=asked.ideal)
    return Gone(one, where, faces, whole, _in_si(one, whole, where, faces), touched, notes)


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
    told = _events(stations, gone.faces, (found.stop, found.end), at)
    return States({("point",): along, ("event",): told, (): single}, attrs, gone.notes)


def _followed(one: real.Path, found: Bent, stations: Stations, engaged: float) -> Followed:
    """Return the states of a beam that engages at a way, rest the first of them, and what happens on its way."""
    way, met, end = one.way, found.answers.contact(), found.answers.end()
    n = end.solved + 1
    rest = np.zeros((1, found.rows.shape[1]))
    rest[:, [path.COLUMNS.index(name) for name in ("x", "y")]] = np.nan
    rows = np.concatenate([rest, found.rows])[:n]
    v = path.named(rows)
    own = {name: v[name] for name in (*MOTIONS, "N", "f", "W_fr", "W_snap", "slip", "mode", "torque")}
    own |= real.bar(one.held, v)
    own["torque"] = own["torque"] * (1 - one.held.free[1]) + 0.0
    spots = np.concatenate([np.full((1, 4), np.nan), found.answers.touches[0, :, 0, 6:10]])[:n]
    faced = (v["first"] == path.FACE) | (v["second"] == path.FACE)
    own |= {"p": np.where(faced, spots[:, 1], v["x"]), "s": np.where(faced, spots[:, 2], v["y"])}
    own |= {"onset": v["T_slip"], "work": v["W"], "U_el": np.sum([*states.energies(way, rows).values()], axis=0)}
    own |= {"theta": states.inclinations(way, rows)} | states.plate_figures(way.scale, path.deflections(rows))
    contact = np.append("", events.touching(found.answers))[:n]
    (word,) = path.endings(found.answers.contacts, found.answers.ends)
    told = events.events(found.answers)
    stop = end.phi if end.code != increments.RANGE else float(stations.ways[-1])
    first = engaged, events.named(met.first, met.second, met.k) if met.first >= 0 else ""
    # the same place as without stations, to the last digit
    told = [event._replace(way=event.way if i else engaged) for i, event in enumerate(told) if event.way <= stop]
    second = events.second(told)
    return Followed(own, path.motions(rows), contact, first, told, stop, str(word), second.placed if second else "")


def _gathered(one: real.Path, faces: Sequence[Followed], stations: Stations) -> Followed:
    """Return the states of a beam by those of its faces: sums, else those of the scaled face."""
    first = faces[0]
    if len(faces) == 1:
        return first
    # where both go all the way one that touches nothing says less
    last = min(faces, key=lambda face: (round(face.stop, 9), face.end == End.NONE))
    n = min(len(face.q) for face in faces)
    psi, phi = stations.strains[:n].T
    (bend, twist), (bare_phi, bare_psi) = both_faces.views(one.beam)[1], _once(one)
    a, b = ({role: v[:n] for role, v in face.own.items()} for face in faces)
    bar = (bare_phi * phi**2 + bare_psi * psi**2) / 2
    own = a | {"torque": a["torque"] + twist * b["torque"] - bare_phi * phi}
    own |= {"M": a["M"] + bend * b["M"] - bare_psi * psi}
    own |= {role: a[role] + b[role] for role in ("W_fr", "W_snap")}
    own |= {role: a[role] + b[role] - bar for role in ("U_el", "work")}
    own |= both_faces.of_other(b)
    return Followed(own, first.q[:n], first.contact[:n], first.met, first.events, last.stop, last.end, last.other)


def bending_rigidity(beam: Beam, way: path.Path) -> float:
    """Return the bending rigidity without contact, N m^2, by a path of one face; the bar of two faces counts once."""
    alone = float(states.bare(way.beams)[0, 1, 1]) * beam.unit_moment * beam.pitch
    return 2 * alone - float(bare("bending", beam.sizes)) if beam.other else alone


def _once(one: real.Path) -> tuple[float, float]:
    """Return the stiffness of what both faces share, against twist and bend (E = d = 1): the bar without tabs."""
    beam, held = one.beam, one.held
    twist = (2 * held.alone - held.rigidity) / beam.pitch
    return twist / beam.unit_moment, float(bare("bending", beam.sizes)) / beam.pitch / beam.unit_moment


def _in_si(one: real.Path, found: Followed, stations: Stations, faces: Sequence[Followed]) -> dict[str, Array]:
    """Give the states their units, with what the scales add to the bar and what the embedded part bears."""
    beam, n = one.beam, len(found.q)
    psi, phi = stations.strains[:n].T
    psi, phi = (q if free else v for q, free, v in zip(found.q[:, [7, 6]].T, one.held.free, (psi, phi), strict=False))
    own = {role: values for role, values in found.own.items() if role not in ("M", "psi")}
    v = in_si(Case.held(beam, one.held.K, 1), beam.substrate.youngs_modulus, phi, own)
    unit = beam.unit_moment
    alone = states.bare(one.way.beams)[0]
    if one.beam.other:
        signs = np.array(one.beam.other.seen[::-1])
        alone = alone + alone * np.outer(signs, signs) - np.diag(_once(one))
    bar = unit * alone @ [phi, psi]
    v |= {"psi": psi, "kappa": psi / beam.pitch, "M": unit * found.own["M"], "leg": stations.legs[:n]}
    v |= {"M_scales": v["M"] - bar[1], "scales": v["torque"] - bar[0], "contact": found.contact}
    for face in faces[1:]:
        v |= both_faces.of_other({"contact": face.contact[:n], **real.embedded(one, face.q[:n])})
    return v | real.embedded(one, found.q)


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


def _events(stations: Stations, faces: Sequence[Followed], end: tuple[float, str], at: _Places) -> dict[str, Array]:
    """Return what happens on the way, and where: what contacts do, corners, the end."""
    rows: list[tuple[float, str]] = []
    for of, face in zip(("", both_faces.WHOSE), faces, strict=False):
        rows += [(event.way, of + event.word) for event in face.events]
    rows += [(way, "corner") for way, _ in stations.corners()[:-1]]
    rows = [*sorted([row for row in rows if row[0] < end[0]], key=lambda row: row[0]), end]
    places = [at(way) for way, _ in rows]
    ends = np.array([way for way, _ in stations.corners()])
    legs = 1 + np.searchsorted(ends[:-1], [way * (1 - 1e-12) for way, _ in rows])
    told = {f"{name}_event": np.array([place[name] for place in places]) for name in places[0]}
    return {"event": np.array([word for _, word in rows]), "event_leg": legs, **told}

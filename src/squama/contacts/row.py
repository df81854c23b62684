"""A row of N scales by the contact solver: states of every scale, further contacts, decay of end effects; E = d = 1.

All cells have the same strains, or each has its own, depending on the ends (:mod:`squama.contacts.ties`). Scales touch
their neighbours in any number of contacts, and the substrate where they come to lie on it.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from squama.batch.keeping import tell
from squama.contacts import entry, increments, path, states, touch
from squama.contacts.increments import Legs, Written
from squama.contacts.of_face import of_face
from squama.contacts.system import ENDLESS, EPS, EQUAL, MOTIONS, OWN, PHI, STRAINS, UNTIED, Ties
from squama.contacts.ties import LOOSE, freed, of_ends
from squama.people import per_pitch
from squama.types import Array

_EVENTS, _BEGIN = 16, 2e-4
"""Room for events of each scale; twist behind engagement at which the decay is measured."""


class Other(NamedTuple):
    """A contact of other features than the first ones: scale (from 1), words, twist of its engagement, face."""

    scale: int
    words: str
    phi: float
    face: int = 0


class Track(NamedTuple):
    """Path of a row of n scales; its last point is its end or the last target.

    ``rows`` (points, n, 61) are states of every scale, :data:`squama.contacts.path.COLUMNS`: N, friction and places are
    of its contacts with scales further on (sums, and the first of them), works and loads are means of all scales.
    ``cells`` (points, n, 8): strains of each cell and its loads M, T, B and P, or (points, n, 0) if all have the same
    strains; ``held`` (points, n): moments by which the substrate lifts scales that lie on it; ``loads`` (points, K):
    loads of ties, followed for a floating beam by rotation and place of the near end; ``contacts`` (points, C, 16) and
    ``events`` (E, 25) as in :mod:`squama.contacts.follow`. With scales on both faces all that is of scales, their
    contacts and events are those of the scaled face, and ``opposite`` has those of the other face.
    """

    rows: Array
    cells: Array
    held: Array
    loads: Array
    contacts: Array
    events: Array
    end: path.End
    floating: bool = False
    opposite: Track | None = None

    @property
    def faces(self) -> tuple[Track, ...]:
        """The track of each face with scales."""
        return (self, self.opposite) if self.opposite else (self,)

    @property
    def met(self) -> list[float]:
        """Twist at which scales of each face first touch; inf if they do not."""
        ways = (face.events[face.events[:, 0] == increments.ENGAGE, 1] for face in self.faces)
        return [float(way[0]) if way.size else math.inf for way in ways]

    @property
    def engaged(self) -> float:
        """Twist at which scales of the row first touch; inf if they do not."""
        return min(self.met)

    def other(self) -> Other | None:
        """Return the first contact of other features than the first one of its face; None if there is none."""
        found = [face._other() for face in self.faces]
        (i, first) = min(enumerate(found), key=lambda one: one[1].phi if one[1] else math.inf)
        return first._replace(face=i) if first else None

    def _other(self) -> Other | None:
        """Return the contact of :meth:`other` on one face."""
        what = self.events[:, 6 + touch.FIRST : 6 + touch.OTHER + 1]
        told = np.isin(self.events[:, 0], (increments.ENGAGE, increments.CHANGE, increments.SNAP))
        told &= (what[:, touch.KIND] != touch.LIES) & (what[:, touch.FIRST] >= 0)
        what, ways = what[told].astype(int), self.events[told, 1]
        new = np.flatnonzero((what[:, touch.APART :] != what[:1, touch.APART :]).any(axis=1))
        if not new.size:
            return None
        c, phi = what[new[0]], float(ways[new[0]])
        return Other(int(c[touch.FIRST]) + 1, f"{placed(c)} at {per_pitch(phi)}", phi)


def placed(c: Array) -> str:
    """Return a contact's features, with the numbers of the scales, in words."""
    (one,), (other,) = path.features(c[touch.KIND, None], c[touch.ONE, None], c[touch.OTHER, None])
    met = [(path.FEATURES[f], c[touch.FIRST] + 1 + k) for f, k in ((one, 0), (other, c[touch.APART]))]
    if one == path.FACE:
        met.reverse()
    (what, i), (on, j) = met
    face = "the face" if on == path.FEATURES[path.FACE] else on
    return f"{what} of scale {i} on {face} of scale {j} (k = {c[touch.APART]})"


def legs(at: Array, *loads: int) -> Array:
    """Return strains (n, 4) with values (n,), or (n, K), for K ``loads`` and 0 for the others."""
    strains = np.zeros((len(at), STRAINS))
    strains[:, loads] = np.reshape(at, (len(at), -1))
    return strains


def track(
    way: path.Path,
    scales: int,
    at: Array,
    step: float = path.STEP,
    *,
    ends: int = EQUAL,
    load: int | tuple[int, ...] = PHI,
    within: float = math.inf,
) -> Track:
    """Follow a row through twists (n,) from 0 on, which may go back, to the last one or to its end.

    ``ends``: ENDLESS, EQUAL cells, or LOOSE, COUPLE or GRIPPED ends; twists are the mean of all cells, or the rotation
    of the far end over their number. ``load``: another strain instead of the twist, or several for loose ends, with
    values (n, K). Gripped ends keep their distance if the stretch is held. The path ends before a cell's strain of the
    load exceeds ``within``.
    """
    free, loads = way.beams.free, load if isinstance(load, tuple) else (load,)
    strains = legs(at, *loads)
    if ends in (ENDLESS, EQUAL):
        return tied(way, scales, strains, None, free, step=step, about=ends)
    held, most = of_ends(scales, ends, *loads, apart=free[0, EPS] == 0), increments.ANY.copy()
    most[list(loads)] = within
    return tied(way, scales, strains, held, freed(free, *loads, ends=ends), step=step, within=most)


def tied(
    way: path.Path,
    scales: int,
    strains: Array,
    ties: Ties | None,
    free: Array,
    *,
    step: float = path.STEP,
    about: int = OWN,
    within: Array = increments.ANY,
) -> Track:
    """Follow a row whose cells have strains of their own by ties, or without ties cells of the kind ``about``.

    ``strains`` (n, 4): corners with straight paths between them, from rest; ``free`` (N, 4): whether strains are
    imposed, free or loaded; ``within`` (4,): largest strains of a cell, at which the path ends.
    """
    n, own, held, faces = len(strains), about >= OWN, ties or UNTIED, path.faces(way.beams)
    every = faces * scales
    room = path.ROOM * every
    ways = np.cumsum(np.linalg.norm(np.diff(strains, axis=0, prepend=0.0), axis=1))
    line = increments.LINE + held.course.shape[0] + 6 * held.floating
    sizes = (line,), (every, MOTIONS + (2 * STRAINS + 1) * own), (every, 24)
    states = (np.full((1, n, *size), np.nan) for size in sizes)
    rest = (n, room, increments.CONTACT), (_EVENTS * (every + 4), increments.EVENT), (4,)
    found = Written._make([*states, *(np.zeros((1, *size)) for size in rest)])
    tell(entry.many, "scales in contact")
    legs, none = Legs(ways[None], strains[None], np.zeros(1), step, within), np.zeros((1, 0))
    entry.many(way.beams._replace(free=free), every, about, held, room, legs, found, none, none)
    code, phi, _, solved = found.ends[0].tolist()
    if code == increments.AT_REST:
        # there is only the state at rest
        found.rows[0, 0], found.motions[0, 0], found.bends[0, 0], solved = 0.0, 0.0, 0.0, 1
    found = found._replace(**{name: getattr(found, name)[:, : int(solved)] for name in Written._fields[:4]})
    whole, end = found.rows[0], path.End(int(code), phi, int(solved))
    parts = [_of_face(found, i, faces) for i in range(faces)]
    cells = parts[0].motions[0, ..., MOTIONS : MOTIONS + 2 * STRAINS]
    each = [_states(part.rows[0], part.motions[0], part.bends[0], part.contacts[0], cells) for part in parts]
    _share(way, whole, *(rows for rows, _ in each))
    tracks = [
        Track(rows, cells, lifted, whole[:, increments.LINE :], part.contacts[0], part.events[0], end, held.floating)
        for part, (rows, lifted) in zip(parts, each, strict=True)
    ]
    return tracks[0]._replace(opposite=tracks[1] if faces > 1 else None)


def _of_face(found: Written, face: int, faces: int) -> Written:
    """Return what is written of the scales of one face, numbered along it, without room for more events."""
    part = found._replace(events=found.events[:, : min(int(found.ends[0, 2]), found.events.shape[1])])
    if faces == 1:
        return part
    rows, contacts = of_face(face, part.rows, part.contacts)
    contacts[..., touch.FIRST] //= faces
    # jumps of which no contact is known are told with the scaled face
    scale = part.events[:, :, 6 + touch.FIRST]
    events = part.events[:, np.where(scale[0] < 0, 0, scale[0] % faces) == face]
    events[..., 6 + touch.FIRST] //= faces
    motions, bends = (v[:, :, face::faces] for v in (part.motions, part.bends))
    return Written(rows, motions, bends, contacts, events, part.ends)


def _states(raw: Array, motions: Array, bends: Array, contacts: Array, cells: Array) -> tuple[Array, Array]:
    """Return states of all scales of a face without their energy, and moments of the substrate, see :class:`Track`."""
    points, n = motions.shape[:2]
    rows, held = np.zeros((points, n, path.WIDTH)), np.zeros((points, n))
    column = path.named(rows)
    first = path.COLUMNS.index("u_X")
    rows[:, :, first : first + 6], rows[:, :, len(path.COLUMNS) :] = motions[..., :MOTIONS], bends
    shared = ("phi", "psi", "twist", "aside", "stretch", "M", "torque", "B", "P", "W", "W_fr", "W_snap")
    for at, name in [*enumerate(shared), (13, "mode"), (17, "T_slip"), (20, "T")]:
        # the solver's frictional work and snap losses are sums over all scales
        column[name][...] = raw[:, at, None] / (n if at in (10, 11) else 1)
    column["tilt"][...] = motions[..., MOTIONS + 2 * STRAINS] if cells.size else 0.0
    for name, own in zip(("psi", "twist", "aside", "stretch"), np.moveaxis(cells, -1, 0), strict=False):
        column[name][...] = own
    for name, missing in (("x", np.nan), ("y", np.nan), ("first", -1.0), ("second", -1.0)):
        column[name][...] = missing
    there = np.arange(contacts.shape[1]) < raw[:, 12, None]
    which, c = np.nonzero(there & (contacts[:, :, touch.KIND] != touch.LIES))
    met, scale = contacts[which, c], contacts[which, c, touch.FIRST].astype(int)
    for name, at in (("N", 13), ("f", 14)):
        np.add.at(column[name], (which, scale), met[:, at])
    # for several contacts of a scale the places are those of the first
    places = path.contacted(met)
    for name in ("first", "second", "k", "x", "y", "along"):
        column[name][which[::-1], scale[::-1]] = places[name][::-1]
    which, c = np.nonzero(there & (contacts[:, :, touch.KIND] == touch.LIES))
    held[which, contacts[which, c, touch.FIRST].astype(int)] = contacts[which, c, 10]
    return rows, held


def _share(way: path.Path, raw: Array, *faces: Array) -> None:
    """Write the energy of the cells: of their joints and bar, and of the plates, which the solver adds up."""
    whole = _of_springs(way, *faces)
    for rows in faces:
        energy = path.named(rows)["energy"]
        energy[...] = whole + (raw[:, 19] - whole.sum(axis=1))[:, None] / whole.shape[1]


def _of_springs(way: path.Path, *faces: Array) -> Array:
    """Return the elastic energies (points, n) of joints and bar; each cell may have another beam's joint."""
    points, n, width = faces[0].shape
    if len(way.beams.K) == 1:
        return states.of_springs(way, *(rows.reshape(points * n, width) for rows in faces)).reshape(points, n)
    beams = (way._replace(beams=entry.Beams._make(v[i : i + 1] for v in way.beams)) for i in range(n))
    each = [states.of_springs(one, *(rows[:, i] for rows in faces)) for i, one in enumerate(beams)]
    return np.column_stack(each)


def decay(way: path.Path, ends: int = EQUAL, load: int = PHI, sign: float = 1.0) -> float:
    """Return the factor by which an end's effect decays per contact, at engagement and without friction.

    Contact forces then grow by N' with the same a N'_(i-1) + b N'_i + a N'_(i+1) for all of them, so differences of N'
    decay by r with r + 1/r = -b/a. Grips, which bend the cells near them, are taken as ``LOOSE`` ends. ``sign``: sense
    of the load in which the way's first contact is.
    """
    face, c = min(enumerate([way.contact, *([way.other] if way.other else [])]), key=lambda one: one[1].phi)
    if c.first < 0:
        return math.nan
    shapes = way.beams.shapes.copy()
    shapes[:, 8] = 0.0
    alone = way._replace(beams=way.beams._replace(shapes=shapes))
    at = sign * (c.phi + _BEGIN * np.array([0.5, 1.0]))
    found = track(alone, 6 * c.k, at, _BEGIN, ends=min(ends, LOOSE), load=load)
    if len(found.rows) < 2:
        return math.nan
    force = path.named(found.faces[face].rows)["N"][:, [0, c.k, 2 * c.k]]
    N = 4 * force[0] - force[1]
    both = (N[0] + N[2] - N[1]) / (N[1] - N[0])
    return float((both - math.copysign(math.sqrt(max(0.0, both * both - 4)), both)) / 2)

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
from squama.contacts.system import ENDLESS, EPS, EQUAL, MOTIONS, OWN, PHI, STRAINS, UNTIED, Ties
from squama.contacts.ties import LOOSE, freed, of_ends
from squama.people import per_pitch
from squama.types import Array

_EVENTS, _BEGIN = 16, 2e-4
"""Room for events of each scale; twist behind engagement at which the decay is measured."""


class Other(NamedTuple):
    """A contact of other features than the first ones: scale (from 1), words, twist of its engagement."""

    scale: int
    words: str
    phi: float


class Track(NamedTuple):
    """Path of a row of n scales; its last point is its end or the last target.

    ``rows`` (points, n, 60) are states of every scale, :data:`squama.contacts.path.COLUMNS`: N, friction and places are
    of its contacts with scales further on (sums, and the first of them), works and loads are means of all scales.
    ``cells`` (points, n, 8): strains of each cell and its loads M, T, B and P, or (points, n, 0) if all have the same
    strains; ``held`` (points, n): moments by which the substrate lifts scales that lie on it; ``loads`` (points, K):
    loads of ties, followed for a floating beam by rotation and place of the near end; ``contacts`` (points, C, 16) and
    ``events`` (E, 25) as in :mod:`squama.contacts.follow`.
    """

    rows: Array
    cells: Array
    held: Array
    loads: Array
    contacts: Array
    events: Array
    end: path.End
    floating: bool = False

    @property
    def engaged(self) -> float:
        """Twist at which scales of the row first touch; inf if they do not."""
        met = np.flatnonzero(self.events[:, 0] == increments.ENGAGE)
        return float(self.events[met[0], 1]) if met.size else math.inf

    def other(self) -> Other | None:
        """Return the first contact of other features; None if there is none."""
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
    n, room, own, held = len(strains), path.ROOM * scales, about == OWN, ties or UNTIED
    ways = np.cumsum(np.linalg.norm(np.diff(strains, axis=0, prepend=0.0), axis=1))
    line = increments.LINE + held.course.shape[0] + 6 * held.floating
    sizes = (line,), (scales, MOTIONS + 2 * STRAINS * own), (scales, 24)
    states = (np.full((1, n, *size), np.nan) for size in sizes)
    rest = (n, room, increments.CONTACT), (_EVENTS * (scales + 4), increments.EVENT), (4,)
    found = Written._make([*states, *(np.zeros((1, *size)) for size in rest)])
    tell(entry.many, "scales in contact")
    legs, none = Legs(ways[None], strains[None], np.zeros(1), step, within), np.zeros((1, 0))
    entry.many(way.beams._replace(free=free), scales, about, held, room, legs, found, none, none)
    (raw,), (motions,), (bends,), (contacts,), (events,), (ended,) = found
    code, phi, told, solved = ended.tolist()
    if code == increments.AT_REST:
        # there is only the state at rest
        raw[0], motions[0], bends[0], solved = 0.0, 0.0, 0.0, 1
    raw, motions, bends, contacts = (v[: int(solved)] for v in (raw, motions, bends, contacts))
    cells, end = motions[..., MOTIONS:], path.End(int(code), phi, int(solved))
    rows, lifted = _states(way, raw, motions[..., :MOTIONS], bends, contacts, cells)
    events = events[: min(int(told), len(events))]
    return Track(rows, cells, lifted, raw[:, increments.LINE :], contacts, events, end, held.floating)


def _states(
    way: path.Path, raw: Array, motions: Array, bends: Array, contacts: Array, cells: Array
) -> tuple[Array, Array]:
    """Return states of all scales, and moments of the substrate, see :class:`Track`."""
    points, n = motions.shape[:2]
    rows, held = np.zeros((points, n, path.WIDTH)), np.zeros((points, n))
    column = path.named(rows)
    first = path.COLUMNS.index("u_X")
    rows[:, :, first : first + 6], rows[:, :, len(path.COLUMNS) :] = motions, bends
    shared = ("phi", "psi", "twist", "aside", "stretch", "M", "torque", "B", "P", "W", "W_fr", "W_snap")
    for at, name in [*enumerate(shared), (13, "mode"), (17, "T_slip"), (20, "T")]:
        # the solver's frictional work and snap losses are sums over all scales
        column[name][...] = raw[:, at, None] / (n if at in (10, 11) else 1)
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
    # the solver returns the energy of joints and plates for all scales together
    whole = _of_springs(way, rows)
    column["energy"][...] = whole + (raw[:, 19] - whole.sum(axis=1))[:, None] / n
    return rows, held


def _of_springs(way: path.Path, rows: Array) -> Array:
    """Return the elastic energies (points, n) of joints and bar; each scale may have another beam's joint."""
    points, n = rows.shape[:2]
    if len(way.beams.K) == 1:
        return states.of_springs(way, rows.reshape(points * n, rows.shape[2])).reshape(points, n)
    beams = (entry.Beams._make(v[i : i + 1] for v in way.beams) for i in range(n))
    return np.column_stack([states.of_springs(way._replace(beams=one), rows[:, i]) for i, one in enumerate(beams)])


def decay(way: path.Path, ends: int = EQUAL, load: int = PHI) -> float:
    """Return the factor by which an end's effect decays per contact, at engagement and without friction.

    Contact forces then grow by N' with the same a N'_(i-1) + b N'_i + a N'_(i+1) for all of them, so differences of N'
    decay by r with r + 1/r = -b/a. Grips, which bend the cells near them, are taken as ``LOOSE`` ends.
    """
    c = way.contact
    if c.first < 0:
        return math.nan
    shapes = way.beams.shapes.copy()
    shapes[:, 8] = 0.0
    alone = way._replace(beams=way.beams._replace(shapes=shapes))
    loads = min(ends, LOOSE)
    found = track(alone, 6 * c.k, c.phi + _BEGIN * np.array([0.5, 1.0]), _BEGIN, ends=loads, load=load)
    if len(found.rows) < 2:
        return math.nan
    force = path.named(found.rows)["N"][:, [0, c.k, 2 * c.k]]
    N = 4 * force[0] - force[1]
    both = (N[0] + N[2] - N[1]) / (N[1] - N[0])
    return float((both - math.copysign(math.sqrt(max(0.0, both * both - 4)), both)) / 2)

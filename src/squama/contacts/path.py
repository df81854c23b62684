"""Load paths of many endless beams by the contact solver: first contacts and states; E = d = 1.

Twists are magnitudes: the other sense is the mirror image, alpha -> -alpha.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple, TypedDict, Unpack

import numpy as np
from numpy.typing import NDArray

from squama.batch.keeping import tell
from squama.contacts import entry, increments, touch
from squama.contacts.increments import Legs, Written
from squama.contacts.of_face import events_of, of_face
from squama.contacts.system import ENDLESS, PHI, PSI, STRAINS, UNTIED
from squama.joints.factor import MIRROR
from squama.model import elastic_plate as plate
from squama.model.outcome import End as Outcome
from squama.types import Array

RANGE = 0.3
"""Default twist per pitch, rad, at which a curve ends, and up to which first contacts are searched."""
STEP = 4e-3
"""Largest increment, rad per pitch; a quarter of it changes a torque by about 1e-5."""
ROOM, EVENTS = 8, 64
"""Room for simultaneous contacts, and for events of a path."""
FREE, SLIP, STICK = range(3)
"""Modes of a state: no contact, sliding, sticking."""
FACE, CORNERS = 4, 5
"""Number of a face, and of the first of the corners C, B (tip), D, A (base), after those of the edges."""
COLUMNS = (
    "phi", "T", "N", "f", "x", "y", "W_fr", "W", "mode", "u_X", "u_Y", "u_Z", "w_X", "w_Y", "w_Z", "T_slip", "slip",
    "psi", "twist", "aside", "stretch", "M", "torque", "B", "P", "W_snap", "contacts", "first", "second", "k", "along",
    "since", "energy", "F_x", "F_y", "F_z", "tilt",
)  # fmt: skip
"""Columns of a state: ``phi`` the way along the path (the twist in pure twisting), ``T`` the work per way; sums of N
and friction over the contacts; for the first contact its places ``x``, ``y``, ``along``, its features (-1: none), and
its force on the first scale in that scale's axes at rest; ``T_slip``: T where a contact last began to slide, or the
path turned; ``slip``: the length along which the first contact has slid; ``since``: the way at which the contacts last
changed; ``tilt``: of a scale of a row, else 0.
"""
TILTED = [2, 3, 4]
"""Motions of a scale that are part of its tilt: u_Z, w_X, w_Y."""
WIDTH = len(COLUMNS) + 24
"""Columns of a state, including the 24 coefficients of the plate's deflection."""
EDGES = ("tip edge", "side edge", "side edge", "base edge")
FEATURES = (*EDGES, "face", *(f"corner {letter}" for letter in "CBDA"))
"""Features of a contact in words, by number."""
MIRRORED = (plate.TIP, plate.SIDE_A, plate.SIDE_D, plate.BASE, FACE, *(CORNERS + c for c in (1, 0, 3, 2)))
"""Numbers of the features in the mirror image."""
WORDS = np.array([
    Outcome.RANGE, Outcome.STOPPED, Outcome.SIDE, Outcome.TOUCHING, Outcome.STOPPED, Outcome.JOINT, Outcome.NONE,
], str)  # fmt: skip
"""Ends in words: those of the compiled solver by number, then that of a path without contact."""
_LOADS = [COLUMNS.index(name) for name in ("T", "T_slip")]


Free = tuple[int, int, int, int]
"""Flags of the free strains bend, twist, lateral bend and stretch: 1, else 0."""
HELD, STRETCHING = (0, 0, 0, 0), (0, 0, 0, 1)
"""Flags for all strains imposed; and for a free stretch alone."""


class Scale(NamedTuple):
    """A scale: lengths in pitches, angles in rad; ``D`` bending stiffness (E d^3, inf for rigid), Poisson's ratio.

    Floats, or arrays (n,) of many scales.
    """

    eta: float | Array
    beta: float | Array
    lam: float | Array
    alpha: float | Array
    theta0: float | Array
    h: float | Array
    D: float | Array = math.inf
    nu: float | Array = 0.3

    @property
    def elastic(self) -> np.bool | NDArray[np.bool]:
        """Whether the scale bends, or which of many scales do."""
        return np.isfinite(self.D)


class Bar(TypedDict, total=False):
    """Arguments that describe the bar, see :func:`beams`."""

    free: Free
    aside: float
    masked: Sequence[float]
    seen: Sequence[float]
    own: Sequence[float]
    tilt: Sequence[float]


class Contact(NamedTuple):
    """First contact: features of scale 1 and of scale 1 + k, twist (rad per pitch) and places.

    ``first`` is -1 without contact, -2 if plates touch at rest.
    """

    first: int
    second: int
    k: int
    phi: float
    x: float
    y: float

    @property
    def words(self) -> str:
        """The pair of features in words."""
        found = f"{FEATURES[self.first]} on {FEATURES[self.second]} (k = {self.k})"
        return "" if self.first < 0 else found

    @property
    def mirrored(self) -> Contact:
        """The contact in the mirror image, where the sides of a scale are exchanged."""
        return self._replace(first=MIRRORED[self.first], second=MIRRORED[self.second]) if self.first >= 0 else self


def features(kind: Array, one: Array, other: Array) -> tuple[Array, Array]:
    """Return the features of contacts, by number, from their kind and their edges or corners."""
    one, other = np.where(kind == touch.VF, CORNERS + one, one), np.where(kind == touch.FV, CORNERS + other, other)
    first = np.where((kind == touch.FV) | (kind == touch.FE), FACE, one)
    return first, np.where((kind == touch.VF) | (kind == touch.EF), FACE, other)


class End(NamedTuple):
    """End of a path: number, way, and number of targets reached."""

    code: int
    phi: float
    solved: int

    @property
    def word(self) -> Outcome:
        """The end in words."""
        return Outcome(str(WORDS[self.code]))


class Answers(NamedTuple):
    """Results of n beams on paths of m targets: first contacts (n, 6), rows (n, m, 61), events (n, 64, 25), ends.

    ``ends`` is (n, 4). Rows are :data:`COLUMNS` and the 24 coefficients of the plate's deflection; NaN beyond the end.
    ``touches`` (n, m, C, 16): all contacts, see :func:`squama.contacts.written.write`. With scales on both faces the
    data of a scale, of contacts and of events are those of the scaled face, and ``other`` has those of the other face.
    """

    contacts: Array
    rows: Array
    events: Array
    ends: Array
    touches: Array
    other: Answers | None = None

    @property
    def faces(self) -> tuple[Answers, ...]:
        """The results for each face with scales."""
        return (self, self.other) if self.other else (self,)

    def contact(self, i: int = 0) -> Contact:
        """Return the first contact of beam i."""
        return Contact(*(int(v) for v in self.contacts[i, :3]), *self.contacts[i, 3:].tolist())

    def end(self, i: int = 0) -> End:
        """Return the end of beam i's path."""
        code, phi, _, solved = self.ends[i].tolist()
        return End(int(code), phi, int(solved))


def beams(
    scale: Scale, K: Array, mu: Array, *, sense: int = 1, free: Free = HELD, aside: Array | float = 1.0,
    masked: Sequence[float] = (), seen: Sequence[float] = (), own: Sequence[float] | Array = (),
    tilt: Sequence[float] | Array = (0.0, 0.0, 0.0),
) -> entry.Beams:  # fmt: skip
    """Return beams for the compiled solver: a scale of arrays (n,), K (n, 9, 9), or (n, 7, 7) without bend and stretch.

    ``mu`` (n,); ``sense``: -1 for the mirror image; ``free``: 1 for each of the strains bend, twist, lateral bend and
    stretch without moment or force; ``aside`` (n,): stiffness of the bar against lateral bend over that against bend;
    ``masked``: 1 for each of the six motions that is blocked, as on hinges, or empty. With scales on both faces
    ``seen`` are the signs with which the other face sees bend, twist and lateral bend, and ``own`` is the bar's own
    stiffness against the four strains, (4,) or (n, 4), included in the matrices of both faces. ``tilt``: motion of the
    scales of a row per unit of their tilt, (3,) or (n, 3), see :mod:`squama.joints.tilt`.
    """
    motions = K.shape[-1]
    signs = MIRROR[:motions] if sense < 0 else np.ones(motions)
    alpha, theta0 = sense * scale.alpha, scale.theta0
    shapes = np.column_stack([
        scale.eta, scale.beta, scale.lam, np.sin(alpha), np.cos(alpha), np.sin(theta0), np.cos(theta0), scale.h, mu,
    ])  # fmt: skip
    elastic, n = np.isfinite(scale.D), len(K)
    plates = np.zeros((n, 24, 24), shapes.dtype)
    if elastic.any():
        made = plate.compliances(*(np.asarray(v)[elastic] for v in (scale.eta, scale.beta, scale.nu)))
        plates[elastic] = made / np.asarray(scale.D)[elastic].reshape(-1, 1, 1)
    loose = np.tile(np.array(free, float) * (motions == 9), (n, 1))
    K = np.ascontiguousarray(K * np.outer(signs, signs))
    aside = np.broadcast_to(np.asarray(aside, K.dtype), n).copy()
    blocked, other = (np.tile(np.asarray(v, float), (n, 1)) for v in (masked, seen))
    bar = np.broadcast_to(np.asarray(own, K.dtype), (n, np.shape(own)[-1])).copy()
    tilts = np.broadcast_to(np.asarray(tilt, K.dtype) * MIRROR[TILTED] ** (sense < 0), (n, 3)).copy()
    return entry.Beams(shapes, K, elastic, plates, loose, aside, blocked, other, bar, np.full(n, entry.GRIP), tilts)


def follow_all(
    beams: entry.Beams, targets: Array, *, most: float | Array | None = None, step: float = STEP,
    corners: Array | None = None, room: int = 1,
) -> Answers:  # fmt: skip
    """Follow beams to targets (n, m); first contacts are searched below the twists ``most``.

    Without ``corners`` the targets are twists, which may go back. With ``corners`` (n, m, 2), bends and twists, the
    targets are the ways there, straight between corners and on to ``most``. ``most`` defaults to 1, with corners to the
    last target. Without targets one corner (n, 1, 2) is the direction of the search. ``room``: number of contacts
    returned for each state; all with scales on both faces.
    """
    legs = on_legs(targets, corners, most, step)
    found = unwritten(legs.ways, room, faces(beams))
    follow(beams, legs, found)
    return read(found, None if corners is not None else targets)


def faces(beams: entry.Beams) -> int:
    """Return the number of faces with scales."""
    return 1 + bool(beams.seen.shape[1])


def follow(
    beams: entry.Beams, legs: Legs, found: Written, notes: Array | None = None, snapshots: Array | None = None
) -> None:
    """Follow endless beams (n) and write the results to ``found``; increments into ``notes`` (n, size), if given.

    ``snapshots`` (n, size): starting states, replaced by the final ones; from rest if not given.
    """
    none, many = np.zeros((len(legs.ways), 0)), faces(beams)
    kept = (none if given is None else given for given in (notes, snapshots))
    tell(entry.many, "scales in contact")
    entry.many(beams, many, ENDLESS, UNTIED, many * ROOM, legs, found, *kept)


def on_legs(targets: Array, corners: Array | None, most: float | Array | None, step: float) -> Legs:
    """Return the legs to targets (n, m), see :func:`follow_all`.

    Without targets the strains (n, 1, 4) are the direction of the search.
    """
    n, m = targets.shape
    strains = np.zeros((n, max(m, 1), STRAINS), targets.dtype)
    if corners is None:
        strains[..., PHI] = targets if m else 1.0
        steps = np.diff(targets, axis=1, prepend=0.0)
        # contiguous, because code is compiled for each layout
        ways = np.ascontiguousarray(np.cumsum(np.where(np.real(steps) < 0, -steps, steps), axis=1))
        # (a path that goes back is longer than its last twist)
        most = 1.0 if most is None else most
    else:
        strains[..., [PSI, PHI]], ways = corners, np.ascontiguousarray(targets)
        most = 0.0 if most is None else most
    last = np.real(ways[:, -1]) if m else 0.0
    return Legs(ways, strains, np.maximum(np.broadcast_to(np.asarray(most, float), n), last), step)


def unwritten(ways: Array, contacts: int, faces: int = 1) -> Written:
    """Return output arrays at ways (n, m) with room for ``contacts`` per state; for two faces with room for all."""
    (n, m), kind = ways.shape, ways.dtype
    contacts = faces * (ROOM if faces > 1 else contacts)
    events = n, faces * EVENTS, increments.EVENT + (faces - 1) * ROOM
    sizes = (increments.LINE,), (faces, 6), (faces, 24)
    states = (np.full((n, m, *size), np.nan, kind) for size in sizes)
    touches = np.zeros((n, m, contacts, increments.CONTACT), kind)
    return Written._make([*states, touches, np.zeros(events, kind), np.zeros((n, 4))])


def read(found: Written, targets: Array | None = None) -> Answers:
    """Return the output as results of each face; where twists ``targets`` go back, work per way becomes torque."""
    states = found.rows, found.contacts
    if found.motions.shape[2] == 1:
        answers = _answers(*states, found.motions[:, :, 0], found.bends[:, :, 0], found.events, found.ends)
    else:
        one, other = (
            _answers(*of_face(i, *states), found.motions[:, :, i], found.bends[:, :, i], *events_of(i, *found[4:]))
            for i in range(2)
        )
        answers = one._replace(other=other)
    if targets is not None and (back := np.diff(np.real(targets), axis=1, prepend=0.0) < 0).any():
        for face in answers.faces:
            face.rows[..., _LOADS] *= np.where(back, -1.0, 1.0)[..., None]
    return answers


def _answers(raw: Array, touches: Array, motions: Array, bends: Array, events: Array, ends: Array) -> Answers:
    """Return the results for one face."""
    return Answers(_first(events, ends), _rows(raw, motions, bends, touches), events, ends, touches)


def _first(events: Array, ends: Array) -> Array:
    """Return the first contacts (n, 6) of paths from their events."""
    met = (np.real(events[:, :, 0]) == increments.ENGAGE) & (np.arange(events.shape[1]) < ends[:, 2, None])
    first = events[np.arange(len(events)), met.argmax(axis=1)]
    one, other = features(*np.real(first[:, 8:11]).T)
    out = np.column_stack([one, other, first[:, 7], first[:, 1], first[:, 14:16]])
    out[~met.any(axis=1)] = (-1, -1, 0, np.inf, np.nan, np.nan)
    out[ends[:, 0] == increments.AT_REST] = (-2, -1, 0, 0.0, 0.0, 0.0)
    return out


def _rows(raw: Array, motions: Array, bends: Array, touches: Array) -> Array:
    """Return rows of :data:`COLUMNS` and deflections from the compiled solver's output."""
    out = np.empty((*raw.shape[:2], WIDTH), raw.dtype)
    column = {name: out[..., i] for i, name in enumerate(COLUMNS)}
    told = ("way", "psi", "twist", "aside", "stretch", "M", "torque", "B", "P", "W", "W_fr", "W_snap", "contacts",
            "mode", "N", "f", "slip", "T_slip", "since", "energy", "T")  # fmt: skip
    for i, name in enumerate(told):
        column.get(name, column["phi"])[...] = raw[..., i]
    out[..., COLUMNS.index("u_X") : COLUMNS.index("w_Z") + 1], out[..., len(COLUMNS) :] = (
        motions,
        bends,
    )
    out[..., COLUMNS.index("tilt")] = 0.0
    first, there = touches[:, :, 0], np.real(raw[..., 12]) > 0
    absent = {"first": -1, "second": -1, "k": 1, "x": np.nan, "y": np.nan, "along": 0.0}
    for name, met in contacted(first).items():
        column[name][...] = np.where(there, met, absent[name])
    for i, name in enumerate(("F_x", "F_y", "F_z")):
        column[name][...] = np.where(there, first[..., 10 + i], 0.0)
    return out


def contacted(touches: Array) -> dict[str, Array]:
    """Return columns of states from their contacts (.., 16), by name: features and places."""
    _, apart, kind, one, other = np.moveaxis(np.real(touches[..., :5]), -1, 0)
    one, other = features(kind, one, other)
    edges, (x1, y1, x2, y2) = kind == touch.EE, np.moveaxis(touches[..., 6:10], -1, 0)
    return {
        "first": one, "second": other, "k": apart,
        "x": np.where(edges, along(one, x1, y1), y1), "y": np.where(edges, along(other, x2, y2), x2),
        "along": np.where(kind >= touch.EF, touches[..., 15], 0.0),
    }  # fmt: skip


def along(edge: Array, x: Array, y: Array) -> Array:
    """Return the places along edges from x and y."""
    return np.where((edge == plate.SIDE_D) | (edge == plate.SIDE_A), x, y)


def endings(contacts: Array, ends: Array) -> Array:
    """Return the ends of paths in words (n,), from their first contacts (n, 6) and ends (n, 4)."""
    code = np.real(ends[:, 0]).astype(int)
    return WORDS[np.where((np.real(contacts[:, 0]) == -1) & (code == increments.RANGE), len(WORDS) - 1, code)]


class Path(NamedTuple):
    """A beam to be followed: its scale in its sense, its compiled data, and its first contact.

    ``other``: first contact on the other face, if it has scales.
    """

    scale: Scale
    beams: entry.Beams
    contact: Contact
    other: Contact | None = None

    @property
    def contacts(self) -> list[Contact]:
        """First contact on each face with scales."""
        return [self.contact, *([self.other] if self.other else [])]

    @property
    def engaged(self) -> float:
        """Way at the first engagement, inf for none."""
        return min(c.phi for c in self.contacts)

    @classmethod
    def at_rest(cls, scale: Scale, K: Array, mu: float, *, sense: int = 1, **bar: Unpack[Bar]) -> Path:
        """Return the path of a beam whose first contact is unknown; arguments as in :func:`beams`."""
        one = beams(Scale(*np.array([scale]).T), K[None], np.array([mu]), sense=sense, **bar)
        nothing = Contact(-1, -1, 0, math.inf, math.nan, math.nan)
        return cls(scale._replace(alpha=sense * scale.alpha), one, nothing, nothing if bar.get("seen") else None)

    @classmethod
    def of(
        cls, scale: Scale, K: Array, mu: float, *, sense: int = 1, toward: tuple[float, float] = (0.0, 1.0),
        most: float = 1.0, **bar: Unpack[Bar],
    ) -> Path:  # fmt: skip
        """Return the path of a beam, with the first contact ``toward`` a bend and twist, up to the way ``most``."""
        return cls.at_rest(scale, K, mu, sense=sense, **bar).looked(toward, most)

    def looked(self, toward: tuple[float, float], most: float) -> Path:
        """Return the path with the first contact in the direction ``toward`` (bend, twist; of length 1) up to a way."""
        # the other face's scales may come in later
        ways, there = (np.full((1, 1), most), most) if self.other else (np.empty((1, 0)), 1.0)
        return self.met(follow_all(self.beams, ways, corners=there * np.array([[toward]]), most=most))

    def met(self, found: Answers) -> Path:
        """Return the path with the first contact from results of that beam."""
        return self._replace(contact=found.contact(), other=found.other.contact() if found.other else None)

    @property
    def mu(self) -> float:
        """Coefficient of friction."""
        return float(self.beams.shapes[0, 8])

    def follow(self, targets: Array, step: float = STEP) -> Answers:
        """Follow the twists ``targets`` (n,), which may go back."""
        return follow_all(self.beams, targets[None], most=0.0, step=step, room=ROOM)

    def along(self, corners: Array, step: float = STEP) -> Answers:
        """Follow the beam from rest through corners (n, 2), bends and twists, straight between them."""
        ways = np.cumsum(np.hypot(*np.diff(corners, axis=0, prepend=np.zeros((1, 2))).T))
        return follow_all(self.beams, ways[None], step=step, corners=corners[None], room=ROOM)

    def states(self, targets: Array, step: float = STEP) -> tuple[Array, End]:
        """Follow the twists ``targets`` (n,); return rows, see ``Answers``, NaN beyond the end, and the end."""
        found = self.follow(targets, step)
        return found.rows[0], found.end()


def deflections(rows: Array) -> Array:
    """Return the coefficients (n, 24) of the plate's deflection in states, see :mod:`squama.model.elastic_plate`."""
    return rows[..., len(COLUMNS) :]


def named(rows: Array) -> dict[str, Array]:
    """Return the columns of states by name."""
    return {name: rows[..., i] for i, name in enumerate(COLUMNS)}


def motions(rows: Array, seen: Sequence[float] = ()) -> Array:
    """Return the motions, twist, bend and stretch (n, 9) of states, as seen by a face with the signs ``seen``."""
    v, (bend, twist, _) = named(rows), seen or (1.0, 1.0, 1.0)
    return np.column_stack(
        [rows[:, COLUMNS.index("u_X") : COLUMNS.index("w_Z") + 1], twist * v["twist"], bend * v["psi"], v["stretch"]]
    )

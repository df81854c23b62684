"""A beam's path on the real model: what touches first, states along the twist, figures of the plates; E = d = 1.

Twists are magnitudes: the other sense is the mirror image, alpha -> -alpha.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from squama.batch.keeping import tell
from squama.joints.factor import MIRROR
from squama.model import elastic_plate as plate
from squama.model.outcome import End
from squama.real import changes, entry, follow
from squama.real.contact import WIDTH
from squama.real.design import LEG, ROWS, SHAPE
from squama.real.features import CORNERS, FACE
from squama.types import Array

RANGE = 0.3
"""Twist per pitch, rad, to which a curve goes, and below which contacts are looked for, unless asked otherwise."""
STEP = 4e-3
"""Largest increment of the twist, rad per pitch; a quarter of it changes a torque by some 1e-5."""
EVERY = 1
"""Other contacts are looked for at every so many steps: at each, so that none of them is behind one that came in."""
_GRID = np.array([(x, y) for x in np.linspace(0.0, 1.0, 13) for y in np.linspace(-1.0, 1.0, 9)])
"""Where stresses are looked for: shares of length and half width."""
_CURVED = plate.curvatures(*_GRID.T)
EDGES = ("tip edge", "side edge", "side edge", "base edge")
FEATURES = (*EDGES, "face", *(f"corner {letter}" for letter in "CBDA"))
"""What may meet, by number (:mod:`squama.real.features`)."""
WORDS = np.array([End.RANGE, End.OFF_TIP, End.OFF_SIDE, End.OTHER, End.STOPPED, End.SNAP, End.NONE, End.TOUCHING], str)
"""Ends in words: those of :mod:`squama.real.follow` by number, then those of :func:`endings` alone."""


class Scale(NamedTuple):
    """A scale: lengths in pitches, angles in rad; ``D`` bending stiffness (E d^3, inf for rigid), Poisson's ratio.

    Floats, or arrays (n,) of many scales.
    """

    eta: Any
    beta: Any
    lam: Any
    alpha: Any
    theta0: Any
    h: Any
    D: Any = math.inf
    nu: Any = 0.3

    @property
    def elastic(self) -> Any:
        """Whether it bends, or which of them do."""
        return np.isfinite(self.D)


class Contact(NamedTuple):
    """What touches first: edges of scale 1 and of 1 + k, twist and places; ``first`` < 0: see ``first_contact``."""

    first: int
    second: int
    k: int
    phi: float
    x: float
    y: float

    @property
    def words(self) -> str:
        """The pair in words."""
        return words(self.first, self.second, self.k)


def words(first: int, second: int, k: int) -> str:
    """Return what meets in words."""
    if first == -1:
        return ""
    return place(second, k) if first == -2 else f"{FEATURES[first]} on {FEATURES[second]} (k = {k})"


def place(edge: int, k: int, scale: int = 1) -> str:
    """Return where an edge of a scale (+ 4: of its neighbour k) comes to the other's face, in words."""
    own, other = (scale, scale + k) if edge < 4 else (scale + k, scale)
    return f"{EDGES[edge % 4]} of scale {own} on the face of scale {other} (k = {k})"


class Answers(NamedTuple):
    """Of n beams: first contacts (n, 6), tables of the designs (n, 46, 24), rows (n, m, 19) and ends (n, 5).

    See :mod:`squama.real.entry`; rows hold :data:`squama.real.follow.COLUMNS`, or ``STRAINED`` where bend and stretch
    are known, NaN beyond the end.
    """

    contacts: Array
    tables: Array
    rows: Array
    ends: Array

    def contact(self, i: int = 0) -> Contact:
        """Return what touches first of one beam."""
        return Contact(*(int(v) for v in self.contacts[i, :3]), *self.contacts[i, 3:].tolist())

    def end(self, i: int = 0) -> follow.End:
        """Return how the path of one beam ends."""
        code, phi, *rest = self.ends[i].tolist()
        return follow.End(int(code), phi, *map(int, rest))


def beams(scale: Scale, K: Array, mu: Array, *, sense: int = 1, stretch: str = "") -> entry.Beams:
    """Return beams for the compiled model.

    Parameters
    ----------
    scale
        Arrays (n,) in place of floats.
    K
        Matrices (n, 7, 7) or (n, 9, 9); of these the part that neither bends nor stretches unless ``stretch`` is given.
    mu
        Coefficients of friction (n,).
    sense
        -1 for the mirror image.
    stretch
        "free" where there is no axial force, "held" where the length is held; K (n, 9, 9), and states know bend,
        stretch and the contact's force. Without it the length is held and K may be (n, 7, 7).
    """
    motions = 9 if stretch else 7
    signs = MIRROR[:motions] if sense < 0 else np.ones(motions)
    alpha, theta0 = sense * scale.alpha, scale.theta0
    shapes = np.column_stack([
        scale.eta, scale.beta, scale.lam, np.sin(alpha), np.cos(alpha), np.sin(theta0), np.cos(theta0), scale.h, mu,
    ])  # fmt: skip
    elastic, n = np.isfinite(scale.D), len(K)
    plates = np.zeros((n, 24, 24), shapes.dtype)
    if elastic.any():
        made = plate.compliances(*(v[elastic] for v in (scale.eta, scale.beta, scale.nu)))
        plates[elastic] = made / scale.D[elastic].reshape(-1, 1, 1)
    soft = 1 / K[:, 8, 8] if stretch == "free" else np.zeros(n, K.dtype)
    K = np.ascontiguousarray(K[:, :motions, :motions] * np.outer(signs, signs))
    return entry.Beams(shapes, K, elastic, plates, np.full(n, bool(stretch)), soft)


def follow_all(
    beams: entry.Beams, targets: Array, *, most: float | Array | None = None, contacts: Array | None = None,
    step: float = STEP, every: int = EVERY, corners: Array | None = None, notes: Array | None = None,
) -> Answers:  # fmt: skip
    """Follow beams to targets (n, m); first contacts are looked for below the twists ``most`` unless they are given.

    ``corners`` (n, m, 2): bend and twist at the targets, which are ways then, straight on to ``most``; it is 1 if not
    given, and the last target where there are corners. ``notes`` (n, i, 56): room for the states, see
    :func:`squama.real.follow.follow`.
    """
    if most is None:
        most = 1.0 if corners is None else 0.0
    n = len(targets)
    columns = follow.STRAINED if beams.bent.any() else follow.COLUMNS
    found = Answers(
        np.full((n, 6), np.nan) if contacts is None else contacts, np.zeros((n, ROWS, 24)),
        np.full((*targets.shape, len(columns)), np.nan), np.zeros((n, len(follow.End._fields))),
    )  # fmt: skip
    tell(entry.answer, "the real beam")
    most, targets = np.full(n, most, float), np.ascontiguousarray(targets, float)
    corners = np.zeros((n, 0, 2)) if corners is None else np.ascontiguousarray(corners, float)
    notes = np.zeros((n, 0, WIDTH)) if notes is None else notes
    entry.answer(beams, most, step, every, targets, corners, *found, notes)
    return found


def held_bent(beams: entry.Beams, bends: Array, twists: Array, most: Array) -> Answers:
    """Bend beams that may be bent by ``bends`` (n,) and twist them to rising twists (n, m) above 0; rows at these.

    What touches first is looked for below the twists ``most`` (n,).
    """
    ways = np.column_stack([0 * bends, twists]) + np.abs(bends)[:, None]
    # as far as the way goes, to the last digit
    corners = np.stack(np.broadcast_arrays(bends[:, None], ways - ways[:, :1]), axis=-1)
    found = follow_all(beams, ways, corners=corners, most=np.abs(bends) + most)
    return found._replace(rows=found.rows[:, 1:])


def bent_alone(beams: entry.Beams, bends: Array, most: Array) -> Answers:
    """Bend beams that may be bent to rising bends (n, m) from 0 on, the twist held at 0; ``most`` as of twists."""
    return follow_all(beams, bends, corners=np.stack([bends, 0 * bends], axis=-1), most=most)


def moved(beams: entry.Beams, targets: Array, copies: int, *, most: float | Array = 1.0) -> Answers:
    """Follow beams to rising targets (n, m) as :func:`follow_all`, with complex steps in beams and targets.

    Each beam stands there ``copies`` times, one after the other, with other steps. Rows and first contacts are complex,
    without an imaginary part behind a contact that sticks.
    """
    real = entry.Beams(*(np.ascontiguousarray(np.real(v[::copies])) for v in beams))
    at = np.ascontiguousarray(np.real(targets[::copies]))
    # as many as the steps are where none is halved, and some
    tell(entry.move, "the real beam's derivatives")
    notes = np.zeros((len(at), 2 * (at.shape[1] + math.ceil(at.max(initial=0.0) / STEP)) + 100, WIDTH))
    found = follow_all(real, at, most=most, notes=notes)
    contacts, tables, rows, ends = (np.repeat(v, copies, axis=0) for v in found)
    tables, changed, starts = tables + 0j, np.zeros(rows.shape, complex), contacts[:, 3:] + 0j
    entry.move(real, found.contacts, at, STEP, notes, beams, np.ascontiguousarray(targets), tables, starts, changed)
    return Answers(np.hstack([contacts[:, :3], starts]), tables, rows + 1j * changed.imag, ends)


def endings(contacts: Array, ends: Array) -> Array:
    """Return in words how paths end (n,), by their first contacts (n, 6) and their ends (n, 5)."""
    contacts = np.real(contacts)
    first, code = contacts[:, 0].astype(int), ends[:, 0].astype(int)
    # where a contact leaves its edge, the edge says how; that of the base is no edge of the contact's
    off = np.array([changes.OFF_FIRST, changes.OFF_SECOND, changes.OFF_SECOND, *[changes.OTHER] * 6])
    left = (code == changes.OFF_FIRST) | (code == changes.OFF_SECOND)
    code = np.where(left, off[np.maximum(ends[:, 2].astype(int), 0)], code)
    code = np.where((first == -1) & (code == changes.RANGE), 6, code)
    return WORDS[np.where((first == -2) & (contacts[:, 3] == 0.0), 7, code)]


class Path(NamedTuple):
    """A beam to be followed: its scale as seen in its sense, its design's table, and what touches first."""

    scale: Scale
    beams: entry.Beams
    table: Array
    contact: Contact

    @classmethod
    def of(cls, scale: Scale, K: Array, mu: float, *, sense: int = 1, most: float = 1.0, stretch: str = "") -> Path:
        """Return the path of a beam that is twisted; arguments as of :func:`beams`, ``most``: largest twist."""
        one = beams(Scale(*np.array([scale]).T), K[None], np.array([mu]), sense=sense, stretch=stretch)
        found = follow_all(one, np.empty((1, 0)), most=most)
        return cls(scale._replace(alpha=sense * scale.alpha), one, found.tables[0], found.contact())

    @property
    def columns(self) -> int:
        """Number of columns of its states."""
        return len(follow.STRAINED if self.beams.bent[0] else follow.COLUMNS)

    @property
    def mu(self) -> float:
        """Coefficient of friction."""
        return float(self.beams.shapes[0, 8])

    def bending(self, rows: Array) -> Array:
        """Return the loads (n, 24) of the plates in states (:func:`pressed`)."""
        c = self.contact
        return pressed(self.scale, (c.first, c.second) if c.first >= 0 else (plate.TIP, plate.SIDE_D), rows)

    def states(self, targets: Array, step: float = STEP, every: int = EVERY) -> tuple[Array, follow.End]:
        """Follow the twist to targets (n,); return rows, see :class:`Answers`, NaN beyond the end."""
        contacts = np.array([self.contact], float)
        found = follow_all(self.beams, targets[None], contacts=contacts, step=step, every=every)
        return found.rows[0], found.end()


def spots(scale: Scale, met: Any, rows: Array, which: int) -> tuple[Array, Array]:
    """Return the places (n,) of contacts in the plate of scale 1 (0) or of the other one (1), in states.

    Of one scale, or of n scales; ``met``: features of both, (2,) or (2, n); rows of beams that are bent tell their own.
    """
    x, y, along, at = rows[:, 4], rows[:, 5], 0 * rows[:, 4], rows[:, 4 + which]
    if rows.shape[1] == len(follow.STRAINED):
        met, along = np.real(rows[:, 26:28].T), rows[:, 28]
    one, two = (np.broadcast_to(feature, len(rows)) for feature in met)
    f, faced = (one, two)[which], (one == FACE) | (two == FACE)
    tip, left, right, base = (f == edge for edge in (plate.TIP, plate.SIDE_D, plate.SIDE_A, plate.BASE))
    lengths = [x, at, 0 * x]
    widths = [y, along, at]
    ends = np.where(left | ((f % 2 == 1) & ~right), -1, 1) * scale.beta
    return (
        np.select([f == FACE, left | right, base | (f >= CORNERS + 2)], lengths, scale.eta + 0 * x),
        np.select([f == FACE, tip & faced, tip | base], widths, ends + 0 * y),
    )


def pressed(scale: Scale, met: Any, rows: Array) -> Array:
    """Return the loads (n, 24) of the powers X^m Y^n of plates in states; arguments as of :func:`spots`."""
    places = (np.nan_to_num(spots(scale, met, rows, i)) for i in (0, 1))
    one, two = (plate.monomials(x / scale.eta, y / scale.beta) for x, y in places)
    return np.asarray(rows[:, 6, None] * one + rows[:, 7, None] * two)


def deflections(path: Path, rows: Array) -> Array:
    """Return the plate's deflections as powers (n, 24), see :mod:`squama.model.elastic_plate`, of states."""
    return path.bending(rows) @ path.table[SHAPE:LEG]


def motions(rows: Array) -> Array:
    """Return the motions and the twist (n, 7) of states; (n, 9) with bend and stretch of a beam that is bent."""
    strains = rows[:, [20, 19, 21]] if rows.shape[1] == len(follow.STRAINED) else rows[:, :1]
    return np.column_stack([rows[:, 11:17], strains])


def energies(path: Path, rows: Array) -> dict[str, Array]:
    """Return the elastic energy (n,) in joint, plate and bar, E d^3 per pitch: roles U_joint, U_plate, U_bar."""
    q, g = motions(rows), path.bending(rows)
    n, alone = q.shape[1], bare(path.beams)[0]
    loads = q[:, 6 : 6 + len(alone)]
    whole = np.einsum("ni,ij,nj->n", q, path.table[:n, :n], q) / 2
    bar = np.einsum("ni,ij,nj->n", loads, alone, loads) / 2
    own = np.einsum("ni,ij,nj->n", g, path.table[SHAPE:LEG], g) / 2
    return {"U_joint": whole - bar, "U_plate": own, "U_bar": bar}


def bare(beams: entry.Beams) -> Array:
    """Return the stiffness (n, 1, 1) of beams without contact against twist, or (n, 2, 2) against twist and bend.

    All are bent, or none is, and free to stretch, or none is.
    """
    K, free = beams.K, int(beams.soft[0] > 0)
    loads, loose = [6, 7][: K.shape[1] - 6], [*range(6), *[8] * free]
    across = K[:, loose][:, :, loads]
    given = np.linalg.solve(K[:, loose][:, :, loose], across)
    return np.asarray(K[:, loads][:, :, loads] - across.swapaxes(1, 2) @ given)


def rigidity(path: Path) -> float:
    """Return the torque per twist without contact, E d^3."""
    return float(bare(path.beams)[0, 0, 0])


def stresses(scale: Scale, bent: Array) -> tuple[Array, Array]:
    """Return the largest stress (von Mises, E) in a scale, by Kirchhoff's moments 6 m / h^2, and its place (n, 2).

    By deflections (n, 24) of one scale or of n; the place is NaN where there is no stress.
    """
    eta, beta, _, _, _, h, D, nu = (np.reshape(v, (-1, 1)) for v in scale)
    xx, yy, xy = bent @ _CURVED[0] / eta**2, bent @ _CURVED[1] / beta**2, bent @ _CURVED[2] / (eta * beta)
    mx, my, mxy = xx + nu * yy, yy + nu * xx, (1 - nu) * xy
    squared = mx * mx - mx * my + my * my + 3 * mxy * mxy
    most = np.real(squared).argmax(axis=1)
    largest = 6 * (D / h**2).ravel() * np.sqrt(squared[np.arange(len(bent)), most])
    places = _GRID[most] * np.column_stack([eta.ravel(), beta.ravel()])
    return largest, np.where(np.real(largest[:, None]) > 0, places, np.nan)


def stresses_of(scale: Scale, found: Answers) -> Array:
    """Return the largest stresses (n, m) of n beams at their targets; NaN where scales are rigid."""
    stress = np.where(scale.elastic[:, None] & np.isfinite(found.rows[..., 1]), 0.0 * found.rows[..., 1], np.nan)
    # without contact nothing bends, whatever the edges are
    which, column = np.nonzero(np.isfinite(stress) & (np.real(found.rows[..., 2]) > 0))
    one, rows = Scale(*(v[which] for v in scale)), found.rows[which, column]
    met = np.maximum(np.real(found.contacts[which, :2]).astype(int), 0)
    bent = np.einsum("nkj,nj->nk", found.tables[which, SHAPE:LEG], pressed(one, met.T, rows))
    stress[which, column] = stresses(one, bent)[0]
    return stress


def plate_figures(scale: Scale, bent: Array) -> dict[str, Array]:
    """Return what is told of a scale's deflections (n, 24), by role; E = d = 1.

    Deflection of the middle of its tip along its normal, turn of the tip about its length by that of its corners,
    largest stress and its place; no stress in a rigid scale.
    """
    b = bent.reshape(len(bent), 6, 4)
    told = {"deflection": b[:, :, 0].sum(axis=1), "scale_twist": b[:, :, 1::2].sum(axis=(1, 2)) / scale.beta}
    if not scale.elastic:
        return told | dict.fromkeys(("stress", "stress_x", "stress_y"), np.full(len(b), np.nan))
    stress, places = stresses(scale, bent)
    return told | {"stress": stress, "stress_x": places[:, 0], "stress_y": places[:, 1]}


def _turns(w: Array) -> Array:
    """Return the rotations (n, 3, 3) of the scale from its attitude at rest, in its axes there, by vectors (n, 3)."""
    from scipy.spatial.transform import Rotation

    known = np.isfinite(w).all(axis=1)
    out = np.full((len(w), 3, 3), np.nan)
    if known.any():
        out[known] = Rotation.from_rotvec(w[known]).as_matrix()
    return out


def inclinations(path: Path, rows: Array) -> Array:
    """Return the angle (n,) of n_X against the beam's face, seen along the width at rest, rad."""
    theta0 = path.scale.theta0
    x = _turns(rows[:, 14:17])[:, :, 0]
    # n_X and n_Z at rest are turned by theta0 from the face, about n_Y
    return np.asarray(theta0 + np.arctan2(x[:, 2], x[:, 0]))


def on_tab(path: Path, q: Array) -> tuple[Array, Array]:
    """Return force (E d^2) and moment (E d^3) of the contacts on the embedded part, about its base midpoint.

    Both (n, 3) by its :func:`motions`, along the scale's own axes, which turn with it; one along n_X pulls it out.
    """
    loads, w, turns = q @ path.table[:6, : q.shape[1]].T, q[:, 3:6], _turns(q[:, 3:6])
    # what is conjugate to a rotation vector is not yet the moment
    t = np.linalg.norm(w, axis=1)[:, None]
    k = (1 - np.cos(t / 2) / np.sinc(t / (2 * np.pi))) / np.maximum(t, 1e-100) ** 2
    once = np.cross(w, loads[:, 3:])
    force, moment = loads[:, :3], loads[:, 3:] + once / 2 + k * np.cross(w, once)
    return np.einsum("ni,nij->nj", force, turns), np.einsum("ni,nij->nj", moment, turns)

"""Loads of beams with a number of scales, over those of endless beams, at states of the latter."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from squama.batch.keeping import tell
from squama.contacts import entry, from_endless, increments, path
from squama.contacts.increments import Legs, Written
from squama.contacts.system import EPS, MOTIONS, OWN, POWERS, STRAINS, Ties
from squama.contacts.ties import KINDS, LOOSE, freed, of_ends
from squama.loads import ending
from squama.types import Array

MOST = 8
"""Largest number of scales between loose ends that is solved for; the effect of the ends of longer beams is
extrapolated.
"""


class Own(NamedTuple):
    """A number of scales, their ends (``LOOSE``, ``COUPLE`` or ``GRIPPED``), and the states of a path to use."""

    scales: int
    kind: int = LOOSE
    states: slice = slice(None)

    @property
    def words(self) -> str:
        """The beam in words."""
        (word,) = (word for word, kind in KINDS.items() if kind == self.kind)
        return f"{self.scales} scales {ending(word)}"


_MOTION, _STRAIN, _LOAD = (path.COLUMNS.index(name) for name in ("u_X", "psi", "M"))


def _loads(rows: Array) -> Array:
    """Return M, T, B and P (n, 4) of states."""
    return rows[:, _LOAD : _LOAD + STRAINS]


def _cell(rows: Array) -> Array:
    """Return motions, strains and plate coefficients of states."""
    motions, strains = (rows[:, at : at + n] for at, n in ((_MOTION, MOTIONS), (_STRAIN, STRAINS)))
    return np.column_stack([motions, strains, path.deflections(rows)])


def _solved(beams: entry.Beams, scales: int, ties: Ties, given: Array, contacts: int) -> Array:
    """Return M, T, B and P (n, 4) of rows of scales, started from endless states; NaN if no state is found.

    ``contacts``: room for contacts of each scale.
    """
    n, every = len(given), scales * path.faces(beams)
    one, none = np.zeros((n, 1)), np.zeros((n, 0))
    sizes = (increments.LINE,), (every, MOTIONS + 2 * STRAINS + 1), (every, POWERS), (0, increments.CONTACT)
    states = (np.zeros((n, 1, *v)) for v in sizes)
    found = Written._make([*states, np.zeros((n, 1, increments.EVENT)), np.zeros((n, 4))])
    legs = Legs(one, np.zeros((n, 1, STRAINS)), one[:, 0], path.STEP)
    tell(entry.many, "scales in contact")
    entry.many(beams, every, OWN, ties, scales * contacts, legs, found, none, given)
    return np.where(found.ends[:, :1] == increments.RANGE, found.rows[:, 0, 5 : 5 + STRAINS], np.nan)


def ratios(beams: entry.Beams, answers: path.Answers, own: Own, *loads: int) -> Array:
    """Return load and tangent stiffness of beams with their own scales over those of the endless ones, (2, n).

    At the last of the states; the tangent is taken from the state before (NaN if there is none). ``loads``: loaded
    strains, the last of which is the load to compare. 1 without contact, NaN if the endless beam ends before, or if no
    state with its contacts is found.
    """
    faces = [(face.rows[:, own.states], face.touches[:, own.states]) for face in answers.faces]
    met, rows = np.min([face.contacts[:, 3] for face in answers.faces], axis=0), faces[0][0]
    way, strain, load = rows[..., 0], rows[..., _STRAIN + loads[-1]], rows[..., _LOAD + loads[-1]]
    if own.kind != LOOSE:
        places = range(max(0, rows.shape[1] - 2), rows.shape[1])
        found = np.array([_shares(beams, faces, own, loads, at) * load[:, at] for at in places])
    else:
        short = own._replace(scales=min(own.scales, MOST))
        solved = _shares(beams, faces, short, loads, -1) * load[:, -1]
        each = zip(way, strain, load, solved, met, strict=True)
        found = np.array([_longer(*one, short.scales, own.scales) for one in each]).T
    with np.errstate(all="ignore"):
        tangents = (np.diff(found, axis=0) / np.diff(load[:, -len(found) :].T, axis=0))[:1]
        shares = np.where(load[:, -1] == found[-1], 1.0, found[-1] / load[:, -1])
    return np.array([shares, tangents[0] if len(tangents) else np.full(len(rows), np.nan)])


def _longer(way: Array, strain: Array, load: Array, solved: float, met: float, n: int, scales: int) -> Array:
    """Return the loads (2,) of a beam of ``scales`` at the last two mean strains, from that of n scales at the last.

    The cells of a beam bear the same load, as springs in series: inner cells are strained as the endless beam under
    that load, end cells by more, in proportion to the load above that at engagement. Arrays (m,) are of the endless
    beam along its ``way``; ``met`` is its engagement.
    """
    if not solved < load[-1]:
        # no contact, no solution, or ends that are not softer: the ends' effect is shared among all scales
        before = load[-2:-1] * (1.0 if solved == load[-1] else np.nan)
        return np.append(before, load[-1] + (solved - load[-1]) * n / scales)
    if not (np.diff(load) > 0).all():
        # behind a snap the load is no function of the strain
        return np.append(load[-2:-1] * np.nan, solved if n == scales else np.nan)
    engaged = float(np.interp(met, way, load))
    more = n * (strain[-1] - np.interp(solved, load, strain)) / max(solved - engaged, 1e-12 * solved)
    means = strain + more * np.maximum(load - engaged, 0.0) / scales
    found = np.interp(strain[-2:], means, load)
    return np.append(found[:-1], solved) if n == scales else found


def _shares(
    beams: entry.Beams, faces: Sequence[tuple[Array, Array]], own: Own, loads: tuple[int, ...], at: int
) -> Array:
    """Return the load of beams with their own scales over that of the endless ones at state ``at``, (n,).

    ``faces``: states and contacts of each face with scales.
    """
    each = np.array([np.nan_to_num(path.named(rows)["contacts"]) for rows, _ in faces])
    touching, counts = np.any(each > 0, axis=0), each[:, :, at].sum(axis=0)
    known = np.isfinite(faces[0][0][:, at, 0])
    last = np.concatenate([touches[:, at] for _, touches in faces], axis=1)
    # those of both faces without the room between them
    there = np.concatenate([np.arange(faces[0][1].shape[2]) < n[:, at, None] for n in each], axis=1)
    last = np.take_along_axis(last, np.argsort(~there, axis=1, kind="stable")[..., None], axis=1)
    found = np.where(known & (counts == 0), 1.0, np.nan)
    which = np.flatnonzero(known & (counts > 0) & (counts <= last.shape[1]))
    if not which.size:
        return found
    free = freed(beams.free, *loads, ends=own.kind)
    ties = of_ends(own.scales, own.kind, *loads, apart=bool(beams.free[0, EPS] == 0))
    first, now = touching[which].argmax(axis=1), faces[0][0][which, at]
    given = np.column_stack(
        [
            *(_cell(rows[which, first]) for rows, _ in faces),
            *(_cell(rows[which, at]) for rows, _ in faces),
            _loads(now),
            counts[which],
            last[which].reshape(which.size, -1),
        ]
    )
    assert given.shape[1] == from_endless.size(last.shape[1], len(faces))
    some = entry.Beams._make(v[which] for v in beams._replace(free=free))
    solved = _solved(some, own.scales, ties, given, int(counts.max()))
    found[which] = solved[:, loads[-1]] / _loads(now)[:, loads[-1]]
    return found

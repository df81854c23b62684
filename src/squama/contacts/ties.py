"""Ties of a bar of n cells: the coordinates that loads and supports impose; E = d = 1.

Sections are counted from the near end, 0, to the far end, n. Directions are those of the near end at rest: x along the
bar's width, y from its middle to the scaled face, z along the bar.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from squama import loads
from squama.contacts.system import CHI, EPS, EQUAL, FREE, LOADED, PHI, PSI, STRAINS, UNTIED, Ties
from squama.types import Array

LOOSE, GRIPPED, COUPLE = range(1, 4)
"""Ends of a row, beside ``EQUAL``: the same load in all cells, both ends on one axis, or a couple at both ends."""
KINDS = {loads.FREE: LOOSE, loads.COUPLE: COUPLE, loads.GRIPPED: GRIPPED, "equal": EQUAL}
"""Kinds of ends by their word."""
X, Y, Z = np.eye(3)
TURNS = {PSI: -X, PHI: -Z, CHI: -Y}
"""Rotation vector of a cell per strain, by strain."""
_STAYS = -1.0


class Tie(NamedTuple):
    """One coordinate, and its unit load: forces by section, M, T, B, P on cells, a section's rotation, a couple.

    ``carried``: M, T, B, P on all cells alike, (4,), or those of each, (n, 4).
    ``course``: the strain of the legs that drives it, and the factor; see ``squama.contacts.system.Ties``.
    """

    forces: Sequence[tuple[float, Array]] = ()
    carried: Sequence[float] | Array = (0.0, 0.0, 0.0, 0.0)
    turn: tuple[float, Array, Array] | None = None
    couple: Array = 0 * Z
    course: tuple[float, float] = (_STAYS, 0.0)


def ties(n: int, every: Sequence[Tie], *, floating: bool = False) -> Ties:
    """Return the ties of n cells; a force between two sections is divided between them as by a lever."""
    along = floating or any(len(t.forces) or t.turn or t.couple.any() for t in every)
    K, sections = len(every), n + 1 if along else 0
    forces, turns = np.zeros((K, sections, 3)), np.zeros((K, 7))
    turns[:, 0] = -1.0
    for k, tie in enumerate(every):
        for at, force in tie.forces:
            j = min(int(at), n - 1)
            forces[k, j] += (1 - (at - j)) * force
            forces[k, j + 1] += (at - j) * force
        if tie.turn is not None:
            turns[k, 0], turns[k, 1:4], turns[k, 4:] = tie.turn
    if not K:
        return UNTIED._replace(forces=forces, turns=turns, floating=floating)
    carried = np.array([np.broadcast_to(np.asarray(t.carried, float), (n, STRAINS)) for t in every])
    course, couples = (np.array([getattr(t, name) for t in every], float) for name in ("course", "couple"))
    return Ties(forces, carried, turns, course, couples, floating)


def of_ends(n: int, ends: int, *loads: int, apart: bool = False) -> Ties:
    """Return the ties of a row whose mean strains ``loads`` are imposed (between grips just one), by default the twist.

    A couple imposes the rotation of the far end about one axis, over the number of cells. ``apart``: grips keep their
    distance.
    """
    loads = loads or (PHI,)
    if ends == COUPLE:
        return ties(n, [Tie(couple=TURNS[load], course=(load, n)) for load in loads])
    if ends == LOOSE:
        return ties(n, [Tie(carried=np.eye(STRAINS)[load].tolist(), course=(load, n)) for load in loads])
    (load,) = loads
    coaxial = [Tie(turn=(n, axis, -n * Z), course=(load, 0.0)) for axis in (X, Y, Z)]
    across = [Tie([(n, axis)]) for axis in (X, Y)]
    return ties(n, [*coaxial, *across, *([Tie([(n, Z)], course=(EPS, n))] if apart else [])])


def of_mode(load: int, shape: Array) -> Ties:
    """Return the tie of a row whose cells carry loads like ``shape`` (n,), up to a factor.

    Its coordinate is the amplitude a of a bar without contact, whose cells are strained by a times the shape.
    """
    carried = np.zeros((len(shape), STRAINS))
    carried[:, load] = shape
    return ties(len(shape), [Tie(carried=carried, course=(load, float(shape @ shape)))])


def freed(free: Array, *loads: int, ends: int = LOOSE) -> Array:
    """Return the kinds (n, 4) of strains, imposed, free or loaded, if ties drive the strains ``loads``.

    Between grips a held stretch is their distance.
    """
    out = free.copy()
    out[:, list(loads)] = LOADED
    if ends == GRIPPED:
        out[:, EPS] = np.where(free[:, EPS] > 0, FREE, LOADED)
    return out

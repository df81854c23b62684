"""Data of scales on a bar, with their joints and plates, and of their states; E = d = 1.

An endless beam is one scale with its own images, or two with scales on both faces; a row has N scales, each with its
own unknowns. All share the strains of the bar, or each cell of a row has its own, depending on the ends
(:mod:`squama.contacts.supports`).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from squama.batch.keeping import inlined as _in
from squama.batch.keeping import part as _jit
from squama.contacts import touch
from squama.contacts.touch import lengthwise, places_of
from squama.types import Array

ETA, BETA, H, MU, ELASTIC, STIFF = range(6)
"""Columns of a scale's shape."""
PSI, PHI, CHI, EPS = range(4)
"""Strains of a cell: bend, twist, lateral bend, stretch; the conjugate loads are M, T, B and P."""
MOTIONS, STRAINS, POWERS = 6, 4, 24
"""Numbers of motions (u, w) of a scale, of strains of a cell, and of powers X^m Y^n of a plate's deflection."""
TILT = MOTIONS
"""Column of a scale's tilt, after its motions, where cells have their own strains."""
ENDLESS, EQUAL, OWN, ALONE = range(-1, 3)
"""Kinds of cells: they repeat for ever; all cells of a row have the same strains; each has its own; or each has its own
and repeats for ever.
"""
SECTION, AXIS, SPIN = 0, 1, 4
"""Columns of a tie that holds a rotation: section, axis, prescribed rotation."""
IMPOSED, FREE, LOADED = range(3)
"""Kinds of strains: imposed on each cell; free, without a load; or free and driven by a tie of that name."""
_NONE, _UNTILTED = np.zeros(0), np.zeros((0, 3))


class Ties(NamedTuple):
    """K coordinates of a bar whose cells have strains of their own; each is imposed by a load, its multiplier.

    The coordinate of a tie is the work of its unit load on the way from rest. ``forces`` (K, N + 1, 3) on the sections
    between cells, in the axes of the near end at rest, or (K, 0, 3) if no tie acts on sections; ``carried`` (K, N, 4):
    M, T, B, P on the cells; ``turns`` (K, 7): a section (-1: none) whose rotation is held about an axis (3), and its
    prescribed rotation (3) per unit of its course; ``course`` (K, 2): the strain of the path's legs that drives a tie
    (-1: none), and the factor; ``couples`` (K, 3): axis and size of a couple on the far end
    (:mod:`squama.contacts.supports`). ``floating``: the near end is not clamped; without couples.
    """

    forces: Array
    carried: Array
    turns: Array
    course: Array
    couples: Array
    floating: bool


UNTIED = Ties(np.zeros((0, 0, 3)), np.zeros((0, 0, 4)), np.zeros((0, 7)), np.zeros((0, 2)), np.zeros((0, 3)), False)
"""No ties."""


class System(NamedTuple):
    """N scales and their bar.

    ``shapes`` (N, 6): eta, beta, h, mu, elastic (1 if plates bend: all or none), and the stiffness that multiplies slip
    in the friction law, of the order of the scale's own (solutions do not depend on it); ``axes`` (N, 3, 3): rows n_X,
    n_Y, n_Z at rest in the section; ``bases`` (N, 3): base midpoints there; ``K`` (N, 10, 10) over (u, w, psi, phi,
    chi, eps); ``plates`` (N, 24, 24), compliances over the powers; ``free`` (4,): whether strains are imposed, free or
    loaded; ``grip``: tangential compliance of a sticking contact, d/E; ``reach``: farthest neighbour; ``periodic``: the
    N scales repeat for ever, with ``own`` the scales of each cell; ``sees`` (N, 3): signs with which a scale sees bend,
    twist and lateral bend (:mod:`squama.beam.faces`); ``stride``: number of scales of a cell, one of each face;
    ``rests`` (N,): inclination at rest over the substrate, for scales that may come to lie on it, or (0,) without that
    check; ``masked`` (6,): 1 for blocked motions, or (0,) for none; ``own``: whether each cell has its own strains,
    governed by ``ties``; ``tilts`` (N, 3): displacement u_Z and rotations w_X, w_Y of a scale per unit of its tilt, of
    stiffness 1, or (0, 3) unless ``own`` (docs: row, tilt).
    """

    shapes: Array
    axes: Array
    bases: Array
    K: Array
    plates: Array
    free: Array
    grip: float
    reach: int
    periodic: bool
    sees: Array
    stride: int
    rests: Array = _NONE
    masked: Array = _NONE
    own: bool = False
    ties: Ties = UNTIED
    tilts: Array = _UNTILTED


class State(NamedTuple):
    """A state: scales, strains of the bar and contacts.

    Motions ``q`` (N, 6), with tilts (N, 7); ``strains`` (1, 4) of all cells or (cells, 4) of each, deflections ``b``
    (N, 24); of each contact its force ``F`` (C, 3) on the first scale in that scale's axes at rest, and its places
    ``s`` (C, 3); ``ties`` (2, K) loads of ties and their prescribed values along the legs, for a floating beam
    (2, K + 6) followed by rotation and place of the near end.
    """

    q: Array
    strains: Array
    b: Array
    F: Array
    s: Array
    ties: Array


class Past(NamedTuple):
    """The three earlier states, for the slip of an increment; its law uses two of them.

    ``E`` (3, N, 12) attitudes and places of the scales, ``pairs`` (3, N, reach, 12) of their neighbours, ``b`` (3, N,
    24), forces ``F`` (C, 3) at the last state; ``weights`` (3,) of the backward difference.
    """

    E: Array
    pairs: Array
    b: Array
    F: Array
    weights: Array


@_jit
def copy(a: Array, b: Array) -> None:
    """Copy array a to b; an assignment of slices takes long to compile."""
    x, y = a.flat, b.flat
    for i in range(a.size):
        y[i] = x[i]


@_jit
def transfer(a: Array, numbers: Array, at: int, out: bool) -> int:
    """Copy an array to ``numbers`` from index ``at`` on, or from there if not ``out``; return the index behind it."""
    x = a.flat
    for i in range(a.size):
        if out:
            numbers[at + i] = x[i].real
        else:
            x[i] = numbers[at + i]
    return at + a.size


@_jit
def copied(a: State, b: State) -> None:
    """Copy state a to b."""
    copy(a.q, b.q)
    copy(a.strains, b.strains)
    copy(a.b, b.b)
    copy(a.F, b.F)
    copy(a.s, b.s)
    copy(a.ties, b.ties)


@_in
def partner(S: System, c: Array) -> int:
    """Return the index of a contact's other scale."""
    return further(S, c[touch.FIRST], c[touch.APART])


@_in
def cells(S: System) -> int:
    """Return the number of cells; loads are those of one cell."""
    return len(S.shapes) // S.stride


@_in
def further(S: System, i: int, k: int) -> int:
    """Return the index of the scale k cells further on the same face; N or more if a row has none there."""
    j: int = i + k * S.stride
    return i if S.periodic and S.own else j % len(S.shapes) if S.periodic else j


@_in
def row_of(S: System, i: int) -> int:
    """Return the row of the strains of scale i's cell."""
    return i // S.stride if S.own else 0


@_in
def before_cell(S: System, at: Array, i: int) -> int:
    """Return the first unknown of cell i: its section's, and its own strains, come before those of its scales."""
    n: int = at[i * S.stride] - ahead(S)
    return n


@_in
def pieces(S: System, k: int) -> int:
    """Return the number of cells with their own strains between a scale and the one k further."""
    return k + 1 if S.own and not S.periodic else 1


@_in
def freedoms(S: System) -> int:
    """Return the number of motions of a scale, with its tilt."""
    return MOTIONS + (1 if S.own else 0)


@_in
def rated(S: System, k: int) -> int:
    """Return the number of rates of a neighbour k cells further: by strains of the cells between, and by both tilts."""
    n: int = STRAINS * pieces(S, k)
    return n + (2 if S.own else 0)


@_jit
def counted(S: System) -> int:
    """Return the number of strains that are free or loaded."""
    n = 0
    for e in range(STRAINS):
        if S.free[e] > 0:
            n += 1
    return n


@_in
def sectioned(S: System) -> bool:
    """Return whether the sections between cells are followed."""
    return bool(S.ties.forces.shape[1] > 0)


@_in
def ahead(S: System) -> int:
    """Return the number of a cell's unknowns before its scales': motion and wrench of its section, own strains."""
    return counted(S) + (12 if sectioned(S) else 0) if S.own else 0


@_in
def borders(S: System) -> int:
    """Return the number of unknowns of the whole beam: strains that all cells share, or loads of ties."""
    return len(S.ties.course) + (6 if S.ties.floating else 0) if S.own else counted(S)


@_jit
def home(S: System, k: int) -> int:
    """Return the cell behind whose unknowns tie k's load has its place; -1 at the end, for more than a cell's sections.

    The place of a floating beam's near end comes behind the ties.
    """
    if not S.own or k >= len(S.ties.course):
        return 0 if S.own else -1
    first, last, N = -1, -1, S.ties.forces.shape[1] - 1
    for i in range(S.ties.carried.shape[1]):
        for e in range(STRAINS):
            if S.ties.carried[k, i, e] != 0.0:
                return -1
    for j in range(N + 1):
        size = abs(S.ties.forces[k, j, 0]) + abs(S.ties.forces[k, j, 1]) + abs(S.ties.forces[k, j, 2])
        if j == N:
            size += abs(S.ties.couples[k, 0]) + abs(S.ties.couples[k, 1]) + abs(S.ties.couples[k, 2])
        if size > 0.0 or S.ties.turns[k, SECTION] == j:
            first, last = j if first < 0 else first, j
    return min(first, N - 1) if last <= first + 1 else -1


@_in
def of_tie(S: System, at: Array, k: int) -> int:
    """Return the unknown of tie k's load, or behind the ties of the near end's place."""
    n: int = at[len(at) - borders(S) + k]
    return n


@_in
def low(S: System, i: int, edge: int) -> float:
    """Return the smallest place on an edge of scale i."""
    place: float = 0.0 * S.shapes[i, BETA] if lengthwise(edge) else -S.shapes[i, BETA]
    return place


@_in
def high(S: System, i: int, edge: int) -> float:
    """Return the largest place on an edge of scale i."""
    place: float = S.shapes[i, ETA] if lengthwise(edge) else S.shapes[i, BETA]
    return place


@_in
def on_edge(S: System, i: int, edge: int, a: float) -> tuple[float, float]:
    """Return x and y of place ``a`` on an edge of scale i."""
    if edge == 0:
        return S.shapes[i, ETA], a
    if edge == 1:
        return a, -S.shapes[i, BETA]
    if edge == 2:
        return a, S.shapes[i, BETA]
    return 0.0 * a, a


@_in
def corner(S: System, i: int, v: int) -> tuple[float, float]:
    """Return x and y of corner v of scale i: C, B at the tip, D, A at the base."""
    x = S.shapes[i, ETA] if v < 2 else 0.0 * S.shapes[i, ETA]
    return x, -S.shapes[i, BETA] if v % 2 == 0 else S.shapes[i, BETA]


@_jit
def spots(S: System, c: Array, s: Array) -> tuple[float, float, float, float]:
    """Return x, y of a contact on its first scale and on its other scale."""
    i, j, kind = c[touch.FIRST], partner(S, c), c[touch.KIND]
    if kind == touch.EE:
        x1, y1 = on_edge(S, i, c[touch.ONE], s[0])
        x2, y2 = on_edge(S, j, c[touch.OTHER], s[1])
    elif kind == touch.VF:
        x1, y1 = corner(S, i, c[touch.ONE])
        x2, y2 = s[0], s[1]
    elif kind == touch.FV:
        x2, y2 = corner(S, j, c[touch.OTHER])
        x1, y1 = s[0], s[1]
    elif kind == touch.EF:
        x1, y1 = on_edge(S, i, c[touch.ONE], s[2])
        x2, y2 = s[0], s[1]
    else:
        x2, y2 = on_edge(S, j, c[touch.OTHER], s[2])
        x1, y1 = s[0], s[1]
    return x1, y1, x2, y2


@_jit
def layout(S: System, con: Array, m: int, at: Array) -> tuple[int, int]:
    """Write the first unknown of each scale, contact and load of a tie into ``at`` (N + C + K,).

    A scale's unknowns come after its cell's own strains and before those of the contacts of which it is the first
    scale, and of the ties at home there; those of the whole beam come last. Returned are the number of unknowns, and
    how many come before the last ones.
    """
    n, N, first, K = 0, len(S.shapes), ahead(S), borders(S)
    for i in range(N):
        at[i] = freedoms(S)
    ties = at[len(at) - K :]
    for k in range(K):
        # below 0 until the unknown is known
        ties[k] = -2 - home(S, k)
    for c in range(m):
        at[N + c] = at[con[c, touch.FIRST]]
        # its force and places, or the moment of the substrate
        at[con[c, touch.FIRST]] += 1 if con[c, touch.KIND] == touch.LIES else 3 + places_of(con[c, touch.KIND])
    for i in range(N):
        n += first if i % S.stride == 0 else 0
        size = at[i]
        at[i] = n
        n += size
        for k in range(K if (i + 1) % S.stride == 0 else 0):
            if ties[k] == -2 - i // S.stride:
                ties[k] = n
                n += 1
    for c in range(m):
        at[N + c] += at[con[c, touch.FIRST]]
    inner = n
    for k in range(K):
        if ties[k] < 0:
            ties[k] = n
            n += 1
    return n, inner


@_jit
def strain_columns(S: System, at: Array, n: int, i: int) -> tuple[int, int, int, int]:
    """Return the unknown, of n, of each strain of scale i's cell; -1 for imposed strains."""
    last, psi, phi, chi, eps = at[i - i % S.stride] if S.own else n, -1, -1, -1, -1
    if S.free[EPS] > 0:
        last -= 1
        eps = last
    if S.free[CHI] > 0:
        last -= 1
        chi = last
    if S.free[PHI] > 0:
        last -= 1
        phi = last
    if S.free[PSI] > 0:
        psi = last - 1
    return psi, phi, chi, eps

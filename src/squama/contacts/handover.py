"""Changes of single contacts: adding, removing, and replacing by a contact of other features; compiled."""

from __future__ import annotations

import math

from squama.batch.keeping import part as _jit
from squama.contacts import touch
from squama.contacts.conditions import FLAT, beside_it
from squama.contacts.detection import known, vertices
from squama.contacts.geometry import put, vector
from squama.contacts.increments import Walk, number
from squama.contacts.meeting import meet
from squama.contacts.system import BETA, ETA, MU, State, copy, partner, spots
from squama.contacts.touch import corner_at, lengthwise
from squama.contacts.vectors import dot
from squama.types import Array

_CLOSE = 1e-6
"""Distance, as a share of the plates, and difference of normals, of two vertices at one place."""
_DOUBLED = 1e-3
"""Distance, as a share of the plates, below which a contact that comes in shares the place of another one."""
_WIDER, _WIDEST = 2.0, 0.2
"""Factor that widens the window of an edge along a face if two contacts in it have no equilibrium, and its limit."""


@_jit
def apart(w: Walk, st: State, c: int, v: Array) -> float:
    """Return the distance of a vertex from a contact, summed over both scales."""
    k = w.W.vertex
    for a in range(5):
        k[a] = int(v[a])
    x1, y1, x2, y2 = spots(w.S, w.con[c], st.s[c])
    X1, Y1, X2, Y2 = spots(w.S, k, v[touch.AT :])
    return abs(X1 - x1) + abs(Y1 - y1) + abs(X2 - x2) + abs(Y2 - y2)


@_jit
def drop(w: Walk, st: State, c: int) -> None:
    """Remove a contact."""
    m = w.counts[0] - 1
    for a in range(c, m):
        copy(w.con[a + 1], w.con[a])
        copy(st.F[a + 1], st.F[a])
        copy(st.s[a + 1], st.s[a])
        copy(w.past.F[a + 1], w.past.F[a])
        copy(w.W.told[a + 1], w.W.told[a])
    w.counts[0], w.J.kept[0] = m, 0


@_jit
def every(w: Walk, how: int) -> None:
    """Let all contacts stick (1), slide (0) or be smooth (SMOOTH), except those that are let go of."""
    for c in range(w.counts[0]):
        if w.con[c, touch.STUCK] != touch.LET_GO:
            w.con[c, touch.STUCK] = how


@_jit
def any_let_go(w: Walk) -> bool:
    """Return whether some contacts are let go of."""
    found = False
    for c in range(w.counts[0]):
        found = found or w.con[c, touch.STUCK] == touch.LET_GO
    return found


@_jit
def add_contact(w: Walk, st: State, row: Array) -> bool:
    """Add a vertex as a contact without force; False if there is no room."""
    m = w.counts[0]
    if m == len(w.con):
        return False
    for a in range(touch.FIRST, touch.STUCK):
        w.con[m, a] = int(row[a])
    w.con[m, touch.STUCK], w.con[m, touch.ENDED] = 1 if w.S.shapes[0, MU].real > 0.0 else 0, 0
    if any_let_go(w):
        # its slip in the meantime is unknown
        w.con[m, touch.STUCK] = touch.SMOOTH
    for a in range(3):
        st.F[m, a] = w.past.F[m, a] = 0.0
        st.s[m, a] = row[touch.AT + a]
    w.counts[0], w.J.kept[0] = m + 1, 0
    return True


@_jit
def exchange(w: Walk, st: State, c: int, kind: int, one: int, other: int, a: float, b: float, d: float) -> None:
    """Give a contact other features at the same place; its force is kept."""
    w.con[c, touch.KIND], w.con[c, touch.ONE], w.con[c, touch.OTHER] = kind, one, other
    st.s[c, 0], st.s[c, 1], st.s[c, 2] = a, b, d
    w.J.kept[0] = 0


@_jit
def become(w: Walk, st: State, c: int, v: Array) -> None:
    """Give a contact the features and places of a vertex; its force is kept."""
    a = touch.AT
    exchange(w, st, c, int(v[touch.KIND]), int(v[touch.ONE]), int(v[touch.OTHER]), v[a], v[a + 1], v[a + 2])


@_jit
def roll(w: Walk, st: State, c: int, edge: int) -> None:
    """Replace a contact by the edge that dips beside it and lies along the face (+ 4: an edge of the other scale).

    An edge that lies flush has no tangent place: the contact is kept.
    """
    S, row = w.S, w.con[c]
    least, most = beside_it(w, st, c, edge)
    if max(-least, most) < FLAT:
        row[touch.ENDED] = touch.FLUSH
        return
    row[touch.ENDED] = 0
    x1, y1, x2, y2 = spots(S, row, st.s[c])
    if edge < 4:
        exchange(w, st, c, touch.EF, edge, edge, x2, y2, x1 if lengthwise(edge) else y1)
    else:
        exchange(w, st, c, touch.FE, edge - 4, edge - 4, x1, y1, x2 if lengthwise(edge - 4) else y2)


@_jit
def leave(w: Walk, st: State, c: int, which: int) -> bool:
    """Replace an edge along a face by its corner, or by the face's edge; False if that is not continuous."""
    row, s = w.con[c], st.s[c]
    kind = row[touch.KIND]
    if kind < touch.EF:
        return False
    own = row[touch.ONE] if kind == touch.EF else row[touch.OTHER]
    if which >= 4:
        v = corner_at(own, which == 5)
        if kind == touch.EF:
            exchange(w, st, c, touch.VF, v, 0, s[0], s[1], 0.0)
        else:
            exchange(w, st, c, touch.FV, 0, v, s[0], s[1], 0.0)
        return True
    edge = 3 if which == 0 else (0 if which == 1 else (1 if which == 2 else 2))
    at = s[1] if which < 2 else s[0]
    if kind == touch.EF:
        exchange(w, st, c, touch.EE, own, edge, s[2], at, 0.0)
    else:
        exchange(w, st, c, touch.EE, edge, own, at, s[2], 0.0)
    return True


@_jit
def succeed(w: Walk, st: State, c: int) -> bool:
    """Replace a contact that left its edge by a vertex at the same place, with its force; False if there is none."""
    S, row = w.S, w.con[c]
    i, apart, kind, one, other = row[touch.FIRST], row[touch.APART], row[touch.KIND], row[touch.ONE], row[touch.OTHER]
    x1, y1, x2, y2 = spots(S, row, st.s[c])
    F = vector(st.F[c], 0)
    drop(w, st, c)
    n = vertices(S, st, w.W, i, apart, 1e-3, w.found, 0)
    best, least, k = -1, 0.1, w.W.vertex
    for a in range(n):
        # known() writes the vertex's row to k
        if known(S, st, w.con, w.counts[0], w.found[a], w.W):
            continue
        if k[touch.KIND] == kind and k[touch.ONE] == one and k[touch.OTHER] == other:
            continue
        X1, Y1, X2, Y2 = spots(S, k, w.found[a, touch.AT :])
        far = abs(X1 - x1) + abs(Y1 - y1) + abs(X2 - x2) + abs(Y2 - y2)
        if far < least:
            best, least = a, far
    if best < 0 or not add_contact(w, st, w.found[best]):
        return False
    put(F, st.F[w.counts[0] - 1], 0)
    return True


@_jit
def merged(w: Walk, ends: bool) -> bool:
    """Merge the last added contact with another of its pair, near it on an edge that lies along a face.

    Such an edge may be pressed at two places or, with ``ends``, beside its end: if both have no equilibrium they act as
    one.
    """
    c = w.counts[0] - 1
    for o in range(c if waiting(w) else 0):
        a, b = w.con[o], w.con[c]
        along = max(a[touch.KIND], b[touch.KIND]) >= touch.EF if ends else a[touch.KIND] >= touch.EF
        if along and (ends or number(a) == number(b)) and beside(w, o, c) < _WIDEST:
            while w.W.window[0] <= beside(w, o, c):
                w.W.window[0] *= _WIDER
            drop(w, w.now, c)
            return True
    return False


@_jit
def doubled(w: Walk) -> int:
    """Return the contact at whose place the last added one is, still without force; -1 if there is none."""
    c = w.counts[0] - 1
    for o in range(c if waiting(w) else 0):
        if beside(w, o, c) < _DOUBLED:
            return o
    return -1


@_jit
def waiting(w: Walk) -> bool:
    """Return whether the last added contact is still without force."""
    c = w.counts[0] - 1
    if c < 0 or w.con[c, touch.KIND] == touch.LIES:
        return False
    F = vector(w.now.F[c], 0)
    return bool(F[0] == 0.0 and F[1] == 0.0 and F[2] == 0.0)


@_jit
def beside(w: Walk, o: int, c: int) -> float:
    """Return the distance of two contacts as a share of the plates' sizes; infinite between different pairs."""
    S, far, a, b = w.S, 0.0, w.con[o], w.con[c]
    if a[touch.KIND] == touch.LIES or a[touch.FIRST] != b[touch.FIRST] or a[touch.APART] != b[touch.APART]:
        return math.inf
    i, j = b[touch.FIRST], partner(S, b)
    sizes = (S.shapes[i, ETA], 2 * S.shapes[i, BETA], S.shapes[j, ETA], 2 * S.shapes[j, BETA])
    for a, b, size in zip(spots(S, w.con[o], w.now.s[o]), spots(S, w.con[c], w.now.s[c]), sizes):  # noqa: B905
        far = max(far, abs(a - b) / size.real)
    return far


@_jit
def successor(w: Walk, st: State, c: int) -> None:
    """Write to ``w.best`` the vertex at a contact's place with the same normal; its kind is -1 if there is none.

    When a corner of a plate that lies along another one leaves the face, two edges begin to cross there.
    """
    S, m, v = w.S, w.counts[0], w.best
    v[touch.KIND] = -1.0
    if m == len(w.con):
        return
    n, row = vertices(S, st, w.W, w.con[c, touch.FIRST], w.con[c, touch.APART], _CLOSE, w.found, 0), w.con[m]
    normal = meet(S, st, w.con[c], st.s[c], w.W).n
    for a in range(n):
        copy(w.found[a], v)
        there = False
        for o in range(5):
            row[o] = int(v[o])
        for o in range(3):
            st.s[m, o] = v[touch.AT + o]
        for o in range(m):
            there = there or number(w.con[o]) == number(row)
        if not there and beside(w, c, m) < _CLOSE and dot(normal, meet(S, st, row, st.s[m], w.W).n) > 1 - _CLOSE:
            return
    v[touch.KIND] = -1.0

"""State of a row from that of the endless beam at the same load, by Newton's method without a path; compiled.

All cells start with the endless beam's state; contacts beyond the ends are left out, and the equilibrium of the others
is solved for. Slips are counted from the engagement of the endless beam.
"""

from __future__ import annotations

from squama.batch.keeping import part as _jit
from squama.contacts import touch
from squama.contacts.increments import CONTACT, Walk
from squama.contacts.meeting import N_, prepared
from squama.contacts.newton import solve
from squama.contacts.supports import GIVEN, LOADS
from squama.contacts.system import MOTIONS, POWERS, STRAINS, TILT, cells, row_of
from squama.contacts.touch import unknown
from squama.contacts.works import remember
from squama.types import Array

_CELL = MOTIONS + STRAINS + POWERS
_TRIES = 4
"""Number of times that pulling contacts are removed."""


def size(contacts: int, faces: int = 1) -> int:
    """Return the length of an endless beam's data: its states at engagement and now, and its contacts now.

    Motions, strains and plate coefficients of both, for each face; M, T, B, P; number of contacts, and each contact
    (16,).
    """
    return 2 * faces * _CELL + STRAINS + 1 + CONTACT * contacts


@_jit
def _laid(w: Walk, given: Array, at: int) -> None:
    """Copy the state of one cell to all cells."""
    st = w.now
    for i in range(len(st.q)):
        o = at + _CELL * (i % w.S.stride)
        for a in range(MOTIONS):
            st.q[i, a] = given[o + a]
        st.q[i, TILT] = 0.0
        for e in range(STRAINS):
            st.strains[row_of(w.S, i), e] = given[o + MOTIONS + e]
        for a in range(POWERS):
            st.b[i, a] = given[o + MOTIONS + STRAINS + a]


@_jit
def _touched(w: Walk, given: Array, at: int) -> None:
    """Copy the contacts of one cell to all cells, except those that would reach beyond the ends."""
    N, n = cells(w.S), 0
    for i in range(N):
        for c in range(int(given[at])):
            o, row, s = at + 1 + CONTACT * c, w.con[n], w.now.s[n]
            if i + int(given[o + touch.APART]) >= N:
                continue
            scale = i * w.S.stride + int(given[o + touch.FIRST])
            for a in range(touch.ENDED):
                row[a] = int(given[o + a])
            row[touch.FIRST], row[touch.STUCK], row[touch.ENDED] = scale, 0, 0
            for a, place in enumerate(unknown(row[touch.KIND], row[touch.ONE], row[touch.OTHER])):
                if place >= 0:
                    s[place] = given[o + 6 + a]
            for a in range(3):
                w.now.F[n, a] = given[o + 10 + a]
            n += 1
    w.counts[0] = n


@_jit
def _let_go(w: Walk) -> bool:
    """Remove contacts that pull; return whether there were any."""
    kept = 0
    m: int = w.counts[0]
    for c in range(m):
        if w.W.told[c, N_] < 0.0:
            continue
        for a in range(w.con.shape[1]):
            w.con[kept, a] = w.con[c, a]
        for a in range(3):
            w.now.F[kept, a], w.now.s[kept, a] = w.now.F[c, a], w.now.s[c, a]
        kept += 1
    w.counts[0], w.J.kept[0] = kept, 0
    return kept < m


@_jit
def from_endless(w: Walk, given: Array) -> bool:
    """Solve for the state of a row whose cells have their own strains; return whether one was found.

    ``given``: data of the endless beam, see :func:`size`; the loads reach as far as its.
    """
    S, now = w.S, _CELL * w.S.stride
    _laid(w, given, 0)
    prepared(S, w.now, w.con, 0, True, w.W)
    # without contacts the plates have no deflection
    _laid(w, given, 0)
    remember(w)
    w.past.weights[0], w.past.weights[1], w.past.weights[2] = 1.0, -1.0, 0.0
    _laid(w, given, now)
    _touched(w, given, 2 * now + STRAINS)
    for k in range(len(S.ties.course)):
        e = int(S.ties.course[k, 0])
        if e >= 0:
            w.now.ties[GIVEN, k] = given[now + MOTIONS + e]
            w.now.ties[LOADS, k] = given[2 * now + e] * (S.ties.course[k, 1] / cells(S))
    for _ in range(_TRIES):
        if not solve(S, w.now, w.past, w.con, w.counts[0], w.W, w.J, w.loads):
            return False
        if not _let_go(w):
            return True
    return False

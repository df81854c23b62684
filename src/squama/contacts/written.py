"""What is written of the states of a path; compiled."""

from __future__ import annotations

from squama.batch.keeping import part as _jit
from squama.contacts.increments import (
    LINE,
    T_GRIPS,
    T_LOAD,
    T_LOST,
    T_ONSET,
    T_RUBBED,
    T_SINCE,
    T_SLID,
    T_SLID_OTHER,
    T_WAY,
    T_WORK,
    Walk,
    strain,
)
from squama.contacts.meeting import F_, N_
from squama.contacts.supports import LOADS
from squama.contacts.system import ENDED, KIND, LIES, MOTIONS, STRAINS, STUCK, copy, spots
from squama.contacts.works import energy
from squama.types import Array


@_jit
def write(w: Walk, row: Array, motions: Array, bends: Array, contacts: Array) -> None:
    """Write the last state: way, strains, loads, works, contacts and what is told of them, energy, work per way.

    Motions (N, 6) and deflections (N, 24) are of each scale; where cells have strains of their own those, and what each
    cell carries, follow the motions (N, 14); loads of ties follow what is told else, as far as there is room.
    """
    t, S = w.tally, w.S
    row[0] = t[T_WAY]
    for e in range(STRAINS):
        row[1 + e], row[5 + e] = strain(w.now, e), w.loads[e]
    m, mode, N, f = w.counts[0], 0, 0.0, 0.0
    for c in range(m):
        if w.con[c, KIND] == LIES:
            continue
        N += w.W.told[c, N_]
        f += w.W.told[c, F_]
        if c == 0 or w.con[c, STUCK] == 0:
            mode = 2 if w.con[c, STUCK] > 0 else 1
    row[9], row[10], row[11], row[12], row[13], row[14], row[15] = t[T_WORK], t[T_RUBBED], t[T_LOST], m, mode, N, f
    row[16], row[17], row[18], row[19] = t[T_SLID], t[T_ONSET], t[T_SINCE], energy(w, w.now) + t[T_GRIPS]
    row[20], row[21] = t[T_LOAD], t[T_SLID_OTHER]
    for o in range(min(w.now.ties.shape[1], len(row) - LINE)):
        row[LINE + o] = w.now.ties[LOADS, o]
    for c in range(min(m, len(contacts))):
        out = contacts[c]
        for a in range(ENDED):
            out[a] = w.con[c, a]
        if w.con[c, KIND] != LIES:
            out[6], out[7], out[8], out[9] = spots(S, w.con[c], w.now.s[c])
        for a in range(3):
            out[10 + a] = w.now.F[c, a]
        out[13], out[14], out[15] = w.W.told[c, N_], w.W.told[c, F_], w.now.s[c, 2]
    copy(w.now.b, bends)
    if not S.own:
        copy(w.now.q, motions)
        return
    for i in range(len(motions)):
        for a in range(MOTIONS):
            motions[i, a] = w.now.q[i, a]
        for e in range(STRAINS):
            motions[i, MOTIONS + e], motions[i, MOTIONS + STRAINS + e] = w.now.strains[i, e], w.W.carried[i, e]

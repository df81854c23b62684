"""Output of the states of a path; compiled."""

from __future__ import annotations

from squama.batch.keeping import part as _jit
from squama.contacts import tally, touch
from squama.contacts.increments import LINE, Walk, Written, strain
from squama.contacts.meeting import F_, N_
from squama.contacts.supports import LOADS
from squama.contacts.system import MOTIONS, STRAINS, TILT, copy, row_of, spots
from squama.contacts.works import energy


@_jit
def write(w: Walk, written: Written, i: int) -> None:
    """Write the last state as number i: way, strains, loads, works, sums over contacts, energy, work per way.

    Motions (N, 6) and deflections (N, 24) are of each scale; if cells have their own strains, these and the loads of
    each cell and the scale's tilt follow the motions (N, 15); loads of ties come last, as far as there is room.
    """
    t, S, row, motions, contacts = w.tally, w.S, written.rows[i], written.motions[i], written.contacts[i]
    row[0] = t[tally.WAY]
    for e in range(STRAINS):
        row[1 + e], row[5 + e] = strain(w.now, e), w.loads[e]
    m, mode, N, f = w.counts[0], 0, 0.0, 0.0
    for c in range(m):
        if w.con[c, touch.KIND] == touch.LIES:
            continue
        N += w.W.told[c, N_]
        f += w.W.told[c, F_]
        if c == 0 or w.con[c, touch.STUCK] == 0:
            mode = 2 if w.con[c, touch.STUCK] > 0 else 1
    row[9], row[10], row[11], row[12], row[13] = t[tally.WORK], t[tally.RUBBED], t[tally.LOST], m, mode
    row[14], row[15], row[16], row[17] = N, f, t[tally.SLID], t[tally.ONSET]
    row[18], row[19] = t[tally.SINCE], energy(w, w.now) + t[tally.GRIPS]
    row[20], row[21] = t[tally.LOAD], t[tally.SLID_OTHER]
    for o in range(min(w.now.ties.shape[1], len(row) - LINE)):
        row[LINE + o] = w.now.ties[LOADS, o]
    for c in range(min(m, len(contacts))):
        out = contacts[c]
        for a in range(touch.ENDED):
            out[a] = w.con[c, a]
        if w.con[c, touch.KIND] != touch.LIES:
            out[6], out[7], out[8], out[9] = spots(S, w.con[c], w.now.s[c])
        for a in range(3):
            out[10 + a] = w.now.F[c, a]
        out[13], out[14], out[15] = w.W.told[c, N_], w.W.told[c, F_], w.now.s[c, 2]
    copy(w.now.b, written.bends[i])
    if not S.own:
        copy(w.now.q, motions)
        return
    for o in range(len(motions)):
        for a in range(MOTIONS):
            motions[o, a] = w.now.q[o, a]
        for e in range(STRAINS):
            motions[o, MOTIONS + e], motions[o, MOTIONS + STRAINS + e] = (
                w.now.strains[row_of(S, o), e],
                w.W.carried[row_of(S, o), e],
            )
        motions[o, MOTIONS + 2 * STRAINS] = w.now.q[o, TILT]

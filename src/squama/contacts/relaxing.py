"""The way to rest behind a path that is unstable: scales creep there, held back less and less; compiled.

Springs in proportion to the joints' own stiffness hold all motions and free strains where they are. Each state with
such springs is near the last one and has less energy; then they are anchored anew. So a jump ends where the bar would
come to rest if it moved slowly, wherever that is.
"""

from __future__ import annotations

from squama.batch.keeping import part as _jit
from squama.contacts import increments, tally
from squama.contacts.changes import regroup
from squama.contacts.increments import Walk, guess, keep, restore, tell
from squama.contacts.system import MOTIONS, STRAINS, cells, row_of
from squama.contacts.works import SNAPS, accept, rounded, worked
from squama.types import Array

_FIRST, _STIFFEST, _SOFT = 100.0, 1e6, 0.1
"""Stiffness of the springs over the joints' own: first, where the search is given up, below which rest is tried."""
_SOFTER, _STIFFER, _STATES = 3.0, 10.0, 80
"""By how much springs get softer after a state that was found, and stiffer after one that was not; states at most."""
_STEP, _FARTHEST, _STAYS = 1e-7, 1e-3, 1e-13
"""Ways on which the search begins, from the first to the last, and that of later states: none."""


@_jit
def anchored(w: Walk, stiffness: float) -> None:
    """Hold motions and free strains where they are by springs of a stiffness over the joints' own; 0 lets go."""
    hold, now = w.W.hold, w.now
    w.J.kept[0], w.W.stiffness[0] = 0, stiffness
    for i in range(len(now.q)):
        for a in range(MOTIONS):
            hold[i, a] = now.q[i, a]
        for e in range(STRAINS):
            hold[i, MOTIONS + e] = now.strains[row_of(w.S, i), e]


@_jit
def crept(w: Walk, h: float, stiffness: float) -> int:
    """Go on to the state that springs of a stiffness allow; return why not, 0 if it did."""
    keep(w)
    anchored(w, stiffness)
    w.tally[tally.FRESH] = 0.0
    guess(w, h)
    code = regroup(w, h, False)
    w.W.stiffness[0], w.J.kept[0] = 0.0, 0
    if code == 0:
        accept(w, h, True, worked(w, h))
    else:
        restore(w)
    return code


@_jit
def relaxed(w: Walk, goal: float, events: Array) -> int:
    """Go on to where all scales of a row come to rest, as a snap; return why not, 0 if they did."""
    t = w.tally
    before, work, rubbed = t[tally.ENERGY], t[tally.WORK], t[tally.RUBBED]
    slid, other, grips = t[tally.SLID], t[tally.SLID_OTHER], t[tally.GRIPS]
    left, stiffness, code = goal - t[tally.WAY].real, _FIRST, increments.NO_EQUILIBRIUM
    h = min(_STEP, left)
    for _ in range(_STATES):
        if stiffness < _SOFT:
            code = crept(w, h, 0.0)
            if code == 0:
                break
        code = crept(w, h, stiffness)
        if code == 0:
            h, stiffness, code = _STAYS, stiffness / _SOFTER, increments.NO_EQUILIBRIUM
        elif h > _STAYS and h < min(_FARTHEST, left):
            # what is nearly in touch is told apart a little farther on
            h = min(10 * h, left)
        else:
            stiffness *= _STIFFER
            if stiffness > _STIFFEST:
                break
    if code != 0:
        return code
    lost = before + (t[tally.WORK] - work) * cells(w.S) - t[tally.ENERGY] + grips
    t[tally.RUBBED], t[tally.SLID], t[tally.SLID_OTHER], t[tally.GRIPS] = rubbed, slid, other, 0.0
    t[tally.LOST] += lost
    tell(w, events, increments.SNAP if lost > SNAPS * max(before, rounded(w)) else increments.CHANGE, -1, lost)
    t[tally.SINCE], t[tally.JUMPED], t[tally.H] = t[tally.WAY], 0.0, _STEP
    return 0

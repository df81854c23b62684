"""What a contact is written as: columns of its row of whole numbers, kinds of contact, how it bears."""

from __future__ import annotations

FIRST, APART, KIND, ONE, OTHER, STUCK, ENDED = range(7)
"""Columns of a contact: scale, how many scales further the other is, kind, features of both, whether it sticks (1;
slides: 0; is taken as smooth: SMOOTH; is let go of, its force given: LET_GO), and whether it stands for an edge that is
tangent to the face nowhere any more: for this increment, or as it lies flush."""
FLUSH, SMOOTH, LET_GO = 2, -1, -2
EE, VF, FV, EF, FE, LIES = range(6)
"""Kinds of contact; the last one is that of a scale that lies on the substrate: a moment that lifts it, no places."""
GAP, AT, VERTEX = 5, 6, 9
"""Columns of a vertex after the first five of a contact: its gap, and its places (3); how many there are."""

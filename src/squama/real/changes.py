"""What ends a contact, or hands it over to another one; compiled."""

from __future__ import annotations

from squama.model.elastic_plate import SIDE_A, SIDE_D, TIP
from squama.real.contact import AT, FORCE, LAST, NEW, NORMAL, PHI, POWERS, STRETCH, Step, held
from squama.real.design import MOTIONS, Design, _in, _jit
from squama.real.faces import others, tilt, tip_over
from squama.real.features import CORNERS, FACE, compliances, high, low, on_face, rolls, shape
from squama.real.start import meeting
from squama.real.steps import solve
from squama.contacts.vectors import copy
from squama.types import Array

RANGE, OFF_FIRST, OFF_SECOND, OTHER, STOPPED, PARTED, TURNS, LIES = range(8)
"""Ends by number; TURNS and LIES are none: a smaller step, a tip edge that comes to lie on a face."""
_UNEVEN = -3e-3
"""Depth, in pitches, up to which a tip edge may dip into the face beside where it touches and is one contact."""


@_jit
def beyond(d: Design, s: Array, room: Array, b: Array, look: bool) -> tuple[int, int, int]:
    """Return why a state is no longer of this one contact: end, edge, neighbour; -1 if it is."""
    x, y = s[AT], s[AT + 1]
    if on_face(d):
        if not (0.0 <= x <= d.eta and abs(y) <= d.beta):
            return OFF_SECOND, d.second, d.k
        if rolls(d) and abs(s[AT + 2]) > d.beta:
            return OFF_FIRST, d.first, d.k
    elif not low(d, d.first) <= x <= high(d, d.first):
        return OFF_FIRST, d.first, d.k
    elif not low(d, d.second) <= y <= high(d, d.second):
        return OFF_SECOND, d.second, d.k
    tip = d.bent and tipped(d)
    if look or tip:
        shape(d, x, y, s[AT + 2], s[MOTIONS + 3], s[MOTIONS + 4], room[POWERS], b, 0)
    if tip and not rolls(d):
        x, y, along = tip_on(d, s)
        # from there on the edge goes towards B over the face
        way = 1.0 if d.second == SIDE_D or d.first == CORNERS else -1.0
        if way * tilt(d, s, s[PHI], s[STRETCH], b, x, y, along) > 0.0:
            return LIES, TIP, d.k
    if look:
        deep, edge, k = others(d, s, s[PHI], s[STRETCH], b)
        if tip and edge == TIP and k == d.k and deep > _UNEVEN:
            return -1, -1, 0
        if edge >= 0:
            return OTHER, edge, k
    return -1, -1, 0


@_in
def tipped(d: Design) -> bool:
    """Say whether the tip edge, or a corner of it, lies on the other scale's face or on a side edge of that."""
    return d.second in (SIDE_D, SIDE_A, FACE) and (d.first == TIP or CORNERS <= d.first < CORNERS + 2)


@_in
def tip_on(d: Design, s: Array) -> tuple[float, float, float]:
    """Return where such a contact is: two places on the face, and that along the tip edge."""
    if d.second != FACE:
        return s[AT + 1], -d.beta if d.second == SIDE_D else d.beta, s[AT]
    if d.first == TIP:
        return s[AT], s[AT + 1], s[AT + 2]
    return s[AT], s[AT + 1], -d.beta if d.first == CORNERS else d.beta


@_in
def taken(d: Design, s: Array, stuck: bool) -> None:
    """Write the contact's own unknowns of a state: places and N of one that slips, the force of one that sticks."""
    m = MOTIONS
    if rolls(d):
        s[held(d)] = s[AT + 2]
    if stuck:
        copy(s[FORCE : FORCE + 3], s[m:])
    else:
        s[m], s[m + 1], s[m + 2] = s[AT], s[AT + 1], s[NORMAL]


@_jit
def handed(
    d: Design, code: int, k: int, room: Array, J: Array, order: Array, b: Array
) -> tuple[Design, bool]:  # fmt: skip
    """Return the design with the contact to which one of a tip edge hands over, its state the last one.

    A tip edge that comes to lie on the face does so where it touches; it is tangent there, or flush, and its force goes
    along it, to a corner, on which it rests then, or to a side edge, over which it runs then. A corner goes over the
    side edge beside which the tip edge lies, and comes back so. All else is an end: False.
    """
    s, new = room[LAST], room[NEW]
    if not (d.bent and d.k == k and tipped(d)):
        return d, False
    x, y, along = tip_on(d, s)
    _, toward, ahead = tip_on(d, new)
    first, second, side = TIP, FACE, 0.0
    if code == OFF_FIRST and (d.second == FACE or (along > 0.0) == (d.second == SIDE_A)):
        first, along = (CORNERS + 1, d.beta) if ahead > 0.0 else (CORNERS, -d.beta)
    elif code == OFF_SECOND and d.second == FACE and (rolls(d) or (toward > 0.0) == (along > 0.0)):
        second, side = (SIDE_A, d.beta) if toward > 0.0 else (SIDE_D, -d.beta)
        if abs(toward) <= d.beta:
            return d, False
    elif code != LIES:
        return d, False
    if rolls(d):
        # a flush edge bears anywhere, so that its force may leap
        shape(d, x, y, s[AT + 2], s[MOTIONS + 3], s[MOTIONS + 4], room[POWERS], b, 0)
        x, y, along = tip_over(d, s, s[PHI], s[STRETCH], b, along, side)
    d = meeting(d, first, second, k)
    s[AT], s[AT + 1], s[AT + 2] = (x, y, along) if second == FACE else (along, x, 0.0)
    if d.elastic and second != FACE:
        compliances(d)
    taken(d, s, True)
    copy(s, new)
    found, _ = solve(d, s[PHI], Step(True, 1.0, -1.0, 0.0, 1.0), room, J, order, False)
    copy(new, s)
    return d, found

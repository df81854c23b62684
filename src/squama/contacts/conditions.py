"""Conditions of an equilibrium with given contacts, and the condition violated most; compiled."""

from __future__ import annotations

import math

from squama.batch.keeping import part as _jit
from squama.contacts import touch
from squama.contacts.detection import covers, deepest, over, vertices, view
from squama.contacts.geometry import back, vector
from squama.contacts.increments import Walk
from squama.contacts.meeting import MARGIN, N_, along_edges, inclination, meet
from squama.contacts.system import BETA, ELASTIC, ETA, MU, H, State, System, copy, high, low, on_edge, partner, spots
from squama.contacts.touch import lengthwise
from squama.contacts.vectors import cross, dot
from squama.types import Array

PULL, OFF, SLOPE, FLIP, MEET = range(5)
"""Conditions: no pulling force, place within its features, no dip of the gap, stick or slide, no further contact."""
LEAN, FAR = 6, 7
"""Conditions of the model: crossing edges press the first scale from below, not from its side; motions of joints within
:data:`MOST`. 5 is a snap (:data:`squama.contacts.increments.LOST`)."""
MOST = 1.0
"""Rotation (rad) and displacement (pitches) of a scale in its joint, up to which the joint is taken for linear."""
MISSED_GAP, MISSED_PULL, MISSED_PLACE, MISSED_CONE, MISSED_SLOPE = 1e-10, 1e-12, 1e-9, 1e-11, 1e-9
"""Tolerances of the conditions: gap, force, place, force beyond the cone of friction, slope of the gap."""
FLAT, _SHALLOW, _BESIDE = 1e-8, 1e-6, (0.01, 0.03, 0.1, 0.3)
"""Gap, in pitches, below which an edge lies flush; depth from which it is tangent again; sampled shares of the edge."""


@_jit
def beyond(S: System, st: State, c: Array, k: int) -> tuple[float, int]:
    """Return how far inside its features a contact's place is (negative outside), and the nearest limit, 0 to 5.

    Limits come in pairs: ends of its first place, of its second place, and of an edge that lies along a face.
    """
    kind, i, j, s = c[touch.KIND], c[touch.FIRST], partner(S, c), st.s[k]
    least, which = 1e9 + 0.0 * s[0], 0
    if kind == touch.LIES or c[touch.STUCK] == touch.LET_GO:
        return least, which
    if kind == touch.EE:
        one, other = c[touch.ONE], c[touch.OTHER]
        l0, h0, l1, h1 = low(S, i, one), high(S, i, one), low(S, j, other), high(S, j, other)
    else:
        face = j if kind in (touch.VF, touch.EF) else i
        l0, h0, l1, h1 = 0.0 * S.shapes[face, ETA], S.shapes[face, ETA], -S.shapes[face, BETA], S.shapes[face, BETA]
    for a, v in enumerate((s[0] - l0, h0 - s[0], s[1] - l1, h1 - s[1])):
        if v.real < least.real:
            least, which = v, a
    if kind >= touch.EF:
        own, e = (i, c[touch.ONE]) if kind == touch.EF else (j, c[touch.OTHER])
        for a, v in enumerate((s[2] - low(S, own, e), high(S, own, e) - s[2])):
            if v.real < least.real:
                least, which = v, 4 + a
    return least, which


@_jit
def slope(w: Walk, st: State, k: int) -> tuple[float, int]:
    """Return the least slope of the gap inwards along a contact's edges, and that edge (+ 4: of the other scale).

    For bent plates only.
    """
    S, c = w.S, w.con[k]
    i, j, kind = c[touch.FIRST], partner(S, c), c[touch.KIND]
    if kind >= touch.EF or c[touch.ENDED] == 1 or c[touch.STUCK] == touch.LET_GO or not S.shapes[i, ELASTIC].real > 0:
        return 1e9 + 0.0 * st.s[k, 0], -1
    one, other, g = c[touch.ONE], c[touch.OTHER], meet(S, st, c, st.s[k], w.W)
    n1, n2 = cross(g.tx1, g.ty1), cross(g.tx2, g.ty2)
    P, E1, E2 = w.W.pairs[i, c[touch.APART] - 1], w.W.E[i], w.W.E[j]
    if kind == touch.EE:
        t1, t2 = along_edges(c, g)
        inner = back(E2, back(P, t1))
        v = inner[1] if lengthwise(other) else inner[0]
        first = dot(t1, n2) * (1.0 if v.real > 0 else -1.0) * (1.0 if other in (1, 3) else -1.0)
        inner = back(E1, t2)
        v = inner[1] if lengthwise(one) else inner[0]
        second = -dot(t2, n1) * (1.0 if v.real > 0 else -1.0) * (1.0 if one in (1, 3) else -1.0)
        return (first, one) if first.real <= second.real else (second, 4 + other)
    v = one if kind == touch.VF else other
    sy, sx = (1.0 if v % 2 == 0 else -1.0), (-1.0 if v < 2 else 1.0)
    if kind == touch.VF:
        a, b = sy * dot(g.ty1, n2), sx * dot(g.tx1, n2)
    else:
        a, b = -sy * dot(g.ty2, n1), -sx * dot(g.tx2, n1)
    end, side = (0 if v < 2 else 3), (1 if v % 2 == 0 else 2)
    o = 0 if kind == touch.VF else 4
    return (a, o + end) if a.real <= b.real else (b, o + side)


@_jit
def dips(w: Walk, st: State, k: int) -> tuple[float, int]:
    """Return the slope and edge of :func:`slope`: negative where the edge lies deeper beside the contact.

    An edge that lies flush dips only if it is deep enough for its tangent place to be found.
    """
    least, edge = slope(w, st, k)
    if least.real < 0.0 and w.con[k, touch.ENDED] == touch.FLUSH:
        least = _SHALLOW + beside_it(w, st, k, edge)[0] + 0.0 * least
    return least, edge


@_jit
def beside_it(w: Walk, st: State, k: int, edge: int) -> tuple[float, float]:
    """Return the least and the largest gap along an edge beside a contact, at a few places over the face.

    0 and infinite if no such place is over the face.
    """
    S, c = w.S, w.con[k]
    i, j, upper, e = c[touch.FIRST], partner(S, c), edge >= 4, edge % 4
    own, other = (j, i) if upper else (i, j)
    x1, y1, x2, y2 = spots(S, c, st.s[k])
    at = (x2 if lengthwise(e) else y2) if upper else (x1 if lengthwise(e) else y1)
    v, begin, end, least, most, found = w.W.views[0], low(S, own, e), high(S, own, e), 0.0, 0.0, False
    view(w.W, i, j, c[touch.APART], upper, v)
    for part in _BESIDE:
        for sign in (-1.0, 1.0):
            s = at + sign * part * (end - begin)
            if begin.real <= s.real <= end.real:
                x, y = on_edge(S, own, e, s)
                p, gap = over(S, st, v, own, other, upper, x, y)
                if covers(S, other, p[0], p[1]):
                    least, most, found = min(least, gap.real), max(most, gap.real), True
    return least, most if found else math.inf


@_jit
def faced(w: Walk, st: State, k: int) -> float:
    """Return the cosine of the angle from the first scale's normal to a contact's, where edges cross.

    It is negative where side faces bear on each other.
    """
    c, cosine = w.con[k], 1.0 + 0.0 * st.s[k, 0]
    if c[touch.KIND] == touch.EE:
        g = meet(w.S, st, c, st.s[k], w.W)
        cosine = dot(cross(g.tx1, g.ty1), g.n)
    out: float = cosine
    return out


@_jit
def room(S: System, st: State) -> float:
    """Return how far the motions of joints are within :data:`MOST`: its square less the largest square."""
    least: float = MOST**2 + 0.0 * st.q[0, 0]
    for i in range(0 if len(S.masked) > 0 else len(st.q)):
        for a in (0, 3):
            v = vector(st.q[i], a)
            left = MOST**2 - dot(v, v)
            least = left if left.real < least.real else least
    return least


@_jit
def condition(w: Walk, st: State, what: int, c: int) -> float:
    """Return the value of a condition other than MEET at the state just solved for; negative if violated."""
    if what == LEAN:
        return faced(w, st, c)
    if what == FAR:
        return room(w.S, st)
    if what == PULL:
        pressed: float = w.W.told[c, N_]
        return pressed
    if what == OFF:
        return beyond(w.S, st, w.con[c], c)[0]
    if what == SLOPE:
        return dips(w, st, c)[0]
    margin: float = w.W.told[c, MARGIN]
    return -margin if w.con[c, touch.STUCK] > 0 else margin


@_jit
def value(w: Walk, st: State, what: int, c: int) -> float:
    """Return the value of a condition, or the gap of ``w.best``, at the state just solved for; below 0 if violated."""
    if what != MEET:
        return condition(w, st, what, c)
    if w.best[touch.KIND] == touch.LIES:
        return inclination(w.S, int(w.best[touch.FIRST]), w.W)
    # the vertex of the overlap, if it is there: one edge may be tangent at several places
    best, gap, least = w.best, math.nan, math.inf
    for a in range(vertices(w.S, st, w.W, int(best[touch.FIRST]), int(best[touch.APART]), 1e9, w.found, 0)):
        v, same = w.found[a], True
        for o in range(touch.KIND, touch.STUCK):
            same = same and v[o] == best[o]
        if same:
            far = abs(v[touch.AT] - best[touch.AT]) + abs(v[touch.AT + 1] - best[touch.AT + 1])
            if far < least:
                gap, least = v[touch.GAP], far
    return gap


@_jit
def violated(w: Walk, st: State, every: bool) -> tuple[int, int, float]:
    """Return the condition violated most at the state just solved for, its contact and value; -1 if none is.

    New contacts are searched between all scales with ``every``, else only between pairs marked before.
    """
    m, mu = w.counts[0], w.S.shapes[0, MU]
    what, which, worst = -1, -1, 0.0
    for c in range(m):
        v = w.W.told[c, N_]
        if v < -MISSED_PULL and v < worst:
            what, which, worst = PULL, c, v
    if what >= 0:
        return what, which, worst
    for c in range(m):
        v, _ = beyond(w.S, st, w.con[c], c)
        if v < -MISSED_PLACE and v < worst:
            what, which, worst = OFF, c, v
        v, _ = dips(w, st, c)
        if v < -MISSED_SLOPE and v < worst:
            what, which, worst = SLOPE, c, v
        if mu > 0.0:
            margin = w.W.told[c, MARGIN]
            v = -margin if w.con[c, touch.STUCK] > 0 else margin
            if v < -MISSED_CONE and v < worst:
                what, which, worst = FLIP, c, v
        v = faced(w, st, c)
        if v < -MISSED_SLOPE and v < worst:
            what, which, worst = LEAN, c, v
    v = room(w.S, st)
    if v < -MISSED_PLACE and v < worst:
        what, which, worst = FAR, -1, v
    if what >= 0:
        return what, which, worst
    a = deepest(w.S, st, w.con, m, w.W, -MISSED_GAP, w.near, every, w.found)
    if a >= 0:
        copy(w.found[a], w.best)
        return MEET, -1, w.found[a, touch.GAP]
    return lain(w)


@_jit
def lain(w: Walk) -> tuple[int, int, float]:
    """Return, as :func:`violated`, the scale turned farthest into the substrate."""
    worst, which = -MISSED_GAP, -1
    for i in range(len(w.S.rests)):
        theta = inclination(w.S, i, w.W)
        if theta < worst and not lying(w, i):
            worst, which = theta, i
    if which < 0:
        return -1, -1, 0.0
    for a in range(touch.VERTEX):
        w.best[a] = 0.0
    w.best[touch.FIRST], w.best[touch.KIND], w.best[touch.GAP] = which, touch.LIES, worst
    return MEET, -1, worst


@_jit
def lying(w: Walk, i: int) -> bool:
    """Return whether a scale lies on the substrate."""
    for c in range(w.counts[0]):  # noqa: SIM110 - compiled
        if w.con[c, touch.KIND] == touch.LIES and w.con[c, touch.FIRST] == i:
            return True
    return False


@_jit
def sideways(w: Walk, gap: float) -> bool:
    """Return whether the vertex in ``w.best`` is so deep that it came in from the side of a plate."""
    return bool(w.best[touch.KIND] != touch.LIES and gap < -0.3 * w.S.shapes[0, H] - 5e-3)

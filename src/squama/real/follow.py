"""A path of the twist, followed step by step: free, slipping, sticking, and its end by name; compiled."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from squama.real.changes import LIES, OTHER, PARTED, RANGE, STOPPED, TURNS, beyond, handed, taken

from squama.real.contact import (  # isort: skip
    ALONG, ASIDE, AT, BEFORE, BENT, BOW, CROSSING, FORCE, FRICTION, LAST, MISSED, MOST, NEW, NORMAL, PHI, SLIDING,
    SLOPE, SPEED, STATES, STRETCH, TALLY, TORQUE, WIDTH, Step, angle, residual,
)  # fmt: skip
from squama.real.design import LEG, MOTIONS, Design, _in, _jit, frame, load, onto, strains
from squama.real.features import deflection, on_face, raised, spots
from squama.real.start import next_contact
from squama.real.steps import free_rates, rates_engaging, solve
from squama.contacts.vectors import copy, magnitude, put
from squama.types import Array

FREE, SLIP, STICK = range(3)
COLUMNS = (
    "phi", "T", "N", "f", "x", "y", "c1", "c2", "W_fr", "W", "mode", "u_X", "u_Y", "u_Z", "w_X", "w_Y", "w_Z", "T_slip",
    "slip",
)  # fmt: skip
"""What is written of each point; T_slip: the torque where the contact last began to slide, or turned round; slip: the
length along which it has slid."""
STRAINED = (
    *COLUMNS, "psi", "twist", "stretch", "F_x", "F_y", "F_z", "lift", "first", "second", "along", "since", "k",
)  # fmt: skip
"""The same of a beam that is bent, whose phi is the way and T the work per way; its strains, the contact's force on the
first scale along its axes at rest, the deflection of the second one there, what meets (-1: nothing), the place on a tip
edge that lies on a face, the way since which it does, and the neighbour's number."""
_LEAST, _SMALLEST, _HELD = 1e-7, 1e-15, 1e-7
NEAR = 1e-6
"""Increment, rad per pitch, below which a target is not stepped to: its rates would be those of rounding."""
_HARDLY = 1e-6
"""Force, E d^2, of a contact that is let go where it can no longer be followed."""
_START, _SOFTLY, _GENTLE = 1 / 16, 1 / 8, 1e-5
"""First steps at engagement, when a contact begins to slide, and to stick; shares of the largest step."""
_TURN, _BENDS, _TURNING = 0.9, 0.98, 1 / 64
"""Cosines of the turn of the slip's direction over a step that is refused, and that is not grown; share of the largest
step below which any turn is taken."""
_MISSES, _HANDED = 400, 24
MODE, FRESH, KNOWN, CLOSING, H, SIZE, NARROW, MISSES, RUBBED, WORK, WAY, COUNT, ONSET, SLID, NOTED, SINCE, HANDED = (
    range(17)
)
"""What is counted along a path: the mode; whether it just began, the Jacobian may be kept, a slide is being located;
next and last step, distance to what ends the path; steps refused; frictional work, work of the torque; sense of the
twist; steps; torque where the contact last began to slide; length of the slip; states noted; where the contact began,
and how many came before it."""
BEGUN = WIDTH - 1
"""Column of a state that is noted: whether it is the first one of a slide."""


class End(NamedTuple):
    """How a path ended: number, twist, edge and neighbour of another contact (+4: an edge of the other scale)."""

    code: int
    phi: float
    edge: int
    k: int
    solved: int


@_jit
def write(d: Design, s: Array, tally: Array, out: Array) -> None:
    """Write a row of :data:`COLUMNS`."""
    m = MOTIONS
    out[0], out[1], out[2], out[3] = s[PHI], s[TORQUE], s[NORMAL], s[FRICTION]
    out[4], out[5], out[6], out[7] = s[AT], s[AT + 1], s[m + 3], s[m + 4]
    out[8], out[9], out[10] = tally[RUBBED], tally[WORK], tally[MODE]
    copy(s[:m], out[11:])
    out[17], out[18] = tally[ONSET], tally[SLID]
    if not d.elastic:
        out[6] = out[7] = 0.0
    if d.bent:
        out[19], out[20] = strains(d, s[PHI])
        out[21] = s[STRETCH]
        for j in range(3):
            out[22 + j] = s[FORCE + j]
        out[25], out[26], out[27], out[28], out[29], out[30] = 0.0, -1.0, -1.0, s[AT + 2], tally[SINCE], d.k
        if s[NORMAL].real > 0.0:
            out[26], out[27] = d.first, d.second
            if d.elastic:
                out[25] = lifted(d, s)


@_in
def lifted(d: Design, s: Array) -> float:
    """Return the deflection of the second scale at the contact."""
    if not on_face(d):
        return deflection(d, d.second, s[AT + 1], s, BENT + 6)[0]
    _, _, x, y = spots(d, s[AT], s[AT + 1], s[AT + 2])
    return raised(d, s, BENT, x, y)[0]


@_jit
def at_rest(d: Design, rates: Array, phi: float, s: Array) -> None:
    """Write the state without contact."""
    m = MOTIONS
    s[:] = 0.0
    for j in range(m):
        s[j] = rates[j, 0] * phi + rates[j, 1]
    s[STRETCH] = rates[m, 0] * phi + rates[m, 1]
    s[AT] = s[AT + 1] = np.nan
    s[PHI], s[TORQUE] = phi, load(d, phi, s, s[STRETCH])


@_in
def extrapolate(d: Design, size: float, room: Array) -> None:
    """Write the unknowns after a step as they would be if they went on like that."""
    last, before, new, done = room[LAST], room[BEFORE], room[NEW], room[TALLY, SIZE]
    for j in range(angle(d) + 1):
        new[j] = last[j] + size / done * (last[j] - before[j] + (size + done) * room[BOW, j])


@_in
def difference(tally: Array, size: float, dphi: float, stuck: bool) -> Step:
    """Return a step with its weights of the backward difference."""
    ratio = size / tally[SIZE]
    if tally[FRESH].real > 0.0:
        return Step(stuck, 1.0 + 0.0 * ratio, -1.0 + 0.0 * ratio, 0.0 * ratio, dphi)
    return Step(stuck, (1 + 2 * ratio) / (1 + ratio), -(1 + ratio), ratio * ratio / (1 + ratio), dphi)


@_jit
def guess(d: Design, size: float, room: Array) -> bool:
    """Write a guess of the new state after a step; False if there is none."""
    last, new, tally = room[LAST], room[NEW], room[TALLY]
    if tally[FRESH] == 0.0:
        extrapolate(d, size, room)
        return True
    if last[NORMAL] == 0.0 and tally[MODE] == SLIP:
        taken(d, last, False)
        if rates_engaging(d, tally[WAY], room):
            for j in range(angle(d) + 1):
                new[j] = last[j] + size * new[j]
            return True
        if not d.bent:
            return False
        # friction holds it from the first on
        begin(tally, STICK, size)
    taken(d, last, True)
    copy(last, new)
    return True


@_in
def ahead(d: Design, room: Array) -> float:
    """Return the cosine of the angle by which a step has turned the direction of slip."""
    last, new, i = room[LAST], room[NEW], SLIDING
    return 1.0 if d.mu == 0.0 else float(last[i] * new[i] + last[i + 1] * new[i + 1] + last[i + 2] * new[i + 2])


@_in
def mean(a: float, b: float, c: float, ratio: float) -> float:
    """Return the mean from b to c of a parabola through a, b and c; ``ratio``: of the last interval to the first."""
    return (b + c) / 2 - (c - b - ratio * (b - a)) / 6 * ratio / (1 + ratio)


@_jit
def accept(d: Design, room: Array, size: float) -> None:
    """Make the new state the last one, after a step of a size."""
    last, new, tally = room[LAST], room[NEW], room[TALLY]
    fresh = tally[FRESH].real > 0.0
    for j in range(MOST):
        slope = (new[j] - last[j]) / size
        room[BOW, j] = 0.0 if fresh else (slope - room[SLOPE, j]) / (size + tally[SIZE]) * size
        room[SLOPE, j] = slope
    before, ratio = room[BEFORE], 0.0 if fresh else size / tally[SIZE]
    if tally[MODE] == SLIP:
        crossing = last[CROSSING]
        if fresh:
            last[SPEED], crossing = new[SPEED], new[CROSSING]
        one, two = before[FRICTION] * before[SPEED], last[FRICTION] * last[SPEED]
        tally[RUBBED] += mean(one, two, new[FRICTION] * new[SPEED], ratio) * size
        x, y = new[AT] - last[AT], new[AT + 1] - last[AT + 1]
        if on_face(d):
            # along the face, and what a tip edge moves along itself
            c, s = new[CROSSING], new[AT + 2] - last[AT + 2]
            x, y, crossing = x + c * y - new[ALONG] * s, np.sqrt(1 - c * c) * y - new[ASIDE] * s, -new[CROSSING]
        tally[SLID] += np.sqrt(magnitude(x * x + y * y - x * y * (crossing + new[CROSSING])))
    tally[WORK] += mean(before[TORQUE], last[TORQUE], new[TORQUE], ratio) * (new[PHI] - last[PHI])
    tally[SIZE], tally[FRESH] = size, 0.0
    copy(last, before)
    copy(new, last)


@_in
def begin(tally: Array, mode: int, h: float) -> None:
    """Go on in a mode with a first step."""
    tally[MODE], tally[FRESH], tally[KNOWN], tally[H] = mode, 1.0, 0.0, h
    tally[NARROW], tally[CLOSING] = math.inf, 0.0


@_jit
def advance(d: Design, rates: Array, start: tuple[float, float, float], goal: float, step: float, room: Array) -> None:
    """Go on without contact, to the goal or to engagement."""
    last, tally = room[LAST], room[TALLY]
    phi, before = last[PHI], last[TORQUE]
    engages = phi.real < start[0].real <= goal.real
    at_rest(d, rates, start[0] if engages else goal, last)
    tally[WORK] += (before + last[TORQUE]) / 2 * (last[PHI] - phi)
    if engages:
        last[AT], last[AT + 1], tally[ONSET], tally[SINCE] = start[1], start[2], last[TORQUE], last[PHI]
        begin(tally, SLIP, step * _START)


@_jit
def attempt(
    d: Design, to: float, size: float, step: float, every: int, room: Array, J: Array, order: Array, b: Array
) -> tuple[int, int, int]:  # fmt: skip
    """Solve for the state at a twist; return why it is not of this contact (end, edge, neighbour), -1 if it is."""
    last, new, tally = room[LAST], room[NEW], room[TALLY]
    found, known, sticks = guess(d, size, room), tally[KNOWN] > 0.0, tally[MODE] == STICK
    # what would be if the contact stuck says whether it does, and is near what is if it slips
    stuck = sticks or (tally[FRESH] > 0.0 and last[NORMAL] > 0.0)
    while found:
        found, known = solve(d, to, difference(tally, size, to - last[PHI], stuck), room, J, order, known)
        if sticks or not stuck:
            break
        if found and d.mu * new[NORMAL] >= new[FRICTION]:
            begin(tally, STICK, size)
            sticks = True
            break
        # (rigid scales that stick may not let the bar twist at all)
        if not found:
            copy(last, new)
        taken(d, last, False)
        taken(d, new, False)
        found, known, stuck = True, False, False
    found = found and (sticks or d.mu == 0.0 or new[SPEED] > 0.0)
    tally[KNOWN] = 1.0 if known else 0.0
    if not found:
        return STOPPED, -1, 0
    if new[NORMAL] < 0.0:
        return PARTED, -1, 0
    if not sticks and ahead(d, room) < _TURN and size > step * _TURNING:
        return TURNS, -1, 0
    return beyond(d, new, room, b, tally[COUNT] % every == 0 or tally[NARROW] < math.inf)


@_jit
def beside(d: Design, to: float, room: Array, J: Array, order: Array) -> bool:
    """Write the new state at a twist so near to the last one that no step leads there; False if it needs one.

    One that slips goes on as it did, or as it begins to; one that sticks is solved for. The last state stays.
    """
    last, new, tally = room[LAST], room[NEW], room[TALLY]
    size = abs(to - last[PHI])
    if tally[MODE] == FREE or size >= NEAR or not guess(d, size, room):
        return False
    found, stuck = True, tally[MODE] == STICK or (tally[FRESH] > 0.0 and last[NORMAL] > 0.0)
    step = difference(tally, size, to - last[PHI], stuck)
    if stuck:
        found, _ = solve(d, to, step, room, J, order, False)
        tally[KNOWN] = 0.0
    else:
        residual(d, frame(d, to, d.k), to, step, room, MISSED)
    return found and new[NORMAL] >= 0.0


@_jit
def slides(d: Design, size: float, step: float, room: Array) -> bool:
    """Say whether friction no longer holds the new state; go nearer to where it gives way, or on from there."""
    last, new, tally = room[LAST], room[NEW], room[TALLY]
    held, least = d.mu * new[NORMAL] - new[FRICTION], _HELD * new[NORMAL]
    if held >= least or (held >= 0.0 and tally[CLOSING] == 0.0):
        return False
    if abs(held) < least or size < _SMALLEST:
        accept(d, room, size)
        tally[ONSET] = new[TORQUE]
        begin(tally, SLIP, step * _SOFTLY)
        return True
    # what holds falls almost linearly
    before = d.mu * last[NORMAL] - last[FRICTION]
    share = before / (before - held) if before > _HELD * last[NORMAL] else 0.5
    tally[H] = size * (share if tally[CLOSING] > 0.0 else min(0.9, max(0.1, share)))
    tally[CLOSING] = 1.0
    return True


@_jit
def opens(d: Design, rates: Array, engaged: float, room: Array) -> None:
    """Let go where the contact closed: nothing but the twist holds the scales there."""
    last, tally = room[LAST], room[TALLY]
    phi, before = last[PHI], last[TORQUE]
    tally[RUBBED] += last[FRICTION] * last[SPEED] / 2 * max(0.0, phi - engaged)
    at_rest(d, rates, min(phi, engaged), last)
    tally[WORK] += (before + last[TORQUE]) / 2 * (last[PHI] - phi)
    begin(tally, FREE, tally[H])


@_jit
def refused(code: int, size: float, room: Array) -> bool:
    """Take a smaller step after one that was refused; True where there is none."""
    tally = room[TALLY]
    tally[H], tally[KNOWN] = size / 2, 0.0
    tally[MISSES] += 1.0
    if code not in (STOPPED, TURNS):
        tally[NARROW] = size
    # a second time from the state alone: it may stick
    elif code == STOPPED and tally[MODE] == SLIP and tally[MISSES] % 2 == 0:
        tally[FRESH] = 1.0
    return bool(tally[H] < _LEAST or tally[MISSES] > _MISSES)


@_jit
def note(room: Array, notes: Array) -> None:
    """Write the new state into the notes (n, 56), as long as there is room for it and the contact slides."""
    tally = room[TALLY]
    i = int(tally[NOTED])
    if tally[MODE] == SLIP and i < len(notes):
        copy(room[NEW], notes[i])
        notes[i, BEGUN] = tally[FRESH]
        tally[NOTED] += 1.0
    else:
        tally[NOTED] = len(notes)


@_jit
def onward(d: Design, size: float, step: float, room: Array, notes: Array) -> None:
    """Accept a step and choose the next one."""
    tally = room[TALLY]
    note(room, notes)
    slowly = tally[MODE] == SLIP and ahead(d, room) < _BENDS
    accept(d, room, size)
    tally[COUNT] += 1.0
    tally[NARROW] -= size
    tally[H] = size if slowly else min(step, 2 * size)
    if tally[NARROW] < 2 * _LEAST:
        tally[NARROW] = math.inf
    elif tally[NARROW] < math.inf:
        tally[H] = min(tally[H], tally[NARROW] / 2)


@_jit
def redirect(d: Design, room: Array) -> None:
    """Write what the last state opposes to the leg that begins there."""
    last, new = room[LAST], room[NEW]
    copy(last, new)
    taken(d, new, True)
    residual(d, frame(d, last[PHI], d.k), last[PHI], Step(True, 1.0, -1.0, 0.0, 1.0), room, MISSED)
    last[TORQUE] = new[TORQUE]


@_jit
def set_out(d: Design, goal: float, corner: bool, step: float, room: Array) -> None:
    """Turn towards a goal: a contact sticks, or at a corner of the path slides or sticks, where the way turns."""
    last, tally = room[LAST], room[TALLY]
    way = 1.0 if goal > last[PHI] else -1.0
    if tally[MODE] != FREE and (corner or way != tally[WAY]):
        if corner:
            redirect(d, room)
            begin(tally, SLIP, step * _SOFTLY)
        elif d.mu > 0.0:
            begin(tally, STICK, step * _GENTLE)
        tally[ONSET] = last[TORQUE]
    tally[WAY] = way


@_jit
def follow(
    d: Design, start: tuple[float, float, float], targets: Array, corners: Array, step: float, every: int, out: Array,
    notes: Array,
) -> End:  # fmt: skip
    """Follow the twist to targets (n,), one after the other, from rest; rows of ``out`` (n, 19) not reached stay.

    ``start``: twist and places at engagement; ``step``: largest increment; other contacts are looked for at every so
    many steps. With ``corners`` (n, 2), bend and twist, ``targets`` are ways there, ever farther. Rows of a beam that
    knows bend and stretch are (n, 31). The states of the first contact, while it slides from the first on, are written
    into ``notes`` (m, 56).
    """
    room, J, order, b = np.zeros((STATES, WIDTH)), np.empty((MOST, MOST)), np.zeros(MOST, np.int64), np.zeros(24)
    for j in range(4):
        # twisted alone, whatever leg was looked at last
        d.table[LEG, j] = 1.0 if j == 3 else 0.0
    last, tally, rates = room[LAST], room[TALLY], free_rates(d)
    at_rest(d, rates, 0.0, last)
    begin(tally, FREE, step)
    tally[SIZE], tally[WAY] = step, 1.0
    why, edge_of, k_of, parted, barred = RANGE, -1, 0, False, False
    for i in range(targets.size):
        goal, tally[MISSES] = targets[i], 0.0
        before = targets[i - 1] if i > 0 else 0.0
        leg = len(corners) > 0 and goal != before
        corner = leg and onto(d, before, goal, corners, i)
        if leg:
            put(free_rates(d), rates)
        if corner and tally[MODE] == FREE:
            # the work is along the new leg
            at_rest(d, rates, last[PHI], last)
        if goal != last[PHI] and (corner or tally[MODE] == FREE or abs(goal - last[PHI]) >= NEAR):
            set_out(d, goal, corner, step, room)
        reached = LAST
        while last[PHI] != goal:
            if tally[MODE] == FREE:
                if parted and (len(corners) > 0 or goal > last[PHI]):
                    d, first, edge_of, k_of, start = next_contact(d, last[PHI], targets, corners, i)
                    parted, barred = False, first == -2
                if barred and start[0] <= goal:
                    return End(OTHER, start[0], edge_of, k_of, i)
                advance(d, rates, start, goal, step, room)
                continue
            if beside(d, goal, room, J, order):
                reached = NEW
                break
            left = abs(goal - last[PHI])
            size = left / math.ceil(left / tally[H] * (1 - 1e-9))
            to = goal if size > left * (1 - 1e-9) else last[PHI] + tally[WAY] * size
            code, edge, k = attempt(d, to, size, step, every, room, J, order, b)
            if code == PARTED and tally[WAY] < 0.0 and to < start[0] + _LEAST:
                opens(d, rates, start[0], room)
            # elsewhere a contact that sticks slides before it opens
            elif code >= 0 and not (code == PARTED and tally[MODE] == STICK):
                if code not in (STOPPED, TURNS) or tally[NARROW] == math.inf:
                    why, edge_of, k_of = STOPPED if code == TURNS else code, edge, k
                if refused(code, size, room):
                    tally[SINCE], tally[MISSES], tally[HANDED] = last[PHI], 0.0, tally[HANDED] + 1.0
                    # (derivatives are those of the first contact)
                    tally[NOTED] = len(notes)
                    # (it may hardly press where the path has just turned)
                    lost = why == STOPPED and len(corners) > 0 and last[NORMAL] < _HARDLY
                    if d.bent and (why == PARTED or lost):
                        at_rest(d, rates, last[PHI], last)
                        begin(tally, FREE, step)
                        start, parted = (math.inf, 0.0, 0.0), True
                        continue
                    d, on = handed(d, why, k_of, room, J, order, b)
                    if not on or tally[HANDED] > _HANDED:
                        return End(STOPPED if why == LIES else why, last[PHI], edge_of, k_of, i)
                    begin(tally, SLIP, step * _SOFTLY)
            elif tally[MODE] != STICK or not slides(d, size, step, room):
                onward(d, size, step, room, notes)
        write(d, room[reached], tally, out[i])
    return End(RANGE, last[PHI], -1, 0, targets.size)

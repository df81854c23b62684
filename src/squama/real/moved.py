"""A path of the twist in contact once more, with a complex step in its beam and its targets; compiled.

The states of the real path are known. With r(x, states before, beam, twist) = 0 a step's equations
(:mod:`squama.real.contact`) and J = dr/dx, a change of the beam changes its state by

    dx = -J^-1 (what r becomes by the change of the beam, of the twist and of the states before)

(implicit function theorem), all of it in the imaginary parts of one evaluation: no differences are taken. Friction's
direction is that of the slip, a rate, so that changes are handed on from step to step, from engagement on. The steps
themselves move with the engagement and the targets: it is the followed curve that is differentiated, to all digits.
J need not be exact: its error is repeated in the equations' imaginary part, and corrected. A contact that sticks has no
derivatives (:func:`squama.real.follow.note`): one that is only ever loaded does not.
"""

from __future__ import annotations

import math

import numpy as np

from squama.real.contact import LAST, MISSED, MOST, NEW, PHI, STATES, TALLY, WIDTH, angle, residual
from squama.real.design import Design, _jit, frame

from squama.real.follow import (  # isort: skip
    BEGUN, FREE, FRESH, NEAR, SIZE, WAY, accept, advance, at_rest, begin, difference, extrapolate, write,
)  # fmt: skip
from squama.real.steps import engagement, free_rates, jacobian
from squama.contacts.vectors import copy
from squama.types import Array

_ROUNDS, _FIRST = 1, 3
"""Corrections of a change by J: of one that is known from the steps before, and of the first."""


@_jit
def inverses(d: Design, start: tuple[float, float, float], step: float, notes: Array, J: Array) -> int:
    """Write the inverse Jacobians (n, 13, 13) at the states that are noted; return how many there are."""
    room, order, rates = np.zeros((STATES, WIDTH)), np.zeros(MOST, np.int64), free_rates(d)
    begun(d, rates, start, step, room)
    n = angle(d) + (1 if d.mu > 0.0 else 0)
    for i in range(len(notes)):
        phi = notes[i, PHI]
        size = phi - room[LAST, PHI]
        if not size > 0.0:
            return i
        copy(notes[i], room[NEW])
        room[TALLY, FRESH] = notes[i, BEGUN]
        by, f = difference(room[TALLY], size, size, False), frame(d, phi, d.k)
        residual(d, f, phi, by, room, MISSED)
        if not jacobian(d, f, phi, by, room, J[i], order, n):
            return i
        copy(notes[i], room[NEW])
        accept(d, room, size)
    return len(notes)


@_jit
def begun(d: Design, rates: Array, start: tuple[float, float, float], step: float, room: Array) -> None:
    """Write the state at engagement as the last one."""
    tally = room[TALLY]
    at_rest(d, rates, 0.0 * start[0], room[LAST])
    begin(tally, FREE, step)
    tally[SIZE], tally[WAY] = step, 1.0
    advance(d, rates, start, start[0], step, room)


@_jit
def again(
    d: Design, contact: Array, targets: Array, goals: Array, step: float, notes: Array, J: Array, start: Array,
    out: Array,
) -> None:  # fmt: skip
    """Write the rows (n, 19) at targets (n,), with the complex steps of a design and of its goals (n,)."""
    room, rates, at = np.zeros((STATES, WIDTH), goals.dtype), free_rates(d), 0
    last, tally = room[LAST], room[TALLY]
    begin(tally, FREE, step)
    while at < targets.size and targets[at] <= contact[3]:
        # the work of a linear spring
        advance(d, rates, (math.inf + 0 * goals[at], goals[at], goals[at]), goals[at], step, room)
        write(d, last, tally, out[at])
        at += 1
    if contact[0] < 0.0 or at == targets.size:
        return
    first = contact[3] + 0 * rates[0, 0], contact[4] + 0 * rates[0, 0], contact[5] + 0 * rates[0, 0]
    for _ in range(2):
        _, phi, x, y = engagement(d, rates, first)
        first = phi, x, y
    start[0], start[1], start[2] = first
    tally[:] = 0.0
    begun(d, rates, first, step, room)
    real = contact[3]
    for i in range(len(notes)):
        while at < targets.size and abs(targets[at] - real) < NEAR and targets[at] != notes[i, PHI]:
            # no step leads there, so that how it moves is not known
            out[at, :] = math.nan
            at += 1
        if at == targets.size:
            return
        share = (notes[i, PHI] - real) / (targets[at] - real)
        real = notes[i, PHI]
        size = share * (goals[at] - last[PHI])
        tally[FRESH] = notes[i, BEGUN]
        change(d, size, notes[i], J[i], room)
        accept(d, room, size)
        if real == targets[at]:
            write(d, last, tally, out[at])
            at += 1


@_jit
def change(d: Design, size: float, noted: Array, J: Array, room: Array) -> None:
    """Write the new state, whose real part is known, after a step."""
    new, last, r = room[NEW], room[LAST], room[MISSED]
    n, rounds = angle(d) + (1 if d.mu.real > 0.0 else 0), _ROUNDS
    copy(last, new)
    if noted[BEGUN] > 0.0:
        rounds = _FIRST
    else:
        extrapolate(d, size, room)
    for i in range(n):
        new[i] = noted[i] + 1j * new[i].imag
    phi = last[PHI] + size
    by, f = difference(room[TALLY], size, size, False), frame(d, phi, d.k)
    for count in range(rounds + 1):
        residual(d, f, phi, by, room, MISSED)
        if count < rounds:
            for i in range(n):
                off = 0.0
                for j in range(n):
                    off += J[i, j] * r[j].imag
                new[i] -= 1j * off

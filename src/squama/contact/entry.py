"""The compiled solver as it is called from outside."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from squama.batch.keeping import kept
from squama.contact import follow as following
from squama.contact.detection import VERTEX
from squama.contact.equations import Work
from squama.contact.follow import TALLY, Walk
from squama.contact.geometry import PAIR, PLACED
from squama.contact.linear import Linear
from squama.contact.system import MOTIONS, Past, State, System

_CROWD = 8
"""Contacts in the mean of as many scales as may meet, for which there is room."""
SOURCES = sorted(Path(__file__).parent.glob("*.py"))
_follow, _jit = following.follow, following._jit


@_jit
def state(N: int, C: int) -> State:
    """Return a state at rest."""
    return State(np.zeros((N, 6)), np.zeros(4), np.zeros((N, 24)), np.zeros((C, 3)), np.zeros((C, 3)))


@_jit
def walk(S: System, C: int) -> Walk:
    """Return a path at rest with room for C contacts."""
    N, k = len(S.shapes), S.reach
    n = 6 * N + 6 * C + 4
    W = Work(
        np.zeros((N, 12)), np.zeros((N, k, PAIR)), np.zeros((N, 24)), np.zeros((2 * C, 3, 24)),
        np.zeros((2 * C, 3, 24)), np.zeros(2 * C), np.zeros((6, n)), np.zeros((22, 28)), np.zeros((C, 7)),
        np.zeros((2, 12)), np.zeros((4, 3)), np.zeros(7, np.int64), np.zeros((2, 28), np.int64),
        np.zeros(N, np.int64), np.zeros(2 * C, np.int64),
    )  # fmt: skip
    wide = n if S.periodic else min(n, 3 * (k + 1) * (MOTIONS + 6 * _CROWD))
    J = Linear(
        np.zeros(n * wide), np.zeros((n, 4)), np.zeros((4, n)), np.zeros((4, 4)), np.zeros(n, np.int64),
        np.zeros(n, np.int64), np.zeros(n), np.zeros(N + C, np.int64), np.zeros(6, np.int64),
    )  # fmt: skip
    past = Past(np.zeros((2, N, 12)), np.zeros((2, N, k, PLACED)), np.zeros((2, N, 24)), np.zeros((C, 3)), np.zeros(3))
    return Walk(
        S, W, J, state(N, C), state(N, C), state(N, C), state(N, C), state(N, C), past, np.zeros((C, 7), np.int64),
        np.zeros((C, 7), np.int64), np.zeros((C, 7), np.int64), np.zeros((64 * N, VERTEX)), np.zeros(4), np.zeros(4, np.int64), np.zeros(8),
        np.zeros(TALLY), np.zeros(VERTEX),
    )  # fmt: skip


def _path(S, C, ways, corners, step, rows, motions, bends, contacts, events, end):
    _follow(walk(S, C), ways, corners, step, rows, motions, bends, contacts, events, end)


path = kept(_path, SOURCES)

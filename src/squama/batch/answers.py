"""Solution of many designs on hinges: a few in Python, many in compiled code on several threads."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from squama.loads import LOADS
from squama.model.evaluation import BENT, NAMES, OPEN, Room
from squama.model.figures import Common, Rules, fill, legendre_rules, pole_rules
from squama.types import Array

FEW = 128
"""Largest number of designs solved in Python: about as fast as loading the compiled code."""
PART, LEAST = 4096, 256
"""Largest and smallest number of designs that a thread takes at a time."""
FLOATS = 10
NO_RULE = Rules(np.zeros(1, np.int64), np.zeros((4, 1)), 0.0)


class Answers(NamedTuple):
    """Arrays (n,): path (from ``x0`` to ``x_end``, through a fold at ``theta_f``), its end, values at the cut-off.

    ``kind`` of path and path parameters as in :mod:`squama.model.evaluation`; ``load_e`` and ``load_end`` in rad per
    pitch.
    """

    load_e: Array
    load_end: Array
    x0: Array
    x_end: Array
    theta_f: Array
    theta_c: Array
    load_c: Array
    f0: Array
    torque: Array
    work: Array
    code: Array
    neighbour: Array
    crossing: Array
    kind: Array


def answers(
    columns: tuple[Array, ...],
    thickness: Array | None = None,
    *,
    law: str,
    sense: str,
    load: str,
    margin: float | None = None,
    threads: int | None = None,
    few: int | None = None,
) -> Answers:
    """Solve designs given by columns (n,) eta, beta, lam, alpha, theta0, mu.

    Parameters
    ----------
    thickness
        Thickness of the scales over the pitch, (n,); 0 by default.
    margin
        Fraction of the path left before a lock; with None the values at the cut-off are NaN.
    threads
        Number of threads; by default the number of cores, or NUMBA_NUM_THREADS.
    few
        Largest number of designs solved in Python; by default :data:`FEW`.
    """
    thin = np.zeros_like(columns[0]) if thickness is None else thickness
    designs = np.ascontiguousarray(np.stack((*columns, thin)), float)
    n = designs.shape[1]
    cut, plain = (NO_RULE, NO_RULE) if margin is None else (pole_rules(margin), legendre_rules())
    kind = OPEN if LOADS[load].sided else BENT
    sign = -1.0 if sense == "-" and kind == OPEN else 1.0
    common = Common(kind, sign, NAMES.index(law), margin is not None, margin or 0.0, cut, plain)
    out, whole = np.full((FLOATS, n), np.nan), np.empty((4, n), np.int64)
    compiled = n > (FEW if few is None else few)
    if not compiled:
        try:
            with np.errstate(all="ignore"):
                fill(designs, 0, n, common, Room(), out, whole)
        except ZeroDivisionError:  # Python's floats only; compiled code has 1/0 = inf
            compiled = True
    if compiled:
        from squama.batch import entry, keeping
        from squama.batch.threads import in_parts

        def begin() -> Callable[[int, int], None]:
            room = entry.room()
            return lambda low, high: entry.fill(designs, low, high, common, room, out, whole)

        keeping.tell(entry.fill, "many designs")
        in_parts(begin, n, most=PART, least=LEAST, threads=threads)
    return Answers._make((*out, whole[0].astype(np.int8), *whole[1:]))

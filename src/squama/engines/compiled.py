"""The Numba engine: the same kernel and the same steps as the numpy engine, compiled and in lock-step blocks.

What is unusual is left to the numpy engine: paths with a deep dip of a margin between samples, and bending. Threads
take turns at parts of some thousand designs; no design's answer depends on the others.
"""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor

import numpy as np
from numba import config

from squama.engines import Problem, Solved
from squama.engines import numpy as plain
from squama.engines.compiled_entry import ready, solve_all
from squama.engines.compiled_first import ANSWER
from squama.model.rules import legendre_rules, pole_rules
from squama.model.scan import FOLDED_STEPS, STEPS

__all__ = ["ready", "run"]
PART, LEAST = 8192, 4096
"""Designs a thread takes at a time, at most and at least."""


def run(p: Problem, threads: int | None = None) -> Solved:
    """Answer every design of a problem.

    Parameters
    ----------
    threads
        Threads to work with; NUMBA_NUM_THREADS (all cores unless set) by default.
    """
    if p.load == "bending":
        return plain.run(p)
    n = p.eta.size
    designs = tuple(np.ascontiguousarray(v) for v in p[:7])
    out, code, neighbour = np.empty((ANSWER, n)), np.empty(n, np.int8), np.empty(n, np.int64)
    # made once, before the threads ask for them
    rules = (*pole_rules(p.margin)[:2], *legendre_rules()[:2])

    workers = min(threads or int(getattr(config, "NUMBA_NUM_THREADS", 1)), -(-n // PART))
    parts = iter(list(_parts(n, workers)))

    def answer() -> None:
        for part in parts:
            solve_all(
                designs, part.start, part.stop, p.sense == "-", p.law == "plate", p.margin,
                STEPS, FOLDED_STEPS, *rules, out, code, neighbour,
            )  # fmt: skip

    if workers > 1:
        with ThreadPoolExecutor(workers - 1) as pool:
            others = [pool.submit(answer) for _ in range(workers - 1)]
            answer()
            for other in others:
                other.result()
    else:
        answer()
    solved = Solved._make((*out[:3], code, neighbour, *out[3:]))
    left = np.flatnonzero(code < 0)
    if left.size:
        columns = {name: getattr(p, name)[left] for name in p._fields[:7]}
        for mine, theirs in zip(solved, plain.run(p._replace(**columns)), strict=True):
            mine[left] = theirs
    return solved


def _parts(n: int, workers: int) -> Iterator[slice]:
    """Parts of n designs, the last ones smaller, so that no thread waits long for another."""
    low = 0
    while low < n:
        size = PART if workers == 1 else max(LEAST, min(PART, (n - low) // (2 * workers)))
        yield slice(low, min(n, low + size))
        low += size

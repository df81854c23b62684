"""The one function that is called from outside, and its copy on the disk."""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import Any

import numba
import numpy as np

from squama.engines.compiled_ends import FRICTIONAL, LEFT
from squama.engines.compiled_kernel import OPTIONS
from squama.engines.compiled_lanes import CARRIED, CODE, MU, ROWS, X0, X_C, X_END, K, W
from squama.engines.compiled_table import EVENTS, TABLE, answer, cross, engage, follow, solve, work
from squama.model import laws, mechanics, neighbours, paths, twisting
from squama.model.solve import Array


def _sources() -> str:
    """Digest of everything that is compiled, for Numba looks at the file of the outermost function only."""
    parts = [laws, mechanics, neighbours, paths, twisting]
    files = sorted([*Path(__file__).parent.glob("compiled*.py"), *(Path(str(m.__file__)) for m in parts)])
    return hashlib.sha256(b"".join(f.read_bytes() for f in files)).hexdigest()


def _entry(stamp: str) -> Any:
    def solve_all(
        cols: Array, low: int, high: int, plates: bool, margin: float, steps: Array, folded_steps: Array,
        sizes: Array, rule: Array, plain_sizes: Array, plain_rule: Array, out: Array, code: Array, neighbour: Array,
    ) -> str:  # fmt: skip
        """Answer the designs low..high: ``out``, ``code`` (-1: left to the numpy engine) and ``neighbour``."""
        w, h, table = np.zeros(ROWS * W), np.zeros(2 * 34 * W), np.zeros((TABLE, CARRIED))
        events, met = np.zeros((4, EVENTS), np.int64), np.zeros(EVENTS)
        index, some = np.zeros(TABLE, np.int64), np.zeros(TABLE, np.int64)
        for base in range(low, high, TABLE):
            n = min(TABLE, high - base)
            engaged = engage(w, table, cols, out, base, n, index)
            plain = follow(w, table, index, engaged, steps, folded_steps, plates)
            for part in range(2):
                folded = part == 1
                a, b = (plain, engaged) if folded else (0, plain)
                solve(w, table, index, a, b, folded, plates)
                cross(w, h, table, index, a, b, folded, events, met)
                answer(w, table, index, a, b, folded, plates, margin, out, base)
                for step in range(2):
                    locked, many = step == 0, 0
                    for i in range(a, b):
                        at = index[i]
                        pole = (table[at, CODE // W] == FRICTIONAL) & ((not folded) | (table[at, X_END // W] > 0))
                        bears = (table[at, MU // W] > 0) & (table[at, X_C // W] > table[at, X0 // W])
                        if (pole == locked) & bears & (table[at, CODE // W] != LEFT):
                            some[many] = at
                            many += 1
                    rules = (sizes, rule) if locked else (plain_sizes, plain_rule)
                    work(w, table, some, many, locked, folded, plates, rules[0], rules[1], out, base)
            for i in range(n):
                code[base + i] = int(table[i, CODE // W])
                neighbour[base + i] = int(table[i, K // W])
        return stamp

    options: dict[str, Any] = {**OPTIONS, "nogil": True}
    try:
        return numba.njit(cache=True, **options)(solve_all)
    except RuntimeError:  # no place on the disk to keep compiled code
        return numba.njit(**options)(solve_all)


solve_all = _entry(_sources())


def ready() -> bool:
    """Whether the compiled code is loaded, or likely to be found on the disk (it takes half a minute to make)."""
    kept = solve_all.stats.cache_path
    return bool(solve_all.signatures) or (kept is not None and any(Path(kept).glob(f"{Path(__file__).stem}.*.nbc")))

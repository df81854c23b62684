"""The one function that is called from outside, and its copy on the disk."""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import Any

import numba
import numpy as np

from squama.engines.compiled_first import ANSWER, CROSSED, PLAIN, ROUGH, first_pass, give_out
from squama.engines.compiled_kernel import OPTIONS, lines
from squama.engines.compiled_lanes import CARRIED, ROWS, SCRATCH, W
from squama.engines.compiled_order import order
from squama.engines.compiled_table import EVENTS, TABLE, answer, choose, cross, follow, solve, work
from squama.model import ends, energy, laws, mechanics, neighbours, paths, rules, scan, twisting
from squama.model import solve as roots
from squama.model.scan import COARSE
from squama.model.solve import Array


def _sources() -> str:
    """Digest of everything that is compiled, for Numba looks at the file of the outermost function only."""
    parts = [ends, energy, laws, mechanics, neighbours, paths, roots, rules, scan, twisting]
    files = sorted([*Path(__file__).parent.glob("compiled*.py"), *(Path(str(m.__file__)) for m in parts)])
    return hashlib.sha256(b"".join(f.read_bytes() for f in files)).hexdigest()


def _entry(stamp: str) -> Any:
    def solve_all(
        designs: tuple[Array, ...], low: int, high: int, mirrored: bool, plates: bool, margin: float,
        steps: Array, folded_steps: Array,
        sizes: Array, rule: Array, plain_sizes: Array, plain_rule: Array, out: Array, code: Array, neighbour: Array,
    ) -> str:  # fmt: skip
        """Answer the designs low..high: ``out``, ``code`` (-1: left to the numpy engine) and ``neighbour``."""
        w, v, h, table = lines(ROWS * W), lines(ROWS * W), lines(SCRATCH), np.empty((TABLE, CARRIED))
        events, met, state = np.empty((4, EVENTS), np.int64), np.empty(EVENTS), np.empty(TABLE, np.int8)
        opened, bent, some = np.empty(TABLE, np.int64), np.empty(TABLE, np.int64), np.empty(TABLE, np.int64)
        taken, found = np.empty(TABLE, np.int64), np.empty((TABLE, ANSWER))
        for base in range(low, high, TABLE):
            n = min(TABLE, high - base)
            order(designs, mirrored, base, n, taken)
            first_pass(
                w, v, table, state, designs, mirrored, taken, base, n, steps[::COARSE], sizes[0], rule, plates, margin,
                found, code, neighbour,
            )  # fmt: skip
            new, folds = follow(w, table, state, opened, bent, n, steps, folded_steps, plates)
            for part in range(2):
                folded = part == 1
                index, many = (bent, folds) if folded else (opened, new)
                solve(w, table, index, many, folded, plates)
                # those whose end was settled at once, but which another neighbour may meet before
                every = many if folded else choose(state, n, CROSSED, index, many)
                cross(w, h, table, index, many, every, folded, events, met)
                answer(w, table, state, index, every, folded, plates, margin, found, code, base)
                many = choose(state, n, ROUGH, some, 0)
                work(w, table, state, some, many, n >= 0, folded, plates, sizes[0 if folded else 1 :], rule, found)
                many = choose(state, n, PLAIN, some, 0)
                work(w, table, state, some, many, n < 0, folded, plates, plain_sizes, plain_rule, found)
            give_out(designs, found, base, n, out)
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

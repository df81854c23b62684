"""The compiled engine at work: how quick, how much it hands on, how much memory it takes.

The table of all engines against the careful script, with its roofline, is made by ``benchmarks/table.py``.
"""

from __future__ import annotations

import time
import tracemalloc
from importlib import import_module
from typing import Any

import pytest
from table import DESIGNS, cpu, problem
from test_ends import designs

import squama


@pytest.mark.parametrize("law", ["edge", "plate"])
def test_compiled_engine(benchmark, law: str) -> None:
    pytest.importorskip("numba")
    compiled = import_module("squama.engines.compiled")
    p = problem(DESIGNS, law)
    start = time.process_time()
    compiled.run(problem(1000, law), 1)
    first = time.process_time() - start
    handed = []

    def count(some: Any) -> Any:
        handed.append(some.eta.size)
        return run(some)

    run, compiled.plain.run = compiled.plain.run, count
    compiled.run(p, 1)
    compiled.plain.run = run
    benchmark.pedantic(lambda: compiled.run(p, 2), rounds=3)
    info = {
        "1 thread, us": cpu(lambda: compiled.run(p, 1))[0] / DESIGNS * 1e6,
        "share left to numpy": sum(handed) / DESIGNS,
        "loading, CPU s": first,
    }
    benchmark.extra_info.update({name: float(f"{value:.3g}") for name, value in info.items()})


def test_memory_is_flat(benchmark) -> None:
    """Beyond its columns and results the engine needs the same for many designs as for few."""
    pytest.importorskip("numba")
    compiled = import_module("squama.engines.compiled")
    own = {}
    for n in (DESIGNS, 8 * DESIGNS):
        p = problem(n, "edge")
        compiled.run(problem(100, "edge"), 1)
        tracemalloc.start()
        solved = compiled.run(p, 1)
        peak = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        own[n] = peak - sum(v.nbytes for v in solved)
    benchmark.pedantic(lambda: squama.solve(**designs(1000), engine="numba"), rounds=1)
    benchmark.extra_info["own MB by designs"] = {n: round(v / 1e6, 2) for n, v in own.items()}
    assert max(own.values()) < 10e6

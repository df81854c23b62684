"""Compiled answers of many designs: how quick, how soon after the start, how much memory they take.

The table against the careful script is made by ``benchmarks/table.py``.
"""

from __future__ import annotations

import os
import subprocess
import sys
import time
import tracemalloc
from pathlib import Path

import pytest
from table import DESIGNS, compiled, cpu

START = """
import squama, numpy as np
squama.solve(eta=3, beta=1.25, lam=0.45, alpha=0.8, theta0=0.2, mu=np.linspace(0, 1, 100_000))
"""


@pytest.mark.parametrize("law", ["edge", "plate"])
def test_many_designs(benchmark, law: str) -> None:
    start = time.process_time()
    compiled(1000, law, 1)()
    first = time.process_time() - start
    benchmark.pedantic(compiled(DESIGNS, law, 2), rounds=3)
    info = {"1 thread, us": cpu(compiled(DESIGNS, law, 1))[0][0] / DESIGNS * 1e6, "loading, CPU s": first}
    benchmark.extra_info.update({name: float(f"{value:.3g}") for name, value in info.items()})


@pytest.mark.parametrize("kept", [False, True])
def test_a_process_that_answers_many(benchmark, tmp_path: Path, kept: bool) -> None:
    """On an empty folder for compiled code and on a filled one."""
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path)}

    def run() -> None:
        subprocess.run([sys.executable, "-c", START], check=True, env=environment, stderr=subprocess.DEVNULL)

    if kept:
        run()
    benchmark.pedantic(run, rounds=3 if kept else 1)


def test_memory_is_flat(benchmark) -> None:
    """Beyond columns and results no more is needed for many designs than for few."""
    compiled(1000, "edge", 1)()
    own = {}
    for n in (DESIGNS, 4 * DESIGNS):
        run = compiled(n, "edge", 1)
        tracemalloc.start()
        run()
        own[n] = tracemalloc.get_traced_memory()[1] / n
        tracemalloc.stop()
    benchmark.pedantic(compiled(1000, "edge", 1), rounds=1)
    benchmark.extra_info["bytes a design"] = {n: round(v) for n, v in own.items()}
    assert max(own.values()) < 600

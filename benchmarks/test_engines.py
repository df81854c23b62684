"""Lock + RED of many designs by every engine against the careful script, per CPU second and in one run; roofline.

The roofline counts the arithmetic of the kernel's source (``twisting.root``, ``twisting.contact``, the law) times its
evaluations per design, over the rate of multiply-and-add measured in the same run: what would be the time if nothing
else were done and no division or root were slower than a product.
"""

from __future__ import annotations

import ast
import inspect
import resource
import textwrap
import time
import tracemalloc
import warnings
from collections.abc import Callable
from importlib import import_module
from typing import Any

import numpy as np
import pytest
from baseline import Design
from baseline import solve as script
from test_ends import designs

import squama
from squama.engines import Problem
from squama.model import laws, twisting

SCRIPT = 300
DESIGNS = 131_072
MARGIN = 0.01
EVALUATIONS = {"engagement": 2, "looks": 12, "root": 7, "neighbours": 5, "figures": 4, "work": 20}
"""Evaluations per design of the compiled engine, about: means over the designs of this benchmark."""


def problem(n: int, law: str) -> Problem:
    return Problem(*designs(n).values(), np.zeros(n), law, "+", MARGIN, "twisting")


def cpu(f: Callable[[], Any], rounds: int = 3) -> tuple[float, float]:
    """CPU and wall seconds of the quickest of some rounds."""
    f()
    both = []
    for _ in range(rounds):
        wall, start = time.perf_counter(), resource.getrusage(resource.RUSAGE_SELF)
        f()
        stop = resource.getrusage(resource.RUSAGE_SELF)
        both.append((stop.ru_utime + stop.ru_stime - start.ru_utime - start.ru_stime, time.perf_counter() - wall))
    return min(b[0] for b in both), min(b[1] for b in both)


def careful() -> float:
    """CPU seconds per design of the careful script with work."""
    few = {name: v.tolist() for name, v in designs(SCRIPT).items()}
    start = time.process_time()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        for eta, beta, lam, alpha, theta0, mu in zip(*few.values(), strict=True):
            script(Design(eta, beta, lam, alpha), theta0, mu, work=True)
    return (time.process_time() - start) / SCRIPT


def operations(*functions: Callable[..., Any]) -> int:
    """Arithmetic operations and square roots in the source of functions."""
    count = 0
    for f in functions:
        for node in ast.walk(ast.parse(textwrap.dedent(inspect.getsource(f)))):
            root = isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "sqrt"
            count += root or isinstance(node, ast.BinOp | ast.UnaryOp)
    return count


def fma_rate() -> float:
    """Multiplications and additions a second of one core, both counted, by compiled code that does nothing else."""
    import numba

    @numba.njit(fastmath={"contract"})
    def chains(n: int) -> float:
        x = np.full(64, 0.5)
        for _ in range(n):
            for i in range(64):
                v = x[i]
                for _ in range(16):
                    v = v * 0.999999 + 1e-7
                x[i] = v
        return float(x.sum())

    n = 200_000
    return 2 * 16 * 64 * n / cpu(lambda: chains(n))[0]


@pytest.mark.parametrize("law", ["edge", "plate"])
def test_engines_against_script(benchmark, law: str) -> None:
    pytest.importorskip("numba")
    compiled, plain = import_module("squama.engines.compiled"), import_module("squama.engines.numpy")
    p = problem(DESIGNS, law)
    start = time.process_time()
    compiled.run(problem(1000, law), 1)
    first = time.process_time() - start
    script_s = careful()
    numpy_s = cpu(lambda: plain.run(p), 1)[0] / DESIGNS
    one, one_wall = cpu(lambda: compiled.run(p, 1))
    two, two_wall = cpu(lambda: compiled.run(p, 2))
    handed = []

    def count(some: Problem) -> Any:
        handed.append(some.eta.size)
        return run(some)

    run, compiled.plain.run = compiled.plain.run, count
    compiled.run(p, 1)
    compiled.plain.run = run
    benchmark.pedantic(lambda: compiled.run(p, 2), rounds=3)
    flops = operations(twisting.root, twisting.contact, laws.LAWS[law]) * sum(EVALUATIONS.values())
    info = {
        "script, us": script_s * 1e6,
        "numpy, us": numpy_s * 1e6,
        "numba 1 thread, us": one / DESIGNS * 1e6,
        "numba 2 threads, us of CPU": two / DESIGNS * 1e6,
        "numpy, times the script per CPU second": script_s / numpy_s,
        "numba 1 thread, times the script per CPU second": script_s / one * DESIGNS,
        "numba 2 threads, times the script per CPU second": script_s / two * DESIGNS,
        "2 threads over 1, wall": one_wall / two_wall,
        "share left to numpy": sum(handed) / DESIGNS,
        "loading, CPU s": first,
        "share of the roofline": flops / fma_rate() / (one / DESIGNS),
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

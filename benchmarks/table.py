"""Lock + RED of many designs, compiled and by scripts, per CPU second and in one run; writes the docs page.

Run by ``make bench``.
"""

from __future__ import annotations

import datetime
import math
import os
import platform
import resource
import time
import warnings
from collections.abc import Callable
from importlib.metadata import version
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from baseline import Design, naive
from baseline import solve as careful
from test_ends import designs

from squama.arrays.compliant_beams import Response, response
from squama.batch import Solved, solved
from squama.model import laws
from squama.types import Array

PAGE = Path(__file__).parents[1] / "docs" / "benchmarks.md"
SCRIPT, NAIVE, ROUNDS = 300, 8, 12
CAREFUL, NAIVE_SCRIPT = "careful script", "naive script"
ONE, TWO = "compiled, 1 core", "compiled, 2 cores"
DESIGNS = 131_072
MARGIN = 0.01
TARGET = 400
"""Times the careful script per CPU second, of compiled code."""


class Line(NamedTuple):
    """Seconds per design: of one core, and on the clock."""

    name: str
    cpu: float
    wall: float


def columns(n: int) -> tuple[Array, ...]:
    """Random designs without a substrate."""
    return (*designs(n).values(), np.zeros(n))


def compiled(n: int, law: str, threads: int) -> Callable[[], Solved]:
    """Answer n designs by compiled code."""
    c = columns(n)
    return lambda: solved(c, law=law, sense="+", margin=MARGIN, load="twisting", threads=threads, few=-1)


def cpu(*runs: Callable[[], Any], rounds: int = 3) -> list[tuple[float, float]]:
    """CPU and wall seconds of the quickest of some rounds.

    The runs take turns of half a second, so that other work on the machine does not meet one of them alone and no core
    starts from rest.
    """
    best, times = [(math.inf, math.inf)] * len(runs), []
    for run in runs:
        run()
        wall = time.perf_counter()
        run()
        times.append(max(1, round(0.5 / (time.perf_counter() - wall))))
    for _ in range(rounds):
        for i in (i for i, n in enumerate(times) for _ in range(n)):
            wall, start = time.perf_counter(), resource.getrusage(resource.RUSAGE_SELF)
            runs[i]()
            stop = resource.getrusage(resource.RUSAGE_SELF)
            used = stop.ru_utime + stop.ru_stime - start.ru_utime - start.ru_stime
            best[i] = min(best[i][0], used), min(best[i][1], time.perf_counter() - wall)
    return best


def script(solve: Callable[..., Any], n: int) -> Callable[[], None]:
    """Run a script that answers one design at a time."""
    few = designs(n)

    def run() -> None:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            for eta, beta, lam, alpha, theta0, mu in zip(*(v.tolist() for v in few.values()), strict=True):
                solve(Design(eta, beta, lam, alpha), theta0, mu, work=True)

    return run


def measured(law: str) -> list[Line]:
    """Both scripts and the compiled code."""
    runs: dict[str, Callable[[], Any]] = {CAREFUL: script(careful, SCRIPT)}
    runs |= {name: compiled(DESIGNS, law, n) for n, name in enumerate((ONE, TWO), 1)}
    lines = [Line(NAIVE_SCRIPT, *cpu(script(naive, NAIVE), rounds=1)[0])]
    lines += [Line(name, *best) for name, best in zip(runs, cpu(*runs.values(), rounds=ROUNDS), strict=True)]
    many = {NAIVE_SCRIPT: NAIVE, CAREFUL: SCRIPT}
    return [Line(one.name, *(v / many.get(one.name, DESIGNS) for v in one[1:])) for one in lines]


def processor() -> str:
    """Name of the processor."""
    info = Path("/proc/cpuinfo")
    names = [row.split(":")[1].strip() for row in info.read_text().splitlines() if row.startswith("model name")]
    return names[0] if names else platform.processor()


def table() -> str:
    """Rows for every way to solve a design with each law, and a sentence on threads and target."""
    found = {law: {line.name: line for line in measured(law)} for law in laws.LAWS}
    heads = "".join(f" `{law}`, µs | speed-up |" for law in found)
    rows = [f"| |{heads}", "|---" * (1 + 2 * len(found)) + "|"]
    for name in next(iter(found.values())):
        cells = [
            f"{float(f'{by[name].cpu * 1e6:.3g}'):g} | {by[CAREFUL].cpu / by[name].cpu:.3g}" for by in found.values()
        ]
        rows.append(" | ".join([f"| {name}", *cells]) + " |")
    threads = " and ".join(f"{by[ONE].wall / by[TWO].wall:.2f}" for by in found.values())
    short = [law for law, by in found.items() if by[CAREFUL].cpu / by[ONE].cpu < TARGET]
    verdict = f"missed with the law {' and '.join(short)}" if short else "met"
    target = f"The target, {TARGET} times as fast as the careful script, is {verdict}."
    end = f"{target} Two cores are {threads} times as fast on the clock."
    return "\n".join([*rows, "", end, ""])


def thick(n: int = 8192) -> str:
    """Curves of thick elastic scales: designs a CPU second, and how they end."""
    r = np.random.default_rng(3)
    beta, alpha, theta0 = r.uniform(0.36, 1.2, n), np.radians(r.uniform(20, 70, n)), np.radians(r.uniform(6, 25, n))
    ratios = {
        "eta": r.choice([2.5, 3.5, 4.5], n), "beta": beta, "lam": r.uniform(0.3, 0.8, n),
        "zeta": r.uniform(0.1, 0.5, n), "alpha": alpha, "theta0": theta0,
        "thickness": np.cos(alpha) * np.sin(theta0) * r.uniform(0.05, 0.44, n),
        "width": r.uniform(1.05, 1.95, n) * 2 * beta * np.cos(alpha), "nu": r.uniform(0.25, 0.49, n), "mu": 0.25,
        "modulus_ratio": 10 ** r.uniform(3, 5.2, n),
    }  # fmt: skip

    def run(threads: int = 1) -> Response:
        return response(np.linspace(0, 0.16, 41), **ratios, threads=threads)

    found = run()
    known = found.in_range.sum()
    (one, wall), (_, two) = cpu(run, lambda: run(2))
    ends = {str(end): (found.end == end).sum() / known for end in np.unique(found.end[found.in_range])}
    told = ", ".join(f"{100 * share:.1f} % {end}" for end, share in ends.items())
    return f"""## Curves of thick elastic scales

`squama.response`: {known} random designs in the range of the joint's law, elastic scales as thick as 5 to 44 % of their
gap, {len(found.torque[0]) - 1} steps to 0.16 rad per pitch with friction, all contacts followed, the joint by its
law: {one / known * 1e6:.0f} µs CPU a design, {known / one:.0f} designs a CPU second; two threads take
{wall / two:.2f} times less time on the clock. Ends: {told}.

"""


INTRODUCTION = """# Benchmarks

Engagement, end and RED (with the frictional work at a margin of 1 %) of {designs} random designs on hinges, by
`python benchmarks/table.py` (a part of `make bench`) on {date}: {cpu}, {python}, {versions}.
The figures are CPU time of one run, on one core if not stated. Other work slows compiled code most. On average
{load:.1f} programs were at work on the {cores} cores when the run ended, so the figures for two cores are rough.

- *naive script* (SciPy): a search for the twist at every inclination (`brentq`), differences, a scan for the end,
  `quad`. Next neighbour only, no folds. Mean of {naive} designs.
- *careful script*: `benchmarks/baseline.py`, the whole job in plain floats with closed forms: first neighbour, fold,
  edges, other neighbours, locks, work; edge law. Mean of {script} designs.
- *compiled*: `squama.solve` for many designs, its code loaded.

"""
KEPT = "## `squama.ends` and a single curve"
"""Where the part of the page begins that is written by hand."""


def main() -> None:
    """Measure and write the page."""
    text = INTRODUCTION.format(
        designs=f"{DESIGNS:,}".replace(",", " "),
        date=datetime.datetime.now(tz=datetime.UTC).date(),
        cpu=processor(),
        python=f"Python {platform.python_version()}",
        versions=", ".join(f"{name} {version(name)}" for name in ("numpy", "scipy", "numba")),
        naive=NAIVE,
        script=SCRIPT,
        load=os.getloadavg()[0],
        cores=os.cpu_count(),
    )
    text += table() + "\n" + thick() + "".join(PAGE.read_text(encoding="utf-8").partition(KEPT)[1:])
    PAGE.write_text(text.rstrip() + "\n", encoding="utf-8")
    print(text)


if __name__ == "__main__":
    main()

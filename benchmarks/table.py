"""Lock + RED of many designs by every engine, per CPU second and in one run, with a roofline; writes the docs page.

Run by ``make bench``. The roofline counts the arithmetic in the kernel's source (``twisting.root``,
``twisting.contact``, the law) times its evaluations per design. It divides multiplications and additions by the
rate of multiply-and-add, divisions and square roots by theirs, all measured in the same run on one core: what would be
the time if nothing else were done. Divisions and roots run beside the rest, so the larger of the two counts.
"""

from __future__ import annotations

import ast
import datetime
import inspect
import math
import os
import platform
import resource
import textwrap
import time
import warnings
from collections import Counter
from collections.abc import Callable
from importlib import import_module
from importlib.metadata import version
from importlib.util import find_spec
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from baseline import Design, naive
from baseline import solve as careful
from test_ends import designs

from squama.engines import Problem
from squama.model import laws, twisting

PAGE = Path(__file__).parents[1] / "docs" / "benchmarks.md"
SCRIPT, NAIVE, ROUNDS = 300, 8, 12
CAREFUL = "scipy, careful script"
DESIGNS = 131_072
MARGIN = 0.01
TARGETS = {"numpy": 300, "numba, 1 thread": 2500}
ROOTS = {"engagement": 3, "neighbours": 8}
"""Evaluations of the contact condition alone, per design, about: means over the designs of this benchmark."""
FULL = {"engagement": 1, "looks": 11, "root": 5, "figures": 2, "work": 20}
"""Evaluations of the whole kernel, likewise."""
SINCOS = Counter(flop=41)
"""Operations of ``compiled_kernel.sincos``, once an evaluation."""


class Line(NamedTuple):
    """Seconds per design: of one core, and on the clock."""

    name: str
    cpu: float
    wall: float


def problem(n: int, law: str) -> Problem:
    return Problem(*designs(n).values(), np.zeros(n), law, "+", MARGIN, "twisting")


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


def operations(*functions: Callable[..., Any]) -> Counter[str]:
    """Multiplications and additions (``flop``), divisions and square roots in the source of functions."""
    count: Counter[str] = Counter()
    for f in functions:
        for node in ast.walk(ast.parse(textwrap.dedent(inspect.getsource(f)))):
            if isinstance(node, ast.BinOp):
                count["divide" if isinstance(node.op, ast.Div) else "flop"] += 1
            elif isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "sqrt":
                count["root"] += 1
    return count


def rates() -> dict[str, float]:
    """Operations a second of one core, by compiled code that does nothing else, eight chains or more at once."""
    import numba

    from squama.engines.compiled_kernel import cos, sin

    def over(step: Callable[[float], float]) -> float:
        f = numba.njit(error_model="numpy", forceinline=True, fastmath={"contract"})(step)

        @numba.njit(error_model="numpy", fastmath={"contract"})
        def chains(x: Any, n: int) -> None:
            for _ in range(n):
                for i in range(64):
                    v = x[i]
                    for _ in range(16):
                        v = f(v)
                    x[i] = v

        n = 20_000
        x = np.full(64, 0.5)
        return 16 * 64 * n / cpu(lambda: chains(x, n), rounds=5)[0][0]

    return {
        "flop": 2 * over(lambda v: v * 0.999999 + 1e-7),
        "divide": over(lambda v: 1.3 / v),
        "root": over(lambda v: math.sqrt(v)),  # noqa: PLW0108
        "sine and cosine": over(lambda v: sin(v) * cos(v)),
    }


def roofline(law: str, rate: dict[str, float]) -> tuple[float, float]:
    """Least seconds per design for multiplications and additions, and for divisions and roots."""
    one = operations(twisting.root) + SINCOS
    whole = one + operations(twisting.contact, laws.LAWS[law])
    ends = {name: sum(ROOTS.values()) * one[name] + sum(FULL.values()) * whole[name] for name in whole}
    return ends["flop"] / rate["flop"], ends["divide"] / rate["divide"] + ends["root"] / rate["root"]


def measured(law: str) -> list[Line]:
    """Both scripts and every engine that is installed."""
    p = problem(DESIGNS, law)
    plain = import_module("squama.engines.numpy")
    runs = {CAREFUL: script(careful, SCRIPT), "numpy": lambda: plain.run(p)}
    if find_spec("numba"):
        compiled = import_module("squama.engines.compiled")
        runs |= {f"numba, {n} thread{'s' * (n > 1)}": lambda n=n: compiled.run(p, n) for n in (1, 2)}
    lines = [Line("scipy, naive", *cpu(script(naive, NAIVE), rounds=1)[0])]
    lines += [Line(name, *best) for name, best in zip(runs, cpu(*runs.values(), rounds=ROUNDS), strict=True)]
    if find_spec("jax"):
        import jax

        xla, device = import_module("squama.engines.xla"), jax.devices()[0]
        name = "jax, CPU" if device.platform == "cpu" else f"jax, {device.device_kind}"
        lines.append(Line(name, *cpu(lambda: xla.run(p), rounds=1)[0]))
    many = {"scipy, naive": NAIVE, CAREFUL: SCRIPT}
    return [Line(one.name, *(v / many.get(one.name, DESIGNS) for v in one[1:])) for one in lines]


def processor() -> str:
    """Name of the processor."""
    info = Path("/proc/cpuinfo")
    names = [row.split(":")[1].strip() for row in info.read_text().splitlines() if row.startswith("model name")]
    return names[0] if names else platform.processor()


def table(law: str, rate: dict[str, float] | None) -> str:
    """One law: a row for every way to answer, and the roofline."""
    lines = measured(law)
    by_name = {line.name: line for line in lines}
    unit = by_name[CAREFUL].cpu
    rows = ["| | CPU time per design, µs | times the careful script | target |", "|---|---|---|---|"]
    for line in lines:
        target = TARGETS.get(line.name, "")
        rows.append(f"| {line.name} | {line.cpu * 1e6:.3g} | {unit / line.cpu:.3g} | {target} |")
    text = f"## Law `{law}`\n\n" + "\n".join(rows) + "\n"
    one, two = by_name.get("numba, 1 thread"), by_name.get("numba, 2 threads")
    if one and two and rate:
        flop, slow = roofline(law, rate)
        text += (
            f"\nTwo threads take {one.wall / two.wall:.2f} times less time on the clock than one (target: 1.9). "
            f"The roofline of the compiled engine is {flop * 1e9:.0f} ns per design for multiplications and additions"
            f" and {slow * 1e9:.0f} ns for divisions and roots: it runs at {max(flop, slow) / one.cpu:.0%} of it.\n"
        )
    short = [
        f"{name} reaches {unit / by_name[name].cpu:.0f} of {target}"
        for name, target in TARGETS.items()
        if name in by_name and unit / by_name[name].cpu < target
    ]
    return text + (f"\nShort of the target: {', '.join(short)}.\n" if short else "")


INTRODUCTION = """# Benchmarks

Engagement, end and RED (with the frictional work at a margin of 1 %) of {designs:,} random designs, made by
`python benchmarks/table.py` (a part of `make bench`) on {date}: {cpu}, {python}, {versions}. All figures
come from one run and are CPU time, so that they compare one core with one core. Other work slows them all
the same, compiled code most, for it shares caches: when the run ended, {load:.1f} programs were at work on
the {cores} cores, this one included. The script and the engines take turns of half a second, and the quickest run
of each counts. The figure for two threads means little unless both cores were free.

- *scipy, naive*: what one writes first. The twist is searched for at every inclination (`brentq`), its rate is a
  difference, the path is scanned for the end and `quad` integrates. Next neighbour only, no folds.
  Mean of {naive} designs.
- *scipy, careful script*: `benchmarks/baseline.py`, the whole job in plain floats with closed forms: first neighbour,
  fold, edges, other neighbours, locks, work. Edge law. Mean of {script} designs. It is the unit of the ratios.
- *numpy*, *numba*, *jax*: the [engines](howto/arrays.md#engines). The jax line needs `pip install squama[jax]`; it is a
  GPU where JAX finds one.

"""
REASONS = """## `squama.ends` and a single curve

`squama.ends` gives engagement and end only. Against the careful script it is 270 to 390 times faster per CPU second
where the script integrates the frictional work too (`quad`), and 115 to 165 times where it leaves that out: 2.6 to
3.5 µs a design against 980 and 415 µs. `benchmarks/test_ends.py` measures both.

A curve of 200 points, warm: the solved path with all its variables takes 1.0 to 1.1 ms (0.4 ms of it for the
evaluation of the points); that is the figure of "200 points under 1 ms". `squama.twist` looks for every other contact
of the plates and labels the answer as well, which makes 2.1 to 2.6 ms. `benchmarks/test_curve.py` measures all three.

## Fits, designs, tolerances and the explorer

Measured one after the other on two free cores; imports and compiled code loaded.

| what | figure | by |
|---|---|---|
| fit of a loop, 202 points, 3 parameters | 0.03 s CPU | `benchmarks/test_fit.py` |
| design for a lock (4096 starts screened, 36 refined) | 0.4 s CPU | `benchmarks/test_design.py` |
| design for five goals that contradict each other | 2.6 s CPU | `benchmarks/test_design.py` |
| front of 20 000 evaluations | 3.0 to 3.2 s, one thread | `squama.pareto("examples/front.toml")` |
| 1 048 576 beams within their tolerances, with all statistics | 0.9 to 1.0 s CPU | `benchmarks/test_uncertainty.py` |
| Sobol indices of 8 tolerances, 40 960 beams | 3.1 s CPU | `benchmarks/test_uncertainty.py` |
| explorer, from slider to picture in Chromium, median of 30 | 108 to 123 ms | `benchmarks/test_explorer.py` |
| the same, to the plots | 142 to 189 ms | `benchmarks/test_explorer.py` |

## What limits the compiled engine

Evaluations per design, estimated: {full} of the whole kernel ({full_parts}) and {roots} of the contact condition
alone ({root_parts}). Most designs are settled by one coarse look and one Gauss rule and leave their block of lanes
for the work only, which is done for full blocks. Designs are taken in the order of their reach and of a guess of how
far they go, since all lanes of a block wait for the slowest. An evaluation takes 2.8 ns in a loop of its own, about
twice its share of the roofline: long chains of operations, and divisions beside them, leave the units idle. The rest
of the time goes to what is kept of the samples to show that nothing hides between them, to handing results out, and
to the designs that are gathered anew, some 40 % for one reason or another: folded paths (13 % with the edge law, and
the dearest), ends that need closer samples (6 %), paths that another neighbour may end (11 %), work that needs other
nodes.

The numpy engine runs the kernel as a flat program of some 110 passes over arrays in the cache, and needs 39 evaluations
of the whole kernel and 12 of the contact condition alone per design (edge law, counted; plate law 34 and 11). An
evaluation takes 30 to 50 ns, which makes half of the time; as much again goes to taking designs out of arrays
and putting results back, to the root finder, and to the tests that nothing hides between samples. A square root takes
as long as seven multiplications there, for NumPy computes one at a time.
"""


def main() -> None:
    """Measure and write the page."""
    rate = rates() if find_spec("numba") else None
    packages = [name for name in ("numpy", "scipy", "numba", "jax") if find_spec(name)]
    text = INTRODUCTION.format(
        designs=DESIGNS,
        date=datetime.datetime.now(tz=datetime.UTC).date(),
        cpu=processor(),
        python=f"Python {platform.python_version()}",
        versions=", ".join(f"{name} {version(name)}" for name in packages),
        naive=NAIVE,
        script=SCRIPT,
        load=os.getloadavg()[0],
        cores=os.cpu_count(),
    )
    for law in laws.LAWS:
        text += table(law, rate) + "\n"
    if rate:
        text += "## Rates of one core\n\n| | 10⁹ a second |\n|---|---|\n"
        names = {"flop": "multiply and add, both counted", "divide": "divide", "root": "square root"}
        text += "".join(f"| {names.get(name, name)} | {value / 1e9:.3g} |\n" for name, value in rate.items()) + "\n"
        parts = {kind: ", ".join(f"{name} {n}" for name, n in of.items()) for kind, of in (("f", FULL), ("r", ROOTS))}
        full, roots = sum(FULL.values()), sum(ROOTS.values())
        text += REASONS.format(full=full, full_parts=parts["f"], roots=roots, root_parts=parts["r"])
    PAGE.write_text(text.rstrip() + "\n", encoding="utf-8")
    print(text)


if __name__ == "__main__":
    main()

"""Ends of many designs against the careful script, as a ratio per CPU second measured in one run."""

from __future__ import annotations

import time
import warnings

import numpy as np
from baseline import Design, solve

import squama

SCRIPT = 300
DESIGNS = 100_000


def designs(n: int) -> dict[str, np.ndarray]:
    """Random designs of the ranges that the theory was checked in."""
    g = np.random.default_rng(2020)
    return {
        "eta": g.uniform(1.5, 6, n),
        "beta": g.uniform(0.3, 2, n),
        "lam": g.uniform(0.2, 1, n),
        "alpha": np.radians(g.uniform(1, 80, n)),
        "theta0": np.radians(g.uniform(3, 20, n)),
        "mu": g.uniform(0, 2, n),
    }


def test_ends_against_script(benchmark) -> None:
    few = {name: v.tolist() for name, v in designs(SCRIPT).items()}
    cpu = {}
    for work in (False, True):
        start = time.process_time()
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            script = []
            for eta, beta, lam, alpha, theta0, mu in zip(*few.values(), strict=True):
                script.append(solve(Design(eta, beta, lam, alpha), theta0, mu, work=work))
        cpu[work] = (time.process_time() - start) / SCRIPT
    many = designs(DESIGNS)
    squama.ends(**few)
    start = time.process_time()
    benchmark.pedantic(lambda: squama.ends(**many), rounds=3)
    ours = (time.process_time() - start) / 3 / DESIGNS
    # both solve the same problem
    e = squama.ends(**few)
    np.testing.assert_allclose([s[0] for s in script], e.phi_e, rtol=1e-9)
    np.testing.assert_allclose([s[1] for s in script], e.theta_end, rtol=1e-6)
    benchmark.extra_info["script with work, us per design"] = round(cpu[True] * 1e6, 1)
    benchmark.extra_info["script without work, us per design"] = round(cpu[False] * 1e6, 1)
    benchmark.extra_info["ends, us per design"] = round(ours * 1e6, 2)
    benchmark.extra_info["ratio per CPU second"] = round(cpu[True] / ours, 1)
    benchmark.extra_info["ratio without work"] = round(cpu[False] / ours, 1)

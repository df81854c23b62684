"""Warm decays: 50 cycles of a hinged design, and the damping of many designs."""

from __future__ import annotations

import math

import numpy as np

import squama

MAIN = {"eta": 3, "beta": 1.25, "lam": 0.45, "alpha": math.pi / 4, "theta0": math.radians(10), "kappa": 2}


def test_decay_of_50_cycles(benchmark) -> None:
    v = benchmark(lambda: squama.free_vibration(**MAIN, mu=0.5, amplitude=0.22, swings=50))
    assert v.end == "rings"
    assert benchmark.stats.stats.median < 0.02


def test_damping_of_10000_designs(benchmark) -> None:
    """A tenth of 1e5 in 20 s."""
    mu = np.linspace(0, 0.5, 10_000)
    v = benchmark(lambda: squama.free_vibration(**MAIN, mu=mu, amplitude=0.2))
    assert (v.end == "rings").all()
    assert benchmark.stats.stats.median < 2

"""A million beams within their tolerances, statistics included, and Sobol indices; CPU time on standard output."""

from __future__ import annotations

import time

import pytest

import squama

BEAM = squama.Beam.from_toml("examples/pla_on_vps.toml")
VARY = {
    "scale.alpha": "+- 1 deg",
    "scale.theta0": "+- 1 deg",
    "scale.length": "+- 1 %",
    "scale.thickness": "+- 5 % 2 sd",
    "beam.pitch": "+- 1 %",
    "substrate.thickness": "+- 1 %",
    "substrate.youngs_modulus": "+- 10 % triangular",
    "mu": "normal(0.25, 0.03)",
}


@pytest.mark.parametrize("sampler", ["sobol", "random"])
def test_a_million_samples(benchmark, sampler) -> None:
    squama.uncertainty(BEAM, VARY, samples=2**17, joint="hinge")

    def run() -> None:
        start = time.process_time()
        squama.uncertainty(BEAM, VARY, samples=10**6, sampler=sampler, before="240 deg total", joint="hinge")
        benchmark.extra_info["cpu_s"] = time.process_time() - start

    benchmark.pedantic(run, rounds=3)
    print(f"{sampler}: {benchmark.extra_info['cpu_s']:.2f} s of processor time")


def test_indices(benchmark) -> None:
    squama.uncertainty(BEAM, VARY, samples=3200, indices=64, joint="hinge")
    benchmark.pedantic(lambda: squama.uncertainty(BEAM, VARY, samples=3200, indices=4096, joint="hinge"), rounds=3)


def test_a_hundred_thousand_compliant_beams(benchmark) -> None:
    beam = squama.Beam.from_toml("examples/stiff_skin.toml")
    vary = {"scale.length": "+- 1 %", "scale.youngs_modulus": "+- 10 %", "mu": "normal(0.25, 0.03)"}
    squama.uncertainty(beam, vary, samples=3200)

    def run() -> None:
        start = time.process_time()
        squama.uncertainty(beam, vary, samples=10**5)
        benchmark.extra_info["cpu_s"] = time.process_time() - start

    benchmark.pedantic(run, rounds=1)
    print(f"{benchmark.extra_info['cpu_s']:.1f} s of processor time")

"""CPU seconds of inverse design and of fronts of 20 000 evaluations; imports left out."""

from __future__ import annotations

import time

import squama
from squama.inverse.target import read_target


def test_design_of_a_lock(benchmark) -> None:
    target = read_target("examples/lock_at_120.toml")
    squama.inverse_design(target)
    start = time.process_time()
    found = benchmark.pedantic(lambda: squama.inverse_design(target), rounds=3, iterations=1)
    benchmark.extra_info["CPU s per design"] = round((time.process_time() - start) / 3, 2)
    assert found.met


def test_design_for_five_goals_that_contradict_each_other(benchmark) -> None:
    data = {
        "target": {
            "lock": "120 deg total",
            "stiffness": "0.03 N m^2",
            "RED": "at least 0.2",
            "points": [{"twist": "80 deg total", "torque": "60 N mm"}],
            "tangent": [{"twist": "80 deg total", "stiffness": "at most 0.2 N m^2"}],
        },
        "vary": {
            "scale.length": ("30 mm", "80 mm"),
            "scale.width": ("15 mm", "40 mm"),
            "scale.alpha": ("30 deg", "70 deg"),
            "scale.theta0": ("5 deg", "20 deg"),
            "scale.embedded": ("3 mm", "10 mm"),
            "scale.thickness": ("0.4 mm", "1.2 mm"),
            "beam.pitch": ("12 mm", "25 mm"),
            "substrate.thickness": ("8 mm", "20 mm"),
            "friction.mu": (0.1, 0.4),
        },
        "limits": {"gap": "1 mm", "strain": "40 %"},
    }
    target = read_target(data, beam=squama.Beam.from_toml("examples/pla_on_vps.toml"))
    start = time.process_time()
    benchmark.pedantic(lambda: squama.inverse_design(target), rounds=2, iterations=1)
    benchmark.extra_info["CPU s per design"] = round((time.process_time() - start) / 2, 2)


def test_design_of_a_limb_with_eight_variables(benchmark) -> None:
    target = read_target("examples/limb.toml")
    squama.inverse_design(target)
    start = time.perf_counter()
    found = benchmark.pedantic(lambda: squama.inverse_design(target), rounds=2, iterations=1)
    benchmark.extra_info["s per design, two threads"] = round((time.perf_counter() - start) / 2, 2)
    assert found.met


def test_front_of_20_000_compliant_beams(benchmark) -> None:
    data = {
        "vary": {
            "scale.length": ("40 mm", "100 mm"),
            "scale.width": ("14 mm", "40 mm"),
            "scale.thickness": ("0.8 mm", "3.2 mm"),
            "scale.alpha": ("20 deg", "70 deg"),
            "scale.theta0": ("8 deg", "25 deg"),
            "substrate.width": ("14 mm", "60 mm"),
        },
        "front": {"maximise": ["stiffness_ratio", "engagement"], "minimise": ["stress"], "at": "150 deg total"},
    }
    beam = squama.Beam.from_toml("examples/pla_on_vps.toml")
    start = time.perf_counter()
    front = benchmark.pedantic(lambda: squama.pareto(data, beam=beam), rounds=1, iterations=1)
    benchmark.extra_info["s per front, two threads"] = round(time.perf_counter() - start, 2)
    assert front.population * front.generations == 20_000


def test_front_of_20_000_evaluations(benchmark) -> None:
    squama.pareto("examples/front.toml", population=200, generations=4)
    start = time.process_time()
    front = benchmark.pedantic(lambda: squama.pareto("examples/front.toml"), rounds=2, iterations=1)
    benchmark.extra_info["CPU s per front"] = round((time.process_time() - start) / 2, 2)
    assert front.population * front.generations == 20_000

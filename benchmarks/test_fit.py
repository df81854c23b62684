"""Fits: a loop of about 200 points with three parameters, and one evaluation of the model with its derivatives."""

from __future__ import annotations

import numpy as np

import squama
from squama.identify.estimate import derivatives
from squama.identify.prepare import placed
from squama.identify.records import read, record
from squama.identify.unknowns import ask

BEAM = squama.Beam.from_ratios(youngs_modulus="2 MPa", mu=0.3)
NAMES = ("mu", "K_theta", "theta0")


def loop() -> dict[str, np.ndarray]:
    c = squama.cycle(BEAM, "0.2 rad/pitch", points=80, joint="hinge")
    torque = c["T"].values
    noise = np.random.default_rng(1).normal(0, 0.02 * torque.max(), torque.size)
    return {"phi": c.phi.values, "T": torque + noise}


def test_fit_of_a_loop_with_three_parameters(benchmark) -> None:
    data, start = loop(), BEAM.replace(friction={"mu": 0.1})
    benchmark.extra_info["points"] = data["T"].size
    fit = benchmark(lambda: squama.fit(data, start, NAMES, joint="hinge"))
    assert abs(fit.values["mu"] - 0.3) < 4 * fit.errors["mu"]


def test_torque_and_derivatives_at_200_points(benchmark) -> None:
    asked = ask(BEAM, "twisting", NAMES)
    forward = placed(record(read(loop(), BEAM, "twisting"), BEAM), asked, "edge").points
    p = asked.start

    def once() -> None:
        forward.torque(asked.physical(p))
        derivatives(forward, asked, p)

    benchmark(once)

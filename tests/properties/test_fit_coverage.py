"""Stated intervals hold what they say: of fits to data with known noise, about 95 % lie within two standard errors."""

from __future__ import annotations

import math

import numpy as np
import pytest

import squama

SEED = 11
BEAM = squama.Beam.from_ratios(youngs_modulus="2 MPa", mu=0.25)
NAMES = ("mu", "K_theta", "theta0")
TRUE = np.array([0.25, BEAM.joint_stiffness, BEAM.scale.theta0])
CASES = {
    "loading": ("0, 0.2 rad/pitch", NAMES[:2], 0.02, 40),
    "loop": ("0, 0.2, 0 rad/pitch", NAMES, 0.02, 20),
    "cycles of a noise that is given": ("0, 0.18, 0.1, 0.2, 0 rad/pitch", NAMES, 0.01, 12),
}


def share(case: str, sets: int) -> np.ndarray:
    """Part of the sets whose estimates lie within two standard errors of the true values, by parameter."""
    history, names, noise, points = CASES[case]
    c = squama.cycle(BEAM, history, points=points, joint="hinge")
    torque = c["T"].values
    sigma = noise * float(torque.max())
    rng = np.random.default_rng(SEED)
    start = BEAM.replace(friction={"mu": 0.1}, joint={"stiffness": 0.7 * BEAM.joint_stiffness})
    hits = np.zeros(len(names))
    for _ in range(sets):
        data = {"phi": c.phi.values, "T": torque + rng.normal(0, sigma, torque.size)}
        fit = squama.fit(data, start, names, noise=sigma if "given" in case else None, starts=2, joint="hinge")
        error = np.sqrt(np.diag(fit.covariance))
        hits += np.abs(fit.estimates - TRUE[: len(names)]) < 2 * error
    return hits / sets


@pytest.mark.slow
@pytest.mark.parametrize("case", list(CASES))
def test_coverage_of_300_sets(case: str) -> None:
    found = share(case, 300)
    assert ((found >= 0.91) & (found <= 0.99)).all(), found


@pytest.mark.slow
@pytest.mark.parametrize("case", list(CASES)[1:])
def test_coverage_of_fewer_sets(case: str) -> None:
    """With so few sets a right interval misses these bounds once in a thousand."""
    sets = 60
    found = share(case, sets)
    spread = 3.3 * math.sqrt(0.954 * 0.046 / sets)
    assert (found >= 0.954 - spread).all(), found

"""Columns of the batch engine from dimensions: the same as the beams', to a complex step, and which rows are beams."""

from __future__ import annotations

import numpy as np
import pytest

import squama
from squama.errors import InputError
from squama.study.columns import beam_at, columns, valid
from squama.study.hinge_columns import solved

BEAM = squama.Beam.from_toml("examples/pla_on_vps.toml")
RANGES = {
    "scale.length": (0.05, 0.07),
    "scale.width": (0.02, 0.03),
    "scale.embedded": (0.004, 0.008),
    "scale.thickness": (0.0006, 0.001),
    "scale.alpha": (0.8, 1.2),
    "scale.theta0": (0.2, 0.3),
    "substrate.width": (0.01, 0.04),
    "substrate.thickness": (0.012, 0.018),
    "substrate.youngs_modulus": (1e6, 2e6),
    "substrate.poisson_ratio": (0.3, 0.49),
    "beam.pitch": (0.018, 0.022),
    "friction.mu": (0.1, 0.3),
}


def sample(n, seed=3):
    rng = np.random.default_rng(seed)
    return {name: rng.uniform(*span, n) for name, span in RANGES.items()}


def short(name):
    return {"scale.alpha": "alpha", "scale.theta0": "theta0", "friction.mu": "mu"}.get(name, name)


@pytest.mark.parametrize("load", ["twisting", "bending"])
def test_rows_are_the_beams(load):
    values = sample(20)
    c = columns(BEAM, values, load=load)
    found = solved(c, load=load)
    for i in range(20):
        beam = beam_at(BEAM, load, {short(name): float(v[i]) for name, v in values.items()})
        rigidity = beam.torsional_rigidity if load == "twisting" else beam.bending_rigidity
        assert c.K[i] == pytest.approx(beam.joint_stiffness, rel=1e-13)
        assert c.rigidity[i] == pytest.approx(rigidity, rel=1e-13)
        assert (c.eta[i], c.beta[i], c.lam[i]) == pytest.approx((beam.eta, beam.beta, beam.lam), rel=1e-13)
        if load == "bending":
            assert found["torque"][i] == pytest.approx(float(squama.bend(beam, points=3, joint="hinge").M_c), rel=1e-9)


@pytest.mark.parametrize("name", [n for n in RANGES if n != "friction.mu"])
def test_a_complex_step_goes_through(name):
    values = sample(5)
    moved = {**values, name: values[name] + 1e-30j}
    step = 1e-6 * values[name]
    up, down = (columns(BEAM, {**values, name: values[name] + s * step}) for s in (1, -1))
    c = columns(BEAM, moved)
    for field in ("eta", "beta", "lam", "alpha", "theta0", "K", "d", "rigidity", "ratio"):
        exact = np.imag(getattr(c, field)) / 1e-30 + np.zeros(5)
        differences = (getattr(up, field) - getattr(down, field)) / (2 * step)
        scale = np.abs(getattr(up, field) / values[name]).max()
        np.testing.assert_allclose(exact, differences, atol=1e-8 * scale, rtol=1e-7, err_msg=field)


def test_valid_rows_are_those_that_make_a_beam():
    rng = np.random.default_rng(5)
    n = 200
    values = {
        "scale.length": rng.uniform(-0.01, 0.05, n),
        "scale.alpha": rng.uniform(-0.3, 1.9, n),
        "scale.embedded": rng.uniform(0, 0.1, n),
        "scale.theta0": rng.uniform(0.1, 0.6, n),
        "substrate.poisson_ratio": rng.uniform(0, 0.6, n),
        "beam.pitch": 10 ** rng.uniform(-4, -1, n),
        "friction.mu": rng.uniform(-0.1, 11, n),
    }
    told = valid(columns(BEAM, values))
    assert told.shape == (n,)
    assert 0.1 < told.mean() < 0.9
    for i in range(n):
        try:
            beam_at(BEAM, "twisting", {short(name): float(v[i]) for name, v in values.items()})
            made = True
        except InputError:
            made = False
        assert made == told[i], i


def test_a_negative_tab_is_no_beam():
    assert valid(columns(BEAM, {"scale.embedded": np.array([-0.001, 0.001])})).tolist() == [False, True]

"""Fits and plans of bent beams, and of scales on both faces, by thick elastic scales on joints that give."""

from __future__ import annotations

import functools

import numpy as np
import pytest

import squama

BEAM = squama.Beam.from_toml("examples/stiff_skin.toml")
FOUND = ("mu", "K_theta", "E_B")
HOW = {"nuisances": "none", "starts": 2, "machine": "rigid"}


def true(beam):
    E, K = beam.substrate.youngs_modulus, beam.joint_stiffness
    return beam.replace(friction={"mu": 0.3}, joint={"stiffness": 1.1 * K}), {"mu": 0.3, "K_theta": 1.1 * K, "E_B": E}


@functools.cache
def loop(scales=None, faces="one", load="bending"):
    """The loop of a specimen whose friction and joint are not those of its file; angle and torque."""
    beam = BEAM.replace(scales=scales, faces=faces)
    found = squama.cycle(true(beam)[0], "0.12 rad/pitch", load=load, points=15)
    names = ("psi", "M") if load == "bending" else ("phi", "T")
    return beam, {name: found[name].values for name in names}


@pytest.mark.parametrize(
    ("scales", "faces", "load"),
    [
        pytest.param(None, "one", "bending", marks=pytest.mark.slow),
        pytest.param(5, "one", "bending", marks=pytest.mark.slow),
        (None, "mirrored", "bending"),
        pytest.param(None, "turned, shifted", "twisting", marks=pytest.mark.slow),
    ],
)
@pytest.mark.usefixtures("alone")
def test_a_loop_without_noise_gives_its_parameters_back(scales, faces, load):
    beam, points = loop(scales, faces, load)
    fit = squama.fit(points, beam, FOUND, load=load, **HOW)
    assert fit.joint == "compliant"
    assert fit.slope.ratio == pytest.approx(1, abs=1e-6)
    for name, value in true(beam)[1].items():
        # the friction stops the search, whose derivatives are differences of walks
        assert fit.values[name] == pytest.approx(value, rel=1e-4), name


@pytest.mark.usefixtures("alone")
def test_the_curve_of_a_fitted_bent_beam_is_that_of_its_cycle():
    beam, points = loop()
    noise = np.random.default_rng(7).normal(0, 0.003 * points["M"].max(), points["M"].size)
    fit = squama.fit({**points, "M": points["M"] + noise}, beam, "mu,E_B", load="bending", **HOW)
    again = squama.cycle(fit.beam, "0.12 rad/pitch", load="bending", points=15)
    # the place where the scales slide again moves with the friction
    ways = [np.cumsum(np.abs(np.diff(psi, prepend=0.0))) for psi in (points["psi"], again.psi.values)]
    M = np.interp(*ways, again["M"].values)
    np.testing.assert_allclose(fit.fitted, M, rtol=0, atol=2e-3 * points["M"].max())
    far = fit.predict("0.1 rad/pitch", samples=10, points=10)
    assert np.all(far.M_low <= far.M_high)
    # hinges with the same freedom describe thick scales on a soft bar worse
    assert fit.rival is None or fit.rival.found is None or fit.rival.found.rms > fit.rms


def test_a_factor_of_the_bar_in_bending_is_of_hinges():
    beam, points = loop()
    fit = squama.fit(points, beam, "mu,K_theta,C_f", load="bending", **HOW)
    assert fit.joint == "hinge"
    assert any(note.startswith("C_f is found on hinges only in bending") for note in fit.notes)


@pytest.mark.parametrize("door", ["fit", "plan"])
def test_hinges_take_scales_on_one_face(door):
    beam, points = loop(faces="mirrored")
    how = {"load": "bending", "joint": "hinge"}
    ask = {
        "fit": lambda: squama.fit(points, beam, FOUND[:2], **how),
        "plan": lambda: squama.plan(beam, FOUND[:2], noise="0.05 N mm", **how),
    }[door]
    with pytest.raises(squama.InputError, match=r'beam\.faces = "mirrored": is not covered by a fit on hinges'):
        ask()


def test_a_plan_in_bending_speaks_of_bending():
    plan = squama.plan(BEAM.replace(scales=None), ("mu", "E_B"), load="bending", noise="0.05 N mm", points=10)
    assert plan.joint == "compliant"
    text = plan.summary()
    assert "largest moment" in text
    assert "twist for" not in text

"""Dimensions of the beam that have a tolerance: found from that and from the points, with the joint as it is."""

from __future__ import annotations

import functools

import numpy as np
import pytest

import squama
from squama.cli import main
from squama.curves import compliant
from squama.errors import InputError
from squama.identify import estimate

BEAM = squama.Beam.from_toml("examples/pla_on_vps.toml").replace(scales=None, hold="bend, lateral bend")
SKIN = squama.Beam.from_toml("examples/stiff_skin.toml").replace(scales=5, hold="bend, lateral bend")
DEGREE = np.radians(1)
ALPHA = BEAM.scale.alpha
NOISE = 5e-3
pytestmark = pytest.mark.usefixtures("alone")


@functools.cache
def loop(off=0.0, sigma=NOISE, softer=1.0):
    beam = BEAM.replace(
        friction={"mu": 0.25},
        joint={"stiffness": 0.75},
        scale={"alpha": ALPHA + off},
        substrate={"youngs_modulus": softer * BEAM.substrate.youngs_modulus},
    )
    c = squama.cycle(beam, "0.1 rad/pitch", joint="hinge", ideal=True, points=60)
    noise = np.random.default_rng(4).normal(size=c.phi.size)
    return {"phi": c.phi.values, "T": c["T"].values + sigma * noise}


def fitted(data, tolerances=None, **given):
    given = {"joint": "hinge", "nuisances": "none", "starts": 1, "machine": "rigid", **given}
    return squama.fit(data, given.pop("beam", BEAM), ("mu", "K_theta"), tolerances=tolerances, **given)


def test_an_angle_that_is_not_its_files_is_found():
    data = loop(DEGREE)
    without = fitted(data)
    assert without.values["K_theta"] > 1.1 * 0.75
    fit = fitted(data, {"scale.alpha": "+- 1.5 deg sd"})
    assert fit.parameters == ("mu", "K_theta", "scale.alpha")
    for name, true in {"mu": 0.25, "K_theta": 0.75, "scale.alpha": ALPHA + DEGREE}.items():
        assert abs(fit.values[name] - true) < 3 * fit.errors[name], name
    assert fit.errors["scale.alpha"] < 0.2 * DEGREE
    # tolerance: the noise
    assert fit.rms == pytest.approx(NOISE, rel=0.15)
    assert without.rms > 1.5 * fit.rms
    assert fit.beam.scale.alpha == fit.values["scale.alpha"]
    assert fit.holds
    # the curve of the beam that is written is the fitted one
    c = squama.cycle(fit.beam, "0.1 rad/pitch", joint="hinge", ideal=True, points=60)
    loading = np.flatnonzero(fit.branch == "loading")
    expected = np.interp(data["phi"][loading], c.phi.values[c.leg == 1], c["T"].values[c.leg == 1])
    # tolerance: the torque is linear in the angle about a value a tenth of its error off
    np.testing.assert_allclose(fit.fitted[loading], expected, rtol=2e-3, atol=2e-3)
    drawn = fit.curve()
    assert np.interp(0.09, drawn.load[drawn.leg == 1], drawn.torque[drawn.leg == 1]) == pytest.approx(
        np.interp(0.09, data["phi"][loading], fit.fitted[loading]), rel=2e-3
    )


def test_an_angle_within_its_tolerance_makes_errors_honest():
    data = loop(0.2 * DEGREE)
    narrow, wide = fitted(data), fitted(data, {"scale.alpha": ("uniform", ALPHA - DEGREE / 2, ALPHA + DEGREE / 2)})
    assert abs(narrow.values["K_theta"] - 0.75) > 3 * narrow.errors["K_theta"]
    assert abs(wide.values["K_theta"] - 0.75) < 2 * wide.errors["K_theta"]
    assert wide.errors["K_theta"] > 2 * narrow.errors["K_theta"]


def test_a_dimension_of_which_the_points_say_nothing_is_its_tolerance():
    data = loop()
    fit = fitted(data, {"scale.thickness": ("normal", 0.9e-3, 2e-5)})
    assert fit.values["scale.thickness"] == pytest.approx(0.9e-3, rel=1e-6)
    assert fit.errors["scale.thickness"] == pytest.approx(2e-5, rel=1e-3)
    plain = fitted(data)
    for name in ("mu", "K_theta"):
        assert fit.values[name] == pytest.approx(plain.values[name], rel=1e-4)
        assert fit.errors[name] == pytest.approx(plain.errors[name], rel=1e-2)


def test_a_section_of_the_bar_changes_its_slope():
    """A bar whose width has a tolerance looks like one whose modulus has: both have the slope before engagement."""
    data = loop(softer=0.93)
    fit = fitted(data, {"substrate.width": "+- 10 % sd"})
    ratio = BEAM.replace(substrate={"width": fit.values["substrate.width"]})
    bar = ratio.G_B * ratio.J / (BEAM.G_B * BEAM.J)
    assert fit.errors["substrate.width"] < 0.08 * BEAM.substrate.width
    assert bar == pytest.approx(0.93, abs=0.06)


@pytest.mark.slow
def test_scales_that_are_walked():
    held = SKIN.replace(joint={"stiffness": compliant.Held.of(SKIN).K_theta * 1.1})
    from squama.beam import matrixfile

    K = compliant.Held.of(held)
    held = held.replace(joint={"matrix": matrixfile.stored(held, K.K), "stiffness": None, "inclusion_factor": None})
    true = held.replace(friction={"mu": 0.25}, scale={"alpha": SKIN.scale.alpha + 0.7 * DEGREE})
    c = squama.cycle(true, "0.1 rad/pitch", points=30)
    data = {"phi": c.phi.values, "T": c["T"].values}
    given = {"joint": "compliant", "beam": held}
    fit = fitted(data, {"scale.alpha": "+- 1 deg sd"}, **given)
    # tolerance: the torque is linear in the angle; without the tolerance K_theta is 10 % off
    np.testing.assert_allclose(fit.estimates, [0.25, K.K_theta, true.scale.alpha], rtol=3e-3)
    assert abs(fitted(data, **given).values["K_theta"] / K.K_theta - 1) > 0.05
    h = 1e-5
    J = estimate.derivatives(fit.points, fit.asked, fit.estimates)
    up, down = (estimate.modelled(fit.points, fit.asked, fit.estimates + s * h * np.eye(3)[2]) for s in (1, -1))
    np.testing.assert_allclose(J[:, 2], (up - down) / (2 * h), rtol=1e-6, atol=1e-9)


def test_the_command_and_what_has_no_tolerance(tmp_path, capsys):
    data = loop(DEGREE)
    rows = "\n".join(f"{x:.9g},{t:.6g}" for x, t in zip(*data.values(), strict=True))
    (tmp_path / "test.csv").write_text(f"phi (rad),T (N m)\n{rows}\n")
    (tmp_path / "beam.toml").write_text(BEAM.to_toml())
    (tmp_path / "known.toml").write_text('[tolerance]\nscale.alpha = "+- 1 deg"\n')
    files = [str(tmp_path / name) for name in ("test.csv", "beam.toml")]
    how = ["--joint", "hinge", "--nuisances", "none", "--starts", "1"]
    assert (
        main(["fit", *files, *how, "--tolerances", str(tmp_path / "known.toml"), "-o", str(tmp_path / "f.toml")]) == 0
    )
    assert ", scale.alpha = 61.0" in capsys.readouterr().out
    assert squama.Beam.from_toml(tmp_path / "f.toml").scale.alpha > ALPHA + DEGREE / 2
    with pytest.raises(InputError, match="give a tolerance of K_theta"):
        fitted(data, {"joint.factor": "+- 5 %"})


def test_samples_know_priors_and_dimensions():
    pytest.importorskip("emcee")
    fit = fitted(loop(DEGREE), {"mu": "0.25 +- 0.0005 sd", "scale.alpha": "+- 1.5 deg sd"}, posterior=640)
    assert fit.errors["mu"] < 5.1e-4
    # tolerance: 640 samples that are not independent tell a deviation to some 6 %
    np.testing.assert_allclose(fit.posterior.samples.std(axis=0), fit.deviations, rtol=0.35)
    assert (np.abs(fit.posterior.samples.mean(axis=0) - fit.estimates) < 0.5 * fit.deviations).all()

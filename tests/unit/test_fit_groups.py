"""Parameters that loops and specimens have of their own, and the test whether loops differ."""

from __future__ import annotations

import functools

import numpy as np
import pytest

import squama
from squama.cli import main
from squama.errors import InputError
from squama.identify import estimate
from squama.identify.readings import Readings

BEAM = squama.Beam.from_toml("examples/pla_on_vps.toml").replace(scales=None, hold="bend, lateral bend")
NOISE, K = 5e-3, 0.75
WAY = "0.1 rad/pitch"
pytestmark = pytest.mark.usefixtures("alone")


@functools.cache
def loop(mu: float, joint: str = "hinge", beam: squama.Beam = BEAM):
    one = beam.replace(friction={"mu": mu}, joint={"stiffness": K if beam is BEAM else 0.105})
    c = squama.cycle(one, WAY, joint=joint, points=40)
    return c.phi.values, c["T"].values


def table(*friction: float, sigma: float = NOISE, seed: int = 7, **how):
    phi, T = np.concatenate([loop(mu, **how) for mu in friction], axis=1)
    return {"phi": phi, "T": T + sigma * np.random.default_rng(seed).normal(size=T.size)}


def fitted(data, **given):
    given = {"joint": "hinge", "nuisances": "none", "starts": 1, "machine": "rigid", **given}
    return squama.fit(data, given.pop("beam", BEAM), given.pop("find", ("mu", "K_theta")), **given)


def test_loops_and_specimens_by_hand():
    load = np.array([0.0, 1, 2, 1, 0, 1, 2, 1])
    way = np.array([1, 1, 1, -1, -1, 1, 1, -1])
    one = Readings.of(load, way, np.zeros(8, int), 10)
    assert one.groups.tolist() == [0, 0, 0, 0, 0, 1, 1, 1]
    assert one.words == ("loop 1", "loop 2")
    two = Readings.of(load, way, np.array([0, 0, 0, 0, 0, 0, 1, 1]), 10)
    assert two.groups.tolist() == [0, 0, 0, 0, 0, 0, 1, 1]
    assert two.words == ("specimen 1", "specimen 2")


def test_a_second_loop_of_another_friction_is_told():
    fit = fitted(table(0.25, 0.3))
    (doubt,) = (d for d in fit.doubts if "from loop to loop" in d)
    assert doubt.startswith("mu rises from loop to loop: 0.2")
    assert fit.loops.told
    np.testing.assert_allclose(fit.loops.values, [0.25, 0.3], atol=4 * fit.loops.errors.max())
    assert fitted(table(0.3, 0.25)).loops.way == "falls"
    assert fitted(table(0.25, 0.3, 0.25)).loops.way == "changes"
    # one loop has none to differ from
    assert fitted(table(0.25)).loops is None


@pytest.mark.slow
def test_equal_loops_are_equal():
    """Of 40 records of two equal loops the chance is uniform: below a tenth in some four."""
    chances = np.array([fitted(table(0.25, 0.25, seed=seed)).loops.chance for seed in range(40)])
    # tolerance: binomial, three deviations
    assert np.count_nonzero(chances < 0.1) <= 10
    assert np.count_nonzero(chances < 0.5) == pytest.approx(20, abs=10)
    assert chances.min() > 1e-3


def test_each_loop_has_a_friction_of_its_own():
    data = table(0.25, 0.3)
    own, alone = fitted(data, each="mu"), [fitted(table(mu, seed=9)) for mu in (0.25, 0.3)]
    assert own.parameters == ("mu[1]", "mu[2]", "K_theta")
    for name, true in {"mu[1]": 0.25, "mu[2]": 0.3, "K_theta": K}.items():
        assert abs(own.values[name] - true) < 3 * own.errors[name], name
    # tolerance: noise of each, in the errors by its residual
    assert own.errors["mu[1]"] == pytest.approx(alone[0].errors["mu"], rel=0.5)
    assert own.errors["K_theta"] < 0.9 * alone[0].errors["K_theta"]
    assert own.loops is None
    assert own.holds
    assert own.beam.friction.mu == pytest.approx((own.values["mu[1]"] + own.values["mu[2]"]) / 2)
    assert "coefficient of friction, loop 2" in own.summary()
    # points, curve and derivatives are those of each loop
    np.testing.assert_allclose(own.residuals[own.used], (data["T"] - own.fitted)[own.used])
    assert np.std(own.residuals[own.used]) < 1.2 * NOISE
    drawn = own.curve()
    assert drawn.leg.max() == 4
    ends = [drawn.torque[drawn.leg == leg].max() for leg in (1, 3)]
    assert ends[1] > 1.01 * ends[0]
    J = estimate.derivatives(own.points, own.asked, own.estimates)
    first = own.points.readings.groups == 0
    assert not J[first, 1].any()
    assert not J[~first, 0].any()
    h = np.array([1e-6, 0, 0])
    up, down = (estimate.modelled(own.points, own.asked, own.estimates + s * h) for s in (1, -1))
    np.testing.assert_allclose(J[:, 0], (up - down) / 2e-6, rtol=1e-5, atol=1e-5)


@pytest.mark.slow
def test_each_loop_of_scales_that_are_walked():
    skin = squama.Beam.from_toml("examples/stiff_skin.toml").replace(scales=5, hold="bend, lateral bend")
    data = table(0.25, 0.32, sigma=1e-7, beam=skin, joint="compliant")
    fit = fitted(data, beam=skin, joint="compliant", each="mu")
    # tolerance: derivatives of the mean of both, and the torque between nodes of a walk
    np.testing.assert_allclose(fit.estimates, [0.25, 0.32, 0.105], rtol=5e-3)
    assert fit.endless.rows[0].name == "mu"


def test_specimens_share_a_joint_and_have_zeros_of_their_own():
    one, two = table(0.3), table(0.3, seed=8)
    two["T"] = two["T"] + 0.05
    data = [one, two]
    shared = fitted(data, find=("mu", "K_theta", "torque_zero"))
    own = fitted(data, find=("mu", "K_theta", "torque_zero"), each=["torque_zero"])
    assert own.parameters == ("mu", "K_theta", "torque_zero[1]", "torque_zero[2]")
    assert own.values["torque_zero[2]"] - own.values["torque_zero[1]"] == pytest.approx(0.05, abs=4 * NOISE / 9)
    assert own.rms < 0.5 * shared.rms
    assert abs(own.values["K_theta"] - K) < 3 * own.errors["K_theta"]
    assert len(own.specimens) == 2
    assert own.report()["parameters"]["torque_zero[2]"]["unit"] == "N m"


@pytest.mark.parametrize(
    ("data", "given", "words"),
    [
        (table(0.3), {"each": "mu"}, "of one loop"),
        (table(0.3, 0.3), {"each": "E_B"}, "E_B is not to be found"),
        (table(0.3, 0.3), {"each": "nu"}, "is not the name of a parameter"),
    ],
)
def test_what_no_group_has(data, given, words):
    with pytest.raises(InputError, match=words):
        fitted(data, **given)


def test_the_command(tmp_path, capsys):
    data = table(0.25, 0.3)
    rows = "\n".join(f"{x:.9g},{t:.6g}" for x, t in zip(*data.values(), strict=True))
    (tmp_path / "test.csv").write_text(f"phi (rad),T (N m)\n{rows}\n")
    (tmp_path / "beam.toml").write_text(BEAM.to_toml())
    files = [str(tmp_path / name) for name in ("test.csv", "beam.toml")]
    how = ["--joint", "hinge", "--nuisances", "none", "--starts", "1", "--plot", str(tmp_path / "fit.png")]
    assert main(["fit", *files, *how, "--each", "mu"]) == 0
    assert "mu[2]" in capsys.readouterr().out

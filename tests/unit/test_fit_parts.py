"""Fits of a part under a force: forces of a trial, parameters of loops, samples beside a grid, words and refusals."""

from __future__ import annotations

import functools
import json
from dataclasses import replace

import numpy as np
import pytest

import squama
from squama.cli import main
from squama.errors import InputError
from squama.identify import prepare, records
from squama.identify.joint_points import of_test
from squama.identify.prepare import Wanted
from squama.loads import PUSHED

BEAM = squama.Beam.from_toml("examples/stiff_skin.toml").replace(scales=4)
K, E = BEAM.joint_stiffness, BEAM.substrate.youngs_modulus
TRUE = {"mu": 0.31, "K_theta": 1.1 * K, "E_B": E}
MADE = BEAM.replace(friction={"mu": 0.31}, joint={"stiffness": 1.1 * K})
TIP, MIDDLE = ("14 mm up at tip", "clamped"), ("6 mm down at middle", "simple, span 60 mm")
HOW = {"nuisances": "none", "starts": 1, "machine": "rigid"}


@functools.cache
def loop(load, support, points=16):
    r = squama.load(MADE, load, support=support, points=points, back=True)
    assert float(r.share_e) < 0.7
    return {"travel": r.travel.values, "F": r.F.values}


def prepared(data, load, support, names=("mu", "K_theta")):
    """Return the test of a part."""
    kind, part = of_test(BEAM, load, support)
    specimens = records.read(data, BEAM, kind)
    wanted = Wanted(BEAM, specimens, names, kind, "edge", None, records.ALL, None, 1, (), part=part)
    return prepare.prepared("compliant", wanted)


@pytest.mark.parametrize(
    ("load", "support"),
    [
        TIP,
        MIDDLE,
        pytest.param("20 mm down at middle", "gripped", marks=pytest.mark.slow),
        ("2 N tendon at 4 mm", None),
        ("12 mm left at 40 mm", None),
    ],
)
def test_the_force_of_a_trial_is_that_of_a_load(load, support):
    r = squama.load(MADE, load, support=support, points=12, back=True)
    made = prepared({"travel": r.travel.values, "F": r.F.values}, load, support)
    v = made.asked.physical(np.array([0.31, 1.1 * K]))
    # tolerance: the largest load itself is located to 2e-7
    np.testing.assert_allclose(made.points.torque(v), r.F.values, rtol=0, atol=1e-5 * np.abs(r.F.values).max())
    N = np.nansum(r.N.values, axis=1)
    assert np.array_equal(made.points.touching(v), N > 0)


@pytest.mark.parametrize("case", [TIP, pytest.param(MIDDLE, marks=pytest.mark.slow)], ids=["tip", "middle"])
@pytest.mark.parametrize("names", ["E_B", "mu,K_theta", *(
    pytest.param(names, marks=pytest.mark.slow) for names in ("mu", "K_theta", "K_theta,E_B", "mu,E_B"))])  # fmt: skip
@pytest.mark.usefixtures("alone")
def test_a_loop_without_noise_gives_its_parameters_back(case, names):
    others = {"mu": {"friction": {"mu": 0.2}}, "K_theta": {"joint": {"stiffness": K}},
              "E_B": {"substrate": {"youngs_modulus": 0.9 * E}}}  # fmt: skip
    start = MADE
    for name in names.split(","):
        start = start.replace(**others[name])
    fit = squama.fit(loop(*case), start, names, load=case[0], support=case[1], **HOW)
    for name in fit.parameters:
        assert fit.values[name] == pytest.approx(TRUE[name], rel=1e-4), name
    assert (fit.joint, fit.load, fit.endless, fit.row, fit.rival) == ("compliant", PUSHED, None, None, None)
    assert fit.fitted_as == f"4 scales, {case[1]}, {case[0].partition(' mm ')[2]}"


def bare_force(travel):
    """Return the force at the tip of four cells that bend in their middles, small deflections.

    By beam theory 3 B u/L^3, B the stiffness of the endless beam that is bent; n cells in place of a bar have
    1 - 1/(4 n^2) of its deflection.
    """
    bent = squama.bend(BEAM.replace(scales=None), at=[1e-4], mu=0)
    return 3 * float(bent.M[0]) / 1e-4 * travel / (4 * BEAM.pitch) ** 3 / (1 - 1 / 64)


def test_before_engagement_the_force_is_that_of_beam_theory():
    travel = np.linspace(0, 0.4e-3, 9)
    made = prepared({"travel": travel, "F": bare_force(travel) + 1e-12}, *TIP, ("E_B",))
    force = made.points.torque(made.asked.physical(np.array([E])))
    # tolerance: deflections that are not quite small, 2e-4 measured
    np.testing.assert_allclose(force, bare_force(travel), rtol=5e-3, atol=1e-9)


@functools.cache
def fitted(**given):
    data = loop(*TIP)
    noise = np.random.default_rng(5).normal(0, 0.003 * data["F"].max(), data["F"].size)
    return squama.fit({**data, "F": data["F"] + noise}, BEAM, load=TIP[0], **HOW, **given)


@pytest.mark.usefixtures("alone")
def test_the_words_and_units_are_those_of_a_force():
    fit = fitted()
    for name in ("mu", "K_theta"):
        assert abs(fit.values[name] - TRUE[name]) < 3 * fit.errors[name] < 0.5 * TRUE[name]
    text = fit.summary()
    assert "fitted as 4 scales, clamped, up at tip" in text
    assert "µN" in text or "mN" in text
    assert "N m," not in text.partition("residual rms")[2]
    data = fit.dataset()
    assert data.travel.units == "m"
    assert data.F.units == data.residual.units == "N"
    np.testing.assert_allclose(data.travel.values, loop(*TIP)["travel"], rtol=1e-12)
    assert fit.plot().axes[1].get_xlabel().endswith("(mm)")


def in_frame(share):
    """Return a loop at the tip as a frame reads it that takes a share of the travel at the top, and its stiffness."""
    data = loop(*TIP, points=60)
    top = int(np.argmax(data["travel"]))
    k = data["F"][top] / (data["travel"][top] * share / (1 - share))
    return {"travel": data["travel"] + data["F"] / k, "F": data["F"]}, k


@pytest.mark.usefixtures("alone")
def test_a_frame_that_gives_is_corrected_for():
    data, k = in_frame(0.01)
    how = {"load": TIP[0], "nuisances": "none", "starts": 1}
    given = squama.fit(data, BEAM, machine=f"{1e-3 * k} N/mm", **how)
    for name, close in (("mu", 0.02), ("K_theta", 3e-3)):
        # tolerance: the frame is taken off with smoothed forces
        assert given.values[name] == pytest.approx(TRUE[name], rel=close), name
    without = squama.fit(data, BEAM, machine=None, **how)
    assert without.machine.told
    assert f'machine "{without.machine.stiffness / 1e3:.3g} N/mm"' in without.of_machine
    assert without.machine.stiffness == pytest.approx(k, rel=0.05)
    # to first order it changes the estimates as it did
    moved = [without.values[name] - TRUE[name] for name in without.parameters]
    np.testing.assert_allclose(-without.machine.changes, moved, rtol=0.4)


@pytest.mark.slow
@pytest.mark.usefixtures("alone")
def test_the_compliance_of_a_frame_is_found_from_its_tolerance_and_the_points():
    data, k = in_frame(0.04)
    noise = np.random.default_rng(6).normal(0, 0.002 * data["F"].max(), data["F"].size)
    data = {**data, "F": data["F"] + noise}
    fit = squama.fit(data, BEAM, machine=f"{1.15 * k} +- {0.4 * k} N/m", load=TIP[0], nuisances="none", starts=1)
    true = {"mu": TRUE["mu"], "K_theta": TRUE["K_theta"], "compliance": 1 / k}
    for name, value in true.items():
        assert abs(fit.values[name] - value) < 3 * fit.errors[name] < 0.5 * value, name
    assert "mm/N" in fit.summary()
    assert fit.dataset().unit.sel(parameter="compliance") == "m/N"


@pytest.mark.usefixtures("alone")
def test_a_prediction_of_a_part_has_the_curve_of_its_load():
    fit = fitted()
    p = fit.predict("9 mm", samples=10, points=8)
    assert (p.travel.units, p.F.units, p["F_low"].units, p.work.units) == ("m", "N", "N", "J")
    r = squama.load(fit.beam, "9 mm up at tip", points=8, back=True)
    np.testing.assert_allclose(p.travel, r.travel, atol=1e-12)
    # tolerance: the joint of the fitted beam is rounded to the digits of its file
    np.testing.assert_allclose(p.F, r.F, rtol=0, atol=1e-4 * float(r.F.max()))
    assert p.leg.values.tolist() == [1] * 9 + [2] * 8
    loss = np.trapezoid(r.F, r.travel)
    assert float(p.work) == pytest.approx(loss, rel=1e-3)
    assert float(p.work_low) < float(p.work) < float(p.work_high)
    top = p.isel(point=8)
    assert float(top.F_low) < float(top.F) < float(top.F_high)
    # the band is that of the covariance, which linear forces carry on
    J = np.array([(p.F_draws.values[:, 8] - float(top.F)).std()])
    assert 0 < J[0] < 0.02 * float(top.F)
    history = fit.predict(["6 mm", "2 mm"], samples=10, points=4)
    assert history.travel.values.tolist() == pytest.approx([0, 1.5e-3, 3e-3, 4.5e-3, 6e-3, 5e-3, 4e-3, 3e-3, 2e-3])
    figure = squama.plot.prediction_figure(p)
    assert figure.axes[0].get_xlabel().endswith("(mm)")
    with pytest.raises(InputError, match="is not a length"):
        fit.predict("0.1 rad/pitch")
    with pytest.raises(InputError, match="two equal travels in a row"):
        fit.predict(["3 mm", "3 mm"])


@pytest.mark.slow
@pytest.mark.usefixtures("alone")
def test_samples_are_those_of_the_model_on_a_grid():
    pytest.importorskip("emcee")
    data = loop(*TIP)
    size = 0.004 * data["F"].max()
    read = {**data, "F": data["F"] + np.random.default_rng(3).normal(0, size, data["F"].size)}
    fit = squama.fit(read, BEAM, load=TIP[0], noise=size, posterior=120, **HOW)
    x = fit.posterior.samples
    assert (x.shape, fit.posterior.walked) == ((120, 2), 120)
    # (all weights alike would be worth 120)
    assert 40 < fit.posterior.worth < 119.9
    assert fit.posterior.effective <= fit.posterior.worth
    assert "from 120 walks of the model" in fit.summary()
    # the posterior on a grid, by the model alone
    made = prepared(read, *TIP)
    axes = [np.linspace(max(v - 4 * s, 0), v + 4 * s, 13) for v, s in zip(fit.estimates, fit.deviations, strict=True)]
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)
    use = fit.used
    square = np.array([[np.sum((made.points.torque(made.asked.physical(p)) - read["F"])[use] ** 2) for p in row]
                       for row in grid])  # fmt: skip
    weight = np.exp(-0.5 * (square - square.min()) / size**2)
    for i in range(2):
        mean = np.sum(weight * grid[..., i]) / weight.sum()
        sd = np.sqrt(np.sum(weight * (grid[..., i] - mean) ** 2) / weight.sum())
        # tolerance: 120 samples tell a mean to 0.09 sd, an sd to 7 %
        assert abs(x[:, i].mean() - mean) < 0.5 * sd
        assert x[:, i].std() == pytest.approx(sd, rel=0.4)


@pytest.mark.usefixtures("alone")
def test_the_command_reads_flags_and_the_sections_of_the_file(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    data = loop(*TIP)
    rows = "".join(f"{1e3 * x:.7g};{f:.7g}\n" for x, f in zip(data["travel"], data["F"], strict=True))
    (tmp_path / "test.csv").write_text("Weg;Kraft\nmm;N\n" + rows)
    (tmp_path / "beam.toml").write_text(BEAM.to_toml())
    part = squama.Part(BEAM, load="1 N up at tip", support=TIP[1])
    part.to_toml(tmp_path / "part.toml")
    how = ["--nuisances", "none", "--machine", "rigid", "--json"]
    assert main(["fit", "test.csv", "part.toml", *how]) == 0
    of_file = json.loads(capsys.readouterr().out)
    assert main(["fit", "test.csv", "beam.toml", "--load", "2 mm up at tip", *how]) == 0
    of_flags = json.loads(capsys.readouterr().out)
    assert of_file["parameters"] == of_flags["parameters"]
    assert of_file["parameters"]["mu"]["estimate"] == pytest.approx(0.31, rel=1e-3)
    assert main(["fit", "test.csv", "part.toml", "--load", "twisting"]) == 2
    assert "test.csv" in capsys.readouterr().err
    assert main(["fit", "test.csv", "part.toml", "--support", "glued"]) == 2
    assert '--support = "glued"' in capsys.readouterr().err
    # the unit that is missing is that of the load: of a force, or of a torque
    for more, noise, to in (([], "3 N", "3 mm"), (["--load", "twisting"], "3 N m", "3 rad/pitch")):
        assert main(["fit", "test.csv", "part.toml", *more, "--noise", "3", "--to", "3"]) == 2
        said = [line for line in capsys.readouterr().err.splitlines() if "error: " in line]
        assert [line.partition("; ")[2] for line in said] == [f'write e.g. "{unit}"' for unit in (noise, to)]


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"load": "20 N mm bend"}, 'load = "20 N mm bend": is no force'),
        ({"load": ["1 N up at tip", "1 N left at tip"]}, "is a second load: a test has one force"),
        ({"load": "torsion"}, 'load = "torsion": must be "twisting" or "bending"'),
        ({"support": "clamped"}, "is of a part under a force"),
        ({"load": TIP[0], "joint": "hinge"}, "is not available for a part under load"),
        ({"load": TIP[0], "ends": "free"}, "are not of a part under a force"),
        (
            {"load": TIP[0], "machine": "2 N m/rad"},
            '"2 N m/rad": is a torque, but a stiffness is needed; write e.g. "2 N/mm"',
        ),
        (
            {"load": TIP[0], "machine": "2 +- 3 N/mm"},
            'is too wide: no machine stiffness is below 0; write e.g. "5 +- 0.5 N/mm"',
        ),
        ({"load": TIP[0], "parameters": "mu,C_f"}, "C_f is not found"),
        ({"load": TIP[0], "to": "0.1 rad/pitch"}, "is not a length"),
        ({"load": TIP[0], "to": "4 mm"}, "points lie before engagement"),
    ],
)
def test_what_a_fit_of_a_part_does_not_take_is_refused(given, words):
    with pytest.raises(InputError) as caught:
        squama.fit(loop(*TIP), BEAM, **given)
    assert words in str(caught.value)


def test_scales_that_differ_are_refused():
    part = squama.Part(BEAM, load=TIP[0], along={"scale.theta0": ["5 deg", "9 deg"]})
    for one in (part, replace(part, load=())):
        with pytest.raises(InputError, match="scales that differ along a part are not fitted"):
            squama.fit(loop(*TIP), one)

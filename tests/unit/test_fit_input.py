"""Fits from files: the command, what it writes, the shipped example, bad input."""

from __future__ import annotations

import functools
import json
import runpy
import signal
from pathlib import Path

import numpy as np
import pytest

import squama
from squama.cli import main
from squama.cli.fit import flat
from squama.errors import InputError
from squama.plot import corner_figure, fit_figure

ROOT = Path(__file__).parents[2]
hinged = functools.partial(squama.fit, joint="hinge")
BEAM = squama.Beam.from_ratios(youngs_modulus="2 MPa", mu=0.1)
LOOP = squama.cycle(BEAM, "0.2 rad/pitch", mu=0.3, points=30, joint="hinge")


def table(columns: str, *rows: tuple[object, ...]) -> str:
    return "\n".join([columns, *(",".join(map(str, row)) for row in rows), ""])


def loop_text(scale: float = 1.0, label: str = "", seed: int = 1) -> str:
    torque = LOOP["T"].values
    torque = torque * scale + np.random.default_rng(seed).normal(0, 0.005 * torque.max(), torque.size)
    start = f"{label}," if label else ""
    return "".join(f"{start}{p:.9g},{t:.6g}\n" for p, t in zip(LOOP.phi.values, torque, strict=True))


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "beam.toml").write_text(BEAM.to_toml())
    (tmp_path / "test.csv").write_text("phi (rad),T (N m)\n" + loop_text())
    return tmp_path


@pytest.mark.slow
@pytest.mark.usefixtures("alone")
@pytest.mark.parametrize("name", ["measured_loop.csv", "stiff_skin_loop.csv"])
def test_the_examples_are_what_their_script_makes(name):
    made = runpy.run_path(str(ROOT / "examples/make_measured_loop.py"))
    text, truth = made["make"](name), made["LOOPS"][name]
    assert (ROOT / "examples" / name).read_bytes() == text.encode()
    assert text.startswith("# SYNTHETIC data, not a real test")
    if "joint" not in truth.how:
        # docs/gallery/fit.md fits it
        return
    beam = squama.Beam.from_toml(ROOT / "examples" / truth.beam)
    fit = squama.fit(ROOT / "examples" / name, beam, joint=truth.how["joint"], nuisances="none")
    # with other seeds 32 of 34 lie within two errors
    for parameter in ("mu", "K_theta"):
        assert abs(fit.values[parameter] - getattr(truth, parameter)) < 3 * fit.errors[parameter]
    # tolerance: noise of a fixed seed, 1.3 % measured
    assert fit.noise == pytest.approx(1e-3 * truth.noise, rel=0.2)
    assert fit.notes == ()
    assert np.count_nonzero(fit.branch == "stick") == 3


def test_the_command(folder, capsys):
    names = ["--plot", "f.png", "--csv", "f.csv", "--netcdf", "f.nc", "-o", "fitted.toml"]
    assert main(["fit", "test.csv", "beam.toml", "--joint", "hinge", "--full", *names]) == 0
    said = capsys.readouterr().out
    fit = hinged("test.csv", BEAM)
    assert said.startswith(f"test.csv: {', '.join(fit.lines)}\n  residual ")
    assert "thin, rigid scales on hinges, edge law; an endless beam; twisting\n" in said
    assert all(f"\n{line}\n" in said for line in (*fit.described(), *fit.checked, *fit.more))
    assert (folder / "f.png").stat().st_size > 10_000
    assert squama.read("f.nc").identical(fit.dataset())
    assert squama.read("f.nc").initial.values.tolist() == [0.1, BEAM.joint_stiffness]
    assert squama.read("f.csv").identical(flat(fit.dataset()))
    assert squama.read("f.csv").attrs["parameters"][0]["estimate"] == fit.values["mu"]
    assert squama.Beam.from_toml("fitted.toml") == fit.beam
    assert (folder / "fitted.toml").read_text().startswith("# Fitted by squama fit to test.csv")
    assert main(["twist", "fitted.toml", "--joint", "hinge"]) == 0
    assert f"mu = {fit.values['mu']:g}" in capsys.readouterr().out


@pytest.mark.usefixtures("alone")
def test_a_saved_cycle_is_a_test_too(folder, capsys):
    (folder / "true.toml").write_text(BEAM.replace(friction={"mu": 0.3}).to_toml())
    assert (
        main(
            [
                "cycle",
                "true.toml",
                "--joint",
                "hinge",
                "--history",
                "0, 0.2, 0.1, 0.18, 0 rad/pitch",
                "--csv",
                "cycle.csv",
            ]
        )
        == 0
    )
    assert main(["fit", "cycle.csv", "beam.toml", "--joint", "hinge", "--json"]) == 0
    said = capsys.readouterr().out
    record = json.loads(said[said.index("\n{") :])
    assert record["parameters"]["mu"]["estimate"] == pytest.approx(0.3, rel=1e-9)


@pytest.mark.slow
@pytest.mark.usefixtures("alone")
def test_json(folder, capsys):
    arguments = ["--find", "mu,K_theta,theta0", "--bounds", "theta0=5 deg:20 deg", "--bounds", "mu=:0.5"]
    assert (
        main(["fit", "beam.toml", "test.csv", *arguments, "--noise", "5 N mm", "--set", "friction.mu=0.2", "--json"])
        == 0
    )
    record = json.loads(capsys.readouterr().out)
    fit = hinged(
        "test.csv", BEAM, "mu,K_theta,theta0", bounds={"theta0": ("5 deg", "20 deg"), "mu": (None, 0.5)}, noise=0.005
    )
    for name in fit.parameters:
        assert record["parameters"][name]["estimate"] == pytest.approx(fit.values[name], rel=1e-6)
        assert record["parameters"][name]["error"] == pytest.approx(fit.errors[name], rel=1e-4)
    assert record["parameters"]["mu"]["initial"] == 0.2
    assert record["parameters"]["mu"]["high"] == 0.5
    assert record["parameters"]["theta0"]["low"] == pytest.approx(np.radians(5))
    assert record["noise_given"] is True
    assert len(record["points"]["residual"]) == fit.used.size
    assert record["beam"]["friction"]["mu"] == pytest.approx(fit.values["mu"], rel=1e-6)


@pytest.mark.usefixtures("alone")
def test_specimens_in_one_file_and_in_several(folder, capsys):
    rows = loop_text(label="A") + loop_text(1.2, label="B", seed=2)
    (folder / "two.csv").write_text("Specimen,phi (rad),T (N m)\n" + rows)
    (folder / "B.csv").write_text("phi (rad),T (N m)\n" + loop_text(1.2, seed=2))
    (folder / "A.csv").write_text("phi (rad),T (N m)\n" + loop_text())
    one, several = hinged("two.csv", BEAM), hinged(["A.csv", "B.csv"], BEAM)
    np.testing.assert_allclose(one.estimates, several.estimates, rtol=1e-8)
    np.testing.assert_allclose(one.specimens[1].values, several.specimens[1].values, rtol=1e-8)
    assert one.used.size == several.used.size == 2 * LOOP.phi.size
    assert [s.label for s in one.specimens] == [s.label for s in several.specimens] == ["A", "B"]
    assert main(["fit", "A.csv", "B.csv", "beam.toml", "--joint", "hinge", "--full", "--plot", "f.svg"]) == 0
    said = capsys.readouterr().out
    assert "specimen B alone: mu = " in said
    assert "note: K_theta differs between the 2 specimens" in said


@pytest.mark.slow
@pytest.mark.usefixtures("alone")
def test_posterior(folder, capsys):
    pytest.importorskip("emcee")
    plain = functools.partial(hinged, nuisances="none")
    fit = plain("test.csv", BEAM, posterior=1280, seed=4)
    x = fit.posterior.samples
    assert x.shape == (1280, 2)
    # many points and little noise: the samples have the covariance of the least squares
    error = np.sqrt(np.diag(fit.covariance))
    # tolerance: a chain that rounding may lead elsewhere; its scatter is some 4 %
    assert (np.abs(x.mean(axis=0) - fit.estimates) < 0.4 * error).all()
    np.testing.assert_allclose(x.std(axis=0), error, rtol=0.3)
    assert np.corrcoef(x.T)[0, 1] == pytest.approx(fit.correlation[0, 1], abs=0.25)
    given = plain("test.csv", BEAM, noise=3 * fit.noise, posterior=1280)
    np.testing.assert_allclose(given.posterior.samples.std(axis=0), 3 * error, rtol=0.3)
    bounded, again = (
        plain("test.csv", BEAM, posterior=320, bounds={"mu": (fit.values["mu"], 1)}, seed=2) for _ in range(2)
    )
    np.testing.assert_array_equal(bounded.posterior.samples, again.posterior.samples)
    assert (bounded.posterior.samples[:, 0] >= fit.values["mu"]).all()
    assert bounded.posterior.note() is not None
    arguments = ["--posterior", "320", "--seed", "4", "--netcdf", "f.nc", "--corner", "c.png", "--noise", "5 N mm"]
    arguments += ["--nuisances", "none", "--joint", "hinge"]
    assert main(["fit", "test.csv", "beam.toml", "--full", *arguments]) == 0
    assert "posterior, 320 samples" in capsys.readouterr().out
    assert squama.read("f.nc").sample_value.shape == (320, 2)
    assert (folder / "c.png").stat().st_size > 10_000
    assert len(corner_figure(fit.dataset()).axes) == 4


def test_no_emcee(folder, monkeypatch, capsys):
    monkeypatch.setitem(__import__("sys").modules, "emcee", None)
    assert main(["fit", "test.csv", "beam.toml", "--posterior", "100", "--netcdf", "f.nc"]) == 2
    assert "install it with: pip install 'squama[fit]'" in capsys.readouterr().err
    assert not (folder / "f.nc").exists()


@pytest.mark.slow
@pytest.mark.usefixtures("alone")
def test_pictures():
    for load, history, torque in (
        ("twisting", "0, 0.2, -0.02, 0.21, 0.1 rad/pitch", "T"),
        ("bending", "0.2 rad/pitch", "M"),
    ):
        fit = hinged(squama.cycle(BEAM, history, mu=0.3, load=load, joint="hinge"), BEAM, load=load)
        data = fit.dataset()
        upper, lower = fit_figure(data).axes
        assert torque in upper.get_ylabel()
        assert "Residual" in lower.get_ylabel()
        # the drawn curve goes through the points
        curve = data[f"{torque}_curve"].values
        assert curve.max() == pytest.approx(data[torque].values.max(), rel=1e-6)
        # the way back begins with the drop, from the upper branch to the lower
        back = curve[data["leg"].values == 2]
        assert back[0] == pytest.approx(curve[data["leg"].values == 1][-1], rel=1e-9)
        assert back[1] < 0.9 * back[0]
    # points that are not used may lie far above: the others keep their room
    part = hinged(LOOP, BEAM, to="0.1 rad/pitch")
    upper = fit_figure(part.dataset()).axes[0]
    assert upper.get_ylim()[1] < 0.5 * float(LOOP["T"].max()) * (1e3 if "mN" in upper.get_ylabel() else 1)


UP = [(p, t) for p, t in zip(LOOP.phi.values[:36:3], LOOP["T"].values[:36:3], strict=True)]
HEAD = "phi (rad),T (N m)"


@pytest.mark.parametrize(
    ("text", "arguments", "words"),
    [
        (table(HEAD, *UP, ("0.2", "abc")), [], 'T (N m) = "abc": is not a number'),
        (table(HEAD, *UP, ("0,2", "1")), [], "has 3 cells, the header has 2"),
        (table("phi (mm),T (N m)", *UP), [], "mm is no unit of a twist or curvature"),
        (table("phi (rad),T (N)", *UP), [], "N is no unit of a torque"),
        (table("phi (rad),T (N m)"), [], "has a header but no rows"),
        (table(HEAD, *sorted(UP, key=lambda r: r[1] % 0.3)), [], "give the rows in the order measured"),
        (table(HEAD, *((0.1, t) for _, t in UP)), [], "the twist is 5.625 rad/m in every row"),
        (table(HEAD, *((p, 0) for p, _ in UP)), [], "the torque is 0 in every row"),
        (table(HEAD, *((p, 0.5) for p, _ in UP)), [], "the torque is 0.5 N m in every row"),
        (table(HEAD, *((p, -t) for p, t in UP)), [], "torque and twist have opposite signs"),
        (table(HEAD, *UP[-2:]), [], "2 usable points (of 2) for 2 parameters (mu and K_theta); give 3 or more"),
        (table(HEAD, *UP), ["--to", "0.01 rad/pitch"], "usable point"),
        (table(HEAD, *((0.2 * p, t) for p, t in UP)), [], "lie before engagement (largest twist 2."),
        (table(HEAD, *((0.2 * p, t) for p, t in UP)), [], "where mu and K_theta cannot be seen; measure beyond 2."),
        (table(HEAD, *UP[:3], UP[-1]), [], "1 point in contact for 2 parameters"),
        (table(HEAD, *((-p, -t) for p, t in UP)), [], "in this sense, -, the scales do not engage"),
        (table(HEAD, *((3 * p, t) for p, t in UP)), [], "lie beyond what the model covers"),
        (table(HEAD, *UP), ["--bounds", "mu=1.5:2"], "the beam locks even with the least friction allowed, 1.5"),
        (
            table(HEAD, *UP),
            ["--find", "mu,stiffness"],
            '--find: "stiffness" is not the name of a parameter; write K_theta',
        ),
        (table(HEAD, *UP), ["--find", "mu,C_g"], "did you mean C_f?"),
        (table(HEAD, *UP), ["--find", "mu,mu"], "--find: mu is given twice"),
        (table(HEAD, *UP), ["--find", ""], '--find: ""'),
        (table(HEAD, *UP), ["--find", "K_theta,C_f,E_B"], "only their product enters the torque"),
        (table(HEAD, *UP), ["--bounds", "mu=0.5:0.1"], "(they are reversed)"),
        (table(HEAD, *UP), ["--bounds", "mu=0.5"], "is not name=lower:upper"),
        (table(HEAD, *UP), ["--bounds", "mu=0:0.5", "--bounds", "mu=0:1"], "--bounds mu: is given twice"),
        (table(HEAD, *UP), ["--bounds", "mu=0:20"], "--bounds mu = 20: must lie within 0 and 10"),
        (table(HEAD, *UP), ["--bounds", "K_theta=0.1:2"], '"0.1": has no unit'),
        (table(HEAD, *UP), ["--bounds", "theta0=5 deg:20 deg"], "theta0 is not to be found"),
        (table(HEAD, *UP), ["--noise", "5"], "--noise = 5: has no unit"),
        (table(HEAD, *UP), ["--noise", "0 N m"], '--noise = "0 N m": is out of range (1e-30 to 1e30 N m)'),
        (table(HEAD, *UP), ["--to", "5 N m"], "--to = "),
        (table(HEAD, *UP), ["--to", "0 rad/m"], "--to: must be above 0"),
        (table(HEAD, *UP), ["--reversal", "-1 rad/m"], "--reversal = -1 rad/m: must be 0 or more"),
        (table(HEAD, *UP), ["--starts", "0"], "--starts"),
        (table(HEAD, *UP), ["--posterior", "many"], "--posterior"),
        (table(HEAD, *UP), ["--corner", "c.png"], "ask for them too"),
        (table(HEAD, *UP), ["--load", "shear"], '--load = "shear"'),
        (
            table(HEAD, *UP),
            ["--load", "bending"],
            "has none of the columns that are needed; write above the rows a line like: kappa",
        ),
        (table(HEAD, *UP), ["--law", "both"], '--law = "both"'),
        (table(HEAD, *UP), ["-o", "beam.toml"], "beam.toml: is read too"),
        (table(HEAD, *UP), ["-o", "b.csv"], "allowed: .toml"),
        (table(HEAD, *UP), ["--csv", "test.csv"], "is read too"),
        (table(HEAD, *UP), ["test.csv"], "test.csv: is given twice"),
        (table(HEAD, *UP), ["beam.toml"], "is a second beam file"),
        ("specimen,phi (rad),T (N m)\nA,0.1,0.2\n,0.2,0.4\n", [], 'line 3: specimen = "": is empty; name it'),
    ],
)
def test_bad_input(folder, capsys, text, arguments, words):
    (folder / "test.csv").write_text(text)
    before = {p: p.read_bytes() for p in folder.iterdir()}
    assert main(["fit", "test.csv", "beam.toml", "--joint", "hinge", *arguments, "--netcdf", "out.nc"]) == 2
    said = capsys.readouterr().err
    assert words in said
    assert all(line.startswith("squama: error: ") for line in said.splitlines())
    assert said.count("\n") == 1 or words in ('--find: ""',)
    assert {p: p.read_bytes() for p in folder.iterdir()} == before


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ([], "data: is empty"),
        (3.0, "data: is no file and has no columns"),
        ({"phi": [0, 1]}, 'data: has no "Phi" (rad/m) and "T" (N m); give both'),
        ({"phi": [0, 0.1, 0.2], "T": [0, 1]}, "data: 3 twists but 2 torques"),
        ({"phi": [0, 0.1, np.nan], "T": [0, 1, 2]}, 'data["phi"] = nan'),
        ({"phi": [[0, 0.1]], "T": [[0, 1]]}, "must be one-dimensional"),
        (squama.twist(BEAM, mu=[0.1, 0.2], joint="hinge"), "must be one-dimensional"),
    ],
)
def test_bad_arrays(given, words):
    with pytest.raises(InputError) as caught:
        hinged(given, BEAM)
    assert words in str(caught.value)
    assert "\n" not in str(caught.value)


def test_very_many_mistakes_are_counted(folder, capsys):
    (folder / "test.csv").write_text("phi (rad),T (N m)\n" + "".join(f"0.{i},x\n" for i in range(100)))
    assert main(["fit", "test.csv", "beam.toml"]) == 2
    said = capsys.readouterr().err.splitlines()
    assert len(said) == 9
    assert said[-1] == "squama: error: test.csv: and 92 more mistakes of this kind"


def test_parameters_that_the_points_do_not_show(folder):
    straight = {"Phi": np.linspace(0, 2, 20), "T": BEAM.torsional_rigidity * np.linspace(0, 2, 20)}
    with pytest.raises(InputError, match="E_B and C_f: these points do not tell them apart"):
        hinged(straight, BEAM, ("E_B", "C_f"))
    with pytest.raises(InputError, match="mu: is not given; find it too"):
        hinged(straight, BEAM.replace(friction={"mu": None}), ("C_f",))


@pytest.mark.parametrize(
    ("torque", "words"),
    [
        ("1e300", "test.csv: line 12: the torque is 1e+300 N m, out of range (1e-30 to 1e30 N m); check"),
        ("1e9", "test.csv: line 12: the torque is 1e+09 N m, "),
        ("-1e9", "test.csv: line 12: the torque is -1e+09 N m, "),
    ],
)
def test_a_torque_out_of_all_proportion(torque, words, folder, capsys):
    lines = Path("test.csv").read_text().splitlines()
    lines[11] = f"{lines[11].split(',')[0]},{torque}"
    Path("test.csv").write_text("\n".join(lines))
    assert main(["fit", "test.csv", "beam.toml", "--csv", "f.csv", "-o", "fitted.toml"]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert words in line
    assert not Path("f.csv").exists()
    assert not Path("fitted.toml").exists()


@pytest.mark.parametrize("factor", [1e-300, 1e-200, 1e150, 1e300])
def test_torques_of_no_measure(factor):
    data = {"phi": LOOP["phi"].values, "T": LOOP["T"].values * factor}
    with pytest.raises(InputError, match="out of range"):
        hinged(data, BEAM)


@pytest.mark.parametrize("noise", ["1e-300 N m", "1e300 N m"])
def test_noise_of_no_measure(noise, folder):
    with pytest.raises(InputError, match="out of range"):
        hinged("test.csv", BEAM, noise=noise)


@pytest.mark.slow
def test_an_interrupt_while_samples_are_drawn_is_one_line(folder, capfd, monkeypatch):
    emcee = pytest.importorskip("emcee")
    steps = emcee.EnsembleSampler.sample

    def sample(*args, **named):
        for n, state in enumerate(steps(*args, **named)):
            if n == 3:
                signal.raise_signal(signal.SIGINT)
            yield state

    monkeypatch.setattr(emcee.EnsembleSampler, "sample", sample)
    Path("fitted.toml").write_text("old")
    how = ["--posterior", "100", "--joint", "hinge", "--csv", "f.csv", "-o", "fitted.toml"]
    assert main(["fit", "test.csv", "beam.toml", *how]) == 130
    out, err = capfd.readouterr()
    assert (out, err) == ("", "squama: interrupted while samples were drawn; nothing is written\n")
    assert not Path("f.csv").exists()
    assert Path("fitted.toml").read_text() == "old"

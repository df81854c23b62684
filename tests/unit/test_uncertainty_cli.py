"""The command uncertainty, how tolerances are written, its files and picture, and what it refuses."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import squama
from squama.cli import main
from squama.errors import InputError
from squama.plot import uncertainty_figure
from squama.study.tolerances.distributions import tolerances

BEAM = squama.Beam.from_ratios(mu=0.25, alpha="60 deg")
FEW = ("--samples", "3200")


@pytest.fixture
def beam(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    BEAM.to_toml("beam.toml")
    return "beam.toml"


@pytest.mark.parametrize(
    ("text", "meaning"),
    [
        ("60 deg +- 1 deg", "uniform(59 deg, 61 deg)"),
        ("60 +- 1 deg", "uniform(59 deg, 61 deg)"),
        ("60 deg+-1", "uniform(59 deg, 61 deg)"),
        ("+- 1 deg", "uniform(59 deg, 61 deg)"),
        ("+/- 5 %", "uniform(57 deg, 63 deg)"),
        ("60 deg ± 2 deg 2 sd", "normal(60 deg, 1 deg)"),
        ("60 deg +- 1 deg sd", "normal(60 deg, 1 deg)"),
        ("60 deg +- 1 deg triangular", "triangular(59 deg, 60 deg, 61 deg)"),
        ("normal(60, 1 deg)", "normal(60 deg, 1 deg)"),
        ("normal(60 deg, 2%)", "normal(60 deg, 1.2 deg)"),
        ("Uniform(59 deg, 61 deg)", "uniform(59 deg, 61 deg)"),
        ("triangular(58 deg, 60 deg, 61 deg)", "triangular(58 deg, 60 deg, 61 deg)"),
        (("normal", np.pi / 3, "1 deg"), "normal(60 deg, 1 deg)"),
    ],
)
def test_how_tolerances_are_written(text, meaning):
    (one,) = tolerances({"alpha": text}, BEAM)
    assert one.name == "scale.alpha"
    assert one.text == meaning
    # what was read reads back
    assert tolerances({"scale": {"alpha": (one.kind, *one.numbers)}}, BEAM) == [one]


def test_a_plain_number_may_be_a_standard_deviation():
    texts = ("0.25 +- 0.02 sd", "+- 0.02 sd", "0.25 +- 0.04 2 sd", "normal(0.25, 0.02)")
    assert {tolerances({"mu": text}, BEAM)[0].text for text in texts} == {"normal(0.25, 0.02)"}


@pytest.mark.parametrize(
    ("name", "text", "words"),
    [
        ("alpha", "60 deg", 'alpha = "60 deg": is no tolerance; write e.g. "60 deg +- 1 deg" (limits)'),
        ("alpha", "60 +- 1", '"60" has no unit'),
        ("alpha", "60 mm +- 1 mm", "is a length, but an angle is needed"),
        ("alpha", "normal(60 deg)", "normal takes 2 values: normal(mean, sd)"),
        ("alpha", "gauss(60 deg, 1 deg)", '"gauss" is no distribution that is known'),
        ("alpha", "+- -1 deg", "what stands behind +- must be more than 0"),
        ("alpha", "normal(60 deg, 0 deg)", "the standard deviation must be more than 0"),
        ("alpha", "uniform(61 deg, 59 deg)", "must grow from the first to the last"),
        ("alpha", "triangular(59 deg, 63 deg, 61 deg)", "must grow from the first to the last"),
        ("alpha", "60 deg +- 40 deg", "it reaches to 100 deg, which is out of range (0 or more, below 90 deg)"),
        ("alpha", "60 deg +- 70 deg", "it reaches to -10 deg, which is out of range"),
        ("alpha", "normal(80 deg, 20 deg)", "31% of it would be out of range"),
        ("alpha", "60 deg +- 1 deg 0 sd", "does not say how many standard deviations"),
        ("alpa", "+- 1 deg", "alpa: is not known as a dimension with a tolerance; did you mean scale.alpha?"),
        ("pitch", "+- 1 mm +- 1 mm", "is not a length"),
        ("eta", "3 +- 0.1", "eta: is a ratio or a setting"),
        ("beam.scales", "25 +- 1", "beam.scales: is not known as a dimension with a tolerance"),
        ("joint.stiffness", "+- 5 %", "the beam has no joint.stiffness of its own"),
        ("mu", "+- 0.3", "it reaches to -0.05"),
        ("mu", 5, "mu = 5: is no tolerance"),
    ],
)
def test_tolerances_that_cannot_be(name, text, words):
    with pytest.raises(InputError) as caught:
        tolerances({name: text}, BEAM, bare=False)
    assert words in str(caught.value)
    assert len(str(caught.value).splitlines()) == 1


def test_all_mistakes_are_told():
    with pytest.raises(InputError) as caught:
        tolerances(
            {"alpha": "x", "scale.alpha": "+- 1 deg", "theta0": "+- 1 deg", "scale": {"theta0": "+- 2 deg"}}, BEAM
        )
    assert [line.split(":")[0] for line in str(caught.value).splitlines()] == ['alpha = "x"', "scale.theta0"]
    with pytest.raises(InputError, match="there are none"):
        tolerances({}, BEAM)


def test_summary(beam, capsys):
    vary = ("--vary", "scale.alpha=60 deg +- 1 deg", "--vary", 'mu="normal(0.25, 0.03)"')
    assert (
        main(
            [
                "uncertainty",
                beam,
                "--joint",
                "hinge",
                *vary,
                *FEW,
                "--before",
                "200 deg total",
                "--indices",
                "64",
                "--full",
            ]
        )
        == 0
    )
    out = capsys.readouterr().out
    assert out.startswith(f"{beam}: nine of ten beams: end of the curve ")
    assert "4096, scrambled Sobol points, seed 0" in out
    assert "  scale.alpha = uniform(59 deg, 61 deg)\n  friction.mu = normal(0.25, 0.03)\n" in out
    assert "locked before 200 deg total  none of 4096 beams (below 0.073 % with 95 % confidence)" in out
    assert "the nominal beam: frictional lock" in out
    assert "  locked before: none, it does not vary" in out
    u = squama.uncertainty(BEAM, {"alpha": "+- 1 deg", "mu": "normal(0.25, 0.03)"}, samples=3200, joint="hinge")
    row = next(line for line in out.splitlines() if line.startswith("phi_end "))
    one = u.sel(figure="phi_end")
    figures = [one.nominal, one["mean"], one.sd, *one["quantile"].sel(level=[0.05, 0.5, 0.95])]
    assert row.split() == ["phi_end", "deg", "per", "pitch", *(f"{np.degrees(float(v)):.3g}" for v in figures), "100"]


def test_files_of_tolerances_and_flags(beam, capsys):
    Path("tol.toml").write_text('[tolerance]\nscale.alpha = "+- 3 deg"\n"mu" = "+- 0.1"\nbeam.pitch = "+- 1 %"\n')
    flags = ("--tolerances", "tol.toml", "--vary", "mu=0.2 +- 0.02 triangular")
    assert (
        main(
            [
                "uncertainty",
                beam,
                "--joint",
                "hinge",
                *flags,
                *FEW,
                "--json",
                "--sampler",
                "random",
                "--seed",
                "4",
                "--indices",
                "64",
            ]
        )
        == 0
    )
    got = json.loads(capsys.readouterr().out)
    assert got["tolerances"] == {
        "scale.alpha": "uniform(57 deg, 63 deg)",
        "friction.mu": "triangular(0.18, 0.2, 0.22)",
        "beam.pitch": f"uniform({BEAM.pitch * 990:.6g} mm, {BEAM.pitch * 1010:.6g} mm)",
    }
    assert (got["samples"], got["sampler"], got["seed"]) == (3200, "random", 4)
    assert got["chances"]["frictional lock"]["number"] == 3200
    assert got["statistics"]["K_0"]["unit"] == "N m^2"
    assert [q["level"] for q in got["statistics"]["RED_c"]["quantiles"]] == [0.01, 0.05, 0.25, 0.5, 0.75, 0.95, 0.99]
    assert set(got["indices"]["RED_c"]) == set(got["tolerances"])
    assert got["indices"]["RED_c"]["friction.mu"]["ST"] > 0.9
    assert "engaged" in got["indices"]["without"]


def test_samples_in_files(beam):
    assert (
        main(
            ["uncertainty", beam, "--joint", "hinge", "--vary", "mu=+- 0.1", *FEW, "--csv", "u.csv", "--netcdf", "u.nc"]
        )
        == 0
    )
    rows, whole = squama.read("u.csv"), squama.read("u.nc")
    again = squama.uncertainty(BEAM, {"mu": "+- 0.1"}, samples=3200, keep=True, joint="hinge")
    assert whole.identical(again)
    assert rows.sizes == {"sample": 4096}
    for name in rows.data_vars:
        np.testing.assert_array_equal(rows[name], again[name])
    assert {"friction.mu", "phi_end", "sample_end", "K_e"} <= set(rows.data_vars)
    assert np.mean(rows.phi_end) == pytest.approx(float(again["mean"].sel(figure="phi_end")), rel=1e-12)


def test_picture(beam):
    flags = (
        "--vary",
        "mu=+- 0.1",
        "--vary",
        "alpha=uniform(15 deg, 40 deg)",
        "--indices",
        "64",
        "--before",
        "0.4 rad/pitch",
    )
    assert main(["uncertainty", beam, "--joint", "hinge", *flags, *FEW, "--plot", "u.png", "--plot", "u.svg"]) == 0
    text = Path("u.svg").read_text(encoding="utf-8")
    for words in ("off tip edge", "frictional lock", "scale.alpha", "nominal beam", "beams that have locked"):
        assert words in text
    u = squama.uncertainty(
        BEAM, {"mu": "+- 0.1", "alpha": "uniform(15 deg, 40 deg)"}, samples=3200, before="0.4 rad/pitch", joint="hinge"
    )
    left, right = uncertainty_figure(u).axes
    labels = [t.get_text() for t in left.get_legend().get_texts()]
    for end in u.end.values:
        share = 100 * float(u.probability.sel(end=end))
        (label,) = [t for t in labels if t.startswith(end)]
        # tolerance: the label has so many digits
        assert float(label.rsplit(",", 1)[1].strip(" %")) == pytest.approx(share, rel=0.01)
    locked = right.lines[0].get_ydata()
    assert locked[0] == 0
    assert locked[-1] == pytest.approx(float(u.P_locked))
    # the point lies on the curve
    (x,), (y,) = next(line.get_data() for line in right.lines if line.get_marker() == "o")
    assert (x, y) == pytest.approx((np.degrees(25 * 0.4), float(u.P_locked_before)))
    assert np.interp(x, right.lines[0].get_xdata(), locked) == pytest.approx(y, abs=0.02)
    # a rate has no place where the pitch varies too
    v = squama.uncertainty(BEAM, {"beam.pitch": "+- 1 %"}, samples=3200, before="15 rad/m", joint="hinge")
    assert not [line for line in uncertainty_figure(v).axes[1].lines if line.get_marker() == "o"]


@pytest.mark.parametrize(
    ("flags", "lines"),
    [
        ((), ["--vary: no tolerance is given; write e.g."]),
        (("--vary", "alpha"), ['--vary "alpha": is not name=tolerance']),
        (
            ("--vary", "mu=x", "--vary", "alpha=+-1"),
            ['--vary mu = "x": is no tolerance', '--vary alpha = "+-1": "1" has no unit'],
        ),
        (("--vary", "mu=+-.1", "--vary", "mu=+-.1"), ["--vary mu: is given twice"]),
        (("--vary", "mu=+-.1", "--samples", "10"), ['--samples = "10": is out of range (3200 to 16777216)']),
        (("--vary", "mu=+-.1", "--seed", "1.5"), ["--seed = 1.5: is not a whole number"]),
        (("--vary", "mu=+-.1", "--indices", "100"), ["--indices = 100: is no power of two"]),
        (("--vary", "mu=+-.1", "--sampler", "grid"), ['--sampler = "grid": must be "sobol" or "random"']),
        (("--vary", "mu=+-.1", "--before", "90 deg"), ['--before = "90 deg": does not say over which length']),
        (("--vary", "mu=+-.1", "--before", "-1 rad/m"), ['--before = "-1 rad/m": must be more than 0']),
        (("--vary", "mu=+-.1", "--before", "3"), ['--before = "3"']),
        (("--vary", "mu=+-.1", "--plot", "a.txt"), ["a.txt: the extension .txt is not known"]),
        (("--vary", "mu=+-.1", "--csv", "beam.toml"), ["beam.toml"]),
        (("--tolerances", "none.toml"), ["none.toml"]),
        (("--tolerances", "beam.toml"), ["beam.toml: holds scale, substrate, beam, friction too"]),
        (("--tolerances", "bad.toml"), ['bad.toml: line 2: "mu = +- 0.1" is not valid TOML']),
        (
            ("--tolerances", "wrong.toml"),
            ['wrong.toml: scale.alpha = "+- 1 mm"', "wrong.toml: nu: is not known as a dimension"],
        ),
        (
            ("--vary", "scale.embedded=uniform(5 mm, 200 mm)"),
            ["tolerances: some samples are no valid beam; at scale.embedded = "],
        ),
        (("--vary", "alpha=+-1 deg", "--law", "x", "--load", "y"), ['--load = "y"', '--law = "x"']),
    ],
)
def test_mistakes(flags, lines, beam, capsys):
    Path("bad.toml").write_text("[tolerance]\nmu = +- 0.1\n")
    Path("wrong.toml").write_text('[tolerance]\nscale.alpha = "+- 1 mm"\nnu = "+- 1"\n')
    assert main(["uncertainty", beam, "--joint", "hinge", *flags]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    got = err.splitlines()
    assert len(got) == len(lines)
    for line, words in zip(got, lines, strict=True):
        assert words in line


def test_friction_is_needed(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    squama.Beam.from_ratios().to_toml("beam.toml")
    assert main(["uncertainty", "beam.toml", "--vary", "alpha=+- 1 deg"]) == 2
    assert "beam.toml: friction.mu: is missing" in capsys.readouterr().err
    assert main(["uncertainty", "beam.toml", "--joint", "hinge", "--vary", "alpha=+- 1 deg", "--mu", "0.2", *FEW]) == 0
    assert main(["uncertainty", "beam.toml", "--joint", "hinge", "--vary", "mu=0.2 +- 0.1", *FEW]) == 0

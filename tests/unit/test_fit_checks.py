"""What a fit says of its record: wrong units, another bar, too few rows, sorted rows, the beam's own ends, a rival."""

from __future__ import annotations

import functools
import json
from types import SimpleNamespace

import numpy as np
import pytest

import squama
from squama.cli import main
from squama.curves import finite_rows
from squama.errors import InputError, refuse
from squama.identify import fitting, noise, selection, slope
from squama.identify.hinge_points import Physical
from squama.identify.readings import Readings
from squama.identify.slope import Slope
from squama.loads import LOADS

BEAM = squama.Beam.from_toml("examples/stiff_skin.toml").replace(scales=None).replace(hold="bend, lateral bend")
TOP, TWISTING = 0.12, LOADS["twisting"]


@functools.cache
def loop(modulus=1.0, joint="compliant"):
    """Twists and torques of a loop with noise, of a beam whose bar is another one."""
    beam = BEAM.replace(substrate={"youngs_modulus": modulus * BEAM.substrate.youngs_modulus})
    c = squama.cycle(beam, f"{TOP} rad/pitch", mu=0.32, points=80, joint=joint)
    x, T = c.phi.values, c["T"].values
    return x, T + np.random.default_rng(3).normal(0, 2e-3 * T.max(), T.size)


def fitted(x, T, names="mu,K_theta", *, starts=2, scales=None, **given):
    return squama.fit({"phi": x, "T": T}, BEAM.replace(scales=scales), names, nuisances="none", starts=starts, **given)


@pytest.mark.slow(but=1)
@pytest.mark.usefixtures("alone")
@pytest.mark.parametrize("joint", ["compliant", "hinge"])
def test_the_slope_before_engagement_is_always_told(joint):
    fit = fitted(*loop(joint=joint), joint=joint)
    assert abs(fit.slope.ratio - 1) < 4 * fit.slope.error
    assert fit.slope.error < 0.1
    straight = (fit.branch == "straight") & fit.used
    assert fit.slope.points == np.count_nonzero(straight)
    # by hand: lines of one slope through the points of either way
    x, T = (values[straight] for values in loop(joint=joint))
    way = fit.points.readings.numbers[straight]
    A = np.column_stack([x, *(way == number for number in np.unique(way))]).astype(float)
    expected = np.linalg.lstsq(A, T, rcond=None)[0][0] / (fit.asked.base.rigidity / BEAM.pitch)
    assert fit.slope.ratio == pytest.approx(expected, rel=1e-9)
    assert f"slope before engagement: {fit.slope.text} of the beam's own" in fit.summary()
    assert fit.holds


@pytest.mark.slow(but=1)
@pytest.mark.usefixtures("alone")
@pytest.mark.parametrize(
    ("twists", "torques", "words"),
    [
        (1, 1000, "as of a torque in N mm taken as N m"),
        (1, 1e-3, "as of a torque in N m taken as N mm"),
        (1, 100, "as of a torque in N cm taken as N m"),
    ],
)
def test_a_wrong_unit_of_the_torque_is_named(twists, torques, words):
    x, T = loop()
    fit = fitted(twists * x, torques * T, starts=1)
    assert words in fit.doubts[0]
    assert "check the units of torque and twist" in fit.doubts[0]
    assert not fit.holds


@pytest.mark.parametrize(("torques", "words"), [(1000, "no fit is found: the slope .* N mm taken as N m"), (1, "sees")])
def test_a_wrong_unit_is_named_where_no_fit_is_found(monkeypatch, torques, words):
    """The joint may run off until no point depends on it."""

    def off(*_):
        refuse("K_theta", "", "no point sees it")

    monkeypatch.setattr(selection, "find", off)
    x, T = loop()
    with pytest.raises(squama.InputError, match=words):
        fitted(x, torques * T)


@pytest.mark.usefixtures("alone")
@pytest.mark.parametrize(
    ("twists", "words"),
    [
        (np.pi / 180, "as of a twist in rad taken as deg"),
        (1 / 25, "as of a twist per pitch taken as the twist of the whole beam"),
        (180 / np.pi, "check the unit of the twist"),
        (-1, "opposite signs"),
    ],
)
def test_a_wrong_unit_of_the_twist_is_named(twists, words):
    x, T = loop()
    with pytest.raises(squama.InputError, match=words):
        fitted(twists * x, T)


@pytest.mark.slow
@pytest.mark.usefixtures("alone")
def test_a_softer_bar_is_named_and_found():
    x, T = loop(modulus=0.7)
    fit = fitted(x, T)
    # tolerance: noise of a fixed seed, 0.4 errors and 0.2 % measured
    assert fit.slope.ratio == pytest.approx(0.7, abs=4 * fit.slope.error)
    assert "softer than its file says (modulus, section or inclusion factor)" in fit.doubts[0]
    found = fitted(x, T, "mu,K_theta,E_B")
    assert found.slope.ratio == pytest.approx(fit.slope.ratio, abs=fit.slope.error)
    assert found.values["E_B"] == pytest.approx(0.7 * BEAM.substrate.youngs_modulus, rel=0.05)
    assert not any("slope" in doubt for doubt in found.doubts)


def test_causes():
    assert (
        Slope(0.85, 0.004, 30)
        .cause(("mu",), 25, TWISTING)
        .startswith("the slope before engagement is 0.8500 +- 0.0040 of")
    )
    assert "15 % softer" in Slope(0.85, 0.004, 30).cause(("mu",), 25, TWISTING)
    assert "5.0 % stiffer" in Slope(1.05, 0.004, 30).cause(("mu",), 25, TWISTING)
    # within its error, and within what no file knows
    assert not Slope(0.85, 0.06, 30).cause(("mu",), 25, TWISTING)
    assert not Slope(1.005, 1e-5, 30).cause(("mu",), 25, TWISTING)
    assert not Slope(0.85, 0.004, 30).cause(("mu", "C_f"), 25, TWISTING)
    assert slope.unit(2 * np.pi, 25, TWISTING).endswith("a twist in revolutions taken as rad")
    assert slope.unit(1 / 24, 25, TWISTING).endswith("the twist of the whole beam taken as a twist per pitch")
    assert slope.unit(-1.1, 25, TWISTING) == "a sign is wrong"
    assert slope.unit(333, 25, TWISTING) == "a unit is wrong"


@pytest.mark.usefixtures("alone")
def test_rows_that_are_sorted_by_the_twist_are_refused():
    x, T = loop()
    place = np.argsort(x, kind="stable")
    with pytest.raises(InputError, match=r"the rows are sorted by the twist: .* sort the rows by the time"):
        fitted(x[place], T[place])
    with pytest.raises(InputError, match="sorted by the twist"):
        fitted(x[place[::-1]], T[place[::-1]])
    # either way alone is in order
    up = np.arange(x.size) <= np.argmax(x)
    assert np.isfinite(fitted(x[up], T[up]).estimates).all()


def test_a_few_rows_sorted_by_the_twist():
    x = np.linspace(0, 1, 10)
    up = x + 5 * np.maximum(x - 0.3, 0) ** 1.5
    both = np.stack([up, 0.8 * up], axis=1).ravel()
    assert noise.mixed(np.repeat(x, 2), both)
    assert noise.mixed(-np.repeat(x, 2)[::-1], -both[::-1])
    # two readings of one branch at each twist, with their noise
    r = np.random.default_rng(1)
    assert not any(noise.mixed(np.repeat(x, 2), np.repeat(up, 2) + r.normal(0, 0.05, 20)) for _ in range(50))
    assert not noise.mixed(np.concatenate([x, x[::-1]]), np.concatenate([up, 0.8 * up[::-1]]))


def test_noise_and_coarse_readings_are_no_branches():
    r = np.random.default_rng(5)
    x = np.linspace(0, 1, 120)
    clean = x + np.maximum(x - 0.5, 0) ** 1.5 * 5
    for size in (0.0, 1e-3, 3e-2):
        assert not noise.interleaved(x, clean + r.normal(0, size, x.size))
    for digit in (0.01, 0.1):
        assert not noise.interleaved(x, np.round(clean / digit) * digit)
    gap = np.where(r.random(x.size) < 0.5, 0.3 * np.maximum(x - 0.4, 0), 0.0)
    assert noise.interleaved(x, clean - gap + r.normal(0, 1e-3, x.size))


@pytest.mark.slow
@pytest.mark.usefixtures("alone")
def test_too_few_points_are_doubted():
    x, T = loop()
    up = np.flatnonzero(np.arange(x.size) <= np.argmax(x))
    few = fitted(x[up[[30, -10, -1]]], T[up[[30, -10, -1]]])
    assert few.doubts[0] == ("too few points: 3 for 2 parameters hardly tell the noise; measure 8 or more, better 20")
    assert few.slope is None
    assert "slope before engagement: too few points there" in few.summary()
    some = up[np.linspace(5, up.size - 1, 8).astype(int)]
    assert not any("too few" in doubt for doubt in fitted(x[some], T[some]).doubts)
    # a noise that is given leaves to be seen whether the model holds
    given = fitted(x[up[[-10, -1]]], T[up[[-10, -1]]], noise="0.2 N mm")
    assert "hardly tell whether the model holds" in given.doubts[0]


@pytest.mark.slow
@pytest.mark.usefixtures("alone")
def test_the_ends_of_the_beam_are_told():
    assert fitted(*loop()).row is None
    fit = fitted(*loop(), scales=25, ends="endless")
    row = squama.row(fit.beam, to=f"{TOP} rad/pitch", points=200)
    T, endless = row["T"].values, row.T_periodic.values
    assert fit.row.scales == 25
    assert fit.row.load == pytest.approx(TOP)
    assert fit.row.torque == pytest.approx(T[-1] / endless[-1], rel=1e-3)
    # tolerance: differences of 30 and of 200 points, 0.5 % measured, on every processor
    assert fit.row.tangent == pytest.approx((T[-1] - T[-2]) / (endless[-1] - endless[-2]), rel=0.1)
    line = next(line for line in fit.summary().splitlines() if line.startswith("25 scales have"))
    assert line.endswith("(squama row): mu and K_theta are those of an endless beam and biased by it")
    assert fit.dataset().attrs["checked"].splitlines()[0] == line


@pytest.mark.slow
def test_the_ends_of_a_long_beam_take_the_less():
    beam = BEAM.replace(friction={"mu": 0.32})
    near, long = (finite_rows.ends(beam.replace(scales=n), TOP / BEAM.pitch) for n in (25, 1000))
    row = squama.row(beam, scales=80, to=f"{TOP} rad/pitch", points=6)
    share = float(row["T"][-1] / row.T_periodic[-1])
    # tolerance: ends of 100 scales stand for those of 1000, and of 80 here; they reach farther, 7 % measured
    assert 1 - long.torque == pytest.approx((1 - share) * 80 / 1000, rel=0.3)
    assert long.torque > near.torque


@pytest.mark.slow
def test_where_the_row_ends_before_the_data_that_is_told():
    row = squama.Beam.from_ratios(eta=3, beta=0.6, lam=0.32, zeta=0.18, slenderness=45, mu=0.2)
    ended = finite_rows.ends(row, 0.4 / row.pitch, joint="hinge")
    assert ended.end == "side entry"
    assert 0.2 < ended.load < 0.2676
    beam = squama.Beam.from_toml("examples/pla_on_vps.toml").replace(scales=None).replace(friction={"mu": 0.3})
    found = finite_rows.ends(beam, 0.14 / beam.pitch)
    assert (found.end, found.load) == ("", pytest.approx(0.14))
    assert 0.3 < found.torque < 1
    # before engagement there are no ends to speak of
    assert finite_rows.ends(beam, 0.01 / beam.pitch) is None


def test_the_first_half_is_told_where_scales_touch_before_the_model_does():
    x = np.linspace(0, 0.05, 101)
    noisy = np.random.default_rng(1).normal(0, 1e-5, x.size)
    readings = Readings.of(x, np.ones(x.size), np.zeros(x.size, int), 25)
    points = SimpleNamespace(readings=readings, touching=lambda _: np.zeros(x.size, bool))
    v = Physical(0.3, 1.0, 1.0, 0.1)
    for bend, count in ((0.0, 101), (4.0, 51)):
        record = SimpleNamespace(load=x, torque=2 * x + bend * np.maximum(x - 0.03, 0) + noisy)
        found = slope.slope(record, points, np.ones(x.size, bool), v, (2.0, 1e6), 1e-5)
        assert found.points == count
        # tolerance: noise of a fixed seed, whose four errors are 1e-4 and 3e-4
        assert abs(found.ratio - 1) < 4 * found.error < 0.01


@pytest.mark.slow
def test_a_rival_that_does_not_describe_the_points_is_not_told(tmp_path, capsys):
    x, T = loop()
    fit = fitted(x, T)
    assert fit.rival is None
    assert not fit.disagreement
    # beside so much noise it is within reach of a search from one start, and is fitted to the end
    noisy = T + 0.3 * np.abs(T).max() * np.random.default_rng(3).normal(size=T.size)
    near = fitted(x, noisy)
    assert near.rival.found.rms < fitting._HOPELESS * near.rms
    assert "disagree" not in fit.summary()
    assert fit.summary().startswith("mu ")
    rows = "".join(f"{a:.9g},{b:.9g}\n" for a, b in zip(x, T, strict=True))
    (tmp_path / "test.csv").write_text("phi (rad),T (N m)\n" + rows)
    given = ["fit", str(tmp_path / "test.csv"), "examples/stiff_skin.toml", "--nuisances", "none"]
    given += ["--hold", "bend, lateral bend", "--ends", "endless"]
    assert main(given) == 0
    assert ": mu = " in capsys.readouterr().out
    assert main([*given, "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["slope"]["ratio"] == pytest.approx(fit.slope.ratio)
    assert told["ends"] == "endless"

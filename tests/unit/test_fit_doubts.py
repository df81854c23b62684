"""Fits of loops with what tests bring: errors that cover, nuisances, stray points, two models that disagree."""

from __future__ import annotations

import functools
import json

import numpy as np
import pytest

import squama
from campaigns import fits
from campaigns.fits import CASES, NOISE
from squama.cli import main
from squama.identify import fitting, noise
from squama.identify.readings import Readings
from squama.plot import fit_figure

RIGID = "rigid scales"
DEGREE = np.radians(1)
STARTS = 2
"""Of every search here: what is looked at does not depend on how many there are."""


def loop(kind: str, seed: int = 100, beam: str = RIGID):
    return fits.measured((beam, kind), np.random.default_rng([2014, CASES.index((beam, kind)), seed]))


few_starts = functools.partial(squama.fit, starts=STARTS)


@functools.cache
def fitted(kind: str, seed: int = 100):
    """The fit of such a loop, whether its intervals cover the true values, and the seconds that it took."""
    return fits.fitted((RIGID, kind), seed, STARTS)


@pytest.mark.slow
@pytest.mark.parametrize("kind", fits.KINDS)
def test_intervals_hold(kind):
    """A short version of the campaign: of six right intervals two miss once in a hundred times."""
    inside = [fitted(kind, 100 + seed) for seed in range(3)]
    assert sum(yes or not fit.holds for fit, covers, _ in inside for yes in covers.values()) >= 4
    assert max(took for _, _, took in inside) < fits.SECONDS


@pytest.mark.slow
def test_a_loop_of_compliant_joints_on_hinges_is_not_believed():
    start, data, true = loop("white noise")
    hinged, (compliant, _, _) = few_starts(data, start, joint="hinge"), fitted("white noise")
    assert (hinged.joint, compliant.joint) == ("hinge", "compliant")
    assert not hinged.holds
    assert compliant.holds
    lines = hinged.summary().splitlines()
    assert lines[0].startswith("mu ")
    assert hinged.disagreement in lines
    assert "the models disagree on" in hinged.disagreement
    assert hinged.disagreement.endswith("describe the points better")
    # the hinges do not describe what a beam on compliant joints does
    assert not compliant.disagreement
    assert compliant.rival is None
    for name, value in true.items():
        assert hinged.values[name] != pytest.approx(value, rel=0.05)
        assert abs(compliant.values[name] - value) < 3 * compliant.errors[name]


@pytest.mark.slow
def test_a_loop_on_hinges_by_default_is_doubted():
    start, data, _ = loop("white noise", beam="hinges")
    fit = few_starts(data, start)
    assert fit.joint == "compliant"
    assert not fit.holds
    assert fit.disagreement.endswith("describe the points better")
    assert few_starts(data, start, joint="hinge").holds


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kind", "name", "value", "near"),
    [
        ("drift", "drift", fits.DRIFT, 8e-3),
        ("twist zero", "twist_zero", fits.TWIST_ZERO * DEGREE, 0.5 * DEGREE),
        ("backlash", "backlash", fits.BACKLASH * DEGREE, 0.5 * DEGREE),
    ],
)
def test_a_nuisance_is_found_and_said(kind, name, value, near):
    start, data, _ = loop(kind, seed=101)
    fit, *_ = fitted(kind, 101)
    assert name in fit.added
    # tolerance: noise of fixed seeds; the table says how near
    assert abs(fit.values[name]) == pytest.approx(value, abs=near)
    assert any(note.startswith(f"{name} is found too: the residual ") for note in fit.notes)
    alone = few_starts(data, start, nuisances="none")
    assert alone.parameters == ("mu", "K_theta")
    assert not alone.added
    # asked for it is found with what else the residual shows
    told = few_starts(data, start, ("mu", "K_theta", *fit.added), nuisances="none")
    for name, error in fit.errors.items():
        assert abs(told.values[name] - fit.values[name]) < 0.3 * error, name


def test_a_stray_point_is_named_by_its_line(tmp_path):
    start, data, true = loop("white noise")
    T = data["T"].copy()
    T[[40, 250]] += 20 * NOISE, -30 * NOISE
    rows = "".join(f"{x:.9g},{t:.6g}\n" for x, t in zip(data["phi"], T, strict=True))
    (tmp_path / "test.csv").write_text("phi (rad),T (N m)\n" + rows)
    fit = few_starts(tmp_path / "test.csv", start)
    assert np.flatnonzero(fit.branch == "stray").tolist() == [40, 250]
    assert not fit.used[[40, 250]].any()
    said = [note for note in fit.notes if note.startswith("stray")]
    assert [note.rpartition(" ")[2] for note in said] == ["42", "252"]
    clean, *_ = fitted("white noise")
    for name in true:
        assert abs(fit.values[name] - clean.values[name]) < 0.5 * clean.errors[name]
    assert len(fit.plot().axes) == len(fit_figure(fit.dataset()).axes) == 2


@pytest.mark.slow
def test_specimens_and_a_record_that_begins_with_unloading():
    start, data, true = loop("white noise")
    down = {name: values[fits.POINTS :] for name, values in data.items()}
    fit = few_starts([data, down], start)
    for name, value in true.items():
        assert abs(fit.values[name] - value) < 4 * fit.errors[name]
    assert all(s.values is not None for s in fit.specimens)


@pytest.mark.slow
def test_noise_of_the_twist_that_turns_it_round_is_no_reversal():
    start, data, true = loop("white noise")
    phi = data["phi"] + np.random.default_rng(4).normal(0, 1e-3, data["phi"].size)
    fit = few_starts({"phi": phi, "T": data["T"]}, start)
    assert len(np.unique(fit.points.readings.numbers)) == 2
    assert fit.uneven
    for name, value in true.items():
        assert abs(fit.values[name] - value) < 3 * fit.errors[name]


def test_a_loop_of_hinges_beyond_what_compliant_joints_follow_is_fitted_on_hinges():
    start, *_ = loop("white noise")
    far = {"phi": np.linspace(0, 0.155, 60), "T": np.linspace(0, 3, 60)}
    fit = few_starts(far, start.replace(friction={"mu": 0.1}), ("mu", "theta0"))
    assert fit.joint == "hinge"
    assert fit.notes[0].startswith("theta0 is found on hinges only")
    assert fit.rival is None


def test_correlated_residuals_are_worth_fewer_points():
    r, way = np.random.default_rng(8), np.zeros(20_000, int)
    white = r.normal(size=way.size)
    slow = np.zeros(way.size)
    for i in range(1, way.size):
        slow[i] = 0.8 * slow[i - 1] + white[i]
    # of an autoregressive process (1 + r) / (1 - r)
    # tolerance: a series of a fixed seed, 10 % measured
    assert noise.dependence(slow, way) == pytest.approx(9, rel=0.15)
    assert noise.dependence(white, way) < 1.1
    # from one way to the next nothing is correlated
    assert noise.dependence(np.repeat(white[:500], 40), np.arange(20_000)) == 1
    assert noise.uneven(white * np.linspace(0, 1, way.size), np.linspace(0, 1, way.size))
    assert not noise.uneven(white, np.linspace(0, 1, way.size))


def test_sandwich_is_the_covariance_of_uneven_noise():
    r, n = np.random.default_rng(9), 60
    J = np.stack([np.ones(n), np.linspace(0, 1, n)], axis=1)
    sigma = np.linspace(0.1, 2, n)
    inner = np.linalg.inv(J.T @ J)
    found, said = [], []
    for _ in range(2000):
        y = sigma * r.normal(size=n)
        p = inner @ J.T @ y
        found.append(p)
        said.append(noise.sandwich(J, y - J @ p, inner))
    # tolerance: a covariance of few series of fixed seeds, 6 % measured
    np.testing.assert_allclose(np.cov(np.array(found).T), np.mean(said, axis=0), rtol=0.12)


def test_readings_and_twists():
    """By hand: 10 scales; zero 1, play 2 over the whole beam."""
    load = np.array([0.0, 1, 2, 3, 2.9, 2, 1, 2, 3])
    way = np.array([1, 1, 1, 1, -1, -1, -1, 1, 1])
    readings = Readings.of(load, way, np.zeros(9, int), 10)
    x, branch = readings.placed(1.0, 2.0, 0.0)
    # on the way back the play is taken up first; what lies in it stays on the branch before
    np.testing.assert_allclose(x, [-0.1, 0.9, 1.9, 2.9, 2.9, 2.1, 1.1, 1.9, 2.9])
    assert branch.tolist() == [-1, 1, 1, 1, 1, -1, -1, 1, 1]
    assert readings.order[[0, -1]].tolist() == [0, 1]


def test_errors_allow_for_the_nuisances_that_may_be_there(monkeypatch):
    """Errors against fits with each selection of two nuisances, which are weighed by their sums of squares."""
    monkeypatch.setattr(fitting, "SHOWN", ("torque_zero", "drift"))
    monkeypatch.setattr(fitting, "_rival", lambda *_: None)
    start, data, _ = loop("white noise", beam="hinges")
    data["T"] = data["T"] - 0.004 * np.linspace(0, 1, data["T"].size)
    whole = few_starts(data, start, joint="hinge", noise=NOISE)
    assert whole.dependence == 1
    asked, n = ("mu", "K_theta"), np.count_nonzero(whole.used)
    fits_of, cost = {}, {}
    for more in ((), ("torque_zero",), ("drift",), ("torque_zero", "drift")):
        one = few_starts(data, start, (*asked, *more), joint="hinge", noise=NOISE, nuisances="none")
        fits_of[more], cost[more] = one, n * (one.rms / NOISE) ** 2 + np.log(n) * len(more)
    weight = {more: np.exp((min(cost.values()) - c) / 2) for more, c in cost.items()}
    assert sorted(weight.values())[-2] > 0.03
    place = [("mu", "K_theta", "torque_zero", "drift").index(name) for name in whole.parameters]
    own = fits_of[whole.added].covariance
    moment = np.zeros((4, 4))
    for more, one in fits_of.items():
        rows = [("mu", "K_theta", "torque_zero", "drift").index(name) for name in one.parameters]
        apart = np.zeros(4)
        apart[rows] = one.estimates
        apart[place] -= whole.estimates
        moment += weight[more] / sum(weight.values()) * np.outer(apart, apart)
        moment[np.ix_(rows, rows)] += weight[more] / sum(weight.values()) * one.covariance
    # in every axis of both as wide as the wider one
    half = np.linalg.cholesky(own)
    seen = np.linalg.solve(half, np.linalg.solve(half, moment[np.ix_(place, place)]).T)
    size, axes = np.linalg.eigh(seen)
    expected = half @ axes @ np.diag(np.maximum(size, 1)) @ axes.T @ half.T
    np.testing.assert_allclose(whole.covariance, expected, rtol=0.02)
    assert np.all(whole.covariance.diagonal()[:2] > 1.05 * own.diagonal()[:2])


@pytest.mark.slow
@pytest.mark.parametrize("joint", ["compliant", "hinge"])
def test_warnings_are_of_the_model_that_is_fitted(joint, capsys):
    given = ["fit", "examples/stiff_skin_loop.csv", "examples/stiff_skin.toml", "--joint", joint]
    given += ["--nuisances", "none", "--starts", "1", "--ends", "endless"]
    assert main(given) == 0
    assert ("the scales are not thin" in capsys.readouterr().out) == (joint == "hinge")
    assert main([*given, "--json"]) == 0
    warnings = json.loads(capsys.readouterr().out)["warnings"]
    assert any("the scales are not thin" in line for line in warnings) == (joint == "hinge")

"""Fits of a beam of few scales with its ends: the model is that of ``squama.cycle``, and the search finds its least."""

from __future__ import annotations

import functools
import json

import numpy as np
import pytest

import squama
from squama.cli import main
from squama.errors import InputError
from squama.identify import joint_points, prepare, records
from squama.identify.hinge_points import Physical
from squama.identify.joint_points import Linear, Walked
from squama.identify.prepare import Wanted
from squama.loads import LOADS

BEAM = squama.Beam.from_toml("examples/stiff_skin.toml").replace(scales=5, hold="bend, lateral bend")
TRUE = BEAM.replace(friction={"mu": 0.31}, joint={"stiffness": 0.105})
WAY = "0.11 rad/pitch"


@functools.cache
def cycle(ends=None, hold="bend, lateral bend", sign="", load="twisting", faces="one"):
    return squama.cycle(TRUE.replace(hold=hold, faces=faces), f"{sign}{WAY}", load=load, points=20, ends=ends)


def walked(c, beam, ends, load="twisting"):
    """Return the points of a test at the twists, or bends, of a cycle, and the values of its beam."""
    names = LOADS[load].angle, LOADS[load].torque
    specimens = records.read({name: c[name].values for name in names}, beam, load)
    asked = "mu", "K_theta"
    wanted = Wanted(beam, specimens, asked, load, "edge", None, records.ALL, None, 1, (), ends)
    made = prepare.prepared("compliant", wanted)
    return made.points, made.asked.physical(np.array([0.31, 0.105]))


@pytest.mark.parametrize(
    ("ends", "hold", "sign", "load", "faces"),
    [
        ("free", "bend, lateral bend", "", "twisting", "one"),
        ("free", "nothing", "-", "twisting", "one"),
        ("gripped", "nothing", "", "twisting", "one"),
        ("equal", "nothing", "", "twisting", "one"),
        ("endless", "bend, lateral bend", "", "twisting", "one"),
        ("free", "nothing", "", "bending", "one"),
        ("endless", "nothing", "", "bending", "mirrored"),
        ("endless", "nothing", "-", "twisting", "turned, shifted"),
    ],
)
def test_the_torque_of_a_trial_is_that_of_a_cycle(ends, hold, sign, load, faces):
    c = cycle(ends, hold, sign, load, faces)
    points, v = walked(c, BEAM.replace(hold=hold, faces=faces), ends, load)
    T = c[LOADS[load].torque].values
    np.testing.assert_allclose(points.torque(v), T, rtol=0, atol=1e-9 * np.abs(T).max())
    N = c["N"].values
    # the last scale has no neighbour to touch, NaN
    touches = np.nansum(N, axis=1) > 0 if N.ndim == 2 else N > 0
    assert np.array_equal(points.touching(v), touches)


def test_the_share_and_the_linear_torque_are_those_of_the_scales_where_they_are_found():
    points, v = walked(cycle(), BEAM, "free")
    shared, linear, T = points.shared(v), Linear(points, v), points.torque(v)
    np.testing.assert_allclose(shared.torque(v), T, rtol=1e-12, atol=1e-15)
    assert shared.share.min() < 0.8
    np.testing.assert_array_equal(linear.torque(v), T)
    names = np.array([name in ("mu", "stiffness") for name in Physical._fields])
    near = v._replace(mu=0.32, stiffness=0.106, torque_zero=1e-3)
    np.testing.assert_allclose(linear.jacobian(near, names), points.jacobian(v, names), rtol=1e-12)
    # tolerance: the second order, 3 % of the change measured
    change = points.torque(near) - T
    assert np.linalg.norm(linear.torque(near) - points.torque(near)) < 0.06 * np.linalg.norm(change - 1e-3)


@functools.cache
def fitted(ends=None, **given):
    c = cycle()
    noise = np.random.default_rng(5).normal(0, 2e-5, c.phi.size)
    data = {"phi": c.phi.values, "T": c["T"].values + noise}
    return squama.fit(data, BEAM, nuisances="none", starts=2, ends=ends, **given)


@pytest.mark.slow
@pytest.mark.usefixtures("alone")
def test_a_fit_is_the_least_square_of_the_scales_themselves():
    fit = fitted()
    assert (fit.ends, fit.row) == ("free", None)
    for name, true in {"mu": 0.31, "K_theta": 0.105}.items():
        assert abs(fit.values[name] - true) < 2.5 * fit.errors[name] < 0.2 * true

    # the residual grows either way by what its errors say
    def square(mu, K):
        beam = BEAM.replace(friction={"mu": mu}, joint={"stiffness": K})
        c = squama.cycle(beam, WAY, points=20)
        T = np.interp(ways(cycle().phi.values), ways(c.phi.values), c["T"].values)
        return float(np.sum((fit.record.torque - T)[fit.used] ** 2))

    best = square(*fit.estimates)
    assert best == pytest.approx(fit.rms**2 * np.count_nonzero(fit.used), rel=1e-3)
    for i, name in enumerate(fit.parameters):
        # along the line on which the other parameter follows
        step = fit.covariance[:, i] / fit.errors[name]
        for sign in (-1, 1):
            grown = (square(*(fit.estimates + sign * step)) - best) / fit.noise**2
            # tolerance: 1 where the torque is linear; steps of a tenth of a reading at engagement
            assert grown == pytest.approx(1 / fit.dependence, rel=0.3)


def ways(x):
    return np.concatenate([[0.0], np.cumsum(np.abs(np.diff(x)))])


@pytest.mark.slow
@pytest.mark.usefixtures("alone")
def test_the_endless_beam_stands_beside():
    fit, endless = fitted(), fitted("endless")
    assert endless.endless is None
    assert endless.row.scales == 5
    # (the endless beam does not follow these points, so that its own fit leaves others out as stray)
    assert fit.endless.rms > 3 * fit.rms
    assert fit.endless.values[1] < 0.1 * fit.values["K_theta"]
    line = next(line for line in fit.summary().splitlines() if line.startswith("fitted as 5 scales with free ends; "))
    assert f"as an endless beam: mu = {fit.asked.rows[0].written(fit.endless.values[0], fit.endless.errors[0])}" in line
    report, data = fit.report(), fit.dataset()
    assert (report["ends"], report["number_of_scales"], report["row"]) == ("free", 5, None)
    assert report["endless"]["rms"] == fit.endless.rms
    assert (data.attrs["ends"], data.attrs["checked"].splitlines()[0]) == ("free", line)
    assert "ends" not in endless.dataset().attrs
    assert (endless.report()["ends"], endless.report()["number_of_scales"]) == ("endless", None)
    # the drawn curve is that of the scales: as a cycle of the fitted beam
    far = data.isel(curve=int(np.argmax(data.phi_curve.values)))
    top = squama.cycle(fit.beam, WAY, points=20)["T"].max()
    assert float(far.T_curve) == pytest.approx(float(top), rel=1e-6)


@pytest.mark.slow
def test_ends_that_no_fit_knows_are_refused():
    c = cycle()
    data = {"phi": c.phi.values, "T": c["T"].values}
    with pytest.raises(InputError, match="this beam is endless"):
        squama.fit(data, BEAM.replace(scales=None), ends="free")
    with pytest.raises(InputError, match="is not known of a row on hinges"):
        squama.fit(data, BEAM, ends="free", joint="hinge")
    with pytest.raises(InputError, match="the cells' bend is held"):
        squama.fit(data, BEAM, ends="gripped")
    with pytest.raises(InputError, match="must be one of"):
        squama.fit(data, BEAM, ends="loose")
    assert squama.fit(data, BEAM, joint="hinge", nuisances="none", starts=1).fitted_as == "an endless beam"


@pytest.mark.slow
@pytest.mark.usefixtures("alone")
def test_the_command_takes_ends(tmp_path, capsys):
    c = cycle()
    T = c["T"].values + np.random.default_rng(5).normal(0, 1e-4, c.phi.size)
    rows = "".join(f"{x:.9g},{y:.9g}\n" for x, y in zip(c.phi.values, T, strict=True))
    (tmp_path / "test.csv").write_text("phi (rad),T (N m)\n" + rows)
    (tmp_path / "beam.toml").write_text(BEAM.to_toml())
    given = ["fit", str(tmp_path / "test.csv"), str(tmp_path / "beam.toml"), "--starts", "1", "--nuisances", "none"]
    assert main(given) == 0
    assert "; 5 scales with free ends; twisting" in capsys.readouterr().out
    assert main([*given, "--ends", "endless", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["ends"] == "endless"
    assert main([*given, "--ends", "loose"]) == 2
    assert "--ends" in capsys.readouterr().err


@pytest.mark.usefixtures("alone")
def test_a_search_walks_the_scales_some_tens_of_times(monkeypatch):
    counts = {}
    walk = Walked._walk

    def counted(self, v):
        counts[self.ends] = counts.get(self.ends, 0) + 1
        return walk(self, v)

    monkeypatch.setattr(joint_points.Walked, "_walk", counted)
    c = cycle()
    T = c["T"].values + np.random.default_rng(6).normal(0, 1e-4, c.phi.size)
    squama.fit({"phi": c.phi.values, "T": T}, BEAM, starts=2)
    assert counts["free"] < 60 < counts["endless"]


@pytest.mark.parametrize("ends", ["free", "gripped"])
def test_the_slope_before_engagement_is_that_of_the_ends(ends):
    beam = BEAM.replace(hold="nothing")
    c = squama.cycle(beam, WAY, points=20, ends=ends)
    specimens, names = records.read({"phi": c.phi.values, "T": c["T"].values}, beam, "twisting"), ("mu", "K_theta")
    wanted = Wanted(beam, specimens, names, "twisting", "edge", None, records.ALL, None, 1, (), ends)
    made = prepare.prepared("compliant", wanted)
    assert prepare.bar(made)[0] == pytest.approx(float(c["T"][1] / c.phi[1]), rel=1e-6)

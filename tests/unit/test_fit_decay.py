"""Parameters of a beam from the record of a decay: given back with their errors, refusals, the command."""

from __future__ import annotations

import json
import math
import re

import numpy as np
import pytest
from scipy.interpolate import CubicHermiteSpline

import squama
from squama.cli import main
from squama.dynamics import systems
from squama.identify import decay_fit, estimate, noise
from squama.loads import LOADS

BEAM = squama.Beam.from_ratios(youngs_modulus="2 MPa", mu=0.3)
GUESS = BEAM.replace(friction={"mu": 0.12})
HINGE = {"joint": "hinge", "ideal": True}
ROTOR = "0.01 kg m2"


def sampled(step=0.025, *, beam=BEAM, load="twisting", **given):
    """Return times and load angles of a motion of :func:`squama.vibrate`, at even times."""
    v = squama.vibrate(beam, load=load, **{"rotor": ROTOR, **given})
    angle = "psi" if load == "bending" else "phi"
    new = np.diff(v.t.values, prepend=-1) > 0
    t = np.arange(0, float(v.t[-1]), step)
    columns = (v[name].values[new] for name in ("t", angle, f"{angle}_speed"))
    return t, CubicHermiteSpline(*columns)(t), v


@pytest.mark.slow
def test_friction_and_damping_are_given_back_within_their_errors():
    t, y, v = sampled(release="0.15 rad/pitch", damping=0.01, swings=2, **HINGE)
    truth = {"mu": 0.3, "damping": 0.01, "f_0": float(v.f_0), "release": 0.15, "start": 0.0, "twist_zero": 0.05}
    off = []
    for seed in range(6):
        read = y + 0.05 / BEAM.pitches + np.random.default_rng(seed).normal(0, 5e-4, t.size)
        f = squama.fit_decay({"t": t, "phi": read}, BEAM, "mu, damping", **HINGE)
        # tolerance: noise of fixed seeds
        assert f.noise == pytest.approx(5e-4, rel=0.4)
        assert f.rms == pytest.approx(5e-4, rel=0.25)
        assert not f.notes
        off.append([(f.values[name] - value) / f.errors[name] for name, value in truth.items()])
    assert np.abs(off).max() < 4
    # as often as errors say: the mean square of six is 1 +- .58
    spread = np.mean(np.square(off), axis=0)
    assert (spread > 0.2).all()
    assert (spread < 3).all()


@pytest.mark.slow
def test_without_noise_all_of_it_is_exact():
    given = {"inclusion_factor": BEAM.C_f}
    both = BEAM.replace(faces="mirrored", joint=given)
    t, y, v = sampled(beam=both, release="-0.2 rad/pitch", damping=0.005, swings=2, **HINGE)
    guess = GUESS.replace(faces="mirrored", joint={**given, "stiffness": 2.0})
    f = squama.fit_decay({"t": t + 7, "phi": y}, guess, **HINGE)
    assert f.values["mu"] == pytest.approx(0.3, rel=1e-5)
    assert f.values["damping"] == pytest.approx(0.005, rel=1e-5)
    assert f.beam.joint.stiffness == f.values["K_theta"]
    again = squama.vibrate(f.beam, release="-0.2 rad/pitch", damping=0.005, swings=2, **HINGE)
    assert again.phi_turn.values == pytest.approx(v.phi_turn.values, rel=1e-5)
    assert again.t_turn.values == pytest.approx(v.t_turn.values, rel=1e-5)
    assert f.values["start"] == pytest.approx(7, abs=1e-6)


@pytest.mark.slow
def test_a_struck_beam_and_one_that_is_held_first():
    struck, y, v = sampled(impulse="0.2 N m s", swings=3, **HINGE)
    assert float(v.phi_turn[0]) > 2 * float(v.phi_e)
    f = squama.fit_decay({"t": struck, "phi": y}, GUESS, "mu", **HINGE)
    assert f.values["mu"] == pytest.approx(0.3, rel=1e-4)
    assert f.values["release"] == pytest.approx(float(v.phi_turn[0]), rel=1e-5)
    t, y, _ = sampled(release="0.15 rad/pitch", swings=2, **HINGE)
    rest = np.arange(0, 1, 0.025)
    held = {"t": np.append(rest, t + 1), "phi": np.append(np.full(rest.size, 0.15), y)}
    f = squama.fit_decay(held, GUESS, "mu", **HINGE)
    assert f.values["mu"] == pytest.approx(0.3, rel=1e-5)
    assert f.values["start"] == pytest.approx(1.0, abs=1e-5)


@pytest.mark.slow
def test_modes_of_bending_give_the_density():
    given = {"load": "bending", "mode": "cantilever", "release": "0.15 rad/pitch", "density": 1100, "rotor": None}
    given |= HINGE
    t, y, _ = sampled(2e-4, **given, swings=2)
    f = squama.fit_decay({"t": t, "psi": y}, GUESS, "mu", load="bending", mode="cantilever", **HINGE)
    assert f.values["mu"] == pytest.approx(0.3, rel=1e-4)
    assert f.beam.density == pytest.approx(1100, rel=1e-4)


@pytest.mark.slow
def test_on_compliant_joints():
    t, y, _ = sampled(release="0.15 rad/pitch", damping=0.01, swings=2)
    read = y + np.random.default_rng(3).normal(0, 3e-4, t.size)
    f = squama.fit_decay({"t": t, "phi": read}, GUESS)
    assert f.attrs["joint"] == "compliant"
    # tolerance: noise of a fixed seed, 1.2 and 1.4 errors measured
    assert f.values["mu"] == pytest.approx(0.3, abs=4 * f.errors["mu"])
    assert f.values["damping"] == pytest.approx(0.01, abs=4 * f.errors["damping"])
    assert f.errors["mu"] < 0.05
    # hinges lose more for the same friction, so they do not give back the same
    hinge = squama.fit_decay({"t": t, "phi": read}, GUESS, "mu, damping", **HINGE)
    assert abs(hinge.values["mu"] - 0.3) > 4 * f.errors["mu"]


def test_a_beam_with_a_number_of_scales_has_all_of_them():
    beam = squama.Beam.from_toml("examples/stiff_skin.toml")
    beam = beam.replace(scales=6, rotor="1e-4 kg m2", hold="bend, lateral bend")
    record = squama.vibrate(beam, release="0.1 rad/pitch", damping=0.01, swings=3)
    f = squama.fit_decay(record, beam, "damping")
    assert f.attrs["ends"] == "free"
    assert f.values["damping"] == pytest.approx(0.01, rel=1e-3)
    assert not f.notes
    endless = squama.fit_decay(record, beam, "damping", ends="endless")
    assert endless.attrs["ends"] == "endless"
    # its moment at the same twist is far larger
    assert endless.rms > 1e3 * f.rms
    assert any("the model misses something" in note for note in endless.notes)


def test_parameters_that_make_up_for_each_other_are_told():
    names, C = ("mu", "K_theta", "damping"), np.diag([4.0, 9.0, 1.0])
    assert not estimate.hardly_separable(names, C)
    C[0, 1] = C[1, 0] = -0.97 * 6
    assert estimate.hardly_separable(names, C) == [("mu", "K_theta", pytest.approx(-0.97))]


def test_below_engagement_only_the_material_is_found():
    t, y, v = sampled(release="0.02 rad/pitch", damping=0.02, swings=4, **HINGE)
    assert float(v.phi_e) > 0.02
    for how in (HINGE, {}):
        with pytest.raises(
            squama.InputError,
            match=re.escape("mu is not to be found: the record never engages"),
        ):
            squama.fit_decay({"t": t, "phi": y}, GUESS, "mu", **how)
    f = squama.fit_decay({"t": t, "phi": y}, GUESS, "damping", **HINGE)
    assert f.values["damping"] == pytest.approx(0.02, rel=1e-5)
    assert f.values["f_0"] == pytest.approx(float(v.f_0), rel=1e-6)


@pytest.mark.slow
def test_of_slow_noise_points_count_less_and_parameters_take_more_of_it(monkeypatch):
    t, y, _ = sampled(release="0.02 rad/pitch", damping=0.02, swings=4, **HINGE)
    read = y + np.random.default_rng(1).normal(0, 1e-4, t.size)
    errors, tau = [], 4.0
    for value in (1.0, tau):
        monkeypatch.setattr(noise, "dependence", lambda *_, value=value: value)
        f = squama.fit_decay({"t": t, "phi": read}, GUESS, "damping", **HINGE)
        errors.append(f.errors["damping"])
    n, p = t.size, len(f.parameters)
    assert errors[1] / errors[0] == pytest.approx(math.sqrt(tau * (n - p) / (n - tau * p)), rel=1e-9)


def test_what_is_refused():
    t, y, _ = sampled(release="0.15 rad/pitch", swings=2, **HINGE)
    record = {"t": t, "phi": y}
    with pytest.raises(squama.InputError, match=re.escape('"kappa" is not the name of a parameter')):
        squama.fit_decay(record, GUESS, "mu, kappa")
    with pytest.raises(squama.InputError, match=re.escape("theta0 is not found on the compliant joint")):
        squama.fit_decay(record, GUESS, "theta0")
    with pytest.raises(squama.InputError, match=re.escape("is a mode of bending")):
        squama.fit_decay(record, GUESS, mode="cantilever")
    with pytest.raises(squama.InputError, match=re.escape('"t" (s)')):
        squama.fit_decay({"phi": y}, GUESS)
    with pytest.raises(squama.InputError, match=re.escape("times")):
        squama.fit_decay({"t": t[:-1], "phi": y}, GUESS)
    with pytest.raises(squama.InputError, match=re.escape("point 7: the time does not grow")):
        squama.fit_decay({"t": np.where(np.arange(t.size) == 7, t[5], t), "phi": y}, GUESS)
    with pytest.raises(squama.InputError, match=re.escape("are no decay")):
        squama.fit_decay({"t": t[:10], "phi": y[:10]}, GUESS)
    with pytest.raises(squama.InputError, match=re.escape("too few turning points")):
        squama.fit_decay({"t": t, "phi": np.linspace(0, 0.1, t.size)}, GUESS)
    stiff = {"stiffness": "20 N m", "inclusion_factor": 1}
    jams = squama.Beam.from_ratios(alpha="20 deg", youngs_modulus="2 MPa", mu=0.5, **stiff)
    with pytest.raises(squama.InputError, match=re.escape("stays at")):
        squama.fit_decay({"t": t, "phi": y * 3.5}, jams, "damping", **HINGE)


def test_the_command_knows_a_decay_by_its_column_of_time(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    GUESS.to_toml("beam.toml")
    t, y, _ = sampled(release="0.15 rad/pitch", damping=0.01, swings=2, **HINGE)
    rows = [f"{1000 * s};{math.degrees(a * BEAM.pitches)}" for s, a in zip(t.tolist(), y.tolist(), strict=True)]
    (tmp_path / "decay.csv").write_text("\n".join(["time (ms);total (deg)", *rows]) + "\n", encoding="utf-8")
    flags = ["fit", "decay.csv", "beam.toml", "--find", "mu,damping", "--joint", "hinge", "--ideal"]
    assert main([*flags, "--full", "-o", "found.toml", "--csv", "found.csv", "--plot", "found.png"]) == 0
    shown = capsys.readouterr().out
    assert "a decay (time, no torque)" in shown
    assert "coefficient of friction" in shown
    found = squama.Beam.from_toml("found.toml")
    assert found.friction.mu == pytest.approx(0.3, rel=1e-5)
    assert found.rotor == pytest.approx(0.01, rel=1e-5)
    assert main([*flags, "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["parameters"]["damping"]["estimate"] == pytest.approx(0.01, rel=1e-5)
    assert len(told["points"]["phi_fit"]) == t.size
    for more, said in (
        (["--to", "0.1 rad/pitch"], "--to: is for torque and twist"),
        (["--mode", "cantilever"], "--mode"),
        (["--decimal", "x"], "decimal"),
    ):
        assert main([*flags, *more]) == 2
        told = capsys.readouterr().err
        assert said in told
        assert told.count("\n") == 1
    names = [f"{'ab'[i > 60]};{row}" for i, row in enumerate(rows)]
    (tmp_path / "two.csv").write_text("\n".join(["specimen;time (ms);total (deg)", *names]) + "\n", encoding="utf-8")
    assert main(["fit", "two.csv", *flags[2:]]) == 2
    assert "2 specimens" in capsys.readouterr().err
    (tmp_path / "test.csv").write_text("time (s), Phi (rad/m), T (N m)\n0, 0, 0\n1, 1, .1\n", encoding="utf-8")
    assert main(["fit", "test.csv", "beam.toml", "--ideal"]) == 2
    assert "are for decays" in capsys.readouterr().err


def test_the_way_back_of_compliant_joints_is_as_smooth_as_its_top():
    """The energy of the way back grows evenly with the top; it jumped by 2 % there, and no search could follow."""
    skin = squama.Beam.from_toml("examples/stiff_skin.toml").replace(scales=None)
    beam = skin.replace(joint={"stiffness": 0.0854}, hold="bend, lateral bend")
    held = systems.Model(LOADS["twisting"], 0.2152, "edge", "compliant", False)
    side = systems.sides(beam, held, "uniform", 1, 0.0923721).plus
    tops = 0.0707014 + 1e-6 * np.arange(-6, 6)
    # over the whole way, and over the part behind the point where the scales slide again
    for energy in (lambda b, y: float(b.work(y)), lambda b, y: float(b.work(y - 1e-3))):
        found = np.array([energy(side.falling(top), top) for top in tops.tolist()])
        even = np.polyval(np.polyfit(tops - tops[0], found, 1), tops - tops[0])
        assert np.abs(found - even).max() < 2e-4 * found.mean()
    # tops right behind engagement have a way back, too
    for above in (3e-7, 3e-6, 3e-5):
        assert side.falling(side.y_e + above).last == side.y_e + above


def test_derivatives_are_above_the_noise_of_the_walk():
    """Of a motion on compliant joints: central differences of two steps agree."""
    t, _, v = sampled(release="0.15 rad/pitch", damping=0.01, swings=2)
    held = systems.Model(LOADS["twisting"], 0.3, "edge", "compliant", False)
    trials = decay_fit.Trials(BEAM, held, "uniform", ("mu", "K_theta", *decay_fit.OWN))
    p = np.array([0.3, squama.twist(BEAM, points=3).attrs["K_theta"], 0.01, float(v.f_0), 0.15, 0.0, 0.0])
    sizes, limits = np.abs(p) + 0.01, (p - 1, p + 1)
    found = []
    for step in (1.0, 3.0):
        with pytest.MonkeyPatch.context() as patch:
            patch.setitem(decay_fit._STEP, "compliant", step * decay_fit._STEP["compliant"])
            found.append(trials.derivatives(p, t[:100], sizes, limits, central=True))
    apart = np.linalg.norm(found[1] - found[0], axis=0) / np.linalg.norm(found[0], axis=0)
    assert apart.max() < 0.1


@pytest.mark.slow
def test_other_starts_are_tried_while_residuals_are_above_the_noise(monkeypatch):
    t, y, _ = sampled(release="0.15 rad/pitch", damping=0.01, swings=2, **HINGE)
    read = y + np.random.default_rng(2).normal(0, 3e-4, t.size)
    true = squama.fit_decay({"t": t, "phi": read}, BEAM, "mu, damping", **HINGE)
    begun, descend = [], decay_fit._Search.descend

    def stuck(self, p, n):
        begun.append(p[0])
        found = descend(self, p, n)
        # the first start leads into another valley, which lies higher
        higher = {"p": np.append(0.6, found.p[1:]), "square": 4 * found.square}
        return found._replace(**higher) if len(begun) == 1 or p[0] == 0.6 else found

    monkeypatch.setattr(decay_fit._Search, "descend", stuck)
    found = squama.fit_decay({"t": t, "phi": read}, GUESS, "mu, damping", **HINGE)
    assert len(begun) >= 3
    assert found.values["mu"] == pytest.approx(true.values["mu"], rel=1e-5)
    assert not found.notes


@pytest.mark.slow
def test_a_search_that_does_not_end_is_not_a_model_that_misses(monkeypatch):
    t, y, _ = sampled(release="0.15 rad/pitch", damping=0.01, swings=2, **HINGE)
    record = {"t": t, "phi": y * (1 + 0.1 * np.sin(9 * t))}
    misses = squama.fit_decay(record, BEAM, "damping", **HINGE).notes
    assert any("the model misses something" in note for note in misses)
    descend = decay_fit._Search.descend
    monkeypatch.setattr(decay_fit._Search, "descend", lambda *a: descend(*a)._replace(ended=False))
    notes = squama.fit_decay(record, BEAM, "damping", **HINGE).notes
    assert any(note.startswith("the search did not come to an end") for note in notes)
    assert not any("misses" in note for note in notes)

"""A testing machine that gives, and what is known beforehand: corrections, priors, and what is said without them."""

from __future__ import annotations

import functools

import numpy as np
import pytest

import squama
from squama.cli import main
from squama.errors import InputError
from squama.identify import machine, noise
from squama.identify.hinge_points import Physical
from squama.identify.readings import Readings
from squama.loads import LOADS

BEAM = squama.Beam.from_toml("examples/pla_on_vps.toml").replace(scales=10, hold="bend, lateral bend")
TRUE = {"mu": 0.3, "K_theta": 0.75}
SHARE = 0.02
"""Part of the rotation at the top that is the machine's."""
NOISE = 5e-3


@functools.cache
def table(load="twisting", share=SHARE, softer=1.0, sigma=0.0):
    """Return readings of a loop on hinges in a machine, in even steps of the reading, and its stiffness."""
    modulus = BEAM.substrate.youngs_modulus * softer
    beam = BEAM.replace(substrate={"youngs_modulus": modulus}, friction={"mu": 0.3}, joint={"stiffness": 0.75})
    to = "0.1 rad/pitch" if load == "twisting" else "0.13 rad/pitch"
    c = squama.cycle(beam, to, load=load, joint="hinge", ideal=True, points=400)
    names = ("phi", "T") if load == "twisting" else ("psi", "M")
    x, T, leg = (c[name].values for name in (*names, "leg"))
    compliance = share * BEAM.scales * x.max() / T.max()
    rows = []
    for number in (1, 2):
        m, torque = (x + compliance * T / BEAM.scales)[leg == number], T[leg == number]
        order = np.argsort(m)
        wanted = np.linspace(0, m.max(), 120)[:: 3 - 2 * number]
        rows.append((wanted, np.interp(wanted, m[order], torque[order])))
    m, torque = np.concatenate(rows, axis=1)
    torque = torque + np.random.default_rng(3).normal(0, sigma, torque.size) * (sigma > 0)
    return dict(zip(names, (m, torque), strict=True)), 1 / compliance if share else np.inf


def fitted(data, find=("mu", "K_theta"), **given):
    given = {"joint": "hinge", "nuisances": "none", "starts": 1, **given}
    return squama.fit(data, BEAM, find, **given)


def off(fit):
    return {name: fit.values[name] / true - 1 for name, true in TRUE.items()}


def test_a_reading_without_the_part_of_the_machine():
    """By hand: 10 scales, a machine of 4 N m/rad, corrected for one of 8 N m/rad."""
    load, torque = np.array([0.0, 1.0, 2.0, 1.0]), np.array([0.0, 4.0, 16.0, 2.0])
    readings = Readings.of(load, np.array([1, 1, 1, -1]), np.zeros(4, int), 10, torque, 0.125)
    np.testing.assert_allclose(readings.placed(0.0, 0.0, 0.25)[0], [0, 0.95, 1.8, 0.975])
    np.testing.assert_allclose(readings.placed(0.0, 0.0, 0.125)[0], load)


def test_a_torque_without_its_noise():
    x = np.concatenate([np.linspace(0, 1, 60), np.linspace(1, 0, 60)])
    y = np.where(np.arange(x.size) < 60, 3 * x, 1 - 2 * x)
    np.testing.assert_allclose(noise.smooth(x, y, [59]), y, atol=1e-12)
    loud = y + np.random.default_rng(2).normal(0, 0.1, x.size)
    # seven points of a line: a seventh of the variance, more at both ends of a way
    assert np.std(noise.smooth(x, loud, [59]) - y) < 0.5 * 0.1
    assert noise.smooth(x[:5], loud[:5], []).tolist() == loud[:5].tolist()


@pytest.mark.parametrize("load", ["twisting", pytest.param("bending", marks=pytest.mark.slow)])
def test_a_machine_that_is_given_is_corrected_for_and_one_that_is_not_is_told(load):
    share = 5e-3
    data, k = table(load, share)
    # tolerance: the table is read between 400 points of a curve, behind the drop at its top too
    found = fitted(data, load=load, machine=f"{k} N m/rad")
    assert max(map(abs, off(found).values())) < 3e-3
    assert found.machine is None
    without = fitted(data, load=load)
    assert off(without)["K_theta"] < -8e-3
    # what is said that it would change is what it does change
    change = dict(zip(without.parameters, without.machine.changes * share / 0.01, strict=True))
    for name, true in TRUE.items():
        assert change[name] == pytest.approx(true - without.values[name], rel=0.2, abs=3e-3 * true), name
    assert without.machine.told
    assert without.machine.stiffness == pytest.approx(k * share / 0.01, rel=0.05)
    assert "machine not given" in without.summary()


@pytest.mark.slow
def test_a_machine_with_a_tolerance_is_found_from_it_and_from_the_points():
    data, k = table(sigma=NOISE)
    for middle in (0.85, 1.2):
        found = fitted(data, machine=f"{middle * k} +- {0.4 * k} N m/rad")
        assert found.parameters == ("mu", "K_theta", "compliance")
        for name, true in {**TRUE, "compliance": 1 / k}.items():
            assert abs(found.values[name] - true) < 3 * found.errors[name], name
        assert found.errors["compliance"] < 0.2 / k
        assert found.holds
    known = fitted(data, machine=f"{k} N m/rad")
    assert found.errors["K_theta"] > 1.2 * known.errors["K_theta"]
    # where the tolerance leaves nothing open it is the machine that is given
    narrow = fitted(data, machine=f"{k} +- {1e-4 * k} N m/rad")
    for name in TRUE:
        assert narrow.values[name] == pytest.approx(known.values[name], rel=1e-3)
        assert narrow.errors[name] == pytest.approx(known.errors[name], rel=0.05)
    wrong = fitted(data, machine=f"{3 * k} +- {k} N m/rad")
    assert any("the points alone give compliance above the given value" in doubt for doubt in wrong.doubts)


@pytest.mark.slow
def test_a_modulus_and_its_tolerance_are_both_used():
    data, _ = table(share=0.0, softer=0.9, sigma=NOISE)
    E, find, given = BEAM.substrate.youngs_modulus, ("mu", "K_theta", "E_B"), {"machine": "rigid", "noise": NOISE}
    free = fitted(data, find, **given)
    assert abs(free.values["E_B"] / (0.9 * E) - 1) < 3 * free.errors["E_B"] / E
    s = free.errors["E_B"]
    both = fitted(data, **given, tolerances={"E_B": f"{E + s} +- {2 * s} Pa 1 sd"})
    # two observations of one quantity: precisions add up, the mean is weighed by them
    assert both.parameters == find
    assert both.errors["E_B"] == pytest.approx(s / np.sqrt(1 + 1 / 4), rel=2e-2)
    assert both.values["E_B"] - free.values["E_B"] == pytest.approx(0.2 * (E + s - free.values["E_B"]), rel=5e-2)
    by_file = fitted(data, **given, tolerances={"substrate.youngs_modulus": ("normal", E + s, 2 * s)})
    assert by_file.values == both.values
    far = fitted(data, **given, tolerances={"E_B": ("normal", E + 8 * s, 2 * s)})
    (doubt,) = (d for d in far.doubts if "the given value" in d)
    assert doubt.startswith("the points alone give E_B below the given value")
    assert not fitted(data, **given, tolerances={"E_B": ("normal", E, s / 10)}).holds


@pytest.mark.slow
def test_a_slope_that_is_too_low_is_a_bar_or_a_machine():
    data, _ = table(share=0.0, softer=0.85, sigma=NOISE / 10)
    fit = fitted(data)
    (doubt,) = (d for d in fit.doubts if "slope before engagement" in d)
    assert "15 % softer" in doubt
    assert "or the machine gives in" in doubt
    assert "the slope alone cannot tell which" in doubt
    assert "machine gives" not in fitted(data, machine="rigid").summary()
    # the compliance in series that would have the same slope, by hand
    R = LOADS["twisting"].rigidity(BEAM) / (BEAM.scales * BEAM.pitch)
    slope = fit.slope
    assert 1 / (1 / R + slope.gives) == pytest.approx(slope.ratio * R, rel=1e-9)
    assert "E_B = 1.2" in slope.sentence


@pytest.mark.slow(but=1)
@pytest.mark.parametrize("load", ["twisting", "bending"])
def test_the_derivative_by_the_compliance_is_that_of_the_torque(load):
    data, k = table(load)
    fit = fitted(data, load=load, machine=f"{k} N m/rad")
    points, v, place = fit.points, fit.asked.physical(fit.estimates), Physical._fields.index("compliance")
    column = points.jacobian(v, np.arange(len(v)) == place)[:, place]
    h = 1e-4 / k
    up, down = (points.torque(v._replace(compliance=v.compliance + s * h)) for s in (1, -1))
    inside = np.flatnonzero(fit.used)[1:-1]
    expected, atol = (up - down) / (2 * h), 1e-3 * np.abs(column).max()
    np.testing.assert_allclose(column[inside], expected[inside], rtol=1e-2, atol=atol)
    assert column[fit.branch == "loading"].max() < 0


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ("-2 N m/rad", "out of range"),
        ("2 mm", "is a length"),
        ("2 +- 3 N m/rad", "too wide"),
        ("2 +- 0 N m/rad", "must be more than 0"),
        ("soft", '"2 N m/rad"'),
    ],
)
def test_machines_that_are_none(given, words):
    with pytest.raises(InputError, match="machine") as error:
        machine.read(given, LOADS["twisting"])
    assert words in str(error.value)


@pytest.mark.slow
def test_the_command(tmp_path, capsys):
    data, k = table(sigma=NOISE)
    rows = "\n".join(f"{x:.9g},{t:.6g}" for x, t in zip(*data.values(), strict=True))
    (tmp_path / "test.csv").write_text(f"phi (rad),T (N m)\n{rows}\n")
    (tmp_path / "beam.toml").write_text(BEAM.to_toml())
    (tmp_path / "known.toml").write_text('[tolerance]\nfriction.mu = "0.3 +- 0.1 sd"\n')
    files = [str(tmp_path / name) for name in ("test.csv", "beam.toml")]
    how = ["--joint", "hinge", "--nuisances", "none", "--starts", "1"]
    known = ["--tolerances", str(tmp_path / "known.toml"), "--prior", "E_B=1.5 MPa +- 5 %"]
    assert main(["fit", *files, *how, "--machine", f"{k} +- {0.2 * k} N m/rad", *known]) == 0
    said = capsys.readouterr().out
    for name in ("mu", "K_theta", "E_B", "compliance"):
        assert f" {name} = " in said.splitlines()[0]
    assert main(["fit", *files, *how, "--machine", "2"]) == 2
    assert 'has no unit; write e.g. "2 N m/rad"' in capsys.readouterr().err
    assert main(["fit", *files, *how, "--prior", "joint.factor=1 +- 5 %"]) == 2
    assert "--prior joint.factor: is no parameter of a fit; give a tolerance of K_theta" in capsys.readouterr().err

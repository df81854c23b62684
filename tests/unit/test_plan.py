"""The plan of a test: expected errors against differences of curves, against fits of noisy loops, and in words."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest

import squama
from campaigns.plans import torque
from squama.cli import main
from squama.errors import InputError

HINGED = squama.Beam.from_ratios(youngs_modulus="2 MPa", mu=0.3)
SKIN = squama.Beam.from_toml("examples/stiff_skin.toml").replace(scales=None, hold="bend, lateral bend")
NOISE = 2e-3
STEP = 1e-3


def _torque(beam, joint, x):
    """Torques at twists (rad per pitch) there and back, by a fine history of the beam."""
    return torque(beam, x, joint, points=6000)


def _loop(top, n=100):
    half = np.linspace(0, top, n // 2 + 1)
    return np.concatenate([half[1:], half[:-1][::-1]])


def _moved(beam, name, by):
    changes = {
        "mu": {"friction": {"mu": beam.friction.mu * (1 + by)}},
        "K_theta": {"joint": {"stiffness": beam.joint_stiffness * (1 + by)}},
        "E_B": {
            "substrate": {"youngs_modulus": beam.substrate.youngs_modulus * (1 + by)},
            "joint": {"stiffness": beam.joint_stiffness},
        },
    }
    return beam.replace(**changes[name])


def _read_by_machine(beam, reading, top, compliance):
    """Torques at readings m = x + c T of the way there and of that back, in halves; the specimen goes past the top."""
    dense = np.concatenate([np.linspace(0, 1.02 * top, 4000), np.linspace(1.02 * top, 0, 4001)[1:]])
    T = _torque(beam, "hinge", dense)
    m, half = dense + compliance * T / beam.pitches, reading.size // 2
    up = np.interp(reading[:half], m[:4000], T[:4000])
    return np.concatenate([up, np.interp(reading[half:], m[4000:][::-1], T[4000:][::-1])])


def _differences(names, torque):
    """Covariance of relative estimates from central differences, noise of 1; ``torque`` of a beam."""
    ends = [[torque(_moved(HINGED, name, s * STEP)) for s in (1, -1)] for name in names]
    return np.column_stack([(up - down) / (2 * STEP) for up, down in ends])


def test_errors_are_those_of_differences_of_the_curves():
    names, top = ("mu", "K_theta", "E_B"), 0.2
    x = _loop(top)
    J = _differences(names, lambda beam: _torque(beam, "hinge", x))
    want = NOISE * np.sqrt(np.diag(np.linalg.inv(J.T @ J)))
    found = squama.plan(HINGED, names, noise=NOISE, tops=[f"{top} rad/pitch"], joint="hinge")
    one = next(c for c in found.candidates if c.shape == "loop")
    assert one.readings == x.size
    # tolerance: interpolation between 6000 points of a way
    assert one.shares == pytest.approx(want, rel=1e-3)
    # noise of the twist, by the slope at each reading
    slope = np.concatenate(
        [np.gradient(_torque(HINGED, "hinge", x)[:50], x[:50]), np.gradient(_torque(HINGED, "hinge", x)[50:], x[50:])]
    )
    t = math.radians(0.3)
    spread = np.hypot(NOISE, slope * t / HINGED.pitches)
    half = np.linalg.inv(J.T @ J) @ (J * spread[:, None]).T
    found = squama.plan(
        HINGED, names, noise=NOISE, twist_noise="0.3 deg total", tops=[f"{top} rad/pitch"], joint="hinge"
    )
    one = next(c for c in found.candidates if c.shape == "loop")
    assert one.shares == pytest.approx(np.sqrt(np.diag(half @ half.T)), rel=0.02)


def test_a_machine_that_gives():
    names, top, c = ("mu", "K_theta"), 0.2, 1 / 20
    x = _loop(top)
    reading = x + c * _torque(HINGED, "hinge", x) / HINGED.pitches
    J = _differences(names, lambda beam: _read_by_machine(beam, reading, top, c))
    ends = [_read_by_machine(HINGED, reading, top, c * (1 + s * STEP)) for s in (1, -1)]
    more = np.column_stack([J, (ends[0] - ends[1]) / (2 * STEP)])
    known, free = (NOISE * np.sqrt(np.diag(np.linalg.inv(A.T @ A)))[:2] for A in (J, more))
    found = squama.plan(HINGED, names, noise=NOISE, machine="20 N m/rad", tops=[f"{top} rad/pitch"], joint="hinge")
    assert found.best.shape == "loop"
    # tolerance: interpolation between 6000 points of a way
    assert found.best.shares == pytest.approx(known, rel=1e-3)
    one = next(more for words, more in found.free if "compliance" in words)
    assert one.shares == pytest.approx(free, rel=1e-3)
    rigid = squama.plan(HINGED, names, noise=NOISE, tops=[f"{top} rad/pitch"], joint="hinge").best
    assert (known > 1.05 * rigid.shares).all()


@pytest.mark.slow
@pytest.mark.usefixtures("alone")
@pytest.mark.parametrize(
    ("beam", "joint", "noise", "names", "seeds"),
    [(HINGED, "hinge", 2e-3, ("mu", "K_theta"), 60), (SKIN, "compliant", 5e-5, ("mu", "K_theta", "E_B"), 12)],
)
def test_fits_of_noisy_loops_scatter_as_expected(beam, joint, noise, names, seeds):
    found = squama.plan(beam, names, noise=noise, joint=joint, ends=None if joint == "hinge" else "endless")
    one = [c for c in found.candidates if c.shape == "loop" and not c.problem][1]
    x = _loop(one.top, one.readings)
    T, apart = _torque(beam, joint, x), []
    for seed in range(seeds):
        loop = {"phi": x, "T": T + np.random.default_rng(seed).normal(0, noise, x.size)}
        fit = squama.fit(loop, beam, names, joint=joint, nuisances="none", starts=1, noise=noise)
        apart.append((fit.estimates - one.values) / one.errors)
    # 99.9 % of the chi-square distribution
    from scipy.stats import chi2

    square = (np.array(apart) ** 2).sum(axis=0)
    assert (square > chi2.ppf(5e-4, seeds)).all(), square
    assert (square < chi2.ppf(1 - 5e-4, seeds)).all(), square


def test_what_is_best_and_how_often():
    found = squama.plan(HINGED, noise="5 N mm", joint="hinge", accuracy="1 %")
    good = [c for c in found.candidates if not c.problem]
    assert found.best.worst == min(c.worst for c in good)
    for one in good:
        number = found.loops(one)
        if number is None:
            assert one.worst / math.sqrt(20) > 0.01
        else:
            assert one.worst / math.sqrt(number) <= 0.01 * (1 + 1e-9)
            assert number == 1 or one.worst / math.sqrt(number - 1) > 0.01
    loading, loop = (next(c for c in good if c.shape == shape) for shape in ("loading", "loop"))
    assert loading.worst > 5 * loop.worst
    assert abs(loading.correlation[0, 1]) > 0.99
    assert any("mu, K_theta are hardly told apart" in note for note in found.notes())
    twice = squama.plan(HINGED, noise="10 N mm", joint="hinge").best
    assert twice.errors == pytest.approx(2 * found.best.errors, rel=1e-9)
    more = squama.plan(HINGED, noise="5 N mm", joint="hinge", points=400).best
    assert more.errors == pytest.approx(found.best.errors / 2, rel=0.05)


def test_the_dataset_and_the_picture():
    found = squama.plan(HINGED, ("mu", "K_theta"), noise="5 N mm", joint="hinge", to="0.12 rad/pitch")
    data = found.dataset()
    assert float(data.top.max()) == pytest.approx(0.12)
    assert data["error_mu"].values.min() == pytest.approx(min(c.errors[0] for c in found.candidates))
    assert data["correlation"].dims == ("candidate", "parameter", "other")
    figure = found.plot()
    assert [len(ax.lines) for ax in figure.axes] == [4, 4]
    with pytest.raises(InputError, match='"E_B": is not the name of a parameter of the plan'):
        squama.plot.expected_errors(data, "E_B")


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"noise": 0}, "noise = 0 N m: is out of range"),
        ({"noise": "5 deg"}, "noise = "),
        ({"machine": "5 N"}, "machine = "),
        ({"machine": "0 N m/rad"}, "machine = "),
        ({"accuracy": 2}, "accuracy = 2: is out of range (1e-4 to 1)"),
        ({"points": 3}, "points = 3"),
        ({"parameters": ("mu", "K")}, '"K" is not the name of a parameter; write K_theta'),
        ({"parameters": ("E_B", "C_f", "K_theta")}, "no test tells them apart"),
        ({"to": "0.01 rad/pitch"}, "no loop of the plan can be followed: "),
        ({"tops": ["5 mm"]}, "tops[0] = "),
        ({"tops": [f"{0.1 + 0.001 * i} rad/pitch" for i in range(30)]}, "tops: 30 are too many"),
        ({"load": "shear"}, "load = "),
    ],
)
def test_what_cannot_be_planned(given, words):
    with pytest.raises(InputError) as caught:
        squama.plan(HINGED, **{"noise": "5 N mm", "joint": "hinge", **given})
    assert words in str(caught.value).splitlines()[0]


def test_the_command(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "beam.toml").write_text(HINGED.to_toml())
    asked = ["plan", "beam.toml", "--joint", "hinge", "--find", "mu,K_theta"]
    noisy = [*asked, "--noise", "5 N mm"]
    assert main([*noisy, "--csv", "a.csv", "--plot", "a.svg", "--tops", "150, 220 deg total", "--full"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].startswith(
        "beam.toml: Twist an endless beam to 8.8 deg per pitch and back, once (100 readings each time): mu to +-"
    )
    assert sum(" 8.8 " in line and "N" in line for line in lines[1:]) == 3
    assert squama.read("a.csv").sizes["candidate"] == 6
    assert main([*noisy, "--json", "--load", "bending"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["find"] == ["mu", "K_theta"]
    assert found["best"]["errors"]["mu"] > 0
    assert {one["loop"] for one in found["candidates"]} == {"loading", "loop"}
    for more, words in (
        ([], '--noise: is not given; say how exact the load cell is, e.g. --noise "0.2 N mm"'),
        (["--noise", "5"], "--noise = 5: has no unit"),
        (["--noise", "5 N mm", "--tops", "9"], "--tops"),
        (["--noise", "5 N mm", "--machine", "2"], "--machine = 2: has no unit"),
        (["--noise", "5 N mm", "--to", "1 mm"], "--to"),
    ):
        assert main([*asked, *more]) == 2
        (line,) = capsys.readouterr().err.splitlines()
        assert words in line

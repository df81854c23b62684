"""Fits: what is found from curves that the fit's own evaluator did not make, errors, separability, specimens."""

from __future__ import annotations

import functools
import math

import numpy as np
import pytest

import squama
from oracle import bending as oracle_bending
from oracle.twisting import forces, phi
from oracle.vectors import FP, MP, Design
from squama.identify.estimate import derivatives
from squama.identify.prepare import placed
from squama.identify.records import read, record
from squama.identify.unknowns import PARAMETERS, ask

pytestmark = pytest.mark.usefixtures("alone")
hinged = functools.partial(squama.fit, joint="hinge")
BEAM = squama.Beam.from_ratios(youngs_modulus="2 MPa", mu=0.3)
TRUE = {"mu": 0.3, "K_theta": BEAM.joint_stiffness, "C_f": BEAM.C_f, "E_B": 2e6, "theta0": BEAM.scale.theta0}
OFF = {"mu": 0.12, "K_theta": 0.6, "C_f": 1.3, "E_B": 0.7, "theta0": 1.15}
"""Start values over the true ones (mu: the value), by name."""
FOLDED = squama.Beam.from_ratios(
    eta=2.94, beta=0.83, lam=1.48, alpha="8.4 deg", theta0="12.7 deg", zeta=0.05, youngs_modulus="2 MPa", mu=0.2
)
HISTORY = "0, 0.2, 0.02, 0.18, 0.1, 0.21, 0 rad/pitch"
RNG = np.random.default_rng


def moved(beam, names):
    """A beam whose values are not the true ones."""
    changes = {}
    for n in names:
        row = PARAMETERS[n]
        value = row.value(beam, "twisting")
        table, _, key = row.place.partition(".")
        changes.setdefault(table, {})[key] = OFF[n] if n == "mu" else OFF[n] * value
    return beam.replace(**changes)


def noisy(dataset, sigma, seed=1, torque="T"):
    key = "phi" if torque == "T" else "psi"
    values = dataset[torque].values
    return {key: dataset[key].values, torque: values + RNG(seed).normal(0, sigma * np.abs(values).max(), values.size)}


@pytest.mark.parametrize("law", ["edge", "plate"])
@pytest.mark.parametrize(
    "names",
    [("mu",), ("mu", "K_theta"), ("mu", "K_theta", "C_f"), ("mu", "K_theta", "E_B", "theta0"), ("theta0", "mu")],
)
def test_a_cycle_gives_its_parameters_back(law, names):
    data = squama.cycle(BEAM, HISTORY, law=law, joint="hinge")
    fit = hinged(data, moved(BEAM, names), names, law=law)
    for name in names:
        assert fit.values[name] == pytest.approx(TRUE[name], rel=1e-9), name
    known = set(fit.branch)
    assert known == {"straight", "loading", "unloading", "stick"}
    # the fit's own labels are those of the cycle, but for the very point of engagement
    same = fit.branch == data.branch.values
    at_engagement = np.abs(data.phi.values - float(data.phi_e[0])) < 1e-9
    assert (same | at_engagement | (data.branch.values == "straight")).all()
    assert squama.twist(fit.beam, points=3, law=law, joint="hinge").phi_e.item() == pytest.approx(float(data.phi_e[0]))


@pytest.mark.parametrize("law", ["edge", "plate"])
def test_twist_gives_its_parameters_back(law):
    data = squama.twist(BEAM, law=law, to="0.25 rad/pitch", joint="hinge")
    fit = hinged(data, moved(BEAM, ("mu", "K_theta")), law=law)
    assert fit.values["mu"] == pytest.approx(0.3, rel=1e-9)
    assert fit.values["K_theta"] == pytest.approx(TRUE["K_theta"], rel=1e-9)


def test_bending_and_a_folded_path_and_the_other_sense():
    data = squama.cycle(BEAM, "0, 0.25, 0.1, 0.28, -0.05, 0 rad/pitch", load="bending", joint="hinge")
    start = BEAM.replace(friction={"mu": 0.1}, joint={"stiffness": 0.01, "inclusion_factor": 1.2})
    fit = hinged(data, start, ("mu", "K_theta", "C_f"), load="bending")
    assert fit.values == pytest.approx({"mu": 0.3, "K_theta": BEAM.joint_stiffness, "C_f": 1.0}, rel=1e-8)
    # this path passes a fold on the way
    most = float(squama.cycle(FOLDED, 0.01, joint="hinge").phi_most[0])
    data = squama.cycle(FOLDED, [0, 0.98 * most / FOLDED.pitch, 0], joint="hinge")
    fall = data.theta.values[data.branch.values == "loading"]
    assert (np.diff(fall) < 0).any()
    fit = hinged(data, moved(FOLDED, ("mu", "K_theta", "theta0")), ("mu", "K_theta", "theta0"))
    assert fit.values["mu"] == pytest.approx(0.2, rel=1e-7)
    assert fit.values["theta0"] == pytest.approx(FOLDED.scale.theta0, rel=1e-7)


def test_the_other_sense_of_twist(monkeypatch):
    monkeypatch.setattr("squama.arrays.solution.touch", lambda *_, **__: None)
    both = squama.Beam.from_ratios(
        eta=1.0683, beta=0.80579, lam=1.034, alpha=0.15793, theta0=0.11, zeta=0.02, mu=0.2, youngs_modulus="2 MPa"
    )
    data = squama.cycle(both, "0, 0.3, -0.3, 0 rad/pitch", joint="hinge")
    fit = hinged(data, both.replace(friction={"mu": 0.5}))
    assert fit.values["mu"] == pytest.approx(0.2, rel=1e-9)
    assert set(fit.branch[fit.record.load < 0]) == {"straight", "loading", "unloading", "stick"}


@pytest.mark.parametrize("law", ["edge", "plate"])
def test_torques_from_force_vectors(law):
    """Against contact forces as vectors; the plate law's torque is that of its energy (docs, theory: forces)."""
    design = Design.of(3, 45, 1.25, 0.45, 10).floats()
    R, K, d = BEAM.torsional_rigidity, BEAM.joint_stiffness, BEAM.pitch
    theta = np.linspace(design.theta0 + 0.01, 0.95, 25).tolist()
    load = [float(phi(t, Design.of(3, 45, 1.25, 0.45, 10))) for t in theta]
    torque = [[], []]
    for way, out in zip((1, -1), torque, strict=True):
        for t, q in zip(theta, load, strict=True):
            f = forces(t, q, design, law, way * 0.3, FP)
            out.append(R * q / d + K * float(f.torque_direct if law == "edge" else f.torque_energy))
    straight, load = np.linspace(0, 0.02, 5), np.array(load)
    data = {
        "phi": np.concatenate([straight, load, load[::-1]]),
        "T": np.concatenate([R * straight / d, torque[0], torque[1][::-1]]),
    }
    fit = hinged(data, moved(BEAM, ("mu", "K_theta", "theta0")), ("mu", "K_theta", "theta0"), law=law)
    assert fit.values["mu"] == pytest.approx(0.3, rel=1e-9)
    assert fit.values["K_theta"] == pytest.approx(K, rel=1e-9)
    assert fit.values["theta0"] == pytest.approx(design.theta0, rel=1e-9)


@pytest.mark.parametrize("load", ["twisting", "bending"])
def test_derivatives_against_central_differences(load):
    data = squama.cycle(
        BEAM, HISTORY if load == "twisting" else "0, 0.25, 0.1, 0.28, 0 rad/pitch", load=load, joint="hinge"
    )
    for names in (
        ("mu", "K_theta", "C_f", "theta0", "torque_zero", "twist_zero", "backlash", "drift"),
        ("mu", "E_B", "C_f"),
        ("E_B", "K_theta"),
    ):
        asked = ask(BEAM, load, names)
        points = placed(record(read(data, BEAM, load), BEAM), asked, "edge")
        p = np.array([TRUE.get(n, 0.01) for n in names]) * 1.07
        for mu in (1.0, 3.0, 40.0):
            # forty times the friction is far beyond the lock: the continuation has its derivatives too
            q = p.copy()
            if "mu" in names:
                q[0] *= mu
            J = derivatives(points.points, asked, q)
            for i in range(len(names)):
                h = 1e-5 * np.abs(q[i])
                up, down = (points.points.torque(asked.physical(q + s * h * np.eye(len(q))[i])) for s in (1, -1))
                difference = (up - down) / (2 * h)
                # where the two sides are not both in contact there is a kink
                smooth = np.abs(points.points.at(asked.physical(q)).theta - asked.physical(q).theta0) > 1e-4
                rounding = 1e-14 * np.abs(up).max() / h
                np.testing.assert_allclose(J[smooth, i], difference[smooth], rtol=1e-4, atol=rounding)


def test_before_engagement_it_is_the_linear_regression():
    rate = np.linspace(0, 2.2, 40)
    torque = 1.4 / BEAM.C_f * BEAM.torsional_rigidity * rate + RNG(3).normal(0, 0.02, rate.size) + 0.05
    fit = hinged({"Phi": rate, "T": torque}, BEAM, ("C_f", "torque_zero"))
    A = np.stack([BEAM.torsional_rigidity / BEAM.C_f * rate, np.ones(rate.size)], axis=1)
    expected, square, *_ = np.linalg.lstsq(A, torque, rcond=None)
    covariance = float(square[0]) / (rate.size - 2) * np.linalg.inv(A.T @ A)
    np.testing.assert_allclose(fit.estimates, expected, rtol=1e-9)
    np.testing.assert_allclose(fit.covariance, covariance, rtol=1e-8)
    assert fit.noise == pytest.approx(math.sqrt(float(square[0]) / (rate.size - 2)))
    assert fit.rms == pytest.approx(math.sqrt(float(square[0]) / rate.size))
    np.testing.assert_allclose(fit.band, np.sqrt(np.diag(A @ covariance @ A.T)), rtol=1e-7)
    np.testing.assert_allclose(fit.residuals, torque - A @ expected, rtol=1e-7, atol=1e-12)
    given = hinged({"Phi": rate, "T": torque}, BEAM, ("C_f", "torque_zero"), noise="50 N mm")
    np.testing.assert_allclose(given.covariance, 0.05**2 * np.linalg.inv(A.T @ A), rtol=1e-8)
    assert fit.condition == pytest.approx(np.linalg.cond(A / np.linalg.norm(A, axis=0)))


@pytest.mark.slow
def test_the_search_does_not_depend_on_the_start():
    data = noisy(squama.cycle(BEAM, HISTORY, joint="hinge"), 0.02)
    names = ("mu", "K_theta", "theta0")
    found = [hinged(data, BEAM.replace(friction={"mu": mu}), names, starts=1).estimates for mu in (0, 0.05, 1, 4)]
    np.testing.assert_allclose(found, np.broadcast_to(found[0], (4, 3)), rtol=1e-6)
    fit = hinged(data, BEAM, names, starts=8)
    assert fit.starts[1] == 8
    # bounds where none are given: a third and three times of an inclination
    np.testing.assert_allclose([fit.asked.low[2], fit.asked.high[2]], [BEAM.scale.theta0 / 3, BEAM.scale.theta0 * 3])
    free = hinged(data, BEAM, names, bounds={"theta0": (None, "11 deg")})
    np.testing.assert_allclose([free.asked.low[2], free.asked.high[2]], [BEAM.scale.theta0 / 3, np.radians(11)])


def test_near_a_lock():
    """The farthest point is within a thousandth of the lock; starts beyond it come back."""
    end = float(squama.twist(BEAM, points=3, joint="hinge").phi_end)
    data = squama.twist(BEAM, at=np.linspace(0, 0.999 * end, 150) / BEAM.pitch, joint="hinge")
    fit = hinged(data, BEAM.replace(friction={"mu": 2.0}))
    assert fit.values["mu"] == pytest.approx(0.3, rel=1e-9)
    asked = ask(BEAM, "twisting", ("mu",))
    forward = placed(record(read(data, BEAM, "twisting"), BEAM), asked, "edge").points
    lock = forward.locks_at(asked.physical(asked.start))
    trials = np.linspace(0, 3 * lock, 400)
    peak = np.array([forward.torque(asked.physical(np.array([m]))).max() for m in trials])
    assert np.isfinite(peak).all()
    assert (np.diff(peak) > 0).all()


def test_loading_alone_does_not_separate_and_unloading_does():
    up = squama.cycle(BEAM, [0, 0.2 / BEAM.pitch], joint="hinge")
    loop = squama.cycle(BEAM, "0.2 rad/pitch", joint="hinge")
    alone = hinged(noisy(up, 0.02), BEAM, noise=1.0, nuisances="none")
    assert alone.correlation[0, 1] < -0.95
    said = "\n".join(alone.notes)
    assert "mu and K_theta are hardly separable" in said
    assert "would help: unloading measured too" in said
    both = hinged(noisy(loop, 0.02), BEAM, noise=1.0, nuisances="none")
    assert abs(both.correlation[0, 1]) < 0.9
    assert "separable" not in "\n".join(both.notes)
    # what was foretold is what the closed loop gives
    foretold = next(r for r in alone.remedies if r.what.startswith("unloading"))
    # tolerance: errors of another noise, 5 % measured; seeds are fixed
    np.testing.assert_allclose(foretold.errors, list(both.errors.values()), rtol=0.1)
    assert both.errors["mu"] < alone.errors["mu"] / 2


def test_points_are_proposed_where_there_are_few():
    def proposed(loop, keep):
        at = np.flatnonzero(keep)
        fit = hinged({"phi": loop.phi.values[at], "T": loop["T"].values[at]}, BEAM, noise=0.1)
        return {what for r in fit.remedies for what in ("before engagement", "more of loading") if what in r.what}

    far = float(squama.twist(BEAM, points=3, joint="hinge").phi_end)
    some, whole = (squama.cycle(BEAM, f"{to} rad/pitch", points=80, joint="hinge") for to in (0.15, 0.995 * far))
    assert proposed(some, some.phi > 0) == {"more of loading"}
    # none before engagement, and a few
    for start in (0.06, 0.045):
        assert proposed(some, some.phi > start) == {"before engagement", "more of loading"}
    assert proposed(whole, whole.phi > 0.06) == {"before engagement"}


def test_further_loading_is_proposed_in_the_first_sense_where_both_were_measured(monkeypatch):
    monkeypatch.setattr("squama.arrays.solution.touch", lambda *_, **__: None)
    beam = squama.Beam.from_ratios(eta=1.0683, beta=0.80579, lam=1.034, alpha=0.15793, theta0=0.11, zeta=0.02, mu=0.2)
    said = {}
    for senses, history in (("+", "0, 0.3"), ("-", "0, -0.3"), ("both", "0, 0.3, -0.3")):
        loop = squama.cycle(beam, f"{history}, 0 rad/pitch", joint="hinge")
        fit = hinged({"phi": loop.phi.values, "T": loop["T"].values}, beam, noise=0.1)
        said[senses] = next(r.what for r in fit.remedies if "more of loading" in r.what).partition(" points")[2]
    assert said["+"] == said["both"] != said["-"]


def test_a_bending_test_as_foretold():
    """The foretold errors are those of both tests fitted together, by a Jacobian of finite differences."""
    up = squama.cycle(BEAM, [0, 0.2 / BEAM.pitch], joint="hinge")
    beam = BEAM.replace(joint={"stiffness": BEAM.joint_stiffness})
    fit = hinged({"phi": up.phi.values, "T": up["T"].values}, beam, noise=0.1)
    remedy = next(r for r in fit.remedies if r.what.startswith("a bending test"))
    n = int(remedy.what.split()[4])
    last = np.radians(float(remedy.what.split()[-4]))

    def both(mu, K, at):
        b = beam.replace(joint={"stiffness": K})
        t = squama.twist(b, mu=mu, at=up.Phi.values, joint="hinge")["T"].values
        return t, squama.bend(b, mu=mu, at=at, joint="hinge")["M"].values

    psi_e = float(squama.bend(beam, mu=0.3, points=3, joint="hinge").psi_e)
    at = np.linspace(psi_e, last, n) / beam.pitch
    t, m = both(0.3, beam.joint_stiffness, at)
    weight = t.max() / m.max()
    columns = []
    for i, p in enumerate((0.3, beam.joint_stiffness)):
        h = 1e-5 * p
        lo, hi = ([0.3, beam.joint_stiffness] for _ in range(2))
        lo[i], hi[i] = p - h, p + h
        (t0, m0), (t1, m1) = both(*lo, at), both(*hi, at)
        columns.append(np.concatenate([t1 - t0, weight * (m1 - m0)]) / (2 * h))
    J = np.stack(columns, axis=1)
    # tolerance: differences and weights of the forecast, 0.2 % measured, on every processor
    np.testing.assert_allclose(remedy.errors, 0.1 * np.sqrt(np.diag(np.linalg.inv(J.T @ J))), rtol=5e-3)


@pytest.mark.slow
def test_what_is_said_about_a_fit():
    loop = squama.cycle(BEAM, "0.2 rad/pitch", joint="hinge")
    quiet = hinged(noisy(loop, 0.005), BEAM, nuisances="none")
    assert quiet.notes == ()
    wrong = hinged(loop, BEAM.replace(scale={"theta0": "12 deg"}))
    assert "residuals are not noise alone" in wrong.doubts[0]
    loud = hinged(noisy(loop, 0.05), BEAM, noise="1 N mm")
    assert any("larger than the noise that is given" in doubt for doubt in loud.doubts)
    slippery = hinged(noisy(loop, 0.001), BEAM, bounds={"mu": (0.4, 1)})
    assert any("mu is at its bound 0.4" in note for note in slippery.notes)
    few = hinged(noisy(squama.cycle(BEAM, "0.055 rad/pitch", joint="hinge"), 0.3), BEAM)
    share = few.errors["mu"] / few.values["mu"]
    assert f"mu is not determined by these points: its error is {share:.2g} times as large" in few.notes


def test_no_friction_and_unloading_alone():
    smooth = hinged(noisy(squama.cycle(BEAM, "0.2 rad/pitch", mu=0, joint="hinge"), 0.01), BEAM)
    assert smooth.values["mu"] < 3 * smooth.errors["mu"]
    assert any("mu cannot be told from 0" in n or "mu is at its bound 0" in n for n in smooth.notes)
    loop = squama.cycle(BEAM, "0.2 rad/pitch", joint="hinge")
    down = loop.isel(point=np.flatnonzero(loop.leg.values == 2))
    fit = hinged(noisy(down, 0.01), BEAM)
    # how the first point was reached nobody saw
    assert fit.branch[0] == "stick"
    assert "loading measured too, at the twists of the unloading" in [r.what for r in fit.remedies]
    assert abs(fit.values["mu"] - 0.3) < 3 * fit.errors["mu"]


def test_points_at_a_reversal_are_not_used_and_others_may_be_left_out():
    loop = squama.cycle(BEAM, HISTORY, joint="hinge")
    wrong = loop["T"].values.copy()
    wrong[loop.branch.values == "stick"] *= 0.3
    beyond = loop.phi.values > 0.15
    wrong[beyond] *= 0.5
    data = {"phi": loop.phi.values, "T": wrong}
    fit = hinged(data, BEAM.replace(friction={"mu": 0.1}), to="0.15 rad/pitch")
    assert fit.values["mu"] == pytest.approx(0.3, rel=1e-9)
    assert (fit.branch[beyond] == "beyond").all()
    assert not fit.used[beyond].any()
    # after a reversal joints may still give: as far as is said
    bad = loop["T"].values.copy()
    after = (loop.leg.values == 2) & (loop.phi.values > 0.195)
    bad[after] *= 1.3
    fit = hinged({"phi": loop.phi.values, "T": bad}, BEAM, stick="0.006 rad/pitch")
    assert fit.values["mu"] == pytest.approx(0.3, rel=1e-9)
    assert (fit.branch[after] == "stick").all()


def test_specimens():
    loops = [
        noisy(squama.cycle(BEAM, "0.2 rad/pitch", mu=mu, joint="hinge"), 0.003, seed=i)
        for i, mu in enumerate((0.2, 0.3, 0.4), start=1)
    ]
    fit = hinged(loops, BEAM)
    assert [s.label for s in fit.specimens] == ["data[0]", "data[1]", "data[2]"]
    # tolerance: noise of fixed seeds, 0.2 % measured
    assert [s.values[0] for s in fit.specimens] == pytest.approx([0.2, 0.3, 0.4], rel=0.02)
    assert any("mu differs between the 3 specimens" in note for note in fit.notes)
    single = hinged(loops[1], BEAM, nuisances="none")
    np.testing.assert_allclose(fit.specimens[1].values, single.estimates, rtol=1e-6)
    np.testing.assert_allclose(fit.specimens[1].errors, list(single.errors.values()), rtol=1e-4)
    same = hinged([noisy(squama.cycle(BEAM, "0.2 rad/pitch", joint="hinge"), 0.003, seed=i) for i in range(3)], BEAM)
    assert not any("differs" in note for note in same.notes)
    straight = squama.cycle(BEAM, "0.02 rad/pitch", joint="hinge")
    part = hinged([loops[0], straight], BEAM)
    assert part.specimens[1].values is None
    assert "before engagement" in part.specimens[1].problem
    assert "specimen data[1] alone: data: all" in part.summary()


@pytest.mark.slow
def test_bending_from_force_vectors():
    """Against the oracle's plane statics, with none of the package's algebra."""
    beam = BEAM.replace(scale={"alpha": 0}, substrate={"neutral": "face"})
    theta = np.linspace(beam.scale.theta0 + 0.02, 0.8, 9)
    at = [(MP.mpf(t), oracle_bending.psi_of(MP.mpf(t), BEAM.eta)) for t in theta]
    up, down = ([oracle_bending.state(t, q, BEAM.eta, BEAM.scale.theta0, m) for t, q in at] for m in (0.3, -0.3))
    R, K, d = BEAM.bending_rigidity, BEAM.joint_stiffness, BEAM.pitch
    psi = np.array([float(b.psi) for b in up])
    moments = [R * psi / d + K * np.array([float(b.moment_direct) for b in branch]) for branch in (up, down)]
    straight = np.linspace(0, 0.02, 4)
    data = {
        "psi": np.concatenate([straight, psi, psi[::-1]]),
        "M": np.concatenate([R * straight / d, moments[0], moments[1][::-1]]),
    }
    fit = hinged(data, beam.replace(friction={"mu": 0.1}), ("mu", "K_theta", "theta0"), load="bending")
    assert fit.values == pytest.approx({"mu": 0.3, "K_theta": K, "theta0": BEAM.scale.theta0}, rel=1e-8)

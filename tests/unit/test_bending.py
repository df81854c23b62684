"""Bending against its closed forms, the oracle in the plane, and virtual work."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import squama
from oracle import bending as oracle
from oracle.vectors import MP
from plane import plane
from squama.arrays import solution
from squama.model import mechanics
from squama.model.bending import Bend
from squama.model.outcome import CODES
from squama.model.paths import ARRAY, FLOAT

etas, angles = st.floats(1.05, 8), st.floats(math.radians(0.1), math.radians(60))


def solve(eta: float | list[float], theta0: float, mu: float) -> squama.Solved:
    etas = np.atleast_1d(np.asarray(eta, float))
    ratios = {"beta": 1.0, "lam": 0.0, "alpha": 0.0, "theta0": float(theta0), "mu": float(mu)}
    columns = {"eta": etas, **{name: np.full(etas.size, value) for name, value in ratios.items()}}
    return solution.solve(columns, load="bending", law="edge", sense="+").found


def across(eta: float, theta0: float = 0.1) -> Bend:
    """Edges across the beam, the length of the face kept; the width of the scales does not matter."""
    return Bend(eta, 0.7, 0.0, 0.0, 1.0, theta0)


@pytest.mark.parametrize(("mu", "lock"), [(0.0, 1.00507), (0.3, 0.96228), (0.6, 0.86068), (1.0, 0.70889)])
def test_figures_of_section_6(mu: float, lock: float) -> None:
    r = plane(squama.Beam.from_ratios(eta=5, theta0="5 deg"), mu=mu)
    # tolerance: the figures of the paper have so many decimals
    assert float(5 * r.psi_end) == pytest.approx(lock, abs=5e-6)
    assert float(r.psi_e) == pytest.approx(0.0193598, abs=5e-8)
    assert float(r.mu_static) == pytest.approx(10.2826, abs=5e-5)
    assert r.end.item() == ("frictional lock" if mu else "kinematic lock")
    assert int(r.neighbour) == 1


@given(etas, angles, st.floats(0, 10))
def test_closed_forms_of_the_locks(eta: float, theta0: float, mu: float) -> None:
    s = solve(eta, theta0, mu)
    psi_e, psi, theta = float(s.load_e[0]), float(s.load_end[0]), float(s.theta_end[0])
    assert eta * psi_e * math.cos(psi_e / 2) == pytest.approx(math.sin(theta0 + psi_e / 2), rel=1e-13)
    end = str(CODES[int(s.code[0])])
    mu_static = 1 / math.tan(theta0 + psi_e / 2)
    if mu >= mu_static:
        assert (end, psi, theta) == ("static lock", psi_e, theta0)
        return
    if mu == 0 or mu > 1e-9:
        assert end == ("frictional lock" if mu > 0 else "kinematic lock")
    assert eta * psi * math.cos(psi / 2) == pytest.approx(1 / math.hypot(1, mu), rel=1e-12)
    # the lock line is a translate: theta + psi/2 = arctan(1/mu)
    assert theta + psi / 2 == pytest.approx(math.atan2(1, mu), rel=1e-12)


@pytest.mark.parametrize(("eta", "degrees", "mu"), [(5.0, 5, 0.0), (5.0, 5, 0.6), (1.05, 30, 0.2), (7.5, 0.1, 1.0)])
@pytest.mark.parametrize("fraction", [0.1, 0.5, 0.95])
def test_states_against_the_oracle(eta: float, degrees: float, mu: float, fraction: float) -> None:
    theta0 = math.radians(degrees)
    theta = theta0 + fraction * (float(solve(eta, theta0, mu).theta_end[0]) - theta0)
    e, t = MP.mpf(eta), MP.mpf(theta)
    psi = oracle.psi_of(t, e)
    want = oracle.state(t, psi, e, MP.mpf(theta0), MP.mpf(mu))
    pt = across(eta, theta0).point(theta, "edge", FLOAT)
    f = mechanics.forces(pt, theta0, mu)
    got = {
        "psi": pt.load,
        "r": pt.s,
        "dtheta_dpsi": pt.theta_rate / pt.load_rate,
        "N0": f.N * eta,
        "f0": f.f * eta,
        "moment_energy": f.torque,
        "moment_direct": f.torque,
        "mu_lock": mechanics.mu_lock(pt),
    }
    wrong = {k: (v, getattr(want, k)) for k, v in got.items() if v != pytest.approx(float(getattr(want, k)), rel=1e-11)}
    assert not wrong
    assert pt.slip_rate / pt.load_rate == pytest.approx(abs(float(want.dr_dpsi)), rel=1e-11)
    assert (pt.theta, pt.p) == (theta, 0.7)
    assert pt.turn == pytest.approx(math.cos(theta + pt.load / 2), rel=1e-12)


@pytest.mark.parametrize(("eta", "degrees", "mu"), [(5.0, 5, 0.3), (1.3, 20, 0.0), (2.0, 10, 4.0)])
def test_ends_against_the_oracle(eta: float, degrees: float, mu: float) -> None:
    theta0 = math.radians(degrees)
    s = solve(eta, theta0, mu)
    e = oracle.path_end(MP.mpf(eta), MP.mpf(theta0), MP.mpf(mu))
    assert str(CODES[int(s.code[0])]) == {"friction": "frictional lock", "kinematic": "kinematic lock"}[e.kind]
    for got, want in ((s.load_e, e.psi_e), (s.theta_end, e.theta), (s.load_end, e.psi)):
        assert float(got[0]) == pytest.approx(float(want), rel=1e-12)
    r = plane(squama.Beam.from_ratios(eta=eta, theta0=theta0), mu=mu, points=5)
    assert float(r.mu_static) == pytest.approx(float(e.mu_static), rel=1e-12)


@given(etas, angles, st.floats(0, 3), st.floats(0.01, 0.99))
def test_moment_from_energy_is_moment_from_forces(eta: float, theta0: float, mu: float, fraction: float) -> None:
    """Also the balance of section 6, K (theta - theta0) = N l sin psi (cot(theta + psi/2) - mu)."""
    s = solve(eta, theta0, mu)
    theta = theta0 + fraction * (float(s.theta_end[0]) - theta0)
    if theta == theta0:
        return
    pt = across(eta, theta0).point(theta, "edge", FLOAT)
    f = mechanics.forces(pt, theta0, mu)
    psi, w = pt.load, theta + pt.load / 2
    arm = f.N * eta * math.sin(psi) * (1 / math.tan(w) - mu)
    assert arm == pytest.approx(theta - theta0, rel=1e-9, abs=1e-13 * f.N)
    # the contact force on scale 2 about the point that scale 2 turns round as the beam bends, in scale 2's axes:
    # place r along the face; the base moves on the circle of the beam
    r = eta * math.sin(theta - psi / 2) / math.sin(w)
    assert pt.s == pytest.approx(r, rel=1e-12)
    base = np.array(
        [(psi * math.cos(psi) - math.sin(psi)) / psi**2, (psi * math.sin(psi) - 1 + math.cos(psi)) / psi**2]
    )
    x2, y2 = (np.array([math.cos(a), math.sin(a)]) for a in (theta + psi, theta + psi + math.pi / 2))
    moved = base + r * y2
    force = -f.N * (y2 - mu * x2)
    size = abs(f.N) * (1 + mu) * (1 + r)
    assert -force @ moved == pytest.approx(f.torque, rel=1e-9, abs=1e-12 * size)


def test_arrays_and_complex_step() -> None:
    theta = np.radians([6.0, 20.0, 50.0])
    row = across(5.0, math.radians(5))
    pt = row.point(theta, "edge", ARRAY)
    for i, t in enumerate(theta):
        one = row.point(float(t), "plate", FLOAT)
        for got, want in zip(pt, one, strict=True):
            assert np.broadcast_to(got, 3)[i] == pytest.approx(want, rel=1e-13)
    step = row.point(theta + 1e-30j, "edge", ARRAY)
    np.testing.assert_allclose(step.load.imag / 1e-30, pt.load_rate, rtol=1e-12)
    np.testing.assert_allclose(abs(step.s.imag / 1e-30), pt.slip_rate, rtol=1e-11)
    assert np.all(np.diff(pt.load) > 0)


@given(etas, angles)
def test_the_first_root_is_found(eta: float, theta: float) -> None:
    psi = across(eta).bend(math.sin(theta), math.cos(theta), FLOAT)
    grid = np.linspace(1e-6, float(psi) * (1 - 1e-9), 400)
    assert np.all(eta * grid * np.cos(grid / 2) < np.sin(theta + grid / 2))
    assert eta * psi * math.cos(psi / 2) == pytest.approx(math.sin(theta + psi / 2), rel=1e-13)


def test_the_contact_stays_on_the_face() -> None:
    for eta in (1.0, 1.7, 6.0):
        row = across(eta, 0.05)
        for theta in np.linspace(0.05, 1.3, 9):
            pt = row.point(float(theta), "edge", FLOAT)
            assert 0 < pt.s < eta
    assert row.theta(0.3) == row.parameter(0.3, FLOAT) == 0.3


@given(etas, angles)
def test_newton_takes_few_steps(eta: float, theta: float) -> None:
    """As few as the true slope of the gap gives: the digits double with every step."""
    angles_seen: list[float] = []
    ops = FLOAT._replace(sin=lambda x: angles_seen.append(x) or math.sin(x))
    psi = across(eta).bend(math.sin(theta), math.cos(theta), ops)
    assert sum(abs(2 * half - psi) > 1e-9 for half in angles_seen) <= 5


def test_short_scales_do_not_engage() -> None:
    s = solve([0.9, 1.0, 2.0], 0.1, 0.3)
    assert [str(CODES[c]) for c in s.code] == ["no engagement", "frictional lock", "frictional lock"]
    assert s.neighbour.tolist() == [0, 1, 1]
    assert np.isinf(s.load_e[0])
    r = plane(squama.Beam.from_ratios(eta=0.9), mu=0.3)
    assert r.end.item() == "no engagement"
    assert np.all(r.N == 0)
    np.testing.assert_allclose(r.M, squama.Beam.from_ratios(eta=0.9).bending_rigidity * r.kappa)


def test_the_moment_of_the_beam() -> None:
    beam = squama.Beam.from_ratios(eta=5, theta0="5 deg", stiffness="30 N m")
    r = plane(beam, mu=0.3, points=60)
    np.testing.assert_allclose(r.M - r.M_scales, beam.bending_rigidity * r.kappa, rtol=1e-12)
    assert float(r.kappa_e) == pytest.approx(float(r.psi_e) / beam.pitch)
    i = 40
    row = across(beam.eta, beam.scale.theta0)
    f = mechanics.forces(row.point(float(r.theta[i]), "edge", FLOAT), beam.scale.theta0, 0.3)
    assert float(r.M_scales[i]) == pytest.approx(30 * f.torque, rel=1e-12)
    assert float(r.N[i]) == pytest.approx(30 / beam.pitch * f.N, rel=1e-12)
    # area law: width (2t)^3 / 12, no inclusion factor of its own
    assert beam.bending_rigidity == pytest.approx(25e9 * 0.032 * 0.016**3 / 12)

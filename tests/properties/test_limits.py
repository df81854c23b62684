"""Limits: small angles, alpha to 0 and to 90 deg, mu to 0, long scales, and digits at .1 deg."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given

import squama
from oracle.twisting import contact as oracle_contact
from oracle.twisting import forces as oracle_forces
from oracle.twisting import phi as oracle_phi
from oracle.twisting import polish_phi
from oracle.vectors import MP, Design
from properties.designs import Drawn, designs

MAIN = {"eta": 3.0, "beta": 1.25, "lam": 0.45, "alpha": math.radians(45)}


def exact(d: Drawn, alpha: object = None) -> Design:
    """Return the design in 30 digits, of exactly these doubles."""
    eta, beta, lam, a, theta0 = (MP.mpf(v) for v in d[:5])
    return Design(eta, a if alpha is None else alpha, beta, lam, theta0)


def test_engagement_at_small_angles() -> None:
    """The formula is the first term: its error halves with theta0."""
    theta0 = np.radians([0.4, 0.2, 0.1, 0.05])
    phi_e = squama.ends(**MAIN, theta0=theta0, mu=0.1).phi_e
    small = theta0 / (3 * math.tan(MAIN["alpha"]) + 1.25 - math.sin(MAIN["alpha"]))
    error = phi_e / small - 1
    assert 0 < abs(error[-1]) < 5e-3
    np.testing.assert_allclose(error[:-1] / error[1:], 2, atol=0.05)
    for sense, sign in (("+", 1), ("-", -1)):
        beam = squama.Beam.from_ratios(eta=2.0, beta=1.5, alpha="5 deg", theta0="0.01 deg")
        r = squama.twist(beam, mu=0, sense=sense, joint="hinge")
        a = math.radians(5)
        formula = beam.scale.theta0 / (sign * 2 * math.tan(a) + 1.5 - sign * math.sin(a))
        assert r.phi_e_small.item() == pytest.approx(formula, rel=1e-12)
        if r.end.item() != "no engagement":
            assert r.phi_e_small.item() == pytest.approx(r.phi_e.item(), rel=1e-3)
    # twisted the other way a long scale's tip does not come down at small angles
    assert np.isinf(squama.twist(squama.Beam.from_ratios(), mu=0, sense="-", joint="hinge").phi_e_small)


@given(designs())
def test_small_angle_formula_for_all_designs(d: Drawn) -> None:
    theta0 = 1e-6
    c = squama.contact(theta0, **d.ratios)
    if d.lam * math.cos(2 * d.alpha) < 0:
        return
    small = theta0 / (d.eta * math.tan(d.alpha) + d.beta - math.sin(d.alpha))
    # next order: theta0 times lengths over the slope, twice
    size = 1 + d.eta + d.beta + d.lam
    assert float(c.phi) == pytest.approx(small, rel=1e-5 * size * max(1.0, small / theta0) ** 2)


@pytest.mark.slow
@given(designs())
def test_digits_at_a_tenth_of_a_degree(d: Drawn) -> None:
    """Engagement, places, rates and forces against 30 digits: a cancelling form would keep eight or so."""
    d = d._replace(theta0=math.radians(0.1))
    for theta in (d.theta0, 1.5 * d.theta0):
        c = squama.contact(theta, **d.ratios)
        e, t = exact(d), MP.mpf(theta)
        q = oracle_phi(t, e)
        if q is None or q > 1:
            continue
        assert float(abs(c.phi / q - 1)) < 1e-13
        o = oracle_contact(t, q, e, "edge")
        size = d.eta + d.beta + 1
        for got, want in ((c.p, o.p), (c.s, o.s)):
            assert abs(float(got - want)) < 1e-14 * size
        assert float(abs(c.dphi_dtheta / o.dphi_dtheta - 1)) < 1e-12 * size
        if theta == d.theta0:
            continue
        for law in ("plate", "edge"):
            f = squama.forces(theta, **d.ratios, theta0=d.theta0, mu=0.3, law=law)
            w = oracle_forces(t, q, e, law, MP.mpf(0.3))
            for got, want in ((f.normal, w.N0), (f.friction, w.f0), (f.torque, w.torque_energy)):
                assert float(abs(got / want - 1)) < 1e-10


def test_alpha_to_zero() -> None:
    """The limit is the contact at alpha = 0 itself, and it is approached linearly."""
    theta, theta0 = math.radians(20), math.radians(5)
    d = Drawn(3.0, 1.25, 0.45, 0.0, theta0, 0.2)
    q = oracle_phi(MP.mpf(theta), exact(d))
    o = oracle_contact(MP.mpf(theta), q, exact(d), "edge")
    w = oracle_forces(MP.mpf(theta), q, exact(d), "edge", MP.mpf(0.2))
    shape = {**MAIN, "alpha": np.array([1e-5, 1e-7, 1e-9, 1e-14])}
    c, f = squama.contact(theta, **shape), squama.forces(theta, **shape, theta0=theta0, mu=0.2)
    pairs = ((c.phi, q), (c.s, o.s), (c.p, o.p), (c.dphi_dtheta, o.dphi_dtheta), (f.torque, w.torque_energy))
    for got, want in pairs:
        error = abs(got - float(want))
        assert error[0] < 3e-3
        # tolerance: linear, so a hundredth of it; rounding is 1e-8 of that
        assert error[1] < 1.1e-2 * error[0] + 1e-14
        assert error[3] < 3e-12


def test_alpha_to_a_right_angle() -> None:
    """The scale's width comes to lie along the beam: engagement goes to zero like cos(alpha)."""
    off = np.array([1e-2, 1e-4, 1e-6])
    c = squama.contact(math.radians(10), **{**MAIN, "alpha": np.pi / 2 - off})
    ratio = c.phi / np.cos(np.pi / 2 - off)
    assert ratio[2] == pytest.approx(math.sin(math.radians(10)) / (3 + 0.45 * math.sin(math.radians(10))), rel=1e-5)
    # tolerance: linear, so a hundredth of it; rounding is 1e-9 of that
    assert abs(ratio[1] - ratio[2]) < 0.02 * abs(ratio[0] - ratio[2])
    d = Drawn(3.0, 1.25, 0.45, float(np.pi / 2 - 1e-4), math.radians(10), 0.3)
    q = oracle_phi(MP.mpf(d.theta0), exact(d))
    assert float(abs(c.phi[1] / q - 1)) < 1e-11
    e = squama.ends(**{**MAIN, "alpha": math.radians(89.9)}, theta0=math.radians(10), mu=[0.1, 3, 10])
    assert set(e.end.tolist()) <= {"frictional lock", "kinematic lock", "static lock", "other contact"}
    assert np.all(np.diff(e.phi_end) <= 0)


def test_mu_to_zero() -> None:
    at = {**MAIN, "theta0": math.radians(10)}
    mu = np.array([1e-3, 1e-5, 1e-7])
    for law in ("plate", "edge"):
        free, rough = (squama.forces(0.8, **at, mu=m, law=law) for m in (0.0, mu))
        for name in ("normal", "torque"):
            error = getattr(rough, name) - getattr(free, name)
            assert np.all(error > 0)
            np.testing.assert_allclose(error[:-1] / error[1:], 100, rtol=0.03)
        np.testing.assert_allclose(rough.friction / mu, free.normal, rtol=0.03)
    # the frictional lock moves off the kinematic one
    lock, limit = squama.ends(**at, mu=mu), squama.ends(**at, mu=0)
    step = limit.theta_end - lock.theta_end
    assert np.all(step > 0)
    np.testing.assert_allclose(step[:-1] / step[1:], 100, rtol=0.01)
    # tolerance: of second order, 0.13 step**2; the rest is rounding
    assert np.all(limit.phi_end - lock.phi_end < step**2 + 1e-13)


@pytest.mark.parametrize("eta", [100.0, 10_000.0])
def test_long_scales(eta: float) -> None:
    d = Drawn(eta, 1.25, 0.45, math.radians(45), math.radians(10), 0.3)
    theta = np.radians([10.0, 40.0, 80.0])
    c = squama.contact(theta, **d.ratios)
    f = squama.forces(theta, **d.ratios, theta0=d.theta0, mu=0.3)
    for i, t in enumerate(map(MP.mpf, theta)):
        phi = MP.mpf(float(c.phi[i]))
        # the oracle's grid is too coarse for so small a twist: start from ours
        q = polish_phi(t, phi, exact(d))
        assert float(abs(phi / q - 1)) < 1e-13
        o = oracle_contact(t, q, exact(d), "edge")
        assert float(abs(c.s[i] / o.s - 1)) < 1e-12
        assert float(abs(c.p[i] - o.p)) < 1e-12 * eta
        if i:
            w = oracle_forces(t, q, exact(d), "edge", MP.mpf(0.3))
            assert float(abs(f.torque[i] / w.torque_energy - 1)) < 1e-9
    # to first order only the length counts: phi eta tan(alpha) = sin(theta)
    np.testing.assert_allclose(c.phi * eta, np.sin(theta) / math.tan(d.alpha), rtol=30 / eta)

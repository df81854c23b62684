"""Bending of oblique scales: the kernel of both loads, figures of the derivation, work and slopes."""

import numpy as np
import pytest

import squama
from squama.model import mechanics, screw
from squama.model.bending import Bend
from squama.model.paths import FLOAT
from squama.model.screw import CONTACTS
from squama.model.screw_path import Design, Leg, followed

MAIN = squama.Beam.from_ratios(eta=3, beta=1.25, lam=0.45, alpha="45 deg", theta0="10 deg")


def bend(beam, **asked):
    return squama.bend(beam, joint="hinge", **asked)


def drawn(n, seed):
    """Designs at random, one in five across the beam, and the height of the line that keeps its length."""
    r = np.random.default_rng(seed)
    alpha = np.radians(r.uniform(0.05, 75, n)) * (r.random(n) > 0.2)
    eta, beta, lam = r.uniform(1.05, 7, n), r.uniform(0.4, 3, n), r.uniform(0.05, 1, n)
    return eta, beta, lam, alpha, np.radians(r.uniform(1, 40, n)), r.choice([0, 0.2, 0.6, 1.5], n), r.choice([0, 1], n)


def test_the_contact_is_that_of_both_loads():
    """Places, rates, force and moment of the closed form against the screw's kernel, which shares none of it."""
    looked = 0
    for *ratios, mu, n in zip(*drawn(200, 1), strict=True):
        eta, beta, lam, alpha, theta0 = ratios
        leg = Leg(Design(*ratios, mu, n * lam), (0.0, 0.0), (1.0, 0.0))
        row = Bend(eta, beta, lam * (1 - n), np.sin(alpha), np.cos(alpha), theta0)
        pt = row.point(theta0 + 0.3, "edge", FLOAT)
        if min(pt.load_rate, pt.turn, *row.places(pt), -pt.M_N - mu * pt.M_f) < 1e-2:
            continue
        looked += 1
        theta, psi = np.array([pt.theta]), np.array([pt.load])
        assert float(leg.touching(psi).theta[0]) == pytest.approx(pt.theta, abs=1e-11)
        posed = leg.posed(psi)
        here = screw.place(CONTACTS["BF"], posed.d, theta)
        slid = screw.Velocities.of(posed.g, n * lam + 0 * psi, here).sliding(theta - theta0, mu + 0 * psi, (1, 0 * psi))
        forces = mechanics.forces(pt, theta0, mu)
        found = (pt.p, pt.s, 1 / pt.load_rate, pt.slip_rate / pt.load_rate, forces.N, forces.torque)
        wanted = (here.across, here.along, slid.theta_rate, slid.slip_rate, slid.N, slid.M)
        np.testing.assert_allclose(found, np.ravel(wanted), rtol=1e-9, atol=1e-11)
    assert looked > 100


@pytest.mark.slow
def test_paths_end_where_those_of_both_loads_end():
    """Arrays of designs against the screw's kernel followed from contact to contact."""
    eta, beta, lam, alpha, theta0, mu, n = drawn(60, 2)
    ratios = {"eta": eta, "beta": beta, "alpha": alpha, "theta0": theta0, "mu": mu}
    s = squama.solve(**ratios, lam=lam * (1 - n), load="bending")
    seen = set()
    for i in range(eta.size):
        design = Design(eta[i], beta[i], lam[i], alpha[i], theta0[i], mu[i], n[i] * lam[i])
        far = 1.5
        pieces = list(followed(design, [(far, 0.0)]))
        if pieces[-1].event == "closed":
            # the corner passes beside the next scale
            assert s.end[i] == "no engagement"
            continue
        seen.add(str(pieces[-1].end))
        assert s.end[i] == pieces[-1].end
        assert s.load_end[i] == pytest.approx(far * pieces[-1].x1, rel=1e-9)
        assert s.load_e[i] == pytest.approx(far * pieces[0].x1, rel=1e-10)
    assert seen >= {"frictional lock", "kinematic lock", "kinematic lock (line contact)"}


def test_engagement_and_lock_of_the_derivation():
    # tolerance: the figures have five decimals
    assert float(bend(MAIN, mu=0).psi_e) == pytest.approx(0.04780, abs=5e-6)
    across = MAIN.replace(scale={"alpha": 0})
    for neutral, lock in (("middle", 0.29257), ("face", 0.33816)):
        assert float(bend(across, mu=0, neutral=neutral).psi_end) == pytest.approx(lock, abs=5e-6)
    # off the line the plates lock: cot(theta) = (omega_Y / rho) tan(rho / 2)
    r = bend(MAIN, mu=0)
    assert r.end.item() == "kinematic lock (line contact)"
    wanted = np.cos(MAIN.scale.alpha) * np.tan(r.psi_end / 2)
    assert float(1 / np.tan(r.theta_end)) == pytest.approx(float(wanted), rel=1e-9)


@pytest.mark.parametrize(("degrees", "mu"), [(5, 0.3), (45, 0.0), (45, 1.0), (80, 0.3)])
def test_work_of_the_moment_is_stored_or_rubbed_away(degrees, mu):
    beam = MAIN.replace(scale={"alpha": f"{degrees} deg"})
    whole = bend(beam, mu=mu, points=3)
    a, b = float(whole.kappa_e), float(whole.kappa_e + 0.8 * (whole.kappa_end - whole.kappa_e))
    nodes, weights = np.polynomial.legendre.leggauss(40)
    at = (a + b) / 2 + (b - a) / 2 * nodes
    r = bend(beam, mu=mu, at=[a, *at, b])
    given = beam.bending_rigidity * a**2 / 2 + (b - a) / 2 * weights @ r.M.values[1:-1]
    assert float(given) == pytest.approx(float(r.U_el[-1] + r.W_fr[-1]), rel=1e-9)
    assert (float(r.W_fr[-1]) > 0) == (mu > 0)
    # the tangent against a difference
    h = 1e-5 * b
    low, high = bend(beam, mu=mu, at=[0.9 * b - h, 0.9 * b + h]).M.values
    tangent = float(bend(beam, mu=mu, at=[0.9 * b]).K_b[0])
    assert tangent == pytest.approx((high - low) / (2 * h), rel=1e-6)


def test_it_is_the_way_of_bend_twist_along_psi():
    r = bend(MAIN, mu=0.3, at=[10.0])
    both = squama.bend_twist(MAIN, "bend 10 rad/m", mu=0.3, joint="hinge").isel(point=-1)
    for name in ("theta", "mu_lock"):
        assert float(r[name][0]) == pytest.approx(float(both[name]), rel=1e-12)
    for name in ("M_scales", "N", "W_fr"):
        assert float(r[name][0]) == pytest.approx(float(both[name]), rel=1e-9)
    assert float(r["T"][0]) == pytest.approx(float(both.T_scales), rel=1e-12)
    assert r.contact.values.tolist() == ["BF"]


def test_a_range_ends_where_it_is_asked_to():
    whole = bend(MAIN, mu=0.3, points=3)
    part = bend(MAIN, mu=0.3, to="0.2 rad/pitch", points=9)
    assert part.end.item() == "range end"
    assert float(part.psi[-1]) == pytest.approx(0.2, rel=1e-13)
    assert float(part.psi_e) == float(whole.psi_e)
    before = bend(MAIN, mu=0.3, to="0.03 rad/pitch", points=9)
    assert (before.end.item(), float(before.psi_e)) == ("range end", float(whole.psi_e))
    assert set(before.contact.values) == {""}
    beyond = bend(MAIN, mu=0.3, at=[0.0, 100.0])
    assert np.isnan(beyond.M.values).tolist() == [False, True]
    # scales shorter than the pitch: oblique ones touch, and so do those that the bar's middle brings together
    short = squama.Beam.from_ratios(eta=0.9)
    assert float(bend(short, mu=0.3).psi_e) < 0.2
    across = short.replace(scale={"alpha": 0})
    # along the face a pitch is 1 - lambda psi long
    assert bend(across, mu=0.3, neutral="face").end.item() == "no engagement"
    r = bend(across, mu=0, at="0.5 rad/pitch")
    gap = 0.9 * 0.5 * np.cos(0.25) - (1 - 0.45 * 0.5) * np.sin(r.theta + 0.25)
    assert float(gap[0]) == pytest.approx(0, abs=1e-13)


def test_a_family_and_bad_input():
    r = bend(MAIN, mu=[0, 0.3, 9], points=12)
    assert r.M.shape == (3, 12)
    assert r.end.values.tolist()[-1] == "static lock"
    with pytest.raises(squama.InputError, match='neutral = "top": must be "free" or "middle" or "face"'):
        bend(MAIN, mu=0, neutral="top")


def test_twisted_scales_across_the_beam_meet_at_the_corner_of_their_base():
    """Where the hinge's other contact comes in, the kernel of both loads has its base contact."""
    beam = MAIN.replace(scale={"alpha": 0})
    r = squama.twist(beam, mu=0.3, joint="hinge")
    assert r.other_contact.item().startswith("corner D2 on the face of scale 1")
    both = squama.bend_twist(beam, "twist 0.2 rad/pitch", mu=0.3, joint="hinge")
    assert both.contact.values[-1] == "DF"
    assert float(r.phi_end) == pytest.approx(float(both.phi_e), rel=1e-9)

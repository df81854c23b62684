"""Bending of oblique scales: figures of the derivation, work, slopes, the path of both loads, and alpha = 0."""

import numpy as np
import pytest

import squama
from squama.curves.doors import respond

MAIN = squama.Beam.from_ratios(eta=3, beta=1.25, lam=0.45, alpha="45 deg", theta0="10 deg")


def bend(beam, **asked):
    return squama.bend(beam, joint="hinge", **asked)


@pytest.mark.parametrize(("eta", "theta0"), [(5, "5 deg"), (1.3, "20 deg"), (7, "0.5 deg"), (1.01, "10 deg")])
@pytest.mark.parametrize("mu", [0.0, 0.3, 4.0])
def test_across_and_on_the_face_it_is_the_closed_form(eta, theta0, mu):
    beam = squama.Beam.from_ratios(eta=eta, theta0=theta0, alpha=0)
    plane = respond(beam, "bending", mu=mu, points=60).dataset()
    r = bend(beam, mu=mu, neutral="face", points=60)
    assert r.end.item() == plane.end.item()
    same = bend(beam, mu=mu, neutral="face", at=plane.kappa.values)
    # at engagement itself the one is before, the other behind it
    inside = np.abs(plane.psi / plane.psi_e - 1).values > 1e-9
    for name in plane.data_vars:
        if name in ("end", "other_contact"):
            continue
        if plane[name].ndim:
            # forces near a lock lose the digits of theta; work is a quadrature
            v, w = plane[name].values[inside], same[name].values[inside]
            floor = 1e-10 if name in ("W_fr", "RED") else 1e-12
            np.testing.assert_allclose(w, v, rtol=2e-11, atol=floor * np.nanmax(np.abs([*v, 0])), err_msg=name)
        else:
            rtol = 1e-12 if name.endswith(("_e", "_end")) else 2e-11
            np.testing.assert_allclose(float(r[name]), float(plane[name]), rtol=rtol, err_msg=name)
    assert np.all(r["T"] == 0)


def test_engagement_and_lock_of_the_derivation():
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
    ratio = MAIN.bending_joint_stiffness / float(both.K_theta)
    for name in ("theta", "mu_lock"):
        assert float(r[name][0]) == pytest.approx(float(both[name]), rel=1e-12)
    for name in ("M_scales", "N", "W_fr"):
        assert float(r[name][0]) == pytest.approx(ratio * float(both[name]), rel=1e-9)
    assert float(r["T"][0]) == pytest.approx(ratio * float(both.T_scales), rel=1e-12)
    assert r.contact.values.tolist() == ["BF"]


def test_a_range_ends_where_it_is_asked_to():
    whole = bend(MAIN, mu=0.3, points=3)
    part = bend(MAIN, mu=0.3, to="0.2 rad/pitch", points=9)
    assert (part.end.item(), float(part.psi[-1])) == ("range end", 0.2)
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
    with pytest.raises(squama.InputError, match='neutral = "top": must be "middle" or "face"'):
        bend(MAIN, mu=0, neutral="top")


def test_twisted_scales_across_the_beam_meet_at_the_corner_of_their_base():
    """Where the hinge's other contact comes in, the kernel of both loads has its base contact."""
    beam = MAIN.replace(scale={"alpha": 0})
    r = squama.twist(beam, mu=0.3, joint="hinge")
    assert r.other_contact.item().startswith("corner D2 on the face of scale 1")
    both = squama.bend_twist(beam, "twist 0.2 rad/pitch", mu=0.3, joint="hinge")
    assert both.contact.values[-1] == "DF"
    assert float(r.phi_end) == pytest.approx(float(both.phi_e), rel=1e-9)

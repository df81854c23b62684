"""The compliant model: as a hinge against the closed form; its energies, senses and invariances."""

import os

import numpy as np
import pytest

pytest.importorskip("ipctk", reason="needs the extra fe")

import squama
from squama.beam.matrixfile import MOTIONS, twisting_stiffness
from squama.errors import InputError
from squama.fe import condense
from squama.fe.contact import DHAT, SLIP
from squama.fe.plate import Rest
from squama.fe.walk import SNAP, STOPPED

K_THETA = 0.0119
MIRROR = np.diag([1.0, -1, 1, -1, 1, -1, -1])
TWISTS = np.arange(1, 53) * 0.005


def test_work_that_is_neither_stored_nor_rubbed_away():
    along = {name: np.array(v) for name, v in (("T", [0, 1, np.nan]), ("W", [0, 2, 0]), ("U_el", [0, 1.5, 0]))}
    c = condense.Condensed(along | {"W_fr": np.array([0, 0.4, 0])}, 0.0, 0.0, "", (), np.empty(0))
    assert c.unbalanced == pytest.approx(0.05)
    assert c._replace(along={"T": np.full(2, np.nan)}).unbalanced == 0


def matrix(k_theta=K_THETA, seed=0):
    """A stiffness of about the right size, all entries alive."""
    size = np.sqrt([0.4, 0.5, 0.4, 4 * k_theta, k_theta, 5 * k_theta, 0.02])
    mixed = np.random.default_rng(seed).normal(size=(7, 7)) * 0.1
    shape = np.eye(7) + (mixed + mixed.T) / 2
    shape[4, 4] = shape[6, 6] = 1.0
    return size[:, None] * shape * size


def hinge(k_theta=K_THETA):
    return np.diag([1.0, 1, 1, 1, k_theta, 1, 0.02])


def motions(c):
    return np.stack([c.along[name] for name in MOTIONS], -1)


FIG_6B = {"eta": 3.0, "beta": 0.6, "lam": 0.32}
MAIN = {"eta": 3.0, "beta": 1.25, "lam": 0.45}


def rest(eta, beta, lam, alpha=45.0):
    return Rest.at(eta, beta, lam, np.radians(alpha), np.radians(10))


def closed_form(case, mu, twists):
    """Inclination, scales' torque over K_theta, N d / K_theta and frictional work of the edge law."""
    beam = squama.Beam.from_ratios(**case, mu=mu)
    r, K, d = squama.twist(beam, at=twists / beam.pitch, joint="hinge"), beam.joint_stiffness, beam.pitch
    return r.theta.values, r.T_scales.values / K, r.N.values * d / K, r.W_fr.values * d / K, float(r.phi_e)


@pytest.mark.parametrize("mu", [0.0, 0.2, 0.5])
@pytest.mark.parametrize("case", [FIG_6B, MAIN], ids=["Fig. 6b", "main case"])
def test_a_rigid_hinge_follows_the_edge_law(case, mu):
    twists = np.append(TWISTS[TWISTS < 0.25], 0.255 if case is MAIN else 0.26)
    c = condense.curve(rest(**case), hinge(), mu, twists, hinge=True)
    theta, T, N, W_fr, phi_e = closed_form(case, mu, twists)
    assert c.end == "range end"
    assert c.phi_e == pytest.approx(phi_e, abs=1e-7)
    assert [t.pair for t in c.contacts] == ["tip edge C1B1 on side edge D2C2"]
    scales = (c.along["T"] - 0.02 * twists) / K_THETA
    on = twists > phi_e + 0.01
    # tolerance: the barrier keeps a gap, which the closed form does not; figures are those of DHAT
    np.testing.assert_allclose(c.along["theta"][on], theta[on], rtol=4e-4)
    np.testing.assert_allclose(scales[on], T[on], rtol=3e-3)
    np.testing.assert_allclose(c.along["N"][on] / K_THETA, N[on], rtol=3e-3)
    np.testing.assert_allclose(c.along["f"][on], mu * c.along["N"][on], rtol=1e-6)
    late = twists > 0.15
    np.testing.assert_allclose(c.along["W_fr"][late] / K_THETA, W_fr[late], rtol=4e-3)
    beam = squama.Beam.from_ratios(**case, mu=mu)
    r = squama.twist(beam, at=twists / beam.pitch, joint="hinge")
    np.testing.assert_allclose(c.along["s"][on], r.s.values[on] / beam.pitch, atol=5e-4)
    np.testing.assert_allclose(c.along["p"][on], r.p.values[on] / beam.pitch, atol=5e-4)


def test_at_the_lock_a_hinge_stops():
    c = condense.curve(rest(**MAIN), hinge(), 0.5, [0.2, 0.26, 0.28], hinge=True)
    assert c.end == STOPPED
    # squama.twist(Beam.from_ratios(), mu=0.5).phi_end = 0.269057
    # tolerance: the barrier, 1.1e-4 measured, on every processor
    assert c.phi_end == pytest.approx(0.269057, abs=2e-4)
    assert np.isfinite(c.along["T"][:2]).all()
    assert np.isnan(c.along["T"][2])


@pytest.mark.parametrize("mu", [0.0, 0.5])
@pytest.mark.parametrize("blocked", [True, False], ids=["hinge", "free"])
def test_the_torques_work_is_stored_or_rubbed_away(mu, blocked):
    c = condense.curve(rest(**FIG_6B), matrix(), mu, TWISTS, hinge=blocked)
    assert c.end == "range end"
    # tolerance: the increments, 1e-4 measured, on every processor
    assert abs(c.unbalanced) < 1e-3
    assert (c.along["W_fr"][-1] > 0.05 * c.along["U_el"][-1]) == (mu > 0)
    assert np.all(np.diff(c.along["W_fr"]) >= 0)


def test_the_model_does_not_depend_on_its_numerical_parameters():
    def end(**options):
        c = condense.curve(rest(**FIG_6B), matrix(), 0.5, [0.1, 0.2, 0.25], **options)
        return np.array([c.along["T"], c.along["theta"], c.along["N"]])

    usual = end()
    for options in ({"dhat": 2e-5}, {"slip": 1e-6}, {"slip": 1e-4}, {"increment": 5e-4}, {"increment": 5e-3}):
        # tolerance: a parameter of the method changes the end by 5e-4, on every processor
        np.testing.assert_allclose(end(**options), usual, rtol=2e-3, err_msg=str(options))


def test_the_other_sense_is_the_mirror_image():
    # alpha = 12 deg: the scales meet in both senses
    K = matrix()
    shape, mirrored = rest(**MAIN, alpha=12), rest(**MAIN, alpha=-12)
    twists = np.array([0.1, 0.2, 0.3, 0.35])
    there = condense.curve(shape, K, 0.3, -twists)
    image = condense.curve(mirrored, MIRROR @ K @ MIRROR, 0.3, twists)
    assert there.contacts
    np.testing.assert_allclose(there.along["T"], -image.along["T"], rtol=1e-6)
    np.testing.assert_allclose(motions(there), motions(image) @ MIRROR[:6, :6], atol=1e-8)
    np.testing.assert_allclose(
        [there.along["theta"], there.along["N"], there.along["W_fr"]],
        [image.along["theta"], image.along["N"], image.along["W_fr"]],
        rtol=1e-5,
    )
    assert there.phi_e == pytest.approx(-image.phi_e, rel=1e-9)
    with_sense = condense.curve(shape, K, 0.3, twists)
    assert not np.allclose(with_sense.along["T"], image.along["T"], rtol=1e-2)


def test_in_the_other_sense_it_finds_the_contact_that_the_plates_have():
    # squama.ends names it for the paper's main case: side edge A1B1 on base edge D2A2 at phi = .38669
    c = condense.curve(rest(**MAIN), hinge(), 0.3, [-0.38, -0.4], hinge=True)
    assert c.phi_e == pytest.approx(-0.3866909880, abs=1e-7)
    assert c.contacts[0].pair == "side edge A1B1 on base edge D2A2"
    assert c.along["N"][0] == 0
    assert c.along["N"][1] > 0


def test_before_contact_the_beam_is_linear():
    K = matrix()
    c = condense.curve(rest(**FIG_6B), K, 0.5, [0.01, 0.03])
    free = -np.linalg.solve(K[:6, :6], K[:6, 6])
    np.testing.assert_allclose(motions(c), np.outer([0.01, 0.03], free), rtol=1e-9)
    np.testing.assert_allclose(c.along["T"], twisting_stiffness(K) * c.along["phi"], rtol=1e-9)
    assert twisting_stiffness(K) == pytest.approx(1 / np.linalg.inv(K)[6, 6])
    assert (c.phi_e, c.contacts) == (np.inf, ())
    assert not c.along["N"].any()


def test_unloading_has_a_lower_branch_and_a_loop_of_the_dissipated_area():
    up = np.arange(1, 51) * 0.004
    c = condense.curve(rest(**FIG_6B), matrix(), 0.3, np.concatenate([up, up[-2::-1], [0.0]]))
    assert c.end == "range end"
    i, j = 30, 2 * up.size - 2 - 30
    assert c.along["phi"][i] == pytest.approx(c.along["phi"][j])
    assert c.along["T"][j] < 0.9 * c.along["T"][i]
    # back at rest nothing is stored: all work was rubbed away
    assert c.along["U_el"][-1] < 1e-4 * c.along["W_fr"][-1]
    assert c.along["W"][-1] == pytest.approx(c.along["W_fr"][-1], rel=1e-2)


@pytest.mark.parametrize("mu", [0.0, 0.5])
def test_where_the_contact_slips_off_a_corner_the_curve_ends_with_a_snap(mu):
    c = condense.curve(rest(**FIG_6B), matrix(), mu, np.arange(1, 120) * 0.005)
    assert c.end == SNAP
    assert 0.36 < c.phi_end < 0.43
    assert abs(c.unbalanced) < 1e-3
    reached = np.isfinite(c.along["T"])
    assert reached[c.along["phi"] <= c.phi_end].all()
    assert not reached[c.along["phi"] > c.phi_end].any()
    # it got to the corner B of the tip edge
    assert c.along["p"][reached][-1] > 0.59 or "corner B1" in c.contacts[-1].pair


def test_a_restart_file_runs_no_code(tmp_path):
    class Planted:
        def __reduce__(self):
            return os.mkdir, (str(tmp_path / "made"),)

    file = tmp_path / "run.npz"
    np.savez(file, key=np.array([Planted()], dtype=object))
    walk = condense.Walk(Rest.at(3, 0.6, 0.32, np.pi / 4, np.radians(10)), np.eye(7), 0.2, condense.FREE, DHAT, SLIP)
    with pytest.raises(InputError, match="is damaged, or no restart file of this version of squama"):
        walk.resume(file, {})
    assert list(tmp_path.iterdir()) == [file]

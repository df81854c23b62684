"""Histories of bends on compliant joints: loops, work, the way of both loads, contacts that part, and refusals."""

import re

import numpy as np
import pytest

import squama
from oracle.barrier import needs_barrier, surface
from squama.cli import main
from squama.curves import compliant
from squama.errors import InputError
from squama.fe.assembly import make_bent
from squama.fe.geometry import geometry
from squama.joints.choice import joint_of

SKIN = squama.Beam.from_toml("examples/stiff_skin.toml").replace(scales=None).replace(hold="bend, twist, lateral bend")
PLA = squama.Beam.from_toml("examples/pla_on_vps.toml").replace(scales=None).replace(hold="bend, twist, lateral bend")
HISTORY = "0, 0.12, 0.09, 0.12, 0, 0.1, 0 rad/pitch"


@pytest.fixture(scope="module")
def walked():
    return squama.cycle(SKIN, HISTORY, load="bending", mu=0.25)


def test_it_is_on_compliant_joints(walked):
    assert (walked.attrs["joint"], walked.attrs["scales"]) == ("compliant", "thick, elastic scales")
    assert walked.attrs["neutral"] == "free"
    assert set(walked.branch.values) == {"straight", "loading", "stick", "unloading"}
    assert set(walked.contact.values) == {"", "BF"}
    # the way up is that of squama.bend
    up = (walked.leg == 1).values
    r = squama.bend(SKIN, mu=0.25, to="0.12 rad/pitch", points=400)
    for name in ("M", "theta", "N", "T", "stress"):
        wanted = np.interp(walked.psi.values[up], r.psi, r[name])
        assert walked[name].values[up] == pytest.approx(wanted, abs=3e-3 * float(abs(r[name]).max())), name
    assert float(walked.psi_e[0]) == pytest.approx(float(r.psi_e), rel=1e-6)


def test_work_is_stored_or_rubbed_away(walked):
    # tolerance: the walk's steps, 3e-5, and trapezoids between points, 1 %, on every processor
    assert abs(float(walked.energy_error)) < 1e-4
    given = np.trapezoid(walked.M, walked.kappa)
    # where the friction turns round the moment falls steeply between points
    assert given == pytest.approx(float(walked.U_el[-1] + walked.W_fr[-1]), rel=2e-2)
    assert float(walked.M[-1]) == pytest.approx(0.0, abs=1e-9)


def test_loops_are_those_of_the_path_of_both_loads(walked):
    np.testing.assert_allclose(walked.psi_base, [0.09, 0, 0], atol=1e-12)
    np.testing.assert_allclose(walked.psi_top, [0.12, 0.12, 0.1], rtol=1e-12)
    r = squama.bend_twist(SKIN, "bend 0.12 rad/pitch; bend 0 rad/pitch", mu=0.25, points=250)
    assert float(walked.W_d[1]) == pytest.approx(float(r.W_fr[-1]), rel=1e-2)
    assert float(walked.zeta_eq[1]) == pytest.approx(
        float(walked.W_d[1] / (4 * np.pi * walked.U_max[1])), rel=1e-9
    )  # fmt: skip
    # friction turns round: the moment falls while the contact sticks
    assert (walked.M_drop > 0).all()


def test_what_is_gone_through_again_is_the_same():
    c = squama.cycle(SKIN, "0.1 rad/pitch", load="bending", mu=0.3, loops=3, points=30)
    np.testing.assert_allclose(c.W_d[1:], c.W_d[0], rtol=2e-3)


def test_bent_away_nothing_touches_and_coming_back_it_does():
    c = squama.cycle(SKIN, "0, -0.08, 0.11, 0 rad/pitch", load="bending", mu=0.25, points=40)
    away = (c.psi < 0.05).values
    np.testing.assert_allclose(c.M.values[away], c.attrs["rigidity"] * c.kappa.values[away], rtol=1e-6, atol=1e-12)
    once = squama.cycle(SKIN, "0.11 rad/pitch", load="bending", mu=0.25, points=40)
    assert float(c.M.max()) == pytest.approx(float(once.M.max()), rel=1e-4)
    assert list(c.sense.values) == ["+", "-"]
    assert np.isinf(c.psi_e[1])


def test_without_friction_the_way_back_is_the_way_up():
    c = squama.cycle(SKIN, "0.12 rad/pitch", load="bending", mu=0, points=80)
    turn = int(np.argmax(c.psi.values))
    up, down = c.isel(point=slice(turn + 1)), c.isel(point=slice(turn, None))
    back = np.interp(up.psi, down.psi[::-1], down.M[::-1])
    # tolerance: straight lines between points, 0.3 % measured, on every processor
    np.testing.assert_allclose(back[3:], up.M[3:], rtol=5e-3, atol=1e-4 * float(c.M.max()))
    assert float(abs(c.W_d[0])) < 1e-9


def test_where_the_contact_ends_the_history_is_refused():
    with pytest.raises(InputError, match=r"the contact is followed to .* deg per pitch") as error:
        squama.cycle(PLA, "0.6 rad/pitch", load="bending")
    assert 'twist = "0.6 rad/pitch" (34.3775 deg per pitch)' in str(error.value)
    most = re.search(r'give at most "([\d.]+ deg/pitch)"', str(error.value))
    assert most
    assert float(squama.cycle(PLA, most[1], load="bending").psi.max()) > 0.05
    with pytest.raises(InputError, match="joint"):
        squama.cycle(SKIN, "0.1 rad/pitch", load="bending", joint="glue")


def test_hinges_are_asked_for(capsys):
    hinge = squama.cycle(SKIN, "0.1 rad/pitch", load="bending", joint="hinge")
    assert hinge.attrs["joint"] == "hinge"
    face = SKIN.replace(substrate={"neutral": "face"})
    assert squama.cycle(face, "0.08 rad/pitch", load="bending").attrs["joint"] == "hinge"
    assert (
        main(
            [
                "cycle",
                "examples/stiff_skin.toml",
                "--load",
                "bending",
                "--to",
                "0.1 rad/pitch",
                "--hold",
                "twist, lateral bend",
                "--full",
            ]
        )
        == 0
    )
    out = capsys.readouterr().out
    assert "thick, elastic scales on compliant joints; 25 scales with free ends; twist, lateral bend held" in out
    assert "sense +: first contact at 86.5 deg (3.46 deg per pitch): corner B on face (k = 1)" in out


@pytest.mark.slow
@needs_barrier
def test_general_contact_goes_the_same_way_back():
    c = squama.cycle(SKIN, "0.12 rad/pitch", load="bending", mu=0.25, points=120)
    down = c.isel(point=slice(int(np.argmax(c.psi.values)), None))
    E, d, K = SKIN.substrate.youngs_modulus, SKIN.pitch, joint_of(SKIN).K
    assert K is not None
    led = make_bent(K, geometry(SKIN), 0.25, exposed=surface(compliant.scale(SKIN, ideal=False)))
    for psi, tolerance in ((0.12, 4e-3), (0.115, 4e-3), (0.09, 4e-3), (0.05, 4e-3), (0.0, 1.0)):
        assert led.run(led.aim(psi, 0.0), 1e-3).reached
        own = np.interp(psi, down.psi[::-1], down.M[::-1])
        # tolerance: the barrier of general contact, 0.15 and 0.3 % measured, on every processor
        assert own == pytest.approx(led.columns["M"][-1] * E * d**3, rel=tolerance, abs=1e-6)
    assert float(c.W_d[0]) == pytest.approx(led.columns["W_fr"][-1] * E * d**2, rel=0.015)

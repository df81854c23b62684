"""Beams on compliant joints, bent: both loads along psi, work, slopes, the end, and the command beside the hinge."""

import json
import math

import numpy as np
import pytest

import squama
from squama.beam import matrixfile
from squama.cli import main
from squama.errors import InputError
from squama.joints.choice import joint_of

SKIN = squama.Beam.from_toml("examples/stiff_skin.toml").replace(scales=None).replace(hold="bend, twist, lateral bend")
PLA = squama.Beam.from_toml("examples/pla_on_vps.toml").replace(scales=None).replace(hold="bend, twist, lateral bend")
FAR = "0.12 rad/pitch"


@pytest.fixture(scope="module")
def bent():
    return squama.bend(SKIN, to=FAR, points=121)


def test_it_is_the_way_of_both_loads_along_psi(bent):
    both = squama.bend_twist(SKIN, f"bend {FAR}")
    for name in ("M", "M_scales", "T", "theta", "N", "W_fr", "stress", "pull_out", "stretch"):
        wanted = np.interp(both.psi, bent.psi, bent[name])
        # tolerance: straight lines between 121 points
        np.testing.assert_allclose(wanted, both[name], rtol=0, atol=2e-3 * float(abs(both[name]).max()), err_msg=name)
    for name in ("joint", "scales", "neutral", "K_theta"):
        assert bent.attrs[name] == both.attrs[name]
    assert bent.end.item() == both.end.item() == "range end"
    assert float(bent.psi_e) == pytest.approx(float(both.psi_e), rel=1e-12)
    assert bent.first_contact.item() == "corner B on face (k = 1)"
    assert set(bent.contact.values) == {"", "BF"}


def test_work_is_stored_or_rubbed_away_and_the_tangent_is_the_slope(bent):
    given = np.trapezoid(bent.M, bent.kappa)
    assert given == pytest.approx(float(bent.U_el[-1] + bent.W_fr[-1]), rel=5e-3)
    assert abs(float(bent.energy_error)) < 2e-3
    assert float(bent.W_fr[-1]) > 0.01 * float(bent.U_el[-1])
    apart = bent.psi.values < float(bent.psi_e)
    np.testing.assert_allclose(bent.M_scales.values[apart], 0, atol=1e-12 * float(bent.M.max()))
    np.testing.assert_allclose(bent.K_b.values[apart], bent.attrs["rigidity"], rtol=1e-12)
    slope = np.gradient(bent.M, bent.kappa)[~apart][5:-5]
    np.testing.assert_allclose(bent.K_b.values[~apart][5:-5], slope, rtol=0.03)
    np.testing.assert_allclose(bent.stiffness_ratio, bent.K_b / bent.attrs["rigidity"], rtol=1e-12)
    # it is more than five times as stiff as soon as its scales touch, and not before
    for name in ("psi_twofold", "psi_fivefold"):
        assert float(bent[name]) == pytest.approx(float(bent.psi_e), rel=1e-7)
    free = bent.psi.values < float(bent.psi_e) * (1 - 1e-8)
    assert set(bent.stiffness_ratio.values[free]) == {1.0}
    assert bent.stiffness_ratio.values[~free][0] > 5


def test_what_is_asked_for_is_there_and_nothing_beyond_it(bent):
    d = SKIN.pitch
    r = squama.bend(SKIN, at=[0.1 / d, 0.02 / d], to=FAR)
    np.testing.assert_array_equal(r.psi, [0.1, 0.02])
    np.testing.assert_allclose(r.M, np.interp(r.psi, bent.psi, bent.M), rtol=2e-3)
    assert r.contact.values.tolist() == ["BF", ""]
    short = squama.bend(SKIN, at=[0.01 / d, 5 / d], to="0.02 rad/pitch")
    assert np.isnan(short.M.values).tolist() == [False, True]
    # engagement is told where the curve ends before, and the bar alone bends
    assert float(short.psi_e) == pytest.approx(float(bent.psi_e), rel=1e-3)
    assert short.end.item() == "range end"
    assert float(short.M[0]) == pytest.approx(short.attrs["rigidity"] * 0.01 / d, rel=1e-9)


def test_strongly_bent_scales_touch_with_their_sides_too():
    family = squama.bend(PLA, mu=[0.0, 0.3], points=20)
    assert family.end.values.tolist() == ["range end"] * 2
    assert family.first_contact.values.tolist() == ["corner B on face (k = 1)"] * 2
    assert np.isfinite(family.M).all()
    assert (family.psi_second > 3 * family.psi_e).all()
    assert all("side edge on face (k = 1)" in words for words in family.other_contact.values)
    assert (abs(family.energy_error) < 2e-3).all()


def test_what_only_hinges_have_means_them():
    seven = SKIN.replace(joint={"matrix": matrixfile.stored(SKIN, joint_of(SKIN).K[:7, :7])})
    r = squama.bend(seven, points=5)
    assert r.attrs["joint"] == "hinge"
    assert "joint.matrix holds six motions and the twist" in r.warnings
    assert squama.bend(SKIN, neutral="face", points=5).attrs["joint"] == "hinge"


@pytest.mark.parametrize(
    ("asked", "words"),
    [
        ({"joint": "glue"}, "joint"), ({"joint": "hinge", "ideal": False}, "ideal"), ({"to": 1e4}, "half a turn"),
        ({"neutral": "face", "joint": "compliant"}, "neutral"), ({"at": [1e4]}, "at = 10000 rad/m"),
    ],
)  # fmt: skip
def test_bad_input_is_one_line(asked, words):
    with pytest.raises(InputError) as error:
        squama.bend(SKIN, **asked)
    assert words in str(error.value)
    assert "\n" not in str(error.value)


def test_the_command_sets_simpler_models_beside(bent, capsys):
    how = ["examples/stiff_skin.toml", "--to", FAR, "--hold", "twist, lateral bend", "--ends", "endless"]
    assert main(["bend", *how, "--full"]) == 0
    lines = capsys.readouterr().out.splitlines()
    model = next(line for line in lines if line.startswith("  model "))
    assert model.endswith("; twist, lateral bend held; error of the moment not known")
    (head,) = [line for line in lines if line.split() == ["thick", "scales", "thin,", "rigid", "hinge"]]
    moments = [line for line in lines if line.startswith("  moment M, N ")]
    unit = {"mm": 1e-3, "m": 1.0}[moments[-1].split()[3]]
    own, _, hinge = (unit * float(v) for v in moments[-1].split()[-3:])
    # tolerance: three digits are printed
    assert own == pytest.approx(float(bent.M[-1]), rel=6e-3)
    hinged = squama.bend(SKIN, at=[FAR], joint="hinge")
    assert hinge == pytest.approx(float(hinged.M[0]), rel=6e-3)
    assert lines.index(head) < lines.index(moments[-1])
    assert "first contact: corner B on face (k = 1); the moment's work" in "\n".join(lines)
    # how far the law is off was looked at in twisting
    assert "torque to about" not in "\n".join(lines)
    assert main(["bend", *how, "--json", "--ideal", "--points", "20"]) == 0
    record = json.loads(capsys.readouterr().out)
    assert list(record["laws"]) == ["thin, rigid", "hinge"]
    assert (record["joint"], record["scales"], record["neutral"]) == ("compliant", "thin, rigid scales", "free")
    (off,) = record["derived"]["off"]["hinge"]
    assert math.isfinite(off["torque"])
    assert main(["bend", "examples/stiff_skin.toml", "--neutral", "up"]) == 2
    assert "--neutral" in capsys.readouterr().err


FINGER = squama.Beam(
    scale=squama.Scale(
        length="20 mm", width="16 mm", thickness="0.8 mm", embedded="3 mm", alpha=0, theta0="15 deg",
        youngs_modulus="3 GPa",
    ),
    substrate=squama.Substrate(width="20 mm", thickness="8 mm", youngs_modulus="0.5 MPa", poisson_ratio=0.49),
    pitch="8 mm", scales=15, friction=squama.Friction(mu=0.25),
)  # fmt: skip


@pytest.mark.slow(but=1)
@pytest.mark.parametrize("beam", [FINGER, SKIN.replace(scale={"alpha": 0}, hold="nothing")], ids=["finger", "skin"])
def test_tips_that_lie_flush_bear_as_far_as_asked(beam):
    """Scales straight across the bar press with both corners of a tip and its middle at once, left and right alike."""
    torques = []
    # before, the corners left the edge they lie on, and whether the path went on depended on its points
    for points in (40, 60):
        r = squama.bend(beam, to="0.2 rad/pitch", points=points)
        assert r.end.item() == "range end"
        assert abs(float(r.energy_error)) < 2e-3
        # tolerance: rounding; what is left of it grew to 1e-9
        np.testing.assert_allclose(r.phi, 0, atol=1e-11)
        np.testing.assert_allclose(r.chi, 0, atol=1e-11)
        assert float(r.stiffness_ratio[-1]) > 2
        torques.append(float(r.M[-1]))
    np.testing.assert_allclose(torques, torques[0], rtol=1e-4)

"""squama.twist(joint="compliant") and its command: units, senses, families, and the distance of the hinge."""

import json

import numpy as np
import pytest

pytest.importorskip("ipctk", reason="needs the extra fe")

import squama
from squama import compliant
from squama.cli import main
from squama.fe import condense

# stiffness of the Fig. 6b joint by elements (6467 tetrahedra), over u_X, u_Y, u_Z, w_X, w_Y, w_Z, phi; E = 1, d = 1
LOWER = """
1.11149
0.03757 0.80550
-0.04975 0.00924 1.07382
-0.01040 0.03646 -0.00869 0.17161
-0.01684 0.00088 0.09614 -0.00139 0.02138
0.03558 -0.08809 -0.00634 0.00117 -0.00112 0.15331
-0.02042 0.01149 0.07621 -0.00394 0.00630 -0.00656 0.04997
"""
ROWS = [[float(x) for x in line.split()] for line in LOWER.split("\n") if line]
K = np.array([[ROWS[max(i, j)][min(i, j)] for j in range(7)] for i in range(7)])
BEAM = squama.Beam.from_ratios(eta=3, beta=0.6, lam=0.32, zeta=0.18, slenderness=45, mu=0.2)
UNIT = BEAM.substrate.youngs_modulus * BEAM.pitch**3


@pytest.fixture(autouse=True)
def joint(monkeypatch):
    monkeypatch.setattr(compliant, "matrix", lambda beam: K)


def twist(**options):
    return squama.twist(BEAM, joint="compliant", **options)


def test_the_torques_are_those_of_nonlinear_elements():
    """A medium mesh of the periodic cell at phi = 0.10 (12 000 tetrahedra): T = .00879, .00941, .01049 E d^3."""
    r = twist(mu=[0, 0.2, 0.5], at=[0.1 / BEAM.pitch])
    np.testing.assert_allclose(r["T"].values.ravel() / UNIT, [0.00879, 0.00941, 0.01049], rtol=0.04)
    # the elements engage at .0586
    np.testing.assert_allclose(r.phi_e, 0.0586, rtol=5e-3)


def test_the_dataset_is_the_curve_in_si_units():
    r = twist(points=41)
    c = condense.curve(compliant.rest(BEAM), K, 0.2, np.linspace(0, 0.3, 41))
    d = BEAM.pitch
    np.testing.assert_allclose(r["phi"], c.phi)
    np.testing.assert_allclose(r["Phi"], c.phi / d)
    np.testing.assert_allclose(r["T"], c.T * UNIT)
    np.testing.assert_allclose(r["N"], c.N * UNIT / d)
    np.testing.assert_allclose(r["U_el"], c.U * UNIT / d)
    np.testing.assert_allclose(r["W_fr"], c.W_fr * UNIT / d)
    np.testing.assert_allclose(r["u_X"], c.v[:, 0] * d)
    np.testing.assert_allclose(r["w_Y"], c.v[:, 4])
    np.testing.assert_allclose(r["s"], c.s * d)
    np.testing.assert_allclose(r["RED"][1:], r["W_fr"][1:] / (r["U_el"] + r["W_fr"])[1:])
    np.testing.assert_allclose(r["K_t"][20], (r["T"][21] - r["T"][19]) / (r["Phi"][21] - r["Phi"][19]))
    before = r["phi"] < 0.05
    np.testing.assert_allclose(r["T_scales"][before], 0, atol=1e-9 * float(r["T"].max()))
    assert {v: r[v].attrs["units"] for v in ("u_X", "w_Z", "gap", "T")} == {
        "u_X": "m", "w_Z": "rad", "gap": "m", "T": "N m",
    }  # fmt: skip
    assert (r.attrs["joint"], r.attrs["mu"]) == ("compliant", float(r.mu))
    assert r.attrs["K_theta"] == pytest.approx(0.01263 * UNIT, rel=1e-3)
    assert r["end"].item() == "range end"
    assert r["first_contact"].item() == "tip edge C1B1 on side edge D2C2 (k = 1)"
    assert abs(float(r["energy_error"])) < 1e-3
    assert "mu_lock" not in r


def test_asked_twists_come_back_in_their_order():
    there, back = twist(at=[2.0, 6.0, 4.0]), twist(at=[6.0, 4.0, 2.0])
    np.testing.assert_allclose(there["Phi"], [2.0, 6.0, 4.0])
    np.testing.assert_allclose(there["T"].values[[1, 2, 0]], back["T"])


def test_beyond_a_snap_there_is_nothing():
    r = twist(to="0.4 rad/pitch", points=41)
    assert r["end"].item() == "snap"
    assert 0.32 < float(r["phi_end"]) < 0.35
    np.testing.assert_array_equal(np.isnan(r["T"]), r["phi"] > r["phi_end"])
    assert "small strains" in r.attrs["warnings"]


def test_the_other_sense_gives_magnitudes():
    r = twist(sense="-", points=5)
    assert (r["T"].values[1:] > 0).all()
    assert (r["theta"].values[1:] < BEAM.scale.theta0).sum() == 0
    assert r["phi_e"].item() == np.inf


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"law": "plate"}, 'law = "plate": belongs to joint="hinge"'),
        ({"to": "4 rad/pitch"}, "below half a turn"),
        ({"to": -1.0}, "above 0"),
        ({"mu": -1}, "mu"),
    ],
)
def test_what_cannot_be_is_refused(options, words):
    with pytest.raises(squama.InputError, match=words.replace("(", r"\(")):
        twist(**options)
    with pytest.raises(squama.InputError, match="joint"):
        squama.twist(BEAM, joint="ball")


def test_a_given_stiffness_is_named_as_unused():
    beam = BEAM.replace(joint={"stiffness": "5 kN m"})
    r = squama.twist(beam, joint="compliant", points=3, to="0.02 rad/pitch")
    assert "joint.stiffness: not used" in r.attrs["warnings"]


def test_the_command_says_how_far_the_hinge_holds(tmp_path, capsys):
    file = tmp_path / "beam.toml"
    BEAM.to_toml(file)
    outputs = [str(tmp_path / name) for name in ("a.csv", "a.nc", "a.png")]
    flags = ["--joint", "compliant", "--points", "60", "--csv", outputs[0], "--netcdf", outputs[1]]
    assert main(["twist", str(file), *flags, "--plot", outputs[2], "--to", "0.25 rad/pitch"]) == 0
    said = capsys.readouterr().out
    # hinge by its scaling laws against this matrix, mu = .2
    assert "the hinge is within 5% in torque up to 0.08" in said
    assert "first contact: tip edge C1B1 on side edge D2C2 (k = 1)" in said
    assert "compliant joint" in said
    again = squama.read(outputs[1])
    assert again.attrs["joint"] == "compliant"
    assert squama.read(outputs[0])["w_X"].shape == (60,)


def test_the_command_gives_json(tmp_path, capsys):
    file = tmp_path / "beam.toml"
    BEAM.to_toml(file)
    assert main(["twist", str(file), "--joint", "compliant", "--mu", "0,0.5", "--points", "60", "--json"]) == 0
    record = json.loads(capsys.readouterr().out)
    assert [0.09 < d["within"] < 0.1 for d in record["derived"]["hinge"]["hinge"]] == [True, False]
    assert np.array(record["curve"]["w_X"]).shape == (2, 60)
    assert main(["twist", str(file), "--joint", "ball"]) == 2
    assert "--joint" in capsys.readouterr().err

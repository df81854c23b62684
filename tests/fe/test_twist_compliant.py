"""squama.twist(joint="compliant") and its command: units, senses, families, and the distance of the hinge."""

import json

import numpy as np
import pytest

pytest.importorskip("ipctk", reason="needs the extra fe")

import squama
from squama.cli import main
from squama.curves import compliant
from squama.errors import InputError
from squama.fe import condense
from squama.scene import geometry
from squama.scene.motion import SLIDING, WALKED, Motion, Setting, shape
from squama.web import charts, live, state

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
    np.testing.assert_allclose(r["phi"], c.along["phi"])
    np.testing.assert_allclose(r["Phi"], c.along["phi"] / d)
    np.testing.assert_allclose(r["T"], c.along["T"] * UNIT)
    np.testing.assert_allclose(r["N"], c.along["N"] * UNIT / d)
    np.testing.assert_allclose(r["f0"], r["f"] * BEAM.scale.length / r.attrs["K_theta"])
    np.testing.assert_allclose(r["U_el"], c.along["U_el"] * UNIT / d)
    np.testing.assert_allclose(r["W_fr"], c.along["W_fr"] * UNIT / d)
    np.testing.assert_allclose(r["u_X"], c.along["u_X"] * d)
    np.testing.assert_allclose(r["w_Y"], c.along["w_Y"])
    np.testing.assert_allclose(r["s"], c.along["s"] * d)
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
        ({"law": "plate"}, 'law = "plate": is not covered by joint="compliant"; write law="edge"'),
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


def test_the_picture_of_the_command_is_of_the_same_joint(tmp_path, capsys):
    file, picture = tmp_path / "beam.toml", tmp_path / "a.png"
    BEAM.to_toml(file)
    assert main(["view", str(file), "--joint", "compliant", "-o", str(picture), "--json"]) == 0
    record = json.loads(capsys.readouterr().out)
    assert record["last"] == pytest.approx(Motion(Setting(BEAM, 0.2, joint="compliant")).last)
    assert picture.stat().st_size > 0
    for flag, value in (("--law", "plate"), ("--load", "bending")):
        assert main(["view", str(file), "--joint", "compliant", flag, value, "-o", str(picture)]) == 2
        assert capsys.readouterr().err.startswith(f"squama: error: {flag} = ")


def test_a_picture_goes_along_the_walked_curve():
    motion = Motion(Setting(BEAM, 0.2, joint="compliant"))
    r = squama.twist(BEAM, mu=0.2, joint="compliant", points=WALKED)
    assert str(motion.end) == r.end.item()
    assert (motion.neighbour, motion.load_e) == (int(r.neighbour), float(r.phi_e))
    assert motion.rigidity == r.attrs["rigidity"]
    assert motion.last == pytest.approx(float(r.phi[np.isfinite(r["T"])][-1]))
    i = WALKED // 2
    state = motion.state(float(r.phi[i]))
    assert state[:5] == pytest.approx([float(r[name][i]) for name in ("phi", "theta", "N", "f", "T")], rel=1e-12)
    assert state.name == SLIDING
    assert motion.state(0.5 * motion.load_e)[2:4] == (0.0, 0.0)
    assert motion.state(1.0).load == motion.last
    # friction on the tip points against its sliding along the other scale
    assert np.hypot(*state.slip) > 0
    assert len(motion.samples(12)) == 12
    assert motion.along(5)["load"].tolist() == pytest.approx(np.linspace(0, motion.last, 5).tolist())


@pytest.mark.parametrize("sense", ["+", "-"])
def test_the_scales_are_drawn_where_their_six_motions_put_them(sense):
    shown = Motion(Setting(BEAM, 0.2, joint="compliant", sense=sense))
    at = [0.07, 0.15, 0.25] if sense == "+" else [0.05]
    r = twist(at=np.array(at) / BEAM.pitch, sense=sense)
    d = shape(shown.setting, shown.neighbour)
    for i, load in enumerate(at):
        state, here = shown.state(load), r.isel(point=i)
        # states between the points of the walk are interpolated
        assert state.theta == pytest.approx(here.theta.item(), rel=1e-4)
        assert (state.N, state.f) == pytest.approx((here.N.item(), here.f.item()), rel=1e-3)
        scale = geometry.scale(d, load, state.pose, 0.0)
        moved = [here[name].item() / BEAM.pitch for name in ("u_X", "u_Y", "u_Z")]
        rest = compliant.rest(BEAM)
        assert np.allclose((scale.o - geometry.frame(d, load, 0.0).o) @ rest.axes.T, moved, rtol=0, atol=1e-4)
        if state.name == "sliding":
            c = geometry.contact(d, load, state.attitude, 2.0)
            places = here.p.item() / BEAM.pitch, here.s.item() / BEAM.pitch
            assert (c.p, c.s) == pytest.approx(places, rel=1e-3)
            assert np.linalg.norm(c.point - c.on_tip) < 1e-3, "the edges touch there"
    names = {state.name for state in shown.samples(20)}
    assert names == {"free", "ended"} | ({"sliding"} if sense == "+" else set())


def test_the_picture_and_the_page_show_the_compliant_joint(tmp_path):
    places = [tmp_path / f"{joint}.png" for joint in ("hinge", "compliant")]
    shown = [squama.view(BEAM, p, to="0.2 rad/pitch", joint=p.stem) for p in places]
    assert [one.state.pose is None for one in shown] == [True, False]
    assert places[0].read_bytes() != places[1].read_bytes()
    for other in ({"law": "plate"}, {"load": "bending"}):
        with pytest.raises(InputError, match='is not covered by joint="compliant"'):
            squama.view(BEAM, joint="compliant", **other)


def test_the_explorer_takes_the_compliant_joint():
    now = state.of(BEAM).change("joint", "compliant").change("twist", "0.2")
    assert state.read(state.query(now)) == now
    live.prepare(now)
    shown = live.scene(now)
    assert np.shape(shown["state"]["pose"]) == (3, 3)
    json.dumps([shown, *(charts.line_options(now, plot, dark=False) for plot in charts.PLOTS)], allow_nan=False)
    assert live.outcome(now)[1].startswith("engagement at φ = 0.05")
    assert "u_X (m)" in live.make_file(now, "csv")[1].decode()
    assert "compliant" in live.compared(now)[0]["what"]

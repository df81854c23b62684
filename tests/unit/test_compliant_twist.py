"""squama.twist on compliant joints and its command: units, senses, families, ends, distance of simpler models."""

import json
import re

import numpy as np
import pytest
from fig6b import BEAM

import squama
from squama.beam import matrixfile
from squama.cli import main
from squama.contacts import path
from squama.curves import compliant, compliant_figures
from squama.errors import InputError
from squama.fe.plate import Rest
from squama.joints import choice, factor, law
from squama.scene import geometry
from squama.scene.motion import POINTS, SLIDING, Motion, Setting, shape
from squama.units import moment

UNIT = BEAM.substrate.youngs_modulus * BEAM.pitch**3


def twist(**options):
    return squama.twist(BEAM, **options)


def test_the_torques_are_those_of_nonlinear_elements():
    """A medium mesh of the periodic cell at phi = 0.10 (12 000 tetrahedra): T = .00879, .00941, .01049 E d^3."""
    r = twist(mu=[0, 0.2, 0.5], at=[0.1 / BEAM.pitch], ideal=True)
    np.testing.assert_allclose(r["T"].values.ravel() / UNIT, [0.00879, 0.00941, 0.01049], rtol=0.04)
    # tolerance: a medium mesh, 3 %, on every processor; the elements engage at .0586
    np.testing.assert_allclose(r.phi_e, 0.0586, rtol=5e-3)


def test_what_is_said_of_the_answer():
    """The default: six motions, scales as the beam says; what the model does not cover is the hinge's."""
    steel = BEAM.replace(scale={"youngs_modulus": "200 TPa"})
    for r, joint, scales in (
        (twist(points=3), "compliant", "thick, rigid scales"),
        (twist(points=3, ideal=True), "compliant", "thin, rigid scales"),
        (squama.twist(steel, points=3), "compliant", "thick, elastic scales"),
        (twist(points=3, joint="hinge"), "hinge", "thin, rigid scales"),
        (twist(points=3, joint="hinge", ideal=False), "hinge", "thick, rigid scales"),
        (twist(points=3, law="plate", ideal=False), "hinge", "thin, rigid scales"),
        (squama.bend(BEAM, points=3), "hinge", "thin, rigid scales"),
    ):
        assert (r.attrs["joint"], r.attrs["scales"]) == (joint, scales)
        assert r.attrs.get("joint_source") == ((joint == "compliant" and "matrix") or None)
    assert squama.cycle(BEAM, "0.1 rad/pitch", points=3).attrs["scales"] == "thick, rigid scales"
    assert squama.cycle(BEAM, "0.1 rad/pitch", points=3, ideal=True).attrs["scales"] == "thin, rigid scales"
    assert squama.cycle(BEAM, "0.1 rad/pitch", points=3, law="plate").attrs["joint"] == "hinge"
    assert squama.cycle(BEAM, "0.1 rad/pitch", points=3, load="bending").attrs["joint"] == "hinge"
    plain = squama.twist(BEAM.replace(joint={"matrix": None}), points=3)
    assert plain.attrs["joint_source"] == "law"
    assert 0 < plain.attrs["band"] < 0.05


def test_thick_scales_touch_earlier_and_stiff_ones_are_rigid():
    beam = BEAM.replace(substrate={"youngs_modulus": "25 Pa"})

    def at(E=None, **how):
        return squama.twist(beam.replace(scale={"youngs_modulus": E}), at=[4.0], **how)

    thin, rigid, stiff, soft = at(ideal=True), at(), at("1e15 Pa"), at("2e8 Pa")
    assert float(rigid.phi_e) < float(thin.phi_e)
    assert rigid["T"][0] > thin["T"][0]
    assert float(stiff["T"][0]) == pytest.approx(float(rigid["T"][0]), rel=1e-5)
    assert soft["T"][0] < 0.999 * rigid["T"][0]
    assert 0 < float(stiff["U_plate"][0]) < 3e-5 * float(soft["U_plate"][0])
    assert float(soft["stress"][0]) > 0
    assert np.isnan(rigid["stress"][0])


def test_the_dataset_in_si_units():
    r = twist(points=41, ideal=True)
    np.testing.assert_allclose(r["Phi"], r["phi"] / BEAM.pitch)
    # the point next to engagement is put on it
    assert float(abs(r["phi"] - r.phi_e).min()) == 0
    assert float(r["phi"][-1]) == 0.3
    np.testing.assert_allclose(r["f0"], r["f"] * BEAM.scale.length / r.attrs["K_theta"])
    np.testing.assert_allclose(r["RED"][1:], r["W_fr"][1:] / (r["U_el"] + r["W_fr"])[1:])
    np.testing.assert_allclose(r["U_el"], r["U_joint"] + r["U_plate"] + r["U_bar"])
    np.testing.assert_allclose(r["T"], r["T_scales"] + r.attrs["rigidity"] * r["Phi"])
    np.testing.assert_allclose(r["stiffness_ratio"], r["K_t"] / r.attrs["rigidity"])
    np.testing.assert_allclose(r["K_t"][20], (r["T"][21] - r["T"][19]) / (r["Phi"][21] - r["Phi"][19]), rtol=0.01)
    sliding = r["phi"] > r.phi_e
    np.testing.assert_allclose(r["f"][sliding], 0.2 * r["N"][sliding], rtol=1e-9)
    np.testing.assert_allclose(r["T_scales"][~sliding], 0, atol=1e-9 * float(r["T"].max()))
    # at engagement itself the gap is closed, and nothing presses yet
    np.testing.assert_array_equal(np.isnan(r["s"]), r["phi"] <= r.phi_e)
    assert {v: r[v].attrs["units"] for v in ("u_X", "w_Z", "deflection", "stress", "pull_out", "U_joint", "T")} == {
        "u_X": "m", "w_Z": "rad", "deflection": "m", "stress": "Pa", "pull_out": "N", "U_joint": "J/m", "T": "N m",
    }  # fmt: skip
    assert (r.attrs["joint"], r.attrs["mu"]) == ("compliant", float(r.mu))
    assert r.attrs["K_theta"] == pytest.approx(0.01263 * UNIT, rel=2e-3)
    assert r["end"].item() == "range end"
    assert r["first_contact"].item() == "tip edge on side edge (k = 1)"
    assert abs(float(r["energy_error"])) < 1e-4
    assert "mu_lock" not in r


@pytest.mark.parametrize("points", [30, 40, 60])
def test_the_number_of_points_does_not_change_the_curve(points):
    """Points of the curve may lie a rounding error beside those that are walked."""
    beam = squama.Beam.from_ratios(mu=0.5)
    some, same = (squama.twist(beam, points=n) for n in (points, 200))
    assert (some.end.item(), float(some.phi_end)) == (same.end.item(), pytest.approx(float(same.phi_end)))
    np.testing.assert_allclose(some["T"], np.interp(some.phi, same.phi, same["T"]), rtol=3e-3)


def test_asked_twists_come_back_in_their_order():
    there, back = twist(at=[2.0, 6.0, 4.0]), twist(at=[6.0, 4.0, 2.0])
    np.testing.assert_allclose(there["Phi"], [2.0, 6.0, 4.0])
    np.testing.assert_allclose(there["T"].values[[1, 2, 0]], back["T"])


@pytest.mark.parametrize("ideal", [True, False])
def test_a_contact_that_leaves_its_edge_does_not_end_the_curve(ideal):
    """The tip's corner slips off the side edge at .334 rad per pitch, and the scales jump to another state."""
    whole = twist(to="0.4 rad/pitch", points=41, ideal=ideal)
    r = twist(at=np.linspace(0, 0.4, 41) / BEAM.pitch, ideal=ideal)
    for one in (whole, r):
        assert np.isfinite(one["T"]).all()
        assert one["end"].item() == "range end"
        assert "trust the curve up to" in one.attrs["warnings"]
        lost = one["W_snap"].values
        assert (lost[one["phi"].values < 0.33] == 0).all()
        assert lost[-1] > 0


def test_the_stiffness_right_after_engagement():
    """One point beyond engagement has no third for a slope of second order, but a slope it has."""
    phi_e = float(twist(points=3).phi_e)
    curve = twist(to=0.08 / BEAM.pitch, points=321)
    for at in (phi_e + 1e-4, phi_e + 1e-3):
        alone = float(twist(at=[at / BEAM.pitch]).stiffness_ratio[0])
        assert alone > 1.5  # tolerance: slopes at two places, 0.2 % on every processor
        assert alone == pytest.approx(float(curve.stiffness_ratio[curve.phi > at][0]), rel=0.01)


def test_the_flagship_stiffens_fivefold_within_its_strength():
    beam = squama.Beam.from_toml("examples/stiff_skin.toml").replace(scales=None)
    r = squama.twist(beam, hold="bend, lateral bend", ends="endless")
    assert (r.attrs["joint_source"], r.attrs["scales"], r.attrs["warnings"]) == ("law", "thick, elastic scales", "")
    assert float(r.phi_fivefold) == float(r.phi_e)
    used = r.sel(point=(r.phi >= r.phi_e) & (r.phi <= 2.5 * r.phi_e))
    assert used.stiffness_ratio.min() > 5
    assert r.stress.max() < 0.5 * beam.scale.strength
    assert r.deflection.max() < 0.1 * beam.scale.length


def test_the_other_sense_gives_magnitudes():
    r = twist(sense="-", points=5)
    assert r["end"].item() == "no engagement"
    assert (r["T"].values[1:] > 0).all()
    assert (r["theta"].values[1:] < BEAM.scale.theta0).sum() == 0
    assert r["phi_e"].item() == np.inf


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (
            {"law": "plate", "joint": "compliant"},
            'law = "plate": is not covered by joint="compliant"; write',
        ),
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


def test_a_measured_stiffness_goes_before():
    r = squama.twist(BEAM.replace(joint={"stiffness": "6 kN m"}), points=3)
    assert r.attrs["K_theta"] == pytest.approx(6e3)
    r = squama.twist(BEAM.replace(joint={"inclusion_factor": 1.5}), at=[1.0])
    assert float(r["T"][0]) == pytest.approx(1.5 * BEAM.G_B * BEAM.J)


def test_a_beam_whose_joint_is_not_known_is_on_hinges_and_says_so():
    beam = BEAM.replace(joint={"matrix": None}, scale={"embedded": "91.25 mm"})
    words = r"scale\.embedded = .*: the scale comes out of the substrate's other face, .*"
    with pytest.raises(InputError, match=words + r".*--joint hinge"):
        squama.twist(beam, joint="compliant")
    r = squama.twist(beam, points=5)
    assert r.attrs["joint"] == "hinge"
    first = r.attrs["warnings"].splitlines()[0]
    assert first.startswith("hinges, as the joint is not known: ")
    assert re.search(words, first)
    np.testing.assert_array_equal(r["T"], squama.twist(beam, points=5, joint="hinge", ideal=True)["T"])


def test_twists_that_are_all_but_equal():
    far = 3 * float(squama.twist(BEAM, points=3).Phi_e)
    alone = squama.twist(BEAM, at=[far])
    for off in (1e-4, 1e-8, 1e-12, 0.0):  # tolerance: 1e-4 of the twist is 1.5e-4 of the torque
        pair = squama.twist(BEAM, at=[far, far * (1 + off)])
        np.testing.assert_allclose(pair["T"], float(alone["T"][0]), rtol=3e-4)
        np.testing.assert_allclose(pair["K_t"], float(alone["K_t"][0]), rtol=2e-2)


def test_the_command_says_how_far_simpler_models_hold(tmp_path, capsys):
    file = tmp_path / "beam.toml"
    BEAM.to_toml(file)
    outputs = [str(tmp_path / name) for name in ("a.csv", "a.nc", "a.png")]
    flags = ["--points", "60", "--csv", outputs[0], "--netcdf", outputs[1]]
    assert main(["twist", str(file), *flags, "--plot", outputs[2], "--to", "0.25 rad/pitch", "--full"]) == 0
    said = capsys.readouterr().out
    assert " thick scales " in said
    assert " thin, rigid " in said
    # the thick scales touch at .0565
    assert "hinge: within 5 % in torque up to" in said
    assert "first contact: tip edge on side edge (k = 1)" in said
    assert "six motions, from the beam's matrix; thick, rigid scales" in said
    again = squama.read(outputs[1])
    assert (again.attrs["joint"], again.attrs["scales"]) == ("compliant", "thick, rigid scales")
    assert squama.read(outputs[0])["w_X"].shape == (60,)
    assert main(["twist", str(file), "--ideal", "--to", "0.25 rad/pitch", "--full"]) == 0
    said = capsys.readouterr().out
    assert "thick scales" not in said
    # a hinge with K_theta and C_f of this matrix, mu = .2
    assert re.search(r"hinge: within 5 % in torque up to 5\.[12]\d* deg per pitch", said)


@pytest.mark.parametrize(("ratio", "elements"), [(100, 0.0783), (500, 0.0429), (2000, 0.0192)])
def test_a_tab_that_bends_is_told(ratio, elements):
    """By elements with the printed scale's tab of its own modulus (tools/rigid_tab.py), torque at twice engagement."""
    beam = squama.Beam.from_toml("examples/pla_on_vps.toml").replace(scales=None).replace(hold="bend, lateral bend")
    beam = beam.replace(scale={"youngs_modulus": ratio * beam.substrate.youngs_modulus, "strength": None})
    r = squama.twist(beam, to="0.1 rad/pitch")
    found = re.search(r"the torque is too high by about (\S+) %: .*\(E_s/E\)\(t_s/L\)\^3 = (\S+)", r.attrs["warnings"])
    assert (found is None) == (elements < 0.03)
    if found:  # tolerance: the warning has one digit
        assert float(found[2]) == pytest.approx(ratio * (0.8 / 6) ** 3, rel=0.05)
        assert float(found[1]) / 100 == pytest.approx(elements, rel=0.35)
        assert found[0] in squama.cycle(beam, "0.1 rad/pitch", mu=0, points=3).attrs["warnings"]
    rigid = beam.replace(scale={"youngs_modulus": None})
    for other in (squama.twist(beam, to="0.1 rad/pitch", ideal=True), squama.twist(rigid, to="0.1 rad/pitch")):
        assert "embedded part" not in other.attrs["warnings"]
    # elements have a rigid tab, too; what was measured has the one of the beam
    made = matrixfile.stored(beam, compliant.Held.of(beam).K[:7, :7])
    scaling = {key: made.made[key] for key in matrixfile.SCALING}
    measured = {"matrix": matrixfile.StoredMatrix(made.rows, scaling)}, {"inclusion_factor": beam.C_f}
    for joint, told in (({"matrix": made}, bool(found)), *((one, False) for one in measured)):
        warnings = squama.twist(beam.replace(joint=joint), to="0.1 rad/pitch").attrs["warnings"]
        assert ("embedded part" in warnings) == told


def test_what_a_scale_bears_is_told(tmp_path, capsys):
    file = tmp_path / "beam.toml"
    steel = BEAM.replace(substrate={"youngs_modulus": "0.2 MPa"}, scale={"youngs_modulus": "200 GPa"})
    steel = steel.replace(joint={"matrix": None})
    steel.to_toml(file)
    r = squama.twist(steel, points=60, to="0.25 rad/pitch").isel(point=-1)
    assert main(["twist", str(file), "--points", "60", "--to", "0.25 rad/pitch", "--full"]) == 0
    said = capsys.readouterr().out
    assert float(r.stress_x) == 0
    assert f"largest stress in a scale: {float(r.stress) / 1e6:.3g} MPa at the root, at 14.3 deg per pitch" in said
    way = "pulling out" if r.pull_out > 0 else "pushing in"
    force, pull, bend, twist = (abs(float(r[name])) for name in ("tab_force", "pull_out", "tab_bending", "tab_torsion"))
    assert f"load on the embedded tab of a scale: {force:.3g} N ({pull:.3g} N {way}), " in said
    assert f"bending moment {moment(bend)}, twisting moment {moment(twist)}, at 14.3 deg per pitch" in said
    # rigid scales have no stress
    assert main(["twist", str(file), "--ideal", "--to", "0.25 rad/pitch", "--full"]) == 0
    said = capsys.readouterr().out
    assert "largest stress in a scale:" not in said
    assert "load on the embedded tab of a scale: " in said


def test_the_other_sense_bears_the_mirror_image():
    """alpha turned round, and the twist: forces and bending stay, torsion and places across change sign."""
    beam = BEAM.replace(joint={"matrix": None}, scale={"youngs_modulus": "2e8 MPa"})
    here = squama.twist(beam, at=[4.0, 8.0])
    K = law.stiffness(choice.shape(beam)) * np.outer(factor.MIRROR, factor.MIRROR)
    held = compliant.Held.of(beam)._replace(K=K)
    plate = compliant.scale(beam, ideal=False)._replace(alpha=-beam.scale.alpha)
    one = compliant.Path(beam, held, path.Path.at_rest(plate, K, 0.2, **held.bar), (0.0, -1.0))
    strains = np.array([(0.0, -4.0), (0.0, -8.0)]) * beam.pitch
    there = compliant_figures.values(one, strains, one.way.along(strains).rows[0], turned=-1.0)
    signs = {"stress_y": -1, "tab_torsion": -1, "u_Y": -1}
    same = ("stress", "stress_x", "pull_out", "tab_force", "tab_bending", "M", "stretch")
    for name in (*same, *signs):
        np.testing.assert_allclose(there[name], signs.get(name, 1) * here[name], rtol=1e-3, err_msg=name)


def test_the_command_gives_json(tmp_path, capsys):
    file = tmp_path / "beam.toml"
    BEAM.to_toml(file)
    assert main(["twist", str(file), "--ideal", "--mu", "0,0.5", "--points", "60", "--json"]) == 0
    record = json.loads(capsys.readouterr().out)
    assert list(record["laws"]) == ["thin, rigid", "hinge"]
    assert [0.09 < d["within"] < 0.105 for d in record["derived"]["off"]["hinge"]] == [True, False]
    assert np.array(record["curve"]["w_X"]).shape == (2, 60)
    assert main(["twist", str(file), "--points", "60", "--json"]) == 0
    record = json.loads(capsys.readouterr().out)
    assert list(record["derived"]["off"]) == ["thin, rigid", "hinge"]
    assert record["figures"] == record["laws"]["thick scales"]
    assert main(["twist", str(file), "--joint", "hinge", "--json"]) == 0
    assert list(json.loads(capsys.readouterr().out)["laws"]) == ["edge", "plate"]
    assert main(["twist", str(file), "--joint", "ball"]) == 2
    assert "--joint" in capsys.readouterr().err


@pytest.mark.slow
def test_the_picture_of_the_command_is_of_the_same_joint(tmp_path, capsys):
    file, picture = tmp_path / "beam.toml", tmp_path / "a.png"
    BEAM.to_toml(file)
    assert main(["view", str(file), "--joint", "compliant", "-o", str(picture), "--json"]) == 0
    record = json.loads(capsys.readouterr().out)
    assert record["last"] == pytest.approx(Motion(Setting(BEAM, 0.2, joint="compliant")).last)
    assert picture.stat().st_size > 0
    for flag, value, named in (("--law", "plate", "--law"), ("--load", "bending", "--joint")):
        assert main(["view", str(file), "--joint", "compliant", flag, value, "-o", str(picture)]) == 2
        assert capsys.readouterr().err.startswith(f"squama: error: {named} = ")


def test_a_picture_goes_along_the_walked_curve():
    motion = Motion(Setting(BEAM, 0.2, joint="compliant"))
    r = squama.twist(BEAM, mu=0.2, joint="compliant", points=POINTS)
    assert str(motion.end) == r.end.item()
    assert (motion.neighbour, motion.load_e) == (int(r.neighbour), float(r.phi_e))
    assert motion.rigidity == r.attrs["rigidity"]
    assert motion.last == pytest.approx(float(r.phi[np.isfinite(r["T"])][-1]))
    i = POINTS // 2
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
        # tolerance: states between the points of the walk are interpolated
        assert state.theta == pytest.approx(here.theta.item(), rel=1e-4)
        assert (state.N, state.f) == pytest.approx((here.N.item(), here.f.item()), rel=1e-3)
        scale = geometry.scale(d, load, state.pose, 0.0)
        moved = [here[name].item() / BEAM.pitch for name in ("u_X", "u_Y", "u_Z")]
        rest = Rest.at(BEAM.eta, BEAM.beta, BEAM.lam, BEAM.scale.alpha, BEAM.scale.theta0)
        assert np.allclose((scale.o - geometry.frame(d, load, 0.0).o) @ rest.axes.T, moved, rtol=0, atol=1e-4)
        if state.name == "sliding":
            c = geometry.contact(d, load, state.attitude, 2.0)
            places = here.p.item() / BEAM.pitch, here.s.item() / BEAM.pitch
            assert (c.p, c.s) == pytest.approx(places, rel=1e-3)
            # mid-planes of plates that touch are a thickness apart
            assert np.linalg.norm(c.point - c.on_tip) == pytest.approx(BEAM.scale.thickness / BEAM.pitch, rel=0.05)
    names = {state.name for state in shown.samples(20)}
    # scales that nothing touches are free up to the last
    assert names == ({"free", "sliding", "ended"} if sense == "+" else {"free"})


@pytest.mark.slow
def test_the_picture_and_the_page_show_the_compliant_joint(tmp_path):
    places = [tmp_path / f"{joint}.png" for joint in ("hinge", "compliant")]
    shown = [squama.view(BEAM, p, to="0.2 rad/pitch", joint=p.stem) for p in places]
    assert [one.state.pose is None for one in shown] == [True, False]
    assert places[0].read_bytes() != places[1].read_bytes()
    for other, words in (({"law": "plate"}, "is not covered"), ({"load": "bending"}, "not the bend")):
        with pytest.raises(InputError, match=words):
            squama.view(BEAM, joint="compliant", **other)


def test_engagement_is_told_though_the_curve_ends_before() -> None:
    far, near = (squama.twist(BEAM, to=f"{to} rad/pitch", points=5) for to in (0.2, 0.01))
    assert float(near.phi_e) == pytest.approx(float(far.phi_e), rel=1e-12)
    assert near.end.item() == "range end"
    cycle = squama.cycle(BEAM, "0.01 rad/pitch")
    assert float(cycle.phi_e.sel(sense="+")) == pytest.approx(float(far.phi_e), rel=1e-12)

"""A beam that is held bent while it is twisted: its shape in space, its picture, and the state of the explorer."""

import json
import math

import numpy as np
import pytest
from scipy.linalg import expm

import squama
from squama.cli import main
from squama.errors import InputError
from squama.scene import geometry, picture
from squama.scene.motion import FREE, LOCKED, SLIDING, Motion, Setting, shapes
from squama.web import live, state

SKIN = squama.Beam.from_toml("examples/stiff_skin.toml")
MAIN = squama.Beam.from_ratios(eta=3, beta=1.25, lam=0.45, alpha="45 deg", theta0="10 deg", scales=7)


@pytest.mark.parametrize("k", [-3.0, 0.5, 2.0, 6.0])
@pytest.mark.parametrize(("psi", "phi"), [(0.1, 0.2), (-0.15, 0.3), (1e-6, 1e-5), (0.2, 0.0), (0.0, 0.0)])
def test_cross_sections_lie_on_the_screw_of_bend_and_twist(k, psi, phi):
    d = {"kind": "twisting", "held": psi, "lam": 0.45, "height": 0.45, "sense": 1}
    # the motion whose velocities are constant along the beam, as a matrix exponential
    W = np.zeros((4, 4))
    W[:3, :3] = np.cross(np.eye(3), -np.array([psi, 0.0, phi]))
    W[2, 3] = 1.0
    g = expm(k * W)
    f = geometry.frame(d, phi, k)
    np.testing.assert_allclose(np.column_stack([f.x, f.y, f.z]), g[:3, :3], atol=1e-13)
    np.testing.assert_allclose(f.o, (g @ [0, 0.45, 0, 1])[:3], atol=1e-12)
    if phi == 0 and psi:
        # an arc about the bar's middle, which keeps its length, closing on the scaled face
        middle = f.o - 0.45 * f.y
        np.testing.assert_allclose(middle, [0, (1 - math.cos(k * psi)) / psi, math.sin(k * psi) / psi], atol=1e-12)


@pytest.mark.parametrize(("bend", "sense"), [(0.04, "+"), (-0.05, "+"), (-0.04, "-")])
def test_states_are_those_of_the_path_that_is_bent_and_then_twisted(bend, sense):
    motion = Motion(Setting(MAIN, 0.2, sense=sense, joint="hinge", bend=bend))
    assert motion.model == "thin, rigid scales on hinges, edge law"
    sign = -1 if sense == "-" else 1
    load = 0.9 * motion.last
    path = f"bend {bend} rad/pitch; twist {sign * load!r} rad/pitch"
    r = squama.bend_twist(MAIN, path, mu=0.2, joint="hinge", points=60).isel(point=-1)
    s = motion.state(load)
    assert s.name == (SLIDING if r.contact.item() else FREE)
    assert s.theta == pytest.approx(float(r.theta), rel=5e-3)
    assert pytest.approx(float(r.N), rel=0.06, abs=1e-9) == s.N
    assert s.torque == pytest.approx(sign * float(r["T"]), rel=0.06)
    assert (s.x, s.pose) == (0.0, None)
    end = squama.bend_twist(MAIN, f"bend {bend} rad/pitch; twist {sign} rad/pitch", mu=0.2, joint="hinge")
    assert str(motion.end) == end.end.item()
    assert motion.figures["load_end"] == pytest.approx(sign * float(end.phi_end), rel=1e-9)
    assert motion.state(2 * motion.last).name == (LOCKED if motion.end.locks else "ended")


def test_a_compliant_beam_has_the_pose_of_its_motions():
    motion = Motion(Setting(SKIN, 0.25, bend=-0.01))
    s = motion.state(0.08)
    assert motion.joint == "compliant"
    r = squama.bend_twist(SKIN, "bend -0.01 rad/pitch; twist 0.08 rad/pitch", mu=0.25, ends="endless")
    assert s.theta == pytest.approx(float(r.theta[-1]), rel=2e-3)
    assert s.torque == pytest.approx(float(r["T"][-1]), rel=0.01)
    assert s.pose is not None
    np.testing.assert_allclose(np.linalg.norm(s.pose[1:], axis=1), 1, rtol=1e-3)


@pytest.mark.slow
def test_the_picture_is_of_a_bent_beam(tmp_path, capsys):
    place = tmp_path / "b.png"
    given = ["examples/stiff_skin.toml", "--joint", "hinge", "--twist", "0.1 rad/pitch", "--out", str(place)]
    assert main(["view", *given, "--bend", "0.05 rad/pitch"]) == 0
    assert "sliding; thin, rigid scales on hinges" in capsys.readouterr().out
    bent = place.read_bytes()
    assert main(["view", *given]) == 0
    assert place.read_bytes() != bent
    capsys.readouterr()
    for more, words in (
        (["--bend", "0.9 rad/pitch"], "--bend = 51.57 deg per pitch: is beyond the beam's frictional lock at"),
        (["--bend", "5"], "--bend"), (["--bend", "1 rad/m", "--load", "bending"], "--bend"),
        (["--bend", "1 rad/m", "--law", "plate"], "--bend"),
    ):  # fmt: skip
        assert main(["view", *given, *more]) == 2
        (line,) = capsys.readouterr().err.splitlines()
        assert words in line


def test_what_is_not_named_is_zero(tmp_path, monkeypatch, capsys):
    """A bend alone is a bent beam: it is not twisted on the way to its end."""
    monkeypatch.setattr(picture, "SIZE", (320, 152))
    place = tmp_path / "beam.toml"
    place.write_text(SKIN.to_toml())
    for joint in ("hinge", "compliant"):
        given = ["view", str(place), "--joint", joint, "--bend", "60 deg total", "--json"]
        assert main([*given, "--out", str(tmp_path / "b.png")]) == 0
        told = json.loads(capsys.readouterr().out)
        assert (told["state"]["phi"], told["asked"]) == (0, 0)
        assert told["bend"] == pytest.approx(math.radians(60) / SKIN.scales)
        shown = squama.view(SKIN, bend="60 deg total", joint=joint)
        assert shown.state.theta == pytest.approx(
            squama.bend_twist(SKIN, "bend 60 deg total, twist 0 rad/m", joint=joint, ends="endless").theta[-1]
        )
        assert "Bend 60 deg (2.4 deg per pitch), twist 0 deg (0 deg per pitch) over 25 scales" in repr(shown)
        # both named, both are there; neither, and it is twisted most of the way
        assert squama.view(SKIN, bend="60 deg total", to="30 deg total", joint=joint).state.load > 0
        assert squama.view(SKIN, joint=joint).state.load > 0
    assert main([*given, "--out", str(tmp_path / "b.gif")]) == 2
    assert "nothing moves: a bend is held and no twist is given" in capsys.readouterr().err
    # the explorer's link, too
    start = state.of(state.example())
    link = "&".join(
        part for part in state.query(start.change("bend", "0.05 rad/pitch")).split("&") if part[:6] != "twist="
    )
    assert (state.read(link).twist, state.read(link).bend) == (0, 0.05)


@pytest.mark.parametrize("joint", ["hinge", "compliant"])
@pytest.mark.parametrize("faces", ["mirrored", "turned, shifted"])
def test_both_faces_are_shown_by_the_model_that_answers(faces, joint):
    """Bent, and bent and then twisted: the states are those of the curves, by the same scales and joint."""
    beam = SKIN.replace(faces=faces, scales=None)
    shown = squama.view(beam, load="bending", to="0.14 rad/pitch", joint=None if joint == "compliant" else joint)
    r = squama.bend(beam, at="0.14 rad/pitch", joint=joint)
    same(shown, r, shown.state.torque, r.M, 1e-6)
    assert (shown.state.name, shown.state.other.name) == (SLIDING, FREE)
    assert (shown.state.other.pose is None) == (joint == "hinge")
    # away from the scaled face, the other one closes
    shown = squama.view(beam, bend="-0.14 rad/pitch", to="0.02 rad/pitch", joint=joint)
    r = squama.bend_twist(beam, "bend -0.14 rad/pitch; twist 0.02 rad/pitch", joint=joint).isel(point=[-1])
    same(shown, r, shown.state.torque, r["T"], 0.05)
    assert (shown.state.name, shown.state.other.name) == (FREE, SLIDING)
    held = [design["held"] for design, _ in shapes(shown.motion)]
    assert held == [-0.14, 0.14]


def same(shown, r, torque, wanted, rel):
    """Compare a picture with a curve's point."""
    # tolerance: pictures lie between states of a curve, 0.6 % of a torque at most on every processor
    assert shown.model.startswith(r.attrs["scales"])
    assert {"hinge": "hinges", "compliant": "compliant joints"}[r.attrs["joint"]] in shown.model
    assert shown.state.theta == pytest.approx(float(r.theta[0]), rel=1e-3)
    assert shown.state.other.theta == pytest.approx(float(r.theta_other[0]), rel=1e-3)
    assert torque == pytest.approx(float(wanted[0]), rel=rel)


def test_the_explorer_holds_a_bend():
    start = state.of(state.example())
    bent = start.change("bend", "0.05 rad/pitch")
    assert bent.change("bend", "2.5 rad/m").bend == pytest.approx(bent.bend)
    assert state.read(state.query(bent)) == bent
    assert "bend=" not in state.query(start)
    assert bent.quick
    # as on the bench, with the hinge beside it
    assert live.motion(bent.setting).model == "thick, elastic scales on compliant joints"
    assert bent.beside is not None
    assert live.motion(bent.beside.setting).model == "thin, rigid scales on hinges, edge law"
    assert live.motion(bent.setting).last > 1.2 * live.motion(bent.beside.setting).last
    design = live.scene(bent)["design"]
    assert (design["held"], design["kind"]) == (0.05, "twisting")
    assert "bent by 71.6 deg (2.86 deg per pitch) and twisted" in live.scene(bent)["words"]
    assert any("the map does not include the held bend" in line for line in live.warnings(bent))
    # the wider it is bent the sooner scales touch
    met = [live.motion(start.change("bend", text).setting).load_e for text in ("30", "70", "115")]
    assert met == sorted(met, reverse=True)
    name, table = live.make_file(bent, "csv")
    assert name == "curve.csv"
    assert b'# attribute load: "bending and twisting"' in table
    assert "only loads" in live.loop(bent.change("path", "cycle"))
    # bent alone it has no bend to be held
    assert not bent.change("load", "bending").bent
    for text in ("1440", "x", "nan", "5 rad/pitch"):
        with pytest.raises(InputError, match="Bend held over 25 scales"):
            start.change("bend", text)
    with pytest.raises(InputError, match="is beyond the beam's"):
        live.motion(start.change("bend", "0.9 rad/pitch").setting)


@pytest.mark.parametrize("sense", ["+", "-"])
def test_the_scaled_face_is_shown_as_such_where_the_other_one_touches_first(sense: str) -> None:
    """A curve begins with the face that touches first, a picture with the scaled one."""
    beam = SKIN.replace(faces="mirrored", scales=None)
    state = Motion(Setting(beam, 0.2, sense=sense)).state(0.1)
    r = squama.twist(beam, mu=0.2, at="0.1 rad/pitch", sense=sense)
    leading, open_one = (state, state.other)[:: 1 if sense == "+" else -1]
    assert (leading.name, open_one.name, open_one.N) == (SLIDING, FREE, 0)
    assert leading.theta == pytest.approx(r.theta.item(), rel=1e-3)
    assert open_one.theta == pytest.approx(r.theta_other.item(), rel=1e-3)

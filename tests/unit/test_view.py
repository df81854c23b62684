"""A beam in space: geometry against the oracle, forces against balance and torque, pictures, the stand-alone page."""

from __future__ import annotations

import functools
import json
import math
import re
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import squama
from oracle import twisting
from oracle.vectors import FP, Design, scale
from squama.cli import main
from squama.errors import InputError
from squama.fe import plate
from squama.model.paths import ARRAY
from squama.plot.palette import SCENE, STATES
from squama.scene import geometry, look, picture, standalone
from squama.scene.look import SAMPLES, Canvas
from squama.scene.motion import ENDED, FREE, LOCKED, MOST_SCALES, SCALED, SLIDING, Motion, Setting, shape, shapes

MAIN = squama.Beam.from_ratios(scales=7)
hinged = functools.partial(Setting, joint="hinge")
CASES = [
    hinged(MAIN, 0.5),
    hinged(MAIN, 0.5, law="plate"),
    hinged(MAIN.replace(scale={"alpha": "8 deg"}), 0.2),
    hinged(MAIN.replace(scale={"alpha": "70 deg"}), 0.1),
    # the tip-side pair engages in the other sense too
    hinged(
        squama.Beam.from_ratios(eta=1.0683, beta=0.80579, lam=1.034, alpha=0.15793, theta0=0.11, zeta=0.02),
        0.2,
        sense="-",
    ),
    hinged(MAIN, 0.3, load="bending"),
]
IDS = ["edge", "plate", "flat", "steep", "other sense", "bending"]
FRACTIONS = (0.3, 0.7, 0.99)


def contact_load(motion: Motion, fraction: float) -> float:
    e = motion.load_e
    return e + fraction * (motion.last - e)


@pytest.fixture
def one_pair(monkeypatch):
    """Leave out the test of the plates against each other, which ends some of these paths before."""
    monkeypatch.setattr("squama.arrays.solution.touch", lambda *_, **__: None)


@pytest.mark.parametrize("sense", [1, -1])
def test_scales_are_those_of_the_oracle(sense: int) -> None:
    rng = np.random.default_rng(3)
    for eta, alpha, beta, lam, theta, phi in rng.uniform([1, 0.1, 0.3, 0.1, 0.1, 0], [5, 1.4, 2, 1, 1.6, 1], (20, 6)):
        d = {
            "kind": "twisting",
            "eta": eta,
            "beta": beta,
            "lam": lam,
            "alpha": alpha,
            "half": 1.0,
            "thick": 0.0,
            "sense": sense,
            "held": 0.0,
            "height": lam,
            **SCALED,
        }
        for j in (0, 1, 3):
            ours = geometry.scale(d, phi, theta, j)
            theirs = scale(FP, Design(eta, alpha, beta, lam, 0.1, sense), theta, phi, j)
            # the oracle's first scale stands where twist and place begin, as the one at k = 0 does
            for mine, other in (
                (ours.x, theirs.x),
                (ours.y, theirs.y),
                (ours.z, theirs.z),
                (ours.o, theirs.base),
                (ours.m, theirs.tip),
                (ours.corners, (theirs.D, theirs.A, theirs.B, theirs.C)),
            ):
                assert np.allclose(mine, other, rtol=0, atol=1e-13)


@pytest.mark.parametrize("sense", [1, -1])
def test_a_moved_scale_has_its_pose_in_every_cross_section(sense: int) -> None:
    """The pose that the elements' kinematics give, and the same carried along the helix."""
    eta, beta, lam, alpha, phi = 3.0, 1.2, 0.45, 0.8, 0.2
    rest = plate.Rest.at(eta, beta, lam, alpha, 0.2)
    v = np.array([0.02, -0.01, 0.03, 0.1, 0.3, -0.2])
    base, turn = plate.pose(rest, v)
    d = {
        "kind": "twisting",
        "eta": eta,
        "beta": beta,
        "lam": lam,
        "alpha": alpha,
        "half": 1.0,
        "thick": 0.0,
        "sense": sense,
        "held": 0.0,
        "height": lam,
        **SCALED,
    }
    pose = np.array([base - rest.base, *(turn @ rest.axes[:2].T).T])
    first = geometry.scale(d, phi, pose.tolist(), 0.0)
    xi = np.array([[0, -beta, 0], [0, beta, 0], [eta, beta, 0], [eta, -beta, 0]])
    assert np.allclose(first.corners, base + xi @ rest.axes @ turn.T, rtol=0, atol=1e-13)
    other, turn = geometry.scale(d, phi, pose.tolist(), 3.0), -sense * 3 * phi
    c, s = np.cos(turn), np.sin(turn)
    R = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    assert np.allclose(other.corners, first.corners @ R.T + [0, 0, 3], rtol=0, atol=1e-13)
    # without motion it is the hinge's scale
    still = [np.zeros(3), *rest.axes[:2]]
    assert np.allclose(geometry.scale(d, phi, still, 2.0).corners, geometry.scale(d, phi, 0.2, 2.0).corners)


@pytest.mark.parametrize("setting", CASES, ids=IDS)
@pytest.mark.parametrize("fraction", FRACTIONS)
def test_contact_points_are_where_the_kernel_has_them(one_pair, setting: Setting, fraction: float) -> None:
    motion = Motion(setting)
    d, state = shape(setting, motion.neighbour), motion.state(contact_load(motion, fraction))
    assert state.name == SLIDING
    at = [state.load / setting.beam.pitch]
    if setting.load == "bending":
        r = squama.bend(setting.beam, mu=setting.mu, at=at, joint="hinge")
        p = motion.hinge.row.point(motion.hinge.place(np.array(at) * setting.beam.pitch), "edge", ARRAY).p
        places = p.item() * setting.beam.pitch, r.r.item()
    else:
        r = squama.twist(setting.beam, mu=setting.mu, at=at, law=setting.law, sense=setting.sense, joint="hinge")
        places = r.p.item(), r.s.item()
    c = geometry.contact(d, state.load, state.theta, 1.5)
    assert np.allclose((c.p, c.s), np.array(places) / setting.beam.pitch, rtol=0, atol=1e-9)
    # the two edges do meet there
    assert np.allclose(c.point, c.on_tip, rtol=0, atol=1e-9)
    assert state.theta == pytest.approx(r.theta.item(), rel=1e-12)
    torque = r["M" if setting.load == "bending" else "T"].item()
    assert (state.N, state.f, state.torque) == pytest.approx((r.N.item(), r.f.item(), torque), rel=1e-9)


@pytest.mark.parametrize("setting", CASES, ids=IDS)
@pytest.mark.parametrize("fraction", FRACTIONS)
def test_the_forces_as_drawn_balance_the_joint(one_pair, setting: Setting, fraction: float) -> None:
    """What the neighbours do to a scale turns it about its base as far as its spring is turned."""
    motion = Motion(setting)
    d, state = shape(setting, motion.neighbour), motion.state(contact_load(motion, fraction))
    own = geometry.scale(d, state.load, state.theta, 0)

    def force(k: float) -> tuple[np.ndarray, np.ndarray]:
        n, t = geometry.directions(d, state.load, state.theta, state.slip, k)
        return geometry.contact(d, state.load, state.theta, k).point, state.N * n + state.f * t

    moment = 0.0
    for k, sign in ((0, 1), (-d["neighbour"], -1)):
        place, acting = force(k)
        moment -= sign * float(np.cross(place - own.o, acting) @ own.y)
    lift = motion.stiffness * (state.theta - setting.beam.scale.theta0)
    assert moment * setting.beam.pitch == pytest.approx(lift, rel=1e-8)


@pytest.mark.parametrize("fraction", FRACTIONS)
def test_the_forces_as_drawn_are_the_torque(fraction: float) -> None:
    """By the edge law the moment of a contact about the axis is the scales' part of the torque (virtual work)."""
    motion = Motion(CASES[0])
    d, state = shape(CASES[0]), motion.state(contact_load(motion, fraction))
    n, t = geometry.directions(d, state.load, state.theta, state.slip, 0)
    point = geometry.contact(d, state.load, state.theta, 0).point
    moment = -float(np.cross(point, state.N * n + state.f * t)[2]) * MAIN.pitch
    scales = state.torque - motion.rigidity * state.load / MAIN.pitch
    assert moment == pytest.approx(scales, rel=1e-8)
    # and the oracle, from vectors alone, has it too
    o = twisting.forces(
        state.theta, state.load, Design(MAIN.eta, MAIN.scale.alpha, MAIN.beta, MAIN.lam, MAIN.scale.theta0),
        "edge", 0.5, FP,
    )  # fmt: skip
    assert moment / motion.stiffness == pytest.approx(float(o.torque_direct), rel=1e-8)


def test_the_bar_is_a_twisted_prism_and_a_bent_one_keeps_its_line() -> None:
    d = shape(CASES[0])
    sections, places = geometry.bar(d, 0.2)
    assert places[[0, -1]] == pytest.approx([-3.5, 3.5])
    turned = sections[-1][1] - sections[-1][0]
    assert math.atan2(-turned[1], turned[0]) == pytest.approx(0.7)
    assert np.allclose(np.linalg.norm(sections[:, 1] - sections[:, 0], axis=1), 2 * d["half"])
    b = shape(CASES[-1])
    bent, _ = geometry.bar(b, 0.2)
    chord = 2 * math.sin(0.2 / geometry.STEPS / 2) / 0.2
    assert np.allclose(np.linalg.norm(np.diff(bent.mean(axis=1), axis=0), axis=1), chord)
    face = bent[:, :2].mean(axis=1)
    assert face[-1][1] > face[21][1], "it bends towards its scales"
    kept = shape(CASES[-1]._replace(beam=CASES[-1].beam.replace(substrate={"neutral": "face"})))
    face = geometry.bar(kept, 0.2)[0][:, :2].mean(axis=1)
    assert np.allclose(np.linalg.norm(np.diff(face, axis=0), axis=1), chord)


def test_states_are_named_and_do_not_go_beyond_the_end() -> None:
    locks, leaves = Motion(CASES[0]), Motion(CASES[2])
    assert [locks.state(x).name for x in (0, 0.9 * locks.load_e, 0.2, locks.last, 5)] == [
        FREE, FREE, SLIDING, LOCKED, LOCKED
    ]  # fmt: skip
    assert leaves.state(leaves.most).name == ENDED
    assert locks.state(5).load == pytest.approx(locks.last) == pytest.approx(locks.samples(30)[-1].load)
    static = Motion(hinged(MAIN, 10.0))
    assert static.end == "static lock"
    assert static.state(1.0)[:3] == (static.load_e, MAIN.scale.theta0, 0.0)
    assert static.state(1.0).name == LOCKED
    never = Motion(hinged(squama.Beam.from_ratios(eta=0.5, beta=0.2), 0.2))
    assert never.end == "no engagement"
    assert [never.state(x * never.last).name for x in (0.5, 1, 2)] == [FREE] * 3, "contact alone has a colour"
    assert shape(hinged(MAIN.replace(scales=1000), 0.1))["scales"] == MOST_SCALES


def test_nearer_triangles_hide_farther_ones_however_they_come() -> None:
    camera = look.fitted(np.array([[-1.0, -1, -1], [1, 1, 1]]), 1.0)
    middle = camera.eye - 5 * camera.back
    side = np.array([camera.right, camera.up])

    def triangle(nearer: float) -> np.ndarray:
        return np.array(
            [middle + nearer * camera.back + a * side[0] + b * side[1] for a, b in ((-2, -2), (2, -2), (0, 3))]
        )

    for order in ((0, 1), (1, 0)):
        canvas = Canvas(40, 40, camera, np.ones(3))
        for i in order:
            canvas.triangles(triangle(i)[None], np.eye(3)[i][None])
        assert canvas.pixels()[20, 20].tolist() == [0, 255, 0]
    canvas.triangles(triangle(-1)[None], np.array([[0.0, 0, 1]]), through=True)
    assert canvas.pixels()[20, 20].tolist() == [0, 178, 76]
    assert canvas.colour.shape[0] == 40 * SAMPLES


@pytest.mark.slow
@pytest.mark.parametrize("joint", ["hinge", None])
def test_beam_and_arrows_of_an_animation_are_whole_and_long_enough_to_be_seen(joint, monkeypatch) -> None:
    beam = squama.Beam.from_toml(Path(__file__).parents[2] / "examples/pla_on_vps.toml")
    motion = Motion(CASES[0]._replace(beam=beam, mu=0.25, joint=joint))
    d, cameras = shape(motion.setting, motion.neighbour), []
    monkeypatch.setattr(picture, "fitted", lambda *given: cameras.append(look.fitted(*given)) or cameras[-1])
    states = [motion.state(motion.last * i / 4) for i in range(5)]
    picture._drawn(motion, states, (500, 100))
    picture._drawn(motion, states, (500, 100), forces=False)
    points, arrows = picture._arrows(d, states[-1], 0.25)
    assert [name for name, _ in arrows] == ["normal", "friction"]
    assert 0.5 < np.linalg.norm(arrows[0][1] - points, axis=1).min() < geometry.LONGEST
    for state in states:
        for camera in cameras:
            assert np.abs(camera.seen(look.outline(d, state.at, state.attitude))[:, :2]).max() < 1
        for _, tips in picture._arrows(d, state, 0.25)[1]:
            assert np.abs(cameras[0].seen(tips)[:, :2]).max() < 1
    assert picture._arrows(d, motion.state(0.0), 0.25)[1] == []


def test_a_picture_shows_the_whole_beam_in_the_colour_of_its_state() -> None:
    motion = Motion(CASES[0])
    d = shape(CASES[0])
    for load, colour in ((0.01, "free"), (0.2, "sliding"), (1.0, "locked")):
        state = motion.state(load)
        camera = look.fitted(look.outline(d, state.load, state.theta), 2.0)
        seen = camera.seen(look.outline(d, state.load, state.theta))
        assert 0.8 < np.abs(seen[:, :2]).max() < 0.97, "whole, and not small"
        pixels = picture.render([(d, state)], 0.5, camera, (300, 150)).reshape(-1, 3).astype(float)
        # shaded or not, the hue is that of the state
        wanted = picture._rgb(STATES[colour])
        share = {
            name: np.mean(
                np.linalg.norm(pixels / 255 / np.linalg.norm(pixels / 255, axis=1, keepdims=True)
                               - picture._rgb(value) / np.linalg.norm(picture._rgb(value)), axis=1) < 0.06
            )
            for name, value in STATES.items()
        }  # fmt: skip
        assert share[colour] > 0.05 > max(v for name, v in share.items() if name != colour), (load, wanted)


def test_the_words_of_a_picture_end_before_its_side() -> None:
    beam = squama.Beam.from_toml(Path(__file__).parents[2] / "examples/stiff_skin.toml")
    pixels = np.asarray(picture.draw(Motion(Setting(beam, 0.25, bend=0.1)), 0.16))
    side = pixels[:, round(0.985 * pixels.shape[1]) :]
    assert np.all(side == side[0, -1])


def test_the_function_is_the_command(tmp_path: Path) -> None:
    shown = squama.view(MAIN, tmp_path / "a.png", tmp_path / "a.html", to="0.2 rad/pitch", mu=0.5, law="plate")
    motion = Motion(Setting(MAIN, 0.5, law="plate"))
    assert shown.files == (tmp_path / "a.png", tmp_path / "a.html")
    assert shown.state == motion.state(0.2)
    assert (shown.asked, shown.last, shown.end) == (pytest.approx(0.2), motion.last, motion.end)
    assert np.array_equal(np.asarray(Image.open(tmp_path / "a.png")), np.asarray(picture.draw(motion, shown.asked)))
    bent = squama.view(MAIN, load="bending", mu=0.3)
    assert bent.asked == pytest.approx(0.7 * bent.last)
    assert bent.state.name == SLIDING


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({}, "mu"),
        ({"mu": -1}, "mu = -1"),
        ({"mu": 0.1, "load": "x"}, "load"),
        ({"mu": 0.1, "law": "x"}, "law"),
        ({"mu": 0.1, "to": "-0.1 rad/pitch"}, "to = -"),
        ({"mu": 0.1, "to": "0.1 m"}, 'to = "0.1 m"'),
        ({"mu": 0.1, "margin": 2}, "margin"),
        ({"mu": 0.1, "frames": 1}, "frames = 1"),
        ({"mu": 0.1, "paths": ("a.jpg",)}, "a.jpg"),
    ],
)
def test_what_the_function_cannot_use_is_one_line(given: dict, words: str) -> None:
    paths = given.pop("paths", ())
    beam = squama.Beam.from_ratios()
    with pytest.raises(InputError) as error:
        squama.view(beam, *paths, **given)
    assert str(error.value).startswith(words)
    assert len(error.value.problems) == 1


def test_files_of_the_command(tmp_path: Path, capsys, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(picture, "SIZE", (800, 380))
    monkeypatch.setattr(picture, "SMALL", (400, 200))
    assert main(["new", "beam.toml"]) == 0
    made = ["-o", "a.png", "-o", "a.gif", "-o", "a.html", "--frames", "4"]
    assert main(["view", "beam.toml", "--twist", "0.14 rad/pitch", *made, "--set", "beam.scales=5"]) == 0
    out = capsys.readouterr().out
    assert "beam.toml: twisted by 40.1 deg (8.02 deg per pitch), inclination 15 deg, sliding" in out
    assert out.count("wrote a.") == 3
    still, moving = Image.open("a.png"), Image.open("a.gif")
    assert still.size == picture.SIZE
    assert (moving.n_frames, moving.size) == (4, picture.SMALL)
    frames = [np.asarray(moving.convert("RGB"), float) for i in range(4) if moving.seek(i) is None]
    assert np.abs(frames[0] - frames[2]).mean() > 1
    assert np.abs(frames[1] - frames[3]).mean() < 0.01, "there and back"
    asked = ["view", "beam.toml", "--twist", "3 rad/pitch", "-o", "b.png", "--json", "--dark", "--no-forces"]
    asked += ["--set", "beam.scales=5"]
    assert main([*asked, "--joint", "hinge"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert (told["end"], told["state"]["name"]) == ("frictional lock", "locked")
    assert told["model"] == "thin, rigid scales on hinges, edge law; endless beam"
    assert main(asked) == 0
    thick = json.loads(capsys.readouterr().out)
    assert thick["end"] == "range end"
    assert thick["model"] == "thick, elastic scales on compliant joints; 5 scales with free ends"
    assert told["last"] < thick["last"] <= 0.3, "it goes beyond the lock of hinges, to the limit of a cell"
    assert main([*asked, "--ideal"]) == 0
    assert json.loads(capsys.readouterr().out)["model"].startswith("thin, rigid scales on compliant joints; 5 scales")
    assert told["state"]["phi"] == pytest.approx(told["last"]) != told["asked"]
    still.close()
    moving.close()


def test_bad_input_is_one_line_each_and_writes_nothing(tmp_path: Path, capsys, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["new", "beam.toml"]) == 0
    capsys.readouterr()
    numbers = ["--twist", "0.1", "--law", "x", "--mu", "-1", "--margin", "2", "--frames", "2.5"]
    bad = [*numbers, "-o", "a.jpg", "-o", "beam.toml"]
    assert main(["view", "beam.toml", *bad]) == 2
    lines = capsys.readouterr().err.splitlines()
    starts = ("--mu", "--margin", "--frames", "--law", "a.jpg", "beam.toml", "--twist")
    assert [line.removeprefix("squama: error: ").split(" ")[0].rstrip(":") for line in lines] == list(starts)
    assert main(["view", "beam.toml"]) == 2
    assert main(["view", "none.toml", "-o", "a.png"]) == 2
    assert main(["view", "beam.toml", "-o", "a.png", "--twist", "-0.1 rad/pitch"]) == 2
    assert "--sense -" in capsys.readouterr().err
    assert [p.name for p in tmp_path.iterdir()] == ["beam.toml"]


def test_the_page_of_its_own_has_everything_inside() -> None:
    motion = Motion(CASES[0])
    text = standalone.page(motion, 0.2)
    outside = re.findall(r"""(?:src|href)=["']?([^"' >]+)""", text)
    assert outside == []
    imports = json.loads(re.search(r'<script type="importmap">(.*?)</script>', text)[1])["imports"]
    assert all(value.startswith("data:text/javascript;base64,") for value in imports.values())
    data = json.loads(re.search(r'<script type="application/json" id="data">(.*?)</script>', text)[1])
    # tolerance: the nearest of the states
    assert data["states"][data["first"]]["load"] == pytest.approx(0.2, abs=0.003)
    assert (data["end"], len(data["states"])) == ("frictional lock", standalone.SAMPLES)
    assert data["states"][-1]["name"] == "locked"
    assert data["palette"] == SCENE


def test_without_nicegui_the_page_says_what_to_install(monkeypatch) -> None:
    monkeypatch.setattr("squama.scene.standalone.find_spec", lambda _: None)
    with pytest.raises(InputError, match=r"pip install 'squama\[web\]'"):
        standalone.find()


def test_the_scripts_have_the_same_sizes_and_are_handed_the_colours() -> None:
    folder = Path(geometry.__file__).parent / "js"
    scene, form = ((folder / f"{name}.js").read_text(encoding="utf-8") for name in ("scene", "geometry"))
    assert not any(re.search(r'"#[0-9a-f]{3,6}"', path.read_text(encoding="utf-8")) for path in folder.glob("*.js"))
    assert set(re.findall(r"palette\.(\w+)", scene + (folder / "standalone.js").read_text(encoding="utf-8"))) == set(
        SCENE
    )
    themes = SCENE["themes"]
    for name in re.findall(r"colours\.(\w+)", scene):
        assert name in themes["light"].keys() & themes["dark"].keys()
    assert f"const [HEAD, SHAFT, DOT] = [{picture.HEAD}, {picture.SHAFT}, {picture.DOT}]" in scene
    assert f"STEPS = {geometry.STEPS};" in form
    assert f"LONGEST = {geometry.LONGEST};" in form
    assert f"away *= {look.AWAY};" in scene
    assert all(len(path.read_text(encoding="utf-8").splitlines()) < 350 for path in folder.glob("*.js"))


@pytest.mark.parametrize("faces", ["mirrored", "turned, shifted"])
@pytest.mark.parametrize("load", ["twisting", "bending"])
def test_scales_of_the_other_face_follow_the_same_bar(faces: str, load: str) -> None:
    """Each face's next scale is this one moved by one and the same motion, that of the bar's sections."""
    motion = Motion(hinged(MAIN.replace(faces=faces), 0.2, load=load))
    state = motion.state(0.6 * motion.last)
    (own, _), (other, _) = motion_shapes = shapes(motion)
    a, b = (geometry.frame(own, state.load, k) for k in (0.3, 1.3))

    def middle(f: geometry.Frame) -> np.ndarray:
        return f.o - own["lam"] * f.y

    turn = np.array([b.x, b.y, b.z]).T @ np.array([a.x, a.y, a.z])
    for design, of in motion_shapes:
        one = of(state)
        first, second = (geometry.scale(design, one.load, one.attitude, k).corners for k in (0.3, 1.3))
        assert np.allclose((first - middle(a)) @ turn.T + middle(b), second, rtol=0, atol=1e-12)
    # at rest on the other side of the bar
    up, down = (geometry.scale(design, 0.0, 0.2, 0.0).corners for design in (own, other))
    assert np.allclose(down, up * MAIN.replace(faces=faces).other.S, rtol=0, atol=1e-15)
    assert geometry.first(other) - geometry.first(own) == (0.5 if "shifted" in faces else 0.0)
    beam = MAIN.replace(faces=faces)
    if load == "twisting":
        found = squama.twist(beam, mu=0.2, at=[state.load / beam.pitch], joint="hinge", ideal=True)
        assert state.torque == pytest.approx(found["T"].item(), rel=1e-9)
        assert state.other.theta == pytest.approx(found.theta_other.item(), rel=1e-9)
    else:
        assert (state.name, state.other.name) == (SLIDING, FREE)

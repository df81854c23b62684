"""Pictures of a beam with ends: each scale as it stands, the torque of `squama.twist`, the screws of the cells."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import expm

import squama
from squama.cli import main
from squama.loads import LOADS
from squama.scene import geometry
from squama.scene.motion import FREE, SLIDING, Motion, Setting, shapes

SKIN = squama.Beam.from_toml(Path(__file__).parents[2] / "examples/stiff_skin.toml").replace(scales=6)
TO = {"twisting": "0.12 rad/pitch", "bending": "0.1 rad/pitch"}


def drawn(load: str = "twisting", ends: str | None = None, beam: squama.Beam = SKIN) -> tuple[squama.View, dict]:
    """Return a view, and the design that the geometry needs."""
    seen = squama.view(beam, to=TO[load], load=load, ends=ends)
    return seen, shapes(seen.motion)[0][0]


@pytest.mark.parametrize(
    ("load", "ends"), [("twisting", "free"), ("twisting", "gripped"), ("twisting", "couple"), ("bending", "free")]
)
def test_the_picture_has_the_torque_of_the_curve(load: str, ends: str) -> None:
    seen, _ = drawn(load, ends)
    curve = (squama.twist if load == "twisting" else squama.bend)(SKIN, to=TO[load], ends=ends, points=121)
    kind = LOADS[load]
    assert seen.state.torque == pytest.approx(float(curve[kind.torque][-1]), rel=1e-9)
    assert [one.N for one in seen.state.each][:-1] == pytest.approx(curve.N[-1, :-1].values.tolist(), rel=1e-9)
    assert seen.model.endswith(f"6 scales {'under a couple at the ends' if ends == 'couple' else f'with {ends} ends'}")
    assert seen.state.name == SLIDING
    assert seen.last == pytest.approx(seen.asked)


def test_without_ends_it_is_the_endless_beam() -> None:
    seen, _ = drawn(ends="endless")
    assert seen.state.each is None
    curve = squama.twist(SKIN, at=["0.12 rad/pitch"], ends="endless")
    # tolerance: between 121 points of the curve
    assert seen.state.torque == pytest.approx(float(curve["T"][0]), rel=1e-3)
    assert seen.model.endswith("; endless beam")
    assert drawn(beam=SKIN.replace(scales=70))[0].state.each is None


def test_sections_are_moved_by_the_screws_of_the_cells() -> None:
    """Against exponentials of the cells' screws from end to end, from where the middle section is."""
    cells = tuple(map(tuple, np.random.default_rng(4).normal(0, 0.1, (5, 4)).tolist()))
    _, d = drawn()
    d = d | {"scales": 5}
    frames = [np.eye(4)]
    for own in cells:
        frames.append(frames[-1] @ expm(_screw(own)))
    middle = frames[2] @ expm(_screw(cells[2]) / 2)
    for i, one in enumerate(frames):
        seen, moved = geometry.frame(d, cells, i - 2.5), np.linalg.inv(middle) @ one
        np.testing.assert_allclose(np.array([seen.x, seen.y, seen.z]).T, moved[:3, :3], atol=1e-12)
        np.testing.assert_allclose(seen.o - d["lam"] * seen.y, moved[:3, 3], atol=1e-12)
    alike = ((0.1, 0.2, -0.1, 0.02),) * 5
    for k in (-2.5, -1.0, 0.3, 2.0):
        for mine, other in zip(geometry.frame(d, alike, k), geometry.frame(d, alike[0], k), strict=True):
            np.testing.assert_allclose(mine, other, atol=1e-12)


def _screw(own: tuple[float, ...]) -> np.ndarray:
    psi, phi, chi, eps = own
    return np.array([[0, phi, -chi, 0], [-phi, 0, psi, 0], [chi, -psi, 0, 1 + eps], [0, 0, 0, 0]])


@pytest.mark.parametrize("load", TO)
def test_every_scale_touches_its_neighbour_where_the_arrow_begins(load: str) -> None:
    seen, d = drawn(load)
    state = seen.state
    points = 0
    for i in range(d["scales"] - d["neighbour"]):
        one, two = state.of(i), state.of(i + d["neighbour"])
        if one.name == FREE or not one.N > 0:
            continue
        k, stand = geometry.first(d) + i, geometry.Stand(two.attitude, two.bent)
        place = geometry.contact(d, state.at, one.attitude, k, one.bent, stand).point
        body = geometry.scale(d, state.at, two.attitude, k + d["neighbour"])
        u, v, w = (place - body.o) @ np.transpose([body.x, body.y, body.z])
        lifted = geometry.lift(d, two.bent, np.array([u]), np.array([v])).item() if two.bent else 0.0
        # tolerance: scales of a beam with ends touch somewhere along their edges, to a hundredth of the pitch
        assert w == pytest.approx(d["thick"] / 2 + lifted, abs=0.01)
        assert 0 < u < d["eta"]
        points += 1
    assert points >= 4


def test_a_scale_that_nobody_touches_is_free() -> None:
    far = squama.twist(SKIN, points=3).phi_e.item()
    motion = Motion(Setting(SKIN, 0.25, ends="free"))
    assert {one.name for one in motion.state(0.5 * far).each} == {FREE}
    assert {one.name for one in motion.state(0.8 * motion.last).each} == {SLIDING}


def test_the_command_names_the_ends(tmp_path, monkeypatch, capsys) -> None:
    monkeypatch.chdir(tmp_path)
    Path("beam.toml").write_text(SKIN.to_toml())
    assert main(["view", "beam.toml", "--twist", TO["twisting"], "--ends", "gripped", "-o", "a.png"]) == 0
    assert "; 6 scales with gripped ends" in capsys.readouterr().out
    assert main(["view", "beam.toml", "--twist", TO["twisting"], "--ends", "glued", "-o", "a.png"]) == 2
    assert "--ends" in capsys.readouterr().err


def test_on_hinges_the_view_is_endless_and_says_so() -> None:
    assert squama.view(SKIN, joint="hinge").model.endswith("endless beam")
    with pytest.raises(squama.InputError, match="the view is of an endless beam; leave it out"):
        squama.view(SKIN, joint="hinge", ends="equal")

"""Parts under load in space: sections where the result has them, scales in contact, files."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import squama
from squama.cli import main
from squama.part import door
from squama.scene import geometry, picture
from squama.scene.motion import FREE, SLIDING
from squama.scene.part_motion import PartMotion

SKIN = squama.Beam.from_toml("examples/stiff_skin.toml").replace(scales=6)
"""A short part of an example."""


@pytest.mark.parametrize(("load", "support"), [("20 mm up at tip", "clamped"), ("10 mm down at middle", "simple")])
def test_sections_and_scales_are_where_the_result_has_them(load: str, support: str) -> None:
    answer, told = door.followed(squama.Part(SKIN, load, support), points=8)
    motion, r = PartMotion(answer, told), answer.dataset()
    d, state = motion.shape(), motion.state(motion.last)
    middles = [np.array([f.o - d["lam"] * f.y for f in _frames(d, motion.state(p).at)]) for p in (0.0, motion.last)]
    places = np.stack([r[f"{name}_axis"].values[[0, -1]] for name in "xyz"], axis=-1) / SKIN.pitch
    if support == "clamped":
        moved, own = places[1] - places[0], middles[1] - middles[0]
    else:
        # rollers let the part move as a whole: distances between sections
        moved, own = (np.linalg.norm(v[1:] - v[:-1], axis=-1) for v in (places[1], middles[1]))
    assert np.abs(moved).max() > 0.5
    np.testing.assert_allclose(own, moved, atol=1e-9)
    assert state.name == SLIDING
    N = np.nan_to_num(r.N.values[-1])
    assert [one.name for one in state.each] == [SLIDING if v else FREE for v in (N > 0) | (np.roll(N, 1) > 0)]
    assert {one.name for one in motion.state(0.0).each} == {FREE}


def _frames(d: dict, cells: tuple) -> list[geometry.Frame]:
    return [geometry.frame(d, cells, k - d["scales"] / 2) for k in range(d["scales"] + 1)]


def test_graded_scales_stand_as_their_own_beams() -> None:
    part = squama.Part(SKIN, "1 mm up at tip", along={"scale.theta0": ["20 deg", "22 deg"]})
    motion = squama.view_part(part, points=3).motion
    rises = [np.arcsin(one.pose[1][1]) for one in motion.state(0.0).each]
    np.testing.assert_allclose(np.degrees(rises), np.linspace(20, 22, 6), atol=1e-9)


def test_scales_of_different_sizes_are_refused() -> None:
    part = squama.Part(SKIN, "1 mm up at tip", along={"scale.length": ["30 mm", "25 mm"]})
    with pytest.raises(squama.InputError, match=r"scale\.length: differs along the part"):
        squama.view_part(part, points=3)


@pytest.mark.parametrize(
    ("part", "given", "words"),
    [
        (SKIN, {}, "load: must be 1 to 12 texts"),
        ("skin.toml", {}, "is a text, not a beam"),
        (squama.Part(SKIN, "1 mm up at tip"), {"frames": 1}, "frames = 1: must be"),
    ],
)
def test_what_is_no_part_is_refused(part, given, words) -> None:
    with pytest.raises(squama.InputError, match=words):
        squama.view_part(part, **given)
    with pytest.raises(squama.InputError, match="not a path"):
        squama.view_part(part, 3)


def test_the_command_draws_the_part(tmp_path, monkeypatch, capsys) -> None:
    monkeypatch.chdir(tmp_path)
    # the sizes of pictures have a test of their own
    monkeypatch.setattr(picture, "SIZE", (320, 152))
    monkeypatch.setattr(picture, "SMALL", (160, 80))
    Path("skin.toml").write_text(SKIN.to_toml())
    files = [flag for name in ("a.png", "a.gif", "a.html") for flag in ("--view", name)]
    assert main(["load", "skin.toml", "--load", "20 mm up at tip", "--points", "4", *files]) == 0
    assert "wrote a.html" in capsys.readouterr().out
    with Image.open("a.gif") as made:
        assert made.n_frames > 10
    data = json.loads(re.search(r'<script[^>]*id="data"[^>]*>(.*?)</script>', Path("a.html").read_text(), re.S)[1])
    assert data["design"]["still"] == -3
    assert data["angle"] == "load"
    assert data["states"][-1]["words"].startswith("100 % of the load: ")
    assert main(["load", "skin.toml", "--load", "20 mm up at tip", "--view", "a.mp4"]) == 2
    assert "a.mp4: the extension .mp4 is not known" in capsys.readouterr().err

"""Scales as bodies in a view: as thick and bent as the model has them, on a bar that bows."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

import squama
from squama.plot.palette import THEMES
from squama.scene import geometry, look, picture
from squama.scene.motion import SLIDING, Motion, Setting, shape, shapes

HINGED = Setting(squama.Beam.from_ratios(scales=7), 0.5, joint="hinge")
PRINTED = "pla_on_vps", "stiff_skin"
LOADED = {
    "twisted": {},
    "bent": {"load": "bending"},
    "both faces": {"faces": "mirrored, shifted"},
    "both faces slide": {"faces": "turned, shifted"},
}


def clearance(d: dict, state, bent: list[float] | None) -> float:
    """Return the least distance of places on the lower side of a scale from the upper side of its next three."""
    x, y = (v.ravel() for v in np.meshgrid(np.linspace(0, d["eta"], 61), d["beta"] * np.linspace(-1, 1, 61)))
    own, least = np.zeros_like(x) if bent is None else geometry.lift(d, bent, x, y), math.inf
    one = geometry.scale(d, state.at, state.attitude, 0.0)
    low = one.o + np.column_stack([x, y, own - d["thick"] / 2]) @ [one.x, one.y, one.z]
    for k in (1, 2, 3):
        two = geometry.scale(d, state.at, state.attitude, float(k))
        u, v, w = ((low - two.o) @ np.transpose([two.x, two.y, two.z])).T
        over = (u >= 0) & (u <= d["eta"]) & (np.abs(v) <= d["beta"])
        gap = w - d["thick"] / 2 - (0.0 if bent is None else geometry.lift(d, bent, u, v))
        least = min(least, float(gap[over].min(initial=math.inf)))
    return least


@pytest.mark.parametrize("name", PRINTED)
@pytest.mark.parametrize("case", LOADED)
def test_plates_touch_as_drawn_and_do_not_pass_through_each_other(name: str, case: str) -> None:
    """What is drawn is the beam of the contact solver: its strains, poses, thickness and deflections."""
    beam, more = squama.Beam.from_toml(Path(__file__).parents[2] / f"examples/{name}.toml"), dict(LOADED[case])
    if faces := more.pop("faces", ""):
        beam = beam.replace(faces=faces)
    motion = Motion(Setting(beam, 0.25, **more))
    state = motion.state(0.6 * motion.last)
    (d, of), *_ = shapes(motion)
    own = of(state)
    assert own.name == SLIDING
    # as near as places lie beside each other
    assert -1e-6 < clearance(d, own, own.bent) < 0.01
    flat = clearance(d, own, None)
    assert flat < -0.003, "bent plates that are drawn flat pass through each other"
    if name == "stiff_skin" and case == "twisted":
        assert abs(clearance(d, own._replace(strains=None), own.bent)) > 0.02, "a beam that bows is drawn straight"
    # the point of the contact lies on the next scale's face, of each face that slides
    sliding = [(d, one) for d, of in shapes(motion) if (one := of(state)).name == SLIDING]
    assert len(sliding) == (2 if case == "both faces slide" else 1)
    for d, one in sliding:
        point = geometry.contact(d, one.at, one.attitude, 0.0, one.bent).point
        two = geometry.scale(d, one.at, one.attitude, float(d["neighbour"]))
        u, v, w = ((point - two.o) @ np.transpose([two.x, two.y, two.z])).T
        lifted = geometry.lift(d, one.bent, np.array([u]), np.array([v])).item()
        # tolerance: the curve is interpolated, 3e-8 measured in bending, on every processor
        assert w == pytest.approx(d["thick"] / 2 + lifted, abs=1e-6)
        assert 0 < u < d["eta"]
        assert abs(v) < d["beta"] + 1e-9


def test_forces_of_the_face_behind_the_bar_are_pale(monkeypatch) -> None:
    """Seen from straight above, no force of the lower face has its full colour."""
    beam = squama.Beam.from_toml(Path(__file__).parents[2] / "examples/stiff_skin.toml")
    motion = Motion(Setting(beam.replace(faces="turned", scales=4), 0.25))
    state = motion.state(0.6 * motion.last)
    faces = [(d, of(state)) for d, of in shapes(motion)]
    assert all(picture._arrows(*face, 0.25)[1] for face in faces)
    monkeypatch.setattr(look, "LOOK", np.array([0.02, 1.0, 0.03]))
    camera = look.fitted(np.concatenate([look.outline(d, one.at, one.attitude) for d, one in faces]), 2.0)

    def full(seen: list, name: str) -> int:
        pixels = picture.render(seen, 0.25, camera, (600, 300))
        colour = np.round(255 * picture._rgb(THEMES["light"][name]))
        return np.count_nonzero((pixels == colour).all(axis=2))

    above = full(faces[:1], "normal")
    # 40 % more with the lower one's
    assert 100 < above == full(faces, "normal")
    # friction is drawn over all that is there, of both
    assert full(faces, "friction") > 1.2 * full(faces[:1], "friction") > 0


def test_the_body_of_a_scale_is_closed() -> None:
    """Every side of a face has another face behind it; thin scales are surfaces."""
    d = shape(HINGED, thick=0.1)
    for bent, faces in ((None, 6), ([0.01 * i for i in range(24)], 2 * 12 + 16)):
        plate = geometry.plate(d, bent)
        assert len(plate.faces) == faces
        sides = np.sort(np.stack([plate.faces, np.roll(plate.faces, -1, axis=1)], axis=2).reshape(-1, 2), axis=1)
        assert np.all(np.unique(sides, axis=0, return_counts=True)[1] == 2)
        assert len(plate.edges) == (12 if bent is None else 2 * 16 + 4)
        assert np.ptp(plate.points[:, 2]) >= 0.1
    assert len(geometry.plate(shape(HINGED), None).faces) == 1


@pytest.mark.parametrize("pitch", [0.002, 0.0177, 3.0])
def test_the_scale_bar_is_as_long_as_it_says(pitch: float) -> None:
    """In the middle of the beam, across the view."""
    motion = Motion(HINGED)
    camera = look.fitted(look.outline(motion.shape(), 0.0, 0.2), 2.0)
    words, long = picture._scale_bar(pitch, camera, (1000, 500))
    metres = float(words.split()[0]) * {"m": 1.0, "mm": 1e-3}[words.split()[1]]
    ends = camera.middle + np.outer([-0.5, 0.5], camera.right) * metres / pitch
    across = camera.seen(ends)[:, 0] * 500
    assert across[1] - across[0] == pytest.approx(long, rel=1e-12)
    assert 1000 / 20 < long <= 1000 / 7


@pytest.mark.slow
def test_a_picture_has_the_name_of_its_beam_and_what_is_drawn_flat() -> None:
    beam = squama.Beam.from_toml(Path(__file__).parents[2] / "examples/stiff_skin.toml").replace(scales=3)
    motion = Motion(Setting(beam, 0.25))
    plain, named = (np.asarray(picture.draw(motion, 0.1, name)) for name in ("", "limb"))
    differs = (plain != named).any(axis=(1, 2))
    assert differs.any()
    assert np.flatnonzero(differs).max() < picture.SIZE[1] // 16, "above the beam alone"
    assert "drawn flat" not in motion.title("")
    assert Motion(Setting(beam, 0.25, bend=0.05)).title("A").endswith(", drawn flat")

"""What the explorer's map and headline say of a design, beside the package's own answers."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest

import squama
from squama.loads import LOADS
from squama.web import live, map, state  # noqa: A004

PLA = state.preset("pla")


@pytest.mark.parametrize("joint", ["hinge", "compliant"])
@pytest.mark.parametrize("ideal", ["yes", "no"])
def test_the_map_has_the_plates_of_the_outcome(joint: str, ideal: str) -> None:
    now = state.preset("pla").change("joint", joint).change("ideal", ideal)
    key = map.key(now, "mu", "alpha")
    thick = "thick, rigid scales" if joint == "hinge" else "thick, elastic scales"
    found, scales = map.grid(key), "thin, rigid scales" if ideal == "yes" else thick
    assert key.scales == scales
    assert scales in map.options(key, found, dark=False)["aria"]["label"]["description"]
    row = 24 if joint == "hinge" else 16
    design = map.take(now, "mu", "alpha", (9, row))
    m = live.motion(design.setting)
    assert found.load_e[row, 9] == pytest.approx(m.figures["load_e"], rel=3e-4)
    if joint == "hinge":
        assert found.figure[row, 9] == pytest.approx(m.figures["RED_c"], rel=1e-3)
        return
    # the beam's own: its tangent stiffness at the twist that is shown
    r = squama.twist(design.beam, at=[f"{now.twist} rad/pitch"], ideal=ideal == "yes", ends="endless")
    assert found.figure[row, 9] == pytest.approx(r.stiffness_ratio.item(), rel=1e-2)
    low, high = (1, *map.LEVELS)[found.code[row, 9] - 2], (*map.LEVELS, math.inf)[found.code[row, 9] - 2]
    assert low <= found.figure[row, 9] < high
    # another twist is another map; beyond the law of the joint, and below engagement, nothing is claimed
    assert map.key(now.change("twist", "0.05 rad/pitch"), "mu", "alpha") != key
    assert map.key(now.change("scale_modulus", "9"), "mu", "alpha") != key
    assert map.CLASSES[found.code[-1, 9]] == "not computed"
    assert map.CLASSES[found.code[0, 9]] == "not in contact"
    assert not map.take(now, "mu", "alpha", (9, map.SIZE[1] - 1)).quick


def test_the_map_tells_beams_that_soften_from_curves_that_end(monkeypatch) -> None:
    monkeypatch.setattr(map, "SIZE", (2, 2))

    def classes(now: state.State, **ranges: tuple[float, float]) -> tuple[map.Key, map.Grid, list[list[str]]]:
        monkeypatch.setattr(map, "RANGES", ranges)
        key = map.key(now, *ranges)
        # not one that is kept of another size
        found = map.grid.__wrapped__(key)
        return key, found, [[map.CLASSES[code] for code in row] for row in found.code]

    overlap, steep = 5.642857, 10.30556
    key, found, words = classes(PLA.change("twist", "0.2 rad/pitch"), eta=(3.0, overlap), theta0=(2.0, steep))
    assert words[0] == ["not computed"] * 2
    assert words[1][1] == "softer than the bar"
    assert words[1][0] in map.CLASSES[2:-2]
    # there the torque falls: a snap lies between this twist and the next increment
    beam = PLA.beam.replace(scale={"length": overlap * PLA.beam.pitch, "theta0": math.radians(steep)})
    r = squama.twist(beam, at=["0.2 rad/pitch", "0.2035 rad/pitch"], ends="endless")
    assert r["T"].values[1] < r["T"].values[0]
    assert {"softer than the bar", "not computed"} < set(map.classes(key, found, dark=False))
    bent = PLA.change("load", "bending").change("twist", "0.2 rad/pitch")
    key, found, words = classes(bent, mu=(0.25, 10 / 9), alpha=(2.0, 60.0))
    assert words[0][1] == "ends before this load"
    r = squama.bend(PLA.beam.replace(scale={"alpha": "2 deg"}), mu=10 / 9, to="0.3 rad/pitch", ends="endless")
    assert found.load_end[0, 1] == pytest.approx(r.psi_end.item(), rel=1e-3)
    assert r.psi_end.item() < 0.2
    assert np.isnan(found.load_end).sum() == 3
    cells = map.options(key, found, dark=True)["series"][0]["data"]
    first, end = (math.degrees(v[0, 1]) for v in (found.load_e, found.load_end))
    told = [25 * first, 25 * end, None, first, end]
    assert cells[1][3:] == [None if v is None else pytest.approx(v, rel=6e-3) for v in told]


def test_a_torque_that_falls_is_told() -> None:
    # at a snap
    now = PLA.change("eta", "5.64286").change("theta0", "10.3056").change("twist", "0.2 rad/pitch")
    assert live.motion(now.setting).value("stiffness_ratio", 0.2) < 0
    assert ", the torque falls at 286 deg" in live.verdict(now)


@pytest.mark.parametrize(
    ("load", "scales", "ends", "words"),
    [
        ("twisting", 6, None, "Your 6 scales with free ends carry about 12 % less torque there"),
        ("twisting", 6, "gripped", "Your 6 scales with gripped ends carry about 12 % less torque there"),
        ("bending", 9, None, "Your 9 scales with free ends carry about 2.9 % less moment there"),
    ],
)
def test_the_headline_tells_what_the_beams_own_scales_carry(load, scales, ends, words) -> None:
    # at twice the engagement, or near it
    now = PLA.change("load", load)._replace(beam=PLA.beam.replace(scales=scales, ends=ends), twist=0.0656)
    assert live.own_scales(now) == words
    door, at = (squama.twist if load == "twisting" else squama.bend), [f"{now.twist} rad/pitch"]
    own, endless = (door(now.beam, at=at, **more)[LOADS[load].torque].item() for more in ({}, {"ends": "endless"}))
    # tolerance: one state of the row beside the row that is followed, 7e-5 measured; the ends take 3 % or more
    assert live.share(now.setting, now.twist) == pytest.approx(own / endless, abs=3e-3)
    # nothing is said of an endless beam, of hinges, or where nothing touches
    for other in (now._replace(beam=now.beam.replace(scales=None)), now.hinged, now.change("twist", "0.01 rad/pitch")):
        assert live.own_scales(other) == ""
        assert live.verdict(other).startswith("Endless beam: ")


def test_marks_of_designs_at_one_place_stand_apart() -> None:
    now = PLA.keep()
    for eta in ("2", "2.5"):
        now = now.change("eta", eta).keep()
    found = map.marks(now, map.key(now, "mu", "alpha"))
    assert [mark.letter for mark in found] == ["A", "B", "C", ""]
    assert len({mark.left for mark in found}) == 1
    shifts = sorted(mark.shift for mark in found)
    assert min(b - a for a, b in itertools.pairwise(shifts)) >= 17, "wider than a mark"
    assert found[-1].shift == 0, "the one that is shown is where it belongs"
    apart = map.marks(now, map.key(now, "eta", "alpha"))
    assert [mark.shift for mark in apart if mark.letter != "C"] == [0, 0, 0]

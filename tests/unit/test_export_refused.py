"""What cannot be printed or assembled is refused with its dimension; what the message advises is taken."""

from __future__ import annotations

import math
import re

import numpy as np
import pytest

from squama.errors import InputError
from squama.fabrication import kinds, refuse, solids
from squama.fabrication.plan import Plan

GOOD = Plan(32, 16, 20, 5, 60, 6, 24, 0.8, math.radians(60), math.radians(15))
FIELDS = {
    "scale.thickness": "thickness",
    "scale.width": "breadth",
    "scale.length": "length",
    "scale.embedded": "embedded",
    "beam.pitch": "pitch",
    "substrate.width": "width",
    "ends": "ends",
    "bed": "bed",
    "wall": "wall",
    "draft": "draft",
}
ALL = kinds.PARTS
BEAM = ("scale", "substrate", "assembly")


def lines(plan, parts=ALL):
    try:
        refuse.check(plan, parts)
    except InputError as error:
        return str(error).splitlines()
    return []


CASES = [
    ({"thickness": 0.3}, "scale.thickness = 0.3 mm: is less than the least size that can be printed"),
    ({"breadth": 0.3, "thickness": 0.2, "feature": 0.35}, "scale.width = 0.3 mm: is less than the least"),
    ({"breadth": 0.7}, "scale.width = 0.7 mm: is no more than the thickness, 0.8 mm"),
    ({"length": 0.1}, "scale.length = 0.1 mm: is less than the least"),
    ({"bed": 60.0}, "scale.length = 60 mm: with its tab of 6 mm the scale is longer than the bed, 60 mm"),
    ({"bed": 30.0, "length": 20.0, "breadth": 31.0, "width": 90}, "scale.width = 31 mm: is wider than the bed"),
    ({"embedded": 2.3}, "scale.embedded = 2.3 mm: the substrate does not close over the tab"),
    ({"theta0": math.radians(75), "embedded": 16.0}, "scale.embedded = 16 mm: the slot goes through the substrate"),
    ({"height": 2.5}, "scale.embedded = 6 mm: the slot goes through the substrate, it is 2.184 mm deep in 2.5 mm"),
    ({"breadth": 65.0, "ends": 60}, "scale.width = 65 mm: the scale is wider than the bar, 2 b cos(alpha) = 32.5 mm"),
    ({"breadth": 44.0}, "scale.width = 44 mm: the slot opens at the bar's side"),
    ({"embedded": 13.0}, "scale.width = 24 mm: the slot opens at the bar's side"),
    ({"pitch": 8.0, "thickness": 0.4}, "beam.pitch = 8 mm: the slots of neighbouring tabs"),
    ({"ends": 0.0}, "ends = 0 mm: a slot opens at the bar's end"),
    ({"thickness": 2.5, "embedded": 9.0}, "scale.thickness = 2.5 mm: neighbouring scales are only 0.08819 mm apart"),
    ({"thickness": 3.0, "embedded": 9.0}, "scale.thickness = 3 mm: neighbouring scales lie in each other at rest"),
    ({"wall": 0.3}, "wall = 0.3 mm: is less than the least size that can be printed"),
    (
        {"draft": math.radians(20), "theta0": math.radians(60), "embedded": 14.0, "breadth": 35.0},
        "draft = 20 deg: the blades come to",
    ),
    ({"draft": math.radians(20), "height": 90.0}, "draft = 20 deg: leaves -0.7573 mm of the tray's floor"),
    ({"ends": 14.0}, "ends = 14 mm: the mould's lid leaves"),
    ({"clearance": 0.42}, "beam.pitch = 20 mm: the slits of the mould's lid are only 0.1082 mm apart"),
    ({"bed": 66.0, "length": 50, "width": 60.0}, "bed = 66 mm: the mould's lid measures"),
    ({"bed": 70.0, "width": 60.0}, "the mould's lid is 118.1 mm long and cannot be cut into pieces that fit"),
]


@pytest.mark.parametrize(("changes", "words"), CASES)
def test_a_line_names_the_dimension(changes, words):
    found = lines(GOOD._replace(**changes))
    assert any(words in line for line in found), found
    for line in found:
        assert re.match(r"[\w.]+ = -?[\d.]+ (mm|deg): .*; .*", line), line


@pytest.mark.parametrize(("changes", "words"), CASES)
def test_what_is_advised_is_taken(changes, words):
    """The line goes if its dimension is as it says, and stays if it is a little on the other side."""
    plan = GOOD._replace(**changes)
    line = next(found for found in lines(plan) if words in found)
    field = FIELDS[line.split(" =")[0]]
    advice = re.search(r"write at (least|most) ([\d.]+) (mm|deg)", line)
    if advice is None:
        assert re.search(r"write a (thicker|plate|smaller|larger)|embed less", line)
        return
    value = float(advice[2]) if advice[3] == "mm" else math.radians(float(advice[2]))
    start = line.split(" =")[0]

    def left(value):
        return [found for found in lines(plan._replace(**{field: value})) if found.startswith(start)]

    kind = line.partition(": ")[2][:18]
    assert not any(kind in found for found in left(value))
    beyond = -1 if advice[1] == "least" else 1
    assert left(value * (1 + beyond * 2e-3) + beyond * 2e-3)


def test_a_good_plan_passes_and_mistakes_come_together():
    assert lines(GOOD) == []
    found = lines(GOOD._replace(thickness=0.3, breadth=80.0, embedded=1.0, ends=0.0))
    assert [line.split(" =")[0] for line in found] == ["scale.thickness", "scale.embedded", "scale.width", "ends"]
    # conditions of the mould are asked only for a mould
    no_mould = GOOD._replace(clearance=0.42)
    assert lines(no_mould)
    assert lines(no_mould, BEAM) == []


def test_single_scales_have_no_neighbour():
    thick = GOOD._replace(thickness=3.0, embedded=9.0)
    assert any("neighbouring" in line for line in lines(thick))
    assert not any("neighbouring" in line for line in lines(thick._replace(scales=1), BEAM))


def test_wider_than_the_bar_is_measured_across_the_bar():
    """It is 2 b cos(alpha) that counts: a wide scale fits if it is turned far enough."""
    wide = GOOD._replace(breadth=34.0, embedded=3.0, ends=60.0)
    assert lines(wide, BEAM) == []
    assert any("wider than the bar" in line for line in lines(wide._replace(alpha=math.radians(10)), BEAM))


@pytest.mark.slow
def test_random_plans_are_refused_or_hold():
    random = np.random.default_rng(11)
    refused = made = pieces = 0
    for _ in range(280):
        d, u = random.uniform(5, 40), random.uniform
        plan = Plan(
            width=u(0.8, 3) * d,
            height=u(0.3, 1.5) * d,
            pitch=d,
            scales=int(random.integers(1, 6)),
            length=u(0.3, 4) * d,
            embedded=u(0.05, 0.8) * d,
            breadth=u(0.1, 1.5) * d,
            thickness=u(0.01, 0.2) * d,
            alpha=math.radians(u(0.05, 88)),
            theta0=math.radians(u(1, 80)),
            ends=u(0, 3) * d,
            clearance=float(random.choice([0.0, 0.1, 0.5])),
            wall=u(0.5, 5),
            draft=math.radians(random.choice([0, 1, 5])),
            bed=[None, 60.0, 150.0][random.integers(3)],
        )
        parts = ALL if not lines(plan) else BEAM
        if lines(plan, parts):
            refused += 1
            continue
        built = solids.make(plan, parts)
        assert not [c.line() for c in built.checks if not c.holds], plan
        made += 1
        pieces += "lid-1" in built.files
        if plan.bed is not None:
            assert all(
                np.ptp(one.mesh.bounds, axis=0)[0] <= plan.bed * (1 + 1e-12)
                for name, placed in built.files.items()
                if name not in ("mould", "assembly", "substrate")
                for one in placed
            )
    assert min(refused, made) > 50
    assert pieces > 3

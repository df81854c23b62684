"""Notes on rows of few scales, whose elements are softer than the model behind contact."""

import numpy as np
import pytest

import squama
from squama.curves import rows
from squama.loads import LOADS

SKIN = squama.Beam.from_toml("examples/stiff_skin.toml")
WIDE = {"length": "38 mm", "width": "37.1 mm", "alpha": "54 deg", "theta0": "24 deg"}


def test_a_short_row_of_wide_scales_says_what_elements_have():
    beam = SKIN.replace(scales=8, scale=WIDE)
    r = squama.twist(beam, to="50 deg total", points=20, ends="couple")
    (line,) = [line for line in r.attrs["warnings"].splitlines() if "elements of 8" in line]
    soft, own = (float(word) for word in line.partition("about ")[2].split() if word[0].isdigit())
    assert own == pytest.approx(float(r.stiffness_ratio[-1]), rel=0.03)
    # elements of all scales on a coarse mesh: 2.0, the model on the joint of that mesh 3.7
    assert 1.8 < soft < 0.85 * own
    assert "softer" not in squama.twist(beam, to="25 deg total", points=5, ends="couple").attrs["warnings"]
    assert "softer" not in squama.twist(beam, to="50 deg total", points=20, ends="equal").attrs["warnings"]


def test_long_rows_and_narrow_scales_are_as_stiff_as_the_model():
    twist, bend = LOADS["twisting"], LOADS["bending"]
    narrow = SKIN.replace(scale={"width": "12 mm"})
    ratios = [rows.softened(SKIN.replace(scales=n), twist, 3.0) for n in (5, 8, 25, 1000)]
    assert np.all(np.diff(ratios) > 0)
    assert ratios[-1] == pytest.approx(3, rel=1e-3)
    assert rows.softened(narrow, twist, 3.0) > rows.softened(SKIN, twist, 3.0) > rows.softened(SKIN, bend, 3.0)
    assert rows.softened(SKIN, twist, 1.0) == 1
    # one contact less of N - 1 in series
    lost = (1 / ratios[1] - 1 / 3) / (1 - 1 / 3) * 7
    assert 0.1 < lost < 0.5

"""Designs held against elements."""

import re

import pytest

pytest.importorskip("netgen", reason="needs netgen-mesher (the extra fe)")
pytest.importorskip("ipctk", reason="needs the extra fe")

import squama
from squama.errors import InputError


@pytest.mark.slow
def test_the_first_design_beside_elements():
    """The two torques, and the two stiffness ratios beyond engagement, are of one beam."""
    data = {
        "target": {"points": [{"twist": "0.07 rad/pitch", "stiffness_ratio": "at least 2"}]},
        "vary": {"scale.length": ("60 mm", "70 mm"), "scale.theta0": ("18 deg", "22 deg")},
        "limits": {"printable": False},
        "designs": 1,
    }
    beam = squama.Beam.from_toml("examples/stiff_skin.toml")
    found = squama.inverse_design(data, beam=beam, starts=32, elements=True)
    assert found.met
    (line,) = found.notes
    off, elements, real = re.fullmatch(
        r"elements \(coarse mesh\), 0\.07 rad per pitch: torque .* N m+ \((.*)%\), "
        r"stiffness ratio (.*) \(model: (.*)\)",
        line,
    ).groups()
    assert abs(float(off)) < 20
    assert float(elements) == pytest.approx(float(real), rel=0.3)


def test_elements_are_for_points_on_compliant_joints():
    data = {"target": {"lock": "120 deg total"}, "vary": {"scale.length": ("40 mm", "70 mm")}}
    with pytest.raises(InputError, match="elements: check compliant joints at points of the target only"):
        squama.inverse_design(data, beam=squama.Beam.from_ratios(mu=0.5), elements=True)

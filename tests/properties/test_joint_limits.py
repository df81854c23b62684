"""Ranges of the joint's laws: their limits belong to them, to rounding, and what lies beyond is said."""

from __future__ import annotations

import numpy as np
import pytest

import squama
from squama.inverse import limits
from squama.inverse.space import cells_of
from squama.model import joint

BEAM = """
[scale]
length = "40 mm"
embedded = "10 mm"
width = "50 mm"
thickness = "3 mm"
alpha = "45 deg"
theta0 = "15 deg"
[substrate]
width = "60 mm"
thickness = "12 mm"
youngs_modulus = "1.5 MPa"
poisson_ratio = 0.49
[beam]
pitch = "20 mm"
scales = 25
"""

LIMITS = {
    "stiffness": {"t_s/d": (0.002, 0.016), "L/d": (0.09, 0.36), "L/(2t)": (0, 0.56), "t_s/(l + L)": (0, 0.05)},
    "inclusion twisting": {"zeta beta/lambda": (0, 1.0), "L/(2t)": (0, 0.56)},
    "inclusion bending": {},
}


def test_beams_and_designs_are_held_to_them() -> None:
    """Each ratio is made of the beam's own lengths."""
    beam = squama.Beam.from_toml_text(BEAM)
    ratios = {"t_s/d": 3 / 20, "L/d": 10 / 20, "L/(2t)": 10 / 12, "t_s/(l + L)": 3 / 50}
    ratios["zeta beta/lambda"] = 10 / 20 * (50 / 40) / (12 / 40)
    # the joint of a scale is one whatever the load; the bar's stiffening has a law in twisting alone
    said = {"twisting": tuple(ratios), "bending": tuple(ratios)[:4]}
    for load, names in said.items():
        lines = "\n".join(beam.warnings(load))
        for name, value in ratios.items():
            assert (f": {name} = {value:.3g} is outside its range" in lines) == (name in names), name
        s = limits.Sizes.of(cells_of(beam, load, {}, 1), load, 1.0)
        laws = ["stiffness", f"inclusion {load}"]
        for name, room in limits.rooms(s, {}, laws).items():
            name = name.removeprefix("joint_law (").removesuffix(")")  # noqa: PLW2901 - its limit alone
            ratio, _, end = name.rpartition(" <= " if " <= " in name else " >= ")
            sign = -1 if " <= " in name else 1
            assert float(np.ravel(room)[0]) == pytest.approx(sign * (ratios[ratio] / float(end) - 1))


@pytest.mark.parametrize("name", list(LIMITS))
def test_limits(name: str) -> None:
    law, limits = joint.LAWS[name], LIMITS[name]
    inside = {ratio: (low + high) / 2 for ratio, (low, high) in limits.items()}
    assert joint.outside(law, inside) == []
    for ratio, (low, high) in limits.items():
        for value in (low, high, low * 1.5, low * (1 - 1e-12), high * (1 + 1e-12)):
            assert joint.outside(law, {**inside, ratio: value}) == []
        beyond = [high * (1 + 1e-6), high * 1.4] + ([low * (1 - 1e-6), low * 0.9] if low else [])
        for value in beyond:
            (line,) = joint.outside(law, {**inside, ratio: value})
            assert line.startswith(f"{law.name}: {ratio} = {value:.3g} is outside its range, {low:g} to {high:g} (")
            assert line.endswith(law.remedy)

"""Ranges of the joint's laws: their limits belong to them, to rounding, and what lies beyond is said."""

from __future__ import annotations

import pytest

from squama.model import joint

LIMITS = {
    "stiffness twisting": {"t_s/d": (0.002, 0.016), "L/d": (0.09, 0.36), "L/(2t)": (0, 0.56), "t_s/(l + L)": (0, 0.05)},
    "inclusion twisting": {"zeta beta/lambda": (0, 1.0), "L/(2t)": (0, 0.56)},
    "stiffness bending": {"L/(2t)": (0, 0.56), "t_s/(l + L)": (0, 0.05)},
    "inclusion bending": {},
}


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

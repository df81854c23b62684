"""Stiffness against lateral bend: elements, limits, derivatives, and a bar that is pushed sideways."""

import numpy as np
import pytest

import squama
from squama.joints import choice, lateral, law
from squama.model import section

SKIN = squama.Beam.from_toml("examples/stiff_skin.toml")
WIDE = {"length": "38 mm", "width": "37.1 mm", "alpha": "54 deg", "theta0": "24 deg"}


def of(beam):
    shape = choice.shape(beam)
    return shape, float(lateral.stiffness(law.stiffness(shape), shape))


@pytest.mark.parametrize(
    ("changes", "elements"),
    [
        ({}, 0.1884),
        ({"scale": {"length": "50.3 mm", "width": "27.9 mm", "alpha": "56.5 deg", "theta0": "23.5 deg"}}, 0.2185),
        ({"scale": WIDE}, 0.307),
    ],
    ids=["stiff skin", "wide", "wider"],
)
def test_linear_elements_have_it_too(changes, elements):
    """``squama.fe.pitch_stiffness`` with ten motions; the bar alone has 0.16."""
    _, found = of(SKIN.replace(**changes))
    # tolerance: the formula
    assert found == pytest.approx(elements, rel=0.25)


def test_a_bar_with_slight_scales_has_its_own():
    shape = law.Shape(3.0, 0.35, 0.12, 0.4, 0.01, 0.3, 0.3, 0.4)
    own = section.bending_moment_of_area(0.7, 3.0)
    assert 1 < float(lateral.stiffness(law.stiffness(shape), shape)) / own < 1.02
    soft = np.diag([*np.ones(6), 1.0, 0.5 * section.bending_moment_of_area(3.0, 0.7), 1.0])
    assert float(lateral.stiffness(soft, shape)) == pytest.approx(own, rel=1e-12)
    assert lateral.covered(shape._replace(beta=2.0)) == 1


def test_derivatives_are_those_of_complex_steps():
    shape, at = choice.shape(SKIN), np.arange(8)
    every = law.Shape(*(np.full(8, x, complex) for x in shape))
    moved = law.Shape(*(x + 1e-30j * (at == i) for i, x in enumerate(every)))
    slopes = lateral.stiffness(law.stiffness(moved), moved).imag / 1e-30
    for i, x in enumerate(shape):
        h = 1e-5 * x
        up, down = (of_shape(shape, i, x + s) for s in (h, -h))
        assert slopes[i] == pytest.approx((up - down) / (2 * h), rel=2e-4, abs=1e-6)


def of_shape(shape, i, x):
    one = shape._replace(**{law.Shape._fields[i]: x})
    return float(lateral.stiffness(law.stiffness(one), one))


def test_a_force_sideways_bends_the_bar_by_it():
    """Beam theory of the cells: u = F L^3/(3 B) (1 - 1/(4 n^2)), B in place of that across the faces."""
    n, d = 5, SKIN.pitch
    _, B = of(SKIN)
    r = squama.load(SKIN, "0.5 mm left at tip", support="clamped", scales=n, points=4)
    stiff = 3 * B * SKIN.unit_moment * d / (n * d) ** 3 / (1 - 1 / (4 * n**2))
    assert float(r.F[-1] / 0.5e-3) == pytest.approx(stiff, rel=2e-3)
    one = squama.law_table(SKIN, mu=0, kappa=[-0.5, 0.0, 0.5], Phi=[-0.5, 0.0, 0.5]).data
    assert one.attrs["lateral_rigidity"] == pytest.approx(B * SKIN.unit_moment * d, rel=1e-9)

"""What holds a beam's scales: the matrix, the law, elements, a hinge, in this order."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest

import squama
from squama.beam import matrixfile
from squama.errors import InputError
from squama.fe import stiffness
from squama.joints import factor, law
from squama.joints.choice import joint_of, shape

FIG6B = {"beta": 0.6, "lam": 0.32, "zeta": 0.18, "slenderness": 45}


def beam(**changes: object) -> squama.Beam:
    return squama.Beam.from_ratios(**{**FIG6B, **changes})


def test_the_law_in_its_range() -> None:
    found = joint_of(beam())
    assert (found.source, found.note) == ("law", "")
    np.testing.assert_array_equal(found.K, law.stiffness(shape(beam())))
    assert found.band == law.band(shape(beam()))
    assert 0.006 < found.band < 0.02
    np.testing.assert_array_equal(found.strain, law.strain(shape(beam())))
    # tolerance: elements of no size, with their error bars (docs, theory: elements)
    assert factor.pivots(found.K)[factor.K_THETA] == pytest.approx(0.0119, rel=0.03)
    # size, modulus and the exposed part play no role
    other = joint_of(beam(width="64 mm", thickness="32 mm", youngs_modulus="1 MPa", eta=2))
    np.testing.assert_allclose(other.K, found.K, rtol=1e-9)


def test_beams_of_a_shape_share_its_joint() -> None:
    one, other = joint_of(beam()), joint_of(beam(mu=0.4))
    assert one.K is other.K
    with pytest.raises(ValueError, match="read-only"):
        one.K[0, 0] = 0.0
    with pytest.raises(ValueError, match="read-only"):
        one.strain[0, 0, 0] = 0.0


def test_a_matrix_goes_first() -> None:
    K = law.stiffness(shape(beam()))[:7, :7] * 1.1
    given = beam().replace(joint={"matrix": matrixfile.stored(beam(), K)})
    found = joint_of(given)
    assert found.source == "matrix"
    assert math.isnan(found.band)
    np.testing.assert_allclose(found.K, K, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("with_matrix", [False, True])
def test_measured_figures_go_before_all(with_matrix: bool) -> None:
    plain = beam()
    if with_matrix:
        plain = plain.replace(joint={"matrix": matrixfile.stored(plain, law.stiffness(shape(plain))[:7, :7])})
    given = plain.replace(joint={"stiffness": 2 * plain.joint_stiffness, "inclusion_factor": 1.7})
    unit = given.substrate.youngs_modulus * given.pitch**3
    pivots = factor.pivots(joint_of(given).K)
    assert pivots[factor.K_THETA] * unit == pytest.approx(given.joint_stiffness, rel=1e-9)
    # a matrix of seven motions knows no bend and no stretch, which are free on the others
    twist = matrixfile.twisting_stiffness(joint_of(given).K, () if with_matrix else (1, 0, 1, 1))
    assert twist * unit * given.pitch == pytest.approx(given.torsional_rigidity, rel=1e-9)
    only = factor.pivots(joint_of(plain.replace(joint={"stiffness": given.joint_stiffness})).K)
    assert only[factor.TWIST] == pytest.approx(factor.pivots(joint_of(plain).K)[factor.TWIST], rel=1e-9)


def test_elements_beyond_the_range(monkeypatch: pytest.MonkeyPatch) -> None:
    K = law.stiffness(shape(beam()))
    made = SimpleNamespace(K=K, K_theta=stiffness.Value(0.012, 0.00012), strain=np.zeros((4, 9, 9)))
    monkeypatch.setattr(stiffness, "joint", lambda _, tab: made if tab == "rigid" else None)
    found = joint_of(beam(poisson_ratio=0.1))
    assert found.source == "elements"
    assert found.K is K
    assert found.strain is made.strain
    assert found.band == pytest.approx(0.01)
    assert found.note == (
        "the joint is by elements: substrate.poisson_ratio = 0.1: the law of the joint goes from 0.245 to 0.495"
    )


def test_a_hinge_where_nothing_else_is_known(monkeypatch: pytest.MonkeyPatch) -> None:
    def lacks(_: squama.Beam, **_how: str) -> None:
        message = "finite elements need netgen-mesher; install them with: pip install 'squama[fe]'"
        raise InputError(message)

    monkeypatch.setattr(stiffness, "joint", lacks)
    found = joint_of(beam(poisson_ratio=0.1).replace(joint={"stiffness": "1 N m"}))
    assert (found.K, found.source) == (None, "hinge")
    assert math.isnan(found.band)
    assert found.note.startswith("hinges, as the joint is not known: substrate.poisson_ratio = 0.1")
    assert "pip install 'squama[fe]'" in found.note


def test_what_decides_is_told_once(monkeypatch: pytest.MonkeyPatch) -> None:
    found = joint_of(beam(zeta=3.65))
    assert found.source == "hinge"
    assert found.note.count("scale.embedded") == found.note.count("comes out of the substrate's other face") == 1
    # 12.8 mm in the bar, 10 mm apart, and not as thick as their gap: beyond the law, not beyond elements
    long = squama.Beam(
        scale={"length": 0.036, "width": 0.025, "thickness": 1e-3, "embedded": 0.0128, "alpha": "40 deg",
               "theta0": "10 deg"},
        substrate={"width": 0.025, "thickness": 0.0125, "youngs_modulus": 5e5, "poisson_ratio": 0.49},
        pitch=0.01,
    )  # fmt: skip
    made = SimpleNamespace(K=np.eye(9), K_theta=stiffness.Value(1.0, 0.01), strain=None)
    tabs: list[str] = []
    monkeypatch.setattr(stiffness, "joint", lambda _, tab: tabs.append(tab) or made)
    # scales that have a modulus bend in the bar, too: rigid ones make this part six times too stiff in twist
    bends = joint_of(long.replace(scale={"youngs_modulus": "2.8 GPa"}))
    assert bends.bends
    assert bends.note.startswith("the joint is by elements, whose embedded parts bend: scale.embedded = 1.28 pitches")
    found = joint_of(long)
    assert tabs == ["elastic", "rigid"]
    assert (found.source, found.bends) == ("elements", False)
    assert found.note.startswith("the joint is by elements: scale.embedded = 1.28 pitches: longer than the law of the ")
    assert joint_of(long.replace(scale={"embedded": 4.6e-3, "thickness": 0.3e-3})).source == "law"

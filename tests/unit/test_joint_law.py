"""Given, by the joint's matrix or by law: one rule for a beam, for columns of beams, and behind every door."""

from __future__ import annotations

from functools import partial

import numpy as np
import pytest

import squama
from squama.beam import joint_law, matrixfile
from squama.curves import compliant
from squama.inverse.space import Space, Variable, stepped
from squama.loads import LOADS
from squama.model.sensitivity import STEP
from squama.study.columns import beam_at, columns
from squama.study.hinge_columns import solved
from squama.study.parameters import of_beam
from squama.web import map as regimes
from squama.web.fields import FIELDS
from squama.web.state import State

PLAIN = squama.Beam.from_toml("examples/pla_on_vps.toml").replace(friction={"mu": 0.5})
E, D = PLAIN.substrate.youngs_modulus, PLAIN.pitch
UNIT = np.array([D, D, D, 1, 1, 1, 1])


def with_matrix(K_theta, rigidity):
    """The beam with a matrix of these figures (SI), on which the other motions do nothing."""
    K = np.diag([1.0, 1.0, 1.0, 0.2, K_theta / (E * D**3), 0.2, rigidity / (E * D**4)])
    return PLAIN.replace(joint={"matrix": matrixfile.stored(PLAIN, K)})


BEAM = with_matrix(3 * PLAIN.joint_stiffness, PLAIN.torsional_rigidity)
"""Three times the law's K_theta."""
OTHER = with_matrix(2 * PLAIN.joint_stiffness, 1.5 * PLAIN.torsional_rigidity)


@pytest.mark.parametrize("neutral", ["free", "middle"])
def test_the_rigidity_of_a_matrix_of_nine_is_that_of_the_curve(neutral):
    """Of a bar that is free to stretch by default; the same figures given by themselves change nothing."""
    beam = PLAIN.replace(substrate={"neutral": None if neutral == "free" else neutral})
    beam = beam.replace(joint={"matrix": matrixfile.stored(beam, compliant.Held.of(beam).K)})
    assert beam.given.line == neutral
    held = compliant.Held.of(beam)
    assert held.rigidity == pytest.approx(beam.torsional_rigidity, rel=1e-12)
    given = beam.replace(joint={"stiffness": beam.joint_stiffness, "inclusion_factor": beam.C_f})
    np.testing.assert_allclose(compliant.Held.of(given).K, held.K, rtol=0, atol=1e-12 * held.K.max())


@pytest.fixture(scope="module")
def torque():
    found = float(squama.twist(BEAM, joint="hinge").T_c)
    # tolerance: the figures have three and four digits
    assert found == pytest.approx(1690, rel=1e-3)
    assert float(squama.twist(PLAIN, joint="hinge").T_c) == pytest.approx(563, rel=1e-2)
    return found


def test_a_sweep_takes_the_matrix(torque, tmp_path):
    r = squama.sweep(BEAM, {"mu": [0.4, 0.5]}, out=tmp_path / "map.zarr", joint="hinge")
    assert float(r.torque.sel(mu=0.5)) == pytest.approx(torque, rel=1e-9)


def test_uncertainty_takes_the_matrix(torque):
    u = squama.uncertainty(BEAM, {"mu": "+- 0.001"}, samples=4096, joint="hinge")
    assert float(u.nominal.sel(figure="T_c")) == pytest.approx(torque, rel=1e-9)
    assert float(u["mean"].sel(figure="T_c")) == pytest.approx(torque, rel=1e-2)


def test_inverse_design_takes_the_matrix(torque):
    space = Space(BEAM, "twisting", (Variable("friction.mu", 0.4, 0.6),))
    c = space.cells(np.array([[0.5]]))
    assert float(solved(c)["torque"][0]) == pytest.approx(torque, rel=1e-9)
    assert of_beam(OTHER, "twisting", "joint.inclusion_factor") == OTHER.C_f


def test_the_map_takes_the_matrix():
    twist = squama.twist(OTHER, joint="hinge")
    key = regimes.key(State(OTHER, 0.1)._replace(joint="hinge"), "mu", "alpha")
    plain = regimes.key(State(PLAIN, 0.1)._replace(joint="hinge"), "mu", "alpha")
    assert key != plain
    red = regimes.grid(key).figure
    assert red.shape == (29, 37)
    assert not np.array_equal(red, regimes.grid(plain).figure)
    ratio, thick = OTHER.torsional_rigidity / (OTHER.joint_stiffness * D), OTHER.scale.thickness / OTHER.pitch
    mu, alpha = (axis.values * FIELDS[axis.name].factor for axis in regimes.drawn("mu", "alpha"))
    assert red[14, 9] == pytest.approx(
        squama.solve(**OTHER.ratios | {"alpha": alpha[14]}, thickness=thick, mu=mu[9], stiffness_ratio=ratio).RED,
        rel=1e-9,
    )
    design = squama.solve(**OTHER.ratios, mu=0.5, stiffness_ratio=ratio)
    assert float(design.RED) == pytest.approx(float(twist.RED_c), rel=1e-9)


@pytest.mark.parametrize("load", list(LOADS))
@pytest.mark.parametrize("joint", [{}, {"stiffness": 70.0}, {"inclusion_factor": 1.2}])
def test_columns_are_the_beams(load, joint):
    """Also where sizes vary on which the matrix depends: it stands for its own shape, at each pitch and modulus."""
    rng = np.random.default_rng(2)
    names = ("scale.embedded", "scale.width", "substrate.thickness", "substrate.youngs_modulus", "beam.pitch")
    at = rng.uniform(0.95, 1.05, (len(names), 6))
    parts = {"scale": OTHER.scale, "substrate": OTHER.substrate, "beam": OTHER}
    values = {n: getattr(parts[n.split(".")[0]], n.split(".")[1]) * s for n, s in zip(names, at, strict=True)}
    beam = OTHER.replace(joint=joint)
    for c in (columns(beam, values, load=load, each=each) for each in (joint_law.one_by_one, joint_law.whole)):
        for i in range(6):
            one = beam_at(beam, load, {n: float(v[i]) for n, v in values.items()})
            assert np.broadcast_to(c.K, 6)[i] == pytest.approx(one.joint_stiffness, rel=1e-13)
            assert c.rigidity[i] == pytest.approx(LOADS[load].rigidity(one), rel=1e-13)


@pytest.mark.parametrize("load", list(LOADS))
@pytest.mark.parametrize("name", ["joint.stiffness", "joint.inclusion_factor"])
def test_what_is_varied_comes_before_the_matrix(load, name):
    value = 80.0 if name == "joint.stiffness" else 1.3
    c = columns(OTHER, {name: np.array([value, 1.1 * value])}, load=load)
    one = beam_at(OTHER, load, {name: value})
    assert float(np.broadcast_to(c.K, 2)[0]) == pytest.approx(one.joint_stiffness, rel=1e-13)
    assert float(np.broadcast_to(c.rigidity, 2)[0]) == pytest.approx(LOADS[load].rigidity(one), rel=1e-13)


@pytest.mark.parametrize("name", ["beam.pitch", "substrate.youngs_modulus", "scale.embedded", "substrate.thickness"])
def test_a_complex_step_goes_through_the_matrix(name):
    table, _, key = name.partition(".")
    value = np.array([getattr(OTHER if table == "beam" else getattr(OTHER, table), key)])
    step = 1e-6 * value
    slope = columns(OTHER, {name: value + 1e-30j})
    up, down = (columns(OTHER, {name: value + s * step}) for s in (1, -1))
    for field in ("K", "rigidity"):
        exact = np.imag(getattr(slope, field)) / 1e-30
        difference = (getattr(up, field) - getattr(down, field)) / (2 * step)
        np.testing.assert_allclose(exact, difference, rtol=1e-7, atol=1e-9 * getattr(up, field).max() / value[0])


def test_the_inclusion_factor_in_bending_is_one():
    beam = PLAIN.replace(joint={"stiffness": 50.0})
    assert of_beam(beam, "bending", "joint.inclusion_factor") == beam.bending_C_f == 1.0
    assert of_beam(beam, "twisting", "joint.inclusion_factor") == beam.C_f > 1.3
    # a share of the factor is the same share of the rigidity, so tolerances on it are what they say
    moved = stepped(beam, "bending", {}, "joint.inclusion_factor", 1.0, 1)
    assert float(np.imag(moved.rigidity[0]) / STEP) == pytest.approx(beam.bending_rigidity, rel=1e-12)
    assert float(np.real(moved.rigidity[0])) == pytest.approx(beam.bending_rigidity, rel=1e-12)


@pytest.mark.parametrize("load", list(LOADS))
def test_arrays_and_numbers_agree(load):
    for beam in (PLAIN, OTHER):
        many = joint_law.Sizes(*(np.full(3, v) for v in beam.sizes))
        rules = (partial(joint_law.inclusion, load), partial(joint_law.rigidity, load), joint_law.stiffness)
        for rule in rules:
            one = rule(beam.sizes, beam.given)
            assert np.all(rule(many, beam.given, joint_law.one_by_one) == one)
            np.testing.assert_allclose(rule(many, beam.given, joint_law.whole), one, rtol=1e-13)


def test_what_varies_the_shape_is_told_as_by_a_beam(tmp_path):
    made = f"was made for another shape, scale.embedded = {BEAM.scale.embedded * 1e3:.4g} mm"
    ranges = {"scale.embedded": (BEAM.scale.embedded, 1.1 * BEAM.scale.embedded, 2)}
    swept = squama.sweep(BEAM, ranges, out=tmp_path / "map.zarr", joint="hinge")
    assert [f"at scale.embedded = {size:g} mm:" in swept.attrs["warnings"] for size in (6, 6.6)] == [False, True]
    assert made in swept.attrs["warnings"]
    here = BEAM.replace(scale={"embedded": 1.1 * BEAM.scale.embedded}).warnings()
    assert any(swept.attrs["warnings"].endswith(line) for line in here if line.startswith("joint.matrix"))
    scattered = squama.uncertainty(BEAM, {"scale.embedded": "+- 10 %"}, samples=3200, joint="hinge")
    assert made in scattered.attrs["notes"]
    softer = squama.uncertainty(BEAM, {"substrate.youngs_modulus": "+- 10 %"}, samples=3200, joint="hinge")
    assert "joint.matrix" not in softer.attrs["notes"]
    bent = squama.uncertainty(BEAM, {"scale.embedded": "+- 10 %"}, samples=3200, load="bending", joint="hinge")
    assert made in bent.attrs["notes"]

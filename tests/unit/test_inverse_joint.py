"""The joint behind every door of inverse design: given, by its matrix or by law, as for single beams."""

from __future__ import annotations

import functools
import math

import numpy as np
import pytest

import squama
from squama.beam import matrixfile
from squama.inverse.front import beams
from squama.inverse.target import read_target

PLAIN = squama.Beam.from_toml("examples/pla_on_vps.toml").replace(scales=None)
VARY = {"scale.length": ("40 mm", "80 mm"), "beam.pitch": ("12 mm", "25 mm")}


def with_matrix(factor):
    """The beam with a matrix of this many times the law's stiffness, on which the other motions do nothing."""
    E, d = PLAIN.substrate.youngs_modulus, PLAIN.pitch
    joint = factor * PLAIN.joint_stiffness / (E * d**3), 0.2, 1.2 * PLAIN.torsional_rigidity / (E * d**4)
    return PLAIN.replace(joint={"matrix": matrixfile.stored(PLAIN, np.diag([1.0, 1.0, 1.0, 0.2, *joint]))})


BEAM = with_matrix(3.0)


def test_designs_take_the_matrix():
    asked = {"points": [{"twist": "60 deg total", "torque": "at least 1 N m"}], "stiffness": "at most 0.1 N m^2"}
    found = squama.inverse_design({"target": asked, "vary": VARY, "joint": "hinge"}, beam=BEAM, starts=128, designs=2)
    assert found.met
    for d in found.designs:
        assert d.beam.joint.matrix is not None
        r = squama.twist(d.beam, at="60 deg total", joint="hinge")
        stiffness, torque = d.goals
        assert torque.reached == pytest.approx(float(r["T"][0]), rel=1e-9)
        assert stiffness.reached == pytest.approx(d.beam.torsional_rigidity, rel=1e-9)
        # which is not what the laws give
        lawful = squama.twist(d.beam.replace(joint={"matrix": None}), at="60 deg total", joint="hinge")
        assert abs(float(lawful["T"][0]) - torque.reached) > 0.05 * torque.reached


def test_fronts_take_the_matrix():
    pytest.importorskip("pymoo")
    data = {
        "joint": "hinge",
        "vary": VARY,
        "front": {"maximise": ["torque", "W_fr"], "at": "60 deg total", "population": 16, "generations": 4},
    }
    front = squama.pareto(data, beam=BEAM)
    for i, beam in enumerate(beams(front)[:4]):
        r = squama.twist(beam, at="60 deg total", joint="hinge")
        assert beam.joint.matrix is not None
        assert float(r["T"][0]) == pytest.approx(float(front["torque"][i]), rel=1e-9)
        assert float(r.W_fr_c) == pytest.approx(float(front["W_fr"][i]), rel=1e-9)


def test_a_matrix_stands_in_no_range_of_a_law():
    data = {"target": {"lock": "120 deg total"}, "vary": VARY, "limits": {"joint_law": True}}
    assert read_target(data, beam=PLAIN).laws == ["stiffness", "inclusion twisting"]
    assert read_target(data, beam=BEAM).laws == []
    assert read_target(data | {"load": "bending"}, beam=PLAIN).laws == ["stiffness", "inclusion bending"]
    assert read_target(data | {"load": "bending"}, beam=BEAM).laws == []
    given = PLAIN.replace(joint={"inclusion_factor": 1.1})
    assert read_target(data, beam=given).laws == ["stiffness"]


@pytest.mark.slow(but=1)
@pytest.mark.parametrize("load", ["twisting", "bending"])
@pytest.mark.parametrize("start", [PLAIN, BEAM], ids=["law", "matrix"])
def test_tolerances_of_the_joint_against_changed_beams(load, start):
    """A share of K_theta and C_f is one of what the beam has; C_f is 1 in bending."""
    torque, call = ("T", squama.twist) if load == "twisting" else ("M", squama.bend)
    at = functools.partial(call, joint="hinge")
    tolerance = {"joint.stiffness": "10 %", "joint.inclusion_factor": "5 %"}
    asked = {"points": [{"twist": "80 deg total", "torque": "at least 1 N mm"}], "stiffness": "at least 0.001 N m^2"}
    data = {"target": asked, "vary": VARY, "joint": "hinge", "load": load, "tolerance": tolerance}
    d = squama.inverse_design(data, beam=start, starts=64, designs=1)[0]
    own = d.beam
    K, C = own.joint_stiffness, own.C_f if load == "twisting" else own.bending_C_f

    def reached(joint):
        beam = own.replace(joint=joint)
        rigidity = beam.torsional_rigidity if load == "twisting" else beam.bending_rigidity
        return rigidity, 1e3 * float(at(beam, at="80 deg total")[torque][0])

    for name, size, value in (("stiffness", 0.1 * K, K), ("inclusion_factor", 0.05 * C, C)):
        up, down = (reached({name: value + s * 1e-4 * size}) for s in (1, -1))
        for goal, a, b in zip(d.goals, up, down, strict=True):
            assert goal.effects[f"joint.{name}"] == pytest.approx((a - b) / 2e-4, rel=1e-5, abs=1e-9 * goal.reached)
    # the rigidity grows with C_f as it is, not with that of the other load
    assert d.goals[0].effects["joint.inclusion_factor"] == pytest.approx(0.05 * d.goals[0].reached, rel=1e-9)
    assert math.isfinite(d.goals[1].spread)

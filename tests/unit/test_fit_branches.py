"""How the points of a record were reached, and how an estimate is written."""

from __future__ import annotations

import math

import numpy as np
import pytest

import squama
from squama.curves import compliant
from squama.identify.hinge_points import Physical
from squama.identify.joint_points import Walked
from squama.identify.readings import Readings
from squama.identify.records import turning_points, ways
from squama.identify.unknowns import with_error
from squama.loads import LOADS


def test_a_noisy_twist_needs_to_be_told():
    """With back steps smaller than what is told, branches are those of the twist without noise."""
    clean = np.concatenate([np.linspace(0, 0.2, 200), np.linspace(0.2, 0, 200)])
    seen = clean + np.random.default_rng(5).uniform(-2e-3, 2e-3, clean.size)
    assert len(turning_points(seen, 0.0)) > 100
    found = ways(seen, tolerance=5e-3)
    assert len(found.turns) == 1
    assert abs(found.turns[0] - 199) < 4
    right = np.where(np.arange(400) < 200, 1, -1)
    far = np.abs(np.arange(400) - 199) > 4
    assert (found.direction == right)[far].all()
    assert found.stuck.sum() < 12


@pytest.mark.parametrize(
    ("values", "direction", "stuck"),
    [
        ([0, 1, 2, 2, 3], [1] * 5, []),
        ([0, 1, 2, 2, 1, 0], [1, 1, 1, -1, -1, -1], [3]),
        ([2, 2, 1, 0], [-1] * 4, [0, 1]),
        ([0, 2, 1, 1, 2], [1, 1, -1, 1, 1], [3]),
        ([0, -1, -2, -1], [-1, -1, -1, 1], []),
        ([-2, -1, 1, 2], [1] * 4, [0]),
        ([5], [1], []),
        ([0, 0, 0], [1] * 3, []),
        ([-3, -3], [-1] * 2, []),
    ],
)
def test_ways(values, direction, stuck):
    found = ways(np.array(values, float))
    assert found.direction.tolist() == direction
    assert np.flatnonzero(found.stuck).tolist() == stuck


def test_ways_of_readings_turn_where_the_twist_does():
    """Through zero it goes on; another specimen begins anew."""
    load, grows = np.array([-2.0, -1, 1, 2, 1, 1, 2]), np.array([-1, -1, 1, 1, -1, 1, 1])
    readings = Readings.of(load, grows, np.array([1, 1, 1, 1, 1, 2, 2]), 10)
    found = [[load[way].tolist() for way in ways] for ways in readings.records]
    assert found == [[[-2, -1, 1, 2], [1]], [[1, 2]]]
    assert readings.numbers.tolist() == [0, 0, 0, 0, 1, 2, 2]


def walked_of(beam, loop, v):
    """What is walked at the twists of a cycle, its torque there, and the cycle's; the second and third where solved.

    A point where scales begin to slide is no solved one of the cycle: 1.8e-5 of the torque off.
    """
    load = loop.phi.values
    readings = Readings.of(load, ways(load).direction, np.zeros(load.size, int), beam.pitches)
    walked = Walked(beam, LOADS["twisting"], readings, v)
    solved = np.append((loop.branch.values[:-1] != "stick") | (loop.branch.values[1:] == "stick"), True)
    return walked, walked.torque(v)[solved], loop["T"].values[solved]


def test_what_is_walked_is_the_cycle():
    """Torques at points of a cycle are the cycle's; rigidity without contact, zero and drift are added to it."""
    beam, history = (
        squama.Beam.from_toml("examples/pla_on_vps.toml").replace(scales=None).replace(hold="bend, lateral bend"),
        "0.1, 0.05, 0.12, 0 rad/pitch",
    )
    loop, held = squama.cycle(beam, history, points=40, ends="endless"), compliant.Held.of(beam)
    load = loop.phi.values
    v = Physical(0.25, held.K_theta, held.rigidity, beam.scale.theta0)
    walked, found, expected = walked_of(beam, loop, v)
    # tolerance: steps that pass that point by, 6e-6 of the torque
    np.testing.assert_allclose(found, expected, rtol=0, atol=2e-4 * float(loop["T"].max()))
    touching = loop.branch.values != "straight"
    assert (walked.touching(v) == touching)[np.abs(load - float(loop.phi_e[0])) > 1e-3].all()
    more = v._replace(rigidity=2 * held.rigidity, torque_zero=0.5, drift=0.1)
    added = held.rigidity * load / beam.pitch + 0.5 + 0.1 * walked.readings.order
    differs = walked.torque(more) - walked.torque(v)
    np.testing.assert_allclose(differs[~touching], added[~touching])
    # in contact the bar stretches with the scales' motions: 4e-4 of it
    np.testing.assert_allclose(differs, added, rtol=0.015)
    # the scales bend, so that a stiffer joint is not a factor on the torque
    share = (walked.torque(v._replace(stiffness=2 * v.stiffness)) - walked.torque(v))[touching]
    own = walked.torque(v)[touching] - (held.rigidity * load / beam.pitch)[touching]
    assert share.max() < 0.5 * own.max()
    # the joint takes a stiffness on as that of a beam's file
    stiffer = beam.replace(joint={"stiffness": 2 * held.K_theta})
    stiff = squama.cycle(stiffer, history, points=40, ends="endless")
    _, found, expected = walked_of(beam, stiff, v._replace(stiffness=2 * v.stiffness))
    np.testing.assert_allclose(found, expected, rtol=0, atol=2e-4 * float(stiff["T"].max()))


def test_words_of_an_estimate():
    assert with_error(0.25, 0.0134, "1") == "0.250 +- 0.013"
    assert with_error(0.0123, 0.0004, "N m") == "12.30 +- 0.40 N mm"
    assert with_error(np.radians(10), np.radians(0.25), "rad") == "10.00 +- 0.25 deg"
    assert with_error(0.3, 1e-12, "1") == "0.3 +- 1.0e-12"
    assert with_error(1, math.inf, "1") == "1 +- inf"
    assert with_error(0, 0, "1") == "0.0 +- 0.0"

"""How the points of a record were reached, and how an estimate is written."""

from __future__ import annotations

import math

import numpy as np
import pytest

import squama
from squama.curves import follow
from squama.curves.path import States
from squama.identify.forward import Physical, Walked
from squama.identify.parameters import with_error
from squama.identify.records import turning_points, ways


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


def test_what_is_walked_turns_where_the_twist_does(monkeypatch):
    """Through zero it goes on; another specimen begins anew."""
    monkeypatch.setattr(Walked, "_walked", lambda *_: None)
    load, grows = np.array([-2.0, -1, 1, 2, 1, 1, 2]), np.array([-1, -1, 1, 1, -1, 1, 1])
    walked = Walked(squama.Beam.from_ratios(), load, grows, np.array([1, 1, 1, 1, 1, 2, 2]), 0.2)
    assert [[way.tolist() for way in record] for record in walked.ways] == [[[-2, -1, 1, 2], [1]], [[1, 2]]]


def test_what_is_walked_touches_where_there_is_a_force(monkeypatch):
    """However small it is; between the points of the walk torque and inclination are interpolated."""
    beam = squama.Beam.from_ratios()
    load, theta = np.linspace(0, 0.2, 5), beam.scale.theta0 + np.array([0, 0, 0, 0.01, 0.05])
    states = {"load": load, "leg": np.ones(5, int), "scales": 6 * load, "N": [0, 0, 1e-4, 2e-4, 3e-4], "theta": theta}
    walk = States({("point",): {role: np.array(v) for role, v in states.items()}}, {"K_theta": 2.0})
    monkeypatch.setattr(follow, "model", lambda *_: follow.Model(None, lambda _: walk, {}))
    at = np.array([0.02, 0.12, 0.2])
    walked = Walked(beam, at, np.ones(3), np.ones(3), 0.2)
    assert (walked.theta > beam.scale.theta0).tolist() == [False, True, True]
    assert walked.theta[2] == pytest.approx(theta[-1])
    torque = walked.torque(Physical(mu=0.2, stiffness=5.0, rigidity=7.0, theta0=0.1, zero=0.5))
    np.testing.assert_allclose(torque, 7 * at / beam.pitch + 0.5 + 5 * 3 * at)


def test_words_of_an_estimate():
    assert with_error(0.25, 0.0134, "1") == "0.250 +- 0.013"
    assert with_error(0.0123, 0.0004, "N m") == "12.30 +- 0.40 N mm"
    assert with_error(np.radians(10), np.radians(0.25), "rad") == "10.00 +- 0.25 deg"
    assert with_error(0.3, 1e-12, "1") == "0.3 +- 1.0e-12"
    assert with_error(1, math.inf, "1") == "1 +- inf"
    assert with_error(0, 0, "1") == "0.0 +- 0.0"

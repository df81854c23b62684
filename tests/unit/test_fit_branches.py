"""How the points of a record were reached, and how an estimate is written."""

from __future__ import annotations

import math

import numpy as np
import pytest

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
    ],
)
def test_ways(values, direction, stuck):
    found = ways(np.array(values, float))
    assert found.direction.tolist() == direction
    assert np.flatnonzero(found.stuck).tolist() == stuck


def test_words_of_an_estimate():
    assert with_error(0.25, 0.0134, "1") == "0.250 +- 0.013"
    assert with_error(0.0123, 0.0004, "N m") == "12.30 +- 0.40 N mm"
    assert with_error(np.radians(10), np.radians(0.25), "rad") == "10.00 +- 0.25 deg"
    assert with_error(0.3, 1e-12, "1") == "0.3 +- 1.0e-12"
    assert with_error(1, math.inf, "1") == "1 +- inf"
    assert with_error(0, 0, "1") == "0.0 +- 0.0"

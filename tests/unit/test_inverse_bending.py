"""Designs in bending: thick, elastic scales on joints that give, judged with their own number of scales."""

from __future__ import annotations

import math

import numpy as np
import pytest

import squama
from squama.inverse.residuals import Residuals
from squama.inverse.target import read_target

TARGET = "examples/finger_target.toml"


@pytest.mark.slow
def test_a_finger_is_what_squama_bend_says_of_it():
    found = squama.inverse_design(TARGET, starts=256, designs=1)
    (best,) = found.designs
    assert found.met
    beam = best.beam
    r = squama.bend(beam, at=["75 deg total"])
    reached = {goal.name: goal.reached for goal in best.goals}
    stiffer, stress = (v for name, v in reached.items() if "75 deg" in name)
    assert float(r.stiffness_ratio[0]) == pytest.approx(stiffer, rel=1e-9)
    assert stiffer > 5 * 0.99
    assert 100 * float(r.stress.max()) / beam.scale.strength == pytest.approx(stress, rel=1e-9)
    assert math.degrees(float(r.psi_e)) * beam.scales == pytest.approx(reached["engagement"])
    assert reached["engagement"] > 45 * 0.99
    assert beam.length == pytest.approx(0.12, rel=0.01)
    assert best.found_by == f"({beam.scales} scales)"
    # the endless beam would be taken for several times as stiff
    endless = next(other for other in best.beside if other.key == "endless")
    assert max(goal.reached for goal in endless.goals if "ratio" in goal.name) > 2 * stiffer


def test_derivatives_are_those_of_the_figures():
    target = {
        "start": "examples/finger.toml",
        "load": "bending",
        "target": {
            "engagement": "45 deg total",
            "points": [{"twist": "75 deg total", "moment": 0.02, "stress": "10 MPa"}],
        },
        "vary": {
            "scale.length": ("25 mm", "38 mm"),
            "scale.alpha": ("10 deg", "30 deg"),
            "scale.theta0": ("20 deg", "25 deg"),
            "substrate.thickness": ("7 mm", "9 mm"),
            "friction.mu": (0.1, 0.4),
        },
    }
    residuals = Residuals(read_target(target))
    middle = np.full((1, 5), 0.5)
    look, step = residuals.look(middle, slopes=True, plates=True), 1e-5
    for i in range(5):
        aside = np.repeat(middle, 2, axis=0)
        aside[:, i] += [-step, step]
        low, high = residuals.look(aside, slopes=False, plates=True).values.T
        slopes = (high - low) / (2 * step)
        assert np.isfinite(look.values).all()
        # a part of the largest slope of the figure stands for those that nearly vanish
        largest = np.abs(look.slopes[:, :, 0]).max(axis=1)
        assert np.all(np.abs(look.slopes[:, i, 0] - slopes) < 5e-3 * largest)


def test_locks_in_bending_stay_those_of_hinges():
    data = {"start": "examples/finger.toml", "load": "bending", "vary": {"scale.length": ("20 mm", "30 mm")}}
    assert read_target({**data, "target": {"lock": "100 deg total"}}).options.joint == "hinge"
    assert read_target({**data, "target": {"engagement": "45 deg total"}}).options.joint == "compliant"
    asked = {"points": [{"twist": "75 deg total", "stiffness_ratio": "at least 5"}]}
    with pytest.raises(squama.InputError, match='is not a figure of hinges; leave out joint = "hinge"'):
        read_target({**data, "joint": "hinge", "target": asked})

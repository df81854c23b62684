"""Rows do not depend on where their points are."""

from __future__ import annotations

import numpy as np
import pytest

import squama
from squama.contacts import increments, row
from squama.contacts.path import Path
from squama.curves import compliant

PLA = squama.Beam.from_toml("examples/pla_on_vps.toml").replace(hold="bend, twist, lateral bend")


def at_the_end() -> squama.Beam:
    """A row in which the last pair of scales engages last, where the solver finds no equilibrium near by."""
    size = {"length": 0.0675009712, "alpha": 1.0759679181, "theta0": 0.2610130214}
    return PLA.replace(pitch=0.0184974435, scale=size, friction={"mu": 0.3014568057})


@pytest.mark.slow
def test_points_that_a_jump_passes_are_not_told_twice():
    # behind 0.0699 rad/pitch the next equilibrium is found 0.004 further on, beyond several of the points
    beam = at_the_end()
    for to in ("0.1025 rad/pitch", "0.11 rad/pitch"):
        assert (np.diff(squama.row(beam, to=to, points=120).phi) > 0).all()
    # tangents are taken without a division by zero
    assert np.isfinite(squama.row(beam, to="0.1005 rad/pitch", points=120).K_t).all()


@pytest.mark.slow
def test_a_row_ends_alike_wherever_its_points_are():
    """Second contacts come in where their gaps close, so no jump passes points on its way."""
    held = compliant.Held.of(at_the_end())
    scale = compliant.scale(at_the_end(), ideal=False)
    way = Path.of(scale, held.K, at_the_end().friction.mu, most=0.3, **held.bar)
    told = []
    for to, points in ((0.1, 40), (0.102, 120), (0.1025, 200), (0.11, 40)):
        found = row.track(way, 25, np.linspace(0.0, to, points + 1)[1:])
        assert (np.diff(found.rows[:, 0, 0]) > 0).all()
        # whether a contact sticks from its first increment on, or slides in it, hangs on that increment
        rubs = np.isin(found.events[:, 0], (increments.STICK, increments.SLIDE))
        told.append((found.end.code, found.events[(found.events[:, 1] < 0.1) & ~rubs]))
    assert {code for code, _ in told} == {told[0][0]}
    # tolerance: 1.4e-7 measured
    np.testing.assert_allclose([events[-1, 1] for _, events in told], told[0][1][-1, 1], rtol=0.0, atol=5e-6)
    for _, events in told[1:]:
        assert len(events) == len(told[0][1])


def test_second_contacts_of_a_short_row_do_not_depend_on_its_points():
    """Three scales, of which the second one bends along the third one's edge: nothing jumps."""
    held = compliant.Held.of(at_the_end())
    scale = compliant.scale(at_the_end(), ideal=False)
    way = Path.of(scale, held.K, at_the_end().friction.mu, most=0.3, **held.bar)
    told = []
    for points in (40, 100, 200, 450):
        found = row.track(way, 3, np.linspace(0.0, 0.1, points + 1)[1:])
        assert found.end.code == increments.RANGE
        told.append(found.events)
    for events in told[1:]:
        np.testing.assert_array_equal(events[:, [0, 6, 7, 8, 9, 10]], told[0][:, [0, 6, 7, 8, 9, 10]])
        # tolerance: 2e-9 measured
        np.testing.assert_allclose(events[:, 1], told[0][:, 1], rtol=0.0, atol=1e-6)

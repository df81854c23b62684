"""Histories, loops and searches of a contact that is walked both ways, without beams."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from properties.designs import Drawn, follow
from squama.model import history
from squama.model.history import Loop, Side
from squama.model.paths import FLOAT

# edge law at a high friction: in the middle of the path the contact does not slide back
HELD = Drawn(2.711606655130277, 2.6771024042412805, 0.1162005028117272, 0.050711102443806, 0.016729201056311673, 3.13)


@pytest.mark.parametrize(
    ("values", "turns", "loops"),
    [
        ([0, 2, 0], [1], [(0, 2, 2)]),
        ([0, 15, 5, 20, 0], [1, 2, 3], [(5, 15, 3), (0, 20, 4)]),
        ([0, 20, 5, 20, 5, 20, 0], [1, 2, 3, 4, 5], [(5, 20, 3), (5, 20, 5), (0, 20, 6)]),
        ([0, 2, -2, 0], [1, 2], [(0, 2, 2), (0, -2, 3)]),
        ([0, 1, 2, 1, 0], [2], [(0, 2, 4)]),
        ([0, 2], [], []),
        ([0, 2, 1], [1], []),
        ([0, 20, 5, 15, 10, 25], [1, 2, 3, 4], [(10, 15, 5), (5, 20, 5)]),
        ([0, -3, -1, -2, -1.5, -3, 0], [1, 2, 3, 4, 5], [(-1.5, -2, 5), (-1, -3, 5), (0, -3, 6)]),
    ],
)
def test_loops_close_where_the_way_comes_back(values, turns, loops):
    assert history.reversals(values) == turns
    assert history.loops(values) == [Loop(*loop) for loop in loops]


@given(st.lists(st.integers(-9, 9), min_size=1, max_size=30))
def test_loops_and_what_is_left_make_up_the_whole_way(steps):
    values = [0.0]
    for v in [*steps, 0]:
        if v != values[-1]:
            values.append(float(v))
    loops = history.loops(values)
    # every stretch of a closed way belongs to one loop, each loop goes over it twice
    way = np.abs(np.diff(values)).sum()
    assert 2 * sum(abs(loop.top - loop.base) for loop in loops) == pytest.approx(way)
    assert all(loop.base * loop.top >= 0 and abs(loop.top) > abs(loop.base) for loop in loops)
    assert [loop.closed for loop in loops] == sorted(loop.closed for loop in loops)


def test_last_below_finds_ends_crossings_and_narrow_dips():
    assert history.last_below(lambda x: x + 1, 0.0, 1.0) is None
    assert history.last_below(lambda x: 0 * x - 1, 0.0, 1.0) == 1.0
    assert history.last_below(lambda x: x - 0.3, 0.0, 1.0) == pytest.approx(0.3, abs=1e-15)
    assert history.last_below(lambda x: 0.3 - x, 0.0, 1.0) == 1.0
    assert history.last_below(lambda x: (x - 0.3001) ** 2 - 1e-9, 0.0, 1.0) == pytest.approx(0.3001 + 10**-4.5)
    # of two, the last
    assert history.last_below(lambda x: (x - 0.2) * (x - 0.4) * (x - 0.7) * (x - 0.8), 0.0, 1.0) == pytest.approx(0.8)


def side(d: Drawn, law: str = "edge", fraction: float = 0.95) -> Side:
    f = follow(d, law)
    return Side(f.row, f.x0, f.x0 + fraction * (f.x_end - f.x0), f.pole, d.mu, law)


def test_friction_can_hold_a_contact_against_sliding_back():
    s = side(HELD, fraction=0.999)
    x = history.held(s, s.x0, s.x_end)

    def drive(v: float) -> float:
        return s.forces(s.row.point(v, "edge", FLOAT), -1).D

    # a direct search from above
    grid = np.linspace(s.x_end, s.x0, 4001)
    first = next(v for v in grid if drive(float(v)) <= 0)
    assert s.x0 < x < s.x_end
    # tolerance: a grid of 4001 points
    assert x == pytest.approx(first, abs=2 * (grid[0] - grid[1]))
    assert history.held(s._replace(mu=0.1), s.x0, s.x_end) is None
    assert history.held(s, x + 1e-6, s.x_end) is None
    assert history.held(s, s.x0, first) == first
    # the friction force has a pole there: the work of getting near it grows by equal steps
    near = [float(history.work(s, s.x_end, x + e)(np.array(x + e))) for e in (1e-3, 1e-4, 1e-5, 1e-6)]
    steps = np.diff(near)
    assert (steps > 0).all()
    assert steps[2] == pytest.approx(steps[1], rel=1e-2)


@pytest.mark.parametrize("law", ["edge", "plate"])
def test_work_of_both_branches_by_another_quadrature(law):
    d = Drawn(3.0, 1.25, 0.45, np.radians(45), np.radians(10), 0.5)
    s = side(d, law)
    a, b = s.x0 + 0.2 * (s.x_end - s.x0), s.x_end
    nodes, weights = np.polynomial.legendre.leggauss(60)
    for way, start, stop in ((1, a, b), (-1, b, a)):
        total = 0.0
        for low, high in zip(*(np.linspace(a, b, 9)[i : 8 + i] for i in (0, 1)), strict=True):
            for z, w in zip(nodes, weights, strict=True):
                pt = s.row.point(float((low + high) / 2 + (high - low) / 2 * z), law, FLOAT)
                total += (high - low) / 2 * w * abs(s.forces(pt, way).f) * pt.slip_rate
        assert float(history.work(s, start, stop)(np.array(stop))) == pytest.approx(total, rel=1e-11)
        assert float(history.work(s, start, stop)(np.array(start))) == pytest.approx(0, abs=1e-13)


def test_the_torque_falls_all_through_the_stick_interval():
    d = Drawn(3.0, 1.25, 0.45, np.radians(45), np.radians(10), 0.5)
    s = side(d)
    pt = s.row.point(s.x_end, "edge", FLOAT)
    torque = [s._replace(mu=m).forces(pt, 1).torque for m in np.linspace(-0.5, 0.5, 41)]
    assert (np.diff(torque) > 0).all()
    assert torque[0] == s.forces(pt, -1).torque
    # dT/dm as the module has it
    m, h = 0.2, 1e-5
    slope = (s._replace(mu=m + h).forces(pt, 1).torque - s._replace(mu=m - h).forces(pt, 1).torque) / (2 * h)
    D = -(pt.M_N + m * pt.M_f)
    assert slope == pytest.approx(-(pt.theta - d.theta0) * pt.M_N * pt.slip_rate / (pt.load_rate * D * D), rel=1e-7)


def valleys(*centres, floor=-1e-6):
    """Parabolas narrower than the samples' distance; the lowest counts."""
    h = 1 / (history.SAMPLES - 1)

    def f(x):
        y = np.min([((np.asarray(x) - c * h) / h) ** 2 for c in centres], axis=0) + floor
        return y if np.ndim(x) else float(y)

    return f, h


@pytest.mark.parametrize("share", [-0.45, -0.3, -0.1, 0.1, 0.3, 0.45])
def test_a_valley_between_two_samples_is_found(share):
    f, h = valleys(500 + share)
    assert history.last_below(f, 0.0, 1.0) == pytest.approx((500 + share + 1e-3) * h, abs=1e-8)


def test_of_several_valleys_the_last_counts():
    for centres in ((100.2, 500.3), (100.2, 300.4, 500.3), (100.2, 300.4, 400.1, 500.3)):
        f, h = valleys(*centres)
        assert history.last_below(f, 0.0, 1.0) == pytest.approx((500.3 + 1e-3) * h, abs=1e-8)


@pytest.mark.parametrize("floor", [1e-6, 0.02])
def test_a_valley_above_zero_is_none(floor):
    f, _ = valleys(100.2, 500.3, floor=floor)
    assert history.last_below(f, 0.0, 1.0) is None
    # beside one that is below
    g, h = valleys(100.2)
    both = history.last_below(lambda x: np.minimum(f(x), g(x)) if np.ndim(x) else min(f(x), g(x)), 0.0, 1.0)
    assert both == pytest.approx((100.2 + 1e-3) * h, abs=1e-8)


def test_a_valley_two_samples_beyond_what_is_below_zero():
    f, h = valleys(500.3)

    def g(x):
        y = np.minimum(5 * (np.asarray(x) / h - 498) - 1e-6, f(x))
        return y if np.ndim(x) else float(y)

    assert history.last_below(g, 0.0, 1.0) == pytest.approx((500.3 + 1e-3) * h, abs=1e-8)

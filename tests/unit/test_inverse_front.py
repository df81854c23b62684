"""Fronts: no point dominates another, no worse than as many random beams, brute force in two dimensions."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest

pytest.importorskip("pymoo")

import squama
from squama.cli.design import _designs
from squama.inverse.front import Trade, beams, read_settings, spread, undominated
from squama.inverse.target import read_target
from squama.inverse.targetfile import Context
from squama.model.outcome import CODES

BEAM = squama.Beam.from_toml("examples/pla_on_vps.toml").replace(scales=None)
DATA = {
    "vary": {"scale.length": ("40 mm", "80 mm"), "scale.alpha": ("35 deg", "68 deg"), "beam.pitch": ("12 mm", "25 mm")},
    "limits": {"gap": "1 mm", "strain": 0.5},
    "front": {"maximise": ["tangent", "range"], "minimise": ["RED"], "at": "60 deg total"},
}


def costs(front):
    signs = {"max": -1, "min": 1}
    return np.stack(
        [signs[v.attrs["objective"]] * v.values for v in front.data_vars.values() if "objective" in v.attrs], axis=1
    )


def hypervolume(points, low, high):
    """Volume that points (all to be small) dominate below ``high``; for two or three objectives, by slices."""
    points = (points - low) / (high - low)
    points = points[(points < 1).all(axis=1)]
    if points.shape[1] == 2:
        order = points[np.argsort(points[:, 0])]
        heights = np.minimum.accumulate(order[:, 1])
        return float(np.sum(np.diff(np.append(order[:, 0], 1)) * (1 - heights)))
    cuts = np.append(np.sort(points[:, 2]), 1)
    return sum(
        (b - a) * hypervolume(points[points[:, 2] <= a][:, :2], np.zeros(2), np.ones(2))
        for a, b in itertools.pairwise(cuts)
    )


def brute(data, y):
    """Return the costs of the best of some points of the unit cube, every contact of their plates tested."""
    target = read_target(data, beam=None if isinstance(data, str) else BEAM, need="front")
    trade = Trade(target, read_settings(target.front, Context(25, "twisting", bare=not isinstance(data, str))))
    seen = trade.evaluate(y, plates=False)
    left = np.flatnonzero(seen.violation <= 0)
    values = seen.values * np.array([-o.sense for o in trade.chosen.objectives])
    other = CODES.index(squama.End.OTHER)
    while True:
        best = left[undominated(values[left])]
        alone = trade.evaluate(y[best], plates=True).found.code != other
        if alone.all():
            return values[best], values[left]
        left = np.setdiff1d(left, best[~alone])


@pytest.fixture(scope="module")
def front():
    return squama.pareto(DATA, beam=BEAM, population=60, generations=40)


def test_no_point_dominates_another_and_each_is_what_it_says(front):
    values = costs(front)
    for i, row in enumerate(values):
        better = (values <= row).all(axis=1) & (values < row).any(axis=1)
        assert not better.any(), i
    assert front.sizes["design"] == 60
    # in the order of the first objective
    assert (np.diff(front[next(iter(front.data_vars))]) >= 0).all()
    for i, beam in list(enumerate(beams(front)))[::7]:
        one = front.isel(design=i)
        r = squama.twist(beam, at="60 deg total", joint="hinge")
        assert r.end.item() == one.end.item()
        assert squama.End(one.end.item()).locks
        assert float(r.Phi_end) == pytest.approx(float(one.rate_end), rel=1e-9)
        assert float(r.K_t[0]) == pytest.approx(float(one["tangent"]), rel=1e-9)
        assert float(r.phi_end - r.phi_e) == pytest.approx(float(one["range"]), rel=1e-9)
        assert float(r.RED_c) == pytest.approx(float(one.RED), rel=1e-9)
        assert math.radians(60) / 25 > float(r.phi_e)
        gap = beam.pitch * math.sin(beam.scale.theta0) * math.cos(beam.scale.alpha) - beam.scale.thickness
        assert gap >= 1e-3
        for name, (low, high) in {k: (front[k].attrs["low"], front[k].attrs["high"]) for k in DATA["vary"]}.items():
            assert low <= float(one[name]) <= high


@pytest.mark.slow
def test_no_worse_than_as_many_random_beams():
    found = squama.pareto("examples/front.toml")
    assert found.population * found.generations == 20_000
    random, everything = brute("examples/front.toml", np.random.default_rng(4).random((20_000, 5)))
    # stiffness and work span decades
    mine, theirs, every = (
        np.stack([-np.log(-v[:, 0]), v[:, 1], -np.log(-v[:, 2])], axis=1) for v in (costs(found), random, everything)
    )
    low, high = np.minimum(mine.min(axis=0), every.min(axis=0)), every.max(axis=0)
    assert hypervolume(mine, low, high) > hypervolume(theirs, low, high)


@pytest.mark.slow
def test_the_front_of_a_grid_in_two_dimensions():
    data = {
        "vary": {"scale.length": ("40 mm", "80 mm"), "scale.alpha": ("45 deg", "68 deg")},
        "front": {"maximise": ["range", "RED"], "population": 80, "generations": 25},
    }
    side = np.linspace(0, 1, 121)
    best, _ = brute(data, np.stack(np.meshgrid(side, side), axis=-1).reshape(-1, 2))
    found = costs(squama.pareto(data, beam=BEAM))
    width = np.ptp(best, axis=0)
    # by how much one set has to be moved so that each point of the other is dominated by one of it
    far, other = (
        ((a[:, None] - b[None]) / width).max(axis=2).min(axis=0).max() for a, b in ((found, best), (best, found))
    )
    assert far < 0.03
    assert other < 0.03


def test_costs_fall_where_objectives_get_better():
    """By their logarithm where they span decades, also below 1 in SI units; what is missing costs as much as 1 N m."""
    data = {**DATA, "front": {"maximise": ["tangent"], "minimise": ["torque", "RED"], "at": "60 deg total"}}
    target = read_target(data, beam=BEAM, need="front")
    trade = Trade(target, read_settings(target.front, Context(25, "twisting", bare=True)))
    values = np.array([[0.01, 0.5, 0.2], [20.0, 1e-3, 0.1], [0.0, np.nan, np.nan]])
    expected = [[-math.log(0.01), math.log(0.5), 0.2], [-math.log(20), math.log(1e-3), 0.1], [0, 0, 0]]
    np.testing.assert_allclose(trade.costs(values), expected, rtol=1e-12)


@pytest.mark.parametrize(
    "asked", [{"generations": 2.5}, {"generations": 0}, {"seed": True}, {"seed": -1}, {"population": 7}]
)
def test_settings_are_whole_numbers(asked):
    (name,) = asked
    with pytest.raises(squama.InputError, match=rf"^front\.{name} = .*: is not a whole number from"):
        squama.pareto({**DATA, "front": {**DATA["front"], **asked}}, beam=BEAM)


def test_a_seed_gives_one_front():
    small = {"population": 16, "generations": 5}
    one, two = (squama.pareto(DATA, beam=BEAM, **small) for _ in range(2))
    assert one.identical(two)
    assert not one.identical(squama.pareto(DATA, beam=BEAM, seed=2, **small))


def test_few_evaluations_find_a_front_where_one_beam_in_twenty_keeps_all_limits():
    assert squama.pareto("examples/front.toml", population=8, generations=1).sizes["design"] >= 4


def test_where_there_is_no_front_it_is_said_what_is_in_the_way():
    never = {**DATA, "limits": {"gap": "12 mm", "overlap": 1.5}}
    with pytest.raises(squama.InputError, match=r"most often missed: .*gap \(100%\)"):
        squama.pareto(never, beam=BEAM, population=8, generations=1)


def test_domination_and_spreading_by_hand():
    points = np.array([[0, 2], [1, 1], [2, 0], [1, 2], [2, 2], [1, 1]], float)
    assert undominated(points).tolist() == [0, 1, 2, 5]
    assert undominated(points[:0]).size == 0
    line = np.stack([np.linspace(0, 1, 50) ** 3, -np.linspace(0, 1, 50)], axis=1)
    keep = spread(line, 9)
    assert keep.size == 9
    assert {0, 49} <= set(keep.tolist())
    assert spread(points[:2][[0, 0, 1]], 5).size == 2


def test_bending_has_fronts_too():
    data = {
        "load": "bending",
        "vary": {"scale.length": ("40 mm", "80 mm"), "beam.pitch": ("12 mm", "25 mm")},
        "front": {"maximise": ["stiffness"], "minimise": ["lock"], "population": 16, "generations": 4},
    }
    found = squama.pareto(data, beam=BEAM)
    beam = beams(found)[0]
    assert float(squama.bend(beam, points=3, joint="hinge").psi_end) == pytest.approx(float(found["lock"][0]), rel=1e-9)
    assert beam.bending_rigidity == pytest.approx(float(found.stiffness[0]), rel=1e-9)


def test_the_table_of_the_summary_has_its_units_in_brackets(front):
    heads = [column.header for column in _designs(front, 3, ["tangent", "RED", "scale.length", "scale.alpha"]).columns]
    assert heads == ["design", "tangent (N m2)", "RED", "scale.\nlength (mm)", "scale.\nalpha (deg)"]

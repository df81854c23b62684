"""What makes the law: the process, its way back, and the torque by which its errors are told."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from shapes import drawn

from squama.joints import law, processes

ROOT = Path(__file__).parents[3]


@pytest.fixture(autouse=True)
def tools(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(ROOT / "tools"))


@pytest.mark.slow
def test_the_torque_is_that_of_the_reference() -> None:
    """Rigid plates, thin and thick, of five geometries; the slip is of first order in both, in other steps."""
    from joint_torque import torque

    table = json.loads((ROOT / "tests" / "reference" / "thick_scales.json").read_text())
    for case in table:
        for name, thickness in (("thin_rigid", 0.0), ("thick_rigid", case["thickness"])):
            curve = case["curves"][name]
            twist, expected = np.array(curve["rows"])[len(curve["rows"]) // 2, :2]
            angles = np.radians([case["alpha_deg"], case["theta0_deg"]])
            numbers = (1.0, case["lam"], 0.2, case["beta"], thickness, *angles, 0.3)
            shape = law.Shape(*(np.array([x]) for x in numbers))
            K = np.eye(9)[None]
            K[0, :7, :7] = case["K"]
            found = torque(shape, K, np.array([case["eta"]]), np.array([twist]), mu=case["mu"])
            assert found.good[0]
            assert found.engagement[0] == pytest.approx(curve["phi_e"], rel=1e-10)
            # tolerance: two methods' steps, 7e-5 measured, on every processor
            assert found.torque[0] == pytest.approx(expected, rel=2e-4)


@pytest.mark.slow
def test_ends_that_are_free_to_come_nearer_change_little() -> None:
    """By the law's K; where the bar can hardly stretch they are as good as held."""
    from joint_torque import torque

    shape, eta = drawn(40), np.full(40, 3.5)
    K = law.stiffness(shape)
    held = torque(shape, K, eta)
    for times, least, most in ((1e6, 0.0, 1e-5), (1.0, 1e-3, 0.02)):
        K[:, 8, 8] = times * law.stiffness(shape)[:, 8, 8]
        free = torque(shape, K, eta, 2 * held.engagement, free=True)
        good = held.good & free.good
        assert good.sum() > 25
        assert least <= np.abs(free.torque / held.torque - 1)[good].max() < most


def test_a_process_finds_a_smooth_function_and_knows_its_errors() -> None:
    from joint_process import fitted, predicted

    rng = np.random.default_rng(2)
    x, at = rng.normal(size=(120, 2)), rng.normal(size=(50, 2))

    def function(x: np.ndarray) -> np.ndarray:
        return np.column_stack([np.sin(x[:, 0]) + 0.3 * x[:, 1], x[:, 0] * x[:, 1]])

    found = fitted(x, function(x))
    assert np.abs(predicted(found, x, at) - function(at)).max() < 0.15
    # each design left out, in truth
    one = 17
    rest = np.delete(np.arange(120), one)
    again = fitted(x[rest], function(x[rest]))
    left = function(x[[one]]) - predicted(again, x[rest], x[[one]])
    np.testing.assert_allclose(found.left_out[one], left[0], atol=3e-4 + 0.3 * np.abs(left).max())


def test_what_is_fitted_is_what_the_law_gives() -> None:
    import joint_law
    import joint_sample

    shape = drawn(30, region=law.WHOLE)
    K = law.stiffness(shape)
    records = joint_sample.Records(np.arange(30), shape, K, K, np.zeros((30, 4, 9, 9)))
    y = joint_law.outputs(shape, records.limit)
    assert y.shape == (30, 45)
    # the factor again, from its logarithms and ratios
    L = np.zeros((30, 9, 9))
    p = np.exp(y[:, :9])
    p[:, 6:] *= np.sqrt(law.bare(shape))
    signs = np.where(law.ODD[9:], np.sin(shape.alpha)[:, None], 1)
    L[:, law.ROWS, law.COLUMNS] = y[:, 9:] * signs * p[:, law.COLUMNS]
    L[:, range(9), range(9)] = p
    order = [0, 1, 2, 3, 5, 4, 6, 7, 8]
    np.testing.assert_allclose(L @ np.swapaxes(L, 1, 2), K[:, order][:, :, order], rtol=1e-9, atol=1e-12)


def test_a_line_cut_short_and_a_packed_design_are_done_once(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    import joint_sample

    file = tmp_path / "sample.jsonl"
    file.write_text('{"index": 5, "refused": "no"}\n{"index": 7, "K": [[1')
    assert [r["index"] for r in joint_sample._lines(file)] == [5]
    assert "cut short" in capsys.readouterr().out
    packed = joint_sample.records(tmp_path, held_out=False)
    assert len(packed.index) > 300
    assert np.isfinite(packed.limit[packed.both]).all()


def corners() -> tuple[law.Shape, np.ndarray]:
    """Return the corners by elements: nine of the core, then two of the whole range."""
    import joint_sample

    cases = json.loads((ROOT / "tests" / "reference" / "joint_corners.json").read_text())
    geometries = [joint_sample.geometry(case["design"]) for case in cases]
    shape = law.Shape(*(np.array([getattr(g, name) for g in geometries]) for name in law.Shape._fields))
    return shape, joint_sample.whole(np.array([case["K"] for case in cases]))


@pytest.mark.slow
def test_the_band_is_that_of_the_place() -> None:
    """Wide in the corners of the range, by elements there; it holds nineteen in twenty designs that were not fitted."""
    import joint_law

    shape, true = corners()
    assert law.within(shape).all()
    assert law.within(shape, law.CORE).tolist() == [True] * 9 + [False] * 2
    # of the last one only the shortest scales touch
    off = np.nanmax(np.abs(joint_law.torque_errors(shape, true, law.stiffness(shape))), axis=0)
    told = law.band(shape)
    # tolerance: digits of the figures
    nearly = [0.0059, 0.0177, 0.0212, 0.0473, 0.0857, 0.1148, 0.0213, 0.0261, 0.0588]
    np.testing.assert_allclose(off[:9], nearly, rtol=0.05)
    assert (off < told).all()
    # nearest designs alone do not say it: they all lie on one side
    core = shape.at(np.arange(9))
    assert (off[:9] > told[:9] / (1 + law.CORNER * law.cornered(core))).sum() == 5
    assert told.min() < 0.025 < 0.5 < told.max()
    for region, middle, most in ((law.CORE, 0.015, 0.1), (law.WHOLE, 0.03, 0.5)):
        r = joint_law.of_region(ROOT / "none", region, held_out=True)
        found = joint_law.torque_errors(r.shape, r.limit, law.stiffness(r.shape))
        known = np.isfinite(found).any(axis=0)
        off, told = np.nanmax(np.abs(found[:, known]), axis=0), law.band(r.shape)[known]
        assert 0.93 < (off < told).mean() < 0.99
        assert np.median(told) < middle
        assert told.max() < most


def test_shallow_tabs_with_thin_scales_are_beyond_the_core() -> None:
    """In the steep corner both fits are 7 to 9 % off in torque: the band is as wide."""
    steep, flat = (law.Shape(*(float(x[i]) for x in corners()[0])) for i in (9, 10))
    for shape in (steep, flat):
        assert law.outside(shape) == []
        assert law.region(shape) is law.WHOLE
        said = "\n".join(map(str, law.outside(shape._replace(zeta=0.08))))
        assert "the law of the joint goes from 0.1 to 0.7 pitches" in said
    assert law.band(flat) < 0.05 < 0.1 < law.band(steep)


def test_a_corner_is_where_several_numbers_are_at_an_end() -> None:
    middle = law.Shape(2.2, 0.55, 0.32, 0.8, 0.24 * np.cos(0.65) * np.sin(0.27), 0.65, 0.27, 0.37)
    assert law.cornered(middle) == 0
    assert law.cornered(middle._replace(nu=0.495)) == 0
    at = middle._replace(nu=0.495, zeta=0.52)
    assert law.cornered(at) == pytest.approx(1 / 7)
    assert law.cornered(at._replace(zeta=0.52 - 0.04 / 2)) == pytest.approx(0.5 / 7)
    assert law.band(at._replace(alpha=-0.65)) == pytest.approx(law.band(at), rel=1e-12)


def test_the_band_of_one_shape_and_of_many() -> None:
    shape = drawn(30, region=law.WHOLE)
    many = law.band(shape)
    for i in (0, 17, 29):
        one = law.band(law.Shape(*(float(x[i]) for x in shape)))
        assert one.shape == ()
        assert float(one) == pytest.approx(many[i], rel=1e-9)
    # the mirror image is as well known
    np.testing.assert_allclose(law.band(shape._replace(alpha=-shape.alpha)), many, rtol=1e-9)
    assert (many >= 2 * 0.003).all()


def test_each_fit_has_its_designs(tmp_path: Path) -> None:
    import joint_law
    import joint_sample

    core, whole = (joint_law.of_region(tmp_path, region, held_out=False) for region in (law.CORE, law.WHOLE))
    for fit_to, place in ((core, processes.PLACE), (whole, processes.WIDER)):
        with np.load(place) as shipped:
            assert len(fit_to.index) == len(shipped["sample"])
    assert core.index.max() < joint_sample.FIRST_WIDE < whole.index.max()
    # those that are too long for either fit are kept
    every = joint_sample.records(tmp_path, held_out=False, wide=True)
    assert law.crowding(whole.shape)[1].max() < joint_law.LONGEST
    assert every.shape.zeta.max() > 1.5
    # nothing that checks the fits is in them
    checks = [joint_law.of_region(tmp_path, region, held_out=True) for region in (law.CORE, law.WHOLE)]
    assert not set(zip(*checks[1].shape, strict=True)) & set(zip(*every.shape, strict=True))
    assert not (law.within(checks[1].shape, law.CORE)).any()
    assert law.within(checks[0].shape, law.CORE).all()

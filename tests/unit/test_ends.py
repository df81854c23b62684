"""Ends as the public function tells them: words, shapes, one design or many, every kind of end."""

from __future__ import annotations

import math

import numpy as np
import pytest

import squama
from properties.designs import many, mirrored
from squama.batch.answers import answers
from squama.model import crossings, evaluation, mechanics, neighbours, reach
from squama.model.outcome import CODES, SENTENCES, End
from squama.model.paths import FLOAT, FoldedTwist, Twist

MAIN = {"eta": 3, "beta": 1.25, "lam": 0.45, "alpha": math.radians(45), "theta0": math.radians(10)}
FOLDED = {**MAIN, "alpha": math.radians(5)}
EVERY_END = [
    ({**MAIN, "mu": 0.5}, "+", "frictional lock"),
    ({**MAIN, "mu": 0.0}, "+", "kinematic lock"),
    ({**MAIN, "mu": 6.0}, "+", "static lock"),
    ({**FOLDED, "mu": 0.1}, "+", "off tip edge"),
    (
        {**MAIN, "eta": 1.2202, "beta": 2.7269, "lam": 1.9978, "alpha": 0.0942, "theta0": 0.0613, "mu": 0.0},
        "+",
        "off side edge",
    ),
    (
        {
            "eta": 2.276,
            "beta": 1.722,
            "lam": 0.406,
            "alpha": math.radians(44.52),
            "theta0": math.radians(9.47),
            "mu": 0,
        },
        "+",
        "other contact",
    ),
    (
        {**MAIN, "eta": 1.292, "beta": 0.92, "lam": 0.744, "alpha": 0.07505, "theta0": 0.21328, "mu": 0.2},
        "+",
        "released",
    ),
    ({**MAIN, "mu": 0.5}, "-", "no engagement"),
]


@pytest.mark.parametrize(("design", "sense", "end"), EVERY_END, ids=[e for *_, e in EVERY_END])
def test_every_kind_of_end(design: dict, sense: str, end: str) -> None:
    e = squama.ends(**design, sense=sense)
    assert str(e.end) == end
    assert End(str(e.end)) in SENTENCES
    assert (e.neighbour == 0) == (end == "no engagement")
    if end in ("no engagement", "static lock"):
        assert e.theta_end == design["theta0"]
        assert e.phi_end == e.phi_e
    else:
        assert e.phi_end > e.phi_e


def test_the_paper_law_at_low_alpha() -> None:
    """Where the edge law runs off the tip edge beyond the fold, the plate law locks."""
    e = [squama.ends(**FOLDED, mu=0.3, law=law) for law in ("edge", "plate")]
    assert [str(x.end) for x in e] == ["off tip edge", "frictional lock"]
    # tolerance: three digits are given
    assert math.degrees(float(e[0].theta_end)) == pytest.approx(23.4, abs=0.1)
    assert float(e[0].phi_end) == pytest.approx(1.38, abs=0.005)


def test_range_end_is_half_a_turn_or_a_scale_on_its_back() -> None:
    columns = many(4000, 41)
    e = squama.ends(**columns)
    there = e.end == "range end"
    assert 2 < there.sum() < 200
    turned = np.isclose(e.phi_end[there] * e.neighbour[there], np.pi, rtol=1e-9)
    on_its_back = np.isclose(e.theta_end[there], math.radians(179), rtol=1e-12)
    assert np.all(turned | on_its_back)


def test_names_of_ends_and_their_sentences() -> None:
    assert set(SENTENCES) == set(End) == {*CODES, End.LINE, End.STOPPED, End.SIDE, End.JOINT}
    assert all(text and not text.endswith(".") for text in SENTENCES.values())
    assert [e for e in End if e.locks] == [End.FRICTIONAL, End.KINEMATIC, End.LINE, End.STATIC]
    assert squama.End is End
    assert End("static lock") == "static lock"


@pytest.mark.slow(but=1)
@pytest.mark.parametrize("law", ["plate", "edge"])
@pytest.mark.parametrize("sense", ["+", "-"])
def test_one_design_or_many(sense: str, law: str) -> None:
    """A single design runs on floats, many in lock-step: the same to rounding."""
    n = 60
    columns = many(n, 42) if sense == "+" else mirrored(n, 43)
    bulk = squama.ends(**columns, sense=sense, law=law)
    for i in range(n):
        one = squama.ends(**{k: float(v[i]) for k, v in columns.items()}, sense=sense, law=law)
        assert (one.end.shape, str(one.end), int(one.neighbour)) == ((), bulk.end[i], bulk.neighbour[i])
        assert str(one.other) == bulk.other[i]
        for name in ("phi_e", "theta_end", "phi_end"):
            assert float(getattr(one, name)) == pytest.approx(getattr(bulk, name)[i], rel=1e-12)
        followed = squama.ends(**{k: float(v[i]) for k, v in columns.items()}, sense=sense, law=law, contacts="all")
        assert followed.phi_e == one.phi_e
        assert followed.neighbour == one.neighbour
        if np.isfinite(one.phi_e):
            assert followed.phi_end <= one.phi_end * (1 + 1e-9)


def test_margins_are_distances_to_the_ends_of_the_edges() -> None:
    """The contact moves towards one end of the tip edge only, in 10^5 designs; the margin knows both."""
    row = Twist(3.0, 1.25, 0.45, 0.6, 0.8, 0.1)
    folded = FoldedTwist(*row[:6], theta_f=1.0)
    pt = row.point(0.4, "edge", FLOAT)
    for p in (-1.2, -0.3, 0.4, 1.3):
        for s in (-0.1, 0.2, 2.9, 3.2):
            for r in (row, folded):
                tip, side = r.places(pt._replace(p=p, s=s))
                assert tip == pytest.approx(min(1.25 - p, 1.25 + p))
                assert side == pytest.approx(min(s, 3 - s))
    f = mechanics.forces(pt, 0.1, 0.2)
    at = evaluation.spot(0.4, evaluation.Design(*row[:6], 0.2, 0.0, 1.0, evaluation.OPEN, 0), evaluation.Room())
    margins = (pt.load_rate, f.D, *row.places(pt), pt.turn)
    assert (at.rate, at.drive, at.tip, at.side, at.turn) == margins
    assert at.least == min(margins)
    assert (at.theta, at.load, at.force, at.torque, at.power) == (0.4, pt.load, f.f, f.torque, f.f * pt.slip_rate)
    # rows without a word about it follow the nearest neighbour
    assert (row.k, folded.k) == (1, 1)
    assert folded.open == row


def test_order_of_the_designs_does_not_matter() -> None:
    columns = many(700, 44)
    order = np.random.default_rng(1).permutation(700)
    straight = squama.ends(**columns)
    shuffled = squama.ends(**{k: v[order] for k, v in columns.items()})
    for name in ("end", "neighbour", "other"):
        assert getattr(shuffled, name).tolist() == getattr(straight, name)[order].tolist()
    for name in ("phi_e", "theta_end", "phi_end"):
        np.testing.assert_allclose(getattr(shuffled, name), getattr(straight, name)[order], rtol=1e-13)


def test_broadcasting() -> None:
    mu, eta = np.array([0.1, 0.5, 0.9])[:, None], np.array([2.0, 3.0])
    e = squama.ends(**{**MAIN, "eta": eta}, mu=mu)
    assert {v.shape for v in e} == {(3, 2)}
    for i in range(3):
        for j in range(2):
            one = squama.ends(**{**MAIN, "eta": eta[j]}, mu=mu[i, 0])
            assert (str(one.end), float(one.phi_end)) == (e.end[i, j], pytest.approx(e.phi_end[i, j], rel=1e-12))
    empty = squama.ends(**MAIN, mu=[])
    assert {v.shape for v in empty} == {(0,)}


def test_the_first_event_wins_among_the_plates() -> None:
    """With all contacts a path ends at the first of all pairs, and says which."""
    at = {**MAIN, "mu": [0.0, 0.1, 0.5]}
    tip, every = squama.ends(**at), squama.ends(**at, contacts="all")
    assert tip.end.tolist() == ["kinematic lock", "frictional lock", "frictional lock"]
    assert every.end.tolist() == ["other contact", "other contact", "frictional lock"]
    assert every.other.tolist() == 2 * ["tip edge C1B1 on tip edge C2B2 (k = 1)"] + [""]
    # tolerance: recorded with nine digits
    assert every.theta_end[:2] == pytest.approx(1.46820783, abs=1e-8)
    assert every.phi_end[2] == tip.phi_end[2]
    assert tip.other.tolist() == ["", "", ""]
    touching = squama.ends(**MAIN, mu=0.5, sense="-", contacts="all")
    assert str(touching.other) == "side edge A1B1 on base edge D2A2 (k = 1)"
    assert str(touching.end) == "no engagement"
    # without engagement the path has no end; where the plates touch is told beside it
    assert (float(touching.phi_end), float(touching.theta_end)) == (math.inf, MAIN["theta0"])
    assert (float(touching.phi_touch), float(touching.theta_touch)) == (pytest.approx(0.386690988), MAIN["theta0"])
    np.testing.assert_array_equal(every.phi_touch, [*every.phi_end[:2], np.nan])
    np.testing.assert_array_equal(every.theta_touch, [*every.theta_end[:2], np.nan])
    assert np.isnan([tip.phi_touch, tip.theta_touch]).all()
    assert every.sense.tolist() == 3 * ["+"]
    assert str(touching.sense) == "-"


@pytest.mark.slow
@pytest.mark.parametrize("sense", ["+", "-"])
def test_the_largest_designs_are_answered(sense: str) -> None:
    for eta, beta in ((reach.LARGEST, reach.LARGEST), (reach.LARGEST, 1.25), (3.0, reach.LARGEST)):
        at = {**MAIN, "eta": eta, "beta": beta, "alpha": np.radians([1.0, 45.0, 89.0])}
        assert squama.ends(**at, mu=0.2, sense=sense, contacts="all").end.shape == (3,)
        with pytest.raises(squama.InputError, match=r"must be more than 0, up to 100; write e\.g\."):
            squama.ends(**{**at, "eta": 1e9}, mu=0.2)


def test_the_bound_of_the_neighbours_is_what_a_tip_can_reach() -> None:
    dice = np.random.default_rng(4)
    n = 200
    eta, beta, theta = dice.uniform(1, 8, n), dice.uniform(0.1, 3, n), dice.uniform(0.01, 3, n)
    alpha = dice.uniform(-1.5, 1.5, n)
    one = np.ones(n)
    row = Twist(eta, beta, 0.4 * one, np.sin(alpha), np.cos(alpha), 0.1 * one, one)
    # neighbour k is met at k = (eta - s) cos a cos th + (beta + p) sin a, 0 <= s <= eta, -beta <= p <= beta
    along = [(eta - s) * np.cos(alpha) * np.cos(theta) for s in (0 * eta, eta)]
    across = [(beta + p) * np.sin(alpha) for p in (-beta, beta)]
    farthest = np.maximum(*along) + np.maximum(*across)
    spare = neighbours.reach_at(row, np.cos(theta)) - farthest
    assert (spare > 0).all()
    assert (spare < 1e-7).all()


def test_neighbours_that_a_tip_reaches_only_early_in_an_interval(monkeypatch) -> None:
    # at the end of the interval in which it is met the tip is too high for the neighbour
    designs = {
        "eta": np.array([5.789271953756154, 6.6502390392195]),
        "beta": np.array([2.423783525705396, 2.879415975862547]),
        "lam": np.array([0.4529943636549085, 0.35606644769543827]),
        "alpha": np.radians([38.107097370141055, 31.153160464182204]),
        "theta0": np.radians([12.706464598334026, 14.802921034099503]),
        "mu": 0.0,
    }
    coarse = squama.ends(**designs)
    monkeypatch.setattr(crossings, "AWAY", 8.0)
    fine = squama.ends(**designs)
    assert (coarse.end == "other contact").all()
    assert (fine.end == "other contact").all()
    np.testing.assert_allclose(coarse.phi_end, fine.phi_end, rtol=1e-9)


@pytest.mark.slow(but=1)
@pytest.mark.parametrize("law", ["edge", "plate"])
@pytest.mark.parametrize("sense", ["+", "-"])
def test_the_quick_look_for_neighbours_overlooks_none(law: str, sense: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Also where the path follows another than the next scale, and that one comes in."""
    dice, n = np.random.default_rng(17), 6_000 if sense == "+" else 12_000
    u = dice.uniform
    d = u(1.05, 9, n), u(0.05, 3, n), u(0.02, 1.2, n), np.radians(u(1, 89, n)), np.radians(u(0.2, 60, n)), u(0, 2, n)
    quick = answers(d, law=law, sense=sense, load="twisting")
    # every third design, and all on whose way another scale comes in or stands before
    some = np.flatnonzero((np.arange(n) % 3 == 0) | (quick.neighbour > 1) | (quick.crossing > 0))
    monkeypatch.setattr(crossings, "NEAR", 0)
    close = answers(tuple(v[some] for v in d), law=law, sense=sense, load="twisting", few=n)
    assert (quick.code[some] == close.code).all()
    assert (quick.crossing[some] == close.crossing).all()
    np.testing.assert_allclose(quick.load_end[some], close.load_end, rtol=1e-11)
    assert (close.crossing > 1).sum() > 100 or sense == "-"
    assert ((close.neighbour > 1) & (close.crossing == 1)).sum() > 30 or sense == "+"

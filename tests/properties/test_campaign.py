"""A small part of the campaign of random designs, and single designs that it found."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import squama
from campaigns import random_designs
from properties.designs import Drawn, designs
from properties.test_first_event import early_ends
from squama.batch import Solved, solved


def ways(d: Drawn, law: str, sense: str, margin: float = 0.01) -> list[Solved]:
    """Answers by Python and by compiled code."""
    flat = (*(np.array([v]) for v in d), np.zeros(1))
    return [solved(flat, law=law, sense=sense, margin=margin, load="twisting", few=few) for few in (1, -1)]


@pytest.mark.parametrize("seed", range(5))
def test_a_small_trial(seed: int, capsys: pytest.CaptureFixture[str]) -> None:
    assert random_designs.trial(seed, size=3000, alone=10, looked_at=2) == []
    assert "3000 designs" in capsys.readouterr().out


def test_a_trial_tells_of_failures(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(random_designs, "impossible", lambda s: {"RED": s.code == 0})
    lines = random_designs.trial(4, size=100, alone=1)
    assert "bending, RED: eta " in lines[0]


@pytest.mark.parametrize(
    ("law", "end", "phi"), [("edge", "off tip edge", 1.583754364), ("plate", "frictional lock", 1.574308285)]
)
def test_a_fold_beside_the_kinematic_lock(law: str, end: str, phi: float) -> None:
    """Two branches of the contact condition nearly meet there; the path ran into the gap between them."""
    d = Drawn(20.104921838796564, 20.0, 0.013749962922690926, 0.024267869216065167, 0.8352663088656036, 0.0)
    for s in ways(d, law, "+"):
        assert (str(s.end[0]), round(float(s.load_end[0]), 9)) == (end, phi)
    assert early_ends(d, "+", law, 20_000) == []


def test_a_margin_that_touches_zero_is_found_by_its_lowest_place() -> None:
    d = Drawn(2.770885, 2.694089, 0.4968139, 0.8474815, 0.3356926, 2.0385e-6)
    for s in ways(d, "plate", "-"):
        assert (str(s.end[0]), round(float(s.theta_end[0]), 9)) == ("frictional lock", 0.335928823)


def test_the_last_interval_of_an_open_path_is_looked_at() -> None:
    """Samples stand farther apart there, and a dip of the drive stood between two of them."""
    d = Drawn(
        1.9247960813856004,
        2.8244512921306373,
        7.3083021482469075,
        0.23447907847682428,
        0.3943718215123195,
        1.9808043716,
    )
    for s in ways(d, "edge", "+"):
        assert s.end[0] == "frictional lock"
        assert 2.405 < s.theta_end[0] < 2.41
    assert early_ends(d, "+", "edge", 5000) == []


@pytest.mark.parametrize(
    ("law", "d"),
    [
        ("edge", Drawn(1.1433923794, 12.3726484337, 0.7732817037, 1.18536499626, 0.0320791419393, 54.070062013)),
        ("edge", Drawn(1.78619025840, 9.84114084363, 1.50470930935, 0.947536279627, 0.0262751415449, 32.2747744284)),
        (
            "plate",
            Drawn(0.623824623175, 4.84436973823, 0.443521411246, 0.911623591782, 0.00130046175800, 70.4980481114),
        ),
    ],
)
def test_a_dip_just_behind_the_engagement_is_found(law: str, d: Drawn) -> None:
    """With it missed, the work of friction was below zero."""
    for s in ways(d, law, "+"):
        assert s.end[0] == "frictional lock"
        assert s.W_fr[0] > 0
    assert early_ends(d, "+", law, 5000) == []


def test_another_neighbour_comes_in_where_it_does_whatever_the_friction() -> None:
    ratios = {"eta": 17.4272, "beta": 18.099, "lam": 1.54289, "alpha": 0.146988, "theta0": 0.0279871}
    e = squama.ends(**ratios, mu=[0, 0.5, 1.07, 1.17, 1.3, 2])
    assert set(e.end) == {"other contact"}
    np.testing.assert_allclose(e.phi_end, 0.30187257, rtol=1e-7)
    assert {other.split("(")[1] for other in e.other} == {"k = 5)"}


def test_plates_touch_where_they_do_whatever_the_friction() -> None:
    """Edges that become parallel after a whole turn meet nowhere; some samples, put by friction, said they did."""
    ratios = {
        "eta": 8.3824102317,
        "beta": 4.2526835395,
        "lam": 0.2222330288,
        "alpha": 0.1369045217,
        "theta0": 0.64360662,
    }
    e = squama.ends(**ratios, mu=[0.0, 0.2, 0.5, 0.6, 1.0], contacts="all")
    np.testing.assert_allclose(e.phi_end, 0.79945201037, rtol=1e-7)
    assert set(e.other) == {"tip edge C1B1 on tip edge C2B2 (k = 1)"}


@given(designs(mu=(0.0, 3.0)), st.floats(0.0, 3.0), st.sampled_from("+-"))
def test_more_friction_never_ends_a_path_later(d: Drawn, more: float, sense: str) -> None:
    """At a lock of the law `edge` friction works against the scale, so more of it locks before; see theory, forces."""
    e = squama.ends(**d._asdict() | {"mu": [d.mu, d.mu + more]}, sense=sense)
    assert e.phi_end[1] <= e.phi_end[0] * (1 + 1e-12)


def test_the_law_plate_may_lock_later_with_more_friction() -> None:
    """Where its friction lifts the scale: the moment of the normal force alone had already vanished."""
    group = random_designs.Group("twisting", "plate", "+")
    columns = random_designs.drawn(group, 0, 3000)
    less, more = (random_designs.answers(group, columns | {"mu": columns["mu"] * by + 1e-9}) for by in (1, 1.3))
    found, helped = random_designs.later(group, columns, less, more)
    assert found.size > 2
    np.testing.assert_array_equal(found, helped)


@pytest.mark.parametrize("margin", [1e-9, 1e-6, 0.01])
def test_figures_near_a_lock_are_numbers(margin: float) -> None:
    for group in random_designs.GROUPS:
        s = random_designs.answers(group, random_designs.drawn(group, 1, 5000), margin=margin)
        assert not np.any([*random_designs.impossible(s).values()])


def test_a_path_shorter_than_rounding_has_figures() -> None:
    """Just below the static lock the whole path is as short as the error of its end."""
    d = {"eta": 3.0, "beta": 1.25, "lam": 0.45, "alpha": math.radians(45), "theta0": math.radians(10)}
    static = float(squama.forces(d["theta0"], mu=0.0, **d).mu_lock)
    for few in (100, -1):
        mu = static * (1 - np.array([1e-6, 1e-9, 1e-12, 1e-14, 1e-15, 3e-16, 0.0]))
        flat = (*(np.full(7, v) for v in d.values()), mu, np.zeros(7))
        s = solved(flat, law="edge", sense="+", margin=1e-9, load="twisting", few=few)
        assert not np.any([*random_designs.impossible(s).values()])
        assert np.all(s.f0 >= 0)
        assert np.all(np.diff(s.W_fr) <= 0)

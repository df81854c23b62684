"""Jumps of scales: which contact is named, and what is said of them."""

import numpy as np
import pytest

import squama
from squama.contacts import events, follow, increments
from squama.contacts.touch import EE, FE


class Jumped:
    """What is looked at of a path behind a jump: contacts before and behind, and their forces."""

    def __init__(self, before: list[tuple[int, ...]], behind: list[tuple[int, ...]], forces: list[float]) -> None:
        self.counts = np.array([len(behind), len(before)])
        self.con, self.kept = (np.zeros((8, 7), np.int64) for _ in range(2))
        self.con[: len(behind), :5], self.kept[: len(before), :5] = behind or [(0,) * 5], before or [(0,) * 5]
        self.now = self.old = type("State", (), {"F": np.zeros((8, 3))})
        self.now.F[: len(forces), 2] = forces


A, B, C = (0, 1, EE, 0, 1), (1, 1, EE, 0, 1), (1, 1, FE, 1, 1)


@pytest.mark.parametrize(
    ("before", "behind", "forces", "named"),
    [
        ([A, B], [A, B, C], [9.0, 8.0, 1.0], (2, -1)),
        ([A], [A, B, C], [9.0, 1.0, 2.0], (2, -1)),
        ([A, B], [A], [9.0, 1.0], (-1, 1)),
        ([A, B], [A, C], [9.0, 1.0], (1, -1)),
        ([A, B], [A, B], [1.0, 2.0], (1, -1)),
        ([A], [], [1.0], (-1, 0)),
        ([], [], [], (-1, -1)),
    ],
)
def test_a_jump_names_the_contact_that_changed(monkeypatch, before, behind, forces, named):
    plain, altered = (getattr(f, "py_func", f) for f in (follow.strongest, follow.altered))
    monkeypatch.setattr(follow, "strongest", plain)
    assert altered(Jumped(before, behind, forces)) == named


def event(kind: int, before: tuple[str, ...], after: tuple[str, ...]) -> events.Event:
    return events.Event(kind, 0.1, 0.0, 0.1, "TS", before, after, 0.0)


def test_what_is_said_of_a_jump():
    change = increments.CHANGE
    assert event(change, ("TS",), ("TS",)).word == "jump of the scales"
    assert event(change, ("TS",), ("BF",)).word == "TS to BF"
    assert event(change, ("TS", "BF"), ("TS",)).word == "release (BF)"
    assert event(change, ("TS",), ("TS", "BF")).word == "another contact (BF)"
    assert event(increments.SNAP, ("TS",), ("BF",)).word == "snap to BF"


@pytest.mark.parametrize(
    ("first", "then", "contact", "later", "none"),
    [
        (increments.ENGAGE, increments.OPEN, "TS", 1e-9, True),
        (increments.SLIDE, increments.STICK, "TS", 1e-9, True),
        (increments.ENGAGE, increments.OPEN, "TS", 1e-3, False),
        (increments.ENGAGE, increments.OPEN, "BF", 1e-9, False),
        (increments.ENGAGE, increments.SLIDE, "TS", 1e-9, False),
    ],
)
def test_what_is_taken_back_at_once_is_no_event(first, then, contact, later, none):
    one = event(first, (), ("TS",))
    assert events.undone(one, one._replace(kind=then, way=one.way + later, contact=contact)) == none


@pytest.mark.parametrize(("points", "mu"), [(50, 0.3), (317, 0.25), (400, 0.25)])
def test_a_contact_that_opens_as_another_sticks(points, mu):
    """Both cannot slide on: the tip edge sticks, and its corner comes off."""
    beam = squama.Beam.from_toml("examples/stiff_skin.toml")
    legs = "bend .1 rad/pitch; twist .15 rad/pitch; bend .05 rad/pitch"
    r = squama.bend_twist(beam, legs, points=points, mu=mu, ends="endless")
    assert r.end.item() == "range end"
    assert r.contact.values[-1] == "TS"
    assert abs(float(r.energy_error)) < 5e-4

"""Jumps of scales: which contact is named, and what is said of them."""

import numpy as np
import pytest

import squama
from squama.contacts import events, follow, increments, slipped, tally
from squama.contacts.touch import EE, FE, LET_GO, STUCK


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


@pytest.mark.parametrize(
    ("contacts", "times"), [([], 0), ([A], 0), ([A, B], 0), ([A, A], 1), ([A, B, A, C, A, B], 2), ([B, C, C, C, C], 3)]
)
def test_a_contact_that_creeps_is_counted(monkeypatch, contacts, times):
    monkeypatch.setattr(slipped, "number", getattr(increments.number, "py_func", increments.number))
    walk = Jumped([], [*contacts, A, A], [])
    # those that bear again at the end do not count
    walk.con[: len(contacts), STUCK] = LET_GO
    assert getattr(slipped.relapses, "py_func", slipped.relapses)(walk) == times


@pytest.mark.parametrize(
    ("gives_up", "found", "looks"), [(True, 0, 2), (True, increments.NO_EQUILIBRIUM, 2), (False, 1, 1), (False, 0, 1)]
)
def test_what_is_given_up_in_haste_is_looked_at_again(monkeypatch, gives_up, found, looks):
    """A branch that only a long walk reaches is followed: it is walked where nothing else was found."""
    walk, seen = Jumped([A], [A], [1.0]), []
    walk.tally = np.zeros(tally.TALLY)

    def landed(w, *_: object) -> int:
        hasty = w.tally[tally.HASTY] > 0
        seen.append(hasty)
        if hasty and gives_up:
            w.tally[tally.HASTY] = 2.0
            return increments.NO_EQUILIBRIUM
        return found

    monkeypatch.setattr(follow, "landed", landed)
    for name in ("keep", "restore"):
        monkeypatch.setattr(follow, name, lambda w: None)
    assert getattr(follow.jump, "py_func", follow.jump)(walk, 1.0, 4e-3, 0, walk.con) == found
    assert seen == [True, False][:looks]


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

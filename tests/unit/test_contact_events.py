"""What the contact solver writes of events: where they are, what they lose, and nothing beside them."""

from __future__ import annotations

import numpy as np
import pytest

from legs import follow_legs
from squama.contacts import events, increments, path
from squama.joints import law

SHAPE = law.Shape(0.8961, 0.51, 0.3, 0.43, 0.034, 0.802851, 0.191986, 0.45)
SCALE = path.Scale(1.8, 0.43, 0.51, 0.802851, 0.191986, 0.034, np.inf, 0.35)
"""Snaps on its way, and back."""
CORNERS = np.array([(-0.072, 0.3), (0.0, 0.0)])


def followed(n: int) -> path.Answers:
    """Follow the beam there and back, n stations on each leg."""
    ways = np.linspace(0.0, 1.0, n + 1)[1:, None]
    corners = np.concatenate([ways * CORNERS[0], CORNERS[0] * (1 - ways)])
    return follow_legs(SCALE, law.stiffness(SHAPE), 0.2, corners).answers


@pytest.fixture(scope="module")
def found() -> path.Answers:
    return followed(20)


def test_a_contact_that_is_gone_is_told_where_it_was() -> None:
    """On the way back a corner slides to the end of an edge, and off it."""
    shape = law.Shape(0.41111, 0.6418, 0.3, 0.4825, 0.0348, 1.282817, 0.360760, 0.45)
    scale = path.Scale(3.41, 0.4825, 0.6418, 1.282817, 0.360760, 0.0348, np.inf, 0.35)
    found = follow_legs(scale, law.stiffness(shape), 0.2, np.array([(0.06, 0.3), (0.0, 0.0)])).answers
    gone, row = events.events(found)[-1], found.events[0, int(found.ends[0, 2]) - 1]
    assert gone.word == "snap: the contact opens"
    assert gone.before == (gone.contact,) == ("side edge A1B1 on side edge D2C2",)
    assert gone.lost == row[12] > 1e-6
    # the number of contacts, places, codes of contacts; the other place is on the edge, a little before its end
    assert row[13] == 0
    assert row[14] == pytest.approx(scale.eta, abs=1e-6)
    assert 0.9 * scale.eta < row[15] < scale.eta
    assert (row[increments.AFTER :] == -1).all()


def test_only_snaps_lose_energy(found: path.Answers) -> None:
    told = events.events(found)
    kinds = [event.kind for event in told]
    assert {increments.ENGAGE, increments.SNAP, increments.SLIDE, increments.OPEN} <= set(kinds)
    lost = np.array([event.lost for event in told])
    assert (lost[np.array(kinds) != increments.SNAP] == 0).all()
    assert lost.sum() == pytest.approx(path.named(found.rows[0])["W_snap"][-1], rel=1e-12)
    assert lost.max() > 1e-5


def test_events_are_on_the_path(found: path.Answers) -> None:
    far = np.hypot(*CORNERS[0])
    for event in events.events(found):
        share = 1 - abs(event.way / far - 1)
        assert (event.psi, event.phi) == pytest.approx(tuple(share * CORNERS[0]), rel=1e-9)


def test_stations_make_no_events(found: path.Answers) -> None:
    """A straight way is the same however many states of it are told."""
    some, every = events.events(followed(2)), events.events(found)
    assert [event.kind for event in some] == [event.kind for event in every]
    # tolerance: increments end at stations, and friction is summed over them
    assert [event.way for event in some] == pytest.approx([event.way for event in every], rel=1e-5)


def test_room_for_contacts_that_are_not_there_stays_empty(found: path.Answers) -> None:
    counts = path.named(found.rows[0])["contacts"].astype(int)
    assert set(counts) == {0, 1}
    for n, touches in zip(counts, found.touches[0], strict=True):
        assert not touches[n:].any()

"""The small solver: a balance that can be written down, no way through a contact, and the trail of equilibria."""

import numpy as np
import pytest

pytest.importorskip("ipctk", reason="needs the extra fe")

from squama.fe import balance as solver
from squama.fe.balance import Balance, Trail
from squama.fe.contact import RowContact, stiffness
from squama.fe.plate import Rest
from squama.fe.rows import Row

DHAT = 1e-3
REST = Rest.at(3.0, 0.6, 0.32, np.radians(45), np.radians(10))
K = np.diag([0.4, 0.5, 0.4, 0.05, 0.0119, 0.06])
FREE, HINGE = np.eye(6), np.eye(6)[:, 4:5]
KAPPA = stiffness(1e-3, DHAT)


def body(v, phi):
    """Springs that pull to a motion which grows with the twist."""
    drift = np.array([0.0, 0.01, 0, 0, 0.05, 0])
    return K @ (v - drift * phi), K, -K @ drift


@pytest.fixture(scope="module")
def contact():
    return RowContact(Row(REST), 0.3, dhat=DHAT)


def test_without_contact_the_springs_decide(contact):
    found = Balance(body, contact, None, KAPPA, FREE).find(np.zeros(6), 0.02)
    assert found.solved
    np.testing.assert_allclose(found.v, [0, 0.0002, 0, 0, 0.001, 0], atol=1e-13)
    np.testing.assert_allclose(found.rate, [0, 0.01, 0, 0, 0.05, 0], atol=1e-12)


@pytest.mark.parametrize("ways", [FREE, HINGE], ids=["free", "hinge"])
def test_a_balance_in_contact_leaves_no_force(contact, ways):
    before = contact.corners(np.zeros(6), 0.055)
    found = Balance(body, contact, before, KAPPA, ways).advance((np.zeros(6), 0.055), (np.zeros(6), 0.08))
    assert found.solved
    assert found.phi == 0.08
    load = contact.load(found.v, found.phi, before, KAPPA)
    left = ways.T @ (body(found.v, 0.08)[0] + load.total[:6])
    assert np.abs(left).max() < 1e-9 * np.abs(K @ found.v).max()
    assert load.strongest.f == pytest.approx(0.3 * load.strongest.N, rel=1e-9)
    if ways is HINGE:
        assert not found.v[[0, 1, 2, 3, 5]].any()
    # the rate is the derivative of this increment's end
    h = 1e-7
    more = Balance(body, contact, before, KAPPA, ways, tolerance=1e-12).find(found.v, 0.08 + h)
    np.testing.assert_allclose((more.v - found.v) / h, found.rate, atol=2e-4 * np.abs(found.rate).max())


def test_a_long_increment_does_not_go_through_the_neighbour(contact):
    before = contact.corners(np.zeros(6), 0.0)
    found = Balance(body, contact, before, KAPPA, HINGE).advance((np.zeros(6), 0.0), (np.zeros(6), 0.2))
    assert found.solved
    corners = contact.corners(found.v, 0.2)
    assert not contact._ipc.has_intersections(contact._mesh, np.asfortranarray(corners))
    assert 0 < contact.gap(corners) < DHAT
    # a hinge that follows the contact of rigid plates: squama.contact(3, .6, .32, 45 deg, theta0 = 10 deg)
    # tolerance: the barrier keeps a gap of up to DHAT, which hinges without one do not
    assert np.radians(10) - found.v[4] == pytest.approx(0.64854, abs=1e-3)


def test_where_no_balance_is_found_it_says_so(contact):
    def runaway(v, phi):
        return np.full(6, 1.0), np.eye(6), np.zeros(6)

    found = Balance(runaway, contact, None, KAPPA, FREE).find(np.zeros(6), 0.01)
    assert not found.solved
    assert found.rounds <= solver.ROUNDS


def test_steps_are_no_longer_than_the_reach_and_are_halved_where_they_overshoot(contact):
    goal = 0.35 * np.eye(6)[0]
    found = Balance(lambda v, phi: (K @ (v - goal), K, np.zeros(6)), contact, None, KAPPA, FREE).find(np.zeros(6), 0.0)
    assert found.solved
    # .1, .2, .3, .35
    assert found.rounds == 4
    np.testing.assert_allclose(found.v, goal, atol=1e-12)

    def bounded(v, phi):
        return np.arctan(100 * v), np.diag(100 / (1 + (100 * v) ** 2)), np.zeros(6)

    # its Newton steps without halving would go farther and farther away
    found = Balance(bounded, contact, None, KAPPA, FREE).find(0.15 * goal, 0.0)
    assert found.rounds > 1
    np.testing.assert_allclose(found.v, 0, atol=1e-9)


def test_the_trail_extrapolates_a_parabola():
    trail = Trail([point(0.0)])
    np.testing.assert_array_equal(trail.expected(0.1), point(0.0)[0])
    trail.add(*point(0.1))
    np.testing.assert_allclose(trail.expected(0.2), 2 * point(0.1)[0] - point(0.0)[0])
    trail.add(*point(0.25))
    np.testing.assert_allclose(trail.expected(0.3), point(0.3)[0])
    trail.add(*point(0.4))
    np.testing.assert_allclose(trail.expected(0.43), point(0.43)[0])


def test_the_slip_has_the_direction_of_the_motion_at_the_increments_end():
    trail = Trail([point(0.1)])
    np.testing.assert_array_equal(trail.before(0.2), point(0.1)[2])
    assert trail.stretch(0.2) == 1
    trail.add(*point(0.25))
    slip = point(0.3)[2] - trail.before(0.3)
    rate = 2 * 0.3 * np.ones((4, 3)) + SHIFT
    np.testing.assert_allclose(slip * trail.stretch(0.3) / 0.05, rate)


def test_a_twist_that_turns_back_forgets_the_way_there():
    trail = Trail([point(0.1)])
    trail.add(*point(0.25))
    np.testing.assert_array_equal(trail.before(0.2), point(0.25)[2])
    np.testing.assert_array_equal(trail.expected(0.2), point(0.25)[0])


SHIFT = np.arange(12.0).reshape(4, 3)


def point(phi):
    """Motions and corners that are parabolas of the twist."""
    return np.arange(6) * phi**2 + phi, phi, phi**2 * np.ones((4, 3)) + phi * SHIFT


def test_a_scale_that_is_let_go_does_not_overshoot(contact):
    def narrow(v, phi):
        return np.arctan(1e3 * v), np.diag(1e3 / (1 + (1e3 * v) ** 2)), np.zeros(6)

    found = Balance(narrow, contact, None, KAPPA, FREE).fall(3e-3 * np.array([0, 1.0, -1, 0, 1, 0]), 0.01)
    assert found.solved
    np.testing.assert_allclose(found.v, 0, atol=1e-9)


def test_let_go_a_scale_falls_back_on_its_neighbour(contact):
    lifted = np.array([0.0, 0, 0, 0, -0.1, 0])
    found = Balance(body, contact, None, KAPPA, FREE).fall(lifted, 0.08)
    assert found.solved
    load = contact.load(found.v, 0.08, None, KAPPA)
    assert load.strongest.N > 0
    assert np.abs(body(found.v, 0.08)[0] + load.total[:6]).max() < 1e-8

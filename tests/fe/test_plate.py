"""The rigid scale's motion: against SciPy's rotations, finite differences, and the geometry of the theory."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from squama.fe.exposed import sheet
from squama.fe.plate import Attached, Carried, Rest, inclination, pose, rotation, turned
from squama.fe.rows import Placed, Row

ALPHA, THETA0 = np.radians(40), np.radians(12)
REST = Rest.at(3.0, 0.6, 0.32, ALPHA, THETA0)
SMALL, SERIES, MIDDLE, LARGE = 1e-4, 0.05, 0.3, 1.2


def differences(f, q, h=1e-5):
    return np.stack([(f(q + h * e) - f(q - h * e)) / (2 * h) for e in np.eye(q.size)], -1)


@pytest.mark.parametrize("size", [0.0, SMALL, SERIES, MIDDLE, LARGE])
def test_turns_are_those_of_scipy_and_their_derivatives_are_right(rng, size):
    w = rng.normal(size=3) * size
    r = rotation(w)
    np.testing.assert_allclose(r.E, Rotation.from_rotvec(w).as_matrix(), atol=1e-13)
    np.testing.assert_array_equal(r.E, turned(w))
    np.testing.assert_allclose(np.moveaxis(r.dE, 0, -1), differences(turned, w), atol=2e-9)
    np.testing.assert_allclose(np.moveaxis(r.ddE, 1, -1), differences(lambda w: rotation(w).dE, w), atol=2e-9)


def test_the_series_of_small_turns_meets_the_closed_form():
    from squama.fe.plate import _factors

    below, above = _factors(0.1 * (1 - 1e-15)), _factors(0.1 * (1 + 1e-15))
    np.testing.assert_allclose(below, above, rtol=2e-9)


def test_the_axes_at_rest_are_those_of_the_theory():
    n_X, n_Y, n_Z = REST.axes
    np.testing.assert_allclose(n_X, [-np.sin(ALPHA) * np.cos(THETA0), np.sin(THETA0), np.cos(ALPHA) * np.cos(THETA0)])
    np.testing.assert_allclose(n_Y, [np.cos(ALPHA), 0, np.sin(ALPHA)])
    np.testing.assert_allclose(n_Z, np.cross(n_X, n_Y))
    D, A, B, C = Placed(Row(REST), np.zeros(6), 0.0).corners[:4]
    np.testing.assert_allclose([D, A], [REST.base - 0.6 * n_Y, REST.base + 0.6 * n_Y])
    np.testing.assert_allclose([C, B], [D + 3 * n_X, A + 3 * n_X])


@pytest.mark.parametrize("turn", [0.0, 0.3, 1.6])
def test_lifting_a_scale_is_a_turn_about_minus_n_Y(turn):
    v = np.array([0.1, 0, 0, 0, -turn, 0])
    assert inclination(REST, v) == pytest.approx(THETA0 + turn)
    lifted = Rest.at(3.0, 0.6, 0.32, ALPHA, THETA0 + turn)
    c, R = pose(REST, v)
    np.testing.assert_allclose(R @ REST.axes[0], lifted.axes[0], atol=1e-13)
    np.testing.assert_allclose(c, REST.base + 0.1 * REST.axes[0])


def test_roll_and_yaw_do_not_count_as_inclination_to_first_order():
    for i in (3, 5):
        v = np.zeros(6)
        v[i] = 1e-4
        assert abs(inclination(REST, v) - THETA0) < 1e-8


def test_attached_points_follow_the_pose_with_right_derivatives(rng):
    points, v = rng.normal(size=(5, 3)), rng.normal(size=6) * 0.4
    attached, forces = Attached(REST, points), rng.normal(size=(5, 3))
    c, R = pose(REST, v)
    np.testing.assert_allclose(attached.places(v), c + (points - REST.base) @ R.T, atol=1e-13)
    np.testing.assert_allclose(attached.rates(v), differences(attached.places, v), atol=1e-8)
    second = differences(lambda v: np.tensordot(forces, attached.rates(v), 2), v)
    np.testing.assert_allclose(attached.curvature(v, forces), second, atol=1e-8)


@pytest.mark.parametrize("k", [0, 3])
def test_carried_points_have_right_derivatives_by_motions_and_twist(rng, k):
    points, q = rng.normal(size=(5, 3)), rng.normal(size=7) * 0.4
    carried, forces = Carried(REST, points, k, 0.5), rng.normal(size=(5, 3))
    rates = carried.rates(q[:6], q[6])
    np.testing.assert_allclose(rates, differences(lambda q: carried.places(q[:6], q[6]), q), atol=1e-8)
    second = differences(lambda q: np.tensordot(forces, carried.rates(q[:6], q[6]), 2), q)
    np.testing.assert_allclose(carried.curvature(q[:6], q[6], forces), second, atol=1e-7)


def test_images_are_turned_clockwise_and_moved_by_a_pitch(rng):
    row, v, phi = Row(REST), rng.normal(size=6) * 0.2, 0.37
    assert row.reach == 4
    corners = Placed(row, v, phi).corners.reshape(-1, 4, 3)
    c, s = np.cos(phi), np.sin(phi)
    R = np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])
    for k in range(row.reach):
        np.testing.assert_allclose(corners[k + 1], corners[k] @ R.T + [0, 0, 1], atol=1e-13)


def bending():
    """A thick plate with two ways of bending."""
    plate = sheet(np.array([0.0, 1, 3]), np.array([-0.6, 0.6]), 0.1)
    modes = np.random.default_rng(2).normal(size=(len(plate.points), 3, 2))
    return plate.bending(modes, np.array([[2.0, 0.3], [0.3, 1.0]]))


ROWS = {
    "endless": Row(REST),
    "three scales": Row(REST, 3, 0.4),
    "bent": Row(REST, exposed=bending()),
    "three bent": Row(REST, 3, 0.4, bending()),
}


@pytest.mark.parametrize("size", [SMALL, MIDDLE, LARGE])
@pytest.mark.parametrize("row", ROWS.values(), ids=ROWS)
def test_derivatives_of_the_corners_by_motions_and_twist(rng, size, row):
    # motions of other bodies may follow those of the scales
    own = (6 + row.exposed.amplitudes) * row.moving
    q = np.append(rng.normal(size=own + (0 if row.endless else 6)) * size, 0.2)
    nodes = np.arange(0, len(row.exposed.points) * row.k.size, 3)
    placed = Placed(row, q[:-1], q[-1])
    forces = rng.normal(size=placed.corners.shape)
    by_q = differences(lambda q: Placed(row, q[:-1], q[-1]).corners, q)
    np.testing.assert_allclose(placed.rates(nodes), by_q[nodes].reshape(-1, q.size), atol=1e-7)
    second = differences(lambda q: forces[nodes].ravel() @ Placed(row, q[:-1], q[-1]).rates(nodes), q)
    np.testing.assert_allclose(placed.curvature(nodes, forces[nodes]), second, atol=1e-6)


@pytest.fixture
def rng():
    return np.random.default_rng(4)

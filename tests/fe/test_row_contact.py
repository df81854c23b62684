"""Contact of N scales: forces and tangent, action and reaction, objectivity, the same as along a helix."""

import numpy as np
import pytest

pytest.importorskip("ipctk", reason="needs the extra fe")

from scipy.spatial.transform import Rotation
from solids import barrier_energy

from squama.fe.contact import RowContact, ranges, stiffness, where
from squama.fe.plate import Rest
from squama.fe.rows import Row

DHAT, SLIP, MU, N = 1e-3, 1e-5, 0.4, 3
KAPPA = stiffness(1e-2, DHAT)
REST = Rest.at(3.0, 0.6, 0.32, np.radians(45), np.radians(10))
PHI = 0.0589
"""Just before the scales at rest would touch: within dhat of each other."""


@pytest.fixture(scope="module")
def row():
    return RowContact(Row(REST, N), MU, dhat=DHAT, slip=SLIP)


def motions(size=1e-5):
    """Six motions for each scale and six more that nothing touches."""
    return np.random.default_rng(5).normal(size=6 * N + 6) * size


def slid_from(contact, size):
    """Corners a little back, so that the contacts have slid by about ``size``."""
    return contact.corners(np.random.default_rng(3).normal(size=6 * N + 6) * size, PHI - size)


@pytest.mark.parametrize("size", [1e-6, 1e-3], ids=["sticking", "sliding"])
def test_the_tangent_is_the_derivative_of_the_forces(row, size):
    before, q, h = slid_from(row, size), np.append(motions(), PHI), 1e-8

    def total(q):
        return row.load(q[:-1], q[-1], before, KAPPA).total

    tangent = row.load(q[:-1], q[-1], before, KAPPA).tangent
    found = np.stack([(total(q + h * e) - total(q - h * e)) / (2 * h) for e in np.eye(q.size)], -1)
    np.testing.assert_allclose(tangent, found, atol=1e-4 * np.abs(found).max())
    assert np.abs(tangent - tangent.T).max() > 1e-3 * np.abs(tangent).max()
    assert not tangent[6 * N : -1].any()


def test_without_friction_forces_are_the_derivative_of_the_energy(row):
    q, h = np.append(motions(), PHI), 1e-8

    def energy(q):
        return barrier_energy(row, row.corners(q[:-1], q[-1]), KAPPA)

    load = row.load(q[:-1], q[-1], None, KAPPA)
    found = [(energy(q + h * e) - energy(q - h * e)) / (2 * h) for e in np.eye(q.size)]
    np.testing.assert_allclose(load.total, found, atol=1e-6 * np.abs(load.total).max())
    np.testing.assert_allclose(load.tangent, load.tangent.T, atol=1e-9 * np.abs(load.tangent).max())
    assert load.slid == 0


def moved(row, v, R, shift):
    """Motions after all scales have been turned and moved together in space."""
    out = np.zeros_like(v)
    A, base = REST.axes, REST.base
    for k in range(N):
        c, s = np.cos(k * PHI), np.sin(k * PHI)
        Q = np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])
        u, w = v[6 * k : 6 * k + 3], v[6 * k + 3 : 6 * k + 6]
        place = R @ (Q @ (base + u @ A) + [0, 0, k]) + shift
        u = A @ (Q.T @ (place - [0, 0, k]) - base)
        turn = A @ Q.T @ R @ Q @ A.T @ Rotation.from_rotvec(w).as_matrix()
        out[6 * k : 6 * k + 6] = np.append(u, Rotation.from_matrix(turn).as_rotvec())
    return out


def test_moved_together_the_scales_feel_the_same(row):
    v, before = motions(), slid_from(row, 1e-3)
    R, shift = Rotation.from_rotvec([0.3, -1.1, 0.7]).as_matrix(), np.array([2.0, -1.0, 0.5])
    there = moved(row, v, R, shift)
    np.testing.assert_allclose(row.corners(there, PHI), row.corners(v, PHI) @ R.T + shift, atol=1e-12)
    push = row.load(v, PHI, before, KAPPA).push
    other = row.load(there, PHI, before @ R.T + shift, KAPPA).push
    assert np.abs(push.friction).max() > 1e-4
    for a, b in ((push.gradient, other.gradient), (push.friction, other.friction)):
        np.testing.assert_allclose(b, a @ R.T, atol=1e-7 * np.abs(a).max())
    energy, turned = (barrier_energy(row, row.corners(motion, PHI), KAPPA) for motion in (v, there))
    assert turned == pytest.approx(energy, rel=1e-7)


def test_action_is_reaction_pair_by_pair(row):
    load = row.load(motions(), PHI, slid_from(row, 1e-3), KAPPA)
    assert [(p.first, p.second) for p in load.pairs] == [(0, 1), (1, 2)]
    on_scale = np.zeros((N, 3))
    for pair in load.pairs:
        assert pair.f == pytest.approx(MU * pair.N, rel=1e-6)
        on_scale[pair.first] += pair.normal + pair.friction
        on_scale[pair.second] -= pair.normal + pair.friction
    total = -(load.push.gradient + load.push.friction).reshape(N, 4, 3).sum(1)
    np.testing.assert_allclose(on_scale, total, atol=1e-10)


def test_equal_scales_touch_as_along_a_helix(row):
    """Two neighbours of the row against a scale and its first image."""
    v = np.zeros(6 * N)
    helix = RowContact(Row(REST), MU, dhat=DHAT, slip=SLIP)
    one = helix.load(v[:6], PHI, helix.corners(v[:6], PHI - 1e-3), KAPPA)
    load = row.load(v, PHI, row.corners(v, PHI - 1e-3), KAPPA)
    for pair in load.pairs:
        assert (pair.N, pair.f) == pytest.approx((one.strongest.N, one.strongest.f), rel=1e-6)
    # two contacts in the row, one a pitch along the helix; a shift of all motions moves both
    # slips are counted in space, so the second pair's is turned by the increment
    for part, ours, slack in ((one.normal, load.normal, 1e-6), (one.friction, load.friction, 2e-3)):
        # tolerance: that turn, 1.4e-3 of the friction, on every processor
        np.testing.assert_allclose(ours[:-1].reshape(N, 6).sum(0), 2 * part[:6], atol=slack * np.abs(part).max())
        assert ours[-1] == pytest.approx(2 * part[6], rel=slack)
    both, single = (barrier_energy(c, c.corners(motion, PHI), KAPPA) for c, motion in ((row, v), (helix, v[:6])))
    assert both == pytest.approx(2 * single, rel=1e-6)


def test_contacts_are_named(row):
    p, s, words = where(row.touches(row.corners(np.zeros(6 * N), PHI), KAPPA), N)
    assert words == "tip edge on the next scale's side edge DC: 1 to 2"
    assert np.isfinite(p[:2]).all()
    assert s[0] == pytest.approx(s[1], rel=1e-6)
    assert np.isnan(p[2])
    assert where(row.touches(row.corners(np.zeros(6 * N), 0.0), KAPPA), N)[2] == ""
    assert ranges([3, 1, 2, 7, 5]) == "1 to 3, 5, 7"


def test_without_contact_nothing_acts(row):
    load = row.load(np.zeros(6 * N), 0.01, None, KAPPA)
    assert not load.total.any()
    assert load.pairs == []
    assert (load.strongest.N, load.strongest.f) == (0, 0)

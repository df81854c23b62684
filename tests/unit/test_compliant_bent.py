"""Compliant joints in a beam that is bent and twisted: against general contact, virtual work, the twisted beam."""

import numpy as np
import pytest

from legs import follow_legs
from squama import combined
from squama.contacts import path
from squama.joints import law
from squama.joints.factor import MIRROR

SHAPE = law.Shape(1.28, 0.32, 0.18, 0.6, 0.02, np.pi / 4, np.radians(10), 0.25)
ETA = 3.0
K = law.stiffness(SHAPE)
TWIST_FIRST = np.array([(0.0, 0.09), (0.02, 0.12), (0.05, 0.12), (0.03, 0.12), (0.03, 0.1)])


def scale(h=SHAPE.thickness, D=np.inf, **changed):
    given = {"eta": ETA, "beta": SHAPE.beta, "lam": SHAPE.lam, "alpha": SHAPE.alpha, "theta0": SHAPE.theta0, **changed}
    return path.Scale(**given, h=h, D=D)


@pytest.mark.parametrize("D", [np.inf, 0.1])
def test_without_bend_it_is_the_twisted_beam(D):
    phi = np.array([0.03, 0.08, 0.12, 0.16])
    one = path.Path.of(scale(D=D), K, 0.3, free=path.HELD)
    rows, _ = one.states(phi)
    found = follow_legs(scale(D=D), K, 0.3, np.column_stack([0 * phi, phi]), free=path.HELD)
    np.testing.assert_allclose(found.rows, rows, rtol=0, atol=1e-10)


@pytest.mark.parametrize("D", [np.inf, 0.1])
def test_moment_and_torque_are_the_slopes_of_the_energy(D):
    """Work of M and T around a square of strains, and along the path by the compiled model's own sum."""
    corners = np.array([(0.02, 0.1), (0.04, 0.1), (0.04, 0.12), (0.02, 0.12), (0.02, 0.1)])
    found = follow_legs(scale(D=D), K, 0.0, corners, step=1e-3)
    work = found.column("W")
    assert work[-1] - work[0] == pytest.approx(0.0, abs=1e-5 * work[0])
    np.testing.assert_allclose([found.M[-1], found.T[-1]], [found.M[0], found.T[0]], rtol=3e-6)
    # the rate of work with the way is along the leg that ends there
    rates = np.diff(corners, axis=0, prepend=np.zeros((1, 2)))
    rates /= np.hypot(*rates.T)[:, None]
    np.testing.assert_allclose(found.column("T"), found.M * rates[:, 0] + found.T * rates[:, 1], rtol=1e-6)
    h = 1e-4
    for axis, value in ((0, found.M[0]), (1, found.T[0])):
        ends = []
        for sign in (1, -1):
            there = corners[:1] + sign * h * np.eye(2)[axis]
            ends.append(follow_legs(scale(D=D), K, 0.0, np.concatenate([corners[:1], there]), step=2e-3))
        works = [end.column("W")[1] for end in ends]
        assert (works[0] - works[1]) / (2 * h) == pytest.approx(value, rel=1e-4)


@pytest.mark.slow
@pytest.mark.parametrize("mu", [0.0, 0.3])
@pytest.mark.parametrize("free", [path.STRETCHING, path.HELD])
def test_general_contact_finds_the_same(mu, free):
    pytest.importorskip("ipctk", reason="general contact needs ipctk (the extra fe)")
    from squama.fe.assembly import make_bent
    from squama.fe.exposed import box
    from squama.fe.geometry import Geometry

    shape = Geometry(*SHAPE[:3], ETA, *SHAPE[3:])
    walk = make_bent(K, shape, mu, free=("stretch",) * free[-1], exposed=box(ETA, shape.beta, shape.thickness))
    found, other = follow_legs(scale(), K, mu, TWIST_FIRST, free=free, step=1e-3), []
    for corner in TWIST_FIRST:
        assert walk.run(walk.aim(*corner), 2e-3).reached
        other.append([walk.columns[name][-1] for name in ("M", "T", "N", "stretch")])
    M, T, N, stretched = np.array(other).T
    # tolerance: the barrier's gap of 1e-4 pitches, and friction's first increment at a corner
    np.testing.assert_allclose(found.M, M, rtol=3e-3)
    np.testing.assert_allclose(found.T, T, rtol=3e-3)
    np.testing.assert_allclose(found.column("N"), N, rtol=5e-3)
    np.testing.assert_allclose(found.stretch, stretched, atol=5e-5)
    assert (found.stretch == 0).all() == (free == path.HELD)


def test_a_joint_that_only_lifts_is_the_hinge():
    """Thin plates on a joint stiff in all else, the axis held: the closed form with the middle's length kept."""
    stiff = np.diag([1e3, 1e3, 1e3, 1e3, 0.013, 1e3, 0.0, 0.0, 1e3])
    stiff[6, 6] = stiff[7, 7] = 0.05
    corners = np.array([(0.0, 0.08), (0.03, 0.12), (0.05, 0.12)])
    found = follow_legs(scale(h=0.0), stiff, 0.2, corners, free=path.HELD)
    ratios = {"eta": ETA, **{k: getattr(SHAPE, k) for k in ("beta", "lam", "alpha", "theta0")}}
    for i, toward in enumerate(((0.0, 1.0), (0.03, 0.04), (1.0, 0.0))):
        one = combined(*corners[i], mu=0.2, toward=toward, **ratios)
        assert one.contact == "TS"
        own = found.M[i] - 0.05 * corners[i, 0], found.T[i] - 0.05 * corners[i, 1]
        np.testing.assert_allclose(np.array(own) / 0.013, [one.bending_moment, one.torque], rtol=3e-3)


def test_mirrored_it_is_the_same():
    # at the usual step the images differ by 1e-4, and rounding says by how much
    fine = {"step": 2.5e-4}
    one = follow_legs(scale(), K, 0.3, TWIST_FIRST, **fine)
    image = follow_legs(scale(alpha=-SHAPE.alpha), K * np.outer(MIRROR, MIRROR), 0.3, TWIST_FIRST * [1, -1], **fine)
    known = np.isfinite(image.M)
    assert known.all()
    np.testing.assert_allclose(image.M[known], one.M[known], rtol=2e-5)
    np.testing.assert_allclose(image.T[known], -one.T[known], rtol=2e-5)


def test_bent_first_a_corner_touches_a_face():
    found = follow_legs(scale(), K, 0.3, np.array([(0.03, 0.0), (0.09, 0.0)]))
    met = found.answers.contact()
    assert met.words == "corner B on face (k = 1)"
    assert 0.045 < met.phi < 0.055
    assert path.endings(found.answers.contacts, found.answers.ends) == "range end"
    # before, it is the bar with its scales, stretched to have no axial force
    loose = [0, 1, 2, 3, 4, 5, 8]
    A = np.linalg.solve(K[np.ix_(loose, loose)], K[loose, 7])
    assert found.stretch[0] == pytest.approx(-0.03 * A[-1], rel=1e-12)
    bare = K[7, 7] - K[7, loose] @ A
    assert found.M[0] == pytest.approx(0.03 * bare, rel=1e-12)
    assert found.M[1] > 1.5 * 0.09 * bare

"""Embedded parts longer than a pitch: cuts that lean as they do, the same joint as between straight cuts."""

import numpy as np
import pytest

pytest.importorskip("netgen", reason="meshes need netgen-mesher (the extra fe)")
pytest.importorskip("numba", reason="elements need numba (the extra fe)")

from squama.fe import geometry as shapes
from squama.fe import pitch_stiffness, stiffness
from squama.fe.elements import Material
from squama.fe.geometry import Geometry
from squama.fe.mesh import bar_mesh, pitch_mesh
from squama.fe.pitch_stiffness import response
from squama.joints import factor, law

LONG = Geometry(2.5, 0.625, 1.28, 2.32, 0.5, 0.1, np.radians(40), np.radians(10), 0.42)
"""Sheets 1.28 pitches deep that leave a third of their thickness between them, inside the sides of the bar."""
SHORT = Geometry(1.6, 0.5, 0.5, 3.0, 0.5, 0.06, np.radians(30), np.radians(20), 0.45)
"""Short enough for cuts of both kinds."""


@pytest.fixture(scope="module")
def long():
    return pitch_mesh(LONG, 0.3, 0.15)


def volume(pitch):
    corners = pitch.nodes[pitch.tets[:, :4]]
    parts = np.linalg.det(corners[:, 1:] - corners[:, :1]) / 6
    assert parts.min() > 0
    return parts.sum()


@pytest.mark.slow
def test_the_pitch_is_filled_and_follows_itself(long):
    slot = 2 * LONG.beta * LONG.thickness * LONG.zeta
    assert volume(long) == pytest.approx(2 * LONG.width * LONG.lam - slot, rel=1e-6)
    assert not set(long.tied) & {*long.front, *long.back}
    X = long.nodes[long.front]
    np.testing.assert_allclose(long.nodes[long.back] - X, np.tile([0.0, 0.0, 1.0], (len(X), 1)), atol=1e-12)
    # parallel to the scale, and plane below it
    away = LONG.local(X)[X[:, 1] > LONG.lam - LONG.depth]
    np.testing.assert_allclose(np.abs(away[:, 2]), LONG.gap / 2, atol=1e-9)
    below = X[X[:, 1] < LONG.lam - LONG.knee - 1e-9]
    assert len(below) > 20
    assert np.ptp(below[:, 2] - below[:, 0] * np.tan(LONG.alpha)) < 1e-9


@pytest.mark.slow(but=1)
@pytest.mark.parametrize(
    "change",
    [
        {"thickness": 0.83 * LONG.gap},  # a fifth of the thickness between neighbours
        {"thickness": 0.95 * LONG.gap},
        {"zeta": 6.0, "thickness": 0.02},  # to the other face
        {"theta0": np.radians(35), "zeta": 1.8, "thickness": 0.3},
        {"theta0": np.radians(3), "thickness": 0.03},
        {"alpha": np.radians(78), "thickness": 0.02, "width": 3.0},
        {"alpha": 0.0},
        {"beta": 1.25},  # out of the side
    ],
)
def test_long_tabs_are_meshed(change):
    g = LONG._replace(**change)
    assert g.lean
    pitch = pitch_mesh(g, 0.3, 0.2)
    clipped = 2 * g.width * g.lam - volume(pitch)
    assert 0 < clipped < 2 * g.beta * g.thickness * g.zeta * (1 + 1e-6)


@pytest.mark.slow
def test_a_bare_bar_between_cuts_that_lean():
    """EI, EA and GJ do not depend on where a bar is cut, and a linear field has no other strains."""
    K = response(bar_mesh(LONG, 0.25), LONG).K
    exact = np.append(np.zeros(6), law.bare(law.Shape(*LONG[:3], *LONG[4:])))
    # tolerance: bend and stretch are exact, the twist's warping is the mesh's, 0.3 % measured
    np.testing.assert_allclose(np.diag(K)[7:], exact[7:], rtol=1e-6)
    np.testing.assert_allclose(K[6, 6], exact[6], rtol=0.02)
    np.testing.assert_allclose(K, np.diag(np.diag(K)), atol=1e-6)


def test_the_energy_of_all_points_is_that_of_the_matrix(long, monkeypatch):
    monkeypatch.setattr(pitch_stiffness, "near_edges", lambda _, points: [np.ones(points.shape[:2], bool)])
    whole = response(long, LONG)
    inside = 2 * LONG.width * LONG.lam - 2 * LONG.beta * LONG.zeta * LONG.thickness
    np.testing.assert_allclose(whole.strain[0] * inside, whole.K, rtol=0, atol=2e-4 * np.abs(whole.K).max())


@pytest.mark.slow
def test_both_cuts_make_the_same_joint(monkeypatch):
    """Also what depends on the section that is held: with leaning cuts it is no face of the mesh."""
    K = []
    for crowded in (shapes.CROWDED, 0.0):
        monkeypatch.setattr(shapes, "CROWDED", crowded)
        assert bool(SHORT.lean) == (not crowded)
        coarse, fine = (response(pitch_mesh(SHORT, 0.15, edge), SHORT).K for edge in (0.08, 0.04))
        K.append(2 * fine - coarse)
    straight, leaning = map(factor.pivots, K)
    # tolerance: meshes; with elements half as large 2 % of the shifts, 0.3 % of K_theta and 0.2 % of the loads measured
    np.testing.assert_allclose(leaning / straight, 1, atol=0.12)
    np.testing.assert_allclose((leaning / straight)[factor.TWIST :], 1, atol=0.04)
    unit = np.sqrt(np.diag(K[0]))
    np.testing.assert_allclose(K[1] / np.outer(unit, unit), K[0] / np.outer(unit, unit), atol=0.12)


@pytest.mark.slow
def test_a_tab_that_bends(long):
    pitch = pitch_mesh(LONG, 0.3, 0.15, tab=True)
    rigid, soft = (factor.pivots(response(pitch, LONG, Material(E, 0.3)).K) for E in (1e7, 2e3))
    # tolerance: coarse meshes that differ
    np.testing.assert_allclose(rigid / factor.pivots(response(long, LONG).K), 1, atol=0.15)
    assert (soft < rigid).all()
    assert (soft / rigid)[factor.TWIST] < 0.7


def test_edges_are_as_fine_as_what_is_left_between_neighbours():
    assert stiffness.sizes(LONG, 2)[1] == pytest.approx([2 * (LONG.gap - LONG.thickness), LONG.gap - LONG.thickness])

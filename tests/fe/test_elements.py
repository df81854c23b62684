"""The quadratic tetrahedra: exact for linear fields, objective, and consistent in their derivatives."""

import itertools

import numpy as np
import pytest

pytest.importorskip("numba", reason="needs the extra fe")

from scipy.spatial.transform import Rotation
from solids import cube, images, stiffness

from squama.fe.elements import Elements, Helical, Material
from squama.fe.periodic import Leg, Twist
from squama.fe.plate import Turn

MATERIAL = Material(2.0, 0.3)


@pytest.fixture(scope="module")
def solid():
    nodes, tets = cube(2)
    # no two elements alike
    inner = (np.abs(nodes) < 0.49).all(1)
    moved = nodes + 0.02 * np.sin(7 * nodes[:, [1, 2, 0]]) * inner[:, None]
    pairs = [(0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3)]
    for e, (i, j) in enumerate(pairs):
        moved[tets[:, 4 + e]] = (moved[tets[:, i]] + moved[tets[:, j]]) / 2
    return moved, tets


def test_lame_constants_are_those_of_the_material():
    L, G = MATERIAL.lame
    assert pytest.approx(MATERIAL.E) == G * (3 * L + 2 * G) / (L + G)
    assert pytest.approx(MATERIAL.nu) == L / (2 * (L + G))


def test_a_homogeneous_deformation_is_exact(solid):
    nodes, tets = solid
    F = np.array([[1.1, 0.2, 0.0], [-0.1, 0.95, 0.1], [0.05, 0.0, 1.2]])
    J = np.linalg.det(F)
    r = Elements(nodes, tets, MATERIAL)(nodes @ F.T)
    L, G = MATERIAL.lame
    density = G / 2 * (np.trace(F.T @ F) - 3 - 2 * np.log(J)) + L / 2 * np.log(J) ** 2
    assert r.energy == pytest.approx(density, rel=1e-12)
    assert r.least == pytest.approx(J, rel=1e-12)
    inner = (np.abs(nodes) < 0.49).all(1)
    assert inner.sum() > 5
    assert np.abs(r.forces[inner]).max() < 1e-13
    # forces on the face x = 1/2 add up to the first Piola-Kirchhoff stress
    P = G * (F - np.linalg.inv(F).T) + L * np.log(J) * np.linalg.inv(F).T
    face = np.abs(nodes[:, 0] - 0.5) < 1e-9
    forces = np.linalg.norm(r.forces[face].sum(0))
    assert forces > 0
    total = np.einsum("ni,nj->ij", r.forces, nodes)
    np.testing.assert_allclose(total, P, atol=1e-13)


def test_small_strain_stiffness_is_that_of_hooke(solid):
    nodes, tets = solid
    K = stiffness(nodes, tets, MATERIAL)
    strain = np.array([[1e-3, 2e-4, 0], [2e-4, -3e-4, 1e-4], [0, 1e-4, 5e-4]])
    u = (nodes @ strain).ravel()
    L, G = MATERIAL.lame
    density = G * (strain**2).sum() + L / 2 * np.trace(strain) ** 2
    assert u @ (K @ u) / 2 == pytest.approx(density, rel=1e-12)
    assert abs(K - K.T).max() < 1e-13
    spin = nodes @ np.array([[0, 1, -2], [-1, 0, 3], [2, -3, 0]]) + [1, 2, 3]
    assert np.abs(K @ spin.ravel()).max() < 1e-12


def test_forces_turn_with_the_body(solid):
    nodes, tets = solid
    elements = Elements(nodes, tets, MATERIAL)
    x = nodes + 0.05 * np.cos(5 * nodes[:, [2, 0, 1]])
    R = Rotation.from_rotvec([0.4, -1.1, 0.7]).as_matrix()
    a, b = elements(x), elements(x @ R.T + [3, -1, 2])
    assert b.energy == pytest.approx(a.energy, rel=1e-12)
    np.testing.assert_allclose(b.forces, a.forces @ R.T, atol=1e-13)


@pytest.fixture(scope="module")
def periodic(solid):
    nodes, tets = cube(2)
    master, turned, places = images(nodes)
    elements = Helical(Elements(nodes, tets, MATERIAL), master, turned)
    dice = np.random.default_rng(3)
    return elements, places + dice.normal(0, 0.02, places.shape), dice


@pytest.mark.parametrize(("course", "loads"), [(Twist(), [0.3]), (Leg(), [0.1, 0.15, 0.05])])
def test_derivatives_under_a_helical_map(periodic, course, loads):
    twisted, y, dice = periodic
    elements = Helical(twisted.elements, twisted.master, twisted.turned, course)
    loads, h = np.array(loads), 1e-5
    dy, dl = dice.normal(size=y.shape), dice.normal(size=loads.size)
    r, up, down = (elements(y + t * h * dy, loads + t * h * dl) for t in (0, 1, -1))

    def rate(name):
        return (getattr(up, name) - getattr(down, name)) / (2 * h)

    assert rate("energy") == pytest.approx((r.forces * dy).sum() + r.loads @ dl, rel=1e-6)
    K = elements.matrix(r.values)
    assert abs(K - K.T).max() < 1e-12
    push = (K @ dy.ravel()).reshape(-1, 3) + r.forces_by @ dl
    np.testing.assert_allclose(rate("forces"), push, atol=5e-6 * np.abs(push).max())
    np.testing.assert_allclose(rate("loads"), np.tensordot(dy, r.forces_by, 2) + r.loads_by @ dl, rtol=1e-5)


def test_a_twisted_frame_costs_no_energy_with_the_images(periodic):
    elements, y, _ = periodic
    # turning the whole cell about z, or moving it along z, is no deformation of a helical cell
    R = Turn.at(0.9).Q
    a, b = (elements(x, np.array([0.3])) for x in (y, y @ R.T + [0, 0, 0.4]))
    assert b.energy == pytest.approx(a.energy, rel=1e-12)
    assert b.loads == pytest.approx(a.loads, rel=1e-10)


def test_gauss_points_integrate_polynomials_of_degree_five():
    from math import factorial

    from squama.fe.elements import _POINTS, _WEIGHTS

    assert (_POINTS > 0).all()
    assert (_WEIGHTS > 0).all()
    for powers in itertools.product(range(6), repeat=4):
        if sum(powers) <= 5:
            # over the volume of a tetrahedron
            exact = 6 * np.prod([float(factorial(n)) for n in powers]) / factorial(3 + sum(powers))
            assert _WEIGHTS @ np.prod(_POINTS ** np.array(powers), axis=1) == pytest.approx(exact, rel=1e-13)


def test_a_tetrahedron_that_is_crushed_at_one_corner_resists(solid):
    """Middle nodes that move towards a corner crush the element there, to .03 of its volume (.13 at four points)."""
    nodes = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    pairs = np.array([(0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3)])
    nodes = np.concatenate([nodes, nodes[pairs].mean(axis=1)])
    element = Elements(nodes, np.arange(10)[None], MATERIAL)
    # at the first corner the derivative along an edge is 4 times its middle less 1: it vanishes at a quarter
    least, energy = [], []
    for s in np.linspace(0.5, 0.24, 27):
        moved = nodes.copy()
        moved[[4, 6, 7]] *= s / 0.5
        r = element(moved, tangent=False)
        least.append(r.least)
        energy.append(r.energy)
    assert np.all(np.diff(least) < 0)
    assert np.all(np.diff(energy) > 0)
    assert least[-1] < 0.05


def test_an_inverted_element_is_told(solid):
    nodes, tets = solid
    r = Elements(nodes, tets, MATERIAL)(nodes * [1, 1, -1])
    assert r.least < 0
    assert r.energy == np.inf


def test_a_mesh_with_an_empty_element_is_refused(solid):
    nodes, tets = solid
    with pytest.raises(ValueError, match="have no volume"):
        Elements(nodes * [1, 1, 0], tets, MATERIAL)

"""Thick and elastic scales: their surfaces, how plates bend, what the contact search finds, limits."""

import json
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

pytest.importorskip("ipctk", reason="needs the extra fe")
pytest.importorskip("netgen", reason="meshes need netgen-mesher (the extra fe)")

from matrices import contacts, curve, shape, unbalanced
from solids import barrier_energy

from oracle.barrier import plate
from squama.beam.matrixfile import MOTIONS
from squama.fe.bending import BRICKS, Bricks, _answers, lines, mesh_error, shapes, solid
from squama.fe.contact import RowContact, stiffness
from squama.fe.elements import Material
from squama.fe.exposed import FACE, box, sheet, thin
from squama.fe.plate import Rest
from squama.fe.rows import Row

ETA, BETA, NU = 3.0, 0.6, 0.35
PLACES = np.array([[ETA, -0.15, 0.0], [2.2, -BETA, 0.0]])
"""On the tip edge and on the side edge."""
COMPLIANCE = np.array([[8.2090, 4.9987], [4.9987, 3.5724]])
"""There, for D = 1, by Argyris plate elements of another library."""
GRID = np.linspace(0, ETA, 7), np.linspace(-BETA, BETA, 5)


@pytest.fixture
def rng():
    return np.random.default_rng(4)


def compliance(exposed, places):
    """Moves of points of the surface along n_Z under unit forces there."""
    nearest = [int(np.argmin(np.linalg.norm(exposed.points - at, axis=1))) for at in places]
    modes = exposed.modes[nearest, 2]
    return modes @ np.linalg.solve(exposed.stiffness, modes.T)


@pytest.mark.parametrize("surface", [box(ETA, BETA, 0.1), sheet(*GRID, 0.1)], ids=["box", "grid"])
def test_the_surface_of_a_thick_plate_is_closed(surface):
    n, e, f = (len(x) for x in (surface.points, surface.edges, surface.faces))
    assert n - e + f == 2
    sides = np.sort(surface.faces[:, [(0, 1), (1, 2), (2, 0)]].reshape(-1, 2), axis=1)
    assert (np.unique(sides, axis=0, return_counts=True)[1] == 2).all()
    assert np.ptp(surface.points, axis=0) == pytest.approx([ETA, 2 * BETA, 0.1])
    assert np.ptp(surface.points[:, 2]) == pytest.approx(0.1)


@pytest.mark.parametrize("h", [0.0, 0.1])
def test_corners_and_edges_have_names(h):
    corners = {"corner D": (0, -BETA), "corner A": (0, BETA), "corner B": (ETA, BETA), "corner C": (ETA, -BETA)}
    lines = {
        "base edge DA": lambda x: x[:, 0] == 0,
        "side edge AB": lambda x: x[:, 1] == BETA,
        "tip edge CB": lambda x: x[:, 0] == ETA,
        "side edge DC": lambda x: x[:, 1] == -BETA,
    }
    for surface in (sheet(*GRID, h), box(ETA, BETA, h)):
        for name, point in zip(surface.names, surface.points, strict=True):
            assert name not in corners or tuple(point[:2]) == corners[name]
        assert {name for name in surface.names if name.startswith("corner")} == set(corners)
        for side, edge in zip(surface.sides, surface.edges, strict=True):
            assert side not in lines or lines[side](surface.points[edge]).all()
            assert side in lines or side in corners or side == FACE
        # twelve edges of a box, four of a rectangle
        if len(surface.points) in (4, 8):
            assert surface.outer.size == (12 if h else 4)


def test_polynomials_are_as_stiff_as_they_should_be():
    """Values of an independent Ritz solution with X^i Y^j, i = 2..7, j = 0..3."""
    surface = sheet(np.array([0.0, 2.2, ETA]), np.array([-BETA, -0.15, BETA]), 0.0)
    found = compliance(plate(surface, ETA, BETA, 1.0, NU), PLACES)
    # tolerance: the values have four decimals
    np.testing.assert_allclose(found, [[8.1407, 4.9569], [4.9569, 3.5321]], atol=6e-5)
    few = compliance(plate(surface, ETA, BETA, 1.0, NU, along=3, across=2), PLACES)
    np.testing.assert_allclose(few, [[7.8229, 4.7476], [4.7476, 3.3018]], atol=6e-5)


@pytest.mark.slow
@pytest.mark.parametrize("h", [0.01, 0.04])
def test_a_thin_solid_is_as_soft_as_a_plate(h):
    material = Material(12 * (1 - NU**2) / h**3, NU)
    # a grid with both places among its points
    bricks = Bricks(ETA, BETA, h, 15, 8)
    exact = bricks.at(PLACES) @ _answers(bricks, material, PLACES)[2::3]
    # tolerance: bricks beside a thin plate, 0.1 to 0.8 % on every processor
    np.testing.assert_allclose(exact, COMPLIANCE, rtol=0.015)
    kept = solid(ETA, BETA, h, material, bricks=(15, 8), contact_h=0.0)
    np.testing.assert_allclose(compliance(kept, PLACES), exact, rtol=2e-3)
    assert 0 < mesh_error(ETA, BETA, h, material) < 0.015


def test_bricks_pass_the_patch_test(rng):
    bricks = Bricks(2.0, 0.5, 0.3, 3, 2)
    K, x = bricks.stiffness(Material(2.0, 0.3)), bricks.nodes
    strain = rng.normal(size=(3, 3))
    moved = x @ strain.T
    e = (strain + strain.T) / 2
    lame, shear = Material(2.0, 0.3).lame
    energy = (lame / 2 * np.trace(e) ** 2 + shear * (e**2).sum()) * 2.0 * 1.0 * 0.3
    assert moved.ravel() @ K @ moved.ravel() / 2 == pytest.approx(energy, rel=1e-12)
    turn = np.cross([0.2, -0.4, 0.7], x)
    assert np.abs(K @ turn.ravel()).max() < 1e-12
    np.testing.assert_allclose(bricks.at(x) @ x, x, atol=1e-13)


def test_shape_functions_of_the_brick_have_right_rates(rng):
    at, h = rng.uniform(-1, 1, size=(4, 3)), 1e-6
    values, rates = shapes(at)
    np.testing.assert_allclose(values.sum(1), 1)
    found = np.stack([(shapes(at + h * e)[0] - shapes(at - h * e)[0]) / (2 * h) for e in np.eye(3)], -1)
    np.testing.assert_allclose(rates, found, atol=1e-9)


def test_a_cantilever_of_bricks_bends_as_a_beam():
    length, h, E = 5.0, 0.25, 3.0
    found = compliance(solid(length, 0.1, h, Material(E, 0.0), bricks=(20, 2), modes=12), [[length, 0.0, h / 2]])
    inertia = 0.2 * h**3 / 12
    shear = length / (5 / 6 * E / 2 * 0.2 * h)
    assert found[0, 0] == pytest.approx(length**3 / (3 * E * inertia) + shear, rel=5e-3)


def test_modes_are_of_a_size_that_suits_the_solver():
    exposed = solid(ETA, BETA, 0.04, Material(1e5, NU), bricks=(6, 4))
    K = exposed.stiffness
    np.testing.assert_allclose(K, np.diag(np.diag(K)))
    assert np.diag(K).max() <= 1 + 1e-12
    assert np.diag(K).min() > 0
    assert np.abs(exposed.modes).max() <= 1 + 1e-12


def test_what_comes_near_is_found(rng):
    """Against all distances of segments' and triangles' sampled points."""
    exposed = plate(sheet(*GRID, 0.04), ETA, BETA, 0.3, NU, along=4, across=1)
    bend = rng.normal(size=3) * 0.03
    row = Row(Rest.at(ETA, BETA, 0.32, 0.8, 0.17), exposed=exposed)
    contact = RowContact(row, 0.0)
    V = contact.corners(np.append(rng.normal(size=6) * 0.02, np.zeros(exposed.amplitudes)), 0.05)
    n = len(exposed.points)
    V[:n] += np.outer(exposed.points[:, 0] ** 2, bend)
    near = contact._near(V, V, 0.1)
    shares = np.linspace(0, 1, 9)[:, None, None]
    one, two = ((1 - shares) * V[k * n + exposed.edges[:, 0]] + shares * V[k * n + exposed.edges[:, 1]] for k in (0, 1))
    far = np.linalg.norm(one[:, None, :, None] - two[None, :, None], axis=-1).min(axis=(0, 1))
    m = len(exposed.edges)
    expected = {(int(a), int(b) + m) for a, b in np.argwhere(far < 0.1)}
    assert len(expected) > 20
    found = [sorted((pair.edge0_id, pair.edge1_id)) for pair in near.ee_candidates]
    assert expected <= {tuple(pair) for pair in found}
    assert len(found) < m * m / 4
    # pairs of two other scales of an endless row are those of scale 0 once more
    assert all(a < m <= b for a, b in found)
    corners = V[exposed.faces].mean(axis=1)
    faces = {(pair.face_id, pair.vertex_id) for pair in near.fv_candidates}
    for face, point in np.argwhere(np.linalg.norm(corners[:, None] - V[None, n : 2 * n], axis=-1) < 0.1).tolist():
        assert (face, n + point) in faces


@pytest.fixture(scope="module")
def joint():
    """A stiffness of about the right size."""
    size = np.sqrt([0.4, 0.5, 0.4, 0.05, 0.0119, 0.06, 0.02])
    mixed = np.random.default_rng(0).normal(size=(7, 7)) * 0.1
    shape = np.eye(7) + (mixed + mixed.T) / 2
    shape[4, 4] = shape[6, 6] = 1.0
    return SimpleNamespace(K=size[:, None] * shape * size, rest=Rest.at(ETA, BETA, 0.32, np.pi / 4, np.radians(10)))


def test_forces_on_a_bent_row_are_the_derivative_of_the_energy(joint):
    exposed = plate(sheet(*GRID, 0.04), ETA, BETA, 0.3, NU, along=4, across=1)
    contact = RowContact(Row(joint.rest, exposed=exposed), 0.4, dhat=1e-3)
    h, phi, r = 1e-8, 0.0589 - 0.04 / (1.8 * np.pi / 4), exposed.amplitudes
    kappa = stiffness(1e-2, 1e-3)
    # down to the neighbour, a little bent
    rng = np.random.default_rng(1)
    q = np.append(rng.normal(size=6 + r) * 1e-4, phi)
    share = contact.free(contact.corners(q[:-1], phi), contact.corners(q[:-1], 0.08))
    q[-1] = phi + share / 0.9 * (0.08 - phi) * 0.999
    # tolerance: the distance of the barrier
    assert contact.gap(contact.corners(q[:-1], q[-1])) < 1e-3
    load = contact.load(q[:-1], q[-1], None, kappa)

    def energy(q):
        return barrier_energy(contact, contact.corners(q[:-1], q[-1]), kappa)

    found = [(energy(q + h * e) - energy(q - h * e)) / (2 * h) for e in np.eye(q.size)]
    assert np.abs(load.total).max() > 1e-6
    np.testing.assert_allclose(load.total, found, atol=1e-5 * np.abs(load.total).max())
    before = contact.corners(q[:-1] + 1e-3, q[-1] - 1e-3)
    tangent = contact.load(q[:-1], q[-1], before, kappa).tangent
    found = np.stack(
        [
            (contact.load(*at(q, h * e), before, kappa).total - contact.load(*at(q, -h * e), before, kappa).total)
            / (2 * h)
            for e in np.eye(q.size)
        ],
        -1,
    )
    np.testing.assert_allclose(tangent, found, atol=2e-5 * np.abs(found).max())


def test_what_was_found_along_a_way_serves_the_next_one_only_where_it_may(joint):
    """Against searches that have nothing to go back to."""
    row = Row(joint.rest, exposed=plate(sheet(*GRID, 0.04), ETA, BETA, 0.3, NU, along=4, across=1))
    used = RowContact(row, 0.0)
    motions = np.zeros(6 + row.exposed.amplitudes)
    for start, end, stopped in ((0.0, 0.02, False), (0.02, 0.1, True), (0.02, 0.0, False), (0.0, 0.1, True)):
        here, there = (used.corners(motions, phi) for phi in (start, end))
        share = used.free(here, there)
        assert (share < 1) == stopped
        assert share == RowContact(row, 0.0).free(here, there)


def at(q, step):
    return (q + step)[:-1], (q + step)[-1]


def twisted(joint, exposed, mu=0.3):
    return curve(shape(ETA, BETA, 0.32), joint.K, mu, [0.05, 0.08, 0.1], exposed=exposed, increment=4e-3)


def test_a_plate_without_thickness_is_the_thin_one(joint):
    usual, walk = twisted(joint, None)
    slim, flat = (box(ETA, BETA, 1e-6), sheet(np.array([0, ETA]), np.array([-BETA, BETA]), 0.0))
    # tolerance: the barrier sees two edges of the slim box, 8e-4 of the force on every processor
    for surface, rtol in ((flat, 1e-9), (slim, 1e-3)):
        other, way = twisted(joint, surface)
        for name in ("T", "N", "theta", "p", "s"):
            np.testing.assert_allclose(other[name], usual[name], rtol=rtol, err_msg=name)
        assert contacts(way) == contacts(walk)
    assert np.ptp(thin(ETA, BETA).points[:, 2]) == 0


def test_a_stiff_plate_is_rigid(joint):
    rigid, _ = twisted(joint, box(ETA, BETA, 0.04))
    stiff, _ = twisted(joint, plate(sheet(*GRID, 0.04), ETA, BETA, 1e5, NU))
    for name in ("T", "N", "theta", *MOTIONS):
        size = np.abs(rigid[name]).max()
        np.testing.assert_allclose(stiff[name], rigid[name], atol=1e-3 * size, err_msg=name)
    soft, _ = twisted(joint, plate(sheet(*GRID, 0.04), ETA, BETA, 0.1, NU))
    assert (soft["T"][1:] < 0.9 * rigid["T"][1:]).all()


@pytest.mark.parametrize("mu", [0.0, 0.3])
def test_the_torques_work_is_stored_in_joint_and_plates_or_rubbed_away(joint, mu):
    c, walk = twisted(joint, plate(sheet(*GRID, 0.04), ETA, BETA, 0.05, NU), mu)
    # tolerance: the step of 4e-3, 3.4e-4 measured on every processor
    assert abs(unbalanced(c)) < 1e-3
    assert contacts(walk) == ["tip edge C1B1 on side edge D2C2"]


RECORDED = json.loads((Path(__file__).parents[1] / "reference" / "thick_scales.json").read_text(encoding="utf-8"))


@pytest.mark.slow(but=1)
@pytest.mark.parametrize("name", ["thin_rigid", "thick_rigid", "thin_elastic", "thick_elastic"])
@pytest.mark.parametrize("i", range(len(RECORDED)))
def test_curves_of_an_independent_solution(i, name):
    """Edge on edge without a barrier, with the same modes; steps of .001 and .002."""
    g = RECORDED[i]
    h = g["thickness"] if name.startswith("thick") else 0.0
    if name.endswith("rigid"):
        exposed = box(g["eta"], g["beta"], h)
    else:
        surface = sheet(*lines(g["eta"], g["beta"], BRICKS), h)
        exposed = plate(surface, g["eta"], g["beta"], g["plate_D"], g["plate_nu"], along=6, across=3)
    beam = shape(*(g[name] for name in ("eta", "beta", "lam", "alpha_deg", "theta0_deg")))
    phi, T, N, p, s = np.array(g["curves"][name]["rows"]).T
    c, _ = curve(beam, np.array(g["K"]), g["mu"], phi, exposed=exposed, increment=4e-3)
    # tolerance: the barrier keeps a gap, which the solution does not: 0.2, 0.7 and 0.03 % on every processor
    np.testing.assert_allclose(c["T"], T, rtol=3e-3)
    np.testing.assert_allclose(c["N"], N, rtol=8e-3)
    np.testing.assert_allclose([c["p"], c["s"]], [p, s], atol=5e-4)

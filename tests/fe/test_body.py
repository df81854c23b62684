"""The condensed substrate against finite differences of whole solutions, and against moves that cost nothing."""

import numpy as np
import pytest

pytest.importorskip("numba", reason="needs the extra fe")

from solids import cube, images, relaxed

from squama.errors import InputError
from squama.fe import solver
from squama.fe.averages import Section
from squama.fe.body import Bent, Body
from squama.fe.elements import Elements, Helical, Material
from squama.fe.plate import Carried, Rest


@pytest.fixture(scope="module")
def body():
    nodes, tets = cube(4)
    master, turned, rest = images(nodes)
    elements = Helical(Elements(nodes, tets, Material(1.0, 0.25)), master, turned)
    tied = np.flatnonzero((np.abs(rest) < 0.26).all(1) & (np.abs(rest[:, 0]) < 1e-9))
    front = np.flatnonzero(np.abs(rest[:, 2] + 0.5) < 1e-9)
    made = Body(
        elements,
        rest,
        [(tied, Carried(Rest.at(1.0, 0.3, 0.1, 0.7, 0.3), rest[tied]))],
        sections=[Section.of_pitch(front, rest[front], np.ones(front.size))],
    )
    yield made
    made.solver.close()


V, PHI = np.array([0.01, 0.02, -0.01, 0.05, -0.04, 0.03]), 0.15


def test_scales_that_bend_stand_behind_the_body(body):
    bent, z, v = Bent(body, np.diag([2.0, 3.0])), body.start(), np.append(V, [0.1, -0.2])
    np.testing.assert_allclose(bent.places(z, v, PHI), body.places(z, V, PHI), atol=1e-12)
    r, own = bent.reduce(z, v, PHI), body.reduce(z, V, PHI)
    assert r.energy == pytest.approx(own.energy + (2 * 0.1**2 + 3 * 0.2**2) / 2)
    np.testing.assert_allclose(r.s, [*own.s, 0.2, -0.6])
    np.testing.assert_array_equal(r.S, np.block([[own.S, np.zeros((6, 2))], [np.zeros((2, 6)), np.diag([2.0, 3.0])]]))
    np.testing.assert_array_equal(r.s_phi, [*own.s_phi, 0, 0])
    np.testing.assert_allclose(r.update(v, 0.1), own.update(V, 0.1), atol=1e-12)


def test_the_condensed_tangent_is_that_of_whole_solutions(body):
    made = body
    z, r = relaxed(made, made.start(), V, PHI)
    assert r.unbalanced < 1e-13
    dice, h, dphi = np.random.default_rng(1), 1e-5, 0.6
    dv = dice.normal(size=6)
    rate = r.update(dv, dphi) - r.update(0 * r.s)
    (z1, up), (z0, down) = (relaxed(made, z, V + sign * h * dv, PHI + sign * h * dphi) for sign in (1, -1))
    assert (up.energy - down.energy) / (2 * h) == pytest.approx(r.s @ dv + r.torque * dphi, rel=1e-7)
    np.testing.assert_allclose((up.s - down.s) / (2 * h), r.S @ dv + r.s_phi * dphi, atol=1e-6)
    assert (up.torque - down.torque) / (2 * h) == pytest.approx(r.s_phi @ dv + r.torque_phi * dphi, rel=1e-6)
    np.testing.assert_allclose((z1 - z0) / (2 * h), rate, atol=1e-6)
    np.testing.assert_allclose(r.S, r.S.T, atol=1e-12)


def test_the_correction_leads_to_balance_quadratically(body):
    made = body
    z, steps = made.start(), []
    for _ in range(6):
        r = made.reduce(z, V, PHI)
        z = z + r.update(0 * r.s)
        steps.append(np.abs(r.update(0 * r.s)).max())
    assert steps[3] < 1e-6
    assert steps[5] < 1e-13


def test_superlu_gives_the_same(body, monkeypatch):
    made = body
    r = made.reduce(made.start(), V, PHI)
    monkeypatch.setattr(solver, "find_spec", lambda name: None)
    other = Body(made.elements, made.rest, made.rigid, sections=made.sections)
    q = other.reduce(other.start(), V, PHI)
    np.testing.assert_allclose(q.S, r.S, rtol=1e-9, atol=1e-10)
    np.testing.assert_allclose(q.update(0 * q.s), r.update(0 * r.s), atol=1e-10)


def test_a_node_is_tied_to_one_thing(body):
    made = body
    with pytest.raises(InputError, match="tied to two things"):
        Body(made.elements, made.rest, [*made.rigid, *made.rigid])

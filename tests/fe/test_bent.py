"""An endless beam that is bent and twisted at once: moves between pitches, derivatives, bars, virtual work."""

import numpy as np
import pytest
from scipy.linalg import expm

from squama.fe.periodic import STRAINS, Leg, Twist, power
from squama.fe.plate import Rest

pytest.importorskip("netgen", reason="meshes need netgen-mesher (the extra fe)")
pytest.importorskip("numba", reason="elements need numba (the extra fe)")

from solids import cube, images

from squama import combined
from squama.beam.matrixfile import inclination_stiffness
from squama.fe.assembly import make_bent, make_body, make_walk
from squama.fe.averages import Section
from squama.fe.body import Body
from squama.fe.elements import Elements, Helical, Material
from squama.fe.mesh import bar_mesh
from squama.fe.pitch_stiffness import response
from squama.fe.plate import Carried


def screw(strains, k):
    """Power k of the screw as a matrix (4, 4), by the exponential of its generator."""
    phi, psi, stretch = strains
    w = -np.array([psi, 0.0, phi])
    out = np.zeros((4, 4))
    out[:3, :3], out[2, 3] = np.cross(w, np.eye(3)).T, 1 + stretch
    return expm(k * out)


@pytest.mark.parametrize("strains", [(0.3, 0.2, -0.05), (0.0, 0.0, 0.0), (0.9, -0.7, 0.1), (0.2, 0.0, 0.0)])
@pytest.mark.parametrize("k", [1.0, 3.0, -0.4])
def test_pitches_follow_by_powers_of_a_screw(strains, k):
    found, exact = power(np.array(strains), k), screw(strains, k)
    np.testing.assert_allclose(found.Q, exact[:3, :3], atol=1e-13)
    np.testing.assert_allclose(found.t, exact[:3, 3], atol=1e-13)
    h = 1e-5
    for i, step in enumerate(h * np.eye(STRAINS)):
        up, down = (power(np.array(strains) + sign * step, k) for sign in (1, -1))
        for value, rate in (("Q", "dQ"), ("t", "dt"), ("dQ", "ddQ"), ("dt", "ddt")):
            slope = (getattr(up, value) - getattr(down, value)) / (2 * h)
            np.testing.assert_allclose(getattr(found, rate)[i], slope, atol=2e-9)


def test_twisting_alone_is_the_twist():
    k = np.array([1.0, -0.4, 2.0])
    one, other = Twist().moves(np.array([0.3]), k), Leg().moves(np.array([0.3, 0.0, 0.0]), k)
    for a, b in ((one.Q, other.Q), (one.t, other.t), (one.dQ, other.dQ[:, :1]), (one.ddQ, other.ddQ[:, :1, :1])):
        np.testing.assert_allclose(a, b, atol=1e-13)


def test_the_condensed_tangent_is_that_of_whole_solutions():
    nodes, tets = cube(4)
    master, turned, rest = images(nodes)
    leg = Leg()
    leg.turn(np.array([0.6, 0.8, 0.0]), 0.0)
    tied = np.flatnonzero((np.abs(rest) < 0.26).all(1) & (np.abs(rest[:, 0]) < 1e-9))
    front = np.flatnonzero(np.abs(rest[:, 2] + 0.5) < 1e-9)
    scale = Carried(Rest.at(1.0, 0.3, 0.1, 0.7, 0.3), rest[tied])
    section = Section.of_pitch(front, rest[front], np.ones(front.size), leg)
    body = Body(
        Helical(Elements(nodes, tets, Material()), master, turned, leg), rest, [(tied, scale)], sections=[section]
    )
    dice, h = np.random.default_rng(1), 1e-5
    v, dv, dw = 0.01 * dice.normal(size=9), dice.normal(size=9), 0.7

    def relaxed(z, v, way):
        for _ in range(15):
            r = body.reduce(z, v, way)
            z = z + r.update(0 * r.s)
        return z, body.reduce(z, v, way)

    z, r = relaxed(body.start(), v, 0.08)
    assert r.unbalanced < 1e-13
    rate = r.update(dv, dw) - r.update(0 * r.s)
    (z1, up), (z0, down) = (relaxed(z, v + sign * h * dv, 0.08 + sign * h * dw) for sign in (1, -1))
    assert (up.energy - down.energy) / (2 * h) == pytest.approx(r.s @ dv + r.torque * dw, rel=1e-6)
    np.testing.assert_allclose((up.s - down.s) / (2 * h), r.S @ dv + r.s_phi * dw, atol=1e-6)
    np.testing.assert_allclose((z1 - z0) / (2 * h), rate, atol=1e-6)
    np.testing.assert_allclose(r.S, r.S.T, atol=1e-12)
    body.solver.close()


def test_nine_motions_at_rest_are_those_of_linear_elements(fig6b, pitch):
    """The linear cell knows nothing of screws."""
    body = make_body(pitch, fig6b, Leg())
    found = body.reduce(body.start(), np.zeros(9), 0.0).S
    body.solver.close()
    K = response(pitch, fig6b).K
    np.testing.assert_allclose(found, K, rtol=0, atol=1e-10 * np.abs(K).max())


def test_a_bare_bar_bends_about_its_middle(fig6b):
    leg = Leg(0)
    body = make_body(bar_mesh(fig6b, 0.2), fig6b, leg)
    leg.turn(np.array([0.0, 1.0, 0.0]), 0.0)
    z, v, loose = body.start(), np.zeros(3), 2
    for _ in range(8):
        r = body.reduce(z, v, 0.05)
        dv = np.zeros(3)
        dv[loose] = -r.s[loose] / r.S[loose, loose]
        z, v = z + r.update(dv), v + dv
    body.solver.close()
    # the slope of a straight prism's moment; the stretch of the middle is of second order
    assert r.torque == pytest.approx(0.05 * fig6b.width * (2 * fig6b.lam) ** 3 / 12, rel=0.01)
    # tolerance: of second order, 0.5 % on every processor
    assert abs(v[loose]) < 0.02 * 0.05 * fig6b.lam


@pytest.fixture(scope="module")
def bent(fig6b, pitch):
    """Bent, then twisted, without friction; columns with the corner's row."""
    walk = make_bent(pitch, fig6b, 0.0)
    assert walk.run(walk.aim(0.08, 0.0), 0.01).reached
    corner = len(walk.columns["M"]) - 1
    assert walk.run(walk.aim(0.08, 0.1), 0.01).reached
    return {name: np.array(column) for name, column in walk.columns.items()}, corner


@pytest.mark.slow
def test_work_of_moment_and_torque_is_the_energy(bent):
    columns, corner = bent
    for part in (slice(0, corner + 1), slice(corner, None)):
        psi, phi, M, T, U = (columns[name][part] for name in ("psi", "phi", "M", "T", "U_el"))
        work = np.trapezoid(M, psi) + np.trapezoid(T, phi)
        # tolerance: the steps of 0.01, 0.5 to 0.9 % measured, on every processor
        assert work == pytest.approx(U[-1] - U[0], rel=0.01)
    assert columns["W"][-1] == pytest.approx(columns["U_el"][-1], rel=0.01)
    np.testing.assert_allclose(columns["force"], 0.0, atol=2e-7)


@pytest.mark.slow
def test_it_is_bent_about_its_middle_and_touches_where_the_hinge_does(fig6b, pitch, bent):
    columns, corner = bent
    assert columns["contact"][corner] == "corner B1 on the face of scale 2 (k = 1)"
    assert columns["contact"][-1] == "tip edge C1B1 on side edge D2C2 (k = 1)"
    line = columns["stretch"][1:corner] / columns["psi"][1:corner] / fig6b.lam
    assert (line > 0.02).all()
    assert (line < 0.08).all()
    # the hinge bent about its middle, on this mesh's joint
    K = response(pitch, fig6b).K
    ratios = {name: getattr(fig6b, name) for name in ("eta", "beta", "lam", "alpha", "theta0")}
    own = columns["M"] - columns["M"][3] / columns["psi"][3] * columns["psi"]
    near = [
        float(combined(0.08, 0.0, mu=0.0, toward=(1.0, 0.0), neutral_height=height, **ratios).bending_moment)
        for height in (0.0, fig6b.lam)
    ]
    found = own[corner] / inclination_stiffness(K[:7, :7])
    assert abs(found - near[0]) < abs(found - near[1])


@pytest.mark.slow
def test_a_twist_without_bend_is_that_of_the_cell(fig6b, pitch):
    """Held stretch and no bend: the torque of the twisted cell."""
    one, other = make_walk(pitch, fig6b, 0.3), make_bent(pitch, fig6b, 0.3, free=())
    assert one.run(0.09, 0.01).reached
    assert other.run(other.aim(0.0, 0.09), 0.01).reached
    np.testing.assert_allclose(other.columns["T"], one.columns["T"], rtol=1e-6)
    assert abs(other.columns["M"][-1]) > 0.1 * other.columns["T"][-1]


def test_only_bent_beams_are_aimed(fig6b, pitch):
    with pytest.raises(TypeError, match="not one to be bent"):
        make_walk(pitch, fig6b, 0.3).aim(0.1, 0.0)

"""Mirror image, similarity, periodicity of the row, farther neighbours by scaled ratios."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

import squama
from oracle.twisting import condition, places
from oracle.vectors import FP, dot, scale, sub
from properties.designs import Drawn, designs, follow
from squama.model.plates import CORNERS, Plates, gaps

senses = st.sampled_from(["+", "-"])
neighbours = st.integers(1, 6)


def angles_from(theta0: float) -> np.ndarray:
    return theta0 + np.array([0.0, 0.2, 0.7])


@given(designs(), senses, neighbours)
def test_contact_lies_on_both_edges_of_the_turned_plates(d: Drawn, sense: str, k: int) -> None:
    """Twisting the other way really turns the other way: by vectors, with the mirrored corners."""
    for theta in angles_from(d.theta0):
        c = squama.contact(theta, **d.ratios, sense=sense, neighbour=k)
        if np.isnan(c.phi):
            continue
        rigid = d.rigid(sense, k)
        size = (1 + d.eta + d.beta + d.lam) * k
        assert abs(condition(FP, rigid, theta, float(c.phi))) < 3e-12 * size
        p, s = places(FP, rigid, theta, float(c.phi))
        J2 = 1 - dot(scale(FP, rigid, theta, float(c.phi), 0).y, scale(FP, rigid, theta, float(c.phi), k).x) ** 2
        assert abs(p - c.p) < 1e-12 * size / J2
        assert abs(s - c.s) < 1e-12 * size / J2
        assert c.on_edges == (abs(c.p) <= d.beta and 0 <= c.s <= d.eta)
        assert 0 < c.phi <= math.pi / k


@given(designs(), senses, neighbours, st.sampled_from(["plate", "edge"]))
def test_a_farther_neighbour_is_the_nearest_of_scaled_ratios(d: Drawn, sense: str, k: int, law: str) -> None:
    far = {"sense": sense, **d.ratios}
    near = {**far, **{name: far[name] / k for name in ("eta", "beta", "lam")}}
    theta = angles_from(d.theta0)
    a, b = squama.contact(theta, **far, neighbour=k), squama.contact(theta, **near)
    same = {"rtol": 1e-12, "atol": 1e-300}
    np.testing.assert_allclose(a.phi, b.phi / k, **same)
    np.testing.assert_allclose(a.dphi_dtheta, b.dphi_dtheta / k, **same)
    for name in ("p", "s", "ds_dtheta", "dp_dtheta"):
        np.testing.assert_allclose(getattr(a, name), k * getattr(b, name), **same)
    friction = {"theta0": d.theta0, "mu": d.mu, "law": law}
    f, g = squama.forces(theta, **far, **friction, neighbour=k), squama.forces(theta, **near, **friction)
    for name in ("normal", "friction", "mu_lock"):
        np.testing.assert_allclose(getattr(f, name), getattr(g, name), **same)
    np.testing.assert_allclose(f.torque, k * g.torque, **same)
    np.testing.assert_allclose(f.dr_dtheta, k * g.dr_dtheta, **same)


def beam_of(d: Drawn) -> squama.Beam:
    return squama.Beam.from_ratios(
        eta=d.eta, beta=d.beta, lam=d.lam, alpha=d.alpha, theta0=d.theta0, zeta=0.9 * d.lam, mu=d.mu, width="2 m"
    )


@settings(max_examples=20)
@given(designs(), st.floats(1e-3, 1e3), senses)
def test_similar_beams(d: Drawn, c: float, sense: str) -> None:
    """All lengths c times: the same angles, K_theta and T c^3 times, forces c^2, energies per length c^2 times."""
    one = beam_of(d)
    two = one.replace(
        scale={n: c * getattr(one.scale, n) for n in ("length", "embedded", "width", "thickness")},
        substrate={"width": c * one.substrate.width, "thickness": c * one.substrate.thickness},
        pitch=c * one.pitch,
    )
    assert two.joint_stiffness == pytest.approx(c**3 * one.joint_stiffness, rel=1e-12)
    assert two.torsional_rigidity == pytest.approx(c**4 * one.torsional_rigidity, rel=1e-12)
    r, s = (squama.twist(b, points=20, sense=sense, joint="hinge") for b in (one, two))
    if r.end.item() != s.end.item() or abs(r.phi_end.item() - s.phi_end.item()) > 1e-9:
        # two ends that lie within rounding of each other
        assert r.phi_end.item() == pytest.approx(s.phi_end.item(), rel=1e-6)
        return
    for name, power in (("phi", 0), ("theta", 0), ("Phi", -1), ("f0", 0), ("RED", 0)):
        np.testing.assert_allclose(s[name], c**power * r[name], rtol=1e-7, atol=1e-10 * c**power)
    for name, power in (("T", 3), ("K_t", 4), ("N", 2), ("f", 2), ("U_el", 2), ("W_fr", 2), ("p", 1), ("s", 1)):
        size = float(np.nanmax(abs(r[name]))) if np.any(np.isfinite(r[name])) else 0.0
        np.testing.assert_allclose(s[name], c**power * r[name], rtol=1e-6, atol=1e-11 * size * c**power + 1e-300)


@given(designs(), st.floats(0.01, 1.0), st.integers(1, 4), st.integers(-3, 5), senses)
def test_every_pair_of_the_row_is_the_same_pair(d: Drawn, phi: float, k: int, j: int, sense: str) -> None:
    """Corners of scale j + k over the face of scale j, for any j, are what `gaps` gives for scales 1 and 1 + k."""
    theta = d.theta0 + 0.3
    sign = 1 if sense == "+" else -1
    plates = Plates(d.eta, d.beta, d.lam, sign * math.sin(d.alpha), math.cos(d.alpha))
    gap, inside = gaps(plates, np.array([theta]), np.array([phi]), np.array([k]))
    rigid = d.rigid(sense)
    one, two = scale(FP, rigid, theta, phi, j), scale(FP, rigid, theta, phi, j + k)
    for corner in range(8):
        name = CORNERS[corner % 4]
        if sign < 0:
            name = name.translate(str.maketrans("ABCD", "DCBA"))
        plate, other = (one, two) if corner < 4 else (two, one)
        arm = sub(getattr(other, name), plate.base)
        # the mirror image turns the normal of the faces round with it
        height, x, y = (float(dot(arm, v)) for v in (plate.z, plate.x, plate.y))
        assert gap[corner, 0, 0] == pytest.approx(height, abs=2e-14 * (d.eta + d.beta + d.lam + k))
        if min(abs(x), abs(x - d.eta), abs(abs(y) - d.beta)) > 1e-9:
            assert inside[corner, 0, 0] == (0 <= x <= d.eta and abs(y) <= d.beta)


@given(designs(), senses)
def test_the_scale_and_its_neighbours_share_one_curve(d: Drawn, sense: str) -> None:
    """Engagement, as the curve starts: theta0 on it, phi_e from `ends`, `contact` and the beam's response."""
    e = squama.ends(**d.ratios, theta0=d.theta0, mu=d.mu, sense=sense)
    assume(e.neighbour > 0)
    k = int(e.neighbour)
    c = squama.contact(d.theta0, **d.ratios, sense=sense, neighbour=k)
    assert c.phi == pytest.approx(float(e.phi_e), rel=1e-13)
    assert c.on_edges
    f = follow(d, "edge", sense)
    assert f is not None
    assert f.load_e == pytest.approx(float(e.phi_e), rel=1e-12)
    r = squama.twist(beam_of(d), sense=sense, points=3, joint="hinge")
    assert r.phi_e.item() == pytest.approx(float(e.phi_e), rel=1e-9)

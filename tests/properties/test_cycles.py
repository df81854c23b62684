"""Cycles of random designs: the loop's area is the work of friction, torques are those of the contact forces."""

from __future__ import annotations

import itertools
import math
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

import squama
from oracle import bending
from oracle.twisting import forces
from oracle.vectors import FP, MP
from properties.designs import Drawn, designs, follow
from squama.errors import InputError
from squama.model import history, mechanics
from squama.model.bending import Bend
from squama.model.history import Side
from squama.model.paths import FLOAT

NODES, WEIGHTS = np.polynomial.legendre.leggauss(24)
FOLDED = squama.Beam.from_ratios(
    eta=2.94, beta=0.83, lam=1.48, alpha="8.4 deg", theta0="12.7 deg", zeta=0.05, youngs_modulus="2 MPa"
)
MAIN = squama.Beam.from_ratios(youngs_modulus="2 MPa")
laws = st.sampled_from(["edge", "plate"])
fractions = st.lists(st.floats(0.02, 0.9), min_size=2, max_size=6, unique=True)


def sided(d: Drawn, law: str) -> Side | None:
    """Return a path up to 95 % of it, where its unloading is free."""
    f = follow(d, law)
    if f is None or f.x_end <= f.x0:
        return None
    side = Side(f.row, f.x0, f.x0 + 0.95 * (f.x_end - f.x0), f.pole, d.mu, law)
    return None if history.held(side, side.x0, side.x_end) is not None else side


def torque(side: Side, x: float, way: int, direct: Drawn | None) -> float:
    """Scales' torque at a place: Eq. 14, or the moment of the forces between the plates, from vectors."""
    pt = side.row.point(x, side.law, FLOAT)
    if direct is None:
        return float(side.forces(pt, way).torque)
    rigid = direct.rigid(k=int(side.row.k))
    return float(forces(pt.theta, pt.load, rigid, side.law, way * side.mu, FP).torque_direct)


def area(side: Side, a: float, b: float, direct: Drawn | None = None) -> float:
    """Area between both branches from a to b, by panels that get shorter towards the pole."""
    z = np.linspace(0, -math.log1p(-(b - a) / (side.pole - a)), 9 if direct is not None else 25)
    ends = a - (side.pole - a) * np.expm1(-z)
    total = 0.0
    for low, high in itertools.pairwise(ends):
        for node, weight in zip(NODES, WEIGHTS, strict=True):
            x = float((low + high) / 2 + (high - low) / 2 * node)
            rate = side.row.point(x, side.law, FLOAT).load_rate
            total += (high - low) / 2 * weight * rate * (torque(side, x, 1, direct) - torque(side, x, -1, direct))
    return total


def rubbed(side: Side, a: float, b: float) -> float:
    return float(history.work(side, a, b)(np.array(b))) + float(history.work(side, b, a)(np.array(a)))


@pytest.mark.slow
@given(designs(mu=(0.01, 3)), laws, st.floats(0, 0.5), st.floats(0.55, 1))
def test_the_area_of_a_loop_is_the_work_of_friction(d: Drawn, law: str, low: float, high: float) -> None:
    """For both laws, with the torque of Eq. 14."""
    side = sided(d, law)
    assume(side is not None)
    a, b = (side.x0 + v * (side.x_end - side.x0) for v in (low, high))
    assert rubbed(side, a, b) == pytest.approx(area(side, a, b), rel=1e-9)


@settings(max_examples=12)
@given(designs(mu=(0.05, 2)), st.floats(0, 0.5), st.floats(0.55, 1))
def test_edge_law_the_area_of_the_contact_forces_loop_is_the_work(d: Drawn, low: float, high: float) -> None:
    """The torque is that of the forces between the plates, written as vectors."""
    side = sided(d, "edge")
    assume(side is not None)
    a, b = (side.x0 + v * (side.x_end - side.x0) for v in (low, high))
    assert rubbed(side, a, b) == pytest.approx(area(side, a, b, direct=d), rel=1e-9)


def test_plate_law_the_area_of_the_contact_forces_loop_is_not_the_work() -> None:
    """It violates virtual work: its loop is defined by the torque of Eq. 14."""
    d = Drawn(3, 1.25, 0.45, math.radians(45), math.radians(10), 0.5)
    side = sided(d, "plate")
    ratio = area(side, side.x0, side.x_end, direct=d) / rubbed(side, side.x0, side.x_end)
    assert ratio == pytest.approx(1.0828, abs=1.5e-3)


@pytest.mark.parametrize("law", ["edge", "plate"])
def test_unloading_torque_to_twenty_digits_from_vectors(law: str) -> None:
    d = Drawn(3, 1.25, 0.45, math.radians(45), math.radians(10), 0.5)
    side = sided(d, law)
    for fraction in (0.1, 0.5, 0.9, 1):
        pt = side.row.point(side.x0 + fraction * (side.x_end - side.x0), law, FLOAT)
        b = side.forces(pt, -1)
        exact = forces(MP.mpf(pt.theta), MP.mpf(pt.load), d.rigid(), law, -MP.mpf(d.mu), MP)
        assert b.torque == pytest.approx(float(exact.torque_energy), rel=1e-11)
        assert b.N * d.eta == pytest.approx(float(exact.N0), rel=1e-11)
        assert b.f * d.eta == pytest.approx(float(exact.f0), rel=1e-11)
        if law == "edge":
            assert b.torque == pytest.approx(float(exact.torque_direct), rel=1e-11)


@pytest.mark.parametrize("mu", [0.1, 0.6])
def test_unloading_in_bending_by_its_closed_form_and_by_vectors(mu: float) -> None:
    eta, theta0 = 5.0, math.radians(5)
    row = Bend(eta, 1.0, 0.0, 0.0, 1.0, theta0)
    for theta in (0.1, 0.3, 0.7):
        pt = row.point(theta, "edge", FLOAT)
        b = mechanics.forces(pt, theta0, -mu)
        w, psi = theta + pt.load / 2, pt.load
        assert b.N * eta * math.sin(psi) * (1 / math.tan(w) + mu) == pytest.approx(theta - theta0, rel=1e-12)
        exact = bending.state(*(MP.mpf(v) for v in (theta, psi, eta, theta0)), -MP.mpf(mu))
        assert b.torque == pytest.approx(float(exact.moment_energy), rel=1e-11)
        assert b.torque == pytest.approx(float(exact.moment_direct), rel=1e-11)


@settings(max_examples=25)
@given(fractions, st.floats(0.02, 1.5), laws, st.sampled_from([MAIN, FOLDED]), st.sampled_from(["twisting", "bending"]))
def test_a_history_keeps_the_balance_of_work(
    parts: list[float], mu: float, law: str, beam: squama.Beam, load: str
) -> None:
    c, _ = ran(beam, parts, mu, law, load)
    rate, torque = ("Phi", "T") if load == "twisting" else ("kappa", "M")
    # closed at 0, so that what the torque has done is rubbed away
    work = np.trapezoid(c[torque].values, c[rate].values)
    spent = float(c.W_fr[-1])
    assert work == pytest.approx(spent, rel=1e-3, abs=1e-12 * float(c.U_el.max()))
    assert float(c.U_el[-1]) == 0
    assert float(c.W_d.sum()) == pytest.approx(float(c.W_fr[-1]), rel=1e-9)
    assert (np.diff(c.W_fr.values) >= -1e-12 * spent).all()
    assert (c.N.values >= 0).all()
    assert np.abs(c.f.values) == pytest.approx(mu * c.N.values)


def ran(beam: squama.Beam, parts: list[float], mu: float, law: str, load: str) -> tuple[Any, float]:
    far = squama.cycle(beam, 1e-3, mu=mu, law=law, load=load, margin=0.05, joint="hinge")
    name = "phi_most" if load == "twisting" else "psi_most"
    most = float(far[name][0]) / beam.pitch
    try:
        return squama.cycle(
            beam, [0, *(most * v for v in parts), 0], mu=mu, law=law, load=load, points=400, joint="hinge"
        ), most
    except InputError as error:
        assume("do not slide back" not in str(error))
        raise


@pytest.mark.slow
@settings(max_examples=15)
@given(fractions, laws, st.floats(0.02, 1.5), st.sampled_from([MAIN, FOLDED]))
def test_a_branch_depends_on_the_direction_only(parts: list[float], law: str, mu: float, beam: squama.Beam) -> None:
    c, most = ran(beam, parts, mu, law, "twisting")
    up = c.isel(point=np.flatnonzero(c.branch.values == "loading"))
    assume(up.sizes["point"] > 0)
    once = squama.twist(beam, at=up.Phi.values, mu=mu, law=law, joint="hinge")
    for name in ("T", "theta", "N", "f", "U_el", "K_t"):
        np.testing.assert_allclose(up[name], once[name], rtol=1e-9, atol=1e-9 * float(np.abs(once[name]).max()))
    down = c.isel(point=np.flatnonzero(c.branch.values == "unloading"))
    whole = squama.cycle(beam, max(parts) * most, mu=mu, law=law, points=3000, joint="hinge")
    way = whole.isel(point=np.flatnonzero(whole.branch.values == "unloading")[::-1])
    np.testing.assert_allclose(
        np.interp(down.phi, way.phi, way["T"]), down["T"], rtol=1e-3, atol=1e-3 * float(way["T"].max())
    )


@settings(max_examples=15)
@given(fractions, laws, st.sampled_from([MAIN, FOLDED]))
def test_without_friction_the_path_does_not_matter(parts: list[float], law: str, beam: squama.Beam) -> None:
    c, _ = ran(beam, parts, 0.0, law, "twisting")
    once = squama.twist(beam, at=c.Phi.values, mu=0, law=law, joint="hinge")
    for name in ("T", "theta", "N", "U_el"):
        np.testing.assert_allclose(c[name], once[name], rtol=1e-9, atol=1e-9 * float(np.abs(once[name]).max()))
    assert (c.W_fr.values == 0).all()
    assert (c.W_d.values == 0).all()
    assert (c.T_drop.values == 0).all()
    assert "stick" not in c.branch.values


def test_little_friction_takes_its_share_in_proportion() -> None:
    small = [squama.cycle(MAIN, "0.2 rad/pitch", mu=mu, joint="hinge") for mu in (0.0, 1e-4, 2e-4)]
    work = [float(c.W_d[0]) for c in small]
    drop = [float(c.T_drop[0]) for c in small]
    zeta = [float(c.zeta_eq[0]) for c in small]
    for v in (work, drop, zeta):
        assert v[0] == 0
        assert v[2] / v[1] == pytest.approx(2, rel=1e-6)
    # the branches lie about the frictionless curve: their mean differs in second order
    bare = float(small[0]["T"].max())
    mean = [float(c["T"].max() - c.T_drop[0] / 2) - bare for c in small[1:]]
    assert mean[1] / mean[0] == pytest.approx(4, rel=1e-3)


def test_a_history_through_a_fold() -> None:
    c = squama.cycle(FOLDED, "0, 0.64, 0.4, 0.65, 0 rad/pitch", mu=0.3, points=200, joint="hinge")
    top = int(c.phi.values.argmax())
    up = c.theta.values[:top]
    assert up[-1] < up.max() - 0.005
    assert c.end[0] == "off tip edge"
    assert c.phi_top.values == pytest.approx([0.64, 0.65])
    # the way back goes through the same inclinations
    phi, theta = c.phi.values[top + 1 :][::-1], c.theta.values[top + 1 :][::-1]
    once = squama.twist(FOLDED, at=phi / FOLDED.pitch, mu=0.3, joint="hinge")
    np.testing.assert_allclose(theta, once.theta, atol=1e-9)

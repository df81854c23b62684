"""Claims of the force laws over all designs: virtual work, balance, and what locks without friction."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

import squama
from oracle.twisting import directions, lifting, slips, tangent
from oracle.vectors import FP, add, cross, dot, mul, norm
from properties.designs import Drawn, balance, designs, each, follow, many, mirrored
from squama.model.paths import FLOAT, FoldedTwist

fractions = st.floats(0.01, 0.999)
senses = st.sampled_from(["+", "+", "-"])


def torque_by_vectors(d: Drawn, sense: str, k: int, theta: float, phi: float, normal: float, law: str) -> float:
    """Moment about the torsion axis of the contact forces that cross a section, for a given normal force."""
    v = slips(FP, d.rigid(sense, k), theta, phi)
    _, n12, _, t12, _ = directions(FP, law, v)
    force = mul(normal, add(n12, mul(d.mu, t12)))
    return float(-(1 if sense == "+" else -1) * k * cross(v.x12, force)[2])


@given(designs(), fractions, senses)
def test_edge_law_satisfies_virtual_work(d: Drawn, fraction: float, sense: str) -> None:
    f = follow(d, "edge", sense)
    assume(f is not None and f.x_end > f.x0)
    pt = f.at(fraction, "edge")
    b = balance(pt, d)
    direct = torque_by_vectors(d, sense, f.k, pt.theta, pt.load, b.N, "edge")
    assert direct == pytest.approx(b.torque, rel=1e-10)


def test_edge_law_satisfies_virtual_work_through_folds_and_with_far_neighbours() -> None:
    seen = {"beyond a fold": 0, "k > 1": 0}
    drawn = [("+", d) for d in each(many(150, 11))] + [("-", d) for d in each(mirrored(300, 13))]
    for sense, d in drawn:
        f = follow(d, "edge", sense)
        if f is None or f.x_end <= f.x0:
            continue
        folded = isinstance(f.row, FoldedTwist)
        for fraction in (0.3, 0.9):
            pt = f.at(fraction, "edge")
            b = balance(pt, d)
            direct = torque_by_vectors(d, sense, f.k, pt.theta, pt.load, b.N, "edge")
            assert direct == pytest.approx(b.torque, rel=1e-10)
            seen["beyond a fold"] += folded and pt.q < 0
            seen["k > 1"] += f.k > 1
    assert seen["beyond a fold"] > 15
    assert seen["k > 1"] > 15


@given(designs(), fractions, senses, st.sampled_from(["plate", "edge"]))
def test_joint_spring_balances_the_forces(d: Drawn, fraction: float, sense: str, law: str) -> None:
    f = follow(d, law, sense)
    assume(f is not None and f.x_end > f.x0)
    pt = f.at(fraction, law)
    b = balance(pt, d)
    v = slips(FP, d.rigid(sense, f.k), pt.theta, pt.load)
    lift = b.N * lifting(FP, law, d.mu, v)
    # moments cancel near a lock: compare with the parts
    part = b.N * max(abs(pt.M_N), d.mu * abs(pt.M_f))
    assert abs(lift - (pt.theta - d.theta0)) < 1e-10 * max(part, pt.theta)
    assert b.D > 0
    assert b.N >= 0
    assert b.f == d.mu * b.N
    # slip of the law's own measure, per unit of the path's own parameter
    n10, _, _, _, slip = directions(FP, law, v)
    assert abs(dot(v.slip10, n10)) < (1e-9 if law == "edge" else math.inf) * norm(FP, v.slip10)
    per_phi = tangent(FP, d.rigid(sense, f.k), pt.theta, pt.load)[1]
    assert pt.slip_rate / pt.load_rate == pytest.approx(slip / per_phi, rel=1e-8)


@given(designs(mu=(0.0, 0.0)), senses)
def test_without_friction_the_edge_law_locks_where_the_geometry_does(d: Drawn, sense: str) -> None:
    f = follow(d, "edge", sense)
    assume(f is not None)
    assert f.end not in ("frictional lock", "static lock")
    if f.end == "kinematic lock":
        pt = f.at(1.0, "edge")
        assert abs(pt.load_rate) < 1e-12 * abs(f.at(0.0, "edge").load_rate)
        assert abs(pt.M_N) < 1e-12
        # one ulp further the twist would fall
        beyond = f.row.point(f.x_end + 1e-6, "edge", FLOAT)
        assert beyond.load_rate < 0


def test_the_plate_law_locks_without_friction_where_the_edge_law_does_not() -> None:
    columns = many(300, 12)
    columns["mu"] = np.zeros(300)
    edge, plate = (squama.ends(**columns, law=law).end for law in ("edge", "plate"))
    assert np.sum(plate == "frictional lock") > 5
    assert np.sum(edge == "frictional lock") == 0
    assert np.sum(edge == "kinematic lock") > 50


@given(designs(), senses)
def test_friction_locks_first(d: Drawn, sense: str) -> None:
    """More friction never makes a path longer, and leaves engagement alone."""
    mus = d.mu * np.array([0.0, 0.25, 0.5, 1.0])
    e = squama.ends(**d.ratios, theta0=d.theta0, mu=mus, sense=sense)
    assert np.all(e.phi_e == e.phi_e[0])
    if np.isfinite(e.phi_e[0]):
        assert np.all(np.diff(e.phi_end) <= 1e-13 * e.phi_end[0])

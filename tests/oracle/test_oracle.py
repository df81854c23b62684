"""The oracle against the recorded figures, against itself, and against the facts of theory.md."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from . import bending
from .path import engagement, path_end, rigid_path, trace
from .plates import first_contact
from .twisting import LAWS, condition, contact, directions, forces, phi, places, slips, tangent
from .vectors import FP, MP, Design, add, dot, mul, norm, scale, sub
from .work import red, work

REFERENCE = Path(__file__).parent.parent / "reference"
RECORDED = json.loads((REFERENCE / "twisting.json").read_text(encoding="utf-8"))
MAIN = Design.of(3, 45, 1.25, 0.45, 10)
FOLDED = Design.of(3, 5, 1.25, 0.45, 10)


def near(a: Any, b: Any, tol: float = 1e-12) -> bool:
    return bool(abs(MP.mpf(a) - MP.mpf(b)) <= tol * max(1, abs(MP.mpf(b))))


@pytest.mark.slow(but=20)
@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("row", RECORDED, ids=range(len(RECORDED)))
def test_recorded_designs(row: dict[str, Any], law: str) -> None:
    d = Design.of(*(row[n] for n in ("eta", "alpha_deg", "beta", "lam", "theta0_deg")))
    mu, want = MP.mpf(str(row["mu"])), row["paper" if law == "plate" else law]
    e = path_end(d, mu, law)
    same = {"friction", "kinematic"} if mu == 0 and e.kind == "kinematic" else {e.kind}
    assert e.kind in same
    assert want["end"] in same
    assert near(e.phi_e, row["phi_e"])
    assert near(e.theta, want["theta_end"])
    assert near(e.phi, want["phi_end"])
    assert (e.neighbour is None) == (want["neighbour"] is None)
    if e.neighbour is not None:
        n = want["neighbour"]
        assert e.neighbour.k == n["k"]
        assert near(e.neighbour.theta, n["theta"])
        assert near(e.neighbour.phi, n["phi"])
    if "mid" not in want:
        assert e.theta == d.theta0
        return
    mid = want["mid"]
    theta = MP.mpf(mid["theta"])
    q = phi(theta, d)
    c, f = contact(theta, q, d, law), forces(theta, q, d, law, mu)
    got = {"phi": q, "p": c.p, "q": c.s, "dphi_dtheta": c.dphi_dtheta, "dr_dtheta": c.dr_dtheta}
    got |= {"f0": f.f0, "N0": f.N0, "dT_over_K": f.torque_energy}
    assert all(near(v, mid[k]) for k, v in got.items())


@pytest.mark.slow
@pytest.mark.parametrize(
    ("law", "theta", "q", "values"),
    [
        ("plate", "1.194017478", ".2661368122", {"1e-2": "1.9954132", "1e-4": "4.4256845"}),
        ("edge", "1.218912547", ".2690567103", {"1e-1": ".72050262", "1e-3": "2.8452067"}),
    ],
)
def test_work_of_section_4(law: str, theta: str, q: str, values: dict[str, str]) -> None:
    mu = MP.mpf("0.5")
    e = path_end(MAIN, mu, law)
    assert e.kind == "friction"
    assert near(e.theta, theta, 5e-10)
    # tolerance: recorded with ten digits, the works with eight
    assert near(e.phi, q, 5e-11)
    for margin, value in values.items():
        w = work(MAIN, mu, law, e, margin)
        assert near(w.W, value, 3e-8)
        assert w.error < 1e-15
        assert red(w, 0) == w.W / (w.W + w.spring)


@pytest.mark.parametrize("mu", ["0", "0.7"])
@pytest.mark.parametrize(("d", "theta", "branch"), [(MAIN, ".8", 0), (FOLDED, ".5", 0), (FOLDED, ".5", 1)])
def test_virtual_work_of_the_edge_law(d: Design, theta: str, branch: int, mu: str) -> None:
    t = MP.mpf(theta)
    q = phi(t, d, branch)
    f = forces(t, q, d, "edge", MP.mpf(mu))
    assert near(f.torque_direct, f.torque_energy, 1e-25)
    g = forces(t, q, d, "plate", MP.mpf(mu))
    assert not near(g.torque_direct, g.torque_energy, 1e-3)


def test_virtual_work_holds_with_a_farther_neighbour() -> None:
    d = Design.of(4, 40, 1, 0.5, 10).with_k(2)
    t = MP.mpf(".8")
    f = forces(t, phi(t, d), d, "edge", MP.mpf("0.4"))
    assert near(f.torque_direct, f.torque_energy, 1e-25)


def test_torques_of_section_3() -> None:
    t = 50 * MP.pi / 180
    f = forces(t, phi(t, MAIN), MAIN, "plate", MP.mpf(0))
    assert {MP.nstr(f.torque_energy, 4), MP.nstr(f.torque_direct, 4)} == {"3.604", "4.069"}


@pytest.mark.parametrize(("d", "branch"), [(MAIN, 0), (FOLDED, 1)])
def test_slip_is_the_difference_of_velocities(d: Design, branch: int) -> None:
    t = MP.mpf(".5")
    q = phi(t, d, branch)
    v, c = slips(MP, d, t, q), contact(t, q, d, "edge")
    dtheta = tangent(MP, d, t, q)[0]
    want = add(mul(dtheta * c.da_dtheta, v.one.x), mul(dtheta * c.dc_dtheta, v.zero.y))
    assert norm(MP, sub(v.slip10, want)) < 1e-27
    on_tip = add(v.zero.tip, mul(c.p, v.zero.y))
    assert norm(MP, sub(on_tip, v.x10)) < 1e-27


def test_normals_point_from_the_neighbour_to_scale_1() -> None:
    t, q = MP.mpf(".5"), phi(MP.mpf(".5"), MAIN)
    n12 = directions(MP, "edge", slips(MP, MAIN, t, q))[1]
    p, s = places(MP, MAIN, t, q - MP.mpf("1e-3"))
    one, two = (scale(MP, MAIN, t, q - MP.mpf("1e-3"), j) for j in (0, 1))
    gap = sub(add(one.tip, mul(p, one.y)), add(two.D, mul(s, two.x)))
    assert dot(gap, n12) > 0


def test_other_sense_is_the_mirror_image() -> None:
    d = Design.of(4, 60, 0.5, 0.6, 8)
    other = Design(d.eta, d.alpha, d.beta, d.lam, d.theta0, -1)
    mirror = Design(d.eta, -d.alpha, d.beta, d.lam, d.theta0, 1)
    t, q, mu = MP.mpf(".4"), MP.mpf(".3"), MP.mpf(".3")
    assert near(condition(MP, other, t, q), condition(MP, mirror, t, q), 1e-28)
    for law in LAWS:
        a, b = contact(t, q, other, law), contact(t, q, mirror, law)
        assert all(near(x, y, 1e-26) for x, y in zip(vars(a).values(), vars(b).values(), strict=True))
        f, g = forces(t, q, other, law, mu), forces(t, q, mirror, law, mu)
        assert all(near(x, y, 1e-26) for x, y in zip(vars(f).values(), vars(g).values(), strict=True))


def test_example_of_a_fold() -> None:
    e = path_end(FOLDED, MP.mpf("0.3"), "edge")
    assert e.kind == "edge-tip"
    assert [round(float(x) * 180 / np.pi, 1) for x in (e.theta_f, e.theta)] == [32.1, 23.4]
    assert round(float(e.phi), 2) == 1.38


def test_a_farther_neighbour_is_found_beyond_eta() -> None:
    row = RECORDED[5]
    assert row["eta"] < 2
    assert row["edge"]["neighbour"]["k"] == 2


def test_plates_see_the_engagement_and_the_second_contact() -> None:
    d = MAIN.floats()
    k, phi_e = engagement(MAIN)  # type: ignore[misc]
    beyond = np.column_stack([np.full(500, d.theta0), np.linspace(0, float(phi_e) + 0.01, 500)])
    c = first_contact(d.eta, d.beta, d.lam, d.alpha, d.theta0, beyond)
    assert c is not None
    assert (c.k, c.pair) == (1, ("edge-edge", "BC", "CD"))
    assert abs(c.phi - float(phi_e)) < 1e-9
    c = first_contact(d.eta, d.beta, d.lam, d.alpha, d.theta0, rigid_path(MAIN), skip_tip_side=k)
    assert c is not None
    one, two = scale(FP, d, c.theta, c.phi, 0), scale(FP, d, c.theta, c.phi, c.k)
    assert c.k > 1 or min(abs(dot(one.y, two.z)), abs(dot(two.x, one.z))) < 1e-6


def test_plates_in_the_other_sense() -> None:
    d = MAIN.floats()
    path = np.column_stack([np.full(2000, d.theta0), np.linspace(0, 0.9, 2000)])
    c = first_contact(d.eta, d.beta, d.lam, -d.alpha, d.theta0, path)
    assert c is not None
    assert c.pair != ("edge-edge", "BC", "CD")
    assert abs(c.phi - 0.38669098800552676) < 1e-9


def test_trace_stays_on_the_contact_curve() -> None:
    d = FOLDED.floats()
    points = trace(FOLDED, phi(FOLDED.theta0, FOLDED))
    assert float(np.abs(condition(np, d, points[:, 0], points[:, 1])).max()) < 1e-13


@pytest.mark.parametrize(("mu", "lock"), [("0", "1.00507"), ("0.3", ".96228"), ("0.6", ".86068"), ("1", ".70889")])
def test_bending(mu: str, lock: str) -> None:
    eta, theta0, m = MP.mpf(5), 5 * MP.pi / 180, MP.mpf(mu)
    e = bending.path_end(eta, theta0, m)
    assert e.kind == ("friction" if m else "kinematic")
    # tolerance: the figures have so many digits
    assert near(eta * e.psi, lock, 5e-6)
    assert near(e.psi_e, ".0193598", 5e-8)
    assert near(e.mu_static, "10.2826", 5e-6)
    theta = (theta0 + e.theta) / 2
    psi = bending.psi_of(theta, eta)
    b = bending.state(theta, psi, eta, theta0, m)
    assert near(b.moment_direct, b.moment_energy, 1e-24)
    assert near(theta - theta0, b.N0 * MP.sin(psi) * (MP.cot(theta + psi / 2) - m), 1e-26)
    assert bending.path_end(eta, theta0, MP.mpf(11)).theta == theta0


@pytest.mark.parametrize("index", [0, 21, 33, 50, 59])
def test_cases_are_what_the_oracle_gives(index: int) -> None:
    case = json.loads((REFERENCE / "cases.json").read_text(encoding="utf-8"))["cases"][index]
    d = Design.of(*(case[n] for n in ("eta", "alpha_deg", "beta", "lam", "theta0_deg", "sense")))
    e = path_end(d, MP.mpf(str(case["mu"])), "edge")
    assert (e.kind, e.k) == (case["edge"]["end"], case["k"])
    assert near(e.theta, case["edge"]["theta_end"], 1e-15)


def test_the_fold_example_is_not_reached_by_rigid_plates() -> None:
    """The side edge of scale 2 comes to lie in the face of scale 1 (n_X2 . n_Z1 = 0) before the fold."""
    d = FOLDED.floats()
    c = first_contact(d.eta, d.beta, d.lam, d.alpha, d.theta0, rigid_path(FOLDED), skip_tip_side=1)
    assert c is not None
    assert (c.k, c.pair) == (1, ("corner-face", "face", "D"))
    # tolerance: the figure has five decimals
    assert abs(c.phi - 0.43385) < 1e-5
    one, two = scale(FP, d, c.theta, c.phi, 0), scale(FP, d, c.theta, c.phi, 1)
    assert abs(dot(two.x, one.z)) < 1e-6

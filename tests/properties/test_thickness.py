"""Thick plates: contact and forces by plain vectors, virtual work, limits, other contacts by boxes, rows, bad input."""

from __future__ import annotations

import math

import numpy as np
import pytest

import squama
from oracle import boxes
from squama.arrays import solution
from squama.curves import doors
from squama.model.paths import ARRAY

SHAPE = ("eta", "beta", "lam", "alpha", "thickness")


def drawn(seed: int, n: int) -> list[dict[str, float]]:
    """Designs whose plates fill a part of the gap."""
    r, found = np.random.default_rng(seed), []
    for _ in range(n):
        alpha, theta0 = np.radians(r.uniform(15, 70)), np.radians(r.uniform(5, 20))
        fill = r.uniform(0.05, 0.6) * math.cos(alpha) * math.sin(theta0)
        shape = {"eta": r.uniform(2, 6), "beta": r.uniform(0.3, 2), "lam": r.uniform(0.2, 1), "alpha": alpha}
        found.append(shape | {"thickness": fill, "theta0": theta0, "mu": r.uniform(0, 1)})
    return found


@pytest.mark.parametrize("sense", ["+", "-"])
@pytest.mark.parametrize("k", [1, 2])
def test_points_meet_and_forces_balance_by_vectors(sense: str, k: int) -> None:
    """The lower tip edge rests on the upper side edge; N, T, slip and lock from D and its derivatives."""
    sign, counted = (1 if sense == "+" else -1), 0
    for d in drawn(k, 60):
        theta = d["theta0"] + 0.1
        shape = {name: d[name] for name in SHAPE}
        c = squama.contact(theta, **shape, sense=sense, neighbour=k)
        f = squama.forces(theta, **shape, theta0=d["theta0"], mu=d["mu"], sense=sense, neighbour=k)
        if not np.isfinite(c.phi):
            continue
        counted += 1
        alpha, h, p, s = sign * d["alpha"], d["thickness"] / 2, float(c.p), float(c.s)

        def points(
            theta: float, phi: float, d=d, alpha=alpha, h=h, p=p, s=s, k=k
        ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
            n, m = boxes.axes(alpha, theta, 0.0), boxes.axes(alpha, theta, k * phi)
            base = np.array([0, d["lam"], 0])
            tip = base + d["eta"] * n[0] + p * n[1] - h * n[2]
            other = boxes.turned(base, k * phi) + np.array([0, 0, k]) - d["beta"] * m[1] + s * m[0] + h * m[2]
            return tip - other, n[1], m[0]

        phi, step = float(c.phi), 1e-5
        D, e1, e2 = points(theta, phi)
        assert np.abs(D).max() < 1e-11
        D_theta = (points(theta + step, phi)[0] - points(theta - step, phi)[0]) / (2 * step)
        D_phi = (points(theta, phi + step)[0] - points(theta, phi - step)[0]) / (2 * step)
        n = np.cross(e2, e1)
        n /= np.linalg.norm(n)
        slip = D_theta + D_phi * float(c.dphi_dtheta)
        assert float(f.dr_dtheta) == pytest.approx(np.linalg.norm(slip), rel=3e-8)
        assert abs(n @ slip) < 1e-8
        t = slip / np.linalg.norm(slip)
        N = (theta - d["theta0"]) / (D_theta @ (n - d["mu"] * t))
        assert float(f.normal) / d["eta"] == pytest.approx(N, rel=1e-7)
        # the torque of the forces is that of the energy
        assert float(f.torque) == pytest.approx(-N * (D_phi @ (n - d["mu"] * t)), rel=1e-7)
        assert float(f.mu_lock) == pytest.approx(D_theta @ n / (D_theta @ t), rel=1e-7)
    assert counted > 10


def test_work_is_the_energy_without_friction() -> None:
    """T = d(U)/d(phi) at mu = 0, with phi(theta) differentiated by its own values."""
    for d in drawn(5, 20):
        shape = {name: d[name] for name in SHAPE}
        theta, step = d["theta0"] + 0.15, 2e-4
        phi = squama.contact(theta + step * np.array([-2, -1, 1, 2]), **shape).phi
        rate = (phi[0] - 8 * phi[1] + 8 * phi[2] - phi[3]) / (12 * step)
        torque = squama.forces(theta, **shape, theta0=d["theta0"], mu=0.0).torque
        assert float(torque) == pytest.approx((theta - d["theta0"]) / rate, rel=1e-8)


@pytest.mark.parametrize("sense", ["+", "-"])
def test_no_thickness_is_the_thin_plate_and_little_is_nearly_it(sense: str) -> None:
    columns = {name: np.array([d[name] for d in drawn(6, 300)]) for name in (*SHAPE, "theta0", "mu")}
    ts = columns.pop("thickness")
    thin, none = squama.solve(**columns, sense=sense), squama.solve(**columns, thickness=0 * ts, sense=sense)
    for a, b in zip(thin, none, strict=True):
        np.testing.assert_array_equal(a, b)
    little = squama.solve(**columns, thickness=1e-9 * ts, sense=sense)
    np.testing.assert_array_equal(little.code, thin.code)
    np.testing.assert_allclose(little.load_e, thin.load_e, rtol=1e-7)
    np.testing.assert_allclose(little.load_end, thin.load_end, rtol=1e-5)


def test_many_designs_are_answered_as_few() -> None:
    columns = {name: np.array([d[name] for d in drawn(7, 300)]) for name in (*SHAPE, "theta0", "mu")}
    many = squama.solve(**columns)
    few = squama.solve(**{name: v[:60] for name, v in columns.items()})
    assert {"frictional lock", "other contact"} <= set(many.end)
    np.testing.assert_array_equal(many.code[:60], few.code)
    for a, b in zip(many, few, strict=True):
        np.testing.assert_allclose(a[:60], b, rtol=1e-9, atol=1e-12)


def test_the_other_neighbour_that_ends_a_path_is_met_there() -> None:
    """Its tip and side edge, of thick plates, lie in one plane at the end, and only there."""
    columns = {name: np.array([d[name] for d in drawn(11, 600)]) for name in (*SHAPE, "theta0", "mu")}
    columns["mu"] *= 0.1
    e = squama.ends(**columns)
    met = np.flatnonzero((e.end == "other contact") & (e.neighbour == 1))

    def apart(i: int, theta: float, phi: float, k: int) -> float:
        eta, beta, lam, alpha, h = (float(columns[name][i]) for name in SHAPE)
        n, m = boxes.axes(alpha, theta, 0.0), boxes.axes(alpha, theta, k * phi)
        base = np.array([0, lam, 0])
        tip = base + eta * n[0] - h / 2 * n[2]
        side = boxes.turned(base, k * phi) + np.array([0, 0, k]) - beta * m[1] + h / 2 * m[2]
        across = np.cross(m[0], n[1])
        return float((tip - side) @ across / np.linalg.norm(across))

    assert met.size > 10
    for i in met:
        theta, phi, reach = float(e.theta_end[i]), float(e.phi_end[i]), int(columns["eta"][i]) + 1
        assert abs(apart(i, theta, phi, 1)) < 1e-9
        assert min(abs(apart(i, theta, phi, k)) for k in range(2, reach + 1)) < 1e-8


@pytest.mark.slow
@pytest.mark.parametrize("sense", ["+", "-"])
def test_other_contacts_are_the_first_overlap_of_boxes(sense: str) -> None:
    """Nowhere before the named contact do boxes overlap, and just behind it those of that neighbour do."""
    named = 0
    for d in drawn(8, 14):
        e = squama.ends(**d, sense=sense, contacts="all")
        sol = solution.solve({name: np.array([v]) for name, v in d.items()}, law="edge", sense=sense)
        stop = float(e.phi_touch) if e.other else float(e.phi_end)
        stop, last = min(stop, 0.6), np.array([d["theta0"]])
        phis = np.linspace(1e-4, min(float(e.phi_e), stop), 40)[:-1]
        places = [(d["theta0"], phi) for phi in phis]
        if sol.tracks:
            t = sol.tracks[0][1]
            with np.errstate(all="ignore"):
                pt = t.row.point(t.x0 + (t.x_end - t.x0) * np.linspace(1e-6, 1, 60), "edge", ARRAY)
            places += [(a, b) for a, b in zip(pt.theta, pt.load, strict=True) if b < stop * (1 - 1e-6)]
            last = pt.theta
        shape = (d["eta"], d["beta"], d["lam"], d["alpha"] * (1 if sense == "+" else -1), d["thickness"])
        most = int(math.hypot(d["eta"], 2 * d["beta"])) + 1
        assert all(boxes.distance(shape, a, b, k) > -1e-9 for a, b in places for k in range(1, most + 1))
        k = int(str(e.other).split("k = ")[1].rstrip(")")) if e.other else 0
        # the boxes do touch where it is named
        assert not k or abs(boxes.distance(shape, float(e.theta_touch), float(e.phi_touch), k)) < 1e-7
        if k and last.size == 1 and stop < 0.6:
            named += 1
            assert boxes.distance(shape, d["theta0"], stop * (1 + 1e-4), k) < 0
    assert named > 0 or sense == "+"


def test_plates_that_fill_the_gap_touch_at_rest() -> None:
    main = {"eta": 3, "beta": 1.25, "lam": 0.45, "alpha": np.pi / 4, "theta0": np.radians(10), "mu": 0.3}
    gap = math.cos(np.pi / 4) * math.sin(np.radians(10))
    e = squama.ends(**main, thickness=np.array([0.99, 1.0, 2.0]) * gap)
    assert list(e.end) == ["frictional lock", "touching at rest", "touching at rest"]
    assert list(e.phi_end[1:]) == [0.0, 0.0]
    assert list(e.neighbour) == [1, 0, 0]
    assert str(squama.ends(**main, thickness=gap, contacts="all").end) == "touching at rest"
    # short scales do not overlap: there is no gap to be filled
    assert str(squama.ends(**main | {"eta": 0.5, "beta": 0.3}, thickness=gap).end) == "no engagement"
    # narrow ones of a high alpha pass beside each other, wide ones do not
    for beta, rests in ((0.3, False), (0.4, False), (0.45, True), (3.0, True)):
        end = str(squama.ends(**main | {"alpha": np.radians(60), "beta": beta}, thickness=gap).end)
        assert (end == "touching at rest") == rests


def test_a_curve_and_a_row_of_thick_scales() -> None:
    """The curve engages where the closed form does; in the middle of a long row scales stand as in the endless beam."""
    beam = squama.Beam.from_ratios(eta=3, mu=0.2, scales=60)
    d = beam.pitch
    r = doors.respond(beam, "twisting", joint="hinge", ideal=False)
    ts = beam.scale.thickness / d
    e = squama.ends(**beam.ratios, mu=0.2, thickness=ts, contacts="all")
    assert float(r["phi_e"]) == pytest.approx(float(e.phi_e), rel=1e-13)
    assert float(r["phi_e"]) < float(doors.respond(beam, "twisting", joint="hinge", ideal=True)["phi_e"])
    row = squama.row(beam, to=0.8 * float(e.phi_end) / d, points=30, joint="hinge", ideal=False)
    middle = row.theta.isel(scale=30).values[1:]
    # the ends are felt in the middle yet
    # tolerance: 0.7 % measured on every processor
    np.testing.assert_allclose(middle, row.theta_periodic.values[1:], rtol=1e-2)


def test_a_curve_of_plates_that_touch_at_rest_is_at_rest() -> None:
    beam = squama.Beam.from_ratios(eta=3, mu=0.2)
    gap = math.cos(beam.scale.alpha) * math.sin(beam.scale.theta0)
    thick = beam.replace(scale={"thickness": 1.01 * gap * beam.pitch})
    r = squama.twist(thick, points=4, joint="hinge", ideal=False)
    assert str(r.end.item()) == "touching at rest"
    assert (float(r.phi_e), float(r.phi_end), float(abs(r.phi).max())) == (0.0, 0.0, 0.0)


@pytest.mark.parametrize(
    ("more", "words"),
    [
        ({"thickness": -0.1}, "thickness"),
        ({"thickness": np.nan}, "thickness"),
        ({"thickness": 0.1, "law": "plate"}, 'must be 0 with law="plate"'),
        ({"thickness": 0.1, "load": "bending"}, "must be 0 in bending"),
    ],
)
def test_bad_thickness_is_one_line(more: dict, words: str) -> None:
    main = {"eta": 3, "beta": 1.25, "lam": 0.45, "alpha": 0.7, "theta0": 0.2, "mu": 0.3}
    with pytest.raises(squama.InputError) as caught:
        squama.solve(**main, **more)
    assert words in str(caught.value)
    assert "\n" not in str(caught.value)

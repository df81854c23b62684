"""States of bent and twisted beams: independent figures, virtual work, and the two loads alone."""

import json
from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import expm

import squama
from plane import plane
from squama.errors import InputError
from squama.model import screw

CASES = json.loads((Path(__file__).parents[1] / "reference" / "combined.json").read_text())["cases"]
MAIN = {"eta": 3.0, "beta": 1.25, "lam": 0.45, "alpha": np.radians(45), "theta0": np.radians(10)}
FIELDS = {"theta": "theta", "N": "normal", "M": "bending_moment", "T": "torque", "mu_lock": "mu_lock"}


def states():
    """Yield what the reference says of single states: design, friction, place, direction, figures."""
    for case in CASES:
        design, mu = {k: float(v) for k, v in case["design"].items()}, float(case.get("mu", 0))
        path = {k: float(v) for k, v in case.get("path", {}).items()}
        found = [s["half"] for s in case.get("segments", []) if "half" in s]
        found += [case["state"]] if "state" in case else []
        for one in found:
            where = float(one["psi"]), float(one["phi"])
            yield design, mu, where, (path["dpsi"], path["dphi"]), one
            ways = {"then_psi": (1, 0), "then_phi": (0, 1)}
            yield from ((design, mu, where, way, one[name] | {"kind": one["kind"]}) for name, way in ways.items())
        if "proportional" in case:
            where = float(case["psi"]), float(case["phi"])
            ways = {"proportional": where, "last_twist": (0, 1), "last_bend": (1, 0), "last_untwist": (0, -1)}
            ways |= {"last_unbend": (-1, 0)}
            kind = {"kind": case["kind"], "theta": case["theta"]}
            yield from ((design, mu, where, way, case[name] | kind) for name, way in ways.items())
        if "TS_mu0.3" in case:
            where = float(case["psi"]), float(case["phi"])
            for friction in (0.0, 0.3):
                yield design, friction, where, where, case[f"TS_mu{friction:g}"] | {"kind": "TS"}


def test_states_are_those_of_the_reference():
    seen = set()
    for design, mu, (psi, phi), toward, expected in states():
        s = squama.combined(psi, phi, mu=mu, toward=toward, **design)
        assert s.contact == expected["kind"]
        seen.add(expected["kind"])
        for name, field in FIELDS.items():
            if name in expected and abs(float(expected[name])) < 1e10:
                assert getattr(s, field) == pytest.approx(float(expected[name]), rel=1e-12, abs=1e-12), (name, expected)
    assert seen == {"TS", "BF", "TA", "DF", "SB"} | (seen & {"CF", "AF"})


def test_free_to_twist_it_has_no_torque():
    for case in (c for c in CASES if "rows_psi_phi_theta_valid" in c):
        design = {k: float(v) for k, v in case["design"].items()}
        rows = np.array([[float(v) for v in row[:3]] for row in case["rows_psi_phi_theta_valid"] if row[3]])
        s = squama.combined(rows[:, 0], rows[:, 1], mu=0, toward=(1, 0), **design)
        # the rows follow corner B on the face, also where the base comes in first
        at = s.contact == "BF"
        assert at.any()
        assert (s.closing[~at] < 0).all()
        np.testing.assert_allclose(s.theta[at], rows[at, 2], rtol=1e-12)
        np.testing.assert_allclose((s.torque + float(case["bar_torsion"]) * rows[:, 1])[at], 0, atol=1e-12)


def test_twist_alone_is_that_of_forces():
    r = np.random.default_rng(3)
    n = 400
    design = {
        "eta": r.uniform(1.5, 5, n), "beta": r.uniform(0.3, 2, n), "lam": r.uniform(0.1, 1, n),
        "alpha": np.radians(r.uniform(20, 70, n)), "theta0": np.radians(r.uniform(3, 15, n)),
        "mu": r.uniform(0, 0.5, n),
    }  # fmt: skip
    ends = squama.ends(**design, law="edge")
    good = np.isfinite(ends.phi_e) & (ends.neighbour == 1)
    good[good] = ends.phi_end[good] > ends.phi_e[good]
    design = {name: v[good] for name, v in design.items()}
    phi = 0.3 * ends.phi_e[good] + 0.7 * ends.phi_end[good]
    s = squama.combined(0.0, phi, toward=(0, 1), neutral_height=r.uniform(-1, 1, phi.size), **design)
    still = s.contact == "TS"
    assert still.mean() > 0.8
    one = squama.forces(s.theta[still], **{name: v[still] for name, v in design.items()}, law="edge")
    where = squama.contact(
        s.theta[still], **{name: v[still] for name, v in design.items() if name not in ("mu", "theta0")}
    )
    np.testing.assert_allclose(where.phi, phi[still], rtol=1e-10)
    np.testing.assert_allclose(design["eta"][still] * s.normal[still], one.normal, rtol=1e-10)
    np.testing.assert_allclose(s.torque[still], one.torque, rtol=1e-10)


def test_bending_across_is_that_of_the_plane():
    beam = squama.Beam.from_ratios(eta=5, theta0="5 deg", mu=0.3)
    r = plane(beam, points=40)
    psi = r.psi.values[r.psi.values > float(r.psi_e)][:-1]
    theta = r.theta.values[r.psi.values > float(r.psi_e)][:-1]
    lam = beam.lam
    flat = {"eta": 5, "beta": 1, "lam": lam, "alpha": 0, "theta0": np.radians(5), "mu": 0.3, "neutral_height": lam}
    s = squama.combined(psi, 0.0, toward=(1, 0), **flat)
    np.testing.assert_allclose(s.theta, theta, rtol=1e-12)
    # the tip lies flush in the next face
    np.testing.assert_allclose(s.mu_lock, 1 / np.tan(theta + psi / 2), rtol=1e-9)


def test_moments_are_the_slopes_of_the_energy_for_every_contact():
    """M = dE/dpsi, T = dE/dphi at mu = 0: theta by the gap alone against the velocities at the place of contact."""
    r = np.random.default_rng(8)
    n, h = 4000, 1e-6
    lengths = [r.uniform(*limits, n) for limits in ((1.2, 5), (0.2, 2), (0.1, 1))]
    alpha, theta0, y_n = np.radians(r.uniform(0, 75, n)), np.radians(r.uniform(3, 20, n)), r.uniform(-1, 1, n)
    w, size = r.uniform(0, 2 * np.pi, n), r.uniform(0.02, 0.4, n)
    psi, phi = size * np.cos(w), size * np.sin(w)
    zero, one = np.zeros(n), np.ones(n)

    def pair(dpsi: float, dphi: float) -> tuple[screw.Pair, screw.Screw]:
        g = screw.Screw.of(psi + dpsi, phi + dphi, y_n)
        return screw.Pair.of(g, *lengths, alpha, theta0), g

    with np.errstate(all="ignore"):
        for name, kind in screw.CONTACTS.items():

            def theta(d: screw.Pair, kind: screw.Kind = kind) -> np.ndarray:
                F, rest = screw.gap(kind, d), np.tan(theta0 / 2)
                return np.where(screw.at(F, rest) < 0, 2 * np.arctan(screw.opening(F, rest)), np.nan)

            d, g = pair(0, 0)
            at = screw.place(kind, d, theta(d))
            g_theta = screw.dot(at.normal, at.V_theta)
            rates = {(h, 0): (np.array([-one, zero, zero]), np.array([zero, zero, y_n]))}
            rates[0, h] = np.array([zero, zero, -one]), np.zeros((3, n))
            for step, (dw, dv) in rates.items():
                slope = screw.dot(at.normal, g.rates(at.point, dw, dv)) / g_theta
                ahead, behind = (theta(pair(*(sign * x for x in step))[0]) for sign in (1, -1))
                difference = (ahead - behind) / (2 * h)
                good = np.isfinite(difference) & (np.abs(slope) < 20)
                assert good.sum() > 100, name
                np.testing.assert_allclose(slope[good], difference[good], rtol=1e-6, atol=1e-7, err_msg=name)


@pytest.mark.parametrize(
    ("psi", "phi", "kind"), [(0.08, 0.15, "TS"), (0.15, 0.05, "BF"), (-0.3, 0.15, "DF"), (0.1, -0.11, "SB")]
)
def test_loads_are_those_of_the_sections_between_two_scales(psi, phi, kind):
    """The contact force's moments about the axes of each section between the scales, averaged: M, T with friction."""
    y_n, mu, way = 0.2, 0.3, (0.6, 0.8)
    one = np.ones(1)
    s = squama.combined(psi, phi, mu=mu, toward=way, neutral_height=y_n, **MAIN)
    assert s.contact == kind
    g = screw.Screw.of(psi * one, phi * one, y_n * one)
    d = screw.Pair.of(g, *(v * one for v in MAIN.values()))
    here = screw.touching(d, s.closing * one, s.rolling * one)

    def pose(share: float, psi: float = psi, phi: float = phi) -> np.ndarray:
        w, v = -np.array([psi, 0, phi]), np.array([0, 0, 1 + psi * y_n])
        spin = np.array([[0, -w[2], w[1]], [w[2], 0, -w[0]], [-w[1], w[0], 0]])
        return expm(share * np.block([[spin, v[:, None]], [np.zeros((1, 4))]]))

    point = np.append(here.point[:, 0], 1.0)
    P = (pose(1) @ point)[:3]
    # slip by differences: the place on scale 2 moves, and scale 1 is lifted about its base
    h, n = 1e-6, here.normal[:, 0]
    moved = ((pose(1, psi + h * way[0], phi + h * way[1]) - pose(1, psi - h * way[0], phi - h * way[1])) @ point)[:3]
    V = here.V_theta[:, 0]
    slip = -moved / (2 * h)
    slip -= V * (n @ slip) / (n @ V)
    F = s.normal * (n - mu * slip / np.linalg.norm(slip))
    nodes, weights = np.polynomial.legendre.leggauss(20)
    mean = np.zeros(2)
    for node, weight in zip(nodes, weights / 2, strict=True):
        at = pose((1 + node) / 2)
        turn, force = at[:3, :3].T @ np.cross(P - at[:3, 3], F), at[:3, :3].T @ F
        mean += weight * np.array([-turn[0] + y_n * force[2], -turn[2]])
    np.testing.assert_allclose(mean, [s.bending_moment, s.torque], rtol=1e-7)


def test_no_contact_is_missed_by_rectangles():
    """Where nothing touches or one does, the edges of both plates stay off the other plate."""
    r = np.random.default_rng(5)
    n = 3000
    eta, beta, lam = r.uniform(1.2, 4, n), r.uniform(0.3, 1.5, n), r.uniform(0.1, 0.8, n)
    alpha, theta0 = np.radians(r.uniform(5, 60, n)), np.radians(r.uniform(5, 15, n))
    w, size = r.uniform(0, 2 * np.pi, n), r.uniform(0, 0.35, n)
    psi, phi = size * np.cos(w), size * np.sin(w)
    given = {"eta": eta, "beta": beta, "lam": lam, "alpha": alpha, "theta0": theta0}
    s = squama.combined(psi, phi, mu=0, toward=(1, 0), **given)
    d = screw.Pair.of(screw.Screw.of(psi, phi, 0 * psi), eta, beta, lam, alpha, theta0)
    nX, nZ, RX, RZ = d.axes(np.nan_to_num(s.theta))
    crossed = np.zeros(n, bool)
    corners = [(0, -1), (0, 1), (1, 1), (1, -1)]
    for base, (x, y, _), other, (u, v, m) in (
        (d.base, (nX, d.y, nZ), d.there, (RX, d.Ry, RZ)), (d.there, (RX, d.Ry, RZ), d.base, (nX, d.y, nZ)),
    ):  # fmt: skip
        at = [base + i * eta * x + j * beta * y - other for i, j in corners]
        for one, two in zip(at, [*at[1:], at[0]], strict=True):
            high, low = screw.dot(one, m), screw.dot(two, m)
            with np.errstate(all="ignore"):
                hit = one + (two - one) * (high / (high - low))
            # a little inside, for what touches lies on the border
            inside = (screw.dot(hit, u) > 1e-6) & (screw.dot(hit, u) < eta - 1e-6)
            inside &= np.abs(screw.dot(hit, v)) < beta - 1e-6
            crossed |= (high * low < -1e-12) & inside
    known = s.contact != screw.LOCKED
    assert known.sum() > 2000
    # where the inclination is that of a contact, and what touches is looked at alone, others have not come in
    assert (crossed & known).mean() < 0.02, s.contact[crossed & known]


def test_nothing_touches_and_nothing_leads_there():
    s = squama.combined([0.0, 0.01, 0.0], [0.0, 0.01, 0.4], mu=0.2, toward=(0, 1), **MAIN)
    assert s.contact.tolist() == ["", "", screw.LOCKED]
    np.testing.assert_array_equal(s.torque, [0, 0, np.nan])
    np.testing.assert_allclose(s.theta[:2], MAIN["theta0"])
    # along the ray the contact of the main state locks at mu = .848
    held = squama.combined(0.08, 0.15, mu=[0.8, 0.9], toward=(8, 15), **MAIN)
    assert np.isfinite(held.torque).tolist() == [True, False]


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"alpha": -0.1}, "alpha"), ({"theta0": 0.0}, "theta0"), ({"toward": 1}, "toward"), ({"psi": 4.0}, "psi"),
        ({"eta": np.nan}, "eta"), ({"mu": -1}, "mu"), ({"toward": (np.inf, 0)}, "dpsi"),
    ],
)  # fmt: skip
def test_bad_input_is_one_line(change, words):
    given = {"psi": 0.1, "phi": 0.1, "mu": 0.2, "toward": (0, 1), **MAIN, **change}
    with pytest.raises(InputError) as error:
        squama.combined(**given)
    assert words in str(error.value)
    assert "\n" not in str(error.value)


def test_what_sliding_needs_is_the_border_of_what_rest_bears():
    """Moments while sliding in any direction lie on the border; the cone ends where a direction just locks."""
    r = np.random.default_rng(6)
    w = r.uniform(0, 2 * np.pi, 50)
    place = 0.08, 0.15
    slid = squama.combined(*place, mu=0.3, toward=(np.cos(w), np.sin(w)), **MAIN)
    rest = squama.held(*place, mu=0.3, points=4000, **MAIN)
    M, T = rest.bending_moment, rest.torque
    gaps = np.hypot(slid.bending_moment[:, None] - M, slid.torque[:, None] - T).min(axis=1)
    # tolerance: the nearest of 4000 points of the border
    assert gaps.max() < 3e-3
    assert np.ptp(T) > 1
    assert np.isnan(rest.cone).all()
    # convex: it turns one way all along
    dM, dT = np.roll(M, -1) - M, np.roll(T, -1) - T
    turn = dM * np.roll(dT, -1) - dT * np.roll(dM, -1)
    assert (np.sign(turn) == np.sign(turn[0])).all()
    locked = squama.held(*place, mu=0.9, **MAIN)
    edge = squama.combined(*place, mu=0.9, toward=(locked.cone[:, 0], locked.cone[:, 1]), **MAIN)
    np.testing.assert_allclose(edge.mu_lock, 0.9, rtol=1e-10)
    low, high = np.sort(np.arctan2(locked.cone[:, 1], locked.cone[:, 0]))
    inside = (w > low) & (w < high)
    free = squama.combined(*place, mu=0.9, toward=(np.cos(w), np.sin(w)), **MAIN)
    assert inside.any()
    np.testing.assert_array_equal(np.isnan(free.torque), inside)
    # frictions that hold by themselves have no border all round
    assert np.isnan(locked.torque).any()
    assert np.isnan(squama.held(0.0, 0.01, mu=0.3, **MAIN).torque).all()
    assert squama.held([0.05, 0.08], [[0.1], [0.15]], mu=0.3, points=7, **MAIN).torque.shape == (2, 2, 7)

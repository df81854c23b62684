"""Paths in the plane of bend and twist: independent figures, work, symmetry, and what other plates do."""

import itertools
import json
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import squama
from plane import plane as across
from squama.model import energy, screw
from squama.model.outcome import End
from squama.model.screw_path import Design, Leg, follow, followed

FILE = Path(__file__).parents[1] / "reference" / "combined.json"
PATHS = [case for case in json.loads(FILE.read_text())["cases"] if "segments" in case]
MAIN = Design(3.0, 1.25, 0.45, np.radians(45), np.radians(10), 0.3)
FAR = 1.2
EVENTS = {
    "frictional lock": "friction", "kinematic lock (line contact)": "turn", "line": "line", "p+": "left",
    "p-": "right", "base": "base",
}  # fmt: skip


def read(case):
    """Return design, points and the reference's segments, its places as parts of the last leg."""
    design = Design(*(float(v) for k, v in case["design"].items() if k != "neutral_height"), float(case["mu"]))
    design = design._replace(y_n=float(case["design"]["neutral_height"]))
    psi0, phi0, dpsi, dphi = (float(v) for v in case["path"].values())
    held = [(psi0, phi0)] if psi0 or phi0 else []
    return design, [*held, (psi0 + FAR * dpsi, phi0 + FAR * dphi)], case["segments"]


@pytest.mark.parametrize("case", PATHS, ids=[case["id"] for case in PATHS])
def test_paths_are_those_of_the_reference(case):
    design, points, segments = read(case)
    pieces = list(followed(design, points))
    last = [p for p in pieces if p.leg == pieces[-1].leg and p.contact]
    # the reference stops where it leaves the tip
    assert [p.contact for p in last][: len(segments)] == [s["kind"] for s in segments]
    for piece, segment in zip(last, segments, strict=False):
        x0, x1 = FAR * piece.x0, FAR * piece.x1
        assert x0 == pytest.approx(float(segment["start"]["sigma"]), abs=2e-11)
        end = float(segment["end_at"]["sigma"])
        if segment["end"] == "base" and piece.contact == "BF":
            # it looks at the face of scale 1; a corner on that of scale 2 leaves where an edge lies in that one
            assert end < x1
            posed, theta, _, _ = piece.places(np.array([end / FAR]))
            _, nZ, RX, _ = posed.d.axes(theta)
            assert screw.dot(nZ, RX)[0] == pytest.approx(0, abs=1e-12)
        else:
            assert x1 == pytest.approx(end, abs=2e-11)
            assert EVENTS[segment["end"]] == piece.event
            ends = {"frictional lock": End.FRICTIONAL, "kinematic lock (line contact)": End.LINE}
            assert piece.end == ends.get(segment["end"], piece.end)
        half = segment["half"]
        at = {"psi": piece.leg.step[0], "phi": piece.leg.step[1]}
        axis = max(at, key=lambda name: abs(at[name]))
        start = piece.leg.start[("psi", "phi").index(axis)]
        state = piece.states(np.array([(float(half[axis]) - start) / at[axis]]))
        for name in ("theta", "N", "M", "T", "mu_lock"):
            if name in half and abs(float(half[name])) < 1e10:
                assert state[name][0] == pytest.approx(float(half[name]), rel=1e-10), name
        if "W_fr_to_0.8" in segment:
            x = piece.x0 + 0.8 * (end / FAR - piece.x0)
            pole = float(energy.pole(piece, np.array([x]), np.array([design.mu]), "", np.array([piece.x0]))[0])
            work = energy.work(piece, piece.x0, x, pole, design.mu, "")(x)
            assert work == pytest.approx(float(segment["W_fr_to_0.8"]), rel=3e-10)
    others = [s["no_other_pair_crosses"] for s in segments]
    found = [p for p in follow(design, points) if p.other]
    if all(other is True for other in others) and piece.end:
        assert not found
    for theta, sigma, k in (other for other in others if other is not True):
        # tolerance: its samples lie behind the touch
        assert found[0].other.endswith(f"(k = {k})")
        assert FAR * found[0].x1 == pytest.approx(sigma, abs=3e-3)
        assert found[0].states(np.array([found[0].x1]))["theta"][0] == pytest.approx(theta, abs=3e-3)


def test_twist_alone_is_that_of_forty_designs():
    """The recorded designs of twisting (16 digits): engagement, frictional locks, and a state half way."""
    locks = halves = 0
    for one in json.loads((FILE.parent / "twisting.json").read_text()):
        angles = np.radians(one["alpha_deg"]), np.radians(one["theta0_deg"])
        design = Design(one["eta"], one["beta"], one["lam"], *angles, one["mu"], 0.3)
        pieces = list(followed(design, [(0.0, 1.0)]))
        touching = [p for p in pieces if p.contact]
        edge = one["edge"]
        if not touching or touching[0].contact != "TS" or (edge["neighbour"] or {}).get("k"):
            continue
        assert touching[0].x0 == pytest.approx(float(one["phi_e"]), rel=1e-13)
        if edge["end"] == "friction" and touching[0].event == "friction":
            assert touching[0].x1 == pytest.approx(float(edge["phi_end"]), rel=1e-12)
            locks += 1
        mid = {name: float(v) for name, v in edge.get("mid", {}).items()}
        if mid and mid["phi"] < touching[0].x1:
            state = touching[0].states(np.array([mid["phi"]]))
            assert state["theta"][0] == pytest.approx(mid["theta"], rel=1e-13)
            assert design.eta * state["N"][0] == pytest.approx(mid["N0"], rel=1e-12)
            assert state["T"][0] == pytest.approx(mid["dT_over_K"], rel=1e-12)
            halves += 1
    assert locks > 8
    assert halves > 20


@pytest.mark.parametrize("mu", [0.0, 0.3, 1.0])
def test_across_and_with_the_face_it_is_bending_alone(mu):
    """The closed form of bending in the plane, which knows neither width nor thickness of the bar."""
    beam = squama.Beam.from_ratios(eta=5, theta0="5 deg")
    plane = across(beam, mu=mu)
    design = Design(5.0, 0.7, 0.4, 0.0, np.radians(5), mu, 0.4)
    free, flush = follow(design, [(1.0, 0.0)])
    assert free.x1 == pytest.approx(float(plane.psi_e), rel=1e-12)
    assert flush.end == plane.end.item()
    assert flush.x1 == pytest.approx(float(plane.psi_end), rel=1e-12)
    psi = plane.psi.values[plane.psi.values > free.x1 * 1.001]
    state = flush.states(psi[:-1])
    there = plane.sel(point=slice(-psi.size, -1))
    np.testing.assert_allclose(state["theta"], there.theta, rtol=1e-12)
    np.testing.assert_allclose(state["M"], there.M_scales / beam.joint_stiffness, rtol=1e-9)
    np.testing.assert_allclose(state["T"], 0, atol=1e-12)


def test_without_friction_the_stiffness_is_symmetric():
    design, h, seen = MAIN._replace(mu=0.0, y_n=0.2), 1e-5, set()

    def moments(psi, phi):
        piece = list(followed(design, [(psi, phi)]))[-1]
        seen.add(piece.contact)
        state = piece.states(np.array([1.0]))
        return state["M"][0], state["T"][0]

    for psi, phi in ((0.08, 0.15), (0.15, 0.05), (-0.1, 0.3)):
        dT_dpsi = (moments(psi + h, phi)[1] - moments(psi - h, phi)[1]) / (2 * h)
        dM_dphi = (moments(psi, phi + h)[0] - moments(psi, phi - h)[0]) / (2 * h)
        assert dT_dpsi == pytest.approx(dM_dphi, rel=1e-6)
    assert seen == {"TS", "BF"}


def test_work_of_the_loads_is_stored_or_rubbed_away():
    """M dpsi + T dphi around a polygon in contact: elastic energy and frictional work, by another quadrature."""
    stored = done = given = 0.0
    nodes, weights = np.polynomial.legendre.leggauss(40)
    for piece in follow(MAIN, [(0.1, 0.0), (0.1, 0.15), (0.06, 0.15), (0.06, 0.08)]):
        assert not piece.end
        x = (piece.x0 + piece.x1) / 2 + (piece.x1 - piece.x0) / 2 * nodes
        w = weights * (piece.x1 - piece.x0) / 2
        state, (psi, phi) = piece.states(x), piece.leg.step
        given += w @ (state["M"] * psi + state["T"] * phi)
        if piece.contact:
            done += energy.work(piece, piece.x0, piece.x1, piece.x1 + 1, MAIN.mu, "")(piece.x1)
            stored = (piece.states(np.array([piece.x1]))["theta"][0] - MAIN.theta0) ** 2 / 2
    assert done > 0.05
    assert given == pytest.approx(stored + done, rel=1e-8)


def test_corners_and_the_line_jump_at_one_inclination():
    pieces = list(follow(MAIN, [(0.1, 0.0), (0.1, 0.15), (0.1, 0.05)]))
    assert [p.contact for p in pieces] == ["", "BF", "BF", "TS", "TS", "BF"]
    assert [p.event for p in pieces] == ["closed", "", "line", "", "line", ""]
    for before, after in itertools.pairwise(pieces[1:]):
        a, b = (p.states(np.array([x])) for p, x in ((before, before.x1), (after, after.x0)))
        assert a["theta"] == pytest.approx(b["theta"], abs=1e-9)
        assert abs(a["M"] - b["M"]) > 0.05
        assert abs(a["T"] - b["T"]) > 0.05
    # along and against the line phi = psi tan(alpha) the two contacts share: the bend alone of scales across has no T
    across = MAIN._replace(alpha=0.0)
    (free, flush) = follow(across, [(0.2, 0.0)])
    assert flush.leg.flush
    np.testing.assert_allclose(flush.states(np.linspace(free.x1 + 0.01, 1, 9))["T"], 0, atol=1e-12)
    # just before the fold, where the inclination rises without bound, friction has locked
    steep = Design(5.0, 1.1, 0.49, np.radians(78), np.radians(4), 0.2)
    rubbed = list(follow(steep, [(0.17, 0.17 * np.tan(steep.alpha))]))[-1]
    rho = rubbed.x1 * 0.17 / np.cos(steep.alpha)
    assert rubbed.end is End.FRICTIONAL
    assert rubbed.states(np.array([rubbed.x1]))["theta"][0] + rho / 2 == pytest.approx(np.arctan(5), rel=1e-9)
    lock = list(follow(across._replace(mu=0.0, y_n=0.45), [(0.5, 0.0)]))[-1]
    assert lock.end is End.KINEMATIC
    # tolerance: the figure has five decimals
    assert lock.x1 * 0.5 == pytest.approx(0.33816, abs=1e-5)


def test_a_direction_that_friction_locks_ends_at_the_corner():
    """At psi = .08, phi = .15 the ray locks at mu = .848, bending alone at 1.037: the state is the same."""
    held = MAIN._replace(mu=0.9)
    ends = {}
    for name, points in {"ray": [(0.16, 0.3)], "bent": [(0.0, 0.15), (0.08, 0.15)]}.items():
        ends[name] = list(follow(held, points))[-1]
    assert (ends["ray"].end, ends["bent"].end) == (End.FRICTIONAL, "")
    assert ends["ray"].leg.loads(np.array(ends["ray"].x1))[0] < 0.08
    on = list(follow(held, [(0.0, 0.15), (0.08, 0.15), (0.16, 0.3)]))[-1]
    assert (on.end, on.x0, on.x1) == (End.FRICTIONAL, 0.0, 0.0)


@pytest.mark.slow
def test_no_pair_of_plates_crosses_along_random_paths():
    r = np.random.default_rng(12)
    contacts = set()
    for _ in range(200):
        lengths = (r.uniform(*at) for at in ((1.5, 4), (0.3, 1.5), (0.1, 0.8)))
        alpha, theta0, w = np.radians(r.uniform(1, 65)), np.radians(r.uniform(4, 15)), r.uniform(0, 2 * np.pi)
        design = Design(*lengths, alpha, theta0, r.choice([0.0, 0.4]), r.uniform(-0.5, 0.5))
        for piece in follow(design, [(0.5 * np.cos(w), 0.5 * np.sin(w))]):
            contacts.add(piece.contact)
            if piece.x1 - piece.x0 < 1e-6:
                continue
            x = r.uniform(piece.x0, piece.x1, 20)
            theta = piece.states(x)["theta"]
            d = piece.leg.posed(x).d
            assert not crossing(design, d, theta).any(), (design, piece)
    assert contacts >= {"", "TS", "BF", "TA", "DF", "SB"}


def crossing(design, d, theta):
    """Say where an edge of one rectangle passes through the other, by corners and edges in space alone."""
    nX, nZ, RX, RZ = d.axes(theta)
    hit_any = np.zeros(theta.size, bool)
    corners = [(0, -1), (0, 1), (1, 1), (1, -1)]
    for base, (x, y), other, (u, v, m) in (
        (d.base, (nX, d.y), d.there, (RX, d.Ry, RZ)), (d.there, (RX, d.Ry), d.base, (nX, d.y, nZ)),
    ):  # fmt: skip
        at = [base + i * design.eta * x + j * design.beta * y - other for i, j in corners]
        for one, two in zip(at, [*at[1:], at[0]], strict=True):
            high, low = screw.dot(one, m), screw.dot(two, m)
            with np.errstate(all="ignore"):
                hit = one + (two - one) * (high / (high - low))
            inside = (screw.dot(hit, u) > 1e-5) & (screw.dot(hit, u) < design.eta - 1e-5)
            inside &= np.abs(screw.dot(hit, v)) < design.beta - 1e-5
            hit_any |= (np.minimum(abs(high), abs(low)) > 1e-7) & (high * low < 0) & inside
    return hit_any


def test_a_path_is_followed_by_few_calls_on_whole_arrays(monkeypatch):
    cross, calls = screw.cross, []
    monkeypatch.setattr(screw, "cross", lambda *vectors: calls.append(1) or cross(*vectors))
    for piece in follow(MAIN, [(0.08, 0.15)]):
        piece.states(np.linspace(piece.x0, piece.x1, 100))
    # some 250; state by state it would be ten thousands
    assert 50 < len(calls) < 1000


def test_the_leg_along_the_line_is_flush():
    assert Leg(MAIN, (0.0, 0.0), (0.1, 0.1 * np.tan(MAIN.alpha))).flush
    assert not Leg(MAIN, (0.0, 0.0), (0.1, 0.1001)).flush
    assert not Leg(MAIN, (0.1, 0.0), (0.1, 0.1)).flush


def test_a_gap_that_closes_beside_the_plates_is_waited_for():
    """The corner comes to the next face later than its plane's gap closes; a path that waited there had no end."""
    design = Design(1.105, 2.978, 2.18, 0.01434, 1.3307, 1.0, 0.0)
    first, second = itertools.islice(follow(design, [(np.pi / 2, 0.0)]), 2)
    assert (first.contact, second.contact, str(second.end)) == ("", "BF", "static lock")
    behind, before = (first.leg.touching(np.array([first.x1 + way])).contact[0] for way in (1e-8, -1e-8))
    assert (behind, before) == ("BF", "")
    # the arrays of bending say the same
    s = squama.solve(eta=1.105, beta=2.978, lam=2.18, alpha=0.01434, theta0=1.3307, mu=1.0, load="bending")
    assert s.end.item() == "static lock"
    assert float(s.load_e) == pytest.approx(first.x1 * np.pi / 2, abs=3e-8)


def test_rotations_by_vectors_of_any_size():
    rng = np.random.default_rng(5)
    w = rng.normal(size=(200, 3)) * 10.0 ** rng.uniform(-12, 0.4, (200, 1))
    np.testing.assert_allclose(screw.rotations(w), Rotation.from_rotvec(w).as_matrix(), atol=1e-14)

"""A tip edge and its corners on a face, of a bent beam on compliant joints: by plain vectors, hinges, energies."""

from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from scipy.linalg import expm
from scipy.spatial.transform import Rotation

import squama
from legs import Bent, follow_legs, follow_straight
from oracle.barrier import monomials
from squama.arrays.combined_states import combined
from squama.contacts import path, states
from squama.curves import compliant
from squama.joints import law

PLA = squama.Beam.from_toml("examples/pla_on_vps.toml").replace(scales=None, hold="bend, twist, lateral bend")
SKIN = squama.Beam.from_toml("examples/stiff_skin.toml").replace(scales=None, hold="bend, twist, lateral bend")


def followed(beam: squama.Beam, corners: Any, mu: float = 0.3, *, ideal: bool = False) -> tuple[path.Scale, Bent]:
    one = compliant.scale(beam, ideal=ideal)
    return one, follow_legs(one, compliant.Held.of(beam).K, mu, np.array(corners, float))


def ray(*corners: tuple[float, float], n: int = 40) -> list[np.ndarray]:
    points = np.array([(0.0, 0.0), *corners])
    return [a + (b - a) * w for a, b in pairwise(points) for w in np.arange(1, n + 1) / n]


def heights(one: path.Scale, found: Bent, i: int) -> dict[str, Any]:
    """Places of a state by plain vectors: heights of the tip edge over the next scale's face, force and slip there."""
    row = path.named(found.rows[i])
    # the place on the other scale
    row |= dict(zip("xy", found.answers.touches[0, i, 0, 8:10], strict=True))
    b = path.deflections(found.rows)[i]
    s, c = np.sin([one.alpha, one.theta0]), np.cos([one.alpha, one.theta0])
    axes = np.array([[-s[0] * c[1], s[1], c[0] * c[1]], [c[0], 0, s[0]], [s[0] * s[1], c[1], -c[0] * s[1]]])
    u, w = (np.array([row[f"{name}_{x}"] for x in "XYZ"]) for name in "uw")
    E = Rotation.from_rotvec(w).as_matrix()
    motion = np.zeros((4, 4))
    motion[:3, :3] = np.cross(np.eye(3), [-row["psi"], 0.0, -row["twist"]])
    motion[2, 3] = 1 + row["stretch"]
    g, base = expm(motion), np.array([0.0, one.lam, 0.0])

    def lift(x: float, y: float) -> float:
        return float((monomials(np.array([x / one.eta]), np.array([y / one.beta])) @ b)[0])

    def below(y: float) -> tuple[np.ndarray, float]:
        """A place of the tip edge in the axes of the next scale, and its height over that one's upper face."""
        at = axes.T @ (u + E @ [one.eta, y, lift(one.eta, y) - one.h / 2]) + base
        there = E.T @ (axes @ (g[:3, :3].T @ (at - g[:3, 3]) - base) - u)
        return there, float(there[2] - one.h / 2 - lift(there[0], there[1]))

    h = 1e-5
    slope = [(lift(row["x"] + h, row["y"]) - lift(row["x"] - h, row["y"])) / (2 * h)]
    slope += [(lift(row["x"], row["y"] + h) - lift(row["x"], row["y"] - h)) / (2 * h)]
    normal = g[:3, :3] @ axes.T @ E @ [-slope[0], -slope[1], 1.0]
    force = axes.T @ [row["F_x"], row["F_y"], row["F_z"]]
    return {"row": row, "below": below, "normal": normal / np.linalg.norm(normal), "force": force}


@pytest.mark.parametrize("beam", [PLA, SKIN], ids=["pla", "skin"])
def test_what_touches_touches_and_nothing_else_goes_through(beam: squama.Beam) -> None:
    one, found = followed(beam, ray((0.08, 0.0), (0.08, 0.14)))
    kinds, alone = set(), set()
    for i in range(30, 80, 3):
        p = heights(one, found, i)
        row, y = p["row"], np.linspace(-one.beta, one.beta, 33)
        if row["second"] != 4 or row["N"] <= 0:
            continue
        kinds.add(int(row["first"]))
        along = {5: -one.beta, 6: one.beta}.get(int(row["first"]), float(row["along"]))
        there, gap = p["below"](along)
        np.testing.assert_allclose(there[:2], [row["x"], row["y"]], atol=1e-6)
        assert abs(gap) < 1e-6
        inside = [p["below"](v) for v in y]
        # nothing goes through: -2e-10 measured
        assert min(h for place, h in inside if abs(place[1]) < one.beta) > -1e-8
        if row["contacts"] > 1:
            # N and friction are sums
            continue
        alone.add(int(row["first"]))
        # the force is that of friction about the face's normal
        N = p["force"] @ p["normal"]
        assert pytest.approx(row["N"], rel=1e-4) == N
        across = np.linalg.norm(p["force"] - N * p["normal"])
        assert across <= 0.3 * N * (1 + 1e-3)
        assert across == pytest.approx(row["f"], rel=2e-3)
        if row["first"] == 0:
            # tangent there
            ends = [p["below"](along + h)[1] for h in (-1e-4, 1e-4)]
            assert (ends[1] - ends[0]) / 2e-4 == pytest.approx(0.0, abs=1e-5)
    assert kinds == {0, 6}
    assert alone


@pytest.mark.parametrize("mu", [0.0, 0.3])
def test_work_is_stored_or_rubbed_away(mu: float) -> None:
    r = squama.bend_twist(SKIN, "bend 0.08 rad/pitch; twist 0.15 rad/pitch", mu=mu, points=250)
    assert {"BF", "TF", "TS"} <= set(r.contact.values)
    given = np.trapezoid(r.M, r.kappa) + np.trapezoid(r["T"], r.Phi)
    assert given == pytest.approx(float(r.U_el[-1] + r.W_fr[-1]), rel=5e-4)
    if not mu:
        # moment and torque are the energy's slopes, whatever touches: so they do not jump where contacts hand over
        for name, load in (("M", "kappa"), ("T", "Phi")):
            leg = r.leg.values == (1 if name == "M" else 2)
            x, U = r[load].values[leg], r.U_el.values[leg]
            np.testing.assert_allclose(
                np.gradient(U, x)[3:-3], r[name].values[leg][3:-3], atol=0.02 * float(r[name].max()), rtol=0.02
            )


@pytest.mark.parametrize(("psi", "phi", "contact"), [(0.1, 0.0, "BF"), (0.12, 0.05, "BF"), (0.03, 0.12, "TS")])
@pytest.mark.parametrize("mu", [0.0, 0.2])
def test_thin_scales_on_a_joint_that_only_lifts_are_hinges(psi: float, phi: float, contact: str, mu: float) -> None:
    eta, beta, lam, alpha, theta0 = 3.0, 0.6, 0.4, np.radians(45), np.radians(15)
    stiff = np.diag([1e3, 1e3, 1e3, 1e3, 0.013, 1e3, 0.05, 0.05, 1e3])
    one = path.Scale(eta, beta, lam, alpha, theta0, 0.0)
    found = follow_straight(one, stiff, mu, np.array([(psi, phi)]), free=path.HELD)
    hinge = combined(psi, phi, eta=eta, beta=beta, lam=lam, alpha=alpha, theta0=theta0, mu=mu, toward=(psi, phi))
    assert hinge.contact == contact
    own = (found.M[0] - 0.05 * psi) / 0.013, (found.T[0] - 0.05 * phi) / 0.013
    np.testing.assert_allclose(own, [hinge.bending_moment, hinge.torque], rtol=3e-3, atol=3e-3)


def test_a_state_is_the_same_whatever_stations_lead_there() -> None:
    ends = [(0.06, 0.05), (0.06, 0.1)]
    _, few = followed(SKIN, ends)
    _, many = followed(SKIN, ray(*ends, n=57))
    np.testing.assert_allclose([few.M[-1], few.T[-1]], [many.M[-1], many.T[-1]], rtol=6e-3)
    assert few.answers.contact().phi == pytest.approx(many.answers.contact().phi, rel=1e-9)


@pytest.mark.parametrize(
    ("alpha", "mu", "corners"),
    [("", 0.2, [(0.08, 0.0), (0.08, 0.05)]), ("45 deg", 0.4, [(0.08, 0.0), (0.08, 0.05), (0.08, -0.05), (0.08, 0.05)])],
)
def test_the_mirror_image_rests_on_the_other_corner(alpha: str, mu: float, corners: list[tuple[float, float]]) -> None:
    """Every step is the mirror image's: 3e-9 apart, where an angle of slip that leapt by a turn left 1e-6 to 5e-5."""
    beam = SKIN.replace(scale={"alpha": alpha}) if alpha else SKIN
    one = compliant.scale(beam, ideal=False)
    K, signs = compliant.Held.of(beam).K, path.MIRROR
    found = follow_legs(one, K, mu, np.array(corners))
    image = follow_legs(one._replace(alpha=-one.alpha), K * np.outer(signs, signs), mu, np.array(corners) * [1.0, -1.0])
    assert (found.answers.contact().words, image.answers.contact().words) == (
        "corner B on face (k = 1)", "corner C on face (k = 1)",
    )  # fmt: skip
    np.testing.assert_allclose(image.M, found.M, rtol=1e-7)
    np.testing.assert_allclose(image.T, -found.T, rtol=1e-7)


@pytest.mark.parametrize("ideal", [False, True])
@pytest.mark.parametrize("mu", [0.0, 0.3])
def test_a_tip_edge_across_the_beam_comes_to_the_face_all_along(ideal: bool, mu: float) -> None:
    one, found = followed(SKIN.replace(scale={"alpha": "0 deg"}), ray((0.15, 0.0)), mu, ideal=ideal)
    met = found.way.contact
    # its corners come down together, on the side edges of the next one
    assert met.words in ("corner B on face (k = 1)", "corner C on face (k = 1)")
    np.testing.assert_allclose(found.T, 0.0, atol=1e-7)
    # hardly oblique scales come there by a corner; rigid ones roll onto the edge within a station's way
    hardly = "0.001 deg" if ideal else "0.01 deg"
    _, near = followed(SKIN.replace(scale={"alpha": hardly}), ray((0.15, 0.0)), mu, ideal=ideal)
    assert near.way.contact.words == "corner B on face (k = 1)"
    # tolerance: what these angles do, 5e-8 and 4e-9 measured; a corner in place of the edge left 6e-4 at a station
    np.testing.assert_allclose(found.M, near.M, rtol=0.0, atol=2e-6 * near.M[-1])
    p = heights(one, found, 39)
    assert abs(p["below"](0.0)[1]) < 1e-6


@pytest.mark.parametrize("n", [60, 200])
def test_a_tip_edge_that_sticks_beside_its_corner_rubs_nothing_away(n: int) -> None:
    """Bent far, the tip edge and its corner hold on the face at once: what is done is stored."""
    beam, mu = SKIN.replace(scale={"alpha": "2 deg"}), 0.5
    one, found = followed(beam, ray((0.26, 0.0), (0.26, 0.01), n=n), mu)
    assert np.isfinite(found.M).all()
    sticks = np.flatnonzero((found.column("mode") == 2) & (found.column("first") == 0))
    assert (found.column("contacts")[sticks] == 2).any()
    for i in sticks[:: max(1, sticks.size // 5)]:
        p = heights(one, found, i)
        here = p["row"]["along"]
        there, gap = p["below"](here)
        np.testing.assert_allclose(there[:2], [p["row"]["x"], p["row"]["y"]], atol=1e-5)
        ends = [p["below"](here + h)[1] for h in (-1e-4, 1e-4)]
        assert abs(gap) < 1e-6
        assert (ends[1] - ends[0]) / 2e-4 == pytest.approx(0.0, abs=1e-5)
    # a stretch on which both hold
    parts = np.split(sticks, 1 + np.flatnonzero(np.diff(sticks) > 1))
    part = max(parts, key=len)
    assert part.size > 1
    assert np.ptp(found.column("W_fr")[part]) == 0.0
    U = np.sum(list(states.energies(found.way, found.rows[part]).values()), axis=0)
    # tolerance: steps of the path, 1e-6 and less, on every processor
    assert np.ptp(found.column("W")[part]) == pytest.approx(np.ptp(U), rel=1e-3)


@pytest.mark.parametrize("ideal", [pytest.param(False, marks=pytest.mark.slow), True])
def test_friction_may_hold_a_contact_from_the_first_on(ideal: bool) -> None:
    beam, far = SKIN.replace(scale={"alpha": "60 deg", "embedded": "3 mm"}), (0.03, 0.1)
    one, found = followed(beam, ray(far), 1.0, ideal=ideal)
    rows = found.rows
    touches = rows[:, path.COLUMNS.index("N")] > 0
    assert touches.sum() > 10
    assert (rows[touches, path.COLUMNS.index("mode")] == 2).all()
    assert (rows[:, path.COLUMNS.index("W_fr")] == 0.0).all()
    f, N = (rows[touches, path.COLUMNS.index(name)] for name in "fN")
    assert (f <= N).all()
    # what holds does not ask by how much
    np.testing.assert_allclose(found.M, followed(beam, ray(far), 1.1, ideal=ideal)[1].M, rtol=1e-8)
    # all work is stored, and general contact finds the same
    U = np.sum(list(states.energies(found.way, rows).values()), axis=0)
    loads, steps = np.column_stack([found.M, found.T]), np.diff(np.array(ray(far)), axis=0)
    # tolerance: trapezoids between the rows, 4e-4, and the barrier of general contact, 1 %, on every processor
    assert ((loads[1:] + loads[:-1]) / 2 * steps).sum() == pytest.approx(U[-1] - U[0], rel=2e-3)
    pytest.importorskip("ipctk", reason="general contact needs ipctk (the extra fe)")
    from oracle.barrier import surface
    from squama.fe.assembly import make_bent
    from squama.fe.geometry import Geometry

    shape = Geometry(np.nan, one.lam, np.nan, one.eta, one.beta, one.h, one.alpha, one.theta0, np.nan)
    led = make_bent(compliant.Held.of(beam).K, shape, 1.0, exposed=surface(one))
    assert led.run(led.aim(*far), 4e-3).reached
    other = np.array([led.columns[name][-1] for name in "MT"], float)
    np.testing.assert_allclose([found.M[-1], found.T[-1]], other, rtol=0.02)


@pytest.mark.parametrize("alpha", [36, 42, 43, 44, 45, 50])
def test_engagement_is_found_where_edges_cross_near_a_corner(alpha: float) -> None:
    """Twisted alone, at the twist of the beam that is not bent; looked at on faces it was seen up to 4 % later."""
    beam = SKIN.replace(scale={"alpha": np.radians(alpha)})
    _, found = followed(beam, [(0.0, 0.12)])
    assert found.answers.contact().words == "tip edge on side edge (k = 1)"
    # tolerance: edges cross where a corner is looked at, 3e-4 measured, on every processor
    assert found.answers.contact().phi == pytest.approx(float(squama.twist(beam, points=3).phi_e), rel=2e-3)


def test_a_corner_that_hardly_presses_hands_over_to_the_tip_edge() -> None:
    shape = law.Shape(1.13, 0.438, 0.362, 0.559, 0.0637, 0.79, 0.216, 0.487)
    one = path.Scale(2.2, shape.beta, shape.lam, shape.alpha, shape.theta0, shape.thickness)
    back = follow_legs(
        one, law.stiffness(shape), 0.0964, np.array(ray((0, 0.033), (0.08, 0.033), (0.02, 0.033), n=120))
    )
    first = back.rows[240:, path.COLUMNS.index("first")]
    assert {6.0, 0.0} <= set(first)
    assert first[-1] == -1

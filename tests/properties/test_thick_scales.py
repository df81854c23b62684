"""What holds for every beam on compliant joints: work and energy, limits, mirror images, ways there and back."""

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import squama
from campaigns import histories
from oracle.barrier import monomials
from squama.contacts import events, increments, path, states
from squama.contacts.path import Path as Way
from squama.contacts.path import Scale
from squama.fe.plate import axes
from squama.joints import law
from squama.joints.factor import MIRROR
from squama.model import elastic_plate as plate

SHAPES = [
    # eta, beta, lam, alpha, theta0, share of the gap, zeta, width, nu, D over K_theta
    (3.0, 0.6, 0.4, 60.0, 15.0, 0.3, 0.3, 1.6, 0.49, 0.05),
    (2.5, 0.8, 0.5, 45.0, 10.0, 0.1, 0.25, 2.0, 0.3, 2.0),
    (4.5, 0.515, 0.333, 46.2, 18.9, 0.35, 0.443, 0.82, 0.455, 0.5),
]


def shape(i: int) -> law.Shape:
    _, beta, lam, alpha, theta0, share, zeta, width, nu, _ = SHAPES[i]
    a, t = math.radians(alpha), math.radians(theta0)
    return law.Shape(width, lam, zeta, beta, share * math.cos(a) * math.sin(t), a, t, nu)


def made(i: int, *, h: float | None = None, D: float | None = None, mu: float = 0.0, sense: int = 1) -> Way:
    eta, bending, at = SHAPES[i][0], SHAPES[i][-1], shape(i)
    beta, lam, a, t, thick, K = at.beta, at.lam, at.alpha, at.theta0, at.thickness, law.stiffness(at)
    K_theta = 1 / np.linalg.inv(K[:6, :6])[4, 4]
    D = bending * K_theta if D is None else D
    return Way.of(Scale(eta, beta, lam, a, t, thick if h is None else h, D, 0.35), K, mu, sense=sense, most=0.5)


def twists(one: Way, n: int = 200, times: float = 2.0) -> np.ndarray:
    return np.linspace(one.contact.phi, times * one.contact.phi, n)[1:]


@pytest.mark.parametrize("i", range(3))
def test_virtual_work_without_friction(i: int) -> None:
    """The torque of the contact's forces is the slope of the energy, by differences of high order."""
    one = made(i)
    h, at = 1e-4, 1.5 * one.contact.phi
    x = at + h * np.arange(-3, 4)
    rows, _ = one.states(x, step=1e-3)
    U = sum(states.energies(one, rows).values())
    slope = (U[6] - 9 * U[5] + 45 * U[4] - 45 * U[2] + 9 * U[1] - U[0]) / (60 * h)
    assert slope == pytest.approx(rows[3, 1], rel=3e-7)


@pytest.mark.parametrize("mu", [0.0, 0.3])
@pytest.mark.parametrize("i", range(3))
def test_energy_is_balanced_there_and_back(i: int, mu: float) -> None:
    one = made(i, mu=mu)
    up = twists(one, 300)
    x = np.concatenate([up, up[::-1][1:], [0.0]])
    rows, end = one.states(x, step=(up[-1] - up[0]) / 300)
    assert end.code == increments.RANGE
    U = sum(states.energies(one, rows).values())
    error = rows[:, 7] - U - rows[:, 6]
    assert np.abs(error).max() < 1e-4 * U.max()
    assert (np.diff(rows[:, 6]) >= 0).all()
    assert rows[-1, 1] == pytest.approx(0.0, abs=1e-12)
    if mu:
        assert rows[-1, 6] > 1e-4 * U.max()


@pytest.mark.slow(but=1)
@pytest.mark.parametrize("seed", range(3))
def test_random_histories(seed: int, capsys: pytest.CaptureFixture[str]) -> None:
    assert histories.trial(seed, size=25) == []
    assert "range end" in capsys.readouterr().out


def test_a_corner_that_comes_in_beside_its_edges_contact_loses_no_work() -> None:
    """It comes in where its gap closes; behind the turn the path jumps, and what is lost there is told."""
    draws = np.random.default_rng([13, 2])
    for _ in range(10):
        given = histories.drawn(draws)
        e = given.path().contact.phi
        far = min(e * draws.uniform(1.3, 3), e + 0.25, 0.5)
        turns = histories.history(draws, e, far)
    one, x = given.path(), histories.along(turns, histories.POINTS)
    found = one.follow(x, (far - e) / 200)
    rows, first = found.rows[0], slice(histories.POINTS + 1)
    came = [event for event in events.events(found) if event.way < far]
    assert [(event.kind, event.contact) for event in came[1:]] == [
        (increments.CHANGE, "TF"), (increments.ENGAGE, "BF"),
    ]  # fmt: skip
    U = sum(states.energies(one, rows).values())
    error = np.abs(rows[:, 7] - U - rows[:, 6] - path.named(rows)["W_snap"]) / U.max()
    assert path.named(rows)["contacts"][first][-1] == 2
    assert error[first].max() < 3e-6
    assert error.max() < 2e-4


def test_what_touches_near_an_edges_end_is_seen_where_it_touches() -> None:
    """Between the places that were looked at it was seen 5 % later, and taken for another pair; by plain vectors."""
    alpha, theta0 = np.radians([20.2, 10.7])
    h, beta, lam = 0.05 * math.cos(alpha) * math.sin(theta0), 0.71, 0.78
    K = law.stiffness(law.Shape(1.79, lam, 0.19, beta, h, alpha, theta0, 0.45))
    one = Way.of(Scale(4.17, beta, lam, alpha, theta0, h), K, 0.2, sense=-1)
    assert one.contact[:3] == (plate.SIDE_D, plate.BASE, 1)
    x = one.contact.x + np.linspace(-2e-2, 2e-2, 4001)

    def least(phi: float) -> float:
        """Height of the side edge over the next scale's face, by motions without contact, in the other sense."""
        held = K[:7, :7] * np.outer(MIRROR[:7], MIRROR[:7])
        q = -np.linalg.solve(held[:6, :6], held[:6, 6]) * phi
        n = axes(-alpha, theta0)
        E, R = Rotation.from_rotvec(q[3:]).as_matrix(), Rotation.from_rotvec([0.0, 0.0, -phi]).as_matrix()
        at = np.column_stack([x, np.full(x.size, -beta), np.full(x.size, -h / 2)])
        there = ((at @ E.T + q[:3]) @ n + [0.0, lam, -1.0]) @ R
        there = ((there - [0.0, lam, 0.0]) @ n.T - q[:3]) @ E
        over = (there[:, 0] > 0) & (np.abs(there[:, 1]) < beta)
        return float(there[over, 2].min()) - h / 2

    assert least(one.contact.phi * (1 - 1e-3)) > 0 > least(one.contact.phi * (1 + 1e-3))
    rows, end = one.states(twists(one, 20, 1.04))
    assert end.code == increments.RANGE
    assert (np.diff(rows[:, 2]) > 0).all()
    assert (rows[:, 1] > states.bare(one.beams)[0, 0, 0] * rows[:, 0]).all()


@pytest.mark.parametrize("i", range(3))
def test_stiffer_plates_become_rigid_and_thinner_ones_thin(i: int) -> None:
    rigid, stiff = made(i, D=math.inf, mu=0.2), made(i, D=1e7, mu=0.2)
    x = twists(rigid, 20)
    np.testing.assert_allclose(stiff.states(x)[0][:, 1], rigid.states(x)[0][:, 1], rtol=1e-5)
    thin, thinner = made(i, h=0.0, mu=0.2, D=math.inf), made(i, h=1e-9, mu=0.2, D=math.inf)
    x = twists(thin, 20)
    np.testing.assert_allclose(thinner.states(x)[0][:, 1], thin.states(x)[0][:, 1], rtol=3e-6)


@pytest.mark.parametrize("h", [0.0, 0.05])
def test_a_joint_that_gives_in_one_motion_only_is_a_hinge(h: float) -> None:
    """Against the closed form of the hinge, thick or thin, without friction: torque from the spring's energy."""
    eta, beta, lam, alpha, theta0, K_theta, rigidity = 3.0, 0.6, 0.4, math.radians(45), math.radians(15), 0.02, 0.05
    K = np.diag([1e6] * 3 + [1e4, K_theta, 1e4] + [rigidity])
    one = Way.of(Scale(eta, beta, lam, alpha, theta0, h), K, 0.0)
    theta = np.linspace(theta0, theta0 + 0.2, 9)[1:]
    c = squama.contact(theta, eta=eta, beta=beta, lam=lam, alpha=alpha, thickness=h)
    phi, rate = c.phi, c.dphi_dtheta
    rows, _ = one.states(phi, step=1e-3)
    np.testing.assert_allclose(states.inclinations(one, rows), theta, rtol=1e-3)
    np.testing.assert_allclose(rows[:, 1] - rigidity * phi, K_theta * (theta - theta0) / rate, rtol=1e-3)


@pytest.mark.parametrize("i", range(3))
def test_the_other_sense_is_the_mirror_image(i: int) -> None:
    """alpha and the twist turned round, and the matrix mirrored, give the same; so does -- of the mirror image."""
    one = made(i, mu=0.2)
    signs = MIRROR
    K = law.stiffness(shape(i)) * np.outer(signs, signs)
    mirrored = Way.of(one.scale._replace(alpha=-one.scale.alpha), K, 0.2, sense=-1, most=0.5)
    assert mirrored.contact == one.contact
    x = twists(one, 20)
    np.testing.assert_allclose(mirrored.states(x)[0], one.states(x)[0], rtol=1e-12)


@pytest.mark.parametrize("mu", [0.1, 0.6])
def test_steps_do_not_matter(mu: float) -> None:
    one = made(1, mu=mu)
    x = twists(one, 6)
    coarse, fine = (one.states(x, step)[0][:, 1] for step in (4e-3, 5e-4))
    np.testing.assert_allclose(coarse, fine, rtol=1e-4)


def test_plates_that_touch_at_rest_and_scales_that_never_meet() -> None:
    eta, beta, lam, alpha, theta0, *_ = SHAPES[0]
    gap = math.cos(math.radians(alpha)) * math.sin(math.radians(theta0))
    K = law.stiffness(shape(0))
    touching = Way.of(Scale(eta, beta, lam, math.radians(alpha), math.radians(theta0), 1.01 * gap), K, 0.2)
    assert touching.contact.first == -2
    assert touching.contact.phi == 0.0
    apart = Way.of(Scale(0.8, 0.3, lam, math.radians(alpha), math.radians(theta0), 0.0), K, 0.2, most=0.1)
    assert apart.contact.first == -1
    rows, end = apart.states(np.array([0.05, 0.1]))
    assert end.code == increments.RANGE
    np.testing.assert_allclose(rows[:, 1], states.bare(apart.beams)[0, 0, 0] * np.array([0.05, 0.1]), rtol=1e-12)


def test_compliances_of_a_plate() -> None:
    """Against converged plate elements of another library (docs/theory/elastic_scales.md, "Elastic plates")."""
    (S,) = plate.compliances(np.array([3.0]), np.array([0.6]), np.array([0.35]))
    tip, side = monomials(np.array([1.0, 2.2 / 3]), np.array([-0.15 / 0.6, -1.0]))
    found = tip @ S @ tip, tip @ S @ side, side @ S @ side
    # tolerance: the modes are up to 1.1 % stiffer than converged elements; their own figures have five digits
    np.testing.assert_allclose(found, (8.2090, 4.9987, 3.5724), rtol=0.012)
    np.testing.assert_allclose(found, (8.1407, 4.9569, 3.5321), rtol=2e-5)
    np.testing.assert_allclose(S, S.T, rtol=1e-6, atol=1e-6 * np.abs(S).max())


def test_stress_of_a_cantilever_under_a_force_at_its_tip() -> None:
    """Beam theory for a long, narrow plate: 6 F l / (2 b h^2) at the root, on average over the width."""
    scale = Scale(3.0, 0.1, 0.4, math.radians(45), math.radians(10), 0.02, 1e-3, 0.0)
    # at the middle of the tip, of all powers those of Y^0 are loaded
    bent = 1e-6 * plate.compliances(*np.array([[3.0], [0.1], [0.0]]))[:, :, ::4].sum(axis=2) / 1e-3
    stress, where = states.stresses(scale, bent)
    assert stress[0] == pytest.approx(6 * 1e-6 * 3.0 / (0.2 * 0.02**2), rel=0.05)
    assert where[0, 0] == 0.0


@pytest.mark.parametrize("D", [math.inf, None])
def test_friction_works_along_the_slip(D: float | None) -> None:
    """dW_fr = mu N dslip there and back; the places on both edges and the angle between these say the slip alone."""
    one = made(1, D=D, mu=0.3)
    e = one.contact.phi
    turned = 2 * e * (1 - np.geomspace(1e-6, 1e-3, 40))
    phi = np.concatenate([np.linspace(0, 2 * e, 401), turned, np.linspace(turned[-1], 1.2 * e, 161)[1:]])
    rows, end = one.states(phi)
    column = path.named(rows)
    assert end.code == increments.RANGE
    force = one.mu * column["N"]
    work = np.cumsum((force[1:] + force[:-1]) / 2 * np.diff(column["slip"]))
    # tolerance: trapezoids between the rows, 2.1e-4 measured on every processor
    np.testing.assert_allclose(work, column["W_fr"][1:], rtol=0, atol=1e-3 * column["W_fr"][-1])
    assert not column["slip"][:200].any()
    # while it sticks nothing slides, though the force changes
    held = np.flatnonzero(column["mode"] == path.STICK)
    assert held.size
    np.testing.assert_array_equal(np.diff(column["slip"][held]), 0.0)
    # and what is told is the torque at the turn
    np.testing.assert_allclose(column["T_slip"][held], column["T"][400], rtol=1e-9)


@pytest.mark.parametrize("mu", [0.0, 0.3])
def test_the_tip_of_a_scale_turns_as_its_corners_say(mu: float) -> None:
    one = made(1, D=None, mu=mu)
    row, _ = one.states(np.array([1.6 * one.contact.phi]))
    bent = path.deflections(row).reshape(6, 4).sum(axis=0)
    corners = [float(bent @ side ** np.arange(4)) for side in (1.0, -1.0)]
    told = states.plate_figures(one.scale, path.deflections(row))
    assert told["scale_twist"][0] == pytest.approx((corners[0] - corners[1]) / (2 * one.scale.beta))
    # without friction a contact slides, too: over the same way as with little
    assert path.COLUMNS[16] == "slip"
    assert row[0, 16] > 0


@pytest.mark.parametrize(("D", "mu"), [(math.inf, 0.0), (math.inf, 0.3), (None, 0.3)])
def test_force_and_moment_on_the_embedded_part(D: float | None, mu: float) -> None:
    """Statics in space: the contact's force where it acts on the tip, its reaction on the side, moments about O."""
    one = made(1, D=D, mu=mu)
    scale, step, at = one.scale, 1e-4, 1.7 * one.contact.phi
    phi = at + step * np.arange(-1, 2)
    rows, _ = one.states(phi, step=step)
    bent = path.deflections(rows).reshape(-1, 6, 4)
    A = axes(scale.alpha, scale.theta0)
    m, j = np.arange(2, 8), np.arange(4)

    def points(i: int) -> list[np.ndarray]:
        """O, the place on the tip, that on the side of the neighbour, and the tangents of both edges."""
        p, s = rows[1, 4:6]
        E = A.T @ Rotation.from_rotvec(rows[i, 12:15]).as_matrix()
        o = np.array([0.0, scale.lam, 0.0]) + A.T @ rows[i, 9:12]
        c, sin = math.cos(phi[i]), math.sin(phi[i])
        R = np.array([[c, sin, 0], [-sin, c, 0], [0, 0, 1.0]])
        y, x = p / scale.beta, s / scale.eta
        tip, across = bent[i].sum(0) @ y**j, bent[i].sum(0) @ (j * y ** np.maximum(j - 1, 0)) / scale.beta
        side, along = x**m @ bent[i] @ (-1.0) ** j, (m * x ** (m - 1)) @ bent[i] @ (-1.0) ** j / scale.eta
        on_tip = o + E @ [scale.eta, p, tip - scale.h / 2]
        on_side = o + E @ [s, -scale.beta, side + scale.h / 2]
        return [o, on_tip, R @ on_side + [0, 0, 1], E @ [0, 1, across], R @ E @ [1, 0, along], on_side, R, E]

    before, now, after = (points(i) for i in range(3))
    n = np.cross(now[4], now[3])
    n /= np.linalg.norm(n)
    slip = (after[1] - before[1]) - (after[2] - before[2])
    slip -= n @ slip * n
    F = rows[1, 2] * (n - mu * slip / np.linalg.norm(slip))
    o, on_tip, _, _, _, on_side, R, E = now
    np.testing.assert_allclose(on_tip, now[2], atol=1e-9)
    back = -R.T @ F
    force, moment = F + back, np.cross(on_tip - o, F) + np.cross(on_side - o, back)
    found = states.on_tab(one, path.motions(rows[1:2]))
    np.testing.assert_allclose(found[0][0], force @ E, rtol=0, atol=2e-4 * np.abs(force).max())
    np.testing.assert_allclose(found[1][0], moment @ E, rtol=0, atol=2e-4 * np.abs(moment).max())
    assert abs(rows[1, 12:15]).max() > 0.01

"""A finite row on compliant joints: against a Lagrangian written out here, the endless beam, the hinge, its energy."""

import json
import math

import numpy as np
import pytest
from scipy.optimize import root
from scipy.spatial.transform import Rotation

import squama
from squama.beam import matrixfile
from squama.cli import main
from squama.contacts import increments, path, row, states
from squama.contacts.path import Path, Scale
from squama.contacts.system import ENDLESS
from squama.contacts.ties import LOOSE
from squama.contacts.touch import FIRST, ONE, OTHER
from squama.curves import compliant
from squama.joints import law
from squama.joints.factor import MIRROR

SHAPES = [
    # eta, beta, lam, alpha, theta0, share of the gap, zeta, width, nu, D over K_theta
    (2.5, 0.8, 0.5, 45.0, 10.0, 0.1, 0.25, 2.0, 0.3, 2.0),
    (4.5, 0.515, 0.333, 46.2, 18.9, 0.35, 0.443, 0.82, 0.455, 0.5),
]
KINDS = {"thick, elastic": {}, "thick, rigid": {"D": math.inf}, "thin, elastic": {"h": 0.0}}
KINDS["thin, rigid"] = KINDS["thick, rigid"] | KINDS["thin, elastic"]
NU = 0.35
PLA = squama.Beam.from_toml("examples/pla_on_vps.toml").replace(hold="bend, twist, lateral bend")
RIGID = PLA.replace(scale={"youngs_modulus": None, "poisson_ratio": None, "strength": None})


def made(i, mu=0.0, **changes):
    eta, beta, lam, alpha, theta0, share, zeta, width, nu, bending = SHAPES[i]
    a, t = math.radians(alpha), math.radians(theta0)
    thick = share * math.cos(a) * math.sin(t)
    K = law.stiffness(law.Shape(width, lam, zeta, beta, thick, a, t, nu))
    D = bending / np.linalg.inv(K[:6, :6])[4, 4]
    given = {"h": thick, "D": D, **changes}
    return Path.of(Scale(eta, beta, lam, a, t, given["h"], given["D"], NU), K, mu, most=0.5)


def named(t):
    """States (points, n) of a row by column."""
    return path.named(t.rows)


def moved(rows):
    return path.motions(rows.reshape(-1, rows.shape[-1]))[:, :6].reshape(*rows.shape[:-1], 6)


def twists(way, times, n=40):
    return np.linspace(way.contact.phi, times * way.contact.phi, n)[1:]


def stored(way, rows):
    """Elastic energy of each scale, E d^3."""
    return sum(states.energies(way, rows.reshape(-1, rows.shape[-1])).values()).reshape(rows.shape[:-1])


# ---- two scales as vectors: the stationary point of energy less the work of the force that closes the gap ---------


def bending_energy(eta, beta, D):
    """Return the stiffness (24, 24) of a plate over X^m Y^n, m = 2..7, n = 0..3, with X = x/eta, Y = y/beta."""
    m, n = (v.ravel() for v in np.meshgrid(np.arange(2, 8), np.arange(4), indexing="ij"))

    def along(p, a, q, b):
        factor = [np.prod([r - i for i in range(k)], axis=0) * np.ones(24) for r, k in ((p, a), (q, b))]
        return np.outer(*factor), (p - a)[:, None] + (q - b)[None, :]

    def times(ax, ay, bx, by):
        fx, ex = along(m, ax, m, bx)
        fy, ey = along(n, ay, n, by)
        over_y = np.where(ey % 2 == 0, 2 / np.where(ey < 0, 1, ey + 1), 0) * (fy != 0)
        whole = fx * fy / (ex + 1) * over_y
        return whole * eta ** (1 - ax - bx) * beta ** (1 - ay - by)

    mixed = times(2, 0, 0, 2)
    return D * (times(2, 0, 2, 0) + times(0, 2, 0, 2) + NU * (mixed + mixed.T) + 2 * (1 - NU) * times(1, 1, 1, 1))


def lagrangian(way, phi, unknown, change):
    """Return U - F . D of two scales; ``change`` (48, 24 a scale) from the unknowns of the plates to their powers."""
    s, K = way.scale, way.beams.K[0, :7, :7]
    q, F, (p, r), b = unknown[:12].reshape(2, 6), unknown[12:15], unknown[15:17], unknown[17:]
    a, t = s.alpha, s.theta0
    x = np.array([-np.sin(a) * np.cos(t), np.sin(t), np.cos(a) * np.cos(t)])
    y = np.array([np.cos(a), 0.0, np.sin(a)])
    axes = np.stack([x, y, np.cross(x, y)])
    bases = np.array([0, s.lam, 0]), np.array([0, s.lam, 0])

    def place(i, xi):
        w = q[i, 3:]
        angle = np.sqrt(w @ w + 1e-300)
        W = np.array([[0, -w[2], w[1]], [w[2], 0, -w[0]], [-w[1], w[0], 0]])
        turned = xi + np.sin(angle) / angle * (W @ xi) + 2 * (np.sin(angle / 2) / angle) ** 2 * (W @ (W @ xi))
        here = bases[i] + axes.T @ (q[i, :3] + turned)
        c, z = np.cos(i * phi), np.sin(i * phi)
        return np.array([c * here[0] + z * here[1], c * here[1] - z * here[0], here[2] + i])

    w1 = w2 = 0.0
    energy = 0.0
    if b.size:
        X = np.concatenate([[(r / s.eta) ** m * (-1.0) ** n for n in range(4)] for m in range(2, 8)])
        w1 = (change @ b[:24]) @ np.tile((p / s.beta) ** np.arange(4), 6)
        w2 = (change @ b[24:]) @ X
        energy = b @ b / 2
    for i in range(2):
        full = np.concatenate([q[i], [phi]])
        energy = energy + full @ K @ full / 2
    apart = place(0, np.array([s.eta, p, w1 - s.h / 2])) - place(1, np.array([r, -s.beta, w2 + s.h / 2]))
    return energy - F @ apart


def slope(f, x):
    h = 1e-30
    return np.array([f(x + 1j * h * e).imag / h for e in np.eye(x.size)])


@pytest.mark.slow(but=1)
@pytest.mark.parametrize("kind", KINDS)
def test_two_scales_without_friction_are_the_stationary_point_of_a_lagrangian(kind):
    way = made(0, **KINDS[kind])
    phi = 1.5 * way.contact.phi
    found = row.track(way, 2, np.array([phi]))
    rows, q, v = found.rows[0], moved(found.rows[0]), {name: column[0] for name, column in named(found).items()}
    places = v["x"][0], v["y"][0]
    change, plates = np.eye(24), np.zeros(0)
    if way.scale.elastic:
        # unknowns in which the plates' energy is half their square
        L = np.linalg.cholesky(bending_energy(way.scale.eta, way.scale.beta, way.scale.D))
        change = np.linalg.inv(L).T
        plates = np.linalg.solve(change, path.deflections(rows).T).T.ravel()
    a, t = way.scale.alpha, way.scale.theta0
    x = np.array([-np.sin(a) * np.cos(t), np.sin(t), np.cos(a) * np.cos(t)])
    y = np.array([np.cos(a), 0.0, np.sin(a)])
    normal = np.stack([x, y, np.cross(x, y)]).T @ Rotation.from_rotvec(q[0, 3:]).as_matrix()[:, 2]
    guess = np.concatenate([q.ravel(), v["N"][0] * normal, places, plates])
    guess *= 1 + 1e-3 * np.cos(np.arange(guess.size))
    solved = root(lambda v: slope(lambda u: lagrangian(way, phi, u, change), v), guess, tol=1e-13).x
    np.testing.assert_allclose(q.ravel(), solved[:12], rtol=0, atol=1e-7 * abs(solved[:12]).max())
    assert v["N"][0] == pytest.approx(np.linalg.norm(solved[12:15]), rel=1e-7)
    assert places == pytest.approx(solved[15:17], rel=1e-7)
    h = 1e-30
    torque = lagrangian(way, phi + 1j * h, solved, change).imag / h
    assert v["torque"].sum() == pytest.approx(torque, rel=1e-8)


@pytest.mark.parametrize("mu", [0.0, 0.3])
@pytest.mark.parametrize("kind", KINDS)
def test_the_middle_of_a_long_row_is_the_endless_beam(kind, mu):
    way = made(0, mu, **KINDS[kind])
    x = twists(way, 1.5)
    one, (endless, _) = row.track(way, 151, x), way.states(x)
    middle, far = {name: v[-1, 75] for name, v in named(one).items()}, path.named(endless[-1])
    assert one.end.code == increments.RANGE
    for name in ("N", "f", "x", "y"):
        assert middle[name] == pytest.approx(far[name], rel=1e-4, abs=1e-12), name
    q = moved(endless[-1:])[0]
    np.testing.assert_allclose(moved(one.rows[-1])[75], q, atol=1e-4 * abs(q).max())
    bent = path.deflections(endless[-1])
    np.testing.assert_allclose(path.deflections(one.rows[-1])[75], bent, atol=1e-4 * abs(bent).max())
    # the ends take the same of every long row
    short = row.track(way, 76, x)
    torque = [named(t)["torque"][-1, 0] for t in (one, short)]
    missing = [n * (1 - T / far["torque"]) for n, T in zip((151, 76), torque, strict=True)]
    assert missing[0] == pytest.approx(missing[1], rel=0.02)
    assert (151 * torque[0] - 76 * torque[1]) / 75 == pytest.approx(far["torque"], rel=1e-4)


@pytest.mark.parametrize("i", range(2))
def test_virtual_work_without_friction(i):
    way, h = made(i), 1e-4
    x = 1.5 * way.contact.phi + h * np.arange(-3, 4)
    t = row.track(way, 5, x, 1e-3)
    U = stored(way, t.rows).sum(axis=1)
    assert (U[6] - 9 * U[5] + 45 * U[4] - 45 * U[2] + 9 * U[1] - U[0]) / (60 * h) == pytest.approx(
        named(t)["torque"][3].sum(), rel=5e-8
    )


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("i", range(2))
def test_energy_is_balanced(i, kind):
    way = made(i, 0.6, **KINDS[kind])
    t = row.track(way, 9, twists(way, 1.8))
    v = named(t)
    U, rubbed, work = (a.sum(axis=1) for a in (stored(way, t.rows), v["W_fr"], v["W"]))
    np.testing.assert_allclose(work, U + rubbed, atol=2e-4 * np.nanmax(U))
    assert rubbed[np.isfinite(rubbed)][-1] > 1e-3 * np.nanmax(U)
    # friction along the slip, and less of it only where a contact sticks
    N, f = v["N"][:, :-1], v["f"][:, :-1]
    assert (f <= 0.6 * N * (1 + 1e-6) + 1e-12).all()


def test_contacts_at_the_pressed_end_stick_and_the_last_scale_lies_down():
    way = made_of(RIGID)
    t = row.track(way, 12, twists(way, 5, 100))
    v = named(t)
    N, f, x = v["N"][:, :-1], v["f"][:, :-1], v["x"]
    sticks = f < way.mu * N * (1 - 1e-6)
    assert sticks[-1].any()
    assert not sticks[-1].all()
    # a contact that sticks stays at its place on the edge
    i = int(np.flatnonzero(sticks[-2] & sticks[-1])[-1])
    assert abs(x[-1, i] - x[-2, i]) < 1e-3 * abs(x[-1, 0] - x[-2, 0])
    theta = np.array([states.inclinations(way, rows) for rows in t.rows])
    down = t.held[:, -1] > 0
    assert down.any()
    np.testing.assert_allclose(theta[down, -1], 0, atol=1e-9)
    assert (theta > -1e-9).all()
    assert (t.held >= 0).all()


@pytest.mark.parametrize("mu", [0.0, 0.3])
def test_a_joint_that_gives_in_one_motion_only_is_a_row_of_hinges(mu):
    given = {"eta": 3, "beta": 0.6, "lam": 0.4, "alpha": "45 deg", "theta0": "15 deg", "youngs_modulus": "1 MPa"}
    beam = squama.Beam.from_ratios(**given, mu=mu, scales=6)
    beam = beam.replace(joint={"stiffness": 0.02 * 1e6 * beam.pitch**3})
    r = squama.row(beam, to="0.2 rad/pitch", joint="hinge", ideal=True, points=60)
    rigid = beam.torsional_rigidity / (1e6 * beam.pitch**4)
    K = np.diag([1e6] * 3 + [1e4, 0.02, 1e4] + [rigid])
    way = Path.of(Scale(3.0, 0.6, 0.4, math.radians(45), math.radians(15), 0.0), K, mu)
    assert way.contact.phi == pytest.approx(float(r.phi_e), rel=1e-3)
    x = r.phi.values[r.phi.values > way.contact.phi]
    t = row.track(way, 6, x)
    theta = np.array([states.inclinations(way, rows) for rows in t.rows])
    np.testing.assert_allclose(theta, r.theta.values[-x.size :], atol=1e-3 * np.ptp(r.theta.values))
    unit = 1e6 * beam.pitch**3
    np.testing.assert_allclose(named(t)["torque"][:, 0] * unit, r["T"].values[-x.size :], rtol=1e-3)
    np.testing.assert_allclose(t.held * unit, r.Q.values[-x.size :], atol=2e-3 * unit * 0.02)
    assert row.decay(way) == pytest.approx(float(r.decay), rel=1e-3)


def test_the_effect_of_an_end_decays_as_said():
    way = made(0, 0.0, **KINDS["thick, rigid"])
    N = named(row.track(way, 80, np.array([1.001 * way.contact.phi])))["N"][0]
    fall = (N[40] - N[1:8]) / (N[40] - N[:7])
    np.testing.assert_allclose(fall, row.decay(way), rtol=0.01)


def test_the_other_sense_is_the_mirror_image():
    """The beam's own matrix, mirrored, with alpha the other way and the other sense of twist."""
    K = np.asarray(compliant.Held.of(PLA).K)
    own = compliant.scale(PLA, ideal=False)
    ways = (
        Path.of(own, K, 0.3, most=0.3),
        Path.of(own._replace(alpha=-own.alpha), K * np.outer(MIRROR, MIRROR), 0.3, sense=-1, most=0.3),
    )
    rows = [row.track(way, 4, twists(way, 1.5, 5)).rows for way in ways]
    np.testing.assert_allclose(rows[1], rows[0], rtol=1e-6, atol=1e-10)


@pytest.mark.parametrize("mu", [0.0, 0.3])
@pytest.mark.parametrize("kind", KINDS)
def test_scales_that_repeat_for_ever_are_one_with_its_images(kind, mu):
    """Five of them do what one does: what happens to all at once is one event."""
    way = made(1, mu, **KINDS[kind])
    x = twists(way, 2.0, 20)
    one, five = (row.track(way, n, x, ends=ENDLESS) for n in (1, 5))
    assert (one.end, 5 * len(one.events)) == (five.end, len(five.events))
    for name in ("torque", "N", "x", "y", "W", "W_fr"):
        expected = np.broadcast_to(named(one)[name], (x.size, 5))
        np.testing.assert_allclose(named(five)[name], expected, rtol=0, atol=1e-7 * abs(expected).max(), err_msg=name)


# ---- the door --------------------------------------------------------------------------------------------------


def test_what_is_said_of_the_answer():
    for beam, options, joint, scales in (
        (PLA, {}, "compliant", "thick, elastic scales"),
        (RIGID, {}, "compliant", "thick, rigid scales"),
        (PLA, {"ideal": True}, "compliant", "thin, rigid scales"),
        (PLA, {"joint": "hinge"}, "hinge", "thin, rigid scales"),
        (PLA, {"joint": "hinge", "ideal": False}, "hinge", "thick, rigid scales"),
    ):
        r = squama.row(beam, scales=3, points=5, to="0.06 rad/pitch", **options)
        assert [r.attrs[name] for name in ("joint", "scales", "law", "load")] == [joint, scales, "edge", "twisting"]
        assert r.theta.dims == ("point", "scale")
    with pytest.raises(squama.InputError, match='joint = "ball"'):
        squama.row(PLA, joint="ball")


def test_a_row_whose_joint_is_not_known_is_on_hinges_and_says_so():
    beam = PLA.replace(scale={"embedded": "20 mm", "thickness": "3 mm"})
    r = squama.row(beam, scales=3, points=5, to="0.06 rad/pitch")
    assert (r.attrs["joint"], r.attrs["scales"]) == ("hinge", "thin, rigid scales")
    assert r.attrs["warnings"].startswith("hinges, as the joint is not known: ")
    with pytest.raises(squama.InputError, match="--joint hinge"):
        squama.row(beam, joint="compliant")


def test_units_and_the_endless_beam_beside():
    r = squama.row(RIGID, scales=8, to="0.1 rad/pitch", points=40)
    e = squama.twist(RIGID, at=r.Phi.values[1:], ends="endless")
    np.testing.assert_allclose(r.T_periodic[1:], e["T"], rtol=1e-4)
    np.testing.assert_allclose(r.theta_periodic[1:], e.theta, rtol=1e-4)
    assert float(r.phi_e) == pytest.approx(float(e.phi_e), rel=1e-9)
    assert float(r.Phi_end) * RIGID.pitch == pytest.approx(0.1)
    work = np.trapezoid(r["T"], r.Phi)
    assert work == pytest.approx(float((r.U_el + r.W_fr)[-1]), rel=2e-3)
    np.testing.assert_allclose(r.U_el, r.U_joint + r.U_plate + r.U_bar, rtol=1e-12)
    np.testing.assert_allclose(r["T"] - r.T_scales, r.attrs["rigidity"] * r.Phi, rtol=1e-9)
    assert np.isnan(r.N[:, -1]).all()
    assert np.isnan(r.s[-1, -1])
    free = r.phi < r.phi_e
    assert (r.N[free, :-1] == 0).all()
    way = made_of(RIGID)
    t = row.track(way, 8, r.phi.values[~free][1:], ends=LOOSE)
    d, E = RIGID.pitch, RIGID.substrate.youngs_modulus
    v = {name: column[-1] for name, column in named(t).items()}
    # tolerance: friction, by other increments; 4e-6 on every processor
    np.testing.assert_allclose(r.N.values[-1, :-1], v["N"][:-1] * E * d**2, rtol=5e-5)
    np.testing.assert_allclose(r.s.values[-1], v["y"] * d, rtol=5e-5)
    np.testing.assert_allclose(r.p.values[-1], v["x"] * d, rtol=5e-5)


def made_of(beam):
    held = compliant.Held.of(beam)
    return Path.of(compliant.scale(beam, ideal=False), held.K, beam.friction.mu, most=0.3, **held.bar)


def test_stress_and_deflection_are_those_of_the_endless_beam_in_the_middle():
    r = squama.row(PLA, scales=41, to="0.07 rad/pitch", ends="equal").isel(point=-1)
    e = squama.twist(PLA, at=[float(r.Phi)], ends="endless").isel(point=0)
    for name in ("stress", "deflection", "strain", "pull_out", "N", "theta"):
        assert float(r[name][20]) == pytest.approx(float(e[name]), rel=6e-3), name
    # the first scale is pressed by none and bends up, the last rests on none and bends down
    assert float(r.deflection[0]) > float(r.deflection[20]) > 0 > float(r.deflection[-1])


@pytest.mark.slow
def test_where_a_row_ends():
    r = squama.row(PLA, scales=5, to="0.2 rad/pitch")
    # another contact comes in, and the row goes on
    assert r.end == "range end"
    assert r.other_contact.item().startswith("side edge of scale 5 on the face of scale 4 (k = 1) at 4.8")
    assert int(r.scale_end) == 4
    assert float(r.phi[-1]) == float(r.phi_end) == pytest.approx(0.2)
    np.testing.assert_allclose(np.trapezoid(r["T"], r.Phi), (r.U_el + r.W_fr)[-1], rtol=2e-3)
    asked = squama.row(PLA, scales=5, to="0.05 rad/pitch", points=5)
    assert (asked.end.item(), int(asked.scale_end)) == ("range end", 0)
    before = squama.row(PLA, scales=5, to="0.02 rad/pitch", points=5)
    assert before.end == squama.twist(PLA, to="0.02 rad/pitch", points=5).end
    assert (before.N[:, :-1] == 0).all()
    far = squama.row(RIGID, scales=3, points=40)
    assert float(far.phi_end) <= 0.3
    thick = RIGID.replace(scale={"thickness": "3 mm"})
    K = compliant.Held.of(RIGID).K[:7, :7]
    thick = thick.replace(joint={"matrix": matrixfile.stored(thick, K)})
    touching = squama.row(thick, scales=3, points=5)
    assert (touching.end, float(touching.phi_end)) == ("touching at rest", 0.0)
    long = squama.Beam.from_ratios(eta=0.8, beta=0.3, mu=0.2, scales=3)
    apart = squama.row(long, to="0.05 rad/pitch", points=5)
    assert apart.end == "no engagement"
    assert math.isinf(float(apart.phi_end))
    assert math.isnan(float(apart.decay))


def test_a_contact_that_leaves_its_edge_is_an_event_there():
    """Contacts move along the tip edge, the first one farthest: where it comes to the corner the row jumps."""
    way = made(0, 0.0, **KINDS["thin, rigid"])
    way = Path.of(way.scale._replace(alpha=1.05, eta=2.8, beta=0.456), way.beams.K[0], 0.0)
    t = row.track(way, 4, twists(way, 8, 200))
    phi = t.events[t.events[:, 0] == increments.SNAP, 1][0]
    assert way.contact.phi < phi < 8 * way.contact.phi
    # an equilibrium that a snap leads to is looked for 1e-7 further on
    v = named(row.track(way, 4, np.array([phi - 2e-7])))
    assert v["x"][0, 0] == pytest.approx(way.scale.beta, abs=1e-5)
    assert (v["x"][0, :3] < way.scale.beta).all()


@pytest.mark.parametrize(("name", "mu"), [("thin, rigid", 0.0), ("thin, rigid", 0.1), ("thin, elastic", 0.1)])
def test_scales_slide_off_one_by_one(name, mu):
    """Each falls from the edge of the next one onto its own side edge, which then bears; what is lost is told."""
    way = made(0, mu, **KINDS[name])
    way = Path.of(way.scale._replace(alpha=1.05, eta=2.8, beta=0.456), way.beams.K[0], mu)
    t = row.track(way, 4, twists(way, 4.5, 100))
    assert t.end.code == increments.RANGE
    snaps = t.events[t.events[:, 0] == increments.SNAP]
    assert sorted(snaps[:, 6 + FIRST]) == [0, 1, 2]
    # the tip edge was on the side edge of the next scale, and one side edge is on the other
    assert (snaps[:, 6 + ONE : 6 + OTHER + 1] == [2, 1]).all()
    v = named(t)
    U, W, rubbed, lost = (v[name].sum(axis=1) for name in ("energy", "W", "W_fr", "W_snap"))
    # tolerance: work by increments, relative to the largest energy
    np.testing.assert_allclose(W - rubbed - lost, U, atol=1e-5 * U.max())
    assert lost[-1] > 1e-3 * U.max()
    assert (v["N"][-1, :3] > 0).all()


def test_the_command(tmp_path, capsys):
    file = tmp_path / "beam.toml"
    PLA.to_toml(file)
    outputs = [str(tmp_path / name) for name in ("a.csv", "a.nc", "a.png")]
    flags = ["--scales", "4", "--to", "0.06 rad/pitch", "--points", "20"]
    assert (
        main(["row", str(file), *flags, "--csv", outputs[0], "--netcdf", outputs[1], "--plot", outputs[2], "--full"])
        == 0
    )
    said = capsys.readouterr().out
    assert "six motions, by the law of the joint" in said
    assert "thick, elastic scales" in said
    assert "largest stress in a scale  " in said
    again, expected = squama.read(outputs[1]), squama.row(PLA, scales=4, to="0.06 rad/pitch", points=20)
    np.testing.assert_array_equal(again.stress, expected.stress)
    np.testing.assert_array_equal(squama.read(outputs[0]).stress.values, expected.stress.values)
    for flag, joint, scales in (("--ideal", "compliant", "thin, rigid"), ("--joint=hinge", "hinge", "thin, rigid")):
        assert main(["row", str(file), *flags, flag, "--json"]) == 0
        record = json.loads(capsys.readouterr().out)
        assert (record["joint"], record["scales"]) == (joint, f"{scales} scales")
    assert main(["row", str(file), "--joint", "ball"]) == 2
    assert "--joint" in capsys.readouterr().err

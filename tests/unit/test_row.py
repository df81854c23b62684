"""A finite row: against vectors written out here, against the endless beam, and where it must not depend on the way."""

import numpy as np
import pytest
from scipy.integrate import cumulative_simpson
from scipy.optimize import fsolve

import squama
from squama.errors import InputError

BEAM = squama.Beam.from_ratios(eta=3, beta=0.6, lam=0.32, zeta=0.18, slenderness=45)  # the paper's Fig. 6b
WIDE = squama.Beam.from_ratios()  # of its Fig. 6a
# both have alpha = 45 deg, where sine and cosine are one number
SLANTED = squama.Beam.from_ratios(eta=3, beta=0.6, lam=0.32, zeta=0.18, slenderness=45, alpha="30 deg")
K, D = BEAM.joint_stiffness, BEAM.pitch


def hinged(beam, **options):
    return squama.row(beam, joint="hinge", **options)


# ---- plates as vectors, in pitches and K_theta; nothing of the package's algebra ----------------------------------


def turned(v, angle):
    c, s = np.cos(angle), np.sin(angle)
    return np.stack([c * v[0] + s * v[1], c * v[1] - s * v[0], v[2]])


def plate(beam, i, theta, phi):
    """Base midpoint and axes (up the scale, along the width) of scale i."""
    a = beam.scale.alpha
    x = np.array([-np.sin(a) * np.cos(theta), np.sin(theta), np.cos(a) * np.cos(theta)])
    y = np.array([np.cos(a), 0.0, np.sin(a)])
    o = turned(np.array([0.0, beam.lam, 0.0]), i * phi) + np.array([0, 0, i])
    return o, turned(x, i * phi), turned(y, i * phi)


def meeting(beam, i, thetas, phi):
    """Place of contact i, unit normal that lifts scale i, gap, places along the two edges."""
    o1, x1, y1 = plate(beam, i, thetas[i], phi)
    o2, x2, y2 = plate(beam, i + 1, thetas[i + 1], phi)
    tip, corner = o1 + beam.eta * x1, o2 - beam.beta * y2
    n = np.cross(x2, y1)
    n /= np.linalg.norm(n)
    # tip + p y1 - corner - s x2 = gap n
    p, s, gap = np.linalg.solve(np.stack([y1, -x2, -n]).T, corner - tip)
    return tip + p * y1, n, gap, p, s


def slip(beam, i, thetas, rates, phi):
    """Velocity of scale i relative to scale i + 1 at contact i, per unit of phi, by differences of moving points."""
    _, _, _, p, s = meeting(beam, i, thetas, phi)
    h = 1e-5

    def apart(e):
        o1, x1, y1 = plate(beam, i, thetas[i] + e * rates[i], phi + e)
        o2, x2, y2 = plate(beam, i + 1, thetas[i + 1] + e * rates[i + 1], phi + e)
        # the frame of scale i: what both do together is no slip
        return turned(o1 + beam.eta * x1 + p * y1 - o2 + beam.beta * y2 - s * x2, -i * (phi + e))

    return turned((apart(h) - apart(-h)) / (2 * h), i * phi)


def forces_on_row(beam, thetas, rates, phi, N, mu):
    """Moments of the contacts about the hinges (lifting is positive) and torque of all contacts per unit of phi."""
    n = len(thetas)
    lift, torque = np.zeros(n), 0.0
    for i in range(n - 1):
        P, normal, gap, _, _ = meeting(beam, i, thetas, phi)
        assert abs(gap) < 1e-9
        v = slip(beam, i, thetas, rates, phi)
        force = N[i] * (normal - mu * v / np.linalg.norm(v))
        for j, f in ((i, force), (i + 1, -force)):
            o, _, y = plate(beam, j, thetas[j], phi)
            lift[j] -= np.cross(P - o, f) @ y
            # scale j turns clockwise by j phi about the axis; the hand that turns it works against the contact
            torque += j * np.cross(P, f)[2]
    return lift, torque


@pytest.mark.parametrize(
    ("beam", "scales", "mu", "to"),
    [(BEAM, 5, 0.4, 0.2), (WIDE, 7, 0.0, 0.1), (WIDE, 4, 0.3, 0.12), (SLANTED, 4, 0.3, 0.25)],
)
def test_every_scale_is_in_balance_and_the_torque_is_that_of_the_forces(beam, scales, mu, to):
    r = hinged(beam, scales=scales, mu=mu, to=f"{to} rad/pitch", points=400)
    phi, theta = r.phi.values, r.theta.values
    stiffness, d = beam.joint_stiffness, beam.pitch
    touching = np.flatnonzero(phi > 1.01 * float(r.phi_e))
    for m in touching[[len(touching) // 5, len(touching) // 2, 4 * len(touching) // 5, -2]]:
        rates = (theta[m + 1] - theta[m - 1]) / (phi[m + 1] - phi[m - 1])
        N = r.N.values[m, :-1] * d / stiffness
        lift, torque = forces_on_row(beam, theta[m], rates, phi[m], N, mu)
        held = r.Q.values[m] / stiffness
        assert theta[m] - theta[0] == pytest.approx(lift + held, abs=2e-4 * N.max())
        assert r.T_scales.values[m] * scales / stiffness == pytest.approx(torque, rel=1e-4)
        p, s = np.array([meeting(beam, i, theta[m], phi[m])[3:] for i in range(scales - 1)]).T * d
        np.testing.assert_allclose(r.p.values[m, :-1], p, atol=1e-9)
        np.testing.assert_allclose(r.s.values[m, :-1], s, atol=1e-9)


def test_the_middle_of_a_long_row_is_the_endless_beam():
    for beam in (BEAM, WIDE):
        r = hinged(beam, scales=241, mu=0.5, to="0.16 rad/pitch")
        middle = r.isel(point=-1, scale=120)
        ratios = {k: v for k, v in beam.ratios.items() if k != "theta0"}
        assert float(squama.contact(middle.theta, **ratios).phi) == pytest.approx(0.16, abs=1e-9)
        f = squama.forces(middle.theta, theta0=beam.scale.theta0, mu=0.5, **ratios)
        # tolerance: slips by differences of the increments of 100 points, 8e-7 on every processor
        assert float(middle.N * beam.scale.length / beam.joint_stiffness) == pytest.approx(float(f.normal), rel=3e-5)
        assert float(middle.theta) == pytest.approx(float(middle.theta_periodic), abs=1e-9)


def test_ends_are_felt_by_three_quarters_per_scale():
    r = hinged(BEAM, scales=61, mu=0, to="0.062 rad/pitch").isel(point=-1)
    fall = np.diff(r.N.values[:8]) / (r.N.values[30] - r.N.values[:7])
    # tolerance: the figure has two decimals
    assert float(r.decay) == pytest.approx(0.77, abs=0.01)
    np.testing.assert_allclose(1 - fall[:6], float(r.decay), atol=0.01)
    last = r.theta.values[-8:] - r.theta.values[30]
    np.testing.assert_allclose(last[:-1] / last[1:], float(r.decay), atol=0.01)


def test_a_row_comes_nearer_to_the_endless_beam():
    torques = [
        float(hinged(BEAM, scales=n, mu=0.2, to="0.1 rad/pitch").isel(point=-1)["T"]) for n in (2, 5, 12, 25, 200)
    ]
    endless = float(hinged(BEAM, scales=2, mu=0.2, to="0.1 rad/pitch").isel(point=-1).T_periodic)
    missing = 1 - np.array(torques) / endless
    assert (np.diff(missing) < 0).all()
    assert missing[0] > 0.1
    # what the two ends take is the same in every long row
    assert missing[-1] * 200 == pytest.approx(missing[-2] * 25, rel=0.2)


def test_two_scales_without_friction_by_hand():
    r = hinged(BEAM, scales=2, mu=0, to="0.25 rad/pitch", points=30)

    def balance(unknown, phi):
        thetas, N = unknown[:2], unknown[2]
        P, n, gap, _, _ = meeting(BEAM, 0, thetas, phi)
        out = [gap]
        for j, sign in ((0, 1), (1, -1)):
            o, _, y = plate(BEAM, j, thetas[j], phi)
            out.append(thetas[j] - BEAM.scale.theta0 + sign * N * np.cross(P - o, n) @ y)
        return out

    for m in (10, 20, 29):
        x = fsolve(balance, [0.2, 0.15, 0.01], args=(float(r.phi[m]),), xtol=1e-13)
        np.testing.assert_allclose(r.theta.values[m], x[:2], rtol=1e-9)
        assert float(r.N[m, 0]) * D / K == pytest.approx(x[2], rel=1e-9)


def test_two_scales_with_friction_by_hand():
    """Friction along the slip of each step, backward differences, extrapolated to steps of no size."""
    mu, to = 0.5, 0.2
    r = hinged(BEAM, scales=2, mu=mu, to=f"{to} rad/pitch", points=60)

    def levers(phi, thetas, rates):
        P, n, _, _, _ = meeting(BEAM, 0, thetas, phi)
        v = slip(BEAM, 0, thetas, rates, phi)
        force = n - mu * v / np.linalg.norm(v)
        bases = [plate(BEAM, j, thetas[j], phi) for j in (0, 1)]
        return [-sign * np.cross(P - o, force) @ y for (o, _, y), sign in zip(bases, (1, -1), strict=True)]

    def run(steps):
        theta0 = np.full(2, BEAM.scale.theta0)
        old, rates = theta0, np.array([0.4, -0.4])
        phis = np.linspace(float(r.phi_e), to, steps + 1)
        h = phis[1] - phis[0]
        for phi in phis[1:]:

            def wrong(x, phi=phi, old=old):
                a, b = levers(phi, x, (x - old) / h)
                return [meeting(BEAM, 0, x, phi)[2], (x[0] - theta0[0]) * b - (x[1] - theta0[1]) * a]

            new = fsolve(wrong, old + h * rates, xtol=1e-12)
            old, rates = new, (new - old) / h
        return old

    rough, fine = run(20), run(40)
    np.testing.assert_allclose(r.theta.values[-1], 2 * fine - rough, rtol=1e-5)
    # the extrapolation is what agrees: friction has been felt
    bare = hinged(BEAM, scales=2, mu=0, to=f"{to} rad/pitch")
    assert np.abs(bare.theta.values[-1] - r.theta.values[-1]).max() > 1e-4


def test_without_friction_the_way_does_not_matter():
    fine = hinged(BEAM, scales=9, mu=0, to="0.2 rad/pitch", points=300).isel(point=-1)
    coarse = hinged(BEAM, scales=9, mu=0, to="0.2 rad/pitch", points=3).isel(point=-1)
    np.testing.assert_allclose(coarse.theta, fine.theta, rtol=1e-9)
    assert float(coarse["T"]) == pytest.approx(float(fine["T"]), rel=1e-9)


@pytest.mark.parametrize("scales", [2, 6, 25])
def test_the_work_of_the_torque_is_stored_or_rubbed_away(scales):
    r = hinged(BEAM, scales=scales, mu=0.4, to="0.22 rad/pitch", points=300)
    work = cumulative_simpson(r["T"].values, x=r.Phi.values, initial=0)
    spent = (r.U_el + r.W_fr).values
    np.testing.assert_allclose(work[50:], spent[50:], rtol=1.2e-3)
    assert float(r.W_fr[-1]) > (0.002 if scales == 2 else 0.02) * spent[-1]
    assert float(r.RED[-1]) == pytest.approx(float(r.W_fr[-1] / spent[-1]))


def test_the_last_scale_lies_down_and_is_held():
    r = hinged(BEAM, scales=25, mu=0.2, to="0.2 rad/pitch")
    last = r.isel(scale=-1)
    down = abs(last.theta.values) < 1e-12
    assert down.any()
    assert (np.diff(down.astype(int)) >= 0).all()
    assert (last.Q.values[down] >= 0).all()
    assert (r.Q.values[:, :-1] == 0).all()
    assert (r.theta.values[:, 0] >= r.theta.values[:, 12] - 1e-12).all()


@pytest.mark.slow
def test_where_a_row_ends():
    off = hinged(BEAM, scales=25, mu=0.2, to="0.5 rad/pitch", points=200)
    assert off.end == "side entry"
    # at .267579 the contact of the first scale, on which none presses, has run to the end of its tip edge: it snaps
    last = int(np.flatnonzero(off.phi < 0.267176)[-1])
    # tolerance: of 200 points the last one before, 0.5 % measured, on every processor
    assert float(np.abs(off.p[last, 0])) == pytest.approx(BEAM.beta * D, rel=1e-2)
    assert float(off.W_snap[last]) == 0
    assert (off.W_snap[off.phi > 0.267579].dropna("point") > 0).all()
    assert 0.2676 < float(off.phi_end) < 0.28
    assert float(off.phi[-1]) == pytest.approx(float(off.phi_end), rel=3e-4)
    before = hinged(BEAM, scales=5, mu=0.2, to="0.05 rad/pitch")
    assert before.end == "range end"
    np.testing.assert_allclose(before.theta, before.theta[0, 0], rtol=1e-15)
    mirrored = hinged(BEAM, scales=5, mu=0.2, to="0.1 rad/pitch", sense="-")
    assert float(mirrored.T_scales.max()) == 0
    # scales that touch by other edges only
    touch = float(squama.twist(WIDE, mu=0.2, sense="-", joint="hinge").phi_touch)
    for to, other, scale in ((0.2, "", 0), (0.5, "side edge on base edge (k = 1) at 22.2 deg per pitch", 1)):
        r = hinged(WIDE, scales=5, mu=0.2, to=f"{to} rad/pitch", sense="-")
        assert (r.other_contact, r.scale_end, r.end) == (other, scale, "range end")
        assert float(r.phi_e) == pytest.approx(touch)


def test_a_row_goes_on_behind_a_contact_of_other_features():
    """The torque without friction is the slope of the energy, through where the last scale meets a face."""
    r = hinged(WIDE, scales=7, mu=0, to="0.2 rad/pitch", points=400)
    assert r.end == "range end"
    assert r.other_contact == "corner D of scale 7 on the face of scale 6 (k = 1) at 6.11 deg per pitch"
    assert r.scale_end == 6
    work = cumulative_simpson(r["T"].values, x=r.Phi.values, initial=0)
    # tolerance: Simpson's rule over the kinks, 2e-6 on every processor
    np.testing.assert_allclose(work[30:], r.U_el[30:], rtol=1e-4)
    assert float(r.N[-1, 5]) > 0


def test_the_stop_that_is_not_given_is_the_cut_off_of_the_endless_beam():
    r = hinged(BEAM, scales=5, mu=0.2)
    assert float(r.phi_end) == pytest.approx(float(squama.twist(BEAM, mu=0.2, joint="hinge").Phi_c) * D)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"scales": 1}, "scales = 1: must be a whole number from 2 to 2000"),
        ({"scales": 2.5}, "scales = 2.5"),
        ({"mu": -1}, "mu = -1: must be 0 or more"),
        ({"mu": None}, "mu: is not given"),
        ({"to": 0}, "must be above 0"),
        ({"points": 2}, "points = 2"),
        ({"sense": "x"}, "sense"),
    ],
)
def test_bad_arguments(arguments, words):
    with pytest.raises(InputError, match=words):
        hinged(BEAM, **{"mu": 0.2, **arguments})


def test_the_command(tmp_path, monkeypatch, capsys):
    import json

    from squama.cli import main

    monkeypatch.chdir(tmp_path)
    (tmp_path / "beam.toml").write_text(BEAM.to_toml())
    arguments = ["row", "beam.toml", "--joint", "hinge", "--scales", "6", "--mu", "0.2", "--to", "0.2 rad/pitch"]
    assert main([*arguments, "--plot", "row.png", "--csv", "row.csv", "--netcdf", "row.nc"]) == 0
    said = capsys.readouterr().out
    assert said.startswith("beam.toml: 6 scales take ")
    assert "wrote row.png" in said
    assert (tmp_path / "row.png").stat().st_size > 10_000
    expected = hinged(BEAM, scales=6, mu=0.2, to="0.2 rad/pitch")
    np.testing.assert_array_equal(squama.read("row.nc").theta, expected.theta)
    table = squama.read("row.csv")
    np.testing.assert_array_equal(table["T"], expected["T"])
    np.testing.assert_array_equal(table.N.values, expected.N.values)
    assert main([*arguments, "--json"]) == 0
    record = json.loads(capsys.readouterr().out)
    np.testing.assert_allclose(record["each"]["theta"], expected.theta)
    assert record["figures"]["end"] == "range end"


@pytest.mark.parametrize(
    ("flags", "words"),
    [
        (["--scales", "1"], "--scales"),
        (["--scales", "2.5"], "whole number"),
        (["--to", "0.2 rad"], "--to"),
        (["--to", "-1 rad/m"], "--to"),
        (["--sense", "left"], "--sense"),
        (["--csv", "nowhere/row.csv"], "nowhere"),
        (["--plot", "row.gif"], "row.gif"),
    ],
)
def test_bad_flags(flags, words, tmp_path, monkeypatch, capsys):
    from squama.cli import main

    monkeypatch.chdir(tmp_path)
    (tmp_path / "beam.toml").write_text(BEAM.to_toml())
    assert main(["row", "beam.toml", "--mu", "0.2", *flags]) == 2
    said = capsys.readouterr().err
    assert words in said
    assert said.startswith("squama: error: ")
    assert [p.name for p in tmp_path.iterdir()] == ["beam.toml"]


# wide scales meet with one contact more than there are hinges
@pytest.mark.slow(but=1)
@pytest.mark.parametrize("mu", [0.0, 0.3])
def test_the_end_of_a_row_does_not_depend_on_its_points(mu):
    few, many = (hinged(WIDE, scales=25, mu=mu, to="1 rad/pitch", points=n) for n in (40, 900))
    assert few.end.item() == many.end.item() == "no equilibrium"
    # tolerance: what steps of 40 and of 900 points leave, 1e-9, on every processor
    assert float(few.phi_end) == pytest.approx(float(many.phi_end), abs=1e-6)


def test_the_endless_beam_is_there_to_its_end() -> None:
    # its curve ends without a lock: the row's last twist is that end but for rounding
    beam = squama.Beam.from_ratios(
        eta=5.803202646762443,
        beta=0.7115620947478247,
        lam=0.71883776566386,
        alpha=0.9827049779018376,
        theta0=0.15241222480083894,
    )
    r = hinged(beam, scales=8, mu=0, points=30)
    assert np.isfinite(r.T_periodic).all()
    assert np.isfinite(r.theta_periodic).all()

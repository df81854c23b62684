"""Cycles on compliant joints: as a hinge against the closed form, energies, senses, partial loops, jamming."""

import json

import numpy as np
import pytest
from fig6b import BEAM, PLAIN, K, held

import squama
from squama.cli import main
from squama.contacts import increments, path
from squama.errors import InputError
from squama.plot import cycle_figure

FAR = {"beam": squama.Beam.from_toml("examples/pla_on_vps.toml").replace(scales=None), "ideal": False}


def stiff(beam):
    """All motions but the lift are blocked by stiff springs; K_theta and rigidity are those of the hinged beam."""
    unit = beam.substrate.youngs_modulus * beam.pitch**3
    k, bar = beam.joint_stiffness / unit, beam.torsional_rigidity / beam.pitch / unit
    plain = beam.replace(joint={"stiffness": None, "inclusion_factor": None})
    return held(plain, np.diag([3e3 * k, 3e3 * k, 3e3 * k, 3e3 * k, k, 3e3 * k, bar]))


def cycle(twist, beam=BEAM, **options):
    return squama.cycle(beam, twist, **{"points": 20, "ideal": True, **options})


def branch(c, leg, *names):
    return c.isel(point=np.flatnonzero((c.leg.values == leg) & np.isin(c.branch.values, names)))


def at(c, hinge_leg, values, name):
    order = np.argsort(hinge_leg.phi.values)
    return np.interp(values, hinge_leg.phi.values[order], hinge_leg[name].values[order])


@pytest.mark.parametrize("mu", [0.2, 0.5])
def test_a_stiff_joint_cycles_as_the_hinge(mu):
    history = "0, 0.2, 0.12, 0.18, 0 rad/pitch"
    ours, hinge = cycle(history, stiff(PLAIN), mu=mu), squama.cycle(PLAIN, history, mu=mu, points=600, joint="hinge")
    scale = float(abs(hinge.T_scales).max())
    for leg, name in ((1, "loading"), (2, "unloading"), (3, "loading"), (4, "unloading")):
        one = branch(ours, leg, name)
        # (the springs that block take up the friction that turns round)
        one = one.isel(point=(one.phi.values > 0.06) & (abs(one.phi.values - float(one.phi[0])) > 5e-3))
        same = branch(hinge, leg, name, "stick")
        for v, tolerance in (("T_scales", 1e-2 * scale), ("theta", 2e-3), ("W_fr", 1e-2 * float(hinge.W_fr[-1]))):
            # tolerance: the joint is stiff, not a hinge: up to 0.7 %, on every processor
            np.testing.assert_allclose(one[v], at(hinge, same, one.phi.values, v), atol=tolerance, err_msg=f"{leg} {v}")
        f, N = (at(hinge, same, one.phi.values, v) for v in ("f", "N"))
        np.testing.assert_allclose(one.f, f, atol=0.01 * abs(f).max())
        np.testing.assert_allclose(one.N, N, atol=0.01 * N.max())
    assert float(ours.phi_e[0]) == pytest.approx(float(hinge.phi_e[0]), rel=1e-2)
    np.testing.assert_allclose(ours.phi_base, hinge.phi_base)
    np.testing.assert_allclose(ours.phi_top, hinge.phi_top)
    for name, tolerance in (("W_d", 0.01), ("U_max", 0.005), ("zeta_eq", 0.015), ("K_sec", 0.01)):
        np.testing.assert_allclose(ours[name], hinge[name], rtol=tolerance, err_msg=name)
    assert ours.sizes["loop"] == 2
    # the friction turns round within a twist that the blocked motions need; part of it slides already
    down = (branch(c, 2, "stick", "unloading") for c in (ours, hinge))
    one, other = (float(np.interp(0.195, c.phi[::-1], c["T"][::-1])) for c in down)
    assert one == pytest.approx(other, rel=0.01)


def test_a_stiff_joint_drops_its_torque():
    drop = float(cycle("0.2 rad/pitch", stiff(PLAIN)).T_drop[0])
    hinge = float(squama.cycle(PLAIN, "0.2 rad/pitch", joint="hinge").T_drop[0])
    assert 0 < drop < hinge


def test_a_stiff_joint_stays_twisted_where_the_hinge_does():
    beam = squama.Beam.from_ratios(alpha="20 deg", youngs_modulus="2 MPa", stiffness="20 N m", inclusion_factor=1)
    for top in ("0.3 rad/pitch", "0.55 rad/pitch"):
        hinge, ours = squama.cycle(beam, top, mu=0.5, joint="hinge"), cycle(top, stiff(beam), mu=0.5)
        assert float(ours.phi_residual[0]) == pytest.approx(float(hinge.phi_residual[0]), abs=0.02)
    assert float(ours.phi_residual[0]) > 0.4


@pytest.mark.parametrize("ideal", [True, False])
@pytest.mark.parametrize("E", [None, "1e15 Pa"])
def test_the_loops_area_is_the_frictional_work(ideal, E):
    beam = BEAM.replace(scale={"youngs_modulus": E}, substrate={"youngs_modulus": "25 MPa"})
    c = cycle("0.2 rad/pitch", beam, ideal=ideal)
    assert c.W_d[0] == c.W_fr[-1]
    assert abs(float(c.energy_error)) < 3e-4


def test_soft_scales_come_back():
    c = cycle("0.2 rad/pitch", BEAM.replace(scale={"youngs_modulus": "1e15 Pa"}), ideal=False)
    assert abs(float(c.energy_error)) < 1e-4


def test_partial_loops_share_the_work():
    c = cycle("0, 0.2, 0.1, 0.15, 0 rad/pitch", points=100)
    # by the points of the result alone
    # tolerance: trapezoids between the points, 0.7 %, on every processor
    assert np.trapezoid(c["T"], c.Phi) == pytest.approx(float(c.W_fr[-1]), rel=1e-2)
    assert float(c.W_d.sum()) == pytest.approx(float(c.W_fr[-1]), rel=1e-12)
    np.testing.assert_allclose([c.phi_base, c.phi_top], [[0.1, 0], [0.15, 0.2]])
    inner = c.isel(point=np.flatnonzero((c.leg.values == 3) | ((c.leg.values == 4) & (c.phi.values >= 0.1))))
    assert float(c.W_d[0]) == pytest.approx(float(inner.W_fr[-1] - c.W_fr.values[c.leg.values == 2][-1]), rel=1e-9)
    assert abs(float(c.energy_error)) < 3e-3


def test_loading_is_the_curve_of_twist():
    c = branch(cycle("0.2 rad/pitch"), 1, "loading")
    r = squama.twist(BEAM, ideal=True, at=c.Phi.values)
    for name in ("T", "theta", "N", "f", "U_el", "T_scales", "s", "p", "w_X", "u_Z"):
        np.testing.assert_allclose(c[name], r[name], atol=3e-3 * float(abs(r[name]).max()), err_msg=name)
    np.testing.assert_allclose(c.W_fr[-1], r.W_fr[-1], rtol=3e-3)
    np.testing.assert_allclose(c.K_t[5:-1], np.gradient(r["T"], r.Phi)[5:-1], rtol=0.02)


def test_a_reversal():
    c = cycle("0.2 rad/pitch")
    stick = np.flatnonzero(c.branch.values == "stick")
    # where it slides again
    assert stick.size == 1
    turn = int(stick[0]) - 1
    assert float(c.phi[turn]) == 0.2
    assert c.branch.values[turn : turn + 3].tolist() == ["loading", "stick", "unloading"]
    # it holds on until the friction has come up again, within a thousandth of a radian
    assert 1e-6 < 0.2 - float(c.phi[stick[0]]) < 1e-3
    assert float(c["T"][turn] - c["T"][stick[0]]) == pytest.approx(float(c.T_drop[0]), rel=1e-12)
    rubbed = float(c.W_fr[stick[0]] - c.W_fr[turn])
    assert 0 <= rubbed < 1e-3 * float(c.W_fr[-1])
    mu = (c.f / c.N).values[turn : stick[0] + 1]
    assert mu == pytest.approx([0.2, -0.2], rel=1e-5)
    # then it slides back under all of its friction
    back = branch(c, 2, "unloading")
    np.testing.assert_allclose(back.f, -0.2 * back.N, rtol=1e-5)
    assert (c.f.values[c.leg.values == 1] >= 0).all()
    assert (np.diff(c.W_fr) >= -1e-12 * float(c.W_fr[-1])).all()


@pytest.mark.parametrize(
    ("load", "joint"), [("twisting", None), ("bending", None), ("twisting", "hinge"), ("bending", "hinge")]
)
def test_the_points_are_those_asked_and_enclose_the_work(load, joint):
    skin = squama.Beam.from_toml("examples/stiff_skin.toml").replace(scales=None)
    c = squama.cycle(skin, "0.11 rad/pitch", load=load, joint=joint)
    angle, x, torque = ("phi", c.Phi, c["T"]) if load == "twisting" else ("psi", c.kappa, c.M)
    # tolerance: what chords leave out of so many points is promised to be below a thousandth; it is 4e-4 and less
    assert np.trapezoid(torque, x) == pytest.approx(float(c.W_d.sum()), rel=1e-3)
    engaged = float(c[f"{angle}_e"][0])
    for leg in (1, 2):
        at = np.sort(c[angle].values[c.leg.values == leg])
        touching = at[at > engaged]
        # as many as asked in contact, and one more where scales slide again; nowhere a pile or a gap
        assert 59 <= touching.size <= 62
        # (on hinges closer together towards a lock)
        assert np.diff(touching).max() < (2.1 if joint else 1.6) * (0.11 - engaged) / 60
        assert joint or np.count_nonzero(touching > 0.11 - (0.11 - engaged) / 6) <= 12
        assert 13 <= at.size - touching.size <= 17


def test_the_work_hardly_depends_on_the_points():
    skin = squama.Beam.from_toml("examples/stiff_skin.toml").replace(scales=None)
    few, many = (squama.cycle(skin, "150 deg total", points=n) for n in (60, 1500))
    # tolerance: increments end at the points, 4e-4 on every processor
    assert float(few.W_d[0]) == pytest.approx(float(many.W_d[0]), rel=2e-3)


TURNS = (0.0203609628, 0.0208150328, 0.0197995517, 0.0201959907, 0.0204442695, 0.0218155842, 0.0196522789)
"""Twists at which scales turn round and did not find on at 5, 20, 40 or 60 points, rad per pitch."""


@pytest.mark.slow
def test_a_reversal_is_walked_at_any_number_of_points():
    beam = squama.Beam.from_ratios(
        eta=4.137, beta=0.8615, lam=0.6666, zeta=0.1818, slenderness=12.386, alpha=0.7484, theta0=0.08754,
        width="63 mm", thickness="40 mm", youngs_modulus="1 MPa", poisson_ratio=0.2543, mu=0.3856,
    )  # fmt: skip
    for turn in TURNS:
        way = [f"{x:.12g} rad/pitch" for x in (0.0492, turn, 0.0492, 0)]
        works = [float(squama.cycle(beam, way, points=n).W_d[-1]) for n in (5, 20, 40, 60, 200)]
        np.testing.assert_allclose(works, works[-1], rtol=6e-3)


def test_without_friction_it_comes_back_as_it_went():
    c = cycle("0.2 rad/pitch", mu=0)
    assert "stick" not in c.branch.values
    assert float(c.W_fr[-1]) == 0
    one, two = branch(c, 1, "loading"), branch(c, 2, "unloading")
    two = two.isel(point=two.phi.values > 0.08)
    np.testing.assert_allclose(np.interp(two.phi[::-1], one.phi, one["T"]), two["T"][::-1], rtol=5e-3)
    assert abs(float(c.W_d[0])) == 0
    assert float(c.T_drop[0]) == pytest.approx(0, abs=1e-4 * float(c["T"].max()))


def test_both_senses():
    # the scales meet in both
    plain = squama.Beam.from_ratios(eta=1.2, beta=0.80579, lam=0.7, alpha=0.158, theta0=0.03, zeta=0.02, mu=0.2)
    beam = held(plain, K)
    c = cycle("0, 0.2, -0.2, 0 rad/pitch", beam, points=40)
    assert list(c.sense.values) == ["+", "-"]
    for i, (sense, leg) in enumerate((("+", 1), ("-", 2))):
        one = branch(c, leg, "loading")
        assert one.sizes["point"] > 3
        r = squama.twist(beam, ideal=True, sense=sense, at=np.abs(one.Phi.values))
        np.testing.assert_allclose(np.abs(one["T"]), r["T"], rtol=3e-3)
        assert float(c.phi_e[i]) == pytest.approx(float(r.phi_e), rel=1e-6)
        assert c.first_contact.values[i] == r.first_contact.item()
    assert float(c.W_d.sum()) == pytest.approx(float(c.W_fr[-1]))
    np.testing.assert_allclose(sorted(c.phi_top.values), [-0.2, 0.2])
    # unsymmetric: the work differs
    assert abs(float(c.W_d[0] / c.W_d[1]) - 1) > 0.01


def test_more_loops_are_nearly_the_same_again():
    c = cycle("0.15 rad/pitch", loops=2)
    assert c.sizes["loop"] == 2
    np.testing.assert_allclose(c.W_d[1], c.W_d[0], rtol=1e-3)
    assert set(c.leg.values) == {1, 2, 3, 4}
    assert c.attrs["joint"] == "compliant"
    assert "margin" not in c.attrs


@pytest.mark.parametrize(
    ("twist", "options", "words"),
    [
        ("0.5 rad/pitch", FAR, 'twist = "0.5 rad/pitch" (28.6479 deg per pitch): the contact is followed back to 16.4'),
        ("1.2 rad/pitch", FAR, 'twist = "1.2 rad/pitch" (68.7549 deg per pitch): the contact is followed to 60.'),
        ("1.2 rad/pitch", FAR, 'give at most "60.'),
        ("1719 deg total", FAR, 'twist = "1719 deg total" (68.76 deg per pitch): the contact is followed to 60.'),
        (
            "0, 0.1, 1.2, 0 rad/pitch",
            FAR,
            'twist = "1.2 rad/pitch" (68.7549 deg per pitch): the contact is followed to 60.',
        ),
        ("1e-8 rad/pitch", {}, "twist = 5.73e-07 deg per pitch: is below 5.73e-05 deg per pitch: nothing moves"),
        ("1e-320 rad/m", {"joint": "hinge"}, "is below 5.73e-05 deg per pitch: nothing moves"),
        ("1e-320 rad/m", {"joint": "hinge", "load": "bending"}, "is below 5.73e-05 deg per pitch: nothing moves"),
        (
            "0, 0.1, 0.1000000001, 0 rad/pitch",
            {},
            "is nearer than 5.73e-05 deg per pitch to another one of the history",
        ),
        ("0, 0.1, -1e-12, 0.1 rad/pitch", {"joint": "hinge"}, "is nearer than 5.73e-05 deg per pitch to another one"),
        ("1.2 rad/pitch", FAR, "a plate comes to lie beside another one's edge"),
        ("4 rad/pitch", {}, "must be below half a turn per pitch"),
        (
            "0.2 rad/pitch",
            {"loops": 1000},
            "over 22900 deg per pitch in increments of 0.0286 deg per pitch; give at most 2864 ",
        ),
        ("0.2 rad/pitch", {"law": "plate", "joint": "compliant"}, 'law = "plate": is not covered by joint="compliant"'),
    ],
)
def test_what_is_not_covered_is_refused(twist, options, words):
    with pytest.raises(InputError) as caught:
        cycle(twist, **options)
    assert words in str(caught.value)
    assert len(str(caught.value).splitlines()) == 1


def test_small_twists_and_equal_ones_in_two_units_are_walked():
    c = cycle("1e-4 rad/m")
    assert float(c.phi.max()) == pytest.approx(1e-4 * BEAM.pitch, rel=1e-12)
    assert (c.branch == "straight").all()
    both = cycle(["0.1 rad/pitch", "0.05 rad/pitch", f"{0.1 / BEAM.pitch * (1 + 3e-16)!r} rad/m", "0 rad/m"])
    assert both.sizes["loop"] == 2


def test_how_far_it_says_one_can_go_one_can():
    with pytest.raises(InputError) as caught:
        cycle("1.2 rad/pitch", **FAR)
    most = str(caught.value).split('"')[3]
    up = ["0 rad/pitch", most]
    assert float(cycle(up, **FAR).phi.max()) > 1.0


def test_where_no_way_on_is_found_it_says_so(monkeypatch):
    real = path.Path.along

    def stopped(self, *given):
        found = real(self, *given)
        found.ends[0, [0, 3]] = increments.NO_EQUILIBRIUM, 3
        return found

    monkeypatch.setattr(path.Path, "along", stopped)
    with pytest.raises(InputError, match="no equilibrium was found beyond this twist, however small the increment"):
        cycle("0.1 rad/pitch")


def test_the_command(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    BEAM.to_toml("beam.toml")
    flags = [
        "--to",
        "0.15 rad/pitch",
        "--ideal",
        "--points",
        "20",
        "--plot",
        "c.png",
        "--csv",
        "c.csv",
        "--netcdf",
        "c.nc",
    ]
    assert main(["cycle", "beam.toml", *flags, "--full"]) == 0
    out = capsys.readouterr().out
    assert "  model                  thin, rigid scales on compliant joints; endless beam" in out
    assert "sense +: first contact at 3.35 deg per pitch: tip edge on side edge (k = 1)" in out
    assert "the work of the torque is balanced to" in out
    c = cycle("0.15 rad/pitch")
    assert squama.read("c.nc").identical(c)
    np.testing.assert_array_equal(squama.read("c.csv")["T"], c["T"])
    assert main(["cycle", "beam.toml", *flags[:5], "--json"]) == 0
    record = json.loads(capsys.readouterr().out)
    assert record["joint"] == "compliant"
    assert record["loops"]["W_d"] == c.W_d.values.tolist()
    assert record["energy_error"] == float(c.energy_error)
    assert main(["cycle", "beam.toml", *flags[:2], "--joint", "compliant", "--law", "plate"]) == 2
    assert capsys.readouterr().err.startswith('squama: error: --law = "plate": is not covered')
    assert main(["cycle", "beam.toml", *flags[:2], "--joint", "ball"]) == 2
    assert '--joint = "ball": must be "hinge" or "compliant"' in capsys.readouterr().err
    left, _ = cycle_figure(c).axes
    straight = next(line for line in left.lines if line.get_linestyle() == "--" and len(line.get_xdata()) == 2)
    # without contact it is the elements' rigidity
    slope = np.diff(straight.get_ydata())[0] / np.diff(straight.get_xdata())[0]
    steps = c.attrs["rigidity"] / BEAM.pitch
    assert slope / steps in (pytest.approx(1), pytest.approx(1e-3), pytest.approx(1e3))

"""Parts under load: bars by closed forms, balance by plain matrices, work, rows, mirror images, refused input."""

import json
import math
from pathlib import Path as File

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm
from scipy.optimize import fsolve

import squama
from squama.cli import main
from squama.contacts import row
from squama.contacts.path import Path, Scale
from squama.contacts.system import PHI, PSI
from squama.contacts.ties import COUPLE, Tie, Y, of_ends, ties
from squama.errors import InputError
from squama.part import loaded, loading

SKIN = squama.Beam.from_toml("examples/stiff_skin.toml")
BARE = SKIN.replace(scale={"length": "2 mm", "width": "2 mm"})
"""Its scales never touch."""


def bar(n, stiffness=(1.0, 1.0), free=(1.0, 0.0, 0.0, 0.0)):
    """Return a bar whose cells have given stiffness against twist and bend, and scales that do nothing."""
    K = np.diag([10.0] * 6 + [*stiffness, 50.0])
    way = Path.at_rest(Scale(0.5, 0.2, 0.1, 0.3, 0.3, 0.0), K, 0.0, free=(1, 1, 1, 1))
    return way, np.array([free]), n


def bent(n, u, *, at=5):
    """Return the force at the tip of a clamped elastica whose tip goes aside by u, and its frames."""
    way, free, n = bar(n)
    free[0, PHI] = 2.0
    share = n * n / 3
    held = ties(n, [Tie([(n, Y)], course=(PHI, share))])
    track = row.tied(way, n, row.legs(np.linspace(0, u / share, at + 1)[1:], PHI), held, free)
    return float(track.loads[-1, 0]), loaded.sections(track, n)[-1]


# ---- bars without contact -------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("load", "aside", "shorter", "slope"),
    [(1.0, 0.3017207738, 0.0564332363, 0.4613519497), (10.0, 0.8106090249, 0.5549955978, 1.430285539)],
)
def test_a_clamped_bar_is_the_elastica(load, aside, shorter, slope):
    """P L^2/EI, tip, slope (parts.md); of second order in the length of a cell."""
    off = {}
    for n in (50, 100, 200):
        P, frames = bent(n, aside * n)
        off[n] = abs(P * n * n / load - 1)
        end = frames[-1]
        assert 1 - end[2, 3] / n == pytest.approx(shorter, abs=0.2 / n**2 * 10)
        assert math.asin(end[1, 2]) == pytest.approx(slope, abs=2 / n**2 * 10)
    # tolerance: of second order, so that the error is the same on every processor
    assert off[200] < 1e-4
    assert off[50] / off[100] == pytest.approx(4, rel=0.05)
    assert off[100] / off[200] == pytest.approx(4, rel=0.05)


def under_couple(n, total, load, coupled=0.0):
    """Return a bar of n cells whose end is turned by an angle about its axis or its width; K couples bend and twist."""
    way, free, _ = bar(n, free=(2.0, 2.0, 1.0, 1.0))
    K = way.beams.K.copy()
    K[0, 6, 7] = K[0, 7, 6] = coupled
    way = way._replace(beams=way.beams._replace(K=K))
    free[0, PSI + PHI - load] = 1.0
    track = row.tied(way, n, row.legs(np.linspace(0, total / n, 5)[1:], load), of_ends(n, COUPLE, load), free)
    return track, loaded.sections(track, n)[-1]


@pytest.mark.parametrize(("load", "total"), [(PSI, 0.4), (PHI, 0.8), (PHI, 5.0)])
def test_an_end_couple_gives_arcs_and_straight_twists(load, total):
    track, frames = under_couple(6, total, load)
    np.testing.assert_allclose(track.cells[-1, :, load], total / 6, rtol=1e-12)
    np.testing.assert_allclose(track.cells[-1, :, 4 + load], total / 6, rtol=1e-12)
    radius = 6 / total
    end = [0, radius * (1 - math.cos(total)), radius * math.sin(total)] if load == PSI else [0, 0, 6]
    np.testing.assert_allclose(frames[-1][:3, 3], end, atol=1e-12)


def test_a_bar_that_bows_as_it_twists_is_a_rod_under_one_couple():
    """A continuous rod by Runge-Kutta steps of plain vectors; cells are of second order."""
    total, coupled = 2.0, 0.3
    # turns about -x, -y, -z: bend, lateral bend, twist
    soft = np.linalg.inv([[1, 0, coupled], [0, 1, 0], [coupled, 0, 1]])

    def far(couple):
        def rate(_, y):
            R = y.reshape(3, 3)
            w = soft @ R.T @ couple
            return (R @ np.array([[0, -w[2], w[1]], [w[2], 0, -w[0]], [-w[1], w[0], 0]])).ravel()

        return solve_ivp(rate, (0, 1), np.eye(3).ravel(), rtol=1e-10, atol=1e-12).y[:, -1].reshape(3, 3)

    def off(couple):
        R = far(couple)
        z = np.array([0, 0, 1.0])
        along = np.cross(couple, z + R[:, 2])
        angle = 2 * math.atan2(R[1, 0] - R[0, 1], 1 + np.trace(R))
        return [along[0], along[1], angle + total]

    found = fsolve(off, [0, 0, -0.9 * total], xtol=1e-10)
    torque = np.linalg.norm(found) * math.sqrt((1 + far(found)[2, 2]) / 2)
    missed = []
    for n in (12, 24, 48):
        track, frames = under_couple(n, total, PHI, coupled)
        missed.append(abs(n * float(track.loads[-1, 0]) / torque - 1))
        assert frames[-1][2, 2] == pytest.approx(far(found)[2, 2], abs=1 / n)
    assert missed[-1] < 1e-3
    assert missed[0] / missed[1] == pytest.approx(4, rel=0.2)


@pytest.mark.slow
def test_small_loads_are_those_of_beam_theory():
    """Cantilever, two rollers, both ends clamped; without shear, whose cells bend at their middle alone."""
    n, push = 20, "0.01 mm up at tip"
    L = n * BARE.pitch
    one = squama.load(BARE, push, scales=n, points=4)
    EI = float(one.F[-1] / one.travel[-1]) * L**3 / 3
    # what a pitch bends by, with its tabs
    r = squama.load(BARE, "0.001 deg bend", scales=n, points=4)
    assert pytest.approx(float(r.moment[-1] / r.turn[-1]) * L, rel=1e-3) == EI
    rollers = squama.load(BARE, "0.01 mm down at middle", support="simple", scales=n, points=4)
    assert float(rollers.F[-1] / rollers.travel[-1]) == pytest.approx(48 * EI / L**3, rel=3e-3)
    grips = squama.load(BARE, "0.01 mm down at middle", support="gripped", scales=n, points=4)
    # tolerance: cells of a fourth of the arc between two turning points bend at their middle alone
    assert float(grips.F[-1] / grips.travel[-1]) == pytest.approx(192 * EI / L**3, rel=2e-2)
    spread = squama.load(BARE, "1 mN down over all", scales=n, points=4)
    assert float(spread.y_axis[-1, -1]) == pytest.approx(-1e-3 * L**3 / (8 * EI), rel=3e-3)


def test_two_rollers_are_two_cantilevers():
    """Bent by a force in its middle, half a bar without scales that touch is a cantilever with half of it."""
    whole = squama.load(BARE, "20 mm down at middle", support="simple", scales=12, points=6)
    half = squama.load(BARE, f"{float(whole.F[-1]) / 2} N up at tip", scales=6, points=6)
    # along the chord, not along the bar's first length: the same to the second order of the slope
    sag = -(whole.y_axis[-1, 6] - whole.y_axis[-1, 0])
    assert float(half.y_axis[-1, -1]) == pytest.approx(float(sag), rel=0.02)
    middle = whole.M_cell[-1, [5, 6]].values
    np.testing.assert_allclose(middle[0], middle[1], rtol=1e-5)
    assert middle[0] > 0


def test_weight_is_a_force_over_all():
    r = squama.load(SKIN, "weight down", scales=5, points=4)
    bar = 1150 * 0.028 * 0.014 * 0.1
    scales = 5 * (1240 * 0.024 * 0.0016 * 0.076 - 1150 * 0.024 * 0.0016 * 0.006)
    assert float(r.F[-1]) == pytest.approx(9.81 * (bar + scales), rel=1e-6)
    np.testing.assert_allclose(r.root_force[-1], [0, 9.81 * (bar + scales), 0], rtol=1e-6, atol=1e-12)


# ---- with scales ----------------------------------------------------------------------------------------------------

CASES = {
    "tip": ("0.15 N up at tip", "clamped"),
    "aside": ("95 mm right at tip", "clamped"),
    "several": ("60 mN up at tip; 20 mN right at 60 mm; 3 mN m twist", "clamped"),
    "over all": ("0.3 N up over all", "clamped"),
    "tendon": ("3 N tendon at 5 mm", "clamped"),
    "rollers": ("60 mm down at middle", "simple, span 100 mm"),
    "grips": ("15 mm down at middle", "gripped"),
    "grips twist": ("90 deg twist", "gripped"),
}


def part(name, n=6, mu=0.25, **given):
    word, support = CASES[name]
    return squama.load(SKIN, word, support=support, scales=n, mu=mu, **given)


ALL = [pytest.param(name, marks=pytest.mark.slow if name == "rollers" else ()) for name in CASES]


@pytest.mark.parametrize("name", ALL)
def test_it_is_in_balance(name):
    """What cells carry is what the loads beyond do on a virtual strain of theirs, by matrices of four rows."""
    r = part(name, points=8)
    assert np.nanmax(r.N.values) > 0
    n, d = 6, SKIN.pitch
    strains = np.stack([r[f"{v}_cell"][-1].values for v in ("psi", "phi", "chi", "stretch")], axis=1)
    carried = np.stack([r[f"{v}_cell"][-1].values for v in ("M", "T", "M_lat", "P")], axis=1) * [1, 1, 1, d]
    first = np.eye(4)
    axis = np.stack([r[f"{v}_axis"][-1].values for v in "xyz"], axis=1) / d

    def places(e):
        """Sections behind the first one, and the frame of the last."""
        frame, out = first, []
        for psi, phi, chi, eps in e:
            screw = np.zeros((4, 4), complex)
            screw[:3, :3] = [[0, phi, -chi], [-phi, 0, psi], [chi, -psi, 0]]
            screw[2, 3] = 1 + eps
            frame = frame @ expm(screw)
            out.append(frame)
        return out

    if not r.attrs["support"].startswith("simple"):
        now = np.array([f[:3, 3].real for f in places(strains)])
        np.testing.assert_allclose(now, axis[1:], atol=1e-9)
        # loads: those of words, and what holds the far end
        held = loading.support(r.attrs["support"], SKIN, n)
        given = loading.loads(r.attrs["loads"], SKIN.replace(scales=n), n)
        if held.word == "clamped":
            moved = np.zeros((n, 4))
            for i, e in np.ndindex(n, 4):
                step = strains.astype(complex)
                step[i, e] += 1e-20j
                way = np.array([f[:3, 3].imag for f in places(step)]) * 1e20
                for one in given:
                    size = (float(r.F[-1]) if "F" in r and one.given else one.size) * (d if one.tie.forces else 1.0)
                    for at, force in one.tie.forces:
                        for j, share in loaded.at_sections(at, n):
                            moved[i, e] += share * size * (way[j - 1] @ force if j else 0.0)
                    moved[i, e] += one.tie.carried[e] * one.size * (d if one.words.strip().endswith("mm") else 1.0)
                    if one.turns == PHI:
                        R = places(step)[-1][:3, :3]
                        # of a turn about z and a tilt after it, by the quaternion
                        angle = 2 * np.arctan((R[0, 1] - R[1, 0]) / (1 + np.trace(R)))
                        moved[i, e] += one.size * angle.imag * 1e20
            np.testing.assert_allclose(carried, moved, atol=1e-6 * np.abs(moved).max())
            # the root bears all of them
            pushed = [one for one in given if one.tie.forces]
            size = [float(r.F[-1]) if one.given else one.size for one in pushed]
            total = sum((-s * f for s, one in zip(size, pushed, strict=True) for _, f in one.tie.forces), np.zeros(3))
            pulled = sum(one.size * one.tie.carried[3] for one in given)
            np.testing.assert_allclose(r.root_force[-1], total - [0, 0, pulled], atol=1e-6 * max(size, default=1.0))
            return
        # grips: coaxial
        end = places(strains)[-1].real
        np.testing.assert_allclose(end[:2, 3], 0, atol=1e-9)
        np.testing.assert_allclose(end[:3, 2], [0, 0, 1], atol=1e-9)
        return
    # on rollers the near one stays, the far one slides, and forces and moments vanish in all
    on = [(loaded.at_sections(at, n)) for at in loading.support(r.attrs["support"], SKIN, n).ends]
    near, far = (sum(share * axis[j] for j, share in one) for one in on)
    np.testing.assert_allclose(near, [0, 0, 0.5], atol=1e-9)
    np.testing.assert_allclose(far[:2], 0, atol=1e-9)
    assert far[2] < 5.5
    np.testing.assert_allclose(carried[[0, -1], 0], 0, atol=0.6 * np.abs(carried[:, 0]).max())
    np.testing.assert_allclose(r.root_force[-1], 0, atol=0)


@pytest.mark.parametrize("name", ALL)
def test_work_is_balanced_there_and_back(name):
    r = part(name, points=25, back=True)
    assert float(r.energy_error) < 3e-4
    name = "F" if "F" in r else "moment"
    x = r["travel" if name == "F" else "turn"].values
    if ";" not in r.attrs["loads"]:
        work = np.trapezoid(r[name].values, x)
        total = float((r.U_el + r.W_fr + r.W_snap)[-1]) * 6 * SKIN.pitch
        most = float(r.U_el.max()) * 6 * SKIN.pitch
        assert work == pytest.approx(total, abs=4e-3 * most)
    assert float(r.W_fr[-1]) > 0


@pytest.mark.slow(but=2)
@pytest.mark.parametrize("name", ["tip", "several", "tendon"])
def test_all_of_the_load_is_on_and_off_again(name):
    r = part(name, points=10, back=True)
    assert float(r.share.max()) == pytest.approx(1, rel=1e-6)
    assert 0 < float(r.share_e) < 1
    assert float(r.share[-1]) == pytest.approx(0, abs=1e-9)
    up, down = (np.interp(r.travel[8], r.travel[half], r.F[half]) for half in (slice(11), slice(20, 9, -1)))
    # friction holds it back
    assert down < up * (1 - 1e-4)


def test_end_torque_is_the_row_under_a_couple():
    r = squama.load(SKIN, "100 deg twist", scales=7, points=9)
    d = squama.row(SKIN, scales=7, to=f"{float(r.turn[-1]) / 7} rad/pitch", points=9, ends="couple")
    assert float(r.moment[-1]) == pytest.approx(float(d["T"][-1]), rel=1e-5)
    np.testing.assert_allclose(r.phi_cell[-1], d.phi_cell[-1], rtol=1e-4)


def test_end_moment_is_the_row_under_a_couple():
    r = squama.load(SKIN, "100 deg bend", scales=15, points=9)
    d = squama.bend(SKIN.replace(scales=15), at=[float(r.turn[-1]) / 15 / SKIN.pitch], ends="couple")
    assert float(r.moment[-1]) == pytest.approx(float(d.M[0]), rel=1e-5)
    np.testing.assert_allclose(r.psi_cell[-1], d.psi_cell[0], rtol=1e-4)


def test_grips_are_those_of_the_row():
    r = squama.load(SKIN, "80 deg twist", support="gripped", scales=6, points=9)
    d = squama.row(SKIN, scales=6, to="80 deg total", ends="gripped", points=9)
    assert float(r.moment[-1]) == pytest.approx(float(d["T"][-1]), rel=1e-5)
    np.testing.assert_allclose(r.M_cell[-1], d.M_cell[-1], atol=1e-4 * float(np.abs(d.M_cell).max()))


@pytest.mark.slow
def test_left_is_the_mirror_image_of_right():
    """Of a beam with scales straight across."""
    straight = SKIN.replace(scale={"alpha": 0})
    both = [
        squama.load(straight, f"18 mN {way} at tip; 0.06 N up at tip", scales=5, points=6, mu=0)
        for way in ("left", "right")
    ]
    assert {r.end.item() for r in both} == {"range end"}
    np.testing.assert_allclose(both[0].x_axis[-1], -both[1].x_axis[-1], atol=1e-9)
    np.testing.assert_allclose(both[0].y_axis[-1], both[1].y_axis[-1], atol=1e-9)


def test_the_root_bears_force_and_moment():
    r = part("tip", points=8)
    tip = [float(r[f"{v}_axis"][-1, -1]) for v in "xyz"]
    np.testing.assert_allclose(r.root_force[-1], [0, -0.15, 0], atol=1e-6)
    np.testing.assert_allclose(r.root_moment[-1], -np.cross(tip, [0, 0.15, 0]), atol=1e-8)
    for word, axis in (("20 N mm bend", 0), ("5 N mm twist", 2)):
        r = squama.load(SKIN, word, scales=4, points=5)
        assert float(r.root_moment[-1, axis]) == pytest.approx(float(r.moment[-1]))


def test_grips_say_that_the_ends_may_warp():
    assert "free to warp" in part("grips twist", points=4).attrs["warnings"]
    assert "free to warp" not in part("grips", points=4).attrs["warnings"]


def test_scales_stiffen_and_engage():
    r = part("tip", points=20)
    free = r.share.values < float(r.share_e)
    assert 2 < free.sum() < 20
    np.testing.assert_allclose(r.F[free], r.F_bare[free], rtol=1e-9)
    assert float((r.F / r.F_bare)[-1]) > 1.2


# ---- grading --------------------------------------------------------------------------------------------------------


def test_equal_values_are_no_grading():
    plain = part("tip", points=5)
    graded = part("tip", points=5, along={"scale.theta0": ["20 deg", "20 deg"]})
    for name in ("F", "y_axis", "N", "stress", "theta"):
        np.testing.assert_allclose(graded[name], plain[name], rtol=1e-9, atol=1e-12, err_msg=name)


def test_a_graded_part_engages_where_its_scales_lie_low():
    """A cantilever bends most at its root."""
    plain = part("tip", points=12)
    low = part("tip", points=12, along={"scale.theta0": ["21 deg", "18 deg"]})
    each = part("tip", points=12, along={"scale.theta0": [f"{21 - 0.6 * i} deg" for i in range(6)]})
    assert np.degrees(low.theta[0].values) == pytest.approx([21, 20.4, 19.8, 19.2, 18.6, 18])
    np.testing.assert_allclose(low.F, each.F, rtol=1e-9)
    assert float(low.share_e) > 1.2 * float(plain.share_e)
    assert float(low.energy_error) < 3e-4
    assert low.attrs["graded"] == "scale.theta0"


# ---- input ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("load", "given", "words"),
    [
        ("0.2 N", {}, "is no load"),
        ("5 s up at tip", {}, "is a time, but a force is needed"),
        ("5 mm up at tip; 1 N down at middle", {}, "stands alone"),
        ("0.2 N up at 1 m", {}, "is not on the beam, which is 100 mm long"),
        ("-1 N up", {}, "must be above 0"),
        ("3 N tendon at 1 m", {}, "lies farther from the bar's middle"),
        ("20 mN m bend", {"support": "gripped"}, "bends against the grips"),
        ("20 mN m twist", {"support": "simple"}, "twists a part that lies on rollers"),
        ("1 N out at tip", {"support": "simple"}, "pushes along the rollers"),
        ("1 N up", {"support": "hinged"}, 'must be one of "clamped", "gripped", "simple"'),
        ("1 N up", {"support": "simple, span 3 m"}, "must be one pitch to 100 mm long"),
        ("1 N up", {"along": {"beam.pitch": [1, 2]}}, "must be one of scale.length"),
        ("1 N up", {"along": {"scale.alpha": ["1 deg"]}}, "needs 2 values, or 5"),
        ("1 N up", {"scales": 1000}, "2 to 200"),
        ([], {}, "must be 1 to 12 texts"),
        (5, {}, "must be 1 to 12 texts"),
        ("-0.5 N down over all", {}, "must be above 0"),
        ("1e300 N up", {}, "is out of range"),
        ("1 N up at root", {}, "does not move the part"),
        ("1 N up at tip", {"support": "gripped"}, "does not move the part"),
        ("1 N up at tip; 1 N down at tip", {}, "does not move the part"),
        ("1 N up at tip", {"hold": "bend"}, "does not move the part"),
        ("1 N up at tip", {"hold": "straight"}, "strains are all held"),
        ("1 N up", {"along": 3}, "is no mapping"),
    ],
)
def test_what_is_refused(load, given, words):
    with pytest.raises(InputError, match=words):
        squama.load(SKIN, load, **{"scales": 5} | given)


@pytest.mark.slow
def test_a_load_that_is_not_reached_says_so():
    r = squama.load(SKIN, "5 kN up at tip", scales=5, points=5)
    assert str(r.end.item()) != "range end"
    assert float(r.share.max()) < 1
    assert np.isfinite(r.F).all()


# ---- the command ----------------------------------------------------------------------------------------------------


def test_the_command(tmp_path, capsys):
    files = [str(tmp_path / f"part.{ending}") for ending in ("png", "csv", "nc")]
    given = ["--load", "0.12 N up at tip", "--scales", "6", "--points", "8", "--back"]
    written = ["--plot", files[0], "--csv", files[1], "--netcdf", files[2]]
    assert main(["load", "examples/stiff_skin.toml", *given, *written]) == 0
    said = capsys.readouterr().out
    r = squama.load(SKIN, "0.12 N up at tip", scales=6, points=8, back=True)
    assert said.startswith(f"examples/stiff_skin.toml: 0.12 N at {1e3 * float(r.travel.max()):.3g} mm, ")
    assert "0.12 N up at tip; all of it is on" in said
    assert f"from {100 * float(r.share_e):.3g} % of the load on" in said
    assert "0 % of the deformation is left" in said
    kept = squama.read(files[2])
    np.testing.assert_allclose(kept.F, r.F, rtol=1e-9)
    assert kept.squama.beam == SKIN.replace(scales=6)
    assert squama.read(files[1]).identical(kept)
    rows = [line for line in File(files[1]).read_text().splitlines() if not line.startswith("#")]
    assert len(rows) == 1 + 17 * 6
    for name in files:
        assert name in said


def test_the_command_as_json(capsys):
    given = ["--load", "90 deg twist", "--support", "gripped", "--scales", "5", "--points", "6", "--json"]
    assert main(["load", "examples/stiff_skin.toml", *given]) == 0
    said = json.loads(capsys.readouterr().out)
    assert said["support"] == "gripped"
    assert said["curve"]["turn"][-1] == pytest.approx(math.pi / 2)
    assert len(said["each"]["theta"]) == 7
    assert len(said["sections"]["z_axis"][0]) == 6
    assert said["units"]["moment"] == "N m"


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ([], "--load: is missing"),
        (["--load", "1 N"], '--load = "1 N": is no load'),
        (["--load", "1 N up", "--support", "glued"], "--support"),
        (["--load", "1 N up", "--along", "theta0"], "--along"),
        (["--load", "1 N up", "--along", "scale.theta0=10 deg, 40 deg"], "--along: scales touch"),
    ],
)
def test_the_command_refuses(given, words, capsys):
    assert main(["load", "examples/stiff_skin.toml", "--scales", "5", *given]) == 2
    assert words in capsys.readouterr().err

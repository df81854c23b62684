"""Cycles of beams: what a history gives, jamming by direct search, other senses, files, command, bad input."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest

import squama
from squama.cli import main
from squama.curves.hinge_cycles import BRANCHES, senses
from squama.errors import InputError
from squama.plot import cycle_figure

BEAM = squama.Beam.from_ratios(youngs_modulus="2 MPa")
SOFT = squama.Beam.from_ratios(alpha="20 deg", youngs_modulus="2 MPa", stiffness="20 N m", inclusion_factor=1)
# with the other contacts of the plates left out, the tip-side pair engages in both senses
BOTH = squama.Beam.from_ratios(eta=1.0683, beta=0.80579, lam=1.034, alpha=0.15793, theta0=0.11, zeta=0.02)
# and here, at a high friction, the scales do not slide back in the middle of the path
HELD = squama.Beam.from_ratios(
    eta=2.711606655, beta=2.6771024, lam=0.1162005028, alpha=0.050711102, theta0=0.016729201, zeta=0.001, slenderness=5
)
HISTORY = "0, 0.15, 0.05, 0.2, 0 rad/pitch"


@pytest.fixture
def one_pair(monkeypatch):
    """Leave out the test of the plates against each other, which ends such paths before."""
    monkeypatch.setattr("squama.arrays.solution.touch", lambda *_, **__: None)


def along(c, branch):
    return c.isel(point=np.flatnonzero(c.branch.values == branch))


def test_every_turning_point_stands_before_and_after_the_drop():
    c = squama.cycle(BEAM, HISTORY, mu=0.3, joint="hinge")
    stick = np.flatnonzero(c.branch.values == "stick")
    assert c.phi.values[stick] == pytest.approx([0.15, 0.05, 0.2])
    for i, way in zip(stick, (-1, 1, -1), strict=True):
        before, after = c.isel(point=i - 1), c.isel(point=i)
        for name in ("phi", "theta", "U_el", "W_fr", "p", "s"):
            assert float(after[name]) == pytest.approx(float(before[name]), rel=1e-12), name
        assert float(after.f) == pytest.approx(way * 0.3 * float(after.N))
        assert float(before.f) == pytest.approx(-way * 0.3 * float(before.N))
        # the normal force changes too, with the friction
        assert (float(after.N) - float(before.N)) * way > 0
        assert (float(after["T"]) - float(before["T"])) * way > 0
    assert set(c.branch.values) == set(BRANCHES)
    assert (np.diff(c.leg.values) >= 0).all()
    assert set(c.leg.values) == {1, 2, 3, 4}
    assert c.attrs["history"] == pytest.approx([v / BEAM.pitch for v in (0, 0.15, 0.05, 0.2, 0)])


def test_a_path_of_hinges_is_that_of_thin_scales_unless_asked_otherwise():
    for ideal in (True, False):
        found = senses(BEAM, "twisting", 0.2, "edge", 0.01, *(() if ideal else (False,)))
        expected = squama.twist(BEAM, mu=0.2, points=3, joint="hinge", ideal=ideal)
        assert found.paths["+"].load_e == pytest.approx(float(expected.phi_e), rel=1e-12)


def test_figures_of_loops():
    c = squama.cycle(BEAM, HISTORY, mu=0.3, joint="hinge")
    np.testing.assert_allclose(c.phi_base, [0.05, 0])
    np.testing.assert_allclose(c.phi_top, [0.15, 0.2])
    tops = [c.isel(point=int(i)) for i in (np.flatnonzero(c.branch.values == "stick")[[0, 2]] - 1)]
    ends = [c.isel(point=int(np.flatnonzero(c.branch.values == "stick")[1]) - 1), c.isel(point=-1)]
    for i, (top, end) in enumerate(zip(tops, ends, strict=True)):
        assert float(c.U_max[i]) == pytest.approx(float(top.U_el))
        assert float(c.zeta_eq[i]) == pytest.approx(float(c.W_d[i] / (4 * math.pi * c.U_max[i])))
        assert float(c.K_sec[i]) == pytest.approx(float((top["T"] - end["T"]) / (top.Phi - end.Phi)))
    both = c.isel(point=[int(np.flatnonzero(c.branch.values == "stick")[2]) - j for j in (1, 0)])
    assert float(c.T_drop[1]) == pytest.approx(float(both["T"][0] - both["T"][1]))
    # tangent stiffness by differences
    for branch in ("loading", "unloading"):
        one = along(squama.cycle(BEAM, "0.2 rad/pitch", mu=0.3, points=2000, joint="hinge"), branch)
        slope = np.gradient(one["T"].values, one.Phi.values)
        np.testing.assert_allclose(one.K_t.values[5:-5], slope[5:-5], rtol=1e-4)


def test_more_loops_are_the_same_again():
    one, three = (squama.cycle(BEAM, "0.2 rad/pitch", mu=0.3, loops=n, joint="hinge") for n in (1, 3))
    assert three.sizes["loop"] == 3
    np.testing.assert_allclose(three.W_d, float(one.W_d[0]), rtol=1e-13)
    assert float(three.W_fr[-1]) == pytest.approx(3 * float(one.W_fr[-1]), rel=1e-12)
    again = squama.cycle(BEAM, [0, 5, 2], mu=0.3, loops=2, joint="hinge")
    assert again.attrs["history"] == pytest.approx([0, 5, 2, 0, 5, 2])


@pytest.mark.parametrize("law", ["edge", "plate"])
@pytest.mark.parametrize("mu", [0.4, 0.6])
def test_jamming_by_direct_search(law, mu):
    most = float(squama.cycle(SOFT, 0.01, mu=mu, law=law, joint="hinge").phi_most[0]) / SOFT.pitch
    c = squama.cycle(SOFT, most, mu=mu, law=law, points=4000, joint="hinge")
    down = along(c, "unloading").sortby("phi")
    phi, torque = down.phi.values, down["T"].values
    i = int(np.flatnonzero((torque[:-1] > 0) & (torque[1:] <= 0))[0])
    threshold = phi[i] + (phi[i + 1] - phi[i]) * torque[i] / (torque[i] - torque[i + 1])
    # tolerance: straight lines between 4000 points, 4e-8 and 2e-4 measured, on every processor
    assert float(c.phi_jam[0]) == pytest.approx(threshold, rel=1e-6)
    for share in (0.5, 0.999, 1.001, 1.2):
        top = threshold * share
        if top > phi[-1]:
            continue
        left = float(squama.cycle(SOFT, f"{top} rad/pitch", mu=mu, law=law, joint="hinge").phi_residual[0])
        # let go: it follows the lower branch down as long as the torque there is positive
        held = np.flatnonzero((torque <= 0) & (phi <= top))
        assert left == pytest.approx(phi[held[-1]] if held.size else 0, abs=2e-3)
        assert (left > 0) == (share > 1)


def test_a_stiff_bar_does_not_jam():
    c = squama.cycle(SOFT.replace(substrate={"youngs_modulus": "25 GPa"}), "0.5 rad/pitch", mu=0.5, joint="hinge")
    assert float(c.phi_jam[0]) == math.inf
    assert float(c.phi_residual[0]) == 0


def test_the_other_sense_is_the_mirrored_path(one_pair):
    to = 0.3 / BOTH.pitch
    c = squama.cycle(BOTH, [0, to, -to, 0], mu=0.2, joint="hinge")
    there = c.isel(point=np.flatnonzero((c.phi.values < 0) & (c.branch.values == "loading")))
    assert there.sizes["point"] > 20
    once = squama.twist(BOTH, at=-there.Phi.values, mu=0.2, sense="-", joint="hinge")
    np.testing.assert_allclose(-there["T"], once["T"], rtol=1e-9)
    np.testing.assert_allclose(there.K_t, once.K_t, rtol=1e-8)
    np.testing.assert_allclose(there.f, once.f, rtol=1e-8)
    assert list(c.sense.values) == ["+", "-"]
    assert (c.W_d.values > 0).all()
    assert c.phi_top.values[1] < 0
    assert c.K_sec.values[1] > 0
    np.testing.assert_allclose(float(c.W_d.sum()), float(c.W_fr[-1]), rtol=1e-12)


def test_let_go_in_the_other_sense_friction_holds_the_beam(one_pair):
    soft = BOTH.replace(joint={"stiffness": "20 N m", "inclusion_factor": 1}, substrate={"youngs_modulus": "0.2 MPa"})
    for top, left in ((0.3, -0.3), (0.19, 0.0)):
        c = squama.cycle(soft, f"0, {-top}, 0 rad/pitch", mu=0.6, joint="hinge")
        # turned round, the torque has to push the beam back, or does not
        assert (float(along(c, "unloading")["T"][0]) > 0) == (left != 0)
        assert float(c.phi_residual[0]) == pytest.approx(left)


def test_bending_closes_and_the_other_way_is_straight():
    c = squama.cycle(BEAM, "0, 0.2, -0.1, 0.2, 0 rad/pitch", mu=0.3, load="bending", joint="hinge")
    assert c.sizes["loop"] == 3
    back = c.isel(point=np.flatnonzero(c.psi.values < 0))
    np.testing.assert_allclose(back["M"], BEAM.bending_rigidity * back.kappa)
    once = squama.bend(BEAM, at=along(c, "loading").kappa.values, mu=0.3, joint="hinge")
    np.testing.assert_allclose(along(c, "loading")["M"], once["M"], rtol=1e-9)


def test_before_engagement_nothing_is_lost():
    c = squama.cycle(BEAM, "0.04 rad/pitch", mu=0.3, joint="hinge")
    assert set(c.branch.values) == {"straight"}
    assert float(c.W_d[0]) == 0
    np.testing.assert_allclose(c["T"], BEAM.torsional_rigidity * c.Phi)
    narrow = squama.cycle(BEAM, [0, 1], mu=0.3, joint="hinge")
    assert narrow.sizes["loop"] == 0
    static = squama.cycle(BEAM, "0.048 rad/pitch", mu=9, joint="hinge")
    assert static.end[0] == "static lock"


@pytest.mark.slow(but=1)
@pytest.mark.parametrize("history", [HISTORY, "0, 0.1, -0.1 rad/pitch", [0, 1]])
def test_files_give_back_what_was_written(tmp_path, history):
    c = squama.cycle(BEAM, history, mu=0.3, joint="hinge")
    assert squama.read(squama.save(c, tmp_path / "c.nc")).identical(c)
    assert squama.read(squama.save(c, tmp_path / "c.csv")).identical(c)
    rows = [line for line in (tmp_path / "c.csv").read_text().splitlines() if not line.startswith("#")]
    assert len(rows) == 1 + c.sizes["point"]


@pytest.mark.parametrize(
    ("beam", "history", "load"),
    [(BEAM, HISTORY, "twisting"), (SOFT, "0.55 rad/pitch", "twisting"), (BEAM, "0.2 rad/pitch", "bending")],
)
def test_pictures(beam, history, load):
    figure = cycle_figure(squama.cycle(beam, history, mu=0.5, load=load, joint="hinge"))
    assert len(figure.axes) == 2
    words = [t.get_text() for t in figure.axes[0].get_legend().get_texts()]
    assert "unloading" in words
    assert ("left when let go" in words) == (beam is SOFT)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"twist": []}, "twist: is empty"),
        ({"twist": 0}, "twist = 0: nothing moves"),
        ({"twist": [0, 5, 5, 0]}, "twist[2] = 5 rad/m: is the same as the one before"),
        ({"twist": [3, 3]}, "twist[1] = 3 rad/m: is the same as the one before"),
        ({"twist": [0, math.nan]}, "twist[1] = nan"),
        ({"twist": "0, 5"}, 'twist[0] = "0": does not say over which length'),
        ({"twist": [0, "5 mm"]}, 'twist[1] = "5 mm"'),
        ({"twist": "0, x, 0 rad/m"}, 'twist[1] = "x"'),
        ({"twist": None}, "twist = None: is nothing"),
        ({"twist": "0.2 rad"}, "does not say over which length"),
        (
            {"twist": "0.3 rad/pitch"},
            "twist = 17.1887 deg per pitch: is beyond 16.1882 deg per pitch, the cut-off before the frictional lock",
        ),
        ({"twist": "0.0482 rad/pitch", "mu": 9}, "where friction locks the scales as soon as they touch"),
        ({"twist": "-0.5 rad/pitch"}, "where another contact comes in that a cycle does not follow: side edge"),
        ({"twist": 5, "mu": None}, "mu: is not given"),
        ({"twist": 5, "mu": -1}, "mu = -1: must be 0 or more"),
        ({"twist": 5, "mu": [0.1, 0.2]}, "mu: must be one number"),
        ({"twist": 5, "law": "both"}, 'law = "both": must be "edge" or "plate"'),
        ({"twist": 5, "load": "shear"}, 'load = "shear": must be "twisting" or "bending"'),
        ({"twist": 5, "margin": 1}, "margin = 1: must be at least 1e-9 and below 1"),
        ({"twist": 5, "points": 2}, "points = 2: must be a whole number"),
        ({"twist": 5, "loops": 0}, "loops = 0: must be a whole number"),
        ({"twist": 5, "loops": 10000, "points": 1000}, "are too many"),
    ],
)
def test_bad_arguments(arguments, words):
    given = {"mu": 0.3, **arguments}
    with pytest.raises(InputError) as caught:
        squama.cycle(BEAM, **given, joint="hinge")
    assert words in str(caught.value)
    assert "\n" not in str(caught.value)


def test_the_other_contact_is_named_as_for_growing_twist():
    once = squama.twist(BEAM, mu=0.3, sense="-", joint="hinge")
    with pytest.raises(InputError) as caught:
        squama.cycle(BEAM, "-0.5 rad/pitch", mu=0.3, joint="hinge")
    assert f"follow: {once.other_contact.item()};" in str(caught.value)
    # as far as there, and there is no end of a path that has not begun
    c = squama.cycle(BEAM, "-0.3 rad/pitch", mu=0.3, joint="hinge").sel(sense="-")
    assert float(c.phi_end) == float(once.phi_end) == math.inf
    assert float(c.phi_most) == pytest.approx(float(once.Phi.max()) * BEAM.pitch)


def test_a_refused_twist_names_one_that_is_taken():
    with pytest.raises(InputError) as caught:
        squama.cycle(BEAM, "0.5 rad/pitch", mu=0.3, joint="hinge")
    allowed = str(caught.value).rpartition("at most ")[2].strip('"')
    assert squama.cycle(BEAM, allowed, mu=0.3, joint="hinge").sizes["loop"] == 1


def test_a_history_on_which_the_scales_do_not_slide_back_is_refused(one_pair):
    assert squama.cycle(HELD, "1.4 rad/pitch", mu=3.13, joint="hinge").sizes["loop"] == 1
    for history in ("0, 1.8, 0 rad/pitch", "0, 2.2, 1.7 rad/pitch"):
        with pytest.raises(
            InputError, match=r"coming from .* the scales do not slide back beyond .* deg per pitch, fric"
        ):
            squama.cycle(HELD, history, mu=3.13, joint="hinge")
    c = squama.cycle(HELD, "0, 2.24, 1.9, 2.24 rad/pitch", mu=3.13, joint="hinge")
    assert float(c.W_d[0]) > 0
    # let go there, it stays as it cannot slide back
    assert float(c.phi_jam[0]) < 1.6
    other = squama.Beam.from_ratios(eta=2.2431, beta=2.629, lam=0.7699, alpha=0.02633, theta0=0.2723, zeta=0.001)
    with pytest.raises(
        InputError, match=r"coming from -126\.051 deg per pitch the scales do not slide back beyond -103"
    ):
        squama.cycle(other, "0, -2.2, 0 rad/pitch", mu=5.3373, joint="hinge")


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "beam.toml").write_text(BEAM.replace(friction={"mu": 0.3}).to_toml())
    return tmp_path


def test_the_command(folder, capsys):
    arguments = ["cycle", "beam.toml", "--joint", "hinge", "--history", HISTORY]
    assert main([*arguments, "--plot", "c.png", "--csv", "c.csv", "--netcdf", "c.nc", "--full"]) == 0
    said = capsys.readouterr().out
    assert said.startswith("beam.toml: damping ratio ")
    assert "thin, rigid scales on hinges, edge law; endless beam" in said
    assert f"{np.degrees(0.05):.3g} to {np.degrees(0.15):.3g} deg per pitch" in said
    assert "wrote c.nc" in said
    assert (folder / "c.png").stat().st_size > 10_000
    expected = squama.cycle(BEAM.replace(friction={"mu": 0.3}), HISTORY, joint="hinge")
    assert squama.read("c.nc").identical(expected)
    np.testing.assert_array_equal(squama.read("c.csv")["T"], expected["T"])
    assert main([*arguments, "--json"]) == 0
    record = json.loads(capsys.readouterr().out)
    np.testing.assert_allclose(record["loops"]["W_d"], expected.W_d)
    np.testing.assert_allclose(record["curve"]["T"], expected["T"])
    assert record["senses"]["end"] == ["frictional lock"]
    assert record["units"]["W_d"] == "J/m"
    assert main(["cycle", "beam.toml", "--to", "0.1 rad/pitch", "--loops", "20", "--load", "bending", "--full"]) == 0
    assert "the first 12 of 20 loops" in capsys.readouterr().out
    assert main(["cycle", "beam.toml", "--joint", "hinge", "--history", "0.1, -0.1 rad/pitch", "--full"]) == 0
    assert "sense -: no engagement" in capsys.readouterr().out
    assert main(["cycle", "beam.toml", "--joint", "hinge", "--to", "0.01 rad/pitch"]) == 0
    assert capsys.readouterr().out.startswith("beam.toml: no contact up to ")


@pytest.mark.parametrize(
    ("flags", "words"),
    [
        ([], 'give one of them, e.g. --to "0.2 rad/pitch"'),
        (["--to", "5 rad/m", "--history", "0, 5 rad/m"], "both are given"),
        (["--to", "0.2"], '--to = "0.2": has no unit'),
        (["--to", "0.2 rad"], "--to = "),
        (["--to", "0.1, 0.2 rad/pitch"], "give them to --history"),
        (["--to", "0 rad/m"], "--to = 0: nothing moves"),
        (["--to", "0.5 rad/pitch", "--joint", "hinge"], "--to = 28.6479 deg per pitch: is beyond"),
        (["--history", "0, 0.5, 0 rad/pitch", "--joint", "hinge"], "--history = 28.6479 deg per pitch: is beyond"),
        (["--history", "0, 0.1, 0.1 rad/pitch"], "--history[2] = 5.625 rad/m: is the same"),
        (["--history", "0, 0.1,, 0.2 rad/pitch"], "--history[2]"),
        (["--to", "5 rad/m", "--loops", "1.5"], "--loops = 1.5: is not a whole number"),
        (["--to", "5 rad/m", "--loops", "0"], '--loops = "0": is out of range'),
        (["--to", "5 rad/m", "--points", "many"], "--points"),
        (["--to", "5 rad/m", "--law", "both"], '--law = "both"'),
        (["--to", "5 rad/m", "--load", "shear"], '--load = "shear"'),
        (["--to", "5 rad/m", "--mu", "0,0.2"], "--mu"),
        (["--to", "5 rad/m", "--margin", "2"], "--margin"),
        (["--to", "5 rad/m", "--csv", "nowhere/c.csv"], "nowhere"),
        (["--to", "5 rad/m", "--plot", "c.gif"], "c.gif"),
    ],
)
def test_bad_flags(folder, capsys, flags, words):
    assert main(["cycle", "beam.toml", *flags, *([] if "--plot" in flags else ["--plot", "c.png"])]) == 2
    said = capsys.readouterr().err
    assert words in said
    assert said.startswith("squama: error: ")
    assert said.count("\n") == 1
    assert [p.name for p in folder.iterdir()] == ["beam.toml"]


def test_wide_oblique_scales_that_are_bent_away_touch_at_their_bases():
    assert (
        squama.cycle(BEAM, "0, -0.2, 0 rad/pitch", mu=0.3, load="bending", joint="hinge")["end"].values[-1]
        == "no engagement"
    )
    wide = BEAM.replace(scale={"width": "60 mm", "alpha": "60 deg"})
    far = squama.cycle(wide, "0, -0.01, 0 rad/pitch", mu=0.3, load="bending", joint="hinge")
    assert far.other_contact.values[-1].startswith("corner ")
    most = float(far.psi_most[-1])
    with pytest.raises(squama.InputError, match="where another contact comes in that a cycle does not follow: corner"):
        squama.cycle(wide, [0, -1.01 * most / wide.pitch], mu=0.3, load="bending", joint="hinge")

"""Bending and twisting along a path on hinges: the dataset, the command and the picture."""

import json

import numpy as np
import pytest

import squama
from squama.cli import main
from squama.curves.polygons import bent_and_twisted
from squama.errors import InputError
from squama.plot import path_figure
from squama.plot.plane import said

BEAM = squama.Beam.from_ratios(eta=3, beta=1.25, lam=0.45, alpha="45 deg", theta0="10 deg", mu=0.2)
PATH = "bend 0.1 rad/pitch; twist 0.15 rad/pitch; bend 0.05 rad/pitch, twist 0.1 rad/pitch"


def hinged(beam, path, **asked):
    return squama.bend_twist(beam, path, joint="hinge", **asked)


def test_twist_alone_is_what_twist_answers():
    both = hinged(BEAM, "twist 0.2 rad/pitch", points=40)
    alone = squama.twist(BEAM, joint="hinge", ideal=True, at=both.Phi.values)
    np.testing.assert_allclose(both.phi_e, alone.phi_e, rtol=1e-12)
    for name in ("theta", "T", "T_scales", "N", "f", "U_el", "W_fr", "RED"):
        np.testing.assert_allclose(both[name], alone[name], rtol=1e-9, atol=1e-9 * float(abs(alone[name]).max()))
    # the moment that keeps it straight, theory: bending and twisting
    assert abs(both.M_scales.values[-1]) > 0.1 * both.T_scales.values[-1]


def test_a_lock_is_cut_off_as_in_twist():
    both = hinged(BEAM, "twist 0.5 rad/pitch", mu=0.5)
    alone = squama.twist(BEAM, joint="hinge", ideal=True, mu=0.5)
    assert both.end.item() == alone.end.item() == "frictional lock"
    for name in ("phi_end", "Phi_end", "theta_end"):
        assert float(both[name]) == pytest.approx(float(alone[name]), rel=1e-12)
    # the cut-off leaves a part of the twist here, of the inclination there
    assert both.phi.values[-1] == pytest.approx(float(both.phi_e) + 0.99 * float(both.phi_end - both.phi_e))


@pytest.mark.parametrize(
    "path", ["twist 0.2 rad/pitch", "bend 0.1 rad/pitch; bend 0.15 rad/pitch, twist 0.3 rad/pitch"]
)
def test_what_locks_at_once_has_no_forces(path):
    r = hinged(BEAM, path, mu=9.0)
    assert r.end.item() == "static lock"
    assert float(r.theta_end) == pytest.approx(BEAM.scale.theta0)
    assert np.isfinite(r.M).all()
    np.testing.assert_array_equal(r.T_scales, 0)
    assert r.event.values[-1] == "static lock"


def test_work_is_stored_or_rubbed_away():
    r = hinged(BEAM, PATH, points=2000)
    assert r.end.item() == "range end"
    M, T, kappa, Phi = (r[name].values for name in ("M", "T", "kappa", "Phi"))
    given = np.trapezoid(M, kappa) + np.trapezoid(T, Phi)
    # tolerance: trapezoids between 2000 points, 4e-7 measured, on every processor
    assert given == pytest.approx(float(r.U_el[-1] + r.W_fr[-1]), rel=1e-6)
    assert r.W_fr.values[-1] > 0.05 * r.U_el.values[-1]
    assert (np.diff(r.W_fr.values) >= 0).all()


def test_events_are_where_loads_jump():
    r = hinged(BEAM, PATH, points=50)
    assert r.event.values.tolist() == [
        "engagement (BF)", "corner", "BF to TS", "corner", "range end",
    ]  # fmt: skip
    assert r.event_leg.values.tolist() == [1, 1, 2, 2, 3]
    np.testing.assert_array_equal(np.unique(r.leg), [1, 2, 3])
    # each place of an event stands twice, before and after
    twice = np.flatnonzero((np.diff(r.psi) == 0) & (np.diff(r.phi) == 0))
    np.testing.assert_allclose(r.psi.values[twice], r.psi_event.values[:-1])
    for name in ("M", "T"):
        np.testing.assert_allclose(np.diff(r[name])[twice], r[f"{name}_jump"].values[:-1], atol=1e-12)
    np.testing.assert_allclose(np.diff(r.theta)[twice], 0, atol=1e-9)
    assert r.attrs["neutral"] == "middle"
    assert r.attrs["joint"] == "hinge"


def test_the_neutral_line_matters_in_bending_only():
    ends = {
        name: [float(hinged(BEAM, path, neutral=name).theta_end) for path in ("bend 5 rad/m", "twist 5 rad/m")]
        for name in ("middle", "face")
    }
    assert ends["middle"][1] == pytest.approx(ends["face"][1], rel=1e-13)
    assert ends["middle"][0] > ends["face"][0] + 0.01


def test_pairs_and_words_are_one_path():
    d = BEAM.pitch
    pairs = hinged(BEAM, [(0.1 / d, 0), (0.1 / d, "0.15 rad/pitch"), (0.05 / d, 0.1 / d)])
    words = hinged(BEAM, PATH)
    np.testing.assert_allclose(pairs.M, words.M, rtol=1e-12)
    back = hinged(BEAM, "twist -0.5 rad/pitch")
    assert "bears on the root" in back.warnings


def test_nothing_warns_of_what_is_taken_in():
    for path in ("bend 5 rad/m", "twist 5 rad/m", PATH):
        assert "alpha = " not in hinged(BEAM, path).warnings


@pytest.mark.slow(but=1)
@pytest.mark.parametrize(("free", "path"), [("twisting", "bend 0.1 rad/pitch"), ("bending", "twist 0.1 rad/pitch")])
def test_what_is_free_has_no_moment_and_takes_the_least_energy(free, path):
    r = hinged(BEAM, path, mu=0, free=free, points=40)
    assert r.end.item() == "range end"
    name, other, angle = ("T", "M", "phi") if free == "twisting" else ("M", "T", "psi")
    np.testing.assert_array_equal(r[name], 0)
    # the bar's and the scales' part cancel
    bar = {"M": BEAM.bending_rigidity * r.kappa, "T": BEAM.torsional_rigidity * r.Phi}
    size = float(abs(r[f"{other}_scales"]).max())
    np.testing.assert_allclose(bar[name] + r[f"{name}_scales"], 0, atol=1e-6 * size)
    assert abs(r[angle].values[-1]) > 1e-4
    # work of the imposed load alone is what is stored
    rate = r.kappa if free == "twisting" else r.Phi
    given = np.trapezoid(r[other], rate)
    assert given == pytest.approx(float(r.U_el[-1]), rel=0.012)
    # less than with the other load held at zero
    held = hinged(BEAM, path, mu=0)
    assert float(r.U_el[-1]) < float(held.U_el[-1])


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"mu": 0.1}, "mu = 0.1: must be 0"), ({"path": PATH}, "one way"), ({"free": "bending"}, "one way"),
        ({"free": "both"}, "free"),
    ],
)  # fmt: skip
def test_what_cannot_be_free_is_one_line(given, words):
    with pytest.raises(InputError) as error:
        hinged(BEAM, **{"path": "bend 5 rad/m", "mu": 0, "free": "twisting"} | given)
    assert words in str(error.value)


@pytest.mark.parametrize(
    ("path", "words"),
    [
        ("", 'path = "": is not a way'), ("turn 5 rad/m", "is not a way"), ("bend", "is not a way"),
        ("bend 5 rad/m, bend 6 rad/m", "each word once"), ("bend 5", "does not say over which length"),
        ("bend 5 rad/m; bend 5 rad/m", "path[1]"), ([], "is not a path"), (5, "is not a path"),
        ([(1, 2, 3)], "not a pair"), ([(0, 0)], "ends where it starts"), ("twist 4 rad/pitch", "half a turn"),
        ([(np.nan, 1)], "path"),
    ],
)  # fmt: skip
def test_bad_paths_are_one_line(path, words):
    with pytest.raises(InputError) as error:
        hinged(BEAM, path)
    assert words in str(error.value)
    assert "\n" not in str(error.value)


def test_the_command(tmp_path, capsys):
    file = tmp_path / "beam.toml"
    BEAM.to_toml(file)
    assert (
        main(["bend-twist", str(file), "--joint", "hinge", "--path", PATH, "--csv", str(tmp_path / "a.csv"), "--full"])
        == 0
    )
    shown = capsys.readouterr().out
    assert shown.splitlines()[0] == f"{file}: the whole path is followed; nothing locks"
    assert "thin, rigid scales on hinges" in shown
    assert "BF to TS" in shown
    assert len((tmp_path / "a.csv").read_text().splitlines()) > 100
    assert main(["bend-twist", str(file), "--joint", "hinge", "--path", PATH, "--json", "--mu", "0"]) == 0
    record = json.loads(capsys.readouterr().out)
    assert record["events"]["event"][0] == "engagement (BF)"
    assert record["figures"]["end"] == "range end"
    assert record["units"]["M_jump"] == "N m"
    assert main(["bend-twist", str(file), "--path", "up 3", "--neutral", "top"]) == 2
    wrong = capsys.readouterr().err
    assert "--neutral" in wrong
    assert main(["bend-twist", str(file), "--path", "bend 5 rad/m; up 3 rad/m"]) == 2
    assert "--path[1]" in capsys.readouterr().err


@pytest.mark.slow
def test_the_picture_has_path_loads_and_inclination():
    answer = bent_and_twisted(BEAM, "bend 0.1 rad/pitch; twist 0.25 rad/pitch", mu=0.4, joint="hinge")
    around = squama.bend_twist_map(BEAM, "bend 0.1 rad/pitch; twist 0.25 rad/pitch", mu=0, joint="hinge")
    # what the map says where the path is
    at = around.sel(psi=answer["psi"][60:160:20], phi=answer["phi"][60:160:20], method="nearest")
    assert {"", "BF"} == set(np.diag(at.contact))
    figure = path_figure(answer.dataset(), plane=around)
    left, loads, theta = figure.axes
    assert len(left.get_images()) == 1
    labels = [text.get_text() for text in figure.legends[0].get_texts()]
    line = r"$\varphi = \psi\,\tan\alpha$"
    assert labels == ["no contact", *map(said, ("BF", "TS")), line, "event on the path", "frictional lock"]
    assert [line.get_label() for line in loads.get_lines()][:2] == ["$M$", "$T$"]
    assert theta.get_lines()[0].get_ydata().max() > 50

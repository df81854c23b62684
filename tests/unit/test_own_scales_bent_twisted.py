"""Bend and twist of a beam with a number of scales: all of them along a path, between free ends or all alike."""

from __future__ import annotations

import json

import numpy as np
import pytest

import squama
from squama.cli import main
from squama.plot import path_figure

BACK = (
    "twist 0.09 rad/pitch; bend 0.02 rad/pitch, twist 0.1 rad/pitch; twist 0.05 rad/pitch; "
    "bend 0 rad/pitch, twist 0 rad/pitch"
)
"""There, aside and back."""
SKIN = squama.Beam.from_toml("examples/stiff_skin.toml").replace(scales=6)


@pytest.mark.parametrize("ends", ["free", "gripped", "equal"])
def test_a_path_of_twists_is_the_twisted_beam(ends):
    both = squama.bend_twist(SKIN, "twist 0.09 rad/pitch", ends=ends, points=40)
    alone = squama.twist(SKIN, at=both.Phi.values, ends=ends)
    assert (both.attrs["ends"], both.theta.dims) == (ends, ("point", "scale"))
    assert float(both.phi_e) == pytest.approx(float(alone.phi_e), rel=1e-9)
    cells = () if ends == "equal" else ("phi_cell", "psi_cell")
    for name in ("T", "T_scales", "psi", "theta", "N", "u_Z", "U_el", "T_periodic", *cells):
        size = float(abs(alone[name]).max())
        # tolerance: increments of 2e-3 beside stations of the curve, and steps along a way
        np.testing.assert_allclose(both[name], alone[name], rtol=0, atol=1e-6 * size, err_msg=name)


def test_a_path_of_bends_is_the_bent_beam():
    both = squama.bend_twist(SKIN, "bend 0.09 rad/pitch", points=40)
    alone = squama.bend(SKIN, at=both.kappa.values)
    for name in ("M", "M_scales", "phi", "theta", "N", "phi_cell", "psi_cell", "U_el", "M_periodic"):
        size = float(abs(alone[name]).max())
        np.testing.assert_allclose(both[name], alone[name], rtol=0, atol=1e-6 * size, err_msg=name)


def test_equal_cells_are_the_row():
    both = squama.bend_twist(SKIN, "twist 0.09 rad/pitch", ends="equal", points=30, hold="bend")
    row = squama.row(SKIN, to="0.09 rad/pitch", ends="equal", points=30, hold="bend")
    # tolerance: increments of 2e-3 from stations that are not the same
    np.testing.assert_allclose(both["T"][-1], row["T"][-1], rtol=1e-6)
    np.testing.assert_allclose(both.theta[-1], row.theta[-1], rtol=1e-6)


@pytest.mark.parametrize("ends", ["free", "equal"])
def test_the_work_of_moment_and_torque_is_stored_or_rubbed(ends):
    r = squama.bend_twist(SKIN, BACK, ends=ends, points=120)
    assert r.end.item() == "range end"
    assert abs(float(r.energy_error)) < 1e-4
    work = np.trapezoid(r.M, r.kappa) + np.trapezoid(r["T"], r.Phi)
    spent = float((r.U_el + r.W_fr + r.W_snap)[-1])
    assert float(r.W_fr[-1]) > 0.01 * float(r.U_el.max())
    # tolerance: trapezoids between 120 points of each way, and the increments; of the largest energy, 1e-4
    assert work == pytest.approx(spent, abs=3e-4 * float(r.U_el.max()))
    if ends == "free":
        np.testing.assert_allclose(r.phi_cell.mean("scale"), r.phi, atol=1e-9)
        np.testing.assert_allclose(r.psi_cell.mean("scale"), r.psi, atol=1e-9)


def test_without_friction_moment_and_torque_are_the_slopes_of_the_energy():
    def at(psi, phi):
        path = f"twist 0.09 rad/pitch; bend {psi} rad/pitch, twist {phi} rad/pitch"
        return squama.bend_twist(SKIN, path, mu=0, points=20).isel(point=-1)

    here, d, h = at(0.02, 0.1), SKIN.pitch, 5e-4
    for name, a, b in (("M", at(0.02 + h, 0.1), at(0.02 - h, 0.1)), ("T", at(0.02, 0.1 + h), at(0.02, 0.1 - h))):
        assert float(a.U_el - b.U_el) / (2 * h / d) == pytest.approx(float(here[name]), rel=1e-4)


def test_the_middle_of_many_scales_is_the_endless_beam_under_the_same_loads():
    """Not at the same mean strains: cells at the ends go farther."""
    long, path = SKIN.replace(scales=60), "bend 0.01 rad/pitch, twist 0.07 rad/pitch"
    # friction knows the way, and that of a cell in the middle is not straight
    r = squama.bend_twist(long, path, points=15, mu=0).isel(point=-1)
    psi, phi = (float(r[name][29]) / SKIN.pitch for name in ("psi_cell", "phi_cell"))
    e = squama.bend_twist(SKIN, [(psi, phi)], points=15, mu=0, ends="endless").isel(point=-1)
    # tolerance: what is left of the ends in the middle
    assert float(r["T"]) == pytest.approx(float(e["T"]), rel=1e-8)
    assert float(r.M) == pytest.approx(float(e.M), rel=1e-8)
    assert float(r.theta[29]) == pytest.approx(float(e.theta), rel=1e-8)
    assert float(r.phi_cell[-1]) > 1.05 * float(r.phi)


def test_events_name_their_scales():
    r = squama.bend_twist(SKIN, "twist 0.09 rad/pitch; twist 0 rad/pitch", points=30)
    engaged = r.event.values == "engagement (TS)"
    assert sorted(r.event_scale.values[engaged].tolist()) == [1, 2, 3, 4, 5]
    assert (r.event.values == "release").sum() == 5
    whole = r.event_scale.values == 0
    assert r.event.values[whole].tolist() == ["corner", "range end"]
    assert set(r.contact.values) == {"", "TS"}
    # a scale that touches bears a force, and what happens to it is where the path is
    np.testing.assert_allclose(r.phi_event[engaged], float(r.phi_e), rtol=1e-6)
    assert ((r.N > 0).any("scale") == (r.contact != "")).all()


def test_who_answers_with_ends():
    path = "twist 0.03 rad/pitch; bend 0.01 rad/pitch"
    for beam, how in (
        (SKIN.replace(scales=None), {}),
        (SKIN.replace(scales=201), {}),
        (SKIN, {"joint": "hinge"}),
        (SKIN, {"ends": "endless"}),
    ):
        assert "scale" not in squama.bend_twist(beam, path, points=3, **how).dims
    assert "scale" in squama.bend_twist(SKIN, path, points=3).dims
    # grips have no use for a moment
    assert squama.bend_twist(SKIN.replace(ends="gripped"), path, points=3).attrs["ends"] == "free"
    for beam, how, words in (
        (SKIN, {"ends": "gripped"}, "is not known of a beam that is loaded so"),
        (SKIN, {"ends": "equal", "joint": "hinge"}, "is not known of a row on hinges"),
        (SKIN.replace(scales=None), {"ends": "free"}, "needs a number of scales, and this beam is endless"),
    ):
        with pytest.raises(squama.InputError, match=words):
            squama.bend_twist(beam, path, **how)


@pytest.mark.slow
def test_the_command_sets_the_endless_beam_beside(tmp_path, capsys):
    file, table = tmp_path / "beam.toml", tmp_path / "path.csv"
    SKIN.to_toml(file)
    given = ["bend-twist", str(file), "--path", BACK, "--points", "20"]
    assert main([*given, "--csv", str(table), "--plot", str(tmp_path / "p.png"), "--full"]) == 0
    said = capsys.readouterr().out
    assert "6 scales with free ends" in said
    own, endless = (squama.bend_twist(SKIN, BACK, points=20, ends=ends) for ends in (None, "endless"))
    at = np.flatnonzero(own.leg == 1)[-1]
    shares = [float(own[name][at] / endless[name][np.flatnonzero(endless.leg == 1)[-1]]) for name in ("M", "T")]
    assert f"6 scales over the endless beam at the end of way 1: M {shares[0]:.3g}, T {shares[1]:.3g} times" in said
    assert any(line.startswith("engagement (TS)") and " 1-5 " in line for line in said.splitlines())
    lines = [line for line in table.read_text().splitlines() if not line.startswith("#")]
    assert len(lines) == 1 + own.sizes["point"] * 6
    assert main([*given, "--ends", "endless", "--json"]) == 0
    record = json.loads(capsys.readouterr().out)
    assert set(record["ways"]) == {"compliant", "hinge"}
    assert main([*given, "--json"]) == 0
    record = json.loads(capsys.readouterr().out)
    assert set(record["ways"]) == {"compliant", "endless", "hinge"}
    assert record["ends"] == "free"
    assert np.shape(record["each"]["theta"]) == (own.sizes["point"], 6)
    assert main([*given, "--ends", "gripped"]) == 2
    assert "--ends" in capsys.readouterr().err


def test_the_picture_has_each_scale_and_the_endless_beam():
    r = squama.bend_twist(SKIN, "twist 0.09 rad/pitch", points=20)
    _, loads, theta = path_figure(r).axes
    labels = [text.get_text() for text in loads.get_legend().get_texts()]
    assert labels == ["$M$", "$M$, endless", "$T$", "$T$, endless"]
    assert len(theta.get_lines()) == 6 + 2

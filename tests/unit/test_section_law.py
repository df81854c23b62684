"""The law of a section: the same states by every other door, a memory that can be taken back, slopes, work, files."""

import csv
import io
import re

import numpy as np
import pytest

import squama
from squama.contacts import onward
from squama.errors import InputError

SKIN = squama.Beam.from_toml("examples/stiff_skin.toml")
D = SKIN.pitch
GRID = np.linspace(-0.1, 0.1, 21) / D
WAYS = "bend 1.5 rad/m; twist 4 rad/m; bend 3 rad/m; twist 1 rad/m, bend 0 rad/m"
"""Engages, slides, turns at corners, and comes back."""


@pytest.fixture(scope="module")
def plane():
    return squama.law_table(SKIN, kappa=GRID, Phi=GRID)


@pytest.fixture(scope="module")
def alone():
    return squama.law_table(SKIN, kappa=GRID, Phi=GRID, mu=0.25, uncoupled=True)


def stepped(law, kappa, Phi):
    """Go through strains and commit each; return moments and torques (n, cells)."""
    found = []
    for k, p in zip(kappa, Phi, strict=True):
        found.append(law.trial(k, p))
        law.commit()
    return np.moveaxis(np.array(found), 1, 0)


# ---- the same states by other doors ---------------------------------------------------------------------------------


@pytest.mark.parametrize("mu", [0.0, 0.25])
def test_committed_steps_are_the_path_of_bend_twist(mu):
    r = squama.bend_twist(SKIN, WAYS, mu=mu, points=25, ends="endless")
    law = squama.law(SKIN, mu=mu)
    M, T = stepped(law, r.kappa.values, r.Phi.values)
    assert M[:, 0] == pytest.approx(r.M.values, abs=1e-9 * np.abs(r.M.values).max())
    assert T[:, 0] == pytest.approx(r["T"].values, abs=1e-9 * np.abs(r["T"].values).max())
    assert law.W_fr[0] == pytest.approx(r.W_fr.values[-1], abs=1e-9 * float(r.U_el.max()))
    assert law.U_el[0] == pytest.approx(r.U_el.values[-1], abs=1e-9 * float(r.U_el.max()))
    assert (law.W_fr[0] > 0.01 * float(r.U_el.max())) == (mu > 0)


def test_a_twist_held_against_bend_is_a_law_without_curvature():
    at = np.linspace(0, 5, 21)
    r = squama.twist(SKIN, mu=0.25, hold="bend", ends="endless", at=at)
    M, T = stepped(squama.law(SKIN, mu=0.25), 0 * at, at)
    # tolerance: a curve has stations of its own between those that are asked for
    assert T[:, 0] == pytest.approx(r["T"].values, abs=1e-5 * float(r["T"].max()))
    assert M[:, 0] == pytest.approx(r.M.values, abs=1e-5 * float(r["T"].max()))


def test_a_bend_held_against_twist_is_a_law_without_twist():
    at = np.linspace(0, 5, 21)
    r = squama.bend(SKIN, mu=0.25, hold="twist", ends="endless", at=at)
    M, _ = stepped(squama.law(SKIN, mu=0.25), at, 0 * at)
    # tolerance: a curve has stations of its own between those that are asked for
    assert M[:, 0] == pytest.approx(r.M.values, abs=1e-6 * float(r.M.max()))


def test_a_beam_free_to_bow_has_no_moment():
    r = squama.twist(SKIN, mu=0.0, ends="endless", at=np.linspace(0, 5, 11))
    M, T = squama.law(SKIN, mu=0, cells=11).trial(r.psi / D, r.Phi)
    assert np.abs(M).max() < 1e-9 * float(r["T"].max())
    assert pytest.approx(r["T"].values, abs=1e-9 * float(r["T"].max())) == T
    assert np.abs(r.psi).max() > 0.02


def test_there_and_back_is_a_cycle():
    r = squama.cycle(SKIN, "5 rad/m", mu=0.25, hold="bend", ends="endless", points=201)
    Phi, T = r.Phi.values, r["T"].values
    law = squama.law(SKIN, mu=0.25)
    _, ours = stepped(law, 0 * Phi, Phi)
    # tolerance: a history has stations of its own between its points
    assert ours[:, 0] == pytest.approx(T, abs=1e-6 * T.max())
    assert np.argmax(Phi) < Phi.size - 5
    assert law.W_fr[0] == pytest.approx(float(r.W_fr.max()), rel=1e-3)


def test_scales_on_both_faces_are_followed():
    both = SKIN.replace(faces="turned")
    r = squama.bend_twist(both, "bend 2 rad/m; twist 4 rad/m", mu=0.2, points=9, ends="endless")
    M, T = stepped(squama.law(both, mu=0.2), r.kappa.values, r.Phi.values)
    # tolerance: a path's increments do not all end at its points
    assert M[:, 0] == pytest.approx(r.M.values, abs=1e-6 * float(np.abs(r.M).max()))
    assert T[:, 0] == pytest.approx(r["T"].values, abs=1e-6 * float(np.abs(r["T"]).max()))


# ---- trial, commit, revert, copy ------------------------------------------------------------------------------------


def test_a_reverted_trial_leaves_no_trace():
    one, two = squama.law(SKIN, mu=0.3), squama.law(SKIN, mu=0.3)
    for k, p in ((1.0, 3.0), (2.0, 4.5), (2.0, 2.0)):
        for off in (0.7, -2.0):
            one.trial(k + off, p - off)
            one.tangent()
            one.revert()
        found = [law.trial(k, p) for law in (one, two)]
        assert np.array_equal(*found)
        assert np.array_equal(one.tangent(), two.tangent())
        one.commit()
        two.commit()
    assert np.array_equal(one.W_fr, two.W_fr)


def test_a_trial_starts_from_the_committed_state_and_not_from_the_last_trial():
    law = squama.law(SKIN, mu=0.3)
    direct = law.trial(0.0, 4.0)
    law.trial(0.0, 5.0)
    assert np.array_equal(law.trial(0.0, 4.0), direct)
    law.trial(0.0, 5.0)
    law.commit()
    # friction: on the way back there is less torque
    assert law.trial(0.0, 4.0)[1] < 0.99 * direct[1]


def test_a_copy_goes_its_own_way():
    law = squama.law(SKIN, mu=0.3)
    law.trial(0.0, 4.0)
    law.commit()
    other = law.copy()
    other.trial(2.0, 4.0)
    other.commit()
    assert (law.kappa[0], other.kappa[0]) == (0.0, 2.0)
    assert np.array_equal(law.trial(2.0, 4.0), other.trial(2.0, 4.0))


def test_cells_are_each_for_itself():
    rng = np.random.default_rng(3)
    kappa, Phi = rng.uniform(-4, 4, (2, 3, 4))
    many = stepped(squama.law(SKIN, mu=0.2, cells=4), kappa, Phi)
    for i in range(4):
        one = stepped(squama.law(SKIN, mu=0.2), kappa[:, i], Phi[:, i])
        assert np.array_equal(many[:, :, i], one[:, :, 0])


def test_a_snapshot_is_written_to_its_end():
    beams = squama.law(SKIN, mu=0.2)._beams
    leg = onward.onward(beams, onward.at_rest(beams, 1), np.zeros((1, 2)), np.array([[0.0, 0.1]]))
    # the last number is a part of a plate, which is above 0
    assert 0 < leg.snapshots[0, -1] < 1


def test_what_has_no_state_is_named():
    law = squama.law(SKIN, mu=0.2, cells=4)
    M, T = law.trial([0.0, np.nan, 100.0, 200.0], 4.0)
    assert law.end.tolist() == ["", "out of range", "side entry", "out of range"]
    assert np.isfinite(M).tolist() == np.isfinite(T).tolist() == [True, False, False, False]
    assert np.isfinite(law.tangent()).all(axis=(1, 2)).tolist() == [True, False, False, False]
    law.commit()
    assert law.Phi.tolist() == [4.0, 0.0, 0.0, 0.0]
    M, T = law.trial(0.0, [4.0, 3.0, 3.0, 3.0])
    assert law.end.tolist() == [""] * 4
    assert T[1] == T[2] == T[3] > 0


# ---- tangents, work -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("mu", [0.0, 0.25])
def test_tangents_are_slopes_of_trials(mu):
    for here, there in ([(0, 0), (1.0, 4.1)], [(1.0, 4.1), (2.5, 4.3)], [(2.5, 4.3), (2.3, 3.1)], [(0, 0), (1, 1)]):
        law = squama.law(SKIN, mu=mu)
        law.trial(*here)
        law.commit()
        law.trial(*there)
        found, h = law.tangent()[0], 1e-5 / D
        for axis in range(2):
            off = h * np.eye(2)[axis]
            up, down = (np.ravel(law.trial(*(there + s * off))) for s in (1, -1))
            # tolerance: increments change with the way, and with them the fifth digit of a load
            assert (up - down) / (2 * h) == pytest.approx(found[:, axis], abs=2e-3 * np.abs(found).max())
        if mu == 0:
            assert found[0, 1] == pytest.approx(found[1, 0], rel=1e-9)


def test_at_rest_the_tangent_is_the_bare_beam():
    law = squama.law(SKIN, mu=0.2)
    K = law.tangent()[0]
    M, T = law.trial(1e-3, 0.0)
    assert np.array([M[0], T[0]]) / 1e-3 == pytest.approx(K[:, 0], rel=1e-9)
    law.revert()
    assert np.array_equal(law.tangent()[0], K)
    # free to bow it has the rigidity of a twist
    rigidity = K[1, 1] - K[0, 1] * K[1, 0] / K[0, 0]
    assert rigidity == pytest.approx(squama.twist(SKIN, mu=0.2, ends="endless").rigidity, rel=1e-9)


def test_a_committed_state_has_the_tangent_of_its_leg():
    law = squama.law(SKIN, mu=0.2)
    law.trial(1.0, 4.0)
    K = law.tangent()
    law.commit()
    assert np.array_equal(law.tangent(), K)
    law.trial(1.0, 4.0)
    assert np.array_equal(law.tangent(), K)


def test_work_is_stored_or_rubbed_away():
    law = squama.law(SKIN, mu=0.25)
    corners = np.array([(0, 0), (1.5, 3.5), (1.5, 4.5), (3, 4.5), (3, 1), (0, 0)])
    s = np.arange(0, 5, 0.01)
    kappa, Phi = (np.interp(s, np.arange(6), v) for v in corners.T)
    M, T = stepped(law, kappa, Phi)
    work = np.trapezoid(M[:, 0], kappa) + np.trapezoid(T[:, 0], Phi)
    # tolerance: trapezia over kinks at contacts and corners
    assert law.U_el[0] + law.W_fr[0] + law.W_snap[0] == pytest.approx(work, rel=2e-3)
    assert law.W_fr[0] > 0.5 * work


# ---- the table ------------------------------------------------------------------------------------------------------


def test_nodes_are_states(plane):
    law = squama.law(SKIN, mu=0)
    for i, j in ((3, 18), (16, 19), (20, 20), (10, 15)):
        M, T = law.trial(GRID[i], GRID[j])
        assert np.allclose(plane.loads(GRID[i], GRID[j]), (M[0], T[0]), rtol=1e-9, atol=0)
        assert plane.potential(GRID[i], GRID[j]) == pytest.approx(law.U_el[0], rel=1e-9)
    assert set(np.unique(plane.data.state)) == {"open", "sliding"}


def test_moment_and_torque_are_slopes_of_one_potential(plane):
    rng = np.random.default_rng(5)
    kappa, Phi = rng.uniform(-4.9, 4.9, (2, 200))
    M, T = plane.loads(kappa, Phi)
    h = 1e-5
    for found, (dk, dp) in ((M, (h, 0)), (T, (0, h))):
        slope = (plane.potential(kappa + dk, Phi + dp) - plane.potential(kappa - dk, Phi - dp)) / (2 * h)
        assert slope == pytest.approx(found, abs=1e-7 * np.abs(found).max())
    mixed = (plane.loads(kappa, Phi + h)[0] - plane.loads(kappa, Phi - h)[0]) / (2 * h)
    other = (plane.loads(kappa + h, Phi)[1] - plane.loads(kappa - h, Phi)[1]) / (2 * h)
    K = plane.tangent(kappa, Phi)
    size = np.abs(K).max()
    # tolerance: a twist rate may lie within h of a node, where second slopes jump
    assert np.median(np.abs(mixed - other)) < 1e-8 * size
    assert np.abs(K[:, 0, 1] - K[:, 1, 0]).max() <= 1e-8 * size
    assert mixed == pytest.approx(K[:, 0, 1], abs=1e-4 * size)


def test_between_nodes_the_table_is_near_the_law(plane):
    rng = np.random.default_rng(6)
    kappa, Phi = rng.uniform(-4.9, 4.9, (2, 60))
    own = squama.law(SKIN, mu=0, cells=60).trial(kappa, Phi)
    for ours, table in zip(own, plane.loads(kappa, Phi), strict=True):
        # tolerance: cells of the grid across which scales engage
        assert np.abs(ours - table).max() < 0.02 * np.abs(ours).max()
        assert np.median(np.abs(ours - table)) < 1e-4 * np.abs(ours).max()
    assert np.isnan(plane.potential(6.0, 0.0))


def test_loads_alone_are_twist_bend_and_cycles(alone):
    half = GRID[GRID >= 0]
    for name, strain, load in (("T", "Phi", squama.twist), ("M", "kappa", squama.bend)):
        r = load(SKIN, mu=0.25, ends="endless", at=half)
        own = alone.data[name].sel(branch="loading").values[GRID >= 0]
        # tolerance: a curve has stations of its own between those that are asked for
        assert own == pytest.approx(r[name].values, abs=1e-6 * float(r[name].max()))
        assert alone.data[strain].values == pytest.approx(GRID)
    r = squama.cycle(SKIN, "5 rad/m", mu=0.25, ends="endless", points=201)
    back = r.isel(point=slice(int(r.Phi.values.argmax()), None))
    down = np.interp(half, back.Phi.values[::-1], back["T"].values[::-1])
    own = alone.data["T"].sel(branch="unloading").values[GRID >= 0]
    # tolerance: a line between the points of a history
    assert own == pytest.approx(down, abs=2e-3 * down.max())
    assert own[7] < 0.9 * alone.data["T"].sel(branch="loading").values[17]


def test_from_so_many_scales_on_the_table_is_good_to_about_a_tenth(plane):
    n = int(plane.data.attrs["scales_for_10_percent"])
    for ends, low, high in ((n, 0.85, 1), (n // 3, 0, 0.85)):
        r = squama.row(SKIN, scales=ends, mu=0, to="0.1 rad/pitch", points=11)
        assert low < float((r["T"] / r.T_periodic)[-1]) < high


# ---- files ----------------------------------------------------------------------------------------------------------


def keywords(text, comment, mark):
    """Return the data lines of a file by the keyword line before them."""
    found, key = {}, ""
    for line in text.splitlines():
        if line.startswith(comment):
            continue
        if line.startswith(mark):
            key = line
            while key in found:
                key += " "
            found[key] = []
        elif line.strip():
            found[key].append([float(v) for v in re.split(r"[,\s]+", line.strip())])
    return {key: np.array(v) if len({*map(len, v)}) == 1 else v for key, v in found.items()}


def said(text):
    """Check what every file says."""
    assert "endless beam; good to 10 % from 15 scales on" in text
    assert f"squama {squama.__version__}" in text
    assert "strain limit: 15 rad/m" in text


def test_csv_of_a_plane_and_of_loads_alone(plane, alone, tmp_path):
    text = plane.save(tmp_path / "law.csv").read_text(encoding="utf-8")
    said(text)
    rows = list(csv.reader(io.StringIO("\n".join(line for line in text.splitlines() if line[0] != "#"))))
    assert rows[0][:4] == ["kappa (rad/m)", "Phi (rad/m)", "w (J/m)", "M (N m)"]
    assert np.array([row[2] for row in rows[1:]], float).tolist() == plane.data.w.values.ravel().tolist()
    text = alone.save(tmp_path / "alone.csv").read_text(encoding="utf-8")
    rows = list(csv.reader(io.StringIO("\n".join(line for line in text.splitlines() if line[0] != "#"))))
    back = [float(row[3]) for row in rows if row[:2] == ["Phi", "unloading"]]
    assert back == alone.data["T"].values[1].tolist()


def test_npz_holds_the_arrays(plane, tmp_path):
    with np.load(plane.save(tmp_path / "law.npz")) as read:
        said("\n".join(read["about"]))
        for name in ("kappa", "Phi", "w", "M", "T", "dM_dPhi", "state"):
            assert np.array_equal(read[name], plane.data[name].values)


def test_an_abaqus_section(tmp_path):
    smooth = squama.law_table(SKIN, kappa=GRID, Phi=GRID, uncoupled=True)
    text = smooth.save(tmp_path / "law.inp").read_text(encoding="utf-8")
    said(text)
    found = keywords(text, "**", "*")
    head = "*BEAM GENERAL SECTION, ELSET=SQUAMA, SECTION=NONLINEAR GENERAL"
    assert [key.split(", DENSITY")[0] for key in found] == [
        head, "*AXIAL, LINEAR", "*M1, ELASTIC", "*M2, LINEAR", "*TORQUE, ELASTIC",
    ]  # fmt: skip
    for key, name in (("*M1, ELASTIC", "M"), ("*TORQUE, ELASTIC", "T")):
        assert found[key][:, 1] == pytest.approx(GRID)
        assert found[key][:, 0] == pytest.approx(smooth.data[name].values[0], rel=1e-8)
    bar = SKIN.substrate
    assert found["*AXIAL, LINEAR"] == pytest.approx(bar.youngs_modulus * bar.width * bar.thickness)
    # scales stiffen the bar around them
    assert 1 < found["*M2, LINEAR"].item() / (bar.youngs_modulus * bar.thickness * bar.width**3 / 12) < 3


def test_an_ansys_section_has_at_most_twenty_points(tmp_path):
    fine = squama.law_table(SKIN, Phi=np.linspace(0, 5, 101), uncoupled=True)
    text = fine.save(tmp_path / "law.mac").read_text(encoding="utf-8")
    said(text)
    lines = [line.split(",") for line in text.splitlines() if line[0] != "!"]
    assert lines[0] == ["SECTYPE", "1", "GENB", "ELASTIC", "SQUAMA"]
    torque = np.array([[float(v) for v in line[1:]] for line in lines if line[0] == "BSTQ"])
    assert len(torque) == 20
    own, known = fine.data["T"].values[0], np.vstack([(0, 0), torque])
    # tolerance: twenty chords of a curve
    assert np.interp(fine.data.Phi, *known.T) == pytest.approx(own, abs=2e-3 * own.max())
    # a load that the table has not is that of the beam without contact
    (bend,) = [line for line in lines if line[0] == "BSM1"]
    assert float(bend[2]) / float(bend[1]) == pytest.approx(fine.data.attrs["bare_M"], rel=1e-8)


def test_a_material_of_discrete_beams(alone, tmp_path):
    text = alone.save(tmp_path / "law.k").read_text(encoding="utf-8")
    said(text)
    found = keywords(text, "$", "*")
    cards = found["*MAT_GENERAL_NONLINEAR_6DOF_DISCRETE_BEAM"]
    assert [len(card) for card in cards] == [8, 6, 6, 6, 6, 7, 6, 6]
    assert cards[0][4] == 1
    curves = {int(v[0][0]): np.array(v[1:]) for key, v in found.items() if key.startswith("*DEFINE_CURVE")}
    for place, name, strain in ((3, "T", "Phi"), (4, "M", "kappa")):
        for branch, card in enumerate(cards[1:3]):
            curve = curves[int(card[place])]
            assert curve[:, 0] == pytest.approx(D * GRID)
            assert curve[:, 1] == pytest.approx(alone.data[name].values[branch], rel=1e-10)
            assert (np.diff(curve[:, 1]) > 0).all(), strain
    # what is linear has one curve both ways
    assert [cards[1][i] == cards[2][i] for i in range(6)] == [True, True, True, False, False, True]


# ---- refused --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"kappa": GRID, "Phi": GRID, "mu": 0.2}, "the order of bending and twisting counts"),
        ({}, "neither curvatures nor twist rates are given"),
        ({"Phi": [0, 1]}, "must be 3 to 1001 values"),
        ({"Phi": [0, 2, 1]}, "must rise"),
        ({"Phi": [0, 1, np.nan]}, "must be a finite number"),
        ({"Phi": np.linspace(0, 1, 401), "kappa": np.linspace(0, 1, 401)}, "more than 40000 nodes"),
        ({"Phi": [0, 1, 2], "mu": -1}, "mu"),
    ],
)
def test_tables_that_are_refused(given, words):
    with pytest.raises(InputError, match=words) as refused:
        squama.law_table(SKIN, **given)
    assert "\n" not in str(refused.value)


def test_laws_that_are_refused():
    for given, words in (({"cells": 0}, "cells"), ({"mu": -1}, "mu"), ({"hold": "x"}, "hold")):
        with pytest.raises(InputError, match=words):
            squama.law(SKIN, **given)
    with pytest.raises(InputError, match="an array of 3 numbers"):
        squama.law(SKIN, mu=0, cells=3).trial([1.0, 2.0], 0.0)


def test_formats_that_cannot_hold_a_table_are_refused(plane, alone, tmp_path):
    for table, name, words in (
        (plane, "law.inp", "takes each load alone"),
        (alone, "law.inp", "which knows no unloading"),
        (alone, "law.mac", "which knows no unloading"),
        (alone, "law.txt", "must be one of csv, npz, abaqus, ansys, dyna"),
    ):
        with pytest.raises(InputError, match=words):
            table.save(tmp_path / name)
    with pytest.raises(InputError, match="has no potential"):
        alone.potential(0.0, 0.0)
    assert not list(tmp_path.iterdir())

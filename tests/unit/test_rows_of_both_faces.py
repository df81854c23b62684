"""N scales on each face: symmetries, the endless beam as limit, work and energy, one answer through all doors."""

from __future__ import annotations

import json

import numpy as np
import pytest

import squama
from squama.cli import main
from squama.curves import rows
from squama.inverse.limits import refused
from squama.web import live, state

SKIN = squama.Beam.from_toml("examples/stiff_skin.toml")
TO = "0.09 rad/pitch"
DOORS = {"twisting": (squama.twist, "T", "phi_e"), "bending": (squama.bend, "M", "psi_e")}


def with_faces(faces: str, scales: int = 8) -> squama.Beam:
    return SKIN.replace(faces=faces, scales=scales)


def test_turned_faces_keep_the_axis_straight_however_the_ends_are_held():
    """Half a turn about the axis maps such a beam onto itself: a torque has no other effect than twist and stretch."""
    beam = with_faces("turned")
    free, couple, gripped = (squama.twist(beam, to=TO, points=20, ends=ends) for ends in ("free", "couple", "gripped"))
    for r in (free, couple, gripped):
        np.testing.assert_allclose(r.psi_cell, 0, atol=1e-10)
        np.testing.assert_allclose(r.N_other, r.N, rtol=1e-8, atol=1e-12)
        np.testing.assert_allclose(r["T"], free["T"], rtol=1e-9)
    assert float(free.phi_e_other) == float(free.phi_e)
    assert float(free.N.max()) > 0


def test_mirrored_faces_answer_a_force_up_as_one_down():
    beam = with_faces("mirrored")
    up, down = (squama.load(beam, f"0.2 N {way} at tip", points=15) for way in ("up", "down"))
    np.testing.assert_allclose(down.F, up.F, rtol=1e-9)
    np.testing.assert_allclose(down.travel, up.travel, rtol=1e-8)
    np.testing.assert_allclose(down.N_other, up.N, rtol=1e-6, atol=1e-9)
    np.testing.assert_allclose(down.y_axis, -up.y_axis, atol=1e-9)
    assert float(np.nanmax(up.N)) > 0
    assert float(np.nanmax(np.abs(up.N_other))) == 0
    # friction, plates, joints and bar together take the work of the force
    work, length = np.trapezoid(up.F, up.travel), beam.pitch * beam.scales
    kept = float((up.U_el + up.W_fr + up.W_snap)[-1]) * length
    assert kept == pytest.approx(work, rel=2e-2)
    assert abs(float(up.energy_error)) < 3e-4


@pytest.mark.parametrize("faces", ["mirrored", "turned"])
def test_a_cell_far_from_free_ends_is_one_of_the_endless_beam(faces):
    """All cells bear the torque of the beam; end effects fall to a third from a scale to the next one."""
    r = squama.twist(with_faces(faces, 40), to=TO, points=30)
    middle = {name: float(r[name][-1, 19]) for name in ("phi_cell", "psi_cell", "theta", "theta_other", "N")}
    endless = SKIN.replace(faces=faces, scales=None)
    alone = squama.twist(endless, at=[middle["phi_cell"] / endless.pitch])
    assert float(alone["T"][0]) == pytest.approx(float(r["T"][-1]), rel=1e-5)
    assert float(alone.psi[0]) == pytest.approx(middle["psi_cell"], rel=1e-4, abs=1e-9)
    for name in ("theta", "theta_other", "N"):
        assert float(alone[name][0]) == pytest.approx(middle[name], rel=1e-5)


@pytest.mark.parametrize("faces", ["mirrored", "turned"])
def test_every_door_gives_one_answer(faces):
    beam = with_faces(faces, 6)
    curve = squama.twist(beam, at=[0.09 / beam.pitch])
    loop = squama.cycle(beam, [TO, "0 rad/pitch"], points=20)
    path = squama.bend_twist(beam, f"twist {TO}", points=20)
    top = int(loop.phi.values.argmax())
    for found, i in ((loop, top), (path, -1)):
        assert float(found["T"][i]) == pytest.approx(float(curve["T"][0]), rel=1e-5)
        for name in ("theta", "theta_other", "N"):
            np.testing.assert_allclose(found[name][i], curve[name][0], rtol=1e-4, atol=1e-9)
        assert abs(float(found.energy_error)) < 1e-4
    drawn = squama.view(beam, to=TO).state
    assert drawn.torque == pytest.approx(float(curve["T"][0]), rel=1e-3)
    assert len(drawn.each) == len(drawn.other.each) == 6
    # a part that is turned by its far end, with the couple that does work on this turn alone
    couple = squama.twist(beam, to=TO, points=20, ends="couple")
    turned = squama.load(beam, f"{6 * 0.09} rad twist", points=20)
    assert float(turned.moment[-1]) == pytest.approx(float(couple["T"][-1]), rel=1e-5)


def test_mirrored_faces_exchange_their_parts_with_the_sense_of_twist():
    beam = with_faces("mirrored", 6)
    plus, minus = (squama.twist(beam, to=TO, points=15, sense=sense) for sense in "+-")
    for name in ("T", "theta", "theta_other", "N", "stress", "stress_other"):
        np.testing.assert_allclose(minus[name], plus[name], rtol=1e-7, atol=1e-9, err_msg=name)
    assert float(minus.decay) == pytest.approx(float(plus.decay), rel=1e-6)
    there_and_back = squama.cycle(beam, [TO, "-0.09 rad/pitch", TO], points=15)
    np.testing.assert_allclose(there_and_back["T"].min(), -there_and_back["T"].max(), rtol=1e-5)


def test_a_graded_part_has_scales_of_each_cell_on_both_faces():
    beam = with_faces("turned", 4)
    alike = squama.load(beam, "25 deg bend", points=10)
    graded = squama.load(beam, "25 deg bend", points=10, along={"scale.theta0": ["20 deg"] * 4})
    np.testing.assert_allclose(graded.moment, alike.moment, rtol=1e-9)
    lower = squama.load(beam, "25 deg bend", points=10, along={"scale.theta0": ["20 deg"] * 2 + ["19 deg"] * 2})
    assert float(lower.theta[0, 3]) == float(lower.theta_other[0, 3]) == pytest.approx(np.radians(19))


def test_the_summary_names_both_faces_and_the_endless_beam(tmp_path, capsys):
    file = tmp_path / "beam.toml"
    file.write_text(with_faces("turned").to_toml(), encoding="utf-8")
    assert main(["twist", str(file), "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["ends"] == "free"
    assert {"theta_other", "N_other", "stress_other"} <= told["each"].keys()
    assert main(["twist", str(file)]) == 0
    said = capsys.readouterr().out
    assert "on both faces (turned); 8 scales with free ends" in said
    assert "endless beam" in said


@pytest.mark.parametrize("load", ["twisting", "bending"])
@pytest.mark.parametrize("faces", ["mirrored", "turned"])
def test_sweeps_have_the_figures_of_curves(faces, load, tmp_path):
    beam, (door, T, e) = with_faces(faces), DOORS[load]
    angle = np.degrees(beam.scale.alpha)
    ranges = {"scale.alpha": [f"{angle - 1} deg", f"{angle} deg"]}
    swept = squama.sweep(beam, ranges, at=TO, load=load, out=tmp_path / "map.zarr").isel(alpha=1)
    endless, own = (door(beam, at=[TO], ends=ends).isel(point=0) for ends in ("endless", "free"))
    stress = np.fmax(endless.stress, endless.stress_other)
    for name, wanted in ((e, endless[e]), ("torque", endless[T]), ("N", endless.N), ("stress", stress)):
        assert float(swept[name]) == pytest.approx(float(wanted), rel=1e-5), name
    assert float(swept.finite_torque) == pytest.approx(float(own[T]), rel=1e-2)
    assert float(swept.finite_ratio) < 0.95


def test_arrays_of_designs_take_both_faces():
    beam = with_faces("turned")
    d = beam.pitch
    ratios = {
        "eta": beam.eta, "beta": beam.beta, "lam": beam.lam, "zeta": beam.zeta, "alpha": beam.scale.alpha,
        "theta0": beam.scale.theta0, "thickness": beam.scale.thickness / d, "width": beam.substrate.width / d,
        "nu": beam.substrate.poisson_ratio, "mu": beam.friction.mu, "modulus_ratio": beam.modulus_ratio,
        "scale_nu": beam.scale.nu,
    }  # fmt: skip
    found = squama.response([0.045, 0.09], **ratios, faces="turned")
    curve = squama.twist(beam.replace(scales=None), at=[TO]).isel(point=0)
    unit = beam.substrate.youngs_modulus * d**3
    assert float(found.torque[-1]) * unit == pytest.approx(float(curve["T"]), rel=1e-6)
    assert float(found.torque[-1]) > 4 * float(squama.response([0.045, 0.09], **ratios).torque[-1])
    with pytest.raises(squama.InputError, match="does not say where scales are"):
        squama.response([0.1], **ratios, faces="both")


def test_designs_on_both_faces_are_printed_without_a_mould():
    assert refused(with_faces("turned"), {}) == refused(with_faces("one"), {}) == []


def test_a_shift_of_half_a_pitch_is_not_followed_by_n_scales():
    assert not rows.shifted(with_faces("turned"))
    with pytest.warns(squama.ResultWarning, match="opposite each other"):
        shifted = squama.twist(with_faces("turned, shifted", 4), to=TO, points=10)
    plain = squama.twist(with_faces("turned", 4), to=TO, points=10)
    np.testing.assert_array_equal(shifted["T"], plain["T"])


@pytest.mark.parametrize("faces", ["mirrored", "turned"])
def test_the_explorer_draws_both_faces(faces):
    beam = with_faces(faces)
    now = state.of(beam)
    assert state.read(state.query(now)) == now
    scene = live.scene(now)
    assert scene["design"]["other"]["shift"] == 0
    assert scene["state"]["other"]["name"] == ("sliding" if faces == "turned" else "free")
    curve = squama.twist(beam, at=[now.twist / beam.pitch], ends="endless")
    told = dict(live.readings(now))
    assert told["stress"] == live.quantity(float(np.fmax(curve.stress, curve.stress_other)[0]), "Pa")
    # hinges have the scaled face alone here
    assert now.beside is None
    for name, text in (("joint", "hinge"), ("law", "plate")):
        with pytest.raises(squama.InputError, match="is not covered by the explorer on hinges"):
            now.change(name, text)
    with pytest.raises(squama.InputError, match="is not covered by the explorer on hinges"):
        state.read(state.query(now).replace("joint=compliant", "joint=hinge"))
    frames = live.swing(now).frames
    assert all(frame["state"]["other"]["load"] == frame["state"]["load"] for frame in frames)


def test_sweeps_tell_the_face_that_touches_first(tmp_path):
    beam = with_faces("mirrored", 6)
    angle = np.degrees(beam.scale.alpha)
    ranges = {"scale.alpha": [f"{angle - 1} deg", f"{angle} deg"]}
    swept = squama.sweep(beam, ranges, at=TO, sense="-", out=tmp_path / "map.zarr").isel(alpha=1)
    curve = squama.twist(beam, at=[TO], sense="-", ends="endless").isel(point=0)
    assert float(swept.N) == pytest.approx(float(curve.N), rel=1e-5)
    assert float(curve.N) > 0


@pytest.mark.parametrize("faces", ["mirrored", "turned"])
def test_pictures_have_each_face_as_it_sees_the_bar(faces):
    beam = with_faces(faces, 6)
    signs = [*beam.other.seen, 1]
    part = squama.Part(beam, "30 deg twist")
    for shown in (squama.view(beam, to=TO).state, squama.view_part(part, points=6).state):
        np.testing.assert_allclose(shown.other.strains, np.array(shown.strains) * signs, rtol=1e-9, atol=1e-12)
        assert np.abs(shown.strains).max() > 0
    shape = squama.plot.part_figure(squama.load(part, points=6)).axes[0]
    lines = [line.get_ydata() for line in shape.get_lines()]
    # scales stand off either face of the bar, which is 14 mm thick
    assert min(np.nanmin(y) for y in lines) < -10
    assert max(np.nanmax(y) for y in lines) > 10

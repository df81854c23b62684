"""A beam with a number of scales: every door answers with all of them, between ends."""

from __future__ import annotations

import json
from functools import partial

import numpy as np
import pytest

import squama
from squama.cli import main

SKIN = squama.Beam.from_toml("examples/stiff_skin.toml").replace(scales=6)
FAR = 0.09 / SKIN.pitch


def test_the_same_question_through_every_door():
    """Torque, frictional work and twists of the cells: a curve, a row, a history, a part whose end is turned."""
    curve = squama.twist(SKIN, at=[FAR], ends="couple").isel(point=0)
    row = squama.row(SKIN.replace(scales=None), scales=6, to=FAR, points=60, ends="couple").isel(point=-1)
    history = squama.cycle(SKIN, FAR, points=40, ends="couple")
    top = history.isel(point=int(np.argmax(history.Phi.values)))
    part = squama.load(SKIN, f"{FAR * SKIN.length} rad twist", points=30).isel(point=-1)
    for other in (row, top):
        assert float(other["T"]) == pytest.approx(float(curve["T"]), rel=2e-5)
        assert float(other.W_fr) == pytest.approx(float(curve.W_fr), rel=1e-3)
        np.testing.assert_allclose(other.theta, curve.theta, rtol=1e-4)
        np.testing.assert_allclose(other.phi_cell, curve.phi_cell, rtol=1e-4)
    assert float(part.moment) == pytest.approx(float(curve["T"]), rel=2e-5)
    np.testing.assert_allclose(part.phi_cell, curve.phi_cell, rtol=1e-4)


@pytest.mark.parametrize("ends", ["free", "couple", "gripped", "equal"])
def test_the_work_of_the_torque_is_stored_or_rubbed(ends):
    r = squama.twist(SKIN, to=FAR, points=160, ends=ends)
    np.testing.assert_allclose(np.trapezoid(r["T"], r.Phi), (r.U_el + r.W_fr + r.W_snap)[-1], rtol=2e-3)
    assert abs(float(r.energy_error)) < 1e-4
    assert r.attrs["ends"] == ends
    if ends == "free":
        # the mean of the cells is the twist of the ends
        np.testing.assert_allclose(r.phi_cell.mean("scale"), r.phi, rtol=1e-6, atol=1e-12)


def test_ends_take_torque_and_damping_away():
    own, endless = (squama.twist(SKIN, at=[FAR], ends=ends) for ends in ("free", "endless"))
    assert float(own["T"][0]) < 0.9 * float(endless["T"][0])
    assert float(own.T_periodic[0]) == pytest.approx(float(endless["T"][0]), rel=1e-4)
    assert float(own.theta_periodic[0]) == pytest.approx(float(endless.theta[0]), rel=1e-4)
    assert "scale" not in endless.dims
    loop, whole = (squama.cycle(SKIN, FAR, points=20, ends=ends) for ends in ("free", "endless"))
    assert 0 < float(loop.zeta_eq[0]) < 0.8 * float(whole.zeta_eq[0])
    assert loop.theta.dims == ("point", "scale")
    assert abs(float(loop.energy_error)) < 1e-4


def test_a_moment_bends_all_scales():
    r = squama.bend(SKIN, to=FAR, points=40)
    assert r.theta.dims == ("point", "scale")
    np.testing.assert_allclose(r.psi_cell.mean("scale"), r.psi, rtol=1e-6, atol=1e-12)
    endless = squama.bend(SKIN, at=[FAR], ends="endless")
    assert float(r.M_periodic[-1]) == pytest.approx(float(endless.M[0]), rel=1e-4)
    assert float(r.M[-1]) < 0.95 * float(endless.M[0])
    np.testing.assert_allclose(np.trapezoid(r.M, r.kappa), (r.U_el + r.W_fr)[-1], rtol=2e-3)


def test_several_frictions_and_places_beyond_the_end():
    r = squama.twist(SKIN, mu=[0.0, 0.4], at=[FAR, 20.0])
    assert r.theta.dims == ("mu", "point", "scale")
    assert (r.W_fr[:, 0] == 0).values.tolist() == [True, False]
    # 0.4 rad per pitch is beyond the 0.3 to which a curve goes by itself, but not beyond the one that is asked
    assert np.isfinite(r["T"][:, 0]).all()
    far = squama.twist(SKIN, at=[FAR, 20.0], to=FAR)
    assert np.isfinite(far["T"]).values.tolist() == [True, False]
    assert np.isnan(far.theta[1]).all()


def test_the_number_of_scales():
    assert squama.Beam.from_ratios().scales is None
    assert squama.Beam.from_ratios(scales=7).scales == 7
    endless = SKIN.replace(scales="endless")
    assert endless.scales is None
    assert (endless.pitches, endless.length) == (25, 25 * SKIN.pitch)
    for beam in (endless, SKIN, SKIN.replace(ends="gripped")):
        assert squama.Beam.from_toml_text(beam.to_toml()) == beam
    text = SKIN.to_toml().replace("scales = 6", 'scales = "endless"')
    assert squama.Beam.from_toml_text(text) == endless
    with pytest.raises(squama.InputError, match='is neither a whole number from 2 to 1000000 nor "endless"'):
        SKIN.replace(scales="many")
    with pytest.raises(squama.InputError, match=r'beam\.ends = "loose": must be one of "free", "couple", "gripped"'):
        SKIN.replace(ends="loose")


def test_who_answers_with_ends():
    few = {"to": "0.03 rad/pitch", "points": 3}
    assert squama.twist(SKIN.replace(ends="gripped"), **few).attrs["ends"] == "gripped"
    # a moment has no use for grips
    assert squama.bend(SKIN.replace(ends="gripped"), **few).attrs["ends"] == "free"
    for beam, how in (
        (SKIN.replace(scales=None), {}),
        (SKIN.replace(scales=201), {}),
        (SKIN.replace(faces="turned"), {"joint": "hinge"}),
        (SKIN, {"joint": "hinge"}),
        (SKIN, {"ends": "endless"}),
    ):
        assert "scale" not in squama.twist(beam, **few, **how).dims


@pytest.mark.parametrize(
    ("door", "beam", "ends", "words"),
    [
        (squama.twist, SKIN.replace(scales=None), "free", "needs a number of scales, and this beam is endless"),
        (squama.bend, SKIN, "gripped", "is not known of a beam that is loaded so"),
        (squama.twist, SKIN, "held", 'must be one of "free", "couple", "gripped", "equal", "endless"'),
        (partial(squama.twist, joint="hinge"), SKIN.replace(faces="turned"), "equal", "takes scales on one face"),
        (squama.twist, SKIN.replace(hold="bend"), "gripped", "the cells' bend is held"),
    ],
)
def test_ends_that_are_refused(door, beam, ends, words):
    with pytest.raises(squama.InputError, match=words):
        door(beam, ends=ends, to="0.05 rad/pitch")


def test_a_history_on_hinges_has_no_ends():
    with pytest.raises(squama.InputError, match="is not known of a row on hinges"):
        squama.cycle(SKIN, "0.05 rad/pitch", joint="hinge", ends="equal")
    with pytest.raises(squama.InputError, match="is not known of a row on hinges"):
        squama.bend(SKIN, joint="hinge", ends="equal")


def test_the_commands(tmp_path, capsys):
    file, table = tmp_path / "beam.toml", tmp_path / "curve.csv"
    SKIN.to_toml(file)
    given = [str(file), "--to", "0.1 rad/pitch"]
    assert (
        main(["twist", *given, "--points", "20", "--csv", str(table), "--plot", str(tmp_path / "p.png"), "--compare"])
        == 0
    )
    said = capsys.readouterr().out
    own = squama.twist(SKIN, to="0.1 rad/pitch", points=20)
    T = 1e3 * float(own["T"][-1])
    assert "6 scales with free ends" in said
    assert f"6 scales with free ends: {T:.3g} N mm" in said
    assert "of the endless beam's torque and" in said
    lines = [line for line in table.read_text().splitlines() if not line.startswith("#")]
    assert len(lines) == 1 + 20 * 6
    assert main(["twist", *given, "--json", "--points", "20"]) == 0
    record = json.loads(capsys.readouterr().out)
    assert np.shape(record["each"]["theta"]) == (20, 6)
    np.testing.assert_allclose(record["curve"]["theta"], np.mean(record["each"]["theta"], axis=1))
    assert record["bench"]["scales"] == 6
    assert record["bench"]["row"]["torque"] < record["bench"]["endless"]["torque"]
    assert main(["twist", *given, "--ends", "endless"]) == 0
    assert "compliant joints; endless beam; torque" in capsys.readouterr().out
    assert main(["cycle", *given, "--points", "10"]) == 0
    assert "6 scales with free ends" in capsys.readouterr().out
    assert main(["bend", *given, "--ends", "gripped"]) == 2
    assert capsys.readouterr().err.startswith('squama: error: --ends = "gripped": is not known of a beam')
    assert main(["twist", *given, "--joint", "hinge", "--ends", "free"]) == 2
    assert capsys.readouterr().err.startswith('squama: error: --ends = "free": is not available on hinges')


@pytest.mark.slow
def test_tolerances_have_the_nominal_beam_with_its_own_scales(capsys, tmp_path):
    vary = {"scale.alpha": "+- 1 deg"}
    few = {"samples": 3200, "at": "0.09 rad/pitch"}
    u = squama.uncertainty(SKIN, vary, **few)
    own = squama.twist(SKIN, to=FAR)
    assert (u.attrs["ends"], u.attrs["own_scales"]) == ("free", 6)
    for figure, name in (("torque", "T"), ("stress", "stress"), ("stiffness_ratio", "stiffness_ratio")):
        last = own[name][-1]
        expected = float(last.max("scale") if "scale" in last.dims else last)
        assert float(u.own.sel(figure=figure)) == pytest.approx(expected, rel=1e-6)
    # the ends take torque away, and the scales that bear it are stressed more
    ratio = u.own / u.nominal
    assert float(ratio.sel(figure="torque")) < 0.9
    assert float(ratio.sel(figure="stress")) > 1
    assert float(ratio.sel(figure="rigidity")) == pytest.approx(1, rel=1e-12)
    assert "own" not in squama.uncertainty(SKIN.replace(scales=None), vary, **few)
    file = tmp_path / "beam.toml"
    SKIN.to_toml(file)
    assert main(["uncertainty", str(file), "--vary", "scale.alpha=+- 1 deg", "--samples", "3200", "--full"]) == 0
    said = capsys.readouterr().out
    assert "6 scales: the nominal beam with free ends; all other columns are endless" in said


@pytest.mark.parametrize("load", ["twist", "bend"])
def test_of_itself_a_curve_goes_as_far_as_the_model_holds_of_every_cell(load):
    r, cell = getattr(squama, load)(SKIN, points=30), {"twist": "phi_cell", "bend": "psi_cell"}[load]
    angle = cell.removesuffix("_cell")
    # the first and last cell, which touch on one side only, are the softest: the mean is less
    assert 0.29 < float(r[cell].max()) <= 0.3 * (1 + 1e-9)
    assert float(r[f"{angle}_end"]) == pytest.approx(float(r[angle][-1]), rel=1e-3)
    assert float(r[angle][-1]) < 0.28
    assert r.end == "range end"
    assert "trust the curve" not in r.attrs["warnings"]
    assert np.isfinite(r[{"twist": "T", "bend": "M"}[load]]).all()
    farther = getattr(squama, load)(SKIN, points=30, to="0.29 rad/pitch")
    assert float(farther[cell].max()) > 0.31
    assert "trust the curve up to" in farther.attrs["warnings"]


@pytest.mark.slow
def test_scales_that_slide_off_take_others_with_them():
    """At .285 rad per pitch one scale near the end runs off its edge; as it falls the one before it does, too."""
    r = squama.twist(SKIN.replace(scales=25), to="0.3 rad/pitch", points=40)
    assert r.end == "range end"
    assert float(r.W_snap[-1]) > 0
    assert abs(float(r.energy_error)) < 1e-4

"""Sweeps and tolerances on compliant joints: each cell is its beam's curve; what is chosen, said, kept and refused."""

from __future__ import annotations

import itertools
import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import squama
from squama.cli import main
from squama.errors import InputError
from squama.joints import choice, law
from squama.study import slices
from squama.study.models import Model, Twist
from squama.study.plan import OWN, VARIABLES
from squama.study.sweeping import make_plan, run

BEAM = squama.Beam.from_toml("examples/stiff_skin.toml").replace(scales=None).replace(scale={"strength": 1e8})
RANGES = {"mu": (0.1, 0.5, 5), "scale.length": ("36 mm", "52 mm", 4)}
AT = "0.09 rad/pitch"
FIGURES = {
    "torque": "T", "tangent": "K_t", "stiffness_ratio": "stiffness_ratio", "N": "N", "stress": "stress", "W_fr": "W_fr",
    "U_el": "U_el", "RED": "RED",
}  # fmt: skip
UNKNOWN = squama.Beam.from_ratios(theta0="2 deg", mu=0.3)


def contents(store: Path) -> dict[str, bytes]:
    return {str(p.relative_to(store)): p.read_bytes() for p in sorted(store.rglob("*")) if p.is_file()}


def swept(beam: squama.Beam, length: float, mu: float) -> squama.Beam:
    return beam.replace(scale={"length": length}, friction={"mu": mu})


@pytest.mark.parametrize("how", [{}, {"ideal": True}, {"sense": "-"}], ids=str)
def test_every_cell_is_the_curve_of_its_beam(how: dict[str, object], tmp_path: Path) -> None:
    data = squama.sweep(BEAM, RANGES, at=AT, out=tmp_path / "map.zarr", **how)
    for i, j in ((0, 0), (4, 1), (2, 3)):
        cell = data.isel({"mu": i, "scale.length": j})
        r = squama.twist(swept(BEAM, float(cell["scale.length"]), float(cell.mu)), to=AT, points=181, **how)
        assert slices.ends(cell) == r.end.item()
        for name, own in FIGURES.items():
            rel = 4e-3 if name in ("tangent", "stiffness_ratio") else 2e-3
            assert float(cell[name]) == pytest.approx(float(r[own][-1]), rel=rel, nan_ok=True), name
        if r.end.item() != "no engagement":
            assert float(cell.phi_e) == pytest.approx(float(r.phi_e))


@pytest.mark.parametrize("how", [{}, {"ideal": True}], ids=str)
def test_every_bent_cell_is_the_curve_of_its_beam(how: dict[str, object], tmp_path: Path) -> None:
    data = squama.sweep(BEAM, RANGES, load="bending", at=AT, out=tmp_path / "map.zarr", **how)
    assert list(data.data_vars) == [*(v for v in VARIABLES["compliant", "bending"] if v not in OWN), "status"]
    assert data.attrs["joint"] == "compliant"
    for i, j in ((0, 0), (4, 1), (2, 3)):
        cell = data.isel({"mu": i, "scale.length": j})
        r = squama.bend(swept(BEAM, float(cell["scale.length"]), float(cell.mu)), to=AT, points=181, **how)
        assert slices.ends(cell) == r.end.item()
        for name, own in {**FIGURES, "torque": "M", "tangent": "K_b"}.items():
            # tolerance: slopes by differences just behind engagement, 0.4 % measured, on every processor
            rel = 1e-2 if name in ("tangent", "stiffness_ratio") else 2e-3
            assert float(cell[name]) == pytest.approx(float(r[own][-1]), rel=rel, nan_ok=True), name
        assert float(cell.psi_e) == pytest.approx(float(r.psi_e), rel=1e-6)
        assert float(cell.rigidity) == pytest.approx(r.attrs["rigidity"], rel=1e-9)


@pytest.mark.slow
def test_bent_samples_are_curves(tmp_path: Path) -> None:
    u = squama.uncertainty(BEAM, {"mu": "+- 0.1", "theta0": "+- 1 deg"}, load="bending", at=AT, samples=3200, keep=True)
    one = u.isel(sample=7)
    factor = float(one["joint.factor"])
    own = BEAM.replace(friction={"mu": float(one["friction.mu"])}, scale={"theta0": float(one["scale.theta0"])})
    r = squama.bend(own, to=AT, points=181)
    # tolerance: the law's own scatter moves little of a moment
    assert float(one.torque) == pytest.approx(float(r.M[-1]), rel=1e-2 + abs(factor - 1))
    assert float(one.psi_e) == pytest.approx(float(r.psi_e), rel=1e-2)


def test_a_face_that_keeps_its_length_is_of_hinges(tmp_path: Path) -> None:
    face = BEAM.replace(substrate={"neutral": "face"})
    data = squama.sweep(face, {"mu": [0.1, 0.2]}, load="bending", out=tmp_path / "map.zarr")
    assert data.attrs.get("joint", "hinge") == "hinge"
    with pytest.raises(InputError, match='neutral = "face": must be "free" or "middle"'):
        squama.sweep(face, {"mu": [0.1, 0.2]}, load="bending", joint="compliant", out=tmp_path / "no.zarr")


def test_labels_and_attributes(tmp_path: Path) -> None:
    place = tmp_path / "map.zarr"
    data = squama.sweep(BEAM, RANGES, out=place)
    assert list(data.data_vars) == [*(v for v in VARIABLES["compliant", "twisting"] if v not in OWN), "status"]
    units = {
        name: data[name].attrs["units"] for name in ("phi_e", "torque", "tangent", "stress", "K_theta", "rigidity")
    }
    assert list(units.values()) == ["rad", "N m", "N m^2", "Pa", "N m", "N m^2"]
    meanings = data.end.attrs["flag_meanings"].split()
    assert (meanings[0], meanings[-1]) == ("not_computed", "joint_unknown")
    assert (data.attrs["joint"], data.attrs["scales"]) == ("compliant", "thick, elastic scales")
    assert "margin" not in data.attrs
    # twice its own engagement, to the last digit
    phi_e = float(squama.twist(BEAM, points=3).phi_e)
    value, unit = data.attrs["at"].split()
    assert (float(value), unit) == (pytest.approx(2 * phi_e), "rad/pitch")
    opened = squama.open_sweep(place)
    assert opened.identical(data.assign_attrs(warnings=opened.attrs["warnings"]))
    # the same call goes on, the resolved twist is the same too
    assert squama.sweep(BEAM, RANGES, out=place, at=data.attrs["at"]).identical(data)


def test_the_beam_itself_is_one_of_its_cells(tmp_path: Path) -> None:
    # it engages at half the twist, where no step may be all but nothing
    data = squama.sweep(BEAM, {"mu": [0.2, 0.25]}, out=tmp_path / "map.zarr")
    r = squama.twist(BEAM, mu=0.25, to=data.attrs["at"], points=181)
    assert float(data.torque[1]) == pytest.approx(float(r["T"][-1]), rel=1e-3)


def test_a_rate_changes_with_the_pitch_and_an_angle_does_not(tmp_path: Path) -> None:
    d = BEAM.pitch
    over = {"beam.pitch": [0.95 * d, 1.05 * d]}
    rate, angle = (
        squama.sweep(BEAM, over, at=text, out=tmp_path / f"{i}.zarr")
        for i, text in enumerate((f"{0.09 / d} rad/m", AT))
    )
    for data, twists in ((rate, (0.0855, 0.0945)), (angle, (0.09, 0.09))):
        for i, twist in enumerate(twists):
            beam = BEAM.replace(pitch=over["beam.pitch"][i])
            r = squama.twist(beam, to=f"{twist} rad/pitch", points=181)
            assert float(data.torque[i]) == pytest.approx(float(r["T"][-1]), rel=1e-3)


def test_material_of_the_scales_and_factor_of_the_joint(tmp_path: Path) -> None:
    moduli = [BEAM.scale.youngs_modulus / 2, BEAM.scale.youngs_modulus]
    data = squama.sweep(
        BEAM, {"scale.youngs_modulus": moduli, "joint.factor": [0.8, 1.0]}, at=AT, out=tmp_path / "m.zarr"
    )
    r = squama.twist(BEAM.replace(scale={"youngs_modulus": moduli[0]}), to=AT, points=181)
    assert float(data.torque[0, 1]) == pytest.approx(float(r["T"][-1]), rel=1e-3)
    np.testing.assert_allclose(data.K_theta[:, 0], 0.8 * data.K_theta[:, 1], rtol=1e-9)


def test_a_run_that_was_stopped_goes_on_byte_for_byte(tmp_path: Path) -> None:
    # strength is not reached and nothing is known of some: chunks of nothing but NaN, too
    ranges = {"mu": (0.1, 0.5, 12), "theta0": ("2 deg", "20 deg", 40)}
    whole, parts = tmp_path / "whole.zarr", tmp_path / "parts.zarr"
    data = squama.sweep(BEAM, ranges, at=AT, out=whole, tile=100)
    plan = make_plan(BEAM, ranges, at=AT, tile=100)
    assert run(plan, parts, shard="2/3")[0] < data.status.size
    assert run(plan, parts) == (data.status.size, data.status.size)
    assert contents(whole) == contents(parts)
    unknown = slices.ends(data) == "joint unknown"
    assert 0 < unknown.mean() < 1
    assert np.isnan(data.torque.values[unknown]).all()
    line = data.attrs["warnings"].splitlines()[0]
    assert (
        line
        == f"{100 * unknown.mean():.3g} % of the beams: the law of the joint does not know them: they have no figures"
    )


def test_a_plan_of_thin_scales_on_hinges_is_written_as_ever() -> None:
    plan = make_plan(BEAM, RANGES, joint="hinge")
    assert plan.model == Model()
    keys = {"format", "load", "law", "sense", "margin", "over", "tile", "versions", "beam"}
    assert set(plan.configuration) == keys
    compliant = make_plan(BEAM, RANGES)
    assert set(compliant.configuration) == {*keys, "joint", "ideal", "at"}
    assert type(plan).from_text(compliant.text).text == compliant.text


def test_thick_scales_on_hinges(tmp_path: Path) -> None:
    data = squama.sweep(BEAM, {"mu": [0.2, 0.4]}, joint="hinge", ideal=False, out=tmp_path / "m.zarr")
    r = squama.twist(BEAM, mu=0.4, joint="hinge", ideal=False, points=3)
    assert (data.attrs["joint"], data.attrs["scales"]) == ("hinge", r.attrs["scales"])
    assert float(data.phi_e[1]) == pytest.approx(float(r.phi_e))
    u = squama.uncertainty(BEAM, {"mu": "+- 0.01"}, joint="hinge", ideal=False, samples=3200)
    near = float(r.Phi_e) * (1 + np.array([1e-4, 2e-4]))
    curve = squama.twist(BEAM, at=near, joint="hinge", ideal=False)
    slope = float(2 * curve.K_t[0] - curve.K_t[1])
    assert float(u.nominal.sel(figure="K_e")) == pytest.approx(slope, rel=1e-4)


def test_without_a_joint_that_is_known_scales_are_on_hinges_and_it_is_said(tmp_path: Path) -> None:
    data = squama.sweep(UNKNOWN, {"mu": [0.1, 0.2]}, out=tmp_path / "m.zarr")
    assert data.attrs["joint"] == "hinge"
    assert data.attrs["warnings"].startswith("hinges, as the joint is not known: ")
    u = squama.uncertainty(UNKNOWN, {"mu": "+- 0.01"}, samples=3200)
    assert u.attrs["joint"] == "hinge"
    assert u.attrs["notes"].startswith("hinges, as the joint is not known: ")


Asked = Callable[..., object]
ASKED: dict[str, Asked] = {
    "sweep": lambda how: squama.sweep(BEAM, {"mu": [0.1, 0.2]}, out="m.zarr", **how),
    "uncertainty": lambda how: squama.uncertainty(BEAM, {"mu": "+- 0.1"}, samples=3200, **how),
}


@pytest.mark.parametrize("asked", ASKED)
@pytest.mark.parametrize(
    ("how", "words"),
    [
        ({"joint": "glue"}, 'joint = "glue": must be'),
        ({"joint": "compliant", "law": "plate"}, 'law = "plate": is not covered by joint="compliant"'),
        ({"joint": "hinge", "at": AT}, 'at = "0.09 rad/pitch": is for compliant joints'),
        ({"at": "5 deg"}, 'at = "5 deg": does not say over which length'),
        ({"at": 0.0}, "at = 0: must be more than 0"),
        ({"at": "200 deg/pitch"}, "must be below half a turn per pitch"),
        ({"sense": "-"}, "at: the beam itself does not engage below 17.2 deg per pitch; give the twist"),
    ],
)
def test_what_is_refused(
    asked: str, how: dict[str, object], words: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(InputError) as caught:
        ASKED[asked](how)
    assert words in str(caught.value)
    assert not list(tmp_path.iterdir())


def test_names_that_belong_to_the_other_model(tmp_path: Path) -> None:
    for over, how, words in (
        ({"margin": [0.01, 0.1]}, {}, r"margin: is of hinges' locks"),
        ({"joint.factor": [0.9, 1.1]}, {"joint": "hinge"}, r"joint\.factor: is for the compliant joint"),
    ):
        with pytest.raises(InputError, match=words):
            squama.sweep(BEAM, over, out=tmp_path / "m.zarr", **how)
    with pytest.raises(InputError, match=r"joint\.factor: is for the compliant joint"):
        squama.uncertainty(BEAM, {"joint.factor": "+- 1 %"}, joint="hinge")
    with pytest.raises(InputError, match=r"before = .*: asks for a lock"):
        squama.uncertainty(BEAM, {"mu": "+- 0.1"}, before=AT)


def test_the_commands(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.chdir(tmp_path)
    BEAM.to_toml("beam.toml")
    flags = ["--over", "mu=0.1:0.5:5", "--over", "theta0=2deg:20deg:6"]
    assert main(["sweep", "beam.toml", *flags, "-o", "map.zarr", "--at", "2.25 deg total"]) == 0
    first, at, model, *_, warning, _ = capsys.readouterr().out.splitlines()
    assert first == "beam.toml: all 30 beams are computed (5 mu x 6 theta0)"
    assert at.split() == ["figures", "at", "2.25", "deg", "total"]
    assert model.endswith("thick, elastic scales on compliant joints; endless beams")
    assert warning.endswith("the law of the joint does not know them: they have no figures")
    assert main(["sweep", "beam.toml", *flags, "-o", "map.zarr", "--at", "2.25 deg total", "--json"]) == 0
    facts = json.loads(capsys.readouterr().out)
    assert facts["joint"] == "compliant"
    assert len(facts["notes"]) == 1
    assert main(["map", "map.zarr", "--plot", "map.png", "--csv", "map.csv", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["variable"] == "stiffness_ratio"
    table = squama.read("map.csv")
    # the twist asked for comes before engagement, which is told all the same
    assert {"joint unknown", "range end"} == set(table.end.values.ravel())
    for variable in ("end", "K_theta", "stress"):
        assert main(["map", "map.zarr", "--variable", variable, "--plot", f"{variable}.svg"]) == 0
    assert main(["map", "map.zarr", "--variable", "end", "--at", "mu=0.3", "--plot", "line.svg"]) == 0
    capsys.readouterr()
    assert main(["map", "map.zarr", "--variable", "lock", "--plot", "lock.png"]) == 2
    assert "--variable = lock: must be one of phi_e, phi_end, torque" in capsys.readouterr().err
    vary = ["--vary", "scale.alpha=+- 1 deg", "--samples", "3200", "--indices", "64"]
    assert main(["uncertainty", "beam.toml", *vary, "--at", AT, "--plot", "u.png", "--csv", "u.csv", "--full"]) == 0
    out = capsys.readouterr().out
    assert "thick, elastic scales on compliant joints; endless beam" in out
    assert "note: joint.factor = normal(1, 0.01" in out
    lines = out[out.index("the nominal beam at ") :].splitlines()
    said = ("endless, free to bow", "endless, held straight")
    assert all(words in line for line, words in zip(lines[1:3], said, strict=True))
    assert "stiffness_ratio" in out
    assert "locked" not in out


# ---- tolerances ----------------------------------------------------------------------------------------------------


def test_a_map_is_cut_at_jumps_and_where_nothing_is_known(tmp_path: Path) -> None:
    beam = squama.Beam.from_toml("examples/stiff_skin.toml").replace(scales=None).replace(hold="bend, lateral bend")
    ranges = {"theta0": ("6 deg", "40 deg", 18), "eta": (2, 5, 13)}
    d = squama.sweep(beam, ranges, at="130 deg total", out=tmp_path / "m.zarr")
    known = slices.ends(d) != "joint unknown"
    columns = np.flatnonzero(known.any(axis=1))
    assert 0 < columns[0] < columns[-1] < 17, "the law ends on both sides"
    touching = d.N.values[columns] > 0
    assert 0 < touching.sum() < touching.size
    for variable, factor, unit in (("stiffness_ratio", 1, ""), ("stress", 1e-6, " (MPa)")):
        figure = squama.plot.map_figure(d, variable, x="theta0", y="eta")
        assert figure.get_suptitle().endswith("at 130 deg total")
        ax, bar = figure.axes
        assert bar.get_ylabel().replace("\n", " ").endswith(unit)
        values = factor * d[variable].values[known]
        levels = np.array([float(t.get_text()) for t in bar.get_yticklabels()])
        assert levels[0] <= values.min() * (1 + 1e-9)
        # rare extremes are left out
        assert levels[-1] >= np.quantile(values, 0.99)
        figure.canvas.draw()
        seen = np.asarray(figure.canvas.buffer_rgba())[::-1, :, :3].astype(int)
        box = ax.get_window_extent()
        inside = seen[int(box.y0) + 2 : int(box.y1) - 2, int(box.x0) + 2 : int(box.x1) - 2].reshape(-1, 3)
        # no colour of a level that no beam has
        fills = next(c for c in ax.collections if c.get_zorder() == 1)
        for low, high in itertools.pairwise(levels):
            colour = np.array(fills.cmap(fills.norm((low + high) / 2))[:3]) * 255
            if not ((values >= low) & (values <= high)).any():
                assert np.abs(inside - colour).max(axis=1).min() > 2
        # between the last beam that is known and the next there is nothing but the hatching, which is grey
        step = np.degrees(d.theta0.values[1] - d.theta0.values[0])
        for side, column in ((-0.3, columns[0]), (0.3, columns[-1])):
            across = int(ax.transData.transform((np.degrees(d.theta0.values[column]) + side * step, 3))[0])
            strip = seen[int(box.y0) + 3 : int(box.y1) - 3, across]
            assert np.ptp(strip, axis=1).max() == 0


def test_a_single_beam_among_unknown_ones_is_seen(tmp_path: Path) -> None:
    beam = squama.Beam.from_toml("examples/stiff_skin.toml").replace(scales=None)
    d = squama.sweep(beam, {"theta0": ("10 deg", "40 deg", 3), "eta": (3, 4, 3)}, at=AT, out=tmp_path / "m.zarr")
    assert (slices.ends(d) != "joint unknown").sum(axis=0).tolist() == [1, 1, 1]
    figure = squama.plot.map_figure(d, "stress", x="theta0", y="eta")
    figure.canvas.draw()
    (column, low), (_, high) = figure.axes[0].transData.transform([(25, 3), (25, 4)]).astype(int)
    seen = np.asarray(figure.canvas.buffer_rgba())[::-1, :, :3].astype(int)
    assert np.ptp(seen[low + 3 : high - 3, column], axis=1).max() > 50, "coloured"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("130 deg total", "130 deg total"), ("0.08 rad/pitch", "0.08 rad/pitch"), ("3.7 deg/pitch", "92.5 deg total"),
        ("4.5 rad/m", "4.5 rad/m"), ("2.3 rad total", "0.092 rad/pitch"), ("0.123456789 rad/pitch", "176.8 deg total"),
    ],
)  # fmt: skip
def test_a_twist_is_told_in_the_unit_in_which_it_is_round(text: str, words: str) -> None:
    twist = Twist.read("at", text, "twisting", BEAM)
    assert twist.words(BEAM.pitches) == words
    assert Twist.from_text(twist.text) == twist


@pytest.mark.slow
def test_samples_are_beams() -> None:
    vary = {"scale.alpha": "+- 2 deg", "scale.youngs_modulus": "+- 10 %", "mu": "+- 0.1", "joint.factor": "+- 5 %"}
    u = squama.uncertainty(BEAM, vary, at=AT, samples=3200, keep=True)
    for i in (0, 77, 3000):
        s = u.isel(sample=i)
        beam = BEAM.replace(
            scale={"alpha": float(s["scale.alpha"]), "youngs_modulus": float(s["scale.youngs_modulus"])},
            friction={"mu": float(s["friction.mu"])},
        )
        held = squama.twist(beam, points=3).attrs["K_theta"] * float(s["joint.factor"])
        assert float(s.K_theta) == pytest.approx(held, rel=1e-6)
        r = squama.twist(beam.replace(joint={"stiffness": held}), to=AT, points=181)
        assert s.sample_end.item() == r.end.item()
        for name, own in FIGURES.items():
            assert float(s[name]) == pytest.approx(float(r[own][-1]), rel=4e-3), name
    assert u.attrs["notes"] == "" or "joint.factor" not in u.attrs["notes"]


@pytest.mark.slow
def test_the_error_of_the_joints_law_scatters_too(monkeypatch: pytest.MonkeyPatch) -> None:
    vary = {"mu": "+- 0.05"}
    u = squama.uncertainty(BEAM, vary, at=AT, samples=3200, indices=256)
    rms = law.errors().K_theta.rms
    assert list(u.parameter.values) == ["friction.mu", "joint.factor"]
    assert u.attrs["notes"].startswith(f"joint.factor = normal(1, {rms:.6g}): how far the law of the joint was off")
    # tolerance: samples of a fixed seed, 0.1 % and 0.3 % measured
    held = u.sel(figure="K_theta")
    assert float(held["sd"] / held["mean"]) == pytest.approx(rms, rel=0.01)
    np.testing.assert_allclose(u.ST.sel(indexed="K_theta"), [0, 1], atol=0.02)
    assert 0 < float(u.ST.sel(indexed="torque", parameter="joint.factor")) < 1
    # its own share of the torque's scatter, by difference
    more = squama.uncertainty(BEAM, vary | {"joint.factor": "normal(1, 0.1)"}, at=AT, samples=3200)
    assert float(more["sd"].sel(figure="torque")) > float(u["sd"].sel(figure="torque"))
    # few samples tell which parameters there are
    monkeypatch.setattr("squama.study.tolerances.monte_carlo.FEWEST", 320)
    for known in (BEAM.replace(joint={"stiffness": 0.06}), BEAM):
        given = vary if known is not BEAM else vary | {"joint.stiffness": "normal(0.06 N m, 1 %)"}
        assert "joint.factor" not in squama.uncertainty(known, given, at=AT, samples=320, levels=[0.5]).parameter.values


def test_tolerances_across_the_end_of_the_law(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("squama.study.tolerances.monte_carlo.FEWEST", 320)
    ask = {"at": AT, "samples": 1024, "levels": [0.5]}
    # the law goes from .245 on
    u = squama.uncertainty(BEAM, {"substrate.poisson_ratio": "uniform(0.24, 0.285)"}, **ask)
    assert float(u.share.sel(figure="K_theta")) == pytest.approx(8 / 9, abs=0.02)
    assert u.attrs["known_samples"] == pytest.approx(1024 * 8 / 9, abs=20)
    # all that are known engage
    assert float(u.P_engaged) == 1
    for limits, share in (("0.235, 0.275", "2[0-9.]+"), ("0.2, 0.24", "100")):
        with pytest.raises(squama.InputError, match=f"{share} % of the samples lie outside .*, at most 20 % may"):
            squama.uncertainty(BEAM, {"substrate.poisson_ratio": f"uniform({limits})"}, **ask)


def test_the_laws_error_is_that_of_the_region(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("squama.study.tolerances.monte_carlo.FEWEST", 320)
    for theta0, region in (("20 deg", law.CORE), ("27 deg", law.WHOLE)):
        beam = BEAM.replace(scale={"theta0": theta0, "embedded": "4 mm"})
        assert law.region(choice.shape(beam)) is region
        assert law.within(choice.shape(beam))
        u = squama.uncertainty(beam, {"mu": "+- 0.05"}, at=AT, samples=320, levels=[0.5])
        assert f"joint.factor = normal(1, {law.errors(region).K_theta.rms:.6g})" in u.attrs["notes"]


@pytest.mark.slow
def test_what_is_not_known_is_a_share() -> None:
    # the law goes from .245 on
    name, least = "substrate.poisson_ratio", 0.245
    limits = f"uniform({least - 0.01}, {least + 0.05})"
    u = squama.uncertainty(BEAM, {name: limits}, at=AT, samples=3200, indices=64, keep=True)
    unknown = float(u.probability.sel(end="joint unknown"))
    assert unknown == pytest.approx(1 / 6, abs=0.01)
    assert float(u.share.sel(figure="torque")) <= 1 - unknown
    assert "the law of the joint does not know them" in u.attrs["notes"]
    without = json.loads(u.attrs["without_indices"])
    assert without.keys() >= {"engaged", "torque"}
    assert "of the groups of samples only, 0.8 are needed" in without["torque"]
    assert "Sobol" not in u.attrs["notes"]
    # a few that are not known do not count
    few = {name: f"uniform({least - 0.0025}, {least + 0.05})", "friction.mu": "+- 10 %"}
    v = squama.uncertainty(BEAM, few, at=AT, samples=3200, indices=256)
    (line,) = (line for line in v.attrs["notes"].splitlines() if line.startswith("Sobol indices are of "))
    known, groups = (int(line.split()[i]) for i in (4, 6))
    assert groups == 256
    # tolerance: samples of a fixed seed
    assert known == pytest.approx(256 * (2 / 2.1) ** 2, abs=3)
    # beside those of the range that is known throughout
    w = squama.uncertainty(BEAM, few | {name: f"uniform({least}, {least + 0.05})"}, at=AT, samples=3200, indices=256)
    np.testing.assert_allclose(v.ST.sel(indexed="torque"), w.ST.sel(indexed="torque"), atol=0.06)
    known = u.sample_end.values != "joint unknown"
    assert float(u.P_engaged) == pytest.approx(np.isfinite(u.phi_e.values[known]).mean())
    assert (u.phi_e.values[np.isfinite(u.phi_e.values)] <= 0.09).all()
    assert int(u["count"].sum()) == np.isfinite(u.stiffness_ratio.values).sum()

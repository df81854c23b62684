"""The commands at work: what they print, what they write, and what they load."""

import csv
import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import squama
from squama.cli import main
from squama.cli.short import EXAMPLE
from squama.units import number

ROOT = Path(__file__).parents[2]
EARLY = "0.04123 rad/pitch"
"""Beyond engagement, before the general contact, which takes seconds."""


@pytest.fixture
def beam(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("beam.toml").write_text(EXAMPLE.read_text())
    return squama.Beam.from_toml("beam.toml")


def _out(capsys, *arguments):
    assert main(list(arguments)) == 0
    captured = capsys.readouterr()
    assert captured.err == ""
    return captured.out


def _json(capsys, *arguments):
    def refuse(token):
        raise AssertionError(token)

    record = json.loads(_out(capsys, *arguments, "--json"), parse_constant=refuse)
    assert record["schema"] == 3
    return record


# ---- new --------------------------------------------------------------------------------------------------


def test_new_writes_the_example(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    text = _out(capsys, "new", "beam.toml")
    assert "squama twist beam.toml" in text
    beam = squama.Beam.from_toml("beam.toml")
    assert (beam.friction.mu, beam.scales, beam.substrate.youngs_modulus) == (0.25, 25, 1.5e6)
    _out(capsys, "twist", "beam.toml", "--to", EARLY, "--set", "beam.scales=5")


def test_new_explains_every_key():
    from squama.beam.beamfile import TABLES

    lines = EXAMPLE.read_text().splitlines()
    for table, keys in TABLES.items():
        assert any(line.startswith(f"[{table}]") for line in lines)
        for key in keys:
            found = [line for line in lines if line.removeprefix("# ").startswith(f"{key} = ")]
            assert found, key
            assert all("  # " in line for line in found), key


def test_new_replaces_when_told_to(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    Path("beam.toml").write_text("old")
    _out(capsys, "new", "beam.toml", "--force")
    assert Path("beam.toml").read_text() == EXAMPLE.read_text()


def test_the_example_in_the_tree_is_the_same():
    assert (ROOT / "examples" / "pla_on_vps.toml").read_text() == EXAMPLE.read_text()


# ---- twist and bend ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("command", ["twist", "bend"])
def test_the_summary_has_the_verdict_first_and_twelve_lines_at_most(command, beam, capsys):
    first, *lines = _out(capsys, command, "beam.toml", "--set", "beam.scales=5").splitlines()
    assert len(lines) < 12
    r = getattr(squama, command)(beam.replace(scales=5))
    angle, torque = ("phi", "T") if command == "twist" else ("psi", "M")
    engaged = np.degrees(float(r[f"{angle}_e"]))
    at = 2 * float(r[f"{angle}_e"])
    ratio = np.interp(at, r[angle], r.stiffness_ratio)
    free = f"free until {5 * engaged:.3g} deg ({engaged:.3g} deg per pitch)"
    assert first == f"beam.toml: {free}, then {ratio:.3g} times as stiff as the bar"
    (line,) = [line for line in lines if line.startswith(f"  {'torque' if command == 'twist' else 'moment'} ")]
    value, unit = line.split(";")[0].split(maxsplit=2)[1:]
    T = float(np.interp(at, r[angle], r[torque]))
    assert float(value) == pytest.approx(T * {"N m": 1, "N mm": 1e3}[unit], rel=0.01)
    stress = float(np.interp(at, r[angle], r.stress.max("scale")))
    assert f"{stress / 1e6:.3g} MPa, {stress / 5e5:.3g} % of the limit, 50 MPa" in "\n".join(lines)
    assert [line[9:] for line in lines if line.startswith("warning: ")] == r.attrs["warnings"].splitlines()


def test_summary_of_twist_on_the_hinge(beam, capsys):
    text = _out(capsys, "twist", "beam.toml", "--joint", "hinge", "--full")
    lines = text.splitlines()
    for column, law in enumerate(("edge", "plate")):
        r = squama.twist(beam, law=law, joint="hinge")
        for label, *values in (
            ("  at, deg", np.degrees(r.phi_end) * 25),
            ("  theta at the end, deg", np.degrees(r.theta_end)),
            ("scales touch at, deg", np.degrees(r.phi_e) * 25),
            ("  by the small-angle formula, deg", np.degrees(r.phi_e_small) * 25),
            ("torque T at the cut-off, N m", r.T_c),
            ("torque over the bare beam's", r.stiffening),
            ("relative energy dissipation RED", r.RED_c),
            ("mu that locks at engagement", r.mu_static),
        ):
            cells = [line.removeprefix(label).split()[column] for line in lines if line.startswith(f"{label} ")]
            assert cells == [number(float(value)) for value in values], label
    assert any(line.split() == ["edge", "law", "plate", "law"] for line in lines)
    assert any(line.split() == ["end", *["frictional", "lock"] * 2] for line in lines)
    assert "friction holds the sliding contact" in text
    assert "cut-off: 0.01 of the path before the lock" in text
    assert f"K_theta = {beam.joint_stiffness:.3g} N m" in text
    assert f"C_f = {beam.C_f:.3g}" in text
    warnings = [line.removeprefix("warning: ") for line in lines if line.startswith("warning: ")]
    assert warnings == beam.warnings()
    assert "\x1b" not in text


def test_summary_on_compliant_joints(beam, capsys):
    text = _out(capsys, "twist", "beam.toml", "--ends", "endless", "--full")
    lines = text.splitlines()
    assert any(line.split() == ["thick", "scales", "thin,", "rigid", "hinge"] for line in lines)
    r = squama.twist(beam, ends="endless")
    thin = squama.twist(beam, ideal=True, to=float(r.Phi[-1]), ends="endless")
    hinge = squama.twist(beam, joint="hinge", ideal=True)

    def row(start):
        return next(line.removeprefix(start).split() for line in lines if line.startswith(start))

    shown = row("scales touch at, deg")
    assert shown == [f"{25 * np.degrees(float(x.phi_e)):.3g}" for x in (r, thin, hinge)]
    # all at the same twist, twice the engagement on compliant joints
    twice = 2 * float(r.phi_e)
    whole = 25 * np.degrees(twice)
    assert any(line.startswith(f"at twice the engagement, {whole:.3g} deg ") for line in lines)
    torques = [float(np.interp(twice, x.phi, x["T"])) for x in (r, thin, hinge)]
    assert [float(cell) for cell in row("  torque T, N m")] == pytest.approx(torques, rel=5e-3)
    ratios = [float(np.interp(twice, x.phi, x.stiffness_ratio)) for x in (r, thin)]
    *shown, last = row("  dT/dPhi over that without contact")
    assert ([float(cell) for cell in shown], last) == (pytest.approx(ratios, rel=5e-3), "-")
    assert row("  largest stress in a scale, MPa")[1:] == ["-", "-"]
    # where simpler models part from that of compliant joints
    assert torques[2] > 4 * torques[0]
    for model in ("thin, rigid", "hinge"):
        (line,) = [line for line in lines if line.startswith(f"{model}: ")]
        assert "5 % in torque up to" in line or "5 % off in torque from the start" in line
    (line,) = [line for line in lines if line.startswith("joint of a scale: ")]
    assert "six motions, by the law of the joint, torque to about" in line
    assert "thick, elastic scales" in line
    assert "endless, free to bow (no bending moment)" in text
    assert "held straight by" not in _out(capsys, "twist", "beam.toml", "--to", "0.01 rad/pitch", "--full")
    # the hinge locks, and nobody meets its torque there: compliant joints are the headline
    assert f" {float(hinge.T_c):.3g} " not in text
    assert [line[9:] for line in lines if line.startswith("warning: ")] == list(r.attrs["warnings"])


@pytest.mark.slow
def test_summary_of_ideal_scales_and_of_rigid_ones(beam, capsys):
    text = _out(capsys, "twist", "beam.toml", "--ideal", "--points", "30", "--ends", "endless", "--compare")
    assert any(line.split() == ["thin,", "rigid", "hinge"] for line in text.splitlines())
    assert "thin, rigid scales" in text
    Path("beam.toml").write_text(
        "".join(line for line in EXAMPLE.read_text().splitlines(keepends=True) if '"3 GPa"' not in line)
    )
    text = _out(capsys, "twist", "beam.toml", "--points", "30", "--full")
    assert "thick, rigid scales" in text
    assert "scale.youngs_modulus is not given" in text


def test_law_plate_means_the_hinge_and_thin_scales(beam, capsys):
    found = _json(capsys, "twist", "beam.toml", "--law", "plate", "--points", "5")
    assert (found["joint"], found["law"]) == ("hinge", "plate")
    r = squama.twist(beam, law="plate", joint="hinge", ideal=True, points=5)
    assert found["figures"]["T_c"] == float(r.T_c)


@pytest.mark.parametrize("columns", ["20", "60", "300"])
@pytest.mark.parametrize("mu", ["0.25", "0,0.123456,10"])
def test_no_digit_is_lost_in_a_narrow_window(mu, columns, beam, capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", columns)
    text = _out(capsys, "twist", "beam.toml", "--mu", mu, "--to", EARLY, "--joint", "hinge", "--full")
    assert "\u2026" not in text
    last = squama.twist(beam, mu=float(mu.split(",")[-1]), to=EARLY, joint="hinge", ideal=True)
    assert f"{np.degrees(float(last.phi_end)) * 25:.3g}" in text


def test_summary_of_bend(beam, capsys):
    text = _out(capsys, "bend", "beam.toml", "--joint", "hinge", "--full")
    m = squama.bend(beam, joint="hinge")
    lines = text.splitlines()
    for label, value in (("  at, deg", 25 * np.degrees(m.psi_end)), ("moment M at the cut-off, N m", m.M_c)):
        assert [line.split()[-1] for line in lines if line.startswith(label)] == [f"{float(value):.3g}"], label
    assert "plate law" not in text
    assert [line[9:] for line in lines if line.startswith("warning: ")] == beam.warnings("bending")


@pytest.mark.slow
def test_other_contact_is_named(beam, capsys):
    text = _out(capsys, "twist", "beam.toml", "--mu", "0", "--full")
    assert f"mu = 0): {squama.twist(beam, mu=0).other_contact.item()}" in text


def test_summary_of_a_family_on_the_hinge(beam, capsys):
    lines = _out(capsys, "twist", "beam.toml", "--mu", "0,.2,.5", "--joint", "hinge", "--compare").splitlines()
    for law in ("edge", "plate"):
        start = lines.index(f"{law} law")
        r = squama.twist(beam, mu=[0, 0.2, 0.5], law=law, joint="hinge")
        for i, row in enumerate(lines[start + 2 : start + 5]):
            cells = row.split()
            assert cells[0] == f"{float(r.mu[i]):g}"
            assert cells[-1] == f"{float(r.RED_c[i]):.3g}"
            assert r.end[i].item() in row


def test_json_of_twist_on_the_hinge(beam, capsys):
    found = _json(capsys, "twist", "beam.toml", "--points", "30", "--joint", "hinge")
    r = squama.twist(beam, points=30, joint="hinge")
    for name in r.data_vars:
        place = found["curve"] if "point" in r[name].dims else found["figures"]
        values = [np.nan if v is None else v for v in np.atleast_1d(place[name])]
        assert values == pytest.approx(np.atleast_1d(r[name].values).tolist(), nan_ok=True), name
        assert found["units"][name] == r[name].attrs["units"]
    assert found["laws"]["edge"] == found["figures"]
    plate = squama.twist(beam, law="plate")
    assert found["laws"]["plate"]["T_c"] == pytest.approx(float(plate.T_c), rel=1e-12)
    assert found["warnings"] == beam.warnings()
    assert found["derived"]["K_theta"] == beam.joint_stiffness
    assert found["beam"]["scale"]["alpha"] == beam.scale.alpha
    assert (found["law"], found["sense"], found["margin"], found["mu"]) == ("edge", "+", 0.01, 0.25)
    assert "locked" in found["figures"]["sentence"]


def test_summary_of_a_family_on_compliant_joints(beam, capsys):
    text = _out(capsys, "twist", "beam.toml", "--mu", "0,.5", "--points", "30", "--ends", "endless", "--full")
    lines = text.splitlines()
    r = squama.twist(beam, mu=[0, 0.5], points=30, ends="endless")
    start = lines.index("thick scales")
    for i, line in enumerate(lines[start + 2 : start + 4]):
        cells = line.split()
        assert cells[0] == f"{float(r.mu[i]):g}"
        assert cells[-1] == f"{float(r.RED_c[i]):.3g}"
        assert r.end[i].item() in line
        assert f"mu = {float(r.mu[i]):g}: hinge: " in text
    assert {"thin, rigid", "hinge"} <= set(lines)


def test_json_on_compliant_joints(beam, capsys):
    found = _json(capsys, "twist", "beam.toml", "--points", "30", "--ends", "endless")
    r = squama.twist(beam, points=30, ends="endless")
    for name in r.data_vars:
        place = found["curve"] if "point" in r[name].dims else found["figures"]
        values = [np.nan if v is None else v for v in np.atleast_1d(place[name])]
        assert values == pytest.approx(np.atleast_1d(r[name].values).tolist(), nan_ok=True), name
        assert found["units"][name] == r[name].attrs["units"]
    assert list(found["laws"]) == ["thick scales", "thin, rigid", "hinge"]
    assert found["laws"]["thick scales"] == found["figures"]
    assert (found["joint"], found["law"], found["sense"], found["mu"]) == ("compliant", "edge", "+", 0.25)
    # figures of the joint are those of the model, and how far simpler models are off stands with them
    assert found["derived"]["K_theta"] == r.attrs["K_theta"] != beam.joint_stiffness
    (thin,), (hinge,) = (found["derived"]["off"][name] for name in ("thin, rigid", "hinge"))
    for off in (thin, hinge):
        assert 0 <= off["within"] < off["last"]
    assert hinge["torque"] > 1
    assert found["warnings"] == list(r.attrs["warnings"])


def test_json_of_a_family_that_never_engages(beam, capsys):
    found = _json(capsys, "twist", "beam.toml", "--mu", "0,1", "--sense=-", "--points", "5", "--joint", "hinge")
    assert found["figures"]["phi_e"] == ["inf", "inf"]
    assert found["figures"]["mu_static"] == [None, None]
    assert found["mu"] == [0, 1]
    assert np.shape(found["curve"]["T"]) == (2, 5)
    assert len(found["figures"]["sentence"]) == 2


def test_json_of_bend(beam, capsys):
    found = _json(capsys, "bend", "beam.toml", "--joint", "hinge")
    assert found["figures"]["psi_end"] == float(squama.bend(beam, joint="hinge").psi_end)
    assert found["derived"]["K_theta"] == beam.joint_stiffness
    assert list(found["laws"]) == ["edge"]


@pytest.mark.slow(but=1)
@pytest.mark.parametrize(
    ("flags", "arguments"),
    [
        (["--law", "plate"], {"law": "plate"}),
        (["--margin", "0.1"], {"margin": 0.1}),
        (["--points", "17"], {"points": 17}),
        (["--sense", "-"], {"sense": "-"}),
        (["--sense=-"], {"sense": "-"}),
        (["--to", "0.1 rad/pitch"], {"to": "0.1 rad/pitch"}),
        (["--to", "90 deg total"], {"to": "90 deg total"}),
        (["--to=5 rad/m"], {"to": 5.0}),
        (["--mu", "0,.2"], {"mu": [0, 0.2]}),
        (["--ideal"], {"ideal": True}),
        (["--joint", "hinge"], {"joint": "hinge"}),
        (["--joint", "hinge", "--margin", "0.1"], {"joint": "hinge", "margin": 0.1}),
    ],
)
def test_flags_are_arguments(flags, arguments, beam, capsys):
    if "to" not in arguments:
        flags, arguments = [*flags, "--to", EARLY], {**arguments, "to": EARLY}
    _out(capsys, "twist", "beam.toml", "--netcdf", "a.nc", *flags)
    # slopes of curves by general contact magnify what threads leave to chance in the last digits
    xr.testing.assert_allclose(squama.read("a.nc"), squama.twist(beam, **arguments), rtol=1e-6)


@pytest.mark.slow(but=1)
@pytest.mark.parametrize(
    ("flags", "changes"),
    [
        (["--mu", "0.4"], {"friction": {"mu": 0.4}}),
        (["--set", "friction.mu=0.4"], {"friction": {"mu": 0.4}}),
        (["--set", "scale.alpha=45 deg"], {"scale": {"alpha": "45 deg"}}),
        (["--set", 'scale.alpha="45 deg"', "--set", "beam.scales=7"], {"scale": {"alpha": "45 deg"}, "scales": 7}),
        (["--set", "joint.stiffness=0.02 N m"], {"joint": {"stiffness": 0.02}}),
        (["--set", "joint.inclusion_factor=2"], {"joint": {"inclusion_factor": 2}}),
        (["--set", "beam.pitch=19mm"], {"pitch": "19 mm"}),
    ],
)
def test_flags_override_the_file(flags, changes, beam, capsys):
    _out(capsys, "twist", "beam.toml", "--netcdf", "a.nc", "--to", EARLY, "--ends", "endless", *flags)
    found, expected = squama.read("a.nc"), squama.twist(beam.replace(**changes), to=EARLY, ends="endless")
    assert found.attrs["beam"] == expected.attrs["beam"]
    xr.testing.assert_identical(found, expected)
    assert Path("beam.toml").read_text() == EXAMPLE.read_text()


def test_a_flag_can_mend_the_file(beam, capsys):
    Path("beam.toml").write_text(EXAMPLE.read_text().replace('"60 deg"', "60").replace("mu = 0.25", ""))
    _out(capsys, "twist", "beam.toml", "--set", "scale.alpha=60 deg", "--mu", "0.1", "--to", EARLY)


@pytest.mark.slow(but=1)
@pytest.mark.parametrize("command", ["twist", "bend"])
def test_files(command, beam, capsys):
    name, torque = ("Phi", "T") if command == "twist" else ("kappa", "M")
    Path("test.csv").write_text(f"{name} (deg/mm),{torque} (N mm)\n0.1,40\n0.2,70\n")
    wanted = ["a.png", "b.svg", "c.pdf", "d.csv", "e.nc"]
    flags = ["--plot", "a.png", "--plot", "b.svg", "--plot", "c.pdf", "--csv", "d.csv", "--netcdf", "e.nc"]
    text = _out(capsys, command, "beam.toml", "--data", "test.csv", "--to", EARLY, "--ends", "endless", *flags)
    assert text.splitlines()[-5:] == [f"wrote {name}" for name in wanted]
    starts = [b"\x89PNG", b"<?xml", b"%PDF"]
    assert [Path(name).read_bytes()[: len(s)] for name, s in zip(wanted, starts, strict=False)] == starts
    xr.testing.assert_identical(squama.read("d.csv"), squama.read("e.nc"))
    found, own = squama.read("d.csv"), getattr(squama, command)(beam, to=EARLY, ends="endless")
    assert found.attrs == own.attrs
    # general contact gives its first and its second answer 1e-9 apart
    xr.testing.assert_allclose(found, own, rtol=1e-6)
    assert sorted(p.name for p in Path().iterdir()) == ["a.png", "b.svg", "beam.toml", "c.pdf", *wanted[3:], "test.csv"]


@pytest.mark.slow
def test_measured_points_are_drawn(beam, capsys):
    Path("test.csv").write_text("Phi (rad/m),T (N m)\n3,1\n4,2\n")
    _out(capsys, "twist", "beam.toml", "--to", EARLY, "--plot", "without.svg")
    _out(capsys, "twist", "beam.toml", "--to", EARLY, "--plot", "with.svg", "--data", "test.csv")
    assert Path("with.svg").read_text() != Path("without.svg").read_text()


# ---- ends, paper, and how a command stops -----------------------------------------------------------------


def test_ends(tmp_path, capsys):
    out = tmp_path / "o.csv"
    text = _out(capsys, "ends", str(ROOT / "examples" / "designs.csv"), "-o", str(out))
    with out.open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert f"{len(rows)} designs" in text
    assert len(rows) == 12
    assert len({row["end"] for row in rows}) >= 7
    assert {row["neighbour"] for row in rows} >= {"0", "1"}
    counts = _json(capsys, "ends", str(ROOT / "examples" / "designs.csv"), "-o", str(out))
    assert sum(counts["counts"].values()) == counts["rows"] == 12
    # to standard output it is the table alone
    assert _out(capsys, "ends", str(ROOT / "examples" / "designs.csv"), "-o", "-") == out.read_text()
    assert not Path("-").exists()
    assert main(["ends", str(ROOT / "examples" / "designs.csv"), "-o", "-", "--json"]) == 2
    assert "-o" in capsys.readouterr().err


def test_paper_hands_on_what_it_is_given(tmp_path, monkeypatch, capsys):
    from squama.paper import twisting2020

    seen = []
    monkeypatch.setattr(twisting2020, "write", lambda *a: seen.append(a) or [tmp_path / "fig4.png"])
    text = _out(capsys, "paper", "fig4", "fig6b", "-o", str(tmp_path), "--points", "fe.csv")
    assert seen == [(("fig4", "fig6b"), tmp_path, Path("fe.csv"), ("png",))]
    assert text == f"wrote {tmp_path / 'fig4.png'}\n"


def test_ctrl_c(beam, monkeypatch, capsys):
    from squama.curves import doors

    def interrupted(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr(doors, "respond", interrupted)
    assert main(["twist", "beam.toml", "--csv", "a.csv"]) == 130
    assert "Traceback" not in capsys.readouterr().err
    assert not Path("a.csv").exists()


def test_a_reader_that_goes_away(beam):
    code = "import sys; from squama.cli import main; sys.exit(main(sys.argv[1:]))"
    command = f"{sys.executable} -c '{code}' twist beam.toml --joint hinge --json --points 2000 | head -c 1"
    done = subprocess.run(
        ["bash", "-o", "pipefail", "-c", command],
        capture_output=True,
        text=True,
        check=False,
        env={**os.environ, "PYTHONPATH": str(ROOT / "src")},
    )
    assert done.stdout == "{"
    assert done.stderr == ""

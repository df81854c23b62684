"""squama export on the command line."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

import squama
from squama.cli import main
from squama.errors import InputError
from squama.fabrication import mesh
from squama.plot import solids_figure

pytest.importorskip("manifold3d")
pytest.importorskip("trimesh")

EXAMPLE = Path(__file__).parents[2] / "examples" / "pla_on_vps.toml"


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "beam.toml").write_text(EXAMPLE.read_text())
    return tmp_path


def test_the_command(folder, capsys):
    assert main(["export", "beam.toml", "--scales", "3", "-o", "out", "--picture", "out/a.png", "--full"]) == 0
    said = capsys.readouterr().out
    for words in (
        "3 scales on a bar of 120 x 32 x 16 mm",
        "substrate",
        "wrote 19 files",
        "theta0, measured on scale 1",
    ):
        assert words in said
    assert "out/scale.stl" in said
    assert (folder / "out" / "a.png").stat().st_size > 10_000
    arguments = ["export", "beam.toml", "--scales", "3", "-o", "out", "--parts", "substrate,scale", "--formats", "3mf"]
    assert main(arguments) == 0
    # the files are listed with --full alone
    assert "out/scale.3mf" not in capsys.readouterr().out
    assert main([*arguments, "--json", "--clearance", "0.25 mm", "--set", "scale.alpha=50 deg"]) == 0
    record = json.loads(capsys.readouterr().out)
    assert record["plan"]["clearance"] == 0.25
    assert [Path(p).name for p in record["written"]][:3] == ["scale.3mf", "scales.3mf", "substrate.3mf"]
    assert all(check["holds"] for check in record["checks"])
    angle = next(c for c in record["checks"] if c["what"] == "alpha")
    assert angle["measured"] == pytest.approx(50)
    assert [row["part"] for row in record["bill"]] == ["scale", "substrate", "glue in a slot"]
    kept = json.loads((folder / "out" / "export.json").read_text())
    assert set(kept["files"]) == {"scale.3mf", "scales.3mf", "substrate.3mf", "bill.csv"}
    assert "assembly.stl" in kept["earlier"]


def test_a_picture_needs_something_to_show(folder):
    made = squama.export(squama.Beam.from_toml("beam.toml"), "out", scales=2, parts=["scale"], formats=["stl"])
    with pytest.raises(InputError, match="shows the assembly and the mould"):
        solids_figure(made)


@pytest.mark.parametrize(
    ("flags", "words"),
    [
        (["--parts", "lid"], ['--parts = "lid": must be']),
        (["--formats", "obj,stl"], ['--formats = "obj": must be']),
        (["--scales", "0"], ["--scales = "]),
        (["--scales", "2.5"], ["--scales = 2.5: is not a whole number"]),
        (["--clearance", "0.2"], ["--clearance = ", "has no unit"]),
        (["--wall", "3 deg", "--bed", "x"], ["--wall = ", "--bed = "]),
        (["--substrate-density", "99"], ["--substrate-density = "]),
        (["--picture", "a.gif"], ["a.gif"]),
        (["--picture", "out/a.gif"], ["a.gif"]),
        (["--picture", "a.png", "--parts", "scale"], ["--picture: shows the assembly and the mould"]),
        (["--set", "scale.alpha=10 deg", "--set", "scale.width=50 mm"], ["wider than the bar"]),
        (["--ends", "1 mm", "--set", "scale.thickness=0.2 mm"], ["ends = 1 mm", "scale.thickness = 0.2 mm"]),
    ],
)
def test_bad_flags(folder, capsys, flags, words):
    assert main(["export", "beam.toml", "-o", "out", *flags]) == 2
    said = capsys.readouterr().err
    for part in words:
        assert part in said
    assert all(line.startswith("squama: error: ") for line in said.splitlines())
    assert [p.name for p in folder.iterdir()] == ["beam.toml"]


def test_a_failed_check_is_told_without_a_traceback(folder, capsys, monkeypatch):
    monkeypatch.setattr(mesh, "VOLUME", -1.0)
    assert main(["export", "beam.toml", "--scales", "2", "-o", "out"]) == 2
    assert "scale: volume = 1267.2 mm^3, should be 1267.2 mm^3" in capsys.readouterr().err
    assert not (folder / "out").exists()

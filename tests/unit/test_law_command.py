"""squama law: files, what it says, and what it refuses."""

import json

import pytest

from squama.cli import main


def test_the_command(tmp_path, capsys):
    out = tmp_path / "law.csv"
    given = ["law", "examples/stiff_skin.toml", "--mu", "0", "--points", "5", "--twist", "5 rad/m", "-o", str(out)]
    assert main([*given, "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["scales_for_10_percent"] >= 10
    assert told["table"]["Phi"] == [-5.0, -2.5, 0.0, 2.5, 5.0]
    assert out.exists()
    assert main([*given, "--bend", "5 rad/m"]) == 0
    assert "potential over 5 x 5 values" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("given", "words"),
    [
        (["--format", "abaqus", "-o", "law.inp", "--mu", "0.2"], "which knows no unloading"),
        (["-o", "law.csv", "--mu", "0.2"], "write --mu 0, or --uncoupled"),
        (["-o", "law.csv", "--points", "4"], "write 5"),
        (["-o", "law.csv", "--twist", "9"], "--twist"),
        (["-o", "law.csv", "--format", "ansys"], ".mac"),
        (["-o", "law.xyz"], "law.xyz"),
    ],
)
def test_the_command_refuses(given, words, tmp_path, monkeypatch, capsys):
    beam = f"{tmp_path}/beam.toml"
    assert main(["new", beam]) == 0
    capsys.readouterr()
    monkeypatch.chdir(tmp_path)
    assert main(["law", beam, *given]) == 2
    told = capsys.readouterr().err
    assert words in told
    assert told.count("\n") == 1
    assert not list(tmp_path.glob("law.*"))

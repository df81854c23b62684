"""Every class of bad input through the command line: status 2, a line per mistake, nothing written or changed."""

import os
import shlex
import subprocess
import sys
from pathlib import Path

import pytest
from refusals import refused

from squama.cli import main
from squama.cli.short import EXAMPLE

GOOD = EXAMPLE.read_text()
BARE = "\n".join(line.split("  #")[0].rstrip() for line in GOOD.splitlines()) + "\n"
DESIGNS = "eta,beta,lambda,alpha_deg,theta0_deg,mu\n3,1.25,0.45,45,10,0.5\n"


@pytest.fixture
def place(tmp_path, monkeypatch):
    """A folder with a good beam file and outputs of an earlier run, which must stay as they are."""
    monkeypatch.chdir(tmp_path)
    Path("beam.toml").write_text(GOOD)
    Path("designs.csv").write_text(DESIGNS)
    Path("test.csv").write_text("Phi (rad/m),T (N m)\n1,0.1\n")
    for name in ("old.csv", "old.nc", "old.png", "old.toml"):
        Path(name).write_text("old")
    Path("folder.csv").mkdir()
    Path("folder.toml").mkdir()
    Path("sealed").mkdir(mode=0o555)
    Path("closed.csv").write_text("old")
    Path("closed.csv").chmod(0o444)
    return tmp_path


BEAM_FILES = [
    # keys
    ('embedded = "6 mm"', "", [["scale.embedded: is missing", "write embedded ="]]),
    ("[substrate]", "[substrat]", [["[substrat]", "did you mean [substrate]?"]]),
    ("pitch =", "ptch =", [["beam.ptch: unknown key", "did you mean pitch?"]]),
    ("scales = 25", "scales = 25\nscales = 26", [["line 30", "scales is given twice"]]),
    ("[friction]", "[scale]", [["the table [scale] is given twice"]]),
    ("mu = 0.25", "", [["friction.mu: is missing", "mu = 0.25", "--mu 0.25"]]),
    # types
    ('"60 mm"', "true", [["scale.length = true", "write e.g."]]),
    ('"60 mm"', '["60 mm"]', [["scale.length", "is a list"]]),
    ("scales = 25", "scales = 2.5", [["beam.scales = 2.5", "whole number"]]),
    ("scales = 25", 'scales = "25"', [['beam.scales = "25"', "whole number"]]),
    # dimensions and units
    ('"60 mm"', '"12 deg"', [['scale.length = "12 deg"', "is an angle, but a length", '"12 mm"']]),
    ('"1.5 MPa"', '"1.5 mm"', [["substrate.youngs_modulus", "is a length, but a pressure"]]),
    ('"60 deg"', "60", [["scale.alpha = 60", "has no unit", '"60 deg"']]),
    ('"20 mm"', '"20"', [['beam.pitch = "20"', "has no unit", '"20 mm"']]),
    ('"60 mm"', "60 mm", [["line 6", "quotes"]]),
    # values
    ('"60 mm"', '"-60 mm"', [['scale.length = "-60 mm"', "more than 0"]]),
    ('"60 mm"', '"0 mm"', [['scale.length = "0 mm"', "more than 0"]]),
    ('"60 mm"', "nan", [["scale.length = nan", "finite"]]),
    ('"60 mm"', '"inf mm"', [["scale.length", "inf mm"]]),
    ("mu = 0.25", "mu = nan", [["friction.mu = nan", "finite"]]),
    ("mu = 0.25", "mu = -0.1", [["friction.mu", "-0.1", "0 to 10"]]),
    ("0.49", "0.5", [["substrate.poisson_ratio", "0.5", "-1 to 0.5, exclusive"]]),
    ("0.49", "-1", [["substrate.poisson_ratio", "-1", "exclusive"]]),
    ('"60 deg"', '"90 deg"', [['scale.alpha = "90 deg"', "below 90 deg"]]),
    ('"15 deg"', '"0 deg"', [['scale.theta0 = "0 deg"', "0 to 90 deg"]]),
    ('"15 deg"', '"100 deg"', [["scale.theta0", "0 to 90 deg"]]),
    # several at once
    (
        'width = "24 mm"\nthickness = "0.8 mm"',
        'width = "24 deg"\nthickness = 0.8',
        [["scale.width", "is an angle"], ["scale.thickness = 0.8", "no unit"]],
    ),
    ("embedded =", "embeded =", [["scale.embeded: unknown key", "did you mean embedded?"]]),
]


@pytest.mark.parametrize("command", ["twist", "bend"])
@pytest.mark.parametrize(("old", "new", "lines"), BEAM_FILES)
def test_values_of_a_beam_file(old, new, lines, command, place, capsys):
    assert old in BARE
    Path("beam.toml").write_text(BARE.replace(old, new))
    arguments = [command, "beam.toml", "--csv", "old.csv", "--netcdf", "new.nc", "--plot", "old.png"]
    refused(arguments, [["beam.toml: ", *words] for words in lines], capsys)


@pytest.mark.parametrize("command", ["twist", "bend"])
@pytest.mark.parametrize(
    ("data", "words"),
    [
        (b"", ["is empty", "squama new"]),
        (b" \n ", ["is empty"]),
        (b"\x7fELF\x00\x00", ["binary"]),
        (GOOD.encode("utf-16"), ["binary"]),
        (b"# \xe4\n" + GOOD.encode(), ["not UTF-8", "line 1"]),
        (b"#" * 1_000_001, ["larger than 1,000,000 bytes"]),
        (b"scale = [[[[", ["not valid TOML"]),
        (None, ["no such file", "squama new nothing.toml"]),
        ("folder.toml", ["is a folder"]),
    ],
)
def test_beam_files_of_the_wrong_kind(data, words, command, place, capsys):
    name = "nothing.toml" if data is None else "folder.toml" if data == "folder.toml" else "beam.toml"
    if isinstance(data, bytes):
        Path(name).write_bytes(data)
    refused([command, name, "--csv", "new.csv"], [[f"{name}: ", *words]], capsys)


FLAGS = [
    ("--mu abc", ['--mu = "abc"', "is not a plain number", "0.25"]),
    ("--mu -1", ['--mu = "-1"', "0 to 10"]),
    ("--mu 11", ['--mu = "11"', "0 to 10"]),
    ("--mu nan", ["--mu", "nan"]),
    ("--mu 0.1,,0.2", ['--mu = ""', "0.25"]),
    ("--mu 0.1,x", ['--mu = "x"']),
    ("--mu 0.1,0.2,0.1", ["--mu = 0.1,0.2,0.1: 0.1 is given twice", "write --mu 0.1,0.2"]),
    ("--mu 1mm", ['--mu = "1mm"', "is a length"]),
    ("--margin 0", ['--margin = "0"', "below 1"]),
    ("--margin 1", ['--margin = "1"', "below 1"]),
    ("--margin x", ['--margin = "x"', "write e.g. 0.01"]),
    ("--points 2", ['--points = "2"', "3 to 100000"]),
    ("--points 5.5", ["--points = 5.5", "whole number"]),
    ("--points 2.5", ["--points = 2.5: is not a whole number", "3 to 100000", "write e.g. 200"]),
    ("--set 'scale.theta0=95 deg'", ["--set scale.theta0", 'write e.g. "10 deg"']),
    ("--set joint.inclusion_factor=x", ["--set joint.inclusion_factor", "write e.g. 1.4"]),
    (
        "--set 'scale.length=1000 km'",
        ["scale.length", "eta = l/d = 5e+07", "allowed: more than 0, up to 100", "write at"],
    ),
    ("--set 'scale.width=5 m'", ["scale.width = 5000 mm", "beta = b/d = 125", "up to 100; write at most 4000 mm"]),
    ("--points 1e9", ['--points = "1e9"', "3 to 100000"]),
    ("--points many", ['--points = "many"']),
    ("--to 5", ['--to = "5"', "over which length"]),
    ("--to '90 deg'", ['--to = "90 deg"', "over which length", '"90 deg total"']),
    ("--to '-5 rad/m'", ['--to = "-5 rad/m"', "more than 0"]),
    ("--to '0 rad/m'", ["--to", "more than 0"]),
    ("--to '5 mm'", ['--to = "5 mm"', "is a length"]),
    ("--to soon", ['--to = "soon"']),
    ("--set scale.alpha", ["--set", "table.key=value"]),
    ("--set scale.alpha=", ["--set", "table.key=value"]),
    ("--set alpha=1", ["--set", "table.key=value"]),
    ("--set scal.alpha=1", ["--set", "did you mean [scale]?"]),
    ("--set scale.alhpa=1", ["--set", "did you mean alpha?"]),
    ("--set scale.alpha=30", ["--set scale.alpha = 30", "has no unit", '"30 deg"']),
    ("--set 'scale.alpha=95 deg'", ['--set scale.alpha = "95 deg"', "below 90 deg"]),
    ("--set 'scale.length=1 deg'", ["--set scale.length", "is an angle"]),
    ("--set beam.scales=1", ["--set beam.scales = 1", "whole number"]),
    ("--data nothing.csv", ["nothing.csv: no such file"]),
    ("--data folder.csv", ["folder.csv: is a folder"]),
    ("--csv folder.csv", ["folder.csv: is a folder"]),
    ("--csv closed.csv", ["closed.csv: is read-only"]),
    ("--csv sealed/a.csv", ["sealed/a.csv: ", "read-only"]),
    ("--csv none/a.csv", ["none/a.csv: ", "does not exist"]),
    ("--csv a.txt", ["a.txt: ", "allowed: .csv"]),
    ("--csv ''", ['"": has no extension', "allowed: .csv"]),
    ("--csv beam.toml", ["beam.toml: ", "allowed: .csv"]),
    ("--netcdf a.csv", ["a.csv: ", "allowed: .nc"]),
    ("--netcdf none/a.nc", ["none/a.nc: ", "does not exist"]),
    ("--plot a.gif", ["a.gif: ", "allowed: .png, .svg, .pdf"]),
    ("--plot a", ["a: ", "allowed: .png, .svg, .pdf"]),
    ("--plot none/a.pdf", ["none/a.pdf: ", "does not exist"]),
    ("--plot a.png --plot ./a.png", ["a.png: is given twice"]),
    ("--plt a.png", ["--plt", "--plot"]),
    ("--mu", ["--mu: is missing or has no value"]),
    ("--mu 1 --mu 2", ["--mu"]),
    ("more", ["more: is more than the command takes"]),
]


@pytest.mark.parametrize("command", ["twist", "bend"])
@pytest.mark.parametrize(("flags", "words"), FLAGS)
def test_flags(flags, words, command, place, capsys):
    others = [] if "--netcdf" in flags else ["--netcdf", "other.nc"]
    refused([command, "beam.toml", *others, *shlex.split(flags)], [words], capsys)


@pytest.mark.parametrize(
    ("arguments", "lines"),
    [
        (["twist", "beam.toml", "--law", "both"], [["--law", '"both"', '"edge"', '"plate"']]),
        (["twist", "beam.toml", "--sense", "left"], [["--sense", '"left"', '"+"', '"-"']]),
        (["bend", "beam.toml", "--law", "edge"], [["--law"]]),
        (
            ["twist", "beam.toml", "--mu", "x", "--margin", "2", "--law", "no", "--csv", "none/a.csv", "--to", "5"],
            [["--mu"], ["--margin"], ["--law"], ["none/a.csv"], ["--to"]],
        ),
        (["twist", "nothing.toml", "--mu", "x", "--plot", "a.gif"], [["--mu"], ["a.gif"], ["nothing.toml"]]),
        (
            ["twist", "beam.toml", "--data", "test.csv", "--csv", "test.csv"],
            [["test.csv: is read too"]],
        ),
        (["twist"], [["BEAM", "squama twist --help"]]),
        (["twits", "beam.toml"], [["twits", "twist"]]),
        (["--verbose"], [["--verbose"]]),
        (["new"], [["BEAM"]]),
        (["new", "old.toml"], [["old.toml: is there already", "--force"]]),
        (["new", "folder.toml"], [["folder.toml: is a folder"]]),
        (["new", "folder.toml", "--force"], [["folder.toml: is a folder"]]),
        (["new", "closed.csv", "--force"], [["closed.csv: is read-only"]]),
        (["new", "sealed/a.toml"], [["sealed/a.toml: ", "read-only"]]),
        (["new", "none/a.toml"], [["none/a.toml: ", "does not exist"]]),
        (["ends", "designs.csv"], [["--out"]]),
        (["ends", "nothing.csv", "-o", "old.csv"], [["nothing.csv: no such file"]]),
        (["ends", "folder.csv", "-o", "old.csv"], [["folder.csv: is a folder"]]),
        (["ends", "designs.csv", "-o", "designs.csv"], [["designs.csv: is read too"]]),
        (["ends", "designs.csv", "-o", "folder.csv"], [["folder.csv: is a folder"]]),
        (["ends", "designs.csv", "-o", "closed.csv"], [["closed.csv: is read-only"]]),
        (["ends", "designs.csv", "-o", "none/a.csv"], [["none/a.csv: ", "does not exist"]]),
        (["ends", "designs.csv", "-o", "a.xlsx"], [["a.xlsx: ", "allowed: .csv"]]),
        (["ends", "test.csv", "-o", "old.csv"], [["test.csv: line 1: ", '"Phi (rad/m),T (N m)" has none', "eta,beta"]]),
        (
            ["ends", "designs.csv", "-o", "a.csv", "--law", "x", "--sense", "x", "--contacts", "x"],
            [["--law"], ["--sense"], ["--contacts", '"tip" or "all"']],
        ),
        (["paper", "-o", "old.csv"], [["old.csv: is a file", "folder"]]),
        (["paper", "-o", "sealed"], [["sealed", "read-only"]]),
        (["paper", "-o", "sealed/new"], [["sealed/new: its folder ", "sealed is read-only"]]),
        (["paper", "-o", "none/deeper"], [["none/deeper: ", "none does not exist"]]),
        (["paper", "fig9", "-o", "figures"], [['"fig9"', "fig4"]]),
        (["paper", "fig6b", "-o", "figures", "--points", "nothing.csv"], [["nothing.csv: no such file"]]),
        (["paper"], [["--out"]]),
    ],
)
def test_commands(arguments, lines, place, capsys):
    refused(arguments, lines, capsys)


def test_bad_rows_do_not_stop_good_ones(place, capsys):
    Path("designs.csv").write_text(f"{DESIGNS}3,1.25,0.45,45 deg,10,0.5\n3,1.25\n")
    assert main(["ends", "designs.csv", "-o", "old.csv"]) == 2
    captured = capsys.readouterr()
    assert captured.err.splitlines() == [
        'squama: error: designs.csv: line 3: alpha_deg = "45 deg": is not a number; write e.g. 45',
        "squama: error: designs.csv: line 4: has 2 cells, the header has 6; give one for each column",
    ]
    assert captured.out.startswith("wrote old.csv: 1 designs")
    assert len(Path("old.csv").read_text().splitlines()) == 2


def test_only_bad_rows_write_nothing(place, capsys):
    Path("designs.csv").write_text(DESIGNS.replace("45", "x"))
    assert main(["ends", "designs.csv", "-o", "old.csv"]) == 2
    assert len(capsys.readouterr().err.splitlines()) == 2
    assert Path("old.csv").read_text() == "old"


@pytest.mark.parametrize(
    "arguments",
    [
        ["twist", "nothing.toml"],
        ["twist", "beam.toml", "--mu", "x"],
        ["twist", "beam.toml", "--bogus"],
        ["bogus"],
        ["ends", "test.csv", "-o", "a.csv"],
    ],
)
def test_in_a_process_of_its_own(arguments, place):
    source = str(Path(main.__code__.co_filename).parents[2])
    done = subprocess.run(
        [sys.executable, "-m", "squama", *arguments],
        capture_output=True,
        text=True,
        check=False,
        env={**os.environ, "PYTHONPATH": source, "COLUMNS": "20"},
    )
    assert done.returncode == 2
    assert done.stdout == ""
    assert "Traceback" not in done.stderr
    assert all(line.startswith("squama: error: ") for line in done.stderr.splitlines())
    assert len(done.stderr.splitlines()) == 1

"""Bad input of `squama cell` and `squama verify`: status 2, a line per mistake, nothing written; no elements needed."""

import sys
from pathlib import Path

import pytest

from squama.cli import main
from squama.cli.short import EXAMPLE
from squama.errors import InputError
from squama.fe import runs
from squama.paper import parameters as par

GOOD = EXAMPLE.read_text()


@pytest.fixture
def place(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("beam.toml").write_text(GOOD)
    Path("slippery.toml").write_text("".join(line for line in GOOD.splitlines(True) if not line.startswith("mu")))
    Path("folder.csv").mkdir()
    Path("sealed").mkdir(mode=0o555)
    return tmp_path


def refused(arguments, lines, capsys):
    before = sorted(Path().rglob("*"))
    assert main(arguments) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    said = captured.err.splitlines()
    assert len(said) == len(lines), captured.err
    for line, words in zip(said, lines, strict=True):
        assert line.startswith("squama: error: ")
        assert words in line
    assert sorted(Path().rglob("*")) == before


TO = ["--to", "0.1 rad/pitch"]


@pytest.mark.parametrize(
    ("arguments", "lines"),
    [
        (["cell", "beam.toml"], ["--to: is missing"]),
        (["cell", "none.toml", *TO], ["none.toml: no such file"]),
        (["cell", "slippery.toml", *TO], ["slippery.toml: friction.mu: is missing; write mu = 0.25 under [friction]"]),
        (["cell", "beam.toml", *TO, "--mu", "-1"], ["--mu = "]),
        (["cell", "beam.toml", *TO, "--mu", "nan"], ["--mu = "]),
        (["cell", "beam.toml", "--to", "0.1"], ["--to = "]),
        (["cell", "beam.toml", "--to", "-5 rad/m"], ["--to = "]),
        (["cell", "beam.toml", *TO, "--sense", "x"], ['--sense = "x": must be "+" or "-"']),
        (["cell", "beam.toml", *TO, "--mesh", "tiny"], ['--mesh = "tiny": must be coarse, medium, fine, or two sizes']),
        (["cell", "beam.toml", *TO, "--mesh", "0.2,x"], ["--mesh = "]),
        (["cell", "beam.toml", *TO, "--increment", "0"], ["--increment = "]),
        (["cell", "beam.toml", *TO, "--set", "scale.x=1"], ["--set "]),
        (["cell", "beam.toml", *TO, "--plot", "a.gif"], ["a.gif: "]),
        (["cell", "beam.toml", *TO, "--picture", "none/a.png"], ["none/a.png: "]),
        (["cell", "beam.toml", *TO, "--plot", "a.png", "--picture", "a.png"], ["a.png: is given twice"]),
        (["cell", "beam.toml", *TO, "--vtk", "a.vtk"], ["a.vtk: "]),
        (["cell", "beam.toml", *TO, "--csv", "folder.csv"], ["folder.csv: is a folder"]),
        (
            ["cell", "beam.toml", *TO, "--mu", "x", "--mesh", "x", "--increment", "x", "--sense", "x"],
            ["--mu", "--increment", "--mesh", "--sense"],
        ),
        (["verify", "none.toml"], ["none.toml: no such file"]),
        (["verify", "slippery.toml"], ["slippery.toml: friction.mu: is missing"]),
        (["verify", "beam.toml", "--scales", "1"], ['--scales = "1"']),
        (["verify", "beam.toml", "--scales", "2.5"], ["--scales = 2.5: is not a whole number"]),
        (["verify", "beam.toml", "--beam-mesh", "x"], ['--beam-mesh = "x": must be coarse']),
        (["verify", "beam.toml", "-o", "beam.toml"], ["beam.toml: is a file; give the name of a folder"]),
        (["verify", "beam.toml", "-o", "none/deeper"], ["none/deeper: its folder "]),
        (["verify", "beam.toml", "-o", "sealed/new"], ["sealed is read-only; give another path"]),
        (
            ["verify", "beam.toml", "--mu", "x", "--mesh", "x", "--to", "x", "--sense", "x", "--increment", "9"],
            ["--mu", "--increment", "--mesh", "--sense", "--to"],
        ),
    ],
)
def test_commands(arguments, lines, place, capsys):
    refused(arguments, lines, capsys)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"to": 0.0}, "to = 0 rad/m: must be above 0"),
        ({"to": "1 rad/pitch", "mu": -1}, "mu"),
        ({"to": "1 rad/pitch", "sense": "x"}, "sense"),
        ({"to": "4 rad/pitch"}, "must be above 0 and below"),
        ({"to": "1 rad/pitch", "mesh": "x"}, "mesh"),
        ({"to": "1 rad/pitch", "mesh": (0.2,)}, "give two sizes"),
        ({"to": "1 rad/pitch", "increment": 1.0}, "increment"),
        ({"to": "1 rad/pitch", "ends": "held"}, "ends: is for finite beams; give scales too"),
        ({"to": "1 rad/pitch", "scales": 2, "last": print}, "last: shows one endless pitch"),
    ],
)
def test_arguments(arguments, words):
    with pytest.raises(InputError, match=words):
        runs.cell(par.fig6b(3.0), **{"mu": 0.2, **arguments})


def test_plates_that_touch_at_rest_are_refused():
    beam = par.fig6b(3.0)
    # cos(alpha) sin(theta0) = .1228
    beam = beam.replace(scale={"thickness": 0.124 * beam.pitch})
    with pytest.raises(
        InputError, match=r"scale.thickness = .* touch their neighbours at rest; write less than 0.1228"
    ):
        runs.cell(beam, to="0.1 rad/pitch", mu=0.2)


def test_without_friction_it_says_so():
    with pytest.raises(InputError, match="mu: is not given"):
        runs.cell(par.fig6b(3.0), to="0.1 rad/pitch")


@pytest.mark.parametrize("command", ["cell", "verify"])
def test_missing_packages_are_one_line(command, place, capsys, monkeypatch):
    for name in [name for name in sys.modules if name.partition(".")[0] == "netgen"]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "netgen", None)
    Path("out").mkdir()
    out = ["-o", "out"] if command == "verify" else []
    words = "finite elements need netgen-mesher; install them with: pip install 'squama[fe]'"
    refused([command, "beam.toml", *TO, "--quiet", *out], [words], capsys)

"""Input that a careless reader computes on for ever: refused at once, in one short line."""

import signal
from pathlib import Path

import pytest

from squama.cli import main
from squama.cli.short import EXAMPLE

GOOD = EXAMPLE.read_text()
LONG = " " * 300_000


@pytest.fixture(autouse=True)
def place(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("beam.toml").write_text(GOOD)
    signal.signal(signal.SIGALRM, signal.default_int_handler)
    signal.alarm(30)
    yield
    signal.alarm(0)


def _refused(capsys, words, *arguments):
    assert main(arguments) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert words in line
    assert len(line) < 700


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('"60 mm"', '"1 9**9**9 m"', "is not known as a unit"),
        ('"60 mm"', f'"60 mm{LONG}x"', "is longer than 100 characters"),
        ("mu = 0.25", f'mu = 1{"x" * 300_000}"', "a quote is missing"),
        ("mu = 0.25", f"mu = {'9' * 5000}", "a number has more than 4300 digits"),
        ("mu = 0.25", f"mu = 0x{'f' * 50_000}", "is not a finite number"),
        ("mu = 0.25", f"mu = [0x{'f' * 50_000}]", "huge numbers: is a list"),
        ("scales = 25", f"scales = 0x{'f' * 50_000}", "is neither a whole number"),
        ("mu = 0.25", "mu = 1e400", "is not a finite number"),
    ],
    ids=range(8),
)
def test_beam_file(old, new, words, capsys):
    Path("bad.toml").write_text(GOOD.replace(old, new))
    _refused(capsys, words, "twist", "bad.toml")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["twist", "beam.toml", "--to", "1 9**9**9 rad/m"], "is not known as a unit"),
        (["twist", "beam.toml", "--to", f"1{LONG[:90_000]}x"], "is longer than 100 characters"),
        (["sweep", "beam.toml", "--over", "scale.length=1 9**9**9 m:2 m:3", "-o", "m.zarr"], "is not known as a unit"),
        (["sweep", "beam.toml", "--over", "mu=0:1:1e400", "-o", "m.zarr"], "is not a whole number"),
        (["cycle", "beam.toml", "--to", "0.1 9**9**9 rad/pitch"], "is not known as a unit"),
    ],
    ids=range(5),
)
def test_flags(arguments, words, capsys):
    _refused(capsys, words, *arguments)


def test_header_of_a_table(capsys):
    Path("test.csv").write_text("Phi (9**9**9 m), T (N m)\n1,2\n2,3\n")
    _refused(capsys, "is no unit of a twist", "fit", "test.csv", "beam.toml")


def test_tolerances_and_targets(capsys):
    Path("tolerances.toml").write_text(f'[tolerance]\nscale.alpha = "60 deg{LONG}x"\n')
    _refused(capsys, "is longer than 100", "uncertainty", "beam.toml", "--tolerances", "tolerances.toml")
    vary = '[vary]\nscale.alpha = ["30 deg", "60 deg"]'
    Path("target.toml").write_text(f'start = "beam.toml"\n[target]\nstiffness = "5{LONG}x"\n{vary}\n')
    _refused(capsys, "is longer than 100", "design", "target.toml")


def test_more_than_a_command_takes(capsys):
    _refused(capsys, "is more than the command takes", "twist", "beam.toml", "9" * 5000)
    _refused(capsys, "Unknown option", "twist", "beam.toml", f"--{'x' * 5000}")


@pytest.mark.parametrize("arguments", ["twist loop.toml", "twist beam.toml --csv loop.csv"])
def test_loops_of_links(arguments, capsys):
    for name in ("loop.toml", "loop.csv"):
        Path(name).symlink_to(name)
    _refused(capsys, "is a loop of symbolic links", *arguments.split())


def test_loops_of_links_are_told_all_at_once(capsys):
    for name in ("loop.toml", "loop"):
        Path(name).symlink_to(name)
    assert main(["design", "loop.toml", "-o", "loop"]) == 2
    lines = capsys.readouterr().err.splitlines()
    assert [line.split(": ")[2] for line in lines] == ["loop", "loop.toml"]
    assert all("is a loop of symbolic links" in line for line in lines)


def test_null_characters(capsys):
    _refused(capsys, "holds a null character; leave it out", "fit", "test.csv", "beam.toml", "\0")

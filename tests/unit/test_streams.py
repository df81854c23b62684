"""Surroundings that fail: streams closed or full, a working folder that is gone, nonsense in the environment.

Curves are those of the hinge, which take no time.
"""

import os
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

from squama.cli import main
from squama.cli.short import EXAMPLE


@pytest.fixture
def place(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "beam.toml").write_text(EXAMPLE.read_text())
    return tmp_path


def _shell(line, **environment):
    line = line.replace("squama ", f"exec {shlex.quote(sys.executable)} -m squama ", 1)
    environment = {**os.environ, **environment}
    return subprocess.run(["sh", "-c", line], check=False, capture_output=True, text=True, env=environment)


CASES = {
    "squama twist beam.toml --joint hinge --csv new.csv >&-": "standard output: is closed; redirect it",
    "squama --help >&-": "standard output: is closed",
    "squama twist beam.toml --joint hinge >/dev/full": "standard output: cannot be written (no space left on device)",
    "squama twist beam.toml --joint hinge --json >/dev/full": "standard output: cannot be written",
    "squama --version >/dev/full": "standard output: cannot be written",
    "squama twist nothing.toml 2>/dev/full": "",
    "squama twist nothing.toml 2>&-": "",
    "squama twist nothing.toml <&- >&- 2>&-": "",
    "squama twist beam.toml --joint hinge >/dev/full 2>/dev/full": "",
    "mkdir gone; cd gone; rmdir ../gone; squama twist beam.toml --joint hinge": "the working folder: is gone",
    "mkdir gone; cd gone; rmdir ../gone; squama new beam.toml": "beam.toml: cannot be written",
}


@pytest.mark.slow(but=2)
@pytest.mark.skipif(not Path("/dev/full").exists(), reason="there is no device that is full")
@pytest.mark.parametrize("line", CASES)
def test_a_stream_that_takes_nothing(line, place):
    done = _shell(line)
    assert done.returncode == 2, done.stderr
    assert not done.stdout
    assert CASES[line] in done.stderr
    assert len(done.stderr.splitlines()) == bool(CASES[line])
    assert [path.name for path in place.iterdir()] == ["beam.toml"]


@pytest.mark.slow
@pytest.mark.parametrize("columns", ["0", "nonsense"])
def test_no_environment_stops_a_command(columns, place):
    done = _shell("squama twist beam.toml --joint hinge --plot a.png", COLUMNS=columns, MPLBACKEND="nope")
    assert (done.returncode, done.stderr) == (0, "")
    assert "frictional lock" in done.stdout


@pytest.mark.parametrize(
    ("missing", "line"),
    [
        ("netgen", "verify beam.toml -o new"),
        ("ipctk", "verify beam.toml -o new --mesh 0.9,0.9"),
        ("", "verify beam.toml -o new --to 1e9rad/m"),
        ("zarr", "sweep beam.toml --over mu=0:1:3 -o new.zarr"),
        ("distributed", "sweep beam.toml --over mu=0:1:3 -o new.zarr --dask local:1"),
    ],
)
def test_what_cannot_be_done_leaves_nothing(missing, line, place, monkeypatch, capsys):
    if missing:
        pytest.importorskip(missing)
        for module in [name for name in sys.modules if name.split(".")[0] == missing]:
            monkeypatch.delitem(sys.modules, module)
        monkeypatch.setitem(sys.modules, missing, None)
    assert main(line.split()) == 2
    assert "install it with" in capsys.readouterr().err.replace("them", "it") or not missing
    assert [path.name for path in place.iterdir()] == ["beam.toml"]


@pytest.mark.slow(but=1)
@pytest.mark.parametrize("ending", ["png", "pdf", "csv", "nc", "gif", "html"])
def test_a_full_disk_keeps_the_former_file(ending, place):
    command = {"csv": "twist beam.toml --joint hinge --csv", "nc": "twist beam.toml --joint hinge --netcdf"}
    command |= {"gif": "view beam.toml --frames 2 -o", "html": "view beam.toml -o"}
    Path(f"old.{ending}").write_text("old")
    # the largest file may have 512 bytes
    done = _shell(f"ulimit -f 1; squama {command.get(ending, 'twist beam.toml --joint hinge --plot')} old.{ending}")
    assert done.returncode == 2, done.stderr
    (line,) = done.stderr.splitlines()
    assert f"old.{ending}: cannot be written (file too large)" in line
    assert Path(f"old.{ending}").read_text() == "old"
    assert sorted(path.name for path in place.iterdir()) == ["beam.toml", f"old.{ending}"]


@pytest.mark.parametrize("columns", ["0", "1", "2", "19", "20", "-5", "many", "9" * 5000])
def test_any_width_of_the_terminal(columns, place, monkeypatch, capsys):
    for line in ("--help", "twist --help", "twist beam.toml --joint hinge", "explore --help"):
        monkeypatch.setenv("COLUMNS", columns)
        assert main(line.split()) == 0
        assert capsys.readouterr().out

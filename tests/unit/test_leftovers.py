"""Temporary files of killed writers are taken away by the next write, those of living ones and other files never."""

from __future__ import annotations

import signal
import subprocess
import sys
from pathlib import Path

import pytest

from squama.io import files

pytest.importorskip("fcntl", reason="folders are locked by fcntl only")

WRITES = """
import sys, time
from squama.io import files
def writer(place):
    place.write_text("half")
    print("begun", flush=True)
    sys.stdin.read()
files.atomic_write(sys.argv[1], writer)
"""


def begun(path: Path) -> subprocess.Popen[str]:
    """Return a process that has begun to write a file and waits."""
    pipe = subprocess.PIPE
    done = subprocess.Popen([sys.executable, "-c", WRITES, str(path)], stdin=pipe, stdout=pipe, text=True)
    assert done.stdout is not None
    assert done.stdout.readline() == "begun\n"
    return done


def names(folder: Path) -> set[str]:
    return {p.name for p in folder.iterdir()}


def test_what_a_killed_writer_left_is_taken_away_by_the_next_write(tmp_path: Path) -> None:
    others = {".squama-notes", ".0123456789ab.csv", "squama-0123456789ab.csv", ".squama-0123456789ab"}
    for name in others - {".squama-0123456789ab"}:
        (tmp_path / name).write_text("mine")
    # a folder of such a name is nobody's temporary file
    (tmp_path / ".squama-0123456789ab").mkdir()
    with begun(tmp_path / "a.csv") as killed, begun(tmp_path / "b.csv") as living:
        killed.send_signal(signal.SIGKILL)
        killed.wait()
        assert len(names(tmp_path) - others) == 2
        # while one is at work nothing is taken away
        files.atomic_write(tmp_path / "c.csv", lambda place: place.write_text("whole"))
        assert len(names(tmp_path) - others) == 3
        living.communicate("")
    assert (tmp_path / "b.csv").read_text() == "half"
    assert "a.csv" not in names(tmp_path)
    files.atomic_write(tmp_path / "d.csv", lambda place: place.write_text("whole"))
    assert names(tmp_path) == {*others, "b.csv", "c.csv", "d.csv"}


def test_a_write_within_a_write_keeps_both(tmp_path: Path) -> None:
    def outer(place: Path) -> None:
        place.write_text("outer")
        files.atomic_write(tmp_path / "inner.csv", lambda inside: inside.write_text("inner"))

    files.atomic_write(tmp_path / "outer.csv", outer)
    assert {p.name: p.read_text() for p in tmp_path.iterdir()} == {"inner.csv": "inner", "outer.csv": "outer"}

"""What is said of long work: steps to a listener, lines of the log, a bar with the time left on a terminal."""

import itertools
import logging
import os
import pty
import re
import subprocess
import sys
from pathlib import Path

import pytest

import squama
from squama import progress
from squama.cli import main

BEAM = squama.Beam.from_ratios(mu=0.3)
TARGET = {"target": {"lock": "0.25 rad/pitch"}, "vary": {"scale.length": ("40 mm", "70 mm")}}
HINGED = {"joint": "hinge", "ideal": True}


def heard(call) -> dict[str, list[tuple[int, int]]]:
    found: dict[str, list[tuple[int, int]]] = {}
    with progress.told(lambda what, done, total: found.setdefault(what, []).append((done, total))):
        call()
    return found


def test_steps_are_told_from_none_to_all() -> None:
    found = heard(lambda: list(progress.steps("abc", 3, "letters")))
    assert found == {"letters": [(0, 3), (1, 3), (2, 3), (3, 3), (3, 3)]}
    # work that ends before is over too
    assert heard(lambda: next(iter(progress.steps("abc", 3, "letters"))))["letters"][-1] == (3, 3)
    assert list(progress.steps("abc", 3, "nobody listens")) == ["a", "b", "c"]


@pytest.mark.slow(but=1)
@pytest.mark.parametrize(
    ("what", "call"),
    [
        ("samples", lambda: squama.uncertainty(BEAM, {"mu": "0.3 +- 0.01"}, samples=3200, **HINGED)),
        ("frequencies", lambda: squama.shake(BEAM, [0.5, 0.6], static="0.06 rad/pitch", rotor="0.01 kg m2", **HINGED)),
        ("steps of the search", lambda: squama.inverse_design(TARGET, beam=BEAM, starts=64)),
    ],
)  # fmt: skip
def test_long_work_says_how_far_it_is(what, call) -> None:
    done, totals = zip(*heard(call)[what], strict=True)
    assert len(set(totals)) == 1
    assert done[0] == 0
    assert done[-1] == totals[0]
    assert all(a <= b for a, b in itertools.pairwise(done))
    assert len(set(done)) > 2 or what == "samples"


def test_the_log_is_for_those_who_ask(tmp_path: Path, capsys, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["new", "beam.toml"]) == 0
    capsys.readouterr()
    told = ["uncertainty", "beam.toml", "--vary", "mu=0.3 +- 0.01", "--joint", "hinge", "--samples", "3200"]
    assert main(told) == 0
    quiet = capsys.readouterr()
    assert "samples: " not in quiet.err
    assert main([*told, "--verbose"]) == 0
    loud = capsys.readouterr()
    assert loud.out == quiet.out
    assert re.search(r"^squama: samples: 4096 of 4096 steps in [\d.e-]+ s$", loud.err, re.MULTILINE)
    # nothing of it stays
    assert not progress.LOG.handlers
    assert progress.LOG.level == logging.NOTSET


CODE = """
import sys, time
from squama import progress
with progress.spoken():
    for _ in progress.steps(range(4), 4, "letters"):
        time.sleep(float(sys.argv[1]))
print("end")
"""


@pytest.mark.parametrize(("pause", "bar"), [(0.8, True), (0.01, False)])
def test_a_terminal_shows_a_bar_with_the_time_left_where_it_takes_long(pause: float, bar: bool) -> None:
    ours, theirs = pty.openpty()
    environment = {**os.environ, "TERM": "xterm", "COLUMNS": "100"}
    done = subprocess.run([sys.executable, "-c", CODE, str(pause)], check=True, stdout=subprocess.PIPE, stderr=theirs,
                          env=environment)  # fmt: skip
    os.close(theirs)
    shown = ""
    try:
        while part := os.read(ours, 4096).decode():
            shown += part
    except OSError:
        # the other end is closed
        pass
    os.close(ours)
    assert done.stdout == b"end\n"
    assert ("letters, left:" in shown) is bar
